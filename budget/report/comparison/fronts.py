"""Fronts, which answer what a better device costs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.comparison.margins import LEAST, SURE
from budget.report.comparison.naming import explain_mark, mark_name, plain_ticks
from budget.report.figures import (
    BLUE,
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    canvas,
    house_style,
)
from budget.report.figures.picture import as_picture, capital
from budget.report.tables import print_given
from budget.studies.figures_of_merit import MERITS, Amount, read_amount

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    from budget.report.blocks import Picture
    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Row, Table

NAMED = 3  # devices in a title
NAME = 22  # characters of a name that fit beside a point
LEAST_COSTS = 2  # different ones, below which a scatter shows nothing


def front_picture(table: Table, merit: str, name: str, data: DataTable) -> Picture:
    """Return the scatter as a block; each point has its tooltip."""
    return as_picture(
        pareto_scatter(table, merit),
        name=name,
        title=pareto_title(table, merit),
        alt=pareto_alt(table, merit),
        tips=pareto_tips(table, merit),
        caption=(
            "Lower left is better. Joined: no other device is better in one and as "
            "good in the other. Hollow: undecided or undecidable; a line up from a "
            "point: what lacks an expected line is there or above, up to at worst, and "
            f"beats nobody. Only devices whose {merit} is known.{explain_mark(table)}"
        ),
        data=data,
    )


def merit_points(table: Table, merit: str) -> list[tuple[Row, Amount]]:
    """Return the devices whose price, mass or power can be compared, cheapest first."""
    found = [
        (row, amount)
        for row in table.rows
        if (amount := read_amount(merit, getattr(row.of, merit))) is not None
    ]
    if not found:
        return []
    # As the front does: amounts in other units than the first one cannot be compared.
    unit = found[0][1].unit
    same = [pair for pair in found if pair[1].unit == unit]
    return sorted(same, key=lambda pair: (pair[1].value, pair[0].of.utilisation))


def no_front(table: Table, merit: str) -> str:
    """Say why a front would show nothing; '' where it shows something."""
    points = merit_points(table, merit)
    if not points:
        return "no device gives one that can be compared"
    if len(points) == 1:
        return f"only {points[0][0].device} gives one that can be compared"
    if len({amount.value for _, amount in points}) >= LEAST_COSTS:
        return ""
    amount = points[0][1]
    return (
        f"the {len(points)} devices that give one have the same, "
        f"{print_given(amount.value)} {amount.unit}"
    )


def no_fronts(table: Table) -> str:
    """Say in a sentence which fronts are not drawn, and why; '' where all are."""
    reasons = {merit: no_front(table, merit) for merit in MERITS}
    missing = [merit for merit in MERITS if reasons[merit]]
    if not missing:
        return ""
    if not any(merit_points(table, merit) for merit in MERITS):
        return (
            "No device gives a price, a mass or a power that can be compared: there is "
            "no front to draw."
        )
    said = "; ".join(f"{merit}: {reasons[merit]}" for merit in missing)
    return f"No front is drawn where it would show nothing. {capital(said)}."


@house_style()
def pareto_scatter(table: Table, merit: str) -> Figure:
    """Draw the part of the limit against a cost; the front is joined, the rest grey."""
    points = merit_points(table, merit)
    left, right, top, below = 40.0, 12.0, 12.0, 34.0
    figure, axes = canvas(220.0, left=left, right=right, top=top, below=below)
    figure.set_label(pareto_title(table, merit))
    axes.set_xscale("log")
    axes.set_yscale("log")
    costs = [amount.value for _, amount in points]
    parts = [max(row.of.utilisation, LEAST) for row, _ in points]
    axes.set_xlim(min(costs) / 1.6, max(costs) * 2.2)
    worst = [row.of.at_worst or 0.0 for row, _ in points if row.of.lower_bound]
    axes.set_ylim(
        100.0 * min(0.5, *parts) / 1.5, 100.0 * max(2.0, *parts, *worst) * 1.5
    )
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.minorticks_off()
    axes.tick_params(axis="y", labelsize=SMALL, labelcolor=MUTED)
    axes.grid(color=GRID, linewidth=0.6)
    axes.set_xlabel(f"{merit} [{points[0][1].unit}]", fontsize=SMALL, color=MUTED)
    axes.set_ylabel("largest error [% of the limit]", fontsize=SMALL, color=MUTED)
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
        point.set_gid(_gid(place))
    names: dict[tuple[float, float], list[str]] = {}
    for row, amount in points:
        if merit in row.of.on_front:  # devices in one place share a label
            names.setdefault((amount.value, row.of.utilisation), []).append(
                mark_name(row, NAME)
            )
    for (cost, part), own in names.items():
        axes.annotate(
            own[0] if len(own) == 1 else f"{own[0]} and {len(own) - 1} more",
            (cost, 100.0 * max(part, LEAST)),
            xytext=(5.0, 3.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=INK,
        )
    return figure


def pareto_title(table: Table, merit: str) -> str:
    """State the finding: which devices nobody beats in both."""
    best = [
        row.device for row, _ in merit_points(table, merit) if merit in row.of.on_front
    ]
    names = list(dict.fromkeys(best))
    if not names:
        return (
            f"{capital(table.sensor)}: nobody can say which device is best in {merit} "
            "and error, all lack lines"
        )
    more = len(names) - NAMED
    named = ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
    verb = "is" if len(names) == 1 else "are"
    return (
        f"{capital(table.sensor)}: {named} {verb} not beaten in {merit} and error at "
        "once"
    )


def pareto_alt(table: Table, merit: str) -> str:
    """Say in words with numbers what the scatter shows."""
    points = "; ".join(
        f"{row.device} {print_given(amount.value)} {amount.unit}, {row.utilisation} %"
        for row, amount in merit_points(table, merit)
    )
    title = pareto_title(table, merit)
    return f"{title}. {merit.capitalize()} and part of the limit: {points}."


def pareto_tips(table: Table, merit: str) -> dict[str, str]:
    """Return a tooltip for each point, by its gid."""
    return {
        _gid(place): (
            f"{row.device}: {print_given(amount.value)} {amount.unit}, "
            f"{row.utilisation} % of the limit, {row.verdict}"
        )
        for place, (row, amount) in enumerate(merit_points(table, merit))
    }


def _gid(place: int) -> str:
    """Name a point."""
    return f"tip-{place}"


def _draw_point(axes: Axes, row: Row, cost: float, *, is_best: bool) -> Line2D:
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
