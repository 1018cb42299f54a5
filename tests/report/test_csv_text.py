"""CSV documents: numbers as they are, texts that no spreadsheet computes."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from budget.report.document import csv_text


def cell(value):
    """Write one cell and read it back."""
    text = csv_text(("head",), [{"head": value, "other": "left out"}])
    (head, (found,)) = csv.reader(io.StringIO(text, newline=""))
    assert head == ["head"]
    return found


@pytest.mark.parametrize(
    "text", ["=1+1", "+cmd|' /C calc'!A0", "-n_x1/n_x2", "@SUM(A1)", "\t=1"]
)
def test_a_text_that_looks_like_a_formula_is_a_text(text):
    """An apostrophe stands before it."""
    assert cell(text) == f"'{text}"


@pytest.mark.parametrize(
    ("value", "written"),
    [
        ("-1.2262e-7", "-1.2262e-7"),
        ("+3", "+3"),
        (-0.1, "-0.1"),
        (np.float64(1e-300), "1e-300"),
        (-2, "-2"),
        (True, "true"),
        (None, ""),
        ("a=b", "a=b"),
        ("\r=1", "\\r=1"),  # else the csv of Python would end the row there
        ("", ""),
    ],
)
def test_numbers_and_other_texts_stay(value, written):
    """Numbers, printed ones too, keep every digit and sign."""
    assert cell(value) == written
