"""A drawn figure as a block of a document: SVG, words, and its numbers as a table."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING
from warnings import catch_warnings, filterwarnings

from budget.report.blocks import Picture
from budget.report.figures.style import STYLES, house_style

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from matplotlib.figure import Figure

    from budget.names import Name
    from budget.report.blocks import Table


LAST = len(STYLES)


def as_picture(
    figure: Figure,
    *,
    name: str,
    title: str,
    alt: str,
    tips: Mapping[str, str] | None = None,
    caption: str = "",
    data: Table | None = None,
    is_wide: bool = False,
) -> Picture:
    """Write a figure into a block; `name` may be a dotted name with underscores."""
    name = name.replace("_", "-").replace(".", "-")
    return Picture(
        name=name,
        title=title,
        alt=alt,
        svg=to_svg(figure, name=name),
        tips=tips or {},
        caption=caption,
        data=data,
        is_wide=is_wide,
    )


def in_order(sources: Iterable[Name]) -> list[Name]:
    """Sort sources as every figure does; those without a look of their own last."""
    places = {name: place for place, name in enumerate(STYLES)}
    return sorted(sources, key=lambda name: places.get(name.quantity, LAST))


def capital(text: str) -> str:
    """Begin a text with a capital; the rest stays as it is."""
    return text[:1].upper() + text[1:]


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
