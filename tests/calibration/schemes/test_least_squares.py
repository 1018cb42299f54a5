"""Any windows by least squares: closed forms, published numbers, and pulses."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians, sqrt

import numpy as np
import pytest
from builders import (
    PAPER_ACCELEROMETER,
    PAPER_GYRO,
    paper_accelerometer,
    paper_gyro,
    procedure,
    sensor,
)
from keeping import Pulses
from numpy.testing import assert_allclose
from scipy.special import ndtri

from budget.calibration.problem import REFERENCES, calibration_problem
from budget.calibration.schemes import (
    calibrates,
    covariance,
    schedule_of,
    scheme_of,
)
from budget.errors import CallError
from budget.inputs import load_device, load_procedure
from budget.methods.gum import propagate
from budget.model.noise import GaussMarkov, White
from budget.model.response import Truth
from budget.model.scheme import Held
from budget.model.windows import OUTER, Setting, Window
from budget.names import parameters_of
from budget.studies.analysis import analyze
from budget.studies.cautions import not_weighted
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, STANDARD_GRAVITY

G = 9.7966933092
SHIPPED = (
    "six-positions",
    "six-positions-and-turns",
    "twelve-positions",
    "twenty-four-positions",
    "hand-turns",
    "one-axis-rate-table",
    "dividing-head",
)
BY_NORM = (
    *("norm-nine-positions", "norm-eighteen-positions", "norm-icosahedron"),
    "norm-and-turns-by-hand",
)
OF_BOTH = ("six-positions-and-turns", "twenty-four-positions", "hand-turns")
SIX = [(axis, sign) for axis in range(3) for sign in (1, -1)]
RUNS, FALSE_ALARM = 100, 1e-4


def how(settings, *, length=300.0, formulas="least_squares", use="both"):
    """Return a procedure whose windows follow each other, by their settings."""
    windows, start = [], 0.0
    for number, setting in enumerate(settings):
        took = abs(setting.angle) / radians(20.0) if setting.angle else length
        windows.append(
            Window(name=str(number), start=start, length=took, setting=setting, use=use)
        )
        start += took
    return replace(procedure(), windows=tuple(windows), formulas=formulas)


def turn(axis, sense, turns=1):
    """Return a turn about the vertical, with a body axis up."""
    held = Setting.face(axis, 1)
    return replace(held, turning=OUTER, angle=2.0 * pi * turns * sense)


def standard(device, plan, reference="as_tested", only=None):
    """Return the law's standard uncertainties by the name of the output [SI]."""
    problem = calibration_problem((device,), plan, reference=reference, only=only)
    law = propagate(problem)
    names = [output.name for output in problem.outputs]
    return dict(zip(names, law.standard_uncertainty, strict=True))


def test_six_positions_have_the_closed_forms_of_white_noise():
    """N/(g sqrt(2 L)) of scale factors and angles, N/sqrt(6 L) of biases."""
    N, L = 5e-4, 120.0
    device = sensor("accelerometer", {"velocity_random_walk": N})
    u = standard(device, how([Setting.face(*face) for face in SIX], length=L))

    for name, value in u.items():
        expected = N / sqrt(6.0 * L) if "bias" in name else N / (G * sqrt(2.0 * L))
        assert_allclose(value, expected, rtol=1e-11)


@pytest.mark.parametrize(
    ("order", "ppm"),
    [
        (((1, 0), (1, 1), (-1, 0), (-1, 1)), 8.7365),
        (((1, 0), (-1, 0), (1, 1), (-1, 1)), 5.0703),
        (((1, 0), (-1, 0), (-1, 1), (1, 1)), 6.4581),
    ],
)
def test_the_order_of_twelve_dwells_counts(order, ppm):
    """Scale factor of the paper's accelerometer: paired, alternating, there and back.

    Closed forms of a Gauss-Markov process over four adjacent windows of 300 s.
    """
    dwells = [
        Setting.face(axis, sign, pi * half)
        for axis in (2, 0, 1)
        for sign, half in order
    ]
    u = standard(paper_accelerometer(), how(dwells))

    for axis in "xyz":
        assert_allclose(
            1e6 * u[f"accelerometer.scale_factor.{axis}"], ppm, rtol=0, atol=6e-5
        )


