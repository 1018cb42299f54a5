"""Accelerometers by the norm of gravity: exact readings, published bounds, refusals."""

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
from budget.calibration.schemes import scheme_of
from budget.calibration.simulation import simulate
from budget.errors import CallError, SpecError
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.methods.trials import first_trials
from budget.model.norm import sensitivity
from budget.model.response import Truth
from budget.units import ARCSEC, MICRO_G

SHIPPED = ("norm-nine-positions", "norm-eighteen-positions", "norm-icosahedron")
OWNER = "accelerometer"


def device(rng, size):
    """Return a triad with nominal values of that size, angles [rad] and biases."""
    return sensor(
        OWNER,
        {},
        bias=rng.normal(0.0, size, 3) * 10.0,
        angle=rng.normal(0.0, size, 6),
    )


def uncertainty(plan, lines, **more):
    """Return the law's u by the name of the output, without its owner [SI]."""
    problem = calibration_problem((sensor(OWNER, lines, **more),), plan)
    u = propagate(problem).standard_uncertainty
    return {o.name.without_owner: v for o, v in zip(problem.outputs, u, strict=True)}


@pytest.mark.parametrize("name", SHIPPED)
def test_counts_at_other_attitudes_give_what_the_problem_says(name):
    """Least squares of real counts, from attitudes that nobody told it.

    The truth differs from the design by a percent; the unit stands 2 deg askew in every
    dwell, which a norm does not feel. What is held goes into what is found.
    """
    rng = np.random.default_rng(7)
    one, plan = device(rng, 0.01), load_procedure(name)
    scheme = scheme_of(OWNER, plan, one)
    true = Truth(
        scale_factor=rng.normal(0.0, 0.01, (3, 1)),
        angle=one.nominal_mounting_angle[:, None] + rng.normal(0.0, 0.01, (6, 1)),
        bias=one.nominal_bias[:, None] + rng.normal(0.0, 0.1, (3, 1)),
    )
    xy, xz, yx, yz, zx, zy = true.angle[:, 0]
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
    K = 1.0 + true.scale_factor
    askew = np.linalg.qr(np.eye(3) + rng.normal(0.0, 0.03, (len(scheme.force), 3, 3)))[
        0
    ]
    force = np.einsum("wij,wj->wi", askew, scheme.force)
    found = scheme.estimate(K * (M @ force.T + true.bias))

    errors = scheme.read_errors(true, np.zeros_like(scheme.weights[:, :, :1]))
    assert_allclose(
        errors.scale_factor, (found.scale_factor[:, None] - K) / K, rtol=0, atol=2e-8
    )
    angle = found.mounting_angle[:, None] - true.angle
    assert_allclose(errors.mounting_angle, angle, rtol=0, atol=2e-8)
    bias = found.bias[:, None] - true.bias
    assert_allclose(errors.bias, bias, rtol=0, atol=2e-8 * 9.8)
    assert np.abs(errors.mounting_angle).max() > 1e-3  # of what is held


