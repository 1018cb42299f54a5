"""Gyros turned between dwells at unknown attitudes: exact readings, closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import line, sensor
from command_line import call
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.calibration.problem import calibration_problem
from budget.calibration.schemes import scheme_of, schemes_of
from budget.errors import CallError, SpecError
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.model.response import Errors, Truth
from budget.model.rotation import mean_rotation, rotation
from budget.units import ARCSEC, DEG_PER_HOUR

SHIPPED = "norm-and-turns-by-hand"
HEAD = "estimator: norm\nmoves: 90 deg/s\n"
FACES = "  - {face: z up, dwell: 60 s}\n  - {inner: 90 deg, dwell: 60 s}\n"
ONE = "estimate: {gyro: [scale_factor.x], accelerometer: [bias.z]}\n"


def unit(rng, size=0.0, **lines):
    """Return a gyro and the accelerometers beside it, nominal values of that size."""

    def triad(kind, scale, own):
        return sensor(
            kind,
            own,
            bias=rng.normal(0.0, size, 3) * scale,
            angle=rng.normal(0.0, size, 6),
        )

    other = triad("accelerometer", 9.8, lines.get("accelerometer", {}))
    gyro = triad("gyro", 1e-2, lines.get("gyro", {}))
    return replace(gyro, beside=other), other


def mean_readings(scheme, turned, K, angle, bias):
    """Return mean counts a second, (3, n), of angles turned in body axes, (n, 3)."""
    xy, xz, yx, yz, zx, zy = angle
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
    rates = turned / scheme.schedule.lengths[:, None] + scheme.standing
    return K[:, None] * (M @ rates.T + bias[:, None])


def vector(found):
    """Return scale factors, angles and biases one after the other, shape (12,)."""
    return np.concatenate([found.scale_factor, found.mounting_angle, found.bias])


def read(scheme, path, tmp_path, text):
    """Load a procedure of that text."""
    path = put(tmp_path / f"{path}.yaml", scheme + text)
    return load_procedure(path)


def test_turns_of_a_hand_give_the_truth():
    """No attitude and no turn is what the file says: every parameter is found.

    The truth differs from the design by a percent, each step of a turn by 3 deg, and
    the first dwell stands 10 deg askew; the directions follow from the true turns.
    """
    rng = np.random.default_rng(11)
    gyro, _ = unit(rng, 0.01)
    scheme = scheme_of("gyro", load_procedure(SHIPPED), gyro)
    still = (scheme.schedule.senses == 0.0)[:, None]
    turned = scheme.schedule.turned
    turned = turned + np.where(still, 0.0, rng.normal(0.0, 0.05, turned.shape))
    down = np.zeros((18, 3))
    down[0] = np.array([0.1, -0.15, 0.98])
    for leg in scheme.legs:
        u = down[leg.first]
        for step in leg.steps:
            u = rotation(-turned[step]) @ u
        down[leg.last] = u
    K = 1.0 + rng.normal(0.0, 0.01, 3)
    angle = gyro.nominal_mounting_angle + rng.normal(0.0, 0.01, 6)
    bias = gyro.nominal_bias + rng.normal(0.0, 1e-4, 3)
    found = scheme.estimate_beside(
        mean_readings(scheme, turned, K, angle, bias), 9.8 * down.T
    )

    assert_allclose(found.scale_factor, K, rtol=1e-9)
    assert_allclose(found.mounting_angle, angle, rtol=0, atol=1e-9)
    assert_allclose(found.bias, bias, rtol=0, atol=1e-13)


@pytest.mark.slow
def test_weights_are_the_slopes_of_the_estimate():
    """Of every axis and window, of gyros and of directions, by central differences."""
    rng = np.random.default_rng(12)
    pair = unit(rng, 0.01)
    gyro, other = pair
    schemes = schemes_of(pair, load_procedure(SHIPPED))
    scheme, beside = schemes["gyro"], schemes["accelerometer"]
    readings = mean_readings(
        scheme,
        scheme.schedule.turned,
        np.ones(3),
        gyro.nominal_mounting_angle,
        gyro.nominal_bias,
    )
    size = np.concatenate([np.ones(9), np.full(3, 1e-2)])

    def slopes(function, x, h):
        """Return the slopes of all parameters by each element of x, (12, *x.shape)."""
        found = np.zeros((12, *x.shape))
        for place in np.ndindex(*x.shape):
            step = np.zeros_like(x)
            step[place] = h
            up, low = vector(function(x + step)), vector(function(x - step))
            found[:, *place] = (up - low) / (2.0 * h)
        return found

    by_reading = slopes(
        lambda x: scheme.estimate_beside(x, beside.force.T), readings, 1e-6
    )
    missed = by_reading - np.moveaxis(scheme.weights, 1, 0)
    assert np.abs(missed / size[:, None, None]).max() < 1e-5
    assert np.abs(by_reading / size[:, None, None]).max() > 0.1

    xy, xz, yx, yz, zx, zy = other.nominal_mounting_angle
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
    by_force = slopes(
        lambda e: scheme.estimate_beside(
            readings, beside.force.T + np.linalg.solve(M, e)
        ),
        np.zeros((3, len(beside.force))),
        1e-5,
    )
    missed = by_force - np.moveaxis(beside.weights[:, -12:], 1, 0)
    assert np.abs(missed / size[:, None, None]).max() < 1e-6
    assert np.abs(by_force / size[:, None, None]).max() > 0.01


def test_errors_beside_turn_and_tilt_the_gyro():
    """What the accelerometers are turned by as a whole goes 1:1 into the gyro's angles.

    A rotation phi of their body axes about x, yx = zx = phi, moves the same angles.
    """
    pair = unit(np.random.default_rng(13))
    schemes = schemes_of(pair, load_procedure(SHIPPED))
    nothing = np.zeros((12, 1))
    truth = Truth(angle=np.zeros((6, 1)), bias=np.zeros((3, 1)))
    none = np.zeros((3, 12, 1))
    for axis, row in enumerate(((2, 4), (0, 5), (1, 3))):
        off = nothing.copy()
        off[[3 + k for k in row]] = 1e-4
        beside = Errors(scale_factor=off[:3], mounting_angle=off[3:9], bias=off[9:])
        found = schemes["gyro"].read_errors_beside(truth, none, beside, none)
        wanted = off[3:9]
        # 2e-4 of it goes by the earth rate, whose nominal attitude is not turned.
        assert_allclose(found.mounting_angle, wanted, rtol=0, atol=3e-8, err_msg=axis)
        assert_allclose(found.scale_factor, np.zeros((3, 1)), rtol=0, atol=3e-8)


def test_one_turn_has_its_closed_form(tmp_path):
    """A quarter turn about x in T: u(dk) = N sqrt(T)/(pi/2) of an angle random walk N.

    The angle that noise adds, N sqrt(T), over the angle of the turn; of a bias of u_b
    that is held T u_b over it. The dwells show neither: x points east.
    """
    N, u_b = 1e-5, 1e-6
    plan = read(HEAD, "one", tmp_path, f"{ONE}windows:\n{FACES}")
    lines = {"angle_random_walk": N, "bias_repeatability": u_b}
    gyro, _ = unit(np.random.default_rng(1), gyro=lines)
    law = propagate(calibration_problem((gyro,), plan, reference="as_tested"))
    noise, bias = law.source_variance[:, 0] ** 0.5

    (leg,) = scheme_of("gyro", plan, gyro).legs
    assert len(leg.steps) == 6
    assert_allclose(noise, N / (np.pi / 2.0), rtol=2e-6)
    assert_allclose(bias, u_b / (np.pi / 2.0), rtol=2e-6)


def test_a_gyro_alone_is_judged_with_what_is_beside_it():
    """Its outputs are those of the unit; the other's lines reach it."""
    plan = load_procedure(SHIPPED)
    gyro = {"angle_random_walk": 1e-5, "bias_repeatability": 3.0 * DEG_PER_HOUR}
    accelerometer = {"velocity_random_walk": 1e-3, "mounting_repeatability": ARCSEC}
    pair = unit(np.random.default_rng(4), 1e-3, gyro=gyro, accelerometer=accelerometer)
    both, alone = (
        propagate(calibration_problem(which, plan)) for which in (pair, pair[:1])
    )

    wanted = both.covariance[:12, :12]
    assert_allclose(alone.covariance, wanted, rtol=1e-9, atol=1e-30)
    names = [g.name for g in calibration_problem(pair[:1], plan).groups]
    noise = names.index("accelerometer.velocity_random_walk")
    assert (alone.source_variance[noise, :9] > 0.0).all()


