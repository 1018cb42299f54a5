"""Open readings in words: what the others would change, and under which it meets."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from budget.names import key_title, words
from budget.report.tables import print_given, print_utilisation, source_title
from budget.ties import settle

if TYPE_CHECKING:
    from budget.results import Reading, ReadingEffect, ReadingVerdicts

MOST = 3  # readings that are named
DIGITS = 3
LEAST = 0.005  # relative change of u that is worth a number [1]


def effect_line(effect: ReadingEffect) -> str:
    """Say what one other reading alone does to u, where it does most."""
    ratio = print_given(settle(effect.ratio), digits=DIGITS)
    said = f"{source_title(effect.line)} read as {words(effect.reading)}"
    said += f" in place of {words(effect.taken)}"
    if effect.ratio == inf:
        return f"{said}: it alone reaches the {key_title(effect.output)}"
    if abs(settle(effect.ratio) - 1.0) < LEAST:
        return f"{said}: no u changes by 0.5 %"
    return f"{said}: u of the {key_title(effect.output)} is {ratio} times as large"


def verdict_line(found: ReadingVerdicts) -> str:
    """Say under which readings a sensor meets, and how far they are apart."""
    used = sorted(settle(one.utilisation) for one in found.found)
    ends = list(dict.fromkeys(print_utilisation(end) for end in (used[0], used[-1])))
    apart = f"uses {' to '.join(ends)} of a limit"
    number = len(found.found)
    which = {
        "all": f"under all {number} readings",
        "none": f"under none of {number} readings",
        "some": f"under {len(found.passing)} of {number} readings",
    }[found.passes]
    text = f"meets {which} ({apart})"
    if found.passes == "some":
        named = [_combination(one, found) for one in found.passing[:MOST]]
        more = len(found.passing) - len(named)
        text += f", with {'; or '.join(named)}"
        text += f"; and {more} more" if more else ""
    if number < found.total:
        text += (
            f". {found.total} combinations there are, {number} were computed: each "
            "reading alone, and the smallest of every line"
        )
    return text


def _combination(one: Reading, found: ReadingVerdicts) -> str:
    """Name what a combination reads otherwise than is taken; that one whole."""
    taken = dict(found.found[0].words)
    other = [(line, word) for line, word in one.words if taken[line] != word]
    said = other or one.words  # what is taken itself
    return ", ".join(f"{words(line.quantity)} as {words(word)}" for line, word in said)
