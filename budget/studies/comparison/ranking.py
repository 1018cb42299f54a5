"""Ranking of judged devices: order, confidence, Pareto fronts, pairs."""

from __future__ import annotations

from dataclasses import replace
from math import inf, prod
from typing import TYPE_CHECKING

from budget.methods.largest import probability_smaller
from budget.studies.comparison.records import (
    VERDICTS,
    DeviceVerdict,
    Lead,
    Pair,
)
from budget.studies.figures_of_merit import MERITS, front, read_amount
from budget.studies.judgement import together
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence


# What a pair is where its parts differ, the last one rules: a part that fails, fails.
GRAVEST = ("meets", "undecided", "predicted", "undecidable", "fails")


def rank(verdicts: Sequence[DeviceVerdict]) -> tuple[DeviceVerdict, ...]:
    """Order each list best first, say how sure each step is, and find the fronts."""
    lists: dict[tuple[str, str], list[DeviceVerdict]] = {}
    for row in verdicts:
        lists.setdefault((row.sensor, row.procedure), []).append(row)
    ranked: list[DeviceVerdict] = []
    for rows in lists.values():
        order = sorted(rows, key=_place)
        # What is only known to be this or more, or rests on lines of others, beats
        # nobody: it is on no front.
        fronts = {
            merit: front(
                [
                    (
                        r.utilisation,
                        None
                        if r.rests_on_others
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


def _place(row: DeviceVerdict) -> tuple[int, float, int, float, float]:
    """Return what a device is ranked by: less is better.

    A line that is taken from a data sheet never improves it: decided ones come first,
    then those that lack fewer lines, then the least utilisation at worst and now. What
    rests on predicted lines stands between those that meet and those that fail, the
    most probable first: of equal probability the decided one is the better.
    """
    lacks = 0 if row.missing is None else len(row.missing.lines)
    verdict = row.verdict
    if verdict == "undecided" and lacks:  # no trial will make it meet
        verdict = "undecidable"
    elif verdict == "undecidable" and not lacks:  # a limit by which none is judged
        verdict = "meets"
    elif row.doubt is not None and row.doubt.probability == 0.0:
        verdict = "fails"  # of equal probability the decided one is the better
    worst = inf if row.at_worst is None else settle(row.at_worst)
    p = 0.0 if row.doubt is None else row.doubt.probability
    return VERDICTS.index(verdict), -p, lacks, worst, settle(row.utilisation)


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


def _both(gyro: DeviceVerdict, other: DeviceVerdict) -> float | None:
    """Return the probability that both meet; None where nothing is predicted.

    As if their missing lines were independent: of one device they go together, and
    then it is more.
    """
    doubts = [one.doubt for one in (gyro, other) if one.doubt is not None]
    if not doubts or max(gyro.verdict, other.verdict, key=GRAVEST.index) != "predicted":
        return None
    return prod(doubt.probability for doubt in doubts)


def pair_up(rows: Sequence[DeviceVerdict], *, every: bool) -> tuple[Pair, ...]:
    """Pair gyros and accelerometers of the same procedure, best first.

    Every one with every other, or only those that are one device.
    """
    found = []
    for gyro in (row for row in rows if row.sensor == "gyro"):
        for other in (row for row in rows if row.sensor == "accelerometer"):
            if other.procedure != gyro.procedure:
                continue
            if not every and other.place != gyro.place:
                continue
            found.append(
                Pair(
                    gyro=gyro.name,
                    accelerometer=other.name,
                    procedure=gyro.procedure,
                    verdict=max(gyro.verdict, other.verdict, key=GRAVEST.index),
                    probability=_both(gyro, other),
                    at_medians=gyro.at_medians or other.at_medians,
                    lower_bound=gyro.lower_bound or other.lower_bound,
                    utilisation=max(gyro.utilisation, other.utilisation),
                    conformance=together((gyro.judged, other.judged)),
                )
            )
    found.sort(
        key=lambda p: (
            VERDICTS.index(p.verdict),
            -(p.probability or 0.0),
            p.lower_bound,
            settle(p.utilisation),
        )
    )
    return tuple(found)
