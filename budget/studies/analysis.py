"""The main job: devices and a procedure in, the budget of every parameter out."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.methods.gum import propagate
from budget.methods.monte_carlo import Sample, collect, sample
from budget.physics.calibration import calibration_problem
from budget.physics.simulation import simulate
from budget.physics.sources import REFERENCES
from budget.results import (
    INTERACTION,
    Budget,
    Contribution,
    InputFile,
    OutputBudget,
    Settings,
)
from budget.spec import load_procedure
from budget.spec.lines import lines_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from budget.arrays import Array
    from budget.methods.execution import Progress
    from budget.methods.gum import Propagation
    from budget.problem import Problem
    from budget.spec.records import Device, Procedure, Requirement, Sensor

METHODS = ("gum", "monte-carlo", "simulation")
INTERVALS = ("symmetric", "shortest")
DEFAULT_COVERAGE = 0.95  # [1]
DEFAULT_REFERENCE = "nominal"
TRIALS = {"monte-carlo": 1_000_000, "simulation": 200}  # where none are asked for


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """What one method says of all outputs, in their order [SI]."""

    mean: Array  # shape (n_out,)
    covariance: Array  # shape (n_out, n_out)
    interval: Array  # shape (n_out, 2)


def analyze(
    *devices: Device,
    procedure: Procedure | None = None,
    requirement: Requirement | None = None,
    method: str = "gum",
    trials: int | None = None,
    seed: int = 0,
    workers: int = 1,
    coverage: float = DEFAULT_COVERAGE,
    interval: str = "symmetric",
    reference: str = DEFAULT_REFERENCE,
    only: Sequence[str] = (),
    command: str = "analyze",
    progress: Progress | None = None,
) -> Budget:
    """Compute the error budget of a calibration.

    Parameters
    ----------
    *devices : Device
        Together at most one gyro and one accelerometer.
    procedure : Procedure, optional
        The paper's, if none is given.
    requirement : Requirement, optional
        Noted among the inputs; it decides nothing here (see choose_basis).
    method : str
        'gum' (law of propagation), 'monte-carlo' or 'simulation'. Contributions of
        the sources are the law's under every method.
    trials : int, optional
        Monte Carlo trials (1,000,000) or simulated runs (200).
    seed : int
        Same seed, same numbers.
    workers : int
        Number of processes; changes no number.
    coverage : float
        Probability of the intervals [1].
    interval : str
        'symmetric' or 'shortest'; by the law both are mean +- k u.
    reference : str
        What errors are counted from: 'nominal', 'as_tested', 'next_turn_on'.
    only : sequence of str
        Sources that count, all others 0; a bare name means both sensors.
    command : str
        Name of the job in the result.
    progress : callable, optional
        Called with trials done and trials in all.

    Returns
    -------
    Budget

    Raises
    ------
    CallError
        Options or devices that do not fit together.
    """
    procedure = load_procedure(None) if procedure is None else procedure
    sensors = sensors_of(devices)
    _check_words(method=method, interval=interval, reference=reference)
    _check_numbers(trials=trials, seed=seed, workers=workers, coverage=coverage)
    chosen, warnings = choose_sources(sensors, only)
    problem = calibration_problem(sensors, procedure, reference=reference, only=chosen)
    law = propagate(problem)
    if method == "gum":
        estimate = Estimate(
            mean=law.mean, covariance=law.covariance, interval=law.interval(coverage)
        )
        count = None
    else:
        count = TRIALS[method] if trials is None else trials
        if method == "monte-carlo":
            drawn = sample(
                problem, trials=count, seed=seed, workers=workers, progress=progress
            )
        else:
            one_run = partial(
                simulate,
                sensors,
                procedure,
                seed=seed,
                reference=reference,
                only=chosen,
            )
            drawn = _repeat(one_run, count, progress)
        estimate = Estimate(
            mean=drawn.mean,
            covariance=drawn.covariance,
            interval=drawn.interval(coverage, interval),
        )
    return Budget(
        command=command,
        title=" + ".join(device.name for device in devices),
        inputs=_input_files(devices, procedure, requirement),
        settings=Settings(
            method=method,
            trials=count,
            seed=seed,
            coverage=coverage,
            interval=interval,
            reference=reference,
            formulas=procedure.formulas,
            normals_per_trial=problem.normals_per_trial,
            only=tuple(sorted(chosen)) if chosen is not None else (),
        ),
        outputs=_output_budgets(problem, law, estimate),
        covariance=estimate.covariance,
        not_given=tuple(name for sensor in sensors for name in sensor.not_given),
        assumptions=(
            *(text for device in devices for text in device.assumptions),
            *procedure.assumptions,
        ),
        warnings=warnings,
    )


@dataclass(frozen=True, kw_only=True)
class Basis:
    """What a statement about errors rests on."""

    coverage: float
    reference: str


def choose_basis(
    requirement: Requirement | None, *, coverage: float | None, reference: str | None
) -> Basis:
    """Return coverage and reference: the requirement's, where there is one.

    Raises
    ------
    CallError
        An option asks for another one than the requirement does.
    """
    if requirement is None:
        return Basis(
            coverage=DEFAULT_COVERAGE if coverage is None else coverage,
            reference=DEFAULT_REFERENCE if reference is None else reference,
        )
    faults = [
        f"--{name} {asked} differs from the requirement's {name} {rules}"
        for name, asked, rules in (
            ("coverage", coverage, requirement.coverage),
            ("reference", reference, requirement.reference),
        )
        if asked is not None and asked != rules
    ]
    if faults:
        raise CallError(
            "; ".join(faults) + f"; leave the option out, or change it in "
            f"{requirement.origin.file}"
        )
    return Basis(coverage=requirement.coverage, reference=requirement.reference)


def sensors_of(devices: Sequence[Device]) -> tuple[Sensor, ...]:
    """Return the triads of all devices, gyro first.

    Raises
    ------
    CallError
        There is no sensor, or two of one kind.
    """
    found: list[Sensor] = []
    for kind in ("gyro", "accelerometer"):
        of_kind = [s for d in devices for s in d.sensors if s.kind == kind]
        if len(of_kind) > 1:
            names = " and ".join(f"{sensor.device!r}" for sensor in of_kind)
            raise CallError(
                f"{names} both have a {kind}, one budget takes at most one; "
                "give devices that complete each other, or `budget compare` them"
            )
        found.extend(of_kind)
    if not found:
        raise CallError("no device with a gyro or an accelerometer was given")
    return tuple(found)


def choose_sources(
    sensors: Sequence[Sensor], only: Sequence[str]
) -> tuple[frozenset[str] | None, tuple[str, ...]]:
    """Resolve the names after `--only`.

    Returns
    -------
    frozenset of str or None
        Full names; None where nothing was chosen, so that everything counts.
    tuple of str
        Warnings about lines that a device does not give.

    Raises
    ------
    CallError
        A name is no source of these sensors.
    """
    if not only:
        return None, ()
    known = [f"{s.kind}.{line.name}" for s in sensors for line in lines_of(s.kind)]
    given = {f"{s.kind}.{line.name}" for s in sensors for line in s.lines}
    chosen: set[str] = set()
    unknown = []
    for name in only:
        full = [k for k in known if name in (k, k.split(".")[1])]
        if not full:
            near = get_close_matches(name, [*known, *(k.split(".")[1] for k in known)])
            hint = f"; did you mean {near[0]!r}?" if near else ""
            unknown.append(f"{name!r} is no source of these devices{hint}")
        chosen.update(full)
    if unknown:
        raise CallError(
            "--only: " + "; ".join(unknown) + ". Known: " + ", ".join(known)
        )
    absent = sorted(chosen - given)
    return frozenset(chosen), tuple(
        f"{name} was asked for alone, but the device does not give it: taken as 0"
        for name in absent
    )


def _check_words(*, method: str, interval: str, reference: str) -> None:
    """Refuse words that name no choice, all at once."""
    faults = [
        f"{name} is {value!r}, allowed: {', '.join(allowed)}"
        for name, value, allowed in (
            ("method", method, METHODS),
            ("interval", interval, INTERVALS),
            ("reference", reference, REFERENCES),
        )
        if value not in allowed
    ]
    if faults:
        raise CallError("; ".join(faults))


def _check_numbers(
    *, trials: int | None, seed: int, workers: int, coverage: float
) -> None:
    """Refuse numbers that mean nothing, all at once."""
    faults = [
        f"{name} is {number}, allowed: {least} or more"
        for name, number, least in (
            ("trials", trials, 2),
            ("seed", seed, 0),
            ("workers", workers, 1),
        )
        if number is not None and number < least
    ]
    if not 0.0 < coverage < 1.0:
        faults.append(f"coverage is {coverage!r}, allowed: above 0 and below 1")
    if faults:
        raise CallError("; ".join(faults))


def _repeat(
    one_run: Callable[..., Array], runs: int, progress: Progress | None
) -> Sample:
    """Simulate the calibration run after run."""
    columns = []
    for run in range(runs):
        columns.append(one_run(run=run))
        if progress is not None:
            progress(run + 1, runs)
    return collect(np.stack(columns, axis=1))


def _output_budgets(
    problem: Problem, law: Propagation, estimate: Estimate
) -> tuple[OutputBudget, ...]:
    """Put the estimate and the law's contributions together, output by output."""
    names = [group.name for group in problem.groups]
    u = np.sqrt(np.diag(estimate.covariance))
    budgets = []
    for k, output in enumerate(problem.outputs):
        sensor = output.name.split(".")[0]
        variances = [
            (name, float(law.source_variance[g, k]))
            for g, name in enumerate(names)
            if name.split(".")[0] == sensor
        ]
        variances.append((INTERACTION, float(law.interaction_variance[k])))
        total = sum(variance for _, variance in variances)
        budgets.append(
            OutputBudget(
                output=output,
                mean=float(estimate.mean[k]),
                standard_uncertainty=float(u[k]),
                interval=(
                    float(estimate.interval[k, 0]),
                    float(estimate.interval[k, 1]),
                ),
                contributions=tuple(
                    Contribution(
                        source=name,
                        standard_uncertainty=float(np.sqrt(max(variance, 0.0))),
                        share=variance / total if total > 0.0 else 0.0,
                    )
                    for name, variance in variances
                ),
            )
        )
    return tuple(budgets)


def _input_files(
    devices: Sequence[Device], procedure: Procedure, requirement: Requirement | None
) -> tuple[InputFile, ...]:
    """Return what the result depends on, by base name and content."""
    several = len(devices) > 1
    origins = [
        (f"device {place}" if several else "device", device.origin)
        for place, device in enumerate(devices, start=1)
    ]
    origins.append(("procedure", procedure.origin))
    if requirement is not None:
        origins.append(("requirement", requirement.origin))
    return tuple(
        InputFile(role=role, name=origin.file, sha256=origin.sha256)
        for role, origin in origins
    )
