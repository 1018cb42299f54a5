"""The whole reproduction: conditions in, findings and the curves of the figures out."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.studies.paper.conclusions import compute_couplings, conclusion_findings
from budget.studies.paper.conditions import load_conditions
from budget.studies.paper.findings import Verdict
from budget.studies.paper.formulas import formula_findings
from budget.studies.paper.mounting import mounting_findings
from budget.studies.paper.orders import order_findings
from budget.studies.paper.readings import reading_findings, readings
from budget.studies.paper.sweeps import compute_sweeps, sweep_findings
from budget.studies.paper.table1 import table1_findings

if TYPE_CHECKING:
    from budget.results import InputFile
    from budget.studies.coupling import CouplingTable
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.printed import Paper
    from budget.studies.paper.sweeps import Sweep


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperStudy:
    """Everything the paper prints in section 3, beside ours.

    Attributes
    ----------
    paper : Paper
        What it prints.
    findings : tuple of Finding
        In the order of its sections.
    sweeps : tuple of Sweep
        Figures 1 to 4.
    table : CouplingTable
        Who couples to whom, by the law with eq. (4) as printed.
    inputs : tuple of InputFile
        The shipped files that hold the paper's conditions.
    """

    paper: Paper
    findings: tuple[Finding, ...]
    sweeps: tuple[Sweep, ...]
    table: CouplingTable
    inputs: tuple[InputFile, ...]

    def of_section(self, section: str) -> tuple[Finding, ...]:
        """Return the findings of one section."""
        return tuple(row for row in self.findings if row.section == section)

    @property
    def counts(self) -> dict[Verdict, int]:
        """How many rows have each verdict that occurs, in the order of Verdict."""
        found = Counter(row.verdict for row in self.findings)
        return {verdict: found[verdict] for verdict in Verdict if found[verdict]}


def reproduce() -> PaperStudy:
    """Compute section 3 of the paper again and hold every number against it."""
    conditions = load_conditions()
    all_readings = readings(conditions)
    sweeps = compute_sweeps(conditions)
    couplings = compute_couplings(conditions)
    findings = (
        *table1_findings(conditions, all_readings),
        *mounting_findings(conditions),
        *sweep_findings(sweeps, conditions),
        *reading_findings(all_readings),
        *order_findings(conditions, all_readings),
        *formula_findings(conditions),
        *conclusion_findings(couplings, conditions),
    )
    place = {section: k for k, section in enumerate(conditions.paper.sections)}
    return PaperStudy(
        paper=conditions.paper,
        findings=tuple(sorted(findings, key=lambda row: place[row.section])),
        sweeps=sweeps,
        table=couplings.by_law[0],
        inputs=conditions.inputs,
    )
