"""Results of a budget: frozen records; SI inside, printed units on paper."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from math import inf, prod
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from budget import views
from budget.documents import Documented, Shown, document, written
from budget.errors import NotThereError
from budget.known import Known
from budget.language import note
from budget.names import Name, braced, spellings, with_parts
from budget.problem import Output
from budget.sentences import sentence
from budget.settings import Settings, fills
from budget.ties import first_largest, from_largest, settle
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    import pandas as pd

    from budget.arrays import Array
    from budget.inputs.changes import Changed
    from budget.inputs.records import (
        Costs,
        Device,
        Mission,
        Origin,
        Procedure,
        Requirement,
    )

INTERACTION = Name("interaction")  # the row of products of two sources
TOTAL = Name("total")
# Verdicts, best first; of parts put together the last one rules.
VERDICTS = ("meets", "meets_if", "predicted", "undecided", "undecidable", "fails")
NEAR = 3  # names that are like one that there is not
TINY = 1e-300  # in the place of a utilisation of 0 [1]
KEY = ("sensor", "parameter", "axis", "unit")  # of an output in every record
AT_A_TIME = "time"  # further key of what is of a mission, after the axis
TIME_COLUMN = "time [s]"  # the same in a pandas frame, whose heads have units
OF_A_LENGTH = ("cep", "r95", "drms")  # further numbers of a length
COLUMNS = (  # of the flat records
    *KEY,
    *("source", "standard_uncertainty", "share", "mean"),
    *("interval_low", "interval_high", "interval_by", "lower_bound"),
)
BY_LAW = "law"  # an interval mean +- k u
BY_TRIALS = "monte-carlo"  # an interval of trials
BY_PREDICTION = "prediction"  # one over what missing lines may be


written(
    "key",
    """
    sensor = name.owner: 'gyro', 'accelerometer', 'imu' of both, 'mission'
    parameter = name.quantity
    axis = name.axis: '' of what has none
    time? = name.time [s]: of a mission, since it began
    unit: of all its numbers
    """,
)(Output)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Study(Shown, Documented):
    """What a study has found, a table, and what it rests on.

    Of one Question all but what it has found is put together by
    budget.studies.envelope.
    """

    title: str = ""  # names of the devices
    inputs: tuple[InputFile, ...]  # files that it depends on
    settings: Settings  # what it depends on besides
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
    # What it answers (budget.question.Question): results know nothing of files.
    question: Any = field(default=None, repr=False)

    @property
    def not_given(self) -> tuple[Name, ...]:
        """Lines that the data sheets do not give."""
        found: tuple[Name, ...] = self.question.not_given
        return found

    def to_frame(self) -> pd.DataFrame:
        """Return its rows as a pandas frame, in printed units."""
        table: pd.DataFrame = views.view().study_frame(self)
        return table


@dataclass(frozen=True, kw_only=True)
class SobolIndex:
    """First-order and total index of one source for one output, with intervals [1].

    An estimate below 0 is shown as 0; its interval is left as it is.
    """

    first: float
    first_interval: tuple[float, float]
    total: float
    total_interval: tuple[float, float]
    interacts: bool  # whether total is above first beyond chance
    rank: int  # by total index; sources that cannot be told apart share it


@written(
    "quantity",
    """
    printed: as the file gives it
    meaning: how its number is meant, '1 sigma', 'max', ...
    unit: as the file gives it
    standard_uncertainty = u [unit]: by axis
    distribution: shapes of its axes
    divisor [1]: printed value over standard uncertainty, with how the number is read;
      null where axes differ in it
    degrees_of_freedom or null [1]: null where infinite, and where the value is of other
      devices
    origin: where another device's value stands for it
    """,
)
@dataclass(frozen=True, kw_only=True)
class InputQuantity(Documented):
    """A specification line as the input quantity of a budget: x_i and u(x_i).

    Its values are in the maker's own terms: `si_per_unit` of them make u in SI.
    """

    source: Name
    printed: str  # as the file gives it
    meaning: str  # '1 sigma', 'max', ...
    unit: str
    si_per_unit: float
    u: tuple[float, ...]  # standard uncertainty by axis [unit]
    distribution: str
    # Printed over u [1], with how the number is read; None where the axes differ in it.
    divisor: float | None
    degrees_of_freedom: float | None = inf  # None where it is of other devices
    origin: str = ""  # where another device's value stands for it
    readings: int = 0  # that it is open to, where the maker does not say


@written(
    "contribution",
    """
    source
    standard_uncertainty / unit: of the output, by this source alone
    share [1]: of the law's own total variance
    lower_bound: whether products with lines that are not given are not in it
    sobol_first = sobol.first [1]: first-order index; null where it was not estimated
    sobol_total = sobol.total [1]: total index, likewise
    u_input? / line_unit [unit of its line]: standard uncertainty of the line, on the
      largest axis that reaches the output
    sensitivity? / unit * line_unit [unit over that of its line]: of the output to it
    sobol_first_interval? = sobol.first_interval [1]: 95 % over scrambles
    sobol_total_interval? = sobol.total_interval [1]: likewise
    sobol_interacts? = sobol.interacts: whether the total is above the first-order index
      beyond chance
    sobol_rank? = sobol.rank: by total index; what cannot be told apart shares it
    """,
)
@dataclass(frozen=True, kw_only=True)
class Contribution:
    """What one source alone does to one output, by the first- and second-order law.

    To first order it is c u(x) of its input quantity, JCGM 100:2008, 5.1.3, with c of
    the law's linear map. Where several inputs of one line reach the output, u(x) is the
    largest u_i of them and c = sqrt(sum of c_i u_i r_ij c_j u_j) / u(x).
    """

    source: Name
    standard_uncertainty: float  # [SI unit of the output]
    share: float  # of the law's own total variance [1]
    lower_bound: bool = False  # products with lines that are not given are not in it
    sobol: SobolIndex | None = None
    # u(x) of its line, that of the largest axis that reaches the output; None of none.
    u_input: float | None = None  # [SI unit of u(x)]
    sensitivity: float | None = None  # c [SI unit of the output over that of u(x)]
    line_unit: float | None = None  # size of the unit of its line [SI]

    @property
    def linear(self) -> float | None:
        """C u(x) [SI unit of the output]; None where it has no line."""
        if self.u_input is None or self.sensitivity is None:
            return None
        return self.sensitivity * self.u_input


@written(
    "validation",
    """
    trials
    holds: whether the law is as good as its tolerance asks for
    difference_low / unit: of the lower ends of both intervals
    difference_high / unit: of the upper ends
    tolerance / unit: numerical tolerance, JCGM 101:2008, 7.9.2
    interval / unit: that of Monte Carlo
    reached / unit: what Monte Carlo itself has settled to
    """,
)
@dataclass(frozen=True, kw_only=True)
class Validation:
    """The law against Monte Carlo for one output, JCGM 101:2008, 8.1."""

    trials: int
    holds: bool
    difference_low: float  # of the lower interval ends [SI unit of the output]
    difference_high: float  # of the upper interval ends [SI unit of the output]
    tolerance: float  # numerical tolerance, JCGM 101:2008, 7.9.2 [same]
    interval: tuple[float, float]  # the Monte Carlo one [same]
    reached: float  # what Monte Carlo itself has settled to [same]

    @property
    def word(self) -> str:
        """'agrees', 'fails', or 'unsettled' where the trials were too few to tell."""
        if self.holds:
            return "agrees"
        difference = max(self.difference_low, self.difference_high)
        return "fails" if difference > self.tolerance else "unsettled"


@dataclass(frozen=True, kw_only=True)
class InUnit:
    """The numbers of an output with the unit that they are in."""

    unit: str
    mean: float
    standard_uncertainty: float
    interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Radii:
    """Circles that the end of a vector in a plane lies in with a probability [SI]."""

    cep: float  # of 50 %: circular error probable
    r95: float  # of 95 %


CEP, R95 = 0.5, 0.95  # coverages of these [1]


@dataclass(frozen=True, kw_only=True, slots=True)
class LimitedOutput(Documented):
    """An output and its limit, where it has one."""

    output: Output
    limit: float = inf  # on the absolute error [SI]
    printed_limit: str = ""  # as the requirement file gives it
    lacks: tuple[Name, ...] = ()  # expected lines, not given, that would widen it

    @property
    def sensor(self) -> str:
        """Owner of the output: gyro, accelerometer or, of both together, imu."""
        return self.output.name.owner

    @property
    def parameter(self) -> str:
        """scale_factor, mounting_angle, bias, or what is derived of them."""
        return self.output.name.quantity

    @property
    def axis(self) -> str:
        """x, y, z or, of an angle, xy, xz, yx, yz, zx, zy."""
        return self.output.name.axis

    @property
    def is_resolved(self) -> bool:
        """Whether anything that is given reaches it."""
        return True

    def known(self, size: float) -> Known:
        """Return a size of it, which a line that is not given would add to."""
        return Known.of(size, self.lacks, is_felt=self.is_resolved)

    @property
    def lower_bound(self) -> bool:
        """Whether its sizes are this or more: a line that reaches it lacks."""
        return bool(self.lacks)


@written(
    "limited_output",
    """
    *output as key
    coverage? [1]: of the interval; where none stands here it is the requirement's
    resolution = output.resolution / unit: a spread at or below this is rounding
    limit / unit: on the absolute error
    standard_uncertainty / unit: by the law
    interval / unit: coverage interval
    interval_by: what it is of, 'law', 'monte-carlo', ...
    largest_error / unit: larger absolute end of the interval
    utilisation [1]: largest error over limit
    conformance [1]: probability that the error is within the limit
    lower_bound: whether a line that is not given would widen it
    nothing_known = is_unknown: whether no line that is given reaches it besides
    """,
    said="One required output against its limit.",
)
@dataclass(frozen=True, kw_only=True, slots=True)
class JudgedOutput(LimitedOutput):
    """One output, how large its error is, and its limit, where it has one [SI]."""

    standard_uncertainty: float
    interval: tuple[float, float]  # coverage interval
    interval_by: str = BY_LAW  # or 'monte-carlo', 'simulation', 'prediction'
    coverage: float | None = None  # of its interval; None: the usual one [1]
    conformance: float = 1.0  # probability that the error is within the limit [1]

    @property
    def by_trials(self) -> bool:
        """Whether the interval is of Monte Carlo, the law not being sure enough."""
        return self.interval_by == BY_TRIALS

    @property
    def is_resolved(self) -> bool:
        """Whether the spread is more than the rounding of the computation."""
        return self.standard_uncertainty > self.output.resolution

    @property
    def u(self) -> Known:
        """Its standard uncertainty, as far as it is known [SI]."""
        return self.known(self.standard_uncertainty)

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known of it: no given line reaches it, one lacks."""
        return self.u.is_unknown

    @property
    def largest_error(self) -> Known:
        """Largest absolute end of the coverage interval [SI]."""
        return self.known(max(map(abs, self.interval)))

    @property
    def utilisation(self) -> Known:
        """Largest error over limit [1]."""
        return self.largest_error / self.limit

    @property
    def is_within(self) -> bool:
        """Whether the largest error is at most the limit."""
        return settle(self.utilisation) <= 1.0


