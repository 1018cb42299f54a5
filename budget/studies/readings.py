"""Readings of values whose meaning a data sheet leaves open: the answer under each.

A line holds the reading with the largest standard uncertainty, of equal ones that which
leaves it the line it is; here is what the other readings give, which may be worse for
an output. A sensor meets if it does under every one that is computed. Readings of
several lines are combined as long as there are few combinations; else each is changed
alone, and all at once to their smallest.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import inf, log, prod
from typing import TYPE_CHECKING

import numpy as np

from budget.inputs.specification import SIDES
from budget.model.estimators import estimator_of
from budget.names import Name
from budget.results import ReadingEffect, ReadingVerdict, ReadingVerdicts
from budget.studies.judgement import judge, screen
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.inputs.records import ErrorLine, Sensor
    from budget.question import Question
    from budget.studies.judgement import Judged

MOST = 16  # combinations that are all computed

# By the name of a line: the word of its reading and the line that it is then.
Choice = tuple[tuple[Name, str], ...]


def effects(question: Question) -> tuple[ReadingEffect, ...]:
    """Return what each other reading alone makes of the standard uncertainties.

    Of each the output whose u changes most, by the law of propagation; u over that
    with the readings that are taken.
    """
    others = [
        (sensor, line, word)
        for sensor in question.sensors
        for line, words in _open_lines(sensor).items()
        for word in words
        if word != _taken(sensor, line)
    ]
    question = replace(question, requirement=None, asked=None, only=None)
    now = _u(question) if others else {}
    found = []
    for sensor, line, word in others:
        u = _u(question.with_sensors([under(sensor, ((line, word),))]))
        output = _largest_change(u, now)
        found.append(
            ReadingEffect(
                line=line,
                reading=word,
                taken=_taken(sensor, line),
                output=output,
                ratio=u[output] / now[output] if now[output] else inf,
            )
        )
    return tuple(found)


def verdicts_by_reading(
    question: Question,
    *,
    seed: int,
    by_law: bool = False,
    taken: Judged | None = None,
) -> ReadingVerdicts | None:
    """Judge one sensor under the readings of its open lines; None where none is open.

    As every command judges (budget.studies.judgement), or by the law alone. Of more
    than MOST combinations those that are taken, each other one alone, and the smallest
    of every line. `taken` is how the sensor stands as it is, where that is known: it is
    the first of them.

    The sides of a density are not changed: the larger noise is taken, and less of it is
    never worse, but for an estimator that weighs by it.
    """
    (sensor,) = question.sensors
    weighs_noise = estimator_of(question.procedure.formulas).weighs_noise
    lines = {
        name: words
        for name, words in _open_lines(sensor).items()
        if weighs_noise or {*words} != {*SIDES}
    }
    if not lines:
        return None
    total = prod(len(words) for words in lines.values())
    found = []
    for place, choice in enumerate(_combinations(sensor, lines, total)):
        read = question.with_sensors([under(sensor, choice)]) if place else question
        if (held := read.held) is None:
            return None
        judged = None if place else taken
        if judged is None:
            look = screen if by_law else judge
            judged = look(held, seed=seed)
        found.append(
            ReadingVerdict(
                words=choice,
                verdict=judged.verdict(held.absent),
                utilisation=judged.utilisation,
            )
        )
    return ReadingVerdicts(sensor=sensor.kind, total=total, found=tuple(found))


def under(sensor: Sensor, choice: Choice) -> Sensor:
    """Return a sensor with other readings of some of its lines."""
    lines = list(sensor.lines)
    for name, word in choice:
        place = next(k for k, one in enumerate(lines) if _is_open_as(one, name))
        lines[place] = replace(
            dict(lines[place].readings)[word], readings=lines[place].readings
        )
    return sensor.with_lines(lines)


def _open_lines(sensor: Sensor) -> dict[Name, tuple[str, ...]]:
    """Return the lines whose meaning is open, as the file names them, and words."""
    return {
        _name(line, sensor.kind): tuple(word for word, _ in line.readings)
        for line in sensor.lines
        if line.readings
    }


def _name(line: ErrorLine, kind: str) -> Name:
    """Return the line that a file names: that of the first reading that stands there.

    What is read as over temperature is another line of the model.
    """
    names = [one.name for _, one in line.readings]
    here = [name for name in names if not name.endswith("_over_temperature")]
    return Name((here or names)[0], owner=kind)


def _is_open_as(line: ErrorLine, name: Name) -> bool:
    """Say whether a line is the open one that a file names so."""
    return bool(line.readings) and _name(line, name.owner) == name


def _taken(sensor: Sensor, name: Name) -> str:
    """Return the word of the reading that a line has now."""
    line = next(one for one in sensor.lines if _is_open_as(one, name))
    return next(
        word
        for word, one in line.readings
        if one.name == line.name
        and np.array_equal(one.u, line.u)
        and one.distributions == line.distributions
    )


def _combinations(
    sensor: Sensor, lines: Mapping[Name, tuple[str, ...]], total: int
) -> list[Choice]:
    """Return the readings to compute, those that are taken first."""
    taken = {name: _taken(sensor, name) for name in lines}
    first = tuple(taken.items())
    if total <= MOST:
        every = (
            tuple(zip(lines, words, strict=True)) for words in product(*lines.values())
        )
        return [first, *(choice for choice in every if choice != first)]
    alone = [
        tuple({**taken, name: word}.items())
        for name, words in lines.items()
        for word in words
        if word != taken[name]
    ]
    smallest = tuple(
        (name, min(words, key=_sizes(sensor, name).__getitem__))
        for name, words in lines.items()
    )
    return list(dict.fromkeys((first, *alone, smallest)))


def _sizes(sensor: Sensor, name: Name) -> dict[str, float]:
    """Return the standard uncertainty of each reading, by its word [SI]."""
    line = next(one for one in sensor.lines if _is_open_as(one, name))
    return {word: settle(one.largest) for word, one in line.readings}


def _u(question: Question) -> dict[Name, float]:
    """Return the standard uncertainty of every output [SI]."""
    u = question.law.standard_uncertainty.tolist()
    names = (output.name for output in question.problem.outputs)
    return dict(zip(names, u, strict=True))


def _largest_change(u: Mapping[Name, float], taken: Mapping[Name, float]) -> Name:
    """Return the output whose u changes most, by its ratio."""
    names = [name for name in u if taken[name] > 0.0 or u[name] > 0.0]
    changes = [
        (abs(log(settle(u[name] / taken[name]))) if u[name] else 0.0)
        if taken[name]
        else inf
        for name in names
    ]
    return names[first_largest(changes)] if names else next(iter(u))
