"""Factors on sources: closed forms, published numbers, random allocations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.methods.allocation import (
    MOST_SPARED,
    Task,
    equal,
    grow,
    headroom,
    proportional,
    sparing,
)
from budget.methods.gum import propagate
from budget.methods.least_cost import Prices, judge, least_cost
from budget.methods.scaling import scaled_law
from budget.methods.trials import coverage_of
from budget.problem import Group, Output, Problem


def linear(C, u):
    """Return the Problem y = C x with one source for each input."""
    C = np.asarray(C, dtype=float)

    def function(x):
        return np.stack(
            [sum(c * row for c, row in zip(cs, x, strict=True)) for cs in C]
        )

    return Problem(
        groups=tuple(Group.independent(f"x{i}", u=size) for i, size in enumerate(u)),
        outputs=tuple(Output(name=f"y{k}") for k in range(len(C))),
        function=function,
    )


def task_of(problem, limit, *, k=1.0, free=None, low=0.0, high=1e9):
    """Return the task of all outputs of a Problem."""
    n = len(problem.groups)
    return Task(
        law=scaled_law(problem),
        limit=np.asarray(limit, dtype=float),
        coverage_factor=np.full(len(problem.outputs), k),
        free=np.ones(n, dtype=bool) if free is None else np.asarray(free),
        low=np.full(n, low),
        high=np.full(n, high),
    )


C = np.array([[1.0, 2.0, 0.5, 0.0], [0.0, 1.0, 3.0, 0.0], [0.2, 0.0, 1.0, 4.0]])
U = np.array([0.1, 0.2, 0.3, 0.4])


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_one_output_costs_least_at_the_closed_form(power):
    """With one limit, s^(p+2) of each source goes as a / (c u)^2.

    From the condition of Lagrange, - a p s^-(p+1) + 2 m c^2 u^2 s = 0.
    """
    a = np.array([1.0, 3.0, 0.5, 2.0])
    c = np.array([1.0, 2.0, 0.5, 1.5])
    task = task_of(linear([c], U), [0.05])

    found = least_cost(task, Prices(c=a, p=np.full(4, power)))

    s = (a / (c * U) ** 2) ** (1.0 / (power + 2.0))
    s *= 0.05 / np.sqrt(((c * U * s) ** 2).sum())
    assert_allclose(found.s, s, rtol=1e-6)
    assert found.is_optimal
    # d cost / d log(limit) = -p cost, as every s is proportional to the limit.
    assert_allclose(found.multiplier, [power * found.cost], rtol=1e-5)


def test_the_least_cost_beats_random_allocations():
    """None of 10 000 random allocations at a limit is cheaper, and some come near."""
    task = task_of(linear(C, U), [0.2, 0.3, 0.5])
    prices = Prices(c=np.array([1.0, 4.0, 0.3, 2.0]), p=np.array([1.0, 2.0, 0.5, 3.0]))
    best = least_cost(task, prices)

    rng = np.random.default_rng(7)
    costs = np.empty(10_000)
    for i in range(costs.size):
        s = best.s * np.exp(rng.normal(scale=rng.choice([0.05, 1.0]), size=4))
        s = s / task.utilisation(s).max()
        costs[i] = prices.each(s).sum()

    assert costs.min() >= best.cost * (1.0 - 1e-8)
    assert costs.min() < best.cost * 1.05


def test_the_unit_of_cost_changes_nothing():
    """Costs a thousand million times larger give the same factors, to 1e-6."""
    task = task_of(linear(C, U), [0.2, 0.3, 0.5])
    c, p = np.array([1.0, 4.0, 0.3, 2.0]), np.array([1.0, 2.0, 0.5, 3.0])

    small = least_cost(task, Prices(c=c, p=p))
    large = least_cost(task, Prices(c=1e9 * c, p=p))

    assert_allclose(large.s, small.s, rtol=1e-6)
    assert_allclose(large.cost, 1e9 * small.cost, rtol=1e-9)
    assert_allclose(large.multiplier, 1e9 * small.multiplier, rtol=1e-4, atol=1e-3)


def test_a_multiplier_is_what_a_wider_limit_saves():
    """Solving again with one limit 0.1 % wider saves what its multiplier says."""
    task = task_of(linear(C, U), [0.2, 0.3, 0.5])
    prices = Prices(c=np.array([1.0, 4.0, 0.3, 2.0]), p=np.array([1.0, 2.0, 0.5, 3.0]))
    found = least_cost(task, prices)
    k = int(np.argmax(found.multiplier))
    limit = task.limit.copy()
    limit[k] *= 1.001

    again = least_cost(replace(task, limit=limit), prices)

    saved = (found.cost - again.cost) / np.log(1.001)
    assert_allclose(saved, found.multiplier[k], rtol=5e-3)  # second order of 0.1 %


def test_a_wrong_point_is_not_taken_for_the_optimum():
    """Control: residual and gap of the proportional point are far from zero."""
    task = task_of(linear(C, U), [0.2, 0.3, 0.5])
    prices = Prices(c=np.array([1.0, 4.0, 0.3, 2.0]), p=np.array([1.0, 2.0, 0.5, 3.0]))
    best = least_cost(task, prices)
    judged = judge(task, prices, proportional(task))

    assert not judged.is_optimal
    assert judged.gap >= 1.0 - best.cost / judged.cost  # a bound, so never too small


def test_the_published_inverse_case_returns_its_target():
    """u(rho) = 0.03 of rho = w/(k d^2 h) comes back from the u(w) that is found."""
    k, h, d, rho = 12.870369, 0.5, 0.25, 2.0

    def problem(u_w):
        return Problem(
            groups=(
                Group.independent("w", mean=rho * k * d**2 * h, u=u_w),
                Group.independent("d", mean=d, u=0.0005),
                Group.independent("h", mean=h, u=0.0005),
            ),
            outputs=(Output(name="rho"),),
            function=lambda x: (x[0] / (k * x[1] ** 2 * x[2]))[None],
        )

    task = task_of(problem(0.01), [0.03], free=[True, False, False])
    task = replace(task, law=task.law.centred())  # what is asked is u, not an interval

    u_w = 0.01 * proportional(task)[0]

    assert_allclose(propagate(problem(u_w)).standard_uncertainty, [0.03], rtol=1e-8)
    relative = np.sqrt((0.03 / rho) ** 2 - (2 * 0.0005 / d) ** 2 - (0.0005 / h) ** 2)
    # First order alone; the second-order terms are some 1e-5 of it.
    assert_allclose(u_w, relative * rho * k * d**2 * h, rtol=1e-4)


def test_proportional_is_one_factor():
    """All factors are equal, and the tightest output is at its limit."""
    task = task_of(linear(C, U), [0.2, 0.3, 0.5], k=1.96)
    s = proportional(task)

    assert_allclose(s, s[0], rtol=1e-15)
    assert_allclose(task.utilisation(s).max(), 1.0, rtol=2e-9)


def test_a_source_of_half_a_percent_is_spared_and_one_of_two_is_not():
    """Of 100, 2 and 0.5 the last stays 1: s = sqrt((limit^2 - 0.5)/102) of the others.

    Up and down: from 102.5 to limits of 400 and 25.
    """
    for limit in (20.0, 5.0):
        found = sparing(
            task_of(linear([[10.0, 2**0.5, 0.5**0.5]], np.ones(3)), [limit])
        )
        s = np.sqrt((limit**2 - 0.5) / 102.0)
        assert found.spared.tolist() == [False, False, True]
        assert_allclose(found.s, [s, s, 1.0], rtol=1e-8)


def test_what_leaves_too_little_is_taken_in_from_the_largest_on():
    """Of 1e6, 900, 60 and 20 against 90 the second is taken in, the others are not.

    900 alone is above nine tenths of 90, 60 + 20 is just below: 10 are left.
    """
    u = np.sqrt([1e6, 900.0, 60.0, 20.0])
    found = sparing(task_of(linear([np.ones(4)], u), [90.0**0.5]))

    assert MOST_SPARED * 90.0 > 80.0
    s = np.sqrt(10.0 / (1e6 + 900.0))
    assert found.spared.tolist() == [False, False, True, True]
    # What is left, 10 of 90, has the limit's rounding nine times.
    assert_allclose(found.s, [s, s, 1.0, 1.0], rtol=1e-7)
    # A control: against 85 that leaves less than a tenth, and 60 is taken in too.
    tighter = sparing(task_of(linear([np.ones(4)], u), [85.0**0.5]))
    assert tighter.spared.tolist() == [False, False, False, True]


def test_a_limit_that_is_passed_elsewhere_has_the_same_factor():
    """y0 must shrink to 1/10, y1, of another source, to 1/2: both have 1/10."""
    task = task_of(linear([[10.0, 0.0, 0.0], [0.0, 2.0, 0.01]], np.ones(3)), [1.0, 1.0])
    found = sparing(task)

    assert found.spared.tolist() == [False, False, True]
    assert_allclose(found.s, [0.1, 0.1, 1.0], rtol=1e-8)


def test_a_source_at_another_output_grows_only_where_that_is_reached():
    """y0 is reached first, y1 has another source and room: that stays as it is."""
    task = task_of(linear([[1.0, 0.0], [0.0, 1.0]], np.ones(2)), [2.0, 50.0])
    found = sparing(task)

    assert found.spared.tolist() == [False, True]
    assert_allclose(found.s, [2.0, 1.0], rtol=1e-8)


def test_sparing_never_passes_a_limit():
    """Of random laws, limits, held sources and ceilings, whenever they can be met."""
    rng = np.random.default_rng(5)
    spared = met = 0
    for _ in range(200):
        C = rng.lognormal(0.0, 2.0, (3, 6)) * rng.integers(0, 2, (3, 6))
        limit = rng.lognormal(0.0, 2.0, 3)
        task = task_of(linear(C, np.ones(6)), limit, free=rng.random(6) < 0.8)
        task = replace(task, high=rng.lognormal(2.0, 2.0, 6))
        if not task.is_feasible:
            continue
        found = sparing(task)
        met += 1
        spared += int(found.spared.sum())
        assert task.utilisation(found.s).max() <= 1.0
        assert_allclose(found.s[~task.free], 1.0, rtol=1e-15)
        at = np.minimum(1.0, task.high)[found.spared]
        assert_allclose(found.s[found.spared], at, rtol=1e-15)
    assert met > 50
    assert spared > met


def test_where_no_limit_is_reached_none_is_spared():
    """All end at their ceilings, as by one factor on all."""
    found = sparing(task_of(linear([[1.0, 0.001]], np.ones(2)), [1e6], high=7.0))

    assert_allclose(found.s, 7.0, rtol=1e-15)
    assert not found.spared.any()


def test_equal_parts_fill_one_limit():
    """Four sources of one output take a quarter of its squared limit each."""
    task = task_of(linear([[1.0, 2.0, 3.0, 4.0]], U), [0.05])

    assert_allclose(task.part(equal(task))[0], 0.25, rtol=1e-8)


def test_equal_lets_sources_grow_that_no_bound_output_feels():
    """Of two outputs without a common source each ends at its own limit."""
    task = task_of(linear([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [1.0, 1.0, 1.0]), [1, 50])
    s = equal(task)

    assert_allclose(task.utilisation(s), 1.0, rtol=3e-9)
    assert_allclose(s, [np.sqrt(0.5), np.sqrt(0.5), 50.0], rtol=1e-8)


def test_equal_takes_back_what_products_added():
    """Where growing sources multiply into a bound output, no limit is passed."""
    problem = Problem(
        groups=tuple(Group.independent(name, u=1.0) for name in "abc"),
        outputs=(Output(name="one"), Output(name="two")),
        function=lambda x: np.stack([x[0] + 0.01 * x[0] * x[1], x[1] + x[2]]),
    )
    task = task_of(problem, [1.0, 30.0])
    s = equal(task)

    assert task.utilisation(s).max() <= 1.0
    assert_allclose(task.utilisation(s).max(), 1.0, rtol=2e-3)


def test_held_sources_stay():
    """A held source keeps factor 1, and the others share what it leaves."""
    task = task_of(linear([[1.0, 1.0]], [3.0, 3.0]), [5.0], free=[False, True])
    s = proportional(task)

    assert_allclose(s, [1.0, 4.0 / 3.0], rtol=1e-8)


def test_ceilings_stop_a_source_and_not_the_others():
    """A source at its ceiling stays there while the common factor goes on."""
    task = task_of(linear([[1.0, 1.0]], [3.0, 3.0]), [5.0])
    task = replace(task, high=np.array([1.0, 10.0]))

    assert_allclose(proportional(task), [1.0, 4.0 / 3.0], rtol=1e-8)
    assert_allclose(equal(task), [1.0, 4.0 / 3.0], rtol=1e-8)


def test_no_limit_in_reach_ends_at_the_ceilings():
    """Where no output is reached, every source ends at its ceiling."""
    task = task_of(linear([[1.0, 1.0]], [3.0, 3.0]), [1e6], high=7.0)

    for strategy in (proportional, equal):
        assert_allclose(strategy(task), 7.0, rtol=1e-15)


def test_the_floor_decides_what_is_feasible():
    """A held source of 5 makes a limit of 4.9 impossible and one of 5.1 possible."""
    for limit, feasible in ((4.9, False), (5.1, True)):
        task = task_of(linear([[1.0, 1.0]], [5.0, 1.0]), [limit], free=[False, True])
        assert task.is_feasible is feasible


def test_headroom_is_the_closed_form():
    """Source i alone may have sqrt(limit^2 - the others' variance) over its own."""
    task = task_of(linear([[3.0, 4.0]], [1.0, 1.0]), [10.0])
    rooms = headroom(task, task.now)

    wanted = [np.sqrt(100.0 - 16.0) / 3.0, np.sqrt(100.0 - 9.0) / 4.0]
    assert_allclose([room.factor for room in rooms], wanted, rtol=1e-8)
    assert [room.stopped_by for room in rooms] == [(0,), (0,)]


def test_a_failing_output_leaves_no_headroom_to_what_it_feels():
    """Sources of an output that fails without them have none; others keep theirs."""
    task = task_of(linear([[3.0, 4.0, 0.0], [0, 0, 1.0]], [1.0, 1.0, 1.0]), [1.0, 6.0])
    rooms = headroom(task, task.now)

    assert [room.factor for room in rooms[:2]] == [0.0, 0.0]
    assert_allclose(rooms[2].factor, 6.0, rtol=1e-8)
    assert rooms[2].stopped_by == (1,)


def test_growing_some_sources_leaves_the_others():
    """Only the sources that take part move."""
    task = task_of(linear([[1.0, 1.0]], [3.0, 4.0]), [10.0])
    s = grow(task, task.now, np.array([True, False]))

    assert s[1] == 1.0
    assert_allclose(9.0 * s[0] ** 2 + 16.0, 100.0, rtol=1e-8)


def test_trials_fall_within_the_interval_as_often_as_it_says():
    """A normal output lies within 1.96 u in 95 % of the trials, within 1 u in 68 %."""
    problem = linear([[1.0, 2.0]], [1.0, 1.0])
    u = np.sqrt(5.0)
    for k, wanted in ((1.959964, 0.95), (1.0, 0.682689)):
        found = coverage_of(
            problem, np.array([[-k * u, k * u]]), coverage=0.95, trials=100_000, seed=3
        )
        bound = 4.0 * np.sqrt(wanted * (1.0 - wanted) / found.trials)
        assert abs(found.inside[0] - wanted) < bound


def test_trials_have_an_interval_of_the_coverage_of_each_output():
    """Two equal outputs, one asked for 68 %: a standard uncertainty to either side."""
    found = coverage_of(
        linear([[1.0], [1.0]], [1.0]),
        np.zeros((2, 2)),
        coverage=np.array([0.95, 0.682689]),
        trials=100_000,
        seed=3,
    )
    # Standard error of a quantile: sqrt(p (1 - p)/M)/f, 0.0084 and 0.0048 u.
    assert_allclose(found.interval, [[-1.96, 1.96], [-1.0, 1.0]], rtol=0, atol=0.035)


def test_the_least_cost_with_sources_at_ceilings_is_known_to_be_one():
    """A source that no limit feels ends at its ceiling, and the optimum is seen."""
    task = task_of(linear(C[:2], U), [0.2, 0.3], high=5.0)  # x3 reaches neither
    found = least_cost(task, Prices(c=np.ones(4), p=np.ones(4)))

    assert found.is_optimal
    assert_allclose(found.s[3], 5.0, rtol=1e-6)
    assert_allclose(task.utilisation(found.s).max(), 1.0, rtol=2e-9)
