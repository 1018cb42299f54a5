"""The whole reproduction: conditions in, findings and the curves of the figures out."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.studies.paper.conclusions import compute_verdicts, conclusion_findings
from budget.studies.paper.conditions import load_conditions
from budget.studies.paper.findings import VERDICTS
from budget.studies.paper.misprints import compute_formulas, formula_findings
from budget.studies.paper.mounting import mounting_findings
from budget.studies.paper.orders import noise_readings, order_findings
from budget.studies.paper.readings import reading_findings, readings, switched_on
from budget.studies.paper.sweeps import compute_sweeps, sweep_findings
from budget.studies.paper.table1 import compute_rows, table1_findings

if TYPE_CHECKING:
    from budget.results import InputFile
    from budget.studies.coupling import CouplingTable
    from budget.studies.paper.findings import Finding
    from budget.studies.paper.sweeps import Sweep

TITLE = "Zhao 2019, section 3, computed again"
SECTIONS = {
    "table 1": "Table 1: errors of the gyro calibration, one source at a time",
    "figures": "Figures 1 to 4: nonlinearity and asymmetry in 25 steps",
    "text": "Orders of magnitude in the text of 3.1 and 3.2",
    "formulas": "Formulas, and the misprints among them",
    "conclusions": "Conclusions of sections 2 and 4",
    "readings": "Other readings of the inputs: computed, none adopted",
}
ASSUMPTIONS = (
    (
        "errors are relative and counted from the nominal values: of K, of 2 arcsec, "
        "of 2.5 deg/h (gyro) and of 6 mg (accelerometer)"
    ),
    (
        "the paper does not say whether Table 1 prints one run or a mean over its 25: "
        "both are tested, row by row"
    ),
    "bias stability of the accelerometer: correlation time 300 s; 3.2 gives none",
    "accelerometer noise 50 ug: white, in each sample at 100 Hz",
    "scale factor repeatability of the accelerometer: 37 ppm; 3.2 prints 37 ug",
    (
        "an order of magnitude is the power of ten of the largest entry, as the text "
        "reads its own Table 1"
    ),
    "eq. (4) for the gyro bias as printed, unless a row says otherwise",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class PaperStudy:
    """Everything the paper prints in section 3, beside ours.

    Attributes
    ----------
    findings : tuple of Finding
        In the order of SECTIONS.
    sweeps : tuple of Sweep
        Figures 1 to 4.
    table : CouplingTable
        Who couples to whom, by the law with eq. (4) as printed.
    inputs : tuple of InputFile
        The shipped files that hold the paper's conditions.
    """

    findings: tuple[Finding, ...]
    sweeps: tuple[Sweep, ...]
    table: CouplingTable
    inputs: tuple[InputFile, ...]

    def of_section(self, section: str) -> tuple[Finding, ...]:
        """Return the findings of one section."""
        return tuple(row for row in self.findings if row.section == section)

    @property
    def counts(self) -> tuple[tuple[str, int], ...]:
        """How many rows have each verdict, in the order of VERDICTS."""
        found = Counter(row.verdict for row in self.findings)
        return tuple((word, found[word]) for word in VERDICTS if found[word])


def reproduce() -> PaperStudy:
    """Compute section 3 of the paper again and hold every number against it."""
    conditions = load_conditions()
    all_readings = readings(conditions)
    sweeps = compute_sweeps(conditions)
    of_sweeps = sweep_findings(sweeps, conditions)
    of_noise = noise_readings(conditions)
    verdicts = compute_verdicts(conditions)
    findings = (
        *table1_findings(
            compute_rows(conditions), all_readings, switched_on(conditions)
        ),
        *mounting_findings(conditions),
        *of_sweeps,
        *order_findings(conditions, all_readings, of_noise),
        *formula_findings(compute_formulas(conditions)),
        *conclusion_findings(verdicts),
        *reading_findings(all_readings),
        *of_noise,
    )
    place = {section: k for k, section in enumerate(SECTIONS)}
    return PaperStudy(
        findings=tuple(sorted(findings, key=lambda row: place[row.section])),
        sweeps=sweeps,
        table=verdicts.law_printed,
        inputs=conditions.inputs,
    )
