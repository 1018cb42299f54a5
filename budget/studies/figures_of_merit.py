"""Price, mass and power of a device: texts of a maker as numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import groupby
from math import inf
from operator import itemgetter
from typing import TYPE_CHECKING

from budget.sentences import sentence

if TYPE_CHECKING:
    from collections.abc import Sequence

MERITS = ("price", "mass", "power")

# Factors to the first unit of each kind [kg, W]; a price keeps its currency.
UNITS = {
    "mass": {"kg": 1.0, "g": 1e-3, "gram": 1e-3, "grams": 1e-3, "lb": 0.45359237},
    "power": {"W": 1.0, "mW": 1e-3},
}
# Catalogue files add the maker's remark in brackets: '140 grams (typical)'.
NUMBER = re.compile(
    r"\s*[<≤~]?\s*(\d+(?:\.\d+)?)\s*([A-Za-z€$]+)\s*(?:\(.*\))?\s*", re.DOTALL
)


@dataclass(frozen=True, kw_only=True)
class Amount:
    """A number that can be compared with others of the same unit."""

    value: float
    unit: str


def read_amount(merit: str, text: str) -> Amount | None:
    """Read '140 g', '2 W' or '50000 EUR'; None for a text that is no such number."""
    match = NUMBER.fullmatch(text)
    if match is None:
        return None
    value, unit = float(match[1]), match[2]
    if merit == "price":
        return Amount(value=value, unit=unit.upper())
    factor = UNITS[merit].get(unit)
    if factor is None:
        return None
    return Amount(value=value * factor, unit=next(iter(UNITS[merit])))


def is_within(merit: str, text: str, cap: str) -> bool | None:
    """Whether a maker's text keeps a cap; None where nobody can tell."""
    have, most = read_amount(merit, text), read_amount(merit, cap)
    if have is None or most is None or have.unit != most.unit:
        return None
    return have.value <= most.value


def over_cap(merit: str, text: str, cap: str) -> str:
    """Say by how much a device exceeds a cap; '' where it does not, or nobody knows."""
    if is_within(merit, text, cap) is not False:
        return ""
    return sentence("comparisons.over_cap", merit=merit, text=text, cap=cap)


def front(points: Sequence[tuple[float, Amount | None]]) -> tuple[bool, ...]:
    """Return which points are Pareto-best: no other is better in one and as good.

    A point is a utilisation and a cost; one without a cost, or in another unit than the
    first one that has a cost, is not on the front.
    """
    unit = next((amount.unit for _, amount in points if amount is not None), "")
    known = [
        (amount.value, u, place)
        for place, (u, amount) in enumerate(points)
        if amount is not None and amount.unit == unit
    ]
    best = [False] * len(points)
    lowest = inf  # utilisation of all that cost less
    for _, same_cost in groupby(sorted(known), key=itemgetter(0)):
        rows = list(same_cost)
        least = rows[0][1]
        for _, u, place in rows:
            best[place] = u == least < lowest
        lowest = min(lowest, least)
    return tuple(best)
