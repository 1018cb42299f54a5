"""What a parameter has gone since its calibration, by the age of that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import (
    ACC_BIAS,
    ACC_SF,
    GYRO_BIAS,
    GYRO_SF,
    UNITS,
    at_sources,
    line,
    procedure,
    triads,
)
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.errors import CallError, SpecError
from budget.inputs import load_device, load_procedure
from budget.methods.gum import propagate
from budget.missing.expected import expecting
from budget.model.sources.later import DRIFT, RANDOM_WALK, growth
from budget.studies.analysis import analyze
from budget.units import DEG_PER_HOUR, MICRO_G, PPM, YEAR, parse_quantity

DEVICE = """
format: budget-device/1
name: one that ages
accelerometer:
  errors:
    bias_repeatability: {}
    ageing: {}
"""


def ages(*horizons, law=""):
    """Return a line with those horizons, of years."""
    points = tuple((years * YEAR, size) for years, size in horizons)
    return replace(line("ageing", [1.0, 1.0, 1.0]), horizons=points, form=law)


@pytest.mark.parametrize(
    ("law", "shorter", "longer"),
    [(DRIFT, 0.25, 4.0), (RANDOM_WALK, 0.5, 2.0), ("", 0.5, 4.0)],
)
def test_one_horizon_is_left_by_its_law(law, shorter, longer):
    """A drift is as the age, a random walk as its root, unsaid the larger of both."""
    one = ages((2.0, 1.0), law=law)
    found = [growth(one, years * YEAR) for years in (0.0, 0.5, 2.0, 8.0)]
    assert_allclose(found, [0.0, shorter, 1.0, longer], rtol=1e-12)


def test_between_two_horizons_it_is_a_power_of_time():
    """0.01 after a day and 1 after 100: a tenth after 10; the ends by the law."""
    day = 1.0 / 365.25
    one = ages((day, 0.01), (100.0 * day, 1.0), law=RANDOM_WALK)
    years = np.array([0.25, 1.0, 10.0, 100.0, 400.0]) * day
    found = [growth(one, age * YEAR) for age in years]
    assert_allclose(found, [0.005, 0.01, 0.1, 1.0, 2.0], rtol=1e-12)


def test_nobody_knows_an_ageing_without_horizon():
    """It is refused, never taken for one of a year."""
    with pytest.raises(CallError, match="without a horizon"):
        growth(line("ageing", [1.0] * 3), YEAR)


AGED = tuple(
    replace(
        sensor,
        lines=tuple(
            replace(one, horizons=((YEAR, 1.0),), form=DRIFT)
            for one in sensor.lines
            if "ageing" in one.name
        ),
    )
    for sensor in triads(
        {"ageing": 0.1 * DEG_PER_HOUR, "scale_factor_ageing": 50.0 * PPM},
        {"ageing": 300.0 * MICRO_G, "scale_factor_ageing": 80.0 * PPM},
    )
)
HALF = procedure(environment=(line("age", [0.5 * YEAR]),), dwell=5.0, sample_rate=20.0)


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_age_counts_at_a_later_turn_on_alone(reference):
    """Db = u A/H and dk likewise, of a horizon H at an age A; else nothing."""
    law = propagate(calibration_problem(AGED, HALF, reference=reference))
    u = law.standard_uncertainty / UNITS
    part = 0.5 if reference == "next_turn_on" else 0.0
    assert_allclose(u[GYRO_BIAS], 0.1 * part, rtol=1e-5, atol=1e-9)
    assert_allclose(u[ACC_BIAS], 300.0 * part, rtol=1e-5, atol=1e-6)
    assert_allclose(u[GYRO_SF], 50.0 * part, rtol=1e-5, atol=1e-9)
    assert_allclose(u[ACC_SF], 80.0 * part, rtol=1e-5, atol=1e-9)


def test_pulses_show_the_same_ageing(monkeypatch):
    """A simulated run that ages by known values has the errors of the function."""
    monkeypatch.setattr("budget.calibration.simulation._values", lambda one, *_: one.u)
    problem = calibration_problem(AGED, HALF, reference="next_turn_on")
    x = at_sources(
        problem,
        **{
            f"{sensor.kind}__{one.name}": one.u
            for sensor in AGED
            for one in sensor.lines
        },
    )
    exact = problem.evaluate(x[:, None])[:, 0] / UNITS
    found = simulate(AGED, HALF, run=0, reference="next_turn_on") / UNITS
    assert_allclose(exact[ACC_BIAS], -150.0, rtol=1e-3)
    assert_allclose(found, exact, rtol=1e-6, atol=1e-6)


def write(tmp_path, repeatability="20 ug", ageing="{value: 300 ug, horizon: 1 year}"):
    """Write a device with these two lines."""
    return put(tmp_path / "aged.yaml", DEVICE.format(repeatability, ageing))


def test_a_file_says_how_it_ages(tmp_path):
    """Horizons, law and meaning are read; what is not said is assumed aloud."""
    says = (
        "{value: 300 ug, horizon: 1 year, meaning: 3 sigma, "
        "earlier: [{value: 15 ug, horizon: 1 month}]}"
    )
    device = load_device(write(tmp_path, ageing=says))
    one = device.accelerometer.line("ageing")
    assert_allclose(one.u, 100.0 * MICRO_G, rtol=1e-12)
    assert_allclose(one.horizons, [(YEAR / 12.0, 0.05), (YEAR, 1.0)], rtol=1e-12)
    assert_says(
        " ".join(device.assumptions),
        "law not given, the larger of drift and random walk",
    )
    assert "15 ug after 1 month" in one.definition


@pytest.mark.parametrize(
    ("ageing", "message"),
    [
        ("300 ug", "expected more beside the value: {value: 300 ug, horizon: 1 year}"),
        ("{value: 300 ug}", "'horizon' is missing"),
        ("{value: 300 ug, horizon: long}", "expected a time"),
        ("{value: 300 ug, horizon: 1 year, law: linear}", "expected 'drift' or"),
        (
            "{value: 3 ug, horizon: 1 day, earlier: [{value: 1 ug, horizon: 2 days}]}",
            "found '2 days' before '1 day', expected times that rise",
        ),
        (
            "{value: 3 ug, horizon: 1 day, earlier: [{value: 4 ug, horizon: 1 h}]}",
            "found '4 ug' before '3 ug', expected values that do not fall",
        ),
        (
            "{value: 3 ug, horizon: 1 day, earlier: [{value: 0 ug, horizon: 1 h}]}",
            "found 0, expected more",
        ),
        (
            "{axes: {x: 1 g, y: 1 g, z: 1 g}, horizon: 9 h, earlier: [*one]}".replace(
                "*one", "{value: 1 ug, horizon: 1 h}"
            ),
            "beside one value of all axes",
        ),
    ],
)
def test_an_ageing_that_says_too_little_is_refused(tmp_path, ageing, message):
    """Every fault names what was found and what is expected."""
    with pytest.raises(SpecError) as caught:
        load_device(write(tmp_path, ageing=ageing))
    assert message in str(caught.value)


def test_what_holds_over_a_year_contains_the_ageing(tmp_path):
    """Both count twice and are refused, unless the file says that they are two."""
    long = "{value: 20 ug, horizon: 1 year}"
    with pytest.raises(SpecError, match="is given over 1 year and so contains"):
        load_device(write(tmp_path, long))
    runs = "{value: 20 ug, horizon: 6 runs}"
    assert load_device(write(tmp_path, runs)).accelerometer.line("ageing")
    added = "{value: 300 ug, horizon: 1 year, adds_to: bias_repeatability}"
    assert load_device(write(tmp_path, long, added)).accelerometer.line("ageing")


@pytest.mark.parametrize(
    ("horizon", "age", "missing"),
    [
        ("1 year", "1 year", False),
        ("1 year", "13 months", True),
        ("365 days", "1 year", False),
        ("6 runs", "1 day", True),
        ("1 year", None, False),
    ],
)
def test_what_does_not_hold_over_the_age_is_missing(tmp_path, horizon, age, missing):
    """A repeatability is good up to its horizon; beyond it an ageing is expected."""
    path = write(tmp_path, f"{{value: 20 ug, horizon: {horizon}}}")
    text = path.read_text(encoding="utf-8")
    path.write_text(text.partition("    ageing")[0], encoding="utf-8")
    device, how = load_device(path), load_procedure(age=age)
    sensor = expecting(device.accelerometer, how, "next_turn_on")
    assert ("accelerometer.ageing" in sensor.expected_missing) is missing
    assert expecting(device.accelerometer, how, "as_tested") is device.accelerometer
    found = analyze(device, procedure=how, reference="next_turn_on", validate=False)
    lacks = found.question.lacks["accelerometer.bias.x"]
    assert ("accelerometer.ageing" in lacks) is missing
    assert (
        "accelerometer.ageing"
        not in found.question.lacks["accelerometer.mounting_angle.xy"]
    )


def test_an_age_under_another_reference_is_said(tmp_path):
    """It changes nothing there, and the result says what to ask for."""
    device, how = load_device(write(tmp_path)), load_procedure(age="2 years")
    found = analyze(device, procedure=how, validate=False)
    assert_says(
        " ".join(found.warnings), "the age of 2 years enters only at a later turn-on"
    )
    later = analyze(device, procedure=how, reference="next_turn_on", validate=False)
    assert not [text for text in later.warnings if "age of" in text]


def test_years_are_julian():
    """365.25 days of 86400 s, a month the twelfth of that."""
    year = parse_quantity("1 year", "s").value
    assert_allclose(year, 31557600.0, rtol=0)
    for text in ("12 months", "365.25 days", "1 yr", "8766 hours"):
        assert_allclose(parse_quantity(text, "s").value, year, rtol=1e-12)
