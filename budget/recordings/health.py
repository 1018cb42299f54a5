"""Health of recorded samples: what is stuck, saturated, an outlier, or missing.

Of a log at rest (budget.recordings.log) samples are looked at piece by piece, of a
calibration (budget.recordings.run) window by window. A run of equal values is stuck
where chance does not allow it by the equal neighbours of the channel itself.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from math import erf, log, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array

MOST_JITTER = 1.5  # of a step over the usual one: more is a gap [1]
WINDOW = 64  # samples whose median an outlier is off
FAR = 8.0  # robust sigmas, of an outlier [1]
MOST_OUTLIERS = 0.01  # of the samples [1]
CHANCE = 1e-6  # of a run of equal values in sound data [1]
LEAST_EQUAL = 1e-3  # probability of two equal values that is reckoned with [1]
FINE = 0.02  # the same, below which three equal extremes are no chance [1]
AT_END = 3  # equal extreme values, one after the other
ROBUST = 1.4826  # of a normal sigma over its median absolute deviation [1]
PARTS = 16  # of the first piece, of whose runs the median counts
MOST_LISTED = 5  # outliers that are named
SPIKE = 5  # samples whose median a spike of one or two is off
TWO_LEVELS = 1.5  # steps, below which all that is read is one level or two [1]
QUARTER = 0.25  # of the parts of a channel, that may be unsound [1]
EXTREME = 0.98  # of the samples of a window, below its end [1]
SEEN = 0.1  # of the largest reading of a turn, that a spike is at the least [1]
LEAST_LEFT = 0.5  # of the samples of a window, below which its mean is none [1]
HARMONICS = 100  # of what steps put into a mean
COARSE = 0.01  # of a step, that a mean is off by [1]
LOST = 1e-3  # of a turn, that may be lost in a gap [1]


@dataclass(frozen=True, kw_only=True)
class KeptOut:
    """How many samples of a channel are kept out, and the first outliers.

    Attributes
    ----------
    stuck, saturated, outliers : int
    first : tuple of (float, float)
        Time since the start [s] and value [SI, or counts] of the first outliers.
    """

    stuck: int = 0
    saturated: int = 0
    outliers: int = 0
    first: tuple[tuple[float, float], ...] = ()


@dataclass
class Look:
    """What is usual of a channel, by its first piece, and what came last.

    Attributes
    ----------
    sigma : float
        Robust, of what a sample is off the median of its window [unit].
    longest : float
        Equal values one after the other that are chance still [1].
    value, run : float, int
        The last value, and how many of it have come.
    """

    sigma: float
    longest: float
    value: float = field(default=np.nan)
    run: int = 0

    @classmethod
    def of(cls, values: Array) -> Look:
        """Look at the first piece of a channel."""
        off = off_window(values)
        sigma = ROBUST * float(np.median(np.abs(off)))
        if sigma == 0.0:  # coarse steps: most are equal
            sigma = float(np.std(off))
        same = np.diff(values) == 0.0
        parts = [float(one.mean()) for one in np.array_split(same, PARTS) if one.size]
        equal = min(max(float(np.median(parts)), LEAST_EQUAL), 1.0 - 1e-9)
        longest = log(CHANCE / values.size) / log(equal)
        return cls(sigma=sigma, longest=longest)

    def clean(
        self,
        values: Array,
        place: NDArray[np.int64],
        kept: KeptOut,
        stated: float | None,
    ) -> tuple[Array, KeptOut]:
        """Return values with nan for what is kept out, and how many that are."""
        runs = self._runs(values)
        stuck = runs > max(self.longest, AT_END)
        saturated = at_end(values, runs) & ~stuck
        if stated is not None:
            saturated |= np.abs(values) >= stated * (1.0 - 1e-9)
            stuck &= ~saturated
        sound = np.where(stuck | saturated, np.nan, values)
        outlier = self._outliers(sound)
        found = np.flatnonzero(outlier)
        room = MOST_LISTED - len(kept.first)
        listed = [(float(place[k]), float(values[k])) for k in found[:room].tolist()]
        sound[outlier] = np.nan
        return sound, KeptOut(
            stuck=kept.stuck + int(stuck.sum()),
            saturated=kept.saturated + int(saturated.sum()),
            outliers=kept.outliers + found.size,
            first=(*kept.first, *listed),
        )

    def _runs(self, values: Array) -> NDArray[np.int64]:
        """Return for each sample how many equal ones its run has, with those before."""
        counted = run_lengths(values)
        if values[0] == self.value:
            counted[: counted[0]] += self.run
        self.value, self.run = float(values[-1]), int(counted[-1])
        return counted

    def _outliers(self, values: Array) -> NDArray[np.bool_]:
        """Return which samples lie far off the median of their window."""
        if self.sigma == 0.0:
            return np.zeros(values.size, dtype=bool)
        return np.abs(off_window(values, near=FAR * self.sigma)) > FAR * self.sigma


def off_window(values: Array, near: float = 0.0) -> Array:
    """Return what each sample is off the median of its window.

    Windows that have nothing farther off their mean than `near` half are left at their
    means: no sample of them is off the median by so much.
    """
    n = max(values.size // WINDOW, 1)
    size = values.size // n
    off = np.empty_like(values)
    whole = values[: n * size].reshape(n, size)
    with np.errstate(invalid="ignore"):
        there = np.isfinite(whole)
        number = np.maximum(there.sum(axis=1), 1)
        middle = np.where(there, whole, 0.0).sum(axis=1) / number
        far = np.abs(np.where(there, whole - middle[:, None], 0.0)).max(axis=1)
    if near == 0.0:
        middle = np.median(whole, axis=1)
    for k in np.flatnonzero(far >= 0.5 * near).tolist() if near else ():
        own = whole[k][there[k]]
        middle[k] = np.median(own) if own.size else 0.0
    off[: n * size] = (whole - middle[:, None]).ravel()
    off[n * size :] = values[n * size :] - middle[-1]
    return np.where(np.isfinite(off), off, 0.0)


def at_end(values: Array, runs: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which samples are at the end of the range, where some pile up there.

    The extreme value three times running, and oftener than the next one to it: of
    noise in steps the extreme is rarer.
    """
    found = np.zeros(values.size, dtype=bool)
    for end in (values.max(), values.min()):
        at = values == end
        if runs[at].max() < AT_END:
            continue
        others = values[~at]
        if not others.size:
            continue
        nearest = others[np.abs(others - end).argmin()]
        if at.sum() > (others == nearest).sum():
            found |= at
    return found


