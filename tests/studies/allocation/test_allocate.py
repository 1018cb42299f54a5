"""From requirement to lines and back: references, bounds, longer tests, Monte Carlo."""

from __future__ import annotations

from dataclasses import replace
from unittest.mock import patch

import builders
import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.distributions import UNIFORM
from budget.errors import CallError
from budget.inputs import load_device, load_procedure, load_requirement
from budget.inputs.files import open_file
from budget.inputs.records import Cost, Costs, Device, Limit, Requirement
from budget.methods.gum import propagate
from budget.missing import fill
from budget.names import Name
from budget.resources import shipped
from budget.studies.allocation import allocate as module
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import STRATEGIES, Bounds
from budget.studies.allocation.longer_tests import find_longer_tests
from budget.studies.allocation.market import (
    best_offered,
    load_catalogue,
    match_catalogue,
)
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.studies.conformity import assess
from budget.units import ARCSEC, DEG_PER_HOUR, PPM

AXES = ("x", "y", "z")


@pytest.fixture(autouse=True)
def nothing_longer(monkeypatch):
    """Look for no longer test, which takes ten times what an allocation takes."""
    monkeypatch.setattr(module, "find_longer_tests", lambda _: ())


@pytest.fixture
def longer(monkeypatch):
    """Look for longer tests, in a test that asks for them."""
    monkeypatch.setattr(module, "find_longer_tests", find_longer_tests)


def device(*sensors):
    """Return a device of ready triads."""
    by_kind = {sensor.kind: sensor for sensor in sensors}
    return Device(
        name="test device",
        gyro=by_kind.get("gyro"),
        accelerometer=by_kind.get("accelerometer"),
        figures=(),
        assumptions=(),
        origin=builders.NOWHERE,
    )


def requirement(limits, *, reference="next_turn_on", coverage=0.95):
    """Return a requirement from `{parameter: limit for all axes}` [SI]."""
    return Requirement(
        name="test requirement",
        coverage=coverage,
        reference=reference,
        limits=tuple(
            Limit(
                output=Name(quantity, owner=owner, axis=axis),
                limit=limit,
                printed=f"{limit}",
            )
            for group, limit in limits.items()
            for owner, quantity in [group.split(".")]
            for axis in (
                ("xy", "xz", "yx", "yz", "zx", "zy") if "angle" in group else AXES
            )
        ),
        caps=(),
        assumptions=(),
        origin=builders.NOWHERE,
    )


ZHAO = load_device("zhao-2019")
NAVIGATION = load_requirement("navigation-grade")


def allot(*devices, wanted=NAVIGATION, **options):
    """Allocate without catalogue and Monte Carlo unless asked for."""
    options = {"catalogue": (), "validate": False, **options}
    return allocate(*devices or (ZHAO,), requirement=wanted, **options)


def allowed(allocation, source):
    """Return what a source may have [SI]."""
    (row,) = (row for row in allocation.sources if row.source == source)
    return row.allowed


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_ends_at_a_limit_of_each_sensor(strategy):
    """No limit is passed, and one of each sensor is reached within 0.2 %."""
    allocation = allot(strategy=strategy)

    for sensor in ("gyro", "accelerometer"):
        used = [row.allowed for row in allocation.outputs if row.sensor == sensor]
        assert 1.0 - 2e-3 < max(used) <= 1.0


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_the_allocated_device_meets_what_it_was_made_for(strategy):
    """Analysed as a device, it returns the limits at the binding outputs, to 1e-5.

    And what the allocation says of them to 1e-9; a limit counts as reached from 1e-6.
    """
    allocation = allot(strategy=strategy)
    made = device(*allocation.sensors)
    budget = analyze(
        made,
        requirement=NAVIGATION,
        validate=False,
        coverage=NAVIGATION.coverage,
        reference=NAVIGATION.reference,
    )
    found = {
        row.output.name: row for row in assess(budget, NAVIGATION, (made,)).outputs
    }

    assert all(row.is_within for row in found.values())
    for row in allocation.binding:
        assert_allclose(found[row.output.name].utilisation, row.allowed, rtol=1e-9)
        assert_allclose(row.allowed, 1.0, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "limits", "strategy"),
    [
        *(("zhao-2019", "navigation-grade", strategy) for strategy in STRATEGIES),
        ("hg4930#C", "tactical-grade", "proportional"),
    ],
)
def test_what_is_allocated_meets_by_compare(name, limits, strategy):
    """Judged as a device of its own it meets; without the last check it may not."""
    wanted = load_requirement(limits)
    allocation = allot(
        load_device(name), wanted=wanted, strategy=strategy, validate=True
    )
    found = compare([device(*allocation.sensors)], wanted)

    assert {row.verdict for row in found.devices} == {"meets"}


