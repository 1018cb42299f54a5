"""Figures as SVG inside a page, in the inks of the page."""

from __future__ import annotations

import re
from html import escape
from typing import TYPE_CHECKING

from budget.report import figures

if TYPE_CHECKING:
    from collections.abc import Mapping

# The figures take their inks from the page, so that they turn with light and dark.
INKS = {
    figures.INK: "currentColor",
    figures.MUTED: "var(--muted)",
    figures.GRID: "var(--grid)",
    figures.PAPER: "var(--paper)",
    figures.BLACK: "var(--black)",
}
INK = re.compile(r"((?:fill|stroke): ?)(#[0-9a-fA-F]{6})")  # as matplotlib writes it
PROLOG = re.compile(
    r"<title>.*?</title>|<metadata>.*?</metadata>|<style.*?</style>", re.DOTALL
)


def svg_element(
    svg: str, *, name: str, alt: str, tips: Mapping[str, str] | None = None
) -> str:
    """Turn an SVG file to an element of HTML: no prolog, no size, the page's inks.

    Parameters
    ----------
    svg : str
        From `budget.report.figures.to_svg`.
    name : str
        That of the figure, with which its ids begin.
    alt : str
        What it shows, for those who cannot see it.
    tips : mapping of str to str, optional
        Tooltips by the gid of the element that they belong to.

    Returns
    -------
    str
        One `svg` element.

    Raises
    ------
    ValueError
        A tip belongs to no element.
    """
    head, end, rest = PROLOG.sub("", svg[svg.index("<svg") :]).partition(">")
    head = re.sub(r' (xmlns(:\w+)?|width|height|version)="[^"]*"', "", head)
    rest = INK.sub(lambda ink: ink[1] + INKS.get(ink[2], ink[2]), rest)
    for gid, tip in (tips or {}).items():
        rest = _add_tip(rest, f"{name}-{gid}", tip)
    return f'{head} role="img" aria-label="{escape(alt)}"{end}{rest}'


def natural_width(svg: str) -> float:
    """Return the width that a figure was drawn for [pt]."""
    found = re.search(r'viewBox="[-\d.]+ [-\d.]+ ([\d.]+) [\d.]+"', svg)
    if found is None:
        raise ValueError("an SVG figure has no viewBox, expected one of figures.to_svg")
    return float(found[1])


def _add_tip(svg: str, identity: str, tip: str) -> str:
    """Put a title into one element, which browsers show as a tooltip."""
    place = re.compile(rf'<(\w+)( [^>]*?\bid="{re.escape(identity)}"[^>]*?)(/?)>')
    title = f"<title>{escape(tip)}</title>"

    def with_title(found: re.Match[str]) -> str:
        closing = f"</{found[1]}>" if found[3] else ""
        return f"<{found[1]}{found[2]}>{title}{closing}"

    told, times = place.subn(with_title, svg, count=1)
    if not times:
        raise ValueError(f"the tip {identity!r} belongs to no element of its figure")
    return told
