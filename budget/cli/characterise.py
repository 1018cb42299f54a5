"""`budget characterise`: what noise a device has, of recordings at rest."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.cli.export import NAMES, read_target
from budget.settings import Asked, Engine, Inputs, RecordingSettings


@options.asking("characterise")
def characterise(
    context: typer.Context,
    logs: Annotated[
        list[Path],
        typer.Argument(
            metavar="LOG...",
            help="Recordings at rest, each a turn-on of one unit: CSV, text, .npy, "
            ".npz, .parquet, or a recording file (.yaml) that says what its columns "
            "are.",
            show_default=False,
        ),
    ],
    *,
    recorded: RecordingSettings,
    attitude: Annotated[
        str | None,
        options.judged(
            metavar="TEXT",
            help="How the unit rested, as 'z up': its bias is found too, at the place "
            "of --procedure.",
            show_default=False,
        ),
    ] = None,
    inputs: Inputs,
    to: Annotated[
        str | None,
        options.written(
            "--to",
            parser=read_target,
            metavar=f"<{'|'.join(NAMES)}>",
            help="Print the figures as this target reads them, like `budget export`.",
            autocompletion=lambda: [*NAMES],
            show_default=False,
        ),
    ] = None,
    engine: Engine,
    out: options.OutputFiles,
) -> None:
    """Find figures of noise in recordings at rest, and write them as a device file.

    Noise, in-run bias and its correlation time, random walk, flicker and quantisation
    of each axis, with 95 % intervals; what the recordings are too short to tell is not
    told. Several recordings of one unit, a turn-on each, give the repeatability of the
    bias too. -o device.yaml writes a device file, -o page.html or .pdf a page.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations, hand_out, pages_asked
    from budget.inputs.recording import YAML
    from budget.recordings.characterise import characterise as find
    from budget.report.document import json_text, table_csv
    from budget.report.recording import (
        characterise_answer,
        characterise_document,
        measured_device,
        measured_yaml,
    )
    from budget.report.rendering import check_suffixes

    files = [one for one in out.output if one.suffix.lower() in YAML]
    pages = replace(out, output=[one for one in out.output if one not in files])
    check_suffixes(pages.output, out.paper)
    check_destinations(
        out.json,
        out.csv,
        *out.output,
        inputs=[*logs, *recorded.files, *inputs.files],
    )
    with computing(engine) as engine_told:
        found = find(
            *logs,
            recorded=recorded,
            attitude=attitude,
            inputs=inputs,
            engine=engine_told,
        )
    written = {path: measured_yaml(found, name=path.stem) for path in files}
    make = partial(characterise_document, found)
    documents = [
        (out.json, lambda: json_text(found.to_dict())),
        (out.csv, lambda: table_csv("noise_line", found.lines)),
    ]
    if to is not None:
        from budget.report.export import write_export
        from budget.studies.export.study import export

        exported = export(
            measured_device(found),
            to=to,
            rate=found.records[0].rate,
            inputs=Inputs(),
            asked=Asked(),
        )
        documents.append((options.STDOUT, lambda: write_export(exported)))
    hand_out(
        documents,
        lambda: characterise_answer(found),
        pages=written | pages_asked(context, pages, make),
        language=out.language,
    )
