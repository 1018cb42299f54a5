"""One judgement: which interval, how sure, the same whatever the command."""

from __future__ import annotations

import pickle
from dataclasses import replace
from math import erf, log, sqrt

import numpy as np
import pytest
from builders import (
    SIZES,
    bounded_bias,
    compared,
    device,
    paper_device,
    procedure,
    requirement,
)
from numpy.testing import assert_allclose, assert_array_equal
from places import put
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.methods.gum import propagate
from budget.methods.intervals import interval_of_values
from budget.methods.largest import (
    Ends,
    ends_in_order,
    ends_of_trials,
    is_same,
    probability_smaller,
)
from budget.methods.largest import sampling_interval as interval_of
from budget.methods.normality import end_accuracy
from budget.names import Name
from budget.problem import Group, Output, Problem
from budget.question import Limited, Question
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.studies.judgement import (
    alike,
    judge,
    judge_with,
    screen,
    together,
)
from budget.studies.sweep import sweep
from budget.studies.what_if import what_if
from jcgm import scaled_student_t

K95 = float(ndtri(0.975))
SEEDS = 300
TRIALS = 4_000


def one_output(*groups, function=lambda x: x.sum(axis=0, keepdims=True)):
    """Return a Problem of one output, the sum of its inputs by default."""
    return Problem(groups=groups, outputs=(Output(name="a.y.x"),), function=function)


def several(n, *, distribution=UNIFORM, u=1.0):
    """Return a Problem of n independent equal outputs, each a parameter of its own."""
    return Problem(
        groups=(Group.independent("a.x", u=[u] * n, distribution=distribution),),
        outputs=tuple(Output(name=f"a.y.{k}") for k in range(n)),
        function=lambda x: x,
    )


def equal_axes(axes):
    """Return outputs that are axes of one parameter."""
    return tuple(Output(name=Name("y", owner="a", axis=axis)) for axis in axes)


def held(problem, limit):
    """Put the same limit on all outputs of a Problem."""
    n = len(problem.outputs)
    return Limited(
        problem=problem,
        rows=np.arange(n),
        limits=np.full(n, limit),
        coverage=np.full(n, 0.95),
        printed=("limit",) * n,
        usual=0.95,
    )


def off(problem, coverage=0.95):
    """Return the law's estimate of what its end can be off by, and its end."""
    law = propagate(problem)
    end = law.interval(coverage)[0, 1]
    return float(end_accuracy(problem, law, coverage)[0]), float(end)


# The accuracy of the law


def end_of_sum(a, s, p):
    """Return the quantile p of a uniform number of half-width a plus a normal one.

    The distribution function is the mean of the normal one over the uniform number.
    """

    def below(y):
        def primitive(x):  # of Phi(x/s)
            return x * ndtr(x / s) + s * np.exp(-0.5 * (x / s) ** 2) / sqrt(2 * np.pi)

        return (primitive(y + a) - primitive(y - a)) / (2.0 * a)

    return brentq(lambda y: below(y) - p, 0.0, 10.0 * (a + s))


@pytest.mark.parametrize("coverage", [0.5, 0.683, 0.9, 0.9173, 0.95, 0.99, 0.9973])
@pytest.mark.parametrize("share", [0.01, 0.1, 0.5, 0.9, 0.999])
def test_the_law_is_off_by_less_than_it_says_with_a_uniform_source(coverage, share):
    """A uniform source of any share of the variance: the closed form's end is near."""
    problem = one_output(
        Group.independent("u", u=sqrt(share), distribution=UNIFORM),
        Group.independent("n", u=sqrt(1.0 - share)),
    )
    bound, end = off(problem, coverage)
    true = end_of_sum(sqrt(3.0 * share), sqrt(1.0 - share), (1.0 + coverage) / 2.0)

    assert abs(end - true) <= bound
    assert bound <= 100.0 * share**2 * end  # and it is no excuse: it falls as it should


