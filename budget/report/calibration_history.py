"""Calibrations of a unit over time, on a terminal and as a page."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.names import Name
from budget.report.document import json_text
from budget.report.figures.history import history_plots
from budget.report.pages import document, sections
from budget.report.provenance import provenance_section, sign_off_section
from budget.report.tables import DASH
from budget.version import __version__

if TYPE_CHECKING:
    from budget.recordings.history import CalibrationHistory, HistoryRow
    from budget.report.blocks import Document, Section

COMMAND = "budget history"


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
        "groups": {sensor: [*own] for sensor, own in groups},
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