def test_without_the_last_check_an_allocation_may_stay_undecided():
    """Control: shared out to the limit itself, the law is not sure to the last bit."""
    wanted = load_requirement("navigation-grade")
    found = compare([device(*allot(wanted=wanted).sensors)], wanted)

    assert "undecided" in {row.verdict for row in found.devices}


def test_what_trials_judge_is_allocated_so_that_it_does_not_fail():
    """A bound of uniform shape ends at its limit: undecided at the worst."""
    wanted = load_requirement("tactical-grade")
    whole, _ = fill(load_device("dg068#10"), "predict")  # it lacks lines
    allocation = allot(whole, wanted=wanted, validate=True)
    (row,) = compare([device(*allocation.sensors)], wanted).devices

    assert row.verdict in {"meets", "undecided"}
    assert row.utilisation > 0.99
    assert "monte-carlo" in {one.interval_by for one in row.outputs}


def test_monte_carlo_returns_the_limit():
    """The trials' interval ends at the binding limit, within 4 standard errors."""
    allocation = allot(validate=True)

    assert {check.output.split(".")[0] for check in allocation.checks} == {
        "gyro",
        "accelerometer",
    }
    for check in allocation.checks:
        # A quantile at p has the error sqrt(p (1 - p) / n) / density [u].
        error = np.sqrt(0.025 * 0.975 / check.trials) / 0.05844 / 1.96
        assert abs(check.reached - 1.0) < 4.0 * np.sqrt(2.0) * error
        assert not check.is_corrected


def test_the_law_is_corrected_where_coverage_is_off():
    """A uniform source alone covers all of 1.96 u, so it may be 1.96/1.645 larger.

    95 % of a uniform law is 0.95 of its half-width, 0.95 sqrt(3) u = 1.645 u.
    """
    gyro = builders.sensor(
        "gyro",
        [builders.line("scale_factor_repeatability", 1e-6, distribution=UNIFORM)],
    )
    wanted = requirement({"gyro.scale_factor": 20 * PPM}, reference="nominal")

    allocation = allot(device(gyro), wanted=wanted, validate=True)

    (row,) = allocation.sources
    assert all(check.is_corrected for check in allocation.checks)
    # Half a percent is 5 standard errors of the interval of 250 000 trials.
    assert_allclose(row.allowed, 20 * PPM / (0.95 * np.sqrt(3.0)), rtol=5e-3)
    assert_allclose(row.uncorrected, 20 * PPM / 1.959964, rtol=1e-6)


HARD = builders.sensor(
    "gyro",
    [
        builders.line(
            "bias_repeatability", 1.75 * DEG_PER_HOUR / 3**0.5, distribution=UNIFORM
        )
    ],
)


