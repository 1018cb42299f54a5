"""Turns and dwells of a longer test that would meet the limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial
from math import ceil, floor, log10, pi
from typing import TYPE_CHECKING

from budget.calibration.schemes import calibrates
from budget.inputs.station import with_age
from budget.model.sources.later import AGEING
from budget.studies.allocation.records import LongerTest, Recalibration
from budget.units import DAY, HOUR, YEAR, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.methods.allocation import Task
    from budget.methods.scaling import ScaledLaw
    from budget.studies.allocation.cases import SensorCase

MOST_TURNS = 1000  # at 20 deg/s five hours for each axis and sense
LONGEST_DWELL = 24.0 * HOUR  # [s]
STEP = 1.25  # from one trial to the next [1]
DIGITS = 3  # of a dwell that is found
ROUNDING = 1e-12  # of a number of turns, relative

AS_THEY_ARE = "devices as they are"
FLOOR = "what is held"


@dataclass(frozen=True, kw_only=True)
class _Setting:
    """One number of the procedure of one sensor, and how it is changed."""

    name: str
    now: float
    most: float
    change: Callable[[float], Procedure]
    whole: bool

    def after(self, value: float) -> float:
        """Return the next value to try."""
        more = min(value * STEP, self.most)
        return max(float(int(more)), value + 1.0) if self.whole else more


def find_longer_tests(case: SensorCase) -> tuple[LongerTest, ...]:
    """Find the least number of turns and the shortest dwell that meet the limits.

    For the devices as they are and for what is held alone, wherever these are not
    within their limits now. Each alone, the other things as they are; upwards from the
    present value, because shorter costs nothing to try by hand. A longer test is not
    always a better one (random walks grow), so what meets is searched step by step,
    then narrowed.
    """
    task = case.task
    goals = [
        (s, goal)
        for s, goal, law in (
            (task.now, AS_THEY_ARE, case.law),
            (task.least, FLOOR, case.least_law),
        )
        if largest_utilisation(task, law, s) > 1.0
    ]
    if not goals:
        return ()
    procedure = case.question.procedure
    settings = [
        (sensor.kind, setting)
        for sensor in case.question.sensors
        if calibrates(sensor.kind, procedure)
        for setting in _growing(sensor, procedure)
    ]
    of_noise = not case.is_tuned and _changes_noise(case)
    laws = [_changed_laws(case, setting, of_noise=of_noise) for _, setting in settings]
    return tuple(
        _grow(setting, partial(_used_of, case, law_at, s), kind, goal)
        for s, goal in goals
        for (kind, setting), law_at in zip(settings, laws, strict=True)
    )


def largest_utilisation(task: Task, law: ScaledLaw, s: Array) -> float:
    """Return the largest part of a limit that is used by another law.

    The sources have the factors `s`, shape (n_src,).
    """
    return float(replace(task, law=law).utilisation(s).max())


def _changes_noise(case: SensorCase) -> bool:
    """Whether a step of all settings together moves but the noise of the windows."""
    procedure = case.question.procedure
    for sensor in case.question.sensors:
        if calibrates(sensor.kind, procedure):
            for place in range(len(_growing(sensor, procedure))):
                setting = _growing(sensor, procedure)[place]
                procedure = setting.change(setting.after(setting.now))
    return case.law_of(case.task.now, procedure).is_like(case.retimed(procedure))


def _changed_laws(
    case: SensorCase, setting: _Setting, *, of_noise: bool
) -> Callable[[float, tuple[float, ...]], ScaledLaw]:
    """Return the law by a setting and what a filter knows; goals may ask for one."""

    @cache
    def law_at(value: float, known: tuple[float, ...]) -> ScaledLaw:
        if value == setting.now:
            return case.law if known == case.known(case.task.now) else case.least_law
        procedure = setting.change(value)
        return case.retimed(procedure) if of_noise else case.law_of(known, procedure)

    return law_at


def _used_of(
    case: SensorCase,
    law_at: Callable[[float, tuple[float, ...]], ScaledLaw],
    s: Array,
    value: float,
) -> float:
    """Return the largest part of a limit that is used at a value of a setting."""
    return largest_utilisation(case.task, law_at(value, case.known(s)), s)


def _growing(sensor: Sensor, procedure: Procedure) -> tuple[_Setting, ...]:
    """Return what of the procedure may grow for a sensor."""
    if procedure.windows:
        return tuple(_growing_windows(sensor.kind, procedure))
    own = procedure.accelerometer
    positions = _Setting(
        name="dwell",
        now=own.dwell,
        most=LONGEST_DWELL,
        change=lambda dwell: replace(
            procedure, accelerometer=replace(own, dwell=dwell)
        ),
        whole=False,
    )
    if sensor.kind != "gyro":
        return (positions,)
    gyro = procedure.gyro
    return (
        _Setting(
            name="turns",
            now=gyro.turns,
            most=MOST_TURNS,
            change=lambda turns: replace(
                procedure, gyro=replace(gyro, turns=int(turns))
            ),
            whole=True,
        ),
        _Setting(
            name="dwell",
            now=gyro.dwell,
            most=LONGEST_DWELL,
            change=lambda dwell: replace(procedure, gyro=replace(gyro, dwell=dwell)),
            whole=False,
        )
        if gyro.azimuths
        else positions,
    )


def _growing_windows(kind: str, procedure: Procedure) -> Iterator[_Setting]:
    """Yield turns and dwells of windows of one's own, all longer in proportion."""
    own = [one for one in procedure.windows if one.use in {kind, "both"}]
    turns = [abs(one.setting.angle) / (2.0 * pi) for one in own if one.sense]
    dwells = [one.length for one in own if not one.sense]
    if (
        round(max(turns, default=0.0)) and kind == "gyro"
    ):  # whole, no move between dwells
        yield _Setting(
            name="turns",
            now=float(round(max(turns))),
            most=MOST_TURNS,
            change=lambda most: _stretched(
                procedure, most / round(max(turns)), turning=True
            ),
            whole=True,
        )
    if dwells:
        yield _Setting(
            name="dwell",
            now=max(dwells),
            most=LONGEST_DWELL,
            change=lambda longest: _stretched(
                procedure, longest / max(dwells), turning=False
            ),
            whole=False,
        )


