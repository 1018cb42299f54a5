"""`budget analyze`: what a device file says, and what becomes of it."""

from __future__ import annotations

import pytest
from command_line import analyze, call, contribution
from numpy.testing import assert_allclose

from budget.model.sources import lines_of

GYRO = """\
name: gyro alone
gyro:
  errors:
    bias_repeatability: 0.05 deg/h
    bias_stability: {value: 0.04 deg/h, correlation_time: 300 s}
    angle_random_walk: 0.005 deg/sqrt(h)
    scale_factor_repeatability: 50 ppm
    mounting_repeatability: 2 arcsec
"""
ACCELEROMETER = """\
name: accelerometer alone
accelerometer:
  errors:
    bias_repeatability: 37 ug
    bias_stability: {value: 20 ug, correlation_time: 300 s}
    velocity_random_walk: 5 ug/sqrt(Hz)
    scale_factor_repeatability: 37 ppm
    mounting_repeatability: 2 arcsec
"""
VARIANTS = """\
variants:
  better: {name: better, gyro: {errors: {bias_repeatability: 0.01 deg/h}}}
"""


@pytest.fixture
def write(tmp_path):
    """Write files of given texts beside each other and return their paths."""

    def write(name, text):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_gyro_alone_has_twelve_outputs(write):
    """A device without an accelerometer has no accelerometer outputs or gaps."""
    document = analyze(write("gyro.yaml", GYRO))

    assert [row["sensor"] for row in document["outputs"]] == ["gyro"] * 12
    assert len(document["covariance"]) == 12
    assert all(name.startswith("gyro.") for name in document["not_given"])


def test_two_files_complete_each_other(write):
    """A gyro and an accelerometer from two files, in any order, give 24 outputs."""
    gyro, other = write("g.yaml", GYRO), write("a.yaml", ACCELEROMETER)
    one, two = analyze(gyro, other), analyze(other, gyro)

    assert len(one["outputs"]) == 24
    assert one["outputs"] == two["outputs"]
    assert one["outputs"][0]["sensor"] == "gyro"
    assert [one["inputs"][f"device {n}"]["name"] for n in (1, 2)] == [
        "g.yaml",
        "a.yaml",
    ]


def test_two_gyros_are_refused(write):
    """Two devices with a gyro each are exit 2, and both are named."""
    gyro = write("g.yaml", GYRO)
    run = call("analyze", gyro, "zhao-2019", "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert "'gyro alone' and 'Zhao 2019 optical IMU' both have a gyro" in run.err


def test_figure_by_axis(write):
    """An axis named in `axes` takes its own figure, the others the common one."""
    text = GYRO.replace(
        "bias_repeatability: 0.05 deg/h",
        "bias_repeatability: {value: 0.05 deg/h, axes: {z: 0.2 deg/h}}",
    )
    document = analyze(write("g.yaml", text))

    for axis, expected in zip("xyz", (0.05, 0.05, 0.2), strict=True):
        part = contribution(document, f"gyro.bias.{axis}", "gyro.bias_repeatability")
        assert_allclose(part["standard_uncertainty"], expected, rtol=1e-9)


def test_half_width_without_distribution(write):
    """`max` is a half-width, uniform unless said: u = a / sqrt(3), and that is said."""
    text = GYRO.replace("50 ppm", "{value: 50 ppm, meaning: max}")
    document = analyze(write("g.yaml", text))

    part = contribution(
        document, "gyro.scale_factor.x", "gyro.scale_factor_repeatability"
    )
    assert_allclose(part["standard_uncertainty"], 28.8675134595, rtol=1e-9)
    assert any("uniform" in text for text in document["assumptions"])


def test_missing_line_stands_in_not_given(write):
    """Every model line that the device does not give is named, and only those.

    Its white noise is given, as a random walk.
    """
    text = "".join(
        line for line in GYRO.splitlines(keepends=True) if "mounting" not in line
    )
    document = analyze(write("g.yaml", text))

    given = {
        *("bias_repeatability", "bias_stability"),
        *("angle_random_walk", "sample_noise", "scale_factor_repeatability"),
    }
    assert set(document["not_given"]) == {
        f"gyro.{line.name}"
        for line in lines_of("gyro")
        if line.varies and line.name not in given
    }
    assert "gyro.mounting_repeatability" in document["not_given"]


def test_variant_is_chosen_by_name(write):
    """FILE#VARIANT takes the variant's figure, FILE the base's."""
    file = write("g.yaml", GYRO + VARIANTS)
    place = ("gyro.bias.x", "gyro.bias_repeatability")
    base, better = (
        contribution(analyze(name), *place)["standard_uncertainty"]
        for name in (file, f"{file}#better")
    )

    assert_allclose([base, better], [0.05, 0.01], rtol=1e-9)


def test_unknown_variant_is_refused(write):
    """A variant that there is not is exit 2, with the ones there are."""
    file = write("g.yaml", GYRO + VARIANTS)
    run = call("analyze", f"{file}#beter", "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert "beter" in run.err
    assert "better" in run.err


def test_source_of_zero_uncertainty(write):
    """A figure of 0 is given, not missing: its rows are zeros and nothing breaks."""
    text = GYRO.replace("angle_random_walk: 0.005 deg", "angle_random_walk: 0 deg")
    document = analyze(write("g.yaml", text))

    assert "gyro.angle_random_walk" not in document["not_given"]
    for row in document["outputs"]:
        (part,) = (
            part
            for part in row["contributions"]
            if part["source"] == "gyro.angle_random_walk"
        )
        assert (part["standard_uncertainty"], part["share"]) == (0.0, 0.0)


def test_nothing_but_zeros(write):
    """A device whose every figure is 0 has no spread, no shares and no failure."""
    text = (
        "name: perfect\ngyro: {errors: {bias_repeatability: 0 deg/h,"
        " scale_factor_repeatability: 0 ppm}}\n"
    )
    file = write("perfect.yaml", text)
    validated = call("analyze", file, "--json", "-")

    assert validated.code == 0, validated.err
    for document in (
        validated.document,
        analyze(file, "--method", "monte-carlo", "--trials", "1000"),
    ):
        for row in document["outputs"]:
            assert row["standard_uncertainty"] == 0.0
            assert {part["share"] for part in row["contributions"]} == {0.0}


def test_faults_of_all_files_come_at_once(write):
    """Two faulty files are reported in one call, each with its position."""
    one = write("one.yaml", "name: x\ngyro: {errors: {bias_stability: 1 arcsec}}\n")
    two = write("two.yaml", "name: y\naccelerometer: {errors: {bias_stabilty: 1 ug}}\n")
    run = call("analyze", one, two, "--json", "-")

    assert (run.code, run.out) == (2, "")
    assert f"{one}:2:" in run.err
    assert f"{two}:2:" in run.err
