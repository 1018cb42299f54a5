"""An allocation as a section and a page, its figures, and the device that it allows."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import accumulate, pairwise
from math import floor, log10
from typing import TYPE_CHECKING

from budget.names import MISSION, by_group
from budget.report.answers import Answer, split_at
from budget.report.blocks import Abreast, ForPages
from budget.report.device_file import device_yaml
from budget.report.document import json_text
from budget.report.figures.rows import (
    HUNDRED,
    Bar,
    Chart,
    ChartPanel,
    Dot,
    chart_picture,
    rows_of,
)
from budget.report.figures.style import GRID, MUTED, PAPER, Scale, look_of
from budget.report.figures.tabled import heads_of
from budget.report.pages import figure, line, sections
from budget.report.provenance import endings
from budget.report.tables import DASH, print_given
from budget.settings import Settings
from budget.studies.allocation.records import FREE
from budget.ties import first_largest, from_largest, settle
from budget.units import DAY, YEAR

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Sequence
    from types import SimpleNamespace

    from budget.names import Name
    from budget.report.blocks import Document, Picture, Section
    from budget.report.figures.rows import ChartMark
    from budget.studies.allocation.records import (
        Allocation,
        LimitPart,
        SharedLimit,
        SourceAllotment,
    )

CLOSEST = 5  # catalogue entries a sensor that are listed where none meets
TAKERS = 3  # sources that are named where a limit cannot be met, at the most
TAKEN = 0.01  # part of the squared limit from which one is named [1]
SHARP = 1e-12  # below it a residual is the rounding of the processor [1]


def allocation_answer(
    allocation: Allocation, *, full: bool = True
) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: in full with what was assumed."""
    return sections(
        "allocation" if full else "allocation_brief",
        found=allocation,
        held=by_group(allocation.not_estimated),
        relaxed=list(relaxations(allocation.impossible)),
        limits=partial(_limits, allocation),
        pictures=Abreast(blocks=(ForPages(lambda: _pictures(allocation)),)),
        in_units=in_units,
        CLOSEST=CLOSEST,
        DASH=DASH,
        FREE=FREE,
        MISSION=MISSION,
        SHARP=SHARP,
    )


def allocation_section(allocation: Allocation) -> Section:
    """Return what each line may be: the finding, its tables and figures."""
    return allocation_answer(allocation)[0]


def allocation_document(
    allocation: Allocation, *, date: str, command_line: str = "budget allocate"
) -> Document:
    """Put an allocation into one document: what each line may be, then why."""
    section, *further = allocation_answer(allocation)
    answer = Answer.of(section)
    owners = dict.fromkeys(row.source.owner for row in allocation.sources)
    allowed = answer.first(*(f"allocation-{owner}" for owner in owners))
    apart = [split_at(one, one.name.replace("-", "-parts-", 1)) for one in allowed]
    return answer.whole(
        "allocation_page",
        *endings(
            allocation.inputs,
            Settings(seed=allocation.settings.seed),
            command_line=command_line,
        ),
        json=json_text(allocation.to_dict()),
        date=date,
        found=allocation,
        allowed=[
            replace(one, blocks=blocks)
            for one, (blocks, _) in zip(allowed, apart, strict=True)
        ],
        taken=[
            (one.title, blocks)
            for one, (_, blocks) in zip(allowed, apart, strict=True)
            if blocks
        ],
        headrooms=[*_headrooms(allocation)],
        waterfalls=[chart_picture(waterfall_chart(row)) for row in figured(allocation)],
        further=further,
    )


def figured(allocation: Allocation) -> tuple[SharedLimit, ...]:
    """Return the outputs that get a waterfall: of each parameter the tightest one.

    Those whose limits cannot be met, and those at their limits.
    """
    return tightest((*allocation.impossible, *allocation.binding))