# ---- windows -------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class UsualSteps:
    """What is usual of a channel of a whole run.

    Attributes
    ----------
    step : float
        The least change from one sample to the next, 0 without any [unit].
    longest : float
        Equal values one after the other that are chance still [1].
    is_fine : bool
        Whether equal neighbours are rare.
    """

    step: float
    longest: float
    is_fine: bool

    @classmethod
    def of(cls, values: Array) -> UsualSteps:
        """Look at a channel.

        Values in steps q of noise sigma are equal with a probability of 2 Phi(q/(2
        sigma)) - 1 at the most, where the mean is in the middle of a step. sigma is
        that of the quiet quarter of its parts, without the q^2/12 of the steps; of two
        levels alone it is not told, and all may be equal.
        """
        steps = np.diff(values)
        np.abs(steps, out=steps)
        step = float(steps.min(initial=np.inf, where=steps > 0.0))
        del steps
        step = step if np.isfinite(step) else 0.0
        n = max(values.size // WINDOW, 1)
        size = values.size // n
        parts = values[: n * size].reshape(n, size)
        square = float(np.quantile(parts.var(axis=1), QUARTER)) - step**2 / 12.0
        by_steps = 1.0
        levels = float(np.median(np.ptp(parts, axis=1)))
        if square > 0.0 and levels > TWO_LEVELS * step:
            by_steps = erf(step / sqrt(8.0 * square))
        same = (np.diff(parts, axis=1) == 0.0).mean(axis=1)
        seen = float(np.quantile(same, 1.0 - QUARTER))
        equal = min(max(seen, by_steps, LEAST_EQUAL), 1.0 - 1e-9)
        longest = max(log(CHANCE / values.size) / log(equal), float(AT_END))
        return cls(step=step, longest=longest, is_fine=equal < FINE)


@dataclass(frozen=True, kw_only=True)
class ReadingSteps:
    """Steps of the readings of a channel beside their noise.

    Rounding to steps q is off by the saw-tooth sum over k of (-1)^k q/(pi k) sin(2 pi
    k x/q), whose mean over a noise sigma about x has e^(-2 (pi k sigma/q)^2) of each
    term. Nobody knows x to a part of a step; that of two windows is independent.

    Attributes
    ----------
    step, noise : float
        q and sigma [unit].
    """

    step: float
    noise: float

    @classmethod
    def of(cls, rests: Sequence[Array], step: float) -> ReadingSteps:
        """Return those of a channel, by its readings at rest.

        How much readings scatter differs with where in a step their mean is: sigma is
        that whose variances at these means are nearest to theirs by least squares.
        """
        if step <= 0.0 or not rests:
            return cls(step=step, noise=0.0)
        means = np.array([one.mean() for one in rests]) / step
        square = np.array([one.var() for one in rests]) / step**2
        plain = sqrt(max(float(np.median(square)) - 1.0 / 12.0, 0.0))
        sigma, mean, variance = _in_steps()
        if plain > sigma[-1]:
            return cls(step=step, noise=plain * step)
        place = np.abs(means - np.rint(means))
        pairs = zip(mean, variance, strict=True)
        shown = np.array([np.interp(place, *pair) for pair in pairs])
        best = int(((shown - square) ** 2).sum(axis=1).argmin())
        return cls(step=step, noise=float(sigma[best]) * step)

    @property
    def u(self) -> float:
        """Standard uncertainty of a mean by them, anywhere in a step [unit]."""
        if self.step <= 0.0:
            return 0.0
        k = np.arange(1, HARMONICS + 1)
        size = 0.5 * (self.step / (pi * k)) ** 2
        left = np.exp(-((2.0 * pi * k * self.noise / self.step) ** 2))
        return sqrt(float((size * left).sum()))

    @property
    def is_coarse(self) -> bool:
        """Whether that counts."""
        return self.u > COARSE * self.step


@cache
def _in_steps() -> tuple[Array, Array, Array]:
    """Return sigma, (m,), and mean and variance of readings, (m, n), over a step.

    From the middle of a step to its edge.
    """
    from scipy.special import ndtr

    sigma, x = np.linspace(0.005, 0.8, 160), np.linspace(0.0, 0.5, 101)
    levels = np.arange(-5.0, 7.0)
    above = (levels + 0.5 - x[:, None]) / sigma[:, None, None]
    below = (levels - 0.5 - x[:, None]) / sigma[:, None, None]
    each = ndtr(above) - ndtr(below)
    mean = (each * levels).sum(axis=-1)
    return sigma, mean, (each * levels**2).sum(axis=-1) - mean**2


@dataclass(frozen=True, kw_only=True)
class WindowHealth:
    """What of one window of one triad is missing or unsound.

    Attributes
    ----------
    gaps, missing : int
        Steps over more than one sample, and samples that they leave out.
    saturated, stuck, outliers : tuple of int
        Samples, by axis.
    samples : int
        That were recorded.
    kept : float
        Part of the samples that the mean of the worst axis is of [1].
    is_lost : bool
        Whether a turn begins, ends or changes its rate in a gap.
    """

    gaps: int = 0
    missing: int = 0
    saturated: tuple[int, ...] = (0, 0, 0)
    stuck: tuple[int, ...] = (0, 0, 0)
    outliers: tuple[int, ...] = (0, 0, 0)
    samples: int = 0
    kept: float = 1.0
    is_lost: bool = False

    @property
    def is_thin(self) -> bool:
        """Whether so few samples are left that the mean is none."""
        return self.kept < LEAST_LEFT

    @property
    def is_spoilt(self) -> bool:
        """Whether its mean is not that of what the unit was exposed to."""
        return any(self.saturated) or self.is_thin or self.is_lost


@dataclass(frozen=True, kw_only=True)
class UnsoundSamples:
    """How many samples of one axis in one window are unsound."""

    window: int  # from 1
    sensor: str
    axis: str
    count: int


@dataclass(frozen=True, kw_only=True, eq=False)
class WindowReadings:
    """Readings of one triad in one window, with the sample before and after it.

    Attributes
    ----------
    times : ndarray, shape (n,)
        [s].
    values : ndarray, shape (3, n)
    first, last : int
        Where the window begins, and its end.
    rate : float
        [Hz].
    is_turn, has_angle : bool
        Whether the unit turns in it, and readings are rates.
    """

    times: Array
    values: Array
    first: int
    last: int
    rate: float
    is_turn: bool
    has_angle: bool

    @property
    def own(self) -> Array:
        """Readings of the window alone, (3, m)."""
        return self.values[:, self.first : self.last]

    @property
    def places(self) -> NDArray[np.int64]:
        """Where the samples stand on a grid of equal intervals."""
        steps = np.diff(self.times) * self.rate
        ahead = np.where(steps > MOST_JITTER, np.rint(steps), 1.0).astype(np.int64)
        return np.concatenate([[0], np.cumsum(ahead)])

    def mean(
        self,
        usual: Sequence[UsualSteps | None],
        ends: tuple[Array, Array],
        stated: float | None,
    ) -> tuple[Array, WindowHealth]:
        """Return the mean of what is sound, (3,), and what is not.

        Over what is missing or kept out of a turn the reading is taken as linear; a
        mean of saturated samples is given as it is.

        Parameters
        ----------
        usual : sequence of UsualSteps or None
            By axis; None of one that was not recorded.
        ends : (ndarray, ndarray), shape (3,)
            What the channel reads at the least and at the most in all windows.
        stated : float, optional
            End of the range.
        """
        places, own = self.places, self.own
        n = own.shape[1]
        inside = np.diff(places[self.first : self.last])
        missing = int((inside - 1).sum())
        mean = np.full(3, np.nan)
        counts = np.zeros((3, 3), dtype=int)  # saturated, stuck, outliers; by axis
        kept, is_lost = 1.0, False
        turned = np.abs(own.sum(axis=1))
        turn = float(np.nanmax(turned)) if np.isfinite(turned).any() else 0.0
        for axis, (each, common) in enumerate(zip(own, usual, strict=True)):
            if common is None:
                continue
            low, high = float(ends[0][axis]), float(ends[1][axis])
            saturated = saturated_in(each, common, stated, (low, high))
            stuck = (run_lengths(each) > common.longest) & ~saturated
            sound = ~(saturated | stuck)
            outlier = np.zeros(n, dtype=bool)
            if sound.any() and not saturated.any():
                outlier = sound & self._outliers(each, sound, common.step)
            counts[:, axis] = saturated.sum(), stuck.sum(), outlier.sum()
            good = ~(stuck | outlier)
            left = float(good.sum()) / (n + missing)
            kept = min(kept, left)
            if left < LEAST_LEFT:
                mean[axis] = each.mean()
            elif self.is_turn:
                mean[axis], lost = self._bridged(axis, good, places)
                is_lost |= self.has_angle and lost > LOST * turn
            else:
                mean[axis] = each[good].mean()
        of_axes = [tuple(row) for row in counts.tolist()]
        return mean, WindowHealth(
            gaps=int((inside > 1).sum()),
            missing=missing,
            saturated=of_axes[0],
            stuck=of_axes[1],
            outliers=of_axes[2],
            samples=n,
            kept=kept,
            is_lost=is_lost,
        )

    def _outliers(
        self, values: Array, sound: NDArray[np.bool_], step: float
    ) -> NDArray[np.bool_]:
        """Return which samples are far off.

        Of a rest off the median of the window. Of a turn off that of the samples
        beside it, which an edge is not, and by a part of the largest reading besides.
        """
        if self.is_turn:
            size = np.quantile(np.abs(self.own), EXTREME, axis=1)
            return spikes(values, step, SEEN * float(np.nanmax(size)))
        off = np.abs(values - np.median(values[sound]))
        sigma = ROBUST * float(np.median(off[sound]))
        return np.asarray(off > FAR * max(sigma, step))

    def _bridged(
        self, axis: int, good: NDArray[np.bool_], places: NDArray[np.int64]
    ) -> tuple[float, float]:
        """Return the mean over all places of a turn, and what a gap may hide of it.

        The latter is the change of the reading over a gap times its samples.
        """
        own = self.values[axis]
        there = np.ones(own.size, dtype=bool)
        there[self.first : self.last] = good
        at, seen = places[there], own[there]
        wide = np.diff(at) > 1
        if not wide.any():
            return float(self.own[axis].mean()), 0.0
        lost = (np.abs(np.diff(seen)) * (np.diff(at) - 1))[wide].max()
        grid = np.arange(places[self.first], places[self.last - 1] + 1)
        return float(np.interp(grid, at, seen).mean()), float(lost)


def ends_of(windows: Sequence[Array]) -> tuple[Array, Array]:
    """Return what a triad reads at the least and at the most, (3,), less outliers."""
    low = [np.quantile(one, 1.0 - EXTREME, axis=1) for one in windows]
    high = [np.quantile(one, EXTREME, axis=1) for one in windows]
    return np.asarray(np.min(low, axis=0)), np.asarray(np.max(high, axis=0))


def saturated_in(
    values: Array,
    usual: UsualSteps,
    stated: float | None,
    ends: tuple[float, float] | None = None,
) -> NDArray[np.bool_]:
    """Return which samples of a window are at the end of the range.

    Parameters
    ----------
    usual : UsualSteps
    stated : float, optional
        End of the range [unit].
    ends : (float, float), optional
        The least and the largest value in all windows, that one which reads the same
        throughout is held against [unit]; None: it is at the end.
    """
    if stated is not None:
        return np.asarray(np.abs(values) >= stated * (1.0 - 1e-9))
    runs = run_lengths(values)
    if runs[0] == values.size:
        is_end = ends is None or (
            ends[0] < ends[1] and not ends[0] < values[0] < ends[1]
        )
        return np.full(values.size, is_end and values.size > usual.longest)
    found = at_end(values, runs)
    return found if usual.is_fine else found & (runs > usual.longest)


def spikes(values: Array, step: float, least: float = 0.0) -> NDArray[np.bool_]:
    """Return which samples are far off the median of those beside them.

    Parameters
    ----------
    step : float
        The least change of the channel [unit].
    least : float
        What it is off by at the least [unit].
    """
    from scipy.ndimage import median_filter

    off = np.abs(values - median_filter(values, SPIKE, mode="nearest"))
    sigma = ROBUST * float(np.median(off))
    return np.asarray(off > max(FAR * sigma, FAR * step, least))


def run_lengths(values: Array) -> NDArray[np.int64]:
    """Return for each sample how many equal ones its run has."""
    starts = np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)
    lengths = np.diff(np.append(starts, values.size))
    return np.asarray(np.repeat(lengths, lengths))
