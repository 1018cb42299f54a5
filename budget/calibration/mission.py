"""A mission as one Problem: errors after calibration, carried along a route.

The errors of the parameters at a later turn-on are constants of the mission, and so is
what a unit adds to its readings by itself: g-sensitivity, the shape of its scale
factor. A triad M = I + T that senses v has the inputs x = M v + b, and is wrong by
M^-1 (dk x + dT v + db + dK2 x^2 + dK3 x^3 - a), a what it adds at that x. The test has
put a part of a into k, T and b, so that at the test's own inputs little is left of it.
Noise in run is drawn anew after that turn-on, independent of the noise of the test;
both are of one line and stand in one group. Together they make errors of position,
velocity and attitude by a map that is linear: the mission is the calibration's Problem
with one more map behind it, and what a method says of one it says of the other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import estimated
from budget.distributions import NORMAL
from budget.model.response import COLUMN, ROW, SIGN, diagonal, tilt_matrix
from budget.model.source import ACCELEROMETER, GYRO, Disturbance, Noise
from budget.model.sources import ENVIRONMENT, source_of
from budget.model.sources.later import (
    MISSION_TEMPERATURE,
    MISSION_VIBRATION,
    RECTIFICATION,
    VibrationRectification,
)
from budget.model.sources.temperature import (
    COEFFICIENTS,
    ON_THE_WAY,
    RATE_COEFFICIENT,
    History,
    OnTheWay,
    Soaks,
    TemperatureChange,
    TemperatureCoefficient,
)
from budget.names import (
    AIDING,
    ALIGNMENT,
    ANGLES,
    AXES,
    LENGTHS,
    MISSION,
    ORDERS,
    PLACES,
    Name,
    components_of,
)
from budget.navigation import growth
from budget.navigation.growth import AxisNoise, Growth, Markov
from budget.problem import Group, Output, Problem, arguments
from budget.units import ARCSEC

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import ErrorLine, Mission, Procedure, Sensor
    from budget.model.course import Course
    from budget.navigation.aided import Aided
    from budget.navigation.dynamics import Moment

REFERENCE = "next_turn_on"  # a mission begins with a turn-on of its own
FIRST = {GYRO: 0, ACCELEROMETER: len(AXES)}  # row of x among the six inputs
# What navigation makes of a process, from its times [s].
IN_RUN: Mapping[str, Callable[..., growth.UnitNoise]] = {
    "white": growth.UnitWhiteNoise,
    "walk": growth.UnitRandomWalk,
    "markov": lambda *times: Markov(times=times),
    "rounding": growth.Rounding,
}
UNITS = {"position": ("m", 1.0), "velocity": ("m/s", 1.0)}
ANGLE = ("arcsec", ARCSEC)
# A spread at or below this is rounding: of 1 m, of 1 m/s, of 1 rad.
ROUNDING = {"position": 1e-9, "velocity": 1e-12, "attitude": 1e-15}
DOWN = "down"
LOST = 1e-13  # of a sum over the steps, by rounding [1]
DOUBTED = 1e-6  # from which error on a correlation is not worth keeping [1]
# What navigators are asked for, in the order of Moment.seen.
SEEN = tuple((quantity, axis) for quantity, axes in PLACES.items() for axis in axes)


def mission_outputs(mission: Mission, times: Iterable[float]) -> tuple[Name, ...]:
    """Return all that can be asked of a mission at these times, lengths last.

    Nothing of height and vertical velocity where the altitude is aided.
    """
    asked = tuple(times)
    single = [
        Name(quantity, owner=MISSION, axis=axis, time=time)
        for time in asked
        for quantity, axis in SEEN
        if not (mission.aided and axis == DOWN)
    ]
    lengths = [
        Name(quantity, owner=MISSION, axis=axis, time=time)
        for time in asked
        for quantity, axis in LENGTHS.items()
    ]
    return (*single, *lengths)


@lru_cache(maxsize=64)  # a comparison asks for one again with every device
def growth_of(mission: Mission, times: tuple[float, ...]) -> Growth:
    """Return how errors grow on a mission, at these times."""
    courses = (line.course for line in mission.use)
    cuts = {cut for one in courses if one is not None for cut in one.cuts}
    return Growth(
        first=mission.route.first,
        alignment=mission.alignment,
        steps=mission.route.steps(times, sorted(cuts)),
        aided=mission.aided,
    )


def mission_problem(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    mission: Mission,
    outputs: Sequence[Name],
    *,
    only: frozenset[str] | None = None,
    journey: Growth | Aided | None = None,
) -> Problem:
    """Set up a mission after a calibration.

    Parameters
    ----------
    sensors : tuple of Sensor
        A gyro and an accelerometer.
    procedure : Procedure
        That they are calibrated by.
    mission : Mission
    outputs : sequence of Name
        What is asked for, of mission_outputs; components of what is a length are added.
    only : frozenset of str, optional
        Full names of the sources that count; all others are set to 0.
    journey : Growth or Aided, optional
        How errors grow to the times of the outputs; by themselves without it.

    Returns
    -------
    Problem
        The sources of the calibration as groups, those of noise with what it does in
        run, and those of the aids; errors at each time as outputs [m, m/s, rad].
    """
    sensors, procedure = on_the_way(sensors, procedure)
    calibration = constants_problem(sensors, procedure, only=only)
    places = Places.of(outputs)
    journey = journey or growth_of(mission, places.times)
    S = map_of(journey, calibration, sensors)
    noise = dict(
        noise_in_run(sensors, journey, sample_rate=procedure.sample_rate, only=only)
    )
    m = len(places.names)
    pools = {one.pool for one in calibration.groups if one.name in noise}
    groups = tuple(
        _carried_on(one, places.pick(noise[one.name]) if one.name in noise else None, m)
        if one.pool in pools
        else one
        for one in calibration.groups
    )
    own, added = _rows(calibration.groups, groups, pools)
    aids = tuple(
        Group(
            name=name,
            mean=np.zeros(m),
            covariance=places.pick(C),
            distributions=(NORMAL,) * m,
        )
        for name, C in of_aiding(journey, only=only)
    )
    return Problem(
        groups=(*groups, *aids),
        outputs=tuple(_output(name) for name in places.every),
        function=Carried(
            calibration=calibration,
            own=own,
            noise=(*added, *arguments((*groups, *aids))[len(groups) :]),
            map=S[places.time, places.row],
        ),
    )


def constants_problem(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    only: frozenset[str] | None = None,
) -> Problem:
    """Return what stays constant during a mission, as outputs of the calibration.

    Errors of all parameters of both triads, those that are held too; after them the
    coefficients of what a unit adds to its readings by itself. One that the calibration
    estimates is among the first. So are those by which a temperature or a vibration
    acts that is known on the way.
    """
    sensors, procedure = on_the_way(sensors, procedure)
    calibration = calibration_problem(
        sensors, procedure, reference=REFERENCE, only=only, every=True
    )
    places = {
        group.name: rows
        for group, rows in zip(
            calibration.groups, arguments(calibration.groups), strict=True
        )
    }
    more: list[Output] = []
    rows: list[int] = []
    for sensor in sensors:
        found = {ORDERS.get(x.quantity, 0) for x in estimated(sensor.kind, procedure)}
        for line in _added(sensor):
            source = source_of(sensor.kind, line.name).meant(line)
            if getattr(source.effect, "order", 0) in found - {0}:
                continue
            name = Name(line.name, owner=sensor.kind)
            rows += range(places[name].start, places[name].stop)
            more += (
                Output(
                    name=Name(line.name, owner=sensor.kind, axis=axis),
                    unit=line.unit,
                    si_per_unit=line.si_per_unit,
                )
                for axis in source.axes
            )
    return replace(
        calibration,
        outputs=(*calibration.outputs, *more),
        function=Constants(calibration=calibration, rows=np.array(rows, dtype=np.intp)),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Constants:
    """Errors of parameters, then inputs as they are.

    Attributes
    ----------
    calibration : Problem
    rows : ndarray, shape (n,)
        Of its argument.
    """

    calibration: Problem
    rows: NDArray[np.intp]

    def __call__(self, argument: Array) -> Array:
        """Return both, shape (n_constants, trials) [SI]."""
        errors = self.calibration.evaluate_argument(argument)
        return np.concatenate([errors, argument[self.rows]])


def _added(sensor: Sensor) -> tuple[ErrorLine, ...]:
    """Return the lines of what a triad adds to its readings by itself, in use too."""
    return tuple(
        line
        for line in sensor.lines
        for effect in [source_of(sensor.kind, line.name).meant(line).effect]
        if line.u.any()
        and (
            line.course is not None
            or (
                isinstance(effect, Disturbance)
                and effect.in_use(np.zeros(3), np.zeros(3)) is not None
            )
        )
    )


def on_the_way(
    sensors: tuple[Sensor, ...], procedure: Procedure
) -> tuple[tuple[Sensor, ...], Procedure]:
    """Return what a temperature and a vibration act by that are known on the way.

    Lines of the triads have the course of it, and coefficients of temperature are
    constants of 1 sigma each; at the turn-on before nothing is left of it.
    """
    there = {x.name: x.course for x in procedure.environment if x.course is not None}
    if not there:
        return sensors, procedure
    courses = {
        **dict.fromkeys(COEFFICIENTS, there.get(MISSION_TEMPERATURE)),
        RECTIFICATION: there.get(MISSION_VIBRATION),
    }

    def felt(sensor: Sensor) -> Sensor:
        lines = (
            line
            if courses.get(line.name) is None
            else replace(
                line,
                u=abs(line.u),
                form=ON_THE_WAY if line.name in COEFFICIENTS else line.form,
                course=courses[line.name],
            )
            for line in sensor.lines
        )
        beside = sensor.beside
        return replace(sensor, lines=tuple(lines), beside=beside and felt(beside))

    use = (
        replace(line, u=0.0 * line.u) if line.name in there else line
        for line in procedure.environment
    )
    return tuple(map(felt, sensors)), replace(procedure, environment=tuple(use))


@dataclass(frozen=True, kw_only=True, eq=False)
class Places:
    """Which outputs of a mission are asked for: times, and rows of Moment.seen."""

    names: tuple[Name, ...]  # those that are no lengths
    lengths: tuple[Name, ...]
    times: tuple[float, ...]  # rising [s]
    # Of each name its place among the times, and its row, shape (n,).
    time: NDArray[np.intp]
    row: NDArray[np.intp]

    @classmethod
    def of(cls, outputs: Sequence[Name]) -> Places:
        """Sort names, and add the components of lengths."""
        lengths = tuple(name for name in outputs if components_of(name))
        parts = (part for name in lengths for part in components_of(name))
        single = (name for name in outputs if not components_of(name))
        names = tuple(dict.fromkeys((*single, *parts)))
        times = tuple(sorted({name.time or 0.0 for name in names}))
        return cls(
            names=names,
            lengths=lengths,
            times=times,
            time=np.array([times.index(name.time or 0.0) for name in names]),
            row=np.array([SEEN.index((one.quantity, one.axis)) for one in names]),
        )

    @property
    def every(self) -> tuple[Name, ...]:
        """The outputs of the Problem: components that lengths need are among them."""
        return (*self.names, *self.lengths)

    def pick(self, C: Array) -> Array:
        """Return the covariance (n, n) of the names out of (times, 9, times, 9)."""
        size = len(self.times) * len(SEEN)
        C = C.reshape(size, size)
        place = self.time * len(SEEN) + self.row
        u = np.sqrt(np.maximum(np.diag(C), 0.0))
        largest = u.reshape(-1, len(AXES)).max(axis=1).repeat(len(AXES))
        return _settled(C[np.ix_(place, place)], largest[place])


@dataclass(frozen=True, kw_only=True, eq=False)
class Carried:
    """Errors of a mission as a function of all inputs.

    Attributes
    ----------
    calibration : Problem
    own : ndarray, shape (n_arguments,)
        Rows of the argument that are those of the calibration.
    noise : tuple of slice
        Rows that are errors by noise in run, of all outputs.
    map : ndarray, shape (n_out, n_parameters)
        What each parameter's error becomes.
    """

    calibration: Problem
    own: NDArray[np.intp]
    noise: tuple[slice, ...]
    map: Array

    def __call__(self, argument: Array) -> Array:
        """Return the errors that are no lengths, shape (n_out, trials) [SI]."""
        found = self.map @ self.calibration.evaluate_argument(argument[self.own])
        for rows in self.noise:
            found = found + argument[rows]
        return np.asarray(found)


def _settled(C: Array, largest: Array) -> Array:
    """Return a covariance without what rounding has left in it, shape (n, n).

    Sums over steps are rounded by a part of the largest error of the same kind at the
    same time. An error far below that, as of the heading at the equator, has a size
    that nobody notices and correlations that mean nothing: they are dropped. Of the
    others the nearest are taken that a covariance can have.
    """
    u = np.sqrt(np.maximum(np.diag(C), 0.0))
    varies = u > 0.0
    size = np.where(varies, u, 1.0)
    R = 0.5 * (C + C.T) / np.outer(size, size)
    lost = LOST * np.outer(largest / size, largest / size) > DOUBTED
    lost |= ~np.outer(varies, varies)
    np.fill_diagonal(lost, val=False)
    R[lost] = 0.0
    np.fill_diagonal(R, varies)
    values, vectors = np.linalg.eigh(R)
    if values.min(initial=0.0) < -LOST * len(R):
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        root /= np.where(varies, np.linalg.norm(root, axis=1), 1.0)[:, None]
        R = root @ root.T
    elif not lost.any():
        return 0.5 * (C + C.T)
    return np.asarray(R * np.outer(u, u))


def _carried_on(group: Group, in_run: Array | None, m: int) -> Group:
    """Return the group of a noise line with what it does to m outputs in run."""
    n = group.size + m
    covariance = np.zeros((n, n))
    covariance[: group.size, : group.size] = group.covariance
    if in_run is not None:
        covariance[group.size :, group.size :] = in_run
    added = tuple(range(group.size, n))
    scales = group.scales
    if len(scales) == 1:
        scales = (replace(scales[0], rows=(*scales[0].rows, *added)),)
    elif scales:  # in run its axes are one error: as sure as the least sure of them
        least = min(scales, key=lambda one: one.degrees_of_freedom)
        scales = (*scales, replace(least, rows=added))
    return replace(
        group,
        mean=np.zeros(n),
        covariance=covariance,
        distributions=(NORMAL,) * n,
        scales=scales,
    )


def _rows(
    before: tuple[Group, ...], after: tuple[Group, ...], pools: set[str]
) -> tuple[NDArray[np.intp], tuple[slice, ...]]:
    """Return which rows of the argument are the calibration's, and those of noise."""
    olds, news = arguments(before), arguments(after)
    own = np.empty(max((old.stop for old in olds), default=0), dtype=np.intp)
    noise: dict[str, slice] = {}
    for group, old, new in zip(before, olds, news, strict=True):
        end = new.start + old.stop - old.start
        own[old] = np.arange(new.start, end)
        if group.pool in pools:
            noise[group.pool] = slice(end, new.stop)
    return own, tuple(noise.values())


