"""Sources beyond the paper: printed check values, and pulses against closed forms."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from builders import (
    ACC_ANGLE,
    ACC_BIAS,
    ACC_SF,
    GYRO_ANGLE,
    GYRO_BIAS,
    GYRO_SF,
    NOWHERE,
    UNITS,
    asked,
    assert_printed,
    at_sources,
    errors,
    line,
    paper_accelerometer,
    paper_gyro,
    procedure,
    sensor,
    simulated,
    triads,
)
from numpy.testing import assert_allclose, assert_array_equal
from reading import assert_says
from scipy.special import ndtri

from budget import load_procedure
from budget.calibration import simulation
from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.errors import CallError
from budget.inputs.records import Device, Limit, Requirement
from budget.methods.gum import propagate
from budget.model.windows import Setting, Window
from budget.names import Name
from budget.studies.allocation.cases import Bounds, set_up, solve
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, PPM, STANDARD_GRAVITY

DEG_PER_HOUR_PER_G = DEG_PER_HOUR / STANDARD_GRAVITY
PER_HOUR = 1.0 / 3600.0  # degC/h [degC/s]


def test_an_unknown_line_is_an_error_and_no_noise():
    """A line that the table does not have is refused with what there is."""
    odd = paper_gyro(bias_wobble=1e-6)
    with pytest.raises(CallError, match=r"gyro\.bias_wobble"):
        calibration_problem((odd,), procedure())
    with pytest.raises(CallError, match=r"gyro\.bias_wobble"):
        simulate((odd,), procedure(dwell=1.0, sample_rate=10.0), run=0)


def test_g_sensitivity_takes_g_for_a_bias():
    """G_iz = 1 deg/h/g: db_i = 0.998985 deg/h, nothing else anywhere."""
    sensors = triads({"g_sensitivity": np.full(9, 1.0 * DEG_PER_HOUR_PER_G)})
    G = np.zeros((3, 3))
    G[:, 2] = 1.0 * DEG_PER_HOUR_PER_G
    found = errors(sensors, procedure(), gyro__g_sensitivity=G.ravel())
    for value in found[GYRO_BIAS]:
        assert_printed(value, "0.998985")
    others = np.delete(found, np.r_[GYRO_BIAS])
    assert_allclose(others, np.zeros(21), rtol=0, atol=1e-12)


def test_g_sensitivity_of_the_horizontal_axes_is_not_felt():
    """With z up all the time, and whole turns, G_ix and G_iy reach nothing."""
    sensors = triads({"g_sensitivity": np.full(9, 1.0 * DEG_PER_HOUR_PER_G)})
    G = np.ones((3, 3)) * DEG_PER_HOUR_PER_G
    G[:, 2] = 0.0
    found = errors(sensors, procedure(), gyro__g_sensitivity=G.ravel())
    assert_allclose(found, np.zeros(24), rtol=0, atol=1e-12)


def test_pulses_show_the_same_g_sensitivity(monkeypatch):
    """A simulated run with all nine elements gives the closed form's errors."""
    G = np.arange(1.0, 10.0) * DEG_PER_HOUR_PER_G
    sensors = triads({"g_sensitivity": G})
    how = procedure(dwell=20.0, sample_rate=20.0, turns=2)
    found = simulated(monkeypatch, sensors, how, "gyro.g_sensitivity", G)
    exact = errors(sensors, how, gyro__g_sensitivity=G)
    assert np.abs(exact).max() > 8.0
    assert_allclose(found, exact, rtol=1e-7, atol=1e-7)


def test_second_order_scale_factor_looks_like_a_bias():
    """K2 10 ug/g^2: db = 9.97934 ug, dk = 0.12 ppm on every axis."""
    K2 = 10.0 * MICRO_G / STANDARD_GRAVITY**2
    sensors = triads(None, {"scale_factor_quadratic": K2})
    found = errors(sensors, procedure(), accelerometer__scale_factor_quadratic=K2)
    for db, dk in zip(found[ACC_BIAS], found[ACC_SF], strict=True):
        assert_allclose(db, 9.97934, rtol=0, atol=2e-4)  # printed without the angles
        assert_allclose(dk, 0.12, rtol=1e-4)
    assert_allclose(found[:12], np.zeros(12), rtol=0, atol=0)


