"""Cost of long work, estimated before it starts."""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK, draw, small_blocks

if TYPE_CHECKING:
    from budget.problem import Problem


# Moments, sorting and gathering take about as long again as evaluating the model.
GATHERING = 1.3  # [1]


def seconds_per_trial(problem: Problem) -> float:
    """Time a block of trials, drawn and evaluated, on this machine: best of three."""
    x = np.empty((problem.n_inputs, BLOCK))
    times = []
    with small_blocks():
        for block in range(3):
            begun = perf_counter()
            problem.evaluate(draw(problem, 0, block, x))
            times.append(perf_counter() - begun)
    return GATHERING * min(times) / BLOCK


def describe_cost(what: str, number: int, seconds: float, workers: int) -> str:
    """Return one line: what is done how often, and about how long it takes."""
    each = f" on {workers} workers" if workers > 1 else ""
    count = f"{number:,}".replace(",", " ")
    return f"{what}: {count} model evaluations, about {seconds / workers:.0f} s{each}"
