"""`budget paper`: every number and claim of the paper beside ours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer  # noqa: TC002 - typer reads the annotations

from budget.cli import options

if TYPE_CHECKING:
    from budget.report.blocks import Document


@options.asking("paper")
def paper(context: typer.Context, *, out: options.OutputFiles) -> None:
    """Compute section 3 of Zhao 2019 again, with a verdict for every number in it.

    Table 1, the figures, the orders of magnitude in the text, the formulas and the
    conclusions: what is printed, ours, their ratio, and why they differ.
    """
    from budget.cli.output import check_files, hand_out, pages_asked
    from budget.language import say, speaking
    from budget.report.document import json_text, table_csv
    from budget.settings import Inputs
    from zhao_2019.page import paper_document, paper_sections
    from zhao_2019.study import reproduce

    def make(*, date: str, command_line: str) -> Document:
        del command_line  # one for all who compute it
        return paper_document(study, date=date)

    check_files(out, Inputs())
    study = reproduce()
    with speaking(out.language):
        title = say(study.paper.title)
    hand_out(
        [
            (out.json, lambda: json_text(study.to_dict())),
            (out.csv, lambda: table_csv("finding", study.findings)),
        ],
        None if out.output else lambda: paper_sections(study),
        title=title,
        pages=pages_asked(context, out, make),
        language=out.language,
    )
