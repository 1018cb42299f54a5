"""Levelling of a table: a tilt of its base against the horizon."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, Table, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act


@dataclass(frozen=True)
class Levelling(Disturbance):
    """The base is turned by phi about a horizontal axis; du = R^T (Rot(phi)^T - 1) v.

    v is the earth rate for gyros and gravity for accelerometers, east-north-up, R the
    table's attitude. Exact for any angle; both triads stand on the same base. To who
    knows no attitude it is no error.

    Attributes
    ----------
    axis : int
        0 for a rotation about east, 1 about north.
    """

    needs = "outputs that a tilt of the table moves (by the norm of gravity none is)"

    axis: int

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return M_i (sum W R^T) (Rot^T - 1) v; None where no attitude is known."""
        scheme = triad.scheme
        if not scheme.knows_attitudes:
            return None
        turned = scheme.weigh(scheme.schedule.to_body.reshape(-1, 9))
        turned = turned.reshape(3, -1, 3, 3)  # sum of W R^T, [axis, statistic]
        across = np.cross(scheme.ambient, np.eye(3)[self.axis])
        along = np.eye(3)[self.axis] * scheme.ambient[self.axis]
        # (Rot^T - 1) v = sin(phi) (v x a) + (cos(phi) - 1) (v - along)
        sine, versine = turned @ across, turned @ (scheme.ambient - along)

        return partial(_tilted, sine=sine, versine=versine)

    def table(self, value: Array, table: Table) -> Table:
        """Return the table on its tilted base."""
        c, s = np.cos(value[0]), np.sin(value[0])
        j, k = (self.axis + 1) % 3, (self.axis + 2) % 3
        back = np.eye(3)  # transposed rotation about the axis
        back[j, j] = back[k, k] = c
        back[j, k], back[k, j] = s, -s
        return replace(table, earth=back @ table.earth, gravity=back @ table.gravity)


def _tilted(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    sine: Array,
    versine: Array,
) -> Array:
    """Return M (Rot^T - 1) v, from its parts in sine and versine."""
    half = np.sin(0.5 * x[0])
    return np.asarray(
        truth.see(sine) * np.sin(x[0]) - truth.see(versine) * 2.0 * half**2
    )
