"""Longer tests by the noise of their windows: the same answers, of few calibrations."""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose

import budget
from budget.calibration.problem import _frame
from budget.studies.allocation import allocate, longer_tests

WANTED = {
    "name": "wanted",
    "environment": "none",
    "reference": "next_turn_on",
    "limits": {
        "gyro": {"mounting_angle": "5 arcsec", "bias": {"z": "0.01 deg/h"}},
        "accelerometer": {"mounting_angle": "5 arcsec", "bias": "80 ug"},
        "mission": {
            "position": {"horizontal": "1 nmi", "at": "1 h", "probability": "50 %"}
        },
    },
}
MOST = 12  # calibrations of one device, with all that an allocation asks of it


@pytest.fixture(autouse=True)
def searched_anew(monkeypatch):
    """Search every time: elsewhere a longer test is searched once for all tests."""
    find = longer_tests.find_longer_tests
    monkeypatch.setattr(allocate, "find_longer_tests", find)


def allocated(**options):
    """Return the allocation of the paper's device and the calibrations set up."""
    _frame.cache_clear()
    found = budget.allocate(
        "zhao-2019", requirement=WANTED, mission="bench", validate=False, **options
    )
    return found, _frame.cache_info().misses


@pytest.mark.slow
@pytest.mark.parametrize("procedure", [None, "twenty-four-positions"])
def test_longer_tests_are_those_of_calibrations_built_anew(procedure, monkeypatch):
    """Every answer is that of setting up each test; by noise alone there are few."""
    quick, few = allocated(procedure=procedure)
    monkeypatch.setattr(longer_tests, "_changes_noise", lambda _: False)
    slow, many = allocated(procedure=procedure)
    assert few <= MOST < many
    assert quick.longer_tests
    for one, other in zip(quick.longer_tests, slow.longer_tests, strict=True):
        assert (one.sensor, one.name, one.goal) == (
            other.sensor,
            other.name,
            other.goal,
        )
        assert (one.needed, one.best) == (other.needed, other.best)
        assert_allclose(one.utilisation, other.utilisation, rtol=1e-9)


@pytest.mark.slow
def test_a_test_that_moves_more_than_noise_is_set_up(monkeypatch):
    """Where more turns make another estimator, each number of them is set up."""
    built, known = [], longer_tests._changes_noise  # noqa: SLF001

    def changes_noise(case):
        built.append(known(case))
        return built[-1]

    monkeypatch.setattr(longer_tests, "_changes_noise", changes_noise)
    monkeypatch.setattr(longer_tests, "MOST_TURNS", 3)
    budget.allocate(
        "zhao-2019",
        requirement=WANTED | {"limits": {"gyro": {"scale_factor": "0.1 ppm"}}},
        procedure="norm-and-turns-by-hand",
        validate=False,
    )
    assert built == [False]
