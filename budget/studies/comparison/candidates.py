"""Candidates of a comparison: a sensor under a procedure, and its remedy."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs
from budget.calibration.schemes import is_beside
from budget.errors import CallError
from budget.methods.gum import propagate
from budget.model.sources import GYRO, lines_of
from budget.names import IMU, Name
from budget.studies.comparison.records import AssumedLine, MissingLines, Remedy
from budget.studies.grades import UNKNOWN, grade
from budget.studies.judgement import Limited, limit_problem, required_problem
from budget.studies.lower_bounds import missing_of
from budget.ties import first_largest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.methods.gum import Propagation
    from budget.spec.records import Device, ErrorLine, Procedure, Requirement, Sensor
    from budget.studies.judgement import Judged

# What makers call their technology has one of these in it, mostly.
FAMILIES = ("mems", "fog", "rlg", "hrg", "quartz flexure")


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """What is judged: one sensor of a device under a procedure.

    Its Problem is made where it is judged and not kept: there may be thousands.
    """

    device: Device
    place: int  # of the device among those compared
    sensor: Sensor
    procedure: Procedure
    requirement: Requirement

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
        """Expected lines that are not given, and that its verdict rests on."""
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


def bound_missing(one: Candidate, catalogue: Sequence[Device]) -> MissingLines | None:
    """Return what expected lines that are not given could do; None where none miss."""
    missing = one.missing
    if not missing:
        return None
    found = [
        worst
        for full_name in missing
        if full_name.owner == one.sensor.kind
        and (worst := _worst_line(full_name, one.device, one.sensor, catalogue))
    ]
    utilisation = None
    if len(found) == len(missing):
        completed = replace(
            one.sensor, lines=(*one.sensor.lines, *(line for line, _ in found))
        )
        held = replace(one, sensor=completed).limited()
        ends = propagate(held.problem).interval(one.requirement.coverage)[held.rows]
        utilisation = float((np.abs(ends).max(axis=1) / held.limits).max())
    return MissingLines(
        lines=missing,
        assumed=tuple(
            AssumedLine(
                source=Name(line.name, owner=one.sensor.kind),
                printed=line.printed,
                device=owner,
            )
            for line, owner in found
        ),
        utilisation=utilisation,
        verdict=""
        if utilisation is None
        else ("meets" if utilisation <= 1.0 else "fails"),
    )


def _worst_line(
    full_name: Name, device: Device, sensor: Sensor, catalogue: Sequence[Device]
) -> tuple[ErrorLine, str] | None:
    """Return the largest such line of the catalogue and whose it is.

    Of the same family of technology and the same grade, as a ring laser must not get
    the value of an automotive chip; None where no such device gives the line, or
    nobody can tell the grade. 'gyro.noise' stands for the first of the noise lines, a
    random walk.
    """
    wanted = full_name.quantity
    names = [
        line.name
        for line in lines_of(sensor.kind)
        if wanted in (line.expected, line.name)
    ][:1]
    family, own_grade = _family(device.technology), grade(sensor)
    if not family or own_grade == UNKNOWN:
        return None
    offers = [
        (line, owner)
        for owner in catalogue
        for other in owner.sensors
        if other.kind == sensor.kind and other.device != sensor.device
        if own_grade == grade(other) and family == _family(owner.technology)
        for line in other.lines
        if line.name in names
    ]
    if not offers:
        return None
    sizes = [float(line.u.max()) for line, _ in offers]
    line, owner = offers[first_largest(sizes)]
    return line, owner.name


def _family(technology: str) -> str:
    """Return 'mems' of 'MEMS, Z axis' and 'bulk MEMS'; '' where nothing is said."""
    text = technology.casefold()
    known = next((family for family in FAMILIES if family in text), "")
    return known or re.split(r"[,(]", text)[0].strip()
