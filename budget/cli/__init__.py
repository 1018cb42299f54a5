"""The command line: parses, calls, prints."""

from __future__ import annotations

import os
import sys

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
from budget.errors import BudgetError
from budget.version import __version__

EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130  # 128 + SIGINT, as shells count

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
    try:
        _check_epoch()
        app()
    except BudgetError as error:
        sys.stderr.write(f"{error}\n")
        raise SystemExit(EXIT_BAD_INPUT) from None
    except SystemExit as end:
        if end.code == EXIT_INTERRUPTED:  # typer answers Ctrl-C with it, in silence
            sys.stderr.write("interrupted; nothing was written\n")
        raise
