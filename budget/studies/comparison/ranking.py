"""Ranking of judged devices: order, confidence, Pareto fronts, pairs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from typing import TYPE_CHECKING

from budget.methods.largest import joined, probability_smaller
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS
from budget.names import IMU
from budget.results import VERDICTS
from budget.studies.comparison.records import DeviceVerdict, Lead, Pair
from budget.studies.figures_of_merit import MERITS, front, read_amount
from budget.studies.judgement import together
from budget.studies.verdicts import FAILS, PREDICTED, UNDECIDABLE, gravest
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.methods.largest import Ends
    from budget.results import Standing


def rank(verdicts: Sequence[DeviceVerdict]) -> tuple[DeviceVerdict, ...]:
    """Order each list best first, say how sure each step is, and find the fronts."""
    lists: dict[tuple[str, str], list[DeviceVerdict]] = {}
    for row in verdicts:
        lists.setdefault((row.sensor, row.procedure), []).append(row)
    ranked: list[DeviceVerdict] = []
    for rows in lists.values():
        order = sorted(rows, key=lambda row: place_of((row,), row.standing))
        # What is only known to be this or more, rests on lines of others, or does not
        # read what it is asked for, beats nobody: it is on no front.
        fronts = {
            merit: front(
                [
                    (
                        r.utilisation,
                        None
                        if r.rests_on_others or r.standing.saturates
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


def place_of(parts: Sequence[DeviceVerdict], standing: Standing) -> tuple[float, ...]:
    """Return what a device is ranked by, of the parts it is judged by: less is better.

    The verdict, of predicted ones the probability, the utilisation with every missing
    line at its ceiling, what it is on what is given. What is hidden is no better: where
    three digits of it are equal, a bound comes after a full value, and more conditions
    and more that is not given after fewer.
    """
    worst = settle(max(map(_at_ceilings, parts)))
    return (
        VERDICTS.index(standing.verdict),
        -(_all(parts) or 0.0),
        float(f"{worst:.2e}"),
        any(one.lower_bound for one in parts),
        len(standing.conditions),
        len(standing.negligible),
        worst,
        settle(max(one.utilisation for one in parts)),
    )


def _at_ceilings(row: DeviceVerdict) -> float:
    """Return the utilisation with every missing line at its ceiling, if it has one."""
    if row.at_worst is None or row.verdict in {UNDECIDABLE, FAILS}:
        return row.utilisation  # the smaller `>=` first
    return row.at_worst


def _ahead(row: DeviceVerdict, following: DeviceVerdict | None) -> Lead | None:
    """Return how sure it is that a device is better than the next; None by the law.

    None also where one of them is only known to be this or more, or rests on lines of
    other devices.

    Between two verdicts the verdict decides, whatever the utilisations are.
    """
    if following is None or following.verdict != row.verdict or row.trials is None:
        return None
    if row.rests_on_others or following.rests_on_others:
        return None  # of what is not given nobody knows a probability
    return Lead(
        other=following.name,
        probability=probability_smaller(row.closer.ends, following.closer.ends),
    )


def _all(parts: Sequence[DeviceVerdict]) -> float | None:
    """Return the probability that all parts meet; None where nothing is predicted.

    As if their missing lines were independent: of one device they go together, and
    then it is more.
    """
    doubts = [one.doubt for one in parts if one.doubt is not None]
    if not doubts or gravest(one.verdict for one in parts) != PREDICTED:
        return None
    return prod(doubt.probability for doubt in doubts)


def pair_up(rows: Sequence[DeviceVerdict], *, is_shared: bool) -> tuple[Pair, ...]:
    """Pair every gyro with every accelerometer of the same procedure, best first.

    Where limits `is_shared` by both nobody knows whether those of two devices meet.
    """
    whole = {(row.procedure, row.place): row for row in rows if row.sensor == IMU}
    found = [
        _Imu(pair=as_one(parts, is_shared=is_shared), parts=parts)
        for gyro in rows
        if gyro.sensor == GYRO
        for shared in [whole.get((gyro.procedure, gyro.place))]
        for other in rows
        if other.sensor == ACCELEROMETER and other.procedure == gyro.procedure
        for own in [[shared] if gyro.place == other.place and shared else []]
        for parts in [(gyro, other, *own)]
    ]
    found.sort(key=lambda one: one.place)
    return tuple(one.pair for one in found)


def rank_imus(rows: Sequence[DeviceVerdict], *, is_shared: bool) -> tuple[Pair, ...]:
    """Rank the devices of which both sensors are judged, under each procedure.

    As `rank` does, with the gravest verdict of both and, where limits `is_shared`, of
    what belongs to both, the missing lines of all and the largest utilisation; so sure
    as the largest of the outputs of all tells them apart.
    """
    both: dict[tuple[str, int], dict[str, DeviceVerdict]] = {}
    for row in rows:
        if row.sensor in {*SENSORS, IMU}:
            both.setdefault((row.procedure, row.place), {})[row.sensor] = row
    lists: dict[str, list[_Imu]] = {}
    for (procedure, _), parts in both.items():
        if IMU in parts or len(parts) > 1:
            own = [parts[kind] for kind in (*SENSORS, IMU) if kind in parts]
            one = _Imu(pair=as_one(own, is_shared=is_shared), parts=tuple(own))
            lists.setdefault(procedure, []).append(one)
    ranked: list[Pair] = []
    for found in lists.values():
        order = sorted(found, key=lambda one: one.place)
        for one, following in zip(order, [*order[1:], None], strict=True):
            ranked.append(replace(one.pair, ahead=one.lead(following)))
    return tuple(ranked)


@dataclass(frozen=True, kw_only=True)
class _Imu:
    """Both sensors of one device, and what belongs to both."""

    pair: Pair
    parts: tuple[DeviceVerdict, ...]

    @property
    def place(self) -> tuple[float, ...]:
        """What it is ranked by: less is better."""
        return place_of(self.parts, self.pair.standing)

    @property
    def ends(self) -> Ends:
        """The ends of all, moved by the same trials."""
        return joined([one.closer.ends for one in self.parts])

    def lead(self, following: _Imu | None) -> Lead | None:
        """Return how sure it is that this one is better than the next, as `_ahead`."""
        if following is None or following.pair.verdict != self.pair.verdict:
            return None
        every = (*self.parts, *following.parts)
        if any(one.trials is None or one.rests_on_others for one in every):
            return None
        return Lead(
            other=following.pair.gyro,
            probability=probability_smaller(self.ends, following.ends),
        )


def as_one(parts: Sequence[DeviceVerdict], *, is_shared: bool) -> Pair:
    """Put a gyro and an accelerometer together, and what belongs to both.

    Where limits `is_shared` by both nobody knows whether those of two devices meet.
    """
    worst = max(parts, key=lambda one: settle(one.utilisation))
    standing = parts[0].standing
    for one in parts[1:]:
        verdict = gravest((standing.verdict, one.verdict))
        standing = standing.beside(one.standing, verdict=verdict)
    if is_shared and not any(one.sensor == IMU for one in parts):
        verdict = gravest((standing.verdict, UNDECIDABLE))
        standing = replace(standing, verdict=verdict)
    all_of, needed = together([x.judged for x in parts]), parts[0].judged.together
    at_medians = any(one.at_medians for one in parts)
    if needed is not None and all_of.value < needed and not at_medians:
        standing = replace(standing, verdict=FAILS)
    if standing.verdict == FAILS:  # nothing to ask for could mend it
        standing = replace(standing, conditions=())
    names = {one.sensor: one.name for one in parts}
    return Pair(
        gyro=names.get(GYRO, parts[0].name),
        accelerometer=names.get(ACCELEROMETER, parts[0].name),
        procedure=parts[0].procedure,
        standing=standing,
        probability=_all(parts),
        at_medians=at_medians,
        lower_bound=any(one.lower_bound for one in parts),
        utilisation=worst.utilisation,
        worst_outputs=worst.worst_outputs,
        limiting_source=worst.remedy.source,
        conformance=all_of,
    )
