"""Angle error of a turn of the table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, TableState, Triad

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
