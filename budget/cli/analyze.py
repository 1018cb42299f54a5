"""`budget analyze`: the budget of every calibration parameter, ranked by cause."""

from __future__ import annotations

from budget.cli import options


def analyze(
    devices: options.Devices = None,
    *,
    procedure: options.ProcedureFile = None,
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
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Compute the error budget of a calibration.

    For every scale factor, mounting angle and bias: its expected error, standard
    uncertainty and coverage interval, and which line of the data sheet causes it.
    """
    from budget.cli.computing import computing
    from budget.cli.output import check_destinations, deliver
    from budget.cli.streams import say
    from budget.methods.monte_carlo import MAX_TRIALS
    from budget.methods.sobol import SAMPLES
    from budget.spec import load_procedure
    from budget.studies.analysis import analyze as run
    from budget.studies.request import choose_basis

    check_destinations(json, csv, inputs=[*(devices or ()), procedure])
    basis = choose_basis(None, coverage=coverage, reference=reference)
    loaded = options.load_devices(devices)
    with computing(workers=workers, cluster=cluster) as engine:
        budget = run(
            *loaded,
            procedure=load_procedure(procedure),
            method=method,
            trials=trials,
            digits=digits,
            max_trials=max_trials or MAX_TRIALS,
            validate=not no_validate,
            seed=seed,
            workers=engine.workers,
            executor=engine.executor,
            coverage=basis.coverage,
            interval=interval,
            reference=basis.reference,
            samples=(samples or SAMPLES) if sobol or samples else None,
            only=only or (),
            progress=engine.progress,
            talk=say,
        )
    deliver(budget, json=json, csv=csv)
