"""Lines that a data sheet does not give, and what they could change, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.tables import words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.names import Name

PLURALS = {
    "scale_factor": "scale factors",
    "mounting_angle": "mounting angles",
    "bias": "biases",
}
NOTHING = "changes nothing under this reference"


def not_given_lines(reach: Mapping[Name, tuple[Name, ...]]) -> tuple[str, ...]:
    """Say which lines are absent and what they could change, by sensor and effect.

    Parameters
    ----------
    reach : mapping of Name to tuple of Name
        The outputs that each absent line would reach, from
        budget.studies.lower_bounds.could_widen.
    """
    absent: dict[tuple[str, str], list[str]] = {}
    for name, outputs in reach.items():
        reached = {output.quantity for output in outputs}
        *most, last = [PLURALS[key] for key in PLURALS if key in reached] or [NOTHING]
        effect = f"{', '.join(most)} and {last}" if most else last
        said = effect if not reached else f"could widen {effect}"
        absent.setdefault((name.owner, said), []).append(words(name.quantity))
    return tuple(
        f"{sensor} {', '.join(lines)}: {effect}"
        for (sensor, effect), lines in absent.items()
    )
