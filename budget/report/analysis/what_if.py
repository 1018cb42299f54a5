"""What-if section of a report: sources one at a time, a model for sliders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Any

from budget.errors import UnitError
from budget.inputs.records import CHANGED
from budget.names import AIDING, MISSION
from budget.question import sensors_of
from budget.report.blocks import Section, Sliders
from budget.report.device_file import LONGEST_NAME, MARK, device_yaml, is_read_back
from budget.report.mission import outputs_at_end
from budget.report.pages import blocks, section
from budget.report.tables import (
    as_limited,
    print_coverage,
    print_two_down,
    round_error,
)
from budget.results import BY_LAW
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from budget.inputs.records import Device, Sensor
    from budget.report.tables import Number
    from budget.results import Assessment, Budget
    from budget.studies.what_if import SourceSteps, Step, WhatIf

SLIGHT = 0.001  # share of every variance below which a row says nothing [1]
CHANGED_FILE = "changed.yaml"  # what a page calls the changed device


@dataclass(frozen=True, kw_only=True)
class AnalyzeAgain:
    """Command lines that analyse the devices of a report again."""

    same: str  # as they are; --set can be added
    of_file: str  # CHANGED_FILE in their place
    operands: str = ""  # what stands after all options of `same`
    devices: tuple[Device, ...] = ()  # as they were read, without stand-ins


def in_page_units(
    model: WhatIf, assessment: Assessment | None, carried: Budget | None
) -> WhatIf:
    """Return the model with its outputs in the units that the answer has them in."""
    own = {} if carried is None else outputs_at_end(carried)
    own |= {
        row.output.name: as_limited(row).output
        for row in (assessment.outputs if assessment else ())
    }
    return replace(
        model, outputs=tuple(own.get(one.name, one) for one in model.outputs)
    )


def what_if_section(
    budget: Budget,
    model: WhatIf,
    rows: Sequence[SourceSteps],
    *,
    devices: Sequence[Device],
    again: AnalyzeAgain | None = None,
) -> Section:
    """Return the section on what one source more or less would do.

    With `again`, the commands of the same analysis, the page has those of a changed
    device.
    """
    device = _device_file(budget, (again and again.devices) or devices)
    is_judged = any(limit is not None for limit in model.limit)
    shown = [row for row in rows if row.share >= SLIGHT] or rows
    slight = [row.source.name for row in rows if row not in shown]
    table: Any
    (table,) = blocks(
        "analysis/what_if_table",
        rows=[_improved(row) for row in shown],
        coverage=print_coverage(model.coverage),
        is_judged=is_judged,
        expanded=_expanded,
        down=print_two_down,
        largest=largest_size,
        inf=inf,
    )
    sliders = Sliders(
        model={
            **model.to_dict(),
            "device": device,
            "command": "" if again is None else again.same,
            "operands": "" if again is None else again.operands,
            "command_of_file": again.of_file if again and device else "",
        },
        table=table,
    )
    return section(
        "analysis/what_if",
        budget=budget,
        assessment=budget.assessment,
        model=model,
        is_judged=is_judged,
        slight=slight,
        sliders=sliders,
        MISSION=MISSION,
        AIDING=AIDING,
        BY_LAW=BY_LAW,
    )


def _improved(row: SourceSteps) -> SourceSteps:
    """Return what a better specification would change; a worse one has sliders."""
    return replace(row, steps=tuple(step for step in row.steps if step.factor <= 1.0))


def _device_file(budget: Budget, devices: Sequence[Device]) -> str:
    """Return the devices as one file with marks, '' where none says the same of them.

    Stand-ins are not written: the command puts them there again.
    """
    filled = {line.source for line in budget.filled}
    sensors = [
        _without(sensor, {one.quantity for one in filled if one.owner == sensor.kind})
        for sensor in sensors_of(devices)
    ]
    technologies = {device.technology for device in devices}
    if any(one.role.startswith("measured") for one in budget.inputs):
        return ""  # a result is of the file that it was calibrated with
    if len(devices) > 1 and budget.settings.missing != "refuse":
        return ""  # what is comparable with each of them is not with one device
    technology = technologies.pop() if len(technologies) == 1 else ""
    title = budget.title.removesuffix(CHANGED)[: LONGEST_NAME - len(CHANGED)]
    text = device_yaml(
        sensors,
        name=f"{title}{CHANGED}",
        source="sliders of a report",
        notes="; ".join(
            f"from {file.role} {file.name} sha256 {file.sha256}"
            for file in budget.inputs
        ),
        technology=technology,
        mark=MARK,
    )
    plain = text.replace(MARK, "")
    return text if is_read_back(plain, sensors, technology=technology) else ""


def _without(sensor: Sensor, names: Collection[str]) -> Sensor:
    """Return a sensor without some of its lines."""
    if not names:
        return sensor
    return sensor.with_lines(line for line in sensor.lines if line.name not in names)


def largest_size(row: SourceSteps) -> str:
    """Print the largest size that meets as the data sheet gives it, '' in words."""
    try:
        now = parse_quantity(row.source.printed, row.source.unit)
    except UnitError:  # one for each axis
        return ""
    most = (row.most or 0.0) * now.value / now.si_per_unit
    return f"{print_two_down(most)} {now.unit}"


def _expanded(row: SourceSteps, step: Step) -> Number:
    """Round U like its standard uncertainty."""
    return round_error(step.expanded, step.u, row.output)
