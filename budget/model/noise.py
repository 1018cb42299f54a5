"""Noise processes as the covariance of their averages over windows, in closed form.

For windows with starts s and lengths L, a before b, gap = s_b - s_a - L_a. A sum or
difference of such averages is exactly Gaussian with the covariance given here, so
nothing has to be sampled in time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import lru_cache
from math import ceil, factorial, log, pi, sqrt
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.windows import Schedule

SAME_EDGE = 1e-9  # part of a window that edges of two may be apart by rounding [1]
SERIES_TERMS = 20  # of the exponential series; the last one is 1/21! at x = 1
# Windows whose rows of a covariance are made at a time: what of it is held grows with
# the windows, not with their square. Tests of no more are made whole, and kept.
ROWS = 128
MOST_KINDS = 128  # of windows that count alike, pairs of which are taken together
SUMS = 64  # roundings that a start may be off by, the sum of thousands of lengths [1]
ALIKE = 12  # digits to which weights of windows are equal, of the largest
RATIO = 10.0 ** (1.0 / 3.0)  # of the correlation times that make up flicker [1]
FASTEST = 1.0  # of them: what is faster is gone in the mean [s]


@dataclass(frozen=True)
class InRun:
    """A process as navigation meets it.

    Attributes
    ----------
    kind : str
        'white'; 'walk', from 0 at the turn-on; 'markov', a sum of stationary
        first-order Gauss-Markov processes, each of variance u^2; 'rounding' of the
        integral to steps of u.
    u : float
        Density, sigma or step [SI].
    times : tuple of float
        Correlation times; of a rounding the period of its samples [s].
    """

    kind: str
    u: float
    times: tuple[float, ...] = ()


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

    def in_run(self, sample_rate: float) -> InRun:
        """Return it as navigation meets it, of samples at a rate [Hz]."""
        ...


def of_size_1(process: Process) -> tuple[float, Process]:
    """Return the size of a process, the first thing it is given, and it at size 1 SI.

    Its covariance is that of size 1 times the square of the size. Of a process of
    another package nobody knows which attribute is its size: it is as it is, of size 1.
    """
    if type(process).__module__ != __name__:
        return 1.0, process
    size, *more = vars(process).values()
    made: Callable[..., Process] = type(process)
    return size, made(1.0, *more)


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

    def in_run(self, sample_rate: float) -> InRun:  # noqa: ARG002
        """Return white noise of the same density."""
        return InRun("white", self.density)


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

    def in_run(self, sample_rate: float) -> InRun:  # noqa: ARG002
        """Return a walk of the same density, from the turn-on."""
        return InRun("walk", self.density)


class _Stationary(_InRows):
    """A process of which two windows know no more than how far they are apart.

    Thousands of windows are repetitions. With V the weights of the kinds of windows
    that are of one length and count alike, W C W^T = V S V^T, S the sums of C over all
    windows of two kinds: each lag between these is one element of C, which counts as
    often as it occurs. Tests of few windows, or of many kinds, are multiplied out.
    """

    @abstractmethod
    def between(self, a: _Span, b: _Span) -> Array:
        """Return covariances of windows of any shape, (1, ...), or p parts (p, ...)."""

    def alone(self, lengths: Array) -> Array:
        """Return variances of windows, shape (p, n)."""
        own = 0.0 * lengths, lengths
        return self.between(own, own)

    def rows(self, schedule: Schedule, own: slice) -> Array:
        """Return some rows of the covariance, shape (m, n) [SI squared]."""
        every = schedule.starts, schedule.lengths
        (C,) = self.between((every[0][own, None], every[1][own, None]), every)
        return np.asarray(C)

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process."""
        found = self.of_kinds(schedule, weights)
        return super().reduce(schedule, weights) if found is None else found[0]

    def of_kinds(self, schedule: Schedule, weights: Array) -> Array | None:
        """Return W C W^T by kinds, shape (p, k, k); None where it is no gain."""
        apart = np.unique(schedule.starts).size == len(schedule.starts)
        if weights.shape[1] <= ROWS or not apart:
            return None
        digits = np.round(weights / (np.abs(weights).max() or 1.0), ALIKE) + 0.0
        both = np.column_stack([schedule.lengths, digits.T])
        _, kinds, counts = np.unique(
            both, axis=0, return_inverse=True, return_counts=True
        )
        if len(counts) > MOST_KINDS:
            return None
        pairs, lags, times = _lags(schedule.starts.tobytes(), kinds.tobytes())
        V = np.stack([np.bincount(kinds, row) for row in weights]) / counts
        L = np.bincount(kinds, schedule.lengths) / counts
        n = len(L)
        spans = (
            (L[pairs[own] // n], lags[own], L[pairs[own] % n])
            for k in range(0, len(lags), ROWS**2)
            for own in [slice(k, k + ROWS**2)]
        )
        parts = [self.between((0.0 * t, a), (t, b)) for a, t, b in spans]
        C = np.concatenate(parts, axis=1) * times
        each = [np.bincount(pairs, part, n**2).reshape(n, n) for part in C]
        same = self.alone(L) * counts
        S = np.stack(
            [S + S.T + np.diag(own) for S, own in zip(each, same, strict=True)]
        )
        return np.asarray(V @ S @ V.T)


_Span = tuple["Array", "Array"]  # starts and lengths of windows [s]


@lru_cache(maxsize=16)  # of all processes and axes of a test
def _lags(starts: bytes, kinds: bytes) -> tuple[NDArray[np.intp], Array, Array]:
    """Return how far windows of two kinds are apart, and how often.

    Each of shape (m,): the pair, n times the kind of the first in time plus that of the
    other, of n; from start to start [s]; their number. Lags are told apart as far as
    the clock of the windows tells times.
    """
    t, which = np.frombuffer(starts), np.frombuffer(kinds, dtype=np.intp)
    tick = SUMS * np.spacing(t.max())
    number, most = which.max() + 1, int(t.max() / tick) + 2
    parts = []
    for k in range(0, len(t), ROWS):
        after = np.rint((t - t[k : k + ROWS, None]) / tick).astype(np.int64)
        keys = (which[k : k + ROWS, None] * number + which) * most + after
        parts.append(np.unique(keys[after > 0], return_counts=True))
    every, times = map(np.concatenate, zip(*parts, strict=True))
    keys, place = np.unique(every, return_inverse=True)
    pairs, lags = np.divmod(keys, most)
    counts = np.asarray(np.bincount(place, times), dtype=float)
    return pairs, np.asarray(lags * tick), counts


@dataclass(frozen=True)
class GaussMarkov(_Stationary):
    """First-order Gauss-Markov process, stationary: bias stability, Zhao 2019, 2.1.1.

    Its autocovariance is sigma^2 exp(-|t|/tau).
    """

    sigma: float  # [SI]
    correlation_time: float  # tau [s]

    def between(self, a: _Span, b: _Span) -> Array:
        """Return the covariances over sigma^2, and those minus 1; see _Stationary.

        tau^2/(L_a L_b) e^(-gap/tau) (1 - e^(-L_a/tau)) (1 - e^(-L_b/tau)). Minus 1 is
        what is left of a process that is nearly a constant.
        """
        tau = self.correlation_time
        later_start = np.maximum(a[0], b[0])
        gap = np.maximum(later_start - np.minimum(a[0] + a[1], b[0] + b[1]), 0.0) / tau
        means = (_log_mean_exponential(one[1] / tau) for one in (a, b))
        exponent = sum(means) - gap
        return np.stack([np.exp(exponent), np.expm1(exponent)])

    def alone(self, lengths: Array) -> Array:
        """Return 2 (x - 1 + e^(-x)) / x^2, x = L/tau, and that minus 1."""
        x = lengths / self.correlation_time
        small, large = np.minimum(x, 1.0), np.maximum(x, 1.0)
        series = _series(small, lambda k: 2.0 / factorial(k + 2))
        closed = 2.0 / large * (1.0 + np.expm1(-large) / large)
        both = np.where(x < 1.0, [series + 1.0, series], [closed, closed - 1.0])
        return np.asarray(both)

    def covariance(self, schedule: Schedule) -> Array:
        """Return the covariance of the averages, shape (n, n) [SI squared]."""
        whole, _ = _correlation(
            schedule, self.correlation_time, 0, len(schedule.windows)
        )
        return np.asarray(self.sigma**2 * whole)

    def reduce(self, schedule: Schedule, weights: Array) -> Array:
        """Return the covariance of weighted window averages; see Process.

        A process much slower than its windows is nearly a constant, which cancels in
        every difference of them. For rows whose windows are all shorter than tau the
        constant part is therefore taken out before the matrices are multiplied: its
        weight is the sum of a row, exactly 0 for a difference.
        """
        tau = self.correlation_time
        constant = weights.sum(axis=1)
        both = self.of_kinds(schedule, weights)
        if both is None:
            made = _correlation if weights.shape[1] > ROWS else _kept_correlation
            C = weighed(
                weights,
                lambda own: np.hstack([*made(schedule, tau, own.start, own.stop)]),
            )
            both = np.moveaxis(C.reshape(len(weights), 2, -1) @ weights.T, 1, 0)
        slow = tau > np.where(weights != 0.0, schedule.lengths, 0.0).max(axis=1)
        C = np.where(
            slow[:, None] & slow[None, :],
            np.outer(constant, constant) + both[1],
            both[0],
        )
        return np.asarray(self.sigma**2 * C)

    def in_run(self, sample_rate: float) -> InRun:  # noqa: ARG002
        """Return the same process."""
        return InRun("markov", self.sigma, (self.correlation_time,))


def _correlation(schedule: Schedule, tau: float, first: int, last: int) -> Array:
    """Return rows of the covariance over sigma^2, and of that minus 1, (2, m, n)."""
    own, process = slice(first, last), GaussMarkov(1.0, tau)
    starts, lengths = schedule.starts, schedule.lengths
    both = process.between((starts[own, None], lengths[own, None]), (starts, lengths))
    for rows, variances in zip(both, process.alone(lengths), strict=True):
        _put_diagonal(rows, own, variances)
    both.flags.writeable = False
    return both


# Of tests that are made whole: axes and devices mostly share their schedule and tau.
_kept_correlation = lru_cache(maxsize=256)(_correlation)


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

    def in_run(self, sample_rate: float) -> InRun:
        """Return the rounding of every sample."""
        return InRun("rounding", self.step, (1.0 / sample_rate,))


FAR = 1e4  # where the next term of the series of Ci is below rounding [1]


@dataclass(frozen=True)
class Flicker(_Stationary):
    """Flicker noise: two-sided density B^2/(2 pi |f|) above a low cut, IEEE 952."""

    coefficient: float  # B [SI]
    low_cut: float  # f_L [Hz]

    def between(self, a: _Span, b: _Span) -> Array:
        """Return the covariances; see _Stationary."""
        return -_difference(self._integral, a, b)[None]

    def in_run(self, sample_rate: float) -> InRun:  # noqa: ARG002
        """Return a sum of Gauss-Markov processes.

        A ratio r apart in correlation time, each of variance B^2 ln(r)/pi, they add up
        to the density B^2/(2 pi |f|) between 1/(2 pi tau) of the slowest and of the
        fastest.
        """
        slowest = 1.0 / (2.0 * pi * self.low_cut)
        number = max(ceil(log(slowest / FASTEST) / log(RATIO)), 1)
        times = tuple(slowest * RATIO ** -(place + 0.5) for place in range(number))
        return InRun("markov", self.coefficient * sqrt(log(RATIO) / pi), times)

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
    a, b = (starts[own, None], lengths[own, None]), (starts, lengths)
    signs = (-1.0, 1.0, 1.0)
    return tuple(
        sign * _difference(F, a, b) for sign, F in zip(signs, integrals, strict=False)
    )


def _difference(F: Callable[[Array], Array], a: _Span, b: _Span) -> Array:
    """Return S_F of two windows; see stationary."""
    edges = ((start + length, start) for start, length in (a, b))
    of_a, of_b = edges
    ee, es, se, ss = (F(y - x) for x in of_a for y in of_b)  # of a, then of b
    return np.asarray((ee - es - se + ss) / (a[1] * b[1]))


def _series(x: Array, coefficient: Callable[[int], float]) -> Array:
    """Return the sum of coefficients times (-x)^k, k from 1, by Horner's rule."""
    found = 0.0 * x
    for k in range(SERIES_TERMS, 0, -1):
        found = -x * (coefficient(k) + found)
    return found


def _log_mean_exponential(x: Array) -> Array:
    """Return log((1 - e^(-x)) / x), to rounding for x from 0 up."""
    series = _series(np.minimum(x, 1.0), lambda k: 1.0 / factorial(k + 1))
    large = np.maximum(x, 1.0)
    logarithm = np.log(-np.expm1(-large) / large)
    return np.asarray(np.where(x < 1.0, np.log1p(series), logarithm))
