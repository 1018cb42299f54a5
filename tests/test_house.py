"""The house: who may import whom, what the command line may not wake up."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "budget"

# From the ground up. A module imports from lower floors, or within its own room;
# rooms on one floor do not know each other.
FLOORS = (
    ("version", "arrays", "errors", "earth", "resources"),
    ("units",),
    ("distributions",),
    ("problem",),
    ("results",),
    ("spec",),
    ("physics", "methods"),
    ("studies",),
    ("report",),
    ("cli",),
    ("__main__",),
)
FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
# The package's face hands on public names and loads them when they are asked for.
FACE = "__init__"


def room_of(path):
    """Return the first part of a module's place below the package."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path):
    """Return every module of this package that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            parts = node.module.split(".")
            if parts == ["budget"]:
                yield from (alias.name for alias in node.names)
            elif parts[0] == "budget":
                yield parts[1]
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.startswith("budget."):
                    yield alias.name.split(".")[1]


MODULES = [p for p in sorted(PACKAGE.rglob("*.py")) if room_of(p) != FACE]


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_run_downwards(path):
    """No module imports from its own floor's neighbour or from above."""
    here = room_of(path)
    for other in imports(path):
        if other != here:
            assert FLOOR[other] < FLOOR[here], f"{path.name} imports {other}"


def test_the_import_check_can_fail(tmp_path):
    """Control: an import that runs upwards is seen by the check."""
    bad = tmp_path / "bad.py"
    bad.write_text("def f():\n    from budget.cli import main\n", encoding="utf-8")
    assert list(imports(bad)) == ["cli"]
    assert FLOOR["cli"] > FLOOR["methods"]


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_modules_are_small_and_say_what_they_are_for(path):
    """Every file states its purpose first and stays under 400 lines."""
    text = path.read_text(encoding="utf-8")
    assert text.startswith('"""')
    assert len(text.splitlines()) < 400


def test_help_wakes_nothing_heavy():
    """`budget --help` imports no numpy, scipy, pandas, matplotlib, pint or pydantic."""
    code = (
        "import sys, budget.cli\n"
        "try:\n    budget.cli.app(['--help'])\n"
        "except SystemExit:\n    pass\n"
        "print(sorted({m.split('.')[0] for m in sys.modules}))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(PACKAGE.parent)},
    )
    loaded = run.stdout.splitlines()[-1]
    for heavy in (
        *("numpy", "scipy", "pandas", "matplotlib", "SALib"),
        *("pint", "pydantic", "ruamel", "jinja2"),
    ):
        assert f"'{heavy}'" not in loaded
