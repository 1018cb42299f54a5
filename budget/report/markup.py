"""Text for a page: numbers set as numbers, foreign text made harmless."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from budget.resources import shipped

if TYPE_CHECKING:
    from collections.abc import Iterable

    from jinja2 import Environment
    from markupsafe import Markup

DIGIT, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"  # as wide as those
MINUS_SIGN = "\N{MINUS SIGN}"
MINUS = re.compile(r"(?<![\w.)\]])-(?=\d)")  # a sign, not a hyphen
POWER = re.compile(r"(?<=\d)e([+-]?)0*(\d+)\b")  # of ten, as Python prints it
PLAIN = re.compile(r"([<>]?[-+]?\d+(\.\d+)?)( [^\d]*)?")


def page_environment() -> Environment:
    """Return the jinja2 environment of every page: escaping, numbers kept with units.

    Missing values are errors, plain text is escaped and its numbers bound to their
    units; the filters `number` and `longest_tail` set columns.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(shipped("templates")),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: bind(value) if type(value) is str else value,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": lambda text, tail=0: markup(number_markup(text, tail=tail)),
        "longest_tail": longest_tail,
    }
    return environment


def markup(html: str) -> Markup:
    """Mark HTML as made here: its makers escape what they are given."""
    from markupsafe import Markup

    return Markup(html)  # noqa: S704 - see above


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
    own = _tail(text)
    if own is None:
        return signs_markup(text)
    missing = tail - own
    filler = DIGIT * missing if own else (POINT + DIGIT * missing)[:missing]
    return signs_markup(
        PLAIN.sub(lambda parts: parts[1] + filler + (parts[3] or ""), text)
    )


def signs_markup(text: str) -> str:
    """Escape a text; minus signs of numbers in it are true, powers of ten raised."""
    told = MINUS.sub(MINUS_SIGN, escape(text))
    return POWER.sub(
        lambda power: (
            "&#8239;&times;&#8239;10<sup>"
            f"{power[1].replace('-', MINUS_SIGN).replace('+', '')}{power[2]}</sup>"
        ),
        told,
    )


def longest_tail(texts: Iterable[str]) -> int:
    """Return the most characters from a decimal point on, powers of ten left out."""
    return max((_tail(text) or 0 for text in texts), default=0)


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


def _tail(text: str) -> int | None:
    """Return the length from the decimal point on; None where no point is in line.

    That is so for words, powers of ten and intervals; a unit may follow the number.
    """
    plain = PLAIN.fullmatch(text)
    return None if plain is None else len(plain[2] or "")
