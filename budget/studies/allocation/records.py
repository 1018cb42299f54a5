"""Records of an allocation: frozen, SI inside, and their JSON document."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from budget.names import Name
from budget.results import SCHEMA, Tabled, inputs_document
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Device, Sensor
    from budget.problem import Output
    from budget.results import InputFile, Standing

MEAN = Name("mean")  # the part of a limit that the mean error takes

FREE = "free"
HELD = "held"  # by --fix
ZERO = "zero"  # a present value of zero stays
SHARED = "shared"  # by both triads: of the station or the environment, stays
NOT_REQUIRED = "not required"  # its sensor has no limits


@dataclass(frozen=True, kw_only=True)
class LimitPart:
    """What one source takes of one squared limit, k^2 u^2 / limit^2 [1]."""

    source: Name  # dotted name, 'interaction' or 'mean'
    now: float
    allowed: float | None  # None where the requirement cannot be met
    floor: float  # with every free source as small as it may be

    @property
    def after(self) -> float:
        """The part after the allocation, of an impossible limit what is held [1]."""
        return self.floor if self.allowed is None else self.allowed


@dataclass(frozen=True, kw_only=True)
class LimitedOutput:
    """One limit, and how it is shared out."""

    output: Output
    limit: float  # [SI]
    printed_limit: str
    now: float  # largest interval end over limit [1]
    allowed: float | None  # the same after the allocation [1]
    floor: float  # the same of what cannot be allocated [1]
    is_binding: bool
    lower_bound: bool  # a line that is not given would take a part of it too
    parts: tuple[LimitPart, ...]

    @property
    def sensor(self) -> str:
        """Owner of the output."""
        return self.output.name.owner

    @property
    def after(self) -> float:
        """Utilisation after the allocation, of an impossible limit what is held [1]."""
        return self.floor if self.allowed is None else self.allowed

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        return {
            "output": self.output.name,
            "unit": self.output.unit,
            "resolution": self.output.resolution / self.output.si_per_unit,
            "limit": self.limit / self.output.si_per_unit,
            "utilisation_now": self.now,
            "utilisation_allowed": self.allowed,
            "utilisation_floor": self.floor,
            "binding": self.is_binding,
            "lower_bound": self.lower_bound,
            "parts": [asdict(part) for part in self.parts],
        }


@dataclass(frozen=True, kw_only=True)
class Headroom:
    """How far one source may go alone, the others as they are."""

    value: float  # [SI]; 0: an output that it reaches fails even without it
    stopped_by: tuple[Name, ...]  # outputs; (): its ceiling, no limit before that


@dataclass(frozen=True, kw_only=True)
class SourceAllotment:
    """One line of a data sheet: what it is and what it may be.

    Values are standard uncertainties of the largest axis; one factor is for all.
    """

    source: Name
    unit: str  # as in the file
    si_per_unit: float
    status: str  # free, held, zero, shared, not required
    now: float  # [SI]
    allowed: float | None  # [SI]; None where the requirement cannot be met
    best_offered: float | None  # least value in the catalogue [SI]
    # By the law alone, where Monte Carlo corrected it [SI].
    uncorrected: float | None = None
    ceiling: float | None = None  # [SI]; None for what is not free
    least: float | None = None  # bound below [SI]; None for what is not free
    at_ceiling: bool = False
    at_least: bool = False
    is_spared: bool = False  # left as it is: others are what matters at a limit
    # Spared, and no more than a hundredth of a squared limit that is reached then.
    is_minor: bool = False
    binding_outputs: tuple[Name, ...] = ()  # at their limits, where it takes most
    # Takes a thousandth of a squared limit, at its ceiling at the latest.
    is_significant: bool = False
    # None for what is zero, has no limit or counts nothing.
    headroom: Headroom | None = None

    @property
    def factor(self) -> float:
        """Allowed over present value [1]; 1 where nothing was allocated."""
        if self.allowed is None or self.now == 0.0:
            return 1.0
        return self.allowed / self.now

    @property
    def is_idle(self) -> bool:
        """Whether its sensor has limits, and it reaches none of them."""
        return not self.is_significant and self.status in {FREE, HELD, SHARED}

    @property
    def is_beyond_market(self) -> bool:
        """Whether nothing in the catalogue is as good as what is allowed."""
        return (
            self.status == FREE
            and self.allowed is not None
            and self.best_offered is not None
            and self.allowed < self.best_offered
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in the unit of its file."""

        def size(value: float | None) -> float | None:
            return None if value is None else value / self.si_per_unit

        room = self.headroom
        return {
            "sensor": self.source.owner,
            "source": self.source,
            "unit": self.unit,
            "status": self.status,
            "now": size(self.now),
            "allowed": size(self.allowed),
            "uncorrected": size(self.uncorrected),
            "binding_output": next(iter(self.binding_outputs), None),
            "at_ceiling": self.at_ceiling,
            "at_least": self.at_least,
            "spared": self.is_spared,
            "ceiling": size(self.ceiling),
            "least": size(self.least),
            "binding_outputs": list(self.binding_outputs),
            "headroom": None
            if room is None
            else {
                "value": size(room.value),
                "stopped_by": next(iter(room.stopped_by), None),
                "all_that_stop": list(room.stopped_by),
            },
            "best_offered": size(self.best_offered),
            "counts": self.is_significant,
        }


