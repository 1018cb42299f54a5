"""Devices ranked by what their errors do on a mission."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from builders import SMALL, Elsewhere, device, paper_device, requirement
from numpy.testing import assert_allclose

from budget.errors import CallError
from budget.inputs import load_device, load_mission, uncalibrated
from budget.inputs.records import Limit
from budget.names import MISSION, Name
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare

BENCH = load_mission("bench")
BOTH = ("gyro", "accelerometer")
LAW = {"method": "gum", "mission": BENCH}
TEN_MINUTES, HOUR = 600.0, 3600.0
MILE = 1852.0  # [m]


def on_mission(*limits, sensors=(), times=1.0):
    """Return a requirement on a mission: (quantity, axis, time, limit, coverage)."""
    basis = requirement(sensors=sensors, times=times, reference="next_turn_on")
    own = tuple(
        Limit(
            output=Name(quantity, owner=MISSION, axis=axis, time=time),
            limit=limit,
            printed=f"{limit:g}",
            coverage=coverage,
        )
        for quantity, axis, time, limit, coverage in limits
    )
    return replace(basis, limits=(*basis.limits, *own))


def horizontal(limit, *, time=TEN_MINUTES, coverage=0.5):
    """Return a limit on the horizontal position."""
    return ("position", "horizontal", time, limit, coverage)


def imu(name="paper", *, times=1.0, missing=()):
    """Return the paper's device of both sensors."""
    return paper_device(name, times=times, sensors=BOTH, missing=missing)


def listed(comparison):
    """Return the verdicts by mission."""
    return [row for row in comparison.devices if row.sensor == MISSION]


def test_better_devices_come_first():
    """With all lines times two every output is twice as large, so is the part used."""
    wanted = on_mission(horizontal(5.0 * MILE))
    given = [imu("bad", times=4.0), imu("good", times=1.0), imu("fair", times=2.0)]

    rows = compare(given, wanted, **LAW).devices

    assert [row.name for row in rows] == ["good", "fair", "bad"]
    used = [row.utilisation for row in rows]
    # Products of two lines are of no weight here.
    assert_allclose(used, np.array([1.0, 2.0, 4.0]) * used[0], rtol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limit"),  # [nautical miles]
    [("zhao-2019", 0.2), ("zhao-2019", 5.0), ("adis16495-1", 1.0)],
)
def test_verdict_is_that_of_the_mission_itself(name, limit):
    """Compare and the budget of the mission judge the same device alike."""
    given = load_device(name)
    wanted = on_mission(
        horizontal(limit * MILE), ("attitude", "heading", HOUR, 3e-3, None)
    )

    (row,) = compare([given], wanted, mission=BENCH).devices
    budget = analyze(
        given, procedure=uncalibrated("factory"), requirement=wanted, mission=BENCH
    )
    (found,) = budget.assessment.sensors

    assert (row.verdict, row.utilisation) == (found.verdict, found.utilisation)
    assert row.utilisation_interval == found.utilisation_interval
    assert row.worst_output == found.worst_output
    assert row.remedy.source == found.remedy.source
    assert row.conformance == found.conformance


def test_missing_lines_leave_what_would_meet_undecidable():
    """A line that is not given stops a verdict where at its ceiling it would fail.

    With more room it bounds the verdict alone.
    """
    bare = imu(missing=("bias_stability",))
    free, open_one, failed = (
        row
        for limit in (1e6, 1e4, 1.0)
        for row in compare([bare], on_mission(horizontal(limit)), **LAW).devices
    )

    verdicts = (free.verdict, open_one.verdict, failed.verdict)
    assert verdicts == ("meets_if", "undecidable", "fails")
    assert free.at_ceilings < 1.0 < open_one.at_ceilings
    assert open_one.utilisation.is_bound
    assert {name.owner for name in open_one.missing.lines} == {*BOTH}


