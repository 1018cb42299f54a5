"""What is kept of Monte Carlo trials: exact moments, values or counts, block means."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.intervals import Grid, Histogram, interval_of_values

if TYPE_CHECKING:
    from budget.arrays import Array

ERROR_RATE = 0.05  # [1], of what adaptive trials are said to have settled to
HALVINGS = 12  # of the bracket around r, from above: to 1e-4 of it
EXACT_TRIALS = 2_000_000  # kept as they are; beyond, quantiles come from a histogram


@dataclass(frozen=True, kw_only=True, eq=False)
class Moments:
    """Mean and co-moment of a number of trials; two of them add up exactly.

    Attributes
    ----------
    n : int
    mean : ndarray, shape (n_out,)
    deviations : ndarray, shape (n_out, n_out)
        Sum over trials of (y - mean)(y - mean)^T.
    """

    n: int
    mean: Array
    deviations: Array

    @classmethod
    def of(cls, y: Array) -> Moments:
        """Return the moments of trials, shape (n_out, n)."""
        mean = y.mean(axis=1)
        centred = y - mean[:, None]
        return cls(n=y.shape[1], mean=mean, deviations=centred @ centred.T)

    def __add__(self, other: Moments) -> Moments:
        """Return the moments of both together (pairwise update of a variance)."""
        n = self.n + other.n
        step = other.mean - self.mean
        return Moments(
            n=n,
            mean=self.mean + step * (other.n / n),
            deviations=self.deviations
            + other.deviations
            + np.outer(step, step) * (self.n * other.n / n),
        )

    @property
    def covariance(self) -> Array:
        """Sample covariance, shape (n_out, n_out): JCGM 101:2008, eq. (17)."""
        return np.asarray(self.deviations / (self.n - 1))

    @property
    def standard_uncertainty(self) -> Array:
        """Sample standard deviations, shape (n_out,)."""
        return np.sqrt(np.diag(self.covariance))


@dataclass(frozen=True, kw_only=True, eq=False)
class MacroBlock:
    """What a worker returns of M trials.

    Attributes
    ----------
    moments : Moments
    values : ndarray, shape (n_out, M), or None
        The trials, in their order; None where their counts stand instead.
    histogram : Histogram or None
    settling : ndarray, shape (4, n_out), or None
        Mean, standard uncertainty and both interval ends of this block alone; of the
        macro-blocks of the first stage.
    """

    moments: Moments
    values: Array | None = None
    histogram: Histogram | None = None
    settling: Array | None = None


class Gathering:
    """Macro-blocks taken in one after another, and the numbers of all so far."""

    def __init__(self, first: MacroBlock, *, exact: bool) -> None:
        """Begin with the first block; `exact` keeps up to EXACT_TRIALS as they are."""
        self.moments = first.moments
        self._keep = EXACT_TRIALS if exact else 0
        self._kept: list[Array] = []
        self._histogram: Histogram | None = None
        self._settling: list[Array] = []
        self._blocks = 0
        self._store(first)

    @property
    def grid(self) -> Grid | None:
        """Bins for macro-blocks yet to come; None while values are kept."""
        return None if self._histogram is None else self._histogram.grid

    def take(self, block: MacroBlock) -> None:
        """Take in the next macro-block."""
        self.moments += block.moments
        self._store(block)

    def reached(self, kind: str) -> Array:
        """Return what the least settled of the four numbers has settled to, (n_out,).

        Stein's two stages in place of the fixed factor 2 of JCGM 101:2008, 7.9.4 e) to
        i): with s_j the spread of number j over the n macro-blocks of the first stage
        and h those there are, r solves

            sum_j P(|t_{n-1}| > r sqrt(h)/s_j) = ERROR_RATE ,

        so that all four errors are within r with a probability of 1 - ERROR_RATE or
        more (Bonferroni; the union over four, each with a part of the rate that goes by
        its spread). For one number it is exact where block values are normal, because s
        comes from the first stage alone and decides only when to stop (Stein 1945, Ann.
        Math. Statist. 16, 243-258). A spread taken anew at every block would choose the
        moments at which it happens to be small.

        The ends of a shortest interval settle as h^(-1/3) only (Kim and Pollard 1990,
        Ann. Statist. 18, 191-219).
        """
        n = len(self._settling)
        if n < 2:  # noqa: PLR2004 - a spread takes two
            return np.full(self.moments.mean.shape, np.inf)
        ends = 1.0 / 3.0 if kind == "shortest" else 1.0 / 2.0
        rate = float(self._blocks) ** -np.array([0.5, 0.5, ends, ends])
        error = np.std(self._settling, axis=0, ddof=1) * rate[:, None]
        return _exceeded_by_none(error, n - 1)

    def interval(self, coverage: float, kind: str) -> Array:
        """Return the coverage intervals of all trials so far, shape (n_out, 2)."""
        if self._histogram is not None:
            return self._histogram.interval(coverage, kind)
        # Output after output: never a sorted copy of all trials.
        rows = range(len(self.moments.mean))
        return np.concatenate(
            [
                interval_of_values(
                    np.sort(np.concatenate([kept[k] for kept in self._kept]))[None],
                    coverage,
                    kind,
                )
                for k in rows
            ]
        )

    def values(self) -> Array | None:
        """Return all trials in their order, shape (n_out, trials), if still kept."""
        return None if self._histogram else np.concatenate(self._kept, axis=1)

    def _store(self, block: MacroBlock) -> None:
        """Keep values while they are few, counts from then on."""
        self._blocks += 1
        if block.settling is not None:
            self._settling.append(block.settling)
        if block.histogram is not None:
            self._count(block.histogram)
        elif block.values is not None:
            self._kept.append(block.values)
        if self._kept and (self._histogram or self.moments.n > self._keep):
            grid = self.grid or Grid.around(
                self.moments.mean, self.moments.standard_uncertainty
            )
            while self._kept:  # freed one by one
                self._count(grid.count(self._kept.pop(0)))

    def _count(self, more: Histogram) -> None:
        """Add counts to those so far."""
        self._histogram = more if self._histogram is None else self._histogram + more


def _exceeded_by_none(error: Array, degrees_of_freedom: int) -> Array:
    """Return r of each column with sum_j P(|t| > r/error_j) = ERROR_RATE, (n_out,)."""
    from scipy.special import stdtr, stdtrit

    v = degrees_of_freedom
    largest, counts = error.max(axis=0), len(error)
    # As if only the largest counted, and as if all were as large.
    low = largest * float(stdtrit(v, 1.0 - ERROR_RATE / 2.0))
    high = largest * float(stdtrit(v, 1.0 - ERROR_RATE / (2.0 * counts)))
    safe = np.where(error > 0.0, error, 1.0)
    for _ in range(HALVINGS):
        r = 0.5 * (low + high)
        beyond = np.where(error > 0.0, 2.0 * stdtr(v, -r / safe), 0.0).sum(axis=0)
        low, high = (
            np.where(beyond > ERROR_RATE, r, low),
            np.where(beyond > ERROR_RATE, high, r),
        )
    return np.asarray(high)
