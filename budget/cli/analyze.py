"""`budget analyze`: the budget of every parameter, its contributions ranked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from budget.cli import options

if TYPE_CHECKING:
    from budget.results import Budget


@options.spell_out
def analyze(
    devices: options.Devices = None,
    *,
    requirement: options.RequirementFile = None,
    changes: options.Changes = None,
    mission: Annotated[Path | None, options.MISSION] = None,
    at: options.At = None,
    calibration: options.Calibration = None,
    procedure: options.ProcedureFile = None,
    station: options.StationFile = None,
    age: options.Age = None,
    environment: options.Environment = None,
    asked: options.Asked,
    exit_code: options.ExitCode = False,
    accept: options.Accept = "meets",
    full: options.Full = False,
    language: options.Language = "en",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Compute the error budget of a calibration, or of a mission after it.

    For every scale factor, mounting angle and bias: its expected error, standard
    uncertainty and coverage interval, and what each specification contributes. Of
    a mission what `budget mission` says. With a requirement the verdict comes first;
    the exit code is 0 whatever it is, but for --exit-code.
    """
    from budget.cli.output import deliver
    from budget.errors import CallError

    if mission is None and at:
        raise CallError("--at is a time of a mission: name one with --mission")
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
        documents=(json, csv),
        command="analyze",
    )
    deliver(budget, json=json, csv=csv, full=full, language=language)
    options.exit_by(budget.assessment, exit_code=exit_code, accept=accept)


def compute(
    devices: list[str] | None,
    *,
    requirement: Path | None,
    changes: list[str] | None,
    mission: Path | None,
    at: list[float] | None,
    calibration: str | None,
    procedure: Path | None,
    station: Path | None,
    age: str | None,
    environment: str | None,
    asked: options.Asked,
    documents: tuple[Path | None, Path | None, *tuple[Path, ...]],
    command: str,
) -> Budget:
    """Load what is named and compute its budget, of a mission where there is one."""
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations
    from budget.question import Question
    from budget.studies.analysis import analyze_as

    check_destinations(
        *documents,
        inputs=[
            *(devices or ()),
            *options.calibration_files(calibration, procedure),
            *(mission, station, requirement),
        ],
    )
    settings = asked.settings(None)
    question = Question.load(
        *options.load_devices(devices, changes),
        procedure=procedure,
        calibration=calibration,
        station=station,
        age=age,
        environment=environment,
        requirement=requirement,
        mission=mission,
        at=at or (),
        coverage=asked.coverage,
        reference=asked.reference,
        only=settings.only,
        outputs=settings.outputs,
        missing=asked.missing,
    )
    with computing(workers=asked.workers, cluster=asked.cluster) as engine:
        return analyze_as(settings, question, engine=engine, command=command)
