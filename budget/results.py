"""Results of a budget: frozen records; SI inside, printed units on paper."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from importlib import import_module
from math import inf, isfinite, prod
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from budget.errors import NotThereError
from budget.language import note
from budget.names import Name
from budget.sentences import sentence
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
    from budget.problem import Output

SCHEMA = "budget/1"
# What draws a result stands above it, and is loaded when it is asked to.
SHOWN_BY = "budget.report.notebook"
INTERACTION = Name("interaction")  # the row of products of two sources
TOTAL = Name("total")
# Verdicts, best first; of parts put together the last one rules.
VERDICTS = ("meets", "meets_if", "predicted", "undecided", "undecidable", "fails")
TINY = 1e-300  # in the place of a utilisation of 0 [1]
KEY = ("sensor", "parameter", "axis", "unit")  # of an output in every record
AT_A_TIME = "time"  # further key of what is of a mission, after the axis
OF_A_LENGTH = ("cep", "r95", "drms")  # further numbers of a length
COLUMNS = (  # of the flat records
    *KEY,
    *("source", "standard_uncertainty", "share", "mean"),
    *("interval_low", "interval_high", "interval_by", "lower_bound"),
)
BY_LAW = "law"  # an interval mean +- k u
BY_TRIALS = "monte-carlo"  # an interval of trials
BY_PREDICTION = "prediction"  # one over what missing lines may be


class Tabled:
    """A result of a study that a notebook shows as a table."""

    def __repr__(self) -> str:
        """Name it, for whom the whole of it would be pages long."""
        return f"<{type(self).__name__}; to_frame() and to_dict() have its numbers>"

    def to_frame(self) -> pd.DataFrame:
        """Return the rows of its CSV document as a pandas frame, in printed units."""
        table: pd.DataFrame = import_module(SHOWN_BY).study_frame(self)
        return table

    def _repr_html_(self) -> str:
        """Return that table, as notebooks show it."""
        html: str = self.to_frame().to_html(na_rep="")
        return html


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


@dataclass(frozen=True, kw_only=True)
class InputQuantity:
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

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return {
            "printed": self.printed,
            "meaning": self.meaning,
            "unit": self.unit,
            "standard_uncertainty": list(self.u),
            "distribution": self.distribution,
            "divisor": self.divisor,
            "degrees_of_freedom": _finite(self.degrees_of_freedom),
            "origin": self.origin,
        }


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

    @property
    def linear(self) -> float | None:
        """C u(x) [SI unit of the output]; None where it has no line."""
        if self.u_input is None or self.sensitivity is None:
            return None
        return self.sensitivity * self.u_input

    @property
    def sobol_first(self) -> float | None:
        """First-order index [1], None where it was not estimated."""
        return None if self.sobol is None else self.sobol.first

    @property
    def sobol_total(self) -> float | None:
        """Total index [1], None where it was not estimated."""
        return None if self.sobol is None else self.sobol.total


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


@dataclass(frozen=True, kw_only=True)
class OutputBudget:
    """Expected error, its uncertainty and the contributions, for one output [SI]."""

    output: Output
    mean: float
    standard_uncertainty: float
    interval: tuple[float, float]
    contributions: tuple[Contribution, ...]
    interval_by: str = BY_LAW  # or 'monte-carlo', 'simulation', 'prediction'
    u_by: str = BY_LAW  # what mean and standard uncertainty are of, likewise
    law_factor: float | None = None  # k of the law [1], whatever the interval is of
    validation: Validation | None = None
    lacks: tuple[Name, ...] = ()  # expected lines, not given, that would widen it
    # Effective ones of u by the law, JCGM 100:2008, eq. (G.2b); None where u is of
    # trials or a lower bound, or a line of other devices is in it.
    degrees_of_freedom: float | None = inf
    coverage: float | None = None  # of its interval; None: the settings' [1]
    radii: Radii | None = None  # of a length

    @property
    def coverage_factor(self) -> float | None:
        """Half the width of the interval over u [1].

        None where nothing varies, or where the two are of different methods.
        """
        if not self.is_resolved or self.interval_by != self.u_by:
            return None
        return (self.interval[1] - self.interval[0]) / 2.0 / self.standard_uncertainty

    @property
    def by_trials(self) -> bool:
        """Whether the interval is of Monte Carlo."""
        return self.interval_by == BY_TRIALS

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
    def is_resolved(self) -> bool:
        """Whether the spread is more than the rounding of the computation."""
        return self.standard_uncertainty > self.output.resolution

    @property
    def lower_bound(self) -> bool:
        """Whether the uncertainty is this or more: a line that reaches it lacks."""
        return bool(self.lacks)

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known of it: no given line reaches it, one lacks."""
        return self.lower_bound and not self.is_resolved

    @property
    def largest_error(self) -> float:
        """Largest absolute end of the coverage interval [SI]."""
        return max(abs(self.interval[0]), abs(self.interval[1]))

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


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Everything besides the input files that a result depends on.

    As asked for, and then, with what was made of it, as part of the result.

    Attributes
    ----------
    method : str
        'gum' (law of propagation), 'monte-carlo' or 'simulation'.
    trials : int or None
        Monte Carlo trials (None asks for adaptive ones) or simulated runs.
    seed : int
        Same seed, same numbers.
    coverage : float
        Probability of the intervals [1].
    interval : str
        'symmetric' or 'shortest'; by the law both are mean +- k u.
    reference : str
        Error reference: 'nominal', 'as_tested', 'next_turn_on'.
    formulas : str
        Of the calibration: those of the procedure.
    only : tuple of Name
        Sources that count, all others 0; a bare name asks for both sensors.
    outputs : tuple of Name
        What is asked for; without any the parameters that are estimated.
    digits : int
        Significant digits of the uncertainties that adaptive trials make sure, and
        that the law is validated to; 1 or 2.
    sobol_samples : int or None
        Points in one scramble for Sobol' indices; None: there are none.
    max_trials : int or None
        Where adaptive trials stop at the latest; None: where they usually do.
    validate : bool
        Whether Monte Carlo checks the law.
    matrices : bool
        Whether the compensation matrices are asked for.
    missing : str
        What stands for expected lines that a device does not give: 'refuse' (nothing),
        'worst', 'typical' or 'predict'.
    """

    method: str = "gum"
    trials: int | None = None
    seed: int = 0
    coverage: float = 0.95
    interval: str = "symmetric"
    reference: str = "nominal"
    formulas: str = ""
    normals_per_trial: int | None = None
    only: tuple[Name, ...] = ()
    outputs: tuple[Name, ...] = ()
    digits: int = 1
    sobol_samples: int | None = None
    sobol_scrambles: int | None = None
    max_trials: int | None = None
    validate: bool = True
    matrices: bool = False
    missing: str = "refuse"

    def to_dict(self) -> dict[str, Any]:
        """Return what a document says of them."""
        document = asdict(self)
        del document["max_trials"], document["validate"], document["matrices"]
        if not self.outputs:
            del document["outputs"]
        if self.missing == "refuse":
            del document["missing"]
        return document


@dataclass(frozen=True, kw_only=True)
class InputFile:
    """One file that a result depends on, by base name and content."""

    role: str  # device, procedure, requirement
    name: str
    sha256: str
    changes: tuple[Changed, ...] = ()  # that the call laid over it

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        document: dict[str, Any] = {
            "role": self.role,
            "name": self.name,
            "sha256": self.sha256,
        }
        if self.changes:
            document["changes"] = [one.to_dict() for one in self.changes]
        return document


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


def inputs_document(files: Sequence[InputFile]) -> dict[str, Any]:
    """Return what documents say of files, by their roles."""
    documents = [file.to_dict() for file in files]
    return {document.pop("role"): document for document in documents}


CONVENTION = note(
    "Reading n of the axes, in counts a second, of an input u in body axes: "
    "n = K (M u + b), M = I + dT. Row i of M is what axis i shows of the body axes x, "
    "y, z. Back: u = T (n/K - b) with the bias b in sensor axes, or u = T n/K - T b "
    "with T b in body axes; T = inv(M), body from sensor axes."
)


@dataclass(frozen=True, kw_only=True, eq=False)
class Compensation:
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
    lower_bound, bias_lower_bound : bool
        Whether expected lines that are not given would widen T, and the biases.
    """

    sensor: str
    outputs: tuple[Output, ...]
    value: Array
    covariance: Array = field(repr=False)
    lower_bound: bool = False
    bias_lower_bound: bool = False

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

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        scale = np.array([output.si_per_unit for output in self.outputs])
        value, u = self.value / scale, self.standard_uncertainty / scale
        unit = self.outputs[-1].unit

        def of(rows: slice, *shape: int) -> dict[str, Any]:
            return {
                "value": value[rows].reshape(shape).tolist(),
                "standard_uncertainty": u[rows].reshape(shape).tolist(),
            }

        return {
            "body_to_sensor": {"value": self.M.tolist()},
            "sensor_to_body": {**of(slice(9), 3, 3), "lower_bound": self.lower_bound},
            "bias_sensor": {"unit": unit, **of(slice(9, 12), 3)},
            "bias_body": {"unit": unit, **of(slice(12, 15), 3)},
            "bias_lower_bound": self.bias_lower_bound,
            "covariance": (self.covariance / np.outer(scale, scale)).tolist(),
        }