def worst_of(rows: Sequence[JudgedOutput]) -> JudgedOutput:
    """Return the output that uses most of its limit; of equal ones the first."""
    return rows[first_largest([row.utilisation for row in rows])]


@written(
    "output",
    """
    *output as key
    resolution = output.resolution / unit: a spread at or below this is rounding
    mean / unit: expected error
    standard_uncertainty / unit
    lower_bound: whether the uncertainty is this or more, as a line that reaches it
      lacks
    nothing_known = is_unknown: whether no given line reaches it, and one lacks
    lacks: expected lines, not given, that would widen it
    interval / unit: coverage interval
    interval_by: what it is of, 'law', 'monte-carlo', 'simulation', 'prediction'
    coverage? [1]: of the interval; where none stands here it is that of the settings
    cep? = radii.cep / unit: of a length, radius of the circle that 50 % are in
    r95? = radii.r95 / unit: of a length, radius of the circle that 95 % are in
    drms? = standard_uncertainty / unit if radii: of a length, root of the summed
      variances
    coverage_factor [1]: half the interval over the standard uncertainty; null where
      nothing varies, or the two are of different methods
    degrees_of_freedom or null [1]: effective ones of the law; null where infinite or
      not known
    contributions: what each source alone does to it, by the law
    validation: of the law against Monte Carlo; null where that was not asked for
    """,
)
@dataclass(frozen=True, kw_only=True, repr=False)
class OutputBudget(Shown, JudgedOutput):
    """Expected error, its uncertainty and the contributions, for one output [SI]."""

    mean: float
    contributions: tuple[Contribution, ...]
    u_by: str = BY_LAW  # what mean and standard uncertainty are of, as `interval_by`
    law_factor: float | None = None  # k of the law [1], whatever the interval is of
    validation: Validation | None = None
    # Effective ones of u by the law, JCGM 100:2008, eq. (G.2b); None where u is of
    # trials or a lower bound, or a line of other devices is in it.
    degrees_of_freedom: float | None = inf
    radii: Radii | None = None  # of a length

    @property
    def coverage_factor(self) -> float | None:
        """Half the width of the interval over u [1].

        None where nothing varies, or where the two are of different methods.
        """
        if not self.is_resolved or self.interval_by != self.u_by:
            return None
        return (self.interval[1] - self.interval[0]) / 2.0 / self.standard_uncertainty

    def in_unit(self, unit: str = "") -> InUnit:
        """Return its numbers in a unit, the printed one without: both agree.

        Raises
        ------
        UnitError
            It is no unit of this quantity.
        """
        scale = self.output.si_per_unit
        if unit and unit != self.output.unit:
            scale = parse_quantity(f"1 {unit}", self.output.unit).value
        low, high = self.interval
        return InUnit(
            unit=unit or self.output.unit,
            mean=self.mean / scale,
            standard_uncertainty=self.standard_uncertainty / scale,
            interval=(low / scale, high / scale),
        )

    def lacking(self, lacks: tuple[Name, ...]) -> Self:
        """Return it where these lines alone are not given and would widen it."""
        contributions = (
            replace(part, lower_bound=part.lower_bound and bool(lacks))
            for part in self.contributions
        )
        return replace(self, lacks=lacks, contributions=tuple(contributions))

    @property
    def ranked(self) -> tuple[Contribution, ...]:
        """Contributions, the largest first."""
        shares = [part.share for part in self.contributions]
        return tuple(self.contributions[k] for k in from_largest(shares))