def test_what_is_now_is_what_every_command_says():
    """A hard bound of 1.75 deg/h uses 0.95 of a limit as large, not 1.96/sqrt(3).

    To the last digit what analyze finds with the requirement; and equal axes stop the
    line together.
    """
    wanted = requirement({"gyro.bias": 1.75 * DEG_PER_HOUR}, reference="nominal")
    unit = device(HARD)
    allocation = allot(unit, wanted=wanted, validate=True)
    budget = analyze(
        unit, requirement=wanted, validate=False, coverage=0.95, reference="nominal"
    )
    rows = assess(budget, wanted).outputs

    for row, said in zip(allocation.outputs, rows, strict=True):
        assert_allclose(row.now, said.utilisation, rtol=1e-12)
        # 100 000 trials: 0.0007 of 0.95, and some rounding of the test's own noise.
        assert_allclose(row.now, 0.95, rtol=5e-3)
    (line,) = allocation.sources
    # A control: by the law the line would have to shrink to 1/1.13.
    by_law = allot(unit, wanted=wanted).sources[0]
    assert_allclose(by_law.factor, 3**0.5 / 1.959964, rtol=1e-6)
    assert_allclose(line.factor, 1.0 / 0.95, rtol=5e-3)
    axes = tuple(Name("bias", owner="gyro", axis=axis) for axis in AXES)
    assert line.binding_outputs == line.headroom.stopped_by == axes


def test_what_is_held_is_now():
    """With every line held a hard bound within its limit can be met, by its trials."""
    wanted = requirement({"gyro.bias": 1.75 * DEG_PER_HOUR}, reference="nominal")
    held = Bounds(held=frozenset({"gyro.bias_repeatability"}), most={}, least={})
    found = [
        allot(device(HARD), wanted=wanted, bounds=held, validate=validate)
        for validate in (True, False)
    ]

    assert [one.feasible for one in found] == [True, False]  # the law alone: no
    for row in found[0].outputs:
        assert_allclose(row.floor, row.now, rtol=5e-3)


def test_lines_that_do_not_matter_stay_as_they_are():
    """A limit on the scale factor asks nothing of the bias; what is spared says so."""
    wanted = requirement({"gyro.scale_factor": 20 * PPM})
    allocation = allot(replace(ZHAO, accelerometer=None), wanted=wanted)
    rows = {row.source.quantity: row for row in allocation.sources}

    spared = {name for name, row in rows.items() if row.is_spared}
    assert spared == {*rows} - {"scale_factor_repeatability"}
    for name in spared:
        assert rows[name].allowed == rows[name].now
        assert rows[name].binding_outputs == ()
        assert rows[name].to_dict()["spared"] is True
    assert rows["scale_factor_repeatability"].factor < 1.0
    assert not any(row.is_spared for row in allot(strategy="equal").sources)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_flicker_is_shared_out_as_any_line(strategy):
    """An instability that is flicker noise gets its part of the limit."""
    gyro = builders.sensor(
        "gyro",
        {"bias_repeatability": 0.05 * DEG_PER_HOUR, "flicker": 0.04 * DEG_PER_HOUR},
    )
    wanted = requirement({"gyro.bias": 0.02 * DEG_PER_HOUR})
    allocation = allot(device(gyro), wanted=wanted, strategy=strategy, validate=True)
    (row,) = (one for one in allocation.sources if one.source == "gyro.flicker")

    assert allocation.feasible
    assert 0.0 < row.allowed < row.now
    assert row.binding_outputs[0].group == "gyro.bias"
    (found,) = compare([device(*allocation.sensors)], wanted).devices
    assert found.utilisation <= 1.0


def test_next_turn_on_counts_a_repeatability_twice():
    """Under next_turn_on a repeatability may be sqrt(2) less than under nominal."""
    gyro = builders.sensor("gyro", {"bias_repeatability": 0.05 * DEG_PER_HOUR})
    limits = {"gyro.bias": 0.01 * DEG_PER_HOUR}
    nominal, later = (
        allowed(
            allot(device(gyro), wanted=requirement(limits, reference=reference)),
            "gyro.bias_repeatability",
        )
        for reference in ("nominal", "next_turn_on")
    )

    assert_allclose(nominal, 0.01 * DEG_PER_HOUR / 1.959964, rtol=1e-6)
    assert_allclose(later, nominal / np.sqrt(2.0), rtol=1e-8)


def test_each_sensor_stands_alone():
    """The accelerometer's allocation is the same with and without a gyro beside it."""
    both = allot(strategy="equal")
    alone = allot(replace(ZHAO, gyro=None), strategy="equal")

    for row in alone.sources:
        assert_allclose(allowed(both, row.source), row.allowed, rtol=1e-12)


