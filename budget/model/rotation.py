"""Calibration of a gyro by rotation: turned between dwells at unknown attitudes.

In a dwell the calibrated accelerometers show where down is, s/g = u; in between the
calibrated gyro says how that has turned, by Phi, the product of exp(-[w^ t]x) of its
steps. With w^ less the earth rate of the nominal attitudes, what is left,

    u_(k+1) - Phi u_k from dwell to dwell,    L w^ of a dwell of length L,

is F, all angles: its least squares give the parameters (Tedaldi, Pretto and
Menegatti 2014, whose bias is that of the dwells); where nobody knows the azimuth they
give the horizontal earth rate too, as two more. To first order dF is that of errors
dw of the rates and du of the directions,

    du_(k+1) - Phi du_k + theta x u_(k+1),    theta = sum Phi(to the end) H dw t,

H the mean of exp(-[a]x) over the angle a of the step; and with J the sensitivity of F
to the parameters, W = J^+, they solve W F = 0 and their errors are -W dF: linear, by
the implicit function theorem. A turn about the vertical is not seen. The gyro's angles
are against the body axes that the accelerometers were calibrated to.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from budget.errors import CallError
from budget.model.norm import shown_of_errors
from budget.model.response import (
    CYCLES,
    CalibratedTriad,
    Errors,
)
from budget.model.scheme import UNBIASED, Held, Scheme
from budget.names import AXES

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth

MOST_STEPS = 500  # of the solution; 12 where all is within 1 % of the design
DONE = 1e-15  # part of a parameter that the last step changes at the most [1]


@dataclass(frozen=True, kw_only=True)
class RotationLeg:
    """The way from one dwell of the accelerometers to the next that stands otherwise.

    Attributes
    ----------
    first, last : int
        Places of the dwells among the windows of the accelerometers.
    steps : tuple of int
        Places of the steps of the turn among the windows of the gyro.
    """

    first: int
    last: int
    steps: tuple[int, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class RotationScheme(Scheme):
    """How a gyro is calibrated by rotation, beside accelerometers that are.

    The statistics of an axis are its part of the errors of the twelve parameters, in
    the order of Held.estimated; rows of what is held are 0. Errors of parameters times
    errors of readings are left out: of 1 % a hundredth of the uncertainties.

    Attributes
    ----------
    held : Held
    legs : tuple of RotationLeg
    inverse : ndarray, shape (12, rows)
        W [1/rad, of an angle 1, of a bias 1/s]; rows of what is held are 0.
    directions : ndarray, shape (3, 12, n_a)
        The same weights on the windows of the axes of the accelerometers.
    from_beside : ndarray, shape (12, 12)
        What errors of parameters of the accelerometers add.
    from_held : ndarray, shape (12, 12)
        What errors of parameters that are held add; of themselves 1.
    """

    knows_turns: ClassVar[bool] = False  # the earth rate is taken at known attitudes
    weighed: ClassVar[str] = "rotation"

    held: Held
    legs: tuple[RotationLeg, ...]
    inverse: Array
    directions: Array
    from_beside: Array
    from_held: Array

    def __post_init__(self) -> None:
        """Check W J = I: what is estimated takes each of its errors as it is.

        Raises
        ------
        CallError
            The weights miss it.
        """
        shown = shown_of_errors(self.turn + self.standing, self.held.value)
        seen = -np.einsum("ikw,ij,wjp->kp", self.weights, self.held.value[:, :3], shown)
        missed = (seen - np.eye(12))[np.ix_(*2 * [self.held.estimated])]
        size = np.abs(self.weights).sum(axis=(0, 2)).max() * np.abs(shown).max()
        if not (np.abs(missed) < UNBIASED * max(size, 1.0)).all():
            raise CallError(f"the weights of the {self.owner} miss W J = I")

    def shown_weights(self) -> tuple[list[tuple[str, Array]], dict[str, Array]]:
        """Return what F is of, and W of what is estimated by its axis."""
        W = self.inverse[self.held.estimated]
        return self.parts, {axis: W[:, k::3] for k, axis in enumerate(AXES)}

    @property
    def parts(self) -> list[tuple[str, Array]]:
        """What F is of: turns by name and dwells, with the angle turned, (3,) [rad]."""
        windows, turned = self.schedule.windows, self.schedule.turned
        ways = [
            (
                ", ".join(
                    dict.fromkeys(windows[k].name.partition(",")[0] for k in leg.steps)
                ),
                turned[list(leg.steps)].sum(axis=0),
            )
            for leg in self.legs
        ]
        still = np.flatnonzero(self.schedule.senses == 0.0)
        return [*ways, *((windows[k].name, turned[k]) for k in still)]

    def read_errors_beside(
        self, truth: Truth, epsilon: Array, beside: Errors, directions: Array
    ) -> Errors:
        """Return the errors of the parameters; those held are as they are.

        Parameters
        ----------
        truth : Truth
        epsilon : ndarray, shape (3, 12, trials)
            Errors of the statistics of each axis.
        beside : Errors
            Of the parameters of the accelerometers.
        directions : ndarray, shape (3, 12, trials)
            Errors of the statistics of each of their axes.
        """
        off = self.held.errors_of(truth)
        found = epsilon.sum(axis=0) + directions.sum(axis=0)
        found = found + _times(self.from_beside, beside.vector)
        return Errors.of(found + _times(self.from_held, off))

    def estimate_beside(self, readings: Array, directions: Array) -> CalibratedTriad:
        """Calibrate as Scheme does: solve W F = 0, from the nominal values.

        Parameters
        ----------
        readings : ndarray, shape (3, n)
            Mean pulses per second of each axis in each window.
        directions : ndarray, shape (3, n_a)
            What the calibrated accelerometers show [m/s^2].
        """
        p = self.held.nominal
        size = np.concatenate([np.ones(9), np.full(3, np.abs(self.turn).max())])
        down = (directions / np.linalg.norm(directions, axis=0)).T
        for _ in range(MOST_STEPS):
            rates = CalibratedTriad.of(p).shown(readings).T
            turned = (rates - self.standing) * self.schedule.lengths[:, None]
            step = self.inverse @ self._misfit(turned, down)
            p -= step
            if (np.abs(step) <= DONE * size).all():
                break
        return CalibratedTriad.of(p)

    def _misfit(self, turned: Array, down: Array) -> Array:
        """Return F, of angles turned (n, 3) and directions (n_a, 3) [rad]."""
        left = []
        R = rotation(-turned)
        for leg in self.legs:
            u = down[leg.first]
            for step in leg.steps:
                u = R[step] @ u
            left.append(down[leg.last] - u)
        return np.concatenate([*left, *turned[self.schedule.senses == 0.0]])


def sensitivities(
    schedule_lengths: Array, turned: Array, down: Array, legs: tuple[RotationLeg, ...]
) -> tuple[Array, Array]:
    """Return dF/dw, (rows, n, 3) [s], and dF/du, (rows, n_a, 3) [1].

    Parameters
    ----------
    schedule_lengths : ndarray, shape (n,)
        Of the windows of the gyro [s].
    turned : ndarray, shape (n, 3)
        Nominal angles of their turns in body axes, 0 of dwells [rad].
    down : ndarray, shape (n_a, 3)
        Nominal directions of gravity in the dwells of the accelerometers [1].
    legs : tuple of RotationLeg
    """
    still = np.flatnonzero(~turned.any(axis=1))
    rows = 3 * (len(legs) + len(still))
    by_rate = np.zeros((rows, *turned.shape))
    by_direction = np.zeros((rows, *down.shape))
    turns, means = rotation(-turned), mean_rotation(-turned)
    for k, leg in enumerate(legs):
        own = slice(3 * k, 3 * k + 3)
        Phi = np.eye(3)  # from the end of the step to the end of the leg
        across = _cross(down[leg.last])  # theta x u = -u x theta
        for step in reversed(leg.steps):
            H = Phi @ means[step]
            by_rate[own, step] = -across @ H * schedule_lengths[step]
            Phi = Phi @ turns[step]
        by_direction[own, leg.first] = -Phi
        by_direction[own, leg.last] = np.eye(3)
    for k, place in enumerate(still, start=len(legs)):
        by_rate[3 * k : 3 * k + 3, place] = np.eye(3) * schedule_lengths[place]
    return by_rate, by_direction


def rotation(vector: Array) -> Array:
    """Return exp([v]x), rotations by vectors (..., 3) [rad], shape (..., 3, 3)."""
    a = np.linalg.norm(vector, axis=-1)[..., None, None]
    S = _cross(vector)
    half = np.sinc(a / (2.0 * np.pi))
    return np.asarray(np.eye(3) + np.sinc(a / np.pi) * S + 0.5 * half**2 * (S @ S))


def mean_rotation(vector: Array) -> Array:
    """Return the mean of exp(s [v]x) over s from 0 to 1, shape (..., 3, 3).

    I + [v]x (1 - cos a)/a^2 + [v]x^2 (a - sin a)/a^3, a the length of v.
    """
    a = np.linalg.norm(vector, axis=-1)[..., None, None]
    S = _cross(vector)
    half = np.sinc(a / (2.0 * np.pi))
    # (a - sin a)/a^3 loses digits where a is small: its series is exact below 0.1.
    small = 1.0 / 6.0 - a**2 / 120.0 + a**4 / 5040.0 - a**6 / 362880.0
    large = np.maximum(a, 0.1)
    third = np.where(a < 0.1, small, (large - np.sin(large)) / large**3)  # noqa: PLR2004
    return np.asarray(np.eye(3) + 0.5 * half**2 * S + third * S @ S)


def _cross(v: Array) -> Array:
    """Return [v]x, matrices (..., 3, 3) of the cross product with v, (..., 3)."""
    found = np.zeros((*v.shape, 3))
    for i, j, k in CYCLES:
        found[..., j, i], found[..., i, j] = v[..., k], -v[..., k]
    return found


def _times(matrix: Array, rows: Array) -> Array:
    """Return the product of a matrix and rows of numbers or jets, (n, trials)."""
    return np.asarray((matrix[:, :, None] * rows).sum(axis=1))
