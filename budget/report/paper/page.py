"""The paper beside ours as a document: verdicts first, then every number and claim."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import (
    Abreast,
    Card,
    Document,
    Listing,
    Paragraph,
    Run,
    Section,
)
from budget.report.figures.picture import capital
from budget.report.formulas import brackets, letter, line, sub
from budget.report.paper.curves import sweep_picture
from budget.report.paper.document import to_json
from budget.report.paper.printing import print_ours, unexplained
from budget.report.paper.ratios import ratio_picture
from budget.report.paper.tables import findings_table, printed_cell, verdict_table
from budget.report.provenance import provenance_section
from budget.studies.paper.findings import WORD, Verdict
from budget.version import __version__

if TYPE_CHECKING:
    from budget.report.blocks import Block, Words
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

COMMAND = "budget paper"
OF_FORMULAS: Words = (
    (
        "Each formula is fed with the pulses of a sensor without errors, whose six "
        "angles are 1 to 6 arcsec. "
    ),
    sub("n", "ij"),
    ": pulses of axis ",
    letter("i"),
    " over a turn forward minus those back, about z (1), x (2), y (3). ",
    line(sub("N", "i"), brackets("j")),
    ": mean count of axis ",
    letter("i"),
    ", z up (1), z down, x up, x down, y up, y down (6).",
)


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
    return Document(
        kind="paper",
        title=study.paper.title,
        facts=(study.paper.reference,),
        headline=f"{len(study.findings)} numbers and claims, each with a verdict",
        summary=(
            (
                "Table 1, figures 1 to 4, the orders of magnitude in the text, the "
                "formulas and the conclusions, computed from the conditions that the "
                "paper states: what it prints, ours, their ratio, a verdict, and why."
            ),
        ),
        cards=tuple(_card(study, title) for title in study.paper.cards),
        sections=(
            _open(study),
            _assumed(study),
            Section(
                name="ratios",
                title="Random entries of Table 1",
                blocks=(ratio_picture(study),),
                on_first_page=True,
            ),
            Section(
                name="verdicts",
                title="The verdicts",
                blocks=(verdict_table(study),),
            ),
            *(_section(study, name) for name in study.paper.sections),
            provenance_section(
                study.inputs, None, version=__version__, command_line=COMMAND
            ),
        ),
        json=to_json(study),
        date=date,
        version=__version__,
    )


def _card(study: PaperStudy, title: str) -> Card:
    """Count the rows of some verdicts, together and each."""
    counts = {str(verdict): number for verdict, number in study.counts.items()}
    found = {word: counts[word] for word in study.paper.cards[title] if word in counts}
    lines: list[Words] = [
        (Run(text=f"{sum(found.values())} of {len(study.findings)}", strong=True),)
    ]
    lines += [
        (Run(text=f"{word}: {number}", strong=word == Verdict.UNEXPLAINED),)
        for word, number in found.items()
    ]
    return Card(title=title, lines=tuple(lines))


def _open(study: PaperStudy) -> Section:
    """Return what nothing explains, entries of one parameter gathered."""
    return Section(
        name="unexplained",
        title="What nothing explains",
        blocks=(
            Listing(
                items=tuple(_said(row) for row in unexplained(study)),
                empty="Nothing is left open.",
            ),
        ),
        on_first_page=True,
    )


def _said(row: Finding) -> Words:
    """Say in a line what is printed and what comes out."""
    printed = printed_cell(row.printed)
    before = f"{printed.note} " if printed.note else ""
    ours = print_ours(row)
    exact = None if row.quantity == WORD else float(row.ours)
    return (
        f"{capital(row.where)}: printed {before}",
        Run(text=printed.text, exact=printed.exact),
        ", ours ",
        Run(text=ours, exact=exact),
        f" ({row.quantity})",
    )


def _assumed(study: PaperStudy) -> Section:
    """Return what the paper leaves to be assumed."""
    return Section(
        name="assumed",
        title="Assumed",
        blocks=(
            Listing(
                items=tuple((capital(text),) for text in study.paper.assumptions),
                empty="Nothing: the paper says all that is needed.",
            ),
        ),
        on_first_page=True,
    )


def _section(study: PaperStudy, name: str) -> Section:
    """Return one part of the paper: how to read it, its figures, its findings."""
    blocks: list[Block] = []
    notes: dict[str, Words] = {k: (text,) for k, text in study.paper.notes.items()}
    notes["formulas"] = OF_FORMULAS
    if name in notes:
        blocks.append(Paragraph(words=notes[name]))
    if name == "figures":
        blocks.append(Abreast(blocks=tuple(map(sweep_picture, study.sweeps))))
    blocks.append(findings_table(study, name))
    return Section(
        name=name.replace(" ", "-"),
        title=study.paper.sections[name],
        blocks=tuple(blocks),
    )