@pytest.mark.parametrize("shape", [UNIFORM, TRIANGULAR, ARCSINE])
@pytest.mark.parametrize("coverage", [0.5, 0.683, 0.9173, 0.95, 0.9973])
def test_the_law_is_off_by_less_than_it_says_of_one_shape(shape, coverage):
    """One source alone: its own quantile is the end."""
    bound, end = off(
        one_output(Group.independent("x", u=1.0, distribution=shape)), coverage
    )
    true = float(shape.quantile(np.array([(1.0 + coverage) / 2.0]))[0])

    assert abs(end - true) <= bound


@pytest.mark.parametrize("part", [1e-3, 1e-2, 0.1, 0.3, 1.0, 10.0])
@pytest.mark.parametrize("coverage", [0.683, 0.95, 0.9973])
def test_the_law_is_off_by_less_than_it_says_of_a_square(part, coverage):
    """A parabola x + part x^2 of a normal x: both ends by the roots of the parabola."""
    problem = one_output(
        Group.independent("x", u=1.0), function=lambda x: x + part * x * x
    )
    law = propagate(problem)
    bound = float(end_accuracy(problem, law, coverage)[0])

    def below(y):
        root = sqrt(max(1.0 + 4.0 * part * y, 0.0))
        return ndtr((root - 1.0) / (2 * part)) - ndtr((-root - 1.0) / (2 * part))

    least = -1.0 / (4.0 * part)
    for end, p in zip(
        law.interval(coverage)[0],
        ((1.0 - coverage) / 2.0, (1.0 + coverage) / 2.0),
        strict=True,
    ):
        true = brentq(lambda y, p=p: below(y) - p, least, 50.0 * (1.0 + part))
        assert abs(end - true) <= bound


def test_the_law_is_off_by_less_than_it_says_beyond_the_second_order():
    """exp(x) bends more than its expansion: the probes see it."""
    problem = one_output(Group.independent("x", u=0.2), function=np.exp)
    law = propagate(problem)
    bound = float(end_accuracy(problem, law, 0.95)[0])

    assert_allclose(
        law.interval(0.95)[0], np.exp([-0.2 * K95, 0.2 * K95]), rtol=0, atol=bound
    )


def test_a_linear_normal_law_is_exact():
    """Nothing but rounding is left to doubt, so 0.999999999 of a limit meets."""
    problem = several(3, distribution=NORMAL)
    found = judge(held(problem, K95 / 0.999999999), seed=0)

    assert off(one_output(Group.independent("x", u=1.0)))[0] < 1e-11
    assert found.verdict() == "meets"
    assert_allclose(found.utilisation, 0.999999999, rtol=1e-12)


def test_few_degrees_of_freedom_leave_the_law_unsure():
    """A k of Student's t is a convention, no quantile of the output.

    By more than it is above the normal one: 2.571 - 1.960 of 5, next to none of many.
    """

    def of(v):
        return Group.independent("x", u=1.0, distribution=scaled_student_t(v))

    few, many = (off(one_output(of(v)))[0] for v in (5.0, 1e6))
    assert few > 2.0 * (2.571 - 1.960)
    assert 0.0 < many < 1e-5


# Which interval, and how many trials


def test_a_uniform_output_is_judged_by_trials_and_a_normal_one_by_the_law():
    """Each output has the interval of the surer method, and only one."""
    problem = Problem(
        groups=(
            Group.independent("a.n", u=1.0),
            Group.independent("a.u", u=1.0, distribution=UNIFORM),
        ),
        outputs=(Output(name="a.y.x"), Output(name="a.y.y")),
        function=lambda x: x,
    )
    found = judge(held(problem, 3.0), seed=0)

    assert found.by_trials.tolist() == [False, True]
    assert_allclose(found.interval[0], [-K95, K95], rtol=1e-12)
    # A quantile of the uniform distribution: sqrt(0.025 0.975/n) 2 a.
    error = sqrt(0.025 * 0.975 / found.trials) * 2.0 * sqrt(3.0)
    assert_allclose(
        found.interval[1], [-0.95 * sqrt(3.0), 0.95 * sqrt(3.0)], rtol=0, atol=5 * error
    )
    assert_allclose(found.factor[0], K95, rtol=1e-12)


