"""An allocation as a section of a report page."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.allocation.figures import (
    headroom_alt,
    headroom_bars,
    headroom_title,
    waterfall,
    waterfall_alt,
    waterfall_title,
)
from budget.report.allocation.words import (
    headline,
    join_outputs,
    lever_text,
    match_text,
    part_title,
    print_change,
    print_part,
    print_used,
    relaxations,
    remarks,
    tightest,
)
from budget.report.inline import inline_svg
from budget.report.markup import (
    markup,
    page_environment,
)
from budget.report.tables import (
    output_title,
    print_count,
    print_coverage,
    print_given,
    source_title,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from budget.studies.allocation.records import (
        Allocation,
        LimitedOutput,
        Match,
        SourceAllotment,
    )

CLOSEST = 5  # catalogue entries a sensor that are listed where none meets


@dataclass(frozen=True, kw_only=True)
class Triad:
    """The tables of one sensor."""

    sensor: str
    rows: tuple[SourceAllotment, ...]
    limits: tuple[LimitedOutput, ...]  # of each parameter the tightest


@dataclass(frozen=True, kw_only=True)
class Shelf:
    """The catalogue entries of one sensor that are listed."""

    sensor: str
    total: int
    meeting: int
    shown: tuple[Match, ...]


def allocation_section(allocation: Allocation) -> str:
    """Write the section of a page: tables and figures, no head, no style.

    Parameters
    ----------
    allocation : Allocation
        The result.

    Returns
    -------
    str
        One `section` element; the same bytes for the same argument.
    """
    environment = page_environment()
    environment.filters |= {
        "given": lambda value: print_given(value, digits=3),
        "output": output_title,
        "source": source_title,
        "coverage": print_coverage,
        "count": print_count,
    }
    sensors = tuple(
        dict.fromkeys(row.source.partition(".")[0] for row in allocation.sources)
    )
    solved = dict.fromkeys(match.sensor for match in allocation.matches)
    triads = [_triad(allocation, sensor) for sensor in sensors]
    return environment.get_template("allocation.html.j2").render(
        allocation=allocation,
        headline=headline(allocation),
        triads=triads,
        shelves=[_shelf(allocation, sensor) for sensor in solved],
        waterfalls=[
            (waterfall_title(row), markup(_inline(waterfall(row), waterfall_alt(row))))
            for row in figured(allocation)
        ],
        headrooms=[
            (
                headroom_title(triad.rows),
                markup(_inline(headroom_bars(triad.rows), headroom_alt(triad.rows))),
            )
            for triad in triads
            if any(row.headroom is not None for row in triad.rows)
        ],
        relaxations=relaxations(allocation.impossible),
        lever_text=lever_text,
        match_text=match_text,
        part_title=part_title,
        print_change=print_change,
        print_part=print_part,
        print_used=print_used,
        remarks=remarks,
        join_outputs=join_outputs,
    )


def figured(allocation: Allocation) -> tuple[LimitedOutput, ...]:
    """Return the outputs that get a waterfall: of each parameter the tightest one.

    Those whose limits cannot be met, and those at their limits.
    """
    return tightest((*allocation.impossible, *allocation.binding))


def _triad(allocation: Allocation, sensor: str) -> Triad:
    """Gather the tables of one sensor."""
    return Triad(
        sensor=sensor,
        rows=tuple(
            row for row in allocation.sources if row.source.startswith(f"{sensor}.")
        ),
        limits=tightest([row for row in allocation.outputs if row.sensor == sensor]),
    )


def _shelf(allocation: Allocation, sensor: str) -> Shelf:
    """Gather the catalogue entries of one sensor, the closest ones shown."""
    own = [match for match in allocation.matches if match.sensor == sensor]
    meeting = sum(match.meets for match in own)
    return Shelf(
        sensor=sensor,
        total=len(own),
        meeting=meeting,
        shown=tuple(own[: max(meeting, CLOSEST)]),
    )


def _inline(figure: Figure, alt: str) -> str:
    """Draw a figure for the page, named by what it shows."""
    name = re.sub(r"[^a-z0-9]+", "-", f"allocation {figure.get_label()}".lower())
    return inline_svg(figure, name, alt)
