"""Test stations: closed forms of what a figure may be, and the circle back."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi, radians

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import put
from scipy.special import ndtri

from budget.errors import CallError
from budget.inputs import (
    load_device,
    load_procedure,
    load_requirement,
    load_station,
    load_stations,
)
from budget.names import Name
from budget.report.stations import station_yaml
from budget.studies.analysis import analyze
from budget.studies.stations import CEILINGS, qualify, station_sources
from budget.units import ARCSEC, DEG_PER_HOUR, PPM, parse_quantity

K = float(ndtri(0.975))
W_H = 12.434358 * DEG_PER_HOUR  # horizontal earth rate at 34.2394 deg [rad/s]

# A unit that feels temperature: the ramp and the random part have something to reach.
WARM = """
name: warm
gyro:
  nominal: {bias: 2.5 deg/h, mounting_angle: 2 arcsec}
  errors:
    bias_repeatability: 0.05 deg/h
    bias_temperature_coefficient: 0.01 deg/h/degC
    scale_factor_temperature_coefficient: 100 ppm/degC
accelerometer:
  nominal: {bias: 6 mg, mounting_angle: 2 arcsec}
  errors:
    bias_repeatability: 37 ug
    bias_temperature_coefficient: 10 ug/degC
"""


def qualified(
    *, requirement="navigation-grade", procedure=None, stations=(), **options
):
    """Return what a station must be for the paper's device; no candidates."""
    return qualify(
        load_device("zhao-2019"),
        requirement=load_requirement(requirement),
        procedure=procedure,
        stations=stations,
        **options,
    )


@pytest.fixture(scope="module")
def navigation():
    """Qualify all that ship for the navigation grade, by the paper's test."""
    return qualified(stations=None)


def figure(found, quantity, owner="station"):
    """Return one figure."""
    return next(
        one for one in found.figures if one.source == Name(quantity, owner=owner)
    )


# PHYSICS: dk = sqrt(2) eps/(4 pi) of a pair of turns, db_z = -w_h dL, dk = -dg/g and
# -delta, an angle of the table is an angle of the body.
@pytest.mark.parametrize(
    ("quantity", "limit", "sensitivity", "stopped_by"),
    [
        ("turn_angle", 20 * PPM, 2**0.5 / (4.0 * pi), "gyro.scale_factor.x"),
        ("levelling.east", 0.01 * DEG_PER_HOUR, W_H, "gyro.bias.z"),
        ("latitude", 0.01 * DEG_PER_HOUR, W_H, "gyro.bias.z"),
        ("gravity", 60 * PPM, 1.0 / 9.7966933092, "accelerometer.scale_factor.x"),
        ("clock", 60 * PPM, 1.0, "accelerometer.scale_factor.x"),
        ("mount", 5 * ARCSEC, 1.0, "gyro.mounting_angle.xy"),
        ("encoder_zero.inner", 5 * ARCSEC, 1.0, "gyro.mounting_angle.yx"),
    ],
)
def test_a_figure_alone_is_its_closed_form(
    navigation, quantity, limit, sensitivity, stopped_by
):
    """Alone it may be limit / (R k c), c the first-order sensitivity."""
    one = figure(navigation, quantity)
    # 1e-4: the printed digits of w_h, terms of second order.
    assert_allclose(one.alone, limit / (4.0 * K * sensitivity), rtol=1e-4)
    assert stopped_by in one.stopped_by


def test_edges_cut_by_time_are_bound_by_the_scale_factor(navigation):
    """u(dk) = sigma_t/T of four edges, T = 18 s; by an index of the table it is any."""
    procedure = load_procedure(None)
    timed = replace(procedure, timing=replace(procedure.timing, edges="time"))
    found = qualified(procedure=timed)
    expected = 18.0 * 20 * PPM / (4.0 * K)
    assert_allclose(figure(found, "edge_jitter").alone, expected, rtol=1e-6)
    assert figure(navigation, "edge_jitter").is_any


