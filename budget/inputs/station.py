"""Station files: uncertainties of table, place and timing, and of the environment."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from budget.inputs.checking import nearest
from budget.inputs.fields import (
    TEXT,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    ValueKind,
    check,
    fault,
    format_row,
    items,
    not_rising,
    one_of,
    or_else,
    table,
)
from budget.inputs.files import exists, find, shipped_names
from budget.inputs.reader import refuse
from budget.inputs.records import Origin, Station
from budget.inputs.specification import POSITIVE_TIME, read_value, value_of
from budget.inputs.tree import Node, describe
from budget.inputs.use import (
    AGE_KIND,
    IN_TEST,
    LINES,
    NONE,
    OPTION,
    of_the_test,
    or_part,
    read_age,
    read_environment,
    refuse_two,
    with_use,
)
from budget.language import note
from budget.model.sources import ENVIRONMENT, STATION, lines_of, source_of
from budget.model.sources.later import AGE
from budget.model.windows import ANGLE, EDGES, RATE, Timing
from budget.names import MISSION, Name, keys_of, words
from budget.sentences import sentence

if TYPE_CHECKING:
    from budget.inputs.files import NamedFile
    from budget.inputs.records import ErrorLine, Procedure
    from budget.inputs.specification import ReadValue
    from budget.inputs.tree import YamlFile
    from budget.model.source import Source
    from budget.units import Quantity

IDEAL = note("station: not given, an ideal one assumed")
OF_RUN = note("station: that of the recorded calibration")
LONGEST_NAME = 200  # of a file
MOST_POINTS = 100  # of soaks in one test
POINTS = "times from the start of a triad's test at which another one begins"


# By what stands beside it, a time: the value that needs it.
_TIMED = {
    beside: keys_of(one.name)[-1]
    for one in lines_of(ENVIRONMENT)
    for beside in (one.time, one.points)
    if beside
}


class Timed(Keyed):
    """A level of station or environment, some of whose values need a time beside."""

    rules: ClassVar[Rules] = tuple(
        rule
        for time, key in _TIMED.items()
        for rule in (
            Rule(
                key,
                lambda it, time=time, key=key: (
                    time in vars(it)
                    and getattr(it, time) is None
                    and getattr(it, key) is not None
                ),
                f"stands without {time}, expected that beside it",
            ),
            Rule(
                time,
                lambda it, time=time, key=key: (
                    getattr(it, time, None) is not None and getattr(it, key) is None
                ),
                f"is of {key}, which is not there; add it, or remove this",
            ),
        )
    )


def _check_rising(node: Node, gravity: float, read: Any) -> object:  # noqa: ANN401
    """Read times, and refuse those that do not rise."""
    times = read(node, gravity)
    says = "found {after!r} after {one!r}, expected times that rise"
    for text in not_rising(times, "", says).values():
        raise fault(text)
    return times


SOAKS = or_else(items(POSITIVE_TIME, least=1, most=MOST_POINTS), _check_rising)
# What a station says besides its figures, and what an unset word means.
WORDS = {
    "scale_from": KeyRow(
        one_of(ANGLE, RATE),
        "what scale factors of gyros are taken from; unset: angle, of whole turns",
    ),
    "window": KeyRow(
        one_of(*EDGES),
        "where windows of turns are cut: index of the table, rest, time; unset: index",
    ),
}


@cache
def surroundings(owner: str) -> ValueKind:
    """Return the rows of that owner, nested as its names are dotted; of none too."""
    tree: dict[str, Any] = {}
    for source in lines_of(owner):
        *folders, last = keys_of(source.name)
        branch = tree
        for folder in folders:
            branch = branch.setdefault(folder, {})
        branch[last] = source
    if owner == STATION:
        return _level(owner, owner, tree, WORDS)
    return or_part(_level(owner, owner, tree, {}), words={NONE: IN_TEST})


def _level(title: str, owner: str, tree: dict[str, Any], words: Rows) -> ValueKind:
    """Return the rows of one level of the mapping."""
    rows = {**words}
    for key, branch in tree.items():
        if isinstance(branch, dict):
            level: ValueKind = _level(f"{title} {key}", owner, branch, {})
            # 'temperature: 20 degC' is that of the use, as in a requirement.
            if MISSION in branch and branch[MISSION].name in LINES:
                level = or_part(level, key=MISSION)
            rows[key] = KeyRow(level)
            continue
        source: Source = branch
        own = AGE_KIND if source.name == AGE else value_of(source, owner)
        rows[key] = KeyRow(own, source.model)
        if source.time:
            rows[source.time] = KeyRow(POSITIVE_TIME, f"of {key}")
        if source.points:
            rows[source.points] = KeyRow(SOAKS, f"of {key}: {POINTS}")
    return table(Timed, rows, title)


def take_surroundings(owner: str, mapping: Keyed | None) -> tuple[ReadValue, ...]:
    """Return the sources that a mapping of that owner names, in the table's order."""
    taken = []
    for source in lines_of(owner):
        *folders, last = keys_of(source.name)
        level: Any = mapping
        for folder in folders:
            level = getattr(level, folder, None)
        figure = getattr(level, last, None)
        if figure is not None:
            one = read_value(source, owner, figure)
            timed = _timed(one.line, source, level) if source.time else one.line
            taken.append(replace(one, line=timed))
    return tuple(taken)


