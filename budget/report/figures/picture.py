"""From a figure to a block of a document; which source is drawn where."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Picture
from budget.report.figures.style import STYLES
from budget.report.figures.svg import to_svg

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
