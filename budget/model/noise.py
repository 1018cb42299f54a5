"""Noise processes as the covariance of their averages over windows, in closed form.

For windows with starts s and lengths L, a before b, gap = s_b - s_a - L_a. A sum or
difference of such averages is exactly Gaussian with the covariance given here, so
nothing has to be sampled in time.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import factorial
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array
    from budget.model.windows import Schedule

SERIES_TERMS = 20  # of the exponential series; the last one is 1/21! at x = 1


class Process(Protocol):
    """A zero-mean Gaussian process, seen through window averages."""

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages.

        Parameters
        ----------
        schedule : Schedule
            The n windows.
        weights : ndarray, shape (k, n)
            One linear combination of the window averages in each row [1].

        Returns
        -------
        ndarray, shape (k, k)
            W C W^T with C the covariance of the averages [SI squared].
        """
        ...


@dataclass(frozen=True)
class White:
    """White noise of one density: angle or velocity random walk."""

    density: float  # N [SI unit times sqrt(s)]

    def covariance(self, schedule: Schedule) -> Array:
        """Return diag(N^2 / L), shape (n, n) [SI squared]."""
        return np.diag(self.density**2 / schedule.lengths)

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process."""
        return np.asarray(weights @ self.covariance(schedule) @ weights.T)


@dataclass(frozen=True)
class RandomWalk:
    """Integrated white noise that is 0 at t = 0: rate or acceleration random walk."""

    density: float  # K [SI unit over sqrt(s)]

    def covariance(self, schedule: Schedule) -> Array:
        """Return the covariance of the averages, shape (n, n) [SI squared].

        K^2 (s + L/3) on the diagonal, K^2 (s_a + L_a/2) for a before b: the integral
        of min(t, t') over both windows.
        """
        starts, lengths = schedule.starts, schedule.lengths
        before = starts + lengths / 2.0
        C = np.minimum(before[:, None], before[None, :])
        np.fill_diagonal(C, starts + lengths / 3.0)
        return self.density**2 * C

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process."""
        return np.asarray(weights @ self.covariance(schedule) @ weights.T)


@dataclass(frozen=True)
class GaussMarkov:
    """First-order Gauss-Markov process, stationary: bias stability, Zhao 2019, 2.1.1.

    Its autocovariance is sigma^2 exp(-|t|/tau).
    """

    sigma: float  # [SI]
    correlation_time: float  # tau [s]

    def covariance(self, schedule: Schedule) -> Array:
        """Return the covariance of the averages, shape (n, n) [SI squared].

        2 sigma^2 (tau/L)^2 (L/tau - 1 + e^(-L/tau)) on the diagonal, sigma^2
        tau^2/(L_a L_b) e^(-gap/tau) (1 - e^(-L_a/tau)) (1 - e^(-L_b/tau)) beside it.
        """
        return self.sigma**2 * _correlation(schedule, self.correlation_time).whole

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process.

        A process much slower than its windows is nearly a constant, which cancels in
        every difference of them. For rows whose windows are all shorter than tau the
        constant part is therefore taken out before the matrices are multiplied: its
        weight is the sum of a row, exactly 0 for a difference.
        """
        tau = self.correlation_time
        constant = weights.sum(axis=1)
        shape = _correlation(schedule, tau)
        rest = weights @ shape.without_constant @ weights.T
        whole = weights @ shape.whole @ weights.T
        slow = tau > np.where(weights != 0.0, schedule.lengths, 0.0).max(axis=1)
        C = np.where(
            slow[:, None] & slow[None, :], np.outer(constant, constant) + rest, whole
        )
        return np.asarray(self.sigma**2 * C)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Correlation:
    """Covariance of window averages over sigma^2, shape (n, n), to rounding."""

    whole: Array  # [1]
    without_constant: Array  # minus 1: what is left of a process that is nearly one


@lru_cache(maxsize=256)
def _correlation(schedule: Schedule, tau: float) -> _Correlation:
    """Return the covariance over sigma^2, with and without its constant part.

    Kept: axes and devices mostly share their schedule and their correlation time.
    """
    starts, lengths = schedule.starts, schedule.lengths
    ends, x = starts + lengths, lengths / tau
    later_start = np.maximum(starts[:, None], starts[None, :])
    earlier_end = np.minimum(ends[:, None], ends[None, :])
    gap = np.maximum(later_start - earlier_end, 0.0) / tau
    log_mean = _log_mean_exponential(x)
    exponent = log_mean[:, None] + log_mean[None, :] - gap
    whole: Array = np.exp(exponent)
    rest: Array = np.expm1(exponent)
    # On the diagonal 2 (x - 1 + e^(-x)) / x^2.
    small, large = np.minimum(x, 1.0), np.maximum(x, 1.0)
    series = sum(
        2.0 * (-small) ** k / factorial(k + 2) for k in range(SERIES_TERMS, 0, -1)
    )  # minus 1
    closed = 2.0 / large * (1.0 + np.expm1(-large) / large)
    np.fill_diagonal(whole, np.where(x < 1.0, series + 1.0, closed))
    np.fill_diagonal(rest, np.where(x < 1.0, series, closed - 1.0))
    for one in (whole, rest):
        one.flags.writeable = False
    return _Correlation(whole=whole, without_constant=rest)


def stationary(
    starts: Array,
    lengths: Array,
    integrals: tuple[Callable[[Array], Array], ...],
) -> tuple[Array, ...]:
    """Return covariances of a stationary process over windows that may overlap.

    With S_F the second difference of F over the edges, F(e_b - e_a) - F(e_b - s_a) -
    F(s_b - e_a) + F(s_b - s_a), over L_a L_b: -S_G of means, S_H of a mean rate of
    change with a mean, S_R of two such rates, R = H' = G'' the autocovariance.

    Parameters
    ----------
    starts, lengths : ndarray, shape (n,)
        [s].
    integrals : tuple of functions
        G, H and R, or as many of them as are asked for.

    Returns
    -------
    tuple of ndarray, shape (n, n)
        One for each function.
    """
    ends = starts + lengths

    def difference(F: Callable[[Array], Array]) -> Array:
        parts = (
            F(b[None] - a[:, None]) for a in (ends, starts) for b in (ends, starts)
        )
        ee, es, se, ss = parts  # the edge of a, then that of b
        return (ee - es - se + ss) / np.outer(lengths, lengths)

    signs = (-1.0, 1.0, 1.0)
    return tuple(
        sign * difference(F) for sign, F in zip(signs, integrals, strict=False)
    )


def _log_mean_exponential(x: Array) -> Array:
    """Return log((1 - e^(-x)) / x), to rounding for x from 0 up."""
    small = np.minimum(x, 1.0)
    series = sum(
        (-small) ** k / factorial(k + 1) for k in range(SERIES_TERMS, 0, -1)
    )  # (1 - e^(-x))/x - 1
    large = np.maximum(x, 1.0)
    logarithm = np.log(-np.expm1(-large) / large)
    return np.asarray(np.where(x < 1.0, np.log1p(series), logarithm))