def test_a_margin_smaller_than_the_laws_error_is_not_decided_by_the_law():
    """A bound of 2 against 2.1: the law says 108 %, what is true is 90.5 %."""
    problem = several(1, u=2.0 / sqrt(3.0))
    fast = screen(held(problem, 2.1), seed=0)
    sure = judge(held(problem, 2.1), seed=0)

    assert fast.utilisation > 1.07
    assert fast.verdict() == "undecided"
    assert sure.verdict() == "meets"
    assert_allclose(sure.utilisation, 0.95 * 2.0 / 2.1, rtol=5e-3)
    low, high = sure.utilisation_interval
    assert low < 0.95 * 2.0 / 2.1 < high


def test_no_trials_are_made_where_they_cannot_be_surer_than_the_law():
    """The law open within 1e-4: the first trials are the last, and it is undecided."""
    problem = one_output(
        Group.independent("a.x", u=1.0), function=lambda x: x + 2e-5 * x * x
    )
    found = judge(held(problem, K95), seed=0)

    assert found.verdict() == "undecided"
    assert found.trials == 100_000
    assert not found.by_trials.any()


# Ties


def drawn(y, limits):
    """Return the ends of trials."""
    return ends_of_trials(y, ends_in_order(y, 0.95), limits, 0.95)


@pytest.mark.parametrize("M", [1, 2, 37, 2_000, 12_345])
@pytest.mark.parametrize("coverage", [0.0001, 0.5, 0.683, 0.95, 0.9999])
def test_trials_are_sorted_as_far_as_their_ends_are_looked_at(M, coverage):
    """Ends and noise of trials with ends in order are those of all in order: bits."""
    rng = np.random.default_rng(M)
    y = np.stack([rng.standard_normal(M), rng.standard_cauchy(M), np.zeros(M)])
    coverages = np.array([coverage, 0.9, coverage])
    found, expected = (
        ends_of_trials(y, ordered, np.ones(3), coverages)
        for ordered in (ends_in_order(y, coverages), np.sort(y, axis=1))
    )

    assert_array_equal(found.value, expected.value)
    assert_array_equal(found.noise, expected.noise)


def covered(n, shared, judge_ends):
    """Return the part of SEEDS in which the interval holds a utilisation of 1."""
    inside = 0
    for seed in range(SEEDS):
        rng = np.random.default_rng([n, seed])
        y = sqrt(1.0 - shared) * rng.standard_normal((n, TRIALS))
        y += sqrt(shared) * rng.standard_normal(TRIALS)
        low, high = judge_ends(y, np.full(n, K95))
        inside += low <= 1.0 <= high
    return inside / SEEDS


def new_rule(y, limits):
    """Return the interval of the largest of true ends."""
    return interval_of(drawn(y, limits))


def old_rule(y, limits):
    """Return the largest of both limits of each output's own interval."""
    ordered = np.sort(y, axis=1)
    reach = K95 * sqrt(TRIALS * 0.025 * 0.975)
    below, above = 0.025 * TRIALS, 0.975 * TRIALS - 1.0
    inner = np.maximum(
        -ordered[:, round(below + reach)], ordered[:, round(above - reach)]
    )
    outer = np.maximum(
        -ordered[:, round(below - reach)], ordered[:, round(above + reach)]
    )
    return (inner / limits).max(), (outer / limits).max()


