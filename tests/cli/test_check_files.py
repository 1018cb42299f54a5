"""`budget validate` and `budget schema`: files in, words and schemas out."""

from __future__ import annotations

import re

from command_line import call
from places import put

from budget.inputs import json_schema
from budget.resources import shipped

REQUIREMENT = shipped("specs") / "requirements" / "navigation-grade.yaml"
SHIPPED = sorted(shipped("specs").glob("*/*.yaml"))
FOLDERS = {
    "devices": "device",
    "missions": "mission",
    "procedures": "procedure",
    "requirements": "requirement",
    "stations": "station",
}
KINDS = ("device", "procedure", "station", "mission", "requirement", "costs")
GYRO = "name: g\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"


def test_shipped_files_are_valid():
    """Every file that ships is valid, and of the kind of its folder."""
    run = call("validate", *SHIPPED)

    assert (run.code, run.err) == (0, "")
    said = set(run.out.splitlines())
    wanted = [f"{path}: {FOLDERS[path.parent.name]}, valid" for path in SHIPPED]
    assert [line for line in wanted if line not in said] == []


def test_assumptions_are_printed(tmp_path):
    """A default that was taken for a figure is said: a correlation time of 300 s."""
    file = put(
        tmp_path / "g.yaml", "name: g\ngyro: {errors: {bias_stability: 1 deg/h}}\n"
    )
    run = call("validate", file, code=0)

    assert re.search(r"assumed: .*bias_stability.*300 s", run.out)


def test_faults_are_printed_with_their_places(tmp_path):
    """All faults of a file are said at once, each as file:line:column: field: ..."""
    file = put(
        tmp_path / "bad.yaml",
        "name: bad\n"
        "gyro:\n"
        "  errors:\n"
        "    bias_stabilty: 0.04 deg/h\n"
        "    bias_repeatability: 0.05\n"
        "    angle_random_walk: 0.005 deg/h\n",
    )
    run = call("validate", file)

    assert (run.code, run.out) == (2, "")
    lines = [re.match(rf"{file}:(\d+):\d+: ", text) for text in run.err.splitlines()]
    assert [int(line[1]) for line in lines] == [4, 5, 6]
    assert "bias_stability" in run.err.splitlines()[0]


def test_good_files_are_named_beside_bad_ones(tmp_path):
    """One bad file among good ones is exit 2; the good ones are still said valid."""
    bad = put(tmp_path / "bad.yaml", "name: bad\nwheels: 4\n")
    run = call("validate", REQUIREMENT, bad, code=2)

    assert run.out == f"{REQUIREMENT}: requirement, valid\n"
    assert run.err.startswith(f"{bad}:")


def test_validate_needs_a_file():
    """`budget validate` without a file is a bad call."""
    assert call("validate").code == 2


def test_schema_is_a_json_schema():
    """`budget schema KIND` prints the JSON Schema and nothing else."""
    for kind in KINDS:
        run = call("schema", kind)
        assert (run.code, run.err) == (0, "")
        assert run.document == json_schema(kind)


def test_schema_of_an_unknown_kind():
    """A kind that there is not is exit 2 and says which there are."""
    run = call("schema", "sensor")

    assert (run.code, run.out) == (2, "")
    assert "requirement" in run.err
