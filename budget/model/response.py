"""Response of a triad: three axes, six mounting angles, and what is calibrated of it.

Row i, column a of the response is what axis i shows of an input along body axis a,
divided by the axis' own true scale factor. Its true value is M = I + dT; a calibration
finds it with an error epsilon, and scale factors, angles and biases follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array


# dT of Zhao 2019, eq. (1): element (ROW, COLUMN) is SIGN times the angle, for the
# angles in the order of ANGLES: xy, xz, yx, yz, zx, zy.
ROW = np.array([0, 0, 1, 1, 2, 2])
COLUMN = np.array([2, 1, 2, 0, 1, 0])
SIGN = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])

BIAS = 3  # row of the weights, after the responses to x, y, z
STATISTICS = 4
CYCLES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What one triad is during the test, trial by trial.

    Attributes
    ----------
    angle : ndarray, shape (6, trials)
        Mounting angles in the order of ANGLES [rad].
    bias : ndarray, shape (3, trials)
        [unit of the input].
    scale_factor : ndarray, shape (3, trials), or None
        k of K = K0 (1 + k) [1]; nobody asks for it where nothing is held.
    """

    angle: Array
    bias: Array
    scale_factor: Array | None = None

    @property
    def from_design(self) -> Array:
        """K0/K - 1, the error of a scale factor that is held, shape (3, trials) [1]."""
        k = np.zeros_like(self.bias)
        if self.scale_factor is not None:
            k = k + self.scale_factor
        return -1.0 * k / (1.0 + k)

    def see(self, vectors: Array) -> Array:
        """Return M_i v_ik, shape (3, k, trials): what each axis shows of vectors.

        Parameters
        ----------
        vectors : ndarray, shape (3, k, 3)
            k inputs for each axis, the same in all trials.
        """
        return self.see_each(vectors[..., None])

    def see_each(self, vectors: Array) -> Array:
        """Return the same of inputs that differ by trial, shape (3, k, 3, trials)."""
        own = vectors[[0, 1, 2], :, [0, 1, 2]]
        part = SIGN[:, None, None] * vectors[ROW, :, COLUMN] * self.angle[:, None]
        return np.asanyarray(own + (part[0::2] + part[1::2]))


def statistics_of(own: Array, cross: Array, bias: Array) -> Array:
    """Put what belongs to parameters where their statistics stand, shape (3, 4, ...).

    Parameters
    ----------
    own, cross, bias : ndarray, shape (3, ...), (6, ...), (3, ...)
        Of scale factors, of mounting angles in the order of ANGLES, of biases.
    """
    table = np.empty((3, BIAS + 1, *own.shape[1:]), dtype=np.result_type(own, cross))
    table[[0, 1, 2], [0, 1, 2]] = own
    table[ROW, COLUMN] = cross
    table[:, BIAS] = bias
    return table


def tilt_matrix(angle: Array) -> Array:
    """Return dT of eq. (1), shape (3, 3, ...), of angles in the order of ANGLES."""
    nothing = np.zeros_like(angle[:3])
    return statistics_of(nothing, (SIGN * angle.T).T, nothing)[:, :BIAS]


def response(angle: Array) -> Array:
    """Return M = I + dT of six angles, shape (3, 3)."""
    return np.asarray(np.eye(3) + tilt_matrix(angle))


def diagonal(values: Array) -> Array:
    """Return matrices (..., 3, 3) with these values (..., 3) in their diagonals."""
    return np.asarray(values[..., None] * np.eye(values.shape[-1]))


def inverse(A: Array) -> Array:
    """Return the inverse of matrices, (3, 3, trials): adjugate over determinant."""
    adjugate = np.empty_like(A)
    for p, i, j in CYCLES:  # element by element: rows and columns would be copies
        for q, m, n in CYCLES:
            adjugate[q, p] = A[i, m] * A[j, n] - A[i, n] * A[j, m]
    return np.asarray(adjugate / (A[0] * adjugate[:, 0]).sum(axis=0))


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
class TriadValues:
    """A value of each parameter of a triad, or one a trial, in the last axis.

    Attributes
    ----------
    scale_factor : ndarray, shape (3, ...)
    mounting_angle : ndarray, shape (6, ...)
        In the order of ANGLES [rad].
    bias : ndarray, shape (3, ...)
        [unit of the input].
    higher : ndarray, shape (3 m, ...), or None
        K_p, order by order [SI].
    """

    scale_factor: Array
    mounting_angle: Array
    bias: Array
    higher: Array | None = None

    @classmethod
    def of(cls, p: Array) -> Self:
        """Return scale factors, angles and biases that stand in one, (12, ...)."""
        return cls(scale_factor=p[:3], mounting_angle=p[3:9], bias=p[9:])

    @property
    def vector(self) -> Array:
        """All of them in one."""
        own = (self.scale_factor, self.mounting_angle, self.bias, self.higher)
        return np.concatenate([one for one in own if one is not None])


class Errors(TriadValues):
    """Errors of what is read off, against the values during the test; of K relative."""


class CalibratedTriad(TriadValues):
    """What a calibration of one triad returns; K in pulses per SI unit of the input."""

    @property
    def response(self) -> Array:
        """M = I + dT, shape (3, 3) [1]."""
        return response(self.mounting_angle)

    def shown(self, readings: Array) -> Array:
        """Return the inputs that readings show, M^-1 (y/K - b), (3, n)."""
        inner = readings / self.scale_factor[:, None] - self.bias[:, None]
        return np.asarray(np.linalg.solve(self.response, inner))
