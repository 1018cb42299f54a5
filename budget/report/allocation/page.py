"""An allocation as a section, for a report and for a terminal."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from budget.names import MISSION, by_group
from budget.report.allocation.figures import headroom_chart, waterfall_chart
from budget.report.allocation.words import (
    IDLE,
    in_units,
    part_title,
    print_headroom,
    print_part,
    print_used,
    print_value,
    relaxations,
    tightest,
)
from budget.report.blocks import Abreast, ForPages
from budget.report.figures.rows import chart_picture
from budget.report.pages import sections
from budget.report.tables import DASH
from budget.studies.allocation.records import FREE

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.report.blocks import Picture, Section
    from budget.studies.allocation.records import Allocation, LimitedOutput

CLOSEST = 5  # catalogue entries a sensor that are listed where none meets
SHARP = 1e-12  # below it a residual is the rounding of the processor [1]


def allocation_answer(allocation: Allocation) -> tuple[Section, ...]:
    """Return what stands alone on a terminal: the allocation and what was assumed."""
    return sections(
        "allocation",
        found=allocation,
        held=by_group(allocation.not_estimated),
        relaxed=list(relaxations(allocation.impossible)),
        limits=partial(_limits, allocation),
        pictures=Abreast(blocks=(ForPages(lambda: _pictures(allocation)),)),
        headroom=print_headroom,
        in_units=in_units,
        part_title=part_title,
        print_part=print_part,
        print_used=print_used,
        print_value=print_value,
        CLOSEST=CLOSEST,
        DASH=DASH,
        FREE=FREE,
        IDLE=IDLE,
        MISSION=MISSION,
        SHARP=SHARP,
    )


def allocation_section(allocation: Allocation) -> Section:
    """Return what each line may be: the finding, its tables and figures."""
    return allocation_answer(allocation)[0]


def figured(allocation: Allocation) -> tuple[LimitedOutput, ...]:
    """Return the outputs that get a waterfall: of each parameter the tightest one.

    Those whose limits cannot be met, and those at their limits.
    """
    return tightest((*allocation.impossible, *allocation.binding))


def _limits(allocation: Allocation, sensor: str) -> tuple[LimitedOutput, ...]:
    """Return the outputs whose limits are taken apart: those that have a waterfall.

    Of parameters without one the tightest.
    """
    own = [row for row in allocation.outputs if row.sensor == sensor]
    drawn = {row.output.name.group: row for row in figured(allocation)}
    return tuple(drawn.get(row.output.name.group, row) for row in tightest(own))


def _pictures(allocation: Allocation) -> Iterator[Picture]:
    """Draw how far each line could go, and what takes how much of the limits."""
    for sensor in dict.fromkeys(row.source.owner for row in allocation.sources):
        rows = [row for row in allocation.sources if row.source.owner == sensor]
        if (headroom := headroom_chart(rows)) is not None:
            yield chart_picture(headroom)
    yield from (chart_picture(waterfall_chart(row)) for row in figured(allocation))
