"""Procedure files: the paper's values, what stands in for them, where it is done."""

from __future__ import annotations

from math import pi

import pytest
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError
from budget.inputs import load_procedure
from budget.model.windows import Timing

DEG = pi / 180.0


@pytest.fixture
def procedure(tmp_path):
    """Return a function that reads a procedure from its text."""

    def read(text):
        path = put(tmp_path / "mine.yaml", text)
        return load_procedure(path)

    return read


def test_the_shipped_procedure_has_the_values_of_the_paper():
    """Place, rate, turns, azimuths and times are those of Zhao 2019; all are set."""
    paper = load_procedure(None)
    assert paper.name == "Zhao 2019"
    assert_allclose(paper.latitude, 34.2394 * DEG, rtol=1e-15)
    assert_allclose(paper.gravity, 9.7966933092, rtol=0, atol=1e-10)
    assert_allclose(paper.sample_rate, 100.0, rtol=0)
    assert paper.formulas == "corrected"
    assert_allclose(paper.gyro.rate, 20.0 * DEG, rtol=1e-15)
    assert paper.gyro.turns == 1
    assert paper.gyro.order == ("z", "x", "y")
    assert_allclose(
        paper.gyro.azimuths, [0.0, pi, 1.5 * pi, 2.5 * pi], rtol=1e-15, atol=0
    )
    for test in (paper.gyro, paper.accelerometer):
        assert_allclose(test.dwell, 300.0, rtol=0)
        assert_allclose(test.pause, 0.0, rtol=0, atol=0)
    # The paper leaves these open.
    assert paper.assumptions == (
        "height: not given, 0 m assumed",
        "station: not given, an ideal one assumed",
    )
    assert paper.origin.file == "zhao-2019.yaml"


def test_unset_keys_take_the_values_of_the_shipped_file(procedure):
    """What a file leaves out is what the shipped file says, and that is said."""
    mine, paper = procedure("sample_rate: 100 Hz\n"), load_procedure()
    for key in ("latitude", "gravity", "formulas", "gyro", "accelerometer"):
        assert getattr(mine, key) == getattr(paper, key)
    assert mine.assumptions == (
        "latitude: not given, 34.2394 deg assumed, as in Zhao 2019",
        "gravity: not given, normal assumed, as in Zhao 2019",
        "formulas: not given, corrected assumed, as in Zhao 2019",
        "gyro.rate: not given, 20 deg/s assumed, as in Zhao 2019",
        "gyro.turns: not given, 1 assumed, as in Zhao 2019",
        "gyro.order: not given, [z, x, y] assumed, as in Zhao 2019",
        "gyro.pause: not given, 0 s assumed, as in Zhao 2019",
        (
            "gyro.azimuths: not given, [0 deg, 180 deg, 270 deg, 450 deg] assumed, "
            "as in Zhao 2019"
        ),
        "gyro.dwell: not given, 300 s assumed, as in Zhao 2019",
        "accelerometer.dwell: not given, 300 s assumed, as in Zhao 2019",
        "accelerometer.pause: not given, 0 s assumed, as in Zhao 2019",
        *paper.assumptions,
    )


def test_a_procedure_without_a_name_has_that_of_its_file(procedure):
    """It does not pass for the paper's."""
    assert procedure("formulas: paper\n").name == "mine"


def test_every_key_can_be_set(procedure):
    """What a file says is taken, in SI."""
    mine = procedure(
        "name: mine\nlatitude: -1 rad\ngravity: 1 g\nsample_rate: 1 kHz\n"
        "formulas: paper\n"
        "gyro: {rate: 1 rad/s, turns: 3, order: [x, y, z], pause: 2 s, "
        "azimuths: [-1 rad], dwell: 1 min}\n"
        "accelerometer: {dwell: 1 h, pause: 3 s}\n"
        "flip_axis: middle\n"
        "station: {scale_from: rate, window: time}\n"
    )
    assert (mine.latitude, mine.gravity, mine.sample_rate) == (-1.0, 9.80665, 1000.0)
    assert (mine.name, mine.formulas, mine.assumptions) == ("mine", "paper", ())
    assert (mine.gyro.rate, mine.gyro.turns, mine.gyro.pause) == (1.0, 3, 2.0)
    assert (mine.gyro.order, mine.gyro.azimuths) == (("x", "y", "z"), (-1.0,))
    assert (mine.gyro.dwell, mine.accelerometer.dwell) == (60.0, 3600.0)
    assert mine.accelerometer.pause == 3.0
    assert mine.accelerometer.flip_axis == "middle"
    assert mine.timing == Timing(scale_from="rate", edges="time")


def test_normal_gravity_is_that_of_the_height(procedure):
    """1600 m up it is 504 ppm less; a measured gravity knows no height."""
    high, low = procedure("height: 1600 m\n"), procedure("height: 0 m\n")
    assert_allclose(high.gravity / low.gravity, 1.0 - 504e-6, rtol=1e-6)
    assert high.place.height == 1600.0
    assert not any(text.startswith("height") for text in high.assumptions)
    for text, what in (
        ("height: 10 m\ngravity: 9.8 m/s^2\n", "gravity is given"),
        ("height: 6371 km\n", "100000 m"),
        ("height: 6371 parsec\n", "no known unit"),
        ("height: 1000000 m\n", "100000 m"),
    ):
        with pytest.raises(SpecError, match=what):
            procedure(text)


def test_z_comes_down_by_the_axis_that_is_named(procedure):
    """Faces of windows turn about the middle axis then; all other faces stay."""
    faces = "windows: [{face: all, dwell: 60 s}]\n"
    inner = procedure(faces).windows
    middle = procedure(f"flip_axis: middle\n{faces}").windows
    moved = [a.name for a, b in zip(inner, middle, strict=True) if a != b]
    assert moved == ["z down"]
    (down,) = (one for one in middle if one.name == "z down")
    assert down.setting.angles == (0.0, pi, 0.0)


@pytest.mark.parametrize(
    ("latitude", "printed"),
    [
        ("0 deg", "9.7803253359"),
        ("45 deg", "9.8061977694"),
        ("-90 deg", "9.8321849379"),
    ],
)
def test_normal_gravity_is_that_of_the_latitude(procedure, latitude, printed):
    """`normal` follows the latitude of the same file, up to the poles."""
    mine = procedure(f"latitude: {latitude}\ngravity: normal\n")
    assert_allclose(mine.gravity, float(printed), rtol=0, atol=1e-10)


def test_a_window_of_one_sample_is_enough(procedure):
    """The shortest dwell and turn that hold a sample are allowed."""
    mine = procedure("sample_rate: 1 Hz\ngyro: {dwell: 1 s, rate: 360 deg/s}\n")
    assert mine.gyro.dwell == 1.0


def test_all_windows_without_a_sample_are_reported(procedure):
    """Turn, gyro dwell and accelerometer dwell are three issues."""
    with pytest.raises(SpecError) as caught:
        procedure(
            "sample_rate: 1 Hz\ngyro: {rate: 720 deg/s, dwell: 0.1 s}\n"
            "accelerometer: {dwell: 0.1 s}\n"
        )
    fields = [issue.field for issue in caught.value.issues]
    assert fields == ["gyro.rate", "gyro.dwell", "accelerometer.dwell"]


def test_a_procedure_has_no_variants():
    """What follows '#' is refused, not passed over."""
    with pytest.raises(SpecError, match="only a device file has variants"):
        load_procedure("zhao-2019#A")
