"""Noise processes as the covariance of their averages over windows, in closed form.

For windows with starts s and lengths L, a before b, gap = s_b - s_a - L_a. A sum or
difference of such averages is exactly Gaussian with the covariance given here, so
nothing has to be sampled in time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from math import factorial
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array
    from budget.model.windows import Schedule

SAME_EDGE = 1e-9  # part of a window that edges of two may be apart by rounding [1]
SERIES_TERMS = 20  # of the exponential series; the last one is 1/21! at x = 1
# Windows whose rows of a covariance are made at a time: what of it is held grows with
# the windows, not with their square. Tests of no more are made whole, and kept.
ROWS = 128


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

    def covariance(self, schedule: Schedule) -> Array:
        """Return the covariance C of the averages, shape (n, n) [SI squared]."""
        ...


class _InRows(ABC):
    """A process whose covariance is made of some of its rows at a time."""

    @abstractmethod
    def rows(self, schedule: Schedule, own: slice) -> Array:
        """Return some rows of the covariance, shape (m, n) [SI squared]."""

    def covariance(self, schedule: Schedule) -> Array:
        """Return the covariance of the averages, shape (n, n) [SI squared]."""
        C = self.rows(schedule, slice(0, len(schedule.windows)))
        return np.asarray(0.5 * (C + C.T))

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process."""
        C = weighed(weights, lambda own: self.rows(schedule, own)) @ weights.T
        return np.asarray(0.5 * (C + C.T))


def weighed(weights: Array, rows: Callable[[slice], Array]) -> Array:
    """Return W C, shape (k, n), of W (k, n) and C (n, n), which is never whole.

    `rows` returns ROWS rows of C at the most, shape (m, n).
    """
    n = weights.shape[1]
    parts = (slice(k, min(k + ROWS, n)) for k in range(0, n, ROWS))
    return np.asarray(sum(weights[:, own] @ rows(own) for own in parts))


def _put_diagonal(rows: Array, own: slice, values: Array) -> None:
    """Put what stands on the diagonal of a matrix into some of its rows, (m, n)."""
    np.fill_diagonal(rows[:, own], values[own])


