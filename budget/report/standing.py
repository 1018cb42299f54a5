"""Assumptions and missing specifications behind an answer, in words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from budget.inputs.records import ANGLES, AXES
from budget.model.sources import STATION
from budget.names import MISSION, Name
from budget.report.tables import SMALL_SHARE
from budget.report.wording import not_given_gathered, parted
from budget.ties import from_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.results import Budget

SAID = "in words alone"  # an assumption without a key
# What a mission is taken to begin with: it makes sources small that are not.
BEFORE = (Name("alignment", owner=MISSION), Name("altitude", owner=MISSION))
NAMES = 4  # of a sensor that are not given, on page one


def counting(own: Sequence[Budget]) -> tuple[str, ...]:
    """Return the assumptions that an answer stands on, those that move it most first.

    How a mission begins, an ideal station, sources by their largest share; the others
    stand under Inputs.
    """
    weights: dict[str, float] = {
        **dict.fromkeys(BEFORE, 2.0),
        STATION: 1.5,
        SAID: SMALL_SHARE,
    }
    for one in own:
        for part in (part for row in one.outputs for part in row.contributions):
            for axis in ("", *AXES, *ANGLES) if part.share >= SMALL_SHARE else ():
                name = Name(part.source.quantity, owner=part.source.owner, axis=axis)
                weights[name] = max(part.share, weights.get(name, 0.0))
    texts = list(dict.fromkeys(text for one in own for text in one.assumptions))
    found = [weights.get(keyed(text)[0] or SAID, 0.0) for text in texts]
    return tuple(texts[k] for k in from_largest(found) if found[k] > 0.0)


def missing(own: Sequence[Budget], most: int = 0) -> tuple[str, ...]:
    """Say what is not given, and what it could change on one budget or the other."""
    reach = {
        name: tuple(output for one in own for output in one.could_widen.get(name, ()))
        for name in dict.fromkeys(name for one in own for name in one.could_widen)
    }
    is_later = any(one.settings.reference == "next_turn_on" for one in own)
    return not_given_gathered(reach, is_later=is_later, most=most)


def keyed(text: str) -> tuple[str, str]:
    """Return the key that an assumption begins with, '' without one, and the rest."""
    key, assumed = parted(text)
    is_key = re.fullmatch(r"[a-z_.]+", key) is not None
    return (key, assumed) if is_key and assumed else ("", text)