def test_a_line_of_zero_stays_held():
    """A present value of zero is not allocated."""
    gyro = builders.paper_gyro(scale_factor_asymmetry=0.0)
    allocation = allot(device(gyro))

    (row,) = (r for r in allocation.sources if r.source.endswith("asymmetry"))
    assert (row.status, row.allowed) == ("zero", 0.0)


def test_held_lines_that_use_a_limit_up_are_named():
    """With bias stability held the gyro bias limits cannot be met, and it is why."""
    bounds = Bounds(held=frozenset({"gyro.bias_stability"}), most={}, least={})
    allocation = allot(bounds=bounds)

    assert not allocation.feasible
    assert {row.output.name for row in allocation.impossible} == {
        f"gyro.bias.{axis}" for axis in AXES
    }
    for row in allocation.impossible:
        worst = max(row.parts, key=lambda part: part.floor)
        assert worst.source == "gyro.bias_stability"
        assert_allclose(worst.floor, row.floor**2, rtol=1e-6)
    assert all(r.allowed is None for r in allocation.sources if "gyro" in r.source[:4])


def test_relaxing_a_limit_to_the_floor_makes_it_feasible():
    """Limits at 1.001 times what is held can be met, at 0.999 they cannot."""
    bounds = Bounds(held=frozenset({"gyro.bias_stability"}), most={}, least={})
    floors = {
        row.output.name: row.floor * row.limit
        for row in allot(bounds=bounds).impossible
    }
    for factor, feasible in ((1.001, True), (0.999, False)):
        limits = tuple(
            replace(limit, limit=factor * floors.get(limit.output, limit.limit))
            for limit in NAVIGATION.limits
            if limit.output in floors
        )
        wanted = replace(NAVIGATION, limits=limits)
        assert allot(wanted=wanted, bounds=bounds).feasible is feasible


@pytest.mark.parametrize(
    ("bias", "verdict"), [("500 deg/h", "meets_if"), ("50000 deg/h", "meets")]
)
def test_what_a_line_hardly_exceeds_is_asked_of_the_sheet(bias, verdict):
    """Not of what is allocated, from whose sizes others would be predicted larger."""
    lines = {"bias_stability": "3 deg/h", "angle_random_walk": "0.2 deg/sqrt(h)"}
    device = {"name": "x", "technology": "mems", "gyro": {"errors": lines}}
    wanted = {"name": "y", "reference": "as_tested", "limits": {"gyro": {"bias": bias}}}
    found = allocate(load_device(device), requirement=wanted, validate=False)

    assert [one.verdict for one in found.standings] == [verdict]


@pytest.mark.slow
@pytest.mark.usefixtures("longer")
def test_a_longer_dwell_that_is_found_meets():
    """The dwell named for what is held meets with it, and one 1 % shorter does not."""
    bounds = Bounds(held=frozenset({"gyro.bias_stability"}), most={}, least={})
    tests = {
        (test.name, test.goal): test
        for test in allot(bounds=bounds).longer_tests
        if test.sensor == "gyro"
    }
    dwell = tests["dwell", "what is held"].needed
    turns = tests["turns", "what is held"].needed

    assert turns is None  # turns do not average the static test
    plan = load_procedure()
    for value, feasible in ((dwell, True), (0.99 * dwell, False)):
        longer = replace(plan, gyro=replace(plan.gyro, dwell=value))
        assert allot(bounds=bounds, procedure=longer).feasible is feasible


