"""Calibration scheme of a gyro that is turned between dwells at unknown attitudes."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.measured import FreeSetting
from budget.model.norm import shown_of_errors
from budget.model.response import BIAS
from budget.model.rotation import RotationLeg, RotationScheme, rotation, sensitivities
from budget.model.scheme import not_told_apart
from budget.names import parameters_of

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Procedure
    from budget.model.scheme import Held
    from budget.model.windows import Schedule

CONTINUOUS = 1e-9  # what an attitude that a turn leads to may be off by [1]
# Found with the parameters where nobody knows the azimuth.
LEVEL = "the earth rate to the east", "the earth rate to the north"


def legs_of(gyro: Schedule, accelerometer: Schedule) -> tuple[RotationLeg, ...]:
    """Return the ways between dwells of the accelerometers that a gyro watches.

    Raises
    ------
    CallError
        A turn leads to another attitude than the dwell after it has, where these are
        nominal; those that were measured are off by errors.
    """
    found = []
    dwells, turned = accelerometer.windows, gyro.turned
    places, turns = np.flatnonzero(gyro.senses).tolist(), rotation(-turned)
    for k, (before, after) in enumerate(pairwise(dwells)):
        steps = tuple(
            place
            for place in places
            if before.start < gyro.windows[place].start < after.start
        )
        if not steps:
            continue
        attitude = before.setting.to_body
        for place in steps:
            attitude = turns[place] @ attitude
        is_measured = isinstance(after.setting, FreeSetting)
        off = np.abs(attitude - after.setting.to_body).max()
        if not is_measured and off > CONTINUOUS:
            raise CallError(
                f"the turns after the dwell {before.name} lead to another attitude "
                f"than the next, {after.name}, has; let them follow one another"
            )
        found.append(RotationLeg(first=k, last=k + 1, steps=steps))
    return tuple(found)


def scheme_by_rotation(
    schedule: Schedule,
    procedure: Procedure,
    held: Held,
    *,
    beside: Schedule,
    values: Array,
) -> RotationScheme:
    """Return windows and weights of a triad of gyros.

    Parameters
    ----------
    schedule : Schedule
        Dwells, and turns in steps; attitudes are nominal, known only roughly.
    procedure : Procedure
        The place.
    held : Held
        What is not estimated.
    beside : Schedule
        Dwells of the accelerometers.
    values : ndarray, shape (3, 4)
        Their design values, as of Held.

    Raises
    ------
    CallError
        The turns cannot tell some parameters apart: which; or they lead elsewhere.
    """
    earth, gravity = procedure.place.earth, procedure.place.force
    legs, turned = legs_of(schedule, beside), schedule.turned
    down = beside.to_body @ gravity / procedure.gravity
    by_rate, by_direction = sensitivities(schedule.lengths, turned, down, legs)
    shown = shown_of_errors(schedule.rates + schedule.to_body @ earth, held.value)
    J = np.einsum("rwi,wip->rp", by_rate, shown)
    estimated = held.estimated
    names = [parameters_of("gyro")[k] for k in estimated]
    longest = schedule.lengths.max()
    size = np.where([name.quantity == "bias" for name in names], 1.0 / longest, 1.0)
    unknown = LEVEL if procedure.place.azimuth is None else ()
    level = np.einsum("rwi,wij->rj", by_rate, schedule.to_body[..., : len(unknown)])
    found = np.hstack([J[:, estimated] * size, level / longest])
    if mixed := not_told_apart(found, [*(n.without_owner for n in names), *unknown]):
        raise CallError(
            f"{procedure.name}, gyro: the turns between these dwells cannot tell "
            f"apart: {mixed}. A turn shows in the directions of gravity only where it "
            "is not about the vertical: turn about each body axis while it is level, "
            "or hold a parameter (estimate: names the others)"
        )
    W = np.zeros((12, len(J)))
    W[estimated] = np.linalg.pinv(found)[: len(estimated)] * size[:, None]
    others = np.setdiff1d(np.arange(12), estimated)
    from_held = np.zeros((12, 12))
    from_held[:, others] = -W @ J[:, others]
    from_held[others, others] = 1.0
    directions = -np.einsum("kr,rwi->kwi", W, by_direction)
    theirs = shown_of_errors(beside.to_body @ gravity, values) / procedure.gravity
    return RotationScheme(
        owner="gyro",
        schedule=schedule,
        place=procedure.place,
        timing=procedure.timing,
        weights=_of_axes(-np.einsum("kr,rwi->kwi", W, by_rate), held.value),
        held=held,
        legs=legs,
        inverse=W,
        directions=_of_axes(directions, values) / procedure.gravity,
        from_beside=np.einsum("kwi,wip->kp", directions, theirs),
        from_held=from_held,
    )


def _of_axes(weights: Array, value: Array) -> Array:
    """Return weights of axes, (3, 12, n), of those of body axes, (12, n, 3)."""
    return np.moveaxis(weights @ np.linalg.inv(value[:, :BIAS]), 2, 0)
