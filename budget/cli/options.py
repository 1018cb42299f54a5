"""Options that several commands share, each defined once."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, is_dataclass
from enum import StrEnum
from functools import partial, wraps
from inspect import Parameter, signature
from itertools import islice
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from budget.cli.space import SPACE_OF_PAGES, check_space
from budget.cli.streams import talk
from budget.language import ENGLISH, LANGUAGES
from budget.settings import (
    CLI,
    COMPUTED,
    FILES,
    GOES,
    JUDGED,
    USED,
    Row,
    ask,
    every_row,
    rows,
    setting,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from budget.errors import Issue
    from budget.inputs.records import Device
    from budget.results import Assessment

BUILT_IN_DEVICE = "zhao-2019"
STDOUT = Path("-")
TOLD = 20  # issues of files that are left out, each a line; of more, files
MEETS = "meets"  # the verdict whose exit code is always 0
EXIT_NOT_MET, EXIT_BAD_INPUT = 1, 2


class Kind(StrEnum):
    """What a device has, or is."""

    GYRO = "gyro"
    ACCELEROMETER = "accelerometer"
    IMU = "IMU"


class Grade(StrEnum):
    """What the list of devices has under grade."""

    NAVIGATION = "navigation"
    TACTICAL = "tactical"
    CONSUMER = "consumer"


def _processes(wanted: int) -> int:
    """Cut the number of processes to that of the processors, and say so.

    More would share the same processors, and each takes some 100 MB.
    """
    there = processors()
    if wanted <= there:
        return wanted
    some = "1 processor" if there == 1 else f"{there} processors"
    talk(f"--workers {wanted}: this run may use {some}, so that many are started")
    return there


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def completing(kind: str, *words: str) -> Callable[[str], list[str]]:
    """Return what completes the name of a shipped file of a kind, or one there.

    Of words that may stand in its place, too.
    """

    def complete(incomplete: str) -> list[str]:
        from budget.inputs.files import shipped_names

        folder, slash, start = incomplete.rpartition("/")
        names = (*words, *shipped_names(kind))
        found = [name for name in names if name.startswith(incomplete)]
        with suppress(OSError):  # no such folder: nothing to complete
            for path in Path(folder + slash).iterdir():
                if path.name.startswith(start):
                    named = f"{folder}{slash}{path.name}"
                    if path.is_dir():
                        found.append(f"{named}/")
                    elif path.suffix.lower() in {".yaml", ".yml"}:
                        found.append(named)
        return sorted(found)

    return complete


complete_device = completing("device")


def complete_line(incomplete: str) -> list[str]:
    """Complete the name of a specification to which a value is given."""
    from budget.inputs.changes import RANGE
    from budget.model.sources import SENSORS, lines_of
    from budget.names import Name

    names = (
        f"{Name(name, owner=owner)}="
        for owner in SENSORS
        for name in (*(one.name for one in lines_of(owner)), RANGE)
    )
    return [name for name in names if name.startswith(incomplete)]


def complete_source(incomplete: str) -> list[str]:
    """Complete the name of an error source, of sensors, station or environment."""
    from budget.model.source import OWNERS
    from budget.model.sources import lines_of
    from budget.names import Name

    names = (
        str(Name(one.name, owner=owner))
        for owner in OWNERS
        for one in lines_of(owner)
        if one.may_vary
    )
    return [name for name in names if name.startswith(incomplete)]


def complete_output(incomplete: str) -> list[str]:
    """Complete the last of some outputs: gyro, gyro.bias or gyro.bias.z."""
    from budget.model.sources import SENSORS
    from budget.names import Name, quantities_of

    before, comma, last = incomplete.rpartition(",")
    names: list[str] = []
    for owner in SENSORS:
        names.append(owner)
        for quantity, axes in quantities_of(owner).items():
            names += [Name(quantity, owner=owner, axis=one) for one in ("", *axes)]
    return [f"{before}{comma}{name}" for name in names if name.startswith(last)]


judged = partial(typer.Option, rich_help_panel=JUDGED)
calibrated = partial(typer.Option, rich_help_panel=USED)
computed = partial(typer.Option, rich_help_panel=COMPUTED)
written = partial(typer.Option, rich_help_panel=GOES)

Devices = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[DEVICE...]",
        autocompletion=complete_device,
        help="Device files, FILE or FILE#VARIANT, - for standard input; without one "
        "the built-in paper device.",
        show_default=False,
    ),
]
Kinds = Annotated[
    list[Kind] | None,
    judged(
        "--kind",
        case_sensitive=False,
        help="Of the catalogue what has this, by itself or in an IMU, or is an IMU; "
        "may be given again.",
        show_default=False,
    ),
]
Grades = Annotated[
    list[Grade] | None,
    judged(
        "--grade",
        case_sensitive=False,
        help="Of the catalogue what has this grade, of that kind; may be given again.",
        show_default=False,
    ),
]
_PAGES = (
    "mission report compare decide allocate station check diff paper characterise "
    "calibrate history"
)


@dataclass(frozen=True, kw_only=True)
class OutputFiles:
    """Where results go, as what, and what the exit code says."""

    exit_code: bool = setting(
        False,  # noqa: FBT003 - the usual value
        "Exit with 1 where the requirement is not met (0 always).",
        "analyze mission",
        panel=JUDGED,
    )
    accept: str = setting(
        MEETS,
        "The least verdict whose exit code is 0: meets_if accepts conditions that "
        "nobody has stated.",
        "analyze mission compare decide allocate",
        panel=JUDGED,
        choices=(MEETS, "meets_if"),
    )
    full: bool = setting(
        False,  # noqa: FBT003 - the usual value
        "Everything that is known, not only the answer.",
        "analyze mission report compare allocate station",
        panel=GOES,
    )
    output: Sequence[Path] = setting(
        (),
        "Report to write, .html or .pdf.",
        _PAGES,
        at={
            "report": {"needed": True},
            "characterise": {"help": "Device file, .yaml, or page, .html or .pdf."},
            "calibrate": {"help": "Certificate, .html or .pdf."},
        },
        panel=GOES,
        option="-o",
        metavar="FILE",
        takes="page",
        several=True,
    )
    paper: str = setting(
        "a4",
        "Sheets of a PDF: A4, or US Letter.",
        _PAGES,
        panel=GOES,
        choices=("a4", "letter"),
    )
    templates: Path | None = setting(
        None,
        "Folder with templates, style sheet and letterhead of your own.",
        f"analyze {_PAGES} export devices validate simulate",
        panel=GOES,
        metavar="DIR",
        takes="folder",
    )
    language: str = setting(
        ENGLISH,
        "Language of results and pages: English, or Chinese.",
        f"analyze {_PAGES} simulate",
        panel=GOES,
        choices=LANGUAGES,
    )
    json: Path | None = setting(
        None,
        "Write the result as JSON.",
        f"analyze {_PAGES} export devices",
        panel=GOES,
        metavar="FILE|-",
        takes="document",
    )
    csv: Path | None = setting(
        None,
        "Write the result as CSV.",
        f"analyze {_PAGES} export",
        panel=GOES,
        metavar="FILE|-",
        takes="document",
    )


def _with_room(paths: list[Path] | None) -> list[Path] | None:
    """Refuse pages where no memory is left for what draws them."""
    if paths:
        check_space(SPACE_OF_PAGES)
    return paths


def _own_templates(context: typer.Context, folder: Path | None) -> Path | None:
    """Let the templates of a folder go before those that ship, for this call."""
    from budget.resources import templates_of

    context.with_resource(templates_of(folder))
    return folder


# What is done as soon as an option is read; of a folder, before others are.
_AT_ONCE: dict[str, Callable[..., Any]] = {
    "workers": _processes,
    "output": _with_room,
    "templates": _own_templates,
}
_COMPLETE = {
    "line": complete_line,
    "source": complete_source,
    "output": complete_output,
}
_PATHS = ("recording", "result", "page", "folder", "document")
_TYPES = {"int": int, "bool": bool}


def asking(job: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Spell out what may be asked of a command that takes it in records.

    Where the command has a parameter that is a record of rows, its help has an option
    for each row that means something in the job; it is handed the record.
    """
    return partial(_spelled_out, job=job)


