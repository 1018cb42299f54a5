"""Report on a budget as one document, from verdict to provenance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain
from typing import TYPE_CHECKING, Any

from budget.inputs.records import UNCALIBRATED
from budget.question import question_of, sensors_of
from budget.report.analysis.groups import (
    budget_section,
    page_of,
)
from budget.report.analysis.method import Trials, method_section
from budget.report.analysis.mission import mission_card
from budget.report.analysis.station import station_section
from budget.report.analysis.verdict import (
    MOST,
    answer_rows,
    judged_by,
    limits_section,
    mends,
)
from budget.report.analysis.what_if import in_page_units, what_if_section
from budget.report.document import to_json
from budget.report.figures.contributions import correlation_chart
from budget.report.figures.density import density_plot
from budget.report.figures.outputs import validity_chart
from budget.report.figures.rows import chart_picture
from budget.report.figures.sources import coupling_chart, sobol_chart
from budget.report.inputs import (
    inputs_section,
    print_degrees,
    procedure_section,
)
from budget.report.pages import document, line, section
from budget.report.provenance import provenance_section
from budget.report.standing import NAMES, counting, keyed, missing
from budget.report.tables import group_tables, print_coverage
from budget.studies.conditions import calibration_words
from budget.studies.evidence import in_doubt
from budget.studies.what_if import one_at_a_time

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from budget.inputs.records import Device, Procedure
    from budget.report.analysis.what_if import AnalyzeAgain
    from budget.report.blocks import Block, Document, Picture, Section
    from budget.report.figures.rows import Chart
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
    growth: Block | None = None  # the figure of it on page one

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
    full: bool = True,
) -> Document:
    """Put a budget and what stands behind it into one document.

    Without `full` what a reviewer reads: formulas, schedule and figures that have
    nothing to say are left out. The evidence is that of `gather_evidence` for the same
    budget; the command line is without output names, `again` are those of a changed
    device; `number` is that of the report for the one who files it.
    """
    groups = group_tables(budget)
    owners = tuple(dict.fromkeys(group.sensor for group in groups))
    sensors = tuple(sensor.kind for sensor in sensors_of(devices, procedure))
    carried = next((one.carried for one in extras if one.carried is not None), None)
    model = in_page_units(evidence.what_if, assessment, carried)
    rows = one_at_a_time(model)
    judged = judged_by(budget, carried)
    budgets = [budget, *([carried] if carried else [])]
    own = procedure if judged is budget else question_of(judged).procedure
    assumed, brief = counting(budgets), missing(budgets, NAMES)
    made = {
        "filled": page_of("filled", budget),
        "limits": assessment and limits_section(budget, assessment, full=full),
        "readings": page_of("readings", budget, assessment=assessment),
        "what_if": what_if_section(budget, model, rows, devices=devices, again=again),
        "inputs": inputs_section(
            devices,
            procedure,
            absent=() if (whole := missing(budgets)) == brief else whole,
            assumed=[text for text in budget.assumptions if text not in assumed[:MOST]],
            parted=keyed,
            full=full,
        ),
        "procedure": procedure_section(procedure, sensors, full=full),
        "budget": budget_section(groups, procedure, assessment, full=full),
        "matrices": page_of("matrices", budget),
        "station": station_section(
            budget, groups, procedure, assessment, evidence.unfelt, full=full
        ),
        "studies": chain(*(extra.sections for extra in extras)),
        "method": method_section(
            budget.settings,
            procedure,
            devices,
            _trials(budget, evidence),
            of_verdict=judged.settings,
            full=full,
        ),
        "provenance": provenance_section(
            (*budget.inputs, *_further_inputs(budget, extras)),
            budget.settings,
            command_line=command_line,
        ),
        "sign_off": section("sign_off"),
    }
    found = document(
        "report",
        budget=budget,
        assessment=assessment,
        carried=carried,
        settings=judged.settings,
        extras=extras,
        groups=groups,
        number=number,
        procedure=procedure,
        calibration=calibration_words(own) if own.formulas in UNCALIBRATED else None,
        degrees=print_degrees,
        rows=answer_rows(budget, groups, assessment, carried),
        coverage=print_coverage(judged.settings.coverage),
        mends=mends(evidence.what_if, rows, judged, assessment) if assessment else {},
        absent=brief,
        counting=assumed,
        parted=keyed,
        MOST=MOST,
        cautioned=assessment.sensors if assessment else (),
        growth=next((one.growth for one in extras if one.growth is not None), None),
        correlation=_drawn([correlation_chart(budget)]),
        coupling=_drawn(
            coupling_chart(evidence.coupling, one)
            for one in owners
            if evidence.coupling is not None
        ),
        sobol=budget.settings.samples is not None,
        indices=_drawn(
            sobol_chart(budget, one)
            for one in owners
            if full or _interacts(budget, one)
        ),
        validity=_drawn(
            validity_chart(budget, one) for one in owners if full or in_doubt(budget)
        ),
        densities=evidence.densities,
        distributions=[
            density_plot(one, coverage=budget.settings.coverage).picture
            for one in evidence.densities
        ],
        made=made,
    )
    if carried is not None and carried.assessment is None:
        found = replace(found, cards=(*found.cards, mission_card(carried)))
    further = {
        "one_at_a_time": [row.to_dict() for row in rows],
        **{extra.key: extra.content for extra in extras},
    }
    return found.whole("report", json=to_json(budget, further), date=date)


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
        replace(file, role=line("words", "role", key=extra.key, role=file.role))
        for extra in extras
        for file in extra.inputs
        if (file.name, file.sha256) not in known
    ]
    return tuple(dict.fromkeys(further))


def _interacts(budget: Budget, sensor: str) -> bool:
    """Whether a total index of an output is above the first-order one beyond chance."""
    return any(
        part.sobol is not None and part.sobol.interacts
        for row in budget.outputs
        if row.sensor == sensor
        for part in row.contributions
    )


def _drawn(charts: Iterable[Chart | None]) -> list[Picture]:
    """Draw the figures that there are."""
    return [chart_picture(chart) for chart in charts if chart is not None]
