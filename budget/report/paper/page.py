"""The paper beside ours as a document: verdicts first, then every number and claim."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Column,
    Document,
    Listing,
    Paragraph,
    RowGroup,
    Run,
    Section,
    Table,
)
from budget.report.figures.picture import capital
from budget.report.formulas import with_math
from budget.report.paper.document import to_json
from budget.report.paper.figures import ratio_picture, sweep_picture
from budget.report.paper.texts import (
    place_of,
    print_ours,
    print_probability,
    print_ratio,
    reason,
    unexplained,
)
from budget.report.provenance import provenance_section
from budget.studies.paper.findings import U_MEAN, U_SINGLE, WORD, Verdict
from budget.version import __version__

if TYPE_CHECKING:
    from budget.report.blocks import Block, Words
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

COMMAND = "budget paper"
OF_FORMULAS = with_math(
    "Each formula is fed with the pulses of a sensor without errors, whose six angles "
    "are 1 to 6 arcsec. $n_(i j)$: pulses of axis $i$ over a turn forward minus those "
    "back, about z (1), x (2), y (3). $N_i (j)$: mean count of axis $i$, z up (1), z "
    "down, x up, x down, y up, y down (6)."
)
# A printed number, and what it is where it is not the entry itself: 'rms 4.74e-9'.
PRINTED = re.compile(r"(?P<head>rms |)(?P<number>-?[0-9.]+(?:e-?[0-9]+)?)(?P<tail>.*)")
QUANTITIES = {U_SINGLE: "u, single", U_MEAN: "u, mean"}  # short, below a number


def paper_document(study: PaperStudy, *, date: str) -> Document:
    """Put the whole study into one document.

    Parameters
    ----------
    study : PaperStudy
        The result.
    date : str
        Year-month-day.

    Returns
    -------
    Document
        The same for the same arguments.
    """
    paper = study.paper
    open_points = Listing(
        items=tuple(_said(row) for row in unexplained(study)),
        empty="Nothing is left open.",
    )
    assumed = Listing(
        items=tuple((capital(text),) for text in paper.assumptions),
        empty="Nothing: the paper says all that is needed.",
    )
    answer = (
        ("unexplained", "What nothing explains", open_points),
        ("assumed", "Assumed", assumed),
        ("ratios", "Random entries of Table 1", ratio_picture(study)),
    )
    verdicts = Section(
        name="verdicts", title="The verdicts", blocks=(verdict_table(study),)
    )
    return Document(
        kind="paper",
        title=paper.title,
        facts=(paper.reference,),
        headline=f"{len(study.findings)} numbers and claims, each with a verdict",
        summary=(
            (
                "Table 1, figures 1 to 4, the orders of magnitude in the text, the "
                "formulas and the conclusions, computed from the conditions that the "
                "paper states: what it prints, ours, their ratio, a verdict, and why."
            ),
        ),
        cards=tuple(_card(study, title) for title in paper.cards),
        sections=(
            *(
                Section(name=name, title=title, blocks=(block,), on_first_page=True)
                for name, title, block in answer
            ),
            verdicts,
            *(_section(study, name) for name in paper.sections),
            provenance_section(
                study.inputs, None, version=__version__, command_line=COMMAND
            ),
        ),
        json=to_json(study),
        date=date,
        version=__version__,
    )


def verdict_table(study: PaperStudy) -> Table:
    """Return how many rows have each verdict, and what it means."""
    rows = tuple(
        (
            Cell(text=word.value, strong=word == Verdict.UNEXPLAINED),
            Cell(text=str(number), exact=number),
            Cell(text=study.paper.verdicts[word]),
        )
        for word, number in study.counts.items()
    )
    return Table(
        name="verdict-counts",
        caption="Rows of each verdict and what it means",
        columns=(
            Column(head="verdict"),
            Column(head="rows", kind="number"),
            Column(head="meaning"),
        ),
        groups=(RowGroup(rows=rows),),
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
    # Formulas are hard to read in pieces; beside numbers all is as wide as it asks.
    weights = (0.5, 1.4, 1.2) if section == "formulas" else (1.0, 1.0, 1.0)
    where, formula, why = weights
    columns = (
        Column(head="where", weight=where),
        Column(head="printed", kind=kind, weight=formula),
        Column(head="ours", kind=kind, weight=formula),
        Column(head="ours / printed", kind="number"),
        Column(head="p, single", kind="number"),
        Column(head="p, mean", kind="number"),
        Column(head="verdict, and why", weight=why),
    )
    groups: dict[str, list[tuple[Cell, ...]]] = {}
    for row in rows:
        groups.setdefault(place_of(row).group, []).append(_cells(row, kind=kind))
    filled = [
        k
        for k in range(len(columns))
        if any(cells[k].text for group in groups.values() for cells in group)
    ]
    return Table(
        name=f"findings-{section.replace(' ', '-')}",
        caption=study.paper.sections[section],
        columns=tuple(columns[k] for k in filled),
        groups=tuple(
            RowGroup(
                title=title,
                rows=tuple(tuple(cells[k] for k in filled) for cells in group),
            )
            for title, group in groups.items()
        ),
        is_wide=True,
        searchable=True,
    )


def printed_cell(printed: str) -> Cell:
    """Return what the paper prints: a number, with what it is in a note, or words."""
    found = PRINTED.fullmatch(printed)
    if found is None:
        return Cell(text=printed)
    note = f"{found['head']}{found['tail'].strip()}".strip()
    for quantity, short in QUANTITIES.items():
        note = note.replace(quantity, short)
    return Cell(text=found["number"], exact=float(found["number"]), note=note)


def _cells(row: Finding, *, kind: str) -> tuple[Cell, ...]:
    """Return one finding; what speaks of several entries is bold in Table 1."""
    place = place_of(row)
    bold = row.is_summary and row.section == "table 1"
    if not isinstance(row.ours, str):
        note = QUANTITIES.get(row.quantity, "")
        ours = Cell(text=print_ours(row), exact=row.ours, note=note)
    elif kind == "number":  # words beside numbers are small: the column stays narrow
        ours = Cell(text="", note=row.ours)
    else:
        ours = Cell(text=row.ours)
    is_open = row.verdict == Verdict.UNEXPLAINED
    return (
        Cell(text=place.name, note=place.note, strong=bold),
        printed_cell(row.printed),
        ours,
        Cell(text=print_ratio(row.ratio), exact=row.ratio),
        *(Cell(text=print_probability(p), exact=p) for p in (row.p_single, row.p_mean)),
        Cell(text=row.verdict.value, strong=is_open, note=reason(row)),
    )


def _card(study: PaperStudy, title: str) -> Card:
    """Count the rows of some verdicts, together and each."""
    counts = {str(verdict): number for verdict, number in study.counts.items()}
    found = {w: counts[w] for w in study.paper.cards[title] if w in counts}
    total = Run(text=f"{sum(found.values())} of {len(study.findings)}", strong=True)
    lines = [
        Run(text=f"{word}: {number}", strong=word == Verdict.UNEXPLAINED)
        for word, number in found.items()
    ]
    return Card(title=title, lines=tuple((run,) for run in (total, *lines)))


def _said(row: Finding) -> Words:
    """Say in a line what is printed and what comes out."""
    printed = printed_cell(row.printed)
    before = f"{printed.note} " if printed.note else ""
    exact = None if row.quantity == WORD else float(row.ours)
    return (
        f"{capital(row.where)}: printed {before}",
        Run(text=printed.text, exact=printed.exact),
        ", ours ",
        Run(text=print_ours(row), exact=exact),
        f" ({row.quantity})",
    )


def _section(study: PaperStudy, name: str) -> Section:
    """Return one part of the paper: how to read it, its figures, its findings."""
    blocks: list[Block] = []
    if name == "formulas":
        blocks.append(Paragraph(words=OF_FORMULAS))
    elif name in study.paper.notes:
        blocks.append(Paragraph(words=(study.paper.notes[name],)))
    if name == "figures":
        blocks.append(Abreast(blocks=tuple(map(sweep_picture, study.sweeps))))
    return Section(
        name=name.replace(" ", "-"),
        title=study.paper.sections[name],
        blocks=(*blocks, findings_table(study, name)),
    )
