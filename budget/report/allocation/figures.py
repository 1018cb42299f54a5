"""Figures of an allocation: where a limit goes, how far each line may grow alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.language import key_title, say
from budget.report.allocation.words import (
    IDLE,
    NONE,
    part_title,
    print_headroom,
    print_part,
    print_used,
    print_value,
)
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
from budget.report.tables import DIGITS, print_given, source_title
from budget.report.wording import capital
from budget.studies.allocation.records import FREE
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.figures.rows import Mark
    from budget.studies.allocation.records import (
        LimitedOutput,
        LimitPart,
        SourceAllotment,
    )

PITCH = 17.0  # from row to row [pt]
LEAST_FACTOR, MOST_FACTOR = 1e-2, 1e2  # of a headroom that is drawn [1]
THIN, BELOW = 3.4, 6.8  # height of a bar of what is now, and how far down it is [pt]
SHOWN = 1e-3  # part of the squared limit from which a source has a row [1]


def waterfall_chart(row: LimitedOutput) -> Chart:
    """Show one limit from the whole down through the sources to what is left.

    The thick bars are what is allowed (of an impossible limit, what is held), the thin
    ones what the sources take now; those leave the figure where the limit is passed.
    """
    left, left_now = 1.0, 1.0
    rows = [Row(label=say("limit"), marks=(Bar(start=0.0, end=100.0, colour=GRID),))]
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
    beside = tuple(
        say(NONE) if value < -SHOWN else print_part(max(value, 0.0))
        for value in (left_now, left)
    )
    rows.append(Row(label=say("left"), marks=tuple(marks), beside=beside))
    scale = Scale(
        low=0.0,
        high=100.0,
        ticks=tuple((float(x), str(x)) for x in (0, 25, 50, 75, 100)),
        label=say("part of the squared limit [%]"),
    )
    word, used = after_word(row), print_used(row, now=True)
    return Chart(
        name=f"waterfall-{row.output.name}",
        title=_waterfall_title(row),
        sides=(Side(panels=(Panel(scale=scale, groups=(Group(rows=tuple(rows)),)),)),),
        lead=say(
            "Parts of the squared limit {printed_limit}: ",
            printed_limit=row.printed_limit,
        ),
        after=say(" The largest error is now {used} of the limit.", used=used),
        caption=(
            say(
                "From the squared limit down: thick bars are what is "
                "{word}, thin ones what each source takes now.",
                word=word,
            )
        ),
        beside=(say("now"), word),
        pitch=PITCH,
    )


def after_word(row: LimitedOutput) -> str:
    """Say what stands beside 'now': what is allowed, or all that is held."""
    return say("held") if row.allowed is None else say("allowed")


def _waterfall_title(row: LimitedOutput) -> str:
    """State the finding: who takes most of the limit."""
    name = key_title(row.output.name)
    largest = row.parts[first_largest([part.after for part in row.parts])]
    title = part_title(largest.source, row.sensor)
    part = say("{title} takes {after} %", title=title, after=print_part(largest.after))
    if row.allowed is None:
        return say(
            "{name} cannot be met: {part} of the squared limit",
            name=capital(name),
            part=part,
        )
    return say("{part} of the squared {name} limit", part=capital(part), name=name)


def _part_row(row: LimitedOutput, part: LimitPart, left: float, left_now: float) -> Row:
    """Return what one source takes of what is left, allowed and now.

    An arrow shows where what it takes now passes the limit.
    """
    colour, hatch, _ = look_of(part.source)
    after, title = part.after, part_title(part.source, row.sensor)
    now, then = print_part(part.now), print_part(after)
    said = say(
        "{title} now {now} %, {after_word} {then} %",
        title=title,
        now=now,
        after_word=after_word(row),
        then=then,
    )
    marks: list[Mark] = [
        Bar(
            start=100.0 * (left - after),
            end=100.0 * left,
            colour=colour,
            hatch=hatch,
            edge_width=0.4,
            tip=say(
                "{said} of the squared {name} limit {printed_limit}",
                said=said,
                name=key_title(row.output.name),
                printed_limit=row.printed_limit,
            ),
        )
    ]
    start, end = 100.0 * min(left_now, 1.0), 100.0 * (left_now - part.now)
    if start > 0.0 and part.now > 0.0:
        marks.append(Bar(start=max(end, 0.0), end=start, height=THIN, lift=BELOW))
    if end < 0.0 < part.now:
        marks.append(
            Dot(at=0.0, shape="<", fill=MUTED, edge=MUTED, size=4.0, lift=BELOW)
        )
    return Row(label=title, marks=tuple(marks), beside=(now, then), said=said)


def headroom_chart(rows: Sequence[SourceAllotment]) -> Chart | None:
    """Show how far each line of a sensor may go alone, from its present value.

    None where no line can be judged; the table of the lines has the data.
    """
    shown = [row for row in rows if row.headroom is not None]
    if not shown:
        return None
    names = say(", ").join(source_title(row.source) for row in rows if row.is_idle)
    idle = (
        say(" Not drawn, as it {idle}: {names}.", idle=say(IDLE), names=names)
        if names
        else ""
    )
    scale = Scale(
        low=LEAST_FACTOR,
        high=MOST_FACTOR,
        kind="log",
        ticks=(
            *((0.01, "1/100"), (0.1, "1/10"), (1.0, say("now"))),
            *((10.0, "10"), (100.0, "100")),
        ),
        lines=((1.0, ""),),
        label=say("value over the present one; diamond: allowed"),
    )
    group = Group(rows=tuple(map(_headroom_row, shown)))
    return Chart(
        name=f"headroom-{shown[0].source.owner}",
        title=_headroom_title(shown, has_idle=bool(idle)),
        sides=(Side(panels=(Panel(scale=scale, groups=(group,)),)),),
        lead=say("Each line alone, the others as now: "),
        after=idle,
        caption=(
            say(
                "Each line alone, the others as they are now; named is the "
                "limit that stops it. To the left: it must become better "
                "by that much.{idle}",
                idle=idle,
            )
        ),
        flush="left",
        pitch=PITCH,
    )


def _headroom_title(shown: Sequence[SourceAllotment], *, has_idle: bool) -> str:
    """State the finding: how many lines may grow alone, and which most."""
    growing = [row for row in shown if _factor(row) > 1.0]
    sensor = shown[0].source.owner
    if not growing:
        return say("No {sensor} line alone may grow", sensor=say(sensor))
    most = growing[first_largest([_factor(row) for row in growing])]
    that_count = say(" that count") if has_idle else ""
    return say(
        "{growing} of {shown} {sensor} lines{that_count} may grow "
        "alone, {source} {factor} times",
        growing=len(growing),
        shown=len(shown),
        sensor=say(sensor),
        that_count=that_count,
        source=source_title(most.source),
        factor=print_given(_factor(most), digits=DIGITS),
    )


def _headroom_row(row: SourceAllotment) -> Row:
    """Return how far one line may go, where it is allowed to be, and what stops it."""
    colour, hatch, _ = look_of(row.source)
    factor, title = _factor(row), source_title(row.source)
    up_to, stop = print_headroom(row)
    stopped_by = (
        say("{none}: {stop}", none=up_to, stop=stop) if up_to == say(NONE) else stop
    )
    now = print_value(row.now / row.si_per_unit, row.unit)
    if row.headroom is not None and row.headroom.value:
        times = print_given(factor, digits=DIGITS)
        said = say(
            "{title} {times} times, stopped by {stopped_by}",
            title=title,
            times=times,
            stopped_by=stopped_by,
        )
        value = print_value(row.headroom.value / row.si_per_unit, row.unit)
        alone = say(
            "alone up to {value}, then stopped by {stopped_by}",
            value=value,
            stopped_by=stopped_by,
        )
    else:
        said = f"{title} {stopped_by}"
        alone = say("alone it cannot mend {stop}", stop=stop)
    bar = Bar(
        start=1.0,
        end=_drawn(factor),
        colour=colour if factor > 0.0 else "none",
        edge=colour,
        edge_width=0.8,
        hatch=hatch,
        tip=say("{title}: now {now}, {alone}", title=title, now=now, alone=alone),
    )
    is_moved = row.status == FREE and bool(row.allowed)
    diamond = Dot(at=_drawn(row.factor), shape="D", fill=PAPER, edge=INK, size=4.0)
    return Row(
        label=title,
        marks=(bar, diamond) if is_moved else (bar,),
        beside=(stopped_by,),
        said=said,
    )


def _factor(row: SourceAllotment) -> float:
    """Return headroom over present value [1], of a line that has one."""
    return 0.0 if row.headroom is None else row.headroom.value / row.now


def _drawn(factor: float) -> float:
    """Keep a factor within the axis [1]."""
    return min(max(factor, LEAST_FACTOR), MOST_FACTOR)
