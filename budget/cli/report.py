"""`budget report`: the budget as a page to look at and to pass on."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from budget.cli import options

SUFFIXES = (".html",)


def report(
    devices: options.Devices = None,
    *,
    output: Annotated[
        list[Path],
        typer.Option("-o", "--output", metavar="FILE", help="Report file, .html."),
    ],
    procedure: options.ProcedureFile = None,
    requirement: options.RequirementFile = None,
    method: options.Method = "gum",
    trials: options.Trials = None,
    digits: options.Digits = 1,
    max_trials: options.MaxTrials = None,
    seed: options.Seed = 0,
    workers: options.Workers = 1,
    cluster: options.Cluster = None,
    coverage: options.Coverage = None,
    interval: options.Interval = "symmetric",
    reference: options.Reference = None,
    no_validate: options.NoValidate = False,
    sobol: options.Sobol = False,
    samples: options.Samples = None,
    only: options.Only = None,
    allocate: Annotated[
        bool,
        typer.Option(
            "--allocate",
            help="Add what each line may be to meet the requirement (proportional).",
        ),
    ] = False,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Write the error budget as a report: verdict first, then what it stands on."""
    from budget.cli.computing import computing, say
    from budget.cli.dates import document_date
    from budget.cli.output import check_destinations, printing
    from budget.errors import CallError
    from budget.methods.monte_carlo import MAX_TRIALS
    from budget.methods.sobol import SAMPLES
    from budget.report.document import to_csv, to_json
    from budget.report.files import write_all
    from budget.report.html import render_html
    from budget.spec import load_procedure, load_requirement
    from budget.studies.analysis import analyze
    from budget.studies.conformity import assess
    from budget.studies.request import choose_basis

    _check_suffixes(output)
    date = document_date()
    check_destinations(
        json, csv, *output, inputs=[*(devices or ()), procedure, requirement]
    )
    if allocate and requirement is None:
        raise CallError("--allocate shares out limits: give them with --requirement")
    loaded = options.load_devices(devices)
    how = load_procedure(procedure)
    wanted = None if requirement is None else load_requirement(requirement)
    basis = choose_basis(wanted, coverage=coverage, reference=reference)
    with computing(workers=workers, cluster=cluster) as shop:
        budget = analyze(
            *loaded,
            procedure=how,
            requirement=wanted,
            method=method,
            trials=trials,
            digits=digits,
            max_trials=max_trials or MAX_TRIALS,
            validate=not no_validate,
            seed=seed,
            workers=shop.workers,
            executor=shop.executor,
            coverage=basis.coverage,
            interval=interval,
            reference=basis.reference,
            samples=(samples or SAMPLES) if sobol or samples else None,
            only=only or (),
            command="report",
            progress=shop.progress,
            talk=say,
        )
    sections = []
    if allocate and wanted is not None:
        from budget.report.allocation.page import allocation_section
        from budget.studies.allocation.allocate import allocate as share_out

        with computing(workers=1, cluster=None) as shop:
            allocation = share_out(
                *loaded,
                requirement=wanted,
                procedure=how,
                seed=seed,
                progress=shop.progress,
            )
        sections.append(allocation_section(allocation))
    page = render_html(
        budget,
        devices=loaded,
        procedure=how,
        assessment=None if wanted is None else assess(budget, wanted, loaded),
        date=date,
        sections=tuple(sections),
    )
    documents = {json: to_json, csv: to_csv}
    files = {path: make(budget) for path, make in documents.items() if path is not None}
    on_stdout = files.pop(options.STDOUT, None)
    write_all({**dict.fromkeys(output, page), **files})
    for path in output:
        typer.echo(f"{path}: written", err=True)
    if on_stdout is not None:
        with printing():
            sys.stdout.write(on_stdout)


def _check_suffixes(paths: list[Path]) -> None:
    """Refuse a kind of report that there is not, before anything is computed."""
    from budget.errors import CallError

    wrong = [str(path) for path in paths if path.suffix.lower() not in SUFFIXES]
    if wrong:
        raise CallError(
            f"-o {', '.join(wrong)}: the suffix decides the kind of report, "
            f"allowed: {', '.join(SUFFIXES)}"
        )
