"""Charts of named rows: bars, lines and signs on a scale, drawn from a table.

Names of rows, texts beside them, tooltips and alternative text are those of the table.
Heights are in points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    TEXT,
    WIDTH,
    Scale,
    add_panel,
    as_picture,
    blank,
    fits,
    house_style,
    in_points,
    set_scale,
    shorten,
    text_width,
    without_name,
    write,
    write_on,
)
from budget.report.figures.tabled import alternative, entries, shown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator
    from types import SimpleNamespace

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture, Table

HEAD = 14.0  # height of the title of a group [pt]
EDGE = 4.0  # air at the edges of the figure [pt]
TICKS, LABEL = 14.0, 14.0  # height of the numbers of an axis, and of its name [pt]
LINE = 12.0  # height of a line of small text [pt]
BETWEEN = 12.0  # sides [pt]
LEAST_NAMES = 24.0  # room for names on the left, also where they are 'x' [pt]
LEAST_PANEL = 36.0  # between names and numbers [pt]
MOST_BESIDE = 0.72  # part of the width that names and numbers may take together [1]
LAST_TICK = 9.0  # air beside a panel without texts, for half a number [pt]
BOLD = 1.12  # width of bold texts over that of others [1]
HUNDRED = tuple((float(x), str(x)) for x in (0, 25, 50, 75, 100))  # ticks of per cent


@dataclass(frozen=True, kw_only=True)
class ChartMark:
    """A bar or a line from one value to another, or a sign at one.

    `height` and `lift`, the distance below the middle of the row, are in points. A
    frame is drawn over a bar in ink. `text` stands in its middle where it fits.
    """

    shape: str  # 'bar', '-', or a sign: 'o', '<', '>', 'D'
    start: float
    end: float = 0.0  # of a bar or a line
    colour: str = MUTED  # 'none' of a hollow one
    edge: str = PAPER
    width: float = 0.6  # of the edge, of a line, of a sign [pt]
    opacity: float = 1.0
    hatch: str = ""
    height: float = 9.0
    lift: float = 0.0
    is_framed: bool = False
    text: str = ""
    text_colour: str = INK
    strong: bool = False
    tip: str = ""


Bar = partial(ChartMark, shape="bar")
Stroke = partial(ChartMark, shape="-", width=0.7)
Dot = partial(ChartMark, shape="o", colour=INK, edge=INK, width=5.0)


@dataclass(frozen=True, kw_only=True)
class ChartRow:
    """One row of a figure."""

    label: str  # its name on the left
    marks: tuple[ChartMark, ...]
    beside: tuple[str, ...] = ()  # what stands on the right, a text a column
    strong: bool = False  # whether that is bold


@dataclass(frozen=True, kw_only=True)
class ChartGroup:
    """Rows under a title, '' for none."""

    rows: tuple[ChartRow, ...]
    title: str = ""


@dataclass(frozen=True, kw_only=True)
class ChartPanel:
    """Groups of rows on one scale; those of one side stand below one another."""

    scale: Scale
    groups: tuple[ChartGroup, ...]
    side: str = ""  # its title, of several beside each other


@dataclass(frozen=True, kw_only=True)
class Head:
    """A word above the panel, at a place of its axis; `level` lines further up."""

    at: float
    text: str
    is_centred: bool = True
    level: int = 0
    colour: str = INK


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A figure of rows, before it is drawn."""

    name: str  # as in `Picture`; so are `title` (the finding) and `caption`
    title: str
    panels: tuple[ChartPanel, ...]
    table: Table | None = None  # what it is drawn from
    has_data: bool = True  # whether that is shown: not where one beside it has the same
    numbers: Table | None = None  # what is shown in its place
    caption: str = ""
    after: str = ""  # a sentence that ends the caption
    heads: tuple[Head, ...] = ()  # words above the first panel
    # Heads of the columns of texts on the right; '' for none.
    beside: tuple[str, ...] = ()
    # The side on which those texts are in line, 'right' for numbers.
    flush: str = "right"
    pitch: float = 13.0  # from row to row [pt]
    foot: str = ""  # what the axes are of, where there are several
    # Colour, hatch and name of what no text names in the figure.
    legend: tuple[tuple[str, str, str], ...] = ()
    data_on_paper: bool = False  # as in `Picture`
    width: float = WIDTH  # that of a column or of the page [pt]
    # What a telephone has of a wide one; None for the same, drawn narrower.
    narrow: Chart | None = None

    @property
    def groups(self) -> tuple[ChartGroup, ...]:
        """All groups, in the order that they are drawn in."""
        return tuple(group for panel in self.panels for group in panel.groups)

    @property
    def sides(self) -> list[list[ChartPanel]]:
        """The panels of each side."""
        titles = dict.fromkeys(panel.side for panel in self.panels)
        return [[one for one in self.panels if one.side == side] for side in titles]

    @property
    def alt(self) -> str:
        """The finding and all numbers, for those who cannot see them."""
        return alternative(self.title, self.table)

    @property
    def data(self) -> Table | None:
        """The numbers behind the figure."""
        own = shown(self.table) if self.table and self.has_data else None
        return self.numbers or own

    @property
    def tips(self) -> dict[str, str]:
        """Tooltips by the gid of their marks."""
        return {
            _gid(g, r, m): mark.tip
            for g, group in enumerate(self.groups)
            for r, row in enumerate(group.rows)
            for m, mark in enumerate(row.marks)
            if mark.tip
        }


