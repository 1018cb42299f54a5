"""Response of a triad: three axes, six mounting angles; the parameters read from it.

Row i, column a of the response is what axis i shows of an input along body axis a,
divided by the axis' own true scale factor. Its true value is M = I + dT; a calibration
finds it with an error epsilon, and scale factors, angles and biases follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.scheme import BIAS, COLUMN, ROW, SIGN

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.scheme import Held, Scheme


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
    if scheme.held is not None:
        epsilon = epsilon + _from_held(scheme, scheme.held, truth)
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


def _from_held(scheme: Scheme, held: Held, truth: Truth) -> Array:
    """Return what held parameters add to epsilon, shape (3, 4, trials).

    A column that is held at h0 and truly is h leaves h - (1 + e) h0 in the averages,
    e = K0/K - 1 where the scale factor is held, else 0 (it is estimated with the held
    column in it). Of the own column both are 1. W sees it as it sees that column, and
    the statistic of a held scale factor is off by e itself.
    """
    is_own = held.which[[0, 1, 2], [0, 1, 2]][:, None]
    k = np.zeros_like(truth.bias) if truth.scale_factor is None else truth.scale_factor
    e = -1.0 * is_own * k / (1.0 + k)
    true = statistics_of(np.ones_like(e), SIGN[:, None] * truth.angle, truth.bias)
    taken = held.value[..., None]
    left = 1.0 * held.which[..., None] * (true - taken - e[:, None] * taken)
    found = (scheme.seen[..., None] * left[:, None]).sum(axis=2)
    found[[0, 1, 2], [0, 1, 2]] += e
    return np.asarray(found)


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
    if scheme.held is not None:
        statistics -= _known(scheme, scheme.held)
    K = statistics[[0, 1, 2], [0, 1, 2]]
    angle = SIGN * statistics[ROW, COLUMN] / K[ROW]
    bias = statistics[:, BIAS] / K
    w = scheme.rotated
    if w is not None:
        v = bias + w + tilt(angle[:, None], w)[:, 0]
        bias = v + tilt_transposed(angle[:, None], v[:, None])[:, 0] - w
    return CalibratedTriad(scale_factor=K, mounting_angle=angle, bias=bias)


def _known(scheme: Scheme, held: Held) -> Array:
    """Return what held scale factors of 1 leave to take off the statistics, (3, 4)."""
    is_own = held.which[[0, 1, 2], [0, 1, 2]]
    own = held.join(scheme.seen)[[0, 1, 2], :, [0, 1, 2]]
    known = np.where(is_own[:, None], own, 0.0)
    known[[0, 1, 2], [0, 1, 2]] -= is_own
    return np.asarray(known)
