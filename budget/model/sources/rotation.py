"""Alignment errors of a three-axis table: base, axes and mount."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from budget.model.source import GYRO, Disturbance, Given, TableState, Triad
from budget.model.windows import CHAIN

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act
    from budget.model.windows import Schedule

BASE, AFTER_OUTER, AFTER_MIDDLE, BODY = range(4)  # joints of the chain


class Joint(NamedTuple):
    """Where one input turns what: a joint, a coordinate axis of it, some windows."""

    joint: int
    axis: int
    places: tuple[int, ...]


@dataclass(frozen=True)
class Rotation(Disturbance):
    """An extra rotation by eps about a coordinate axis a, at one joint of the table.

    The table makes of east-north-up v the body's S^T P^T v, P the axes between the base
    and the joint, S those from there on: R = P S. With R' = P Rot(eps, a) S it is

        du = sin(eps) S^T (P^T v x a) - (1 - cos(eps)) S^T (P^T v - a (a.P^T v)),

    v the earth rate of gyros, gravity of accelerometers; a turn about an axis before
    the joint adds its rate to P^T v. Only P or S turns in a window, so the mean over it
    is the product of theirs. Exact for any angle of one source; what two rotations make
    together is left out: 60 arcsec times 60 arcsec is 0.017 arcsec.

    So 1 arcsec of `orthogonality.outer_middle` is 1 arcsec of yx of gyros; by a tilt
    about east the bias of the vertical gyro moves by -w_h: -6.02835e-5 deg/h an arcsec
    at a latitude of 34.2394 deg.
    To who knows no attitude none of it is an error; where turns are found only what the
    earth rate makes of it.

    Attributes
    ----------
    joint : int
        BASE, AFTER_OUTER, AFTER_MIDDLE or BODY.
    axis : int
        0, 1, 2 for x, y, z of the frame there; of the base east, north and up.
    """

    removed: ClassVar[str] = "sources.balance"
    removed_by_norm: ClassVar[str] = "sources.norm"

    joint: int
    axis: int

    def joints(self, given: Given, schedule: Schedule) -> tuple[Joint, ...]:  # noqa: ARG002
        """Return where each of the inputs acts."""
        return (Joint(self.joint, self.axis, tuple(range(len(schedule.windows)))),)

    def size(self, given: Given, scheme: Scheme | None) -> int:
        """Return how many rotations there are."""
        if scheme is None:
            return given.u.size
        return len(self.joints(given, scheme.schedule))

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return M du, weighed; None where nothing of it is left, or no attitude."""
        scheme = triad.scheme
        is_unknown = scheme.owner == GYRO and scheme.place.azimuth is None
        if not scheme.knows_attitudes or (is_unknown and self == AZIMUTH):
            return None
        parts = []
        for row, joint in enumerate(self.joints(given, scheme.schedule)):
            sine, versine = _weighed(scheme, joint)
            places = np.flatnonzero(sine.astype(bool) | versine.astype(bool))
            if places.size:
                parts.append(_Part(row, places, sine[places], versine[places]))
        if not parts:
            return None
        shape = (3, scheme.weights.shape[1], 3)
        return partial(_rotated, parts=tuple(parts), shape=shape)

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with that joint askew."""
        return table.askew(self.joint, self.axis, value[0])


AZIMUTH = Rotation(BASE, 2)


@dataclass(frozen=True)
class Mount(Rotation):
    """The body in its mount: three rotations, equal in gyros and accelerometers.

    yx = zx = m_x, xy = zy = m_y, xz = yz = m_z: the body frame as a whole is turned.
    """

    joint: int = BODY
    axis: int = 0

    def joints(self, given: Given, schedule: Schedule) -> tuple[Joint, ...]:  # noqa: ARG002
        """Return a rotation about each axis, in all windows."""
        every = tuple(range(len(schedule.windows)))
        return tuple(Joint(BODY, axis, every) for axis in range(3))

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with the body askew on it."""
        for axis in range(3):
            table = table.askew(BODY, axis, value[axis])
        return table


