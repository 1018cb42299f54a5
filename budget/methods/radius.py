"""Radius of the circle that a plane normal vector lies in with a given probability.

With the variances a >= b along the principal axes of its covariance, x = R sin t along
the first and h = R cos t across it (Hoyt 1947, in another form),

    P(R) = 2 int_0^(pi/2) phi(x/sqrt a)/sqrt a erf(h/sqrt(2 b)) h dt ,

phi the unit normal density; CEP at P = 50 %, R95 at 95 %. Equal variances give
R = sigma sqrt(-2 ln(1 - P)), one variance alone the normal law's; the two bracket all
others.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from budget.arrays import Array

POINTS = 128  # of Gauss and Legendre on a quarter turn
STEPS = 60  # at the most, halvings to the rounding of a double; mostly six of Newton
SAME = 4e-16  # relative, of a step that changes nothing [1]
LEAST = 1e-12  # ratio of variances that a density is taken for at the least [1]
SQRT2, SQRT_PI = np.sqrt(2.0), np.sqrt(np.pi)


def principal_variances(first: Array, second: Array, between: Array) -> Array:
    """Return a >= b of covariances [[first, between], [between, second]], (2, n)."""
    middle, half = (first + second) / 2.0, np.hypot((first - second) / 2.0, between)
    larger = middle + half
    # Their product is the determinant: no small difference of large numbers.
    determinant = np.maximum(first * second - between**2, 0.0)
    smaller = determinant / np.where(larger > 0.0, larger, 1.0)
    return np.stack([larger, np.minimum(smaller, larger)])


def probability_within(radius: Array, variances: Array) -> Array:
    """Return P(R), shape (n,) [1], for radii (n,) and variances a, b, shape (2, n)."""
    from scipy.special import erf

    t, weights = _nodes()
    long, wide = SQRT2 * np.sqrt(variances)
    safe = np.where(long > 0.0, long, 1.0)
    x = np.multiply.outer(radius / safe, np.sin(t))
    h = np.multiply.outer(radius / safe, np.cos(t))
    narrow = np.where(wide > 0.0, wide, 1.0)[:, None]
    across = np.where(wide[:, None] > 0.0, erf(h * safe[:, None] / narrow), 1.0)
    inside = np.exp(-(x**2)) * across * h @ weights * (2.0 / SQRT_PI)
    return np.where(long > 0.0, inside, 1.0)


def density_at(radius: Array, variances: Array) -> Array:
    """Return dP/dR, shape (n,), for variances with a > 0; of Newton's steps.

    R/sqrt(ab) exp(-R^2 (a + b)/(4ab)) I0(R^2 (a - b)/(4ab)): Hoyt's density.
    """
    from scipy.special import ive

    a = np.where(variances[0] > 0.0, variances[0], 1.0)
    b = np.maximum(variances[1], LEAST * a)
    bend = ive(0, radius**2 * (a - b) / (4.0 * a * b))
    return np.asarray(radius / np.sqrt(a * b) * np.exp(-(radius**2) / (2.0 * a)) * bend)


def radius_of(coverage: ArrayLike, variances: Array) -> Array:
    """Return the radii of circles of a coverage, shape (n,) [root of the variances].

    Parameters
    ----------
    coverage : float or ndarray, shape (n,)
        Above 0 and below 1.
    variances : ndarray, shape (2, n)
        Of principal_variances.
    """
    from scipy.special import ndtri

    p = np.broadcast_to(np.asarray(coverage, dtype=float), variances.shape[1:])
    size = np.sqrt(variances[0])
    ratio = variances / np.where(size > 0.0, size, 1.0) ** 2
    low, high = ndtri((1.0 + p) / 2.0), np.sqrt(-2.0 * np.log1p(-p))
    radius = (low + high) / 2.0
    for _ in range(STEPS):
        short = p - probability_within(radius, ratio)
        low = np.where(short > 0.0, radius, low)
        high = np.where(short > 0.0, high, radius)
        newton = radius + short / density_at(radius, ratio)
        # A step beyond the bracket is halved.
        is_inside = (newton >= low) & (newton <= high)
        before, radius = radius, np.where(is_inside, newton, (low + high) / 2.0)
        if (np.abs(radius - before) <= SAME * radius).all():
            break
    return np.asarray(size * radius)


def circles(
    covariance: Array, legs: NDArray[np.intp], coverage: float | Array
) -> Array:
    """Return the radii of circles of a coverage, shape (n_lengths,).

    Parameters
    ----------
    covariance : ndarray, shape (n_out, n_out)
    legs : ndarray of int, shape (2, n_lengths)
        Rows of the two components of each length.
    coverage : float, or ndarray of shape (n_lengths,)
        Above 0 and below 1.
    """
    return radius_of(coverage, plane_variances(covariance, legs))


def plane_variances(covariance: Array, legs: NDArray[np.intp]) -> Array:
    """Return the principal variances of each length, shape (2, ..., n_lengths).

    Of covariances (..., n_out, n_out) and legs as of `circles`.
    """
    a, b = legs
    U = covariance
    return principal_variances(U[..., a, a], U[..., b, b], U[..., a, b])


@lru_cache(maxsize=1)
def _nodes() -> tuple[Array, Array]:
    """Return angles from 0 to a quarter turn, and their weights [rad]."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    return (nodes + 1.0) * (np.pi / 4.0), weights * (np.pi / 4.0)
