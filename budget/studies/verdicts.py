"""Verdicts with their conditions: what would overturn them, and what they depend on.

On what is given the largest error is within its limit or beyond it
(budget.studies.judgement). Where it is within, three things may still overturn it: an
expected line that reaches a limited output and is not given; an environment or an age
that nobody has stated; a range. By the law of propagation, of a line of size s that is
not given, at its ceiling s_c (budget.studies.ceilings),

    U(s) = |mean| + k sqrt(V + sum of V_m + (s/s_c)^2 V_s) ,

V of what is given, V_m of the others that are not, at their ceilings. Its bound is the
largest s at which every U is within its limit; so it is of a temperature (variance
going with its square), of a vibration (with the fourth power of its rms) and of an age
(as its lines grow). Of a length, the ellipse in the place of V gives a circle.

    meets        nothing of that matters
    meets_if     it holds with every line at its ceiling, or a use is not stated
    undecidable  a line below its ceiling overturns it, or it has none
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import floor, inf, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from budget.aiding import (
    believed,
    journey_of,
    overconfident,
)
from budget.calibration.mission import Places, mission_outputs
from budget.calibration.saturation import (
    UNITS as SHOWN,
)
from budget.calibration.saturation import (
    needed_range,
    saturations,
)
from budget.calibration.schemes import calibrates, largest_of_test
from budget.distributions import normal_coverage_factor
from budget.inputs.makers import bare, lines_by_word
from budget.inputs.records import JOINT
from budget.inputs.specification import read_value, time_of
from budget.inputs.station import IDEAL
from budget.inputs.use import LINES, STATED, stated_of
from budget.known import Known
from budget.methods.gum import covariance_by_source
from budget.methods.radius import principal_variances, radius_of
from budget.missing import line_of, shipped_devices, usual_line
from budget.missing.grades import FAMILIES, family
from budget.missing.prediction import stand_in
from budget.model.course import Fading
from budget.model.sources import ACCELEROMETER, ENVIRONMENT, GYRO, SOURCES, source_of
from budget.model.sources.later import (
    AGE,
    AGEING,
    MISSION_TEMPERATURE,
    RECTIFICATION,
    TEST_VIBRATION,
    growth,
)
from budget.model.sources.temperature import (
    COEFFICIENTS,
    RATE_COEFFICIENT,
)
from budget.names import AIDING, Name, time_text, words
from budget.results import TINY, VERDICTS, Condition, Verdict
from budget.sentences import sentence
from budget.studies.cautions import beyond_first_order
from budget.studies.ceilings import (
    BY_NATURE,
    at_most,
    ceilings,
    largest_printed,
    printed_by_others,
)
from budget.studies.doubt import doubt_of
from budget.studies.jointly import Jointly, components_of
from budget.studies.judgement import (
    TRIALS,
    assess_outputs,
    find_remedy,
    interval_by_law,
    judge,
)
from budget.studies.readings import verdict_of
from budget.ties import from_largest, settle
from budget.units import STANDARD_GRAVITY, YEAR, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.calibration.saturation import Peak
    from budget.inputs.records import (
        Device,
        ErrorLine,
        Mission,
        Procedure,
        Sensor,
    )
    from budget.methods.gum import Propagation
    from budget.question import Limited, Question
    from budget.results import Doubt, ReadingVerdicts
    from budget.studies.ceilings import Ceiling
    from budget.studies.judgement import Judged

MEETS, MEETS_IF, PREDICTED, UNDECIDED, UNDECIDABLE, FAILS = VERDICTS
LATER = "next_turn_on"  # the error reference that a use is of
# By the parameter: coefficient, and the residual over temperature that says it too.
BY_TEMPERATURE = {
    getattr(one.effect, "target", ""): (one.left_of[0], one.name)
    for one in SOURCES
    if one.left_of
}
# Lines of which a sheet has to say more than a value, and one that a level use needs.
NONLINEARITY, SAMPLE_NOISE = "scale_factor_nonlinearity", "sample_noise"
STABILITY, ALLAN_FLOOR = "bias_stability", "allan_minimum"
G_SENSITIVITY, QUANTIZATION = "g_sensitivity", "quantization"
MEMS = "mems"
NOT_MEMS = {*FAMILIES, "optical"} - {MEMS}
SATURATES, NO_TIME = "saturates", "no_correlation_time"
# What a use that nobody has stated is tried at.
PROBE = {
    key: read_value(source_of(ENVIRONMENT, STATED[key][0]), ENVIRONMENT, quantity).line
    for key, quantity in (
        ("temperature", parse_quantity("1 degC", "degC")),
        ("vibration", parse_quantity("1 g", "g")),
        ("age", parse_quantity("1 year", "s")),
    )
}
SAME = 1e-9  # relative, of a bound [1]
CLOSE = 1e-4 * SAME  # of the ends between which it is looked up
# A line reaches a limit where u at its ceiling is more than this part of it; without
# one, where so many times the largest that any device prints is [1].
NEGLIGIBLE, FAR_ABOVE = 0.005, 10.0
# Lines through which the environment of a test acts.
IN_TEST = {
    "temperature": COEFFICIENTS,
    "vibration": (RECTIFICATION,),
}
SHORT = 1.0  # correlation time of a bias stability that is none [s]
DOUBLINGS = 200  # of a bound, from one probe on
HALVINGS = 60  # to the rounding of a double


def decide(
    question: Question,
    judged: Judged,
    *,
    seed: int,
    doubt: Doubt | None = None,
    readings: ReadingVerdicts | None = None,
) -> Verdict:
    """Return the verdict on a question, the same in every command.

    Parameters
    ----------
    question : Question
    judged : Judged
        How it stands on what is given and on what stands for lines that are not.
    seed : int
        Of trials, where the law is not sure enough.
    doubt : Doubt, optional
        Of missing lines that are predicted.
    readings : ReadingVerdicts, optional
        Verdicts under other readings of lines whose meaning is open.
    """
    found = _decided(question, judged, seed=seed, doubt=doubt, readings=readings)
    aided = tuple(_of_aids(question))
    found = replace(found, cautions=(*found.cautions, *aided))
    if found.verdict in {UNDECIDABLE, FAILS}:
        return found
    lost = (
        *(one for one in found.cautions if one.kind == NO_TIME),
        *_lost(question),
    )
    if not lost:
        return found
    return replace(
        found,
        verdict=UNDECIDED,
        conditions=lost,
        cautions=tuple(dict.fromkeys((*lost, *found.cautions))),
    )


def _of_aids(question: Question) -> Iterator[Condition]:
    """Yield what an aided mission is judged with, and where its filter is too sure."""
    mission, held = question.journey, question.limits
    outputs = held.outputs
    if mission is None or not mission.aiding:
        return
    times = Places.of([output.name for output in outputs]).times
    spans = [span for aid in mission.aiding for span in aid.spans]
    during = [t for t in times if any(begin < t <= end for begin, end in spans)]
    if during:
        text = sentence("conditions.aided", times=during)
        yield Condition(kind="aided", line=Name(AIDING), text=text)
    if mission.filter is not None and question.only is None:
        journey = journey_of(mission, times, question.sensors, question.procedure)
        errors = believed(
            journey, outputs, question.law.standard_uncertainty[held.rows]
        )
        for said in overconfident(errors):
            yield Condition(kind="filter", line=Name(AIDING), text=said)


def _lost(question: Question) -> tuple[Condition, ...]:
    """Return what leaves a verdict open where first order ends before a limit."""
    if question.journey is None:
        return ()
    times = dict.fromkeys(output.name.time or 0.0 for output in question.limits.outputs)
    attitudes = [
        name
        for name in mission_outputs(question.journey, times)
        if name.quantity == "attitude"
    ]
    own = replace(question, asked=tuple(attitudes), requirement=None, only=None)
    return tuple(
        Condition(
            kind="first_order",
            line=attitudes[-1].group,
            text=text,
        )
        for text in beyond_first_order(own.problem, own.law)
    )


def _decided(
    question: Question,
    judged: Judged,
    *,
    seed: int,
    doubt: Doubt | None,
    readings: ReadingVerdicts | None,
) -> Verdict:
    """Return the verdict as far as the equations are of first order."""
    silent = unjudged(question)
    cautions, words = silent.cautions, replace(silent, conditions=())
    given = verdict_of(judged, question.limits.absent, doubt=doubt, readings=readings)
    if any(one.kind == SATURATES for one in cautions):
        given = FAILS
    if question.only is not None and given == MEETS:
        return replace(
            words,
            verdict=MEETS_IF,
            conditions=(
                Condition(
                    kind="only",
                    line=min(question.only),
                    text=sentence("conditions.chosen"),
                ),
            ),
            cautions=cautions,
        )
    if given == FAILS or question.only:
        return replace(words, verdict=given, cautions=cautions)
    if not any(one.lines for one in question.there):
        return silent
    margin = Margin.of(question, judged, seed=seed)
    # What is predicted is in the doubt; what else nothing bounds decides all the same.
    decisive = margin.decisive if doubt is None else margin.without_ceiling
    conditions = tuple(
        margin.of_line(name, alone=bool(decisive))
        for name in (decisive or margin.missing)
        if doubt is None or decisive
    )
    if not decisive:  # whatever a line is, it is no condition
        conditions = tuple(one for one in conditions if one.below is not None)
    uses = uses_of(question, margin)
    verdict = given
    if decisive and given in {MEETS, UNDECIDED, PREDICTED}:
        verdict = UNDECIDABLE
    elif given == MEETS and (conditions or uses):
        verdict = MEETS_IF
    return replace(
        words,
        verdict=verdict,
        conditions=(*conditions, *uses),
        cautions=(*conditions, *uses, *cautions),
        at_ceilings=margin.at_ceilings,
        negligible=tuple(x for x in expected_of(question) if x not in margin.missing),
    )


def uses_of(question: Question, margin: Margin) -> tuple[Condition, ...]:
    """Return the conditions on the use, as far as nobody has stated it."""
    uses = (
        *(one for key in unstated(question) for one in margin.of_use(key, question)),
        *ranges_of(question),
    )
    if uses or not unstated(question):
        return uses
    text = sentence("conditions.as_in_its_test")
    return (Condition(kind="environment", line=Name(ENVIRONMENT), text=text),)


def _temperatures_of_test(procedure: Procedure) -> frozenset[Name]:
    """Return the sources of a temperature that changes in the test itself."""
    return frozenset(
        Name(line.name, owner=ENVIRONMENT)
        for line in procedure.environment
        if line.name.startswith("temperature") and line.name not in LINES
        if line.u.any()
    )


def _exercised_in_test(question: Question) -> tuple[str, ...]:
    """Return what acts in the test itself: its temperature, its vibration."""
    found = {
        "temperature": bool(_temperatures_of_test(question.procedure)),
        "vibration": any(
            line.name == TEST_VIBRATION and line.u.any()
            for line in question.procedure.environment
        ),
    }
    return tuple(key for key, acts in found.items() if acts)


def lacking_in_test(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given of what acts in the test itself.

    A residual over temperature says nothing of it: that is of a later use.
    """
    exercised = _exercised_in_test(question)
    return tuple(
        Name(line, owner=sensor.kind)
        for sensor in question.there
        for key in exercised
        for line in IN_TEST[key]
        if sensor.lines and sensor.line(line) is None
    )


