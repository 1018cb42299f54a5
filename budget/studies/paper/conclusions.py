"""The conclusions of sections 2 and 4: who couples to whom, by law and simulation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.gum import propagate
from budget.names import AXES, Name
from budget.studies.coupling import CouplingTable, coupling
from budget.studies.paper.conditions import PLACES, only_sources
from budget.studies.paper.findings import WORD, Finding, Verdict, say, words
from budget.studies.paper.readings import MOUNTING
from budget.units import ARCSEC, DEG_PER_HOUR

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import Conclusion

YES, NO = "affects", "no effect"
# A simulation that takes no time: none from some is told by any sampling.
SAMPLE_RATE, DWELL = 10.0, 20.0  # [Hz], [s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Couplings:
    """Who couples to whom, by both methods and formulas, and what explains it.

    Attributes
    ----------
    by_law, by_simulation : tuple of CouplingTable
        With eq. (4) as printed, and corrected.
    as_tested : CouplingTable
        By the law, corrected, counted from the values during the test.
    sensitivity : tuple of ndarray, shape (3, 6)
        d bias / d angle of the gyro, printed and corrected [(deg/h)/arcsec].
    """

    by_law: tuple[CouplingTable, ...]
    by_simulation: tuple[CouplingTable, ...]
    as_tested: CouplingTable
    sensitivity: tuple[Array, ...]

    def answers(self, source: Name, group: Name) -> dict[str, str]:
        """Return whether the source affects the group by each method and formula."""
        return {
            f"{method}, {formula}": YES if table.cell(source, group).reaches else NO
            for method, tables in (
                ("law", self.by_law),
                ("simulation", self.by_simulation),
            )
            for formula, table in zip(
                ("eq. (4) as printed", "corrected"), tables, strict=True
            )
        }


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

    return Couplings(
        by_law=tuple(coupling(sensors, procedure) for procedure in procedures),
        by_simulation=tuple(
            coupling(sensors, short(procedure), method="simulation")
            for procedure in procedures
        ),
        as_tested=coupling(sensors, conditions.corrected, reference="as_tested"),
        sensitivity=tuple(sensitivity(procedure) for procedure in procedures),
    )


def conclusion_findings(
    couplings: Couplings, conditions: Conditions
) -> tuple[Finding, ...]:
    """Return one row for each thing the paper says of a source and a parameter."""
    return tuple(
        _finding(couplings, conclusion, parameter, claim)
        for conclusion in conditions.paper.conclusions
        for parameter, claim in conclusion.claims.items()
    )


def _finding(
    couplings: Couplings, conclusion: Conclusion, parameter: str, claim: str
) -> Finding:
    """Hold one claim against four answers."""
    source, group = conclusion.name, Name(parameter, owner=conclusion.sensor)
    answers = couplings.answers(source, group)
    given = set(answers.values())
    by_printed = {name: claim if "printed" in name else NO for name in answers}
    verdict, why = Verdict.UNEXPLAINED, ""
    ours = "; ".join(f"{name}: {answer}" for name, answer in answers.items())
    if given == {claim}:
        verdict, ours = Verdict.AGREES, claim
        why = "by law and simulation, by both formulas"
        if claim == YES:
            size = couplings.by_law[0].cell(source, group).size
            why += f"; {say(size)} of the spread from all sources together"
    elif (source, parameter) == (MOUNTING, "bias") and answers == by_printed:
        verdict, ours = Verdict.EXPLAINED, "only by eq. (4) as printed"
        why = _explain_mounting(*couplings.sensitivity)
    elif given == {YES} and not couplings.as_tested.cell(source, group).reaches:
        verdict, ours = Verdict.EXPLAINED, f"{YES} (from nominal)"
        why = (
            "a constant nonlinearity is a change of K and is calibrated as one: no "
            "error against K during the test, in full against the nominal K"
        )
    return Finding(
        section="conclusions",
        where=f"section {conclusion.section}: {conclusion.sensor} "
        f"{words(conclusion.source)} on {words(parameter)}",
        printed=claim,
        ours=ours,
        quantity=WORD,
        verdict=verdict,
        why=why,
    )


def _explain_mounting(printed: Array, corrected: Array) -> str:
    """Say why eq. (4) couples and the corrected formula does not, with numbers."""
    largest = np.abs(printed).max(axis=1)
    rows = ", ".join(
        f"{axis} {say(size)}" for axis, size in zip(AXES, largest, strict=True)
    )
    return (
        "eq. (4) undoes dT by its transpose, which leaves (dT + dT^T) w + dT^T b: "
        f"largest d bias/d angle {rows} (deg/h)/arcsec; the corrected formula "
        f"subtracts the dT it has found, largest {say(np.abs(corrected).max(), 1)}"
    )
