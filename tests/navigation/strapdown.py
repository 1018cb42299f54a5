"""A full strapdown navigator on the ellipsoid, for many units at once.

No error equation: attitude, velocity and place are integrated as they stand, by Runge
and Kutta's fourth order, of the rates and forces that each unit senses. Groves 2013,
Principles of GNSS, inertial, and multisensor integrated navigation systems, section
5.4; the formulas here are its own, of the package only constants are taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from budget import earth

A, E2 = earth.SEMI_MAJOR_AXIS, earth.ECCENTRICITY_SQUARED
STAGES = 3  # begin, middle and end of a step


@dataclass(frozen=True, kw_only=True)
class Motion:
    """What an ideal unit senses, in steps, and where it begins.

    `rate` and `force` have the shape (steps, 3, 3): at the begin, middle and end of
    each step, in right, forward, up; `body` those axes as columns, north, east, down.
    """

    durations: np.ndarray
    rate: np.ndarray
    force: np.ndarray
    latitude: float
    height: float
    velocity: np.ndarray
    body: np.ndarray


@dataclass
class State:
    """What navigators believe: arrays whose first axis counts them."""

    body: np.ndarray
    velocity: np.ndarray
    place: np.ndarray  # latitude, longitude, height

    def moved(self, slope, time):
        """Return it after a time at these slopes."""
        return State(
            self.body + time * slope.body,
            self.velocity + time * slope.velocity,
            self.place + time * slope.place,
        )


def radii(latitude, height):
    """Return those of curvature, north and east, at a height."""
    curved = 1.0 - E2 * np.sin(latitude) ** 2
    return A * (1.0 - E2) / curved**1.5 + height, A / np.sqrt(curved) + height


def gravity(latitude, height):
    """Return Somigliana's normal gravity, with its fall by height."""
    s2 = np.sin(latitude) ** 2
    ground = earth.EQUATORIAL_GRAVITY * (1.0 + earth.GRAVITY_CONSTANT * s2)
    ground = ground / np.sqrt(1.0 - E2 * s2)
    f, m = earth.FLATTENING, earth.CENTRIFUGAL_RATIO
    slope = 2.0 / A * (1.0 + f + m - 2.0 * f * s2)
    return ground * (1.0 - slope * height + 3.0 * (height / A) ** 2)


def cross(a, b):
    """Return vector products: numpy's own spends most of its time on the axes."""
    (x, y, z), (u, v, w) = ([one[..., i] for i in range(3)] for one in (a, b))
    found = np.empty(np.broadcast(a, b).shape)
    found[..., 0] = y * w - z * v
    found[..., 1] = z * u - x * w
    found[..., 2] = x * v - y * u
    return found


def slope_of(state, rate, force, *, aided):
    """Return the time derivatives of all that navigators believe."""
    L, h = state.place[:, 0], state.place[:, 2]
    north, east, down = state.velocity.T
    R_n, R_e = radii(L, h)
    spin = earth.ROTATION_RATE * np.stack([np.cos(L), 0.0 * L, -np.sin(L)], axis=1)
    carried = np.stack([east / R_e, -north / R_n, -east * np.tan(L) / R_e], axis=1)
    turn_body = cross(rate[:, None], state.body)  # rows of C [w x]: row x w ...
    turn_body = -turn_body  # ... and r [w x] = -(w x r)
    turn_frame = cross((spin + carried)[:, None], state.body.swapaxes(1, 2))
    velocity = np.einsum("nij,nj->ni", state.body, force)
    velocity = velocity - cross(2.0 * spin + carried, state.velocity)
    velocity[:, 2] += gravity(L, h)
    place = np.stack([north / R_n, east / (R_e * np.cos(L)), -down], axis=1)
    if aided:
        velocity[:, 2] = place[:, 2] = 0.0
    return State(turn_body - turn_frame.swapaxes(1, 2), velocity, place)


def aligned(rate, force):
    """Return the attitude that explains what a unit at rest senses."""
    down = -force / np.linalg.norm(force, axis=1, keepdims=True)
    east = np.cross(down, rate)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    return np.stack([np.cross(east, down), east, down], axis=1)


def navigate(motion, errors, begin, stops, *, aided=True):
    """Return states at the ends of some steps.

    `errors(step, sensed)` gives what is added to (..., 6) sensed rates and forces, each
    run its own, shape (runs, 6); `begin` the attitudes at the start, (runs, 3, 3).
    """
    runs = len(begin)
    state = State(
        begin.copy(),
        np.tile(motion.velocity, (runs, 1)),
        np.tile([motion.latitude, 0.0, motion.height], (runs, 1)),
    )
    found = []
    for step, h in enumerate(motion.durations):
        sensed = []
        for stage in range(STAGES):
            ideal = np.concatenate(
                [motion.rate[step, stage], motion.force[step, stage]]
            )
            sensed.append(ideal + errors(step, ideal))
        a, b, c = ((one[:, :3], one[:, 3:]) for one in sensed)
        k1 = slope_of(state, *a, aided=aided)
        k2 = slope_of(state.moved(k1, h / 2), *b, aided=aided)
        k3 = slope_of(state.moved(k2, h / 2), *b, aided=aided)
        k4 = slope_of(state.moved(k3, h), *c, aided=aided)
        for slope, weight in ((k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)):
            state = state.moved(slope, h * weight / 6.0)
        if step in stops:
            found.append(state)
    return found


def seen(state, true):
    """Return errors against one state: place [m], velocity, roll, pitch, heading."""
    R_n, R_e = radii(true.place[:, 0], true.place[:, 2])
    scale = np.stack([R_n, R_e * np.cos(true.place[:, 0]), -np.ones_like(R_n)], axis=1)
    angles = euler(state.body) - euler(true.body)
    angles = (angles + np.pi) % (2.0 * np.pi) - np.pi
    place = (state.place - true.place) * scale
    return np.concatenate([place, state.velocity - true.velocity, angles], axis=1)


def euler(body):
    """Return roll, pitch and heading of right, forward, up axes as columns."""
    right, forward, up = np.moveaxis(body, -1, 0)
    roll = np.arctan2(right[:, 2], -up[:, 2])
    pitch = np.arctan2(-forward[:, 2], np.hypot(forward[:, 0], forward[:, 1]))
    return np.stack([roll, pitch, np.arctan2(forward[:, 1], forward[:, 0])], axis=1)