def unjudged(question: Question) -> Verdict:
    """Return how it stands before anything is computed: what it lacks decides."""
    requirement = question.wanted
    return Verdict(
        verdict=UNDECIDABLE,
        sensor=question.owner,
        conditions=tuple(
            Condition(
                kind="missing",
                line=name,
                below=None,
                unit=line.unit,
                si_per_unit=line.si_per_unit,
                decides=True,
                text=sentence("conditions.decides", line=name),
            )
            for name in expected_of(question)
            for line in [usual_line(name)]
        ),
        cautions=cautions_of(question),
        calibration=calibration_words(question.procedure),
        station=station_words(question.procedure),
        use=use_words(question.procedure, is_later=question.is_later),
        mission="" if question.journey is None else question.journey.name,
        decision=sentence(
            "conditions.decision",
            is_joint=requirement.decision == JOINT,
            coverage=requirement.coverage,
        ),
    )


def verdict_on(
    question: Question,
    judged: Judged,
    *,
    seed: int,
    readings: ReadingVerdicts | None = None,
) -> Verdict:
    """Return the verdict on a question with its numbers; arguments as of `decide`."""
    held, law = question.limits, question.law
    prediction, missing = question.filled.prediction, question.missing
    doubt = None
    if prediction is not None and not missing and not held.absent:
        doubt = doubt_of(prediction, held, law, judged)
    found = decide(question, judged, seed=seed, doubt=doubt, readings=readings)
    outputs = assess_outputs(held, judged, found, question.lacks)
    why = tuple(dict.fromkeys(name for row in outputs for name in row.lacks))
    is_bound = found.misses or bool(why)
    return replace(
        found,
        outputs=outputs,
        utilisation=Known(judged.utilisation, high=inf if is_bound else None, why=why),
        utilisation_interval=judged.utilisation_interval,
        worst_outputs=tuple(held.outputs[k].name for k in judged.all_worst),
        remedy=find_remedy(held, law, judged),
        conformance=judged.conformance,
        at_medians=prediction is not None,
        trials=judged.trials,
        expected_missing=found.matter(missing),
        nothing_known=not question.has_lines,
        doubt=doubt,
        not_estimated=held.absent,
        readings=readings,
    )


