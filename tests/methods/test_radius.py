"""Radii of circles of a coverage, and lengths as outputs of a Problem."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import ndtri

from budget.distributions import NORMAL, UNIFORM
from budget.errors import ProblemError
from budget.methods.gum import propagate
from budget.methods.normality import end_accuracy
from budget.methods.radius import principal_variances, probability_within, radius_of
from budget.methods.scaling import scaled_law
from budget.methods.sobol import sobol
from budget.methods.trials import first_trials
from budget.names import Name
from budget.problem import Group, Output, Problem

COVERAGES = (0.05, 0.5, 0.9, 0.95, 0.999)
TRIALS = 200_000


@pytest.mark.parametrize("coverage", COVERAGES)
def test_the_two_ends_have_closed_forms(coverage):
    """Equal variances: Rayleigh's law; one alone: the normal law, here of 9 m^2."""
    found = radius_of(coverage, np.array([[9.0, 9.0], [9.0, 0.0]]))
    rayleigh = 3.0 * np.sqrt(-2.0 * np.log(1.0 - coverage))
    normal = 3.0 * ndtri((1.0 + coverage) / 2.0)
    assert_allclose(found, [rayleigh, normal], rtol=1e-9)


def test_cep_and_r95_of_a_circle():
    """1.17741 and 2.44775 sigma (PHYSICS: requirements on horizontal position)."""
    found = [radius_of(p, np.ones((2, 1)))[0] for p in (0.5, 0.95)]
    assert_allclose(found, [1.17741, 2.44775], rtol=2e-6)


@pytest.mark.parametrize("coverage", COVERAGES)
@pytest.mark.parametrize("ratio", [0.9, 0.3, 1e-2, 1e-5])
def test_a_radius_has_its_coverage_by_another_integral(ratio, coverage):
    """P(R) again over one coordinate: phi(x) (2 Phi(h/s) - 1) dx, by Simpson's rule."""
    from scipy.integrate import simpson
    from scipy.special import erf

    (R,) = radius_of(coverage, np.array([[1.0], [ratio**2]]))
    t = np.linspace(-np.pi / 2, np.pi / 2, 200_001)
    x, h = R * np.sin(t), R * np.cos(t)
    density = np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)
    found = simpson(density * erf(h / ratio / np.sqrt(2)) * h, x=t)
    assert_allclose(found, coverage, rtol=1e-7)


def test_nothing_varies():
    """A vector that is always 0 lies in a circle of radius 0."""
    assert radius_of(0.5, np.zeros((2, 1))) == [0.0]
    assert probability_within(np.array([1.0]), np.zeros((2, 1))) == [1.0]


def test_principal_variances_are_eigenvalues():
    """Of matrices of every shape, those without a small one and without two."""
    rng = np.random.default_rng(1)
    A = rng.standard_normal((50, 2, 2))
    U = A @ A.swapaxes(1, 2)
    found = principal_variances(U[:, 0, 0], U[:, 1, 1], U[:, 0, 1])
    assert_allclose(found[::-1].T, np.linalg.eigvalsh(U), rtol=1e-9, atol=1e-12)


def two_and_length(distribution, between=0.3):
    """Return a plane vector of three sources: of both components, of one, of one."""
    names = Name("north"), Name("east")
    return Problem(
        groups=(
            Group.independent("a", u=1.0, distribution=distribution),
            Group.independent("b", u=0.5, distribution=distribution),
            Group.independent("c", u=2.0, distribution=distribution),
        ),
        outputs=(
            *(Output(name=name) for name in names),
            Output(name="radius", length_of=names),
        ),
        function=_Sums(between),
    )


class _Sums:
    def __init__(self, between):
        self.between = between

    def __call__(self, x):
        a, b, c = x
        return np.stack([a + self.between * c, b + c])


def test_a_length_by_law_and_trials():
    """DRMS, radii and probabilities of the law are those of trials."""
    problem = two_and_length(NORMAL)
    law = propagate(problem)
    y = first_trials(problem, trials=TRIALS, seed=3)[2]
    assert_allclose(law.standard_uncertainty[2] ** 2, y.var(), rtol=5 * TRIALS**-0.5)
    assert_allclose(law.standard_uncertainty[2] ** 2, 1 + 4 * 0.09 + 0.25 + 4.0)
    for p in COVERAGES:
        R = law.interval(p)[2, 1]
        inside = (np.abs(y) <= R).mean()
        assert abs(inside - p) < 5 * np.sqrt(p * (1 - p) / TRIALS)
        assert_allclose(law.probability_of_length(0, R), p, rtol=1e-9)
    wrong = 0.59 * law.standard_uncertainty[:2].sum()  # the rule of thumb of the CEP
    assert abs((np.abs(y) <= wrong).mean() - 0.5) > 5 * np.sqrt(0.25 / TRIALS)


def test_sources_of_a_length_add_up():
    """Its variances are those of the components; so are Sobol' indices of a vector."""
    problem = two_and_length(UNIFORM)
    law = propagate(problem)
    assert_allclose(law.source_variance[:, 2], [1.0, 0.25, 4.36], rtol=1e-12)
    assert_allclose(scaled_law(problem).first[2], [1.0, 0.25, 4.36], rtol=1e-12)
    indices = sobol(problem, samples=256, scrambles=4, seed=0)
    assert_allclose(
        indices.first.value[:, 2], [1 / 5.61, 0.25 / 5.61, 4.36 / 5.61], rtol=1e-6
    )


def test_the_law_knows_how_far_off_a_radius_may_be():
    """Uniform inputs: no radius of trials is farther off than the law says."""
    problem = two_and_length(UNIFORM)
    law = propagate(problem)
    y = np.sort(np.abs(first_trials(problem, trials=TRIALS, seed=4)[2]))
    for p in COVERAGES:
        R, bound = law.interval(p)[2, 1], end_accuracy(problem, law, p)[2]
        low, high = (
            y[int(TRIALS * (p + sign * 5 * np.sqrt(p * (1 - p) / TRIALS)))]
            for sign in (-1, 1)
        )
        assert low - bound <= R <= high + bound
        assert p > 0.95 or bound < R  # no excuse where tails are not asked for


def test_a_length_of_nothing_is_refused():
    """Its components are outputs before it, two of them."""
    with pytest.raises(ProblemError, match="two outputs that are no lengths"):
        Problem(
            groups=(Group.independent("a", u=1.0),),
            outputs=(
                Output(name="x"),
                Output(name="r", length_of=(Name("x"), Name("y"))),
            ),
            function=np.asarray,
        )
