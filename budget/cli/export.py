"""`budget export`: the figures of a device, as a filter or a simulator reads them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.resources import names_in
from budget.settings import LONGEST_NUMBER, Asked, Inputs, read_rate

NAMES = tuple(names_in("templates", "export"))


def read_target(text: str) -> str:
    """Read the name of a target, in capitals too."""
    name = text.strip().casefold()
    there = names_in("templates", "export")
    if name not in there:
        shown = text if len(text) <= LONGEST_NUMBER else "the text given"
        raise typer.BadParameter(
            f"{shown!r} is no target; there are: {', '.join(there)}"
        )
    return name


def _factor(text: str) -> float:
    """Read a factor of inflation."""
    from budget.studies.export.study import LEAST_INFLATION, MOST_INFLATION

    value = _number(text)
    if value is None or not LEAST_INFLATION <= value <= MOST_INFLATION:
        raise typer.BadParameter(
            f"{text!r} is no factor of standard deviations; give a number of "
            f"{LEAST_INFLATION:g} (none) to {MOST_INFLATION:g}, as 3"
        )
    return value


def _number(text: str) -> float | None:
    """Read a plain number; None where the text is none."""
    from budget.units import NUMBER

    text = text.strip()
    short = len(text) <= LONGEST_NUMBER
    return float(text) if short and re.fullmatch(NUMBER, text) else None


@options.asking("export")
def export(
    devices: options.Devices = None,
    *,
    to: Annotated[
        str,
        typer.Option(
            "--to",
            parser=read_target,
            metavar=f"<{'|'.join(NAMES)}>",
            help="What reads the file; nav-toolkit is NaveGo.",
            autocompletion=lambda: [*NAMES],
        ),
    ],
    residual: Annotated[
        bool,
        typer.Option(
            "--residual",
            help="Bias, scale factor and mounting angles after calibration, "
            "at the next turn-on, in place of the raw specifications.",
        ),
    ] = False,
    inputs: Inputs,
    asked: Asked,
    inflate: Annotated[
        float | None,
        typer.Option(
            parser=_factor,
            metavar="N",
            help="Factor on every standard deviation (1); variances take its square.",
            show_default=False,
        ),
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(
            parser=options.reading(read_rate),
            metavar="HZ",
            help="Sampling rate, where the target counts by the sample.",
            show_default=False,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="File to write; without it the file goes to stdout.",
            show_default=False,
        ),
    ] = None,
    out: options.OutputFiles,
) -> None:
    """Write the figures of a device as a filter or a simulator reads them.

    Every value says in a comment which specification it is from and how it is made.
    What the target cannot hold is listed, and a specification that it needs is never
    made up.
    """
    from budget.cli.output import check_destinations, hand_out
    from budget.cli.streams import talk
    from budget.errors import CallError
    from budget.report.document import json_text, table_csv
    from budget.report.export import export_answer, remarks, write_export
    from budget.studies.export.study import export as export_to

    check_destinations(
        *(out.json, out.csv, *(() if output is None else (output,))),
        inputs=[*(devices or ()), *inputs.files],
    )
    idle = ("procedure", "station", "age", "environment")
    given = next((one for one in idle if getattr(inputs, one)), "")
    if given and not residual:
        raise CallError(
            f"--{given} changes nothing without --residual: the raw figures are those "
            "of the data sheet; add --residual, or leave it out"
        )
    found = export_to(
        *options.load_devices(devices, inputs.changes),
        to=to,
        residual=residual,
        inflate=1.0 if inflate is None else inflate,
        rate=rate,
        inputs=inputs,
        asked=asked,
    )
    documents = [
        (out.json, lambda: json_text(found.to_dict())),
        (out.csv, lambda: table_csv("exported", found.rows)),
    ]
    on_stdout = options.STDOUT in {out.json, out.csv}
    if output is None and not on_stdout:
        for text in remarks(found):
            talk(text)
        hand_out([*documents, (options.STDOUT, lambda: write_export(found))])
        return
    pages = {} if output is None else {output: write_export(found)}
    hand_out(documents, lambda: export_answer(found), title=found.title, pages=pages)
