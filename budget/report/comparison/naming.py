"""Names of devices in figures, and how many devices a figure shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from budget.report.comparison.tables import Table

SHOWN = 40  # devices in a figure, the best ones; all are in the tables
DOTS = "..."


def fit_name(name: str, length: int) -> str:
    """Return a name that fits beside a figure, its end left out where it is long."""
    return name if len(name) <= length else f"{name[: length - len(DOTS)]}{DOTS}"


def more_devices(table: Table) -> str:
    """Say that a figure does not show all devices, '' where it does."""
    whole = len(table.rows)
    return f" The first {SHOWN} of {whole} devices." if whole > SHOWN else ""
