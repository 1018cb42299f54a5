"""How long `budget compare --method gum` takes for 1,000 files, and how it grows.

The files are the shipped devices with every figure moved by up to a fifth. Each number
of devices is compared by a process of its own, started as a user starts it; time and
memory are the process' own. With a checkout of another revision each is compared by
that too, one after the other, and the last column says how many times as long it
takes: on a busy machine that is the number to trust.
Run: python benchmarks/compare.py [FILES [CHECKOUT]]
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from budget.inputs import load_catalogue

ROOT = Path(__file__).resolve().parent.parent
FILES = 1000
REQUIREMENT = "catalogue-edge"
SPREAD = 0.2  # largest relative change of a figure


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What one comparison took."""

    wall: float  # [s]
    used: float  # of the processor [s]
    memory: float  # the most of this and smaller numbers [MB]


def write_devices(folder: Path, number: int, *, seed: int = 0) -> list[Path]:
    """Write device files that give the lines of the catalogue, a little changed."""
    rng = np.random.default_rng(seed)
    catalogue = load_catalogue()
    paths = []
    for place in range(number):
        device = catalogue[place % len(catalogue)]
        text = [f"name: {device.name} no. {place}"]
        if device.technology:
            text.append(f'technology: "{device.technology}"')
        for sensor in device.sensors:
            text += [f"{sensor.kind}:", "  errors:"]
            for line in sensor.lines:
                value = float(line.u[0]) / line.si_per_unit
                value *= 1.0 + SPREAD * rng.uniform(-1.0, 1.0)
                text.append(f'    {line.name}: "{value:.5g} {line.unit}"')
        path = folder / f"device-{place:04d}.yaml"
        path.write_text("\n".join(text) + "\n", encoding="utf-8")
        paths.append(path)
    return paths


def run(paths: list[Path], folder: Path, tree: Path) -> Cost:
    """Compare them in a process of one core, by the package of a checkout."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begun = time.perf_counter()
    call = [sys.executable, "-m", "budget", "compare", *map(str, paths)]
    call += ["--requirement", REQUIREMENT, "--method", "gum"]
    subprocess.run(
        [*call, "--json", str(folder / "result.json")],
        check=False,
        stdout=subprocess.DEVNULL,
        cwd=tree,
        env={
            **os.environ,
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "PYTHONPATH": os.pathsep.join([str(tree), str(tree / "examples")]),
        },
    )
    wall = time.perf_counter() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(wall=wall, used=used, memory=after.ru_maxrss / 1024)


def main() -> None:
    """Print a line for a quarter, a half and all of the files."""
    most = int(sys.argv[1]) if len(sys.argv) > 1 else FILES
    others = [Path(one).resolve() for one in sys.argv[2:3]]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        paths = write_devices(folder, most)
        print("files  wall [s]  processor [s]  memory so far [MB]  times before")
        for number in (most // 4, most // 2, most):
            cost = run(paths[:number], folder, ROOT)
            before = [run(paths[:number], folder, one).used for one in others]
            ratio = "".join(f"{one / cost.used:14.1f}" for one in before)
            print(
                f"{number:5d}{cost.wall:10.1f}{cost.used:15.1f}{cost.memory:20.0f}"
                f"{ratio}",
                flush=True,
            )


if __name__ == "__main__":
    main()
