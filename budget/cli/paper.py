"""`budget paper`: every number and claim of the paper beside ours."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options
from budget.cli.streams import console, say_written, tell


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
        printing,
        render_pages,
    )
    from budget.report.files import write_all
    from budget.report.paper.document import to_csv, to_json
    from budget.report.paper.page import paper_document
    from budget.report.paper.terminal import paper_text
    from budget.studies.paper.study import reproduce

    check_destinations(json, csv, *(output or ()))
    pages = output or []
    check_suffixes(pages)
    study = reproduce()
    documents = [(json, to_json), (csv, to_csv)]
    on_stdout = [render for path, render in documents if path == options.STDOUT]
    files: dict[Path, str | bytes] = {
        path: render(study)
        for path, render in documents
        if path not in {None, options.STDOUT}
    }
    if pages:
        files |= render_pages(paper_document(study, date=document_date()), pages)
    write_all(files)
    say_written(pages)
    with printing():
        if on_stdout:
            sys.stdout.write(on_stdout[0](study))
        elif not pages:
            tell(paper_text(study, width=console().width))