def _timed(line: ErrorLine, source: Source, level: Any) -> ErrorLine:  # noqa: ANN401
    """Return a line with the times that stand beside it on its level."""
    time: Quantity = getattr(level, source.time)
    points: tuple[Quantity, ...] = getattr(level, source.points or "", ())
    at = ", ".join(point.printed for point in points)
    beside = f", {words(source.points)} {at}" if points else ""
    return replace(
        line,
        correlation_time=np.array([time.value]),
        points=np.array([point.value for point in points]) if points else None,
        definition=f"{words(source.time)} {time.printed}{beside}",
    )


def describe_surroundings(owner: str, taken: tuple[ReadValue, ...]) -> tuple[str, ...]:
    """Say which figures of that owner count, with the words that stand beside them."""
    return tuple(
        f"{Name(line.name, owner=owner)}: {line.printed}, "
        + ", ".join(word for word in said if word)
        for line in (one.line for one in taken)
        for said in [
            (
                *(line.meaning, line.definition, line.includes, line.horizon),
                *(line.condition, line.source),
            )
        ]
    )


def _read_file(node: Node, gravity: float, mapping: Any) -> object:  # noqa: ANN401
    """Read a mapping, or the name of a station file."""
    value = node.value
    if not isinstance(value, str):
        return mapping(node, gravity)
    if not value.strip() or len(value) > LONGEST_NAME or "\x00" in value:
        raise fault("is no file name, expected one, or a mapping of keys")
    return value


_NAME = {"type": "string", "description": "a station file, or a shipped one"}
OR_FILE = or_else(surroundings(STATION), _read_file, _NAME)


class StationFile(Keyed):
    """A test station: what is not known of its table, its place and its environment."""

    rows: ClassVar[Rows] = {
        "format": format_row("station"),
        "name": KeyRow(TEXT, "unset: the file's name"),
        STATION: KeyRow(
            surroundings(STATION), "uncertainties of table, place and timing"
        ),
        ENVIRONMENT: KeyRow(
            surroundings(ENVIRONMENT),
            "what changes during the calibration; unset: nothing",
        ),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "station",
            lambda it: it.station is None,
            "is missing, expected its figures; of an ideal one 'station: {{}}'",
        ),
    )


