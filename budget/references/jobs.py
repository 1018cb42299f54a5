"""What a reference is of, a budget, a comparison, an allocation; computed anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from budget.errors import CallError
from budget.inputs.costs import read_costs
from budget.inputs.device import read_device
from budget.inputs.files import NamedFile
from budget.inputs.load import load_calibration
from budget.inputs.mission import read_mission
from budget.inputs.procedure import read_procedure
from budget.inputs.records import CHANGED
from budget.inputs.requirement import read_requirement
from budget.inputs.station import done_at, named_station, read_station
from budget.methods.execution import small_blocks
from budget.model.sources import STATION
from budget.names import MISSION
from budget.question import (
    Question,
    find_sources,
    question_of,
    refuse_unjudged,
    sensors_of,
    source_names,
)
from budget.recordings.measured_unit import measured_units
from budget.references.quantities import device_of, snapshot_of
from budget.references.records import (
    FILES,
    JOBS,
    RESULT,
    STORED,
    Stored,
    files_fault,
)
from budget.references.sampling import standard_errors
from budget.results import BY_TRIALS
from budget.settings import Use, rows
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import Bounds
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.studies.judgement import TRIALS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device, Mission, Procedure, Requirement
    from budget.inputs.tree import YamlFile
    from budget.references.records import Snapshot
    from budget.results import Budget

# What means nothing to a job here: an allocation is stored without its correction.
IDLE = {"allocate": {"seed"}}
_NAMES = {"samples": "sobol and --samples", "max_trials": "max-trials"}


def check_asked(job: str, asked: Stored) -> None:
    """Refuse settings that mean nothing to a job.

    Raises
    ------
    CallError
        With all of them.
    """
    if job not in JOBS:
        raise CallError(f"kind is {job!r}, allowed: {', '.join(JOBS)}")
    usual = Stored()
    means = rows(Stored, job).keys() - IDLE.get(job, set())
    strange = [
        f"--{_NAMES.get(name, name)}"
        for name in STORED
        if name not in means and getattr(asked, name) != getattr(usual, name)
    ]
    if strange:
        raise CallError(
            f"{', '.join(strange)}: means nothing to a reference of kind {job}; leave "
            "it out, or take another --kind"
        )


def compute(
    job: str, inputs: Sequence[YamlFile], asked: Stored, *, workers: int = 1
) -> Snapshot:
    """Do a job on its inputs, devices first, in the order they were given.

    Raises
    ------
    CallError, SpecError
        Inputs or settings do not fit together, or a file is not sound.
    """
    by_role = {
        one.kind: [own for own in inputs if own.kind == one.kind] for one in inputs
    }
    devices = [read_device(one) for one in _told_apart(by_role.get("device", []))]
    procedures = _procedures(by_role.get("procedure", []), by_role.get(STATION, []))
    limits = [read_requirement(one) for one in by_role.get("requirement", [])]
    mission = next(map(_mission, by_role.get(MISSION, [])), None)
    costs = [read_costs(one) for one in by_role.get("costs", [])]
    results = [
        NamedFile(
            path=Path(one.base_name),
            shown=one.file,
            variant="",
            content=one.text.encode(),
        )
        for one in _told_apart(by_role.get(RESULT, []))
    ]
    fault = files_fault(job, [one.kind for one in inputs])
    _refuse(
        (
            mission is None and any(MISSION in one.kinds for one in limits),
            (
                "the requirement has limits on a mission, and none is given; take "
                "those limits out, or give --mission FILE"
            ),
        ),
        (
            job != "compare" and len(procedures) > 1,
            (
                f"{len(procedures)} procedures were given, a reference of kind {job} "
                "takes one; give one, or take --kind compare"
            ),
        ),
        (
            0 not in FILES[job]["requirement"] and not limits,
            f"a reference of kind {job} needs a requirement; give --requirement FILE",
        ),
        (fault, f"found {fault}; give as many, or take another --kind"),
        (
            results and any(one.origin.file.endswith(CHANGED) for one in devices),
            (
                "a reference of a measured unit has its data sheet as it was "
                "calibrated with; leave --set out, or keep the JSON of `budget analyze`"
            ),
        ),
    )
    with_maker = mission is not None and not procedures
    procedures = [
        load_calibration(
            asked.calibration or ("factory" if with_maker else None),
            one,
            age=asked.age,
            environment=asked.environment,
        )
        for one in procedures or (None,)
    ]
    for one in limits if mission is not None else ():
        refuse_unjudged(one, mission, procedures[0])
    given = {
        name: value
        for name in rows(Stored, job).keys() & STORED.keys() - rows(Use, job).keys()
        if (value := getattr(asked, name)) is not None
    }
    given = {n: v for n, v in given.items() if n not in IDLE.get(job, set())}
    # The matrices are small, threads of BLAS only wait for each other; and with one the
    # order of every sum is the same on any machine.
    with small_blocks():
        if job in {"analyze", MISSION}:
            budget = analyze(
                *devices,
                procedure=procedures[0],
                requirement=limits[0] if limits else None,
                mission=mission,
                validate=False,
                workers=workers,
                command=job,
                measured=results,
                **given,
            )
            return _snapshot(budget)
        if job == "compare":
            given |= {"workers": workers, "mission": mission, "measured": results}
            return _compare(devices, procedures, limits[0], given)
        known = source_names(sensors_of(devices))
        held = find_sources(given.pop("fix"), known, option="--fix")
        # Limits are shared out by the law, without the catalogue.
        allocation = allocate(
            *devices,
            requirement=limits[0],
            procedure=procedures[0],
            mission=mission,
            costs=costs[0] if costs else None,
            bounds=Bounds(held=frozenset(held), most={}, least={}),
            catalogue=(),
            validate=False,
            **given,
        )
        return snapshot_of(allocation.to_dict(), {})


def _refuse(*wrong: tuple[object, str]) -> None:
    """Refuse the first of several things that is so.

    Raises
    ------
    CallError
    """
    for is_so, text in wrong:
        if is_so:
            raise CallError(text)


def _procedures(
    procedures: Sequence[YamlFile], stations: Sequence[YamlFile]
) -> list[Procedure]:
    """Read procedures with their station: that which some name, else that of all.

    Raises
    ------
    CallError
        One names a station that is not there: none is looked for.
    SpecError
        A file is not sound, or there are two stations.
    """
    named = [one for one in procedures if named_station(one)]
    station = stations[0] if stations else None
    files = ", ".join(one.file for one in stations)
    first = (f"{one.file} names the station {named_station(one)}" for one in named)
    _refuse(
        (
            stations[1:],
            (
                f"found the stations {files}, a reference takes one; where a procedure "
                "names its station, leave --station out"
            ),
        ),
        (
            named and not stations,
            (
                f"{next(first, '')}, which is not among the inputs; save the reference "
                "again"
            ),
        ),
        (
            stations and not procedures,
            (
                f"{files}: is a station, and no procedure is given that is done there; "
                "give --procedure FILE, or leave --station out"
            ),
        ),
    )
    found = []
    for one in procedures:
        procedure = read_procedure(one, station if one in named else None)
        if station is not None and not named:
            procedure = done_at(procedure, read_station(station), one.file)
        found.append(procedure)
    return found


def by_law(asked: Stored) -> Stored:
    """Return the same settings with the law in the place of trials."""
    return replace(asked, method="gum", trials=None, max_trials=None, samples=None)


def _snapshot(budget: Budget) -> Snapshot:
    """Return what a budget states, with the standard errors of what trials made."""
    settings = budget.settings
    # By the law some intervals are of trials all the same.
    is_drawn = any(row.interval_by == BY_TRIALS for row in budget.outputs)
    trials = settings.trials or (TRIALS if is_drawn else None)
    sure = trials is not None and standard_errors(
        question_of(budget).problem,
        trials=trials,
        coverage=settings.coverage,
        interval=settings.interval,
    )
    return snapshot_of(budget.to_dict(), {"": sure} if sure else {})


def _mission(document: YamlFile) -> Mission:
    """Read a mission; what a trajectory is in is a file that nobody stored.

    Raises
    ------
    CallError
        It takes its route from one: that is not opened.
    """
    part = document.root.child("mission")
    if part is not None and part.child("trajectory") is not None:
        raise CallError(
            f"{document.file}: takes its route from a recorded trajectory, which a "
            "reference does not store; expected a mission of segments: give one, or "
            "keep the JSON of `budget mission`"
        )
    return read_mission(document)


def _compare(
    devices: Sequence[Device],
    procedures: Sequence[Procedure],
    requirement: Requirement,
    given: dict[str, Any],
) -> Snapshot:
    """Compare devices; what missing lines could do hangs on the catalogue."""
    comparison = compare(devices, requirement, procedures, **given)
    document = comparison.to_dict()
    units = measured_units(devices, given["measured"], procedures)
    every = (*devices, *(unit for _, unit in units))
    tests = {one.name: one for one in procedures}
    errors = {}
    for one, row in zip(comparison.devices, document["devices"], strict=True):
        if row["trials"] is not None:
            device, how = every[one.place], tests[row["procedure"]]
            is_carried = row["sensor"] == MISSION
            question = Question.of(
                device,
                procedure=how,
                requirement=requirement,
                mission=given["mission"] if is_carried else None,
                carried_to=() if is_carried else None,
            )
            errors[device_of(document, row)] = standard_errors(
                question.alone(row["sensor"]).problem,
                trials=row["trials"],
                coverage=requirement.coverage,
            )
    return snapshot_of(document, errors)


def _told_apart(devices: Sequence[YamlFile]) -> list[YamlFile]:
    """Count the devices whose files have one name."""
    names = [one.base_name for one in devices]
    return [
        one
        if names.count(name) == 1
        else replace(one, base_name=f"{name} ({names[: k + 1].count(name)})")
        for k, (one, name) in enumerate(zip(devices, names, strict=True))
    ]
