"""The notebook of the documentation, run by a fresh kernel."""

from __future__ import annotations

import runpy

import pytest
from places import ROOT


def printed(book):
    """Return what each cell prints, a figure by the finding that is its title."""
    return [
        [output["data"]["text/plain"] for output in cell["outputs"]]
        for cell in book.cells
        if cell["cell_type"] == "code"
    ]


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # of what runs the kernel, which is not ours
def test_the_notebook_prints_what_is_kept():
    """Every cell runs, every table is as kept, and figures are drawn by themselves."""
    make = runpy.run_path(str(ROOT / "docs" / "make_notebook.py"))
    kept, found = make["read"](), make["executed"]()

    assert printed(found) == printed(kept)
    figures = [
        output["data"]["image/svg+xml"]
        for cell in found.cells
        for output in cell.get("outputs", ())
        if output["data"]["text/plain"].startswith("<Figure: ")
    ]
    assert len(figures) == 2
    assert all("<svg" in text for text in figures)
    kinds = {
        kind
        for cell in kept.cells
        for output in cell.get("outputs", ())
        for kind in output["data"]
    }
    assert kinds == {"text/plain", "text/html", "image/svg+xml"}
