"""Calibrations over time: drift with its interval, what it reaches, what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS
from scipy.stats import binom, linregress, norm

from budget.errors import CallError, SpecError
from budget.recordings.history import drift_of, history

FOLDER = TESTS / "data" / "history"


def written(folder, **changes):
    """Copy the results with other words in the first."""
    for path in FOLDER.glob("*.json"):
        document = json.loads(path.read_text(encoding="utf-8"))
        if path.name == "cal-0.json":
            document |= changes
        (folder / path.name).write_text(json.dumps(document), encoding="utf-8")
    return folder


def test_what_drifts_is_found():
    """A bias that goes 0.5 deg/h from year to year; nothing else moves."""
    found = history(FOLDER)
    (one,) = found.drifting
    assert (one.sensor, one.parameter, one.axis) == ("gyro", "bias", "x")
    assert one.drift_low < 0.5 / (1115 / 3 / 365.25) < one.drift_high
    assert [at.date for at in one.values] == sorted(at.date for at in one.values)
    assert found.serial == "7"


def test_a_line_is_that_of_scipy():
    """Of equal weights, scattering more than they are known to: linregress's own."""
    rng = np.random.default_rng(1)
    t = np.array([0.0, 1.0, 2.1, 2.9, 4.2])
    y = 3.0 * t + rng.normal(size=5)
    found, other = drift_of(t, y, np.full(5, 0.1)), linregress(t, y)
    assert found.scatter > 1.0
    assert_allclose([found.slope, found.p], [other.slope, other.pvalue], rtol=1e-9)
    assert_allclose(found.reach, 3.182446305284263 * other.stderr, rtol=1e-9)
    two = drift_of(t[:2], y[:2], np.array([0.3, 0.4]))
    assert_allclose(two.reach, 1.959964 * 0.5, rtol=1e-6)
    assert two.scatter is None


def test_intervals_hold_the_drift():
    """Of values as well known as they are said to be no fewer than 95 %."""
    rng = np.random.default_rng(2)
    t, u, runs = np.arange(5.0), np.array([1.0, 2.0, 1.0, 0.5, 1.0]), 1000
    held = 0
    for _ in range(runs):
        found = drift_of(t, 0.7 * t + u * rng.normal(size=5), u)
        held += abs(found.slope - 0.7) <= found.reach
    assert held >= binom.ppf(1e-3, runs, 0.95)
    half = sum(
        abs(one.slope) <= one.reach / 2.0
        for one in (drift_of(t, u * rng.normal(size=5), u) for _ in range(runs))
    )
    assert half < binom.ppf(1e-3, runs, 0.95)  # the control


def test_scatter_beyond_what_values_are_known_to_is_no_drift():
    """Turn-ons of a steady unit scatter by three times u: at 5 % as seldom as said."""
    rng = np.random.default_rng(3)
    t, u, runs = np.arange(3.0), np.ones(3), 2000
    p = [drift_of(t, 3.0 * rng.normal(size=3), u).p for _ in range(runs)]
    assert sum(one < 0.05 for one in p) <= binom.ppf(1.0 - 1e-3, runs, 0.05)


def test_two_calibrations_tell_no_drift():
    """Nobody knows their scatter."""
    found = drift_of(np.arange(2.0), np.array([0.0, 100.0]), np.ones(2))
    assert found.p is None
    assert found.scatter is None


def test_a_limit_is_reached_when_drift_and_u_are_as_large(tmp_path):
    """By the end of the interval that is farther from 0; expected by the slope."""
    (tmp_path / "r.yaml").write_text(
        "name: r\nreference: as_tested\nlimits:\n  gyro:\n    bias: 2 deg/h\n",
        encoding="utf-8",
    )
    found = history(FOLDER, requirement=tmp_path / "r.yaml")
    one = found.first_to_reach
    assert (one.parameter, one.axis) == ("bias", "x")
    left = 2.0 - norm.ppf(0.975) * one.values[-1].standard_uncertainty
    assert_allclose(one.earliest, left / one.drift_high, rtol=1e-9)
    assert_allclose(one.reaches, left / one.drift, rtol=1e-9)
    steady = next(x for x in found.parameters if x.axis == "y" and x.limit)
    assert steady.reaches is None
    assert steady.earliest > one.earliest


