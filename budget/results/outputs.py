"""Outputs of a budget: how large their errors are, of what, and of what limit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING, Self

from budget.documents import Documented, Shown, written
from budget.known import Known
from budget.names import Name
from budget.problem import Output
from budget.ties import first_largest, from_largest, settle
from budget.units import parse_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence


INTERACTION = Name("interaction")  # the row of products of two sources
TOTAL = Name("total")
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
CEP, R95 = 0.5, 0.95  # coverages of these [1]


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
    lower_bound = standard_uncertainty.is_bound: whether products with lines that are
      not given are not in it
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
    # Of products a bound, where lines are not given [SI unit of the output].
    standard_uncertainty: Known
    share: float  # of the law's own total variance [1]
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


@dataclass(frozen=True, kw_only=True)
class LimitedOutput(Documented):
    """An output and its limit, where it has one."""

    output: Output
    limit: float = inf  # on the absolute error [SI]
    printed_limit: str = ""  # as the requirement file gives it

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


def u_known(output: Output, u: float, lacks: tuple[Name, ...]) -> Known:
    """Return a standard uncertainty which lines that are not given would add to."""
    return Known.of(float(u), lacks, is_felt=u > output.resolution)


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
    lower_bound = standard_uncertainty.is_bound: whether a line that is not given would
      widen it
    nothing_known = standard_uncertainty.is_unknown: whether no line that is given
      reaches it besides
    """,
    said="One required output against its limit.",
)
@dataclass(frozen=True, kw_only=True)
class JudgedOutput(LimitedOutput):
    """One output, how large its error is, and its limit, where it has one [SI]."""

    # As far as it is known; its other sizes are known as this is.
    standard_uncertainty: Known
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
    def largest_error(self) -> Known:
        """Largest absolute end of the coverage interval [SI]."""
        return self.standard_uncertainty.like(max(map(abs, self.interval)))

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
    lower_bound = standard_uncertainty.is_bound: whether the uncertainty is this or
      more, as a line that reaches it lacks
    nothing_known = standard_uncertainty.is_unknown: whether no given line reaches it,
      and one lacks
    lacks = standard_uncertainty.why: expected lines, not given, that would widen it
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
            standard_uncertainty=float(self.standard_uncertainty) / scale,
            interval=(low / scale, high / scale),
        )

    def lacking(self, lacks: tuple[Name, ...]) -> Self:
        """Return it where these lines alone are not given and would widen it."""
        contributions = (
            replace(part, standard_uncertainty=Known.of(float(u), lacks))
            if (u := part.standard_uncertainty).is_bound
            else part
            for part in self.contributions
        )
        return replace(
            self,
            standard_uncertainty=u_known(self.output, self.standard_uncertainty, lacks),
            contributions=tuple(contributions),
        )

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
