"""Temperature and vibration that are known at every time of a mission.

A coefficient of the device that one of them acts by is a constant of the mission then:
what it is a change of, a bias or a scale factor, it changes by as much as the course
has at that time. All times are from the mission's start, and before it, while the unit
finds level and north, everything is as at the start.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array

FADED = 36  # times in which e^(-t/tau) is cut, each tau: what is left is rounding


class Course(Protocol):
    """A value at every time."""

    @abstractmethod
    def __hash__(self) -> int:
        """Return one number for equal ones."""

    @property
    def largest(self) -> float:
        """Its largest size [SI]."""

    @property
    def cuts(self) -> tuple[float, ...]:
        """Times between which it is smooth [s]."""

    def at(self, t: Array) -> Array:
        """Return it at those times [SI]."""

    def slope(self, t: Array) -> Array:
        """Return its time derivative at those times [SI/s]."""


@dataclass(frozen=True)
class Profile:
    """Linear between points, held constant before the first and after the last."""

    times: tuple[float, ...]  # rising [s]
    values: tuple[float, ...]

    @property
    def largest(self) -> float:
        """Largest size of a point."""
        return float(np.abs(self.values).max())

    @property
    def cuts(self) -> tuple[float, ...]:
        """Times of the points."""
        return self.times

    def at(self, t: Array) -> Array:
        """Return it at those times."""
        return np.asarray(np.interp(t, self.times, self.values))

    def slope(self, t: Array) -> Array:
        """Return the slope between two points, 0 beyond them."""
        slopes = np.diff(self.values) / np.diff(self.times)
        return np.pad(slopes, 1)[np.searchsorted(self.times, t, side="right")]


@dataclass(frozen=True)
class Fading:
    """-D e^(-t/tau): D below, or above where D is negative, what it ends at."""

    by: float  # D
    time: float  # tau [s]

    @property
    def largest(self) -> float:
        """That at the start."""
        return abs(self.by)

    @property
    def cuts(self) -> tuple[float, ...]:
        """A row of times so dense that a polynomial follows it."""
        return tuple(self.time * k for k in range(1, FADED + 1))

    def at(self, t: Array) -> Array:
        """Return it at those times."""
        return np.asarray(-self.by * np.exp(-t / self.time))

    def slope(self, t: Array) -> Array:
        """Return D/tau e^(-t/tau)."""
        return -self.at(t) / self.time


@dataclass(frozen=True)
class Stretches:
    """Constant from each begin to the next."""

    begins: tuple[float, ...]  # rising from 0 [s]
    values: tuple[float, ...]

    @property
    def largest(self) -> float:
        """Largest of them."""
        return max(self.values)

    @property
    def cuts(self) -> tuple[float, ...]:
        """Times at which it changes."""
        return self.begins

    def at(self, t: Array) -> Array:
        """Return it at those times."""
        place = np.searchsorted(self.begins, t, side="right") - 1
        return np.asarray(np.array(self.values)[place])

    def slope(self, t: Array) -> Array:
        """Return 0: between its steps it does not change."""
        return np.zeros_like(t)
