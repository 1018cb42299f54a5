"""The paper beside ours as text for a terminal."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from budget.report.paper.printing import (
    print_ours,
    print_probability,
    print_ratio,
    shorten,
    unexplained,
)
from budget.studies.paper.findings import Verdict

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

HEADS = ("printed", "ours", "ours/printed", "verdict")
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
        (
            shorten(row),
            row.printed,
            print_ours(row),
            print_ratio(row.ratio),
            row.verdict,
        )
        for row in rows
    ]
    heads = ("", *HEADS)
    widths = [
        max(len(head), *(len(cell[k]) for cell in cells))
        for k, head in enumerate(heads)
    ]
    if sum(widths) + 2 * len(widths) > width:
        return _stacked_lines(rows, cells, width)
    lines = [_set(heads, widths)]
    for row, cell in zip(rows, cells, strict=True):
        lines.append(_set(cell, widths))
        lines += _why_lines(row, width)
    return lines


def _stacked_lines(
    rows: Sequence[Finding], cells: Sequence[tuple[str, ...]], width: int
) -> list[str]:
    """Set each row as its place and verdict, then what stands there and ours."""
    lines = []
    for row, (where, printed, ours, ratio, verdict) in zip(rows, cells, strict=True):
        lines += _wrap(f"{where}: {verdict}", width, first="")
        parts = [f"printed {printed}", f"ours {ours}"]
        if ratio:
            parts.append(f"ratio {ratio}")
        lines += _wrap("; ".join(parts), width, first="    ")
        lines += _why_lines(row, width)
    return lines


def _why_lines(row: Finding, width: int) -> list[str]:
    """Say why, where it is not said by the verdict or by the row above."""
    if row.verdict == Verdict.AGREES and not row.is_summary:
        return []
    if row.why.startswith("judged with"):
        return []
    why = row.why
    if row.p_single is not None and row.p_mean is not None:
        why = (
            f"p {print_probability(row.p_single)} (single run), "
            f"{print_probability(row.p_mean)} (mean over 25); {why}"
        )
    return _wrap(why, width, first="    ")


def _set(cells: Sequence[str], widths: Sequence[int]) -> str:
    """Set one line: numbers flush right, names and verdicts flush left."""
    where, *numbers, verdict = cells
    texts = [where.ljust(widths[0])]
    texts += [text.rjust(w) for text, w in zip(numbers, widths[1:-1], strict=True)]
    return "  ".join([*texts, verdict])


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
