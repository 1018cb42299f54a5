"""The nominal route of a mission: legs of constant rates, or a recorded trajectory."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, cos, hypot, sin
from typing import TYPE_CHECKING, Protocol

import numpy as np

from budget.documents import written
from budget.earth import meridian_radius, normal_radius
from budget.errors import ProblemError
from budget.navigation.dynamics import Moment, each, level_body

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scipy.interpolate import CubicSpline
    from scipy.spatial.transform import RotationSpline

    from budget.arrays import Array

# The longest step in which the equations of motion are taken as a cubic: of time, and
# of a turn. Halving both moves no result by 1e-7 of itself.
STEP = 30.0  # [s]
TURN_STEP = 0.1  # [rad]
# Of velocity, off a straight line in time, in a step of a recorded track: 1.3e-4 of the
# errors in a flight that swings from side to side in two minutes, a tenth a tenth.
BEND = 0.1  # [m/s]
ROUNDING = 1e-9  # of a count of steps, and of times
UPRIGHT = 1e-4  # cosine of a pitch at which there is no heading [1]
# Right, forward and up as columns, of front, right and down.
FRONT_OF_BODY = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A stretch of a route: while it lasts three rates are constant.

    A leg with a bank is entered level, rolls to its bank, and is level again at its
    end; without one it rolls as long as it lasts.
    """

    duration: float  # [s]
    turn_rate: float = 0.0  # of the heading [rad/s]
    acceleration: float = 0.0  # forward [m/s^2]
    climb_rate: float = 0.0  # [m/s]
    bank: float = 0.0  # right side down [rad]
    roll_rate: float = 0.0  # of that sign [rad/s]

    @property
    def rolling(self) -> float:
        """How long it rolls to its bank, and as long back [s]."""
        return self.bank / self.roll_rate if self.bank else 0.0

    @property
    def pieces(self) -> tuple[Leg, ...]:
        """The leg in parts that each roll at a constant rate."""
        if not self.bank:
            return (self,)
        spans = (
            (self.rolling, self.roll_rate),
            (self.duration - 2.0 * self.rolling, 0.0),
            (self.rolling, -self.roll_rate),
        )
        return tuple(
            replace(self, duration=span, bank=0.0, roll_rate=rate)
            for span, rate in spans
            if span > 0.0
        )

    def steps(self, time: float) -> int:
        """Return in how many steps errors are carried along so much of it."""
        turned = hypot(self.turn_rate, self.roll_rate) * time
        return ceil(max(time / STEP, turned / TURN_STEP, 1.0) - ROUNDING)


@dataclass(frozen=True, kw_only=True)
class Start:
    """Where a route begins, and how."""

    latitude: float  # geodetic [rad]
    height: float = 0.0  # above the ellipsoid [m]
    speed: float = 0.0  # forward [m/s]
    heading: float = 0.0  # from north to east [rad]
    longitude: float | None = None  # which nothing depends on [rad]
    roll: float = 0.0  # right side down [rad]
    time: float = 0.0  # since the mission's start [s]


# Gauss' four points in [0, 1], and their weights.
NEAR, FAR = (0.5 * (3.0 / 7.0 + sign * (4.8 / 49.0) ** 0.5) ** 0.5 for sign in (-1, 1))
NODES = (0.5 - FAR, 0.5 - NEAR, 0.5 + NEAR, 0.5 + FAR)
HEAVY, LIGHT = (0.25 + sign * 30.0**0.5 / 72.0 for sign in (1, -1))
WEIGHTS = (LIGHT, HEAVY, HEAVY, LIGHT)


