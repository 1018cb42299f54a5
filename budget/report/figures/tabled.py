"""The table of a figure: its numbers, alternative text and tooltips are made of it.

It is declared by a macro of a page, below what the figure says
(`budget.report.pages.figure`). The roles of its columns say what is drawn, `entries`
reads its rows by them. A column with a role and without a head is drawn, not shown.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from budget.report.blocks import Column, RowGroup, Table
from budget.report.figures.style import as_picture, house_style
from budget.report.pages import line
from budget.report.writing import capital

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from matplotlib.figure import Figure

    from budget.report.blocks import Cell, Picture

PAGE = "figures_rows"
BESIDE, CELL = "beside", "cell"  # roles of texts on the right, of cells of a map


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A figure over two axes: what it says, its table, and how it is drawn."""

    name: str  # as in `Picture`
    said: SimpleNamespace  # `title`, the finding, and `caption`
    table: Table
    draw: Callable[[], Figure]
    # Tooltips by the gid of what they belong to; what is not drawn has none.
    tips: Mapping[str, str] = field(default_factory=dict)
    alt: str = ""  # that of the table without
    is_wide: bool = False
    data_on_paper: bool = False

    @property
    def figure(self) -> Figure:
        """The drawing, with the finding as its label."""
        with house_style():
            figure = self.draw()
        figure.set_label(self.said.title)
        return figure

    @property
    def picture(self) -> Picture:
        """The block of a page."""
        return as_picture(
            self.figure,
            name=self.name,
            title=self.said.title,
            alt=self.alt or alternative(self.said.title, self.table),
            tips=self.tips,
            caption=self.said.caption,
            data=shown(self.table),
            is_wide=self.is_wide,
            data_on_paper=self.data_on_paper,
        )


def heads_of(table: Table, role: str = BESIDE) -> tuple[str, ...]:
    """Return the heads of the columns of a role."""
    return tuple(one.head for one in table.columns if role in one.role.split())


def column_tips(table: Table) -> dict[str, str]:
    """Say of each column where it begins and ends, by the gid of its line."""
    rows = [row for group in table.groups for row in group.rows]
    return {
        f"curve-{k}": line(
            PAGE, "span", head=column.head, first=rows[0][k], last=rows[-1][k]
        )
        for k, column in enumerate(table.columns)
        if k and _is_shown(column)
    }


def alternative_of_curves(title: str, table: Table, more: Sequence[str] = ()) -> str:
    """Say the finding of a figure, where the lines of its table lead, and more."""
    rows = [row for group in table.groups for row in group.rows]
    return line(
        PAGE,
        "curves",
        title=title,
        table=table,
        first=rows[0][0].text,
        last=rows[-1][0].text,
        parts=[*column_tips(table).values(), *more],
    )


def _is_shown(column: Column) -> bool:
    """Whether a column is not only drawn."""
    return bool(column.head) or not column.role


def shown(table: Table) -> Table:
    """Return a table of a figure as it is shown: without what is only drawn."""
    kept = [k for k, column in enumerate(table.columns) if _is_shown(column)]
    return replace(
        table,
        columns=tuple(replace(table.columns[k], role="") for k in kept),
        groups=tuple(
            RowGroup(
                title=capital(group.title),
                rows=tuple(tuple(row[k] for k in kept) for row in group.rows),
            )
            for group in table.groups
        ),
    )


def alternative(title: str, table: Table | None) -> str:
    """Say the finding and the table of a figure, its heads once."""
    return line("figures_rows", "alt", title=title, table=table and shown(table))


def entries(table: Table) -> Iterator[tuple[str, list[SimpleNamespace]]]:
    """Yield the title of each group of a table, and its rows by the roles of columns.

    An entry has the number of its cell of each role, or the text of one that has none;
    and `label`, whether it is `strong`, the texts `beside`, the `cells` of a map, and
    the row in words as a `tip`.
    """
    for group in table.groups:
        yield group.title, [_entry(table, group.title, row) for row in group.rows]


def _entry(table: Table, title: str, row: Sequence[Cell]) -> SimpleNamespace:
    """Return what is drawn of a row."""
    pairs = [*zip(table.columns, row, strict=True)]
    roles = [(role, cell) for column, cell in pairs for role in column.role.split()]
    said = [(one, cell) for one, cell in pairs[1:] if cell.text and _is_shown(one)]
    words = partial(line, "figures_rows", "tip", title=title, label=row[0].text)
    found: dict[str, Any] = {
        role: cell.text if cell.exact is None else cell.exact for role, cell in roles
    }
    found |= {
        "label": row[0].text,
        "strong": any(cell.strong for cell in row),
        BESIDE: tuple(cell.text for role, cell in roles if role == BESIDE),
        "tip": words(pairs=said) if said else "",
        "cells": [
            SimpleNamespace(
                **vars(cell), at=k, tip=words(pairs=[(column, cell)]), head=column.head
            )
            for k, (column, cell) in enumerate(
                one for one in pairs if CELL in one[0].role.split()
            )
        ],
    }
    return SimpleNamespace(**found)