def test_ageing_beyond_the_data_sheet_is_said():
    """Where even the near end of the interval is more than two sigmas of it."""
    sheet = {
        "format": "budget-device/1",
        "name": "ages little",
        "gyro": {
            "errors": {
                "bias_repeatability": "0.01 deg/h",
                "ageing": {"value": "0.1 deg/h", "horizon": "1 year"},
            }
        },
    }
    found = history(FOLDER, device=sheet)
    (one,) = [x for x in found.parameters if x.is_older]
    assert (one.parameter, one.axis) == ("bias", "x")
    assert_allclose(one.ageing, 0.1, rtol=0.01)
    sheet["gyro"]["errors"]["ageing"]["value"] = "0.5 deg/h"
    assert not any(x.is_older for x in history(FOLDER, device=sheet).parameters)


SHEET = {
    "format": "budget-device/1",
    "name": "turns on anew",
    "gyro": {"errors": {"bias_repeatability": "3 deg/h"}},
}


def test_a_value_of_the_unit_has_the_repeatability():
    """As root of both squares; what the sheet does not print is said."""
    alone, found = history(FOLDER), history(FOLDER, device=SHEET)
    for one, other in zip(alone.parameters, found.parameters, strict=True):
        has_own = (one.sensor, one.parameter) == ("gyro", "bias")
        R = 3.0 if has_own else 0.0
        assert one.repeatability is None
        assert (other.repeatability is not None) == has_own
        for a, b in zip(one.values, other.values, strict=True):
            u = np.hypot(a.standard_uncertainty, R)
            assert_allclose(b.standard_uncertainty, u, rtol=1e-12)
            assert_allclose(b.expanded, 1.95996 * u, rtol=1e-5)
    assert not found.drifting
    assert any(
        "the repeatability of the data sheet besides" in str(x)
        for x in found.assumptions
    )
    assert any(
        "says no repeatability of gyro scale factor" in str(x) for x in found.warnings
    )
    assert any("no device is given" in str(x) for x in alone.assumptions)


def test_a_nonlinearity_is_no_repeatability():
    """Of a sheet that prints the shape of a scale factor alone, before it or after."""
    shape = {"scale_factor_nonlinearity": "20 ppm"}
    errors = {**shape, **SHEET["gyro"]["errors"]}
    alone = {**SHEET, "gyro": {"errors": errors}}
    both = {**errors, "scale_factor_repeatability": "70 ppm"}
    for sheet, R in ((alone, None), ({**SHEET, "gyro": {"errors": both}}, 70.0)):
        found = history(FOLDER, device=sheet).parameters
        own = [x for x in found if (x.sensor, x.parameter) == ("gyro", "scale_factor")]
        assert len(own) == 3
        for one in own:
            if R is None:
                assert one.repeatability is None
            else:
                assert_allclose(one.repeatability, R, rtol=1e-12)


def test_limits_of_the_next_turn_on_have_the_repeatability_twice(tmp_path):
    """As `calibrate` they are refused without it; what cannot be judged is listed."""
    (tmp_path / "r.yaml").write_text(
        "name: r\nlimits:\n  gyro:\n    bias: 20 deg/h\n    scale_factor: 5 ppm\n",
        encoding="utf-8",
    )
    with pytest.raises(CallError, match="without the repeatability of the unit"):
        history(FOLDER, requirement=tmp_path / "r.yaml")
    found = history(FOLDER, requirement=tmp_path / "r.yaml", device=SHEET)
    one = next(x for x in found.parameters if (x.parameter, x.axis) == ("bias", "x"))
    u = history(FOLDER).parameters[9].values[-1].standard_uncertainty
    left = 20.0 - norm.ppf(0.975) * np.sqrt(u**2 + 2.0 * 3.0**2)
    far = max(abs(one.drift_low), abs(one.drift_high))
    assert_allclose(one.earliest, left / far, rtol=1e-7)
    assert any("limits that are not judged" in str(x) for x in found.warnings)
    assert all(x.limit is None for x in found.parameters if x.parameter != "bias")
    (tmp_path / "n.yaml").write_text(
        "name: n\nreference: nominal\nlimits:\n  gyro:\n    bias: 20 deg/h\n",
        encoding="utf-8",
    )
    with pytest.raises(CallError, match="limits errors of reference nominal"):
        history(FOLDER, requirement=tmp_path / "n.yaml", device=SHEET)


