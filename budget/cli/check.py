"""`budget check`: are stored budgets still what they were, and if not, why."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer

from budget.cli import options
from budget.cli.streams import in_line, talk, tell
from budget.settings import UNTESTED, Asked, Engine, Inputs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.files import NamedFile
    from budget.inputs.records import Device
    from budget.references.difference import Difference
    from budget.references.records import Job, Role, Stored, StoredInput
    from budget.results import InputFile


EXIT_MOVED = 1
MOST_DEVICES = 3  # beside which it is said what runs may not show
SUFFIX = ".json"

SchemaKind = Literal[
    "device",
    "procedure",
    "station",
    "mission",
    "requirement",
    "costs",
    "reference",
    "results",
]


@options.asking("check")
def check(
    context: typer.Context,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[REFERENCE...]",
            help="References: files, folders of them, or bare names of shipped ones; "
            "without one all that ship. With --save: device files.",
            show_default=False,
        ),
    ] = None,
    *,
    save: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.json",
            help="Store a new reference of the devices named; the options below are "
            "its settings.",
            show_default=False,
        ),
    ] = None,
    kind: Annotated[
        Literal["analyze", "mission", "compare", "allocate"] | None,
        typer.Option(
            case_sensitive=False,
            help="What to store (analyze; mission with --mission).",
            show_default=False,
        ),
    ] = None,
    inputs: Inputs,
    asked: Asked,
    costs: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Costs file of an allocation.", show_default=False
        ),
    ] = None,
    root: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            exists=True,
            file_okay=False,
            help="Folder that inputs of references must be in (this one, or that of "
            "the reference).",
            show_default=False,
        ),
    ] = None,
    engine: Engine,
    out: options.OutputFiles,
) -> None:
    """Hold stored budgets against their files as they are now.

    Each is computed again from its input files. Results by GUM propagation may
    differ by 1e-9, those of trials by what two seeds may give. Exit code 1 where a
    number moved, with what moved and which input or version did it; 2 where a reference
    cannot be checked.

    With --save a budget is stored: `budget check --save ref.json DEVICE...`. GUM
    propagation is stored without its check by Monte Carlo, an allocation without its
    correction.
    """
    from budget.errors import CallError
    from budget.references.records import Stored

    given = Stored.of(asked, inputs)
    if save is not None:
        if out.json or out.csv or out.output:
            raise CallError(
                "--json, --csv and -o are for checks, a reference is a document "
                "itself; leave them out"
            )
        kind = kind or ("mission" if inputs.mission else "analyze")
        files = (names or [], inputs)
        _save(save, kind, given, *files, costs=costs, workers=engine.workers)
        return
    if options.given(context, Asked, Inputs) or kind or costs:
        raise CallError(
            "settings are those of the stored references and cannot be given to a "
            "check; leave them out, or store a new reference with --save FILE"
        )
    _check(context, names or [], out, root=root, workers=engine.workers)


def _save(
    path: Path,
    kind: Job,
    given: Stored,
    devices: list[str],
    inputs: Inputs,
    *,
    costs: str | None,
    workers: int,
) -> None:
    """Compute a reference and store it."""
    from budget.cli.output import check_destinations
    from budget.errors import CallError, ReferenceFileError
    from budget.references.check import make_reference
    from budget.references.files import with_changes
    from budget.references.store import parse_reference, reference_text
    from budget.report.files import write_all

    if path.suffix.lower() != SUFFIX:
        raise CallError(
            f"--save {path}: a reference ends in {SUFFIX}; give it that name"
        )
    check_destinations(None, None, path, inputs=[*devices, *inputs.files, costs])
    if not devices:
        talk(
            f"No device given: using the built-in {options.BUILT_IN_DEVICE} "
            "(Zhao 2019)."
        )
    taken = take_all(devices or [None], inputs, costs, folder=path.parent)
    reference = make_reference(
        kind, with_changes(taken, inputs.changes, job=kind), given, workers=workers
    )
    text = reference_text(reference)
    try:
        parse_reference(text.encode(), str(path))
    except ReferenceFileError as error:
        raise CallError(
            f"--save: nothing was written, as it could not be read back: {error}"
        ) from None
    write_all({path: text})
    numbers = len(reference.numbers)
    talk(f"{in_line(path)}: written, {kind}, {numbers} numbers")


def take_all(
    devices: Sequence[str | None],
    inputs: Inputs,
    costs: str | None = None,
    *,
    folder: Path | None = None,
) -> tuple[StoredInput, ...]:
    """Read all inputs, or say everything that is wrong in them."""
    from budget.errors import Issue, SpecError
    from budget.inputs.load import one_calibration, several, try_all
    from budget.references.files import take, take_procedures

    tests = one_calibration(inputs.calibration, inputs.procedures or inputs.procedure)
    files: dict[Role, Any] = {
        "device": devices,
        "procedure": None if tests in UNTESTED else tests,
        "station": inputs.station,
        "mission": inputs.mission,
        "requirement": inputs.requirement,
        "costs": costs,
        "result": inputs.measured,
    }
    taken: list[StoredInput] = []
    issues: list[Issue] = []
    for role, given in files.items():
        names = () if given is None else several(given)
        if role == "procedure":
            is_tested = inputs.mission is None and tests is None
            wanted = [[*names] or ([None] if is_tested else [])]
            sets, wrong = try_all(wanted, partial(take_procedures, folder=folder))
            taken += [one for own in sets for one in own]
        else:
            found, wrong = try_all(names, partial(take, role, folder=folder))
            taken += found
        issues += wrong
    if issues:
        raise SpecError(tuple(issues))
    return tuple(taken)


def _check(
    context: typer.Context,
    names: list[str],
    out: options.OutputFiles,
    *,
    root: Path | None,
    workers: int,
) -> None:
    """Check references one by one; one that is bad does not stop the others."""
    from budget.cli.computing import progress
    from budget.cli.output import check_files, hand_out, pages_asked
    from budget.errors import BudgetError
    from budget.references.check import check as run
    from budget.references.files import find_references, named_reference
    from budget.references.store import read_reference
    from budget.report.document import json_of, table_csv
    from budget.report.reference import check_document, check_sections, moved

    checks: list[Difference] = []
    errors: list[str] = []
    found: list[NamedFile] = []
    files: list[InputFile] = []
    for wanted in names or (None,):
        try:
            found.extend(find_references(wanted))
        except BudgetError as error:
            errors.append(str(error))
    check_files(out, Inputs(), more=[one.path for one in found])
    with progress() as show:
        for done, one in enumerate(found, start=1):
            try:
                stored = read_reference(one.path, one.shown)
                files.append(named_reference(one))
                folder = one.path.parent
                checks.append(
                    run(stored, folder, name=one.shown, workers=workers, root=root)
                )
            except BudgetError as error:
                errors.append(str(error))
            show("check", done, len(found))
    for text in errors:
        talk(text)
    hand_out(
        [
            (out.json, lambda: json_of((checks, errors), "check")),
            (out.csv, lambda: table_csv("moved", moved(checks))),
        ],
        lambda: check_sections(checks, len(errors)),
        pages=pages_asked(context, out, partial(check_document, checks, errors, files)),
        language=out.language,
    )
    if errors:
        raise typer.Exit(options.EXIT_BAD_INPUT)
    if not all(one.holds for one in checks):
        raise typer.Exit(EXIT_MOVED)


@options.asking("validate")
def validate(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Files of any kind.")
    ],
    *,
    inputs: Inputs,
    _out: options.OutputFiles,
) -> None:
    """Check files and say everything that is wrong in them, with positions.

    Of a procedure beside up to three devices it says which mistakes of a run with one
    may not be seen.
    """
    from budget.cli.output import printing
    from budget.errors import SpecError
    from budget.inputs.load import try_valid
    from budget.inputs.makers import MEANINGS
    from budget.language import say
    from budget.studies.sheets import cautions_of_device

    checked, issues = try_valid(files, inputs.changes)
    devices = [one for found in checked for one in found.devices]
    for found in checked:
        name = found.file
        with printing():
            tell(f"{in_line(name)}: {found.kind}, valid\n")
            for text in found.ranges:
                tell(f"  range: {text}\n")
            for text in found.assumptions:
                tell(f"  assumed: {text}\n")
            for text in dict.fromkeys(
                say(one.text)
                for device in found.devices
                for one in cautions_of_device(device)
            ):
                tell(f"  caution: {text}\n")
            if found.kind == "device" and found.assumptions:
                tell(f"  how values of data sheets are read: {MEANINGS}\n")
            if found.kind == "procedure":
                _show_procedure(name, devices)
            if found.kind == "mission":
                _show_mission(name)
    if issues:
        raise SpecError(tuple(issues))


def _show_procedure(name: str, devices: Sequence[Device]) -> None:
    """Warn of what it says of the place, what that may cost; draw what it does when.

    Of devices that are checked beside it, which mistakes of a run they may not show.
    """
    from budget.calibration.schemes import calibrates
    from budget.cli.output import print_page
    from budget.inputs import load_procedure
    from budget.model.sources import SENSORS
    from budget.recordings.run_soundness import unseen_mistakes
    from budget.report.calibrated import unseen_section
    from budget.report.figures.timeline import schedule_sections
    from budget.report.inputs import blunders_sections
    from budget.studies.blunders import costs, evident

    procedure = load_procedure(name)
    for text in evident(procedure):
        tell(f"  warning: {text}\n")
    there = [kind for kind in SENSORS if calibrates(kind, procedure)]
    print_page(
        [
            *blunders_sections(costs(procedure)),
            *schedule_sections(procedure, there),
            *(
                unseen_section(unseen_mistakes(one, procedure), device=one.name)
                for one in (devices if len(devices) <= MOST_DEVICES else ())
            ),
        ]
    )


def _show_mission(name: str) -> None:
    """Warn of what is of no vehicle, and say where it leads."""
    from budget.cli.output import print_page
    from budget.inputs import load_mission
    from budget.report.route import route_section
    from budget.studies.cautions import of_no_vehicle

    mission = load_mission(name)
    for text in of_no_vehicle(mission):
        tell(f"  warning: {text}\n")
    print_page([route_section(mission)])


def schema(
    kind: Annotated[
        SchemaKind,
        typer.Argument(
            metavar="KIND", case_sensitive=False, help=", ".join(get_args(SchemaKind))
        ),
    ],
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check.

    That of `results` is of the documents that --json writes.
    """
    from json import dumps

    from budget.cli.output import printing
    from budget.inputs import json_schema
    from budget.references.store import reference_schema
    from budget.report.schema import results_schema
    from zhao_2019.study import PaperStudy

    if kind == "results":
        found = results_schema(PaperStudy)
    else:
        found = reference_schema() if kind == "reference" else json_schema(kind)
    with printing():
        typer.echo(dumps(found, indent=2, ensure_ascii=False))
