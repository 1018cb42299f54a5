"""Figures of all sources: shares of the variance, coupling, Sobol indices."""

from __future__ import annotations

from functools import partial
from itertools import accumulate
from math import fsum
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from budget.language import key_title
from budget.model.sources import SENSORS
from budget.names import IMU, LENGTHS
from budget.report.figures.rows import (
    HUNDRED,
    Bar,
    Chart,
    ChartGroup,
    ChartPanel,
    ChartRow,
    Dot,
    Head,
    Stroke,
    cells,
    rows_of,
)
from budget.report.figures.style import (
    BLUE,
    INK,
    ON_DARK,
    OTHER,
    PAPER,
    WIDE,
    WIDTH,
    Scale,
    fits,
    in_order,
    look_of,
    looks,
)
from budget.report.figures.tabled import CELL, entries, heads_of
from budget.report.pages import figure
from budget.report.tables import (
    ALL,
    SMALL_SHARE,
    full_title,
    group_tables,
    print_given,
    print_index,
    print_share,
    source_title,
)
from budget.results import widest_of_each
from budget.ties import largest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.names import Name
    from budget.report.figures.rows import ChartMark
    from budget.report.tables import GroupTable
    from budget.results import Budget, OutputBudget, SobolIndex
    from budget.studies.evidence import CouplingTable

    Part = tuple[Name, float]  # a source, and its share of a variance

PAGE = "figures_sources"
SPAN = WIDTH - 36.0  # of the whole variance at least [pt]
GROUP_SPAN = WIDE - 220.0  # of the whole variance among names of groups [pt]
VISIBLE = 0.002  # share below which a segment is thinner than a line [1]


def share_chart(group: GroupTable) -> Chart:
    """Show what contributes to each output's variance: a stacked bar for each output.

    The table of the budget has the numbers.
    """
    bars = [
        (
            row.axis,
            gathered({one.source: one.cells[k].share.exact for one in group.sources}),
        )
        for k, row in enumerate(group.rows)
    ]
    title = partial(source_title, of=group.sensor)
    first = bars[0][1]
    starts = accumulate((share for _, share in first), initial=0.0)
    heads = {
        source: Head(at=100.0 * start, text=title(source), is_centred=False)
        for start, (source, share) in zip(starts, first, strict=False)
        if source != OTHER and fits(title(source), share * SPAN)
    }
    return _stacked(
        "shares",
        bars,
        title,
        name=f"shares-{group.sensor}-{group.parameter}",
        heads=heads,
        label=lambda _, share: print_share(share),
        is_both=group.sensor == IMU,
        view={
            "group": group,
            "alone": [
                {one.source: one.cells[k].u.text for one in group.sources}
                for k in range(len(group.rows))
            ],
        },
        has_data=False,
        pitch=21.0,
    )


FEWEST, MOST_BARS = 2, 12  # bars: one says nothing that a sentence does not


def group_shares_chart(budget: Budget) -> Chart | None:
    """Show what the variance of each group of outputs is made of, a stacked bar each.

    Of a group the shares are those of the sum of its variances; of a mission each
    output has its bar, accelerometers hatched. None of one bar, or without spread.
    """
    bars = _bars(budget)[:MOST_BARS]
    if len(bars) < FEWEST:
        return None
    is_mission = all(row.output.name.time is not None for row in budget.outputs)
    title = full_title if is_mission else source_title

    def label(source: Name, share: float) -> str:
        texts = () if source == OTHER else (title(source), print_share(share))
        return next((text for text in texts if fits(text, share * GROUP_SPAN)), "")

    return _stacked(
        "group_shares",
        bars,
        title,
        name="shares",
        label=label,
        is_both=is_mission,
        pitch=19.0,
        width=WIDE,
    )


