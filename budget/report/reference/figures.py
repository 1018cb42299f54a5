"""Figure of a check: what moved most, of every reference that moved."""

from __future__ import annotations

from functools import partial
from math import inf
from typing import TYPE_CHECKING, Protocol

from budget.report.answers import LEAST_ROWS, decades
from budget.report.figures.rows import Bar, Chart, Group, Panel, Row, Scale, Side
from budget.report.pages import line

if TYPE_CHECKING:
    from collections.abc import Sequence

MOST_DRAWN = 4  # references, and rows of each
said = partial(line, "figures_check")


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
    scale = Scale(low=low, high=high, kind="log", label=said("axis"))
    groups = tuple(
        Group(
            title=name,
            rows=tuple(
                Row(
                    label=said("label", row=row),
                    marks=(Bar(start=low, end=100.0 * row.size),),
                    beside=(row.change,),
                    said=said("said", row=row),
                )
                for row in rows
            ),
        )
        for name, rows in shown
    )
    (name, (row, *_)), *_ = shown
    return Chart(
        name="moves",
        title=said("title", name=name, row=row),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        caption=said("caption"),
    )
