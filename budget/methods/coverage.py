"""How often an output really lies in an interval that the law gives: by trials."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.methods.execution import BLOCK
from budget.methods.intervals import interval_of_values
from budget.methods.trials import first_trials

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Problem


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
    problem: Problem, interval: Array, *, coverage: float, trials: int, seed: int
) -> Covered:
    """Count how many trials lie within intervals.

    Parameters
    ----------
    problem : Problem
        Any.
    interval : ndarray, shape (n_out, 2)
        Of each output [SI].
    coverage : float
        Of the interval that is taken from the trials [1].
    trials : int
        Rounded up to whole blocks.
    seed : int
        The same seed draws the same unit variates for every size of the sources.

    Returns
    -------
    Covered
    """
    whole = -(-trials // BLOCK) * BLOCK
    y = first_trials(problem, trials=whole, seed=seed)
    within = (y >= interval[:, :1]) & (y <= interval[:, 1:])
    y.sort(axis=1)
    return Covered(
        trials=y.shape[1],
        inside=within.mean(axis=1),
        interval=interval_of_values(y, coverage, "symmetric"),
    )
