"""A mission on a terminal: the finding, errors by time, main contributors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.calibration.problem import MEASURED
from budget.inputs.records import UNCALIBRATED
from budget.model.sources import DEVICE, SHARED, TURN_ON, source_of
from budget.names import MISSION
from budget.question import question_of
from budget.report.analysis.groups import (
    brief_sections,
    lacking,
    rest_sections,
    verdict_sections,
)
from budget.report.analysis.verdict import answer_rows
from budget.report.blocks import Abreast, Card, Paragraph, Run
from budget.report.document import to_json
from budget.report.figures.growth import growth_pictures
from budget.report.figures.track import Way, track_plot
from budget.report.inputs import inputs_section, print_degrees
from budget.report.mission import (
    PLANE,
    bought,
    by_time,
    contributions,
    filtered,
    limits_blocks,
    rate_per_hour,
    units_of,
)
from budget.report.pages import document, sections
from budget.report.provenance import endings
from budget.report.route import way_of
from budget.report.standing import (
    NAMES,
    counting,
    deciding_lines,
    keyed,
    missing,
    standing_blocks,
)
from budget.report.tables import (
    SMALL_SHARE,
    full_title,
    of_the_variance,
    print_coverage,
)
from budget.report.writing import capital
from budget.results import BY_PREDICTION
from budget.studies.conditions import calibration_words, use_words
from budget.studies.mission import curve, drawn_times

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.report.blocks import Block, Document, Picture, Section
    from budget.results import Assessment, Budget
    from budget.studies.mission import Curve

# Sections on a terminal that page one, cautions and inputs of a page have.
ON_PAGE_ONE = {"not-given", "assumptions", "warnings"}
MOST = 4  # cautions and assumptions on page one
ASSUMED = 3  # assumptions of an answer in brief
SPANS = 3  # of an aid, which are shown
NOT_LEARNT = 0.9  # of what was there before, from which on it is not learnt [1]


def mission_answer(budget: Budget, *, full: bool = True) -> tuple[Section, ...]:
    """Return what stands on a terminal: finding, tables, what they rest on.

    Else the answer in brief, and what a reader must know beside it.
    """
    if not full:
        (found,) = _page("mission_brief", budget)
        judged = budget.assessment
        limits = () if judged is None else mission_limits(budget, judged)
        own = (*limits, *found.blocks)
        return brief_sections(budget, own, found.title, _deciding(judged))
    return (
        *verdict_sections(budget, mission_limits, _conditions),
        *_page("mission", budget),
        *rest_sections(budget),
    )


def _deciding(assessment: Assessment | None) -> Iterator[Block]:
    """Yield what the verdict depends on."""
    for sensor in assessment.sensors if assessment else ():
        for said in deciding_lines(sensor):
            yield Paragraph(words=(Run(text=f"{capital(said)}.", strong=True),))


def _conditions(assessment: Assessment) -> Iterator[Block]:
    """Yield what the verdict stands on."""
    for sensor in assessment.sensors:
        yield from standing_blocks(sensor)


def mission_section(budget: Budget, figures: Sequence[Picture] = ()) -> Section:
    """Return a mission in a report: finding, tables, figures, method."""
    drawn = Abreast(blocks=tuple(figures)) if figures else None
    (section,) = _page("mission", budget, drawn)
    return section


def mission_document(
    budget: Budget, *, date: str, command_line: str = "budget mission"
) -> Document:
    """Put a mission into one document: the finding, errors, what they rest on."""
    question, assessment = question_of(budget), budget.assessment
    (section,) = _page("mission", budget, Abreast(blocks=()), assessment is None)
    rests = _rests(budget)
    whole, brief = missing([budget]), missing([budget], NAMES)
    found = document(
        "mission_page",
        **_view(budget),
        degrees=print_degrees,
        limits=assessment and next(mission_limits(budget, assessment)),
        rows=answer_rows(budget, (), assessment, budget),
        coverage=print_coverage(budget.settings.coverage),
        pictures=mission_figures(budget),
        below=section.blocks,
        absent=brief,
        MOST=MOST,
        rest=[
            one
            for one in rest_sections(budget)
            if one.blocks and one.name not in ON_PAGE_ONE
        ],
    )
    return found.whole(
        "mission",
        inputs_section(
            question.devices,
            question.procedure,
            absent=() if whole == brief else whole,
            assumed=[one for one in budget.assumptions if one not in rests[:MOST]],
            parted=keyed,
        ),
        *endings(budget.inputs, budget.settings, command_line=command_line),
        json=to_json(budget),
        date=date,
    )


def mission_figures(budget: Budget) -> tuple[Picture, ...]:
    """Return the figures of a mission, that of page one first; () if none varies.

    Its errors over time, and where they are.
    """
    question = question_of(budget)
    asked = sorted({row.output.name.time or 0.0 for row in budget.outputs})
    times = () if question.mission is None else drawn_times(question.mission, asked)
    limits = () if budget.assessment is None else budget.assessment.outputs
    found = curve(question, times)
    way = way_with_errors(budget, found)
    track = () if way is None else (track_plot(way).picture,)
    return (*growth_pictures(found, limits), *track)


def way_with_errors(budget: Budget, found: Curve) -> Way | None:
    """Return the track of a mission with ellipses at the times that are asked for."""
    journey = question_of(budget).journey
    if journey is None:
        return None
    times = [one.time for one in by_time(budget)]
    return Way.of(journey.route, found, times, budget.settings.coverage)


def mission_card(budget: Budget) -> Card:
    """Return the finding on page one, where no limit is on the mission."""
    (section,) = _page("mission_card", budget)
    lines = (one.words for one in section.blocks if isinstance(one, Paragraph))
    return Card(title=section.title, lines=tuple(lines))


def _page(
    page: str,
    budget: Budget,
    drawn: Block | None = None,
    is_said: bool = False,  # noqa: FBT001, FBT002 - of one caller
) -> tuple[Section, ...]:
    """Return a page of a mission, without its finding where that `is_said` already."""
    return sections(page, drawn=drawn, is_said=is_said, **_view(budget))


def _rests(budget: Budget) -> tuple[str, ...]:
    """Return what the errors rest on: its environment, assumptions that count.

    Without those that a section of their own has: what stands for what is not given.
    """
    use = use_words(question_of(budget).procedure, is_later=True)
    filled = {one.source for one in budget.filled}
    own = (one for one in counting([budget]) if keyed(one)[0] not in filled)
    return (*(() if budget.assessment else (use,)), *own)


def _view(budget: Budget) -> dict[str, object]:
    """Return what a page of a mission is filled in with."""
    moments = by_time(budget)
    end = next((one for one in reversed(moments) if one.horizontal is not None), None)
    because = budget.bought[-1].because if budget.bought else None
    mission = budget.mission
    return {
        "budget": budget,
        "assessment": budget.assessment,
        "mission": mission,
        "calibration": calibration_words(question_of(budget).procedure),
        "way": mission and way_of(mission.route),
        "moments": moments,
        "units": units_of(moments),
        "units_of": units_of,
        "end": end if end and end.horizontal and end.horizontal.radii else None,
        "lost": [one for one in moments if one.is_lost],
        "rate": rate_per_hour(moments),
        "is_predicted": any(x.interval_by == BY_PREDICTION for x in budget.outputs),
        "lacks": lacking(budget),
        "rests": _rests(budget),
        "parted": keyed,
        "ASSUMED": ASSUMED,
        "SMALL_SHARE": SMALL_SHARE,
        "bought": bought(budget, moments),
        "tested": len(budget.bought) > len(UNCALIBRATED),
        "because": because,
        "source": because
        and because != MEASURED
        and source_of(because.owner, because.quantity),
        "PLANE": PLANE,
        "SPANS": SPANS,
        "NOT_LEARNT": NOT_LEARNT,
        "SHARED": SHARED,
        "STAYING": (DEVICE, TURN_ON),
        **contributions(moments),
        **filtered(budget),
    }


def mission_limits(budget: Budget, assessment: Assessment) -> Iterator[Block]:
    """Yield the limits on a mission as a table, and what uses most of one."""
    worst = [one.worst_output for one in assessment.sensors if one.sensor == MISSION]
    yield from limits_blocks(
        budget.settings.coverage,
        assessment,
        [row for row in assessment.outputs if row.output.name.owner == MISSION],
        [
            (
                name,
                of_the_variance(
                    [
                        (full_title(part.source), part.share)
                        for part in budget.output(name).contributions
                    ]
                ),
            )
            for name in worst
        ],
    )
