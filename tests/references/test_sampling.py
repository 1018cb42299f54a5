"""Standard errors of sampled numbers: as large as what seeds really do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reference_examples import parts_of

from budget.calibration.problem import calibration_problem
from budget.distributions import UNIFORM
from budget.inputs.device import read_device
from budget.inputs.procedure import read_procedure
from budget.methods.monte_carlo import sample
from budget.methods.sobol import sobol
from budget.problem import Group, Output, Problem
from budget.references.sampling import BATCHES, standard_errors

SEEDS = 300
TRIALS = 4000
# Relative standard error of a standard deviation from so many seeds, times 4; tails
# heavier than normal, as of the u of a product, make it up to twice as large.
SLACK = 2.0 * 4.0 / np.sqrt(2.0 * SEEDS)


def model(x):
    """Return a sum, a product and a square of a sum: kurtoses 2.8, 9 and 15."""
    return np.stack([x[0] + 0.5 * x[2], x[0] * x[1], (x[0] + x[1]) ** 2])


@pytest.fixture(scope="module")
def problem():
    """Provide a problem whose outputs are all but normal."""
    return Problem(
        groups=(
            Group.independent("a", u=[1.0, 1.0]),
            Group.independent("b", u=[2.0], distribution=UNIFORM),
        ),
        outputs=tuple(Output(name=name) for name in ("sum", "product", "square")),
        function=model,
    )


@pytest.fixture(scope="module")
def runs(problem):
    """Provide the results of many seeds, both kinds of interval."""
    return {
        kind: [
            sample(problem, trials=TRIALS, interval=kind, seed=seed)
            for seed in range(SEEDS)
        ]
        for kind in ("symmetric", "shortest")
    }


def spread(values):
    """Return the standard deviation over seeds."""
    return np.std(values, axis=0, ddof=1)


def test_standard_errors_of_moments_are_what_seeds_do(problem, runs):
    """Mean and u of outputs that are not normal vary from seed to seed as told."""
    told = standard_errors(problem, trials=TRIALS, coverage=0.95)
    drawn = runs["symmetric"]

    assert_allclose(told.mean, spread([r.mean for r in drawn]), rtol=SLACK)
    u = [r.standard_uncertainty for r in drawn]
    assert_allclose(told.u, spread(u), rtol=SLACK)
    # Control: the formula for a normal output, u/sqrt(2n), is far off for a product.
    normal = np.mean(u, axis=0) / np.sqrt(2.0 * TRIALS)
    assert normal[1] < 0.6 * spread(u)[1]


def test_an_end_beyond_which_lies_next_to_nothing_is_hardly_known(problem):
    """At 99.99 % two halves of the trials tell: one degree of freedom, no false alarm.

    An end of 512 trials would be their extreme, and four times too sure.
    """
    usual = standard_errors(problem, trials=TRIALS, coverage=0.95)
    rare = standard_errors(problem, trials=TRIALS, coverage=0.9999)

    assert (usual.freedom("end"), rare.freedom("end")) == (BATCHES - 1.0, 1.0)
    assert rare.freedom("u") == usual.freedom("u") == BATCHES - 1.0


def test_standard_errors_of_correlations_are_what_seeds_do(problem, runs):
    """Correlations, also of outputs that depend on each other, vary as told."""
    told = standard_errors(problem, trials=TRIALS, coverage=0.95)
    found = []
    for run in runs["symmetric"]:
        u = run.standard_uncertainty
        found.append((run.covariance / np.outer(u, u))[np.triu_indices(3, 1)])

    assert_allclose(told.correlation[np.triu_indices(3, 1)], spread(found), rtol=SLACK)
    assert_allclose(np.diag(told.correlation), 0.0, rtol=0, atol=1e-7)


@pytest.mark.parametrize("kind", ["symmetric", "shortest"])
def test_standard_errors_of_ends_are_what_seeds_do(problem, runs, kind):
    """Interval ends vary as told; the slope over half a tail may tell 30 % more."""
    told = standard_errors(problem, trials=TRIALS, coverage=0.95, interval=kind)
    ends = spread([run.interval for run in runs[kind]])

    # From 16 batches a standard error is sure to 4/sqrt(30); the square's shortest
    # interval starts at its edge, where every order statistic is as small as u/1000.
    slack = SLACK if kind == "symmetric" else 4.0 / np.sqrt(30.0)
    for ours, seeds in ((told.low, ends[:, 0]), (told.high, ends[:, 1])):
        clear = seeds > 1e-2 * told.mean
        assert (ours[clear] > (1.0 - slack) * seeds[clear]).all()
        assert (ours[clear] < (1.3 + slack) * seeds[clear]).all()


def test_standard_errors_fall_with_the_root_of_trials(problem):
    """Four times the trials halve every standard error but those of shortest ends."""
    few = standard_errors(problem, trials=1000, coverage=0.95)
    many = standard_errors(problem, trials=4000, coverage=0.95)

    for name in ("mean", "u", "low", "high"):
        assert_allclose(getattr(few, name), 2.0 * getattr(many, name), rtol=1e-12)


@pytest.mark.slow
def test_standard_errors_of_indices_are_what_seeds_do():
    """Sobol' indices of a gyro with asymmetry vary as their scrambles say."""
    device, how = parts_of()
    sensor = read_device(device).gyro
    small = calibration_problem((sensor,), read_procedure(how))
    drawn = [sobol(small, samples=64, seed=seed) for seed in range(40)]
    told = np.mean([(r.total.high - r.total.low) / 2.0 for r in drawn], axis=0)
    seen = spread([r.total.value for r in drawn])

    # The half-width is t(0.975, 7) = 2.36 standard errors.
    ratio = told / 2.3646 / np.where(seen > 0.0, seen, np.inf)
    clear = seen > 1e-9
    assert clear.sum() > 20
    assert_allclose(np.median(ratio[clear]), 1.0, rtol=0.15)
