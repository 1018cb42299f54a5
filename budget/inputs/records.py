"""Records of validated files: frozen, SI, no text left to interpret."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import sqrt
from typing import TYPE_CHECKING, Self

import numpy as np

from budget.distributions import ARCSINE
from budget.documents import Shown, written
from budget.errors import CallError
from budget.model.place import Place
from budget.model.source import Given
from budget.model.sources import ENVIRONMENT, PROCEDURE, STATION, lines_of
from budget.model.windows import Timing
from budget.names import ANGLES, AXES, Name
from budget.units import DEG_PER_HOUR, STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from pathlib import Path

    from budget.arrays import Array
    from budget.inputs.changes import Changed, Changes
    from budget.model.windows import Window
    from budget.navigation.route import Route

__all__ = ["ANGLES", "AXES"]

CHANGED = ", changed"  # after the name of a device of which a call changed a value


@written(
    "line",
    """
    line = name
    printed: as the file gives it
    meaning: how its number is meant, '1 sigma', 'max', ...
    unit: as the file gives it
    standard_uncertainty = u / si_per_unit (list[float]) [unit]: by axis
    correlation_time (list[float] | None) [s]: by axis; null of what has none
    distributions = distributions.name (list[str]): shapes by axis
    degrees_of_freedom (list[float | None]) [1]: of all, or by axis; null: known
    includes: what it covers, in the words of the maker
    horizon: after which time
    definition: of the maker
    condition: under which it applies
    source: where it is printed
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class ErrorLine(Given):
    """One specification value that an error model uses, and how the file prints it.

    Attributes
    ----------
    printed : str
        The value as the file gives it, for people: '0.04 deg/h' or
        'x 0.02 deg/h, y 0.03 deg/h, z 0.02 deg/h'.
    unit : str
        Its unit as the file gives it (of the first axis).
    si_per_unit : float
        u of one of that unit [SI]: the size of the unit, of a one-sided density that
        over sqrt(2). So u / si_per_unit is in the maker's own terms.
    meaning : str
        '1 sigma', 'max', ... as the file gives it or by default.
    density : str
        Of a random walk per root of hertz 'one-sided' or 'two-sided', else ''.
    adds_to : str
        The random walk that a noise of every sample is no part of; '' if not said.
    factor : float
        u over the value that is printed, beside its meaning [SI], where the model has
        another quantity than the maker.
    reading : float
        The part of it that is how the number is read, not a unit [1].
    says : tuple of (str, str)
        What else the file says of it that moves its numbers, as (key, text).
    definition, includes, horizon, condition, source : str
        The maker's own words; '' where not given.
    readings : tuple of (str, ErrorLine)
        What the value may mean, where that is open, and the line that it is then; this
        one is the largest of them.
    """

    printed: str
    unit: str
    si_per_unit: float
    meaning: str = "1 sigma"
    density: str = ""
    adds_to: str = ""
    factor: float = 1.0
    reading: float = 1.0
    says: tuple[tuple[str, str], ...] = ()
    definition: str = ""
    includes: str = ""
    horizon: str = ""
    condition: str = ""
    source: str = ""
    readings: tuple[tuple[str, ErrorLine], ...] = ()


@written(
    "unused_value",
    """
    name
    value: as the file gives it
    condition: under which it applies
    meaning: how its number is meant
    source: where it is printed
    """,
)
@dataclass(frozen=True, kw_only=True)
class UnusedValue:
    """A value that the maker prints and no model uses: shown, not budgeted."""

    name: str
    value: str
    condition: str = ""
    meaning: str = ""
    source: str = ""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredParameters:
    """What a recorded calibration of one unit leaves of its parameters.

    Attributes
    ----------
    names : tuple of Name
        Parameters of all its triads.
    covariance : ndarray, shape (n, n)
        Of what noise, table and place of that run left, without what constants of the
        unit put into the test, which its lines have [SI squared].
    degrees_of_freedom : ndarray, shape (n,)
        [1]; inf where it is known.
    noise : frozenset of Name or None
        Lines of noise that are among it; None: all there are, as by a scatter.
    has_station : bool
        Whether errors of table and place are among it; else those of the procedure
        come on top.
    file, sha256, serial, date, procedure : str
        Of the result; '' where it does not say.
    is_told : bool
        Whether the run is known to have been sound.
    is_bound : bool
        Whether its covariance is a lower bound: its data sheet lacks lines.
    """

    names: tuple[Name, ...]
    covariance: Array
    degrees_of_freedom: Array
    noise: frozenset[Name] | None
    has_station: bool
    file: str
    sha256: str
    serial: str
    date: str
    procedure: str
    is_told: bool
    is_bound: bool


