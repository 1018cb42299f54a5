"""Figures of all outputs: U, limits used, the law against Monte Carlo."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.language import axis_title, key_title, words
from budget.names import MISSION
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
from budget.report.pages import line, table, texts
from budget.report.tables import as_limited, largest_error, used_part
from budget.results import worst_of
from budget.ties import first_largest, from_largest, largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.tables import GroupTable, OutputRow
    from budget.results import (
        Assessment,
        Budget,
        JudgedOutput,
        OutputBudget,
        Validation,
    )

PAGE = "figures_outputs"
ABOVE = 1.08  # reach of an axis over the largest U [1]


def overview_chart(groups: Sequence[GroupTable]) -> Chart | None:
    """Show U of each output: a panel a group, a side a sensor; None without spread."""
    if not any(row.expanded.exact > 0.0 for group in groups for row in group.rows):
        return None
    said = texts(PAGE, "overview", groups=groups)
    return Chart(
        name="overview",
        title=said.title,
        sides=tuple(
            Side(
                title=words(sensor),
                panels=tuple(_overview_panel(g) for g in groups if g.sensor == sensor),
            )
            for sensor in dict.fromkeys(group.sensor for group in groups)
        ),
        lead=said.lead,
        caption=said.caption,
        foot=said.foot,
        data_on_paper=False,
        data=table(PAGE, "overview_data", groups=groups),
    )


def _overview_panel(group: GroupTable) -> Panel:
    """Return one group on its own axis from zero."""
    largest = max(row.expanded.exact for row in group.rows)
    return Panel(
        scale=Scale(low=0.0, high=ABOVE * largest or 1.0),
        groups=(
            Group(
                title=f"{words(group.parameter)} [{group.unit}]",
                said=line(PAGE, "in_unit", group=group),
                rows=tuple(_overview_row(group, row) for row in group.rows),
            ),
        ),
    )


def _overview_row(group: GroupTable, row: OutputRow) -> Row:
    """Return a line from zero to the dot of one output, and its number."""
    x, text = row.expanded.exact, row.expanded.text
    tip = line(PAGE, "overview_row", group=group, row=row)
    return Row(
        label=row.axis,
        marks=(Stroke(start=0.0, end=x), Dot(at=x, size=4.5, tip=tip)),
        beside=(text,),
        said=f"{row.axis} {text}",
    )


ABREAST = 2  # sensors beside each other at the most
MOST_LINEAR = 4.0  # utilisations beyond need a logarithmic axis [1]


def utilisation_chart(assessment: Assessment) -> Chart:
    """Show each required output's largest error against its limit, worst first."""
    most = max(output.utilisation for output in assessment.outputs)
    is_log = most > MOST_LINEAR
    said = texts(PAGE, "used", is_log=is_log)
    scale = Scale(
        low=1.0 if is_log else 0.0,  # what is less sits at the edge, its label is exact
        high=100.0 * max(1.05 * most, 1.2),
        kind="log" if is_log else "linear",
        lines=((100.0, said.limit),),
    )
    sensors = dict.fromkeys(row.output.name.owner for row in assessment.outputs)
    # Names of a mission are long: beside another side there is no room for them.
    is_one = MISSION in sensors or len(sensors) > ABREAST
    panels = {
        sensor: Panel(
            scale=scale,
            groups=_limit_groups(assessment, sensor, scale.low, is_one=is_one),
        )
        for sensor in sensors
    }
    every = tuple(group for panel in panels.values() for group in panel.groups)
    return Chart(
        name="utilisation",
        title=utilisation_title(assessment),
        sides=(Side(panels=(Panel(scale=scale, groups=every),)),)
        if is_one
        else tuple(
            Side(title=words(sensor), panels=(panel,))
            for sensor, panel in panels.items()
        ),
        lead=said.lead,
        foot=said.foot,
        data_on_paper=False,
        data=table(
            PAGE,
            "used_data",
            rows=[
                row
                for sensor in sensors
                for own in _ranked(assessment, sensor)
                for row in own
            ],
            axis=axis_title,
            used=used_part,
        ),
    )


def utilisation_title(assessment: Assessment) -> str:
    """State the finding: how many outputs exceed their limits, and the worst."""
    sensors = assessment.sensors
    return line(
        PAGE,
        "used_title",
        assessment=assessment,
        nearest=[sensors[k] for k in largest([one.utilisation for one in sensors])],
        used=used_part(worst_of(assessment.outputs)).text,
    )


def _ranked(assessment: Assessment, sensor: str) -> list[list[JudgedOutput]]:
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


