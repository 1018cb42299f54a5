"""Blunders about the place: their sizes, what gives them away, where it is said."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, degrees, radians, sin, sqrt

import numpy as np
import pytest
from builders import (
    UNITS,
    assert_printed,
    line,
    paper_accelerometer,
    paper_gyro,
    simulated,
)
from command_line import call
from numpy.testing import assert_allclose
from places import ROOT, put
from reading import assert_says

from budget import compare
from budget.earth import ECCENTRICITY_SQUARED, SEMI_MAJOR_AXIS, normal_gravity
from budget.inputs import load_device, load_procedure
from budget.inputs.files import shipped_names
from budget.inputs.records import Limit, Origin, Requirement
from budget.names import Name
from budget.studies.allocation.allocate import allocate
from budget.studies.analysis import analyze
from budget.studies.blunders import (
    against_limits,
    blunders,
    costs,
    evident,
    offsets,
)
from budget.studies.stations import qualify
from budget.units import PPM

ZHAO, PAPER = load_device("zhao-2019"), load_procedure()
TRIADS = (paper_gyro(), paper_accelerometer())
SF = "accelerometer.scale_factor"
CLOCK = (line("clock", PPM),)


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a procedure file with this text."""

    def read(text):
        path = put(tmp_path / "mine.yaml", text)
        return load_procedure(path)

    return read


def sizes(procedure):
    """Return what each mistake costs, in printed units, by its source and text."""
    return {
        one.text: {o.name: o.error / o.output.si_per_unit for o in moved}
        for one, moved in costs(procedure)
    }


def test_mistakes_have_their_printed_sizes():
    """At 34.2394 deg: biases and scale factors that a real test shows."""
    latitude, rate, height, anomaly, unit = sizes(PAPER).values()
    assert_printed(latitude["gyro.bias.z"], "0.0388417")
    assert_printed(rate["gyro.bias.z"], "0.0231064")
    assert_printed(anomaly[SF] / 50.0, "1.02075")  # for each mGal
    assert_printed(height[SF], "-31.5")  # 2 (1 + f + m - 2 f sin^2 L) h/a
    assert_allclose(
        unit[SF] * PPM, 9.7966933092 / 9.80665 - 1.0, rtol=1e-7
    )  # K = pulses over what gravity is taken for
    there, used = PAPER.gravity, normal_gravity(radians(34.2394 - 10.7273 / 60.0))
    assert_allclose(latitude[SF] * PPM, there / used - 1.0, rtol=2e-3)
    assert [set(one) for one in (rate, height, anomaly, unit)] == [
        *({"gyro.bias.z"}, {SF}, {SF}, {SF})
    ]


def test_geocentric_latitude_is_the_angle_at_the_centre():
    """Of the point on the ellipsoid: x = N cos L, z = N (1 - e^2) sin L."""
    for L in map(radians, (-60.0, 0.0, 34.2394, 45.0, 90.0)):
        N = SEMI_MAJOR_AXIS / sqrt(1.0 - ECCENTRICITY_SQUARED * sin(L) ** 2)
        there = atan2(N * (1.0 - ECCENTRICITY_SQUARED) * sin(L), N * cos(L))
        one = blunders(replace(PAPER, latitude=L))[0]
        assert_allclose(one.difference, there - L, rtol=1e-9, atol=1e-15)
        assert f"{degrees(there):.4f} deg" in one.text


@pytest.mark.parametrize("place", range(5))
@pytest.mark.parametrize("latitude", [34.2394, -60.0])
def test_pulses_at_the_true_place_show_the_same(monkeypatch, place, latitude):
    """The simulated table stands elsewhere than the estimator takes it for."""
    L = radians(latitude)
    there = replace(PAPER, latitude=L, gravity=normal_gravity(L))
    blunder = blunders(there)[place]
    found = np.array([one.error for one in offsets(blunder, TRIADS)]) / UNITS
    size = [abs(blunder.difference)]
    used = replace(blunder.used, station=(line(blunder.source, size),))
    shown = simulated(
        monkeypatch, TRIADS, used, f"station.{blunder.source}", [blunder.difference]
    )
    # Left: gravity goes by slopes, 4e-3 of 15 ppm of a latitude 0.2 deg off.
    allowed = np.repeat([1e-3, 1e-4, 1e-5, 0.1, 1e-4, 1.0], [3, 6, 3, 3, 6, 3])
    assert (np.abs(found - shown) < allowed).all()
    assert (np.abs(shown) > 100.0 * allowed).any()