@pytest.mark.parametrize("name", SHIPPED)
def test_the_weights_invert_the_sensitivity(name):
    """W J = I to 1e-12, J by differences of the norms themselves."""
    rng = np.random.default_rng(8)
    scheme = scheme_of(OWNER, load_procedure(name), device(rng, 0.02))
    value, places = scheme.held.value, scheme.held.estimated
    J = sensitivity(scheme.force, scheme.held)
    assert_allclose(scheme.norm_weights @ J, np.eye(9), rtol=0, atol=1e-11)

    def norms(step):
        """Return F at parameters that are off by a step, shape (n,)."""
        own, d, b = step[:3], step[3:9], step[9:]
        M, nominal = value[:, :3], value[:, 3]
        dM = np.array([[0.0, d[1], -d[0]], [-d[3], 0.0, d[2]], [d[5], -d[4], 0.0]])
        y = (M @ scheme.force.T + nominal[:, None]) / (1.0 + own)[:, None]
        s = np.linalg.solve(M + dM, y - (nominal + b)[:, None])
        return (s**2).sum(axis=0)

    h = 1e-5
    steps = np.eye(12)[places] * h
    slopes = np.array([(norms(one) - norms(-one)) / (2.0 * h) for one in steps]).T
    assert_allclose(J, slopes, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", SHIPPED[1:])
def test_noise_costs_what_skog_and_haendel_found(name):
    """Mean square errors within 8 dB of known attitudes; never below them."""
    plan = load_procedure(name)
    noise = {"velocity_random_walk": 1e-4}
    norm = uncertainty(plan, noise)
    known = uncertainty(replace(plan, formulas="least_squares"), noise)
    decibels = {key: 20.0 * np.log10(norm[key] / known[key]) for key in norm}

    assert norm.keys() == known.keys()
    assert 0.0 < min(decibels.values()) < max(decibels.values()) < 8.0


def test_even_attitudes_have_their_closed_forms():
    """Corners of an icosahedron: a bias by norm has three times the known variance.

    Of white noise N over L and n dwells u(b)^2 is 3 N^2/(n L), as each dwell shows the
    bias along gravity alone and cos^2 has the mean 1/3.
    """
    N, n, L = 1e-4, 12, 60.0
    u = uncertainty(load_procedure("norm-icosahedron"), {"velocity_random_walk": N})
    for axis in "xyz":
        assert_allclose(u[f"bias.{axis}"], N * np.sqrt(3.0 / (n * L)), rtol=1e-8)


def test_what_the_triad_is_turned_by_goes_into_the_angles():
    """One repeatability of six: an angle that is found takes in one that is held."""
    u = uncertainty(
        load_procedure("norm-icosahedron"), {"mounting_repeatability": 2.0 * ARCSEC}
    )
    for pair in ("yz", "zx", "zy"):
        assert_allclose(u[f"mounting_angle.{pair}"], 8.0**0.5 * ARCSEC, rtol=1e-6)


def test_the_law_is_that_of_the_trials():
    """1e5 trials of large errors: u within what chance allows, at 1e-4 of the tests."""
    plan, trials = load_procedure("norm-eighteen-positions"), 100_000
    lines = {
        "bias_repeatability": 3000.0 * MICRO_G,
        "scale_factor_repeatability": 3e-3,
        "mounting_repeatability": 600.0 * ARCSEC,
        "velocity_random_walk": 1e-3,
    }
    one = sensor(OWNER, lines, bias=0.05, angle=0.01)
    problem = calibration_problem((one,), plan)
    u = propagate(problem).standard_uncertainty
    drawn = first_trials(problem, trials=trials, seed=3, outputs=np.arange(u.size))

    allowed = 4.5 / np.sqrt(2.0 * trials)
    off = np.abs(drawn.std(axis=1, ddof=1) / u - 1.0)
    assert off.max() < allowed
    assert np.abs(drawn.std(axis=1, ddof=1) / (1.02 * u) - 1.0).min() > allowed


@pytest.mark.parametrize("angle", [1e-3, 0.1])
def test_a_tilt_of_the_stand_is_no_error(angle):
    """Pulses at a stand that is askew, and the problem: the same errors as level."""
    tilt = (line("levelling.east", [angle]), line("levelling.north", [angle]))
    plan = load_procedure("norm-eighteen-positions")
    one = sensor(OWNER, {}, bias=0.05, angle=0.01)
    askew = replace(plan, sample_rate=1.0, station=tilt)
    problem = calibration_problem((one,), askew)
    n = sum(group.size for group in problem.groups)
    errors = problem.function(np.full((n, 1), angle))[:, 0]

    assert_allclose(errors, problem.function(np.zeros((n, 1)))[:, 0], rtol=0, atol=0)
    assert_allclose(simulate((one,), askew, run=0), errors, rtol=0, atol=1e-9 * 9.8)
    known = calibration_problem((one,), replace(askew, formulas="least_squares"))
    assert np.abs(known.function(np.full((n, 1), angle))).max() > 0.1 * angle


def test_faces_alone_do_not_show_angles(tmp_path):
    """Six faces: which angles, and what to do."""
    faces = "".join(
        f"  - {{face: {axis} {word}, dwell: 60 s}}\n"
        for axis in "xyz"
        for word in ("up", "down")
    )
    path = put(
        tmp_path / "faces.yaml", f"name: faces\nestimator: norm\nwindows:\n{faces}"
    )
    plan = load_procedure(path)
    with pytest.raises(CallError, match="attitudes between the faces") as caught:
        scheme_of(OWNER, plan, device(np.random.default_rng(1), 0.0))

    for pair in ("yz", "zx", "zy"):
        assert f"mounting_angle.{pair}" in str(caught.value)
    run = call("analyze", "zhao-2019", "--procedure", path, code=2)
    assert "cannot tell apart" in run.err


def test_how_a_triad_is_turned_is_refused_and_not_taken_from_the_table():
    """With no angle held (`estimate: all`): which go together, no other estimator."""
    plan = replace(load_procedure("norm-eighteen-positions"), held=())
    with pytest.raises(CallError) as caught:
        scheme_of(OWNER, plan, device(np.random.default_rng(1), 0.0))

    pairs = str(caught.value).partition("apart: ")[2].partition(". ")[0]
    assert pairs.split("; ") == [
        f"mounting_angle.{a} and mounting_angle.{b}"
        for a, b in (("xy", "zy"), ("xz", "yz"), ("yx", "zx"))
    ]


@pytest.mark.parametrize(
    ("window", "words"),
    [
        ("face: z up, turn: vertical, turns: 1, rate: 9 deg/s", ("turn", "dwells")),
        ("face: z up, dwell: 9 s, use: gyro", ("use", "another estimator")),
    ],
)
def test_windows_that_have_no_norm_are_refused(tmp_path, window, words):
    """Turns, and windows of a gyro."""
    path = put(tmp_path / "mine.yaml", f"estimator: norm\nwindows:\n  - {{{window}}}\n")
    with pytest.raises(SpecError, match=r"windows\[0\]") as caught:
        load_procedure(path)

    for word in words:
        assert word in str(caught.value)


def test_a_gyro_alone_has_no_norm_of_gravity():
    """The remedy is another estimator, no window."""
    run = call("analyze", "adxrs453", "--procedure", SHIPPED[0], code=2)

    assert_says(run.err, "accelerometers alone", "another estimator")
    assert "window" not in run.err


def test_three_angles_are_held_and_said_to_be():
    """Unless the file says which; the gyro is said to be left out."""
    said = load_procedure(SHIPPED[0]).assumptions
    run = call("analyze", "zhao-2019", "--procedure", SHIPPED[0])

    assert [text for text in said if "accelerometer.mounting_angle xy, xz, yx" in text]
    assert "does not calibrate the gyro" in " ".join(run.out.split())
