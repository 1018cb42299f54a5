"""Figures of all sources: shares of the variance, coupling, Sobol indices."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum
from typing import TYPE_CHECKING

from budget.language import key_title, say, term, words
from budget.model.source import ACCELEROMETER
from budget.model.sources import SENSORS
from budget.names import IMU
from budget.report.blocks import Cell, Field, table_of
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
    STYLES,
    WIDTH,
    fits,
    in_order,
    look_of,
)
from budget.report.tables import (
    ALL,
    SMALL_SHARE,
    print_given,
    print_index,
    print_share,
    source_title,
)
from budget.report.wording import capital
from budget.results import widest_of_each
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.names import Name
    from budget.report.figures.rows import Mark
    from budget.report.tables import GroupTable
    from budget.results import Budget, OutputBudget, SobolIndex
    from budget.studies.coupling import Coupling, CouplingTable

SPAN = WIDTH - 36.0  # of the whole variance at least [pt]
VISIBLE = 0.002  # share below which a segment is thinner than a line [1]
MAJORITY = 0.5  # share of the variance [1]


def share_chart(group: GroupTable) -> Chart:
    """Show what contributes to each output's variance: a stacked bar for each output.

    The table of the budget has the numbers.
    """
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
        label=say("share of the variance [%]"),
    )
    rows = tuple(_shares_row(group, place, bar) for place, bar in enumerate(bars))
    return Chart(
        name=f"shares-{group.sensor}-{group.parameter}",
        title=_shares_title(group),
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=rows),)),)),),
        lead=say("Shares of the variance by axis. "),
        heads=tuple(heads.values()),
        pitch=21.0,
        legend=tuple(
            (
                *_segment_look(name, group)[:2],
                _segment_name(name, group, say("other, each below 1 %")),
            )
            for name in in_order(seen)
            if name not in heads
        ),
    )


def _shares_title(group: GroupTable) -> str:
    """State the finding: what makes most of the variance of a group."""
    first, *others = group.sources
    if first.share.exact == 0.0:
        return say("The {group} has no spread", group=group.title)
    whole = say("of the {group} variance", group=group.title)
    if first.share.exact >= MAJORITY or not others:
        return say(
            "{first} contributes {share} {whole}",
            first=capital(first.title),
            share=first.share.text,
            whole=whole,
        )
    second = others[0]
    both = print_share(first.share.exact + second.share.exact)
    return say(
        "{first} and {second} contribute {both} {whole}",
        first=capital(first.title),
        second=second.title,
        both=both,
        whole=whole,
    )


def _segment_name(source: Name, group: GroupTable, other: str) -> str:
    """Name a segment for people."""
    return other if source == OTHER else source_title(source, of=group.sensor)


def _segments(group: GroupTable, place: int) -> list[tuple[Name, float]]:
    """Return (source, share) of one bar in fixed order, small ones gathered."""
    shares = {row.source: row.cells[place].share.exact for row in group.sources}
    bar = [
        (name, shares[name])
        for name in in_order(shares)
        if name.quantity in STYLES and shares[name] >= SMALL_SHARE
    ]
    rest = fsum(shares.values()) - fsum(share for _, share in bar)
    small = any(0.0 < share < SMALL_SHARE for share in shares.values())
    return [*bar, (OTHER, rest)] if small or rest >= SMALL_SHARE else bar


def _segment_look(source: Name, group: GroupTable) -> tuple[str, str, str]:
    """Return colour, hatch, colour of text; of two triads the second is hatched."""
    if group.sensor == IMU and source.owner == ACCELEROMETER:
        return look_of(source)[0], HATCH, ""
    return look_of(source)


def _shares_row(group: GroupTable, place: int, bar: list[tuple[Name, float]]) -> Row:
    """Return one stacked bar; each segment has its tooltip."""
    axis = group.rows[place].axis
    alone = {row.source: row.cells[place].u.text for row in group.sources}
    marks, said, start = [], [], 0.0
    for source, share in bar:
        colour, hatch, ink = _segment_look(source, group)
        text = print_share(share)
        name = _segment_name(source, group, say("all others together"))
        tip = say(
            "{group} {axis}: {name} {text} of the variance",
            group=group.title,
            axis=axis,
            name=name,
            text=text,
        )
        if source in alone:
            tip += say(", alone u {alone} {unit}", alone=alone[source], unit=group.unit)
        marks.append(
            Bar(
                start=100.0 * start,
                end=100.0 * (start + share),
                colour=colour,
                hatch=hatch,
                height=15.0,
                text=text if ink else "",
                text_colour=ink,
                tip=tip,
            )
        )
        said.append(f"{source_title(source, of=group.sensor)} {text}")
        start += share
    return Row(
        label=axis,
        marks=tuple(marks),
        beside=() if bar else (say("no spread"),),
        said=say(
            "{axis}: {said}", axis=axis, said=say(", ").join(said) or say("no spread")
        ),
    )


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
NOTHING = term("none")


def coupling_chart(table: CouplingTable, sensor: str) -> Chart | None:
    """Show sources by groups of parameters, the hue by the size of what reaches.

    Of one sensor; None where nothing reaches anything.
    """
    cells = [cell for cell in table.cells if cell.group.owner == sensor]
    if not any(cell.reaches for cell in cells):
        return None
    groups = [group for group in table.groups if group.owner == sensor]
    reaching = [s for s in table.sources if any(cell.source == s for cell in cells)]
    own = [s for s in reaching if s.owner in SENSORS]
    shared = [s for s in reaching if s.owner not in SENSORS]
    sources = (*in_order(own), *in_order(shared))
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
                    [table.cell(source, group) for group in groups],
                    sensor,
                    among=owner,
                )
                for source in members
            ),
        )
        for title, (members, owner) in parts.items()
        if members
    )

    def column(group: Name) -> Field[Name]:
        return Field(
            head=f"{words(group.quantity)} [%]",
            kind="number",
            cell=lambda source: _part_cell(table.cell(source, group)),
        )

    return Chart(
        name=f"coupling-{sensor}",
        title=_coupling_title(cells, sensor),
        sides=(
            Side(
                panels=(
                    Panel(
                        scale=Scale(low=0.0, high=float(len(groups)), ticks=()),
                        groups=drawn,
                    ),
                    _hues(),
                )
            ),
        ),
        lead=say(
            "u from one source alone over u from all, of the {sensor}. ",
            sensor=words(sensor),
        ),
        after=say(" All other sources reach nothing."),
        caption=say("Framed: the own spread of a parameter. Empty: nothing."),
        heads=tuple(
            Head(at=x + 0.5, text=words(group.quantity))
            for x, group in enumerate(groups)
        ),
        pitch=18.0,
        data_on_paper=False,
        data=table_of(
            sources,
            (
                Field(
                    head=say("source"), cell=lambda name: source_title(name, of=sensor)
                ),
                *map(column, groups),
            ),
            name=f"coupling-{sensor}-data",
            caption=say(
                "u of each {sensor} source over u of all, in per cent",
                sensor=words(sensor),
            ),
        ),
    )


def _part_cell(cell: Coupling) -> Cell:
    """Return the part of u that a source makes of a group."""
    if not cell.reaches:
        return Cell(text=say(NOTHING))
    exact = 100.0 * cell.size
    return Cell(text=_per_cent(cell.size), exact=exact, strong=cell.is_own)


def print_part(size: float) -> str:
    """Print a part of u in two digits: '33 %', '0.69 %', '3.1e-5', '>99 %'."""
    if size < PER_CENT_FROM:
        return f"{size:.1e}".replace("e-0", "e-")
    return f"{_per_cent(size)} %"


def _coupling_title(cells: list[Coupling], sensor: str) -> str:
    """State the finding: which source reaches farthest where it does not belong."""
    foreign = [cell for cell in cells if not cell.is_own]
    most = foreign[first_largest([cell.size for cell in foreign])] if foreign else None
    if most is None or not most.reaches:
        return say(
            "Each {sensor} parameter is reached by its own spread alone",
            sensor=words(sensor),
        )
    title = source_title(most.source, of=sensor)
    return say(
        "Besides own spreads, {title} reaches farthest: {size} of the u of the {group}",
        title=title,
        size=print_part(most.size),
        group=key_title(most.group),
    )


def _coupling_row(
    source: Name, cells: list[Coupling], sensor: str, *, among: str
) -> Row:
    """Return the cells of one source, each with its number and its tooltip.

    Its name leaves out the owner that it stands among.
    """
    name = source_title(source, of=among)
    title = source_title(source, of=sensor)
    marks: list[Mark] = []
    said = []
    for x, cell in enumerate(cells):
        if not (cell.reaches or cell.is_own):
            continue
        opacity = next(opacity for edge, opacity in STEPS if cell.size >= edge)
        part = print_part(cell.size)
        marks.append(
            Bar(
                start=x + 0.015,
                end=x + 0.985,
                colour=BLUE if cell.reaches else "none",
                edge="none",
                opacity=opacity,
                height=16.0,
                is_framed=cell.is_own,
                text=part if cell.reaches else "",
                text_colour=ON_DARK if opacity == 1.0 else INK,
                tip=say(
                    "{title} contributes {part} of the u of the {group}",
                    title=title,
                    part=part,
                    group=key_title(cell.group),
                )
                if cell.reaches
                else "",
            )
        )
        if cell.reaches:
            owned = say(" (own)") if cell.is_own else ""
            said.append(f"{words(cell.group.quantity)} {part}{owned}")
    return Row(
        label=name,
        marks=tuple(marks),
        said=say("{name}: {said}", name=name, said=say(", ").join(said))
        if said
        else "",
    )


def _hues() -> Panel:
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
            label=say("u of one source over u of all"),
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
class Indices:
    """The indices of one output that are not 0 to the digits printed."""

    row: OutputBudget
    shown: tuple[tuple[Name, SobolIndex], ...]  # in the order of all figures
    zero: tuple[Name, ...]  # names of the other sources

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
    zeros = say("; ").join(
        say("for the {parameter}: ", parameter=words(one.row.parameter))
        + say(", ").join(source_title(name, of=sensor) for name in one.zero)
        for one in found
        if one.zero
    )
    zeros = say(" 0 to the digits that are sure {zeros}.", zeros=zeros) if zeros else ""
    scale = Scale(
        low=0.0,
        high=1.0,
        ticks=tuple((float(x), x) for x in ("0", "0.25", "0.5", "0.75", "1")),
        label=say("index, a share of the variance [1]"),
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
        title=_sobol_title(found, sensor),
        sides=(Side(panels=(Panel(scale=scale, groups=groups),)),),
        lead=say("Sobol' indices with intervals. "),
        after=zeros,
        caption=(
            say(
                "Dot: first-order index, ring: total index, with their "
                "intervals; a band between them is interaction.{zeros}",
                zeros=zeros,
            )
        ),
        beside=(say("first, total"),),
        pitch=20.0,
        data_on_paper=False,
        data=table_of(
            [(one.row, *pair) for one in found for pair in one.ranked],
            (
                Field(
                    head=say("source"),
                    cell=lambda one: Cell(
                        text=source_title(one[1], of=sensor),
                        note=say("interacts") if one[2].interacts else "",
                    ),
                ),
                Field(head=say("rank"), cell=lambda one: _rank(one[0], one[2])),
                Field(
                    head=say("first order"),
                    kind="number",
                    cell=lambda one: Cell(text=_first(one[2])[0], exact=one[2].first),
                ),
                Field(
                    head=say("interval"),
                    kind="unit",
                    cell=lambda one: _first(one[2])[1],
                ),
                Field(
                    head=say("total"),
                    kind="number",
                    cell=lambda one: Cell(text=_total(one[2])[0], exact=one[2].total),
                ),
                Field(
                    head=say("interval"),
                    kind="unit",
                    cell=lambda one: _total(one[2])[1],
                ),
            ),
            name=f"sobol-{sensor}-data",
            caption=say(
                "Sobol' indices of the widest {sensor} outputs", sensor=words(sensor)
            ),
            by=lambda one: capital(key_title(one[0].output.name)),
            titled=True,
        ),
    )


def _sobol_title(found: tuple[Indices, ...], sensor: str) -> str:
    """State the finding: the largest interaction, or that there is none."""
    pairs = [(one.row, *pair) for one in found for pair in one.shown]
    seen = [pair for pair in pairs if _can_be_seen(pair[2])]
    if seen:
        row, source, index = seen[
            first_largest([index.total - index.first for _, _, index in seen])
        ]
        first, total = _first(index)[0], _total(index)[0]
        return say(
            "{source} interacts in the {name}: first order {first}, total {total}",
            source=capital(source_title(source, of=sensor)),
            name=key_title(row.output.name),
            first=first,
            total=total,
        )
    if any(index.interacts for _, _, index in pairs):
        return say(
            "Products of {sensor} sources make too little to print: "
            "first-order and total indices agree",
            sensor=words(sensor),
        )
    return say(
        "No {sensor} source interacts beyond chance: first-order "
        "and total indices agree",
        sensor=words(sensor),
    )


def _widest(budget: Budget, sensor: str) -> tuple[Indices, ...]:
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
            Indices(
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
    first, total = _first(index), _total(index)
    said = say(
        "{title} first order {first} and total {total}",
        title=title,
        first=" ".join(first),
        total=" ".join(total),
    ) + (say(" (interacts)") if index.interacts else "")
    gap = Bar(
        start=index.first,
        end=index.total,
        colour=colour,
        edge="none",
        opacity=GAP,
        height=2.0 * APART,
    )
    marks: list[Mark] = [gap]
    for value, ends, lift, fill in (
        (index.first, index.first_interval, -APART, INK),
        (index.total, index.total_interval, APART, PAPER),
    ):
        tip = (
            say("{name}: {said}", name=key_title(output.output.name), said=said)
            if fill == INK
            else ""
        )
        marks += [
            Stroke(start=0.0, end=value, colour=colour, width=2.0, lift=lift),
            Stroke(start=ends[0], end=ends[1], colour=INK, width=0.9, lift=lift),
            Dot(at=value, fill=fill, size=4.5, lift=lift, tip=tip),
        ]
    return Row(
        label=title,
        marks=tuple(marks),
        beside=(say("{first}, {total}", first=first[0], total=total[0]),),
        strong=_can_be_seen(index),
        said=said,
    )


def _rank(output: OutputBudget, index: SobolIndex) -> str:
    """Print a rank; sources that cannot be told apart share it: '2='."""
    ranks = [part.sobol.rank for part in output.contributions if part.sobol]
    return f"{index.rank}{'=' if ranks.count(index.rank) > 1 else ''}"


def _can_be_seen(index: SobolIndex) -> bool:
    """Whether an interaction is beyond chance and beyond the digits printed."""
    return index.interacts and _first(index)[0] != _total(index)[0]


def _first(index: SobolIndex) -> tuple[str, str]:
    """Print the first-order index and its interval."""
    return print_index(index.first, index.first_interval)


def _total(index: SobolIndex) -> tuple[str, str]:
    """Print the total index and its interval."""
    return print_index(index.total, index.total_interval)
