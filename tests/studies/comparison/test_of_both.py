"""Limits on both triads of a device together, in a comparison as in its budget."""

from __future__ import annotations

from itertools import chain
from typing import Any

import pytest
from numpy.testing import assert_allclose

import budget
from budget.names import IMU, MISSION
from budget.studies.comparison.compare import compare

ALONE: dict[str, Any] = {}
WITH_OTHERS = {"gyro": {"bias": "20 deg/h"}, "accelerometer": {"bias": "10 mg"}}


def need(limit: str, more: dict[str, Any], **other: Any) -> dict[str, Any]:
    """Return a requirement on the misalignment at a later turn-on, and on more."""
    return {
        "name": "aligned",
        "reference": "next_turn_on",
        "environment": "none",
        "age": "0 s",
        "limits": {"misalignment": limit, **more},
        **other,
    }


def said_of(rows: Any) -> dict[str, Any]:
    """Return what is said of each sensor: verdict, utilisation, conditions."""
    return {
        one.sensor: (
            one.verdict,
            one.utilisation,
            one.at_ceilings,
            [str(condition.text) for condition in one.conditions],
        )
        for one in rows
    }


# The verdict of the whole; a gyro of a VN-100 beside the limit is undecidable, too.
CASES = [
    ("zhao-2019", "60 arcsec", ALONE, "meets"),
    ("zhao-2019", "5 arcsec", ALONE, "fails"),
    ("vn-100", "60 arcsec", ALONE, "undecidable"),
    ("zhao-2019", "60 arcsec", WITH_OTHERS, "meets"),
    ("zhao-2019", "5 arcsec", WITH_OTHERS, "fails"),
    ("vn-100", "60 arcsec", WITH_OTHERS, "undecidable"),
]


@pytest.mark.parametrize("decision", ["each", "joint"])
@pytest.mark.parametrize(("device", "limit", "more", "verdict"), CASES)
def test_it_says_what_the_budget_says(device, limit, more, verdict, decision):
    """Sensor by sensor and as one, to the words of what to ask for."""
    wanted = need(limit, more, decision=decision)
    found = compare([device], wanted)
    told = budget.analyze(device, requirement=wanted, validate=False).assessment
    (whole,) = found.imus

    assert said_of(found.devices) == said_of(told.sensors)
    assert (whole.verdict, told.verdict) == (verdict, verdict)
    assert_allclose(whole.conformance.value, told.conformance.value, rtol=1e-12)
    asked = [one.asks for one in told.sensors if verdict == "undecidable"]
    assert [str(one.text) for one in whole.asks] == [
        str(one.text) for one in chain(*asked)
    ]
    assert bool(whole.asks) == (verdict == "undecidable")
    assert found.not_compared == ()


def test_a_sensor_alone_is_judged_on_what_is_its_own():
    """Its verdict is the same with the limit on both and without; said once."""
    with_both = need("60 arcsec", {"gyro": {"bias": "200 deg/h"}})
    without = {**with_both, "limits": {"gyro": {"bias": "200 deg/h"}}}
    found = compare(["zhao-2019", "adxrs453"], with_both)
    bare = compare(["zhao-2019", "adxrs453"], without)

    own = {one.name: one for one in found.devices if one.sensor != IMU}
    assert {name: one.verdict for name, one in own.items()} == {
        one.name: one.verdict for one in bare.devices
    }
    assert own["Zhao 2019 optical IMU"].verdict == "meets"
    said = [text for text in found.warnings if "misalignment" in text]
    assert len(said) == 1
    assert not [text for text in bare.warnings if "misalignment" in text]
    assert [one.gyro for one in found.imus] == ["Zhao 2019 optical IMU"]
    assert not bare.imus


def test_without_a_device_of_both_it_is_not_compared():
    """Gyros alone: their own limit has an answer, that on both has none."""
    wanted = need("60 arcsec", {"gyro": {"bias": "200 deg/h"}})
    found = compare(["adxrs453"], wanted)
    assert found.not_compared == (IMU,)
    assert {one.sensor for one in found.devices} == {"gyro"}


@pytest.mark.slow
def test_sensors_of_two_devices_do_not_meet_what_nobody_judged():
    """A pair of one device is judged whole; one of two is not, and never meets."""
    devices = ["zhao-2019", "hg4930#A"]
    more = {"gyro": {"bias": "200 deg/h"}, "accelerometer": {"bias": "1 g"}}
    for limits, verdicts in (
        ({"misalignment": "1 deg", **more}, {True: "meets", False: "undecidable"}),
        (more, {True: "meets", False: "meets"}),
    ):
        wanted = {**need("1 deg", {}), "limits": limits}
        found = compare(devices, wanted, pairs=True)
        assert len(found.pairs) == 4
        assert {
            (pair.gyro == pair.accelerometer, pair.verdict) for pair in found.pairs
        } == {*verdicts.items()}


@pytest.mark.slow
def test_every_row_of_the_catalogue_has_conditions_or_an_ask():
    """Under the requirements that ship and one on both; what fails asks for nothing."""
    more = {"gyro": {"bias": "20 deg/h"}, "accelerometer": {"bias": "10 mg"}}
    for wanted in (
        "catalogue-edge",
        "navigation-grade",
        "tactical-grade",
        need("60 arcsec", more),
    ):
        found = compare(budget.load_catalogue(), wanted, method="gum")
        rows = (*found.entrants, *found.imus)
        assert len(rows) > 100
        for one in rows:
            assert bool(one.asks) == (one.verdict == "undecidable")
            if one.verdict != "undecided":  # it may be on conditions, too
                open_ = one.verdict in {"undecidable", "meets_if"}
                assert bool(one.conditions) == open_


DRONE = {
    "name": "drone",
    "environment": "none",
    "limits": {
        "mission": {"position": {"horizontal": "2 m", "at": "660 s"}},
        "gyro": {"bias": "200 deg/h"},
        "accelerometer": {"bias": "200 mg"},
    },
}


def test_a_mission_counts_in_the_verdict_on_a_device():
    """Both triads meet, the mission fails: so does the device, as one and as a pair.

    Of a gyro and an accelerometer of two devices nobody knows the mission.
    """
    found = compare(
        ["hg4930#C", "stim300#10g"],
        DRONE,
        mission="outage-60-s-after-gnss",
        method="gum",
        pairs=True,
    )
    parts = {(one.sensor, one.name): one for one in found.devices}

    assert {one.verdict for (kind, _), one in parts.items() if kind != MISSION} == {
        "meets"
    }
    assert {one.verdict for one in found.imus} == {"fails"}
    for unit in found.imus:
        worst = parts[MISSION, unit.name]
        assert unit.utilisation == worst.utilisation
        assert unit.worst_outputs == worst.worst_outputs
    own = {(one.gyro == one.accelerometer): one.verdict for one in found.pairs}
    assert own == {True: "fails", False: "undecidable"}
