"""Hints at what is meant where a file says something else: slips, words of makers."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING

from budget.earth import ROTATION_RATE
from budget.inputs.makers import bare, lines_by_word, reading_of
from budget.inputs.tree import LONGEST_SHOWN
from budget.model.sources import every_source, from_outside, twin_of
from budget.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.tree import Node

_SLIP = 0.85  # likeness from which a word of a file is a slip of another

_EARTH_RATE = (
    f"; the earth rate is that of WGS 84, {ROTATION_RATE / DEG_PER_HOUR:.4f} deg/h, a "
    "turn in a sidereal day and not in 24 h; what is not known of it is "
    "station.earth_rate"
)

# Of a limit on a horizontal error, by what others call its radius.
_RADIUS = {
    "radius": "did you mean 'horizontal'?",
    "circle": "did you mean 'horizontal'?",
    "cep": "expected 'horizontal' with 'probability: 50 %' beside it",
    "cep50": "expected 'horizontal' with 'probability: 50 %' beside it",
    "cep95": "expected 'horizontal' with 'probability: 95 %' beside it",
    "r95": "expected 'horizontal' with 'probability: 95 %' beside it",
}


@lru_cache(maxsize=1024)
def nearest(word: str, allowed: tuple[str, ...]) -> str:
    """Return a hint at the allowed word that is nearest, or ''."""
    by_lower = {name.lower(): name for name in allowed if name != word}
    near = get_close_matches(word.lower(), by_lower, n=1)
    return f"; did you mean {by_lower[near[0]]!r}?" if near else ""


def slip(word: str, allowed: tuple[str, ...]) -> str:
    """Return a hint at the word of a file that another is a slip of, or ''.

    Near is not enough here: '4 sigma' is no slip of '1 sigma' nor 'lognormal' of
    'normal', and a line of one kind of sensor has its own twin on the other.
    """
    if word in from_outside().faults:
        return f"; {from_outside().faults[word]}"
    if word == "earth_rate":
        return _EARTH_RATE
    if "horizontal" in allowed and word.lower() in _RADIUS:
        return f"; {_RADIUS[word.lower()]}"
    if any(line.name == word for line in every_source()):
        twin = twin_of(word)
        return f"; did you mean {twin!r}?" if twin in allowed else ""
    digits = re.findall("[0-9]", word)
    same = {
        name.lower(): name for name in allowed if re.findall("[0-9]", name) == digits
    }
    lines = [line for line in lines_by_word().get(bare(word), ()) if line in allowed]
    if lines:
        either = " or ".join(map(repr, lines))
        return f"; did you mean {either}?{see(lines)}"
    near = get_close_matches(word.lower(), same, n=1, cutoff=_SLIP)
    return f"; did you mean {same[near[0]]!r}?" if near else ""


def see(steps: Sequence[str | int]) -> str:
    """Return where to read how makers print the line of those steps, or ''."""
    found = next(filter(None, (reading_of(str(step)) for step in steps)), None)
    return f"; how makers print it: {found.link}" if found else ""


def mended(node: Node, *, is_truth: bool = False) -> str:
    """Return a hint at the word that YAML 1.2 reads as what YAML 1.1 did."""
    word = node.written.lower()
    if is_truth:
        is_old = word in {"yes", "no", "on", "off"}
        return f"; did you mean {str(word in {'yes', 'on'}).lower()}?" if is_old else ""
    number = re.fullmatch(r"([+-]?)0*([0-9][0-9_]*)", node.written)
    return f"; did you mean {number[1]}{number[2].replace('_', '')}?" if number else ""


def bracketed(node: Node, *, of_mappings: bool) -> str:
    """Return how the list is written that a file has one item of, or of what."""
    if of_mappings:
        return ", each item a mapping of keys"
    one, key = node.written, re.split(r"\.", node.path)[-1]
    # What is long, or no text that a terminal shows, is not repeated.
    is_short = one.isprintable() and 0 < len(one) <= LONGEST_SHOWN
    if is_short and not isinstance(node.value, bool):
        return f", such as '{key}: [{one}]'"
    return ", such as [x, y] of two items"
