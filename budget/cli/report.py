"""`budget report`: the budget as pages to look at, to sign and to file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Engine, Inputs

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.inputs.records import Device
    from budget.question import Question
    from budget.report.analysis.build import Extra
    from budget.report.analysis.what_if import AnalyzeAgain
    from budget.results import Budget


BESIDE = frozenset({"compare", "allocate", "number"})  # the budget
OF_MISSION = frozenset({"mission", "at"})  # which analyze takes in place of a test


@options.asking("report")
def report(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    compare: Annotated[
        list[str] | None,
        typer.Option(
            metavar="DEVICE",
            help="Add a comparison with this device file, its base and every variant; "
            "may be given again.",
            show_default=False,
        ),
    ] = None,
    allocate: Annotated[
        bool,
        typer.Option(
            "--allocate",
            help="Add the allowable specification values for the requirement "
            "(proportional).",
        ),
    ] = False,
    number: Annotated[
        str,
        typer.Option(
            metavar="TEXT", help="Number of the report, printed under its title."
        ),
    ] = "",
    out: options.OutputFiles,
) -> None:
    """Write the error budget as a report: verdict first, then its basis.

    Inputs, procedure, budget, coupling, distributions, GUM propagation vs Monte
    Carlo, method and provenance, the same in HTML and PDF; the HTML page has sliders
    that change the sources.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_files, command_line, hand_out, pages_of
    from budget.errors import CallError
    from budget.inputs import (
        load_all,
    )
    from budget.language import speaking
    from budget.question import choose_times
    from budget.report.analysis.build import report_document
    from budget.report.document import to_csv
    from budget.report.rendering import document_date
    from budget.studies.analysis import analyze_as
    from budget.studies.evidence import gather_evidence

    date = document_date()
    check_files(out, inputs, devices, more=compare or ())
    if allocate and inputs.measured:
        raise CallError(
            "--allocate shares out limits among the specifications of a data sheet, "
            "and --measured is of one unit of it; leave one of them out"
        )
    _check_extras(
        inputs, allocate=allocate, compare=bool(compare), only=bool(asked.only)
    )
    if inputs.at and inputs.mission is None:
        raise CallError("--at is a time of a mission: name one with --mission")
    if allocate and asked.missing != "refuse":
        raise CallError(
            "--allocate shares limits out among the specifications given, --missing "
            f"{asked.missing} puts others beside them: one report would hold two "
            "budgets; write two"
        )
    loaded = options.load_devices(devices, inputs.changes)
    inputs = replace(inputs, requirement=inputs.required, mission=inputs.journey)
    question = _asked(loaded, inputs, asked)
    settings, route = asked.settle(), inputs.journey
    times = (
        () if route is None else choose_times(route, inputs.at, question.requirement)
    )
    others = load_all(compare or [])
    with computing(engine) as place:
        budget = analyze_as(settings, question, engine=place, command="report")
        carried = None
        if route is not None:
            carried = analyze_as(
                replace(settings, matrices=False),
                question.carry(times, settings.only),
                engine=place,
                command="mission",
            )
        evidence = gather_evidence(
            question,
            budget,
            budget.assessment,
            carried=carried,
            full=out.full,
        )
        with speaking(out.language):
            extras = (
                *(() if carried is None else (_mission_extra(carried),)),
                *_extras(
                    question,
                    others,
                    with_allocation=allocate,
                    seed=settings.seed,
                    engine=place,
                ),
            )
        show = place.stage("figures and pages") or (lambda _, __: None)
        show(0, 1)
        with speaking(out.language):
            document = report_document(
                budget,
                devices=question.devices,
                procedure=question.procedure,
                evidence=evidence,
                assessment=budget.assessment,
                extras=extras,
                command_line=command_line(context),
                again=_again(
                    context,
                    loaded,
                    is_on_mission=carried is not None
                    and carried.assessment is not None,
                    without={"calibration"} if question.on_mission else set(),
                ),
                date=date,
                number=number,
                full=out.full,
            )
        files = pages_of(document, out.output, out.paper)
        show(1, 1)
    documents = [(out.json, lambda: document.json), (out.csv, lambda: to_csv(budget))]
    hand_out(documents, pages=files)


