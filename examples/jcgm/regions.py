"""Joint coverage regions of several outputs: JCGM 102:2011, 6.5 and 7.7.

Intervals of single outputs at 95 % hold all of them together in fewer than 95 % of
cases. A region holds them all at once: an ellipsoid, a box with one factor on every
standard uncertainty, or the cells of a mesh in which most trials lie.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil, exp, lgamma, log, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError, ProblemError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from budget.arrays import Array

# Of a correlation matrix: outputs that are one another's combinations span no volume.
LEAST_EIGENVALUE = 1e-10  # [1]
LEAST_PER_CELL = 100.0  # trials, on average: fewer, and chance chooses the cells
LEAST_CELLS = 10  # along an output: a region of fewer has no form


@dataclass(frozen=True, kw_only=True, eq=False)
class Ellipsoid:
    """Points with (y - m)^T U^-1 (y - m) <= k^2.

    Attributes
    ----------
    coverage : float
        Probability of the region [1].
    mean : ndarray, shape (n_out,)
        m, its centre [SI].
    covariance : ndarray, shape (n_out, n_out)
        U [SI squared].
    factor : float
        k_p of JCGM 102:2011, 7.7.2 [1].
    """

    coverage: float
    mean: Array
    covariance: Array
    factor: float

    def contains(self, points: ArrayLike) -> Array:
        """Return whether points, shape (n_out, n), lie in it: bool, shape (n,)."""
        y = np.asarray(points, dtype=float)
        return np.asarray(_distance(y, self.mean, self.covariance) <= self.factor)

    @property
    def volume(self) -> float:
        """Volume, in two dimensions area [product of the units of the outputs]."""
        n = self.mean.size
        unit_ball = exp(n / 2.0 * log(pi) - lgamma(n / 2.0 + 1.0))
        root = sqrt(float(np.linalg.det(_correlation(self.covariance))))
        u = np.sqrt(np.diag(self.covariance))
        return unit_ball * root * float(np.prod(self.factor * u))


@dataclass(frozen=True, kw_only=True, eq=False)
class Box:
    """Points with |y_j - m_j| <= k u_j for every output.

    Attributes
    ----------
    coverage : float
        Probability of the region [1].
    mean, u : ndarray, shape (n_out,)
        Centre and standard uncertainties [SI].
    factor : float
        k_q of JCGM 102:2011, 7.7.3 [1].
    """

    coverage: float
    mean: Array
    u: Array
    factor: float

    def contains(self, points: ArrayLike) -> Array:
        """Return whether points, shape (n_out, n), lie in it: bool, shape (n,)."""
        y = np.asarray(points, dtype=float)
        return np.asarray(_largest(y, self.mean, self.u) <= self.factor)

    @property
    def interval(self) -> Array:
        """Its sides, shape (n_out, 2) [SI]."""
        U = self.factor * self.u
        return np.stack([self.mean - U, self.mean + U], axis=1)

    @property
    def volume(self) -> float:
        """Volume, in two dimensions area [product of the units of the outputs]."""
        return float(np.prod(2.0 * self.factor * self.u))


@dataclass(frozen=True, kw_only=True, eq=False)
class Cells:
    """The fullest cells of a mesh over all trials: about the smallest region.

    Attributes
    ----------
    coverage : float
        Part of the trials in the cells, at least what was asked [1].
    low, width : ndarray, shape (n_out,)
        Lower corner of the mesh and sides of a cell [SI].
    per_axis : int
        Cells along each output.
    chosen : ndarray of int, shape (n_cells,)
        Cells of the region, by their place in the mesh (last output fastest).
    """

    coverage: float
    low: Array
    width: Array
    per_axis: int
    chosen: NDArray[np.intp] = field(repr=False)

    def contains(self, points: ArrayLike) -> Array:
        """Return whether points, shape (n_out, n), lie in it: bool, shape (n,)."""
        y = np.asarray(points, dtype=float)
        place = (y - self.low[:, None]) / self.width[:, None]
        # The largest trial lies on the upper end of its cell.
        on_mesh = ((place >= 0.0) & (place <= self.per_axis)).all(axis=0)
        cells = _cells(np.where(on_mesh, place, 0.0), self.per_axis)
        return np.asarray(on_mesh & np.isin(cells, self.chosen))

    @property
    def volume(self) -> float:
        """Volume, in two dimensions area [product of the units of the outputs]."""
        return float(self.chosen.size * np.prod(self.width))


def ellipsoid_region(trials: ArrayLike, coverage: float = 0.95) -> Ellipsoid:
    """Return the ellipsoid that contains a part of all trials: JCGM 102:2011, 7.7.2.

    Parameters
    ----------
    trials : array_like, shape (n_out, M)
        Of the outputs, as `methods.trials.first_trials` returns them [SI].
    coverage : float
        p, above 0 and below 1.

    Returns
    -------
    Ellipsoid

    Raises
    ------
    CallError
        The trials are no such array, or p is not a probability.
    ProblemError
        An output is a linear combination of others, so that there is no volume.
    """
    y = _trials(trials, coverage)
    mean, covariance = y.mean(axis=1), np.cov(y).reshape(len(y), len(y))
    return Ellipsoid(
        coverage=coverage,
        mean=mean,
        covariance=covariance,
        factor=_quantile(_distance(y, mean, covariance), coverage),
    )


def normal_region(
    mean: ArrayLike, covariance: ArrayLike, coverage: float = 0.95
) -> Ellipsoid:
    """Return the ellipsoid of jointly normal outputs: k_p^2 is chi-squared.

    JCGM 102:2011, 6.5.3. For what the law of propagation gives.

    Parameters
    ----------
    mean : array_like, shape (n_out,)
        [SI].
    covariance : array_like, shape (n_out, n_out)
        [SI squared].
    coverage : float
        p, above 0 and below 1.

    Raises
    ------
    CallError
        p is not a probability, or the shapes do not fit.
    ProblemError
        An output is a linear combination of others, so that there is no volume.
    """
    from scipy.special import chdtri

    _check_coverage(coverage)
    m, U = np.array(mean, dtype=float), np.array(covariance, dtype=float)
    if m.ndim != 1 or not m.size or U.shape != (m.size, m.size):
        raise CallError(
            f"mean has shape {m.shape}, covariance {U.shape}; expected (n,) and (n, n)"
        )
    _root(U)
    factor = sqrt(float(chdtri(m.size, 1.0 - coverage)))
    return Ellipsoid(coverage=coverage, mean=m, covariance=U, factor=factor)


def box_region(trials: ArrayLike, coverage: float = 0.95) -> Box:
    """Return the box m_j +- k_q u_j that contains a part of all trials: 7.7.3.

    Parameters, errors as of `ellipsoid_region`; outputs may depend on each other.

    Returns
    -------
    Box
    """
    y = _trials(trials, coverage)
    mean, u = y.mean(axis=1), y.std(axis=1, ddof=1)
    return Box(
        coverage=coverage,
        mean=mean,
        u=u,
        factor=_quantile(_largest(y, mean, u), coverage),
    )


def smallest_region(trials: ArrayLike, coverage: float = 0.95) -> Cells:
    """Return about the smallest region that contains a part of all trials: 7.7.4.

    A mesh of equal cells is laid over all trials, and cells are taken from the fullest
    on until they hold enough. For a density of any form, with several tops too.

    Parameters, errors as of `ellipsoid_region`; there must be trials enough for 100 in
    a cell on average, with 10 cells along every output. Chance has a part in which
    cells are fullest, so that fresh trials lie in them a little less often.

    Returns
    -------
    Cells
    """
    y = _trials(trials, coverage)
    n, M = y.shape
    per_axis = int((M / LEAST_PER_CELL) ** (1.0 / n) * (1.0 + 1e-12))
    if per_axis < LEAST_CELLS:
        raise CallError(
            f"{M} trials of {n} outputs are too few for a mesh: with {LEAST_CELLS} "
            f"cells along each it takes {LEAST_PER_CELL * LEAST_CELLS**n:.0f}; make "
            "more, choose fewer outputs, or take an ellipsoid or a box"
        )
    low = y.min(axis=1)
    width = (y.max(axis=1) - low) / per_axis
    if (width == 0.0).any():
        raise ProblemError(
            f"output {int(np.argmin(width))} of the trials does not vary; leave it out"
        )
    cells = _cells((y - low[:, None]) / width[:, None], per_axis)
    counts = np.bincount(cells, minlength=per_axis**n)
    fullest = np.argsort(-counts, kind="stable")
    held = np.cumsum(counts[fullest])
    taken = int(np.searchsorted(held, _rank(M, coverage))) + 1
    return Cells(
        coverage=float(held[taken - 1]) / M,
        low=low,
        width=width,
        per_axis=per_axis,
        chosen=np.sort(fullest[:taken]),
    )


def _trials(trials: ArrayLike, coverage: float) -> Array:
    """Return trials as an array, shape (n_out, M)."""
    _check_coverage(coverage)
    y = np.asarray(trials, dtype=float)
    least = 2.0 / (1.0 - coverage)
    if y.ndim != 2 or not len(y) or not np.isfinite(y).all():  # noqa: PLR2004
        raise CallError(
            f"trials have shape {y.shape}; expected finite numbers of shape "
            "(n_outputs, M), as budget.first_trials returns them"
        )
    if y.shape[1] < max(least, len(y) + 1):
        raise CallError(
            f"{y.shape[1]} trials are too few for a region of {coverage:g} of "
            f"{len(y)} outputs; the least is {ceil(max(least, len(y) + 1))}"
        )
    return y


def _check_coverage(coverage: float) -> None:
    if not 0.0 < coverage < 1.0:
        raise CallError(f"coverage is {coverage!r}, allowed: above 0 and below 1")


def _rank(M: int, coverage: float) -> int:
    """Return how many of M trials are the part p: 7.7.1 of JCGM 101:2008."""
    return min(max(int(M * coverage + 0.5), 1), M)


def _quantile(distances: Array, coverage: float) -> float:
    """Return the distance within which the part p of them is."""
    rank = _rank(distances.size, coverage) - 1
    return float(np.partition(distances, rank)[rank])


def _distance(y: Array, mean: Array, covariance: Array) -> Array:
    """Return Mahalanobis distances of points from the mean, shape (n,) [1]."""
    u = np.sqrt(np.diag(covariance))[:, None]
    z = np.linalg.solve(_root(covariance), (y - mean[:, None]) / u)
    return np.asarray(np.sqrt((z**2).sum(axis=0)))


def _largest(y: Array, mean: Array, u: Array) -> Array:
    """Return the largest |y_j - m_j|/u_j of each point, shape (n,) [1]."""
    if not (u > 0.0).all():
        raise ProblemError(f"output {int(np.argmin(u))} does not vary; leave it out")
    return np.asarray((np.abs(y - mean[:, None]) / u[:, None]).max(axis=0))


def _correlation(covariance: Array) -> Array:
    """Return the correlation matrix of outputs that all vary."""
    u = np.sqrt(np.diag(covariance))
    if not (u > 0.0).all():
        raise ProblemError(f"output {int(np.argmin(u))} does not vary; leave it out")
    return np.asarray(covariance / np.outer(u, u))


def _root(covariance: Array) -> Array:
    """Return the Cholesky factor of the correlation matrix, shape (n_out, n_out)."""
    R = _correlation(covariance)
    values, vectors = np.linalg.eigh(R)
    if values[0] < LEAST_EIGENVALUE:
        involved = np.flatnonzero(np.abs(vectors[:, 0]) > sqrt(LEAST_EIGENVALUE))
        raise ProblemError(
            f"outputs {', '.join(map(str, involved))} (counted from 0) are linearly "
            "dependent: an ellipsoid of them has no volume. Leave one of them out, or "
            "take a box"
        )
    return np.asarray(np.linalg.cholesky(R))


def _cells(place: Array, per_axis: int) -> NDArray[np.intp]:
    """Return the number of the cell of each point, shape (n,)."""
    steps = np.minimum(place.astype(np.intp), per_axis - 1)
    return np.asarray(np.ravel_multi_index(tuple(steps), (per_axis,) * len(steps)))
