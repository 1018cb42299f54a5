"""Candidates of a comparison: a sensor under a procedure, and its remedy."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs
from budget.calibration.schemes import is_beside
from budget.errors import CallError
from budget.methods.gum import propagate
from budget.model.sources import GYRO
from budget.names import IMU, Name
from budget.studies.comparison.records import MissingLines, Remedy
from budget.studies.judgement import Limited, limit_problem, required_problem
from budget.studies.lower_bounds import expecting_device, missing_of
from budget.studies.missing import REFUSE, WORST, Filling, fill
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.methods.gum import Propagation
    from budget.spec.records import Device, Procedure, Requirement, Sensor
    from budget.studies.judgement import Judged


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """What is judged: one sensor of a device under a procedure.

    Its Problem is made where it is judged and not kept: there may be thousands.
    """

    device: Device
    place: int  # of the device among those compared
    given: Sensor  # as the data sheet leaves it
    sensor: Sensor  # with what stands for lines that are not given
    procedure: Procedure
    requirement: Requirement
    # What stands in the device for expected lines that are not given.
    filling: Filling = field(default_factory=Filling)

    @property
    def is_limited(self) -> bool:
        """Whether anything is required of what is estimated of it."""
        is_alone = self.sensor.kind == GYRO and self.sensor.beside is None
        if is_beside(self.procedure) and is_alone:
            return False  # a gyro is found beside accelerometers
        names = known_outputs((self.sensor.kind,), self.procedure)
        return any(limit.output in names for limit in self.requirement.limits)

    @property
    def missing(self) -> tuple[Name, ...]:
        """Expected lines that nothing stands for, and that its verdict rests on."""
        return missing_of((self.sensor,), self.procedure)

    def limited(self) -> Limited:
        """Return its Problem with the limits on it.

        Raises
        ------
        CallError
            Nothing is required of it.
        """
        problem = required_problem(self.sensor, self.procedure, self.requirement)
        held = limit_problem(problem, self.requirement, apart=IMU)
        if held is None:
            raise CallError(
                f"{self.requirement.name} limits nothing of the {self.sensor.kind}; "
                "add limits for it, or leave it out"
            )
        return held


def find_remedy(held: Limited, law: Propagation, judged: Judged) -> Remedy:
    """Return the source that makes most of the worst output, and what would mend it.

    With the other sources as they are, k^2 (V - V_s + f^2 V_s) = (limit - |mean|)^2
    gives the factor f on its standard uncertainty, by the law and with the k of the
    interval that was judged; its small part in products with other sources is left as
    it is.
    """
    worst = judged.worst
    row = held.rows[worst]
    parts = law.source_variance[:, row]
    source = first_largest(parts.tolist())
    total = float(law.covariance[row, row])
    name = held.problem.groups[source].name
    if total == 0.0:
        return Remedy(source=name, share=0.0, factor=None)
    k = float(judged.factor[worst])
    allowed = (max(held.limits[worst] - abs(law.mean[row]), 0.0) / k) ** 2
    rest = total - float(parts[source])
    can_mend = allowed > rest and parts[source] > 0.0
    return Remedy(
        source=name,
        share=float(parts[source]) / total,
        factor=float(np.sqrt((allowed - rest) / parts[source])) if can_mend else None,
    )


def bound_missing(
    one: Candidate, bare: Device, catalogue: Sequence[Device] | None
) -> MissingLines | None:
    """Return what expected lines that are not given could do; None where none miss.

    `bare` is its device as the file gives it.
    """
    missing = missing_of((one.given,), one.procedure)
    if not missing:
        return None
    if one.filling.mode != REFUSE:
        return MissingLines(
            lines=missing,
            filling=one.filling,
            utilisation=None,
            verdict="",
            is_bound=False,
        )
    bare = expecting_device(bare, one.procedure, one.requirement.reference)
    completed, filling = fill(bare, WORST, catalogue)
    # Beside a sensor of another kind its lines count where the verdict rests on them.
    filling = filling.of(missing)
    utilisation = None
    if len(filling.lines) == len(missing):
        kind = one.sensor.kind
        sensor = next(each for each in completed.sensors if each.kind == kind)
        held = replace(one, sensor=sensor).limited()
        ends = propagate(held.problem).interval(one.requirement.coverage)[held.rows]
        utilisation = float((np.abs(ends).max(axis=1) / held.limits).max())
    return MissingLines(
        lines=missing,
        filling=filling,
        utilisation=utilisation,
        verdict=""
        if utilisation is None
        else ("meets" if utilisation <= 1.0 else "fails"),
    )
