"""How errors of an inertial navigator grow: its linear equations at one moment.

The modified phi-angle model (Scherzinger and Reid 1994, 'Modified strapdown inertial
navigator error models'): the velocity error is taken in the frame that the navigator
believes in, so gravity stands where other models have the specific force, and the
equations change only as velocity and latitude do. States are the errors of position
[m], velocity [m/s] and attitude [rad], each north, east, down. All of first order is
there; what that paper and filters leave out, as too small for minutes, is put in
_by_place: it turns the position by v tan(L)/R t, 14 % in an hour at 250 m/s and 45 deg.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from math import cos, sin, tan
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import (
    ECCENTRICITY_SQUARED,
    ROTATION_RATE,
    gravity_by_height,
    gravity_by_latitude,
    meridian_radius,
    normal_gravity,
    normal_radius,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array

POSITION, VELOCITY, ATTITUDE = slice(0, 3), slice(3, 6), slice(6, 9)
STATES = 9
INPUTS = 6  # errors of gyros x, y, z and accelerometers x, y, z
# Rows that select the states that are free, with the altitude aided and not.
FREE = {False: np.eye(STATES), True: np.delete(np.eye(STATES), [2, 5], axis=0)}


@dataclass(frozen=True, kw_only=True, eq=False)
class Moment:
    """Where a vehicle is, and how it moves: at one moment, or at many in an array.

    Attributes
    ----------
    latitude, height : ndarray, shape (...)
        Geodetic, and above the ellipsoid [rad, m].
    velocity : ndarray, shape (..., 3)
        North, east, down [m/s].
    acceleration : ndarray, shape (..., 3)
        Its time derivative, north, east, down [m/s^2].
    body : ndarray, shape (..., 3, 3)
        Body axes right, forward, up as columns, north, east, down.
    turning : ndarray, shape (..., 3)
        Rate at which they turn against north, east, down, along these [rad/s].
    time : ndarray, shape (...)
        From the mission's start [s].
    """

    latitude: Array
    height: Array
    velocity: Array
    acceleration: Array
    body: Array
    turning: Array
    time: Array

    def some(self, rows: slice) -> Moment:
        """Return some of many moments, by their first index."""
        return Moment(
            **{one.name: getattr(self, one.name)[rows] for one in fields(self)}
        )

    @property
    def at_rest(self) -> Moment:
        """The same place and attitude, at rest."""
        rest = np.zeros_like(self.velocity)
        return replace(self, velocity=rest, acceleration=rest, turning=rest)

    @cached_property
    def radii(self) -> tuple[Array, Array]:
        """Of a move north and of one east, at this height, shape (...) [m]."""
        north = each(meridian_radius, self.latitude) + self.height
        return north, each(normal_radius, self.latitude) + self.height

    @cached_property
    def curvature(self) -> Array:
        """Rotation of the local level for a shift, shape (..., 3, 3) [rad/m]."""
        north, east = self.radii
        K = np.zeros((*east.shape, 3, 3))
        K[..., 0, 1] = 1.0 / east
        K[..., 1, 0] = -1.0 / north
        K[..., 2, 1] = -each(tan, self.latitude) / east
        return K

    @cached_property
    def transport(self) -> Array:
        """Rotation of the local level by motion, shape (..., 3) [rad/s]."""
        return np.asarray((self.curvature @ self.velocity[..., None])[..., 0])

    @cached_property
    def earth_rate(self) -> Array:
        """Rotation of the earth, north, east, down, shape (..., 3) [rad/s]."""
        north, down = each(cos, self.latitude), -each(sin, self.latitude)
        return ROTATION_RATE * np.stack([north, np.zeros_like(north), down], axis=-1)

    @cached_property
    def gravity(self) -> Array:
        """Normal gravity, north, east, down, shape (..., 3) [m/s^2]."""
        down = each(normal_gravity, self.latitude, self.height)
        return np.asarray(down[..., None] * np.array([0.0, 0.0, 1.0]))

    @cached_property
    def rate(self) -> Array:
        """What gyros sense, x, y, z, shape (..., 3) [rad/s]."""
        return self._along_body(self.earth_rate + self.transport + self.turning)

    @cached_property
    def force(self) -> Array:
        """What accelerometers sense, x, y, z, shape (..., 3) [m/s^2]."""
        coriolis = np.cross(2.0 * self.earth_rate + self.transport, self.velocity)
        return self._along_body(self.acceleration + coriolis - self.gravity)

    def dynamics(self, *, aided: bool) -> Array:
        """Return F of x' = F x + G e, shape (..., n, n): n is 9, or 7 aided."""
        F = np.zeros((*self.latitude.shape, STATES, STATES))
        motion = cross_matrix(self.velocity)
        F[..., POSITION, VELOCITY] = np.eye(3)
        F[..., POSITION, ATTITUDE] = motion
        F[..., VELOCITY, VELOCITY] = -cross_matrix(
            2.0 * self.earth_rate + self.transport
        )
        F[..., VELOCITY, ATTITUDE] = -cross_matrix(self.gravity)
        F[..., VELOCITY, ATTITUDE] -= motion @ cross_matrix(self.earth_rate)
        F[..., ATTITUDE, VELOCITY] = self.curvature
        F[..., ATTITUDE, ATTITUDE] = self.curvature @ motion
        F[..., ATTITUDE, ATTITUDE] -= cross_matrix(self.earth_rate + self.transport)
        F[..., POSITION] += self._by_place()
        return np.asarray(FREE[aided] @ F @ self._whole(aided=aided))

    def entry(self, *, aided: bool) -> Array:
        """Return G, shape (..., n, 6): where errors of gyros, accelerometers go."""
        G = np.zeros((*self.latitude.shape, STATES, INPUTS))
        G[..., VELOCITY, :3] = cross_matrix(self.velocity) @ self.body
        G[..., ATTITUDE, :3] = -self.body
        G[..., VELOCITY, 3:] = self.body
        return np.asarray(FREE[aided] @ G)

    def seen(self, *, aided: bool) -> Array:
        """Return C, shape (..., 9, n): what is asked for, of the states.

        Errors of position and velocity, north, east, down, and of roll, pitch and
        heading, which turn about the forward axis, the level axis to the right of it,
        and down.
        """
        C = np.zeros((*self.latitude.shape, STATES, STATES))
        C[...] = np.eye(STATES)
        C[..., VELOCITY, ATTITUDE] = cross_matrix(self.velocity)
        north, east, down = np.moveaxis(self.body[..., 1], -1, 0)
        level = np.hypot(north, east)
        c, s = north / level, east / level
        angles = np.zeros((*level.shape, 3, 3))
        angles[..., 0, 0], angles[..., 0, 1] = c / level, s / level
        angles[..., 1, 0], angles[..., 1, 1] = -s, c
        angles[..., 2, 0], angles[..., 2, 1] = -down / level * c, -down / level * s
        angles[..., 2, 2] = 1.0
        C[..., ATTITUDE, ATTITUDE] = -angles
        return np.asarray(C @ self._whole(aided=aided))

    def measured(self, *, aided: bool) -> Array:
        """Return what aids measure of the states, shape (..., 10, n).

        What is seen, and last the error of the forward speed as wheels have it, in body
        axes: f . (dv - v x phi), f the forward axis.
        """
        ahead = self.body[..., None, :, 1] @ self._whole(aided=aided)[..., VELOCITY, :]
        return np.concatenate([self.seen(aided=aided), ahead], axis=-2)

    def given(self, *, aided: bool) -> Array:
        """Return the states of errors that are given, shape (..., n, 9).

        Of position, velocity, and attitude about north, east, down.
        """
        T = np.zeros((*self.latitude.shape, STATES, STATES))
        T[...] = np.eye(STATES)
        T[..., VELOCITY, ATTITUDE] = -cross_matrix(self.velocity)
        return np.asarray(FREE[aided] @ T)

    def aligned(self, *, aided: bool) -> Array:
        """Return the states that self-alignment finds, of mean errors, (..., n, 6).

        Level is where the accelerometers sense no force: phi_E = -a_N/g, phi_N = a_E/g;
        north is where the gyros sense no rate from the east: phi_D = e_E/(W cos L) -
        phi_N tan L, W the rate of the earth.
        """
        g = self.gravity[..., 2, None]
        north, down = self.earth_rate[..., 0, None], self.earth_rate[..., 2, None]
        M = np.zeros((*self.latitude.shape, STATES, INPUTS))
        M[..., 6, 3:] = self.body[..., 1, :] / g
        M[..., 7, 3:] = -self.body[..., 0, :] / g
        M[..., 8, :3] = self.body[..., 1, :] / north
        M[..., 8, :] += M[..., 6, :] * down / north
        return np.asarray(FREE[aided] @ M)

    def _by_place(self) -> Array:
        """Return what errors of position do, shape (..., 9, 3).

        Derivatives of rates, Coriolis force and gravity; and the errors of position
        themselves are angles times radii that change on the way.
        """
        north, east = self.radii
        v_n, v_e, v_d = np.moveaxis(self.velocity, -1, 0)
        t = each(tan, self.latitude)
        B = np.zeros((*t.shape, STATES, 3))
        B[..., 0, 0], B[..., 0, 2] = -v_d / north, v_n / north
        B[..., 1, 0], B[..., 1, 1] = v_e * t / east, -(v_n * t + v_d) / east
        B[..., 1, 2] = v_e / east
        turned = cross_matrix(self.earth_rate) @ self.curvature
        B[..., VELOCITY, :] = cross_matrix(self.velocity) @ turned
        B[..., 5, 0] += each(gravity_by_latitude, self.latitude, self.height) / north
        # Gravity falls with height: the vertical channel is unstable.
        B[..., 5, 2] -= each(gravity_by_height, self.latitude, self.height)
        B[..., ATTITUDE, :] = turned
        # Of the transport rate (v_E/R_E, -v_N/R_N, -v_E tan(L)/R_E); dR_E/dL is
        # tan(L) (R_E - R_N).
        grows = t * (east - north)
        s = each(sin, self.latitude)
        curved = 1.0 - ECCENTRICITY_SQUARED * s**2
        bends = 3.0 * ECCENTRICITY_SQUARED * s * each(cos, self.latitude) / curved
        B[..., 6, 0] -= v_e * grows / east**2 / north
        B[..., 6, 2] += v_e / east**2
        B[..., 7, 0] += v_n * bends * (north - self.height) / north**3
        B[..., 7, 2] -= v_n / north**2
        B[..., 8, 0] -= v_e * (1.0 + t**2 - t * grows / east) / east / north
        B[..., 8, 2] -= v_e * t / east**2
        return B

    def _along_body(self, v: Array) -> Array:
        """Return the components of vectors along the body's axes."""
        return np.asarray((self.body.swapaxes(-1, -2) @ v[..., None])[..., 0])

    def _whole(self, *, aided: bool) -> Array:
        """Return all nine states of the free ones, shape (..., 9, n).

        With the altitude aided the errors of height and vertical velocity are 0, so
        that of the sixth state follows from attitude: v_E phi_N - v_N phi_E.
        """
        T = np.zeros((*self.latitude.shape, *FREE[aided].T.shape))
        T[...] = FREE[aided].T
        if aided:
            T[..., 5, 4], T[..., 5, 5] = self.velocity[..., 1], -self.velocity[..., 0]
        return T


def level_body(heading: Array) -> Array:
    """Return right, forward and up of a level vehicle as columns, (..., 3, 3)."""
    s, c = each(sin, heading), each(cos, heading)
    body = np.zeros((*s.shape, 3, 3))
    body[..., 0, 0], body[..., 0, 1] = -s, c
    body[..., 1, 0], body[..., 1, 1] = c, s
    body[..., 2, 2] = -1.0
    return body


def cross_matrix(v: Array) -> Array:
    """Return [v x], shape (..., 3, 3): times u it is the cross product of v and u."""
    M = np.zeros((*v.shape, 3))
    M[..., 2, 1] = v[..., 0]
    M[..., 0, 2] = v[..., 1]
    M[..., 1, 0] = v[..., 2]
    return np.asarray(M - M.swapaxes(-1, -2))


def each(function: Callable[..., float], *arrays: Array) -> Array:
    """Return a function of floats of every element: the same on every processor."""
    return np.asarray(np.vectorize(function, otypes=[float])(*arrays))
