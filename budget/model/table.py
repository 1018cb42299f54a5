"""Attitude of a three-axis table, and its mean over a turn.

Body axes x, y, z point east, north, up at table zero. The outer axis turns about z, the
middle one about y, the inner one about x:

    v_ENU = Rz(outer) Ry(middle) Rx(inner) v_body .
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array

OUTER, MIDDLE, INNER = 2, 1, 0  # the body axis that each turns about at table zero

# Cosines and sines below this are rounding of a right angle or a whole turn [1].
ROUNDING = 1e-15


@dataclass(frozen=True, kw_only=True)
class Setting:
    """Angles of the table, and the turn that one of its axes makes from there.

    Attributes
    ----------
    outer, middle, inner : float
        [rad].
    turning : int or None
        OUTER, MIDDLE or INNER.
    angle : float
        Of the turn; its sign is the sense [rad].
    """

    outer: float = 0.0
    middle: float = 0.0
    inner: float = 0.0
    turning: int | None = None
    angle: float = 0.0

    @property
    def to_body(self) -> Array:
        """Matrix from east-north-up to body axes, shape (3, 3), mean over the turn."""
        x, y, z = (self._back(axis) for axis in range(3))
        return np.asarray(x @ y @ z)

    @property
    def turn_axis(self) -> Array:
        """Axis of the turn in body axes, shape (3,); zeros where nothing turns."""
        if self.turning is None:
            return np.zeros(3)
        axis: Array = np.eye(3)[self.turning]
        for inner in range(self.turning - 1, -1, -1):
            axis = np.asarray(self._back(inner) @ axis)
        return axis

    def _back(self, axis: int) -> Array:
        """Return the transposed rotation about one axis, mean over the turn."""
        start = (self.inner, self.middle, self.outer)[axis]
        turn = self.angle if axis == self.turning else 0.0
        return _mean_rotation(axis, start, turn).T


def _mean_rotation(axis: int, start: float, turn: float) -> Array:
    """Return the mean of rotations about a coordinate axis, shape (3, 3).

    cos and sin averaged over the angles from `start` to `start + turn`: those of the
    middle angle times sin(h)/h, h half the turn; 0 over whole turns.
    """
    half = turn / 2.0
    damping = sin(half) / half if half else 1.0
    middle = start + half
    c, s = (
        0.0 if abs(part) < ROUNDING else part
        for part in (cos(middle) * damping, sin(middle) * damping)
    )
    R = np.zeros((3, 3))
    j, k = (axis + 1) % 3, (axis + 2) % 3
    R[axis, axis] = 1.0
    R[j, j] = R[k, k] = c
    R[j, k], R[k, j] = -s, s
    return R