def test_third_order_scale_factor_looks_like_a_scale_factor():
    """K3 10 ug/g^3: dk = 9.98078 ppm, db = 0.119752 ug on every axis."""
    K3 = 10.0 * MICRO_G / STANDARD_GRAVITY**3
    sensors = triads(None, {"scale_factor_cubic": K3})
    found = errors(sensors, procedure(), accelerometer__scale_factor_cubic=K3)
    for db, dk in zip(found[ACC_BIAS], found[ACC_SF], strict=True):
        assert_allclose(db, 0.119752, rtol=1e-4)
        assert_allclose(dk, 9.98078, rtol=1e-6)
    assert_allclose(found[:12], np.zeros(12), rtol=0, atol=0)


@pytest.mark.parametrize(("line", "order"), [("quadratic", 2), ("cubic", 3)])
def test_pulses_show_the_same_higher_orders(monkeypatch, line, order):
    """A simulated run with three coefficients gives the closed form's errors."""
    K = np.array([10.0, -200.0, 3000.0]) * MICRO_G / STANDARD_GRAVITY**order
    sensors = triads(None, {f"scale_factor_{line}": np.abs(K)})
    how = procedure(dwell=5.0, sample_rate=20.0)
    name = f"accelerometer.scale_factor_{line}"
    found = simulated(monkeypatch, sensors, how, name, K)
    exact = errors(sensors, how, **{f"accelerometer__scale_factor_{line}": K})
    assert np.abs(exact[ACC_BIAS if order == 2 else ACC_SF]).min() > 9.0
    assert_allclose(found, exact, rtol=1e-7, atol=1e-7)


def test_second_and_third_order_of_a_gyro_have_the_printed_effects():
    """A turn shows dk = K3 Omega^2 and dk = 2 K2 (b + earth rate); angles -d dk."""
    rate, w = np.radians(20.0), np.array([0.0, 12.434358, 8.462886]) * DEG_PER_HOUR
    K3 = 4.0 * 30.0 * PPM / np.radians(300.0) ** 2  # 30 ppm of 300 deg/s, best line
    K2 = 2.0 * 30.0 * PPM / np.radians(300.0)
    sensors = triads({"scale_factor_quadratic": K2, "scale_factor_cubic": K3})
    found = errors(sensors, procedure(), gyro__scale_factor_cubic=K3)
    for dk in found[GYRO_SF]:
        assert_printed(dk, "0.533")
    assert_allclose(found[GYRO_ANGLE], -2.0 * K3 * rate**2, rtol=2e-3)
    assert np.abs(found[GYRO_BIAS]).max() < 1e-5
    fast = errors(sensors, procedure(rate=300.0), gyro__scale_factor_cubic=K3)
    assert_allclose(fast[GYRO_SF], 120.0, rtol=1e-6)

    found = errors(sensors, procedure(), gyro__scale_factor_quadratic=K2)
    dk = 2.0 * K2 * (2.5 * DEG_PER_HOUR + w) / PPM
    assert_allclose(found[GYRO_SF], dk, rtol=1e-4)  # angles let in other turns


@pytest.mark.parametrize(("name", "order"), [("quadratic", 2), ("cubic", 3)])
def test_pulses_show_the_same_higher_orders_of_a_gyro(monkeypatch, name, order):
    """A simulated run of gyros, whose inputs turn, gives the closed form's errors."""
    K = np.array([1.0, -20.0, 300.0]) * 1e-4
    sensors = triads({f"scale_factor_{name}": np.abs(K)})
    how = procedure(dwell=5.0, sample_rate=20.0, latitude=-40.0)
    found = simulated(monkeypatch, sensors, how, f"gyro.scale_factor_{name}", K)
    exact = errors(sensors, how, **{f"gyro__scale_factor_{name}": K})
    assert np.abs(exact[GYRO_SF]).min() > (0.002 if order == 2 else 10.0)
    assert_allclose(found, exact, rtol=1e-7, atol=1e-7)


def asymmetric(gyro=50e-6, accelerometer=50e-6):
    """Return both triads with an asymmetry by the sign of the input."""
    return tuple(
        replace(
            one,
            lines=tuple(
                replace(line, form="input")
                if line.name == "scale_factor_asymmetry"
                else line
                for line in one.lines
            ),
        )
        for one in triads(
            {"scale_factor_asymmetry": gyro}, {"scale_factor_asymmetry": accelerometer}
        )
    )


