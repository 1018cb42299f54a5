"""Share bars, which answer what causes each output's error."""

from __future__ import annotations

from math import fsum
from typing import TYPE_CHECKING

from budget.report.figures.picture import as_picture, capital, in_order
from budget.report.figures.style import (
    GRID,
    INK,
    MUTED,
    OTHER,
    PAPER,
    SMALL,
    STYLES,
    WIDTH,
    canvas,
    fits,
    house_style,
    look_of,
)
from budget.report.tables import SMALL_SHARE, print_share, source_title

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from budget.names import Name
    from budget.report.blocks import Picture
    from budget.report.tables import GroupTable

BAR, PITCH = 15.0, 21.0  # height of a bar, and from bar to bar [pt]
LEGEND_LINE = 13.0  # [pt]
VISIBLE = 0.002  # share below which a segment is thinner than a line [1]
MAJORITY = 0.5  # share of the variance [1]


def share_picture(group: GroupTable) -> Picture | None:
    """Return the bars as a block, None without spread; the budget table has the data.

    Each segment has its tooltip.
    """
    if not any(row.share.exact for row in group.sources):
        return None
    return as_picture(
        share_bars(group),
        name=f"shares-{group.sensor}-{group.parameter}",
        title=share_title(group),
        alt=share_alt(group),
        tips=share_tips(group),
    )


@house_style()
def share_bars(group: GroupTable) -> Figure:
    """Draw what causes each output's variance: a stacked bar for each output."""
    bars = [_segments(group, place) for place in range(len(group.rows))]
    left, right, top = 28.0, 8.0, 18.0
    span = WIDTH - left - right  # [pt] of the whole variance
    named = {
        source
        for source, share in bars[0]
        if source != OTHER and fits(source_title(source, of=group.sensor), share * span)
    }
    seen = dict.fromkeys(
        name for bar in bars for name, share in bar if share >= VISIBLE
    )
    legend = [name for name in in_order(seen) if name not in named]
    below = 32.0 + LEGEND_LINE * ((len(legend) + 1) // 2)
    height = top + PITCH * len(bars) + below
    figure, axes = canvas(height, left=left, right=right, top=top, below=below)
    figure.set_label(share_title(group))
    axes.set_xlim(0.0, 100.0)
    axes.set_ylim(len(bars) - 0.5, -0.5)
    axes.set_yticks(range(len(bars)), [row.axis for row in group.rows])
    axes.set_xticks([0, 25, 50, 75, 100])
    axes.set_xlabel("share of the variance [%]", fontsize=SMALL, color=MUTED)
    axes.grid(axis="x", color=GRID, linewidth=0.6)
    for place, bar in enumerate(bars):
        _draw_bar(
            axes, place, bar, span, name=group.rows[place].axis, sensor=group.sensor
        )
    start = 0.0
    for source, share in bars[0]:
        if source in named:
            axes.annotate(
                source_title(source, of=group.sensor),
                (100.0 * start, -BAR / PITCH / 2.0),
                xytext=(0.0, 3.0),
                textcoords="offset points",
                fontsize=SMALL,
                color=INK,
            )
        start += share
    _draw_legend(figure, legend, left, group.sensor)
    return figure


def share_title(group: GroupTable) -> str:
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


def share_alt(group: GroupTable) -> str:
    """Say in words with numbers what the bars show."""
    bars = []
    for place, row in enumerate(group.rows):
        parts = [
            f"{source_title(source, of=group.sensor)} {print_share(share)}"
            for source, share in _segments(group, place)
        ]
        bars.append(f"{row.axis}: {', '.join(parts) or 'no spread'}")
    return f"{share_title(group)}. Shares of the variance by axis. {'; '.join(bars)}."


def share_tips(group: GroupTable) -> dict[str, str]:
    """Return a tooltip for each segment, by its gid: 'tip-z-bias_stability'."""
    alone = {row.source: [cell.u.text for cell in row.cells] for row in group.sources}
    tips = {}
    for place, row in enumerate(group.rows):
        for source, share in _segments(group, place):
            name = (
                "all others together"
                if source == OTHER
                else source_title(source, of=group.sensor)
            )
            text = f"{group.title} {row.axis}: {name} {print_share(share)}"
            text += " of the variance"
            if source in alone:
                text += f", alone u {alone[source][place]} {group.unit}"
            tips[_gid(row.axis, source.within(group.sensor))] = text
    return tips


def _gid(axis: str, source: Name) -> str:
    """Name a segment."""
    return f"tip-{axis}-{source}"


def _name(source: Name, sensor: str) -> str:
    """Name a segment for people."""
    return (
        "other, each below 1 %" if source == OTHER else source_title(source, of=sensor)
    )


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


def _draw_bar(
    axes: Axes,
    place: int,
    bar: Sequence[tuple[Name, float]],
    span: float,
    *,
    name: str,
    sensor: str,
) -> None:
    """Draw one stacked bar; the share is written where it fits."""
    if not bar:
        axes.text(0.5, place, "no spread", fontsize=SMALL, color=MUTED, va="center")
    start = 0.0
    for source, share in bar:
        colour, hatch, text_colour = look_of(source)
        (segment,) = axes.barh(
            place,
            100.0 * share,
            left=100.0 * start,
            height=BAR / PITCH,
            color=colour,
            edgecolor=PAPER,
            linewidth=0.6,
            hatch=hatch or None,
        )
        segment.set_gid(_gid(name, source.within(sensor)))
        label = print_share(share)
        if text_colour and fits(label, share * span):
            axes.text(
                100.0 * (start + share / 2.0),
                place,
                label,
                fontsize=SMALL,
                color=text_colour,
                ha="center",
                va="center_baseline",
            )
        start += share


def _draw_legend(
    figure: Figure, sources: Sequence[Name], left: float, sensor: str
) -> None:
    """Name the sources that no label fits on, two abreast at the foot."""
    from matplotlib.patches import Patch

    if not sources:
        return
    figure.legend(
        handles=[
            Patch(facecolor=look_of(name)[0], hatch=look_of(name)[1], edgecolor=PAPER)
            for name in sources
        ],
        labels=[_name(name, sensor) for name in sources],
        loc="lower left",
        bbox_to_anchor=(left / WIDTH, 0.0),
        ncols=2,
        frameon=False,
        fontsize=SMALL,
        labelcolor=INK,
        borderpad=0.0,
        borderaxespad=0.0,
        handlelength=1.2,
        handleheight=0.9,
    )
