"""Progress of long work, and an estimate of its cost before it starts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK, draw, small_blocks

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from budget.problem import Problem


Progress = Callable[[str, int, int], None]  # what is done, steps done, steps in all


def stage(progress: Progress | None, what: str) -> Callable[[int, int], None] | None:
    """Return what a method calls with steps done and in all; it need not know more."""
    return None if progress is None else partial(progress, what)


@dataclass(frozen=True, kw_only=True)
class Engine:
    """Who does the work, and how it is talked about; nothing of it changes a number."""

    workers: int = 1  # processes
    executor: Executor | None = None  # does the work in place of local processes
    # Called with what is being done, steps done and steps in all.
    progress: Progress | None = None
    # Called with a line for people before work that may take long.
    talk: Callable[[str], None] | None = None

    def stage(self, what: str) -> Callable[[int, int], None] | None:
        """Return what a method calls with steps done and in all."""
        return stage(self.progress, what)


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
