"""Validation of the law against Monte Carlo: JCGM 101:2008, clause 8."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.methods.intervals import numerical_tolerance
from budget.methods.monte_carlo import sample
from budget.results import Validation

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from budget.methods.gum import Propagation
    from budget.problem import Problem

MAX_TRIALS = 250_000  # about what one digit takes for a normal output
# Monte Carlo settles to a fifth of the tolerance that is judged with (8.2, note 3).
PART = 0.2


def validate(
    problem: Problem,
    law: Propagation,
    *,
    coverage: float = 0.95,
    digits: int = 1,
    max_trials: int = MAX_TRIALS,
    seed: int = 0,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Validation, ...]:
    """Compare the ends of the law's intervals with Monte Carlo ones, output by output.

    d_low = |y - U - y_low|, d_high = |y + U - y_high| (8.1); the law holds where both
    are within the numerical tolerance of the standard uncertainty to so many digits,
    the smaller one of both methods, and Monte Carlo itself has settled to that. An
    output without spread holds trivially. All else as of monte_carlo.sample.
    """
    drawn = sample(
        problem,
        digits=digits,
        part=PART,
        max_trials=max_trials,
        coverage=coverage,
        seed=seed,
        workers=workers,
        executor=executor,
        progress=progress,
    )
    # A heavy tail blows up the standard uncertainty of trials, and with it a tolerance
    # taken from it: a law that is far off would then hold.
    u = np.minimum(drawn.standard_uncertainty, law.standard_uncertainty)
    tolerance = numerical_tolerance(u, problem.outputs, digits)
    reached = np.full(u.shape, np.inf) if drawn.reached is None else drawn.reached
    difference = np.abs(law.interval(coverage) - drawn.interval)
    # Constants agree to the rounding of the computation, whatever their tolerance.
    resolution = np.array([output.resolution for output in problem.outputs])
    still = drawn.standard_uncertainty <= resolution
    agree = (difference <= tolerance[:, None]).all(axis=1) & (reached <= tolerance)
    holds = agree | (still & (law.standard_uncertainty <= resolution))
    return tuple(
        Validation(
            trials=drawn.trials,
            holds=bool(holds[k]),
            difference_low=float(difference[k, 0]),
            difference_high=float(difference[k, 1]),
            tolerance=float(tolerance[k]),
            reached=float(reached[k]),
            interval=(float(drawn.interval[k, 0]), float(drawn.interval[k, 1])),
        )
        for k in range(len(problem.outputs))
    )
