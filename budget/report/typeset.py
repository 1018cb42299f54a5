"""A document as PDF: its blocks as data for the template `report.typ`.

Every text passes through `FontSet.printable`, so that typst meets no character that
it cannot show.
"""

from __future__ import annotations

import json
import re
import textwrap
import warnings
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from budget.errors import OutputError
from budget.language import speaking
from budget.report.blocks import (
    Abreast,
    Equations,
    ForPages,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Picture,
    Run,
    Sliders,
    Table,
    drawn,
)
from budget.report.fonts import choose_fonts, name_character, place_fonts, text_width
from budget.report.inline import BOUND, MINUS, NARROW, Link, cut, exponent, with_minus
from budget.report.pages import line
from budget.report.tables import align_decimals
from budget.resources import own_pictures, template_file

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from budget.report.blocks import Block, Column, Document, RowGroup, Words
    from budget.report.formulas import Math

    Part = str | dict[str, Any]
    from collections.abc import Mapping

    from typst import PDFStandard, TypstWarning

    from budget.report.fonts import Face


TEMPLATE, LETTERHEAD = "report.typ", "letterhead.typ"
HEAD_LENGTH = 100  # characters that fit into the running head
SIZE = re.compile(r'<svg\b[^>]*?\bwidth="([\d.]+)(?:pt)?"')


# Tables.
LONGEST_HEAD = 160  # characters of the head of a column; it is on every page
NARROW_HEAD = 12  # characters of the head of a narrow column before it is broken
CROWDED = 9  # columns; from there on a table is set smaller, its heads broken sooner
CROWDED_HEAD = 7  # characters
SHORT_CELL = 26  # characters; a column of such cells is never narrower than they are
SPLIT_CELL = 1500  # characters; a row with such a cell may go on on the next page
LEAST_SHARE = 11.0  # [em] that a column of long text can do with
SMALL = 0.9  # size of notes over that of the table [1]
EXPONENT = 0.6  # size of exponents over that of the table [1]

# Text.
DIGIT, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"  # as wide as those
BREAK = "\N{ZERO WIDTH SPACE}"  # a line may end here
SAID = "typeset"  # the page of what is said around a document

# As `tables` prints: '<0.1', '-2.3e-9', '230 000', '79 %'.
NUMBER = re.compile(
    r"(?P<head>[<>]?)(?P<digits>[+-]?\d[\d ]*(?:\.\d+)?)(?:e(?P<power>[+-]?\d+))?"
    r"(?P<tail>| [^\d\s].*)"
)
LONG_WORD = 24  # characters; words of a report are shorter
UNBROKEN = 12  # characters of a long one between places where a line may end


@dataclass(frozen=True, kw_only=True)
class Typeset:
    """A PDF, and the characters in it that no font has."""

    pdf: bytes
    # Code points that stand in the place of their characters: 'U+8D75'.
    replaced: tuple[str, ...]


def typeset(
    document: Document, *, paper: str = "a4", folders: Sequence[Path] | None = None
) -> Typeset:
    """Write a document as PDF: the same bytes for the same document and fonts.

    Its sheets are of A4, or of US Letter where paper is 'letter'.

    Characters that the bundled fonts lack are looked for in `folders`, without them
    where the system keeps its fonts.

    Raises
    ------
    OutputError
        The template is not there, or typst refuses it or a figure.
    """
    document = drawn(document)
    pictures = tuple(_pictures(b for part in document.sections for b in part.blocks))
    with speaking(document.language):
        data = plain_document(document, pictures)
    texts = [*_strings(data), *(picture.svg for picture in pictures)]
    fonts = choose_fonts(texts, folders=folders)
    missing = frozenset[str]().union(*map(fonts.missing, texts))
    printable = _map_strings(data, fonts.printable)
    pdf = render_pdf(
        TEMPLATE,
        printable | {"families": fonts.families, "paper": paper},
        {
            f"{place}.svg": fonts.drawable(picture.svg).encode()
            for place, picture in enumerate(pictures)
        },
        date=document.date,
        faces=fonts.faces,
    )
    return Typeset(pdf=pdf, replaced=tuple(map(name_character, sorted(missing))))


def plain_document(document: Document, pictures: Sequence[Picture]) -> dict[str, Any]:
    """Return what the template prints, as JSON holds it.

    `images/<place>.svg` is the file of each picture of the document.
    """
    places = {id(picture): place for place, picture in enumerate(pictures)}
    return {
        "language": document.language,
        "said": {
            "page": line(SAID, "page", page=BREAK, pages=BREAK).split(BREAK),
            **{key: line(SAID, key) for key in ("numbers", "contents", "figures")},
        },
        "title": document.title,
        "heading": break_long(document.title),
        "facts": [_cut_text(fact) for fact in document.facts],
        "date": f"{line(SAID, 'issued')} {document.date}",
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
            if picture.data is not None and picture.data_on_paper
        ],
    }


