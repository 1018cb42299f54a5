"""Lower bounds: outputs that a line which is not given would widen.

Decided by the model and not by a list: a probe stands for each expected line that a
data sheet does not give, and what it alone reaches, lacks it. Products of two lines
are no source, as in the coupling table.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs, rotations_of
from budget.calibration.mission import REFERENCE, mission_problem
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import (
    initial_lines,
    is_beside,
    with_accelerometers,
)
from budget.inputs.records import Sensor
from budget.inputs.specification import time_of
from budget.missing import line_of
from budget.model.estimators import estimator_of
from budget.model.sources import SENSORS, blamed_outside, lines_of, source_of
from budget.model.sources.later import AGEING, age_in
from budget.model.sources.processes import FlickerNoise
from budget.names import IMU, Name, every_output

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.inputs.records import Device, ErrorLine, Mission, Procedure
    from budget.model.source import Source

SAME_TIME = 0.01  # relative: 365 days are a year, of 365.25 [1]
DRAWS = 8  # of each line alone


@cache
def _together() -> tuple[frozenset[Name], ...]:
    """Return lines that vary, in sets that are probed together.

    The numbers of a flicker take longer to import than all others to compute; what
    another package brings may fail, and is alone.
    """
    sets: dict[str, set[Name]] = {}
    for kind in SENSORS:
        for line in lines_of(kind):
            if line.varies:
                apart = line.origin or str(isinstance(line.effect, FlickerNoise))
                sets.setdefault(apart, set()).add(Name(line.name, owner=kind))
    return tuple(map(frozenset, sets.values()))


def lacking(
    sensors: Sequence[Sensor],
    procedure: Procedure,
    *,
    reference: str,
    only: frozenset[Name] | None = None,
) -> Mapping[Name, tuple[Name, ...]]:
    """Return for each output the expected lines that are not given and would reach it.

    Turns, dwells and formulas decide what a line reaches; one that cancels in the error
    reference reaches nothing, one that `only` leaves out is not missing. By the name of
    the output; () where its number is complete.
    """
    found: dict[Name, tuple[Name, ...]] = {}
    for triads in _families(sensors, procedure):
        probes = {
            name: line
            for sensor in triads
            for name in sensor.expected_missing
            if (line := _stand_in(name, only)) is not None
        }
        reached = _reached(triads, probes, procedure, reference)
        for output in (one for sensor in triads for one in every_output(sensor.kind)):
            found[output] = tuple(name for name in probes if output in reached[name])
    for output in every_output(IMU):
        found[output] = tuple(
            name
            for rotation in rotations_of(output)
            for name in found.get(rotation, ())
        )
    return found


def lacking_of_mission(
    sensors: Sequence[Sensor],
    procedure: Procedure,
    mission: Mission,
    outputs: tuple[Name, ...],
    *,
    only: frozenset[Name] | None = None,
) -> Mapping[Name, tuple[Name, ...]]:
    """Return the same for outputs of a mission, by what a line does in run too."""
    probes = {
        name: line
        for sensor in sensors
        for name in sensor.expected_missing
        if (line := _stand_in(name, only)) is not None
    }
    reached = _reached(sensors, probes, procedure, REFERENCE, on=(mission, outputs))
    return {
        output: tuple(name for name in probes if output in reached[name])
        for output in outputs
    }


def expecting(
    sensor: Sensor, procedure: Procedure, reference: str, *, every: bool = False
) -> Sensor:
    """Return a sensor that is expected to say what else counts: its age, its making.

    At a later turn-on after an age what a bias or a scale factor has gone is known by a
    line of ageing, or by a repeatability that holds over that time at the least. Where
    `every` parameter counts, what a new unit has of those that are held counts, too.
    """
    if every:
        sensor = _as_made(sensor, procedure)
    age = age_in({line.name: line for line in procedure.environment})
    if reference != "next_turn_on" or age == 0.0:
        return sensor
    missing = tuple(
        Name(ageing, owner=sensor.kind)
        for parameter, ageing in AGEING.items()
        if sensor.line(ageing) is None
        and not _holds_over(sensor.line(f"{parameter}_repeatability"), age)
    )
    there = (name for name in sensor.expected_missing if name not in missing)
    return replace(sensor, expected_missing=(*there, *missing))


def _as_made(sensor: Sensor, procedure: Procedure) -> Sensor:
    """Return a sensor that is expected to say what it has from its making."""
    known = [line for line in lines_of(sensor.kind) if line.is_initial]
    probes = tuple(line_of(line, sensor.kind) for line in known)
    given = {line.name for line in sensor.initial}
    missing = (
        Name(line.name, owner=sensor.kind)
        for line in initial_lines(replace(sensor, initial=probes), procedure)
        if line.name not in given
    )
    there = dict.fromkeys((*sensor.expected_missing, *missing))
    return replace(sensor, expected_missing=tuple(there))


def expecting_device(
    device: Device, procedure: Procedure, reference: str, *, every: bool = False
) -> Device:
    """Return a device whose sensors are expected to say what else counts."""
    gyro, other = (
        None if sensor is None else expecting(sensor, procedure, reference, every=every)
        for sensor in (device.gyro, device.accelerometer)
    )
    return replace(device, gyro=gyro, accelerometer=other)


def _holds_over(line: ErrorLine | None, age: float) -> bool:
    """Say whether a line says that it holds over a time as long as that [s]."""
    over = None if line is None else time_of(line.horizon)
    return over is not None and over.value * (1.0 + SAME_TIME) >= age


def could_widen(
    sensors: Sequence[Sensor],
    procedure: Procedure,
    *,
    reference: str,
    on: tuple[Mission, tuple[Name, ...]] | None = None,
) -> Mapping[Name, tuple[Name, ...]]:
    """Return for each line that is not given the outputs that it would reach.

    `on` is a mission with its outputs, in the place of those of the calibration. () of
    a line that changes nothing: under this error reference, or in this use.
    """
    found: dict[Name, tuple[Name, ...]] = {}
    families = _families(sensors, procedure) if on is None else (sensors,)
    for triads in families:
        probes = {
            name: source_of(name.owner, name.quantity)
            for sensor in triads
            for name in sensor.not_given
        }
        found |= _reached(triads, probes, procedure, reference, on=on)
    return found


def _families(
    sensors: Sequence[Sensor], procedure: Procedure
) -> Iterator[tuple[Sensor, ...]]:
    """Yield triads that show in one another's outputs together, the others alone."""
    there = with_accelerometers(sensors, procedure)
    if is_beside(procedure):
        yield there
    else:
        yield from ((sensor,) for sensor in there)