def test_what_a_procedure_says_makes_the_table():
    """A height that is said is no row, a gravity that is measured no anomaly."""
    said = replace(PAPER, height=0.0, assumptions=())
    measured = replace(said, is_gravity_normal=False)
    assert [len(sizes(one)) for one in (PAPER, said, measured)] == [5, 4, 3]


@pytest.mark.parametrize("name", shipped_names("procedure"))
def test_shipped_procedures_give_evidence_of_nothing(name):
    """Their tables reach what they estimate, and name every output once."""
    procedure = load_procedure(name)
    assert evident(procedure) == ()
    for _, moved in costs(procedure):
        names = [one.name for one in moved]
        assert len(names) == len(set(names)) > 0
        assert all(np.isfinite(one.error) for one in moved)


def test_windows_that_calibrate_nothing_have_no_table(read):
    """A dwell alone is a valid file, and no test."""
    one = read("windows: [{face: z up, dwell: 300 s}]\n")
    assert costs(one) == evident(one) == ()


def test_a_table_of_very_many_windows_is_not_made(read):
    """Warnings with evidence stand all the same."""
    faces = "windows: [{face: all, dwell: 30 s, use: accelerometer, repeat: %d}]\n"
    few, many = (read("gravity: 9.7 m/s^2\n" + faces % n) for n in (33, 34))
    assert [bool(costs(one)) for one in (few, many)] == [True, False]
    assert evident(read("gravity: 9.81 m/s^2\n" + faces % 34)) != ()


@pytest.mark.parametrize("gravity", ["1e-20", "1e-9", "5", "1e20"])
def test_no_gravity_breaks_the_table(tmp_path, gravity):
    """Whatever is accepted as a gravity: a table of numbers, and no more on stderr."""
    path = put(tmp_path / "far.yaml", f"latitude: -90 deg\ngravity: {gravity} m/s^2\n")
    run = call("validate", path)
    assert (run.code, run.err) == (0, "")
    assert "nan" not in run.out
    assert "inf" not in run.out


@pytest.mark.parametrize(
    ("gravity", "size"),
    [
        ("9.80665 m/s^2", "-1015 ppm"),
        ("1 g", "-1015 ppm"),
        ("9.81 m/s^2", "-1356 ppm"),
        ("980 Gal", "-337 ppm"),
    ],
)
def test_the_unit_g_for_gravity_gives_itself_away(read, gravity, size):
    """As against normal gravity at that latitude; whatever it is spelled as."""
    mine = read(f"latitude: 34.2394 deg\ngravity: {gravity}\n")
    (text,) = evident(mine)
    assert_says(text, size, SF, "9.79669 m/s^2")
    (said,) = analyze(ZHAO, procedure=mine, validate=False).warnings
    assert_says(said, size, SF, "u 38 ppm")


@pytest.mark.parametrize(
    "text",
    [
        "latitude: 34.2394 deg\ngravity: 9.79669 m/s^2\n",
        "latitude: 45.5 deg\ngravity: 9.80665 m/s^2\n",  # where g is what there is
        "latitude: 49.2 deg\ngravity: 9.81 m/s^2\n",
    ],
)
def test_a_gravity_that_may_be_true_is_no_blunder(read, text):
    """Within 10 mGal of the normal one, or measured to more digits."""
    mine = read(text)
    assert evident(mine) == ()
    assert analyze(ZHAO, procedure=mine, validate=False).warnings == ()


def test_a_value_in_the_place_of_its_uncertainty_gives_itself_away(read):
    """15 deg/h under station.earth_rate costs +0.0231 deg/h where it is used."""
    mine = read(
        "latitude: 34.2394 deg\nheight: 1600 m\nstation: {earth_rate: 15 deg/h, "
        "latitude: 34.24 deg, gravity: 979 Gal, height: 1600 m}\n"
    )
    texts = evident(mine)
    assert len(texts) == 4
    (rate,) = (text for text in texts if "earth_rate" in text)
    assert_says(rate, "15.0411 deg/h", "+0.0231 deg/h", "gyro.bias.z")
    assert {*texts} <= {*analyze(ZHAO, procedure=mine, validate=False).warnings}
    right = "station: {earth_rate: 0.01 deg/h, latitude: 1 arcmin, height: 5 m}\n"
    assert evident(read(right)) == ()


def warned(station=CLOCK, device=ZHAO, limit=None, **more):
    """Return what of the place is warned of, by a word: height, anomaly."""
    requirement = limit and Requirement(
        name="r",
        coverage=0.95,
        reference="nominal",
        limits=(
            Limit(
                output=Name("scale_factor", owner="accelerometer", axis="x"),
                limit=limit * PPM,
                printed="",
            ),
        ),
        caps=(),
        assumptions=(),
        origin=Origin(file="", sha256=""),
    )
    how = replace(PAPER, station=station, **more)
    budget = analyze(device, procedure=how, requirement=requirement, validate=False)
    texts = " ".join(budget.warnings)
    return {word for word in ("height", "anomaly") if word in texts}