def stand(question: Question, *, seed: int) -> Verdict | None:
    """Judge a question, by few trials where they are needed; None: it has no limit."""
    if question.held is None:
        return None
    judged = judge(question.held, question.law, seed=seed, max_trials=TRIALS)
    return decide(question, judged, seed=seed)


def gravest(verdicts: Iterable[str]) -> str:
    """Return what parts are together: one that fails, fails."""
    return max(verdicts, key=VERDICTS.index)


@dataclass(frozen=True, kw_only=True, eq=False)
class Margin:
    """Room that there is for what is not given and what nobody has stated.

    Attributes
    ----------
    missing : tuple of Name
        Expected lines that are not given and reach a limited output.
    tops : mapping of Name to Ceiling
        Of those that have one.
    groups : mapping of str to tuple of int
        Groups of `parts` that a missing line, or a use by its key, stands for.
    ages : mapping of int to ErrorLine
        Lines of ageing, by their group.
    silent : mapping of str to tuple of Name
        By the use: lines of it that reach a limited output and are not given.
    parts : ndarray, shape (n_groups, n_required, 2, 2)
        Covariance that each group makes: of a length of both components, of others the
        variance in the first place [SI squared].
    rest : ndarray, shape (n_required, 2, 2)
        Of all that is given.
    mean : ndarray, shape (n_required,)
        Absolute [SI].
    factor : tuple of ndarray, shape (n_required,) each
        Coverage factors on what is given, and with all lines at their ceilings [1].
    ratio : ndarray, shape (n_required,)
        Of a length what was judged over the circle of the law [1].
    jointly : Jointly, optional
        Of limits to be kept together what decides in the place of these.
    """

    held: Limited
    missing: tuple[Name, ...]
    filled: tuple[Name, ...]  # those that something stands for
    sizes: Mapping[Name, float]  # that their groups are of [SI]
    tops: Mapping[Name, Ceiling]
    groups: Mapping[str, tuple[int, ...]]
    ages: Mapping[int, ErrorLine]
    silent: Mapping[str, tuple[Name, ...]]
    parts: Array
    rest: Array
    mean: Array
    factor: tuple[Array, Array]
    ratio: Array
    jointly: Jointly | None = None

    @classmethod
    def of(
        cls,
        question: Question,
        judged: Judged,
        *,
        seed: int,
    ) -> Margin:
        """Compute what each missing line and each use that is not stated makes."""
        held, law = question.limits, question.law
        names = expected_of(question)
        stands = {one.expected: one for one in question.filled.lines}
        silent = silent_of(question)
        every = dict.fromkeys((*names, *(name for x in silent.values() for name in x)))
        tops = {
            name: one
            for device in question.sheets or question.devices
            for own in [{sensor.kind for sensor in device.sensors}]
            for name, one in ceilings(
                device,
                [name for name in every if name.owner in own],
                question.catalogue,
            ).items()
        }
        sizes = {name: tops[name].u if name in tops else _one(name) for name in every}
        comparable = {name for name in tops if tops[name].origin != BY_NATURE}
        in_test = [x for x in lacking_in_test(question) if x.quantity in COEFFICIENTS]
        lines = {
            name: _standing(question, name, sizes[name])
            for name in names
            if name not in in_test or name in _lacking_stated(question)
        }
        probes = {
            name: _standing(question, name, sizes[name])
            for x in silent.values()
            for name in x
        }
        found_of = question.with_lines(lines | probes).in_use(
            [PROBE[key] for key in unstated(question)]
        )
        whole, found = found_of.limits, found_of.law
        parts = np.concatenate(
            [
                _parts(whole, found),
                *(_of_test(question, name, sizes[name]) for name in in_test),
            ]
        )
        places = {group.name: k for k, group in enumerate(whole.problem.groups)}
        known: dict[str, tuple[Name, ...]] = {
            **{
                name: (Name(line.name, owner=name.owner),)
                for name, line in (lines | probes).items()
            },
            **{name: (one.source,) for name, one in stands.items()},
            **{
                key: (
                    *_felt_by(question, key),
                    *(
                        Name(probes[name].name, owner=name.owner)
                        for name in silent[key]
                        if comparable >= {*silent[key]}
                    ),
                )
                for key in unstated(question)
            },
        }
        groups = {
            name: tuple(places[own] for own in several if own in places)
            for name, several in known.items()
        }
        for k, name in enumerate(in_test, start=len(places)):
            groups[name] = (*groups.get(name, ()), k)
        least = np.array([output.resolution for output in held.outputs]) ** 2

        def variance(name: str) -> Array:
            own = parts[list(groups[name])].sum(axis=0)
            return np.asarray(own[:, [0, 1], [0, 1]].max(axis=1))

        def reaches(name: str) -> bool:
            return bool((variance(name) > least).any())

        def matters(name: Name) -> bool:
            size = 1.0
            if name not in tops and name not in stands:
                most = largest_printed(name, question.catalogue)
                size = inf if most is None else FAR_ABOVE * most / sizes[name]
            share = float((np.sqrt(variance(name)) / held.limits).max())
            return reaches(name) and size * share > NEGLIGIBLE

        rest = _parts(held, law, whole=True)[0]
        rest = rest - sum(
            (parts[list(groups[name])].sum(axis=0) for name in stands), 0.0
        )
        circle = np.abs(interval_by_law(held, law)).max(axis=1)
        is_length = held.rows >= law.value.size - law.legs.shape[1]
        margin = cls(
            held=held,
            missing=tuple(name for name in (*names, *stands) if matters(name)),
            filled=tuple(stands),
            sizes=sizes | {name: one.u for name, one in stands.items()},
            tops=tops,
            groups=groups,
            ages={
                places[Name(line.name, owner=sensor.kind)]: line
                for sensor in question.there
                for line in sensor.lines
                if line.name in AGEING.values()
                if Name(line.name, owner=sensor.kind) in places
            }
            | {
                places[name]: line
                for name, line in (lines | probes).items()
                if line.name in AGEING.values() and name in places
            },
            silent={
                key: tuple(name for name in own if reaches(name))
                for key, own in silent.items()
            },
            parts=parts,
            rest=rest,
            mean=np.abs(law.mean[held.rows]),
            factor=(_factor(held, judged),) * 2,
            ratio=np.where(
                is_length, judged.used * held.limits / np.maximum(circle, TINY), 0.0
            ),
        )
        if held.is_joint:
            margin = replace(
                margin, jointly=_jointly(margin, whole, found, law, judged)
            )
        if any(family(one.technology) != MEMS for one in question.devices):
            untold = {Name(G_SENSITIVITY, owner=GYRO)} - tops.keys()
            margin = replace(
                margin, missing=tuple(x for x in margin.missing if x not in untold)
            )
        margin = margin.less([x for x in margin.missing if _is_suspected(question, x)])
        if margin.without_ceiling or not (lines and judged.by_trials.any()):
            return margin
        full = question.with_lines(lines)
        top = full.limits
        at_top = judge(top, full.law, seed=seed, max_trials=TRIALS)
        if margin.jointly is not None:
            top_known = (margin.weights, at_top.utilisation)
            both = (*margin.jointly.known, top_known)
            margin = replace(margin, jointly=replace(margin.jointly, known=both))
        return replace(margin, factor=(margin.factor[0], _factor(top, at_top)))

    @cached_property
    def weights(self) -> Array:
        """Times that the variance of each group counts at the ceilings, (n_groups,)."""
        found = np.zeros(len(self.parts))
        for name in self.missing:
            found[list(self.groups[name])] = name in self.tops or name in self.filled
        return found

    def less(self, suspected: Sequence[Name]) -> Margin:
        """Return it without lines that overturn nothing, or of which nobody knows."""
        least = replace(
            self, missing=tuple(x for x in self.missing if x not in suspected)
        )
        known = (x for x in suspected if x in self.tops)
        most = replace(self, missing=(*least.missing, *known))
        used, at_first = (settle(one.used(one.weights)) for one in (most, least))
        return most if used > 1.0 >= at_first else least

    @property
    def added(self) -> Array:
        """Covariance that missing lines add at their ceilings, as one of `parts`."""
        weights = self.weights.copy()
        for name in self.filled:
            weights[list(self.groups[name])] = 0.0  # it is in what is given
        return np.asarray(np.tensordot(weights, self.parts, axes=1))

    @property
    def without_ceiling(self) -> tuple[Name, ...]:
        """Missing lines that nothing bounds."""
        return tuple(
            name
            for name in self.missing
            if name not in {*self.tops, *self.filled}
            if name.quantity != RATE_COEFFICIENT
        )

    @cached_property
    def at_ceilings(self) -> float | None:
        """Utilisation with all missing lines at their ceilings; None: one has none."""
        if self.without_ceiling:
            return None
        return self.used(self.weights)

    @cached_property
    def decisive(self) -> tuple[Name, ...]:
        """Missing lines that overturn a verdict, the one to ask for first.

        No more than are needed: with these at 0 all others may be at their ceilings.
        """
        if none := self.without_ceiling:
            return none
        weights = self.weights.copy()
        places = [list(self.groups[name]) for name in self.missing]
        sizes = [
            float((self.parts[own].sum(axis=0)[:, 0, 0] / self.held.limits**2).max())
            for own in places
        ]
        asked: list[Name] = []
        for k in from_largest(sizes):
            if settle(self.used(weights)) <= 1.0:
                break
            weights[places[k]] = 0.0
            asked.append(self.missing[k])
        return tuple(asked)

    def used(self, weights: Array) -> float:
        """Return the utilisation with groups at so many times their variance [1].

        Parameters
        ----------
        weights : ndarray, shape (n_groups,)
            Of what is not among the given.
        """
        if self.jointly is not None:
            return self.jointly.used(weights)
        added = weights @ self._variances
        # From the factor of what is given to that with all lines at their ceilings.
        factor, top = self.factor[0], self._top
        if self.factor[0] is not self.factor[1]:
            grown = np.minimum(added, top) / np.maximum(top, TINY)
            factor = factor + (self.factor[1] - factor) * grown
        variance = np.maximum(self.rest[:, 0, 0] + added, 0.0)
        ends = self.mean + factor * np.sqrt(variance)
        if self.ratio.any():
            C = self.rest + np.tensordot(weights, self.parts, axes=1)
            for j in np.flatnonzero(self.ratio):
                axes = principal_variances(C[j, :1, 0], C[j, 1:, 1], C[j, :1, 1])
                circle = radius_of(self.held.coverage[[j]], axes)
                ends[j] = self.ratio[j] * float(circle[0])
        return float((ends / self.held.limits).max())

    @cached_property
    def _variances(self) -> Array:
        """Variance that each group makes, of a length of its first component."""
        return np.ascontiguousarray(self.parts[:, :, 0, 0])

    @cached_property
    def _top(self) -> Array:
        """Variance that is added at the ceilings, shape (n_required,) [SI squared]."""
        return np.asarray(self.weights @ self._variances)

    def bound(self, change: Callable[[Array, float], None], *, alone: bool) -> float:
        """Return the largest size at which every output is within its limit.

        `change` puts a size into the weights; all others are at their ceilings, or
        `alone` at 0. inf where no size matters, 0 where none will do.
        """

        def excess(size: float) -> float:
            weights = np.zeros_like(self.weights) if alone else self.weights.copy()
            change(weights, size)
            return self.used(weights) - 1.0

        if settle(1.0 + excess(0.0)) > 1.0:
            return 0.0
        low, high = 0.0, 1.0
        for _ in range(DOUBLINGS):
            if excess(high) > 0.0:
                break
            high *= 2.0
        else:
            return inf
        is_beyond = _looked_up(excess, low, high)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_beyond(middle) else (middle, high)
            if high - low <= SAME * high:
                break
        return low

    def of_line(self, name: Name, *, alone: bool) -> Condition:
        """Return what a missing line may be; `alone`: all other missing ones 0."""
        places = list(self.groups[name])

        def change(weights: Array, times: float) -> None:
            weights[places] = times**2

        below = self.bound(change, alone=alone) * self.sizes[name]
        if not alone and below >= at_most(name):  # what no sensor reaches
            below = inf
        top = self.tops.get(name)
        largest = None if top is None else top.largest_comparable
        source = stand_in(name)
        printed = below if 0.0 < below < inf else None
        if printed and not alone:  # a size below the bound is within it
            one = usual_line(name).si_per_unit
            printed = rounded_down(below / one, 3) * one
        line = line_of(source, name.owner, printed) if printed else usual_line(name)
        known = None if below == inf else below
        return Condition(
            kind="missing",
            line=name,
            below=known,
            unit=line.unit,
            si_per_unit=line.si_per_unit,
            largest_comparable=None if largest is None else largest.u,
            ceiling=None if top is None else top.u,
            decides=alone,
            text=sentence(
                "conditions.missing",
                line=name,
                below=known,
                bound=line.printed,
                top=None if top is None else top.u,
                largest=largest and line_of(source, name.owner, largest.u).printed,
                alone=alone,
            ),
        )

    def of_use(self, key: str, question: Question) -> tuple[Condition, ...]:
        """Return the conditions of a use that nobody has stated, and that reaches."""
        found = []
        silent = self.silent.get(key, ())
        unknown = tuple(
            name
            for name in silent
            if name not in self.tops or self.tops[name].origin == BY_NATURE
        )
        if (size := self.use_bounds.get(key)) is not None:
            tops = [] if unknown else [self.tops[name] for name in silent]
            found.append(_bounded(key, size * _tried_at(key), tops))
        if key == "age":
            found += _horizon(question)
        if unknown:
            text = sentence("conditions.silent", use=key, lines=unknown)
            found.append(_on_use(key, text, silent=unknown))
        if not found and _is_felt(question, key):
            found.append(_on_use(key, sentence("conditions.over_temperature")))
        return tuple(found)

    @cached_property
    def use_bounds(self) -> Mapping[str, float]:
        """Largest sizes of the uses that nobody has stated, over those tried [1].

        Each alone first, then all of them by one factor, at which every output is
        within its limit with all of them there.
        """
        places = {
            key: [k for k in self.groups.get(key, ()) if self._reaches(k)]
            for key in STATED
        }

        def change(sizes: Mapping[str, float]) -> Callable[[Array, float], None]:
            def put(weights: Array, times: float) -> None:
                for key, size in sizes.items():
                    for k in places[key]:
                        weights[k] = self._grown(key, k, times * size)

            return put

        alone = {
            key: self.bound(change({key: 1.0}), alone=False)
            for key, own in places.items()
            if own
        }
        within = {key: size for key, size in alone.items() if 0.0 < size < inf}
        if len(within) > 1:
            factor = min(self.bound(change(within), alone=False), 1.0)
            alone |= {key: factor * size for key, size in within.items()}
        return alone

    def _reaches(self, group: int) -> bool:
        """Say whether a group makes anything of what is limited."""
        return bool(self.parts[group].any())

    def _grown(self, key: str, group: int, size: float) -> float:
        """Return the variance of a group at so many times the use that was tried."""
        if key != "age":
            return size ** (2 if key == "temperature" else 4)
        line, year = self.ages[group], _tried_at(key)
        return (growth(line, size * year) / growth(line, year)) ** 2


