"""Sentences that records keep: English wherever they go, sayable in any language."""

from __future__ import annotations

import pickle

import pytest

from budget.errors import OutputError
from budget.language import note, say, speaking
from budget.resources import templates_of
from budget.sentences import Sentence, sentence

PAGE = """{% macro few(trials, of) %}
{% trans trials=trials %}{{ trials }} scale factors{% endtrans %}
{% endmacro %}
"""


FEW = {"trials": 100, "outside": 5.0, "coverage": 0.95, "wanted": 2000}


@pytest.fixture
def own(tmp_path):
    """Return a folder with a page of sentences."""
    (tmp_path / "pages").mkdir()
    (tmp_path / "pages" / "own.md.j2").write_text(PAGE, encoding="utf-8")
    return tmp_path


def test_a_sentence_of_a_page_that_does_not_ship_is_refused(own):
    """The English of a record is of what ships, whatever folder goes before."""
    with templates_of(own), pytest.raises(OutputError, match="missing"):
        sentence("own.few", trials=3, of="scale_factor")


def test_a_value_is_no_markup():
    """What stands in a value comes out as it went in."""
    text = sentence("cautions.few_trials", **FEW | {"trials": "<3> & **4**"})

    assert text.startswith("<3> & **4** trials")


def test_a_sentence_is_english_and_can_be_said():
    """It survives another process, and is said where it is a part of another."""
    text = sentence("cautions.few_trials", **FEW)
    again = pickle.loads(pickle.dumps(text))  # noqa: S301 - our own

    assert isinstance(again, Sentence)
    assert text == again
    assert "100 trials leave 5 outside" in text
    with speaking("zh"):
        assert say(again) != text
        assert "2000" in say(again)
        assert say("{axis}: ", axis=again) == say("{axis}: ", axis=say(again))
        assert (
            sentence(
                "cautions.few_trials",
                trials=100,
                outside=5.0,
                coverage=0.95,
                wanted=2000,
            )
            == text
        )
    assert note("{x}!", x=again) == f"{text}!"
