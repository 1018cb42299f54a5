"""Budgets of parameter groups: errors, contributions, check of the law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.known import Known
from budget.names import AXES
from budget.report.analysis.verdict import (
    headline,
    limits_section,
    summary,
    verdict_cards,
)
from budget.report.blocks import Abreast, Panel, Paragraph, Section
from budget.report.figures.contributions import (
    Critical,
    tornado_chart,
    waterfall_chart,
)
from budget.report.figures.rows import chart_picture
from budget.report.figures.sources import sobol_chart
from budget.report.pages import blocks, line, section, sections
from budget.report.standing import mode_sentence, not_given_lines
from budget.report.tables import (
    DASH,
    group_tables,
    round_error,
    round_u,
    settings_lines,
)
from budget.results import CONVENTION, worst_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.inputs.records import Procedure
    from budget.names import Name
    from budget.report.blocks import Block
    from budget.report.tables import GroupTable, Number, OutputRow
    from budget.results import (
        Assessment,
        Budget,
        Compensation,
        JudgedOutput,
        OutputBudget,
    )

TESTED = ("procedure", "station", "mission", "trajectory")  # roles of files


def budget_answer(budget: Budget, *, full: bool = True) -> tuple[Section, ...]:
    """Return what stands on a terminal: in full all groups, and what they rest on.

    Else it is the answer in brief, and what a reader must know beside it.
    """
    groups = group_tables(budget)
    view = {"groups": groups, "headline": headline(budget, None)}
    judged = budget.assessment
    if not full:
        return brief_sections(budget, _worst_blocks(budget, groups))
    return (
        *verdict_sections(budget, _cards),
        *page_of("worst", budget, **view),
        *((limits_section(budget, judged),) if judged else ()),
        *page_of("groups", budget, **view),
    )


def brief_sections(
    budget: Budget,
    own: Iterable[Block],
    title: str = "",
    under: Iterable[Block] = (),
) -> tuple[Section, ...]:
    """Return an answer in brief, under a title of its own where nothing is judged.

    What a verdict depends on stands right `under` it, where `own` does not say it.
    """
    judged = budget.assessment
    answer = Section(
        name="verdict",
        title=title if judged is None and title else headline(budget, judged),
        verdict="" if judged is None else judged.verdict,
        blocks=(*under, Paragraph(words=summary(budget, judged)), *own),
    )
    return (answer, *page_of("asked", budget))


def _worst_blocks(budget: Budget, groups: Sequence[GroupTable]) -> tuple[Block, ...]:
    """Return the worst output of each group, and what a reader must know beside it."""
    return blocks(
        "analysis/brief",
        budget=budget,
        assessment=budget.assessment,
        worst=[_worst(budget.assessment, group) for group in groups],
        lacks=lacking(budget),
        DASH=DASH,
    )


def lacking(budget: Budget) -> list[Name]:
    """Return the specifications not given without which numbers are bounds."""
    return list(
        dict.fromkeys(
            name for row in budget.outputs for name in row.standard_uncertainty.why
        )
    )


@dataclass(frozen=True, kw_only=True)
class WorstOutput:
    """The output of a group that uses most of its limit; without any the widest."""

    output: OutputBudget
    number: OutputRow
    limited: JudgedOutput | None


def _worst(assessment: Assessment | None, group: GroupTable) -> WorstOutput:
    """Return that of a group."""
    names = [row.output.name for row in group.outputs]
    limited = [
        row
        for row in (assessment.outputs if assessment else ())
        if row.output.name in names
    ]
    worst = worst_of(limited) if limited else None
    place = names.index(worst.output.name) if worst else group.rows.index(group.widest)
    return WorstOutput(
        output=group.outputs[place], number=group.rows[place], limited=worst
    )


def rest_sections(budget: Budget) -> tuple[Section, ...]:
    """Return what the numbers of a mission rest on, and how the law was checked."""
    digits = budget.settings.digits
    checked = line("analysis/group", "law", outputs=budget.outputs, digits=digits)
    return page_of("rest", budget, checked=checked)


def page_of(page: str, budget: Budget, **view: object) -> tuple[Section, ...]:
    """Return a page of a budget, or a part of one; nothing where it has nothing."""
    is_later = budget.settings.reference == "next_turn_on"
    sensors = dict.fromkeys(row.sensor for row in budget.outputs)
    charts = (sobol_chart(budget, sensor) for sensor in sensors)
    common = {
        "budget": budget,
        "assessment": budget.assessment,
        "mode": mode_sentence(budget.settings),
        "matrices": [(key, x, *_rounded(x)) for key, x in budget.matrices.items()],
        "charts": [chart for chart in charts if chart],
        "not_given": not_given_lines(budget.could_widen, is_later=is_later),
        "settings": settings_lines(budget.settings),
        "AXES": AXES,
        "CONVENTION": CONVENTION,
        "TESTED": TESTED,
    }
    return sections(f"analysis/{page}", **{**common, **view})


def _rounded(found: Compensation) -> list[list[list[Number]]]:
    """Return the rows of T, then both forms of the bias; and those of their u."""
    values, us = [], []
    for output, x, u, lacks in zip(
        found.outputs,
        found.value,
        found.standard_uncertainty,
        found.lacks,
        strict=True,
    ):
        values.append(round_error(float(x), float(u), output))
        us.append(round_u(Known.of(float(u), lacks), output))
    places = range(0, len(values), len(AXES))
    return [[one[k : k + len(AXES)] for k in places] for one in (values, us)]


def verdict_sections(
    budget: Budget,
    why: Callable[[Budget, Assessment], Iterable[Block]],
    under: Callable[[Assessment], Iterable[Block]] = lambda _: (),
) -> Iterator[Section]:
    """Yield the verdict, as page one of a report has it, and why; none without one.

    Right `under` the headline stands what it holds if, where `why` does not say it.
    """
    assessment = budget.assessment
    if assessment is None:
        return
    yield Section(
        name="verdict",
        title=headline(budget, assessment),
        verdict=assessment.verdict,
        blocks=(
            *under(assessment),
            Paragraph(words=summary(budget, assessment)),
            *why(budget, assessment),
        ),
    )


def _cards(budget: Budget, assessment: Assessment) -> Iterator[Block]:
    """Yield why, sensor by sensor."""
    for card in verdict_cards(budget, assessment):
        blocks = tuple(Paragraph(words=line) for line in card.lines)
        yield Panel(title=card.title, blocks=blocks)


def budget_section(
    groups: Sequence[GroupTable],
    procedure: Procedure,
    assessment: Assessment | None = None,
    *,
    full: bool = True,
) -> Section:
    """Return the budgets of all groups, their model equations, in full figures."""
    drawn = [
        (group, _pictures(group, assessment) if full else None) for group in groups
    ]
    return section(
        "analysis/budget",
        groups=drawn,
        procedure=procedure,
        sensors={group.sensor for group in groups},
        full=full,
    )


def _pictures(group: GroupTable, assessment: Assessment | None) -> Abreast | None:
    """Return tornado and waterfall of the critical output of a group."""
    critical = Critical.of(group, assessment)
    charts = [tornado_chart(critical), waterfall_chart(critical)]
    drawn = tuple(chart_picture(chart) for chart in charts if chart is not None)
    return Abreast(blocks=drawn) if drawn else None