def _stretched(procedure: Procedure, factor: float, *, turning: bool) -> Procedure:
    """Make turns, or dwells, longer; pauses stay, what comes later begins later.

    Turns stay whole: of fewer turns than the most the number is rounded up.
    """
    windows, later = [], 0.0
    for one in procedure.windows:
        setting, length = one.setting, one.length
        if turning and one.sense:
            turns = round(abs(setting.angle) / (2.0 * pi))
            times = ceil(turns * factor * (1.0 - ROUNDING)) / turns
            setting = replace(setting, angle=setting.angle * times)
            length *= times
        elif not turning and not one.sense:
            length *= factor
        windows.append(
            replace(one, start=one.start + later, length=length, setting=setting)
        )
        later += length - one.length
    return replace(procedure, windows=tuple(windows))


def _grow(
    setting: _Setting,
    utilisation: Callable[[float], float],
    sensor: str,
    goal: str,
) -> LongerTest:
    """Step upwards until the limits are met, then narrow the last step."""
    below, value = setting.now, setting.now
    best, least = value, utilisation(value)
    needed = None
    while value < setting.most:
        below, value = value, setting.after(value)
        used = utilisation(value)
        if used < least:
            best, least = value, used
        if used <= 1.0:
            needed = _narrow(setting, utilisation, below, value)
            best, least = needed, utilisation(needed)
            break
    return LongerTest(
        sensor=sensor,
        name=setting.name,
        goal=goal,
        now=setting.now,
        needed=needed,
        tried_to=value,
        utilisation=least,
        best=best,
    )


def _narrow(
    setting: _Setting,
    utilisation: Callable[[float], float],
    fails: float,
    meets: float,
) -> float:
    """Return the least value that meets, to a whole number or three digits up."""
    step = 1.0 if setting.whole else 10.0 ** (floor(log10(meets)) - DIGITS + 1)
    while meets - fails > step:
        middle = (fails + meets) / 2.0
        middle = float(int(middle)) if setting.whole else middle
        if utilisation(middle) <= 1.0:
            meets = middle
        else:
            fails = middle
    rounded = step * -(-meets // step)
    meets_too = utilisation(rounded) <= 1.0
    return rounded if meets_too else meets


SOONEST, LATEST = DAY, 30.0 * YEAR  # [s]
ALLOCATED = "as allocated"


def find_recalibrations(case: SensorCase) -> tuple[Recalibration, ...]:
    """Find how old a calibration may be, with the lines as they are and as allocated.

    The age A at which the largest end of an interval, |m(A)| + k u(A), is at its limit,
    by the law of propagation. () where errors are not counted from a later turn-on, or
    nothing that is given ages.
    """
    ages = [
        name
        for name in AGEING.values()
        for sensor in case.question.sensors
        if sensor.line(name)
    ]
    if case.question.reference != "next_turn_on" or not ages:
        return ()
    states = [(AS_THEY_ARE, case.task.now)]
    if case.s is not None:
        states.append((ALLOCATED, case.s))
    # Both ask for the ends.
    laws = cache(lambda age, known: case.law_of(known, _aged(case, age)))
    return tuple(_find(case, laws, s, goal) for goal, s in states)


def _aged(case: SensorCase, age: float) -> Procedure:
    """Return the procedure of a calibration that is as old [s]."""
    return with_age(case.question.procedure, parse_quantity(f"{age!r} s", "s"))


def _find(
    case: SensorCase,
    laws: Callable[[float, tuple[float, ...]], ScaledLaw],
    s: Array,
    goal: str,
) -> Recalibration:
    """Look between a day and 30 years for the age at which the limits are reached."""

    def used(age: float) -> float:
        return largest_utilisation(case.task, laws(age, case.known(s)), s)

    age, utilisation = None, used(SOONEST)
    if utilisation <= 1.0:
        utilisation = used(LATEST)
        if utilisation > 1.0:
            from scipy.optimize import brentq

            age = float(brentq(lambda age: used(age) - 1.0, SOONEST, LATEST))
            utilisation = 1.0
    oldest = case.question.under(_aged(case, LATEST)).sensors
    return Recalibration(
        sensor=case.owner,
        goal=goal,
        age=age,
        utilisation=utilisation,
        not_given=tuple(name for one in oldest for name in one.expected_missing),
    )
