"""The test station: axes, encoders, base and mount of a three-axis table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import (
    NOWHERE,
    UNITS,
    assert_printed,
    errors,
    line,
    paper_accelerometer,
    procedure,
    simulated,
    triads,
)
from numpy.testing import assert_allclose
from reading import assert_says

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.distributions import NORMAL as NORMAL_SHAPE
from budget.distributions import UNIFORM
from budget.earth import ECCENTRICITY_SQUARED, ROTATION_RATE, normal_gravity
from budget.errors import CallError
from budget.inputs import load_device, load_procedure
from budget.inputs.records import Device
from budget.methods.gum import propagate
from budget.model.sources import SOURCES, STATION
from budget.model.sources.rotation import Rotation
from budget.model.windows import Setting, Timing, Window
from budget.names import parameters_of
from budget.studies.analysis import analyze
from budget.units import ARCSEC, DEG_PER_HOUR, PPM

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


# With z down by the middle axis these differ, in accelerometers alone.
BY_MIDDLE = {
    **TABLE,
    "orthogonality.outer_middle": ("gyro.yx", "accelerometer.zx"),
    "encoder_zero.middle": ("gyro.xy", "accelerometer.xy", "accelerometer.zy"),
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


def test_more_stops_than_can_be_carried_are_refused():
    """Thousands of settings: in words, before memory is filled."""
    windows = tuple(
        Window(name=str(k), start=float(k), length=1.0, setting=Setting(outer=0.1 * k))
        for k in range(400)
    )
    station = (line("positioning", ARCSEC),)
    windows = (*everything().windows, *later(windows, 1000.0))
    plan = replace(everything(station=station), windows=windows)
    with pytest.raises(
        CallError, match=r"station\.positioning: this calibration has 1\d\d\d"
    ):
        calibration_problem(triads(), plan)


def later(windows, start):
    """Return windows that begin later [s]."""
    return tuple(replace(one, start=one.start + start) for one in windows)


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
        "station levelling north, station azimuth",
        "removed by the 180 deg repeat",
    )
    east = procedure(station=(line("levelling.east", 5.0 * ARCSEC),))
    assert analyze(device, procedure=east, validate=False).warnings == ()


def only(name, value, **how):
    """Return the 24 errors with one source of the station at a value."""
    plan = procedure(station=(line(name, np.abs(value)),), **how)
    return errors(triads(), plan, **{f"station__{name.replace('.', '__')}": value})


MINUTE = 60.0 * ARCSEC
NORMAL = {"is_gravity_normal": True, "gravity": normal_gravity(np.radians(34.2394))}
BY_RATE = {"timing": Timing(scale_from="rate", edges="time")}
FALSE_RATE = 15.0 * DEG_PER_HOUR - ROTATION_RATE


def test_latitude_leans_the_earth_rate():
    """+1 arcmin: db_z = -3.617010e-3 deg/h; geocentric for geodetic +0.0388417."""
    found = only("latitude", MINUTE)
    # Printed to first order; of the second -w_v dL^2/2, -3.6e-7 deg/h.
    assert_allclose(found[11], -3.617010e-3 - W_V * MINUTE**2 / 2.0, rtol=1e-6)
    others = np.delete(found, 11)
    assert_allclose(others, np.zeros(23), rtol=0, atol=2e-5)
    L = np.radians(34.2394)
    less = L - np.arctan((1.0 - ECCENTRICITY_SQUARED) * np.tan(L))
    assert_printed(less / MINUTE, "10.7273")
    geocentric = only("latitude", -less, latitude=np.degrees(L - less))
    assert_printed(geocentric[11], "0.0388417")


def test_normal_gravity_follows_latitude_and_height():
    """100 m too low: dk = -31.5 ppm; 1 arcmin: Somigliana; gravity given: nothing."""
    L = np.radians(34.2394)
    for name, value, used in (
        ("height", -100.0, normal_gravity(L) / normal_gravity(L, 100.0)),
        ("latitude", MINUTE, normal_gravity(L) / normal_gravity(L - MINUTE)),
    ):
        found = only(name, value, **NORMAL)
        assert_allclose(found[12:15], (1.0 / used - 1.0) / PPM, rtol=2e-4)
        assert_allclose(only(name, value)[12:], np.zeros(12), rtol=0, atol=0)


def test_gravity_and_earth_rate_have_their_printed_values():
    """1 mGal: dk = -1.02075 ppm, db = b dg/g; 15 deg/h: db_z = +0.0231064 deg/h."""
    found = only("gravity", 1e-5)
    for value in found[12:15]:
        assert_printed(value, "-1.02075")
    assert_allclose(found[21:], 6000.0 * 1.02075e-6, rtol=1e-5)
    assert_allclose(found[:12], 0.0, rtol=0, atol=0)
    earth = only("earth_rate", FALSE_RATE)
    assert_printed(earth[11], "0.0231064")
    assert_allclose(np.delete(earth, 11), 0.0, rtol=0, atol=1e-6)


def test_a_rate_error_acts_where_the_rate_is_trusted():
    """By angle nothing at all; by rate dk = rho, db = -rho (b + input)."""
    assert not only("rate_error", 5.0 * PPM).any()
    found = only("rate_error", 5.0 * PPM, **BY_RATE)
    assert_allclose(found[:3], 5.0, rtol=1e-9)
    b = 2.5 + np.array([0.0, 0.0, W_V])
    assert_allclose(found[9:12], -5e-6 * b, rtol=1e-4)
    assert_allclose(found[3:9], 0.0, rtol=0, atol=1e-9)
    assert_allclose(found[12:], 0.0, rtol=0, atol=0)


def test_a_fast_clock_makes_all_readings_small():
    """Gyros db = -delta (b + input), accelerometers dk = -delta; by rate gyros too."""
    delta = 20.0 * PPM
    found = only("clock", delta)
    exact = -delta / (1.0 + delta)
    b = 2.5 + np.array([-2.0 * ARCSEC * W_V, 2.0 * ARCSEC * W_V, W_V])
    assert_allclose(found[9:12], exact * b, rtol=1e-5)
    assert_allclose(found[:9], 0.0, rtol=0, atol=1e-9)
    assert_allclose(found[12:15], exact / PPM, rtol=1e-9)
    assert_allclose(found[15:], 0.0, rtol=0, atol=1e-6)
    by_rate = only("clock", delta, **BY_RATE)
    assert_allclose(by_rate[:3], exact / PPM, rtol=1e-9)
    assert_allclose(by_rate[9:12], 0.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("shape", "u", "printed"),
    [(NORMAL_SHAPE, 1e-3, "55.6"), (UNIFORM, 5e-3 / np.sqrt(3.0), "160.375")],
)
def test_edges_by_time_cost_sigma_over_the_turn(shape, u, printed):
    """u(dk) = sigma_t/T: 1 ms at 18 s 55.6 ppm, half a sample 160.375 ppm."""
    jitter = (line("edge_jitter", u, distribution=shape),)
    name = frozenset({"station.edge_jitter"})
    plan = procedure(station=jitter, **BY_RATE)
    u = propagate(calibration_problem(triads(), plan, only=name)).standard_uncertainty
    for value in u[:3] / PPM:
        assert_printed(value, printed)
    plain = procedure(station=jitter)
    law = propagate(calibration_problem(triads(), plain, only=name))
    assert not law.covariance.any()


PLACE = {
    "latitude": MINUTE,
    "height": 100.0,
    "gravity": 1e-3,
    "earth_rate": FALSE_RATE,
    "clock": 2e-4,
    "rate_error": 1e-4,
    "edge_jitter": 1e-3,
}


@pytest.mark.parametrize("name", PLACE)
@pytest.mark.parametrize("timing", [Timing(), BY_RATE["timing"]])
@pytest.mark.parametrize("plan", ["paper", "windows"])
def test_pulses_at_that_place_and_time_show_the_same(monkeypatch, name, timing, plan):
    """Samples of another place, of windows that are cut otherwise, and the problem."""
    station = (line(name, abs(PLACE[name])),)
    make = everything if plan == "windows" else procedure
    how = replace(make(station=station), timing=timing, sample_rate=20.0, **NORMAL)
    problem = calibration_problem(triads(), how)
    (size,) = [g.size for g in problem.groups if g.name.owner == STATION]
    by_rate = timing == BY_RATE["timing"]
    draws = np.random.default_rng(11).normal(size=size) if size > 1 else 1.0
    value = np.full(size, PLACE[name]) * draws
    exact = errors(triads(), how, **{f"station__{name}": value})
    found = simulated(monkeypatch, triads(), how, f"station.{name}", value)
    if name in {"rate_error", "edge_jitter"} or (name == "clock" and by_rate):
        # Left out: the place over the part of a turn that is too much, 2e-4 of it, and
        # what an accelerometer sees there: g times the square of that part.
        allowed = np.repeat([0.1, 0.05, 0.01, 0.2, 0.05, 1.0], [3, 6, 3, 3, 6, 3])
    else:  # slopes of gravity stand for it, 7e-10 of it at 100 m
        allowed = np.repeat([1e-3, 1e-4, 1e-5, 2e-3, 1e-4, 2e-3], [3, 6, 3, 3, 6, 3])
    assert (np.abs(found - exact) < allowed).all()
    felt = by_rate or name not in {"rate_error", "edge_jitter"}
    assert (np.abs(exact) > 10.0 * allowed).any() == felt


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("norm-icosahedron", "the norm of gravity, which knows no attitude"),
        ("twelve-positions", "the 180 deg repeat of each face"),
    ],
)
def test_what_removes_an_azimuth_is_the_test_at_hand(name, words):
    """By the norm of gravity it is no repeat, and the other way round."""
    how = replace(load_procedure(name), station=(line("azimuth", 60.0 * ARCSEC),))
    device = replace(load_device("zhao-2019"), gyro=None)
    found = analyze(device, procedure=how, validate=False).warnings
    (said,) = [text for text in found if "station azimuth" in text]
    assert f"removed by {words}" in said
