"""Figures of one output's budget, tornado and waterfall; correlation of all outputs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import fsum, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.language import key_title
from budget.report.figures.rows import Bar, Chart, Group, Head, Panel, Row, Scale, Side
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
    look_of,
    text_width,
)
from budget.report.pages import blocks, line
from budget.report.tables import (
    PER_CENT,
    SMALL_SHARE,
    print_coverage,
    print_decimals,
    round_value,
)
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.names import Name
    from budget.report.tables import GroupTable, Number, OutputRow, SourceRow
    from budget.results import Assessment, Budget

FEWEST = 2  # sources: one bar alone says nothing that a sentence does not
MOST_ROWS = 7  # sources that have a row of their own
PITCH = 14.0  # from row to row [pt]
AIR = 1.06  # reach of an axis over the longest bar [1]
said = partial(line, "figures_contributions")


@dataclass(frozen=True, kw_only=True)
class OutputLimit:
    """What an output is held against."""

    at: float  # [unit of the group]
    printed: str
    used: float  # part of it that the output takes [1]


@dataclass(frozen=True, kw_only=True)
class Critical:
    """The output of a group that uses most of its limit, or else has the largest U."""

    group: GroupTable
    place: int
    limit: OutputLimit | None

    @classmethod
    def of(cls, group: GroupTable, assessment: Assessment | None) -> Critical:
        """Choose it; of equal ones the first."""
        limits: dict[str, OutputLimit] = {}
        for one in assessment.outputs if assessment else ():
            name = one.output.name
            if (name.owner, name.quantity) == (group.sensor, group.parameter):
                limits[name.axis] = OutputLimit(
                    at=one.limit / one.output.si_per_unit,
                    printed=one.printed_limit,
                    used=one.utilisation,
                )
        sizes = [
            limits[row.axis].used if row.axis in limits else 0.0 for row in group.rows
        ]
        if not limits:
            sizes = [row.expanded.exact for row in group.rows]
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
        shown = [
            row
            for row in self.group.sources
            if row.cells[self.place].share.exact >= SMALL_SHARE / 10.0
        ]
        shown.sort(key=lambda row: -settle(row.cells[self.place].u.exact))
        return shown[:MOST_ROWS]


def tornado_chart(critical: Critical) -> Chart | None:
    """Show what one standard uncertainty of each source moves the output by.

    None of fewer than two. The budget table has the numbers.
    """
    group, place = critical.group, critical.place

    def linear(source: SourceRow) -> Number:
        part = source.cells[place]
        return part.linear or part.u  # products of two sources have no c

    sources = [one for one in critical.sources if linear(one).exact > 0.0]
    sources.sort(key=lambda one: -settle(linear(one).exact))
    if len(sources) < FEWEST:
        return None
    rows = []
    for source in sources:
        moved = linear(source)
        colour, hatch, _ = look_of(source.source)
        view = {"critical": critical, "source": source, "moved": moved}
        bar = Bar(
            start=-moved.exact,
            end=moved.exact,
            colour=colour,
            hatch=hatch,
            height=11.0,
            tip=said("tornado_tip", **view),
        )
        rows.append(
            Row(
                label=source.title,
                marks=(bar,),
                beside=(
                    f"\N{PLUS-MINUS SIGN}{moved.text}",
                    source.cells[place].share.text,
                ),
                said=said("tornado_said", **view),
            )
        )
    first = sources[0]
    moved = linear(first)
    most = AIR * moved.exact
    return Chart(
        name=f"tornado-{group.sensor}-{group.parameter}",
        title=said("tornado_title", critical=critical, source=first, moved=moved),
        sides=_one_side(
            Scale(
                low=-most,
                high=most,
                lines=((0.0, ""),),
                label=said("tornado_axis", unit=group.unit),
            ),
            rows,
        ),
        lead=said("tornado_lead", critical=critical),
        beside=("c u(x)", said("share")),
        pitch=PITCH,
    )


def waterfall_chart(critical: Critical) -> Chart | None:
    """Show how the square of U grows source by source: squares alone add up.

    From the largest down, by k and u of the law; what an interval of trials differs
    from that by is a step of its own. Then the mean error, where there is one: the
    middle of the interval. None of fewer than two steps.
    """
    group, place, row = critical.group, critical.place, critical.row
    sources = critical.sources
    if not sources or row.law_k is None:
        return None
    k, u = row.law_k, row.u.exact
    coverage = print_coverage(group.coverage)
    reached = 0.0
    rows = []
    squares: list[float] = []
    for source in sources:
        squares.append(source.cells[place].u.exact ** 2)
        after = k * sqrt(fsum(squares))
        rows.append(_step(source.title, reached, after, u, look_of(source.source)))
        reached = after
    whole = row.expanded.exact
    if len(sources) < sum(not source.is_idle for source in group.sources):
        by_law = k * sqrt(fsum(one.cells[place].u.exact ** 2 for one in group.sources))
        rows.append(_step(said("others"), reached, by_law, u, (MUTED, "", "")))
        reached = by_law
    if row.by:
        look = (MUTED, HATCH, "")
        rows.append(_step(said("trials"), reached, whole, u, look))
    if len(rows) < FEWEST:
        return None
    head = f"U{coverage}" if row.by else f"U{coverage} = k u"
    rows.append(_total(head, whole, row.expanded.text))
    mean = abs(row.low.exact + row.high.exact) / 2.0
    has_mean = float(round_value(mean, u)) != 0.0
    largest = max(abs(row.low.exact), abs(row.high.exact))
    if has_mean:
        label = said("mean", row=row)
        rows.append(_step(label, whole, whole + mean, u, (REST, HATCH, "")))
        text = row.low.text if abs(row.low.exact) > row.high.exact else row.high.text
        rows.append(_total(said("largest"), largest, text.lstrip("-")))
    limit = critical.limit
    most = max(largest, whole, limit.at if limit else 0.0)
    return Chart(
        name=f"steps-{group.sensor}-{group.parameter}",
        title=said("steps_title", critical=critical, coverage=coverage),
        sides=_one_side(
            Scale(
                low=0.0,
                high=AIR * most**2,
                lines=((limit.at**2, said("limit", limit=limit)),) if limit else (),
                label=said("steps_axis", coverage=coverage, unit=group.unit),
            ),
            rows,
        ),
        lead=said("steps_lead", coverage=coverage, critical=critical),
        pitch=PITCH,
    )


def _step(
    label: str, start: float, end: float, u: float, look: tuple[str, str, str]
) -> Row:
    """Return what one source adds to those above it, from U to U, drawn squared."""
    text = round_value(end, u)
    return Row(
        label=label,
        marks=(
            Bar(
                start=start**2,
                end=end**2,
                colour=look[0],
                hatch=look[1],
                height=11.0,
            ),
        ),
        beside=(text,),
        said=f"{label} {text}",
    )


def _total(label: str, end: float, text: str) -> Row:
    """Return what all come to."""
    return Row(
        label=label,
        marks=(Bar(start=0.0, end=end**2, colour=INK, height=11.0),),
        beside=(text,),
        strong=True,
        said=f"{label} {text}",
    )


def _one_side(scale: Scale, rows: Sequence[Row]) -> tuple[Side, ...]:
    """Return rows on one scale."""
    return (Side(panels=(Panel(scale=scale, groups=(Group(rows=tuple(rows)),)),)),)


SEEN = 0.2  # correlation below which nothing is drawn [1]
CELL = 26.0  # width of a column of the map [pt]
# Opacity by the size of a correlation [1].
STEPS = ((0.75, 1.0), (0.5, 0.72), (SEEN, 0.5))


def correlated(budget: Budget) -> list[int]:
    """Return the places of the outputs that are correlated with another one."""
    r = _off_diagonal(budget)
    return [k for k in range(len(r)) if np.abs(r[k]).max(initial=0.0) >= SEEN]


def _off_diagonal(budget: Budget) -> np.ndarray:
    """Return the correlations of outputs with others, their own taken out."""
    r = budget.correlation.copy()
    np.fill_diagonal(r, 0.0)
    return r


def correlation_chart(budget: Budget) -> Chart | None:
    """Show the correlation of the outputs that have one; None where none has."""
    places = correlated(budget)
    if not places:
        return None
    r = _off_diagonal(budget)
    names = [budget.outputs[k].output.name for k in places]
    rows = [
        Row(
            label=f"{number}  {key_title(name)}",
            marks=tuple(
                _cell(x, float(r[k, other]), names[number - 1], names[x])
                for x, other in enumerate(places)
                if abs(r[k, other]) >= SEEN
            ),
            said=said(
                "correlation_said",
                name=name,
                seen=[
                    (names[x], _per_cent(r[k, places[x]]))
                    for x in range(number)
                    if abs(r[k, places[x]]) >= SEEN
                ],
            ),
        )
        for number, (k, name) in enumerate(zip(places, names, strict=True), start=1)
    ]
    left = max(text_width(row.label, 9.0) for row in rows) + 24.0
    width = WIDTH if left + CELL * len(places) <= WIDTH else WIDE
    pairs = [
        (names[x], names[y], _per_cent(r[k, places[y]]), r[k, places[y]])
        for x, k in enumerate(places)
        for y in range(x)
        if abs(r[k, places[y]]) >= SEEN
    ]
    data: Any = blocks("figures_contributions", "correlation_data", pairs=pairs)[0]
    return Chart(
        name="correlation",
        title=_correlation_title(r, budget),
        sides=_one_side(Scale(low=0.0, high=float(len(places)), ticks=()), rows),
        lead=said("correlation_lead"),
        caption=said("correlation_caption"),
        heads=tuple(Head(at=x + 0.5, text=str(x + 1)) for x in range(len(places))),
        pitch=15.0,
        width=width,
        data_on_paper=False,
        data=data,
    )


def _correlation_title(r: np.ndarray, budget: Budget) -> str:
    """State the finding: the two outputs that go together most."""
    size = np.abs(r)
    first, second = np.unravel_index(first_largest(size.ravel().tolist()), r.shape)
    return said(
        "correlation_title",
        one=budget.outputs[first].output.name,
        other=budget.outputs[second].output.name,
        r=_per_cent(r[first, second]),
    )


def _cell(x: int, r: float, one: Name, other: Name) -> Bar:
    """Return one cell of the map."""
    opacity = next(opacity for edge, opacity in STEPS if abs(r) >= edge)
    return Bar(
        start=x + 0.02,
        end=x + 0.98,
        colour=BLUE if r > 0.0 else VERMILION,
        edge="none",
        opacity=opacity,
        height=13.0,
        text=_per_cent(r),
        text_colour=ON_DARK if opacity == 1.0 else INK,
        tip=said("correlation_tip", one=one, other=other, r=_per_cent(r)),
    )


def _per_cent(r: float) -> str:
    """Print a correlation in whole per cent."""
    return print_decimals(PER_CENT * r, 0)
