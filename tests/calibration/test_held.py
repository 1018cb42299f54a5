"""Parameters that nobody calibrates: wrong by what the design does not know."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from builders import UNITS, line, procedure, triads
from numpy.testing import assert_allclose, assert_array_equal

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import answered, estimated
from budget.calibration.simulation import simulate
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.model.windows import Setting, Window
from budget.names import Name, parameters_of
from budget.units import ARCSEC, DEG_PER_HOUR, PPM

REFERENCES = ("nominal", "as_tested", "next_turn_on")
TWO = ("gyro", "accelerometer")
NAMES = [*parameters_of("gyro"), *parameters_of("accelerometer")]
HELD = (
    *(Name("bias", owner="gyro", axis=axis) for axis in "xyz"),
    Name("scale_factor", owner="accelerometer", axis="y"),
    Name("mounting_angle", owner="accelerometer", axis="xz"),
)
PLACES = [NAMES.index(name) for name in HELD]
U = np.array([0.05, 0.05, 0.05, 37.0, 2.0])  # repeatability of each, as printed


def plan(held=HELD, **more):
    """Return six faces and six turns of both triads, with parameters held."""
    faces = [
        Window(name=f"{k}", start=60.0 * k, length=60.0, setting=Setting.face(*face))
        for k, face in enumerate(product(range(3), (1, -1)))
    ]
    turns = load_procedure("six-positions-and-turns").windows
    after = [
        replace(one, start=one.start + 1e4, use="gyro") for one in turns if one.sense
    ]
    how = procedure(formulas="least_squares", sample_rate=2.0, **more)
    return replace(how, windows=(*faces, *after), held=held)


def law(how, reference="next_turn_on", sensors=None):
    """Return the law for every parameter of both triads."""
    problem = calibration_problem(
        triads() if sensors is None else sensors, how, reference=reference, every=True
    )
    assert [output.name for output in problem.outputs] == NAMES
    return propagate(problem)


@pytest.mark.parametrize(
    ("reference", "times"),
    [("nominal", 0.0), ("as_tested", 1.0), ("next_turn_on", 1.0)],
)
def test_a_held_parameter_has_its_repeatability_once(reference, times):
    """Design less the value of the reference: u, once; 0 from the design itself."""
    found = law(plan(), reference)
    u = found.standard_uncertainty / UNITS
    # The products of a scale factor with itself are of 37 ppm of it.
    assert_allclose(u[PLACES], times * U, rtol=1e-4, atol=1e-12)


def test_what_is_estimated_has_it_twice():
    """Control: of the same lines a found bias has sqrt(2) u, and more by noise."""
    u = law(plan(held=())).standard_uncertainty / UNITS
    assert (u[PLACES] > 1.4 * U).all()


@pytest.mark.parametrize("reference", REFERENCES)
def test_other_outputs_do_not_know_that_held_ones_are_asked_for(reference):
    """Without the option the same numbers come out, to the last bit."""
    how = plan()
    few, every = (
        calibration_problem(triads(), how, reference=reference, every=asked)
        for asked in (False, True)
    )
    places = [NAMES.index(one) for kind in TWO for one in estimated(kind, how)]
    assert len(places) == len(NAMES) - len(HELD)
    x = np.linspace(-1e-6, 1e-6, 3 * few.mean.size).reshape(-1, 3)
    assert_array_equal(few.evaluate(x), every.evaluate(x)[places])
    assert_array_equal(propagate(few).C, propagate(every).C[places])


MORE = triads(
    {
        "g_sensitivity": np.full(9, DEG_PER_HOUR / 9.80665),
        "bias_over_temperature": 1e-6,
    },
    {"scale_factor_nonlinearity": 90.0 * PPM, "vibration_rectification": 1e-6},
)
SHAKEN = (line("vibration.test", [1.0]), line("vibration.mission", [3.0]))


@pytest.mark.parametrize("reference", REFERENCES)
@pytest.mark.parametrize("shipped", ["", "norm-and-turns-by-hand"])
def test_pulses_show_the_same_errors_of_what_is_held(monkeypatch, reference, shipped):
    """A simulated run with known values has the errors of the function."""
    shipped_how = replace(load_procedure("norm-and-turns-by-hand"), sample_rate=2.0)
    how = (
        replace(shipped_how, environment=SHAKEN)
        if shipped
        else plan(environment=SHAKEN)
    )
    monkeypatch.setattr(
        "budget.calibration.simulation._values", lambda one, *_: 1.0 * one.u
    )
    names = frozenset(
        Name(one.name, owner=sensor.kind)
        for sensor in MORE
        for one in sensor.lines
        if one.correlation_time is None
        and "walk" not in one.name
        and "noise" not in one.name
    )
    problem = calibration_problem(
        MORE, how, reference=reference, only=names, every=True
    )
    given = {
        Name(one.name, owner=sensor.kind): one.u
        for sensor in MORE
        for one in sensor.lines
    }
    x = problem.mean.copy()
    for group, rows in zip(problem.groups, problem.slices, strict=True):
        if group.name in names:
            x[rows] = np.resize(given[group.name], x[rows].size)
    exact = problem.evaluate(x[:, None])[:, 0] / UNITS
    found = simulate(MORE, how, run=0, reference=reference, only=names, every=True)
    held = [k for k, one in enumerate(NAMES) if one in how.held]
    assert len(held) > 2
    assert_allclose(found[held] / UNITS[held], exact[held], rtol=1e-9, atol=1e-9)
    if not shipped:  # what is found there is tested with its scheme
        assert_allclose(found / UNITS, exact, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("reference", REFERENCES)
def test_a_triad_without_any_window_is_wrong_by_its_lines(reference):
    """Gyros beside a test of accelerometers alone: what the design does not know."""
    how = plan(held=())
    how = replace(how, windows=tuple(one for one in how.windows if not one.sense))
    how = replace(
        how,
        windows=tuple(replace(one, use="accelerometer") for one in how.windows),
        station=(line("positioning", [3.0 * ARCSEC]), line("edge_jitter", [1e-3])),
        environment=(line("temperature.ramp", [1.0 / 3600.0]),),
    )
    assert estimated("gyro", how) == ()
    assert answered("gyro", how) == parameters_of("gyro")
    found = law(how, reference)
    u = found.standard_uncertainty / UNITS
    times = 0.0 if reference == "nominal" else 1.0
    wanted = times * np.array([50.0] * 3 + [2.0] * 6 + [0.05] * 3)
    assert_allclose(u[:12], wanted, rtol=1e-4, atol=1e-12)
    alone = propagate(calibration_problem(triads()[1:], how, reference=reference))
    assert_allclose(u[12:], alone.standard_uncertainty / UNITS[12:], rtol=1e-12)
    drawn = simulate(triads(), how, run=3, reference=reference, every=True)
    assert (drawn[:12] == 0.0).all() == (reference == "nominal")
