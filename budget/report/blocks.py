"""Documents as sections of blocks, the same for terminal, HTML, PDF.

Builders (`budget.report.analysis`, and those of comparison and allocation) make these
records of results; renderers turn them into pages (`budget.report.page` and
`budget.report.typeset`) and into lines of a terminal (`budget.report.terminal`).
Numbers are text already: `budget.report.tables` rounds them, once.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from budget.language import say, speaking, spoken

if TYPE_CHECKING:
    from collections.abc import (
        Callable,
        Iterable,
        Iterator,
        Mapping,
    )

    from budget.report.formulas import Math


@dataclass(frozen=True, kw_only=True)
class Run:
    """A stretch of text; bold, or with the exact value of the number that it is."""

    text: str
    strong: bool = False
    exact: float | None = None


Words = tuple["str | Run | Math", ...]  # a line of text, with formulas in it


@dataclass(frozen=True, kw_only=True)
class Paragraph:
    """Words that run on; small ones comment on what is beside them."""

    words: Words
    small: bool = False


@dataclass(frozen=True, kw_only=True)
class Listing:
    """Points, numbered or not; `empty` says what it means that there are none."""

    items: tuple[Words, ...]
    empty: str
    numbered: bool = False


@dataclass(frozen=True, kw_only=True)
class Pairs:
    """Terms and what they are."""

    rows: tuple[tuple[str, Words], ...]


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table: its head, with the unit of all its numbers in it."""

    head: str
    # 'text', 'number' (decimal points in line, sorted by the exact value), 'unit'
    # (beside a number), 'code' (a hash, in fixed width) or 'drawing' (of characters, on
    # a terminal alone).
    kind: str = "text"
    # Share of the width that a text column asks for beside other text columns.
    weight: float = 1.0
    # Where a narrow page has it, as numbers that answer come first: '' beside the head
    # of the row, 'below' it, or there after a tap, 'more'.
    when_narrow: str = ""
    role: str = ""  # what a script knows it by


@dataclass(frozen=True, kw_only=True)
class Share:
    """One part of a stacked bar: what it is of, its share, and how it looks."""

    name: str  # for a program: 'gyro.bias_repeatability'
    text: str  # 'bias repeatability 94 %'
    share: float  # of the variance [1]
    colour: str  # '#0072B2'


@dataclass(frozen=True, kw_only=True)
class Shares:
    """A stacked bar in a cell: shares of one variance, from the largest."""

    outputs: tuple[str, ...]  # that the row is of, the first has these: 'gyro.bias.x'
    parts: tuple[Share, ...]


@dataclass(frozen=True, kw_only=True)
class Cell:
    """One cell: its text, rounded, and what it is exactly."""

    text: str  # as it is printed
    # In full precision, where it is a number: tooltips and sorting.
    exact: float | None = None
    share: float | None = None  # part of the cell that a bar behind the text fills [1]
    strong: bool = False  # bold: what the reader must not miss
    note: str = ""  # a second line, small
    shares: Shares | None = None  # a stacked bar above the text


@dataclass(frozen=True, kw_only=True)
class RowGroup:
    """Rows that belong together; decimal points are in line within the group.

    Its title, where it has one, is a line across the table.
    """

    rows: tuple[tuple[Cell, ...], ...]  # the first cell is the head of the row
    title: str = ""


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table with a head that repeats on every printed page.

    Raises
    ------
    ValueError
        A row has more or fewer cells than there are columns.
    """

    name: str  # one word for a link, unique in the document: 'inputs-gyro'
    # What it shows, for those who hear the page; printed in the PDF's tags only.
    caption: str
    columns: tuple[Column, ...]
    groups: tuple[RowGroup, ...]  # every row has as many cells as there are columns
    is_wide: bool = False  # whether it needs the width of the page
    searchable: bool = False  # whether it is long enough to be searched and sorted
    for_pen: bool = False  # whether people write into it: wide, with rows of 12 mm

    def __post_init__(self) -> None:
        """Hold every row to the number of columns."""
        for group in self.groups:
            for row in group.rows:
                if len(row) != len(self.columns):
                    raise ValueError(
                        f"table {self.name!r}: a row has {len(row)} cells, "
                        f"expected {len(self.columns)}"
                    )


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure: title with the finding, the same in words with numbers, its data."""

    name: str  # one word, unique in the document: 'shares-gyro-bias'
    title: str  # the finding: 'Bias repeatability makes 97 % of the gyro bias variance'
    alt: str  # the finding with the numbers, for those who cannot see it
    # From `budget.report.figures.style.to_svg`, with texts as text.
    svg: str = field(repr=False)
    # Tooltips by the gid of the element that they belong to.
    tips: Mapping[str, str] = field(default_factory=dict, repr=False)
    caption: str = ""  # how to read it; '' where the axes say it all
    # The numbers behind it; None where a table beside it has them.
    data: Table | None = None
    is_wide: bool = False  # whether it needs the width of the page
    narrow: str = field(default="", repr=False)  # the same for a telephone, if it does
    # Whether paper has that table too: not where the figure or a table prints them.
    data_on_paper: bool = True