@pytest.mark.usefixtures("longer")
def test_longer_windows_that_are_found_meet():
    """Of a test of one's own every dwell is longer in proportion, or every turn."""
    gyro = builders.sensor(
        "gyro", {"angle_random_walk": 0.005 * builders.DEGREE / 60.0}
    )
    wanted = requirement({"gyro.scale_factor": 1e-6}, reference="nominal")
    plan = load_procedure("six-positions-and-turns")
    found = allot(device(gyro), wanted=wanted, procedure=plan).longer_tests
    tests = {test.name: test for test in found}
    turns = int(tests["turns"].needed)

    assert (tests["turns"].now, tests["dwell"].now) == (1.0, 300.0)
    assert tests["dwell"].needed is None  # dwells do not turn
    for n, meets in ((turns - 1, False), (turns, True)):
        windows, later = [], 0.0
        for one in plan.windows:
            n_here = n if one.sense else 1
            setting = replace(one.setting, angle=one.setting.angle * n_here)
            longer = {"start": one.start + later, "length": one.length * n_here}
            windows.append(replace(one, setting=setting, **longer))
            later += one.length * (n_here - 1)
        longer_plan = replace(plan, windows=tuple(windows))
        again = allot(device(gyro), wanted=wanted, procedure=longer_plan)
        assert (again.longer_tests == ()) is meets


@pytest.mark.usefixtures("longer")
def test_more_turns_that_are_found_meet():
    """Turns named for the device as it is meet its limit, one turn fewer does not."""
    gyro = builders.sensor(
        "gyro", {"angle_random_walk": 0.005 * builders.DEGREE / 60.0}
    )
    wanted = requirement({"gyro.mounting_angle": 0.1 * ARCSEC}, reference="nominal")
    tests = {
        test.name: test for test in allot(device(gyro), wanted=wanted).longer_tests
    }
    turns = int(tests["turns"].needed)

    used = []
    for n in (turns - 1, turns):
        problem = calibration_problem((gyro,), builders.procedure(turns=n))
        ends = np.abs(propagate(problem).interval(0.95)).max(axis=1)
        used.append(ends[3:9].max() / (0.1 * ARCSEC))
    assert used[0] > 1.0 >= used[1]


@pytest.mark.parametrize(
    ("source", "most", "least"),
    [
        ("accelerometer.sample_noise", 6e-4, None),
        ("accelerometer.bias_stability", None, 1.9e-4),
    ],
)
def test_bounds_are_kept(source, most, least):
    """A line that would pass --max or --min ends there, and is marked."""
    bounds = Bounds(
        held=frozenset(),
        most={source: most} if most else {},
        least={source: least} if least else {},
    )
    rows = {row.source: row for row in allot(strategy="equal", bounds=bounds).sources}

    assert_allclose(rows[source].allowed, most or least, rtol=1e-12)
    assert (rows[source].at_ceiling, rows[source].at_least) == (bool(most), bool(least))


def test_default_ceilings_are_one_percent_one_degree_and_a_hundredfold():
    """Unlimited lines end at 1 %, 1 deg and 100 times the present value."""
    wanted = requirement({"accelerometer.bias": 1e3})
    allocation = allot(replace(ZHAO, gyro=None), wanted=wanted)
    rows = {row.source.split(".")[1]: row for row in allocation.sources}

    assert all(row.at_ceiling for row in rows.values())
    assert_allclose(rows["scale_factor_repeatability"].allowed, 0.01, rtol=1e-12)
    assert_allclose(rows["mounting_repeatability"].allowed, builders.DEGREE, rtol=1e-12)
    noise = rows["sample_noise"]
    assert_allclose(noise.allowed, 100.0 * noise.now, rtol=1e-12)
    assert any("ceiling" in text for text in allocation.warnings)


def test_headroom_is_where_a_line_alone_meets_its_limit():
    """Grown to its headroom, the scale factor alone brings its output to the limit."""
    (row,) = (
        r for r in allot().sources if r.source == "gyro.scale_factor_repeatability"
    )
    gyro = replace(
        ZHAO.gyro,
        lines=tuple(
            replace(line, u=line.u * row.headroom.value / row.now)
            if line.name == "scale_factor_repeatability"
            else line
            for line in ZHAO.gyro.lines
        ),
    )
    problem = calibration_problem(
        (gyro,), load_procedure(), reference=NAVIGATION.reference
    )
    ends = np.abs(propagate(problem).interval(0.95)).max(axis=1)

    assert row.headroom.stopped_by == tuple(f"gyro.scale_factor.{a}" for a in "xyz")
    assert_allclose(ends[:3].max(), 20 * PPM, rtol=1e-8)


