"""Angle error of a table's turn: what it turns more than it was told."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, Table, Triad

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act


@dataclass(frozen=True)
class TurnAngle(Disturbance):
    """du = eps/L along the axis of a turn of length L, eps of each turn on its own.

    The part of a turn beyond a whole one also turns the earth rate a little: second
    order, 1e-5 of the first, left out. An accelerometer does not feel a turn.
    """

    needs = "a gyro that is turned"

    def size(self, given: Given, scheme: Scheme | None) -> int:
        """Return the number of turns."""
        return given.u.size if scheme is None else max(1, _turns(scheme).size)

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M du, weighed; None where the triad feels no turn."""
        scheme = triad.scheme
        turns = _turns(scheme)
        if not scheme.turn.any():
            return None
        windows = scheme.schedule.windows
        # du of an angle error of 1 rad, (m, 3)
        per_angle = np.array([windows[k].setting.turn_axis for k in turns])
        per_angle = per_angle / scheme.schedule.lengths[turns, None]
        weights = scheme.weights[:, :, turns]
        shown = weights[..., None] * per_angle  # (3, 4, m, 3)

        return partial(_turned, shown=shown)

    def table(self, value: Array, table: Table) -> Table:
        """Return the table with the angle that it really turns."""
        if table.turn is None:
            return table
        return replace(table, angle=table.angle + value[table.turn])


def _turns(scheme: Scheme) -> NDArray[np.intp]:
    """Return the places of the windows that turn."""
    return np.flatnonzero(scheme.schedule.senses)


def _turned(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    shown: Array,
) -> Array:
    """Return M du, summed over the turns."""
    seen = [truth.see(shown[:, :, k]) for k in range(shown.shape[2])]
    return np.asarray(sum(v * x[k] for k, v in enumerate(seen)))
