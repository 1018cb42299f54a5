"""JSON Schema of result documents: it names every key that a command writes."""

from __future__ import annotations

import jsonschema
import pytest
from command_line import SCHEMA, call, checked
from places import TESTS

EDGE = ("--requirement", "catalogue-edge")
PREDICT = ("--missing", "predict")

# What no other test asks for as JSON: `document` of each is held against the schema.
CALLS = {
    "everything": (
        *("analyze", "--requirement", "navigation-grade", "--matrices"),
        *("--sobol", "--samples", "16", "--set", "gyro.bias_stability=0.02 deg/h"),
        *("--outputs", "gyro.bias,gyro.rotation", "--trials", "1000"),
    ),
    "predicted": ("analyze", "ltm210#S10", *EDGE, *PREDICT, "--no-validate"),
    "compare": (
        *("compare", "zhao-2019", "hg4930#A", "ltm210#S10", "--pairs", *EDGE),
        *("--method", "gum", *PREDICT),
    ),
    "characterise": ("characterise", str(TESTS / "data" / "static.csv")),
    "paper": ("paper",),
}


@pytest.mark.parametrize("case", CALLS)
def test_the_schema_names_every_key(case, tmp_path, monkeypatch):
    """A document passes, here as wherever a test reads `document`."""
    monkeypatch.chdir(tmp_path)
    assert call(*CALLS[case], "--json", "-").document


def test_the_schema_is_sound():
    """It is one of draft 2020-12, and each object in it is closed or a mapping."""
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    for entry in SCHEMA["$defs"].values():
        assert entry["additionalProperties"] is False
        assert set(entry["required"]) <= set(entry["properties"])
        assert entry["description"]


@pytest.mark.slow
def test_a_key_that_is_not_in_it_is_refused():
    """Control: a new key, one that is gone and a text for a number are seen."""
    document = call("analyze", "--no-validate", "--json", "-").document
    output = document["outputs"][0]
    for wrong in (
        {**document, "new": 1},
        {key: value for key, value in document.items() if key != "covariance"},
        {**document, "outputs": [{**output, "mean": "0"}]},
        {**document, "outputs": [{**output, "news": 0.0}]},
    ):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, SCHEMA)
        with pytest.raises(AssertionError):
            checked(wrong)


def test_one_row_of_many_that_is_wrong_is_found():
    """Control: rows that are alike are looked at once, one that is not is not alike."""
    document = call("analyze", "--no-validate", "--json", "-").document
    rows = document["outputs"]
    for place in (0, 9, len(rows) - 1):
        for wrong in ({"news": 0.0}, {"mean": "0"}, {"coverage_factor": [2.0]}):
            row = rows[place] | wrong
            changed = [*rows[:place], row, *rows[place + 1 :]]
            with pytest.raises(AssertionError):
                checked({**document, "outputs": changed})
        less = {key: text for key, text in rows[place].items() if key != "mean"}
        with pytest.raises(AssertionError):
            checked({**document, "outputs": [*rows[:place], less, *rows[place + 1 :]]})
    with pytest.raises(AssertionError):
        checked({**document, "covariance": [*document["covariance"], ["0"]]})
