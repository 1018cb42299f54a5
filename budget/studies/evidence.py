"""Evidence beside a budget: the studies that a report shows to a reviewer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import MEASURED
from budget.documents import written
from budget.model.sources import SENSORS, source_of
from budget.names import IMU
from budget.studies.cautions import unfelt
from budget.studies.densities import critical_densities
from budget.studies.what_if import what_if

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.names import Name
    from budget.problem import Problem
    from budget.question import Question
    from budget.results import Assessment, Budget
    from budget.studies.cautions import Unfelt
    from budget.studies.densities import ErrorDensity
    from budget.studies.what_if import WhatIf


@written(
    "coupling",
    """
    source
    group: outputs of one name, on all axes
    reaches: whether any of them spreads more than by rounding
    size [1]: standard uncertainty over that of all sources together, the largest of
      them
    """,
)
@dataclass(frozen=True, kw_only=True)
class Coupling:
    """What one source alone does to one group of parameters."""

    source: Name  # 'gyro.bias_stability'
    group: Name  # 'gyro.scale_factor': the outputs of that name on all axes
    u: float  # largest standard uncertainty over the group [SI unit of the outputs]
    # Standard uncertainty over that from all sources together, largest over the group
    # [1]; 0 where nothing reaches it.
    size: float
    # Whether any output of the group has more spread than the rounding of the
    # computation (Output.resolution).
    reaches: bool

    @property
    def is_own(self) -> bool:
        """Whether the source is a spread of the parameter itself."""
        if self.source == MEASURED:
            return False
        own = source_of(self.source.owner, self.source.quantity).own
        return own == self.group.quantity


@dataclass(frozen=True, kw_only=True)
class CouplingTable:
    """All sources of some sensors against their own groups of parameters."""

    sources: tuple[Name, ...]
    groups: tuple[Name, ...]
    cells: tuple[Coupling, ...]  # a sensor's sources reach its own groups only

    def cell(self, source: str, group: str) -> Coupling:
        """Return one cell; KeyError where source and group are of two sensors."""
        for cell in self.cells:
            if (cell.source, cell.group) == (source, group):
                return cell
        raise KeyError(f"{source}, {group}")


def coupling(question: Question) -> CouplingTable:
    """Find which source alone reaches which parameters, by the law of propagation.

    Zhao 2019, sections 2 and 4. Products of two sources are no source: asymmetry, for
    one, reaches a scale factor only as a product with the bias, so that it counts here
    for a nominal bias and not for a nominal bias of zero.
    """
    return coupling_table(question.problem, np.sqrt(question.law.source_variance))


def coupling_table(problem: Problem, u: Array) -> CouplingTable:
    """Gather what sources do to outputs, shape (n_sources, n_out) [SI], by groups."""
    names = [output.name.group for output in problem.outputs]
    u = np.where(u > [output.resolution for output in problem.outputs], u, 0.0)
    total = np.sqrt((u**2).sum(axis=0))
    part = u / np.where(total > 0.0, total, np.inf)
    sources = tuple(group.name for group in problem.groups)
    groups = tuple(dict.fromkeys(names))
    cells = []
    for place, source in enumerate(sources):
        for group in groups:
            if source.owner in SENSORS and group.owner not in {source.owner, IMU}:
                continue
            of_group = np.array([name == group for name in names])
            largest = float(u[place, of_group].max())
            cells.append(
                Coupling(
                    source=source,
                    group=group,
                    u=largest,
                    size=float(part[place, of_group].max()),
                    reaches=largest > 0.0,
                )
            )
    return CouplingTable(sources=sources, groups=groups, cells=tuple(cells))


@dataclass(frozen=True, kw_only=True, eq=False)
class Evidence:
    """What stands behind a budget."""

    coupling: CouplingTable | None  # which source reaches what, by the law
    # How the errors of the critical outputs are distributed; by Monte Carlo. () where
    # the law is confirmed and nobody asks.
    densities: tuple[ErrorDensity, ...]
    what_if: WhatIf  # the budget as a function of the sizes of its sources
    unfelt: tuple[Unfelt, ...]  # what is given and reaches no output


def gather_evidence(
    question: Question,
    budget: Budget,
    assessment: Assessment | None = None,
    *,
    carried: Budget | None = None,
    full: bool = True,
) -> Evidence:
    """Compute what a report shows beside a budget, its assessment and its mission.

    In `full` all; else distributions only where the law is not confirmed.
    """
    return Evidence(
        coupling=coupling(question) if full else None,
        densities=critical_densities(question, budget, assessment)
        if full or in_doubt(budget)
        else (),
        what_if=what_if(question, budget=budget, carried=carried),
        unfelt=unfelt(question),
    )


def in_doubt(budget: Budget) -> bool:
    """Whether the law is not what the intervals rest on, or has failed its check."""
    return any(
        row.by_trials or (row.validation is not None and not row.validation.holds)
        for row in budget.outputs
    )
