"""Temperature and vibration that are known on the way, after every calibration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import line, procedure, triads
from numpy.testing import assert_allclose

from budget.aiding import problem_of_mission
from budget.calibration.mission import (
    constants_problem,
    mission_outputs,
    not_carried,
    on_the_way,
)
from budget.inputs import load_mission, uncalibrated
from budget.inputs.use import in_use
from budget.methods.gum import propagate
from budget.units import DEG_PER_HOUR, MICRO_G, STANDARD_GRAVITY

TIMES = (60.0, 200.0)
LEGS = [
    {"straight": "50 s", "speed": "30 m/s"},
    {"turn": "90 deg", "rate": "1.5 deg/s"},
    {"straight": "90 s"},
]
GNSS = {"gnss": {"position": "2.5 m", "velocity": "0.05 m/s", "rate": "1 Hz"}}
ALONE = {"alignment": "perfect"}
ALIGNED = {"alignment": "self", "alignment_time": "60 s"}
AIDED = {
    "alignment": {"position": "9 m", "velocity": "1 m/s", "level": "1 deg"},
    "aiding": GNSS,
}
COEFFICIENTS = ("bias_temperature_coefficient", "scale_factor_temperature_coefficient")
RECTIFICATION = "vibration_rectification"
TESTED = procedure(environment=(line("vibration.test", 2.0 * STANDARD_GRAVITY),))


def way(environment, how=ALONE, shaken=None):
    """Return a mission of these legs, the first aided where there are aids."""
    more = {"vibration": shaken} if shaken else {}
    legs = [{**leg, **more} for leg in LEGS]
    if "aiding" in how:
        legs[0]["aiding"] = ["gnss"]
    if how is ALIGNED:
        legs = [{"stand": "200 s", **more}]
    part = {"latitude": "47 deg", **how, "segments": legs}
    return load_mission({"name": "way", "environment": environment, "mission": part})


def law(mission, sensors, how=TESTED, only=None):
    """Return the law of all errors of a mission at both times."""
    used = in_use(how, None, mission)
    outputs = mission_outputs(mission, TIMES)
    problem = problem_of_mission(sensors, used, mission, outputs, only=only)
    return problem, propagate(problem)


def shaken(gyro=0.5, accelerometer=30.0):
    """Return both triads of the paper with rectification, deg/h/g^2 and ug/g^2."""
    per = STANDARD_GRAVITY**2
    return triads(
        {RECTIFICATION: gyro * DEG_PER_HOUR / per},
        {RECTIFICATION: accelerometer * MICRO_G / per},
    )


@pytest.mark.parametrize("calibration", ["none", "factory", "tested"])
@pytest.mark.parametrize("how", [ALONE, ALIGNED, AIDED], ids=["", "self", "aided"])
def test_a_vibration_that_is_the_same_all_the_way_is_that_size(how, calibration):
    """By segments or by one size: the same law, correlated with the calibration."""
    test = TESTED if calibration == "tested" else uncalibrated(calibration)
    one = law(way({"vibration": "3 g"}, how), shaken(), test)[1]
    other = law(way({"vibration": "1 g"}, how, "3 g"), shaken(), test)[1]
    u = one.standard_uncertainty
    found, size = other.covariance / np.outer(u, u), one.covariance / np.outer(u, u)
    assert_allclose(found, size, rtol=0, atol=1e-9)
    less = law(way({"vibration": "3 g"}, how, "1 g"), shaken(), test)[1]
    assert np.abs(less.standard_uncertainty / u - 1.0).max() > 1e-3  # control


def test_a_vibration_as_in_the_test_leaves_nothing():
    """VRE (2^2 - 2^2) g^2; with the sign of one of both turned VRE 8 g^2."""
    only = frozenset({f"gyro.{RECTIFICATION}", f"accelerometer.{RECTIFICATION}"})
    mission = way({"vibration": "1 g"}, ALONE, "2 g")
    left = law(mission, shaken(), only=only)[1].standard_uncertainty
    alone = law(mission, shaken(), uncalibrated("none"), only=only)[1]
    u = alone.standard_uncertainty
    assert_allclose(left / u, 0.0, rtol=0, atol=1e-6)
    # Control: what is not correlated with a constant bias of the test is seen by sign.
    turned = in_use(TESTED, None, mission)
    sensors, used = on_the_way(shaken(), turned)
    constants = constants_problem(sensors, used, only=only)
    C = propagate(constants).covariance
    names = [output.name for output in constants.outputs]
    own = names.index(f"gyro.{RECTIFICATION}.x"), names.index("gyro.bias.x")
    assert C[own] / np.sqrt(C[own[0], own[0]] * C[own[1], own[1]]) > 0.99


@pytest.mark.parametrize("how", [ALONE, ALIGNED, AIDED], ids=["", "self", "aided"])
def test_a_temperature_that_does_not_change_is_that_difference(how):
    """On one axis a coefficient and a difference are a product: the same law."""
    size = {"bias_temperature_coefficient": [0.0, 0.1 * DEG_PER_HOUR, 0.0]}
    sensors = triads(size, {})
    flat = [["0 s", "45 degC"], ["200 s", "45 degC"]]
    course = {"temperature": {"reference": "25 degC", "profile": flat}}
    one = law(way({"temperature": "20 degC"}, how), sensors)[1]
    other = law(way(course, how), sensors)[1]
    u = one.standard_uncertainty
    found, wanted = (x.covariance / np.outer(u, u) for x in (other, one))
    assert_allclose(found, wanted, rtol=0, atol=1e-9)


def test_the_sign_of_a_temperature_is_no_matter_and_its_zero_is():
    """Coefficients are as often negative: T0 - T is T - T0, another T0 is not."""
    sensors = triads(
        dict.fromkeys(COEFFICIENTS, 1e-7), {"bias_temperature_coefficient": 1e-4}
    )

    def u(first, last):
        points = [["0 s", f"{first} degC"], ["200 s", f"{last} degC"]]
        said = {"temperature": {"reference": "20 degC", "profile": points}}
        return law(way(said), sensors)[1].standard_uncertainty

    assert_allclose(u(10, 40), u(30, 0), rtol=1e-12)
    assert np.abs(u(10, 40) / u(20, 50) - 1.0).max() > 0.05


@pytest.mark.parametrize("how", [ALONE, AIDED], ids=["", "aided"])
def test_contributions_add_up(how):
    """Of all sources with coefficients of a course among them, of 1 sigma each."""
    warm = {"temperature": {"warm_up": {"by": "20 degC", "time": "50 s"}}}
    more = {**dict.fromkeys(COEFFICIENTS, -1e-6), RECTIFICATION: 1e-9}
    sensors = triads(more, {})
    problem, whole = law(way({**warm, "vibration": "1 g"}, how, "2 g"), sensors)
    names = [group.name for group in problem.groups]
    total = whole.source_variance.sum(axis=0)
    linear = ~np.array([bool(one.length_of) for one in problem.outputs])
    variance = whole.standard_uncertainty**2
    assert_allclose(total[linear], variance[linear], rtol=1e-9)
    for key in (*COEFFICIENTS, RECTIFICATION):
        place = names.index(f"gyro.{key}")
        assert (whole.source_variance[place] > 0.0).any()
        only = frozenset({f"gyro.{key}"})
        mission = way({**warm, "vibration": "1 g"}, how, "2 g")
        alone = law(mission, sensors, only=only)[1].standard_uncertainty ** 2
        part = whole.source_variance[place]
        kept = linear & (part > 1e-9 * variance)
        assert_allclose(part[kept], alone[kept], rtol=1e-6)


def test_all_coefficients_are_carried():
    """That of the rate is no more named as left out."""
    rate = "bias_temperature_rate_coefficient"
    sensors = triads({rate: 1e-9})
    size = in_use(TESTED, None, way({"temperature": "9 degC"}))
    warm = {"temperature": {"warm_up": {"by": "20 degC", "time": "50 s"}}}
    course = in_use(TESTED, None, way(warm))
    assert not_carried(sensors, size) == (f"gyro.{rate}",)
    assert not_carried(sensors, course) == ()
    # A residual over temperature counts in full, as with any temperature stated.
    over = triads({"bias_over_temperature": 1e-6})
    only = frozenset({"gyro.bias_over_temperature"})
    found = [law(way(said), over, only=only)[1] for said in ({}, warm)]
    one, other = (x.standard_uncertainty for x in found)
    assert_allclose(one, other, rtol=1e-12)
    assert one.any()


def test_steps_end_where_a_course_bends():
    """A profile that bends within a step: as dense points of the same, to 1e-9."""
    sensors = triads({"bias_temperature_coefficient": 1e-7})
    bends = [(0.0, 20.0), (13.0, 20.0), (17.0, 60.0), (71.0, 25.0), (200.0, 25.0)]
    t = np.arange(0.0, 200.5, 0.5)
    dense = np.stack([t, np.interp(t, *np.transpose(bends))], axis=1)

    def u(points):
        profile = [[f"{t:.9g} s", f"{T:.15g} degC"] for t, T in points]
        said = {"temperature": {"reference": "20 degC", "profile": profile}}
        only = frozenset({"gyro.bias_temperature_coefficient"})
        return law(way(said), sensors, only=only)[1].standard_uncertainty

    assert_allclose(u(bends), u(dense), rtol=1e-8)
    assert np.abs(u(bends) / u([*bends[:2], *bends[3:]]) - 1.0).max() > 0.01


def test_a_device_is_left_as_it_is():
    """Without a course nothing is another object; a line of 0 is no constant."""
    sensors = triads({"bias_temperature_coefficient": 0.0})
    assert on_the_way(sensors, TESTED) == (sensors, TESTED)
    warm = {"temperature": {"warm_up": {"by": "20 degC", "time": "50 s"}}}
    used = in_use(TESTED, None, way(warm))
    names = [one.name for one in constants_problem(sensors, used).outputs]
    assert not any("temperature" in name for name in names)
    assert replace(used).environment == used.environment
