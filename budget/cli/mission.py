"""`budget mission`: what the errors do to navigation, and which line is to blame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from budget.cli import options


@options.spell_out_but("reference", "outputs", "matrices")
def mission(
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
    asked: options.Asked,
    language: options.Language = "en",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Say how far off navigation is after a calibration, and because of which line.

    Position (CEP, R95, DRMS), velocity and attitude at some times of a mission, with
    the errors that the calibration leaves at a later turn-on and the noise in run. With
    limits on a mission in the requirement the verdict comes first, and the exit code is
    0 whatever it is.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations, deliver
    from budget.spec import load_mission, load_requirement
    from budget.studies.analysis import analyze_as
    from budget.studies.request import choose_times, limits_on_mission

    check_destinations(
        json,
        csv,
        inputs=[
            *(devices or ()),
            *options.calibration_files(calibration, procedure),
            *(mission, station, requirement),
        ],
    )
    route = load_mission(mission)
    loaded = options.load_devices(devices, changes)
    wanted = None if requirement is None else load_requirement(requirement)
    if wanted is not None:
        limits_on_mission(wanted)
    with computing(workers=asked.workers, cluster=asked.cluster) as engine:
        budget = analyze_as(
            replace(asked, reference="next_turn_on").settings(wanted),
            *loaded,
            requirement=wanted,
            procedure=options.load_calibration(
                calibration, procedure, station=station, age=age
            ),
            mission=route,
            carried_to=choose_times(route, at or (), wanted),
            engine=engine,
            command="mission",
        )
    deliver(budget, json=json, csv=csv, language=language)
