"""`budget analyze`: the budget of every parameter, its contributions ranked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.cli import options
from budget.settings import Asked, Engine, Inputs

if TYPE_CHECKING:
    from budget.results import Budget


@options.asking("analyze")
def analyze(
    devices: options.Devices = None,
    *,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    out: options.OutputFiles,
) -> None:
    """Compute the error budget of a calibration, or of a mission after it.

    For every scale factor, mounting angle and bias: its expected error, standard
    uncertainty and coverage interval, and what each specification contributes. Of
    a mission what `budget mission` says. With a requirement the verdict comes first;
    the exit code is 0 whatever it is, but for --exit-code.
    """
    from budget.cli.output import deliver
    from budget.errors import CallError

    if inputs.mission is None and inputs.at:
        raise CallError("--at is a time of a mission: name one with --mission")
    options.check_exit_code(inputs.requirement, out)
    budget = compute(devices, inputs, asked, engine, out, command="analyze")
    deliver(budget, out)
    options.exit_by(budget.assessment, out)


def compute(
    devices: list[str] | None,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    out: options.OutputFiles,
    *,
    command: str,
) -> Budget:
    """Load what is named and compute its budget, of a mission where there is one."""
    from budget.cli.computing import computing
    from budget.cli.output import check_files
    from budget.studies.analysis import analyze as run

    check_files(out, inputs, devices)
    loaded = options.load_devices(devices, inputs.changes)
    with computing(engine) as found:
        return run(*loaded, inputs=inputs, asked=asked, engine=found, command=command)
