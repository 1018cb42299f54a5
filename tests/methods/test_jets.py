"""Taylor arithmetic: derivatives against closed forms and the complex step."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.errors import ProblemError
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
        (np.abs, lambda x: 1.0, lambda x: 0.0),
        (lambda x: np.abs(-x), lambda x: 1.0, lambda x: 0.0),
        (np.expm1, np.exp, np.exp),
        (
            np.exp2,
            lambda x: np.log(2) * 2**x,
            lambda x: np.log(2) ** 2 * 2**x,
        ),
        (np.log1p, lambda x: 1 / (1 + x), lambda x: -1 / (1 + x) ** 2),
        (np.log2, lambda x: 1 / x / np.log(2), lambda x: -1 / x**2 / np.log(2)),
        (np.log10, lambda x: 1 / x / np.log(10), lambda x: -1 / x**2 / np.log(10)),
        (np.cbrt, lambda x: x ** (-2 / 3) / 3, lambda x: -2 / 9 * x ** (-5 / 3)),
        (
            lambda x: np.cbrt(-x),
            lambda x: -(x ** (-2 / 3)) / 3,
            lambda x: 2 / 9 * x ** (-5 / 3),
        ),
        (
            np.arcsin,
            lambda x: (1 - x**2) ** -0.5,
            lambda x: x * (1 - x**2) ** -1.5,
        ),
        (
            np.arccos,
            lambda x: -((1 - x**2) ** -0.5),
            lambda x: -x * (1 - x**2) ** -1.5,
        ),
        (np.sinh, np.cosh, np.sinh),
        (np.cosh, np.sinh, np.cosh),
        (
            np.tanh,
            lambda x: 1 / np.cosh(x) ** 2,
            lambda x: -2 * np.tanh(x) / np.cosh(x) ** 2,
        ),
        (
            np.arcsinh,
            lambda x: (1 + x**2) ** -0.5,
            lambda x: -x * (1 + x**2) ** -1.5,
        ),
        (
            lambda x: np.arccosh(x + 1.0),
            lambda x: (x * (x + 2)) ** -0.5,
            lambda x: -(x + 1) * (x * (x + 2)) ** -1.5,
        ),
        (
            np.arctanh,
            lambda x: 1 / (1 - x**2),
            lambda x: 2 * x / (1 - x**2) ** 2,
        ),
        (np.degrees, lambda x: 180 / np.pi, lambda x: 0.0),
        (np.deg2rad, lambda x: np.pi / 180, lambda x: 0.0),
        (
            lambda x: np.hypot(x, 2.0),
            lambda x: x / np.hypot(x, 2),
            lambda x: 4 / np.hypot(x, 2) ** 3,
        ),
        (
            lambda x: np.arctan2(2.0, x),
            lambda x: -2 / (4 + x**2),
            lambda x: 4 * x / (4 + x**2) ** 2,
        ),
        (
            lambda x: np.arctan2(x, x**2),
            lambda x: -1 / (1 + x**2),
            lambda x: 2 * x / (1 + x**2) ** 2,
        ),
        (
            lambda x: np.hypot(np.sin(x), np.cos(x)) * x**2,
            lambda x: 2 * x,
            lambda x: 2.0,
        ),
        (lambda x: np.where(x > 0.5, x**2, -x), lambda x: 2 * x, lambda x: 2.0),
        (lambda x: np.maximum(0.0, x) ** 2, lambda x: 2 * x, lambda x: 2.0),
        (lambda x: np.minimum(x**2, x), lambda x: 2 * x, lambda x: 2.0),
        (lambda x: np.clip(x, 0.0, 1.0), lambda x: 1.0, lambda x: 0.0),
        (lambda x: np.sign(x) * x, lambda x: 1.0, lambda x: 0.0),
        (
            lambda x: np.where(np.isfinite(x), np.sqrt(4.0 * x**2), 0.0),
            lambda x: 2.0,
            lambda x: 0.0,
        ),
    ],
)
def test_functions_of_one_variable(function, first, second):
    """Value, first and second derivative equal the closed form."""
    x = 0.7
    jet = expand(function, np.array([x]))
    assert_allclose(jet.value[0], function(np.array([x]))[0], rtol=1e-14)
    assert_allclose(jet.C[0, 0], first(x), rtol=1e-13)
    # Where the second derivative is 0, rounding of terms of about 1 may be left.
    atol = 1e-14 if second(x) == 0.0 else 0.0
    assert_allclose(jet.H[0, 0, 0], second(x), rtol=1e-13, atol=atol)


@pytest.mark.parametrize(
    ("function", "point"),
    [
        (np.abs, 0.0),
        (np.sqrt, 0.0),
        (np.sqrt, -1.0),
        (np.cbrt, 0.0),
        (np.log, 0.0),
        (np.log10, -2.0),
        (np.arcsin, 1.0),
        (np.arccos, 1.5),
        (np.arccosh, 1.0),
        (np.arctanh, 1.0),
        (lambda x: np.hypot(x, 0.0), 0.0),
        (lambda x: np.arctan2(x, -1.0), 0.0),
        (lambda x: x**1.5, 0.0),
        (lambda x: x**0.5, -1.0),
        (lambda x: 1.0 / x, 0.0),
        (lambda x: x / 0.0, 1.0),
        (lambda x: np.maximum(x, 2.0), 2.0),
        (lambda x: np.minimum(x, 2.0 * x - 2.0), 2.0),
        (lambda x: np.where(x > 2.0, x, 2.0), 2.0),
        (np.sign, 0.0),
        (np.exp, 1e4),
    ],
)
def test_no_derivatives_at_the_point_is_refused_in_words(function, point):
    """Corners, poles and branches at the nominal point raise ProblemError."""
    with pytest.raises(ProblemError, match=r"needs first and second derivatives"):
        expand(function, np.array([point]))


@pytest.mark.parametrize(
    "function",
    [
        lambda x: np.interp(x[0], [0.0, 1.0], [0.0, 1.0])[None],
        lambda x: np.array([[float(x[0, 0])]]),
        np.floor,
        lambda x: np.exp(1j * x).real,
    ],
)
def test_what_taylor_numbers_do_not_know_is_refused_in_words(function):
    """Other functions raise ProblemError that names what is known and sample()."""
    with pytest.raises(ProblemError, match=r"arctan2.*sample\(\)"):
        expand(function, np.array([0.3]))


def test_a_fault_of_the_function_stays_its_own():
    """What the function raises of plain numbers too is not made another error."""
    with pytest.raises(IndexError):
        expand(lambda x: x[3], np.array([0.3]))


def test_equal_numbers_may_be_compared():
    """A maximum of one and the same quantity is no corner."""
    jet = expand(lambda x: np.maximum(x * 2.0, x + x), np.array([0.3]))
    assert_allclose(jet.C, [[2.0]], rtol=0)


def test_constants_among_the_numbers_are_taken():
    """Plain numbers in an array of Taylor numbers pass through functions too."""

    def function(x):
        y = np.empty_like(x)
        y[0], y[1] = x[0], 4.0
        return np.sqrt(y)

    found = expand(function, np.array([9.0, 1.0]))
    assert_allclose(found.value, [3.0, 2.0], rtol=0)
    assert_allclose(found.C, [[1.0 / 6.0, 0.0], [0.0, 0.0]], rtol=1e-15)


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
