"""What a report shows beside a budget, so that a reviewer can follow and doubt it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.studies.coupling import coupling
from budget.studies.densities import critical_densities
from budget.studies.request import choose_sources, sensors_of
from budget.studies.what_if import what_if

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.results import Assessment, Budget
    from budget.spec.records import Device, Procedure, Requirement
    from budget.studies.coupling import CouplingTable
    from budget.studies.densities import Density
    from budget.studies.what_if import WhatIf


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What stands behind a budget.

    Attributes
    ----------
    coupling : CouplingTable
        Which source reaches what, by the law.
    densities : tuple of Density
        How the errors of the critical outputs are distributed; by Monte Carlo.
    what_if : WhatIf
        The budget as a function of the sizes of its sources.
    """

    coupling: CouplingTable
    densities: tuple[Density, ...]
    what_if: WhatIf


def gather_evidence(
    budget: Budget,
    devices: Sequence[Device],
    *,
    procedure: Procedure,
    requirement: Requirement | None = None,
    assessment: Assessment | None = None,
) -> Evidence:
    """Compute what a report shows beside a budget.

    Parameters
    ----------
    budget : Budget
        The result of `analyze` for the same devices, procedure and requirement.
    devices : sequence of Device
    procedure : Procedure
    requirement : Requirement, optional
    assessment : Assessment, optional
        The budget held against it.

    Returns
    -------
    Evidence
        Of the same reference, coverage, seed and choice of sources.
    """
    settings = budget.settings
    sensors = sensors_of(devices)
    only, _ = choose_sources(sensors, procedure, settings.only)
    return Evidence(
        coupling=coupling(sensors, procedure, reference=settings.reference, only=only),
        densities=critical_densities(
            budget, assessment, devices=devices, procedure=procedure
        ),
        what_if=what_if(
            *devices,
            procedure=procedure,
            requirement=requirement,
            coverage=settings.coverage,
            reference=settings.reference,
            only=settings.only,
            budget=budget,
        ),
    )
