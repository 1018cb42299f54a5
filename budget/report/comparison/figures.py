"""Figures of a comparison: where devices use their limits, and at what cost."""

from __future__ import annotations

from collections import Counter
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

from budget.known import AT_LEAST
from budget.report.comparison.tables import merit_points
from budget.report.figures.rows import (
    Bar,
    Chart,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
)
from budget.report.figures.style import (
    BLUE,
    INCH,
    INK,
    MUTED,
    PAPER,
    as_picture,
    house_style,
    log_ticks,
    plane,
    text_width,
    write,
)
from budget.report.pages import line
from budget.report.tables import as_limited, largest_error, used_part

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from budget.report.blocks import Picture
    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Ranking
    from budget.report.comparison.tables import Row as Device
    from budget.results import JudgedOutput

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
said = partial(line, "figures_comparison")


def map_chart(table: Ranking, name: str, data: DataTable) -> Chart:
    """Show devices by outputs, best first: one hue, a step and a frame at the limit.

    Of those that can be judged; outputs that are alike for all of them, as equal axes
    are, are one column.
    """
    rows = table.measured[:SHOWN]
    columns = _columns(rows)
    cells = Panel(
        scale=Scale(low=0.0, high=float(len(columns)), ticks=()),
        groups=(Group(rows=tuple(_map_row(row, columns) for row in rows)),),
    )
    width = 1.1 * DARKEST_AT / STEPS
    hues = tuple(
        Bar(
            start=step * width,
            end=(step + 1) * width,
            colour=BLUE,
            edge="none",
            opacity=_opacity((step + 0.5) * width),
        )
        for step in range(STEPS)
    )
    ticks = ((0.0, "0"), (1.0, said("limit")), (DARKEST_AT, said("beyond")))
    scale = Panel(
        scale=Scale(low=0.0, high=STEPS * width, ticks=ticks),
        groups=(Group(rows=(Row(label="", marks=hues),)),),
    )
    return Chart(
        name=name,
        title=map_title(table),
        sides=(Side(panels=(cells, scale)),),
        lead=said("map_lead"),
        caption=said("map_caption", table=table, shown=SHOWN),
        heads=tuple(_output_heads(rows[0], columns)),
        pitch=15.0,
        data=data,
        data_on_paper=False,
        width=BROAD,
    )


def _columns(rows: Sequence[Device]) -> list[list[int]]:
    """Gather the outputs of a quantity that every device uses alike, in order."""

    def looks(place: int) -> tuple[object, ...]:
        name = rows[0].of.outputs[place].output.name
        texts = (used_part(row.of.outputs[place]).text for row in rows)
        return (name.quantity, name.time, *texts)

    places = range(len(rows[0].of.outputs))
    return [list(own) for _, own in groupby(places, looks)]


def map_title(table: Ranking) -> str:
    """State the finding: which output is the tightest for most devices."""
    rows = [row for row in table.measured if not row.of.utilisation.is_bound]
    tightest = Counter(row.of.worst_output.quantity for row in rows)
    return said("map_title", table=table, rows=rows, most=tightest.most_common(1))


def _map_row(row: Device, columns: Sequence[Sequence[int]]) -> Row:
    """Return the cells of one device; each has its tooltip."""
    return Row(
        label=mark_name(row, LONG_NAME),
        marks=tuple(
            Bar(
                start=x + 0.02,
                end=x + 0.98,
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
                    error=largest_error(as_limited(output)).text,
                    unit=as_limited(output).output.unit,
                    printed_limit=output.printed_limit,
                    used=used_part(output).text,
                ),
            )
            for x, places in enumerate(columns)
            for output in [row.of.outputs[places[0]]]
        ),
        said=said("map_said", row=row),
    )


def _output_heads(row: Device, columns: Sequence[Sequence[int]]) -> Iterator[Head]:
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


def front_picture(table: Ranking, merit: str, name: str, data: DataTable) -> Picture:
    """Return the part of the limit against a cost; each point has its tooltip."""
    points, title = merit_points(table, merit), pareto_title(table, merit)
    return as_picture(
        pareto_scatter(table, merit),
        name=name,
        title=title,
        alt=said("front_alt", title=title, merit=merit, points=points),
        tips={
            f"tip-{place}": said("front_tip", row=row, amount=amount)
            for place, (row, amount) in enumerate(points)
        },
        caption=said("front_caption", table=table, merit=merit),
        data=data,
        is_wide=True,
        data_on_paper=False,
    )


def no_front(table: Ranking, merit: str) -> str:
    """Say why there is no front; '' where there is one, with a name at every dot."""
    points = merit_points(table, merit)
    why = said("no_front", points=points, merit=merit)
    if why or _drawn_front(table, merit) is not None:
        return why
    return said("no_room", points=points)


def no_fronts(why: Mapping[str, str]) -> str:
    """Say in a sentence which fronts are not drawn, and why; '' where all are."""
    return said("no_fronts", why=why)


@house_style()
def pareto_scatter(table: Ranking, merit: str) -> Figure:
    """Draw the part of the limit against a cost; the front is joined, the rest grey.

    Raises
    ------
    ValueError
        There is no room for the name of every dot: `no_front` says so.
    """
    figure = _drawn_front(table, merit)
    if figure is None:
        raise ValueError(f"no room for the names of all devices by {merit}")
    return figure


