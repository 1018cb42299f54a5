"""One temperature for all axes and both triads, and what waits for a later turn-on."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import (
    ACC_BIAS,
    ACC_SF,
    GYRO_ANGLE,
    GYRO_BIAS,
    GYRO_SF,
    NOWHERE,
    UNITS,
    assert_printed,
    at_sources,
    errors,
    line,
    procedure,
    simulated,
    triads,
)
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget import compare, load_procedure, load_requirement
from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import scheme_of
from budget.calibration.simulation import simulate
from budget.errors import SpecError
from budget.inputs import load_device
from budget.inputs.records import Device
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.methods.sobol import sobol
from budget.model.noise import GaussMarkov, stationary
from budget.model.windows import Schedule, Setting, Window
from budget.studies.allocation.allocate import allocate
from budget.studies.analysis import analyze
from budget.units import DEG_PER_HOUR, MICRO_G, PPM, STANDARD_GRAVITY

PER_HOUR = 1.0 / 3600.0  # degC/h [degC/s]
PER_MINUTE = 60.0  # one over degC/min [s/degC]
BT, KT = "bias_temperature_coefficient", "scale_factor_temperature_coefficient"
BR = "bias_temperature_rate_coefficient"
WARM = triads(
    {BT: 0.01 * DEG_PER_HOUR, BR: 0.5 * DEG_PER_HOUR * PER_MINUTE, KT: 20.0 * PPM},
    {BT: 10.0 * MICRO_G, BR: 50.0 * MICRO_G * PER_MINUTE, KT: 10.0 * PPM},
)
ENVIRONMENT = "environment.temperature."


def at(name, value, time=None):
    """Return a line of the environment, with its time."""
    taken = line(name, [value])
    return replace(taken, correlation_time=None if time is None else np.array([time]))


def of(*lines, **how):
    """Return a procedure in that environment."""
    return procedure(environment=lines, **how)


def test_a_ramp_of_scale_factors_has_the_printed_effects():
    """KT 100 ppm/degC at 1 degC/h: by the order of the axes, and a bias upside down."""
    sensors = triads({KT: 100.0 * PPM}, {KT: 100.0 * PPM})
    part = 1e-4  # of the ramp, for what is printed is to first order
    how = of(at("temperature.ramp", PER_HOUR))
    found = errors(sensors, how, environment__temperature__ramp=part * PER_HOUR) / part
    for value, printed in zip(
        found[GYRO_SF][[2, 0, 1]], ("0.5", "1.5", "2.5"), strict=True
    ):
        # Printed without the earth rate, which the turns have 1e-4 of.
        assert_allclose(value, float(printed), rtol=1e-4)
    for value, printed in zip(
        found[ACC_SF][[2, 0, 1]], ("16.617", "49.950", "83.283"), strict=True
    ):
        assert_printed(value, printed)
    for value in found[ACC_BIAS]:
        assert_printed(value, "-8.32457")
    assert np.abs(found[GYRO_ANGLE]).max() < 1e-3


@pytest.mark.parametrize(
    ("name", "value", "time"),
    [
        ("temperature.ramp", 50.0 * PER_HOUR, None),
        ("temperature.warm_up", 8.0, 150.0),
        ("temperature.warm_up", 8.0, 5.0),
    ],
)
def test_pulses_show_the_same_history(monkeypatch, name, value, time):
    """A simulated run with all three coefficients gives the closed form's errors."""
    how = of(at(name, value, time), dwell=20.0, sample_rate=100.0)
    full = f"environment.{name}"
    found = simulated(monkeypatch, WARM, how, full, [value])
    exact = errors(WARM, how, **{full.replace(".", "__"): value})
    assert np.abs(exact[GYRO_SF]).max() > 0.01
    assert np.abs(exact[ACC_BIAS]).max() > 0.5
    size = np.abs(exact).max()
    assert_allclose(found / size, exact / size, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("tau", "points"), [(40.0, (30.0, 200.0)), (1e-3, (95.0,))])