@dataclass(frozen=True, kw_only=True)
class Calibrated:
    """How far off a unit is on a mission after one calibration, or none."""

    name: str  # of the procedure
    cep: tuple[float, ...]  # of the horizontal position, time by time [m]
    lower_bound: bool  # whether an expected line that is not given would widen it
    # Of a test after which it is larger at the end than after the maker's calibration:
    # the name of that, and the line that adds most; '' and None of others.
    worse_than: str = ""
    because: Name | None = None


@dataclass(frozen=True, kw_only=True)
class Learnt:
    """What a filter has found out of the bias of one axis, its slow noise with it."""

    sensor: str
    axis: str
    time: float  # at which an aid ends [s]
    before: float  # standard uncertainty without the filter [unit]
    after: float  # and with it [unit]
    unit: str


@dataclass(frozen=True, kw_only=True)
class BelievedError:
    """An error of navigation as the filter believes it."""

    parameter: str  # 'position', 'velocity', 'attitude'
    axis: str
    time: float  # [s]
    standard_uncertainty: float  # [unit]
    true: float  # what it is [unit]
    unit: str


@dataclass(frozen=True, kw_only=True)
class Turned:
    """How far off a mission ends, and one that turns where its aids end [m]."""

    time: float  # of both ends [s]
    straight: float  # root of the summed variances north and east [m]
    turned: float  # the same, turned by 180 deg in the first half of the way on [m]


