"""Changes of a device on a call: read as a file is, and told wherever it is used."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from places import put
from reading import assert_says

from budget import load_device
from budget.errors import CallError, SpecError
from budget.inputs import load_all
from budget.inputs.load import load_changed
from budget.units import DEG_PER_HOUR, DEGREE, MICRO_G

FILE = """
name: mine
source: a sheet
gyro:
  nominal: {bias: 2.5 deg/h}
  errors:
    bias_repeatability: {value: 3 deg/h, meaning: max, source: p. 4, condition: warm}
    bias_stability:
      {value: 0.4 deg/h, definition: allan_minimum, correlation_time: 90 s}
    angle_random_walk: {value: 0.1 deg/s/sqrt(Hz), density: two-sided}
    scale_factor_repeatability: {axes: {x: 1 ppm, y: 2 ppm, z: 3 ppm}}
accelerometer:
  errors:
    bias_repeatability: 37 ug
variants:
  better: {gyro: {errors: {bias_repeatability: 1 deg/h}}}
  worse: {gyro: {errors: {bias_repeatability: 9 deg/h}}}
"""


@pytest.fixture
def path(tmp_path):
    """Provide a device file."""
    return put(tmp_path / "mine.yaml", FILE)


def gyro(path, *changes, line="bias_repeatability"):
    """Return a line of the gyro with changes."""
    return load_device(path, changes).gyro.line(line)


def test_a_value_alone_keeps_how_it_is_meant_and_drops_whose_it_was(path):
    """0.2 for 0.4 deg/h: still the lowest Allan deviation, still 90 s."""
    line = gyro(path, "gyro.bias_stability=0.2 deg/h", line="bias_stability")
    assert_allclose(line.u, 0.2 * DEG_PER_HOUR / 0.664, rtol=1e-12)
    assert_allclose(line.correlation_time, 90.0, rtol=1e-12)
    other = gyro(path, "gyro.bias_repeatability=1 deg/h")
    assert_allclose(other.u, DEG_PER_HOUR / np.sqrt(3.0), rtol=1e-12)
    assert (other.meaning, other.source, other.condition) == ("max", "--set", "")


def test_a_density_does_not_stay_with_a_value_that_is_none(path):
    """deg/sqrt(h) in the place of deg/s/sqrt(Hz) is the walk itself."""
    line = gyro(
        path, "gyro.angle_random_walk=0.3 deg/sqrt(h)", line="angle_random_walk"
    )
    assert_allclose(line.u, 0.3 * DEGREE / 60.0, rtol=1e-12)
    same = gyro(
        path, "gyro.angle_random_walk=0.2 deg/s/sqrt(Hz)", line="angle_random_walk"
    )
    assert_allclose(same.u, 0.2 * DEGREE, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ("gyro.scale_factor_repeatability.y=7 ppm", (1, 7, 3)),
        ("gyro.scale_factor_repeatability=[4 ppm, 5 ppm, 6 ppm]", (4, 5, 6)),
        ("gyro.scale_factor_repeatability=8 ppm", (8, 8, 8)),
        ("gyro.scale_factor_repeatability={axes: {x: 1 %}, value: 2 ppm}", (1e4, 2, 2)),
        ("gyro.scale_factor_repeatability.meaning=2 sigma", (0.5, 1, 1.5)),
        ("gyro.errors.scale_factor_repeatability.axes.z=9 ppm", (1, 2, 9)),
    ],
)
def test_axes_lists_mappings_and_keys(change, expected, path):
    """Each replaces what it names and nothing else."""
    line = gyro(path, change, line="scale_factor_repeatability")
    assert_allclose(line.u / 1e-6, expected, rtol=1e-12)


def test_one_axis_of_a_line_with_one_value(path):
    """The other axes stay as the file has them."""
    unit = load_device(path, ["accelerometer.bias_repeatability.z=1 mg"])
    (line,) = unit.accelerometer.lines
    assert_allclose(line.u / MICRO_G, [37, 37, 1000], rtol=1e-12)


def test_nominal_values(path):
    """One axis, or all of a list."""
    one = load_device(path, ["gyro.nominal.bias.z=0 deg/h"]).gyro.nominal_bias
    every = load_device(path, ["gyro.nominal.bias=[1 deg/h, 2 deg/h, 3 deg/h]"])
    assert_allclose(one / DEG_PER_HOUR, [2.5, 2.5, 0], rtol=1e-12)
    assert_allclose(every.gyro.nominal_bias / DEG_PER_HOUR, [1, 2, 3], rtol=1e-12)


def test_a_line_that_is_not_given_is_given(path):
    """It is no gap any more."""
    unit = load_device(path, ["accelerometer.velocity_random_walk=0.1 m/s/sqrt(h)"])
    assert "accelerometer.velocity_random_walk" not in unit.accelerometer.not_given
    (told,) = unit.origin.changes
    assert told.old == "not given"


def test_the_last_of_two_changes_of_one_line_counts(path):
    """In the order of the call, told once."""
    unit = load_device(
        path, ["gyro.bias_repeatability=1 deg/h", "gyro.bias_repeatability=2 deg/h"]
    )
    (told,) = unit.origin.changes
    assert (told.old, told.new) == ("3 deg/h (meaning max)", "2 deg/h (meaning max)")


def test_a_changed_device_says_so(path):
    """In its name, in what is assumed of the line and in where it is from."""
    plain, unit = load_device(path), load_device(path, ["gyro.bias_stability=1 deg/h"])
    assert unit.name == "mine, changed"
    assert unit.gyro.device == "mine, changed"
    assert_says(
        unit.assumptions[0], "gyro.bias_stability", "1 deg/h", "0.4 deg/h", "--set"
    )
    assert plain.origin.changes == ()
    assert plain.origin.sha256 == unit.origin.sha256
    assert [one.to_dict() for one in unit.origin.changes] == [
        {
            "line": "gyro.bias_stability",
            "from": "0.4 deg/h (definition allan_minimum, correlation time 90 s)",
            "to": "1 deg/h (definition allan_minimum, correlation time 90 s)",
        }
    ]


def test_a_change_may_be_of_one_device_or_variant(path):
    """NAME: before the address, as on the call; the others stay."""
    for name in ("#better", "mine#better", "mine.yaml#better", f"{path}#better"):
        found = load_changed(
            [path], [f"{name}:gyro.bias_repeatability=5 deg/h"], variants=True
        )
        u = [one.gyro.line("bias_repeatability").u[0] / DEG_PER_HOUR for one in found]
        # 3 deg/h is a bound; those of the variants are 1 sigma.
        assert_allclose(u, [3.0 / np.sqrt(3.0), 5.0, 9.0], rtol=1e-12)
        assert [one.name for one in found] == [
            "mine",
            "mine (better), changed",
            "mine (worse)",
        ]


def test_without_changes_nothing_is_other(path):
    """Base and variants are those that they were, name by name."""
    plain = load_all([path])
    same = load_changed([path], (), variants=True)
    for one, other in zip(plain, same, strict=True):
        assert one.name == other.name
        assert one.assumptions == other.assumptions
        assert_array_equal(one.gyro.lines[0].u, other.gyro.lines[0].u)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            "gyro.bias_stability=0.2 deg",
            ("gyro.errors.bias_stability", "0.2 deg", "deg/h"),
        ),
        ("gyro.bias_stability=0.2", ("without a unit", "deg/h")),
        ("gyro.bias_stablity=1 deg/h", ("unknown key", "'bias_stability'")),
        ("gyro.velocity_random_walk=1 deg/h", ("'angle_random_walk'",)),
        ("gyro.bias_repeatability.w=1 deg/h", ("unknown key 'w'", "axes")),
        ("gyro.bias_repeatability=[1 deg/h, 2 deg/h]", ("list of 2", "x, y, z")),
        ("gyro.bias_repeatability.meaning=mx", ("'mx'", "'max'")),
        ("gyro.bias_repeatability=-1 deg/h", ("-1 deg/h",)),
        ("gyro.nominal.drift=1 deg/h", ("unknown key 'drift'", "bias")),
        ("gyro.bias_repeatability={", ("no YAML",)),
        ("gyro.bias_repeatability=&a 1 deg/h", ("anchor",)),
    ],
)
def test_a_bad_value_is_refused_in_the_words_of_files(change, words, path):
    """Where: the option with its address; what was found, what is allowed."""
    with pytest.raises(SpecError) as caught:
        load_device(path, [change])
    assert str(caught.value).startswith(f"--set {change.partition('=')[0]}:1:")
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("bias_stability=1 deg/h", ("'gyro.bias_stability'", "'accelerometer.bias")),
        ("giro.bias_stability=1 deg/h", ("did you mean 'gyro.bias_stability'",)),
        ("gyro=1 deg/h", ("SENSOR.SPEC",)),
        ("gyro.bias_stability", ("SENSOR.SPEC=VALUE",)),
        ("gyro.bias_stability=", ("SENSOR.SPEC=VALUE",)),
        ("gyro..bias_stability=1 deg/h", ("SENSOR.SPEC",)),
        ("yours:gyro.bias_stability=1 deg/h", ("'yours'", "gyro")),
        ("gyro.bias_stability=" + "1" * 2000, ("1000",)),
        ("gyro.bias_stability=1 deg/h\x07", ("U+0007",)),
        ("gyro.bias_stability=\udcff", ("U+DCFF",)),
    ],
)
def test_what_is_no_change_is_refused(change, words, path):
    """No address, no value, nobody's."""
    with pytest.raises(CallError) as caught:
        load_device(path, [change])
    for word in words:
        assert word in str(caught.value)


def test_a_change_of_a_sensor_that_is_not_there(tmp_path):
    """Another device may have it; if none has, the call is refused."""
    (tmp_path / "g.yaml").write_text(
        "{name: g, gyro: {errors: {bias_stability: 1 deg/h}}}", encoding="utf-8"
    )
    with pytest.raises(CallError) as caught:
        load_device(tmp_path / "g.yaml", ["accelerometer.bias_stability=1 mg"])
    assert_says(str(caught.value), "no device here has an accelerometer")
