"""The utilisation map, which answers which device is tight where."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from budget.report.comparison.naming import SHOWN, explain_mark, mark_name, more_devices
from budget.report.comparison.tables import print_output
from budget.report.figures import (
    BLUE,
    INK,
    MUTED,
    PAPER,
    SMALL,
    WIDE,
    add_panel,
    canvas,
    house_style,
)
from budget.report.figures.picture import as_picture, capital
from budget.report.tables import (
    AT_LEAST,
    bound_number,
    output_title,
    round_error,
    words,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.blocks import Table as DataTable
    from budget.report.comparison.tables import Row, Table
    from budget.results import OutputAssessment

LEFT, RIGHT, TOP, BELOW = 184.0, 4.0, 34.0, 36.0  # room for names, heads, scale [pt]
CELL = 16.0  # height [pt]
CELL_TEXT = 8.5  # [pt]
NAME = 32  # characters of a name that fit beside it
SCALE = 300.0  # width of the scale [pt]
# Opacities of the one hue; up to 0.8 ink can be read on it (4.5:1) in light and dark.
PALEST, UP_TO_LIMIT, BEYOND, DARKEST = 0.06, 0.40, 0.60, 0.80
DARKEST_AT = 2.0  # utilisation with the darkest hue [1]
ROOM = 5  # characters that a cell holds
MOST_PER_CENT = 999.5  # beyond, a cell says >999
BOTH = 2  # devices that are all there are
SHORT = {"scale_factor": "SF", "mounting_angle": "angle", "bias": "bias"}


def map_picture(table: Table, name: str, data: DataTable) -> Picture:
    """Return the map as a block; each cell has its tooltip."""
    return as_picture(
        utilisation_map(table),
        name=name,
        title=map_title(table),
        alt=map_alt(table),
        tips=map_tips(table),
        caption=(
            "Largest error in % of the limit, devices by outputs, best first; framed "
            f"and in bold: beyond the limit.{explain_mark(table)}{more_devices(table)}"
        ),
        data=data,
        is_wide=True,
    )


@house_style()
def utilisation_map(table: Table) -> Figure:
    """Draw devices by outputs, best first: one hue, a step and a frame at the limit."""
    from matplotlib.patches import Rectangle

    rows = table.rows[:SHOWN]
    outputs = rows[0].of.outputs
    height = TOP + CELL * len(rows) + BELOW
    figure, axes = canvas(
        height, left=LEFT, right=RIGHT, top=TOP, below=BELOW, width=WIDE
    )
    figure.set_label(map_title(table))
    axes.set_xlim(0.0, len(outputs))
    axes.set_ylim(len(rows), 0.0)
    axes.set_xticks([])
    axes.set_yticks(
        [place + 0.5 for place in range(len(rows))],
        [mark_name(row, NAME) for row in rows],
    )
    axes.tick_params(axis="y", labelsize=SMALL)
    for y, row in enumerate(rows):
        for x, output in enumerate(row.of.outputs):
            part = output.utilisation
            axes.add_patch(
                Rectangle(
                    (x, y),
                    1.0,
                    1.0,
                    facecolor=BLUE,
                    alpha=PALEST if output.is_unknown else _opacity(part),
                    edgecolor="none",
                    linewidth=0.0,
                    gid=_gid(y, x),
                )
            )
            if not output.is_within:
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
                _cell(output),
                fontsize=CELL_TEXT,
                color=INK,
                fontweight="normal" if output.is_within else "bold",
                ha="center",
                va="center_baseline",
            )
    _draw_output_heads(axes, [output.output.name for output in outputs])
    _draw_scale(figure, height)
    return figure


def map_title(table: Table) -> str:
    """State the finding: which output is the tightest for most devices."""
    # Of what is only known to be this or more, nobody knows what is the tightest.
    rows = [row for row in table.rows if not row.of.lower_bound]
    if not rows:
        return f"{capital(table.sensor)}: no device gives all lines, each can be worse"
    worst = [output_group(row) for row in rows]
    first = max(dict.fromkeys(worst), key=worst.count)
    number = worst.count(first)
    whole = len(worst)
    lack = len(table.rows) - whole
    but = f"; {lack} more {'lacks' if lack == 1 else 'lack'} lines" if lack else ""
    of = f"{number} of {whole} devices"
    if number == whole:
        of = "both devices" if whole == BOTH else f"all {whole} devices"
    if whole == 1:
        return (
            f"{capital(table.sensor)}: the {first} is the tightest for the only device"
            f"{' that gives all lines' if lack else ''}{but}"
        )
    return f"{capital(table.sensor)}: the {first} is the tightest for {of}{but}"


def output_group(row: Row) -> str:
    """Name the parameter whose output is the tightest of a device: 'bias'."""
    return words(row.of.worst_output.quantity)


def map_alt(table: Table) -> str:
    """Say in words with numbers what the map shows."""
    rows = [
        f"{row.device} {row.utilisation} % ({row.worst_output})"
        for row in table.rows[:SHOWN]
    ]
    return (
        f"{map_title(table)}. Largest error of each output in per cent of its limit; "
        f"the worst of each device: {'; '.join(rows)}."
    )


def map_tips(table: Table) -> dict[str, str]:
    """Return a tooltip for each cell, by its gid."""
    return {
        _gid(y, x): (
            f"{row.device}, {output_title(output.output.name)}: "
            f"{print_error(output)} of {output.printed_limit}, "
            f"{print_output(output)} % of the limit"
        )
        for y, row in enumerate(table.rows[:SHOWN])
        for x, output in enumerate(row.of.outputs)
    }


def print_error(output: OutputAssessment) -> str:
    """Print a largest error, rounded like its standard uncertainty."""
    error = round_error(
        output.largest_error, output.standard_uncertainty, output.output
    )
    marked = bound_number(
        error, lower_bound=output.lower_bound, unknown=output.is_unknown
    )
    return f"{marked.text} {output.output.unit}"


def _gid(y: int, x: int) -> str:
    """Name a cell."""
    return f"tip-{y}-{x}"


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
    text = print_output(output).replace(" ", "")
    return text if len(text) <= ROOM or text[:1] == AT_LEAST else "<0.1"


def _draw_output_heads(axes: Axes, names: list[Name]) -> None:
    """Name the axes above the columns, and their parameters above those."""
    style: dict[str, Any] = {
        "fontsize": SMALL,
        "color": MUTED,
        "ha": "center",
    }
    start = 0
    for place, name in enumerate(names):
        parameter = name.quantity
        axes.text(place + 0.5, -0.3, name.axis, va="bottom", **style)
        is_last = place + 1 == len(names) or names[place + 1].quantity != parameter
        if is_last:
            middle = (start + place + 1) / 2.0
            title = words(parameter) if place - start > 1 else SHORT[parameter]
            axes.text(middle, -1.15, title, va="bottom", **{**style, "color": INK})
            if start:
                axes.axvline(start, color=PAPER, linewidth=2.0)
            start = place + 1


def _draw_scale(figure: Figure, height: float) -> None:
    """Draw the scale of the hue at the foot, the limit marked on it."""
    scale = add_panel(figure, left=LEFT, top=height - 28.0, width=SCALE, height=8.0)
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
            fontsize=SMALL,
            color=MUTED,
            ha={0.0: "left", 1.0: "center"}.get(x, "right"),
            va="top",
        )
