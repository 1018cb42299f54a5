"""Knowledge of the place: latitude, height, gravity, earth rate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

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
