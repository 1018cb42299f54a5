"""Candidates of a comparison: triads under a procedure, and their remedy."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from budget.calibration.derived import known_outputs
from budget.calibration.schemes import is_beside
from budget.errors import CallError
from budget.missing import REFUSE, Filling
from budget.missing.expected import lacking, lacking_of_mission, missing_of
from budget.model.sources import GYRO
from budget.names import IMU, MISSION, Name
from budget.studies.comparison.records import MissingLines
from budget.studies.judgement import Limited, limit_problem, required_problem
from budget.studies.verdicts import Case
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.inputs.records import Device, Mission, Procedure, Requirement, Sensor
    from budget.results import Verdict


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


def missing_lines(one: Candidate, verdict: Verdict) -> MissingLines | None:
    """Return what lines that are not given could do to limits; None where none can."""
    missing = verdict.matter(missing_of(one.given, one.procedure))
    if not missing:
        return None
    used = verdict.at_ceilings
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
