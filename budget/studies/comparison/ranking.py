"""Ranking of judged devices: order, confidence, Pareto fronts, units of parts."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import reduce
from typing import TYPE_CHECKING, TypeVar

from budget.known import Known
from budget.methods.largest import joined, probability_smaller
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import IMU, MISSION
from budget.results import VERDICTS, Verdict
from budget.studies.comparison.records import (
    NUMBERED,
    Entrant,
    Lead,
    Unit,
    probability_of,
)
from budget.studies.figures_of_merit import MERITS, front, read_amount
from budget.studies.judgement import together
from budget.studies.verdicts import FAILS, UNDECIDABLE, gravest
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from budget.names import Name

R = TypeVar("R", Entrant, Unit)

BOTH = (IMU, MISSION)  # owners of what is of both triads together


def rank_devices(found: Iterable[Entrant]) -> tuple[Entrant, ...]:
    """Rank what was judged within each sensor and procedure, and find the fronts.

    What is only known to be this or more, rests on lines of others, or does not read
    what it is asked for, beats nobody: it is on no front.
    """
    lists: dict[tuple[str, str], list[Entrant]] = {}
    for one in found:
        lists.setdefault((one.sensor, one.procedure), []).append(one)
    every = []
    for ranked in map(rank, lists.values()):
        beaten = [one.rests_on_others or one.saturates for one in ranked]
        fronts = {
            merit: front(
                [
                    (
                        one.utilisation,
                        None if is_no else read_amount(merit, getattr(one, merit)),
                    )
                    for one, is_no in zip(ranked, beaten, strict=True)
                ]
            )
            for merit in MERITS
        }
        every += [
            replace(one, on_front=tuple(m for m in MERITS if fronts[m][place]))
            for place, one in enumerate(ranked)
        ]
    return tuple(every)


def rank(found: Iterable[R]) -> list[R]:
    """Order a list best first, say how sure each step is, and number it."""
    order: list[R] = sorted(found, key=place_of)
    following = [*order[1:], None]
    return numbered(
        [
            replace(one, ahead=None if after is None else _ahead(one, after))
            for one, after in zip(order, following, strict=True)
        ]
    )


def numbered(order: Iterable[R]) -> list[R]:
    """Give each its rank; neighbours that cannot be told apart at 95 % share one.

    What neither meets nor meets on conditions has none.
    """
    found: list[R] = []
    rank, was_tied = 0, False
    for place, one in enumerate(order, start=1):
        rank = rank if was_tied else place
        is_tied = one.ahead is not None and one.ahead.is_tied
        is_ranked = one.verdict in NUMBERED
        found.append(
            replace(one, rank=rank, is_tied=is_tied or was_tied) if is_ranked else one
        )
        was_tied = is_tied
    return found


def place_of(one: Entrant | Unit) -> tuple[float, ...]:
    """Return what a device is ranked by, of the parts it is judged by: less is better.

    The verdict, of predicted ones the probability, the utilisation with every missing
    line at its ceiling, what it is on what is given. What is hidden is no better: where
    three digits of it are equal, a bound comes after a full value, and more conditions
    and more that is not given after fewer.
    """
    used = Known.largest(part.utilisation for part in one.parts)
    worst = used.like(settle(max(map(_at_ceilings, one.parts))))
    return (
        VERDICTS.index(one.verdict),
        -(probability_of(one.parts) or 0.0),
        *worst.order,
        len(one.conditions),
        len(one.negligible),
        worst,
        settle(used),
    )


def _at_ceilings(row: Entrant) -> float:
    """Return the utilisation with every missing line at its ceiling, if it has one."""
    if row.at_worst is None or row.verdict in {UNDECIDABLE, FAILS}:
        return row.utilisation  # the smaller `>=` first
    return row.at_worst


def _ahead(one: Entrant | Unit, following: Entrant | Unit) -> Lead | None:
    """Return how sure it is that one is better than the next; None by the law.

    None also where one of them is only known to be this or more, or rests on lines of
    other devices: of what is not given nobody knows a probability. Between two verdicts
    the verdict decides, whatever the utilisations are.
    """
    both = (one.parts, following.parts)
    if following.verdict != one.verdict or any(
        x.trials is None or x.rests_on_others for parts in both for x in parts
    ):
        return None
    # The ends of all parts are moved by the same trials.
    ends = [joined([part.looked_at.ends for part in parts]) for parts in both]
    return Lead(other=following.name, probability=probability_smaller(*ends))


def shared_by_both(outputs: Iterable[Name]) -> frozenset[str]:
    """Return owners of outputs that are of both triads together."""
    return frozenset(name.owner for name in outputs if name.owner in BOTH)


def pair_up(rows: Sequence[Entrant], *, shared: frozenset[str]) -> tuple[Unit, ...]:
    """Pair every gyro with every accelerometer of the same procedure, best first.

    Whether two devices meet limits that are `shared` by both nobody knows.
    """
    devices = by_device(row for row in rows if row.sensor in BOTH)
    found = [
        as_one((gyro, other, *own), shared=shared)
        for gyro in rows
        if gyro.sensor == GYRO
        for other in rows
        if other.sensor == ACCELEROMETER and other.procedure == gyro.procedure
        for whole in [devices.get((gyro.procedure, gyro.place), [])]
        for own in [whole if gyro.place == other.place else []]
    ]
    return tuple(sorted(found, key=place_of))


def rank_imus(rows: Sequence[Entrant], *, shared: frozenset[str]) -> tuple[Unit, ...]:
    """Rank the devices of which both sensors are judged, under each procedure."""
    lists: dict[str, list[Unit]] = {}
    for (procedure, _), parts in by_device(rows).items():
        own = [one for kind in (*SENSORS, *BOTH) for one in parts if one.sensor == kind]
        if len(own) > 1 or any(one.sensor == IMU for one in own):
            lists.setdefault(procedure, []).append(as_one(own, shared=shared))
    return tuple(one for found in lists.values() for one in rank(found))


def by_device(rows: Iterable[Entrant]) -> dict[tuple[str, int], list[Entrant]]:
    """Return the parts of each device under each procedure, as they stand."""
    found: dict[tuple[str, int], list[Entrant]] = {}
    for one in rows:
        found.setdefault((one.procedure, one.place), []).append(one)
    return found


def as_one(parts: Sequence[Entrant], *, shared: frozenset[str], order: int = 0) -> Unit:
    """Put parts together: triads as one, counted in the same trials, then the mission.

    The gravest verdict, the largest utilisation, the missing lines of all. Limits that
    are `shared` by both triads are met by what is judged of both, and else undecidable.
    """
    triads = [one for one in parts if one.sensor != MISSION]
    is_counted = len(triads) > 1 and all(one.is_judged for one in parts)
    standings: list[Verdict] = [*parts]
    if is_counted:
        missions = [one for one in parts if one.sensor == MISSION]
        standings = [_counted(triads), *missions]
    whole: Verdict = reduce(Verdict.beside, standings)
    own = {one.name: getattr(whole, one.name) for one in fields(Verdict)}
    if len(triads) > 1 and not shared <= {one.sensor for one in parts}:
        own["verdict"] = gravest((whole.verdict, UNDECIDABLE))
    return Unit(**own, parts=tuple(parts), order=order)


def _counted(triads: Sequence[Entrant]) -> Verdict:
    """Return the verdict on triads whose limits are counted in the same trials."""
    whole: Verdict = reduce(Verdict.beside, triads)
    verdict = whole.verdict
    judged = [one.judged for one in triads if one.judged is not None]
    all_of, needed = together(judged), judged[0].together
    if needed is not None and all_of.value < needed and not whole.at_medians:
        verdict = FAILS
    conditions = () if verdict == FAILS else whole.conditions  # no answer mends it
    return replace(whole, verdict=verdict, conditions=conditions, conformance=all_of)
