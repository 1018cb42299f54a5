"""What a unit has from its making: found by a calibration, met without one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import UNITS, line, triads
from numpy.testing import assert_allclose, assert_array_equal

from budget.calibration.mission import mission_outputs
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import calibrates
from budget.calibration.simulation import simulate
from budget.errors import CallError
from budget.inputs import load_mission, load_procedure, uncalibrated
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.missing.expected import expecting, lacking_of_mission
from budget.model.sources import lines_of
from budget.names import Name, parameters_of
from budget.units import DEG_PER_HOUR, MICRO_G, PPM

REFERENCES = ("nominal", "as_tested", "next_turn_on")
NAMES = [*parameters_of("gyro"), *parameters_of("accelerometer")]
PAPER_U = np.array(
    [50.0] * 3 + [2.0] * 6 + [0.05] * 3 + [37.0] * 3 + [2.0] * 6 + [37.0] * 3
)
NEW_U = np.array(
    [3e4] * 3 + [4000.0] * 6 + [72000.0] * 3 + [2e4] * 3 + [5000.0] * 6 + [5e4] * 3
)
LINES = ("initial_scale_factor", "initial_mounting", "initial_bias")


def new(sensors=None):
    """Return both triads of the paper with the tolerances of a new unit."""
    found = []
    for sensor in sensors or triads():
        u = NEW_U * UNITS
        u = u[:12] if sensor.kind == "gyro" else u[12:]
        initial = [
            line(name, part)
            for name, part in zip(LINES, np.split(u, [3, 9]), strict=True)
        ]
        found.append(sensor.with_lines((*sensor.lines, *initial)))
    return tuple(found)


def u_of(sensors, how, reference="next_turn_on", only=None):
    """Return the law's u of every parameter, as printed."""
    problem = calibration_problem(
        sensors, how, reference=reference, every=True, only=only
    )
    return propagate(problem).standard_uncertainty / UNITS


def test_a_sensor_keeps_what_it_has_from_its_making_apart():
    """Initial lines are none of the lines of a calibration, and stay beside them."""
    (gyro, _) = new()
    assert [one.name for one in gyro.lines] == [one.name for one in triads()[0].lines]
    assert {one.name for one in gyro.initial} == {*LINES}
    again = gyro.with_lines(gyro.lines[:2])
    assert again.initial == gyro.initial
    assert not any("initial" in name for name in again.not_given)


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize(
    "shipped", ["zhao-2019", "six-positions-and-turns", "norm-nine-positions"]
)
def test_a_calibration_finds_them(reference, shipped):
    """With tolerances of 3 % and 20 deg/s every estimated number stays to the bit."""
    how = load_procedure(shipped)
    plain, found = (
        calibration_problem(
            tuple(one for one in sensors if calibrates(one.kind, how)),
            how,
            reference=reference,
        )
        for sensors in (triads(), new())
    )
    assert [g.name for g in plain.groups] == [g.name for g in found.groups]
    assert_array_equal(propagate(plain).C, propagate(found).C)
    x = np.linspace(-1e-6, 1e-6, 2 * plain.mean.size).reshape(-1, 2)
    assert_array_equal(plain.evaluate(x), found.evaluate(x))


def test_without_calibration_they_count_once():
    """Nobody calibrates: u^2 = tolerance^2 + repeatability^2, each of them once."""
    u = u_of(new(), uncalibrated("none"))
    # Of a scale factor 1/(1 + k) - 1: the law's second order, k^2 = 9e-4 of it.
    assert_allclose(u, np.hypot(NEW_U, PAPER_U), rtol=2e-3)
    assert_allclose(u_of(new(), uncalibrated("none"), "nominal"), 0.0, atol=1e-12)


def test_a_maker_has_found_them():
    """Factory: what is new at a turn-on counts once, from the making nothing."""
    u = u_of(new(), uncalibrated("factory"))
    assert_allclose(u, PAPER_U, rtol=1e-4)


def test_what_one_scale_factor_cannot_hold_stays():
    """A nonlinearity counts once without a test, and after one as much.

    Of which range it is a percentage nobody says, so that no part of it is in a scale
    factor. Against the test itself nothing stays.
    """
    sensors = triads({"scale_factor_nonlinearity": 300.0 * PPM})
    only = frozenset({Name("scale_factor_nonlinearity", owner="gyro")})
    for word in ("none", "factory"):
        u = u_of(sensors, uncalibrated(word), only=only)
        assert_allclose(u[:3], 300.0, rtol=1e-4)
    tested = u_of(sensors, load_procedure(), only=only)
    assert_allclose(tested[:3], 300.0, rtol=1e-4)
    itself = u_of(sensors, load_procedure(), "as_tested", only=only)
    assert_allclose(itself[:3], 0.0, atol=1e-6)