def _spelled_out(command: Callable[..., None], *, job: str) -> Callable[..., None]:
    """Return a command whose signature has the options of its records."""
    own = signature(command, eval_str=True)
    records: dict[str, Any] = {
        one.name: one.annotation
        for one in own.parameters.values()
        if is_dataclass(one.annotation)
    }
    found = {name: rows(kind, job, CLI) for name, kind in records.items()}
    parameters = [
        each
        for one in own.parameters.values()
        for each in (
            [_option(row) for row in found[one.name].values()]
            if one.name in found
            else [one]
        )
    ]

    @wraps(command)
    def called(*arguments: object, **values: Any) -> None:  # noqa: ANN401 - as typer read them
        for record, kind in records.items():
            given = {
                name: not values.pop(f"no_{name}") if row.is_on else values.pop(name)
                for name, row in found[record].items()
            }
            values[record] = ask(
                kind, job, {n: v for n, v in given.items() if v is not None}
            )
        command(*arguments, **values)

    told: Any = called
    told.__signature__ = own.replace(parameters=parameters)
    told.__annotations__ = {each.name: each.annotation for each in parameters}
    return called


def given(context: typer.Context, *kinds: type) -> dict[str, str]:
    """Return what a call states of the rows of some records, each with its option."""
    flags = {name: row.flag for one in kinds for name, row in every_row(one).items()}
    found = ((name, context.get_parameter_source(name)) for name in context.params)
    return {
        name: flags[name]
        for name, source in found
        if name in flags and source is not None and source.name == "COMMANDLINE"
    }


