"""Figures of a comparison: how far devices are from the limit, where, at what cost."""

from __future__ import annotations

from collections import Counter
from functools import partial
from itertools import groupby
from typing import TYPE_CHECKING

from budget.report.comparison.tables import merit_points
from budget.report.figures.rows import (
    Bar,
    Chart,
    Dot,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import (
    BLUE,
    INCH,
    INK,
    MUTED,
    PAPER,
    WIDE,
    WIDTH,
    as_picture,
    fits,
    house_style,
    log_ticks,
    plane,
    write,
)
from budget.report.pages import line
from budget.report.tables import AT_LEAST, as_limited, largest_error, used_part
from budget.studies.figures_of_merit import MERITS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Ranking
    from budget.report.comparison.tables import Row as Device
    from budget.report.figures.rows import Mark
    from budget.results import OutputAssessment

SHOWN = 40  # devices in a figure, the best ones; all are in the tables
DOTS = "..."
MARK = " *"  # behind the name of a device that lacks a line
NAME, LONG_NAME = 22, 32  # characters of a name that fit beside a narrow, a wide figure
LEAST = 1e-4  # utilisation where a bar ends at the latest [1]
SURE = ("meets", "fails")  # verdicts whose bars and points are full
# Opacities of the one hue; up to 0.8 ink can be read on it (4.5:1) in light and dark.
PALEST, UP_TO_LIMIT, BEYOND, DARKEST = 0.06, 0.40, 0.60, 0.80
DARKEST_AT = 2.0  # utilisation with the darkest hue [1]
STEPS = 44  # of the hue on its scale, which goes on for a tenth beyond the darkest
ROOM = 5  # characters that a cell holds
MOST_PER_CENT = 999.5  # beyond, a cell says >999
BOTH = 2  # devices that are all there are
NAMED = 3  # devices in a title
said = partial(line, "figures_comparison")


def margin_chart(table: Ranking, name: str) -> Chart:
    """Show how far each device is from its limit: bars that start at the limit.

    The ranking has the data.
    """
    rows = table.rows[:SHOWN]
    parts = [max(row.of.utilisation, LEAST) for row in rows]
    worst = [row.of.at_worst or 0.0 for row in rows if row.of.lower_bound]
    ranges = [row.of.doubt.utilisation_90 for row in rows if row.of.doubt]
    reached = [max(end, LEAST) for ends in ranges for end in ends]
    scale = Scale(
        low=100.0 * min(0.5, *parts, *reached) / 1.3,
        high=100.0 * max(2.0, *parts, *worst, *reached) * 1.3,
        kind="log",
        lines=((100.0, said("limit")),),
        label=said("error_axis"),
    )
    group = Group(rows=tuple(_margin_row(row, scale.high) for row in rows))
    return Chart(
        name=name,
        title=margin_title(table),
        sides=(Side(panels=(Panel(scale=scale, groups=(group,)),)),),
        lead=said("margin_lead"),
        caption=said("margin_caption", table=table, shown=SHOWN),
        flush="left",
        pitch=15.0,
    )


def margin_title(table: Ranking) -> str:
    """State the finding: how many meet, and the best of those that can be decided."""
    return said("margin_title", table=table)


def _margin_row(row: Device, end: float) -> Row:
    """Return a bar from the limit; its fill and a word say the verdict."""
    x, ink = 100.0 * max(row.of.utilisation, LEAST), BLUE
    if row.of.utilisation > 1.0:
        ink = INK
    start, height = 100.0, 9.3
    marks: list[Mark] = []
    if row.of.verdict == "undecidable":  # not a margin: somewhere from here on
        worst = row.of.at_worst
        start = end if worst is None else max(100.0 * worst, x)
        height = 3.9
        shape = ">" if worst is None else "|"
        marks.append(Dot(at=start, shape=shape, fill=MUTED, edge=MUTED))
    marks.append(
        Bar(
            start=start,
            end=x,
            colour=ink if row.of.verdict in SURE else "none",
            edge=ink,
            edge_width=0.9,
            height=height,
            tip=said("margin_tip", row=row),
        )
    )
    low, high = (100.0 * max(end, LEAST) for end in row.of.range)
    if high > low:
        marks.append(Stroke(start=low, end=high, width=2.2))
    return Row(
        label=mark_name(row, NAME),
        marks=tuple(marks),
        beside=(f"{row.utilisation} {row.verdict}",),
        strong=row.of.verdict == "meets",
        said=said("margin_said", row=row),
    )


def map_chart(table: Ranking, name: str, data: DataTable) -> Chart:
    """Show devices by outputs, best first: one hue, a step and a frame at the limit."""
    rows = table.rows[:SHOWN]
    outputs = rows[0].of.outputs
    cells = Panel(
        scale=Scale(low=0.0, high=float(len(outputs)), ticks=()),
        groups=(Group(rows=tuple(map(_map_row, rows))),),
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
        heads=tuple(_output_heads([output.output.name for output in outputs])),
        pitch=16.0,
        data=data,
        width=WIDE,
    )


def map_title(table: Ranking) -> str:
    """State the finding: which output is the tightest for most devices."""
    rows = [row for row in table.rows if not row.of.lower_bound]
    tightest = Counter(row.of.worst_output.quantity for row in rows)
    return said("map_title", table=table, rows=rows, most=tightest.most_common(1))


def _map_row(row: Device) -> Row:
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
                height=15.0,
                is_framed=not output.is_within,
                text=_cell(output),
                strong=not output.is_within,
                tip=said(
                    "map_tip",
                    device=row.device,
                    name=output.output.name,
                    error=largest_error(as_limited(output)).text,
                    unit=as_limited(output).output.unit,
                    printed_limit=output.printed_limit,
                    used=used_part(output).text,
                ),
            )
            for x, output in enumerate(row.of.outputs)
        ),
        said=said("map_said", row=row),
    )


