"""Compensation matrices: readings become what was put in, and how surely."""

from __future__ import annotations

import pickle
from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from builders import procedure, sensor
from command_line import call
from numpy.testing import assert_allclose

from budget import analyze, load_device, load_procedure
from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.report.analysis.groups import budget_answer, page_of
from budget.results import CONVENTION
from budget.studies.compensation import inversion_of, outputs_of
from budget.units import ARCSEC, MICRO_G

# Angles of a degree and more, of which none is another's: an order would show.
ANGLE = np.array([1.0, -2.0, 3.0, 0.5, -1.5, 2.5]) * 3600.0 * ARCSEC
BIAS = np.array([3.0, -2.0, 1.0]) * 1000.0 * MICRO_G
INPUT = np.array([[9.0, -1.0, 2.0], [0.5, 5.0, -8.0], [0.3, 0.2, 0.1]]).T  # [m/s^2]
TRIALS = 40_000
SIGMAS = 5.0


def counts(K, angle, bias):
    """Return what a triad counts a second, the matrix written out: Zhao 2019, eq. 1."""
    xy, xz, yx, yz, zx, zy = angle
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
    return K[:, None] * (M @ INPUT + bias[:, None])


def solved(device, plan, **more):
    """Return the matrices of one triad: their problem, map and law."""
    parameters = calibration_problem((device,), plan, **more)
    invert = inversion_of(device, parameters)
    problem = parameters.then(invert, outputs_of(device, parameters))
    return problem, invert, propagate(problem)


def test_readings_give_the_input_back_in_both_forms():
    """T (n/K - b) and T n/K - T b are the input; T transposed is not."""
    given = replace(
        load_device("zhao-2019").accelerometer,
        nominal_mounting_angle=ANGLE,
        nominal_bias=BIAS,
    )
    device = replace(load_device("zhao-2019"), accelerometer=given)
    found = analyze(device, matrices=True, validate=False).matrices["accelerometer"]
    K = np.array([1000.0, 1500.0, 700.0])
    n = counts(K, ANGLE, BIAS) / K[:, None]

    before = found.T @ (n - found.bias_sensor[:, None])
    after = found.T @ n - found.bias_body[:, None]
    assert_allclose(before, INPUT, rtol=1e-12)
    assert_allclose(after, INPUT, rtol=1e-12)
    assert_allclose(found.M @ INPUT + BIAS[:, None], n, rtol=1e-12)
    wrong = found.T.T @ (n - found.bias_sensor[:, None])
    assert (np.abs(wrong / INPUT - 1.0) > 1e-3).any(axis=0).all()


def test_a_simulated_calibration_compensates_its_own_readings():
    """Errors found pulse by pulse, through the map: the input of the same unit back."""
    device = sensor("accelerometer", {}, bias=BIAS, angle=ANGLE)
    plan = procedure(dwell=10.0, sample_rate=10.0)
    errors = simulate((device,), plan, run=0)
    problem, invert, _ = solved(device, plan)
    found = invert(errors[:, None])[:, 0]
    T, b, after = found[:9].reshape(3, 3), found[9:12], found[12:]
    K = np.array([2.0, 3.0, 4.0])
    n = counts(K, ANGLE, BIAS) / (K * (1.0 + errors[:3]))[:, None]

    assert_allclose(T @ (n - b[:, None]), INPUT, rtol=1e-9)
    assert_allclose(T @ n - after[:, None], INPUT, rtol=1e-9)
    assert len(problem.outputs) == found.size


def test_uncertainties_by_hand():
    """Small angles: u(T_xy) = u(xz); T b has u(b) and b times u of two angles.

    b_x' = b_x - xz b_y + xy b_z to first order, all independent here.
    """
    u_angle, u_bias = 200.0 * ARCSEC, 1.0 * MICRO_G
    lines = {"mounting_repeatability": u_angle, "bias_repeatability": u_bias}
    device = sensor("accelerometer", lines, bias=BIAS)
    _, _, law = solved(device, procedure())
    u = law.standard_uncertainty
    T = u[:9].reshape(3, 3)

    assert_allclose(T[~np.eye(3, dtype=bool)], u_angle, rtol=1e-5)
    assert (np.diag(T) < 1e-2 * u_angle).all()
    assert_allclose(u[9:12], u_bias, rtol=1e-9)
    b = np.abs(BIAS)
    expected = [
        hypot(u_bias, u_angle * b[1], u_angle * b[2]),
        hypot(u_bias, u_angle * b[0], u_angle * b[2]),
        hypot(u_bias, u_angle * b[0], u_angle * b[1]),
    ]
    assert_allclose(u[12:], expected, rtol=1e-5)
    assert (u[12:] > 1.5 * u_bias).all()  # without the angles it would be u(b)


