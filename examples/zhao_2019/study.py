"""The whole reproduction: conditions in, findings and the curves of the figures out.

With the conclusions of sections 2 and 4: who couples to whom, by law and simulation.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.documents import Documented, written
from budget.methods.gum import propagate
from budget.names import AXES, Name
from budget.sentences import sentence
from budget.studies.evidence import CouplingTable, coupling_table
from budget.units import ARCSEC, DEG_PER_HOUR
from zhao_2019.conditions import PLACES, load_conditions, only_sources
from zhao_2019.formulas import formula_findings
from zhao_2019.orders import compute_sweeps, order_findings, sweep_findings
from zhao_2019.printed import Agreement, Finding, say_number
from zhao_2019.readings import MOUNTING, readings
from zhao_2019.table1 import reading_findings, table1_findings

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Procedure
    from budget.results import InputFile
    from zhao_2019.conditions import Conditions
    from zhao_2019.orders import Sweep
    from zhao_2019.printed import Conclusion, Paper

YES, NO = "affects", "no effect"
# A simulation that takes no time: none from some is told by any sampling.
SAMPLE_RATE, DWELL = 10.0, 20.0  # [Hz], [s]
RUNS = 4  # for each source: enough to tell a spread from none
# Pulses add up more rounding than the law: so many times its resolution is none [1].
PULSE_ROUNDING = 100.0


@written(
    "paper",
    """
    title = paper.title (str)
    inputs by role as file
    rows = findings: every number and claim
    verdicts = paper.verdicts (Mapping[str, str]): what each means
    sweeps: figures 1 to 4
    coupling = table.cells: who couples to whom
    assumptions = paper.assumptions (tuple[str, ...])
    warnings (list[str])
    """,
    commands="paper",
    warnings=lambda _: (),
)
@dataclass(frozen=True, kw_only=True, eq=False)
class PaperStudy(Documented):
    """Everything the paper prints in section 3, beside ours."""

    paper: Paper  # what it prints
    findings: tuple[Finding, ...]  # in the order of its sections
    sweeps: tuple[Sweep, ...]  # figures 1 to 4
    table: CouplingTable  # who couples to whom, by the law with eq. (4) as printed.
    inputs: tuple[InputFile, ...]  # the shipped files that hold the paper's conditions

    def of_section(self, section: str) -> tuple[Finding, ...]:
        """Return the findings of one section."""
        return tuple(row for row in self.findings if row.section == section)

    @property
    def counts(self) -> dict[Agreement, int]:
        """How many rows have each verdict that occurs, in the order of Agreement."""
        found = Counter(row.verdict for row in self.findings)
        return {verdict: found[verdict] for verdict in Agreement if found[verdict]}

    @property
    def unexplained(self) -> tuple[Finding, ...]:
        """What nothing explains, entries of one row gathered."""
        return tuple(
            row
            for row in self.findings
            if row.verdict == Agreement.UNEXPLAINED and row.is_summary
        )


def reproduce() -> PaperStudy:
    """Compute section 3 of the paper again and hold every number against it."""
    conditions = load_conditions()
    all_readings = readings(conditions)
    sweeps = compute_sweeps(conditions)
    couplings = compute_couplings(conditions)
    findings = (
        *table1_findings(conditions, all_readings),
        *sweep_findings(sweeps, conditions),
        *reading_findings(conditions, all_readings),
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Couplings:
    """Who couples to whom, by both methods and formulas, and what explains it."""

    # With eq. (4) as printed, and corrected.
    by_law: tuple[CouplingTable, ...]
    by_simulation: tuple[CouplingTable, ...]
    # By the law, corrected, counted from the values during the test.
    as_tested: CouplingTable
    # d bias / d angle of the gyro, printed and corrected, shape (3, 6)
    # [(deg/h)/arcsec].
    sensitivity: tuple[Array, ...]

    def answers(self, source: Name, group: Name) -> tuple[tuple[str, bool, str], ...]:
        """Return by each method and formula whether the source affects the group.

        Method, whether the formula is that which is printed, and the answer.
        """
        return tuple(
            (
                method,
                table is tables[0],
                YES if table.cell(source, group).reaches else NO,
            )
            for method, tables in (
                ("law", self.by_law),
                ("simulation", self.by_simulation),
            )
            for table in tables
        )


def compute_couplings(conditions: Conditions) -> Couplings:
    """Compute who couples to whom, and the sensitivity that decides it."""
    sensors = conditions.sensors
    procedures = (conditions.printed, conditions.corrected)

    def short(procedure: Procedure) -> Procedure:
        return replace(
            procedure,
            sample_rate=SAMPLE_RATE,
            gyro=replace(procedure.gyro, dwell=DWELL),
            accelerometer=replace(procedure.accelerometer, dwell=DWELL),
        )

    def sensitivity(procedure: Procedure) -> Array:
        C = propagate(only_sources(conditions.gyro, procedure, MOUNTING)).C
        return np.asarray(C[PLACES["bias"]] * ARCSEC / DEG_PER_HOUR)

    def by_law(procedure: Procedure, reference: str = "nominal") -> CouplingTable:
        problem = calibration_problem(sensors, procedure, reference=reference)
        return coupling_table(problem, np.sqrt(propagate(problem).source_variance))

    def by_simulation(procedure: Procedure) -> CouplingTable:
        problem = calibration_problem(sensors, procedure, reference="nominal")
        u = [
            np.std(
                [
                    simulate(sensors, procedure, run=run, only=frozenset({group.name}))
                    for run in range(RUNS)
                ],
                axis=0,
                ddof=1,
            )
            for group in problem.groups
        ]
        zero = [PULSE_ROUNDING * output.resolution for output in problem.outputs]
        return coupling_table(problem, np.where(np.stack(u) > zero, u, 0.0))

    return Couplings(
        by_law=tuple(map(by_law, procedures)),
        by_simulation=tuple(by_simulation(short(one)) for one in procedures),
        as_tested=by_law(conditions.corrected, "as_tested"),
        sensitivity=tuple(sensitivity(procedure) for procedure in procedures),
    )


def conclusion_findings(
    couplings: Couplings, conditions: Conditions
) -> tuple[Finding, ...]:
    """Return one row for each thing the paper says of a source and a parameter."""
    return tuple(
        _finding(couplings, conditions.paper, conclusion, parameter, claim)
        for conclusion in conditions.paper.conclusions
        for parameter, claim in conclusion.claims.items()
    )


def _finding(
    couplings: Couplings, paper: Paper, said: Conclusion, parameter: str, claim: str
) -> Finding:
    """Hold one claim against four answers."""
    source, group = said.name, Name(parameter, owner=said.sensor)
    answers = couplings.answers(source, group)
    given = {answer for _, _, answer in answers}
    by_printed = all(answer == (claim if one else NO) for _, one, answer in answers)
    verdict, case = Agreement.UNEXPLAINED, "unexplained"
    ours: str = sentence("paper_words.answers", found=answers)
    if given == {claim}:
        verdict, ours = Agreement.AGREES, claim
        case = "affects" if claim == YES else "agrees"
    elif (source, parameter) == (MOUNTING, "bias") and by_printed:
        verdict, ours = Agreement.EXPLAINED, sentence("paper_words.as_printed")
        case = "only eq. (4)"
    elif given == {YES} and not couplings.as_tested.cell(source, group).reaches:
        verdict, ours = Agreement.EXPLAINED, sentence("paper_words.from_nominal")
        case = "as tested"
    printed, corrected = couplings.sensitivity
    largest = zip(AXES, np.abs(printed).max(axis=1), strict=True)
    return paper.tell(
        "conclusion",
        case,
        printed=claim,
        ours=ours,
        verdict=verdict,
        said=said,
        parameter=parameter,
        size=couplings.by_law[0].cell(source, group).size,
        rows=", ".join(f"{axis} {say_number(size)}" for axis, size in largest),
        rest=np.abs(corrected).max(),
    )
