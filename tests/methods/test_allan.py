"""Allan deviation of a record: NIST's suite, theory, gaps, degrees of freedom."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import chi2

from budget.methods.allan import (
    FLICKER,
    WALK,
    WHITE,
    allan_curve,
    degrees_of_freedom,
    interval_of,
)
from budget.methods.noise_fit import allan_variance

SERIES = 400
SURE = 1e-6  # of a false alarm


def of_nist():
    """Return the 1000 points of NIST SP 1065, section 12.4."""
    found = [1234567890]
    for _ in range(999):
        found.append(16807 * found[-1] % 2147483647)
    return np.array(found) / 2147483647.0


def test_it_is_that_of_the_suite():
    """The overlapping Allan deviations that SP 1065 prints, to their digits."""
    found = [one.deviation for one in allan_curve(of_nist(), 1.0, [1, 10, 100])]
    assert_allclose(found, [0.2922319, 0.09159953, 0.03241343], rtol=2e-7)


def test_a_large_mean_takes_no_digits():
    """A rate of a thousand times its noise has the noise's deviation."""
    y = np.random.default_rng(1).standard_normal(10_000)
    own, other = (allan_curve(one, 0.1) for one in (y, y + 1e3))
    assert_allclose(
        [one.deviation for one in own], [one.deviation for one in other], rtol=1e-10
    )


def test_a_gap_is_left_out():
    """Differences over missing samples go, and no others."""
    y = np.random.default_rng(2).standard_normal(500)
    y[200:210] = np.nan
    (found,) = allan_curve(y, 1.0, [4])
    means = np.convolve(y, np.ones(4) / 4.0, "valid")
    second = means[4:] - means[:-4]
    second = second[np.isfinite(second)]
    assert found.terms == second.size < found.whole
    assert_allclose(found.deviation, sqrt(0.5 * np.mean(second**2)), rtol=1e-10)
    assert allan_curve(np.full(9, np.nan), 1.0) == []


@pytest.mark.parametrize("m", [1, 2, 8, 33, 100, 250])
@pytest.mark.parametrize("alpha", [WHITE, WALK])
def test_the_degrees_of_freedom_are_those_of_trials(alpha, m):
    """2 E^2/Var of the variance over series, within what their number leaves open."""
    rng, n = np.random.default_rng([3, m, -alpha]), 1000
    found = []
    for _ in range(SERIES):
        y = rng.standard_normal(n)
        y = np.cumsum(y) if alpha == WALK else y
        ((one),) = allan_curve(y, 1.0, [m])
        found.append(one.deviation**2)
    edf = 2.0 * np.mean(found) ** 2 / np.var(found, ddof=1)
    # A variance of a chi-square variable of nu degrees has a kurtosis of 3 + 12/nu.
    nu = degrees_of_freedom(alpha, n, m)
    spread = sqrt((2.0 + 12.0 / nu) / SERIES)
    assert abs(edf / nu - 1.0) < 5.0 * spread


# Of 1000 points, by averages: what allantools 2024.6 (edf_greenhall) gives where it
# takes the exact sums of the paper.
OTHERS = {
    WHITE: (782.0302990727438, 540.6811941160472, 165.98780647450286, 46.294531872384),
    WALK: (762.2904904738508, 438.24586013692635, 114.02338380791441, 29.392679241223),
    FLICKER: (
        895.2473612695801,
        538.6605103076603,
        143.28796731140596,
        37.278875428294,
    ),
}


@pytest.mark.parametrize("alpha", OTHERS)
def test_the_degrees_of_freedom_are_those_of_another_program(alpha):
    """An independent program of the same paper; of flicker it sums otherwise."""
    found = [degrees_of_freedom(alpha, 1000, m) for m in (1, 2, 8, 30)]
    assert_allclose(found, OTHERS[alpha], rtol=6e-3 if alpha == FLICKER else 1e-9)


def test_an_interval_is_that_of_chi_square():
    """Its ends have the probabilities that they are to have."""
    low, high = interval_of(2.0, 10.0, 0.95)
    assert_allclose(chi2.cdf(10.0 * 4.0 / low**2, 10.0), 0.975, rtol=1e-9)
    assert_allclose(chi2.cdf(10.0 * 4.0 / high**2, 10.0), 0.025, rtol=1e-9)


def test_the_curve_of_a_model_is_that_of_its_processes():
    """Of a Gauss-Markov process by quadrature of its covariance; of others known."""
    s, T, t = 3.0, 20.0, 7.0
    grid = (np.arange(4000) + 0.5) * (2.0 * t / 4000)
    weight = np.where(grid < t, -1.0, 1.0) / 2000.0
    C = s**2 * np.exp(-np.abs(np.subtract.outer(grid, grid)) / T)
    expected = 0.5 * weight @ C @ weight
    found = allan_variance({"N": 0.0, "sigma": s, "tau": T}, np.array([t]), 1e3)
    assert_allclose(found, [expected], rtol=1e-4)
    slow = allan_variance({"N": 0.0, "sigma": s, "tau": 1e6}, np.array([t]), 1e3)
    assert_allclose(slow, 2.0 * s**2 / 1e6 * t / 3.0, rtol=1e-4)
    floor = allan_variance({"N": 0.0, "B": 1.0}, np.array([0.1, 100.0]), 1e7)
    assert_allclose(np.sqrt(floor[1]), 0.664, rtol=2e-3)
