"""Turns and dwells of a longer test that would meet the limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor, log10
from typing import TYPE_CHECKING

from budget.calibration.problem import calibration_problem
from budget.methods.scaling import scaled_law
from budget.studies.allocation.records import LongerTest
from budget.units import HOUR

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array
    from budget.spec.records import Procedure, Sensor
    from budget.studies.allocation.cases import SensorCase

MOST_TURNS = 1000  # at 20 deg/s five hours for each axis and sense
LONGEST_DWELL = 24.0 * HOUR  # [s]
STEP = 1.25  # from one trial to the next [1]
DIGITS = 3  # of a dwell that is found

AS_THEY_ARE = "devices as they are"
FLOOR = "what is held"


@dataclass(frozen=True, kw_only=True)
class _Trials:
    """One number of the procedure of one sensor, and how it is changed."""

    name: str
    now: float
    most: float
    change: Callable[[float], Procedure]
    whole: bool


def find_longer_tests(
    case: SensorCase, s: Array, *, goal: str
) -> tuple[LongerTest, ...]:
    """Find the least number of turns and the shortest dwell that meet the limits.

    Each alone, the other things as they are; upwards from the present value, because
    shorter costs nothing to try by hand. A longer test is not always a better one
    (random walks grow), so what meets is searched step by step, then narrowed. The
    sources have the factors `s`, shape (n_src,), which stand for AS_THEY_ARE or FLOOR.
    """

    def utilisation(changed: Procedure) -> float:
        problem = calibration_problem(
            (case.sensor,), changed, reference=case.requirement.reference
        )
        law = scaled_law(problem).select(case.task.law.outputs)
        return float(replace(case.task, law=law).utilisation(s).max())

    return tuple(
        _grow(trials, utilisation, case.sensor.kind, goal)
        for trials in _growing(case.sensor, case.procedure)
    )


def _growing(sensor: Sensor, procedure: Procedure) -> tuple[_Trials, ...]:
    """Return what of the procedure may grow for a sensor; windows are the user's."""
    if procedure.windows:
        return ()
    if sensor.kind != "gyro":
        own = procedure.accelerometer
        return (
            _Trials(
                name="dwell",
                now=own.dwell,
                most=LONGEST_DWELL,
                change=lambda dwell: replace(
                    procedure, accelerometer=replace(own, dwell=dwell)
                ),
                whole=False,
            ),
        )
    gyro = procedure.gyro
    return (
        _Trials(
            name="turns",
            now=gyro.turns,
            most=MOST_TURNS,
            change=lambda turns: replace(
                procedure, gyro=replace(gyro, turns=int(turns))
            ),
            whole=True,
        ),
        _Trials(
            name="dwell",
            now=gyro.dwell,
            most=LONGEST_DWELL,
            change=lambda dwell: replace(procedure, gyro=replace(gyro, dwell=dwell)),
            whole=False,
        ),
    )


def _grow(
    trials: _Trials,
    utilisation: Callable[[Procedure], float],
    sensor: str,
    goal: str,
) -> LongerTest:
    """Step upwards until the limits are met, then narrow the last step."""
    below, value = trials.now, trials.now
    best, least = value, utilisation(trials.change(value))
    needed = None
    while value < trials.most:
        below, value = value, min(value * STEP, trials.most)
        if trials.whole:
            value = max(float(int(value)), below + 1.0)
        used = utilisation(trials.change(value))
        if used < least:
            best, least = value, used
        if used <= 1.0:
            needed = _narrow(trials, utilisation, below, value)
            best, least = needed, utilisation(trials.change(needed))
            break
    return LongerTest(
        sensor=sensor,
        name=trials.name,
        goal=goal,
        now=trials.now,
        needed=needed,
        tried_to=value,
        utilisation=least,
        best=best,
    )


def _narrow(
    trials: _Trials,
    utilisation: Callable[[Procedure], float],
    fails: float,
    meets: float,
) -> float:
    """Return the least value that meets, to a whole number or three digits up."""
    step = 1.0 if trials.whole else 10.0 ** (floor(log10(meets)) - DIGITS + 1)
    while meets - fails > step:
        middle = (fails + meets) / 2.0
        middle = float(int(middle)) if trials.whole else middle
        if utilisation(trials.change(middle)) <= 1.0:
            meets = middle
        else:
            fails = middle
    rounded = step * -(-meets // step)
    meets_too = utilisation(trials.change(rounded)) <= 1.0
    return rounded if meets_too else meets