def test_asymmetry_by_the_sign_of_the_input_has_the_printed_effects():
    """Ka 50 ppm on both triads: Ka g/2 is a bias of the accelerometers."""
    found = errors(
        asymmetric(),
        procedure(),
        gyro__scale_factor_asymmetry=50e-6,
        accelerometer__scale_factor_asymmetry=50e-6,
    )
    for dk, printed in zip(
        found[GYRO_SF], ("8.680556e-4", "5.185541e-3", "3.806558e-3"), strict=True
    ):
        assert_printed(dk, printed)
    assert np.abs(found[GYRO_ANGLE]).max() < 1e-5
    for db, printed in zip(
        found[GYRO_BIAS], ("1.86677e-4", "1.86667e-4", "2.74030e-4"), strict=True
    ):
        assert_printed(db, printed)
    for db, dk in zip(found[ACC_BIAS], found[ACC_SF], strict=True):
        assert_printed(db, "24.9737")
        assert_printed(dk, "0.150152")


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
@pytest.mark.parametrize("turned", [False, True])
def test_pulses_show_the_same_asymmetry_by_the_input(monkeypatch, owner, turned):
    """Also where an input changes its sign within a turn, at another bias."""
    Ka = np.array([100.0, -300.0, 500.0]) * PPM
    how = rolling() if turned else procedure(dwell=5.0, sample_rate=200.0)
    how = replace(how, sample_rate=400.0)
    name = f"{owner}.scale_factor_asymmetry"
    found = simulated(monkeypatch, asymmetric(), how, name, Ka)
    exact = errors(asymmetric(), how, **{name.replace(".", "__"): Ka})
    size = np.array([1e-3] * 3 + [1e-5] * 6 + [1e-3] * 3 + [1e-1] * 12)
    assert np.abs(exact[:12] if owner == "gyro" else exact[12:]).max() > 1e-3
    assert_allclose(found / size, exact / size, rtol=1e-6, atol=2e-3)


def test_the_law_of_an_asymmetry_takes_a_side_where_an_input_is_nothing():
    """Without a bias the level faces have no input: no corner stops the law."""
    plain = sensor("accelerometer", {"scale_factor_asymmetry": 50e-6})
    law = propagate(calibration_problem((plain,), procedure()))
    u = law.standard_uncertainty / UNITS[12:]
    assert_allclose(u[9:], 50e-6 * 9.7966933092 / 2.0 / MICRO_G, rtol=1e-9)
    assert_allclose(u[:9], np.zeros(9), rtol=0, atol=1e-9)


def test_a_curve_over_a_full_scale_is_found_with_the_higher_order(monkeypatch):
    """A tumble that estimates K3 finds the nonlinearity's too; pulses agree."""
    how = load_procedure("dividing-head")
    how = replace(how, sample_rate=1.0)
    K3 = 30.0 * MICRO_G / STANDARD_GRAVITY**3
    curved = replace(line("scale_factor_nonlinearity", K3), form="cubic")
    sensors = (sensor("accelerometer", [curved, line("scale_factor_cubic", 2.0 * K3)]),)
    for reference, seen in (("nominal", 3.0), ("as_tested", 0.0)):
        problem = calibration_problem(sensors, how, reference=reference)
        x = at_sources(
            problem,
            accelerometer__scale_factor_nonlinearity=K3,
            accelerometer__scale_factor_cubic=2.0 * K3,
        )
        found = problem.evaluate(x[:, None])[:, 0]
        order = [output.name.quantity for output in problem.outputs]
        third = found[[k for k, name in enumerate(order) if name == "third_order"]]
        assert_allclose(third, seen * K3, rtol=1e-9, atol=1e-12 * K3)
        rest = [k for k, name in enumerate(order) if name != "third_order"]
        assert_allclose(found[rest], 0.0, rtol=0, atol=1e-11)

        monkeypatch.setattr(simulation, "_values", lambda line, *_: line.u)
        drawn = simulate(sensors, how, run=0, reference=reference)
        assert_allclose(drawn, found, rtol=1e-6, atol=1e-10)


BT_GYRO = 0.01 * DEG_PER_HOUR
BT_ACCELEROMETER = 10.0 * MICRO_G
WARM = triads(
    {"bias_temperature_coefficient": BT_GYRO},
    {"bias_temperature_coefficient": BT_ACCELEROMETER},
)


def ramp(**how):
    """Return a procedure with an unknown ramp of 1 degC/h."""
    return procedure(environment=(line("temperature.ramp", [PER_HOUR]),), **how)


