"""Station and environment among the sensors' lines: Monte Carlo, Sobol', the law."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from builders import ACC_ANGLE, ACC_SF, GYRO_ANGLE, GYRO_BIAS, line, procedure, triads
from numpy.testing import assert_allclose
from scipy.stats import chi2

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.distributions import UNIFORM
from budget.inputs import load_procedure
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.methods.sobol import sobol
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, PPM

RAMP = "environment.temperature.ramp"
RANDOM = "environment.temperature.sigma"
GRAVITY, MOUNT = "station.gravity", "station.mount"
SENSORS = triads(
    {"bias_temperature_coefficient": 0.5 * DEG_PER_HOUR},
    {
        "bias_temperature_coefficient": 40.0 * MICRO_G,
        "scale_factor_temperature_coefficient": 20.0 * PPM,
    },
)
SIGMAS = 5.0  # a bound that a sound estimate misses once in a million
TRIALS = 40_000


def plan(scale=1.0):
    """Return a procedure with lines of both owners, all of them times a factor."""
    random = replace(
        line("temperature.sigma", [0.5 * scale]), correlation_time=np.array([1800.0])
    )
    return procedure(
        station=(
            line("mount", 3.0 * ARCSEC * scale, distribution=UNIFORM),
            line("gravity", [3e-4 * scale]),
            line("positioning", [2.0 * ARCSEC * scale]),
            line("latitude", [60.0 * ARCSEC * scale]),
        ),
        environment=(line("temperature.ramp", [1.0 / 3600.0 * scale]), random),
    )


@cache
def found(scale=1.0):
    """Return the calibration there, and its law."""
    problem = calibration_problem(SENSORS, plan(scale))
    return problem, propagate(problem)


def far_off(drawn, law, trials):
    """Return how many standard errors the spreads lie from the law's, at the most.

    That of a standard deviation is sqrt((k - 1)/(4 n)) of it, k the kurtosis: sums of
    normal and uniform inputs have that of the normal law, 3, at the most.
    """
    off = drawn.standard_uncertainty / law.standard_uncertainty - 1.0
    return np.abs(off).max() * np.sqrt(2.0 * trials)


def test_monte_carlo_draws_station_and_environment_as_the_law_has_them():
    """24 spreads, all correlations; the law of figures 5 % larger is refused."""
    problem, law = found()
    drawn = sample(problem, trials=TRIALS, seed=4)
    assert far_off(drawn, law, TRIALS) < SIGMAS
    assert far_off(drawn, found(1.05)[1], TRIALS) > 2.0 * SIGMAS  # the control

    def correlations(covariance):
        u = np.sqrt(np.diag(covariance))
        return (covariance / np.outer(u, u))[:12, 12:]

    exact = correlations(law.covariance)
    error = (1.0 - exact**2) / np.sqrt(TRIALS)
    off = np.abs(correlations(drawn.covariance) - exact) / error
    assert off.max() < SIGMAS
    # The control: triads that share nothing.
    assert np.abs(exact / error).max() > 10.0 * SIGMAS


@pytest.mark.parametrize(
    ("source", "output"),
    [(GRAVITY, ACC_SF), (MOUNT, GYRO_ANGLE), (MOUNT, ACC_ANGLE), (RANDOM, GYRO_BIAS)],
)
def test_indices_are_the_shares_of_the_law(source, output):
    """First order and total, by the interval of the scrambles; not another share.

    Half a 95 % interval of eight scrambles is 2.36 standard errors (t of 7); three of
    it are missed by one sound estimate in 5000.
    """
    indices = estimated()
    _, law = found()
    place = indices.factors.index(source)
    names = [group.name for group in found()[0].groups]
    parts = law.source_variance
    share = (parts / parts.sum(axis=0))[names.index(source), output]
    assert share.max() > 0.05
    for one in (indices.first, indices.total):
        value = one.value[place, output]
        half = 0.5 * (one.high - one.low)[place, output]
        # Beside the sampling: what the law leaves out, products of two sources.
        assert (np.abs(value - share) < 3.0 * half + 1e-4).all()
        assert (half < 0.02).all()
    # The control: the share of a station 20 % worse.
    worse = found(1.2)[1].source_variance
    wrong = (worse / worse.sum(axis=0))[names.index(source), output]
    value = indices.total.value[place, output]
    half = 0.5 * (indices.total.high - indices.total.low)[place, output]
    assert (np.abs(value - wrong) > 3.0 * half + 1e-4).any()


@cache
def estimated():
    """Return the indices there, once."""
    return sobol(found()[0], samples=256, seed=1)


def test_every_source_of_station_and_environment_has_an_index():
    """None is left out, and with products there is nothing beyond the whole."""
    indices = estimated()
    given = {one.name for one in (*plan().station, *plan().environment)}
    assert given <= {name.partition(".")[2] for name in indices.factors}
    assert RAMP in indices.factors
    assert_allclose(indices.first.value.sum(axis=0), 1.0, rtol=0, atol=0.01)


@pytest.mark.slow
def test_simulated_runs_at_a_table_scatter_as_the_law_says():
    """Angles of turns are drawn for the gyro, whose windows are the fewer here."""
    runs = 40
    own = replace(load_procedure(station="three-axis-table"), sample_rate=1.0)
    law = propagate(calibration_problem(SENSORS, own))
    errors = np.array([simulate(SENSORS, own, run=run) for run in range(runs)])
    # (n - 1) s^2/sigma^2 is chi-squared: its end of a probability of 1e-7 either way.
    low, high = np.sqrt(chi2.ppf([1e-7, 1.0 - 1e-7], runs - 1) / (runs - 1))
    ratio = errors.std(axis=0, ddof=1) / law.standard_uncertainty
    assert low < ratio.min() <= ratio.max() < high
    angle = next(one for one in own.station if one.name == "turn_angle")
    other = replace(own, station=(replace(angle, u=1000.0 * angle.u),))
    assert simulate(SENSORS, other, run=0)[0] != errors[0, 0]
