"""How much a number varies from seed to seed: standard errors of what trials give.

A result keeps means and intervals, not its trials. So the shape of every output is
taken from trials of the same model on streams of their own, and standard errors follow
from the shape and from the number of trials that the result has.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.execution import BLOCK
from budget.methods.intervals import interval_of_values
from budget.methods.trials import first_trials

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Problem

SHAPE_TRIALS = 8 * BLOCK
SHAPE_SEED = 20_190_306  # any fixed one: shapes are properties of the model
BATCHES = 16  # of a shortest interval, whose ends have no simple formula


@dataclass(frozen=True, kw_only=True, eq=False)
class StandardErrors:
    """Of every output of a run with so many trials.

    Attributes
    ----------
    mean, u : ndarray, shape (n_out,)
        Of mean and standard uncertainty [SI].
    low, high : ndarray, shape (n_out,)
        Of the ends of the coverage interval [SI].
    correlation : ndarray, shape (n_out, n_out)
        Of the correlation coefficients [1].
    degrees_of_freedom : float
        Of mean and correlation.
    u_degrees_of_freedom : ndarray, shape (n_out,)
        Of u: fewer for heavy tails, whose kurtosis is hard to tell.
    end_degrees_of_freedom : float
        Of the ends.
    """

    mean: Array
    u: Array
    low: Array
    high: Array
    correlation: Array
    degrees_of_freedom: float
    u_degrees_of_freedom: Array
    end_degrees_of_freedom: float

    @property
    def end(self) -> Array:
        """Of the larger absolute end, shape (n_out,) [SI].

        That of the less sure one: the larger of two numbers strays no further than
        the one of them that strays further.
        """
        return np.maximum(self.low, self.high)

    def freedom(self, spread: str, place: int) -> float:
        """Return the degrees of freedom of one of the fields, at one output."""
        if spread == "u":
            return float(self.u_degrees_of_freedom[place])
        is_end = spread in {"low", "high", "end"}
        return self.end_degrees_of_freedom if is_end else self.degrees_of_freedom


def standard_errors(
    problem: Problem, *, trials: int, coverage: float, interval: str = "symmetric"
) -> StandardErrors:
    """Return the standard errors of a Monte Carlo result.

    Parameters
    ----------
    problem : Problem
        The model that was sampled.
    trials : int
        How many trials the result has.
    coverage, interval
        Of its coverage intervals.
    """
    y = first_trials(problem, trials=SHAPE_TRIALS, seed=SHAPE_SEED)
    mean = y.mean(axis=1)
    centred = y - mean[:, None]
    u = np.sqrt((centred**2).mean(axis=1))
    safe = np.where(u > 0.0, u, 1.0)
    z = centred / safe[:, None]
    kurtosis = np.where(u > 0.0, (z**4).mean(axis=1), 3.0)
    y.sort(axis=1)
    if interval == "symmetric":
        ends, freedom = _quantile_errors(y, trials, coverage)
    else:
        ends, freedom = _batch_errors(centred + mean[:, None], trials, coverage)
    return StandardErrors(
        mean=u / sqrt(trials),
        # var(s^2) = u^4 (kurtosis - 1)/n to leading order, s = sqrt(s^2).
        u=u * np.sqrt((kurtosis - 1.0) / (4.0 * trials)),
        low=ends[:, 0],
        high=ends[:, 1],
        correlation=_correlation_spread(z) / sqrt(trials),
        degrees_of_freedom=trials - 1.0,
        u_degrees_of_freedom=np.minimum(_kurtosis_freedom(z, kurtosis), trials - 1.0),
        end_degrees_of_freedom=freedom,
    )


def _quantile_errors(
    ordered: Array, trials: int, coverage: float
) -> tuple[Array, float]:
    """Return standard errors of both quantiles, (n_out, 2), and their freedom.

    sqrt(p (1 - p)/n) dQ/dp, the slope taken over half the tail on each side: few
    trials would make it rough, and the bend of a tail only makes it larger (8 % for
    the normal at 95 %).
    """
    n = ordered.shape[1]
    tail = (1.0 - coverage) / 2.0
    reach = max(round(tail * n / 2.0), 1)
    binomial = sqrt(tail * (1.0 - tail) / trials)
    errors = []
    for p in (tail, 1.0 - tail):
        first = min(max(round(p * n) - reach, 0), n - 1)
        last = min(max(round(p * n) + reach, 0), n - 1)
        slope = (ordered[:, last] - ordered[:, first]) / (max(last - first, 1) / n)
        errors.append(binomial * slope)
    # The sum of m spacings has the relative variance 1/m, a variance with v degrees of
    # freedom 2/v, and the variance here is the square of the sum: v = m/2.
    return np.stack(errors, axis=1), float(max(reach, 1))


def _batch_errors(values: Array, trials: int, coverage: float) -> tuple[Array, float]:
    """Return standard errors of the ends of shortest intervals, from batches.

    Where the shortest interval lies is sure to the cube root of the trials only, not
    to their square root.
    """
    size = values.shape[1] // BATCHES
    ends = np.stack(
        [
            interval_of_values(
                np.sort(values[:, start : start + size]), coverage, "shortest"
            )
            for start in range(0, BATCHES * size, size)
        ]
    )
    scale = (size / trials) ** (1.0 / 3.0)
    return ends.std(axis=0, ddof=1) * scale, BATCHES - 1.0


def _kurtosis_freedom(z: Array, kurtosis: Array) -> Array:
    """Return the degrees of freedom of kurtosis - 1, as a variance has them, (n_out,).

    The influence of one trial on the kurtosis k is z^4 - k - 2 k (z^2 - 1), and v
    degrees of freedom go with a relative variance of 2/v.
    """
    k = kurtosis[:, None]
    influence = z**4 - k - 2.0 * k * (z**2 - 1.0)
    variance = (influence**2).mean(axis=1) / z.shape[1]
    # A coin, +-1, has kurtosis 1 and no spread at all.
    known = (variance > 0.0) & (kurtosis > 1.0)
    free = 2.0 * (kurtosis - 1.0) ** 2 / np.where(known, variance, 1.0)
    return np.asarray(np.where(known, np.maximum(free, 1.0), np.inf))


def _correlation_spread(z: Array) -> Array:
    """Return sqrt(n) times the standard error of each correlation, (n_out, n_out).

    The influence of one trial on r is a b - r (a^2 + b^2)/2 for standardised a, b.
    """
    n = z.shape[1]
    z2, z3 = z**2, z**3
    r = z @ z.T / n
    mixed = z2 @ z2.T / n  # E a^2 b^2
    cubes = z3 @ z.T / n  # E a^3 b
    fourth = np.diag(mixed)
    variance = (
        mixed
        - r * (cubes + cubes.T)
        + r**2 / 4.0 * (fourth[:, None] + fourth[None, :] + 2.0 * mixed)
    )
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
