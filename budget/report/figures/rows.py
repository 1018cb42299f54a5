"""Rows of dots under headings, a column a sensor: what is written beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.figures.style import INCH, INK, PAPER, SMALL, TEXT, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BETWEEN = 12.0  # columns [pt]


def columns_for(number: int) -> list[tuple[float, float]]:
    """Return left edge and width of each of so many columns [pt]."""
    width = (WIDTH - BETWEEN * (number - 1)) / number
    return [(place * (width + BETWEEN), width) for place in range(number)]


def write_on(
    figure: Figure,
    left: float,
    base: float,
    text: str,
    *,
    size: float = TEXT,
    weight: str = "normal",
    colour: str = INK,
) -> None:
    """Write a text on the figure; place of its base line in points from top left."""
    width, height = (INCH * float(inches) for inches in figure.get_size_inches())
    figure.text(
        left / width,
        1.0 - base / height,
        text,
        fontsize=size,
        fontweight=weight,
        color=colour,
    )


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
