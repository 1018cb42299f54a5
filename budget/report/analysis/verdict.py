"""Verdict and limits of a report: margins, contributions, cards of page one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from budget.language import beside, key_title, say
from budget.names import MISSION
from budget.report.mission import limits_blocks
from budget.report.pages import cards, line, runs, sections
from budget.report.tables import (
    SMALL_SHARE,
    Number,
    as_limited,
    print_share,
    round_u,
    source_title,
)
from budget.studies.request import given_lines, sensors_of
from budget.ties import first_largest, from_largest, settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.inputs.records import Device, ErrorLine, Procedure
    from budget.names import Name
    from budget.report.blocks import Card, Section, Words
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, OutputAssessment

    Order = tuple[bool, float]  # whether beyond a limit, and the weight
    # Owner and source, the part of a limit that is used, and what it makes there.
    Found = tuple[str, Name, float, "Effect"]


def headline(budget: Budget, assessment: Assessment | None) -> str:
    """Return the answer in one line: 'FAILS navigation grade'.

    It stands on every printed page, so it says where sources were left out.
    """
    return line("verdict", "headline", budget=budget, assessment=assessment)


def judged_by(budget: Budget, carried: Budget | None) -> Budget:
    """Return the budget that the verdicts are of, where the mission alone is limited.

    A unit on it may be as its maker calibrated it, and the test of the other budget
    then calibrated nothing that is judged.
    """
    found = budget.assessment
    if carried and found and {one.sensor for one in found.sensors} == {MISSION}:
        return carried
    return budget


def summary(
    budget: Budget, assessment: Assessment | None, carried: Budget | None = None
) -> Words:
    """Return the answer in a sentence or two: margin, and what errors are."""
    judged = judged_by(budget, carried).settings
    return runs(
        "verdict", "summary", budget=budget, assessment=assessment, judged=judged
    )


def verdict_cards(
    budget: Budget, assessment: Assessment, carried: Budget | None = None
) -> tuple[Card, ...]:
    """Return the verdict on each sensor; on a mission by its own budget."""
    view = {"budget": budget, "assessment": assessment, "carried": carried}
    return cards("verdict", "sensor_cards", **view)


def limits_section(budget: Budget, assessment: Assessment) -> Section:
    """Return every required output against its limit, as a table."""
    coverage = budget.settings.coverage
    rows = [row for row in assessment.outputs if row.output.name.owner == MISSION]
    (section,) = sections(
        "limits",
        assessment=assessment,
        coverage=coverage,
        mission=limits_blocks(coverage, assessment, rows)[0],
    )
    return section


T = TypeVar("T")
LARGEST = 5  # as many as a reader keeps in mind


@dataclass(frozen=True, kw_only=True)
class Effect:
    """What a source makes of the variance of one group, or of an error on a mission."""

    share: Number
    group: str
    is_on_mission: bool = False
    u: Number  # of the source alone, on the axis where it is largest
    unit: str


@dataclass(frozen=True, kw_only=True)
class LargestContribution:
    """One source, and what it makes of every group where it counts."""

    title: str
    line: ErrorLine | None  # of the data sheet
    effects: tuple[Effect, ...]


def rank_contributions(
    groups: Sequence[GroupTable],
    devices: Sequence[Device],
    procedure: Procedure,
    assessment: Assessment | None,
    carried: Budget | None = None,
) -> tuple[LargestContribution, ...]:
    """Return the largest contributions, each with what it makes of every group.

    Ranked by the largest share of a group's variance; with a requirement by that share
    of the group's utilisation, those of groups beyond their limits before all others.
    Where a budget carried to a mission is limited, of what is limited alone.
    """
    given = given_lines(sensors_of(devices), procedure)
    on_mission = [] if carried is None else [*_on_mission(carried)]
    in_groups = _in_groups(groups, assessment, limited_alone=bool(on_mission))
    found: dict[tuple[str, Name], list[tuple[Order, Effect]]] = {}
    for owner, source, used, effect in (*on_mission, *in_groups):
        if effect.share.exact >= SMALL_SHARE:
            order = (settle(used) > 1.0, used * effect.share.exact)
            found.setdefault((owner, source), []).append((order, effect))
    ranked = _from_largest(
        [(max(order for order, _ in own), source) for source, own in found.items()]
    )
    return tuple(
        LargestContribution(
            title=beside(say(owner), source_title(source)),
            line=given.get(source),
            effects=tuple(_from_largest(found[owner, source])),
        )
        for owner, source in ranked[:LARGEST]
    )


def _on_mission(carried: Budget) -> Iterator[Found]:
    """Yield what sources make of that which uses most of each limit on a mission.

    Nothing of what is only rounding.
    """
    limited: dict[Name, list[OutputAssessment]] = {}
    for row in carried.assessment.outputs if carried.assessment else ():
        name = row.output.name
        if name.owner == MISSION and carried.output(name).is_resolved:
            limited.setdefault(name.group, []).append(row)
    for rows in limited.values():
        row = as_limited(rows[first_largest([one.utilisation for one in rows])])
        for part in carried.output(row.output.name).contributions:
            effect = Effect(
                share=Number(text=print_share(part.share), exact=part.share),
                group=key_title(row.output.name),
                is_on_mission=True,
                u=round_u(part.standard_uncertainty, row.output),
                unit=row.output.unit,
            )
            yield part.source.owner or MISSION, part.source, row.utilisation, effect


def _in_groups(
    groups: Sequence[GroupTable],
    assessment: Assessment | None,
    *,
    limited_alone: bool,
) -> Iterator[Found]:
    """Yield what sources make of groups; used is 1 where nothing is required of any."""
    found: dict[str, float] = {}
    for row in assessment.outputs if assessment else ():
        title = key_title(row.output.name.group)
        found[title] = max(found.get(title, 0.0), row.utilisation)
    for group in groups:
        used = found.get(group.title, 1.0 if assessment is None else 0.0)
        for one in group.sources if used or not limited_alone else ():
            u = one.cells[first_largest([cell.u.exact for cell in one.cells])].u
            effect = Effect(share=one.share, group=group.title, u=u, unit=group.unit)
            yield one.source.owner or group.sensor, one.source, used, effect


def _from_largest(found: Sequence[tuple[Order, T]]) -> list[T]:
    """Return what is beyond a limit first, then from the largest weight down."""
    parts = (
        [(weight, one) for (is_beyond, weight), one in found if is_beyond is beyond]
        for beyond in (True, False)
    )
    return [own[k][1] for own in parts for k in from_largest([w for w, _ in own])]
