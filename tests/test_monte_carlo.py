"""Monte Carlo: the same numbers always, and the intervals of JCGM 101."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose, assert_array_equal

from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.methods.execution import BLOCK, draw
from budget.methods.monte_carlo import sample, shortest_interval, symmetric_interval
from budget.physics.calibration import calibration_problem
from budget.problem import Group, Output, Problem

TRIALS = 3 * BLOCK + 17


def paper_problem(**more):
    """Return the built-in calibration with further gyro lines."""
    return calibration_problem((paper_gyro(**more), paper_accelerometer()), procedure())


def test_same_seed_same_numbers():
    """Two runs with one seed are equal bit for bit; another seed differs, 0 too."""
    first, again, other = (
        sample(paper_problem(), trials=TRIALS, seed=seed).values for seed in (0, 0, 1)
    )
    assert_array_equal(first, again)
    assert (first != other).any()


@pytest.mark.parametrize("workers", [2, 3])
def test_workers_change_no_number(workers):
    """1, 2 and 3 processes give the same trials bit for bit."""
    alone = sample(paper_problem(), trials=TRIALS, seed=4)
    shared = sample(paper_problem(), trials=TRIALS, seed=4, workers=workers)
    assert_array_equal(alone.values, shared.values)
    assert_array_equal(alone.covariance, shared.covariance)


def test_a_longer_run_begins_with_the_shorter_one():
    """The first trials do not depend on how many follow."""
    short = sample(paper_problem(), trials=1000).values
    long = sample(paper_problem(), trials=TRIALS).values
    assert_array_equal(short, long[:, :1000])


def test_adding_a_source_moves_no_other_draws():
    """Every source's inputs are the same bits with and without another source."""
    without, with_it = paper_problem(), paper_problem(scale_factor_nonlinearity=1e-5)

    def inputs(problem):
        x = draw(problem, 3, 2, np.empty((problem.n_inputs, BLOCK)))
        names = (group.name for group in problem.groups)
        return {n: x[rows] for n, rows in zip(names, problem.slices, strict=True)}

    before, after = inputs(without), inputs(with_it)
    assert set(after) - set(before) == {"gyro.scale_factor_nonlinearity"}
    for name, rows in before.items():
        assert_array_equal(rows, after[name])


def test_blocks_and_sources_have_streams_of_their_own():
    """No two blocks and no two sources share their numbers."""
    problem = paper_problem()
    x = [draw(problem, 0, b, np.empty((problem.n_inputs, BLOCK))) for b in (0, 1)]
    unit = np.concatenate(x) / np.std(np.concatenate(x), axis=1, keepdims=True)
    r = np.corrcoef(unit)
    # Correlations within a process are real; those between blocks must be chance.
    between = np.abs(r[: problem.n_inputs, problem.n_inputs :])
    assert between.max() < 6.0 / np.sqrt(BLOCK)


@pytest.mark.parametrize("shape", [NORMAL, UNIFORM, TRIANGULAR, ARCSINE])
def test_drawn_shapes_have_their_moments(shape):
    """Mean 0, variance 1 and the stated kurtosis, within 5 standard errors; bounded."""
    n = 400_000
    z = np.empty(n)
    shape.draw(np.random.default_rng(8), z)
    eighth = {"normal": 105.0, "uniform": 9.0, "triangular": 28.8, "arcsine": 4.375}
    assert abs(z.mean()) < 5.0 / np.sqrt(n)
    assert abs(z.var() - 1.0) < 5.0 * np.sqrt((shape.kurtosis - 1.0) / n)
    spread = np.sqrt((eighth[shape.name] - shape.kurtosis**2) / n)
    assert abs(np.mean(z**4) - shape.kurtosis) < 5.0 * spread
    assert np.abs(z).max() <= shape.half_width


