"""The gyro calibration: the paper's residuals, closed forms, exact references."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest
from builders import at_sources, paper_gyro, procedure, sensor
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes.zhao_2019 import schedule_gyro
from budget.earth import ROTATION_RATE
from budget.methods.gum import propagate
from budget.model.noise import GaussMarkov
from budget.units import ARCSEC, DEG_PER_HOUR, DEGREE

BIAS = 2.5 * DEG_PER_HOUR
ANGLE = 2.0 * ARCSEC


def errors(problem, **values):
    """Return the outputs with whole sources set to values, the rest at 0."""
    return problem.evaluate(at_sources(problem, **values)[:, None])[:, 0]


def test_paper_formula_without_any_error_leaves_table_1s_residual():
    """Relative bias errors are -3.18e-10, -3.18e-10, 6.37e-10, as Table 1 prints."""
    problem = calibration_problem((paper_gyro(),), procedure(formulas="paper"))
    assert_allclose(
        errors(problem)[9:] / BIAS,
        [-3.182645e-10, -3.182645e-10, 6.365290e-10],
        rtol=5e-6,
    )


def test_corrected_formula_without_any_error_leaves_nothing():
    """Relative bias errors are below 1e-14."""
    problem = calibration_problem((paper_gyro(),), procedure())
    assert_allclose(errors(problem)[9:] / BIAS, np.zeros(3), rtol=0, atol=1e-14)


def test_asymmetry_on_the_papers_device():
    """Ka 1250 ppm: angles 2.24e-3 relative, scale factors as eq. (17) with earth."""
    problem = calibration_problem(
        (paper_gyro(scale_factor_asymmetry=1250e-6),), procedure(formulas="paper")
    )
    found = errors(problem, gyro__scale_factor_asymmetry=1250e-6)
    for value, printed in zip(
        found[:3], ("2.17e-8", "1.30e-7", "9.52e-8"), strict=True
    ):
        assert f"{value:.2e}" == f"{float(printed):.2e}"
    assert_allclose(np.abs(found[3:9] / ANGLE), np.full(6, 2.24e-3), rtol=2e-3)
    assert_allclose(np.sign(found[3:9]), [-1, 1, 1, -1, -1, 1])


def test_asymmetry_reaches_scale_factors_by_the_closed_form():
    """dK/K = Ka T s/(4 pi n), s = (b, b + w cos L, b + w sin L): eq. (17), earth."""
    problem = calibration_problem(
        (sensor("gyro", {"scale_factor_asymmetry": 1e-3}, bias=BIAS),),
        procedure(turns=3, rate=10.0),
    )
    found = errors(problem, gyro__scale_factor_asymmetry=1e-3)
    L, T = radians(34.2394), 3 * 36.0
    s = BIAS + ROTATION_RATE * np.array([0.0, cos(L), sin(L)])
    assert_allclose(found[:3], 1e-3 * T * s / (4.0 * pi * 3), rtol=1e-12)


@pytest.mark.parametrize(
    ("reference", "printed", "times"),
    [
        ("nominal", "0.0564", 1),
        ("as_tested", "0.0261", 0),
        ("next_turn_on", "0.0754", 2),
    ],
)
def test_bias_uncertainty_under_each_reference(reference, printed, times):
    """Repeatability counts once, not at all, twice; the procedure's part stays."""
    problem = calibration_problem((paper_gyro(),), procedure(), reference=reference)
    u = propagate(problem).standard_uncertainty[9:]
    assert_allclose(u / DEG_PER_HOUR, np.full(3, float(printed)), rtol=0, atol=5e-5)

    # What the procedure adds: mean stability and random walk over the dwells, minus
    # dk (b + w_z) for x, y, z less the horizontal rate, and ddT w.
    plan = schedule_gyro(procedure().gyro)
    stability = GaussMarkov(0.04 * DEG_PER_HOUR, 300.0).covariance(plan)
    N = 0.005 * DEGREE / 60.0
    white = np.diag(N**2 / plan.lengths)
    C = stability + white
    mean = np.array([0.0] * 6 + [0.25] * 4)
    turns = {axis: np.zeros(10) for axis in "zxy"}
    for place, axis in enumerate("zxy"):
        turns[axis][[2 * place, 2 * place + 1]] = [1.0, -1.0]
    gain = 1.0 / (2.0 * radians(20.0))
    w = ROTATION_RATE * sin(radians(34.2394))
    own = {"x": "z", "y": "z", "z": None}
    for i, axis in enumerate("xyz"):
        # db = mean noise - e_own (b + M w) - (ddT w), ddT only where a z-turn reaches.
        standing = BIAS + (w if axis == "z" else {"x": -1, "y": 1}[axis] * ANGLE * w)
        weights = mean - gain * standing * turns[axis]
        if own[axis]:
            d = {"x": -ANGLE, "y": ANGLE}[axis]
            weights = weights - gain * w * (turns["z"] - d * turns[axis])
        exact = sqrt(weights @ C @ weights + times * (0.05 * DEG_PER_HOUR) ** 2)
        assert_allclose(u[i], exact, rtol=1e-9)


def test_scale_factor_and_angle_uncertainty_from_random_walk():
    """ARW 0.005 deg/sqrt(h): u(K) = N sqrt(2/T) / (2 rate) = 6.9e-7, angles 0.143."""
    problem = calibration_problem(
        (paper_gyro(),), procedure(), only=frozenset({"gyro.angle_random_walk"})
    )
    u = propagate(problem).standard_uncertainty
    exact = 0.005 * DEGREE / 60.0 * sqrt(2.0 / 18.0) / (2.0 * radians(20.0))
    assert_allclose(u[:3], exact, rtol=1e-9)
    assert_allclose(u[:3], 6.9e-7, rtol=0, atol=1e-8)
    assert_allclose(u[3:9] / ARCSEC, 0.143, rtol=0, atol=5e-4)


def test_unbalanced_azimuths_leave_no_bias_error():
    """With azimuths 0 and 90 deg the corrected formula still inverts the model."""
    problem = calibration_problem((paper_gyro(),), procedure(azimuths=(0.0, 90.0)))
    assert_allclose(errors(problem)[9:] / BIAS, np.zeros(3), rtol=0, atol=1e-14)


def test_large_errors_are_exact_not_linearised():
    """Scale factor 0.1 high, 0.2 asymmetric: the error is eq. (6) in closed form."""
    problem = calibration_problem(
        (
            sensor(
                "gyro",
                {"scale_factor_repeatability": 0.1, "scale_factor_asymmetry": 0.2},
                bias=1e-2,
            ),
        ),
        procedure(latitude=0.0),
    )
    found = errors(
        problem,
        gyro__scale_factor_repeatability=0.1,
        gyro__scale_factor_asymmetry=0.2,
    )
    gain = 1.0 / (2.0 * radians(20.0))
    s = 1e-2 + ROTATION_RATE * np.array([0.0, 1.0, 0.0])
    assert_allclose(found[:3], 1.1 * (1.0 + 0.2 * gain * s) - 1.0, rtol=1e-12)
