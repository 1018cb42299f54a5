"""Shapes: unit variance, stated moments, quantiles of scipy.stats, refusals."""

from __future__ import annotations

import pickle
from math import inf, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats
from scipy.integrate import quad

from budget.distributions import ARCSINE, LEAST, MOST, NORMAL, TRIANGULAR, UNIFORM
from budget.errors import ProblemError
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.methods.scaling import scaled_law
from budget.methods.sobol import sobol
from budget.problem import Group, Output, Problem
from jcgm import (
    EXPONENTIAL,
    Copula,
    beta,
    curvilinear_trapezoid,
    from_quantile,
    gamma,
    lognormal,
    samples,
    scaled_student_t,
    student_t,
    trapezoidal,
)


def logistic(p):
    """Return the quantile function of the logistic distribution at 5, scale 2."""
    return 5.0 + 2.0 * np.log(p / (1.0 - p))


READINGS = (1.0, 2.0, 2.0, 3.0, 7.0, -1e3)

# Every shape with scipy's own of the same form, where it has one.
REFEREES = [
    (NORMAL, stats.norm()),
    (UNIFORM, stats.uniform()),
    (TRIANGULAR, stats.triang(0.5)),
    (ARCSINE, stats.arcsine()),
    (scaled_student_t(5.0), stats.t(5.0)),
    (scaled_student_t(30.0), stats.t(30.0)),
    (trapezoidal(0.0), stats.triang(0.5)),
    (trapezoidal(0.3), stats.trapezoid(0.35, 0.65)),
    (trapezoidal(1.0), stats.uniform()),
    (lognormal(0.05), stats.lognorm(0.05)),
    (lognormal(0.7), stats.lognorm(0.7)),
    (gamma(0.5), stats.gamma(0.5)),
    (gamma(4.0), stats.gamma(4.0)),
    (EXPONENTIAL, stats.expon()),
    (beta(2.0, 5.0), stats.beta(2.0, 5.0)),
    (beta(0.5, 0.5), stats.arcsine()),
    (from_quantile(logistic, name="logistic"), stats.logistic()),
]
OTHERS = [
    *(curvilinear_trapezoid(r) for r in (1e-3, 0.4, 0.95)),
    samples(READINGS),
    scaled_student_t(3.0),
]
SHAPES = [shape for shape, _ in REFEREES] + OTHERS


def identify(value):
    """Return a name for a case."""
    return getattr(value, "name", None)


@pytest.mark.parametrize(("shape", "referee"), REFEREES, ids=identify)
def test_quantiles_are_those_of_scipy(shape, referee):
    """From 1e-12 to 1 - 1e-12 the standardised quantile of scipy.stats, to 1e-7 u."""
    p = np.concatenate([10.0 ** np.arange(-12.0, -1.0), np.linspace(0.02, 0.98, 49)])
    p = np.concatenate([p, 1.0 - p])
    expected = (referee.ppf(p) - referee.mean()) / referee.std()
    # atol: the standard deviation of `from_quantile` is by quadrature.
    assert_allclose(shape.quantile(p), expected, rtol=1e-9, atol=1e-7)


@pytest.mark.parametrize(("shape", "referee"), REFEREES, ids=identify)
def test_stated_moments_are_those_of_scipy(shape, referee):
    """Skewness and kurtosis are the closed forms that scipy.stats states."""
    skewness, excess = referee.stats(moments="sk")
    assert_allclose(shape.skewness, float(skewness), rtol=1e-9, atol=1e-12)
    assert_allclose(shape.kurtosis, float(excess) + 3.0, rtol=1e-9)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_moments_by_quadrature(shape):
    """The quantile function has mean 0, variance 1 and the stated third and fourth."""
    # t = ln(p/(1 - p)) leads to both ends smoothly, as far as doubles go; p = k/6, the
    # steps of the sample, are ends of panels.
    node, weight = np.polynomial.legendre.leggauss(12)
    edges = np.concatenate([np.linspace(-36.0, 36.0, 721), [-np.log(5), np.log(5)]])
    edges = np.unique(np.concatenate([edges, [-np.log(2), np.log(2)]]))
    half = np.diff(edges)[:, None] / 2.0
    t = (edges[:-1, None] + half + half * node).ravel()
    p = np.clip(1.0 / (1.0 + np.exp(-t)), LEAST, MOST)
    w = (half * weight).ravel() / (1.0 + np.exp(t)) / (1.0 + np.exp(-t))
    q = shape.quantile(p)

    def moment(power):
        return float(w @ q**power)

    # Tails beyond p = 2e-16: of t with 3 degrees of freedom the variance there is
    # p^(1/3) = 1e-5 of the whole, of 5 degrees the fourth moment p^(1/5) = 1e-3.
    heavy = shape.name == "scaled_student_t"
    assert_allclose(moment(1), 0.0, rtol=0, atol=1e-7)
    assert_allclose(moment(2), 1.0, rtol=2e-5 if shape.kurtosis == inf else 1e-7)
    assert_allclose(moment(3), shape.skewness, rtol=1e-4, atol=0.05 if heavy else 1e-7)
    if shape.kurtosis < inf:
        assert_allclose(moment(4), shape.kurtosis, rtol=2e-3)


