"""Limits on several outputs together: their joint probability as one utilisation.

Errors e_i are within their limits L_i, all at once, with the probability p or more
where

    t <= 1 ,  t the p-quantile of max_i |e_i|/L_i ,

|e_i| of a length that of its vector. It is the utilisation that the verdict is by. Of
M trials t is the smallest ratio that p M of them or more do not exceed: it is 1 or less
exactly where the part of the trials that are within all limits is p or more.

With a covariance of which lines that are not given, or a use that nobody has stated,
add a part, t is counted in the same POINTS of the normal law for every size of it,

    t(w) = r t_law(C + sum of w_g C_g) ,  r = t(0)/t_law(C) ,

t(0) by what was judged: nothing added, it is that. As many plain draws would leave a
standard error of sqrt(p (1 - p)/POINTS)/(f t) (f the density of the ratios at t; of one
output at 95 % 0.5 %); these points are of low discrepancy, and err by some 0.1 %. The
larger a covariance, the smaller the probability of a convex region about its mean
(Anderson 1955): t grows with every w.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.arrays import root_of_correlation
from budget.methods.execution import BLOCK, small_blocks, stream
from budget.methods.largest import BATCH, SPACING, Ends
from budget.results import TINY
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.question import Limited

NORMAL_TRIALS = 16_384  # of the joint normal law, where there are no others
POINTS = 32_768  # that every size of what is added is counted in: a power of 2
# Added to the diagonal of a correlation, so that its root is Cholesky's, which moves
# with it, where outputs hang together; of a standard uncertainty half of it [1].
RIDGE = 1e-10


@dataclass(frozen=True, kw_only=True, eq=False)
class Components:
    """Required outputs, two components in the place of each length, over the limits."""

    rows: NDArray[np.intp]  # of the Problem, shape (n_components,)
    limits: Array  # shape (n_components,) [SI]
    pairs: NDArray[np.intp]  # places of the two of each length, shape (n_lengths, 2)
    mean: Array  # over the limits, shape (n_components,) [1]
    covariance: Array  # over them, shape (n_components, n_components) [1]

    def scaled(self, covariance: Array) -> Array:
        """Return these of covariances, shape (..., n_out, n_out), over the limits."""
        own = covariance[..., self.rows[:, None], self.rows[None, :]]
        return np.asarray(own / np.outer(self.limits, self.limits))


def components_of(held: Limited) -> Components:
    """Return the components of required outputs; lengths are the last of a Problem."""
    law = held.law
    places: list[int] = []
    each: list[float] = []
    pairs: list[tuple[int, int]] = []
    for row, length, limit in zip(held.rows, held.lengths, held.limits, strict=True):
        own = [row] if length < 0 else law.legs[:, length].tolist()
        if length >= 0:
            pairs.append((len(places), len(places) + 1))
        places += own
        each += [limit] * len(own)
    return Components(
        rows=np.array(places),
        limits=np.array(each),
        pairs=np.array(pairs, dtype=int).reshape(-1, 2),
        mean=law.mean[places] / each,
        covariance=law.covariance[np.ix_(places, places)] / np.outer(each, each),
    )


def ends_together(largest: Array, coverage: float, *, off: float = 0.0) -> Ends:
    """Return the utilisation of limits to be kept together, and how trials move it.

    One trial y moves the quantile q of probability p by (p - [y <= q])/(f M), f the
    density there, as of the ends of an output (budget.methods.largest).

    Parameters
    ----------
    largest : ndarray, shape (trials,)
        Largest |e_i|/L_i of every trial [1].
    coverage : float
        p [1].
    off : float, optional
        What the law that they are of can be off by [1].
    """
    M = largest.size
    place = max(ceil(settle(coverage * M)), 1) - 1
    reach = max(round((1.0 - coverage) * M * SPACING), 1)
    first, last = max(place - reach, 0), min(place + reach, M - 1)
    ordered = np.partition(largest, [first, place, last])
    slope = (ordered[last] - ordered[first]) / max(last - first, 1)  # 1/(f M)
    starts = np.arange(0, M, BATCH)
    size = np.diff(np.append(starts, M))
    below = np.add.reduceat(largest <= ordered[place], starts, dtype=float)
    moved = coverage * size - below
    # Counts of few batches are a rough variance; the binomial one is known.
    known = slope * sqrt(M * coverage * (1.0 - coverage))
    moved *= known / max(float(np.linalg.norm(moved)), TINY)
    return Ends(
        value=ordered[[place]], noise=moved[:, None], bound=np.full(1, float(off))
    )


def largest_of_normals(
    of: Components, *, seed: int, name: str, is_joint: bool
) -> Array:
    """Return the largest |e_i|/L_i of NORMAL_TRIALS draws of the law, (trials,) [1].

    Where it is asked for nothing but whether it is 1 or less, 0 of those within reach.
    """
    normals = _unit_normals(seed, name, of.rows.size)
    reach = normals.longest * np.sqrt(np.diag(of.covariance))
    is_far = not of.pairs.size and bool((np.abs(of.mean) + reach <= 1.0).all())
    if is_far and not is_joint:  # no draw gets out
        return np.zeros(NORMAL_TRIALS)
    return _largest(of, of.covariance, normals.z, root_of_correlation)


@dataclass(frozen=True, kw_only=True, eq=False)
class Jointly:
    """Utilisation of limits to be kept together, of what is given and more.

    Attributes
    ----------
    of : Components
        Of what was judged.
    rest : ndarray, shape (n_components, n_components)
        Covariance of all that is given [1].
    parts : ndarray, shape (n_groups, n_components, n_components)
        What each group adds [1].
    coverage : float
        Probability that all limits are to be kept together with [1].
    known : tuple of (ndarray, float)
        Times that the groups count, and the utilisation that was judged there: of what
        is given, and with all lines at their ceilings where that was judged, too.
    """

    of: Components
    rest: Array
    parts: Array
    coverage: float
    known: tuple[tuple[Array, float], ...]

    def used(self, weights: Array) -> float:
        """Return the utilisation with groups at so many times their variance [1]."""
        by_law, ratios = self._ratios
        t = self.by_law(weights)
        return t * float(np.interp(t, by_law, ratios))

    def by_law(self, weights: Array) -> float:
        """Return the same of the normal law of these covariances [1]."""
        C = self.rest + np.tensordot(weights, self.parts, axes=1)
        largest = _largest(self.of, C, normal_points(self.of.rows.size), _steady_root)
        return ends_together(largest, self.coverage).largest

    @cached_property
    def _ratios(self) -> tuple[list[float], list[float]]:
        """Return the law's utilisations of what is known, and what it is over them."""
        by_law = [self.by_law(weights) for weights, _ in self.known]
        judged = [used for _, used in self.known]
        return by_law, [a / max(b, TINY) for a, b in zip(judged, by_law, strict=True)]


