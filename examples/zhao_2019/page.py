"""Reproduction of the paper as a document: verdicts, then every number and claim."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from budget.language import ENGLISH, say, spoken, term
from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Document,
    Field,
    ForPages,
    Listing,
    Paragraph,
    Run,
    Section,
    table_of,
)
from budget.report.document import csv_text, json_text
from budget.report.figures.rows import chart_picture
from budget.report.formulas import with_math
from budget.report.provenance import provenance_section
from budget.report.tables import print_given, round_uncertainty
from budget.report.wording import capital, say_words
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
from zhao_2019.study import COLUMNS

if TYPE_CHECKING:
    from budget.report.blocks import Block, Table, Words
    from zhao_2019.printed import Finding
    from zhao_2019.study import PaperStudy

COMMAND = "budget paper"
LEAST_P = 1e-6  # [1]; below it a probability is printed as such
OF_FORMULAS = term(
    "Each formula is fed with the pulses of a sensor without errors, whose six angles "
    "are 1 to 6 arcsec. $n_(i j)$: pulses of axis $i$ over a turn forward minus those "
    "back, about z (1), x (2), y (3). $N_i (j)$: mean count of axis $i$, z up (1), z "
    "down, x up, x down, y up, y down (6)."
)
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
    paper = study.paper
    open_points = Listing(
        items=tuple(_said(row) for row in study.unexplained),
        empty=say("Nothing is left open."),
    )
    assumed = Listing(
        items=tuple((capital(say(text)),) for text in paper.assumptions),
        empty=say("Nothing: the paper says all that is needed."),
    )
    ratios = ForPages(lambda: (chart_picture(ratio_chart(study)),))
    return (
        _first("unexplained", say("What nothing explains"), open_points),
        _first("assumed", say("Assumed"), assumed),
        replace(
            _first("ratios", say("Random entries of Table 1"), ratios),
            in_brief="",
        ),
        Section(
            name="verdicts",
            title=say("The verdicts"),
            blocks=(verdict_table(study),),
        ),
        *(_section(study, name) for name in paper.sections),
    )


def _first(name: str, title: str, block: Block) -> Section:
    """Return a section of page one."""
    return Section(name=name, title=title, blocks=(block,), on_first_page=True)


def to_csv(study: PaperStudy) -> str:
    """Write one line for each row, numbers with all their digits."""
    return csv_text(COLUMNS, map(vars, study.findings))


def verdict_table(study: PaperStudy) -> Table:
    """Return how many rows have each verdict, and what it means."""
    return table_of(
        study.counts.items(),
        (
            Field(
                head=say("verdict"),
                cell=lambda count: Cell(
                    text=say(count[0].value),
                    strong=count[0] == Verdict.UNEXPLAINED,
                ),
            ),
            Field(
                head=say("rows"),
                kind="number",
                cell=lambda count: Cell(text=str(count[1]), exact=count[1]),
            ),
            Field(
                head=say("meaning"),
                cell=lambda count: say(study.paper.verdicts[count[0]]),
            ),
        ),
        name="verdict-counts",
        caption=say("Rows of each verdict and what it means"),
        is_wide=True,
    )


def findings_table(study: PaperStudy, section: str) -> Table:
    """Return every finding of one section, without columns that would be empty.

    Grouped by where the findings stand in the paper.
    """
    rows = study.of_section(section)
    kind = "text" if all(row.quantity == WORD for row in rows) else "number"
    # Formulas are hard to read in pieces; beside numbers all is as wide as it asks.
    where, formula, why = (0.95, 1.3, 1.2) if section == "formulas" else (1.0,) * 3
    fields: tuple[Field[Finding], ...] = (
        Field(head=say("where"), weight=where, cell=_place),
        Field(
            head=say("printed"),
            kind=kind,
            weight=formula,
            cell=lambda row: printed_cell(row.printed),
        ),
        Field(
            head=say("ours"),
            kind=kind,
            weight=formula,
            cell=lambda row: _ours(row, kind=kind),
        ),
        Field(
            head=say("ours / printed"),
            kind="number",
            cell=lambda row: Cell(text=print_ratio(row.ratio), exact=row.ratio),
        ),
        Field(
            head=say("p, single"),
            kind="number",
            cell=lambda row: _probability(row.p_single),
        ),
        Field(
            head=say("p, mean"),
            kind="number",
            cell=lambda row: _probability(row.p_mean),
        ),
        Field(
            head=say("verdict, and why"),
            weight=why,
            cell=lambda row: Cell(
                text=say(row.verdict.value),
                strong=row.verdict == Verdict.UNEXPLAINED,
                note=reason(row),
            ),
        ),
    )
    groups = list(dict.fromkeys(row.place[0] for row in rows))
    return table_of(
        sorted(rows, key=lambda row: groups.index(row.place[0])),
        [replace(field, optional=True) for field in fields],
        name=f"findings-{section.replace(' ', '-')}",
        caption=say(study.paper.sections[section]),
        by=lambda row: capital(say(row.place[0])),
        titled=True,
        is_wide=True,
        searchable=True,
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


def _ours(row: Finding, *, kind: str) -> Cell:
    """Return what came out; words beside numbers are small: the column stays narrow."""
    if not isinstance(row.ours, str):
        note = say(QUANTITIES.get(row.quantity, ""))
        return Cell(text=print_ours(row), exact=row.ours, note=note)
    ours = say(row.ours)
    return Cell(text="", note=ours) if kind == "number" else Cell(text=ours)


def _probability(p: float | None) -> Cell:
    """Return how probable what is printed is."""
    return Cell(text=print_probability(p), exact=p)


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


def _said(row: Finding) -> Words:
    """Say in a line what is printed and what comes out."""
    printed = printed_cell(row.printed)
    before = f"{printed.note} " if printed.note else ""
    exact = None if row.quantity == WORD else float(row.ours)
    return say_words(
        "{where}: printed {what}{printed}, ours {ours} ({quantity})",
        where=capital(say(row.where)),
        what=before,
        printed=Run(text=printed.text, exact=printed.exact),
        ours=Run(text=print_ours(row), exact=exact),
        quantity=say(row.quantity),
    )


def _section(study: PaperStudy, name: str) -> Section:
    """Return one part of the paper: how to read it, its figures, its findings."""
    note = OF_FORMULAS if name == "formulas" else study.paper.notes.get(name, "")
    blocks: tuple[Block, ...] = ()
    if note:
        blocks = (Paragraph(words=with_math(say(note))),)
    if name == "figures":
        text = blocks  # on how to read the curves
        drawing = ForPages(
            lambda: (*text, Abreast(blocks=tuple(map(sweep_picture, study.sweeps))))
        )
        blocks = (drawing,)
    return Section(
        name=name.replace(" ", "-"),
        title=say(study.paper.sections[name]),
        blocks=(*blocks, findings_table(study, name)),
    )


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
