"""References on a terminal: what holds in a line, what moved in full; differences."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from budget.references.records import TOOL
from budget.report.reference.tables import (
    NONE,
    MoveTable,
    change_lines,
    move_table,
)
from budget.report.tables import align_decimals
from budget.report.terminal import GAP, SIGNS, Page, set_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from budget.references.records import Change, Difference
    from budget.report.reference.tables import Group

HEADS = {"check": ("stored", "now"), "diff": ("A", "B")}
INDENT = " " * GAP


def render_checks(checks: Sequence[Difference], bad: int, console: Console) -> None:
    """Print one line for each reference that holds, and all about those that moved.

    Parameters
    ----------
    checks : sequence of Checked
        References that could be computed.
    bad : int
        How many could not.
    console : rich.console.Console
        Its width and encoding decide the layout.
    """
    page = Page(console)
    width = max((len(one.first) for one in checks), default=0)
    for one in checks:
        text = f"{one.first:<{width}}  {_verdict(one)}"
        if len(text) <= page.width:
            page.line(text, style=_style(one))
        else:
            _wrap(one.first, page, style=_style(one))
            _wrap(_verdict(one), page, first=INDENT, style=_style(one))
        own = [change for change in one.changes if change.where != TOOL]
        for text in change_lines(own, moved=False) if one.holds else ():
            page.paragraph(text, first=f"{INDENT}changed  ")
    moved = {one.first: move_table(one.moves) for one in checks if not one.holds}
    for one in checks:
        if not one.holds:
            page.line()
            _wrap(f"{one.first}: what moved, the largest first", page, style="bold")
            _print_moves("check", one.changes, moved[one.first], page)
    _print_legend(tuple(moved.values()), page, command="check")
    tool = [
        f"{change.key} {change.before} -> {change.after}"
        for one in checks
        for change in one.changes
        if one.holds and change.where == TOOL
    ]
    if tool:
        page.line()
        page.paragraph(
            ", ".join(dict.fromkeys(tool)), first="stored with other versions: "
        )
    held = sum(one.holds for one in checks)
    page.line()
    counts = [f"{held} hold", f"{len(checks) - held} moved"]
    if bad:
        counts.append(f"{bad} cannot be checked")
    number = len(checks) + bad
    noun = "reference" if number == 1 else "references"
    _wrap(f"{number} {noun}: {', '.join(counts)}", page, style="bold")


def render_difference(difference: Difference, console: Console) -> None:
    """Print two budgets side by side, the largest change first."""
    page = Page(console)
    for label, name in (("A", difference.first), ("B", difference.second)):
        _wrap(name, page, first=f"{label}  ", style="bold")
    page.line()
    moved = len(difference.moves)
    page.paragraph(f"{moved} of {difference.compared} numbers and words differ")
    table = move_table(difference.moves)
    _print_moves("diff", difference.changes, table, page)
    _print_legend((table,), page, command="diff")


def _verdict(one: Difference) -> str:
    """Say how one reference fared."""
    sampled = f", {one.sampled} sampled" if one.sampled else ""
    if one.holds:
        return f"holds  {one.compared} numbers and words{sampled}"
    return f"MOVED  {len(one.moves)} of {one.compared} numbers and words"


def _style(one: Difference) -> str:
    """Return how a line is set."""
    return "" if one.holds else "bold red"


def _print_moves(
    command: str, changes: Sequence[Change], table: MoveTable, page: Page
) -> None:
    """Print what changed, numbered, and the moves that name these numbers."""
    if changes:
        page.line()
        page.line("What changed", style="bold")
    width = len(str(len(changes)))
    moved = bool(table.groups or table.words)
    for k, text in enumerate(change_lines(changes, moved=moved), start=1):
        number = "" if text.startswith("and ") else str(k)
        first = f"{INDENT}{number:>{width}}  "
        page.paragraph(_breakable(text, page.width - len(first)), first=first)
    if table.words:
        page.line()
    for text in table.words:
        page.paragraph(_breakable(text, page.width - GAP), first=INDENT)
    if table.groups:
        page.line()
        _print_groups(command, table.groups, page)
    if table.rest:
        page.paragraph(f"and {table.rest} more numbers, all in --json")


def _print_groups(command: str, groups: Sequence[Group], page: Page) -> None:
    """Print all groups under one head; the narrower the place, the fewer columns.

    First goes the column `by`, then causes get a line below the row, then labels one
    above it. Numbers are never cut or wrapped.
    """
    columns = ["label", "because"]
    lines = _columns(command, groups, [*columns, "by"])
    for narrower in (columns, ["label"], []):
        if max(map(len, lines)) > page.width:
            columns = narrower
            lines = _columns(command, groups, columns)
    page.line(lines[0], style="bold")
    rest = iter(lines[1:])
    for group in groups:
        _wrap(group.title, page, style="underline")
        for row in group.rows:
            if "label" not in columns and row.label:
                _wrap(row.label, page, first=INDENT)
            page.line(next(rest))
            if "because" not in columns and row.because != NONE:
                _wrap(row.because, page, first=f"{INDENT}because ")


def _columns(
    command: str, groups: Sequence[Group], wanted: Sequence[str]
) -> tuple[str, ...]:
    """Set the rows of all groups under one head, with these columns beside numbers."""
    rows = [row for group in groups for row in group.rows]
    before: list[str] = []
    after: list[str] = []
    for group in groups:  # decimal points in line within a group
        texts = align_decimals(
            [
                text.translate(SIGNS)
                for row in group.rows
                for text in (row.before, row.after)
            ]
        )
        before.extend(texts[0::2])
        after.extend(texts[1::2])
    heads = ["", *HEADS[command], "change"]
    columns: list[Sequence[str]] = [
        [f"{INDENT}{row.label}" if "label" in wanted else INDENT for row in rows],
        before,
        after,
        [row.change for row in rows],
    ]
    if "by" in wanted and command == "check":
        heads.append("by")
        columns.append([row.times for row in rows])
    if "because" in wanted:
        because = [row.because for row in rows]
        width = max(len("because"), *(len(text) for text in because))
        heads.append("because".ljust(width))
        columns.append([text.ljust(width) for text in because])
    head, lines = set_columns(heads, columns)
    return (head, *lines)


def _wrap(text: str, page: Page, *, first: str = "", style: str = "") -> None:
    """Print a text on as many lines as the page needs for it, words whole."""
    for line in textwrap.wrap(
        text,
        page.width,
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
        break_on_hyphens=False,
    ):
        page.line(line, style=style)


def _breakable(text: str, room: int) -> str:
    """Part words that are too long for a line after a dot: the way to a key."""
    words = []
    for word in text.split(" "):
        rest = word
        while len(rest) > room and (place := rest.rfind(".", 1, room) + 1):
            words.append(rest[:place])
            rest = rest[place:]
        words.append(rest)
    return " ".join(words)


def _print_legend(tables: Sequence[MoveTable], page: Page, *, command: str) -> None:
    """Explain the columns that are there, once for all."""
    if not any(table.groups for table in tables):
        return
    text = (
        "change: of the standard uncertainty of the output, or of the number itself "
        "where it belongs to none. because: numbers of the changes above, with the "
        "part of the difference that each explains alone, by the law."
    )
    if any(table.has_together for table in tables):
        text += " together: what all changes do at once beyond the sum of these parts."
    if command == "check" and any(table.has_tolerances for table in tables):
        text += " tol: times the tolerance, 1e-9 relative or rounding."
    if command == "check" and any(table.has_standard_errors for table in tables):
        text += " s.e.: standard errors of a difference between two seeds."
    if any(table.has_bounds for table in tables):
        text += " >=, <=: this or worse, as a line is not given that would add to it."
    page.line()
    page.paragraph(text)
