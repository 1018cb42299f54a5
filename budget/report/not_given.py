"""Lines that a data sheet does not give, and what they could change, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.tables import words

if TYPE_CHECKING:
    from collections.abc import Iterable

# What a line of a data sheet reaches, Zhao 2019, section 2; all others reach all.
REACH = {
    "bias_repeatability": "biases",
    "scale_factor_repeatability": "scale factors",
    "scale_factor_nonlinearity": "scale factors",
    "mounting_repeatability": "mounting angles",
}
EVERYTHING = "scale factors, mounting angles and biases"
NOTHING = "changes nothing under this reference, which shares its value"
CANCELS = {
    "as_tested": tuple(REACH),
    "next_turn_on": ("scale_factor_nonlinearity",),
}


def not_given_lines(names: Iterable[str], reference: str) -> tuple[str, ...]:
    """Say which lines are absent and what they could change, by sensor and effect.

    A constant that the reference shares with the test changes nothing.
    """
    absent: dict[tuple[str, str], list[str]] = {}
    for name in names:
        sensor, _, line = name.rpartition(".")
        reach = REACH.get(line, EVERYTHING)
        shared = line in CANCELS.get(reference, ())
        effect = (sensor, NOTHING if shared else f"could widen {reach}")
        absent.setdefault(effect, []).append(words(line))
    return tuple(
        f"{sensor} {', '.join(lines)}: {effect}"
        for (sensor, effect), lines in absent.items()
    )
