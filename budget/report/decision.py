"""What to buy for people and programs: the choice, its calibration, station, asks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.document import json_text
from budget.report.pages import document, sections
from budget.report.provenance import provenance_section
from budget.report.tables import AT_LEAST, DASH
from budget.report.wording import standing_lines
from budget.version import __version__

if TYPE_CHECKING:
    from budget.report.blocks import Document, Section
    from budget.studies.decide import Decision

MOST_SHOWN = 8  # devices of a table: those after them are counted
COMMAND = "budget decide"


def decision_answer(found: Decision) -> tuple[Section, ...]:
    """Return what stands on a terminal."""
    return sections("decision", **_view(found))


def decision_document(
    found: Decision, *, date: str, command_line: str = COMMAND
) -> Document:
    """Put a decision into one document, the answer first."""
    provenance = provenance_section(
        found.inputs,
        found.settings,
        version=__version__,
        command_line=command_line,
    )
    page = document("decision_page", **_view(found))
    return page.whole(
        "decision", provenance, json=json_text(found.to_dict()), date=date
    )


def _view(found: Decision) -> dict[str, object]:
    """Return what the page is filled in with."""
    return {
        "found": found,
        "MOST": MOST_SHOWN,
        "DASH": DASH,
        "AT_LEAST": AT_LEAST,
        "lines": standing_lines,
    }
