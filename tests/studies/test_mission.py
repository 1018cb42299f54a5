"""The growth of a mission's errors against the law of its Problem."""

from __future__ import annotations

from dataclasses import replace
from math import log, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import toeplitz
from scipy.special import sici

from budget.errors import CallError
from budget.inputs import load_device, load_mission, load_procedure, uncalibrated
from budget.methods.gum import covariance_by_source, propagate
from budget.methods.trials import first_trials
from budget.names import MISSION, Name
from budget.question import Question
from budget.results import INTERACTION
from budget.studies.analysis import analyze
from budget.studies.mission import bought, curve, growth

TIMES = (60.0, 3600.0)


@pytest.fixture(scope="module")
def bench():
    """Return the paper's unit on a bench, looked at after a minute and an hour."""
    return Question(
        devices=(load_device("zhao-2019"),),
        procedure=load_procedure(None),
        reference="next_turn_on",
        mission=load_mission("bench"),
        carried_to=TIMES,
    )


def test_the_curve_is_the_law_at_every_time(bench):
    """Each source's part, each error and radius: S U S^T is the Problem's own law."""
    found, law = curve(bench, TIMES), bench.law
    names = [output.name for output in bench.problem.outputs]
    for place, time in enumerate(TIMES):
        row = names.index(Name("position", owner=MISSION, axis="horizontal", time=time))
        parts = found.horizontal_variance()[:, place]
        assert found.sources == (*law.sources, INTERACTION)
        assert_allclose(parts[:-1], law.source_variance[:, row], rtol=1e-12, atol=0)
        assert_allclose(parts[-1], law.interaction_variance[row], rtol=1e-9)
        u = law.standard_uncertainty[row]
        for p in (0.5, 0.95):
            radius = law.coverage_factor(p)[row] * u
            assert_allclose(found.radius(p)[place], radius, rtol=1e-12)
        for quantity, axis in (("velocity", "east"), ("attitude", "heading")):
            row = names.index(Name(quantity, owner=MISSION, axis=axis, time=time))
            assert_allclose(
                found.standard_uncertainty(quantity, axis)[place],
                law.standard_uncertainty[row],
                rtol=1e-12,
            )


def test_covariances_by_source_add_up(bench):
    """Their sum is the law's covariance; products of sources are not forgotten."""
    problem = bench.problem
    law = propagate(problem)
    each = covariance_by_source(problem, law)
    n = each.shape[1]
    u = law.standard_uncertainty[:n]
    assert_allclose(
        each.sum(axis=0) / np.outer(u, u),
        law.covariance[:n, :n] / np.outer(u, u),
        rtol=0,
        atol=1e-12,
    )
    diagonal = np.einsum("skk->sk", each)
    assert_allclose(diagonal[:-1], law.source_variance[:, :n], rtol=1e-12, atol=0)
    assert_allclose(diagonal[-1], law.interaction_variance[:n], rtol=1e-9, atol=0)
    assert diagonal[-1].max() > 0.0


FLOOR = "{value: 0.5 deg/h, definition: allan_minimum}"
TIMED = FLOOR.replace("}", ", correlation_time: 300 s}")


def channel(correlation, *, n=2000):
    """Return u(p) after an hour of a level channel driven by a process of sigma 1 [m].

    p(t) = R int_0^t (1 - cos ws (t - s)) e(s) ds, ws^2 = g/R: the double integral of
    the autocovariance of e over cells of an hour, that of a cell with itself by the
    mean over lags below its length.
    """
    R, g, hour = 6371000.0, 9.80665, 3600.0
    cell = hour / n
    left = hour - cell * (np.arange(n) + 0.5)
    k = R * (1.0 - np.cos(sqrt(g / R) * left)) * cell
    near = (np.arange(10_000) + 0.5) / 10_000
    own = 2.0 * np.mean((1.0 - near) * correlation(near * cell))
    return sqrt(k @ toeplitz([own, *correlation(cell * np.arange(1, n))]) @ k)


@pytest.mark.parametrize(
    ("words", "printed", "correlation"),
    [
        # Flicker above f_L has the autocovariance -(B^2/pi) Ci(2 pi f_L tau).
        (FLOOR, "110", lambda lag: -sici(2.0 * np.pi / 86400.0 * lag)[1] / np.pi),
        (TIMED, "54", lambda lag: np.exp(-lag / 300.0)),
    ],
)
@pytest.mark.parametrize(
    "only", [None, frozenset({Name("bias_stability", owner="gyro")})]
)
def test_an_allan_floor_on_the_bench(tmp_path, words, printed, correlation, only):
    """0.5 deg/h alone: CEP after an hour in km, and by a channel of its own to 2 %."""
    path = tmp_path / "floor.yaml"
    path.write_text(
        f"name: floor\ngyro: {{errors: {{bias_stability: {words}}}}}\n"
        "accelerometer: {errors: {}}\n"
    )
    question = Question(
        devices=(load_device(path),),
        procedure=uncalibrated("factory"),
        reference="next_turn_on",
        mission=load_mission("bench"),
        carried_to=(3600.0,),
        only=only,
    )
    names = [output.name for output in question.problem.outputs]
    rows = [
        names.index(Name("position", owner="mission", axis=axis, time=3600.0))
        for axis in ("north", "east")
    ]
    u = question.law.standard_uncertainty[rows]
    circle = sqrt(2.0 * log(2.0))  # CEP over sigma of a circular Gaussian
    assert_allclose(circle * sqrt(np.mean(u**2)) / 1e3, float(printed), rtol=0, atol=1)
    sigma = 0.5 / 0.664 * np.pi / 180.0 / 3600.0
    assert_allclose(u, sigma * channel(correlation), rtol=0.02)


