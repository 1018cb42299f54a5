"""Reproduction of the paper as a document: verdicts, then every number and claim."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.language import ENGLISH, say, spoken, term
from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Document,
    ForPages,
    Paragraph,
    Run,
)
from budget.report.document import json_text
from budget.report.figures.rows import chart_picture
from budget.report.formulas import with_math
from budget.report.pages import sections
from budget.report.provenance import provenance_section
from budget.report.tables import print_given, round_uncertainty
from budget.version import __version__
from zhao_2019.figures import print_ratio, ratio_chart, sweep_picture
from zhao_2019.printed import (
    U_MEAN,
    U_SINGLE,
    VALUE,
    WORD,
    Verdict,
    say_number,
)

if TYPE_CHECKING:
    from budget.report.blocks import Block, Section
    from zhao_2019.printed import Finding
    from zhao_2019.study import PaperStudy

COMMAND = "budget paper"
LEAST_P = 1e-6  # [1]; below it a probability is printed as such
# A printed number, and what it is where it is not the entry itself: 'rms 4.74e-9'.
PRINTED = re.compile(r"(?P<head>rms |)(?P<number>-?[0-9.]+(?:e-?[0-9]+)?)(?P<tail>.*)")
# Short, below a number.
QUANTITIES = {U_SINGLE: term("u, single"), U_MEAN: term("u, mean")}
BESIDE = (term("rms"), term("rms of u, single"), term("rms about -1"))  # a number


def paper_document(study: PaperStudy, *, date: str) -> Document:
    """Put the whole study into one document."""
    paper = study.paper
    return Document(
        kind="paper",
        title=say(paper.title),
        facts=(say(paper.reference),),
        headline=say(
            "{findings} numbers and claims, each with a verdict",
            findings=len(study.findings),
        ),
        summary=(
            say(
                "Table 1, figures 1 to 4, the orders of magnitude in the text, the "
                "formulas and the conclusions, computed from the conditions that the "
                "paper states: what it prints, ours, their ratio, a verdict, and why."
            ),
        ),
        cards=tuple(_card(study, title) for title in paper.cards),
        sections=(
            *paper_sections(study),
            provenance_section(
                study.inputs,
                None,
                version=__version__,
                command_line=COMMAND
                if spoken() == ENGLISH
                else f"{COMMAND} --language {spoken()}",
            ),
        ),
        json=json_text(study.to_dict()),
        date=date,
        version=__version__,
    )


def paper_sections(study: PaperStudy) -> tuple[Section, ...]:
    """Return the sections that page and terminal have in common, the answer first."""
    return sections(
        "paper",
        study=study,
        paper=study.paper,
        open_points=[(row, printed_cell(row.printed)) for row in study.unexplained],
        ratios=ForPages(lambda: (chart_picture(ratio_chart(study)),)),
        parts=[_part(study, name) for name in study.paper.sections],
        UNEXPLAINED=Verdict.UNEXPLAINED,
        WORD=WORD,
        print_ours=print_ours,
        print_ratio=print_ratio,
        print_probability=print_probability,
        reason=reason,
    )


@dataclass(frozen=True, kw_only=True)
class Part:
    """One part of the paper, as its page shows it."""

    name: str
    title: str
    lead: tuple[Block, ...]  # how to read it, and its figures
    of_words: bool  # whether nothing in it is a number
    # Findings by where they stand, each with that, what is printed, and ours.
    groups: dict[str, list[tuple[Finding, Cell, Cell, Cell]]]


def _part(study: PaperStudy, name: str) -> Part:
    """Gather one part of the paper."""
    rows = study.of_section(name)
    of_words = all(row.quantity == WORD for row in rows)
    groups: dict[str, list[tuple[Finding, Cell, Cell, Cell]]] = {}
    for row in rows:
        cells = (
            _place(row),
            printed_cell(row.printed),
            _ours(row, beside=not of_words),
        )
        groups.setdefault(row.place[0], []).append((row, *cells))
    notes = [study.paper.notes[name]] if name in study.paper.notes else []
    read: tuple[Block, ...] = tuple(
        Paragraph(words=with_math(say(note))) for note in notes
    )
    pictures = ForPages(
        lambda: (*read, Abreast(blocks=tuple(map(sweep_picture, study.sweeps))))
    )
    return Part(
        name=name,
        title=study.paper.sections[name],
        lead=(pictures,) if name == "figures" else read,
        of_words=of_words,
        groups=groups,
    )


def printed_cell(printed: str) -> Cell:
    """Return what the paper prints: a number, with what it is in a note, or words."""
    found = PRINTED.fullmatch(printed)
    if found is None:
        return Cell(text=say(printed))
    note = f"{found['head']}{found['tail'].strip()}".strip()
    for quantity, short in QUANTITIES.items():
        note = note.replace(quantity, short)
    return Cell(text=found["number"], exact=float(found["number"]), note=say(note))


def _place(row: Finding) -> Cell:
    """Return where a finding stands; what speaks of several entries is bold."""
    _, head, *special = map(say, row.place)
    strong = row.is_summary and row.section == "table 1"
    return Cell(text=head, note="".join(special), strong=strong)


def _ours(row: Finding, *, beside: bool) -> Cell:
    """Return what came out; words beside numbers are small: the column stays narrow."""
    if not isinstance(row.ours, str):
        note = say(QUANTITIES.get(row.quantity, ""))
        return Cell(text=print_ours(row), exact=row.ours, note=note)
    ours = say(row.ours)
    return Cell(text="", note=ours) if beside else Cell(text=ours)


def _card(study: PaperStudy, title: str) -> Card:
    """Count the rows of some verdicts, together and each."""
    counts = {str(verdict): number for verdict, number in study.counts.items()}
    found = {w: counts[w] for w in study.paper.cards[title] if w in counts}
    of_all = say(
        "{number} of {all}", number=sum(found.values()), all=len(study.findings)
    )
    total = Run(text=of_all, strong=True)
    lines = [
        Run(
            text=say("{key}: {text}", key=say(word), text=number),
            strong=word == Verdict.UNEXPLAINED,
        )
        for word, number in found.items()
    ]
    return Card(title=say(title), lines=tuple((run,) for run in (total, *lines)))


def print_ours(row: Finding) -> str:
    """Print ours: six digits of a value, two of a standard uncertainty, or a word."""
    if isinstance(row.ours, str):
        return say(row.ours)
    if row.quantity == VALUE:
        return print_given(row.ours, digits=6)
    return round_uncertainty(row.ours)


def print_probability(p: float | None) -> str:
    """Print a probability to two digits, '' where there is none."""
    if p is None:
        return ""
    return f"<{say_number(LEAST_P)}" if p < LEAST_P else say_number(p)


def reason(row: Finding) -> str:
    """Say why, but where the row of all the entries judged together says it."""
    return "" if row.why.startswith("judged with") else say(row.why)
