"""How printed random entries are judged: chi-square, scatter, orders of magnitude."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import chi2, norm

from zhao_2019.conditions import PLACES, load_conditions
from zhao_2019.orders import expectation_of
from zhao_2019.readings import LEVEL, fit, order_probability
from zhao_2019.table1 import stated_rows

SIGMAS = 5.0  # of the sampling error that a share may miss by


@pytest.fixture(scope="module")
def conditions():
    return load_conditions()


@pytest.fixture(scope="module")
def rows(conditions):
    return stated_rows(conditions)


def test_fit_is_the_chi_square_of_independent_entries(rows):
    """With one axis an entry, p is that of the sum of squares and of the scatter."""
    row = rows["bias_repeatability"].of_mean
    z = row.printed[PLACES["bias"]] / (0.02 / 5.0)
    found = row.fit("bias")
    tails = [
        2.0 * min(chi2.cdf(q, df), chi2.sf(q, df))
        for q, df in (((z**2).sum(), 3), (((z - z.mean()) ** 2).sum(), 2))
    ]
    # eq. (4)'s residual, 1e-7 of an entry, is in the expectation.
    assert_allclose(found.chi_square, (z**2).sum(), rtol=1e-6)
    assert_allclose(found.p, min(1.0, 2.0 * min(tails)), rtol=1e-5)
    assert_allclose(found.p_entries, 2.0 * norm.sf(np.abs(z)), rtol=1e-5)


def test_fit_is_uniform_under_its_own_reading(rows):
    """Entries drawn as they should be are refused no more often than the level."""
    row = rows["bias_stability"]
    rng = np.random.default_rng(0)
    factor = np.linalg.cholesky(row.expectation.covariance)
    trials = 2000
    refused = {1.0: 0, 3.0: 0}
    for scale in refused:
        for _ in range(trials):
            drawn = scale * factor @ rng.standard_normal(12) + row.expectation.mean
            found = fit(drawn, row.expectation, PLACES["mounting_angle"], runs=1)
            refused[scale] += not found.fits
    # The doubled smaller of two p keeps the level or better.
    bound = LEVEL + SIGMAS * np.sqrt(LEVEL / trials)
    assert refused[1.0] / trials < bound
    assert refused[3.0] / trials > 0.5  # control: three times the spread


def test_order_probability_is_a_share_of_draws(conditions):
    """The closed form is the share of draws whose largest entry has the order."""
    (printed,) = (
        row
        for row in conditions.paper.orders
        if row.name == "accelerometer.bias_stability"
    )
    found = expectation_of(printed, conditions)
    place = PLACES["mounting_angle"]
    closed = order_probability("1e-1", found, place, runs=1)
    trials = 20_000
    factor = np.linalg.cholesky(found.covariance[place, place])
    z = np.random.default_rng(1).standard_normal((6, trials))
    largest = np.abs(factor @ z).max(axis=0)
    share = np.mean((largest >= 0.1) & (largest < 1.0))
    # Correlations of 0.4 at the most, taken as none, move it by some hundredths.
    assert abs(share - closed) < 0.05
    assert abs(np.mean(largest < 0.1) - closed) > 0.1  # control: another order
