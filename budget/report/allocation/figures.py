"""Figures of an allocation: where a limit goes, how far each line may grow alone."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from budget.report.figures.rows import (
    Bar,
    Chart,
    Dot,
    Group,
    Panel,
    Row,
    Scale,
    Side,
)
from budget.report.figures.style import GRID, INK, MUTED, PAPER, look_of
from budget.report.pages import line
from budget.report.tables import source_title
from budget.report.writing import print_part
from budget.studies.allocation.records import FREE
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.figures.rows import Mark
    from budget.studies.allocation.records import (
        LimitPart,
        SharedLimit,
        SourceAllotment,
    )

PITCH = 17.0  # from row to row [pt]
LEAST_FACTOR, MOST_FACTOR = 1e-2, 1e2  # of a headroom that is drawn [1]
THIN, BELOW = 3.4, 6.8  # height of a bar of what is now, and how far down it is [pt]
SHOWN = 1e-3  # part of the squared limit from which a source has a row [1]
said = partial(line, "figures_allocation")


def waterfall_chart(row: SharedLimit) -> Chart:
    """Show one limit from the whole down through the sources to what is left.

    The thick bars are what is allowed (of an impossible limit, what is held), the thin
    ones what the sources take now; those leave the figure where the limit is passed.
    """
    left, left_now = 1.0, 1.0
    rows = [Row(label=said("limit"), marks=(Bar(start=0.0, end=100.0, colour=GRID),))]
    for part in row.parts:
        if max(part.now, part.after) < SHOWN:
            continue
        rows.append(_part_row(row, part, left, left_now))
        left, left_now = left - part.after, left_now - part.now
    marks: list[Mark] = []
    if left > 0.0:
        marks.append(Bar(start=0.0, end=100.0 * left, colour=GRID))
    if left_now > 0.0:
        marks.append(Bar(start=0.0, end=100.0 * left_now, height=THIN, lift=BELOW))
    beside = tuple(said("rest", part=one, least=SHOWN) for one in (left_now, left))
    rows.append(Row(label=said("left"), marks=tuple(marks), beside=beside))
    scale = Scale(
        low=0.0,
        high=100.0,
        ticks=tuple((float(x), str(x)) for x in (0, 25, 50, 75, 100)),
        label=said("waterfall_axis"),
    )
    most = row.parts[first_largest([part.after for part in row.parts])]
    return Chart(
        name=f"waterfall-{row.output.name}",
        title=said("waterfall_title", row=row, most=most),
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=tuple(rows)),)),)),),
        lead=said("waterfall_lead", row=row),
        after=said("waterfall_after", row=row),
        caption=said("waterfall_caption", row=row),
        beside=(said("now"), said("then", row=row)),
        pitch=PITCH,
    )


def _part_row(row: SharedLimit, part: LimitPart, left: float, left_now: float) -> Row:
    """Return what one source takes of what is left, allowed and now.

    An arrow shows where what it takes now passes the limit.
    """
    colour, hatch, _ = look_of(part.source)
    marks: list[Mark] = [
        Bar(
            start=100.0 * (left - part.after),
            end=100.0 * left,
            colour=colour,
            hatch=hatch,
            edge_width=0.4,
            tip=said("part_tip", row=row, part=part),
        )
    ]
    start, end = 100.0 * min(left_now, 1.0), 100.0 * (left_now - part.now)
    if start > 0.0 and part.now > 0.0:
        marks.append(Bar(start=max(end, 0.0), end=start, height=THIN, lift=BELOW))
    if end < 0.0 < part.now:
        marks.append(
            Dot(at=0.0, shape="<", fill=MUTED, edge=MUTED, size=4.0, lift=BELOW)
        )
    return Row(
        label=said("part_title", row=row, part=part),
        marks=tuple(marks),
        beside=(print_part(part.now), print_part(part.after)),
        said=said("part_said", row=row, part=part),
    )


def headroom_chart(rows: Sequence[SourceAllotment]) -> Chart | None:
    """Show how far each line of a sensor may go alone, from its present value.

    None where no line can be judged; the table of the lines has the data.
    """
    shown = [row for row in rows if row.headroom is not None]
    if not shown:
        return None
    idle = [row for row in rows if row.is_idle]
    growing = [row for row in shown if _factor(row) > 1.0]
    most = growing[first_largest([*map(_factor, growing)])] if growing else None
    scale = Scale(
        low=LEAST_FACTOR,
        high=MOST_FACTOR,
        kind="log",
        ticks=(
            *((0.01, "1/100"), (0.1, "1/10"), (1.0, said("now"))),
            *((10.0, "10"), (100.0, "100")),
        ),
        lines=((1.0, ""),),
        label=said("headroom_axis"),
    )
    group = Group(rows=tuple(map(_headroom_row, shown)))
    sensor = shown[0].source.owner
    return Chart(
        name=f"headroom-{sensor}",
        title=said(
            "headroom_title",
            sensor=sensor,
            drawn=shown,
            growing=growing,
            most=most,
            idle=idle,
        ),
        sides=(Side(panels=(Panel(scale=scale, groups=(group,)),)),),
        lead=said("headroom_lead"),
        after=said("headroom_after", rows=idle),
        caption=said("headroom_caption", idle=idle),
        flush="left",
        pitch=PITCH,
    )


def _headroom_row(row: SourceAllotment) -> Row:
    """Return how far one line may go, where it is allowed to be, and what stops it."""
    colour, hatch, _ = look_of(row.source)
    factor = _factor(row)
    bar = Bar(
        start=1.0,
        end=_drawn(factor),
        colour=colour if factor > 0.0 else "none",
        edge=colour,
        edge_width=0.8,
        hatch=hatch,
        tip=said("headroom_tip", row=row),
    )
    is_moved = row.status == FREE and bool(row.allowed)
    diamond = Dot(at=_drawn(row.factor), shape="D", fill=PAPER, edge=INK, size=4.0)
    return Row(
        label=source_title(row.source),
        marks=(bar, diamond) if is_moved else (bar,),
        beside=(said("headroom_beside", row=row),),
        said=said("headroom_said", row=row),
    )


def _factor(row: SourceAllotment) -> float:
    """Return headroom over present value [1], of a line that has one."""
    return 0.0 if row.headroom is None else row.headroom.value / row.now


def _drawn(factor: float) -> float:
    """Keep a factor within the axis [1]."""
    return min(max(factor, LEAST_FACTOR), MOST_FACTOR)