def rows_of(
    table: Table,
    draw: Callable[..., Iterable[ChartMark]],
    *records: Iterable[Any],
    by: Callable[..., Any] | None = None,
) -> tuple[ChartGroup, ...]:
    """Return the rows of a table with the marks that `draw` makes of each entry.

    And of the record of the row, where there are such; `by` sorts them in a group.
    """
    left = zip(*map(iter, records), strict=False)
    groups = []
    for title, own in entries(table):
        pairs = [(one, *(next(left) if records else ())) for one in own]
        rows = tuple(
            ChartRow(
                label=pair[0].label,
                marks=tuple(draw(*pair)),
                beside=pair[0].beside,
                strong=pair[0].strong,
            )
            for pair in (sorted(pairs, key=lambda pair: by(*pair)) if by else pairs)
        )
        groups.append(ChartGroup(title=title, rows=rows))
    return tuple(groups)


def cells(
    entry: SimpleNamespace, look: Callable[[SimpleNamespace], dict[str, Any] | None]
) -> Iterator[ChartMark]:
    """Yield the cells of a row of a map, as they look; none where that is None."""
    for one in entry.cells:
        if (own := look(one)) is not None:
            yield Bar(
                **{"edge": "none", "text": one.text, "tip": one.tip, "height": 14.0}
                | {"start": one.at + CELL_EDGE, "end": one.at + 1.0 - CELL_EDGE}
                | own
            )


CELL_EDGE = 0.02  # of a cell of a map, over its width [1]


@house_style()
def chart_picture(chart: Chart) -> Picture:
    """Draw a figure of rows into a block."""
    return as_picture(
        draw(chart),
        name=chart.name,
        title=chart.title,
        alt=chart.alt,
        tips=chart.tips,
        caption=f"{chart.caption} {chart.after}".strip(),
        data=chart.data,
        narrow=draw(chart.narrow or replace(chart, width=WIDTH))
        if chart.width > WIDTH
        else None,
        data_on_paper=chart.data_on_paper,
    )


