"""Saturation: inputs of a triad, in a test and on a mission, against its range.

A range is the largest input of either sign that an axis reads. A test takes a gyro to
the rate of its turns and the earth rate, an accelerometer to gravity at every attitude
that it holds or turns through; a mission takes both to what the moving vehicle senses
(budget.navigation.dynamics.Moment: rate and force). Errors of a sensor, its bias among
them, are no part of either: they are thousandths of a range at most.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import ACCELEROMETER, GYRO, SENSORS
from budget.names import AXES
from budget.navigation.route import Legs
from budget.sentences import sentence
from budget.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Mission, Sensor
    from budget.model.place import Place
    from budget.model.windows import Schedule, Window
    from budget.navigation.route import Route

# Of a range, that its two or three digits leave open: the earth rate beside a turn of
# 1 deg/s (0.42 %) and gravity at a pole beside 1 g (0.26 %) are within it [1].
ROUNDED = 0.005
UNITS = {GYRO: ("deg/s", pi / 180.0), ACCELEROMETER: ("g", STANDARD_GRAVITY)}
PER_TURN = 360  # attitudes of a whole turn that are looked at, among them all peaks


@dataclass(frozen=True, kw_only=True)
class Peak:
    """The largest input of one axis, and where that is.

    Attributes
    ----------
    sensor, axis : str
        'gyro' or 'accelerometer'; 'x', 'y' or 'z'.
    size : float
        Without its sign [rad/s or m/s^2].
    where : str
        The window of a test, the segment of a mission: 'segment 2 (turn 180 deg)'; the
        first that comes within ROUNDED of it.
    time : float or None
        Of a mission from its start, None of a test [s].
    """

    sensor: str
    axis: str
    size: float
    where: str
    time: float | None = None

    @property
    def shown(self) -> str:
        """Its size for people: '400 deg/s'."""
        return shown(self.sensor, self.size)


@dataclass(frozen=True, kw_only=True)
class Saturation:
    """Axes of a triad that are asked for more than they read."""

    device: str
    peak: Peak  # of the first of them
    range: float  # of that [rad/s or m/s^2]
    axes: tuple[str, ...]  # all of them

    @property
    def range_shown(self) -> str:
        """Its range for people: '±300 deg/s'."""
        return f"±{shown(self.peak.sensor, self.range)}"

    @property
    def said(self) -> str:
        """The sentence on a mission."""
        return sentence(
            "saturation.beyond",
            device=self.device,
            peak=self.peak,
            range=self.range_shown,
            axes=self.axes,
        )


def shown(sensor: str, size: float) -> str:
    """Write a rate or a force as ranges are printed: '400 deg/s', '1.4 g'."""
    unit, si = UNITS[sensor]
    return f"{size / si:.4g} {unit}"


def peaks_of_test(sensor: str, schedule: Schedule, place: Place) -> tuple[Peak, ...]:
    """Return the largest input of each axis in the windows of one triad.

    w + C(angle) e of a gyro, C(angle) g of an accelerometer: w the rate of the turn, e
    the earth rate, g the specific force of gravity, C to the body axes at every degree
    of a turn. What is between the windows is read by nobody.
    """
    inputs = [_largest(sensor, one, place) for one in schedule.windows]
    names = [one.name for one in schedule.windows]
    return tuple(_peaks(sensor, np.array(inputs), lambda k: (names[k], None)))


@lru_cache(maxsize=64)  # a comparison asks for those of one mission with every device
def peaks_of_mission(mission: Mission) -> tuple[Peak, ...]:
    """Return the largest input of each axis on a mission, gyros x, y, z first.

    At the points at which errors are carried along: of a recording what is quicker than
    those, and its noise, are not seen. Segments follow one another without a transition
    in between: what a vehicle does to begin a turn has no peak here, and neither have
    the vibrations of the way.
    """
    course = mission.route.course
    times = course.time.ravel()
    speeds = np.linalg.norm(course.moment.velocity, axis=-1).ravel()

    def where(k: int) -> tuple[str, float]:
        time = float(times[k])
        return _where(mission.route, time, is_moving=bool(speeds[k] > 0.0)), time

    return tuple(
        peak
        for sensor, inputs in (
            (GYRO, course.moment.rate),
            (ACCELEROMETER, course.moment.force),
        )
        for peak in _peaks(sensor, np.abs(inputs).reshape(-1, 3), where)
    )


def beyond(sensor: Sensor, peaks: Sequence[Peak]) -> Saturation | None:
    """Return the axes of a triad whose peaks are beyond its range; None: none is.

    By more than ROUNDED of it: as large as the range is within.
    """
    if sensor.range is None:
        return None
    limits = dict(zip(AXES, sensor.range.tolist(), strict=True))
    found = [
        peak
        for peak in peaks
        if peak.sensor == sensor.kind
        and peak.size > limits[peak.axis] * (1.0 + ROUNDED)
    ]
    if not found:
        return None
    return Saturation(
        device=sensor.device,
        peak=found[0],
        range=limits[found[0].axis],
        axes=tuple(peak.axis for peak in found),
    )


def saturations(sensors: Sequence[Sensor], mission: Mission) -> tuple[Saturation, ...]:
    """Return the triads that a mission asks for more than they read."""
    found = (beyond(one, peaks_of_mission(mission)) for one in sensors)
    return tuple(one for one in found if one is not None)


def needed_range(sensors: Sequence[Sensor], mission: Mission) -> tuple[Peak, ...]:
    """Return the largest input of each triad whose range is not given on a mission."""
    open_ones = [one.kind for one in sensors if one.range is None]
    return tuple(
        max(
            (peak for peak in peaks_of_mission(mission) if peak.sensor == kind),
            key=lambda peak: peak.size,
        )
        for kind in SENSORS
        if kind in open_ones
    )


def _largest(sensor: str, window: Window, place: Place) -> Array:
    """Return the largest input of each axis within a window, shape (3,).

    f(angle) = a + b cos + c sin, found from three attitudes.
    """
    constant = window.rate if sensor == GYRO else np.zeros(3)
    vector = place.earth if sensor == GYRO else place.force
    first, quarter, half = (
        window.setting.after(angle).to_body @ vector for angle in (0.0, pi / 2.0, pi)
    )
    a, b = (first + half) / 2.0, (first - half) / 2.0
    turn = window.setting.angle
    angles = np.sign(turn) * np.linspace(0.0, min(abs(turn), 2.0 * pi), PER_TURN + 1)
    inputs = (
        constant
        + a
        + np.outer(np.cos(angles), b)
        + np.outer(np.sin(angles), quarter - a)
    )
    return np.asarray(np.abs(inputs).max(axis=0))


def _peaks(
    sensor: str, sizes: Array, where: Callable[[int], tuple[str, float | None]]
) -> Iterator[Peak]:
    """Yield the largest of each axis, of sizes of shape (n, 3), and where that is."""
    for axis, column in zip(AXES, sizes.T, strict=True):
        top = float(column.max())
        words, time = where(int(np.argmax(column >= top * (1.0 - ROUNDED))))
        yield Peak(sensor=sensor, axis=axis, size=top, where=words, time=time)


def _where(route: Route, time: float, *, is_moving: bool) -> str:
    """Say in which segment a time is, or when."""
    if not isinstance(route, Legs):
        return sentence("saturation.at", time=round(time, 1))
    number = route.leg_at(time)
    leg = route.legs[number]
    moves = {
        "turn": leg.turn_rate,
        "accelerate": leg.acceleration,
        "climb": leg.climb_rate,
        "straight": is_moving,
    }
    return sentence(
        "saturation.segment",
        number=number + 1,
        move=next(filter(moves.get, moves), "stand"),
        angle=degrees(leg.turn_rate * leg.duration),
        duration=leg.duration,
    )
