"""Verdict and limits of a report: margins, contributions, cards of page one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import fsum
from typing import TYPE_CHECKING, Any

from budget.language import key_title, say
from budget.names import MISSION
from budget.question import question_of
from budget.report.analysis.what_if import largest_size
from budget.report.blocks import Share, Shares
from budget.report.figures.style import OTHER, look_of
from budget.report.mission import PLANE, by_time, limits_blocks
from budget.report.pages import cards, line, runs, sections
from budget.report.standing import outcome_words
from budget.report.tables import (
    HEADING,
    SMALL_SHARE,
    Number,
    as_limited,
    join_outputs,
    largest_error,
    print_contributions,
    print_gaps,
    print_share,
    round_error,
    source_title,
    unit_for,
    used_part,
)
from budget.results import BY_LAW, worst_of
from budget.studies.conditions import calibration_words
from budget.studies.verdicts import FAILS
from budget.studies.what_if import mended

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.names import Name
    from budget.report.blocks import Card, Section, Words
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, JudgedOutput, OutputBudget
    from budget.studies.what_if import SourceSteps, WhatIf

LACKS = 2  # names of what a row lacks
MOST = 2  # cautions and assumptions on page one
# Errors of a mission that stand on page one where nothing limits it.
AT_THE_END = (("position", PLANE), ("velocity", PLANE), ("attitude", HEADING))


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


def limits_section(
    budget: Budget, assessment: Assessment, *, full: bool = True
) -> Section | None:
    """Return every required output against its limit, as a table; caps, conditions.

    Without `full` what page one does not say: axes where they differ.
    """
    coverage = budget.settings.coverage
    rows = [row for row in assessment.outputs if row.output.name.owner == MISSION]
    found = sections(
        "limits",
        full=full,
        differing=_differing(assessment),
        MOST=MOST,
        assessment=assessment,
        coverage=coverage,
        mission=limits_blocks(coverage, assessment, rows)[0],
    )
    return found[0] if found and found[0].blocks[1:] else None


def _differing(
    assessment: Assessment,
) -> list[tuple[str, list[JudgedOutput]]]:
    """Return by sensor the groups of limits whose axes differ in print."""
    groups: dict[Name, list[JudgedOutput]] = {}
    for row in assessment.outputs:
        if row.output.name.owner != MISSION:
            groups.setdefault(row.output.name.group, []).append(row)
    found: dict[str, list[JudgedOutput]] = {}
    for group, rows in groups.items():
        if len({largest_error(row).text for row in rows}) > 1:
            found.setdefault(group.owner, []).extend(rows)
    return list(found.items())


@dataclass(frozen=True, kw_only=True)
class AnswerRow:
    """What page one says of one limit, or of one group without one."""

    title: str  # 'gyro mounting angle (every axis)'
    error: Number  # the largest one, or U
    unit: str
    shares: Shares  # of its variance
    said: str  # these in words, the largest first
    gaps: str  # what the error lacks, where it is a lower bound
    limit: str = ""  # as the requirement has it
    used: Number | None = None  # part of the limit
    outcome: str = ""  # on which side of it, if anybody knows
    coverage: float | None = None  # of its interval; None: as the others [1]
    # What an error without a limit is after, where that is another calibration.
    after: str = ""
    is_within: bool = True


def answer_rows(
    budget: Budget,
    groups: Sequence[GroupTable],
    assessment: Assessment | None,
    carried: Budget | None = None,
) -> tuple[AnswerRow, ...]:
    """Return a row for each limit, the axes of a group in one; without limits for each.

    Of a group the output that uses most of its limit, or has the largest U; of a
    mission without limits its last time.
    """
    rows = [
        *(_limited(budget, assessment, carried) if assessment else map(_free, groups)),
        *([] if carried is None or carried.assessment else _at_the_end(carried)),
    ]
    return tuple(rows)


def _limited(
    budget: Budget, assessment: Assessment, carried: Budget | None
) -> Iterator[AnswerRow]:
    """Yield what is held against limits."""
    groups: dict[object, list[JudgedOutput]] = {}
    for row in assessment.judged:
        name = row.output.name
        groups.setdefault(name if name.owner == MISSION else name.group, []).append(row)
    for rows in groups.values():
        row = as_limited(worst_of(rows))
        name = row.output.name
        of = carried if carried and name.owner == MISSION else budget
        names = [row.output.name for row in rows]
        error = largest_error(row)
        tied = [
            one.output.name
            for one in rows
            if largest_error(
                replace(one, output=replace(row.output, name=one.output.name))
            ).text
            == error.text
        ]
        yield AnswerRow(
            title=join_outputs(tied),
            error=error,
            unit=row.output.unit,
            limit=row.printed_limit,
            used=used_part(row),
            is_within=row.is_within,
            outcome=outcome_words(assessment, worst_of(rows)),
            coverage=row.coverage,
            **_made_of(of.output(name), [name, *names]),
        )


def _free(group: GroupTable) -> AnswerRow:
    """Return what is known of a group without a limit."""
    place = group.rows.index(group.widest)
    row = group.rows[place]
    own = [one.output.name for one in group.outputs]
    tied = [
        name
        for name, one in zip(own, group.rows, strict=True)
        if one.expanded.text == row.expanded.text
    ]
    return AnswerRow(
        title=join_outputs(tied),
        error=row.expanded,
        unit=group.unit,
        **_made_of(group.outputs[place], [own[place], *own]),
    )


def _at_the_end(carried: Budget) -> Iterator[AnswerRow]:
    """Yield the errors at the last time of a mission that has no limits."""
    end = by_time(carried)[-1]
    for quantity, axis in AT_THE_END:
        row = end.row(quantity, axis)
        if row is not None and not row.standard_uncertainty.is_unknown:
            like = HEADING if axis == HEADING else quantity
            unit, scale = unit_for(like, row.largest_error)
            output = replace(row.output, unit=unit, si_per_unit=scale)
            yield AnswerRow(
                title=key_title(row.output.name),
                error=round_error(row.largest_error, row.standard_uncertainty, output),
                unit=unit,
                after=calibration_words(question_of(carried).procedure),
                **_made_of(row, [row.output.name]),
            )


def _made_of(row: OutputBudget, outputs: Sequence[Name]) -> dict[str, Any]:
    """Return the shares of the variance of an output, as a bar and in words."""
    owner = row.output.name.owner
    ranked = row.ranked if row.is_resolved else ()
    titles = [(source_title(one.source, of=owner), one) for one in ranked]
    parts = [
        Share(
            name=one.source,
            text=f"{title} {print_share(one.share)}",
            share=one.share,
            colour=look_of(one.source)[0],
        )
        for title, one in titles
        if one.share >= SMALL_SHARE
    ]
    rest = fsum(one.share for one in ranked[len(parts) :])
    if parts and rest >= SMALL_SHARE:
        text = say("rest {rest}", rest=print_share(rest))
        parts.append(Share(name=OTHER, text=text, share=rest, colour=look_of(OTHER)[0]))
    return {
        "shares": Shares(outputs=tuple(dict.fromkeys(outputs)), parts=tuple(parts)),
        "said": print_contributions([(title, one.share) for title, one in titles]),
        "gaps": print_gaps([row], most=LACKS),
    }


@dataclass(frozen=True, kw_only=True)
class Mend:
    """One specification that alone would make a sensor meet, the others as they are."""

    source: Name
    now: str  # as the file gives it
    most: str  # that it may be


def mends(
    model: WhatIf, rows: Sequence[SourceSteps], budget: Budget, assessment: Assessment
) -> dict[str, Mend]:
    """Return for sensors that fail the specification that need be improved least.

    Nothing of those that no single one would make meet, that others stand for, or
    whose intervals are of trials: what these become is not known here.
    """
    filled = {one.source for one in budget.filled}
    steps = {one.source.name: one for one in rows}
    found = {}
    for sensor in assessment.sensors:
        own = [
            one for one in assessment.outputs if one.output.name.owner == sensor.sensor
        ]
        by_law = all(one.interval_by == BY_LAW for one in own)
        best = (
            mended(model, sensor.sensor) if sensor.verdict == FAILS and by_law else None
        )
        if best is None or best[0].name in filled or best[0].name not in steps:
            continue
        source, factor = best
        if most := largest_size(replace(steps[source.name], most=factor)):
            found[sensor.sensor] = Mend(
                source=source.name, now=source.printed, most=most
            )
    return found
