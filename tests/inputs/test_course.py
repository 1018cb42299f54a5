"""What a mission file says of a temperature and a vibration that are known."""

from __future__ import annotations

import re

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose
from places import ROOT

from budget.errors import CallError, SpecError
from budget.inputs import load_mission, load_requirement, uncalibrated
from budget.inputs.course import MOST_POINTS
from budget.inputs.schema import json_schema
from budget.inputs.use import in_use
from budget.units import STANDARD_GRAVITY

FIRST = {"straight": "300 s", "speed": "15 m/s"}
WAY = [FIRST, {"straight": "300 s"}]
TWO = [["0 s", "20 degC"], ["600 s", "45 degC"]]
WARM_UP = {"by": "20 degC", "time": "300 s"}
SHAKEN = {"value": "2 g", "during": [["0 s", "60 s"], ["90 s", "120 s"]]}
T, V = "environment.temperature", "environment.vibration"


def file_of(environment=None, segments=WAY, **more):
    """Return a mission file as data."""
    part = {"latitude": "47 deg", "segments": segments, **more}
    given = {} if environment is None else {"environment": environment}
    return {"name": "way", **given, "mission": part}


def on_trajectory(vibration):
    """Return one along the recorded flight of the tests, 120 s."""
    flight = str(ROOT / "tests" / "data" / "flight.csv")
    part = {"trajectory": flight, "at": ["120 s"]}
    return {"environment": {"vibration": vibration}, "mission": part}


def course(said, name):
    """Return the line of a use that a file states."""
    return next(line for line in load_mission(said).use if line.name == name)


def profile(*points, reference="25 degC"):
    """Return an environment with a profile."""
    return {"temperature": {"reference": reference, "profile": [*points]}}


def test_a_profile_is_linear_and_held_beyond_its_ends():
    """T - T0 at and between its points; 0 where it does not change."""
    said = file_of(profile(["100 s", "20 degC"], ["500 s", "45 degC"]))
    line = course(said, "temperature.mission")
    t = np.array([0.0, 100.0, 200.0, 500.0, 600.0])
    assert_allclose(line.course.at(t), [-5.0, -5.0, 1.25, 20.0, 20.0], rtol=1e-12)
    slope = line.course.slope(np.array([50.0, 200.0, 550.0]))
    assert_allclose(slope, [0.0, 0.0625, 0.0], rtol=1e-12)
    assert line.printed == "-5 degC to 20 degC"
    assert_allclose(line.u, 20.0, rtol=1e-12)
    kept = "before its first point as there, after its last as there"
    assert any(kept in text for text in load_mission(said).assumptions)
    whole = load_mission(file_of(profile(*TWO)))
    assert not any(kept in text for text in whole.assumptions)


def test_a_warm_up_begins_below_and_fades():
    """-20 e^(-t/300 s), and its slope by differences."""
    said = file_of({"temperature": {"warm_up": WARM_UP}})
    line = course(said, "temperature.mission")
    t = np.array([0.0, 300.0, 600.0])
    assert_allclose(line.course.at(t), -20.0 * np.exp(-t / 300.0), rtol=1e-12)
    h = 1e-3
    rise = (line.course.at(t + h) - line.course.at(t - h)) / (2.0 * h)
    assert_allclose(line.course.slope(t), rise, rtol=1e-8)
    assert line.printed == "-20 degC to 0 degC"
    # None of it is no course: the temperature of the test.
    none = file_of({"temperature": {"warm_up": {**WARM_UP, "by": "0 degC"}}})
    assert course(none, "temperature.mission").course is None


@pytest.mark.parametrize(
    ("said", "sizes"),
    [
        (
            file_of({"vibration": "1 g"}, [{**FIRST, "vibration": "2 g"}, WAY[1]]),
            (2, 1),
        ),
        (
            file_of({"vibration": "1 g"}, [FIRST, {**WAY[1], "vibration": "2 g"}]),
            (1, 2),
        ),
        (
            file_of(
                {"vibration": "1 g"},
                [
                    {"segments": [{**FIRST, "straight": "300 s"}], "vibration": "3 g"},
                    WAY[1],
                ],
            ),
            (3, 1),
        ),
    ],
)
def test_a_segment_or_a_group_has_a_vibration_of_its_own(said, sizes):
    """Elsewhere it is that of the environment."""
    line = course(said, "vibration.mission")
    found = line.course.at(np.array([1.0, 299.0, 301.0, 599.0])) / STANDARD_GRAVITY
    assert_allclose(found, np.repeat(sizes, 2), rtol=1e-12)
    assert_allclose(line.u / STANDARD_GRAVITY, max(sizes), rtol=1e-12)


def test_beside_a_trajectory_a_vibration_says_when():
    """In spans as aids do; one value without them is of the rest."""
    line = course(on_trajectory([SHAKEN, {"value": "1 g"}]), "vibration.mission")
    t = np.array([1.0, 59.0, 61.0, 89.0, 91.0, 119.0])
    found = line.course.at(t) / STANDARD_GRAVITY
    assert_allclose(found, [2, 2, 1, 1, 2, 2], rtol=1e-12)
    alone = course(on_trajectory([{"value": "1 g"}]), "vibration.mission")
    assert alone.course is None


