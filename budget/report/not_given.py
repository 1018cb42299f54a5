"""Lines that a data sheet does not give, and what they could change, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.model.source import DEVICE, Offset
from budget.model.sources import source_of
from budget.report.tables import words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.names import Name

# What an offset of a parameter reaches; all other sources reach all.
REACH = {
    "bias": "biases",
    "scale_factor": "scale factors",
    "mounting_angle": "mounting angles",
}
EVERYTHING = "scale factors, mounting angles and biases"
NOTHING = "changes nothing under this reference, which shares its value"


def not_given_lines(names: Iterable[Name], reference: str) -> tuple[str, ...]:
    """Say which lines are absent and what they could change, by sensor and effect.

    A constant that the reference shares with the test changes nothing.
    """
    absent: dict[tuple[str, str], list[str]] = {}
    for name in names:
        source = source_of(name.owner, name.quantity)
        offset = source.effect.target if isinstance(source.effect, Offset) else ""
        shared = bool(offset) and (
            reference == "as_tested"
            or (reference == "next_turn_on" and source.stays == DEVICE)
        )
        reach = REACH.get(offset, EVERYTHING)
        effect = (name.owner, NOTHING if shared else f"could widen {reach}")
        absent.setdefault(effect, []).append(words(name.quantity))
    return tuple(
        f"{sensor} {', '.join(lines)}: {effect}"
        for (sensor, effect), lines in absent.items()
    )