def test_costs_decide_who_pays():
    """A line a thousand times dearer to improve may be larger than at equal costs."""
    dear = Costs(
        costs=(
            Cost(source=Name("bias_stability", owner="gyro"), a=1e3, p=1.0, u_ref=None),
        ),
        assumptions=(),
        origin=builders.NOWHERE,
    )
    plain, paid = allot(strategy="cost"), allot(costs=dear)

    assert paid.settings.strategy == "cost"
    assert allowed(paid, "gyro.bias_stability") > 1.5 * allowed(
        plain, "gyro.bias_stability"
    )
    assert all(report.is_optimal for report in paid.costs)


@pytest.mark.slow
def test_a_cost_at_a_floor_is_in_the_terms_of_the_data_sheet():
    """u_ref as the sheet prints its floor is what the device has: no u_ref at all."""
    one = load_device(
        {
            "name": "x",
            "gyro": {
                "errors": {
                    "bias_stability": {
                        "value": "0.04 deg/h",
                        "definition": "allan_minimum",
                    },
                    "bias_repeatability": "0.05 deg/h",
                }
            },
        }
    )
    wanted = load_requirement(
        {"name": "x", "environment": "none", "limits": {"gyro": {"bias": "0.03 deg/h"}}}
    )
    name = Name("bias_stability", owner="gyro")
    found = [
        allocate(
            one,
            requirement=wanted,
            strategy="cost",
            costs=Costs(
                costs=(Cost(source=name, a=2.0, p=1.5, u_ref=u_ref),),
                assumptions=(),
                origin=builders.NOWHERE,
            ),
        )
        for u_ref in (None, 0.04 * DEG_PER_HOUR, 0.08 * DEG_PER_HOUR)
    ]
    own, same, other = (allowed(each, name) for each in found)

    assert_allclose(same, own, rtol=1e-9)
    assert other > 1.01 * own


def test_parts_add_up_to_the_squared_utilisation():
    """Sources, products and mean error of each limit make up all that is used."""
    for row in allot(strategy="equal").outputs:
        assert_allclose(sum(part.now for part in row.parts), row.now**2, rtol=1e-9)
        used = sum(part.allowed for part in row.parts)
        assert_allclose(used, row.allowed**2, rtol=1e-9)


def test_the_catalogue_is_matched_line_by_line():
    """A device that is exactly what is allowed meets; one line 1 % larger does not."""
    allocation = allot()
    exact = replace(device(*allocation.sensors), name="exact")
    lines = exact.gyro.lines
    worse = replace(
        exact,
        name="worse",
        gyro=replace(
            exact.gyro, lines=(replace(lines[0], u=1.01 * lines[0].u), *lines[1:])
        ),
    )
    poorer = replace(exact, name="poorer", gyro=replace(exact.gyro, lines=lines[1:]))
    matches = [
        match
        for match in allot(catalogue=(poorer, worse, exact)).matches
        if match.sensor == "gyro"
    ]

    assert [match.device for match in matches] == ["exact", "worse", "poorer"]
    assert [match.meets for match in matches] == [True, False, False]
    assert_allclose(matches[1].worst, 1.01, rtol=1e-9)
    assert matches[2].missing == ("gyro.bias_repeatability",)


def test_noise_of_a_sample_is_compared_as_a_density():
    """A velocity random walk N stands for N sqrt(f) of noise in every sample."""
    noisy = builders.sensor("accelerometer", {"velocity_random_walk": 1e-5})
    offered = device(noisy)
    wanted = builders.sensor("accelerometer", {"sample_noise": 1e-3})
    limits = requirement({"accelerometer.bias": 1e-3})
    (match,) = allot(device(wanted), wanted=limits, catalogue=(offered,)).matches

    (line,) = match.lines
    assert_allclose(line.value, 1e-5 * np.sqrt(100.0), rtol=1e-12)
    assert not match.extra


