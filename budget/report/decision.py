"""A purchase decision as a document: device, calibration, station, questions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.known import AT_LEAST
from budget.report.comparison.tables import Request, gather
from budget.report.document import json_text
from budget.report.pages import document, sections
from budget.report.provenance import provenance_section
from budget.report.standing import standing_lines
from budget.report.tables import DASH

if TYPE_CHECKING:
    from budget.report.blocks import Document, Section
    from budget.studies.decide import Decision, Purchase

MOST_SHOWN = 8  # devices of a table: those after them are counted


def decision_answer(found: Decision) -> tuple[Section, ...]:
    """Return what stands on a terminal."""
    return sections("decision", **_view(found))


def decision_document(
    found: Decision, *, date: str, command_line: str = "budget decide"
) -> Document:
    """Put a decision into one document, the answer first."""
    provenance = provenance_section(
        found.inputs,
        found.settings,
        command_line=command_line,
    )
    return document("decision_page", **_view(found)).whole(
        "decision", provenance, json=json_text(found.to_dict()), date=date
    )


def _asked(purchase: Purchase) -> list[Request]:
    """Gather whom to ask for the specification that decides, alike ones together."""
    return gather(
        ((purchase.kind, offer.parts[0].vendor, (ask.line,)), offer)
        for offer, ask in purchase.open
    )


def _view(found: Decision) -> dict[str, object]:
    """Return what the page is filled in with."""
    return {
        "found": found,
        "MOST": MOST_SHOWN,
        "DASH": DASH,
        "AT_LEAST": AT_LEAST,
        "lines": standing_lines,
        "asked": _asked,
    }
