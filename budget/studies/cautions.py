"""Warnings on a budget: what its numbers leave out or take for granted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, pi, radians
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mission import not_carried, of_test_alone
from budget.calibration.saturation import saturations
from budget.calibration.schemes import calibrates, noise_of, removal
from budget.inputs.records import UNCALIBRATED
from budget.inputs.specification import time_of
from budget.model.estimators import estimator_of
from budget.model.source import Coefficient, Disturbance, Nonlinearity, TurnOnChange
from budget.model.sources import DEVICE, ENVIRONMENT, source_of
from budget.model.sources.later import AGE, AGEING
from budget.model.sources.processes import Quantization, SampleNoise
from budget.names import IMU, MISSION, Name, by_group
from budget.question import given_lines, kinds_of, limited_but_held
from budget.sentences import described, sentence
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import (
        Device,
        MeasuredParameters,
        Mission,
        Procedure,
        Requirement,
        Sensor,
    )
    from budget.methods.gum import Propagation
    from budget.methods.monte_carlo import Sample
    from budget.problem import Problem
    from budget.question import Question
    from budget.results import Budget, OutputBudget

# Trials that a tail of the interval should hold at the least: JCGM 101:2008, 7.2.2 asks
# for M much larger than 1/(1 - p).
LEAST_OUTSIDE = 100


def options_without_effect(
    method: str, *, trials: int | None, interval: str
) -> tuple[str, ...]:
    """Name the options that were given and change nothing under this method."""
    given = {"trials": trials is not None, "interval": interval != "symmetric"}
    return tuple(
        sentence("cautions.without_effect", option=option)
        for option, is_given in given.items()
        if method == "gum" and is_given
    )


def not_calibrated(devices: Sequence[Device], procedure: Procedure) -> tuple[str, ...]:
    """Say of which triads that are there a procedure finds nothing."""
    if procedure.formulas in UNCALIBRATED:
        return ()
    return tuple(
        sentence("cautions.not_calibrated", procedure=procedure.name, sensor=kind)
        for kind in kinds_of(devices)
        if not calibrates(kind, procedure)
    )


def about_results(devices: Sequence[Device], procedure: Procedure) -> tuple[str, ...]:
    """Say what results of recorded calibrations leave open."""
    every = _results(devices, procedure)
    has_table = bool(procedure.station)
    untold = [one.file for one in every if not one.is_told]
    bare = [one.file for one in every if not (one.has_station or has_table)]
    rows = (
        (untold, sentence("measured_unit.untold", files=untold)),
        (bare, sentence("measured_unit.no_table", files=bare)),
    )
    return tuple(said for files, said in rows if files)


def better_than_units(
    devices: Sequence[Device], procedure: Procedure
) -> tuple[str, ...]:
    """Say that data sheets are predicted on an ideal table, beside units on a real one.

    Which station the sheet would be calibrated at nobody but the caller knows: results
    may be of several.
    """
    files = tuple(x.file for x in _results(devices, procedure) if x.has_station)
    if procedure.station or not files or all(one.measured for one in devices):
        return ()
    text = sentence("measured_unit.beside_ideal", procedure=procedure.name, files=files)
    return (text,)


def _results(
    devices: Sequence[Device], procedure: Procedure
) -> tuple[MeasuredParameters, ...]:
    """Return what was measured of devices after that procedure, each once."""
    every = dict.fromkeys(one.measured for one in devices if one.measured)
    return tuple(one for one in every if one.procedure == procedure.name)


def not_estimated(
    devices: Sequence[Device], procedure: Procedure, requirement: Requirement | None
) -> tuple[str, ...]:
    """Say which limits a procedure says nothing of, as it holds what they are on."""
    limits = () if requirement is None else requirement.outputs
    return tuple(
        sentence(
            "cautions.not_estimated", procedure=procedure.name, parameters=parameters
        )
        for parameters in by_group(
            limited_but_held(kinds_of(devices), procedure, limits)
        )
    )


def not_on_a_mission(
    requirement: Requirement | None, mission: Mission | None
) -> tuple[str, ...]:
    """Say that limits on a mission are judged by nobody who is given none."""
    if mission is not None or requirement is None or MISSION not in requirement.kinds:
        return ()
    return (sentence("cautions.limits_on_a_mission"),)


def not_of_one_sensor(requirement: Requirement) -> tuple[str, ...]:
    """Say which limits are judged by nobody who takes the sensors one by one."""
    of_both = [name for name in requirement.outputs if name.owner == IMU]
    return tuple(
        sentence("cautions.of_both", parameters=parameters)
        for parameters in by_group(of_both)
    )


def not_weighted(sensors: Sequence[Sensor], procedure: Procedure) -> tuple[str, ...]:
    """Say for which triads there is no noise that an estimator could weigh by."""
    if not estimator_of(procedure.formulas).weighs_noise:
        return ()
    return tuple(
        sentence("cautions.no_weights", sensor=sensor.kind)
        for sensor in sensors
        if not noise_of(sensor.kind, sensor.lines)
    )


def asked_alone(question: Question) -> tuple[str, ...]:
    """Say which of the sources that alone count the data sheet does not give."""
    given = given_lines(question.sensors, question.procedure, mission=question.journey)
    return tuple(
        sentence("cautions.asked_alone", name=name)
        for name in sorted((question.only or frozenset()) - given.keys())
    )


def few_trials(trials: int | None, coverage: float) -> tuple[str, ...]:
    """Warn of an interval whose tails hold hardly a trial."""
    if trials is None or trials * (1.0 - coverage) >= LEAST_OUTSIDE:
        return ()
    wanted = int(np.ceil(LEAST_OUTSIDE / (1.0 - coverage)))
    text = sentence(
        "cautions.few_trials",
        trials=trials,
        outside=trials * (1.0 - coverage),
        coverage=coverage,
        wanted=wanted,
    )
    return (text,)


def doubts(rows: Sequence[OutputBudget]) -> tuple[str, ...]:
    """Warn of outputs whose interval is the law's, and not confirmed by Monte Carlo."""
    doubtful = [
        row.output.name
        for row in rows
        if row.validation is not None and not row.validation.holds
    ]
    if not doubtful:
        return ()
    return (sentence("cautions.not_confirmed", outputs=doubtful),)