def test_a_noise_in_a_band_is_its_random_walk_whatever_the_rate(tmp_path):
    """N = rms/sqrt(2 B): the mission is that of the walk, and no rate is said."""
    found = []
    for line in (
        "sample_noise: {value: 0.5 deg/s, bandwidth: 50 Hz}",
        "angle_random_walk: 0.05 deg/sqrt(s)",
    ):
        path = tmp_path / "band.yaml"
        path.write_text(
            f"name: band\ngyro: {{errors: {{{line}}}}}\n"
            "accelerometer: {errors: {velocity_random_walk: 1 ug/sqrt(Hz)}}\n"
        )
        found.append(
            analyze(load_device(path), mission="bench", at=["10 s"], validate=False)
        )
    band, walk = found
    assert_allclose(
        [row.standard_uncertainty for row in band.outputs],
        [row.standard_uncertainty for row in walk.outputs],
        rtol=1e-9,
    )
    assert not any("samples of the mission" in text for text in band.assumptions)


def test_a_calibration_alone_has_no_curve(bench):
    """What is of no mission is refused in words."""
    alone = Question(devices=bench.devices, procedure=bench.procedure)
    with pytest.raises(CallError, match="give a mission"):
        curve(alone)


def test_the_library_answers_as_the_law(bench):
    """`analyze(mission=)` and `growth` of it: names, units, times, the file's too."""
    found = analyze(
        *("zhao-2019",),
        procedure="zhao-2019",
        mission="bench",
        at=["1 min", 3600],
        validate=False,
    )
    row = found.output("mission.position.horizontal.3600")
    expected = bench.law.standard_uncertainty
    names = [output.name for output in bench.problem.outputs]
    place = names.index("mission.position.horizontal.3600")
    assert_allclose(row.standard_uncertainty, expected[place], rtol=1e-12)
    assert found.settings.reference == "next_turn_on"
    table = growth(found, ["1 h", 60.0]).to_frame()
    assert table["time [s]"].tolist() == [60.0, 3600.0]
    assert_allclose(table["drms [m]"].iloc[1], row.standard_uncertainty, rtol=1e-12)
    assert table["dominant"].iloc[1] == "gyro.bias_repeatability"


LATE = {
    "name": "late",
    "limits": {"mission": {"position": {"horizontal": "1 km", "at": "2 h"}}},
}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"at": [60]}, "give mission="),
        ({"mission": "bench", "at": [7200]}, "lasts 1 h"),
        ({"mission": "bench", "at": ["3 m"]}, "is a length"),
        ({"mission": "bench", "at": [None]}, "time None"),
        ({"mission": "bench", "requirement": LATE}, "late has a limit after 2 h"),
        ({"mission": "bench", "reference": "nominal"}, "turn-on of its own"),
        ({"mission": "bench", "method": "simulation"}, "gum or monte-carlo"),
    ],
)
def test_what_does_not_fit_a_mission_is_refused(options, words, monkeypatch):
    """In words, before anything is computed."""
    monkeypatch.setattr(f"{analyze.__module__}.simulate", None)
    with pytest.raises(CallError, match=words):
        analyze("zhao-2019", validate=False, **options)
    with pytest.raises(CallError, match="has no accelerometer"):
        analyze("stim202", mission="bench")


def test_what_a_calibration_buys(bench):
    """Of the paper's unit the maker's is the mean of many turn-ons: once, not twice.

    By this test each repeatability counts twice in variance, and noise is added.
    """
    none, maker, own = bought(bench)
    assert tuple(one.lower_bound for one in (none, maker, own)) == (
        True,
        False,
        False,
    )
    assert_allclose(own.cep, curve(bench, TIMES).radius(0.5), rtol=1e-12)
    assert (np.array(own.cep) > np.array(maker.cep)).all()
    repeated = frozenset({Name("bias_repeatability", owner="gyro")})
    none, maker, own = bought(replace(bench, only=repeated))
    assert_allclose(np.array(own.cep) / np.array(maker.cep), 2.0**0.5, rtol=1e-3)
    assert_allclose(none.cep, maker.cep, rtol=1e-12)  # nothing initial is given
    changed = load_device("mpu-6050")
    made, sold, _ = bought(replace(bench, devices=(changed,)))
    assert (np.array(made.cep) > 1.3 * np.array(sold.cep)).all()


