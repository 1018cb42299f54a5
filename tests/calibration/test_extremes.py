"""Extremes: right to all digits that doubles leave, or refused in clear words."""

from __future__ import annotations

import json
import warnings
from functools import cache
from math import isfinite

import high_precision
import mpmath
import numpy as np
import pytest
from builders import (
    PAPER_ACCELEROMETER,
    PAPER_GYRO,
    procedure,
    sensor,
)
from command_line import call
from high_precision import State, calibrate_accelerometer, calibrate_gyro
from mpmath import mpf
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.earth import ROTATION_RATE
from budget.errors import CallError
from budget.methods.gum import propagate
from budget.units import ARCSEC, DEG_PER_HOUR, DEGREE, STANDARD_GRAVITY

pytestmark = pytest.mark.slow

# Some 10 operations on doubles lie between a figure and a result: 1e-12 leaves room
# for 1000 times their rounding, and is 1000 times closer than anyone can ask for.
CLOSE = 1e-12

LINES = {
    "gyro": {
        **PAPER_GYRO,
        "rate_random_walk": 0.01 * DEG_PER_HOUR / 60.0,
        "scale_factor_nonlinearity": 20e-6,
        "scale_factor_asymmetry": 1250e-6,
    },
    "accelerometer": {
        **PAPER_ACCELEROMETER,
        "velocity_random_walk": 1e-5 * STANDARD_GRAVITY,
        "acceleration_random_walk": 1e-7,
        "scale_factor_nonlinearity": 20e-6,
    },
}
BIAS = {"gyro": 2.5 * DEG_PER_HOUR, "accelerometer": 6e-3 * STANDARD_GRAVITY}
PLACE = {"latitude": 34.2394, "gravity": 9.7966933092}  # of builders.procedure
PLACES = {"gyro": {"z": 0, "x": 2, "y": 4}, "accelerometer": {"z": 0, "x": 4, "y": 8}}
TAUS = (1e-9, 1e-3, 17.9, 299.0, 86_399.0, 1e6, 1e9, 1e14, 1e20)


@pytest.fixture(autouse=True)
def digits():
    """Compute with 100 digits in every test here."""
    with mpmath.workdps(high_precision.DIGITS):
        yield


def windows_of(kind, *, rate=20, turns=1, dwell=300, pause=0):
    """Return (start, length) of one triad's windows in high precision [s]."""
    if kind == "gyro":
        return high_precision.gyro_windows(
            rate=rate, turns=turns, dwell=dwell, pause=pause
        )
    return high_precision.accelerometer_windows(dwell=dwell, pause=pause)


def weights(kind, axis, *, rate=20):
    """Return what the formulas use of the window averages, a matrix.

    Responses to x, y, z: differences over twice the rate or twice gravity; the bias:
    the mean of the static or own windows, of a gyro less the response to the mean earth
    rate; of a gyro then the sums of both turns about x, y, z over twice the rate.
    """
    places, n = PLACES[kind], 10 if kind == "gyro" else 12
    rows = mpmath.zeros(7 if kind == "gyro" else 4, n)
    each = 1 if kind == "gyro" else 2  # windows of one sense
    size = mpmath.radians(mpf(rate)) if kind == "gyro" else mpf(PLACE["gravity"])
    for row, name in enumerate("xyz"):
        for k in range(each):
            plus, minus = places[name] + k, places[name] + each + k
            rows[row, plus] = 1 / (2 * size * each)
            rows[row, minus] = -rows[row, plus]
            if kind == "gyro":
                rows[4 + row, plus] = rows[4 + row, minus] = rows[row, plus]
    if kind == "gyro":
        static = range(6, 10)
        w = mpf(ROTATION_RATE) * mpmath.sin(mpmath.radians(mpf(PLACE["latitude"])))
        for place in range(n):
            rows[3, place] = -w * rows[2, place]
    else:
        static = range(places["xyz"[axis]], places["xyz"[axis]] + 4)
    for place in static:
        rows[3, place] += mpf(1) / 4
    return rows


def process_covariance(windows, name, u, tau, rate):
    """Return the covariance of all window averages of one axis."""
    if name == "bias_stability":
        return high_precision.gauss_markov(windows, u, tau)
    if name in {"rate_random_walk", "acceleration_random_walk"}:
        return high_precision.random_walk(windows, u)
    density = mpf(u) / mpmath.sqrt(rate) if name == "sample_noise" else mpf(u)
    return high_precision.white(windows, density)