def read_station(document: YamlFile) -> Station:
    """Turn a station file into a record, in SI.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model: StationFile = check(document, table(StationFile))
    return station_of(
        model.station,
        model.environment,
        name=model.name or document.stem,
        origin=Origin(file=document.base_name, sha256=document.sha256),
    )


def station_of(
    station: Keyed | None, environment: Keyed | None, *, name: str, origin: Origin
) -> Station:
    """Return the record of both mappings, as a file of either kind holds them."""
    shared = {
        STATION: take_surroundings(STATION, station),
        ENVIRONMENT: take_surroundings(ENVIRONMENT, environment),
    }
    return Station(
        name=name,
        station=tuple(one.line for one in shared[STATION]),
        environment=tuple(one.line for one in shared[ENVIRONMENT]),
        timing=Timing(
            scale_from=getattr(station, "scale_from", None) or ANGLE,
            edges=getattr(station, "window", None) or EDGES[0],
        ),
        assumptions=(
            *_unsaid(station),
            *(
                text
                for taken in shared.values()
                for one in taken
                for text in one.assumptions
            ),
            *(
                text
                for owner, taken in shared.items()
                for text in describe_surroundings(owner, taken)
            ),
        ),
        origin=origin,
    )


def _unsaid(station: Keyed | None) -> tuple[str, ...]:
    """Say which words a station leaves out that its figures need."""
    needed = {"scale_from": ("rate_error", ANGLE), "window": ("edge_jitter", EDGES[0])}
    return tuple(
        sentence("assumed.default", of=STATION, name=word, usual=usual)
        for word, (figure, usual) in needed.items()
        if getattr(station, figure, None) and not getattr(station, word)
    )


def named_station(document: YamlFile) -> str:
    """Return the name of the station that a procedure file names; '' if it does not."""
    node = document.root.child(STATION)
    return node.value if node is not None and isinstance(node.value, str) else ""


def station_file(document: YamlFile) -> NamedFile:
    """Find the station that a procedure names: beside it, else as commands find it.

    Raises
    ------
    SpecError
        There is none.
    """
    name = named_station(document)
    beside = Path(document.file).parent / name
    file = find(beside if exists(beside) else name, STATION)
    if not exists(file.path):
        known = shipped_names(STATION)
        message = (
            f"found {describe(name)}, expected a station file, beside this one or "
            f"where the command runs, or a shipped one: {', '.join(known)}"
            f"{nearest(name, known)}"
        )
        raise document.refuse(((STATION,), message))
    return file


def of_run(procedure: Procedure) -> Procedure:
    """Return a procedure whose table and place a recorded calibration has counted."""
    own = {line.name: line for line in procedure.environment if line.name in LINES}
    left = tuple(text for text in procedure.assumptions if text != IDEAL)
    return replace(
        procedure,
        station=(),
        environment=tuple(own.values()),
        station_origin=None,
        assumptions=(*left, OF_RUN),
    )


def done_at(procedure: Procedure, station: Station, shown: str) -> Procedure:
    """Return a procedure at a station that is given beside it, `shown` in messages.

    Raises
    ------
    SpecError
        It has one of its own, or both have an environment.
    """
    for has, what in (
        (IDEAL not in procedure.assumptions, STATION),
        (
            of_the_test(procedure.environment) and of_the_test(station.environment),
            ENVIRONMENT,
        ),
    ):
        if has:
            message = (
                f"has a {what} of its own, and {station.origin.file} is given beside "
                "it; remove one of them"
            )
            raise refuse(shown, message)
    return at_station(procedure, station)


def used(procedure: Procedure, environment: str, shown: str) -> Procedure:
    """Return a procedure whose unit is used in an environment, `shown` in messages.

    Raises
    ------
    CallError
        The environment is none.
    SpecError
        It states one of its own.
    """
    lines = read_environment(environment)
    if any(line.name in LINES and line.name != AGE for line in procedure.environment):
        message = (
            "states an environment of its use, and another is given beside it; remove "
            "one of them"
        )
        raise refuse(shown, message)
    has_age = any(
        x.name == AGE and (x.u.any() or x.source == OPTION[AGE])
        for x in procedure.environment
    )
    new = [line for line in lines if not (has_age and line.name == AGE)]
    return with_use(
        procedure, [replace(line, source=OPTION[ENVIRONMENT]) for line in new]
    )


def aged(procedure: Procedure, age: str, shown: str) -> Procedure:
    """Return a procedure whose calibration is used at an age, `shown` in messages.

    Raises
    ------
    CallError
        The age is no time.
    SpecError
        Its environment has one of its own.
    """
    if any(line.name == AGE and line.u.any() for line in procedure.environment):
        message = (
            "has an age of its own (environment), and another is given beside it; "
            "remove one of them"
        )
        raise refuse(shown, message)
    return with_use(procedure, [replace(read_age(age), source=OPTION[AGE])])


def with_age(procedure: Procedure, age: Quantity, source: str = "") -> Procedure:
    """Return a procedure with that age, in place of the one that it has."""
    line = read_value(source_of(ENVIRONMENT, AGE), ENVIRONMENT, age).line
    return with_use(procedure, [replace(line, source=source)])


def at_station(procedure: Procedure, station: Station) -> Procedure:
    """Return a procedure at another station, whose environment counts if it has one.

    Raises
    ------
    CallError
        Both state a use, and different ones; an age of 0 gives way.
    """
    own = {line.name: line for line in procedure.environment if line.name in LINES}
    for line in station.environment:
        if line.name in own and (line.name != AGE or line.u.any()):
            if line.name == AGE and not own[AGE].u.any():
                del own[AGE]
            else:
                refuse_two(
                    own[line.name],
                    procedure.origin.file,
                    line,
                    station.origin.file,
                )
    left = tuple(text for text in procedure.assumptions if text != IDEAL)
    return replace(
        procedure,
        station=station.station,
        environment=tuple(
            {
                line.name: line
                for line in (
                    *(
                        of_the_test(station.environment)
                        or of_the_test(procedure.environment)
                    ),
                    *(x for x in station.environment if x.name in LINES),
                    *own.values(),
                )
            }.values()
        ),
        timing=station.timing,
        station_origin=station.origin,
        assumptions=(*left, *station.assumptions),
    )
