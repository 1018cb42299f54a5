"""Correlated quantities of any shape: a Gaussian copula that meets their correlations.

Inputs x_i = F_i^-1(Phi(s_i)) of jointly normal scores s have the distributions F_i they
should have, and a joint one that is the normal one where they all are (JCGM 102:2011,
5.3.3, leaves the choice of a copula open). The correlation r of x_i and x_j is not that
of their scores, rho. With the coefficients a_k of x(s), in units of u, over Hermite
polynomials He_k(s)/sqrt(k!), Mehler's expansion of the normal density gives

    r(rho) = sum_k a_ik a_jk rho^k ,

which rises with rho; its ends at rho = -1 and 1 are all that the two shapes allow.
For uniform x it is r = 6/pi asin(rho/2).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isfinite, pi
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import LEAST, MOST, NORMAL
from budget.errors import ProblemError
from budget.problem import Group, checked_root

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.distributions import Distribution

TERMS = 200
REACH = 8.25  # of a score, where its probability is the least that a double has
PANELS, NODES = 512, 8  # of the quadrature over scores
BISECTIONS = 60
ROUNDING = 1e-9  # [1] of a correlation at the end of what the shapes allow


@dataclass(frozen=True, kw_only=True, eq=False)
class Copula(Group):
    """Correlated inputs of any shapes, drawn by a Gaussian copula.

    As a Group, of which it takes the place in a Problem; without a correlation, or of
    normal inputs alone, it is drawn as one. The law counts with its covariance.

    Raises
    ------
    ProblemError
        As of a Group, or the shapes cannot have the covariance.
    """

    def __post_init__(self) -> None:
        """Check the group, and that its shapes can have the covariance."""
        super().__post_init__()
        if self.is_joined:
            _ = self.scores_factor

    @cached_property
    def is_joined(self) -> bool:
        """Whether inputs are correlated that are not all normal."""
        return not self.is_independent and any(d != NORMAL for d in self.distributions)

    @property
    def drawn(self) -> tuple[Distribution, ...]:
        """Shapes of the independent variates that `deviations` takes."""
        return (NORMAL,) * self.size if self.is_joined else self.distributions

    @cached_property
    def scores_factor(self) -> Array:
        """Matrix L, shape (n, n): L z are the normal scores of the inputs [1].

        Raises
        ------
        ProblemError
            The shapes cannot have the covariance, two of them or all together.
        """
        where = f"input group {self.name!r}"
        needed = normal_scores(self.correlation, self.distributions, where=where)
        root, least = checked_root(needed, scale=np.ones(self.size))
        if root is None:
            raise ProblemError(
                f"{where}: a Gaussian copula of these shapes cannot have these "
                f"correlations: those of its scores have the eigenvalue {least:.3g}, "
                "expected 0 or more; make the correlations smaller"
            )
        return root

    def deviations(self, z: Array, out: Array | None = None) -> Array:
        """Return deviations from the mean, shape (n, trials) [SI]: see Group."""
        if not self.is_joined:
            return super().deviations(z, out)
        x = np.matmul(self.scores_factor, z, out=out)
        u = np.sqrt(np.diag(self.covariance))
        for u_x, shape, row in zip(u, self.distributions, x, strict=True):
            row[:] = u_x * quantiles_of_scores(shape, row)
        return np.asarray(x)


def quantiles_of_scores(shape: Distribution, scores: Array) -> Array:
    """Return F^-1(Phi(s)), same shape as the scores [u]."""
    from scipy.special import ndtr

    return shape.quantile(np.clip(ndtr(scores), LEAST, MOST))


def normal_scores(
    correlation: Array, shapes: tuple[Distribution, ...], *, where: str
) -> Array:
    """Return the correlations that normal scores need, shape (n, n) [1].

    Parameters
    ----------
    correlation : ndarray, shape (n, n)
        Of the quantities; 0 on the diagonal for those that do not vary.
    shapes : tuple of Distribution, length n
        Theirs.
    where : str
        What the quantities are, for messages.

    Raises
    ------
    ProblemError
        Two shapes do not allow a correlation, or a shape is not of the given u.
    """
    scores = np.array(correlation)
    is_correlated = np.asarray((scores - np.diag(np.diag(scores))).any(axis=1))
    for row, shape in enumerate(shapes):
        if isfinite(shape.degrees_of_freedom) and is_correlated[row]:
            raise ProblemError(
                f"{where}: input {row} is {shape.name}, whose standard deviation is "
                "not the u that its covariance counts with; take scaled_student_t for "
                "a correlated input"
            )
    is_normal = np.array([shape == NORMAL for shape in shapes])
    as_they_are = np.logical_and.outer(is_normal, is_normal)
    i, j = np.nonzero(np.triu(np.where(as_they_are, 0.0, correlation), k=1))
    if not i.size:
        return scores
    r = correlation[i, j]
    distinct = list(dict.fromkeys(shapes))
    place = np.array([distinct.index(shape) for shape in shapes])
    series, low, high = _expansions(distinct)
    a, b = place[i], place[j]
    worst = int(np.argmax(np.maximum(r - high[a, b], low[a, b] - r)))
    if not low[a, b][worst] - ROUNDING <= r[worst] <= high[a, b][worst] + ROUNDING:
        pair = (a[worst], b[worst])
        raise ProblemError(
            f"{where}: inputs {i[worst]} ({distinct[pair[0]].name}) and {j[worst]} "
            f"({distinct[pair[1]].name}) have the correlation {r[worst]:.4g}; two "
            f"quantities of these shapes can have {low[pair]:.4g} to {high[pair]:.4g}. "
            "Take a smaller one, or other shapes"
        )
    rho = _solve(series[a] * series[b], r, low[a, b], high[a, b])
    scores[i, j] = scores[j, i] = rho
    return scores


def _expansions(shapes: list[Distribution]) -> tuple[Array, Array, Array]:
    """Return coefficients a_1.. of each shape, and r(-1), r(1) of each pair."""
    node, weight = np.polynomial.legendre.leggauss(NODES)
    half = REACH / PANELS
    middles = np.linspace(-REACH + half, REACH - half, PANELS)
    s = (middles[:, None] + half * node).ravel()
    w = np.tile(half * weight, PANELS) * np.exp(-(s**2) / 2.0) / np.sqrt(2.0 * pi)
    x = np.stack([quantiles_of_scores(shape, s) for shape in shapes])
    x -= (x @ w)[:, None] / w.sum()
    x /= np.sqrt(x**2 @ w)[:, None]
    series = np.empty((len(shapes), TERMS))
    before, polynomial = np.zeros_like(s), np.ones_like(s)
    for k in range(1, TERMS + 1):
        before, polynomial = (
            polynomial,
            (s * polynomial - np.sqrt(k - 1.0) * before) / np.sqrt(k),
        )
        series[:, k - 1] = (x * polynomial) @ w
    return series, (x * w) @ x[:, ::-1].T, (x * w) @ x.T


def _solve(products: Array, r: Array, low: Array, high: Array) -> Array:
    """Return rho of every pair, shape (pairs,), by bisection.

    What the first terms leave out at rho = -1 and 1 is known: it stands, even and odd
    powers apart, at the first powers that are left out.
    """
    signs = (-1.0) ** np.arange(1, TERMS + 1)
    left_high, left_low = high - products.sum(axis=1), low - products @ signs
    odd, even = (left_high - left_low) / 2.0, (left_high + left_low) / 2.0
    c = np.column_stack([np.zeros(r.size), products, odd, even]).T
    below, above = -np.ones(r.size), np.ones(r.size)
    for _ in range(BISECTIONS):
        rho = 0.5 * (below + above)
        too_low = np.polynomial.polynomial.polyval(rho, c, tensor=False) < r
        below, above = np.where(too_low, rho, below), np.where(too_low, above, rho)
    return np.asarray(0.5 * (below + above))
