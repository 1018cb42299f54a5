"""The paper beside ours as text for a terminal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from budget.report.paper.texts import (
    print_ours,
    print_probability,
    print_ratio,
    reason,
    shorten,
    unexplained,
)
from budget.report.terminal import GAP, set_columns
from budget.studies.paper.findings import Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

HEADS = ("", "printed", "ours", "ours/printed")  # and the verdict, flush left
TEXT_WIDTH = 100  # of running text, however wide the terminal


def paper_text(study: PaperStudy, *, width: int) -> str:
    """Write all findings as text.

    Parameters
    ----------
    study : PaperStudy
    width : int
        Of the terminal; rows that do not fit are set one field a line [columns].

    Returns
    -------
    str
        Ends with a line feed; ASCII.
    """
    paper, total = study.paper, len(study.findings)
    lines = [paper.title, "", f"{total} numbers and claims of the paper, of which"]
    lines += [f"{number:5d}  {word}" for word, number in study.counts.items()]
    lines += ["", "Nothing explains"]
    for row in unexplained(study):
        text = f"{row.where}: printed {row.printed}, ours {print_ours(row)}"
        lines += _wrap(f"{text} ({row.quantity})", width, first="- ")
    for section, title in paper.sections.items():
        lines += ["", *_wrap(title, width, first=""), "=" * min(len(title), width)]
        lines += _section_lines(study.of_section(section), width)
    lines += ["", "Verdicts", "========"]
    for word, text in paper.verdicts.items():
        lines += _wrap(text, width, first=f"{word}: ")
    lines += ["", "Assumed", "======="]
    for text in paper.assumptions:
        lines += _wrap(text, width, first="- ")
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _section_lines(rows: Sequence[Finding], width: int) -> list[str]:
    """Set the rows of one section as a table, or one field a line."""
    cells = [
        (shorten(row), row.printed, print_ours(row), print_ratio(row.ratio))
        for row in rows
    ]
    head, table = set_columns(HEADS, list(zip(*cells, strict=True)))
    verdict = max(len(text) for text in ("verdict", *(row.verdict for row in rows)))
    is_narrow = len(head) + verdict + 2 * GAP > width
    lines = [] if is_narrow else [f"{head}  verdict"]
    for row, (where, printed, ours, ratio), line in zip(
        rows, cells, table, strict=True
    ):
        if is_narrow:
            text = f"printed {printed}; ours {ours}"
            text += f"; ratio {ratio}" if ratio else ""
            lines += _wrap(f"{where}: {row.verdict}", width, first="")
            lines += _wrap(text, width, first="    ")
        else:
            lines.append(f"{line}  {row.verdict}")
        lines += _wrap(_why(row), width, first="    ")
    return lines


def _why(row: Finding) -> str:
    """Say why, where it is not said by the verdict or by the row above."""
    if row.verdict == Verdict.AGREES and not row.is_summary:
        return ""
    why = reason(row)
    if not why or row.p_single is None or row.p_mean is None:
        return why
    return (
        f"p {print_probability(row.p_single)} (single run), "
        f"{print_probability(row.p_mean)} (mean over 25); {why}"
    )


def _wrap(text: str, width: int, *, first: str) -> list[str]:
    """Break running text; lines after the first are indented below it."""
    indent = " " * min(len(first), 4)
    return textwrap.wrap(
        text,
        min(width, TEXT_WIDTH),
        initial_indent=first,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
