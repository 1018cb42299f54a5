"""Sobol' indices of sources: the part of a variance that each makes, alone, in all.

Points are scrambled Sobol' ones, twice as many columns as inputs, split into A and B;
a source's columns are swapped together, so inputs may be correlated within it. The
estimators are those of Saltelli et al. (2010), intervals come from independent
scrambles, because a bootstrap of Sobol' points is far too wide.

The linear part of a model has indices that are known exactly. Where it makes most of
the variance it serves as a control variate: what is estimated from the points is only
how the model differs from its linear part on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import ceil, isfinite, isinf, log2
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError, ProblemError
from budget.methods.execution import in_order, local_executor, small_blocks
from budget.methods.gum import propagate
from budget.methods.trials import check_finite

if TYPE_CHECKING:
    from collections.abc import Callable
    from concurrent.futures import Executor

    from budget.arrays import Array
    from budget.problem import Problem

SAMPLES = 2048
MOST_SAMPLES = 2**20  # of one scramble, kept at once: 1.2 GB for two triads
SCRAMBLES = 8
LEAST_SCRAMBLES = 2  # an interval takes a spread
CONFIDENCE = 0.95  # of the intervals over scrambles
# A control variate helps where it is correlated with the model by more than 1/2; the
# share of the linear part in the variance is the square of that correlation.
LINEAR_ENOUGH = 0.5  # [1]
# Sobol' points may touch 0, where a normal quantile is infinite.
EDGE = 2.0**-40


@dataclass(frozen=True, kw_only=True, eq=False)
class Indices:
    """Estimates of one kind of index with their intervals."""

    value: Array  # [1]; nan where an output has no variance, shape (n_factors, n_out)
    # Ends of the t interval over scrambles [1].
    low: Array
    high: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class SobolResult:
    """First-order and total indices of every source for every output.

    Attributes
    ----------
    factors : tuple of str
        Sources (or inputs) that vary; constant ones are left out.
    first, total : Indices
    interaction : Indices
        Total minus first, estimated scramble by scramble.
    evaluations : int
        How often the model was evaluated.
    note : str
        Why there was no control variate though one was wanted; empty otherwise.
    """

    factors: tuple[str, ...]
    first: Indices
    total: Indices
    interaction: Indices
    samples: int
    scrambles: int
    evaluations: int
    note: str = ""

    def ranks(self, output: int) -> tuple[int, ...]:
        """Return the rank of each factor by its total index for one output.

        A factor whose interval overlaps that of the first of a rank shares the rank.
        """
        order = np.argsort(-self.total.value[:, output], kind="stable")
        ranks = [0] * len(order)
        rank, leader = 1, order[0]
        for place, factor in enumerate(order, start=1):
            if self.total.high[factor, output] < self.total.low[leader, output]:
                rank, leader = place, factor
            ranks[factor] = rank
        return tuple(ranks)


@dataclass(frozen=True, kw_only=True)
class _Factor:
    """What is swapped together: a name and its rows among the inputs."""

    name: str
    rows: slice


@dataclass(frozen=True, kw_only=True)
class _Draws:
    """How many points of which stream."""

    samples: int
    seed: int


def evaluations(problem: Problem, samples: int, scrambles: int) -> int:
    """Return how often `sobol` will evaluate the model."""
    varying = sum(not group.is_constant for group in problem.groups)
    return (varying + 2) * _power_of_two(samples) * scrambles


def sobol(
    problem: Problem,
    *,
    samples: int = SAMPLES,
    scrambles: int = SCRAMBLES,
    by_input: bool = False,
    control_variate: bool = True,
    seed: int = 0,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> SobolResult:
    """Estimate first-order and total indices of the sources.

    Parameters
    ----------
    problem : Problem
        Any; at least one of its sources must vary.
    samples : int
        N of one scramble; the next power of two is taken.
    scrambles : int
        Independent randomisations, 2 or more; 8 make an interval worth its name.
    by_input : bool
        Take every single input as a factor, in place of whole sources.
    control_variate : bool
        Whether the linear part may serve as one, where it makes most of the variance.
    seed, workers, executor, progress
        As of monte_carlo.sample; progress counts scrambles.

    Returns
    -------
    SobolResult

    Raises
    ------
    ProblemError
        Nothing varies, or a correlated source would have to be split.
    CallError
        Too few samples or scrambles, or more samples than a machine can keep.
    """
    if samples > MOST_SAMPLES:
        raise CallError(
            f"{samples} samples in one scramble: allowed are {MOST_SAMPLES} at the "
            "most, which are kept at once; take more scrambles for smaller intervals"
        )
    if scrambles < LEAST_SCRAMBLES or samples < LEAST_SCRAMBLES:
        raise CallError(
            f"{samples} samples in {scrambles} scrambles: allowed are "
            f"{LEAST_SCRAMBLES} or more of each"
        )
    factors = _factors(problem, by_input=by_input)
    n = _power_of_two(samples)
    linear, note = _control_variate(problem, factors) if control_variate else (None, "")
    work = partial(
        _one_scramble, problem, factors, linear, _Draws(samples=n, seed=seed)
    )
    parts: list[tuple[Array, Array]] = []
    with local_executor(1 if executor is not None else workers) as pool:
        for part in in_order(
            work, range(scrambles), executor or pool, ahead=2 * workers
        ):
            parts.append(part)
            if progress is not None:
                progress(len(parts), scrambles)
    first = np.stack([first for first, _ in parts])
    total = np.stack([total for _, total in parts])
    return SobolResult(
        factors=tuple(factor.name for factor in factors),
        first=_over_scrambles(first),
        total=_over_scrambles(total),
        interaction=_over_scrambles(total - first),
        samples=n,
        scrambles=scrambles,
        evaluations=(len(factors) + 2) * n * scrambles,
        note=note,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _LinearPart:
    """The tangent of the model at the mean, and what is known of it exactly."""

    # Sensitivities; zero rows where the tangent is no help, shape (n_out, n_in).
    C: Array
    # Variance of the tangent from each factor, shape (n_factors, n_out).
    variance: Array


def _control_variate(
    problem: Problem, factors: tuple[_Factor, ...]
) -> tuple[_LinearPart | None, str]:
    """Return the tangent as a control variate, or none and why."""
    # A Student t variate has another variance than the u^2 that the law counts; of
    # shapes without a finite kurtosis the law may know no variance at all.
    if not all(
        isinf(shape.degrees_of_freedom) and isfinite(shape.kurtosis)
        for group in problem.groups
        for shape in group.distributions
    ) or any(group.scales for group in problem.groups):
        return None, (
            "no control variate: the law does not count the variance that is drawn"
        )
    try:
        return _linear_part(problem, factors), ""
    except ProblemError as error:
        return None, f"no control variate, as the model has no tangent: {error}"


def _linear_part(problem: Problem, factors: tuple[_Factor, ...]) -> _LinearPart:
    """Return the tangent where it makes most of the variance by the law."""
    law = propagate(problem)
    exact = np.diag(law.first_order)
    enough = exact > LINEAR_ENOUGH * np.diag(law.covariance)
    enough[exact.size - problem.legs.shape[1] :] = False  # a length has no tangent
    C = np.where(enough[:, None], law.C, 0.0)
    U_x = problem.input_covariance
    variance = np.stack(
        [
            np.einsum("ki,ij,kj->k", C[:, f.rows], U_x[f.rows, f.rows], C[:, f.rows])
            for f in factors
        ]
    )
    return _LinearPart(C=C, variance=variance)


def _one_scramble(
    problem: Problem,
    factors: tuple[_Factor, ...],
    linear: _LinearPart | None,
    draws: _Draws,
    scramble: int,
) -> tuple[Array, Array]:
    """Return first-order and total indices from one scramble, (n_factors, n_out)."""
    with small_blocks():
        return _estimate(problem, factors, linear, draws, scramble)


def _estimate(
    problem: Problem,
    factors: tuple[_Factor, ...],
    linear: _LinearPart | None,
    draws: _Draws,
    scramble: int,
) -> tuple[Array, Array]:
    """Draw the points, evaluate A, B and the mixed ones, apply the estimators."""
    from scipy.stats import qmc

    k = problem.n_inputs + sum(len(group.scales) for group in problem.groups)
    stream = np.random.SeedSequence(draws.seed, spawn_key=(scramble,))
    engine = qmc.Sobol(2 * k, scramble=True, seed=np.random.default_rng(stream))
    points = engine.random(draws.samples).T
    a, b = (_inputs(problem, half) for half in (points[:k], points[k:]))
    y_a, y_b = problem.evaluate(a).T, problem.evaluate(b).T
    check_finite(np.stack([y_a, y_b]))

    # Every output is scaled to about 1.
    centre = np.mean(np.concatenate([y_a, y_b]), axis=0)
    spread = np.std(np.concatenate([y_a, y_b]), axis=0)
    scale = np.where(spread > 0.0, spread, 1.0)
    l_a = l_b = np.zeros_like(y_a)
    known = np.zeros((len(factors), y_a.shape[1]))
    mean = problem.mean[:, None]
    if linear is not None:
        l_a, l_b = ((linear.C @ (x - mean)).T / scale for x in (a, b))
        l_centre = np.mean(np.concatenate([l_a, l_b]), axis=0)
        l_a, l_b = l_a - l_centre, l_b - l_centre  # as the model itself is centred
        known = linear.variance / scale**2
    y_a, y_b = (y_a - centre) / scale, (y_b - centre) / scale

    variance = _variance(y_a, y_b) - _variance(l_a, l_b) + known.sum(axis=0)
    first, total = np.empty_like(known), np.empty_like(known)
    for f, factor in enumerate(factors):
        mixed = a.copy()
        mixed[factor.rows] = b[factor.rows]
        y_ab = (problem.evaluate(mixed).T - centre) / scale
        check_finite(y_ab)
        l_ab = l_a
        if linear is not None:  # only the rows exchanged move the tangent
            step = b[factor.rows] - a[factor.rows]
            l_ab = l_a + (linear.C[:, factor.rows] @ step).T / scale
        first[f] = _alone(y_a, y_ab, y_b) - _alone(l_a, l_ab, l_b) + known[f]
        total[f] = _in_all(y_a, y_ab) - _in_all(l_a, l_ab) + known[f]
    for row, legs in enumerate(
        problem.legs.T, start=len(problem.outputs) - len(problem.legs.T)
    ):
        # Of a vector: its parts over all its variance (Gamboa et al. 2014).
        for values in (first.T, total.T, variance):
            values[row] = (values[legs].T @ scale[legs] ** 2).T / scale[row] ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        still = spread == 0.0
        first, total = first / variance, total / variance
    first[:, still] = total[:, still] = np.nan
    return first, total


def _alone(a: Array, ab: Array, b: Array) -> Array:
    """Return the partial variance of a factor alone: Saltelli et al. 2010, table 2b."""
    return np.asarray(np.mean(b * (ab - a), axis=0))


def _in_all(a: Array, ab: Array) -> Array:
    """Return the variance by all that a factor is in: Saltelli et al. 2010, 2f."""
    return np.asarray(0.5 * np.mean((a - ab) ** 2, axis=0))


def _variance(a: Array, b: Array) -> Array:
    """Return the variance of both samples together, shape (n_out,)."""
    return np.asarray(np.var(np.concatenate([a, b]), axis=0))


def _inputs(problem: Problem, points: Array) -> Array:
    """Map points of the unit cube to inputs [SI]; those of scales are the last rows."""
    from scipy.special import chdtri

    points = np.clip(points, EDGE, 1.0 - EDGE)
    x, of_scales = points[: problem.n_inputs], iter(points[problem.n_inputs :])
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        for row, shape in zip(x[rows], group.drawn, strict=True):
            row[:] = shape.quantile(row)
        dx = group.deviations(x[rows])
        for scale in group.scales:
            v = scale.degrees_of_freedom
            dx[list(scale.rows)] *= scale.of(chdtri(v, next(of_scales)))
        x[rows] = dx + group.mean[:, None]
    return x


def _over_scrambles(estimates: Array) -> Indices:
    """Return mean and t interval over scrambles, from (scrambles, n_factors, n_out)."""
    from scipy.special import stdtrit

    runs = len(estimates)
    t = float(stdtrit(runs - 1, (1.0 + CONFIDENCE) / 2.0))
    mean = estimates.mean(axis=0)
    half = t * estimates.std(axis=0, ddof=1) / np.sqrt(runs)
    return Indices(value=mean, low=mean - half, high=mean + half)


def _factors(problem: Problem, *, by_input: bool) -> tuple[_Factor, ...]:
    """Return what varies, source by source or input by input."""
    found: list[_Factor] = []
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        if group.is_constant:
            continue
        if not by_input:
            found.append(_Factor(name=group.name, rows=rows))
            continue
        if not group.is_independent:
            raise ProblemError(
                f"the inputs of {group.name!r} are correlated: they have no indices "
                "of their own; take whole sources (by_input=False)"
            )
        found.extend(
            _Factor(name=f"{group.name}[{i}]", rows=slice(row, row + 1))
            for i, row in enumerate(range(rows.start, rows.stop))
            if group.covariance[i, i] > 0.0
        )
    if not found:
        raise ProblemError("no source varies: there is no variance to share out")
    return tuple(found)


def _power_of_two(samples: int) -> int:
    """Return the next power of two: Sobol' points are balanced only there."""
    return int(2 ** ceil(log2(max(samples, 2))))
