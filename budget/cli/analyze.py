"""`budget analyze`: the budget of every parameter, its contributions ranked."""

from __future__ import annotations

from typing import Annotated

import typer

from budget.cli import options


@options.spell_out
def analyze(
    devices: options.Devices = None,
    *,
    requirement: options.RequirementFile = None,
    changes: options.Changes = None,
    procedure: options.ProcedureFile = None,
    station: options.StationFile = None,
    age: options.Age = None,
    asked: options.Asked,
    brief: Annotated[
        bool,
        typer.Option(
            "--brief", help="Print the worst axis of each parameter, and no more."
        ),
    ] = False,
    language: options.Language = "en",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Compute the error budget of a calibration.

    For every scale factor, mounting angle and bias: its expected error, standard
    uncertainty and coverage interval, and what each specification line contributes.
    With a requirement the verdict comes first, and the exit code is 0 whatever it is.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations, deliver
    from budget.spec import load_procedure, load_requirement
    from budget.studies.analysis import analyze_as

    check_destinations(
        json, csv, inputs=[*(devices or ()), procedure, station, requirement]
    )
    loaded = options.load_devices(devices, changes)
    wanted = None if requirement is None else load_requirement(requirement)
    with computing(workers=asked.workers, cluster=asked.cluster) as engine:
        budget = analyze_as(
            asked.settings(wanted),
            *loaded,
            requirement=wanted,
            procedure=load_procedure(procedure, station=station, age=age),
            engine=engine,
        )
    deliver(budget, json=json, csv=csv, brief=brief, language=language)
