"""Calibration scheme of any windows, by least squares: W = (A^T C^-1 A)^-1 A^T C^-1.

A has a row (mean input, 1) for each window. Without C every window counts alike; with
the covariance of the window averages (budget.calibration.schemes.covariance), W is the
best linear unbiased estimator (Gauss, Markov, Aitken), axis by axis. Parameters that
are held have no column of their own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.response import BIAS
from budget.model.scheme import Scheme, least_squares, mean_powers

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.records import Procedure
    from budget.model.scheme import Held
    from budget.model.windows import Schedule


Task = tuple["Array", "Array | None", "NDArray[np.bool_] | None", "dict[int, Array]"]


def scheme_by_least_squares(
    owner: str,
    schedule: Schedule,
    procedure: Procedure,
    covariances: Array | None = None,
    held: Held | None = None,
    *,
    orders: tuple[int, ...] = (),
) -> Scheme:
    """Return windows and weights of one triad.

    Parameters
    ----------
    owner : str
        'gyro' or 'accelerometer'.
    schedule : Schedule
        Its windows.
    procedure : Procedure
        The place.
    covariances : ndarray, shape (3, n, n), optional
        Of the window averages of each axis [unit of the input, squared].
    held : Held, optional
        What is not estimated.
    orders : tuple of int
        Powers of the own input that are estimated besides.

    Raises
    ------
    CallError
        The windows cannot tell some parameters apart: which.
    """
    earth, gravity = procedure.place.earth, procedure.place.force
    turning = schedule.rates if owner == "gyro" else 0.0
    inputs = turning + schedule.to_body @ (earth if owner == "gyro" else gravity)
    powers = mean_powers(schedule.spread(gravity), orders)  # of accelerometers alone
    columns = np.tile(np.column_stack([inputs, np.ones(len(inputs))]), (3, 1, 1))
    if held is not None:
        columns = held.join(columns)
    tasks: list[Task] = [
        (
            columns[axis, :, :BIAS],
            None if covariances is None else covariances[axis],
            None if held is None else held.which[axis],
            dict(zip(orders, powers[axis].T, strict=True)),
        )
        for axis in range(3)
    ]
    weights: list[Array] = []
    try:
        for task in tasks:
            alike = (k for k in range(len(weights)) if _are_equal(tasks[k], task))
            place = next(alike, None)
            weights.append(least_squares(*task) if place is None else weights[place])
    except CallError as error:
        raise CallError(f"{procedure.name}, {owner}: {error}") from None
    return Scheme(
        owner=owner,
        schedule=schedule,
        place=procedure.place,
        timing=procedure.timing,
        weights=np.stack(weights),
        held=held,
        orders=orders,
    )


def _are_equal(a: Task, b: Task) -> bool:
    """Whether two axes are estimated alike: most have equal noise, and nothing held."""
    return not (a[3] or b[3]) and all(
        one is other if one is None or other is None else np.array_equal(one, other)
        for one, other in zip(a[:3], b[:3], strict=True)
    )
