"""Figures of all sources: shares of the variance, coupling, Sobol indices."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum
from typing import TYPE_CHECKING

from budget.language import key_title, words
from budget.model.source import ACCELEROMETER
from budget.model.sources import SENSORS
from budget.names import IMU, LENGTHS
from budget.report.figures.rows import (
    Bar,
    Chart,
    Dot,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
    Stroke,
)
from budget.report.figures.style import (
    BLUE,
    HATCH,
    INK,
    ON_DARK,
    OTHER,
    PAPER,
    WIDE,
    WIDTH,
    fits,
    in_order,
    look_of,
    looks,
)
from budget.report.pages import line, table, texts
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
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from budget.names import Name
    from budget.report.figures.rows import Mark
    from budget.report.tables import GroupTable
    from budget.results import Budget, OutputBudget, SobolIndex
    from budget.studies.coupling import Coupling, CouplingTable

PAGE = "figures_sources"
SPAN = WIDTH - 36.0  # of the whole variance at least [pt]
GROUP_SPAN = WIDE - 220.0  # of the whole variance among names of groups [pt]
VISIBLE = 0.002  # share below which a segment is thinner than a line [1]


def share_chart(group: GroupTable) -> Chart:
    """Show what contributes to each output's variance: a stacked bar for each output.

    The table of the budget has the numbers.
    """
    said = texts(PAGE, "shares", group=group)
    bars = [_segments(group, place) for place in range(len(group.rows))]
    starts = [fsum(share for _, share in bars[0][:k]) for k in range(len(bars[0]))]
    heads = {
        source: Head(
            at=100.0 * start,
            text=source_title(source, of=group.sensor),
            is_centred=False,
        )
        for start, (source, share) in zip(starts, bars[0], strict=True)
        if source != OTHER and fits(source_title(source, of=group.sensor), share * SPAN)
    }
    seen = dict.fromkeys(
        name for bar in bars for name, share in bar if share >= VISIBLE
    )
    scale = Scale(
        low=0.0,
        high=100.0,
        ticks=tuple((float(x), str(x)) for x in (0, 25, 50, 75, 100)),
        label=said.label,
    )
    rows = tuple(
        Row(
            label=row.axis,
            marks=tuple(_segment_bars(group, place, bar)),
            beside=() if bar else (said.no_spread,),
            said=line(PAGE, "shares_row", axis=row.axis, bar=bar, sensor=group.sensor),
        )
        for place, (row, bar) in enumerate(zip(group.rows, bars, strict=True))
    )
    return Chart(
        name=f"shares-{group.sensor}-{group.parameter}",
        title=said.title,
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=rows),)),)),),
        lead=said.lead,
        heads=tuple(heads.values()),
        pitch=21.0,
        legend=tuple(
            (
                *_segment_look(name, group)[:2],
                said.other if name == OTHER else source_title(name, of=group.sensor),
            )
            for name in in_order(seen)
            if name not in heads
        ),
    )


def _segments(group: GroupTable, place: int) -> list[tuple[Name, float]]:
    """Return (source, share) of one bar in fixed order, small ones gathered."""
    return gathered({row.source: row.cells[place].share.exact for row in group.sources})


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


def _segment_look(source: Name, group: GroupTable) -> tuple[str, str, str]:
    """Return colour, hatch, colour of text; of two triads the second is hatched."""
    if group.sensor == IMU and source.owner == ACCELEROMETER:
        return look_of(source)[0], HATCH, ""
    return look_of(source)


def _segment_bars(
    group: GroupTable, place: int, bar: list[tuple[Name, float]]
) -> Iterator[Bar]:
    """Yield the segments of one stacked bar, each with its tooltip."""
    alone = {row.source: row.cells[place].u.text for row in group.sources}
    start = 0.0
    for source, share in bar:
        colour, hatch, ink = _segment_look(source, group)
        yield Bar(
            start=100.0 * start,
            end=100.0 * (start + share),
            colour=colour,
            hatch=hatch,
            height=15.0,
            text=print_share(share) if ink else "",
            text_colour=ink,
            tip=line(
                PAGE,
                "share",
                group=group,
                axis=group.rows[place].axis,
                source=source,
                share=share,
                alone=alone.get(source),
            ),
        )
        start += share


FEWEST, MOST_BARS = 2, 12  # bars: one says nothing that a sentence does not


def group_shares_chart(budget: Budget) -> Chart | None:
    """Show what the variance of each group of outputs is made of, a stacked bar each.

    Of a group the shares are those of the sum of its variances; of a mission each
    output has its bar, accelerometers hatched. None of one bar, or without spread.
    """
    every = _bars(budget)
    bars = every[:MOST_BARS]
    if len(bars) < FEWEST:
        return None
    said = texts(
        PAGE,
        "group_shares",
        bars=[(name, *max(bar, key=lambda one: one[1])) for name, bar in bars],
    )
    seen = dict.fromkeys(
        name for _, bar in bars for name, share in bar if share >= VISIBLE
    )
    is_mission = all(row.output.name.time is not None for row in budget.outputs)
    title = full_title if is_mission else source_title
    rows = tuple(
        Row(
            label=name,
            marks=tuple(_group_bars(name, bar, title)),
            said=line(PAGE, "group_shares_row", name=name, bar=bar),
        )
        for name, bar in bars
    )
    named = {mark.text for row in rows for mark in row.marks if isinstance(mark, Bar)}
    scale = Scale(
        low=0.0,
        high=100.0,
        ticks=tuple((float(x), str(x)) for x in (0, 25, 50, 75, 100)),
        label=said.label,
    )
    return Chart(
        name="shares",
        title=said.title,
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=rows),)),)),),
        lead=said.lead,
        pitch=19.0,
        width=WIDE,
        legend=tuple(
            dict.fromkeys(
                (*_look(name, title)[:2], said.other if name == OTHER else title(name))
                for name in in_order(seen)
                if title(name) not in named
            )
        ),
        data=table(PAGE, "group_shares_data", bars=bars),
        data_on_paper=False,
    )


def _bars(budget: Budget) -> list[tuple[str, list[tuple[Name, float]]]]:
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


def _look(source: Name, title: Callable[[Name], str]) -> tuple[str, str, str]:
    """Return the look of a source; of two triads in one bar the second is hatched."""
    colour, hatch, ink = look_of(source)
    if title is full_title and source.owner == ACCELEROMETER and not hatch:
        return colour, HATCH, ""
    return colour, hatch, ink


def _group_bars(
    name: str, bar: Sequence[tuple[Name, float]], title: Callable[[Name], str]
) -> Iterator[Bar]:
    """Yield the segments of one bar, named where the name fits, else with the share."""
    start = 0.0
    for source, share in bar:
        colour, hatch, ink = _look(source, title)
        room = share * GROUP_SPAN
        label = next(
            (text for text in (title(source), print_share(share)) if fits(text, room)),
            "",
        )
        yield Bar(
            start=100.0 * start,
            end=100.0 * (start + share),
            colour=colour,
            hatch=hatch,
            height=15.0,
            text=label if ink and source != OTHER else "",
            text_colour=ink or INK,
            tip=line(PAGE, "group_share", name=name, source=source, share=share),
        )
        start += share


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
    cells = [cell for cell in found.cells if cell.group.owner == sensor]
    if not any(cell.reaches for cell in cells):
        return None
    groups = [group for group in found.groups if group.owner == sensor]
    reaching = [s for s in found.sources if any(cell.source == s for cell in cells)]
    own = [s for s in reaching if s.owner in SENSORS]
    shared = [s for s in reaching if s.owner not in SENSORS]
    parts = {
        # The sensors' own need no head where no others stand below.
        words(sensor) if shared else "": (in_order(own), sensor),
        **{
            owner: (tuple(s for s in in_order(shared) if s.owner == owner), owner)
            for owner in dict.fromkeys(s.owner for s in shared)
        },
    }
    drawn = tuple(
        Group(
            title=title,
            rows=tuple(
                _coupling_row(
                    source,
                    [found.cell(source, group) for group in groups],
                    sensor,
                    among=owner,
                )
                for source in members
            ),
        )
        for title, (members, owner) in parts.items()
        if members
    )
    foreign = [cell for cell in cells if cell.reaches and not cell.is_own]
    said = texts(
        PAGE,
        "coupling",
        sensor=sensor,
        farthest=[foreign[k] for k in largest([cell.size for cell in foreign])],
        part=print_part,
    )
    return Chart(
        name=f"coupling-{sensor}",
        title=said.title,
        sides=(
            Side(
                panels=(
                    Panel(
                        scale=Scale(low=0.0, high=float(len(groups)), ticks=()),
                        groups=drawn,
                    ),
                    _hues(said.label),
                )
            ),
        ),
        lead=said.lead,
        after=said.after,
        caption=said.caption,
        heads=tuple(
            Head(at=x + 0.5, text=words(group.quantity))
            for x, group in enumerate(groups)
        ),
        pitch=18.0,
        data_on_paper=False,
        data=table(
            PAGE,
            "coupling_data",
            sensor=sensor,
            sources=(*in_order(own), *in_order(shared)),
            groups=groups,
            table=found,
            per_cent=_per_cent,
        ),
    )


def print_part(size: float) -> str:
    """Print a part of u in two digits: '33 %', '0.69 %', '3.1e-5', '>99 %'."""
    if size < PER_CENT_FROM:
        return f"{size:.1e}".replace("e-0", "e-")
    return f"{_per_cent(size)} %"


def _coupling_row(
    source: Name, cells: list[Coupling], sensor: str, *, among: str
) -> Row:
    """Return the cells of one source, each with its number and its tooltip.

    Its name leaves out the owner that it stands among.
    """
    name = source_title(source, of=among)
    reaching = [cell for cell in cells if cell.reaches]
    return Row(
        label=name,
        marks=tuple(
            _coupling_bar(x, cell, sensor)
            for x, cell in enumerate(cells)
            if cell.reaches or cell.is_own
        ),
        said=line(PAGE, "coupling_row", name=name, cells=reaching, part=print_part),
    )


def _coupling_bar(x: int, cell: Coupling, sensor: str) -> Bar:
    """Return one cell of the map; a frame alone where an own spread is 0."""
    opacity = next(opacity for edge, opacity in STEPS if cell.size >= edge)
    tip = line(PAGE, "coupling_cell", cell=cell, sensor=sensor, part=print_part)
    return Bar(
        start=x + 0.015,
        end=x + 0.985,
        colour=BLUE if cell.reaches else "none",
        edge="none",
        opacity=opacity,
        height=16.0,
        is_framed=cell.is_own,
        text=print_part(cell.size) if cell.reaches else "",
        text_colour=ON_DARK if opacity == 1.0 else INK,
        tip=tip if cell.reaches else "",
    )


def _hues(label: str) -> Panel:
    """Return the steps of the hue, their edges written below."""
    rising = STEPS[::-1]
    return Panel(
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
            Group(
                rows=(
                    Row(
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


@dataclass(frozen=True, kw_only=True)
class OutputIndices:
    """The indices of one output that are not 0 to the digits printed."""

    row: OutputBudget
    shown: tuple[tuple[Name, SobolIndex], ...]  # in the order of all figures
    zero: tuple[Name, ...]  # names of the other sources

    @property
    def interacts(self) -> bool:
        """Whether any of those shown does."""
        return any(index.interacts for _, index in self.shown)

    @property
    def ranked(self) -> list[tuple[Name, SobolIndex]]:
        """Those shown by rank, then by total index."""
        return sorted(self.shown, key=lambda pair: (pair[1].rank, -pair[1].total))


def sobol_chart(budget: Budget, sensor: str) -> Chart | None:
    """Show first-order and total index of each source of a sensor, None without any.

    Of each group of parameters the output with the largest spread.
    """
    found = _widest(budget, sensor)
    if not found:
        return None
    pairs = [(one.row, *pair) for one in found for pair in one.shown]
    seen = [pair for pair in pairs if _can_be_seen(pair[2])]
    gaps = [index.total - index.first for _, _, index in seen]
    view = {"found": found, "sensor": sensor, "first": _first, "total": _total}
    said = texts(PAGE, "sobol", seen=[seen[k] for k in largest(gaps)], **view)
    scale = Scale(
        low=0.0,
        high=1.0,
        ticks=tuple((float(x), x) for x in ("0", "0.25", "0.5", "0.75", "1")),
        label=said.label,
    )
    groups = tuple(
        Group(
            title=f"{words(one.row.parameter)} {one.row.axis}",
            said=key_title(one.row.output.name),
            rows=tuple(_sobol_row(one.row, *pair, sensor) for pair in one.shown),
        )
        for one in found
    )
    return Chart(
        name=f"sobol-{sensor}",
        title=said.title,
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=said.lead,
        after=said.after,
        caption=said.caption,
        beside=(said.beside,),
        pitch=20.0,
        data_on_paper=False,
        data=table(PAGE, "sobol_data", **view),
    )


def _widest(budget: Budget, sensor: str) -> tuple[OutputIndices, ...]:
    """Return the indices of the output of each group with the largest spread."""
    with_indices = [
        row
        for row in budget.outputs
        if row.sensor == sensor and any(part.sobol for part in row.contributions)
    ]
    found = []
    for row in widest_of_each(with_indices):
        own = {p.source: p.sobol for p in row.contributions if p.sobol is not None}
        shown = [name for name in in_order(own) if float(_total(own[name])[0]) > 0.0]
        found.append(
            OutputIndices(
                row=row,
                shown=tuple((name, own[name]) for name in shown),
                zero=tuple(name for name in in_order(own) if name not in shown),
            )
        )
    return tuple(found)


def _sobol_row(
    output: OutputBudget, source: Name, index: SobolIndex, sensor: str
) -> Row:
    """Return one source: dot above, ring below, whiskers, and the gap between."""
    colour, title = look_of(source)[0], source_title(source, of=sensor)
    said = texts(
        PAGE,
        "sobol_row",
        name=output.output.name,
        title=title,
        first=_first(index),
        total=_total(index),
        interacts=index.interacts,
    )
    gap = Bar(
        start=index.first,
        end=index.total,
        colour=colour,
        edge="none",
        opacity=GAP,
        height=2.0 * APART,
    )
    marks: list[Mark] = [gap]
    for value, ends, lift, fill, tip in (
        (index.first, index.first_interval, -APART, INK, said.tip),
        (index.total, index.total_interval, APART, PAPER, ""),
    ):
        marks += [
            Stroke(start=0.0, end=value, colour=colour, width=2.0, lift=lift),
            Stroke(start=ends[0], end=ends[1], colour=INK, width=0.9, lift=lift),
            Dot(at=value, fill=fill, size=4.5, lift=lift, tip=tip),
        ]
    return Row(
        label=title,
        marks=tuple(marks),
        beside=(said.beside,),
        strong=_can_be_seen(index),
        said=said.said,
    )


def _can_be_seen(index: SobolIndex) -> bool:
    """Whether an interaction is beyond chance and beyond the digits printed."""
    return index.interacts and _first(index)[0] != _total(index)[0]


def _first(index: SobolIndex) -> tuple[str, str]:
    """Print the first-order index and its interval."""
    return print_index(index.first, index.first_interval)


def _total(index: SobolIndex) -> tuple[str, str]:
    """Print the total index and its interval."""
    return print_index(index.total, index.total_interval)
