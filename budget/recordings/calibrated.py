"""What a recorded calibration says: values, how sure they are, whether it was sound."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from budget.calibration.problem import BIAS_UNITS
from budget.documents import Documented, written
from budget.names import AXES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.arrays import Array
    from budget.calibration.mistakes import Mistake
    from budget.inputs.records import ErrorLine
    from budget.names import Name
    from budget.recordings.records import RecordedConditions
    from budget.results import InputFile


Key = tuple[str, str, str]  # sensor, parameter, axis


@written(
    "calibrated_output",
    """
    sensor: 'gyro', 'accelerometer' or, of both together, 'imu'
    parameter: 'scale_factor', 'mounting_angle', 'bias', or what is derived of them
    axis
    unit: of a scale factor in counts 'counts/(deg/s)' and the like
    value / unit [unit]: of a scale factor the relative deviation from the nominal one
    standard_uncertainty / unit [unit]: against the values during the test
    coverage_factor [1]
    degrees_of_freedom or null [1]: null where infinite
    interval_low = interval.0 / unit [unit]: value - k u
    interval_high = interval.1 / unit [unit]
    prior / unit [unit]: standard uncertainty before, by the data sheet; null where it
      gives none
    prior_z [1]: value less the nominal one, over both standard uncertainties; likewise
    remaining [1]: standard uncertainty over the one before; likewise
    limit / unit [unit]: on the absolute error; null where there is none
    utilisation [1]: k u over the limit; likewise
    as_found / unit [unit]: error of the unit as it came, known to k u: value less that
      of the correction in force, or less the nominal one of a unit without; null where
      nothing says it
    as_left = expanded / unit [unit]: what is left after the correction by the value
    found_standing: whether the error as found with k u 'meets' the limit, 'fails' it,
      or is 'undecided' (JCGM 106, 8.3); null without a limit, and where the run is not
      sound
    left_standing: likewise of what is left, which 'fails' where k u is above the limit
    """,
)
@dataclass(frozen=True, kw_only=True)
class CalibratedOutput(Documented):
    """One parameter of a unit, as it was calibrated."""

    sensor: str
    parameter: str
    axis: str
    unit: str
    si_per_unit: float
    value: float
    standard_uncertainty: float
    coverage_factor: float
    degrees_of_freedom: float
    prior: float | None
    prior_z: float | None
    limit: float | None = None
    as_found: float | None = None
    found_standing: str | None = None
    left_standing: str | None = None

    @property
    def expanded(self) -> float:
        """U = k u [SI]."""
        return self.coverage_factor * self.standard_uncertainty

    @property
    def interval(self) -> tuple[float, float]:
        """Value -+ k u [SI]."""
        return self.value - self.expanded, self.value + self.expanded

    @property
    def remaining(self) -> float | None:
        """Standard uncertainty over the one before."""
        if not self.prior:
            return None
        return self.standard_uncertainty / self.prior

    @property
    def utilisation(self) -> float | None:
        """Of the limit."""
        return None if self.limit is None else self.expanded / self.limit


@written(
    "correction_in_force",
    """
    name: of the result that it is of
    title
    serial
    date: of its run; empty where nobody said it
    procedure
    is_sound or null: whether its run was
    """,
    said="An earlier calibration, whose correction a unit came with.",
)
@dataclass(frozen=True, kw_only=True, eq=False)
class CalibrationResult(Documented):
    """What a document of `budget calibrate` says of its values.

    Attributes
    ----------
    name : str
        Of its file.
    sha256 : str
    title, serial, date, procedure : str
    is_sound : bool or None
    keys : tuple of (str, str, str)
        Sensor, parameter and axis of each value.
    units : tuple of str
    values, expanded, degrees_of_freedom : ndarray, shape (n,)
        In these units; nan where u is not known.
    covariance : ndarray, shape (n, n)
        Likewise.
    is_bound : bool
        Whether uncertainties are lower bounds.
    recordings : frozenset of str
        SHA-256 of the recordings of the run; empty where none is named.
    has_device : bool
        Whether uncertainties are of a data sheet, not of the scatter.
    has_station : bool
        Whether what is not known of table and place is among them.
    files : mapping of str to str
        SHA-256 of the files it was made with, by role; '' where it does not say.
    changes : tuple of dict
        What was laid over the device file.
    """

    name: str
    sha256: str
    title: str
    serial: str
    date: str
    procedure: str
    is_sound: bool | None
    keys: tuple[Key, ...]
    units: tuple[str, ...]
    values: Array
    expanded: Array
    degrees_of_freedom: Array
    covariance: Array
    is_bound: bool = False
    recordings: frozenset[str] = frozenset()
    has_device: bool = False
    has_station: bool = False
    files: Mapping[str, str] = field(default_factory=dict)
    changes: tuple[Mapping[str, Any], ...] = ()

    @property
    def file(self) -> tuple[str, str]:
        """Its file: name and SHA-256."""
        return self.name, self.sha256


@written(
    "compensation_matrix",
    """
    sensor
    unit: of a reading over its input, '1' where a nominal scale factor is known
    sensor_from_body (list[list[float]]) [unit]: S of reading = S input + bias, rows
      sensor axes
    body_from_sensor (list[list[float]]) [1/unit]: its inverse, input = S^-1 (reading -
      bias)
    bias (list[float]) [bias_unit]: of a reading
    bias_unit
    standard_uncertainty [unit]: of the elements of S; null of one that was held and not
      estimated
    bias_standard_uncertainty [bias_unit]: likewise
    triangle (list[list[float]]) [unit]: L of S = L R, lower triangular: scale factors,
      with their signs, and non-orthogonality
    rotation (list[list[float]]) [1]: R, orthogonal: how the triad stands in the body; a
      rotation, unless two axes are exchanged
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class CompensationMatrix(Documented):
    """Readings as a matrix times the input, and a bias; in printed units."""

    sensor: str
    unit: str
    sensor_from_body: Array
    body_from_sensor: Array
    bias: Array
    bias_unit: str
    standard_uncertainty: tuple[tuple[float | None, ...], ...]
    bias_standard_uncertainty: tuple[float | None, ...]
    triangle: Array
    rotation: Array

    @property
    def not_estimated(self) -> tuple[str, ...]:
        """What was held: of S by row and column, 'S xy', of the bias 'bias x'."""
        of_S = (
            f"S {AXES[i]}{AXES[j]}"
            for i, row in enumerate(self.standard_uncertainty)
            for j, u in enumerate(row)
            if u is None
        )
        biases = (
            f"bias {axis}"
            for axis, u in zip(AXES, self.bias_standard_uncertainty, strict=True)
            if u is None
        )
        return (*of_S, *biases)


