"""The command line as a user types it: in this process, or in one of its own."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from unittest.mock import patch

import jsonschema
import typer.main

from budget.cli import main
from budget.report.schema import results_schema
from zhao_2019.study import PaperStudy

# A process builds its commands once; without this each call here would again.
COMMAND = cache(typer.main.get_command)

# A terminal of usual width without colours, whatever the tests are started from.
TERMINAL = {"COLUMNS": "80", "NO_COLOR": "1", "PYTHONIOENCODING": "utf-8"}
# Without bytecode each process would compile the whole package again.
UNWANTED = ("FORCE_COLOR", "SOURCE_DATE_EPOCH", "PYTHONDONTWRITEBYTECODE")


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a call left behind: its exit code and both streams."""

    code: int
    out: str
    err: str

    @property
    def document(self):
        """The JSON document on stdout, which is all that may stand there.

        Every key of it is in the schema of results.
        """
        return checked(json.loads(self.out))


SCHEMA = results_schema(PaperStudy)


@cache
def judge(command):
    """Return what validates the documents of one command."""
    refs = [
        one["$ref"] for part in SCHEMA["oneOf"] for one in part.get("oneOf", [part])
    ]
    own = [
        {"$ref": ref}
        for ref in refs
        for entry in [SCHEMA["$defs"][ref.rpartition("/")[2]]]
        if command in entry["properties"]["command"]["enum"]
    ]
    return jsonschema.Draft202012Validator({"oneOf": own, "$defs": SCHEMA["$defs"]})


def words_in(schema):
    """Yield the words that a schema knows of some value: all others are alike to it."""
    for part in schema.values() if isinstance(schema, dict) else schema:
        if isinstance(part, dict | list):
            yield from words_in(part)
    if isinstance(schema, dict):
        yield from (one for one in schema.get("enum", ()) if isinstance(one, str))
        yield schema.get("const")


WORDS = frozenset(words_in(SCHEMA))
LONGEST_TUPLE = 4  # items of a list that has a place for each


def one_of_each(value):
    """Return what a schema tells values apart by, and the value without doubles.

    Of a long list one item of each kind: numbers are alike, and so are free texts. The
    schema has no bounds of either. Most of a document are rows that differ in those.
    """
    if isinstance(value, dict):
        found = {key: one_of_each(item) for key, item in value.items()}
        kind = tuple((key, kind) for key, (kind, _) in found.items())
        return kind, {key: kept for key, (_, kept) in found.items()}
    if isinstance(value, list):
        items = [one_of_each(item) for item in value]
        if len(items) > LONGEST_TUPLE:
            items = list(dict(reversed(items)).items())
        return (list, *(kind for kind, _ in items)), [kept for _, kept in items]
    is_word = isinstance(value, str) and value in WORDS
    return (value if is_word else type(value)), value


def checked(document):
    """Return a document all of whose keys are in the schema, or a schema."""
    if "$schema" not in document:
        _, short = one_of_each(document)
        faults = judge(document["command"]).iter_errors(short)
        assert [(one.json_path, one.message[:200]) for one in faults] == []
    return document


def surroundings():
    """Return the environment that commands are called in."""
    kept = {name: text for name, text in os.environ.items() if name not in UNWANTED}
    return kept | TERMINAL


def call(*args, code=None, **environment):
    """Call the command line in this process, which saves the start of another.

    Keywords are more of its environment; it ends with `code`, where that is given.
    """
    out, err = io.StringIO(), io.StringIO()
    ended = 0
    with (
        patch.object(sys, "argv", ["budget", *map(str, args)]),
        patch.object(typer.main, "get_command", COMMAND),
        patch.dict(os.environ, surroundings() | environment, clear=True),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as stop:
            ended = stop.code or 0
    assert code in {None, ended}, (ended, err.getvalue() or out.getvalue())
    return Outcome(code=ended, out=out.getvalue(), err=err.getvalue())


def start(*args, cwd, python=sys.executable, **environment):
    """Start `python -m budget` in a folder, with more in its environment.

    The folder is never the checkout, which `-m` would put before what is installed.
    """
    run = subprocess.run(
        [python, "-m", "budget", *map(str, args)],
        cwd=cwd,
        capture_output=True,
        check=False,
        env=surroundings() | environment,
    )
    return Outcome(
        code=run.returncode, out=run.stdout.decode(), err=run.stderr.decode()
    )


def analyze(*args):
    """Return the document of a budget that is not validated."""
    return call("analyze", *args, "--no-validate", "--json", "-", code=0).document


def output(document, name):
    """Return the entry of one output by its dotted name."""
    (entry,) = (
        row
        for row in document["outputs"]
        if name == f"{row['sensor']}.{row['parameter']}.{row['axis']}"
    )
    return entry


def contribution(document, name, source):
    """Return what one source does to one output."""
    (part,) = (
        part
        for part in output(document, name)["contributions"]
        if part["source"] == source
    )
    return part
