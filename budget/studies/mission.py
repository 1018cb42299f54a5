"""Growth of the errors of a mission over time, and which source makes them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.aiding import BIAS, believed, few_times, journey_of, overconfident
from budget.calibration.aiding import SAME, lines_of_mission
from budget.calibration.mission import (
    FIRST,
    SEEN,
    Places,
    Sensing,
    columns_of,
    constants_problem,
    map_of,
    noise_in_run,
    noises_of,
    of_aiding,
    on_the_way,
)
from budget.calibration.problem import BIAS_UNITS
from budget.documents import Shown
from budget.errors import CallError
from budget.inputs import without_test
from budget.inputs.records import FACTORY, UNCALIBRATED
from budget.known import Known
from budget.methods.gum import covariance_by_source, derivatives
from budget.methods.radius import principal_variances, radius_of
from budget.names import AIDING, ALIGNMENT, AXES, HORIZONTAL, LENGTHS, MISSION, Name
from budget.navigation.aided import Aided
from budget.navigation.route import Leg, Legs
from budget.question import question_of, seconds
from budget.results import CEP, INTERACTION, R95, Calibrated, Filtered, Learnt, Turned
from budget.studies.doubt import ONE_SIGMA, Mixture
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    import pandas as pd
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Mission, Requirement
    from budget.question import Question
    from budget.results import Budget

PLANE = LENGTHS["position"]
POINTS = 100  # of a curve, where nobody asks for more
DRAWN = 32  # of a figure
WORSE = 1.01  # CEP over that of another calibration that is worth a word [1]
LEAST_SPAN, MOST_SPAN = 100.0, 1000.0  # of its axis, end over start [1]


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Curve(Shown):
    """Errors of a mission at many times, by source.

    Attributes
    ----------
    times : tuple of float
        [s], rising.
    sources : tuple of Name
        The lines, then products of two: `interaction`.
    covariance : ndarray, shape (n_sources, n_times, 9, 9)
        Of position, velocity, attitude at one time, in the order of SEEN [SI squared];
        of lines that are predicted at their medians.
    mixture : Mixture or None
        What those may be: radii and standard uncertainties are over that.
    measured : tuple of (float, float)
        Begins and ends of when any aid is there [s].
    lower_bounds : frozenset of (str, str)
        Quantities and axes of errors that are this or more: a specification lacks.
    """

    times: tuple[float, ...]
    sources: tuple[Name, ...]
    covariance: Array
    mixture: Mixture | None = None
    measured: tuple[tuple[float, float], ...] = ()
    lower_bounds: frozenset[tuple[str, str]] = frozenset()

    def standard_uncertainty(self, quantity: str, axis: str) -> Array:
        """Return that of one error at all times, shape (n_times,) [SI]."""
        if self.mixture is None:
            return np.asarray(np.sqrt(self.variance(quantity, axis).sum(axis=0)))
        return self.reach(ONE_SIGMA, quantity, axis)

    def variance(self, quantity: str, axis: str) -> Array:
        """Return what each source adds to that of one error, (n_sources, n_times) [SI].

        Of the horizontal one to DRMS squared. Of lines that are predicted at their
        medians.
        """
        if LENGTHS.get(quantity) == axis:
            return self.horizontal_variance(quantity)
        row = SEEN.index((quantity, axis))
        return np.asarray(self.covariance[:, :, row, row])

    def reach(self, coverage: float, quantity: str, axis: str) -> Array:
        """Return what one error is below with a coverage, shape (n_times,) [SI].

        Of the horizontal one the radius of its circle.
        """
        if LENGTHS.get(quantity) == axis:
            return self.radius(coverage, quantity)
        own = self.variance(quantity, axis)
        return self._reach(coverage, np.stack([own, 0.0 * own, 0.0 * own], axis=1))

    def drms(self, quantity: str = "position") -> Array:
        """Return the root of the sum of squared u north and east, (n_times,) [SI]."""
        u = [self.standard_uncertainty(quantity, axis) for axis in HORIZONTAL]
        return np.asarray(np.hypot(*u))

    def horizontal_variance(self, quantity: str = "position") -> Array:
        """Return what each source adds to DRMS squared, (n_sources, n_times) [SI].

        Of lines that are predicted at their medians.
        """
        rows = _plane(quantity)
        return np.asarray(self.covariance[..., rows, rows].sum(axis=-1))

    def radius(self, coverage: float, quantity: str = "position") -> Array:
        """Return the radii of circles of a coverage, shape (n_times,) [SI]."""
        a, b = _plane(quantity)
        C = self.covariance
        each = np.stack([C[..., a, a], C[..., b, b], C[..., a, b]], axis=1)
        return self._reach(coverage, each)

    def _reach(self, coverage: float, each: Array) -> Array:
        """Return radii of two variances and a covariance by source, (n_times,) [SI].

        `each` has the shape (n_sources, 3, n_times).
        """
        if self.mixture is not None:
            return self.mixture.radius(coverage, self.sources, each)
        return radius_of(coverage, principal_variances(*each.sum(axis=0)))

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table, a row for each time, with units in its heads.

        CEP, R95 and DRMS of position, DRMS of velocity, what makes most of position.
        """
        import pandas as pd

        return pd.DataFrame(
            {
                "time [s]": self.times,
                "cep [m]": self.radius(CEP),
                "r95 [m]": self.radius(R95),
                "drms [m]": self.drms(),
                "velocity_drms [m/s]": self.drms("velocity"),
                "dominant": self.dominant,
            }
        )

    @property
    def dominant(self) -> tuple[Name, ...]:
        """Return the source that makes most of the horizontal position each time."""
        parts = self.horizontal_variance().T.tolist()
        return tuple(self.sources[first_largest(one)] for one in parts)


