"""Where results go: stdout for results, files whole or not at all."""

from __future__ import annotations

import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING

from budget.cli.options import STDOUT
from budget.cli.streams import console, say
from budget.errors import CallError
from budget.journal import note_read

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from budget.results import Budget


def check_destinations(
    json: Path | None,
    csv: Path | None,
    *others: Path,
    inputs: Iterable[str | Path | None] = (),
) -> None:
    """Refuse outputs that cannot be, before anything is computed.

    Parameters
    ----------
    json, csv : Path or None
        Documents; '-' is stdout.
    *others : Path
        Further files to be written.
    inputs : iterable of str or Path or None
        Files to be read, FILE#VARIANT among them: none may be overwritten.

    Raises
    ------
    CallError
        Two documents would go to stdout.
    OutputError
        A file cannot be written, or is an input.
    """
    from budget.report.files import check_targets
    from budget.spec.files import find

    if json == STDOUT and csv == STDOUT:
        raise CallError(
            "--json - and --csv - would both write to stdout; "
            "send one of them to a file"
        )
    for name in inputs:
        if name is not None:
            note_read(find(name).path)
    check_targets(path for path in (json, csv, *others) if path and path != STDOUT)


@contextmanager
def printing() -> Iterator[None]:
    """Let a reader that stops reading, such as `head`, end the program in silence.

    Only while results are printed: elsewhere a broken pipe is an error to be told.
    """
    if not hasattr(signal, "SIGPIPE") or current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    try:
        yield
        sys.stdout.flush()
    finally:
        signal.signal(signal.SIGPIPE, before)


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
    if csv == STDOUT:  # the only output that has no room for them
        for text in budget.warnings:
            say(f"warning: {text}")
    with printing():
        if on_stdout:
            sys.stdout.write(on_stdout[0](budget))
            return
        from budget.report.terminal import render_budget

        render_budget(budget, console())