@pytest.mark.parametrize("R", [0.0, 3.0])
def test_turn_ons_of_values_not_alike_are_no_drift(R):
    """Steady, u of 0.1 to 1, turn-ons of 3: drift at 5 %, as R is known or not."""
    rng = np.random.default_rng(5)
    t, u, runs = np.arange(6.0), np.array([1.0, 1.0, 0.2, 1.0, 1.0, 0.1]), 1000
    y = rng.normal(size=(runs, 6)) * np.hypot(u, 3.0)
    p = [drift_of(t, one, np.hypot(u, R)).p for one in y]
    # By Birge's ratio alone 57 of 100 drift; Student's t is near, as weights are found.
    assert sum(one < 0.05 for one in p) <= binom.ppf(1.0 - 1e-3, runs, 0.06)


def test_exact_and_unknown_values_have_a_line():
    """Of u 0 it is that of the scatter alone; of nan nothing is told."""
    t, y = np.arange(4.0), np.array([0.0, 1.1, 1.9, 3.0])
    found, other = drift_of(t, y, np.zeros(4)), linregress(t, y)
    assert_allclose([found.slope, found.p], [other.slope, other.pvalue], rtol=1e-9)
    assert found.scatter is None
    assert drift_of(t, 2.0 * t, np.zeros(4)).p < 1e-9
    still = drift_of(t, np.zeros(4), np.zeros(4))
    assert (still.slope, still.p) == (0.0, 1.0)
    none = drift_of(t, y, np.array([1.0, np.nan, 1.0, 1.0]))
    assert (none.p, none.reach) == (None, None)


def test_a_run_that_is_given_twice_is_one_calibration(tmp_path):
    """A copy, and the same written again; one of two days is refused."""
    folder = written(tmp_path)
    text = (folder / "cal-1.json").read_text(encoding="utf-8")
    (folder / "copy.json").write_text(text, encoding="utf-8")
    (folder / "again.json").write_text(
        json.dumps(json.loads(text), indent=2), encoding="utf-8"
    )
    found = history(folder)
    assert len(found.parameters[0].values) == 4
    assert_allclose(
        [x.drift for x in found.parameters],
        [x.drift for x in history(FOLDER).parameters],
        rtol=1e-12,
    )
    said = " ".join(map(str, found.warnings))
    assert "copy.json" in said
    assert "again.json and cal-1.json are one run" in said
    recorded = {"inputs": {"recording": {"name": "r.csv", "sha256": "0" * 64}}}
    for name, date in (("a", "2026-01-01"), ("b", "2026-01-02")):
        (folder / f"{name}.json").write_text(
            json.dumps(json.loads(text) | recorded | {"date": date}), encoding="utf-8"
        )
    with pytest.raises(CallError, match=r"a.json and b.json are of the same recording"):
        history(folder)


def test_unsound_runs_are_left_out_and_said(tmp_path):
    """They are no values of the unit."""
    found = history(written(tmp_path, is_sound=False))
    assert len(found.parameters[0].values) == 3
    assert "of a run that was not sound: cal-0.json" in str(found.warnings[0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"date": ""}, "has the date '', expected one as 2026-05-31"),
        ({"date": "May"}, "calibrate --date"),
        ({"serial": "8"}, "are of several units (cal-0.json: 8, cal-"),
        ({"command": "analyze"}, "is no result of a calibration"),
        ({"outputs": []}, "is no result of a calibration"),
    ],
)
def test_what_is_no_history_is_refused(tmp_path, changes, said):
    """With what is missing, once."""
    with pytest.raises((SpecError, CallError)) as caught:
        history(written(tmp_path, **changes))
    assert said in str(caught.value)


def test_one_result_is_no_history():
    """Two at the least; the command ends with 2."""
    assert call("history", str(FOLDER / "cal-0.json")).code == 2
    with pytest.raises(CallError, match="expected 2 or more"):
        history(FOLDER / "cal-0.json")
