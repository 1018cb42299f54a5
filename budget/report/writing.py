"""Values in templates: kept from Markdown, and written by filters."""

from __future__ import annotations

import string
from math import degrees, isnan
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from budget.inputs.records import ANGLES, AXES
from budget.language import Note, key_title, listed, say, term, words
from budget.names import by_group, time_text
from budget.report.tables import (
    DASH,
    DIGITS,
    as_limited,
    full_title,
    join_outputs,
    largest_error,
    length,
    of_the_variance,
    print_chance,
    print_count,
    print_coverage,
    print_decimals,
    print_degrees_of_freedom,
    print_divisor,
    print_given,
    print_most,
    print_probability,
    print_share,
    print_stop,
    print_utilisation,
    round_uncertainty,
    source_title,
    used_part,
)
from budget.ties import foremost, settle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from budget.arrays import Array
    from budget.report.tables import Number

VERDICTS = {
    "meets": term("MEETS"),
    "meets_if": term("MEETS IF"),
    "fails": term("FAILS"),
    "undecided": term("UNDECIDED"),
    "undecidable": term("UNDECIDABLE"),
    "predicted": term("PREDICTED"),
}

# Marks of what a value is, in characters of private use; none of them is Markdown.
EXACT, OF, OBJECT, BENEATH, BAR, END = map(chr, range(0xE000, 0xE006))
# Characters that Markdown may read, in a value: somewhere else while it is read.
_PLANE = 0xF0000
_MARKS = f"{EXACT}{OF}{OBJECT}{BENEATH}{BAR}{END}"
_BREAKS = " \t\n\v\f\r\x1c\x1d\x1e\x85\u2028\u2029"
# Marks of Chinese sentences: beside one of them `**` would not end what is bold.
_WIDE = "\u201c\u201d\u3001\u3002\u300a\u300b\uff01\uff08\uff09\uff0c\uff1a\uff1b\uff1f"
_SET_ASIDE = string.punctuation + _BREAKS + _MARKS + _WIDE
_HIDDEN = {ord(one): _PLANE + ord(one) for one in _SET_ASIDE}
_SHOWN = {there: here for here, there in _HIDDEN.items()}
WIDE = {ord(one): _PLANE + ord(one) for one in _WIDE}


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
    return bar(exact(print_share(share).removesuffix(" %"), share), float(share))


def print_part(part: float) -> str:
    """Print a part of a squared limit in per cent, 0 plainly."""
    if part < 0.5e-3:  # noqa: PLR2004
        return "0" if part <= 1e-12 else "<0.1"  # noqa: PLR2004 - rounding
    return f"{100.0 * part:.{1 if part < 0.1 else 0}f}"  # noqa: PLR2004


def shown(text: str) -> str:
    """Return a value as it was."""
    return text.translate(_SHOWN)


def capital(text: str) -> str:
    """Begin a text with a capital; the rest stays as it is."""
    return text[:1].upper() + text[1:]


def _rounded(number: Number | None, unit: str = "") -> str:
    """Return a rounded number with its exact value, and its unit; '' of none."""
    if number is None:
        return ""
    return exact(f"{number.text} {unit}".rstrip(), number.exact)


def print_by_axis(values: Array) -> str:
    """Write one number where the axes agree, else each with its axis."""
    printed = [print_given(float(value)) for value in values]
    if len(set(printed)) == 1:
        return printed[0]
    names = AXES if len(printed) == len(AXES) else ANGLES
    return _commas(f"{name} {text}" for name, text in zip(names, printed, strict=True))


def _commas(texts: Iterable[str], mark: str = ", ") -> str:
    """Put texts in a row, with a mark of the language between them."""
    return say(mark).join(texts)


def _each(records: Iterable[Any], write: Callable[[Any], Any]) -> list[Any]:
    """Return what a macro writes of each record, without the blanks around it."""
    return [one.strip() if isinstance(one, str) else one for one in map(write, records)]


def _lines(text: Markup) -> list[Markup]:
    """Return what stands on the lines of a template, without blank ones."""
    return [line for one in text.splitlines() if (line := one.strip())]


def _semicolons(lines: Markup | Iterable[Markup]) -> Markup:
    """Put what stands on lines of a template in a row."""
    texts = _lines(lines) if isinstance(lines, Markup) else lines
    return Marked(say("; ")).join(texts)


FILTERS: Mapping[str, Callable[..., object]] = {
    "number": number,
    "exact": exact,
    "beneath": beneath,
    "bar": bar,
    "strong": strong,
    "capital": capital,
    "lower_first": lambda text: text[:1].lower() + text[1:],
    "commas": _commas,
    "listed": lambda texts: Marked(listed([marked(one) for one in texts])),
    "said": say,
    "words": words,
    "key": key_title,
    "line": source_title,
    "outputs": join_outputs,
    "verdict": lambda word: say(VERDICTS[word]),
    "by_axis": print_by_axis,
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
    "rounded": _rounded,
    "decimals": print_decimals,
    "chance": print_chance,
    "probability": print_probability,
    "at_most": print_most,
    "as_limited": as_limited,
    "largest_error": largest_error,
    "used_part": used_part,
    "of_the_variance": lambda titles, shares: of_the_variance(
        [*zip(titles, shares, strict=True)]
    ),
    "by_group": by_group,
    "foremost": lambda parts, number: parts[
        : foremost([one.share for one in parts], number)
    ],
    "owned": full_title,
    "time": time_text,
    "two": round_uncertainty,
    "metres": length,
    "divisor": print_divisor,
    "degrees_of_freedom": print_degrees_of_freedom,
    "share": print_share,
    "of_square": print_part,
    "share_bar": share_bar,
    "lines": _lines,
    "semicolons": _semicolons,
    "each": _each,
}
