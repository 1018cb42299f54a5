"""`budget station`: how good a test station must be, and which one will do."""

from __future__ import annotations

import re
from functools import partial
from math import inf
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Inputs

_NUMBER = r"[0-9]{1,9}(?:\.[0-9]{1,9})?"
_RATIO = re.compile(rf"({_NUMBER})(?: *: *1)?")


def _ratio(text: str) -> float:
    """Read the ratio of a limit to an uncertainty, '4:1' or '4'."""
    from budget.studies.stations import LEAST_RATIO, MOST_RATIO

    match = _RATIO.fullmatch(text.strip())
    value = float(match[1]) if match else inf
    if not LEAST_RATIO <= value <= MOST_RATIO:
        raise typer.BadParameter(
            f"{text!r} is no ratio of a limit to the expanded uncertainty of the "
            f"station by itself; give one of {LEAST_RATIO:g}:1 to "
            f"{MOST_RATIO:g}:1, as 4:1, 3:1 or 10"
        )
    return value


def _guard(text: str) -> float:
    """Read the factor r of a guard band."""
    from budget.studies.stations import MOST_GUARD

    match = re.fullmatch(_NUMBER, text.strip())
    value = float(match[0]) if match else inf
    if value > MOST_GUARD:
        raise typer.BadParameter(
            f"{text!r} is no factor of a guard band, which is R times the expanded "
            "uncertainty of the measurement; give a number of 0 (none) to "
            f"{MOST_GUARD:g}, as 1"
        )
    return value


@options.asking("station")
def station(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    inputs: Inputs,
    asked: Asked,
    ratio: Annotated[
        float | None,
        options.judged(
            parser=_ratio,
            metavar="N:1",
            help="Limit over the expanded uncertainty of the station by itself (4:1).",
            show_default=False,
        ),
    ] = None,
    guard: Annotated[
        float | None,
        options.judged(
            parser=_guard,
            metavar="R",
            help="Guard band of the acceptance limits, over the expanded uncertainty "
            "of the whole measurement (1).",
            show_default=False,
        ),
    ] = None,
    stations: Annotated[
        list[Path] | None,
        options.judged(
            "--station",
            autocompletion=options.completing("station"),
            metavar="FILE",
            help="A station file to judge beside the shipped ones; may be given again.",
            show_default=False,
        ),
    ] = None,
    write: Annotated[
        Path | None,
        options.written(
            metavar="FILE.yaml",
            help="Write what the figures may be together as a station file.",
        ),
    ] = None,
    out: options.OutputFiles,
) -> None:
    """Say how good each figure of a test station must be, and which station will do.

    The station's part is to be at most 1/N of each limit. Exit code 1 if no station
    does, that of the procedure among them.
    """
    from budget.cli.output import check_files, check_yaml, hand_out, pages_asked
    from budget.errors import SpecError
    from budget.inputs import load_station, load_stations
    from budget.inputs.load import try_all
    from budget.report.document import json_text, table_csv
    from budget.report.stations import (
        station_answer,
        station_document,
        station_yaml,
    )
    from budget.studies.stations import GUARD, RATIO, qualify

    given = stations or []
    check_files(out, inputs, devices, write, more=given)
    check_yaml(write, "station")
    more, issues = try_all(given, load_station)
    if issues:
        raise SpecError(tuple(issues))
    found = qualify(
        *options.load_devices(devices, inputs.changes),
        ratio=RATIO if ratio is None else ratio,
        guard=GUARD if guard is None else guard,
        stations=(*load_stations(), *more),
        inputs=inputs,
        asked=asked,
    )
    written = {} if write is None else {write: station_yaml(found)}
    hand_out(
        (
            (out.json, lambda: json_text(found.to_dict())),
            (out.csv, lambda: table_csv("station_figure", found.figures)),
        ),
        lambda: station_answer(found, full=out.full),
        title=found.title,
        pages=written | pages_asked(context, out, partial(station_document, found)),
        language=out.language,
    )
    if not found.doing:
        raise typer.Exit(options.EXIT_NOT_MET)
