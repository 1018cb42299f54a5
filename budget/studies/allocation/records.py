"""Records of an allocation: frozen, SI inside, and their JSON document."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.names import Name
from budget.results import LimitedOutput, Study
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.records import Sensor
    from budget.known import Known
    from budget.results import Verdict

MEAN = Name("mean")  # the part of a limit that the mean error takes

FREE = "free"
HELD = "held"  # by --fix
ZERO = "zero"  # a present value of zero stays
SHARED = "shared"  # by both triads: of the station or the environment, stays
NOT_REQUIRED = "not required"  # its sensor has no limits


@written(
    "limit_part",
    """
    source: or 'interaction', 'mean'
    now [1]: of the squared limit
    allowed [1]: null where the requirement cannot be met
    floor [1]: with every free source as small as it may be
    """,
)
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


@written(
    "shared_limit",
    """
    output = output.name
    unit = output.unit
    resolution = output.resolution / unit: a spread at or below this is rounding
    limit / unit: on the absolute error
    utilisation_now = now [1]: largest interval end over limit
    utilisation_allowed = allowed [1]: the same after the allocation
    utilisation_floor = floor [1]: the same of what cannot be allocated
    binding = is_binding: whether it is at its limit after the allocation
    lower_bound = now.is_bound: whether a line that is not given would take a part of it
      too
    parts: what each source takes of the squared limit
    """,
)
@written(
    "relaxation",
    """
    output = output.name
    unit = output.unit
    limit / unit: on the absolute error
    needed / unit (float): the least that what cannot be allocated leaves room for
    """,
    needed=lambda row: row.floor * row.limit,
)
@dataclass(frozen=True, kw_only=True)
class SharedLimit(LimitedOutput):
    """One limit, and how it is shared out."""

    now: Known  # largest interval end over limit [1]
    allowed: float | None  # the same after the allocation [1]
    floor: float  # the same of what cannot be allocated [1]
    is_binding: bool
    parts: tuple[LimitPart, ...]

    @property
    def after(self) -> float:
        """Utilisation after the allocation, of an impossible limit what is held [1]."""
        return self.floor if self.allowed is None else self.allowed


@written(
    "headroom",
    """
    value / unit: 0 where an output that it reaches fails even without it
    stopped_by = stopped_by.0: the first output that is at its limit then; null at its
      ceiling
    all_that_stop = stopped_by not in CSV: all of them
    """,
)
@dataclass(frozen=True, kw_only=True)
class Headroom:
    """How far one source may go alone, the others as they are."""

    value: float  # [SI]; 0: an output that it reaches fails even without it
    stopped_by: tuple[Name, ...]  # outputs; (): its ceiling, no limit before that


@written(
    "allotment",
    """
    sensor = source.owner
    source
    unit: as the file gives it
    status: 'free', 'held', 'zero', 'shared', 'not required'
    now / unit: standard uncertainty of the largest axis
    allowed / unit: what it may be; null where the requirement cannot be met
    uncorrected / unit: the same by the law alone, where Monte Carlo corrected it
    binding_output = binding_outputs.0: at its limit, where the source takes most
    at_ceiling: whether it is as large as it may be asked for
    at_least: whether it is as small as it may be asked for
    spared = is_spared: whether it is left as it is, others being what matters at a
      limit
    ceiling / unit: null of what is not free
    least / unit: likewise
    binding_outputs not in CSV: all that are at their limits, where it takes most
    headroom as headroom: how far it may go alone, the others as they are
    best_offered / unit: the least in the catalogue
    counts = is_significant: whether it takes a thousandth of a squared limit, at its
      ceiling at the latest
    """,
)
@dataclass(frozen=True, kw_only=True)
class SourceAllotment(Documented):
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


@written(
    "coverage_check",
    """
    output
    trials
    covered [1]: part of the trials within the interval of the law
    factor_before [1]: coverage factor of the law
    factor [1]: the one that was allocated with in the end
    reached [1]: largest end of the trials' interval over the limit
    corrected = is_corrected: whether the coverage of the law was too far off
    """,
)
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


@written(
    "saving",
    """
    outputs: those of one parameter that are at their limits
    saves [unit of cost]: by one percent more on these limits
    part [1]: of the cost of the sensor
    """,
)
@dataclass(frozen=True, kw_only=True)
class Saving:
    """What one percent more on the limits of one parameter would save."""

    outputs: tuple[Name, ...]  # those of the parameter that are at their limits
    saves: float  # [unit of cost]
    part: float  # of the cost of that sensor [1]


@written(
    "cost_report",
    """
    sensor
    now [unit of cost]: of the sources that are free
    cost [unit of cost]: of what is allocated
    residual [1]: of the conditions of Karush, Kuhn and Tucker
    gap [1]: duality gap over the cost
    is_optimal
    solver
    savings: the largest first
    """,
)
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


@written(
    "longer_test",
    """
    sensor
    name: 'turns' or 'dwell'
    goal: 'devices as they are', or 'what is held'
    now [turns, or s]
    needed [turns, or s]: null where no value that was tried meets
    tried_to [turns, or s]
    utilisation [1]: the largest at what is needed, else the least that was found
    best [turns, or s]: where that is
    """,
)
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


@written(
    "line_match",
    """
    source
    ratio [1]: worst axis over what that axis may have; null where it is not given
    how: '' or what was converted to compare
    """,
)
@dataclass(frozen=True, kw_only=True)
class LineMatch:
    """One line of a catalogue device against what is allowed."""

    source: Name
    value: float | None  # largest axis [SI]; None: the device does not give it
    ratio: float | None  # worst axis over what that axis may have [1]
    how: str  # '' or what was converted to compare


@written(
    "match",
    """
    name = device
    file
    sensor
    meets: whether every allocated line is given and small enough
    lines
    extra: lines that it gives and that nothing was allotted to
    """,
)
@dataclass(frozen=True, kw_only=True)
class Match(Documented):
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


@written(
    "recalibration",
    """
    sensor
    goal: of which lines, as they are, as allocated
    age [s]: at which a limit is reached; null where it is passed at the youngest that
      was tried, or not reached at the oldest
    utilisation [1]: of the limits, there
    not_given: expected lines that would make it sooner
    is_soon: whether a limit is passed at the youngest age that was tried
    """,
)
@dataclass(frozen=True, kw_only=True)
class Recalibration(Documented):
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


@written(
    "allocation",
    """
    title: names of the devices
    inputs by role as file
    settings = self as allocation_settings
    feasible: whether the requirement can be met
    standings as standing: of what is allocated; none where nothing is
    not_allocated: sensors that have limits and are not given
    not_estimated?: what has limits and is held in the test
    sources: what each line is and may be
    outputs: how each limit is shared out
    relaxations = impossible as relaxation: limits that what cannot be allocated passes
    levers = longer_tests: what a change of the procedure would do
    recalibrations?: how old a calibration may be
    costs: by sensor, where costs are given
    checks: by Monte Carlo, of outputs at their limits
    devices = matches: of the catalogue, against what is allocated
    not_given: lines of the data sheet that are absent
    assumptions
    warnings
    """,
    commands="allocate",
)
@written(
    "allocation_settings",
    """
    method = 'gum' (str)
    strategy = settings.strategy (str): how limits are shared out
    seed = settings.seed: of the trials that check it
    coverage = settings.coverage [1]: of the requirement
    reference = settings.reference: what an error is one against
    formulas = settings.formulas: of the calibration
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Allocation(Study):
    """Everything that `budget allocate` says."""

    feasible: bool
    not_allocated: tuple[str, ...]  # sensors that have limits and are not given
    sources: tuple[SourceAllotment, ...]
    outputs: tuple[SharedLimit, ...]
    checks: tuple[CoverageCheck, ...]
    costs: tuple[CostReport, ...]
    longer_tests: tuple[LongerTest, ...]
    recalibrations: tuple[Recalibration, ...]
    matches: tuple[Match, ...]
    sensors: tuple[Sensor, ...]  # with the allocated values; as given if infeasible
    not_estimated: tuple[Name, ...] = ()  # have limits and are held in the test
    # Of what is allocated, by the owner of the limits; () where nothing is.
    standings: tuple[Verdict, ...] = ()

    def is_met(self, accepted: Sequence[str]) -> bool:
        """Whether what is allocated has one of these verdicts, or is at its limit.

        At a limit, which is where an allocation ends, no trials decide.
        """
        fine = {*accepted, "undecided"}
        return self.feasible and all(one.verdict in fine for one in self.standings)

    @property
    def binding(self) -> tuple[SharedLimit, ...]:
        """Outputs at their limits after the allocation."""
        return tuple(row for row in self.outputs if row.is_binding)

    @property
    def impossible(self) -> tuple[SharedLimit, ...]:
        """Outputs whose limits are passed by what cannot be allocated."""
        return tuple(row for row in self.outputs if row.floor > 1.0)
