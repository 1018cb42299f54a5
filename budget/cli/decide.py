"""`budget decide`: which device to buy for a need, after which calibration."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import typer

from budget.cli import options


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
            metavar="[DEVICE]",
            autocompletion=options.complete_device,
            help="Device files to choose from; all that ship, if none is given.",
            show_default=False,
        ),
    ] = None,
    *,
    kind: options.Kinds = None,
    grade: options.Grades = None,
    changes: options.Changes = None,
    procedure: Annotated[
        list[Path] | None,
        typer.Option(
            "--procedure",
            metavar="FILE",
            help="A calibration that is at hand, the one preferred first (the "
            "paper's); may be given again.",
        ),
    ] = None,
    mission: Annotated[Path | None, options.MISSION] = None,
    station: options.StationFile = None,
    age: options.Age = None,
    environment: options.Environment = None,
    method: Annotated[
        Literal["gum", "monte-carlo"],
        typer.Option(case_sensitive=False, help="gum is the fast screen."),
    ] = "gum",
    seed: options.Seed = 0,
    workers: options.Workers = 1,
    missing: options.Missing = "refuse",
    accept: options.Accept = "meets",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
    output: Annotated[list[Path] | None, options.OUTPUT] = None,
    paper: options.Paper = "a4",
    _templates: options.Templates = None,
    language: options.Language = "en",
) -> None:
    """Say what to buy for a need: which device, after which calibration, and why.

    On one page: the device, its calibration, the station for that, when to calibrate
    again, and what to ask the makers for of devices that cannot be judged. Exit code 1
    if nothing meets.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations, hand_out, pages_asked
    from budget.errors import CallError, SpecError
    from budget.inputs import load_catalogue, load_requirement
    from budget.inputs.load import shipped_path, try_changed
    from budget.report.decision import decision_answer, decision_document
    from budget.report.document import json_text, table_csv
    from budget.report.rendering import check_suffixes
    from budget.studies.decide import decide as run

    files = [*(devices or ()), *(procedure or ()), mission, station, requirement]
    check_destinations(json, csv, *(output or ()), inputs=files)
    check_suffixes(output or [], paper)
    if (kind or grade) and devices:
        raise CallError("--kind and --grade choose from the catalogue; name no device")
    wanted = load_requirement(requirement)
    names = devices or map(shipped_path, options.select_catalogue(kind, grade))
    loaded, issues = try_changed([*names], changes or (), variants=True)
    if issues:
        raise SpecError(tuple(issues))
    with computing(workers=workers, cluster=None) as engine:
        found = run(
            loaded,
            wanted,
            procedure or (),
            mission=mission,
            station=station,
            age=age,
            environment=environment,
            catalogue=load_catalogue(),
            missing=missing,
            method=method,
            seed=seed,
            workers=engine.workers,
            progress=engine.progress,
        )
    make = partial(decision_document, found)
    hand_out(
        (
            (json, lambda: json_text(found.to_dict())),
            (csv, lambda: table_csv("offer", found.offers)),
        ),
        lambda: decision_answer(found),
        pages=pages_asked(context, output, paper, language, make),
        language=language,
    )
    if found.not_compared or found.verdict not in options.accepted(accept):
        raise typer.Exit(options.EXIT_NOT_MET)
