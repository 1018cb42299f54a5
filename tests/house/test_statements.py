"""The count of statements, against an invented tree that is counted by hand."""

from __future__ import annotations

import runpy
import subprocess

import pytest
from places import ROOT

MAIN = runpy.run_path(str(ROOT / "benchmarks" / "statements.py"))["main"]
GROUND = '''"""A docstring."""
import os
from budget.language import note
TOP: int = 1; LOW = 2
class Row:
    """A class."""
    name: str
    def title(self):
        """A method."""
        return note("{name}", name=self.name)
'''
# Six: a, def, if, return, return, the expression, which is no docstring here.
ROOM = """a = language.say("x") + term("y") + say("z")
async def f(x):
    if x: return 1
    return counted(2, "one", "two")
"no docstring"
"""


@pytest.fixture
def tree(tmp_path):
    """Make a package of two rooms, a template, and what is not counted."""
    texts = {
        "budget/rows.py": GROUND,
        "budget/inner/__init__.py": "",
        "budget/inner/deep/f.py": ROOM,
        "budget/inner/words.po": "no Python",
        "examples/one/study.py": "a = say(1)\n",
        "examples/one/printed.yaml": "a: 1",
        "templates/page.j2": "one\ntwo\n",
        "tests/test_f.py": "a = 1\n",
    }
    for name, text in texts.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def numbers(table):
    """Return the numbers of a table by the heads of its rows."""
    lines = [line.split() for line in table.splitlines()]
    return {head: list(map(int, row)) for head, *row in lines if row[-1].isdigit()}


def test_rooms_are_counted_apart_and_add_up(tree):
    """Statements, functions, classes, then say, note, term and counted, by room."""
    table = MAIN([], tree)

    assert numbers(table) == {
        "(ground)": [6, 1, 1, 0, 1, 0, 0],
        "inner": [6, 1, 0, 2, 0, 1, 1],
        "examples": [1, 0, 0, 1, 0, 0, 0],
        "total": [13, 2, 1, 3, 1, 1, 1],
        "templates": [2],
    }
    assert max(map(len, table.splitlines())) <= 80


def test_a_revision_stands_beside_what_is_now(tree):
    """Before and now in pairs; a room that is gone and a new one have 0 once."""
    git = ("git", "-c", "user.name=a", "-c", "user.email=a@b")
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "first"]):
        subprocess.run([*git, *words], cwd=tree, check=True)
    (tree / "budget" / "inner").rename(tree / "budget" / "outer")
    (tree / "templates" / "page.j2").write_text("one\n", encoding="utf-8")
    (tree / "budget" / "rows.py").write_text("a = say(1)\n", encoding="utf-8")

    table = MAIN(["--against", "HEAD"], tree)

    assert numbers(table) == {
        "(ground)": [6, 1, 1, 0, 1, 0, 1, 1],
        "inner": [6, 0, 1, 0, 0, 0, 4, 0],
        "outer": [0, 6, 0, 1, 0, 0, 0, 4],
        "examples": [1, 1, 0, 0, 0, 0, 1, 1],
        "total": [13, 8, 2, 1, 1, 0, 6, 6],
        "say": [3, 4],
        "note": [1, 0],
        "term": [1, 1],
        "counted": [1, 1],
        "templates": [2, 1],
    }
    assert max(map(len, table.splitlines())) <= 80