def judged_otherwise(budget: Budget) -> tuple[str, ...]:
    """Say which intervals are not of the kind that was asked for."""
    interval, found = budget.settings.interval, budget.assessment
    outputs: list[Name] | None = [
        row.output.name
        for row in budget.outputs
        if row.by_trials and budget.settings.method == "gum"
    ]
    if found is not None and any(row.by_trials for row in found.outputs):
        outputs = None
    if interval == "symmetric" or outputs == []:
        return ()
    return (sentence("cautions.judged_otherwise", interval=interval, outputs=outputs),)


def unsettled(problem: Problem, drawn: Sample) -> tuple[str, ...]:
    """Warn of outputs that the trials allowed were too few for."""
    names = [
        output.name
        for output, settled in zip(problem.outputs, drawn.is_settled, strict=True)
        if not settled
    ]
    if not names:
        return ()
    return (sentence("cautions.unsettled", trials=drawn.trials, outputs=names),)


def unknown_zeros(problem: Problem, law: Propagation) -> tuple[str, ...]:
    """Warn of outputs that nothing given reaches: their 0 is ignorance, not quality."""
    resolution = np.array([output.resolution for output in problem.outputs])
    still = law.standard_uncertainty <= resolution
    groups = dict.fromkeys(
        output.name.group
        for output, is_still in zip(problem.outputs, still, strict=True)
        if is_still
    )
    return (sentence("cautions.unknown_zeros", groups=tuple(groups)),) if groups else ()


@dataclass(frozen=True, kw_only=True)
class Unfelt:
    """What is given and reaches no output of this test."""

    source: Name
    removed: str  # what makes it cancel, to first order; '' if nothing does
    needs: str  # else: what is not there that it takes


