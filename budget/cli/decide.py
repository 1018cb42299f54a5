"""`budget decide`: which device to buy for a need, after which calibration."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Engine, Inputs


@options.asking("decide")
def decide(
    context: typer.Context,
    requirement: Annotated[
        Path,
        typer.Argument(
            metavar="REQUIREMENT",
            help="Requirement file: what the unit is needed for.",
            show_default=False,
        ),
    ],
    devices: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[DEVICE...]",
            autocompletion=options.complete_device,
            help="Device files to choose from; all that ship, if none is given.",
            show_default=False,
        ),
    ] = None,
    *,
    kind: options.Kinds = None,
    grade: options.Grades = None,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    out: options.OutputFiles,
) -> None:
    """Say what to buy for a need: which device, after which calibration, and why.

    On one page: the device, its calibration, the station for that, when to calibrate
    again, and what to ask the makers for of devices that cannot be judged. Exit code 1
    if nothing meets.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_files, hand_out, pages_asked
    from budget.errors import CallError
    from budget.inputs import load_catalogue, load_requirement
    from budget.inputs.load import shipped_path
    from budget.report.decision import decision_answer, decision_document
    from budget.report.document import json_text, table_csv
    from budget.studies.decide import decide as run

    check_files(out, inputs, devices, more=[requirement])
    if (kind or grade) and devices:
        raise CallError("--kind and --grade choose from the catalogue; name no device")
    wanted = load_requirement(requirement)
    names = devices or map(shipped_path, options.select_catalogue(kind, grade))
    loaded, is_partial = options.load_units(names, inputs.changes)
    with computing(engine) as place:
        found = run(
            loaded,
            wanted,
            inputs.procedures,
            inputs=replace(inputs, catalogue=load_catalogue()),
            asked=asked,
            engine=place,
        )
    hand_out(
        (
            (out.json, lambda: json_text(found.to_dict())),
            (out.csv, lambda: table_csv("offer", found.offers)),
        ),
        lambda: decision_answer(found),
        pages=pages_asked(context, out, partial(decision_document, found)),
        language=out.language,
    )
    if is_partial:
        raise typer.Exit(options.EXIT_BAD_INPUT)
    if found.not_compared or found.verdict not in options.accepted(out.accept):
        raise typer.Exit(options.EXIT_NOT_MET)