def test_pulses_show_the_same_soaks(monkeypatch, tau, points):
    """Soaks of different temperatures, slow and fast to settle, in both triads."""
    soak = replace(at("temperature.soak", 5.0, tau), points=np.array(points))
    how = of(soak, dwell=20.0, sample_rate=100.0)
    values = np.array([4.0, -7.0, 3.0])[: len(points) + 1]
    found = simulated(monkeypatch, WARM, how, "environment.temperature.soak", values)
    exact = errors(WARM, how, environment__temperature__soak=values)
    assert np.abs(exact[GYRO_SF]).max() > 0.01
    assert np.abs(exact[ACC_BIAS]).max() > 0.5
    size = np.abs(exact).max()
    assert_allclose(found / size, exact / size, rtol=1e-4, atol=1e-5)


def test_soaks_of_one_temperature_are_one():
    """Soaks that all have the same temperature leave what a constant one leaves.

    That is a shift of every bias by bT T and of every scale factor by kT T.
    """
    soak = replace(at("temperature.soak", 5.0, 40.0), points=np.array([30.0, 200.0]))
    how = of(soak, dwell=20.0)
    same = errors(WARM, how, environment__temperature__soak=np.full(3, 2.0))
    assert_allclose(same[GYRO_BIAS], 2.0 * 0.01, rtol=1e-3)
    assert_allclose(same[ACC_BIAS], 2.0 * 10.0, rtol=1e-3)
    assert_allclose(same[GYRO_SF], 2.0 * 20.0, rtol=1e-3)
    assert_allclose(same[ACC_SF], 2.0 * 10.0, rtol=1e-3)


def test_each_soak_is_drawn_on_its_own():
    """Gyros turned in the first soak: u(dk) = kT u; one after the test is nothing."""
    first = replace(at("temperature.soak", 0.5, 1.0), points=np.array([200.0, 9e4]))
    how = of(first, dwell=20.0)
    sensors = triads({KT: 100.0 * PPM})[:1]
    only = frozenset({"environment.temperature.soak"})
    law = propagate(calibration_problem(sensors, how, only=only))
    turning = law.standard_uncertainty[GYRO_SF] / PPM
    assert_allclose(turning, 50.0, rtol=1e-6)
    assert not law.C[:, -1].any()


def alone(sensors, how, **values):
    """Return the errors of one triad with sources at values [SI]."""
    problem = calibration_problem(sensors, how)
    return problem.evaluate(at_sources(problem, **values)[:, None])[:, 0]


def simulated_alone(monkeypatch, sensors, how, name, values):
    """Return those of a simulated run [SI]."""
    monkeypatch.setattr(
        "budget.calibration.simulation._values", lambda *_: np.array(values)
    )
    return simulate(sensors, how, run=0, only=frozenset({name}))


def test_what_a_turn_leaves_out_is_as_large_as_is_said(monkeypatch):
    """Accelerometers read in turns on a ramp: off by kT r L g/(2 pi n) at the most.

    Of one turn about a level axis it is all of that: (1/L) int r t g sin(2 pi t/L) dt;
    a turn back takes it away again, so there is none here.
    """
    turns = [
        Window(
            name=str(k),
            start=20.0 * (12 + k),
            length=18.0,
            setting=Setting(
                outer=0.0,
                middle=0.0,
                inner=0.0,
                turning=axis,
                angle=2.0 * np.pi,
            ),
            use="both",
        )
        for k, axis in enumerate((0, 1))
    ]
    faces = [
        Window(
            name=f"face {k}",
            start=20.0 * k,
            length=18.0,
            setting=Setting.face(axis, sign, azimuth),
            use="both",
        )
        for k, (axis, sign, azimuth) in enumerate(
            (a, s, z) for a in range(3) for s in (1, -1) for z in (0.0, np.pi)
        )
    ]
    rate, kT = 50.0 * PER_HOUR, 200.0 * PPM
    how = replace(
        of(at("temperature.ramp", rate), sample_rate=50.0),
        windows=(*faces, *turns),
        formulas="least_squares",
    )
    sensors = triads({KT: kT}, {KT: kT})[1:]
    name = "environment.temperature.ramp"
    found = simulated_alone(monkeypatch, sensors, how, name, [rate])
    exact = alone(sensors, how, environment__temperature__ramp=rate)
    g = how.gravity
    most = kT * rate * 18.0 * g / (2.0 * np.pi)
    scheme = scheme_of("accelerometer", how, sensors[0])
    turned = np.abs(scheme.weights[:, 3, 12:]).sum(axis=1)
    off = np.abs(found - exact)[9:]
    assert (off <= 1.01 * most * turned).all()
    assert off.max() > 0.2 * most * turned.max()  # and not nothing