@pytest.mark.parametrize(
    ("senses", "ppm"), [((1, -1, 1, -1), 0.49392), ((1, 1, -1, -1), 0.50241)]
)
def test_alternating_turns_beat_blocks(senses, ppm):
    """Four turns of 18 s of the paper's gyro; dwells see what turns do not."""
    settings = [turn(axis, sense) for axis in (2, 0, 1) for sense in senses]
    settings += [Setting.face(*face) for face in SIX]
    u = standard(paper_gyro(), how(settings))

    for axis in "xyz":  # the dwells have a part of 1e-3 in the response
        assert_allclose(1e6 * u[f"gyro.scale_factor.{axis}"], ppm, rtol=1e-3)


def test_responses_are_those_of_the_paper_where_the_windows_are():
    """Eq. (5) is least squares for the responses; its bias uses a third of them."""
    paper = procedure()
    squares = replace(paper, formulas="least_squares")
    ours, theirs = (scheme_of("accelerometer", one).weights for one in (squares, paper))

    assert_allclose(ours[:, :3], theirs[:, :3], rtol=1e-12, atol=1e-16)
    assert_allclose(ours[:, 3], 1.0 / 12.0, rtol=1e-12)


def by_heading(plan, schedule, axis):
    """Return w_h^2/2 of what an axis has of the horizontal, alike in one stop."""
    if not plan.azimuth:
        return 0.0
    level = schedule.to_body[:, axis, :2]
    stop = np.array([*schedule.stops.values()])
    return plan.place.horizontal**2 / 2.0 * (level @ level.T) * (stop == stop[:, None])


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
@pytest.mark.parametrize("name", OF_BOTH)
def test_weighted_is_the_best_linear_unbiased_estimator(owner, name):
    """W A = I, W C W^T = (A^T C^-1 A)^-1, and plain least squares is never better."""
    plan = replace(load_procedure(name), formulas="weighted", station=())
    device = paper_gyro() if owner == "gyro" else paper_accelerometer()
    best = scheme_of(owner, plan, device)
    plain = scheme_of(owner, replace(plan, formulas="least_squares"))
    inputs = best.turn + best.standing
    size = np.abs(inputs).max()
    A = np.column_stack([inputs / size, np.ones(len(inputs))])
    scale = np.array([size, size, size, 1.0])[:, None]
    tau = 300.0
    if owner == "gyro":
        parts = (
            White(density=PAPER_GYRO["angle_random_walk"]),
            GaussMarkov(sigma=PAPER_GYRO["bias_stability"], correlation_time=tau),
        )
    else:
        white = PAPER_ACCELEROMETER["sample_noise"] / sqrt(100.0)
        parts = (
            White(density=white),
            GaussMarkov(
                sigma=PAPER_ACCELEROMETER["bias_stability"], correlation_time=tau
            ),
        )
    noise = sum(part.reduce(best.schedule, np.eye(len(A))) for part in parts)
    for axis in range(3):
        C = noise + by_heading(plan, best.schedule, axis) * (owner == "gyro")
        bound = np.linalg.inv(A.T @ np.linalg.solve(C, A))
        W, V = best.weights[axis] * scale, plain.weights[axis] * scale
        assert_allclose(W @ A, np.eye(4), rtol=0, atol=1e-12)
        assert_allclose(W @ C @ W.T, bound, rtol=1e-9, atol=1e-9 * bound.max())
        excess = np.linalg.eigvalsh(V @ C @ V.T - bound)
        assert excess.min() > -1e-9 * bound.max()
        assert excess.max() > 1e-3 * bound.max()  # and is not the same


