"""Values of the first trials of a Monte Carlo run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError, ProblemError
from budget.methods.execution import BLOCK, batches, small_blocks
from budget.methods.intervals import interval_of_trials

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.problem import Problem


def first_trials(
    problem: Problem,
    *,
    trials: int,
    seed: int = 0,
    outputs: Sequence[int] | NDArray[np.intp] | None = None,
    known: Array | None = None,
) -> Array:
    """Return the values of the first trials, in their order.

    They are those that `monte_carlo.sample` gathers, bit for bit: the same streams,
    drawn in the same blocks. One process; all values are held in memory.

    Parameters
    ----------
    problem : Problem
        Any.
    trials : int
        How many, 1 or more.
    seed : int
        The same seed draws the same unit variates for every size of the sources.
    outputs : sequence of int, optional
        Places of the outputs that are wanted, in that order; all without it.
    known : ndarray, shape (n_wanted, fewer trials), optional
        What this returned for fewer: no block of it is drawn again.

    Returns
    -------
    ndarray, shape (n_wanted, trials)
        [SI units of the outputs].

    Raises
    ------
    CallError
        There are no trials to make.
    ProblemError
        The function returned a value that is not finite.
    """
    if trials < 1:
        raise CallError(f"trials is {trials}, allowed: 1 or more")
    problem = problem.pooled
    rows = np.arange(len(problem.outputs)) if outputs is None else np.asarray(outputs)
    values = np.empty((rows.size, trials))
    done = 0
    if known is not None:
        done = min(known.shape[1], trials) // BLOCK * BLOCK
        values[:, :done] = known[:, :done]
    with small_blocks():
        block, more = done // BLOCK, trials - done
        for at, y in batches(problem, seed, block=block, trials=more):
            values[:, done:][:, at] = y[rows]
    check_finite(values)
    return values


def check_finite(values: Array) -> None:
    """Refuse outputs of a model, or what was computed of them, that are not finite.

    Raises
    ------
    ProblemError
        One is not.
    """
    if not np.isfinite(values).all():
        raise ProblemError(
            "the function returned a value that is not finite; restrict its inputs, or "
            "mend it where it overflows or divides by zero"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Covered:
    """Trials against given intervals.

    Attributes
    ----------
    trials : int
    inside : ndarray, shape (n_out,)
        Part of the trials within the given interval [1].
    interval : ndarray, shape (n_out, 2)
        Coverage interval of the trials themselves, symmetric in probability [SI].
    """

    trials: int
    inside: Array
    interval: Array


def coverage_of(
    problem: Problem,
    interval: Array,
    *,
    coverage: float | Array,
    trials: int,
    seed: int,
) -> Covered:
    """Count how many trials, in whole blocks, lie within intervals of shape (n_out, 2).

    `coverage` is that of the intervals that are taken from the trials, of all or of
    each output [1]. The same seed draws the same unit variates for every size of the
    sources.
    """
    y = first_trials(problem, trials=-(-trials // BLOCK) * BLOCK, seed=seed)
    within = (y >= interval[:, :1]) & (y <= interval[:, 1:])
    wanted = np.broadcast_to(coverage, len(y)).tolist()
    return Covered(
        trials=y.shape[1],
        inside=within.mean(axis=1),
        interval=np.array(
            [
                interval_of_trials([row], each, "symmetric")
                for row, each in zip(y, wanted, strict=True)
            ]
        ),
    )
