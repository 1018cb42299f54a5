"""How much memory the largest files take: windows, weights, rows of a trajectory.

Run `python benchmarks/memory.py`; some minutes. Each is a command of its own, and what
is printed is the most that it held (ru_maxrss of wait4). Measured on two cores, before
and after arrays of all windows by all windows, and of all steps, were given up:

    least squares, 3,000 windows     503 MB    143 MB
    least squares, 9,000 windows   > 5 GB      269 MB
    weighted, 1,000 windows          788 MB    233 MB
    trajectory, 50,000 noisy rows  1,521 MB    356 MB
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

TARGET = 700e6  # [byte]
PROCEDURE = """\
name: repeated
latitude: 34 deg
gravity: normal
sample_rate: 100 Hz
estimator: {estimator}
windows:
  - repeat: {repeat}
    windows:
      - {{face: all, dwell: 10 s}}
      - {{face: z up, turn: vertical, turns: 1, rate: 36 deg/s}}
      - {{face: x up, turn: vertical, turns: 1, rate: 36 deg/s}}
      - {{face: y up, turn: vertical, turns: 1, rate: 36 deg/s}}
"""
WINDOWS = 9  # of each repetition
MISSION = """\
name: flown
environment: none
mission:
  {trajectory: flown.csv, alignment: perfect, altitude: aided, at: [10 min, 4990 s]}
"""
HEADER = "time [s],latitude [deg],longitude [deg],height [m],heading [deg]"
ROWS = 50_000


def write(folder: Path) -> dict[str, tuple[str, ...]]:
    """Write the files, and return the command of each."""
    commands = {}
    for estimator, windows in (
        ("least_squares", 3000),
        ("least_squares", 9000),
        ("weighted", 1000),
    ):
        name = f"{estimator}-{windows}.yaml"
        text = PROCEDURE.format(estimator=estimator, repeat=windows // WINDOWS)
        (folder / name).write_text(text, encoding="utf-8")
        commands[name] = ("analyze", "--no-validate", "--procedure", name)
    rng = np.random.default_rng(1)
    t = 0.1 * np.arange(ROWS)
    latitude = 45.0 + 3e-6 * t + 5e-7 * rng.standard_normal(ROWS)
    height = 100.0 + 0.01 * t + 0.3 * rng.standard_normal(ROWS)
    columns = (t, latitude, 10.0 + 2e-6 * t, height, 10.0 + 5.0 * np.sin(t / 60.0))
    np.savetxt(
        folder / "flown.csv",
        np.column_stack(columns),
        fmt="%.9f",
        delimiter=",",
        header=HEADER,
        comments="",
    )
    (folder / "flown.yaml").write_text(MISSION, encoding="utf-8")
    commands["flown.yaml"] = ("mission", "--no-validate", "--mission", "flown.yaml")
    return commands


def peak(command: tuple[str, ...], folder: Path) -> float:
    """Return the most memory that a command holds [byte]."""
    child = subprocess.Popen(
        (sys.executable, "-m", "budget", *command),
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{' '.join(command)}: exit code {child.returncode}")
    return 1024.0 * usage.ru_maxrss


def main() -> None:
    """Print what each file takes."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        for file, command in write(folder).items():
            found = peak(command, folder)
            said = "" if found < TARGET else "  above the target"
            print(f"{file:24} {found / 1e6:6.0f} MB{said}", flush=True)


if __name__ == "__main__":
    main()
