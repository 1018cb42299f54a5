"""A data sheet beside what was measured: ratios, p, lowest Allan deviations, bounds."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS
from scipy.integrate import quad

from budget.errors import CallError
from budget.inputs import load_device
from budget.recordings.printed import (
    beside_data_sheet,
    is_measured,
    lot_beside_data_sheet,
)


def device(name, sensor="gyro", **errors):
    """Return a device of a few lines."""
    return load_device(
        {"format": "budget-device/1", "name": name, sensor: {"errors": errors}}
    )


def beside(printed, measured, sample_rate=100.0):
    """Return what is found by line and axis."""
    found = beside_data_sheet(printed, measured, sample_rate=sample_rate)
    return found, {(one.line, one.axis): one for one in found.lines}


def test_six_turn_ons_beside_a_data_sheet():
    """S = 73.19 deg/h with 5 degrees of freedom, times [.6242, 2.4526], of 50 deg/h."""
    own = {"value": "73.19 deg/h", "degrees_of_freedom": 5}
    found, by_line = beside(
        device("sheet", bias_repeatability="50 deg/h"),
        device("unit", bias_repeatability=own),
    )
    one = by_line["bias_repeatability", "x"]
    assert_allclose(one.ratio, 73.19 / 50.0, rtol=1e-12)
    assert_allclose(one.interval, 73.19 / 50.0 * np.array([0.6242, 2.4526]), rtol=1e-4)
    # By quadrature of the density of chi-square with 5 degrees of freedom.
    square = 5.0 * one.ratio**2
    p, _ = quad(lambda x: x**1.5 * np.exp(-x / 2.0) / 7.519884823893, square, 200.0)
    assert_allclose(one.p, p, rtol=1e-8)
    assert one.standing == "within"
    assert_allclose(found.level, 0.05 / 3.0)
    assert not found.worse


@pytest.mark.parametrize(("nu", "standing"), [(5, "within"), (60, "worse")])
def test_more_readings_tell_more(nu, standing):
    """A ratio of 1.46 is nothing of 5 readings, and worse of 60."""
    own = {"value": "73.19 deg/h", "degrees_of_freedom": nu}
    found, _ = beside(
        device("sheet", bias_repeatability="50 deg/h"),
        device("unit", bias_repeatability=own),
    )
    assert {one.standing for one in found.lines} == {standing}
    assert len(found.worse) == (3 if standing == "worse" else 0)


def test_a_lowest_allan_deviation_is_held_beside_one():
    """Of a Gauss-Markov process with white noise, where the curve is flat: by hand.

    N 9 deg/h sqrt(s), sigma 6 deg/h, tau 60 s: the least of N^2/t + (2 s^2 T/t) (1 -
    (T/2t)(3 - 4 exp(-t/T) + exp(-2t/T))) before 1.89 tau.
    """
    slow = {"value": "6 deg/h", "definition": "sigma", "correlation_time": "60 s"}
    found, by_line = beside(
        device(
            "sheet", bias_stability={"value": "4 deg/h", "definition": "allan_minimum"}
        ),
        device(
            "unit",
            angle_random_walk={"value": "0.15 deg/sqrt(h)", "degrees_of_freedom": 4000},
            bias_stability=slow | {"degrees_of_freedom": 60},
            rate_random_walk={"value": "500 deg/h/sqrt(h)", "meaning": "max"},
        ),
    )
    t = np.geomspace(1.0, 1.89 * 60.0, 100_000)
    x = t / 60.0
    slow = 72.0 / x * (1.0 - (3.0 - 4.0 * np.exp(-x) + np.exp(-2.0 * x)) / (2.0 * x))
    lowest = np.sqrt((81.0 / t + slow).min())
    one = by_line["bias_stability", "x"]
    assert one.definition == "allan_minimum"
    assert_allclose(one.ratio, lowest / 4.0, rtol=1e-4)
    assert one.degrees_of_freedom == 60
    assert_allclose(one.printed / one.si_per_unit, 4.0, rtol=1e-12)
    assert by_line["rate_random_walk", "x"].standing == "not_printed"
    assert by_line["angle_random_walk", "x"].standing == "not_printed"
    assert found.worse == ()


def test_flicker_and_walks_have_the_lowest_point_of_their_curve():
    """sqrt(2 N K/sqrt(3)) of white noise and a random walk; 0.664 B of flicker."""
    few = {"degrees_of_freedom": 30}
    sheet = device(
        "sheet", bias_stability={"value": "2 deg/h", "definition": "allan_minimum"}
    )
    N, K = 0.15, 10.0  # deg/sqrt(h), deg/h/sqrt(h)
    walks = device(
        "unit",
        angle_random_walk={"value": f"{N} deg/sqrt(h)"} | few,
        rate_random_walk={"value": f"{K} deg/h/sqrt(h)"} | few,
    )
    _, by_line = beside(sheet, walks)
    one = by_line["bias_stability", "y"]
    assert_allclose(one.ratio, np.sqrt(2.0 * N * K / np.sqrt(3.0)) / 2.0, rtol=1e-4)
    flicker = device("unit", flicker={"value": "5 deg/h"} | few)
    _, by_line = beside(sheet, flicker)
    assert_allclose(by_line["bias_stability", "y"].ratio, 0.664 * 5.0 / 2.0, rtol=1e-4)


def test_two_sigmas_are_held_beside_each_other():
    """Where both are of a Gauss-Markov process nothing is computed."""
    time = {"definition": "sigma", "correlation_time": "60 s"}
    _, by_line = beside(
        device("sheet", bias_stability={"value": "5 deg/h"} | time),
        device(
            "unit",
            bias_stability={"value": "5.5 deg/h", "degrees_of_freedom": 60} | time,
        ),
    )
    one = by_line["bias_stability", "z"]
    assert (one.definition, one.standing) == ("sigma", "within")
    assert_allclose(one.ratio, 1.1, rtol=1e-12)


@pytest.mark.parametrize(
    ("bound", "standing"),
    [("2 deg/h/sqrt(h)", "within"), ("9 deg/h/sqrt(h)", "not_told")],
)
def test_a_bound_is_within_or_tells_nothing(bound, standing):
    """Never better than it is known, never worse than it may be."""
    _, by_line = beside(
        device("sheet", rate_random_walk="3 deg/h/sqrt(h)"),
        device(
            "unit",
            angle_random_walk={"value": "0.15 deg/sqrt(h)", "degrees_of_freedom": 9},
            rate_random_walk={"value": bound, "meaning": "max"},
        ),
    )
    one = by_line["rate_random_walk", "x"]
    assert (one.is_bound, one.p, one.standing) == (True, None, standing)


def test_noise_by_the_sample_is_held_beside_a_density():
    """Sigma 10 deg/h at 100 Hz is N = 1 deg/h sqrt(s), 1/60 deg/sqrt(h)."""
    _, by_line = beside(
        device("sheet", sample_noise="10 deg/h"),
        device(
            "unit",
            angle_random_walk={"value": "0.02 deg/sqrt(h)", "degrees_of_freedom": 400},
        ),
    )
    one = by_line["angle_random_walk", "x"]
    assert_allclose(one.ratio, 1.2, rtol=1e-12)
    assert one.standing == "worse"


def test_what_is_no_recording_is_none():
    """A data sheet with one line of few readings is a data sheet."""
    few = {"value": "50 deg/h", "degrees_of_freedom": 5}
    assert is_measured(device("unit", bias_repeatability=few))
    assert not is_measured(device("sheet", bias_repeatability="50 deg/h"))
    both = device("sheet", bias_repeatability=few, scale_factor_repeatability="100 ppm")
    assert not is_measured(both)


def test_other_sensors_are_refused():
    """Of a gyro beside accelerometers nothing can be said."""
    few = {"value": "50 ug", "degrees_of_freedom": 5}
    with pytest.raises(CallError, match="has no accelerometer"):
        beside(
            device("sheet", bias_repeatability="50 deg/h"),
            device("unit", "accelerometer", bias_repeatability=few),
        )


UNIT = """format: budget-device/1
name: unit 7
gyro:
  errors:
    angle_random_walk: {value: 0.09 deg/sqrt(h), degrees_of_freedom: 300}
    bias_repeatability: {value: 15 deg/h, degrees_of_freedom: 5}
