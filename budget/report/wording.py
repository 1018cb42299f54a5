"""Words that stand in several sections, and small ways to make blocks of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.language import Note, say
from budget.model.sources import source_of
from budget.names import Name
from budget.report.pages import blocks, line, lines
from budget.report.writing import VERDICTS, capital

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.report.blocks import Block
    from budget.results import Assessment, Doubt, OutputAssessment, Standing
    from budget.settings import Settings

__all__ = [
    "VERDICTS",
    "capital",
    "deciding_lines",
    "doubt_sentence",
    "error_reference",
    "mode_remark",
    "mode_sentence",
    "not_given_gathered",
    "not_given_lines",
    "outcome_words",
    "parted",
    "standing_blocks",
    "standing_lines",
]

# Parameters, and what a mission asks for, in the order in which they are named.
NAMED = ("scale_factor", "mounting_angle", "bias", "position", "velocity", "attitude")


def standing_lines(standing: Standing) -> tuple[str, ...]:
    """Say what a verdict stands on: its conditions, or what decides; cautions.

    The same sentences in every command and on every page.
    """
    return lines("standing", "stands", standing=standing)


def deciding_lines(standing: Standing) -> tuple[str, ...]:
    """Say what a verdict depends on."""
    return lines("standing", "deciding", standing=standing)


def standing_blocks(standing: Standing) -> tuple[Block, ...]:
    """Return what a verdict stands on, below its headline."""
    return blocks("standing", "below", standing=standing)


def error_reference(settings: Settings) -> str:
    """Say what errors are counted from."""
    return line("words", "reference", settings=settings)


def mode_remark(settings: Settings) -> str:
    """Say beside a headline what stands for missing lines; '' where nothing does."""
    return line("words", "mode_remark", settings=settings)


def mode_sentence(settings: Settings) -> str:
    """Say what stands for expected lines that are not given; '' where nothing does."""
    return line("words", "mode", settings=settings)


def doubt_sentence(doubt: Doubt, *, of: str) -> str:
    """Say how probable it is to meet, and which missing line to ask for first."""
    return line("words", "doubt", doubt=doubt, of=of)


def outcome_words(assessment: Assessment, row: OutputAssessment) -> str:
    """Say on which side of its limit an output is, if anybody knows."""
    return line("words", "outcome", assessment=assessment, row=row)


def not_given_lines(
    reach: Mapping[Name, tuple[Name, ...]], *, is_later: bool = False
) -> tuple[str, ...]:
    """Say which lines are absent and what they could change, by sensor and effect.

    `reach` has the outputs that each absent line would reach, from
    budget.missing.expected.could_widen; `is_later`: at a later turn-on.
    """
    absent: dict[tuple[str, tuple[str, ...], str], list[str]] = {}
    for name, outputs in reach.items():
        reached = {output.quantity for output in outputs}
        own = source_of(name.owner, name.quantity).use
        use = own if is_later and not reached else ""
        effect = (name.owner, tuple(one for one in NAMED if one in reached), use)
        absent.setdefault(effect, []).append(name.quantity)
    return lines("words", "not_given", absent=absent)


def not_given_gathered(
    reach: Mapping[Name, tuple[Name, ...]], *, is_later: bool = False, most: int = 0
) -> tuple[str, ...]:
    """Say as not_given_lines, a line a sensor, the first names of `most` and more."""
    widening: dict[str, list[str]] = {}
    by_use: dict[str, str] = {}
    for name, outputs in reach.items():
        if outputs:
            widening.setdefault(name.owner, []).append(name.quantity)
        elif is_later and (use := source_of(name.owner, name.quantity).use):
            by_use[name.quantity] = use
    view = {"widening": widening, "by_use": by_use, "most": most}
    return lines("words", "not_given_gathered", **view)


def parted(text: str) -> tuple[str, str]:
    """Part an assumption into its key and what is assumed: 'height', 'not given, ...'.

    The key stays as files have it.
    """
    key, _, assumed = text.partition(": ")
    if not isinstance(text, Note):
        return key, assumed
    _, _, said = say(text).partition(say(": "))
    whole = text.parts.get("key")
    return whole if isinstance(whole, Name) and whole == key else key, said or assumed
