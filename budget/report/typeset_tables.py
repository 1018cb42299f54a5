"""Tables of a PDF: how wide their columns are, and cells cut into parts."""

from __future__ import annotations

import textwrap
from math import sqrt
from typing import TYPE_CHECKING, Any

from budget.report.fonts import text_width
from budget.report.typeset_text import break_long, cut_numbers, shorten

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Column, RowGroup, Table
    from budget.report.typeset_text import Part

LONGEST_HEAD = 160  # characters of the head of a column; it is on every page
NARROW_HEAD = 12  # characters of the head of a narrow column before it is broken
CROWDED = 9  # columns; from there on a table is set smaller, its heads broken sooner
CROWDED_HEAD = 7  # characters
SHORT_CELL = 26  # characters; a column of such cells is never narrower than they are
SPLIT_CELL = 1500  # characters; a row with such a cell may go on on the next page
LEAST_SHARE = 11.0  # [em] that a column of long text can do with
SMALL = 0.9  # size of notes over that of the table [1]
RAISED = 0.6  # size of exponents over that of the table [1]


def plain_table(table: Table) -> dict[str, Any]:
    """Return a table as JSON holds it.

    `natural` is how wide it is where no text is broken and `least` how narrow it can
    be where only short texts are not, both without the air between columns [em].
    """
    groups = [_plain_rows(table, group) for group in table.groups]
    rows = [row for group in groups for row in group]
    crowded = len(table.columns) >= CROWDED
    columns = [
        _plain_column(column, [row[k] for row in rows], crowded=crowded)
        for k, column in enumerate(table.columns)
    ]
    return {
        "is": "table",
        "columns": columns,
        "crowded": crowded,
        "natural": sum(column["natural"] for column in columns),
        "least": sum(
            column["natural"] if column["share"] is None else LEAST_SHARE
            for column in columns
        ),
        "groups": [
            {"title": break_long(group.title), "rows": plain}
            for group, plain in zip(table.groups, groups, strict=True)
        ],
    }


def _plain_column(
    column: Column, cells: Sequence[dict[str, Any]], *, crowded: bool
) -> dict[str, Any]:
    """Return a column; long text has a share of the width instead of its own."""
    longest = max((max(len(c["plain"]), len(c["note"])) for c in cells), default=0)
    head = break_long(shorten(column.head, LONGEST_HEAD))
    if crowded or column.kind != "text":
        narrow = max(CROWDED_HEAD if crowded else NARROW_HEAD, longest)
        lines = textwrap.wrap(head, width=narrow, break_long_words=False)
        head = "\n".join(lines)
    widths = [text_width(line, bold=True) for line in head.split("\n")]
    widths += [text_width(c["plain"], bold=c["strong"]) for c in cells]
    widths += [SMALL * text_width(c["note"]) for c in cells]
    wraps = column.kind == "text" and longest > SHORT_CELL
    # Text twice as long is set wider and higher, both by the root of two.
    share = column.weight * sqrt(max(1.0, longest / SHORT_CELL)) if wraps else None
    return {
        "head": head,
        "kind": column.kind,
        "natural": max(widths),
        "share": share,
    }


def _plain_rows(table: Table, group: RowGroup) -> list[list[dict[str, Any]]]:
    """Return the rows of a group, decimal points in line within each column."""
    wholes = [
        # A row is split between pages if one of its cells would fill one.
        all(len(cell.text) + len(cell.note) < SPLIT_CELL for cell in row)
        for row in group.rows
    ]
    by_column = []
    for place, column in enumerate(table.columns):
        cells = [row[place] for row in group.rows]
        texts = [cell.text for cell in cells]
        numeric = column.kind == "number"
        parts = cut_numbers(texts) if numeric else [break_long(t) for t in texts]
        by_column.append(
            [
                {
                    "text": part,
                    "plain": _join(part),
                    "share": cell.share,
                    "strong": cell.strong,
                    "note": break_long(cell.note),
                    "whole": whole,
                }
                for part, cell, whole in zip(parts, cells, wholes, strict=True)
            ]
        )
    return [list(row) for row in zip(*by_column, strict=True)]


def _join(part: Part) -> str:
    """Write a part about as wide as it will be."""
    if isinstance(part, str):
        return part
    power = part["power"]
    raised = power[: round(RAISED * len(power))]
    times = f"\u202f\N{MULTIPLICATION SIGN}\u202f10{raised}" if power else ""
    return f"{part['head']}{part['digits']}{times}{part['tail']}{part['pad']}"
