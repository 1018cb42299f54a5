"""What gyros and accelerometers share: three axes, six mounting angles, one response.

Row i, column a of the response is what axis i shows of an input along body axis a,
divided by the axis' own true scale factor. Its true value is I + dT; a calibration
finds it with an error epsilon, and scale factors and angles follow from both alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.spec.records import ANGLES, AXES

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.physics.sources import SourceRows

# dT of Zhao 2019, eq. (1): element (ROW, COLUMN) is SIGN times the angle, for the
# angles in the order of ANGLES: xy, xz, yx, yz, zx, zy.
ROW = np.array([0, 0, 1, 1, 2, 2])
COLUMN = np.array([2, 1, 2, 0, 1, 0])
SIGN = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])

OUTPUT_NAMES = (
    *(f"scale_factor.{axis}" for axis in AXES),
    *(f"mounting_angle.{angle}" for angle in ANGLES),
    *(f"bias.{axis}" for axis in AXES),
)


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
class ResponseError:
    """Errors of what is read off the response, against the values during the test."""

    scale_factor: Array  # relative, shape (3, trials) [1]
    mounting_angle: Array  # shape (6, trials) [rad]


def read_response(epsilon: Array, angle: Array) -> ResponseError:
    """Read scale factors and angles off a response I + dT + epsilon.

    K_i = K_true (1 + e_ii); d = s (s d + e_ia) / (1 + e_ii): Zhao 2019, eqs. (3), (5),
    with s the sign of the angle in dT. Written as errors, which keeps the digits that
    the difference of two nearly equal angles would lose.

    Parameters
    ----------
    epsilon : ndarray, shape (3, 3, trials)
        Error of the response, [axis, input axis] [1].
    angle : ndarray, shape (6, trials)
        True mounting angles [rad].

    Returns
    -------
    ResponseError
    """
    own = epsilon[[0, 1, 2], [0, 1, 2]]
    cross = epsilon[ROW, COLUMN] * SIGN[:, None]
    return ResponseError(
        scale_factor=own,
        mounting_angle=(cross - angle * own[ROW]) / (1.0 + own[ROW]),
    )


def refer(
    x: Array,
    rows: SourceRows,
    reference: str,
    response: ResponseError,
    bias: Array,
) -> Array:
    """Count errors from the reference instead of from the values during the test.

    Error = (calibrated - true during the test) + (true during the test - reference);
    relative errors of the scale factor multiply: (1 + r)(1 + e) - 1.

    Parameters
    ----------
    x : ndarray, shape (n_inputs, trials)
        Inputs of the triad [SI].
    rows : SourceRows
        Where its sources stand.
    reference : str
        One of sources.REFERENCES.
    response : ResponseError
        Errors of scale factors and angles against the values during the test.
    bias : ndarray, shape (3, trials)
        The same of the biases [SI].

    Returns
    -------
    ndarray, shape (12, trials)
        Errors in the order of OUTPUT_NAMES.
    """
    r = rows.scale_factor_departure(x, reference)
    return np.concatenate(
        [
            r + response.scale_factor * (1.0 + r),
            response.mounting_angle
            + rows.departure(x, "mounting_repeatability", reference),
            bias + rows.departure(x, "bias_repeatability", reference),
        ]
    )
