"""States of the Kalman filter of a mission: sensor errors and believed covariance."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from budget.aiding import BIAS, believed, journey_of, overconfident
from budget.calibration.aiding import SAME
from budget.calibration.mission import (
    FIRST,
    Places,
    Sensing,
    columns_of,
    constants_problem,
    noises_of,
    on_the_way,
)
from budget.calibration.problem import BIAS_UNITS
from budget.methods.gum import covariance_by_source, derivatives
from budget.names import AXES
from budget.navigation.aided import Aided
from budget.navigation.route import Leg, Legs
from budget.results import Filtered, Learnt, Turned
from budget.studies.mission import curve

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.arrays import Array
    from budget.inputs.records import Mission, Requirement
    from budget.question import Question

DECIMALS = 9  # of a time in s, which is the sum of steps


def filtered(question: Question) -> Filtered | None:
    """Return what the filter of a mission has found out, and what it believes.

    None of a calibration, and of a unit that navigates by itself.
    """
    mission = question.journey
    if mission is None or not mission.aiding or question.outputs is None:
        return None
    times = Places.of(question.outputs).times
    journey = journey_of(mission, times, question.sensors, question.procedure)
    if not isinstance(journey, Aided):
        return None
    return Filtered(
        kind="optimal" if mission.filter is None else "own",
        states=journey.filter.size,
        updates=journey.filter.updates,
        learnt=tuple(_learnt(question, journey, mission)),
        believed=tuple(
            believed(
                journey, question.problem.outputs, question.law.standard_uncertainty
            )
        ),
        turned=_turned(question, mission),
    )


def too_sure(
    found: Filtered | None, requirement: Requirement | None
) -> tuple[str, ...]:
    """Warn of a filter that is too sure; beside a verdict it is a caution."""
    if found is None or requirement is not None:
        return ()
    return overconfident(found.believed)


def _learnt(question: Question, journey: Aided, mission: Mission) -> Iterator[Learnt]:
    """Yield what is left of the biases where aids end, and what was there before."""
    sensors, procedure = on_the_way(question.sensors, question.procedure)
    constants = constants_problem(sensors, procedure)
    U = covariance_by_source(constants, derivatives(constants)).sum(axis=0)
    names = [output.name for output in constants.outputs]
    columns = columns_of(names, tuple(map(Sensing.of, sensors)))
    growth = journey.filter.growth
    biases = columns(growth.first) * [name.quantity == BIAS for name in names]
    rate = question.procedure.sample_rate
    lines = noises_of(question.sensors, sample_rate=rate)
    noises = [part for _, parts in lines for part in parts if part.u]
    t = np.cumsum(growth.steps.durations)[list(growth.steps.asked)]
    for end in _ends(mission, t):
        sweep = journey.of_inputs(end)
        S = sweep.of_constants(columns) + biases
        C = S @ U @ S.T + sweep.of_noise(noises)
        parts = (*sweep.of_aids(journey.aids), *sweep.of_start(journey.start))
        C = C + sum(one for _, one in parts)
        before = np.diag(biases @ U @ biases.T).copy()
        for part in noises:
            over = part.noise.over(t[end : end + 1])
            states = over.fade[0] ** 2 * part.noise.begins + over.end[0]
            before[part.row] += part.u**2 * states.sum()
        u = np.sqrt(np.maximum([before, np.diag(C)], 0.0))
        for kind, first in FIRST.items():
            unit, size = BIAS_UNITS[kind]
            for place, axis in enumerate(AXES):
                both = (u[:, first + place] / size).tolist()
                yield Learnt(
                    sensor=kind,
                    axis=axis,
                    time=round(float(t[end]), DECIMALS),
                    before=both[0],
                    after=both[1],
                    unit=unit,
                )


def _ends(mission: Mission, t: Array) -> tuple[int, ...]:
    """Return the ends of the steps, at these times, at which each aid ends."""
    stops = {max(end for _, end in aid.spans) for aid in mission.aiding}
    found = np.searchsorted(t, np.array(sorted(stops)) * (1.0 + SAME), side="right") - 1
    return tuple(dict.fromkeys(found[found >= 0].tolist()))


def _turned(question: Question, mission: Mission) -> Turned | None:
    """Return how far off it ends, and had it turned by 180 deg where the aids end.

    None of one that does not go straight on from there. What a filter cannot tell apart
    straight on cancels until the unit turns: a level bias, and the tilt with it.
    """
    route, begin = mission.route, mission.measured[-1][1]
    if not isinstance(route, Legs) or begin * (1.0 + SAME) >= route.duration:
        return None
    ends = np.cumsum([leg.duration for leg in route.legs])
    first = int(np.searchsorted(ends, begin * (1.0 + SAME), side="right"))
    half = (route.duration - begin) / 2.0
    if {replace(leg, duration=half) for leg in route.legs[first:]} != {
        Leg(duration=half)
    }:
        return None
    back = (
        *route.legs[:first],
        Leg(duration=half, turn_rate=np.pi / half),
        Leg(duration=half),
    )
    straight, turned = (
        _ends_off(replace(question, mission=one), one, route.duration)
        for one in (mission, replace(mission, route=replace(route, legs=back)))
    )
    return Turned(time=route.duration, straight=straight, turned=turned)


def _ends_off(question: Question, mission: Mission, end: float) -> float:
    """Return the root of the variances north and east at the end of a mission [m].

    Of a filter that believes what is true it is what that believes: no source is
    traced back.
    """
    if mission.filter is not None:
        return float(curve(replace(question, carried_to=(end,)), (end,)).drms()[-1])
    asked = Places.of(question.outputs or ()).times
    times = asked if asked[-1:] == (end,) else (end,)  # with a filter that there is
    journey = journey_of(mission, times, question.sensors, question.procedure)
    C = journey.believed[-1] if isinstance(journey, Aided) else np.zeros((2, 2))
    return float(np.sqrt(C[0, 0] + C[1, 1]))
