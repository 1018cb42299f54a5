"""The calibration formulas as they are used on pulses: Zhao 2019, eqs. (3) to (5).

Two misprints are mended, because they are no method: by eq. (1) d_yx has no minus sign
in eq. (3), and eq. (5) prints d_yz with N_x for N_y and d_xz under the name d_xy.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array

X, Y, Z = range(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class CalibratedTriad:
    """What a calibration of one triad returns."""

    scale_factor: Array  # K, shape (3,) [pulses per SI unit of the input]
    mounting_angle: Array  # xy, xz, yx, yz, zx, zy, shape (6,) [rad]
    bias: Array  # shape (3,) [rad/s] or [m/s^2]


def calibrate_gyro(
    turn_pulses: Array,
    static_rate: Array,
    *,
    turns: int,
    mean_earth: Array,
    formulas: str,
) -> CalibratedTriad:
    """Calibrate a gyro triad from its pulses.

    Parameters
    ----------
    turn_pulses : ndarray, shape (3, 3)
        Pulses of the + turn minus those of the - turn, [axis, axis turned about].
    static_rate : ndarray, shape (3,)
        Pulses per second, mean over the static dwells.
    turns : int
        n, in each sense.
    mean_earth : ndarray, shape (3,)
        Mean earth rate over the dwells, in body axes; (0, 0, w sin L) at balanced
        azimuths [rad/s].
    formulas : str
        'corrected', or 'paper' for eq. (4) as printed.

    Returns
    -------
    CalibratedTriad
    """
    n = turn_pulses
    K = np.diag(n) / (4.0 * turns * pi)  # eq. (3)
    angle = np.array(
        [
            -n[X, Z] / n[X, X],  # d_xy, eq. (3)
            n[X, Y] / n[X, X],  # d_xz, eq. (3)
            n[Y, Z] / n[Y, Y],  # d_yx; eq. (3) prints a minus
            -n[Y, X] / n[Y, Y],  # d_yz, eq. (3)
            -n[Z, Y] / n[Z, Z],  # d_zx, eq. (3)
            n[Z, X] / n[Z, Z],  # d_zy, eq. (3)
        ]
    )
    dT = _mounting_matrix(angle)
    if formulas == "paper":
        bias = (np.eye(3) + dT.T) @ (static_rate / K) - mean_earth  # eq. (4)
    else:
        bias = static_rate / K - (np.eye(3) + dT) @ mean_earth  # eq. (1), inverted
    return CalibratedTriad(scale_factor=K, mounting_angle=angle, bias=bias)


def calibrate_accelerometer(face_rate: Array, *, gravity: float) -> CalibratedTriad:
    """Calibrate an accelerometer triad from its pulses.

    Parameters
    ----------
    face_rate : ndarray, shape (3, 6)
        N_i(j): mean pulses per second of axis i, faces j in the order z up, z down, x
        up, x down, y up, y down, each the mean of its two dwells.
    gravity : float
        g [m/s^2].

    Returns
    -------
    CalibratedTriad
    """
    N = dict(enumerate(face_rate.T, start=1))  # N[j][i] is N_i(j)
    two_g = 2.0 * gravity
    K = np.array(
        [
            (N[3][X] - N[4][X]) / two_g,  # eq. (5)
            (N[5][Y] - N[6][Y]) / two_g,  # eq. (5)
            (N[1][Z] - N[2][Z]) / two_g,  # eq. (5)
        ]
    )
    angle = np.array(
        [
            -(N[1][X] - N[2][X]) / (two_g * K[X]),  # d_xy, eq. (5)
            (N[5][X] - N[6][X]) / (two_g * K[X]),  # d_xz; eq. (5) prints d_xy
            (N[1][Y] - N[2][Y]) / (two_g * K[Y]),  # d_yx, eq. (5)
            -(N[3][Y] - N[4][Y]) / (two_g * K[Y]),  # d_yz; eq. (5) prints N_x
            -(N[5][Z] - N[6][Z]) / (two_g * K[Z]),  # d_zx, eq. (5)
            (N[3][Z] - N[4][Z]) / (two_g * K[Z]),  # d_zy, eq. (5)
        ]
    )
    bias = np.array(
        [
            (N[3][X] + N[4][X]) / (2.0 * K[X]),  # eq. (5)
            (N[5][Y] + N[6][Y]) / (2.0 * K[Y]),  # eq. (5)
            (N[1][Z] + N[2][Z]) / (2.0 * K[Z]),  # eq. (5)
        ]
    )
    return CalibratedTriad(scale_factor=K, mounting_angle=angle, bias=bias)


def _mounting_matrix(angle: Array) -> Array:
    """Return dT of eq. (1), shape (3, 3), from the six angles [rad]."""
    xy, xz, yx, yz, zx, zy = angle
    return np.array([[0.0, xz, -xy], [-yz, 0.0, yx], [zy, -zx, 0.0]])