def test_a_shared_temperature_ramp_has_the_printed_effects():
    """1 degC/h: a rotation of all errors by the order of the windows."""
    found = errors(WARM, ramp(), environment__temperature__ramp=PER_HOUR)
    for value in found[GYRO_SF]:
        assert_printed(value, "-3.472222e-4")
    # What is printed leaves out dk (b + input), 1e-9 deg/h, and ddT w.
    assert_allclose(found[GYRO_BIAS], 1.966667e-3, rtol=2e-6)
    for value in found[ACC_SF]:
        assert_printed(value, "-0.834180")
    # The off-diagonal element, less the angle's part of dk.
    assert_allclose(np.abs(found[ACC_ANGLE]), 0.172062, rtol=2e-5)
    for value, printed in zip(
        found[ACC_BIAS][[2, 0, 1]], ("1.6717", "5.0050", "8.3383"), strict=True
    ):
        assert_printed(value, printed)


def test_a_shared_source_correlates_both_triads():
    """Two outputs that only the ramp reaches are the same number, up to its sign."""
    only = frozenset({"environment.temperature.ramp"})
    law = propagate(calibration_problem(WARM, ramp(), only=only))
    u = law.standard_uncertainty
    correlation = law.covariance / np.outer(u, u)
    signs = np.sign(errors(WARM, ramp(), environment__temperature__ramp=PER_HOUR))
    assert_allclose(correlation, np.outer(signs, signs), rtol=1e-9)


def test_pulses_show_the_same_ramp(monkeypatch):
    """A simulated run gives the closed form's errors of both triads."""
    how = ramp(dwell=20.0, sample_rate=20.0)
    value = [50.0 * PER_HOUR]
    found = simulated(monkeypatch, WARM, how, "environment.temperature.ramp", value)
    exact = errors(WARM, how, environment__temperature__ramp=value)
    assert_allclose(found, exact, rtol=1e-6, atol=1e-7)


def test_without_coefficients_a_ramp_reaches_nothing():
    """A device that gives no coefficient feels no temperature, and says 0."""
    law = propagate(
        calibration_problem(
            triads(), ramp(), only=frozenset({"environment.temperature.ramp"})
        )
    )
    assert_allclose(law.covariance, np.zeros((24, 24)), rtol=0, atol=0)


def test_turn_angle_reaches_the_scale_factors_only():
    """1 arcsec at each turn on its own: u(dk) = 0.545611 ppm; angles get none."""
    how = procedure(station=(line("turn_angle", [1.0 * ARCSEC]),))
    only = frozenset({"station.turn_angle"})
    u = propagate(calibration_problem(triads(), how, only=only)).standard_uncertainty
    u = u / UNITS
    for value in u[GYRO_SF]:
        # sqrt(2) arcsec/(4 pi) = 0.5456071 ppm; 0.545611 is printed elsewhere.
        assert_allclose(value, np.sqrt(2.0) * ARCSEC / (4.0 * np.pi) / PPM, rtol=1e-9)
        assert_allclose(value, 0.545611, rtol=1e-5)
    # Two turns miss independently: dd = d (dk_a - dk_i), 2 arcsec times 1e-6.
    assert_allclose(u[GYRO_ANGLE], 2.0 * np.sqrt(2.0) * u[0] * PPM, rtol=1e-6)
    assert_allclose(u[12:], np.zeros(12), rtol=0, atol=0)


def test_turn_angle_takes_dk_times_the_standing_input_for_a_bias():
    """Db = -dk (b + input) - ddT w: with w_v and the nominal bias of 2.5 deg/h."""
    how = procedure(station=(line("turn_angle", [1.0 * ARCSEC]),))
    eps = np.array([3.0, -1.0, 2.0, 0.5, -2.0, 1.0]) * ARCSEC  # z+ z- x+ x- y+ y-
    found = errors(triads(), how, station__turn_angle=eps)
    # The - turn turns by -(2 pi) + eps: the difference of both adds the two.
    dk = (eps[0::2] - eps[1::2])[[1, 2, 0]] / (4.0 * np.pi)
    assert_allclose(found[GYRO_SF], dk / PPM, rtol=1e-9)
    standing = 2.5 + np.array([-2.0 * ARCSEC * 8.462886, 2.0 * ARCSEC * 8.462886, 0])
    standing[2] += 8.462886
    # For x and y the error of the response to z follows the angle, not dk.
    w = 8.462886 * np.array([-2.0, 2.0, 0.0]) * ARCSEC
    exact = -dk * (standing - w) - dk * w
    assert_allclose(found[GYRO_BIAS], exact, rtol=1e-4)


