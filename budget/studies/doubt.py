"""Doubt in a verdict that rests on predicted lines, and which line to ask for.

Of given sizes s of the missing lines, by the law of propagation with the coverage
factor k of each output as it was judged, a device meets where

    |mean| + k sqrt(V_0 + sum_m c_m s_m^2) <= limit   of every required output,

c_m being the variance that a missing line of size 1 makes, and V_0 all the rest, with
products of two lines as they are at the medians. With ln s of a joint Student t
(budget.missing.prediction), p = P(meets) and the doubt is D = min(p, 1 - p), the risk
of the likelier verdict. Knowledge of line m is worth

    D(p) - E[ D( P(meets | s_m) ) ] >= 0,

the expected value of partial perfect information of that loss, by strata of s_m as in
Strong, Oakley 2013. The points are those of a Kronecker sequence, the
same for all devices: the same numbers on every machine.
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
from budget.results import INTERACTION, Ask, Doubt
from budget.ties import from_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.missing.prediction import Prediction
    from budget.question import Limited, Question
    from budget.studies.judgement import Judged

STRATA = 64  # of equal probability, of the line that becomes known
POINTS = 2**15  # in all of them
STRIDE = 4  # every so manieth point is enough for a range


def doubt_of(prediction: Prediction, held: Limited, judged: Judged) -> Doubt | None:
    """Return the probability to meet, and what each missing line is worth.

    None where the given lines are beyond a limit by themselves: nothing is in doubt.

    Parameters
    ----------
    prediction : Prediction
        Of the missing lines.
    held, judged
        With the lines at the medians of the prediction.
    """
    unit, room = rooms(prediction, held, judged)
    if (room < 0.0).any():
        return None
    ends = np.column_stack(
        [np.abs(held.mean), judged.factor, held.limits, unit.T, room]
    )
    # Equal axes are looked at once.
    unlike = {tuple(map(settle, row)): k for k, row in enumerate(ends.tolist())}
    kept = sorted(unlike.values())
    with small_blocks():
        p, reductions = weigh(prediction, unit[:, kept], room[kept])
        used = _range(prediction, ends[kept])
    return Doubt(
        probability=p,
        utilisation_90=used,
        asks=tuple(
            Ask(source=prediction.names[m], reduction=reductions[m])
            for m in from_largest(reductions)
        ),
    )


def rooms(prediction: Prediction, held: Limited, judged: Judged) -> tuple[Array, Array]:
    """Return what missing lines do to the outputs, and what these have room for.

    Returns
    -------
    ndarray, shape (n_missing, n_required)
        Variance for a line at its median [SI squared].
    ndarray, shape (n_required,)
        Variance that all of them may make together; below 0 where the other lines are
        beyond the limit by themselves [SI squared].
    """
    places = {group.name: place for place, group in enumerate(held.problem.groups)}
    filled = np.array(
        [
            places[Name(stand_in(name).name, owner=name.owner)]
            for name in prediction.names
        ]
    )
    unit = held.law.source_variance[np.ix_(filled, held.rows)]
    total = np.diag(held.law.covariance)[held.rows]
    left = held.limits - np.abs(held.mean)
    allowed = np.where(
        judged.factor > 0.0,
        np.square(
            np.maximum(left, 0.0) / np.where(judged.factor > 0.0, judged.factor, 1.0)
        ),
        np.inf,
    )
    return unit, np.where(left < 0.0, -np.inf, allowed - (total - unit.sum(axis=0)))


def weigh(
    prediction: Prediction, unit: Array, room: Array
) -> tuple[float, list[float]]:
    """Return P(meets), and by how much each line would reduce the doubt.

    `unit` and `room` are those of `rooms`.
    """
    n = len(prediction.names)
    p, reductions = 0.0, []
    for m in range(n):
        # The line that becomes known comes first: draws are in the order of its size.
        order = [m, *(k for k in range(n) if k != m)]
        squared = squared_lines(prediction, order)
        meets = np.ones(POINTS, dtype=bool)
        for k in range(room.size):
            if unit[:, k].any():
                meets &= unit[order, k] @ squared <= room[k]
        known = meets.reshape(STRATA, -1).mean(axis=1)
        own = float(meets.mean())
        if m == 0:
            p = own
        after = float(np.minimum(known, 1.0 - known).mean()) if n > 1 else 0.0
        felt = bool(unit[m].any())
        reductions.append(max(min(own, 1.0 - own) - after, 0.0) if felt else 0.0)
    return p, reductions


def _range(prediction: Prediction, ends: Array) -> tuple[float, float]:
    """Return the central 90 % of the utilisation over the missing lines.

    A row of `ends` has |mean|, k, limit, unit variances and room of one output.
    """
    squared = squared_lines(prediction, range(len(prediction.names)))[:, ::STRIDE]
    used = np.zeros(squared.shape[1])
    for mean, k, limit, *unit, room in ends.tolist():
        rest = max(((limit - mean) / k) ** 2 - room, 0.0) if k > 0.0 else 0.0
        end = k * np.sqrt(rest + np.array(unit) @ squared)
        used = np.maximum(used, (mean + end) / limit)
    low, high = np.quantile(used, [0.05, 0.95])
    return float(low), float(high)


def squared_lines(prediction: Prediction, order: Sequence[int]) -> Array:
    """Return draws of squared lines over their medians, by the first of the order.

    Shape (n_missing, POINTS).
    """
    root = np.linalg.cholesky(prediction.scale[np.ix_(order, order)])
    return np.asarray(np.exp(2.0 * (root @ standard(len(order), prediction.df))))


@lru_cache(maxsize=16)
def standard(n: int, df: float) -> Array:
    """Return points of n uncorrelated Student t, by the first one, (n, POINTS).

    Normals over the root of chi^2/df, through their inverse distributions at the
    points (1/2 + i a_k) mod 1, a_k = g^-k with g^(n + 2) = g + 1: of low discrepancy.
    """
    from scipy.special import gammaincinv, ndtri

    g = 2.0
    for _ in range(64):  # the fixed point
        g = (1.0 + g) ** (1.0 / (n + 2))
    steps = g ** -np.arange(1.0, n + 2.0)
    u = np.mod(0.5 + np.outer(steps, np.arange(1, POINTS + 1)), 1.0)
    t = ndtri(u[:n]) / np.sqrt(2.0 * gammaincinv(df / 2.0, u[n]) / df)
    t = np.ascontiguousarray(t[:, np.argsort(t[0], kind="stable")])
    t.flags.writeable = False
    return t


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
