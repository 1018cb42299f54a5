"""Missions with aids: the filter of a unit, and how its errors grow with that."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.aiding import SAME, Cuts, aids_of, believing
from budget.calibration.mission import (
    FIRST,
    SEEN,
    Places,
    Sensing,
    columns_of,
    constants_problem,
    growth_of,
    mission_problem,
    noises_of,
)
from budget.calibration.problem import BIAS_UNITS
from budget.methods.gum import covariance_by_source, derivatives
from budget.names import AXES, components_of
from budget.navigation.aided import Aided, Belief, Filter
from budget.navigation.growth import Growth
from budget.results import BelievedError, Filtered, Learnt

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.names import Name
    from budget.problem import Problem
    from budget.spec.records import Mission, Procedure, Sensor
    from budget.studies.request import Analysis

AT_ONCE = 8  # times that are traced back together
BIAS = "bias"
KEPT = 4  # journeys that are remembered: each has arrays for all its steps


@lru_cache(maxsize=KEPT)
def journey_of(
    mission: Mission,
    times: tuple[float, ...],
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
) -> Growth | Aided:
    """Return how errors grow on a mission, at these times, with its filter if any.

    The filter is that of the whole unit, whichever of its sources are looked at.

    Raises
    ------
    CallError
        It believes something of a line that the unit does not have.
    """
    if not mission.is_filtered:
        return growth_of(mission, times)
    cuts = Cuts.of(mission, times)
    own = mission.filter
    believes = () if own is None else own.believes
    believed = believing(sensors, believes)
    constants = constants_problem(believed, procedure)
    U = covariance_by_source(constants, derivatives(constants)).sum(axis=0)
    names = [output.name for output in constants.outputs]
    kept = [
        place
        for place, name in enumerate(names)
        if own is None or own.estimates is None or name.group in own.estimates
    ]
    noises = noises_of(believed, sample_rate=procedure.sample_rate)
    start = np.array(mission.start)
    columns = columns_of(
        [names[place] for place in kept], tuple(map(Sensing.of, believed))
    )
    is_bias = [names[place].quantity == BIAS for place in kept]
    belief = Belief(
        covariance=U[np.ix_(kept, kept)],
        columns=columns,
        biases=columns(mission.route.first) * is_bias,
        noises=tuple(part for _, parts in noises for part in parts if part.u),
        aids=aids_of(mission, cuts, believes),
        start=start,
    )
    return Aided(
        filter=Filter(
            growth=growth_of(mission, cuts.times),
            belief=belief,
            kept=frozenset(cuts.asked),
        ),
        asked=cuts.asked,
        aids=aids_of(mission, cuts),
        start=start,
    )


def few_times(journey: Growth | Aided) -> Iterator[Growth | Aided]:
    """Yield journeys that ask for some of the times each, one after the other.

    Each traces its times back by itself, so that little is kept at once.
    """
    if isinstance(journey, Growth):
        yield journey
        return
    for first in range(0, len(journey.asked), AT_ONCE):
        yield replace(journey, asked=journey.asked[first : first + AT_ONCE])


def problem_of_mission(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    mission: Mission,
    outputs: Sequence[Name],
    *,
    only: frozenset[str] | None = None,
) -> Problem:
    """Set up a mission after a calibration, with its filter; see mission_problem."""
    return mission_problem(
        sensors,
        procedure,
        mission,
        outputs,
        only=only,
        journey=journey_of(mission, Places.of(outputs).times, sensors, procedure),
    )


def filtered(analysis: Analysis) -> Filtered | None:
    """Return what the filter of a mission has found out, and what it believes.

    None of a calibration, and of a unit that navigates by itself.
    """
    mission = analysis.journey
    if mission is None or not mission.aiding or analysis.outputs is None:
        return None
    times = Places.of(analysis.outputs).times
    journey = journey_of(mission, times, analysis.sensors, analysis.procedure)
    if isinstance(journey, Growth):
        return None
    return Filtered(
        kind="optimal" if mission.filter is None else "own",
        states=journey.filter.size,
        updates=journey.filter.updates,
        learnt=tuple(_learnt(analysis, journey, mission)),
        believed=tuple(_believed(analysis, journey)),
    )


def _learnt(analysis: Analysis, journey: Aided, mission: Mission) -> Iterator[Learnt]:
    """Yield what is left of the biases where aids end, and what was there before."""
    constants = constants_problem(analysis.sensors, analysis.procedure)
    U = covariance_by_source(constants, derivatives(constants)).sum(axis=0)
    names = [output.name for output in constants.outputs]
    columns = columns_of(names, tuple(map(Sensing.of, analysis.sensors)))
    growth = journey.filter.growth
    biases = columns(growth.first) * [name.quantity == BIAS for name in names]
    rate = analysis.procedure.sample_rate
    lines = noises_of(analysis.sensors, sample_rate=rate)
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
        u = np.sqrt([before, np.diag(C)])
        for kind, first in FIRST.items():
            unit, size = BIAS_UNITS[kind]
            for place, axis in enumerate(AXES):
                both = (u[:, first + place] / size).tolist()
                yield Learnt(
                    sensor=kind,
                    axis=axis,
                    time=float(t[end]),
                    before=both[0],
                    after=both[1],
                    unit=unit,
                )


def _ends(mission: Mission, t: Array) -> tuple[int, ...]:
    """Return the ends of the steps, at these times, at which each aid ends."""
    stops = {max(end for _, end in aid.spans) for aid in mission.aiding}
    found = np.searchsorted(t, np.array(sorted(stops)) * (1.0 + SAME), side="right") - 1
    return tuple(dict.fromkeys(found[found >= 0].tolist()))


def _believed(analysis: Analysis, journey: Aided) -> Iterator[BelievedError]:
    """Yield what the filter believes of what is asked for, beside what is true."""
    law = analysis.law
    times = Places.of(analysis.outputs or ()).times
    for output, true in zip(
        analysis.problem.outputs, law.standard_uncertainty.tolist(), strict=True
    ):
        name = output.name
        rows = [
            SEEN.index((one.quantity, one.axis))
            for one in (components_of(name) or (name,))
        ]
        C = journey.believed[times.index(name.time or 0.0)]
        yield BelievedError(
            parameter=name.quantity,
            axis=name.axis,
            time=name.time or 0.0,
            standard_uncertainty=float(np.sqrt(C[rows, rows].sum()))
            / output.si_per_unit,
            true=true / output.si_per_unit,
            unit=output.unit,
        )
