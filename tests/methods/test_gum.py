"""The law of propagation: published examples, closed forms, bookkeeping."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.errors import ProblemError
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.problem import Group, Output, Problem

pytestmark = pytest.mark.kernels


def additive(*u):
    """Return Y = X1 + X2 + ... of independent rectangular inputs."""
    return Problem(
        groups=tuple(
            Group.independent(f"X{i}", u=value, distribution=UNIFORM)
            for i, value in enumerate(u, start=1)
        ),
        outputs=(Output(name="Y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )


@pytest.mark.parametrize(
    ("u", "printed_u", "printed_end"),
    [((1.0, 1.0, 1.0, 1.0), "2.0", "3.92"), ((1.0, 1.0, 1.0, 10.0), "10.1", "19.9")],
)
def test_jcgm_101_9_2_additive_model(u, printed_u, printed_end):
    """The law gives u and the 95 % interval of JCGM 101:2008, 9.2.3 and 9.2.4."""
    law = propagate(additive(*u))
    assert f"{law.standard_uncertainty[0]:.1f}" == printed_u
    assert_allclose(
        law.interval(0.95)[0],
        [-float(printed_end), float(printed_end)],
        rtol=0,
        atol=10.0 ** -len(printed_end.partition(".")[2]),
    )


def end_gauge():
    """Return JCGM 100:2008, H.1, lengths in nm."""
    inputs = {
        "ls": (50_000_623.0, 25.0),
        "d": (215.0, 9.7),
        "d_alpha": (0.0, 0.58e-6),
        "theta": (-0.1, 0.41),
        "alpha_s": (11.5e-6, 1.2e-6),
        "d_theta": (0.0, 0.029),
    }

    def length(x):
        ls, d, d_alpha, theta, alpha_s, d_theta = x
        return (ls + d - ls * (d_alpha * theta + alpha_s * d_theta))[None]

    return Problem(
        groups=tuple(
            Group.independent(name, mean=mean, u=u)
            for name, (mean, u) in inputs.items()
        ),
        outputs=(Output(name="l", unit="nm", si_per_unit=1e-9),),
        function=length,
    )


def test_gum_h1_with_and_without_second_order_terms():
    """u(l) is 32 nm (31.71) to first order and 34 nm (33.91) to second: H.1.7."""
    law = propagate(end_gauge())
    assert_allclose(np.sqrt(law.first_order[0, 0]), 31.71, rtol=0, atol=0.01)
    assert_allclose(law.standard_uncertainty[0], 33.91, rtol=0, atol=0.01)
    assert_allclose(law.mean[0], 50_000_838.0, rtol=0, atol=1.0)


@pytest.mark.parametrize("shape", [NORMAL, UNIFORM, TRIANGULAR, ARCSINE])
def test_square_of_an_input_of_any_shape(shape):
    """Y = x^2 at mean 0 has mean u^2 and variance (kurtosis - 1) u^4, exactly."""
    u = 0.3
    problem = Problem(
        groups=(Group.independent("x", u=u, distribution=shape),),
        outputs=(Output(name="y"),),
        function=lambda x: x**2,
    )
    law = propagate(problem)
    assert_allclose(law.mean[0], u**2, rtol=1e-14)
    assert_allclose(law.covariance[0, 0], (shape.kurtosis - 1.0) * u**4, rtol=1e-12)


def test_product_at_zero_has_only_the_second_order():
    """Y = x1 x2 at (0, 0): first order says 0, the truth is u1 u2, as interaction."""
    problem = Problem(
        groups=(Group.independent("a", u=2.0), Group.independent("b", u=3.0)),
        outputs=(Output(name="y"),),
        function=lambda x: (x[0] * x[1])[None],
    )
    law = propagate(problem)
    assert law.first_order[0, 0] == 0.0
    assert_allclose(law.standard_uncertainty[0], 6.0, rtol=1e-14)
    assert_allclose(law.interaction_variance, [36.0], rtol=1e-14)


def test_product_of_correlated_normals():
    """Var(x1 x2) = u1^2 u2^2 (1 + r^2) at zero means: correlation counts."""
    C = np.array([[4.0, 3.0], [3.0, 9.0]])
    problem = Problem(
        groups=(
            Group(
                name="x", mean=np.zeros(2), covariance=C, distributions=(NORMAL, NORMAL)
            ),
        ),
        outputs=(Output(name="y"),),
        function=lambda x: (x[0] * x[1])[None],
    )
    law = propagate(problem)
    assert_allclose(law.mean, [3.0], rtol=1e-14)
    assert_allclose(law.covariance, [[36.0 + 9.0]], rtol=1e-14)


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_contributions_add_up_to_the_total(reference):
    """Sources and interaction sum to the variance of every one of the 24 outputs."""
    law = propagate(
        calibration_problem(
            (paper_gyro(scale_factor_asymmetry=1e-3), paper_accelerometer()),
            procedure(formulas="paper"),
            reference=reference,
        )
    )
    total = law.source_variance.sum(axis=0) + law.interaction_variance
    assert_allclose(total, np.diag(law.covariance), rtol=1e-12)


def test_covariance_between_outputs_holds_second_order_terms():
    """Two outputs x1 x2 and x1 x2 + x3 at zero share the variance of the product."""
    problem = Problem(
        groups=tuple(Group.independent(n, u=1.0) for n in ("a", "b", "c")),
        outputs=(Output(name="y"), Output(name="z")),
        function=lambda x: np.stack([x[0] * x[1], x[0] * x[1] + x[2]]),
    )
    assert_allclose(propagate(problem).covariance, [[1.0, 1.0], [1.0, 2.0]], rtol=1e-14)


def test_law_agrees_with_monte_carlo_on_uniform_inputs_that_multiply():
    """(x1 + 2) x2 with uniform x: u equals 200,000 trials within sampling error."""
    problem = Problem(
        groups=(
            Group.independent("a", u=0.5, distribution=UNIFORM),
            Group.independent("b", u=1.0, distribution=TRIANGULAR),
        ),
        outputs=(Output(name="y"),),
        function=lambda x: ((x[0] + 2.0) * x[1])[None],
    )
    drawn = sample(problem, trials=200_000, seed=1)
    u = propagate(problem).standard_uncertainty[0]
    # Kurtosis of the product is below 4: standard error below u sqrt(3/(4 n)).
    limit = 4.0 * np.sqrt(3.0 / (4.0 * 200_000))
    assert abs(drawn.standard_uncertainty[0] / u - 1.0) < limit


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda x: x * np.inf, "no finite value of y"),
        (lambda x: (x - 0.5) * np.nan, "no finite value of y"),
        (lambda x: x * 1e300 * 1e10, "no finite derivative of y"),
        (lambda x: x * 1e200, "no finite variance of y"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_law_never_returns_what_is_no_number(function, words):
    """Values, derivatives and variances that are not finite raise ProblemError."""
    problem = Problem(
        groups=(Group.independent("x", u=1.0),),
        outputs=(Output(name="y"),),
        function=function,
    )
    with pytest.raises(ProblemError, match=words):
        propagate(problem)
