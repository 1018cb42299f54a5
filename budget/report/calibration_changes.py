"""Calibrations side by side on a terminal: two of a unit, or those of a lot."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.recordings.results import described_changes
from budget.report.pages import sections
from budget.report.tables import DASH

if TYPE_CHECKING:
    from budget.recordings.lot import CalibratedLot
    from budget.recordings.results import CalibrationChange
    from budget.report.blocks import Section


def change_answer(found: CalibrationChange) -> tuple[Section, ...]:
    """Return what stands on a terminal: what moved, and what it is the size of."""
    return sections("changed", found=found, groups=described_changes(found))


def calibrated_lot_answer(found: CalibratedLot) -> tuple[Section, ...]:
    """Return what stands on a terminal: the spread of a lot beside its data sheet."""
    groups = groupby(found.parameters, key=lambda one: one.sensor)
    return sections(
        "calibrated_lot",
        found=found,
        groups={sensor: [*own] for sensor, own in groups},
        DASH=DASH,
    )