def _output(name: Name) -> Output:
    """Return an output with its unit and the size of its rounding."""
    unit, size = UNITS.get(name.quantity, ANGLE)
    return Output(
        name=name,
        unit=unit,
        si_per_unit=size,
        resolution=ROUNDING[name.quantity],
        length_of=components_of(name),
    )


def of_aiding(
    journey: Growth | Aided, *, only: frozenset[str] | None = None
) -> Iterator[tuple[Name, Array]]:
    """Yield what aids and alignment leave, as noise_in_run; 0 of what does not count.

    Nothing of a unit that navigates by itself.
    """
    if isinstance(journey, Growth):
        return
    for owner, parts in (
        (AIDING, journey.of_aids()),
        (ALIGNMENT, journey.of_start()),
    ):
        for key, C in parts:
            name = Name(key, owner=owner)
            yield name, C if only is None or name in only else np.zeros_like(C)


def map_of(
    journey: Growth | Aided, constants: Problem, sensors: Sequence[Sensor]
) -> Array:
    """Return what constants become on the way, shape (times, 9, n_constants) [SI]."""
    names = tuple(output.name for output in constants.outputs)
    triads = tuple(map(Sensing.of, sensors))
    if isinstance(journey, Growth):
        return _of_constants(journey, names, triads)
    return journey.of_constants(columns_of(names, triads))


