"""Utilisation dots: each output against its limit."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING

from budget.names import words
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import (
    Chart,
    Dot,
    Group,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import INK, MUTED, PAPER
from budget.report.tables import (
    join_outputs,
    largest_error,
    output_title,
    used_part,
)
from budget.report.wording import capital
from budget.results import worst_of
from budget.ties import from_largest, largest

if TYPE_CHECKING:
    from budget.results import Assessment, OutputAssessment

LINEAR_BELOW = 4.0  # utilisations beyond need a logarithmic axis [1]


FIELDS = (
    Field["OutputAssessment"](head="output", cell=lambda row: row.output.name.axis),
    Field["OutputAssessment"](
        head="largest error [% of the limit]",
        kind="number",
        cell=lambda row: Cell(
            text=used_part(row).text.removesuffix(" %"),
            exact=100.0 * row.utilisation,
            strong=not row.is_within,
        ),
    ),
    Field["OutputAssessment"](head="limit", cell=lambda row: row.printed_limit),
)


def utilisation_chart(assessment: Assessment) -> Chart:
    """Show each required output's largest error against its limit, worst first."""
    most = max(output.utilisation for output in assessment.outputs)
    is_log = most > LINEAR_BELOW
    scale = Scale(
        low=1.0 if is_log else 0.0,  # what is less sits at the edge, its label is exact
        high=100.0 * max(1.05 * most, 1.2),
        kind="log" if is_log else "linear",
        lines=((100.0, "limit"),),
    )
    sensors = dict.fromkeys(row.output.name.owner for row in assessment.outputs)
    return Chart(
        name="utilisation",
        title=utilisation_title(assessment),
        sides=tuple(
            Side(
                title=words(sensor),
                panels=(
                    Panel(scale=scale, groups=_groups(assessment, sensor, scale.low)),
                ),
            )
            for sensor in sensors
        ),
        lead="Largest errors in per cent of the limit. ",
        foot="largest error [% of the limit]; filled: beyond it",
        data=table_of(
            [
                row
                for sensor in sensors
                for own in _ranked(assessment, sensor)
                for row in own
            ],
            FIELDS,
            name="utilisation-data",
            caption="Largest error of each output in per cent of its limit",
            by=lambda row: capital(output_title(row.output.name.group)),
            titled=True,
        ),
    )


def utilisation_title(assessment: Assessment) -> str:
    """State the finding: how many outputs exceed their limits, and the worst."""
    worst = worst_of(assessment.outputs)
    sensors = assessment.sensors
    nearest = [
        sensors[place] for place in largest([one.utilisation for one in sensors])
    ]
    beyond = sum(not output.is_within for output in assessment.outputs)
    name = join_outputs([name for one in nearest for name in one.worst_outputs])
    part = f"{name} at {used_part(worst).text} of the limit"
    total = len(assessment.outputs)
    if beyond:
        return f"{beyond} of {total} outputs exceed their limits, most of all {part}"
    open_ones = sum(output.lower_bound for output in assessment.outputs)
    if open_ones:
        return (
            f"{total - open_ones} of {total} outputs are within their limits, "
            f"{open_ones} cannot be decided, lines are missing"
        )
    return f"All {total} outputs stay within their limits, the nearest is {part}"


def _ranked(assessment: Assessment, sensor: str) -> list[list[OutputAssessment]]:
    """Return the outputs of a sensor by parameter, the worst group first.

    Axes keep their order, which noise would change otherwise.
    """
    own = [row for row in assessment.outputs if row.output.name.owner == sensor]
    groups = [
        list(outputs)
        for _, outputs in groupby(own, key=lambda output: output.output.name.group)
    ]
    order = from_largest([worst_of(outputs).utilisation for outputs in groups])
    return [groups[k] for k in order]


def _groups(assessment: Assessment, sensor: str, start: float) -> tuple[Group, ...]:
    """Return the rows of the outputs of a sensor, the worst group first."""
    return tuple(
        Group(
            title=output_title(outputs[0].output.name.group.without_owner),
            said=output_title(outputs[0].output.name.group),
            rows=tuple(_row(output, start) for output in outputs),
        )
        for outputs in _ranked(assessment, sensor)
    )


def _row(output: OutputAssessment, start: float) -> Row:
    """Return a thin line to a dot, filled where it is beyond the limit."""
    x = max(100.0 * output.utilisation, start)
    used, axis = used_part(output).text, output.output.name.axis
    return Row(
        label=axis,
        marks=(
            Stroke(start=start, end=x),
            Dot(
                at=x,
                fill=PAPER if output.is_within else INK,
                edge=MUTED if output.is_within else INK,
                tip=f"{output_title(output.output.name)}: largest error "
                f"{largest_error(output).text} "
                f"{output.output.unit}, {used} of the limit {output.printed_limit}",
            ),
        ),
        beside=(used,),
        strong=not output.is_within,
        said=f"{axis} {used}",
    )
