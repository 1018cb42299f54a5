"""Allocation: a requirement in, the standard uncertainty of each line out."""

from __future__ import annotations

import itertools
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import calibrates
from budget.errors import CallError
from budget.inputs import load_costs
from budget.methods.allocation import TOUCHES
from budget.methods.trials import coverage_of
from budget.names import IMU, MISSION, Name
from budget.question import Question, limited_but_held
from budget.sentences import sentence
from budget.settings import Asked, Engine, Inputs, asking
from budget.studies.allocation.cases import (
    COVERAGE_OFF,
    NO_BOUNDS,
    resize,
    set_up,
    shared_by_equals,
    solve,
)
from budget.studies.allocation.longer_tests import (
    find_longer_tests,
    find_recalibrations,
)
from budget.studies.allocation.market import (
    best_offered,
    load_catalogue,
    match_catalogue,
)
from budget.studies.allocation.records import Allocation, CoverageCheck
from budget.studies.allocation.rows import (
    cost_report,
    limited_outputs,
    shared_allotments,
    source_allotments,
)
from budget.studies.blunders import against_limits
from budget.studies.cautions import (
    not_estimated,
    not_of_one_sensor,
    of_no_vehicle,
)
from budget.studies.envelope import envelope
from budget.studies.judgement import judge
from budget.studies.verdicts import stand

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import (
        Costs,
        Device,
        Sensor,
    )
    from budget.studies.allocation.cases import Bounds, SensorCase

TRIALS = 250_000  # for which 0.2 % of coverage are 4.6 standard errors at 95 %
MARGIN = 0.001  # that a corrected k has over the trials', which vary by as much [1]
SETTLED = 0.001  # relative change of k that needs no further correction [1]
CORRECTIONS = 6  # at the most
ASSURED = 1e-9  # more than an interval reaches over a limit, for a file's digits [1]


@asking("allocate")
def allocate(
    *devices: Device | File,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    costs: Costs | File | None = None,
    bounds: Bounds = NO_BOUNDS,
    market: bool = False,
) -> Allocation:
    """Find the standard uncertainty that each line may have.

    Parameters
    ----------
    *devices : Device
        Where to start; together at most one gyro and one accelerometer.
    costs : Costs, optional
        For the strategy 'cost'; lines that it does not name have a = p = 1.
    bounds : Bounds
        Lines that are held, and bounds of others.
    market : bool
        Whether no line may become better than the best in the catalogue, or than it
        is now.

    Returns
    -------
    Allocation
        `feasible` says whether the limits can be met.

    Raises
    ------
    CallError
        Options that do not fit together, limits on a mission without one, or no limit
        for any sensor that is there.
    """
    return allocate_as(
        Question.load(*devices, inputs=inputs),
        asked,
        engine=engine,
        costs=costs,
        bounds=bounds,
        market=market,
    )