@house_style()
def draw(chart: Chart) -> Figure:
    """Draw a figure of rows; what stands beside them has the room that it needs."""
    sides = chart.sides
    width = (chart.width - BETWEEN * (len(sides) - 1)) / len(sides)
    room = _room(chart, width)
    above = _above(chart)
    below = max(sum(_height(chart, panel) for panel in side) for side in sides)
    abreast = _abreast(chart, room.left)
    legend = LINE * -(-len(chart.legend) // abreast)
    foot = LINE + EDGE if chart.foot else EDGE
    height = above + below + foot + legend
    figure = blank(height, width=chart.width)
    figure.set_label(chart.title)
    place = 0
    for k, side in enumerate(sides):
        start = k * (width + BETWEEN)
        write_on(figure, start + EDGE, 10.0, side[0].side, size=TEXT, weight="bold")
        top = above
        for panel in side:
            axes = add_panel(
                figure,
                left=start + room.left,
                top=top,
                width=width - room.left - max(sum(room.beside) + EDGE, LAST_TICK),
                height=_rows_height(chart, panel),
            )
            _draw_panel(axes, chart, panel, room, place)
            place += len(panel.groups)
            top += _height(chart, panel)
    if chart.foot:
        base = height - legend - EDGE
        write_on(figure, EDGE, base, chart.foot, colour=MUTED)
    if chart.legend:
        _draw_legend(figure, chart, room.left, abreast)
    return figure


@dataclass(frozen=True, kw_only=True)
class _Room:
    """What stands beside the rows: names on the left, columns of texts [pt]."""

    left: float
    beside: list[float]


def _gid(group: int, row: int, mark: int) -> str:
    """Name a mark by its place."""
    return f"tip-{group}-{row}-{mark}"


def _room(chart: Chart, width: float) -> _Room:
    """Return the room that names and texts beside the rows need."""
    rows = [row for group in chart.groups for row in group.rows]
    left = max(LEAST_NAMES, *(text_width(row.label, TEXT) + 12.0 for row in rows))
    heads = ChartRow(label="", marks=(), beside=chart.beside)
    columns = [
        max(_beside_width(row, k) for row in (*rows, heads))
        for k in range(max(len(row.beside) for row in rows))
    ]
    spare = MOST_BESIDE * width - left
    labels = any(panel.scale.label for panel in chart.panels)
    if chart.flush == "right" and not labels:  # numbers are whole or wrong
        spare = max(spare, width - left - LEAST_PANEL)
    if sum(columns) > spare:  # the last column is cut
        columns[-1] = max(spare - sum(columns[:-1]), 0.0)
    return _Room(left=left, beside=columns)


def _beside_width(row: ChartRow, column: int) -> float:
    """Return the room that one text beside a row needs [pt]."""
    text = row.beside[column] if column < len(row.beside) else ""
    return (BOLD if row.strong else 1.0) * text_width(text) + 8.0 if text else 0.0


def _above(chart: Chart) -> float:
    """Return the room above the first panel [pt]."""
    lines = any(text for panel in chart.panels for _, text in panel.scale.lines)
    levels = max((1 + head.level for head in chart.heads), default=0)
    titles = LINE + EDGE if any(panel.side for panel in chart.panels) else EDGE
    return titles + LINE * max(levels, int(lines or any(chart.beside)))


def _rows_height(chart: Chart, panel: ChartPanel) -> float:
    """Return the height of the rows of a panel and their titles [pt]."""
    return sum(
        (HEAD if group.title else 0.0) + chart.pitch * len(group.rows)
        for group in panel.groups
    )


def _height(chart: Chart, panel: ChartPanel) -> float:
    """Return the height of a panel with its axis [pt]."""
    ticks = TICKS if panel.scale.ticks != () else 0.0
    label = LABEL if panel.scale.label else 0.0
    return _rows_height(chart, panel) + ticks + label + EDGE


def _draw_panel(
    axes: Axes, chart: Chart, panel: ChartPanel, room: _Room, place: int
) -> None:
    """Draw the groups of one panel; `place` is that of the first in the figure."""
    from matplotlib.collections import LineCollection
    from matplotlib.ticker import FixedFormatter, FixedLocator

    set_scale(axes, "x", panel.scale, by_room=True)
    axes.set_ylim(_rows_height(chart, panel), 0.0)
    ticks: list[tuple[float, str]] = []
    top = 0.0
    for g, group in enumerate(panel.groups, start=place):
        if group.title:
            write(
                axes,
                group.title,
                (0.0, top + HEAD / 2.0),
                (EDGE - room.left, 0.0),
                coords=("axes fraction", "data"),
                va="center",
                strong=True,
                size=TEXT,
                paper=1.0,
            )
            top += HEAD
        ends = (top, top + chart.pitch * len(group.rows))
        if panel.scale.band:
            axes.fill_betweenx(
                ends, *panel.scale.band, color=GRID, alpha=0.6, linewidth=0.0
            )
        else:
            grid = [[(x, end) for end in ends] for x in axes.get_xticks()]
            axes.add_artist(LineCollection(grid, colors=GRID, linewidths=0.6, zorder=0))
        for r, row in enumerate(group.rows):
            middle = top + chart.pitch / 2.0
            ticks.append((middle, row.label))
            for m, mark in enumerate(row.marks):
                _draw_mark(axes, middle, mark, _gid(g, r, m) if mark.tip else None)
            _write_beside(axes, middle, row, room.beside, chart.flush)
            top += chart.pitch
    axes.yaxis.set_major_locator(FixedLocator([y for y, _ in ticks]))
    axes.yaxis.set_major_formatter(FixedFormatter([text for _, text in ticks]))
    without_name(axes.yaxis)
    for x, text in panel.scale.lines:
        axes.axvline(x, color=INK if text else MUTED, linewidth=1.0 if text else 0.7)
        _write_above(axes, Head(at=x, text=text))
    if panel is chart.panels[0]:
        for head in chart.heads:
            _write_above(axes, head)
        heads = ChartRow(label="", marks=(), beside=chart.beside)
        _write_beside(axes, -LINE / 2.0, heads, room.beside, chart.flush)


def _draw_mark(axes: Axes, middle: float, mark: ChartMark, gid: str | None) -> None:
    """Draw one mark on the line of its row."""
    from matplotlib.lines import Line2D

    y = middle + mark.lift
    # The ends of the axes are set: artists are put on them, which `plot` and `barh`
    # measure first, for axes that fit themselves to what is drawn.
    if mark.shape == "-":
        axes.add_artist(
            Line2D(
                [mark.start, mark.end],
                [y, y],
                color=mark.colour,
                linewidth=mark.width,
                zorder=3,
                gid=gid,
            )
        )
    elif mark.shape != "bar":
        axes.add_artist(
            Line2D(
                [mark.start],
                [y],
                marker=mark.shape,
                markersize=mark.width,
                color=mark.colour,
                markeredgecolor=mark.edge,
                markeredgewidth=0.9,
                linestyle="none",
                zorder=4,
                clip_on=False,
                gid=gid,
            )
        )
    else:
        _draw_bar(axes, y, mark, gid)


def _draw_bar(axes: Axes, y: float, bar: ChartMark, gid: str | None) -> None:
    """Draw a bar, its frame and its text."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Rectangle

    low, high = sorted((bar.start, bar.end))
    axes.add_artist(
        Rectangle(
            (low, y - bar.height / 2.0),
            high - low,
            bar.height,
            facecolor=to_rgba(bar.colour, None if bar.opacity == 1.0 else bar.opacity),
            edgecolor=bar.edge,
            linewidth=bar.width,
            # As `barh` hands it on: the id of a hatch is made of its repr.
            hatch=np.str_(bar.hatch) if bar.hatch else None,
            gid=gid,
        )
    )
    if bar.is_framed:
        height = bar.height - 1.0
        axes.add_artist(
            Rectangle(
                (low, y - height / 2.0),
                high - low,
                height,
                facecolor="none",
                edgecolor=INK,
                linewidth=1.0,
            )
        )
    start, end = axes.transData.transform([(low, y), (high, y)])[:, 0]
    if bar.text and fits(bar.text, in_points(axes, end - start)):
        write(
            axes,
            bar.text,
            ((low + high) / 2.0, y),
            strong=bar.strong,
            colour=bar.text_colour,
            ha="center",
        )


def _write_above(axes: Axes, head: Head) -> None:
    """Write a word above the panel."""
    write(
        axes,
        head.text,
        (head.at, 1.0),
        (0.0, EDGE + LINE * head.level),
        coords=("data", "axes fraction"),
        ha="center" if head.is_centred else "left",
        va="baseline",
        colour=head.colour,
    )


def _write_beside(
    axes: Axes, middle: float, row: ChartRow, columns: list[float], flush: str
) -> None:
    """Write the texts of a row on its right, each in its column."""
    start = 0.0
    for text, width in zip(row.beside, columns, strict=False):
        write(
            axes,
            shorten(text, (width - 7.0) / (BOLD if row.strong else 1.0)),
            (1.0, middle),
            (start + (width if flush == "right" else 6.0), 0.0),
            coords=("axes fraction", "data"),
            strong=row.strong,
            ha=flush,
        )
        start += width


def _abreast(chart: Chart, left: float) -> int:
    """Return how many names of colours stand beside each other: two, if they fit."""
    # Of the size of a text: a patch, the gap behind it, and that between columns.
    widest = max((text_width(name) for _, _, name in chart.legend), default=0.0)
    needed = 2.0 * (widest + 2.0 * SMALL) + 2.0 * SMALL
    return 2 if left + needed <= chart.width else 1


def _draw_legend(figure: Figure, chart: Chart, left: float, abreast: int) -> None:
    """Name colours at the foot."""
    from matplotlib.patches import Patch

    figure.legend(
        handles=[
            Patch(facecolor=colour, hatch=hatch, edgecolor=PAPER)
            for colour, hatch, _ in chart.legend
        ],
        labels=[name for _, _, name in chart.legend],
        loc="lower left",
        bbox_to_anchor=(left / chart.width, 0.0),
        ncols=abreast,
        frameon=False,
        fontsize=SMALL,
        labelcolor=INK,
        borderpad=0.0,
        borderaxespad=0.0,
        handlelength=1.2,
        handleheight=0.9,
    )
