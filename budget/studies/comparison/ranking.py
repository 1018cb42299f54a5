"""Ranking of judged devices: order, confidence, Pareto fronts, pairs."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import reduce
from math import prod
from typing import TYPE_CHECKING

from budget.methods.largest import joined, probability_smaller
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import IMU
from budget.results import VERDICTS, Verdict
from budget.studies.comparison.records import Entrant, Lead, Pair
from budget.studies.figures_of_merit import MERITS, front, read_amount
from budget.studies.judgement import together
from budget.studies.verdicts import FAILS, PREDICTED, UNDECIDABLE, gravest
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence


def rank(verdicts: Sequence[Entrant]) -> tuple[Entrant, ...]:
    """Order each list best first, say how sure each step is, and find the fronts."""
    lists: dict[tuple[str, str], list[Entrant]] = {}
    for row in verdicts:
        lists.setdefault((row.sensor, row.procedure), []).append(row)
    ranked: list[Entrant] = []
    for rows in lists.values():
        order = sorted(rows, key=lambda row: place_of((row,), row))
        # What is only known to be this or more, rests on lines of others, or does not
        # read what it is asked for, beats nobody: it is on no front.
        fronts = {
            merit: front(
                [
                    (
                        r.utilisation,
                        None
                        if r.rests_on_others or r.saturates
                        else read_amount(merit, getattr(r, merit)),
                    )
                    for r in order
                ]
            )
            for merit in MERITS
        }
        for place, row in enumerate(order):
            following = order[place + 1] if place + 1 < len(order) else None
            ranked.append(
                replace(
                    row,
                    ahead=_ahead(row, following),
                    on_front=tuple(m for m in MERITS if fronts[m][place]),
                )
            )
    return tuple(ranked)


def place_of(parts: Sequence[Entrant], whole: Verdict) -> tuple[float, ...]:
    """Return what a device is ranked by, of the parts it is judged by: less is better.

    The verdict, of predicted ones the probability, the utilisation with every missing
    line at its ceiling, what it is on what is given. What is hidden is no better: where
    three digits of it are equal, a bound comes after a full value, and more conditions
    and more that is not given after fewer.
    """
    worst = settle(max(map(_at_ceilings, parts)))
    return (
        VERDICTS.index(whole.verdict),
        -(_all(parts) or 0.0),
        float(f"{worst:.2e}"),
        any(one.utilisation.is_bound for one in parts),
        len(whole.conditions),
        len(whole.negligible),
        worst,
        settle(max(one.utilisation for one in parts)),
    )


def _at_ceilings(row: Entrant) -> float:
    """Return the utilisation with every missing line at its ceiling, if it has one."""
    if row.at_worst is None or row.verdict in {UNDECIDABLE, FAILS}:
        return row.utilisation  # the smaller `>=` first
    return row.at_worst


def _ahead(one: Entrant | Pair, following: Entrant | Pair | None) -> Lead | None:
    """Return how sure it is that one is better than the next; None by the law.

    None also where one of them is only known to be this or more, or rests on lines of
    other devices: of what is not given nobody knows a probability. Between two verdicts
    the verdict decides, whatever the utilisations are.
    """
    if following is None or following.verdict != one.verdict:
        return None
    both = [x.parts if isinstance(x, Pair) else (x,) for x in (one, following)]
    if any(x.trials is None or x.rests_on_others for parts in both for x in parts):
        return None
    # The ends of all parts are moved by the same trials.
    ends = [joined([part.looked_at.ends for part in parts]) for parts in both]
    name = following.gyro if isinstance(following, Pair) else following.name
    return Lead(other=name, probability=probability_smaller(*ends))


def _all(parts: Sequence[Entrant]) -> float | None:
    """Return the probability that all parts meet; None where nothing is predicted.

    As if their missing lines were independent: of one device they go together, and
    then it is more.
    """
    doubts = [one.doubt for one in parts if one.doubt is not None]
    if not doubts or gravest(one.verdict for one in parts) != PREDICTED:
        return None
    return prod(doubt.probability for doubt in doubts)


def pair_up(rows: Sequence[Entrant], *, is_shared: bool) -> tuple[Pair, ...]:
    """Pair every gyro with every accelerometer of the same procedure, best first.

    Where limits `is_shared` by both nobody knows whether those of two devices meet.
    """
    whole = {(row.procedure, row.place): row for row in rows if row.sensor == IMU}
    found = [
        as_one((gyro, other, *own), is_shared=is_shared)
        for gyro in rows
        if gyro.sensor == GYRO
        for shared in [whole.get((gyro.procedure, gyro.place))]
        for other in rows
        if other.sensor == ACCELEROMETER and other.procedure == gyro.procedure
        for own in [[shared] if gyro.place == other.place and shared else []]
    ]
    return tuple(sorted(found, key=lambda one: place_of(one.parts, one)))


def rank_imus(rows: Sequence[Entrant], *, is_shared: bool) -> tuple[Pair, ...]:
    """Rank the devices of which both sensors are judged, under each procedure.

    As `rank` does, with the gravest verdict of both and, where limits `is_shared`, of
    what belongs to both, the missing lines of all and the largest utilisation; so sure
    as the largest of the outputs of all tells them apart.
    """
    both: dict[tuple[str, int], dict[str, Entrant]] = {}
    for row in rows:
        if row.sensor in {*SENSORS, IMU}:
            both.setdefault((row.procedure, row.place), {})[row.sensor] = row
    lists: dict[str, list[Pair]] = {}
    for (procedure, _), parts in both.items():
        if IMU in parts or len(parts) > 1:
            own = [parts[kind] for kind in (*SENSORS, IMU) if kind in parts]
            lists.setdefault(procedure, []).append(as_one(own, is_shared=is_shared))
    ranked: list[Pair] = []
    for found in lists.values():
        order = sorted(found, key=lambda one: place_of(one.parts, one))
        for one, following in zip(order, [*order[1:], None], strict=True):
            ranked.append(replace(one, ahead=_ahead(one, following)))
    return tuple(ranked)


def as_one(parts: Sequence[Entrant], *, is_shared: bool) -> Pair:
    """Put a gyro and an accelerometer together, and what belongs to both.

    Where limits `is_shared` by both nobody knows whether those of two devices meet.
    """
    whole: Verdict = reduce(Verdict.beside, parts)
    verdict = whole.verdict
    if is_shared and not any(one.sensor == IMU for one in parts):
        verdict = gravest((verdict, UNDECIDABLE))
    judged = [one.judged for one in parts if one.judged is not None]
    all_of, needed = together(judged), judged[0].together
    if needed is not None and all_of.value < needed and not whole.at_medians:
        verdict = FAILS
    if verdict == FAILS:  # nothing to ask for could mend it
        whole = replace(whole, conditions=())
    whole = replace(whole, verdict=verdict, conformance=all_of)
    names = {one.sensor: one.name for one in parts}
    return Pair(
        **{one.name: getattr(whole, one.name) for one in fields(Verdict)},
        gyro=names.get(GYRO, parts[0].name),
        accelerometer=names.get(ACCELEROMETER, parts[0].name),
        procedure=parts[0].procedure,
        parts=tuple(parts),
        probability=_all(parts),
    )
