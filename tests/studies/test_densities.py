"""Densities of the critical outputs: the trials of Monte Carlo, and the normal law."""

from __future__ import annotations

import builders
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from places import put
from scipy.special import ndtr

from budget import analyze, load_device, load_procedure, load_requirement
from budget.calibration.problem import calibration_problem
from budget.distributions import NORMAL, UNIFORM
from budget.errors import CallError, ProblemError
from budget.methods.execution import BLOCK
from budget.methods.monte_carlo import sample
from budget.methods.trials import first_trials
from budget.problem import Group, Output, Problem
from budget.question import question_of
from budget.studies.conformity import assess
from budget.studies.densities import BINS, critical_densities
from budget.ties import ALIKE

TRIALS = 3 * BLOCK + 17


def paper_problem():
    """Return the built-in calibration."""
    return calibration_problem(
        (builders.paper_gyro(), builders.paper_accelerometer()), builders.procedure()
    )


def test_first_trials_are_those_of_a_sample():
    """Interval ends equal, bit for bit, those that sample takes of as many trials."""
    drawn = sample(paper_problem(), trials=TRIALS, seed=5)
    values = first_trials(paper_problem(), trials=TRIALS, seed=5)

    assert values.shape == (24, TRIALS)
    q = int(TRIALS * 0.95 + 0.5)
    r = (TRIALS - q + 1) // 2 - 1
    ordered = np.sort(values)
    assert_array_equal(ordered[:, [r, r + q]], drawn.interval)
    assert_allclose(values.mean(axis=1), drawn.mean, rtol=1e-9, atol=1e-25)


def test_chosen_outputs_are_rows_of_all():
    """Places of outputs give those rows, in the order of the places."""
    every = first_trials(paper_problem(), trials=100)
    some = first_trials(paper_problem(), trials=100, outputs=[20, 3])

    assert_array_equal(some, every[[20, 3]])


def test_trials_that_are_known_are_not_drawn_again():
    """More trials begin with those, bit for bit: whole blocks stay as given."""
    few, more = 5000, 9000
    known = first_trials(paper_problem(), trials=few, outputs=[20, 3])
    every = first_trials(paper_problem(), trials=more, outputs=[20, 3])

    how = {"trials": more, "outputs": [20, 3]}
    assert_array_equal(first_trials(paper_problem(), known=known, **how), every)
    marked = first_trials(paper_problem(), known=0.0 * known, **how)
    assert_array_equal((marked == 0.0).sum(axis=1), BLOCK)
    assert_array_equal(marked[:, BLOCK:], every[:, BLOCK:])
    fewer = first_trials(paper_problem(), trials=100, outputs=[20, 3], known=known)
    assert_array_equal(fewer, every[:, :100])


def test_another_seed_has_other_trials():
    """Control: bit for bit equality sees another seed."""
    one, other = (first_trials(paper_problem(), trials=9, seed=s) for s in (0, 1))
    assert (one != other).any()


def test_trials_that_are_not_finite_are_refused():
    """A model that overflows raises, as it does for a sample; no trials do too."""
    problem = Problem(
        groups=(Group.independent("x", u=1.0),),
        outputs=(Output(name="y"),),
        function=lambda x: np.where(x > 0.0, np.inf, x),
    )
    with pytest.raises(ProblemError, match="not finite"):
        first_trials(problem, trials=100)
    with pytest.raises(CallError, match="trials is 0"):
        first_trials(paper_problem(), trials=0)


def drawn(device, **options):
    """Return budget and densities of a device without a requirement."""
    procedure = load_procedure()
    budget = analyze(device, procedure=procedure, validate=False, **options)
    return budget, critical_densities(question_of(budget), budget, None)


def bias_only(tmp_path, distribution):
    """Return a gyro with a bias repeatability alone: its bias error is that draw."""
    file = put(
        tmp_path / "one.yaml",
        "name: one\ngyro:\n  errors:\n    bias_repeatability: "
        f"{{value: 0.05 deg/h, distribution: {distribution.name}}}\n",
    )
    return load_device(file)


