"""What a test and a mission ask of each axis, against closed forms; who saturates."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import budget
from budget.calibration.problem import calibration_problem
from budget.calibration.saturation import (
    ROUNDED,
    beyond,
    needed_range,
    peaks_of_mission,
    peaks_of_test,
    saturations,
)
from budget.calibration.schemes import refusals, schedule_of
from budget.earth import ROTATION_RATE, meridian_radius, normal_gravity
from budget.errors import CallError
from budget.inputs import load_device, load_mission, load_procedure, uncalibrated
from budget.inputs.records import Mission
from budget.navigation.route import Track
from budget.units import DEGREE, STANDARD_GRAVITY

RATE = 3.0 * DEGREE  # of a turn [rad/s]
SPEED = 100.0  # [m/s]


def device(**ranges):
    """Return a unit with these ranges, by sensor."""
    lines = {"gyro": "1 deg/h", "accelerometer": "1 mg"}
    sensors = {
        kind: {"errors": {"bias_repeatability": value}} for kind, value in lines.items()
    }
    return load_device({"name": "unit", "range": ranges, **sensors})


def mission(*segments, **start):
    """Return a mission at the equator."""
    part = {"latitude": "0 deg", **start, "segments": list(segments)}
    return load_mission({"name": "way", "mission": part})


def sizes(peaks, sensor):
    """Return the largest inputs of a triad, x, y, z [SI]."""
    return [one.size for one in peaks if one.sensor == sensor]


def peaks(sensor, procedure):
    """Return what a procedure asks of a triad."""
    return peaks_of_test(sensor, schedule_of(sensor, procedure), procedure.place)


def test_the_papers_turns_take_each_gyro_to_its_rate_and_the_earth_s():
    """About east, north and up at table zero: 20 deg/s, with W (0, cos L, sin L)."""
    procedure = load_procedure()
    L = procedure.latitude
    expected = 20.0 * DEGREE + ROTATION_RATE * np.array([0.0, np.cos(L), np.sin(L)])

    assert_allclose(sizes(peaks("gyro", procedure), "gyro"), expected, rtol=1e-12)
    assert [one.where for one in peaks("gyro", procedure)] == [
        f"turn {axis}+" for axis in "xyz"
    ]


def test_faces_take_each_accelerometer_to_gravity():
    """Up and down, the gravity of the place."""
    procedure = load_procedure()

    found = sizes(peaks("accelerometer", procedure), "accelerometer")

    assert_allclose(found, [procedure.gravity] * 3, rtol=1e-12)


def procedure_of(*windows):
    """Return a procedure of these windows, with a latitude and a gravity."""
    return load_procedure(
        {
            "name": "windows",
            "latitude": "30 deg",
            "gravity": "9.8 m/s^2",
            "estimator": "least_squares",
            "estimate": {"gyro": ["bias"], "accelerometer": ["bias"]},
            "windows": list(windows),
        }
    )


def test_a_slanted_axis_feels_its_part_of_gravity():
    """Rolled by 30 deg: sin 30 along y, cos 30 along z, none along x."""
    procedure = procedure_of({"inner": "30 deg", "dwell": "60 s"})

    found = sizes(peaks("accelerometer", procedure), "accelerometer")

    assert_allclose(found[1:], [9.8 * 0.5, 9.8 * np.cos(np.pi / 6.0)], rtol=1e-12)
    assert_allclose(found[0], 0.0, atol=1e-12)


def test_a_turn_takes_axes_through_gravity_that_begin_level():
    """A turn about the level x axis: y begins with none and meets all of it."""
    procedure = procedure_of(
        {"outer": "0 deg", "turn": "inner", "turns": 1, "rate": "10 deg/s"}
    )

    found = sizes(peaks("accelerometer", procedure), "accelerometer")

    assert_allclose(found[1:], [9.8, 9.8], rtol=1e-12)
    assert_allclose(found[0], 0.0, atol=1e-12)


def test_standing_is_gravity_and_the_earth_rate():
    """At the equator, looking north: the earth turns about y, nothing about z."""
    found = peaks_of_mission(mission({"stand": "60 s"}))

    assert_allclose(sizes(found, "gyro"), [0.0, ROTATION_RATE, 0.0], atol=1e-18)
    g = normal_gravity(0.0, 0.0)
    assert_allclose(sizes(found, "accelerometer"), [0.0, 0.0, g], atol=1e-12)


def test_straight_on_is_gravity_less_what_the_earth_s_curve_takes():
    """North from the equator: g - v^2/R up, transport v/R about the right axis."""
    found = peaks_of_mission(
        mission({"straight": "1 s", "speed": f"{SPEED} m/s", "heading": "0 deg"})
    )
    R = meridian_radius(0.0)

    assert_allclose(sizes(found, "gyro")[0], SPEED / R, rtol=1e-6)
    expected = normal_gravity(0.0, 0.0) - SPEED**2 / R
    assert_allclose(sizes(found, "accelerometer")[2], expected, rtol=1e-6)


def test_a_level_turn_is_speed_times_rate_to_the_side():
    """Speed times rate beside the Coriolis force, nothing level at the equator.

    Its 2 W v sin L is 0 where the vertical earth rate is; the gyro z turns with w.
    """
    found = peaks_of_mission(
        mission(
            {"straight": "1 s", "speed": f"{SPEED} m/s", "heading": "90 deg"},
            {"turn": "180 deg", "rate": "3 deg/s"},
        )
    )
    (side,) = (one for one in found if (one.sensor[0], one.axis) == ("a", "x"))
    (about,) = (one for one in found if (one.sensor[0], one.axis) == ("g", "z"))

    assert_allclose(side.size, SPEED * RATE, rtol=1e-4)
    assert_allclose(about.size, RATE, rtol=1e-4)
    assert (side.where, about.where) == ("segment 2 (turn 180 deg)",) * 2
    assert 1.0 < about.time < 61.0


def test_speeding_up_is_its_acceleration_forward():
    """From 0 to 100 m/s in 10 s: 10 m/s^2 along y, in the segment that does it."""
    found = peaks_of_mission(
        mission({"stand": "20 s"}, {"accelerate": "10 s", "to": "100 m/s"})
    )
    (forward,) = (one for one in found if (one.sensor[0], one.axis) == ("a", "y"))

    assert_allclose(forward.size, 10.0, rtol=1e-3)
    assert forward.where == "segment 2 (accelerate 10 s)"


def test_a_coordinated_bank_pulls_up_and_not_aside():
    """At 100 m/s and 6 deg/s g/cos(phi) along z, next to nothing along x."""
    turn = {"turn": "-180 deg", "rate": "6 deg/s"}
    banked = {**turn, "bank": "coordinated", "roll_rate": "20 deg/s"}
    start = {"straight": "9 s", "speed": "100 m/s", "heading": "0 deg"}
    level, leans = (
        {(one.sensor, one.axis): one for one in peaks_of_mission(mission(start, own))}
        for own in (turn, banked)
    )
    side = 100.0 * np.radians(6.0)

    assert_allclose(level["accelerometer", "x"].size, side, rtol=5e-3)
    up = leans["accelerometer", "z"]
    assert_allclose(up.size, np.hypot(side, 9.8), rtol=5e-3)
    assert up.where == "segment 2 (turn -180 deg)"
    roll = leans["gyro", "y"]
    assert_allclose(roll.size, np.radians(20.0), rtol=5e-3)
    assert roll.where == "segment 2 (turn -180 deg)"


TURNS = mission(
    {"straight": "10 s", "speed": "50 m/s", "heading": "0 deg"},
    {"turn": "90 deg", "rate": "30 deg/s"},
    {"straight": "10 s"},
    {"turn": "-360 deg", "rate": "60 deg/s", "repeat": 2},
)


def test_a_saturation_says_which_axis_where_and_by_how_much():
    """The gyro z in the first of the quicker turns, the accelerometer x there too."""
    unit = device(gyro="40 deg/s", accelerometer="5 g")

    found = saturations(unit.sensors, TURNS)

    assert [(one.peak.sensor, one.peak.axis, one.peak.where) for one in found] == [
        ("gyro", "z", "segment 4 (turn -360 deg)"),
        ("accelerometer", "x", "segment 4 (turn -360 deg)"),
    ]
    assert found[0].device == "unit"
    assert_allclose(found[0].range, 40.0 * DEGREE, rtol=1e-14)
    assert_allclose(found[0].peak.size, 60.0 * DEGREE, rtol=1e-3)
    assert_allclose(found[1].peak.size, 50.0 * 60.0 * DEGREE, rtol=1e-2)
    for word in ("gyro z", "±40 deg/s", "60 deg/s", "segment 4"):
        assert word in found[0].said


def test_each_axis_has_a_range_of_its_own():
    """A low range of an axis that nothing turns about says nothing."""
    level = {"value": "5 deg/s", "z": "100 deg/s"}
    assert saturations(device(gyro=level).sensors, TURNS) == ()
    steep = {"value": "100 deg/s", "z": "5 deg/s"}
    (found,) = saturations(device(gyro=steep).sensors, TURNS)
    assert found.peak.axis == "z"


@pytest.mark.parametrize(
    ("size", "saturated"), [("60 deg/s", 0), ("59.8 deg/s", 0), ("59.6 deg/s", 1)]
)
def test_as_large_as_the_range_is_within(size, saturated):
    """The earth rate on top is within the digits of a range; 0.7 % is not."""
    assert ROUNDED < 1.0 - 59.6 / 60.0
    assert len(saturations(device(gyro=size).sensors, TURNS)) == saturated


def test_without_a_range_nothing_saturates_and_what_is_needed_is_said():
    """The largest of each triad that does not say how far it reads."""
    assert saturations(device().sensors, TURNS) == ()
    gyro, force = needed_range(device().sensors, TURNS)
    assert_allclose(gyro.size, 60.0 * DEGREE, rtol=1e-3)
    assert_allclose(force.size, 50.0 * 60.0 * DEGREE, rtol=1e-2)
    assert (gyro.shown, gyro.axis, force.axis) == ("60 deg/s", "z", "x")
    (left,) = needed_range(device(gyro="100 deg/s").sensors, TURNS)
    assert left.sensor == "accelerometer"


def test_peaks_of_a_mission_are_found_once():
    """A comparison asks for those of one mission with every device."""
    assert peaks_of_mission(TURNS) is peaks_of_mission(TURNS)


def rolling(amplitude, period, *, up_at_the_end=False):
    """Return a recorded flight north that rolls from side to side."""
    t = np.arange(0.0, 40.0 + 0.05, 0.1)
    roll = amplitude * np.sin(2.0 * np.pi * t / period)
    pitch = np.radians(90.0) * (t / t[-1]) ** 3 * up_at_the_end
    attitude = np.stack([roll, pitch, np.zeros_like(t)], axis=1)
    R = meridian_radius(0.0)
    track = Track(
        time=t,
        latitude=SPEED * t / R,
        longitude=np.zeros_like(t),
        height=np.zeros_like(t),
        attitude=attitude,
    )
    example = load_mission("bench")
    return Mission(
        name="roll",
        route=track,
        alignment=0.0,
        aided=True,
        at=(10.0,),
        assumptions=(),
        origin=example.origin,
    )


def test_a_recording_says_when():
    """A roll of A sin(2 pi t/T) turns with 2 pi A/T at its middle, about y."""
    found = peaks_of_mission(rolling(0.5, 20.0))
    (about,) = (one for one in found if (one.sensor[0], one.axis) == ("g", "y"))

    assert_allclose(about.size, 2.0 * np.pi * 0.5 / 20.0, rtol=2e-2)
    assert about.where.endswith("after the start")
    # A heel of 0.5 rad puts g sin(0.5) on the wing.
    (side,) = (one for one in found if (one.sensor[0], one.axis) == ("a", "x"))
    assert_allclose(side.size, STANDARD_GRAVITY * np.sin(0.5), rtol=1e-2)


def test_a_vehicle_that_ends_straight_up_has_peaks():
    """It has no heading then, which nobody asks for; its rate is one all the same."""
    found = peaks_of_mission(rolling(0.0, 20.0, up_at_the_end=True))
    (about,) = (one for one in found if (one.sensor[0], one.axis) == ("g", "x"))

    # d/dt of 90 deg (t/40 s)^3 at its end.
    assert_allclose(about.size, 3.0 * np.pi / 2.0 / 40.0, rtol=3e-2)


def test_a_gyro_that_the_turns_are_beyond_is_refused_for_the_test():
    """Device, sensor, range, what the test asks, and where."""
    unit = device(gyro="10 deg/s", accelerometer="5 g")

    (text,) = refusals(unit.sensors, load_procedure())
    for word in ("unit", "gyro", "±10 deg/s", "20 deg/s", "turn x+", "Zhao 2019"):
        assert word in text
    with pytest.raises(CallError, match="cannot be calibrated"):
        calibration_problem(unit.sensors, load_procedure())


def test_an_accelerometer_that_gravity_is_beyond_is_refused_for_the_test():
    """0.5 g at a face, whoever tests it by itself or beside a gyro."""
    unit = device(gyro="100 deg/s", accelerometer="0.5 g")
    for sensors in (unit.sensors, unit.sensors[1:]):
        (text,) = refusals(sensors, load_procedure())
        for word in ("accelerometer", "±0.5 g", "0.999 g", "up"):
            assert word in text


def test_a_test_as_quick_as_the_range_is_no_test_beyond_it():
    """20 deg/s of 20 deg/s, and 1 g of 1 g, at any gravity of the earth."""
    unit = device(gyro="20 deg/s", accelerometer="1 g")
    assert refusals(unit.sensors, load_procedure()) == ()
    pole = load_procedure({"name": "pole", "latitude": "89 deg", "sample_rate": "1 Hz"})
    assert pole.gravity > STANDARD_GRAVITY
    assert refusals(unit.sensors, pole) == ()


@pytest.mark.parametrize("word", ["none", "factory"])
def test_without_a_test_nothing_is_beyond(word):
    """A unit that nobody calibrates is turned by nobody."""
    unit = device(gyro="10 deg/s", accelerometer="0.5 g")
    assert refusals(unit.sensors, uncalibrated(word)) == ()
    calibration_problem(
        unit.sensors, uncalibrated(word), reference="next_turn_on", every=True
    )


def test_windows_of_the_other_triad_alone_do_not_count():
    """A gyro is read in its own windows: a quick turn of accelerometers is no test."""
    quick = {"face": "z up", "turn": "vertical", "turns": 1, "rate": "90 deg/s"}
    dwell = {"face": "z up", "dwell": "60 s"}
    shy = device(gyro="50 deg/s")
    alone = procedure_of(dwell, {**quick, "use": "accelerometer"})
    assert refusals(shy.sensors, alone) == ()
    assert len(refusals(shy.sensors, procedure_of(dwell, quick))) == 1


def test_the_mission_of_an_analysis_warns_of_what_saturates():
    """With the sentence of the saturation; not where the range is wide enough."""

    def warnings(**ranges):
        found = budget.analyze(
            device(**ranges),
            mission=TURNS,
            procedure=uncalibrated("factory"),
            validate=False,
        )
        return [text for text in found.warnings if "saturates" in text]

    narrow = device(gyro="40 deg/s")
    assert warnings(gyro="40 deg/s") == [
        one.said for one in saturations(narrow.sensors, TURNS)
    ]
    assert warnings(gyro="100 deg/s", accelerometer="6 g") == []
    # Control: without a range nobody can say.
    assert warnings() == []


def test_beyond_is_of_the_own_triad():
    """Peaks of gyros say nothing of accelerometers."""
    gyro, force = device(gyro="1 deg/s", accelerometer="100 g").sensors
    found = peaks_of_mission(TURNS)
    assert beyond(gyro, found).peak.sensor == "gyro"
    assert beyond(force, found) is None
