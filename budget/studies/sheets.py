"""What data sheets leave open or say aside, which qualifies every verdict on them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from budget.calibration.saturation import saturations
from budget.inputs.makers import bare, lines_by_word
from budget.inputs.specification import time_of
from budget.missing.prediction import stand_in
from budget.model.sources import ACCELEROMETER, source_of
from budget.model.sources.processes import Quantization
from budget.names import Name, words
from budget.results import Condition
from budget.sentences import sentence
from budget.studies.ceilings import printed_by_others
from budget.studies.conditions import peaks
from budget.studies.lacking import exercised_in_test, includes, stated_use
from budget.studies.margin import FAR_ABOVE

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.inputs.records import Device, ErrorLine, Sensor
    from budget.question import Question

SATURATES, NO_TIME = "saturates", "no_correlation_time"
SHORT = 1.0  # correlation time of a bias stability that is none [s]
ALLAN_FLOOR = "allan_minimum"
# By what a file may say of a value: what of it is left to whoever reads it.
LEFT_OPEN = {
    "nonlinearity": "full_scale",
    "sample_noise": "bandwidth",
    "stability": "correlation_time",
}


def cautions_of(question: Question) -> tuple[Condition, ...]:
    """Return what qualifies a verdict whatever it is.

    What is given and nothing exercises; figures that hold over less than the age of the
    use; what its sheet leaves to the procedure.
    """
    return tuple(_cautions_of(question))


def _cautions_of(question: Question) -> Iterator[Condition]:
    """Yield them."""
    for one in peaks(question):
        yield _on_range("conditions.range_needed", one.sensor, needed=one.shown)
    mission = question.journey
    for asked in () if mission is None else saturations(question.sensors, mission):
        name = Name("range", owner=asked.peak.sensor)
        yield Condition(kind=SATURATES, line=name, text=asked.said)
    stands = {one.source for one in question.filled.lines}
    kinds = {sensor.kind for sensor in question.there}
    for device in question.sheets or question.devices:
        own = _unusual(device, question.catalogue)
        every = (*(x for x in own if x.line not in stands), *_aside(device))
        yield from (said for said in every if said.line.owner in kinds)
    for sensor in question.there:
        for line in sensor.lines:
            yield from _in_use(question, Name(line.name, owner=sensor.kind), line)


def _on_line(kind: str, place: str, line: Name, **said: object) -> Condition:
    """Return what there is to say of a line: a sentence on it."""
    return Condition(kind=kind, line=line, text=sentence(place, line=line, **said))


def _on_range(place: str, sensor: str, **said: object) -> Condition:
    """Return what there is to say of a range that is not given."""
    text = sentence(place, sensor=sensor, **said)
    return Condition(kind="range", line=Name("range", owner=sensor), text=text)


def _in_use(question: Question, name: Name, line: ErrorLine) -> Iterator[Condition]:
    """Yield what a line that is given leaves open in the use that is stated."""
    stated, key = stated_use(question), source_of(name.owner, line.name).use
    is_idle = key in stated and not stated[key].u.any() and line.u.any()
    if is_idle and key not in exercised_in_test(question):
        yield _on_line(
            "not_exercised",
            "conditions.not_exercised",
            name,
            printed=line.printed,
            use=key,
        )
    if question.journey is not None:
        yield from _open_lines(name, line)
    felt = stated.get("temperature")
    if felt is not None and felt.u.any() and includes(line, "temperature"):
        said = {"temperature": felt.printed}
        yield _on_line("temperature", "conditions.includes_temperature", name, **said)
    time, age = time_of(line.horizon), stated.get("age")
    if age and time and key != "age" and time.value < age.u[0]:
        said = {"time": time.printed, "age": age.printed}
        yield _on_line("horizon", "conditions.outlives", name, **said)


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
                    yield _on_line(
                        "unusual",
                        "conditions.far_off",
                        name,
                        printed=line.printed,
                        other=(least if is_low else most).printed,
                        is_low=is_low,
                    )
            time = line.correlation_time
            is_stability = source_of(sensor.kind, line.name).value == "stability"
            if is_stability and time is not None and time.min() < SHORT:
                yield _on_line(
                    NO_TIME, "conditions.no_correlation", name, time=float(time.min())
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
        yield _on_range("conditions.no_range", sensor.kind)
    for line in sensor.lines:
        name = Name(line.name, owner=sensor.kind)
        key = source_of(sensor.kind, line.name).use
        if key and line.u.any():
            said = {"printed": line.printed, "use": key}
            yield _on_line("not_exercised", "conditions.acts_at_use", name, **said)
        elif key != "age" and time_of(line.horizon) is not None:
            yield _on_line("horizon", "conditions.lasts", name, time=line.horizon)
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
                effect = source_of(sensor.kind, line.quantity).effect
                # Makers call much else a resolution.
                is_called = line.quantity in known
                is_called &= not isinstance(effect, Quantization)
                if is_called or f" {words(line.quantity)} " in f" {after}":
                    said = {"name": figure.name, "value": figure.value}
                    yield _on_line("unusual", "conditions.among_figures", line, **said)


def _open_lines(name: Name, line: ErrorLine) -> Iterator[Condition]:
    """Yield what a line leaves to whoever reads it."""
    key = LEFT_OPEN.get(source_of(name.owner, line.name).value)
    is_said = key in dict(line.says)
    if key == "correlation_time":
        is_said = line.definition != ALLAN_FLOOR or line.correlation_time is not None
    if key and not is_said:
        yield _on_line(key, "conditions.left_open", name, what=key)
