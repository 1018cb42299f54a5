"""Errors of navigation against closed forms, python-ins and each other."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.earth import ROTATION_RATE, gravity_by_height
from budget.navigation import growth as module
from budget.navigation.growth import (
    AxisNoise,
    Growth,
    Markov,
    Rounding,
    UnitRandomWalk,
    UnitWhiteNoise,
)
from budget.navigation.route import Leg, Legs, Start
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

LATITUDE = np.radians(34.2394)
NORTH, EAST = 0, 1
RIGHT, FORWARD = 0, 1  # body axes: east and north at heading 0


def growth(legs, times, *, start=Start(latitude=LATITUDE), alignment=0.0, aided=True):  # noqa: B008
    """Return the growth of errors on a route."""
    route = Legs(start=start, legs=tuple(legs))
    return Growth(
        first=route.first, alignment=alignment, steps=route.steps(times), aided=aided
    )


def triad(first, noise, u=1.0):
    """Return one noise on the three axes of a triad."""
    return [AxisNoise(row=first + axis, noise=noise, u=u) for axis in range(3)]


def six(_):
    """Return six constants, each one of the inputs."""
    return np.eye(6)


def test_constants_on_the_bench_are_those_of_python_ins():
    """Expm of the matrices of python-ins 1.0.1, altitude aided, one hour."""
    (S,) = growth([Leg(duration=3600.0)], (3600.0,)).of_constants(six)
    gyro = S[:2, FORWARD] * 0.01 * DEG_PER_HOUR
    assert_allclose(gyro, [-127.361, 1348.159], rtol=5e-6)
    force = S[NORTH, 3 + FORWARD] * 100.0 * MICRO_G
    assert_allclose(force, 789.021, rtol=1e-6)
    P = S[:, :3] @ S[:, :3].T * (0.02 * DEG_PER_HOUR) ** 2
    assert_allclose(np.sqrt(np.diag(P))[:2], [2693.3, 2708.4], rtol=2e-5)
    assert_allclose(np.sqrt(P[8, 8]) / ARCSEC, 93.28, rtol=5e-5)


def test_self_alignment_hides_what_it_was_wrong_by():
    """Level and north are wrong so that a unit at rest sees nothing; turns show it."""
    legs = [Leg(duration=1.0), Leg(duration=3599.0)]
    first, hour = growth(legs, (1.0, 3600.0), alignment=300.0).of_constants(six)
    east_force = first[6:, 3 + RIGHT] * 100.0 * MICRO_G / ARCSEC
    assert_allclose(np.abs(east_force).max(), 20.647, rtol=1e-4)
    heading = first[8, RIGHT] * 0.01 * DEG_PER_HOUR / (60.0 * ARCSEC)
    w_h = ROTATION_RATE * np.cos(LATITUDE)
    assert_allclose(abs(heading), 2.764716, rtol=1e-6)
    assert_allclose(abs(heading) * 60.0 * ARCSEC, 0.01 * DEG_PER_HOUR / w_h, rtol=1e-6)
    assert np.abs(hour[:2, [RIGHT, 3 + RIGHT]] * MICRO_G).max() < 1e-6
    turned = [Leg(duration=100.0), Leg(duration=60.0, turn_rate=np.pi / 60.0)]
    turned.append(Leg(duration=3440.0))
    (S,) = growth(turned, (3600.0,), alignment=300.0).of_constants(six)
    (plain,) = growth(turned, (3600.0,)).of_constants(six)
    assert np.abs(S[:2, RIGHT]).max() > 1.5 * np.abs(plain[:2, RIGHT]).max()


def test_self_alignment_is_over_before_anything_moves():
    """A scale factor of a unit that is aligned is felt at rest, whatever comes then."""

    def scale_factors(moment):
        senses = np.concatenate([moment.rate, moment.force], axis=-1)
        return senses[..., None] * np.eye(6)

    short, moves = Leg(duration=1e-3), Leg(duration=60.0, acceleration=2.0)
    turns = Leg(duration=60.0, turn_rate=0.1)
    for leg in (moves, turns):
        at_once, later = (
            growth(legs, (1.0,), alignment=300.0).of_constants(scale_factors)
            for legs in ([leg], [short, leg])
        )
        assert_allclose(at_once, later, rtol=0, atol=5e-3 * np.abs(later).max())


@pytest.mark.parametrize("aided", [True, False])
def test_halved_steps_change_nothing(aided, monkeypatch):
    """Fourth order: in flight with a turn and a climb, to 1e-7 of the largest."""
    start = Start(latitude=0.9, height=3000.0, speed=240.0, heading=1.0)
    legs = [
        Leg(duration=200.0, climb_rate=0.0 if aided else 5.0),
        Leg(duration=90.0, turn_rate=np.radians(2.0)),
        Leg(duration=310.0, acceleration=-0.1),
    ]
    noise = [
        AxisNoise(row=row, noise=Markov(times=(tau,)), u=1.0)
        for row, tau in enumerate((100.0, 300.0, 1000.0))
    ]
    results = []
    for part in (1.0, 0.5):
        monkeypatch.setattr("budget.navigation.route.STEP", 30.0 * part)
        monkeypatch.setattr("budget.navigation.route.TURN_STEP", 0.1 * part)
        one = growth(legs, (250.0, 600.0), start=start, aided=aided, alignment=0.0)
        results.append((one.of_constants(six), one.of_noise(noise)))
    (a, p), (b, q) = results
    assert_allclose(a, b, rtol=0, atol=1e-7 * np.abs(b).max())
    assert_allclose(p, q, rtol=0, atol=3e-7 * np.abs(q).max())


@pytest.mark.parametrize("alignment", [0.0, 600.0])
def test_noise_is_many_constants(alignment):
    """A very slow process is a constant, and its covariance that of constants."""
    one = growth([Leg(duration=900.0)], (300.0, 900.0), alignment=alignment)
    S = one.of_constants(six)[:, :, :3]
    P = one.of_noise(triad(0, Markov(times=(1e12,))))
    expected = np.einsum("aic,bjc->aibj", S, S)
    assert_allclose(P, expected, rtol=0, atol=1e-6 * np.abs(expected).max())


def test_white_noise_of_one_level_channel():
    """Var p = N^2 R^2 (3t/2 - 2 s/w + s2/(4 w)) at the equator, to the earth's rate."""
    N = 0.005 * np.radians(1.0) / 60.0
    one = growth([Leg(duration=600.0)], (600.0,), start=Start(latitude=0.0))
    P = one.of_noise(triad(0, UnitWhiteNoise(), N))
    from budget.earth import meridian_radius, normal_gravity

    R, g = meridian_radius(0.0), normal_gravity(0.0)
    w, t = np.sqrt(g / R), 600.0
    s, s2 = np.sin(w * t), np.sin(2 * w * t)
    variance = N**2 * R**2 * (1.5 * t - 2 * s / w + s2 / (4 * w))
    assert_allclose(P[0, NORTH, 0, NORTH], variance, rtol=1e-3)


