"""Predictive mixture: errors over the predicted values of lines not given.

Of given sizes s of the missing lines the errors are normal, with the covariance

    V(s) = V_0 + sum_m C_m (s_m/median_m)^2,

C_m being what a line makes at its median, V_0 all the rest, with products of two lines
as they are at the medians. Over s, with ln s of a joint Student t
(budget.missing.prediction), an interval or a circle holds with the mean of its
probabilities: the radius R of a coverage p solves

    E_s[ P(|e| < R given V(s)) ] = p.

In a plane with the variances a >= b along its principal axes e is r (sqrt a cos t,
sqrt b sin t), r^2/2 exponential and t uniform, so that

    P(R) = 1 - (2/pi) int_0^(pi/2) exp(-R^2/(2 (a cos^2 t + b sin^2 t))) dt ,

and of one component alone erf(R/sqrt(2 a)). E[s^2] of a log-t is infinite: the mixture
has no variance, and its standard uncertainty is half of its interval of 68.3 %, which
is u where nothing is missing. The points s are those of budget.studies.doubt.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import exp, log, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import small_blocks
from budget.methods.gum import covariance_by_source
from budget.methods.radius import principal_variances, radius_of
from budget.missing.prediction import stand_in
from budget.names import Name
from budget.results import INTERACTION
from budget.studies.doubt import squared_lines

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.question import Question

# Probability that a normal error is within its standard uncertainty [1].
ONE_SIGMA = 0.6826894921370859
NODES = 24  # of Gauss and Legendre on a quarter turn
TOGETHER = 8  # draws of like size, that are taken as one
STEPS = 60  # at the most, of Newton; mostly five
SAME = 1e-12  # relative, of a step that changes nothing [1]
FURTHEST = 2.0  # step of the logarithm of a radius
LEAST = 1e-12  # slope, and variance over that of the medians, not to divide by 0 [1]
LARGEST = 700.0  # exponent of a double
MOST = 1e100  # square of a line over its median, for a product of two of them [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Mixture:
    """What lines that are not given may be, for the errors that they make."""

    sources: tuple[Name, ...]
    squared: Array  # draws of squared lines over their medians, (n_missing, n) [1]

    @classmethod
    def of(cls, question: Question) -> Mixture | None:
        """Return that of a mission; None where no line of it is predicted."""
        prediction = question.filled.prediction
        if prediction is None or question.journey is None:
            return None
        with small_blocks():
            squared = squared_lines(prediction, range(len(prediction.names)))
        return cls(
            sources=tuple(
                Name(stand_in(name).name, owner=name.owner) for name in prediction.names
            ),
            squared=np.minimum(squared, MOST),
        )

    def radius(self, coverage: float, sources: Sequence[Name], each: Array) -> Array:
        """Return radii that hold with a coverage, shape (n,) [root of `each`].

        Parameters
        ----------
        coverage : float
        sources : sequence of Name
        each : ndarray, shape (n_sources, 3, n)
            What every source makes, of predicted ones at the median: the two variances
            and the covariance in a plane; of one component the first, and 0.
        """
        total = each.sum(axis=0)
        found = radius_of(coverage, principal_variances(*total))
        places = [k for k, name in enumerate(sources) if name in self.sources]
        rows = [self.sources.index(sources[k]) for k in places]
        parts, squared = each[places], self.squared[rows]
        for k in np.flatnonzero(parts.any(axis=(0, 1)) & (found > 0.0)).tolist():
            size = total[:2, k].sum()
            own = parts[:, :, k] / size
            rest = total[:, k] / size - own.sum(axis=0)
            with small_blocks():
                drawn = rest[:, None] + own.T @ squared
            first, second = np.maximum(drawn[:2], 0.0)
            variances = principal_variances(first, second, drawn[2])
            start = float(found[k]) / sqrt(size)
            found[k] = sqrt(size) * _radius(coverage, variances, start)
        return found

    def half_widths(self, coverage: float, question: Question) -> Array:
        """Return those of symmetric intervals of all outputs, shape (n_out,) [SI].

        Of a length the radius; of what no missing line reaches, k u of the law.
        """
        problem, law = question.problem, question.law
        each = covariance_by_source(problem, law)
        alone = np.zeros((len(each), 3, each.shape[1]))
        alone[:, 0] = np.einsum("kii->ki", each)
        a, b = problem.legs
        plane = np.stack([each[:, a, a], each[:, b, b], each[:, a, b]], axis=1)
        names = (*law.sources, INTERACTION)
        found = self.radius(coverage, names, np.concatenate([alone, plane], axis=2))
        missing = [k for k, name in enumerate(law.sources) if name in self.sources]
        return np.where(
            law.source_variance[missing].any(axis=0),
            found,
            law.coverage_factor(coverage) * law.standard_uncertainty,
        )


def _radius(coverage: float, variances: Array, start: float) -> float:
    """Return the radius of a mixture of variances a, b, shape (2, n), from a guess."""
    variances = _condensed(variances)
    at, low, high = log(start), -np.inf, np.inf
    for _ in range(STEPS):
        inside, slope = _within(exp(at), variances)
        short = coverage - inside
        step = float(np.clip(short / max(slope, LEAST), -FURTHEST, FURTHEST))
        if abs(step) <= SAME:
            break
        low, high = (at, high) if step > 0.0 else (low, at)
        # A step beyond the bracket is halved.
        at = at + step if low < at + step < high else (low + high) / 2.0
    return exp(at)


def _condensed(variances: Array) -> Array:
    """Return draws by their size, so many as one: of the mean of ln a and of b/a.

    P is smooth in both, so what that changes is of second order in their differences.
    """
    a, b = variances[:, np.argsort(variances[0], kind="stable")]
    a = np.maximum(a, LEAST**2)
    middle = np.exp(np.log(a).reshape(-1, TOGETHER).mean(axis=1))
    return np.stack([middle, middle * (b / a).reshape(-1, TOGETHER).mean(axis=1)])


def _within(radius: float, variances: Array) -> tuple[float, float]:
    """Return the mean probability within a radius, and dP/d ln R [1]."""
    from scipy.special import erf

    if not variances[1].any():
        z = radius / np.sqrt(variances[0])
        density = sqrt(2.0 / np.pi) * z * np.exp(-0.5 * z * z)
        return float(erf(z / sqrt(2.0)).mean()), float(density.mean())
    squares, weights = _nodes()
    s2 = variances[0][:, None] * squares + variances[1][:, None] * (1.0 - squares)
    x = np.minimum(radius**2 / (2.0 * s2), LARGEST)
    beyond = np.exp(-x)
    outside = (beyond @ weights).mean()
    return float(1.0 - outside), float(((2.0 * x * beyond) @ weights).mean())


@lru_cache(maxsize=1)
def _nodes() -> tuple[Array, Array]:
    """Return cos^2 of angles on a quarter turn, and their weights, of sum 1."""
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    return np.cos((nodes + 1.0) * (np.pi / 4.0)) ** 2, weights / 2.0
