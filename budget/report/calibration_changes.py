"""Two calibrations side by side, on a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.recordings.results import described_changes
from budget.report.pages import sections

if TYPE_CHECKING:
    from budget.recordings.results import CalibrationChange
    from budget.report.blocks import Section


def change_answer(found: CalibrationChange) -> tuple[Section, ...]:
    """Return what stands on a terminal: what moved, and what it is the size of."""
    return sections("changed", found=found, groups=described_changes(found))
