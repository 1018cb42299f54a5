"""`budget allocate`: a requirement in, allowable specification values out."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from budget.cli import options
from budget.cli.streams import talk

if TYPE_CHECKING:
    from budget.inputs.records import Sensor
    from budget.names import Name


def allocate(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    changes: options.Changes = None,
    requirement: Annotated[Path, options.REQUIREMENT],
    procedure: options.ProcedureFile = None,
    mission: Annotated[Path | None, options.MISSION] = None,
    calibration: options.Calibration = None,
    station: options.StationFile = None,
    age: options.Age = None,
    environment: options.Environment = None,
    strategy: Annotated[
        Literal["equal", "proportional", "cost"] | None,
        options.computed(
            case_sensitive=False,
            help="How limits are shared out (proportional; cost where --costs is).",
            show_default=False,
        ),
    ] = None,
    costs: Annotated[
        Path | None,
        options.computed(
            metavar="FILE", help="Costs file; other specifications have a = p = 1."
        ),
    ] = None,
    fix: Annotated[
        list[str] | None,
        options.computed(
            metavar="SOURCE",
            autocompletion=options.complete_source,
            help="Hold this specification, as gyro.bias_stability; may be given again.",
            show_default=False,
        ),
    ] = None,
    most: Annotated[
        list[str] | None,
        options.computed(
            "--max",
            autocompletion=options.complete_line,
            metavar="SOURCE=VALUE",
            help="Largest value, as 'bias_stability=0.1 deg/h' (scale "
            "factors 1 %, angles 1 deg, others 100 times the present value).",
            show_default=False,
        ),
    ] = None,
    least: Annotated[
        list[str] | None,
        options.computed(
            "--min",
            autocompletion=options.complete_line,
            metavar="SOURCE=VALUE",
            help="Least value of a specification, largest axis, 1 sigma.",
            show_default=False,
        ),
    ] = None,
    market: Annotated[
        bool,
        options.computed(
            "--market",
            help="No specification better than the best in the catalogue, or now.",
        ),
    ] = False,
    write: Annotated[
        Path | None,
        options.written(
            metavar="FILE.yaml", help="Write the allocated device as a device file."
        ),
    ] = None,
    seed: options.Seed = 0,
    no_validate: options.NoValidate = False,
    accept: options.Accept = "meets",
    full: options.Full = False,
    output: Annotated[list[Path] | None, options.OUTPUT] = None,
    paper: options.Paper = "a4",
    _templates: options.Templates = None,
    language: options.Language = "en",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Find the standard uncertainty that each specification may have.

    The device is where it starts. Exit code 1 where what is allocated meets the
    requirement only on conditions or cannot be judged; 1, and no file written, where
    the requirement cannot be met.
    """
    from budget.cli.computing import computing
    from budget.cli.output import (
        check_destinations,
        check_yaml,
        hand_out,
        pages_asked,
    )
    from budget.inputs import load_costs, load_requirement
    from budget.question import find_sources, sensors_of, source_names
    from budget.report.allocation.document import allocated_device
    from budget.report.allocation.page import (
        allocation_answer,
        allocation_document,
    )
    from budget.report.document import json_text, table_csv
    from budget.report.rendering import check_suffixes
    from budget.studies.allocation.allocate import allocate as run
    from budget.studies.allocation.cases import Bounds

    others = (*(output or ()), *(() if write is None else (write,)))
    check_suffixes(output or [], paper)
    check_destinations(
        json,
        csv,
        *others,
        inputs=[
            *(devices or ()),
            *options.calibration_files(calibration, procedure),
            *(mission, station, requirement, costs),
        ],
    )
    check_yaml(write, "device")
    loaded = options.load_devices(devices, changes)
    wanted = load_requirement(requirement)
    sensors = sensors_of(loaded)
    bounds = Bounds(
        held=frozenset(find_sources(fix or (), source_names(sensors), option="--fix")),
        most=_values(sensors, "--max", most or []),
        least=_values(sensors, "--min", least or []),
    )
    with computing(workers=1, cluster=None) as engine:
        allocation = run(
            *loaded,
            requirement=wanted,
            procedure=procedure,
            mission=mission,
            calibration=calibration,
            station=station,
            age=age,
            environment=environment,
            strategy=strategy,
            costs=None if costs is None else load_costs(costs),
            bounds=bounds,
            market=market,
            validate=not no_validate,
            seed=seed,
            progress=engine.progress,
        )

    show = partial(
        hand_out,
        sections=lambda: allocation_answer(allocation, full=full),
        title=allocation.title,
        language=language,
    )
    make = partial(allocation_document, allocation)
    written = pages_asked(context, output, paper, language, make)
    if write is not None and allocation.feasible:
        written[write] = _read_back(allocated_device(allocation), write)
    documents = (
        (json, lambda: json_text(allocation.to_dict())),
        (csv, lambda: table_csv("allotment", allocation.sources)),
    )
    if allocation.feasible:
        show(documents, pages=written)
        if not allocation.is_met(options.accepted(accept)):
            raise typer.Exit(options.EXIT_NOT_MET)
        return
    show([one for one in documents if one[0] == options.STDOUT], pages=written)
    if any(path not in {None, options.STDOUT} for path in (json, csv, write)):
        other = "other " if written else ""
        talk(f"the requirement cannot be met: no {other}file was written")
    raise typer.Exit(options.EXIT_NOT_MET)


def _values(
    sensors: tuple[Sensor, ...], option: str, texts: list[str]
) -> dict[Name, float]:
    """Read SOURCE=VALUE [SI]; every unit of the line will do."""
    from budget.errors import CallError, UnitError
    from budget.inputs.specification import standard_size
    from budget.model.sources import source_of
    from budget.question import find_sources, source_names
    from budget.units import parse_quantity

    kinds = {sensor.kind: sensor for sensor in sensors}
    values: dict[Name, float] = {}
    for text in texts:
        name, sign, printed = text.partition("=")
        if not sign:
            raise CallError(
                f"{option}: found {text!r}, expected SOURCE=VALUE, as "
                "'bias_stability=0.1 deg/h'"
            )
        for full in find_sources([name.strip()], source_names(sensors), option=option):
            given = kinds[full.owner].line(full.quantity)
            unit = source_of(full.owner, full.quantity).like(full.owner)
            try:
                gravity = kinds[full.owner].gravity_unit
                quantity = parse_quantity(printed, unit, gravity=gravity)
                value = standard_size(quantity, given.density if given else "")
                value *= given.factor if given else 1.0
            except UnitError as error:
                raise CallError(f"{option} {name.strip()}: {error}") from None
            if value <= 0.0:
                raise CallError(
                    f"{option} {name.strip()}: found {printed.strip()!r}, expected a "
                    "value above 0; to take a specification out, leave it out of the "
                    "device"
                )
            values[full] = value
    return values


def _read_back(text: str, write: Path) -> str:
    """Return the text of a device file that can be read again; refuse any other."""
    from budget.errors import CallError, SpecError
    from budget.inputs.device import read_device
    from budget.inputs.reader import parse

    try:
        read_device(parse(text.encode(), str(write), base_name=write.name))
    except SpecError as error:
        raise CallError(
            f"--write: nothing was written, as it could not be read back: {error}"
        ) from None
    return text