def allocate_as(
    question: Question,
    asked: Asked,
    *,
    engine: Engine,
    costs: Costs | File | None = None,
    bounds: Bounds = NO_BOUNDS,
    market: bool = False,
) -> Allocation:
    """Share out limits as `allocate` does, of a calibration and of its mission."""
    wanted = question.whole().wanted
    journey = question.mission if MISSION in wanted.kinds else None
    without = question if question.mission is None else replace(question, mission=None)
    unit = without if journey is None else question.alone(MISSION)
    how, sensors, catalogue = unit.procedure, unit.sensors, question.catalogue
    prices = None if costs is None else load_costs(costs)
    strategy, seed = _choose_strategy(asked.strategy, prices), asked.seed
    warnings: tuple[str, ...] = ()
    if catalogue is None:
        catalogue, warnings = load_catalogue()
    offered = best_offered(catalogue, sensors)
    cases = _set_up(question, unit, bounds, offered if market else {}, seed)
    if not cases:
        raise CallError(
            f"{wanted.name} sets no limit for what is estimated of a sensor "
            "that is there "
            f"({', '.join(sensor.kind for sensor in sensors)}); add limits for it"
        )
    if asked.validate:  # begins with what Monte Carlo found of the present state
        cases = [replace(case, task=case.present) for case in cases]
    feasible = all(case.is_feasible for case in cases)
    longer_tests = tuple(test for case in cases for test in find_longer_tests(case))
    share_out = partial(solve, strategy=strategy, costs=prices)
    for place, one in enumerate(cases):
        case = one if one.question.journey is None else one.at_most(_allowed(cases))
        feasible = feasible and case.is_feasible
        if case.is_feasible:
            solved = share_out(case)
            if asked.validate:
                solved = _correct(solved, share_out, seed=seed)
                solved = _assure(solved, share_out, seed=seed)
            cases[place] = solved
        if engine.progress is not None:
            engine.progress("error allocation", place + 1, len(cases))
    if journey is not None:
        cases = _together(cases)
    there = {sensor.kind for sensor in sensors} | {case.owner for case in cases}
    missing = tuple(kind for kind in wanted.kinds if kind not in there)
    allotted = tuple(_resized(sensor, cases) for sensor in sensors)
    solved_kinds = {kind for case in cases if case.s is not None for kind in case.kinds}
    settings = replace(
        asked.settle(wanted), method="gum", strategy=strategy, formulas=how.formulas
    )
    return Allocation(
        **envelope(
            unit,
            settings,
            assumed=() if prices is None else prices.assumptions,
            warned=(
                *warnings,
                *of_no_vehicle(journey),
                *against_limits(how, wanted),
                *(() if journey is None else not_estimated(unit.devices, how, wanted)),
                *not_of_one_sensor(wanted),
                *_warnings(unit, cases, missing, bounds, prices),
            ),
            files={} if prices is None else {"costs": prices},
        ),
        feasible=feasible,
        not_allocated=missing,
        not_estimated=limited_but_held(there, how, wanted.outputs),
        standings=tuple(
            standing
            for case in cases
            if feasible and case.s is not None
            for standing in [stand(case.found, seed=seed)]
            if standing is not None
        ),
        sources=(
            *(
                row
                for sensor in sensors
                for row in source_allotments(sensor, cases, offered)
            ),
            *shared_allotments(cases),
        ),
        outputs=tuple(row for case in cases for row in limited_outputs(case)),
        checks=tuple(check for case in cases for check in case.checks),
        costs=tuple(cost_report(case) for case in cases if case.solution is not None),
        longer_tests=longer_tests,
        recalibrations=tuple(
            one for case in cases for one in find_recalibrations(case)
        ),
        matches=match_catalogue(
            catalogue,
            tuple(sensor for sensor in allotted if sensor.kind in solved_kinds),
            sample_rate=how.sample_rate,
        ),
        sensors=allotted,
    )


def _set_up(
    question: Question,
    unit: Question,
    bounds: Bounds,
    market: Mapping[Name, float],
    seed: int,
) -> list[SensorCase]:
    """Return what has limits: the triads, then the unit on a mission.

    What the limits on sensors allow is the most that those on a mission may take.
    """
    of_test = question
    if question.journey is not None:
        of_test = replace(question, carried_to=None)
    asked = [
        of_test.alone(sensor.kind)
        for sensor in unit.sensors
        if calibrates(sensor.kind, of_test.procedure)
    ]
    asked += [] if unit.journey is None else [unit]
    found = (set_up(one, bounds, market, seed=seed) for one in asked)
    return [case for case in found if case is not None]


def _choose_strategy(strategy: str | None, costs: Costs | None) -> str:
    """Return the strategy that is meant."""
    if strategy is None:
        return "proportional" if costs is None else "cost"
    if costs is not None and strategy != "cost":
        raise CallError(
            f"costs count for nothing in the strategy {strategy!r}; "
            "use the strategy 'cost', or leave them out"
        )
    return strategy


