"""Text for a page: numbers are set for reading, foreign text is made harmless."""

from __future__ import annotations

import json

import pytest

from budget.report.page import (
    bind,
    css_string,
    longest_tail,
    number_markup,
    script_safe,
    signs_markup,
)

FIGURE, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("-0.11", "\N{MINUS SIGN}0.11"),
        ("2.4e-9", "2.4&#8239;&times;&#8239;10<sup>\N{MINUS SIGN}9</sup>"),
        ("1e+05", "1&#8239;&times;&#8239;10<sup>5</sup>"),
        ("<0.1", "&lt;0.1"),
        ("none", "none"),
        ("none <b>", "none &lt;b&gt;"),
    ],
)
def test_numbers_are_set_for_reading(text, markup):
    """Minus signs are true ones, exponents are raised, the rest is escaped."""
    assert number_markup(text) == markup


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("-0.1 to -0.2", "\N{MINUS SIGN}0.1 to \N{MINUS SIGN}0.2"),
        ("HG-4930", "HG-4930"),
        ("2019-11-21", "2019-11-21"),
        ("0.41 deg/h", "0.41 deg/h"),
    ],
)
def test_a_hyphen_is_no_minus(text, markup):
    """Only what stands before a number becomes its sign."""
    assert signs_markup(text) == markup


@pytest.mark.parametrize(
    ("text", "tail", "markup"),
    [
        ("50", 3, f"50{POINT}{FIGURE}{FIGURE}"),
        ("0.69", 4, f"0.69{FIGURE}"),
        ("0.077", 4, "0.077"),
        ("97 %", 2, f"97{POINT}{FIGURE} %"),
        ("none", 4, "none"),
        ("10-20", 4, "10-20"),
    ],
)
def test_points_of_a_column_are_in_line(text, tail, markup):
    """Shorter tails are filled up with spaces as wide as digits and point."""
    assert number_markup(text, tail=tail) == markup


def test_longest_tail_is_that_of_plain_numbers():
    """Powers of ten, words and intervals do not widen a column."""
    assert longest_tail(["1.25", "3", "2.4567e-9", "e.g. 1.2345", "97.5 %"]) == 3
    assert longest_tail([]) == 0


def test_css_string_cannot_be_left():
    """Quotes, brackets and line ends become code points."""
    assert css_string('a"}\n') == r'"a\000022\00007d\00000a"'


def test_number_stays_with_its_unit():
    """The space between a number and its unit does not break."""
    assert bind("after 300 s at 5 deg/h or so") == (
        "after 300\N{NO-BREAK SPACE}s at 5\N{NO-BREAK SPACE}deg/h or so"
    )


def test_script_safe_json_is_the_same_json():
    """What could end a script element is written in another way, and read the same."""
    document = {"title": "</script><!-- & \u2028"}
    safe = script_safe(json.dumps(document))

    assert not set("<>&") & set(safe)
    assert json.loads(safe) == document
