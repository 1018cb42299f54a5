"""Margins, which answer how far each device is from its limit."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.comparison.naming import (
    SHOWN,
    explain_mark,
    mark_name,
    more_devices,
    plain_ticks,
)
from budget.report.figures import BLUE, GRID, INK, MUTED, SMALL, canvas, house_style
from budget.report.figures.picture import as_picture, capital
from budget.report.tables import print_utilisation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.report.comparison.tables import Row, Table

LEFT, RIGHT, TOP, BELOW = 118.0, 92.0, 18.0, 32.0  # for names, verdicts, axis [pt]
NAME = 22  # characters of a name that fit beside it
BAR_ROW = 15.0  # height [pt]
LEAST = 1e-4  # utilisation where a bar ends at the latest [1]
SURE = ("meets", "fails")  # verdicts whose bars are full


def margin_picture(table: Table, name: str) -> Picture:
    """Return the bars as a block; each has its tooltip, the ranking has the data."""
    return as_picture(
        margin_bars(table),
        name=name,
        title=margin_title(table),
        alt=margin_alt(table),
        tips=margin_tips(table),
        caption=(
            "Bars start at the limit: to the left is what is left of it. Hollow: "
            "undecided. A range: undecidable because an expected line is not given, "
            "from now to at worst; an arrow: at worst is not known."
            f"{explain_mark(table)}{more_devices(table)}"
        ),
    )


@house_style()
def margin_bars(table: Table) -> Figure:
    """Draw how far each device is from its limit: bars that start at the limit."""
    rows = table.rows[:SHOWN]
    height = TOP + BAR_ROW * len(rows) + BELOW
    figure, axes = canvas(height, left=LEFT, right=RIGHT, top=TOP, below=BELOW)
    figure.set_label(margin_title(table))
    axes.set_xscale("log")
    parts = [max(row.of.utilisation, LEAST) for row in rows]
    worst = [row.of.at_worst or 0.0 for row in rows if row.of.lower_bound]
    axes.set_xlim(
        100.0 * min(0.5, *parts) / 1.3, 100.0 * max(2.0, *parts, *worst) * 1.3
    )
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [mark_name(row, NAME) for row in rows])
    axes.tick_params(axis="y", labelsize=SMALL)
    plain_ticks(axes.xaxis)
    axes.minorticks_off()
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    axes.set_xlabel("largest error [% of the limit]", fontsize=SMALL, color=MUTED)
    for place, (row, part) in enumerate(zip(rows, parts, strict=True)):
        _draw_margin(axes, place, row, part)
    axes.axvline(100.0, color=INK, linewidth=1.0, zorder=3)
    _label_limit(axes, 100.0)
    return figure


def margin_title(table: Table) -> str:
    """State the finding: how many meet, and the best of those that can be decided."""
    sensor = capital(table.sensor)
    meets = [row for row in table.rows if row.of.verdict == "meets"]
    decided = [row for row in table.rows if row.of.verdict != "undecidable"]
    lacking = len(table.rows) - len(decided)
    number = f"{len(meets) or 'None'} of {len(table.rows)}"
    if not decided:
        return f"{sensor}: {number} can be decided, lines are missing"
    best = min(meets or decided, key=lambda row: row.of.utilisation)
    named = f"{best.device} at {print_utilisation(best.of.utilisation)} of the limit"
    lack = f"; {lacking} cannot be decided, lines are missing" if lacking else ""
    if meets:
        verb = "meet" if len(meets) > 1 else "meets"
        return f"{sensor}: {number} {verb}, the best is {named}{lack}"
    least = "the best that can be decided" if lacking else "the least used limit"
    return f"{sensor}: {number} meets; {least} is {named}{lack}"


def margin_alt(table: Table) -> str:
    """Say in words with numbers what the bars show."""
    bars = "; ".join(
        f"{row.device} {row.utilisation} %, {row.verdict}"
        + (f", at worst {row.at_worst}" if row.at_worst else "")
        for row in table.rows[:SHOWN]
    )
    return f"{margin_title(table)}. Largest error in per cent of the limit: {bars}."


def margin_tips(table: Table) -> dict[str, str]:
    """Return a tooltip for each bar, by its gid."""
    return {
        _gid(place): (
            f"{row.device}: {row.verdict}, {row.utilisation} % of the limit, "
            f"worst {row.worst_output}, limited by {row.limiting_source}"
            + (f"; at worst {row.at_worst}" if row.at_worst else "")
        )
        for place, row in enumerate(table.rows[:SHOWN])
    }


def _gid(place: int) -> str:
    """Name a bar."""
    return f"tip-{place}"


def _draw_margin(axes: Axes, place: int, row: Row, part: float) -> None:
    """Draw one bar from the limit; its fill and a word say the verdict."""
    x = 100.0 * part
    beyond = part > 1.0
    sure = row.of.verdict in SURE
    start, height = 100.0, 0.62
    if row.of.verdict == "undecidable":  # not a margin: somewhere from here on
        worst = row.of.at_worst
        start = axes.get_xlim()[1] if worst is None else max(100.0 * worst, x)
        height = 0.26
        marker = ">" if worst is None else "|"
        axes.plot([start], [place], marker=marker, markersize=5.0, color=MUTED)
    (bar,) = axes.barh(
        place,
        x - start,
        left=start,
        height=height,
        color=(INK if beyond else BLUE) if sure else "none",
        edgecolor=INK if beyond else BLUE,
        linewidth=0.9,
    )
    bar.set_gid(_gid(place))
    low, high = (100.0 * max(end, LEAST) for end in row.of.utilisation_interval)
    if high > low:
        axes.plot([low, high], [place, place], color=MUTED, linewidth=2.2, zorder=4)
    axes.annotate(
        f"{row.utilisation} {row.verdict}",
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(4.0, 0.0),
        textcoords="offset points",
        fontsize=SMALL,
        color=INK,
        fontweight="bold" if row.of.verdict == "meets" else "normal",
        va="center_baseline",
    )


def _label_limit(axes: Axes, x: float) -> None:
    """Write 'limit' above a line."""
    axes.annotate(
        "limit",
        (x, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(0.0, 4.0),
        textcoords="offset points",
        ha="center",
        fontsize=SMALL,
        color=INK,
    )