@pytest.mark.parametrize(("n", "shared"), [(1, 0.0), (3, 0.0), (6, 0.6), (12, 0.0)])
def test_ties_do_not_move_the_interval_of_the_largest(n, shared):
    """Of 300 seeds 95 % hold the truth, to 3 standard errors, whatever the ties."""
    error = sqrt(0.95 * 0.05 / SEEDS)

    assert covered(n, shared, new_rule) >= 0.95 - 3.0 * error


def test_the_largest_of_each_bound_does_not_cover_ties():
    """Control: taking the largest of both bounds covers far less with twelve ties."""
    assert covered(12, 0.0, old_rule) < 0.75


def test_an_interval_is_no_wider_than_ties_ask_for():
    """Outputs far below the largest do not widen it."""
    rng = np.random.default_rng(3)
    y = rng.standard_normal((12, 20_000))
    limits = np.full(12, K95)
    low, high = interval_of(drawn(y[:1], limits[:1]))
    far = interval_of(drawn(y, np.array([K95] + [10.0 * K95] * 11)))

    assert_allclose(far, (low, high), rtol=1e-12)


def test_a_tie_of_twelve_does_not_lose_its_rank():
    """Twelve outputs at 0.900 against one at 0.905: hardly ever is the one first.

    Of 60 seeds at the most 2.5 %, and three standard errors, may say so. A mean of the
    maxima of batches, the control, says so nearly always.
    """
    seeds, trials, batch = 60, 24_000, 2_000
    said = control = 0
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        y = rng.standard_normal((13, trials))
        many, one = np.full(12, K95 / 0.900), np.full(1, K95 / 0.905)
        ahead = probability_smaller(drawn(y[12:], one), drawn(y[:12], many))
        said += ahead > 0.975
        parts = [
            largest(y[12:, k : k + batch], one) - largest(y[:12, k : k + batch], many)
            for k in range(0, trials, batch)
        ]
        control += np.mean(parts) / np.std(parts) * sqrt(len(parts)) < -2.2
    assert said / seeds <= 0.025 + 3.0 * sqrt(0.025 * 0.975 / seeds)
    assert control / seeds > 0.5


def largest(y, limits):
    """Return the largest utilisation of trials."""
    ends = interval_of_values(np.sort(y, axis=1), 0.95, "symmetric")
    return (np.abs(ends).max(axis=1) / limits).max()


@pytest.mark.parametrize("seed", range(8))
def test_equal_axes_have_one_interval_by_trials(seed):
    """Three equal uniform axes: one k and one utilisation, and the first is the worst.

    Control: outputs that are parameters of their own are told apart by their trials.
    """
    axes = replace(several(3), outputs=equal_axes("xyz"))
    found, apart = (
        judge_with(held(problem, 2.0 * sqrt(3.0)), seed=seed, trials=TRIALS)
        for problem in (axes, several(3))
    )

    assert found.by_trials.all()
    assert len({*found.used.tolist()}) == len({*found.factor.tolist()}) == 1
    assert len({*found.within.tolist()}) == 1
    assert (found.worst, found.all_worst) == (0, (0, 1, 2))
    assert_array_equal(found.interval[2], apart.interval[0])
    assert len({*apart.used.tolist()}) == 3


def test_equal_axes_share_an_interval_where_their_limits_differ():
    """One interval over each limit; what differs in size is drawn for itself."""
    problem = replace(
        several(4),
        groups=(
            Group.independent("a.x", u=[1.0, 1.0, 1.01, 1.0], distribution=UNIFORM),
        ),
        outputs=equal_axes("wxyz"),
    )
    limited = replace(
        held(problem, 2.0),
        rows=np.array([1, 2, 3]),
        limits=np.array([2.0, 2.0, 4.0]),
        coverage=np.array([0.95, 0.95, 0.95]),
    )
    law = propagate(problem)
    found = judge_with(limited, seed=0, trials=TRIALS)

    assert alike(problem, law).tolist() == [0, 0, 2, 0]
    assert_array_equal(found.interval[0], found.interval[2])
    assert_allclose(found.used[0], 2.0 * found.used[2], rtol=1e-12)
    assert found.used[1] != found.used[0]
    # It is that of the first of the Problem, whatever has a limit.
    all_of_them = judge_with(held(problem, 2.0), seed=0, trials=TRIALS)
    assert_array_equal(found.interval[0], all_of_them.interval[0])


