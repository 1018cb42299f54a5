"""Budgets of parameter groups: errors, contributions, check of the law."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
from budget.report.pages import line, sections
from budget.report.readings import effect_line, verdict_line
from budget.report.tables import (
    bound_number,
    group_tables,
    round_error,
    round_u,
    settings_lines,
)
from budget.report.wording import mode_sentence, not_given_lines
from budget.results import CONVENTION

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from budget.inputs.records import Procedure
    from budget.report.blocks import Block
    from budget.report.tables import GroupTable, Number
    from budget.results import Assessment, Budget, Compensation

TESTED = ("procedure", "station", "mission", "trajectory")  # roles of files


def budget_answer(budget: Budget, *, brief: bool = False) -> tuple[Section, ...]:
    """Return what stands on a terminal: the answer, all groups, what they rest on.

    In brief it is the answer, and what a reader must know beside it.
    """
    view = {"groups": group_tables(budget), "headline": headline(budget, None)}
    verdict = verdict_sections(budget, _cards)
    if brief:
        return (*verdict, *_page("brief", budget, **view))
    judged = budget.assessment
    return (
        *verdict,
        *_page("worst", budget, **view),
        *((limits_section(budget, judged),) if judged else ()),
        *_page("groups", budget, **view),
    )


def rest_sections(budget: Budget) -> tuple[Section, ...]:
    """Return what the numbers of a mission rest on, and how the law was checked."""
    digits = budget.settings.digits
    checked = line("analysis/group", "law", outputs=budget.outputs, digits=digits)
    return _page("rest", budget, checked=checked)


def filled_sections(budget: Budget) -> tuple[Section, ...]:
    """Return what stands for expected lines that are not given; nothing to refuse."""
    return _page("filled", budget)


def readings_section(
    budget: Budget, assessment: Assessment | None
) -> tuple[Section, ...]:
    """Return what other readings would change; nothing where none is open."""
    return _page("readings", budget, assessment=assessment)


def matrices_sections(budget: Budget) -> tuple[Section, ...]:
    """Return how readings become inputs, where it was asked for."""
    return _page("matrices", budget)


def _page(page: str, budget: Budget, **view: object) -> tuple[Section, ...]:
    """Return a page of a budget, or a part of one."""
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
        "effect_line": effect_line,
        "verdict_line": verdict_line,
        "AXES": AXES,
        "CONVENTION": CONVENTION,
        "TESTED": TESTED,
    }
    return sections(f"analysis/{page}", **{**common, **view})


def _rounded(found: Compensation) -> list[list[list[Number]]]:
    """Return the rows of T, then both forms of the bias; and those of their u."""
    values, us = [], []
    for output, x, u in zip(
        found.outputs, found.value, found.standard_uncertainty, strict=True
    ):
        is_bias = output.name.quantity != "T"
        bound = found.bias_lower_bound if is_bias else found.lower_bound
        values.append(round_error(float(x), float(u), output))
        us.append(bound_number(round_u(float(u), output), lower_bound=bound))
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
    sensors = {group.sensor for group in groups}
    (section,) = sections(
        "analysis/budget",
        groups=drawn,
        procedure=procedure,
        sensors=sensors,
        full=full,
    )
    return section


def _pictures(group: GroupTable, assessment: Assessment | None) -> Abreast | None:
    """Return tornado and waterfall of the critical output of a group."""
    critical = Critical.of(group, assessment)
    charts = [tornado_chart(critical), waterfall_chart(critical)]
    drawn = tuple(chart_picture(chart) for chart in charts if chart is not None)
    return Abreast(blocks=drawn) if drawn else None
