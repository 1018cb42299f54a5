"""Monte Carlo: the same numbers always, and the intervals of JCGM 101."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from builders import last_digit, paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose, assert_array_equal
from scipy import special

from budget.calibration.problem import calibration_problem
from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.errors import WorkerError
from budget.methods import monte_carlo
from budget.methods.execution import BLOCK, draw, local_executor
from budget.methods.monte_carlo import sample, student_quantile, student_tails
from budget.problem import Group, Output, Problem

TRIALS = 3 * BLOCK + 17


def paper_problem(**more):
    """Return the built-in calibration with further gyro lines."""
    return calibration_problem((paper_gyro(**more), paper_accelerometer()), procedure())


def numbers(drawn):
    """Return every number of a sample, to be compared bit for bit."""
    return np.concatenate(
        [drawn.mean, drawn.covariance.ravel(), drawn.interval.ravel(), [drawn.trials]]
    )


@pytest.mark.parametrize("trials", [TRIALS, None])
def test_same_seed_same_numbers(trials):
    """Two runs with one seed are equal bit for bit; another seed differs, 0 too."""
    first, again, other = (
        numbers(sample(paper_problem(), trials=trials, seed=seed)) for seed in (0, 0, 1)
    )
    assert_array_equal(first, again)
    assert (first != other).any()


@pytest.fixture(scope="module")
def processes():
    """Return three processes of this machine."""
    with local_executor(3) as executor:
        yield executor


@pytest.mark.parametrize("trials", [7 * BLOCK + 17, None])
def test_workers_change_no_number(trials, processes):
    """1, 2 and 3 processes give the same numbers bit for bit, adaptive runs too."""
    alone = numbers(sample(paper_problem(), trials=trials, seed=4))
    for workers in (2, 3):
        shared = sample(
            paper_problem(), trials=trials, seed=4, workers=workers, executor=processes
        )
        assert_array_equal(alone, numbers(shared))


def test_trials_are_the_first_of_the_stream():
    """The mean of 1000 trials is that of the first 1000 draws of block 0."""
    problem = paper_problem().pooled
    x = draw(problem, 0, 0, np.empty((problem.n_inputs, BLOCK)))
    expected = problem.evaluate(x)[:, :1000].mean(axis=1)
    assert_array_equal(sample(problem, trials=1000).mean, expected)


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
    z = shape.quantile(np.random.default_rng(8).uniform(2.0**-54, 1.0, n))
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
        interval=kind,
        seed=2,
    )
    low, high = drawn.interval[0]
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


def test_a_model_that_cannot_be_sent_is_an_error_for_people():
    """A lambda as the model, with two workers, raises WorkerError that says so."""
    problem = one_output(Group.independent("x", u=1.0))
    with pytest.raises(WorkerError, match="top of a module"):
        sample(problem, trials=5 * BLOCK, workers=2)


def die(x):
    """End the process that evaluates this, unless it is the test's own."""
    if os.getpid() != int(os.environ["BUDGET_TEST_PID"]):
        os._exit(1)
    return x.sum(axis=0, keepdims=True)


@pytest.mark.slow
def test_a_killed_worker_is_an_error_for_people(monkeypatch):
    """Workers that die in the middle raise WorkerError, never a wrong answer."""
    monkeypatch.setenv("BUDGET_TEST_PID", str(os.getpid()))
    problem = Problem(
        groups=(Group.independent("x", u=1.0),),
        outputs=(Output(name="Y"),),
        function=die,
    )
    with pytest.raises(WorkerError, match="died"):
        sample(problem, trials=5 * BLOCK, workers=2)


@pytest.mark.parametrize("digits", [1, 2])
def test_adaptive_trials_settle_to_the_digits_asked_for(digits):
    """Every output reaches its tolerance, and the truth lies within twice of it."""
    u = [1.0, 2.3, 9.4e-9]
    problem = Problem(
        groups=tuple(
            Group.independent(f"X{i}", u=size, distribution=shape)
            for i, (size, shape) in enumerate(
                zip(u, (NORMAL, UNIFORM, TRIANGULAR), strict=True)
            )
        ),
        outputs=tuple(Output(name=name) for name in "abc"),
        function=np.copy,
    )
    found = sample(problem, digits=digits, seed=3)
    expected = 0.5 * np.array([1.0, 1.0, 1e-9]) / 10.0 ** (digits - 1)
    assert_allclose(found.tolerance, expected, rtol=1e-12)
    assert found.is_settled.all()
    assert (np.abs(found.standard_uncertainty - u) < found.tolerance).all()
    ends = np.array([1.959964, 0.95 * np.sqrt(3.0), np.sqrt(6.0) * (1 - np.sqrt(0.05))])
    exact = np.stack([-ends * u, ends * u], axis=1)
    assert (np.abs(found.interval - exact) < 2.0 * found.tolerance[:, None]).all()


