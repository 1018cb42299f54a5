"""The law as a function of source sizes: against the law itself, and differences."""

from __future__ import annotations

import builders
import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.distributions import ARCSINE, NORMAL, UNIFORM
from budget.methods.gum import propagate
from budget.methods.scaling import scaled_law
from budget.problem import Group, Output, Problem


def curved(scale=(1.0, 1.0, 1.0)):
    """Return a Problem with strong second-order terms and several shapes."""

    def function(x):
        a, b, c, d = x
        return np.stack([a * b + 0.3 * c**2 + d, a + b * c + 0.5 * d**2])

    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    return Problem(
        groups=(
            Group(
                name="pair",
                mean=np.array([0.5, -0.2]),
                covariance=scale[0] ** 2 * covariance,
                distributions=(NORMAL, NORMAL),
            ),
            Group.independent("flat", u=scale[1] * 0.3, distribution=UNIFORM),
            Group.independent("arc", u=scale[2] * 0.2, distribution=ARCSINE),
        ),
        outputs=(Output(name="one"), Output(name="two")),
        function=function,
    )


def asymmetric_gyro():
    """Return the paper's gyro with an asymmetry and no nominal bias."""
    gyro = builders.paper_gyro(scale_factor_asymmetry=1250e-6)
    return calibration_problem((gyro,), builders.procedure(), reference="next_turn_on")


@pytest.mark.parametrize(
    "problem", [curved(), asymmetric_gyro()], ids=["curved", "gyro"]
)
def test_at_the_present_sizes_it_is_the_law(problem):
    """With all factors 1, mean, variance and single variances are propagate's."""
    law, scaled = propagate(problem), scaled_law(problem)
    one = np.ones(len(scaled.sources))

    assert_allclose(scaled.mean(one), law.mean, rtol=1e-12, atol=1e-25)
    assert_allclose(scaled.variance(one), np.diag(law.covariance), rtol=1e-12)
    assert_allclose(scaled.variance_alone(one).T, law.source_variance, rtol=1e-12)


def test_any_factors_are_the_law_of_the_resized_problem():
    """Factors on the sources give what a Problem with such sources gives."""
    s = np.array([0.3, 2.5, 1.7])
    law, scaled = propagate(curved(tuple(s))), scaled_law(curved())

    assert_allclose(scaled.mean(s), law.mean, rtol=1e-12)
    assert_allclose(scaled.variance(s), np.diag(law.covariance), rtol=1e-12)


def test_products_of_sources_are_in_the_variance():
    """Control: without second order the resized law would be missed by 1 % or more."""
    s = np.array([0.3, 2.5, 1.7])
    scaled = scaled_law(curved())

    assert (np.abs(scaled.first @ s**2 / scaled.variance(s) - 1.0) > 0.01).all()


def test_the_gradient_is_that_of_central_differences():
    """The slope of log(end) over log(s) is that of steps of 1e-5, to their error."""
    scaled, k = scaled_law(curved()), np.array([1.96, 2.5])
    s, step = np.array([0.3, 2.5, 1.7]), 1e-5
    for g in range(s.size):
        up, down = s.copy(), s.copy()
        up[g] *= np.exp(step)
        down[g] *= np.exp(-step)
        slope = (np.log(scaled.end(up, k)) - np.log(scaled.end(down, k))) / (2 * step)
        assert_allclose(scaled.log_end_gradient(s, k)[:, g], slope, rtol=1e-7)


def test_selected_outputs_keep_their_numbers():
    """A selection in another order has the rows of the whole law."""
    scaled = scaled_law(curved())
    s = np.array([1.1, 0.9, 2.0])

    assert_allclose(
        scaled.select(["two", "one"]).variance(s), scaled.variance(s)[::-1], rtol=0
    )


def test_an_output_without_spread_has_no_gradient():
    """All sources at zero give ends at the nominal value and a gradient of 0."""
    scaled = scaled_law(curved())
    s, k = np.zeros(3), np.full(2, 2.0)

    assert_allclose(scaled.end(s, k), np.abs(scaled.value), rtol=1e-15)
    assert not scaled.log_end_gradient(s, k).any()
