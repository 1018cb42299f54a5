"""What the figures of a comparison share: names of devices, a logarithmic axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axis import Axis

    from budget.report.comparison.tables import Row, Table

SHOWN = 40  # devices in a figure, the best ones; all are in the tables
DOTS = "..."
MARK = " *"  # behind the name of a device that lacks a line
# Ticks of a logarithmic axis, and the span beyond which the coarse ones are enough.
FINE, COARSE, DECADES = (1.0, 2.0, 5.0), (1.0,), 99.0


def fit_name(name: str, length: int) -> str:
    """Return a name that fits beside a figure, its end left out where it is long."""
    return name if len(name) <= length else f"{name[: length - len(DOTS)]}{DOTS}"


def mark_name(row: Row, length: int) -> str:
    """Return a device's name that fits, marked where expected lines are missing."""
    if not row.missing:
        return fit_name(row.device, length)
    return fit_name(row.device, length - len(MARK)) + MARK


def explain_mark(table: Table) -> str:
    """Say what the mark means, '' where no device of the figure has it."""
    if not any(row.missing for row in table.rows[:SHOWN]):
        return ""
    return (
        " *: expected lines are missing and count as 0; the error is this or more (≥)."
    )


def more_devices(table: Table) -> str:
    """Say that a figure does not show all devices, '' where it does."""
    whole = len(table.rows)
    return f" The first {SHOWN} of {whole} devices." if whole > SHOWN else ""


def plain_ticks(axis: Axis) -> None:
    """Tick a logarithmic axis at 1, 2 and 5, or at decades where it is long."""
    from matplotlib.ticker import LogLocator

    low, high = axis.get_view_interval()
    axis.set_major_locator(LogLocator(subs=FINE if high < DECADES * low else COARSE))
    axis.set_major_formatter("{x:g}")
