"""Calibrations of one unit over time: drift with its interval, and what it reaches.

A value of one calibration is one of the unit at one of its turn-ons: u^2 is that of the
calibration with R^2, R the repeatability from turn-on to turn-on that a data sheet
prints. A straight line is fitted to the values of each parameter, weighed by their
variances: of N values with residuals r, chi-square sum (r/u)^2 has N - 2 degrees of
freedom. Where that is more, every variance has a further t^2 with which it is not
(Mandel and Paule), as each turn-on adds its own whatever a calibration is known to;
with Student's t.

At the next turn-on the error of the last value is that of the calibration, its own
turn-on and the next one's: u^2 + 2 R^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date as Day  # noqa: N812 - one word with one meaning
from math import exp, floor, inf, isfinite, log, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs import load_device
from budget.inputs.reader import refuse
from budget.model.source import Nonlinearity, Offset
from budget.model.sources import source_of
from budget.model.sources.later import AGEING, growth
from budget.names import PARAMETERS, Name, by_group
from budget.recordings.results import (
    LEVEL,
    common_keys,
    counted_once,
    in_one_unit,
    read_results,
    said_of,
)
from budget.recordings.run_values import AS_TESTED
from budget.results import input_files, numbered_files
from budget.sentences import sentence
from budget.settings import Asked, Inputs, asking
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Device, Requirement
    from budget.model.source import Given
    from budget.recordings.calibrated import CalibrationResult, Key
    from budget.results import InputFile

YEAR = 365.25  # [days]
LEAST = 2  # calibrations of which there is a drift
DRIFTS, STEADY, NOT_TOLD = "drifts", "steady", "not told"
OLDER = 1.959964  # normal, of 95 %
RESULT = "*.json"
NEXT = "next_turn_on"
TURN_ONS = {AS_TESTED: 0, NEXT: 2}  # of a repeatability, in the variance of an error
LONGEST = 1e4  # [years], beyond which nothing is reached
MANY = 1_000_000_000  # degrees of freedom of what is known
LEAST_SCATTER, MOST_SCATTER = 1e-12, 1e3  # over the range of the values [1]


@written(
    "calibrated_value",
    """
    name: of the result
    date
    time [years]: since the first
    value / unit [unit]
    standard_uncertainty or null [unit]: as a value of the unit, with the repeatability
    expanded or null [unit]: U = k u
    """,
)
@dataclass(frozen=True, kw_only=True)
class CalibratedValue(Documented):
    """One value of a parameter in time."""

    name: str
    date: str
    time: float
    value: float
    standard_uncertainty: float | None
    expanded: float | None


@written(
    "history_row",
    """
    sensor: 'gyro' or 'accelerometer'
    parameter
    axis
    unit
    values not in CSV
    repeatability or null [unit]: standard uncertainty from turn-on to turn-on, by the
      data sheet; null where it prints none
    drift [unit/year]: slope of the straight line
    drift_low or null [unit/year]: of its interval at 95 %; null where no uncertainty is
      known
    drift_high or null [unit/year]
    scatter or null [1]: of the values about it, over what they are known to; null of
      two, and where nothing is known of that
    p or null [1]: probability of as large a slope where nothing drifts; null of two
      values, whose scatter nobody knows, and where an uncertainty is not known
    standing: 'drifts' where p is below 5 % over all parameters, 'not told' without p,
      else 'steady'
    ageing [unit]: standard uncertainty of what a year adds, by the data sheet;
      null where none says it
    is_older: whether it drifts more than the data sheet says, at 95 %
    limit or null [unit]: on its error; null where there is none, or it is not judged
    reaches [years]: since the last calibration, when drift and U are the limit; null
      where it does not drift
    earliest [years]: by the end of the interval that is farther from 0
    """,
)
@dataclass(frozen=True, kw_only=True)
class HistoryRow(Documented):
    """One parameter over time, in its unit."""

    sensor: str
    parameter: str
    axis: str
    unit: str
    values: tuple[CalibratedValue, ...]
    repeatability: float | None
    drift: float
    drift_low: float | None
    drift_high: float | None
    scatter: float | None
    p: float | None
    standing: str
    ageing: float | None
    is_older: bool
    limit: float | None
    reaches: float | None
    earliest: float | None
    si_per_unit: float = 1.0


@written(
    "calibration_history",
    """
    title: name of the unit
    serial
    inputs by role as file
    parameters
    assumptions
    warnings
    """,
    commands="history",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class CalibrationHistory(Documented):
    """Calibrations of a unit over time."""

    title: str
    serial: str
    inputs: tuple[InputFile, ...]
    parameters: tuple[HistoryRow, ...]
    assumptions: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def drifting(self) -> tuple[HistoryRow, ...]:
        """Parameters that drift."""
        return tuple(one for one in self.parameters if one.standing == DRIFTS)

    @property
    def first_to_reach(self) -> HistoryRow | None:
        """The parameter that may reach its limit first."""
        found = [one for one in self.parameters if one.earliest is not None]
        return min(found, key=lambda one: one.earliest or 0.0, default=None)


@asking("history")
def history(
    *results: File,
    device: Device | File | None = None,
    inputs: Inputs,
    asked: Asked,  # noqa: ARG001 - as every job has it
) -> CalibrationHistory:
    """Put calibrations of one unit in the order of time.

    Parameters
    ----------
    *results : str or Path
        Results of `budget calibrate --json`, or folders of them.
    device : str, Path or Device, optional
        Data sheet, whose repeatability and ageing drifts are held against.

    Returns
    -------
    CalibrationHistory

    Raises
    ------
    SpecError
        A file is no result.
    CallError
        They are fewer than two, of several units, or without dates, or limits are on
        errors that they do not know.
    """
    read, twice = counted_once(read_results(_files(results)))
    found = sorted(read, key=_day)
    if len(found) < LEAST:
        raise CallError(
            f"{len(found)} result of a calibration is given, expected 2 or more, or a "
            f"folder of them{'; '.join(['', *map(str, twice)])}"
        )
    serials = {one.serial: one.name for one in found}
    if len(serials) > 1:
        listed = ", ".join(f"{name}: {x or 'none'}" for x, name in serials.items())
        raise CallError(
            f"the results are of several units ({listed}); give those of one"
        )
    unit = None if device is None else load_device(device)
    sound = [one for one in found if one.is_sound is not False]
    if len(sound) < LEAST:
        raise CallError("fewer than two of the runs were sound; there is no history")
    wanted = inputs.required
    _check_limits(wanted, unit)
    limits = {
        (x.output.owner, x.output.quantity, x.output.axis): _Bound(
            size=x.limit,
            coverage=wanted.coverage_of(x),
            turn_ons=TURN_ONS[wanted.reference],
        )
        for x in (wanted.limits if wanted is not None else ())
    }
    has = [(one.name, one.keys) for one in sound]
    keys, left_out = common_keys(has, among=PARAMETERS)
    if not keys:
        raise CallError("the results have no parameter in common")
    level = LEVEL / len(keys)
    rows = [_row(key, sound, unit, limits.get(key), level) for key in keys]
    judged = {(x.sensor, x.parameter, x.axis) for x in rows if x.limit is not None}
    not_judged = [
        Name(q, owner=o, axis=a) for o, q, a in limits if (o, q, a) not in judged
    ]
    has_own = any(one.repeatability is not None for one in rows)
    lacks = [
        name
        for name in dict.fromkeys(
            Name(one.parameter, owner=one.sensor)
            for one in rows
            if one.repeatability is None
        )
        if unit is not None
    ]
    is_next = wanted is not None and wanted.reference == NEXT
    return CalibrationHistory(
        title=sound[-1].title,
        serial=sound[-1].serial,
        inputs=(
            *numbered_files("result", [one.file for one in found]),
            *input_files(() if unit is None else (unit,), requirement=wanted),
        ),
        parameters=tuple(rows),
        assumptions=(
            *((sentence("calibrations.with_turn_ons"),) if has_own else ()),
            *((sentence("calibrations.without_turn_ons"),) if unit is None else ()),
            *((sentence("calibrations.at_next_turn_on"),) if is_next else ()),
        ),
        warnings=(
            *said_of(found),
            *twice,
            *left_out,
            *([sentence("calibrations.lacks_turn_ons", names=lacks)] if lacks else []),
            *(
                [sentence("calibrations.limits_not_judged", names=by_group(not_judged))]
                if not_judged
                else []
            ),
            *(
                [sentence("calibrations.few_in_time", number=len(sound))]
                if len(sound) == LEAST
                else []
            ),
        ),
    )


def _check_limits(wanted: Requirement | None, unit: Device | None) -> None:
    """Refuse limits on errors that calibrations do not know.

    Raises
    ------
    CallError
        They are.
    """
    if wanted is None or wanted.reference == AS_TESTED:
        return
    if wanted.reference not in TURN_ONS:
        raise CallError(
            f"{wanted.name} limits errors of reference {wanted.reference}, and "
            "calibrations know their values against those during the run; give limits "
            f"of 'reference: {AS_TESTED}', or of '{NEXT}' with a device"
        )
    if unit is None:
        raise CallError(
            f"{wanted.name} limits errors of reference {wanted.reference}, of which "
            "calibrations know nothing without the repeatability of the unit; give its "
            f"data sheet (--device), or limits of 'reference: {AS_TESTED}'"
        )


def _files(results: Sequence[File]) -> Iterator[File]:
    """Yield results, of a folder all that are in it."""
    for one in results:
        path = Path(str(one))
        if path.is_dir():
            yield from sorted(path.glob(RESULT))
        else:
            yield one


def _day(result: CalibrationResult) -> Day:
    """Return the day of a run.

    Raises
    ------
    SpecError
        Nobody said it.
    """
    try:
        return Day.fromisoformat(result.date)
    except ValueError:
        message = (
            f"has the date {result.date!r}, expected one as 2026-05-31; give it when "
            "the run is calibrated (calibrate --date)"
        )
        raise refuse(result.name, message) from None


def _row(
    key: Key,
    results: Sequence[CalibrationResult],
    unit: Device | None,
    limit: _Bound | None,
    level: float,
) -> HistoryRow:
    """Return one parameter over time.

    Raises
    ------
    CallError
        It is in several units.
    """
    sensor, parameter, axis = key
    own, values, variances = in_one_unit(key, results, "runs")
    own_u = np.sqrt(variances)
    days = [_day(one) for one in results]
    times = np.array([(day - days[0]).days / YEAR for day in days])
    last = values[-1]
    size: float | None = None  # of a relative one, in counts
    if "counts" not in own:
        size = size_of(own)
    elif last != 0.0:
        size = 1.0 / abs(float(last))
    line = None if unit is None else _turn_on(unit, key)
    R = None if line is None or size is None else _of_axis(line, key) / size
    u = np.hypot(own_u, R or 0.0)
    factors = [
        one.expanded[one.keys.index(key)] / at if at > 0.0 else 0.0
        for one, at in zip(results, own_u, strict=True)
    ]
    fitted = drift_of(times, values, u)
    slope, reach = fitted.slope, fitted.reach
    ageing = None if unit is None or size is None else _ageing(unit, key, size)
    ends = None if reach is None else (slope - reach, slope + reach)
    drifts = fitted.p is not None and fitted.p < level
    is_0 = ends is None or ends[0] <= 0.0 <= ends[1]
    least = 0.0 if ends is None or is_0 else min(map(abs, ends))
    allowed = left = None
    if limit is not None and size is not None and "counts" not in own and ends:
        newest = results[-1]
        nu = float(newest.degrees_of_freedom[newest.keys.index(key)])
        U = limit.expanded(float(own_u[-1]), nu, R, line)
        if U is not None:
            allowed = limit.size / size
            left = max(allowed - U, 0.0)
    farthest = 0.0 if ends is None else max(map(abs, ends))
    return HistoryRow(
        sensor=sensor,
        parameter=parameter,
        axis=axis,
        unit=own,
        values=tuple(
            CalibratedValue(
                name=one.name,
                date=one.date,
                time=float(t),
                value=float(x),
                standard_uncertainty=_known(float(at)),
                expanded=_known(float(k * at)),
            )
            for one, t, x, at, k in zip(results, times, values, u, factors, strict=True)
        ),
        repeatability=R,
        drift=slope,
        drift_low=None if ends is None else ends[0],
        drift_high=None if ends is None else ends[1],
        scatter=fitted.scatter,
        p=fitted.p,
        standing=NOT_TOLD if fitted.p is None else DRIFTS if drifts else STEADY,
        ageing=ageing,
        is_older=ageing is not None and least > OLDER * ageing,
        limit=allowed,
        reaches=_time(left, abs(slope)) if drifts else None,
        earliest=_time(left, farthest),
    )


def _known(x: float) -> float | None:
    """Return a number; None of nan."""
    return x if isfinite(x) else None


def _time(left: float | None, drift: float) -> float | None:
    """Return when a drift has taken what is left [years]; None where it never has."""
    if left is None or drift <= left / LONGEST:
        return None
    return left / drift


@dataclass(frozen=True, kw_only=True)
class _Bound:
    """A limit on the error of a parameter [SI], and which errors it is on.

    Attributes
    ----------
    turn_ons : int
        How often a repeatability counts in their variance.
    """

    size: float
    coverage: float
    turn_ons: int

    def expanded(
        self, u: float, nu: float, R: float | None, line: Given | None
    ) -> float | None:
        """Return U by the fewest degrees of freedom; None where it is not known."""
        from scipy.special import stdtrit

        if (self.turn_ons and (R is None or line is None)) or not isfinite(u):
            return None
        if self.turn_ons and line is not None:
            nu = min(nu, *(x for x in line.degrees_of_freedom if x is not None), inf)
        p = (1.0 + self.coverage) / 2.0
        k = float(stdtrit(min(max(floor(min(nu, MANY)), 1), MANY), p))
        return k * sqrt(u**2 + self.turn_ons * (R or 0.0) ** 2)


@dataclass(frozen=True, kw_only=True)
class StraightLine:
    """A line through values in time: slope, 95 % to both sides, scatter, p of 0."""

    slope: float
    reach: float | None
    scatter: float | None
    p: float | None


def drift_of(times: Array, values: Array, u: Array) -> StraightLine:
    """Fit a straight line.

    By Student's t of n - 2 whatever the scatter: one that happens to be small is no
    proof that u is known.

    Parameters
    ----------
    times, values, u : ndarray, shape (n,)
        Of the values; u may be 0 of what is exact. Where one is nan nothing is told.

    Raises
    ------
    CallError
        All are of one day.
    """
    from scipy.special import stdtr, stdtrit

    if np.ptp(times) <= 0.0:
        raise CallError("all calibrations are of one day; there is no drift to tell")
    is_known = bool(np.isfinite(u).all())
    if not is_known:
        u = np.zeros(len(u))
    size = max(float(np.ptp(values)), float(u.max())) or 1.0
    y, s = (values - values.mean()) / size, u / size
    nu = len(times) - LEAST
    more = LEAST_SCATTER if nu <= 0 else _more(times, y, s)
    slope, _, u_slope = _line(times, y, s, more)
    _, square, first_u = _line(times, y, s, LEAST_SCATTER)
    slope *= size
    if not is_known or nu <= 0:
        reach = OLDER * first_u * size if is_known else None
        return StraightLine(slope=slope, reach=reach, scatter=None, p=None)
    return StraightLine(
        slope=slope,
        reach=float(stdtrit(nu, 0.975)) * u_slope * size,
        scatter=sqrt(square / nu) if (u > 0.0).all() else None,
        p=2.0 * float(stdtr(nu, -abs(slope / size) / u_slope)),
    )


def _line(times: Array, y: Array, u: Array, more: float) -> tuple[float, float, float]:
    """Return slope, chi-square and u of the slope, of variances u^2 + more^2."""
    w = 1.0 / (u**2 + more**2)
    middle = (w * times).sum() / w.sum()
    mean = (w * y).sum() / w.sum()
    Q = float((w * (times - middle) ** 2).sum())
    slope = float((w * (times - middle) * (y - mean)).sum()) / Q
    left = y - mean - slope * (times - middle)
    return slope, float((w * left**2).sum()), 1.0 / sqrt(Q)


def _more(times: Array, y: Array, u: Array) -> float:
    """Return t with which chi-square is no more than its degrees of freedom."""
    from scipy.optimize import brentq

    nu = len(times) - LEAST

    def over(log_t: float) -> float:
        return _line(times, y, u, exp(log_t))[1] / nu - 1.0

    low, high = log(LEAST_SCATTER), log(MOST_SCATTER)
    if over(low) <= 0.0:
        return LEAST_SCATTER
    return exp(float(brentq(over, low, high, xtol=1e-14, rtol=1e-14)))


def _turn_on(unit: Device, key: Key) -> Given | None:
    """Return the repeatability of a parameter by its data sheet; None: it has none."""
    sensor, parameter, _ = key
    own = next((one for one in unit.sensors if one.kind == sensor), None)
    for line in () if own is None else own.lines:
        effect = source_of(sensor, line.name).meant(line).effect
        is_shape = isinstance(effect, Nonlinearity)
        if isinstance(effect, Offset) and not is_shape and effect.target == parameter:
            return line
    return None


def _of_axis(line: Given, key: Key) -> float:
    """Return the standard uncertainty of a line on one axis [SI]."""
    axes = PARAMETERS[key[1]]
    return float(np.broadcast_to(np.abs(line.u), (len(axes),))[axes.index(key[2])])


def _ageing(unit: Device, key: Key, size: float) -> float | None:
    """Return what a year adds to a parameter by its data sheet, 1 sigma; else None."""
    sensor, parameter, axis = key
    own = next((one for one in unit.sensors if one.kind == sensor), None)
    line = None if own is None else own.line(AGEING.get(parameter, ""))
    if line is None or len(axis) > 1:
        return None
    u = np.broadcast_to(np.abs(line.u), (3,))["xyz".index(axis)]
    grown = growth(line, YEAR * 86400.0)
    return float(u * grown / size) if grown < inf else None
