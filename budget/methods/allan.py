"""Overlapping Allan deviation of recorded rates, and how sure it is.

Of averages over m samples, each beginning a sample after the other,

    sigma^2(m dt) = <(y_{i+m} - y_i)^2>/2  (IEEE Std 952-2020, annex C),

by running sums, so that each m takes the time of the record. Its equivalent degrees of
freedom for a power law S_y(f) ~ f^alpha are those of Greenhall and Riley (2003),
"Uncertainty of stability variances based on finite differences", PTTI 35: with w the
generalised autocovariance of the phase, |t|^3 for alpha = 0, -t^4 ln|t| for -1 and
-|t|^5 for -2, s_x(t) = m^2 (2 w(t) - w(t - 1/m) - w(t + 1/m)) (of large m the second
derivative, which is w of alpha + 2) and s_z its fourth difference,

    1/edf = (s_z(0)^2 + 2 sum_j (1 - j/M) s_z(j/m)^2) / (s_z(0)^2 M),  M = n - 2m + 1 .
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.arrays import Array

WHITE, FLICKER, WALK = 0, -1, -2  # alpha
LEAST_PARTS = 4  # of a record, that are as long as the longest averages
FINE = 3000  # samples of an average, from which on it is taken as continuous
MOST_SUM = 2**17  # terms of a sum; of more the step is larger


@dataclass(frozen=True, kw_only=True)
class AllanPoint:
    """The Allan deviation over one averaging time.

    Attributes
    ----------
    tau : float
        Averaging time [s].
    samples : int
        Of an average.
    deviation : float
        [unit].
    terms, whole : int
        Differences that are there, and that there were without missing samples.
    length : int
        Samples of the record.
    """

    tau: float
    samples: int
    deviation: float
    terms: int
    whole: int
    length: int

    def edf(self, alpha: int) -> float:
        """Return equivalent degrees of freedom, of a power law; fewer of gaps [1]."""
        return degrees_of_freedom(alpha, self.length, self.samples) * (
            self.terms / self.whole
        )


def allan_curve(
    values: Array, interval: float, samples: Iterable[int] | None = None
) -> list[AllanPoint]:
    """Return the overlapping Allan deviation of samples.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Rates; nan where one is missing [unit].
    interval : float
        From one to the next [s].
    samples : iterable of int, optional
        Of averages; octaves from 1 to a quarter of the record without it.

    Returns
    -------
    list of AllanPoint
        Those of which there is a difference.
    """
    n = len(values)
    is_there = np.isfinite(values)
    number = int(is_there.sum())
    if not number:
        return []
    # Off their mean: a running sum of large values would lose digits.
    mean = float(values[is_there].mean())
    phase = np.zeros(n + 1)
    np.cumsum(np.where(is_there, values - mean, 0.0), out=phase[1:])
    count: Array | None = None
    if number < n:
        count = np.zeros(n + 1)
        np.cumsum(is_there, out=count[1:])
    if samples is None:
        top = max(n // LEAST_PARTS, 1)
        samples = [2**k for k in range(top.bit_length()) if 2**k <= top]
    found = []
    for m in samples:
        whole = n - 2 * m + 1
        if whole < 1:
            continue
        sums = phase[m:] - phase[:-m]
        second = sums[m:] - sums[:-m]
        if count is not None:
            second = second[count[2 * m :] - count[:whole] == 2 * m]
        if second.size:
            found.append(
                AllanPoint(
                    tau=m * interval,
                    samples=m,
                    deviation=sqrt(0.5 * float(np.mean(second**2))) / m,
                    terms=second.size,
                    whole=whole,
                    length=n,
                )
            )
    return found


def degrees_of_freedom(alpha: int, length: int, samples: int) -> float:
    """Return those of an overlapping Allan variance [1].

    Parameters
    ----------
    alpha : int
        0 of white noise of a rate, -1 of flicker, -2 of its random walk.
    length, samples : int
        Of the record, and of an average.
    """
    M = length - 2 * samples + 1
    far = min(M, 3 * samples)
    # Lags beyond three averages add nothing; of many every k-th stands for k.
    step = max(far // MOST_SUM, 1)
    j = np.arange(step, far + 1, step)
    s = _structure(np.concatenate([[0.0], j / samples]), samples, alpha)
    squares = (s[1:] / s[0]) ** 2
    weights = np.maximum(1.0 - j / M, 0.0) * step
    return float(M / (1.0 + 2.0 * float(weights @ squares)))


def _structure(t: Array, m: int, alpha: int) -> Array:
    """Return s_z at lags over an average [1]."""

    def s_x(t: Array) -> Array:
        if m >= FINE:
            return _covariance(t, alpha + 2)
        return m**2 * (
            2.0 * _covariance(t, alpha)
            - _covariance(t - 1.0 / m, alpha)
            - _covariance(t + 1.0 / m, alpha)
        )

    return np.asarray(
        6.0 * s_x(t) - 4.0 * (s_x(t - 1.0) + s_x(t + 1.0)) + s_x(t - 2.0) + s_x(t + 2.0)
    )


def _covariance(t: Array, alpha: int) -> Array:
    """Return w(t) of the phase, but for a factor and what differences remove."""
    size = np.abs(t)
    logs = np.log(np.where(size > 0.0, size, 1.0))
    return {2: -size, 1: t**2 * logs, 0: size**3, -1: -(t**4) * logs, -2: -(size**5)}[
        alpha
    ]


def interval_of(deviation: float, edf: float, level: float) -> tuple[float, float]:
    """Return the chi-square interval of a deviation: deviation sqrt(edf/chi2)."""
    from scipy.stats import chi2

    ends = chi2.ppf([0.5 * (1.0 + level), 0.5 * (1.0 - level)], edf)
    low, high = deviation * np.sqrt(edf / ends)
    return float(low), float(high)
