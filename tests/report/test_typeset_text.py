"""Numbers, words and formulas, cut into the parts that a page sets apart."""

from __future__ import annotations

import pytest

from budget.report.blocks import Run
from budget.report.formulas import Math
from budget.report.typeset import (
    BREAK,
    break_long,
    cut_numbers,
    cut_words,
    shorten,
)

MINUS, BOUND, FIGURE, POINT = "\u2212", "\u00a0", "\u2007", "\u2008"


def flat(part):
    """Write a part as it reads."""
    if isinstance(part, str):
        return part
    if part["is"] == "number":
        power = f"*10^{part['power']}" if part["power"] else ""
        return part["head"] + part["digits"] + power + part["tail"] + part["pad"]
    return f"<{''.join(map(flat, part['parts']))}>"


@pytest.mark.parametrize(
    ("texts", "printed"),
    [
        (["0.050", "12"], ["0.050", f"12{POINT}{FIGURE * 3}"]),
        (["-1.5", "0.25"], [f"{MINUS}1.5{FIGURE}", "0.25"]),
        (["<0.1", "79"], ["<0.1", f"79{POINT}{FIGURE}"]),
        (
            ["2.3e-9", "1.25", "7"],
            [f"2.3*10^{MINUS}9", "1.25", f"7{POINT}{FIGURE * 2}"],
        ),
        (["79 %", "0.3 %"], [f"79{BOUND}%{POINT}{FIGURE}", f"0.3{BOUND}%"]),
        (["230 000", "1"], ["230\u202f000", "1"]),
        (["-", "holds", "", "2x"], ["-", "holds", "", "2x"]),
    ],
)
def test_numbers_of_a_column_are_padded_to_their_points(texts, printed):
    """Points are in line; powers, words and dashes have no part in it."""
    assert [flat(part) for part in cut_numbers(texts)] == printed


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("u 0.050 deg/h", f"u 0.050{BOUND}deg/h"),
        (
            "from -0.5 to -2.3e-9 ppm",
            f"from {MINUS}0.5{BOUND}to {MINUS}2.3*10^{MINUS}9{BOUND}ppm",
        ),
        ("HG4930-2 of 2026-01-31", f"HG4930-2{BOUND}of 2026-01-31"),
        ("zhao-2019.yaml a-1, -v, -3b", "zhao-2019.yaml a-1, -v, -3b"),
        ("1e5 x", f"1*10^5{BOUND}x"),
        ("9f86e08, v1e5, 12e4ab", "9f86e08, v1e5, 12e4ab"),
    ],
)
def test_numbers_in_a_sentence_are_set_as_numbers(text, printed):
    """A minus, a power of ten and a unit are; names, dates and hashes stay."""
    assert "".join(map(flat, cut_words((text,)))) == printed


def test_bold_runs_are_marked():
    """A strong run is one; a run that is not is plain text."""
    parts = cut_words((Run(text="a", strong=True), Run(text="b", exact=1.0), "c"))
    assert "".join(map(flat, parts)) == "<a>bc"


def test_formulas_have_a_source_and_words():
    """The template sets the one, who hears the page hears the other."""
    (part,) = cut_words((Math(source="macron(N)"),))
    assert part == {"is": "math", "alt": "mean of N", "source": "macron(N)"}


def test_long_words_may_be_broken_and_short_ones_not():
    """A path is broken after its signs, a run of letters anywhere, words nowhere."""
    assert break_long("accelerometer repeatability") == "accelerometer repeatability"
    assert break_long("a-very/long_path.of/several-parts") == BREAK.join(
        ["a-", "very/", "long_", "path.", "of/", "several-", "parts"]
    )
    pieces = break_long("x" * 100).split(BREAK)
    assert max(map(len, pieces)) == 12
    assert "".join(pieces) == "x" * 100


def test_what_is_cut_shows_it():
    """A shortened text ends in an ellipsis; a short one is whole."""
    assert shorten("abc", 3) == "abc"
    assert shorten("abc defg", 5) == "abc\u2026"
