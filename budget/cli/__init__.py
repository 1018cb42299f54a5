"""The command line: parses, calls, prints."""

from __future__ import annotations

import gc
import logging
import os
import signal
import sys
import traceback
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from budget.cli.allocate import allocate
from budget.cli.analyze import analyze
from budget.cli.calibrate import calibrate
from budget.cli.characterise import characterise
from budget.cli.check import check, schema, validate
from budget.cli.compare import compare
from budget.cli.decide import decide
from budget.cli.devices import devices
from budget.cli.diff import diff
from budget.cli.export import export
from budget.cli.history import history
from budget.cli.mission import mission
from budget.cli.new import new
from budget.cli.paper import paper
from budget.cli.report import report
from budget.cli.simulate import simulate
from budget.cli.space import LEAST_SPACE, check_space
from budget.cli.station import station
from budget.cli.streams import in_line, prepare_streams, talk, tell
from budget.errors import BudgetError, CallError, WorkerError
from budget.inputs.tree import LONGEST_SHOWN
from budget.journal import keep_journal
from budget.report.rendering import document_date
from budget.settings import COMPUTED, GOES, JUDGED, USED
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

    from budget.journal import Journal

EXIT_BAD_INPUT = 2
EXIT_SIGNAL = 128  # and the number of the signal, as shells count
EXIT_INTERRUPTED = 130  # SIGINT
EXIT_FAULT = 70  # of the program itself, as sysexits.h has it
LONGEST_WORD = 4096  # characters of an argument: no path that can be opened is longer
GARBAGE = 100_000  # new objects before circles among them are looked for
DETAILS = "BUDGET_TRACEBACK"  # environment variable: print where a fault arose
ENDINGS = {129: "hung up", EXIT_INTERRUPTED: "interrupted", 143: "ended on request"}


