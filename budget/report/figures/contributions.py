"""Figures of one output's budget, tornado and waterfall; correlation of all outputs."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.language import key_title, say
from budget.report.blocks import Cell, Field, table_of
from budget.report.figures.rows import Bar, Chart, Group, Head, Panel, Row, Scale, Side
from budget.report.figures.style import (
    BLUE,
    GRID,
    HATCH,
    INK,
    MUTED,
    ON_DARK,
    VERMILION,
    WIDE,
    WIDTH,
    look_of,
    text_width,
)
from budget.report.tables import (
    PER_CENT,
    SMALL_SHARE,
    UNKNOWN,
    print_coverage,
    print_decimals,
    print_utilisation,
    round_value,
)
from budget.report.wording import capital
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.names import Name
    from budget.report.tables import GroupTable, Number, OutputRow, SourceRow
    from budget.results import Assessment, Budget

MOST_ROWS = 7  # sources that have a row of their own
PITCH = 14.0  # from row to row [pt]
AIR = 1.06  # reach of an axis over the longest bar [1]


@dataclass(frozen=True, kw_only=True)
class Limit:
    """What an output is held against."""

    at: float  # [unit of the group]
    printed: str
    used: float  # part of it that the output takes [1]


@dataclass(frozen=True, kw_only=True)
class Critical:
    """The output of a group that uses most of its limit, or else has the largest U."""

    group: GroupTable
    place: int
    limit: Limit | None

    @classmethod
    def of(cls, group: GroupTable, assessment: Assessment | None) -> Critical:
        """Choose it; of equal ones the first."""
        limits: dict[str, Limit] = {}
        for one in assessment.outputs if assessment else ():
            name = one.output.name
            if (name.owner, name.quantity) == (group.sensor, group.parameter):
                limits[name.axis] = Limit(
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

    None without spread. The budget table has the numbers.
    """
    group, place = critical.group, critical.place

    def linear(source: SourceRow) -> Number:
        part = source.cells[place]
        return part.linear or part.u  # products of two sources have no c

    sources = [one for one in critical.sources if linear(one).exact > 0.0]
    sources.sort(key=lambda one: -settle(linear(one).exact))
    if not sources:
        return None
    rows = []
    for source in sources:
        moved = linear(source)
        u = moved.exact
        colour, hatch, _ = look_of(source.source)
        said = f"\N{PLUS-MINUS SIGN}{moved.text} {group.unit}"
        tip = say(
            "{source} moves the {critical} by {said}",
            source=source.title,
            critical=critical.title,
            said=said,
        )
        bar = Bar(start=-u, end=u, colour=colour, hatch=hatch, height=11.0, tip=tip)
        share = source.cells[place].share.text
        rows.append(
            Row(
                label=source.title,
                marks=(bar,),
                beside=(f"\N{PLUS-MINUS SIGN}{moved.text}", share),
                said=say(
                    "{source} {said} ({share} of the variance)",
                    source=source.title,
                    said=said,
                    share=share,
                ),
            )
        )
    most = AIR * linear(sources[0]).exact
    first = sources[0]
    return Chart(
        name=f"tornado-{group.sensor}-{group.parameter}",
        title=(
            say(
                "{critical}: {first} ±{u} {unit}",
                critical=capital(critical.title),
                first=first.title,
                u=linear(first).text,
                unit=group.unit,
            )
        ),
        sides=_one_side(
            Scale(
                low=-most,
                high=most,
                lines=((0.0, ""),),
                label=say("error for ±u of one source [{unit}]", unit=group.unit),
            ),
            rows,
        ),
        lead=say(
            "Error of the {critical} for one u of each source: ",
            critical=critical.title,
        ),
        beside=("c u(x)", say("share")),
        pitch=PITCH,
    )