def test_monte_carlo_agrees_with_the_law():
    """All elements and both biases, of angles that are not small, with covariance.

    T and T b are correlated through the angles, by more than a half somewhere.
    """
    lines = {"mounting_repeatability": 600.0 * ARCSEC, "bias_stability": 2e-4}
    device = sensor("accelerometer", lines, bias=20.0 * BIAS, angle=ANGLE)
    problem, _, law = solved(device, procedure())
    sent = pickle.dumps(problem)  # as to a worker
    drawn = sample(pickle.loads(sent), trials=TRIALS, seed=1)  # noqa: S301 - from here
    bound = SIGMAS / np.sqrt(2.0 * TRIALS)

    assert_allclose(drawn.standard_uncertainty, law.standard_uncertainty, rtol=bound)
    both = drawn.covariance[0:9, 12:15]  # of T and T b
    u = drawn.standard_uncertainty
    assert (np.abs(both / np.outer(u[:9], u[12:])) > 0.5).any()
    scale = np.outer(law.standard_uncertainty, law.standard_uncertainty)
    limit = SIGMAS * np.sqrt(2.0 / TRIALS)
    assert_allclose(
        drawn.covariance / scale, law.covariance / scale, rtol=0, atol=limit
    )


def test_documents_have_the_matrices_where_they_are_asked_for():
    """JSON in printed units, its convention beside; without the option, no key."""
    args = ("analyze", "zhao-2019", "--no-validate", "--json", "-")
    found = call(*args, "--matrices", "--outputs", "gyro.bias").document["matrices"]
    gyro = found["gyro"]

    assert "T = inv(M)" in found["convention"]
    assert (gyro["bias_sensor"]["unit"], gyro["bias_sensor"]["value"]) == (
        "deg/h",
        pytest.approx([2.5] * 3, rel=1e-12, abs=0.0),
    )
    product = np.array(gyro["body_to_sensor"]["value"]) @ np.array(
        gyro["sensor_to_body"]["value"]
    )
    assert_allclose(product, np.eye(3), rtol=0, atol=1e-15)
    u = [
        *np.ravel(gyro["sensor_to_body"]["standard_uncertainty"]),
        *gyro["bias_sensor"]["standard_uncertainty"],
        *gyro["bias_body"]["standard_uncertainty"],
    ]
    assert_allclose(np.sqrt(np.diag(gyro["covariance"])), u, rtol=1e-12)
    assert "matrices" not in call(*args).document


def test_what_a_test_does_not_find_makes_no_matrix():
    """A rate table finds no angle: a warning says which matrices there are not."""
    plan = load_procedure("one-axis-rate-table")
    found = analyze(
        load_device("zhao-2019"), procedure=plan, matrices=True, validate=False
    )

    assert found.matrices == {}
    (said,) = [text for text in found.warnings if "matrices" in text]
    assert "gyro mounting angle" in said


def test_page_and_terminal_print_the_same_matrices():
    """Convention, value and u of every element, the exact ones behind the rounded."""
    found = analyze(load_device("zhao-2019"), matrices=True, validate=False)
    (section,) = [one for one in budget_answer(found) if one.name == "matrices"]
    assert [*page_of("matrices", found)] == [section]
    convention, _, both = section.blocks
    assert convention.words == (CONVENTION,)
    for panel, one in zip(both.blocks, found.matrices.values(), strict=True):
        (table,) = panel.blocks
        scale = [output.si_per_unit for output in one.outputs]
        printed = [
            [cell.exact for cell in row[1:]]
            for group in table.groups
            for row in group.rows
        ]
        T, u_T, *biases = (
            *(np.ravel(printed[k : k + 3]) for k in (0, 3)),
            *printed[6:],
        )
        values = np.concatenate([T, biases[0], biases[2]])
        u = np.concatenate([u_T, biases[1], biases[3]])
        assert_allclose(values, one.value / scale, rtol=1e-15)
        assert_allclose(u, one.standard_uncertainty / scale, rtol=1e-15)

    without = analyze(load_device("zhao-2019"), validate=False)
    assert [*page_of("matrices", without)] == []
