"""Taylor arithmetic: derivatives against closed forms and the complex step."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.methods.jets import expand


@pytest.mark.parametrize(
    ("function", "first", "second"),
    [
        (np.sin, np.cos, lambda x: -np.sin(x)),
        (np.cos, lambda x: -np.sin(x), lambda x: -np.cos(x)),
        (np.exp, np.exp, np.exp),
        (np.log, lambda x: 1 / x, lambda x: -1 / x**2),
        (np.sqrt, lambda x: 0.5 / np.sqrt(x), lambda x: -0.25 * x**-1.5),
        (
            np.tan,
            lambda x: 1 / np.cos(x) ** 2,
            lambda x: 2 * np.tan(x) / np.cos(x) ** 2,
        ),
        (np.arctan, lambda x: 1 / (1 + x**2), lambda x: -2 * x / (1 + x**2) ** 2),
        (np.square, lambda x: 2 * x, lambda x: 2.0),
        (np.reciprocal, lambda x: -(x**-2), lambda x: 2 * x**-3),
        (lambda x: x**3, lambda x: 3 * x**2, lambda x: 6 * x),
        (lambda x: x**0, lambda x: 0.0, lambda x: 0.0),
        (lambda x: 2.0**x, lambda x: np.log(2) * 2**x, lambda x: np.log(2) ** 2 * 2**x),
        (
            lambda x: x**x,
            lambda x: x**x * (np.log(x) + 1),
            lambda x: x**x * ((np.log(x) + 1) ** 2 + 1 / x),
        ),
        (
            lambda x: 1.0 / (3.0 - x),
            lambda x: (3 - x) ** -2,
            lambda x: 2 * (3 - x) ** -3,
        ),
        (lambda x: -x / 2.0 + +x, lambda x: 0.5, lambda x: 0.0),
    ],
)
def test_functions_of_one_variable(function, first, second):
    """Value, first and second derivative equal the closed form."""
    x = 0.7
    jet = expand(function, np.array([x]))
    assert_allclose(jet.value[0], function(np.array([x]))[0], rtol=1e-14)
    assert_allclose(jet.C[0, 0], first(x), rtol=1e-13)
    assert_allclose(jet.H[0, 0, 0], second(x), rtol=1e-13)


def test_square_has_its_second_derivative_at_zero():
    """x^2 at 0 has the Hessian 2, where the first derivative vanishes."""
    assert_allclose(expand(lambda x: x**2, np.zeros(1)).H, [[[2.0]]], rtol=0)


def test_outputs_that_no_input_reaches_are_constants():
    """A plain number among the outputs has zero derivatives."""
    found = expand(
        lambda x: np.stack([x[0], 0 * x[1].astype(object) * 0 + 4.0]), np.ones(2)
    )
    assert_allclose(found.value, [1.0, 4.0], rtol=0)
    assert_allclose(found.C[1], [0.0, 0.0], rtol=0)


@pytest.mark.parametrize("formulas", ["corrected", "paper"])
@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_calibration_sensitivities_equal_the_complex_step(formulas, reference):
    """All sensitivities of the calibration agree with Im f(x + ih)/h to 1e-12."""
    problem = calibration_problem(
        (
            paper_gyro(scale_factor_asymmetry=1e-3, scale_factor_nonlinearity=1e-5),
            paper_accelerometer(velocity_random_walk=1e-5),
        ),
        procedure(formulas=formulas),
        reference=reference,
    )
    n, step = problem.n_inputs, 1e-30
    x = problem.mean[:, None] + 1j * step * np.eye(n)
    C = problem.evaluate(x).imag / step
    jet = expand(problem.evaluate, problem.mean).C
    scale = np.maximum(np.abs(C), np.abs(jet)) + 1e-300
    large = scale > 1e-12 * scale.max(axis=1, keepdims=True)
    assert (np.abs(jet - C) / scale)[large].max() < 1e-12


def test_calibration_hessians_equal_the_complex_step_of_the_gradient():
    """Second derivatives agree with differences of the complex-step gradient.

    f(x + ih e_i + e_j t) is rational of low degree in t, so a central difference of the
    complex-step gradient with t of the inputs' own size is good to 1e-5.
    """
    problem = calibration_problem(
        (paper_gyro(scale_factor_asymmetry=1e-3),), procedure(formulas="paper")
    )
    H = expand(problem.evaluate, problem.mean).H
    u = np.concatenate([np.sqrt(np.diag(g.covariance)) for g in problem.groups])
    n, step = problem.n_inputs, 1e-30
    scaled = H * np.outer(u, u)
    for j in range(n):
        t = u[j]
        ends = []
        for sign in (1.0, -1.0):
            x = problem.mean.copy()
            x[j] += sign * t
            y = problem.evaluate(x[:, None] + 1j * step * np.eye(n))
            ends.append(y.imag / step)
        other = (ends[0] - ends[1]) / 2.0 * u  # H_ij u_i u_j
        size = np.abs(scaled).max(axis=(1, 2))[:, None] + 1e-300
        # Rounding of the two gradients bounds what their difference can show.
        rounding = 1e-14 * np.abs(ends[0]).max(axis=1, keepdims=True) * u.max()
        assert (np.abs(other - scaled[:, :, j]) < 1e-5 * size + rounding).all()
