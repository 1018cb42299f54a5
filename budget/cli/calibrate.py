"""`budget calibrate`: a unit calibrated from what was recorded of a procedure."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Inputs, RecordingSettings


@options.asking("calibrate")
def calibrate(
    context: typer.Context,
    runs: Annotated[
        list[Path],
        typer.Argument(
            metavar="RUN...",
            help="Recordings of the run, one after the other, or one table with a row "
            "of means for each window: window,duration [s],gyro_x [deg/s],...",
            show_default=False,
        ),
    ],
    *,
    inputs: Inputs,
    device: Annotated[
        str | None,
        options.judged(
            metavar="DEVICE",
            help="What the unit should be: its data sheet, FILE or FILE#VARIANT.",
            autocompletion=options.complete_device,
            show_default=False,
        ),
    ] = None,
    recorded: RecordingSettings,
    windows: Annotated[
        Path | None,
        options.judged(
            metavar="FILE.csv",
            help="When each window begins and ends, window,start [s],end [s], in the "
            "place of rests and turns that are found.",
            show_default=False,
        ),
    ] = None,
    as_found: Annotated[
        Path | None,
        options.judged(
            metavar="FILE.json",
            help="Result of the calibration whose correction the unit came with "
            "(calibrate --json); none: as found is the unit without correction.",
            show_default=False,
        ),
    ] = None,
    serial: Annotated[
        str,
        options.written(
            metavar="TEXT", help="Serial number of the unit.", show_default=False
        ),
    ] = "",
    date: Annotated[
        str,
        options.written(
            metavar="YYYY-MM-DD", help="Day of the run.", show_default=False
        ),
    ] = "",
    to: Annotated[
        str | None,
        options.written(
            "--to",
            metavar="<python|c|yaml>",
            help="Print the correction as code, with its units.",
            show_default=False,
        ),
    ] = None,
    asked: Asked,
    out: options.OutputFiles,
) -> None:
    """Calibrate a unit from a recorded run, and say whether the run was sound.

    Windows are found by rest and turn and matched to the procedure in their order.
    Values come with uncertainties; with a device the run is held against its data
    sheet, and where it is not sound the likeliest known mistake is named. -o
    certificate.html or .pdf writes a certificate. Exit code 1: the run is not sound,
    or a limit is missed or cannot be judged.
    """
    from budget.cli.output import check_destinations, hand_out, pages_asked
    from budget.errors import CallError
    from budget.recordings.calibrate import calibrate as find
    from budget.report.calibrated import calibrate_answer, calibrate_document
    from budget.report.correction import CORRECTIONS, correction_code
    from budget.report.document import json_text, table_csv
    from budget.report.rendering import check_suffixes

    if to is not None and to not in CORRECTIONS:
        raise CallError(f"--to {to}: allowed are {', '.join(CORRECTIONS)}")
    check_suffixes(out.output, out.paper)
    check_destinations(
        out.json,
        out.csv,
        *out.output,
        inputs=[*runs, *recorded.files, windows, as_found, device, *inputs.files],
    )
    found = find(
        *runs,
        device=options.load_sheet(device, inputs.changes),
        recorded=recorded,
        windows=windows,
        as_found=as_found,
        serial=serial,
        date=date,
        inputs=inputs,
        asked=asked,
    )
    make = partial(calibrate_document, found)
    documents = [
        (out.json, lambda: json_text(found.to_dict())),
        (out.csv, lambda: table_csv("calibrated_output", found.outputs)),
    ]
    if to is not None:
        documents.append((options.STDOUT, lambda: correction_code(found, to=to)))
    hand_out(
        documents,
        lambda: calibrate_answer(found),
        pages=pages_asked(context, out, make),
        language=out.language,
    )
    if found.is_sound is False or found.missed or found.is_open:
        raise typer.Exit(options.EXIT_NOT_MET)
