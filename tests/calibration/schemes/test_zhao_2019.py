"""The paper's scheme: error-free readings return what was put in; misprints do not."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from builders import procedure
from numpy.testing import assert_allclose

from budget.calibration.schemes import scheme_of
from budget.model.response import estimate

K = np.array([2.0, 3.0, 5.0])
ANGLE = np.array([1e-5, -2e-5, 3e-5, -4e-5, 5e-5, 6e-5])  # xy xz yx yz zx zy
XY, XZ, YX, YZ, ZX, ZY = ANGLE
M = np.array([[1.0, XZ, -XY], [-YZ, 1.0, YX], [ZY, -ZX, 1.0]])  # eq. (1)
BIAS = np.array([1e-5, -2e-5, 3e-5])
GRAVITY = 9.7966933092
FACES = [(2, 1), (2, -1), (0, 1), (0, -1), (1, 1), (1, -1)]
SCHEMES = {
    "as the paper does it": {},
    "azimuths that do not balance": {"azimuths": (0.0, 90.0, 130.0), "turns": 2},
}


def readings(scheme):
    """Return what error-free windows count a second, shape (3, n)."""
    return K[:, None] * (M @ (scheme.turn + scheme.standing).T + BIAS[:, None])


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
@pytest.mark.parametrize("how", SCHEMES.values(), ids=SCHEMES)
def test_the_estimator_inverts_the_measurement_model(owner, how):
    """Error-free readings return K, the six angles and the bias of eqs. (1), (2)."""
    scheme = scheme_of(owner, procedure(**how))
    found = estimate(scheme, readings(scheme))
    # Angles and biases are differences of readings: rounding of 1e-16 of the inputs.
    assert_allclose(found.scale_factor, K, rtol=1e-13)
    assert_allclose(found.mounting_angle, ANGLE, rtol=1e-9)
    assert_allclose(found.bias, BIAS, rtol=1e-9)


def test_paper_bias_leaves_the_residual_of_eq_4():
    """Eq. (4) as printed is wrong by (dT + dT^T) w + dT^T b + dT^T dT w."""
    scheme = scheme_of("gyro", procedure(formulas="paper"))
    found = estimate(scheme, readings(scheme))
    dT, w = M - np.eye(3), scheme.rotated
    residual = (dT + dT.T) @ w + dT.T @ BIAS + dT.T @ dT @ w
    assert_allclose(found.bias - BIAS, residual, rtol=1e-6)
    assert np.abs(residual).min() > 1e-12 * np.abs(BIAS).max()  # it is there


def gyro_pulses():
    """Return n_ij of error-free turns by one revolution."""
    return K[:, None] * M * 4.0 * pi


def face_rates():
    """Return what error-free faces count a second, shape (3, 6)."""
    return np.stack(
        [K * (M[:, axis] * sign * GRAVITY + BIAS) for axis, sign in FACES], axis=1
    )


@pytest.mark.parametrize(
    ("angle", "printed"),
    [
        # eq. (3) prints d_yx with a minus sign
        (YX, lambda n, N: -n[1, 2] / n[1, 1]),
        # eq. (5) prints d_yz with N_x in place of N_y
        (YZ, lambda n, N: -(N[0, 2] - N[0, 3]) / (2.0 * GRAVITY * K[1])),
        # eq. (5) prints a second d_xy, which is d_xz
        (XY, lambda n, N: (N[0, 4] - N[0, 5]) / (2.0 * GRAVITY * K[0])),
    ],
    ids=["d_yx", "d_yz", "second d_xy"],
)
def test_printed_formula_returns_a_wrong_angle(angle, printed):
    """Each misprint, fed with error-free pulses, misses the angle by its own size."""
    wrong = printed(gyro_pulses(), face_rates())
    assert abs(wrong - angle) > 0.9 * abs(angle)
