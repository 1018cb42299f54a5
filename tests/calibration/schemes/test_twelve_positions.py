"""Gyro bias of twelve positions: what drops out, exactly, and what it costs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import line, procedure, sensor
from keeping import Pulses
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import schedule_of, scheme_of
from budget.errors import SpecError
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.units import ARCSEC, DEG_PER_HOUR

BIAS = slice(9, 12)
PLAN = procedure(azimuths=())
FALSE_ALARM = 4.5  # standard deviations of each u; 24 of them: 2e-4


def biases(plan, lines=None, **more):
    """Return the u of the three biases by each source, by its name [rad/s]."""
    gyro = sensor("gyro", lines or {}, bias=2.5 * DEG_PER_HOUR, angle=2.0 * ARCSEC)
    problem = calibration_problem((gyro,), replace(plan, **more))
    found = propagate(problem).source_variance[:, BIAS] ** 0.5
    return dict(zip([g.name for g in problem.groups], found, strict=True))


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("latitude", 60.0 * ARCSEC),
        ("earth_rate", 0.1 * DEG_PER_HOUR),
        ("levelling.east", 60.0 * ARCSEC),
        ("levelling.north", 60.0 * ARCSEC),
        ("azimuth", 60.0 * ARCSEC),
    ],
)
@pytest.mark.parametrize("flip", ["inner", "middle"])
def test_place_and_level_drop_out(name, size, flip):
    """Below the last digits; at azimuths the first three go into the vertical axis."""
    station = (line(name, [size]),)
    plans = [replace(p, station=station) for p in (PLAN, procedure())]
    accelerometer = replace(PLAN.accelerometer, flip_axis=flip)
    twelve = biases(plans[0], accelerometer=accelerometer)
    four = biases(plans[1])

    assert twelve[f"station.{name}"].max() < 1e-10 * DEG_PER_HOUR
    if name in {"latitude", "earth_rate", "levelling.east"}:
        assert four[f"station.{name}"][2] > 1e-3 * DEG_PER_HOUR


def test_what_an_axis_feels_of_gravity_along_itself_drops_out():
    """G_iz g at azimuths, z up: 0.998985 deg/h of 1 deg/h/g; here nothing is left."""
    G = DEG_PER_HOUR / 9.80665
    lines = {"g_sensitivity": np.full(9, G)}
    four, twelve = biases(procedure(), lines), biases(PLAN, lines)

    wanted = 0.998985 * DEG_PER_HOUR
    assert_allclose(four["gyro.g_sensitivity"], wanted, rtol=1e-6)
    assert twelve["gyro.g_sensitivity"].max() < 1e-9 * wanted


def test_white_noise_costs_what_four_dwells_do():
    """N/sqrt(4 L) of each axis, as at four azimuths: each is read in four dwells."""
    N = 0.005 * DEG_PER_HOUR * 60.0
    twelve = biases(PLAN, {"angle_random_walk": N})["gyro.angle_random_walk"]

    assert_allclose(twelve, N / np.sqrt(4.0 * 300.0), rtol=1e-7)


def test_both_triads_stand_in_the_same_dwells():
    """One clock and the same stops: what the table misses there is felt by both."""
    gyro, other = (schedule_of(owner, PLAN) for owner in ("gyro", "accelerometer"))
    assert gyro.windows[6:] == other.windows
    assert [gyro.stops[6 + k] for k in range(12)] == [other.stops[k] for k in range(12)]
    assert gyro.n_stops == other.n_stops
    weights = scheme_of("gyro", PLAN).weights[:, 3]
    assert_allclose(weights.sum(axis=1), np.ones(3), rtol=1e-15)


@pytest.mark.slow
def test_pulses_agree_with_the_law():
    """Twenty-four u of 200 runs within chance; one and a half times it is not."""
    plan = replace(
        PLAN, sample_rate=1.0, station=(line("positioning", [100.0 * ARCSEC]),)
    )
    lines = {
        "bias_repeatability": 0.05 * DEG_PER_HOUR,
        "angle_random_walk": 0.05 * DEG_PER_HOUR * 60.0,
        "g_sensitivity": np.full(9, DEG_PER_HOUR / 9.80665),
    }
    pair = (
        sensor("gyro", lines, bias=2.5 * DEG_PER_HOUR, angle=2.0 * ARCSEC),
        sensor("accelerometer", {"velocity_random_walk": 1e-3}, bias=0.06),
    )
    runs = 200
    errors = Pulses(pair, plan, seed=9).errors(runs, reference="nominal")
    law = propagate(calibration_problem(pair, plan)).standard_uncertainty
    u, allowed = errors.std(axis=0, ddof=1), FALSE_ALARM / np.sqrt(2.0 * (runs - 1))

    assert np.abs(u / law - 1.0).max() < allowed
    assert np.abs(u / (1.5 * law) - 1.0).max() > allowed


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("gyro: {bias: twelve_positions, dwell: 3 s}", ("gyro.dwell", "remove it")),
        ("gyro: {bias: twelve_positions}\nformulas: paper", ("formulas", "azimuths")),
        ("gyro: {bias: six}", ("gyro.bias", "twelve_positions")),
    ],
)
def test_keys_that_do_not_go_together_are_refused(tmp_path, text, words):
    """Which, and what to do."""
    path = put(tmp_path / "mine.yaml", text + "\n")
    with pytest.raises(SpecError) as caught:
        load_procedure(path)

    assert_says(str(caught.value), *words)
