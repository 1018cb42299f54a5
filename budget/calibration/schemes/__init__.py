"""Calibration schemes: what a procedure file means as windows and weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from math import isclose
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.saturation import beyond, peaks_of_test
from budget.calibration.schemes import zhao_2019
from budget.calibration.schemes.covariance import covariances_of, noise_of
from budget.calibration.schemes.least_squares import scheme_by_least_squares
from budget.calibration.schemes.norm import scheme_by_norm
from budget.calibration.schemes.rotation import scheme_by_rotation
from budget.errors import CallError
from budget.inputs.records import FACTORY, UNCALIBRATED
from budget.model.estimators import NORM, PLAIN, WEIGHTED, estimator_of
from budget.model.norm import NormScheme
from budget.model.response import SIGN, STATISTICS, statistics_of
from budget.model.rotation import RotationScheme
from budget.model.scheme import Held, Scheme
from budget.model.source import ACCELEROMETER, GYRO
from budget.model.sources import source_of
from budget.model.sources.rotation import AZIMUTH
from budget.model.windows import Schedule
from budget.names import ORDERS, PARAMETERS, Name, every_output, parameters_of
from budget.sentences import described, sentence

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.calibration.saturation import Peak
    from budget.inputs.records import ErrorLine, Procedure, Sensor
    from budget.model.windows import Window

SAME_LENGTH = 1e-6  # of the length of a turn [1]


def schemes_of(
    sensors: Sequence[Sensor], procedure: Procedure, *, every: bool = False
) -> dict[str, Scheme]:
    """Return windows and weights of triads by kind, with what each needs of another.

    With `every` those of triads that the procedure does not calibrate, too: none.

    Raises
    ------
    CallError
        The test takes an axis beyond its range, or its windows cannot tell some
        parameters apart.
    """
    if refused := refusals(sensors, procedure):
        raise CallError("\n".join(refused))
    found = {
        one.kind: scheme_of(one.kind, procedure, one)
        if calibrates(one.kind, procedure) or not every
        else _of_design(one, procedure)
        for one in sensors
    }
    gyro, norm = found.get(GYRO), found.get(ACCELEROMETER)
    if isinstance(gyro, RotationScheme) and isinstance(norm, NormScheme):
        found[ACCELEROMETER] = norm.beside(gyro.directions)
    return found


def refusals(sensors: Sequence[Sensor], procedure: Procedure) -> tuple[str, ...]:
    """Say which axes a procedure takes beyond their range, and what to do; () if none.

    Where nobody calibrates there is no test.
    """
    return tuple(
        sentence(
            "saturation.untestable",
            device=found.device,
            procedure=procedure.name,
            peak=found.peak,
            range=found.range_shown,
        )
        for one in sensors
        if one.range is not None and calibrates(one.kind, procedure)
        if (found := beyond(one, _peaks(one.kind, procedure))) is not None
    )


@lru_cache(maxsize=64)
def _peaks(owner: str, procedure: Procedure) -> tuple[Peak, ...]:
    """Return the largest input of each axis of a triad in a test, for all devices."""
    return peaks_of_test(owner, schedule_of(owner, procedure), procedure.place)


@lru_cache(maxsize=64)
def largest_of_test(owner: str, procedure: Procedure) -> Peak:
    """Return the largest input of a triad in the windows of a test, for all devices."""
    peaks = peaks_of_test(owner, scheme_of(owner, procedure).schedule, procedure.place)
    return max(peaks, key=lambda peak: peak.size)


def is_beside(procedure: Procedure) -> bool:
    """Whether a gyro is calibrated by what accelerometers beside it show."""
    estimator = estimator_of(procedure.formulas)
    return not estimator.knows_attitudes and calibrates(GYRO, procedure)


def with_accelerometers(
    sensors: Sequence[Sensor], procedure: Procedure
) -> tuple[Sensor, ...]:
    """Return triads, with the accelerometers that a gyro alone is found beside.

    Raises
    ------
    CallError
        It needs them, and its device has none.
    """
    if not is_beside(procedure) or [one.kind for one in sensors] != [GYRO]:
        return tuple(sensors)
    (gyro,) = sensors
    if gyro.beside is None:
        raise CallError(
            f"{procedure.name} finds a gyro by what accelerometers beside it show, "
            f"and {gyro.device} has none; give a device with both, or one with "
            "accelerometers too, or a procedure with another estimator"
        )
    return (gyro, gyro.beside)


def scheme_of(owner: str, procedure: Procedure, sensor: Sensor | None = None) -> Scheme:
    """Return windows and weights of one triad.

    Parameters
    ----------
    owner : str
        'gyro' or 'accelerometer'.
    procedure : Procedure
        Windows or the paper's tests, the place, the estimator.
    sensor : Sensor, optional
        Whose noise the estimator `weighted` weighs by, and whose nominal values stand
        for parameters that are held; without it there is no noise, and they are 0.

    Raises
    ------
    CallError
        The windows cannot tell some parameters apart.
    """
    is_own = estimator_of(procedure.formulas).is_of_device or any(
        name.owner == owner for name in procedure.held
    )
    return _scheme_of(owner, procedure, sensor if is_own else None)


@lru_cache(maxsize=64)
def _scheme_of(owner: str, procedure: Procedure, sensor: Sensor | None) -> Scheme:
    """Return a scheme; without what depends on the device thousands share a few."""
    if procedure.formulas not in SCHEMES:
        return zhao_2019.scheme_of(owner, procedure)
    schedule, held = schedule_of(owner, procedure), held_of(owner, procedure, sensor)
    return SCHEMES[procedure.formulas](owner, schedule, procedure, held, sensor)


def _by_least_squares(
    owner: str,
    schedule: Schedule,
    procedure: Procedure,
    held: Held,
    sensor: Sensor | None,
) -> Scheme:
    """Return least squares, of windows alike or weighed by the noise of a device."""
    covariances = None
    weighs_noise = estimator_of(procedure.formulas).weighs_noise
    if weighs_noise and sensor and noise_of(owner, sensor.lines):
        covariances = covariances_of(sensor, procedure, schedule, held)
    return scheme_by_least_squares(
        owner,
        schedule,
        procedure,
        covariances,
        held if held.which.any() else None,
        orders=orders_of(owner, procedure),
    )


def _by_norm(
    owner: str,
    schedule: Schedule,
    procedure: Procedure,
    held: Held,
    sensor: Sensor | None,
) -> Scheme:
    """Return accelerometers by the norm of gravity, gyros by what these show."""
    if owner == ACCELEROMETER:
        return scheme_by_norm(owner, schedule, procedure, held)
    steps = tuple(step for one in schedule.windows for step in one.steps)
    return scheme_by_rotation(
        replace(schedule, windows=steps),
        procedure,
        held,
        beside=schedule_of(ACCELEROMETER, procedure),
        values=held_of(ACCELEROMETER, procedure, sensor and sensor.beside).value,
    )


# What each of budget.model.estimators makes of windows.
Maker = Callable[[str, Schedule, "Procedure", Held, "Sensor | None"], Scheme]
SCHEMES: dict[str, Maker] = {
    PLAIN: _by_least_squares,
    WEIGHTED: _by_least_squares,
    NORM: _by_norm,
}


@lru_cache(maxsize=64)
def schedule_of(owner: str, procedure: Procedure) -> Schedule:
    """Return the windows of one triad, on the clock of the procedure.

    Raises
    ------
    CallError
        No window is the triad's.
    """
    if not procedure.windows:
        return zhao_2019.schedule_of(owner, procedure)
    own = tuple(one for one in procedure.windows if one.use in {owner, "both"})
    if not own:
        raise CallError(
            f"{procedure.name}: no window is of the {owner}; let one be used by it "
            f"(use: {owner}, or both), or give a device without {owner}"
        )
    others = tuple(one for one in procedure.windows if one.use not in {owner, "both"})
    return Schedule(windows=own, others=others)


@lru_cache(maxsize=64)
def windows_of(procedure: Procedure) -> tuple[Window, ...]:
    """Return all windows of a test in their order, on one clock.

    Of the paper's tests those of the gyro stand before those of the accelerometers.
    """
    if procedure.windows:
        return procedure.windows
    gyro = zhao_2019.schedule_of(GYRO, procedure).windows
    other = zhao_2019.schedule_of(ACCELEROMETER, procedure)
    if other.others:  # on one clock already, dwells read by both
        dwells = {one.start for one in other.windows}
        return tuple(
            replace(one, use="both" if one.start in dwells else GYRO) for one in gyro
        )
    begin = gyro[-1].end + procedure.gyro.pause
    return (
        *(replace(one, use=GYRO) for one in gyro),
        *(
            replace(one, use=ACCELEROMETER, start=one.start + begin)
            for one in other.windows
        ),
    )


def as_recorded(procedure: Procedure, windows: tuple[Window, ...]) -> Procedure:
    """Return a procedure with its windows as they were, by start and length.

    The paper's formulas are of windows as they should be: where a turn took another
    time than that, least squares stand in their place.
    """
    is_same = all(
        isclose(one.length, other.length, rel_tol=SAME_LENGTH)
        for one, other in zip(windows, windows_of(procedure), strict=True)
        if one.sense
    )
    if procedure.formulas in SCHEMES:
        return replace(procedure, windows=windows)
    if is_same:
        return procedure
    return replace(procedure, windows=windows, formulas=PLAIN)


def removal(name: Name, procedure: Procedure) -> str:
    """Return what makes a source cancel in a test that is good at it; '' if nothing."""
    effect = source_of(name.owner, name.quantity).effect
    knows_attitudes = estimator_of(procedure.formulas).knows_attitudes
    place = effect.removed if knows_attitudes else effect.removed_by_norm
    if procedure.azimuth and effect == AZIMUTH:
        place = "sources.no_azimuth"
    return described(place)


def estimated(owner: str, procedure: Procedure) -> tuple[Name, ...]:
    """Return the parameters of a triad that a procedure estimates; () without any."""
    if not calibrates(owner, procedure):
        return ()
    orders = orders_of(owner, procedure)
    return tuple(
        name
        for name in every_output(owner)
        if (name.quantity in PARAMETERS and name not in procedure.held)
        or ORDERS.get(name.quantity) in orders
    )


def initial_lines(sensor: Sensor, procedure: Procedure) -> tuple[ErrorLine, ...]:
    """Return what a new unit has of parameters that are held at the design.

    A maker who has calibrated it has found that.
    """
    if procedure.formulas == FACTORY:
        return ()
    found = {*estimated(sensor.kind, procedure)}
    held = {one.quantity for one in parameters_of(sensor.kind) if one not in found}
    return tuple(
        line for line in sensor.initial if source_of(sensor.kind, line.name).own in held
    )


def answered(owner: str, procedure: Procedure) -> tuple[Name, ...]:
    """Return the parameters of a triad whose errors are known: held ones too."""
    found = estimated(owner, procedure)
    return (*parameters_of(owner), *(one for one in found if one.quantity in ORDERS))


def orders_of(owner: str, procedure: Procedure) -> tuple[int, ...]:
    """Return the higher orders that a procedure estimates of a triad."""
    return procedure.orders if owner == "accelerometer" else ()


def calibrates(owner: str, procedure: Procedure) -> bool:
    """Whether any window is of that triad; the paper's tests are of both."""
    if procedure.formulas in UNCALIBRATED:
        return False
    own = [one for one in procedure.windows if one.use in {owner, "both"}]
    if not estimator_of(procedure.formulas).knows_attitudes and owner == GYRO:
        return any(one.sense for one in own)  # no norm of the earth rate is that large
    return not procedure.windows or bool(own)


