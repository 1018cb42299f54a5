"""`budget paper`: every number and claim of the paper beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.cli.streams import console


def paper(
    *,
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Page to write, .html or .pdf; may be given twice.",
            show_default=False,
        ),
    ] = None,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Compute section 3 of Zhao 2019 again, with a verdict for every number in it.

    Table 1, the figures, the orders of magnitude in the text, the formulas and the
    conclusions: what is printed, ours, their ratio, and why they differ.
    """
    from budget.cli.output import (
        check_destinations,
        check_suffixes,
        document_date,
        hand_out,
        render_pages,
    )
    from budget.report.document import json_text
    from budget.report.paper.page import paper_document, paper_sections, to_csv
    from budget.report.terminal import Page, print_sections
    from budget.studies.paper.study import reproduce

    check_destinations(json, csv, *(output or ()))
    pages = output or []
    check_suffixes(pages)
    study = reproduce()

    def show() -> None:
        page = Page(console())
        page.heading(study.paper.title, style="bold")
        print_sections(paper_sections(study), page)

    rendered: dict[Path, str | bytes] = {}
    if pages:
        rendered = render_pages(paper_document(study, date=document_date()), pages)
    hand_out(
        [(json, lambda: json_text(study.to_dict())), (csv, lambda: to_csv(study))],
        None if pages else show,
        pages=rendered,
    )