def test_every_file_of_the_market_is_read_once():
    """The catalogue costs one reading of each of its files, however many variants."""
    with patch("budget.inputs.load.open_file", wraps=open_file) as opened:
        load_catalogue()
    files = sorted((shipped("specs") / "devices").glob("*.yaml"))
    assert [one.args[0].path for one in opened.call_args_list] == files


def test_the_market_bounds_below():
    """With --market no line gets better than the best that is offered, or than now."""
    catalogue, warnings = load_catalogue()
    best = best_offered(catalogue)
    loose = replace(
        NAVIGATION,
        limits=tuple(replace(lim, limit=50.0 * lim.limit) for lim in NAVIGATION.limits),
    )
    allocation = allot(wanted=loose, strategy="cost", market=True, catalogue=catalogue)

    assert not warnings
    for row in allocation.sources:
        assert row.allowed >= min(best[row.source], row.now) * (1.0 - 1e-12)


def test_options_that_contradict_each_other_are_refused():
    """Costs with another strategy, and a least value above the largest, are refused."""
    costs = Costs(costs=(), assumptions=(), origin=builders.NOWHERE)
    crossed = Bounds(
        held=frozenset(),
        most={"gyro.bias_stability": 1e-9},
        least={"gyro.bias_stability": 1e-8},
    )
    with pytest.raises(CallError, match="costs count for nothing"):
        allot(costs=costs, strategy="equal")
    with pytest.raises(CallError, match="is above the largest"):
        allot(bounds=crossed)
    with pytest.raises(CallError, match="sets no limit"):
        allot(replace(ZHAO, gyro=None), wanted=requirement({"gyro.bias": 1.0}))


def test_headroom_ends_at_the_ceiling():
    """Far from any limit a line may go to its default bound, or to --max."""
    wanted = requirement({"gyro.scale_factor": 0.03, "gyro.bias": 1.0})
    rows = {row.source: row for row in allot(wanted=wanted).sources}
    row = rows["gyro.scale_factor_repeatability"]
    bound = {row.source: 100.0 * row.now}
    bounded = allot(
        wanted=wanted, bounds=Bounds(held=frozenset(), most=bound, least={})
    )
    (again,) = (r for r in bounded.sources if r.source == row.source)

    assert_allclose(row.headroom.value, 0.01, rtol=1e-12)
    assert row.headroom.stopped_by == ()
    assert_allclose(again.headroom.value, 100.0 * row.now, rtol=1e-12)


@pytest.mark.parametrize(
    ("reference", "counting"), [("as_tested", False), ("next_turn_on", True)]
)
def test_a_repeatability_counts_by_the_reference(reference, counting):
    """As tested it cancels and has no headroom; at the next turn-on it has one."""
    wanted = requirement({"gyro.scale_factor": 200 * PPM}, reference=reference)
    rows = {row.source: row for row in allot(wanted=wanted).sources}
    row = rows["gyro.scale_factor_repeatability"]

    assert row.is_significant is counting
    assert (row.headroom is not None) is counting
    assert row.is_idle is not counting
    assert not rows["accelerometer.bias_repeatability"].is_idle  # no limit at all


def test_a_curve_is_not_held_against_a_constant(tmp_path):
    """K3 of a nonlinearity over a full scale is another quantity than a bare ratio."""
    path = tmp_path / "curve.yaml"
    path.write_text(
        "name: curve\naccelerometer:\n  errors:\n    scale_factor_nonlinearity: "
        "{value: 100 ppm, full_scale: 8 g}\n",
        encoding="utf-8",
    )
    own = load_device(path)
    stim = load_device("stim300#5g")
    bare = stim.accelerometer.line("scale_factor_nonlinearity")
    assert bare is not None
    assert bare.form != own.accelerometer.lines[0].form
    name = "accelerometer.scale_factor_nonlinearity"
    assert name in best_offered((stim,))
    assert name not in best_offered((stim,), own.sensors)
    (match,) = match_catalogue((stim,), own.sensors, sample_rate=100.0)
    (line,) = match.lines
    assert (line.ratio, line.how) == (None, "given as another quantity")
