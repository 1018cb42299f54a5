"""Share bars: contributions to each output's variance."""

from __future__ import annotations

from math import fsum
from typing import TYPE_CHECKING

from budget.report.figures.rows import (
    Bar,
    Chart,
    Group,
    Head,
    Panel,
    Row,
    Scale,
    Side,
)
from budget.report.figures.style import OTHER, STYLES, WIDTH, fits, in_order, look_of
from budget.report.tables import SMALL_SHARE, print_share, source_title
from budget.report.wording import capital

if TYPE_CHECKING:
    from budget.names import Name
    from budget.report.tables import GroupTable

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
        label="share of the variance [%]",
    )
    rows = tuple(_row(group, place, bar) for place, bar in enumerate(bars))
    return Chart(
        name=f"shares-{group.sensor}-{group.parameter}",
        title=_title(group),
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=rows),)),)),),
        lead="Shares of the variance by axis. ",
        heads=tuple(heads.values()),
        pitch=21.0,
        legend=tuple(
            (*look_of(name)[:2], _name(name, group, "other, each below 1 %"))
            for name in in_order(seen)
            if name not in heads
        ),
    )


def _title(group: GroupTable) -> str:
    """State the finding: what makes most of the variance of a group."""
    first, *others = group.sources
    if first.share.exact == 0.0:
        return f"The {group.title} has no spread"
    whole = f"of the {group.title} variance"
    if first.share.exact >= MAJORITY or not others:
        return f"{capital(first.title)} makes {first.share.text} {whole}"
    second = others[0]
    both = print_share(first.share.exact + second.share.exact)
    return f"{capital(first.title)} and {second.title} make {both} {whole}"


def _name(source: Name, group: GroupTable, other: str) -> str:
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


def _row(group: GroupTable, place: int, bar: list[tuple[Name, float]]) -> Row:
    """Return one stacked bar; each segment has its tooltip."""
    axis = group.rows[place].axis
    alone = {row.source: row.cells[place].u.text for row in group.sources}
    marks, said, start = [], [], 0.0
    for source, share in bar:
        colour, hatch, ink = look_of(source)
        text = print_share(share)
        name = _name(source, group, "all others together")
        tip = f"{group.title} {axis}: {name} {text} of the variance"
        if source in alone:
            tip += f", alone u {alone[source]} {group.unit}"
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
        beside=() if bar else ("no spread",),
        said=f"{axis}: {', '.join(said) or 'no spread'}",
    )
