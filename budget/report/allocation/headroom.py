"""Headroom, which answers how far each line may grow alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.allocation.rows import THICK, named_rows
from budget.report.allocation.words import (
    DIGITS,
    IDLE,
    NONE,
    print_headroom,
    print_value,
)
from budget.report.figures import INK, MUTED, PAPER, SMALL, house_style, look_of
from budget.report.figures.picture import as_picture
from budget.report.tables import print_given, source_title
from budget.studies.allocation.records import FREE
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from budget.report.blocks import Picture
    from budget.studies.allocation.records import SourceAllotment

LEAST_FACTOR, MOST_FACTOR = 1e-2, 1e2  # of a headroom that is drawn [1]


def headroom_picture(rows: Sequence[SourceAllotment]) -> Picture | None:
    """Return the bars of one sensor as a block, None where no line can be judged.

    Each bar has its tooltip; the table of the lines has the data.
    """
    shown = [row for row in rows if row.headroom is not None]
    if not shown:
        return None
    sensor = shown[0].source.owner
    return as_picture(
        headroom_bars(rows),
        name=f"headroom-{sensor}",
        title=headroom_title(rows),
        alt=headroom_alt(rows),
        tips=headroom_tips(rows),
        caption=(
            "Each line alone, the others as they are now; named is the limit that "
            f"stops it. To the left: it must become better by that much.{_idle(rows)}"
        ),
    )


@house_style()
def headroom_bars(rows: Sequence[SourceAllotment]) -> Figure:
    """Draw how far each line may go alone, from its present value, on a log axis."""
    shown = [row for row in rows if row.headroom is not None]
    figure, axes = named_rows(len(shown), top=8.0)
    figure.set_label(headroom_title(rows))
    axes.set_xscale("log")
    axes.set_xlim(LEAST_FACTOR, MOST_FACTOR)
    axes.set_xticks(
        [0.01, 0.1, 1.0, 10.0, 100.0], ["1/100", "1/10", "now", "10", "100"]
    )
    axes.minorticks_off()
    axes.set_xlabel(
        "value over the present one; diamond: allowed", fontsize=SMALL, color=MUTED
    )
    axes.set_yticks(range(len(shown)), [source_title(row.source) for row in shown])
    axes.axvline(1.0, color=INK, linewidth=0.8)
    for place, row in enumerate(shown):
        colour, hatch, _ = look_of(row.source)
        factor = _factor(row)
        drawn = min(max(factor, LEAST_FACTOR), MOST_FACTOR)
        low, high = sorted((1.0, drawn))
        (bar,) = axes.barh(
            place,
            high - low,
            left=low,
            height=THICK,
            color=colour if factor > 0.0 else "none",
            edgecolor=colour,
            linewidth=0.8,
            hatch=hatch or None,
        )
        bar.set_gid(_gid(row))
        if row.status == FREE and row.allowed:
            allowed = min(max(row.factor, LEAST_FACTOR), MOST_FACTOR)
            axes.plot(
                [allowed],
                [place],
                marker="D",
                markersize=4.0,
                color=PAPER,
                markeredgecolor=INK,
                clip_on=False,
            )
        axes.annotate(
            _stop(row),
            (1.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(6.0, 0.0),
            textcoords="offset points",
            fontsize=SMALL,
            color=INK,
            va="center_baseline",
        )
    return figure


def headroom_title(rows: Sequence[SourceAllotment]) -> str:
    """State the finding: how many lines may grow alone, and which most."""
    shown = [row for row in rows if row.headroom is not None]
    growing = [row for row in shown if _factor(row) > 1.0]
    sensor = shown[0].source.owner if shown else ""
    if not growing:
        return f"No {sensor} line alone may grow"
    most = growing[first_largest([_factor(row) for row in growing])]
    that_count = " that count" if any(row.is_idle for row in rows) else ""
    return (
        f"{len(growing)} of {len(shown)} {sensor} lines{that_count} may grow alone, "
        f"{source_title(most.source)} {print_given(_factor(most), digits=DIGITS)} times"
    )


def headroom_alt(rows: Sequence[SourceAllotment]) -> str:
    """Say in words with numbers what the bars show."""
    texts = "; ".join(
        f"{source_title(row.source)} {print_given(_factor(row), digits=3)} times, "
        f"stopped by {_stop(row)}"
        if _factor(row) > 0.0
        else f"{source_title(row.source)} {_stop(row)}"
        for row in rows
        if row.headroom is not None
    )
    title = headroom_title(rows)
    return f"{title}. Each line alone, the others as now: {texts}.{_idle(rows)}"


def headroom_tips(rows: Sequence[SourceAllotment]) -> dict[str, str]:
    """Return a tooltip for the bar of each line, by its gid."""
    tips = {}
    for row in rows:
        if row.headroom is None:
            continue
        now = print_value(row.now / row.si_per_unit, row.unit)
        if row.headroom.value:
            value = print_value(row.headroom.value / row.si_per_unit, row.unit)
            alone = f"alone up to {value}, then stopped by {_stop(row)}"
        else:
            alone = f"alone it cannot mend {_stop(row).removeprefix('none: ')}"
        tips[_gid(row)] = f"{source_title(row.source)}: now {now}, {alone}"
    return tips


def _gid(row: SourceAllotment) -> str:
    """Name the bar of a line."""
    return f"tip-{row.source.quantity}"


def _factor(row: SourceAllotment) -> float:
    """Return headroom over present value [1], of a line that has one."""
    return 0.0 if row.headroom is None else row.headroom.value / row.now


def _stop(row: SourceAllotment) -> str:
    """Name what stops a line."""
    up_to, stop = print_headroom(row)
    return f"{NONE}: {stop}" if up_to == NONE else stop


def _idle(rows: Sequence[SourceAllotment]) -> str:
    """Name the lines that are not drawn because they count nothing."""
    names = ", ".join(source_title(row.source) for row in rows if row.is_idle)
    return f" Not drawn, as it {IDLE}: {names}." if names else ""