RANDOM = of(at("temperature.sigma", 0.5, 1800.0), sample_rate=0.5)
ONLY = frozenset({ENVIRONMENT + "sigma"})
RUNS = 200


@cache
def drawn():
    """Return simulated runs of both triads in a random temperature."""
    return np.array([simulate(WARM, RANDOM, run=k, only=ONLY) for k in range(RUNS)])


@cache
def law_of_random():
    """Return the law of the same."""
    return propagate(calibration_problem(WARM, RANDOM, only=ONLY))


@pytest.mark.slow
def test_pulses_have_the_spread_of_a_random_temperature():
    """24 standard uncertainties agree with the law within the error of the runs."""
    law = law_of_random()
    off = np.std(drawn(), axis=0, ddof=1) / law.standard_uncertainty - 1.0
    assert np.abs(off).max() * np.sqrt(2.0 * (RUNS - 1)) < 4.5
    mean = np.mean(drawn(), axis=0) / law.standard_uncertainty
    assert np.abs(mean).max() * np.sqrt(RUNS) < 4.5


def correlations(covariance):
    """Return those of a gyro output with one of an accelerometer, (12, 12)."""
    u = np.sqrt(np.diag(covariance))
    u[u == 0.0] = 1.0
    return (covariance / np.outer(u, u))[:12, 12:]


@pytest.mark.slow
def test_both_triads_share_the_random_temperature():
    """Correlations of the triads agree; without a common history they would be 0."""
    exact = correlations(law_of_random().covariance)
    found = correlations(np.cov(drawn().T))
    error = (1.0 - exact**2) / np.sqrt(RUNS)
    assert np.abs((found - exact) / error).max() < 4.5
    assert np.abs(exact / error).max() > 20.0  # control: not those of nothing shared


def test_monte_carlo_and_indices_take_the_shared_temperature():
    """Draws have the law's joint covariance; the indices are those of one source."""
    problem = calibration_problem(WARM, RANDOM, only=ONLY)
    law, n = law_of_random(), 20_000
    some = sample(problem, trials=n, seed=3)
    off = some.standard_uncertainty / law.standard_uncertainty - 1.0
    assert np.abs(off).max() * np.sqrt(2.0 * n) < 4.5
    exact = correlations(law.covariance)
    error = (1.0 - exact**2) / np.sqrt(n)
    assert np.abs((correlations(some.covariance) - exact) / error).max() < 4.5
    both = calibration_problem(
        WARM, RANDOM, only=ONLY | {"accelerometer.bias_repeatability"}
    )
    found = sobol(both, samples=512)
    place = found.factors.index(ENVIRONMENT + "sigma")
    parts = propagate(both).source_variance
    share = (parts / parts.sum(axis=0))[[g.name for g in both.groups].index(*ONLY)]
    assert_allclose(found.total.value[place], share, rtol=0, atol=0.02)
    assert share[ACC_BIAS].max() < 0.5 < share[ACC_SF].min()


def test_window_means_of_a_stationary_process_are_those_of_the_closed_form():
    """The second difference of G is the covariance of the Gauss-Markov rows."""
    tau = 300.0
    windows = tuple(
        Window(name="", start=start, length=length)
        for start, length in ((0.0, 18.0), (18.0, 300.0), (400.0, 30.0))
    )
    schedule = Schedule(windows=windows)
    (C,) = stationary(
        schedule.starts,
        schedule.lengths,
        (lambda t: tau**2 * (np.abs(t) / tau + np.expm1(-np.abs(t) / tau)),),
        slice(0, len(schedule.windows)),
    )
    assert_allclose(C, GaussMarkov(1.0, tau).covariance(schedule), rtol=1e-10)