def test_an_interval_of_each_coverage_is_of_its_own():
    """Equal axes with limits at 50 % and 95 % have intervals of 50 % and 95 %."""
    axes = replace(several(2), outputs=equal_axes("xy"))
    limited = replace(held(axes, 4.0), coverage=np.array([0.5, 0.95]))
    found = judge_with(limited, seed=0, trials=100_000)

    for interval, coverage in zip(found.interval, (0.5, 0.95), strict=True):
        p = (1.0 + coverage) / 2.0
        error = sqrt(p * (1.0 - p) / 100_000) * 2.0 * sqrt(3.0)
        assert_allclose(interval[1], coverage * sqrt(3.0), rtol=0, atol=4.0 * error)


def test_what_the_law_can_be_off_by_is_in_the_rank():
    """Two laws at 0.90 and 0.91: told apart where their errors are small, else not."""
    for bound, expected in ((0.001, 1.0), (0.02, 0.5)):
        a, b = (
            Ends(value=np.array([x]), noise=np.zeros((1, 1)), bound=np.array([bound]))
            for x in (0.90, 0.91)
        )
        assert probability_smaller(a, b) == expected


def test_ends_that_only_differ_far_below_are_one():
    """Trials that move the largest ends alike leave one half; one that differs, not."""
    rng = np.random.default_rng(0)
    noise = 1e-3 * rng.standard_normal((40, 3))
    a = Ends(value=np.array([0.9, 0.9, 0.2]), noise=noise, bound=np.zeros(3))
    far, near, moved = (
        Ends(value=np.array(value), noise=noise * factors, bound=np.zeros(3))
        for value, factors in (
            ([0.9, 0.9, 0.3], [1.0, 1.0, 2.0]),
            ([0.9, 0.8999, 0.2], [1.0, 1.0, 1.0]),
            ([0.9, 0.9, 0.2], [1.0, 2.0, 1.0]),
        )
    )

    assert is_same(a, far)
    assert probability_smaller(a, far) == probability_smaller(far, a) == 0.5
    assert not is_same(a, near)
    assert not is_same(a, moved)


# Together


def test_joint_conformity_is_counted_in_the_same_trials():
    """Two problems of one source are within together, not with the product."""
    problem = several(1, distribution=NORMAL)
    one = held(problem, 1.0)
    found = [judge(one, seed=0) for _ in range(2)]
    p = erf(1.0 / sqrt(2.0))

    both = together(found)
    error = sqrt(p * (1.0 - p) / 100_000)
    assert_allclose(both.value, p, rtol=0, atol=4.0 * error)
    assert both.value > p**2 + 4.0 * error  # control: the product
    assert both.low < both.value < both.high


def test_sensors_of_their_own_sources_are_independent():
    """Gyro and accelerometer: together within four standard errors of the product."""
    wanted = requirement(sensors=("gyro", "accelerometer"), times=1.0)
    lines = {
        kind: {"bias_repeatability": 0.6 * SIZES[kind]["bias"]}
        for kind in ("gyro", "accelerometer")
    }
    found = compared([device("x", **lines)], wanted, pairs=True, trials=20_000)
    product = np.prod([row.conformance.value for row in found.devices])
    (pair,) = found.pairs

    error = sqrt(product * (1.0 - product) / 20_000)
    assert 0.5 < product < 0.9
    assert_allclose(pair.conformance.value, product, rtol=0, atol=4.0 * error)


# The same whatever the command


