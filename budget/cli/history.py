"""`budget history`: calibrations of one unit over time."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Inputs


@options.asking("history")
def history(
    context: typer.Context,
    results: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULT...",
            help="Results of one unit (`budget calibrate --json`), or folders of them.",
            show_default=False,
        ),
    ],
    *,
    device: Annotated[
        str | None,
        options.judged(
            metavar="DEVICE",
            help="Data sheet, whose repeatability and ageing drifts are held against.",
            autocompletion=options.complete_device,
            show_default=False,
        ),
    ] = None,
    inputs: Inputs,
    asked: Asked,
    out: options.OutputFiles,
) -> None:
    """Put calibrations of one unit in the order of time, and tell its drift.

    Straight lines with their intervals, parameter by parameter; with a requirement when
    its limits may be reached since the last calibration, with a device whether it ages
    more than its data sheet says. Values have the repeatability of the device besides,
    without which limits of the next turn-on are refused. Runs that were not sound are
    left out.
    """
    from budget.cli.output import check_destinations, hand_out, pages_asked
    from budget.recordings.history import history as find
    from budget.report.calibration_history import history_answer, history_document
    from budget.report.document import json_text, table_csv
    from budget.report.rendering import check_suffixes

    check_suffixes(out.output, out.paper)
    check_destinations(
        out.json, out.csv, *out.output, inputs=[*results, device, *inputs.files]
    )
    found = find(
        *results,
        device=options.load_sheet(device, inputs.changes),
        inputs=inputs,
        asked=asked,
    )
    hand_out(
        [
            (out.json, lambda: json_text(found.to_dict())),
            (out.csv, lambda: table_csv("history_row", found.parameters)),
        ],
        lambda: history_answer(found),
        pages=pages_asked(context, out, partial(history_document, found)),
        language=out.language,
    )
