"""Shapes of input quantities: centred on 0, standard uncertainty 1, symmetric."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import ProblemError

if TYPE_CHECKING:
    from budget.arrays import Array


@dataclass(frozen=True)
class Distribution:
    """A probability density of unit standard uncertainty, JCGM 101:2008, 6.4.

    Attributes
    ----------
    name : str
        The word a device file uses.
    half_width : float
        Half-width over standard uncertainty, a/u [1]; infinite for the normal one.
    kurtosis : float
        Fourth central moment over u^4 [1]; the second-order law needs it.
    degrees_of_freedom : float
        Of a standard uncertainty from few readings; infinite where it is known.
    """

    name: str
    half_width: float
    kurtosis: float
    degrees_of_freedom: float = inf

    def quantile(self, p: Array) -> Array:
        """Return the inverse of the distribution function, same shape as p [u]."""
        if self.name == "normal":
            from scipy.special import ndtri

            return np.asarray(ndtri(p))
        if self.name == "student_t":
            from scipy.special import stdtrit

            return np.asarray(stdtrit(self.degrees_of_freedom, p))
        if self.name == "uniform":
            return np.asarray((2.0 * p - 1.0) * self.half_width)
        if self.name == "triangular":
            tail = np.minimum(p, 1.0 - p)
            return np.copysign(1.0 - np.sqrt(2.0 * tail), p - 0.5) * self.half_width
        if self.name == "arcsine":
            return np.asarray(np.sin(pi * (p - 0.5)) * self.half_width)
        raise ProblemError(
            f"there is no distribution {self.name!r}; take one of budget.distributions"
        )


NORMAL = Distribution("normal", inf, 3.0)
UNIFORM = Distribution("uniform", sqrt(3.0), 9.0 / 5.0)  # JCGM 100:2008, 4.3.7
TRIANGULAR = Distribution("triangular", sqrt(6.0), 12.0 / 5.0)  # JCGM 100:2008, 4.3.9
ARCSINE = Distribution("arcsine", sqrt(2.0), 3.0 / 2.0)  # JCGM 101:2008, 6.4.6


def student_t(degrees_of_freedom: float) -> Distribution:
    """Return the shape of a mean of few readings, s/sqrt(n) being its u.

    JCGM 101:2008, 6.4.9: the density is Student's t scaled by u. Its own standard
    deviation is larger than u, sqrt(v/(v - 2)) u, and infinite up to v = 2; the law of
    propagation counts u and carries v (JCGM 100:2008, G.4), as the guide does.

    Parameters
    ----------
    degrees_of_freedom : float
        v, above 0.

    Raises
    ------
    ProblemError
        v is not above 0.
    """
    if not degrees_of_freedom > 0.0:
        raise ProblemError(
            f"{degrees_of_freedom} degrees of freedom, expected a number above 0"
        )
    return Distribution("student_t", inf, 3.0, degrees_of_freedom)


# The shapes that a device file can name.
BY_NAME = {d.name: d for d in (NORMAL, UNIFORM, TRIANGULAR, ARCSINE)}
