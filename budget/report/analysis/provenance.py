"""Where the numbers come from: version, command, seed, and every input by its hash."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import (
    Cell,
    Column,
    Pairs,
    Paragraph,
    RowGroup,
    Section,
    Table,
)
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
    files = Table(
        name="input-files",
        caption="Input files and their SHA-256",
        columns=(
            Column(head="input"),
            Column(head="file"),
            Column(head="SHA-256", kind="code", weight=3.0),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (Cell(text=f.role), Cell(text=f.name), Cell(text=f.sha256))
                    for f in inputs
                )
            ),
        ),
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