@dataclass(frozen=True)
class White:
    """White noise of one density: angle or velocity random walk."""

    density: float  # N [SI unit times sqrt(s)]

    def covariance(self, schedule: Schedule) -> Array:
        """Return diag(N^2 / L), shape (n, n) [SI squared]."""
        return np.diag(self.density**2 / schedule.lengths)

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process."""
        return np.asarray(weights * (self.density**2 / schedule.lengths) @ weights.T)


@dataclass(frozen=True)
class RandomWalk(_InRows):
    """Integrated white noise that is 0 at t = 0: rate or acceleration random walk."""

    density: float  # K [SI unit over sqrt(s)]

    def rows(self, schedule: Schedule, own: slice) -> Array:
        """Return some rows of the covariance, shape (m, n) [SI squared].

        K^2 (s + L/3) on the diagonal, K^2 (s_a + L_a/2) for a before b: the integral
        of min(t, t') over both windows.
        """
        starts, lengths = schedule.starts, schedule.lengths
        before = starts + lengths / 2.0
        C = np.minimum(before[own, None], before[None, :])
        _put_diagonal(C, own, starts + lengths / 3.0)
        return self.density**2 * C


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
        n = len(schedule.windows)
        shape = _correlation(schedule, self.correlation_time, 0, n)
        return self.sigma**2 * shape.whole

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process.

        A process much slower than its windows is nearly a constant, which cancels in
        every difference of them. For rows whose windows are all shorter than tau the
        constant part is therefore taken out before the matrices are multiplied: its
        weight is the sum of a row, exactly 0 for a difference.
        """
        tau = self.correlation_time
        constant = weights.sum(axis=1)
        correlation = _correlation if weights.shape[1] > ROWS else _kept_correlation

        def rows(own: slice) -> Array:
            made = correlation(schedule, tau, own.start, own.stop)
            return np.hstack([made.whole, made.without_constant])

        both = weighed(weights, rows).reshape(len(weights), 2, -1) @ weights.T
        whole, rest = both[:, 0], both[:, 1]
        slow = tau > np.where(weights != 0.0, schedule.lengths, 0.0).max(axis=1)
        C = np.where(
            slow[:, None] & slow[None, :], np.outer(constant, constant) + rest, whole
        )
        return np.asarray(self.sigma**2 * C)


@dataclass(frozen=True)
class Quantized(_InRows):
    """Rounding of an increment, by at most half a step: IEEE 952, quantisation noise.

    What is left over at the end of a window is counted in the one that follows it.
    """

    step: float  # q, of the integral of the unit [SI unit times s]

    def rows(self, schedule: Schedule, own: slice) -> Array:
        """Return some rows of the covariance, shape (m, n) [SI squared].

        Each edge is off by q^2/12: q^2/(6 L^2) on the diagonal, -q^2/(12 L_a L_b) for
        windows that share one.
        """
        starts, lengths = schedule.starts, schedule.lengths
        ends = starts + lengths
        apart = np.minimum(
            np.abs(starts - ends[own, None]), np.abs(starts[own, None] - ends)
        )
        shared = -1.0 * (apart <= SAME_EDGE * lengths.max())
        _put_diagonal(shared, own, np.full(ends.shape, 2.0))
        L2 = np.outer(lengths[own], lengths)
        return np.asarray(self.step**2 / 12.0 * shared / L2)


FAR = 1e4  # where the next term of the series of Ci is below rounding [1]


@dataclass(frozen=True)
class Flicker(_InRows):
    """Flicker noise: two-sided density B^2/(2 pi |f|) above a low cut, IEEE 952."""

    coefficient: float  # B [SI]
    low_cut: float  # f_L [Hz]

    def rows(self, schedule: Schedule, own: slice) -> Array:
        """Return some rows of the covariance, shape (m, n) [SI squared]."""
        (C,) = stationary(schedule.starts, schedule.lengths, (self._integral,), own)
        return C

    def _integral(self, t: Array) -> Array:
        """Return G, whose second derivative is the autocovariance [SI squared, s^2].

        With a = 2 pi f_L and x = a |t|: -(B^2/(pi a^2)) [(x^2/2) Ci(x) - (x/2) sin x -
        (1 - cos x)/2].
        """
        from scipy.special import sici

        a = 2.0 * np.pi * self.low_cut
        x = a * np.abs(t)
        cosine = sici(np.where(x > 0.0, x, 1.0))[1]
        inner = 0.5 * x**2 * cosine - 0.5 * x * np.sin(x) - np.sin(0.5 * x) ** 2
        # Far out its first terms cancel; what is left of the asymptotic series of Ci:
        y = np.maximum(x, FAR)
        far = -0.5 - np.sin(y) / y + 3.0 * np.cos(y) / y**2 + 12.0 * np.sin(y) / y**3
        inner = np.where(x < FAR, inner, far)
        return np.asarray(-(self.coefficient**2) / (np.pi * a**2) * inner)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Correlation:
    """Rows of the covariance of window averages over sigma^2, (m, n), to rounding."""

    whole: Array  # [1]
    without_constant: Array  # minus 1: what is left of a process that is nearly one


def _correlation(schedule: Schedule, tau: float, first: int, last: int) -> _Correlation:
    """Return rows of the covariance over sigma^2, with and without its constant."""
    own = slice(first, last)
    starts, lengths = schedule.starts, schedule.lengths
    ends, x = starts + lengths, lengths / tau
    later_start = np.maximum(starts[own, None], starts[None, :])
    earlier_end = np.minimum(ends[own, None], ends[None, :])
    gap = np.maximum(later_start - earlier_end, 0.0) / tau
    log_mean = _log_mean_exponential(x)
    exponent = log_mean[own, None] + log_mean[None, :] - gap
    whole: Array = np.exp(exponent)
    rest: Array = np.expm1(exponent)
    # On the diagonal 2 (x - 1 + e^(-x)) / x^2.
    small, large = np.minimum(x, 1.0), np.maximum(x, 1.0)
    series = sum(
        2.0 * (-small) ** k / factorial(k + 2) for k in range(SERIES_TERMS, 0, -1)
    )  # minus 1
    closed = 2.0 / large * (1.0 + np.expm1(-large) / large)
    _put_diagonal(whole, own, np.where(x < 1.0, series + 1.0, closed))
    _put_diagonal(rest, own, np.where(x < 1.0, series, closed - 1.0))
    for one in (whole, rest):
        one.flags.writeable = False
    return _Correlation(whole=whole, without_constant=rest)


# Of tests that are made whole: axes and devices mostly share their schedule and tau.
_kept_correlation = lru_cache(maxsize=256)(_correlation)


def stationary(
    starts: Array,
    lengths: Array,
    integrals: tuple[Callable[[Array], Array], ...],
    own: slice,
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
    own : slice
        The m windows whose rows are asked for.

    Returns
    -------
    tuple of ndarray, shape (m, n)
        One for each function.
    """
    ends = starts + lengths

    def difference(F: Callable[[Array], Array]) -> Array:
        parts = (
            F(b[None] - a[own, None]) for a in (ends, starts) for b in (ends, starts)
        )
        ee, es, se, ss = parts  # the edge of a, then that of b
        return (ee - es - se + ss) / np.outer(lengths[own], lengths)

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
