"""Examples of the standards, through the public interface, by every fit method."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import budget
from budget.distributions import NORMAL, UNIFORM
from budget.methods.validation import validate
from jcgm import student_t

pytestmark = pytest.mark.kernels


def mass_calibration():
    """Return JCGM 101:2008, 9.3, in mg and kg/m^3."""
    # Half-widths of rectangular inputs: 0.10, 1000 and 50 kg/m^3.
    inputs = (
        ("m_Rc", 100_000.0, 0.050, NORMAL),
        ("dm_Rc", 1.234, 0.020, NORMAL),
        ("rho_a", 1.20, 0.10 / np.sqrt(3.0), UNIFORM),
        ("rho_W", 8000.0, 1000.0 / np.sqrt(3.0), UNIFORM),
        ("rho_R", 8000.0, 50.0 / np.sqrt(3.0), UNIFORM),
    )

    def deviation(x):
        m, dm, rho_a, rho_W, rho_R = x
        buoyancy = (rho_a - 1.2) * (1.0 / rho_W - 1.0 / rho_R)
        return ((m + dm) * (1.0 + buoyancy) - 100_000.0)[None]

    return budget.Problem(
        groups=tuple(
            budget.Group.independent(name, mean=mean, u=u, distribution=shape)
            for name, mean, u, shape in inputs
        ),
        outputs=(budget.Output(name="dm", unit="mg", si_per_unit=1.0),),
        function=deviation,
    )


def test_mass_calibration_by_monte_carlo():
    """Mean, u and 95 % interval are the exact ones of JCGM 101:2008, 9.3."""
    n = 1_000_000
    found = budget.sample(mass_calibration(), trials=n, seed=1)
    u = 0.0754797
    assert_allclose(found.mean, 1.2340000, rtol=0, atol=5.0 * u / np.sqrt(n))
    # Kurtosis of the output is below 4: standard error of u below u sqrt(3/4n).
    assert_allclose(found.standard_uncertainty, u, rtol=5.0 * np.sqrt(0.75 / n))
    # Density at the ends 0.06/u at least: standard error of an end.
    end = np.sqrt(0.025 * 0.975 / n) / (0.05 / u)
    assert_allclose(found.interval[0], [1.084433, 1.383567], rtol=0, atol=5.0 * end)


def test_mass_calibration_by_shortest_interval():
    """The shortest interval has the same ends, which are ill-conditioned: 0.002."""
    found = budget.sample(
        mass_calibration(), trials=1_000_000, seed=1, interval="shortest"
    )
    assert_allclose(found.interval[0], [1.084433, 1.383567], rtol=0, atol=0.002)


def test_mass_calibration_by_the_first_order_law():
    """To first order u is 0.0539 and the interval [1.1285, 1.3395]."""
    law = budget.propagate(mass_calibration())
    u = np.sqrt(law.first_order[0, 0])
    assert_allclose(u, 0.0539, rtol=0, atol=1e-4)
    k = law.coverage_factor(0.95)[0]
    ends = [1.234 - k * u, 1.234 + k * u]
    assert_allclose(ends, [1.1285, 1.3395], rtol=0, atol=1e-4)


def test_mass_calibration_by_the_second_order_law():
    """The products add what first order misses: u 0.0750 of 0.0755."""
    u = budget.propagate(mass_calibration()).standard_uncertainty[0]
    assert_allclose(u, 0.0750, rtol=0, atol=1e-4)


def end_gauge():
    """Return JCGM 100:2008, H.1, in nm, with the degrees of freedom of Table H.1."""
    inputs = (
        ("ls", 50_000_623.0, 25.0, student_t(18)),
        ("d", 215.0, 9.7, student_t(25.6)),
        ("d_alpha", 0.0, 0.58e-6, student_t(50)),
        ("theta", -0.1, 0.41, NORMAL),
        ("alpha_s", 11.5e-6, 1.2e-6, NORMAL),
        ("d_theta", 0.0, 0.029, student_t(2)),
    )

    def length(x):
        ls, d, d_alpha, theta, alpha_s, d_theta = x
        return (ls + d - ls * (d_alpha * theta + alpha_s * d_theta))[None]

    return budget.Problem(
        groups=tuple(
            budget.Group.independent(name, mean=mean, u=u, distribution=shape)
            for name, mean, u, shape in inputs
        ),
        outputs=(budget.Output(name="l", unit="nm", si_per_unit=1.0),),
        function=length,
    )


def test_end_gauge_by_the_law():
    """H.1: l 50 000 838, u 32 (31.71), 16 dof, U99 93; to second order 34 (33.91)."""
    law = budget.propagate(end_gauge())
    u = np.sqrt(law.first_order[0, 0])
    assert_allclose(law.value, [50_000_838.0], rtol=0, atol=1.0)
    assert_allclose(u, 31.71, rtol=0, atol=0.01)
    assert np.floor(law.degrees_of_freedom[0]) == 16
    assert_allclose(law.coverage_factor(0.99)[0] * u, 93.0, rtol=0, atol=1.0)
    assert_allclose(law.standard_uncertainty, [33.91], rtol=0, atol=0.01)


def test_end_gauge_by_monte_carlo_has_student_t_inputs():
    """Trials of the t inputs reproduce their mean and the interval of their sum.

    With t inputs the 99 % interval is wider than 2.576 u of normal ones; it is held
    against numpy's own draws of the same model.
    """
    n = 400_000
    found = budget.sample(end_gauge(), trials=n, seed=3, coverage=0.99)
    rng = np.random.default_rng(4)

    def t(v, u):
        return u * rng.standard_t(v, n)

    ls = 50_000_623.0 + t(18, 25.0)
    alpha = t(50, 0.58e-6) * (-0.1 + 0.41 * rng.standard_normal(n))
    theta = (11.5e-6 + 1.2e-6 * rng.standard_normal(n)) * t(2, 0.029)
    other = ls + 215.0 + t(25.6, 9.7) - ls * (alpha + theta)
    expected = np.quantile(other, [0.005, 0.995])
    # d_theta has 2 degrees of freedom: tails fall as 1/x^2, so the density at an end
    # is twice the tail probability over its distance, 175 nm. Both samples wander.
    end = np.sqrt(2.0 * 0.005 * 0.995 / n) / (2.0 * 0.005 / 175.0)
    assert_allclose(found.interval[0], expected, rtol=0, atol=5.0 * end)
    assert found.interval[0, 1] - found.mean[0] > 2.576 * 33.91


READINGS = np.array(
    [
        [5.007, 4.994, 5.005, 4.990, 4.999],  # V
        [19.663e-3, 19.639e-3, 19.640e-3, 19.685e-3, 19.678e-3],  # A
        [1.0456, 1.0438, 1.0468, 1.0428, 1.0433],  # rad
    ]
)


def impedance(x):
    """Return R, X, Z of V, I, phi."""
    V, current, phi = x
    return np.stack([V / current * np.cos(phi), V / current * np.sin(phi), V / current])


def reactance(*, correlated):
    """Return JCGM 100:2008, H.2: simultaneous readings of V, I and phi."""
    C = np.cov(READINGS) / READINGS.shape[1]  # of the means
    return budget.Problem(
        groups=(
            budget.Group(
                name="readings",
                mean=READINGS.mean(axis=1),
                covariance=C if correlated else np.diag(np.diag(C)),
                distributions=(NORMAL,) * 3,
            ),
        ),
        outputs=tuple(budget.Output(name=n, unit="ohm") for n in ("R", "X", "Z")),
        function=impedance,
    )


@pytest.mark.parametrize(
    ("correlated", "printed"),
    [(True, ("0.071", "0.295", "0.236")), (False, ("0.195", "0.201", "0.204"))],
)
def test_reactance_by_the_law(correlated, printed):
    """H.2, Table H.4: R 127.732, X 219.847, Z 254.260 with their uncertainties."""
    # X with correlations: full precision gives 0.29558; the guide rounded on the way.
    law = budget.propagate(reactance(correlated=correlated))
    assert_allclose(law.value, [127.732, 219.847, 254.260], rtol=0, atol=1e-3)
    expected = [float(text) for text in printed]
    assert_allclose(law.standard_uncertainty, expected, rtol=0, atol=1e-3)


def test_reactance_by_monte_carlo():
    """Correlated inputs drawn jointly give the law's uncertainties and correlations."""
    n = 400_000
    problem = reactance(correlated=True)
    law, found = budget.propagate(problem), budget.sample(problem, trials=n, seed=2)
    off = found.standard_uncertainty / law.standard_uncertainty - 1.0
    assert np.abs(off).max() < 5.0 / np.sqrt(2.0 * n)
    scale = np.outer(law.standard_uncertainty, law.standard_uncertainty)
    error = (found.covariance - law.covariance) / scale
    assert np.abs(error).max() < 5.0 * np.sqrt(2.0 / n)


def test_validation_refuses_the_first_order_answer_of_the_mass():
    """JCGM 101:2008, 9.3: even with second order, two digits are not confirmed."""
    problem = mass_calibration()
    (verdict,) = validate(problem, budget.propagate(problem), digits=2)
    assert not verdict.holds