def _stacked(
    macro: str,
    bars: Sequence[tuple[str, Sequence[Part]]],
    title: Callable[[Name], str],
    *,
    name: str,
    label: Callable[[Name, float], str],
    is_both: bool,
    heads: Mapping[Name, Head] | None = None,
    view: Mapping[str, object] | None = None,
    **options: Any,  # noqa: ANN401 - of a chart
) -> Chart:
    """Stack shares in bars: each source in its look, named as `label` says, or below.

    Where a bar `is_both` triads, the second is hatched.
    """
    said, table = figure(PAGE, macro, bars=bars, title=title, **view or {})

    look = partial(look_of, is_both=is_both)
    rows = []
    for (name_of, bar), (_, own) in zip(bars, entries(table), strict=True):
        ends = accumulate((100.0 * share for _, share in bar), initial=0.0)
        marks = [
            Bar(
                start=start,
                end=start + 100.0 * share,
                colour=colour,
                hatch=hatch,
                height=15.0,
                text=label(source, share) if ink else "",
                text_colour=ink or INK,
                tip=one.tip,
            )
            for start, (source, share), one in zip(ends, bar, own, strict=False)
            for colour, hatch, ink in [look(source)]
        ]
        beside = () if bar else (said.no_spread,)
        rows.append(ChartRow(label=name_of, marks=tuple(marks), beside=beside))
    named = {mark.text for row in rows for mark in row.marks} | {
        head.text for head in (heads or {}).values()
    }
    seen = {source for _, bar in bars for source, share in bar if share >= VISIBLE}
    return Chart(
        name=name,
        title=said.title,
        panels=(
            ChartPanel(
                scale=Scale(low=0.0, high=100.0, ticks=HUNDRED, label=said.label),
                groups=(ChartGroup(rows=tuple(rows)),),
            ),
        ),
        table=table,
        heads=tuple((heads or {}).values()),
        legend=tuple(
            dict.fromkeys(
                (*look(one)[:2], said.other if one == OTHER else title(one))
                for one in in_order(seen)
                if title(one) not in named
            )
        ),
        **options,
    )


def gathered(shares: Mapping[Name, float]) -> list[tuple[Name, float]]:
    """Return shares of one variance in fixed order, those below 1 % as one."""
    bar = [
        (name, shares[name])
        for name in in_order(shares)
        if name.quantity in looks() and shares[name] >= SMALL_SHARE
    ]
    rest = fsum(shares.values()) - fsum(share for _, share in bar)
    small = any(0.0 < share < SMALL_SHARE for share in shares.values())
    return [*bar, (OTHER, rest)] if small or rest >= SMALL_SHARE else bar


def _bars(budget: Budget) -> list[tuple[str, list[Part]]]:
    """Return the bars of groups, or of the outputs of a mission, by their names."""
    if all(row.output.name.time is not None for row in budget.outputs):
        return [
            (
                key_title(row.output.name),
                gathered({part.source: part.share for part in row.contributions}),
            )
            for row in _of_mission(budget)
            if row.is_resolved
        ]
    return [
        (group.title, gathered({row.source: row.share.exact for row in group.sources}))
        for group in group_tables(budget)
        if any(row.expanded.exact > 0.0 for row in group.rows)
    ]


def _of_mission(budget: Budget) -> list[OutputBudget]:
    """Return limited outputs, else position by time, and attitude at the end."""
    if budget.assessment is not None:
        limited = {row.output.name for row in budget.assessment.outputs}
        return [row for row in budget.outputs if row.output.name in limited]
    end = max(row.output.name.time or 0.0 for row in budget.outputs)
    plane = ("position", LENGTHS["position"])
    return [
        *(row for row in budget.outputs if (row.parameter, row.axis) == plane),
        *(
            row
            for row in budget.outputs
            if row.parameter == "attitude" and row.output.name.time == end
        ),
    ]


