"""The command line: parses, calls, prints."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, NoReturn

import typer

from budget.cli.allocate import allocate
from budget.cli.analyze import analyze
from budget.cli.check import check
from budget.cli.check_files import schema, validate
from budget.cli.compare import compare
from budget.cli.dates import document_date
from budget.cli.devices import devices
from budget.cli.diff import diff
from budget.cli.paper import paper
from budget.cli.report import report
from budget.cli.streams import drop_output, prepare_streams, without_controls
from budget.errors import BudgetError
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

EXIT_BAD_INPUT = 2
EXIT_SIGNAL = 128  # and the number of the signal, as shells count
EXIT_INTERRUPTED = 130  # SIGINT
EXIT_BROKEN_PIPE = 141  # SIGPIPE
ENDINGS = {129: "hung up", EXIT_INTERRUPTED: "interrupted", 143: "ended on request"}

app = typer.Typer(
    help="Error budgets for the discrete turntable calibration of strapdown IMUs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help starts faster and reads well in any terminal
)
app.command()(analyze)
app.command()(allocate)
app.command()(report)
app.command()(compare)
app.command()(check)
app.command()(diff)
app.command()(devices)
app.command()(paper)
app.command()(validate)
app.command()(schema)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - typer calls it so
    """Print the version and stop, if asked to."""
    if wanted:
        typer.echo(f"budget {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    *,
    version: bool = typer.Option(
        False,  # noqa: FBT003 - typer's own form
        "--version",
        callback=_print_version,
        is_eager=True,
        help="Print the version and stop.",
    ),
) -> None:
    """Error budgets for the discrete turntable calibration of strapdown IMUs."""


def _check_epoch() -> None:
    """Refuse a SOURCE_DATE_EPOCH that is no number: libraries crash on it."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        document_date()


def main() -> None:
    """Run the command line; errors made for people become one message and a code."""
    prepare_streams()
    try:
        with _ended_by_signals():
            _run()
    except BudgetError as error:
        _stop(str(error))
    except BrokenPipeError:
        drop_output()  # a reader that has enough, such as `head`
        raise SystemExit(EXIT_BROKEN_PIPE) from None
    except OSError as error:
        drop_output()
        _stop(
            f"{error.filename or 'standard output'}: the system refused: "
            f"{error.strerror or error}; expected a file or stream that can be used; "
            "free the disk, change its permissions or name another"
        )
    except MemoryError:
        _stop(
            "there is not enough memory for this run, nothing was written; expected "
            "some 300 MB and more for each worker: use fewer workers or trials"
        )
    except SystemExit as end:
        said = ENDINGS.get(end.code) if isinstance(end.code, int) else None
        if said is not None:  # typer answers Ctrl-C with its code, in silence
            sys.stderr.write(f"{said}; nothing was written\n")
        raise


def _run() -> None:
    """Run the command, and see that all it printed has gone out."""
    _check_epoch()
    try:
        app()
    finally:
        sys.stdout.flush()  # a full disk shows here, and not after a code for success


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let a request to end stop this process in order: files, workers, its code.

    A signal that is ignored stays so, as under `nohup`.
    """
    if current_thread() is not main_thread():
        yield
        return
    names = [name for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    asked = [getattr(signal, name) for name in names]
    ours = [number for number in asked if signal.getsignal(number) == signal.SIG_DFL]
    for number in ours:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, signal.SIG_DFL)


def _end(number: int, _: FrameType | None) -> NoReturn:
    """End with the code that shells give to a signal."""
    raise SystemExit(EXIT_SIGNAL + number)


def _stop(message: str) -> NoReturn:
    """Say what is wrong and end."""
    sys.stderr.write(f"{without_controls(message)}\n")
    raise SystemExit(EXIT_BAD_INPUT) from None
