"""Place of a test: latitude, height, gravity and earth rate, stated or true."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import ROTATION_RATE, gravity_by_height, gravity_by_latitude

if TYPE_CHECKING:
    from budget.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Place:
    """What a test takes the place for, or what the place is.

    Attributes
    ----------
    latitude : float
        Geodetic [rad].
    gravity : float
        [m/s^2].
    height : float
        Above the ellipsoid [m].
    is_normal : bool
        Whether gravity is the normal one of latitude and height, and not measured.
    earth_rate : float
        [rad/s].
    azimuth : float or None
        Of the zero of azimuths, from north to west [rad]; None: nobody knows it.
    """

    latitude: float
    gravity: float
    height: float = 0.0
    is_normal: bool = False
    earth_rate: float = ROTATION_RATE
    azimuth: float | None = 0.0

    @property
    def horizontal(self) -> float:
        """Earth rate about north [rad/s]."""
        return float(self.earth_rate * np.cos(self.latitude))

    @cached_property
    def earth(self) -> Array:
        """Earth rate that is known, shape (3,) [rad/s].

        East-north-up of a table whose zero is to the north; else by its zero. Of an
        azimuth that nobody knows the vertical part alone.
        """
        vertical = self.earth_rate * np.sin(self.latitude)
        h = 0.0 if self.azimuth is None else self.horizontal
        a = self.azimuth or 0.0
        return np.array([h * np.sin(a), h * np.cos(a), vertical])

    @property
    def leaning(self) -> Array:
        """Earth rate that tilts act by, shape (3,) [rad/s].

        Of an azimuth that nobody knows that at 45 deg, whose parts are the rms of all.
        """
        known = self.azimuth is not None
        return self.earth if known else replace(self, azimuth=pi / 4.0).earth

    @cached_property
    def force(self) -> Array:
        """Specific force of gravity, east-north-up, shape (3,) [m/s^2]."""
        return np.array([0.0, 0.0, self.gravity])

    @property
    def gravity_by_latitude(self) -> float:
        """dg/dL of the gravity that is used [m/s^2 per rad]; 0 of a measured one."""
        if not self.is_normal:
            return 0.0
        return gravity_by_latitude(self.latitude, self.height)

    @property
    def gravity_by_height(self) -> float:
        """dg/dh of the gravity that is used [1/s^2]; 0 of a measured one."""
        if not self.is_normal:
            return 0.0
        return gravity_by_height(self.latitude, self.height)
