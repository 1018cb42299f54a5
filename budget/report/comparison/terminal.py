"""The comparison on a terminal: one wide table, or two that fit beside each other."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.comparison.tables import (
    COLUMNS,
    PAIRS_SHOWN,
    print_at_most,
    side_by_side,
    tables,
)
from budget.report.comparison.wording import (
    advice_lines,
    cap_lines,
    missing_lines,
    not_compared_lines,
    nothing_known_line,
    unknown_cap_lines,
    verdict_lines,
)
from budget.report.tables import (
    align_decimals,
    print_probability,
    print_utilisation,
    settings_lines,
)
from budget.report.terminal import GAP, SETTING, SIGNS, Page, set_columns

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rich.console import Console

    from budget.report.comparison.tables import Column, Row, Table
    from budget.studies.comparison.records import Comparison

# The second of two tables says why; rank and device stand in both.
WHY = ("worst_output", "limiting_source", "factor", "missing", "at_worst")
MAY_BE_EMPTY = ("interval", "missing", "at_worst")
BOTH = ("rank", "device")
ALIGNED = ("utilisation", "conformance", "factor")
FLUSH_LEFT = (
    "device",
    "verdict",
    "interval",
    "worst_output",
    "limiting_source",
    "at_worst",
)
LONGEST_DEVICE = 30  # characters; a longer name is cut
LEGEND = {
    "": "=: not told apart from a neighbour at 95 %.",
    "interval": "interval: 95 %, of the sampling, and what the law can be off by.",
    "conformance": "conform %: probability that all required outputs are within their "
    "limits.",
    "factor": "factor: times this, the u of the limiting source alone would bring the "
    "worst output to its limit, by the law; -: it alone cannot.",
    "missing": "missing: expected lines that the data sheet does not give; they count "
    "as 0, so that the error is this or more (>=), and one stops a `meets`.",
    "at_worst": "at worst: % of limit by the law with the worst of the catalogue of "
    "the same technology and grade in their place, named below; ?: there is none.",
}


def render_comparison(
    comparison: Comparison, console: Console, *, sort: Column | None = None
) -> None:
    """Print who meets, the ranked devices, and what the ranking rests on.

    Parameters
    ----------
    comparison : Comparison
        The result.
    console : rich.console.Console
        Its width and encoding decide the layout.
    sort : Column, optional
        What the tables are sorted by, in place of the rank.
    """
    page = Page(console)
    page.line(f"Against {comparison.requirement}", style="bold")
    found = tables(comparison, sort=sort)
    several = len(comparison.procedures) > 1
    for text in (*verdict_lines(found), *not_compared_lines(comparison)):
        page.paragraph(text, first="- ")
    with_rows = dict.fromkeys(table.sensor for table in found if table.rows)
    for sensor in with_rows if several else ():
        page.line()
        _print_side_by_side(found, sensor, page)
    for table in found:
        page.line()
        _print_table(table, page, several=several)
    if comparison.devices:
        page.line()
        page.paragraph(_legend(found))
    _print_pairs(comparison, page)
    for label, lines in (
        ("In the place of missing lines", missing_lines(comparison)),
        ("Advice", advice_lines(comparison)),
        ("Over a cap", cap_lines(comparison)),
        ("Not known whether over a cap", unknown_cap_lines(comparison)),
        ("Warnings", comparison.warnings),
    ):
        if lines:
            page.line()
            page.line(label, style="bold")
        for text in lines:
            page.paragraph(text, first="- ")
    page.line()
    number = len(comparison.assumptions)
    page.line(
        f"Assumptions: {number}, all in --json" if number else "Assumptions: none",
        style="bold",
    )
    page.line()
    page.line("Settings", style="bold")
    for label, text in settings_lines(comparison.settings):
        page.paragraph(text, first=f"{label:<{SETTING}}")


def _print_table(table: Table, page: Page, *, several: bool) -> None:
    """Print the devices with one sensor under one procedure."""
    title = f"{table.sensor.capitalize()}: {table.counts}"
    if several:
        title = f"{table.sensor.capitalize()}, {table.procedure}: {table.counts}"
    page.line(title, style="bold underline")
    if unknown := nothing_known_line(table):
        page.paragraph(unknown)
    if not table.rows:
        return
    keys = [column.key for column in COLUMNS]
    for key in MAY_BE_EMPTY:
        if not any(getattr(row, key) for row in table.rows):
            keys.remove(key)
    head, lines = _set(table.rows, keys)
    if len(head) <= page.width:
        _print_lines(page, head, lines)
        return
    _print_lines(page, *_set(table.rows, [key for key in keys if key not in WHY]))
    page.line()
    why = [key for key in keys if key in (*BOTH, *WHY)]
    _print_lines(page, *_set(table.rows, why))


def _legend(found: Sequence[Table]) -> str:
    """Explain the columns that are there."""
    rows = [row for table in found for row in table.rows]
    said = []
    for key, text in LEGEND.items():
        if key:
            is_there = key not in MAY_BE_EMPTY or any(getattr(row, key) for row in rows)
        else:
            is_there = any("=" in row.rank for row in rows)
        if is_there:
            said.append(text)
    return " ".join(said)


def _set(rows: Sequence[Row], keys: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Set some columns of a table as text lines of one width."""
    chosen = [column for column in COLUMNS if column.key in keys]
    columns = []
    for column in chosen:
        texts = [getattr(row, column.key).translate(SIGNS) or "-" for row in rows]
        if column.key == "rank":  # a tie is marked behind the digits
            mark = any("=" in text for text in texts)
            texts = [text if "=" in text or not mark else f"{text} " for text in texts]
        if column.key in MAY_BE_EMPTY:
            texts = ["" if text == "-" else text for text in texts]
        if column.key == "device":
            texts = [cut(text) for text in texts]
        if column.key in ALIGNED:
            texts = list(align_decimals(texts))
        columns.append(_flush(column, texts))
    heads = [
        column.head.ljust(len(texts[0])) if column.key in FLUSH_LEFT else column.head
        for column, texts in zip(chosen, columns, strict=True)
    ]
    return set_columns(heads, columns, flush_left=False)


