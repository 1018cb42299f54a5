"""Rows of files: one row is read, refused, described and told in the docs alike."""

from __future__ import annotations

import runpy
from dataclasses import replace

import jsonschema
import pytest
from places import DOCS

from budget.errors import SpecError
from budget.inputs import schema
from budget.inputs.fields import (
    SPAN,
    TEXT,
    KeyRow,
    Sign,
    check,
    items,
    measured,
    number,
    one_of,
    table,
)
from budget.inputs.reader import parse
from budget.inputs.requirement import RequirementFile
from budget.inputs.schema import json_schema
from budget.inputs.station import StationFile

NEW = KeyRow(measured("degC", Sign.ANY), "of the cellar below", usual="12 degC")
KEY = "cellar_temperature"


def read(text, kind):
    """Return what a text says as a mapping of that kind."""
    return check(parse(text.encode(), "f.yaml", base_name="f.yaml"), kind)


@pytest.mark.parametrize(
    ("record", "kind", "text"),
    [
        (StationFile, "station", "station: {}\n"),
        (RequirementFile, "requirement", "name: x\nlimits: {gyro: {bias: 1 deg/h}}\n"),
    ],
)
def test_a_new_key_of_a_file_is_one_row(monkeypatch, record, kind, text):
    """Read with its unit, refused at its place, in the schema and in the docs."""
    longer = table(record, {KEY: NEW})
    monkeypatch.setitem(schema.TABLES, kind, lambda: longer)

    given = read(f"{text}{KEY}: -3 degC\n", longer)
    absent = read(text, longer)
    assert (given.cellar_temperature.value, KEY in given.given) == (-3.0, True)
    assert (absent.cellar_temperature.printed, KEY in absent.given) == (
        "12 degC",
        False,
    )
    line = text.count("\n") + 1
    with pytest.raises(SpecError, match=rf"f\.yaml:{line}:21: {KEY}: .*temperature"):
        read(f"{text}{KEY}: 3 s\n", longer)
    with pytest.raises(SpecError, match=f"did you mean '{KEY}'"):
        read(f"{text}{KEY[:-1]}: 3 degC\n", longer)
    with pytest.raises(SpecError, match="unknown key"):
        read(f"{text}{KEY}: 3 degC\n", table(record))
    own = json_schema(kind)["properties"][KEY]
    assert (own["description"], own["default"]) == (NEW.says, NEW.usual)
    jsonschema.validate("9 degC", own)
    rows = runpy.run_path(str(DOCS / "make_tables.py"))["files"]()
    assert f"| `{KEY}` | in degC | `12 degC` | of the cellar below |" in rows


KINDS = table(
    rows={
        "word": KeyRow(one_of("left", "right", meant={"port": "left"})),
        "count": KeyRow(number(1, 9)),
        "part": KeyRow(number(0.0, 1.0, is_whole=False)),
        "text": KeyRow(TEXT),
        "span": KeyRow(items(SPAN, SPAN)),
        "list": KeyRow(items(TEXT, most=2, alone=True)),
    }
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("word: LEFT", "left"),
        ("word: port", "left"),
        ("count: 9", 9),
        ("part: 1", 1.0),
        ("list: a", ("a",)),
        ("list: [a, b]", ("a", "b")),
    ],
)
def test_kinds_read_what_they_may_be(text, value):
    """Words in any capitals, whole numbers, one item in the place of a list."""
    found = read(text, KINDS)
    assert vars(found)[text.partition(":")[0]] == value


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("word: up", "1:7: word: found 'up', expected 'left' or 'right'$"),
        ("count: 10", "count: found 10, expected 9 or less$"),
        ("count: 1.5", "count: found 1.5, expected a whole number"),
        ("count: true", "count: found true, expected a whole number"),
        ("part: 1e999", "part: found 1e999, expected a finite number$"),
        ("text: ' '", "text: is blank"),
        ("text: 3", "text: found 3, expected text; put it in quotes"),
        ("span: [1 s]", "span: item 2 is missing"),
        ("span: [1 s, 2 s, 3 s]", "has 3 items, expected 2 at the most"),
        ("list: [a, b, c]", "has 3 items, expected 2 at the most"),
        ("list: [a, 3]", r"1:11: list\[1\]: found 3, expected text"),
        ("[1]", "expected a mapping of keys"),
    ],
)
def test_kinds_refuse_what_they_may_not_be(text, said):
    """At the place, with what was found and what is allowed."""
    with pytest.raises(SpecError, match=said):
        read(text, KINDS)


def test_what_is_absent_takes_what_stands_for_it():
    """Of a row with another default the others are as they were."""
    row = StationFile.rows["name"]
    assert row.default is None
    assert replace(row, usual="here").default == "here"