"""


def test_the_command_says_it_once_everywhere(tmp_path, monkeypatch):
    """Terminal, JSON, CSV, page have the same finding; two budgets have no page."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "unit.yaml").write_text(UNIT, encoding="utf-8")
    words = ("diff", "hg4930#A", "unit.yaml")
    found = call(*words, "-o", "a.html", "-o", "a.pdf")
    assert found.code == 0
    assert "unit 7: 3 of 6 figures are worse than HG4930 (A) prints." in found.out
    assert "Printed and not measured: gyro bias stability." in " ".join(
        found.out.split()
    )
    page = " ".join((tmp_path / "a.html").read_text(encoding="utf-8").split())
    assert "figures are worse than HG4930 (A) prints" in page
    told = json.loads(call(*words, "--json", "-").out)
    rows = list(csv.DictReader(io.StringIO(call(*words, "--csv", "-").out)))
    assert [one["standing"] for one in told["lines"]] == [r["standing"] for r in rows]
    worse = [one for one in told["lines"] if one["standing"] == "worse"]
    assert {(one["line"], one["unit"]) for one in worse} == {
        ("angle_random_walk", "°/√hr")
    }
    assert_allclose([one["ratio"] for one in worse], 1.5, rtol=1e-9)
    found = call("diff", "hg4930#A", "hg4930#C", "-o", "b.html")
    assert found.code == 2
    assert "of two budgets there is no page" in found.err
    assert not (tmp_path / "b.html").exists()


