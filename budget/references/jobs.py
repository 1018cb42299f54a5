"""Compute what a reference is about: inputs and settings in, numbers and words out."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from budget.errors import CallError
from budget.methods.execution import one_blas_thread
from budget.methods.monte_carlo import MAX_TRIALS
from budget.references.numbers import (
    allocation_numbers,
    budget_numbers,
    comparison_numbers,
)
from budget.references.records import JOBS, Asked, files_fault
from budget.spec.costs import read_costs
from budget.spec.device import read_device
from budget.spec.procedure import read_procedure
from budget.spec.requirement import read_requirement
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import Bounds
from budget.studies.analysis import analyze
from budget.studies.comparison.compare import compare
from budget.studies.judgement import TRIALS
from budget.studies.request import (
    choose_basis,
    find_sources,
    sensors_of,
    source_names,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.references.records import Snapshot
    from budget.spec.records import Device, Procedure, Requirement
    from budget.spec.tree import Document

# Which settings mean something to which job; the others must stay as they are.
SETTINGS = {
    "analyze": (
        *("method", "trials", "max_trials", "digits", "seed", "coverage", "interval"),
        *("reference", "only", "samples"),
    ),
    "compare": ("method", "trials", "max_trials", "seed"),
    "allocate": ("strategy", "fix"),
}
_NAMES = {"samples": "sobol and --samples", "max_trials": "max-trials"}


def check_asked(job: str, asked: Asked) -> None:
    """Refuse settings that mean nothing to a job.

    Raises
    ------
    CallError
        With all of them.
    """
    if job not in JOBS:
        raise CallError(f"kind is {job!r}, allowed: {', '.join(JOBS)}")
    plain = Asked()
    strange = [
        f"--{_NAMES.get(name, name)}"
        for name in Asked.__dataclass_fields__
        if name not in SETTINGS[job] and getattr(asked, name) != getattr(plain, name)
    ]
    if strange:
        raise CallError(
            f"{', '.join(strange)}: means nothing to a reference of kind {job}; leave "
            "it out, or take another --kind"
        )


def compute(
    job: str, inputs: Sequence[Document], asked: Asked, *, workers: int = 1
) -> Snapshot:
    """Do a job on its inputs.

    Parameters
    ----------
    job : str
        'analyze', 'compare' or 'allocate'.
    inputs : sequence of Document
        Devices first, in the order they were given.
    asked : Asked
        Settings.
    workers : int
        Number of processes; changes no number.

    Returns
    -------
    Snapshot
        In printed units.

    Raises
    ------
    CallError, SpecError
        Inputs or settings do not fit together, or a file is not sound.
    """
    devices = [read_device(one) for one in _of("device", inputs)]
    procedures = [read_procedure(one) for one in _of("procedure", inputs)]
    limits = [read_requirement(one) for one in _of("requirement", inputs)]
    costs = [read_costs(one) for one in _of("costs", inputs)]
    if job != "compare" and len(procedures) > 1:
        raise CallError(
            f"{len(procedures)} procedures were given, a reference of kind {job} takes "
            "one; give one, or take --kind compare"
        )
    if job != "analyze" and not limits:
        raise CallError(
            f"a reference of kind {job} needs a requirement; give --requirement FILE"
        )
    fault = files_fault(job, [one.kind for one in inputs])
    if fault:
        raise CallError(f"found {fault}; give as many, or take another --kind")
    # The matrices are small, threads of BLAS only wait for each other; and with one the
    # order of every sum is the same on any machine.
    with one_blas_thread():
        if job == "analyze":
            requirement = limits[0] if limits else None
            return _analyze(devices, procedures[0], requirement, asked, workers)
        if job == "compare":
            comparison = compare(
                devices,
                limits[0],
                procedures,
                method=asked.method,
                trials=asked.trials or TRIALS,
                max_trials=asked.max_trials,
                seed=asked.seed,
                workers=workers,
            )
            names = _once([one.base_name for one in _of("device", inputs)])
            return comparison_numbers(comparison, names, devices, procedures, limits[0])
        known = source_names(sensors_of(devices))
        held = find_sources(asked.fix, known, option="--fix")
        # Limits are shared out by the law, without the catalogue.
        allocation = allocate(
            *devices,
            requirement=limits[0],
            procedure=procedures[0],
            strategy=asked.strategy,
            costs=costs[0] if costs else None,
            bounds=Bounds(held=frozenset(held), most={}, least={}),
            catalogue=(),
            validate=False,
        )
        return allocation_numbers(allocation)


def by_law(asked: Asked) -> Asked:
    """Return the same settings with the law in the place of trials."""
    return replace(asked, method="gum", trials=None, max_trials=None, samples=None)


def _of(role: str, inputs: Sequence[Document]) -> list[Document]:
    """Return the inputs of one role."""
    return [one for one in inputs if one.kind == role]


def _analyze(
    devices: Sequence[Device],
    procedure: Procedure,
    requirement: Requirement | None,
    asked: Asked,
    workers: int,
) -> Snapshot:
    """Compute a budget; the check of the law by Monte Carlo is no part of it."""
    basis = choose_basis(
        requirement, coverage=asked.coverage, reference=asked.reference
    )
    budget = analyze(
        *devices,
        procedure=procedure,
        requirement=requirement,
        method=asked.method,
        trials=asked.trials,
        digits=asked.digits,
        max_trials=asked.max_trials or MAX_TRIALS,
        validate=False,
        seed=asked.seed,
        workers=workers,
        coverage=basis.coverage,
        interval=asked.interval,
        reference=basis.reference,
        samples=asked.samples,
        only=asked.only,
    )
    return budget_numbers(budget)


def _once(names: Sequence[str]) -> list[str]:
    """Count the names that stand twice."""
    return [
        name if names.count(name) == 1 else f"{name} ({names[: k + 1].count(name)})"
        for k, name in enumerate(names)
    ]
