"""What is done when: the windows over which the readings of one triad are averaged."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from budget.model.table import Setting

if TYPE_CHECKING:
    from budget.arrays import Array


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
    """

    name: str
    start: float
    length: float
    setting: Setting = field(default_factory=Setting)
    axis: int | None = None
    sign: int = 0
    azimuth: float | None = None

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

    @cached_property
    def middles(self) -> Array:
        """Times in the middle of the windows, shape (n_windows,) [s]."""
        return self.starts + self.lengths / 2.0

    @cached_property
    def senses(self) -> Array:
        """Signs of the turns, 0 of dwells, shape (n_windows,) [1]."""
        return np.array([float(window.sense) for window in self.windows])

    @cached_property
    def rates(self) -> Array:
        """Mean rates of the turns in body axes, shape (n_windows, 3) [rad/s]."""
        return np.array([window.rate for window in self.windows])

    @cached_property
    def to_body(self) -> Array:
        """Mean matrices from east-north-up to body axes, shape (n_windows, 3, 3)."""
        return np.array([window.setting.to_body for window in self.windows])

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
