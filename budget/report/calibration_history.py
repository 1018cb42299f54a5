"""Calibrations of a unit over time, on a terminal and as a page with its figures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.names import Name
from budget.report.calibrated import decimals_of
from budget.report.document import json_text
from budget.report.figures.recorded import draw_axes
from budget.report.figures.style import Scale
from budget.report.figures.tabled import Plot, alternative_of_curves
from budget.report.pages import document, figure, sections
from budget.report.provenance import endings
from budget.report.tables import DASH, print_given

if TYPE_CHECKING:
    from collections.abc import Sequence
    from types import SimpleNamespace

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.recordings.history import CalibrationHistory, HistoryRow
    from budget.report.blocks import Document, Section
    from budget.report.figures.recorded import Look


@dataclass(frozen=True, kw_only=True)
class PrintedDrift:
    """One parameter over time as people read it, in its unit.

    The last value to two digits of U, the drift to those of half its interval.
    """

    row: HistoryRow
    last: str
    expanded: str  # '' where it is not known
    drift: str
    reach: str  # likewise


def printed_drift(row: HistoryRow) -> PrintedDrift:
    """Print the last value and the drift of a parameter."""
    last, ends = row.values[-1], (row.drift_low, row.drift_high)
    reach = None if None in ends else max(x - row.drift for x in ends if x is not None)
    return PrintedDrift(
        row=row,
        last=_to_digits_of(last.expanded, last.value),
        expanded=print_given(last.expanded, digits=2) if last.expanded else "",
        drift=_to_digits_of(reach, row.drift, sign="+"),
        reach=print_given(reach, digits=2) if reach else "",
    )


def _to_digits_of(u: float | None, value: float, sign: str = "") -> str:
    """Print a value to two digits of what it is known to; without that to five."""
    if not u:
        return print_given(value, digits=5)
    decimals = decimals_of(u)
    return f"{round(value, decimals) + 0.0:{sign}.{decimals}f}"


def history_answer(found: CalibrationHistory) -> tuple[Section, ...]:
    """Return what stands on a terminal: drifts, and when limits are reached."""
    return (
        *sections("history", **_view(found)),
        *sections("assumptions", found=found),
    )


def _view(found: CalibrationHistory) -> dict[str, object]:
    """Return what the pages are given."""
    groups = groupby(found.parameters, key=lambda one: one.sensor)
    return {
        "found": found,
        "groups": {sensor: [*map(printed_drift, own)] for sensor, own in groups},
        "calibrations": len(found.parameters[0].values),
        "older": [one for one in found.parameters if one.is_older],
        "name_of": _name,
        "DASH": DASH,
    }


def _name(one: HistoryRow) -> Name:
    """Return the name of a parameter, whatever its axis."""
    return Name(one.parameter, owner=one.sensor)


def history_document(
    found: CalibrationHistory, *, date: str, command_line: str = "budget history"
) -> Document:
    """Put it into one document: drifts, curves, results."""
    return document(
        "history_page",
        pictures=[one.picture for one in history_plots(found)],
        **_view(found),
    ).whole(
        "history",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
    )


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

    def curve(axes: Axes, one: HistoryRow, look: Look) -> float:
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
            color=look["color"],
            elinewidth=0.8,
            markeredgewidth=0.0,
        )
        return y[-1]

    return draw_axes(
        Scale(low=-ROOM * last, high=(1.0 + ROOM) * last, label=told.time_axis),
        Scale(
            low=min(ends) - ROOM * span, high=max(ends) + ROOM * span, label=told.axis
        ),
        [(one.axis, one) for one in rows],
        curve,
        zero=(0.0, 0.5),
    )
