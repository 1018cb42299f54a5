"""Sobol' indices of the built-in device: ours against SALib's sample and analyze.

Run `python benchmarks/sobol.py`. Both take the same points of one scramble through the
same model; SALib's pipeline analyses one output after another, with its bootstrap. Ours
then does eight scrambles. Also printed: what the control variate gains.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from SALib.analyze import sobol as analyze
from SALib.sample import sobol as sample

from budget.calibration.problem import calibration_problem
from budget.inputs import load_device, load_procedure
from budget.methods.sobol import sobol

if TYPE_CHECKING:
    from budget.problem import Problem

SAMPLES = 8192


def by_salib(problem: Problem) -> float:
    """Return seconds of SALib's own pipeline for one scramble, all outputs."""
    inputs = problem.n_inputs
    spec = {
        "num_vars": inputs,
        "names": [f"x{i}" for i in range(inputs)],
        "groups": [g.name for g in problem.groups for _ in range(g.size)],
        "bounds": [[0.0, 1.0]] * inputs,
    }
    begun = perf_counter()
    points = sample.sample(spec, SAMPLES, calc_second_order=False, seed=1).T
    x = np.clip(points, 2.0**-40, 1.0 - 2.0**-40)
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        x[rows] = group.factor @ group.distributions[0].quantile(x[rows])
    for row in problem.evaluate(x):
        # SALib takes the variances of biases for zero, so they are scaled first.
        analyze.analyze(spec, row / row.std(), calc_second_order=False)
    return perf_counter() - begun


def widest(problem: Problem, *, control_variate: bool) -> tuple[float, float]:
    """Return seconds of eight scrambles and the widest interval of all indices."""
    begun = perf_counter()
    found = sobol(problem, samples=SAMPLES, control_variate=control_variate)
    seconds = perf_counter() - begun
    spans = [kind.high - kind.low for kind in (found.first, found.total)]
    return seconds, float(np.nanmax(spans))


def main() -> None:
    """Print times, their ratio a scramble, and the widths of the intervals."""
    problem = calibration_problem(
        load_device("zhao-2019").sensors, load_procedure(None)
    )
    salib = by_salib(problem)
    ours, width = widest(problem, control_variate=True)
    plain, plain_width = widest(problem, control_variate=False)
    for name, figure in (
        ("SALib, one scramble of 8192, s", salib),
        ("ours, eight scrambles of 8192, s (target: 5)", ours),
        ("ours over SALib, a scramble (target: 0.05)", ours / 8.0 / salib),
        ("without control variate, eight scrambles, s", plain),
        ("widest interval with control variate", width),
        ("widest interval without", plain_width),
    ):
        print(f"{name:50} {figure:12.4g}")


if __name__ == "__main__":
    main()