@lru_cache(maxsize=64)
def _of_constants(
    journey: Growth, names: tuple[Name, ...], triads: tuple[Sensing, ...]
) -> Array:
    """Return what constants of triads make, shape (times, 9, n) [SI]."""
    return journey.of_constants(columns_of(names, triads))


def columns_of(
    names: Sequence[Name], triads: Sequence[Sensing]
) -> Callable[[Moment], Array]:
    """Return what says of moments which inputs constants of 1 are, (..., 6, n)."""
    places = [
        [place for place, name in enumerate(names) if name.owner == triad.kind]
        for triad in triads
    ]

    def columns(moment: Moment) -> Array:
        found = np.zeros((*moment.latitude.shape, 2 * len(AXES), len(names)))
        there = ((triad, own) for triad, own in zip(triads, places, strict=True) if own)
        for triad, own in there:
            first = FIRST[triad.kind]
            found[..., first : first + len(AXES), own] = triad.columns(
                [names[place] for place in own],
                moment.rate,
                moment.force,
                moment.time,
            )
        return found

    return columns


@dataclass(frozen=True, kw_only=True)
class Sensing:
    """What a triad is meant to sense, and what it adds to that by itself."""

    kind: str
    bias: tuple[float, ...]  # nominal [unit of the input]
    angle: tuple[float, ...]  # nominal [rad]
    effects: tuple[tuple[str, Disturbance], ...]  # by the line
    courses: tuple[tuple[str, OnTheWay | VibrationRectification, Course], ...] = ()

    @classmethod
    def of(cls, sensor: Sensor) -> Sensing:
        """Read it off a sensor; what says nothing of sizes is the same for many."""
        kind = sensor.kind
        effects = tuple(
            (one.name, source_of(kind, one.name).meant(one).effect, one.course)
            for one in _added(sensor)
        )
        return cls(
            kind=kind,
            bias=tuple(sensor.nominal_bias.tolist()),
            angle=tuple(sensor.nominal_mounting_angle.tolist()),
            effects=tuple(
                (name, one) for name, one, _ in effects if isinstance(one, Disturbance)
            ),
            courses=tuple(
                (name, one, course)
                for name, one, course in effects
                if isinstance(one, OnTheWay | VibrationRectification) and course
            ),
        )

    def columns(
        self,
        names: Sequence[Name],
        rate: Array,
        force: Array,
        time: Array | float = 0.0,
    ) -> Array:
        """Return what constants of 1 are of what is sensed, shape (..., 3, n).

        Parameters
        ----------
        names : sequence of Name
            Of parameters and lines of this triad, by axis.
        rate, force : ndarray, shape (..., 3)
            In body axes [rad/s, m/s^2].
        time : ndarray, shape (...)
            From the mission's start [s].
        """
        v = rate if self.kind == GYRO else force
        M = np.eye(3) + tilt_matrix(np.array(self.angle))
        x = v @ M.T + np.array(self.bias)
        angles = np.zeros((*v.shape, len(ANGLES)))
        angles[..., ROW, range(len(ANGLES))] = SIGN * v[..., COLUMN]
        blocks: dict[str, tuple[tuple[str, ...], Array]] = {
            "mounting_angle": (ANGLES, angles),
            **{
                quantity: (AXES, diagonal(x**power))
                for quantity, power in (
                    ("bias", 0),
                    ("scale_factor", 1),
                    *ORDERS.items(),
                )
            },
        }
        for name, effect in self.effects:
            added = effect.in_use(x, force)
            if added is not None:
                blocks[name] = (source_of(self.kind, name).axes, -1.0 * added)
        for name, one, course in self.courses:
            size = one.felt(course, np.asarray(time))
            blocks[name] = (AXES, -size[..., None, None] * blocks[one.target][1])
        parts = [
            block[..., axes.index(name.axis)]
            for name in names
            for axes, block in [blocks[name.quantity]]
        ]
        return np.asarray(np.linalg.solve(M, np.stack(parts, axis=-1)))


