"""How values are written on pages: what keeps them from Markdown, and the filters."""

from __future__ import annotations

import string
from math import degrees, isnan
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from budget.language import Note, key_title, say, words
from budget.names import time_text
from budget.report.tables import (
    DASH,
    DIGITS,
    full_title,
    join_outputs,
    print_count,
    print_coverage,
    print_given,
    print_share,
    print_stop,
    print_utilisation,
    round_uncertainty,
    source_title,
)
from budget.report.wording import VERDICTS, capital, listed, standing_lines
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping


# Marks of what a value is, in characters of private use; none of them is Markdown.
EXACT, OF, OBJECT, BENEATH, BAR, END = map(chr, range(0xE000, 0xE006))
# Characters that Markdown may read, in a value: somewhere else while it is read.
_PLANE = 0xF0000
_MARKS = f"{EXACT}{OF}{OBJECT}{BENEATH}{BAR}{END}"
_BREAKS = " \t\n\v\f\r\x1c\x1d\x1e\x85\u2028\u2029"
_HIDDEN = {ord(one): _PLANE + ord(one) for one in string.punctuation + _BREAKS + _MARKS}
_SHOWN = {there: here for here, there in _HIDDEN.items()}


class Marked(Markup):
    """Text of a page as it stands, marks in it; any other text is a value.

    Markup is what Jinja2 leaves as it is; nothing here is HTML.
    """

    __slots__ = ()


def marked(value: object) -> Marked:
    """Return a value as text that Markdown leaves alone; a note is said."""
    if isinstance(value, Markup):
        return Marked(value)
    text = say(value) if isinstance(value, Note) else str(value)
    return Marked(text.translate(_HIDDEN))


def exact(text: str, value: float | None) -> Marked:
    """Return a number in a text, or in a cell, with its exact value."""
    if value is None or isnan(value):
        return marked(text)
    size = value if isinstance(value, int) else float(value)
    return Marked(f"{EXACT}{size!r}{OF}{marked(text)}{END}")


def number(value: float, digits: int = 3) -> Marked:
    """Print a number that is given, to so many digits, with its exact value."""
    return exact(print_given(value, digits=digits), value)


def strong(text: object, is_strong: object = True) -> Marked:  # noqa: FBT002 - a filter
    """Write text in bold, where it is to be."""
    return Marked(f"**{marked(text)}**") if is_strong else marked(text)


def beneath(text: object) -> Marked:
    """Return the second, small line of a cell."""
    return Marked(f"{BENEATH}{marked(text)}{END}")


def bar(text: object, share: float) -> Marked:
    """Return a cell with a bar behind it that fills a share of it."""
    return Marked(f"{marked(text)}{BAR}{share!r}{END}")


def share_bar(share: float) -> Marked:
    """Return a cell with a share of a variance in per cent, and a bar behind it."""
    text = print_share(share).removesuffix(" %")
    return bar(exact(text, share), float(share))


def shown(text: str) -> str:
    """Return a value as it was."""
    return text.translate(_SHOWN)


def _commas(texts: Iterable[str], mark: str = ", ") -> str:
    """Put texts in a row, with a mark of the language between them."""
    return say(mark).join(texts)


def _each(records: Iterable[Any], write: Callable[[Any], Any]) -> list[Any]:
    """Return what a macro writes of each record, without the blanks around it."""
    written = map(write, records)
    return [one.strip() if isinstance(one, str) else one for one in written]


def _semicolons(lines: Markup) -> Markup:
    """Put what stands on lines of a template in a row."""
    return Marked(say("; ")).join(filter(None, map(Markup.strip, lines.splitlines())))


FILTERS: Mapping[str, Callable[..., object]] = {
    "number": number,
    "exact": exact,
    "beneath": beneath,
    "bar": bar,
    "strong": strong,
    "capital": capital,
    "commas": _commas,
    "listed": lambda texts: Marked(listed([marked(one) for one in texts])),
    "said": say,
    "words": words,
    "key": key_title,
    "line": source_title,
    "outputs": join_outputs,
    "verdict": lambda word: say(VERDICTS[word]),
    "standing": standing_lines,
    "given": lambda value, digits=3: print_given(value, digits=digits),
    "coverage": print_coverage,
    "used": print_utilisation,
    "settle": settle,
    "ratio": lambda value: f"{print_given(value, digits=DIGITS)}:1",
    "of_ratio": lambda value: DASH if value is None else number(value),
    "in_degrees": degrees,
    "stop": print_stop,
    "per_cent": lambda part: print_utilisation(part).removesuffix(" %"),
    "thousands": print_count,
    "rounded": lambda one: "" if one is None else exact(one.text, one.exact),
    "owned": full_title,
    "time": time_text,
    "two": round_uncertainty,
    "share": print_share,
    "share_bar": share_bar,
    "semicolons": _semicolons,
    "each": _each,
}
