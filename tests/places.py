"""Where the checkout is, what of it the tests read, and its source as trees."""

from __future__ import annotations

import ast
import gc
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "budget"
EXAMPLE = ROOT / "examples" / "zhao_2019"
DOCS = ROOT / "docs"
TESTS = ROOT / "tests"
SHIPPED = sorted((*PACKAGE.rglob("*.py"), *EXAMPLE.rglob("*.py")))  # that ships


@cache
def nodes_of(path):
    """Return all nodes of a file, outer ones first: parsed once for all who ask."""
    was_enabled = gc.isenabled()
    gc.disable()  # nothing of a tree is garbage, and to look for it takes half the time
    try:
        return tuple(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    finally:
        if was_enabled:
            gc.enable()


def put(path, text):
    """Write a file of text, and return its path."""
    path.write_text(text, encoding="utf-8")
    return path
