"""Conditions of a verdict, and what it is of, in words: lines, uses, ranges."""

from __future__ import annotations

from functools import cache
from math import floor, inf, log10
from pathlib import Path
from typing import TYPE_CHECKING

from budget.calibration.saturation import UNITS, needed_range
from budget.calibration.schemes import calibrates, largest_of_test
from budget.inputs.specification import time_of
from budget.inputs.station import IDEAL, OF_RUN
from budget.inputs.use import STATED, stated_of
from budget.missing import line_of, shipped_devices, usual_line
from budget.missing.prediction import stand_in
from budget.model.course import Fading
from budget.model.sources import ACCELEROMETER, ENVIRONMENT, source_of
from budget.names import Name, time_text
from budget.results import Condition
from budget.sentences import sentence
from budget.studies.ceilings import BY_NATURE, at_most
from budget.studies.lacking import RESIDUALS, over_temperature, unstated
from budget.studies.margin import PROBE, TRIED_AT
from budget.ties import settle
from budget.units import STANDARD_GRAVITY, YEAR

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.calibration.saturation import Peak
    from budget.inputs.records import Procedure
    from budget.question import Question
    from budget.studies.ceilings import Ceiling
    from budget.studies.margin import Margin

# What an age is read in that is twice as long, else a shorter time.
LONG = (("years", 2.0 * YEAR, YEAR), ("days", 2.0 * 86400.0, 86400.0))


def of_line(margin: Margin, name: Name, *, alone: bool) -> Condition:
    """Return what a missing line may be; `alone`: all other missing ones 0."""
    below = margin.bound_of(name, alone=alone)
    if not alone and below >= at_most(name):  # what no sensor reaches
        below = inf
    top = margin.tops.get(name)
    largest = None if top is None else top.largest_comparable
    source, line = stand_in(name), usual_line(name)
    if 0.0 < below < inf:
        printed, one = below, line.si_per_unit
        if not alone:  # a size below the bound is within it
            printed = rounded_down(below / one, 3) * one
        line = line_of(source, name.owner, printed)
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


def uses_of(question: Question, margin: Margin) -> tuple[Condition, ...]:
    """Return the conditions on the use, as far as nobody has stated it."""
    uses = (
        *(one for key in unstated(question) for one in _of_use(question, margin, key)),
        *ranges_of(question),
    )
    if uses or not unstated(question):
        return uses
    text = sentence("conditions.as_in_its_test")
    return (Condition(kind="environment", line=Name(ENVIRONMENT), text=text),)


def _of_use(question: Question, margin: Margin, key: str) -> tuple[Condition, ...]:
    """Return the conditions of a use that nobody has stated, and that reaches."""
    found = []
    silent, tops = margin.silent.get(key, ()), margin.tops
    unknown = tuple(
        name for name in silent if name not in tops or tops[name].origin == BY_NATURE
    )
    if (size := margin.use_bounds.get(key)) is not None:
        known = [] if unknown else [tops[name] for name in silent]
        found.append(_bounded(key, size * TRIED_AT[key], known))
    if key == "age":
        found += _horizon(question)
    if unknown:
        text = sentence("conditions.silent", use=key, lines=unknown)
        found.append(_on_use(key, text, silent=unknown))
    is_felt = key == "temperature" and any(
        over_temperature(sensor, name)
        for sensor in question.there
        for name in RESIDUALS
    )
    if not found and is_felt:
        found.append(_on_use(key, sentence("conditions.over_temperature")))
    return tuple(found)


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
    own = ((PROBE[key].unit, 0.0, PROBE[key].si_per_unit),)
    for unit, least, one in LONG if key == "age" else own:
        if size >= least:
            return f"{rounded_down(size / one, 2):g} {unit}"
    return time_text(rounded_down(size, 2))


def _horizon(question: Question) -> Iterator[Condition]:
    """Yield the shortest time that a figure holds over, where no age is stated."""
    found = [
        (time.value, time.printed)
        for sensor in question.there
        for line in sensor.lines
        if source_of(sensor.kind, line.name).use != "age"
        if (time := time_of(line.horizon)) is not None
    ]
    for seconds, printed in sorted(found)[:1]:
        text = sentence("conditions.horizon", time=printed)
        line = Name(STATED["age"][0], owner=ENVIRONMENT)
        yield Condition(kind="age", line=line, text=text, below=seconds, unit="s")


def peaks(question: Question) -> tuple[Peak, ...]:
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
            unit=unit,
            si_per_unit=size,
            text=sentence("conditions.reads", sensor=peak.sensor, needed=peak.shown),
        )
        for peak in peaks(question)
        for unit, size in [UNITS[peak.sensor]]
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
    return sentence(
        "conditions.table",
        is_ideal=IDEAL in procedure.assumptions,
        is_of_run=OF_RUN in procedure.assumptions,
    )
