"""Calibrations of one unit over time: drift with its interval, and what it reaches.

A straight line is fitted to the values of each parameter, weighed by their variances:
of N values with residuals r, chi-square sum (r/u)^2 has N - 2 degrees of freedom. Where
that is more, they scatter by more than they are known to (each turn-on is another one),
and all u are taken times its root over those degrees (Birge), with Student's t.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date as Day  # noqa: N812 - one word with one meaning
from math import inf, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from budget.documents import Documented, written
from budget.errors import CallError
from budget.inputs import load_device
from budget.inputs.reader import refuse
from budget.model.sources.later import AGEING, growth
from budget.names import PARAMETERS
from budget.recordings.results import LEVEL, read_result
from budget.results import InputFile, input_files
from budget.sentences import sentence
from budget.settings import Asked, Inputs, asking
from budget.units import size_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.files import File
    from budget.inputs.records import Device
    from budget.recordings.results import CalibrationResult, Key

YEAR = 365.25  # [days]
LEAST = 2  # calibrations of which there is a drift
DRIFTS, STEADY, NOT_TOLD = "drifts", "steady", "not told"
OLDER = 1.959964  # normal, of 95 %
RESULT = "*.json"


@written(
    "calibrated_value",
    """
    name: of the result
    date
    time [years]: since the first
    value / unit [unit]
    expanded / unit [unit]: U = k u
    """,
)
@dataclass(frozen=True, kw_only=True)
class CalibratedValue(Documented):
    """One value of a parameter in time."""

    name: str
    date: str
    time: float
    value: float
    expanded: float


@written(
    "history_row",
    """
    sensor: 'gyro' or 'accelerometer'
    parameter
    axis
    unit
    values not in CSV
    drift [unit/year]: slope of the straight line
    drift_low [unit/year]: of its interval at 95 %
    drift_high [unit/year]
    scatter [1]: of the values about it, over what they are known to; null of two
    p or null [1]: probability of as large a slope where nothing drifts; null of two
      values, whose scatter nobody knows
    standing: 'drifts' where p is below 5 % over all parameters, 'not told' without p,
      else 'steady'
    ageing [unit]: standard uncertainty of what a year adds, by the data sheet;
      null where none says it
    is_older: whether it drifts more than the data sheet says, at 95 %
    limit [unit]: on its error; null where there is none
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
    drift: float
    drift_low: float
    drift_high: float
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
        Data sheet, whose ageing drifts are held against.

    Returns
    -------
    CalibrationHistory

    Raises
    ------
    SpecError
        A file is no result.
    CallError
        They are fewer than two, of several units, or without dates.
    """
    found = sorted((read_result(one) for one in _files(results)), key=_day)
    if len(found) < LEAST:
        raise CallError(
            f"{len(found)} result of a calibration is given, expected 2 or more, or a "
            "folder of them"
        )
    serials = {one.serial for one in found}
    if len(serials) > 1:
        listed = ", ".join(sorted(serials))
        raise CallError(
            f"the results are of several units ({listed}); give those of one"
        )
    unit = None if device is None else load_device(device)
    sound = [one for one in found if one.is_sound is not False]
    if len(sound) < LEAST:
        raise CallError("fewer than two of the runs were sound; there is no history")
    limits = {}
    wanted = inputs.required
    if wanted is not None:
        limits = {
            (x.output.owner, x.output.quantity, x.output.axis): x.limit
            for x in wanted.limits
        }
    keys = [
        key
        for key in sound[0].keys
        if key[1] in PARAMETERS and all(key in one.keys for one in sound)
    ]
    if not keys:
        raise CallError("the results have no parameter in common")
    level = LEVEL / len(keys)
    rows = [_row(key, sound, unit, limits.get(key), level) for key in keys]
    unsound = [one.name for one in found if one not in sound]
    return CalibrationHistory(
        title=sound[-1].title,
        serial=sound[-1].serial,
        inputs=(
            *(
                InputFile(role=f"result {k}", name=one.name, sha256=one.sha256)
                for k, one in enumerate(found, start=1)
            ),
            *input_files(() if unit is None else (unit,), requirement=wanted),
        ),
        parameters=tuple(rows),
        warnings=(
            *(sentence("calibrations.unsound", name=name) for name in unsound),
            *(
                [sentence("calibrations.few_in_time", number=len(sound))]
                if len(sound) == LEAST
                else []
            ),
        ),
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
    limit: float | None,
    level: float,
) -> HistoryRow:
    """Return one parameter over time.

    Raises
    ------
    CallError
        It is in several units.
    """
    sensor, parameter, axis = key
    places = [one.keys.index(key) for one in results]
    units = {one.units[k] for one, k in zip(results, places, strict=True)}
    if len(units) > 1:
        raise CallError(
            f"{sensor} {parameter} {axis} is in {' and in '.join(sorted(units))}; "
            "calibrate all runs with, or without, a gain"
        )
    own = units.pop()
    days = [_day(one) for one in results]
    times = np.array([(day - days[0]).days / YEAR for day in days])
    values = np.array([one.values[k] for one, k in zip(results, places, strict=True)])
    pairs = list(zip(results, places, strict=True))
    u = np.array([sqrt(one.covariance[k, k]) for one, k in pairs])
    expanded = np.array([one.expanded[k] for one, k in pairs])
    fitted = drift_of(times, values, u)
    slope, reach = fitted.slope, fitted.reach
    size = 1.0 if "counts" in own else size_of(own)
    ageing = None if unit is None else _ageing(unit, key, size)
    ends = slope - reach, slope + reach
    drifts = fitted.p is not None and fitted.p < level
    least = 0.0 if ends[0] <= 0.0 <= ends[1] else min(map(abs, ends))
    allowed = None if limit is None or size == 1.0 else limit / size
    left = None if allowed is None else max(allowed - float(expanded[-1]), 0.0)
    farthest = max(map(abs, ends))
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
                expanded=float(U),
            )
            for one, t, x, U in zip(results, times, values, expanded, strict=True)
        ),
        drift=slope,
        drift_low=ends[0],
        drift_high=ends[1],
        scatter=fitted.scatter,
        p=fitted.p,
        standing=NOT_TOLD if fitted.p is None else DRIFTS if drifts else STEADY,
        ageing=ageing,
        is_older=ageing is not None and least > OLDER * ageing,
        limit=allowed,
        reaches=left / abs(slope) if left is not None and drifts else None,
        earliest=left / farthest if left is not None and farthest > 0.0 else None,
    )


@dataclass(frozen=True, kw_only=True)
class StraightLine:
    """A line through values in time: slope, 95 % to both sides, scatter, p of 0."""

    slope: float
    reach: float
    scatter: float | None
    p: float | None


def drift_of(times: Array, values: Array, u: Array) -> StraightLine:
    """Fit a straight line.

    By Student's t of n - 2, with the root of chi-square over n - 2 (Birge) where that
    is above 1: a scatter that happens to be small is no proof that it is known.

    Parameters
    ----------
    times, values, u : ndarray, shape (n,)
        Of the values; u above 0.

    Raises
    ------
    CallError
        All are of one day.
    """
    from scipy.special import stdtr, stdtrit

    if np.ptp(times) <= 0.0:
        raise CallError("all calibrations are of one day; there is no drift to tell")
    w = 1.0 / np.maximum(u, np.finfo(float).tiny) ** 2
    middle = (w * times).sum() / w.sum()
    mean = (w * values).sum() / w.sum()
    Q = float((w * (times - middle) ** 2).sum())
    slope = float((w * (times - middle) * (values - mean)).sum()) / Q
    nu = len(times) - LEAST
    u_slope = 1.0 / sqrt(Q)
    if nu <= 0:
        return StraightLine(slope=slope, reach=OLDER * u_slope, scatter=None, p=None)
    left = values - mean - slope * (times - middle)
    scatter = sqrt(float((w * left**2).sum()) / nu)
    u_slope *= max(1.0, scatter)
    return StraightLine(
        slope=slope,
        reach=float(stdtrit(nu, 0.975)) * u_slope,
        scatter=scatter,
        p=2.0 * float(stdtr(nu, -abs(slope) / u_slope)),
    )


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