@house_style()
def _drawn_front(table: Ranking, merit: str) -> Figure | None:
    """Draw a front; None where a name would lie on another one, or on a dot."""
    points = merit_points(table, merit)
    figure, axes = plane(
        pareto_title(table, merit),
        said("cost_axis", merit=merit, unit=points[0][1].unit),
        said("error_axis"),
        240.0,
    )
    figure.set_size_inches(BROAD / INCH, 240.0 / INCH)
    axes.set_xscale("log")
    axes.set_yscale("log")
    costs = [amount.value for _, amount in points]
    parts = [max(row.of.utilisation, LEAST) for row, _ in points]
    axes.set_xlim(min(costs) / 1.6, max(costs) * 2.2)
    axes.set_ylim(100.0 * min(0.5, *parts) / 1.5, 100.0 * max(2.0, *parts) * 1.5)
    log_ticks(axes.xaxis, MOST_TICKS)
    log_ticks(axes.yaxis, MOST_TICKS)
    axes.minorticks_off()
    axes.axhline(100.0, color=INK, linewidth=1.0, zorder=1)
    on_front = [
        (amount.value, 100.0 * max(row.of.utilisation, LEAST))
        for row, amount in points
        if merit in row.of.on_front
    ]
    if on_front:
        axes.plot(*zip(*on_front, strict=True), color=BLUE, linewidth=1.0, zorder=2)
    for place, (row, amount) in enumerate(points):
        point = _draw_point(axes, row, amount.value, is_best=merit in row.of.on_front)
        point.set_gid(f"tip-{place}")
    names: dict[tuple[float, float], list[str]] = {}
    for row, amount in points:  # devices in one place share a name
        place_of = (amount.value, 100.0 * max(row.of.utilisation, LEAST))
        names.setdefault(place_of, []).append(mark_name(row, NAME))
    return figure if _write_names(axes, names) else None


def _write_names(
    axes: Axes, names: Mapping[tuple[float, float], Sequence[str]]
) -> bool:
    """Write a name beside every dot; whether each has room of its own."""
    if len(names) > MOST_NAMES:
        return False
    scale = INCH / axes.figure.dpi
    dots = {at: scale * axes.transData.transform(at) for at in names}
    low, high = scale * axes.bbox.y0, scale * axes.bbox.y1
    taken = [(x - DOT, y - DOT, x + DOT, y + DOT) for x, y in dots.values()]
    for at, own in names.items():
        name = said("front_label", names=own)
        width = text_width(name)
        x, y = dots[at]
        for dx, dy, side in (
            (6.0, 0.0, "left"),
            (-6.0, 0.0, "right"),
            (0.0, 9.0, "center"),
            (0.0, -9.0, "center"),
        ):
            left = x + dx - width * {"left": 0.0, "right": 1.0, "center": 0.5}[side]
            box = (left, y + dy - HIGH / 2, left + width, y + dy + HIGH / 2)
            inside = scale * axes.bbox.x0 < left and left + width < BROAD
            if inside and low < box[1] and box[3] < high and not _meets(box, taken):
                break
        else:
            return False
        taken.append(box)
        write(axes, name, at, (dx, dy), ha=side)
    return True


def _meets(
    box: tuple[float, float, float, float],
    others: Iterable[tuple[float, float, float, float]],
) -> bool:
    """Whether a box lies on one of others; left, low, right, high."""
    return any(
        box[0] < right and left < box[2] and box[1] < high and low < box[3]
        for left, low, right, high in others
    )


def pareto_title(table: Ranking, merit: str) -> str:
    """State the finding: which devices nobody beats in both."""
    points = merit_points(table, merit)
    best = [row.device for row, _ in points if merit in row.of.on_front]
    names = list(dict.fromkeys(best))
    return said(
        "front_title", subject=table.subject, merit=merit, names=names, most=NAMED
    )


def _draw_point(axes: Axes, row: Device, cost: float, *, is_best: bool) -> Line2D:
    """Draw one device; those on the front have their names beside them."""
    y = 100.0 * max(row.of.utilisation, LEAST)
    sure = row.of.verdict in SURE
    colour = BLUE if is_best else MUTED
    if row.of.utilisation.is_bound:  # there, or above
        top = axes.get_ylim()[1]
        axes.plot([cost, cost], [y, top], color=MUTED, linewidth=0.9, zorder=1)
    (point,) = axes.plot(
        [cost],
        [y],
        marker="o",
        markersize=5.0,
        color=colour if sure else PAPER,
        markeredgecolor=colour,
        linestyle="none",
        zorder=4 if is_best else 3,
    )
    return point


def fit_name(name: str, length: int) -> str:
    """Return a name that fits beside a figure, its middle left out where it is long.

    Variants of a device differ in the end of their names.
    """
    if len(name) <= length:
        return name
    end = (length - len(DOTS)) // 2
    return f"{name[: length - len(DOTS) - end].rstrip()}{DOTS}{name[-end:].lstrip()}"


def mark_name(row: Device, length: int) -> str:
    """Return a device's name that fits, marked where specifications are missing."""
    if not row.missing:
        return fit_name(row.device, length)
    return fit_name(row.device, length - len(MARK)) + MARK
