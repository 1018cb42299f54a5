"""What a unit adds to its readings by itself, at the inputs of a mission."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import line, paper_accelerometer, paper_gyro, procedure, triads
from numpy.testing import assert_allclose

from budget.calibration.mission import (
    Sensing,
    constants_problem,
    mission_outputs,
    mission_problem,
    not_carried,
)
from budget.calibration.simulation import simulate
from budget.earth import ROTATION_RATE, normal_gravity
from budget.inputs import load_mission, load_procedure, uncalibrated
from budget.methods.gum import propagate
from budget.model.response import tilt_matrix
from budget.model.source import Disturbance
from budget.model.sources import SOURCES
from budget.units import DEG_PER_HOUR, DEGREE, MICRO_G, PPM, STANDARD_GRAVITY

LATITUDE = np.radians(34.2394)
G = float(normal_gravity(LATITUDE))
EARTH = ROTATION_RATE * np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
LEVEL, REST = np.array([0.0, 0.0, G]), EARTH
G_UNIT = DEG_PER_HOUR / STANDARD_GRAVITY
UG2, UG3 = MICRO_G / STANDARD_GRAVITY**2, MICRO_G / STANDARD_GRAVITY**3
HOW = procedure(gravity=G, dwell=5.0, sample_rate=20.0)


def read(sensor, form, name, value):
    """Return the triad with one line alone, of that value and meaning."""
    one = replace(line(name, value), form=form)
    return replace(sensor, lines=(one,))


def error(sensor, rate, force, how=HOW):
    """Return the error of what a calibrated triad senses, its one line at its u.

    Calibrated less true, shape (3,) [SI].
    """
    both = triads()
    sensors = tuple(sensor if one.kind == sensor.kind else one for one in both)
    sensors = tuple(one if one is sensor else replace(one, lines=()) for one in sensors)
    constants = constants_problem(sensors, how)
    (own,) = sensor.lines
    x = constants.mean.copy()
    (group,) = constants.groups
    x[: group.size] = own.u
    names = [output.name for output in constants.outputs]
    places = [k for k, name in enumerate(names) if name.owner == sensor.kind]
    found = constants.evaluate(x[:, None])[places, 0]
    columns = Sensing.of(sensor).columns([names[k] for k in places], rate, force)
    return columns @ found


def straight(sensor):
    """Return it without nominal values: closed forms of one axis."""
    return replace(sensor, nominal_bias=np.zeros(3), nominal_mounting_angle=np.zeros(6))


GYRO, ACCELEROMETER = straight(paper_gyro()), straight(paper_accelerometer())


def test_a_level_mission_after_a_level_test_has_no_g_sensitivity_left():
    """Static test: db_i = G_iz g; level 0, upside down 2 G g, in a turn -G_ix a."""
    elements = np.arange(1.0, 10.0) * G_UNIT
    gyro = read(GYRO, "", "g_sensitivity", elements)
    by_axis = elements.reshape(3, 3)
    level = error(gyro, REST, LEVEL)
    assert_allclose(level, 0.0, rtol=0, atol=1e-12 * G_UNIT * G)
    assert_allclose(error(gyro, REST, -LEVEL), 2.0 * G * by_axis[:, 2], rtol=1e-9)
    turn = error(gyro, REST, LEVEL + np.array([3.0, 0.0, 0.0]))
    assert_allclose(turn, -3.0 * by_axis[:, 0], rtol=1e-9)


def test_without_a_test_g_sensitivity_acts_in_full():
    """Nobody calibrates: -G f, of all nine elements."""
    elements = np.arange(1.0, 10.0) * G_UNIT
    gyro = read(GYRO, "", "g_sensitivity", elements)
    force = np.array([1.0, 2.0, G])
    for word in ("none", "factory"):
        found = error(gyro, REST, force, uncalibrated(word))
        assert_allclose(found, -elements.reshape(3, 3) @ force, rtol=1e-12)


def test_a_level_accelerometer_shows_a_false_bias_by_its_square():
    """K2 g^2 of the axes that are level, nothing of the one that is tested there."""
    sensor = read(ACCELEROMETER, "", "scale_factor_quadratic", 10.0 * UG2)
    found = error(sensor, REST, LEVEL)
    assert_allclose(found[:2], 10.0 * UG2 * G**2, rtol=1e-9)
    assert_allclose(found[2], 0.0, rtol=0, atol=1e-9 * MICRO_G)
    # And at 2 g it misses K2 (4 g^2 - g^2).
    twice = error(sensor, REST, 2.0 * LEVEL)
    assert_allclose(twice[2], -30.0 * UG2 * G**2, rtol=1e-9)


def test_a_level_accelerometer_shows_a_false_bias_by_its_asymmetry():
    """Ka g/2 of the level axes; of the vertical one nothing, at 3 g -Ka g."""
    sensor = read(ACCELEROMETER, "", "scale_factor_asymmetry", 50.0 * PPM)
    found = error(sensor, REST, LEVEL)
    assert_allclose(found[:2], 25.0 * PPM * G, rtol=1e-9)
    assert_allclose(found[2], 0.0, rtol=0, atol=1e-9 * MICRO_G)
    assert_allclose(error(sensor, REST, 3.0 * LEVEL)[2], -50.0 * PPM * G, rtol=1e-9)


def test_a_cubic_shows_beyond_the_rate_of_the_test():
    """-k3 (w^2 - Omega^2) w, Omega = 20 deg/s: nothing at that rate itself."""
    k3 = 4.0 * 30.0 * PPM / (300.0 * DEGREE) ** 2
    gyro = read(GYRO, "", "scale_factor_cubic", k3)
    for rate in (20.0, 300.0):
        w = rate * DEGREE
        found = error(gyro, np.array([w, 0.0, 0.0]), LEVEL)[0]
        wanted = -k3 * (w**2 - (20.0 * DEGREE) ** 2) * w
        # Beside the test's rate that of the earth, and what it leaves in the bias.
        assert_allclose(found, wanted, rtol=1e-5, atol=1e-6 * k3 * w**3)
    assert_allclose(wanted / (300.0 * DEGREE), -119.4667 * PPM, rtol=1e-4)


@pytest.mark.parametrize("form", ["turn", "input"])
def test_a_gyro_asymmetry_is_that_of_the_rate_it_meets(form):
    """-(Ka/2) |w| in either sense, by either convention: the test has hidden none."""
    gyro = read(GYRO, form, "scale_factor_asymmetry", 50.0 * PPM)
    for w in (5.0 * DEGREE, -5.0 * DEGREE):
        found = error(gyro, np.array([0.0, w, 0.0]), LEVEL)[1]
        assert_allclose(found, -25.0 * PPM * abs(w), rtol=1e-3)


def test_an_order_that_is_estimated_leaves_nothing():
    """A test that finds K2 has it in no bias: the mission is right at every force."""
    sensor = read(ACCELEROMETER, "", "scale_factor_quadratic", 10.0 * UG2)
    how = load_procedure("twenty-four-positions")
    found = error(sensor, REST, 2.0 * LEVEL, replace(how, orders=(2,)))
    assert_allclose(found, 0.0, rtol=0, atol=1e-6 * MICRO_G)
    without = error(sensor, REST, 2.0 * LEVEL, how)
    assert np.abs(without).max() > 5.0 * MICRO_G  # control


def test_a_temperature_that_changes_on_the_way_is_named():
    """Coefficients and histories are; what another one at the start does is carried."""
    both = triads(
        {
            "bias_temperature_coefficient": 1e-9,
            "bias_temperature_rate_coefficient": 1e-9,
        },
        {"scale_factor_temperature_coefficient": 1e-6},
    )
    ramp = line("temperature.ramp", [1.0 / 3600.0])
    there = (ramp, line("temperature.mission", [20.0]), line("age", [1e7]))
    rate = "gyro.bias_temperature_rate_coefficient"
    for environment, names in (
        ((), {*ALL, rate}),
        ((ramp,), {*ALL, rate, "environment.temperature.ramp"}),
        (there, {rate, "environment.temperature.ramp"}),
    ):
        found = not_carried(both, procedure(environment=environment))
        assert {*found} == names
        assert not_carried(triads(), procedure(environment=environment)) == ()


ALL = (
    "gyro.bias_temperature_coefficient",
    "accelerometer.scale_factor_temperature_coefficient",
)
LINES = {
    ("gyro", "g_sensitivity"): np.arange(1.0, 10.0) * G_UNIT,
    ("gyro", "scale_factor_quadratic"): 30.0 * PPM / DEGREE,
    ("gyro", "scale_factor_cubic"): 0.3 * PPM / DEGREE**2,
    ("gyro", "scale_factor_asymmetry"): 400.0 * PPM,
    ("accelerometer", "scale_factor_quadratic"): 30.0 * UG2,
    ("accelerometer", "scale_factor_cubic"): 20.0 * UG3,
    ("accelerometer", "scale_factor_asymmetry"): 200.0 * PPM,
}


@pytest.mark.parametrize(("kind", "name"), LINES)
@pytest.mark.parametrize("form", ["", "input"])
def test_a_unit_calibrated_by_pulses_is_wrong_by_that(monkeypatch, kind, name, form):
    """Its reading, compensated by what the pulses gave, misses the truth by as much.

    With biases and angles of the paper, at a rate and a force of neither test.
    """
    if form and "asymmetry" not in name:
        pytest.skip("it has one convention")
    sensor = next(one for one in triads() if one.kind == kind)
    sensor = read(sensor, form, name, LINES[kind, name])
    monkeypatch.setattr(
        "budget.calibration.simulation._values", lambda one, *_: 1.0 * one.u
    )
    errors = simulate((sensor,), HOW, run=0, reference="as_tested")
    rate = np.array([3.0, -7.0, 11.0]) * DEGREE
    force = np.array([1.5, -2.5, 12.0])
    v = rate if kind == "gyro" else force

    M = np.eye(3) + tilt_matrix(sensor.nominal_mounting_angle)
    x = M @ v + sensor.nominal_bias
    (own,) = sensor.lines
    u = own.u
    added = {
        "g_sensitivity": lambda: u.reshape(3, 3) @ force,
        "scale_factor_quadratic": lambda: u * x**2,
        "scale_factor_cubic": lambda: u * x**3,
        "scale_factor_asymmetry": lambda: 0.5 * u * np.abs(x),
    }[name]()
    K = 1.0 + errors[:3]
    M_found = np.eye(3) + tilt_matrix(sensor.nominal_mounting_angle + errors[3:9])
    shown = np.linalg.solve(M_found, (x + added) / K - sensor.nominal_bias - errors[9:])
    wanted = v - shown  # calibrated less true is what is taken off too much
    found = error(sensor, rate, force)
    size = np.abs(added).max()
    assert_allclose(found, wanted, rtol=0, atol=3e-3 * size)
    assert np.abs(wanted).max() > 0.1 * size  # control


def test_every_term_of_a_device_says_what_it_does_in_use():
    """A disturbance by a line of a device that a test alone has would be forgotten."""
    for source in SOURCES:
        for kind in ("gyro", "accelerometer"):
            for effect in (source.effect, *source.forms.values()):
                if source.like(kind) and isinstance(effect, Disturbance):
                    added = effect.in_use(np.ones(3), np.ones(3))
                    assert added.shape == (3, len(source.axes))


def test_on_the_bench_a_level_test_leaves_no_g_sensitivity():
    """A mission at rest has none of it; without a test it is a bias G g."""
    at_test = {"latitude": "34.2394 deg", "height": "0 m"}
    stand = {
        "alignment": "perfect",
        "altitude": "aided",
        "segments": [{"stand": "1 h"}],
    }
    bench = load_mission({"name": "bench", "mission": at_test | stand})
    outputs = mission_outputs(bench, (600.0,))
    elements = np.zeros(9)
    elements[2::3] = G_UNIT
    only = (read(GYRO, "", "g_sensitivity", elements), replace(ACCELEROMETER, lines=()))
    bias = read(GYRO, "", "bias_repeatability", G_UNIT * G)
    drift = (bias, only[1])

    def u(sensors, how):
        problem = mission_problem(sensors, how, bench, outputs)
        return propagate(problem).standard_uncertainty

    tested, free = u(only, HOW), u(only, uncalibrated("none"))
    assert_allclose(free, u(drift, uncalibrated("none")), rtol=1e-9, atol=1e-12)
    assert_allclose(tested, 0.0, rtol=0, atol=1e-9 * free.max())
