"""The test station: axes, encoders, base and mount of a three-axis table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from acting import UNITS, assert_printed, errors, simulated, triads
from builders import NOWHERE, line, paper_accelerometer, procedure
from numpy.testing import assert_allclose
from saying import assert_says

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.methods.gum import propagate
from budget.model.sources import SOURCES, STATION
from budget.model.sources.rotation import Rotation
from budget.model.windows import Setting, Window
from budget.names import parameters_of
from budget.spec.records import Device
from budget.studies.analysis import analyze
from budget.units import ARCSEC

TWO = ("gyro", "accelerometer")
NAMES = [*parameters_of("gyro"), *parameters_of("accelerometer")]
W_H, W_V = 12.434358, 8.462886  # of the earth rate [deg/h]
STOPS = [
    *("turns", "180", "270", "450"),
    *(
        f"{axis} {way} {visit}"
        for axis in "zxy"
        for way in ("up", "down")
        for visit in "12"
    ),
]
GEOMETRY = [one.name for one in SOURCES if isinstance(one.effect, Rotation)]


def moved(name, value=ARCSEC, least=2e-5, **how):
    """Return what moves, by output; of gyro biases what is above least [deg/h]."""
    plan = procedure(station=(line(name, ARCSEC),), **how)
    found = errors(triads(), plan, **{f"station__{name.replace('.', '__')}": value})
    # Below these are products of 1 arcsec and nominal angles of 2 arcsec.
    floor = {"scale_factor": 1e-4, "mounting_angle": 1e-4, "bias": least}
    return {
        str(n).replace("mounting_angle.", ""): e
        for n, e in zip(NAMES, found, strict=True)
        if abs(e) > (1e-3 if n == f"accelerometer.bias.{n.axis}" else floor[n.quantity])
    }


# Sensitivities of first order, arcsec for arcsec.
TABLE = {
    "orthogonality.outer_middle": ("gyro.yx", "accelerometer.yx", "accelerometer.zx"),
    "orthogonality.middle_inner": ("gyro.xz", "accelerometer.yz"),
    "encoder_zero.middle": ("gyro.xy", "accelerometer.zy"),
    "encoder_zero.inner": (
        *("gyro.yx", "gyro.zx"),
        *("accelerometer.yx", "accelerometer.zx"),
    ),
    "levelling.north": (),
    "azimuth": (),
}


@pytest.mark.parametrize("name", TABLE)
def test_geometry_moves_these_angles_and_nothing_else(name):
    """One arcsec is one arcsec of the angles of the table, to 1e-5 of it."""
    assert moved(name) == pytest.approx(
        dict.fromkeys(TABLE[name], 1.0), rel=1e-5, abs=0
    )


@pytest.mark.parametrize(
    ("axis", "pairs"),
    [(0, ("yx", "zx")), (1, ("xy", "zy")), (2, ("xz", "yz"))],
)
def test_a_turned_mount_turns_both_triads_as_a_whole(axis, pairs):
    """m_x: yx = zx = 1 arcsec in gyros and accelerometers alike; y and z likewise."""
    found = moved("mount", np.eye(3)[axis] * ARCSEC)
    wanted = {f"{kind}.{p}": 1.0 for kind in ("gyro", "accelerometer") for p in pairs}
    assert found == pytest.approx(wanted, rel=1e-5, abs=0)


def test_a_tilt_about_east_moves_the_vertical_gyro():
    """Of 1 arcsec db_z = -6.02835e-5 deg/h, and the angles not at all."""
    found = moved("levelling.east")
    assert found.keys() == {"gyro.bias.z"}
    assert_printed(found["gyro.bias.z"], "-6.02835e-5")


def test_without_the_repeat_a_tilt_is_an_angle():
    """Six positions: 60 arcsec about east are 60.000 of yx and zx; north: of zy."""
    faces = [(2, 1), (2, -1), (0, 1), (0, -1), (1, 1), (1, -1)]
    windows = tuple(
        Window(name=str(k), start=60.0 * k, length=60.0, setting=Setting.face(*face))
        for k, face in enumerate(faces)
    )
    for axis, pairs in (("east", ("yx", "zx")), ("north", ("zy",))):
        tilt = (line(f"levelling.{axis}", 60.0 * ARCSEC),)
        plan = replace(procedure(station=tilt), windows=windows)
        plan = replace(plan, formulas="least_squares")
        one = calibration_problem((paper_accelerometer(),), plan)
        u = propagate(one).C[:, -1] * 60.0  # arcsec for each arcsec
        angles = {n.axis: c for n, c in zip(NAMES[3:9], u[3:9], strict=True)}
        for pair in pairs:
            assert_allclose(angles.pop(pair), 60.0, rtol=0, atol=1e-3)
        assert_allclose(list(angles.values()), 0.0, rtol=0, atol=1e-3)


def stop(which, axis):
    """Return the value of `positioning` with one axis off by 1 arcsec at one stop."""
    value = np.zeros(3 * len(STOPS))
    value[3 * STOPS.index(which) + ("outer", "middle", "inner").index(axis)] = ARCSEC
    return value


@pytest.mark.parametrize(
    ("which", "axis", "wanted"),
    [
        ("180", "outer", {"gyro.bias.x": -W_H / 4.0}),
        ("270", "outer", {"gyro.bias.y": W_H / 4.0}),
        ("450", "outer", {"gyro.bias.y": -W_H / 4.0}),
        ("180", "middle", {"gyro.bias.x": -W_V / 4.0}),
        ("180", "inner", {"gyro.bias.y": W_V / 4.0, "gyro.bias.z": W_H / 4.0}),
        ("270", "inner", {"gyro.bias.y": W_V / 4.0}),
        ("z up 1", "middle", {"accelerometer.xy": 0.25}),
        ("z down 2", "middle", {"accelerometer.xy": -0.25}),
        ("x up 1", "middle", {"accelerometer.zy": 0.25}),
        ("x down 2", "middle", {"accelerometer.zy": 0.25}),
        ("y up 1", "middle", {"accelerometer.xz": -0.25}),
        ("y down 2", "middle", {"accelerometer.xz": 0.25}),
        ("z up 1", "inner", {"accelerometer.yx": 0.25}),
        ("z down 1", "inner", {"accelerometer.yx": 0.25}),
        ("y up 2", "inner", {"accelerometer.zx": 0.25}),
        ("y down 2", "inner", {"accelerometer.zx": 0.25}),
        ("x up 1", "inner", {}),
    ],
)
def test_one_stop_moves_this(which, axis, wanted):
    """An axis off at one dwell of four, or of twelve: a quarter of it in the mean."""
    value = stop(which, axis)
    found = moved("positioning", value, least=1e-7)
    for name, size in wanted.items():
        expected = size * (ARCSEC if "bias" in name else 1.0)
        # Left are products of the nominal angles, 2 arcsec, with the whole input.
        assert_allclose(found.pop(name), expected, rtol=2e-4)
    assert found == {}


def test_at_one_setting_the_table_stands_once():
    """Turns and the first dwell share a stop; sixteen in all, three axes each."""
    plan = procedure(station=(line("positioning", ARCSEC),))
    for sensors in (triads(), triads()[:1], triads()[1:]):
        problem = calibration_problem(sensors, plan)
        (size,) = [g.size for g in problem.groups if g.name.owner == STATION]
        assert size == 3 * len(STOPS) == 48
    # The first stop is in four dwells' mean and in all turns: xy and db_x.
    found = moved("positioning", stop("turns", "middle"))
    assert found.keys() == {"gyro.xy", "gyro.bias.x"}
    assert_allclose(found["gyro.xy"], 1.0, rtol=1e-5)


def test_wobble_turns_with_its_rotor():
    """Rho in two directions of each rotor: dd = rho of every gyro angle, alone."""
    plan = procedure(station=(line("wobble", ARCSEC),))
    only = frozenset({"station.wobble"})
    u = propagate(calibration_problem(triads(), plan, only=only)).standard_uncertainty
    assert_allclose(u[3:9], ARCSEC, rtol=1e-6)
    assert_allclose(u[12:], 0.0, rtol=0, atol=0)


def everything(**more):
    """Return windows of all kinds: faces, odd angles, turns from odd angles."""
    settings = [
        Setting.face(axis, sign, azimuth)
        for axis in range(3)
        for sign in (1, -1)
        for azimuth in (0.0, 2.0)
    ]
    settings += [
        Setting(
            outer=0.4, middle=-0.7, inner=1.1, turning=axis, angle=sense * 2.0 * np.pi
        )
        for axis in range(3)
        for sense in (1, -1)
    ]
    settings += [Setting(outer=1.0, middle=0.3, inner=-2.0)] * 2
    uses = ("both", "gyro", "both", "accelerometer", "both")
    windows = tuple(
        Window(
            name=str(k),
            start=20.0 * k,
            length=18.0,
            setting=setting,
            use=uses[k % 5] if k < 12 else "both",
        )
        for k, setting in enumerate(settings)
    )
    plain = procedure(sample_rate=20.0)
    return replace(plain, windows=windows, formulas="least_squares", **more)


@pytest.mark.parametrize("name", GEOMETRY)
@pytest.mark.parametrize("plan", ["paper", "windows"])
def test_pulses_on_the_crooked_table_show_the_same(monkeypatch, name, plan):
    """Rotation matrices of half a degree in the chain give the closed form's errors.

    With both triads, and with the second alone: it feels the same inputs.
    """
    station = (line(name, 1800.0 * ARCSEC),)
    how = (
        procedure(dwell=5.0, sample_rate=20.0, station=station)
        if plan == "paper"
        else everything(station=station)
    )
    problem = calibration_problem(triads(), how)
    (size,) = [g.size for g in problem.groups if g.name.owner == STATION]
    # Sources of many inputs leave out products of two of them: one at a time is exact.
    value = np.zeros(size)
    value[np.random.default_rng(7).integers(size)] = 1800.0 * ARCSEC
    key = {f"station__{name.replace('.', '__')}": value}
    exact = errors(triads(), how, **key)
    found = simulated(monkeypatch, triads(), how, f"station.{name}", value)
    # A turn by samples is a sum of harmonics that vanish, to rounding.
    assert_allclose(found, exact, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["positioning", "wobble", "mount"])
def test_pulses_with_all_inputs_differ_by_products_alone(monkeypatch, name):
    """All inputs at once, some 60 arcsec: the same but for products of two."""
    how = everything(station=(line(name, 60.0 * ARCSEC),))
    problem = calibration_problem(triads(), how)
    (size,) = [g.size for g in problem.groups if g.name.owner == STATION]
    value = np.random.default_rng(3).normal(0.0, 60.0 * ARCSEC, size)
    exact = errors(triads(), how, **{f"station__{name}": value})
    found = simulated(monkeypatch, triads(), how, f"station.{name}", value)
    square = (
        (300.0 * ARCSEC) ** 2
        / UNITS
        * np.repeat([1, 1, 2e-3, 1, 1, 9.8], [3, 6, 3, 3, 6, 3])
    )
    assert (np.abs(found - exact) < square).all()
    assert np.abs(exact[3:9]).max() > 10.0  # arcsec


def test_what_both_triads_stand_on_correlates_them():
    """Mount and tilt: 100 simulated runs have the law's correlation of gyx and ayx."""
    station = (line("mount", 20.0 * ARCSEC), line("levelling.east", 100.0 * ARCSEC))
    own = (line("mounting_repeatability", 15.0 * ARCSEC),)
    sensors = tuple(replace(one, lines=own) for one in triads())
    plan = procedure(dwell=1.0, sample_rate=5.0, station=station)
    C = propagate(calibration_problem(sensors, plan)).covariance
    gyro, other = (
        NAMES.index("gyro.mounting_angle.yx"),
        NAMES.index("accelerometer.mounting_angle.yx"),
    )
    rho = C[gyro, other] / np.sqrt(C[gyro, gyro] * C[other, other])
    assert_allclose(rho, 20.0**2 / (20.0**2 + 15.0**2), rtol=1e-4)

    runs = 100
    drawn = np.array([simulate(sensors, plan, run=k, seed=2) for k in range(runs)])
    seen = np.corrcoef(drawn[:, gyro], drawn[:, other])[0, 1]
    # Fisher: artanh of a correlation has the standard error 1/sqrt(n - 3).
    off = (np.arctanh(seen) - np.arctanh(rho)) * np.sqrt(runs - 3.0)
    assert abs(off) < 4.5
    assert abs(np.arctanh(seen)) * np.sqrt(runs - 3.0) > 5.0  # independent it is not


def test_what_cancels_by_symmetry_is_nothing_and_is_named():
    """Azimuth and a tilt about north: coefficients are exact zeros, and said so."""
    station = (line("levelling.north", 5.0 * ARCSEC), line("azimuth", 60.0 * ARCSEC))
    plan = procedure(station=station)
    law = propagate(calibration_problem(triads(), plan))
    assert not law.C[:, -2:].any()
    gyro, accelerometer = triads()
    device = Device(
        name="one",
        gyro=gyro,
        accelerometer=accelerometer,
        figures=(),
        assumptions=(),
        origin=NOWHERE,
    )
    (text,) = analyze(device, procedure=plan, validate=False).warnings
    assert_says(
        text,
        "station.levelling.north, station.azimuth",
        "removed by the 180 deg repeat",
    )
    east = procedure(station=(line("levelling.east", 5.0 * ARCSEC),))
    assert analyze(device, procedure=east, validate=False).warnings == ()