@dataclass(frozen=True, kw_only=True)
class CoverageCheck:
    """Monte Carlo at the allocated values, for one output at its limit."""

    output: Name
    trials: int
    covered: float  # part of the trials within the law's interval [1]
    factor_before: float  # k of the law [1]
    factor: float  # k that was allocated with in the end [1]
    reached: float  # largest end of the trials' interval over the limit [1]

    @property
    def is_corrected(self) -> bool:
        """Whether the law's coverage was too far off to allocate with."""
        return self.factor != self.factor_before


@dataclass(frozen=True, kw_only=True)
class Saving:
    """What one percent more on the limits of one parameter would save."""

    outputs: tuple[Name, ...]  # those of the parameter that are at their limits
    saves: float  # [unit of cost]
    part: float  # of the cost of that sensor [1]


@dataclass(frozen=True, kw_only=True)
class CostReport:
    """The cost of one sensor, and what shows that it is the least one."""

    sensor: str
    now: float  # of the sources that are free [unit of cost]
    cost: float
    residual: float  # of the conditions of Karush, Kuhn and Tucker [1]
    gap: float  # duality gap over the cost [1]
    is_optimal: bool
    solver: str
    savings: tuple[Saving, ...]


@dataclass(frozen=True, kw_only=True)
class LongerTest:
    """What a change of the procedure would do for one sensor."""

    sensor: str
    name: str  # 'turns' or 'dwell'
    goal: str  # 'devices as they are', or 'what is held'
    now: float  # turns [1] or dwell [s]
    needed: float | None  # None: no value that was tried meets
    tried_to: float
    utilisation: float  # largest one at `needed`, else the least that was found [1]
    best: float  # where that is


@dataclass(frozen=True, kw_only=True)
class LineMatch:
    """One line of a catalogue device against what is allowed."""

    source: Name
    value: float | None  # largest axis [SI]; None: the device does not give it
    ratio: float | None  # worst axis over what that axis may have [1]
    how: str  # '' or what was converted to compare


@dataclass(frozen=True, kw_only=True)
class Match:
    """One triad of the catalogue against the allocated lines."""

    device: str
    file: str
    sensor: str
    lines: tuple[LineMatch, ...]
    extra: tuple[Name, ...]  # lines that it gives and that nothing was allotted to

    @property
    def missing(self) -> tuple[Name, ...]:
        """Allocated lines that the device does not give."""
        return tuple(line.source for line in self.lines if line.ratio is None)

    @property
    def beyond(self) -> tuple[LineMatch, ...]:
        """Lines that are larger than allowed."""
        return tuple(
            line
            for line in self.lines
            if line.ratio is not None and settle(line.ratio) > 1.0
        )

    @property
    def worst(self) -> float:
        """Largest ratio of the lines that are given [1]; 0 where none is."""
        return max((line.ratio or 0.0 for line in self.lines), default=0.0)

    @property
    def meets(self) -> bool:
        """Whether every allocated line is given and small enough."""
        return not self.missing and not self.beyond

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return {
            "name": self.device,
            "file": self.file,
            "sensor": self.sensor,
            "meets": self.meets,
            "lines": [
                {"source": line.source, "ratio": line.ratio, "how": line.how}
                for line in self.lines
            ],
            "extra": list(self.extra),
        }


