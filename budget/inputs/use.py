"""Use of a calibrated unit: environment and age that a verdict holds in, as stated.

The temperature is the difference from that of the test, one sigma; the vibration its
rms; the age the time since the calibration. Who states them does so in the requirement,
in the mission, in the procedure or with the call. They become lines of the environment
of the procedure, which is what the sources know of it; a stated 0 is a line, too, so
that what is 0 and what nobody has stated are told apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.errors import CallError, UnitError
from budget.inputs.course import KnownCourse, TemperaturePart, VibrationPart, or_size
from budget.inputs.fields import (
    KeyRow,
    ValueKind,
    fault,
    items,
    node_of,
    or_else,
    rows_of,
    table,
)
from budget.inputs.specification import read_value, value_of
from budget.inputs.tree import Node, describe
from budget.language import term
from budget.model.sources import ENVIRONMENT, source_of
from budget.model.sources.later import AGE, MISSION_TEMPERATURE, MISSION_VIBRATION
from budget.names import MISSION, Name
from budget.sentences import sentence
from budget.units import Quantity, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from budget.inputs.records import ErrorLine, Mission, Procedure, Requirement

# By the key that states it: the line of the environment, and what is none of it.
STATED = {
    "temperature": (MISSION_TEMPERATURE, "0 degC"),
    "vibration": (MISSION_VIBRATION, "0 g"),
    "age": (AGE, "0 s"),
}
LINES = tuple(line for line, _ in STATED.values())
NONE = "none"
COURSE = term("known at every time")  # meaning of a course
OPTION = {"environment": "--environment", "age": "--age"}  # how a call states it


def or_part(
    kind: ValueKind, key: str = "", words: Mapping[str, Mapping[str, str]] | None = None
) -> ValueKind:
    """Allow, beside a mapping, a value alone that is of one key in it.

    Parameters
    ----------
    kind : ValueKind
        Of the mapping.
    key : str
        Of a text in the place of the mapping.
    words : mapping of str to mapping
        Texts that stand for a whole mapping.
    """
    whole = words or {}

    def read(node: Node, gravity: float, mapping: Any) -> object:  # noqa: ANN401
        value = node.value
        if isinstance(value, str) and (word := value.strip().casefold()) in whole:
            return mapping(node_of(whole[word]), gravity)
        if key and isinstance(value, str | int | float):
            return mapping(replace(node, value={key: node}), gravity)
        if whole and not isinstance(value, dict):
            raise fault(
                f"found {describe(value)}, expected {' or '.join(whole)}, or a mapping "
                "such as {temperature: 20 degC, vibration: 1 g}"
            )
        return mapping(node, gravity)

    alone = {"enum": [*whole]} if whole else {"type": "string"}
    return or_else(kind, read, alone)


IN_TEST = {key: zero for key, (_, zero) in STATED.items()}
_NONE = {key: zero for key, zero in IN_TEST.items() if key != AGE}
_VALUES = {
    key: value_of(source_of(ENVIRONMENT, line), ENVIRONMENT)
    for key, (line, _) in STATED.items()
}
_SAYS = (
    "that it is used in: temperature, difference from that of the "
    "calibration, 1 sigma{known}; vibration, rms; or none, as in the calibration and "
    "right after it. Unset: not stated, and nothing meets without a condition"
)
# As a requirement states them.
ENVIRONMENT_ROW = KeyRow(
    or_part(
        table(rows=rows_of({key: _VALUES[key] for key in _NONE}), title="use"),
        words={NONE: _NONE},
    ),
    _SAYS.format(known=""),
)
# As a mission does, whose temperature and vibration may be known on the way.
ON_THE_WAY_ROW = KeyRow(
    or_part(
        table(
            rows=rows_of(
                {
                    "temperature": or_size(
                        table(TemperaturePart),
                        _VALUES["temperature"],
                        TemperaturePart.rows,
                    ),
                    "vibration": or_size(
                        items(table(VibrationPart)), _VALUES["vibration"]
                    ),
                }
            ),
            title="use on the way",
        ),
        words={NONE: _NONE},
    ),
    _SAYS.format(known=", or its profile or warm_up where it is known"),
)


def _zero(value: Any) -> Any:  # noqa: ANN401 - of a file
    """Return 0 s for a 0 without a unit: of a time it is clear."""
    return STATED[AGE][1] if str(value).strip() == "0" else value


AGE_KIND = or_else(
    _VALUES[AGE],
    lambda node, gravity, read: read(replace(node, value=_zero(node.value)), gravity),
)
AGE_ROW = KeyRow(AGE_KIND, "time from the calibration to the use; unset: not stated")


def stated_lines(environment: object, age: object) -> tuple[ErrorLine, ...]:
    """Return the lines of what a file states, both as their fields have read them.

    No environment means no time since the test either, where no age is given.
    """
    given: dict[str, Any] = {key: getattr(environment, key, None) for key in _NONE}
    given["age"] = age
    if age is None and is_none(environment):
        given["age"] = parse_quantity("0 s", "s")
    return tuple(
        stated_line(key, value) for key, value in given.items() if value is not None
    )


def is_none(environment: object) -> bool:
    """Say whether an environment is that of the test in all that can be stated."""
    found = [getattr(environment, key, None) for key in _NONE]
    # In a procedure each stands in a mapping beside what is of the test.
    found = [getattr(one, MISSION, one) for one in found]
    return all(isinstance(one, Quantity) and one.value == 0.0 for one in found)


def stated_line(key: str, value: Any) -> ErrorLine:  # noqa: ANN401
    """Return the line of the environment that a value states."""
    source = source_of(ENVIRONMENT, STATED[key][0])
    if not isinstance(value, KnownCourse):
        return read_value(source, ENVIRONMENT, value).line
    one = parse_quantity(f"1 {value.unit}", source.like(ENVIRONMENT))
    size = value.course.largest
    return replace(
        read_value(source, ENVIRONMENT, one).line,
        u=np.array([size]),
        printed=value.printed,
        meaning=COURSE,
        course=value.course if size else None,
    )


def read_environment(text: str) -> tuple[ErrorLine, ...]:
    """Read what a call states: 'none', or 'temperature 20 degC, vibration 1 g'.

    Raises
    ------
    CallError
        It says neither.
    """
    is_none = text.strip().casefold() == NONE
    every = IN_TEST if is_none else {}
    found = {key: _of(key, zero) for key, zero in every.items()}
    for part in () if is_none else text.strip().strip("{}").split(","):
        key, _, value = part.strip().replace("=", " ").replace(":", " ").partition(" ")
        if key not in _NONE or key in found:
            raise CallError(
                f"environment: found {part.strip()!r}{' again' if key in found else ''}"
                f" in {text!r}, expected the one word none, or temperature and "
                "vibration, each once at the most: 'temperature 20 degC, vibration 1 g'"
            )
        found[key] = _of(key, value.strip())
    return tuple(stated_line(key, value) for key, value in found.items())


@dataclass(frozen=True)
class Stated:
    """An environment as it is known on the way."""

    temperature: object = None
    vibration: object = None


def read_age(text: str) -> ErrorLine:
    """Read the age that a call states, '1 year' or 0; CallError: it is none."""
    return stated_line(AGE, _of(AGE, text))


def _of(key: str, text: str) -> Quantity:
    """Read one quantity of a call, which is not negative."""
    like = source_of(ENVIRONMENT, STATED[key][0]).like(ENVIRONMENT)
    try:
        found = parse_quantity(str(_zero(text)) if key == AGE else text, like)
    except UnitError as error:
        raise CallError(f"{key}: {error}") from None
    if found.value < 0.0:
        raise CallError(f"{key}: found {text!r}, expected one that is not negative")
    return found


def with_use(procedure: Procedure, lines: Iterable[ErrorLine]) -> Procedure:
    """Return a procedure that is used as the lines say, in place of what it says."""
    new = {line.name: line for line in lines}
    if not new:
        return procedure
    at = tuple(f"{Name(name, owner=ENVIRONMENT)}:" for name in new)
    return replace(
        procedure,
        environment=(
            *(line for line in procedure.environment if line.name not in new),
            *new.values(),
        ),
        assumptions=(
            *(text for text in procedure.assumptions if not text.startswith(at)),
            *(
                sentence(
                    "assumed.stated",
                    key=Name(line.name, owner=ENVIRONMENT),
                    printed=line.printed,
                    meaning=line.meaning,
                    source=line.source,
                )
                for line in new.values()
            ),
        ),
    )


def in_use(
    procedure: Procedure, requirement: Requirement | None, mission: Mission | None
) -> Procedure:
    """Return a procedure that is used as all of them state.

    What a call states goes before what files do, and is told by its source. An age of
    0, as `environment: none` has it, gives way to any other.

    Raises
    ------
    CallError
        Two files state different ones.
    """
    stated: dict[str, tuple[ErrorLine, str]] = {
        line.name: (line, procedure.origin.file)
        for line in procedure.environment
        if line.name in LINES
    }
    new = {}
    given: tuple[Requirement | Mission | None, ...] = (requirement, mission)
    for file in [one for one in given if one is not None]:
        for line in file.use:
            other, where = stated.get(line.name, (line, ""))
            is_no_age = line.name == AGE and not other.u.any()
            gives_way = is_no_age and other.source != OPTION[AGE]
            if line.name == AGE and line.name in stated and not line.u.any():
                continue
            if other.source in OPTION.values() and not gives_way:
                continue
            if not gives_way:
                refuse_two(other, where, line, file.origin.file)
            stated[line.name] = line, file.origin.file
            new[line.name] = line
    return with_use(procedure, new.values())


def refuse_two(one: ErrorLine, where: str, other: ErrorLine, there: str) -> None:
    """Refuse two files that state different ones.

    Raises
    ------
    CallError
    """
    if one.u[0] != other.u[0] or one.course != other.course:
        key = next(key for key, (own, _) in STATED.items() if own == one.name)
        raise CallError(
            f"{key} is {one.printed} in {where} and {other.printed} in {there}; state "
            f"it once, or with {OPTION.get(key, OPTION['environment'])}"
        )


def of_the_test(lines: Iterable[ErrorLine]) -> tuple[ErrorLine, ...]:
    """Return the lines of an environment that act in the test, not in the use."""
    return tuple(line for line in lines if line.name not in LINES)


def stated_of(procedure: Procedure) -> Mapping[str, ErrorLine]:
    """Return what is stated of the use, by its key: temperature, vibration, age."""
    there = {line.name: line for line in procedure.environment}
    return {key: there[line] for key, (line, _) in STATED.items() if line in there}
