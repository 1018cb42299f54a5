"""What the figures of an allocation share: rows with names, numbers beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.figures import GRID, INK, SMALL, canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PITCH = 17.0  # from row to row [pt]
THICK = 0.52  # height of a bar, in rows [1]
LEFT, RIGHT, BELOW = 122.0, 92.0, 30.0  # room for names, for numbers, the axis [pt]


def named_rows(rows: int, *, top: float) -> tuple[Figure, Axes]:
    """Make a bare figure for a number of rows, names on the left; room above [pt]."""
    height = top + PITCH * rows + BELOW
    figure, axes = canvas(height, left=LEFT, right=RIGHT, top=top, below=BELOW)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    return figure, axes


def write_beside(
    axes: Axes, place: float, column: float, text: str, *, colour: str = INK
) -> None:
    """Write a text that ends so many points right of the panel, at a row."""
    axes.annotate(
        text,
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(column, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=colour,
        ha="right",
        va="center_baseline",
    )
