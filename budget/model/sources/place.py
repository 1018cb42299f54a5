"""Knowledge of the place: latitude, height, gravity, earth rate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import pi
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from budget.earth import normal_gravity
from budget.model.source import GYRO, Disturbance, Given, TableState, Triad
from budget.model.sources.rotation import BASE, Rotation

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.place import Place
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act

# What a procedure says of azimuths: of none, or of all but their zero.
UNKNOWN, ZERO_UNKNOWN = "unknown", "zero_unknown"


@dataclass(frozen=True)
class LocalGravity(Disturbance):
    """Gravity used minus gravity: du = -R^T (0, 0, dg).

    dk = -dg/g and db = b dg/g of accelerometers: 1 mGal is -1.02075 ppm.
    """

    needs = "sources.accelerometers"

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M du, weighed."""
        slope = self.slope(triad.scheme.place)
        if triad.scheme.owner == GYRO or not slope:
            return None
        return _less(triad.scheme, np.array([0.0, 0.0, slope]))

    def slope(self, place: Place) -> float:  # noqa: ARG002
        """Return the change of the gravity that is used by 1 of the input [SI]."""
        return 1.0

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table at the gravity that is there."""
        place = table.place
        there = replace(place, gravity=place.gravity - value[0])
        return replace(table, place=there)


@dataclass(frozen=True)
class Height(LocalGravity):
    """Height used minus height: normal gravity changes, dk = 31.5 ppm per 100 m.

    To first order; the second is 7e-10 at 100 m. A measured gravity knows no height.
    """

    needs = "sources.normal_gravity"

    def slope(self, place: Place) -> float:
        """Return the vertical gradient of normal gravity [1/s^2]."""
        return place.gravity_by_height

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table at the height that it has."""
        place = table.place
        return replace(
            table, place=_moved(place, place.latitude, place.height - value[0])
        )


@dataclass(frozen=True)
class Latitude(LocalGravity):
    """Latitude used minus latitude: the earth rate leans about east by it.

    db_z = -w_h dL of gyros: +1 arcmin is -3.617010e-3 deg/h at 34.2394 deg. Normal
    gravity changes with it, to first order: dk = -1.4 ppm there.
    """

    needs = "sources.latitude"

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return M du, weighed: a rotation for gyros, gravity for accelerometers."""
        place = triad.scheme.place
        if triad.scheme.owner == GYRO and place.azimuth is None:
            return _less(triad.scheme, np.array([0.0, 0.0, place.horizontal]))
        if triad.scheme.owner == GYRO:
            return Rotation(BASE, 0).bind(given, triad)
        return super().bind(given, triad)

    def slope(self, place: Place) -> float:
        """Return the change of normal gravity with latitude [m/s^2 per rad]."""
        return place.gravity_by_latitude

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table at the latitude that it has."""
        place = table.place
        return replace(
            table, place=_moved(place, place.latitude - value[0], place.height)
        )


@dataclass(frozen=True)
class EarthRate(Disturbance):
    """Earth rate used minus earth rate, along its axis.

    15 deg/h for it, 0.0410686 deg/h too small, makes db_z = +0.0231064 deg/h.
    """

    needs = "sources.earth_rate"

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M du, weighed."""
        if triad.scheme.owner != GYRO:
            return None
        place = triad.scheme.place
        return _less(triad.scheme, place.earth / place.earth_rate)

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table on the earth as it turns."""
        rate = table.place.earth_rate - value[0]
        return replace(table, place=replace(table.place, earth_rate=rate))


@dataclass(frozen=True)
class UnknownAzimuth(Disturbance):
    """The horizontal earth rate at a heading that nobody knows: du = S^T (e, n, 0).

    e = w_h sin(a) and n = w_h cos(a), w_h = w cos(latitude), a uniform on the circle:
    means 0, variances w_h^2/2, no covariance, arcsine each. By hand the unit is put
    down anew at each stop, so that a is independent from stop to stop; windows one
    after the other at the same angles are one. Where azimuths are right among one
    another and their zero alone is not known, `is_one`, there is one a in all, which
    who finds a gyro by turns between dwells finds with its parameters.

    At 34.2394 deg 8.792418 deg/h; of six faces, each its stop, a third of that in a
    bias: four of six windows have the axis level.
    """

    needs: ClassVar[str] = "sources.level_gyro"
    formula: ClassVar[str] = "u^2 = (omega cos phi)^2/2"
    letters: ClassVar[str] = "sources.unknown_azimuth"
    removed_by_norm = "sources.norm"

    is_one: bool = False

    def size(self, given: Given, scheme: Scheme | None) -> int:
        """Return how many parts there are, two at each stop."""
        if scheme is None:
            return given.u.size
        return 2 * (1 if self.is_one else scheme.schedule.n_stops)

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M du, weighed."""
        scheme = triad.scheme
        if scheme.owner != GYRO:
            return None
        level = scheme.schedule.to_body[..., :2]  # (n, 3, 2)
        places: dict[int, list[int]] = {}
        for place, stop in scheme.schedule.stops.items():
            places.setdefault(0 if self.is_one else stop, []).append(place)
        parts = []
        for stop, own in places.items():
            for part in range(2):
                put_in = np.zeros((len(level), 3))
                put_in[own] = level[own, :, part]
                shown = scheme.weigh(put_in)
                if shown.any():
                    parts.append((2 * stop + part, shown))
        return partial(_put_in_each, parts=tuple(parts)) if parts else None

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table at the heading that it has: the sine, the other's sign."""
        first = 0 if self.is_one else 2 * table.stop
        largest = table.place.horizontal
        sine = np.clip(value[first] / largest, -1.0, 1.0) if largest else 0.0
        a = float(np.arcsin(sine))
        a = a if value[first + 1] >= 0.0 else pi - a
        return replace(table, place=replace(table.place, azimuth=a))


def _put_in_each(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    parts: tuple[tuple[int, Array], ...],
) -> Array:
    """Return M du, summed over the inputs."""
    return np.asarray(sum(truth.see(shown) * x[row] for row, shown in parts))


def _moved(place: Place, latitude: float, height: float) -> Place:
    """Return a place elsewhere; a measured gravity is that of the test."""
    more = 0.0
    if place.is_normal:
        more = normal_gravity(latitude, height)
        more -= normal_gravity(place.latitude, place.height)
    return replace(
        place, latitude=latitude, height=height, gravity=place.gravity + more
    )


def _less(scheme: Scheme, direction: Array) -> Act:
    """Return what takes an east-north-up vector times x off what is put in."""
    shown = scheme.weigh(-1.0 * (scheme.schedule.to_body @ direction))
    return partial(_put_in, shown=shown)


def _put_in(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    shown: Array,
) -> Array:
    """Return M du, weighed, of an input of size x."""
    return np.asarray(truth.see(shown) * x[0])
