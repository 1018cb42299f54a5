"""Calibration as one Problem: error = estimate(measure(truth)) - error reference.

Sources of all owners are its inputs. Each triad's truth is its nominal values and its
Offsets; its window averages hold the truth, the noise and what disturbances add; the
scheme's weights make statistics of them, from which the parameters are read. So a
source that both triads share is drawn once and felt by both.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache, reduce
from operator import add
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.derived import combination, parts_of
from budget.calibration.schemes import (
    answered,
    estimated,
    initial_lines,
    schemes_of,
    with_accelerometers,
)
from budget.distributions import NORMAL
from budget.earth import ROTATION_RATE
from budget.errors import CallError
from budget.model.response import STATISTICS, Truth
from budget.model.rotation import RotationScheme
from budget.model.source import (
    SENSORS,
    SHARED,
    TURN_ON,
    Coefficient,
    Disturbance,
    Initial,
    Noise,
    Nonlinearity,
    Offset,
    Statistics,
    Triad,
    TurnOnChange,
)
from budget.model.sources import source_of
from budget.model.sources.outside import watched
from budget.model.sources.temperature import TemperatureChange
from budget.names import IMU, ORDERS, Name, every_output
from budget.problem import CommonScale, Group, Output, Problem, arguments
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, PPM, STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import MeasuredParameters, Procedure, Sensor
    from budget.model.response import Errors
    from budget.model.scheme import Scheme
    from budget.model.source import Act, Gains, Given, Source
    from budget.problem import Function

MEASURED = Name("result", owner="calibration")  # what was measured of a unit
REFERENCES = ("nominal", "as_tested", "next_turn_on")
BIAS_UNITS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}

FRAMES = 512  # structures of devices: hundreds of designs have as many
MOST_INPUTS = 1000  # of one source: turns, stops; all second derivatives are carried
# Spread below this part of a parameter's natural size is rounding of doubles: of a
# scale factor 1, of an angle 1 rad, of a bias the input it is measured beside.
ROUNDING = 1e-14  # [1]


def calibration_problem(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    reference: str = "nominal",
    only: frozenset[str] | None = None,
    outputs: Sequence[Name] | None = None,
    every: bool = False,
) -> Problem:
    """Set up the calibration of one or two triads.

    Parameters
    ----------
    sensors : tuple of Sensor
        At most one gyro and one accelerometer.
    procedure : Procedure
        Windows, the place, the formulas, station and environment.
    reference : str
        What errors are counted from: 'nominal', 'as_tested', 'next_turn_on'.
    only : frozenset of str, optional
        Full names of the sources that count; all others are set to 0.
    outputs : sequence of Name, optional
        What is asked for, of budget.calibration.derived.known_outputs; all parameters
        that are estimated, and nothing derived from them, without it.
    every : bool
        Whether parameters that are held are outputs too, each in its place among those
        of its triad, and triads that the procedure does not calibrate at all. Only then
        does what a unit has from its making count: alone, a calibration is right about
        the axes and values that it holds, which others are counted from.

    Returns
    -------
    Problem
        Sources as groups, an output for each parameter estimated: its error, calibrated
        value minus reference [1, rad, rad/s, m/s^2]; of what is derived likewise. Of a
        parameter that is held the value of the design is the calibrated one.

    Raises
    ------
    CallError
        A line is no error source that the program knows.
    """
    structure = _structure(
        sensors, procedure, reference=reference, outputs=outputs, every=every
    )
    frame = _frame(structure)
    # Of a structure that is new they were made for its frame.
    made = vars(structure).pop("made", None)
    members = made if made and only is None else None
    members = members or structure.members(frame.statistics, only=only)
    measured = next((one.measured for one in sensors if one.measured), None)
    if measured is not None and measured.procedure == procedure.name:
        return _of_unit(measured, members, frame, only)
    return Problem(
        groups=tuple(group for _, group in members),
        outputs=frame.outputs,
        function=frame.function,
    )


def is_by_readings(owner: str, given: Given, *, has_station: bool) -> bool:
    """Whether a source acts by the readings of the test alone, so that it is measured.

    Noise does, and with `has_station` disturbances from outside the unit.
    """
    effect = source_of(owner, given.name).meant(given).effect
    is_outside = isinstance(effect, Disturbance) and owner not in SENSORS
    return isinstance(effect, Noise) or (has_station and is_outside)


def _is_replaced(row: _Row, measured: MeasuredParameters) -> bool:
    """Whether what was measured stands for a source: not for one it knew nothing of."""
    known = measured.noise
    if known is not None and row.owner in SENSORS:
        return Name(row.given.name, owner=row.owner) in known
    return is_by_readings(row.owner, row.given, has_station=measured.has_station)


def _of_unit(
    measured: MeasuredParameters,
    members: Sequence[tuple[_Row, Group]],
    frame: _Frame,
    only: frozenset[str] | None,
) -> Problem:
    """Return a Problem whose noise and table are what was measured of one unit."""
    groups = [
        replace(group, covariance=np.zeros_like(group.covariance), scales=())
        if _is_replaced(row, measured)
        else group
        for row, group in members
    ]
    nu = measured.degrees_of_freedom
    n = len(measured.names)
    counts = only is None or MEASURED in only
    own = Group(
        name=MEASURED,
        mean=np.zeros(n),
        covariance=measured.covariance * counts,
        distributions=(NORMAL,) * n,
        scales=tuple(
            CommonScale(degrees_of_freedom=v, rows=tuple(np.flatnonzero(nu == v)))
            for v in sorted({*nu[np.isfinite(nu)].tolist()})
        ),
    )
    places = {name: place for place, name in enumerate(measured.names)}
    shares = np.zeros((len(frame.outputs), n))
    for row, output in enumerate(frame.outputs):
        for part, factor in parts_of(output.name).items():
            if part in places:
                shares[row, places[part]] = factor
    return Problem(
        groups=(*groups, own),
        outputs=frame.outputs,
        function=OfUnit(
            predicted=frame.function,
            rows=arguments((*groups, own))[-1],
            shares=shares,
        ),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class OfUnit:
    """Errors by what is predicted, and those that were measured.

    Attributes
    ----------
    predicted : callable
        Of the rows before.
    rows : slice
        Of the argument, that are errors of parameters.
    shares : ndarray, shape (n_outputs, n_rows)
        What each output takes of them [1].
    """

    predicted: Function
    rows: slice
    shares: Array

    def __call__(self, argument: Array) -> Array:
        """Return all outputs, shape (n_outputs, trials) [SI]."""
        found = self.predicted(argument[: self.rows.start])
        return np.asarray(found + self.shares @ argument[self.rows])


def retimed(
    problem: Problem,
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    every: bool = False,
) -> Problem:
    """Return a Problem with the noise of windows of other lengths, all else as it is.

    `problem` is of a calibration of these triads, or of what follows from it; see
    `calibration_problem`.
    """
    of = _structure(sensors, procedure, every=every)
    triads = of.triads(_statistics_of(of))
    found = {
        Name(row.given.name, owner=row.owner): _noise_covariance(
            row.source.effect,
            row.given,
            triads[row.owner],
            procedure.sample_rate,
            included=True,
        )
        for row in of.rows
        if isinstance(row.source.effect, Noise)
    }

    def changed(group: Group) -> Group:
        own = found.get(group.name)
        if own is None:
            return group
        covariance = group.covariance.copy()
        covariance[: len(own), : len(own)] = own
        return replace(group, covariance=covariance)

    return replace(problem, groups=tuple(map(changed, problem.groups)))


def _structure(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    reference: str = "nominal",
    outputs: Sequence[Name] | None = None,
    every: bool = False,
) -> _Structure:
    """Return what is asked of a device; see `calibration_problem`."""
    there = with_accelerometers(sensors, procedure)
    rows = [
        *(
            _Row.of(sensor.kind, line)
            for sensor in there
            for line in (
                *sensor.lines,
                *(initial_lines(sensor, procedure) if every else ()),
            )
        ),
        *(
            _Row.of(owner, line)
            for owner, lines in procedure.shared.items()
            for line in lines
        ),
    ]
    schemes = schemes_of(there, procedure, every=every)
    # What a line of another package takes of the others nobody knows.
    is_whole = any(row.source.origin for row in rows)
    return _Structure(
        key=(
            procedure,
            *(reference, every, outputs and tuple(outputs), len(sensors)),
            *((one.kind, id(schemes[one.kind]), *_design(one)) for one in there),
            *(
                row.structure(is_felt=bool(procedure.environment), is_whole=is_whole)
                for row in rows
                if row.owner in SENSORS
            ),
        ),
        sensors=sensors,
        there=there,
        procedure=procedure,
        rows=rows,
        schemes=schemes,
        reference=reference,
        outputs=outputs,
        every=every,
    )


def _statistics_of(of: _Structure) -> dict[str, Statistics]:
    """Return what each triad needs of its noise."""
    return {
        one.kind: _statistics(one, of.schemes[one.kind], of.rows) for one in of.there
    }


@dataclass(frozen=True, kw_only=True)
class _Structure:
    """What is asked of a device; devices that differ in sizes alone have one key.

    Attributes
    ----------
    key : tuple
        Of two that are equal all is the same but the groups of the Problem.
    sensors, there : tuple of Sensor
        Those that outputs are of, and all triads.
    schemes : mapping of str to Scheme
        Windows and weights of each triad; a key names them by where they are.
    """

    key: tuple[object, ...]
    sensors: tuple[Sensor, ...] = field(compare=False)
    there: tuple[Sensor, ...] = field(compare=False)
    procedure: Procedure = field(compare=False)
    rows: Sequence[_Row] = field(compare=False)
    schemes: Mapping[str, Scheme] = field(compare=False)
    reference: str = field(compare=False)
    outputs: Sequence[Name] | None = field(compare=False)
    every: bool = field(compare=False)

    def triads(self, statistics: Mapping[str, Statistics]) -> dict[str, Triad]:
        """Return its triads: scheme, lines, what each needs of its noise."""
        return {
            one.kind: Triad(
                scheme=self.schemes[one.kind],
                given={
                    line.name: line
                    for line in (*self.procedure.environment, *one.lines)
                },
                statistics=statistics[one.kind],
            )
            for one in self.there
        }

    def members(
        self, statistics: Mapping[str, Statistics], *, only: frozenset[str] | None
    ) -> list[tuple[_Row, Group]]:
        """Return the lines that are inputs, each with its group."""
        triads = self.triads(statistics)
        return [
            (row, row.group(triads, self.procedure, self.reference, only=only))
            for row in self.rows
            if row.is_input(triads)
        ]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Frame:
    """What devices of one structure share: all of a Problem but its groups."""

    statistics: Mapping[str, Statistics]
    outputs: tuple[Output, ...]
    function: Function


@lru_cache(maxsize=FRAMES)
def _frame(of: _Structure) -> _Frame:
    """Set up the function and the outputs of a structure."""
    statistics = _statistics_of(of)
    triads = tuple(of.triads(statistics).values())
    members = vars(of)["made"] = of.members(statistics, only=None)
    groups = tuple(group for _, group in members)
    places = tuple(
        (row, place) for (row, _), place in zip(members, arguments(groups), strict=True)
    )
    known = answered if of.every else estimated
    names = [name for sensor in of.sensors for name in known(sensor.kind, of.procedure)]
    made = _outputs_of(of.sensors, of.procedure)
    problem = Problem(
        groups=groups,
        outputs=tuple(made[name] for name in names),
        function=Calibration(
            triads=tuple(
                _calibration(
                    sensor, triads, number, places, of.reference, every=of.every
                )
                for number, sensor in enumerate(of.there)
            ),
            kinds=tuple(sensor.kind for sensor in of.sensors),
        ),
    )
    if of.outputs is not None:
        outputs = [made[name] for name in of.outputs]
        problem = problem.then(combination(names, of.outputs), outputs)
    return _Frame(
        statistics=statistics, outputs=problem.outputs, function=problem.function
    )


def _design(sensor: Sensor) -> tuple[bytes, bytes]:
    """Return the values of the design that a test starts from, as a key."""
    return sensor.nominal_bias.tobytes(), sensor.nominal_mounting_angle.tobytes()


@dataclass(frozen=True, kw_only=True, eq=False)
class _Row:
    """One line of a file with the source that it means."""

    owner: str
    given: Given
    source: Source

    @classmethod
    def of(cls, owner: str, given: Given) -> _Row:
        """Find the source; an unknown one is an error."""
        source = source_of(owner, given.name).meant(given)
        return cls(owner=owner, given=given, source=source)

    def structure(self, *, is_felt: bool, is_whole: bool) -> tuple[object, ...]:
        """Return what the function takes of it: a size where coefficients are felt.

        All of its values, where any may be taken.
        """
        given, effect = self.given, self.source.effect
        if is_whole:
            more = (given.u, given.correlation_time, given.low_cut, given.points)
            values = (None if one is None else one.tobytes() for one in more)
            own = tuple(sorted(given.own.items()))
            return self.owner, given.name, given.form, given.horizons, own, *values
        size = given.u.tobytes() if is_felt and isinstance(effect, Coefficient) else b""
        is_there = bool(given.u.any())
        key = (self.owner, given.name, given.form, given.u.size, is_there)
        return *key, size, given.horizons

    def is_input(self, triads: Mapping[str, Triad]) -> bool:
        """Whether it varies, and there is anything that it may reach.

        A coefficient is fixed; what disturbs a test disturbs none where nothing is
        tested.
        """
        effect = self.source.effect
        if isinstance(effect, Disturbance) and self.owner not in SENSORS:
            return any(_is_tested(triad) for triad in triads.values())
        if isinstance(effect, TemperatureChange) and not self.given.u.any():
            return False  # stated, and none
        return self.source.varies

    def acts_on(self, kind: str) -> bool:
        """Whether it can reach a triad: its own, or all from outside the sensors."""
        return self.owner in {kind, *SHARED}

    def act_on(self, triad: Triad, effect: Disturbance) -> Act | None:
        """Return what it does to a triad under test; None: nothing."""
        is_felt = self.given.u.any() and _is_tested(triad)
        act = effect.bind(self.given, triad) if is_felt else None
        return watched(act, self.source) if act and self.source.origin else act

    def group(
        self,
        triads: Mapping[str, Triad],
        procedure: Procedure,
        reference: str,
        *,
        only: frozenset[str] | None,
    ) -> Group:
        """Make the inputs of the source: constants, or statistics of a process."""
        name = Name(self.given.name, owner=self.owner)
        included = only is None or name in only
        effect, given = self.source.effect, self.given
        if isinstance(effect, Noise):
            covariance = _noise_covariance(
                effect,
                given,
                triads[self.owner],
                procedure.sample_rate,
                included=included,
            )
            n = len(covariance)
            return Group.known(
                name=name,
                mean=np.zeros(n),
                covariance=covariance,
                distributions=(NORMAL,) * n,
                pool=f"{self.owner}.noise",
                scales=scales_of(self.owner, given, n),
            )
        times = 1 + (reference == "next_turn_on" and self.is_new)
        if isinstance(effect, Disturbance):
            joint = effect.covariance(given, tuple(triads.values()))
            if joint is not None:
                n = len(joint)
                return Group(
                    name=name,
                    mean=np.zeros(n),
                    covariance=joint * included,
                    distributions=(NORMAL,) * n,
                    scales=scales_of(self.owner, given, n),
                )
            own = triads.get(self.owner) or next(filter(_is_tested, triads.values()))
            times = effect.size(given, own.scheme) // given.u.size
            if times > MOST_INPUTS:
                raise CallError(
                    f"{name}: this calibration has {times} independent values of it, "
                    f"{MOST_INPUTS} at the most can be propagated; leave it out, or "
                    "give one with fewer windows"
                )
        found = Group.independent(
            name,
            u=np.tile(given.u * included, times),
            distribution=given.distributions * times,
        )
        scales = scales_of(self.owner, given, found.size)
        return replace(found, scales=scales) if scales else found

    @property
    def is_new(self) -> bool:
        """Whether a later turn-on draws it anew."""
        return isinstance(self.source.effect, Offset) and self.source.stays == TURN_ON


def _noise_covariance(
    effect: Noise, given: Given, triad: Triad, sample_rate: float, *, included: bool
) -> Array:
    """Return the covariance of the statistics of a process, correlated within an axis.

    Axis after axis those of W, then axis after axis the others, so that a disturbance
    that needs more of them moves no draws of the first.
    """
    order = _statistics_order(triad.statistics.weights.shape[1])
    covariance = np.zeros((order.size, order.size))
    for axis in range(3 if included and _is_tested(triad) else 0):
        covariance[np.ix_(order[axis], order[axis])] = triad.statistics.covariance(
            effect.process(given, axis, sample_rate), axis, triad.scheme.schedule
        )
    return covariance


def scales_of(owner: str, given: Given, size: int) -> tuple[CommonScale, ...]:
    """Return what few readings leave open of so many inputs of a line.

    One figure of all axes is off as a whole. Of inputs that no one axis has it is that
    of the axis with the fewest readings.
    """
    every = given.degrees_of_freedom
    few = [v for v in every if v is not None]
    if not few:
        return ()
    axes = axes_of_inputs(owner, given, size)
    if len(every) == 1 or axes is None:
        return (CommonScale(degrees_of_freedom=min(few), rows=tuple(range(size))),)
    return tuple(
        CommonScale(
            degrees_of_freedom=v, rows=tuple(np.flatnonzero(axes == axis).tolist())
        )
        for axis, v in enumerate(every)
        if v is not None
    )


def axes_of_inputs(owner: str, line: Given, n: int) -> NDArray[np.intp] | None:
    """Return the axis of the line that each of n inputs is of; None: of no one."""
    if isinstance(source_of(owner, line.name).meant(line).effect, Noise):
        found = np.empty(n, dtype=np.intp)
        found[_statistics_order(n // 3)] = np.arange(3)[:, None]
        return found
    return None if n % line.u.size else np.arange(n) % line.u.size


def line_u_of_inputs(owner: str, line: Given, group: Group) -> Array:
    """Return the standard uncertainty of a line that each input of its source is of.

    Shape (n,) [SI of the line]: that of the axis of the input; of inputs that are of
    one process together, the largest.
    """
    n, u = len(group.mean), np.abs(line.u)  # a coefficient has a sign
    if isinstance(source_of(owner, line.name).meant(line).effect, Noise):
        found = np.empty(n)
        found[_statistics_order(n // 3)] = np.broadcast_to(u, (3,))[:, None]
        return found
    if n % u.size == 0 and group.is_independent:
        return np.resize(u, n)
    return np.full(n, u.max())


def _statistics_order(k: int) -> Array:
    """Return where statistic j of axis i stands among the inputs, shape (3, k)."""
    first = min(k, STATISTICS)
    own, more = np.arange(3 * first), np.arange(3 * first, 3 * k)
    return np.concatenate([own.reshape(3, -1), more.reshape(3, -1)], axis=1)


def _is_tested(triad: Triad) -> bool:
    """Whether any window is of that triad; else the design is all that is known."""
    return bool(triad.scheme.schedule.windows)


def _statistics(sensor: Sensor, scheme: Scheme, rows: Sequence[_Row]) -> Statistics:
    """Return the statistics of its windows that a triad needs of its noise."""
    wanted = [
        weights
        for row in rows
        if row.acts_on(sensor.kind)
        and scheme.schedule.windows
        and isinstance(row.source.effect, Disturbance)
        and row.given.u.any()
        and (weights := row.source.effect.weights(scheme)) is not None
    ]
    return Statistics.of(scheme, wanted)


@dataclass(frozen=True, kw_only=True)
class _Constant:
    """An Offset of one triad: its rows, those of a later turn-on, how it is counted.

    Or a Change: what the parameter takes of the same rows, in the test and later; or
    what a new unit has of parameters that are held.
    """

    now: slice
    later: slice | None = None
    gains: Gains | None = None
    is_left: bool = False  # in use, whatever the test finds

    @classmethod
    def of(cls, effect: Offset, place: slice, n: int, scheme: Scheme) -> _Constant:
        """Return an Offset of n values, whose rows stand at that place."""
        now, more = slice(place.start, place.start + n), place.stop - place.start > n
        if isinstance(effect, Initial):
            held = np.diag(scheme.held_of(effect.target))
            return cls(now=now, gains=(held, held))
        later = slice(now.stop, place.stop) if more else None
        return cls(now=now, later=later, is_left=isinstance(effect, Nonlinearity))

    def deviation(self, x: Array, reference: str) -> Array | float:
        """Return true value minus what the reference holds.

        The reference holds 0 (nominal), the value itself (as_tested), or, for what is
        new at each turn-on, an independent draw (next_turn_on); of what is left in use,
        which is met where the test was not, 0.
        """
        if reference == "nominal" or (self.is_left and reference == "next_turn_on"):
            return self.value(x)
        is_same = self.later is None and self.gains is None
        if reference == "as_tested" or is_same:
            return 0.0
        return self.value(x) - self.next_value(x)

    def held_value(self, x: Array, reference: str) -> Array | float:
        """Return what the reference holds of it, where the design has 0."""
        if reference == "nominal":
            return 0.0
        return self.value(x) if reference == "as_tested" else self.next_value(x)

    def value(self, x: Array) -> Array:
        """Return the value during the test."""
        own = x[self.now]
        return own if self.gains is None else np.asarray(self.gains[0] @ own)

    def next_value(self, x: Array) -> Array:
        """Return the value at the later turn-on."""
        own = x[self.now if self.later is None else self.later]
        return own if self.gains is None else np.asarray(self.gains[1] @ own)


@dataclass(frozen=True, kw_only=True, eq=False)
class Read:
    """What is read off of one triad, against its values during the test."""

    errors: Errors
    epsilon: Array  # errors of its statistics, shape (3, k, trials)


@dataclass(frozen=True, kw_only=True, eq=False)
class TriadCalibration:
    """The outputs of one triad as a function of all inputs: 12 less those held.

    Attributes
    ----------
    scheme : Scheme
    bias : ndarray, shape (3,)
        Nominal bias [unit of the input].
    angle : ndarray, shape (6,)
        Nominal mounting angles [rad].
    offsets : mapping of str to tuple of _Constant
        By what they are added to: 'bias', 'scale_factor', 'mounting_angle'.
    noise : slice or None
        Rows of the noise statistics.
    order : ndarray, shape (3, k)
        Of those rows by axis and statistic.
    own : ndarray, shape (3, m, k), or None
        What makes the statistics of the scheme of those; None: they are the first m.
    acts : tuple of (slice, Act)
        Disturbances, with their rows.
    reference : str
        What the errors are counted from.
    every : bool
        Whether errors of what is held are outputs too.
    """

    scheme: Scheme
    bias: Array
    angle: Array
    offsets: Mapping[str, tuple[_Constant, ...]]
    noise: slice | None
    order: Array
    own: Array | None
    acts: tuple[tuple[slice, Act], ...]
    reference: str
    every: bool

    def read(self, x: Array, beside: Read | None) -> Read:
        """Return what is read off, for inputs x, (n, trials) [SI].

        `beside` are the accelerometers that a gyro may be found by.
        """
        truth = Truth(
            angle=self._add(self.angle, x, "mounting_angle"),
            bias=self._add(self.bias, x, "bias"),
            scale_factor=self._add(np.zeros(3), x, "scale_factor")
            if self.scheme.held is not None
            else None,
        )
        noise = self._noise(x)
        own = self.own
        m = self.scheme.weights.shape[1]
        epsilon = noise[:, :m] if own is None else np.asarray(own @ noise)
        for rows, act in self.acts:
            epsilon = epsilon + act(x[rows], truth, noise)
        scheme = self.scheme
        if isinstance(scheme, RotationScheme) and beside is not None:
            shown = beside.epsilon[:, -len(scheme.from_beside) :]
            found = scheme.read_errors_beside(truth, epsilon, beside.errors, shown)
        else:
            found = scheme.read_errors(truth, epsilon)
        return Read(errors=found, epsilon=epsilon)

    def count(self, x: Array, found: Errors) -> list[Array]:
        """Return the errors against the reference, rows (n, trials) after one another.

        CommonScale factors [1], mounting angles [rad], biases [unit of the input].
        """
        # Error = (calibrated - true during the test) + (that - reference); relative
        # errors of the scale factor multiply: (1 + r)(1 + e) - 1.
        r = self._scale_factor_deviation(x)
        errors = [
            r + found.scale_factor * (1.0 + r),
            found.mounting_angle + self._deviation(x, "mounting_angle"),
            found.bias + self._deviation(x, "bias"),
        ]
        held = self.scheme.held
        if held is not None:
            every = np.concatenate(errors)
            if self.every:
                every[held.held] = self._left_by_design(x)[held.held]
            errors = [every if self.every else every[held.estimated]]
        if found.higher is None or not self.scheme.orders:
            return errors
        return [*errors, found.higher - self._found_before(x)]

    def _left_by_design(self, x: Array) -> Array:
        """Return design values minus those of the reference, shape (12, trials).

        Of a scale factor over that of the reference: 1/(1 + k) - 1.
        """
        k, angle, bias = (
            np.zeros_like(x, shape=(n, x.shape[1]))
            + sum((c.held_value(x, self.reference) for c in self.offsets[target]), 0.0)
            for target, n in (("scale_factor", 3), ("mounting_angle", 6), ("bias", 3))
        )
        return np.concatenate([-1.0 * k / (1.0 + k), -1.0 * angle, -1.0 * bias])

    def _found_before(self, x: Array) -> Array:
        """Return the higher orders that the reference holds, shape (3 m, trials)."""
        names = [name for name, p in ORDERS.items() if p in self.scheme.orders]
        held = [np.zeros_like(x, shape=(3, x.shape[1])) for _ in names]
        for place, name in enumerate(names):
            for constant in self.offsets.get(name, ()):
                if self.reference != "nominal":  # a constant of the device
                    held[place] = held[place] + x[constant.now]
        return np.concatenate(held)

    def _add(self, nominal: Array, x: Array, target: str) -> Array:
        """Return nominal values plus their offsets, (n, trials)."""
        total = _sum(constant.value(x) for constant in self.offsets[target])
        if isinstance(total, float):
            total = np.zeros_like(x, shape=(len(nominal), x.shape[1]))
        return total + nominal[:, None] if nominal.any() else total

    def _deviation(self, x: Array, target: str) -> Array | float:
        """Return true values during the test minus the reference's."""
        return _sum(c.deviation(x, self.reference) for c in self.offsets[target])

    def _scale_factor_deviation(self, x: Array) -> Array | float:
        """Return (K true - K reference) / K reference, shape (3, trials) [1].

        K = K0 (1 + sum of the offsets): Zhao 2019, eq. (14).
        """
        k = self._deviation(x, "scale_factor")
        if self.reference != "next_turn_on":
            return k  # K reference is K0, or K itself and k is 0
        met = (c for c in self.offsets["scale_factor"] if not c.is_left)
        return k / (1.0 + _sum(c.next_value(x) for c in met))

    def _noise(self, x: Array) -> Array:
        """Return the statistics of the noise, shape (3, k, trials)."""
        if self.noise is None:
            return np.zeros_like(x, shape=(*self.order.shape, x.shape[1]))
        rows = x[self.noise]
        if self.order.shape[1] == STATISTICS:  # in their order: a view, no copy
            return rows.reshape(3, STATISTICS, -1)
        return np.asarray(rows[self.order])


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """The function of the Problem: all triads on the same inputs.

    Attributes
    ----------
    triads : tuple of TriadCalibration
        A gyro before the accelerometers that it may be found by.
    kinds : tuple of str
        Whose errors are asked for.
    """

    triads: tuple[TriadCalibration, ...]
    kinds: tuple[str, ...]
    is_steady = True  # the same whenever it is called

    def __call__(self, x: Array) -> Array:
        """Return all outputs, shape (n_outputs, trials), for x (n_inputs, trials)."""
        found: list[Array] = []
        read = None
        for triad in reversed(self.triads):
            read = triad.read(x, read)
            if triad.scheme.owner in self.kinds:
                found = triad.count(x, read.errors) + found
        return np.concatenate(found)


