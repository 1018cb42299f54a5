"""The conclusions of sections 2 and 4: who couples to whom, by law and simulation."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.methods.gum import propagate
from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import Name
from budget.spec.records import AXES
from budget.studies.coupling import CouplingTable, coupling
from budget.studies.paper.conditions import PLACES, only_sources
from budget.studies.paper.findings import (
    AGREES,
    EXPLAINED,
    UNEXPLAINED,
    WORD,
    Finding,
    say,
)
from budget.units import ARCSEC, DEG_PER_HOUR

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure
    from budget.studies.paper.conditions import Conditions

YES, NO = "affects", "no effect"
PARAMETERS = ("scale_factor", "mounting_angle", "bias")
MOUNTING = Name("mounting_repeatability", owner=GYRO)

# A simulation that takes no time: none from some is told by any sampling.
SAMPLE_RATE, DWELL = 10.0, 20.0  # [Hz], [s]

# What sections 2 and 4 say, for scale factors, mounting angles, bias; '' for nothing
# said. A parameter's own repeatability is not said to affect it.
CLAIMS = (
    (Name("bias_repeatability", owner=GYRO), (NO, NO, ""), "2.1.1, 4"),
    (Name("bias_stability", owner=GYRO), (YES, YES, ""), "2.1.1, 4"),
    (Name("angle_random_walk", owner=GYRO), (YES, YES, YES), "2.1.1, 4"),
    (Name("scale_factor_nonlinearity", owner=GYRO), (NO, "", ""), "2.1.2"),
    (Name("scale_factor_nonlinearity", owner=GYRO), ("", NO, NO), "2.1.2, 4"),
    (Name("scale_factor_asymmetry", owner=GYRO), (YES, "", ""), "2.1.2, eq. (17)"),
    (Name("scale_factor_asymmetry", owner=GYRO), ("", YES, YES), "2.1.2, 4"),
    (Name("scale_factor_repeatability", owner=GYRO), ("", NO, NO), "2.1.2, 4"),
    (MOUNTING, (NO, "", YES), "2.1.3, 4"),
    (Name("bias_repeatability", owner=ACCELEROMETER), (NO, NO, ""), "2.2.1, 4"),
    (Name("bias_stability", owner=ACCELEROMETER), (YES, YES, ""), "2.2.1, 4"),
    (Name("sample_noise", owner=ACCELEROMETER), (YES, YES, YES), "2.2.1, 4"),
    (Name("scale_factor_nonlinearity", owner=ACCELEROMETER), ("", NO, NO), "2.2.2, 4"),
    (Name("scale_factor_repeatability", owner=ACCELEROMETER), ("", NO, NO), "2.2.2, 4"),
    (Name("mounting_repeatability", owner=ACCELEROMETER), (NO, "", NO), "2.2.3, 4"),
)


@dataclass(frozen=True, kw_only=True, eq=False)
class MountingSensitivity:
    """How the gyro bias answers to the mounting angles, by both formulas.

    Attributes
    ----------
    printed, corrected : ndarray, shape (3, 6)
        d bias / d angle [(deg/h)/arcsec].
    """

    printed: Array
    corrected: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Verdicts:
    """The coupling tables of both methods and formulas, and what explains them."""

    law_printed: CouplingTable
    law_corrected: CouplingTable
    simulated_printed: CouplingTable
    simulated_corrected: CouplingTable
    as_tested: CouplingTable  # by the law, counted from the values during the test
    sensitivity: MountingSensitivity

    @property
    def tables(self) -> tuple[tuple[str, CouplingTable], ...]:
        """The four that are held against the paper, with their names."""
        return (
            ("law, eq. (4) as printed", self.law_printed),
            ("law, corrected", self.law_corrected),
            ("simulation, eq. (4) as printed", self.simulated_printed),
            ("simulation, corrected", self.simulated_corrected),
        )


def compute_verdicts(conditions: Conditions) -> Verdicts:
    """Compute who couples to whom, four times, and the sensitivity that decides it."""
    sensors = conditions.sensors

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

    return Verdicts(
        law_printed=coupling(sensors, conditions.printed),
        law_corrected=coupling(sensors, conditions.corrected),
        simulated_printed=coupling(
            sensors, short(conditions.printed), method="simulation"
        ),
        simulated_corrected=coupling(
            sensors, short(conditions.corrected), method="simulation"
        ),
        as_tested=coupling(sensors, conditions.corrected, reference="as_tested"),
        sensitivity=MountingSensitivity(
            printed=sensitivity(conditions.printed),
            corrected=sensitivity(conditions.corrected),
        ),
    )


def conclusion_findings(verdicts: Verdicts) -> tuple[Finding, ...]:
    """Return one row for each thing the paper says of a source and a parameter."""
    return tuple(
        _finding(verdicts, source, parameter, claim, section)
        for source, claims, section in CLAIMS
        for parameter, claim in zip(PARAMETERS, claims, strict=True)
        if claim
    )


def _finding(
    verdicts: Verdicts, source: Name, parameter: str, claim: str, section: str
) -> Finding:
    """Hold one claim against four answers."""
    group = Name(parameter, owner=source.owner)
    answers = {
        name: YES if table.cell(source, group).reaches else NO
        for name, table in verdicts.tables
    }
    given = set(answers.values())
    verdict, why = UNEXPLAINED, ""
    ours = "; ".join(f"{name}: {answer}" for name, answer in answers.items())
    if given == {claim}:
        verdict, ours = AGREES, claim
        why = "by law and simulation, by both formulas"
        if claim == YES:
            size = verdicts.law_printed.cell(source, group).size
            why += f"; {say(size, 2)} of the spread from all sources together"
    elif source == MOUNTING and parameter == "bias":
        if answers == {
            name: claim if "printed" in name else NO for name, _ in verdicts.tables
        }:
            verdict = EXPLAINED
            ours = "only by eq. (4) as printed"
            why = _explain_mounting(verdicts.sensitivity)
    elif given == {YES} and not verdicts.as_tested.cell(source, group).reaches:
        verdict, ours = EXPLAINED, f"{YES} (from nominal)"
        why = (
            "a constant nonlinearity is a change of K and is calibrated as one: no "
            "error against K during the test, in full against the nominal K"
        )
    return Finding(
        section="conclusions",
        where=f"section {section}: {source.owner} {_words(source.quantity)} on "
        f"{_words(parameter)}",
        printed=claim,
        ours=ours,
        quantity=WORD,
        verdict=verdict,
        why=why,
    )


def _explain_mounting(sensitivity: MountingSensitivity) -> str:
    """Say why eq. (4) couples and the corrected formula does not, with numbers."""
    printed, corrected = np.abs(sensitivity.printed), np.abs(sensitivity.corrected)
    rows = ", ".join(
        f"{axis} {say(row.max(), 2)}" for axis, row in zip(AXES, printed, strict=True)
    )
    return (
        "eq. (4) undoes dT by its transpose, which leaves (dT + dT^T) w + dT^T b: "
        f"largest d bias/d angle {rows} (deg/h)/arcsec; the corrected formula "
        f"subtracts the dT it has found, largest {say(corrected.max(), 1)}"
    )


def _words(name: str) -> str:
    """Turn a key into words."""
    return name.replace("_", " ")
