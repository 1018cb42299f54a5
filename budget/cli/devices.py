"""`budget devices`: what ships, and what one data sheet says."""

from __future__ import annotations

from itertools import chain
from typing import Annotated

import typer

from budget.cli import options
from budget.settings import Inputs


@options.asking("devices")
def devices(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            autocompletion=options.complete_device,
            help="A device to show, FILE or FILE#VARIANT; without it all that ship.",
            show_default=False,
        ),
    ] = None,
    *,
    kind: options.Kinds = None,
    grade: options.Grades = None,
    inputs: Inputs,
    out: options.OutputFiles,
) -> None:
    """List the devices that ship, or show every specification value of one.

    A file with variants shows each of them. What the list has under name is what
    every command takes as DEVICE.
    """
    from budget.cli.output import hand_out
    from budget.errors import CallError
    from budget.inputs.load import load_changed
    from budget.report.catalogue import device_sections, list_sections
    from budget.report.document import json_of

    if name is None and inputs.changes:
        raise CallError("--set changes a device, and none is named; name one")
    if name is not None and (kind or grade):
        raise CallError(
            f"--kind and --grade choose from the list, and {name} is named; leave one "
            "of both out"
        )
    if name is None:
        every = options.select_catalogue(kind, grade)
        hand_out(
            [(out.json, lambda: json_of(every, "device_list"))],
            lambda: list_sections(every),
        )
        return
    found = load_changed([name], inputs.changes, variants=True)
    shown = (found[0], "one_device") if len(found) == 1 else (found, "device_list")
    hand_out(
        [(out.json, lambda: json_of(*shown))],
        lambda: chain.from_iterable(map(device_sections, found)),
    )
