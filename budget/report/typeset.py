"""A document as PDF: its blocks as data for the template `report.typ`.

Every text passes through `Lettering.printable`, so that typst meets no character that
it cannot show.
"""

from __future__ import annotations

import re
import textwrap
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
from budget.report.typeset_text import (
    break_long,
    cut_math,
    cut_numbers,
    cut_words,
    shorten,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from budget.report.blocks import Block, Cell, Column, Document, RowGroup

TEMPLATE = "report.typ"
HEAD_LENGTH = 100  # characters that fit into the running head
NARROW_HEAD = 12  # characters of the head of a narrow column before it is broken
LONGEST_HEAD = 160  # characters of the head of a column; it is on every page
SHORT_CELL = 26  # characters; a column of such cells is as wide as they are
SPLIT_CELL = 1500  # characters; a cell that long may go on on the next page
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
                "table": _plain_table(picture.data),
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
            return _plain_table(block)
        case Picture():
            return _plain_picture(block, places[id(block)])
        case Sliders(table=table):
            return _plain_table(table)
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


def _plain_table(table: Table) -> dict[str, Any]:
    """Return a table: how wide its columns are, heads, and cells cut into parts."""
    columns = [
        _plain_column(column, [row[k] for group in table.groups for row in group.rows])
        for k, column in enumerate(table.columns)
    ]
    return {
        "is": "table",
        "columns": columns,
        "wide": table.is_wide,
        "groups": [
            {"title": break_long(group.title), "rows": _plain_rows(table, group)}
            for group in table.groups
        ],
    }


def _plain_column(column: Column, cells: Sequence[Cell]) -> dict[str, Any]:
    """Return a column: as wide as its cells if they are short, or its share."""
    longest = max((len(c.text) for c in cells), default=0)
    longest = max([longest, *(len(c.note) for c in cells)])
    wraps = column.kind == "text" and longest > SHORT_CELL
    head = shorten(column.head, LONGEST_HEAD)
    if column.kind != "text":
        head = "\n".join(
            textwrap.wrap(head, width=max(NARROW_HEAD, longest), break_long_words=False)
        )
    return {
        "head": break_long(head),
        "kind": column.kind,
        "width": column.weight if wraps else None,
    }


def _plain_rows(table: Table, group: RowGroup) -> list[list[dict[str, Any]]]:
    """Return the rows of a group, decimal points in line within each column."""
    # A row is split between pages if any of its cells would fill one.
    wholes = [
        all(len(cell.text) + len(cell.note) < SPLIT_CELL for cell in row)
        for row in group.rows
    ]
    by_column = []
    for column, cells in zip(
        table.columns, zip(*group.rows, strict=True), strict=bool(group.rows)
    ):
        texts = [cell.text for cell in cells]
        numeric = column.kind == "number"
        parts = cut_numbers(texts) if numeric else [break_long(t) for t in texts]
        by_column.append(
            [
                {
                    "text": part,
                    "share": cell.share,
                    "strong": cell.strong,
                    "note": break_long(cell.note),
                    "whole": whole,
                }
                for part, cell, whole in zip(parts, cells, wholes, strict=True)
            ]
        )
    return [list(row) for row in zip(*by_column, strict=True)]


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
