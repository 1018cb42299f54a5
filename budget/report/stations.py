"""Test stations for people and programs: figures, verdicts, acceptance limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from decimal import ROUND_FLOOR, Decimal
from itertools import groupby
from math import floor, log10, nan
from typing import TYPE_CHECKING

from budget.distributions import NORMAL
from budget.inputs.tree import block, flow, quoted
from budget.model.sources import ENVIRONMENT, STATION, source_of
from budget.names import keys_of
from budget.question import given_lines
from budget.report.answers import LEAST_ROWS, Answer, decades
from budget.report.document import json_text
from budget.report.figures.rows import Bar, Chart, ChartPanel, chart_picture, rows_of
from budget.report.figures.style import Scale, look_of
from budget.report.pages import figure, sections
from budget.report.provenance import endings
from budget.report.tables import (
    DASH,
    DIGITS,
    Number,
    print_given,
    print_three,
)
from budget.studies.stations import DOES, MOST_FALSE_ACCEPT, NO_FIGURES
from budget.ties import from_largest, settle, smallest

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.names import Name
    from budget.report.blocks import Document, Section
    from budget.studies.stations import (
        Qualification,
        StationOutput,
        StationVerdict,
    )

ANY = "any"
SHOWN = 1e-3  # of the part of a limit: a figure that takes less has no bar [1]
PER_CENT = 100.0
LEAST_RISK = 1e-4  # of a false accept: less is printed as less than this [1]


def station_answer(found: Qualification, *, full: bool = True) -> tuple[Section, ...]:
    """Return what stands on a terminal: the answer, in full or in brief."""
    tried = [one for one in found.stations if one.has_figures]
    nearest, of_all = map(_least_used, (tried, found.doing))
    own = found.own
    shown = [own] if own else tried
    risk = float(NORMAL.probability([-found.guard * found.coverage_factor])[0])
    return sections(
        "station" if full else "station_brief",
        found=found,
        nearest=nearest,
        headed=(own or (of_all or nearest)[0]) if tried else None,
        risk=PER_CENT * risk,
        most=PER_CENT * MOST_FALSE_ACCEPT,
        shown=[
            (found.stations.index(one), one, [*_accepted(one)], too_often)
            for one in shown
            for too_often in [
                [row.output.name for row in one.outputs if row.is_accepted_too_often]
            ]
        ],
        DOES=DOES,
        NO_FIGURES=NO_FIGURES,
        DASH=DASH,
        DIGITS=DIGITS,
    )


def _least_used(stations: Sequence[StationVerdict]) -> list[StationVerdict]:
    """Return the station that uses least of its limits, with all that are equal."""
    return [stations[k] for k in smallest([one.utilisation for one in stations])]


def station_document(
    found: Qualification, *, date: str, command_line: str = "budget station"
) -> Document:
    """Put it into one document: which station will do, then what it stands on."""
    answer, *further = station_answer(found)
    chart = figures_chart(found)
    return Answer.of(answer).whole(
        "station_page",
        *endings(found.inputs, command_line=command_line),
        json=json_text(found.to_dict()),
        date=date,
        found=found,
        further=further,
        picture=None if chart is None else chart_picture(chart),
    )


def figures_chart(found: Qualification) -> Chart | None:
    """Show what each figure of the procedure's own station takes, largest first.

    None where there is no such station, or hardly a figure of it takes anything.
    """
    used = [row.takes_now or 0.0 for row in found.figures]
    rows = [found.figures[k] for k in from_largest(used) if used[k] >= SHOWN]
    if len(rows) < LEAST_ROWS:
        return None
    said, table = figure("figures_station", "used", rows=rows, ratio=found.ratio)
    low, high = decades(
        [*(PER_CENT * (row.takes_now or 0.0) for row in rows), PER_CENT]
    )
    scale = Scale(
        low=low,
        high=max(high, 2.0 * PER_CENT),
        kind="log",
        lines=((PER_CENT, said.its_part),),
        label=said.axis,
    )
    drawn = rows_of(
        table,
        lambda at, look: [
            Bar(start=low, end=at.used, colour=look[0], hatch=look[1], width=0.4)
        ],
        [look_of(row.source) for row in rows],
    )
    return Chart(
        name="station-figures",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        caption=said.caption,
    )


def print_ratio(ratio: float) -> str:
    """Print a ratio of a limit to an uncertainty: '4:1'."""
    return f"{print_given(ratio, digits=DIGITS)}:1"


def station_yaml(found: Qualification) -> str:
    """Write a station file whose figures are what they may be together: 1 sigma.

    What may be any value is left out.
    """
    timing = found.question.procedure.timing
    given = given_lines((), found.question.procedure)
    wanted = found.question.requirement.name
    tree: dict[str, object] = {
        "format": "budget-station/1",
        "name": f"station for {wanted} at {print_ratio(found.ratio)}"[:200],
    }
    for owner in (STATION, ENVIRONMENT):
        for one in found.figures:
            if one.source.owner != owner or one.together is None:
                continue
            *folders, last = keys_of(one.source.quantity)
            branch = tree.setdefault(owner, {})
            for folder in folders:
                branch = branch.setdefault(folder, {})  # type: ignore[attr-defined]
            value = one.together / one.si_per_unit
            branch[last] = f"{value!r} {one.unit}"  # type: ignore[index]
            if one.source in found.times:
                time = source_of(owner, one.source.quantity).time
                branch[time] = f"{found.times[one.source]!r} s"  # type: ignore[index]
            points = None if one.source not in given else given[one.source].points
            if points is not None:
                key = source_of(owner, one.source.quantity).points
                branch[key] = [f"{point!r} s" for point in points.tolist()]  # type: ignore[index]
    station: dict[str, object] = tree.setdefault(STATION, {})  # type: ignore[assignment]
    station |= {"scale_from": timing.scale_from, "window": timing.edges}
    entries = ((key, flow(value, quoted)) for key, value in tree.items())
    return "\n".join(block(entries)) + "\n"


@dataclass(frozen=True, kw_only=True)
class Accepted:
    """Limit, U and acceptance limit of outputs that are alike, in their unit."""

    names: tuple[Name, ...]
    group: str  # the parameter
    unit: str
    limit: float
    expanded: Number  # U
    accept: Number | None  # None where no value would be
    by_station: Number | None  # were its U all
    test_ratio: float | None
    risk: Number  # of a false accept [%]
    too_often: bool
    beyond: bool  # whether the station alone takes more than its part


def _accepted(station: StationVerdict) -> Iterator[Accepted]:
    """Yield what is accepted of every limited output; alike ones once."""
    for _, alike in groupby(map(_acceptance, station.outputs), _printed):
        rows = list(alike)
        yield replace(rows[0], names=tuple(name for row in rows for name in row.names))


def _acceptance(row: StationOutput) -> Accepted:
    """Return what is accepted of one output."""
    scale = row.output.si_per_unit
    u = row.whole / scale

    def up_to(value: float | None) -> Number | None:
        if value is None:
            return None
        return Number(text=print_down(value / scale, u), exact=value / scale)

    risk = nan if row.false_accept is None else PER_CENT * row.false_accept
    return Accepted(
        names=(row.output.name,),
        group=row.output.name.group,
        unit=row.output.unit,
        limit=row.limit / scale,
        expanded=Number(text=print_three(u) if u > 0.0 else "0", exact=u),
        accept=up_to(row.acceptance),
        by_station=up_to(row.station_acceptance),
        test_ratio=row.test_ratio,
        risk=Number(text=print_risk(row), exact=risk),
        too_often=row.is_accepted_too_often,
        beyond=settle(row.utilisation) > 1.0,
    )


def _printed(row: Accepted) -> tuple[object, ...]:
    """Return what alike outputs have in common: all that is printed."""
    numbers = (row.expanded, row.accept, row.by_station, row.risk)
    return (row.group, row.limit, *(one and one.text for one in numbers))


def print_risk(row: StationOutput) -> str:
    """Print a false accept in per cent: a dash for none, and what is hardly any."""
    risk = row.false_accept
    if risk is None or row.acceptance is None:
        return DASH
    if risk < LEAST_RISK:
        return f"<{print_given(PER_CENT * LEAST_RISK)}"
    return print_given(PER_CENT * risk, digits=2)


def print_down(value: float, u: float) -> str:
    """Print an acceptance limit to the third digit of U, never rounded up."""
    if u <= 0.0 or value <= 0.0:
        return print_given(value, digits=6)
    step = Decimal(1).scaleb(max(floor(log10(settle(u))) - 2, floor(log10(value)) - 5))
    exact = Decimal(repr(settle(value)))
    return f"{(exact / step).to_integral_value(ROUND_FLOOR) * step:f}"
