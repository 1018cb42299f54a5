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
from budget.studies.judgement import judge, screened
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
        (sensor, name, _taken(line), word)
        for sensor in question.sensors
        for name, line in _open(sensor).items()
        for word, _ in line.readings
        if word != _taken(line)
    ]
    question = replace(question, requirement=None, asked=None, only=None)
    now = _u(question) if others else {}
    found = []
    for sensor, name, taken, word in others:
        u = _u(question.with_sensors([under(sensor, ((name, word),))]))
        output = _largest_change(u, now)
        found.append(
            ReadingEffect(
                line=name,
                reading=word,
                taken=taken,
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

    What belongs to both sensors is not, nor what rests on predicted lines, whose
    verdict is a probability, nor some sources alone.

    As every command judges (budget.studies.judgement), or by the law alone. Of more
    than MOST combinations those that are taken, each other one alone, and the smallest
    of every line. `taken` is how the sensor stands as it is, where that is known: it is
    the first of them.

    The sides of a density are not changed: the larger noise is taken, and less of it is
    never worse, but for an estimator that weighs by it.
    """
    sensor, *others = question.sensors
    if others or question.only is not None or question.filled.prediction is not None:
        return None
    weighs_noise = estimator_of(question.procedure.formulas).weighs_noise
    lines = {
        name: line
        for name, line in _open(sensor).items()
        if weighs_noise or {*dict(line.readings)} != {*SIDES}
    }
    if not lines:
        return None
    total = prod(len(line.readings) for line in lines.values())
    found = []
    for place, choice in enumerate(_combinations(lines, total)):
        read = question.with_sensors([under(sensor, choice)]) if place else question
        if (held := read.held) is None:
            return None
        judged = None if place else taken
        if judged is None:
            look = screened if by_law else judge
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
    lines = _open(sensor)
    other = {
        id(line): replace(dict(line.readings)[word], readings=line.readings)
        for name, word in choice
        for line in [lines[name]]
    }
    return sensor.with_lines(other.get(id(line), line) for line in sensor.lines)


def _open(sensor: Sensor) -> dict[Name, ErrorLine]:
    """Return the lines whose meaning is open, by the names that a file has for them.

    That is the first reading that stands there: what is read as over temperature is
    another line of the model.
    """
    found = {}
    for line in sensor.lines:
        names = [one.name for _, one in line.readings]
        here = [name for name in names if not name.endswith("_over_temperature")]
        if names:
            found[Name((here or names)[0], owner=sensor.kind)] = line
    return found


def _taken(line: ErrorLine) -> str:
    """Return the word of the reading that a line has now."""
    return next(
        word
        for word, one in line.readings
        if one.name == line.name
        and np.array_equal(one.u, line.u)
        and one.distributions == line.distributions
    )


def _combinations(lines: Mapping[Name, ErrorLine], total: int) -> list[Choice]:
    """Return the readings to compute, those that are taken first."""
    taken = {name: _taken(line) for name, line in lines.items()}
    first = tuple(taken.items())
    if total <= MOST:
        words = (dict(line.readings) for line in lines.values())
        every = (tuple(zip(lines, one, strict=True)) for one in product(*words))
        return [first, *(choice for choice in every if choice != first)]
    alone = [
        tuple({**taken, name: word}.items())
        for name, line in lines.items()
        for word, _ in line.readings
        if word != taken[name]
    ]
    smallest = tuple(
        (name, min(line.readings, key=lambda read: settle(read[1].largest))[0])
        for name, line in lines.items()
    )
    return list(dict.fromkeys((first, *alone, smallest)))


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