# Opacity of the one hue by the part of u that a source makes: steps that stay apart in
# grey. Text is light on the full hue only: it can be read on all others, light or dark.
STEPS = (
    (0.1, 1.0),
    (0.01, 0.68),
    (1e-3, 0.5),
    (1e-4, 0.34),
    (1e-6, 0.21),
    (0.0, 0.11),
)
EDGES = {1e-6: "1e-6", 1e-4: "1e-4", 1e-3: "0.1 %", 0.01: "1 %", 0.1: "10 %"}
PER_CENT_FROM = 0.001  # smaller parts are written as powers of ten [1]


def coupling_chart(found: CouplingTable, sensor: str) -> Chart | None:
    """Show sources by groups of parameters, the hue by the size of what reaches.

    Of one sensor; None where nothing reaches anything.
    """
    own = [cell for cell in found.cells if cell.group.owner == sensor]
    if not any(cell.reaches for cell in own):
        return None
    groups = [group for group in found.groups if group.owner == sensor]
    reaching = [s for s in found.sources if any(one.source == s for one in own)]
    owner_of = {s: sensor if s.owner in SENSORS else s.owner for s in reaching}
    owners = sorted({*owner_of.values()}, key=[sensor, *owner_of.values()].index)
    foreign = [cell for cell in own if cell.reaches and not cell.is_own]
    said, table = figure(
        PAGE,
        "coupling",
        sensor=sensor,
        farthest=[foreign[k] for k in largest([cell.size for cell in foreign])],
        part=print_part,
        groups=groups,
        # The sensors' own need no head where no others stand below.
        owners=[
            (
                owner if len(owners) > 1 else "",
                owner,
                [
                    (s, [found.cell(s, group) for group in groups])
                    for s in in_order(reaching)
                    if owner_of[s] == owner
                ],
            )
            for owner in owners
        ],
    )
    return Chart(
        name=f"coupling-{sensor}",
        title=said.title,
        panels=(
            ChartPanel(
                scale=Scale(low=0.0, high=float(len(groups)), ticks=()),
                groups=rows_of(table, lambda at: cells(at, _reaching)),
            ),
            _hues(said.label),
        ),
        table=table,
        caption=said.caption,
        heads=tuple(
            Head(at=x + 0.5, text=text) for x, text in enumerate(heads_of(table, CELL))
        ),
        pitch=18.0,
    )


def _reaching(cell: SimpleNamespace) -> dict[str, Any] | None:
    """Return how a cell of the map looks; a frame alone where an own spread is 0."""
    if cell.exact is None:
        return (
            {"colour": "none", "is_framed": True, "text": "", "tip": ""}
            if cell.strong
            else None
        )
    opacity = next(opacity for edge, opacity in STEPS if cell.exact >= 100.0 * edge)
    return {
        "start": cell.at + 0.015,
        "end": cell.at + 0.985,
        "colour": BLUE,
        "opacity": opacity,
        "height": 16.0,
        "is_framed": cell.strong,
        "text_colour": ON_DARK if opacity == 1.0 else INK,
    }


def print_part(size: float) -> str:
    """Print a part of u in two digits: '33 %', '0.69 %', '3.1e-5', '>99 %'."""
    if size < PER_CENT_FROM:
        return f"{size:.1e}".replace("e-0", "e-")
    return f"{_per_cent(size)} %"


def _hues(label: str) -> ChartPanel:
    """Return the steps of the hue, their edges written below."""
    rising = STEPS[::-1]
    return ChartPanel(
        scale=Scale(
            low=0.0,
            high=float(len(STEPS)),
            ticks=tuple(
                (float(place), EDGES[edge])
                for place, (edge, _) in enumerate(rising)
                if place
            ),
            label=label,
        ),
        groups=(
            ChartGroup(
                rows=(
                    ChartRow(
                        label="",
                        marks=tuple(
                            Bar(
                                start=float(place),
                                end=place + 0.96,
                                colour=BLUE,
                                edge="none",
                                opacity=opacity,
                            )
                            for place, (_, opacity) in enumerate(rising)
                        ),
                    ),
                )
            ),
        ),
    )


