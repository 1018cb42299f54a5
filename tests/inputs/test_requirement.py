"""Requirement and costs files: limits by output, what is left free, prices."""

from __future__ import annotations

from math import pi

import pytest
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError
from budget.inputs import load_costs, load_requirement, validate

DEG_H = pi / 180.0 / 3600.0
ARCSEC = pi / 180.0 / 3600.0
UG = 9.80665e-6
AXES = ["x", "y", "z"]
ANGLES = ["xy", "xz", "yx", "yz", "zx", "zy"]


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a file."""

    def write(text):
        return put(tmp_path / "file.yaml", text)

    return write


def test_the_shipped_requirement_expands_to_one_limit_an_output():
    """The example has all 24 outputs, in their order, with the limits it prints."""
    requirement = load_requirement("navigation-grade")
    expected = {
        **{f"gyro.scale_factor.{axis}": 20e-6 for axis in AXES},
        **{f"gyro.mounting_angle.{axis}": 5.0 * ARCSEC for axis in ANGLES},
        "gyro.bias.x": 0.02 * DEG_H,
        "gyro.bias.y": 0.02 * DEG_H,
        "gyro.bias.z": 0.01 * DEG_H,
        **{f"accelerometer.scale_factor.{axis}": 60e-6 for axis in AXES},
        **{f"accelerometer.mounting_angle.{axis}": 5.0 * ARCSEC for axis in ANGLES},
        **{f"accelerometer.bias.{axis}": 80.0 * UG for axis in AXES},
    }
    assert [limit.output for limit in requirement.limits] == list(expected)
    limits = [limit.limit for limit in requirement.limits]
    assert_allclose(limits, list(expected.values()), rtol=1e-15)
    assert requirement.limits[11].printed == "0.01 deg/h"
    assert (requirement.name, requirement.coverage) == ("navigation grade", 0.95)
    assert requirement.reference == "next_turn_on"
    assert requirement.assumptions == ()
    assert requirement.caps == (
        ("price", "50000 EUR"),
        ("mass", "2 kg"),
        ("power", "20 W"),
    )


def test_what_is_not_named_is_not_required(write):
    """An unnamed axis, parameter or sensor has no limit."""
    path = write("name: x\nlimits: {gyro: {mounting_angle: {yz: 1 arcsec}}}\n")
    outputs = [limit.output for limit in load_requirement(path).limits]
    assert outputs == ["gyro.mounting_angle.yz"]


def test_unset_coverage_and_reference_are_assumed_and_said(write):
    """95 % and next_turn_on stand in, each in the assumptions."""
    path = write("name: x\nlimits: {accelerometer: {bias: 1 mg}}\n")
    requirement = load_requirement(path)
    assert (requirement.coverage, requirement.reference) == (0.95, "next_turn_on")
    assert requirement.assumptions == (
        "coverage: not given, 95 % assumed",
        "reference: not given, next_turn_on assumed",
    )
    assert validate(path).assumptions == requirement.assumptions


def test_coverage_and_reference_are_taken_where_given(write):
    """A file's own coverage and reference rule."""
    requirement = load_requirement(
        write(
            "name: x\ncoverage: 99.7 %\nreference: as_tested\n"
            "limits: {gyro: {bias: 1 deg/h}}\n"
        )
    )
    assert (requirement.coverage, requirement.reference) == (0.997, "as_tested")
    assert requirement.assumptions == ()


def test_costs_are_read_by_line(write):
    """The figures of a file are taken; what is unset is 1, 1 and the present value."""
    path = write(
        "costs: {gyro.bias_stability: {a: 2, p: 1.5, u_ref: 0.04 deg/h}, "
        "accelerometer.velocity_random_walk: {a: 3}}\n"
    )
    costs = load_costs(path)
    first, second = costs.costs
    assert (first.source, first.a, first.p) == ("gyro.bias_stability", 2.0, 1.5)
    assert_allclose(first.u_ref, 0.04 * DEG_H, rtol=1e-15)
    assert second.source == "accelerometer.velocity_random_walk"
    assert (second.a, second.p, second.u_ref) == (3.0, 1.0, None)
    assert costs.assumptions == (
        "accelerometer.velocity_random_walk.p: not given, 1 assumed",
        (
            "accelerometer.velocity_random_walk.u_ref: not given, the present value "
            "assumed"
        ),
    )
    assert validate(path).kind == "costs"


