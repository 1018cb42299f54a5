"""The device that an allocation allows, as a file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from budget.report.device_file import device_yaml
from budget.report.pages import line

if TYPE_CHECKING:
    from budget.studies.allocation.records import Allocation


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
    wanted = allocation.question.requirement.name[:30]
    technologies = {one.technology for one in allocation.question.devices}
    return device_yaml(
        closed,
        name=f"{allocation.title[:150]}, allocated for {wanted}",
        source="budget allocate",
        notes=line("allocated", found=allocation),
        technology=technologies.pop() if len(technologies) == 1 else "",
    )
