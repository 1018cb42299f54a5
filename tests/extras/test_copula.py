"""Correlated inputs of any shape: the covariance that was given is the one drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.errors import ProblemError
from budget.methods.gum import propagate
from budget.methods.sobol import sobol
from budget.methods.trials import first_trials
from budget.methods.validation import validate
from budget.problem import Group, Output, Problem
from jcgm import EXPONENTIAL, gamma, lognormal, samples, scaled_student_t, student_t
from jcgm.copula import Copula, normal_scores

FIELDS = ("name", "mean", "covariance", "distributions")
PAIR = np.array([[0.0, 1.0], [1.0, 0.0]])


def score(r, *shapes):
    """Return the correlation of the scores of two quantities."""
    return normal_scores(np.eye(2) + r * PAIR, shapes, where="pair")[0, 1]


def problem(correlation, shapes, *, u=1.0, function=np.copy, outputs=None):
    """Return a function of one correlated group as a Problem."""
    R = np.array(correlation, dtype=float)
    size = np.broadcast_to(u, len(R))
    return Problem(
        groups=(
            Copula(
                name="x",
                mean=np.arange(len(R)) + 1.0,
                covariance=R * np.outer(size, size),
                distributions=shapes,
            ),
        ),
        outputs=tuple(Output(name=f"y{i}") for i in range(outputs or len(R))),
        function=function,
    )


@pytest.mark.parametrize("r", [-1.0, -0.9, -1e-6, 0.3, 0.99, 1.0])
def test_scores_of_uniform_quantities(r):
    """Uniform quantities correlated by r have scores correlated by 2 sin(pi r/6)."""
    assert_allclose(
        score(r, UNIFORM, UNIFORM), 2.0 * np.sin(np.pi * r / 6.0), rtol=1e-9
    )


@pytest.mark.parametrize("rho", [-0.9, 0.4, 0.95])
def test_scores_of_lognormal_quantities(rho):
    """exp(a s) and exp(b s) have (e^(ab rho) - 1)/sqrt((e^aa - 1)(e^bb - 1))."""
    a, b = 0.5, 0.8
    r = np.expm1(rho * a * b) / np.sqrt(np.expm1(a**2) * np.expm1(b**2))
    assert_allclose(score(r, lognormal(a), lognormal(b)), rho, rtol=1e-9)


@pytest.mark.parametrize("r", [-0.9, 0.4, 0.97])
def test_scores_of_a_normal_and_a_uniform_quantity(r):
    """With a uniform quantity a normal one has the correlation rho sqrt(3/pi)."""
    assert_allclose(score(r, NORMAL, UNIFORM), r / np.sqrt(3.0 / np.pi), rtol=1e-9)


SHAPES = [
    (UNIFORM, TRIANGULAR),
    (ARCSINE, NORMAL),
    (EXPONENTIAL, gamma(0.6)),
    (lognormal(0.6), samples([1.0, 2.0, 4.0, 4.5, 9.0])),
    (scaled_student_t(9.0), UNIFORM),
]


def miss(drawn, r):
    """Return how many standard errors the covariance of unit quantities is from r."""
    products = drawn[0] * drawn[1]
    return (products.mean() - r) / (products.std() / np.sqrt(products.size))


@pytest.mark.parametrize("r", [-0.55, 0.8])
@pytest.mark.parametrize("shapes", SHAPES)
def test_the_given_covariance_is_drawn(shapes, r):
    """Over 200,000 trials it is met within 5 standard errors, and so is each shape."""
    n = 200_000
    case = problem(np.eye(2) + r * PAIR, shapes)
    x = first_trials(case, trials=n, seed=3) - case.mean[:, None]
    assert abs(miss(x, r)) < 5.0
    p = np.array([0.03, 0.5, 0.9])
    for row, shape in zip(x, shapes, strict=True):
        if shape.name != "samples":
            below = (row[:, None] <= shape.quantile(p)).mean(axis=0)
            assert (np.abs(below - p) < 5.0 * np.sqrt(p * (1.0 - p) / n)).all()
    law = propagate(case)
    assert_allclose(law.covariance, np.eye(2) + r * PAIR, rtol=1e-12)


def test_the_check_of_the_covariance_can_fail():
    """Control: scores with the quantities' own correlation miss it by far."""
    rng = np.random.default_rng(3)
    z = rng.multivariate_normal([0.0, 0.0], np.eye(2) - 0.55 * PAIR, 200_000).T
    x = np.exp(0.8 * z - 0.32) - 1.0
    assert abs(miss(x / np.sqrt(np.expm1(0.64)), -0.55)) > 30.0


