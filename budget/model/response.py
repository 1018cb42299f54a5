"""Response of a triad: three axes, six mounting angles; the parameters read from it.

Row i, column a of the response is what axis i shows of an input along body axis a,
divided by the axis' own true scale factor. Its true value is M = I + dT; a calibration
finds it with an error epsilon, and scale factors, angles and biases follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.scheme import BIAS

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.scheme import Scheme

# dT of Zhao 2019, eq. (1): element (ROW, COLUMN) is SIGN times the angle, for the
# angles in the order of ANGLES: xy, xz, yx, yz, zx, zy.
ROW = np.array([0, 0, 1, 1, 2, 2])
COLUMN = np.array([2, 1, 2, 0, 1, 0])
SIGN = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What one triad is during the test, trial by trial.

    Attributes
    ----------
    angle : ndarray, shape (6, trials)
        Mounting angles in the order of ANGLES [rad].
    bias : ndarray, shape (3, trials)
        [unit of the input].
    """

    angle: Array
    bias: Array

    def see(self, vectors: Array) -> Array:
        """Return M_i v_ik, shape (3, k, trials): what each axis shows of vectors.

        Parameters
        ----------
        vectors : ndarray, shape (3, k, 3)
            k inputs for each axis, the same in all trials.
        """
        own = vectors[[0, 1, 2], :, [0, 1, 2]][..., None]
        return own + self.see_across(vectors)

    def see_across(self, vectors: Array) -> Array:
        """Return dT_i v_ik, shape (3, k, trials): what the angles let through."""
        part = (SIGN[:, None] * vectors[ROW, :, COLUMN])[..., None] * self.angle[
            :, None
        ]
        return np.asarray(part[0::2] + part[1::2])  # ROW is 0, 0, 1, 1, 2, 2


def tilt(angle: Array, u: Array) -> Array:
    """Return dT u, the input that the mounting angles let through.

    Parameters
    ----------
    angle : ndarray, shape (6, trials)
        Mounting angles [rad].
    u : ndarray, shape (3,)
        Input in body axes [SI].

    Returns
    -------
    ndarray, shape (3, trials)
        [unit of u].
    """
    part = angle * (SIGN * u[COLUMN])[:, None]
    return np.asarray(part[0::2] + part[1::2])  # ROW is 0, 0, 1, 1, 2, 2


def tilt_transposed(angle: Array, u: Array) -> Array:
    """Return dT^T u; `angle` has shape (6, trials), `u` (3, trials) [unit of u]."""
    part = angle * u[ROW] * SIGN[:, None]
    # Columns of dT: x gathers yz and zy, y gathers xz and zx, z gathers xy and yx.
    return np.stack([part[3] + part[5], part[1] + part[4], part[0] + part[2]])


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """Errors of what is read off, against the values during the test."""

    scale_factor: Array  # relative, shape (3, trials) [1]
    mounting_angle: Array  # shape (6, trials) [rad]
    bias: Array  # shape (3, trials) [unit of the input]


def read_errors(scheme: Scheme, truth: Truth, epsilon: Array) -> Errors:
    """Read scale factors, angles and biases off statistics (M, b) + epsilon.

    K_i = K_true (1 + e_ii); d = s (s d + e_ia) / (1 + e_ii), s the sign of the angle in
    dT; b = (b + e_ib) / (1 + e_ii): Zhao 2019, eqs. (3) to (5). Written as errors: the
    difference of two nearly equal values would lose digits.

    With `scheme.rotated` w the bias goes through eq. (4) as printed: it rotates v, the
    mean reading over K, by the transpose, (I + dT^T) v - w, which is right only where
    dT is antisymmetric and the bias given in body axes.

    Parameters
    ----------
    scheme : Scheme
    truth : Truth
    epsilon : ndarray, shape (3, 4, trials)
        Errors of the statistics of each axis, W (e + M du).

    Returns
    -------
    Errors
    """
    own = epsilon[[0, 1, 2], [0, 1, 2]]
    cross = epsilon[ROW, COLUMN] * SIGN[:, None]
    angle = (cross - truth.angle * own[ROW]) / (1.0 + own[ROW])
    bias = (epsilon[:, BIAS] - truth.bias * own) / (1.0 + own)
    if scheme.rotated is not None:
        found = truth.angle + angle
        through = tilt(found, scheme.rotated)
        v = truth.bias + bias + scheme.rotated[:, None] + through
        bias = bias + through + tilt_transposed(found, v)
    return Errors(scale_factor=own, mounting_angle=angle, bias=bias)


@dataclass(frozen=True, kw_only=True, eq=False)
class CalibratedTriad:
    """What a calibration of one triad returns."""

    scale_factor: Array  # K, shape (3,) [pulses per SI unit of the input]
    mounting_angle: Array  # in the order of ANGLES, shape (6,) [rad]
    bias: Array  # shape (3,) [unit of the input]


def estimate(scheme: Scheme, readings: Array) -> CalibratedTriad:
    """Calibrate one triad from its readings: the same weights, on real windows.

    Parameters
    ----------
    scheme : Scheme
    readings : ndarray, shape (3, n)
        Mean pulses per second of each axis in each window.

    Returns
    -------
    CalibratedTriad
    """
    statistics = np.einsum("ikw,iw->ik", scheme.weights, readings)
    K = statistics[[0, 1, 2], [0, 1, 2]]
    angle = SIGN * statistics[ROW, COLUMN] / K[ROW]
    bias = statistics[:, BIAS] / K
    w = scheme.rotated
    if w is not None:
        v = bias + w + tilt(angle[:, None], w)[:, 0]
        bias = v + tilt_transposed(angle[:, None], v[:, None])[:, 0] - w
    return CalibratedTriad(scale_factor=K, mounting_angle=angle, bias=bias)
