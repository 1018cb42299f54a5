"""Ranking of judged devices: order, confidence, Pareto fronts, units of parts."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import reduce
from itertools import pairwise
from typing import TYPE_CHECKING, TypeVar

from budget.known import Known
from budget.methods.largest import joined, probability_smaller
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import IMU, MISSION
from budget.results import VERDICTS, Verdict
from budget.spooled import Made, chained
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
    from budget.studies.figures_of_merit import Amount

R = TypeVar("R", Entrant, Unit)

BOTH = (IMU, MISSION)  # owners of what is of both triads together


def rank_devices(found: Sequence[Entrant]) -> Sequence[Entrant]:
    """Rank what was judged within each sensor and procedure, and find the fronts.

    What is only known to be this or more, rests on lines of others, or does not read
    what it is asked for, beats nobody: it is on no front.
    """
    lists: dict[tuple[str, str], list[int]] = {}
    for place, one in enumerate(found):
        if one.is_judged:
            lists.setdefault((one.sensor, one.procedure), []).append(place)
    return chained(
        _with_fronts(rank(Made(found.__getitem__, own))) for own in lists.values()
    )


def _with_fronts(ranked: Sequence[Entrant]) -> Sequence[Entrant]:
    """Say of each of a list for which merits it is on the front."""
    points: dict[str, list[tuple[float, Amount | None]]] = {m: [] for m in MERITS}
    for one in ranked:
        is_beaten = one.rests_on_others or one.saturates
        for merit, own in points.items():
            amount = None if is_beaten else read_amount(merit, getattr(one, merit))
            own.append((float(one.utilisation), amount))
    fronts = {merit: front(own) for merit, own in points.items()}
    best = [
        tuple(merit for merit in MERITS if fronts[merit][place])
        for place in range(len(ranked))
    ]
    return Made(
        lambda place: replace(ranked[place], on_front=best[place]), range(len(ranked))
    ).held()


def rank(found: Sequence[R]) -> Sequence[R]:
    """Order a list best first, say how sure each step is, and number it.

    Neighbours that cannot be told apart at 95 % share a rank; what neither meets nor
    meets on conditions has none.
    """
    keys, is_counted = [], False
    for one in found:
        keys.append(place_of(one))
        is_counted = is_counted or one.trials is not None
    order = sorted(range(len(keys)), key=keys.__getitem__)
    ordered = Made(found.__getitem__, order).held()
    ahead: list[Lead | None] = [None] * len(order)
    if is_counted:
        ahead[:-1] = [_ahead(one, after) for one, after in pairwise(ordered)]
    numbers = numbered([VERDICTS[int(keys[k][0])] for k in order], ahead)

    def make(place: int) -> R:
        rank, is_tied = numbers[place]
        return replace(ordered[place], ahead=ahead[place], rank=rank, is_tied=is_tied)

    return Made(make, range(len(order))).held()


def numbered(
    verdicts: Iterable[str], ahead: Iterable[Lead | None]
) -> list[tuple[int | None, bool]]:
    """Return the rank of each of a list, and whether a neighbour shares it."""
    found: list[tuple[int | None, bool]] = []
    rank, was_tied = 0, False
    for place, (verdict, lead) in enumerate(zip(verdicts, ahead, strict=True), 1):
        rank = rank if was_tied else place
        is_tied = lead is not None and lead.is_tied
        is_ranked = verdict in NUMBERED
        found.append((rank, is_tied or was_tied) if is_ranked else (None, False))
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


def rank_imus(rows: Sequence[Entrant], *, shared: frozenset[str]) -> Sequence[Unit]:
    """Rank the devices of which both sensors are judged, under each procedure."""
    kinds = (*SENSORS, *BOTH)
    parts: dict[tuple[str, int], list[tuple[int, int]]] = {}
    for place, one in enumerate(rows):
        own = parts.setdefault((one.procedure, one.place), [])
        own.append((kinds.index(one.sensor), place))
    lists: dict[str, list[list[int]]] = {}
    for (procedure, _), own in parts.items():
        if len(own) > 1 or kinds[own[0][0]] == IMU:
            lists.setdefault(procedure, []).append([k for _, k in sorted(own)])

    def unit(own: list[int]) -> Unit:
        return as_one([rows[k] for k in own], shared=shared)

    return chained(rank(Made(unit, own).held()) for own in lists.values())


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
    each = [one.counted for one in triads if one.counted is not None]
    all_of, needed = together(each), each[0].together
    if needed is not None and all_of.value < needed and not whole.at_medians:
        verdict = FAILS
    conditions = () if verdict == FAILS else whole.conditions  # no answer mends it
    return replace(whole, verdict=verdict, conditions=conditions, conformance=all_of)
