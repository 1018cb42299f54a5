"""Lines of text as pages and sheets set them: minus signs, powers, links."""

from __future__ import annotations

import pytest

from budget.report.inline import Link, Raised, cut

BOUND, MINUS = "\N{NO-BREAK SPACE}", "\N{MINUS SIGN}"
TEN = "\u202f\N{MULTIPLICATION SIGN}\u202f10"
DOI = "10.11823/j.issn.1674-5795.2019.03.06"


def shown(text):
    """Write the pieces of a text in a line: exponents and links in brackets."""
    marks = {
        str: str,
        Raised: lambda one: f"<{one.text}>",
        Link: lambda one: f"[{one.text}]({one.address})",
    }
    return "".join(marks[type(one)](one) for one in cut(text))


@pytest.mark.parametrize(
    ("text", "set_as"),
    [
        ("once a day (1.157e-05 Hz)", f"once a day (1.157{TEN}<{MINUS}5>{BOUND}Hz)"),
        ("closed form -1.0219e-5; on", f"closed form {MINUS}1.0219{TEN}<{MINUS}5>; on"),
        ("3.89e3, 1e+05", f"3.89{TEN}<3>, 1{TEN}<5>"),
        ("9.8 m/s^2 and 2^-53", f"9.8{BOUND}m/s<2> and 2<{MINUS}53>"),
        ("from -0.5 to -40 degC", f"from {MINUS}0.5{BOUND}to {MINUS}40{BOUND}degC"),
    ],
)
def test_minus_signs_and_powers_are_those_of_print(text, set_as):
    """A minus is a true one, an exponent raised, a unit on the line of its number."""
    assert shown(text) == set_as


@pytest.mark.parametrize(
    "text",
    [
        "HG4930-2 of",
        "zhao-2019.yaml, a-1, -v, -3b",
        "2026-01-31",
        "pages 34-40",
        "--set gyro.bias=-5",
        "9f86e08, v1e5, 12e4ab, 12345e67",
        "'-0.5 deg/h' is",
        "x' = F x + G e, dT^T",
    ],
)
def test_names_dates_hashes_and_what_is_typed_stay(text):
    """None of them has a number with a sign or a power."""
    assert shown(text).replace(BOUND, " ") == text


@pytest.mark.parametrize(
    ("text", "set_as"),
    [
        (f"2019, doi {DOI}, its", f"2019, [doi {DOI}](https://doi.org/{DOI}), its"),
        (f"(doi:{DOI}).", f"([doi:{DOI}](https://doi.org/{DOI}))."),
        ("see https://a.b/c-1?d=2.", "see [https://a.b/c-1?d=2](https://a.b/c-1?d=2)."),
        ("javascript:alert(1) file:///x", "javascript:alert(1) file:///x"),
        ("https://", "https://"),
    ],
)
def test_addresses_are_links(text, set_as):
    """Those of the web and of documents are, without what ends the sentence."""
    assert shown(text) == set_as