def test_what_the_test_removes_may_be_anything(navigation):
    """Azimuth: four azimuths balance; a levelling about north acts by its square."""
    azimuth, north = (figure(navigation, q) for q in ("azimuth", "levelling.north"))
    assert azimuth.is_any
    assert azimuth.together is None
    assert "180 deg repeat" in azimuth.why
    assert "180 deg repeat" in north.why
    # dk = -phi^2/2 of an accelerometer: its spread is u^2/sqrt(2).
    expected = (2**0.5 * 60 * PPM / (4.0 * K)) ** 0.5
    assert_allclose(north.alone, expected, rtol=1e-4)


def test_a_ratio_scales_figures_of_first_order(navigation):
    """Ten to one leaves 0.4 of what four to one leaves."""
    strict = qualified(ratio=10.0)
    for quantity in ("turn_angle", "gravity", "mount"):
        loose = figure(navigation, quantity).alone
        # The square of 0.6 arcsec is all that is not of first order.
        assert_allclose(figure(strict, quantity).alone, 0.4 * loose, rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["equal", "proportional"])
@pytest.mark.parametrize("device", ["paper", "warm"])
def test_a_station_with_these_figures_just_does(strategy, device, tmp_path):
    """Written as a file and judged as any other, it uses the whole of limit / R."""
    path = put(tmp_path / "warm.yaml", WARM)
    unit = load_device("zhao-2019" if device == "paper" else path)
    wanted = load_requirement("navigation-grade")
    procedure = load_procedure(None, station="three-axis-table")
    found = qualify(
        unit, requirement=wanted, procedure=procedure, strategy=strategy, stations=()
    )
    written = put(tmp_path / "allowed.yaml", station_yaml(found))
    again = qualify(unit, requirement=wanted, stations=[load_station(written)])
    assert_allclose(again.stations[0].utilisation, 1.0, rtol=1e-6)
    assert again.stations[0].verdict == "does"
    if device == "warm" and strategy == "equal":
        for quantity in ("temperature.ramp", "temperature.sigma"):
            assert figure(found, quantity, "environment").together > 0.0


def test_one_figure_more_than_alone_does_not(navigation, tmp_path):
    """A millionth below its value alone a single figure does, one above it does not."""
    alone = figure(navigation, "gravity").alone
    for factor, verdict in ((1.0 - 1e-6, "does"), (1.0 + 1e-6, "does not")):
        path = tmp_path / "one.yaml"
        value = f"{alone * factor!r} m/s^2"
        path.write_text(f"station: {{gravity: {value}}}\n", encoding="utf-8")
        found = qualified(stations=[load_station(path)])
        assert found.stations[0].verdict == verdict


@pytest.mark.slow
def test_proportional_is_one_factor_on_the_own_station():
    """Figures keep the proportions that they have; what is not given gets nothing."""
    procedure = load_procedure(None, station="three-axis-table")
    found = qualified(procedure=procedure, strategy="proportional")
    factors = [one.together / one.now for one in found.figures if one.together]
    assert len(factors) > 10
    assert_allclose(factors, factors[0], rtol=1e-9)
    assert figure(found, "earth_rate").together is None


def test_together_is_never_more_than_alone(navigation):
    """All sources share what one alone could have."""
    for one in navigation.figures:
        assert one.is_any or 0.0 < one.together <= one.alone * (1.0 + 1e-9)


@pytest.mark.slow
def test_the_own_station_is_judged_first_and_says_what_it_takes():
    """Part of limit / R of each figure alone, and the squares of first order add up."""
    procedure = load_procedure(None, station="three-axis-table")
    found = qualified(procedure=procedure, stations=None)
    assert found.own is found.stations[0]
    assert [one.is_own for one in found.stations] == [True, False, False]
    turn = figure(found, "turn_angle")
    expected = K * ARCSEC * 2**0.5 / (4.0 * pi) / (5.0 * PPM)
    assert_allclose(turn.takes_now, expected, rtol=1e-6)
    assert turn.is_within
    assert figure(found, "mount").is_within is False