def _plain(block: Block, places: dict[int, int]) -> dict[str, Any]:  # noqa: C901, PLR0911 - a kind each
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
        case ForPages():
            raise ValueError("pass the document through drawn() first")


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
        "numbers": picture.data is not None and picture.data_on_paper,
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


def plain_table(table: Table) -> dict[str, Any]:
    """Return a table as JSON holds it.

    `natural` is how wide it is where no text is broken and `least` how narrow it can
    be where only short texts are not, both without the air between columns [em].
    """
    groups = [_plain_rows(table, group) for group in table.groups]
    rows = [row for group in groups for row in group]
    crowded = len(table.columns) >= CROWDED
    columns = [
        _plain_column(column, [row[k] for row in rows], crowded=crowded)
        for k, column in enumerate(table.columns)
    ]
    return {
        "is": "table",
        "columns": columns,
        "crowded": crowded,
        "pen": table.for_pen,
        "natural": sum(column["natural"] for column in columns),
        "least": sum(
            column["natural"] if column["share"] is None else LEAST_SHARE
            for column in columns
        ),
        "groups": [
            {"title": break_long(group.title), "rows": plain}
            for group, plain in zip(table.groups, groups, strict=True)
        ],
    }


def _plain_column(
    column: Column, cells: Sequence[dict[str, Any]], *, crowded: bool
) -> dict[str, Any]:
    """Return a column; long text has a share of the width instead of its own."""
    longest = max((max(len(c["plain"]), len(c["note"])) for c in cells), default=0)
    head = break_long(shorten(column.head, LONGEST_HEAD))
    if crowded or column.kind != "text":
        narrow = max(CROWDED_HEAD if crowded else NARROW_HEAD, longest)
        head = "\n".join(textwrap.wrap(head, width=narrow, break_long_words=False))
    widths = [text_width(line, bold=True) for line in head.split("\n")]
    widths += [text_width(c["plain"], bold=c["strong"]) for c in cells]
    widths += [SMALL * text_width(c["note"]) for c in cells]
    wraps = column.kind == "text" and longest > SHORT_CELL
    # Text twice as long is set wider and higher, both by the root of two.
    share = column.weight * sqrt(max(1.0, longest / SHORT_CELL)) if wraps else None
    return {
        "head": head,
        "kind": column.kind,
        "natural": max(widths),
        "share": share,
        "weight": column.weight,
    }


def _plain_rows(table: Table, group: RowGroup) -> list[list[dict[str, Any]]]:
    """Return the rows of a group, decimal points in line within each column."""
    wholes = [
        # A row is split between pages if one of its cells would fill one.
        all(len(cell.text) + len(cell.note) < SPLIT_CELL for cell in row)
        for row in group.rows
    ]
    by_column = []
    for place, column in enumerate(table.columns):
        cells = [row[place] for row in group.rows]
        texts = [cell.text for cell in cells]
        numeric = column.kind == "number"
        parts = (
            cut_numbers(texts)
            if numeric
            else [break_long(text) for text in texts]
            if column.kind == "code"
            else [_cut_text(text) for text in texts]
        )
        by_column.append(
            [
                {
                    "text": part,
                    "plain": _join(part),
                    "share": cell.share,
                    "parts": [
                        [one.share, one.colour]
                        for one in (cell.shares.parts if cell.shares else ())
                    ],
                    "strong": cell.strong,
                    "note": with_minus(cell.note),
                    "under": _cut_text(cell.note),
                    "whole": whole,
                }
                for part, cell, whole in zip(parts, cells, wholes, strict=True)
            ]
        )
    return [list(row) for row in zip(*by_column, strict=True)]


def _join(part: Part | list[Part]) -> str:
    """Write a part about as wide as it will be."""
    if isinstance(part, str):
        return part
    if isinstance(part, list):
        return "".join(map(_join, part))
    if "text" in part:
        return str(part["text"])
    power = part["power"]
    raised = power[: round(EXPONENT * len(power))]
    times = f"\u202f\N{MULTIPLICATION SIGN}\u202f10{raised}" if power else ""
    return f"{part['head']}{part['digits']}{times}{part['tail']}{part['pad']}"


def cut_words(words: Words) -> list[Part]:
    """Turn a line of text into what JSON holds: texts, numbers, formulas."""
    parts: list[Part] = []
    for word in words:
        if isinstance(word, str):
            parts += _cut_text(word)
        elif isinstance(word, Run):
            said = _cut_text(word.text)
            parts += [{"is": "strong", "parts": said}] if word.strong else said
        else:
            parts.append(cut_math(word))
    return parts


def cut_math(math: Math) -> dict[str, Any]:
    """Turn a formula into what JSON holds, with words for those who hear it."""
    return {"is": "math", "alt": math.alt, "source": math.source}