def group_covariance(kind, name, u, *, tau=300.0, **plan):
    """Return the package's covariance of a process, axis by axis, (3, k, k)."""
    lines = {name: u}
    if kind == "gyro":
        lines["scale_factor_asymmetry"] = 1e-3  # so that means of turns are kept too
    problem = calibration_problem(
        (sensor(kind, lines, tau=tau),), procedure(sample_rate=1000.0, **plan)
    )
    (group,) = (g for g in problem.groups if g.name == f"{kind}.{name}")
    more = group.size // 3 - 4
    order = [
        [*range(4 * a, 4 * a + 4), *range(12 + more * a, 12 + more * (a + 1))]
        for a in range(3)
    ]
    return group, [group.covariance[np.ix_(rows, rows)] for rows in order]


PLANS = (
    dict(dwell=300.0, turns=1),
    dict(dwell=1e-3, turns=1, rate=36_000.0),
    dict(dwell=86_400.0, turns=1, rate=36_000.0),
    dict(dwell=86_400.0, turns=10_000),
    dict(dwell=300.0, turns=10_000, pause=86_400.0),
)
PROCESSES = [
    *(("gyro", "bias_stability", tau) for tau in TAUS),
    *(("accelerometer", "bias_stability", tau) for tau in TAUS),
    ("gyro", "angle_random_walk", 300.0),
    ("gyro", "rate_random_walk", 300.0),
    ("accelerometer", "sample_noise", 300.0),
    ("accelerometer", "acceleration_random_walk", 300.0),
]


@pytest.mark.parametrize("plan", PLANS, ids=str)
@pytest.mark.parametrize(("kind", "name", "tau"), PROCESSES)
def test_window_covariances(kind, name, tau, plan):
    """Every statistic of every process agrees with 100 digits to 1e-12 of its size."""
    u = LINES[kind][name]
    _, found = group_covariance(kind, name, u, tau=tau, **plan)
    averages = process_covariance(windows_of(kind, **plan), name, u, tau, 1000)
    exact = None
    for axis, actual in enumerate(found):
        if exact is None or kind != "gyro":  # whose axes use all windows alike
            W = weights(kind, axis, rate=plan.get("rate", 20))
            exact = W * averages * W.T
        n = exact.rows
        scale = [mpmath.sqrt(exact[i, i]) for i in range(n)]
        correlation = [
            [float(exact[i, j] / (scale[i] * scale[j])) for j in range(n)]
            for i in range(n)
        ]
        size = np.array([float(s) for s in scale])
        # Of the product of the two spreads: an element far below it has its rounding.
        assert_allclose(actual / np.outer(size, size), correlation, rtol=0, atol=CLOSE)


def test_window_far_out_on_the_clock_keeps_what_its_start_keeps():
    """1 ms dwells after 300 h of turns: as good as the gap between two starts is."""
    plan = dict(dwell=1e-3, turns=10_000)
    u, tau = LINES["gyro"]["bias_stability"], 1e-3
    _, (actual, *_) = group_covariance("gyro", "bias_stability", u, tau=tau, **plan)
    W = weights("gyro", 0)
    exact = (
        W
        * process_covariance(windows_of("gyro", **plan), "bias_stability", u, tau, 1000)
        * W.T
    )
    # Starts near 1.08e6 s are known to 2.3e-10 s (a double), gaps of 1 ms to 2.3e-7.
    assert_allclose(actual[3, 3], float(exact[3, 3]), rtol=2.3e-7)
    assert_allclose(np.diag(actual)[:3], float(exact[0, 0]), rtol=CLOSE)


@pytest.mark.parametrize("name", ["bias_stability", "rate_random_walk"])
@pytest.mark.parametrize("tau", TAUS)
@pytest.mark.parametrize("plan", PLANS, ids=str)
def test_factor_of_nearly_singular_windows(name, tau, plan):
    """What is drawn with has the covariance of the windows, however singular.

    A slow process makes all means of windows the same number: the smallest eigenvalue
    of their correlations goes down to 1e-16.
    """
    group, _ = group_covariance("gyro", name, LINES["gyro"][name], tau=tau, **plan)
    F = group.factor
    size = np.sqrt(np.diag(group.covariance))
    assert np.isfinite(F).all()
    assert_allclose(
        F @ F.T / np.outer(size, size),
        group.covariance / np.outer(size, size),
        rtol=0,
        atol=CLOSE,
    )


# ---- the law ------------------------------------------------------------------------


