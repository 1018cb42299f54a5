"""Sections on a terminal: of any width from 40 columns, in ASCII if need be.

A page and a terminal show the same blocks. A terminal draws no figure, sets no formula,
and puts the columns of a table that do not fit into further tables below it. Verdicts
are in colour where the terminal has any, and say the same without.
"""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass
from functools import cached_property
from itertools import repeat
from typing import TYPE_CHECKING
from unicodedata import east_asian_width

from budget.known import AT_LEAST, AT_MOST
from budget.language import say
from budget.report.blocks import (
    Abreast,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Run,
    Sliders,
    Table,
)
from budget.report.tables import (
    align_decimals,
)
from budget.report.writing import VERDICTS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rich.console import Console

    from budget.report.blocks import Block, Cell, Section, Words

EIGHTHS = " ▏▎▍▌▋▊▉█"
TEXT_WIDTH = 78  # running text is no wider, however wide the terminal
NARROWEST_BAR, WIDEST_BAR = 4, 40  # [columns]
WIDEST_CELL = (32, 24)  # columns of a text beside others, where room is scarce
NARROW_CELL = 16  # where that keeps a table whole
GAP = 2  # columns between columns

NO_BREAK = "\N{NO-BREAK SPACE}"
ASCII = {
    "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u",
    "\N{GREEK SMALL LETTER NU}": "v",
    "°": "deg",
    "±": "+-",
    "\N{EN DASH}": "-",
}
# After a wide character a line may end, but not before one that closes.
BREAK = re.compile(
    "([\u3000-\u30ff\u3400-\u9fff\uff00-\uffef])"
    "(?![\u3001\u3002\u300b\u300d\u201d\uff01\uff09\uff0c\uff1a\uff1b\uff1f]|$)"
    "(?<![\u300a\u300c\uff08])"
)
BOUND = re.compile(r"(?<=\d) (?=\S)|(?<=[<>]=) (?=\d)")  # a number, its unit and sign
COLOURS = {"meets": "green", "fails": "red"}  # of verdicts
OPEN = "yellow"  # of all others
SIGNS = str.maketrans({AT_LEAST: ">=", AT_MOST: "<=", "\N{INFINITY}": "inf"})


