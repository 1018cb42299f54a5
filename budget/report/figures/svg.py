"""Figures as SVG text, the same bytes for the same figure."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING
from warnings import catch_warnings, filterwarnings

from budget.report.figures.style import house_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def to_svg(figure: Figure, *, name: str) -> str:
    """Write a figure as SVG text; ids begin with `name`, so that several fit a page.

    An artist with the gid 'tip-z' becomes the element with the id '{name}-tip-z': the
    tips of a picture find it by that.
    """
    file = io.StringIO()
    with house_style(), catch_warnings():
        # Texts stay texts: who shows the figure has other fonts, or says what it lacks.
        filterwarnings("ignore", message=r"Glyph \d+ .* missing from")
        figure.savefig(
            file,
            format="svg",
            transparent=True,
            metadata={
                "Date": None,
                "Creator": None,
                "Format": None,
                "Type": None,
                "Title": figure.get_label(),
            },
        )
    text = re.sub(r'\bid="', f'id="{name}-', file.getvalue())
    return re.sub(r'(url\(|href=")#', rf"\1#{name}-", text)
