"""JSON and CSV documents."""

from __future__ import annotations

import csv
import io
import json

import numpy as np
import pytest
from report_examples import GYRO, make_budget, make_outputs

from budget.report.document import csv_text, to_csv, to_json
from budget.results import COLUMNS


def test_json_round_trip_is_exact():
    """Reading the document gives every number back to the last bit."""
    budget = make_budget()

    read = json.loads(to_json(budget))

    expected = budget.to_dict()
    assert read["outputs"] == expected["outputs"]
    assert read["covariance"] == expected["covariance"]
    assert list(read) == list(expected)


def test_json_ends_with_one_newline():
    """The document is a text file: its last line is ended, once."""
    text = to_json(make_budget())

    assert text.endswith("}\n")


def test_json_keeps_the_order_of_the_record():
    """Keys stand in the order of the contract, not of the alphabet."""
    keys = list(json.loads(to_json(make_budget())))

    assert keys[:4] == ["schema", "command", "title", "inputs"]


def test_json_keeps_letters_readable():
    """A name in Chinese is not turned into escapes."""
    assert "分立标定" in to_json(make_budget(title="分立标定"))


def test_json_refuses_what_is_no_number():
    """NaN never gets into a document."""
    outputs = make_outputs("gyro", GYRO, mean=float("nan"))

    with pytest.raises(ValueError, match="no number that JSON has"):
        to_json(make_budget(outputs=outputs))


def test_documents_are_the_same_twice():
    """The same budget gives the same bytes."""
    assert to_json(make_budget()) == to_json(make_budget())
    assert to_csv(make_budget()) == to_csv(make_budget())


def test_csv_has_the_columns_of_the_contract():
    """The head line is what other people's scripts read."""
    assert to_csv(make_budget()).partition("\n")[0] == (
        "sensor,parameter,axis,unit,source,standard_uncertainty,share,"
        "mean,interval_low,interval_high,interval_by,lower_bound"
    )


def test_csv_has_line_feeds_only():
    """No carriage return stands in the text, and the last line is ended."""
    text = to_csv(make_budget())

    assert "\r" not in text
    assert text.endswith("\n")


def test_csv_rows_are_the_rows_of_the_budget():
    """Reading the text gives every row back, None as the empty cell."""
    budget = make_budget()
    numbers = set(COLUMNS[5:-2])

    read = [
        {
            key: (float(text) if text else None) if key in numbers else text
            for key, text in row.items()
        }
        | {
            "interval_by": row["interval_by"] or None,
            "lower_bound": row["lower_bound"] == "true",
        }
        for row in csv.DictReader(io.StringIO(to_csv(budget)))
    ]

    assert read == list(budget.rows())


# ---- cells of a CSV document ---------------------------------------------------------


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