def _of_design(sensor: Sensor, procedure: Procedure) -> Scheme:
    """Return what is known of a triad without any test: all is held, W is empty."""
    return Scheme(
        owner=sensor.kind,
        schedule=Schedule(windows=()),
        place=procedure.place,
        weights=np.zeros((3, STATISTICS, 0)),
        held=held_of(sensor.kind, procedure, sensor),
    )


def held_of(owner: str, procedure: Procedure, sensor: Sensor | None) -> Held:
    """Return what a procedure holds of a triad, at the nominal values of a sensor."""
    names = parameters_of(owner)
    found = estimated(owner, procedure)
    held = np.array([name not in found for name in names])
    angle = np.zeros(6) if sensor is None else sensor.nominal_mounting_angle
    bias = np.zeros(3) if sensor is None else sensor.nominal_bias
    return Held(
        which=statistics_of(held[:3], held[3:9], held[9:]) != 0.0,
        value=statistics_of(np.ones(3), SIGN * angle, bias),
    )


__all__ = [
    "answered",
    "as_recorded",
    "calibrates",
    "estimated",
    "held_of",
    "initial_lines",
    "is_beside",
    "largest_of_test",
    "noise_of",
    "schedule_of",
    "scheme_of",
    "schemes_of",
    "windows_of",
    "with_accelerometers",
]