def test_pulses_show_the_same_turn_angle(monkeypatch):
    """Turns that end a little late give the closed form's errors."""
    how = procedure(
        dwell=5.0, sample_rate=50.0, station=(line("turn_angle", [1.0 * ARCSEC]),)
    )
    eps = np.array([3.0, -1.0, 2.0, 0.5, -2.0, 1.0]) * 100.0 * ARCSEC
    found = simulated(monkeypatch, triads(), how, "station.turn_angle", eps)
    exact = errors(triads(), how, station__turn_angle=eps)
    assert np.abs(exact[GYRO_SF]).min() > 50.0
    # Left out: the earth rate over the part of a turn that is too much, 2e-4 of dk.
    assert_allclose(found[GYRO_SF], exact[GYRO_SF], rtol=1e-3)
    assert_allclose(found[GYRO_ANGLE], exact[GYRO_ANGLE], rtol=0, atol=0.05)
    assert_allclose(found[GYRO_BIAS], exact[GYRO_BIAS], rtol=1e-3)
    assert_allclose(found[12:], exact[12:], rtol=0, atol=1e-6)


def rolling(**more):
    """Return six faces, then turns about all axes, some of which one triad reads."""
    steps = [
        (Setting.face(axis, sign), "both") for axis in range(3) for sign in (1, -1)
    ]
    for use in ("gyro", "both", "accelerometer"):
        for axis in range(3):
            for sense in (1, -1):
                turn = Setting(inner=0.3, turning=axis, angle=sense * 2.0 * np.pi)
                steps.append((turn, use))
    windows = tuple(
        Window(name=str(k), start=20.0 * k, length=18.0, setting=setting, use=use)
        for k, (setting, use) in enumerate(steps)
    )
    plain = procedure(sample_rate=50.0)
    return replace(plain, windows=windows, formulas="least_squares", **more)


def test_an_accelerometer_feels_where_a_turn_about_a_level_axis_ends(monkeypatch):
    """Eps adds g eps/(2 pi) along the force at the end; pulses of both triads agree."""
    how = rolling(station=(line("turn_angle", [1.0 * ARCSEC]),))
    eps = np.random.default_rng(5).normal(0.0, 100.0 * ARCSEC, 18)
    exact = errors(triads(), how, station__turn_angle=eps)
    found = simulated(monkeypatch, triads(), how, "station.turn_angle", eps)
    one = calibration_problem((paper_accelerometer(),), how)
    alone = one.evaluate(at_sources(one, station__turn_angle=eps)[:, None])[:, 0]

    assert_allclose(alone / UNITS[12:], exact[12:], rtol=1e-9)
    assert_allclose(found[GYRO_SF], exact[GYRO_SF], rtol=1e-3)
    assert_allclose(found[ACC_SF], exact[ACC_SF], rtol=0, atol=0.1)
    assert_allclose(found[ACC_ANGLE], exact[ACC_ANGLE], rtol=0, atol=0.02)
    assert_allclose(found[ACC_BIAS], exact[ACC_BIAS], rtol=0, atol=0.1)
    assert np.abs(exact[ACC_BIAS]).max() > 1.0  # ug
    assert np.abs(exact[ACC_ANGLE]).max() > 0.2  # arcsec


@pytest.mark.parametrize("name", ["scale_factor_quadratic", "scale_factor_cubic"])
def test_powers_of_what_turns_are_means_over_the_turn(monkeypatch, name):
    """The mean of a square is not the square of a mean: g^2/2 about a level axis."""
    values = np.array([20.0, -10.0, 15.0]) * MICRO_G / 10.0**2
    sensors = triads(None, {name: 1e-7})
    exact = errors(sensors, rolling(), **{f"accelerometer__{name}": values})
    found = simulated(monkeypatch, sensors, rolling(), f"accelerometer.{name}", values)

    assert_allclose(found, exact, rtol=1e-6, atol=1e-6)
    assert np.abs(exact).max() > 1.0


