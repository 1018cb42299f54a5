"""Report on a budget as one document, from verdict to provenance."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

from budget.inputs.records import UNCALIBRATED
from budget.language import key_title, say
from budget.report.analysis.groups import (
    budget_section,
    filled_sections,
    matrices_sections,
    readings_section,
)
from budget.report.analysis.method import Trials, method_section
from budget.report.analysis.mission import mission_card
from budget.report.analysis.station import station_section
from budget.report.analysis.verdict import (
    group_cards,
    headline,
    judged_by,
    limits_section,
    rank_contributions,
    summary,
    verdict_cards,
)
from budget.report.analysis.what_if import what_if_section
from budget.report.blocks import (
    Abreast,
    Document,
    Listing,
    Panel,
    Paragraph,
    Run,
    Section,
)
from budget.report.document import to_json
from budget.report.figures.contributions import correlation_chart
from budget.report.figures.density import density_picture
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import chart_picture
from budget.report.figures.sources import coupling_chart, sobol_chart
from budget.report.inputs import (
    inputs_section,
    print_degrees,
    procedure_section,
)
from budget.report.provenance import provenance_section, sign_off_section
from budget.report.tables import group_tables, print_count
from budget.report.wording import capital, not_given_lines, parted, points, say_words
from budget.studies.request import analysis_of, sensors_of
from budget.studies.verdicts import calibration_words
from budget.studies.what_if import one_at_a_time
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from budget.inputs.records import Device, Mission, Procedure
    from budget.report.analysis.verdict import LargestContribution
    from budget.report.analysis.what_if import AnalyzeAgain
    from budget.report.blocks import Picture, Words
    from budget.report.figures.rows import Chart
    from budget.report.formulas import Math
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, InputFile
    from budget.studies.allocation.records import Allocation
    from budget.studies.comparison.records import Comparison
    from budget.studies.evidence import Evidence


@dataclass(frozen=True, kw_only=True)
class Extra:
    """What another study adds to a report."""

    key: str  # of its numbers in the JSON document: 'allocation'
    content: Mapping[str, Any]  # those numbers
    sections: tuple[Section, ...]
    # What it depends on; the device of the report is called so, others by the key.
    inputs: tuple[InputFile, ...]
    warnings: tuple[str, ...] = ()  # what a reader of page one must know of it
    carried: Budget | None = None  # of a mission, whose limits are judged with the rest

    @classmethod
    def of(
        cls, key: str, found: Allocation | Comparison, sections: tuple[Section, ...]
    ) -> Extra:
        """Return what a study found, and its sections."""
        return cls(
            key=key,
            content=found.to_dict(),
            sections=sections,
            inputs=found.inputs,
            warnings=found.warnings,
        )


def report_document(
    budget: Budget,
    *,
    devices: Sequence[Device],
    procedure: Procedure,
    evidence: Evidence,
    assessment: Assessment | None = None,
    extras: Sequence[Extra] = (),
    command_line: str,
    again: AnalyzeAgain | None = None,
    date: str,
    number: str = "",
) -> Document:
    """Put a budget and what stands behind it into one document.

    The evidence is that of `gather_evidence` for the same budget; the command line is
    without output names, `again` are those of a changed device; `number` is that of the
    report for the one who files it.
    """
    groups = group_tables(budget)
    owners = tuple(dict.fromkeys(group.sensor for group in groups))
    sensors = tuple(sensor.kind for sensor in sensors_of(devices, procedure))
    carried = next((one.carried for one in extras if one.carried is not None), None)
    cards = (
        group_cards(groups)
        if assessment is None
        else verdict_cards(budget, assessment, carried)
    )
    if carried is not None and carried.assessment is None:
        cards = (*cards, mission_card(carried))
    rows = one_at_a_time(evidence.what_if)
    latitude = print_degrees(procedure.latitude)
    judged = judged_by(budget, carried)
    own = procedure if judged is budget else analysis_of(judged).procedure
    is_beside = own.formulas in UNCALIBRATED
    found: list[Section | None] = [
        _overview(groups, assessment),
        _contributions(
            rank_contributions(groups, devices, procedure, assessment, carried)
        ),
        _gaps(budget, extras),
        *filled_sections(budget),
        None if assessment is None else limits_section(budget, assessment),
        *readings_section(budget, assessment),
        what_if_section(budget, evidence.what_if, rows, devices=devices, again=again),
        inputs_section(devices, procedure),
        procedure_section(procedure, sensors),
        budget_section(groups, assessment),
        _correlation(budget),
        *matrices_sections(budget),
        station_section(budget, groups, procedure, assessment, evidence.unfelt),
        _coupling(evidence, owners),
        _indices(budget, owners),
        _validity(budget, owners),
        _distributions(budget, evidence),
        *(section for extra in extras for section in extra.sections),
        method_section(
            budget.settings,
            procedure,
            devices,
            sensors,
            _trials(budget, evidence),
            of_verdict=judged.settings,
        ),
        provenance_section(
            (*budget.inputs, *_further_inputs(budget, extras)),
            budget.settings,
            version=__version__,
            command_line=command_line,
        ),
        sign_off_section(),
    ]
    return Document(
        kind="report",
        title=budget.title,
        facts=(
            *((say("report {number}", number=number),) if number else ()),
            say(
                "{calibration}; beside it the budget of procedure {name}, latitude "
                "{latitude} deg"
                if is_beside
                else "procedure {name}, latitude {latitude} deg",
                calibration=capital(say(calibration_words(own))),
                name=procedure.name,
                latitude=latitude,
            ),
            *((_mission_fact(carried.mission),) if carried and carried.mission else ()),
        ),
        headline=headline(budget, assessment),
        summary=summary(budget, assessment, carried),
        cards=cards,
        sections=tuple(section for section in found if section is not None),
        json=to_json(
            budget,
            {
                "one_at_a_time": [row.to_dict() for row in rows],
                **{extra.key: extra.content for extra in extras},
            },
        ),
        date=date,
        version=__version__,
    )


def _mission_fact(mission: Mission) -> str:
    """Say where a mission begins: not where the calibration was."""
    return say(
        "mission {name}, from latitude {latitude} deg",
        name=mission.name,
        latitude=print_degrees(float(mission.route.first.latitude)),
    )


def _trials(budget: Budget, evidence: Evidence) -> Trials:
    """Count the trials that stand beside those of the method."""
    checks = [row.validation.trials for row in budget.outputs if row.validation]
    return Trials(
        check=max(checks, default=0),
        densities=max((density.trials for density in evidence.densities), default=0),
    )


def _further_inputs(budget: Budget, extras: Sequence[Extra]) -> tuple[InputFile, ...]:
    """Return the files that only the further studies depend on, named by them."""
    known = {(file.name, file.sha256) for file in budget.inputs}
    further = [
        replace(
            file, role=say("{key}, {role}", key=say(extra.key), role=say(file.role))
        )
        for extra in extras
        for file in extra.inputs
        if (file.name, file.sha256) not in known
    ]
    return tuple(dict.fromkeys(further))


def _overview(
    groups: Sequence[GroupTable], assessment: Assessment | None
) -> Section | None:
    """Return the figure of page one: limits used, or U of every group."""
    chart = None
    if assessment is None:
        chart = overview_chart(groups)
    elif assessment.judged:
        chart = utilisation_chart(replace(assessment, outputs=assessment.judged))
    if chart is None:
        return None
    picture = chart_picture(chart)
    title = say("What is left") if assessment is None else say("Against the limits")
    return Section(name="overview", title=title, blocks=(picture,), on_first_page=True)


def _contributions(contributions: Sequence[LargestContribution]) -> Section:
    """Return the largest contributions in words with numbers."""
    several = len(contributions)
    return Section(
        name="contributions",
        title=say("The {several} largest contributions", several=several)
        if several > 1
        else say("Contributions"),
        blocks=(
            Listing(
                items=tuple(map(_contribution_words, contributions)),
                empty=say("Nothing varies: no output has any spread."),
                numbered=True,
            ),
        ),
        on_first_page=True,
    )


def _contribution_words(contribution: LargestContribution) -> Words:
    """Say what one source makes of the variance of each group."""
    words: list[str | Run | Math] = [
        Run(text=capital(contribution.title), strong=True),
        say(" ({printed}) contributes ", printed=contribution.printed)
        if contribution.printed
        else say(" contributes "),
    ]
    last = len(contribution.effects) - 1
    for place, effect in enumerate(contribution.effects):
        words += [
            *say_words(
                "{share} of the variance of {group} (alone u\N{NO-BREAK SPACE}{u})"
                if effect.is_on_mission
                else "{share} of the {group} variance (alone u\N{NO-BREAK SPACE}{u})",
                share=Run(text=effect.share.text, exact=effect.share.exact),
                group=effect.group,
                u=Run(text=f"{effect.u.text} {effect.unit}", exact=effect.u.exact),
            ),
            say(".")
            if place == last
            else say(" and ")
            if place == last - 1
            else say(", "),
        ]
    return tuple(words)


def _gaps(budget: Budget, extras: Sequence[Extra]) -> Section:
    """Return what is not given, what is assumed, and what to beware of."""
    warnings = chain(
        map(say, budget.warnings),
        (
            say("{key}: {text}", key=say(extra.key), text=say(text))
            for extra in extras
            for text in extra.warnings
            if text not in budget.warnings
        ),
    )
    own = [budget, *(one.carried for one in extras if one.carried is not None)]
    reach = {
        name: tuple(output for one in own for output in one.could_widen.get(name, ()))
        for name in dict.fromkeys(name for one in own for name in one.could_widen)
    }
    is_later = any(one.settings.reference == "next_turn_on" for one in own)
    missing = not_given_lines(reach, is_later=is_later)
    lists = (
        (
            say("Not given"),
            [say("{line}.", line=capital(line)) for line in missing],
            say("Every line that the model knows is given."),
        ),
        (
            say("Assumptions"),
            [capital(_in_words(text)) for text in budget.assumptions],
            say("None beyond what the files say."),
        ),
        (say("Warnings"), warnings, say("None.")),
    )
    return Section(
        name="gaps",
        title=say("What is missing and what is assumed"),
        blocks=(
            Abreast(
                blocks=tuple(
                    Panel(
                        title=title, blocks=(Listing(items=points(lines), empty=empty),)
                    )
                    for title, lines, empty in lists
                ),
                columns=3,
            ),
        ),
        on_first_page=True,
    )


def _in_words(assumption: str) -> str:
    """Write the key that an assumption begins with as words."""
    key, assumed = parted(assumption)
    if re.fullmatch(r"[a-z_.]+", key) is None or not assumed:
        return say(assumption)
    return say("{key}: {text}", key=key_title(key), text=assumed)


def _correlation(budget: Budget) -> Section:
    """Return which outputs go together."""
    chart = correlation_chart(budget)
    text = say(
        "Sources that reach several outputs make them go together; the covariance of "
        "all is in the JSON document. "
    )
    if chart is None:
        text += say("No two outputs have a correlation of 1 % or more.")
    pictures = () if chart is None else (chart_picture(chart),)
    return Section(
        name="correlation",
        title=say("Correlation of outputs"),
        blocks=(Paragraph(words=(text.rstrip(),)), *pictures),
    )


def _coupling(evidence: Evidence, sensors: Sequence[str]) -> Section | None:
    """Return which source reaches which parameters."""
    text = say(
        "Each source alone, by the law: its standard uncertainty over that of all "
        "sources together, the largest over the axes of a group. Empty: it does not "
        "reach the group, to the rounding of the computation."
    )
    return _by_sensor(
        "coupling",
        say("Coupling"),
        text,
        _drawn(coupling_chart(evidence.coupling, sensor) for sensor in sensors),
    )


def _indices(budget: Budget, sensors: Sequence[str]) -> Section | None:
    """Return Sobol' indices with their intervals."""
    settings = budget.settings
    text = say(
        "Part of the variance that a source contributes alone (first "
        "order) and with all its products (total), with 95 % "
        "intervals over {sobol_scrambles} independent scrambles of "
        "{sobol_samples} points; of the output of each group with "
        "the largest spread. Those of all outputs are in the JSON "
        "document.",
        sobol_scrambles=settings.sobol_scrambles,
        sobol_samples=settings.sobol_samples,
    )
    return _by_sensor(
        "indices",
        say("Sobol' indices"),
        text,
        _drawn(sobol_chart(budget, sensor) for sensor in sensors),
    )