def _option(row: Row) -> Parameter:
    """Return an option as typer takes it."""
    kind: Any = _TYPES.get(row.type.partition(" |")[0], str)
    if row.takes in {*FILES, *_PATHS} and not row.words:
        kind = Path
    if row.choices:
        kind = Literal[row.choices]
    if row.several:
        kind = list[kind]
    default = None if row.several else row.default
    name = row.name
    if row.is_on:
        name, default = f"no_{name}", False
    told = typer.Option(
        *([row.flag, "--output"] if row.flag == "-o" else [row.flag]),
        help=f"{row.help[:-1]}; may be given again." if row.several else row.help,
        rich_help_panel=row.panel,
        metavar=row.metavar,
        case_sensitive=False,
        min=None if row.read else row.least,
        max=None if row.read else row.most,
        parser=row.read and reading(row.read),
        callback=_AT_ONCE.get(name),
        is_eager=row.takes == "folder",
        autocompletion=completing(row.takes, *row.words)
        if row.takes in FILES
        else _COMPLETE.get(row.takes),
        show_default=default is not None,
    )
    return Parameter(
        name,
        Parameter.KEYWORD_ONLY,
        default=Parameter.empty if row.needed else default,
        annotation=Annotated[
            kind if row.needed or default is not None else kind | None, told
        ],
    )