def widest_of_each(rows: Sequence[OutputBudget]) -> tuple[OutputBudget, ...]:
    """Return the output of each parameter with the largest u; of equal ones the first.

    In the order of the parameters.
    """
    groups: dict[tuple[str, str], list[OutputBudget]] = {}
    for row in rows:
        groups.setdefault((row.sensor, row.parameter), []).append(row)
    return tuple(
        own[first_largest([row.standard_uncertainty for row in own])]
        for own in groups.values()
    )


@written(
    "role_and_file",
    """
    role: 'device', 'procedure', 'station', ...
    *self as file
    """,
)
@written(
    "file",
    """
    name: base name, with #VARIANT where one was chosen
    sha256: of its bytes
    changes?: that the call laid over it
    """,
)
@dataclass(frozen=True, kw_only=True)
class InputFile(Documented):
    """One file that a result depends on, by base name and content."""

    role: str  # device, procedure, requirement
    name: str
    sha256: str
    changes: tuple[Changed, ...] = ()  # that the call laid over it


def input_files(
    devices: Sequence[Device],
    **files: Device | Procedure | Mission | Requirement | Costs | None,
) -> tuple[InputFile, ...]:
    """Return the files that a result depends on; several devices are numbered.

    Those that there are of `files` follow, each with its role.
    """
    number = " {}" if len(devices) > 1 else ""
    return (
        *(
            input_file(f"device{number.format(place)}", device)
            for place, device in enumerate(devices, start=1)
        ),
        *(input_file(role, file) for role, file in files.items() if file is not None),
        *named_files([*files.values()]),
    )


def named_files(
    files: Sequence[Device | Procedure | Mission | Requirement | Costs | None],
) -> tuple[InputFile, ...]:
    """Return the files that files name: stations of procedures, trajectories."""
    named: list[tuple[str, Origin | None]] = [
        (role, getattr(one, key, None))
        for role, key in (("station", "station_origin"), ("trajectory", "trajectory"))
        for one in files
    ]
    found = {(role, origin) for role, origin in named if origin is not None}
    return tuple(
        InputFile(role=role, name=origin.file, sha256=origin.sha256)
        for role, origin in sorted(found, key=lambda one: (one[0], one[1].file))
    )


def input_file(
    role: str, record: Device | Procedure | Mission | Requirement | Costs
) -> InputFile:
    """Return the file that a record was read from."""
    origin = record.origin
    return InputFile(
        role=role, name=origin.file, sha256=origin.sha256, changes=origin.changes
    )


CONVENTION = note(
    "Reading n of the axes, in counts a second, of an input u in body axes: "
    "n = K (M u + b), M = I + dT. Row i of M is what axis i shows of the body axes x, "
    "y, z. Back: u = T (n/K - b) with the bias b in sensor axes, or u = T n/K - T b "
    "with T b in body axes; T = inv(M), body from sensor axes."
)


def _printed(covariance: Array, outputs: Sequence[Output]) -> Array:
    """Return a covariance of outputs in products of their units."""
    scale = np.array([output.si_per_unit for output in outputs])
    return np.asarray(covariance / np.outer(scale, scale))