def test_a_station_that_leaves_height_or_gravity_open_is_told():
    """100 m are 31.5 ppm, 50 mGal 51 ppm; without a station it is said to be ideal."""
    both = {"height", "anomaly"}
    assert warned() == both
    assert warned(station=()) == set()
    assert warned(assumptions=()) == {"anomaly"}
    assert warned(station=(line("gravity", 1e-4),)) == {"height"}
    assert warned(is_gravity_normal=False) == set()
    how = replace(PAPER, station=CLOCK)
    texts = analyze(ZHAO, procedure=how, validate=False).warnings
    assert_says(" ".join(texts), "-31.5 ppm", "+51.0 ppm", "u 38 ppm", SF)
    only = analyze(ZHAO, procedure=how, validate=False, only=("bias_stability",))
    assert only.warnings == ()


def test_only_what_counts_beside_u_or_a_limit_is_said():
    """31.5 ppm count beside 315 ppm at the most, 51 ppm beside 102 ppm."""

    def device(ppm):
        lines = {"scale_factor_repeatability": ppm * PPM}
        return replace(ZHAO, gyro=None, accelerometer=paper_accelerometer(**lines))

    assert warned(device=device(100.0)) == {"height", "anomaly"}
    assert warned(device=device(104.0)) == warned(device=device(313.0)) == {"height"}
    assert warned(device=device(317.0)) == set()
    assert warned(device=device(317.0), limit=313.0) == {"height"}
    assert warned(device=device(317.0), limit=100.0) == {"height", "anomaly"}


def test_the_paper_is_warned_of_nothing():
    """Without a station an ideal one is assumed, and said to be."""
    assert analyze(ZHAO, validate=False).warnings == ()


def test_validate_warns_and_shows_what_mistakes_cost(tmp_path):
    """A table of five for a place that is left open; warnings with evidence alone."""
    run = call("validate", ROOT / "specs" / "procedures" / "zhao-2019.yaml")
    assert_says(run.out, "geocentric latitude, 34.0606 deg", "+0.0388 deg/h")
    assert_says(run.out, "earth rate 15 deg/h", "+0.0231 deg/h", "-31.5 ppm")
    assert_says(run.out, "anomaly of +50 mGal", "+51.0 ppm", "-1015 ppm")
    assert run.out.count("gyro.bias.z") == 2
    assert "warning" not in run.out
    path = put(tmp_path / "g.yaml", "gravity: 9.8 m/s^2\n")
    assert_says(call("validate", path).out, "warning", "-337 ppm", SF)


def test_an_earth_rate_is_answered_with_the_one_that_is_used(tmp_path):
    """There is no such key: it is that of WGS 84, and only its uncertainty is given."""
    path = put(tmp_path / "rate.yaml", "latitude: 34 deg\nearth_rate: 15 deg/h\n")
    run = call("validate", path, code=2)
    assert_says(run.err, "15.0411 deg/h", "station.earth_rate")


def limited(scale_factor):
    """Return a requirement on the accelerometers' scale factors alone [1]."""
    return Requirement(
        name="tight",
        coverage=0.95,
        reference="next_turn_on",
        limits=tuple(
            Limit(
                output=Name("scale_factor", owner="accelerometer", axis=axis),
                limit=scale_factor,
                printed="",
            )
            for axis in "xyz"
        ),
        caps=(),
        assumptions=(),
        origin=Origin(file="tight.yaml", sha256=""),
    )


@pytest.mark.parametrize(("limit", "said"), [(60.0, 2), (180.0, 1), (1000.0, 0)])
def test_a_place_left_open_counts_beside_a_limit_without_a_station(limit, said):
    """From a quarter of it on: 51 ppm of 50 mGal, 31.5 ppm of 100 m; in all answers."""
    wanted = limited(limit * PPM)
    texts = against_limits(PAPER, wanted)
    assert len(texts) == said
    if said:
        assert_says(" ".join(texts), "+51.0 ppm", f"limit {limit:g} ppm")
    answers = (
        compare([ZHAO], wanted, method="gum"),
        allocate(ZHAO, requirement=wanted, catalogue=(), validate=False),
        qualify(ZHAO, requirement=wanted),
        analyze(ZHAO, requirement=wanted, reference="next_turn_on", validate=False),
    )
    for answer in answers:
        assert set(texts) <= set(answer.warnings)
        assert bool(said) is any("ppm" in text for text in answer.warnings)