def largest_misfit(density):
    """Return the largest gap of counts from the normal law, in standard deviations.

    A bin of probability p holds a binomial number of trials; only bins with p M of 20
    or more are near enough to normal for that scale.
    """
    share = np.diff(ndtr((density.edges - density.mean) / density.u))
    found = density.density * np.diff(density.edges) * density.trials
    spread = np.sqrt(density.trials * share * (1.0 - share))
    full = density.trials * share >= 20.0
    return float((np.abs(found - density.trials * share) / spread)[full].max())


def test_a_normal_error_has_the_normal_density(tmp_path):
    """No bin is further than 5 standard deviations of its count from the law."""
    _, (density,) = drawn(bias_only(tmp_path, NORMAL))

    assert density.output.name.startswith("gyro.bias")
    assert largest_misfit(density) < 5.0


def test_the_check_of_the_density_can_fail(tmp_path):
    """Control: a uniform error of the same spread is far from the normal density."""
    _, (density,) = drawn(bias_only(tmp_path, UNIFORM))

    assert largest_misfit(density) > 20.0


def test_densities_integrate_to_one():
    """Every critical output of the paper's device: area 1, and all trials within."""
    budget, densities = drawn(load_device("zhao-2019"))

    assert [d.output.name.rpartition(".")[0] for d in densities] == [
        f"{sensor}.{parameter}"
        for sensor in ("gyro", "accelerometer")
        for parameter in ("scale_factor", "mounting_angle", "bias")
    ]
    for density in densities:
        assert density.density.shape == (BINS,)
        assert density.trials == 100_000
        assert_allclose(density.density @ np.diff(density.edges), 1.0, rtol=1e-12)
        row = budget.output(density.output.name)
        assert_allclose(density.interval, row.interval, rtol=1e-12)
        assert_allclose([density.u], row.standard_uncertainty, rtol=1e-12)
        # An end is a quantile; at 2.5 % its standard error is 2.7 u/sqrt(M) of a
        # normal output, so this is 5 of them.
        gap = np.abs(np.subtract(density.interval_mc, density.interval))
        assert (gap < 13.5 * density.u / np.sqrt(density.trials)).all()
        assert density.limit is None


def test_without_limits_the_widest_of_each_group_is_drawn():
    """No output of its group has a larger standard uncertainty."""
    budget, densities = drawn(load_device("zhao-2019"))
    for density in densities:
        group = density.output.name.rpartition(".")[0]
        widest = max(
            row.standard_uncertainty
            for row in budget.outputs
            if row.output.name.rpartition(".")[0] == group
        )
        assert_allclose(density.u, widest, rtol=ALIKE)  # of equal ones the first


def test_with_limits_the_worst_of_each_limited_group_is_drawn(tmp_path):
    """The output with the largest utilisation is drawn, with its limit; others not."""
    file = put(
        tmp_path / "limits.yaml",
        "name: limits\nreference: next_turn_on\nlimits:\n  gyro:\n"
        "    bias: {x: 0.9 deg/h, y: 0.1 deg/h, z: 0.8 deg/h}\n",
    )
    device, requirement = load_device("zhao-2019"), load_requirement(file)
    procedure = load_procedure()
    budget = analyze(
        device,
        procedure=procedure,
        requirement=requirement,
        validate=False,
        coverage=requirement.coverage,
        reference=requirement.reference,
    )
    (density,) = critical_densities(
        question_of(budget), budget, assess(budget, requirement), trials=1000
    )

    assert density.output.name == "gyro.bias.y"
    assert density.limit == requirement.limits[1].limit
    assert density.trials == 1000


def test_a_device_without_any_spread_has_no_density(tmp_path):
    """Where nothing varies there is nothing to draw."""
    file = put(
        tmp_path / "none.yaml",
        "name: none\ngyro:\n  errors:\n    bias_repeatability: 0 deg/h\n",
    )
    _, densities = drawn(load_device(file))
    assert densities == ()