def _sum(values: Iterable[Array | float]) -> Array | float:
    """Return the sum: of one array itself, of nothing 0."""
    first, *others = [*values] or [0.0]
    return reduce(add, others, first)


def _calibration(
    sensor: Sensor,
    triads: tuple[Triad, ...],
    number: int,
    places: tuple[tuple[_Row, slice], ...],
    reference: str,
    *,
    every: bool,
) -> TriadCalibration:
    """Bind every source to one triad, that of this number."""
    triad = triads[number]
    own = [(row, place) for row, place in places if row.acts_on(sensor.kind)]
    offsets: dict[str, tuple[_Constant, ...]] = dict.fromkeys(
        ("bias", "scale_factor", "mounting_angle"), ()
    )
    noise = None
    acts: list[tuple[slice, Act]] = []
    for row, place in own:
        effect = row.source.effect
        if isinstance(effect, Offset):
            constant = _Constant.of(effect, place, row.given.u.size, triad.scheme)
            offsets[effect.target] += (constant,)
        elif isinstance(effect, Noise):
            noise = place
        elif isinstance(effect, Disturbance):
            for quantity, order in ORDERS.items():
                if order == effect.order:
                    constant = _Constant(now=place, later=None)
                    offsets[quantity] = (*offsets.get(quantity, ()), constant)
            act = row.act_on(triad, effect)
            if act is not None:
                rows = range(place.start, place.stop)[effect.part(triads, number)]
                acts.append((slice(rows.start, rows.stop), act))
        elif isinstance(effect, TurnOnChange):
            for target, gains in effect.gains(triad.given).items():
                offsets[target] += (_Constant(now=place, gains=gains),)
    return TriadCalibration(
        scheme=triad.scheme,
        bias=sensor.nominal_bias,
        angle=sensor.nominal_mounting_angle,
        offsets=offsets,
        noise=noise,
        order=_statistics_order(triad.statistics.weights.shape[1]),
        own=triad.statistics.own,
        acts=tuple(acts),
        reference=reference,
        every=every,
    )