HARD = (  # a hand, and parameters that are held
    ("hand-turns", "zhao-2019", "gyro"),
    ("hand-turns", "vn-100", "gyro"),
    ("one-axis-rate-table", "adis16448", "gyro"),
    ("six-positions-and-turns", "zhao-2019", "accelerometer"),
)


def ratios(name, device, owner, *, title="by all"):
    """Return u by weighted over u by least squares of what has a spread.

    A scheme is kept for the procedure of that title.
    """
    found = []
    for formulas in ("weighted", "least_squares"):
        plan = replace(load_procedure(name), formulas=formulas, name=title)
        sensor = getattr(load_device(device), owner)
        problem = calibration_problem((sensor,), plan, reference="as_tested")
        found.append(propagate(problem).standard_uncertainty)
    resolution = [10.0 * output.resolution for output in problem.outputs]
    has_spread = found[1] > resolution
    return found[0][has_spread] / found[1][has_spread]


@pytest.mark.parametrize(("name", "device", "owner"), HARD)
def test_weighted_is_no_worse_than_plain_by_all_that_is_known(name, device, owner):
    """Station, held parameters and noise together: no u grows by weighing."""
    found = ratios(name, device, owner)

    assert found.max() <= 1.0 + 1e-6
    assert found.size > 2


def test_weighing_by_noise_alone_makes_it_worse(monkeypatch):
    """Control: what a held parameter leaves in the windows outweighs their noise."""
    nothing = np.zeros((3, 1, 1))
    monkeypatch.setattr(covariance, "_disturbances", lambda *_: ())
    monkeypatch.setattr(covariance, "_left", lambda *_: 0.0 * nothing)
    found = [ratios(*case, title="by noise alone").max() for case in HARD]

    assert max(found) > 4.0


def test_the_covariance_of_turns_is_that_of_the_hand():
    """u(eps)/L of a turn of 1 deg at the most over 8 s, in its own window alone."""
    plan = replace(load_procedure("hand-turns"), formulas="weighted")
    schedule = schedule_of("gyro", plan)
    held = Held(which=np.zeros((3, 4), dtype=bool), value=np.zeros((3, 4)))
    C, without = (
        covariance.covariances_of(paper_gyro(), one, schedule, held)
        for one in (plan, replace(plan, station=()))
    )
    turned = schedule.senses != 0.0
    u = radians(1.0) / sqrt(3.0) / 8.0

    assert turned.sum() == 3
    # The turn about an axis is felt by that axis, which stands upright then.
    own = (C - without)[:, turned, turned]
    assert_allclose(np.sort(own, axis=1)[:, -1], u**2, rtol=1e-6)
    assert_allclose((C - without)[:, ~turned, ~turned], 0.0, atol=1e-9 * u**2)


def test_five_faces_tell_all_apart():
    """Without z down the bias of z comes from the dwells on x and y.

    Of n readings of unit variance X = (1, f), u^2 = diag (X'X)^-1: over six faces
    1/6 and 1/2, over five 1/4, 1/2 and of the response to z 5/4; files.md, Windows.
    """
    N, L = 5e-4, 120.0
    device = sensor("accelerometer", {"velocity_random_walk": N})
    six, five = (
        standard(device, how([Setting.face(*face) for face in faces], length=L))
        for faces in (SIX, SIX[:5])
    )

    for name, value in five.items():
        # A turn of x about y, or of y about x, brings z in.
        grown = sqrt(2.5) if name.endswith(("factor.z", "xy", "yx")) else 1.0
        grown = sqrt(1.5) if "bias" in name else grown
        assert_allclose(value / six[name], grown, rtol=1e-10, err_msg=name)


