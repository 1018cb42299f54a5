"""What-if: the law of a budget for any sizes of its sources.

With f_g the factor on the standard uncertainty of source g, k the coverage factor, d
how far the middle of the interval lies off the mean (0 by the law) and the sums over
sources (budget.methods.scaling), of every output

    mean = value + sum_g f_g^2 m_g ,
    u^2  = sum_g (f_g^2 A_g + f_g^4 Q_g) + sum_{g<h} f_g^2 f_h^2 P_gh ,
    interval = mean + d u +- k u ,    utilisation = largest |end| / limit ,
    share of g = (f_g^2 A_g + f_g^4 Q_g) / u^2 .

It is the law, not near it: the calibration is expanded about values that no factor
moves. Multiplying a value of the device file by f_g and analysing again by gum gives
the same numbers. Where the interval of the budget is not the law's, k and d are those
of that interval, (U_p/u, JCGM 100:2008, annex G): its shape is kept, which is exact
at factors of 1 and an approximation elsewhere.

A verdict is as in budget.studies.verdicts. With every line that is not given at its
ceiling u^2 is larger by what these add, which no factor moves: beyond a limit then, it
is undecidable. At factors of 1 it is the verdict of the budget.

Outputs of a mission stand beside those of the calibration, of the same sources. k of a
length goes with its ellipse, and so with the factors.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import MEASURED
from budget.distributions import normal_coverage_factor
from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs.use import STATED
from budget.known import Known
from budget.language import axis_title, key_title, say
from budget.methods.scaling import ScaledLaw, scaled_law
from budget.model.sources import SENSORS
from budget.names import IMU, MISSION, Name
from budget.question import limited_but_held, question_of
from budget.results import BY_LAW, LimitedOutput, Verdict, u_known
from budget.sentences import sentence
from budget.studies.conditions import uses_of
from budget.studies.conformity import margins
from budget.studies.sheets import SATURATES, cautions_of
from budget.studies.verdicts import (
    FAILS,
    MEETS,
    MEETS_IF,
    PREDICTED,
    UNDECIDABLE,
    UNDECIDED,
    gravest,
)
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.methods.gum import Propagation
    from budget.problem import Output
    from budget.question import Question
    from budget.results import Assessment, Budget
    from budget.studies.margin import Margin


LARGEST = 1e6  # factor up to which it is asked what will do [1]
NEAR = 1e-3  # below the largest factor at which a limit is kept [1]
# Over a utilisation: of limits that are kept one by one nobody knows here whether all
# are kept together; one that is not kept is not kept together [1].
JOINTLY = (1.0, 1e300)


@written(
    "what_if_source",
    """
    name
    owner = name.owner
    quantity = name.quantity
    title (str): in words
    u / unit: present standard uncertainty
    unit
    printed: as the file gives it
    decides (list[str]): sensors whose verdicts are held against it
    """,
    title=lambda source: key_title(source.name),
    decides=lambda source: list(source.decides),
)
@dataclass(frozen=True, kw_only=True)
class WhatIfSource:
    """A source whose size can be changed; one factor for all its axes."""

    name: Name  # 'gyro.bias_repeatability'
    u: float  # present standard uncertainty, of the largest axis [SI]
    unit: str  # as the device file gives it
    si_per_unit: float
    printed: str  # the value as the file gives it
    # Its sensor, or that of the output where its share is largest, and the mission.
    decides: tuple[str, ...] = ()


@written(
    "what_if_sensor",
    """
    name
    title (str): in words
    missing (list[str]): what a verdict cannot do without, in words
    doubt [1]: interval of the utilisation, over it
    verdict: at factors of 1
    is_open: whether what is missing is not bounded
    conditions (list[str]): of a 'meets', in words
    saturates: whether a mission asks for more than it reads
    """,
    title=lambda sensor: key_title(sensor.name),
    missing=lambda sensor: [
        key_title(one.quantity if one.owner == sensor.name else one)
        for one in sensor.missing
    ],
    conditions=lambda sensor: [say(text) for text in sensor.conditions],
)
@dataclass(frozen=True, kw_only=True)
class WhatIfSensor:
    """A triad that is there, and what a verdict on it cannot do without."""

    name: str  # 'gyro' or 'accelerometer'
    missing: tuple[Name, ...]  # lines not given, limited parameters not estimated
    verdict: str = ""  # at factors of 1; '' where nobody has judged it
    is_open: bool = False  # whether what is missing is not bounded
    conditions: tuple[str, ...] = ()  # of a 'meets' at any factors
    saturates: bool = False  # beyond its range no source matters
    doubt: tuple[float, float] = (1.0, 1.0)  # interval of the utilisation over it [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Outlook:
    """What the law says at changed sources."""

    # Expected errors and standard uncertainties, shape (n_out,) [SI].
    mean: Array
    u: Array
    interval: Array  # coverage intervals, shape (n_out, 2) [SI]
    # Of each source alone in the variance; 0 where the variance is 0, shape (n_out,
    # n_src) [1].
    share: Array
    # Of each output; None where nothing is required [1].
    utilisation: tuple[float | None, ...]
    sensors: tuple[Verdict, ...]  # of the sensors of which something is required


@written(
    "what_if_output",
    """
    name = output.name
    sensor = output.name.owner
    title (str): in words
    group (str): what several axes are of, in words
    axis = named: with the coverage where it is another than that of the budget
    is_timed: whether it is of a mission
    unit = output.unit
    value / unit: of the calibration
    coverage [1]: of its interval
    length: its place among lengths; null of what is none
    factor [1]: k, of a length on the radius of the circle of its coverage
    shift [1]: d
    limit / unit or null: null where there is none
    lower_bound = why (bool): whether a line that is not given would widen it
    resolution = output.resolution / unit: a spread at or below this is rounding
    added / unit / unit: V and, of lengths, D/2 and W of missing lines at their ceilings
    """,
    title=lambda one: key_title(one.output.name),
    group=lambda one: key_title(one.output.name.group),
    is_timed=lambda one: one.output.name.time is not None,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class WhatIfOutput(LimitedOutput):
    """One output, as a page computes it."""

    named: str  # its axis, with a coverage of its own
    value: float  # [SI]
    coverage: float  # [1]
    length: int | None
    factor: float  # [1]
    shift: float  # [1]
    added: Array  # shape (3,) [SI squared]
    why: tuple[Name, ...]  # lines that are not given and would widen it


# Of a law in printed units, by source, then by output.
written(
    "what_if_law",
    """
    first = first.T: A
    second: Q
    pairs as what_if_pair: P of two sources, where it reaches one output at least
    """,
    second=lambda law: np.einsum("kgg->gk", law.second),
    pairs=lambda law: [
        ((law.sources[g], law.sources[h]), 2.0 * law.second[:, g, h])
        for g, h in combinations(range(len(law.sources)), 2)
        if law.second[:, g, h].any()
    ],
)(ScaledLaw)
written(
    "what_if_pair",
    """
    sources = 0
    variance = 1
    """,
)(tuple)


@written(
    "what_if",
    """
    coverage [1]: of the intervals
    most [1]: factor up to which it is asked what will do
    sensors
    sources
    outputs = each
    mean = law_in_units.shift.T: m, by source, then by output
    *law_in_units as what_if_law
    ellipse = law_in_units.ellipse as what_if_law: D/2 and W in the place of the
      variance, of lengths alone
    """,
    most=lambda _: LARGEST,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class WhatIf(Documented):
    """A budget as a function of the sizes of its sources."""

    coverage: float  # probability of the intervals [1]
    reference: str  # error reference
    sensors: tuple[WhatIfSensor, ...]
    # Those that are not 0 in this run; a factor on 0 changes nothing.
    sources: tuple[WhatIfSource, ...]
    outputs: tuple[Output, ...]
    # Coverage factors k: half an interval over u, shape (n_out,) [1]. Of a length over
    # its roundness, as if it lay along one axis.
    coverage_factor: Array = field(repr=False)
    # d: the middle of an interval less the mean, over u, shape (n_out,) [1].
    shift: Array = field(repr=False)
    # On the absolute error of each output; None where there is none [SI].
    limit: tuple[float | None, ...]
    # Probability of each interval, that of its limit, shape (n_out,) [1].
    coverages: Array = field(repr=False)
    # Of each output: the lines that are not given and would widen it.
    why: tuple[tuple[Name, ...], ...]
    law: ScaledLaw = field(repr=False)  # in the order of `sources` and `outputs` [SI]
    # What missing lines add at their ceilings: V and, of lengths, D/2 and W
    # (budget.methods.scaling), shape (3, n_out) [SI squared].
    added: Array = field(repr=False)

    def evaluate(self, factors: Mapping[str, float]) -> Outlook:
        """Return the budget with the standard uncertainties of sources multiplied.

        Raises
        ------
        CallError
            A name is no source here, or a factor is negative or not finite.
        """
        s = self._factors(factors)
        mean, variance = self.law.mean(s), self.law.variance(s)
        u = np.sqrt(variance)
        interval = self._interval(self.law, s)
        at_top = self._interval(
            self.law.with_source(Name("missing"), self.added), np.append(s, 1.0)
        )
        share = (
            self.law.variance_alone(s)
            / np.where(variance > 0.0, variance, 1.0)[:, None]
        )
        utilisation = self._utilisation(interval)
        return Outlook(
            mean=mean,
            u=u,
            interval=interval,
            share=share,
            utilisation=utilisation,
            sensors=self._judge(
                utilisation, self._utilisation(at_top), changed=bool((s != 1.0).any())
            ),
        )

    def _interval(self, law: ScaledLaw, s: Array) -> Array:
        """Return the coverage intervals, shape (n_out, 2) [SI]."""
        mean, u = law.mean(s), np.sqrt(law.variance(s))
        k = self.coverage_factor * law.roundness(s, self.coverages)
        return np.stack([mean + (self.shift + end) * u for end in (-k, k)], axis=1)

    def _utilisation(self, interval: Array) -> tuple[float | None, ...]:
        """Return the part of its limit that each output uses [1]."""
        end = np.abs(interval).max(axis=1)
        return tuple(
            None if limit is None else float(end[k]) / limit
            for k, limit in enumerate(self.limit)
        )

    @property
    def law_in_units(self) -> ScaledLaw:
        """The law in printed units, its ellipse of lengths alone."""
        law = self.law.in_units([one.si_per_unit for one in self.outputs])
        names = [law.outputs[k] for k in self.lengths]
        return replace(law, ellipse=tuple(one.select(names) for one in law.ellipse))

    @property
    def each(self) -> tuple[WhatIfOutput, ...]:
        """The outputs one by one."""
        along = normal_coverage_factor(self.coverages)
        along[[k for k in range(along.size) if k not in self.lengths]] = 1.0
        return tuple(
            WhatIfOutput(
                output=output,
                named=self._axis(k),
                value=self.law.value[k],
                coverage=self.coverages[k],
                length=self.lengths.index(k) if k in self.lengths else None,
                factor=self.coverage_factor[k] / along[k],
                shift=self.shift[k],
                limit=inf if (limit := self.limit[k]) is None else limit,
                why=self.why[k],
                added=self.added[:, k],
            )
            for k, output in enumerate(self.outputs)
        )

    @property
    def lengths(self) -> list[int]:
        """Places of the outputs that are lengths."""
        is_length = self.law.is_length
        return [] if is_length is None else np.flatnonzero(is_length).tolist()

    def _axis(self, k: int) -> str:
        """Name an output among its like; with the coverage of its own that it has."""
        axis = axis_title(self.outputs[k].name)
        if self.coverages[k] == self.coverage:
            return axis
        return f"{axis} ({100.0 * self.coverages[k]:.6g}\N{NO-BREAK SPACE}%)"

    def _factors(self, factors: Mapping[str, float]) -> Array:
        """Return one factor a source, 1 where none is named."""
        names = [source.name for source in self.sources]
        unknown = sorted(set(factors) - set(names))
        if unknown:
            raise CallError(
                f"{', '.join(unknown)}: no source of this budget, or one that is 0; "
                f"known: {', '.join(names)}"
            )
        s = np.array([factors.get(name, 1.0) for name in names], dtype=float)
        sound = np.isfinite(s) & (s >= 0.0)
        if not sound.all():
            raise CallError(
                f"the factor on {names[int(np.argmin(sound))]} is "
                f"{s[~sound][0]}, expected 0 or more; 1 leaves the source as it is"
            )
        return s

    def _judge(
        self,
        utilisation: Sequence[float | None],
        at_top: Sequence[float | None],
        *,
        changed: bool,
    ) -> tuple[Verdict, ...]:
        """Return the verdicts, by the rules of budget.studies.verdicts.

        Those of the unchanged device are its own.
        """
        outlooks = []
        for sensor in self.sensors:
            own = [
                (used, top, output.name, why)
                for used, top, output, why in zip(
                    utilisation, at_top, self.outputs, self.why, strict=True
                )
                if used is not None and top is not None
                if output.name.owner == sensor.name
            ]
            if not own:
                continue
            used, _, worst, _ = own[first_largest([row[0] for row in own])]
            why = tuple(dict.fromkeys(line for *_, lines in own for line in lines))
            is_own = sensor.verdict == PREDICTED or not changed
            outlooks.append(
                Verdict(
                    sensor=sensor.name,
                    verdict=(is_own and sensor.verdict)
                    or _verdict(sensor, used, max(row[1] for row in own)),
                    utilisation=Known.of(used, why),
                    worst_outputs=(worst,),
                )
            )
        return tuple(outlooks)


def _verdict(sensor: WhatIfSensor, used: float, at_top: float) -> str:
    """Return the verdict at a utilisation, and at one with missing lines at their top.

    It is as in budget.studies.verdicts.
    """
    low, high = (settle(part * used) for part in sensor.doubt)
    given = FAILS if settle(used) > 1.0 else MEETS
    if low <= 1.0 < high:
        given = UNDECIDED
    if sensor.saturates:
        given = FAILS
    if given != FAILS and (sensor.is_open or settle(at_top) > 1.0):
        return UNDECIDABLE
    return MEETS_IF if given == MEETS and sensor.conditions else given


def what_if(
    question: Question, *, budget: Budget | None = None, carried: Budget | None = None
) -> WhatIf:
    """Set up the budget of devices as a function of their sources.

    With a budget of the same analysis its intervals and verdicts are those at factors
    of 1; without one it is the budget by the law alone. Limits are those of the
    analysis, also those on its mission; what else is known on that is of the budget
    carried there.
    """
    found, required = _what_if(question, budget), question.requirement
    is_carried = question.mission is not None and question.journey is None
    if carried is not None:
        found = _beside(found, _what_if(question_of(carried), carried))
    elif is_carried and required is not None and MISSION in required.kinds:
        found = _beside(found, _what_if(question.alone(MISSION), budget))
    assessment = None if budget is None else budget.assessment
    return _deciding(_judged(found, question, assessment))


def _deciding(found: WhatIf) -> WhatIf:
    """Say of each source what its size decides."""
    share = found.evaluate({}).share
    sources = []
    for g, source in enumerate(found.sources):
        owner = source.name.owner
        widest = found.outputs[_widest(found, share[:, g])].name.owner
        own = owner if owner in SENSORS and widest != IMU else widest
        sources.append(replace(source, decides=(own, MISSION)))
    return replace(found, sources=tuple(sources))


def _widest(found: WhatIf, share: Array) -> int:
    """Return the output of which a source has the largest share, shape (n_out,).

    One of the calibration where it reaches any; outputs of a mission are the last.
    """
    own = [
        part if one.name.owner != MISSION else 0.0
        for part, one in zip(share.tolist(), found.outputs, strict=True)
    ]
    return first_largest(own if any(own) else share.tolist())


def _judged(found: WhatIf, question: Question, assessment: Assessment | None) -> WhatIf:
    """Give a model what its verdicts need besides the sizes of its sources."""
    own = {one.sensor: one for one in (assessment.sensors if assessment else ())}
    rooms = {one.owner: (one, margin) for one, margin in margins(question)}
    places = {output.name: k for k, output in enumerate(found.outputs)}
    added = np.zeros_like(found.added)
    sensors = []
    for sensor in found.sensors:
        name, saturates = sensor.name, False
        is_open, conditions = bool(sensor.missing), tuple[str, ...]()
        doubt = sensor.doubt
        if sensor.name in rooms:
            one, margin = rooms[sensor.name]
            C = margin.added
            is_length = margin.ratio > 0.0
            half = np.where(is_length, (C[:, 0, 0] - C[:, 1, 1]) / 2.0, 0.0)
            parts = np.stack([np.trace(C, axis1=1, axis2=2), half, C[:, 0, 1]])
            for j, output in enumerate(margin.held.outputs):
                added[:, places[output.name]] = parts[:, j]
            is_open = bool(
                margin.without_ceiling
                or margin.held.absent
                or one.filled.prediction is not None
            )
            conditions = tuple(_conditions(one, margin))
            if margin.held.is_joint:
                doubt = JOINTLY
            saturates = any(x.kind == SATURATES for x in cautions_of(one))
        sensors.append(
            replace(
                sensor,
                verdict=own[name].verdict if name in own else "",
                is_open=is_open,
                conditions=conditions,
                saturates=saturates,
                doubt=doubt,
            )
        )
    return replace(found, sensors=tuple(sensors), added=added)


def _conditions(question: Question, margin: Margin) -> Iterator[str]:
    """Yield what a 'meets' holds if, whatever the sizes of the sources are."""
    if question.only is not None:
        yield sentence("conditions.chosen")
        return
    for name in margin.missing:
        if name in margin.tops:
            bound = margin.tops[name].printed
            yield sentence("conditions.stays_below", line=name, bound=bound)
        elif name in margin.filled:
            yield sentence("conditions.stands", line=name)
    uses = uses_of(question, margin)
    for key in dict.fromkeys(one.kind for one in uses if one.kind in STATED):
        yield sentence("conditions.changes_nothing", use=key)
    yield from (one.text for one in uses if one.kind not in STATED)


def _beside(calibration: WhatIf, mission: WhatIf) -> WhatIf:
    """Put the outputs of a mission beside those of the calibration before it."""
    both = calibration, mission
    law = calibration.law.beside(mission.law)
    sources = {one.name: one for model in both for one in model.sources}
    owners = list(dict.fromkeys(name.owner for name in law.sources))
    names = sorted(law.sources, key=lambda name: owners.index(name.owner))
    return replace(
        calibration,
        sensors=(
            *calibration.sensors,
            *(one for one in mission.sensors if one.name == MISSION),
        ),
        sources=tuple(sources[name] for name in names),
        outputs=(*calibration.outputs, *mission.outputs),
        coverage_factor=np.concatenate([one.coverage_factor for one in both]),
        shift=np.concatenate([one.shift for one in both]),
        limit=(*calibration.limit, *mission.limit),
        coverages=np.concatenate([one.coverages for one in both]),
        why=(*calibration.why, *mission.why),
        law=law.select_sources(names),
        added=np.concatenate([one.added for one in both], axis=1),
    )


def _what_if(question: Question, budget: Budget | None) -> WhatIf:
    """Set it up for a calibration or a mission alone."""
    problem, law, required = question.problem, question.law, question.requirement
    held_against = None if budget is None else budget.assessment
    bounds = {
        row.output.name: row.standard_uncertainty.why
        for row in (held_against.outputs if held_against else ())
    }
    varying = [group.name for group in problem.groups if not group.is_constant]
    limits = {} if required is None else {r.output: r.limit for r in required.limits}
    own = (
        {}
        if required is None
        else {r.output: required.coverage_of(r) for r in required.limits}
    )
    names = [output.name for output in problem.outputs]
    coverages = np.array([own.get(name, question.coverage) for name in names])
    scaled = scaled_law(problem, law).select_sources(varying)
    factor, shift = _shape(law, coverages, budget)
    factor /= scaled.roundness(np.ones(len(varying)), coverages)
    # The components of a length need not have been asked for.
    asked = names if question.outputs is None else question.outputs
    rows = [k for k, name in enumerate(names) if name in asked]
    outputs = tuple(problem.outputs[k] for k in rows)
    doubts = {} if budget is None else _doubts(budget)
    triads = {sensor.kind: (sensor,) for sensor in question.sensors}
    owners = dict.fromkeys((*triads, *(name.owner for name in names)))
    held = limited_but_held(triads, question.procedure, limits)
    prediction = question.filling.prediction
    predicted = () if prediction is None else prediction.names
    return WhatIf(
        coverage=question.coverage,
        reference=question.reference,
        sensors=tuple(
            WhatIfSensor(
                name=owner,
                missing=(
                    *(
                        name
                        for sensor in triads.get(owner, question.sensors)
                        for name in sensor.expected_missing
                    ),
                    *(
                        name
                        for name in predicted
                        if owner in {name.owner, IMU, MISSION}
                    ),
                    *(name for name in held if name.owner == owner),
                ),
                doubt=doubts.get(owner, (1.0, 1.0)),
            )
            for owner in owners
        ),
        sources=tuple(_source(question, name) for name in varying),
        outputs=outputs,
        coverage_factor=factor[rows],
        shift=shift[rows],
        limit=tuple(limits.get(output.name) for output in outputs),
        coverages=coverages[rows],
        why=tuple(
            bounds.get(output.name, question.lacks[output.name]) for output in outputs
        ),
        law=scaled.select([output.name for output in outputs]),
        added=np.zeros((3, len(outputs))),
    )


def _source(question: Question, name: Name) -> WhatIfSource:
    """Return a source as its file gives it; what was measured by a factor alone."""
    if name == MEASURED:
        files = (one.measured.file for one in question.devices if one.measured)
        return WhatIfSource(
            name=name, u=1.0, unit="1", si_per_unit=1.0, printed=next(files)
        )
    line = question.lines[name]
    return WhatIfSource(
        name=name,
        u=line.largest,
        unit=line.unit,
        si_per_unit=line.si_per_unit,
        printed=line.printed,
    )


def _shape(
    law: Propagation, coverages: Array, budget: Budget | None
) -> tuple[Array, Array]:
    """Return k and d of every output, shape (n_out,) each [1]."""
    factor = law.coverage_factor(coverages)
    shift = np.zeros_like(factor)
    if budget is None:
        return factor, shift
    judged = () if budget.assessment is None else budget.assessment.outputs
    found = {row.output.name: (row.interval_by, row.interval) for row in judged}
    found |= {
        row.output.name: (row.interval_by, row.interval) for row in budget.outputs
    }
    for k, output in enumerate(law.outputs):
        by, interval = found.get(output.name, (BY_LAW, (0.0, 0.0)))
        u = law.standard_uncertainty[k]
        if by != BY_LAW and u > 0.0:
            low, high = ((end - law.mean[k]) / u for end in interval)
            factor[k], shift[k] = (high - low) / 2.0, (high + low) / 2.0
    return factor, shift


def _doubts(budget: Budget) -> dict[str, tuple[float, float]]:
    """Return the interval of each sensor's utilisation, over the utilisation [1].

    Where other readings of the data sheet leave the verdict open, that of all of them.
    """
    sensors = () if budget.assessment is None else budget.assessment.sensors
    return {
        one.sensor: (min(ends) / one.utilisation, max(ends) / one.utilisation)
        for one in sensors
        if one.utilisation > 0.0
        for ends in [
            [read.utilisation for read in one.readings.found]
            if one.readings is not None and one.is_open_by_reading
            else one.utilisation_interval
        ]
    }


FACTORS = (0.0, 0.5, 1.0, 2.0)  # on the standard uncertainty of the source [1]


@written(
    "step",
    """
    factor [1]: on its standard uncertainty
    expanded_uncertainty = expanded / unit: half the coverage interval of the output
    utilisation [1]: the largest; null where nothing is required
    verdict: the gravest; '' where nothing is required
    """,
)
@dataclass(frozen=True, kw_only=True)
class Step:
    """One size of one source, all others as they are."""

    factor: float  # [1]
    u: Known  # standard uncertainty of the output [SI]
    expanded: Known  # U, half the coverage interval [SI]
    utilisation: Known | None  # the largest; None where nothing is required
    verdict: str  # the gravest; '' where nothing is required


@written(
    "one_at_a_time",
    """
    source = source.name
    output = output.name: where its share is largest
    unit = output.unit
    share [1]: of the variance of that output as it is
    lower_bound: whether a line that is not given would widen that output
    meets_up_to = most or null [1]: largest factor at which all limits are kept; null
      where none is, or any will do
    meets_at_any (bool)
    steps
    """,
    meets_at_any=lambda row: row.most == inf,
)
@dataclass(frozen=True, kw_only=True)
class SourceSteps(LimitedOutput):
    """One source in several sizes, seen at the output where its share is largest.

    The verdict, and the part of the limit, are of all that is judged by the source:
    its sensor, and the mission where that has limits.
    """

    source: WhatIfSource
    share: float  # of the variance of that output as it is [1]
    steps: tuple[Step, ...]
    # Largest factor at which all these limits are kept, the others as they are [1];
    # None where not even 0 is enough, or nothing is limited; inf where any will do.
    most: float | None

    @property
    def lower_bound(self) -> bool:
        """Whether a line that is not given would widen that output."""
        return any(one.expanded.is_bound for one in self.steps)


def one_at_a_time(what_if: WhatIf) -> tuple[SourceSteps, ...]:
    """Change one source after another, each to nothing, half and twice its size."""
    present = what_if.evaluate({})
    rows = []
    for g, source in enumerate(what_if.sources):
        k = _widest(what_if, present.share[:, g])
        judged = source.decides
        rows.append(
            SourceSteps(
                source=source,
                output=what_if.outputs[k],
                share=float(present.share[k, g]),
                steps=tuple(
                    _step(
                        what_if,
                        what_if.evaluate({source.name: factor}),
                        factor,
                        k,
                        judged,
                    )
                    for factor in FACTORS
                ),
                most=_most(what_if, source.name, judged),
            )
        )
    return tuple(rows)


def _most(what_if: WhatIf, source: Name, judged: Sequence[str]) -> float | None:
    """Return up to what factor on one source the limits of what is judged are kept.

    A part of a limit does not fall where a source grows, but for shifts of the mean
    that cancel; they are of second order.
    """

    def beyond(factor: float) -> float:
        outlook = what_if.evaluate({source: factor})
        used = [one.utilisation for one in outlook.sensors if one.sensor in judged]
        return settle(max(used) - 1.0) if used else 1.0

    if any(one.saturates for one in what_if.sensors if one.name in judged):
        return None

    if beyond(0.0) > 0.0:
        return None
    if beyond(LARGEST) <= 0.0:
        return inf
    from scipy.optimize import brentq

    return float(brentq(beyond, 0.0, LARGEST))


def mended(what_if: WhatIf, sensor: str) -> tuple[WhatIfSource, float] | None:
    """Return the source that need be lessened least for a sensor, or mission, to meet.

    With the factor on it at which it does, all others as they are; None where no one
    source does: verdicts on conditions, and those that wait for what is not given, are
    none that meet.
    """
    able = []
    for source in what_if.sources:
        factor = _most(what_if, source.name, (sensor,)) or inf
        if factor < 1.0:
            outlook = what_if.evaluate({source.name: factor * (1.0 - NEAR)})
            if {one.verdict for one in outlook.sensors if one.sensor == sensor} == {
                MEETS
            }:
                able.append((source, factor))
    return max(able, key=lambda one: settle(one[1]), default=None)


def _step(
    what_if: WhatIf, outlook: Outlook, factor: float, k: int, judged: Sequence[str]
) -> Step:
    """Read one output and one verdict from an outlook."""
    own = [one for one in outlook.sensors if one.sensor in judged]
    u = u_known(what_if.outputs[k], outlook.u[k], what_if.why[k])
    return Step(
        factor=factor,
        u=u,
        expanded=u.like(float(what_if.coverage_factor[k] * u)),
        utilisation=Known.largest(one.utilisation for one in own) if own else None,
        verdict=gravest(one.verdict for one in own) if own else "",
    )