def reading(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """Return what reads a text as typer takes it."""

    def parse(text: str) -> Any:  # noqa: ANN401 - of any type
        from budget.errors import BudgetError

        try:
            return read(text)
        except BudgetError as error:
            raise typer.BadParameter(str(error)) from None

    return parse


def select_catalogue(
    kinds: Sequence[str] | None, grades: Sequence[str] | None
) -> tuple[Device, ...]:
    """Load the devices that ship, of some kinds and grades or all.

    Raises
    ------
    CallError
        There is none.
    """
    from budget.errors import CallError
    from budget.inputs import load_catalogue
    from budget.missing.grades import is_one_of

    found = tuple(
        device for device in load_catalogue() if is_one_of(device, kinds, grades)
    )
    if not found:
        asked = " and ".join(
            f"{option} {' or '.join(words)}"
            for option, words in (("--kind", kinds), ("--grade", grades))
            if words
        )
        raise CallError(
            f"{asked}: expected a device of the catalogue that is so, found none; "
            "`budget devices` lists kind and grade of all"
        )
    return found


def accepted(accept: str) -> tuple[str, ...]:
    """Return the verdicts whose exit code is 0."""
    from budget.results import VERDICTS

    return VERDICTS[: VERDICTS.index(accept) + 1]


def check_exit_code(requirement: object, out: OutputFiles) -> None:
    """Refuse options on the exit code where nothing sets it.

    Raises
    ------
    CallError
        There is no requirement, or the code is 0 whatever the verdict.
    """
    from budget.errors import CallError

    if out.exit_code and requirement is None:
        raise CallError(
            "--exit-code is by the verdict on a requirement: give one with "
            "--requirement, or leave it out"
        )
    if out.accept != MEETS and not out.exit_code:
        raise CallError(
            f"--accept {out.accept} changes nothing without --exit-code: the code is 0 "
            "whatever the verdict; add --exit-code, or leave it out"
        )


def exit_by(assessment: Assessment | None, out: OutputFiles) -> None:
    """End with 1 where a requirement is not met, if the code is to say so.

    One with limits that were not judged is not met: the headline names them.
    """
    is_met = assessment is None or (
        assessment.verdict in accepted(out.accept) and not assessment.not_there
    )
    if out.exit_code and not is_met:
        raise typer.Exit(EXIT_NOT_MET)


def load_units(
    names: Iterable[str | Path], changes: Sequence[str], *, strict: bool = False
) -> tuple[Sequence[Device], bool]:
    """Load what is compared, every variant; whether some could not be read, as is said.

    Every file is read, however many are bad: what is not compared is never left unsaid.

    Raises
    ------
    CallError
        A change is none, or none of the devices can be read.
    SpecError
        With the issues of all files, where they are to be read `strict`.
    """
    from budget.errors import CallError, SpecError
    from budget.inputs.load import try_changed
    from budget.inputs.tree import MOST_ISSUES

    loaded, issues = try_changed(
        [*names], changes, variants=True, most=MOST_ISSUES if strict else inf
    )
    if strict and issues:
        raise SpecError(tuple(issues))
    for text in _told(issues):
        talk(text)
    if not loaded:
        raise CallError("none of the device files can be read; mend them and try again")
    return loaded.held(), bool(issues)


def load_sheet(device: str | None, changes: Sequence[str]) -> Device | None:
    """Load the data sheet beside what was measured, where one is given.

    Raises
    ------
    CallError
        None is, and changes are laid over it.
    SpecError
        It cannot be read.
    """
    from budget.errors import CallError
    from budget.inputs import load_device

    if device is not None:
        return load_device(device, changes)
    if changes:
        raise CallError(
            "--set changes values of a data sheet, and none is given; add --device, or "
            "leave it out"
        )
    return None


def _told(issues: Sequence[Issue]) -> Iterator[str]:
    """Yield what is said of bad files among good ones: of many issues one a file."""
    if len(issues) <= TOLD:
        yield from map(str, issues)
        return
    files: dict[str, list[Issue]] = {}
    for one in issues:
        files.setdefault(one.file, []).append(one)
    for own in islice(files.values(), TOLD):
        yield f"{own[0]}" + (f" (and {len(own) - 1} more)" if own[1:] else "")
    if len(files) > TOLD:
        yield f"{len(files) - TOLD} more files cannot be read; mend those above first"


def load_devices(names: list[str] | None, changes: Sequence[str]) -> tuple[Device, ...]:
    """Load the devices named, or the built-in one, saying so; with the changes.

    Raises
    ------
    CallError
        A change is none, or reaches no device.
    SpecError
        With the issues of all files.
    """
    from budget.inputs.load import load_changed

    if not names:
        talk(f"No device given: using the built-in {BUILT_IN_DEVICE} (Zhao 2019).")
        names = [BUILT_IN_DEVICE]
    return tuple(load_changed(names, changes, variants=False))