def _output_heads(names: Sequence[Name]) -> Iterator[Head]:
    """Yield axes above the columns and quantities above those; of a mission times."""
    is_mission = any(name.time is not None for name in names)
    for level, depth in enumerate((3, 2, 1) if is_mission else (2, 1)):
        for _, group in groupby(
            enumerate(names),
            key=lambda one: (one[1].quantity, one[1].axis, one[1].time)[:depth],
        ):
            own = list(group)
            is_short = len(own) <= BOTH and not is_mission
            yield Head(
                at=(own[0][0] + own[-1][0] + 1) / 2.0,
                text=said("head", name=own[0][1], depth=depth, is_short=is_short),
                level=level,
                colour=INK if level else MUTED,
            )


def _opacity(part: float) -> float:
    """Return the opacity of the hue: it steps up at the limit."""
    if part <= 1.0:
        return PALEST + (UP_TO_LIMIT - PALEST) * part
    share = min((part - 1.0) / (DARKEST_AT - 1.0), 1.0)
    return BEYOND + (DARKEST - BEYOND) * share


def _cell(output: OutputAssessment) -> str:
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
        caption=said("front_caption", table=table, merit=merit, shown=SHOWN),
        data=data,
    )


def no_front(table: Ranking, merit: str) -> str:
    """Say why a front would show nothing; '' where it shows something."""
    return said("no_front", points=merit_points(table, merit))


def no_fronts(table: Ranking) -> str:
    """Say in a sentence which fronts are not drawn, and why; '' where all are."""
    points = {merit: merit_points(table, merit) for merit in MERITS}
    return said("no_fronts", points=points)


@house_style()
def pareto_scatter(table: Ranking, merit: str) -> Figure:
    """Draw the part of the limit against a cost; the front is joined, the rest grey."""
    points = merit_points(table, merit)
    figure, axes = plane(
        pareto_title(table, merit),
        said("cost_axis", merit=merit, unit=points[0][1].unit),
        said("error_axis"),
        220.0,
    )
    axes.set_xscale("log")
    axes.set_yscale("log")
    costs = [amount.value for _, amount in points]
    parts = [max(row.of.utilisation, LEAST) for row, _ in points]
    axes.set_xlim(min(costs) / 1.6, max(costs) * 2.2)
    worst = [row.of.at_worst or 0.0 for row, _ in points if row.of.lower_bound]
    axes.set_ylim(
        100.0 * min(0.5, *parts) / 1.5, 100.0 * max(2.0, *parts, *worst) * 1.5
    )
    log_ticks(axes.xaxis)
    log_ticks(axes.yaxis)
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
    for row, amount in points:
        if merit in row.of.on_front:  # devices in one place share a label
            names.setdefault((amount.value, row.of.utilisation), []).append(
                mark_name(row, NAME)
            )
    for (cost, part), own in names.items():
        name = said("front_label", names=own)
        room = WIDTH - INCH / figure.dpi * axes.transData.transform((cost, 100.0))[0]
        side = "left" if fits(name, room) else "right"  # it stays in the figure
        shift = (-6.0 if side == "right" else 5.0, 3.0)
        write(
            axes, name, (cost, 100.0 * max(part, LEAST)), shift, ha=side, va="baseline"
        )
    return figure


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
    if row.of.lower_bound:
        worst = row.of.at_worst
        top = axes.get_ylim()[1] if worst is None else max(100.0 * worst, y)
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
    """Return a name that fits beside a figure, its end left out where it is long."""
    return name if len(name) <= length else f"{name[: length - len(DOTS)]}{DOTS}"


def mark_name(row: Device, length: int) -> str:
    """Return a device's name that fits, marked where expected lines are missing."""
    if not row.missing:
        return fit_name(row.device, length)
    return fit_name(row.device, length - len(MARK)) + MARK
