"""The paper beside ours, as text for a terminal, as JSON and as CSV: formats only."""

from __future__ import annotations

import csv
import io
import json
import textwrap
from typing import TYPE_CHECKING, Any

from budget.report.tables import print_given, round_uncertainty
from budget.results import SCHEMA
from budget.studies.paper.findings import (
    AGREES,
    UNEXPLAINED,
    VALUE,
    VERDICTS,
    say,
)
from budget.studies.paper.study import ASSUMPTIONS, SECTIONS, TITLE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.studies.paper.findings import Finding
    from budget.studies.paper.study import PaperStudy

COLUMNS = (
    "section",
    "where",
    "printed",
    "ours",
    "quantity",
    "ratio",
    "verdict",
    "p_single",
    "p_mean",
    "why",
)
HEADS = ("printed", "ours", "ours/printed", "verdict")
TEXT_WIDTH = 100  # of running text, however wide the terminal
NEAR_ONE = 1e-3  # a ratio this close to 1 is printed with all its digits [1]
LEAST_P = 1e-6  # [1]; below it a probability is printed as such


def print_ours(row: Finding) -> str:
    """Print ours: six digits of a value, two of a standard uncertainty, or a word."""
    if isinstance(row.ours, str):
        return row.ours
    if row.quantity == VALUE:
        return print_given(row.ours, digits=6)
    return round_uncertainty(row.ours)


def print_ratio(ratio: float | None) -> str:
    """Print ours over printed, '' where there is none."""
    if ratio is None:
        return ""
    if abs(ratio - 1.0) < NEAR_ONE:
        return f"{ratio:.6f}"
    return print_given(ratio, digits=3)


def print_probability(p: float | None) -> str:
    """Print a probability to two digits, '' where there is none."""
    if p is None:
        return ""
    return f"<{say(LEAST_P)}" if p < LEAST_P else say(p)


def shorten(row: Finding) -> str:
    """Name the place without what the title of its section says already."""
    text = row.where
    for prefix in ("Table 1, ", "section "):
        if row.section != "readings":
            text = text.removeprefix(prefix)
    return text


def unexplained(study: PaperStudy) -> tuple[Finding, ...]:
    """Return what nothing explains, entries of one row gathered."""
    return tuple(
        row for row in study.findings if row.verdict == UNEXPLAINED and row.is_summary
    )


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
    lines = [TITLE, ""]
    total = sum(number for _, number in study.counts)
    lines.append(f"{total} numbers and claims of the paper, of which")
    lines += [f"{number:5d}  {word}" for word, number in study.counts]
    lines += ["", "Nothing explains"]
    for row in unexplained(study):
        text = f"{row.where}: printed {row.printed}, ours {print_ours(row)}"
        lines += _wrap(f"{text} ({row.quantity})", width, first="- ")
    for section, title in SECTIONS.items():
        lines += ["", *_wrap(title, width, first=""), "=" * min(len(title), width)]
        lines += _section_lines(study.of_section(section), width)
    lines += ["", "Verdicts", "========"]
    for word, text in VERDICTS.items():
        lines += _wrap(text, width, first=f"{word}: ")
    lines += ["", "Assumed", "======="]
    for text in ASSUMPTIONS:
        lines += _wrap(text, width, first="- ")
    return "\n".join(line.rstrip() for line in lines) + "\n"


def paper_document(study: PaperStudy) -> dict[str, Any]:
    """Return the JSON document of schema `budget/1`, full precision."""
    return {
        "schema": SCHEMA,
        "command": "paper",
        "title": TITLE,
        "inputs": {
            file.role: {"name": file.name, "sha256": file.sha256}
            for file in study.inputs
        },
        "rows": [
            {name: getattr(row, name) for name in COLUMNS} for row in study.findings
        ],
        "verdicts": dict(VERDICTS),
        "sweeps": [
            {
                "figure": sweep.figure,
                "source": sweep.source,
                "parameter": sweep.parameter,
                "size": sweep.size.tolist(),
                "errors": dict(zip(sweep.names, sweep.errors.tolist(), strict=True)),
            }
            for sweep in study.sweeps
        ],
        "coupling": [
            {
                "source": cell.source,
                "group": cell.group,
                "reaches": cell.reaches,
                "size": cell.size,
            }
            for cell in study.table.cells
        ],
        "assumptions": list(ASSUMPTIONS),
        "warnings": [],
    }


def paper_json(study: PaperStudy) -> str:
    """Write the JSON document."""
    document = paper_document(study)
    return json.dumps(document, allow_nan=False, ensure_ascii=False, indent=1) + "\n"


def paper_csv(study: PaperStudy) -> str:
    """Write one line for each row, numbers with all their digits."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in study.findings:
        writer.writerow([_cell(getattr(row, name)) for name in COLUMNS])
    return text.getvalue()


def _cell(value: str | float | None) -> str:
    """Write a number with all its digits, nothing for None."""
    if value is None:
        return ""
    return value if isinstance(value, str) else repr(float(value))


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
    if row.verdict == AGREES and not row.is_summary:
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
