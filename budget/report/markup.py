"""Text for a page: numbers set as numbers, foreign text made harmless."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

DIGIT, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"  # as wide as those


def number_markup(text: str, *, tail: int = 0) -> str:
    """Set a printed number for a page: true minus signs, powers of ten raised.

    Parameters
    ----------
    text : str
        As it comes from `tables`.
    tail : int
        Characters from the decimal point on to fill up to, so that the points of a
        column that is set flush right are in line.
    """
    mantissa, e, exponent = escape(text).replace("-", "\N{MINUS SIGN}").partition("e")
    if e:
        return f"{mantissa}&#8239;&times;&#8239;10<sup>{exponent}</sup>"
    missing = tail - longest_tail([text])
    if missing > 0 and "." not in text:
        return mantissa + POINT + DIGIT * (missing - 1)
    return mantissa + DIGIT * missing


def longest_tail(texts: Iterable[str]) -> int:
    """Return the most characters from a decimal point on, powers of ten left out."""
    plain = [text for text in texts if "e" not in text]
    return max((len(t) - len(t.partition(".")[0]) for t in plain), default=0)


def bind(text: str) -> str:
    """Keep each number and what follows it, its unit mostly, on one line."""
    return re.sub(r"(?<=\d) (?=\S)", "\N{NO-BREAK SPACE}", text)


def script_safe(document: str) -> str:
    """Escape JSON so that nothing in it can end the script element around it."""
    for character in "&<>":
        document = document.replace(character, f"\\u{ord(character):04x}")
    return document


def css_string(text: str) -> str:
    """Quote a text for CSS; all but plain letters and digits as code points."""
    return '"' + re.sub(r"[^A-Za-z0-9]", lambda c: f"\\{ord(c[0]):06x}", text) + '"'
