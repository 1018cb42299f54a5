"""`budget report`: the budget as pages to look at, to sign and to file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.report.analysis.build import Extra
    from budget.spec.records import Device, Procedure, Requirement
    from budget.studies.progress import Engine


ONLY_HERE = frozenset({"compare", "allocate", "number"})  # not parameters of analyze


@options.spell_out
def report(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    changes: options.Changes = None,
    output: Annotated[list[Path], options.OUTPUT],
    paper: options.Paper = "a4",
    language: options.Language = "en",
    procedure: options.ProcedureFile = None,
    station: options.StationFile = None,
    age: options.Age = None,
    requirement: options.RequirementFile = None,
    asked: options.Asked,
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
            help="Add what each line may be to meet the requirement (proportional).",
        ),
    ] = False,
    number: Annotated[
        str,
        typer.Option(
            metavar="TEXT", help="Number of the report, printed under its title."
        ),
    ] = "",
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Write the error budget as a report: verdict first, then what it stands on.

    Inputs, procedure, budget, coupling, distributions, the law against Monte Carlo,
    method and provenance, the same in HTML and PDF; the HTML page has sliders that
    change the sources.
    """
    from budget.cli.computing import computing
    from budget.cli.output import (
        check_destinations,
        command_line,
        command_parts,
        hand_out,
        pages_of,
    )
    from budget.errors import CallError
    from budget.language import speaking
    from budget.report.analysis.build import report_document
    from budget.report.analysis.what_if import CHANGED_FILE, AnalyzeAgain
    from budget.report.document import to_csv
    from budget.report.rendering import check_suffixes, document_date
    from budget.spec import load_all, load_procedure, load_requirement
    from budget.studies.analysis import analyze_as
    from budget.studies.evidence import gather_evidence
    from budget.studies.request import analysis_of

    check_suffixes(output, paper)
    date = document_date()
    check_destinations(
        json,
        csv,
        *output,
        inputs=[*(devices or ()), *(compare or ()), procedure, station, requirement],
    )
    _check_extras(
        requirement, allocate=allocate, compare=bool(compare), only=bool(asked.only)
    )
    if allocate and asked.missing != "refuse":
        raise CallError(
            "--allocate shares limits out among the lines that are given, --missing "
            f"{asked.missing} puts others beside them: one report would hold two "
            "budgets; write two"
        )
    loaded = options.load_devices(devices, changes)
    how = load_procedure(procedure, station=station, age=age)
    wanted = None if requirement is None else load_requirement(requirement)
    others = load_all(compare or [])
    settings = asked.settings(wanted)
    with computing(workers=asked.workers, cluster=asked.cluster) as engine:
        budget = analyze_as(
            settings,
            *loaded,
            procedure=how,
            requirement=wanted,
            engine=engine,
            command="report",
        )
        loaded, bare = analysis_of(budget).devices, loaded
        options_of_same, operands = command_parts(
            context, command="analyze", without=ONLY_HERE
        )
        evidence = gather_evidence(analysis_of(budget), budget, budget.assessment)
        with speaking(language):
            extras = tuple(
                _extras(
                    bare,
                    others,
                    how,
                    wanted,
                    missing=asked.missing,
                    with_allocation=allocate,
                    seed=settings.seed,
                    engine=engine,
                )
            )
        show = engine.stage("figures and pages") or (lambda _, __: None)
        show(0, 1)
        with speaking(language):
            document = report_document(
                budget,
                devices=loaded,
                procedure=how,
                evidence=evidence,
                assessment=budget.assessment,
                extras=extras,
                command_line=command_line(context),
                again=AnalyzeAgain(
                    same=options_of_same,
                    operands=operands,
                    devices=bare,
                    of_file=command_line(
                        context,
                        command="analyze",
                        devices=[CHANGED_FILE],
                        without={*ONLY_HERE, "changes"},
                    ),
                ),
                date=date,
                number=number,
            )
        files = pages_of(document, output, paper)
        show(1, 1)
    documents = [(json, lambda: document.json), (csv, lambda: to_csv(budget))]
    hand_out(documents, pages=files)


def _check_extras(
    requirement: Path | None, *, allocate: bool, compare: bool, only: bool
) -> None:
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
    if wants and requirement is None:
        raise CallError(f"{' and '.join(wants)}: give them with --requirement")
    if wants and only:
        raise CallError(
            "--only counts some sources, --allocate and --compare count all of them: "
            "one report would hold two budgets; write two"
        )


def _extras(
    devices: tuple[Device, ...],
    others: tuple[Device, ...],
    procedure: Procedure,
    requirement: Requirement | None,
    *,
    missing: str,
    with_allocation: bool,
    seed: int,
    engine: Engine,
) -> Iterator[Extra]:
    """Yield what was asked for besides: lines for the limits, other devices."""
    from budget.report.allocation.page import allocation_section
    from budget.report.analysis.build import Extra
    from budget.report.comparison.page import comparison_sections
    from budget.spec import load_catalogue
    from budget.studies.allocation.allocate import allocate
    from budget.studies.comparison.compare import compare

    if requirement is None:
        return
    if with_allocation:
        allotted = allocate(
            *devices,
            requirement=requirement,
            procedure=procedure,
            seed=seed,
            progress=engine.progress,
        )
        yield Extra.of("allocation", allotted, (allocation_section(allotted),))
    if others:
        compared = compare(
            (*devices, *others),
            requirement,
            [procedure],
            catalogue=load_catalogue(),
            missing=missing,
            seed=seed,
            workers=engine.workers,
            executor=engine.executor,
            progress=engine.progress,
        )
        yield Extra.of("comparison", compared, comparison_sections(compared))
