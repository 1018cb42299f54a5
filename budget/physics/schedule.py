"""What is done when: the windows over which the pulses of one triad are averaged."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import accumulate
from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from budget.spec.records import AXES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.spec.records import AccelerometerProcedure, GyroProcedure

FACE_ORDER = ("z", "x", "y")  # Zhao 2019, section 1.2.3: z up, z down, x up, ...


@dataclass(frozen=True, kw_only=True)
class Window:
    """One turn or one dwell.

    Attributes
    ----------
    name : str
        'turn z+', 'azimuth 180', 'z up 1'.
    start, length : float
        [s], the start counted from the first window of the triad.
    axis : int or None
        Axis turned about, or vertical; 0, 1, 2 for x, y, z. None at an azimuth.
    sign : int
        +1 or -1: sense of the turn, or the axis up or down; 0 at an azimuth.
    azimuth : float or None
        Of a gyro dwell [rad].
    """

    name: str
    start: float
    length: float
    axis: int | None = None
    sign: int = 0
    azimuth: float | None = None


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """The windows of one triad in the order of time."""

    windows: tuple[Window, ...]

    @cached_property
    def starts(self) -> Array:
        """Starts, shape (n_windows,) [s]."""
        return np.array([window.start for window in self.windows])

    @cached_property
    def lengths(self) -> Array:
        """Lengths, shape (n_windows,) [s]."""
        return np.array([window.length for window in self.windows])

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


@lru_cache(maxsize=16)
def schedule_gyro(procedure: GyroProcedure) -> Schedule:
    """Lay out the rate turns, + before -, then the dwells: Zhao 2019, 1.2.1, 1.2.2."""
    turn = 2.0 * pi * procedure.turns / procedure.rate  # [s]
    turns = [
        (f"turn {axis}{'+' if sign > 0 else '-'}", turn, AXES.index(axis), sign, None)
        for axis in procedure.order
        for sign in (1, -1)
    ]
    dwells = [
        (f"azimuth {degrees(azimuth):.6g}", procedure.dwell, None, 0, azimuth)
        for azimuth in procedure.azimuths
    ]
    return _back_to_back([*turns, *dwells], procedure.pause)


@lru_cache(maxsize=16)
def schedule_accelerometer(procedure: AccelerometerProcedure) -> Schedule:
    """Lay out the twelve dwells, each face twice in a row: Zhao 2019, 1.2.3."""
    faces = [
        (
            f"{axis} {'up' if sign > 0 else 'down'} {visit}",
            procedure.dwell,
            AXES.index(axis),
            sign,
            None,
        )
        for axis in FACE_ORDER
        for sign in (1, -1)
        for visit in (1, 2)  # the second time turned 180 deg about the vertical
    ]
    return _back_to_back(faces, procedure.pause)


def _back_to_back(
    steps: Sequence[tuple[str, float, int | None, int, float | None]], pause: float
) -> Schedule:
    """Give each step (name, length, axis, sign, azimuth) its start; pauses between."""
    starts = accumulate((length + pause for _, length, *_ in steps), initial=0.0)
    return Schedule(
        windows=tuple(
            Window(
                name=name,
                start=start,
                length=length,
                axis=axis,
                sign=sign,
                azimuth=azimuth,
            )
            for (name, length, axis, sign, azimuth), start in zip(
                steps, starts, strict=False
            )
        )
    )
