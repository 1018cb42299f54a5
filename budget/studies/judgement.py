"""Verdicts: outputs of a Problem against limits, the same in every command.

The largest absolute end of each coverage interval is held against its limit. The end is
the law's, mean +- k u, where what the law can be off by (budget.methods.normality) is
no more than the sampling error of the trials made; elsewhere it is that of the trials.
So a linear model with normal inputs is judged exactly, and a bound of uniform shape by
Monte Carlo. Trials are four times as many until the limit lies outside the interval of
the utilisation, or until there are as many as may be: then it is undecided.

Outputs that are equal by the law, source by source, as equal axes are, have one
distribution: the trials of the first of them stand for all, so that they have one
interval and tie. What has no limit gets the interval of the first trials.

Limits that are to be kept together (`decision: joint`) have one utilisation, the
quantile of the largest error over its limit (budget.studies.jointly), by the trials.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from math import exp, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import normal_coverage_factor
from budget.methods.gum import covariance_by_source
from budget.methods.intervals import interval_of_values
from budget.methods.largest import (
    CONFIDENCE,
    Ends,
    ends_in_order,
    ends_of_trials,
    half_widths,
    sampling_interval,
)
from budget.methods.normality import end_accuracy
from budget.methods.radius import principal_variances, probability_within
from budget.methods.trials import first_trials
from budget.question import Limited
from budget.results import (
    BY_LAW,
    BY_TRIALS,
    NO_REMEDY,
    TINY,
    JudgedOutput,
    Probability,
    Remedy,
    u_known,
)
from budget.studies.jointly import components_of, ends_together, largest_of_normals
from budget.ties import ALIKE, equal_to, first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.names import Name
    from budget.problem import Problem
    from budget.question import Question
    from budget.results import Verdict

TRIALS = 100_000  # at first
MAX_TRIALS = 1_600_000  # where more trials stop trying to settle a verdict
STEP = 4  # times as many trials in each try
# Of what sampling leaves open of an end of a normal output: a law that is surer is
# surer than trials of any output that is so nearly normal [1].
SURE = 0.5
GROWTH = 4.0  # of a variance, from one try of a bracket to the next [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Marks:
    """A yes or no for every trial, a bit each: of thousands of devices all are kept."""

    bits: NDArray[np.uint8]  # shape (size / 8, rounded up)
    size: int

    @classmethod
    def of(cls, each: Array) -> Marks:
        """Pack an array of bool, shape (trials,)."""
        if (n := np.count_nonzero(each)) in {0, each.size}:
            return _alike_marks(each.size, is_inside=n > 0)
        return cls(bits=np.packbits(each.astype(bool)), size=each.size)

    def first(self, number: int) -> NDArray[np.bool_]:
        """Return the marks of the first trials, bool, shape (number,)."""
        return np.unpackbits(self.bits, count=number).astype(bool)


@lru_cache(maxsize=8)
def _alike_marks(size: int, *, is_inside: bool) -> Marks:
    """Return marks that are all the same, which most devices share."""
    return Marks(bits=np.packbits(np.full(size, is_inside)), size=size)


@dataclass(frozen=True, kw_only=True, eq=False)
class Counted:
    """What is counted of the outputs of one Problem together with those of others."""

    # In which trials all are within; of the joint normal law where `trials` is None.
    inside: Marks = field(repr=False)
    trials: int | None  # none: by the law alone
    # Probability that all limits are to be kept together with; None: each alone [1].
    together: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged(Counted):
    """How the required outputs of one Problem stand against their limits."""

    interval: Array  # coverage intervals, shape (n_required, 2) [SI]
    # Whether an interval is of the trials, else it is the law's, shape (n_required,).
    by_trials: NDArray[np.bool_]
    # Coverage factors: what times u gives the largest end from |mean| on, shape
    # (n_required,); of limits to be kept together so many times as the utilisation is
    # the largest of `used` [1].
    factor: Array
    u: Array  # standard uncertainties, by the law, shape (n_required,) [SI]
    # Utilisations: largest absolute end over limit, shape (n_required,) [1].
    used: Array
    # The same by the law, which knows of equal axes that they are equal, shape
    # (n_required,) [1].
    used_by_law: Array = field(repr=False)
    # Of the largest: sampling at 95 %, and what the law can be off by [1].
    utilisation_interval: tuple[float, float]
    # Probability of each error to be within its limit, shape (n_required,) [1].
    within: Array
    conformance: Probability  # of all together
    # What the utilisation and its interval were taken from.
    ends: Ends = field(repr=False)
    # Half the 95 % sampling interval of each utilisation, were it of the trials, shape
    # (n_required,) [1].
    sampled: Array = field(repr=False)

    @property
    def counted(self) -> Counted:
        """What stands beside other Problems of it, and no more."""
        return Counted(inside=self.inside, trials=self.trials, together=self.together)

    @property
    def worst(self) -> int:
        """Place of the output that uses most of its limit; of equal ones the first."""
        return first_largest(self.used.tolist())

    @property
    def all_worst(self) -> tuple[int, ...]:
        """That place and those of all outputs that are equal to it by the law."""
        return equal_to(self.used_by_law.tolist(), self.worst)

    @property
    def utilisation(self) -> float:
        """The largest of all outputs; of limits to be kept together theirs [1]."""
        return self.ends.largest

    @property
    def is_open(self) -> bool:
        """Whether the limit lies within the interval of the utilisation."""
        low, high = (settle(end) for end in self.utilisation_interval)
        return low <= 1.0 < high

    def verdict(self, missing: Sequence[str] = ()) -> str:
        """Return 'meets', 'fails', 'undecided' or 'undecidable'.

        `missing` are expected lines that are not given and limited parameters that are
        not estimated: they stop a `meets`, nothing else.
        """
        if self.is_open:
            return "undecided"
        if settle(self.utilisation) > 1.0:
            return "fails"
        return "undecidable" if missing else "meets"


def judge(
    held: Limited,
    *,
    seed: int,
    trials: int = TRIALS,
    max_trials: int = MAX_TRIALS,
) -> Judged:
    """Judge required outputs, with as many trials as the verdict takes.

    The first trials of the streams of a seed are the same for every problem.
    """
    number, values = trials, None
    while True:
        values = _first_trials(held, number, seed, known=values)
        judged = _judge_by(values, held)
        settles = judged.is_open and can_sharpen(judged, max_trials, above=1.0)
        if not settles or number >= max_trials:
            return judged
        number = min(STEP * number, max_trials)


def judge_with(held: Limited, *, seed: int, trials: int) -> Judged:
    """Judge with so many trials and no more; arguments as of `judge`."""
    return _judge_by(_first_trials(held, trials, seed), held)


@dataclass(frozen=True, kw_only=True, eq=False)
class Intervals:
    """Coverage intervals of all outputs of a Problem."""

    ends: Array  # shape (n_out, 2) [SI]
    # Whether they are of the trials, else the law's, shape (n_out,).
    by_trials: NDArray[np.bool_]


def intervals_of(question: Question, *, seed: int) -> Intervals:
    """Return the intervals that `judge` takes from its first trials; no limit counts.

    Trials are drawn for outputs that the law could be off by half of what sampling
    leaves open of the end of a normal output: for all others they would be less sure
    than the law. What has a limit is left with the law's.
    """
    problem, law, coverage = question.problem, question.law, question.coverage
    wanted = question.requirement
    besides = () if wanted is None else wanted.outputs
    found = Intervals(
        ends=law.interval(coverage), by_trials=np.zeros(law.value.size, dtype=bool)
    )
    off = end_accuracy(problem, law, coverage)
    least = SURE * _sampled_of_normal(coverage) * law.standard_uncertainty
    rows = np.array(
        [
            k
            for k in np.flatnonzero(off > least)
            if problem.outputs[k].name not in besides
        ],
        dtype=int,
    )
    if not rows.size:
        return found
    held = Limited(
        problem=problem,
        rows=rows,
        limits=np.ones(rows.size),
        coverage=np.full(rows.size, coverage),
        printed=("",) * rows.size,
        usual=coverage,
    )
    vars(held)["law"] = law
    drawn = _of_trials(_first_trials(held, TRIALS, seed), held)
    taken = rows[drawn.by_trials]
    found.ends[taken] = drawn.interval[drawn.by_trials]
    found.by_trials[taken] = True
    return found


def _sampled_of_normal(coverage: float) -> float:
    """Return half the sampling interval of an end of a normal output, over its u [1].

    The quantile of probability p of M trials has the standard error
    sqrt(p (1 - p)/M)/f, f the density there (of normal outputs that at z).
    """
    z, p = normal_coverage_factor(coverage), (1.0 + coverage) / 2.0
    error = sqrt(p * (1.0 - p) / TRIALS) * sqrt(2.0 * pi) * exp(z**2 / 2.0)
    return float(normal_coverage_factor(CONFIDENCE) * error)


def alike(problem: Problem, law: Propagation) -> NDArray[np.intp]:
    """Return for every output the first one that it is equal to, shape (n_out,).

    Of one parameter, equal in its mean and in the variance of every source: equal axes
    have equal distributions, of which trials draw one after the other.
    """
    parts = np.vstack([law.source_variance, law.interaction_variance])
    u = law.standard_uncertainty
    found = np.arange(u.size)
    firsts: dict[tuple[Name, float | None], list[int]] = {}
    for k, output in enumerate(problem.outputs):
        known = firsts.setdefault((output.name.group, output.name.time), [])
        for j in known:
            off = np.abs(parts[:, k] - parts[:, j]).max()
            shift = abs(law.mean[k] - law.mean[j])
            if off <= ALIKE * u[j] ** 2 and shift <= ALIKE * u[j]:
                found[k] = j
                break
        else:
            known.append(k)
    return found


def _first_trials(
    held: Limited,
    trials: int,
    seed: int,
    *,
    known: Array | None = None,
) -> Array:
    """Return the outputs `_drawn_rows` in the first trials, (n_drawn, trials) [SI]."""
    return first_trials(
        held.problem, trials=trials, seed=seed, outputs=_drawn_rows(held), known=known
    )


def _drawn_rows(held: Limited) -> NDArray[np.intp]:
    """Return the required outputs and those that stand for them, ascending."""
    return np.union1d(held.rows, alike(held.problem, held.law)[held.rows])


@dataclass(frozen=True, kw_only=True, eq=False)
class _OfTrials:
    """What trials say of the required outputs; equal ones have the same."""

    interval: Array  # shape (n_required, 2) [SI]
    within: Array  # parts of the trials within the limits, shape (n_required,) [1]
    ends: Ends
    # Half the 95 % sampling interval over the limit, shape (n_required,) [1].
    sampled: Array
    given: Ends  # by the law
    # Whether the law is less sure than the trials, shape (n_required,).
    by_trials: NDArray[np.bool_]


def _of_trials(values: Array, held: Limited) -> _OfTrials:
    """Take intervals of trials of the outputs `_drawn_rows`, shape (n_drawn, trials).

    An output that varies by rounding alone is left to the law.
    """
    place = np.searchsorted(_drawn_rows(held), alike(held.problem, held.law)[held.rows])
    (each, coverage), back = np.unique(
        np.stack([place, held.coverage]), axis=1, return_inverse=True
    )
    own, back = values[each.astype(int)], back.ravel()
    ordered = ends_in_order(own, coverage)
    ends = ends_of_trials(own, ordered, np.ones(coverage.size), coverage)
    both = np.concatenate([back, back + coverage.size])
    scale = np.tile(held.limits, 2)
    drawn = Ends(
        value=ends.value[both] / scale,
        noise=ends.noise[:, both] / scale,
        bound=np.zeros(both.size),
    )
    given = _ends_of_law(held)
    sampled = half_widths(drawn).reshape(2, -1).max(axis=0)
    # Of equal ones the largest: they stay together.
    off = np.zeros(coverage.size)
    np.maximum.at(off, back, given.bound[: back.size] * held.limits)
    varies = held.u > [output.resolution for output in held.outputs]
    return _OfTrials(
        interval=interval_of_values(ordered, coverage, "symmetric")[back],
        within=np.array(
            [
                (np.abs(values[k]) <= limit).mean()
                for k, limit in zip(place, held.limits, strict=True)
            ]
        ),
        ends=drawn,
        sampled=sampled,
        given=given,
        by_trials=(off[back] > sampled * held.limits) & varies,
    )


def _judge_by(values: Array, held: Limited) -> Judged:
    """Judge by trials of the outputs `_drawn_rows`, shape (n_drawn, trials) [SI]."""
    found = _of_trials(values, held)
    chosen = np.tile(found.by_trials, 2)
    places = np.searchsorted(_drawn_rows(held), held.rows)
    largest = np.zeros(values.shape[1])
    for place, limit in zip(places, held.limits, strict=True):
        np.maximum(largest, np.abs(values[place]) / limit, out=largest)
    inside = largest <= 1.0
    return _judged(
        held,
        interval=np.where(found.by_trials[:, None], found.interval, held.by_law),
        by_trials=found.by_trials,
        within=found.within,
        conformance=_binomial(int(inside.sum()), inside.size),
        largest=largest,
        ends=Ends(
            value=np.where(chosen, found.ends.value, found.given.value),
            # Where the law decides all there is none: of thousands all are kept.
            noise=np.where(
                chosen, found.ends.noise[: None if chosen.any() else 1], 0.0
            ),
            bound=np.where(chosen, 0.0, found.given.bound),
        ),
        given=found.given,
        sampled=found.sampled,
        trials=inside.size,
    )


def screen(held: Limited, *, seed: int) -> Judged:
    """Judge by the law alone: fast, and undecided where the law is not sure enough.

    The joint probability of a box has no closed form; it is counted in draws of the
    normal distribution with the law's means and joint covariance, and says nothing of
    what the law is off by: it has no interval. The utilisation of limits to be kept
    together has one, of the draws and of what the law is off by. Arguments as of
    `judge`.
    """
    from scipy.special import ndtr

    limits = held.limits
    mean, u = held.mean, held.u
    safe = np.where(u > 0.0, u, 1.0)
    within = np.where(
        u > 0.0,
        ndtr((limits - mean) / safe) - ndtr((-limits - mean) / safe),
        np.abs(mean) <= limits,
    )
    for k in np.flatnonzero(held.lengths >= 0):
        within[k] = held.law.probability_of_length(held.lengths[k], limits[k])
    largest = largest_of_normals(
        components_of(held),
        seed=seed,
        name=held.outputs[0].name.owner,
        is_joint=held.is_joint,
    )
    ends = _ends_of_law(held)
    return _judged(
        held,
        interval=held.by_law,
        by_trials=np.zeros(held.rows.size, dtype=bool),
        within=within,
        conformance=Probability(
            value=float((largest <= 1.0).mean()), low=None, high=None
        ),
        largest=largest,
        ends=ends,
        given=ends,
        sampled=np.zeros(held.rows.size),
        trials=None,
    )


def screened(held: Limited, *, seed: int, max_trials: int = MAX_TRIALS) -> Judged:
    """Judge by the law where it is sure, by trials where it is not; as `judge`."""
    judged = screen(held, seed=seed)
    return judge(held, seed=seed, max_trials=max_trials) if judged.is_open else judged


def can_sharpen(judged: Judged, max_trials: int, *, above: float) -> bool:
    """Whether more trials can make surer what reaches above a utilisation.

    They cannot where the law gave it, and is surer than the last of them would be: of
    limits to be kept together it gives none.
    """
    if judged.trials is None or judged.together is not None:
        return judged.trials is not None
    bound = judged.ends.bound.reshape(2, -1)[0]
    doubt = np.where(judged.by_trials, judged.sampled, bound)
    sharpest = judged.sampled * sqrt(judged.trials / max_trials)
    return bool(
        (judged.by_trials | (bound > sharpest))[judged.used + doubt > above].any()
    )


def assess_outputs(
    question: Question, judged: Judged, verdict: Verdict
) -> tuple[JudgedOutput, ...]:
    """Return every required output against its limit.

    Lines that are not given and by the verdict are negligible leave nothing open.
    """
    held = question.limits
    open_to = [verdict.matter(question.lacks[one.name]) for one in held.outputs]
    return tuple(
        JudgedOutput(
            output=output,
            limit=float(held.limits[k]),
            printed_limit=held.printed[k],
            standard_uncertainty=u_known(output, judged.u[k], open_to[k]),
            interval=(float(judged.interval[k, 0]), float(judged.interval[k, 1])),
            interval_by=BY_TRIALS if judged.by_trials[k] else BY_LAW,
            conformance=float(judged.within[k]),
            coverage=p if (p := float(held.coverage[k])) != held.usual else None,
        )
        for k, output in enumerate(held.outputs)
    )


def find_remedy(held: Limited, judged: Judged) -> Remedy:
    """Return the source that makes most of the worst output, and what would mend it.

    With the other sources as they are, k^2 (V - V_s + f^2 V_s) = (limit - |mean|)^2
    gives the factor f on its standard uncertainty, by the law and with the k of the
    interval that was judged; its small part in products with other sources is left as
    it is. Of a length, the circle that was judged goes as the law's does.
    """
    worst, law = judged.worst, held.law
    row = held.rows[worst]
    parts = law.source_variance[:, row]
    if not parts.size:  # a sensor without lines has the row of products alone
        return NO_REMEDY
    source = first_largest(parts.tolist())
    total = float(law.covariance[row, row])
    name = held.problem.groups[source].name
    if total == 0.0:
        return Remedy(source=name, share=0.0, factor=None)
    if held.lengths[worst] >= 0:
        factor = _of_length(held, judged, source)
        return Remedy(source=name, share=float(parts[source]) / total, factor=factor)
    k = float(judged.factor[worst])
    allowed = (max(held.limits[worst] - abs(held.mean[worst]), 0.0) / k) ** 2
    rest = total - float(parts[source])
    can_mend = allowed > rest and parts[source] > 0.0
    return Remedy(
        source=name,
        share=float(parts[source]) / total,
        factor=float(np.sqrt((allowed - rest) / parts[source])) if can_mend else None,
    )


def _of_length(held: Limited, judged: Judged, source: int) -> float | None:
    """Return the factor on a source that brings a length to its limit; None: none does.

    The ellipse of U - (1 - f^2) U_s gives a circle of the limit's radius, times what
    the law's circle is to that which was judged, its coverage.
    """
    from scipy.optimize import brentq

    law, worst = held.law, judged.worst
    legs = law.legs[:, held.lengths[worst]]
    part = covariance_by_source(held.problem, law)[source][np.ix_(legs, legs)]
    rest = law.covariance[np.ix_(legs, legs)] - part
    radius = held.by_law[[worst], 1] / judged.utilisation

    def excess(squared: float) -> float:
        (a, between), (_, b) = (rest + squared * part)[:, :, None]
        within = probability_within(radius, principal_variances(a, b, between))
        return float(within[0] - held.coverage[worst])

    if excess(0.0) <= 0.0:
        return None
    most = 1.0
    while excess(most) > 0.0:
        most *= GROWTH
    return float(np.sqrt(brentq(excess, 0.0, most, xtol=1e-15 * most)))


def together(judged: Sequence[Counted]) -> Probability:
    """Return the probability that all outputs of several problems are within.

    Counted in the same trials: sources that problems share have the same draws there.
    """
    n = min(one.inside.size for one in judged)
    inside = np.logical_and.reduce([one.inside.first(n) for one in judged])
    if any(one.trials is None for one in judged):
        return Probability(value=float(inside.mean()), low=None, high=None)
    return _binomial(int(inside.sum()), n)


def _judged(
    held: Limited,
    *,
    interval: Array,
    by_trials: NDArray[np.bool_],
    within: Array,
    conformance: Probability,
    largest: Array,
    ends: Ends,
    given: Ends,
    sampled: Array,
    trials: int | None,
) -> Judged:
    """Add to intervals what follows from them; `largest` is of every trial."""
    end = np.abs(interval).max(axis=1)
    used = end / held.limits
    u = held.u
    times = 1.0
    if held.is_joint:
        off = given.bound.max() if trials is None else 0.0
        ends = ends_together(largest, held.usual, off=off)
        times = ends.largest / max(used.max(), TINY)
    beyond_mean = times * end - np.abs(held.mean)
    return Judged(
        interval=interval,
        by_trials=by_trials,
        factor=np.where(u > 0.0, beyond_mean / np.where(u > 0.0, u, 1.0), 0.0),
        u=u,
        used=used,
        used_by_law=given.value.reshape(2, -1).max(axis=0),
        utilisation_interval=sampling_interval(ends),
        within=within,
        conformance=conformance,
        inside=Marks.of(np.asarray(largest <= 1.0)),
        ends=ends,
        sampled=sampled,
        trials=trials,
        together=held.usual if held.is_joint else None,
    )


def _ends_of_law(held: Limited) -> Ends:
    """Return the law's ends, which have a bound and no noise."""
    low, high = held.by_law.T
    off = end_accuracy(held.problem, held.law, held.every_coverage)[held.rows]
    return Ends(
        value=np.concatenate([high / held.limits, -low / held.limits]),
        noise=np.zeros((1, 2 * held.rows.size)),
        bound=np.tile(off / held.limits, 2),
    )


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