def _validity(budget: Budget, sensors: Sequence[str]) -> Section | None:
    """Return the law against Monte Carlo."""
    text = say(
        "Both ends of the coverage interval by the law, less those by Monte Carlo, in "
        "numerical tolerances of the standard uncertainty (JCGM 101:2008, 8.1): within "
        "the band the law may be trusted."
    )
    return _by_sensor(
        "validity",
        say("The law against Monte Carlo"),
        text,
        _drawn(validity_chart(budget, sensor) for sensor in sensors),
    )


def _distributions(budget: Budget, evidence: Evidence) -> Section | None:
    """Return how the errors of the critical outputs are distributed."""
    text = say(
        "Of each group of parameters the output that uses most of its limit or, where "
        "nothing is required, has the largest spread. "
    )
    if evidence.densities:
        trials = print_count(max(one.trials for one in evidence.densities))
        text += say(
            "Area: {trials} trials, those beyond a limit in full "
            "colour; line: the normal law.",
            trials=trials,
        )
    coverage = budget.settings.coverage
    return _by_sensor(
        "distributions",
        say("Distributions"),
        text,
        (density_picture(density, coverage=coverage) for density in evidence.densities),
    )


def _drawn(charts: Iterable[Chart | None]) -> Iterator[Picture]:
    """Draw the figures that there are."""
    return (chart_picture(chart) for chart in charts if chart is not None)


def _by_sensor(
    name: str, title: str, text: str, pictures: Iterable[Picture | None]
) -> Section | None:
    """Return figures beside each other under what they show; None without any."""
    drawn = tuple(picture for picture in pictures if picture is not None)
    if not drawn:
        return None
    return Section(
        name=name,
        title=title,
        blocks=(Paragraph(words=(text,)), Abreast(blocks=drawn)),
    )