def test_only_the_lines_of_the_device_count_without_a_test():
    """No noise of a test, no station: of the paper's lines the repeatabilities alone.

    The environment of the later turn-on stays: a temperature by its coefficient, a
    vibration by its square, an age.
    """
    station = {
        "station": {"positioning": "3 arcsec"},
        "environment": {
            "temperature": {"ramp": "1 degC/h", "mission": "20 degC"},
            "vibration": {"test": "1 g", "mission": "3 g"},
            "age": "1 year",
        },
    }
    how = uncalibrated("factory", station=station)
    assert how.station == ()
    kept = [one.name for one in how.environment]
    assert sorted(kept) == ["age", "temperature.mission", "vibration.mission"]
    assert not any("ramp" in text or "position" in text for text in how.assumptions)
    sensors = triads(
        {"bias_temperature_coefficient": 0.01 * DEG_PER_HOUR},
        {"vibration_rectification": 10.0 * MICRO_G / 9.80665**2},
    )
    environment = (
        line("temperature.mission", [20.0]),
        line("vibration.mission", [3.0 * 9.80665]),
    )
    u = u_of(sensors, replace(how, environment=environment))
    assert_allclose(u[9:12], np.hypot(0.05, 0.2), rtol=1e-4)
    assert_allclose(u[21:], np.hypot(37.0, 90.0), rtol=1e-4)


def test_trials_and_pulses_agree_without_any_test():
    """Of 4000 trials, and 300 runs of pulses, the spread is that of the lines."""
    how = uncalibrated("none")
    problem = calibration_problem(new(), how, reference="next_turn_on", every=True)
    wanted = np.hypot(NEW_U, PAPER_U)
    drawn = sample(problem, trials=4000, seed=3).standard_uncertainty / UNITS
    # 5 standard errors of a normal sample.
    assert_allclose(drawn, wanted, rtol=5.0 / np.sqrt(2.0 * 3999))
    runs = [
        simulate(new(), how, run=run, reference="next_turn_on", every=True)
        for run in range(300)
    ]
    found = np.std(runs, axis=0, ddof=1) / UNITS
    assert_allclose(found, wanted, rtol=5.0 / np.sqrt(2.0 * 299))
    assert (np.abs(found / PAPER_U - 1.0) > 1.0).all()  # control


def test_held_parts_of_a_calibration_have_them_and_found_ones_do_not(monkeypatch):
    """A test that holds one bias meets its tolerance there, and what leans on it."""
    held = (Name("bias", owner="accelerometer", axis="x"),)
    how = load_procedure("six-positions-and-turns")
    how = replace(how, held=held, sample_rate=2.0)
    x = NAMES.index(held[0])
    only = frozenset(Name(name, owner=one.kind) for one in triads() for name in LINES)
    u = u_of(new(), how, only=only)
    assert_allclose(u[x], NEW_U[x], rtol=1e-9)
    own = [k for k, name in enumerate(NAMES) if name.quantity == "bias" and k != x]
    assert_allclose(u[own], 0.0, atol=1e-9)
    monkeypatch.setattr(
        "budget.calibration.simulation._values", lambda one, *_: 0.01 * one.u
    )
    problem = calibration_problem(
        new(), how, reference="next_turn_on", every=True, only=only
    )
    values = problem.mean.copy()
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        if group.name in only:
            values[rows] = 0.01 * np.sqrt(np.diag(group.covariance))
    exact = problem.evaluate(values[:, None])[:, 0] / UNITS
    found = simulate(new(), how, run=0, reference="next_turn_on", every=True, only=only)
    assert_allclose(exact[x], -0.01 * NEW_U[x], rtol=1e-9)
    assert_allclose(found / UNITS, exact, rtol=1e-6, atol=1e-6)


def test_what_is_not_printed_of_a_new_unit_is_a_lower_bound():
    """On a mission without a test it lacks its tolerances; after one it lacks nothing.

    Where nothing moves mounting and scale factor of accelerometers see gravity.
    """
    bench = load_mission("bench")
    outputs = mission_outputs(bench, (60.0,))[:2]
    for how, lacks in (
        (uncalibrated("none"), {*LINES}),
        (uncalibrated("factory"), set()),
        (load_procedure(), set()),
    ):
        sensors = [
            expecting(one.with_lines(one.lines), how, "next_turn_on", every=True)
            for one in triads()
        ]
        found = lacking_of_mission(sensors, how, bench, outputs)
        assert {name.quantity for one in found.values() for name in one} == lacks
    how = uncalibrated("none")
    given = [expecting(one, how, "next_turn_on", every=True) for one in new()]
    assert not any(lacking_of_mission(given, how, bench, outputs).values())


def test_no_word_but_these_stands_for_a_procedure():
    """Another word is refused, and every initial line is one of both triads."""
    with pytest.raises(CallError, match="none or factory"):
        uncalibrated("maker")
    for kind in ("gyro", "accelerometer"):
        known = [one.name for one in lines_of(kind) if one.is_initial]
        assert {*known} == {*LINES}