def waterfall_chart(critical: Critical) -> Chart | None:
    """Show how U grows source by source, by the root of the sum of squares.

    From the largest down, by k and u of the law; what an interval of trials differs
    from that by is a step of its own. Then the mean error, where there is one: the
    middle of the interval. None without spread.
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
        rows.append(_step(say("all others"), reached, by_law, u, (MUTED, "", "")))
        reached = by_law
    if row.by:
        look = (MUTED, HATCH, "")
        rows.append(_step(say("trials in place of the law"), reached, whole, u, look))
    head = f"U{coverage}" if row.by else f"U{coverage} = k u"
    rows.append(_total(head, whole, row.expanded.text))
    mean = abs(row.low.exact + row.high.exact) / 2.0
    has_mean = float(round_value(mean, u)) != 0.0
    largest = max(abs(row.low.exact), abs(row.high.exact))
    if has_mean:
        label = say("mean error")
        if row.by and not row.is_centred:
            label = say("middle of the interval")
        rows.append(_step(label, whole, whole + mean, u, (GRID, HATCH, "")))
        text = row.low.text if abs(row.low.exact) > row.high.exact else row.high.text
        rows.append(_total(say("largest error"), largest, text.lstrip("-")))
    limit = critical.limit
    most = max(largest, whole, limit.at if limit else 0.0)
    return Chart(
        name=f"steps-{group.sensor}-{group.parameter}",
        title=_waterfall_title(critical, coverage),
        sides=_one_side(
            Scale(
                low=0.0,
                high=AIR * most,
                lines=((limit.at, say("limit {limit}", limit=limit.printed)),)
                if limit
                else (),
                label=say(
                    "U{coverage}, sources added one by one [{unit}]",
                    coverage=coverage,
                    unit=group.unit,
                ),
            ),
            rows,
        ),
        lead=say(
            "U{coverage} of the {critical} with each source added: ",
            coverage=coverage,
            critical=critical.title,
        ),
        pitch=PITCH,
    )


def _waterfall_title(critical: Critical, coverage: str) -> str:
    """State the finding: how large U is, and how much of the limit is used."""
    row, unit = critical.row, critical.group.unit
    whole = say(
        "{critical}: U{coverage} {expanded} {unit}",
        critical=capital(critical.title),
        coverage=coverage,
        expanded=row.expanded.text,
        unit=unit,
    )
    if critical.limit is None or row.expanded.text == UNKNOWN:
        return whole
    used = print_utilisation(critical.limit.used)
    return say("{whole}, {used} of the limit", whole=whole, used=used)


def _step(
    label: str, start: float, end: float, u: float, look: tuple[str, str, str]
) -> Row:
    """Return what one source adds to those above it."""
    text = round_value(end, u)
    return Row(
        label=label,
        marks=(Bar(start=start, end=end, colour=look[0], hatch=look[1], height=11.0),),
        beside=(text,),
        said=f"{label} {text}",
    )


def _total(label: str, end: float, text: str) -> Row:
    """Return what all come to."""
    return Row(
        label=label,
        marks=(Bar(start=0.0, end=end, colour=INK, height=11.0),),
        beside=(text,),
        strong=True,
        said=f"{label} {text}",
    )


def _one_side(scale: Scale, rows: Sequence[Row]) -> tuple[Side, ...]:
    """Return rows on one scale."""
    return (Side(panels=(Panel(scale=scale, groups=(Group(rows=tuple(rows)),)),)),)


SEEN = 0.01  # correlation below which nothing is drawn [1]
CELL = 26.0  # width of a column of the map [pt]
# Opacity by the size of a correlation [1].
STEPS = ((0.75, 1.0), (0.5, 0.72), (0.25, 0.5), (0.1, 0.34), (SEEN, 0.18))


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
            said=_said(
                name, [(names[x], float(r[k, places[x]])) for x in range(number)]
            ),
        )
        for number, (k, name) in enumerate(zip(places, names, strict=True), start=1)
    ]
    left = max(text_width(row.label, 9.0) for row in rows) + 24.0
    width = WIDTH if left + CELL * len(places) <= WIDTH else WIDE
    return Chart(
        name="correlation",
        title=_correlation_title(r, budget),
        sides=_one_side(Scale(low=0.0, high=float(len(places)), ticks=()), rows),
        lead=say("Correlation of outputs. "),
        caption=(
            say(
                "Correlation coefficient in per cent; blue above 0, red below. "
                "Empty below 1 %. Columns have the numbers of the rows."
            )
        ),
        heads=tuple(Head(at=x + 0.5, text=str(x + 1)) for x in range(len(places))),
        pitch=15.0,
        width=width,
        data_on_paper=False,
        data=table_of(
            [
                (names[x], names[y], float(r[places[x], places[y]]))
                for x in range(len(places))
                for y in range(x)
                if abs(r[places[x], places[y]]) >= SEEN
            ],
            (
                Field(head=say("output"), cell=lambda one: key_title(one[0])),
                Field(head=say("with"), cell=lambda one: key_title(one[1])),
                Field(
                    head=say("correlation [%]"),
                    kind="number",
                    cell=lambda one: Cell(text=_per_cent(one[2]), exact=one[2]),
                ),
            ),
            name="correlation-data",
            caption=say("Correlation coefficients of outputs"),
        ),
    )


def _correlation_title(r: np.ndarray, budget: Budget) -> str:
    """State the finding: the two outputs that go together most."""
    size = np.abs(r)
    first, second = np.unravel_index(first_largest(size.ravel().tolist()), r.shape)
    names = (budget.outputs[k].output.name for k in (first, second))
    one, other = map(key_title, names)
    return say(
        "{one} and {other} correlate most: {per_cent} %",
        one=capital(one),
        other=other,
        per_cent=_per_cent(float(r[first, second])),
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
        text_colour=ON_DARK if opacity == 1.0 and r > 0.0 else INK,
        tip=say(
            "{one} with {other}: {per_cent} %",
            one=key_title(one),
            other=key_title(other),
            per_cent=_per_cent(r),
        ),
    )


def _said(name: Name, others: Sequence[tuple[Name, float]]) -> str:
    """Say what one output is correlated with, of those before it."""
    seen = [f"{key_title(o)} {_per_cent(r)} %" for o, r in others if abs(r) >= SEEN]
    return (
        say("{name} with {seen}", name=key_title(name), seen=say(", ").join(seen))
        if seen
        else ""
    )


def _per_cent(r: float) -> str:
    """Print a correlation in whole per cent."""
    return print_decimals(PER_CENT * r, 0)
