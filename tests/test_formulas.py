"""Calibration formulas: error-free pulses return what was put in; misprints do not."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.physics.formulas import calibrate_accelerometer, calibrate_gyro

K = np.array([2.0, 3.0, 5.0])
ANGLE = np.array([1e-5, -2e-5, 3e-5, -4e-5, 5e-5, 6e-5])  # xy xz yx yz zx zy
XY, XZ, YX, YZ, ZX, ZY = ANGLE
M = np.array([[1.0, XZ, -XY], [-YZ, 1.0, YX], [ZY, -ZX, 1.0]])  # eq. (1)
BIAS = np.array([1e-5, -2e-5, 3e-5])
EARTH = np.array([0.0, 0.0, 4e-5])
GRAVITY = 9.8
FACES = [(2, 1), (2, -1), (0, 1), (0, -1), (1, 1), (1, -1)]


def gyro_pulses(turns=2):
    """Return what error-free turns and dwells count."""
    return K[:, None] * M * 4.0 * pi * turns, K * (M @ EARTH + BIAS)


def face_rates():
    """Return what error-free faces count a second, shape (3, 6)."""
    return np.stack(
        [K * (M[:, axis] * sign * GRAVITY + BIAS) for axis, sign in FACES], axis=1
    )


def test_gyro_formulas_invert_the_measurement_model():
    """Corrected formulas return K, the six angles and the bias of eq. (1)."""
    pulses, static = gyro_pulses()
    found = calibrate_gyro(
        pulses, static, turns=2, mean_earth=EARTH, formulas="corrected"
    )
    assert_allclose(found.scale_factor, K, rtol=1e-14)
    assert_allclose(found.mounting_angle, ANGLE, rtol=1e-13)
    assert_allclose(found.bias, BIAS, rtol=1e-13)


def test_paper_bias_leaves_the_residual_of_eq_4():
    """Eq. (4) as printed is wrong by (dT + dT^T) w + dT^T b + dT^T dT w."""
    pulses, static = gyro_pulses()
    found = calibrate_gyro(pulses, static, turns=2, mean_earth=EARTH, formulas="paper")
    dT = M - np.eye(3)
    residual = (dT + dT.T) @ EARTH + dT.T @ BIAS + dT.T @ dT @ EARTH
    assert_allclose(found.bias - BIAS, residual, rtol=1e-9)
    assert np.abs(residual).min() > 1e-12 * np.abs(BIAS).max()  # it is there


def test_accelerometer_formulas_invert_the_measurement_model():
    """Mended eq. (5) returns K, the six angles and the bias of eq. (2)."""
    found = calibrate_accelerometer(face_rates(), gravity=GRAVITY)
    assert_allclose(found.scale_factor, K, rtol=1e-14)
    # 2 g d is found as a difference of rates near the bias: rounding of 1e-16 of g.
    assert_allclose(found.mounting_angle, ANGLE, rtol=1e-10)
    assert_allclose(found.bias, BIAS, rtol=1e-9)


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
    wrong = printed(gyro_pulses()[0], face_rates())
    assert abs(wrong - angle) > 0.9 * abs(angle)
