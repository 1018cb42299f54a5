"""U of every output, for a report without a requirement."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.names import words
from budget.report.blocks import Field, table_of
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
from budget.report.tables import UNKNOWN, print_coverage
from budget.report.wording import capital, cell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.tables import GroupTable, OutputRow

ABOVE = 1.08  # reach of an axis over the largest U [1]


def overview_chart(groups: Sequence[GroupTable]) -> Chart | None:
    """Show U of each output: a panel a group, a side a sensor; None without spread."""
    if not any(row.expanded.exact > 0.0 for group in groups for row in group.rows):
        return None
    coverage = print_coverage(groups[0].coverage)
    return Chart(
        name="overview",
        title=_title(groups, coverage),
        sides=tuple(
            Side(
                title=words(sensor),
                panels=tuple(_panel(g) for g in groups if g.sensor == sensor),
            )
            for sensor in dict.fromkeys(group.sensor for group in groups)
        ),
        lead=f"U{coverage}. ",
        caption="Each group of parameters has an axis of its own, from zero.",
        foot=f"U{coverage}, half the width of the {coverage} % interval",
        data=table_of(
            [(group, row) for group in groups for row in group.rows],
            (
                Field(head="output", cell=lambda one: one[1].axis),
                Field(
                    head=f"U{coverage}",
                    kind="number",
                    cell=lambda one: cell(one[1].expanded),
                ),
                Field(head="", kind="unit", cell=lambda one: one[0].unit),
            ),
            name="overview-data",
            caption=f"U{coverage} of every output",
            by=lambda one: capital(_in_unit(one[0])),
            titled=True,
        ),
    )


def _in_unit(group: GroupTable) -> str:
    """Name a group with its unit: 'gyro bias in deg/h'."""
    return f"{group.title} in {group.unit}"


def _title(groups: Sequence[GroupTable], coverage: str) -> str:
    """State the finding: the widest bias of each sensor, or the widest output."""
    chosen = [group for group in groups if group.parameter == "bias"] or groups[:1]
    parts = [
        f"not known for the {group.title}"
        if group.widest.expanded.text == UNKNOWN
        else f"{group.widest.expanded.text} {group.unit} for the {group.title}"
        for group in chosen
    ]
    return f"U{coverage} is {' and '.join(parts)}"


def _panel(group: GroupTable) -> Panel:
    """Return one group on its own axis from zero."""
    largest = max(row.expanded.exact for row in group.rows)
    return Panel(
        scale=Scale(low=0.0, high=ABOVE * largest or 1.0),
        groups=(
            Group(
                title=f"{words(group.parameter)} [{group.unit}]",
                said=_in_unit(group),
                rows=tuple(_row(group, row) for row in group.rows),
            ),
        ),
    )


def _row(group: GroupTable, row: OutputRow) -> Row:
    """Return a line from zero to the dot of one output, and its number."""
    x, text = row.expanded.exact, row.expanded.text
    tip = f"{group.title} {row.axis}: U {text} {group.unit}"
    return Row(
        label=row.axis,
        marks=(Stroke(start=0.0, end=x), Dot(at=x, size=4.5, tip=tip)),
        beside=(text,),
        said=f"{row.axis} {text}",
    )