def test_a_density_of_costs_is_two_sided(write):
    """1 ug/sqrt(Hz) stands for that random walk, the larger, as it does in a device."""
    figure = "{a: 1, p: 1, u_ref: 1 ug/sqrt(Hz)}"
    costs = load_costs(
        write(f"costs: {{accelerometer.velocity_random_walk: {figure}}}")
    )
    assert_allclose(costs.costs[0].u_ref, 9.80665e-6, rtol=1e-15)
    (said,) = costs.assumptions
    assert "taken as two-sided" in said


def test_limits_on_what_is_derived_follow_those_on_parameters(write):
    """Of each triad after its biases, of both together last; pairs have no order."""
    path = write(
        "name: x\nlimits: {misalignment: {y: 9 arcsec}, "
        "accelerometer: {rotation: 3 arcsec}, "
        "gyro: {non_orthogonality: {xz: 2 arcsec}, bias: {z: 1 deg/h}}}\n"
    )
    found = [(one.output, one.limit) for one in load_requirement(path).limits]

    assert [str(name) for name, _ in found] == [
        "gyro.bias.z",
        "gyro.non_orthogonality.xz",
        *(f"accelerometer.rotation.{axis}" for axis in AXES),
        "imu.misalignment.y",
    ]
    expected = [DEG_H, *(n * ARCSEC for n in (2.0, 3.0, 3.0, 3.0, 9.0))]
    assert_allclose([limit for _, limit in found], expected, rtol=1e-15)


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ("gyro: {non_orthogonality: {zx: 2 arcsec}}", "allowed: xy, xz, yz"),
        ("gyro: {misalignment: 2 arcsec}", "unknown key"),
        ("misalignment: 2 deg/h", "expected an angle"),
        ("misalignment: -2 arcsec", "positive"),
    ],
)
def test_limits_on_what_is_derived_are_checked(write, limits, said):
    """A pair the wrong way round, a place, a unit, a sign: line, column, remedy."""
    with pytest.raises(SpecError) as found:
        validate(write(f"name: x\nlimits: {{{limits}}}\n"))
    (issue,) = found.value.issues
    assert (issue.line, said in str(issue)) == (2, True), str(issue)


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("heading: 1 deg", "{limit: 1 deg, at: 60 s}"),
        ("position: 5 m", "{horizontal: 5 m, at: 60 s}"),
        ("velocity: [1 m/s]", "a mapping of keys"),
        ("velocity: true", "found true"),
    ],
)
def test_a_limit_on_a_mission_says_its_time(write, limit, said):
    """A value alone is shown with what it lacks."""
    with pytest.raises(SpecError) as found:
        validate(write(f"name: x\nlimits: {{mission: {{{limit}}}}}\n"))
    (issue,) = found.value.issues
    assert (issue.line, said in str(issue)) == (2, True), str(issue)


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("CEP", "'horizontal' with 'probability: 50 %'"),
        ("R95", "'horizontal' with 'probability: 95 %'"),
        ("radius", "did you mean 'horizontal'?"),
    ],
)
def test_other_words_for_a_horizontal_limit_have_a_hint(write, key, said):
    """What others call the radius is `horizontal` here, at a probability."""
    text = f"name: x\nlimits: {{mission: {{position: {{{key}: 5 m, at: 60 s}}}}}}\n"
    with pytest.raises(SpecError) as found:
        validate(write(text))
    assert any(
        f"unknown key {key!r}" in str(issue) and said in str(issue)
        for issue in found.value.issues
    )