@dataclass(frozen=True, kw_only=True)
class Filtered:
    """The filter of a mission with aids."""

    kind: str  # 'optimal' or 'own'
    states: int
    updates: int
    learnt: tuple[Learnt, ...]
    believed: tuple[BelievedError, ...]
    turned: Turned | None = None  # of a mission that goes straight on without aids


@dataclass(frozen=True, kw_only=True, eq=False)
class Budget:
    """The error budget of a calibration: every output, and how they go together.

    Or of a mission after it, whose outputs are errors of navigation at some times.

    Attributes
    ----------
    title : str
        Names of the devices.
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
    title: str
    inputs: tuple[InputFile, ...]
    settings: Settings
    outputs: tuple[OutputBudget, ...]
    covariance: Array = field(repr=False)
    not_given: tuple[Name, ...]
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
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
    # What it is of (budget.studies.request.Analysis): results know nothing of files.
    analysis: object = field(default=None, repr=False)

    @property
    def correlation(self) -> Array:
        """Correlation matrix, shape (n_out, n_out) [1]; 0 beside a constant output."""
        u = np.sqrt(np.diag(self.covariance))
        safe = np.where(u > 0.0, u, np.inf)
        return np.asarray(self.covariance / np.outer(safe, safe))

    def output(self, name: str) -> OutputBudget:
        """Return the budget of one output by its dotted name.

        Raises
        ------
        CallError
            There is none; it is a KeyError as well.
        """
        for row in self.outputs:
            if row.output.name == name:
                return row
        there = ", ".join(row.output.name for row in self.outputs)
        raise NotThereError(f"found {name!r}, this budget has: {there}")

    def __repr__(self) -> str:
        """Name it; `to_frame`, `to_markdown` and a notebook show its numbers."""
        return f"<budget of {self.title}, {len(self.outputs)} outputs>"

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
            total = _output_document(row, {})
            key = {name: total[name] for name in (*KEY, AT_A_TIME) if name in total}
            low, high = total["interval"]
            parts = total["contributions"]
            total |= {"source": TOTAL, "share": sum(part["share"] for part in parts)}
            total |= {"interval_low": low, "interval_high": high}
            for record in (*({**key, **part} for part in parts), total):
                yield {name: record.get(name) for name in self.columns}

    def to_frame(self) -> pd.DataFrame:
        """Return `rows()` as a tidy pandas frame, in printed units."""
        import pandas as pd

        return pd.DataFrame.from_records(list(self.rows()))

    @property
    def plot(self) -> Any:  # noqa: ANN401 - Plots, of a floor above this one
        """The figures of the report, `plot.contributions()`: matplotlib Figures."""
        return import_module(SHOWN_BY).Plots(self)

    def to_markdown(self) -> str:
        """Return a table with a row for each output, rounded as in a report."""
        table: str = import_module(SHOWN_BY).budget_markdown(self)
        return table

    def to_latex(self) -> str:
        """Return the same as a LaTeX tabular."""
        table: str = import_module(SHOWN_BY).budget_latex(self)
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
        path: Path = import_module(SHOWN_BY).write_xlsx(self, file)
        return path

    def _repr_html_(self) -> str:
        """Return a small table, as notebooks show it."""
        table: str = import_module(SHOWN_BY).budget_html(self)
        return table

    def _mission(self) -> dict[str, Any]:
        """Return what documents say of the mission; {} of a calibration."""
        if self.mission is None:
            return {}
        route = self.mission.route
        return {
            "mission": {
                "name": self.mission.name,
                "duration": route.duration,
                "route": asdict(route.outline),
                "alignment": self.mission.alignment,
                "aided": self.mission.aided,
                "calibrations": [asdict(one) for one in self.bought],
                **({} if self.filter is None else {"filter": asdict(self.filter)}),
            }
        }

    def _covariance(self, scaled: Array) -> list[list[float | None]]:
        """Return it for documents: of a length with other outputs none is known."""
        found: list[list[float | None]] = scaled.tolist()
        lengths = [k for k, one in enumerate(self.outputs) if one.output.length_of]
        for k in lengths:
            for other in range(len(found)):
                if other != k:
                    found[k][other] = found[other][k] = None
        return found

    def _missing(self) -> dict[str, Any]:
        """Return what documents say of lines that are not given; {} to refuse."""
        if self.settings.missing == "refuse":
            return {}
        filled = [line.to_dict() for line in self.filled]
        left, mode = list(self.left), self.settings.missing
        return {"missing": {"mode": mode, "filled": filled, "left": left}}

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON document of schema `budget/1`, in printed units."""
        scale = np.array([row.output.si_per_unit for row in self.outputs])
        quantities = {one.source: one for one in self.quantities}
        return {
            "schema": SCHEMA,
            "command": self.command,
            "title": self.title,
            "inputs": inputs_document(self.inputs),
            "settings": self.settings.to_dict(),
            **self._mission(),
            "outputs": [_output_document(row, quantities) for row in self.outputs],
            "quantities": {
                name: quantity.to_dict() for name, quantity in quantities.items()
            },
            "covariance": self._covariance(self.covariance / np.outer(scale, scale)),
            "not_given": list(self.not_given),
            **self._missing(),
            "assumptions": list(self.assumptions),
            "warnings": list(self.warnings),
            "assessment": None
            if self.assessment is None
            else self.assessment.to_dict(),
            **(
                {"readings": [one.to_dict() for one in self.readings]}
                if self.readings
                else {}
            ),
            **(
                {
                    "matrices": {
                        "convention": CONVENTION,
                        **{kind: one.to_dict() for kind, one in self.matrices.items()},
                    }
                }
                if self.matrices
                else {}
            ),
        }


