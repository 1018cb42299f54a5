"""Figures: result in, matplotlib Figure out; each with a finding and words for it.

One module for each question that a figure answers. Widths are those of a column
(330 pt) or of the page (700 pt).
"""

from __future__ import annotations

from budget.report.figures.coupling import (
    coupling_alt,
    coupling_map,
    coupling_picture,
    coupling_title,
)
from budget.report.figures.density import (
    density_alt,
    density_picture,
    density_step,
    density_title,
)
from budget.report.figures.overview import (
    overview_alt,
    overview_dots,
    overview_picture,
    overview_title,
)
from budget.report.figures.picture import (
    as_picture,
    capital,
    in_order,
)
from budget.report.figures.rows import (
    write_beside,
    write_heading,
)
from budget.report.figures.shares import (
    share_alt,
    share_bars,
    share_picture,
    share_tips,
    share_title,
)
from budget.report.figures.sobol import (
    sobol_alt,
    sobol_dots,
    sobol_picture,
    sobol_title,
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
    house_style,
    look_of,
    text_width,
)
from budget.report.figures.svg import (
    to_svg,
)
from budget.report.figures.timeline import (
    schedule_alt,
    schedule_bars,
    schedule_picture,
    schedule_title,
)
from budget.report.figures.utilisation import (
    utilisation_alt,
    utilisation_dots,
    utilisation_picture,
    utilisation_title,
)
from budget.report.figures.validity import (
    validity_alt,
    validity_marks,
    validity_picture,
    validity_title,
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
    "as_picture",
    "blank",
    "canvas",
    "capital",
    "columns_for",
    "coupling_alt",
    "coupling_map",
    "coupling_picture",
    "coupling_title",
    "density_alt",
    "density_picture",
    "density_step",
    "density_title",
    "fits",
    "house_style",
    "in_order",
    "look_of",
    "overview_alt",
    "overview_dots",
    "overview_picture",
    "overview_title",
    "schedule_alt",
    "schedule_bars",
    "schedule_picture",
    "schedule_title",
    "share_alt",
    "share_bars",
    "share_picture",
    "share_tips",
    "share_title",
    "sobol_alt",
    "sobol_dots",
    "sobol_picture",
    "sobol_title",
    "text_width",
    "to_svg",
    "utilisation_alt",
    "utilisation_dots",
    "utilisation_picture",
    "utilisation_title",
    "validity_alt",
    "validity_marks",
    "validity_picture",
    "validity_title",
    "write_beside",
    "write_heading",
    "write_on",
]
