"""Timing of a test: rate and turns of the table, clock, edges of windows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, TableState, Triad
from budget.model.windows import ANGLE, EDGES_BY_TIME

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act


@dataclass(frozen=True)
class TurnAngle(Disturbance):
    """A turn of length L by eps too much, eps of each turn on its own.

    A gyro is put in du = eps/L along the axis. An accelerometer stands longer where
    the turn ends: du = (f_end - f) eps/A, f its mean force over the angle A, so a turn
    about the vertical is not felt. What the earth rate does likewise is left out: 2e-4
    of the first at 20 deg/s. Squares of eps are left out too. Where
    what was turned is found it is no error.
    """

    needs = "sources.level_turns"

    def size(self, given: Given, scheme: Scheme | None) -> int:
        """Return the number of turns."""
        if scheme is None:
            return given.u.size
        return max(1, len(scheme.schedule.turn_starts))

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M du, weighed; None where the triad feels no turn."""
        scheme = triad.scheme
        turns = scheme.schedule.turns
        places = list(turns)
        windows = [scheme.schedule.windows[k] for k in places]
        if not windows or not scheme.knows_turns:
            return None
        # du of an angle error of 1 rad, (m, 3)
        if scheme.turn.any():
            per_angle = np.array([w.setting.turn_axis / w.length for w in windows])
        else:
            end = [w.setting.after(w.setting.angle).to_body for w in windows]
            more = np.array(end) @ scheme.gravity - scheme.force[places]
            per_angle = more / np.array([[w.setting.angle] for w in windows])
        shown = scheme.weights[:, :, places, None] * per_angle  # (3, 4, m, 3)
        if not shown.any():
            return None

        return partial(_turned, shown=shown, rows=tuple(turns.values()))

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with the angle that it really turns."""
        if table.turn is None:
            return table
        return replace(table, angle=table.angle + value[table.turn])


def _turned(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    shown: Array,
    rows: tuple[int, ...],
) -> Array:
    """Return M du, summed over the turns, whose errors are these rows of x."""
    seen = [truth.see(shown[:, :, k]) for k in range(shown.shape[2])]
    return np.asarray(sum(v * x[row] for v, row in zip(seen, rows, strict=True)))


@dataclass(frozen=True)
class RateError(Disturbance):
    """The table turns by rho faster than it says, in all turns alike.

    Where scale factors are taken from the rate, every turn is too large by rho, as in
    TurnAngle: dk = rho of gyros, 1 to 1, and db = -rho (b + input). Where they are from
    whole angles, whose time is measured, there is nothing.
    """

    needs = "sources.rate"

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return what turns do that are too large in proportion."""
        if triad.scheme.timing.scale_from == ANGLE:
            return None
        act = TurnAngle().bind(given, triad)
        return act and partial(_in_proportion, act=act, angles=_angles(triad.scheme))

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with the angle that it turns in the time."""
        if table.timing.scale_from == ANGLE:
            return table
        return replace(table, angle=table.angle * (1.0 + value[0]))


@dataclass(frozen=True)
class Clock(Disturbance):
    """The clock counts 1 + delta s in a second: readings are too small by that factor.

    dk = -delta of accelerometers; db = -delta (b + input) of gyros. A turn that is
    known by its angle ends when it ends, so its rate follows the clock too; where scale
    factors are taken from the rate, turns are too small in proportion and dk = -delta
    of gyros. Products with noise are left out.
    """

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return -delta/(1 + delta) (M u + b), weighed, u without turns by angle."""
        scheme = triad.scheme
        by_rate = scheme.timing.scale_from != ANGLE
        return partial(
            _slowed,
            shown=scheme.weigh(scheme.standing),
            total=scheme.weights.sum(axis=2),
            act=TurnAngle().bind(given, triad) if by_rate else None,
            angles=_angles(scheme),
        )

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table in windows that are really shorter."""
        pace = 1.0 / (1.0 + value[0])
        angle = table.angle
        if table.timing.scale_from != ANGLE:
            angle *= pace
        return replace(table, pace=table.pace * pace, angle=angle)


def _angles(scheme: Scheme) -> Array:
    """Return the angles of the turns of all triads; 0 of those of others [rad]."""
    angles = np.zeros(max(1, len(scheme.schedule.turn_starts)))
    for place, number in scheme.schedule.turns.items():
        angles[number] = scheme.schedule.windows[place].setting.angle
    return angles


def _in_proportion(
    x: Array, truth: Truth, noise: Array, *, act: Act, angles: Array
) -> Array:
    """Return what turns do that are too large by x of their angle."""
    return act(x[:1] * angles[:, None], truth, noise)


def _slowed(
    x: Array,
    truth: Truth,
    noise: Array,
    *,
    shown: Array,
    total: Array,
    act: Act | None,
    angles: Array,
) -> Array:
    """Return -delta/(1 + delta) (M u + b), weighed, and what turns are too small."""
    part = -1.0 * x / (1.0 + x)
    slowed = (truth.see(shown) + total[:, :, None] * truth.bias[:, None]) * part[0]
    if act is None:
        return np.asarray(slowed)
    turned = _in_proportion(part, truth, noise, act=act, angles=angles)
    return np.asarray(slowed + turned)


@dataclass(frozen=True)
class EdgeJitter(TurnAngle):
    """Edges of windows on a table that moves, each off by t on its own.

    Between them the table turns by eps = rate (t_end - t_start) more: u(dk) = sigma_t/T
    of a pair of turns of length T: 1 ms at 18 s is 55.6 ppm, half a sample at 100 Hz
    (uniform, 5 ms either way) 160.375 ppm. Edges at an index of the table, or at rest
    before and after it moves, make nothing.
    """

    needs = "sources.timed_windows"

    def size(self, given: Given, scheme: Scheme | None) -> int:
        """Return the number of edges: a start and an end for each turn."""
        return 2 * super().size(given, scheme)

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return what the angles do that lie between the edges."""
        scheme = triad.scheme
        act = super().bind(given, triad)
        if act is None or scheme.timing.edges != EDGES_BY_TIME:
            return None
        rates = np.zeros_like(_angles(scheme))
        for place, number in scheme.schedule.turns.items():
            window = scheme.schedule.windows[place]
            rates[number] = window.setting.angle / window.length
        return partial(_cut, act=act, rates=rates)

    def table(self, value: Array, table: TableState) -> TableState:
        """Return the table with the angle that it turns between the edges."""
        if table.turn is None or table.timing.edges != EDGES_BY_TIME:
            return table
        start, end = value[2 * table.turn : 2 * table.turn + 2]
        return replace(table, angle=table.angle * (1.0 + (end - start) / table.length))


def _cut(x: Array, truth: Truth, noise: Array, *, act: Act, rates: Array) -> Array:
    """Return what turns show whose edges are off by x, start and end in turn."""
    return act((x[1::2] - x[0::2]) * rates[:, None], truth, noise)
