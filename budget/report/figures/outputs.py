"""Figures of all outputs: U, limits used, the law against Monte Carlo."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING

from budget.language import axis_title, key_title, say, term, words
from budget.names import MISSION
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
    UNKNOWN,
    as_limited,
    join_outputs,
    largest_error,
    print_count,
    print_coverage,
    used_part,
)
from budget.report.wording import capital, cell
from budget.results import worst_of
from budget.ties import first_largest, from_largest, largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.tables import GroupTable, OutputRow
    from budget.results import (
        Assessment,
        Budget,
        OutputAssessment,
        OutputBudget,
        Validation,
    )

ABOVE = 1.08  # reach of an axis over the largest U [1]


def overview_chart(groups: Sequence[GroupTable]) -> Chart | None:
    """Show U of each output: a panel a group, a side a sensor; None without spread."""
    if not any(row.expanded.exact > 0.0 for group in groups for row in group.rows):
        return None
    coverage = print_coverage(groups[0].coverage)
    return Chart(
        name="overview",
        title=_overview_title(groups, coverage),
        sides=tuple(
            Side(
                title=words(sensor),
                panels=tuple(_overview_panel(g) for g in groups if g.sensor == sensor),
            )
            for sensor in dict.fromkeys(group.sensor for group in groups)
        ),
        lead=say("U{coverage}. ", coverage=coverage),
        caption=say("Each group of parameters has an axis of its own, from zero."),
        foot=say(
            "U{coverage}, half the width of the {coverage} % interval",
            coverage=coverage,
        ),
        data_on_paper=False,
        data=table_of(
            [(group, row) for group in groups for row in group.rows],
            (
                Field(head=say("output"), cell=lambda one: one[1].axis),
                Field(
                    head=f"U{coverage}",
                    kind="number",
                    cell=lambda one: cell(one[1].expanded),
                ),
                Field(head="", kind="unit", cell=lambda one: one[0].unit),
            ),
            name="overview-data",
            caption=say("U{coverage} of every output", coverage=coverage),
            by=lambda one: capital(_in_unit(one[0])),
            titled=True,
        ),
    )


def _in_unit(group: GroupTable) -> str:
    """Name a group with its unit: 'gyro bias in deg/h'."""
    return say("{group} in {unit}", group=group.title, unit=group.unit)


def _overview_title(groups: Sequence[GroupTable], coverage: str) -> str:
    """State the finding: the widest bias of each sensor, or the widest output."""
    chosen = [group for group in groups if group.parameter == "bias"] or groups[:1]
    parts = [
        say("not known for the {group}", group=group.title)
        if group.widest.expanded.text == UNKNOWN
        else say(
            "{expanded} {unit} for the {group}",
            expanded=group.widest.expanded.text,
            unit=group.unit,
            group=group.title,
        )
        for group in chosen
    ]
    return say(
        "U{coverage} is {parts}", coverage=coverage, parts=say(" and ").join(parts)
    )


def _overview_panel(group: GroupTable) -> Panel:
    """Return one group on its own axis from zero."""
    largest = max(row.expanded.exact for row in group.rows)
    return Panel(
        scale=Scale(low=0.0, high=ABOVE * largest or 1.0),
        groups=(
            Group(
                title=f"{words(group.parameter)} [{group.unit}]",
                said=_in_unit(group),
                rows=tuple(_overview_row(group, row) for row in group.rows),
            ),
        ),
    )


def _overview_row(group: GroupTable, row: OutputRow) -> Row:
    """Return a line from zero to the dot of one output, and its number."""
    x, text = row.expanded.exact, row.expanded.text
    tip = say(
        "{group} {axis}: U {text} {unit}",
        group=group.title,
        axis=row.axis,
        text=text,
        unit=group.unit,
    )
    return Row(
        label=row.axis,
        marks=(Stroke(start=0.0, end=x), Dot(at=x, size=4.5, tip=tip)),
        beside=(text,),
        said=f"{row.axis} {text}",
    )


ABREAST = 2  # sensors beside each other at the most
MOST_LINEAR = 4.0  # utilisations beyond need a logarithmic axis [1]


USED = (
    Field["OutputAssessment"](
        head=term("output"), cell=lambda row: axis_title(row.output.name)
    ),
    Field["OutputAssessment"](
        head=term("largest error [% of the limit]"),
        kind="number",
        cell=lambda row: Cell(
            text=used_part(row).text.removesuffix(" %"),
            exact=100.0 * row.utilisation,
            strong=not row.is_within,
        ),
    ),
    Field["OutputAssessment"](head=term("limit"), cell=lambda row: row.printed_limit),
)


def utilisation_chart(assessment: Assessment) -> Chart:
    """Show each required output's largest error against its limit, worst first."""
    most = max(output.utilisation for output in assessment.outputs)
    is_log = most > MOST_LINEAR
    scale = Scale(
        low=1.0 if is_log else 0.0,  # what is less sits at the edge, its label is exact
        high=100.0 * max(1.05 * most, 1.2),
        kind="log" if is_log else "linear",
        lines=((100.0, say("limit")),),
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
        lead=say("Largest errors in per cent of the limit. "),
        foot=say("largest error [% of the limit]; filled: beyond it"),
        data_on_paper=False,
        data=table_of(
            [
                row
                for sensor in sensors
                for own in _ranked(assessment, sensor)
                for row in own
            ],
            USED,
            name="utilisation-data",
            caption=say("Largest error of each output in per cent of its limit"),
            by=lambda row: capital(key_title(row.output.name.group)),
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
    at = "" if assessment.chance is None else say("At the medians of predicted lines: ")
    if any(one.standing.saturates for one in sensors):
        at = say("Of sensors that read enough: ")
    elif any(one.standing.misses for one in sensors):
        at = say("On what is given: ")
    name = join_outputs([name for one in nearest for name in one.worst_outputs])
    part = say(
        "{name} at {used_part} of the limit", name=name, used_part=used_part(worst).text
    )
    total = len(assessment.outputs)
    if beyond == total == 1:
        return capital(
            say("{at}the one output exceeds its limit: {part}", at=at, part=part)
        )
    if beyond:
        return say(
            "{at}{beyond} of {total} outputs exceed their limits, most of all {part}",
            at=at,
            beyond=beyond,
            total=total,
            part=part,
        )
    open_ones = len(assessment.open_rows)
    if open_ones == total == 1:
        return say("The one output cannot be decided, lines are missing")
    if open_ones:
        return say(
            "{within} of {total} outputs are within their limits, {open_ones} cannot "
            "be decided, lines are missing",
            within=total - open_ones,
            total=total,
            open_ones=open_ones,
        )
    if total == 1:
        return capital(
            say("{at}the one output is within its limit: {part}", at=at, part=part)
        )
    return say(
        "{at}all {total} outputs stay within their limits, the nearest is {part}"
        if at
        else "All {total} outputs stay within their limits, the nearest is {part}",
        at=at,
        total=total,
        part=part,
    )


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


def _limit_row(output: OutputAssessment, start: float) -> Row:
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
                tip=say(
                    "{name}: largest error {largest_error} {unit}, {used} of "
                    "the limit {printed_limit}",
                    name=key_title(output.output.name),
                    largest_error=largest_error(limited).text,
                    unit=limited.output.unit,
                    used=used,
                    printed_limit=output.printed_limit,
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


CHECKED = (
    Field[Check](head=term("output"), cell=lambda check: check.row.axis),
    Field[Check](
        head=term("lower end [tolerances]"),
        kind="number",
        cell=lambda check: Cell(text=_signed(check.low), exact=check.low),
    ),
    Field[Check](
        head=term("upper end [tolerances]"),
        kind="number",
        cell=lambda check: Cell(text=_signed(check.high), exact=check.high),
    ),
    Field[Check](
        head=term("the law"),
        cell=lambda check: Cell(
            text=say(check.validation.word), strong=not check.validation.holds
        ),
    ),
)


def validity_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show both interval ends of each output of a sensor, None where none was checked.

    The band is the tolerance of JCGM 101:2008, 8.1.
    """
    checks = _checks(budget, sensor)
    if not checks:
        return None
    trials = print_count(max(check.validation.trials for check in checks))
    reach = max(LEAST_REACH, 1.1 * max(check.worst for check in checks))
    is_long = reach > LINEAR_BELOW
    scale = Scale(
        low=-reach * (1.2 if is_long else 1.0),
        high=reach * (1.2 if is_long else 1.0),
        kind="symlog" if is_long else "linear",
        lines=((0.0, ""),),
        band=(-1.0, 1.0),
        label=say("law less Monte Carlo [tolerances]; band: the law is confirmed"),
    )
    groups = tuple(
        Group(title=words(name), rows=tuple(map(_check_row, own)))
        for name, own in groupby(checks, key=lambda check: check.row.parameter)
    )
    return Chart(
        name=f"validity-{sensor}",
        title=_check_title(checks, sensor),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=(
            say("Lower and upper interval end, law less Monte Carlo, in tolerances. ")
        ),
        caption=(
            say(
                "Monte Carlo: {trials} trials. Triangles point to the end "
                "that they are of; in the band the law is confirmed.",
                trials=trials,
            )
        ),
        data_on_paper=False,
        data=table_of(
            checks,
            CHECKED,
            name=f"validity-{sensor}-data",
            caption=say(
                "The law less Monte Carlo for the {sensor}, in tolerances",
                sensor=words(sensor),
            ),
            by=lambda check: capital(words(check.row.parameter)),
            titled=True,
        ),
    )


def _check_title(checks: list[Check], sensor: str) -> str:
    """State the finding: for how many outputs the law holds, and the worst of them."""
    worst = checks[first_largest([check.worst for check in checks])]
    name, size = key_title(worst.row.output.name), _signed(worst.worst)[1:]
    missed = sum(not check.validation.holds for check in checks)
    part = say(
        "farthest off is {name} with a difference of {size} tolerances",
        name=name,
        size=size,
    )
    if missed:
        return say(
            "The law is not confirmed for {missed} of {checks} {sensor} outputs, "
            "{part}",
            missed=missed,
            checks=len(checks),
            sensor=words(sensor),
            part=part,
        )
    return say(
        "The law is confirmed for all {checks} {sensor} outputs, {part}",
        checks=len(checks),
        sensor=words(sensor),
        part=part,
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
    holds, word = check.validation.holds, check.validation.word
    low, high = _signed(check.low), _signed(check.high)
    size = _signed(check.worst)[1:]
    fill, edge = (PAPER, MUTED) if holds else (INK, INK)
    axis = check.row.axis
    tip = say(
        "{name}: the law {word}, lower end {low}, upper end {high} tolerances",
        name=key_title(check.row.output.name),
        word=say(word),
        low=low,
        high=high,
    )
    return Row(
        label=axis,
        marks=(
            Stroke(start=check.low, end=check.high, colour=edge, tip=tip),
            Dot(at=check.low, shape="<", fill=fill, edge=edge),
            Dot(at=check.high, shape=">", fill=fill, edge=edge),
        ),
        beside=(
            {"agrees": size, "fails": say("fails {size}", size=size)}.get(
                word, say(word)
            ),
        ),
        strong=not holds,
        said=say("{axis} {low} and {high}", axis=axis, low=low, high=high)
        + ("" if holds else say(" ({word})", word=say(word))),
    )


def _signed(value: float) -> str:
    """Print a number of tolerances with its sign; hundredths of one are enough."""
    return f"{value:+.2f}" if abs(value) < TEN else f"{value:+.0f}"
