"""Figures: result in, matplotlib Figure out; each with a finding and words for it.

One module for each question that a figure answers. Widths are those of a column
(330 pt) or of the page (700 pt).
"""

from __future__ import annotations

from budget.report.figures.shares import (
    share_alt,
    share_bars,
    share_picture,
    share_tips,
    share_title,
)
from budget.report.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    GRID,
    INCH,
    INK,
    MUTED,
    ON_DARK,
    ON_LIGHT,
    ORANGE,
    OTHER,
    PAPER,
    PURPLE,
    SKY,
    SMALL,
    STYLE,
    STYLES,
    TEXT,
    VERMILION,
    WIDE,
    WIDTH,
    YELLOW,
    add_panel,
    blank,
    canvas,
    fits,
    text_width,
)
from budget.report.figures.svg import (
    to_svg,
)
from budget.report.figures.utilisation import (
    utilisation_alt,
    utilisation_dots,
    utilisation_picture,
    utilisation_title,
)

__all__ = [
    "BLACK",
    "BLUE",
    "GREEN",
    "GRID",
    "INCH",
    "INK",
    "MUTED",
    "ON_DARK",
    "ON_LIGHT",
    "ORANGE",
    "OTHER",
    "PAPER",
    "PURPLE",
    "SKY",
    "SMALL",
    "STYLE",
    "STYLES",
    "TEXT",
    "VERMILION",
    "WIDE",
    "WIDTH",
    "YELLOW",
    "add_panel",
    "blank",
    "canvas",
    "fits",
    "share_alt",
    "share_bars",
    "share_picture",
    "share_tips",
    "share_title",
    "text_width",
    "to_svg",
    "utilisation_alt",
    "utilisation_dots",
    "utilisation_picture",
    "utilisation_title",
]
