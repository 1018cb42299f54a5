"""What-if section of a report: sources one at a time, a model for sliders."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import floor, inf, log10
from typing import TYPE_CHECKING

from budget.inputs.records import CHANGED
from budget.language import key_title, say, term
from budget.names import AIDING, MISSION
from budget.report.blocks import (
    Cell,
    Field,
    Paragraph,
    Section,
    Sliders,
    table_of,
)
from budget.report.device_file import LONGEST_NAME, MARK, device_yaml, is_read_back
from budget.report.tables import (
    Number,
    bound_number,
    print_coverage,
    print_given,
    print_utilisation,
    round_error,
    source_title,
)
from budget.report.wording import VERDICTS, cell, share_cell
from budget.results import BY_LAW
from budget.studies.request import sensors_of
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from budget.inputs.records import Device, Sensor
    from budget.report.blocks import Table
    from budget.results import Budget
    from budget.studies.what_if import SourceSteps, WhatIf

HEADS = {
    0.0: term("without it"),
    0.5: term("at half"),
    1.0: term("now"),
    2.0: term("at twice"),
}


CHANGED_FILE = "changed.yaml"  # what a page calls the changed device


@dataclass(frozen=True, kw_only=True)
class AnalyzeAgain:
    """Command lines that analyse the devices of a report again."""

    same: str  # as they are; --set can be added
    of_file: str  # CHANGED_FILE in their place
    operands: str = ""  # what stands after all options of `same`
    devices: tuple[Device, ...] = ()  # as they were read, without stand-ins


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
    coverage = print_coverage(model.coverage)
    required = any(limit is not None for limit in model.limit)
    on_mission = any(output.name.owner == MISSION for output in model.outputs)
    text = say(
        "One source at a time, the others as they are, by the law "
        "with its second-order terms. U{coverage} is of the output "
        "where the source has the largest share of the variance.",
        coverage=coverage,
    )
    if on_mission:
        text += say(
            " U is of the calibration; the part of the limit is the largest of the "
            "sensor's outputs and of the mission's, and so is the verdict."
        )
    elif required:
        text += say(" The part of the limit is the largest of the sensor's outputs.")
    if any(one.name.owner == AIDING for one in model.sources):
        text += say(
            " The filter is not retuned: its gains stay those of the lines as they "
            "are. What a change does is exact for that filter, and one that knew of "
            "the change would be off by no more; `--set` retunes it."
        )
    if required:
        text += say(
            " Meets up to: on what is given, that many times the present size of the "
            "line."
        )
    text += _not_by_law(budget, required=required)
    device = _device_file(budget, (again and again.devices) or devices)
    return Section(
        name="what-if",
        title=say("What a better line would change"),
        blocks=(
            Paragraph(words=(text,)),
            Sliders(
                model={
                    **model.to_dict(),
                    "device": device,
                    "command": "" if again is None else again.same,
                    "operands": "" if again is None else again.operands,
                    "command_of_file": again.of_file if again and device else "",
                },
                table=_table(rows, coverage, required=required),
            ),
        ),
    )


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


def _not_by_law(budget: Budget, *, required: bool) -> str:
    """Say where the rest of the report does not stand on the law."""
    if budget.settings.method != "gum":
        return say(
            " The budget itself is by {method}.", method=say(budget.settings.method)
        )
    judged = () if budget.assessment is None else budget.assessment.outputs
    found = [(row.output.name, row.interval_by) for row in budget.outputs]
    found += [
        (row.output.name, row.interval_by)
        for row in judged
        if row.output.name.owner == MISSION
    ]
    overruled = [key_title(name) for name, by in found if by != BY_LAW]
    refused = [
        key_title(row.output.name)
        for row in budget.outputs
        if row.interval_by == BY_LAW
        and row.validation is not None
        and not row.validation.holds
        and not required
    ]
    text = ""
    if overruled:
        text += say(
            " The interval of {overruled} is not the law's: its own "
            "coverage factor U/u is used here (JCGM 100, annex G), as "
            "if the shape stayed the same; with the sources as they "
            "are it is exact.",
            overruled=say(", ").join(overruled),
        )
    if refused:
        text += say(
            " The law failed its check for {refused}: there the "
            "numbers of this section are in doubt.",
            refused=say(", ").join(refused),
        )
    return text


def _table(rows: Sequence[SourceSteps], coverage: str, *, required: bool) -> Table:
    """Return one source after the other in several sizes."""
    steps = list(
        enumerate(say(HEADS[step.factor]) for step in rows[0].steps) if rows else ()
    )
    expanded = [
        Field(head=f"U{coverage} {head}", kind="number", cell=partial(_expanded, place))
        for place, head in steps
    ]
    used = [
        Field(
            head=say("of the limit {head} [%]", head=head),
            kind="number",
            cell=partial(_used, place),
        )
        for place, head in steps
    ]
    most = Field(head=say("meets up to"), kind="number", cell=_most)
    against = (*used, most, Field(head=say("verdict then"), cell=_verdicts))
    return table_of(
        rows,
        (
            Field(
                head=say("source"),
                weight=2.0,
                cell=lambda row: source_title(row.source.name),
            ),
            Field(head=say("printed"), cell=lambda row: row.source.printed),
            Field(
                head=say("output"),
                weight=1.6,
                cell=lambda row: key_title(row.output.name.without_owner),
            ),
            Field(
                head=say("its share [%]"),
                kind="number",
                cell=lambda row: share_cell(row.share),
            ),
            *expanded,
            Field(head="", kind="unit", cell=lambda row: row.output.unit),
            *(against if required else ()),
        ),
        name="one-at-a-time",
        caption=say("What one source more or less would do"),
        by=lambda row: say(row.source.name.owner),
        titled=True,
        is_wide=True,
        searchable=True,
    )


def _expanded(place: int, row: SourceSteps) -> Cell:
    """Round U like its standard uncertainty."""
    step = row.steps[place]
    number = round_error(step.expanded, step.u, row.output)
    unknown = row.lower_bound and step.u <= row.output.resolution
    return cell(bound_number(number, lower_bound=row.lower_bound, unknown=unknown))


def _used(place: int, row: SourceSteps) -> Cell:
    """Return the part of the limit that the sensor uses."""
    step = row.steps[place]
    if step.utilisation is None:
        return Cell(text="")
    number = Number(
        text=print_utilisation(step.utilisation).removesuffix(" %"),
        exact=step.utilisation,
    )
    marked = bound_number(number, lower_bound=row.used_lower_bound)
    return cell(marked, strong=step.utilisation > 1.0)


def _most(row: SourceSteps) -> Cell:
    """Say up to what size, in that it has now, the limits of the sensor are kept."""
    if row.used_lower_bound:
        return Cell(text="?")
    if row.most is None:
        return Cell(text=say("none"))
    if row.most == inf:
        return Cell(text=say("any"))
    # Down: what is printed has to meet.
    step = 10.0 ** (floor(log10(row.most)) - 1) if row.most > 0.0 else 1.0
    text = print_given(floor(settle(row.most / step)) * step)
    return Cell(
        text=f"\N{MULTIPLICATION SIGN} {text}",
        exact=row.most,
        strong=settle(row.most) < 1.0,
    )


def _verdicts(row: SourceSteps) -> str:
    """Say what the verdict would become, where it is another one than now."""
    now = next(step.verdict for step in row.steps if step.factor == 1.0)
    changed = [
        f"{say(VERDICTS[step.verdict])} {say(HEADS[step.factor])}"
        for step in row.steps
        if step.verdict != now
    ]
    return say("; ").join(changed) or say("unchanged") if now else ""
