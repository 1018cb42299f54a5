"""Provenance section: version, command, seed, hashes of inputs; sign-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Field, Pairs, Paragraph, Section, table_of
from budget.report.tables import print_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Words
    from budget.results import InputFile, Settings

WHERE_EXACT = (
    "The same numbers in full precision stand in the JSON document: inside the HTML "
    "file, and from the same command with --json."
)


def provenance_section(
    inputs: Sequence[InputFile],
    settings: Settings | None,
    *,
    version: str,
    command_line: str,
) -> Section:
    """Return what it takes to make the report again.

    The command line comes without output names and without what changes no number.
    Where nothing can be set `settings` is None.
    """
    rows: list[tuple[str, Words]] = [
        ("made by", (f"budget {version}",)),
        ("command", (command_line,)),
    ]
    if settings is not None:
        rows.append(("seed", (str(settings.seed),)))
    if settings is not None and settings.trials is not None:
        rows.append(("trials", (print_count(settings.trials),)))
    files = table_of(
        inputs,
        (
            Field(head="input", cell=lambda file: file.role),
            Field(head="file", cell=_file),
            Field(
                head="SHA-256", kind="code", weight=3.0, cell=lambda file: file.sha256
            ),
        ),
        name="input-files",
        caption="Input files and their SHA-256",
    )
    return Section(
        name="provenance",
        title="Provenance",
        blocks=(
            Pairs(rows=tuple(rows)),
            files,
            Paragraph(words=(WHERE_EXACT,), small=True),
        ),
    )


def _file(file: InputFile) -> Cell:
    """Return the name of a file, with what the call changed of it."""
    changes = "; ".join(
        f"{one.address} {one.new} (was {one.old})" for one in file.changes
    )
    return Cell(text=file.name, note=f"changed: {changes}" if changes else "")


def sign_off_section() -> Section:
    """Return the lines on which those who answer for a report sign it."""
    blank = Cell(text="\N{NO-BREAK SPACE}")
    table = table_of(
        ("prepared", "checked", "approved"),
        (
            Field(head="", weight=0.6, cell=lambda role: role),
            Field(head="name", weight=1.5, cell=lambda _: blank),
            Field(head="date", weight=0.7, cell=lambda _: blank),
            Field(head="signature", weight=1.8, cell=lambda _: blank),
        ),
        name="signatures",
        caption="Lines to be signed: prepared, checked, approved",
        for_pen=True,
    )
    return Section(name="sign-off", title="Sign-off", blocks=(table,))