class TerminalPage:
    """A console that is written line by line, in characters that it can show."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._is_blank = True  # nothing before it, or a blank line
        self.width = console.width
        self.has_blocks = _encodes(EIGHTHS, console.encoding)

    def line(
        self, text: str = "", *, style: str = "", verdicts: Sequence[str] = ()
    ) -> None:
        """Print one line; a blank one parts, so that none follows another.

        rich neither wraps a line nor reads markup in it. Words of it that are verdicts
        are in their colours.
        """
        from rich.text import Text

        if self._is_blank and not text:
            return
        self._is_blank = not text
        encoding = self._console.encoding
        if not _encodes(text, encoding):
            for character, plain in ASCII.items():
                text = text.replace(character, plain)
            text = text.encode(encoding, errors="replace").decode(encoding)
        shown = Text(text.rstrip(), style=style)
        for word in verdicts:
            shown.highlight_words([word], _colour_of(word))
        self._console.print(shown, soft_wrap=True)

    def heading(self, text: str, *, style: str) -> None:
        """Print a title over as many lines as it needs."""
        verdict = _verdict_at_end(text)
        for line in _wrap(text, self.width):
            self.line(line, style=style, verdicts=[verdict] if verdict else ())

    def paragraph(self, text: str, *, first: str = "") -> None:
        """Print running text, indented below `first`; a number keeps its unit."""
        width = min(self.width, TEXT_WIDTH)
        bound = BOUND.sub(NO_BREAK, text.translate(SIGNS))
        indent = _columns(first)
        for place, line in enumerate(
            _wrap(_part_long(bound, width - indent), width - indent, on_hyphens=False)
        ):
            start = " " * indent if place else first
            self.line(f"{start}{line}".replace(NO_BREAK, " "))

    def bar(self, share: float, width: int) -> str:
        """Draw a share of `width` columns, to an eighth of one where possible."""
        eighths = round(8 * width * min(max(share, 0.0), 1.0))
        if not self.has_blocks:
            return "#" * round(eighths / 8)
        return EIGHTHS[8] * (eighths // 8) + EIGHTHS[eighths % 8].rstrip()


def print_sections(sections: Iterable[Section], page: TerminalPage) -> None:
    """Print sections below one another, or the line that stands for one in brief."""
    for section in sections:
        if section.in_brief == "":
            continue
        page.line()
        if section.in_brief is not None:
            page.line(section.in_brief, style="bold")
            continue
        colour = COLOURS.get(section.verdict, OPEN) if section.verdict else ""
        page.heading(section.title, style=f"bold {colour}".rstrip())
        print_blocks(section.blocks, page)


def print_blocks(blocks: Iterable[Block], page: TerminalPage) -> None:
    """Print what a terminal can show of blocks: no figure, no formula."""
    before: Block | None = None
    for block in blocks:
        if isinstance(before, Table) or (before and isinstance(block, Table | Sliders)):
            page.line()
        before = block
        match block:
            case Paragraph(words=words):
                page.paragraph(_plain(words))
            case Listing():
                _print_listing(block, page)
            case Pairs(rows=rows):
                width = max((_columns(term) for term, _ in rows), default=0) + GAP
                for term, words in rows:
                    page.paragraph(_plain(words), first=_padded(term, width))
            case Table() | Sliders():
                table = block.table if isinstance(block, Sliders) else block
                print_table(table, page)
            case Panel(title=title, blocks=inner):
                page.line()
                page.heading(title, style="bold underline")
                print_blocks(inner, page)
            case Abreast(blocks=inner):
                print_blocks(inner, page)


def _print_listing(listing: Listing, page: TerminalPage) -> None:
    """Print points, or what it means that there are none."""
    for place, item in enumerate(listing.items, start=1):
        page.paragraph(_plain(item), first=f"{place}. " if listing.numbered else "- ")
    if not listing.items:
        page.paragraph(listing.empty)


@dataclass(frozen=True, kw_only=True)
class SetColumn:
    """A column of a table as lines of text: its head, and each of its cells."""

    head: list[str]
    cells: list[list[str]]
    shares: list[float | None]
    flush_right: bool
    is_unit: bool

    @cached_property
    def width(self) -> int:
        """Characters of the longest line."""
        return max(_columns(line) for cell in (self.head, *self.cells) for line in cell)

    def line(self, cell: Sequence[str], place: int) -> str:
        """Return one line of a cell, as wide as the column."""
        text = cell[place] if 0 <= place < len(cell) else ""
        if self.flush_right:
            return " " * (self.width - _columns(text)) + text
        return _padded(text, self.width)


def print_table(table: Table, page: TerminalPage) -> None:
    """Print a table; columns for which there is no room, in tables below it.

    Texts are broken over lines where that makes room. The first column stands in each
    of the tables. Where even one more has no room beside it, every row is a list of its
    fields. Numbers are never cut or broken.
    """
    for widest in (page.width, *WIDEST_CELL, NARROW_CELL):
        columns = [_set(table, place, widest) for place in range(len(table.columns))]
        tried = _parts(columns, page.width)
        is_whole = tried is not None and len(tried) == 1
        if is_whole or widest != NARROW_CELL:
            parts = tried
        if is_whole:
            break
    if parts is None:
        _print_fields(table, page)
    for number, part in enumerate(parts or ()):
        if number:
            page.line()
        _print_part(table, part, page, with_notes=number == 0)


def _parts(columns: Sequence[SetColumn], width: int) -> list[list[SetColumn]] | None:
    """Share columns out over tables that are no wider; None where one has no room."""
    first, *others = columns
    parts: list[list[SetColumn]] = []
    room = width - first.width
    left = 0
    for place, column in enumerate(others):
        if not any(map(any, (column.head, *column.cells))):
            continue
        needed = GAP + column.width
        together = needed  # a number and its unit
        if place + 1 < len(others) and others[place + 1].is_unit:
            together += GAP + others[place + 1].width
        if together > room:
            return None
        if together > left:
            parts.append([first])
            left = room
        parts[-1].append(column)
        left -= needed
    return parts


def _set(table: Table, place: int, widest: int) -> SetColumn:
    """Break head and texts of a column into lines; points in line within a group."""
    column = table.columns[place]
    cells: list[list[str]] = []
    for group in table.groups:
        own = [row[place].text.translate(SIGNS) for row in group.rows]
        if column.kind == "number":
            cells += [[text] for text in align_decimals(own)]
        elif column.kind == "drawing":
            cells += [[text] for text in own]
        else:
            cells += [_break(text, widest) for text in own]
    longest = max(_columns(line) for cell in cells for line in cell)
    # No narrower than its longest word, which makes the column that wide anyway.
    longest = max(longest, *map(_columns, ("", *column.head.split())))
    return SetColumn(
        head=_break(column.head, longest if widest in WIDEST_CELL else widest),
        cells=cells,
        shares=[row[place].share for group in table.groups for row in group.rows],
        flush_right=column.kind == "number",
        is_unit=column.kind == "unit",
    )


def _break(text: str, width: int) -> list[str]:
    """Break a text between words; a number keeps its unit; one line at least."""
    lines = _wrap(BOUND.sub(NO_BREAK, text), width, on_hyphens=False) or [""]
    return [line.replace(NO_BREAK, " ") for line in lines]


def _columns(text: str) -> int:
    """Return how many columns a text takes: characters of Chinese take two."""
    if text.isascii():
        return len(text)
    return len(text) + sum(east_asian_width(sign) in "WF" for sign in text)


def _padded(text: str, width: int) -> str:
    """Fill a text up with blanks."""
    return text + " " * (width - _columns(text))


def _wrap(text: str, width: int, *, on_hyphens: bool = True) -> list[str]:
    """Break a text into lines of so many columns, one at least; no word is broken."""
    width = max(width, 1)
    if _columns(text) == len(text):
        return textwrap.wrap(
            text, width, break_long_words=False, break_on_hyphens=on_hyphens
        )
    lines: list[str] = []
    line = ""
    for word in re.sub(r"(?<=\d) (?=%)", NO_BREAK, text).split(" "):
        for place, unit in enumerate(BREAK.sub("\\1\n", word).split("\n")):
            space = " " if line and not place else ""
            if line and _columns(line) + len(space) + _columns(unit) > width:
                lines.append(line)
                line = unit
            else:
                line += space + unit
    found = [*lines, line] if line else lines
    return found if NO_BREAK in text else [one.replace(NO_BREAK, " ") for one in found]


def _print_part(
    table: Table, columns: Sequence[SetColumn], page: TerminalPage, *, with_notes: bool
) -> None:
    """Print some columns of a table side by side, heads above their last line."""

    def line(
        cells: Sequence[Sequence[str]], place: int, style: str, end: str = ""
    ) -> None:
        pairs = zip(columns, cells, strict=True)
        texts = [column.line(cell, place) for column, cell in pairs]
        words = [cell[place] for cell in cells if place < len(cell)]
        verdicts = [word for word in words if word in _verdicts()]
        page.line((" " * GAP).join([*texts, end]), style=style, verdicts=verdicts)

    room = page.width - sum(GAP + column.width for column in columns)
    bars = _bars(columns, min(room, WIDEST_BAR), page)
    high = max(len(column.head) for column in columns)
    heads = [[""] * (high - len(column.head)) + column.head for column in columns]
    for place in range(high if any(map(any, heads)) else 0):
        line(heads, place, "bold")
    rows = iter(zip(*(column.cells for column in columns), strict=True))
    for group in table.groups:
        if group.title:
            page.heading(group.title, style="underline")
        for row in group.rows:
            cells = next(rows)
            notes = _notes(row) if with_notes else ""
            size = max(map(len, cells))
            beside = next(bars)
            if not beside and notes and size == 1 and len(notes) + len("()") <= room:
                beside = f"({notes})"
            for place in range(size):
                line(cells, place, "bold" if row[0].strong else "", beside)
            if notes and beside != f"({notes})":
                page.paragraph(notes, first=" " * GAP)


def _bars(
    columns: Sequence[SetColumn], width: int, page: TerminalPage
) -> Iterator[str]:
    """Yield a bar for each row: of the share in it, where one column alone has any."""
    (shares, *others) = [c.shares for c in columns if any(c.shares)] or [[]]
    if others or width < NARROWEST_BAR:
        shares = []
    yield from (page.bar(share or 0.0, width) for share in shares)
    yield from repeat("")


def _print_fields(table: Table, page: TerminalPage) -> None:
    """Print every row as a list of its fields, below its head."""
    for group in table.groups:
        if group.title:
            page.paragraph(group.title)
        for row in group.rows:
            page.paragraph(row[0].text)
            for column, cell in zip(table.columns[1:], row[1:], strict=True):
                if cell.text:
                    said = (
                        say("{head}: {text}", head=column.head, text=cell.text)
                        if column.head
                        else cell.text
                    )
                    page.paragraph(said, first=" " * GAP)
            if notes := _notes(row):
                page.paragraph(notes, first=" " * GAP)


def _notes(row: Sequence[Cell]) -> str:
    """Return what is remarked on the cells of a row, below which it stands."""
    return say("; ").join(cell.note for cell in row if cell.note.strip())


def _verdicts() -> dict[str, str]:
    """Return the verdicts by how they are said, the longest first."""
    said = {say(word): verdict for verdict, word in VERDICTS.items()}
    return dict(sorted(said.items(), key=lambda one: -len(one[0])))


def _colour_of(word: str) -> str:
    """Return the colour of a verdict as it is said."""
    return COLOURS.get(_verdicts()[word], OPEN)


def _verdict_at_end(title: str) -> str:
    """Return the verdict that a title ends with, 'Gyro: FAILS', or ''."""
    return next((word for word in _verdicts() if title.endswith(word)), "")


def _plain(words: Words) -> str:
    """Return words as text, formulas as they are said."""
    return "".join(
        word
        if isinstance(word, str)
        else word.text
        if isinstance(word, Run)
        else word.alt
        for word in words
    )


def _part_long(text: str, room: int) -> str:
    """Part words that are too long for a line after a dot: the way to a key."""
    words = []
    for word in text.split(" "):
        rest = word
        while len(rest) > room and (place := rest.rfind(".", 1, room) + 1):
            words.append(rest[:place])
            rest = rest[place:]
        words.append(rest)
    return " ".join(words)


def _encodes(text: str, encoding: str) -> bool:
    """Whether the encoding has every character of the text."""
    try:
        text.encode(encoding)
    except (UnicodeEncodeError, LookupError):
        return False
    return True
