"""Where results go: stdout for results, files whole or not at all."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from budget.cli.options import STDOUT
from budget.errors import CallError

if TYPE_CHECKING:
    from budget.results import Budget


def check_destinations(json: Path | None, csv: Path | None) -> None:
    """Refuse two documents on one stdout, before anything is computed."""
    if json == STDOUT and csv == STDOUT:
        raise CallError(
            "--json - and --csv - would both write to stdout; "
            "send one of them to a file"
        )


def deliver(budget: Budget, *, json: Path | None, csv: Path | None) -> None:
    """Print the budget for people, or the document asked for; write the files."""
    from budget.report.document import to_csv, to_json
    from budget.report.files import write_all

    documents = [(json, to_json), (csv, to_csv)]
    write_all(
        {
            path: render(budget)
            for path, render in documents
            if path is not None and path != STDOUT
        }
    )
    on_stdout = [render for path, render in documents if path == STDOUT]
    if on_stdout:
        sys.stdout.write(on_stdout[0](budget))
        return
    from rich.console import Console

    from budget.report.terminal import render_budget

    render_budget(budget, Console())