@dataclass(frozen=True, kw_only=True, eq=False)
class Steps:
    """A route in short steps.

    Attributes
    ----------
    durations : ndarray, shape (s,)
        Of the steps [s].
    nodes : Moment, shape (s, 4)
        At the points of Gauss of each step.
    asked : tuple of int
        Steps at whose ends something is asked for.
    ends : Moment, shape (times,)
        Those ends.
    """

    durations: Array
    nodes: Moment
    asked: tuple[int, ...]
    ends: Moment


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """How a vehicle moves at times of its route, both of shape (s, 4)."""

    time: Array  # from the start [s]
    moment: Moment

    @classmethod
    def of(cls, durations: Array, nodes: Moment) -> Motion:
        """Return the nodes of steps with their times."""
        begins = np.cumsum(durations) - durations
        return cls(
            time=begins[:, None] + durations[:, None] * np.array(NODES), moment=nodes
        )


@written(
    "route",
    """
    latitude [rad]: where it begins and ends
    longitude [rad]: likewise; null where it is not given
    heights [m]: least and largest, above the ellipsoid
    length [m]: of the way
    duration [s]
    speed [m/s]: largest
    climb_rate [m/s]: largest, up or down
    acceleration [m/s^2]: largest of north, east, down
    turn_rate [rad/s]: largest, against north, east, down
    hardest [s]: when the acceleration is largest
    """,
)
@dataclass(frozen=True, kw_only=True)
class Outline:
    """A route in a few numbers, in SI, by which its user sees a wrong unit.

    The largest are at the points of Gauss of its steps, and of the motion against the
    ground: at rest all are 0.
    """

    latitude: tuple[float, float]  # where it begins and ends [rad]
    longitude: tuple[float, float] | None  # likewise; None: not given
    heights: tuple[float, float]  # least and largest, above the ellipsoid [m]
    length: float  # of the way [m]
    duration: float  # [s]
    speed: float  # largest [m/s]
    climb_rate: float  # largest, up or down [m/s]
    acceleration: float  # largest, dv/dt north, east, down [m/s^2]
    turn_rate: float  # largest, against north, east, down [rad/s]
    hardest: float  # when the acceleration is largest [s]


class Route(Protocol):
    """Where a vehicle goes, and how it moves there."""

    @property
    def outline(self) -> Outline:
        """It in a few numbers, found once."""

    @property
    def duration(self) -> float:
        """From its start to its end [s]."""

    @property
    def first(self) -> Moment:
        """When it begins."""

    @property
    def course(self) -> Motion:
        """All of it, at the points of Gauss of its steps."""

    def steps(self, times: Sequence[float], cuts: Sequence[float] = ()) -> Steps:
        """Return it in short steps, one of which ends at every asked time and cut."""


