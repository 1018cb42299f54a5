"""Terms: what users read says what contributes, contains or is confirmed."""

from __future__ import annotations

import ast
import inspect
import re
from collections import Counter

import pytest
from places import DOCS, PACKAGE, ROOT, SHIPPED, nodes_of, put

import budget
from budget.cli import app

# A source contributes, an interval contains, the law is confirmed, a limit is kept: of
# these the reader would have to guess which.
VAGUE = re.compile(r"\b(makes|holds|causes)\b")
CODE = re.compile(r"(?ms)^ *```.*?^ *```|`[^`\n]*`|<!--.*?-->")
# Names of fields, one after another.
FIELDS = re.compile(r"([a-z_]+(=\w+)? )*[a-z_]+=\w+( [a-z_]+(=\w+)?)*")
# The keys that rows of documents begin with, as code.
KEYS = re.compile(r"(?m)^ {4}\w+(?=:| \(| not in CSV)")


def vague(text):
    """Return the words about each vague one."""
    return [text[max(0, m.start() - 30) : m.end() + 20] for m in VAGUE.finditer(text)]


def written(path):
    """Yield the texts in a module that may be shown: strings, no docstrings."""
    nodes = nodes_of(path)
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    silent = {
        id(node.body[0].value)
        for node in nodes
        if isinstance(node, kinds) and isinstance(node.body[0], ast.Expr)
    }
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
            if " " in text and id(node) not in silent and not FIELDS.fullmatch(text):
                yield text


@pytest.mark.parametrize(
    "path", [ROOT / "README.md", *sorted(DOCS.glob("*.md"))], ids=lambda p: p.name
)
def test_pages_of_the_documentation(path):
    """Outside of code no page has a vague verb."""
    assert vague(CODE.sub("", path.read_text(encoding="utf-8"))) == []


def test_what_reports_and_messages_are_made_of():
    """No text in the package has one; templates neither."""
    found = [
        f"{path.name}: {one}"
        for path in SHIPPED
        for text in written(path)
        for one in vague(KEYS.sub("", text))
    ]
    for path in (ROOT / "templates").rglob("*"):
        if path.suffix in {".html", ".typ"}:
            found += vague(path.read_text(encoding="utf-8"))
    assert len(SHIPPED) > 100
    assert found == []


def test_help_and_docstrings_of_what_is_public():
    """Those of commands and of the library, down to what a result can do."""
    said = [one.callback.__doc__ for one in app.registered_commands]
    for name in budget.__all__:
        found = getattr(budget, name)
        said.append(inspect.getdoc(found) or "")
        if isinstance(found, type):
            said += [inspect.getdoc(one) or "" for one in vars(found).values()]
    assert len(said) > 50
    assert [one for text in said for one in vague(text or "")] == []


def test_a_vague_verb_is_seen(tmp_path):
    """Control: in a string and in prose; not in a docstring or in code."""
    path = put(
        tmp_path / "x.py",
        '"""It holds."""\nX = f"{1} makes {2} of u"\nY = "a=b holds"\n',
    )
    assert [one for text in written(path) for one in vague(text)] == [" makes "]
    assert vague(CODE.sub("", "it `holds`\n```\nmakes\n```\n")) == []
    assert vague("which causes it") == ["which causes it"]


def twofold(paths):
    """Return the names that several classes have, none of them inside of another."""
    found = Counter(
        node.name
        for path in paths
        for node in nodes_of(path)
        if isinstance(node, ast.ClassDef)
    )
    return {name for name, number in found.items() if number > 1}


def test_one_word_has_one_meaning(tmp_path):
    """No two classes of the package have one name; two that have are seen."""
    assert twofold(PACKAGE.rglob("*.py")) == set()
    (tmp_path / "one.py").write_text("class Limit:\n    pass\n", encoding="utf-8")
    (tmp_path / "other.py").write_text(
        "class Limit(str):\n    pass\n", encoding="utf-8"
    )
    assert twofold(tmp_path.glob("*.py")) == {"Limit"}
