"""Allocation: factors on sources that keep outputs within their limits.

A Task is one law, one set of limits and the room that each source has. Three
strategies share the limits out, headroom and floor say what is possible at all. Least
cost is in budget.methods.least_cost.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, log
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.scaling import NEGLIGIBLE
from budget.ties import first_largest, largest

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.methods.scaling import ScaledLaw

# Allocations aim this little below the limit, so that rounding does not carry them
# beyond it [1].
TARGET = 1.0 - 1e-9
# An output counts as at its limit from here on [1].
AT_LIMIT = 1.0 - 1e-6
SMALLEST = 1e-30  # factor that stands for none where a logarithm is taken [1]
TOUCHES = 1e-6  # relative distance at which a bound counts as reached
# Share of an output's variance up to which a source does not matter there [1].
SPARED = 0.01
# Part of a squared limit that sources may take and still be spared: what is left is
# for the others, which would have to become very small for the sake of those [1].
MOST_SPARED = 0.9


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """Limits on some outputs of one law, and the room of each source."""

    law: ScaledLaw  # of the limited outputs alone
    limit: Array  # largest absolute interval end that is allowed, shape (n_out,) [SI]
    # k of the interval mean +- k u of each output, of a length if it lay along one
    # axis, shape (n_out,) [1].
    coverage_factor: Array
    # Sources that may change; the others stay at s = 1, shape (n_src,).
    free: NDArray[np.bool_]
    # Least and largest factor of each free source, shape (n_src,) [1].
    low: Array
    high: Array
    # Probabilities of the intervals, shape (n_out,) [1]; None where no output is a
    # length, of which k goes with the ellipse.
    coverage: Array | None = None

    @property
    def now(self) -> Array:
        """Return the factors of the present state, all 1."""
        return np.ones(len(self.law.sources))

    @property
    def least(self) -> Array:
        """Return the factors of the floor: every free source as small as it may be."""
        return np.where(self.free, self.low, 1.0)

    def clip(self, s: Array) -> Array:
        """Return factors within bounds, those of held sources 1."""
        return np.where(self.free, np.clip(s, self.low, self.high), 1.0)

    def utilisation(self, s: Array) -> Array:
        """Return interval ends over limits, shape (n_out,) [1]."""
        return self.law.end(s, self.factor(s)) / self.limit

    def factor(self, s: Array) -> Array:
        """Return k of each output with these factors, shape (n_out,) [1]."""
        return self.coverage_factor * self.roundness(s)

    def roundness(self, s: Array) -> Array:
        """Return what k of a length is over that along one axis, shape (n_out,) [1]."""
        if self.coverage is None:
            return np.ones(len(self.limit))
        return self.law.roundness(s, self.coverage)

    def log_end_gradient(self, s: Array) -> Array:
        """Return d log(end) / d log(s), shape (n_out, n_src) [1]."""
        found = self.law.log_end_gradient(s, self.factor(s))
        if self.coverage is None:
            return found
        return found + self.law.log_roundness_gradient(s, self.coverage)

    def part(self, s: Array) -> Array:
        """Return k^2 V_g / limit^2 of each source alone, shape (n_out, n_src) [1]."""
        scale = (self.factor(s) / self.limit) ** 2
        return np.asarray(scale[:, None] * self.law.variance_alone(s))

    def binding(self, s: Array) -> NDArray[np.bool_]:
        """Return which outputs are at their limits, shape (n_out,)."""
        return np.asarray(self.utilisation(s) >= AT_LIMIT)

    @property
    def is_feasible(self) -> bool:
        """Whether the limits can be met at all."""
        return bool((self.utilisation(self.least) <= TARGET).all())


@dataclass(frozen=True, kw_only=True)
class FactorHeadroom:
    """How far one source may go alone."""

    factor: float  # on its present size [1]; inf where nothing stops it
    stopped_by: tuple[int, ...]  # places of the outputs; (): its ceiling or nothing


@dataclass(frozen=True, kw_only=True, eq=False)
class Sparing:
    """One factor on the sources that matter, the others as they are."""

    s: Array  # factors, shape (n_src,) [1]
    spared: NDArray[np.bool_]  # free, and left as they are, shape (n_src,)


def proportional(task: Task) -> Array:
    """Return one common factor on all free sources, shape (n_src,) [1]."""
    return grow(task, task.now, task.free)


def sparing(
    task: Task, *, now: ScaledLaw | None = None, known: NDArray[np.bool_] | None = None
) -> Sparing:
    """Bring outputs to their limits by one factor on the sources that matter there.

    One factor on all free sources says which outputs come to their limits first. A
    source matters where its variance alone is more than SPARED of the variance of one
    of these now; the others stay as they are. Of those the one that takes most is taken
    in, one after the other, as long as a limit has less than 1 - MOST_SPARED of its
    square left for the sources that matter; and so are those that matter at an output
    that comes to its limit only then. Where no limit is reached none is spared. What
    is now may go by another law than the task's; sources `known` to matter, shape
    (n_src,), do.
    """
    start = task.clip(task.now)
    everyone = grow(task, start, task.free)
    law = now or task.law
    variance, alone = law.variance(start)[:, None], law.variance_alone(start)
    share = np.divide(alone, variance, out=np.zeros_like(alone), where=variance > 0.0)
    matters = (share > SPARED) & task.free
    reached = task.binding(everyone)
    if not reached.any():
        return Sparing(s=everyone, spared=np.zeros_like(task.free))
    who = np.asarray(matters[reached].any(axis=0))
    who |= np.zeros_like(who) if known is None else known
    while True:
        left = np.where(who, np.minimum(task.low, start), start)
        crowded = task.utilisation(left) ** 2 > MOST_SPARED
        takes = np.where(task.free & ~who, task.part(left), 0.0)
        takes[~crowded] = 0.0
        if takes.max() > SPARED:
            who[largest(takes.max(axis=0).tolist()),] = True
            continue
        s = grow(task, start, who)
        used = task.utilisation(s)
        more = matters[used >= AT_LIMIT].any(axis=0)
        if (used > 1.0).any():  # what matters cannot do it
            more |= task.free & (task.part(s)[used > 1.0] >= NEGLIGIBLE).any(axis=0)
        if not (more & ~who).any():
            break
        who |= more
    if not task.binding(s).any():  # all at their ceilings
        return Sparing(s=everyone, spared=np.zeros_like(task.free))
    return Sparing(s=s, spared=task.free & ~who)


def equal(task: Task) -> Array:
    """Share the limits equally, then use up what is left.

    Each free source starts with 1/n of the squared limit at the output where it now
    uses most of it, n being the free sources that count there. One common factor
    then brings the first output to its limit; sources that no output at its limit
    limits grow on; a last factor takes back what their second-order terms added.

    Returns
    -------
    ndarray, shape (n_src,)
        Factors [1].
    """
    s = _equal_start(task)
    s = grow(task, s, task.free)
    for _ in range(len(task.law.outputs)):
        bound = task.binding(s)
        counted = (task.part(s)[bound] >= NEGLIGIBLE).any(axis=0)
        at_ceiling = s >= task.high * (1.0 - TOUCHES)
        loose = task.free & ~counted & ~at_ceiling
        if not loose.any() or bound.all():
            break
        # Outputs at their limits now may be passed by a little: see the last factor.
        s = grow(task, s, loose, among=~bound)
    if (task.utilisation(s) > 1.0).any():
        s = grow(task, s, task.free)
    return s


def headroom(task: Task, s: Array) -> tuple[FactorHeadroom, ...]:
    """Return how far each source may go alone, the others staying as they are at s.

    A factor counts from the present size; below 1 the source must shrink, 0 says that
    an output that it reaches passes its limit even without it. Outputs that fail and
    that a source does not reach do not stop it. Ceilings do not count here.
    """
    return tuple(headroom_of(task, s, g) for g in range(len(task.law.sources)))


def headroom_of(task: Task, s: Array, g: int) -> FactorHeadroom:
    """Return how far one source may go alone from s; see headroom."""
    task = replace(
        task,
        free=np.arange(len(s)) == g,
        low=np.zeros_like(task.low),
        high=np.full_like(task.high, inf),
    )
    without = s.copy()
    without[g] = 0.0
    over = task.utilisation(without)
    hopeless = (over > TARGET) & (task.part(s)[:, g] >= NEGLIGIBLE)
    if hopeless.any():
        places = largest(np.where(hopeless, over, 0.0).tolist())
        return FactorHeadroom(factor=0.0, stopped_by=places)
    counts = over <= TARGET
    end = grow(task, s, task.free, among=counts)
    used = np.where(counts, task.utilisation(end), 0.0)
    if used.max() < AT_LIMIT:
        return FactorHeadroom(factor=inf, stopped_by=())
    return FactorHeadroom(factor=float(end[g]), stopped_by=largest(used.tolist()))


def grow(
    task: Task,
    s: Array,
    who: NDArray[np.bool_],
    *,
    among: NDArray[np.bool_] | None = None,
) -> Array:
    """Multiply some sources by one factor until an output is at its limit.

    From the factors s on, shape (n_src,), for those who take part; the others stay at
    s, and one that reaches a bound stays there. Only the outputs among those given
    count. All end at their ceilings where no output stops them, all at their least
    where even that is too much.
    """
    from scipy.optimize import brentq

    counts = np.ones(len(task.limit), dtype=bool) if among is None else among
    start = np.where(s > 0.0, s, SMALLEST)

    def at(x: float) -> Array:
        return np.where(who, np.clip(start * np.exp(x), task.low, task.high), s)

    def excess(x: float) -> float:
        largest = task.utilisation(at(x))[counts].max()
        return float(np.log(max(largest, SMALLEST) / TARGET))

    moving = who & (task.high > 0.0)
    if not moving.any() or not counts.any():
        return np.asarray(s)
    finite = np.where(np.isfinite(task.high), task.high, 1.0 / SMALLEST)
    top = max(float(np.log(finite[moving] / start[moving]).max()), 0.0) + 1.0
    if excess(top) <= 0.0:
        return at(top)
    bottom = min(log(SMALLEST), top - 1.0)
    if excess(bottom) > 0.0:
        return at(bottom)
    return at(float(brentq(excess, bottom, top, xtol=1e-13, rtol=1e-14)))


def _equal_start(task: Task) -> Array:
    """Return the factors that give each free source its equal part of one limit."""
    part, factor = task.part(task.now), task.factor(task.now)
    counted = (part >= NEGLIGIBLE) & task.free
    n = counted.sum(axis=1)
    s = task.now.copy()
    for g in np.flatnonzero(task.free):
        if not counted[:, g].any():
            continue  # counts nowhere: the common factors move it to its ceiling
        k = first_largest(part[:, g].tolist())
        a = task.law.first[k, g]
        b = task.law.second[k, g, g]
        wanted = (task.limit[k] / factor[k]) ** 2 / n[k]
        # a q + b q^2 = wanted, in the form that does not cancel where b is small.
        s[g] = np.sqrt(2.0 * wanted / (a + np.sqrt(a**2 + 4.0 * b * wanted)))
    return s
