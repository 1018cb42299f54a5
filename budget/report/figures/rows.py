"""Named rows with marks: the one drawing of every figure that is a list of rows.

A figure says what each row is called, what is drawn on it, what is written beside it
and what is said of it. Drawing, tooltips and alternative text are made of that here.
Heights are in points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    TEXT,
    WIDTH,
    add_panel,
    as_picture,
    blank,
    fits,
    house_style,
    log_ticks,
    shorten,
    text_width,
    without_name,
    write,
    write_on,
)
from budget.report.pages import line

if TYPE_CHECKING:
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
TICK_ROOM, DECADE_ROOM = 30.0, 24.0  # of a number, of a power of ten on an axis [pt]
LAST_TICK = 9.0  # air beside a panel without texts, for half a number [pt]


@dataclass(frozen=True, kw_only=True)
class Bar:
    """From one value to another; hollow where `colour` is 'none'.

    `height` and `lift`, the distance below the middle of the row, are in points. A
    frame is drawn over it in ink. `text` stands in its middle where it fits.
    """

    start: float
    end: float
    colour: str = MUTED
    edge: str = PAPER
    edge_width: float = 0.6  # [pt]
    opacity: float = 1.0
    hatch: str = ""
    height: float = 9.0
    lift: float = 0.0
    is_framed: bool = False
    text: str = ""
    text_colour: str = INK
    strong: bool = False
    tip: str = ""


@dataclass(frozen=True, kw_only=True)
class Stroke:
    """A thin line from one value to another."""

    start: float
    end: float
    colour: str = MUTED
    width: float = 0.7  # [pt]
    lift: float = 0.0
    tip: str = ""


@dataclass(frozen=True, kw_only=True)
class Dot:
    """A mark at a value: 'o', '<', '>', 'D', '|'."""

    at: float
    shape: str = "o"
    fill: str = INK
    edge: str = INK
    size: float = 5.0  # [pt]
    lift: float = 0.0
    tip: str = ""


Mark = Bar | Stroke | Dot


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row of a figure."""

    label: str  # its name on the left
    marks: tuple[Mark, ...]
    beside: tuple[str, ...] = ()  # what stands on the right, a text a column
    strong: bool = False  # whether that is bold
    said: str = ""  # the row in words with its numbers; '' where nothing is said of it


@dataclass(frozen=True, kw_only=True)
class Group:
    """Rows under a title, '' for none; `said` is that title in words."""

    rows: tuple[Row, ...]
    title: str = ""
    said: str = ""