@dataclass(frozen=True)
class Positioning(Rotation):
    """Each axis of the table stands a little off at each stop, on its own.

    Inputs are outer, middle and inner of the first stop, of the second, and so on;
    windows one after the other at the same angles are one stop, turns from there too.
    One of four dwells about the vertical: db_x = w_h/4 (da_0 - da_180) by the outer
    axis; one of twelve dwells: 1/4 arcsec of an angle for 1 arcsec of middle or inner.
    """

    joint: int = BASE
    axis: int = 0

    def joints(self, given: Given, schedule: Schedule) -> tuple[Joint, ...]:  # noqa: ARG002
        """Return three rotations for each stop, each about its own axis."""
        places: list[list[int]] = [[] for _ in range(schedule.n_stops)]
        for place, stop in schedule.stops.items():
            places[stop].append(place)
        return tuple(
            Joint(1 + number, axis, tuple(own))
            for own in places
            for number, axis in enumerate(CHAIN)
        )

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table as its axes stand at this stop."""
        outer, middle, inner = value[3 * table.stop : 3 * table.stop + 3]
        table = table.askew(AFTER_OUTER, 2, outer).askew(AFTER_MIDDLE, 1, middle)
        return table.askew(BODY, 0, inner)


@dataclass(frozen=True)
class Wobble(Rotation):
    """The part of a rotor's wobble that turns with it: dd = rho of a gyro's angles.

    While an axis turns, what it carries leans by rho about the two directions across
    it, each on its own and the same in all turns about that axis. Where it stands still
    it is in positioning, orthogonality and mount.
    """

    needs = "sources.turns"
    removed = removed_by_norm = ""

    joint: int = BASE
    axis: int = 0

    def joints(self, given: Given, schedule: Schedule) -> tuple[Joint, ...]:  # noqa: ARG002
        """Return two rotations for each axis of the table, in its own turns."""
        settings = [window.setting for window in schedule.windows]
        return tuple(
            Joint(
                1 + number,
                across,
                tuple(k for k, one in enumerate(settings) if one.turning == axis),
            )
            for number, axis in enumerate(CHAIN)
            for across in range(3)
            if across != axis
        )

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with its rotor leaning, if it turns."""
        if table.turning is None:
            return table
        own = value[2 * table.turning : 2 * table.turning + 2]
        across = ((0, 1), (0, 2), (1, 2))[table.turning]
        for axis, angle in zip(across, own, strict=True):
            table = table.askew(1 + table.turning, axis, angle)
        return table


class _Part(NamedTuple):
    """What one input does: its row, and which entries of (3, m, 3) by how much."""

    row: int
    places: NDArray[np.intp]
    sine: Array
    versine: Array


def _weighed(scheme: Scheme, joint: Joint) -> tuple[Array, Array]:
    """Return the weighed parts of du in sin(eps) and 1 - cos(eps), flat (3 m 3,)."""
    windows = scheme.schedule.windows
    a = np.eye(3)[joint.axis]
    sine, versine = np.zeros((2, len(windows), 3))
    for place in joint.places:
        window = windows[place]
        v = window.setting.between(BASE, joint.joint) @ scheme.leaning
        if scheme.knows_turns and scheme.turn[place].any():
            rate = window.setting.angle / window.length
            v = v + window.setting.turn_axis_after(joint.joint) * rate
        onward = window.setting.between(joint.joint, BODY)
        sine[place] = onward @ np.cross(v, a)
        versine[place] = onward @ (v - a * v[joint.axis])
    return scheme.weigh(sine).ravel(), scheme.weigh(versine).ravel()


def _rotated(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    parts: tuple[_Part, ...],
    shape: tuple[int, int, int],
) -> Array:
    """Return M du, summed over the inputs."""
    shown = np.zeros((np.prod(shape), x.shape[1]), dtype=x.dtype)
    for row, places, sine, versine in parts:
        less = 2.0 * np.sin(0.5 * x[row]) ** 2
        shown[places] += sine[:, None] * np.sin(x[row]) - versine[:, None] * less
    return truth.see_each(shown.reshape(*shape, -1))