def test_what_windows_do_not_see_is_said():
    """Without z up and down nothing shows the response to z, without downs the bias."""
    with pytest.raises(CallError, match="accelerometer") as caught:
        scheme_of("accelerometer", how([Setting.face(*face) for face in SIX[:4]]))

    assert "test procedure" in str(caught.value)
    assert "the response to z" in str(caught.value)

    with pytest.raises(CallError, match="response to z and the bias"):
        scheme_of("accelerometer", how([Setting.face(*face) for face in SIX[::2]]))


def test_a_triad_without_a_window_is_refused_in_words():
    """Dwells of the accelerometer alone say nothing of a gyro."""
    plan = how([Setting.face(*face) for face in SIX], use="accelerometer")
    with pytest.raises(CallError, match="use: gyro"):
        scheme_of("gyro", plan)


def test_weighted_without_noise_is_plain():
    """A device without a noise line has nothing to weigh by."""
    plan = load_procedure("six-positions")
    weighted = scheme_of("accelerometer", replace(plan, formulas="weighted"))

    plain = scheme_of("accelerometer", plan)
    assert_allclose(weighted.weights, plain.weights, rtol=1e-15)
    bare = paper_gyro()
    (said,) = not_weighted(
        [replace(bare, lines=bare.lines[:1])], replace(plan, formulas="weighted")
    )
    assert "gyro" in said
    assert "every window has the same weight" in said
    assert not_weighted([bare], replace(plan, formulas="weighted")) == ()


def design(scheme):
    """Return the rows (mean input, 1) of a scheme, shape (n, 4)."""
    inputs = scheme.turn + scheme.standing
    return np.column_stack([inputs, np.ones(len(inputs))])


HELD = {  # by their group or by their own names
    "biases": ("bias",),
    "scale factors": ("scale_factor",),
    "angles": ("mounting_angle",),
    "all but scale factors": ("bias", "mounting_angle"),
    "triangular": ("mounting_angle.xy", "mounting_angle.xz", "mounting_angle.yz"),
    "mixed": ("scale_factor.y", "mounting_angle.xz", "bias.x"),
}


@pytest.mark.parametrize("owner", ["gyro", "accelerometer"])
@pytest.mark.parametrize("which", HELD)
def test_held_parameters_are_error_sources_exactly(owner, which):
    """What the estimator reads off counts is what the Problem says, to rounding.

    Large errors, and counts of windows made by hand: K ((I + dT) u + b).
    """
    rng = np.random.default_rng(3)
    size = DEG_PER_HOUR if owner == "gyro" else MICRO_G
    angle, bias = rng.normal(0.0, 0.02, 6), rng.normal(0.0, 500.0, 3) * size
    device = sensor(owner, {}, bias=bias, angle=angle)
    names = parameters_of(owner)
    held = tuple(
        name for name in names if {name.quantity, name.without_owner} & {*HELD[which]}
    )
    plan = replace(load_procedure("six-positions-and-turns"), held=held)
    scheme = scheme_of(owner, plan, device)
    true = Truth(
        scale_factor=rng.normal(0.0, 0.01, (3, 1)),
        angle=angle[:, None] + rng.normal(0.0, 0.01, (6, 1)),
        bias=bias[:, None] + rng.normal(0.0, 100.0, (3, 1)) * size,
    )
    xy, xz, yx, yz, zx, zy = true.angle[:, 0]
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])
    K = 1.0 + true.scale_factor
    found = scheme.estimate(K * (np.column_stack([M, true.bias]) @ design(scheme).T))

    errors = scheme.read_errors(true, np.zeros((3, 4, 1)))
    expected = np.concatenate(
        [
            (found.scale_factor[:, None] - K) / K,
            found.mounting_angle[:, None] - true.angle,
            found.bias[:, None] - true.bias,
        ]
    )
    ours = np.concatenate([errors.scale_factor, errors.mounting_angle, errors.bias])
    estimates = [k for k, name in enumerate(names) if name not in held]
    scale = np.r_[np.ones(9), np.full(3, np.abs(design(scheme)[:, :3]).max())][:, None]
    difference = np.abs(ours - expected) / scale
    assert difference[estimates].max() < 1e-12
    assert (np.abs(ours) / scale)[estimates].max() > 1e-8  # of what is held
    assert [output.name for output in calibration_problem((device,), plan).outputs] == [
        names[k] for k in estimates
    ]


