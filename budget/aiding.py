"""Missions with aids: how their errors grow under a Kalman filter."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.aiding import Cuts, aids_of, believing
from budget.calibration.mission import (
    SEEN,
    Places,
    Sensing,
    columns_of,
    constants_problem,
    growth_of,
    mission_problem,
    noises_of,
    on_the_way,
)
from budget.methods.gum import covariance_by_source, derivatives
from budget.names import Name, components_of
from budget.navigation.aided import Aided, Belief, KalmanFilter
from budget.navigation.growth import Growth
from budget.results import BelievedError
from budget.sentences import sentence

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Mission, Procedure, Sensor
    from budget.problem import Output, Problem

AT_ONCE = 8  # times that are traced back together
CONFIDENT = 0.8  # of what is true, below which a filter believes too much of itself
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
    believed, procedure = on_the_way(believing(sensors, believes), procedure)
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
        filter=KalmanFilter(
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
    designed: tuple[tuple[Sensor, ...], Procedure] | None = None,
) -> Problem:
    """Set up a mission after a calibration, with its filter; see mission_problem.

    `designed` has the triads and the procedure that the filter knows, where these are
    others: what they do not have it takes for 0.
    """
    known = designed or (sensors, procedure)
    return mission_problem(
        sensors,
        procedure,
        mission,
        outputs,
        only=only,
        journey=journey_of(mission, Places.of(outputs).times, *known),
    )


def believed(
    journey: Growth | Aided, outputs: Sequence[Output], u: Array
) -> Iterator[BelievedError]:
    """Yield what a filter believes of each output, beside what is true of it, u [SI].

    The journey asks for the times of these outputs; without a filter there is nothing.
    """
    if not isinstance(journey, Aided):
        return
    times = Places.of([output.name for output in outputs]).times
    for output, true in zip(outputs, u.tolist(), strict=True):
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
            # Below the rounding of what went in a variance may come out negative.
            standard_uncertainty=float(np.sqrt(max(C[rows, rows].sum(), 0.0)))
            / output.si_per_unit,
            true=true / output.si_per_unit,
            unit=output.unit,
        )


def overconfident(found: Iterable[BelievedError]) -> tuple[str, ...]:
    """Warn of a filter that believes in errors far smaller than they are."""
    off = [one for one in found if one.standard_uncertainty < CONFIDENT * one.true]
    if not off:
        return ()
    worst = min(off, key=lambda one: one.standard_uncertainty / one.true)
    what = Name(worst.parameter, axis=worst.axis)
    return (sentence("cautions.filter_too_sure", error=worst, what=what),)
