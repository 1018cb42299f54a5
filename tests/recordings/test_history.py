"""Calibrations over time: drift with its interval, what it reaches, what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS
from scipy.stats import binom, linregress

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
        "name: r\nlimits:\n  gyro:\n    bias: 2 deg/h\n", encoding="utf-8"
    )
    found = history(FOLDER, requirement=tmp_path / "r.yaml")
    one = found.first_to_reach
    assert (one.parameter, one.axis) == ("bias", "x")
    left = 2.0 - one.values[-1].expanded
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
                "bias_repeatability": "1 deg/h",
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


def test_unsound_runs_are_left_out_and_said(tmp_path):
    """They are no values of the unit."""
    found = history(written(tmp_path, is_sound=False))
    assert len(found.parameters[0].values) == 3
    assert "cal-0.json is of a run that was not sound" in str(found.warnings[0])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"date": ""}, "has the date '', expected one as 2026-05-31"),
        ({"date": "May"}, "calibrate --date"),
        ({"serial": "8"}, "are of several units (7, 8)"),
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