@dataclass(frozen=True, kw_only=True)
class Legs:
    """A route of legs, one after another, of a vehicle that leans in banks alone."""

    start: Start
    legs: tuple[Leg, ...]

    @property
    def duration(self) -> float:
        """From the start to the end of the last leg [s]."""
        return sum(leg.duration for leg in self.legs)

    @property
    def first(self) -> Moment:
        """When the route begins."""
        return moments([self.start], [self.legs[0]], ())

    @property
    def course(self) -> Motion:
        """All of it, at the points of Gauss of its steps."""
        steps = self.steps((self.duration,))
        return Motion.of(steps.durations, steps.nodes)

    @cached_property
    def outline(self) -> Outline:
        """It in a few numbers; the longitude is the sum of the way east."""
        steps = self.steps((self.duration,))
        here = self.start.longitude
        east = steps.nodes.velocity[..., 1] / steps.nodes.radii[1]
        moved = east / each(cos, steps.nodes.latitude) @ WEIGHTS @ steps.durations
        return _outline(
            steps.durations,
            steps.nodes,
            latitude=(self.start.latitude, float(steps.ends.latitude[-1])),
            longitude=None if here is None else (here, here + float(moved)),
            heights=self.start.height
            + np.cumsum([0.0, *(leg.climb_rate * leg.duration for leg in self.legs)]),
        )

    def leg_at(self, time: float) -> int:
        """Return the place of the leg that a time after the start is in."""
        ends = np.cumsum([leg.duration for leg in self.legs])
        return min(int(np.searchsorted(ends, time)), len(self.legs) - 1)

    def steps(self, times: Sequence[float], cuts: Sequence[float] = ()) -> Steps:
        """Return the route in short steps, one of which ends at every asked time.

        Parameters
        ----------
        times : sequence of float
            From the start [s], rising, above 0; to the end at the most.
        cuts : sequence of float
            Where a step ends, too, if it is within them [s].

        Raises
        ------
        ProblemError
            A time is not within the route.
        """
        checked(times, self.duration)
        durations: list[float] = []
        nodes, ends = _Points(), _Points()
        asked: list[int] = []
        wanted = {*times}
        here, begun, left = self.start, 0.0, cut_at(times, cuts)
        for leg in (piece for whole in self.legs for piece in whole.pieces):
            done = 0.0
            while done < leg.duration:
                until = leg.duration
                is_asked = bool(left) and left[0] <= (begun + until) * (1.0 + ROUNDING)
                if is_asked:
                    is_asked = left[0] in wanted
                    asks = left.pop(0) - begun
                    until = asks if asks < until * (1.0 - ROUNDING) else until
                number = leg.steps(until - done)
                length = (until - done) / number
                for _ in range(number):
                    nodes.add(leg, *(moved(here, leg, n * length) for n in NODES))
                    here = moved(here, leg, length)
                    durations.append(length)
                if is_asked:
                    asked.append(len(durations) - 1)
                    ends.add(leg, here)
                done = until
            begun += leg.duration
        return Steps(
            durations=np.array(durations),
            nodes=nodes.moments((-1, len(NODES))),
            asked=tuple(asked),
            ends=ends.moments((-1,)),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """A recorded trajectory, of a vehicle of any attitude.

    Cubic splines go through its positions and its attitude, whose turn rate and its
    slope are continuous too. Steps follow the record as closely as it bends; the
    accelerations and turn rates in a step are those that its velocity and attitude need
    from its begin to its middle and its end, so that what is quicker than a step, and
    the noise of what was recorded, add up to what happened.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Rising from 0 [s]; two at least.
    latitude, longitude, height : ndarray, shape (n,)
        Geodetic, and above the ellipsoid [rad, m].
    attitude : ndarray, shape (n, 3)
        Roll, right side down; pitch, nose up; heading, from north to east [rad]: body
        axes are turned from north, east, down by the heading about the third, the pitch
        about the second, the roll about the first.

    Raises
    ------
    ProblemError
        Shapes do not fit, a number is not finite, or time does not rise from 0.
    """

    time: Array
    latitude: Array
    longitude: Array
    height: Array
    attitude: Array

    def __post_init__(self) -> None:
        """Check it once, where it enters."""
        n = len(self.time)
        columns = (self.time, self.latitude, self.longitude, self.height)
        shapes = [np.shape(column) for column in (*columns, self.attitude)]
        if n < 2 or shapes != [(n,)] * 4 + [(n, 3)]:  # noqa: PLR2004 - a begin, an end
            raise ProblemError(
                f"a track of shapes {shapes}: expected four columns of n times, two at "
                "least, and an attitude (n, 3)"
            )
        if not all(np.isfinite(one).all() for one in (*columns, self.attitude)):
            raise ProblemError("a track has a number that is not finite")
        if self.time[0] or not (np.diff(self.time) > 0.0).all():
            raise ProblemError("the times of a track do not rise from 0")

    @property
    def duration(self) -> float:
        """From its first time to its last [s]."""
        return float(self.time[-1])

    @property
    def first(self) -> Moment:
        """When it begins."""
        return self._moments(np.array(0.0))

    @property
    def course(self) -> Motion:
        """All of it, at the points of Gauss of its steps."""
        edges, _ = self._whole
        return Motion.of(np.diff(edges), self._nodes(edges))

    @cached_property
    def outline(self) -> Outline:
        """It in a few numbers."""
        edges, _ = self._whole
        return _outline(
            np.diff(edges),
            self._nodes(edges),
            latitude=(float(self.latitude[0]), float(self.latitude[-1])),
            longitude=(float(self.longitude[0]), float(self.longitude[-1])),
            heights=self.height,
        )

    def steps(self, times: Sequence[float], cuts: Sequence[float] = ()) -> Steps:
        """Return the route to the last asked time; see Route.

        Raises
        ------
        ProblemError
            A time is not within the route, or the vehicle points up or down then.
        """
        checked(times, self.duration)
        stops = cut_at(times, cuts)
        edges, ended = self._edges(stops)
        wanted = {*times}
        asked = tuple(
            step for step, stop in zip(ended, stops, strict=True) if stop in wanted
        )
        ends = self._moments(edges[np.array(asked) + 1])
        if np.hypot(*np.moveaxis(ends.body[..., :2, 1], -1, 0)).min() < UPRIGHT:
            raise ProblemError(
                "the vehicle points straight up or down at a time that is asked for; "
                "it has no heading then: ask for another"
            )
        return Steps(
            durations=np.diff(edges), nodes=self._nodes(edges), asked=asked, ends=ends
        )

    def _nodes(self, edges: Array) -> Moment:
        """Return what the errors grow by at the points of Gauss between ends of steps.

        Of shape (steps, 4).
        """
        a, b = edges[:-1], edges[1:]
        h = b - a
        at = a[:, None] + h[:, None] * np.array(NODES)
        middle = 0.5 * (a + b)
        v, w, x = (self._velocity(t)[1] for t in (a, middle, b))
        acceleration = _linear(v, w, x, h)
        begun, half, ended = (self._attitude(t) for t in (a, middle, b))
        # Of the turns of both halves, in body axes, as a velocity's changes.
        first, second = (
            one.as_rotvec() for one in (begun.inv() * half, half.inv() * ended)
        )
        turning = _linear(-first, 0.0 * first, second, h)
        return self._moments(at, acceleration=acceleration, turning=turning)

    @cached_property
    def _whole(self) -> tuple[Array, tuple[int, ...]]:
        """Ends of the steps of all of it; most of the time to find them is here."""
        return self._edges((self.duration,))

    def _edges(self, times: Sequence[float]) -> tuple[Array, tuple[int, ...]]:
        """Return the ends of steps, and which steps end at the asked times.

        They are times of the record, more where these are far apart, fewer where the
        track is straight: velocity is within BEND of linear in a step.
        """
        asked = np.minimum(times, self.duration)
        near = np.abs(self.time[:, None] - asked).min(axis=1) > self.duration * ROUNDING
        known = self.time[near & (self.time < asked[-1])]
        whole = np.unique(np.concatenate([[0.0], known, asked]))
        turned = self._turned(whole)
        number = np.ceil(
            np.maximum(np.diff(whole) / STEP, turned / TURN_STEP) - ROUNDING
        ).astype(int)
        parts = [
            np.linspace(a, b, max(n, 1), endpoint=False)
            for a, b, n in zip(whole[:-1], whole[1:], number, strict=True)
        ]
        t = np.concatenate([*parts, whole[-1:]])
        turns = np.concatenate([[0.0], np.cumsum(self._turned(t))])
        velocity = self._velocity(t)[1]
        stops = np.searchsorted(t, asked)
        kept = [0]
        while kept[-1] < stops[-1]:
            i = kept[-1]
            j = min(
                stops[np.searchsorted(stops, i, side="right")],
                np.searchsorted(t, t[i] + STEP * (1.0 + ROUNDING), side="right") - 1,
                np.searchsorted(turns, turns[i] + TURN_STEP, side="right") - 1,
            )
            while j > i + 1 and _bend(t[i : j + 1], velocity[i : j + 1]) > BEND:
                j = i + (j - i) // 2
            kept.append(max(int(j), i + 1))
        return t[kept], tuple(int(step) for step in np.searchsorted(kept, stops) - 1)

    def _turned(self, t: Array) -> Array:
        """Return the angles from each time to the next [rad]."""
        attitude = self._attitude(t)
        return np.asarray((attitude[:-1].inv() * attitude[1:]).magnitude())

    @cached_property
    def _position(self) -> CubicSpline:
        """Latitude, longitude and height by time."""
        from scipy.interpolate import CubicSpline

        columns = (self.latitude, np.unwrap(self.longitude), self.height)
        return CubicSpline(self.time, np.stack(columns, axis=-1))

    @cached_property
    def _attitude(self) -> RotationSpline:
        """Rotation from front, right, down to north, east, down by time."""
        from scipy.spatial.transform import Rotation, RotationSpline

        turns = Rotation.from_euler("ZYX", self.attitude[:, ::-1])
        return RotationSpline(self.time, turns)

    def _velocity(self, t: Array) -> tuple[Array, Array]:
        """Return latitude, longitude and height, and velocity, shapes (..., 3)."""
        place = self._position(t)
        slope = self._position(t, 1)
        latitude, height = place[..., 0], place[..., 2]
        east = each(normal_radius, latitude) + height
        north = each(meridian_radius, latitude) + height
        scales = (north, east * each(cos, latitude), -np.ones_like(height))
        return place, slope * np.stack(scales, axis=-1)

    def _moments(
        self,
        t: Array,
        acceleration: Array | float = 0.0,
        turning: Array | float = 0.0,
    ) -> Moment:
        """Return what the errors grow by at times, the turn rate given in the body."""
        place, velocity = self._velocity(t)
        front = self._attitude(t.ravel()).as_matrix().reshape(*t.shape, 3, 3)
        rates = np.broadcast_to(turning, velocity.shape)[..., None]
        return Moment(
            latitude=place[..., 0],
            height=place[..., 2],
            velocity=velocity,
            acceleration=np.broadcast_to(acceleration, velocity.shape),
            body=front @ FRONT_OF_BODY,
            turning=(front @ rates)[..., 0],
            time=t,
        )


def _outline(
    durations: Array,
    nodes: Moment,
    *,
    latitude: tuple[float, float],
    longitude: tuple[float, float] | None,
    heights: Array,
) -> Outline:
    """Return the outline of a route from steps of it and where it begins and ends.

    And from heights on the way, which has none above or below all of them.
    """
    speed, acceleration, turn_rate = (
        np.linalg.norm(one, axis=-1)
        for one in (nodes.velocity, nodes.acceleration, nodes.turning)
    )
    return Outline(
        latitude=latitude,
        longitude=longitude,
        heights=(float(heights.min()), float(heights.max())),
        length=float(speed @ WEIGHTS @ durations),
        duration=float(durations.sum()),
        speed=float(speed.max()),
        climb_rate=float(np.abs(nodes.velocity[..., 2]).max()),
        acceleration=float(acceleration.max()),
        turn_rate=float(turn_rate.max()),
        hardest=float(Motion.of(durations, nodes).time.ravel()[acceleration.argmax()]),
    )


def _linear(begin: Array, middle: Array, end: Array, h: Array) -> Array:
    """Return slopes at the nodes, linear in time, of what has these values.

    Shape (steps, 4, 3), of (steps, 3) and durations (steps,).
    """
    per_step = 1.0 / h[:, None]
    mean = (end - begin) * per_step
    grows = 4.0 * (end - 2.0 * middle + begin) * per_step
    late = np.array(NODES)[:, None] - 0.5
    return np.asarray(mean[:, None] + grows[:, None] * late)


def _bend(t: Array, velocity: Array) -> float:
    """Return how far velocity is from linear between its ends, at most [m/s]."""
    part = ((t - t[0]) / (t[-1] - t[0]))[:, None]
    chord = velocity[0] + part * (velocity[-1] - velocity[0])
    return float(np.abs(velocity - chord).max())


class _Points:
    """Points of a route as they are found."""

    def __init__(self) -> None:
        """Begin with none."""
        self.points: list[Start] = []
        self.legs: list[Leg] = []

    def add(self, leg: Leg, *points: Start) -> None:
        """Note points of a leg."""
        self.points += points
        self.legs += [leg] * len(points)

    def moments(self, shape: tuple[int, ...]) -> Moment:
        """Return what the errors grow by there."""
        return moments(self.points, self.legs, shape)


def checked(times: Sequence[float], duration: float) -> None:
    """Refuse times that do not rise, or are not within a route.

    Raises
    ------
    ProblemError
        With the times, and what is allowed.
    """
    t = np.array([0.0, *times])
    if not ((np.diff(t) > 0.0).all() and t[-1] <= duration * (1.0 + ROUNDING)):
        raise ProblemError(
            f"times {', '.join(f'{time:g}' for time in times)} s of a route that takes "
            f"{duration:g} s: expected rising ones above 0, to its end at the most"
        )


def cut_at(times: Sequence[float], cuts: Sequence[float]) -> list[float]:
    """Return rising times with cuts between them, to the last of these.

    A cut that is a time but for rounding is none.
    """
    slack = ROUNDING * times[-1]
    return sorted(
        (
            *times,
            *(
                cut
                for cut in cuts
                if slack < cut < times[-1]
                and times[bisect_left(times, cut - slack)] > cut + slack
            ),
        )
    )


def moved(start: Start, leg: Leg, time: float) -> Start:
    """Return where a leg leads in a short time: Runge and Kutta's fourth order."""

    def slope(t: float, latitude: float) -> float:
        speed = start.speed + leg.acceleration * t
        north = speed * cos(start.heading + leg.turn_rate * t)
        height = start.height + leg.climb_rate * t
        return north / (meridian_radius(latitude) + height)

    first = slope(0.0, start.latitude)
    second = slope(time / 2.0, start.latitude + time / 2.0 * first)
    third = slope(time / 2.0, start.latitude + time / 2.0 * second)
    last = slope(time, start.latitude + time * third)
    return Start(
        latitude=start.latitude
        + time / 6.0 * (first + 2.0 * second + 2.0 * third + last),
        height=start.height + leg.climb_rate * time,
        speed=start.speed + leg.acceleration * time,
        heading=start.heading + leg.turn_rate * time,
        roll=start.roll + leg.roll_rate * time,
        time=start.time + time,
    )


def moments(
    points: Sequence[Start], legs: Sequence[Leg], shape: tuple[int, ...]
) -> Moment:
    """Return what the errors grow by at points of legs, as arrays of that shape."""

    def column(values: Iterable[float]) -> Array:
        return np.array(list(values), dtype=float).reshape(shape)

    speed = column(point.speed for point in points)[..., None]
    level = level_body(column(point.heading for point in points))
    aside, ahead = level[..., 0], level[..., 1]
    down = np.array([0.0, 0.0, 1.0])
    roll = column(point.roll for point in points)[..., None]
    s, c = each(sin, roll), each(cos, roll)
    turn_rate = column(leg.turn_rate for leg in legs)[..., None]
    roll_rate = column(leg.roll_rate for leg in legs)[..., None]
    climb_rate = column(leg.climb_rate for leg in legs)[..., None]
    gains = column(leg.acceleration for leg in legs)[..., None]
    return Moment(
        latitude=column(point.latitude for point in points),
        height=column(point.height for point in points),
        velocity=speed * ahead - climb_rate * down,
        acceleration=gains * ahead + speed * turn_rate * aside,
        body=np.stack([c * aside + s * down, ahead, s * aside - c * down], axis=-1),
        turning=turn_rate * down + roll_rate * ahead,
        time=column(point.time for point in points),
    )
