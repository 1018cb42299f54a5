"""Open readings in words: what the others would change, and under which it meets."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from budget.language import key_title, say, words
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
    said = say(
        "{line} read as {reading}",
        line=source_title(effect.line),
        reading=words(effect.reading),
    )
    said += say(" in place of {taken}", taken=words(effect.taken))
    if effect.ratio == inf:
        return say(
            "{said}: it alone reaches the {output}",
            said=said,
            output=key_title(effect.output),
        )
    if abs(settle(effect.ratio) - 1.0) < LEAST:
        return say("{said}: no u changes by 0.5 %", said=said)
    return say(
        "{said}: u of the {output} is {ratio} times as large",
        said=said,
        output=key_title(effect.output),
        ratio=ratio,
    )


def verdict_line(found: ReadingVerdicts) -> str:
    """Say under which readings a sensor meets, and how far they are apart."""
    used = sorted(settle(one.utilisation) for one in found.found)
    ends = list(dict.fromkeys(print_utilisation(end) for end in (used[0], used[-1])))
    apart = say("uses {ends} of a limit", ends=say(" to ").join(ends))
    number = len(found.found)
    which = {
        "all": say("under all {number} readings", number=number),
        "none": say("under none of {number} readings", number=number),
        "some": say(
            "under {passing} of {number} readings",
            passing=len(found.passing),
            number=number,
        ),
    }[found.passes]
    text = say("meets {which} ({apart})", which=which, apart=apart)
    if found.passes == "some":
        named = [_combination(one, found) for one in found.passing[:MOST]]
        more = len(found.passing) - len(named)
        text += say(", with {named}", named=say("; or ").join(named))
        text += say("; and {more} more", more=more) if more else ""
    if number < found.total:
        text += say(
            ". {total} combinations there are, {number} were computed: "
            "each reading alone, and the smallest of every line",
            total=found.total,
            number=number,
        )
    return text


def _combination(one: Reading, found: ReadingVerdicts) -> str:
    """Name what a combination reads otherwise than is taken; that one whole."""
    taken = dict(found.found[0].words)
    other = [(line, word) for line, word in one.words if taken[line] != word]
    said = other or one.words  # what is taken itself
    return say(", ").join(
        say("{quantity} as {word}", quantity=words(line.quantity), word=words(word))
        for line, word in said
    )