def test_a_later_temperature_is_met_at_the_next_turn_on_only():
    """Db = bT dT and dk = kT dT, one draw of dT for both triads."""
    how = of(at("temperature.mission", 20.0), dwell=5.0, sample_rate=20.0)
    only = frozenset({ENVIRONMENT + "mission"})
    for reference in ("nominal", "as_tested"):
        problem = calibration_problem(WARM, how, reference=reference, only=only)
        assert not propagate(problem).standard_uncertainty.any()
    problem = calibration_problem(WARM, how, reference="next_turn_on", only=only)
    law = propagate(problem)
    u = law.standard_uncertainty / UNITS
    assert_allclose(u[GYRO_BIAS], 0.2, rtol=1e-6)
    assert_allclose(u[ACC_BIAS], 200.0, rtol=1e-6)
    assert_allclose(u[GYRO_SF], 400.0, rtol=1e-3)
    assert_allclose(u[ACC_SF], 200.0, rtol=1e-3)
    assert_allclose(correlations(law.covariance)[9:, 9:], 1.0, rtol=1e-6)


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_pulses_show_the_same_changes(monkeypatch, reference):
    """What waits for a later turn-on is simulated under every error reference."""
    lines = {
        "bias_over_temperature": 3.0 * DEG_PER_HOUR,
        "scale_factor_over_temperature": 300.0 * PPM,
        "vibration_rectification": 0.5 * DEG_PER_HOUR / STANDARD_GRAVITY**2,
    }
    gyro, _ = triads(lines)
    how = of(
        at("vibration.test", 0.7 * STANDARD_GRAVITY),
        at("vibration.mission", 2.0 * STANDARD_GRAVITY),
        dwell=5.0,
        sample_rate=20.0,
    )
    names = [f"gyro.{name}" for name in lines]
    monkeypatch.setattr("budget.calibration.simulation._values", lambda one, *_: one.u)
    only = frozenset(names)
    problem = calibration_problem((gyro,), how, reference=reference, only=only)
    x = at_sources(
        problem,
        **{
            name.replace(".", "__"): value
            for name, value in zip(names, lines.values(), strict=True)
        },
    )
    exact = problem.evaluate(x[:, None])[:, 0] / UNITS[:12]
    found = simulate((gyro,), how, run=0, reference=reference, only=only) / UNITS[:12]
    assert_allclose(found, exact, rtol=1e-6, atol=1e-6)
    bias = {"nominal": 0.245, "as_tested": 0.0, "next_turn_on": 0.245 - 2.0 - 3.0}
    assert_allclose(exact[GYRO_BIAS], bias[reference], rtol=1e-3, atol=1e-6)


def test_a_vibration_alike_at_test_and_mission_cancels():
    """VRE a^2 is a bias of the test, and of the mission: the calibration holds it."""
    (gyro, _) = triads({"vibration_rectification": 1.0 * DEG_PER_HOUR / 9.8**2})
    how = of(at("vibration.test", 9.8), at("vibration.mission", 9.8))
    only = frozenset({"gyro.vibration_rectification"})
    for reference, size in (("nominal", 1.0), ("next_turn_on", 0.0)):
        law = propagate(
            calibration_problem((gyro,), how, reference=reference, only=only)
        )
        u = law.standard_uncertainty / UNITS[:12]
        assert_allclose(u[GYRO_BIAS], size, rtol=1e-6, atol=1e-9)
        assert_allclose(np.delete(u, np.r_[GYRO_BIAS]), 0.0, rtol=0, atol=2e-5)


def test_a_vibration_that_no_sensor_feels_is_said():
    """A known size without the line that it is multiplied by is named, else not."""
    how = of(at("vibration.test", 9.8))
    for lines, found in (({}, 1), ({"vibration_rectification": 1e-9}, 0)):
        gyro, _ = triads(lines)
        device = Device(
            name="one",
            gyro=gyro,
            accelerometer=None,
            figures=(),
            assumptions=(),
            origin=NOWHERE,
        )
        texts = analyze(device, procedure=how, validate=False).warnings
        said = [text for text in texts if text.startswith("environment vibration test")]
        assert len(said) == found