@pytest.mark.parametrize(
    ("gyro", "line"),
    [
        ({"bias_repeatability": "1 deg/h"}, "gyro.bias_repeatability"),
        ({"angle_random_walk": "1 deg/sqrt(h)"}, "gyro.angle_random_walk"),
        (
            {"bias_repeatability": "1 deg/h", "angle_random_walk": "3 deg/sqrt(h)"},
            "gyro.angle_random_walk",
        ),
    ],
)
def test_it_says_which_line_makes_a_test_cost(bench, gyro, line):
    """A noise over a short test, or what is new at every turn-on: that adds most."""
    sheet = {
        "name": "one line",
        "gyro": {"errors": gyro},
        "accelerometer": {"errors": {"bias_stability": "1 ug"}},
    }
    none, maker, own = bought(replace(bench, devices=(load_device(sheet),)))
    assert own.cep[-1] > maker.cep[-1]
    assert (own.worse_than, own.because) == (maker.name, line)
    assert none.because is maker.because is None


def test_a_test_that_holds_what_the_maker_finds_costs_it(bench):
    """The norm of gravity finds no gyro bias: what it has from its making is left."""
    changed = replace(
        bench,
        devices=(load_device("icm-20948"),),
        procedure=load_procedure("norm-nine-positions"),
    )
    *_, own = bought(changed)
    assert own.because == "gyro.initial_bias"


def test_a_test_that_costs_nothing_gives_no_reason(bench):
    """A control: of six positions the paper's unit is as its maker calibrated it."""
    *_, maker, own = bought(replace(bench, procedure=load_procedure("six-positions")))
    assert_allclose(own.cep[-1], maker.cep[-1], rtol=0.01)
    assert own.because is None


def test_beyond_first_order_is_said():
    """A unit whose attitude is lost has no meaningful position: a warning says so."""
    lost = analyze("mpu-6050", mission="outage-60-s", validate=False)
    assert any("the unit is lost" in text for text in lost.warnings)
    found = analyze("zhao-2019", mission="outage-60-s", validate=False)
    assert not any("the unit is lost" in text for text in found.warnings)


def test_trials_of_a_mission_agree_with_its_law(bench):
    """Standard uncertainties and radii of 50,000 trials, within 5 standard errors."""
    trials = 50_000
    y = first_trials(bench.problem, trials=trials, seed=1)
    law, error = bench.law, 5.0 * np.sqrt(0.5 / trials)
    assert_allclose(y.std(axis=1), law.standard_uncertainty, rtol=error)
    for p in (0.5, 0.95):
        inside = (np.abs(y) <= law.interval(p)[:, 1:]).mean(axis=1)
        assert np.abs(inside - p).max() < 5.0 * np.sqrt(p * (1.0 - p) / trials)
    half = 0.5 * law.interval(0.95)[:, 1:]  # control: another circle has another share
    assert ((np.abs(y) <= half).mean(axis=1) < 0.9).all()


def test_the_rate_of_samples_is_said():
    """A noise per sample acts by the rate of the mission, which no file gives."""
    found = analyze("zhao-2019", mission="bench", at=[60], validate=False)
    assert any("samples of the mission come at 100 Hz" in x for x in found.assumptions)
    other = analyze("hg4930#A", mission="bench", at=[60], validate=False)
    assert not any("samples of the mission" in text for text in other.assumptions)


TWO_WALKS = {
    "name": "x",
    "gyro": {"errors": {"angle_random_walk": "0.1 deg/sqrt(h)"}},
    "accelerometer": {"errors": {"velocity_random_walk": "0.1 m/s/sqrt(h)"}},
}


@pytest.mark.slow
@pytest.mark.parametrize("device", ["zhao-2019", TWO_WALKS], ids=str)
def test_the_equator_is_a_place_like_others(device):
    """Where an error is lost in the rounding of others, all goes on as nearby.

    Of the heading there, which accelerometers do not move, and its neighbourhood.
    """
    found = []
    for latitude in ("0 deg", "0.001 deg", "0.1 deg"):
        segments = [{"stand": "2 h"}]
        mission = {"mission": {"latitude": latitude, "segments": segments}}
        times = ["60 s", "600 s", "42.2 min", "3600 s", "84.4 min"]
        mission["mission"]["at"] = times
        result = analyze(device, mission=mission, validate=False)
        found.append(result)
    equator, *nearby = (
        {row.output.name: row.standard_uncertainty for row in one.outputs}
        for one in found
    )
    for one in nearby:
        for name, u in equator.items():
            assert_allclose(one[name], u, rtol=0.01, err_msg=str(name))