def _per_cent(size: float) -> str:
    """Print a part in per cent; 100 stands only where nothing else counts."""
    text = print_given(100.0 * size, digits=2)
    return ">99" if text == "100" and size < ALL else text


APART = 4.0  # of the two dots of a source from the middle of its row [pt]
GAP = 0.35  # opacity of the gap between them


def sobol_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show first-order and total index of each source of a sensor, None without any.

    Of each group of parameters the output with the largest spread.
    """
    found = _widest(budget, sensor)
    if not found:
        return None
    seen = [
        (one.row, *pair)
        for one in found
        for pair in one.ranked
        if _can_be_seen(pair[1])
    ]
    gaps = [index.total - index.first for _, _, index in seen]
    said, table = figure(
        PAGE,
        "sobol",
        seen=[seen[k] for k in largest(gaps)],
        found=found,
        sensor=sensor,
        interacts=any(pair[1].interacts for one in found for pair in one.ranked),
        first=_first,
        total=_total,
        can_be_seen=_can_be_seen,
    )
    sources, indices = zip(*(pair for one in found for pair in one.ranked), strict=True)
    order = in_order(dict.fromkeys(sources))
    scale = Scale(
        low=0.0,
        high=1.0,
        ticks=tuple((float(x), x) for x in ("0", "0.25", "0.5", "0.75", "1")),
        label=said.label,
    )
    drawn = rows_of(
        table, _index_marks, sources, indices, by=lambda _, name, __: order.index(name)
    )
    return Chart(
        name=f"sobol-{sensor}",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        caption=said.caption,
        beside=(said.beside,),
        pitch=20.0,
    )


def _widest(budget: Budget, sensor: str) -> list[SimpleNamespace]:
    """Return the output of each group with the largest spread, where it has indices.

    With its sources by rank, then by total index, `ranked`, and the names of those
    whose index is `zero` to the digits that are printed.
    """
    found = []
    rows = [row for row in budget.outputs if row.sensor == sensor]
    for row in widest_of_each(
        [row for row in rows if any(part.sobol for part in row.contributions)]
    ):
        own = {p.source: p.sobol for p in row.contributions if p.sobol is not None}
        zero = [name for name in in_order(own) if float(_total(own[name])[0]) <= 0.0]
        shown = [(name, own[name]) for name in in_order(own) if name not in zero]
        shown.sort(key=lambda pair: (pair[1].rank, -pair[1].total))
        found.append(SimpleNamespace(row=row, ranked=shown, zero=zero))
    return found


def _index_marks(
    at: SimpleNamespace, source: Name, index: SobolIndex
) -> list[ChartMark]:
    """Return one source: dot above, ring below, whiskers, and the gap between."""
    colour = look_of(source)[0]
    gap = Bar(
        start=index.first,
        end=index.total,
        colour=colour,
        edge="none",
        opacity=GAP,
        height=2.0 * APART,
    )
    marks = [gap]
    for value, ends, lift, fill, tip in (
        (index.first, index.first_interval, -APART, INK, at.tip),
        (index.total, index.total_interval, APART, PAPER, ""),
    ):
        marks += [
            Stroke(start=0.0, end=value, colour=colour, width=2.0, lift=lift),
            Stroke(start=ends[0], end=ends[1], colour=INK, width=0.9, lift=lift),
            Dot(start=value, colour=fill, width=4.5, lift=lift, tip=tip),
        ]
    return marks


def _can_be_seen(index: SobolIndex) -> bool:
    """Whether an interaction is beyond chance and beyond the digits printed."""
    return index.interacts and _first(index)[0] != _total(index)[0]


def _first(index: SobolIndex) -> tuple[str, str]:
    """Print the first-order index and its interval."""
    return print_index(index.first, index.first_interval)


def _total(index: SobolIndex) -> tuple[str, str]:
    """Print the total index and its interval."""
    return print_index(index.total, index.total_interval)