@dataclass(frozen=True, kw_only=True)
class Recalibration:
    """How old a calibration may be before a limit is reached."""

    sensor: str
    goal: str  # of which lines: as they are, as allocated
    # At which a limit is reached; None: passed at the youngest that was tried, or not
    # reached at the oldest [s].
    age: float | None
    utilisation: float  # of the limits, there [1]
    not_given: tuple[Name, ...]  # expected lines that would make it sooner

    @property
    def is_soon(self) -> bool:
        """Whether a limit is passed at the youngest age that was tried."""
        return self.age is None and self.utilisation > 1.0

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it; the age in seconds."""
        return {**asdict(self), "is_soon": self.is_soon}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Allocation(Tabled):
    """Everything that `budget allocate` says."""

    title: str
    inputs: tuple[InputFile, ...]
    strategy: str
    requirement: str
    procedure: str
    coverage: float
    reference: str
    formulas: str
    seed: int
    feasible: bool
    not_allocated: tuple[str, ...]  # sensors that have limits and are not given
    sources: tuple[SourceAllotment, ...]
    outputs: tuple[LimitedOutput, ...]
    checks: tuple[CoverageCheck, ...]
    costs: tuple[CostReport, ...]
    longer_tests: tuple[LongerTest, ...]
    recalibrations: tuple[Recalibration, ...]
    matches: tuple[Match, ...]
    devices: tuple[Device, ...]
    sensors: tuple[Sensor, ...]  # with the allocated values; as given if infeasible
    not_given: tuple[Name, ...]
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
    not_estimated: tuple[Name, ...] = ()  # have limits and are held in the test
    # Of what is allocated, by the owner of the limits; () where nothing is.
    standings: tuple[tuple[str, Standing], ...] = ()

    def is_met(self, accepted: Sequence[str]) -> bool:
        """Whether what is allocated has one of these verdicts, or is at its limit.

        At a limit, which is where an allocation ends, no trials decide.
        """
        fine = {*accepted, "undecided"}
        return self.feasible and all(one.verdict in fine for _, one in self.standings)

    @property
    def binding(self) -> tuple[LimitedOutput, ...]:
        """Outputs at their limits after the allocation."""
        return tuple(row for row in self.outputs if row.is_binding)

    @property
    def impossible(self) -> tuple[LimitedOutput, ...]:
        """Outputs whose limits are passed by what cannot be allocated."""
        return tuple(row for row in self.outputs if row.floor > 1.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON document of schema `budget/1`, in the units of the files."""
        return {
            "schema": SCHEMA,
            "command": "allocate",
            "title": self.title,
            "inputs": inputs_document(self.inputs),
            "settings": {
                "method": "gum",
                "strategy": self.strategy,
                "seed": self.seed,
                "coverage": self.coverage,
                "reference": self.reference,
                "formulas": self.formulas,
            },
            "feasible": self.feasible,
            "standings": [
                {"sensor": owner, "verdict": one.verdict, **one.to_dict()}
                for owner, one in self.standings
            ],
            "not_allocated": list(self.not_allocated),
            **({"not_estimated": held} if (held := list(self.not_estimated)) else {}),
            "sources": [source.to_dict() for source in self.sources],
            "outputs": [row.to_dict() for row in self.outputs],
            "relaxations": [
                {
                    "output": row.output.name,
                    "unit": row.output.unit,
                    "limit": row.limit / row.output.si_per_unit,
                    "needed": row.floor * row.limit / row.output.si_per_unit,
                }
                for row in self.impossible
            ],
            "levers": [asdict(test) for test in self.longer_tests],
            **(
                {"recalibrations": [one.to_dict() for one in self.recalibrations]}
                if self.recalibrations
                else {}
            ),
            "costs": [asdict(cost) for cost in self.costs],
            "checks": [
                {**asdict(check), "corrected": check.is_corrected}
                for check in self.checks
            ],
            "devices": [match.to_dict() for match in self.matches],
            "not_given": list(self.not_given),
            "assumptions": list(self.assumptions),
            "warnings": list(self.warnings),
        }