def read(tmp_path, environment):
    """Return the procedure of a file with that environment."""
    path = put(tmp_path / "p.yaml", f"latitude: 40 deg\nenvironment: {environment}\n")
    return load_procedure(path)


def test_a_file_says_the_times_beside_the_temperatures(tmp_path):
    """Each time belongs to its figure, and is printed with it."""
    one = read(
        tmp_path,
        "{temperature: {sigma: 0.5 degC, correlation_time: 30 min, warm_up: 8 degC, "
        "warm_up_time: 15 min}, vibration: {test: 0 g, mission: 1.5 g}}",
    )
    times = {line.name: line.correlation_time for line in one.environment}
    assert_allclose(times["temperature.sigma"], 1800.0, rtol=1e-15)
    assert_allclose(times["temperature.warm_up"], 900.0, rtol=1e-15)
    assert times["vibration.test"] is None
    (said,) = [text for text in one.assumptions if "temperature.sigma" in text]
    assert_says(said, "0.5 degC", "correlation time 30 min")


@pytest.mark.parametrize(
    ("environment", "words"),
    [
        ("{temperature: {sigma: 1 degC}}", "sigma: stands without correlation_time"),
        ("{temperature: {warm_up_time: 9 s}}", "warm_up_time: is of warm_up"),
        ("{temperature: {soak: 1 degC, settling_time: 9 s}}", "stands without soak_po"),
        (
            "{temperature: {soak: 1 K, settling_time: 9 s, soak_points: [9 s, 8 s]}}",
            "found '8 s' after '9 s', expected times that rise",
        ),
    ],
)
def test_a_temperature_without_its_time_is_refused(tmp_path, environment, words):
    """Neither is guessed, and no key is read that does nothing."""
    with pytest.raises(SpecError, match=words):
        read(tmp_path, environment)


@pytest.mark.parametrize(
    ("residual", "coefficient"),
    [
        (
            "bias_over_temperature: 3 deg/h",
            "bias_temperature_coefficient: 1 deg/h/degC",
        ),
        (
            "bias_over_temperature: 3 deg/h",
            "bias_temperature_rate_coefficient: 1 deg/h/(degC/min)",
        ),
        (
            "scale_factor_over_temperature: 9 ppm",
            "scale_factor_temperature_coefficient: 1 ppm/degC",
        ),
    ],
)
def test_a_residual_beside_its_coefficient_is_refused(tmp_path, residual, coefficient):
    """One effect is given once; either alone is read."""
    path = tmp_path / "d.yaml"
    for lines in ((residual,), (coefficient,), (residual, coefficient)):
        path.write_text(f"name: x\ngyro: {{errors: {{{', '.join(lines)}}}}}\n")
        if len(lines) == 1:
            assert load_device(path).gyro.lines
            continue
        with pytest.raises(SpecError, match=coefficient.partition(":")[0]):
            load_device(path)


COURSES = (
    at("temperature.ramp", 6.0 * PER_HOUR),
    at("temperature.sigma", 0.5, 1800.0),
    at("temperature.warm_up", 1.0, 600.0),
    replace(at("temperature.soak", 0.4, 60.0), points=np.array([40.0, 160.0])),
    at("temperature.mission", 0.5),
)
ALL = of(*COURSES, dwell=20.0, sample_rate=20.0)


def test_trials_and_indices_take_every_course_of_the_temperature():
    """Joint covariance of 24 outputs and shares of five shared sources, three ways."""
    problem = calibration_problem(
        WARM,
        ALL,
        reference="next_turn_on",
        only=frozenset(ENVIRONMENT + one.name.partition(".")[2] for one in COURSES),
    )
    law, n = propagate(problem), 20_000
    some = sample(problem, trials=n, seed=5)
    off = some.standard_uncertainty / law.standard_uncertainty - 1.0
    assert np.abs(off).max() * np.sqrt(2.0 * n) < 4.5
    exact = correlations(law.covariance)
    error = (1.0 - exact**2) / np.sqrt(n)
    assert np.abs((correlations(some.covariance) - exact) / error).max() < 4.5
    assert np.abs(exact / error).max() > 20.0  # control: the triads share it
    found = sobol(problem, samples=512)
    parts = law.source_variance
    share = parts / parts.sum(axis=0)
    order = [[g.name for g in problem.groups].index(name) for name in found.factors]
    assert_allclose(found.total.value, share[order], rtol=0, atol=0.03)
    named = [g.name for g in problem.groups]
    for one in COURSES:  # each of them counts somewhere
        assert share[named.index(f"environment.{one.name}")].max() > 0.01


