"""An allocation for programs: CSV, and the allocated device as a file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from budget.report.device_file import device_yaml
from budget.report.document import csv_text
from budget.report.pages import line

if TYPE_CHECKING:
    from budget.studies.allocation.records import Allocation


COLUMNS = (
    *("sensor", "source", "unit", "status", "now", "allowed", "uncorrected"),
    *("binding_output", "at_ceiling", "at_least", "spared"),
    *("ceiling", "least"),
    *("headroom", "stopped_by", "best_offered", "counts"),
)


def allocation_csv(allocation: Allocation) -> str:
    """Write one row for each source, values in the units of the file."""
    return csv_text(COLUMNS, (_row(one.to_dict()) for one in allocation.sources))


def allocated_device(allocation: Allocation) -> str:
    """Write the allocated device as a device file.

    Raises
    ------
    ValueError
        The requirement cannot be met, so there is none.
    """
    if not allocation.feasible:
        raise ValueError("an infeasible requirement has no allocated device")
    # An allowed size is one to be kept, whatever the maker left open.
    closed = [
        sensor.with_lines(replace(one, readings=()) for one in sensor.lines)
        for sensor in allocation.sensors
    ]
    technologies = {one.technology for one in allocation.devices}
    return device_yaml(
        closed,
        name=f"{allocation.title[:150]}, allocated for {allocation.requirement[:30]}",
        source="budget allocate",
        notes=line("allocated", found=allocation),
        technology=technologies.pop() if len(technologies) == 1 else "",
    )


def _row(entry: dict[str, Any]) -> dict[str, Any]:
    """Return one entry of `sources` without a nest, as columns have it."""
    room = entry["headroom"] or {}
    return {
        **entry,
        "headroom": room.get("value"),
        "stopped_by": room.get("stopped_by"),
    }