def _asked(devices: tuple[Device, ...], inputs: Inputs, asked: Asked) -> Question:
    """Return the calibration whose budget it is, and what it leaves on the mission.

    It is the paper's test where the unit on the mission is as its maker calibrated it,
    or as it was made: these have no budget of a calibration.
    """
    from budget.inputs.records import UNCALIBRATED
    from budget.question import Question, with_results

    wanted, route, settings = inputs.required, inputs.journey, asked.settle()
    own = inputs.calibrated(mission=route, requirement=wanted)
    devices = with_results(devices, inputs.measured, own)
    is_tested = route is None or own.formulas not in UNCALIBRATED
    paper = replace(inputs, calibration=None, procedure=None)
    question = Question.of(
        *devices,
        procedure=own if is_tested else paper.calibrated(),
        on_mission=own,
        requirement=wanted,
        mission=route,
        coverage=asked.coverage,
        reference=asked.reference,
        only=settings.only,
        outputs=settings.outputs,
        missing=asked.missing,
    )
    return question if wanted is None else question.whole()


def _again(
    context: typer.Context,
    devices: tuple[Device, ...],
    *,
    is_on_mission: bool,
    without: set[str],
) -> AnalyzeAgain:
    """Return the commands of changed devices; limits on a mission take a report."""
    from budget.cli.output import command_line, command_parts
    from budget.report.analysis.what_if import CHANGED_FILE, AnalyzeAgain

    command = "report" if is_on_mission else "analyze"
    left = BESIDE if is_on_mission else BESIDE | OF_MISSION | without
    page = " -o changed.html" if is_on_mission else ""
    same, operands = command_parts(context, command=command, without=left)
    of_file = command_line(
        context, command=command, devices=[CHANGED_FILE], without={*left, "changes"}
    )
    return AnalyzeAgain(
        same=same + page, operands=operands, devices=devices, of_file=of_file + page
    )


def _mission_extra(carried: Budget) -> Extra:
    """Return a mission as a part of the report: its section and its document."""
    from budget.report.analysis.build import Extra
    from budget.report.analysis.mission import mission_figures, mission_section

    figures = mission_figures(carried)
    return Extra(
        key="mission",
        content=carried.to_dict(),
        sections=(mission_section(carried, figures[1:]),),
        growth=next(iter(figures), None),
        inputs=carried.inputs,
        warnings=carried.warnings,
        carried=carried,
    )


def _check_extras(inputs: Inputs, *, allocate: bool, compare: bool, only: bool) -> None:
    """Refuse what needs limits or every source, where they are not there.

    Raises
    ------
    CallError
        There is no requirement to share out or to compare against, or sources are
        left out of the budget that allocation and comparison would count.
    """
    from budget.errors import CallError

    wants = [
        text
        for asked, text in (
            (allocate, "--allocate shares out limits"),
            (compare, "--compare sets devices against limits"),
        )
        if asked
    ]
    if wants and inputs.requirement is None:
        raise CallError(f"{' and '.join(wants)}: give them with --requirement")
    if wants and only:
        raise CallError(
            "--only counts some sources, --allocate and --compare count all of them: "
            "one report would hold two budgets; write two"
        )


def _extras(
    question: Question,
    others: tuple[Device, ...],
    *,
    with_allocation: bool,
    seed: int,
    engine: Engine,
) -> Iterator[Extra]:
    """Yield what was asked for besides: lines for the limits, other devices."""
    from budget.inputs import load_catalogue
    from budget.names import MISSION
    from budget.report.allocation import allocation_section
    from budget.report.analysis.build import Extra
    from budget.report.comparison.page import comparison_sections
    from budget.studies.allocation.allocate import allocate_as
    from budget.studies.comparison.compare import compare

    requirement = question.requirement
    if requirement is None:
        return
    is_carried = MISSION in requirement.kinds
    if with_allocation:
        allotted = allocate_as(question, Asked(seed=seed), engine=engine)
        yield Extra.of("allocation", allotted, (allocation_section(allotted),))
    if others:
        compared = compare(
            (*(question.given or question.devices), *others),
            requirement,
            [(is_carried and question.on_mission) or question.procedure],
            mission=question.mission if is_carried else None,
            catalogue=load_catalogue(),
            missing=question.filling.mode,
            seed=seed,
            workers=engine.workers,
            executor=engine.executor,
            progress=engine.progress,
        )
        yield Extra.of("comparison", compared, comparison_sections(compared))
