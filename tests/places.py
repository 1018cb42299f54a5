"""Where the checkout is, and what of it the tests read."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "budget"
DOCS = ROOT / "docs"
TESTS = ROOT / "tests"