@pytest.mark.parametrize(
    "made",
    [
        bounded_bias("bound", 0.905),
        bounded_bias("close", 0.995),
        paper_device("paper", times=0.5),
    ],
    ids=lambda made: made.name,
)
def test_compare_and_analyze_say_the_same(made):
    """Verdict, largest errors, utilisation, its interval and conformity are equal."""
    wanted = requirement()
    (row,) = compared([made], wanted, trials=100_000, max_trials=1_600_000).devices
    budget = analyze(
        made,
        procedure=procedure(),
        requirement=wanted,
        coverage=wanted.coverage,
        reference=wanted.reference,
        validate=False,
    )
    (sensor,) = budget.assessment.sensors

    assert sensor.verdict == row.verdict
    assert sensor.utilisation == row.utilisation
    assert sensor.utilisation_interval == row.utilisation_interval
    assert sensor.conformance == row.conformance == budget.assessment.conformance
    assert sensor.worst_output == row.worst_output
    assert budget.assessment.outputs == row.outputs
    assert [one.interval for one in budget.outputs] == [o.interval for o in row.outputs]


@pytest.fixture
def hard_bound(tmp_path):
    """Return the file of a gyro of which nothing but a bound of its bias is known."""
    return put(
        tmp_path / "bound.yaml",
        "name: bound\ngyro:\n  errors:\n"
        "    bias_repeatability: {value: 1.75 deg/h, meaning: max}\n",
    )


def test_a_hard_bound_has_one_interval_whoever_asks(hard_bound, tmp_path):
    """+-1.75 deg/h: 95 % lie within 1.6625, with a limit or without, digit for digit.

    The law says 1.98, which is beyond the bound itself.
    """
    file = put(
        tmp_path / "r.yaml",
        "name: r\ncoverage: 95 %\nreference: nominal\n"
        "limits: {gyro: {bias: 2.4 deg/h}}\n",
    )
    budgets = [
        analyze(hard_bound),
        analyze(hard_bound, validate=False),
        analyze(hard_bound, validate=False, interval="shortest"),
        analyze(hard_bound, validate=False, only=["gyro.bias_repeatability"]),
        analyze(hard_bound, requirement=file, validate=False),
    ]
    shown = [
        row["interval"]
        for budget in budgets
        for row in budget.to_dict()["outputs"]
        if row["parameter"] == "bias" and row["interval_by"] == "monte-carlo"
    ]
    (device_row,) = compare(hard_bound, file).devices
    shown += [
        [end / row.output.si_per_unit for end in row.interval]
        for row in device_row.outputs
    ]
    table = sweep(
        hard_bound, "gyro.bias_repeatability", ["{value: 1.75 deg/h, meaning: max}"]
    )
    table = table[table.parameter == "bias"]
    shown += table[["interval_low", "interval_high"]].to_numpy().tolist()

    assert len(shown) == 3 * (len(budgets) + 2)
    assert_allclose(shown, np.tile(shown[0], (len(shown), 1)), rtol=1e-12)
    error = sqrt(0.025 * 0.975 / 100_000) * 2.0 * 1.75
    assert_allclose(shown[0], [-1.6625, 1.6625], rtol=0, atol=4.0 * error)
    law = (
        budgets[0].question.law.interval(0.95)[-1, 1]
        / budgets[0].outputs[-1].output.si_per_unit
    )
    assert_allclose(law, 1.96 * 1.75 / sqrt(3.0), rtol=1e-4)  # control
    page = what_if(budgets[0].question, budget=budgets[0]).evaluate({})
    row = budgets[0].outputs[-1]
    assert_allclose(page.interval[-1], row.interval, rtol=1e-12)


