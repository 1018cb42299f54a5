"""Words, numbers and formulas of a PDF, cut into the parts that a page sets apart."""

from __future__ import annotations

import re
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from budget.report.blocks import Run
from budget.report.formulas import (
    Figure,
    Fraction,
    Letter,
    Line,
    Mean,
    Sign,
    Sub,
    Sup,
)
from budget.report.tables import align_decimals

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Words
    from budget.report.formulas import Math

    Part = str | dict[str, Any]  # of a line of text, as JSON

MINUS, BOUND, NARROW = "\N{MINUS SIGN}", "\N{NO-BREAK SPACE}", "\u202f"
DIGIT, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"  # as wide as those
BREAK = "\N{ZERO WIDTH SPACE}"  # a line may end here

# As `tables` prints: '<0.1', '-2.3e-9', '230 000', '79 %'.
NUMBER = re.compile(
    r"(?P<head>[<>]?)(?P<digits>[+-]?\d[\d ]*(?:\.\d+)?)(?:e(?P<power>-?\d+))?"
    r"(?P<tail>| [^\d\s].*)"
)
# In a sentence: no part of a name, a date or a range.
NEGATIVE = re.compile(r"(?<![\w.+/-])-(?=\d+(?:\.\d+)?(?:e-?\d+)?(?![\d.]*\w))")
RAISED = re.compile(rf"(?<![\w.+/-])({MINUS}?\d+(?:\.\d+)?)e(-?\d+)(?!\.?\w)")
LONG_WORD = 24  # characters; words of a report are shorter
UNBROKEN = 12  # characters of a long one between places where a line may end


def cut_words(words: Words) -> list[Part]:
    """Turn a line of text into what JSON holds: texts, numbers, formulas."""
    parts: list[Part] = []
    for word in words:
        if isinstance(word, str):
            parts += _cut_text(word)
        elif isinstance(word, Run):
            cut = list(_cut_text(word.text))
            parts += [{"is": "strong", "parts": cut}] if word.strong else cut
        else:
            parts.append(cut_math(word))
    return parts


def cut_math(math: Math) -> dict[str, Any]:
    """Turn a formula into what JSON holds, with words for those who hear it."""
    return {"is": "math", "alt": say(math), "tree": _tree(math)}


def cut_numbers(texts: Sequence[str]) -> list[Part]:
    """Turn a column of printed numbers into parts, padded to bring points in line.

    What is no number, a dash or a word, stays as it is; powers of ten have no part in
    the line of points.
    """
    found = [NUMBER.fullmatch(text) for text in texts]
    plain = [m["digits"] for m in found if m and m["power"] is None]
    pads = iter(align_decimals(plain, digit=DIGIT, point=POINT))
    parts: list[Part] = []
    for text, match in zip(texts, found, strict=True):
        if match is None:
            parts.append(break_long(text))
            continue
        digits, power = match["digits"], match["power"]
        pad = next(pads)[len(digits) :] if power is None else ""
        parts.append(
            {
                "is": "number",
                "head": match["head"],
                "digits": _print_digits(digits),
                "power": "" if power is None else _print_digits(power),
                "tail": match["tail"].replace(" ", BOUND, 1),
                "pad": pad,
            }
        )
    return parts


def say(math: Math) -> str:  # noqa: PLR0911 - one for each kind of part
    """Write a formula on one line: 'K_x = n_x2/(4 π m)'."""
    match math:
        case Letter(text=text) | Figure(text=text):
            return text
        case Sign(text=text, prefix=prefix):
            return text if prefix or text in "()[]" else f" {text} "
        case Sub(base=base, index=index):
            return f"{say(base)}_{say(index)}"
        case Sup(base=base, exponent=exponent):
            return f"{say(base)}^{say(exponent)}"
        case Mean(base=base):
            return f"mean of {say(base)}"
        case Fraction(top=top, bottom=bottom):
            return f"{_say_part(top)}/{_say_part(bottom)}"
        case Line(parts=parts):
            said = [say(part) for part in parts]
            gaps = [
                " " if text[-1:].isalnum() and after[:1].isalnum() else ""
                for text, after in zip(said, [*said[1:], ""], strict=True)
            ]
            return "".join(t + gap for t, gap in zip(said, gaps, strict=True)).strip()


def shorten(text: str, length: int) -> str:
    """Cut a text that is too long, and show that it was."""
    return text if len(text) <= length else f"{text[: length - 1].rstrip()}…"


def break_long(text: str) -> str:
    """Let a line end within words that no column could hold."""
    return re.sub(rf"\S{{{LONG_WORD},}}", lambda word: _break_word(word[0]), text)


def _break_word(word: str) -> str:
    """Let a line end after signs, and where there are none for too long."""
    pieces = re.split(r"(?<=[/_,;.:=-])(?=[^\s/_,;.:=-])", word)
    return BREAK.join(
        piece[start : start + UNBROKEN]
        for piece in pieces
        for start in range(0, len(piece), UNBROKEN)
    )


def _cut_text(text: str) -> Iterator[Part]:
    """Yield a text with the numbers in it set as numbers, bound to their units."""
    # Pieces between powers of ten: text, mantissa, exponent, text, ...
    pieces = RAISED.split(NEGATIVE.sub(MINUS, text))
    for place in range(0, len(pieces), 3):
        words = re.sub(r"(?<=\d) (?=\S)", BOUND, pieces[place])
        if place:
            words = re.sub(r"^ (?=\S)", BOUND, words)
        if words:
            yield break_long(words)
        if place + 1 < len(pieces):
            yield {
                "is": "number",
                "head": "",
                "digits": pieces[place + 1],
                "power": _print_digits(pieces[place + 2]),
                "tail": "",
                "pad": "",
            }


def _print_digits(digits: str) -> str:
    """Write a true minus sign, and narrow blanks between groups of digits."""
    return digits.replace("-", MINUS).replace(" ", NARROW)


def _say_part(math: Math) -> str:
    """Write the top or bottom of a quotient, in brackets where it is longer."""
    return f"({say(math)})" if isinstance(math, Line) else say(math)


def _tree(math: Math) -> dict[str, Any]:
    """Turn a formula into nested records: `is` is the kind, the rest its fields."""
    plain: dict[str, Any] = {"is": type(math).__name__.lower()}
    for entry in fields(math):
        value = getattr(math, entry.name)
        if isinstance(value, tuple):
            plain[entry.name] = [_tree(part) for part in value]
        else:
            plain[entry.name] = value if isinstance(value, str | bool) else _tree(value)
    return plain
