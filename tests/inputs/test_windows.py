"""Windows of a procedure file: where the table stands, when, and what is refused."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError
from budget.inputs import load_procedure

FACES = {"x": 0, "y": 1, "z": 2}


@pytest.fixture
def procedure(tmp_path):
    """Return a function that reads windows, one a line, with keys after them."""

    def read(*windows, more=""):
        path = tmp_path / "mine.yaml"
        lines = "".join(f"  - {{{window}}}\n" for window in windows)
        head = "windows:\n" if lines else "windows: []\n"
        place = "" if "latitude" in more else "latitude: 34 deg\n"
        path.write_text(f"{head}{lines}{place}{more}")
        return load_procedure(path)

    return read


@pytest.mark.parametrize("axis", "xyz")
@pytest.mark.parametrize(("word", "sign"), [("up", 1), ("down", -1)])
@pytest.mark.parametrize("azimuth", [0, 90, 200])
def test_a_face_holds_its_axis_vertical(procedure, axis, word, sign, azimuth):
    """Gravity stands along the axis of the face, whatever the azimuth."""
    text = f"face: {axis} {word}, azimuth: {azimuth} deg, dwell: 60 s"
    (window,) = procedure(text).windows
    up = window.setting.to_body @ np.array([0.0, 0.0, 1.0])

    assert_allclose(up, sign * np.eye(3)[FACES[axis]], rtol=0, atol=1e-15)


def test_table_angles_are_those_of_the_three_axes(procedure):
    """Outer about up, middle about y, inner about x, each turned back in turn."""
    text = "outer: 30 deg, middle: 40 deg, inner: 50 deg, dwell: 60 s"
    (window,) = procedure(text).windows
    a, b, c = (radians(x) for x in (30.0, 40.0, 50.0))
    z = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    x = np.array([[1, 0, 0], [0, np.cos(c), -np.sin(c)], [0, np.sin(c), np.cos(c)]])

    assert_allclose(window.setting.to_body, (z @ y @ x).T, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("face", "axis"), [("x up", [1, 0, 0]), ("y down", [0, -1, 0]), ("z up", [0, 0, 1])]
)
def test_a_vertical_turn_is_felt_along_the_axis_that_is_up(procedure, face, axis):
    """Two turns back at 10 deg/s last 72 s and are felt against the vertical axis."""
    text = f"face: {face}, turn: vertical, turns: -2, rate: 10 deg/s"
    (window,) = procedure(text).windows

    assert_allclose(window.length, 72.0, rtol=1e-14)
    assert_allclose(window.rate, -radians(10.0) * np.array(axis), rtol=0, atol=1e-16)
    assert window.sense == -1


def test_windows_follow_each_other_on_one_clock(procedure):
    """Pauses part them, repeats come at once, a start of its own is kept."""
    found = procedure(
        "face: z up, dwell: 60 s, repeat: 2",
        "face: z down, dwell: 1 min, use: accelerometer, start: 500 s",
        "face: x up, turn: vertical, turns: 1, rate: 20 deg/s, use: gyro",
        more="pause: 10 s\nestimator: weighted\n",
    )

    assert_allclose(
        [w.start for w in found.windows], [0.0, 70.0, 500.0, 570.0], rtol=1e-14
    )
    assert [w.use for w in found.windows] == ["both", "both", "accelerometer", "gyro"]
    assert found.formulas == "weighted"


def test_a_line_may_stand_for_many_windows(procedure):
    """Every face, several azimuths, a turn and back, groups that are repeated."""
    short = procedure(
        "face: all, azimuths: [0 deg, 90 deg], dwell: 60 s",
        "repeat: 2, windows: [{face: z up, dwell: 9 s, start: 3000 s}, "
        "{face: x up, turn: vertical, turns: 2, rate: 20 deg/s, "
        "back: true, repeat: 2}]",
        more="pause: 10 s\n",
    ).windows
    faces = [
        f"face: {axis} {word}, azimuth: {azimuth} deg, dwell: 60 s"
        for axis in "zxy"
        for word in ("up", "down")
        for azimuth in (0, 90)
    ]
    turn = "face: x up, turn: vertical, turns: {}, rate: 20 deg/s"
    turns = [turn.format(2), turn.format(-2)] * 2
    again = "face: z up, dwell: 9 s"
    long = procedure(
        *faces,
        *(f"{again}, start: 3000 s", *turns, again, *turns),
        more="pause: 10 s\n",
    ).windows

    assert len(short) == 22
    assert short == long


def test_what_a_file_with_windows_leaves_open_is_said(procedure):
    """The estimator and the pause that were assumed; nothing of the paper's tests."""
    said = procedure("face: z up, dwell: 60 s", more="latitude: 48 deg\n").assumptions

    assert "estimator: not given, least_squares assumed" in said
    assert "pause: not given, 0 s assumed" in said
    assert not [text for text in said if text.startswith(("gyro.", "formulas"))]


