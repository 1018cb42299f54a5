"""`budget mission`: what the errors do to navigation, and their main contributors."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer  # noqa: TC002 - typer reads the annotations

from budget.cli import options
from budget.cli.analyze import compute


@options.spell_out_but("reference", "outputs", "matrices")
def mission(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    mission: Annotated[Path, options.MISSION],
    at: options.At = None,
    requirement: options.RequirementFile = None,
    changes: options.Changes = None,
    calibration: options.Calibration = None,
    procedure: options.ProcedureFile = None,
    station: options.StationFile = None,
    age: options.Age = None,
    environment: options.Environment = None,
    asked: options.Asked,
    exit_code: options.ExitCode = False,
    accept: options.Accept = "meets",
    full: options.Full = False,
    output: Annotated[list[Path] | None, options.OUTPUT] = None,
    paper: options.Paper = "a4",
    _templates: options.Templates = None,
    language: options.Language = "en",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Say how far off navigation is after a calibration, and the main contributors.

    Position (CEP, R95, DRMS), velocity and attitude at some times of a mission, with
    the residual errors after calibration at a later turn-on and the noise in run. With
    limits on a mission in the requirement the verdict comes first; the exit code is 0
    whatever it is, but for --exit-code.
    """
    from budget.cli.output import deliver, pages_asked
    from budget.report.analysis.mission import mission_document
    from budget.report.rendering import check_suffixes

    check_suffixes(output or [], paper)
    options.check_exit_code(requirement, exit_code=exit_code, accept=accept)
    budget = compute(
        devices,
        requirement=requirement,
        changes=changes,
        mission=mission,
        at=at,
        calibration=calibration,
        procedure=procedure,
        station=station,
        age=age,
        environment=environment,
        asked=asked,
        documents=(json, csv, *(output or ())),
        command="mission",
    )
    make = partial(mission_document, budget)
    deliver(
        budget,
        json=json,
        csv=csv,
        pages=pages_asked(context, output, paper, language, make),
        full=full,
        language=language,
    )
    options.exit_by(budget.assessment, exit_code=exit_code, accept=accept)
