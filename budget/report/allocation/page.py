"""An allocation as a section, for a report and for a terminal."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import floor, log10
from typing import TYPE_CHECKING

from budget.names import MISSION, by_group
from budget.report.allocation.figures import headroom_chart, waterfall_chart
from budget.report.answers import Answer, split_at
from budget.report.blocks import Abreast, ForPages
from budget.report.document import json_text
from budget.report.figures.rows import chart_picture
from budget.report.pages import sections
from budget.report.provenance import provenance_section, sign_off_section
from budget.report.tables import DASH, print_given
from budget.settings import Settings
from budget.studies.allocation.records import FREE
from budget.ties import first_largest, from_largest, settle
from budget.units import DAY, YEAR
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Sequence

    from budget.names import Name
    from budget.report.blocks import Document, Picture, Section
    from budget.studies.allocation.records import Allocation, LimitPart, SharedLimit

COMMAND = "budget allocate"
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
    allocation: Allocation, *, date: str, command_line: str = COMMAND
) -> Document:
    """Put an allocation into one document: what each line may be, then why."""
    section, *further = allocation_answer(allocation)
    answer = Answer.of(section)
    owners = dict.fromkeys(row.source.owner for row in allocation.sources)
    allowed = answer.first(*(f"allocation-{owner}" for owner in owners))
    apart = [split_at(one, one.name.replace("-", "-parts-", 1)) for one in allowed]
    return answer.whole(
        "allocation_page",
        provenance_section(
            allocation.inputs,
            Settings(seed=allocation.settings.seed),
            version=__version__,
            command_line=command_line,
        ),
        sign_off_section(),
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
