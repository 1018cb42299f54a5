"""Calibrations of a unit over time, on a terminal and as a page."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.names import Name
from budget.report.calibrated import decimals_of
from budget.report.document import json_text
from budget.report.figures.history import history_plots
from budget.report.pages import document, sections
from budget.report.provenance import provenance_section, sign_off_section
from budget.report.tables import DASH, print_given
from budget.version import __version__

if TYPE_CHECKING:
    from budget.recordings.history import CalibrationHistory, HistoryRow
    from budget.report.blocks import Document, Section

COMMAND = "budget history"


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
    found: CalibrationHistory, *, date: str, command_line: str = COMMAND
) -> Document:
    """Put it into one document: drifts, curves, results."""
    return document(
        "history_page",
        pictures=[one.picture for one in history_plots(found)],
        **_view(found),
    ).whole(
        "history",
        provenance_section(
            found.inputs, None, version=__version__, command_line=command_line
        ),
        sign_off_section(),
        json=json_text(found.to_dict()),
        date=date,
    )