def cut_numbers(texts: Sequence[str]) -> list[Part]:
    """Turn a column of printed numbers into parts, padded to bring points in line.

    What is no number, a dash or a word, stays as it is; powers of ten have no part in
    the line of points.
    """
    found = [NUMBER.fullmatch(text) for text in texts]
    plain = [m["digits"] for m in found if m and m["power"] is None]
    pads = iter(align_decimals(plain, digit=DIGIT, point=POINT))
    parts: list[Part] = []
    for text, match in zip(texts, found, strict=True):
        if match is None:
            parts.append(break_long(text))
            continue
        digits, power = match["digits"], match["power"]
        pad = next(pads)[len(digits) :] if power is None else ""
        parts.append(
            {
                "is": "number",
                "head": match["head"],
                "digits": _print_digits(digits),
                "power": "" if power is None else exponent(power),
                "tail": match["tail"].replace(" ", BOUND, 1),
                "pad": pad,
            }
        )
    return parts


def shorten(text: str, length: int) -> str:
    """Cut a text that is too long, and show that it was."""
    return text if len(text) <= length else f"{text[: length - 1].rstrip()}…"


def break_long(text: str) -> str:
    """Let a line end within words that no column could hold; minus signs are true."""
    told = with_minus(text)
    return re.sub(rf"\S{{{LONG_WORD},}}", lambda word: _break_word(word[0]), told)


def _break_word(word: str) -> str:
    """Let a line end after signs, and where there are none for too long."""
    return BREAK.join(
        piece[start : start + UNBROKEN]
        for piece in re.split(r"(?<=[/_,;.:=-])(?=[^\s/_,;.:=-])", word)
        for start in range(0, len(piece), UNBROKEN)
    )


def _cut_text(text: str) -> list[Part]:
    """Turn a text into what JSON holds: words, exponents, links."""
    return [
        break_long(part)
        if isinstance(part, str)
        else {"is": "link", "text": break_long(part.text), "to": part.address}
        if isinstance(part, Link)
        else {"is": "raised", "text": part.text}
        for part in cut(text)
    ]


def _print_digits(digits: str) -> str:
    """Write a true minus sign, and narrow blanks between groups of digits."""
    return digits.replace("-", MINUS).replace(" ", NARROW)


# To keep, and to be read aloud: tagged, with alternative texts and a language.
STANDARDS: list[PDFStandard] = ["a-2a", "ua-1"]


def render_pdf(
    template: str,
    data: Mapping[str, Any],
    images: Mapping[str, bytes],
    *,
    date: str,
    faces: tuple[Face, ...] = (),
) -> bytes:
    """Set a document with typst as PDF/A-2a and PDF/UA-1; same arguments, same bytes.

    The template, a file in the folder `templates`, finds `data` in `data.json` and the
    images, SVG or PNG, in `images/`. The date (year-month-day) alone tells the time.

    Raises
    ------
    OutputError
        The template is not there, or typst refuses it, the data or an image.
    """
    source = _read_template(template)
    beside = dict(own_pictures())
    if template == TEMPLATE:
        beside[LETTERHEAD] = _read_template(LETTERHEAD)
    try:
        with TemporaryDirectory(prefix="budget-") as folder:
            root = Path(folder)
            (root / "main.typ").write_bytes(source)
            for name, content in beside.items():
                (root / name).write_bytes(content)
            (root / "data.json").write_text(
                json.dumps(data, allow_nan=False), encoding="utf-8"
            )
            (root / "fonts").mkdir()
            place_fonts(faces, root / "fonts")
            (root / "images").mkdir()
            for name, content in images.items():
                (root / "images" / name).write_bytes(content)
            pdf, doubts = _compile(root, template, date)
    except OSError as error:
        raise OutputError(
            f"{template}: cannot prepare the PDF in the folder for temporary files "
            f"({error.strerror}), expected one with room for 30 MB; set TMPDIR to such "
            "a folder, or write .html instead"
        ) from error
    for doubt in doubts:
        warnings.warn(f"{template}: typst says: {doubt.message}", stacklevel=2)
    return pdf


def _compile(root: Path, template: str, date: str) -> tuple[bytes, list[TypstWarning]]:
    """Run typst in a folder; return the file and what typst has doubts about."""
    from datetime import UTC, datetime

    import typst

    try:
        return typst.compile_with_warnings(
            root / "main.typ",
            root=root,
            font_paths=[root / "fonts"],
            ignore_system_fonts=True,
            format="pdf",
            pdf_standards=STANDARDS,
            timestamp=datetime.fromisoformat(date).replace(tzinfo=UTC),
        )
    except typst.TypstError as error:
        hints = "".join(f" ({hint})" for hint in error.hints)
        raise OutputError(
            f"{template}: typst says: {error.message}{hints}; expected a template "
            "and data that make a PDF; write .html instead, and report this"
        ) from error


def _read_template(name: str) -> bytes:
    """Read a template; an installation may have lost one."""
    path = template_file(name)
    try:
        return path.read_bytes()
    except OSError as error:
        raise OutputError(
            f"{path}: cannot read this template ({error.strerror}); it comes with the "
            "program: install that again, or write .html instead"
        ) from error