def unfelt(question: Question) -> tuple[Unfelt, ...]:
    """Find what is given and reaches no parameter of this test: what removes it, lacks.

    Disturbances, changes and coefficients only: that an offset is shared by the
    reference is said elsewhere. Nothing where only some sources count.
    """
    if question.only is not None:
        return ()
    whole = question if question.asked is None else replace(question, asked=None)
    problem, law, sensors = whole.problem, whole.law, whole.sensors
    zero = np.array([output.resolution**2 for output in problem.outputs])
    first_order = [
        ((law.C[:, rows] @ np.asarray(group.covariance)) * law.C[:, rows]).sum(axis=1)
        for group, rows in zip(problem.groups, problem.slices, strict=True)
    ]
    removed = {
        group.name: what
        for group, variance in zip(problem.groups, first_order, strict=True)
        if not group.is_constant
        and (variance <= zero).all()
        and (what := removal(group.name, whole.procedure))
    }
    names = [
        group.name
        for group, variance in zip(problem.groups, law.source_variance, strict=True)
        if not group.is_constant and (variance <= zero).all()
    ]
    owners = {group.name.owner for group in problem.groups if not group.is_constant}
    if ENVIRONMENT not in owners:
        names += [
            Name(line.name, owner=sensor.kind)
            for sensor in sensors
            for line in sensor.lines
            if line.u.any() and not source_of(sensor.kind, line.name).varies
        ]
    has = {line.name for sensor in sensors for line in sensor.lines if line.u.any()}
    names += [
        Name(line.name, owner=ENVIRONMENT)
        for line in whole.procedure.environment
        if line.u.any()
        and isinstance(known := source_of(ENVIRONMENT, line.name).effect, Coefficient)
        and has.isdisjoint(known.partners)
        and not (line.name == AGE and any(_says_of_age(one) for one in sensors))
    ]
    effects = [
        (name, source_of(name.owner, name.quantity).effect)
        for name in names
        if name not in removed
    ]
    return (
        *(
            Unfelt(source=name, removed=what, needs="")
            for name, what in removed.items()
        ),
        *(
            Unfelt(source=name, removed="", needs=described(effect.needs))
            for name, effect in effects
            if isinstance(effect, Disturbance | TurnOnChange | Coefficient)
        ),
    )


def _says_of_age(sensor: Sensor) -> bool:
    """Say whether a sensor holds over a time, or is a lower bound for want of it."""
    return any(time_of(line.horizon) for line in sensor.lines) or any(
        name.quantity in AGEING.values() for name in sensor.expected_missing
    )


def say_unfelt(found: Sequence[Unfelt]) -> tuple[str, ...]:
    """Warn of what reaches nothing; those that one thing removes together."""
    by_what: dict[str, list[Name]] = {}
    for one in found:
        if one.removed:
            by_what.setdefault(one.removed, []).append(one.source)
    return (
        *(
            sentence("cautions.removed", names=names, what=what)
            for what, names in by_what.items()
        ),
        *(
            sentence("cautions.unfelt", source=one.source, needs=one.needs)
            for one in found
            if one.needs
        ),
    )


def age_that_counts_not(procedure: Procedure, reference: str) -> tuple[str, ...]:
    """Warn of an age of the calibration that the error reference knows nothing of."""
    age = next((line for line in procedure.environment if line.name == AGE), None)
    if age is None or not age.u.any() or reference == "next_turn_on":
        return ()
    text = sentence("cautions.age_counts_not", age=age.printed, reference=reference)
    return (text,)


def shared_constants(
    sensors: Sequence[Sensor], procedure: Procedure, reference: str
) -> tuple[str, ...]:
    """Say which given lines count nothing because the reference shares their value.

    Those of a parameter that is held count, as its error is that of the design, and in
    use a nonlinearity without a full scale, which no calibration takes out.
    """
    if reference == "nominal":
        return ()
    held = {name.group for name in procedure.held}
    is_use = reference == "next_turn_on"
    return tuple(
        sentence(
            "cautions.shared",
            name=Name(line.name, owner=sensor.kind),
            reference=reference,
        )
        for sensor in sensors
        for line in sensor.lines
        for source in [source_of(sensor.kind, line.name).meant(line)]
        if source.own and source.stays == DEVICE
        if not (is_use and isinstance(source.effect, Nonlinearity))
        if Name(getattr(source.effect, "target", ""), owner=sensor.kind) not in held
    )


def left_behind(sensors: Sequence[Sensor], procedure: Procedure) -> tuple[str, ...]:
    """Say what is taken for granted of given lines that act during a mission too."""
    sampled = [
        Name(line.name, owner=sensor.kind)
        for sensor in sensors
        for line in sensor.lines
        if isinstance(
            source_of(sensor.kind, line.name).meant(line).effect,
            SampleNoise | Quantization,
        )
    ]
    said = []
    if sampled:
        rate = procedure.sample_rate
        said.append(sentence("cautions.samples", names=sampled, rate=rate))
    if names := of_test_alone(sensors):
        said.append(sentence("cautions.of_test_alone", names=names))
    if names := not_carried(sensors, procedure):
        said.append(sentence("cautions.not_carried", names=names))
    return tuple(said)


