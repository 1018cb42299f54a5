"""Monte Carlo against its floor: the time that drawing the same normals alone takes.

Run `python benchmarks/throughput.py`. Draws, trials and simulation alternate in one
process on one core, so that the ratios hold where the machine's speed drifts.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one

from statistics import median
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.inputs import load_device, load_procedure
from budget.methods.execution import BLOCK
from budget.methods.monte_carlo import sample

if TYPE_CHECKING:
    from budget.problem import Problem

TRIALS = 1_000_000
ROUNDS = 5


def floor(problem: Problem) -> float:
    """Return seconds to draw the normals of TRIALS trials, in blocks, and no more."""
    rng = np.random.Generator(np.random.SFC64(1))
    block = np.empty((problem.normals_per_trial, BLOCK))
    begun = perf_counter()
    for _ in range(TRIALS // BLOCK):
        rng.standard_normal(out=block)
    return (perf_counter() - begun) * TRIALS / (TRIALS // BLOCK * BLOCK)


def trials(problem: Problem, number: int | None) -> tuple[float, int]:
    """Return seconds and number of trials of a whole run, intervals included."""
    begun = perf_counter()
    made = sample(problem, trials=number, digits=2).trials
    return perf_counter() - begun, made


def main() -> None:
    """Print trials a second, the floor, and the ratios."""
    device, procedure = load_device("zhao-2019"), load_procedure(None)
    problem = calibration_problem(device.sensors, procedure)
    simulate(device.sensors, procedure, run=0)  # imports scipy.signal
    rows = []
    for run in range(1, ROUNDS + 1):
        bare = floor(problem)
        fixed, _ = trials(problem, TRIALS)
        adaptive, made = trials(problem, None)
        begun = perf_counter()
        simulate(device.sensors, procedure, run=run)
        simulated = perf_counter() - begun
        rows.append(
            (
                TRIALS / fixed,
                bare / TRIALS * 1e6,
                fixed / bare,
                adaptive / made * TRIALS / bare,
                simulated / (fixed / TRIALS),
            )
        )
    figures = [median(column) for column in zip(*rows, strict=True)]
    names = (
        "trials a second, all outputs with intervals and covariance",
        f"floor: {problem.normals_per_trial} normals, us a trial",
        "ratio to the floor, fixed number of trials (target: 1.5)",
        "ratio to the floor, adaptive to two digits",
        "ratio to the simulation, a trial (target: 10 000)",
    )
    for name, figure in zip(names, figures, strict=True):
        print(f"{name:60} {figure:14.4g}")


if __name__ == "__main__":
    main()