@dataclass(frozen=True)
class ForPages:
    """Blocks that only a page shows, figures mostly; made where one does, and once."""

    make: Callable[[], Iterable[Block]]
    language: str = field(default_factory=spoken)  # when they were asked for

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """What was made."""
        with speaking(self.language):
            return tuple(self.make())


@dataclass(frozen=True, kw_only=True)
class Equation:
    """A formula on a line of its own, with the number it has in its source."""

    math: Math
    number: str = ""


@dataclass(frozen=True, kw_only=True)
class Equations:
    """Formulas side by side, as many as fit."""

    equations: tuple[Equation, ...]


@dataclass(frozen=True, kw_only=True)
class Sliders:
    """What one specification would do: a table; in HTML, sliders above it."""

    # What the page computes from, as JSON: `budget.studies.what_if`.
    model: Mapping[str, object] = field(repr=False)
    table: Table  # the same for a few fixed changes, for paper


@dataclass(frozen=True, kw_only=True)
class Panel:
    """A part of a section under a heading of its own, kept together if it can be."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, kw_only=True)
class Abreast:
    """Panels or pictures beside each other, where there is room for them.

    `columns` is the most that stand side by side on a wide page.
    """

    blocks: tuple[Panel | Picture | ForPages, ...]
    columns: int = 2


Block = (
    Paragraph
    | Listing
    | Pairs
    | Table
    | Picture
    | ForPages
    | Equations
    | Sliders
    | Panel
    | Abreast
)


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of a document that its contents name."""

    name: str  # one word for a link, unique in the document: 'inputs'
    title: str
    blocks: tuple[Block, ...]
    # Whether it belongs to the answer on page one; those sections come first.
    on_first_page: bool = False
    verdict: str = ""  # that the title says, 'fails': a terminal has a colour for it
    # What a terminal prints in its place, '' for nothing; None for its blocks.
    in_brief: str | None = None


@dataclass(frozen=True, kw_only=True)
class Card:
    """The answer for one sensor, or for one group of parameters."""

    title: str
    lines: tuple[Words, ...]


@dataclass(frozen=True, kw_only=True)
class Document:
    """A whole report."""

    # 'report', 'comparison', 'allocation' or 'paper': names the embedded JSON.
    kind: str
    title: str  # what it is of: the devices
    # Procedure, place; the date and the version stand beside them.
    facts: tuple[str, ...]
    headline: str  # the answer in one line: 'FAILS navigation grade'
    summary: Words  # the answer in a sentence or two
    cards: tuple[Card, ...]  # the answer in parts
    sections: tuple[Section, ...]  # those of page one first
    json: str = field(repr=False)  # all numbers in full precision
    date: str  # year-month-day
    version: str  # of the tool
    language: str = field(default_factory=spoken)  # 'en', 'zh'

    @property
    def running_head(self) -> str:
        """The verdict on every printed page; it may begin with the title."""
        if self.headline.startswith(self.title):
            return self.headline
        return say("{title}: {headline}", title=self.title, headline=self.headline)


def drawn(document: Document) -> Document:
    """Return a document with the blocks in it that only a page shows."""
    sections = tuple(
        replace(section, blocks=tuple(_drawn(section.blocks)))
        for section in document.sections
    )
    return replace(document, sections=sections)


def _drawn(blocks: Iterable[Block]) -> Iterator[Any]:
    """Yield blocks; one of others is left out where nothing was made for it."""
    for block in blocks:
        if isinstance(block, ForPages):
            yield from block.blocks
        elif isinstance(block, Panel | Abreast):
            if inner := tuple(_drawn(block.blocks)):
                yield replace(block, blocks=inner)
        else:
            yield block
