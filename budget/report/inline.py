"""Figures as SVG inside a page, in the inks of the page."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from budget.report import figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The figures take their inks from the page, so that they turn with light and dark.
INKS = {
    figures.INK: "currentColor",
    figures.MUTED: "var(--muted)",
    figures.GRID: "var(--grid)",
    figures.PAPER: "var(--paper)",
    figures.BLACK: "var(--black)",
}


def inline_svg(figure: Figure, name: str, alt: str) -> str:
    """Turn a figure to SVG inside HTML: no prolog, no size, the inks of the page."""
    svg = figures.to_svg(figure, name=name)
    svg = svg[svg.index("<svg") :]
    svg = re.sub(
        r"<title>.*?</title>|<metadata>.*?</metadata>", "", svg, flags=re.DOTALL
    )
    svg = re.sub(
        r"<style.*?</style>", "", svg, flags=re.DOTALL
    )  # holds for all the page
    head, end, rest = svg.partition(">")
    head = re.sub(r' (xmlns(:\w+)?|width|height|version)="[^"]*"', "", head)
    for ink, of_page in INKS.items():
        rest = rest.replace(ink, of_page)
    return f'{head} role="img" aria-label="{escape(alt)}"{end}{rest}'
