"""Every word of the shipped commands is as it was; and what the guard cannot see."""

from __future__ import annotations

import json
from importlib.metadata import version

import pytest
from outputs import (
    DIGESTS,
    DRAWINGS,
    Page,
    calls,
    digests,
    document,
    outputs,
    plain,
    shorter,
)

from budget.version import __version__

KEPT = json.loads(DIGESTS.read_text(encoding="utf-8"))
SEE = "python tests/guard/outputs.py"


def moved(name, found, *, drawn):
    """Return the media of a call whose words are not those that are kept."""
    kept = KEPT["calls"].get(name, {})
    return [
        medium
        for medium in sorted({*kept, *found})
        if kept.get(medium) != found.get(medium)
        and (drawn or not medium.endswith(DRAWINGS))
        and not (medium.endswith(".pdf") and medium not in found)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("name", calls())
def test_every_word_is_as_it_was(name, tmp_path):
    """What a call writes has the digests that are kept, medium by medium."""
    found = digests(outputs(name, tmp_path.resolve() / "call"))
    others = moved(name, found, drawn=KEPT["matplotlib"] == version("matplotlib"))

    assert not others, (
        f"the call {name!r} writes other words: {', '.join(others)}. To see them: "
        f"{SEE} diff REVISION {name} (the last that was right). Where it is meant: "
        f"{SEE} accept {name}"
    )


def test_digests_are_of_the_calls_that_there_are():
    """None is kept of a call that is gone; all have a terminal's words."""
    assert list(KEPT["calls"]) == list(calls())
    assert all("terminal" in media for media in KEPT["calls"].values())


@pytest.mark.slow
def test_a_word_that_moves_is_seen(tmp_path):
    """The control: another value, and what is left out alone, in every medium."""
    found = outputs("analyze-brief", tmp_path.resolve() / "call")
    assert moved("analyze-brief", digests(found), drawn=True) == []
    for medium, text in found.items():
        other = digests(found | {medium: text.replace("bias", "bia5", 1)})
        assert moved("analyze-brief", other, drawn=True) == [medium]
    assert moved("analyze-brief", digests(found | {"more.csv": ""}), drawn=True) == [
        "more.csv"
    ]


@pytest.mark.parametrize(
    ("number", "kept"),
    [
        ("50.00000000000001", "50.0"),
        ("-1.2345678901", "-1.23457"),
        ("0.0016999999999999999", "0.0017"),
        ("4.880604623562055e-13", "4.8806e-13"),
        ("0.001230", "0.001230"),
        ("34.2394", "34.2394"),
    ],
)
def test_numbers_lose_the_digits_that_processors_do_not_agree_in(number, kept):
    """Six digits are compared; what is printed with fewer stays as printed."""
    assert shorter(number) == kept


def test_what_rounding_makes_of_zero_is_zero_in_documents():
    """A mean, and a covariance of nothing else beside its spreads; no more."""
    assert document('{"mean": -1.195683e-21, "u": 1e-9}') == document(
        '{"mean": 0.0, "u": 1e-9}'
    )
    matrix = '{"covariance": [[9e4, %s], [0.5, 4.0]]}'
    same, small, large = (document(matrix % one) for one in ("0.0", "5e-7", "7e-7"))
    assert same == small != large


def test_what_machines_differ_in_is_taken_out(tmp_path):
    """Folder and version go; names, counts and sums of files stay."""
    sha = "c9713f47786345e887ec85a495408ccd651a8c6839cb5729d3c230701eac717f"
    text = f"{tmp_path}/imu.yaml budget {__version__} 1767225600 {sha} g1.123456789"

    assert plain(text, tmp_path) == (
        f"FOLDER/imu.yaml budget 0 1767225600 {sha} g1.123456789"
    )


PAGE = """<p class="a">U of <b>gyro</b> bias</p><script>let a = 1;</script>
<script type="application/json">{"a":1}</script>
<svg aria-label="a bias"><path d="M 0 1"/><g><text x="1">0.1</text></g></svg>end"""


@pytest.mark.parametrize(
    ("word", "other", "is_text", "is_drawing"),
    [
        ("U of", "u of", True, False),
        ('class="a"', 'class="b"', True, False),
        ("<b>gyro</b>", "gyro", True, False),
        ("a = 1", "a = 2", True, False),
        ('"a":1', '"a":2', True, False),
        ('"a":1', '"a": 1', False, False),
        ("a bias", "no bias", True, True),
        ("0.1", "0.2", True, True),
        ("M 0 1", "M 0 2", False, True),
        ("<g>", "<g><path/>", True, True),
        ("</p>", "</p>\n\n ", False, False),
        ("end", "ends", True, False),
    ],
)
def test_pages_are_told_apart_by_words_and_structure(word, other, is_text, is_drawing):
    """Words, tags, attributes, scripts and documents count; geometry counts apart."""
    one, two = Page(PAGE), Page(PAGE.replace(word, other, 1))

    assert (one.text != two.text) == is_text
    assert (one.drawings != two.drawings) == is_drawing
