"""Utilisation and conformance of one sensor: from trials, or from the law's normal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.arrays import root_of_correlation
from budget.methods.execution import BLOCK, one_blas_thread, stream
from budget.methods.intervals import interval_of_values
from budget.methods.trials import first_trials
from budget.studies.comparison.records import Probability

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.problem import Problem

BATCH = 2 * BLOCK  # trials whose utilisation is one point of the ranking's spread
CONFIDENCE = 0.95  # of sampling intervals
NORMAL_TRIALS = 16_384  # of the joint normal law, for the conformance by gum


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """How one sensor stands against its limits.

    Attributes
    ----------
    largest_error : ndarray, shape (n_required,)
        Largest absolute end of each coverage interval [SI].
    utilisation_low, utilisation_high : float
        95 % sampling interval of the largest utilisation [1].
    within : ndarray, shape (n_required,)
        Probability of each error to be within its limit [1].
    conformance : Probability
        Of all together.
    u : ndarray, shape (n_required,)
        Standard uncertainties [SI].
    batches : ndarray, shape (n_batches,)
        Utilisation of each full batch of trials [1]; empty by the law.
    trials : int or None
    """

    largest_error: Array
    utilisation_low: float
    utilisation_high: float
    within: Array
    conformance: Probability
    u: Array
    batches: Array
    trials: int | None


def judge_by_trials(
    problem: Problem,
    rows: Array,
    limits: Array,
    *,
    coverage: float,
    trials: int,
    seed: int,
) -> Judged:
    """Judge by Monte Carlo trials, the same streams for every device.

    Parameters
    ----------
    problem : Problem
        Of one sensor.
    rows : ndarray of int, shape (n_required,)
        Its required outputs.
    limits : ndarray, shape (n_required,)
        On the absolute errors [SI].
    coverage : float
        Probability of the intervals.
    trials, seed : int
        How many, and of which streams.
    """
    values = first_trials(problem, trials=trials, seed=seed, outputs=rows)
    inside = np.abs(values) <= limits[:, None]
    joint = int(inside.all(axis=0).sum())
    within = inside.mean(axis=1)
    u = values.std(axis=1, ddof=1)
    batches = [
        _utilisation(np.sort(values[:, start : start + BATCH]), limits, coverage)
        for start in range(0, trials - BATCH + 1, BATCH)
    ]
    values.sort(axis=1)
    ends = interval_of_values(values, coverage, "symmetric")
    low, high = _sampling_interval(values, limits, coverage)
    return Judged(
        largest_error=np.abs(ends).max(axis=1),
        utilisation_low=low,
        utilisation_high=high,
        within=within,
        conformance=_binomial(joint, trials),
        u=u,
        batches=np.array(batches),
        trials=trials,
    )


def judge_by_law(
    law: Propagation, rows: Array, limits: Array, *, coverage: float, seed: int
) -> Judged:
    """Judge by the law: intervals mean +- k u, conformance of the joint normal.

    The joint probability of a box has no closed form; it is counted in draws of the
    normal distribution with the law's means and joint covariance.
    """
    from scipy.special import ndtr

    ends = law.interval(coverage)[rows]
    largest = np.abs(ends).max(axis=1)
    utilisation = float((largest / limits).max())
    mean, u = law.mean[rows], law.standard_uncertainty[rows]
    safe = np.where(u > 0.0, u, 1.0)
    within = np.where(
        u > 0.0,
        ndtr((limits - mean) / safe) - ndtr((-limits - mean) / safe),
        np.abs(mean) <= limits,
    )
    joint = _count_inside(law, rows, limits, seed)
    return Judged(
        largest_error=largest,
        utilisation_low=utilisation,
        utilisation_high=utilisation,
        within=within,
        conformance=_binomial(joint, NORMAL_TRIALS),
        u=u,
        batches=np.empty(0),
        trials=None,
    )


def probability_smaller(a: Array, b: Array) -> float:
    """Return the probability that a's true utilisation is the smaller one.

    Both were found on the same random numbers, batch by batch; their difference has a
    Student t distribution over the batches. Fewer than two batches tell nothing.
    """
    from scipy.special import stdtr

    n = min(a.size, b.size)
    if n < 2:  # noqa: PLR2004 - a spread takes two
        return 0.5
    difference = a[:n] - b[:n]
    spread = difference.std(ddof=1)
    mean = difference.mean()
    if spread == 0.0:
        return 0.5 if mean == 0.0 else float(mean < 0.0)
    return float(stdtr(n - 1, -mean / (spread / sqrt(n))))


def _count_inside(law: Propagation, rows: Array, limits: Array, seed: int) -> int:
    """Return how many of NORMAL_TRIALS draws of the law lie within all limits."""
    normals = _unit_normals(seed, rows.size)
    # Scaled by the limits: the box becomes the unit cube.
    mean = law.mean[rows] / limits
    covariance = law.covariance[np.ix_(rows, rows)] / np.outer(limits, limits)
    reach = normals.longest * np.sqrt(np.diag(covariance))
    if (np.abs(mean) + reach <= 1.0).all():  # no draw is long enough to get out
        return NORMAL_TRIALS
    u = np.sqrt(np.diag(covariance))
    safe = np.where(u > 0.0, u, 1.0)
    factor = u[:, None] * root_of_correlation(covariance / np.outer(safe, safe))
    inside = 0
    with one_blas_thread():
        for start in range(0, NORMAL_TRIALS, BLOCK):  # blocks stay in the cache
            y = factor @ normals.z[:, start : start + BLOCK]
            y += mean[:, None]
            inside += int((np.abs(y, out=y).max(axis=0) <= 1.0).sum())
    return inside


@dataclass(frozen=True, kw_only=True, eq=False)
class _Normals:
    """Independent unit normals that all devices share."""

    z: Array  # shape (n, NORMAL_TRIALS)
    longest: float  # the largest norm of a draw


@lru_cache(maxsize=4)
def _unit_normals(seed: int, n: int) -> _Normals:
    """Draw unit normals for n outputs."""
    z = stream(seed, "joint conformance", 0).standard_normal((n, NORMAL_TRIALS))
    z.flags.writeable = False
    return _Normals(z=z, longest=float(np.sqrt((z**2).sum(axis=0).max())))


def _utilisation(ordered: Array, limits: Array, coverage: float) -> float:
    """Return the largest utilisation of ordered trials."""
    ends = interval_of_values(ordered, coverage, "symmetric")
    return float((np.abs(ends).max(axis=1) / limits).max())


def _sampling_interval(
    ordered: Array, limits: Array, coverage: float
) -> tuple[float, float]:
    """Return the 95 % sampling interval of the largest utilisation.

    The number of trials below a quantile is binomial, so the quantile lies between two
    order statistics; of the largest output both ends are the largest of all outputs.
    """
    from scipy.special import ndtri

    trials = ordered.shape[1]
    tail = (1.0 - coverage) / 2.0
    z = float(ndtri((1.0 + CONFIDENCE) / 2.0))
    reach = z * sqrt(trials * tail * (1.0 - tail))

    def at(place: float) -> Array:
        return ordered[:, int(np.clip(round(place), 0, trials - 1))]

    below, above = tail * trials, (1.0 - tail) * trials - 1.0
    inner = np.maximum(-at(below + reach), at(above - reach))
    outer = np.maximum(-at(below - reach), at(above + reach))
    return float((np.abs(inner) / limits).max()), float((np.abs(outer) / limits).max())


def _binomial(successes: int, trials: int) -> Probability:
    """Return a proportion with its 95 % interval (Clopper and Pearson)."""
    from scipy.special import betaincinv

    tail = (1.0 - CONFIDENCE) / 2.0
    failures = trials - successes
    return Probability(
        value=successes / trials,
        low=float(betaincinv(successes, failures + 1, tail)) if successes else 0.0,
        high=float(betaincinv(successes + 1, failures, 1.0 - tail))
        if failures
        else 1.0,
    )