def saturated(question: Question) -> tuple[str, ...]:
    """Name the axes that the mission asks for more than they read; () of a test.

    Of what has limits the verdict says it.
    """
    mission = question.journey
    if mission is None or question.requirement is not None:
        return ()
    return tuple(one.said for one in saturations(question.sensors, mission))


# What no usual vehicle does, so that a wrong unit is likelier. Which one it is nobody
# says, so each bound is that of the vehicle that goes farthest, and ships, cars and
# airliners are well within.
# SR-71, 28 July 1976: 3529.56 km/h, 980 m/s, and 85,069 ft, 25,929 m, in level flight
# (mechanicshub.com/toolbox/fastest-plane); an F-15 coasted to 103,000 ft in a climb of
# minutes (afhistory.org/january-26-1975), about which a hint may be wrong.
MOST_SPEED = 1000.0  # [m/s]
MOST_HEIGHT = 26_000.0  # [m]
# Fighters turn at 9 g (boltflight.com, F-16 G-force limit), air races end at 12 g
# (matthallracing.com, G-inspection); above, for what is short: bumps, catapults.
MOST_ACCELERATION = 20.0 * STANDARD_GRAVITY  # [m/s^2]
# Race planes roll at 420 deg/s (airrace.redbull.com, What it takes), racing drones are
# set to 550 to 650 deg/s (prismnews.com, Betaflight); above, for those of freestyle.
MOST_TURN_RATE = radians(1000.0)  # [rad/s]
# Underwater gliders are slowest; ones of half their speed are proposed (Bruvik et al.
# 2020, Ocean Science 16, 291), so it is below half of a usual 0.25 m/s.
LEAST_SPEED, LEAST_LENGTH = 0.1, 10.0  # [m/s], [m]


def of_no_vehicle(mission: Mission | None) -> tuple[str, ...]:
    """Say where a route is none of a vehicle, and what in its recording is a slip.

    A hint changes no quantity: rockets and shells go faster. () without a mission.
    """
    if mission is None:
        return ()
    way = mission.route.outline
    bounds = (
        ("speed", way.speed, MOST_SPEED, 1.0),
        ("height", way.heights[1], MOST_HEIGHT, 1.0),
        ("acceleration", way.acceleration, MOST_ACCELERATION, STANDARD_GRAVITY),
        ("turn", way.turn_rate, MOST_TURN_RATE, radians(1.0)),
    )
    found = [
        *mission.doubts,
        *(
            sentence(
                "cautions.no_vehicle",
                slip=slip,
                size=size / unit,
                most=most / unit,
                time=way.hardest,
            )
            for slip, size, most, unit in bounds
            if size > most
        ),
    ]
    if way.length > LEAST_LENGTH and way.speed < LEAST_SPEED:
        found.append(sentence("cautions.slow", length=way.length, speed=way.speed))
    if way.longitude is not None and _in_radians(way.latitude, way.longitude):
        found.append(sentence("cautions.in_radians"))
    return tuple(found)


def _in_radians(latitude: Sequence[float], longitude: Sequence[float]) -> bool:
    """Say whether a place [rad] is so near 0 that its degrees may be radians."""
    # 0 itself is said where the place does not matter; all around it is sea.
    near = max(map(abs, latitude)) <= radians(pi / 2.0)
    near &= max(map(abs, longitude)) <= radians(pi)
    return near and all((*latitude, *longitude))


# Standard uncertainty of an attitude up to which first order holds, 5.7 deg [rad].
SMALL = 0.1


def beyond_first_order(problem: Problem, law: Propagation) -> tuple[str, ...]:
    """Warn of a mission whose attitude errors are too large for its equations."""
    found = [
        (u, output.name.time)
        for output, u in zip(problem.outputs, law.standard_uncertainty, strict=True)
        if output.name.quantity == "attitude" and u > SMALL
    ]
    if not found:
        return ()
    largest = max(u for u, _ in found)
    first = min(time or 0.0 for _, time in found)
    text = sentence("cautions.beyond_first_order", size=degrees(largest), time=first)
    return (text,)
