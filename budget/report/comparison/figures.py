"""Figures of a comparison: who is tight where, by what margin, what better costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.report.figures import (
    BLUE,
    GRID,
    INK,
    MUTED,
    PAPER,
    SMALL,
    WIDTH,
    add_panel,
    canvas,
)
from budget.report.tables import print_given, print_utilisation, words
from budget.studies.comparison.figures_of_merit import Amount, read_amount

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.report.comparison.tables import Row, Table

NAMED = 3  # devices in a title
SHOWN = 40  # devices in a figure, the best ones; all are in the tables
LEFT = 112.0  # room for names [pt]
NAME = 22  # characters of a name that fit there
CELL, BAR_ROW = 13.0, 14.0  # heights [pt]
CELL_TEXT = 6.5  # [pt]
PALEST, UP_TO_LIMIT, BEYOND = 0.06, 0.45, 0.70  # opacities of the one hue
DARKEST_AT = 2.0  # utilisation with the full hue [1]
DARK_FROM = 0.6  # opacity from which text is light
MOST_PER_CENT = 999.5  # beyond, a cell says >999
LEAST = 1e-4  # utilisation where a bar ends at the latest [1]
LEAST_POINTS = 2  # that make a scatter
# Ticks of a logarithmic axis, and the span beyond which the coarse ones are enough.
FINE, COARSE, DECADES = (1.0, 2.0, 5.0), (1.0,), 99.0
SHORT = {"scale_factor": "SF", "mounting_angle": "angle", "bias": "bias"}


def utilisation_map(table: Table) -> Figure:
    """Draw devices by outputs, best first: one hue, a step and a frame at the limit."""
    from matplotlib.patches import Rectangle

    rows = table.rows[:SHOWN]
    outputs = rows[0].of.outputs
    top, below = 30.0, 34.0
    height = top + CELL * len(rows) + below
    figure, axes = canvas(height, left=LEFT, right=4.0, top=top, below=below)
    figure.set_label(map_title(table))
    axes.set_xlim(0.0, len(outputs))
    axes.set_ylim(len(rows), 0.0)
    axes.set_xticks([])
    axes.set_yticks(
        [place + 0.5 for place in range(len(rows))], [_name(row) for row in rows]
    )
    axes.tick_params(axis="y", labelsize=SMALL)
    for y, row in enumerate(rows):
        for x, output in enumerate(row.of.outputs):
            part = output.utilisation
            opacity = _opacity(part)
            axes.add_patch(
                Rectangle(
                    (x, y),
                    1.0,
                    1.0,
                    facecolor=BLUE,
                    alpha=opacity,
                    edgecolor="none",
                    linewidth=0.0,
                )
            )
            if part > 1.0:
                axes.add_patch(
                    Rectangle(
                        (x + 0.04, y + 0.06),
                        0.92,
                        0.88,
                        facecolor="none",
                        edgecolor=INK,
                        linewidth=0.9,
                    )
                )
            axes.text(
                x + 0.5,
                y + 0.5,
                _cell(part),
                fontsize=CELL_TEXT,
                color="#ffffff" if opacity >= DARK_FROM else INK,
                fontweight="bold" if part > 1.0 else "normal",
                ha="center",
                va="center_baseline",
            )
    _draw_output_heads(axes, [output.output.name for output in outputs])
    _draw_scale(figure, height)
    return figure


def map_title(table: Table) -> str:
    """State the finding: which output is the tightest for most devices."""
    worst = [row.worst_output.rpartition(" ")[0] for row in table.rows]
    first = max(dict.fromkeys(worst), key=worst.count)
    number = worst.count(first)
    whole = len(worst)
    of = f"all {whole} devices" if number == whole else f"{number} of {whole} devices"
    if whole == 1:
        return f"{_capital(table)}: the {first} is the tightest for the only device"
    return f"{_capital(table)}: the {first} is the tightest for {of}"


def map_alt(table: Table) -> str:
    """Say in words with numbers what the map shows."""
    rows = [
        f"{row.device} {print_utilisation(row.of.utilisation)} ({row.worst_output})"
        for row in table.rows[:SHOWN]
    ]
    return (
        f"{map_title(table)}. Largest error of each output in per cent of its limit; "
        f"the worst of each device: {'; '.join(rows)}."
    )


def margin_bars(table: Table) -> Figure:
    """Draw how far each device is from its limit: bars that start at the limit."""
    rows = table.rows[:SHOWN]
    top, below = 18.0, 32.0
    figure, axes = canvas(
        top + BAR_ROW * len(rows) + below, left=LEFT, right=84.0, top=top, below=below
    )
    figure.set_label(margin_title(table))
    axes.set_xscale("log")
    parts = [max(row.of.utilisation, LEAST) for row in rows]
    axes.set_xlim(100.0 * min(0.5, *parts) / 1.3, 100.0 * max(2.0, *parts) * 1.3)
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [_name(row) for row in rows])
    axes.tick_params(axis="y", labelsize=SMALL)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.minorticks_off()
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    axes.set_xlabel("largest error [% of the limit]", fontsize=SMALL, color=MUTED)
    for place, (row, part) in enumerate(zip(rows, parts, strict=True)):
        _draw_margin(axes, place, row, part)
    axes.axvline(100.0, color=INK, linewidth=1.0, zorder=3)
    _label_limit(axes, 100.0)
    return figure


def margin_title(table: Table) -> str:
    """State the finding: how many meet, and the best of them."""
    meets = [row for row in table.rows if row.of.verdict == "meets"]
    number = f"{len(meets) or 'None'} of {len(table.rows)}"
    verb = "meet" if len(meets) > 1 else "meets"
    best = min(meets or table.rows, key=lambda row: row.of.utilisation)
    part = print_utilisation(best.of.utilisation)
    named = f"{best.device} at {part} of the limit"
    if meets:
        return f"{_capital(table)}: {number} {verb}, the best is {named}"
    return f"{_capital(table)}: {number} meets; the least used limit is {named}"


def margin_alt(table: Table) -> str:
    """Say in words with numbers what the bars show."""
    bars = "; ".join(
        f"{row.device} {print_utilisation(row.of.utilisation)}, {row.verdict}"
        for row in table.rows[:SHOWN]
    )
    return f"{margin_title(table)}. Largest error in per cent of the limit: {bars}."


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


def pareto_scatter(table: Table, merit: str) -> Figure:
    """Draw the part of the limit against a cost; the front is joined, the rest grey."""
    from matplotlib.ticker import LogLocator

    points = merit_points(table, merit)
    left, right, top, below = 40.0, 12.0, 12.0, 34.0
    figure, axes = canvas(220.0, left=left, right=right, top=top, below=below)
    figure.set_label(pareto_title(table, merit))
    axes.set_xscale("log")
    axes.set_yscale("log")
    costs = [amount.value for _, amount in points]
    parts = [max(row.of.utilisation, LEAST) for row, _ in points]
    axes.set_xlim(min(costs) / 1.6, max(costs) * 2.2)
    axes.set_ylim(100.0 * min(0.5, *parts) / 1.5, 100.0 * max(2.0, *parts) * 1.5)
    for axis, (low, high) in (
        (axes.xaxis, axes.get_xlim()),
        (axes.yaxis, axes.get_ylim()),
    ):
        axis.set_major_locator(
            LogLocator(subs=FINE if high < DECADES * low else COARSE)
        )
        axis.set_major_formatter("{x:g}")
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
    axes.plot(*zip(*on_front, strict=True), color=BLUE, linewidth=1.0, zorder=2)
    for row, amount in points:
        _draw_point(axes, row, amount.value, is_best=merit in row.of.on_front)
    names: dict[tuple[float, float], list[str]] = {}
    for row, amount in points:
        if merit in row.of.on_front:  # devices in one place share a label
            names.setdefault((amount.value, row.of.utilisation), []).append(_name(row))
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
    more = len(names) - NAMED
    named = ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")
    verb = "is" if len(names) == 1 else "are"
    return f"{_capital(table)}: {named} {verb} not beaten in {merit} and error at once"


def pareto_alt(table: Table, merit: str) -> str:
    """Say in words with numbers what the scatter shows."""
    points = "; ".join(
        f"{row.device} {print_given(amount.value)} {amount.unit}, "
        f"{print_utilisation(row.of.utilisation)}"
        for row, amount in merit_points(table, merit)
    )
    title = pareto_title(table, merit)
    return f"{title}. {merit.capitalize()} and part of the limit: {points}."


def _capital(table: Table) -> str:
    """Return what the figures of a table are of."""
    return table.sensor.capitalize()


def _name(row: Row) -> str:
    """Return a name that fits beside a figure."""
    name = row.device
    return name if len(name) <= NAME else f"{name[: NAME - 3]}..."


def _opacity(part: float) -> float:
    """Return the opacity of the hue: it steps up at the limit."""
    if part <= 1.0:
        return PALEST + (UP_TO_LIMIT - PALEST) * part
    share = min((part - 1.0) / (DARKEST_AT - 1.0), 1.0)
    return BEYOND + (1.0 - BEYOND) * share


def _cell(part: float) -> str:
    """Print a part of a limit in three characters, so that 100 is not passed."""
    per_cent = 100.0 * part
    if per_cent >= MOST_PER_CENT:
        return ">999"
    if part > 1.0 and round(per_cent) == 100:  # noqa: PLR2004 - per cent
        return ">100"
    return f"{per_cent:.0f}" if per_cent >= 1.0 else "<1"


def _draw_output_heads(axes: Axes, names: list[str]) -> None:
    """Name the axes above the columns, and their parameters above those."""
    style: dict[str, Any] = {
        "fontsize": CELL_TEXT + 0.5,
        "color": MUTED,
        "ha": "center",
    }
    start = 0
    for place, name in enumerate(names):
        _, parameter, axis = name.split(".")
        axes.text(place + 0.5, -0.3, axis, va="bottom", **style)
        is_last = place + 1 == len(names) or names[place + 1].split(".")[1] != parameter
        if is_last:
            middle = (start + place + 1) / 2.0
            title = words(parameter) if place - start > 1 else SHORT[parameter]
            axes.text(middle, -1.15, title, va="bottom", **{**style, "color": INK})
            if start:
                axes.axvline(start, color=PAPER, linewidth=2.0)
            start = place + 1


def _draw_scale(figure: Figure, height: float) -> None:
    """Draw the scale of the hue at the foot, the limit marked on it."""
    width = WIDTH - LEFT - 4.0
    scale = add_panel(figure, left=LEFT, top=height - 27.0, width=width, height=7.0)
    scale.set_xlim(0.0, DARKEST_AT)
    scale.set_ylim(0.0, 1.0)
    scale.axis("off")
    steps = 40
    for step in range(steps):
        start, end = DARKEST_AT * step / steps, DARKEST_AT * (step + 1) / steps
        scale.axvspan(
            start, end, color=BLUE, alpha=_opacity((start + end) / 2.0), linewidth=0.0
        )
    scale.plot([1.0, 1.0], [-0.4, 1.4], color=INK, linewidth=1.2, clip_on=False)
    for x, text in ((0.0, "0"), (1.0, "limit"), (DARKEST_AT, "200 % and more")):
        scale.annotate(
            text,
            (x, 0.0),
            xytext=(0.0, -4.0),
            textcoords="offset points",
            fontsize=CELL_TEXT + 0.5,
            color=MUTED,
            ha={0.0: "left", 1.0: "center"}.get(x, "right"),
            va="top",
        )


def _draw_margin(axes: Axes, place: int, row: Row, part: float) -> None:
    """Draw one bar from the limit; its fill and a word say the verdict."""
    x = 100.0 * part
    beyond = part > 1.0
    sure = row.of.verdict in ("meets", "fails")
    axes.barh(
        place,
        x - 100.0,
        left=100.0,
        height=0.62,
        color=(INK if beyond else BLUE) if sure else "none",
        edgecolor=INK if beyond else BLUE,
        linewidth=0.9,
    )
    low, high = (100.0 * max(end, LEAST) for end in row.of.utilisation_interval)
    if high > low:
        axes.plot([low, high], [place, place], color=MUTED, linewidth=2.2, zorder=4)
    axes.annotate(
        f"{row.utilisation} {row.verdict}",
        (1.0, place),
        xycoords=("axes fraction", "data"),
        xytext=(4.0, 0.0),
        textcoords="offset points",
        fontsize=SMALL - 0.5,
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


def _draw_point(axes: Axes, row: Row, cost: float, *, is_best: bool) -> None:
    """Draw one device; those on the front have their names beside them."""
    y = 100.0 * max(row.of.utilisation, LEAST)
    sure = row.of.verdict in ("meets", "fails")
    colour = BLUE if is_best else MUTED
    axes.plot(
        [cost],
        [y],
        marker="o",
        markersize=5.0,
        color=colour if sure else PAPER,
        markeredgecolor=colour,
        linestyle="none",
        zorder=4 if is_best else 3,
    )