def noise_in_run(
    sensors: Sequence[Sensor],
    journey: Growth | Aided,
    *,
    sample_rate: float,
    only: frozenset[str] | None = None,
) -> Iterator[tuple[Name, Array]]:
    """Yield each line that is noise in run and counts, with the covariance it makes.

    Shape (times, 9, times, 9), in the order of Moment.seen [SI squared].
    """
    for name, parts in noises_of(sensors, sample_rate=sample_rate):
        if only is None or name in only:
            yield name, journey.of_noise(parts)


def noises_of(
    sensors: Sequence[Sensor], *, sample_rate: float
) -> Iterator[tuple[Name, tuple[AxisNoise, ...]]]:
    """Yield each line that is noise in run, with what it is of each axis."""
    for sensor in sensors:
        for line in sensor.lines:
            effect = source_of(sensor.kind, line.name).meant(line).effect
            if not isinstance(effect, Noise):
                continue
            parts = []
            for axis in range(len(AXES)):
                found = effect.process(line, axis, sample_rate).in_run(sample_rate)
                noise = IN_RUN[found.kind](*found.times)
                row = FIRST[sensor.kind] + axis
                parts.append(AxisNoise(row=row, noise=noise, u=found.u))
            yield Name(line.name, owner=sensor.kind), tuple(parts)