def _correct(
    case: SensorCase, share_out: Callable[[SensorCase], SensorCase], *, seed: int
) -> SensorCase:
    """Check the allocation by Monte Carlo; where coverage is off, allocate again.

    The k of an output whose law misses the coverage becomes what the trials need, so
    that their largest interval end is |m| + k u, and a little more. Allocating again
    moves the mixture of shapes, so this goes on until k has settled. Equal outputs
    share one k.
    """
    law_factor = case.normal_factor
    for _ in range(CORRECTIONS):
        task, s = case.task, case.factors
        found_case = case.found
        problem, law, held = found_case.problem, found_case.law, found_case.held
        if held is None:
            break
        rows = [
            [output.name for output in problem.outputs].index(name)
            for name in task.law.outputs
        ]
        every = held.every_coverage
        coverage = every[rows]
        found = coverage_of(
            problem,
            law.interval(every),
            coverage=every,
            trials=TRIALS,
            seed=seed,
        )
        u = law.standard_uncertainty[rows]
        ends = np.abs(found.interval[rows]).max(axis=1)
        inside, shape = found.inside[rows], task.roundness(s)
        checks = tuple(
            CoverageCheck(
                output=name,
                trials=found.trials,
                covered=float(inside[k]),
                factor_before=float(law_factor[k] * shape[k]),
                factor=float(task.coverage_factor[k] * shape[k]),
                reached=float(ends[k] / task.limit[k]),
            )
            for k, name in enumerate(task.law.outputs)
            if task.binding(s)[k]
        )
        case = replace(case, checks=checks)
        off = (np.abs(inside - coverage) > COVERAGE_OFF) & (
            u > np.array([problem.outputs[row].resolution for row in rows])
        )
        needed = (ends - np.abs(law.mean[rows])) / np.where(u > 0.0, u, np.inf)
        k_next = np.where(off, needed / shape * (1.0 + MARGIN), law_factor)
        k_next = shared_by_equals(task, s, k_next)
        moved = np.abs(k_next / task.coverage_factor - 1.0)
        k_next = np.where(moved > SETTLED, k_next, task.coverage_factor)
        corrected = replace(task, coverage_factor=k_next)
        at_limit = task.binding(s) | (corrected.utilisation(s) > 1.0)
        if not (at_limit & (moved > SETTLED)).any():
            case = replace(case, task=corrected)
            break
        if not replace(case, task=corrected).is_feasible:
            break
        case = share_out(replace(case, task=corrected))
    if not any(check.is_corrected for check in case.checks):
        return case
    by_law = replace(case, task=replace(case.task, coverage_factor=law_factor))
    return replace(case, by_law=share_out(by_law).s) if by_law.is_feasible else case


def _assure(
    case: SensorCase, share_out: Callable[[SensorCase], SensorCase], *, seed: int
) -> SensorCase:
    """Judge the allocated device as every command does; tighten what would fail.

    The k of the outputs at their limits grows by what the interval of the utilisation
    reaches over 1: until it is within, and where trials judge until it does not fail.
    Trials leave it undecided then, as an allocation is at its limit by design.
    """
    for _ in range(CORRECTIONS):
        task, s = case.task, case.factors
        found = case.found
        if found.held is None:
            break
        judged = judge(found.held, seed=seed)
        verdict, over = judged.verdict(), judged.utilisation_interval[1]
        if verdict == "meets" or (verdict == "undecided" and judged.by_trials.any()):
            break
        factor = np.where(task.binding(s), over * (1.0 + ASSURED), 1.0)
        tightened = replace(
            case, task=replace(task, coverage_factor=factor * task.coverage_factor)
        )
        if not tightened.is_feasible:
            break
        case = share_out(tightened)
    return case