@written(
    "sensor",
    """
    sensor = kind: 'gyro' or 'accelerometer'
    lines as line
    not_given: lines of the model that are absent
    expected_missing: those of them that a verdict 'meets' cannot do without
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Sensor:
    """One triad of a device: its nominal values and the lines of its data sheet.

    Attributes
    ----------
    kind : str
        'gyro' or 'accelerometer'.
    device : str
        Name of the device it belongs to, with the variant.
    nominal_bias : ndarray, shape (3,)
        [rad/s] or [m/s^2].
    nominal_mounting_angle : ndarray, shape (6,)
        In the order of ANGLES [rad].
    lines : tuple of ErrorLine
        What is given, in the order of the model lines.
    not_given : tuple of str
        Model lines that are absent, 'gyro.rate_random_walk'.
    expected_missing : tuple of str
        Those of them that a verdict 'meets' cannot do without; 'gyro.noise' stands
        for the one noise line.
    gravity_unit : float
        What g means in values of the device [m/s^2].
    beside : Sensor or None
        Of a gyro: the accelerometers of the same unit.
    initial : tuple of ErrorLine
        Tolerances of a new unit, that every calibration finds; they count for what is
        held at the design.
    range : ndarray, shape (3,), or None
        The largest input of either sign that each axis reads [rad/s or m/s^2]; None
        where it is not given.
    range_printed : str
        As the file gives it, for people: '±400 °/s (saturates at ±480 °/s)'.
    measured : MeasuredParameters or None
        What stands for the predicted uncertainty of a calibration of this one unit.
    """

    kind: str
    device: str
    nominal_bias: Array
    nominal_mounting_angle: Array
    lines: tuple[ErrorLine, ...]
    not_given: tuple[Name, ...]
    expected_missing: tuple[Name, ...]
    gravity_unit: float = STANDARD_GRAVITY
    beside: Sensor | None = None
    initial: tuple[ErrorLine, ...] = ()
    range: Array | None = None
    range_printed: str = ""
    measured: MeasuredParameters | None = None

    @classmethod
    def bare(cls, kind: str) -> Self:
        """Return a triad of which nothing is known: nominal, without lines."""
        return cls(
            kind=kind,
            device="",
            nominal_bias=np.zeros(3),
            nominal_mounting_angle=np.zeros(6),
            lines=(),
            not_given=(),
            expected_missing=(),
        )

    def line(self, name: str) -> ErrorLine | None:
        """Return the line of that name, or None where the data sheet has none."""
        every = (*self.lines, *self.initial)
        return next((line for line in every if line.name == name), None)

    def with_lines(self, lines: Iterable[ErrorLine]) -> Sensor:
        """Return the sensor with these lines, in their order, and what it then lacks.

        Of lines for one thing the second is no gap where the first is given. What a new
        unit has stays as it is where none of these says it.
        """
        known = [line for line in lines_of(self.kind) if not line.is_initial]
        at_first = [line for line in lines_of(self.kind) if line.is_initial]
        given = {line.name: line for line in lines}
        initial = tuple(given[one.name] for one in at_first if one.name in given)
        met = {line.expected for line in known if line.name in given} - {""}
        expected = dict.fromkeys(line.expected for line in known if line.expected)
        return replace(
            self,
            lines=tuple(given[line.name] for line in known if line.name in given),
            initial=initial or self.initial,
            not_given=tuple(
                Name(line.name, owner=self.kind)
                for line in known
                if line.varies and line.name not in given and line.expected not in met
            ),
            expected_missing=tuple(
                Name(name, owner=self.kind) for name in expected if name not in met
            ),
        )


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Where a record came from."""

    file: str  # base name, with #VARIANT where one was chosen
    sha256: str  # of the file's bytes
    changes: tuple[Changed, ...] = ()  # that were laid over it

    @property
    def used(self) -> tuple[str, ...]:
        """The changes as they were given."""
        return tuple(text for one in self.changes for text in one.texts)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Device(Shown):
    """One device file, one variant of it.

    Texts that say what it is and costs move no number; they are '' where not given.
    """

    name: str
    gyro: Sensor | None
    accelerometer: Sensor | None
    figures: tuple[UnusedValue, ...]
    assumptions: tuple[str, ...]
    origin: Origin
    source: str = ""
    vendor: str = ""
    technology: str = ""
    price: str = ""
    mass: str = ""
    power: str = ""
    notes: str = ""
    # Reads the same file again with changes, where it was read from one.
    read_again: Callable[[Changes], Device] | None = field(default=None, repr=False)
    # Reads it without any.
    read_plain: Callable[[], Device] | None = field(default=None, repr=False)

    def replace(self, changes: Changes) -> Device:
        """Return what the same file gives with other values, each of them named.

        Parameters
        ----------
        changes : mapping, or sequence of str
            {'gyro.bias_stability': '0.02 deg/h'}, as of `load_device`; they count
            after those that the device has already.

        Raises
        ------
        SpecError
            A value is none of that line.
        CallError
            There is no such line or sensor, or the device is of no file.
        """
        if self.read_again is None:
            raise CallError(
                f"{self.name} was read from no file, so what it is changed from cannot "
                "be named; make it with budget.load_device"
            )
        return self.read_again(changes)

    @property
    def range(self) -> str:
        """The ranges of its triads, for people; '' where none is given."""
        return "; ".join(
            f"{one.kind} {one.range_printed}"
            for one in (self.gyro, self.accelerometer)
            if one is not None and one.range_printed
        )

    @property
    def measured(self) -> MeasuredParameters | None:
        """What was measured of this one unit; None of a data sheet."""
        return next((one.measured for one in self.sensors if one.measured), None)

    @property
    def as_printed(self) -> str:
        """Its name without the mark of what a call changed: the same data sheet."""
        return self.name.removesuffix(CHANGED)

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The triads that are there, gyro first, which knows those beside it."""
        gyro, beside = self.gyro, self.accelerometer
        if gyro is not None and beside is not None:
            gyro = replace(gyro, beside=beside)
        return tuple(s for s in (gyro, beside) if s is not None)


@dataclass(frozen=True, kw_only=True, eq=False)
class Station:
    """What is not known of a table, its place, its timing, and of the environment."""

    name: str
    station: tuple[ErrorLine, ...]
    environment: tuple[ErrorLine, ...]
    timing: Timing
    assumptions: tuple[str, ...]
    origin: Origin


@dataclass(frozen=True, kw_only=True)
class GyroProcedure:
    """Rate turns, then a static test at several azimuths, or in twelve positions."""

    rate: float  # [rad/s]
    turns: int
    order: tuple[str, ...]  # axes in the order they are turned about
    pause: float  # between all windows [s]
    azimuths: tuple[float, ...]  # [rad]; () where the bias is of twelve positions
    dwell: float  # at each azimuth [s]


@dataclass(frozen=True, kw_only=True)
class AccelerometerProcedure:
    """The twelve-position static test."""

    dwell: float  # at each position [s]
    pause: float  # between all windows [s]
    flip_axis: str = "inner"  # that z comes down by


# In place of formulas, of a unit that nobody calibrates: as made, as it is sold.
NONE, FACTORY = "none", "factory"
UNCALIBRATED = (NONE, FACTORY)


@dataclass(frozen=True, kw_only=True)
class Procedure:
    """Where and how the calibration is done; or that none is."""

    name: str
    latitude: float  # [rad]
    gravity: float  # at the place [m/s^2]
    sample_rate: float  # [Hz]
    formulas: str  # 'corrected', 'paper', 'least_squares', ...; UNCALIBRATED
    gyro: GyroProcedure
    accelerometer: AccelerometerProcedure
    assumptions: tuple[str, ...]
    origin: Origin
    station: tuple[ErrorLine, ...] = ()
    environment: tuple[ErrorLine, ...] = ()
    windows: tuple[Window, ...] = ()  # in place of the tests of gyro and accelerometer
    held: tuple[Name, ...] = ()  # parameters that are not estimated, 'gyro.bias.x'
    orders: tuple[int, ...] = ()  # of accelerometers, that are estimated besides: 2, 3
    height: float = 0.0  # above the ellipsoid, where gravity is the normal one [m]
    is_gravity_normal: bool = False
    timing: Timing = field(default_factory=Timing)
    station_origin: Origin | None = None  # where the station has a file of its own
    azimuth: str = ""  # UNKNOWN, ZERO_UNKNOWN; '' where azimuths are from north

    @property
    def place(self) -> Place:
        """What the test takes the place for."""
        return Place(
            latitude=self.latitude,
            gravity=self.gravity,
            height=self.height,
            is_normal=self.is_gravity_normal,
            azimuth=None if self.azimuth else 0.0,
        )

    @cached_property
    def shared(self) -> Mapping[str, tuple[ErrorLine, ...]]:
        """Lines that all triads share, by owner: of the procedure what it leaves open.

        Each part of the horizontal earth rate has w cos(latitude)/sqrt(2), arcsine.
        """
        own: tuple[ErrorLine, ...] = ()
        if self.azimuth:
            u = self.place.horizontal / sqrt(2.0)
            line = ErrorLine(
                name="heading",
                u=np.array([u]),
                distributions=(ARCSINE,),
                form=self.azimuth,
                printed=f"{u / DEG_PER_HOUR:.4g} deg/h",
                unit="deg/h",
                si_per_unit=DEG_PER_HOUR,
            )
            own = (line,)
        return {STATION: self.station, ENVIRONMENT: self.environment, PROCEDURE: own}


_ROUNDING = 1e-9  # of a time, relative


def joined(spans: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Return spans, as they rise, of which none begins before another ends."""
    found: list[tuple[float, float]] = []
    for begin, end in spans:
        if found and begin <= found[-1][1] * (1.0 + _ROUNDING):
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((begin, end))
    return tuple(found)


@dataclass(frozen=True, kw_only=True)
class Aiding:
    """What is measured of a vehicle besides, and when."""

    name: str  # 'gnss_position', 'gnss_velocity', 'heading', ...
    u: tuple[float, ...]  # white by epoch: north, east and down, or one [SI]
    rate: float  # [Hz]
    spans: tuple[tuple[float, float], ...]  # begins and ends of when it is there [s]
    drift: tuple[float, ...] = ()  # sizes of an error that fades; () without [SI]
    correlation_time: float = 0.0  # of that [s]


@dataclass(frozen=True, kw_only=True)
class Believed:
    """A line that a filter believes otherwise."""

    line: Name  # of a triad, or of the aids
    value: float  # 1 sigma [SI]
    printed: str
    axis: str = ""  # '' of all
    is_time: bool = False  # whether it is the correlation time of the line


@dataclass(frozen=True, kw_only=True)
class OwnFilter:
    """A filter that has not all states, or does not believe what is true."""

    estimates: tuple[Name, ...] | None  # 'gyro.bias', ...; None: all
    believes: tuple[Believed, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Mission:
    """Where a calibrated unit goes by itself, and what it knows when it begins."""

    name: str
    route: Route
    alignment: float  # how long it finds level and north by itself [s]; 0: it knows
    aided: bool  # whether height and vertical velocity are known all the time
    at: tuple[float, ...]  # times that are asked for, rising [s]
    assumptions: tuple[str, ...]
    origin: Origin
    trajectory: Origin | None = None  # where the route was recorded
    use: tuple[ErrorLine, ...] = ()  # environment and age that it states
    doubts: tuple[str, ...] = ()  # what in its recording looks like a slip
    # Errors of position, velocity and attitude when it begins, north, east, down, that
    # are known to this only [SI]; those of the route's first moment.
    start: tuple[float, ...] = (0.0,) * 9
    aiding: tuple[Aiding, ...] = ()
    filter: OwnFilter | None = None  # None: the one that believes what is true

    @property
    def is_filtered(self) -> bool:
        """Whether more is in it than a unit that navigates by itself."""
        return bool(self.aiding) or any(self.start)

    @property
    def measured(self) -> tuple[tuple[float, float], ...]:
        """Begins and ends of when any aid is there, rising and apart [s]."""
        return joined(sorted(span for aid in self.aiding for span in aid.spans))


EACH, JOINT = "each", "joint"


@dataclass(frozen=True, kw_only=True)
class Limit:
    """The largest absolute error allowed for one output."""

    output: Name
    limit: float  # [SI]
    printed: str
    coverage: float | None = None  # of its interval; None: the requirement's [1]


@dataclass(frozen=True, kw_only=True)
class Requirement:
    """What a calibrated system must hold."""

    name: str
    coverage: float  # [1]
    reference: str  # 'nominal', 'as_tested' or 'next_turn_on'
    limits: tuple[Limit, ...]
    caps: tuple[tuple[str, str], ...]  # ('price', '50000 EUR'), ...
    assumptions: tuple[str, ...]
    origin: Origin
    use: tuple[ErrorLine, ...] = ()  # environment and age that it states
    decision: str = EACH  # every limit alone, or JOINT: all together

    def coverage_of(self, limit: Limit) -> float:
        """Return the coverage at which a limit is judged [1]."""
        return self.coverage if limit.coverage is None else limit.coverage

    @property
    def outputs(self) -> tuple[Name, ...]:
        """What has a limit, in the order of the outputs."""
        return tuple(limit.output for limit in self.limits)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of sensor that have limits, in their order."""
        return tuple(dict.fromkeys(name.owner for name in self.outputs))


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What it costs to make one line better: a (u_ref / u)^p."""

    source: Name  # 'gyro.bias_stability'
    a: float  # cost at u_ref [1]
    p: float  # [1]
    u_ref: float | None  # [SI]; None: the value the device has now


@dataclass(frozen=True, kw_only=True)
class Costs:
    """Costs of the lines that a file names; the others have a = p = 1."""

    costs: tuple[Cost, ...]
    assumptions: tuple[str, ...]
    origin: Origin


@dataclass(frozen=True, kw_only=True)
class RunConditions:
    """What the environment of a run was, as its file says: it moves no number."""

    temperature: float | None = None  # [degC]
    humidity: float | None = None  # relative [1]
    pressure: float | None = None  # [Pa]
    text: str = ""


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Files of recorded readings, and what is said of their columns.

    Attributes
    ----------
    name : str
        Of the file that stands for it.
    files : tuple of (Path, str)
        As they are found, and as messages name them.
    rate : float, optional
        Of sampling [Hz]; None: that of the stamps.
    columns : tuple of str
        Heads in the place of those of the files; () these.
    gain : mapping of str to float
        By sensor, counts per rad/s or m/s^2; results are in counts without it.
    increments : bool
        Whether the readings are steps of angle and velocity.
    saturation : mapping of str to float
        By sensor, reading at the end of the range [SI].
    counter : (str, int), optional
        Head of a counter of samples, and from where it begins again.
    date : str
        Day of the run, 'YYYY-MM-DD'; '' where it does not say it.
    environment : RunConditions, optional
        Likewise.
    """

    name: str
    files: tuple[tuple[Path, str], ...]
    rate: float | None = None
    columns: tuple[str, ...] = ()
    gain: Mapping[str, float] = field(default_factory=dict)
    increments: bool = False
    saturation: Mapping[str, float] = field(default_factory=dict)
    counter: tuple[str, int] | None = None
    date: str = ""
    environment: RunConditions | None = None
    assumptions: tuple[str, ...] = ()
    origin: Origin | None = None


@dataclass(frozen=True, kw_only=True)
class Checked:
    """What is said of a file in which nothing is wrong."""

    file: str  # as the user gave it
    kind: str  # as `budget schema` takes it
    variants: tuple[str, ...]  # of a device, '' for its base; () of the others
    assumptions: tuple[str, ...]  # of the base and every variant, each once
    ranges: tuple[str, ...] = ()  # of its sensors, likewise
    # The base and every variant, of a device file.
    devices: tuple[Device, ...] = field(default=(), repr=False)
    changes: tuple[str, ...] = ()  # those of the call that it has