def _plane(quantity: str) -> NDArray[np.intp]:
    """Return the rows of the two horizontal errors of a quantity in SEEN."""
    return np.array([SEEN.index((quantity, axis)) for axis in HORIZONTAL])


def growth(budget: Budget, times: Iterable[float | str] | None = None) -> Curve:
    """Return how the errors of a mission grow, of what `analyze` says of it.

    Parameters
    ----------
    budget : Budget
        Of a mission.
    times : iterable of float or str, optional
        [s], or as '10 min'; above 0, to its end; 100 of them evenly without it.

    Raises
    ------
    CallError
        It is of no mission, or that ends before one of the times, or they are none.
    """
    question = question_of(budget)
    if times is None or question.journey is None:
        return curve(question)
    found = tuple(sorted(map(seconds, times)))
    last = question.journey.route.duration
    if not found or not (found[0] > 0.0 and found[-1] <= last):
        raise CallError(f"times are {found}, expected some above 0 s and to {last:g} s")
    return curve(question, found)


def curve(question: Question, times: Sequence[float] | None = None) -> Curve:
    """Carry the law of a calibration along a mission, exactly, without its Problem.

    The map is linear: at each time S U S^T of every source's covariance U, and what its
    noise in run adds. So at the times of a Problem it is the law of that.

    Parameters
    ----------
    question : Question
        Of a mission.
    times : sequence of float, optional
        [s], rising, above 0, to its end; POINTS of them evenly without it.

    Raises
    ------
    CallError
        It is of no mission.
    """
    mission = question.journey
    if mission is None:
        raise CallError("this is of a calibration alone; give a mission")
    if times is None:
        times = np.linspace(0.0, mission.route.duration, POINTS + 1)[1:].tolist()
    whole = journey_of(mission, tuple(times), question.sensors, question.procedure)
    sensors, procedure = on_the_way(question.sensors, question.procedure)
    constants = constants_problem(sensors, procedure, only=question.only)
    each = covariance_by_source(constants, derivatives(constants))
    lines = (
        *(group.name for group in constants.groups),
        *lines_of_mission(mission),
        INTERACTION,
    )
    found = []
    for journey in few_times(whole):
        S = map_of(journey, constants, sensors)
        made = S @ each[:, None] @ S.swapaxes(1, 2)
        more = len(lines) - len(each)
        C = np.insert(made, [len(each) - 1] * more, 0.0, axis=0)
        here = np.arange(len(S))
        parts = dict(of_aiding(journey, only=question.only))
        parts |= noise_in_run(
            question.sensors,
            journey,
            sample_rate=question.procedure.sample_rate,
            only=question.only,
        )
        for name, one in parts.items():
            C[lines.index(name)] += one[here, :, here]
        found.append(C)
    return Curve(
        times=tuple(times),
        sources=lines,
        covariance=np.concatenate(found, axis=1),
        mixture=Mixture.of(question),
        measured=mission.measured,
        lower_bounds=frozenset(
            (name.quantity, name.axis)
            for name, lacks in question.lacks.items()
            if lacks
        ),
    )


