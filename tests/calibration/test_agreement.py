"""Three methods, one answer: law, Monte Carlo and pulses agree as they should."""

from __future__ import annotations

from functools import cache
from math import sqrt

import numpy as np
import pytest
from builders import PAPER_ACCELEROMETER, PAPER_GYRO, procedure, sensor
from keeping import Pulses
from scipy.special import ndtri

from budget.calibration.problem import calibration_problem
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.model.scheme import Scheme
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

pytestmark = pytest.mark.slow

RUNS = 200
TRIALS = 1_000_000
FALSE_ALARM = 1e-4  # for all 24 outputs together

HOW = procedure(
    latitude=50.0,
    gravity=9.811,
    rate=30.0,
    turns=2,
    dwell=60.0,
    pause=7.0,
    sample_rate=10.0,
)
GYRO = sensor(
    "gyro",
    {
        **PAPER_GYRO,
        "rate_random_walk": 1e-9,
        "sample_noise": 3e-5,
        "scale_factor_nonlinearity": 20e-6,
        "scale_factor_asymmetry": 400e-6,
    },
    bias=np.array([1.0, -2.0, 3.0]) * DEG_PER_HOUR,
    angle=np.array([10.0, -20.0, 30.0, 40.0, -50.0, 60.0]) * ARCSEC,
    tau=120.0,
)
ACCELEROMETER = sensor(
    "accelerometer",
    {
        **PAPER_ACCELEROMETER,
        "velocity_random_walk": 5e-4,
        "acceleration_random_walk": 3e-6,
        "scale_factor_nonlinearity": 25e-6,
    },
    bias=np.array([1000.0, -2000.0, 3000.0]) * MICRO_G,
    angle=np.array([-15.0, 25.0, 35.0, -45.0, 55.0, 5.0]) * ARCSEC,
    tau=120.0,
)
BOTH = (GYRO, ACCELEROMETER)


@cache
def pulses(only=None):
    """Return the simulated runs; of one source alone those of its own triad."""
    sensors = BOTH if only is None else owner_of(only)
    return Pulses(sensors, HOW, seed=11, only=only and frozenset({only}))


def owner_of(source):
    """Return the triad that a source belongs to."""
    return tuple(sensor for sensor in BOTH if source.startswith(f"{sensor.kind}."))


def u_of_runs(only=None, reference="nominal"):
    """Return the standard deviation of every output over the simulated runs."""
    return np.std(pulses(only).errors(RUNS, reference=reference), axis=0, ddof=1)


@cache
def law_and_trials(reference):
    """Return the law, and Monte Carlo of 1e6 trials."""
    problem = calibration_problem(BOTH, HOW, reference=reference)
    return propagate(problem), sample(problem, trials=TRIALS, seed=5)


def disagreement(u, n, exact):
    """Return |u/exact - 1| in standard errors of a normal sample of size n."""
    return np.abs(u / exact - 1.0) * sqrt(2.0 * (n - 1))


def bound(comparisons=24):
    """Return how many standard errors chance allows, over all comparisons."""
    return float(ndtri(1.0 - FALSE_ALARM / (2.0 * comparisons)))


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_monte_carlo_agrees_with_the_law(reference):
    """1e6 trials give the law's 24 standard uncertainties within sampling error."""
    law, drawn = law_and_trials(reference)
    off = disagreement(drawn.standard_uncertainty, TRIALS, law.standard_uncertainty)
    assert off.max() < bound()


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_simulated_pulses_agree_with_the_law(reference):
    """200 runs sample by sample give the law's 24 standard uncertainties."""
    law = propagate(calibration_problem(BOTH, HOW, reference=reference))
    off = disagreement(u_of_runs(reference=reference), RUNS, law.standard_uncertainty)
    assert off.max() < bound()


@pytest.mark.parametrize(
    "source",
    [
        f"{s.kind}.{line.name}"
        for s in BOTH
        for line in s.lines
        if line.name
        in {
            "bias_stability",
            "angle_random_walk",
            "rate_random_walk",
            "sample_noise",
            "velocity_random_walk",
            "acceleration_random_walk",
        }
    ],
)
def test_each_process_alone_agrees_with_simulated_pulses(source):
    """No noise process hides behind a larger source: each agrees alone."""
    problem = calibration_problem(owner_of(source), HOW, only=frozenset({source}))
    u = propagate(problem).standard_uncertainty
    off = disagreement(u_of_runs(source), RUNS, u)
    assert off.shape == (12,)
    assert off.max() < bound(12)


def test_correlations_agree_with_the_law():
    """1e6 trials give the law's joint correlation matrix within sampling error."""
    law, drawn = law_and_trials("as_tested")

    def correlation(C):
        u = np.sqrt(np.diag(C))
        return C / np.outer(u, u)

    exact = correlation(law.covariance)
    # Standard error of a sample correlation r: (1 - r^2)/sqrt(n).
    error = np.abs(correlation(drawn.covariance) - exact) * sqrt(TRIALS)
    assert np.abs(exact - np.eye(24)).max() > 0.2  # 200 standard errors
    assert (error / (1.0 - exact**2 + np.eye(24))).max() < bound(276)


def test_a_wrong_formula_is_caught(monkeypatch):
    """Control: with d_yx of eq. (3) as misprinted, pulses and law do not agree."""
    right = Scheme.estimate

    def misprinted(scheme, readings):
        found = right(scheme, readings)
        found.mounting_angle[2] *= -1.0
        return found

    monkeypatch.setattr(Scheme, "estimate", misprinted)
    law = propagate(calibration_problem(BOTH, HOW))
    wrong = pulses().errors(RUNS // 4, reference="nominal")
    off = np.abs(np.mean(wrong, axis=0) - law.mean) / law.standard_uncertainty
    assert off.max() * sqrt(len(wrong)) > bound()


def test_mean_errors_agree_with_simulated_pulses():
    """The expected errors of 200 runs are the law's, within their standard error."""
    law = propagate(calibration_problem(BOTH, HOW))
    mean = pulses().errors(RUNS, reference="nominal").mean(axis=0)
    off = np.abs(mean - law.mean) / law.standard_uncertainty
    assert off.max() * sqrt(RUNS) < bound()


def test_a_wrong_spread_is_caught():
    """Control: a random walk 1.5 times too large fails the bound on the spread."""
    louder = sensor(
        "gyro",
        {**PAPER_GYRO, "angle_random_walk": 1.5 * PAPER_GYRO["angle_random_walk"]},
        tau=120.0,
    )
    name = "gyro.angle_random_walk"
    law = propagate(calibration_problem((louder,), HOW, only=frozenset({name})))
    off = disagreement(u_of_runs(name), RUNS, law.standard_uncertainty)
    assert off.max() > bound()
