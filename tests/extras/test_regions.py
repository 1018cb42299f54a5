"""Joint coverage regions: exact factors of normal outputs, coverage over seeds."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats
from scipy.optimize import brentq

import budget
import jcgm
from budget.errors import CallError, ProblemError
from jcgm import (
    box_region,
    ellipsoid_region,
    normal_region,
    smallest_region,
)

M = 200_000
SIZES = np.array([1e-8, 3.0])  # as of a bias [rad/s] and an angle


def covariance(r):
    """Return that of two outputs of very different sizes."""
    return np.array([[1.0, r], [r, 1.0]]) * np.outer(SIZES, SIZES)


def normal_trials(r, *, trials=M, seed=0):
    """Return trials of two normal outputs about (1e-7, 5), shape (2, trials)."""
    z = np.random.default_rng(seed).standard_normal((2, trials))
    z[1] = r * z[0] + np.sqrt(1.0 - r**2) * z[1]
    return np.array([[1e-7], [5.0]]) + SIZES[:, None] * z


def quantile_error(density, p, trials=M):
    """Return the standard error of a quantile of trials, where that is the density."""
    return np.sqrt(p * (1.0 - p) / trials) / density


@pytest.mark.parametrize("p", [0.5, 0.95, 0.997])
@pytest.mark.parametrize("r", [0.0, -0.9])
def test_factor_of_the_ellipsoid_is_chi(r, p):
    """k_p of two normal outputs is sqrt(-2 ln(1 - p)), whatever their correlation."""
    found = ellipsoid_region(normal_trials(r), p)
    exact = np.sqrt(-2.0 * np.log(1.0 - p))
    error = quantile_error(exact * np.exp(-(exact**2) / 2.0), p)
    assert abs(found.factor - exact) < 5.0 * error
    area = np.pi * exact**2 * np.sqrt(1.0 - r**2) * SIZES.prod()
    # Of a determinant of M trials the relative standard error is sqrt(4/M) at most.
    bound = 5.0 * (2.0 * error / exact + 2.0 / np.sqrt(M))
    assert abs(found.volume / area - 1.0) < bound


def test_region_of_the_law_is_exact():
    """Of two and three outputs k_p^2 is chi-squared's 5.991 and 7.815 at 95 %."""
    two = normal_region([1e-7, 5.0], covariance(0.4))
    three = normal_region(np.zeros(3), np.eye(3))
    assert_allclose(two.factor**2, 5.991, rtol=0, atol=1e-3)
    assert_allclose(three.factor**2, 7.815, rtol=0, atol=1e-3)
    assert_allclose(three.volume, 4.0 / 3.0 * np.pi * three.factor**3, rtol=1e-12)
    one = normal_region([2.0], [[4.0]])
    assert_allclose(one.factor, 1.959963984540054, rtol=1e-12)
    assert_allclose(one.volume, 2.0 * 2.0 * one.factor, rtol=1e-12)
    assert one.contains([[2.0 + 3.91, 2.0 + 3.93]]).tolist() == [True, False]


@pytest.mark.parametrize("r", [0.0, 0.8])
def test_factor_of_the_box_is_that_of_the_largest(r):
    """k_q solves P(|z_1| <= k, |z_2| <= k) = p of two normal variates."""
    p = 0.95

    def held(k):
        joint = stats.multivariate_normal(cov=[[1.0, r], [r, 1.0]])
        return joint.cdf([k, k], lower_limit=[-k, -k]) - p

    exact = brentq(held, 1.0, 4.0, xtol=1e-9)
    step = 1e-3
    density = (held(exact + step) - held(exact - step)) / (2.0 * step)
    found = box_region(normal_trials(r), p)
    # Centre and u are of the trials too: their own error is below that of k.
    assert abs(found.factor - exact) < 6.0 * quantile_error(density, p)
    assert_allclose(
        np.diff(found.interval)[:, 0], 2.0 * found.factor * found.u, rtol=1e-7
    )
    assert_allclose(found.volume, np.prod(2.0 * found.factor * found.u), rtol=1e-12)


def test_smallest_region_of_normal_outputs_is_about_their_ellipse():
    """Its area is the ellipse's within a seam of half a cell all round it."""
    found = smallest_region(normal_trials(0.6), 0.95)
    k = np.sqrt(-2.0 * np.log(0.05))
    area = np.pi * k**2 * 0.8
    width = found.width / SIZES
    seam = 0.5 * np.hypot(*width) * 2.0 * np.pi * k
    assert found.coverage >= 0.95
    assert abs(found.volume / SIZES.prod() - area) < seam


