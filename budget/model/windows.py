"""Schedules: windows over which the readings of one triad are averaged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from math import ceil, cos, isclose, pi, sin
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from budget.arrays import Array


OUTER, MIDDLE, INNER = 2, 1, 0  # the body axis that each turns about at table zero
FLIPS = {"inner": INNER, "middle": MIDDLE}  # axes that z comes down by
CHAIN = (OUTER, MIDDLE, INNER)  # from the base to the body
RIGHT = pi / 2.0
FACES = {  # (axis, sign up or down): how the table holds it, at azimuth zero
    (2, 1): (0.0, 0.0),  # middle, inner [rad]
    (2, -1): (0.0, pi),
    (0, 1): (-RIGHT, 0.0),
    (0, -1): (RIGHT, 0.0),
    (1, 1): (0.0, RIGHT),
    (1, -1): (0.0, -RIGHT),
}
ANGLE, RATE = "angle", "rate"  # that scale factors are taken from
EDGES = ("index", "rest", "time")  # of windows: at an index of the table, at rest
EDGES_BY_TIME = EDGES[-1]
# Cosines and sines below this are rounding of a right angle or a whole turn [1].
ROUNDING = 1e-15
STEP = pi / 12.0  # of a turn that is integrated, at the most [rad]
EXACT = 1e-9  # part of a step that is rounding [1]
POINTS = 4  # of a turn: as many as harmonics 0 to 3 take [1]


@dataclass(frozen=True, kw_only=True)
class Timing:
    """What a test goes by where its table turns.

    Attributes
    ----------
    scale_from : str
        ANGLE, of whole turns whose time is measured, or RATE, that the table is set to.
    edges : str
        One of EDGES, of windows.
    """

    scale_from: str = ANGLE
    edges: str = EDGES[0]


@dataclass(frozen=True, kw_only=True)
class Setting:
    """Angles of the table, and the turn that one of its axes makes from there.

    Attributes
    ----------
    outer, middle, inner : float
        [rad].
    turning : int or None
        OUTER, MIDDLE or INNER.
    angle : float
        Of the turn; its sign is the sense [rad].
    """

    outer: float = 0.0
    middle: float = 0.0
    inner: float = 0.0
    turning: int | None = None
    angle: float = 0.0

    @classmethod
    def face(
        cls, axis: int, sign: int, azimuth: float = 0.0, flip: int = INNER
    ) -> Setting:
        """Hold a body axis up (sign +1) or down, the outer axis at an azimuth [rad].

        z comes down by half a turn of the inner axis, or of the middle one (`flip`).
        """
        middle, inner = FACES[axis, sign]
        if flip == MIDDLE and (axis, sign) == (2, -1):
            middle, inner = inner, middle
        return cls(outer=azimuth, middle=middle, inner=inner)

    def after(self, angle: float) -> Setting:
        """Return how the table stands when it has turned by an angle [rad]."""
        if self.turning is None:
            return self
        axis = ("inner", "middle", "outer")[self.turning]
        stands = {axis: getattr(self, axis) + angle}
        return replace(self, turning=None, angle=0.0, **stands)

    @property
    def to_body(self) -> Array:
        """Matrix from east-north-up to body axes, shape (3, 3), mean over the turn."""
        return _to_body(self)

    @property
    def around(self) -> Array:
        """The same at POINTS angles spread evenly over a whole turn, (POINTS, 3, 3)."""
        return _around(self)

    def between(self, first: int, last: int) -> Array:
        """Matrix from the frame after `first` axes to that after `last`, (3, 3), mean.

        Axes are counted from the base: after none of them the frame is east-north-up,
        after outer, middle and inner it is the body's.
        """
        matrix = np.eye(3)
        for axis in CHAIN[first:last]:
            matrix = self.back(axis) @ matrix
        return matrix

    def turn_axis_after(self, number: int) -> Array:
        """Axis of the turn in the frame after that many axes, shape (3,).

        Zeros where nothing turns, or where what turns stands further out.
        """
        if self.turning is None or CHAIN.index(self.turning) >= number:
            return np.zeros(3)
        onward = self.between(CHAIN.index(self.turning) + 1, number)
        return np.asarray(onward @ np.eye(3)[self.turning])

    @property
    def turn_axis(self) -> Array:
        """Axis of the turn in body axes, shape (3,); zeros where nothing turns."""
        return _turn_axis(self)

    @property
    def angles(self) -> tuple[float, float, float]:
        """Outer, middle and inner angle, where it stands or the turn begins [rad]."""
        return self.outer, self.middle, self.inner

    def back(self, axis: int) -> Array:
        """Return the transposed rotation about one axis, mean over the turn."""
        start = (self.inner, self.middle, self.outer)[axis]
        turn = self.angle if axis == self.turning else 0.0
        return _mean_rotation(axis, start, turn).T


# Of longer tests, and of the devices of a comparison, the settings are the same.
@lru_cache(maxsize=2048)
def _to_body(setting: Setting) -> Array:
    """Return the mean matrix of a setting, shape (3, 3); it is kept, and read only."""
    x, y, z = (setting.back(axis) for axis in range(3))
    return _kept(x @ y @ z)


@lru_cache(maxsize=2048)
def _turn_axis(setting: Setting) -> Array:
    """Return the axis of a turn in body axes, shape (3,)."""
    return _kept(setting.turn_axis_after(len(CHAIN)))


@lru_cache(maxsize=2048)
def _around(setting: Setting) -> Array:
    """Return its matrices over a whole turn, shape (POINTS, 3, 3)."""
    steps = (2.0 * pi * k / POINTS for k in range(POINTS))
    return _kept(np.array([setting.after(step).to_body for step in steps]))


def _kept(matrix: Array) -> Array:
    """Return it as nobody can change it."""
    matrix.setflags(write=False)
    return matrix


def _mean_rotation(axis: int, start: float, turn: float) -> Array:
    """Return the mean of rotations about a coordinate axis, shape (3, 3).

    cos and sin averaged over the angles from `start` to `start + turn`: those of the
    middle angle times sin(h)/h, h half the turn; 0 over whole turns.
    """
    half = turn / 2.0
    damping = sin(half) / half if half else 1.0
    middle = start + half
    c, s = (
        0.0 if abs(part) < ROUNDING else part
        for part in (cos(middle) * damping, sin(middle) * damping)
    )
    R = np.zeros((3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R[axis, axis] = 1.0
    R[j, j] = R[k, k] = c
    R[j, k], R[k, j] = -s, s
    return R


@dataclass(frozen=True, kw_only=True)
class Window:
    """One turn or one dwell.

    Attributes
    ----------
    name : str
        'turn z+', 'azimuth 180', 'z up 1'.
    start, length : float
        [s], the start counted from the first window of the triad.
    setting : Setting
        Of the table.
    axis : int or None
        Body axis turned about, or vertical; 0, 1, 2 for x, y, z. None at an azimuth.
    sign : int
        +1 or -1: sense of the turn, or the axis up or down; 0 at an azimuth.
    azimuth : float or None
        Of a gyro dwell [rad].
    use : str
        Whose readings are averaged: 'gyro', 'accelerometer' or 'both'.
    """

    name: str
    start: float
    length: float
    setting: Setting = field(default_factory=Setting)
    axis: int | None = None
    sign: int = 0
    azimuth: float | None = None
    use: str = "both"

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.start + self.length

    @property
    def steps(self) -> tuple[Window, ...]:
        """Equal parts of a turn, none over STEP; of a dwell itself.

        Noise within a step of 15 deg weighs as if it came at its mean attitude: of a
        variance that leaves out 15^2/24 deg^2 = 0.3 % at the most.
        """
        n = max(1, ceil(abs(self.setting.angle) / STEP - EXACT))
        angle, length = self.setting.angle / n, self.length / n
        return tuple(
            replace(
                self,
                name=self.name if n == 1 else f"{self.name}, {k + 1} of {n}",
                start=self.start + k * length,
                length=length,
                setting=replace(
                    self.setting.after(k * angle),
                    turning=self.setting.turning,
                    angle=angle,
                ),
            )
            for k in range(n)
        )

    def goes_on(self, before: Window) -> bool:
        """Whether it is a turn from where another one ended."""
        ended = before.setting.after(before.setting.angle).angles
        begins = zip(ended, self.setting.angles, strict=True)
        is_there = all(isclose(a, b, abs_tol=EXACT) for a, b in begins)
        return bool(self.sense and before.sense and is_there)

    @property
    def rate(self) -> Array:
        """Mean rate of the table's turn, in body axes, shape (3,) [rad/s]."""
        return self.setting.turn_axis * (self.setting.angle / self.length)

    @property
    def sense(self) -> int:
        """Sign of the turn; 0 of a dwell."""
        return int(np.sign(self.setting.angle))


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The windows of one triad in the order of time.

    Attributes
    ----------
    windows : tuple of Window
    others : tuple of Window
        Those of the other triad alone, on the same clock.
    before, later : tuple of Window
        Those of the other triad's own test, where that comes before, or after this.
    """

    windows: tuple[Window, ...]
    others: tuple[Window, ...] = ()
    before: tuple[Window, ...] = ()
    later: tuple[Window, ...] = ()

    @cached_property
    def starts(self) -> Array:
        """Starts, shape (n_windows,) [s]."""
        return np.array([window.start for window in self.windows])

    @cached_property
    def lengths(self) -> Array:
        """Lengths, shape (n_windows,) [s]."""
        return np.array([window.length for window in self.windows])

    @cached_property
    def middles(self) -> Array:
        """Times in the middle of the windows, shape (n_windows,) [s]."""
        return self.starts + self.lengths / 2.0

    @cached_property
    def senses(self) -> Array:
        """Signs of the turns, 0 of dwells, shape (n_windows,) [1]."""
        return np.array([float(window.sense) for window in self.windows])

    @cached_property
    def turn_starts(self) -> tuple[float, ...]:
        """Starts of the turns of all triads [s]."""
        return tuple(
            sorted(one.start for one in (*self.windows, *self.others) if one.sense)
        )

    @cached_property
    def turns(self) -> Mapping[int, int]:
        """Number of each turn among those of all triads, by its place here."""
        number = {start: k for k, start in enumerate(self.turn_starts)}
        return {
            place: number[window.start]
            for place, window in enumerate(self.windows)
            if window.sense
        }

    @cached_property
    def _stops(self) -> tuple[Mapping[int, int], int]:
        """Number of the stop at each place here, and how many there are in all."""
        own = {id(window): place for place, window in enumerate(self.windows)}
        clock = sorted((*self.windows, *self.others), key=lambda one: one.start)
        number, found = -1, {}
        for test in (self.before, clock, self.later):
            last: Window | None = None
            for window in test:
                stands = (
                    last is not None and window.setting.angles == last.setting.angles
                )
                if not (stands or (last is not None and window.goes_on(last))):
                    number += 1
                last = window
                if id(window) in own and test is clock:
                    found[own[id(window)]] = number
        return found, number + 1

    @property
    def stops(self) -> Mapping[int, int]:
        """Number of each stop of the table among those of all triads, by its place.

        Windows one after the other at the same angles are one stop, and turns on from
        there.
        """
        return self._stops[0]

    @property
    def n_stops(self) -> int:
        """Stops of the table in the tests of all triads."""
        return self._stops[1]

    @cached_property
    def rates(self) -> Array:
        """Mean rates of the turns in body axes, shape (n_windows, 3) [rad/s]."""
        return np.array([window.rate for window in self.windows]).reshape(-1, 3)

    @cached_property
    def turned(self) -> Array:
        """Angles of the turns in body axes, 0 of dwells, shape (n_windows, 3) [rad]."""
        return self.rates * self.lengths[:, None]

    @cached_property
    def to_body(self) -> Array:
        """Mean matrices from east-north-up to body axes, shape (n_windows, 3, 3)."""
        matrices = [window.setting.to_body for window in self.windows]
        return np.array(matrices).reshape(-1, 3, 3)

    def spread(self, vector: Array) -> Array:
        """Return an east-north-up vector in body axes within each window, (n, p, 3).

        At angles spread evenly over a whole turn: means of products of up to three
        components are those over the turn. Dwells have it p times alike, p 1 where
        nothing turns.
        """
        if not self.senses.any():
            return (self.to_body @ vector)[:, None]
        return np.array([window.setting.around for window in self.windows]) @ vector

    def pick(self, axis: int, sign: int) -> tuple[int, ...]:
        """Return the places of the windows that turn about, or hold up, that axis."""
        return tuple(
            place
            for place, window in enumerate(self.windows)
            if window.axis == axis and window.sign == sign
        )

    @property
    def azimuths(self) -> tuple[int, ...]:
        """Places of the static windows of a gyro test."""
        return tuple(
            place
            for place, window in enumerate(self.windows)
            if window.azimuth is not None
        )


def dwells_of(windows: Iterable[Window]) -> list[Window]:
    """Return the windows in which nothing turns."""
    return [one for one in windows if not one.sense]