def _finite(number: float | None) -> float | None:
    """Return a number, None where it is infinite: JSON has no word for that."""
    return None if number is None or not isfinite(number) else number


def _output_document(
    row: OutputBudget, quantities: Mapping[Name, InputQuantity]
) -> dict[str, Any]:
    """Return one entry of `outputs` in the JSON document, in printed units."""
    scale = row.output.si_per_unit
    validation = None
    if row.validation is not None:
        validation = {
            "trials": row.validation.trials,
            "holds": row.validation.holds,
            "difference_low": row.validation.difference_low / scale,
            "difference_high": row.validation.difference_high / scale,
            "tolerance": row.validation.tolerance / scale,
            "interval": [end / scale for end in row.validation.interval],
            "reached": row.validation.reached / scale,
        }
    return {
        **_key_document(row.output),
        "resolution": row.output.resolution / scale,
        "mean": row.mean / scale,
        "standard_uncertainty": row.standard_uncertainty / scale,
        "lower_bound": row.lower_bound,
        "nothing_known": row.is_unknown,
        "lacks": list(row.lacks),
        "interval": [end / scale for end in row.interval],
        "interval_by": row.interval_by,
        **({} if row.coverage is None else {"coverage": row.coverage}),
        **_length_document(row, scale),
        "coverage_factor": row.coverage_factor,
        "degrees_of_freedom": _finite(row.degrees_of_freedom),
        "contributions": [
            _contribution_document(part, scale, quantities.get(part.source))
            for part in row.contributions
        ],
        "validation": validation,
    }


