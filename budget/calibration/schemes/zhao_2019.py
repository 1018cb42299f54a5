"""The discrete calibration of Zhao 2019: rate turns and four dwells, twelve dwells.

Gyro, eq. (3): n_ij, the + turn minus the - turn about axis j, is 4 pi n K_i times the
response; per second, the difference over twice the rate. Bias: the mean reading of the
static dwells less the response to the mean earth rate there (eq. (1), inverted). Or,
of twelve positions, the mean of the own axis up and down, each dwell turned by 180 deg
once: the earth rate drops out, and with it what of it, of the latitude and of the level
is not known; so does what an axis feels of gravity along itself.
Accelerometer, eq. (5): differences of up and down over 2 g, and the mean of the own
axis up and down. Misprints are mended: d_yx has no minus sign in eq. (3), eq. (5)
prints d_yz with N_x for N_y and d_xz under the name d_xy.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import accumulate, product
from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from budget.language import note
from budget.model.response import BIAS, STATISTICS
from budget.model.scheme import Scheme
from budget.model.windows import FLIPS, INNER, MIDDLE, OUTER, Schedule, Setting, Window
from budget.names import AXES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.inputs.records import AccelerometerProcedure, GyroProcedure, Procedure

FACE_ORDER = ("z", "x", "y")  # Zhao 2019, section 1.2.3: z up, z down, x up, ...
TABLE_AXES = (INNER, MIDDLE, OUTER)  # that turn about body x, y, z at table zero
# Azimuths that balance leave sums of sines of this size [1], by rounding.
BALANCED = 1e-14


def scheme_of(owner: str, procedure: Procedure) -> Scheme:
    """Return windows and weights of one triad.

    Parameters
    ----------
    owner : str
        'gyro' or 'accelerometer'.
    procedure : Procedure
        Turns and dwells, the place, the formulas.
    """
    if owner == "accelerometer":
        schedule = schedule_of(owner, procedure)
        return Scheme(
            owner=owner,
            schedule=schedule,
            place=procedure.place,
            timing=procedure.timing,
            weights=_accelerometer_weights(schedule, procedure.gravity),
        )
    schedule = schedule_of(owner, procedure)
    azimuths = procedure.gyro.azimuths
    mean_earth = _mean_earth(azimuths, procedure.place.earth) if azimuths else None
    return Scheme(
        owner=owner,
        schedule=schedule,
        place=procedure.place,
        timing=procedure.timing,
        weights=_gyro_weights(schedule, procedure.gyro.rate, mean_earth),
        rotated=mean_earth if procedure.formulas == "paper" else None,
    )


def schedule_of(owner: str, procedure: Procedure) -> Schedule:
    """Lay out the test of one triad, that of gyros before that of accelerometers.

    Where the gyro's bias is of twelve positions it is read in those of the other.
    """
    gyro = schedule_gyro(procedure.gyro)
    accelerometer = schedule_accelerometer(procedure.accelerometer)
    if not procedure.gyro.azimuths:  # dwells that both triads are read in, on one clock
        begin = gyro.windows[-1].end + procedure.gyro.pause
        dwells = tuple(
            replace(one, start=one.start + begin) for one in accelerometer.windows
        )
        if owner == "gyro":
            return Schedule(windows=(*gyro.windows, *dwells))
        return Schedule(windows=dwells, others=gyro.windows)
    if owner == "gyro":
        return replace(gyro, later=accelerometer.windows)
    return replace(accelerometer, before=gyro.windows)


@lru_cache(maxsize=16)
def schedule_gyro(procedure: GyroProcedure) -> Schedule:
    """Lay out the rate turns, + before -, then the dwells: Zhao 2019, 1.2.1, 1.2.2."""
    turn = 2.0 * pi * procedure.turns
    steps = [
        Window(
            name=f"turn {axis}{'+' if sign > 0 else '-'}",
            start=0.0,
            length=turn / procedure.rate,
            setting=Setting(turning=TABLE_AXES[AXES.index(axis)], angle=sign * turn),
            axis=AXES.index(axis),
            sign=sign,
        )
        for axis in procedure.order
        for sign in (1, -1)
    ]
    steps += [
        Window(
            name=f"azimuth {degrees(azimuth):.6g}",
            start=0.0,
            length=procedure.dwell,
            setting=Setting(outer=azimuth),
            azimuth=azimuth,
        )
        for azimuth in procedure.azimuths
    ]
    return _back_to_back(steps, procedure.pause)


@lru_cache(maxsize=16)
def schedule_accelerometer(procedure: AccelerometerProcedure) -> Schedule:
    """Lay out the twelve dwells, each face twice in a row: Zhao 2019, 1.2.3."""
    steps = []
    for axis in FACE_ORDER:
        for sign in (1, -1):
            for visit in (1, 2):  # the second time turned 180 deg about the vertical
                place = AXES.index(axis)
                steps.append(
                    Window(
                        name=note(
                            "{axis} up {visit}" if sign > 0 else "{axis} down {visit}",
                            axis=axis,
                            visit=visit,
                        ),
                        start=0.0,
                        length=procedure.dwell,
                        setting=Setting.face(
                            place,
                            sign,
                            pi * (visit - 1),
                            flip=FLIPS[procedure.flip_axis],
                        ),
                        axis=place,
                        sign=sign,
                    )
                )
    return _back_to_back(steps, procedure.pause)


def _back_to_back(steps: Sequence[Window], pause: float) -> Schedule:
    """Give each window its start; pauses lie between them."""
    starts = accumulate((step.length + pause for step in steps), initial=0.0)
    return Schedule(
        windows=tuple(
            replace(step, start=start)
            for step, start in zip(steps, starts, strict=False)
        )
    )


def _gyro_weights(schedule: Schedule, rate: float, mean_earth: Array | None) -> Array:
    """Return W of every axis, shape (3, 4, n): eqs. (3) and (1), or twelve dwells."""
    W = np.zeros((3, STATISTICS, len(schedule.windows)))
    turning = schedule.senses != 0.0
    for axis, sign in product(range(3), (1, -1)):
        places = np.array(schedule.pick(axis, sign))
        turns, dwells = places[turning[places]], places[~turning[places]]
        W[:, axis, turns] = sign * 0.5 / rate  # n_ij / (4 pi n), per second
        W[axis, BIAS, dwells] = 0.25
    if mean_earth is not None:
        W[:, BIAS, schedule.azimuths] = 1.0 / len(schedule.azimuths)
        W[:, BIAS] -= mean_earth @ W[0, :BIAS]
    return W


def _accelerometer_weights(schedule: Schedule, gravity: float) -> Array:
    """Return W of every axis, shape (3, 4, n): eq. (5), each face twice."""
    W = np.zeros((3, STATISTICS, len(schedule.windows)))
    for axis in range(3):
        up, down = schedule.pick(axis, 1), schedule.pick(axis, -1)
        W[:, axis, up], W[:, axis, down] = 0.25 / gravity, -0.25 / gravity
        W[axis, BIAS, up] = W[axis, BIAS, down] = 0.25
    return W


def _mean_earth(azimuths: tuple[float, ...], earth: Array) -> Array:
    """Return the earth rate in body axes, mean over the azimuths: Zhao 2019, 1.2.2."""
    east, north = float(np.mean(np.sin(azimuths))), float(np.mean(np.cos(azimuths)))
    return np.array(
        [
            0.0 if abs(east) < BALANCED else earth[1] * east,
            0.0 if abs(north) < BALANCED else earth[1] * north,
            earth[2],
        ]
    )