def _limit_groups(
    assessment: Assessment, sensor: str, start: float, *, is_one: bool
) -> tuple[Group, ...]:
    """Return the rows of the outputs of a sensor, the worst group first.

    In `is_one` side for all sensors with the name of the sensor.
    """
    return tuple(
        Group(
            title=key_title(
                group if is_one else group.without_owner,
            ),
            said=key_title(outputs[0].output.name.group),
            rows=tuple(_limit_row(output, start) for output in outputs),
        )
        for outputs in _ranked(assessment, sensor)
        for group in [outputs[0].output.name.group]
    )


def _limit_row(output: JudgedOutput, start: float) -> Row:
    """Return a thin line to a dot, filled where it is beyond the limit."""
    x = max(100.0 * output.utilisation, start)
    used, axis = used_part(output).text, axis_title(output.output.name)
    limited = as_limited(output)
    return Row(
        label=axis,
        marks=(
            Stroke(start=start, end=x),
            Dot(
                at=x,
                fill=PAPER if output.is_within else INK,
                edge=MUTED if output.is_within else INK,
                tip=line(
                    PAGE,
                    "used_row",
                    row=output,
                    unit=limited.output.unit,
                    error=largest_error(limited).text,
                    used=used,
                ),
            ),
        ),
        beside=(used,),
        strong=not output.is_within,
        said=f"{axis} {used}",
    )


TEN = 10.0  # tolerances that are printed without decimals [1]
LEAST_REACH, LINEAR_BELOW = 1.5, 6.0  # reach of the axis, in tolerances [1]


@dataclass(frozen=True, kw_only=True)
class Check:
    """Both interval ends of one output: the law's less Monte Carlo's."""

    row: OutputBudget
    validation: Validation
    low: float  # in tolerances [1]
    high: float  # in tolerances [1]

    @property
    def worst(self) -> float:
        """The larger one in size [1]."""
        return max(abs(self.low), abs(self.high))


def validity_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show both interval ends of each output of a sensor, None where none was checked.

    The band is the tolerance of JCGM 101:2008, 8.1.
    """
    checks = _checks(budget, sensor)
    if not checks:
        return None
    said = texts(
        PAGE,
        "validity",
        checks=checks,
        sensor=sensor,
        worst=checks[first_largest([check.worst for check in checks])],
        trials=max(check.validation.trials for check in checks),
        signed=_signed,
    )
    reach = max(LEAST_REACH, 1.1 * max(check.worst for check in checks))
    is_long = reach > LINEAR_BELOW
    scale = Scale(
        low=-reach * (1.2 if is_long else 1.0),
        high=reach * (1.2 if is_long else 1.0),
        kind="symlog" if is_long else "linear",
        lines=((0.0, ""),),
        band=(-1.0, 1.0),
        label=said.label,
    )
    groups = tuple(
        Group(title=words(name), rows=tuple(map(_check_row, own)))
        for name, own in groupby(checks, key=lambda check: check.row.parameter)
    )
    return Chart(
        name=f"validity-{sensor}",
        title=said.title,
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=said.lead,
        caption=said.caption,
        data_on_paper=False,
        data=table(PAGE, "validity_data", checks=checks, sensor=sensor, signed=_signed),
    )


def _checks(budget: Budget, sensor: str) -> list[Check]:
    """Return the outputs that were checked and have a spread to be checked."""
    checks = []
    for row in budget.outputs:
        check = row.validation
        if row.sensor != sensor or check is None or not row.is_resolved:
            continue
        low, high = (
            (ours - theirs) / check.tolerance
            for ours, theirs in zip(row.interval, check.interval, strict=True)
        )
        checks.append(Check(row=row, validation=check, low=low, high=high))
    return checks


def _check_row(check: Check) -> Row:
    """Return both ends of one output; dark and named where the law does not hold."""
    said = texts(PAGE, "validity_row", check=check, signed=_signed)
    fill, edge = (PAPER, MUTED) if check.validation.holds else (INK, INK)
    return Row(
        label=check.row.axis,
        marks=(
            Stroke(start=check.low, end=check.high, colour=edge, tip=said.tip),
            Dot(at=check.low, shape="<", fill=fill, edge=edge),
            Dot(at=check.high, shape=">", fill=fill, edge=edge),
        ),
        beside=(said.beside,),
        strong=not check.validation.holds,
        said=said.said,
    )


def _signed(value: float) -> str:
    """Print a number of tolerances with its sign; hundredths of one are enough."""
    return f"{value:+.2f}" if abs(value) < TEN else f"{value:+.0f}"
