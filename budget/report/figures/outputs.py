"""Figures of all outputs: U, limits used, the law against Monte Carlo."""

from __future__ import annotations

from itertools import groupby
from types import SimpleNamespace
from typing import TYPE_CHECKING

import numpy as np

from budget.language import axis_title, words
from budget.names import MISSION
from budget.report.figures.rows import Chart, ChartPanel, Dot, Stroke, rows_of
from budget.report.figures.style import INK, MUTED, PAPER, Scale
from budget.report.pages import figure
from budget.report.tables import used_part
from budget.results import worst_of
from budget.ties import first_largest, from_largest, largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.tables import GroupTable
    from budget.results import (
        Assessment,
        Budget,
        JudgedOutput,
    )

PAGE = "figures_outputs"
ABOVE = 1.08  # reach of an axis over the largest U [1]


def overview_chart(groups: Sequence[GroupTable]) -> Chart | None:
    """Show U of each output: a panel a group, a side a sensor; None without spread."""
    if not any(row.expanded.exact > 0.0 for group in groups for row in group.rows):
        return None
    said, table = figure(PAGE, "overview", groups=groups)
    drawn = rows_of(
        table,
        lambda at: (
            Stroke(start=0.0, end=at.u),
            Dot(start=at.u, width=4.5, tip=at.tip),
        ),
    )
    return Chart(
        name="overview",
        title=said.title,
        panels=tuple(
            ChartPanel(
                side=words(group.sensor),
                scale=Scale(low=0.0, high=ABOVE * group.widest.expanded.exact or 1.0),
                groups=(own,),
            )
            for group, own in zip(groups, drawn, strict=True)
        ),
        table=table,
        caption=said.caption,
        foot=said.foot,
    )


ABREAST = 2  # sensors beside each other at the most
MOST_LINEAR = 4.0  # utilisations beyond need a logarithmic axis [1]


def utilisation_chart(assessment: Assessment) -> Chart:
    """Show each required output's largest error against its limit, worst first."""
    most = max(output.utilisation for output in assessment.outputs)
    is_log = most > MOST_LINEAR
    low = 1.0 if is_log else 0.0  # what is less sits at the edge, its label is exact
    ranked = [
        (sensor, own)
        for sensor in dict.fromkeys(row.output.name.owner for row in assessment.outputs)
        for own in _ranked(assessment, sensor)
    ]
    sensors = dict.fromkeys(sensor for sensor, _ in ranked)
    # Names of a mission are long: beside another side there is no room for them.
    is_one = MISSION in sensors or len(sensors) > ABREAST
    judged = assessment.sensors
    said, table = figure(
        PAGE,
        "used",
        assessment=assessment,
        nearest=[judged[k] for k in largest([one.utilisation for one in judged])],
        worst=used_part(worst_of(assessment.outputs)).text,
        is_log=is_log,
        groups=[
            (
                own[0].output.name.group
                if is_one
                else own[0].output.name.group.without_owner,
                own,
            )
            for _, own in ranked
        ],
        axis=axis_title,
        used=used_part,
    )
    drawn = rows_of(
        table,
        lambda at: (
            Stroke(start=low, end=max(at.used, low)),
            Dot(
                start=max(at.used, low),
                colour=INK if at.strong else PAPER,
                edge=INK if at.strong else MUTED,
                tip=at.tip,
            ),
        ),
    )
    scale = Scale(
        low=low,
        high=100.0 * max(1.05 * most, 1.2),
        kind="log" if is_log else "linear",
        lines=((100.0, said.limit),),
    )
    return Chart(
        name="utilisation",
        title=said.title,
        panels=tuple(
            ChartPanel(
                side="" if is_one else words(sensor),
                scale=scale,
                groups=tuple(
                    group
                    for group, (of, _) in zip(drawn, ranked, strict=True)
                    if is_one or of == sensor
                ),
            )
            for sensor in list(sensors)[: 1 if is_one else None]
        ),
        table=table,
        foot=said.foot,
    )


def _ranked(assessment: Assessment, sensor: str) -> list[list[JudgedOutput]]:
    """Return the outputs of a sensor by parameter, the worst group first.

    Axes keep their order, which noise would change otherwise.
    """
    own = [row for row in assessment.outputs if row.output.name.owner == sensor]
    groups = [
        list(rows) for _, rows in groupby(own, key=lambda row: row.output.name.group)
    ]
    worst = [worst_of(outputs).utilisation for outputs in groups]
    return [groups[k] for k in from_largest(worst)]


TEN = 10.0  # tolerances that are printed without decimals [1]
LEAST_REACH, LINEAR_BELOW = 1.5, 6.0  # reach of the axis, in tolerances [1]


def validity_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show both interval ends of each output of a sensor, None where none was checked.

    The band is the tolerance of JCGM 101:2008, 8.1.
    """
    checks = _checks(budget, sensor)
    if not checks:
        return None
    said, table = figure(
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
    drawn = rows_of(
        table,
        lambda at: (
            Stroke(
                start=at.low,
                end=at.high,
                colour=INK if at.strong else MUTED,
                tip=at.tip,
            ),
            *(
                Dot(
                    start=end,
                    shape=shape,
                    colour=INK if at.strong else PAPER,
                    edge=INK if at.strong else MUTED,
                )
                for end, shape in ((at.low, "<"), (at.high, ">"))
            ),
        ),
    )
    return Chart(
        name=f"validity-{sensor}",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        caption=said.caption,
    )


def _checks(budget: Budget, sensor: str) -> list[SimpleNamespace]:
    """Return the outputs that were checked and have a spread to be checked.

    With both interval ends, the law's less Monte Carlo's, in tolerances [1].
    """
    return [
        SimpleNamespace(row=row, validation=check, low=low, high=high, worst=worst)
        for row in budget.outputs
        if row.sensor == sensor and row.is_resolved
        for check in [row.validation]
        if check is not None
        for low, high in [(np.array(row.interval) - check.interval) / check.tolerance]
        for worst in [max(abs(low), abs(high))]
    ]


def _signed(value: float) -> str:
    """Print a number of tolerances with its sign; hundredths of one are enough."""
    return f"{value:+.2f}" if abs(value) < TEN else f"{value:+.0f}"
