"""Figures inside a page: the page's inks, spoken words, tooltips."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from budget.report import figures
from budget.report.page import natural_width, svg_element

SVG = (
    '<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="330pt" '
    'height="9pt" viewBox="0 0 330 9" version="1.1"><title>t</title>'
    "<metadata>m</metadata><defs><style>*{stroke-linejoin: round}</style></defs>"
    f'<g id="f-bar"><path style="fill: {figures.INK}; stroke: #0072b2"/></g>'
    f'<use id="f-dot" x="1"/><text style="fill: {figures.MUTED}">{figures.INK}</text>'
    "</svg>"
)


def element(**options):
    """Return the figure as an element, and parsed."""
    text = svg_element(SVG, name="f", **({"alt": "words"} | options))
    return text, ET.fromstring(text)  # noqa: S314 - our own


def test_figure_takes_the_inks_of_the_page():
    """Ink and muted ink turn with light and dark; colours and texts stay."""
    text, svg = element()

    assert svg.find("g/path").get("style") == "fill: currentColor; stroke: #0072b2"
    assert svg.find("text").get("style") == "fill: var(--muted)"
    assert svg.find("text").text == figures.INK
    assert not text.startswith("<?xml")


def test_figure_brings_no_styles_or_titles_of_its_own():
    """What would hold for all the page, or show as a tooltip of it all, is left out."""
    text, svg = element()

    assert not svg.findall(".//style")
    assert not svg.findall(".//title")
    assert not svg.findall(".//metadata")
    assert "http:" not in text


def test_figure_is_spoken():
    """Those who cannot see it get the words, whatever stands in them."""
    _, svg = element(alt='"quoted" <b> & more')

    assert svg.get("role") == "img"
    assert svg.get("aria-label") == '"quoted" <b> & more'


def test_tips_belong_to_their_elements():
    """A tooltip is the first thing inside its element, empty ones included."""
    _, svg = element(tips={"bar": "a < b", "dot": "c"})

    assert svg.find("g")[0].tag == "title"
    assert svg.find("g")[0].text == "a < b"
    assert svg.find("use/title").text == "c"


def test_tip_without_an_element_is_refused():
    """A tooltip that would get lost is an error of the figure."""
    with pytest.raises(ValueError, match="'f-line' belongs to no element"):
        element(tips={"line": "lost"})


def test_natural_width_is_that_of_the_drawing():
    """The page scales a figure by the width that it was drawn for."""
    assert natural_width(SVG) == 330.0
    with pytest.raises(ValueError, match="no viewBox"):
        natural_width("<svg></svg>")
