"""Coverage intervals and numerical tolerances, by hand and by the standard."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from budget.methods.intervals import (
    interval_of_trials,
    interval_of_values,
    numerical_tolerance,
    sort_tails,
)
from budget.problem import Output

TEN = np.sort([0.0, 9.5, 1.0, 8.0, 2.0, 7.0, 3.0, 6.0, 4.0, 50.0])[None]


def test_intervals_of_a_small_sample_by_hand():
    """M 10, p 0.7: q 7; symmetric from value 2 to 9 (7.7.2), shortest 0 to 8."""
    assert_array_equal(interval_of_values(TEN, 0.7, "symmetric"), [[1.0, 9.5]])
    assert_array_equal(interval_of_values(TEN, 0.7, "shortest"), [[0.0, 8.0]])


@pytest.mark.parametrize("kind", ["symmetric", "shortest"])
@pytest.mark.parametrize("coverage", [0.01, 0.5, 0.99])
def test_intervals_exist_for_tiny_samples(coverage, kind):
    """Two values give themselves as the interval at any coverage."""
    two = np.array([[1.0, 2.0]])
    assert_array_equal(interval_of_values(two, coverage, kind), two)


@pytest.mark.parametrize("kind", ["symmetric", "shortest"])
@pytest.mark.parametrize("coverage", [0.1, 0.5, 0.95, 0.9999])
@pytest.mark.parametrize("n", [2, 3, 999, 1000, 12_345])
def test_trials_need_not_be_sorted(n, coverage, kind):
    """The interval is the same to the bit: ties, tails, trials that ascend, any n."""
    rng = np.random.default_rng(n)
    for trials in (
        rng.standard_normal(n),
        rng.standard_cauchy(n),
        np.zeros(n),
        np.arange(n, 0.0, -1.0),
        np.where(np.arange(n) % 12 == 0, rng.random(n), 5.0),  # some tell little
        np.where(np.arange(n) % 12 == 0, rng.random(n), -5.0),
    ):
        expected = interval_of_values(np.sort(trials)[None], coverage, kind)[0]
        assert_array_equal(interval_of_trials([trials], coverage, kind), expected)


@pytest.mark.parametrize("depth", [1, 30, 1_000, 6_172, 20_000])
@pytest.mark.parametrize("n", [1, 2, 999, 12_345])
def test_ends_are_sorted_as_deep_as_asked(n, depth):
    """So many at either end stand as among all ascending ones: tails, ties, any n."""
    rng = np.random.default_rng(n)
    trials = np.stack(
        [
            rng.standard_cauchy(n),
            np.arange(n, 0.0, -1.0),
            np.where(np.arange(n) % 12 == 0, rng.random(n), 5.0),
            np.where(np.arange(n) % 12 == 0, rng.random(n), -5.0),
        ]
    )
    found, expected = sort_tails(trials, np.full(4, depth)), np.sort(trials, axis=1)

    assert_array_equal(found[:, :depth], expected[:, :depth])
    assert_array_equal(found[:, -depth:], expected[:, -depth:])


def test_coverages_of_their_own_are_those_of_each_output():
    """Outputs with unlike coverages have the intervals that each has alone."""
    ordered = np.sort(np.random.default_rng(3).standard_normal((3, 500)), axis=1)
    coverages = np.array([0.9, 0.5, 0.9])

    assert_array_equal(
        interval_of_values(ordered, coverages, "symmetric"),
        [
            interval_of_values(row[None], p, "symmetric")[0]
            for row, p in zip(ordered, (0.9, 0.5, 0.9), strict=True)
        ],
    )


@pytest.mark.parametrize(
    ("u", "digits", "expected"),
    [
        # JCGM 101:2008, 7.9.2, examples 1 and 2: 0.000 35 is 35 x 10^-5; 2 is 2 x 10^0.
        (0.00035, 2, 0.5e-5),
        (2.0, 1, 0.5),
        (9.96, 2, 0.5),  # rounds to 10, two digits: 1 and 0
        (9.94, 2, 0.05),
        (0.0951, 1, 0.05),
        (1e-300, 1, 0.5e-300),
    ],
)
def test_numerical_tolerance(u, digits, expected):
    """Half a unit in the last significant digit of u."""
    found = numerical_tolerance(np.array([u]), (Output(name="y"),), digits)
    assert_allclose(found, [expected], rtol=1e-12)


def test_tolerance_is_that_of_the_printed_unit():
    """6 arcsec has the tolerance of 0.5 arcsec, whatever that is in radians."""
    arcsec = 4.84813681109536e-06
    output = Output(name="angle", unit="arcsec", si_per_unit=arcsec)
    found = numerical_tolerance(np.array([6.0 * arcsec]), (output,), 1)
    assert_allclose(found, [0.5 * arcsec], rtol=1e-12)
