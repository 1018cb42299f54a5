"""Rows of dots under headings: what is written beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.figures.style import INK, PAPER, SMALL, TEXT

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def write_heading(axes: Axes, place: float, title: str, *, indent: float) -> None:
    """Write the title of a group of rows on a row of its own, from the left edge.

    `indent` is the margin that the rows of the group have on the left [pt].
    """
    axes.annotate(
        title,
        (0.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(4.0 - indent, 0.0),
        textcoords="offset points",
        fontsize=TEXT,
        fontweight="bold",
        color=INK,
        va="center",
        bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 1.0},
    )


def write_beside(
    axes: Axes, place: float, text: str, *, reach: float, strong: bool = False
) -> None:
    """Write a number on the right of a row, so that it ends at `reach` [pt]."""
    axes.annotate(
        text,
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(reach, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=INK,
        fontweight="bold" if strong else "normal",
        ha="right",
        va="center_baseline",
    )
