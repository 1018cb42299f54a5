"""Covariance of window averages: what `weighted` least squares weighs windows by.

C of an axis is that of all that is known to be random: the noise of the device, and
what disturbs its readings or the input that the table gives, in station, environment
and device, du of a window seen by the axis as (M du)_i. A disturbance is asked what it
does where the statistics are the windows themselves, W = I: of inputs of covariance U,
by columns G of their sizes, C += G U G^T. What is the same in all windows, or shows as
the response to a nominal input, lies among the columns of A and changes no W; but a
parameter that is held has no column there, and what the truth differs from the design
is an error of every window, of the size of its offsets.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.response import Truth, statistics_of
from budget.model.scheme import Scheme
from budget.model.source import Disturbance, Noise, Offset, Statistics, Triad
from budget.model.sources import source_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.model.scheme import Held
    from budget.model.source import Given
    from budget.model.windows import Schedule

# White, of the mean variance of disturbances: noise so far below them is none, and C
# keeps an inverse [1].
FLOOR = 1e-12


def noise_of(owner: str, lines: Sequence[Given]) -> list[Given]:
    """Return the noise of a triad; without any `weighted` weighs nothing."""
    return [
        line
        for line in lines
        if line.u.any()
        and isinstance(source_of(owner, line.name).meant(line).effect, Noise)
    ]


def covariances_of(
    sensor: Sensor, procedure: Procedure, schedule: Schedule, held: Held
) -> Array:
    """Return the covariance of the window averages of each axis, shape (3, n, n)."""
    n = len(schedule.windows)
    found = np.zeros((3, n, n))
    for line in noise_of(sensor.kind, sensor.lines):
        effect = source_of(sensor.kind, line.name).meant(line).effect
        if isinstance(effect, Noise):
            for axis in range(3):
                process = effect.process(line, axis, procedure.sample_rate)
                found[axis] += process.covariance(schedule)
    scheme = Windows.of(sensor.kind, schedule, procedure)
    disturbed = _left(sensor, scheme, held)
    for shown in _disturbances(sensor, procedure, scheme):
        disturbed += shown @ shown.transpose(0, 2, 1)
    size = np.trace(disturbed, axis1=1, axis2=2) / n
    return np.asarray(found + disturbed + FLOOR * size[:, None, None] * np.eye(n))


def joint_covariance(sensor: Sensor, procedure: Procedure, schedule: Schedule) -> Array:
    """Return the covariance of the window averages of a triad, shape (3 n, 3 n).

    Axis after axis [unit of the input, squared]. What the table and the place are off
    by reaches all axes, so that these are correlated; what parameters are off by is not
    in it.
    """
    n = len(schedule.windows)
    found = np.zeros((3, n, 3, n))
    for line in noise_of(sensor.kind, sensor.lines):
        effect = source_of(sensor.kind, line.name).meant(line).effect
        if isinstance(effect, Noise):
            for axis in range(3):
                process = effect.process(line, axis, procedure.sample_rate)
                found[axis, :, axis] += process.covariance(schedule)
    joint = found.reshape(3 * n, 3 * n)
    scheme = Windows.of(sensor.kind, schedule, procedure)
    for shown in _disturbances(sensor, procedure, scheme):
        G = shown.reshape(3 * n, -1)
        joint += G @ G.T
    return joint


@dataclass(frozen=True, kw_only=True, eq=False)
class Windows(Scheme):
    """A triad whose statistics are the window averages themselves."""

    def __post_init__(self) -> None:
        """Estimate nothing: there is no W A to check."""

    @classmethod
    def of(cls, owner: str, schedule: Schedule, procedure: Procedure) -> Windows:
        """Return those of a triad in a schedule."""
        return cls(
            owner=owner,
            schedule=schedule,
            place=procedure.place,
            timing=procedure.timing,
            weights=np.tile(np.eye(len(schedule.windows)), (3, 1, 1)),
        )

    def held_of(self, quantity: str) -> Array:
        """Return 1: what a new unit has of a parameter is in its readings."""
        return np.ones(6 if quantity == "mounting_angle" else 3)


def _left(sensor: Sensor, scheme: Scheme, held: Held) -> Array:
    """Return what the offsets of held parameters add to it, shape (3, n, n)."""
    variance = {"scale_factor": np.zeros(3), "bias": np.zeros(3)}
    variance["mounting_angle"] = np.zeros(6)
    for line in sensor.lines:
        effect = source_of(sensor.kind, line.name).meant(line).effect
        if isinstance(effect, Offset):
            variance[effect.target] += line.u**2
    each = held.which * statistics_of(
        variance["scale_factor"], variance["mounting_angle"], variance["bias"]
    )
    n = len(scheme.schedule.windows)
    A = np.column_stack([scheme.turn + scheme.standing, np.ones(n)])
    return np.asarray((A * each[:, None]) @ A.T)


def _disturbances(
    sensor: Sensor, procedure: Procedure, scheme: Scheme
) -> Iterator[Array]:
    """Yield G times a root of U of each disturbance, shape (3, n, inputs)."""
    triad = Triad(
        scheme=scheme,
        given={line.name: line for line in (*procedure.environment, *sensor.lines)},
        statistics=Statistics(weights=scheme.weights),
    )
    owners = (
        (sensor.kind, sensor.lines),
        *procedure.shared.items(),
    )
    for owner, lines in owners:
        for line in lines:
            effect = source_of(owner, line.name).meant(line).effect
            if isinstance(effect, Disturbance) and line.u.any():
                yield _shown(effect, line, triad, sensor)


def _shown(effect: Disturbance, line: Given, triad: Triad, sensor: Sensor) -> Array:
    """Return G times a root of U, shape (3, n, inputs), at the nominal values."""
    n = triad.statistics.weights.shape[1]
    act = effect.bind(line, triad)
    if act is None:
        return np.zeros((3, n, 0))
    joint = effect.covariance(line, (triad,))
    if joint is None:
        joint = np.diag(np.resize(line.u, effect.size(line, triad.scheme)) ** 2)
    u = np.sqrt(np.diag(joint))
    x = np.diag(u)[effect.part((triad,), 0)]
    trials = x.shape[1]
    truth = Truth(
        angle=np.tile(sensor.nominal_mounting_angle[:, None], trials),
        bias=np.tile(sensor.nominal_bias[:, None], trials),
    )
    still = np.zeros((3, n, trials))
    G = act(x, truth, still) - act(0.0 * x, truth, still)
    safe = np.where(u > 0.0, u, 1.0)
    values, vectors = np.linalg.eigh(joint / np.outer(safe, safe))
    return np.asarray(G @ (vectors * np.sqrt(np.maximum(values, 0.0))))
