"""Recorded tracks against the legs that they were recorded from, and at their edges."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_less
from scipy.spatial.transform import Rotation

from budget.earth import normal_radius
from budget.errors import ProblemError
from budget.navigation.growth import (
    AxisNoise,
    Growth,
    Markov,
    UnitRandomWalk,
    UnitWhiteNoise,
)
from budget.navigation.route import STEP, Leg, Legs, Start, Track

WEIGHTS = np.polynomial.legendre.leggauss(4)[1] / 2.0
START = Start(latitude=0.6, height=500.0, heading=0.4)
FLIGHT = (
    Leg(duration=20.0),
    Leg(duration=60.0, acceleration=2.5),
    Leg(duration=30.0),
    Leg(duration=60.0, turn_rate=np.radians(3.0)),
    Leg(duration=30.0),
)
TIMES = (50.0, 150.0, 200.0)


@cache
def recorded(legs, *, rate=10.0, start=START):
    """Return what a recorder on a vehicle of these legs writes."""
    route = Legs(start=start, legs=legs)
    number = round(route.duration * rate)
    times = np.arange(1, number + 1) / rate
    steps = route.steps(times)
    whole = [route.first, steps.ends]
    latitude = np.concatenate([np.atleast_1d(m.latitude.ravel()) for m in whole])
    height = np.concatenate([np.atleast_1d(m.height.ravel()) for m in whole])
    body = np.concatenate([m.body.reshape(-1, 3, 3) for m in whole])
    # Longitude by the points of Gauss of each step, which are its nodes.
    nodes = steps.nodes
    radius = np.vectorize(normal_radius)(nodes.latitude) + nodes.height
    slope = nodes.velocity[..., 1] / (radius * np.cos(nodes.latitude))
    grown = np.cumsum(steps.durations * (slope @ WEIGHTS))
    longitude = np.concatenate([[0.0], grown[list(steps.asked)]])
    heading = np.arctan2(body[:, 1, 1], body[:, 0, 1])
    level = np.zeros_like(heading)
    return Track(
        time=np.concatenate([[0.0], times]),
        latitude=latitude,
        longitude=np.angle(np.exp(1j * (longitude + np.pi))),  # over the date line
        height=height,
        attitude=np.stack([level, level, heading], axis=1),
    )


def senses(moment):
    """Return biases and scale factors of the six inputs, and quadratic ones."""
    v = np.concatenate([moment.rate, moment.force], axis=-1)[..., None] * np.eye(6)
    ones = np.broadcast_to(np.eye(6), v.shape)
    return np.concatenate([ones, v, v * v], axis=-1)


def results(route, times=TIMES, *, alignment=0.0, aided=True):
    """Return what constants and noise do."""
    one = Growth(
        first=route.first, alignment=alignment, steps=route.steps(times), aided=aided
    )
    noise = (UnitWhiteNoise(), UnitRandomWalk(), Markov(times=(50.0,)))
    C = [
        one.of_noise([AxisNoise(row=row, noise=n, u=1.0) for row in range(6)])
        for n in noise
    ]
    return one.of_constants(senses), C


@pytest.mark.parametrize("alignment", [0.0, 600.0])
@pytest.mark.parametrize("aided", [True, False])
def test_a_track_does_what_its_legs_do(alignment, aided):
    """Recorded at 10 Hz: to 3e-6 of the largest; of scale factors, squares less."""
    legs = Legs(start=START, legs=FLIGHT)
    S, C = results(legs, alignment=alignment, aided=aided)
    own, own_C = results(recorded(FLIGHT), alignment=alignment, aided=aided)
    bounds = np.repeat([3e-6, 1e-5, 1e-3], 6)
    for quantity in (slice(0, 3), slice(3, 6), slice(6, 9)):
        size = np.abs(S[:, quantity]).max(axis=(0, 1))
        gap = np.abs(own[:, quantity] - S[:, quantity]).max(axis=(0, 1))
        assert_array_less(gap, bounds * size + 1e-300)
    for P, own_P in zip(C, own_C, strict=True):
        u = np.sqrt(np.einsum("titi->ti", P))
        size = u[:, :, None, None] * u
        assert (np.abs(own_P - P) <= 1e-5 * size).all()


def test_a_track_that_is_turned_is_seen():
    """Control: a heading that is off by 1 deg is no rounding."""
    track = recorded(FLIGHT)
    off = replace(track, attitude=track.attitude + np.radians([0, 0, 1]))
    S, own = (results(one)[0][:, :2, :6] for one in (track, off))
    assert np.abs(own - S).max() > 1e-3 * np.abs(S).max()


def test_few_samples_are_enough_where_nothing_bends():
    """A row a minute of level flight: steps are cut, and the answers stay."""
    cruise = (Leg(duration=600.0),)
    start = replace(START, speed=100.0)
    dense, few = (recorded(cruise, rate=r, start=start) for r in (1.0, 1.0 / 60.0))
    steps = few.steps((600.0,))
    assert steps.durations.max() <= STEP * (1.0 + 1e-9)
    assert len(dense.steps((600.0,)).durations) < 30
    S, own = (results(one, (600.0,))[0] for one in (dense, few))
    assert_allclose(own, S, rtol=0, atol=1e-6 * np.abs(S).max())


def test_what_bends_is_cut():
    """A track that swings twice a second has steps that follow it."""
    t = np.arange(0.0, 20.0, 0.05)
    track = Track(
        time=t,
        latitude=0.6 + 1e-7 * np.sin(4.0 * np.pi * t),
        longitude=0.0 * t,
        height=0.0 * t,
        attitude=np.stack([0.3 * np.sin(4.0 * np.pi * t), 0.0 * t, 0.0 * t], axis=1),
    )
    steps = track.steps((10.0, 15.0))
    assert steps.durations.max() < 0.1
    ends = np.cumsum(steps.durations)[list(steps.asked)]
    assert_allclose(ends, [10.0, 15.0], rtol=1e-12)
    # In each step the mean of the acceleration is the change of velocity.
    weights = steps.durations[:, None, None] * WEIGHTS[:, None]
    gained = (weights * steps.nodes.acceleration).sum(axis=1)
    total = np.cumsum(gained, axis=0)[list(steps.asked)]
    change = steps.ends.velocity - track.first.velocity
    assert_allclose(total, change, rtol=0, atol=1e-9)


@pytest.mark.parametrize("pitch", [-1.2, 0.0, 0.7])
def test_errors_of_angles_are_those_of_a_turned_body(pitch):
    """Roll, pitch and heading of the body, before and after a small turn."""
    angles = np.array([0.5, pitch, 2.1])
    track = Track(
        time=np.array([0.0, 1.0]),
        latitude=np.full(2, 0.7),
        longitude=np.zeros(2),
        height=np.zeros(2),
        attitude=np.tile(angles, (2, 1)),
    )
    C = track.first.seen(aided=True)[6:, 4:]
    turn = 1e-6 * np.array([0.3, -0.5, 0.8])
    before = Rotation.from_euler("ZYX", angles[::-1])
    # The computed body is turned by -phi.
    after = Rotation.from_rotvec(-turn) * before
    change = (after.as_euler("ZYX") - before.as_euler("ZYX"))[::-1]
    assert_allclose(C @ turn, change, rtol=0, atol=1e-11)


def test_body_axes_are_right_forward_and_up():
    """Right side down the right axis points down; nose up the forward one up."""
    for place, angle, axis, sign in ((0, 0.3, 0, 1.0), (1, 0.3, 1, -1.0)):
        attitude = np.zeros((2, 3))
        attitude[:, place] = angle
        track = Track(
            time=np.array([0.0, 1.0]),
            latitude=np.full(2, 0.7),
            longitude=np.zeros(2),
            height=np.zeros(2),
            attitude=attitude,
        )
        assert_allclose(track.first.body[2, axis], sign * np.sin(angle), rtol=1e-12)


def test_times_out_of_a_route_are_refused():
    """Not rising, 0, after the end; of both kinds of route."""
    track = recorded(FLIGHT[:1])
    for route in (track, Legs(start=START, legs=FLIGHT[:1])):
        for times in ((0.0,), (20.0, 10.0), (10.0, 10.0), (31.0,)):
            with pytest.raises(ProblemError, match="expected rising"):
                route.steps(times)


def test_a_faulty_track_is_refused():
    """Shapes, numbers, order of time, and a body that points straight up."""
    track = recorded(FLIGHT[:1])
    with pytest.raises(ProblemError, match="shapes"):
        replace(track, height=track.height[1:])
    with pytest.raises(ProblemError, match="finite"):
        replace(track, height=track.height * np.nan)
    with pytest.raises(ProblemError, match="rise"):
        replace(track, time=track.time[::-1])
    up = replace(track, attitude=track.attitude + np.radians([0, 90, 0]))
    with pytest.raises(ProblemError, match="straight up"):
        up.steps((10.0,))


def test_times_at_the_ends_of_legs():
    """Asked at joints, just beside them, and often: each time is there once."""
    legs = tuple(Leg(duration=0.1, turn_rate=0.1 * (-1) ** n) for n in range(30))
    route = Legs(start=START, legs=legs)
    times = tuple(sorted({*np.cumsum([0.1] * 30), *np.linspace(0.05, 2.95, 59), 1.0}))
    steps = route.steps(times)
    assert len(steps.asked) == len(times)
    ends = np.cumsum(steps.durations)[list(steps.asked)]
    assert_allclose(ends, times, rtol=1e-9)


BANK = Leg(duration=60.0, turn_rate=-0.1, bank=-0.3, roll_rate=-0.15)


def test_what_is_sensed_in_a_bank_is_that_of_its_attitude_and_motion():
    """Rates of attitudes and forces of velocities a moment apart, by differences."""
    route = Legs(start=replace(START, speed=29.4), legs=(BANK,))
    h = 1e-3
    for time in (1.0, 30.0, 59.0):  # it rolls, it leans, it rolls back
        before, there, after = (
            route.steps((at,)).ends for at in (time - h, time, time + h)
        )
        first, last = (Rotation.from_matrix(one.body[0]) for one in (before, after))
        turned = (first.inv() * last).as_rotvec() / (2.0 * h)
        v = (after.velocity - before.velocity) / (2.0 * h)
        of_frame = there.earth_rate + there.transport
        coriolis = np.cross(of_frame + there.earth_rate, there.velocity)
        felt = (v + coriolis - there.gravity)[0] @ there.body[0]
        still = of_frame[0] @ there.body[0]
        assert_allclose(there.rate[0], turned + still, rtol=0, atol=1e-8)
        assert_allclose(there.force[0], felt, rtol=0, atol=1e-6)


def test_a_bank_turns_about_two_axes_and_is_left_level():
    """Of rate w: w cos phi about z, abs(w) sin abs(phi) about x, in either sense."""
    for sense in (1.0, -1.0):
        leg = replace(
            BANK, turn_rate=0.1 * sense, bank=0.3 * sense, roll_rate=0.15 * sense
        )
        route = Legs(start=replace(START, speed=29.4), legs=(leg, Leg(duration=9.0)))
        steps = route.steps((1.0, 30.0, 60.0, 69.0))
        turning = (steps.ends.turning[:, None] @ steps.ends.body)[:, 0]
        roll = np.arctan2(steps.ends.body[:, 2, 0], -steps.ends.body[:, 2, 2])
        assert_allclose(roll, sense * np.array([0.15, 0.3, 0, 0]), rtol=0, atol=1e-12)
        expected = [0.1 * np.sin(0.3), 0.0, -sense * 0.1 * np.cos(0.3)]
        assert_allclose(turning[1], expected, rtol=0, atol=1e-12)
        assert_allclose(steps.durations.sum(), 69.0, rtol=1e-12)
    assert [piece.duration for piece in leg.pieces] == [2.0, 56.0, 2.0]


def test_a_time_at_the_end_of_a_bank_needs_no_step_of_its_own():
    """Its rolls do not add up to the last bit; no step is a rounding of that."""
    leg = replace(BANK, bank=-0.3 / 3.0)
    assert sum(piece.duration for piece in leg.pieces) != leg.duration
    route = Legs(start=replace(START, speed=29.4), legs=(leg,) * 30)
    steps = route.steps(60.0 * np.arange(1.0, 31.0))
    assert steps.durations.min() > 0.1
    assert len(steps.asked) == 30


@pytest.mark.parametrize("kind", ["legs", "track"])
def test_a_step_ends_at_every_cut(kind):
    """Cuts are ends of steps and ask for nothing; one at a time asked for is it."""
    legs = Legs(
        start=Start(latitude=0.8, speed=30.0),
        legs=(Leg(duration=50.0), Leg(duration=60.0, turn_rate=0.02)),
    )
    t = np.linspace(0.0, 110.0, 111)
    line = 0.8 + 30.0 * t / 6.4e6
    flat = np.zeros((111, 3))
    track = Track(
        time=t, latitude=line, longitude=0.0 * t, height=0.0 * t, attitude=flat
    )
    route = {"legs": legs, "track": track}[kind]
    times, cuts = (40.0, 110.0), (-3.0, 0.0, 7.3, 40.0 + 1e-12, 50.0, 70.1, 120.0)
    steps = route.steps(times, cuts)
    ends = np.cumsum(steps.durations)
    assert_allclose(ends[list(steps.asked)], times, rtol=1e-12)
    assert_allclose(steps.ends.time, times, rtol=1e-12)
    for cut in (7.3, 50.0, 70.1):
        assert np.abs(ends - cut).min() < 1e-9
    assert steps.durations.min() > 1e-3
    begins = ends - steps.durations
    inside = (steps.nodes.time > begins[:, None]) & (steps.nodes.time < ends[:, None])
    assert inside.all()
    plain = np.cumsum(route.steps(times).durations)
    assert np.abs(plain - 7.3).min() > 0.1  # control
