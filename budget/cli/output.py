"""Where results go: stdout for results, files whole or not at all."""

from __future__ import annotations

import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING

from budget.cli.options import STDOUT
from budget.errors import CallError

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
        Two documents would go to stdout or to one file, or an output is an input.
    """
    if json == STDOUT and csv == STDOUT:
        raise CallError(
            "--json - and --csv - would both write to stdout; "
            "send one of them to a file"
        )
    wanted = [path for path in (json, csv, *others) if path and path != STDOUT]
    _check_twice(wanted)
    read = [Path(str(name).partition("#")[0]) for name in inputs if name is not None]
    for path in wanted:
        if path.exists():
            for source in read:
                if source.exists() and path.samefile(source):
                    raise CallError(
                        f"{path} is an input of this run and would be overwritten; "
                        "write to another file"
                    )


def _check_twice(paths: list[Path]) -> None:
    """Refuse two outputs in one file, however it is spelt: one would be lost."""
    targets = [path.resolve() for path in paths]
    twice = {target for target in targets if targets.count(target) > 1}
    if twice:
        names = [
            str(path)
            for path, target in zip(paths, targets, strict=True)
            if target in twice
        ]
        raise CallError(
            f"{', '.join(dict.fromkeys(names))}: two outputs would be written to this "
            "one file, expected a file for each; give them different names"
        )


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
            sys.stderr.write(f"warning: {text}\n")
    with printing():
        if on_stdout:
            sys.stdout.write(on_stdout[0](budget))
            return
        from rich.console import Console

        from budget.report.terminal import render_budget

        render_budget(budget, Console())
