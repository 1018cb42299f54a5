"""Risks of decision rules: JCGM 106's example, closed forms, densities, trials."""

from __future__ import annotations

from itertools import pairwise
from math import inf, sqrt

import numpy as np
import pytest
from builders import last_digit
from numpy.testing import assert_allclose
from scipy import stats
from scipy.integrate import quad

from budget.distributions import TRIANGULAR, UNIFORM
from budget.errors import CallError
from budget.methods.decisions import (
    acceptance_interval,
    global_risks,
)
from jcgm import gamma, lognormal, samples, scaled_student_t

BEARINGS = {"mean": 1.0, "u": 0.5, "u_measurement": 0.25, "distribution": gamma(4.0)}


def test_ball_bearings_of_jcgm_106():
    """4.2 % of all bearings do not conform; measured, 0.8 % are accepted so: 9.5.4.

    The numbers as the documentation of Suncal gives them for this example.
    """
    tolerance = (-inf, 2.0)
    found = global_risks(tolerance, tolerance, **BEARINGS)
    for value, printed in ((1.0 - found.conforming, "4.2"), (found.consumer, "0.8")):
        assert_allclose(100.0 * value, float(printed), rtol=0, atol=last_digit(printed))


def by_normals(tolerance, acceptance, *, mean, u, u_measurement):
    """Return both risks from the bivariate normal distribution of value and reading."""
    joint = stats.multivariate_normal(
        [mean, mean], [[u**2, u**2], [u**2, u**2 + u_measurement**2]]
    )
    both = joint.cdf(
        [tolerance[1], acceptance[1]], lower_limit=[tolerance[0], acceptance[0]]
    )
    value = stats.norm(mean, u)
    reading = stats.norm(mean, sqrt(u**2 + u_measurement**2))
    return (
        reading.cdf(acceptance[1]) - reading.cdf(acceptance[0]) - both,
        value.cdf(tolerance[1]) - value.cdf(tolerance[0]) - both,
    )


@pytest.mark.parametrize("u_measurement", [0.005, 0.1, 1.0])
@pytest.mark.parametrize("w", [-0.2, 0.0, 0.15])
@pytest.mark.parametrize("mean", [0.0, 0.4])
def test_normal_risks_are_those_of_the_bivariate_distribution(mean, w, u_measurement):
    """Both global risks of normal quantities agree with the closed form to 1e-9."""
    tolerance, acceptance = (-1.0, 1.0), (-1.0 + w, 1.0 - w)
    case = {"mean": mean, "u": 0.6, "u_measurement": u_measurement}
    found = global_risks(tolerance, acceptance, **case)
    exact = by_normals(tolerance, acceptance, **case)
    # atol: that of the bivariate function, far above that of the quadrature.
    assert_allclose([found.consumer, found.producer], exact, rtol=0, atol=1e-9)
    balance = found.conforming + found.consumer - found.producer
    assert_allclose(found.accepted, balance, rtol=1e-9)


@pytest.mark.parametrize(
    ("shape", "referee"),
    [
        (lognormal(0.6), stats.lognorm(0.6)),
        (UNIFORM, stats.uniform()),
        (TRIANGULAR, stats.triang(0.5)),
        (scaled_student_t(5.0), stats.t(5.0)),
    ],
)
def test_risks_of_other_priors_by_their_density(shape, referee):
    """R_C and R_P are the integrals of the prior's density over eta: 9.5.2."""
    mean, u, u_m, tolerance, acceptance = 2.0, 0.5, 0.1, (1.1, 2.7), (1.2, 2.65)
    scale = u / referee.std()
    shift = mean - scale * referee.mean()

    def accepted(eta):
        p = stats.norm.cdf((np.array(acceptance) - eta) / u_m)
        return (p[1] - p[0]) * referee.pdf((eta - shift) / scale) / scale

    low, high = (shift + scale * x for x in referee.support())
    low, high = max(low, 0.0), min(high, 5.0)  # where a reading may be accepted

    def integral(a, b):
        ends = np.unique(np.clip([*np.arange(low, high, 0.1), a, b, mean], a, b))
        return sum(quad(accepted, c, d, epsabs=1e-13)[0] for c, d in pairwise(ends))

    inside = integral(*tolerance)
    conforming = np.diff(referee.cdf((np.array(tolerance) - shift) / scale))[0]
    found = global_risks(
        tolerance, acceptance, mean=mean, u=u, u_measurement=u_m, distribution=shape
    )
    consumer = integral(low, tolerance[0]) + integral(tolerance[1], high)
    assert_allclose(found.consumer, consumer, rtol=0, atol=1e-9)
    assert_allclose(found.producer, conforming - inside, rtol=0, atol=1e-9)


def wrong(acceptance, n):
    """Return the parts of n items wrongly accepted and rejected, by trials."""
    rng = np.random.default_rng(11)
    p = rng.uniform(2.0**-54, 1.0, (2, n))
    value = 1.0 + 0.5 * gamma(4.0).quantile(p[0])
    reading = value + 0.25 * UNIFORM.quantile(p[1])
    taken = (acceptance[0] <= reading) & (reading <= acceptance[1])
    conforms = value <= 2.0
    return np.array([(taken & ~conforms).mean(), (~taken & conforms).mean()])


def test_risks_with_a_uniform_error_of_measurement_by_trials():
    """Gamma items read with a uniform error: both risks within 5 standard errors.

    Control: the risks of simple acceptance are not those of the guarded rule.
    """
    n = 400_000
    tolerance, acceptance = (-inf, 2.0), (-inf, 1.8)
    found = global_risks(tolerance, acceptance, measurement=UNIFORM, **BEARINGS)
    exact = np.array([found.consumer, found.producer])
    error = np.sqrt(exact * (1.0 - exact) / n)
    assert (np.abs(wrong(acceptance, n) - exact) < 5.0 * error).all()
    assert (np.abs(wrong(tolerance, n) - exact) > 20.0 * error).all()


def test_items_that_were_measured_before_are_a_prior():
    """A prior of samples gives the mean over them, to 1e-4."""
    values = np.random.default_rng(2).normal(0.0, 0.7, 40)
    found = global_risks(
        (-1.0, 1.0),
        (-0.8, 0.8),
        mean=values.mean(),
        u=values.std(),
        u_measurement=0.2,
        distribution=samples(values),
    )
    p = stats.norm.cdf((0.8 - values) / 0.2) - stats.norm.cdf((-0.8 - values) / 0.2)
    bad = np.abs(values) > 1.0
    assert bad.any()
    assert_allclose(found.consumer, (p * bad).mean(), rtol=0, atol=1e-4)
    assert_allclose(found.producer, ((1.0 - p) * ~bad).mean(), rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: acceptance_interval((0.0, 1.0), 0.5), "nothing to accept"),
        (lambda: acceptance_interval((1.0, 1.0), 0.0), "tolerance is"),
        (lambda: acceptance_interval((np.nan, 1.0), 0.0), "tolerance is"),
        (lambda: acceptance_interval(3.0, 0.0), "tolerance is"),
        (
            lambda: global_risks((0.0, 1.0), (0.0, 1.0), **BEARINGS | {"u": -1.0}),
            "u is -1.0",
        ),
    ],
)
def test_what_is_no_rule_is_refused(call, words):
    """Each message says what is allowed."""
    with pytest.raises(CallError, match=words):
        call()