def _limits(allocation: Allocation, sensor: str) -> tuple[SharedLimit, ...]:
    """Return the outputs whose limits are taken apart: those that have a waterfall.

    Of parameters without one the tightest.
    """
    own = [row for row in allocation.outputs if row.sensor == sensor]
    drawn = {row.output.name.group: row for row in figured(allocation)}
    return tuple(drawn.get(row.output.name.group, row) for row in tightest(own))


def _pictures(allocation: Allocation) -> Iterator[Picture]:
    """Draw how far each line could go, and what takes how much of the limits."""
    yield from _headrooms(allocation)
    yield from (chart_picture(waterfall_chart(row)) for row in figured(allocation))


def _headrooms(allocation: Allocation) -> Iterator[Picture]:
    """Draw how far each line could go, sensor by sensor."""
    for sensor in dict.fromkeys(row.source.owner for row in allocation.sources):
        rows = [row for row in allocation.sources if row.source.owner == sensor]
        if (headroom := headroom_chart(rows)) is not None:
            yield chart_picture(headroom)


def _alike(
    outputs: Sequence[SharedLimit], by: Callable[[SharedLimit], Hashable]
) -> Iterator[list[SharedLimit]]:
    """Yield outputs that have something in common, in order of the first."""
    for common in dict.fromkeys(map(by, outputs)):
        yield [row for row in outputs if by(row) == common]


def tightest(outputs: Sequence[SharedLimit]) -> tuple[SharedLimit, ...]:
    """Return the output of each parameter group that is nearest to its limit."""
    return tuple(
        rows[
            first_largest(
                [row.now if row.allowed is None else row.allowed for row in rows]
            )
        ]
        for rows in _alike(outputs, lambda row: row.output.name.group)
    )


def relaxations(
    outputs: Sequence[SharedLimit],
) -> Iterator[tuple[list[Name], SharedLimit, list[LimitPart]]]:
    """Yield outputs with one limit that cannot be met, the one that needs most of it.

    With what takes most of that one.
    """
    for rows in _alike(outputs, lambda row: (row.output.name.group, row.printed_limit)):
        row = rows[first_largest([row.floor for row in rows])]
        users = [row.parts[k] for k in from_largest([one.floor for one in row.parts])]
        taken = [part for part in users[:TAKERS] if part.floor > TAKEN]
        yield [each.output.name for each in rows], row, taken


def in_units(seconds: float) -> tuple[str, str]:
    """Write a time in days, months or years, two digits rounded down; and which."""
    sizes = {"years": YEAR, "months": YEAR / 12.0, "days": DAY}
    unit = next((one for one in sizes if seconds >= 2.0 * sizes[one]), "days")
    number = seconds / sizes[unit]
    step = 10.0 ** (floor(log10(number)) - 1)
    return print_given(floor(settle(number / step)) * step), unit


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
    said, table = figure(
        PAGE,
        "waterfall",
        row=row,
        most=row.parts[first_largest([part.after for part in row.parts])],
        parts=parts,
        rest=(left_now[-1], left[-1]),
        least=SHOWN,
    )
    drawn = rows_of(
        table,
        _limit_marks,
        [(GRID, ""), *(look_of(one.source)[:2] for one in parts), (GRID, "")],
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


def allocated_device(allocation: Allocation) -> str:
    """Write the allocated device as a device file.

    Raises
    ------
    ValueError
        The requirement cannot be met, so there is none.
    """
    if not allocation.feasible:
        raise ValueError("an infeasible requirement has no allocated device")
    # An allowed size is one to be kept, whatever the maker left open.
    closed = [
        sensor.with_lines(replace(one, readings=()) for one in sensor.lines)
        for sensor in allocation.sensors
    ]
    wanted = allocation.question.requirement.name[:30]
    technologies = {one.technology for one in allocation.question.devices}
    return device_yaml(
        closed,
        name=f"{allocation.title[:150]}, allocated for {wanted}",
        source="budget allocate",
        notes=line("allocated", found=allocation),
        technology=technologies.pop() if len(technologies) == 1 else "",
    )
