"""`budget devices`: what ships, and what one data sheet says."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options
from budget.cli.streams import console

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.spec.records import Device


def devices(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="A device to show, FILE or FILE#VARIANT; without it all that ship.",
            show_default=False,
        ),
    ] = None,
    *,
    json: options.JsonFile = None,
) -> None:
    """List the devices that ship, or show every specification value of one.

    A file with variants shows each of them.
    """
    from budget.cli.output import printing
    from budget.report.catalogue import device_to_json, list_to_json
    from budget.report.files import write_all
    from budget.spec import load_catalogue, load_variants

    found = load_catalogue() if name is None else load_variants(name)
    if json is not None:
        alone = name is not None and len(found) == 1
        text = device_to_json(found[0]) if alone else list_to_json(found)
        if json == options.STDOUT:
            with printing():
                sys.stdout.write(text)
            return
        write_all({json: text})
    with printing():
        _render(found, is_list=name is None)


def _render(found: Sequence[Device], *, is_list: bool) -> None:
    """Print the list, or one device after the other."""
    from budget.report.catalogue import device_sections, list_sections
    from budget.report.terminal import Page, print_sections

    page = Page(console())
    if is_list:
        print_sections(list_sections(found), page)
        return
    for device in found:
        print_sections(device_sections(device), page)
