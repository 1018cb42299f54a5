"""How long the main job takes: start, law, Monte Carlo, simulation; and its memory.

Run `python benchmarks/main_job.py`. Machines are noisy: each figure is the median of
several whole processes, and the ratio to a bare `python -c pass` of the same run.
"""

from __future__ import annotations

import os
import subprocess
import sys
from statistics import median
from time import perf_counter

RUNS = 5
BUDGET = [sys.executable, "-m", "budget"]
JOBS = (
    ("bare python", [sys.executable, "-c", "pass"]),
    ("budget --help", [*BUDGET, "--help"]),
    ("analyze, law", [*BUDGET, "analyze", "--json", "-"]),
    (
        "analyze, 1e6 Monte Carlo trials",
        [*BUDGET, "analyze", "--method", "monte-carlo", "--trials", "1000000"],
    ),
    (
        "analyze, one simulated procedure and one more",
        [*BUDGET, "analyze", "--method", "simulation", "--trials", "2"],
    ),
)


def run(command: list[str]) -> tuple[float, float]:
    """Return wall time [s] and peak memory [MB] of one process."""
    begun = perf_counter()
    process = subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    return perf_counter() - begun, usage.ru_maxrss / 1024.0


def main() -> None:
    """Print a row for every job."""
    print(f"{'job':46} {'wall s':>8} {'ratio':>7} {'peak MB':>8}")
    bare = 0.0
    for name, command in JOBS:
        times, memory = zip(*(run(command) for _ in range(RUNS)), strict=True)
        wall = median(times)
        bare = bare or wall
        print(f"{name:46} {wall:8.3f} {wall / bare:7.1f} {max(memory):8.0f}")


if __name__ == "__main__":
    main()
