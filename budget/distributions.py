"""Shapes of input quantities: expectation 0, standard uncertainty 1.

A shape is a quantile function with its moments. Estimate and standard uncertainty are
the Group's, so a shape has only the parameters that change its form.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, pi, sqrt
from statistics import NormalDist
from typing import TYPE_CHECKING, overload

import numpy as np

from budget.errors import moved

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable

    from numpy.typing import ArrayLike

    from budget.arrays import Array

LEAST = 2.0**-54  # of a probability whose quantile is taken: at 0 it may be infinite
MOST = 1.0 - 2.0**-53  # the largest double below 1
# Of coverage intervals: below the least an interval is a point, above the most its ends
# hang on digits of the probability that a double does not have.
LEAST_COVERAGE, MOST_COVERAGE = 1e-6, 0.999999999999
COVERAGES = "from 1e-6 to 1 - 1e-12 (0.0001 % to 99.9999999999 %)"
BISECTIONS = 64  # of an interval in a double: 64 halvings leave its rounding


def is_coverage(value: float) -> bool:
    """Whether intervals of this probability can be computed; nan is none."""
    return LEAST_COVERAGE <= value <= MOST_COVERAGE


@dataclass(frozen=True)
class Distribution:
    """A probability density of expectation 0 and unit standard uncertainty.

    Attributes
    ----------
    name : str
        The word a device file uses, or what the shape is called.
    half_width : float
        Half the length of the support over standard uncertainty, a/u [1]; infinite
        where there is no end on one side.
    kurtosis : float
        Fourth central moment over u^4 [1]; the second-order law needs it.
    function : callable, (p, *parameters) -> array
        Its quantile function: a function at the top of a module, so that shapes can be
        sent to other processes and compared.
    parameters : tuple
        What the function takes beside p.
    degrees_of_freedom : float
        Of a standard uncertainty from few readings; infinite where it is known.
    skewness : float
        Third central moment over u^3 [1]; 0 where the shape is symmetric.
    """

    name: str
    half_width: float
    kurtosis: float
    function: Callable[..., Array] = field(repr=False)
    parameters: tuple[Hashable, ...] = field(default=(), repr=False)
    degrees_of_freedom: float = inf
    skewness: float = 0.0

    def quantile(self, p: Array) -> Array:
        """Return the inverse of the distribution function, same shape as p [u]."""
        return np.asarray(self.function(p, *self.parameters), dtype=float)

    def probability(self, x: ArrayLike) -> Array:
        """Return the distribution function, P(X <= x), same shape as x; x is in u.

        By bisection of the quantile function, to the rounding of a double; the normal
        one by its own function, exact far out.
        """
        x = np.asarray(x, dtype=float)
        if self == NORMAL:
            from scipy.special import ndtr

            return np.asarray(ndtr(x))
        low, high = np.zeros(x.shape), np.ones(x.shape)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            below = self.quantile(np.clip(middle, LEAST, MOST)) <= x
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.where(x == inf, 1.0, np.where(x == -inf, 0.0, 0.5 * (low + high)))


@overload
def normal_coverage_factor(coverage: float) -> float: ...
@overload
def normal_coverage_factor(coverage: Array) -> Array: ...
@overload
def normal_coverage_factor(coverage: float | Array) -> float | Array: ...
def normal_coverage_factor(coverage: float | Array) -> float | Array:
    """Return k with which a normal error is within k u with that probability [1]."""
    if np.ndim(coverage) == 0:  # without scipy, which takes long to load
        return NormalDist().inv_cdf((1.0 + float(coverage)) / 2.0)
    each = [normal_coverage_factor(one) for one in np.ravel(coverage).tolist()]
    return np.reshape(each, np.shape(coverage))


def _normal(p: Array) -> Array:
    """JCGM 101:2008, 6.4.7."""
    from scipy.special import ndtri

    return np.asarray(ndtri(p))


def _uniform(p: Array) -> Array:
    """JCGM 101:2008, 6.4.2."""
    return (2.0 * p - 1.0) * sqrt(3.0)


def _triangular(p: Array) -> Array:
    """JCGM 101:2008, 6.4.5."""
    return np.copysign(1.0 - np.sqrt(2.0 * np.minimum(p, 1.0 - p)), p - 0.5) * sqrt(6.0)


def _arcsine(p: Array) -> Array:
    """JCGM 101:2008, 6.4.6."""
    return np.sin(pi * (p - 0.5)) * sqrt(2.0)


NORMAL = Distribution("normal", inf, 3.0, _normal)
UNIFORM = Distribution("uniform", sqrt(3.0), 9.0 / 5.0, _uniform)  # JCGM 100, 4.3.7
# JCGM 100:2008, 4.3.9
TRIANGULAR = Distribution("triangular", sqrt(6.0), 12.0 / 5.0, _triangular)
ARCSINE = Distribution("arcsine", sqrt(2.0), 3.0 / 2.0, _arcsine)

# The shapes that a device file can name.
BY_NAME = {d.name: d for d in (NORMAL, UNIFORM, TRIANGULAR, ARCSINE)}

MOVED = [
    "student_t",
    "scaled_student_t",
    "trapezoidal",
    "curvilinear_trapezoid",
    "lognormal",
    "gamma",
    "EXPONENTIAL",
    "beta",
    "samples",
    "from_quantile",
]

if not TYPE_CHECKING:  # where a module has __getattr__, mypy believes in every name

    def __getattr__(name: str) -> object:
        """Say where the shapes are that stood here."""
        if name in MOVED:
            raise moved(name, __name__)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