def test_a_bias_held_in_a_test_of_one_sense_is_its_scale_factor():
    """One turn: K is off by b/Omega, and by K0 where nothing tells it."""
    plan = how([turn(axis, 1) for axis in range(3)], use="gyro")
    held = tuple(n for n in parameters_of("gyro") if n.quantity != "scale_factor")
    u_b = 2.0 * DEG_PER_HOUR
    device = sensor("gyro", {"bias_repeatability": u_b})
    u = standard(device, replace(plan, held=held))

    for value in u.values():
        assert_allclose(
            value, u_b / (radians(20.0) + 8.462886 * DEG_PER_HOUR), rtol=1e-6
        )
    with pytest.raises(CallError, match="hold a parameter"):
        scheme_of("gyro", plan)


def test_hand_turns_have_the_error_of_the_hand():
    """A turn that stops within 1 deg: its scale factor is off by 1 deg/sqrt(3)/360."""
    plan = load_procedure("hand-turns")
    u = standard(sensor("gyro", {"angle_random_walk": 0.0}), plan)

    for axis in "xyz":
        assert_allclose(
            u[f"gyro.scale_factor.{axis}"], 1.0 / sqrt(3.0) / 360.0, rtol=2e-3
        )


def test_a_tumble_is_an_analysis_of_harmonics():
    """K3 is -4/g^3 times the third harmonic of the angle; K2 and bias do not mix.

    x^3 = g^3 (3 sin t - sin 3t)/4 with x = g sin t, at twelve angles t of a whole turn.
    """
    scheme = scheme_of("accelerometer", load_procedure("dividing-head"))
    t = -np.arange(12) * pi / 6.0  # of axis x, turned about y
    third = -4.0 / G**3 * np.sin(3.0 * t) / 6.0

    assert_allclose(scheme.weights[0, 5, :12], third, rtol=0, atol=1e-9 / G**3)
    assert_allclose(scheme.weights[0, 5, 12:], 0.0, rtol=0, atol=1e-9 / G**3)
    A = np.concatenate([np.tile(design(scheme), (3, 1, 1)), scheme.powers], axis=2)
    size = np.array([G, G, G, 1.0, G**2, G**3])
    found = scheme.weights @ A * size[:, None] / size
    assert_allclose(found, np.tile(np.eye(6), (3, 1, 1)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_a_tumble_finds_what_harms_other_tests(reference):
    """K2 and K3 go into no bias and no scale factor there, and into their own outputs.

    The noise of K3 is that of the third harmonic, 4/g^3 N/sqrt(6 L).
    """
    N, K2, K3 = 1e-4, 10.0 * MICRO_G / G**2, 20.0 * MICRO_G / G**3
    lines = {"scale_factor_quadratic": K2, "scale_factor_cubic": K3}
    plan = load_procedure("dividing-head")
    device = sensor("accelerometer", {"velocity_random_walk": N, **lines})
    u = standard(device, plan, reference)
    without = sensor("accelerometer", {"velocity_random_walk": N})
    noise = standard(without, plan, reference)
    other = standard(device, load_procedure("six-positions"), reference)

    assert_allclose(
        noise["accelerometer.third_order.x"], 4.0 / G**3 * N / sqrt(6 * 60), rtol=1e-9
    )
    own = {"second_order": K2, "third_order": K3} if reference == "nominal" else {}
    for name, value in u.items():
        true = own.get(name.quantity, 0.0)
        assert_allclose(value, np.hypot(noise[name], true), rtol=1e-6)
    # Of six faces two show K2 g^2, and each counts for a sixth of the bias.
    white = standard(without, load_procedure("six-positions"), reference)
    bias = "accelerometer.bias.x"
    assert_allclose(other[bias], np.hypot(white[bias], K2 * G**2 / 3.0), rtol=1e-4)
    assert not [name for name in other if "order" in name]


BOTH = (
    sensor(
        "gyro",
        {**PAPER_GYRO, "rate_random_walk": 1e-9, "scale_factor_asymmetry": 400e-6},
        bias=np.array([1.0, -2.0, 3.0]) * DEG_PER_HOUR,
        angle=np.array([10.0, -20.0, 30.0, 40.0, -50.0, 60.0]) * ARCSEC,
        tau=120.0,
    ),
    sensor(
        "accelerometer",
        {
            **PAPER_ACCELEROMETER,
            "velocity_random_walk": 5e-4,
            "scale_factor_quadratic": 20.0 * MICRO_G / STANDARD_GRAVITY**2,
            "scale_factor_cubic": 30.0 * MICRO_G / STANDARD_GRAVITY**3,
        },
        bias=np.array([1000.0, -2000.0, 3000.0]) * MICRO_G,
        angle=np.array([-15.0, 25.0, 35.0, -45.0, 55.0, 5.0]) * ARCSEC,
        tau=120.0,
    ),
)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SHIPPED, *BY_NORM])
def test_pulses_agree_with_the_law_on_every_shipped_scheme(name):
    """Sample by sample, every u is the law's within chance; 1.5 times it is not."""
    procedure = replace(load_procedure(name), sample_rate=2.0)
    devices = tuple(one for one in BOTH if calibrates(one.kind, procedure))
    pulses = Pulses(devices, procedure, seed=5)
    usual = "norm" if name in BY_NORM else "least_squares"
    cases = [(usual, reference) for reference in REFERENCES]
    cases += [("weighted", "as_tested")] if usual == "least_squares" else []
    for formulas, reference in cases:
        case, plan = f"{formulas}, {reference}", replace(procedure, formulas=formulas)
        errors = pulses.errors(RUNS, reference=reference, procedure=plan)
        law = propagate(calibration_problem(devices, plan, reference=reference))
        u = errors.std(axis=0, ddof=1)
        allowed = ndtri(1.0 - FALSE_ALARM / (2.0 * u.size)) / sqrt(2.0 * (RUNS - 1))
        off = np.abs(u / law.standard_uncertainty - 1.0)

        assert off.max() < allowed, case
        assert np.abs(u / (1.5 * law.standard_uncertainty) - 1.0).max() > allowed, case
        mean = np.abs(errors.mean(axis=0) - law.mean) / law.standard_uncertainty
        chance = ndtri(1.0 - FALSE_ALARM / (2.0 * u.size))
        assert mean.max() * sqrt(RUNS) < chance, case


def test_weighted_takes_the_floor_of_an_allan_curve_as_the_flicker_that_it_is(tmp_path):
    """The same errors as by a line of flicker of B = floor/0.664, and no plain ones."""
    path = tmp_path / "x.yaml"
    lines = {
        "floor": "bias_stability: {value: 1 deg/h, definition: allan_minimum}",
        "flicker": f"flicker: {1.0 / 0.664!r} deg/h",
    }
    found = {}
    for name, line in lines.items():
        path.write_text(
            "name: x\ngyro: {errors: {angle_random_walk: 0.1 deg/sqrt(h), "
            f"{line}}}}}\n",
            encoding="utf-8",
        )
        for formulas in ("weighted", "least_squares"):
            plan = replace(load_procedure("hand-turns"), formulas=formulas, station=())
            rows = analyze(load_device(path), procedure=plan, validate=False).outputs
            found[name, formulas] = [row.standard_uncertainty for row in rows]
    assert_allclose(
        found["floor", "weighted"], found["flicker", "weighted"], rtol=1e-12
    )
    for best, plain in zip(
        found["floor", "weighted"], found["floor", "least_squares"], strict=True
    ):
        assert best <= plain * (1.0 + 1e-9)