CONSTANTS = {  # what it moves, how many inputs
    "bias_repeatability": ("bias", 3),
    "mounting_repeatability": ("angle", 6),
    "scale_factor_repeatability": ("k", 3),
    "scale_factor_nonlinearity": ("k", 3),
    "scale_factor_asymmetry": ("asymmetry", 3),
}


@cache
def expansion(kind, moved, *, latitude, formulas, gravity, rate, turns, dwell):
    """Differentiate the errors of one triad by one of its inputs; None: by noise."""
    windows = windows_of(kind, rate=rate, turns=turns, dwell=dwell)
    w, zero = len(windows), [mpf(0)]
    natural = mpf(rate) / 57 if kind == "gyro" else mpf(gravity)
    angle = [mpf(2.0 * ARCSEC)] * 6
    still = dict(
        bias=[mpf(BIAS[kind])] * 3,
        angle=angle,
        k=zero * 3,
        asymmetry=zero * 3,
        noise=[zero * w] * 3,
    )

    def errors(x):
        if moved is None:
            values = {"noise": [x[axis * w : (axis + 1) * w] for axis in range(3)]}
        else:
            values = {moved: [p + q for p, q in zip(still[moved], x, strict=True)]}
        state = State(**{**still, **values})
        if kind == "gyro":
            K, d, b = calibrate_gyro(
                state,
                windows,
                rate=rate,
                turns=turns,
                latitude=latitude,
                azimuths=(0, 180, 270, 450),
                formulas=formulas,
            )
        else:
            K, d, b = calibrate_accelerometer(state, gravity=gravity)
        return [
            *(k - 1 for k in K),
            *(found - true for found, true in zip(d, angle, strict=True)),
            *(found - mpf(BIAS[kind]) for found in b),
        ]

    if moved is None:
        return high_precision.expand(errors, [natural] * (3 * w))
    size = natural if moved == "bias" else mpf(1)
    return high_precision.expand(errors, [size] * len(still[moved]))


def exact_law(kind, name, u, *, tau, rate, turns, dwell, **place):
    """Return u of every output from one source alone, in 100 digits."""
    moved, n = CONSTANTS.get(name, (None, 0))
    found = expansion(kind, moved, rate=rate, turns=turns, dwell=dwell, **place)
    if moved is not None:
        return high_precision.propagate(found, mpmath.eye(n) * mpf(u) ** 2)
    windows = windows_of(kind, rate=rate, turns=turns, dwell=dwell)
    C = process_covariance(windows, name, u, tau, 1000)
    U = mpmath.zeros(3 * C.rows)
    for axis in range(3):
        for i in range(C.rows):
            for j in range(C.rows):
                U[axis * C.rows + i, axis * C.rows + j] = C[i, j]
    return high_precision.propagate(found, U)


def compare_with_law(kind, name, factor=1.0, tau=300.0, slip=0.0, **changes):
    """Assert that the package's law of one source alone is the exact one."""
    u = factor * LINES[kind][name]
    place = dict(latitude=34.2394, formulas="corrected", gravity=9.7966933092)
    plan = dict(rate=20.0, turns=1, dwell=300.0)
    place |= {key: changes[key] for key in place.keys() & changes.keys()}
    plan |= {key: changes[key] for key in plan.keys() & changes.keys()}
    exact = exact_law(kind, name, u * (1.0 + slip), tau=tau, **place, **plan)
    triad = sensor(kind, {name: u}, bias=BIAS[kind], angle=2.0 * ARCSEC, tau=tau)
    problem = calibration_problem(
        (triad,), procedure(sample_rate=1000.0, **place, **plan)
    )
    law = propagate(problem)
    expected = np.array([float(value) for value in exact])
    # An output that the source does not reach is 0 exactly; the difference quotients
    # leave less than 1e-30 of its natural size, 1e14 times its resolution.
    nothing = 1e-16 * np.array([output.resolution for output in problem.outputs])
    felt = expected > nothing
    actual = law.standard_uncertainty
    assert_allclose(actual[felt], expected[felt], rtol=CLOSE)
    assert_allclose(actual[~felt], 0.0, rtol=0, atol=nothing.min())
    assert felt.any()


SOURCES = [(kind, name) for kind, lines in LINES.items() for name in lines]


@pytest.mark.parametrize(("kind", "name"), SOURCES)
@pytest.mark.parametrize("factor", [1e-12, 1.0, 1e3])
def test_law_of_small_and_large_sources(kind, name, factor):
    """From 1e-12 to 1e3 of the paper's figures u agrees with 100 digits to 1e-12."""
    compare_with_law(kind, name, factor)


