"""Typography of a line of text: minus signs, powers of ten, links.

Texts come with hyphens for minus signs and with powers of ten as Python prints them,
as a terminal and programs have them; names, dates, ranges and hashes stay as they are.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

MINUS, BOUND, NARROW = "\N{MINUS SIGN}", "\N{NO-BREAK SPACE}", "\u202f"
TEN = f"{NARROW}\N{MULTIPLICATION SIGN}{NARROW}10"
# No part of a name, a date, a range, a setting or a quotation.
NEGATIVE = re.compile(r"(?<![\w.+/=^\"'-])-(?=\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\d.]*\w))")
MARKED = re.compile(
    # A power of ten; one digit before the point, as numbers are printed.
    rf"(?<![\w.+/=-])(?P<digits>{MINUS}?\d(?:\.\d+)?)e(?P<power>[+-]?\d{{1,3}})(?!\.?\w)"
    # Of a unit, or of another number.
    r"|(?<=[\w)])\^(?P<raised>[+-]?\d+)(?!\.?\w)"
    r"|(?P<address>https?://[^\s<>\"']+|doi:? ?(?P<doi>10\.\d{4,9}/[^\s<>\"',;]+))"
)
AFTER = ".,;:!?)]"  # of the sentence, not of an address at its end


@dataclass(frozen=True, kw_only=True)
class Raised:
    """An exponent."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Link:
    """Words that lead to an address."""

    text: str
    address: str


def with_minus(text: str) -> str:
    """Write the minus signs of the numbers in a text as true ones."""
    return NEGATIVE.sub(MINUS, text)


def bind(text: str) -> str:
    """Keep each number and what follows it, its unit mostly, on one line."""
    return re.sub(r"(?<=\d) (?=\S)", BOUND, text)


def exponent(digits: str) -> str:
    """Write an exponent of a program, '-05', as it is read."""
    return str(int(digits)).replace("-", MINUS)


def cut(text: str) -> Iterator[str | Raised | Link]:
    """Yield the pieces of a text, its numbers bound to their units."""
    text = with_minus(text)
    at, words = 0, ""
    for found in MARKED.finditer(text):
        words += text[at : found.start()]
        at = found.end()
        mark: Raised | Link
        if found["address"]:
            said = found["address"].rstrip(AFTER)
            at = found.start() + len(said)
            doi = (found["doi"] or "").rstrip(AFTER)
            mark = Link(text=said, address=f"https://doi.org/{doi}" if doi else said)
        else:
            words += f"{found['digits']}{TEN}" if found["power"] else ""
            mark = Raised(text=exponent(found["power"] or found["raised"]))
        if words:
            yield bind(words)
        yield mark
        # A unit after a power stays with it.
        is_bound = found["power"] and re.match(r" \S", text[at:])
        words = BOUND if is_bound else ""
        at += len(words)
    if words or at < len(text):
        yield bind(words + text[at:])