class _Commands(TyperGroup):
    """All commands. A pipe that breaks is an error to be told, not typer's exit 1."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:  # noqa: ANN401
        """Return the command; one of its options may not be given twice in silence."""
        name, found, rest = super().resolve_command(ctx, args)
        if found is not None and (twice := _given_twice(found, rest)):
            raise typer.BadParameter(
                f"{', '.join(twice)} given more than once, and only one counts; leave "
                "the others out"
            )
        return name, found, rest

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401 - as typer has it
        """Run the command."""
        try:
            return super().invoke(ctx)
        except typer.BadParameter as error:
            error.message = error.message.replace("int range", "integer")
            raise
        except BrokenPipeError as error:
            raise WorkerError(
                "a pipe to another process of this run broke, expected one that stays "
                "open; nothing is known to be wrong with the files: try again with "
                "--workers 1"
            ) from error


class _Command(TyperCommand):
    """One command, whose help has its options in groups."""

    def format_options(self, ctx: Any, formatter: Any) -> None:  # noqa: ANN401
        """Print arguments, then each group of options; that of `--help` last."""
        groups: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                is_option = parameter.param_type_name == "option"
                panel = getattr(parameter, "rich_help_panel", None)
                title = panel or ("Options" if is_option else "Arguments")
                groups.setdefault(title, []).append(record)
        order = ("Arguments", JUDGED, USED, COMPUTED, GOES)
        groups = {name: groups.pop(name) for name in order if name in groups} | groups
        for title, records in groups.items():
            with formatter.section(title):
                formatter.write_dl(records)


def _given_twice(command: Any, words: list[str]) -> list[str]:  # noqa: ANN401
    """Return the options with one value for which there are two."""
    options = {
        word: option
        for option in command.params
        if option.param_type_name == "option"
        for word in option.opts
    }
    given: list[str] = []
    left = iter(words)
    for word in left:
        if word == "--":
            break
        name, has_value, _ = word.partition("=")
        option = options.get(name)
        if option is None or option.is_flag:
            continue
        if not has_value:
            next(left, None)
        if not option.multiple:
            given.append(option.opts[0])
    return [name for name in dict.fromkeys(given) if given.count(name) > 1]


app = typer.Typer(
    cls=_Commands,
    help="Error budgets for the discrete turntable calibration of strapdown IMUs.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help starts faster and reads well in any terminal
)
for command in (
    *(
        analyze,
        mission,
        allocate,
        station,
        export,
        characterise,
        calibrate,
        history,
        simulate,
        report,
        compare,
        decide,
        check,
        diff,
    ),
    *(devices, paper, new, validate, schema),
):
    # A short help that is given is printed whole; one that is found is cut.
    summary = " ".join((command.__doc__ or "").partition("\n\n")[0].split())
    app.command(cls=_Command, short_help=summary)(command)


def _print_version(wanted: bool) -> None:  # noqa: FBT001 - typer calls it so
    """Print the version and stop, if asked to."""
    if wanted:
        tell(f"budget {__version__}\n")
        raise typer.Exit


@app.callback()
def _root(
    *,
    version: bool = typer.Option(  # noqa: ARG001 - typer asks it
        False,  # noqa: FBT003 - typer's own form
        "--version",
        callback=_print_version,
        is_eager=True,
        help="Print the version and stop.",
    ),
) -> None:
    """Error budgets for the discrete turntable calibration of strapdown IMUs."""
    check_space(LEAST_SPACE)


def _check_epoch() -> None:
    """Refuse a SOURCE_DATE_EPOCH that is no number: libraries crash on it."""
    if "SOURCE_DATE_EPOCH" in os.environ:
        document_date()


def main() -> None:
    """Run the command line; errors made for people become one message and a code."""
    # Matrices are small here: a second thread of OpenBLAS only waits, spinning. It is
    # read when numpy is loaded, in worker processes too.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Files are read by our schemas alone: no plugins are looked for among all packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # Other libraries' talk is not ours: what a person must know is said in our words.
    logging.disable(logging.NOTSET if os.environ.get(DETAILS) else logging.CRITICAL)
    # Nearly all objects of a run are modules and classes, which stay: to look through
    # them for circles at every 700 new ones takes a tenth of its time.
    gc.set_threshold(GARBAGE)
    with keep_journal() as journal:
        try:
            _guard(journal)
        finally:
            for fault in _of_sources("outside_faults"):
                talk(f"warning: {fault}")


def _guard(journal: Journal) -> None:
    """Run, and turn whatever ends a run into words and a code."""
    try:
        prepare_streams()
        with _ended_by_signals():
            _run()
    except BudgetError as error:
        _stop(str(error))
    except OSError as error:
        what = f"{error.filename}: " if error.filename else ""
        _stop(
            f"{what}the system refused: {error.strerror or error}; expected files and "
            "folders that can be used and limits that allow it; free the disk, change "
            "permissions, raise the limit (`ulimit -a` lists them) or use fewer workers"
        )
    except MemoryError:
        _stop(
            f"there is not enough memory for this run, {_written(journal)}; expected "
            "some 300 MB and more for each worker: use fewer workers, trials or windows"
        )
    except KeyboardInterrupt:
        _stop(f"{ENDINGS[EXIT_INTERRUPTED]}; {_written(journal)}", EXIT_INTERRUPTED)
    except SystemExit as end:
        said = ENDINGS.get(end.code) if isinstance(end.code, int) else None
        if said is not None:  # typer answers Ctrl-C with its code, in silence
            talk(f"{said}; {_written(journal)}")
        raise
    except Exception as error:  # noqa: BLE001 - the last net
        _fail(error)


def _written(journal: Journal) -> str:
    """Say which files stand, all of them whole."""
    names = ", ".join(map(in_line, journal.written))
    return f"written before: {names}" if names else "nothing was written"


def _run() -> None:
    """Run the command, and see that all it printed has gone out."""
    _check_epoch()
    for word in sys.argv[1:]:  # whatever is wrong with it, a message would repeat it
        if len(word) > LONGEST_WORD:
            raise CallError(
                f"the argument '{word[:LONGEST_SHOWN]}...' has {len(word)} characters, "
                f"{LONGEST_WORD} are the most of one; give a longer text in a file"
            )
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


def _stop(message: str, code: int = EXIT_BAD_INPUT) -> NoReturn:
    """Say what is wrong and end."""
    talk(message)
    raise SystemExit(code) from None


def _of_sources(name: str, *given: object) -> Any:  # noqa: ANN401
    """Ask the table of sources something, if the run has loaded it; else ()."""
    table = sys.modules.get("budget.model.sources")
    return () if table is None else getattr(table, name)(*given)


def _fail(error: Exception) -> NoReturn:
    """Say in a line what is to be reported: a fault of the program itself.

    Or of another package, whose error line it arose in.
    """
    if whose := _of_sources("blamed_outside", error):
        _stop(whose)
    found = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in found if "budget" in Path(frame.filename).parts]
    where = f" in {Path(ours[-1].filename).name}:{ours[-1].lineno}" if ours else ""
    said = " ".join(str(error).split())
    if os.environ.get(DETAILS):
        talk("".join(traceback.format_exception(error)).rstrip())
    _stop(
        f"internal error: {type(error).__name__}{where}: {said}; this is a fault of "
        f"budget {__version__}, not of your files: please report this line with the "
        f"command and its files ({DETAILS}=1 prints more to add)",
        EXIT_FAULT,
    )