def _reached(
    triads: Sequence[Sensor],
    probes: Mapping[Name, Source],
    procedure: Procedure,
    reference: str,
    *,
    on: tuple[Mission, tuple[Name, ...]] | None = None,
) -> dict[Name, tuple[Name, ...]]:
    """Return for each probe the outputs that it alone reaches."""
    asked = {name: Name(line.name, owner=name.owner) for name, line in probes.items()}
    nominal = tuple(
        (one.kind, (*one.nominal_bias, *one.nominal_mounting_angle)) for one in triads
    )
    # An estimator that weighs by noise lines is another one with more of them.
    is_weighted = estimator_of(procedure.formulas).weighs_noise
    together = [frozenset(asked.values())] if is_weighted else _together()
    found: dict[Name, tuple[Name, ...]] = {}
    for lines in together:
        if not lines.isdisjoint(asked.values()):
            try:
                found |= _reach(nominal, lines, procedure, reference, on)
            except Exception as error:
                if not blamed_outside(error):
                    raise
    return {name: found.get(line, ()) for name, line in asked.items()}


# What one device lacks another does not: asked of all lines at once, it is the same for
# all devices without nominal values, which are nearly all, and for the runs of a study.
@lru_cache(maxsize=256)
def _reach(
    triads: tuple[tuple[str, tuple[float, ...]], ...],
    lines: frozenset[Name],
    procedure: Procedure,
    reference: str,
    on: tuple[Mission, tuple[Name, ...]] | None,
) -> Mapping[Name, tuple[Name, ...]]:
    """Return the outputs that each line alone reaches in triads of nominal values.

    The outputs of a mission that are named `on` it, else all of the calibration. A line
    is drawn a few times, all others being 0: an output that it reaches moves.
    """
    bare = [
        Sensor(
            kind=kind,
            device="",
            nominal_bias=np.array(nominal[:3]),
            nominal_mounting_angle=np.array(nominal[3:]),
            lines=(),
            not_given=(),
            expected_missing=(),
        ).with_lines(
            line_of(source_of(kind, name.quantity), kind)
            for name in sorted(lines)
            if name.owner == kind
        )
        for kind, nominal in triads
    ]
    bare[0] = replace(bare[0], beside=bare[-1])
    if on is not None:
        mission, outputs = on
        # With a filter a line reaches what it reaches without.
        alone = replace(mission, aiding=(), start=(0.0,) * len(mission.start))
        problem = mission_problem(tuple(bare), procedure, alone, outputs)
    else:
        problem = calibration_problem(
            tuple(bare),
            procedure,
            reference=reference,
            outputs=known_outputs([one.kind for one in bare], procedure),
        )
    probes = [
        (group, rows)
        for group, rows in zip(problem.groups, problem.slices, strict=True)
        if group.name in lines
    ]
    rng = np.random.default_rng(0)  # of any numbers that are not equal
    x = np.tile(problem.mean[:, None], (len(probes) + 1) * DRAWS)
    for place, (group, rows) in enumerate(probes):
        draws = group.factor @ rng.standard_normal((group.size, DRAWS))
        x[rows, place * DRAWS : (place + 1) * DRAWS] += draws
    y = problem.evaluate(x).reshape(len(problem.outputs), -1, DRAWS)
    spread = np.sqrt(((y - y[:, -1:]) ** 2).mean(axis=2))  # from nominal values
    return {
        group.name: tuple(
            output.name
            for k, output in enumerate(problem.outputs)
            if spread[k, place] > output.resolution
        )
        for place, (group, _) in enumerate(probes)
    }


def _stand_in(name: Name, only: frozenset[Name] | None) -> Source | None:
    """Return the model line of a missing one; None where it is not asked for.

    'gyro.noise' is the first of the noise lines, a random walk.
    """
    lines = [
        line
        for line in lines_of(name.owner)
        if name.quantity in (line.expected, line.name)
        and (only is None or Name(line.name, owner=name.owner) in only)
    ]
    return lines[0] if lines else None