@dataclass(frozen=True, kw_only=True)
class Scale:
    """The axis that rows share."""

    # Its ends.
    low: float
    high: float
    kind: str = "linear"  # 'linear', 'log', or 'symlog' (linear between -1 and 1)
    # Where its numbers stand, and as what; None for round ones.
    ticks: tuple[tuple[float, str], ...] | None = None
    # Lines across all rows, a limit or a zero, with a word above; '' for none.
    lines: tuple[tuple[float, str], ...] = ()
    band: tuple[float, float] | None = None  # what is shaded behind the rows
    label: str = ""  # quantity and unit


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Groups of rows on one scale."""

    scale: Scale
    groups: tuple[Group, ...]


@dataclass(frozen=True, kw_only=True)
class Side:
    """Panels one below the other under a title: the outputs of one sensor."""

    panels: tuple[Panel, ...]
    title: str = ""


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
    sides: tuple[Side, ...]  # beside each other
    lead: str = ""  # what the numbers are, before those of the rows are said
    after: str = ""  # what is said after them, a sentence or none
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
    # The numbers behind the figure; None where a table beside it has them.
    data: Table | None = None
    data_on_paper: bool = True  # as in `Picture`
    width: float = WIDTH  # that of a column or of the page [pt]
    # What a telephone has of a wide one; None for the same, drawn narrower.
    narrow: Chart | None = None

    @property
    def groups(self) -> tuple[Group, ...]:
        """All groups, in the order that they are drawn in."""
        return tuple(g for side in self.sides for p in side.panels for g in p.groups)

    @property
    def alt(self) -> str:
        """The finding and all numbers, for those who cannot see them."""
        return line("figures_rows", "alt", chart=self)

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
    number = len(chart.sides)
    width = (chart.width - BETWEEN * (number - 1)) / number
    room = _room(chart, width)
    above = _above(chart)
    below = max(
        sum(_height(chart, panel) for panel in side.panels) for side in chart.sides
    )
    abreast = _abreast(chart, room.left)
    legend = LINE * -(-len(chart.legend) // abreast)
    foot = LINE + EDGE if chart.foot else EDGE
    height = above + below + foot + legend
    figure = blank(height, width=chart.width)
    figure.set_label(chart.title)
    place = 0
    for k, side in enumerate(chart.sides):
        start = k * (width + BETWEEN)
        if side.title:
            write_on(figure, start + EDGE, 10.0, side.title, size=TEXT, weight="bold")
        top = above
        for panel in side.panels:
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
    heads = Row(label="", marks=(), beside=chart.beside)
    columns = [
        max(_beside_width(row, k) for row in (*rows, heads))
        for k in range(max(len(row.beside) for row in rows))
    ]
    spare = MOST_BESIDE * width - left
    labels = any(p.scale.label for side in chart.sides for p in side.panels)
    if chart.flush == "right" and not labels:  # numbers are whole or wrong
        spare = max(spare, width - left - LEAST_PANEL)
    if sum(columns) > spare:  # the last column is cut
        columns[-1] = max(spare - sum(columns[:-1]), 0.0)
    return _Room(left=left, beside=columns)


def _beside_width(row: Row, column: int) -> float:
    """Return the room that one text beside a row needs [pt]."""
    text = row.beside[column] if column < len(row.beside) else ""
    return (1.12 if row.strong else 1.0) * text_width(text) + 8.0 if text else 0.0


def _above(chart: Chart) -> float:
    """Return the room above the first panel [pt]."""
    lines = any(
        text
        for side in chart.sides
        for panel in side.panels
        for _, text in panel.scale.lines
    )
    levels = max((1 + head.level for head in chart.heads), default=0)
    titles = LINE + EDGE if any(side.title for side in chart.sides) else EDGE
    return titles + LINE * max(levels, int(lines or any(chart.beside)))


def _rows_height(chart: Chart, panel: Panel) -> float:
    """Return the height of the rows of a panel and their titles [pt]."""
    return sum(
        (HEAD if group.title else 0.0) + chart.pitch * len(group.rows)
        for group in panel.groups
    )


def _height(chart: Chart, panel: Panel) -> float:
    """Return the height of a panel with its axis [pt]."""
    ticks = TICKS if panel.scale.ticks != () else 0.0
    label = LABEL if panel.scale.label else 0.0
    return _rows_height(chart, panel) + ticks + label + EDGE


def _draw_panel(
    axes: Axes, chart: Chart, panel: Panel, room: _Room, place: int
) -> None:
    """Draw the groups of one panel; `place` is that of the first in the figure."""
    from matplotlib.collections import LineCollection
    from matplotlib.ticker import FixedFormatter, FixedLocator

    _set_scale(axes, panel.scale)
    axes.set_ylim(_rows_height(chart, panel), 0.0)
    first = chart.sides[0].panels[0]
    ticks: list[tuple[float, str]] = []
    top = 0.0
    for g, group in enumerate(panel.groups, start=place):
        if group.title:
            _write_title(axes, top + HEAD / 2.0, group.title, room.left)
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
    if panel is first:
        for head in chart.heads:
            _write_above(axes, head)
        heads = Row(label="", marks=(), beside=chart.beside)
        _write_beside(axes, -LINE / 2.0, heads, room.beside, chart.flush)


def _set_scale(axes: Axes, scale: Scale) -> None:
    """Set ends, kind, numbers and name of an axis."""
    options = {"linthresh": 1.0} if scale.kind == "symlog" else {}
    if scale.kind != "linear":  # as it is
        axes.set_xscale(scale.kind, **options)
    axes.set_xlim(scale.low, scale.high)
    if scale.ticks is not None:
        axes.set_xticks([x for x, _ in scale.ticks], [text for _, text in scale.ticks])
    else:
        width = _points(axes, axes.bbox.width)
        if scale.kind == "linear":
            number = max(2, int(width / TICK_ROOM))
            axes.locator_params(axis="x", nbins=number, steps=[1, 2, 5, 10])
        elif scale.kind == "log":
            log_ticks(axes.xaxis, max(2, int(width / DECADE_ROOM)))
        axes.xaxis.set_major_formatter("{x:g}")
        low, high = sorted((scale.low, scale.high))
        axes.set_xticks([x for x in axes.get_xticks() if low <= x <= high])
    axes.minorticks_off()
    if scale.label:
        axes.set_xlabel(scale.label, fontsize=SMALL, color=MUTED)
    else:
        without_name(axes.xaxis)


def _points(axes: Axes, pixels: float) -> float:
    """Return a length on the figure [pt]."""
    return 72.0 * pixels / axes.figure.dpi


def _draw_mark(axes: Axes, middle: float, mark: Mark, gid: str | None) -> None:
    """Draw one mark on the line of its row."""
    from matplotlib.lines import Line2D

    y = middle + mark.lift
    # The ends of the axes are set: artists are put on them, which `plot` and `barh`
    # measure first, for axes that fit themselves to what is drawn.
    if isinstance(mark, Stroke):
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
    elif isinstance(mark, Dot):
        axes.add_artist(
            Line2D(
                [mark.at],
                [y],
                marker=mark.shape,
                markersize=mark.size,
                color=mark.fill,
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


def _draw_bar(axes: Axes, y: float, bar: Bar, gid: str | None) -> None:
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
            linewidth=bar.edge_width,
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
    if bar.text and fits(bar.text, _points(axes, end - start)):
        write(
            axes,
            bar.text,
            ((low + high) / 2.0, y),
            strong=bar.strong,
            colour=bar.text_colour,
            ha="center",
        )


def _write_title(axes: Axes, middle: float, title: str, left: float) -> None:
    """Write the title of a group, from the left edge of its side."""
    axes.annotate(
        title,
        (0.0, middle),
        xycoords=("axes fraction", "data"),
        xytext=(EDGE - left, 0.0),
        textcoords="offset points",
        fontsize=TEXT,
        fontweight="bold",
        color=INK,
        va="center",
        bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 1.0},
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
    axes: Axes, middle: float, row: Row, columns: list[float], flush: str
) -> None:
    """Write the texts of a row on its right, each in its column."""
    start = 0.0
    for text, width in zip(row.beside, columns, strict=False):
        write(
            axes,
            shorten(text, (width - 7.0) / (1.12 if row.strong else 1.0)),
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
