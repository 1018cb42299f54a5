"""Where the checkout is, and what of it the tests read."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "budget"
EXAMPLE = ROOT / "examples" / "zhao_2019"
DOCS = ROOT / "docs"
TESTS = ROOT / "tests"
SHIPPED = sorted((*PACKAGE.rglob("*.py"), *EXAMPLE.rglob("*.py")))  # that ships