def _looked_up(
    excess: Callable[[float], float], low: float, high: float
) -> Callable[[float], bool]:
    """Return whether `excess`, which grows from `low` to `high`, is above 0 at a size.

    Regula falsi (Illinois) brackets where it turns; between the ends of that it is
    asked, which for halvings is hardly ever.
    """
    ends, values = [low, high], [excess(low), excess(high)]
    last = None
    for _ in range(HALVINGS):
        step = values[0] / (values[0] - values[1])
        middle = ends[0] + (ends[1] - ends[0]) * step
        if not ends[0] < middle < ends[1] or ends[1] - ends[0] <= CLOSE * ends[1]:
            break
        value = excess(middle)
        side = int(value > 0.0)
        ends[side], values[side] = middle, value
        if last == side:
            values[1 - side] /= 2.0
        last = side

    def is_beyond(size: float) -> bool:
        if ends[0] < size < ends[1]:
            return excess(size) > 0.0
        return size >= ends[1]

    return is_beyond


def _tried_at(key: str) -> float:
    """Return the size at which a use that nobody has stated is tried [SI]."""
    return float(PROBE[key].u[0])


def _one(name: Name) -> float:
    """Return a size of 1 in the most usual unit of a line [SI]."""
    return float(usual_line(name).u[0])