@written(
    "run_window",
    """
    window: number of it in the procedure, from 1
    name
    sensor
    start [s]: since the first window began
    length [s]: of a rest that of the samples that its mean is of
    unit
    mean (list[float]) [unit]: of the readings, by axis
    residual (list[float]) [residual_unit]: reading over its scale factor less what was
      found; by the norm of gravity of its length
    residual_unit
    z? (list[float]) [1]: residual over its standard uncertainty, where a device says
      that
    gaps?: steps over more than one sample; this and what follows of recordings alone
    missing?: samples that the gaps leave out
    saturated? (list[int]): samples at the end of the range, by axis
    stuck? (list[int]): samples that are kept out of the mean, by axis
    outliers? (list[int]): likewise
    is_spoilt?: whether the mean is not that of the input: saturated samples, less than
      half of them left, or a turn that begins or ends in a gap
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class RunWindow(Documented):
    """One window of one triad; in printed units."""

    window: int
    name: str
    sensor: str
    start: float
    length: float
    unit: str
    mean: Array
    residual: Array
    residual_unit: str
    z: Array | None
    gaps: int | None = None
    missing: int | None = None
    saturated: tuple[int, ...] = ()
    stuck: tuple[int, ...] = ()
    outliers: tuple[int, ...] = ()
    is_spoilt: bool | None = None


@written(
    "run_turn",
    """
    first: number of the rest that it begins at, from 1
    last: that it ends at
    start [s]: since the first window began
    length [s]
    turned [deg]: on its way, by the calibrated gyro
    residual (list[float]) [arcsec]: down by the accelerometers less down by the gyro
      after it, in two directions across gravity
    z (list[float]) [1]: over its standard uncertainty
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class RunTurn(Documented):
    """A turn between two rests that a gyro is found by; in printed units."""

    first: int
    last: int
    start: float
    length: float
    turned: float
    residual: Array
    z: Array


@written(
    "run_chi_square",
    """
    sensor
    value
    degrees_of_freedom
    p [1]: probability that a sound run has one as large
    """,
)
@dataclass(frozen=True, kw_only=True)
class RunChiSquare(Documented):
    """A sum of squares against what it should be."""

    sensor: str
    value: float
    degrees_of_freedom: int
    p: float


@written(
    "mistake",
    """
    name: 'earth_rate_sign', 'window_face', ...
    sensor
    window?: of which, its number in the procedure
    windows?: that were exchanged
    face?: that it was at, as 'x up'
    azimuth? [deg]: that it was at
    axes?: that were exchanged, or reversed
    axis?: of a reading that is off
    factor? [1]: of readings over true ones
    value?: latitude [deg], gravity [m/s^2], or what a reading is off by [deg/h, ug]
    """,
)
@dataclass(frozen=True, kw_only=True)
class MistakeRow(Documented):
    """A mistake, and which one."""

    name: str
    sensor: str
    window: int | None = None
    windows: tuple[int, ...] = ()
    face: str = ""
    azimuth: float | None = None
    axes: str = ""
    axis: str = ""
    factor: float | None = None
    value: float | None = None

    @classmethod
    def of(cls, kind: str, mistake: Mistake) -> MistakeRow:
        """Return a mistake as a row; what a reading is off by in the unit of a bias."""
        what: dict[str, Any] = dict(mistake.what)
        if mistake.added is not None:
            what["value"] /= BIAS_UNITS[kind][1]
        return cls(name=mistake.name, sensor=kind, **what)


@written(
    "suspicion",
    """
    *mistake as mistake
    evidence: -2 ln L of a sound run less that with the mistake
    also: mistakes that it is not told from
    """,
)
@dataclass(frozen=True, kw_only=True)
class Suspicion(Documented):
    """A mistake that a triad's run looks like."""

    mistake: MistakeRow
    evidence: float
    also: tuple[MistakeRow, ...] = ()


@written(
    "unseen_mistake",
    """
    name
    sensor
    probability [1]: that a run with it is found not to be sound, at the nominal values
    windows: in which it may be missed; empty of one of the whole run
    """,
)
@dataclass(frozen=True, kw_only=True)
class UnseenMistake(Documented):
    """A mistake that this procedure and device may not show."""

    name: str
    sensor: str
    probability: float
    windows: tuple[int, ...] = ()


@written(
    "passed_over",
    """
    start [s]
    end [s]
    """,
)
@dataclass(frozen=True, kw_only=True)
class PassedOver(Documented):
    """A rest that is no window of the procedure, by the recording's clock."""

    start: float
    end: float


@written(
    "recorded_calibration",
    """
    title: name of the unit, else of the run
    serial: number of the unit; empty where nobody said it
    date: of the run, as it was given; empty where nobody said it
    environment: of each recording, when and in what it was made
    procedure: its name
    estimator: by which values were found
    station as line: what the figures of table, place and environment of the test rest
      on; empty: it names none, and they are taken as exact
    as_found: whose correction the unit came with; null: none was given, and errors as
      found are of the unit without correction against its nominal values
    coverage [1]: of the intervals
    inputs by role as file
    is_sound or null: whether chi-squares are as they should be, and no window is
      spoilt; null where of some triad nothing says it
    lower_bound = lacks (bool): whether lines that are not given would add to u
    outputs
    covariance (list[list[float]]) [units of the outputs]
    matrix by sensor as compensation_matrix
    windows
    turns as run_turn: that the gyro of a test by hand is found by; empty of any other
    chi_square: of what least squares leaves of the readings
    prior: of the readings against nominal values and tolerances
    looks_like
    worst (list[int]): windows that are farthest off, where no known mistake fits
    unseen: mistakes that this procedure and device may not show
    passed_over
    not_judged (list[str]): outputs that have a limit, and no value in its unit here
    assumptions
    warnings
    """,
    commands="calibrate",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class RecordedCalibration(Documented):
    """A unit as it was calibrated by a recorded run.

    Attributes
    ----------
    untold : tuple of str
        Triads whose soundness nothing tells.
    lacks : tuple of Name
        Lines that would add to uncertainties, and are not given.
    not_judged : tuple of Name
        Outputs that have a limit, and no value in its unit here.
    """

    title: str
    serial: str
    date: str
    environment: tuple[RecordedConditions, ...]
    procedure: str
    estimator: str
    station: tuple[ErrorLine, ...] = field(repr=False)
    as_found: CalibrationResult | None
    coverage: float
    inputs: tuple[InputFile, ...]
    outputs: tuple[CalibratedOutput, ...]
    covariance: tuple[tuple[float, ...], ...] = field(repr=False)
    matrix: tuple[CompensationMatrix, ...]
    windows: tuple[RunWindow, ...]
    turns: tuple[RunTurn, ...]
    chi_square: tuple[RunChiSquare, ...]
    prior: tuple[RunChiSquare, ...]
    looks_like: tuple[Suspicion, ...]
    worst: tuple[int, ...]
    unseen: tuple[UnseenMistake, ...]
    passed_over: tuple[PassedOver, ...]
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]
    least_p: float = 0.001
    untold: tuple[str, ...] = ()
    lacks: tuple[Name, ...] = ()
    not_judged: tuple[Name, ...] = ()

    @property
    def is_sound(self) -> bool | None:
        """Whether nothing is less likely than it may be; None where nothing says it.

        A window whose mean is not that of its input is a known mistake of the run.
        """
        found = (*self.chi_square, *self.prior)
        if self.spoilt or any(one.p < self.least_p for one in found):
            return False
        return True if found and not self.untold else None

    @property
    def failed_as_found(self) -> tuple[CalibratedOutput, ...]:
        """Outputs whose error as found is over their limit."""
        return tuple(x for x in self.outputs if x.found_standing == "fails")

    @property
    def spoilt(self) -> tuple[int, ...]:
        """Windows whose mean is not that of their input."""
        return tuple(sorted({one.window for one in self.windows if one.is_spoilt}))

    @property
    def is_open(self) -> bool:
        """Whether limits are not judged: of what is not found, or not known well."""
        is_open = any(one.left_standing == "undecided" for one in self.outputs)
        return (is_open or bool(self.not_judged)) and not self.missed

    @property
    def missed(self) -> tuple[CalibratedOutput, ...]:
        """Outputs whose uncertainty is over their limit."""
        return tuple(x for x in self.outputs if (x.utilisation or 0.0) > 1.0)