def _flush(column: Column, texts: Sequence[str]) -> list[str]:
    """Pad words on the right, so that they are set flush left."""
    if column.key not in FLUSH_LEFT:
        return list(texts)
    width = max(len(column.head), *(len(text) for text in texts))
    return [text.ljust(width) for text in texts]


def cut(text: str) -> str:
    """Cut a long name, showing that it was."""
    return text if len(text) <= LONGEST_DEVICE else f"{text[: LONGEST_DEVICE - 3]}..."


def _print_lines(page: Page, head: str, lines: Iterable[str]) -> None:
    """Print a table."""
    page.line(head, style="bold")
    for line in lines:
        page.line(line)


def _print_side_by_side(found: Sequence[Table], sensor: str, page: Page) -> None:
    """Print one table with a column for each procedure."""
    rows = side_by_side(found, sensor)
    procedures = [table.procedure for table in found if table.sensor == sensor]
    page.line(
        f"{sensor.capitalize()}: % of limit and verdict by procedure",
        style="bold underline",
    )
    columns: list[Sequence[str]] = [[cut(row.device) for row in rows]]
    for place in range(len(procedures)):
        pairs = [row.cells[place].translate(SIGNS).rsplit(" ", 1) for row in rows]
        numbers = align_decimals([number for number, _ in pairs])
        widest = max(len(number) for number in numbers)
        columns.append(
            [
                f"{number:>{widest}} {word:<11}"
                for number, (_, word) in zip(numbers, pairs, strict=True)
            ]
        )
    heads = ["device", *(cut(name) for name in procedures)]
    width = len(set_columns(heads, columns)[0])
    if width <= page.width:
        _print_lines(page, *set_columns(heads, columns))
        return
    for row in rows:
        page.line(cut(row.device))
        for name, cell in zip(procedures, row.cells, strict=True):
            page.paragraph(f"{name}: {cell}", first=" " * GAP)


def _print_pairs(comparison: Comparison, page: Page) -> None:
    """Print the best pairs of gyro and accelerometer; the rest is counted."""
    if not comparison.pairs:
        return
    shown = comparison.pairs[:PAIRS_SHOWN]
    page.line()
    page.line("Pairs, within all limits of both together", style="bold underline")
    several = len(comparison.procedures) > 1
    heads = ["gyro", "accelerometer", "verdict", "% of limit", "conform %"]
    words = [
        [cut(pair.gyro) for pair in shown],
        [cut(pair.accelerometer) for pair in shown],
        [pair.verdict for pair in shown],
    ]
    columns = [
        [text.ljust(max(len(t) for t in (*texts, head))) for text in texts]
        for head, texts in zip(heads, words, strict=False)
    ]
    heads[1], heads[2] = (heads[k].ljust(len(columns[k][0])) for k in (1, 2))
    columns.append(
        list(
            align_decimals(
                [
                    f"{'>= ' if p.lower_bound else ''}"
                    + print_utilisation(p.utilisation).removesuffix(" %")
                    for p in shown
                ]
            )
        )
    )
    columns.append(
        list(
            align_decimals(
                [
                    print_at_most(p.conformance).translate(SIGNS)
                    if p.lower_bound
                    else print_probability(p.conformance)
                    for p in shown
                ]
            )
        )
    )
    if several:
        heads.append("procedure")
        columns.append([cut(pair.procedure) for pair in shown])
    _print_lines(page, *set_columns(heads, columns))
    rest = len(comparison.pairs) - len(shown)
    if rest:
        page.line(f"and {rest} more, all in --json")