def beyond(runs, *, u, part, interval):
    """Return how many adaptive runs of one normal input miss what they `reached`.

    A run misses where estimate, standard uncertainty or an interval end is off by more.
    """
    problem = one_output(Group.independent("x", u=u))
    truth = np.array([0.0, 1.0, -1.9599640, 1.9599640]) * u
    missed = 0
    for seed in range(runs):
        found = sample(problem, seed=seed, part=part, interval=interval)
        assert found.is_settled.all()
        numbers = [found.mean[0], found.standard_uncertainty[0], *found.interval[0]]
        missed += bool((np.abs(numbers - truth) > found.reached[0]).any())
    return missed


def most_beyond(runs):
    """Return what 5 % of so many runs may be, but for one case in 10 000."""
    missed = np.arange(runs + 1.0)
    return int(np.argmax(special.bdtr(missed, runs, 0.05) >= 1.0 - 1e-4))


@pytest.mark.slow
def test_what_adaptive_runs_reached_holds_at_the_stated_rate():
    """In 300 runs all four numbers are within `reached` in 95 % or more.

    At u = 5 and a fifth of the tolerance runs stop after 10 to some 20 macro-blocks.
    """
    assert beyond(300, u=5.0, part=0.2, interval="symmetric") <= most_beyond(300)


def test_the_check_of_what_is_reached_can_fail(monkeypatch):
    """Control: twice the spread of two and more macro-blocks misses too often."""

    def twice(gathering, _kind):
        blocks = gathering._settling  # noqa: SLF001 - the old rule, of the same blocks
        if len(blocks) < 2:
            return np.full(1, np.inf)
        error = np.std(blocks, axis=0, ddof=1) / np.sqrt(len(blocks))
        return 2.0 * error.max(axis=0)

    block = monte_carlo._macro_block  # noqa: SLF001 - made to settle beyond its stage
    monkeypatch.setattr(
        monte_carlo,
        "_macro_block",
        lambda problem, plan, task: block(problem, replace(plan, first_stage=99), task),
    )
    monkeypatch.setattr(monte_carlo, "FIRST_STAGE", 2)
    monkeypatch.setattr(monte_carlo.Gathering, "reached", twice)
    assert beyond(150, u=5.0, part=0.2, interval="symmetric") > most_beyond(150)


@pytest.mark.slow
def test_shortest_intervals_settle_at_their_own_rate():
    """In 150 runs the ends of shortest intervals are within `reached` in 95 %."""
    assert beyond(150, u=9.0, part=1.0, interval="shortest") <= most_beyond(150)


@pytest.mark.slow
def test_shortest_intervals_do_not_settle_as_symmetric_ones(monkeypatch):
    """Control: with the rate h^(-1/2) for their ends too many miss."""
    reached = monte_carlo.Gathering.reached
    monkeypatch.setattr(
        monte_carlo.Gathering, "reached", lambda self, _kind: reached(self, "symmetric")
    )
    assert beyond(150, u=9.0, part=1.0, interval="shortest") > most_beyond(150)


@pytest.mark.parametrize(("digits", "blocks"), [(1, 10), (2, 30)])
def test_no_adaptive_run_stops_within_its_first_stage(digits, blocks):
    """However coarse the tolerance, 10 macro-blocks are made, 30 for two digits."""
    found = sample(one_output(Group.independent("x", u=1.0)), digits=digits)
    assert found.trials == blocks * 3 * BLOCK


def test_few_macro_blocks_count_with_the_quantile_for_them():
    """With room for 3 and 10 macro-blocks a spread counts by t with 2 and 9 degrees."""
    problem = one_output(Group.independent("x", u=5.0))
    few, many = (
        sample(problem, max_trials=blocks * 3 * BLOCK).reached[0] for blocks in (3, 10)
    )
    # The ends lead: 0.024 u for one block each, and t at 0.9875 or so.
    spread = 5.0 * np.sqrt(0.025 * 0.975 / (3 * BLOCK)) / 0.05845
    for found, t, blocks in ((few, 6.205, 3), (many, 2.685, 10)):
        expected = t * spread / np.sqrt(blocks)
        # A spread of n values is off by a factor of 3 in one case of 100 for n = 3.
        assert expected / 4.0 < found < 2.5 * expected


