"""Assumptions, conditions and missing specifications behind an answer, in words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from budget.inputs.records import ANGLES, AXES
from budget.language import Note, say
from budget.model.sources import STATION, source_of
from budget.names import MISSION, Name
from budget.report.pages import blocks, line, lines
from budget.report.tables import SMALL_SHARE
from budget.ties import from_largest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.report.blocks import Block
    from budget.results import Assessment, Budget, JudgedOutput, Verdict
    from budget.settings import Settings

# Parameters, and what a mission asks for, in the order in which they are named.
NAMED = ("scale_factor", "mounting_angle", "bias", "position", "velocity", "attitude")


def standing_lines(standing: Verdict) -> tuple[str, ...]:
    """Say what a verdict stands on: its conditions, or what decides; cautions.

    The same sentences in every command and on every page.
    """
    return lines("standing", "stands", standing=standing)


def deciding_lines(standing: Verdict) -> tuple[str, ...]:
    """Say what a verdict depends on."""
    return lines("standing", "deciding", standing=standing)


def standing_blocks(standing: Verdict) -> tuple[Block, ...]:
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


def outcome_words(assessment: Assessment, row: JudgedOutput) -> str:
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
