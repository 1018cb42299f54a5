"""A document as PDF: its blocks as data for the template `report.typ`.

Every text passes through `FontSet.printable`, so that typst meets no character that
it cannot show.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from budget.report.blocks import (
    Abreast,
    Equations,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Picture,
    Sliders,
    Table,
)
from budget.report.fonts import choose_fonts, name_character
from budget.report.pdf import render_pdf
from budget.report.typeset_tables import plain_table
from budget.report.typeset_text import (
    break_long,
    cut_math,
    cut_words,
    shorten,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from budget.report.blocks import Block, Document

TEMPLATE = "report.typ"
HEAD_LENGTH = 100  # characters that fit into the running head
SIZE = re.compile(r'<svg\b[^>]*?\bwidth="([\d.]+)(?:pt)?"')


@dataclass(frozen=True, kw_only=True)
class Typeset:
    """A PDF, and the characters in it that no font has.

    Attributes
    ----------
    pdf : bytes
    replaced : tuple of str
        Code points that stand in the place of their characters: 'U+8D75'.
    """

    pdf: bytes
    replaced: tuple[str, ...]


def typeset(document: Document, *, folders: Sequence[Path] | None = None) -> Typeset:
    """Write a document as PDF.

    Parameters
    ----------
    document : Document
    folders : sequence of Path or None
        Where to look for fonts with characters that the bundled ones lack; None for
        where the system keeps its own.

    Returns
    -------
    Typeset
        The same bytes for the same document and fonts.

    Raises
    ------
    OutputError
        The template is not there, or typst refuses it or a figure.
    """
    pictures = tuple(_pictures(b for part in document.sections for b in part.blocks))
    data = plain_document(document, pictures)
    texts = [*_strings(data), *(picture.svg for picture in pictures)]
    lettering = choose_fonts(texts, folders=folders)
    missing = frozenset[str]().union(*map(lettering.missing, texts))
    printable = _map_strings(data, lettering.printable)
    pdf = render_pdf(
        TEMPLATE,
        printable | {"families": lettering.families},
        {
            f"{place}.svg": lettering.drawable(picture.svg).encode()
            for place, picture in enumerate(pictures)
        },
        date=document.date,
        faces=lettering.faces,
    )
    return Typeset(pdf=pdf, replaced=tuple(map(name_character, sorted(missing))))


def plain_document(document: Document, pictures: Sequence[Picture]) -> dict[str, Any]:
    """Return what the template prints, as JSON holds it.

    Parameters
    ----------
    document : Document
    pictures : sequence of Picture
        All of the document; `images/<place>.svg` is the file of each.
    """
    places = {id(picture): place for place, picture in enumerate(pictures)}
    return {
        "title": document.title,
        "heading": break_long(document.title),
        "facts": [break_long(fact) for fact in document.facts],
        "date": document.date,
        "version": document.version,
        "headline": break_long(document.headline),
        "head": shorten(document.running_head, HEAD_LENGTH),
        "summary": cut_words(document.summary),
        "cards": [
            {"title": break_long(card.title), "lines": [*map(cut_words, card.lines)]}
            for card in document.cards
        ],
        "sections": [
            {
                "title": break_long(section.title),
                "first": section.on_first_page,
                "blocks": [_plain(block, places) for block in section.blocks],
            }
            for section in document.sections
        ],
        "numbers": [
            {
                "title": break_long(picture.title),
                "place": place,
                "table": plain_table(picture.data),
            }
            for place, picture in enumerate(pictures)
            if picture.data is not None
        ],
    }


def _plain(block: Block, places: dict[int, int]) -> dict[str, Any]:  # noqa: PLR0911 - a kind each
    """Turn a block into what JSON holds; `is` says of which kind it was."""
    match block:
        case Paragraph(words=words, small=small):
            return {"is": "paragraph", "words": cut_words(words), "small": small}
        case Listing(items=items, empty=empty, numbered=numbered):
            return {
                "is": "listing",
                "items": [cut_words(item) for item in items],
                "empty": break_long(empty),
                "numbered": numbered,
            }
        case Pairs(rows=rows):
            pairs = [(break_long(term), cut_words(words)) for term, words in rows]
            return {"is": "pairs", "rows": [list(pair) for pair in pairs]}
        case Equations(equations=equations):
            formulas = [(cut_math(one.math), one.number) for one in equations]
            return {"is": "equations", "rows": [list(pair) for pair in formulas]}
        case Table():
            return plain_table(block)
        case Picture():
            return _plain_picture(block, places[id(block)])
        case Sliders(table=table):
            return plain_table(table)
        case Panel(title=title, blocks=blocks):
            return {
                "is": "panel",
                "title": break_long(title),
                "blocks": [_plain(one, places) for one in blocks],
            }
        case Abreast(blocks=blocks, columns=columns):
            return {
                "is": "abreast",
                "blocks": [_plain(one, places) for one in blocks],
                "columns": columns,
            }


def _plain_picture(picture: Picture, place: int) -> dict[str, Any]:
    """Return a figure without its drawing, which is a file beside the data."""
    size = SIZE.search(picture.svg)
    return {
        "is": "picture",
        "place": place,
        "title": break_long(picture.title),
        "alt": picture.alt,
        "caption": cut_words((picture.caption,)),
        "width": float(size[1]) if size else None,  # [pt]
        "numbers": picture.data is not None,
    }


def _pictures(blocks: Iterator[Block] | Sequence[Block]) -> Iterator[Picture]:
    """Yield the figures among blocks, and among the blocks in them."""
    for block in blocks:
        if isinstance(block, Picture):
            yield block
        elif isinstance(block, Panel | Abreast):
            yield from _pictures(block.blocks)


def _strings(part: object) -> Iterator[str]:
    """Yield every text of the data."""
    if isinstance(part, str):
        yield part
    elif isinstance(part, dict):
        yield from _strings([*part.values()])
    elif isinstance(part, list):
        for item in part:
            yield from _strings(item)


def _map_strings(part: Any, change: Callable[[str], str]) -> Any:  # noqa: ANN401 - whatever JSON holds
    """Change every text of the data."""
    if isinstance(part, str):
        return change(part)
    if isinstance(part, dict):
        return {key: _map_strings(item, change) for key, item in part.items()}
    if isinstance(part, list):
        return [_map_strings(item, change) for item in part]
    return part
