"""Figures of a comparison: where devices use their limits, and at what cost."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

from budget.known import AT_LEAST
from budget.report.comparison.tables import merit_points
from budget.report.figures.curves import free_place
from budget.report.figures.rows import (
    CELL_EDGE,
    Bar,
    Chart,
    ChartGroup,
    ChartPanel,
    ChartRow,
    Head,
    rows_of,
)
from budget.report.figures.style import (
    BLUE,
    INCH,
    INK,
    MUTED,
    PAPER,
    Scale,
    add_plane,
    blank,
    house_style,
    text_width,
    write,
)
from budget.report.figures.tabled import Plot, entries
from budget.report.pages import figure, line
from budget.report.tables import as_limited, used_part

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from types import SimpleNamespace

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Ranking
    from budget.report.figures.rows import ChartMark
    from budget.results import JudgedOutput
    from budget.studies.figures_of_merit import Amount

SHOWN = 30  # devices of a map, the best ones that can be judged; all are in the tables
DOTS = "..."
MARK = " *"  # behind the name of a device that lacks a specification
NAME, LONG_NAME = 26, 32  # characters of a name in a front, beside a map
BROAD = 500.0  # of a figure that paper shows as large as it is [pt]
LEAST = 1e-4  # utilisation where an axis ends at the latest [1]
SURE = ("meets", "fails")  # verdicts whose points are full
# Opacities of the one hue; up to 0.8 ink can be read on it (4.5:1) in light and dark.
PALEST, UP_TO_LIMIT, BEYOND, DARKEST = 0.06, 0.40, 0.60, 0.80
DARKEST_AT = 2.0  # utilisation with the darkest hue [1]
STEPS = 44  # of the hue on its scale, which goes on for a tenth beyond the darkest
ROOM = 5  # characters that a cell holds
MOST_PER_CENT = 999.5  # beyond, a cell says >999
NARROW = 0.16  # part of a map where the name of a quantity is written short [1]
NAMED = 3  # devices in a title
MOST_NAMES = 24  # dots of a front: names of more have no room
MOST_TICKS = 8  # of an axis of a front
DOT, HIGH = 4.0, 9.5  # half of the room of a dot; height of its name [pt]
PAGE = "figures_comparison"
said = partial(line, PAGE)


def map_chart(table: Ranking, name: str, data: DataTable | None) -> Chart:
    """Show devices by outputs, best first: one hue, a step and a frame at the limit.

    Of those that can be judged; outputs that are alike for all of them, as equal axes
    are, are one column.
    """
    rows = table.measured[:SHOWN]
    columns = _columns(rows)
    known = [row for row in table.measured if not row.of.utilisation.is_bound]
    tightest = Counter(row.of.worst_output.quantity for row in known)
    told, own = figure(
        PAGE,
        "map",
        table=table,
        rows=rows,
        known=known,
        most=tightest.most_common(1),
    )
    (drawn,) = rows_of(own, partial(_map_cells, columns=columns), rows)
    marked = [mark_name(row, LONG_NAME) for row in rows]
    named = map(lambda one, label: replace(one, label=label), drawn.rows, marked)
    width = 1.1 * DARKEST_AT / STEPS
    hues = [
        Bar(
            start=step * width,
            end=(step + 1) * width,
            colour=BLUE,
            edge="none",
            opacity=_opacity((step + 0.5) * width),
        )
        for step in range(STEPS)
    ]
    ticks = ((0.0, "0"), (1.0, told.limit), (DARKEST_AT, told.beyond))
    return Chart(
        name=name,
        title=told.title,
        panels=(
            ChartPanel(
                scale=Scale(low=0.0, high=float(len(columns)), ticks=()),
                groups=(replace(drawn, rows=tuple(named)),),
            ),
            ChartPanel(
                scale=Scale(low=0.0, high=STEPS * width, ticks=ticks),
                groups=(ChartGroup(rows=(ChartRow(label="", marks=tuple(hues)),)),),
            ),
        ),
        table=own,
        has_data=False,
        numbers=data,
        caption=told.caption,
        heads=tuple(_output_heads(rows[0], columns)),
        pitch=15.0,
        width=BROAD,
    )


def _map_cells(
    _: object, row: SimpleNamespace, columns: Sequence[Sequence[int]]
) -> Iterator[ChartMark]:
    """Yield the cells of one device; each has its tooltip."""
    for x, places in enumerate(columns):
        output = row.of.outputs[places[0]]
        yield Bar(
            start=x + CELL_EDGE,
            end=x + 1.0 - CELL_EDGE,
            colour=BLUE,
            edge="none",
            opacity=PALEST if output.is_unknown else _opacity(output.utilisation),
            height=14.0,
            is_framed=not output.is_within,
            text=_cell(output),
            strong=not output.is_within,
            tip=said(
                "map_tip",
                device=row.device,
                names=[row.of.outputs[k].output.name for k in places],
                limited=as_limited(output),
                printed_limit=output.printed_limit,
            ),
        )


def _columns(rows: Sequence[SimpleNamespace]) -> list[list[int]]:
    """Gather the outputs of a quantity that every device uses alike, in order."""

    def looks(place: int) -> tuple[object, ...]:
        name = rows[0].of.outputs[place].output.name
        texts = (used_part(row.of.outputs[place]).text for row in rows)
        return (name.quantity, name.time, *texts)

    places = range(len(rows[0].of.outputs))
    return [list(own) for _, own in groupby(places, looks)]


def _output_heads(
    row: SimpleNamespace, columns: Sequence[Sequence[int]]
) -> Iterator[Head]:
    """Yield axes above the columns and quantities above those; of a mission times."""
    names = [[row.of.outputs[k].output.name for k in places] for places in columns]
    is_mission = any(name.time is not None for own in names for name in own)
    for level, depth in enumerate((3, 2, 1) if is_mission else (2, 1)):
        for _, group in groupby(
            enumerate(names),
            key=lambda one: (
                [(name.quantity, name.axis, name.time)[:depth] for name in one[1]]
                if depth > 1
                else one[1][0].quantity
            ),
        ):
            own = list(group)
            is_short = len(own) / len(columns) < NARROW and not is_mission
            yield Head(
                at=(own[0][0] + own[-1][0] + 1) / 2.0,
                text=said("head", names=own[0][1], depth=depth, is_short=is_short),
                level=level,
                colour=INK if level else MUTED,
            )


def _opacity(part: float) -> float:
    """Return the opacity of the hue: it steps up at the limit."""
    if part <= 1.0:
        return PALEST + (UP_TO_LIMIT - PALEST) * part
    share = min((part - 1.0) / (DARKEST_AT - 1.0), 1.0)
    return BEYOND + (DARKEST - BEYOND) * share


def _cell(output: JudgedOutput) -> str:
    """Print a part of a limit as everywhere, as far as a cell has room for it."""
    if 100.0 * output.utilisation >= MOST_PER_CENT:
        return ">999"
    text = used_part(output).text.removesuffix(" %").replace(" ", "")
    return text if len(text) <= ROOM or text[:1] == AT_LEAST else "<0.1"


def front_plot(table: Ranking, merit: str) -> Plot | str:
    """Show the part of the limit against a cost; else say why there is no figure.

    The front is joined, the rest grey. There is none where it would show nothing, or a
    name would have no room beside its dot.
    """
    points = merit_points(table, merit)
    if why := said("no_front", points=points, merit=merit):
        return why
    told, own = figure(
        PAGE,
        "front",
        table=table,
        merit=merit,
        points=points,
        names=list(
            dict.fromkeys(row.device for row, _ in points if merit in row.of.on_front)
        ),
        most=NAMED,
    )
    found = _drawn_front(points, merit, told)
    if found is None:
        return said("no_room", points=points)
    ((_, rows),) = entries(own)
    return Plot(
        name=f"front-{merit}-{table.name}",
        said=told,
        table=own,
        draw=lambda: found,
        tips={f"tip-{place}": one.tip for place, one in enumerate(rows)},
        is_wide=True,
    )


def no_fronts(why: Mapping[str, str]) -> str:
    """Say in a sentence which fronts are not drawn, and why; '' where all are."""
    return said("no_fronts", why=why)


@house_style()
def _drawn_front(
    points: Sequence[tuple[SimpleNamespace, Amount]], merit: str, told: SimpleNamespace
) -> Figure | None:
    """Draw a front; None where a name would lie on another one, or on a dot."""
    places = [
        (amount.value, 100.0 * max(row.of.utilisation, LEAST)) for row, amount in points
    ]
    costs, parts = zip(*places, strict=True)
    log = partial(Scale, kind="log", most=MOST_TICKS)
    x = log(low=min(costs) / 1.6, high=max(costs) * 2.2, label=told.cost)
    low, high = min(50.0, *parts) / 1.5, max(200.0, *parts) * 1.5
    y = log(low=low, high=high, label=told.error)
    drawing = blank(240.0, width=BROAD)
    axes = add_plane(drawing, x, y, left=88.0, right=100.0, height=194.0)
    axes.axhline(100.0, color=INK, linewidth=1.0, zorder=1)
    best = [merit in row.of.on_front for row, _ in points]
    if any(best):
        front = [at for at, is_best in zip(places, best, strict=True) if is_best]
        axes.plot(*zip(*front, strict=True), color=BLUE, linewidth=1.0, zorder=2)
    names: dict[tuple[float, float], list[str]] = {}
    for place, ((row, _), at, is_best) in enumerate(
        zip(points, places, best, strict=True)
    ):
        if row.of.utilisation.is_bound:  # there, or above
            axes.plot([at[0]] * 2, [at[1], high], color=MUTED, linewidth=0.9, zorder=1)
        colour = BLUE if is_best else MUTED
        axes.plot(
            *([one] for one in at),
            marker="o",
            markersize=5.0,
            color=colour if row.of.verdict in SURE else PAPER,
            markeredgecolor=colour,
            linestyle="none",
            zorder=4 if is_best else 3,
            gid=f"tip-{place}",
        )
        # Devices in one place share a name.
        names.setdefault(at, []).append(mark_name(row, NAME))
    return drawing if _write_names(axes, names) else None


def _write_names(
    axes: Axes, names: Mapping[tuple[float, float], Sequence[str]]
) -> bool:
    """Write a name beside every dot; whether each has room of its own."""
    scale = INCH / axes.figure.dpi
    dots = {at: scale * axes.transData.transform(at) for at in names}
    within = (scale * axes.bbox.x0, scale * axes.bbox.y0, BROAD, scale * axes.bbox.y1)
    taken = [(x - DOT, y - DOT, x + DOT, y + DOT) for x, y in dots.values()]
    for at, own in names.items() if len(names) <= MOST_NAMES else ():
        name = said("front_label", names=own)
        width, (x, y) = text_width(name), dots[at]
        boxes = [
            (
                x + dx - part * width,
                y + dy - HIGH / 2,
                x + dx + (1.0 - part) * width,
                y + dy + HIGH / 2,
            )
            for dx, dy, _, part in BESIDE_DOT
        ]
        place = free_place(boxes, within, taken)
        if place is None:
            return False
        dx, dy, side, _ = BESIDE_DOT[place]
        write(axes, name, at, (dx, dy), ha=side)
    return len(names) <= MOST_NAMES


# Where a name may stand at its dot [pt], its side there, and its part left of that.
BESIDE_DOT = (
    (6.0, 0.0, "left", 0.0),
    (-6.0, 0.0, "right", 1.0),
    (0.0, 9.0, "center", 0.5),
    (0.0, -9.0, "center", 0.5),
)


def fit_name(name: str, length: int) -> str:
    """Return a name that fits beside a figure, its middle left out where it is long.

    Variants of a device differ in the end of their names.
    """
    if len(name) <= length:
        return name
    end = (length - len(DOTS)) // 2
    return f"{name[: length - len(DOTS) - end].rstrip()}{DOTS}{name[-end:].lstrip()}"


def mark_name(row: SimpleNamespace, length: int) -> str:
    """Return a device's name that fits, marked where specifications are missing."""
    mark = MARK if row.missing else ""
    return fit_name(row.device, length - len(mark)) + mark