@pytest.mark.parametrize(
    ("window", "words"),
    [
        ("dwell: 60 s", ("windows[0]", "face: z up", "outer: 0 deg")),
        ("face: z up", ("dwell", "60 s")),
        ("face: z up, outer: 1 deg, dwell: 60 s", ("outer", "face")),
        ("outer: 1 deg, azimuth: 1 deg, dwell: 60 s", ("azimuth", "face")),
        ("outer: 1, dwell: 60 s", ("outer", "without a unit", "deg")),
        ("face: up, dwell: 60 s", ("face", "z up")),
        ("face: z up, turn: vertical, rate: 9 deg/s", ("turns", "1 or -1")),
        (
            "face: z up, turn: vertical, turns: 0, rate: 9 deg/s",
            ("turns", "whole turn"),
        ),
        ("face: z up, turn: vertical, turns: 0.5, rate: 9 deg/s", ("turns", "0.5")),
        ("face: z up, turn: vertical, turns: 1", ("rate", "10 deg/s")),
        ("face: z up, dwell: 60 s, rate: 9 deg/s", ("rate", "turn: vertical")),
        (
            "face: z up, dwell: 60 s, turn: inner, turns: 1, rate: 9 deg/s",
            ("dwell", "rate"),
        ),
        ("face: z up, dwell: 1 ms", ("no sample", "100 Hz")),
        ("face: z up, dwell: 60 s, repeat: 10001", ("repeat", "10000")),
        ("face: z up, dwell: 60 s, use: gyros", ("use", "gyro")),
        ("face: z up, dwell: 60 s, back: true", ("back", "turn: vertical")),
        ("face: all, dwell: 60 s, azimuths: []", ("azimuths", "1 to 10000")),
        (
            "face: all, dwell: 60 s, azimuth: 0 deg, azimuths: [0 deg]",
            ("azimuth", "remove"),
        ),
        ("outer: 1 deg, azimuths: [1 deg], dwell: 60 s", ("azimuths", "face")),
        ("windows: []", ("windows[0].windows", "one at least")),
        (
            "face: z up, windows: [{face: z up, dwell: 60 s}]",
            ("windows[0].face", "in its lines"),
        ),
        (
            "windows: [{face: z up, dwell: 60 s, windows: []}]",
            ("windows[0].windows[0].windows", "unknown key"),
        ),
    ],
)
def test_what_makes_no_window_is_refused(procedure, window, words):
    """The key that is wrong and what is expected."""
    with pytest.raises(SpecError) as caught:
        procedure(window)
    (issue, *_) = caught.value.issues

    for word in words:
        assert word in str(issue)


