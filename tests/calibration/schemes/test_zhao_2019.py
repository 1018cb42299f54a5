"""The paper's scheme: error-free readings return what was put in; misprints do not."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from builders import procedure
from numpy.testing import assert_allclose

from budget.calibration.schemes import scheme_of
from budget.calibration.schemes.zhao_2019 import schedule_accelerometer, schedule_gyro

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
    found = scheme.estimate(readings(scheme))
    # Angles and biases are differences of readings: rounding of 1e-16 of the inputs.
    assert_allclose(found.scale_factor, K, rtol=1e-13)
    assert_allclose(found.mounting_angle, ANGLE, rtol=1e-9)
    assert_allclose(found.bias, BIAS, rtol=1e-9)


def test_paper_bias_leaves_the_residual_of_eq_4():
    """Eq. (4) as printed is wrong by (dT + dT^T) w + dT^T b + dT^T dT w."""
    scheme = scheme_of("gyro", procedure(formulas="paper"))
    found = scheme.estimate(readings(scheme))
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


# ---- schedules: order, times and pauses of turns and dwells --------------------------


def test_gyro_turns_come_before_dwells_plus_before_minus():
    """The paper's gyro test is z+ z- x+ x- y+ y- and four dwells, back to back."""
    plan = schedule_gyro(procedure().gyro)
    assert [w.name for w in plan.windows] == [
        *("turn z+", "turn z-", "turn x+", "turn x-", "turn y+", "turn y-"),
        *("azimuth 0", "azimuth 180", "azimuth 270", "azimuth 450"),
    ]
    assert_allclose(plan.lengths, [18.0] * 6 + [300.0] * 4, rtol=1e-14)
    assert_allclose(
        plan.starts, [0, 18, 36, 54, 72, 90, 108, 408, 708, 1008], rtol=1e-14
    )


def test_order_moves_a_turn_in_time_but_keeps_its_name():
    """With order y, z, x the first turn is about y and still called so."""
    plan = schedule_gyro(procedure(order=("y", "z", "x")).gyro)
    assert plan.windows[0].name == "turn y+"
    assert plan.pick(1, 1) == (0,)


def test_pause_lies_between_all_windows():
    """A pause of 5 s shifts the k-th window by 5 k seconds."""
    without = schedule_gyro(procedure(turns=3).gyro)
    with_pause = schedule_gyro(procedure(turns=3, pause=5.0).gyro)
    assert_allclose(
        with_pause.starts - without.starts, [5.0 * k for k in range(10)], rtol=1e-13
    )
    assert_allclose(with_pause.lengths, without.lengths, rtol=1e-14)


def test_accelerometer_holds_each_face_twice_in_a_row():
    """Twelve dwells: z up, z down, x up, x down, y up, y down, each twice."""
    plan = schedule_accelerometer(procedure().accelerometer)
    assert [(w.axis, w.sign) for w in plan.windows] == [
        (axis, sign) for axis in (2, 0, 1) for sign in (1, -1) for _ in range(2)
    ]
    assert_allclose(plan.starts, [300.0 * k for k in range(12)], rtol=1e-14)


def test_azimuths_are_kept_as_given():
    """450 deg stays 450 deg."""
    plan = schedule_gyro(procedure().gyro)
    assert plan.windows[-1].azimuth == radians(450.0)
