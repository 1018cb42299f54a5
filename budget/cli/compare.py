"""`budget compare`: which devices meet a requirement, by what margin, and why not."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from budget.cli import options
from budget.cli.streams import talk

EXIT_BAD_INPUT = 2


def compare(
    context: typer.Context,
    devices: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[DEVICE]",
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
    changes: options.Changes = None,
    requirement: Annotated[Path, options.REQUIREMENT],
    procedure: Annotated[
        list[Path] | None,
        typer.Option(
            "--procedure",
            metavar="FILE",
            help="Procedure file (the paper's); may be given again.",
        ),
    ] = None,
    mission: Annotated[Path | None, options.MISSION] = None,
    calibration: options.Calibration = None,
    station: options.StationFile = None,
    age: options.Age = None,
    environment: options.Environment = None,
    method: Annotated[
        Literal["gum", "monte-carlo"],
        typer.Option(case_sensitive=False, help="gum is the fast screen."),
    ] = "monte-carlo",
    trials: Annotated[int | None, options.FIRST_TRIALS] = None,
    max_trials: Annotated[int | None, options.MOST_OF_A_DEVICE] = None,
    seed: options.Seed = 0,
    workers: options.Workers = 1,
    cluster: options.Cluster = None,
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
    missing: options.Missing = "refuse",
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            help="Compute nothing if any file is bad, or a calibration takes any "
            "device beyond its range.",
        ),
    ] = False,
    validate: Annotated[
        bool,
        typer.Option("--validate", help="By gum: check every one by Monte Carlo."),
    ] = False,
    accept: options.Accept = "meets",
    full: options.Full = False,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
    output: Annotated[list[Path] | None, options.OUTPUT] = None,
    paper: options.Paper = "a4",
    _templates: options.Templates = None,
    language: options.Language = "en",
) -> None:
    """Compare devices against a requirement, best first.

    For every sensor, and every IMU as one device: who meets, by what part of the limit
    and with what probability, and which specification limits it. Exit code 1 if a
    required sensor has no device that meets.
    """
    from budget.cli.computing import computing
    from budget.cli.output import (
        check_destinations,
        command_line,
        hand_out,
        pages_of,
    )
    from budget.errors import CallError, SpecError
    from budget.inputs import load_requirement
    from budget.inputs.load import shipped_path, try_changed
    from budget.language import speaking
    from budget.missing import shipped_devices
    from budget.report.comparison.document import json_pieces, to_csv
    from budget.report.comparison.page import comparison_answer, comparison_document
    from budget.report.comparison.tables import find_column
    from budget.report.rendering import check_suffixes, document_date
    from budget.studies.comparison.compare import compare as run
    from budget.studies.judgement import TRIALS

    check_destinations(
        json,
        csv,
        *(output or ()),
        inputs=[
            *(devices or ()),
            *options.calibration_files(calibration, *(procedure or ())),
            mission,
            station,
            requirement,
        ],
    )
    check_suffixes(output or [], paper)
    if not devices and not catalogue:
        raise CallError("nothing to compare; name device files, or give --catalogue")
    if (kind or grade) and not catalogue:
        raise CallError("--kind and --grade choose from the catalogue; add --catalogue")
    column = None if sort is None else find_column(sort)
    wanted = load_requirement(requirement)
    every = shipped_devices()
    chosen = options.select_catalogue(kind, grade) if catalogue else ()
    loaded, issues = try_changed(
        [*(devices or ()), *map(shipped_path, chosen)], changes or (), variants=True
    )
    # What is named and ships too is compared once.
    loaded = list(
        {(one.origin.file, one.origin.sha256): one for one in loaded}.values()
        if catalogue
        else loaded
    )
    if strict and issues:
        raise SpecError(tuple(issues))
    for issue in issues:
        talk(str(issue))
    if not loaded:
        raise CallError("none of the device files can be read; mend them and try again")

    with computing(workers=workers, cluster=cluster) as engine:
        found = run(
            loaded,
            wanted,
            procedure or (),
            mission=mission,
            calibration=calibration,
            station=station,
            age=age,
            environment=environment,
            catalogue=every,
            missing=missing,
            method=method,
            trials=trials or TRIALS,
            max_trials=max_trials,
            validate=validate,
            pairs=pairs,
            strict=strict,
            seed=seed,
            workers=engine.workers,
            executor=engine.executor,
            progress=engine.progress,
        )
    pages: dict[Path, str | bytes] = {}
    if output:
        command = command_line(context)
        with speaking(language):
            document = comparison_document(
                found, date=document_date(), command_line=command
            )
        pages = pages_of(document, output, paper)
    hand_out(
        [(json, lambda: json_pieces(found)), (csv, lambda: [to_csv(found)])],
        lambda: comparison_answer(
            found, order=None if column is None else column.order, full=full
        ),
        pages=pages,
        language=language,
    )
    if issues:
        raise typer.Exit(EXIT_BAD_INPUT)
    if found.not_compared or not found.has(options.accepted(accept)):
        raise typer.Exit(options.EXIT_NOT_MET)
