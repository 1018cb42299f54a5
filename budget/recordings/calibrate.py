"""A recorded calibration: values, how sure they are, and whether the run was sound.

Values come by the estimator of the procedure (budget.model.scheme) from means of its
windows; their covariance is that of the budget, of errors against the values during
the test (budget.calibration.problem). Without a device it is that of the scatter: with
s^2 the residual sum of squares over n - m degrees of freedom, and J the derivative of
the estimate by the readings, J s^2 J'.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import date as Day  # noqa: N812 - one word with one meaning
from math import hypot, inf, isnan, log, sqrt
from typing import TYPE_CHECKING, cast

import numpy as np

from budget.calibration.derived import known_outputs, parts_of
from budget.calibration.mistakes import (
    SUSPECT,
    TriadRun,
    prior_of,
)
from budget.calibration.mistakes_of_norm import NormRun
from budget.calibration.mistakes_of_rotation import RotationRun
from budget.calibration.problem import BIAS_UNITS, calibration_problem
from budget.calibration.schemes import (
    as_recorded,
    calibrates,
    estimated,
    held_of,
    is_beside,
    orders_of,
    schemes_of,
    windows_of,
)
from budget.errors import BudgetError, CallError
from budget.inputs import load_device
from budget.inputs.files import find
from budget.inputs.records import UNCALIBRATED, Sensor
from budget.methods.gum import propagate
from budget.model.estimators import estimator_of
from budget.model.measured import MeasuredTurns, turns_of_rows
from budget.model.norm import NormScheme
from budget.model.response import COLUMN, ROW, SIGN, tilt_matrix
from budget.model.rotation import RotationScheme
from budget.model.source import GYRO, SENSORS
from budget.model.windows import dwells_of
from budget.names import ANGLES, AXES, IMU, ORDERS, Name, parameters_of
from budget.recordings.calibrated import (
    CalibratedOutput,
    CompensationMatrix,
    CorrectionInForce,
    MistakeRow,
    PassedOver,
    RecordedCalibration,
    RunChiSquare,
    RunWindow,
    Suspicion,
    UnseenMistake,
)
from budget.recordings.columns import COUNTS, LIKE
from budget.recordings.health import MOST_OUTLIERS, UnsoundSamples
from budget.recordings.records import RecordedConditions
from budget.recordings.results import read_result
from budget.recordings.run import read_windows
from budget.results import InputFile, input_files
from budget.sentences import sentence
from budget.settings import Asked, Inputs, RecordingSettings, asking
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.calibration.mistakes import ChiSquare, Mistake
    from budget.inputs.files import File
    from budget.inputs.records import Device, Procedure, Recording, Requirement
    from budget.model.response import CalibratedTriad
    from budget.model.scheme import Scheme
    from budget.problem import Output
    from budget.recordings.health import WindowHealth
    from budget.recordings.results import CalibrationResult, Key
    from budget.recordings.window_table import RecordedWindows

AnyRun = TriadRun | NormRun | RotationRun
STEP = 1e-4  # of readings over the largest, that the estimate is differentiated by [1]
SHOWN = 0.95  # probability of being seen, below which a mistake may be missed [1]
WORST = 3  # windows that are named
TINY = 1e-9  # of a reading's uncertainty, below which nothing can be left of it [1]
SAME_PACE = 1.25  # of lengths of windows over planned ones [1]
HALF = 0.5  # of a nominal scale factor, from which it is none [1]
AS_TESTED, SCALE_FACTOR = "as_tested", "scale_factor"
MEETS, FAILS, UNDECIDED = "meets", "fails", "undecided"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Triad:
    """One triad of a run.

    Attributes
    ----------
    sensor : Sensor
    scheme : Scheme
    numbers : tuple of int
        Of its windows in the procedure, from 1.
    readings : ndarray, shape (3, n)
        Means [SI or counts].
    scale, zero : ndarray, shape (3,)
        What readings are taken over and from, so that their scale factors are near 1.
    found : CalibratedTriad
        Of readings so scaled.
    has_counts : bool
    turns : MeasuredTurns or None
        Of a gyro that is found by them; its windows are dwells.
    is_found : bool
        Whether they fit any values; else those are nominal, and not given out.
    """

    sensor: Sensor
    scheme: Scheme
    numbers: tuple[int, ...]
    readings: Array
    scale: Array
    zero: Array
    found: CalibratedTriad
    has_counts: bool
    turns: MeasuredTurns | None = None
    is_found: bool = True

    @property
    def scaled(self) -> Array:
        """Readings over their scale, (3, n) [unit of the input]."""
        return np.asarray((self.readings - self.zero[:, None]) / self.scale[:, None])

    @property
    def scale_factor(self) -> Array:
        """K of readings over the input, (3,) [1, or counts per unit of the input]."""
        return np.asarray(self.scale * self.found.scale_factor)

    @property
    def is_left_handed(self) -> bool:
        """Whether S = K M turns a right-handed triad of inputs into a left-handed."""
        M = np.eye(3) + tilt_matrix(self.found.mounting_angle)
        return float(np.prod(self.scale_factor) * np.linalg.det(M)) < 0.0

    @property
    def bias(self) -> Array:
        """B of K (M u + b), (3,) [unit of the input]."""
        return np.asarray(self.found.bias + self.zero / self.scale_factor)

    @property
    def values(self) -> Array:
        """Parameters in the order of names: k or K, angles, biases, higher orders."""
        own = self.scale_factor if self.has_counts else self.scale_factor - 1.0
        higher = self.found.higher
        more = np.empty(0) if higher is None else higher
        return np.concatenate([own, self.found.mounting_angle, self.bias, more])

    @property
    def nominal(self) -> Array:
        """What the design has of them; nan of the scale factors of counts."""
        own = np.full(3, np.nan) if self.has_counts else np.zeros(3)
        angle, bias = self.sensor.nominal_mounting_angle, self.sensor.nominal_bias
        if self.has_counts:  # nobody knows where they begin
            bias = np.full(3, np.nan)
        more = np.full(len(self.values) - 12, np.nan)
        return np.concatenate([own, angle, bias, more])

    @property
    def residuals(self) -> Array:
        """Readings less those of what was found, (3, n) [unit of the input].

        By the norm of gravity, of what the calibrated triad shows along its length.
        """
        M = np.eye(3) + tilt_matrix(self.found.mounting_angle)
        K, b = self.found.scale_factor[:, None], self.found.bias[:, None]
        if isinstance(self.scheme, NormScheme):
            shown = np.linalg.solve(M, self.scaled / K - b)
            g = float(np.linalg.norm(self.scheme.gravity))
            return np.asarray(np.linalg.norm(shown, axis=0)[None] - g)
        if self.turns is not None:
            left = self.turns.misfit(self.found)[-self.readings.size :]
            return np.asarray(left.reshape(-1, 3).T / self.turns.lengths)
        inputs = (self.scheme.turn + self.scheme.standing).T
        true = M @ inputs + b
        if self.scheme.orders and self.found.higher is not None:
            K_p = self.found.higher.reshape(-1, 3)
            true = true + np.einsum("inm,mi->in", self.scheme.powers, K_p)
        return np.asarray(self.scaled / K - true)


@asking("calibrate")
def calibrate(
    *runs: Recording | File,
    device: Device | File | None = None,
    recorded: RecordingSettings,
    windows: File | None = None,
    as_found: File | None = None,
    serial: str = "",
    date: str = "",
    inputs: Inputs,
    asked: Asked,
) -> RecordedCalibration:
    """Calibrate a unit from what was recorded of a procedure.

    Parameters
    ----------
    *runs : str, Path or Recording
        A table with a row of means for each window, or recordings one after the other.
    device : str, Path or Device, optional
        What the unit should be; without it uncertainties are those of the scatter.
    windows : str or Path, optional
        Table of when each window begins and ends.
    as_found : str or Path, optional
        Result of an earlier calibration (--json), whose correction the unit came with;
        without it errors as found are of the unit without correction.
    serial, date : str
        Number of the unit, and when it was run, as they are to stand in the result.

    Returns
    -------
    RecordedCalibration

    Raises
    ------
    CallError
        No procedure is given, or its windows are not in the recording.
    SpecError
        Everything that is wrong with a file, each at its line.
    """
    if not runs:
        raise CallError("no run is given; name the file of one")
    if not serial.isprintable():
        raise CallError(f"serial is {serial!r}, expected a text of one line")
    how = inputs.calibrated()
    if how.formulas in UNCALIBRATED:
        raise CallError(f"{how.name} is no test of which a run could be recorded")
    recordings = recorded.load(*runs)
    planned = how
    if is_beside(how):  # the unit is turned any way from dwell to dwell
        how = replace(how, windows=tuple(dwells_of(windows_of(how))))
    times = None
    if windows is not None:
        file = find(windows, "recording")
        times = (file.path, file.shown)
    read = read_windows(
        recordings,
        windows_of(planned),
        name=how.name,
        times=times,
        knows_attitudes=estimator_of(how.formulas).knows_attitudes,
    )
    unit = None if device is None else load_device(device)
    there = as_recorded(how, read.windows)
    triads = [*_triads(read, there, unit)]
    why = ""
    if is_beside(planned) and GYRO in read.means:
        try:
            there, triads = _with_gyro(read, planned, there, unit, triads)
        except BudgetError as error:
            why = str(error)
    if not triads:
        kinds = ", ".join(read.means)
        raise CallError(
            f"{how.name} calibrates no triad of {read.name}, which has the {kinds}; "
            "give another procedure or recording"
        )
    wanted = inputs.required
    _check_limits(wanted)
    before = None if as_found is None else read_result(as_found)
    given = GivenOfRun(
        read=read,
        recordings=recordings,
        how=how,
        there=there,
        unit=unit,
        requirement=wanted,
        coverage=asked.settle(wanted).coverage,
        serial=serial,
        date=_day(date, recordings, before),
        before=before,
        left_out=why,
    )
    return _put_together(given, triads)


def _with_gyro(
    read: RecordedWindows,
    planned: Procedure,
    there: Procedure,
    unit: Device | None,
    triads: Sequence[_Triad],
) -> tuple[Procedure, list[_Triad]]:
    """Return a procedure with turns as they were, and triads with the gyro by them.

    Raises
    ------
    CallError
        There is no turn, nothing that they are held against, or they are too few.
    """
    norm = next((one for one in triads if isinstance(one.scheme, NormScheme)), None)
    sensors = {one.kind: one for one in (unit.sensors if unit else ())}
    if norm is None or GYRO not in sensors:
        raise CallError(sentence("calibrations.needs_device"))
    if not read.turns and read.turns_left_out:
        raise CallError(sentence("calibrations.no_sound_turn"))
    if not read.turns:
        raise CallError(sentence("calibrations.no_moves"))
    if read.has_counts[GYRO]:
        raise CallError(sentence("calibrations.needs_gain"))
    held = held_of(GYRO, planned, sensors[GYRO])
    M = np.eye(3) + tilt_matrix(norm.found.mounting_angle)
    inner = norm.scaled / norm.found.scale_factor[:, None] - norm.found.bias[:, None]
    shown = np.linalg.solve(M, inner)
    turns = MeasuredTurns(
        dwells=read.windows,
        down=(shown / np.linalg.norm(shown, axis=0)).T,
        still=read.means[GYRO],
        turns=read.turns,
        earth=there.place.earth,
        knows_azimuth=there.place.azimuth is not None,
    )
    if not np.isfinite(turns.still).all():
        raise CallError(sentence("calibrations.no_moves"))
    every = np.hstack([turns.still, *(one.rates for one in turns.turns)])
    _check_connected(GYRO, every)
    turns, found, is_found = turns.solve(held)
    there = replace(there, windows=turns.follow(found).windows)
    schemes = schemes_of([sensors[GYRO], norm.sensor], there)
    still = _Triad(
        sensor=sensors[GYRO],
        scheme=schemes[GYRO],
        numbers=tuple(range(1, len(read.windows) + 1)),
        readings=turns.still,
        scale=np.ones(3),
        zero=np.zeros(3),
        found=found,
        has_counts=False,
        turns=turns,
        is_found=is_found,
    )
    return there, [still, replace(norm, scheme=schemes[norm.sensor.kind])]


def _check_limits(wanted: Requirement | None) -> None:
    """Refuse limits on other errors than those of the values during the run.

    Raises
    ------
    CallError
        They are.
    """
    if wanted is not None and wanted.reference != AS_TESTED:
        raise CallError(
            f"{wanted.name} limits errors of reference {wanted.reference}, and a "
            "recorded calibration knows its values against those during the run; give "
            f"limits of 'reference: {AS_TESTED}', or ask `budget analyze "
            "--requirement` of the device"
        )


def _day(
    date: str, recordings: Sequence[Recording], before: CalibrationResult | None
) -> str:
    """Return the day of a run, as the call or the first recording file says; else ''.

    Raises
    ------
    CallError
        It is none, the two differ, or the correction in force is of a later one.
    """
    days = [one.date for one in recordings if one.date]
    try:
        day = "" if not date else Day.fromisoformat(date).isoformat()
    except ValueError:
        raise CallError(f"date is {date!r}, expected one as 2026-05-31") from None
    if day and days and day not in days:
        raise CallError(
            f"date is {day}, and the recording file says {days[0]}; leave one out"
        )
    found = day or next(iter(days), "")
    if before is not None and found and before.date > found:
        raise CallError(
            f"{before.name} is of {before.date}, after this run of {found}; as found "
            "is the correction that was in force before it"
        )
    return found


def _triads(
    read: RecordedWindows, procedure: Procedure, unit: Device | None
) -> Iterator[_Triad]:
    """Yield the triads that were recorded, calibrated.

    Raises
    ------
    CallError
        A window has no reading, or the gyro is found by what is between windows.
    """
    there = {one.kind: one for one in (unit.sensors if unit else ())}
    for kind in SENSORS:
        if kind not in read.means or not calibrates(kind, procedure):
            continue
        if unit is not None and kind not in there:
            continue
        sensor = there.get(kind) or Sensor.bare(kind)
        own = [k for k, one in enumerate(read.windows) if one.use in {kind, "both"}]
        readings = read.means[kind][:, own]
        if not np.isfinite(readings).all():
            axis, k = np.argwhere(~np.isfinite(readings))[0]
            raise CallError(
                f"{read.name}: window {own[k] + 1} ({read.windows[own[k]].name}) has "
                f"no reading of {kind}_{'xyz'[axis]}, which the procedure uses; give "
                f"it, or let the window be of the other triad alone (use)"
            )
        scheme = schemes_of([sensor], procedure)[kind]
        _check_connected(f"{read.name}: {kind}", readings)
        yield _triad(sensor, scheme, own, readings, is_counted=read.has_counts[kind])


def _check_connected(name: str, readings: Array) -> None:
    """Refuse a channel that reads the same all the time, (3, n)."""
    still = np.flatnonzero(np.ptp(readings, axis=1) == 0.0)
    if len(still):
        channel = f"{name}_{AXES[still[0]]}"
        raise CallError(sentence("calibrations.dead", channel=channel))


def _triad(
    sensor: Sensor,
    scheme: Scheme,
    own: Sequence[int],
    readings: Array,
    *,
    is_counted: bool,
) -> _Triad:
    """Calibrate one triad."""
    scale, zero = np.ones(3), np.zeros(3)
    if is_counted:
        size = float(np.abs(scheme.turn + scheme.standing).max())
        low, high = readings.min(axis=1), readings.max(axis=1)
        scale, zero = (high - low) / (2.0 * size), (high + low) / 2.0
        if not isinstance(scheme, NormScheme):
            found = scheme.estimate((readings - zero[:, None]) / scale[:, None])
            scale = scale * found.scale_factor
    scaled = (readings - zero[:, None]) / scale[:, None]
    return _Triad(
        sensor=sensor,
        scheme=scheme,
        numbers=tuple(k + 1 for k in own),
        readings=readings,
        scale=scale,
        zero=zero,
        found=scheme.estimate(scaled),
        has_counts=is_counted,
    )


# ---- how sure ------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True, eq=False)
class _Made:
    """Outputs of all triads, with values and how sure these are [SI]."""

    outputs: tuple[Output, ...]
    value: Array
    covariance: Array
    degrees_of_freedom: Array
    nominal: Array
    prior: Array  # standard uncertainties before; nan where nothing is known

    @classmethod
    def of(
        cls, triads: Sequence[_Triad], procedure: Procedure, unit: Device | None
    ) -> _Made:
        """Put values, and the law of the budget or the scatter, together."""
        kinds = [one.sensor.kind for one in triads]
        wanted = known_outputs(kinds, procedure)
        if not wanted:
            raise CallError(f"{procedure.name} estimates nothing of the {kinds[0]}")
        sensors = tuple(one.sensor for one in triads)
        problem = calibration_problem(
            sensors, procedure, reference=AS_TESTED, outputs=wanted
        )
        places: dict[Name, float] = {}
        nominal: dict[Name, float] = {}
        prior: dict[Name, float] = {}
        for triad in triads:
            names = _names(triad, procedure)
            inputs = triad.scheme.turn + triad.scheme.standing
            before = prior_of(
                triad.sensor,
                float(np.abs(inputs).max()),
                is_scaled=not triad.has_counts,
            )
            u = np.where(before.is_known, before.u, np.nan)
            for name, value, design, old in zip(
                names,
                triad.values,
                triad.nominal,
                np.concatenate([u, np.full(len(names) - 12, np.nan)]),
                strict=True,
            ):
                places[name], nominal[name] = float(value), float(design)
                prior[name] = float(old) if unit is not None else np.nan
        if unit is None:
            covariance, nu = _by_scatter(triads, procedure, wanted)
        else:
            law = propagate(problem)
            from_zero = _from_zero(triads, wanted)
            covariance = from_zero @ law.covariance @ from_zero.T
            nu = law.degrees_of_freedom
        return cls(
            outputs=tuple(problem.outputs),
            value=_summed(wanted, places),
            covariance=np.asarray(covariance),
            degrees_of_freedom=np.asarray(nu),
            nominal=_summed(wanted, nominal),
            prior=np.array(
                [
                    sqrt(sum((x * prior[one]) ** 2 for one, x in parts_of(n).items()))
                    for n in wanted
                ]
            ),
        )


def _from_zero(triads: Sequence[_Triad], wanted: Sequence[Name]) -> Array:
    """Return derivatives of outputs by those of readings taken from their zero.

    B = b + zero/K: a bias that is far from the middle of the readings is known no
    better than K is.
    """
    rows = {name: row for row, name in enumerate(wanted)}
    found = np.eye(len(wanted))
    for one in triads:
        for i, axis in enumerate(AXES):
            bias = rows.get(Name("bias", owner=one.sensor.kind, axis=axis))
            scale = rows.get(Name(SCALE_FACTOR, owner=one.sensor.kind, axis=axis))
            if bias is not None and scale is not None:
                found[bias, scale] = -one.zero[i] / one.scale_factor[i]
    return found


def _names(triad: _Triad, procedure: Procedure) -> list[Name]:
    """Return the names of a triad's values, in their order."""
    kind = triad.sensor.kind
    more = [one for one in estimated(kind, procedure) if one.quantity in ORDERS]
    return [*parameters_of(kind), *more][: len(triad.values)]


