"""Station section of a report: errors by table, place, timing and environment."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum, sqrt
from typing import TYPE_CHECKING

from budget.inputs.use import LINES
from budget.known import Known
from budget.model.sources import SENSORS, SHARED, source_of
from budget.question import given_lines
from budget.report.pages import section
from budget.report.tables import (
    NO_SHARE,
    SMALL_SHARE,
    Number,
    print_contributions,
    print_utilisation,
    source_title,
    used_part,
)
from budget.results import INTERACTION
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from budget.inputs.records import Procedure
    from budget.names import Name
    from budget.report.blocks import Section
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, JudgedOutput, OutputBudget
    from budget.studies.cautions import Unfelt

LEAST_SAID = 0.001  # share of a variance that is printed as a number [1]


def station_section(
    budget: Budget,
    groups: Sequence[GroupTable],
    procedure: Procedure,
    assessment: Assessment | None,
    unfelt: Sequence[Unfelt],
    *,
    full: bool = True,
) -> Section | None:
    """Return what the station and the environment make of the budget.

    None where the procedure gives no line of either. Without `full` what adds less than
    0.1 % everywhere is gathered.
    """
    lines = {
        name: line
        for name, line in given_lines((), procedure).items()
        # A use as in the test is stated, and makes nothing.
        if line.u.any() or name.quantity not in LINES
    }
    if not lines:
        return None
    owners = [one for one in SHARED if any(name.owner == one for name in lines)]
    sources = {name: source_of(name.owner, name.quantity) for name in lines}
    row, most = _most(budget, owners)
    parts = [
        (source_title(part.source), part.share)
        for part in row.ranked
        if part.source.owner in owners
    ]
    judged = _judged(budget, owners, assessment)
    reasons: dict[tuple[str, str], list[Name]] = {}
    for one in unfelt:
        if one.source.owner in SHARED:
            reason = (one.removed, "" if one.removed else one.needs)
            reasons.setdefault(reason, []).append(one.source)
    slight = [
        name
        for name, source in sources.items()
        if source.varies and max(_by_group(groups, [name])) < LEAST_SAID
    ]
    return section(
        "analysis/station",
        budget=budget,
        groups=groups,
        owners=owners,
        lines=lines,
        # Lines of a sensor that a known size acts by.
        known={
            name: getattr(source.effect, "partners", ())
            for name, source in sources.items()
            if not source.varies
        },
        row=row,
        most=most,
        own=_share(row, SENSORS),
        by=print_contributions(parts)
        if any(share >= SMALL_SHARE for _, share in parts[:1])
        else "".join(title for title, _ in parts[:1]),
        judged=judged,
        worst=_worst(judged, owners),
        idle={one.source: one for one in unfelt},
        reasons=[(*reason, names) for reason, names in reasons.items()],
        acts_on=lambda name: _acts_on(budget, name),
        by_group=lambda names: _by_group(groups, names),
        slight=slight if len(slight) > 1 and not full else [],
        used_part=used_part,
        SENSORS=SENSORS,
        INTERACTION=INTERACTION,
        NO_SHARE=NO_SHARE,
        LEAST_SAID=LEAST_SAID,
    )


def _share(row: OutputBudget, names: Collection[str]) -> float:
    """Return the share of sources, or of all of some owners, in a variance."""
    if not row.is_resolved:
        return 0.0
    return fsum(
        part.share
        for part in row.contributions
        if part.source in names or part.source.owner in names
    )


def _most(budget: Budget, names: Collection[str]) -> tuple[OutputBudget, float]:
    """Return the output of whose variance sources make most, and how much."""
    shares = [_share(row, names) for row in budget.outputs]
    return budget.outputs[first_largest(shares)], max(shares)


def _acts_on(budget: Budget, name: Name) -> tuple[Name, float] | None:
    """Return the output that a source acts most on, and its share; None if on none."""
    row, most = _most(budget, (name,))
    return (row.output.name, most) if most > NO_SHARE else None


def _by_group(groups: Sequence[GroupTable], names: Collection[str]) -> list[float]:
    """Return the share of sources, or of all of some owners, in each group."""
    return [
        fsum(
            row.share.exact
            for row in group.sources
            if row.source in names or row.source.owner in names
        )
        for group in groups
    ]


@dataclass(frozen=True, kw_only=True)
class LimitedBudget:
    """A required output, and what it is made of."""

    row: OutputBudget
    limit: JudgedOutput

    def used_by(self, owners: Sequence[str]) -> Number:
        """Return U by the sources of those owners alone, over the limit."""
        low, high = self.limit.interval
        k = 0.5 * (high - low) / self.limit.standard_uncertainty
        variance = fsum(
            part.standard_uncertainty**2
            for part in self.row.contributions
            if part.source.owner in owners
        )
        u = sqrt(variance)
        used = k * u / self.limit.limit if u > self.row.output.resolution else 0.0
        known = Known.of(
            used, self.row.standard_uncertainty.why if owners == SENSORS else ()
        )
        return Number.of(known, print_utilisation(used) if used else "0 %")


def _judged(
    budget: Budget, owners: Sequence[str], assessment: Assessment | None
) -> list[LimitedBudget]:
    """Return of each group of limits the output where these owners use most.

    Of those that have any spread.
    """
    rows = {row.output.name: row for row in budget.outputs if row.is_resolved}
    groups: dict[Name, list[LimitedBudget]] = {}
    for one in assessment.judged if assessment else ():
        name = one.output.name
        if name in rows:  # not those of a mission
            judged = LimitedBudget(row=rows[name], limit=one)
            groups.setdefault(name.group, []).append(judged)
    return [found for own in groups.values() if (found := _worst(own, owners))]


def _worst(
    judged: Sequence[LimitedBudget], owners: Sequence[str]
) -> LimitedBudget | None:
    """Return the output where these owners use most of its limit."""
    used = [one.used_by(owners).exact for one in judged]
    return judged[first_largest(used)] if used else None