@pytest.mark.slow
def test_the_acceptance_limit_is_the_limit_less_the_guard_band():
    """A = limit - r U of the whole measurement, and of the station alone beside it.

    Where r U is no less than the limit there is none.
    """
    for guard in (0.0, 1.0, 2.5):
        found = qualified(guard=guard, stations=load_stations())
        for station in found.stations:
            for row in station.outputs:
                assert row.whole >= row.expanded
                for accepted, u in (
                    (row.acceptance, row.whole),
                    (row.station_acceptance, row.expanded),
                ):
                    left = row.limit - guard * u
                    if left <= 0.0:
                        assert accepted is None
                    else:
                        assert_allclose(accepted, left, rtol=1e-12)
        none = [r for s in found.stations for r in s.outputs if r.acceptance is None]
        assert bool(none) == (guard > 0.0)


@pytest.fixture(scope="module")
def bias():
    """Qualify by a limit of 0.1 deg/h on the gyro bias, at the good table."""
    limits = tuple(
        replace(one, limit=0.1 * DEG_PER_HOUR)
        for one in load_requirement("navigation-grade").limits
        if one.output.group == "gyro.bias"
    )
    wanted = replace(load_requirement("navigation-grade"), limits=limits)
    (table,) = (one for one in load_stations() if "three" in one.name)
    return partial(
        qualify, load_device("zhao-2019"), requirement=wanted, stations=[table]
    )


def test_what_is_accepted_counts_the_noise_of_the_device(bias):
    """0.049 of 0.1 deg/h at 2:1, where the station alone would accept 0.0997 at 345:1.

    The closed form of U is that of the error as tested: what the stability of 0.04
    deg/h and the random walk leave in the windows of the test, and 2e-4 of the station.
    """
    (station,) = bias().stations
    (row,) = station.all_coarsest
    tested = analyze(
        load_device("zhao-2019"),
        coverage=0.95,
        reference="as_tested",
        validate=False,
        only=("gyro.bias_stability", "gyro.angle_random_walk"),
    )
    (u,) = (
        one.standard_uncertainty
        for one in tested.outputs
        if one.output.name == row.output.name
    )

    assert row.output.name == Name("bias", owner="gyro", axis="z")
    assert_allclose(row.whole**2, (K * u) ** 2 + row.expanded**2, rtol=1e-5)
    assert round(row.whole / DEG_PER_HOUR, 3) == 0.051
    assert round(row.acceptance / DEG_PER_HOUR, 3) == 0.049
    assert_allclose(station.test_ratio, 1.96, rtol=2e-3)
    assert row.whole_sources == (Name("bias_stability", owner="gyro"),)
    # A control: by the station alone both are those of a measurement without noise.
    assert_allclose(row.station_acceptance / DEG_PER_HOUR, 0.0997, rtol=1e-3)
    assert_allclose(row.limit / row.expanded, 345.0, rtol=1e-2)


def test_the_parameter_has_the_spread_that_its_lines_give_it(bias):
    """u_0 is the repeatability of 0.05 deg/h alone, neither noise nor station."""
    for row in bias().stations[0].outputs:
        assert_allclose(row.prior, 0.05 * DEG_PER_HOUR, rtol=1e-9)


def test_false_accept_is_what_items_that_are_drawn_show(bias):
    """Of 4e6 items that are drawn and measured as many are accepted beyond the limit.

    Within 4 standard errors of the count, without a guard band and with one; against
    the probability of the other guard band that fails.
    """
    rng = np.random.default_rng(11)
    n = 4_000_000
    rows = {guard: bias(guard=guard).stations[0].outputs[0] for guard in (0.0, 1.0)}
    row = rows[0.0]
    eta = rng.normal(0.0, row.prior, n)
    measured = eta + rng.normal(0.0, row.whole / K, n)
    for guard, one in rows.items():
        counted = np.count_nonzero(
            (np.abs(eta) > one.limit) & (np.abs(measured) <= one.acceptance)
        )
        other = rows[1.0 - guard].false_accept
        for p, agrees in ((one.false_accept, True), (other, False)):
            off = abs(counted - n * p) / np.sqrt(n * p * (1.0 - p))
            assert bool(off < 4.0) is agrees


@pytest.mark.slow
def test_two_percent_of_false_accepts_are_the_most():
    """An item in eight by simple acceptance is too much; a guard band mends it.

    At a bias limit of 0.02 deg/h the item has 0.05 and the measurement 0.026.
    """
    (table,) = (one for one in load_stations() if "three" in one.name)
    for guard, beyond in ((0.0, True), (0.5, False)):
        found = qualified(guard=guard, stations=[table]).stations[0]
        assert found.false_accept == max(row.false_accept for row in found.outputs)
        assert any(row.is_accepted_too_often for row in found.outputs) is beyond
        assert (found.false_accept > 0.02) is beyond


