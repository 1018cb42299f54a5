"""Schemes: weights with W A = I, or refused in words; windows that cannot tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import procedure
from numpy.testing import assert_allclose

from budget.calibration.schemes import scheme_of
from budget.errors import CallError
from budget.model.scheme import least_squares
from budget.model.windows import INNER, MIDDLE, OUTER, Setting

HOW = procedure(latitude=50.0, rate=0.3, turns=3, azimuths=(0.0, 90.0, 200.0))


def design(scheme):
    """Return A, the rows (mean input, 1) of the windows."""
    inputs = scheme.turn + scheme.standing
    return np.column_stack([inputs, np.ones(len(inputs))])


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
@pytest.mark.parametrize("how", [procedure(), HOW], ids=["paper", "other"])
def test_weights_are_unbiased(owner, how):
    """W A = I for every axis, to 1e-12 of the size of its terms."""
    scheme = scheme_of(owner, how)
    A = design(scheme)
    terms = np.abs(scheme.weights) @ np.abs(A)
    missed = np.abs(scheme.weights @ A - np.eye(4))
    assert (missed <= 1e-12 * np.maximum(terms, 1.0)).all()


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
def test_biased_weights_are_refused_with_the_parameter(owner):
    """A weight that is a thousandth too large names axis, statistic and input."""
    scheme = scheme_of(owner, procedure())
    wrong = scheme.weights.copy()
    wrong[1, 2] *= 1.001
    with pytest.raises(CallError, match=r"of axis y the response to z takes 1\.001"):
        replace(scheme, weights=wrong)


def test_least_squares_gives_weights_without_bias():
    """The twelve positions by least squares: W A = I, biases from all dwells."""
    scheme = scheme_of("accelerometer", procedure())
    A = design(scheme)
    W = least_squares(A[:, :3])
    assert_allclose(W @ A, np.eye(4), rtol=0, atol=1e-14 * 10)
    assert_allclose(W[3], np.full(12, 1.0 / 12.0), rtol=1e-12)
    # The responses are those of eq. (5): each face is held equally long.
    assert_allclose(W[:3], scheme.weights[0, :3], rtol=0, atol=1e-16)


def test_weighted_least_squares_is_the_best_of_both():
    """With a covariance no statistic has a larger variance than without (Aitken)."""
    A = design(scheme_of("accelerometer", procedure()))
    covariance = np.diag(np.linspace(1.0, 4.0, 12)) + 0.5
    plain, best = least_squares(A[:, :3]), least_squares(A[:, :3], covariance)
    assert_allclose(best @ A, np.eye(4), rtol=0, atol=1e-13)
    spread = [np.diag(W @ covariance @ W.T) for W in (best, plain)]
    assert (spread[0] <= spread[1] * (1.0 + 1e-12)).all()
    assert spread[0][3] < 0.99 * spread[1][3]


def test_windows_that_cannot_tell_say_what():
    """Without a face down the response to z and the bias are one number."""
    up = np.array([[0.0, 0.0, 9.8], [9.8, 0.0, 0.0], [-9.8, 0.0, 0.0], [0.0, 9.8, 0.0]])
    up = np.vstack([up, [[0.0, -9.8, 0.0]]])[[0, 1, 2, 3, 4]]
    assert least_squares(up).shape == (4, 5)
    level = np.array([[0.0, 0.0, 9.8]] * 4)
    with pytest.raises(CallError, match="response to x from nothing at all"):
        least_squares(level)


@pytest.mark.parametrize("axis", [INNER, MIDDLE, OUTER])
@pytest.mark.parametrize("angle", [0.7, -2.0, 40.0])
def test_mean_attitude_over_a_turn_is_the_mean_of_attitudes(axis, angle):
    """The closed form agrees with a quadrature that is exact to rounding."""
    start = Setting(outer=0.4, middle=-0.9, inner=1.3)
    names = {INNER: "inner", MIDDLE: "middle", OUTER: "outer"}
    nodes, weights = np.polynomial.legendre.leggauss(128)
    steps = 0.5 * angle * (1.0 + nodes)
    at = [
        replace(start, **{names[axis]: getattr(start, names[axis]) + step}).to_body
        for step in steps
    ]
    found = replace(start, turning=axis, angle=angle)
    mean = np.tensordot(0.5 * weights, at, axes=1)
    assert_allclose(found.to_body, mean, rtol=0, atol=1e-12)
    # The axis of the turn stands still in body axes.
    assert_allclose(found.turn_axis @ found.turn_axis, 1.0, rtol=1e-14)
    moved = [R @ at[0].T @ found.turn_axis for R in (at[0], at[70])]
    assert_allclose(moved[1], moved[0], rtol=0, atol=1e-12)
