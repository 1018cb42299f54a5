"""Growth of errors against full strapdown navigation, unit by unit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import sensor
from navigation.strapdown import Motion, aligned, gravity, navigate, radii, seen
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from budget.calibration.mission import mission_outputs, mission_problem
from budget.inputs import load_mission, uncalibrated
from budget.inputs.use import in_use
from budget.methods.gum import propagate
from budget.navigation.growth import AxisNoise, Growth, Markov, UnitWhiteNoise
from budget.navigation.route import Leg, Legs, Start, Track, moments, moved
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

BENCH = Legs(start=Start(latitude=np.radians(34.2394)), legs=(Leg(duration=3600.0),))
FLIGHT = Legs(
    start=Start(latitude=0.9, height=2000.0, heading=1.1),
    legs=(
        Leg(duration=100.0),
        Leg(duration=100.0, acceleration=2.0),
        Leg(duration=300.0),
        Leg(duration=60.0, turn_rate=np.radians(3.0)),
        Leg(duration=340.0),
    ),
)
BANKED = Legs(
    start=FLIGHT.start,
    legs=(
        Leg(duration=20.0),
        Leg(duration=40.0, acceleration=2.0),
        *(
            Leg(
                duration=60.0,
                turn_rate=np.radians(3.0 * sense),
                bank=np.radians(44.0 * sense),
                roll_rate=np.radians(4.0 * sense),
            )
            for sense in (1.0, -1.0, 1.0)
        ),
    ),
)
SIZES = np.array([1e-3 * DEG_PER_HOUR] * 3 + [5 * MICRO_G] * 3 + [1e-6] * 6)


def motion_of(route, *, step=4.0, turn=np.pi / 180.0):
    """Return what an ideal unit senses on a route of legs."""
    here, durations, stages, legs = route.start, [], [], []
    for leg in (piece for whole in route.legs for piece in whole.pieces):
        turned = np.hypot(leg.turn_rate, leg.roll_rate) * leg.duration
        number = round(max(leg.duration / step, turned / turn))
        h = leg.duration / number
        for _ in range(number):
            stages += [here, moved(here, leg, h / 2), moved(here, leg, h)]
            here = stages[-1]
        durations += [h] * number
        legs += [leg] * 3 * number
    at = moments(stages, legs, (-1, 3))
    first = route.first
    return Motion(
        durations=np.array(durations),
        rate=at.rate,
        force=at.force,
        latitude=route.start.latitude,
        height=route.start.height,
        velocity=first.velocity,
        body=first.body,
    )


def senses(moment):
    """Return biases and scale factors of the six inputs."""
    v = np.concatenate([moment.rate, moment.force], axis=-1)[..., None] * np.eye(6)
    return np.concatenate([np.broadcast_to(np.eye(6), v.shape), v], axis=-1)


def by_equations(route, times, *, alignment=0.0, aided=True):
    """Return what a unit of each parameter becomes, (times, 9, 12)."""
    growth = Growth(
        first=route.first, alignment=alignment, steps=route.steps(times), aided=aided
    )
    return growth.of_constants(senses)


def by_navigation(motion, times, *, is_aligned=False, aided=True):
    """Return the same of full navigators, each with one parameter off, up and down."""
    return both_by_navigation(motion, times, aided=aided)[is_aligned]


def both_by_navigation(motion, times, *, aided):
    """Return it of those that were told their attitude, and of those that aligned."""
    p = np.concatenate([np.zeros((1, 12)), np.diag(SIZES), -np.diag(SIZES)])
    twice = np.concatenate([p, p])

    def errors(step, ideal):  # noqa: ARG001
        return twice[:, :6] + twice[:, 6:] * ideal

    begin = np.tile(motion.body, (len(twice), 1, 1))
    at_rest = np.concatenate([motion.rate[0, 0], motion.force[0, 0]])
    felt = (at_rest + errors(0, at_rest))[len(p) :]
    begin[len(p) :] = aligned(felt[:, :3], felt[:, 3:])
    ends = np.cumsum(motion.durations)
    stops = {int(np.argmin(np.abs(ends - time))) for time in times}
    found = []
    for state in navigate(motion, errors, begin, stops, aided=aided):
        for one in (slice(len(p)), slice(len(p), None)):
            own = type(state)(state.body[one], state.velocity[one], state.place[one])
            true = type(state)(own.body[:1], own.velocity[:1], own.place[:1])
            off = seen(own, true)[1:]
            found.append(((off[:12] - off[12:]) / (2.0 * SIZES[:, None])).T)
    return np.array(found[::2]), np.array(found[1::2])


@cache
def flown(route, times, *, aided):
    """Return what navigators find on a route, told their attitude and aligned: once."""
    return both_by_navigation(motion_of(route), times, aided=aided)


def gap(S, own):
    """Return the largest difference over the largest of its kind and parameter."""
    worst = 0.0
    # With them, what rounding of the navigators makes [m, m/s, rad].
    for first, rounding in ((0, 4e-9), (3, 2e-11), (6, 1e-14)):
        left = rounding / SIZES
        size = np.abs(own[:, first : first + 3]).max(axis=(0, 1))
        off = np.abs(S - own)[:, first : first + 3].max(axis=(0, 1))
        worst = max(worst, ((off - left) / np.maximum(size, left)).max())
    return worst


BENCHED, FLOWN = (60.0, 600.0, 1800.0), (180.0, 520.0, 900.0)
LEANT = (62.0, 150.0, 240.0)  # the first while it rolls


@pytest.mark.parametrize("is_aligned", [False, True])
@pytest.mark.parametrize("aided", [False, True])
@pytest.mark.parametrize(
    ("route", "times"),
    [(BENCH, BENCHED), (FLIGHT, FLOWN), (BANKED, LEANT)],
    ids=["bench", "flight", "banked"],
)
def test_constants_are_those_of_navigators(route, times, aided, is_aligned):
    """Biases and scale factors, each by itself: to 1e-6 of the largest."""
    alignment = 300.0 if is_aligned else 0.0
    S = by_equations(route, times, alignment=alignment, aided=aided)
    own = flown(route, times, aided=aided)[is_aligned]
    assert gap(S, own) < 1e-6


WARM = {
    "name": "warm",
    "environment": {"temperature": {}, "vibration": "1 g"},
    "age": "0 s",
    "mission": {
        "latitude": "50 deg",
        "alignment": "perfect",
        "altitude": "aided",
        "segments": [
            {"straight": "50 s", "speed": "40 m/s", "vibration": "2 g"},
            {"turn": "120 deg", "rate": "2 deg/s"},
            {"straight": "130 s", "vibration": "3 g"},
        ],
    },
}
COURSES = {
    "warm-up": (
        {"warm_up": {"by": "20 degC", "time": "80 s"}},
        lambda t: -20.0 * np.exp(-t / 80.0),
        lambda t: 0.25 * np.exp(-t / 80.0),
    ),
    "profile": (
        {
            "reference": "25 degC",
            "profile": [["31 s", "20 degC"], ["150 s", "45 degC"]],
        },
        lambda t: np.clip(-5.0 + 25.0 * (t - 31.0) / 119.0, -5.0, 20.0),
        lambda t: 25.0 / 119.0 * ((t > 31.0) & (t < 150.0)),
    ),
}
COEFFICIENTS = {
    "bias_temperature_coefficient": (1e-8, 2e-5),
    "scale_factor_temperature_coefficient": (2e-5, 3e-6),
    "bias_temperature_rate_coefficient": (1e-6, 2e-3),
    "vibration_rectification": (2e-10, 3e-7),
}


@pytest.mark.parametrize("course", COURSES)
def test_a_course_on_the_way_is_that_of_navigators(course):
    """Coefficients of a known temperature and vibration: each line, to 1e-3."""
    said, at, slope = COURSES[course]
    environment = {**WARM["environment"], "temperature": said}
    mission = load_mission({**WARM, "environment": environment})
    times = (60.0, 240.0)
    motion = motion_of(mission.route, step=1.0, turn=np.pi / 360.0)
    ends = np.cumsum(motion.durations)
    middle = ends - motion.durations / 2.0
    shaking = np.select([middle < 50.0, middle < 110.0], [2.0, 1.0], 3.0) * 9.80665
    sizes = np.array([*COEFFICIENTS.values()])  # (lines, 2)
    felt = {
        "bias_temperature_coefficient": at(middle),
        "scale_factor_temperature_coefficient": at(middle),
        "bias_temperature_rate_coefficient": slope(middle),
        "vibration_rectification": shaking**2,
    }
    own = []
    for (name, size), u in zip(felt.items(), sizes, strict=True):
        e = np.diag(np.repeat(u, 3))
        off = np.concatenate([np.zeros((1, 6)), e, -e])

        def errors(step, ideal, *, off=off, size=size, by_input="scale" in name):
            return off * size[step] * (ideal if by_input else 1.0)

        begin = np.tile(motion.body, (13, 1, 1))
        stops = {int(np.argmin(np.abs(ends - time))) for time in times}
        found = []
        for state in navigate(motion, errors, begin, stops):
            one = type(state)(state.body[:1], state.velocity[:1], state.place[:1])
            left = seen(state, one)[1:]
            found.append((left[:6] - left[6:]) / 2.0)
        own.append(np.sqrt((np.array(found) ** 2).sum(axis=1)))  # (times, 9)
    sensors = tuple(
        sensor(kind, dict(zip(COEFFICIENTS, sizes[:, place], strict=True)))
        for place, kind in enumerate(("gyro", "accelerometer"))
    )
    how = in_use(uncalibrated("none"), None, mission)
    outputs = [x for x in mission_outputs(mission, times) if x.axis != "horizontal"]
    rows = [k for k in range(9) if k not in {2, 5}]
    problem = mission_problem(sensors, how, mission, outputs)
    law = propagate(problem)
    whole = np.sqrt((np.array(own) ** 2).sum(axis=0))[:, rows].ravel()
    assert_allclose(law.standard_uncertainty[: len(whole)], whole, rtol=1e-3)
    for name, u in zip(felt, own, strict=True):
        only = frozenset({f"gyro.{name}", f"accelerometer.{name}"})
        alone = mission_problem(sensors, how, mission, outputs, only=only)
        found = propagate(alone).standard_uncertainty[: len(whole)]
        assert_allclose(found, u[:, rows].ravel(), rtol=1e-3)
    # Control: a temperature that stays as it begins is another.
    steady = {"temperature": f"{at(np.array(0.0)):.9g} degC".replace("-", "")}
    other = load_mission({**WARM, "environment": {**environment, **steady}})
    held = in_use(uncalibrated("none"), None, other)
    law = propagate(mission_problem(sensors, held, other, outputs))
    assert np.abs(law.standard_uncertainty[: len(whole)] / whole - 1.0).max() > 0.05


@pytest.mark.parametrize(("route", "times"), [(FLIGHT, FLOWN), (BANKED, LEANT)])
def test_a_unit_without_errors_stays_on_its_route(route, times):
    """What an ideal unit senses leads where the route does, to a millimetre."""
    motion = motion_of(route)
    ends = np.cumsum(motion.durations)
    stops = {int(np.argmin(np.abs(ends - time))) for time in times}
    none = np.zeros((1, 6))
    states = navigate(motion, lambda *_: none, motion.body[None], stops, aided=False)
    true = route.steps(times).ends
    for place, state in enumerate(states):
        off = (state.place[0, 0] - true.latitude[place]) * 6.4e6
        assert abs(off) < 1e-3
        assert abs(state.place[0, 2] - true.height[place]) < 1e-3
        assert_allclose(state.velocity[0], true.velocity[place], rtol=0, atol=1e-5)
        assert_allclose(state.body[0], true.body[place], rtol=0, atol=5e-9)


def test_what_is_wrong_is_seen(monkeypatch):
    """Controls: the earth turns the other way, axes swapped, alignment forgotten."""
    route, times = FLIGHT, FLOWN
    own = flown(route, times, aided=True)[True]
    S = by_equations(route, times, alignment=300.0)
    assert gap(S, own) < 1e-6
    swapped = S[..., [1, 0, *range(2, 12)]]
    assert gap(swapped, own) > 0.1
    assert gap(by_equations(route, times), own) > 0.1
    monkeypatch.setattr("budget.navigation.dynamics.ROTATION_RATE", -7.292115e-5)
    assert gap(by_equations(route, times, alignment=300.0), own) > 0.1


def test_an_hour_on_the_bench():
    """0.02 deg/h on all gyros at 34.2394 deg: north, east and heading as printed."""
    (S,) = by_navigation(motion_of(BENCH, step=10.0), (3600.0,))
    u = np.sqrt((S[:, :3] ** 2).sum(axis=1)) * 0.02 * DEG_PER_HOUR
    assert_allclose(u[:2], [2693.3, 2708.4], rtol=2e-5)
    assert_allclose(u[8] / ARCSEC, 93.28, rtol=5e-5)


def test_errors_of_an_alignment():
    """A navigator that levels itself: b/g, e/(W cos L); none of position at rest."""
    motion = motion_of(BENCH, step=10.0)
    S = by_navigation(motion, (10.0, 3600.0), is_aligned=True)
    right = 0
    roll = abs(S[0, 6:8, 3 + right]).max() * 100.0 * MICRO_G / ARCSEC
    # Normal gravity there is 9.79656 m/s^2, a g of the unit 9.80665.
    assert_allclose(roll, 20.647, rtol=1e-4)
    heading = abs(S[0, 8, right]) * 0.01 * DEG_PER_HOUR / (60.0 * ARCSEC)
    assert_allclose(heading, 2.764716, rtol=1e-6)
    assert np.abs(S[1, :2, [right, 3 + right]] * SIZES[[[right], [3]]]).max() < 1e-6
    half, rest = Leg(duration=2.0, turn_rate=np.pi / 2.0), Leg(duration=598.0)
    turned = Legs(start=BENCH.start, legs=(half, rest))
    times = (600.0,)
    plain, both = (S[0, :2, right] for S in flown(turned, times, aided=True))
    # After half a turn the bias acts with what hid it: twice, about.
    assert_allclose(np.linalg.norm(both) / np.linalg.norm(plain), 2.0, rtol=0.01)


RUNS = 400


def by_drawing(motion, until, *, step_noise, alignment, rng):
    """Return errors at the end of RUNS navigators with noise, (runs, 9)."""
    steps = int(np.argmin(np.abs(np.cumsum(motion.durations) - until)))
    at_rest = np.concatenate([motion.rate[0, 0], motion.force[0, 0]])
    mean, noise = step_noise(motion.durations, alignment, rng)
    begin = np.tile(motion.body, (RUNS + 1, 1, 1))
    if alignment:
        begin[1:] = aligned((at_rest + mean)[:, :3], (at_rest + mean)[:, 3:])
    off = np.concatenate([np.zeros((len(noise), 1, 6)), noise], axis=1)
    (state,) = navigate(motion, lambda step, _: off[step], begin, {steps})
    true = type(state)(state.body[:1], state.velocity[:1], state.place[:1])
    return seen(state, true)[1:]


NOISES = {
    "white": (UnitWhiteNoise(), np.array([1e-6] * 3 + [1e-4] * 3)),
    "Gauss-Markov": (Markov(times=(200.0,)), np.array([2e-7] * 3 + [2e-4] * 3)),
}


def drawn(kind, u):
    """Return what draws a noise: its mean while aligned, then it, held in each step."""

    def draw(h, alignment, rng):
        z = rng.standard_normal((len(h), RUNS, 6))
        if kind == "white":
            mean = rng.standard_normal((RUNS, 6)) * u / max(alignment, 1.0) ** 0.5
            return mean, u / np.sqrt(h)[:, None, None] * z
        tau = 200.0
        now, mean = rng.standard_normal((RUNS, 6)), np.zeros((RUNS, 6))
        parts = 100
        fade = np.exp(-alignment / parts / tau)
        for _ in range(parts if alignment else 0):
            old = now
            now = fade * now
            now = now + np.sqrt(1 - fade**2) * rng.standard_normal(now.shape)
            mean += 0.5 * (old + now) / parts
        found = []
        for step, one in zip(h, z, strict=True):
            fade = np.exp(-step / tau)
            old, now = now, fade * now + np.sqrt(1 - fade**2) * one
            found.append(0.5 * (old + now) * u)
        return mean * u, np.array(found)

    return draw


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(NOISES))
@pytest.mark.parametrize("alignment", [0.0, 400.0])
@pytest.mark.parametrize(
    ("route", "until"), [(BENCH, 3600.0), (FLIGHT, 900.0)], ids=["bench", "flight"]
)
def test_noise_is_that_of_navigators(route, until, alignment, kind):
    """Variances of 400 runs within 4.5 of their standard errors; and not of others."""
    noise, u = NOISES[kind]
    rng = np.random.default_rng(20240)
    errors = by_drawing(
        motion_of(route, step=10.0),
        until,
        step_noise=drawn(kind, u),
        alignment=alignment,
        rng=rng,
    )
    parts = [AxisNoise(row=row, noise=noise, u=u[row]) for row in range(6)]

    def expected(**options):
        given = {"first": route.first, "steps": route.steps((until,)), "aided": True}
        C = Growth(**{**given, "alignment": alignment, **options}).of_noise(parts)
        return C[0, :, 0]

    rows = [0, 1, 3, 4, 6, 7, 8]
    e = errors[:, rows]

    def off(C):
        """Return the worst of variances and correlations, in standard errors."""
        C = C[np.ix_(rows, rows)]
        s = np.sqrt(np.diag(C))
        R = C / np.outer(s, s)
        found = (e / s).T @ (e / s) / RUNS
        return (np.abs(found - R) / np.sqrt((1.0 + R**2) / RUNS)).max()

    assert off(expected()) < 4.5
    # Controls: aligned or not, and noise a quarter larger.
    assert off(expected(alignment=0.0 if alignment else 400.0)) > 4.5
    assert off(1.25**2 * expected()) > 4.5


def banked(t):
    """Return place and attitude, (..., 3) each, of a flight that banks and climbs."""
    swing = np.sin(2.0 * np.pi * t / 120.0)
    ahead = 120.0 * t
    place = [0.7 + ahead / 6.4e6, 0.2 + 1e-4 * swing, 3000.0 + 50.0 * swing]
    attitude = [0.6 * swing, 0.1 + 0.1 * swing, 0.5 * swing + 0.3]
    return tuple(np.stack(np.broadcast_arrays(*one), -1) for one in (place, attitude))


def body_at(t):
    """Return right, forward and up of that flight as columns."""
    R = Rotation.from_euler("ZYX", banked(t)[1][..., ::-1].reshape(-1, 3)).as_matrix()
    front, right, down = np.moveaxis(R.reshape(*t.shape, 3, 3), -1, 0)
    return np.stack([right, front, -down], axis=-1)


def velocity_at(t, d=1e-2):
    """Return its velocity by differences of fourth order."""
    place = banked(t)[0]
    scale = np.stack([*radii(place[..., 0], place[..., 2]), -np.ones_like(t)], -1)
    scale[..., 1] *= np.cos(place[..., 0])
    return scale * slope_by(lambda t: banked(t)[0], t, d)


def slope_by(f, t, d=1e-2):
    """Return a time derivative by differences of fourth order."""
    return (8.0 * (f(t + d) - f(t - d)) - (f(t + 2 * d) - f(t - 2 * d))) / (12.0 * d)


def test_a_recorded_flight_that_banks(monkeypatch):
    """Constants of a vehicle that is never level: to 3e-4, in short steps to 2e-6."""
    until, h = 150.0, 0.25
    t = np.arange(0.0, until, h)[:, None] + h * np.array([0.0, 0.5, 1.0])
    C, v = body_at(t), velocity_at(t)
    L, _, height = np.moveaxis(banked(t)[0], -1, 0)
    north, east = radii(L, height)
    spin = 7.292115e-5 * np.stack([np.cos(L), 0.0 * L, -np.sin(L)], -1)
    carried = [v[..., 1] / east, -v[..., 0] / north, -v[..., 1] * np.tan(L) / east]
    carried = np.stack(carried, -1)
    W = C.swapaxes(-1, -2) @ slope_by(body_at, t)
    turning = np.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], -1)
    force = slope_by(velocity_at, t) + np.cross(2.0 * spin + carried, v)
    force[..., 2] -= gravity(L, height)
    motion = Motion(
        durations=np.full(len(t), h),
        rate=np.einsum("stij,sti->stj", C, spin + carried) + turning,
        force=np.einsum("stij,sti->stj", C, force),
        latitude=L[0, 0],
        height=height[0, 0],
        velocity=v[0, 0],
        body=C[0, 0],
    )
    times = (60.0, 150.0)
    own = by_navigation(motion, times, aided=False)
    samples = np.arange(0.0, until + 0.05, 0.1)
    place, attitude = banked(samples)
    track = Track(
        time=samples,
        latitude=place[:, 0],
        longitude=place[:, 1],
        height=place[:, 2],
        attitude=attitude,
    )
    assert gap(by_equations(track, times, aided=False), own) < 3e-4
    # Control: the bank to the other side.
    other = replace(track, attitude=attitude * [-1.0, 1.0, 1.0])
    assert gap(by_equations(other, times, aided=False), own) > 1e-2
    monkeypatch.setattr("budget.navigation.route.BEND", 1e-3)
    monkeypatch.setattr("budget.navigation.route.TURN_STEP", 0.01)
    assert gap(by_equations(track, times, aided=False), own) < 2e-6