def test_smallest_region_of_two_tops_leaves_out_the_middle():
    """Two normal heaps 10 u apart: no point between, and half the ellipse's area."""
    y = normal_trials(0.0)
    y[0] += np.where(np.arange(M) % 2, 5.0, -5.0) * SIZES[0]
    found = smallest_region(y, 0.95)
    assert not found.contains(np.array([[1e-7], [5.0]])).any()
    assert found.contains(np.array([[1e-7 + 5e-8], [5.0]])).all()
    assert found.volume < 0.55 * ellipsoid_region(y, 0.95).volume


REGIONS = [ellipsoid_region, box_region, smallest_region]


def coverages(make, seeds, *, trials=20_000):
    """Return how much of fresh trials regions of other trials hold, by seed."""
    fresh = normal_trials(0.5, trials=100_000, seed=999)
    return np.array(
        [
            make(normal_trials(0.5, trials=trials, seed=seed)).contains(fresh).mean()
            for seed in range(seeds)
        ]
    )


# Standard error of a mean over 60 regions of 20,000 trials, tried on the same 100,000.
COVERAGE_ERROR = np.sqrt(0.95 * 0.05 * (1.0 / (60 * 20_000) + 1.0 / 100_000))


@pytest.mark.parametrize("make", REGIONS[:2])
def test_regions_hold_their_part_of_fresh_trials(make):
    """Over 60 seeds the mean coverage of a 95 % region is 0.95 within 5 errors."""
    assert abs(coverages(make, 60).mean() - 0.95) < 5.0 * COVERAGE_ERROR


def test_the_mesh_holds_less_by_the_choice_of_its_cells():
    """Cells that chance filled are chosen: some 0.1 % is lost, as the docs say."""
    assert 0.947 < coverages(smallest_region, 20, trials=100_000).mean() < 0.9505


def test_the_coverage_check_can_fail():
    """Control: single 95 % intervals hold two outputs together far less often."""

    def intervals(y):
        region = box_region(y)
        return type(region)(
            coverage=0.95, mean=region.mean, u=region.u, factor=1.959964
        )

    assert coverages(intervals, 10).mean() < 0.95 - 50.0 * COVERAGE_ERROR


@pytest.mark.parametrize("make", REGIONS)
def test_a_region_holds_its_own_trials(make):
    """The part of the trials themselves that it holds is what it says, to a trial."""
    y = normal_trials(-0.3, trials=10_000)
    region = make(y, 0.9)
    inside = region.contains(y).mean()
    assert_allclose(inside, region.coverage, rtol=0, atol=1.5e-4)
    assert inside >= 0.8999


def test_trials_of_a_problem_go_in_as_they_come():
    """The box of a model's trials holds 95 % of them; dependent outputs have one."""
    problem = budget.Problem(
        groups=(budget.Group.independent("x", u=[1.0, 2.0]),),
        outputs=tuple(budget.Output(name=n) for n in ("a", "b", "sum")),
        function=lambda x: np.stack([x[0], x[1], x[0] + x[1]]),
    )
    y = budget.first_trials(problem, trials=20_000, seed=1)
    assert_allclose(jcgm.box_region(y).contains(y).mean(), 0.95, rtol=1e-3)
    with pytest.raises(ProblemError, match=r"outputs 0, 1, 2 .* linearly dependent"):
        jcgm.ellipsoid_region(y)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: box_region([1.0, 2.0]), CallError, r"shape \(2,\)"),
        (lambda: box_region(np.zeros((2, 10))), CallError, "too few"),
        (lambda: box_region(np.zeros((2, 100))), ProblemError, "does not vary"),
        (lambda: smallest_region(np.zeros((1, 5000))), ProblemError, "not vary"),
        (lambda: box_region(np.full((2, 100), np.nan)), CallError, "finite"),
        (lambda: ellipsoid_region(np.zeros((2, 100)), 1.0), CallError, "below 1"),
        (lambda: smallest_region(normal_trials(0.0, trials=9999)), CallError, "10000"),
        (lambda: normal_region([1.0], np.eye(2)), CallError, "expected"),
    ],
)
def test_what_has_no_region_is_refused(call, error, words):
    """Each message says what is missing."""
    with pytest.raises(error, match=words):
        call()
