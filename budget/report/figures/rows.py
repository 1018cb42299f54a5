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
    def head(self) -> ChartRow:
        """The heads of what stands on the right."""
        return ChartRow(label="", marks=(), beside=self.beside)

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
        caption=chart.caption,
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
    left, beside = room = _room(chart, width)
    above = _above(chart)
    below = max(sum(_heights(chart, panel)[1] for panel in side) for side in sides)
    abreast = _abreast(chart, left)
    legend = LINE * -(-len(chart.legend) // abreast)
    height = above + below + legend + (LINE + EDGE if chart.foot else EDGE)
    figure = blank(height, width=chart.width)
    figure.set_label(chart.title)
    place = 0
    for k, side in enumerate(sides):
        start, top = k * (width + BETWEEN), above
        write_on(figure, start + EDGE, 10.0, side[0].side, size=TEXT, weight="bold")
        for panel in side:
            rows, whole = _heights(chart, panel)
            axes = add_panel(
                figure,
                left=start + left,
                top=top,
                width=width - left - max(sum(beside) + EDGE, LAST_TICK),
                height=rows,
            )
            _draw_panel(axes, chart, panel, room, place)
            place += len(panel.groups)
            top += whole
    if chart.foot:
        write_on(figure, EDGE, height - legend - EDGE, chart.foot, colour=MUTED)
    if chart.legend:
        _draw_legend(figure, chart, left, abreast)
    return figure


def _gid(group: int, row: int, mark: int) -> str:
    """Name a mark by its place."""
    return f"tip-{group}-{row}-{mark}"


def _room(chart: Chart, width: float) -> tuple[float, list[float]]:
    """Return the room of names on the left, and of each column on the right [pt]."""
    rows = [row for group in chart.groups for row in group.rows]
    left = max(LEAST_NAMES, *(text_width(row.label, TEXT) + 12.0 for row in rows))
    columns = [
        max(_beside_width(row, k) for row in (*rows, chart.head))
        for k in range(max(len(row.beside) for row in rows))
    ]
    spare = MOST_BESIDE * width - left
    labels = any(panel.scale.label for panel in chart.panels)
    if chart.flush == "right" and not labels:  # numbers are whole or wrong
        spare = max(spare, width - left - LEAST_PANEL)
    if sum(columns) > spare:  # the last column is cut
        columns[-1] = max(spare - sum(columns[:-1]), 0.0)
    return left, columns


def _beside_width(row: ChartRow, column: int) -> float:
    """Return the room that one text beside a row needs [pt]."""
    text = "".join(row.beside[column : column + 1])
    return (BOLD if row.strong else 1.0) * text_width(text) + 8.0 if text else 0.0


def _above(chart: Chart) -> float:
    """Return the room above the first panel [pt]."""
    lines = any(text for panel in chart.panels for _, text in panel.scale.lines)
    levels = max((1 + head.level for head in chart.heads), default=0)
    titles = LINE + EDGE if any(panel.side for panel in chart.panels) else EDGE
    return titles + LINE * max(levels, int(lines or any(chart.beside)))


def _heights(chart: Chart, panel: ChartPanel) -> tuple[float, float]:
    """Return the height of the rows of a panel with their titles, and with its axis."""
    titles = HEAD * sum(bool(group.title) for group in panel.groups)
    rows = titles + chart.pitch * sum(len(group.rows) for group in panel.groups)
    ticks = TICKS if panel.scale.ticks != () else 0.0
    return rows, rows + ticks + (LABEL if panel.scale.label else 0.0) + EDGE


def _draw_panel(
    axes: Axes,
    chart: Chart,
    panel: ChartPanel,
    room: tuple[float, list[float]],
    place: int,
) -> None:
    """Draw the groups of one panel; `place` is that of the first in the figure."""
    from matplotlib.collections import LineCollection

    left, beside = room
    set_scale(axes, "x", panel.scale, by_room=True)
    axes.set_ylim(_heights(chart, panel)[0], 0.0)
    ticks: list[tuple[float, str]] = []
    top = 0.0
    for g, group in enumerate(panel.groups, start=place):
        if group.title:
            at, shift = (0.0, top + HEAD / 2.0), (EDGE - left, 0.0)
            write(axes, group.title, at, shift, coords=BESIDE_AXES, **GROUP_TITLE)
            top += HEAD
        ends = (top, top + chart.pitch * len(group.rows))
        if band := panel.scale.band:
            axes.fill_betweenx(ends, *band, color=GRID, alpha=0.6, linewidth=0.0)
        else:
            grid = [[(x, end) for end in ends] for x in axes.get_xticks()]
            axes.add_artist(LineCollection(grid, colors=GRID, linewidths=0.6, zorder=0))
        for r, row in enumerate(group.rows):
            middle = top + chart.pitch * (r + 0.5)
            ticks.append((middle, row.label))
            for m, mark in enumerate(row.marks):
                _draw_mark(axes, middle, mark, _gid(g, r, m) if mark.tip else None)
            _write_beside(axes, middle, row, beside, chart.flush)
        top = ends[1]
    axes.set_yticks([y for y, _ in ticks], [text for _, text in ticks])
    without_name(axes.yaxis)
    is_first = panel is chart.panels[0]
    for x, text in panel.scale.lines:
        axes.axvline(x, color=INK if text else MUTED, linewidth=1.0 if text else 0.7)
    named = [Head(at=x, text=text) for x, text in panel.scale.lines]
    for head in (*named, *(chart.heads if is_first else ())):
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
    if is_first:
        _write_beside(axes, -LINE / 2.0, chart.head, beside, chart.flush)


BESIDE_AXES = ("axes fraction", "data")
GROUP_TITLE: dict[str, Any] = {
    "va": "center",
    "strong": True,
    "size": TEXT,
    "paper": 1.0,
}


def _draw_mark(axes: Axes, middle: float, mark: ChartMark, gid: str | None) -> None:
    """Draw one mark on the line of its row: a bar, its frame and its text, or a line.

    The ends of the axes are set: artists are put on them, which `plot` and `barh`
    measure first, for axes that fit themselves to what is drawn.
    """
    from matplotlib.colors import to_rgba
    from matplotlib.lines import Line2D
    from matplotlib.patches import Rectangle

    y = middle + mark.lift
    if mark.shape != "bar":
        is_line = mark.shape == "-"
        axes.add_artist(
            Line2D(
                [mark.start, mark.end] if is_line else [mark.start],
                [y, y] if is_line else [y],
                color=mark.colour,
                linestyle="-" if is_line else "none",
                linewidth=mark.width,
                marker="" if is_line else mark.shape,
                markersize=mark.width,
                markeredgecolor=mark.edge,
                markeredgewidth=0.9,
                clip_on=is_line,
                zorder=3 if is_line else 4,
                gid=gid,
            )
        )
        return
    low, high = sorted((mark.start, mark.end))
    face = to_rgba(mark.colour, None if mark.opacity == 1.0 else mark.opacity)
    # As `barh` hands it on: the id of a hatch is made of its repr.
    hatch = np.str_(mark.hatch) if mark.hatch else None
    bar = (mark.height, face, mark.edge, mark.width, hatch, gid)
    frame = (mark.height - 1.0, "none", INK, 1.0, None, None)
    for height, colour, edge, width, hatch, name in (bar, frame)[: 1 + mark.is_framed]:
        axes.add_artist(
            Rectangle(
                (low, y - height / 2.0),
                high - low,
                height,
                facecolor=colour,
                edgecolor=edge,
                linewidth=width,
                hatch=hatch,
                gid=name,
            )
        )
    start, end = axes.transData.transform([(low, y), (high, y)])[:, 0]
    if mark.text and fits(mark.text, in_points(axes, end - start)):
        write(
            axes,
            mark.text,
            ((low + high) / 2.0, y),
            strong=mark.strong,
            colour=mark.text_colour,
            ha="center",
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
