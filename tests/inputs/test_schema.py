"""JSON Schemas: they pass what `validate` passes and stop what an editor can see."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import jsonschema
import pytest
from places import put

from budget.errors import CallError
from budget.inputs import json_schema, validate
from budget.inputs.reader import read
from budget.inputs.schema import TABLES
from budget.inputs.tree import plain
from budget.resources import shipped

FILES = sorted(shipped("specs").rglob("*.yaml"))
KINDS = ("device", "procedure", "station", "mission", "requirement", "costs")


def values(node):
    """Return plain JSON values: lists where the reader has tuples."""
    if isinstance(node, dict):
        return {key: values(value) for key, value in node.items()}
    return [values(item) for item in node] if isinstance(node, tuple) else node


def document(text, tmp_path):
    """Return the values of a text as an editor has them."""
    path = put(Path(tmp_path) / "file.yaml", text)
    return values(plain(read(path, "file").root))


@cache
def judge(kind):
    """Return what validates files of a kind; that its schema is one is asked below."""
    return jsonschema.Draft202012Validator(json_schema(kind))


@pytest.mark.parametrize("kind", KINDS)
def test_schemas_are_sound(kind):
    """Each is a schema of draft 2020-12 with a title, and knows no null."""
    schema = json_schema(kind)
    assert schema["$schema"].endswith("2020-12/schema")
    assert kind in schema["title"]
    jsonschema.Draft202012Validator.check_schema(schema)
    assert "'null'" not in str(schema)
    assert all(name == one["title"] for name, one in schema["$defs"].items())


@pytest.mark.parametrize("kind", KINDS)
def test_mappings_that_are_told_apart_have_names_of_their_own(kind):
    """As many definitions as there are mappings: none takes the place of another."""
    tables = {}
    TABLES[kind]().described(tables)
    assert len({one["title"] for one in tables.values()}) == len(tables)
    assert len(json_schema(kind)["$defs"]) == len(tables) - 1


def test_shipped_files_pass_tool_and_schema():
    """Every shipped spec is valid by `validate` and by the schema of its kind."""
    faults = {
        path: list(judge(validate(path).kind).iter_errors(content))
        for path in FILES
        for content in [values(plain(read(path, path.name).root))]
    }
    assert faults
    assert {path: found for path, found in faults.items() if found} == {}


GOOD = {
    "axes": "name: x\ngyro: {errors: {bias_stability: {value: 1 deg/h, axes: "
    "{x: {value: 2 deg/h, meaning: max}}}}}\n",
    "variant": "name: x\nvariants: {A: {gyro: {errors: {bias_stability: "
    "{correlation_time: 1 s}}}}}\ngyro: {errors: {bias_stability: 1 \u00b0/h}}\n",
    "signs": "name: x\naccelerometer: {nominal: {bias: {x: -3 \u00b5g}}}\n",
}
BAD = {
    "unknown key": "name: x\ngyro: {errors: {bias_stabilty: 1 deg/h}}\n",
    "bare number": "name: x\ngyro: {errors: {bias_stability: 1}}\n",
    "no unit": "name: x\ngyro: {errors: {bias_stability: '1'}}\n",
    "negative": "name: x\ngyro: {errors: {bias_stability: -1 deg/h}}\n",
    "meaning": "name: x\ngyro: {errors: {bias_stability: {value: 1 deg/h, "
    "meaning: 4 sigma}}}\n",
    "no name": "gyro: {}\n",
    "number for a name": "name: 1\ngyro: {}\n",
    "decimal comma": "name: x\ngyro: {errors: {bias_stability: '1,5 deg/h'}}\n",
}


@pytest.mark.parametrize("case", GOOD)
def test_the_schema_passes_good_devices(case, tmp_path):
    """What the tool reads, an editor does not mark."""
    judge("device").validate(document(GOOD[case], tmp_path))


@pytest.mark.parametrize("case", BAD)
def test_the_schema_stops_bad_devices(case, tmp_path):
    """A mistake in one value is marked in the editor."""
    with pytest.raises(jsonschema.ValidationError):
        judge("device").validate(document(BAD[case], tmp_path))


def test_there_is_no_schema_of_an_unknown_kind():
    """The kinds there are stand in the message."""
    with pytest.raises(CallError, match=", ".join(KINDS)):
        json_schema("devices")