def test_a_lot_has_a_size_a_spread_and_its_worst(tmp_path, monkeypatch):
    """Root mean square, standard deviation less that of the values; by hand.

    Units of 0.05, 0.06, 0.07, 0.08 deg/sqrt(h), u = s/sqrt(600) each.
    """
    monkeypatch.chdir(tmp_path)
    values = np.array([0.05, 0.06, 0.07, 0.08])
    units = []
    for k, value in enumerate(values):
        text = UNIT.replace("unit 7", f"unit {k}").replace("0.09", f"{value:g}")
        units.append(tmp_path / f"unit-{k}.yaml")
        units[-1].write_text(text, encoding="utf-8")
    sheet = load_device("hg4930#A")
    found = lot_beside_data_sheet(sheet, [*map(load_device, units)], sample_rate=100.0)
    one = next(x for x in found.lines if x.line == "angle_random_walk")
    size, spread, largest = (
        x / one.si_per_unit for x in (one.size, one.spread, one.largest)
    )
    assert_allclose(size, np.sqrt(np.mean(values**2)), rtol=1e-9)
    own = np.mean(values**2) / 600.0
    assert_allclose(spread, np.sqrt(np.var(values, ddof=1) - own), rtol=1e-9)
    assert_allclose(largest, 0.08, rtol=1e-9)
    assert (one.largest_unit, one.units) == ("unit 3", 4)
    assert one.worse == found.worse == ("unit 2", "unit 3")
    # 15 deg/h of four units alike: they scatter less than five readings of each.
    bias = next(x for x in found.lines if x.line == "bias_repeatability")
    assert bias.spread == 0.0
    said = call(
        "diff", "hg4930#A", *map(str, units), "-o", "a.html", "--json", "a.json"
    )
    assert "2 of 4 units are worse than HG4930 (A) prints: unit 2, unit 3." in said.out
    told = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert told["lines"][0]["units"] == 4
    twice = call("diff", "hg4930#A", str(units[0]), str(units[0]))
    assert "two units have one name" in twice.err
    three = call("diff", "hg4930#A", "hg4930#B", "hg4930#C")
    assert three.code == twice.code == 2
    assert "3 are given, expected 2" in three.err


@pytest.mark.slow
def test_five_real_units_are_as_the_page_says(tmp_path, monkeypatch):
    """MPU-9150 in a hand (docs/recordings.md): gyros 17 to 27 times what is printed."""
    monkeypatch.chdir(tmp_path)
    folder = TESTS / "data" / "mpu-9150"
    units = []
    for path in sorted(folder.glob("*.csv")):
        values = np.loadtxt(path, delimiter=",", skiprows=1)
        units.append(f"{path.stem}.yaml")
        said = call("characterise", str(path), "--rate", "100", "-o", units[-1])
        assert said.code == 0
        assert "Too short to tell more than white noise" in said.out
        # N^2 of means of 10 samples, apart from the few that are kept out.
        means = values[:, 3].reshape(-1, 10).mean(axis=1)
        N = np.std(means, ddof=1) * np.sqrt(0.1)
        own = load_device(units[-1]).gyro.line("angle_random_walk").u[0]
        assert_allclose(own, N, rtol=0.03)
    told = json.loads(call("diff", "mpu-9150", *units, "--json", "-").out)
    ratios = {}
    for one in told["lines"]:
        assert len(one["worse"]) == 5
        ratios.setdefault(one["sensor"], []).append(one["ratio"])
    assert_allclose(ratios["gyro"], [16.8, 26.9, 20.8], rtol=0.01)
    assert_allclose(ratios["accelerometer"], [1.69, 2.16, 2.57], rtol=0.01)


def test_units_of_unlike_models_are_no_lot_of_one_line():
    """A sigma and a lowest Allan deviation stand apart; a change has no nu, and is."""
    time = {"definition": "sigma", "correlation_time": "60 s"}
    few = {"degrees_of_freedom": 30}
    warm = "0.02 deg/h/degC"
    sheet = device(
        "sheet",
        bias_stability={"value": "5 deg/h"} | time,
        bias_temperature_coefficient="0.03 deg/h/degC",
    )
    units = [
        device(
            "a",
            bias_stability={"value": "4 deg/h"} | time | few,
            bias_temperature_coefficient=warm,
        ),
        device("b", flicker={"value": "4 deg/h"} | few),
    ]
    found = lot_beside_data_sheet(sheet, units, sample_rate=100.0)
    rows = {(one.definition, one.axis): one for one in found.lines}
    assert rows["sigma", "x"].units == rows["allan_minimum", "x"].units == 1
    _, by_line = beside(sheet, units[0])
    assert by_line["bias_temperature_coefficient", "x"].standing == "within"
