"""A setting is declared once: everything else reads it from there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from inspect import signature

import pytest
from command_line import call, surroundings
from places import EXAMPLE, PACKAGE, ROOT

import budget
from budget.cli import app
from budget.cli.options import OutputFiles
from budget.errors import CallError
from budget.settings import CLI, Asked, Engine, Inputs, every_row, rows

NEW = """    depth: int = setting(
        1,
        "How deep the water is.",
        "analyze report check",
        least=1,
        most=9,
    )
    strategy: str | None = setting(
"""
# What becomes of it: option, parameter, check, document, table, stored reference.
SCRIPT = """
import json, sys
import budget
from budget.cli import main

def run(*words):
    sys.argv = ["budget", *words]
    try:
        main()
    except SystemExit as end:
        return end.code

found = budget.analyze("zhao-2019", validate=False, depth=7)
try:
    budget.analyze("zhao-2019", depth=0)
except budget.CallError as error:
    refused = str(error)
report = run("report", "zhao-2019", "--no-validate", "--depth", "7", "-o", "a.html")
saved = run("check", "--save", "a.json", "zhao-2019", "--depth", "7")
checked = run("check", "a.json")
print(json.dumps({
    "doc": budget.analyze.__doc__, "refused": refused,
    "document": found.to_dict()["settings"], "codes": [report, saved, checked],
}))
run("analyze", "--help")
"""


@pytest.mark.slow
def test_a_new_setting_is_one_field(tmp_path):
    """Written into one file it is an option, a parameter, checked, said and stored."""
    for folder in (PACKAGE, EXAMPLE, ROOT / "templates", ROOT / "specs"):
        place = tmp_path / folder.name
        shutil.copytree(folder, place, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    file = tmp_path / PACKAGE.name / "settings.py"
    text = file.read_text(encoding="utf-8")
    head, mark, rest = text.partition("    strategy: str | None = setting(\n")
    assert mark
    file.write_text(head + NEW + rest, encoding="utf-8")
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=tmp_path,
        env=surroundings() | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        check=False,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    lines = run.stdout.splitlines()
    found = json.loads(next(line for line in lines if line.startswith('{"doc"')))
    assert "--depth <int range>" in run.stdout
    assert "depth : int\n    How deep the water is." in found["doc"]
    assert found["refused"] == "depth is 0, allowed: whole numbers, 1 to 9"
    assert found["document"]["depth"] == 7
    assert {*found["codes"]} <= {None, 0}
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "depth 7" in " ".join(re.sub("<[^>]+>", " ", page).split())
    stored = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert stored["settings"]["depth"] == 7


@pytest.mark.parametrize("given", [{"seed": 0.0}, {"digits": 1.0}, {"workers": 1.0}])
def test_a_number_of_another_kind_is_refused_where_it_is_the_usual_one(given):
    """It says what is allowed, as of any other."""
    with pytest.raises(CallError, match="whole numbers"):
        budget.analyze("zhao-2019", validate=False, **given)


@pytest.mark.parametrize(
    ("given", "allowed"),
    [
        ({"digits": 3}, "1 to 2"),
        ({"samples": 2**21, "validate": False}, "2 to 1048576"),
        ({"trials": 0}, "2 to "),
        ({"workers": 0}, "1 or more"),
    ],
)
def test_a_number_beyond_what_the_command_takes_is_refused(given, allowed):
    """The library says the same range as the option."""
    with pytest.raises(CallError, match=f"allowed: whole numbers, {allowed}"):
        budget.analyze("zhao-2019", **given)


LIBRARY = {
    "analyze": "analyze",
    "compare": "compare",
    "allocate": "allocate",
    "qualify": "station",
    "export": "export",
    "sweep": "sweep",
}


@pytest.mark.parametrize("name", LIBRARY)
def test_functions_show_every_setting(name):
    """In their signature, with its usual value, and in their docstring."""
    function = getattr(budget, name)
    shown = signature(function).parameters
    for kind in (Asked, Inputs):
        for key, row in rows(kind, LIBRARY[name], "library").items():
            usual = shown[key].default
            assert usual == (shown[key].empty if row.needed else row.default)
            assert f"\n{key} : " in function.__doc__
    with pytest.raises(TypeError, match="did you mean"):
        function(**{next(iter(rows(Inputs, LIBRARY[name], "library"))) + "s": 1})


# Where an option means nothing though its like is there, and why.
WITHOUT = {
    "--calibration": {
        "decide": "it finds out which calibration",
        "export": "the residual is of a test, --procedure",
    },
    "--mission": {
        "station": "it serves the calibration",
        "export": "figures are of the unit",
    },
    "--station": {},
    "--missing": {
        "allocate": "limits are shared out among the specifications given",
        "station": "the station is judged, not what is missing of a device",
    },
    "--language": {"export": "a file for programs, its comments in English"},
    "--set": {},
    "--templates": {},
    "-o": {
        "analyze": "`report` is its page",
    },
    "--age": {},
    "--environment": {},
}
COMPUTING = (
    *("analyze", "mission", "report", "compare", "decide", "allocate"),
    *("station", "export", "check", "diff"),
)


@pytest.mark.parametrize("option", WITHOUT)
def test_what_computes_has_the_same_options(option):
    """Every command that computes budgets of devices, but for those with a reason."""
    has = {name for name in COMPUTING if f" {option}" in call(name, "--help").out}
    assert {*COMPUTING} - has == WITHOUT[option].keys()


def test_every_option_of_a_row_is_in_the_help():
    """Of each command those of the rows that mean something in it."""
    names = {one.name or one.callback.__name__ for one in app.registered_commands}
    jobs = set().union(
        *(
            row.jobs
            for kind in (Asked, Engine, Inputs, OutputFiles)
            for row in every_row(kind).values()
        )
    )
    assert jobs - names == {"sweep"}
    for name in sorted(jobs & names):
        shown = call(name, "--help").out
        for kind in (Asked, Inputs, OutputFiles):
            assert all(row.flag in shown for row in rows(kind, name, CLI).values())