def _resized(sensor: Sensor, cases: Sequence[SensorCase]) -> Sensor:
    """Return a sensor with its allocated values, as it is where there are none."""
    own = [case for case in cases if sensor.kind in case.kinds]  # the last one rules
    if not own or own[-1].s is None:
        return sensor
    return resize(sensor, own[-1].task.law.sources, own[-1].s)


def _allowed(cases: Sequence[SensorCase]) -> dict[Name, float]:
    """Return the factors that limits on sensors allow their lines."""
    return {
        name: float(factor)
        for case in cases
        if case.question.journey is None and case.s is not None
        for name, factor, free in zip(
            case.task.law.sources, case.s, case.task.free, strict=True
        )
        if free
    }


def _together(cases: Sequence[SensorCase]) -> list[SensorCase]:
    """Return the cases of sensors with the lines that the mission allows them.

    Less than their own limits do, so that these are met; what Monte Carlo found at
    limits that are not reached any more is left out. Without a solution for all of
    them there is none.
    """
    last = cases[-1]
    if last.s is None or any(case.s is None for case in cases):
        return [replace(case, s=None, by_law=None, checks=()) for case in cases]
    by_name = dict(zip(last.task.law.sources, last.s.tolist(), strict=True))
    found = []
    for case in cases[:-1]:
        s = np.array([by_name[name] for name in case.task.law.sources])
        kept = {*itertools.compress(case.task.law.outputs, case.task.binding(s))}
        checks = tuple(check for check in case.checks if check.output in kept)
        found.append(replace(case, s=s, checks=checks))
    return [*found, last]


def _warnings(
    unit: Question,
    cases: Sequence[SensorCase],
    missing: Sequence[str],
    bounds: Bounds,
    costs: Costs | None,
) -> tuple[str, ...]:
    """Say what a reader should know before believing the table.

    `missing` are those that have limits and are not there.
    """
    sensors, journey = unit.sensors, unit.journey
    given = {Name(line.name, owner=s.kind) for s in sensors for line in s.lines}
    named = {
        "held": sorted(bounds.held),
        "bounded": sorted({*bounds.most, *bounds.least}),
        "given a cost": [] if costs is None else [c.source for c in costs.costs],
    }
    required = {kind for case in cases for kind in case.kinds}
    texts = [
        *(
            sentence(
                "allocations.not_there",
                sensor=kind,
                is_calibrated=calibrates(kind, unit.procedure),
            )
            for kind in missing
            if kind not in {IMU, MISSION}
        ),
        *(
            sentence(place)
            for place, has in (
                ("allocations.retuned", "aiding"),
                ("allocations.own_filter", "filter"),
            )
            if journey is not None and getattr(journey, has)
        ),
        *(
            sentence("allocations.unknown", name=name, what=what)
            for what, names in named.items()
            for name in names
            if name not in given
        ),
        *(
            sentence("allocations.no_limit", sensor=one.kind)
            for one in sensors
            if one.kind not in required
        ),
    ]
    said: set[Name] = set()
    for case in cases:
        kind = case.owner
        if not case.task.free.any():
            texts.append(sentence("allocations.nothing_free", sensor=kind))
        elif case.s is not None and not case.task.binding(case.s).any():
            at_top = case.s >= case.task.high * (1.0 - TOUCHES)
            if at_top[case.task.free].all():
                texts.append(sentence("allocations.at_ceilings", sensor=kind))
        if case.solution is not None and not case.solution.is_optimal:
            texts.append(
                sentence(
                    "allocations.not_optimal",
                    sensor=kind,
                    gap=case.solution.gap,
                    residual=case.solution.residual,
                )
            )
        if case.by_law is not None:
            texts.append(sentence("allocations.by_trials", sensor=kind))
        lacking = [
            name for one in case.question.sensors for name in one.expected_missing
        ]
        if new := [name for name in lacking if name not in said]:
            said.update(new)
            texts.append(sentence("allocations.missing", lines=new))
    return tuple(texts)