def test_height_that_is_free_runs_away():
    """Of a force from below, a (cosh(kt) - 1)/k^2 with k^2 = dg/dh, over two hours."""
    latitude, times = 0.0, (600.0, 3600.0, 7200.0)
    S = growth(
        [Leg(duration=7200.0)], times, start=Start(latitude=latitude), aided=False
    ).of_constants(six)
    # Coriolis force, which that leaves out, takes a part in (2 W/k)^2 of the growth.
    k = np.sqrt(-gravity_by_height(latitude, 0.0))
    expected = (np.cosh(k * np.array(times)) - 1.0) / k**2
    assert_allclose(-S[:, 2, 5], expected, rtol=0.03)
    assert S[2, 2, 5] / S[1, 2, 5] > 100.0  # e^(k 3600 s) = 760


def test_noise_of_nothing_is_nothing():
    """Zero noise, of all kinds, and none at all."""
    one = growth([Leg(duration=60.0)], (30.0, 60.0))
    kinds = (
        UnitWhiteNoise(),
        UnitRandomWalk(),
        Markov(times=(10.0, 100.0)),
        Rounding(period=0.01),
    )
    parts = [AxisNoise(row=row, noise=kind, u=0.0) for row in (0, 4) for kind in kinds]
    assert not one.of_noise(parts).any()
    assert not one.of_noise([]).any()