def _summed(names: Sequence[Name], values: Mapping[Name, float]) -> Array:
    """Return outputs of parameters, each a sum of its parts."""
    return np.array(
        [sum(x * values[part] for part, x in parts_of(one).items()) for one in names]
    )


def _by_scatter(
    triads: Sequence[_Triad], procedure: Procedure, wanted: Sequence[Name]
) -> tuple[Array, Array]:
    """Return covariance and degrees of freedom of outputs by the scatter of readings.

    Means have variances s^2 T0/T of white noise, T the median length of turns, or of
    dwells; s^2 is the sum of squares of the residuals R y over tr(A), with
    tr(A)^2/tr(A^2) degrees of freedom, A = D^1/2 R'R D^1/2, D = T0/T (Welch and
    Satterthwaite). Dwells alone have the residual mean square, with n less the
    parameters.

    Raises
    ------
    CallError
        There are no more readings than parameters.
    """
    n = len(wanted)
    windows = windows_of(procedure)
    covariance, nu = np.zeros((n, n)), np.full(n, inf)
    for triad in triads:
        names = _names(triad, procedure)
        left = triad.residuals
        held = triad.scheme.held
        D = np.ones(left.shape[1])
        if isinstance(triad.scheme, NormScheme):
            free = np.full(3, left.shape[1] - len(triad.scheme.held.estimated))
        else:
            which = np.zeros((3, 4), dtype=bool) if held is None else held.which
            fitted = (~which).sum(axis=1) + len(triad.scheme.orders)
            free = left.shape[1] - fitted
            own = [windows[k - 1] for k in triad.numbers]
            times: dict[bool, list[float]] = {}
            for one in own:
                times.setdefault(bool(one.sense), []).append(one.length)
            D = 1.0 / np.array([np.median(times[bool(one.sense)]) for one in own])
            D /= D.min()
        if min(free) <= 0:
            raise CallError(
                f"{procedure.name} has no more windows than parameters of the "
                f"{triad.sensor.kind}, so that no scatter says how sure they are; "
                "give the device (--device), or repeat windows"
            )
        variance = (left**2).sum(axis=1) * triad.found.scale_factor**2 / free
        if not isinstance(triad.scheme, NormScheme):
            R = _left(triad)
            A = np.sqrt(D)[:, None] * np.einsum("iab,iac->ibc", R, R) * np.sqrt(D)
            trace = np.einsum("ibb->i", A)
            variance *= free / trace
            # Whole degrees are not to fall to the next lower by rounding.
            free = np.round(trace**2 / (A**2).sum(axis=(1, 2)), 9)
        J = _derivative(triad)  # (values, 3, n)
        of_values = np.einsum("pin,i,n,qin->pq", J, variance, D, J)
        change = np.zeros((n, len(names)))
        for row, name in enumerate(wanted):
            for part, x in parts_of(name).items():
                if part in names:
                    change[row, names.index(part)] = x
        covariance += change @ of_values @ change.T
        for place in np.flatnonzero(change.any(axis=1)).tolist():
            axes = {_row_of(names[k]) for k in np.flatnonzero(change[place])}
            nu[place] = min(nu[place], *(free[axis] for axis in axes))
    return covariance, nu