def of_test_alone(sensors: Sequence[Sensor]) -> tuple[Name, ...]:
    """Return lines that are given and say nothing of what they do in use."""
    return tuple(
        Name(line.name, owner=sensor.kind)
        for sensor in sensors
        for line in sensor.lines
        for effect in [source_of(sensor.kind, line.name).meant(line).effect]
        if line.u.any()
        and isinstance(effect, Disturbance)
        and effect.in_use(np.zeros(3), np.zeros(3)) is None
    )


def not_carried(sensors: Sequence[Sensor], procedure: Procedure) -> tuple[Name, ...]:
    """Return lines that are given and would act on the way, and are not carried along.

    A temperature that changes on the way is not modelled. Of coefficients of
    temperature what another one at the start does (temperature.mission) is carried, so
    they are named where nobody gives it; those of its rate unless it is known on the
    way.
    """
    felt = [
        (Name(line.name, owner=sensor.kind), line.name)
        for sensor in sensors
        for line in sensor.lines
        if line.u.any()
        and isinstance(source_of(sensor.kind, line.name).effect, TemperatureCoefficient)
    ]
    known = [
        (line, source_of(ENVIRONMENT, line.name).effect)
        for line in procedure.environment
    ]
    at_start = [line for line, x in known if isinstance(x, TemperatureChange)]
    has_course = any(line.course for line in at_start)
    courses = (
        Name(line.name, owner=ENVIRONMENT)
        for line, effect in known
        if felt and isinstance(effect, History) and not isinstance(effect, Soaks)
    )
    unknown = (
        name
        for name, line in felt
        if not (at_start and (has_course or line != RATE_COEFFICIENT))
    )
    return (*unknown, *courses)