def test_means_of_rotations_are_their_integrals():
    """Against a thousand rotations, at small and at large angles."""
    s = (np.arange(1000) + 0.5) / 1000
    for size in (1e-6, 0.05, 0.099, 0.101, 1.0, 3.0):
        v = size * np.array([0.6, -0.48, 0.64])
        mean = rotation(s[:, None] * v).mean(axis=0)
        allowed = size**2 * 1e-6 + 1e-14
        assert_allclose(mean_rotation(v), mean, rtol=0, atol=allowed)


def test_a_gyro_without_accelerometers_is_refused():
    """In words, by analyze; a comparison says that nothing was judged of it."""
    run = call("analyze", "adxrs453", "--procedure", SHIPPED, code=2)

    assert_says(run.err, "accelerometers beside it", "give a device with both")


def test_turns_that_do_not_show_all_are_refused(tmp_path):
    """One quarter turn about x: which parameters, and what to do."""
    plan = read(HEAD, "two", tmp_path, f"windows:\n{FACES}")
    gyro, _ = unit(np.random.default_rng(1))
    with pytest.raises(CallError, match="while it is level") as caught:
        scheme_of("gyro", plan, gyro)

    assert "scale_factor.y" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("moves: 9 deg/s\nwindows:\n" + FACES, ("moves", "estimator norm")),
        ("estimator: norm\nmoves: 9 m\nwindows:\n" + FACES, ("moves", "deg/s")),
        (
            HEAD + "windows:\n  - {windows: [{face: all, dwell: 1 s}], repeat: 200}\n",
            ("moves", "steps", "10000"),
        ),
    ],
)
def test_moves_that_cannot_be_are_refused(tmp_path, text, words):
    """Of another estimator, no rate, more steps than there may be windows."""
    path = put(tmp_path / "mine.yaml", text)
    with pytest.raises(SpecError) as caught:
        load_procedure(path)

    assert_says(str(caught.value), *words)