@pytest.mark.slow
@pytest.mark.parametrize("calibration", ["none", "factory", "six-positions"])
def test_what_a_new_unit_has_is_expected_of_it(calibration):
    """A data sheet that says nothing of its making meets no limit on a mission by that.

    As of the mission itself: what nobody calibrates is missing there, and here.
    """
    plan = calibration if calibration.startswith("six") else uncalibrated(calibration)
    wanted = on_mission(horizontal(1e6))
    (judged,) = compare(["hg4930#A"], wanted, plan, **LAW).devices
    own = analyze(
        "hg4930#A",
        mission="bench",
        procedure=plan,
        requirement=wanted,
        validate=False,
    )
    lacks = {name for row in own.outputs for name in row.standard_uncertainty.why}
    assert lacks <= {*(() if judged.missing is None else judged.missing.lines)}
    is_open = calibration != "factory"
    assert (judged.verdict == "undecidable") == bool(lacks) == is_open


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_lines_of_others_stand_in_for_missing_ones(mode):
    """What is assumed for a line that is not given counts on the mission too."""
    given = load_device("adis16495-1")
    wanted = on_mission(horizontal(MILE))

    (without,) = compare([given], wanted, **LAW).devices
    (filled,) = compare([given], wanted, missing=mode, **LAW).devices

    assert filled.utilisation > without.utilisation
    assert not filled.is_bound


def test_factor_brings_the_circle_to_its_limit():
    """The limiting line times the factor has a circle as large as the limit."""
    given = load_device("zhao-2019")
    wanted = on_mission(horizontal(1.5 * MILE))
    (row,) = compare([given], wanted, **LAW).devices
    owner, line = row.remedy.source.owner, row.remedy.source.quantity
    sensor = getattr(given, owner)
    mended = replace(
        sensor,
        lines=tuple(
            replace(one, u=row.remedy.factor * one.u) if one.name == line else one
            for one in sensor.lines
        ),
    )

    (after,) = compare([replace(given, **{owner: mended})], wanted, **LAW).devices

    assert abs(row.utilisation - 1.0) > 0.02
    assert_allclose(after.utilisation, 1.0, rtol=1e-4)


def test_devices_with_one_sensor_are_said_not_to_be_comparable():
    """A gyro alone is in no list of the mission, and the reader is told why."""
    wanted = on_mission(horizontal(MILE), sensors=("gyro",), times=1e3)

    found = compare([imu(), paper_device("alone")], wanted, **LAW)

    assert [row.name for row in listed(found)] == ["paper"]
    assert {row.name for row in found.devices if row.sensor == "gyro"} == {
        "paper",
        "alone",
    }
    assert any(
        "have no accelerometer: alone" in text and "mission" in text
        for text in found.warnings
    )


def test_limits_of_sensors_are_ranked_beside_the_mission():
    """Sensors, both as one, and the mission have lists of their own."""
    wanted = on_mission(horizontal(1e6), sensors=BOTH, times=1e-3)

    found = compare([imu()], wanted, **LAW)

    assert {row.sensor: row.verdict for row in found.devices} == {
        "gyro": "fails",
        "accelerometer": "fails",
        MISSION: "meets",
    }
    (pair,) = found.imus
    assert pair.verdict == "fails"
    assert not found.is_met


@pytest.mark.parametrize(
    ("wanted", "options", "word"),
    [
        (on_mission(horizontal(MILE)), {}, "--mission"),
        (
            requirement(reference="next_turn_on"),
            {"mission": BENCH},
            "no limit on a mission",
        ),
        (on_mission(horizontal(MILE, time=2.0 * HOUR)), {"mission": BENCH}, "ends"),
    ],
)
def test_a_mission_and_limits_on_it_belong_together(wanted, options, word):
    """Limits without a mission, one without limits, or after its end are refused."""
    with pytest.raises(CallError, match=word):
        compare([imu()], wanted, method="gum", **options)


def test_nothing_known_of_a_device_is_no_best_one():
    """A device without any line is not ranked: nothing is computed of it."""
    empty = device("empty", gyro={}, accelerometer={})

    found = compare([imu(), empty], on_mission(horizontal(1e6)), **LAW)

    assert [row.name for row in listed(found)] == ["paper"]
    assert [row.name for row in found.nothing_known] == ["empty"]


def test_workers_change_nothing():
    """Candidates that are sent away give the document that one process gives."""
    given = [imu("a"), imu("b", times=1.1)]
    wanted = on_mission(horizontal(MILE))

    one, two = (
        compare(given, wanted, mission=BENCH, executor=executor, **SMALL)
        for executor in (None, Elsewhere())
    )

    assert json.dumps(one.to_dict()) == json.dumps(two.to_dict())
    assert one.to_dict()["mission"] == BENCH.name
