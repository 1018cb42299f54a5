"""`budget allocate`: a requirement in, allowable specification values out."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options
from budget.cli.streams import talk
from budget.settings import Asked, Engine, Inputs

if TYPE_CHECKING:
    from budget.inputs.records import Sensor
    from budget.names import Name


@options.asking("allocate")
def allocate(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    inputs: Inputs,
    costs: Annotated[
        Path | None,
        options.computed(
            metavar="FILE", help="Costs file; other specifications have a = p = 1."
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
    asked: Asked,
    out: options.OutputFiles,
) -> None:
    """Find the standard uncertainty that each specification may have.

    The device is where it starts. Exit code 1 where what is allocated meets the
    requirement only on conditions or cannot be judged; 1, and no file written, where
    the requirement cannot be met.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_files, check_yaml, hand_out, pages_asked
    from budget.inputs import load_costs
    from budget.question import find_sources, sensors_of, source_names
    from budget.report.allocation import (
        allocated_device,
        allocation_answer,
        allocation_document,
    )
    from budget.report.document import json_text, table_csv
    from budget.studies.allocation.allocate import allocate as run
    from budget.studies.allocation.cases import Bounds

    check_files(out, inputs, devices, write, more=[costs])
    check_yaml(write, "device")
    loaded = options.load_devices(devices, inputs.changes)
    sensors = sensors_of(loaded)
    bounds = Bounds(
        held=frozenset(find_sources(asked.fix, source_names(sensors), option="--fix")),
        most=_values(sensors, "--max", most or []),
        least=_values(sensors, "--min", least or []),
    )
    with computing(Engine()) as engine:
        allocation = run(
            *loaded,
            costs=None if costs is None else load_costs(costs),
            bounds=bounds,
            market=market,
            inputs=inputs,
            asked=asked,
            engine=engine,
        )

    show = partial(
        hand_out,
        sections=lambda: allocation_answer(allocation, full=out.full),
        title=allocation.title,
        language=out.language,
    )
    written = pages_asked(context, out, partial(allocation_document, allocation))
    if write is not None and allocation.feasible:
        written[write] = _read_back(allocated_device(allocation), write)
    documents = (
        (out.json, lambda: json_text(allocation.to_dict())),
        (out.csv, lambda: table_csv("allotment", allocation.sources)),
    )
    if allocation.feasible:
        show(documents, pages=written)
        if not allocation.is_met(options.accepted(out.accept)):
            raise typer.Exit(options.EXIT_NOT_MET)
        return
    show([one for one in documents if one[0] == options.STDOUT], pages=written)
    if any(path not in {None, options.STDOUT} for path in (out.json, out.csv, write)):
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