def test_one_source_of_four_shapes_keeps_its_sizes():
    """Constants stay, sizes of 1e-9 and 1e3 side by side keep their correlation."""
    R = np.array(
        [
            [1.0, 0.5, 0.0, -0.3],
            [0.5, 1.0, 0.0, 0.2],
            [0.0, 0.0, 1.0, 0.0],
            [-0.3, 0.2, 0.0, 1.0],
        ]
    )
    u = np.array([1e-9, 1e3, 0.0, 1.0])
    case = problem(R, (UNIFORM, EXPONENTIAL, UNIFORM, NORMAL), u=u)
    x = first_trials(case, trials=100_000, seed=1)
    assert (x[2] == 3.0).all()
    rows = [0, 1, 3]
    x = (x[rows] - case.mean[rows, None]) / u[rows, None]
    for i, j in ((0, 1), (0, 2), (1, 2)):
        assert abs(miss(x[[i, j]], R[rows[i], rows[j]])) < 5.0


@pytest.mark.parametrize(
    ("correlation", "shapes", "words"),
    [
        (np.eye(2) - 0.7 * PAIR, (EXPONENTIAL,) * 2, r"-0\.7; .* -0\.6449 to 1"),
        (np.eye(2) + 0.98 * PAIR, (NORMAL, UNIFORM), r"-0\.9772 to 0\.9772"),
        (np.eye(2) + 0.1 * PAIR, (NORMAL, student_t(4.0)), "scaled_student_t"),
        # The scores of three uniform quantities at -1/2 would need -0.5176 each.
        (1.5 * np.eye(3) - 0.5, (UNIFORM,) * 3, "copula .* eigenvalue -0.0353"),
    ],
)
def test_what_the_shapes_cannot_have_is_refused(correlation, shapes, words):
    """The message names the inputs and the correlations that are possible."""
    with pytest.raises(ProblemError, match=f"input group 'x'.*{words}"):
        problem(correlation, shapes)


def total(x):
    """Return the sum of all inputs."""
    return x.sum(axis=0, keepdims=True)


def test_the_law_of_a_sum_holds_and_sobol_takes_the_source_whole():
    """u^2 of a sum of correlated uniform inputs is 1 + 1 + 2 r; one source makes it."""
    R = np.eye(2) + 0.6 * PAIR
    case = problem(R, (UNIFORM, UNIFORM), function=total, outputs=1)
    law = propagate(case)
    assert_allclose(law.covariance, [[3.2]], rtol=1e-12)
    y = first_trials(case, trials=200_000, seed=2)[0]
    # The kurtosis of such a sum is below 3.
    assert abs(y.std() / np.sqrt(3.2) - 1.0) < 5.0 * np.sqrt(0.5 / 200_000)
    indices = sobol(case, samples=256)
    assert_allclose(indices.first.value, 1.0, rtol=1e-6)
    with pytest.raises(ProblemError, match="no indices of their own"):
        sobol(case, by_input=True)


def test_sobol_points_have_the_given_covariance():
    """Of x0 + x1 + x2 with x2 apart the source makes 3.2/4.2, without the tangent."""
    group = problem(np.eye(2) + 0.6 * PAIR, (UNIFORM, UNIFORM)).groups[0]
    case = Problem(
        groups=(group, Group.independent("c", u=1.0)),
        outputs=(Output(name="y"),),
        function=total,
    )
    r = sobol(case, samples=4096, control_variate=False)
    assert r.first.low[0, 0] - 0.005 < 3.2 / 4.2 < r.first.high[0, 0] + 0.005
    assert abs(r.first.value[0, 0] - 3.2 / 4.2) < 0.01


def test_validation_finds_a_bent_model_of_correlated_shapes():
    """For x0 x1 of exponential inputs correlated by 0.9 the law says it does not hold.

    To second order it counts them as jointly normal.
    """
    case = problem(
        np.eye(2) + 0.9 * PAIR,
        (EXPONENTIAL, EXPONENTIAL),
        function=lambda x: (x[0] * x[1])[None],
        outputs=1,
    )
    (verdict,) = validate(case, propagate(case), max_trials=60_000)
    assert not verdict.holds


@pytest.mark.parametrize("shapes", [(NORMAL, NORMAL), (UNIFORM, EXPONENTIAL)])
def test_a_group_takes_a_copula_only_where_it_must(shapes):
    """Jointly normal inputs and uncorrelated ones are drawn as they always were."""
    r = 0.5 if shapes[0] == NORMAL else 0.0
    (group,) = problem(np.eye(2) + r * PAIR, shapes).groups
    assert group.drawn == shapes
    plain = Group(**{name: getattr(group, name) for name in FIELDS})
    for one, other in zip(
        *(
            (first_trials(case, trials=100), sobol(case, samples=64).first.value)
            for case in (
                replace(problem(np.eye(2), shapes), groups=(this,))
                for this in (group, plain)
            )
        ),
        strict=True,
    ):
        assert_allclose(one, other, rtol=0)


def test_a_group_without_a_copula_refuses_correlated_shapes():
    """A covariance does not say how they go together; the refusal says what does."""
    with pytest.raises(ProblemError, match=r"'x'.* not all normal.*jcgm\.Copula"):
        Group(
            name="x",
            mean=[0.0, 0.0],
            covariance=[[1.0, 0.5], [0.5, 1.0]],
            distributions=(NORMAL, UNIFORM),
        )