@pytest.mark.parametrize(
    ("windows", "more", "words"),
    [
        (
            ("face: z up, dwell: 60 s", "face: x up, dwell: 9 s, start: 59 s"),
            "",
            ("windows[1].start", "overlap"),
        ),
        (("face: z up, dwell: 60 s, repeat: 6000",) * 2, "", ("12000", "10000")),
        (
            ("repeat: 9999, windows: [{face: all, dwell: 60 s, repeat: 9999}]",),
            "",
            ("599880006", "10000"),
        ),
        (
            ("face: all, dwell: 60 s, repeat: 167",),
            "estimator: weighted\n",
            ("windows", "1002", "1000", "least_squares"),
        ),
        (("face: z up, dwell: 60 s",), "gyro: {dwell: 9 s}\n", ("gyro", "windows")),
        (
            ("face: z up, dwell: 60 s",),
            "estimator: paper\n",
            ("estimator", "least_squares"),
        ),
        (("face: z up, dwell: 60 s",), "formulas: paper\n", ("formulas", "remove")),
        ((), "", ("windows",)),
        (
            ("face: z up, dwell: 60 s",),
            "estimate: {gyro: [biases, scale_factor], accelerometer: []}\n",
            ("estimate.gyro[0]", "'bias'", "estimate.accelerometer", "use:"),
        ),
        (("face: z up, dwell: 60 s",), "estimate: bias\n", ("estimate", "mapping")),
    ],
)
def test_what_makes_no_test_is_refused(procedure, windows, more, words):
    """Windows that overlap, are too many, or stand beside the paper's tests."""
    with pytest.raises(SpecError) as caught:
        procedure(*windows, more=more)

    for word in words:
        assert word in str(caught.value)


def test_a_pause_of_the_file_belongs_to_windows(tmp_path):
    """The paper's tests have their own pauses: one beside them is refused."""
    path = put(tmp_path / "mine.yaml", "pause: 10 s\n")
    with pytest.raises(SpecError, match="pause"):
        load_procedure(path)


def test_what_is_not_named_is_held(procedure):
    """Quantities on all their axes, or one; what a file does not speak of is found."""
    found = procedure(
        "face: z up, dwell: 60 s",
        more="estimate: {gyro: [scale_factor, mounting_angle.xy, bias.z]}\n",
    )
    both = procedure(
        "face: z up, dwell: 60 s", more="estimate: {gyro: all, accelerometer: all}\n"
    )

    assert found.held == (
        *(f"gyro.mounting_angle.{pair}" for pair in ("xz", "yx", "yz", "zx", "zy")),
        *(f"gyro.bias.{axis}" for axis in "xy"),
    )
    words = "not estimated, held at the nominal value of the device"
    assert f"gyro.mounting_angle xz, yx, yz, zx, zy: {words}" in found.assumptions
    assert f"gyro.bias x, y: {words}" in found.assumptions
    assert both.held == ()


def test_the_papers_estimator_holds_nothing(tmp_path):
    """Its formulas find every parameter: `estimate` beside them is refused."""
    path = put(tmp_path / "mine.yaml", "estimate: {gyro: [bias]}\n")
    with pytest.raises(SpecError, match="another estimator"):
        load_procedure(path)


@pytest.mark.parametrize("estimator", ["least_squares", "weighted"])
def test_the_papers_windows_go_through_another_estimator(tmp_path, estimator):
    """Without windows the paper's stand, whatever estimates from them."""
    path = put(tmp_path / "mine.yaml", f"estimator: {estimator}\n")
    found, paper = load_procedure(path), load_procedure(None)

    assert (found.formulas, found.windows) == (estimator, ())
    assert found.gyro == paper.gyro
    assert_allclose(found.latitude, paper.latitude, rtol=1e-15)
    assert pi / 2 > found.latitude > 0.0


def test_validate_draws_the_schedule(tmp_path):
    """A row for each window, at its time: turns and dwells look different."""
    path = put(
        tmp_path / "mine.yaml",
        "latitude: 34 deg\nwindows:\n  - {face: z up, dwell: 300 s}\n"
        "  - {face: z up, turn: vertical, turns: 10, rate: 12 deg/s, use: gyro}\n",
    )
    run = call("validate", path, code=0)
    rows = [line.split() for line in run.out.splitlines()]

    assert "Gyro: 1 turn of 5 min and 1 dwell of 5 min, in 10 min" in run.out
    assert ["dwell", "with", "z", "up", "0", "300", "=" * 19] in rows
    assert rows[-1] == ["dwell", "with", "z", "up", "0", "300", "=" * 19]
    (turn,) = (line for line in run.out.splitlines() if line.startswith("turn +10"))
    assert turn.endswith(" " * 19 + "#" * 19)