def test_adaptive_trials_stop_at_the_cap_and_say_so():
    """With room for two macro-blocks and two digits, outputs are left unsettled."""
    found = sample(paper_problem(), digits=2, max_trials=30_000)
    assert found.trials == 2 * 3 * BLOCK
    assert not found.is_settled.all()
    assert (found.reached > found.tolerance).any()


def test_a_constant_output_settles_at_once():
    """An output without spread has interval, mean and u exact, and is settled."""
    problem = Problem(
        groups=(Group.independent("x", u=1.0), Group.independent("c", u=0.0, mean=3.0)),
        outputs=(Output(name="y"), Output(name="constant")),
        function=np.copy,
    )
    for trials in (None, 50_000):
        found = sample(problem, trials=trials)
        assert found.is_settled.all()
        assert_array_equal(found.interval[1], [3.0, 3.0])
        assert_array_equal(found.covariance[1], [0.0, 0.0])


@pytest.mark.parametrize("kind", ["symmetric", "shortest"])
@pytest.mark.parametrize("shape", [NORMAL, UNIFORM, TRIANGULAR, ARCSINE])
def test_counted_trials_give_the_quantiles_of_kept_ones(monkeypatch, kind, shape):
    """Beyond the kept trials, ends (shortest: lengths) are within 0.2 % of u."""
    problem = one_output(Group.independent("x", u=3e-8, distribution=shape))
    kept = sample(problem, trials=300_000, interval=kind)
    monkeypatch.setattr("budget.methods.monte_carlo.EXACT_TRIALS", 20_000)
    monkeypatch.setattr("budget.methods.monte_carlo.EXACT_TRIALS", 20_000)
    counted = sample(problem, trials=300_000, interval=kind)
    assert_array_equal(kept.covariance, counted.covariance)
    error = (kept.interval - counted.interval) / 3e-8
    if kind == "shortest":
        error = np.diff(error)
    assert np.abs(error).max() < 2e-3


def test_an_adaptive_run_counts_once_too_many_were_kept(monkeypatch):
    """An adaptive run that outgrows the kept trials stays within 0.2 % of u."""
    problem = one_output(Group.independent("x", u=1.0))
    kept = sample(problem, digits=2, seed=1)
    monkeypatch.setattr("budget.methods.monte_carlo.EXACT_TRIALS", kept.trials // 3)
    counted = sample(problem, digits=2, seed=1)
    assert counted.trials == kept.trials
    assert np.abs(counted.interval - kept.interval).max() < 2e-3


@pytest.mark.slow
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_blocks_use_the_memory_of_those_before():
    """A run after another maps hardly a page anew: it took 350 a block of trials.

    Of three the least: a machine that is short of memory takes pages away.
    """
    code = (
        "from resource import RUSAGE_SELF, getrusage\n"
        "from budget.calibration.problem import calibration_problem\n"
        "from budget.methods.monte_carlo import sample\n"
        "from budget.inputs import load_device, load_procedure\n"
        "device = load_device('zhao-2019')\n"
        "problem = calibration_problem(device.sensors, load_procedure(None))\n"
        "for _ in range(4):\n"
        "    before = getrusage(RUSAGE_SELF).ru_minflt\n"
        "    sample(problem, trials=24 * 4096)\n"
        "    print(getrusage(RUSAGE_SELF).ru_minflt - before)\n"
    )
    # Dask sets how much memory is given back, for all that a test after it starts.
    own = {name: x for name, x in os.environ.items() if not name.startswith("MALLOC_")}
    command = [sys.executable, "-c", code]
    run = subprocess.run(command, capture_output=True, text=True, check=True, env=own)
    assert min(map(int, run.stdout.split()[1:])) < 24 * 50


@pytest.mark.parametrize(
    ("v", "printed"),
    # Tables of Student's t, for 95 %: JCGM 100:2008, Table G.2.
    [
        *((1, "12.71"), (2, "4.30"), (3, "3.18"), (4, "2.78"), (9, "2.26")),
        *((10, "2.23"), (20, "2.09"), (30, "2.04")),
    ],
)
def test_student_quantiles_are_those_of_the_tables(v, printed):
    """The t of 5 % in both tails agrees with the printed one, the tails with scipy."""
    t = np.array([0.0, 0.1, 1.0, 2.0, 10.0, 1e3])

    found = student_quantile(0.05, v)
    assert_allclose(found, float(printed), rtol=0, atol=0.5 * last_digit(printed))
    # To rounding of 1, from which the tails are what is left.
    expected = 2.0 * special.stdtr(v, -t)
    assert_allclose(student_tails(t, v), expected, rtol=0, atol=1e-14)
