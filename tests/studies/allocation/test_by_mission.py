"""What each line may be for limits on a mission: the lines of both triads together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import requirement
from numpy.testing import assert_allclose

from budget.errors import CallError
from budget.inputs import load_device, load_mission, load_procedure
from budget.inputs.records import Limit
from budget.methods.scaling import scaled_law
from budget.names import MISSION, Name
from budget.question import Question
from budget.studies.allocation import allocate as module
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import STRATEGIES, Bounds, resize
from budget.studies.allocation.longer_tests import find_longer_tests
from budget.studies.comparison import judging
from budget.studies.comparison.compare import compare
from budget.studies.judgement import screen
from budget.units import ARCSEC

ZHAO = load_device("zhao-2019")
BENCH = load_mission("bench")
MILE = 1852.0  # [m]
HORIZONTAL = Name("position", owner=MISSION, axis="horizontal", time=3600.0)


@pytest.fixture(autouse=True)
def nothing_longer(monkeypatch):
    """Look for no longer test, which takes ten times what an allocation takes."""
    monkeypatch.setattr(module, "find_longer_tests", lambda _: ())


def on_mission(limit=MILE, *, coverage=0.5, sensors=(), times=1.0):
    """Return a limit on the horizontal position after an hour [m], and on sensors."""
    basis = requirement(sensors=sensors, times=times, reference="next_turn_on")
    own = Limit(output=HORIZONTAL, limit=limit, printed=f"{limit} m", coverage=coverage)
    return replace(basis, limits=(*basis.limits, own))


def allot(wanted, **options):
    """Allocate without catalogue and Monte Carlo unless asked for."""
    options = {"catalogue": (), "validate": False, "mission": BENCH, **options}
    return allocate(ZHAO, requirement=wanted, **options)


def made(allocation):
    """Return the device with its lines as allocated."""
    gyro, accelerometer = allocation.sensors
    return replace(ZHAO, gyro=gyro, accelerometer=accelerometer)


def by_mission(device, wanted, **options):
    """Return the verdict on a device by the mission."""
    rows = compare([device], wanted, mission=BENCH, **options).devices
    return next(row for row in rows if row.sensor == MISSION)


@pytest.mark.parametrize("coverage", [0.5, 0.95])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_allocated_lines_bring_the_circle_to_its_limit(strategy, coverage, monkeypatch):
    """By the law, with the k of the ellipse that the allocated lines make."""

    def by_law(held, *, seed, max_trials):  # noqa: ARG001 - as `screened`
        return screen(held, seed=seed)

    monkeypatch.setattr(judging, "screened", by_law)  # at the limit trials decide
    wanted = on_mission(coverage=coverage)
    allocation = allot(wanted, strategy=strategy)

    (row,) = allocation.outputs
    found = by_mission(made(allocation), wanted, method="gum")

    assert row.is_binding
    assert_allclose(found.utilisation, row.allowed, rtol=1e-9)
    assert_allclose(row.allowed, 1.0, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("reach", [0.2, 3.0])  # of the limit, in miles
def test_what_is_allocated_does_not_fail_by_compare(reach):
    """Judged by trials as a device of its own it meets, or is at its limit."""
    wanted = on_mission(reach * MILE)
    allocation = allot(wanted, validate=True)

    assert by_mission(made(allocation), wanted).verdict in {"meets", "undecided"}
    assert all(check.reached <= 1.01 for check in allocation.checks)


@pytest.mark.slow
def test_cost_shares_out_lines_of_both_triads():
    """The cheapest is no dearer than one factor on all lines, and a proven optimum."""
    wanted = on_mission()
    cheap, alike = (allot(wanted, strategy=how) for how in ("cost", "proportional"))
    (report,) = cheap.costs

    price = sum(
        1.0 / row.factor for row in alike.sources if row.status == "free" and row.now
    )

    assert report.is_optimal
    assert report.cost < price
    factors = {
        row.source.owner: row.factor for row in cheap.sources if row.status == "free"
    }
    assert set(factors) == {"gyro", "accelerometer"}


@pytest.mark.slow
def test_limits_on_sensors_and_mission_hold_together():
    """Each line is at most what either allows; the device fails none of them."""
    wanted = on_mission(sensors=("gyro",), times=0.01)
    sensor_limits = [one for one in wanted.limits if one.output != HORIZONTAL]
    by_gyro = allot(replace(wanted, limits=tuple(sensor_limits)), mission=None)
    both, alone = allot(wanted), allot(on_mission())

    first, without = (
        {row.source: row.allowed for row in one.sources} for one in (by_gyro, alone)
    )
    lines = [row for row in both.sources if row.status == "free"]
    of_gyro = [row for row in lines if row.source.owner == "gyro"]
    assert all(row.allowed <= first[row.source] * (1.0 + 1e-12) for row in of_gyro)
    rows = compare([made(both)], wanted, mission=BENCH, method="gum").devices
    assert {row.sensor: row.verdict != "fails" for row in rows} == {
        "gyro": True,
        MISSION: True,
    }
    stops = {name.owner for row in of_gyro for name in row.binding_outputs}
    assert stops == {"gyro"}
    # A control: the limits of the gyro bind, or this would be the mission alone.
    assert any(row.allowed < 0.9 * without[row.source] for row in of_gyro)
    assert any(row.is_binding for row in both.outputs if row.sensor == MISSION)


@pytest.mark.parametrize("limit", [6.0, 120.0])  # [arcmin]
def test_a_limit_on_heading_asks_nothing_of_accelerometers(limit):
    """They give less than a thousandth of its variance: they stay, the gyro does it.

    At 6 arcmin they take half of the squared limit, so that the gyro has the rest.
    """
    heading = Name("attitude", owner=MISSION, axis="heading", time=600.0)
    basis = requirement(sensors=(), reference="next_turn_on")
    wanted = replace(
        basis,
        limits=(
            Limit(output=heading, limit=60.0 * limit * ARCSEC, printed=f"{limit}"),
        ),
    )
    allocation = allocate(
        load_device("hg4930#C"),
        requirement=wanted,
        procedure=load_procedure(None),
        mission=BENCH,
        catalogue=(),
        validate=False,
    )
    rows = [row for row in allocation.sources if row.source.owner == "accelerometer"]

    assert allocation.feasible
    assert all(row.factor == 1.0 and row.is_spared for row in rows)
    (output,) = allocation.outputs
    assert_allclose(output.allowed, 1.0, rtol=1e-8)
    of_gyro = [row for row in allocation.sources if row.source.owner == "gyro"]
    assert min(row.factor for row in of_gyro) < 0.7


def test_what_a_mission_limits_now_is_what_compare_says():
    """The circle is judged by trials, and so is what it is now."""
    wanted = on_mission()
    (row,) = allot(wanted).outputs

    assert_allclose(row.now, by_mission(ZHAO, wanted).utilisation, rtol=1e-12)


def test_what_cannot_be_met_says_so(monkeypatch):
    """With every line held as it is, after a test 6.7 miles are no mile.

    The limit is named.

    What is held is the devices as they are, so one longer test is found for both.
    """
    monkeypatch.setattr(module, "find_longer_tests", find_longer_tests)
    held = frozenset(
        Name(line.name, owner=sensor.kind)
        for sensor in ZHAO.sensors
        for line in sensor.lines
    )

    test = load_procedure(None)
    allocation = allot(
        on_mission(), bounds=Bounds(held=held, most={}, least={}), procedure=test
    )

    assert not allocation.feasible
    (row,) = allocation.impossible
    assert row.output.name == HORIZONTAL
    now = by_mission(ZHAO, on_mission(), method="gum", procedures=test).utilisation
    assert_allclose(row.floor, now, rtol=1e-9)
    by_goal = {test.goal: [] for test in allocation.longer_tests}
    for test in allocation.longer_tests:
        by_goal[test.goal].append(replace(test, goal=""))
    (as_they_are, floor) = by_goal.values()
    assert as_they_are == floor
    found = {(test.sensor, test.name): test for test in floor}
    assert {*found} == {
        ("gyro", "turns"),
        ("gyro", "dwell"),
        ("accelerometer", "dwell"),
    }
    # Repeatabilities are left, however long a test is: none brings it to the mile.
    assert all(test.needed is None and test.best > test.now for test in floor)
    assert all(1.0 < test.utilisation < 0.999999 * now for test in floor)


def test_limits_on_a_mission_need_one():
    """Without a mission nothing is shared out for it: refused, in words."""
    with pytest.raises(CallError, match="--mission"):
        allot(on_mission(), mission=None)


@pytest.mark.parametrize("coverage", [0.5, 0.95, 0.999])
def test_coverage_factor_of_a_length_follows_its_ellipse(coverage):
    """For other sizes of the sources it is that of the law propagated anew."""
    unit = Question.of(ZHAO, requirement=on_mission(), mission=BENCH, carried_to=())
    problem = unit.problem
    law = scaled_law(problem).select((HORIZONTAL,))
    row = next(k for k, one in enumerate(problem.outputs) if one.name == HORIZONTAL)
    rng = np.random.default_rng(7)

    for _ in range(3):
        s = np.exp(rng.normal(0.0, 2.0, len(law.sources)))
        resized = unit.with_sensors(resize(x, law.sources, s) for x in unit.sensors)
        held = [name.owner not in {"gyro", "accelerometer"} for name in law.sources]
        s = np.where(held, 1.0, s)
        anew = resized.law
        along = law.roundness(s, np.array([coverage]))
        normal = anew.coverage_factor(coverage)[0]  # of a component
        assert_allclose(
            normal * along[0], anew.coverage_factor(coverage)[row], rtol=1e-9
        )
        slope = law.log_roundness_gradient(s, np.array([coverage]))[0]
        for g in range(len(s)):
            ends = []
            for step in (1e-5, -1e-5):
                moved = s.copy()
                moved[g] *= np.exp(step)
                ends.append(np.log(law.roundness(moved, np.array([coverage]))[0]))
            # A difference of 1e-5 of numbers of 1e-16.
            assert_allclose(slope[g], (ends[0] - ends[1]) / 2e-5, rtol=1e-4, atol=1e-8)