def test_levelling_about_east_reaches_the_bias_of_the_vertical_gyro():
    """phi_E 60 arcsec: db_z = -3.617011e-3 deg/h; all else below second order."""
    phi = 60.0 * ARCSEC
    how = procedure(station=(line("levelling.east", [phi]),))
    found = errors(triads(), how, station__levelling__east=phi)
    # Printed to first order, -w_h phi; to second -w_v phi^2/2 = -3.6e-7 deg/h.
    assert_allclose(found[11], -3.617011e-3 - 8.462886 * phi**2 / 2.0, rtol=1e-6)
    # phi^2/2 of gravity: -0.0423 ppm, and that times the bias of 6 mg.
    assert_allclose(found[ACC_SF], -0.0423, rtol=0, atol=5e-5)
    assert_allclose(found[ACC_BIAS], 0.0423e-6 * 6000.0, rtol=2e-3)
    others = np.delete(found, np.r_[11:15, ACC_BIAS])
    assert_allclose(others, np.zeros(others.size), rtol=0, atol=2e-5)


def test_levelling_about_north_is_removed_by_the_second_half_turn():
    """phi_N 60 arcsec: no gyro bias, no angle; the scale factor's phi^2/2 stays."""
    phi = 60.0 * ARCSEC
    how = procedure(station=(line("levelling.north", [phi]),))
    found = errors(triads(), how, station__levelling__north=phi)
    assert_allclose(found[ACC_SF], -0.0423, rtol=0, atol=5e-5)
    others = found[:12]
    assert_allclose(others, np.zeros(12), rtol=0, atol=2e-5)
    assert_allclose(found[ACC_ANGLE], np.zeros(6), rtol=0, atol=2e-5)


@pytest.mark.parametrize("axis", ["east", "north"])
def test_pulses_show_the_same_levelling(monkeypatch, axis):
    """A table that is half a degree off level gives the closed form's errors."""
    phi = [0.5 * 3600.0 * ARCSEC]
    how = procedure(
        dwell=5.0, sample_rate=200.0, station=(line(f"levelling.{axis}", phi),)
    )
    found = simulated(monkeypatch, triads(), how, f"station.levelling.{axis}", phi)
    exact = errors(triads(), how, **{f"station__levelling__{axis}": phi})
    assert np.abs(exact[ACC_SF]).min() > 30.0
    assert_allclose(found, exact, rtol=1e-6, atol=1e-6)


def test_a_drop_of_the_level_is_one_number_for_both_triads():
    """Levelling is one draw: the gyro's bias z, the accelerometer's phi^2/2."""
    phi = 60.0 * ARCSEC
    how = procedure(station=(line("levelling.east", [phi]),))
    only = frozenset({"station.levelling.east"})
    problem = calibration_problem(triads(), how, only=only)
    assert problem.normals_per_trial == 1
    law = propagate(problem)
    u = law.standard_uncertainty / UNITS
    assert_allclose(u[11], 3.617011e-3, rtol=1e-5)
    # phi^2/2 of a normal phi: standard deviation phi^2/sqrt(2).
    assert_allclose(u[12:15], phi**2 / np.sqrt(2.0) / PPM, rtol=1e-4)


def test_allocation_leaves_a_shared_source_its_part_of_a_limit():
    """k^2 (f^2 u^2 + u_turn^2) = L^2: what is left of the limit goes to the line."""
    u, turn, limit = 1e-6, 1.0 * ARCSEC, 1.5e-6
    sensor = replace(paper_gyro(), lines=(line("scale_factor_repeatability", u),))
    requirement = Requirement(
        name="one",
        coverage=0.95,
        reference="nominal",
        limits=tuple(
            Limit(
                output=Name("scale_factor", owner="gyro", axis=axis),
                limit=limit,
                printed="1.5 ppm",
            )
            for axis in "xyz"
        ),
        caps=(),
        assumptions=(),
        origin=NOWHERE,
    )
    how = procedure(station=(line("turn_angle", [turn]),))
    bounds = Bounds(held=frozenset(), least={}, most={})
    case = set_up(asked(sensor, procedure=how, requirement=requirement), bounds, {})
    solved = solve(case, "proportional", None)
    shared = np.sqrt(2.0) * turn / (4.0 * np.pi)
    k = ndtri(0.975)
    exact = np.sqrt((limit / k) ** 2 - shared**2) / u
    assert_allclose(solved.factors, [exact, 1.0], rtol=1e-6)


