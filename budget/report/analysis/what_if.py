"""What a better or worse line would change: a table, and a model for sliders."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.report.blocks import (
    Cell,
    Column,
    Paragraph,
    RowGroup,
    Section,
    Sliders,
    Table,
)
from budget.report.tables import (
    Number,
    bound_number,
    output_title,
    print_coverage,
    print_share,
    print_utilisation,
    round_error,
    source_title,
)
from budget.report.wording import VERDICTS, cell
from budget.results import BY_LAW

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.results import Budget
    from budget.studies.what_if import SourceSteps, Step, WhatIf

HEADS = {0.0: "without it", 0.5: "at half", 1.0: "now", 2.0: "at twice"}


def what_if_section(
    budget: Budget, model: WhatIf, rows: Sequence[SourceSteps]
) -> Section:
    """Return the section on what one source more or less would do."""
    coverage = print_coverage(model.coverage)
    required = any(limit is not None for limit in model.limit)
    text = (
        "One source at a time, the others as they are, by the law with its "
        f"second-order terms. U{coverage} is of the output where the source makes the "
        "largest share of the variance."
    )
    if required:
        text += " The part of the limit is the largest of the sensor's outputs."
    text += _departures(budget, required=required)
    heads = [HEADS[step.factor] for step in rows[0].steps] if rows else []
    columns = (
        Column(head="source", weight=2.0),
        Column(head="printed"),
        Column(head="output", weight=1.6),
        Column(head="its share [%]", kind="number"),
        *(Column(head=f"U{coverage} {head}", kind="number") for head in heads),
        Column(head="", kind="unit"),
        *(
            Column(head=f"of the limit {head} [%]", kind="number")
            for head in (heads if required else ())
        ),
        *((Column(head="verdict then"),) if required else ()),
    )
    table = Table(
        name="one-at-a-time",
        caption="What one source more or less would do",
        columns=columns,
        groups=tuple(
            RowGroup(
                title=sensor,
                rows=tuple(_row(row, required=required) for row in of_sensor),
            )
            for sensor, of_sensor in groupby(
                rows, key=lambda row: row.source.name.owner
            )
        ),
        is_wide=True,
        searchable=True,
    )
    return Section(
        name="what-if",
        title="What a better line would change",
        blocks=(
            Paragraph(words=(text,)),
            Sliders(model=model.to_dict(), table=table),
        ),
    )


def _departures(budget: Budget, *, required: bool) -> str:
    """Say where the rest of the report does not stand on the law."""
    if budget.settings.method != "gum":
        return f" The budget itself is by {budget.settings.method}."
    overruled = [
        output_title(row.output.name)
        for row in budget.outputs
        if row.interval_by != BY_LAW
    ]
    refused = [
        output_title(row.output.name)
        for row in budget.outputs
        if row.interval_by == BY_LAW
        and row.validation is not None
        and not row.validation.holds
        and not required
    ]
    text = ""
    if overruled:
        text += (
            f" The interval of {', '.join(overruled)} is not the law's: its own "
            "coverage factor U/u is used here (JCGM 100, annex G), as if the shape "
            "stayed the same; with the sources as they are it is exact."
        )
    if refused:
        text += (
            f" The law failed its check for {', '.join(refused)}: there the numbers "
            "of this section are in doubt."
        )
    return text


def _row(row: SourceSteps, *, required: bool) -> tuple[Cell, ...]:
    """Return one source in several sizes."""
    share = Number(text=print_share(row.share), exact=row.share)
    cells = [
        Cell(text=source_title(row.source.name)),
        Cell(text=row.source.printed),
        Cell(text=output_title(row.output.name.without_owner)),
        Cell(text=share.text.removesuffix(" %"), exact=share.exact, share=share.exact),
        *(_expanded(row, step) for step in row.steps),
        Cell(text=row.output.unit),
    ]
    if required:
        cells += [_used(row, step) for step in row.steps]
        cells.append(_verdicts(row.steps))
    return tuple(cells)


def _expanded(row: SourceSteps, step: Step) -> Cell:
    """Round U like its standard uncertainty."""
    number = round_error(step.expanded, step.u, row.output)
    unknown = row.lower_bound and step.u <= row.output.resolution
    return cell(bound_number(number, lower_bound=row.lower_bound, unknown=unknown))


def _used(row: SourceSteps, step: Step) -> Cell:
    """Return the part of the limit that the sensor uses."""
    if step.utilisation is None:
        return Cell(text="")
    number = Number(
        text=print_utilisation(step.utilisation).removesuffix(" %"),
        exact=step.utilisation,
    )
    marked = bound_number(number, lower_bound=row.used_lower_bound)
    return cell(marked, strong=step.utilisation > 1.0)


def _verdicts(steps: Sequence[Step]) -> Cell:
    """Say what the verdict would become, where it is another one than now."""
    now = next(step.verdict for step in steps if step.factor == 1.0)
    changed = [
        f"{VERDICTS[step.verdict]} {HEADS[step.factor]}"
        for step in steps
        if step.verdict != now
    ]
    return Cell(text="; ".join(changed) or "unchanged" if now else "")