def _factor(held: Limited, judged: Judged) -> Array:
    """Return the coverage factors that were judged by; of what is 0 the normal ones."""
    usual = np.array([normal_coverage_factor(p) for p in held.coverage.tolist()])
    return np.where(judged.factor > 0.0, judged.factor, usual)


def _jointly(
    margin: Margin,
    whole: Limited,
    found: Propagation,
    law: Propagation,
    judged: Judged,
) -> Jointly:
    """Return what limits to be kept together have room for: `whole` is with `parts`."""
    of = components_of(margin.held.rows, margin.held.limits, law)
    of_whole = components_of(whole.rows, whole.limits, found)
    parts = of_whole.scaled(covariance_by_source(whole.problem, found)[:-1])
    given = np.zeros(len(parts))
    for name in margin.filled:
        given[list(margin.groups[name])] = 1.0
    return Jointly(
        of=of,
        rest=of.covariance - np.tensordot(given, parts, axes=1),
        parts=parts,
        coverage=margin.held.usual,
        known=((given, judged.utilisation),),
    )


def _parts(held: Limited, law: Propagation, *, whole: bool = False) -> Array:
    """Return the covariance that each group makes, as Margin has it.

    Of the `whole` law in one.
    """
    n = law.value.size - law.legs.shape[1]
    has_lengths = bool((held.rows >= n).any())
    variance = np.diag(law.covariance)[None] if whole else law.source_variance
    found = np.zeros((len(variance), held.rows.size, 2, 2))
    found[:, :, 0, 0] = variance[:, held.rows]
    if has_lengths:
        each = (
            law.covariance[None, :n, :n]
            if whole
            else covariance_by_source(held.problem, law)[:-1]
        )
        for j in np.flatnonzero(held.rows >= n):
            legs = law.legs[:, held.rows[j] - n]
            found[:, j] = each[:, legs[:, None], legs[None, :]]
    return found


