"""Values of a unit over time, with their uncertainties: an axis a line."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Any

from budget.report.figures.curves import name_lines
from budget.report.figures.recorded import (
    ABOVE,
    BELOW,
    HEIGHT,
    LEFT,
    LOOKS,
    RIGHT,
)
from budget.report.figures.style import INK, Scale, add_plane, blank
from budget.report.figures.tabled import Plot, alternative_of_curves
from budget.report.pages import figure

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from types import SimpleNamespace

    from matplotlib.figure import Figure

    from budget.recordings.history import CalibrationHistory, HistoryRow

AGEING = ("scale_factor", "bias")  # what is shown
ROOM = 0.08  # beyond the ends of the values [1]


def history_plots(found: CalibrationHistory) -> list[Plot]:
    """Show scale factors and biases of each sensor since the first calibration."""
    shown = [one for one in found.parameters if one.parameter in AGEING]
    return [
        _plot(sensor, parameter, [*own])
        for (sensor, parameter), own in groupby(
            shown, key=lambda one: (one.sensor, one.parameter)
        )
    ]


def _plot(sensor: str, parameter: str, rows: Sequence[HistoryRow]) -> Plot:
    """Show one parameter of one sensor."""
    worst = min(rows, key=lambda one: 1.0 if one.p is None else one.p)
    first = rows[0]
    told, table = figure(
        "figures_history",
        "in_time",
        sensor=sensor,
        parameter=parameter,
        unit=first.unit,
        axes=[one.axis for one in rows],
        worst=worst,
        rows=[
            (at.time, [one.values[k].value - one.values[0].value for one in rows])
            for k, at in enumerate(first.values)
        ],
    )
    return Plot(
        name=f"history-{sensor}-{parameter}",
        said=told,
        table=table,
        draw=lambda: _draw_in_time(rows, told),
        alt=alternative_of_curves(told.title, table),
    )


def _draw_in_time(rows: Sequence[HistoryRow], told: SimpleNamespace) -> Figure:
    """Draw changes with bars, and straight lines."""
    ends = [
        x
        for one in rows
        for at in one.values
        for x in (
            at.value - one.values[0].value - (at.expanded or 0.0),
            at.value - one.values[0].value + (at.expanded or 0.0),
        )
    ]
    span = (max(ends) - min(ends)) or 1.0
    last = rows[0].values[-1].time
    drawing = blank(ABOVE + HEIGHT + BELOW)
    axes = add_plane(
        drawing,
        Scale(low=-ROOM * last, high=(1.0 + ROOM) * last, label=told.time_axis),
        Scale(
            low=min(ends) - ROOM * span, high=max(ends) + ROOM * span, label=told.axis
        ),
        left=LEFT,
        top=ABOVE,
        right=RIGHT,
        height=HEIGHT,
    )
    axes.axhline(0.0, color=INK, linewidth=0.5)
    names = []
    looks: dict[str, Mapping[str, Any]] = {}
    for one in rows:
        colour, dash = LOOKS[one.axis]
        look: dict[str, Any] = {"color": colour, "linestyle": dash, "linewidth": 1.1}
        x = [at.time for at in one.values]
        y = [at.value - one.values[0].value for at in one.values]
        reach = [at.expanded or 0.0 for at in one.values]
        axes.plot(x, y, **look)
        axes.errorbar(
            x,
            y,
            reach,
            fmt="o",
            markersize=3.0,
            color=colour,
            elinewidth=0.8,
            markeredgewidth=0.0,
        )
        names.append((y[-1], one.axis))
        looks[one.axis] = look
    name_lines(axes, names, looks)
    for spine in axes.spines.values():
        spine.set_color(INK)
    return drawing
