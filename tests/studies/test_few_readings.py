"""A figure from few readings in a data sheet, from the file to the verdict."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from numpy.testing import assert_allclose

import budget
from budget.calibration.problem import calibration_problem
from budget.errors import SpecError
from budget.inputs import load_mission, load_procedure
from budget.methods.gum import propagate
from budget.question import Question
from budget.report.device_file import device_yaml, is_read_back

SIX = "{value: 73.19 deg/h, degrees_of_freedom: 5}"  # turn-ons of an ADIS16405
LIMIT = """\
name: limit of 180
environment: none
reference: nominal
limits:
  gyro: {bias: 180 deg/h}
"""
FULL = """\
name: all lines
gyro:
  range: 300 deg/s
  errors:
    bias_repeatability: %s
    bias_stability: 0.1 deg/h
    angle_random_walk: 0.01 deg/sqrt(h)
    rate_random_walk: 0.01 deg/h/sqrt(h)
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 10 arcsec
    g_sensitivity: 0.01 deg/h/g
accelerometer:
  range: 5 g
  errors:
    bias_repeatability: 100 ug
    bias_stability: 20 ug
    velocity_random_walk: {value: 0.01 m/s/sqrt(h), axes: %s}
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 10 arcsec
"""
VRW = "0.01 m/s/sqrt(h)"
APART = (
    "{x: {value: 0.01 m/s/sqrt(h), degrees_of_freedom: 9}, y: 0.01 m/s/sqrt(h), "
    "z: {value: 0.01 m/s/sqrt(h), degrees_of_freedom: 4.5}}"
)


def read(tmp_path, figure=SIX, axes=APART):
    """Return a device with these."""
    path = tmp_path / "device.yaml"
    path.write_text(FULL % (figure, axes), encoding="utf-8")
    return budget.load_device(path)


@pytest.fixture
def wanted(tmp_path):
    path = tmp_path / "limit.yaml"
    path.write_text(LIMIT, encoding="utf-8")
    return path


def test_six_turn_ons_fail_where_as_many_as_one_likes_meet(tmp_path, wanted):
    """U95 = 2.5706 x 73.19 deg/h = 188.1 deg/h, of 180 deg/h; 143.4 without."""
    few = read(tmp_path)
    law = budget.analyze(few, requirement=wanted, validate=False, method="gum")
    trials = budget.analyze(few, requirement=wanted, validate=False)
    known = budget.analyze(
        read(tmp_path, "73.19 deg/h"), requirement=wanted, validate=False
    )
    (row, *_) = [row for row in law.outputs if row.output.name.quantity == "bias"]

    assert_allclose(row.degrees_of_freedom, 5.0, rtol=1e-3)
    assert_allclose(row.law_factor, 2.5705818, rtol=1e-7)
    assert row.interval_by == "monte-carlo"  # Welch-Satterthwaite is a convention
    (verdict, *_) = trials.assessment.sensors
    assert verdict.verdict == "fails"
    # To five standard errors of a 97.5 % quantile of t of 5 degrees among 100 000.
    density, t = 0.02789, 2.5706
    sure = np.sqrt(0.05 * 0.95 / 100_000) / (2.0 * density * t)
    assert_allclose(verdict.utilisation, t * 73.19 / 180.0, rtol=5.0 * sure)
    (other, *_) = known.assessment.sensors
    assert other.verdict in {"meets", "meets_if"}
    assert_allclose(other.utilisation, 0.797, atol=5e-4)


def test_of_many_readings_the_law_is_sure_enough(tmp_path):
    """So many that k is the normal one but for less than trials leave open."""
    many = read(tmp_path, "{value: 73.19 deg/h, degrees_of_freedom: 20000}")
    found = budget.analyze(many, validate=False)
    rows = [row for row in found.outputs if row.output.name.owner == "gyro"]

    assert {row.interval_by for row in rows} == {"law"}
    assert min(row.degrees_of_freedom for row in rows) < inf


def test_one_figure_is_off_as_a_whole_and_those_of_axes_each(tmp_path):
    """A scale for all inputs of a line, or one for each axis that is not known."""
    device = read(tmp_path)
    groups = {
        one.name: one
        for one in calibration_problem(
            device.sensors, load_procedure(), reference="next_turn_on"
        ).groups
    }
    (whole,) = groups["gyro.bias_repeatability"].scales
    assert (whole.degrees_of_freedom, whole.rows) == (5.0, tuple(range(6)))
    walk = groups["accelerometer.velocity_random_walk"]
    x, z = walk.scales
    assert (x.degrees_of_freedom, z.degrees_of_freedom) == (9.0, 4.5)
    # What is of one axis is not correlated with what is of another.
    assert not {*x.rows} & {*z.rows}
    assert not walk.covariance[np.ix_(x.rows, z.rows)].any()
    assert groups["gyro.bias_stability"].scales == ()


def test_a_mission_knows_a_noise_no_better_than_its_calibration_does(tmp_path):
    """In run a line is as sure as in the test; by axis as the least sure of them."""

    def on_the_way(device):
        asked = {"procedure": load_procedure(), "mission": load_mission("bench")}
        return Question.of(device, **asked).carry((3600.0,)).problem

    few = on_the_way(read(tmp_path))
    known = on_the_way(
        read(tmp_path, "73.19 deg/h", "{x: %s, y: %s, z: %s}" % ((VRW,) * 3))
    )
    groups = {one.name: one for one in few.groups}
    walk = groups["accelerometer.velocity_random_walk"]

    assert [one.degrees_of_freedom for one in walk.scales] == [9.0, 4.5, 4.5]
    assert max(k for one in walk.scales for k in one.rows) == walk.size - 1
    same, found = propagate(known), propagate(few)
    assert_allclose(found.standard_uncertainty, same.standard_uncertainty, rtol=1e-15)
    assert (found.degrees_of_freedom < same.degrees_of_freedom).any()


def test_it_is_written_and_read_again(tmp_path):
    """As one figure, or by axis."""
    sensors = read(tmp_path).sensors
    path = tmp_path / "again.yaml"
    path.write_text(
        device_yaml(sensors, name="again", source="a log", notes="six"),
        encoding="utf-8",
    )
    gyro, accelerometer = budget.load_device(path).sensors

    assert gyro.line("bias_repeatability").degrees_of_freedom == (5.0,)
    walk = accelerometer.line("velocity_random_walk")
    assert walk.degrees_of_freedom == (9.0, None, 4.5)
    assert is_read_back(path.read_text(encoding="utf-8"), sensors)


@pytest.mark.parametrize(
    ("figure", "words"),
    [
        ("{value: 1 deg/h, degrees_of_freedom: 0}", "degrees_of_freedom"),
        ("{value: 1 deg/h, degrees_of_freedom: few}", "expected a number"),
        ("{value: 1 deg/h, degrees_of_freedom: .inf}", "degrees_of_freedom"),
        (
            "{value: 1 deg/h, meaning: max, degrees_of_freedom: 5}",
            "standard uncertainty",
        ),
        (
            "{value: 1 deg/h, distribution: uniform, degrees_of_freedom: 5}",
            "standard uncertainty",
        ),
    ],
)
def test_what_has_none_is_refused(tmp_path, figure, words):
    """A half-width, a shape that is not normal, no number."""
    with pytest.raises(SpecError, match=words):
        read(tmp_path, figure)
