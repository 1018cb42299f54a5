"""Python files as trees, for what the tests ask of the source itself."""

from __future__ import annotations

import ast
import gc
from functools import cache


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