@written(
    "bias_of_matrix",
    """
    unit = output.unit
    value / unit (list[float])
    standard_uncertainty / unit (list[float])
    """,
    said="What turns readings into inputs, of one triad, at its nominal values.",
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Bias:
    """Biases of the three axes of a triad [SI]."""

    output: Output  # of the first axis
    value: Array
    standard_uncertainty: Array


@written(
    "matrices",
    """
    body_to_sensor = self as matrix: M, whose row i is what axis i shows of the body
      axes
    sensor_to_body = self as uncertain_matrix: T, the inverse of M
    bias_sensor = sensor_axes as bias_of_matrix: taken off before T
    bias_body = body_axes as bias_of_matrix: taken off after T
    bias_lower_bound = bias_lacks (bool): whether lines that are not given would widen
      the biases
    covariance = printed (list[list[float]]) [products of units]: of T row by row, bias
      in sensor axes, bias in body axes
    """,
    sensor_axes=lambda found: found.bias(9),
    body_axes=lambda found: found.bias(12),
    printed=lambda found: _printed(found.covariance, found.outputs),
)
@written(
    "uncertain_matrix",
    """
    value = T (list[list[float]]) [1]: row by row
    standard_uncertainty = u (list[list[float]]) [1]: of its elements
    lower_bound = lacks (bool): whether lines that are not given would widen it
    """,
    u=lambda found: found.standard_uncertainty[:9].reshape(3, 3),
)
@written(
    "matrix",
    """
    value = M (list[list[float]]) [1]: row by row
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Compensation(Documented):
    """What turns readings into inputs, of one triad, at its nominal values.

    Attributes
    ----------
    sensor : str
    outputs : tuple of Output, length 15
        T row by row, b in sensor axes, T b in body axes.
    value : ndarray, shape (15,)
        At the nominal values of the device [SI].
    covariance : ndarray, shape (15, 15)
        Joint, of what a calibration finds [products of SI units].
    lacks, bias_lacks : tuple of Name
        Expected lines that are not given and would widen T, and the biases.
    """

    sensor: str
    outputs: tuple[Output, ...]
    value: Array
    covariance: Array = field(repr=False)
    lacks: tuple[Name, ...] = ()
    bias_lacks: tuple[Name, ...] = ()

    @property
    def standard_uncertainty(self) -> Array:
        """Standard uncertainties in the order of the outputs, shape (15,) [SI]."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def T(self) -> Array:
        """Body from sensor axes, shape (3, 3) [1]."""
        return self.value[:9].reshape(3, 3)

    @property
    def M(self) -> Array:
        """Sensor from body axes, I + dT, shape (3, 3) [1]."""
        return np.asarray(np.linalg.inv(self.T))

    @property
    def bias_sensor(self) -> Array:
        """Bias b, taken off before T, shape (3,) [SI]."""
        return self.value[9:12]

    @property
    def bias_body(self) -> Array:
        """Bias T b, taken off after T, shape (3,) [SI]."""
        return self.value[12:]

    def bias(self, first: int) -> Bias:
        """Return three biases, the first of which stands there among the outputs."""
        own = slice(first, first + 3)
        return Bias(
            output=self.outputs[first],
            value=self.value[own],
            standard_uncertainty=self.standard_uncertainty[own],
        )


@written(
    "calibrated",
    """
    name: of the procedure
    cep [m]: of the horizontal position, time by time
    lower_bound = lacks (bool): whether an expected line that is not given would widen
      it
    worse_than: the maker's calibration, where it is farther off at the end than after
      that
    because: the line that adds most then
    """,
)
@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """How far off a unit is on a mission after one calibration, or none."""

    name: str  # of the procedure
    cep: tuple[float, ...]  # of the horizontal position, time by time [m]
    lacks: tuple[Name, ...]  # expected lines, not given, that would widen it
    # Of a test after which it is larger at the end than after the maker's calibration:
    # the name of that, and the line that adds most; '' and None of others.
    worse_than: str = ""
    because: Name | None = None


@written(
    "learnt",
    """
    sensor
    axis
    time [s]: at which an aid ends
    before [unit]: standard uncertainty without the filter
    after [unit]: and with it
    unit
    """,
)
@dataclass(frozen=True, kw_only=True)
class Learnt:
    """What a filter has found out of the bias of one axis, its slow noise with it."""

    sensor: str
    axis: str
    time: float  # at which an aid ends [s]
    before: float  # standard uncertainty without the filter [unit]
    after: float  # and with it [unit]
    unit: str


@written(
    "believed",
    """
    parameter: 'position', 'velocity', 'attitude'
    axis
    time [s]: since the mission began
    standard_uncertainty [unit]: as the filter believes
    true [unit]: what it is
    unit
    """,
)
@dataclass(frozen=True, kw_only=True)
class BelievedError:
    """An error of navigation as the filter believes it."""

    parameter: str  # 'position', 'velocity', 'attitude'
    axis: str
    time: float  # [s]
    standard_uncertainty: float  # [unit]
    true: float  # what it is [unit]
    unit: str


@written(
    "turned",
    """
    time [s]: of both ends
    straight [m]: root of the summed variances north and east
    turned [m]: the same, turned by 180 deg in the first half of the way on
    """,
)
@dataclass(frozen=True, kw_only=True)
class Turned:
    """How far off a mission ends, and one that turns where its aids end [m]."""

    time: float  # of both ends [s]
    straight: float  # root of the summed variances north and east [m]
    turned: float  # the same, turned by 180 deg in the first half of the way on [m]


@written(
    "filter",
    """
    kind: 'optimal' or 'own'
    states: how many it has
    updates: how many measurements it takes
    learnt: of biases, where aids end
    believed: errors of navigation, as it believes and as they are
    turned: of a mission that goes straight on without aids; null of others
    """,
)
@dataclass(frozen=True, kw_only=True)
class Filtered:
    """The filter of a mission with aids."""

    kind: str  # 'optimal' or 'own'
    states: int
    updates: int
    learnt: tuple[Learnt, ...]
    believed: tuple[BelievedError, ...]
    turned: Turned | None = None  # of a mission that goes straight on without aids


@written(
    "budget",
    """
    title: names of the devices
    inputs by role as file: files that it depends on
    settings: what it depends on besides
    mission = self if mission as mission_of_budget: that it is of; in a report all that
      `budget mission` says
    outputs
    quantities by source: the lines that contributions are of
    covariance = printed (list[list[float | None]]) [products of units]: of all outputs;
      null between a horizontal length and another output, of which no covariance is
      known
    not_given: lines of the data sheet that are absent
    missing = self if fills as missing: where lines stand for those that are not given
    assumptions
    warnings
    assessment: against the requirement; null where there is none
    readings?: other readings of lines whose meaning is open, one by one
    matrices = self if matrices as matrices_of_triads: where they were asked for
    one_at_a_time? = None (tuple[SourceSteps, ...]): of a report
    mission? = None (Budget)
    allocation? = None (Allocation): of a report with --allocate
    comparison? = None (Comparison): of a report with --compare
    """,
    commands="analyze report mission",
    fills=lambda budget: fills(budget.settings),
    printed=lambda budget: budget.printed_covariance,
)
@written(
    "matrices_of_triads",
    """
    convention (str): how they are used
    gyro? = matrices.gyro
    accelerometer? = matrices.accelerometer
    """,
    said="Compensation matrices, by triad.",
    convention=lambda _: CONVENTION,
)
@written(
    "mission_of_budget",
    """
    name = mission.name (str)
    duration = mission.route.duration (float) [s]
    route = mission.route.outline (Outline)
    alignment = mission.alignment (float) [s]: how long it finds level and north by
      itself; 0 where it knows them
    aided = mission.aided (bool): whether height and vertical velocity are known all the
      time
    calibrations = bought: how far off it is after none, the maker's, and this one
    filter?: where it has aids
    """,
    said="Where a calibrated unit goes by itself, and what it knows when it begins.",
)
@written(
    "missing",
    """
    mode = settings.missing: 'worst', 'typical' or 'predict'
    filled: what stands for expected lines
    left: expected lines that nothing stands for
    """,
    said="A line in the place of an expected one that is not given.",
)
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Budget(Study):
    """The error budget of a calibration: every output, and how they go together.

    Or of a mission after it, whose outputs are errors of navigation at some times.

    Attributes
    ----------
    outputs : tuple of OutputBudget
        One for each calibration parameter [SI].
    covariance : ndarray, shape (n_out, n_out)
        Joint covariance of all outputs in their order [products of SI units].
    could_widen : mapping of Name to tuple of Name
        The outputs that each line that is not given would reach.
    matrices : mapping of str to Compensation
        By triad, where they were asked for.
    """

    command: str
    outputs: tuple[OutputBudget, ...]
    covariance: Array = field(repr=False)
    could_widen: Mapping[Name, tuple[Name, ...]]
    assessment: Assessment | None = None  # against the requirement, where there is one
    matrices: Mapping[str, Compensation] = field(default_factory=dict)
    quantities: tuple[InputQuantity, ...] = ()  # what its contributions are of
    # What stands for expected lines that are not given, and those without a stand-in.
    filled: tuple[FilledLine, ...] = ()
    left: tuple[Name, ...] = ()
    readings: tuple[ReadingEffect, ...] = ()  # other ones than are taken, one by one
    mission: Mission | None = None  # that it is of; None: of a calibration
    # The same mission after no calibration, the maker's, and the one it is of.
    bought: tuple[Calibrated, ...] = ()
    filter: Filtered | None = None  # of that mission, where it has one

    @property
    def correlation(self) -> Array:
        """Correlation matrix, shape (n_out, n_out) [1]; 0 beside a constant output."""
        u = np.sqrt(np.diag(self.covariance))
        safe = np.where(u > 0.0, u, np.inf)
        return np.asarray(self.covariance / np.outer(safe, safe))

    @cached_property
    def _by_name(self) -> dict[str, OutputBudget]:
        """Outputs by all that each may be called."""
        return {
            name: row for row in self.outputs for name in spellings(row.output.name)
        }

    def output(self, name: str) -> OutputBudget:
        """Return the budget of one output by its dotted name, as `budget[name]` does.

        Of a mission the time may have its unit, 'mission.position.north.1 min', and the
        length of the horizontal vector no axis: 'mission.position.60 s'.

        Raises
        ------
        CallError
            There is none; it is a KeyError as well.
        """
        if name not in self._by_name:
            text = str(name)
            near = with_parts(text, self) or get_close_matches(text, self._by_name)
            meant = " or ".join(repr(str(one)) for one in near[:NEAR])
            raise NotThereError(
                f"found {name!r}, no output of this budget"
                f"{f'; did you mean {meant}?' if meant else '.'} It has {braced(self)}"
            )
        return self._by_name[name]

    def __getitem__(self, name: str) -> OutputBudget:
        """Return the budget of one output. Raises as `output`."""
        return self.output(name)

    def __contains__(self, name: object) -> bool:
        """Whether there is an output of that name."""
        return name in self._by_name

    def __iter__(self) -> Iterator[Name]:
        """Yield the names of the outputs, as a mapping does."""
        return (row.output.name for row in self.outputs)

    def __len__(self) -> int:
        """Count the outputs."""
        return len(self.outputs)

    def _ipython_key_completions_(self) -> list[str]:
        """Return what may stand in brackets: what a notebook completes."""
        return [*map(str, self)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Heads of the flat records: of a mission with the time, and what it adds."""
        if self.mission is None:
            return COLUMNS
        place = COLUMNS.index("unit")
        return (
            *COLUMNS[:place],
            AT_A_TIME,
            *COLUMNS[place:],
            *("coverage", *OF_A_LENGTH),
        )

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield one flat record for each output and source, and one `total` each.

        In printed units. Mean and interval belong to the total; on the rows of single
        sources they are None.
        """
        for row in self.outputs:
            total = document(row)
            key = {name: total[name] for name in (*KEY, AT_A_TIME) if name in total}
            low, high = total["interval"]
            parts = total["contributions"]
            total |= {"source": TOTAL, "share": sum(part["share"] for part in parts)}
            total |= {"interval_low": low, "interval_high": high}
            for record in (*({**key, **part} for part in parts), total):
                yield {name: record.get(name) for name in self.columns}

    @property
    def widening(self) -> tuple[Name, ...]:
        """Lines not given that could widen outputs, first those that reach most."""
        reached = self.could_widen
        return tuple(
            name
            for name in sorted(reached, key=lambda one: -len(reached[one]))
            if reached[name]
        )

    @property
    def printed_covariance(self) -> list[list[float | None]]:
        """Covariance in printed units: of a length with other outputs none is known."""
        found: list[list[float | None]] = _printed(
            self.covariance, [row.output for row in self.outputs]
        ).tolist()
        lengths = [k for k, one in enumerate(self.outputs) if one.output.length_of]
        for k in lengths:
            for other in range(len(found)):
                if other != k:
                    found[k][other] = found[other][k] = None
        return found

    def to_frame(self) -> pd.DataFrame:
        """Return `rows()` as a tidy pandas frame, in the units of its column `unit`."""
        import pandas as pd

        table = pd.DataFrame.from_records(list(self.rows()))
        return table.rename(columns={AT_A_TIME: TIME_COLUMN})

    @cached_property  # which a notebook completes, unlike a property
    def plot(self) -> Any:  # noqa: ANN401 - Plots, of a floor above this one
        """The figures of the report, `plot.contributions()`: matplotlib Figures."""
        return views.view().Plots(self)

    def to_markdown(self) -> str:
        """Return a table with a row for each output, rounded as in a report."""
        table: str = views.view().budget_markdown(self)
        return table

    def to_latex(self) -> str:
        """Return the same as a LaTeX tabular."""
        table: str = views.view().budget_latex(self)
        return table

    def to_xlsx(self, file: str | Path) -> Path:
        """Write a workbook: that table, contributions, notes (extra `xlsx`).

        Raises
        ------
        CallError
            The extra is not installed, or the file has another suffix than .xlsx.
        OutputError
            It cannot be written.
        """
        path: Path = views.view().write_xlsx(self, file)
        return path


@written(
    "filled_line",
    """
    source: the line that stands for it
    stands_for = expected: the expected line
    printed: of 'worst' as that device's file gives it
    unit
    standard_uncertainty = u / unit: of the largest axis; of 'predict' the median
    devices: how many give the line and are comparable
    designs: that these are variants of; null of 'worst'
    of = owners: of 'worst' the one device, else all that it comes from
    interval_50 / unit: of the standard uncertainty, by 'predict'
    interval_90 / unit: likewise
    """,
)
@dataclass(frozen=True, kw_only=True)
class FilledLine(Documented):
    """A line in the place of an expected one that is not given."""

    source: Name
    expected: Name  # what it stands for, 'gyro.noise'
    mode: str  # 'worst', 'typical' or 'predict'
    printed: str  # of 'worst' as that device's file gives it
    u: float  # of the largest axis; of 'predict' the median [SI]
    unit: str
    si_per_unit: float
    owners: tuple[str, ...]  # of 'worst' the one device, else all that it comes from
    devices: int  # that give the line and are comparable
    designs: int | None = None  # that these are variants of; None of 'worst'
    interval_50: tuple[float, float] | None = None  # of u, by 'predict' [SI]
    interval_90: tuple[float, float] | None = None

    def __str__(self) -> str:
        """'gyro.bias_stability 24 deg/h (of NAME)', or from how many devices."""
        return f"{self.source} {self.printed} ({self.basis})"

    @property
    def basis(self) -> str:
        """'of NAME', 'median of 3 designs', 'predicted from 9 devices of 4 designs'."""
        ends = self.interval_90
        return sentence(
            "filled.basis",
            owner=self.owners[0] if self.mode == "worst" else "",
            devices=self.devices,
            designs=self.designs,
            ends=None if ends is None else tuple(map(self._print, ends)),
        )

    @property
    def origin(self) -> str:
        """The basis, with how many devices the worst is of."""
        if self.mode != "worst":
            return self.basis
        return sentence("filled.worst", owner=self.owners[0], devices=self.devices)

    @property
    def words(self) -> str:
        """Say what was taken for it."""
        return sentence("filled.words", printed=self.printed, origin=self.origin)

    def _print(self, u: float) -> str:
        """Print a size to three digits."""
        return f"{float(f'{u / self.si_per_unit:.3g}'):g}"


@written(
    "ask",
    """
    source: the expected line
    reduction [1]: expected, of the doubt, were it known
    """,
)
@dataclass(frozen=True, kw_only=True)
class Ask:
    """A line that is not given, and what it is worth to be told it."""

    source: Name  # the expected line
    reduction: float  # expected, of the doubt min(p, 1 - p), were it known [1]


@written(
    "predicted",
    """
    probability [1]: that every largest error is within its limit
    doubt [1]: risk of the likelier verdict, min(p, 1 - p)
    utilisation_90 [1]: central 90 % of the utilisation
    worth_asking = asks: lines to ask for, the one that is worth most first
    """,
)
@dataclass(frozen=True, kw_only=True)
class Doubt(Documented):
    """Probability that a device meets over what its missing lines may be."""

    probability: float  # that every largest error is within its limit [1]
    utilisation_90: tuple[float, float]  # central 90 % of the utilisation [1]
    asks: tuple[Ask, ...]  # the one that is worth most first

    @property
    def doubt(self) -> float:
        """min(p, 1 - p): the risk of the likelier verdict [1]."""
        return min(self.probability, 1.0 - self.probability)


@written(
    "conformance",
    """
    conformance = value [1]: probability of being within all limits; null where nothing
      is known of it
    conformance_interval = interval [1]: 95 % sampling; null by the law
    """,
)
@dataclass(frozen=True, kw_only=True)
class Probability(Documented):
    """A probability with its 95 % sampling interval [1]."""

    value: float
    low: float | None  # None where it is computed by the law: not sampled, not exact
    high: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Both ends, where there are any."""
        low, high = self.low, self.high
        return None if low is None or high is None else (low, high)


@written(
    "reading_effect",
    """
    line: whose meaning the data sheet leaves open
    reading
    taken: the reading that the numbers stand on
    output: whose standard uncertainty changes most
    ratio or null [1]: of that, over the one with the reading taken; null over 0
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingEffect(Documented):
    """How another reading of one line alone changes the standard uncertainties."""

    line: Name  # whose meaning the data sheet leaves open
    reading: str
    taken: str  # the one that the numbers stand on
    output: Name  # whose u changes most
    ratio: float  # of its u, over that with the reading taken; inf over 0 [1]


@written(
    "reading",
    """
    readings = words (dict[str, str]): by line
    verdict
    utilisation [1]: the largest over the required outputs
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingVerdict:
    """The verdict under one combination of readings."""

    words: tuple[tuple[Name, str], ...]  # by line
    verdict: str
    utilisation: float  # the largest over the required outputs [1]


@written(
    "reading_verdicts",
    """
    combinations = total: of readings, that there are
    passes: under which it meets, 'all', 'some' or 'none' of those computed
    computed = found: the reading that is taken first
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingVerdicts(Documented):
    """The verdicts on one sensor under the readings of its open lines."""

    sensor: str
    total: int  # combinations that there are
    found: tuple[ReadingVerdict, ...]  # those computed, the one that is taken first

    @property
    def passing(self) -> tuple[ReadingVerdict, ...]:
        """Those under which it meets."""
        return tuple(one for one in self.found if one.verdict == "meets")

    @property
    def passes(self) -> str:
        """Under which readings it meets: 'all', 'some' or 'none' of those computed."""
        if len(self.passing) == len(self.found):
            return "all"
        return "some" if self.passing else "none"


@written(
    "condition",
    """
    kind: 'missing', 'temperature', 'vibration', 'age'
    line
    below / unit: the bound; null where none is needed, or known
    unit
    largest_comparable / unit: the largest that a comparable device prints, as a
      standard uncertainty
    ceiling / unit: the largest that is thought of
    decides: whether it leaves the verdict open
    not_given = silent: lines of a use that nobody has stated
    text: in words
    """,
)
@written(
    "caution",
    """
    kind
    line
    text: in words
    bound [unit]
    unit
    """,
    said="What qualifies a verdict, beside it wherever it stands.",
)
@dataclass(frozen=True, kw_only=True)
class Condition(Documented):
    """What must hold for a verdict, or what decides it and has to be asked for.

    Of a line that is not given, or of a use that nobody has stated. Or what qualifies
    it, beside it wherever it stands.
    """

    kind: str  # 'missing', 'temperature', 'vibration', 'age', ...
    line: Name
    text: str
    # The bound [SI]; None: none is needed, or none is known.
    below: float | None = None
    unit: str = ""
    si_per_unit: float = 1.0
    # The largest that a comparable device prints, as a standard uncertainty [SI].
    largest_comparable: float | None = None
    ceiling: float | None = None  # [SI]
    decides: bool = False  # whether it leaves the verdict open, being not given
    # Lines of a use that nobody has stated, which its sheet does not give.
    silent: tuple[Name, ...] = ()

    @property
    def bound(self) -> float | None:
        """The bound in its unit, where there is one."""
        return None if self.below is None else self.below / self.si_per_unit


@dataclass(frozen=True, kw_only=True)
class Remedy:
    """The source that limits a sensor, and what its line alone would have to be."""

    source: Name
    share: float  # of the variance of the worst output [1]
    factor: float | None  # on its standard uncertainty; None: it alone cannot mend it


# Of what nobody can judge.
UNJUDGED = Known(inf, low=-inf)
NO_REMEDY = Remedy(source=INTERACTION, share=0.0, factor=None)
NO_CONFORMANCE = Probability(value=0.0, low=0.0, high=1.0)


@written(
    "sensor_verdict",
    """
    sensor
    *self as verdict
    utilisation [1]: the largest over its required outputs
    utilisation_interval [1]: 95 % sampling, and the law's error
    worst_output: that uses most of its limit
    worst_outputs: that one and all that are equal to it
    limiting_source = remedy.source: with the largest share there
    *known_conformance as conformance
    trials: that were made; null by the law alone
    expected_missing: lines that a 'meets' cannot do without
    nothing_known: whether no error line is given
    predicted? = doubt: where the verdict rests on predicted lines
    not_estimated?: parameters with limits that are held in the test
    readings?: verdicts under the readings of lines whose meaning is open
    """,
    said="The verdict on one triad.",
)
@written(
    "standing",
    """
    sensor: or 'mission'
    *self as verdict
    """,
    said="A verdict and what it stands on, the same in every command.",
)
@written(
    "verdict",
    f"""
    verdict (Literal{list(VERDICTS)})
    calibration: after which
    station: at which
    use: in which
    mission or null: on which
    decision: by which rule limits are held
    conditions: that it rests on, or that decide
    cautions as caution
    utilisation_at_ceilings = at_ceilings [1]: with every missing line at its ceiling;
      null where one has none
    """,
    said="A verdict and what it stands on, the same in every command.",
)
@dataclass(frozen=True, kw_only=True)
class Verdict(Documented):
    """A verdict and what it stands on, the same in every command.

    On a sensor, on what belongs to both, or on a mission. In words: after which
    calibration, at which station, in which use, of which mission.
    """

    # 'meets', 'meets_if', 'predicted', 'undecided', 'undecidable', 'fails'.
    verdict: str
    conditions: tuple[Condition, ...] = ()  # that it holds if, or that decide
    cautions: tuple[Condition, ...] = ()
    # Utilisation with every missing line at its ceiling [1]; None: one has none.
    at_ceilings: float | None = None
    calibration: str = ""
    station: str = ""
    use: str = ""
    mission: str = ""
    decision: str = ""  # by which rule limits are held
    # Lines that are not given and, whatever they are, take next to nothing of a limit.
    negligible: tuple[Name, ...] = ()
    sensor: str = ""  # gyro, accelerometer; 'imu' of both, 'mission'
    # Required outputs against their limits; () of what nobody can judge, and below.
    outputs: tuple[JudgedOutput, ...] = ()
    utilisation: Known = UNJUDGED  # the largest of them [1]
    # 95 % sampling, and the law's error [1].
    utilisation_interval: tuple[float, float] = (0.0, inf)
    worst_outputs: tuple[Name, ...] = ()  # the worst, and all equal to it by the law
    remedy: Remedy = NO_REMEDY
    # Of all outputs together.
    conformance: Probability = NO_CONFORMANCE
    at_medians: bool = False  # its numbers are those at medians of predicted lines
    trials: int | None = None  # that were made; None by the law alone
    expected_missing: tuple[Name, ...] = ()  # lines that a 'meets' cannot do without
    nothing_known: bool = False  # no error line is given: a 0 is no good news
    doubt: Doubt | None = None  # of a verdict that rests on predicted lines
    not_estimated: tuple[Name, ...] = ()  # parameters with limits, held in the test
    readings: ReadingVerdicts | None = None  # where the meaning of lines is open

    @property
    def saturates(self) -> bool:
        """Whether a mission asks for more than a sensor reads.

        Its numbers are then those of one that reads enough.
        """
        return any(one.kind == "saturates" for one in self.cautions)

    @property
    def misses(self) -> bool:
        """Whether it is up to a line that nothing stands for.

        Its numbers are then that or more, and what is sure of it that or less.
        """
        is_open = any(one.ceiling is not None for one in self.conditions)
        return is_open or self.verdict == "undecidable"

    def matter(self, lacks: Iterable[Name]) -> tuple[Name, ...]:
        """Return of lines that are not given those that its limits are open to."""
        return tuple(name for name in lacks if name not in self.negligible)

    @property
    def asks(self) -> tuple[Condition, ...]:
        """The lines to ask the maker for, that which decides first."""
        return tuple(one for one in self.conditions if one.decides)

    @property
    def after(self) -> str:
        """Say what it is of: calibration, mission, use."""
        return sentence(
            "conditions.after",
            calibration=self.calibration,
            mission=self.mission,
            use=self.use,
        )

    @property
    def worst_output(self) -> Name:
        """The output that uses most of its limit; of equal ones the first."""
        return worst_of(self.outputs).output.name

    @property
    def known_conformance(self) -> Probability | None:
        """None where its numbers are not those of what is there.

        At the medians of predicted lines it would look better than it is.
        """
        is_other = self.at_medians or self.nothing_known or self.saturates
        return None if is_other else self.conformance

    @property
    def is_near(self) -> bool:
        """Whether it is undecided because its interval does not tell on which side."""
        low, high = map(settle, self.utilisation_interval)
        return self.verdict == "undecided" and low <= 1.0 < high

    @property
    def is_open_by_reading(self) -> bool:
        """Whether it is undecided because another reading of its lines fails."""
        is_all = self.readings is None or self.readings.passes == "all"
        return self.verdict == "undecided" and not self.is_near and not is_all

    def beside(self, other: Verdict) -> Self:
        """Return how both stand as one: the graver, what both hold if, and cautions.

        What both say alike stands once; numbers are those of the one that uses most.
        """
        ceilings = (self.at_ceilings, other.at_ceilings)
        known = [used for used in ceilings if used is not None]
        both: tuple[Verdict, ...] = (self, other)
        worst = max(both, key=lambda one: settle(one.utilisation))
        return replace(
            self,
            verdict=max(self.verdict, other.verdict, key=VERDICTS.index),
            outputs=(*self.outputs, *other.outputs),
            utilisation=Known.largest(one.utilisation for one in both),
            utilisation_interval=worst.utilisation_interval,
            worst_outputs=worst.worst_outputs,
            remedy=worst.remedy,
            at_medians=self.at_medians or other.at_medians,
            doubt=None,
            readings=None,
            conditions=tuple(dict.fromkeys((*self.conditions, *other.conditions))),
            cautions=tuple(dict.fromkeys((*self.cautions, *other.cautions))),
            at_ceilings=max(known) if len(known) == len(ceilings) else None,
        )


@written(
    "cap_assessment",
    """
    device
    merit: 'price', 'mass' or 'power'
    cap: as the requirement gives it
    given: as the device file gives it; '' where it does not
    is_within: null where nobody can tell
    """,
)
@dataclass(frozen=True, kw_only=True)
class CapAssessment:
    """What one device costs, weighs or draws against a cap; it decides no verdict."""

    device: str
    merit: str  # 'price', 'mass' or 'power'
    cap: str  # as the requirement file gives it
    given: str  # as the device file gives it; '' where it does not
    is_within: bool | None  # None where nobody can tell


@written(
    "assessment",
    """
    requirement: its name
    verdict: the gravest of the sensors; of limits to be kept together that of all
    *conformance as conformance
    sensors
    outputs
    not_there: sensors with limits that no device has
    caps
    """,
)
@dataclass(frozen=True, kw_only=True)
class Assessment(Documented):
    """A budget held against a requirement."""

    requirement: str  # its name
    outputs: tuple[JudgedOutput, ...]
    sensors: tuple[Verdict, ...]
    conformance: Probability | None  # of all outputs together; None: nothing known
    not_there: tuple[str, ...] = ()  # sensors with limits that no device has
    caps: tuple[CapAssessment, ...] = ()
    # Probability that all limits are to be kept together with; None: each alone [1].
    together: float | None = None

    @property
    def chance(self) -> float | None:
        """Probability that all sensors meet; None where nothing is predicted.

        As if the missing lines of two sensors were independent: of one device they go
        together, and then it is more.
        """
        doubts = [one.doubt for one in self.sensors if one.doubt is not None]
        return prod(one.probability for one in doubts) if doubts else None

    @property
    def verdict(self) -> str:
        """The gravest of the sensors; of limits to be kept together that of all."""
        found = max((one.verdict for one in self.sensors), key=VERDICTS.index)
        p = self.conformance
        if self.together is not None and p is not None and p.value < self.together:
            return VERDICTS[-1]
        return found

    @property
    def judged(self) -> tuple[JudgedOutput, ...]:
        """Outputs of which something is known."""
        unknown = {one.sensor for one in self.sensors if one.nothing_known}
        return tuple(
            row
            for row in self.outputs
            if row.output.name.owner not in unknown and not row.is_unknown
        )

    def outcome(self, row: JudgedOutput) -> str:
        """Return 'conforms', 'does not conform', or 'open' where its sensor's limit is.

        In the words of JCGM 106:2012, the largest error being held against the limit.
        """
        for sensor in self.sensors:
            if row.output.name.owner == sensor.sensor:
                low, high = sensor.utilisation_interval
                part = row.utilisation / max(sensor.utilisation, TINY)
                if sensor.verdict == "undecided" and low * part <= 1.0 < high * part:
                    return "open"
        return "conforms" if row.is_within else "does not conform"

    @property
    def open_rows(self) -> tuple[JudgedOutput, ...]:
        """Outputs that lines not given leave open; on conditions they are within."""
        waits = {one.sensor for one in self.sensors if one.verdict != "meets_if"}
        return tuple(
            row
            for row in self.outputs
            if row.lower_bound and row.is_within and row.output.name.owner in waits
        )
