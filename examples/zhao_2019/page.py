"""Reproduction of the paper as a document: verdicts, then every number and claim."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from budget.language import ENGLISH, spoken
from budget.report.blocks import Abreast, Cell, Document, ForPages
from budget.report.document import json_text
from budget.report.figures.rows import chart_picture
from budget.report.formulas import with_math
from budget.report.pages import blocks, document
from budget.report.provenance import provenance_section
from budget.report.tables import print_given, round_uncertainty
from zhao_2019.figures import print_ratio, ratio_chart, sweep_plot
from zhao_2019.printed import (
    U_MEAN,
    U_SINGLE,
    VALUE,
    WORD,
    Agreement,
    say_number,
)

if TYPE_CHECKING:
    from budget.report.blocks import Section
    from budget.report.pages import Page
    from zhao_2019.printed import Finding
    from zhao_2019.study import PaperStudy

COMMAND = "budget paper"
LEAST_P = 1e-6  # [1]; below it a probability is printed as such
# A printed number, and what it is where it is not the entry itself: 'rms 4.74e-9'.
PRINTED = re.compile(r"(?P<head>rms |)(?P<number>-?[0-9.]+(?:e-?[0-9]+)?)(?P<tail>.*)")
# Short, below a number.
QUANTITIES = {U_SINGLE: "u, single", U_MEAN: "u, mean"}


def paper_document(study: PaperStudy, *, date: str) -> Document:
    """Put the whole study into one document."""
    is_english = spoken() == ENGLISH
    provenance = provenance_section(
        study.inputs,
        None,
        command_line=COMMAND if is_english else f"{COMMAND} --language {spoken()}",
    )
    document = json_text(study.to_dict())
    return _page(study).whole("paper", provenance, json=document, date=date)


def paper_sections(study: PaperStudy) -> tuple[Section, ...]:
    """Return the sections that page and terminal have in common, the answer first."""
    return _page(study).sections


def _page(study: PaperStudy) -> Page:
    """Return what page and terminal say."""
    note = study.paper.notes["figures"]
    return document(
        "paper",
        study=study,
        paper=study.paper,
        ratios=ForPages(lambda: (chart_picture(ratio_chart(study)),)),
        pictures=ForPages(
            lambda: (
                *blocks("figures_paper", "note", text=note, with_math=with_math),
                Abreast(blocks=tuple(sweep_plot(one).picture for one in study.sweeps)),
            )
        ),
        UNEXPLAINED=Agreement.UNEXPLAINED,
        U_MEAN=U_MEAN,
        U_SINGLE=U_SINGLE,
        WORD=WORD,
        print_ours=print_ours,
        print_ratio=print_ratio,
        print_probability=print_probability,
        printed_cell=printed_cell,
        reason=reason,
        with_math=with_math,
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


def print_ours(row: Finding) -> str:
    """Print ours: six digits of a value, two of a standard uncertainty, or a word."""
    if isinstance(row.ours, str):
        return row.ours
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
    return "" if row.why.startswith("judged with") else row.why
