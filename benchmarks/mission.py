"""How long a mission takes beside its calibration: one device, and forty compared.

Run `python benchmarks/mission.py`. Of one device with every process: the errors of an
hour's flight at 100 times, by source, all computed anew in this process. Of forty:
whole commands, with a mission in the requirement and without. All is time of one
processor, its own and that of the children, not by the clock, and the least of several
runs: others may use the machine.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one

import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

import budget
from budget.calibration import mission as missions
from budget.inputs import load_catalogue
from budget.navigation import growth

RUNS = 3
TIMES, HOUR = 100, 3600.0
DEVICES = 40
FLIGHT = "transport-flight"
ALL = """\
name: every process
gyro:
  errors:
    bias_stability: 0.01 deg/h
    bias_repeatability: 0.02 deg/h
    flicker: {value: 0.003 deg/h, adds_to: bias_stability}
    angle_random_walk: 0.003 deg/sqrt(h)
    rate_random_walk: 0.002 deg/h/sqrt(h)
    quantization: 0.5 arcsec
    scale_factor_repeatability: 10 ppm
    scale_factor_nonlinearity: 10 ppm
    mounting_repeatability: 5 arcsec
accelerometer:
  errors:
    bias_stability: 10 ug
    bias_repeatability: 50 ug
    flicker: {value: 3 ug, adds_to: bias_stability}
    velocity_random_walk: 10 ug/sqrt(Hz)
    acceleration_random_walk: 1 ug/sqrt(h)
    quantization: 0.1 mm/s
    scale_factor_repeatability: 50 ppm
    scale_factor_nonlinearity: 50 ppm
    mounting_repeatability: 10 arcsec
"""
WANTED = """\
name: an hour
limits:
  gyro: {bias: 0.01 deg/h}
  accelerometer: {bias: 100 ug}
"""
LED = """\
  mission: {position: {horizontal: 1 nmi, at: 1 h, probability: 50 %}}
"""


def of_one(folder: Path) -> tuple[float, float, float]:
    """Return what calibration takes, the mission at 100 times, and once more [s]."""
    device = folder / "all.yaml"
    device.write_text(ALL, encoding="utf-8")
    times = [HOUR * (place + 1) / TIMES for place in range(TIMES)]
    begun = process_time()
    budget.analyze(device, validate=False)
    calibrated = process_time()
    answer = budget.analyze(device, validate=False, mission=FLIGHT)
    for memory in (missions.growth_of, missions._of_constants, growth._spread):  # noqa: SLF001
        memory.cache_clear()
    seconds = []
    for _ in range(2):
        start = process_time()
        budget.growth(answer, times)
        seconds.append(process_time() - start)
    return calibrated - begun, *seconds


def of_many(folder: Path, requirement: str) -> float:
    """Return what comparing forty devices takes, the whole command [s]."""
    wanted = folder / "wanted.yaml"
    wanted.write_text(requirement, encoding="utf-8")
    files = []
    both = [one for one in load_catalogue() if len(one.sensors) > 1]
    for place in range(DEVICES):
        path = folder / f"device-{place:02d}.yaml"
        text = [f"name: {both[place % len(both)].name} no. {place}"]
        for sensor in both[place % len(both)].sensors:
            text += [f"{sensor.kind}:", "  errors:"]
            for line in sensor.lines:
                value = float(line.u[0]) / line.si_per_unit * (1.0 + 0.001 * place)
                text.append(f'    {line.name}: "{value:.5g} {line.unit}"')
        path.write_text("\n".join(text) + "\n", encoding="utf-8")
        files.append(str(path))
    call = [sys.executable, "-m", "budget", "compare", *files, "--method", "gum"]
    call += ["--requirement", str(wanted), "--json", str(folder / "result.json")]
    if requirement.endswith(LED):
        call += ["--mission", FLIGHT]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(call, check=False, capture_output=True, text=True)
    if not (folder / "result.json").exists():
        raise SystemExit(run.stderr)
    (folder / "result.json").unlink()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print each figure with its target."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        calibration, mission, again = (
            min(figures)
            for figures in zip(*(of_one(folder) for _ in range(RUNS)), strict=True)
        )
        plain = min(of_many(folder, WANTED) for _ in range(RUNS))
        led = min(of_many(folder, WANTED + LED) for _ in range(RUNS))
    for name, figure in (
        ("one device: its calibration, s", calibration),
        ("its flight of an hour, 100 times, all lines, s (target: 1)", mission),
        ("the same for the next device, s", again),
        ("compare 40 devices without a mission, s", plain),
        ("compare 40 devices by a mission, s", led),
        ("what the mission adds, s (target: 5)", led - plain),
    ):
        print(f"{name:62} {figure:8.3f}")


if __name__ == "__main__":
    main()
