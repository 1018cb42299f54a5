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
ELEMENT = re.compile(r'<(?P<tag>\w+) [^>]*?\bid="(?P<id>[^"]+)"[^>]*?(?P<empty>/?)>')
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
    rest = _with_tips(rest, {f"{name}-{gid}": tip for gid, tip in (tips or {}).items()})
    return f'{head} role="img" aria-label="{escape(alt)}"{end}{rest}'


def natural_width(svg: str) -> float:
    """Return the width that a figure was drawn for [pt]."""
    found = re.search(r'viewBox="[-\d.]+ [-\d.]+ ([\d.]+) [\d.]+"', svg)
    if found is None:
        raise ValueError("an SVG figure has no viewBox, expected one of figures.to_svg")
    return float(found[1])


def _with_tips(svg: str, tips: Mapping[str, str]) -> str:
    """Put a title into the elements of those ids, which browsers show as a tooltip."""
    left = dict(tips)

    def with_title(found: re.Match[str]) -> str:
        tip = left.pop(found["id"], None)
        if tip is None:
            return found[0]
        closing = f"</{found['tag']}>" if found["empty"] else ""
        start = found[0].removesuffix(">").removesuffix("/")
        return f"{start}><title>{escape(tip)}</title>{closing}"

    told = ELEMENT.sub(with_title, svg)
    if left:
        lost = ", ".join(map(repr, left))
        raise ValueError(f"the tip {lost} belongs to no element of its figure")
    return told