def _key_document(output: Output) -> dict[str, Any]:
    """Return what names an output in documents, and the unit of its numbers."""
    name = output.name
    return {
        "sensor": name.owner,
        "parameter": name.quantity,
        "axis": name.axis,
        **({} if name.time is None else {AT_A_TIME: name.time}),
        "unit": output.unit,
    }


def _length_document(row: OutputBudget, scale: float) -> dict[str, float]:
    """Return the further numbers of a length; {} of all else."""
    if row.radii is None:
        return {}
    sizes = (row.radii.cep, row.radii.r95, row.standard_uncertainty)
    return {key: size / scale for key, size in zip(OF_A_LENGTH, sizes, strict=True)}


def _contribution_document(
    part: Contribution, scale: float, quantity: InputQuantity | None
) -> dict[str, Any]:
    """Return one entry of `contributions`, in printed units."""
    document: dict[str, Any] = {
        "source": part.source,
        "standard_uncertainty": part.standard_uncertainty / scale,
        "share": part.share,
        "lower_bound": part.lower_bound,
        "sobol_first": part.sobol_first,
        "sobol_total": part.sobol_total,
    }
    if quantity and part.u_input is not None and part.sensitivity is not None:
        unit = quantity.si_per_unit
        document |= {
            "u_input": part.u_input / unit,
            "sensitivity": part.sensitivity / scale * unit,
        }
    if part.sobol is not None:
        document |= {
            "sobol_first_interval": list(part.sobol.first_interval),
            "sobol_total_interval": list(part.sobol.total_interval),
            "sobol_interacts": part.sobol.interacts,
            "sobol_rank": part.sobol.rank,
        }
    return document