def one_output(*groups):
    """Return the sum of all inputs as a Problem."""
    return Problem(
        groups=groups,
        outputs=(Output(name="Y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )


@pytest.mark.parametrize(
    ("u", "shape", "exact_end", "exact_u"),
    [
        ((1.0, 1.0, 1.0, 1.0), NORMAL, 3.919928, 2.0),
        ((1.0, 1.0, 1.0, 1.0), UNIFORM, 3.879407, 2.0),
        ((1.0, 1.0, 1.0, 10.0), UNIFORM, 17.01581, np.sqrt(103.0)),
    ],
    ids=["9.2.2", "9.2.3", "9.2.4"],
)
@pytest.mark.parametrize("kind", ["symmetric", "shortest"])
def test_jcgm_101_9_2_intervals(u, shape, exact_end, exact_u, kind):
    """Monte Carlo finds the exact 95 % interval of JCGM 101:2008, 9.2."""
    n = 1_000_000
    drawn = sample(
        one_output(
            *(
                Group.independent(f"X{i}", u=value, distribution=shape)
                for i, value in enumerate(u)
            )
        ),
        trials=n,
        seed=2,
    )
    low, high = drawn.interval(0.95, kind)[0]
    assert_allclose(drawn.standard_uncertainty[0], exact_u, rtol=4.0 / np.sqrt(2.0 * n))
    # An end is a quantile: standard error sqrt(p q/n)/f. The densities at the ends
    # are 0.029, 0.031 and 0.025 (9.2.4: the edge of a nearly flat density).
    error = np.sqrt(0.025 * 0.975 / n) / 0.025
    if kind == "symmetric":
        assert_allclose([low, high], [-exact_end, exact_end], rtol=0, atol=5 * error)
    else:
        # Ends of the shortest one wander together where the density is flat; its
        # length does not.
        assert_allclose(high - low, 2.0 * exact_end, rtol=0, atol=10 * error)


def test_intervals_of_a_small_sample_by_hand():
    """M 10, p 0.7: q 7, symmetric from value 2 to 9 (r = (M - q + 1)//2), 7.7.2."""
    values = np.array([0.0, 9.5, 1.0, 8.0, 2.0, 7.0, 3.0, 6.0, 4.0, 50.0])
    assert symmetric_interval(values, 0.7) == (1.0, 9.5)
    assert shortest_interval(values, 0.7) == (0.0, 8.0)


def test_intervals_exist_for_tiny_samples():
    """Two values give themselves as the interval at any coverage."""
    for coverage in (0.01, 0.5, 0.99):
        assert symmetric_interval(np.array([2.0, 1.0]), coverage) == (1.0, 2.0)
        assert shortest_interval(np.array([2.0, 1.0]), coverage) == (1.0, 2.0)


def test_correlated_inputs_are_drawn_with_their_covariance():
    """A group with correlation -0.8 and very different sizes keeps it."""
    C = np.array([[1.0, -0.8e-6], [-0.8e-6, 1e-12]])
    group = Group(
        name="x", mean=np.array([5.0, 1.0]), covariance=C, distributions=(NORMAL,) * 2
    )
    problem = Problem(
        groups=(group,), outputs=(Output(name="a"), Output(name="b")), function=np.copy
    )
    n = 200_000
    found = sample(problem, trials=n, seed=9)
    r = found.covariance[0, 1] / np.prod(found.standard_uncertainty)
    assert abs(r + 0.8) < 5.0 * (1.0 - 0.64) / np.sqrt(n)
    assert_allclose(found.mean, [5.0, 1.0], rtol=5.0 / np.sqrt(n))


def test_progress_is_told_to_the_end():
    """The callback ends with all trials done."""
    told = []
    sample(
        one_output(Group.independent("x", u=1.0)),
        trials=TRIALS,
        progress=lambda done, total: told.append((done, total)),
    )
    assert told[-1] == (TRIALS, TRIALS)
    assert [done for done, _ in told] == sorted(done for done, _ in told)
