"""Open readings in words: what the others would change, and under which it meets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.pages import line

if TYPE_CHECKING:
    from budget.results import ReadingEffect, ReadingVerdicts


def effect_line(effect: ReadingEffect) -> str:
    """Say what one other reading alone does to u, where it does most."""
    return line("readings", "effect", one=effect)


def verdict_line(found: ReadingVerdicts) -> str:
    """Say under which readings a sensor meets, and how far they are apart."""
    return line("readings", "verdict", found=found)
