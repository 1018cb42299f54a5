"""Figures of one output's budget, tornado and waterfall; correlation of all outputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import fsum, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.names import Name
from budget.report.figures.rows import (
    Bar,
    Chart,
    ChartPanel,
    Head,
    cells,
    rows_of,
)
from budget.report.figures.style import (
    BLUE,
    HATCH,
    INK,
    MUTED,
    ON_DARK,
    REST,
    VERMILION,
    WIDE,
    WIDTH,
    Scale,
    look_of,
    text_width,
)
from budget.report.figures.tabled import heads_of
from budget.report.pages import figure
from budget.report.tables import (
    SMALL_SHARE,
    print_coverage,
    print_decimals,
    round_value,
)
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from types import SimpleNamespace

    from budget.report.tables import GroupTable, OutputRow, SourceRow
    from budget.results import Assessment, Budget, JudgedOutput

PAGE = "figures_contributions"
FEWEST = 2  # sources: one bar alone says nothing that a sentence does not
MOST_ROWS = 7  # sources that have a row of their own
PITCH = 14.0  # from row to row [pt]
BAR = 11.0  # height of a bar [pt]
AIR = 1.06  # reach of an axis over the longest bar [1]


@dataclass(frozen=True, kw_only=True)
class Critical:
    """The output of a group that uses most of its limit, or else has the largest U."""

    group: GroupTable
    place: int
    limit: JudgedOutput | None  # what it is held against

    @classmethod
    def of(cls, group: GroupTable, assessment: Assessment | None) -> Critical:
        """Choose it; of equal ones the first."""
        of = Name(group.parameter, owner=group.sensor)
        rows = assessment.outputs if assessment else ()
        limits = {
            one.output.name.axis: one for one in rows if one.output.name.group == of
        }
        sizes = [row.expanded.exact for row in group.rows]
        if limits:
            judged = [limits.get(row.axis) for row in group.rows]
            sizes = [one.utilisation if one else 0.0 for one in judged]
        place = first_largest(sizes)
        return cls(group=group, place=place, limit=limits.get(group.rows[place].axis))

    @property
    def row(self) -> OutputRow:
        """Its numbers."""
        return self.group.rows[self.place]

    @property
    def title(self) -> str:
        """'gyro bias z'."""
        return f"{self.group.title} {self.row.axis}"

    @property
    def sources(self) -> list[SourceRow]:
        """Those that can be seen, its largest first."""
        least, at = SMALL_SHARE / 10.0, self.place
        shown = [
            row for row in self.group.sources if row.cells[at].share.exact >= least
        ]
        shown.sort(key=lambda row: -settle(row.cells[at].u.exact))
        return shown[:MOST_ROWS]


def tornado_chart(critical: Critical) -> Chart | None:
    """Show what one standard uncertainty of each source moves the output by.

    None of fewer than two. The budget table has the numbers.
    """
    place = critical.place
    pairs = [  # products of two sources have no c
        (one, part.linear or part.u)
        for one in critical.sources
        for part in [one.cells[place]]
    ]
    pairs = [pair for pair in pairs if pair[1].exact > 0.0]
    pairs.sort(key=lambda pair: -settle(pair[1].exact))
    if len(pairs) < FEWEST:
        return None
    said, table = figure(PAGE, "tornado", critical=critical, pairs=pairs)
    most = AIR * pairs[0][1].exact
    scale = Scale(low=-most, high=most, lines=((0.0, ""),), label=said.axis)
    drawn = rows_of(
        table,
        lambda at, look: [
            Bar(
                start=-at.u,
                end=at.u,
                tip=at.tip,
                colour=look[0],
                hatch=look[1],
                height=BAR,
            )
        ],
        [look_of(source.source) for source, _ in pairs],
    )
    return Chart(
        name=f"tornado-{critical.group.sensor}-{critical.group.parameter}",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        beside=heads_of(table),
        pitch=PITCH,
    )


def waterfall_chart(critical: Critical) -> Chart | None:
    """Show how the square of U grows source by source: squares alone add up.

    From the largest down, by k and u of the law; what an interval of trials differs
    from that by is a step of its own. Then the mean error, where there is one: the
    middle of the interval. None of fewer than two steps.
    """
    row, place = critical.row, critical.place
    if not critical.sources or row.law_k is None:
        return None
    every, own = (
        [one.cells[place].u.exact ** 2 for one in sources]
        for sources in (critical.group.sources, critical.sources)
    )
    ends = [
        (one.title, row.law_k * sqrt(fsum(own[: k + 1])), look_of(one.source))
        for k, one in enumerate(critical.sources)
    ]
    whole, mean = row.expanded.exact, abs(row.low.exact + row.high.exact) / 2.0
    if len(own) < sum(not source.is_idle for source in critical.group.sources):
        ends.append(("others", row.law_k * sqrt(fsum(every)), (MUTED, "", "")))
    if row.by:
        ends.append(("trials", whole, (MUTED, HATCH, "")))
    if len(ends) < FEWEST:
        return None
    starts = [0.0, *(end for _, end, _ in ends)]
    steps = [*zip(starts, ends, strict=False), (0.0, ("total", whole, (INK, "", "")))]
    largest = max(abs(row.low.exact), abs(row.high.exact))
    if float(round_value(mean, row.u.exact)) != 0.0:
        steps += [
            (whole, ("mean", whole + mean, (REST, HATCH, ""))),
            (0.0, ("largest", largest, (INK, "", ""))),
        ]
    said, table = figure(
        PAGE,
        "steps",
        critical=critical,
        coverage=print_coverage(critical.group.coverage),
        steps=[
            (title, start**2, end**2, round_value(end, row.u.exact))
            for start, (title, end, _) in steps
        ],
    )
    held = critical.limit
    limits = [held.limit / held.output.si_per_unit] if held else []
    scale = Scale(
        low=0.0,
        high=AIR * max(largest, whole, *limits) ** 2,
        lines=tuple((limit**2, said.limit) for limit in limits),
        label=said.axis,
    )
    drawn = rows_of(
        table,
        lambda at, look: [
            Bar(start=at.start, end=at.end, colour=look[0], hatch=look[1], height=BAR)
        ],
        [look for _, (*_, look) in steps],
    )
    return Chart(
        name=f"steps-{critical.group.sensor}-{critical.group.parameter}",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        pitch=PITCH,
    )


SEEN = 0.2  # correlation below which nothing is drawn [1]
COLUMN = 26.0  # width of a column of the map [pt]
# Opacity by the size of a correlation [1].
STEPS = ((0.75, 1.0), (0.5, 0.72), (SEEN, 0.5))


def correlated(budget: Budget) -> list[int]:
    """Return the places of the outputs that are correlated with another one."""
    r = np.abs(budget.correlation - np.diag(np.diag(budget.correlation)))
    return [k for k in range(len(r)) if r[k].max(initial=0.0) >= SEEN]


def correlation_chart(budget: Budget) -> Chart | None:
    """Show the correlation of the outputs that have one; None where none has."""
    places = correlated(budget)
    if not places:
        return None
    r = 100.0 * budget.correlation[places][:, places]
    np.fill_diagonal(r, 0.0)
    view = {"r": r.tolist(), "names": [budget.outputs[k].output.name for k in places]}
    view |= {"seen": 100.0 * SEEN, "print": partial(print_decimals, decimals=0)}
    most = np.unravel_index(first_largest(np.abs(r).ravel().tolist()), r.shape)
    said, table = figure(PAGE, "correlation", most=[*map(int, most)], **view)
    drawn = rows_of(table, lambda at: cells(at, _correlated))
    left = max(text_width(row.label, 9.0) for row in drawn[0].rows) + 24.0
    return Chart(
        name="correlation",
        title=said.title,
        panels=(
            ChartPanel(
                scale=Scale(low=0.0, high=float(len(places)), ticks=()), groups=drawn
            ),
        ),
        table=figure(PAGE, "correlated", **view)[1],
        caption=said.caption,
        heads=tuple(Head(at=k + 0.5, text=str(k + 1)) for k in range(len(places))),
        pitch=15.0,
        width=WIDTH if left + COLUMN * len(places) <= WIDTH else WIDE,
    )


def _correlated(cell: SimpleNamespace) -> dict[str, Any] | None:
    """Return how a cell of the map looks; None below what is drawn."""
    r = (cell.exact or 0.0) / 100.0
    opacity = next((opacity for edge, opacity in STEPS if abs(r) >= edge), 0.0)
    return (
        None
        if not opacity
        else {
            "colour": BLUE if r > 0.0 else VERMILION,
            "opacity": opacity,
            "height": 13.0,
            "text_colour": ON_DARK if opacity == 1.0 else INK,
        }
    )
