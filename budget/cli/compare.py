"""`budget compare`: which devices meet a requirement, by what margin, and why not."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Engine, Inputs


@options.asking("compare")
def compare(
    context: typer.Context,
    devices: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[DEVICE...]",
            autocompletion=options.complete_device,
            help="Device files; FILE is its base and every variant, FILE#VARIANT one; "
            "- is standard input.",
            show_default=False,
        ),
    ] = None,
    *,
    catalogue: Annotated[
        bool, typer.Option("--catalogue", help="Compare the devices that ship too.")
    ] = False,
    kind: options.Kinds = None,
    grade: options.Grades = None,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    pairs: Annotated[
        bool,
        typer.Option("--pairs", help="Pair every gyro with every accelerometer too."),
    ] = False,
    sort: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN",
            help="Sort the printed tables by this column (rank).",
            show_default=False,
        ),
    ] = None,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            help="Compute nothing if any file is bad, or a calibration takes any "
            "device beyond its range.",
        ),
    ] = False,
    out: options.OutputFiles,
) -> None:
    """Compare devices against a requirement, best first.

    For every sensor, and every IMU as one device: who meets, by what part of the limit
    and with what probability, and which specification limits it. Exit code 1 if a
    required sensor has no device that meets.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_files, hand_out, pages_asked
    from budget.documents import document
    from budget.errors import CallError
    from budget.inputs.load import shipped_path
    from budget.missing import shipped_devices
    from budget.report.comparison.page import comparison_answer, comparison_document
    from budget.report.comparison.tables import find_column, to_csv
    from budget.report.document import json_pieces
    from budget.spooled import Made
    from budget.studies.comparison.compare import compare as run

    check_files(out, inputs, devices)
    if not devices and not catalogue:
        raise CallError("nothing to compare; name device files, or give --catalogue")
    if (kind or grade) and not catalogue:
        raise CallError("--kind and --grade choose from the catalogue; add --catalogue")
    column = None if sort is None else find_column(sort)
    chosen = options.select_catalogue(kind, grade) if catalogue else ()
    loaded, is_partial = options.load_units(
        [*(devices or ()), *map(shipped_path, chosen)], inputs.changes, strict=strict
    )
    # What is named and ships too is compared once.
    if catalogue:
        first = {
            (one.origin.file, one.origin.sha256): place
            for place, one in reversed([*enumerate(loaded)])
        }
        loaded = Made(loaded.__getitem__, sorted(first.values())).held()

    with computing(engine) as place:
        found = run(
            loaded,
            inputs.requirement,
            inputs.procedures,
            pairs=pairs,
            strict=strict,
            inputs=replace(inputs, catalogue=shipped_devices()),
            asked=asked,
            engine=place,
        )
    make = partial(comparison_document, found)
    hand_out(
        [
            (out.json, lambda: json_pieces(document(found))),
            (out.csv, lambda: to_csv(found)),
        ],
        lambda: comparison_answer(
            found, order=None if column is None else column.order, full=out.full
        ),
        pages=pages_asked(context, out, make),
        language=out.language,
    )
    if is_partial:
        raise typer.Exit(options.EXIT_BAD_INPUT)
    if found.not_compared or not found.has(options.accepted(out.accept)):
        raise typer.Exit(options.EXIT_NOT_MET)