def test_the_law_is_not_checked_where_trials_give_the_interval(hard_bound):
    """No validation, no warning that sends to Monte Carlo, and k of neither method."""
    budget = analyze(hard_bound)
    by_trials = [row for row in budget.outputs if row.by_trials]

    assert {row.parameter for row in by_trials} == {"bias"}
    assert {row.validation for row in by_trials} == {None}
    assert {row.coverage_factor for row in by_trials} == {None}
    others = [row for row in budget.outputs if not row.by_trials]
    assert all(row.validation.holds for row in others)
    assert not [text for text in budget.warnings if "not confirmed" in text]


def test_no_trial_is_drawn_where_the_law_is_sure(monkeypatch):
    """Normal sources: the intervals are the law's, and nothing is drawn for them."""

    def refuse(*_args, **_options):
        raise AssertionError

    monkeypatch.setattr("budget.studies.judgement.first_trials", refuse)
    asked = {"procedure": procedure(), "validate": False}
    budget = analyze(paper_device(), **asked)
    assert not any(row.by_trials for row in budget.outputs)
    with pytest.raises(AssertionError):  # control
        analyze(bounded_bias("bound", 0.5), **asked)


@pytest.mark.parametrize(("used", "verdict"), [(0.905, "meets"), (1.05, "fails")])
def test_what_if_starts_from_the_interval_that_was_judged(used, verdict):
    """With nothing changed intervals and verdict are the budget's, not the law's."""
    made, wanted = bounded_bias("bound", used), requirement()
    asked = {"procedure": procedure(), "requirement": wanted}
    basis = {"coverage": wanted.coverage, "reference": wanted.reference}
    budget = analyze(made, **asked, **basis, validate=False)
    question = Question.of(made, **asked)
    now = what_if(question, budget=budget).evaluate({})
    law = what_if(question).evaluate({})
    judged = np.array([row.interval for row in budget.outputs])
    resolution = max(row.output.resolution for row in budget.outputs)

    assert {row.interval_by for row in budget.outputs} == {"law", "monte-carlo"}
    assert_allclose(now.interval, judged, rtol=1e-12, atol=resolution)
    (ours,), (theirs,) = now.sensors, budget.assessment.sensors
    assert ours.verdict == theirs.verdict == verdict
    assert_allclose(ours.utilisation, theirs.utilisation, rtol=1e-12)
    assert law.sensors[0].utilisation > 1.15 * used  # control


def test_by_gum_the_verdict_is_that_of_trials():
    """Trials decide what the law is not sure of; it stays open only near the limit."""
    for used in (0.3, 0.8, 0.95, 1.02, 1.3, 3.0):
        made = bounded_bias("x", used)
        fast = compared([made], method="gum").devices[0]
        sure = compared([made], trials=100_000, max_trials=400_000).devices[0]

        assert fast.verdict in {sure.verdict, "undecided"}
        low, high = fast.utilisation_interval
        assert low <= used <= high
        if fast.verdict == "undecided":
            assert "monte-carlo" in fast.advice


def test_a_limit_on_nothing_leaves_nothing_to_judge():
    """A Problem without required outputs has no limits."""
    problem = several(2)

    assert Limited.of(problem, requirement()) is None


def test_multipliers_do_not_depend_on_the_number_of_draws():
    """The same trials give the same interval every time: no state is kept."""
    y = np.random.default_rng(1).standard_normal((6, 10_000))
    limits = np.full(6, K95)

    assert new_rule(y, limits) == new_rule(y, limits)
    assert log(new_rule(y, limits)[1]) > log(new_rule(y, limits)[0])


def test_what_is_kept_of_a_judgement_is_a_bit_a_trial():
    """A comparison keeps that of thousands of devices; a byte a trial is too much."""
    problem = several(3)
    trials = 200_000
    found = judge_with(
        held(problem, 1.6),
        seed=0,
        trials=trials,
    )
    assert len(pickle.dumps(found)) < trials / 8 + found.ends.noise.nbytes + 5_000
    marks = found.inside.first(trials)
    assert_allclose(marks.mean(), found.conformance.value, rtol=1e-12)
    assert 0.0 < found.conformance.value < 1.0
