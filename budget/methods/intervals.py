"""Coverage intervals from trials (JCGM 101:2008, 7.7), and how well they are known."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log10
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.problem import Output


KINDS = ("symmetric", "shortest")

SOME = 1000  # trials that tell where the ends of all are about
INSIDE = 15  # of them, beyond each end: two to three standard errors of 2.5 %

BINS = 24_000
REACH = 12.0  # half-width of a histogram over the standard uncertainty: bins of u/1000


def interval_of_values(ordered: Array, coverage: float | Array, kind: str) -> Array:
    """Return the coverage interval of ascending trials (n_out, M), shape (n_out, 2).

    'symmetric' in probability (7.7.2) or 'shortest' (7.7.4), of the given coverage:
    that of all, or of each output.
    """
    if isinstance(coverage, np.ndarray):
        return np.concatenate(
            [
                interval_of_values(row[None], float(each), kind)
                for row, each in zip(ordered, coverage, strict=True)
            ]
        )
    M = ordered.shape[1]
    q = min(max(int(M * coverage + 0.5), 1), M - 1)  # 7.7.1
    if kind == "symmetric":
        r = (M - q + 1) // 2 - 1  # 7.7.2, counted from 0
        return np.stack([ordered[:, r], ordered[:, r + q]], axis=1)
    r_best = np.argmin(ordered[:, q:] - ordered[:, :-q], axis=1)  # 7.7.4
    rows = np.arange(len(ordered))
    return np.stack([ordered[rows, r_best], ordered[rows, r_best + q]], axis=1)


def interval_of_trials(values: Sequence[Array], coverage: float, kind: str) -> Array:
    """Return interval_of_values of one output's trials in any order, shape (2,).

    They may stand in several arrays. Neither end of an interval lies further in than
    the trials left out of it: only the tails are sorted.
    """
    M = sum(map(len, values))
    q = min(max(int(M * coverage + 0.5), 1), M - 1)  # 7.7.1
    if kind != "symmetric":
        low, high = _sorted_tails(values, M - q)
        low, high = low[: M - q], high[q - M :]
        r = int(np.argmin(high - low))  # 7.7.4
        return np.array([low[r], high[r]])
    r = (M - q + 1) // 2 - 1  # 7.7.2, counted from 0
    low, high = _tails(values, max(r + 1, M - r - q))
    low.partition(r)  # alone is it in its place, which costs less than all in theirs
    end = low[r]
    high.partition(len(high) + r + q - M)
    return np.array([end, high[r + q - M]])


def sort_tails(values: Array, depth: NDArray[np.intp]) -> Array:
    """Return trials, shape (n_out, M), of which the ends alone are in ascending order.

    So many of the smallest and of the largest trials of each output, depth (n_out,),
    stand where they do when all are sorted; between them there may be nan.
    """
    ordered = np.full_like(values, np.nan)
    for row, trials, n in zip(ordered, values, depth.tolist(), strict=True):
        low, high = _sorted_tails([trials], n)
        row[: len(low)] = low
        row[row.size - len(high) :] = high
    return ordered


def _tails(values: Sequence[Array], n: int) -> tuple[Array, Array]:
    """Return n or more of the smallest and of the largest trials, each in any order.

    They are cut off a little inside of where the ends of some of the trials are.
    """
    M = sum(map(len, values))
    some = np.sort(np.concatenate([each[:: max(M // SOME, 1)] for each in values]))
    inside = int(len(some) * (n / M)) + INSIDE
    if 2 * inside < len(some):
        low = np.concatenate([each.compress(each <= some[inside]) for each in values])
        high = np.concatenate(
            [each.compress(each >= some[-1 - inside]) for each in values]
        )
        if len(low) >= n and len(high) >= n:
            return low, high
    every = np.concatenate(values)
    return every, every


def _sorted_tails(values: Sequence[Array], n: int) -> tuple[Array, Array]:
    """Return the same, both ascending."""
    low, high = _tails(values, n)
    return np.sort(low), np.sort(high)


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Equal bins for every output; what falls outside counts in the outermost."""

    # Lower end of the first bin, width of a bin, shape (n_out,) [SI].
    low: Array
    width: Array

    @classmethod
    def around(cls, mean: Array, u: Array) -> Grid:
        """Lay bins of u/1000 over mean +- 12 u; a constant output gets any width."""
        reach = REACH * np.where(u > 0.0, u, 1.0)
        return cls(low=mean - reach, width=2.0 * reach / BINS)

    def count(self, values: Array) -> Histogram:
        """Count trials, shape (n_out, trials), in the bins."""
        counts = np.empty((len(values), BINS))
        for row, y in enumerate(values):
            place = (y - self.low[row]) / self.width[row]
            np.clip(place, 0, BINS - 1, out=place)
            counts[row] = np.bincount(place.astype(np.intp), minlength=BINS)
        return Histogram(
            grid=self,
            counts=counts,
            least=values.min(axis=1),
            largest=values.max(axis=1),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Histogram:
    """Counts of all trials of every output, and their extremes."""

    grid: Grid
    counts: Array  # shape (n_out, BINS)
    # Smallest and largest trial, shape (n_out,) [SI].
    least: Array
    largest: Array

    def __add__(self, other: Histogram) -> Histogram:
        """Return the histogram of both; they have the same grid."""
        return Histogram(
            grid=self.grid,
            counts=self.counts + other.counts,
            least=np.minimum(self.least, other.least),
            largest=np.maximum(self.largest, other.largest),
        )

    def interval(self, coverage: float, kind: str) -> Array:
        """Return the coverage interval, shape (n_out, 2), to a bin of u/1000."""
        return np.array(
            [self._interval(row, coverage, kind) for row in range(len(self.counts))]
        )

    def _interval(self, row: int, coverage: float, kind: str) -> tuple[float, float]:
        """Return the interval of one output, by interpolation within bins."""
        edges = self.grid.low[row] + self.grid.width[row] * np.arange(BINS + 1)
        # The outermost bins reach to the extremes.
        edges[0] = min(edges[0], self.least[row])
        edges[-1] = max(edges[-1], self.largest[row])
        below = np.concatenate([[0.0], np.cumsum(self.counts[row])])
        below /= below[-1]
        if kind == "symmetric":
            tail = (1.0 - coverage) / 2.0
            low, high = np.interp([tail, 1.0 - tail], below, edges)
        else:
            lows = edges[below <= 1.0 - coverage]
            highs = np.interp(below[: lows.size] + coverage, below, edges)
            best = int(np.argmin(highs - lows))
            low, high = lows[best], highs[best]
        return (
            float(np.clip(low, self.least[row], self.largest[row])),
            float(np.clip(high, self.least[row], self.largest[row])),
        )


def numerical_tolerance(u: Array, outputs: tuple[Output, ...], digits: int) -> Array:
    """Return delta of every output, shape (n_out,) [SI].

    u = c 10^l with c an integer of so many digits, delta = 10^l / 2. The digits are
    those of the number as it is printed, in the output's unit. A spread that is only
    rounding has the tolerance of its resolution.

    Parameters
    ----------
    u : ndarray, shape (n_out,)
        Standard uncertainties [SI].
    outputs : tuple of Output
        Their units and resolutions.
    digits : int
        Significant digits wanted of u.
    """
    return np.array(
        [
            _half_last_digit(value / output.si_per_unit, digits) * output.si_per_unit
            if value > output.resolution
            else output.resolution
            for value, output in zip(u, outputs, strict=True)
        ]
    )


def _half_last_digit(u: float, digits: int) -> float:
    """Return half a unit in the last of the significant digits of u."""
    last = floor(log10(u)) - digits + 1
    if round(u / 10.0**last) == 10**digits:  # 9.96 has two digits as 10, not 9.9
        last += 1
    return 0.5 * 10.0**last
