"""Records of an allocation from its factors: sources, limits and costs."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.known import Known
from budget.methods.allocation import SPARED, TOUCHES, headroom_of
from budget.methods.scaling import NEGLIGIBLE
from budget.model.sources import SHARED
from budget.names import Name
from budget.results import INTERACTION, TINY
from budget.studies.allocation.cases import RETUNINGS
from budget.studies.allocation.records import (
    FREE,
    MEAN,
    NOT_REQUIRED,
    ZERO,
    CostReport,
    Headroom,
    LimitPart,
    Saving,
    SharedLimit,
    SourceAllotment,
)
from budget.ties import first_largest, from_largest, largest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Sensor
    from budget.methods.allocation import Task
    from budget.studies.allocation.cases import SensorCase

ONE_PERCENT = 0.01  # [1]
COUNTS = 1e-3  # part of a squared limit from which a source is said to count [1]


def limited_outputs(case: SensorCase) -> tuple[SharedLimit, ...]:
    """Say of each limit who takes how much of it, now and after the allocation."""
    task, s = case.task, case.s
    printed = {limit.output: limit.printed for limit in case.question.wanted.limits}
    # What is now is as every command judges it, each output by its own k.
    judged = case.judged.factor / case.present.roundness(task.now)
    states = [
        (replace(case.present, coverage_factor=judged), task.now),
        (replace(case.present, law=case.least_law), task.least),
        *([] if s is None else [(task, s)]),
    ]
    used = [by.utilisation(state) for by, state in states]
    parts = [_parts(by, state) for by, state in states]
    bound = np.zeros(len(task.limit), bool) if s is None else task.binding(s)
    names = (*task.law.sources, INTERACTION, MEAN)
    return tuple(
        SharedLimit(
            output=case.outputs[name],
            limit=float(task.limit[k]),
            printed_limit=printed[name],
            now=Known.of(float(used[0][k]), case.question.lacks[name]),
            floor=float(used[1][k]),
            allowed=None if s is None else float(used[2][k]),
            is_binding=bool(bound[k]),
            parts=tuple(
                LimitPart(
                    source=source,
                    now=float(parts[0][k, g]),
                    floor=float(parts[1][k, g]),
                    allowed=None if s is None else float(parts[2][k, g]),
                )
                for g, source in enumerate(names)
            ),
        )
        for k, name in enumerate(task.law.outputs)
    )


def source_allotments(
    sensor: Sensor, cases: Sequence[SensorCase], offered: Mapping[Name, float]
) -> tuple[SourceAllotment, ...]:
    """Say of each line of one sensor what it is and what it may be."""
    own = [case for case in cases if sensor.kind in case.kinds]
    if not own:
        return tuple(
            SourceAllotment(
                source=Name(line.name, owner=sensor.kind),
                unit=line.unit,
                si_per_unit=line.si_per_unit,
                status=NOT_REQUIRED,
                now=line.largest,
                allowed=line.largest,
                best_offered=offered.get(Name(line.name, owner=sensor.kind)),
            )
            for line in sensor.lines
        )
    rows = [_allotments(case, offered, owners={sensor.kind}) for case in own]
    by_name = {row.source: row for row in rows[0]}
    return tuple(_both(by_name.get(row.source), row) for row in rows[-1])


def _both(first: SourceAllotment | None, last: SourceAllotment) -> SourceAllotment:
    """Put together what limits on the sensor and on the mission say of one line.

    Its ceiling by the mission is what the sensor's limits allow.
    """
    if first is None or first is last:
        return last
    rooms = [row.headroom for row in (first, last) if row.headroom is not None]
    by_sensor = last.at_ceiling  # which is what the sensor allows
    return replace(
        last,
        ceiling=first.ceiling,
        at_ceiling=first.at_ceiling and last.at_ceiling,
        is_spared=first.is_spared if by_sensor else last.is_spared,
        is_minor=first.is_minor and last.is_minor,
        binding_outputs=first.binding_outputs if by_sensor else last.binding_outputs,
        is_significant=first.is_significant or last.is_significant,
        headroom=min(rooms, key=lambda room: room.value, default=None),
    )


def shared_allotments(cases: Sequence[SensorCase]) -> tuple[SourceAllotment, ...]:
    """Say of each line of the station and the environment what it takes.

    It belongs to neither triad, so it stays as it is; alone it may go as far as the
    triad lets it that is the first to be at a limit.
    """
    found: dict[Name, list[SourceAllotment]] = {}
    for case in cases:
        for row in _allotments(case, {}, owners={*SHARED}):
            found.setdefault(row.source, []).append(row)
    merged = []
    for rows in found.values():
        rooms = [row.headroom for row in rows if row.headroom is not None]
        nearest = (
            first_largest([1.0 / max(room.value, TINY) for room in rooms])
            if rooms
            else 0
        )
        solved = all(row.allowed is not None for row in rows)
        merged.append(
            replace(
                rows[0],
                allowed=rows[0].allowed if solved else None,
                is_significant=any(row.is_significant for row in rows),
                headroom=rooms[nearest] if rooms else None,
            )
        )
    return tuple(merged)


def _allotments(
    case: SensorCase, offered: Mapping[Name, float], *, owners: set[str]
) -> tuple[SourceAllotment, ...]:
    """Say it of the lines of some owners."""
    task, s = case.task, case.s
    takes = task.part(case.factors)[task.binding(case.factors)].max(axis=0, initial=0.0)
    rows = []
    for g, name in enumerate(task.law.sources):
        if name.owner not in owners:
            continue
        line = case.question.lines[name]
        now = line.largest
        status = case.statuses[g]
        free = status == FREE
        allotted = s is not None and free
        significant = status != ZERO and _counts(replace(task, law=case.law), g)
        rows.append(
            SourceAllotment(
                source=name,
                unit=line.unit,
                si_per_unit=line.si_per_unit,
                status=status,
                now=now,
                allowed=None if s is None else now * float(s[g]),
                uncorrected=(
                    now * float(case.by_law[g])
                    if case.by_law is not None and free
                    else None
                ),
                ceiling=now * float(task.high[g]) if free else None,
                least=now * float(task.low[g]) if free else None,
                at_ceiling=allotted
                and bool(case.factors[g] >= task.high[g] * (1.0 - TOUCHES)),
                at_least=allotted
                and bool(case.factors[g] <= task.low[g] * (1.0 + TOUCHES)),
                is_spared=allotted and bool(case.spared[g]),
                is_minor=allotted and bool(case.spared[g] and takes[g] <= SPARED),
                binding_outputs=_binding_outputs(task, case.factors, g)
                if allotted and not case.spared[g]
                else (),
                is_significant=significant,
                headroom=_headroom(case, g, now) if significant else None,
                best_offered=offered.get(name),
            )
        )
    return tuple(rows)


def cost_report(case: SensorCase) -> CostReport:
    """Say what the cheapest allocation of one sensor costs and what limits cost."""
    solution, prices = case.solution, case.prices
    if solution is None or prices is None:
        raise ValueError(f"the {case.owner} was not allocated by cost")
    task = case.task
    bound = task.binding(solution.s)
    groups: dict[Name, list[int]] = {}
    for k in np.flatnonzero(bound):
        groups.setdefault(task.law.outputs[k].group, []).append(int(k))
    savings = []
    for places in groups.values():
        saves = ONE_PERCENT * float(solution.multiplier[places].sum())
        savings.append(
            Saving(
                outputs=tuple(task.law.outputs[k] for k in places),
                saves=saves,
                part=saves / solution.cost if solution.cost > 0.0 else 0.0,
            )
        )
    return CostReport(
        sensor=case.owner,
        now=float(prices.each(task.now)[task.free].sum()),
        cost=solution.cost,
        residual=solution.residual,
        gap=solution.gap,
        is_optimal=solution.is_optimal,
        solver=solution.solver,
        savings=tuple(
            savings[k] for k in from_largest([saving.saves for saving in savings])
        ),
    )


def _parts(task: Task, s: Array) -> Array:
    """Return parts of the squared limits, shape (n_out, n_src + 2) [1].

    Sources alone, then products of two sources, then what the mean takes: they add up
    to the square of the utilisation.
    """
    alone = task.part(s)
    scale = (task.factor(s) / task.limit) ** 2
    spread = scale * task.law.variance(s)
    mean = task.utilisation(s) ** 2 - spread
    return np.column_stack([alone, spread - alone.sum(axis=1), np.maximum(mean, 0.0)])


def _counts(task: Task, g: int) -> bool:
    """Whether a source takes something of a limit, at its ceiling at the latest.

    Products with the other sources, as they are now, and the mean are in it.
    """
    law = task.law
    q = max(float(task.high[g]), 1.0) ** 2
    others = 1.0 - np.eye(len(law.sources))[g]
    spread = q * (
        law.first[:, g] + law.second[:, g, g] * q + 2.0 * law.second[:, g] @ others
    )
    part = (task.factor(task.now) / task.limit) ** 2 * spread
    shift = np.abs(law.shift[:, g]) * q / task.limit
    return bool((np.maximum(part, shift) >= COUNTS).any())


def _headroom(case: SensorCase, g: int, now: float) -> Headroom:
    """Return how far a source may go alone: to a limit, or to its ceiling before.

    With the filter of a unit of which it is so large, step by step as in solve.
    """
    task, ceiling = case.present, float(case.task.high[g])
    room = headroom_of(task, task.now, g)
    own = case.is_tuned and task.law.sources[g].owner in case.kinds
    for _ in range(RETUNINGS if own else 0):
        if room.factor > ceiling:
            break
        law = case.law_of(np.where(np.arange(len(task.now)) == g, room.factor, 1.0))
        before, room = room, headroom_of(replace(task, law=law), task.now, g)
        if abs(room.factor - before.factor) <= sqrt(case.tuned_to) * room.factor:
            break
    if not room.stopped_by or room.factor > ceiling:
        return Headroom(value=now * ceiling, stopped_by=())
    return Headroom(
        value=now * room.factor,
        stopped_by=tuple(task.law.outputs[k] for k in room.stopped_by),
    )


def _binding_outputs(task: Task, s: Array, g: int) -> tuple[Name, ...]:
    """Return the outputs at their limits of which a source takes most, if it counts.

    Equal ones are all named.
    """
    part = np.where(task.binding(s), task.part(s)[:, g], 0.0)
    return tuple(
        task.law.outputs[k] for k in largest(part.tolist()) if part[k] >= NEGLIGIBLE
    )
