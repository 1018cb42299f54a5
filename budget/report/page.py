"""A document as one HTML page: self-contained, for the screen and for paper."""

from __future__ import annotations

import json
from base64 import b64encode
from hashlib import sha256
from html import escape
from typing import TYPE_CHECKING

from budget.errors import OutputError
from budget.report import figures
from budget.report.blocks import Abreast, Run, Table
from budget.report.inline import natural_width, svg_element
from budget.report.markup import (
    bind,
    css_string,
    longest_tail,
    markup,
    page_environment,
    script_safe,
    signs_markup,
)
from budget.report.mathml import to_mathml
from budget.resources import shipped

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from jinja2 import Environment
    from markupsafe import Markup

    from budget.report.blocks import Block, Document, Picture, RowGroup, Words
    from budget.report.formulas import Math

SCRIPTS = ("what_if.js", "page.js")  # in the order that they stand in the page
SMALL_BAR = 0.005  # a share that is thinner than a line behind its number [1]


def render_page(document: Document) -> str:
    """Write a document as one page that needs nothing else and can load nothing.

    Parameters
    ----------
    document : Document
        Whose texts may come from anywhere: all are escaped.

    Returns
    -------
    str
        HTML; the same bytes for the same document.

    Raises
    ------
    OutputError
        A template is missing.
    """
    from jinja2 import TemplateNotFound

    try:
        return _render(document)
    except TemplateNotFound as error:
        raise OutputError(
            f"{shipped('templates') / str(error.name)}: this template is missing; it "
            "comes with the program: install that again, or write .pdf instead"
        ) from error


def _render(document: Document) -> str:
    """Fill the templates in."""
    environment = page_environment()
    environment.filters |= {
        "words": _words,
        "mathml": lambda math: markup(to_mathml(math, displayed=True)),
        "kind": lambda block: type(block).__name__,
        "is_broad": _is_broad,
        "tails": _tails,
        "widths": _widths,
        "picture": _picture,
        "natural_width": lambda picture: natural_width(picture.svg),
        "model": _model,
        "has_bar": lambda share: share is not None and share > SMALL_BAR,
        "per_cent": lambda share: f"{100.0 * min(share, 1.0):.1f}%",
    }
    script = _script(environment)
    return environment.get_template("page.html.j2").render(
        document=document,
        first=[section for section in document.sections if section.on_first_page],
        rest=[section for section in document.sections if not section.on_first_page],
        has_search=any(_has_searchable(s.blocks) for s in document.sections),
        json=markup(script_safe(document.json)),
        running_head=markup(css_string(document.running_head)),
        script=markup(script),
        script_hash=b64encode(sha256(script.encode()).digest()).decode(),
    )


def _script(environment: Environment) -> str:
    """Return the script of every page, the same bytes that its hash is of."""
    sources = [environment.get_template(name).render() for name in SCRIPTS]
    return "\n" + "\n".join(sources) + "\n"


def _words(words: Words) -> Markup:
    """Set a line of text with what is bold, exact or a formula in it."""
    return markup("".join(_part(part) for part in words))


def _part(part: str | Run | Math) -> str:
    """Set one part of a line; a number stays with its unit."""
    if isinstance(part, str):
        return escape(bind(part))
    if not isinstance(part, Run):
        return to_mathml(part)
    text = escape(bind(part.text))
    if part.exact is not None:
        text = f'<span class="number" title="{part.exact!r}">{_signs(part.text)}</span>'
    return f"<strong>{text}</strong>" if part.strong else text


def _signs(text: str) -> str:
    """Set a number with its unit."""
    return signs_markup(bind(text))


def _is_broad(blocks: Sequence[Block]) -> bool:
    """Whether a section needs more than a column of the first page."""
    return any(
        getattr(block, "is_wide", False)
        or (isinstance(block, Abreast) and _is_broad(block.blocks))
        for block in blocks
    )


def _has_searchable(blocks: Sequence[Block]) -> bool:
    """Whether a table among blocks, or in the panels among them, is searchable."""
    return any(
        block.searchable
        if isinstance(block, Table)
        else _has_searchable(getattr(block, "blocks", ()))
        for block in blocks
    )


def _tails(group: RowGroup) -> list[int]:
    """Return for each column how long the tails of its numbers are."""
    columns = zip(*group.rows, strict=True)
    return [longest_tail(cell.text for cell in column) for column in columns]


def _widths(table: Table) -> list[str]:
    """Return the part of the width that each column of a wide table asks for.

    Text columns share out what the others leave, by their weights; those are as wide
    as their numbers.
    """
    texts = [column.weight for column in table.columns if column.kind == "text"]
    if not table.is_wide or len(set(texts)) < 2:  # noqa: PLR2004 - all alike
        return [""] * len(table.columns)
    part = len(texts) / len(table.columns) / sum(texts)
    return [
        f"{100.0 * part * column.weight:.1f}%" if column.kind == "text" else ""
        for column in table.columns
    ]


def _picture(picture: Picture) -> Markup:
    """Set a figure into the page."""
    return markup(
        svg_element(picture.svg, name=picture.name, alt=picture.alt, tips=picture.tips)
    )


def _model(model: Mapping[str, object]) -> Markup:
    """Write what the sliders compute from, with the colours of the figures."""
    colours = {name: colour for name, (colour, _, _) in figures.STYLES.items()}
    return markup(
        script_safe(json.dumps({**model, "colours": colours}, allow_nan=False))
    )
