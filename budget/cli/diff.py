"""`budget diff`: two budgets side by side, and which input makes the difference."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from budget.cli import options
from budget.settings import Asked, Inputs

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence
    from pathlib import Path

    from budget.recordings.printed import MeasuredLot, MeasuredUnit
    from budget.recordings.results import CalibrationChange
    from budget.references.records import Job, ReferenceBudget, StoredInput

SUFFIX = ".json"
JOBS: tuple[Job, ...] = ("analyze", "mission")  # of a device, which is computed now


@options.asking("diff")
def diff(
    context: typer.Context,
    first: Annotated[
        str,
        typer.Argument(
            metavar="A",
            help="A device file, FILE or FILE#VARIANT, or a stored reference.",
        ),
    ],
    others: Annotated[
        list[str],
        typer.Argument(
            metavar="B...",
            help="What it is held against; as A. Several are units that were measured.",
        ),
    ],
    *,
    inputs: Inputs,
    asked: Asked,
    out: options.OutputFiles,
) -> None:
    """Set two budgets side by side, the largest change first.

    Largest is by the difference over A's standard uncertainty of the output; of a
    number that belongs to no output, over itself. Each difference is attributed to the
    inputs that differ: A's keys are exchanged one at a time for those of B, and the
    budget is computed by GUM propagation.

    A device is analyzed by GUM propagation; beside a reference, with the procedure, the
    requirement and the settings of that. The numbers of a reference are the stored
    ones. Exit code 0 whatever differs.

    Where B is a device file of recordings and A is none, it is the unit beside its data
    sheet: each figure printed and measured, their ratio with its 95 % interval, and
    what is worse than printed; of several units, the lot and its spread. -o writes that
    as a page.

    Two results of `budget calibrate --json` are two calibrations of a unit: what moved
    beyond its uncertainty and, with --procedure, whether that is the size of a known
    mistake. Beside a device file they are units of a lot: how much each parameter
    spreads.

    --set changes the devices of the call as elsewhere; of a device beside itself it
    changes B: what does this value do?
    """
    from budget.cli.output import check_files, hand_out
    from budget.errors import CallError
    from budget.inputs import load_device
    from budget.inputs.records import CHANGED
    from budget.recordings.lot import lot_of
    from budget.recordings.results import is_result, read_results
    from budget.references.check import compare_sides, make_reference, side_of
    from budget.references.records import Stored
    from budget.report.calibrated import calibrated_lot_answer, change_answer
    from budget.report.document import json_of, json_text, table_csv
    from budget.report.reference import difference_sections, moved

    names = (first, others[0])
    check_files(out, inputs, (first, *others))
    stated = options.given(context, Asked, Inputs)
    if all(map(is_result, (first, *others))):
        _check_taken("two calibrations", stated, {"procedure"}, out.output)
        change = _change(first, others, inputs)
        hand_out(
            [
                (out.json, lambda: json_text(change.to_dict())),
                (out.csv, lambda: table_csv("changed_parameter", change.parameters)),
            ],
            lambda: change_answer(change),
            language=out.language,
        )
        return
    if all(map(is_result, others)):
        _check_taken("units of a lot", stated, {"changes"}, out.output)
        lot = lot_of(load_device(first, inputs.changes), read_results(others))
        hand_out(
            [
                (out.json, lambda: json_text(lot.to_dict())),
                (out.csv, lambda: table_csv("lot_spread", lot.parameters)),
            ],
            lambda: calibrated_lot_answer(lot),
            language=out.language,
        )
        return
    stored = [_reference(name) for name in names]
    given = Stored.of(asked, inputs)
    own = [flag for name, flag in stated.items() if name != "changes"]
    if any(stored) and own:
        raise CallError(
            "a reference has its own procedure, mission and settings, and a device "
            f"beside it takes them; leave {' and '.join(own)} out"
        )
    model = next((one for one in stored if one is not None), None)
    job = JOBS[inputs.mission is not None] if model is None else model.job
    taken = [
        None if one else _inputs(name, model, inputs)
        for name, one in zip(names, stored, strict=True)
    ]
    taken = _changed(taken, inputs.changes, job)
    if model is None and (made := _measured(first, others, inputs)) is not None:
        _check_taken("units that were measured", stated, {"procedure"})
        _hand_out_measured(context, out, made)
        return
    if len(others) > 1:
        raise CallError(
            f"{len(others) + 1} are given, expected 2: several are held beside a data "
            "sheet where each is a device file of recordings (`budget characterise`)"
        )
    _check_taken("two budgets", stated, stated, out.output)
    settings = given if model is None else model.settings
    sides = []
    for name, one, files in zip(names, stored, taken, strict=True):
        budget = one or make_reference(job, files or (), settings)
        changed = any(file.changes for file in files or ())
        shown = f"{name}{CHANGED}" if changed else name
        sides.append(side_of(budget, name=shown, is_fresh=one is None))
    difference = compare_sides(*sides)
    hand_out(
        [
            (out.json, lambda: json_of(difference, "difference")),
            (out.csv, lambda: table_csv("moved", moved([difference]))),
        ],
        lambda: difference_sections(difference),
        language=out.language,
    )


def _check_taken(
    what: str,
    stated: Mapping[str, str],
    taken: Collection[str],
    pages: Sequence[Path] = (),
) -> None:
    """Refuse pages of what has none, and options that it would leave out in silence.

    Raises
    ------
    CallError
        A page is asked for, or an option is not among those that are taken.
    """
    from budget.errors import CallError

    if pages:
        raise CallError(
            f"-o {pages[0]}: of {what} there is no page; it is of a device file of "
            "recordings (`budget characterise`) beside a data sheet"
        )
    idle = [flag for name, flag in stated.items() if name not in taken]
    if idle:
        raise CallError(
            f"nothing of {what} changes with {' and '.join(idle)}; leave that out"
        )


def _change(first: str, others: Sequence[str], inputs: Inputs) -> CalibrationChange:
    """Hold two results of a calibration beside each other.

    Raises
    ------
    CallError
        They are more than two.
    """
    from budget.errors import CallError
    from budget.recordings.results import change_between, read_results

    if len(others) > 1:
        raise CallError(f"{len(others) + 1} calibrations are given, expected 2")
    how = None if inputs.procedure is None else inputs.calibrated()
    one, two = read_results((first, *others))
    return change_between(one, two, how)


def _reference(name: str) -> ReferenceBudget | None:
    """Read a stored reference; None where the name is of a device."""
    from budget.inputs.files import find
    from budget.references.files import find_references, shipped_references
    from budget.references.store import read_reference

    ships = {one.shown for one in shipped_references()}
    is_bare = name in ships and not find(name, "device").path.is_file()
    if not (name.endswith(SUFFIX) or is_bare):
        return None
    (found,) = find_references(name)
    return read_reference(found.path, found.shown)


def _measured(
    first: str, others: Sequence[str], inputs: Inputs
) -> MeasuredUnit | MeasuredLot | None:
    """Hold units beside A, where they were measured and A was not; else None."""
    from budget.inputs import load_device, load_procedure
    from budget.recordings.printed import (
        beside_data_sheet,
        is_measured,
        lot_beside_data_sheet,
    )

    printed, *units = map(load_device, (first, *others))
    if is_measured(printed) or not all(map(is_measured, units)):
        return None
    rate = load_procedure(inputs.procedure).sample_rate
    if len(units) > 1:
        return lot_beside_data_sheet(printed, units, sample_rate=rate)
    return beside_data_sheet(printed, units[0], sample_rate=rate)


def _hand_out_measured(
    context: typer.Context, out: options.OutputFiles, made: MeasuredUnit | MeasuredLot
) -> None:
    """Write and print units beside their data sheet."""
    from budget.cli.output import hand_out, pages_asked
    from budget.recordings.printed import MeasuredLot
    from budget.report import measured as pages
    from budget.report.document import json_text, table_csv

    is_lot = isinstance(made, MeasuredLot)
    answer: Any = pages.lot_answer if is_lot else pages.measured_answer
    page: Any = pages.lot_document if is_lot else pages.measured_document
    row = "lot_line" if is_lot else "measured_line"
    hand_out(
        [
            (out.json, lambda: json_text(made.to_dict())),
            (out.csv, lambda: table_csv(row, made.lines)),
        ],
        lambda: answer(made),
        pages=pages_asked(context, out, partial(page, made)),
        language=out.language,
    )


def _inputs(
    name: str, model: ReferenceBudget | None, inputs: Inputs
) -> tuple[StoredInput, ...]:
    """Return a device, and what it is calibrated with."""
    from budget.cli.check import take_all
    from budget.errors import CallError
    from budget.references.files import take

    if model is not None and model.job not in JOBS:
        raise CallError(
            f"{name} is a device, and the reference beside it is of kind {model.job}; "
            "give two references of that kind, or one of kind analyze or mission"
        )
    # Nothing is stored, so paths do not matter.
    if model is None:
        return take_all([name], inputs)
    return (
        take("device", name),
        *(one for one in model.inputs if one.role != "device"),
    )


def _changed(
    sides: list[tuple[StoredInput, ...] | None], changes: Sequence[str], job: Job
) -> list[tuple[StoredInput, ...] | None]:
    """Lay changes over the devices of both sides; of two that are one, over B's."""
    from budget.references.files import with_changes

    first, second = sides
    if first == second:
        return [first, with_changes(second or (), changes, job=job)]
    both = with_changes((*(first or ()), *(second or ())), changes, job=job)
    count = len(first or ())
    return [first and both[:count], second and both[count:]]
