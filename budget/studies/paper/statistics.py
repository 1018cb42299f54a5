"""How well printed random numbers fit what one run, or a mean over runs, should be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtr, chdtrc, erfc, ndtr

from budget.methods.execution import BLOCK, draw

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.problem import Problem
    from budget.studies.paper.conditions import Expectation

LEVEL = 0.01  # a reading is said to fit from this p on [1]
BLOCKS = 10  # of trials drawn for repeats of a mean


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Printed entries against an expectation.

    Attributes
    ----------
    chi_square : float
        Deviations squared in the metric of their joint covariance [1].
    entries : int
        Its degrees of freedom.
    p : float
        Two-sided: twice the smaller tail; too good a fit counts as well. Where the
        scatter about a common shift was tested too, twice the smaller of both p [1].
    p_entries : ndarray
        Two-sided normal p of each entry by itself [1].
    u_rms : float
        Root mean square of the standard uncertainties [1].
    """

    chi_square: float
    entries: int
    p: float
    p_entries: Array
    u_rms: float

    @property
    def fits(self) -> bool:
        """Whether the entries may well be such."""
        return self.p >= LEVEL


def fit(
    printed: Array,
    expectation: Expectation,
    places: slice | NDArray[np.bool_],
    *,
    runs: int,
    scatter: bool = True,
) -> Fit:
    """Hold printed entries against the mean over `runs` runs (1: a single run).

    Parameters
    ----------
    printed : ndarray, shape (12,)
        Relative errors [1].
    expectation : Expectation
        Of one run; all entries at `places` must vary.
    places : slice or ndarray of bool
        Which of the twelve.
    runs : int
        Number of runs averaged.
    scatter : bool
        Whether the scatter about a common shift is tested too: six entries near -1
        have the sum of squares of six draws with u = 1, but not their scatter.

    Returns
    -------
    Fit
    """
    deviation = (printed - expectation.mean)[places]
    C = expectation.covariance[places][:, places] / runs
    u = np.sqrt(np.diag(C))
    # Scaled first: scale factors and angles differ by a factor of 1e5.
    z = deviation / u
    one = np.ones_like(z)
    weighted = np.linalg.solve(C / np.outer(u, u), np.stack([z, one], axis=1))
    chi_square = float(z @ weighted[:, 0])
    p = two_sided(chi_square, z.size)
    if scatter:
        about = chi_square - float(one @ weighted[:, 0]) ** 2 / float(
            one @ weighted[:, 1]
        )
        p = min(1.0, 2.0 * min(p, two_sided(about, z.size - 1)))
    return Fit(
        chi_square=chi_square,
        entries=z.size,
        p=p,
        p_entries=erfc(np.abs(z) / np.sqrt(2.0)),
        u_rms=float(np.sqrt(np.mean(u**2))),
    )


def two_sided(chi_square: float, entries: int) -> float:
    """Return twice the smaller tail of chi-square: too good counts as well [1]."""
    tails = chdtr(entries, chi_square), chdtrc(entries, chi_square)
    return float(min(1.0, 2.0 * min(tails)))


def order_probability(
    order: str, expectation: Expectation, places: slice, *, runs: int
) -> float:
    """Return the probability that the largest entry has that power of ten [1].

    10^k <= max |entry| < 10^(k+1): so the paper's text reads its own Table 1. Entries
    are taken as independent; their correlations are 0.2 at the most.
    """
    mean, u = expectation.mean[places], expectation.u[places] / np.sqrt(runs)

    def below(bound: float) -> float:
        inside = ndtr((bound - mean) / u) - ndtr((-bound - mean) / u)
        return float(np.prod(inside))

    return below(10.0 * float(order)) - below(float(order))


def spread_of_means(problem: Problem, *, runs: int, seed: int = 0) -> Array:
    """Draw means over `runs` runs again and again, and return their spread.

    Parameters
    ----------
    problem : Problem
        Of one triad.
    runs : int
        Runs in a mean.
    seed : int
        Same seed, same numbers.

    Returns
    -------
    ndarray, shape (12,)
        Standard deviation of `repeats(runs)` means [SI].
    """
    x = np.empty((problem.n_inputs, BLOCK))
    each = BLOCK // runs
    means = []
    for block in range(BLOCKS):
        y = problem.evaluate(draw(problem, seed, block, x))[:, : each * runs]
        means.append(y.reshape(len(problem.outputs), each, runs).mean(axis=2))
    return np.asarray(np.concatenate(means, axis=1).std(axis=1, ddof=1))


def repeats(runs: int) -> int:
    """Return how many means `spread_of_means` draws."""
    return BLOCKS * (BLOCK // runs)
