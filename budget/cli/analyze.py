"""`budget analyze`: the budget of every calibration parameter, ranked by cause."""

from __future__ import annotations

from budget.cli import options


def analyze(
    devices: options.Devices = None,
    *,
    procedure: options.ProcedureFile = None,
    method: options.Method = "gum",
    trials: options.Trials = None,
    seed: options.Seed = 0,
    workers: options.Workers = 1,
    coverage: options.Coverage = None,
    interval: options.Interval = "symmetric",
    reference: options.Reference = None,
    only: options.Only = None,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Compute the error budget of a calibration.

    For every scale factor, mounting angle and bias: its expected error, standard
    uncertainty and coverage interval, and which line of the data sheet causes it.
    """
    from budget.cli.output import check_destinations, deliver
    from budget.cli.progress import progress
    from budget.spec import load_procedure
    from budget.studies.analysis import DEFAULT_COVERAGE, DEFAULT_REFERENCE
    from budget.studies.analysis import analyze as run

    check_destinations(json, csv)
    loaded = options.load_devices(devices)
    with progress(method) as show:
        budget = run(
            *loaded,
            procedure=load_procedure(procedure),
            method=method,
            trials=trials,
            seed=seed,
            workers=workers,
            coverage=DEFAULT_COVERAGE if coverage is None else coverage,
            interval=interval,
            reference=DEFAULT_REFERENCE if reference is None else reference,
            only=only or (),
            progress=show,
        )
    deliver(budget, json=json, csv=csv)