def test_nothing_is_said_of_false_accepts_of_what_no_line_spreads():
    """Without a repeatability nobody knows how far a bias is from nominal."""
    device = load_device("zhao-2019")
    gyro = device.gyro
    kept = tuple(one for one in gyro.lines if one.name != "bias_repeatability")
    bare = replace(device, gyro=replace(gyro, lines=kept), accelerometer=None)
    found = qualify(
        bare, requirement=load_requirement("tactical-grade"), stations=load_stations()
    )
    for station in found.stations:
        for row in station.outputs:
            is_bias = row.output.name.quantity == "bias"
            assert (row.false_accept is None) == is_bias
            assert row.whole > 0.0


def test_the_uncertainty_of_a_station_is_that_of_the_law(navigation):
    """U of the good table: gravity, height, latitude and clock of a scale factor."""
    station = next(one for one in navigation.stations if "three" in one.name)
    row = next(
        one
        for one in station.outputs
        if one.output.name == Name("scale_factor", owner="accelerometer", axis="x")
    )
    gravity, height = 20e-5 / 9.7966933092, 5.0 * 3.0821e-6 / 9.7966933092
    latitude = ARCSEC * 1.4e-6 / radians(1.0 / 60.0)  # -1.4 ppm per arcmin
    u = np.sqrt(gravity**2 + height**2 + latitude**2 + (PPM**2) / 3.0)
    # 1 %: height and latitude are printed to three and two digits.
    assert_allclose(row.expanded, K * u, rtol=0.01)
    assert row.sources == (Name("gravity", owner="station"),)


def test_a_station_without_a_figure_does_not_count(navigation):
    """The ideal one says nothing of itself, and is no station that one could have."""
    ideal = next(one for one in navigation.stations if one.name == "ideal")
    assert ideal.verdict == "no figures"
    assert ideal not in navigation.doing


def test_lines_of_the_device_take_no_part():
    """A noisy device needs the same station, coefficients apart."""
    device = load_device("zhao-2019")
    sensor = device.gyro
    loud = replace(
        device,
        gyro=replace(
            sensor, lines=tuple(replace(one, u=9.0 * one.u) for one in sensor.lines)
        ),
    )
    wanted = load_requirement("navigation-grade")
    quiet, noisy = (
        qualify(one, requirement=wanted, stations=()) for one in (device, loud)
    )
    for one, other in zip(quiet.figures, noisy.figures, strict=True):
        assert one.alone == other.alone


def test_every_source_has_a_ceiling_in_its_unit():
    """A source that is added to the table says how far the law is trusted with it."""
    for owner, source in station_sources():
        unit = source.like(owner)
        assert parse_quantity(CEILINGS[unit], unit).value > 0.0


def test_shipped_stations_are_the_candidates(navigation):
    """Without others all that ship are judged."""
    assert {one.name for one in navigation.stations} == {
        one.name for one in load_stations()
    }


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"ratio": 0.0}, "ratio is 0.0"),
        ({"ratio": float("nan")}, "ratio is nan"),
        ({"guard": -1.0}, "guard is -1.0"),
        ({"strategy": "cost"}, "strategy is 'cost'"),
        ({"strategy": "proportional"}, "no figures of a station"),
    ],
)
def test_options_that_mean_nothing_are_refused(options, said):
    """Each with what is allowed."""
    with pytest.raises(CallError, match=said):
        qualified(**options)


def test_a_requirement_that_limits_nothing_here_is_refused():
    """A limit on what the test does not estimate is none."""
    procedure = load_procedure("one-axis-rate-table")
    wanted = load_requirement("navigation-grade")
    biases = tuple(
        one
        for one in wanted.limits
        if one.output.owner == "gyro" and one.output.quantity == "mounting_angle"
    )
    assert biases
    with pytest.raises(CallError, match="sets no limit"):
        qualify(
            load_device("zhao-2019"),
            requirement=replace(wanted, limits=biases),
            procedure=procedure,
        )