@pytest.mark.parametrize("name", ["six-positions", "norm-icosahedron"])
@pytest.mark.parametrize("course", ["temperature.ramp", "temperature.sigma"])
def test_any_estimator_takes_the_temperature(name, course):
    """Weighted and by the norm: 60 simulated runs have the law's spread."""
    how = replace(load_procedure(name), sample_rate=0.1)
    if name == "six-positions":
        how = replace(how, formulas="weighted")
    one = at(course, 2.0 * PER_HOUR if "ramp" in course else 0.5, 1800.0)
    how = replace(how, environment=(one,))
    (sensor,) = triads({}, {BT: 10.0 * MICRO_G, KT: 10.0 * PPM})[1:]
    only = frozenset({f"environment.{course}"})
    law = propagate(calibration_problem((sensor,), how, only=only))
    runs = 60
    found = np.array([simulate((sensor,), how, run=k, only=only) for k in range(runs)])
    seen = law.standard_uncertainty > 1e-3 * law.standard_uncertainty[:3].max()
    off = np.sqrt((found**2).mean(axis=0))[seen] / law.standard_uncertainty[seen] - 1.0
    assert np.abs(off).max() * np.sqrt(2.0 * runs) < 4.5
    assert seen[:3].all()


@pytest.mark.slow
def test_compare_allocate_and_analyze_agree_in_a_full_environment(tmp_path):
    """One budget: the utilisation of a limit is the same from every command."""
    station = put(
        tmp_path / "station.yaml",
        "station: {levelling: {east: 20 arcsec}, mount: 5 arcsec}\n"
        "environment: {temperature: {ramp: 1 degC/h, sigma: 0.5 degC, "
        "correlation_time: 30 min, warm_up: 2 degC, warm_up_time: 15 min, "
        "soak: 1 degC, soak_points: [20 min], settling_time: 5 min, mission: 15 degC}, "
        "vibration: {test: 0 g, mission: 1 g}, age: 6 months}\n",
    )
    device = put(
        tmp_path / "device.yaml",
        "name: one\ngyro:\n  errors:\n"
        "    bias_repeatability: 0.3 deg/h\n    bias_stability: 0.05 deg/h\n"
        "    angle_random_walk: 0.005 deg/sqrt(h)\n"
        "    scale_factor_repeatability: 20 ppm\n"
        "    mounting_repeatability: 5 arcsec\n"
        "    bias_temperature_coefficient: 0.01 deg/h/degC\n"
        "    scale_factor_temperature_coefficient: 3 ppm/degC\n"
        "    vibration_rectification: 0.05 deg/h/g^2\n"
        "    ageing: {value: 0.2 deg/h, horizon: 1 year, law: drift}\n"
        "    scale_factor_ageing: {value: 30 ppm, horizon: 1 year, law: drift}\n",
    )
    limits = put(
        tmp_path / "limits.yaml",
        "name: l\nlimits: {gyro: {bias: 2 deg/h, scale_factor: 200 ppm}}\n",
    )
    one, wanted = load_device(device), load_requirement(limits)
    how = load_procedure(station=station)
    (row,) = compare([one], wanted, [how], method="gum").devices
    budget = analyze(
        one, procedure=how, requirement=wanted, reference="next_turn_on", validate=False
    )
    (judged,) = budget.assessment.sensors
    shared = {
        part.source.owner
        for out in budget.outputs
        for part in out.contributions
        if part.share > 1e-3
    }
    assert {"environment", "gyro"} <= shared
    assert_allclose(row.utilisation, judged.utilisation, rtol=1e-9)
    allocated = allocate(
        one, requirement=wanted, procedure=how, catalogue=(), validate=False
    )
    now = max(out.now for out in allocated.outputs)
    assert_allclose(now, judged.utilisation, rtol=1e-6)
