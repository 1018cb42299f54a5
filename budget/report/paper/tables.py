"""The tables of the paper's document: verdicts, and every finding of a section."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.blocks import Cell, Column, RowGroup, Table
from budget.report.figures.picture import capital
from budget.report.paper.printing import (
    print_ours,
    print_probability,
    print_ratio,
    shorten,
)
from budget.studies.paper.findings import (
    U_MEAN,
    U_SINGLE,
    WORD,
    Verdict,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

# A printed number, and what it is where it is not the entry itself: 'rms 4.74e-9'.
PRINTED = re.compile(r"(?P<head>rms |)(?P<number>-?[0-9.]+(?:e-?[0-9]+)?)(?P<tail>.*)")
WHOLE = "Table 1 as a whole"
# Where the head of a row ends: what follows stands below it, in a narrow column.
SPECIAL = re.compile(r" (?=(?:from|beyond|of|random|with) )")
QUANTITIES = {U_SINGLE: "u, single", U_MEAN: "u, mean"}  # short, below a number


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a finding stands in its table.

    Attributes
    ----------
    group : str
        Title of the rows that it belongs to: 'Bias stability'.
    name : str
        Head of its row: 'mounting angle xy'.
    note : str
        What is special about it: 'from its angles'.
    """

    group: str
    name: str
    note: str = ""


def place_of(row: Finding) -> Place:
    """Split the place of a finding into that of its group and its own."""
    text = shorten(row)
    if row.section == "readings":  # of what entries: which reading
        entries, _, reading = text.partition(": ")
        group, _, name = entries.rpartition(", ")
        return Place(group=capital(f"{group}: {reading}"), name=name)
    if row.section == "conclusions":  # sentences, under the section they stand in
        group, _, name = text.partition(": ")
        return Place(group=group, name=name)
    if row.section == "text":
        group, _, name = text.rpartition(", ")
    else:
        group, _, name = text.partition(", ")
    head, *special = SPECIAL.split(name or group, maxsplit=1)
    return Place(
        group=capital(group) if name else WHOLE, name=head, note="".join(special)
    )


def verdict_table(study: PaperStudy) -> Table:
    """Return how many rows have each verdict, and what it means."""
    return Table(
        name="verdict-counts",
        caption="Rows of each verdict and what it means",
        columns=(
            Column(head="verdict"),
            Column(head="rows", kind="number"),
            Column(head="meaning"),
        ),
        groups=(
            RowGroup(
                rows=tuple(
                    (
                        Cell(text=word.value, strong=word == Verdict.UNEXPLAINED),
                        Cell(text=str(number), exact=number),
                        Cell(text=study.paper.verdicts[word]),
                    )
                    for word, number in study.counts.items()
                )
            ),
        ),
        is_wide=True,
    )


def findings_table(study: PaperStudy, section: str) -> Table:
    """Return every finding of one section, without columns that would be empty.

    Parameters
    ----------
    study : PaperStudy
    section : str
        A key of Paper.sections.

    Returns
    -------
    Table
        Grouped by where the findings stand in the paper.
    """
    rows = study.of_section(section)
    kind = "text" if all(row.quantity == WORD for row in rows) else "number"
    has_ratios = any(row.ratio is not None for row in rows)
    is_random = any(row.p_single is not None for row in rows)
    # Formulas are hard to read in pieces; beside numbers all is as wide as it asks.
    is_formulas = kind == "text" and has_ratios
    where, formula, reason = (0.5, 1.4, 1.2) if is_formulas else (1.0, 1.0, 1.0)
    columns = [
        Column(head="where", weight=where),
        Column(head="printed", kind=kind, weight=formula),
        Column(head="ours", kind=kind, weight=formula),
    ]
    if has_ratios:
        columns.append(Column(head="ours / printed", kind="number"))
    if is_random:
        columns += [
            Column(head="p, single", kind="number"),
            Column(head="p, mean", kind="number"),
        ]
    columns.append(Column(head="verdict, and why", weight=reason))
    return Table(
        name=f"findings-{section.replace(' ', '-')}",
        caption=study.paper.sections[section],
        columns=tuple(columns),
        groups=tuple(
            RowGroup(
                title=group,
                rows=tuple(
                    _cells(row, kind=kind, has_ratios=has_ratios, is_random=is_random)
                    for row in members
                ),
            )
            for group, members in _gathered(rows).items()
        ),
        is_wide=True,
        searchable=True,
    )


def _gathered(rows: Iterable[Finding]) -> dict[str, list[Finding]]:
    """Return the rows of each group, groups in the order of their first rows."""
    found: dict[str, list[Finding]] = {}
    for row in rows:
        found.setdefault(place_of(row).group, []).append(row)
    return found


def _cells(
    row: Finding, *, kind: str, has_ratios: bool, is_random: bool
) -> tuple[Cell, ...]:
    """Return one finding; what speaks of several entries is bold in Table 1."""
    cells = [
        Cell(
            text=place_of(row).name,
            note=place_of(row).note,
            strong=row.is_summary and row.section == "table 1",
        ),
        printed_cell(row.printed),
        _ours_cell(row, kind=kind),
    ]
    if has_ratios:
        cells.append(Cell(text=print_ratio(row.ratio), exact=row.ratio))
    if is_random:
        cells += [
            Cell(text=print_probability(p), exact=p) for p in (row.p_single, row.p_mean)
        ]
    # A row is judged with its neighbours where the row of them all says why.
    why = "" if row.why.startswith("judged with") else row.why
    cells.append(
        Cell(
            text=row.verdict.value, strong=row.verdict == Verdict.UNEXPLAINED, note=why
        )
    )
    return tuple(cells)


def _ours_cell(row: Finding, *, kind: str) -> Cell:
    """Return ours; words beside numbers are small, so that the column stays narrow."""
    if not isinstance(row.ours, str):
        return Cell(
            text=print_ours(row), exact=row.ours, note=QUANTITIES.get(row.quantity, "")
        )
    if kind == "number":
        return Cell(text="", note=row.ours)
    return Cell(text=row.ours)


def printed_cell(printed: str) -> Cell:
    """Return what the paper prints: a number, with what it is in a note, or words."""
    found = PRINTED.fullmatch(printed)
    if found is None:
        return Cell(text=printed)
    note = f"{found['head']}{found['tail'].strip()}".strip()
    for quantity, short in QUANTITIES.items():
        note = note.replace(quantity, short)
    return Cell(text=found["number"], exact=float(found["number"]), note=note)
