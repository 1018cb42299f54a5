"""Mission files: what a vehicle does, one segment after the other, in SI."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
from math import radians

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import ROOT, put

from budget.errors import SpecError
from budget.inputs import load_mission, validate
from budget.inputs.mission import MOST_SEGMENTS, MOST_STEPS
from budget.navigation.growth import Growth
from budget.resources import shipped

STAND = {"stand": "60 s"}
FAST = {"straight": "60 s", "speed": "250 m/s", "heading": "90 deg"}
FILES = sorted((shipped("specs") / "missions").glob("*.yaml"))


def mission(segments=(STAND,), **keys):
    """Return what a file with those segments says; one of None is not there."""
    part = {"latitude": "45 deg", "segments": segments and list(segments), **keys}
    return load_mission({"mission": {k: v for k, v in part.items() if v is not None}})


def issues(segments=(STAND,), **keys):
    """Return what is wrong with such a file: field and words of each issue."""
    with pytest.raises(SpecError) as caught:
        mission(**{"segments": segments, **keys})
    return [(issue.field, issue.message) for issue in caught.value.issues]


def assert_refused(found, *expected):
    """Assert that these are all issues, by their field and a pattern each."""
    assert [field for field, _ in found] == [
        f"mission.{field}" if field else "mission" for field, _ in expected
    ], found
    for (_, message), (_, pattern) in zip(found, expected, strict=True):
        assert re.search(pattern, message), message


def test_a_file_says_all_of_a_mission():
    """Place, start, alignment, altitude and times in SI, and nothing is assumed."""
    one = mission(
        longitude="11 deg",
        height="500 m",
        heading="30 deg",
        alignment="self",
        alignment_time="5 min",
        altitude="free",
        at=["10 s", "1 min"],
    )
    start = one.route.start
    assert_allclose(
        [start.latitude, start.height, start.heading],
        [radians(45.0), 500.0, radians(30.0)],
        rtol=1e-15,
    )
    assert start.speed == 0.0
    assert (one.alignment, one.aided, one.at) == (300.0, False, (10.0, 60.0))
    assert one.assumptions == ()


def test_what_is_not_said_is_assumed_and_said():
    """Height, heading, alignment, altitude, times; speed where it might be another."""
    one = mission([{"stand": "30 min"}])
    assert (one.alignment, one.aided) == (0.0, True)
    assert one.at == (10.0, 60.0, 600.0, 1800.0)
    said = " ".join(one.assumptions)
    for key in ("height", "heading", "alignment", "altitude"):
        assert f"mission.{key}: not given" in said
    assert "10 s, 60 s, 600 s, 1800 s assumed" in said
    assert "mission.speed" not in said  # it stands
    assert "stays level" not in said
    turns = " ".join(mission([{"turn": "90 deg", "rate": "3 deg/s"}]).assumptions)
    assert "mission.speed: not given, 0 m/s" in turns
    assert "stays level" not in turns  # it turns on the spot
    banked = [FAST, {"turn": "90 deg", "rate": "3 deg/s"}]
    assert any("stays level" in text for text in mission(banked).assumptions)
    flight = " ".join(mission([FAST]).assumptions)
    assert "mission.speed" not in flight
    assert "mission.heading" not in flight


def test_segments_become_legs():
    """Each begins as the one before has ended; rates are constant in each."""
    one = mission(
        [
            STAND,
            {"accelerate": "20 s", "to": "30 m/s"},
            {"turn": "-90 deg", "rate": "3 deg/s"},
            {"straight": "10 s", "speed": "30 m/s", "heading": "270 deg"},
            {"climb": "100 s", "rate": "-2 m/s"},
            {"straight": "5 s"},
            {"accelerate": "15 s", "to": "0 m/s"},
            STAND,
        ]
    )
    legs = one.route.legs
    assert_allclose(
        [leg.duration for leg in legs],
        [60.0, 20.0, 30.0, 10.0, 100.0, 5.0, 15.0, 60.0],
        rtol=1e-12,
    )
    assert_allclose(
        [leg.acceleration for leg in legs], [0, 1.5, 0, 0, 0, 0, -2.0, 0], rtol=1e-12
    )
    assert_allclose(
        [leg.turn_rate for leg in legs],
        [0, 0, -radians(3.0), 0, 0, 0, 0, 0],
        rtol=1e-12,
    )
    assert [leg.climb_rate for leg in legs] == [0, 0, 0, 0, -2.0, 0, 0, 0]
    assert_allclose(one.route.duration, 300.0, rtol=1e-12)


def test_a_first_straight_says_how_the_mission_begins():
    """An outage begins in flight; the mission may say the same, or more."""
    start = mission([FAST]).route.start
    assert_allclose([start.speed, start.heading], [250.0, radians(90.0)], rtol=1e-15)
    grouped = mission([{"repeat": 2, "segments": [FAST]}]).route.start
    assert grouped == start
    said = mission([{"straight": "1 s"}], speed="250 m/s", heading="90 deg")
    assert said.route.start == start
    assert mission([FAST], speed="250 m/s", heading="450 deg").route.duration == 60.0


@pytest.mark.parametrize(
    ("segments", "where", "what"),
    [
        (
            [STAND, {**FAST, "heading": "0 deg"}],
            "segments[1].speed",
            "accelerate first",
        ),
        ([FAST, STAND], "segments[1].stand", "accelerate to 0 m/s first"),
        ([STAND, {"straight": "9 s"}], "segments[1].straight", "accelerate first"),
        (
            [FAST, {"straight": "9 s", "heading": "80 deg"}],
            "segments[1].heading",
            "heads 90 deg by then; turn first",
        ),
        (
            [{"repeat": 2, "segments": [FAST, {"turn": "9 deg", "rate": "1 deg/s"}]}],
            "segments[0].segments[0].heading",
            "heads 99 deg",
        ),
    ],
)
def test_a_segment_that_does_not_follow_is_refused(segments, where, what):
    """Nothing jumps in speed or heading; one slip is said once."""
    assert_refused(issues(segments), (where, what))


def test_a_group_is_repeated():
    """A figure of eight is two turns, repeated; a line has its own repeat."""
    turns = [{"turn": f"{sense}360 deg", "rate": "10 deg/s"} for sense in ("", "-")]
    one = mission([{"repeat": 3, "segments": turns}, {**turns[0], "repeat": 2}])
    senses = [leg.turn_rate > 0.0 for leg in one.route.legs]
    assert senses == [True, False] * 3 + [True] * 2


@pytest.mark.parametrize(
    ("segment", "where", "what"),
    [
        ({}, "", "expected one of stand, straight, turn, climb, accelerate"),
        ({**STAND, "turn": "9 deg"}, ".turn", "stands beside stand"),
        ({**STAND, "speed": "1 m/s"}, ".speed", "is of straight, and this is stand"),
        (
            {"turn": "90 deg", "rate": "3 deg/s", "speed": "1 m/s"},
            ".speed",
            "for the speed at the start put it under mission.speed",
        ),
        ({**STAND, "rate": "1 deg/s"}, ".rate", "is of turn or climb"),
        ({**STAND, "to": "1 m/s"}, ".to", "is of accelerate"),
        ({"turn": "9 deg"}, ".turn", "'rate: 3 deg/s'"),
        ({"climb": "9 s"}, ".climb", "'rate: 5 m/s'"),
        ({"accelerate": "9 s"}, ".accelerate", "'to: 100 m/s'"),
        ({"turn": "9 deg", "rate": "1 m/s"}, ".rate", "expected an angular rate"),
        ({"climb": "9 s", "rate": "1 deg/s"}, ".rate", "expected a velocity"),
        ({"turn": "9 deg", "rate": "-1 deg/s"}, ".rate", "positive"),
        ({"turn": "0 deg", "rate": "1 deg/s"}, ".turn", "takes 0 s"),
        ({"stand": "0 s"}, ".stand", "positive"),
        ({"stand": "1 us"}, ".stand", "expected 0.001 s"),
        ({"stand": "25 h"}, ".stand", "to 24 h"),
        ({"stand": "9"}, ".stand", "did you mean '9 s'"),
        ({**FAST, "speed": "-9 m/s"}, ".speed", "not negative"),
        ({**FAST, "speed": "11000 m/s"}, ".speed", "10 km/s"),
        ({"accelerate": "9 s", "to": "11000 m/s"}, ".to", "10 km/s"),
        ({"climb": "9 s", "rate": "-11000 m/s"}, ".rate", "10 km/s"),
        ({"climb": "1 h", "rate": "30 m/s"}, ".climb", "108 km, expected"),
        ({"climb": "1 h", "rate": "-30 m/s"}, ".climb", "-108 km, expected"),
        ({**STAND, "segments": [STAND]}, ".stand", "beside a group"),
        ({"segments": []}, ".segments", "at least"),
        ({**STAND, "repeat": 0}, ".repeat", "expected 1 or more"),
    ],
)
def test_a_segment_is_one_thing_within_bounds(segment, where, what):
    """What it lacks, what is too much in it and what cannot be are said at the key."""
    assert_refused(issues([segment]), (f"segments[0]{where}", what))


@pytest.mark.parametrize(
    ("segments", "what"),
    [
        ([], "names no segment"),
        ([{"repeat": 25, "stand": "1 h"}], "90000 s, expected 24 h"),
        ([{"turn": "1e7 deg", "rate": "1e7 deg/s"}], f"expected {MOST_STEPS}"),
        (
            [{"repeat": MOST_SEGMENTS, "segments": [{**STAND, "repeat": 9}]}],
            f"90000, expected {MOST_SEGMENTS}",
        ),
    ],
)
def test_a_mission_that_would_take_for_ever_is_refused(segments, what):
    """In words and at once, whatever the numbers."""
    assert_refused(issues(segments), ("segments", what))


@pytest.mark.parametrize("sense", ["", "-"])
def test_a_pole_is_not_flown_over(sense):
    """Neither from the start nor on the way, north or south."""
    assert_refused(issues(latitude=f"{sense}89.9 deg"), ("latitude", "no direction"))
    heading = "180 deg" if sense else "0 deg"
    flight = {"straight": "10 h", "speed": "250 m/s", "heading": heading}
    assert_refused(
        issues([flight], latitude=f"{sense}45 deg"), ("segments[0].straight", "a pole")
    )
    assert mission([flight], latitude=f"{'' if sense else '-'}30 deg")


@pytest.mark.parametrize(
    ("keys", "where", "what"),
    [
        ({"latitude": None}, "", "latitude: 45 deg"),
        ({"segments": None}, "", "expected segments"),
        ({"longitude": "361 deg"}, "longitude", "360 deg"),
        ({"height": "101000 m"}, "height", "100 km"),
        ({"height": "-101000 m"}, "height", "100 km"),
        ({"alignment": "self"}, "alignment", "without alignment_time"),
        ({"alignment_time": "60 s"}, "alignment_time", "'alignment: self'"),
        (
            {"alignment": "perfect", "alignment_time": "60 s"},
            "alignment_time",
            "'alignment: self'",
        ),
        ({"alignment": {"self": "60 s"}}, "alignment", "'alignment_time: 300 s'"),
        (
            {"alignment": "self", "alignment_time": "0.5 s"},
            "alignment_time",
            "1 s to 24 h",
        ),
        (
            {"alignment": "self", "alignment_time": "60 s", "segments": [FAST]},
            "alignment",
            "standing",
        ),
        ({"alignment": {"level": "181 deg"}}, "alignment.level", "180 deg at the most"),
        ({"alignment": {"velocity": "1e5 m/s"}}, "alignment.velocity", "1e4 m/s at"),
        ({"altitude": "held"}, "altitude", "'aided' or 'free'"),
        ({"at": []}, "at", "1 to 16"),
        ({"at": [f"{n} s" for n in range(1, 18)]}, "at", "17 times, expected 1 to 16"),
        ({"at": "60 s"}, "at", r"brackets, such as 'at: \[60 s\]'"),
        ({"at": 60}, "at", r"brackets, such as 'at: \[60\]'"),
        ({"at": {"one": "60 s"}}, "at", "in brackets, such as .x, y. of two items$"),
        ({"at": ["5 s", "5 s"]}, "at[1]", "that rise"),
        ({"at": ["5 s", "61 s"]}, "at[1]", "ends at 60 s"),
        ({"wind": "5 m/s"}, "wind", "unknown key"),
    ],
)
def test_what_is_wrong_with_a_mission_is_said_at_its_key(keys, where, what):
    """Each key alone, with what is allowed and what to do."""
    assert_refused(issues(**keys), (where, what))


@pytest.fixture
def flown(tmp_path):
    """Return a function that reads a mission of the recorded flight, with more keys."""
    shutil.copy(ROOT / "tests" / "data" / "flight.csv", tmp_path)

    def of(name="flight.csv", **keys):
        path = tmp_path / "m.yaml"
        part = {"trajectory": name, **keys}
        path.write_text(json.dumps({"mission": part}), encoding="utf-8")
        return load_mission(path)

    return of


def test_a_trajectory_stands_in_place_of_segments(flown, tmp_path):
    """It is found beside the mission, and named with its hash."""
    one = flown(at=["1 min", "2 min"], altitude="aided", alignment="perfect")
    assert_allclose(one.route.duration, 120.0, rtol=1e-15)
    assert_allclose(one.route.height[-1], 660.0, rtol=1e-12)
    assert one.at == (60.0, 120.0)
    assert one.assumptions == ()
    data = (tmp_path / "flight.csv").read_bytes()
    assert one.trajectory.file == "flight.csv"
    assert one.trajectory.sha256 == hashlib.sha256(data).hexdigest()
    assert mission().trajectory is None
    said = " ".join(flown().assumptions)
    assert "10 s, 60 s, 120 s assumed" in said
    assert "height" not in said


def test_a_recorded_flight_is_flown_as_its_segments(flown):
    """Errors of gyros and accelerometers grow alike, to what a row a second shows."""
    segments = [
        {"straight": "20 s", "speed": "70 m/s", "heading": "80 deg"},
        {"turn": "180 deg", "rate": "3 deg/s"},
        {"climb": "40 s", "rate": "4 m/s"},
    ]
    one, other = flown(), mission(segments, height="500 m")
    assert one.at == other.at
    grown = [
        Growth(
            first=each.route.first,
            alignment=0.0,
            steps=each.route.steps(each.at),
            aided=True,
        ).of_constants(lambda _: np.eye(6))
        for each in (one, other)
    ]
    assert_allclose(grown[0], grown[1], rtol=0, atol=5e-4 * np.abs(grown[1]).max())


@pytest.mark.parametrize(
    ("keys", "where", "what"),
    [
        ({"name": "."}, "trajectory", "is no file; expected a CSV file"),
        ({"segments": "60 s"}, "segments", "in brackets, each item a mapping of keys$"),
        ({"at": ["121 s"]}, "at[0]", "ends at 120 s"),
        (
            {"alignment": "self", "alignment_time": "60 s"},
            "alignment",
            "begins at 70.* m/s",
        ),
        *(
            ({key: value}, key, "stands beside a trajectory")
            for key, value in (
                ("latitude", "45 deg"),
                ("height", "0 m"),
                ("speed", "0 m/s"),
                ("heading", "0 deg"),
                ("segments", [STAND]),
            )
        ),
    ],
)
def test_what_does_not_fit_a_trajectory_is_refused(flown, keys, where, what):
    """What it says already, and what it ends or moves too early for."""
    with pytest.raises(SpecError) as caught:
        flown(**keys)
    found = [(issue.field, issue.message) for issue in caught.value.issues]
    assert_refused(found, (where, what))


GNSS = {"position": "2.5 m", "rate": "1 Hz"}
SEEN = {**STAND, "aiding": "gnss"}


@pytest.mark.parametrize(
    ("keys", "where", "what"),
    [
        ({"segments": [SEEN]}, "segments[0].aiding", "mission.aiding does not have"),
        ({"aiding": {"gnss": GNSS}}, "aiding.gnss", "used nowhere"),
        (
            {"segments": [{"segments": [SEEN], "aiding": ["gnss"]}]},
            "segments[0].segments[0].aiding",
            "in a group that says it",
        ),
        (
            {"aiding": {"gnss": {"rate": "1 Hz"}}, "segments": [SEEN]},
            "aiding.gnss",
            "neither position nor velocity",
        ),
        (
            {"aiding": {"gnss": {**GNSS, "rate": "0 Hz"}}, "segments": [SEEN]},
            "aiding.gnss.rate",
            "positive",
        ),
        (
            {"aiding": {"gnss": {**GNSS, "position": "-1 m"}}, "segments": [SEEN]},
            "aiding.gnss.position",
            "positive",
        ),
        (
            {"aiding": {"gnss": {**GNSS, "position": "1 deg"}}, "segments": [SEEN]},
            "aiding.gnss.position",
            "length",
        ),
        (
            {"aiding": {"gnss": {**GNSS, "rate": "1e4 Hz"}}, "segments": [SEEN]},
            "aiding",
            "600000 epochs, expected 100000",
        ),
        (
            {
                "aiding": {"gnss": {**GNSS, "during": [["0 s", "9 s"]]}},
                "segments": [SEEN],
            },
            "aiding.gnss.during",
            "of a trajectory",
        ),
        (
            {
                "aiding": {"zero_velocity": {"value": "1 cm/s", "rate": "1 Hz"}},
                "segments": [{**FAST, "aiding": "zero_velocity"}],
            },
            "segments[0].aiding",
            "the vehicle moves",
        ),
        ({"aiding": {}}, "aiding", "names nothing that is measured"),
        ({"aiding": {}, "filter": "optimal"}, "aiding", "or remove it"),
        (
            {"aiding": {"gnss": {**GNSS, "rate": "0.01 Hz"}}, "segments": [SEEN]},
            "aiding.gnss.rate",
            "no multiple of that period",
        ),
        ({"filter": "optimal"}, "filter", "with aiding, which is not there"),
        (
            {
                "filter": {"estimates": ["gyro.biases"]},
                "aiding": {"gnss": GNSS},
                "segments": [SEEN],
            },
            "filter.estimates[0]",
            "gyro.bias",
        ),
        (
            {
                "filter": {"believes": {"gyro.angle_walk": "1 deg/h"}},
                "aiding": {"gnss": GNSS},
                "segments": [SEEN],
            },
            "filter.believes.gyro.angle_walk",
            "no specification",
        ),
        (
            {
                "filter": {"believes": {"gyro.angle_random_walk": "1 m"}},
                "aiding": {"gnss": GNSS},
                "segments": [SEEN],
            },
            "filter.believes.gyro.angle_random_walk",
            "angle random walk",
        ),
        (
            {"alignment": {"level": "1 deg"}, "alignment_time": "300 s"},
            "alignment_time",
            "'alignment: self'",
        ),
    ],
)
def test_what_is_wrong_with_aids_is_said_at_its_key(keys, where, what):
    """Aids, their sizes and times, the filter, the alignment: with place and remedy."""
    found = issues(**keys)
    assert_refused(found, (where, what))


def test_what_a_mission_says_of_its_aids():
    """Sizes in SI, of axes that differ, of a CEP; epochs of a group of segments."""
    position = {"value": "2.5 m", "axes": {"down": "5 m"}, "meaning": "CEP"}
    one = mission(
        [{"segments": [STAND, STAND], "repeat": 2, "aiding": "gnss"}, STAND],
        aiding={"gnss": {"position": position, "rate": "1 Hz"}},
        alignment={"position": "10 m", "heading": "5 deg"},
    )
    (aid,) = one.aiding
    # Half of all errors of a circular normal law are within 1.17741 sigma.
    assert_allclose(aid.u, [2.5 / 1.17741, 2.5 / 1.17741, 5.0], rtol=1e-6)
    assert (aid.name, aid.rate, aid.spans) == ("gnss_position", 1.0, ((0.0, 240.0),))
    expected = [10.0] * 3 + [0.0] * 5 + [radians(5.0)]
    assert_allclose(one.start, expected, rtol=1e-12)


def test_zero_velocity_where_a_trajectory_moves_is_refused(flown):
    """With the speed that it has then."""
    aid = {"value": "1 cm/s", "rate": "1 Hz", "during": [["1 s", "9 s"]]}
    with pytest.raises(SpecError) as caught:
        flown(aiding={"zero_velocity": aid})
    found = [(issue.field, issue.message) for issue in caught.value.issues]
    assert_refused(found, ("aiding.zero_velocity.during", "stands"))


@pytest.mark.parametrize(
    ("during", "place", "what"),
    [
        ([["9 s", "1 s"]], "[0]", "after its begin"),
        ([["1 s", "9 s"], ["5 s", "20 s"]], "[1]", "one after the other"),
        ([["1 s", "9 h"]], "[0]", "the mission ends at"),
        ([["1 s", "9 s"], ["20 s"]], "[1]", "item 2 is missing"),
        (None, "", "says not when"),
    ],
)
def test_times_of_an_aid_beside_a_trajectory(flown, during, place, what):
    """They rise, do not overlap, and lie within it."""
    aid = {**GNSS, **({"during": during} if during else {})}
    with pytest.raises(SpecError) as caught:
        flown(aiding={"gnss": aid})
    found = [(issue.field, issue.message) for issue in caught.value.issues]
    where = f"aiding.gnss.during{place}" if during else "aiding.gnss"
    assert_refused(found, (where, what))


def test_a_trajectory_that_is_not_there_is_said_with_its_place(flown, tmp_path):
    """Where it was looked for: beside the mission, not in the folder of the call."""
    with pytest.raises(SpecError) as caught:
        flown("none.csv")
    (issue,) = caught.value.issues
    assert issue.field == "mission.trajectory"
    assert f"{str(tmp_path / 'none.csv')!r} does not exist" in issue.message


def test_what_is_wrong_in_a_trajectory_is_said_of_its_file(flown, tmp_path):
    """With its own lines."""
    (tmp_path / "bad.csv").write_text("time [s]\n" + "0\n" * 5, encoding="utf-8")
    with pytest.raises(SpecError, match=r"bad.csv:1:1: the header has no latitude"):
        flown("bad.csv")


def test_all_that_is_wrong_is_said_at_once():
    """Of several keys and several segments."""
    assert_refused(
        issues([STAND, FAST, {"stand": "1 s", "repeat": 3}]),
        ("segments[1].speed", "accelerate first"),
        ("segments[1].heading", "turn first"),
        ("segments[2].stand", "accelerate to 0 m/s"),
    )
    assert_refused(
        issues(latitude="91 deg", height="1e6 m", alignment="self"),
        ("latitude", "89.9"),
        ("height", "100 km"),
        ("alignment", "alignment_time"),
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_shipped_missions_are_read_by_name(path):
    """Each says all there is to say, so that nothing of it is assumed."""
    assert validate(path).kind == "mission"
    one = load_mission(path.stem)
    assert one.origin.file == path.name
    assert one.at[-1] == one.route.duration
    assert not [text for text in one.assumptions if "not given" in text]


def test_a_mission_is_one_by_its_key(tmp_path):
    """Files of other kinds are refused where a mission is wanted, in words."""
    path = put(tmp_path / "m.yaml", json.dumps({"latitude": "45 deg"}))
    with pytest.raises(SpecError, match="procedure file, expected a mission file"):
        load_mission(path)
    with pytest.raises(SpecError, match="bench"):
        load_mission("bensh")


@pytest.mark.parametrize("where", [load_mission, validate])
@pytest.mark.parametrize(
    "more",
    [
        {"segments": [STAND]},
        {"trajectory": "flight.csv"},
        {"altitude": "free"},
        {"alignment": "self"},
    ],
)
def test_a_mission_without_its_wrapper_is_one(where, more):
    """Each key is said to stand under `mission`; a latitude makes it no procedure."""
    with pytest.raises(SpecError) as caught:
        where({"latitude": "45 deg", **more})
    said = [issue for issue in caught.value.issues if issue.field]
    assert {issue.field for issue in said} == {"latitude", *more}
    assert all("; it stands under 'mission'" in issue.message for issue in said)


def test_a_procedure_with_a_key_of_missions_is_one():
    """What is of procedures alone decides."""
    with pytest.raises(SpecError, match="procedure file, expected a mission"):
        load_mission({"altitude": "100 m", "gyro": {"rate": "10 deg/s"}})


CURVE = {"turn": "90 deg", "rate": "3 deg/s"}
LEANING = {**CURVE, "bank": "coordinated", "roll_rate": "20 deg/s"}


@pytest.mark.parametrize(
    ("speed", "rate", "bank"),
    [(15.0, 5.0, 7.60293), (20.0, 9.0, 17.7630), (250.0, 3.0, 53.1604)],
)
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_coordinated_bank_pulls_nothing_aside(speed, rate, bank, sense, monkeypatch):
    """By tan phi = v w/g, right side down in a right turn."""
    monkeypatch.setattr("budget.inputs.mission.normal_gravity", lambda *_: 9.80665)
    turn = {**LEANING, "turn": f"{360.0 * sense} deg", "rate": f"{rate} deg/s"}
    (leg,) = mission([turn], speed=f"{speed} m/s").route.legs
    assert_allclose(leg.bank, sense * radians(bank), rtol=4e-6)
    assert_allclose(leg.roll_rate, sense * radians(20.0), rtol=1e-12)
    assert_allclose(leg.rolling, bank / 20.0, rtol=4e-6)


@pytest.mark.parametrize(
    ("segment", "where", "what"),
    [
        ({**CURVE, "bank": "coordinated"}, "bank", "'roll_rate: 20 deg/s' there"),
        (
            {**CURVE, "roll_rate": "9 deg/s"},
            "roll_rate",
            "'bank: coordinated', which is not",
        ),
        ({**LEANING, "bank": "level"}, "roll_rate", "remove this"),
        ({**LEANING, "bank": "20 deg"}, "bank", "'coordinated'"),
        ({**LEANING, "roll_rate": "0 deg/s"}, "roll_rate", "positive"),
        ({**LEANING, "roll_rate": "9 m/s"}, "roll_rate", "angular rate"),
        ({**LEANING, "roll_rate": "1e-9 deg/s"}, "roll_rate", "roll quicker"),
        (
            {**LEANING, "roll_rate": "3 deg/s"},
            "roll_rate",
            "takes 17.7.* s to a bank of 53.1.* deg and as long back.* takes 30 s",
        ),
        ({**STAND, "bank": "coordinated"}, "bank", "is of turn, and this is stand"),
    ],
)
def test_a_bank_that_cannot_be_is_refused(segment, where, what):
    """At its key, and what follows is read on."""
    found = issues([segment], speed=None if "stand" in segment else "250 m/s")
    assert_refused(found, (f"segments[0].{where}", what))


def test_a_bank_of_what_turns_on_the_spot_is_level():
    """Without speed nothing pulls aside; it does not roll."""
    (leg,) = mission([LEANING]).route.legs
    assert (leg.bank, leg.roll_rate, leg.pieces) == (0.0, 0.0, (leg,))


def test_many_short_banked_turns_are_counted():
    """Rolls are steps, too."""
    turn = {**LEANING, "turn": "3 deg", "roll_rate": "300 deg/s"}
    found = issues([{**turn, "repeat": MOST_SEGMENTS}], speed="20 m/s")
    assert_refused(found, ("segments", f"expected {MOST_STEPS}; turn less"))


def test_what_stays_level_is_said_of_what_does_not_bank():
    """Of all, of the other turns and climbs, or of nothing."""

    def said(*segments):
        given = mission(segments, speed="50 m/s").assumptions
        return [text for text in given if "stays level" in text]

    assert not said(LEANING)
    (both,) = said(LEANING, CURVE)
    assert "but in turns that say bank" in both
    (climbs,) = said(LEANING, {"climb": "9 s", "rate": "1 m/s"})
    assert climbs == both
    (level,) = said(CURVE)
    assert "without bank in turns" in level
