"""Standard uncertainties from few readings: by law, Monte Carlo and Sobol' indices."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import integrate, optimize, stats

from budget import sample
from budget.methods.gum import propagate
from budget.methods.sobol import sobol
from budget.methods.trials import first_trials
from budget.problem import CommonScale, Group, Output, Problem

TRIALS = 200_000


def group(name, u, *scales, covariance=None):
    """Return a normal group with scales: (degrees of freedom, *inputs)."""
    u = np.atleast_1d(np.asarray(u, dtype=float))
    return Group(
        name=name,
        mean=np.zeros(u.size),
        covariance=np.diag(u**2) if covariance is None else covariance,
        distributions=Group.independent("x", u=u).distributions,
        scales=tuple(
            CommonScale(degrees_of_freedom=v, rows=tuple(rows)) for v, *rows in scales
        ),
    )


def add(x):
    """Return the sum of all inputs."""
    return x.sum(axis=0, keepdims=True)


def problem(*groups, function=add, outputs=("y",)):
    """Return a Problem of these groups."""
    named = tuple(Output(name=name) for name in outputs)
    return Problem(groups=groups, outputs=named, function=function)


def test_welch_satterthwaite_has_a_term_for_each_scale():
    """(G.2b) of JCGM 100:2008, by hand: what one scale is of is one term."""
    a, b = 3.0, 4.0
    apart = problem(group("a", [a, b], (5.0, 0), (7.0, 1)))
    joint = problem(group("a", [a, b], (5.0, 0, 1)))
    beside = problem(group("a", [a], (5.0, 0)), group("b", [b]))

    (found,) = propagate(apart).degrees_of_freedom
    assert_allclose(found, 25.0**2 / (a**4 / 5.0 + b**4 / 7.0), rtol=1e-14)
    assert_allclose(propagate(joint).degrees_of_freedom, 5.0, rtol=1e-14)
    (other,) = propagate(beside).degrees_of_freedom
    assert_allclose(other, 25.0**2 / (a**4 / 5.0), rtol=1e-14)


def test_correlated_inputs_of_one_scale_are_one_term():
    """The variance of their sum, with what they have in common."""
    covariance = np.array([[4.0, 1.5], [1.5, 9.0]])
    one = problem(
        group("a", [2.0, 3.0], (6.0, 0, 1), covariance=covariance), group("b", [1.0])
    )

    (found,) = propagate(one).degrees_of_freedom
    assert_allclose(found, 17.0**2 / (16.0**2 / 6.0), rtol=1e-14)


@pytest.mark.parametrize("v", [1.0, 2.5, 5.0, 40.0])
def test_one_input_is_student_t(v):
    """By both methods: the drawn one by a test of Kolmogorov and Smirnov at 1e-6."""
    one = problem(group("a", [2.0], (v, 0)))
    law = propagate(one)
    whole = np.floor(v)

    assert_allclose(law.coverage_factor(0.95), stats.t(whole).ppf(0.975), rtol=1e-12)
    (y,) = first_trials(one, trials=TRIALS, seed=4)
    assert stats.kstest(y / 2.0, stats.t(v).cdf).pvalue > 1e-6
    # Control: a normal one is told from it.
    assert v == 40.0 or stats.kstest(y / 2.0, stats.norm.cdf).pvalue < 1e-6


@pytest.mark.parametrize("is_joint", [True, False])
def test_inputs_of_one_scale_are_off_together(is_joint):
    """Sizes of two inputs are correlated if and only if their scale is one.

    Of |x| = s |z| with ln s of variance trigamma(v/2)/4 and ln |z| of pi^2/8: the
    correlation of the logarithms, to five standard errors of a sample of independent
    pairs.
    """
    v = 5.0
    scales = [(v, 0, 1)] if is_joint else [(v, 0), (v, 1)]
    both = problem(
        group("a", [1.0, 1.0], *scales), function=np.array, outputs=("y", "z")
    )
    y = first_trials(both, trials=TRIALS, seed=1)
    found = np.corrcoef(np.log(np.abs(y)))[0, 1]
    trigamma = np.pi**2 / 2.0 - 4.0 * (1.0 + 1.0 / 9.0)  # of 5/2
    wanted = trigamma / 4.0 / (trigamma / 4.0 + np.pi**2 / 8.0) if is_joint else 0.0

    assert_allclose(found, wanted, atol=5.0 / sqrt(TRIALS))


def test_trials_of_a_sum_have_its_distribution():
    """Two scatters: 95 % ends as by quadrature; Welch-Satterthwaite falls short."""
    t5, t7 = stats.t(5.0), stats.t(7.0)

    def outside(q):
        def inside(x):
            return t5.pdf(x) * np.diff(t7.cdf((np.array([-q, q]) - 3.0 * x) / 4.0))[0]

        return 0.95 - integrate.quad(inside, -np.inf, np.inf, epsabs=1e-10)[0]

    one = problem(group("a", [3.0], (5.0, 0)), group("b", [4.0], (7.0, 0)))
    exact = optimize.brentq(outside, 5.0, 20.0)
    found = sample(one, trials=TRIALS, coverage=0.95, seed=2)
    # An end of probability p is sure to sqrt(p (1 - p) / n) over the density there.
    y = np.abs(first_trials(one, trials=TRIALS, seed=2)[0])
    density = (np.abs(y - exact) < 0.5).mean()
    sure = sqrt(0.05 * 0.95 / TRIALS) / density
    assert_allclose(found.interval[0, 1], exact, atol=5.0 * sqrt(2.0) * sure)
    assert propagate(one).interval(0.95)[0, 1] < exact - 20.0 * sure


def test_scales_of_a_pool_are_drawn_by_themselves():
    """Adding up pooled groups loses no scale."""

    def pooled(name, u, *scales):
        own = group(name, u, *scales)
        return Group.known(
            name=own.name,
            mean=np.zeros(1),
            covariance=own.covariance.copy(),
            distributions=own.distributions,
            pool="noise",
            scales=own.scales,
        )

    many = problem(pooled("a", [1.0]), pooled("b", [2.0]), pooled("c", [6.0], (3.0, 0)))
    assert len(many.pooled.groups) == 2
    kept = [scale for one in many.pooled.groups for scale in one.scales]
    assert kept == [CommonScale(degrees_of_freedom=3.0, rows=(0,))]


def test_sobol_counts_the_variance_that_is_drawn():
    """Of a t variate u^2 v/(v - 2): shares of a sum by hand."""
    v = 12.0
    one = problem(group("a", [1.0], (v, 0)), group("b", [1.0]))
    found = sobol(one, samples=2**12, seed=3)
    of_a = v / (v - 2.0)
    wanted = np.array([of_a, 1.0]) / (of_a + 1.0)

    first = found.first.value[:, 0]
    assert_allclose(first, wanted, atol=0.02)


def test_known_standard_uncertainties_stay_as_they_were():
    """Without scales nothing is drawn besides, and the factor is the normal one."""
    one = problem(group("a", [2.0]))

    assert propagate(one).degrees_of_freedom.tolist() == [inf]
    assert_allclose(propagate(one).coverage_factor(0.95), 1.959963984540054, rtol=1e-14)