def test_the_check_by_quadrature_can_fail():
    """Control: Student's t of few readings is no shape of unit variance."""
    q = student_t(5.0).quantile(np.linspace(0.0005, 0.9995, 1000))
    assert np.mean(q**2) > 1.5


def test_curvilinear_trapezoid_is_a_uniform_of_uniform_width():
    """Its distribution function is the mixture's of JCGM 101:2008, 6.4.3.4."""
    r = 0.4
    shape = curvilinear_trapezoid(r)
    u = sqrt(1.0 / 3.0 + r**2 / 9.0)  # 6.4.3.3 of (b - a)/2 = 1, d = r
    assert_allclose(shape.half_width, (1.0 + r) / u, rtol=1e-14)
    for x in (0.0, 0.3, 0.6, 0.9, 1.2, 1.39):
        exact, _ = quad(
            lambda w, x=x: min(0.5 + x / (2.0 * w), 1.0) / (2.0 * r),
            1.0 - r,
            1.0 + r,
            points=[max(x, 1.0 - r)],
        )
        assert_allclose(shape.probability(x / u), exact, rtol=1e-10)
        assert_allclose(shape.probability(-x / u), 1.0 - exact, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_shapes_travel_and_compare(shape):
    """A pickled shape is equal to its own and draws the same; none but NORMAL is it."""
    copy = pickle.loads(pickle.dumps(shape))  # noqa: S301 - our own bytes
    p = np.array([0.01, 0.4, 0.99])
    assert copy == shape
    assert hash(copy) == hash(shape)
    assert_allclose(copy.quantile(p), shape.quantile(p), rtol=0)
    assert (shape == NORMAL) == (shape.name == "normal")


def test_shapes_of_other_parameters_differ():
    """Parameters are part of a shape, samples and functions of one's own too."""
    assert gamma(2.0) == gamma(2) != gamma(3.0)
    assert samples([1.0, 2.0]) != samples([1.0, 2.0, 2.0])
    assert samples([1.0, 2.0, 4.0]) == samples([4.0, 1.0, 2.0])
    assert from_quantile(logistic) == from_quantile(logistic)
    assert scaled_student_t(inf) == NORMAL


def test_samples_are_drawn_as_often_as_they_stand_there():
    """Quantiles of six equally probable values, two of them equal."""
    x = np.array(READINGS)
    p = (np.arange(6) + 0.5) / 6.0
    expected = (np.sort(x) - x.mean()) / x.std()
    assert_allclose(samples(x).quantile(p), expected, rtol=1e-12, atol=1e-14)
    assert_allclose(samples(1e200 * x).quantile(p), expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("shape", SHAPES, ids=identify)
def test_probability_inverts_the_quantile(shape):
    """P(X <= q(p)) is p for a shape without steps, and 0 and 1 at the far ends."""
    p = np.array([0.001, 0.02, 0.5, 0.77, 0.999])
    if shape.name != "samples":
        assert_allclose(shape.probability(shape.quantile(p)), p, rtol=1e-6)
    assert_allclose(shape.probability([-inf, inf]), [0.0, 1.0], rtol=0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: student_t(0.0), "above 0"),
        (lambda: scaled_student_t(2.0), "above 2"),
        (lambda: trapezoidal(1.1), "0 to 1"),
        (lambda: trapezoidal(np.nan), "0 to 1"),
        (lambda: curvilinear_trapezoid(0.0), "UNIFORM"),
        (lambda: lognormal(4.0), "up to 3"),
        (lambda: gamma(0.0), "0.01 to"),
        (lambda: beta(1.0, -1.0), "b of a beta"),
        (lambda: samples([1.0, 1.0]), "not all equal"),
        (lambda: samples([[1.0, 2.0]]), "one row"),
        (lambda: samples(["a", "b"]), "finite numbers"),
        (lambda: samples([]), "one row"),
        (lambda: from_quantile(lambda p: -p), "falls"),
        (lambda: from_quantile(lambda p: 1.0 / (p - p)), "not finite"),
        (lambda: from_quantile(lambda p: p[:3]), r"shape \(3,\)"),
        (lambda: from_quantile(lambda p: 0.0 * p + 2.0), "everywhere"),
        (lambda: from_quantile(lambda p: np.tan(np.pi * (p - 0.5))), "variance"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
@pytest.mark.filterwarnings("ignore:invalid value")
def test_what_is_no_shape_is_refused(make, words):
    """Each refusal says what is allowed."""
    with pytest.raises(ProblemError, match=words):
        make()


def bent(shape, *, c, h, u=0.3):
    """Return y = c x + h x^2/2 of one input of that shape at 0."""
    return Problem(
        groups=(Group.independent("x", u=u, distribution=shape),),
        outputs=(Output(name="y"), Output(name="x")),
        function=lambda x: np.stack([c * x[0] + h * x[0] ** 2 / 2.0, x[0]]),
    )


@pytest.mark.parametrize("shape", [s for s in SHAPES if s.kurtosis < inf], ids=identify)
def test_the_law_of_a_bent_model_is_exact(shape):
    """Var(c x + h x^2/2) = c^2 u^2 + c h m3 + h^2 (m4 - u^4)/4, its covariance too."""
    c, h, u = 2.0, -3.0, 0.3
    m3, m4 = shape.skewness * u**3, shape.kurtosis * u**4
    law = propagate(bent(shape, c=c, h=h, u=u))
    exact = c**2 * u**2 + c * h * m3 + h**2 * (m4 - u**4) / 4.0
    # rtol: of an almost two-valued sample the terms cancel to a thousandth.
    assert_allclose(law.covariance[0, 0], exact, rtol=1e-10)
    assert_allclose(law.covariance[0, 1], c * u**2 + h * m3 / 2.0, rtol=1e-11)
    total = law.source_variance.sum(axis=0) + law.interaction_variance
    assert_allclose(total, np.diag(law.covariance), rtol=1e-10)


@pytest.mark.parametrize(
    "shape",
    [lognormal(0.5), gamma(2.0), beta(1.0, 3.0), trapezoidal(0.4)],
    ids=identify,
)
def test_monte_carlo_and_sobol_take_every_shape(shape):
    """Mean, u and 95 % interval of one input within 5 standard errors; one source."""
    n = 100_000
    problem = bent(shape, c=1.0, h=0.0, u=2.0)
    drawn = sample(problem, trials=n, seed=5)
    assert abs(drawn.mean[0]) < 5.0 * 2.0 / sqrt(n)
    bound = 5.0 * sqrt((shape.kurtosis - 1.0) / (4.0 * n))
    assert abs(drawn.standard_uncertainty[0] / 2.0 - 1.0) < bound
    inside = np.diff(shape.probability(drawn.interval[0] / 2.0))[0]
    assert abs(inside - 0.95) < 5.0 * sqrt(0.95 * 0.05 / n)
    assert_allclose(sobol(problem, samples=64).first.value, 1.0, rtol=1e-6)


def test_an_infinite_kurtosis_is_refused_only_where_the_model_bends():
    """The law of a linear model needs none; of x^2 it says so, and Sobol' runs."""
    heavy = scaled_student_t(3.0)
    straight = bent(heavy, c=2.0, h=0.0)
    assert_allclose(propagate(straight).standard_uncertainty[0], 0.6, rtol=1e-12)
    with pytest.raises(ProblemError, match=r"'x'.*scaled_student_t.*Monte Carlo"):
        propagate(bent(heavy, c=2.0, h=1.0))
    # Without the tangent one source's index is 1 but for the points' own error.
    indices = sobol(bent(heavy, c=1.0, h=0.1), samples=1024)
    assert_allclose(indices.first.value, 1.0, rtol=0, atol=0.1)


def test_sizes_of_skewed_sources_are_refused():
    """The scaled law has no term for a skewness and says so."""
    with pytest.raises(ProblemError, match="symmetric"):
        scaled_law(bent(EXPONENTIAL, c=1.0, h=1.0))


def both(x):
    """Return a sum and a product, at the top of a module."""
    return np.stack([x.sum(axis=0), x[0] * x[1]])


@pytest.mark.slow
def test_workers_draw_every_shape_and_copula_alike():
    """Shapes with samples, functions and copulas reach other processes bit for bit."""
    shapes = (samples(READINGS), from_quantile(logistic), gamma(2.0))
    problem = Problem(
        groups=(
            Copula(
                name="x",
                mean=np.zeros(3),
                covariance=0.7 * np.eye(3) + 0.3,
                distributions=shapes,
            ),
        ),
        outputs=(Output(name="y"), Output(name="z")),
        function=both,
    )
    alone, shared = (sample(problem, trials=20_000, workers=n) for n in (1, 2))
    assert (alone.covariance == shared.covariance).all()
    assert (alone.interval == shared.interval).all()