@lru_cache(maxsize=4)
def normal_points(n: int) -> Array:
    """Return points of n independent normals, of low discrepancy, (n, POINTS).

    Sobol's points, in the middle of their intervals, through the inverse distribution.
    """
    from scipy.special import ndtri
    from scipy.stats.qmc import Sobol

    found = ndtri(Sobol(n, scramble=False).random(POINTS).T + 0.5 / POINTS)
    found = np.ascontiguousarray(found)
    found.flags.writeable = False
    return found


def _steady_root(R: Array) -> Array:
    """Return a root that moves with a correlation matrix, which may be singular."""
    try:
        return np.asarray(np.linalg.cholesky(R + RIDGE * np.eye(len(R))))
    except np.linalg.LinAlgError:  # by more than rounding not semidefinite
        return root_of_correlation(R)


def _largest(
    of: Components, C: Array, z: Array, root: Callable[[Array], Array]
) -> Array:
    """Return the largest |e_i|/L_i at each of the points, shape (n_points,) [1].

    A length in the place of its two; scaled by the limits the box is the unit cube.
    """
    u = np.sqrt(np.maximum(np.diag(C), 0.0))
    safe = np.where(u > 0.0, u, 1.0)
    factor = u[:, None] * root(C / np.outer(safe, safe))
    found = np.empty(z.shape[1])
    with small_blocks():
        for start in range(0, found.size, BLOCK):  # blocks stay in the cache
            y = factor @ z[:, start : start + BLOCK]
            y += of.mean[:, None]
            for a, b in of.pairs:
                y[a] = np.hypot(y[a], y[b])
                y[b] = 0.0
            found[start : start + BLOCK] = np.abs(y, out=y).max(axis=0)
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Normals:
    """Independent unit normals that all devices with one kind of sensor share."""

    z: Array  # shape (n, NORMAL_TRIALS)
    longest: float  # the largest norm of a draw


@lru_cache(maxsize=4)
def _unit_normals(seed: int, sensor: str, n: int) -> _Normals:
    """Draw unit normals for n outputs; those of two sensors are independent."""
    rng = stream(seed, f"joint conformance {sensor}", 0)
    z = rng.standard_normal((n, NORMAL_TRIALS))
    z.flags.writeable = False
    return _Normals(z=z, longest=float(np.sqrt((z**2).sum(axis=0).max())))
