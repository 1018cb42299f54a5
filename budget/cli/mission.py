"""`budget mission`: what the errors do to navigation, and their main contributors."""

from __future__ import annotations

from functools import partial

import typer  # noqa: TC002 - typer reads the annotations

from budget.cli import options
from budget.cli.analyze import compute
from budget.settings import Asked, Engine, Inputs


@options.asking("mission")
def mission(
    context: typer.Context,
    devices: options.Devices = None,
    *,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
    out: options.OutputFiles,
) -> None:
    """Say how far off navigation is after a calibration, and the main contributors.

    Position (CEP, R95, DRMS), velocity and attitude at some times of a mission, with
    the residual errors after calibration at a later turn-on and the noise in run. With
    limits on a mission in the requirement the verdict comes first; the exit code is 0
    whatever it is, but for --exit-code.
    """
    from budget.cli.output import deliver, pages_asked
    from budget.report.analysis.mission import mission_document

    options.check_exit_code(inputs.requirement, out)
    budget = compute(devices, inputs, asked, engine, out, command="mission")
    make = partial(mission_document, budget)
    deliver(budget, out, pages=pages_asked(context, out, make))
    options.exit_by(budget.assessment, out)