REFUSED = [
    (file_of(profile(TWO[0], ["700 s", "9 degC"])), f"{T}.profile[1]", "within it"),
    (file_of(profile(TWO[0], TWO[0])), f"{T}.profile[1]", "times that rise"),
    (file_of(profile(TWO[1], TWO[0])), f"{T}.profile[1]", "times that rise"),
    (file_of(profile(TWO[0])), f"{T}.profile", "fewer points than two"),
    (file_of(profile()), f"{T}.profile", "fewer points than two"),
    (
        file_of(profile(*[[f"{k / 10} s", "9 degC"] for k in range(MOST_POINTS + 1)])),
        f"{T}.profile",
        f"{MOST_POINTS}",
    ),
    (file_of(profile(TWO[0], ["9 s", "318 K"])), f"{T}.profile[1]", "zeros differ"),
    (file_of(profile(["-1 s", "9 degC"], TWO[1])), f"{T}.profile[0][0]", "negative"),
    (file_of(profile(TWO[0], ["9 s", "inf degC"])), f"{T}.profile[1][1]", "no number"),
    (file_of(profile(TWO[0], ["9 s", "9 deg"])), f"{T}.profile[1][1]", "an angle"),
    (file_of({"temperature": {"profile": TWO}}), f"{T}.profile", "without reference"),
    (
        file_of({"temperature": {"reference": "9 degC"}}),
        f"{T}.reference",
        "without profile",
    ),
    *(
        (
            file_of({"temperature": {"warm_up": {**WARM_UP, **wrong}}}),
            f"{T}.warm_up.{next(iter(wrong))}",
            what,
        )
        for wrong, what in (
            ({"time": "0 s"}, "positive"),
            ({"time": "-9 s"}, "positive"),
            ({"time": "9 m"}, "a length"),
            ({"by": "nan degC"}, "no number"),
            ({"by": "9 g"}, "an acceleration"),
        )
    ),
    (
        file_of({"temperature": {"warm_up": {"by": "9 degC"}}}),
        f"{T}.warm_up",
        "'time' is missing",
    ),
    (
        file_of({"temperature": {"warm_up": WARM_UP, "profile": TWO}}),
        f"{T}.profile",
        "beside warm_up",
    ),
    (file_of({"vibration": [SHAKEN, {"value": "1 g"}]}), V, "of a trajectory"),
    (on_trajectory([SHAKEN]), V, "one value without during"),
    (on_trajectory([{"value": "1 g"}] * 2), V, "one value without during"),
    (
        on_trajectory(
            [SHAKEN, {"value": "3 g", "during": [["50 s", "70 s"]]}, {"value": "1 g"}]
        ),
        V,
        "one after the other",
    ),
    (
        on_trajectory(
            [{"value": "3 g", "during": [["50 s", "170 s"]]}, {"value": "1 g"}]
        ),
        V,
        "within the mission",
    ),
    (
        file_of(None, [{**FIRST, "vibration": "2 g"}]),
        "mission.segments[0].vibration",
        "'environment: {vibration: 0 g}'",
    ),
    (
        file_of({"vibration": "1 g"}, [{**FIRST, "vibration": "-2 g"}]),
        "mission.segments[0].vibration",
        "negative",
    ),
    (
        file_of(
            {"vibration": "1 g"},
            [{"vibration": "2 g", "segments": [{**FIRST, "vibration": "3 g"}]}],
        ),
        "mission.segments[0].segments[0].vibration",
        "in a group",
    ),
]


@pytest.mark.parametrize(("said", "where", "what"), REFUSED)
def test_what_is_wrong_is_said_at_its_place(said, where, what):
    """Each with what is allowed; nothing else is said of it."""
    with pytest.raises(SpecError) as caught:
        load_mission(said)
    (issue,) = caught.value.issues
    assert issue.field == where
    assert re.search(what, issue.message), issue.message


def test_two_files_cannot_say_it_and_a_call_goes_before_them():
    """A size in a requirement is another one, even of the same largest."""
    way = load_mission(file_of({"temperature": {"warm_up": WARM_UP}}))
    limits = {"gyro": {"bias": "1 deg/h"}}
    said = {"name": "r", "environment": {"temperature": "20 degC"}, "limits": limits}
    with pytest.raises(CallError, match=r"20 degC in .* and -20 degC to 0 degC"):
        in_use(uncalibrated("factory"), load_requirement(said), way)
    asked = uncalibrated("factory", environment="temperature 5 degC")
    for procedure, has in ((uncalibrated("factory"), True), (asked, False)):
        lines = in_use(procedure, None, way).environment
        assert any(line.course is not None for line in lines) == has


def test_the_schema_knows_both():
    """What an editor checks; a course in a requirement is none."""
    check = Draft202012Validator(json_schema("mission")).is_valid
    assert check(file_of(profile(*TWO)))
    assert check(file_of({"temperature": {"warm_up": WARM_UP}, "vibration": "1 g"}))
    assert check(file_of({"temperature": "9 degC"}))
    assert check(on_trajectory([SHAKEN, {"value": "1 g"}]))
    assert not check(file_of({"temperature": {"warm_up": {"by": "9 degC"}}}))
    assert not check(file_of({"temperature": {"course": []}}))


def test_a_temperature_that_is_known_has_a_place_of_its_own():
    """A size has no sign; what is asked for instead is said with the refusal."""
    with pytest.raises(SpecError, match=r"without sign; one that is known goes under"):
        load_mission(file_of({"temperature": "-20 degC"}))
