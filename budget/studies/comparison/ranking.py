"""Best first, and how sure: order, neighbours, fronts and pairs of judged devices."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from budget.studies.comparison.figures_of_merit import MERITS, front, read_amount
from budget.studies.comparison.records import (
    VERDICTS,
    Ahead,
    DeviceVerdict,
    Pair,
    Probability,
)
from budget.studies.comparison.sampling import probability_smaller

if TYPE_CHECKING:
    from collections.abc import Sequence


def rank(verdicts: Sequence[DeviceVerdict]) -> tuple[DeviceVerdict, ...]:
    """Order each list best first, say how sure each step is, and find the fronts."""
    lists: dict[tuple[str, str], list[DeviceVerdict]] = {}
    for row in verdicts:
        lists.setdefault((row.sensor, row.procedure), []).append(row)
    ranked: list[DeviceVerdict] = []
    for rows in lists.values():
        order = sorted(rows, key=lambda r: (VERDICTS.index(r.verdict), r.utilisation))
        fronts = {
            merit: front(
                [(r.utilisation, read_amount(merit, getattr(r, merit))) for r in order]
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


def _ahead(row: DeviceVerdict, following: DeviceVerdict | None) -> Ahead | None:
    """Return how sure it is that a device is better than the next; None by the law.

    Between two verdicts the verdict decides, whatever the utilisations are.
    """
    if following is None or following.verdict != row.verdict or row.trials is None:
        return None
    return Ahead(
        other=following.name,
        probability=probability_smaller(row.batches, following.batches),
    )


def pair_up(rows: Sequence[DeviceVerdict]) -> tuple[Pair, ...]:
    """Pair every gyro with every accelerometer of the same procedure, best first."""
    found = []
    for gyro in (row for row in rows if row.sensor == "gyro"):
        for other in (row for row in rows if row.sensor == "accelerometer"):
            if other.procedure != gyro.procedure:
                continue
            a, b = gyro.conformance, other.conformance
            found.append(
                Pair(
                    gyro=gyro.name,
                    accelerometer=other.name,
                    procedure=gyro.procedure,
                    verdict=max(gyro.verdict, other.verdict, key=VERDICTS.index),
                    utilisation=max(gyro.utilisation, other.utilisation),
                    conformance=Probability(
                        value=a.value * b.value, low=a.low * b.low, high=a.high * b.high
                    ),
                )
            )
    found.sort(key=lambda p: (VERDICTS.index(p.verdict), p.utilisation))
    return tuple(found)
