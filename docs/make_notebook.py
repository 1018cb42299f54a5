"""Run the notebook of these pages and keep what it prints: its figures as drawings."""  # noqa: INP001 - a script, no package

from __future__ import annotations

import os
from pathlib import Path

import nbformat
from nbclient import NotebookClient

FILE = Path(__file__).resolve().parent / "notebook.ipynb"
# A figure is kept once, as the drawing, which is the same wherever it is drawn.
LEFT_OUT = ("image/png",)
WIDTH = "100"  # of what is printed [columns]


def read() -> nbformat.NotebookNode:
    """Return the notebook as it is kept."""
    return nbformat.read(FILE, as_version=4)


def executed() -> nbformat.NotebookNode:
    """Return the notebook as a fresh kernel runs it, without times and bitmaps.

    Raises
    ------
    CellExecutionError
        A cell fails.
    """
    book = read()
    client = NotebookClient(book, timeout=120, record_timing=False)
    client.execute(env={**os.environ, "COLUMNS": WIDTH})
    book.metadata.pop("language_info", None)
    for cell in book.cells:
        for output in cell.get("outputs", ()):
            for kind in LEFT_OUT:
                output.get("data", {}).pop(kind, None)
    return book


if __name__ == "__main__":
    nbformat.write(executed(), FILE)