def test_noises_add_up():
    """Of several parts together it is the sum of each, and quadratic in their size."""
    one = growth([Leg(duration=300.0)], (100.0, 300.0), alignment=60.0)
    kinds = (
        UnitWhiteNoise(),
        UnitRandomWalk(),
        Markov(times=(10.0, 100.0)),
        Rounding(period=0.01),
    )
    parts = [AxisNoise(row=n, noise=kind, u=2.0 + n) for n, kind in enumerate(kinds)]
    each = []
    for n, part in enumerate(parts):
        unit = one.of_noise([replace(part, u=1.0)])
        each.append(unit * (2.0 + n) ** 2)
        same = np.moveaxis(unit, (0, 1), (2, 3))
        assert_allclose(unit, same, rtol=0, atol=1e-12 * np.abs(unit).max())
    assert_allclose(one.of_noise(parts), np.sum(each, axis=0), rtol=1e-12)


@pytest.mark.parametrize(
    "noise", [UnitWhiteNoise(), UnitRandomWalk(), Markov(times=(20.0, 300.0))]
)
def test_many_times_agree_with_few(noise):
    """What is asked at two times does not depend on what is asked between."""
    legs = [Leg(duration=100.0, acceleration=1.0), Leg(duration=50.0, turn_rate=0.02)]
    parts = triad(0, noise)
    few = growth(legs, (70.0, 150.0), alignment=30.0).of_noise(parts)
    times = tuple(np.arange(1.0, 151.0))
    many = growth(legs, times, alignment=30.0).of_noise(parts)
    places = [69, 149]
    assert_allclose(
        many[places][:, :, places], few, rtol=0, atol=1e-8 * np.abs(few).max()
    )


NOISES = (UnitWhiteNoise(), Rounding(0.01), UnitRandomWalk(), Markov((300.0, 20.0)))


def grown(monkeypatch, at_a_time):
    """Return what constants and noise do on a route, so many steps at a time."""
    monkeypatch.setattr(module, "AT_A_TIME", at_a_time)
    turns = Leg(duration=60.0, turn_rate=np.pi / 60.0)
    own = growth([turns, Leg(duration=40.0), turns], (50.0, 150.0), alignment=60.0)
    parts = [part for noise in NOISES for part in triad(3, noise)]
    return own.of_constants(six), own.of_noise(parts)


@pytest.mark.parametrize("at_a_time", [1, 3, 7])
def test_how_many_steps_are_taken_at_a_time_changes_no_number(monkeypatch, at_a_time):
    """Arrays are made of some steps after the others, and are those of all."""
    whole = grown(monkeypatch, 10**6)
    parts = grown(monkeypatch, at_a_time)

    for one, other in zip(parts, whole, strict=True):
        assert_allclose(one, other, rtol=1e-14, atol=1e-14 * np.abs(other).max())


@pytest.mark.slow
def test_memory_of_a_long_route_is_a_part_of_that_of_all_steps_at_once(monkeypatch):
    """Of what a step takes only transitions and responses are kept for all steps."""

    def peak(at_a_time):
        monkeypatch.setattr(module, "AT_A_TIME", at_a_time)
        turns = Leg(duration=20_000.0, turn_rate=np.pi / 60.0)
        own = growth([turns], (20_000.0,))
        tracemalloc.start()
        try:
            own.of_constants(six)
            own.of_noise(triad(0, Markov((300.0, 20.0))))
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(256) < 0.5 * peak(10**6)