@pytest.mark.slow
def test_a_table_is_no_error_but_by_the_earth_rate():
    """Turns, stops and a base off by 0.1 deg: accelerometers nothing, gyros a w_e.

    An azimuth that is a off makes the bias of the level axes w_h a at the most.
    """
    off = ("turn_angle", "positioning", "levelling.east", "azimuth")
    plan = replace(load_procedure(SHIPPED), azimuth="")
    askew = replace(plan, station=tuple(line(name, [360.0 * ARCSEC]) for name in off))
    pair = unit(np.random.default_rng(5), 1e-3)
    law = propagate(calibration_problem(pair, askew))
    by_name = dict(zip(off, law.source_variance**0.5, strict=True))

    assert not law.source_variance[:, 12:].any()
    assert not by_name["turn_angle"].any()
    w = plan.place.earth[1] * 360.0 * ARCSEC
    for name in off[1:]:
        assert 0.001 * w < by_name[name][9:12].max() < w, name
    known = replace(askew, formulas="least_squares", held=())
    assert propagate(calibration_problem(pair[1:], known)).source_variance.any()


def test_a_way_between_dwells_is_no_stop_of_its_own():
    """One stop for each of the eighteen dwells, with the turns on from there."""
    scheme = scheme_of("gyro", load_procedure(SHIPPED))
    stops = scheme.schedule.stops

    assert scheme.schedule.n_stops == 18
    for leg in scheme.legs:
        (number,) = {stops[step] for step in leg.steps}
        assert number == leg.first


def test_accelerometers_alone_are_compared_and_a_gyro_alone_is_not():
    """Who needs the other: a gyro needs accelerometers, these need no gyro."""
    how = ("--requirement", "tactical-grade", "--procedure", SHIPPED)
    run = call("compare", "adxl357", "adxrs453", *how)

    assert "0 of 1 accelerometer meets" in run.out
    assert "of 1 gyro" not in run.out
