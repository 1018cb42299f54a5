"""Inputs that broke the reader once: each is read or refused for ever after."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz.oracle import judge_input

FOUND = sorted((Path(__file__).parent / "found").iterdir())


@pytest.mark.parametrize("case", FOUND, ids=lambda path: path.name)
def test_what_broke_the_reader_breaks_it_no_more(case, tmp_path):
    """A case of the corpus gives a sound record, or issues at places in the file."""
    judge_input(tmp_path / "file.yaml", case.read_bytes())


def test_the_corpus_is_there():
    """The folder with the cases is in the checkout, so that the test above has some."""
    assert FOUND
