"""`budget paper`: every number and claim of the paper beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from budget.cli import options


def paper(
    *,
    output: Annotated[list[Path] | None, options.OUTPUT] = None,
    paper: options.Paper = "a4",
    _templates: options.Templates = None,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
    language: options.Language = "en",
) -> None:
    """Compute section 3 of Zhao 2019 again, with a verdict for every number in it.

    Table 1, the figures, the orders of magnitude in the text, the formulas and the
    conclusions: what is printed, ours, their ratio, and why they differ.
    """
    from budget.cli.output import (
        check_destinations,
        hand_out,
        pages_of,
    )
    from budget.language import say, speaking
    from budget.report.document import json_text, table_csv
    from budget.report.rendering import check_suffixes, document_date
    from zhao_2019.page import paper_document, paper_sections
    from zhao_2019.study import reproduce

    check_destinations(json, csv, *(output or ()))
    pages = output or []
    check_suffixes(pages, paper)
    study = reproduce()

    rendered: dict[Path, str | bytes] = {}
    with speaking(language):
        title = say(study.paper.title)
        document = paper_document(study, date=document_date()) if pages else None
    if document is not None:
        rendered = pages_of(document, pages, paper)
    hand_out(
        [
            (json, lambda: json_text(study.to_dict())),
            (csv, lambda: table_csv("finding", study.findings)),
        ],
        None if pages else lambda: paper_sections(study),
        title=title,
        pages=rendered,
        language=language,
    )
