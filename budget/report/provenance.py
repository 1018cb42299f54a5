"""Provenance section: version, command, seed, hashes of inputs; sign-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.language import say, term
from budget.report.blocks import Cell, Field, Pairs, Paragraph, Section, table_of
from budget.report.tables import print_count

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Words
    from budget.results import InputFile, Settings

WHERE_EXACT = term(
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
        (say("made by"), (f"budget {version}",)),
        (say("command"), (command_line,)),
    ]
    if settings is not None:
        rows.append((say("seed"), (str(settings.seed),)))
    if settings is not None and settings.trials is not None:
        rows.append((say("trials"), (print_count(settings.trials),)))
    files = table_of(
        inputs,
        (
            Field(head=say("input"), cell=lambda file: say(file.role)),
            Field(head=say("file"), cell=_file),
            Field(
                head="SHA-256", kind="code", weight=3.0, cell=lambda file: file.sha256
            ),
        ),
        name="input-files",
        caption=say("Input files and their SHA-256"),
    )
    return Section(
        name="provenance",
        title=say("Provenance"),
        blocks=(
            Pairs(rows=tuple(rows)),
            files,
            Paragraph(words=(say(WHERE_EXACT),), small=True),
        ),
    )


def _file(file: InputFile) -> Cell:
    """Return the name of a file, with what the call changed of it."""
    changes = say("; ").join(
        say(
            "{address} {new} (was {old})", address=one.address, new=one.new, old=one.old
        )
        for one in file.changes
    )
    return Cell(
        text=file.name,
        note=say("changed: {changes}", changes=changes) if changes else "",
    )


def sign_off_section() -> Section:
    """Return the lines on which those who answer for a report sign it."""
    blank = Cell(text="\N{NO-BREAK SPACE}")
    table = table_of(
        (say("prepared"), say("checked"), say("approved")),
        (
            Field(head=say("role"), weight=0.6, cell=lambda role: role),
            Field(head=say("name"), weight=1.5, cell=lambda _: blank),
            Field(head=say("date"), weight=0.7, cell=lambda _: blank),
            Field(head=say("signature"), weight=1.8, cell=lambda _: blank),
        ),
        name="signatures",
        caption=say("Lines to be signed: prepared, checked, approved"),
        for_pen=True,
    )
    return Section(name="sign-off", title=say("Sign-off"), blocks=(table,))
