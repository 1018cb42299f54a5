"""Lines that a question exercises and its data sheets do not give, by their rows.

A source is exercised by the temperature of a test or of a use, by a vibration, by an
age; its row says by which (`use`). The g-sensitivity of a gyro, which no use names, is
by the turns of a test in gravity, and by a route.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import calibrates
from budget.inputs.specification import time_of
from budget.inputs.use import LINES, STATED, stated_of
from budget.missing.grades import FAMILIES, family
from budget.model.sources import ENVIRONMENT, GYRO, SOURCES, source_of
from budget.model.sources.later import TEST_VIBRATION
from budget.names import Name

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.inputs.records import ErrorLine, Mission, Sensor
    from budget.question import Question

# What a temperature, a vibration or an age acts by, and by nothing: in gravity.
BY_USE = {
    key: [one for one in SOURCES if one.is_asked and one.use == key] for key in STATED
}
IN_GRAVITY = {
    one.name for one in SOURCES if one.is_asked and one.varies and one.use not in STATED
}
# Coefficients, by what is left of them over temperature the parameter too.
COEFFICIENTS = tuple(one.name for one in SOURCES if one.is_asked and one.is_signed)
OF_RATES = {name for name in COEFFICIENTS if not source_of(GYRO, name).use}
RESIDUALS = {one.left_of[0]: one for one in SOURCES if one.left_of}
# Lines through which the environment of a test acts.
IN_TEST = {
    "temperature": COEFFICIENTS,
    "vibration": tuple(one.name for one in BY_USE["vibration"]),
}
MEMS = "mems"
NOT_MEMS = {*FAMILIES, "optical"} - {MEMS}


def expected_of(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given and that the question exercises.

    The expected ones; what temperature and vibration do where these are stated or the
    test has its own; the g-sensitivity of a MEMS gyro, and on a route that turns or
    climbs of one that may be.
    """
    if question.only is not None:
        return ()
    names = [name for sensor in question.there for name in sensor.expected_missing]
    names += [*lacking_stated(question), *lacking_in_test(question)]
    families = {
        family(device.technology)
        for device in question.devices
        for sensor in device.sensors
        if sensor.kind == GYRO
    }
    is_turned = question.journey is not None or calibrates(GYRO, question.procedure)
    # A technology that nobody has told, or that nobody knows, may be MEMS.
    if is_turned and not families & NOT_MEMS:
        names += [
            Name(line, owner=GYRO)
            for gyro in question.there
            for line in IN_GRAVITY
            if gyro.kind == GYRO and gyro.line(line) is None
        ]
    filled = {one.expected for one in question.filled.lines}
    return tuple(dict.fromkeys(name for name in names if name not in filled))


def temperatures_of_test(question: Question) -> frozenset[Name]:
    """Return the sources of a temperature that changes in the test itself."""
    return frozenset(
        Name(line.name, owner=ENVIRONMENT)
        for line in question.procedure.environment
        if line.name.startswith("temperature") and line.name not in LINES
        if line.u.any()
    )


def exercised_in_test(question: Question) -> tuple[str, ...]:
    """Return what acts in the test itself: its temperature, its vibration."""
    shaken = [
        line
        for line in question.procedure.environment
        if line.name == TEST_VIBRATION and line.u.any()
    ]
    found = {"temperature": temperatures_of_test(question), "vibration": shaken}
    return tuple(key for key, acting in found.items() if acting)


def lacking_in_test(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given of what acts in the test itself.

    A residual over temperature says nothing of it: that is of a later use.
    """
    exercised = exercised_in_test(question)
    return tuple(
        Name(line, owner=sensor.kind)
        for sensor in question.there
        for key in exercised
        for line in IN_TEST[key]
        if sensor.lines and sensor.line(line) is None
    )


def lacking_stated(question: Question) -> tuple[Name, ...]:
    """Return the lines that are not given of a temperature and a vibration stated."""
    return tuple(
        name
        for key, line in stated_use(question).items()
        if key != "age" and line.u.any()
        for name in lacking_use(question, key)
    )


def lacking_use(question: Question, key: str) -> tuple[Name, ...]:
    """Return the lines of a use that are not given: what it does to the triads.

    A figure that holds over temperature says what a temperature does that stays as it
    is, and one that holds over a time what age does.
    """
    return tuple(
        Name(source.name, owner=sensor.kind)
        for sensor in question.there
        for source in BY_USE[key]
        if sensor.line(source.name) is None
        and not _is_said(sensor, source.name, key, moves=_moves(question))
    )


def _is_said(sensor: Sensor, name: str, key: str, *, moves: bool) -> bool:
    """Say whether another figure of a sensor says what a use does by a source.

    `moves`: the temperature changes on the way.
    """
    if key == "age":
        target = getattr(source_of(sensor.kind, name).effect, "target", "")
        own = sensor.line(f"{target}_repeatability")
        return own is not None and time_of(own.horizon) is not None
    return name in RESIDUALS and not moves and over_temperature(sensor, name)


def over_temperature(sensor: Sensor, coefficient: str) -> bool:
    """Say whether a figure holds over temperature that a coefficient is of."""
    residual = RESIDUALS[coefficient]
    own = sensor.line(f"{getattr(residual.effect, 'target', '')}_repeatability")
    return sensor.line(residual.name) is not None or includes(own, "temperature")


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


def includes(line: ErrorLine | None, word: str) -> bool:
    """Say whether a line includes something, by its maker's words."""
    parts = "" if line is None else line.includes.replace(";", ",")
    return word in {part.strip() for part in parts.split(",")}


def stated_use(question: Question) -> Mapping[str, ErrorLine]:
    """Return what is stated of the use that the question is of, by its key."""
    return stated_of(question.procedure) if question.is_later else {}


def unstated(question: Question) -> tuple[str, ...]:
    """Return what of its use nobody has stated: temperature, vibration, age."""
    if not question.is_later:
        return ()
    stated = stated_of(question.procedure)
    return tuple(key for key in STATED if key not in stated)


def felt_by(question: Question, key: str) -> tuple[Name, ...]:
    """Return the sources that a use acts through."""
    if key == "temperature":
        return (Name(STATED[key][0], owner=ENVIRONMENT),)
    lines = {one.name for one in BY_USE[key]}
    return tuple(
        Name(line.name, owner=sensor.kind)
        for sensor in question.there
        for line in sensor.lines
        if line.name in lines
    )


def manoeuvres(mission: Mission) -> bool:
    """Say whether a route turns, climbs or speeds up; a recorded one may always."""
    legs: Sequence[object] | None = getattr(mission.route, "legs", None)
    if legs is None:
        return True
    parts = ("turn_rate", "climb_rate", "acceleration")
    return any(getattr(leg, part) for leg in legs for part in parts)
