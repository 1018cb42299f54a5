"""Figure of a check: what moved most, of every reference that moved."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Protocol

from budget.report.answers import LEAST_ROWS, decades
from budget.report.figures.rows import Bar, Chart, ChartPanel, rows_of
from budget.report.figures.style import Scale
from budget.report.pages import figure

if TYPE_CHECKING:
    from collections.abc import Sequence

MOST_DRAWN = 4  # references, and rows of each


class Moved(Protocol):
    """What a figure draws of numbers that moved alike."""

    @property
    def change(self) -> str:
        """In words."""

    @property
    def size(self) -> float:
        """Absolute difference over what it is measured by [1]."""


def moves_chart(moved: Sequence[tuple[str, Sequence[Moved]]]) -> Chart | None:
    """Show the numbers of each reference that moved most, on one logarithmic axis.

    None where hardly a number did, or they did from nothing.
    """
    sized = [
        (name, [one for one in rows if 0.0 < 100.0 * one.size < inf][:MOST_DRAWN])
        for name, rows in moved
    ]
    shown = sorted(
        ((name, rows) for name, rows in sized if rows),
        key=lambda pair: -pair[1][0].size,
    )[:MOST_DRAWN]
    parts = [100.0 * row.size for _, rows in shown for row in rows]
    if len(parts) < LEAST_ROWS:
        return None
    low, high = decades(parts)
    said, table = figure("figures_check", "moves", shown=shown)
    scale = Scale(low=low, high=high, kind="log", label=said.axis)
    drawn = rows_of(table, lambda at: [Bar(start=low, end=at.size)])
    return Chart(
        name="moves",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        caption=said.caption,
    )