def _natural_bias(sensor: Sensor, procedure: Procedure) -> float:
    """Return what a bias of that triad is measured beside, with its own [SI]."""
    beside = ROTATION_RATE if sensor.kind == "gyro" else procedure.gravity
    return beside + float(np.abs(sensor.nominal_bias).max())


def _outputs_of(sensors: Sequence[Sensor], procedure: Procedure) -> dict[Name, Output]:
    """Return what can be asked of triads, with units, by name."""
    beside = [(sensor.kind, _natural_bias(sensor, procedure)) for sensor in sensors]
    return {
        output.name: output
        for owner, natural_bias in (*beside, (IMU, 0.0))
        for output in _outputs(owner, natural_bias)
    }


@lru_cache(maxsize=64)  # thousands of devices share a few
def _outputs(owner: str, natural_bias: float) -> tuple[Output, ...]:
    """Name the outputs of one owner, with units and the size of their rounding.

    `natural_bias` is what a bias is measured beside, with that of the design [SI].
    """
    angle = ("arcsec", ARCSEC, 1.0)
    units = {
        "scale_factor": ("ppm", PPM, 1.0),
        "bias": (*BIAS_UNITS.get(owner, ("", 1.0)), natural_bias),
        **{
            quantity: (
                f"ug/g^{p}",
                MICRO_G / STANDARD_GRAVITY**p,
                natural_bias ** (1 - p),
            )
            for quantity, p in ORDERS.items()
            if natural_bias
        },
    }
    return tuple(
        Output(
            name=name, unit=unit, si_per_unit=si_per_unit, resolution=ROUNDING * size
        )
        for name in every_output(owner)
        for unit, si_per_unit, size in [units.get(name.quantity, angle)]
    )