def drawn_times(mission: Mission, asked: Sequence[float]) -> tuple[float, ...]:
    """Return times that show the growth of errors [s].

    On a logarithmic axis, from the first that is asked for to the end of the mission,
    over two decades at the least and three at the most. On an even one with aids: from
    as long before they first end as the mission goes on after that; all of it where
    nothing goes on. Those that are asked for and lie there among them.
    """
    duration = mission.route.duration
    if mission.measured:
        end = mission.measured[0][1]
        goes_on = end * (1.0 + SAME) < duration
        first = max(2.0 * end - duration, 0.0) if goes_on else 0.0
        even = np.linspace(first, duration, DRAWN + 1)[1:-1].tolist()
        edges = (time for span in mission.measured for time in span)
        own = (time for time in (*asked, *edges) if first < time < duration)
        return tuple(sorted({*even, *own, duration}))
    first = max(min(*asked, duration / LEAST_SPAN), duration / MOST_SPAN)
    even = np.geomspace(first, duration, DRAWN)[:-1].tolist()
    own = (time for time in asked if first <= time < duration)
    return tuple(sorted({*even, *own, duration}))


def bought(question: Question, budget: Budget | None = None) -> tuple[Calibrated, ...]:
    """Return how far off a unit is after no calibration, its maker's, and this one.

    CEP at the times that the mission is looked at; each by the law. Of a test that
    leaves more at the end than the maker's calibration: which line adds most to it.
    `budget`, where there is one, says what of this one is a lower bound.
    """
    times = question.carried_to or ()
    if not times:
        return ()
    own = question.procedure
    tests = {word: without_test(own, word) for word in UNCALIBRATED}
    tests[own.formulas if own.formulas in tests else ""] = own
    found: list[Calibrated] = []
    parts: list[dict[Name, float]] = []  # of the variance at the end, by source
    for procedure in tests.values():
        one = replace(question, procedure=procedure, requirement=None)
        grown = curve(one, times)
        last = grown.horizontal_variance()[:, -1].tolist()
        parts.append(dict(zip(grown.sources, last, strict=True)))
        why = tuple(
            line
            for time in times
            for name in [Name("position", owner=MISSION, axis=PLANE, time=time)]
            for line in (
                budget.output(name).standard_uncertainty.why
                if budget is not None and procedure is own
                else one.lacks[name]
            )
        )
        cep = tuple(Known.of(size, why) for size in grown.radius(CEP).tolist())
        found.append(Calibrated(name=procedure.name, cep=cep))
    place = UNCALIBRATED.index(FACTORY)
    maker, last_one = found[place], found[-1]
    if last_one.cep[-1] <= WORSE * maker.cep[-1]:
        return tuple(found)
    more = {
        name: variance - parts[place].get(name, 0.0)
        for name, variance in parts[-1].items()
        if name != INTERACTION and name.owner not in {AIDING, ALIGNMENT}
    }
    because = [*more][first_largest([*more.values()])]
    return (*found[:-1], replace(last_one, worse_than=maker.name, because=because))


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
    lines = noises_of(question.sensors, sample_rate=question.procedure.sample_rate)
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


__all__ = ["POINTS", "Curve", "bought", "curve", "drawn_times", "growth"]