def _row_of(name: Name) -> int:
    """Return the axis of a triad that a parameter is read by."""
    return "xyz".index(name.axis[0])


def _derivative(triad: _Triad) -> Array:
    """Return the derivatives of relative values by scaled readings, (values, 3, n)."""
    y = triad.scaled
    step = STEP * float(np.abs(y).max())
    found = np.zeros((len(triad.values), *y.shape))
    for axis in range(3):
        for k in range(y.shape[1]):
            ends = []
            for sign in (1.0, -1.0):
                moved = y.copy()
                moved[axis, k] += sign * step
                one = triad.scheme.estimate(moved)
                more = np.empty(0) if one.higher is None else one.higher
                ends.append(
                    np.concatenate(
                        [
                            one.scale_factor / triad.found.scale_factor,
                            one.mounting_angle,
                            one.bias + triad.zero / (triad.scale * one.scale_factor),
                            more,
                        ]
                    )
                )
            found[:, axis, k] = (ends[0] - ends[1])[: len(found)] / (2.0 * step)
    return found


# ---- what is said of it --------------------------------------------------------------


def _put_together(given: GivenOfRun, triads: Sequence[_Triad]) -> RecordedCalibration:
    """Return what has been found, in rows, and what has to be said of it.

    Raises
    ------
    CallError
        Nothing says how sure values are.
    """
    read, how, there = given.read, given.how, given.there
    valued = [one for one in triads if one.is_found]
    made = _Made.of(valued, there, given.unit)
    sound: dict[str, AnyRun] = {}
    untold: dict[str, str] = {}
    for one in triads if given.unit is not None else ():
        run = _run(one, triads, there)
        try:
            is_told = not run.is_sound or run.residual.degrees_of_freedom > 0
            why = "" if is_told else sentence("calibrations.no_residual")
            if run.is_sound and not one.is_found:
                why = sentence("calibrations.not_solved", sensor=one.sensor.kind)
        except CallError as error:  # of a triad that nothing varies of
            why = str(error)
        if why:
            untold[one.sensor.kind] = sentence("calibrations.untold", why=why)
        else:
            sound[one.sensor.kind] = run
    looks = [_suspicion(kind, run) for kind, run in sound.items() if not run.is_sound]
    suspicions = tuple(one for one in looks if one is not None)
    windows = tuple(
        row for one in triads for row in _windows(one, read, sound.get(one.sensor.kind))
    )
    named = {one.mistake.sensor for one in suspicions}
    lost = [
        kind
        for kind, run in sound.items()
        if run.residual.p < SUSPECT and kind not in named
    ]
    is_bad = any(not one.is_sound for one in sound.values()) or any(
        x.is_spoilt for _, _, x in _healths(read, triads)
    )
    lower = {one.owner for one in _lacks(given, triads)} | {*untold}
    lower |= {IMU} if lower else set()
    outputs = tuple(
        one if is_bad else _judged(one, is_lower=one.sensor in lower)
        for one in _as_found(_outputs(valued, made, given), made, given)
    )
    judged = {
        Name(one.parameter, owner=one.sensor, axis=one.axis)
        for one in outputs
        if one.limit is not None
    }
    wanted = () if given.requirement is None else given.requirement.limits
    not_judged = tuple(one.output for one in wanted if one.output not in judged)
    return RecordedCalibration(
        title=given.unit.name if given.unit else read.name,
        serial=given.serial,
        date=given.date,
        environment=tuple(map(RecordedConditions.of, given.recordings)),
        procedure=how.name,
        estimator=there.formulas,
        station=(*how.station, *how.environment),
        as_found=given.in_force,
        coverage=given.coverage,
        inputs=tuple(_files(given)),
        outputs=outputs,
        covariance=tuple(map(tuple, _printed_covariance(valued, made).tolist())),
        matrix=tuple(_matrix(one, made) for one in valued),
        windows=windows,
        chi_square=tuple(_chi(kind, one.residual) for kind, one in sound.items()),
        prior=tuple(_chi(kind, one.prior) for kind, one in sound.items()),
        looks_like=suspicions,
        worst=_worst(windows, lost),
        unseen=tuple(x for kind, run in sound.items() for x in unseen_of(kind, run)),
        passed_over=tuple(PassedOver(start=a, end=b) for a, b in read.passed_over),
        assumptions=(
            *(given.unit.assumptions if given.unit else ()),
            *how.assumptions,
            *_of_heading(triads, there),
            sentence("calibrations.as_tested"),
        ),
        warnings=(
            *_warnings(given, triads, not_judged),
            *untold.values(),
        ),
        least_p=SUSPECT,
        untold=tuple(untold),
        lacks=_lacks(given, triads),
        not_judged=not_judged,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenOfRun:
    """What a caller says of a run.

    Attributes
    ----------
    read : RecordedWindows
    recordings : sequence of Recording
    how, there : Procedure
        As it is given, and as it was recorded.
    unit : Device or None
    requirement : Requirement or None
    coverage : float
        Of the intervals [1].
    serial, date : str
    before : CalibrationResult or None
        Whose correction the unit came with.
    left_out : str
        Why the gyro is, where turns between dwells are to tell of it.
    """

    read: RecordedWindows
    recordings: Sequence[Recording]
    how: Procedure
    there: Procedure
    unit: Device | None
    requirement: Requirement | None
    coverage: float
    serial: str = ""
    date: str = ""
    before: CalibrationResult | None = None
    left_out: str = ""

    @property
    def in_force(self) -> CorrectionInForce | None:
        """The same as a row."""
        if self.before is None:
            return None
        own = ("name", "title", "serial", "date", "procedure", "is_sound")
        return CorrectionInForce(**{key: getattr(self.before, key) for key in own})


def _run(triad: _Triad, triads: Sequence[_Triad], procedure: Procedure) -> AnyRun:
    """Return what mistakes are looked for in."""
    beside = next((one for one in triads if isinstance(one.scheme, NormScheme)), None)
    if isinstance(triad.scheme, RotationScheme) and triad.turns and beside:
        return RotationRun(
            sensor=triad.sensor,
            beside=beside.sensor,
            procedure=procedure,
            norm=cast("NormScheme", beside.scheme),
            held=triad.scheme.held,
            turns=triad.turns,
        )
    if isinstance(triad.scheme, NormScheme):
        return NormRun.of(
            triad.sensor,
            procedure,
            triad.scheme,
            triad.scaled,
            numbers=triad.numbers,
            is_scaled=not triad.has_counts,
        )
    return TriadRun.of(
        triad.sensor,
        procedure,
        triad.scheme.schedule,
        triad.scaled,
        triad.numbers,
        is_scaled=not triad.has_counts,
        orders=orders_of(triad.sensor.kind, procedure),
    )


def _chi(kind: str, one: ChiSquare) -> RunChiSquare:
    """Return a chi-square as a row."""
    return RunChiSquare(
        sensor=kind,
        value=one.value,
        degrees_of_freedom=one.degrees_of_freedom,
        p=one.p,
    )


def _suspicion(kind: str, run: AnyRun) -> Suspicion | None:
    """Return what a triad's run looks like; None where no known mistake fits."""
    found = run.looks_like
    if found is None:
        return None
    return Suspicion(
        mistake=MistakeRow.of(kind, found.mistake),
        evidence=found.evidence,
        also=tuple(MistakeRow.of(kind, one) for one in found.also),
    )


def unseen_of(kind: str, run: AnyRun) -> Iterator[UnseenMistake]:
    """Yield the kinds of mistakes that may be missed, with the windows of each."""
    groups: dict[str, list[Mistake]] = {}
    for one in run.known:
        groups.setdefault(one.name, []).append(one)
    for name, every in groups.items():
        # Two windows of equal inputs may be exchanged without harm.
        own = [one for one in every if name != "windows_order" or run.is_seen(one)]
        seen = [run.shown(one) if run.is_seen(one) else 0.0 for one in own]
        missed = [one for one, p in zip(own, seen, strict=True) if p < SHOWN]
        if missed:
            yield UnseenMistake(
                name=name,
                sensor=kind,
                probability=min(seen),
                windows=tuple(sorted({x for one in missed for x in one.numbers})),
            )


@dataclass(frozen=True, kw_only=True)
class UnseenMistakes:
    """What a run of a procedure with a device may not show, or why that is not told."""

    unseen: tuple[UnseenMistake, ...]
    why: str = ""


def unseen_mistakes(device: Device, procedure: Procedure) -> UnseenMistakes:
    """Tell before a run which known mistakes it may not show.

    By a run that reads what the nominal unit would.
    """
    found: list[UnseenMistake] = []
    try:
        for sensor in device.sensors:
            kind = sensor.kind
            if not calibrates(kind, procedure):
                continue
            if kind == GYRO and is_beside(procedure):
                run = _nominal_rotation(sensor, procedure)
                found += unseen_of(kind, run) if run else ()
                continue
            scheme = schemes_of([sensor], procedure)[kind]
            inputs = (scheme.turn + scheme.standing).T
            M = np.eye(3) + tilt_matrix(sensor.nominal_mounting_angle)
            readings = M @ inputs + sensor.nominal_bias[:, None]
            every = enumerate(windows_of(procedure))
            own = [k for k, one in every if one.use in {kind, "both"}]
            triad = _triad(sensor, scheme, own, readings, is_counted=False)
            found += unseen_of(kind, _run(triad, (), procedure))
    except BudgetError as error:
        return UnseenMistakes(unseen=(), why=str(error))
    return UnseenMistakes(unseen=tuple(found))


def _nominal_rotation(gyro: Sensor, procedure: Procedure) -> RotationRun | None:
    """Return the turns of a procedure as the nominal gyro would read them."""
    if gyro.beside is None:
        return None
    schemes = schemes_of([gyro, gyro.beside], procedure)
    scheme, norm = schemes[GYRO], schemes[gyro.beside.kind]
    if not (isinstance(scheme, RotationScheme) and isinstance(norm, NormScheme)):
        return None
    windows = scheme.schedule.windows
    M = np.eye(3) + tilt_matrix(gyro.nominal_mounting_angle)
    rates = M @ (scheme.turn + scheme.standing).T + gyro.nominal_bias[:, None]
    still, turns = turns_of_rows(windows, rates)
    return RotationRun(
        sensor=gyro,
        beside=gyro.beside,
        procedure=procedure,
        norm=norm,
        held=scheme.held,
        turns=MeasuredTurns(
            dwells=tuple(windows[k] for k in still),
            down=norm.force / procedure.gravity,
            still=rates[:, still],
            turns=turns,
            earth=procedure.place.earth,
            knows_azimuth=procedure.place.azimuth is not None,
        ),
    )


def _pace(read: RecordedWindows, procedure: Procedure) -> float:
    """Return how much longer turns took than planned, the median; dwells without any.

    A dwell is found as long as the unit rested.
    """
    pairs = list(zip(read.windows, windows_of(procedure), strict=True))
    turns = [(one, other) for one, other in pairs if other.sense] or pairs
    return float(np.median([one.length / other.length for one, other in turns]))


def _windows(
    triad: _Triad, read: RecordedWindows, run: AnyRun | None
) -> Iterator[RunWindow]:
    """Yield the windows of a triad, with what is left of each."""
    kind = triad.sensor.kind
    unit = COUNTS if triad.has_counts else LIKE[kind]
    size = 1.0 if triad.has_counts else size_of(unit)
    own_unit, own_size = BIAS_UNITS[kind]
    left = triad.residuals
    z = None if run is None else left / _residual_u(triad, run)
    own = read.health.get(kind)
    for k, number in enumerate(triad.numbers):
        window = read.windows[number - 1]
        health = None if own is None else own[number - 1]
        yield RunWindow(
            window=number,
            name=window.name,
            sensor=kind,
            start=window.start,
            length=window.length,
            unit=unit,
            mean=triad.readings[:, k] / size,
            residual=left[:, k] / own_size,
            residual_unit=own_unit,
            z=None if z is None else z[:, k],
            gaps=health.gaps if health else None,
            missing=health.missing if health else None,
            saturated=health.saturated if health else (),
            stuck=health.stuck if health else (),
            outliers=health.outliers if health else (),
            is_spoilt=health.is_spoilt if health else None,
        )


def _residual_u(triad: _Triad, run: AnyRun) -> Array:
    """Return standard uncertainties of residuals, (3, n): of (1 - A W) C (1 - A W)'."""
    if isinstance(run, RotationRun):
        return run.residual_u()
    if isinstance(run, NormRun):
        J, W = run.sensitivity, np.linalg.pinv(run.sensitivity)
        R = np.eye(len(J)) - J @ W
        g = run.place.gravity
        found = np.sqrt(np.maximum(np.diag(R @ run.covariance @ R.T), 0.0)) / (2.0 * g)
        noise = np.sqrt(np.diag(run.covariance)) / (2.0 * g)
        return np.asarray(np.where(found > TINY * noise, found, np.inf))[None]
    n = triad.readings.shape[1]
    C = run.covariance.reshape(3, n, 3, n)
    found = np.array(
        [
            np.sqrt(np.maximum(np.diag(R @ C[axis, :, axis] @ R.T), 0.0))
            for axis, R in enumerate(_left(triad))
        ]
    )
    noise = np.sqrt(np.diag(run.covariance)).reshape(3, n)
    return np.asarray(np.where(found > TINY * noise, found, np.inf))


def _left(triad: _Triad) -> Array:
    """Return R of residuals R y, 1 - A W of each axis, (3, n, n)."""
    scheme = triad.scheme
    n = triad.readings.shape[1]
    A = np.column_stack([scheme.turn + scheme.standing, np.ones(n)])
    columns = [
        np.column_stack([A, scheme.powers[axis]]) if scheme.orders else A
        for axis in range(3)
    ]
    return np.asarray(np.eye(n) - np.array(columns) @ np.array(scheme.weights))


def _worst(windows: Sequence[RunWindow], kinds: Sequence[str]) -> tuple[int, ...]:
    """Return the windows of triads that are farthest off, the farthest first."""
    sizes = [
        (float(np.abs(one.z).max()), one.window)
        for one in windows
        if one.sensor in kinds and one.z is not None
    ]
    found = dict.fromkeys(number for _, number in sorted(sizes, reverse=True))
    return tuple(found)[:WORST]


def _units(triads: Sequence[_Triad], output: Output) -> tuple[str, float]:
    """Return the unit of an output, and its size: of counts over the input's."""
    name = output.name
    for one in triads:
        if one.sensor.kind == name.owner and one.has_counts:
            like = LIKE[name.owner]
            if name.quantity == SCALE_FACTOR:
                return f"{COUNTS}/({like})", 1.0 / size_of(like)
    return output.unit, output.si_per_unit


def _factors(triads: Sequence[_Triad], made: _Made) -> Array:
    """Return what the law's errors are times of those of the values: K of counts."""
    found = np.ones(len(made.outputs))
    for row, output in enumerate(made.outputs):
        if output.name.quantity != SCALE_FACTOR:
            continue
        for one in triads:
            if one.sensor.kind == output.name.owner:
                axis = "xyz".index(output.name.axis)
                found[row] = abs(one.scale_factor[axis])
    return found


def _printed_covariance(triads: Sequence[_Triad], made: _Made) -> Array:
    """Return the covariance of the values, in their units."""
    sizes = np.array([_units(triads, one)[1] for one in made.outputs])
    change = _factors(triads, made) / sizes
    return np.asarray(made.covariance * np.outer(change, change))


def _outputs(
    triads: Sequence[_Triad], made: _Made, given: GivenOfRun
) -> Iterator[CalibratedOutput]:
    """Yield the values, each with how sure it is and what was known before."""
    u = np.sqrt(np.diag(made.covariance)) * _factors(triads, made)
    k = _coverage_factors(made.degrees_of_freedom, given.coverage)
    limits = {}
    if given.requirement is not None:
        limits = {one.output: one.limit for one in given.requirement.limits}
    for row, output in enumerate(made.outputs):
        unit, size = _units(triads, output)
        prior, nominal = float(made.prior[row]), float(made.nominal[row])
        is_known = np.isfinite(prior) and np.isfinite(nominal) and prior > 0.0
        off = made.value[row] - nominal
        yield CalibratedOutput(
            sensor=output.name.owner,
            parameter=output.name.quantity,
            axis=output.name.axis,
            unit=unit,
            si_per_unit=size,
            value=float(made.value[row]),
            standard_uncertainty=float(u[row]),
            coverage_factor=float(k[row]),
            degrees_of_freedom=float(made.degrees_of_freedom[row]),
            prior=prior if is_known else None,
            prior_z=float(off / hypot(prior, u[row])) if is_known else None,
            limit=limits.get(output.name) if unit == output.unit else None,
        )


def _as_found(
    rows: Iterable[CalibratedOutput], made: _Made, given: GivenOfRun
) -> Iterator[CalibratedOutput]:
    """Yield values with the errors of the unit as it came: less the correction's.

    The correction is a number, as it was applied: the error is known as the value is.

    Raises
    ------
    CallError
        The correction in force has no value of it in its unit, or none of all.
    """
    before = given.before
    there: dict[Key, tuple[str, float]] = {}
    if before is not None:
        both = zip(before.units, before.values.tolist(), strict=True)
        there = dict(zip(before.keys, both, strict=True))
    has_any = before is None
    for row, nominal in zip(rows, made.nominal.tolist(), strict=True):
        key = (row.sensor, row.parameter, row.axis)
        taken = None if isnan(nominal) or before is not None else nominal
        if before is not None and key in there:
            unit, value = there[key]
            if unit != row.unit:
                raise CallError(
                    f"{' '.join(key)} is in {unit} in {before.name}, and in "
                    f"{row.unit} here; calibrate both with, or without, a gain"
                )
            taken, has_any = value * row.si_per_unit, True
        yield replace(row, as_found=None if taken is None else row.value - taken)
    if before is not None and not has_any:
        raise CallError(f"{before.name} has no parameter in common with this run")


def _judged(row: CalibratedOutput, *, is_lower: bool) -> CalibratedOutput:
    """Return a value with verdicts on its errors as found and as left.

    With U as guard band on either side: |e| + U within the limit meets, |e| - U above
    it fails (JCGM 106, 8.3.2). A U that is a lower bound tells of no error whether it
    meets.
    """
    limit, U = row.limit, row.expanded
    if limit is None:
        return row

    def standing(low: float, high: float) -> str:
        if high <= limit and not is_lower:
            return MEETS
        return FAILS if low > limit and not is_lower else UNDECIDED

    e = None if row.as_found is None else abs(row.as_found)
    return replace(
        row,
        found_standing=None if e is None else standing(e - U, e + U),
        left_standing=FAILS if limit < U else standing(0.0, U),
    )


def _coverage_factors(degrees_of_freedom: Array, coverage: float) -> Array:
    """Return k of the t distribution, for the integer below: JCGM 100, G.4."""
    from scipy.special import ndtri, stdtrit

    p = (1.0 + coverage) / 2.0
    nu = np.floor(np.where(np.isinf(degrees_of_freedom), 1.0, degrees_of_freedom))
    return np.asarray(
        np.where(
            np.isinf(degrees_of_freedom), ndtri(p), stdtrit(np.maximum(nu, 1.0), p)
        )
    )


def _matrix(triad: _Triad, made: _Made) -> CompensationMatrix:
    """Return S, its inverse and its parts, with what these are not known to."""
    kind = triad.sensor.kind
    like = LIKE[kind]
    size = size_of(like)
    unit = f"{COUNTS}/({like})" if triad.has_counts else "1"
    of_reading = size if triad.has_counts else 1.0
    K, M = triad.scale_factor, np.eye(3) + tilt_matrix(triad.found.mounting_angle)
    S = K[:, None] * M * of_reading
    bias_unit = COUNTS if triad.has_counts else like
    bias = K * triad.bias / (1.0 if triad.has_counts else size)
    rows = {one.name: k for k, one in enumerate(made.outputs)}
    u_S, u_b = np.full((3, 3), np.nan), np.full(3, np.nan)  # of what is held
    C = made.covariance

    def covariance(a: Name, b: Name) -> float:
        return float(C[rows[a], rows[b]]) if a in rows and b in rows else 0.0

    for i, axis in enumerate(AXES):
        k_ = Name(SCALE_FACTOR, owner=kind, axis=axis)
        b_ = Name("bias", owner=kind, axis=axis)
        own = triad.bias[i]
        square = (
            own**2 * covariance(k_, k_)
            + 2.0 * own * covariance(k_, b_)
            + covariance(b_, b_)
        )
        if k_ in rows:
            u_S[i, i] = sqrt(covariance(k_, k_))
        if b_ in rows:
            u_b[i] = sqrt(max(square, 0.0))
    for angle, i, j, sign in zip(ANGLES, ROW, COLUMN, SIGN, strict=True):
        a_ = Name("mounting_angle", owner=kind, axis=angle)
        k_ = Name(SCALE_FACTOR, owner=kind, axis=AXES[i])
        part = M[i, j]
        square = (
            covariance(a_, a_)
            + 2.0 * sign * part * covariance(a_, k_)
            + part**2 * covariance(k_, k_)
        )
        if a_ in rows:
            u_S[i, j] = sqrt(max(square, 0.0))
    q, r = np.linalg.qr(S.T)
    # The sign of an axis that is reversed is that of its scale factor, so that R is a
    # rotation.
    signs = np.where(np.diag(r) * K < 0.0, -1.0, 1.0)
    scale = np.abs(K)
    return CompensationMatrix(
        sensor=kind,
        unit=unit,
        sensor_from_body=S,
        body_from_sensor=np.asarray(np.linalg.inv(S), dtype=float),
        bias=bias,
        bias_unit=bias_unit,
        standard_uncertainty=_or_none(u_S * scale[:, None] * of_reading),
        bias_standard_uncertainty=_or_none(
            [u_b * scale / (1.0 if triad.has_counts else size)]
        )[0],
        triangle=(r.T * signs),
        rotation=(q * signs).T,
    )


def _or_none(rows: Iterable[Array]) -> tuple[tuple[float | None, ...], ...]:
    """Return rows of numbers, None where nothing was estimated."""
    return tuple(tuple(None if isnan(x) else x for x in one.tolist()) for one in rows)


def _files(given: GivenOfRun) -> Iterator[InputFile]:
    """Yield the files that it rests on."""
    every = [
        *(
            (one.origin.file, one.origin.sha256)
            for one in given.recordings
            if one.origin
        ),
        *given.read.sha256,
    ]
    every = [*dict.fromkeys(every)]
    for number, (name, digest) in enumerate(every, start=1):
        role = f"recording {number}" if len(every) > 1 else "recording"
        yield InputFile(role=role, name=name, sha256=digest)
    there = () if given.unit is None else (given.unit,)
    yield from input_files(there, procedure=given.how, requirement=given.requirement)
    if given.before is not None:
        name, digest = given.before.name, given.before.sha256
        yield InputFile(role="as found", name=name, sha256=digest)


def _of_heading(triads: Sequence[_Triad], procedure: Procedure) -> tuple[str, ...]:
    """Say whose heading is assumed, where turns are followed from a known one."""
    is_followed = any(one.turns for one in triads)
    if not is_followed or procedure.place.azimuth is None:
        return ()
    return (sentence("calibrations.first_heading"),)


def _lacks(given: GivenOfRun, triads: Sequence[_Triad]) -> tuple[Name, ...]:
    """Return what a data sheet does not give and would add to uncertainties."""
    if given.unit is None:
        return ()
    return tuple(x for one in triads for x in one.sensor.expected_missing)


def _warnings(
    given: GivenOfRun, triads: Sequence[_Triad], not_judged: Sequence[Name]
) -> Iterator[str]:
    """Yield what has to be said of a run besides."""
    read, how, unit = given.read, given.how, given.unit
    left = sorted(read.means.keys() - {one.sensor.kind for one in triads})
    lacks = _lacks(given, triads)
    far = [
        Name(SCALE_FACTOR, owner=one.sensor.kind)
        for one in triads
        if unit is None and not one.has_counts
        if (np.abs(one.scale_factor - 1.0) > HALF).any()
    ]
    held = [
        name
        for one in triads
        for name in parameters_of(one.sensor.kind)
        if name not in estimated(one.sensor.kind, given.there)
    ]
    is_by_norm = any(isinstance(one.scheme, NormScheme) for one in triads)
    missing = [
        one.kind
        for one in (unit.sensors if unit else ())
        if one.kind not in read.means and calibrates(one.kind, how)
    ]
    ratio = _pace(read, how)
    is_spoilt = any(x.is_spoilt for _, _, x in _healths(read, triads))
    before = given.before
    is_other = before is not None and before.serial != given.serial
    is_unsound = before is not None and before.is_sound is False
    name = "" if before is None else before.name
    rows = [
        (is_other, sentence("calibrations.other_unit")),
        (is_unsound, sentence("calibrations.unsound", name=name)),
        (missing, sentence("calibrations.not_recorded", sensors=missing)),
        (
            abs(log(ratio)) > log(SAME_PACE),
            sentence("calibrations.other_lengths", ratio=ratio),
        ),
        (unit is None and not is_spoilt, sentence("calibrations.no_device")),
        (unit is None and is_spoilt, sentence("calibrations.by_scatter")),
        (unit is not None and not how.station, sentence("calibrations.no_station")),
        (lacks, sentence("calibrations.lacks", names=lacks)),
        (given.there.formulas != how.formulas, sentence("calibrations.other_times")),
        *(
            (one.has_counts, sentence("calibrations.counts", sensor=one.sensor.kind))
            for one in triads
        ),
        (far, sentence("calibrations.far", names=far)),
        (not read.has_one_clock, sentence("calibrations.no_pauses")),
        (
            left and not given.left_out,
            sentence("calibrations.not_calibrated", sensors=left),
        ),
        (
            given.left_out,
            sentence("calibrations.gyro_left_out", why=given.left_out),
        ),
        (
            read.turns_left_out,
            sentence("calibrations.turns_left_out", turns=read.turns_left_out),
        ),
        *(
            (
                not one.is_found,
                sentence("calibrations.not_solved", sensor=one.sensor.kind),
            )
            for one in triads
        ),
        (not_judged, sentence("calibrations.not_judged", names=not_judged)),
        *(
            (
                one.is_left_handed,
                sentence("calibrations.left_handed", sensor=one.sensor.kind),
            )
            for one in triads
        ),
        (held, sentence("calibrations.held", names=held)),
        (is_by_norm, sentence("calibrations.by_norm")),
        (not read.is_as_planned, sentence("calibrations.other_attitudes")),
        (
            read.passed_over,
            sentence("calibrations.passed_over", spans=read.passed_over),
        ),
    ]
    yield from (said for is_so, said in rows if is_so)
    yield from _of_health(read, triads)


def _healths(
    read: RecordedWindows, triads: Sequence[_Triad]
) -> Iterator[tuple[int, str, WindowHealth]]:
    """Yield the health of each window of each triad, with its number and sensor."""
    for one in triads:
        own = read.health.get(one.sensor.kind)
        if own is not None:
            for number in one.numbers:
                yield number, one.sensor.kind, own[number - 1]


def _of_health(read: RecordedWindows, triads: Sequence[_Triad]) -> Iterator[str]:
    """Yield what windows lack, and what is kept out of their means: each kind once."""
    every = [*_healths(read, triads)]
    turns = {k for k, one in enumerate(read.windows, start=1) if one.sense}

    def places(what: str, least: float = 0.0) -> list[UnsoundSamples]:
        return [
            UnsoundSamples(window=number, sensor=kind, axis=axis, count=count)
            for number, kind, health in every
            for axis, count in zip(AXES, getattr(health, what), strict=True)
            if count > least * health.samples
        ]

    missing: dict[int, int] = {}
    for number, _, health in every:
        if health.missing:
            missing[number] = max(missing.get(number, 0), health.missing)
    in_rest = [one for one in missing if one not in turns]
    in_turn = [one for one in missing if one in turns]
    samples = [sum(missing[one] for one in own) for own in (in_rest, in_turn)]
    lost = sorted({number for number, _, health in every if health.is_lost})
    thin = sorted({number for number, _, health in every if health.is_thin})
    at_end, stuck, outliers = map(places, ("saturated", "stuck", "outliers"))
    many = places("outliers", MOST_OUTLIERS)
    rows = [
        (at_end, sentence("calibrations.saturated", places=at_end)),
        (in_rest, sentence("calibrations.gaps", windows=in_rest, missing=samples[0])),
        (
            in_turn,
            sentence("calibrations.gaps_in_turns", windows=in_turn, missing=samples[1]),
        ),
        (lost, sentence("calibrations.lost", windows=lost)),
        (stuck, sentence("calibrations.stuck", places=stuck)),
        (outliers, sentence("calibrations.outliers", places=outliers)),
        (many, sentence("calibrations.many_outliers", places=many)),
        (thin, sentence("calibrations.thin", windows=thin)),
    ]
    yield from (said for is_so, said in rows if is_so)