@pytest.mark.parametrize("latitude", [0.0, 90.0, -90.0])
@pytest.mark.parametrize("formulas", ["corrected", "paper"])
@pytest.mark.parametrize(
    "name", ["bias_repeatability", "mounting_repeatability", "scale_factor_asymmetry"]
)
def test_law_at_the_equator_and_the_poles(name, formulas, latitude):
    """Where a part of the earth rate is 0 nothing is lost or divided by it."""
    compare_with_law("gyro", name, latitude=latitude, formulas=formulas)


@pytest.mark.parametrize(
    "plan",
    [
        dict(turns=10_000),
        dict(dwell=1e-3),
        dict(dwell=86_400.0),
        dict(dwell=86_400.0, rate=36_000.0),
    ],
    ids=str,
)
@pytest.mark.parametrize(
    ("name", "tau"),
    [
        ("bias_stability", 1e-9),
        ("bias_stability", 86_399.0),
        ("bias_stability", 1e14),
        ("rate_random_walk", 0.0),
    ],
)
def test_law_of_short_and_long_tests(name, tau, plan):
    """One turn to 1e4, dwells of 1 ms to a day, tau from 1 ns to far beyond."""
    compare_with_law("gyro", name, tau=tau, **plan)


def test_the_comparison_can_fail():
    """Control: a figure that is off by 1e-11 of itself is seen."""
    with pytest.raises(AssertionError):
        compare_with_law("gyro", "bias_repeatability", slip=1e-11)


# ---- the whole way, from a file to a document ---------------------------------------

DEVICE = """name: extreme
gyro:
  nominal: {{bias: 2.5 deg/h, mounting_angle: 2 arcsec}}
  errors:
    bias_repeatability: {0} deg/h
    bias_stability: {{value: {1} deg/h, correlation_time: {tau} s}}
    angle_random_walk: {2} deg/sqrt(h)
    rate_random_walk: {3} deg/h/sqrt(h)
    scale_factor_repeatability: {4} ppm
    scale_factor_asymmetry: {5} ppm
    mounting_repeatability: {6} arcsec
"""
FIGURES = (0.05, 0.04, 0.005, 0.01, 50.0, 10.0, 2.0)
METHODS = {
    "law, validated": (),
    "Monte Carlo": ("--method", "monte-carlo", "--trials", "20000"),
    "adaptive": ("--method", "monte-carlo", "--max-trials", "40000"),
    "Sobol": ("--no-validate", "--sobol", "--samples", "32"),
    "next turn-on": ("--reference", "next_turn_on", "--max-trials", "40000"),
}
TAU_OF_FILES = ("1e-30", "1e-9", "300", "1e15", "1e30")


def numbers(document):
    """Yield every number of a document."""
    if isinstance(document, dict):
        document = list(document.values())
    if isinstance(document, list):
        for part in document:
            yield from numbers(part)
    elif isinstance(document, float):
        yield document


