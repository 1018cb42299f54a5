"""Figures of an allocation: where a limit goes, how far each line may grow alone."""

from __future__ import annotations

from itertools import accumulate, pairwise
from typing import TYPE_CHECKING

from budget.report.figures.rows import HUNDRED, Bar, Chart, ChartPanel, Dot, rows_of
from budget.report.figures.style import GRID, MUTED, PAPER, Scale, look_of
from budget.report.figures.tabled import heads_of
from budget.report.pages import figure
from budget.studies.allocation.records import FREE
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from types import SimpleNamespace

    from budget.report.figures.rows import ChartMark
    from budget.studies.allocation.records import SharedLimit, SourceAllotment

PAGE = "figures_allocation"
PITCH = 17.0  # from row to row [pt]
LEAST_FACTOR, MOST_FACTOR = 1e-2, 1e2  # of a headroom that is drawn [1]
THIN, BELOW = 3.4, 6.8  # height of a bar of what is now, and how far down it is [pt]
SHOWN = 1e-3  # part of the squared limit from which a source has a row [1]


def waterfall_chart(row: SharedLimit) -> Chart:
    """Show one limit from the whole down through the sources to what is left.

    The thick bars are what is allowed (of an impossible limit, what is held), the thin
    ones what the sources take now; those leave the figure where the limit is passed.
    """
    parts = [part for part in row.parts if max(part.now, part.after) >= SHOWN]
    left, left_now = (
        [*accumulate(sizes, lambda at, size: at - size, initial=1.0)]
        for sizes in ([one.after for one in parts], [one.now for one in parts])
    )
    most = row.parts[first_largest([part.after for part in row.parts])]
    said, table = figure(
        PAGE,
        "waterfall",
        row=row,
        most=most,
        parts=parts,
        rest=(left_now[-1], left[-1]),
        least=SHOWN,
    )
    looks = [(GRID, ""), *(look_of(one.source)[:2] for one in parts), (GRID, "")]
    drawn = rows_of(
        table,
        _limit_marks,
        looks,
        [(1.0, 0.0), *pairwise(left), (left[-1], 0.0)],
        [(0.0, 0.0), *pairwise(left_now), (left_now[-1], 0.0)],
    )
    return Chart(
        name=f"waterfall-{row.output.name}",
        title=said.title,
        panels=(
            ChartPanel(
                scale=Scale(low=0.0, high=100.0, ticks=HUNDRED, label=said.axis),
                groups=drawn,
            ),
        ),
        table=table,
        has_data=False,
        caption=said.caption,
        beside=heads_of(table),
        pitch=PITCH,
    )


def _limit_marks(
    at: SimpleNamespace,
    look: tuple[str, str],
    allowed: tuple[float, float],
    now: tuple[float, float],
) -> Iterator[ChartMark]:
    """Yield what one source takes of what is left, allowed and now.

    An arrow shows where what it takes now passes the limit.
    """
    start, end = 100.0 * min(now[0], 1.0), 100.0 * now[1]
    is_whole = look[0] == GRID
    if allowed[0] > 0.0 or not is_whole:
        yield Bar(
            start=100.0 * allowed[1],
            end=100.0 * allowed[0],
            colour=look[0],
            hatch=look[1],
            width=0.6 if is_whole else 0.4,
            tip=at.tip,
        )
    if start > 0.0 and end < start:
        yield Bar(start=max(end, 0.0), end=start, height=THIN, lift=BELOW)
    if end < 0.0 and now[1] < now[0]:
        yield Dot(start=0.0, shape="<", colour=MUTED, edge=MUTED, width=4.0, lift=BELOW)


def headroom_chart(rows: Sequence[SourceAllotment]) -> Chart | None:
    """Show how far each line of a sensor may go alone, from its present value.

    None where no line can be judged; the table of the lines has the data.
    """
    drawn = [row for row in rows if row.headroom is not None]
    if not drawn:
        return None
    growing = [row for row in drawn if _factor(row) > 1.0]
    said, table = figure(
        PAGE,
        "headroom",
        sensor=drawn[0].source.owner,
        drawn=drawn,
        growing=growing,
        most=growing[first_largest([*map(_factor, growing)])] if growing else None,
        idle=[row for row in rows if row.is_idle],
    )
    scale = Scale(
        low=LEAST_FACTOR,
        high=MOST_FACTOR,
        kind="log",
        ticks=(
            *((0.01, "1/100"), (0.1, "1/10"), (1.0, said.now)),
            *((10.0, "10"), (100.0, "100")),
        ),
        lines=((1.0, ""),),
        label=said.axis,
    )
    return Chart(
        name=f"headroom-{drawn[0].source.owner}",
        title=said.title,
        panels=(
            ChartPanel(scale=scale, groups=rows_of(table, _headroom_marks, drawn)),
        ),
        table=table,
        has_data=False,
        caption=said.caption,
        flush="left",
        pitch=PITCH,
    )


def _headroom_marks(at: SimpleNamespace, row: SourceAllotment) -> Iterator[ChartMark]:
    """Yield how far one line may go, and where it is allowed to be."""
    colour, hatch, _ = look_of(row.source)
    yield Bar(
        start=1.0,
        end=_drawn(_factor(row)),
        colour=colour if _factor(row) > 0.0 else "none",
        edge=colour,
        width=0.8,
        hatch=hatch,
        tip=at.tip,
    )
    if row.status == FREE and row.allowed:
        yield Dot(start=_drawn(row.factor), shape="D", colour=PAPER, width=4.0)


def _factor(row: SourceAllotment) -> float:
    """Return headroom over present value [1], of a line that has one."""
    return 0.0 if row.headroom is None else row.headroom.value / row.now


def _drawn(factor: float) -> float:
    """Keep a factor within the axis [1]."""
    return min(max(factor, LEAST_FACTOR), MOST_FACTOR)