def expected_of(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given and that the question exercises.

    The expected ones; what temperature and vibration do where these are stated or the
    test has its own; the g-sensitivity of a MEMS gyro, and on a route that turns or
    climbs of one that may be.
    """
    if question.only is not None:
        return ()
    names = [name for sensor in question.there for name in sensor.expected_missing]
    names += [*_lacking_stated(question), *lacking_in_test(question)]
    families = {
        family(device.technology)
        for device in question.devices
        for sensor in device.sensors
        if sensor.kind == GYRO
    }
    gyros = [one for one in question.there if one.kind == GYRO]
    if (
        gyros
        and gyros[0].line(G_SENSITIVITY) is None
        # A technology that nobody has told, or that nobody knows, may be MEMS.
        and not families & NOT_MEMS
        and (question.journey is not None or calibrates(GYRO, question.procedure))
    ):
        names.append(Name(G_SENSITIVITY, owner=GYRO))
    filled = {one.expected for one in question.filled.lines}
    return tuple(dict.fromkeys(name for name in names if name not in filled))


def _is_suspected(question: Question, name: Name) -> bool:
    """Say whether a line counts only where at its ceiling it overturns a verdict.

    The g-sensitivity of a gyro that does not turn in gravity.
    """
    is_level = question.journey is not None and not manoeuvres(question.journey)
    # Beside a use that nobody has stated it is one condition more.
    return is_level and name.quantity == G_SENSITIVITY and not unstated(question)


def _lacking_stated(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given of a temperature and a vibration stated."""
    stated = stated_of(question.procedure) if question.is_later else {}
    return tuple(
        name
        for key, line in stated.items()
        if key != "age" and line.u.any()
        for name in lacking_use(question, key)
    )


def manoeuvres(mission: Mission) -> bool:
    """Say whether a route turns, climbs or speeds up; a recorded one may always."""
    legs = getattr(mission.route, "legs", None)
    if legs is None:
        return True
    return any(leg.turn_rate or leg.climb_rate or leg.acceleration for leg in legs)


def lacking_use(question: Question, key: str) -> tuple[Name, ...]:
    """Return the lines of a use that are not given: what it does to the triads.

    A figure that holds over temperature says what a temperature does that stays as it
    is, and one that holds over a time what age does.
    """
    found: list[Name] = []
    for sensor in question.there:
        if key == "vibration" and sensor.line(RECTIFICATION) is None:
            found.append(Name(RECTIFICATION, owner=sensor.kind))
        for parameter, (coefficient, residual) in BY_TEMPERATURE.items():
            own = sensor.line(f"{parameter}_repeatability")
            is_said = sensor.line(residual) or _includes(own, "temperature")
            is_known = sensor.line(coefficient) or (is_said and not _moves(question))
            if key == "temperature" and not is_known:
                found.append(Name(coefficient, owner=sensor.kind))
            ageing = AGEING[parameter]
            if key == "age" and not sensor.line(ageing) and not _lasts(own):
                found.append(Name(ageing, owner=sensor.kind))
    return tuple(found)


def _moves(question: Question) -> bool:
    """Say whether the temperature changes on the way.

    A residual over temperature is one constant there, which a filter learns: of the
    change it says nothing.
    """
    line = stated_of(question.procedure).get("temperature")
    course = None if line is None else line.course
    if question.journey is None or course is None:
        return False
    values = course.at(np.array([0.0, *course.cuts, question.journey.route.duration]))
    return bool(np.ptp(values))


def _includes(line: ErrorLine | None, word: str) -> bool:
    """Say whether a line includes something, by its maker's words."""
    parts = "" if line is None else line.includes.replace(";", ",")
    return word in {part.strip() for part in parts.split(",")}


def _lasts(line: ErrorLine | None) -> bool:
    """Say whether a line holds over a time that its maker names."""
    return line is not None and time_of(line.horizon) is not None


def unstated(question: Question) -> tuple[str, ...]:
    """Return what of its use nobody has stated: temperature, vibration, age."""
    if not question.is_later:
        return ()
    stated = stated_of(question.procedure)
    return tuple(key for key in STATED if key not in stated)


def silent_of(question: Question) -> Mapping[str, tuple[Name, ...]]:
    """Return by the use that is not stated the lines of it that are not given."""
    return {key: lacking_use(question, key) for key in unstated(question)}


def _felt_by(question: Question, key: str) -> tuple[Name, ...]:
    """Return the sources that a use acts through."""
    if key == "temperature":
        return (Name(MISSION_TEMPERATURE, owner=ENVIRONMENT),)
    lines = (RECTIFICATION,) if key == "vibration" else tuple(AGEING.values())
    return tuple(
        Name(line.name, owner=sensor.kind)
        for sensor in question.there
        for line in sensor.lines
        if line.name in lines
    )


def _standing(question: Question, name: Name, u: float) -> ErrorLine:
    """Return the line that stands for one that is not given, of a size [SI].

    Of a coefficient of temperature what it makes of the temperature that is stated: a
    residual on each axis, whose sign nobody knows. Where that is known at every time of
    a mission the coefficient is a constant itself.
    """
    stated = stated_of(question.procedure).get("temperature")
    for coefficient, residual in BY_TEMPERATURE.values():
        if name.quantity == coefficient and not (stated and stated.course):
            size = float((stated or PROBE["temperature"]).u[0])
            return line_of(source_of(name.owner, residual), name.owner, u * size)
    return line_of(stand_in(name), name.owner, u)


def _of_test(question: Question, name: Name, size: float) -> Array:
    """Return the covariance that one coefficient has of the temperature of a test.

    Alone, as its sign beside that of others is not known: shape (1, n_required, 2, 2).
    """
    line = line_of(stand_in(name), name.owner, size)
    alone = question.with_lines({name: line}, less=COEFFICIENTS)
    own = alone.limits
    there = _temperatures_of_test(question.procedure)
    rows = [k for k, group in enumerate(own.problem.groups) if group.name in there]
    parts = _parts(own, alone.law)[rows]
    return np.asarray(parts.sum(axis=0, keepdims=True))


def _bounded(key: str, below: float, tops: Sequence[Ceiling]) -> Condition:
    """Return the condition on a use: of lines that are given, and `tops` of others."""
    known = None if below == inf else below
    text = sentence(
        "conditions.within",
        use=key,
        bound=None if known is None else _bound(key, known),
        tops=[(one.name, one.printed) for one in tops],
    )
    return _on_use(key, text, below=known)


def _on_use(
    key: str,
    text: str,
    *,
    below: float | None = None,
    silent: tuple[Name, ...] = (),
) -> Condition:
    """Return a condition on a use that nobody has stated."""
    return Condition(
        kind=key,
        line=Name(STATED[key][0], owner=ENVIRONMENT),
        text=text,
        below=below,
        unit=PROBE[key].unit,
        si_per_unit=PROBE[key].si_per_unit,
        silent=silent,
    )


def rounded_down(value: float, digits: int) -> float:
    """Return the next number below that has so many digits."""
    if value <= 0.0:
        return 0.0
    step = 10.0 ** (floor(log10(value)) - digits + 1)
    return float(f"{floor(settle(value / step)) * step:.{digits}g}")


def _bound(key: str, size: float) -> str:
    """Write a bound on a use, an age of more than a day in days or years."""
    units = [(PROBE[key].unit, PROBE[key].si_per_unit, 0.0)]
    if key == "age":
        units = [("years", YEAR, 2.0), ("days", 86400.0, 2.0)]
    for unit, one, least in units:
        if size >= least * one:
            return f"{rounded_down(size / one, 2):g} {unit}"
    return time_text(rounded_down(size, 2))


def _horizon(question: Question) -> Iterator[Condition]:
    """Yield the shortest time that a figure holds over, where no age is stated."""
    found = [
        (time.value, time.printed)
        for sensor in question.there
        for line in sensor.lines
        if line.name not in AGEING.values()
        if (time := time_of(line.horizon)) is not None
    ]
    for seconds, printed in sorted(found)[:1]:
        yield Condition(
            kind="age",
            line=Name(AGE, owner=ENVIRONMENT),
            below=seconds,
            unit="s",
            si_per_unit=1.0,
            text=sentence("conditions.horizon", time=printed),
        )


def _is_felt(question: Question, key: str) -> bool:
    """Say whether a figure is given that holds over a temperature."""
    return key == "temperature" and any(
        sensor.line(residual) is not None
        or _includes(sensor.line(f"{parameter}_repeatability"), key)
        for sensor in question.there
        for parameter, (_, residual) in BY_TEMPERATURE.items()
    )


def cautions_of(question: Question) -> tuple[Condition, ...]:
    """Return what qualifies a verdict whatever it is.

    What is given and nothing exercises; figures that hold over less than the age of the
    use; what its sheet leaves to the procedure.
    """
    stands = {one.source for one in question.filled.lines}
    asked = (
        ()
        if question.journey is None
        else saturations(question.sensors, question.journey)
    )
    return (
        *(
            Condition(
                kind="range",
                line=Name("range", owner=one.sensor),
                text=sentence(
                    "conditions.range_needed", sensor=one.sensor, needed=one.shown
                ),
            )
            for one in _peaks(question)
        ),
        *(
            Condition(
                kind=SATURATES,
                line=Name("range", owner=one.peak.sensor),
                text=one.said,
            )
            for one in asked
        ),
        *(
            one
            for device in question.sheets or question.devices
            for own in [_unusual(device, question.catalogue)]
            for one in (*(x for x in own if x.line not in stands), *_aside(device))
        ),
        *(
            one
            for sensor in question.there
            for line in sensor.lines
            for one in _in_use(question, Name(line.name, owner=sensor.kind), line)
        ),
    )


def _in_use(question: Question, name: Name, line: ErrorLine) -> Iterator[Condition]:
    """Yield what a line that is given leaves open in the use that is stated."""
    stated = stated_of(question.procedure) if question.is_later else {}
    key = source_of(name.owner, line.name).use
    is_idle = key in stated and not stated[key].u.any() and line.u.any()
    if is_idle and key not in _exercised_in_test(question):
        yield Condition(
            kind="not_exercised",
            line=name,
            text=sentence(
                "conditions.not_exercised", line=name, printed=line.printed, use=key
            ),
        )
    if question.journey is not None:
        yield from _open_lines(name, line)
    felt = stated.get("temperature")
    if felt is not None and felt.u.any() and _includes(line, "temperature"):
        yield Condition(
            kind="temperature",
            line=name,
            text=sentence(
                "conditions.includes_temperature", line=name, temperature=felt.printed
            ),
        )
    time, age = time_of(line.horizon), stated.get("age")
    if (
        age is not None
        and time is not None
        and line.name not in AGEING.values()
        and time.value < age.u[0]
    ):
        yield Condition(
            kind="horizon",
            line=name,
            text=sentence(
                "conditions.outlives", line=name, time=time.printed, age=age.printed
            ),
        )


def _unusual(
    device: Device, catalogue: Sequence[Device] | None = None
) -> Iterator[Condition]:
    """Yield the lines of a sheet that are far from those of every other device.

    So is a bias stability that has no time to be one: of a standard uncertainty s and a
    correlation time T its spectral density is at most 2 s^2 T, that of a random walk.
    """
    for sensor in device.sensors:
        for line in sensor.lines:
            name = Name(line.name, owner=sensor.kind)
            found = printed_by_others(name, device, catalogue)
            if found is not None and stand_in(name).expected:
                least, most = found
                is_low = line.largest < least.u / FAR_ABOVE
                if is_low or line.largest > most.u * FAR_ABOVE:
                    yield Condition(
                        kind="unusual",
                        line=name,
                        text=sentence(
                            "conditions.far_off",
                            line=name,
                            printed=line.printed,
                            other=(least if is_low else most).printed,
                            is_low=is_low,
                        ),
                    )
            time = line.correlation_time
            if line.name == STABILITY and time is not None and time.min() < SHORT:
                yield Condition(
                    kind=NO_TIME,
                    line=name,
                    text=sentence(
                        "conditions.no_correlation", line=name, time=float(time.min())
                    ),
                )


def _peaks(question: Question) -> tuple[Peak, ...]:
    """Return the largest input of each triad whose range is not given."""
    if question.journey is not None:
        return needed_range(question.there, question.journey)
    return tuple(
        largest_of_test(one.kind, question.procedure)
        for one in question.there
        if one.range is None and calibrates(one.kind, question.procedure)
    )


def ranges_of(question: Question) -> tuple[Condition, ...]:
    """Return the conditions on ranges that are not given, where they may not do.

    Some device of the catalogue that reads gravity reads less than is asked of it.
    """
    return tuple(
        Condition(
            kind="range",
            line=Name("range", owner=peak.sensor),
            below=None,
            unit=unit,
            si_per_unit=size,
            text=sentence("conditions.reads", sensor=peak.sensor, needed=peak.shown),
        )
        for peak in _peaks(question)
        for unit, size in [SHOWN[peak.sensor]]
        if peak.size > least_range(peak.sensor)
    )


@cache
def least_range(kind: str) -> float:
    """Return the least range of a device that ships and reads gravity [SI]."""
    least = STANDARD_GRAVITY if kind == ACCELEROMETER else 0.0
    return min(
        float(sensor.range.min())
        for device in shipped_devices()
        for sensor in device.sensors
        if sensor.kind == kind and sensor.range is not None
        if sensor.range.min() > least
    )


def cautions_of_device(device: Device) -> tuple[Condition, ...]:
    """Return what a data sheet leaves open, whatever it is held against.

    What is expected of it and not given; what nothing exercises before somebody states
    the use; figures that hold over a time; what leaves a reader a choice.
    """
    return (
        *(one for sensor in device.sensors for one in _of_sheet(sensor)),
        *_unusual(device),
        *_aside(device),
    )


def _of_sheet(sensor: Sensor) -> Iterator[Condition]:
    """Yield what a triad is not given, and what its lines leave open."""
    if absent := sensor.expected_missing:
        text = sentence("conditions.not_given", lines=absent)
        yield Condition(kind="missing", line=absent[0], text=text)
    if sensor.range is None:
        text = sentence("conditions.no_range", sensor=sensor.kind)
        yield Condition(kind="range", line=Name("range", owner=sensor.kind), text=text)
    for line in sensor.lines:
        name = Name(line.name, owner=sensor.kind)
        key = source_of(sensor.kind, line.name).use
        if key and line.u.any():
            text = sentence(
                "conditions.acts_at_use", line=name, printed=line.printed, use=key
            )
            yield Condition(kind="not_exercised", line=name, text=text)
        elif key != "age" and time_of(line.horizon) is not None:
            text = sentence("conditions.lasts", line=name, time=line.horizon)
            yield Condition(kind="horizon", line=name, text=text)
        yield from _open_lines(name, line)


def _aside(device: Device) -> Iterator[Condition]:
    """Yield figures that are called as a line which the sheet does not give."""
    for figure in device.figures:
        called = re.sub("[^a-z0-9]+", " ", figure.name.lower())
        called = re.sub(r"\bacc(el)?\b", ACCELEROMETER, called)
        for sensor in device.sensors:
            _, _, after = f" {called} ".rpartition(f" {sensor.kind} ")
            known = lines_by_word().get(bare(after), ())
            for line in sensor.not_given:
                is_called = line.quantity in known and line.quantity != QUANTIZATION
                if is_called or f" {words(line.quantity)} " in f" {after}":
                    yield Condition(
                        kind="unusual",
                        line=line,
                        text=sentence(
                            "conditions.among_figures",
                            name=figure.name,
                            line=line,
                            value=figure.value,
                        ),
                    )


def _open_lines(name: Name, line: ErrorLine) -> Iterator[Condition]:
    """Yield what a line leaves to whoever reads it."""
    says = dict(line.says)
    is_floor = line.name == STABILITY and line.definition == ALLAN_FLOOR
    is_open = {
        "full_scale": line.name == NONLINEARITY and "full_scale" not in says,
        "bandwidth": line.name == SAMPLE_NOISE and "bandwidth" not in says,
        "correlation_time": is_floor and line.correlation_time is None,
    }
    for kind in filter(is_open.get, is_open):
        text = sentence("conditions.left_open", line=name, what=kind)
        yield Condition(kind=kind, line=name, text=text)


def calibration_words(procedure: Procedure) -> str:
    """Say after which calibration a verdict is: 'as the maker calibrated it'."""
    return sentence(
        "conditions.calibration",
        formulas=procedure.formulas,
        name=procedure.name,
        station=station_words(procedure),
    )


def use_words(procedure: Procedure, *, is_later: bool) -> str:
    """Say in what environment and at what age a unit is used, as far as it is stated.

    `is_later`: at a later turn-on.
    """
    stated = stated_of(procedure) if is_later else {}
    return sentence(
        "conditions.use",
        is_later=is_later,
        stated=tuple(stated),
        is_all=set(STATED) <= stated.keys(),
        acting=[
            (key, line.printed, line.course if is_fading else None)
            for key, line in stated.items()
            if line.u.any()
            for is_fading in [isinstance(line.course, Fading)]
        ],
    )


def station_words(procedure: Procedure) -> str:
    """Say at which station: 'an ideal table', or the name of its file."""
    if procedure.station_origin is not None:
        return Path(procedure.station_origin.file).stem
    return sentence("conditions.table", is_ideal=IDEAL in procedure.assumptions)