def analyze(folder, device, *options, procedure_text=None):
    """Analyze a device of that text; any warning of numpy is an error."""
    (folder / "device.yaml").write_text(device, encoding="utf-8")
    if procedure_text is not None:
        (folder / "procedure.yaml").write_text(procedure_text, encoding="utf-8")
        options += ("--procedure", folder / "procedure.yaml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return call("analyze", folder / "device.yaml", "--json", "-", *options)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("factor", [1e-12, 1e-6, 1e3])
def test_documents_of_small_and_large_sources(tmp_path, factor, method):
    """By every method all numbers are finite, and shares add up to 1."""
    device = DEVICE.format(*(factor * figure for figure in FIGURES), tau=300)
    run = analyze(tmp_path, device, *METHODS[method])
    assert run.code == 0, run.err
    assert all(isfinite(number) for number in numbers(run.document))
    for output in run.document["outputs"]:
        shares = [part["share"] for part in output["contributions"]]
        assert_allclose(sum(shares), 1.0, rtol=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tau", TAU_OF_FILES)
def test_documents_of_fast_and_slow_processes(tmp_path, tau, method):
    """Correlation times from 1e-30 to 1e30 s: every number is finite."""
    run = analyze(tmp_path, DEVICE.format(*FIGURES, tau=tau), *METHODS[method])
    assert run.code == 0, run.err
    assert all(isfinite(number) for number in numbers(run.document))


PROCEDURES = {
    "pole": "latitude: 90 deg\n",
    "south pole": "latitude: -90 deg\nformulas: paper\n",
    "equator": "latitude: 0 deg\nformulas: paper\n",
    "many turns": "gyro: {turns: 10000}\n",
    "day": "gyro: {dwell: 24 h}\naccelerometer: {dwell: 24 h}\n",
    "millisecond": "sample_rate: 1 kHz\ngyro: {dwell: 0.001 s}\n",
    "long pauses": "gyro: {pause: 1e30 s}\naccelerometer: {pause: 1e30 s}\n",
    "slow": "gyro: {rate: 1e-6 deg/s}\n",
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", PROCEDURES)
def test_documents_of_extreme_procedures(tmp_path, name, method):
    """At poles and equator, in a millisecond and a day: every number is finite."""
    device = DEVICE.format(*FIGURES, tau=300)
    run = analyze(tmp_path, device, *METHODS[method], procedure_text=PROCEDURES[name])
    assert run.code == 0, run.err
    assert all(isfinite(number) for number in numbers(run.document))


@pytest.mark.parametrize("figure", range(len(FIGURES)))
@pytest.mark.parametrize("size", ["1e40", "1e300", "1e-40", "1e-300"])
def test_figures_beyond_what_can_be_are_refused(tmp_path, figure, size):
    """Their fourth power would overflow, or vanish and be a 0 in silence: exit 2."""
    texts = [*map(str, FIGURES)]
    texts[figure] = size
    run = analyze(tmp_path, DEVICE.format(*texts, tau=300), "--no-validate")
    assert (run.code, run.out) == (2, "")
    assert f"found '{size} " in run.err
    assert "of a size that can be" in run.err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("latitude: 90.0001 deg\n", "expected -90 deg to 90 deg"),
        ("gyro: {dwell: 0.001 s}\n", "has no sample at 100 Hz"),
        ("gyro: {rate: 36001 deg/s}\n", "a turn of 0.00999972 s has no sample"),
        ("gyro: {turns: 0}\n", "gyro.turns: found 0"),
        ("gyro: {turns: 1000001}\n", "gyro.turns: found 1000001"),
        ("gravity: 1e-200 m/s^2\n", "of a size that can be"),
    ],
)
def test_procedures_that_cannot_be_are_refused(tmp_path, text, said):
    """What has no meaning is exit 2 with the place and what is allowed."""
    device = DEVICE.format(*FIGURES, tau=300)
    run = analyze(tmp_path, device, "--no-validate", procedure_text=text)
    assert (run.code, run.out) == (2, "")
    assert said in run.err


def test_simulation_of_windows_that_fill_the_memory_is_refused():
    """A day at 100 Hz holds 8.64e6 samples: refused, with what to do."""
    triad = sensor("gyro", {"bias_repeatability": 1e-7})
    with pytest.raises(CallError, match=r"8\.64e\+06 samples.*Lower the sample rate"):
        simulate((triad,), procedure(dwell=86_400.0), run=0)


def test_simulation_of_a_day_at_a_low_rate():
    """A day at 1 Hz is simulated: without a source all errors are rounding."""
    triad = sensor("gyro", {"bias_repeatability": 0.0}, bias=BIAS["gyro"])
    errors = simulate((triad,), procedure(dwell=86_400.0, sample_rate=1.0), run=0)
    # Sums of 86,400 samples: 1e-12 of a scale factor of 1, a rate of 1 rad/s.
    assert_allclose(errors, 0.0, rtol=0, atol=1e-12)


def test_document_of_one_big_random_walk_is_the_closed_form(tmp_path):
    """100 deg/h/sqrt(h) alone: the gyro bias has K^2 times the closed form."""
    (tmp_path / "device.yaml").write_text(
        "name: w\ngyro: {errors: {rate_random_walk: 100 deg/h/sqrt(h)}}\n",
        encoding="utf-8",
    )
    run = call("analyze", tmp_path / "device.yaml", "--no-validate", "--json", "-")
    document = json.loads(run.out)
    windows = windows_of("gyro")
    W = weights("gyro", 0)[3, :]
    K = mpf(100.0) * DEG_PER_HOUR / 60
    exact = (W * high_precision.random_walk(windows, K) * W.T)[0]
    bias = next(o for o in document["outputs"] if o["parameter"] == "bias")
    # Without nominal bias the scale-factor error times the earth rate is all that is
    # added: it stands at z, not at x, to the second order of 1e-5.
    assert_allclose(
        bias["standard_uncertainty"] * DEGREE / 3600.0,
        float(mpmath.sqrt(exact)),
        rtol=1e-4,
    )
