"""Candidates of a comparison: triads under a procedure, and their remedy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import known_outputs
from budget.calibration.schemes import is_beside
from budget.errors import CallError
from budget.methods.gum import covariance_by_source
from budget.methods.radius import principal_variances, probability_within
from budget.missing import REFUSE, Filling
from budget.missing.expected import lacking, lacking_of_mission, missing_of
from budget.model.sources import GYRO
from budget.names import IMU, MISSION, Name
from budget.studies.comparison.records import MissingLines, Remedy
from budget.studies.judgement import Limited, limit_problem, required_problem
from budget.studies.verdicts import Case
from budget.ties import first_largest, settle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.inputs.records import Device, Mission, Procedure, Requirement, Sensor
    from budget.methods.gum import Propagation
    from budget.results import Standing
    from budget.studies.judgement import Judged


GROWTH = 4.0  # of a variance, from one try of a bracket to the next [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """What is judged: one triad of a device under a procedure, or both together.

    By what belongs to both, of which alone the requirement then is, or on a mission.
    Its Problem is made where it is judged and not kept: there may be thousands.
    """

    device: Device
    place: int  # of the device among those compared
    given: tuple[Sensor, ...]  # as the data sheet leaves them
    sensors: tuple[Sensor, ...]  # with what stands for lines that are not given
    procedure: Procedure
    requirement: Requirement
    mission: Mission | None = None  # that both are judged by; None: one by its errors
    # What stands in the device for expected lines that are not given.
    filling: Filling = field(default_factory=Filling)
    catalogue: tuple[Device, ...] | None = None  # that is comparable

    @property
    def owner(self) -> str:
        """Owner of the outputs: the triad, what belongs to both, or the mission."""
        if self.mission is not None:
            return MISSION
        return IMU if len(self.sensors) > 1 else self.sensors[0].kind

    @property
    def has_lines(self) -> bool:
        """Whether any error line is given."""
        return any(sensor.lines for sensor in self.sensors)

    @property
    def is_limited(self) -> bool:
        """Whether anything is required of what is estimated of it."""
        if self.mission is not None:
            return MISSION in self.requirement.kinds
        first = self.sensors[0]
        if is_beside(self.procedure) and first.kind == GYRO and first.beside is None:
            return False  # a gyro is found beside accelerometers
        names = known_outputs([one.kind for one in self.sensors], self.procedure)
        return any(limit.output in names for limit in self.requirement.limits)

    @property
    def case(self) -> Case:
        """What its verdict is made of."""
        return Case(
            devices=(self.device,),
            sensors=self.sensors,
            procedure=self.procedure,
            requirement=self.requirement,
            mission=self.mission,
            filling=self.filling,
            catalogue=self.catalogue,
        )

    @property
    def missing(self) -> tuple[Name, ...]:
        """Expected lines that nothing stands for, and that its verdict rests on."""
        return missing_of(self.sensors, self.procedure)

    def limited(self) -> Limited:
        """Return its Problem with the limits on it.

        Raises
        ------
        CallError
            Nothing is required of it.
        """
        problem = required_problem(
            self.sensors, self.procedure, self.requirement, self.mission
        )
        held = limit_problem(problem, self.requirement)
        if held is None:
            raise CallError(
                f"{self.requirement.name} limits nothing of the {self.owner}; "
                "add limits for it, or leave it out"
            )
        return held

    def lacks(self, held: Limited) -> Mapping[Name, tuple[Name, ...]]:
        """Return the missing lines that would widen an output, by its name."""
        if self.mission is None:
            return lacking(
                self.sensors, self.procedure, reference=self.requirement.reference
            )
        names = tuple(output.name for output in held.outputs)
        return lacking_of_mission(self.sensors, self.procedure, self.mission, names)


def find_remedy(held: Limited, law: Propagation, judged: Judged) -> Remedy:
    """Return the source that makes most of the worst output, and what would mend it.

    With the other sources as they are, k^2 (V - V_s + f^2 V_s) = (limit - |mean|)^2
    gives the factor f on its standard uncertainty, by the law and with the k of the
    interval that was judged; its small part in products with other sources is left as
    it is. Of a length, the circle that was judged goes as the law's does.
    """
    worst = judged.worst
    row = held.rows[worst]
    parts = law.source_variance[:, row]
    source = first_largest(parts.tolist())
    total = float(law.covariance[row, row])
    name = held.problem.groups[source].name
    if total == 0.0:
        return Remedy(source=name, share=0.0, factor=None)
    if row >= law.value.size - law.legs.shape[1]:
        factor = _of_length(held, law, judged, source)
        return Remedy(source=name, share=float(parts[source]) / total, factor=factor)
    k = float(judged.factor[worst])
    allowed = (max(held.limits[worst] - abs(law.mean[row]), 0.0) / k) ** 2
    rest = total - float(parts[source])
    can_mend = allowed > rest and parts[source] > 0.0
    return Remedy(
        source=name,
        share=float(parts[source]) / total,
        factor=float(np.sqrt((allowed - rest) / parts[source])) if can_mend else None,
    )


def _of_length(
    held: Limited, law: Propagation, judged: Judged, source: int
) -> float | None:
    """Return the factor on a source that brings a length to its limit; None: none does.

    The ellipse of U - (1 - f^2) U_s gives a circle of the limit's radius, times what
    the law's circle is to that which was judged, its coverage.
    """
    from scipy.optimize import brentq

    row = held.rows[judged.worst]
    legs = law.legs[:, row - (law.value.size - law.legs.shape[1])]
    part = covariance_by_source(held.problem, law)[source][np.ix_(legs, legs)]
    rest = law.covariance[np.ix_(legs, legs)] - part
    by_law = law.interval(held.every_coverage)[row, 1]
    radius = np.array([by_law / judged.utilisation])

    def excess(squared: float) -> float:
        (a, between), (_, b) = (rest + squared * part)[:, :, None]
        within = probability_within(radius, principal_variances(a, b, between))
        return float(within[0] - held.coverage[judged.worst])

    if excess(0.0) <= 0.0:
        return None
    most = 1.0
    while excess(most) > 0.0:
        most *= GROWTH
    return float(np.sqrt(brentq(excess, 0.0, most, xtol=1e-15 * most)))


def missing_lines(one: Candidate, standing: Standing) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = standing.matter(missing_of(one.given, one.procedure))
    if not missing:
        return None
    used = standing.at_ceilings
    is_bound = one.filling.mode == REFUSE
    return MissingLines(
        lines=missing,
        filling=one.filling,
        utilisation=used if is_bound else None,
        verdict=""
        if used is None or not is_bound
        else ("meets" if settle(used) <= 1.0 else "fails"),
        is_bound=is_bound,
    )