def test_a_device_whose_triads_share_a_source_is_judged_jointly():
    """Both limits fall at one size of the ramp: together 90 %, not 0.9 times 0.9."""
    small = 1e-6  # of what the ramp makes, so that every line is given and none counts
    lines = {
        "bias_repeatability": small * DEG_PER_HOUR,
        "bias_stability": small * DEG_PER_HOUR,
        "angle_random_walk": 1e-12,
        "scale_factor_repeatability": 1e-12,
        "mounting_repeatability": 1e-12,
    }
    gyro = sensor("gyro", lines | {"bias_temperature_coefficient": BT_GYRO})
    lines = lines | {"velocity_random_walk": 1e-12}
    del lines["angle_random_walk"]
    accelerometer = sensor(
        "accelerometer", lines | {"bias_temperature_coefficient": BT_ACCELEROMETER}
    )
    how = ramp()
    unit = errors((gyro, accelerometer), how, environment__temperature__ramp=PER_HOUR)
    k = ndtri(0.95)  # |r| below k has a probability of 0.9
    limits = tuple(
        Limit(
            output=Name("bias", owner=owner, axis="x"),
            limit=k * abs(unit[place]) * UNITS[place],
            printed="",
        )
        for owner, place in (("gyro", 9), ("accelerometer", 21))
    )
    wanted = Requirement(
        name="shared",
        coverage=0.95,
        reference="nominal",
        limits=limits,
        caps=(),
        assumptions=(),
        origin=NOWHERE,
    )
    device = Device(
        name="one",
        gyro=gyro,
        accelerometer=accelerometer,
        figures=(),
        assumptions=(),
        origin=NOWHERE,
    )
    found = compare([device], wanted, [how], trials=100_000)
    standard_error = np.sqrt(0.9 * 0.1 / 100_000)
    (pair,) = found.imus
    for probability in (*(one.conformance for one in found.devices), pair.conformance):
        assert abs(probability.value - 0.9) < 5.0 * standard_error
    assert abs(pair.conformance.value - 0.81) > 50.0 * standard_error  # a product


def test_every_source_can_be_sent_to_another_process():
    """A Problem with every kind of disturbance gives the same bits after pickling."""
    sensors = (
        paper_gyro(
            scale_factor_asymmetry=1e-4,
            g_sensitivity=np.full(9, DEG_PER_HOUR_PER_G),
            bias_temperature_coefficient=BT_GYRO,
        ),
        paper_accelerometer(
            scale_factor_quadratic=1e-6, bias_temperature_coefficient=BT_ACCELEROMETER
        ),
    )
    how = ramp(
        station=(line("turn_angle", [1e-6]), line("levelling.east", [1e-5])),
    )
    problem = calibration_problem(sensors, how, reference="next_turn_on")
    x = np.random.default_rng(1).normal(size=(problem.n_inputs, 5)) * 1e-6
    sent = pickle.loads(pickle.dumps(problem))  # noqa: S301 - our own bytes
    assert_array_equal(sent.evaluate(x), problem.evaluate(x))
    assert [g.name.owner for g in sent.groups] == [g.name.owner for g in problem.groups]


def test_what_nothing_feels_is_said_with_what_it_takes():
    """A ramp without coefficients, a coefficient without a ramp, turns of no gyro."""

    def warned(sensors, how):
        device = Device(
            name="one",
            gyro=next((s for s in sensors if s.kind == "gyro"), None),
            accelerometer=next((s for s in sensors if s.kind != "gyro"), None),
            figures=(),
            assumptions=(),
            origin=NOWHERE,
        )
        return analyze(device, procedure=how, validate=False).warnings

    (text,) = warned(triads(), ramp())
    assert text.startswith("environment temperature ramp ")
    assert_says(text, "affects no", "bias_temperature_coefficient")
    both = warned(WARM, procedure())
    assert [text.partition(" is given")[0] for text in both] == [
        "gyro bias temperature coefficient",
        "accelerometer bias temperature coefficient",
    ]
    turned = procedure(station=(line("turn_angle", [1e-6]),))
    (text,) = warned((paper_accelerometer(),), turned)
    assert text.startswith("station turn angle is given")
    assert warned(WARM, ramp()) == ()  # what is felt is not named


def test_asymmetry_by_the_input_needs_no_other_line():
    """A device that gives nothing else: Ka/2 w_v of the vertical gyro, by the law."""
    only = replace(line("scale_factor_asymmetry", 50e-6), form="input")
    law = propagate(calibration_problem((sensor("gyro", [only]),), procedure()))

    w_v = procedure().place.earth[2]
    assert_allclose(law.standard_uncertainty[11], 25e-6 * w_v, rtol=2e-4)
