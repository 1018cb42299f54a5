"""Evidence beside a budget: the studies that a report shows to a reviewer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.studies.cautions import unfelt
from budget.studies.coupling import coupling_by_law
from budget.studies.densities import critical_densities
from budget.studies.what_if import what_if

if TYPE_CHECKING:
    from budget.question import Question
    from budget.results import Assessment, Budget
    from budget.studies.cautions import Unfelt
    from budget.studies.coupling import CouplingTable
    from budget.studies.densities import ErrorDensity
    from budget.studies.what_if import WhatIf


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
        coupling=coupling_by_law(
            question.problem, question.law, question.procedure.formulas
        )
        if full
        else None,
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