@dataclass(frozen=True, kw_only=True)
class FilledLine:
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

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""

        def of(ends: tuple[float, float] | None) -> list[float] | None:
            return None if ends is None else [end / self.si_per_unit for end in ends]

        return {
            "source": self.source,
            "stands_for": self.expected,
            "printed": self.printed,
            "unit": self.unit,
            "standard_uncertainty": self.u / self.si_per_unit,
            "devices": self.devices,
            "designs": self.designs,
            "of": list(self.owners),
            "interval_50": of(self.interval_50),
            "interval_90": of(self.interval_90),
        }


@dataclass(frozen=True, kw_only=True)
class Ask:
    """A line that is not given, and what it is worth to be told it."""

    source: Name  # the expected line
    reduction: float  # expected, of the doubt min(p, 1 - p), were it known [1]


@dataclass(frozen=True, kw_only=True)
class Doubt:
    """Probability that a device meets over what its missing lines may be."""

    probability: float  # that every largest error is within its limit [1]
    utilisation_90: tuple[float, float]  # central 90 % of the utilisation [1]
    asks: tuple[Ask, ...]  # the one that is worth most first

    @property
    def doubt(self) -> float:
        """min(p, 1 - p): the risk of the likelier verdict [1]."""
        return min(self.probability, 1.0 - self.probability)

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return {
            "probability": self.probability,
            "doubt": self.doubt,
            "utilisation_90": list(self.utilisation_90),
            "worth_asking": [asdict(ask) for ask in self.asks],
        }


@dataclass(frozen=True, kw_only=True)
class Probability:
    """A probability with its 95 % sampling interval [1]."""

    value: float
    low: float | None  # None where it is computed by the law: not sampled, not exact
    high: float | None

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of a conformance and its interval."""
        ends = None if self.low is None else [self.low, self.high]
        return {"conformance": self.value, "conformance_interval": ends}


@dataclass(frozen=True, kw_only=True, slots=True)
class OutputAssessment:
    """One required output against its limit [SI]."""

    output: Output
    limit: float
    printed_limit: str  # as the requirement file gives it
    standard_uncertainty: float  # by the law
    interval: tuple[float, float]  # coverage interval
    interval_by: str  # 'law' or 'monte-carlo'
    conformance: float  # probability that the error is within the limit [1]
    lower_bound: bool = False  # a line that is not given would widen it
    is_unknown: bool = False  # and no line that is given reaches it
    coverage: float | None = None  # of the interval; None: the requirement's [1]

    @property
    def largest_error(self) -> float:
        """Largest absolute end of the coverage interval [SI]."""
        return max(abs(self.interval[0]), abs(self.interval[1]))

    @property
    def utilisation(self) -> float:
        """Largest error over limit [1]."""
        return self.largest_error / self.limit

    @property
    def by_monte_carlo(self) -> bool:
        """Whether the interval is of trials, the law not being sure enough."""
        return self.interval_by == BY_TRIALS

    @property
    def is_within(self) -> bool:
        """Whether the largest error is at most the limit."""
        return settle(self.utilisation) <= 1.0

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        scale = self.output.si_per_unit
        return {
            **_key_document(self.output),
            **({} if self.coverage is None else {"coverage": self.coverage}),
            "resolution": self.output.resolution / scale,
            "limit": self.limit / scale,
            "standard_uncertainty": self.standard_uncertainty / scale,
            "interval": [end / scale for end in self.interval],
            "interval_by": self.interval_by,
            "largest_error": self.largest_error / scale,
            "utilisation": self.utilisation,
            "conformance": self.conformance,
            "lower_bound": self.lower_bound,
            "nothing_known": self.is_unknown,
        }


def worst_of(rows: Sequence[OutputAssessment]) -> OutputAssessment:
    """Return the output that uses most of its limit; of equal ones the first."""
    return rows[first_largest([row.utilisation for row in rows])]


@dataclass(frozen=True, kw_only=True)
class ReadingEffect:
    """How another reading of one line alone changes the standard uncertainties."""

    line: Name  # whose meaning the data sheet leaves open
    reading: str
    taken: str  # the one that the numbers stand on
    output: Name  # whose u changes most
    ratio: float  # of its u, over that with the reading taken; inf over 0 [1]

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it; a ratio over 0 is none."""
        return {**asdict(self), "ratio": self.ratio if self.ratio < inf else None}


@dataclass(frozen=True, kw_only=True)
class Reading:
    """The verdict under one combination of readings."""

    words: tuple[tuple[Name, str], ...]  # by line
    verdict: str
    utilisation: float  # the largest over the required outputs [1]


@dataclass(frozen=True, kw_only=True)
class ReadingVerdicts:
    """The verdicts on one sensor under the readings of its open lines."""

    sensor: str
    total: int  # combinations that there are
    found: tuple[Reading, ...]  # those computed, the one that is taken first

    @property
    def passing(self) -> tuple[Reading, ...]:
        """Those under which it meets."""
        return tuple(one for one in self.found if one.verdict == "meets")

    @property
    def passes(self) -> str:
        """Under which readings it meets: 'all', 'some' or 'none' of those computed."""
        if len(self.passing) == len(self.found):
            return "all"
        return "some" if self.passing else "none"

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return {
            "combinations": self.total,
            "passes": self.passes,
            "computed": [
                {
                    "readings": dict(one.words),
                    "verdict": one.verdict,
                    "utilisation": one.utilisation,
                }
                for one in self.found
            ],
        }


@dataclass(frozen=True, kw_only=True)
class Condition:
    """What must hold for a verdict, or what decides it and has to be asked for.

    Of a line that is not given, or of a use that nobody has stated.
    """

    kind: str  # 'missing', 'temperature', 'vibration', 'age'
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

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in its unit."""

        def of(size: float | None) -> float | None:
            return None if size is None else size / self.si_per_unit

        return {
            "kind": self.kind,
            "line": self.line,
            "below": of(self.below),
            "unit": self.unit,
            "largest_comparable": of(self.largest_comparable),
            "ceiling": of(self.ceiling),
            "decides": self.decides,
            "not_given": list(self.silent),
            "text": self.text,
        }


@dataclass(frozen=True, kw_only=True)
class Caution:
    """What qualifies a verdict, beside it wherever it stands."""

    kind: str
    line: Name
    text: str
    bound: float | None = None  # [unit]
    unit: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return asdict(self)


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A verdict and what it stands on, the same in every command.

    In words: after which calibration, at which station, in which use, of which mission.
    """

    verdict: str
    conditions: tuple[Condition, ...] = ()  # that it holds if, or that decide
    cautions: tuple[Caution, ...] = ()
    # Utilisation with every missing line at its ceiling [1]; None: one has none.
    at_ceilings: float | None = None
    calibration: str = ""
    station: str = ""
    use: str = ""
    mission: str = ""
    decision: str = ""  # by which rule limits are held
    # Lines that are not given and, whatever they are, take next to nothing of a limit.
    negligible: tuple[Name, ...] = ()

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

    def beside(self, other: Standing, *, verdict: str) -> Standing:
        """Return how both stand as one: with the conditions and the cautions of both.

        What both say alike stands once.
        """
        ceilings = (self.at_ceilings, other.at_ceilings)
        known = [used for used in ceilings if used is not None]
        return replace(
            self,
            verdict=verdict,
            conditions=tuple(dict.fromkeys((*self.conditions, *other.conditions))),
            cautions=tuple(dict.fromkeys((*self.cautions, *other.cautions))),
            at_ceilings=max(known) if len(known) == len(ceilings) else None,
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it."""
        return {
            "calibration": self.calibration,
            "station": self.station,
            "use": self.use,
            "mission": self.mission or None,
            "decision": self.decision,
            "conditions": [one.to_dict() for one in self.conditions],
            "cautions": [one.to_dict() for one in self.cautions],
            "utilisation_at_ceilings": self.at_ceilings,
        }


@dataclass(frozen=True, kw_only=True)
class SensorAssessment:
    """The verdict on one triad."""

    sensor: str  # gyro or accelerometer
    standing: Standing
    utilisation: float  # the largest over its required outputs [1]
    utilisation_interval: tuple[float, float]  # 95 % sampling, and the law's error [1]
    worst_output: Name
    worst_outputs: tuple[Name, ...]  # that one and all that are equal to it
    limiting_source: Name
    conformance: Probability | None  # of all its outputs together; None: not known
    trials: int | None  # that were made; None by the law alone
    expected_missing: tuple[Name, ...]  # lines that a 'meets' cannot do without
    nothing_known: bool = False  # no error line is given: a 0 is no good news
    doubt: Doubt | None = None  # of a verdict that rests on predicted lines
    not_estimated: tuple[Name, ...] = ()  # parameters with limits, held in the test
    readings: ReadingVerdicts | None = None  # where the meaning of lines is open

    @property
    def verdict(self) -> str:
        """'meets', 'meets_if', 'predicted', 'undecided', 'undecidable', 'fails'."""
        return self.standing.verdict

    @property
    def is_open_by_reading(self) -> bool:
        """Whether it is undecided because another reading of its lines fails."""
        low, high = map(settle, self.utilisation_interval)
        return self.verdict == "undecided" and not low <= 1.0 < high


@dataclass(frozen=True, kw_only=True)
class CapAssessment:
    """What one device costs, weighs or draws against a cap; it decides no verdict."""

    device: str
    merit: str  # 'price', 'mass' or 'power'
    cap: str  # as the requirement file gives it
    given: str  # as the device file gives it; '' where it does not
    is_within: bool | None  # None where nobody can tell


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """A budget held against a requirement."""

    requirement: str  # its name
    outputs: tuple[OutputAssessment, ...]
    sensors: tuple[SensorAssessment, ...]
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
    def judged(self) -> tuple[OutputAssessment, ...]:
        """Outputs of which something is known."""
        unknown = {one.sensor for one in self.sensors if one.nothing_known}
        return tuple(
            row
            for row in self.outputs
            if row.output.name.owner not in unknown and not row.is_unknown
        )

    def outcome(self, row: OutputAssessment) -> str:
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
    def open_rows(self) -> tuple[OutputAssessment, ...]:
        """Outputs that lines not given leave open; on conditions they are within."""
        waits = {one.sensor for one in self.sensors if one.verdict != "meets_if"}
        return tuple(
            row
            for row in self.outputs
            if row.lower_bound and row.is_within and row.output.name.owner in waits
        )

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        return {
            "requirement": self.requirement,
            "verdict": self.verdict,
            **_conformance(self.conformance),
            "sensors": [
                {
                    "sensor": one.sensor,
                    "verdict": one.verdict,
                    **one.standing.to_dict(),
                    "utilisation": one.utilisation,
                    "utilisation_interval": list(one.utilisation_interval),
                    "worst_output": one.worst_output,
                    "worst_outputs": list(one.worst_outputs),
                    "limiting_source": one.limiting_source,
                    **_conformance(one.conformance),
                    "trials": one.trials,
                    "expected_missing": list(one.expected_missing),
                    "nothing_known": one.nothing_known,
                    **({"predicted": one.doubt.to_dict()} if one.doubt else {}),
                    **(
                        {"not_estimated": names}
                        if (names := list(one.not_estimated))
                        else {}
                    ),
                    **(
                        {"readings": one.readings.to_dict()}
                        if one.readings is not None
                        else {}
                    ),
                }
                for one in self.sensors
            ],
            "outputs": [row.to_dict() for row in self.outputs],
            "not_there": list(self.not_there),
            "caps": [asdict(cap) for cap in self.caps],
        }


def _conformance(p: Probability | None) -> dict[str, Any]:
    """Return a conformance for documents; None where nothing is known."""
    if p is None:
        return {"conformance": None, "conformance_interval": None}
    return p.to_dict()
