"""Calibration by the norm of gravity: dwells at unknown attitudes.

A dwell holds |f| = g whatever its attitude. With D = K/K^ and F = |s|^2 - g^2 of what
the calibrated triad shows, s = M^^-1 (D y - b^), the parameters solve W F = 0 (Skog and
Haendel 2006; Tedaldi, Pretto and Menegatti 2014). W = J^+ with J the sensitivity of F
at the nominal values and attitudes: the normal equations of Gauss and Newton to first
order, so that by the implicit function theorem the errors are W applied to those of F.
How the triad as a whole is turned no norm shows: three angles are held.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from budget.errors import CallError
from budget.model.response import (
    BIAS,
    COLUMN,
    ROW,
    SIGN,
    STATISTICS,
    CalibratedTriad,
    Errors,
    inverse,
    tilt_matrix,
)
from budget.model.scheme import UNBIASED, Held, Scheme

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth

# Steps of the solution at the most, from the law's first order; each takes off all but
# the part that the truth differs from the design by [1]. Four leave 2e-8 where that is
# 1 %; no more are made where what is left is below LEFT of the largest error [1].
STEPS = 4
LEFT = 2e-8


@dataclass(frozen=True, kw_only=True, eq=False)
class NormScheme(Scheme):
    """How one triad of accelerometers is calibrated by the norm of gravity.

    The statistics of an axis are, for each parameter that is estimated, its errors
    weighed by W f_x, W f_y, W f_z and W: all that F holds of them to first order.
    Their squares are left out: of an average of 10 ug 1e-10 of g^2. What turns all of
    gravity is no such error, as its square undoes it: it is none at all.

    Attributes
    ----------
    held : Held
        Three angles at the least.
    """

    knows_attitudes: ClassVar[bool] = False
    knows_turns: ClassVar[bool] = False
    weighed: ClassVar[str] = "norm"

    held: Held

    @property
    def norm_weights(self) -> Array:
        """W of what is estimated, shape (m, n) [s^4/m^2, of a bias s^2/m]."""
        return self.weights[0, BIAS : self.own_statistics : STATISTICS]

    def shown_weights(self) -> tuple[list[tuple[str, Array]], dict[str, Array]]:
        """Return the dwells with their mean input, and W of what is estimated."""
        parts, _ = super().shown_weights()
        return parts, {"": self.norm_weights}

    @property
    def own_statistics(self) -> int:
        """Number of the first statistics, 4 m; those after them are for a gyro."""
        return STATISTICS * len(self.held.estimated)

    def __post_init__(self) -> None:
        """Check W J = I.

        Raises
        ------
        CallError
            The weights miss it.
        """
        J = sensitivity(self.force, self.held)
        missed = self.norm_weights @ J - np.eye(len(self.norm_weights))
        size = np.abs(self.norm_weights) @ np.abs(J) + 1.0
        if not (np.abs(missed) < UNBIASED * size).all():
            raise CallError(f"the weights of the {self.owner} miss W J = I")

    @cached_property
    def moments(self) -> tuple[Array, Array, Array]:
        """Sums of W f f^T, W f and W: shapes (m, 9), (m, 3), (m, 1)."""
        W, f = self.norm_weights, self.force
        squares = (f[:, :, None] * f[:, None]).reshape(-1, 9)
        return W @ squares, W @ f, W.sum(axis=1)[:, None]

    @cached_property
    def first_order(self) -> tuple[Array, Array]:
        """C of the design, (3, 3), and what held errors make by W J, shape (m, 12)."""
        value, held = self.held.value, np.setdiff1d(np.arange(12), self.held.estimated)
        every = 2.0 * np.einsum(
            "wi,wip->wp", self.force, shown_of_errors(self.force, value)
        )
        from_held = np.zeros((len(self.norm_weights), 12))
        from_held[:, held] = self.norm_weights @ every[:, held]
        return np.asarray(np.linalg.inv(value[:, :BIAS])), from_held

    def read_errors(self, truth: Truth, epsilon: Array) -> Errors:
        """Solve for the errors of the parameters; those held are as they are.

        Parameters
        ----------
        truth : Truth
        epsilon : ndarray, shape (3, 4 m or more, trials)
            Errors of the statistics of each axis; the first 4 m count.

        Returns
        -------
        Errors
        """
        found = self.held.errors_of(truth)
        places = self.held.estimated
        own = epsilon[:, : self.own_statistics]
        noise = own.reshape(3, len(places), STATISTICS, -1)
        M = np.eye(3)[..., None] + tilt_matrix(truth.angle)
        shown, from_held = self.first_order
        found[places] = -2.0 * _seen(shown, noise) - from_held @ found
        if found.dtype != float:  # one step is their second order
            found[places] = found[places] - self._misfit(found, M, truth.bias, noise)
        else:
            self._settle(found, M, truth.bias, noise)
        return Errors.of(found)

    def _settle(self, found: Array, M: Array, b: Array, noise: Array) -> None:
        """Bring errors of all parameters, (12, trials), from first order to the end."""
        places = self.held.estimated
        size = np.where(
            places < len(SIGN) + BIAS, 1.0, 1.0 / np.linalg.norm(self.gravity)
        )
        before = largest = _largest(found[places], size)
        for _ in range(STEPS):
            step = self._misfit(found, M, b, noise)
            found[places] -= step
            left = _largest(step, size)
            if left**2 <= LEFT * largest * before:
                break
            before = left

    def _misfit(self, found: Array, M: Array, b: Array, noise: Array) -> Array:
        """Return W F, shape (m, trials), at errors of all parameters.

        s = f + P f + q + C e, P = M^^-1 ((D - 1) M - dM), q = M^^-1 ((D - 1) b - db)
        and C = M^^-1 D; F = 2 f.(P f + q) + |P f + q|^2 + 2 (f + P f + q).C e.
        """
        own, bias = found[:3], found[9:]
        dM = tilt_matrix(found[3:9])
        back = inverse(M + dM)
        D = 1.0 / (1.0 + own)
        less = -1.0 * own * D
        P = _product(back, less[:, None] * M - dM)
        q = _applied(back, less * b - bias)
        C = back * D
        turned = np.swapaxes(P, 0, 1)  # P^T
        squares, means, total = self.moments
        wanted = 2.0 * P + _product(turned, P)
        shown = C + _product(turned, C)  # (1 + P)^T C
        steady = _applied(np.swapaxes(C, 0, 1), q)  # C^T q
        return np.asarray(
            squares @ wanted.reshape(9, -1)
            + means @ (2.0 * (q + _applied(turned, q)))
            + total * (q * q).sum(axis=0)
            + 2.0 * _seen(shown, noise)
            + 2.0 * sum(steady[i] * noise[i, :, BIAS] for i in range(BIAS))
        )

    def estimate(self, readings: Array) -> CalibratedTriad:
        """Calibrate as Scheme does, (3, n), by nonlinear least squares of F."""
        from scipy.optimize import least_squares

        g = float(np.linalg.norm(self.gravity))
        places = self.held.estimated
        size = np.concatenate([np.ones(9), np.full(3, g)])

        def whole(part: Array) -> CalibratedTriad:
            parameters = self.held.nominal
            parameters[places] += part * size[places]
            return CalibratedTriad.of(parameters)

        def residual(part: Array) -> Array:
            shown = whole(part).shown(readings) / g
            return np.asarray((shown**2).sum(axis=0) - 1.0)

        def slope(part: Array) -> Array:
            now = whole(part)
            s = now.shown(readings).T / g
            ds = shown_of_errors(s, np.column_stack([now.response, now.bias / g]))
            ds[..., :3] /= now.scale_factor
            return np.asarray(2.0 * np.einsum("wi,wip->wp", s, ds)[:, places])

        solved = least_squares(
            residual,
            np.zeros(len(places)),
            slope,
            method="lm",
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        return whole(solved.x)

    def beside(self, directions: Array) -> NormScheme:
        """Return it with more statistics, (3, 12, n), that a gyro needs of it."""
        return replace(self, weights=np.concatenate([self.weights, directions], axis=1))


def statistics_weights(norm_weights: Array, force: Array) -> Array:
    """Return the weights of the statistics, (3, 4 m, n), of W (m, n) and f (n, 3)."""
    rows = norm_weights[:, None] * np.column_stack([force, np.ones(len(force))]).T
    return np.tile(rows.reshape(-1, len(force)), (3, 1, 1))


def sensitivity(force: Array, held: Held) -> Array:
    """Return J, the derivatives of F by what is estimated, shape (n, m): 2 f.ds.

    Parameters
    ----------
    force : ndarray, shape (n, 3)
        Nominal specific force of the dwells in body axes [m/s^2].
    held : Held
        What is estimated, and all nominal values.
    """
    shown = shown_of_errors(force, held.value)
    return np.asarray(2.0 * np.einsum("wi,wip->wp", force, shown)[:, held.estimated])


def shown_of_errors(inputs: Array, value: Array) -> Array:
    """Return ds/dp, what a triad shows too much for errors of its parameters.

    s = M^-1 (D y - b): ds = -M^-1 e_i times (M u + b)_i of a relative error of a scale
    factor, SIGN u_a of an angle, 1 of a bias.

    Parameters
    ----------
    inputs : ndarray, shape (n, 3)
        Nominal inputs in body axes [SI].
    value : ndarray, shape (3, 4)
        Design values, as of Held.

    Returns
    -------
    ndarray, shape (n, 3, 12)
        [unit of the input; of a bias 1].
    """
    M, b = value[:, :BIAS], value[:, BIAS]
    size = np.concatenate(
        [inputs @ M.T + b, inputs[:, COLUMN] * SIGN, np.ones_like(inputs)], axis=1
    )
    places = np.concatenate([np.arange(3), ROW, np.arange(3)])
    return np.asarray(-np.linalg.inv(M)[:, places] * size[:, None])


def _seen(matrix: Array, noise: Array) -> Array:
    """Return sums of noise, (3, m, 4, trials), that each axis shows, (m, trials)."""
    if matrix.ndim > 2 and matrix.dtype == float:  # noqa: PLR2004 - of each trial
        return np.asarray(np.einsum("ait,imat->mt", matrix, noise[:, :, :BIAS]))
    return np.asarray(
        sum(
            matrix[a, i] * noise[i, :, a]
            for a in range(BIAS)
            for i in range(BIAS)
            if matrix.ndim > 2 or matrix[a, i]  # noqa: PLR2004 - of each trial
        )
    )


def _largest(values: Array, size: Array) -> float:
    """Return the largest of all trials, (m, trials), in the scale of each, (m,)."""
    return float((np.abs(values).max(axis=1) * size).max(initial=0.0))


def _product(a: Array, b: Array) -> Array:
    """Return the matrix product of (3, 3, trials) and (3, 3, trials)."""
    return np.asarray(a[:, :1] * b[0] + a[:, 1:2] * b[1] + a[:, 2:] * b[2])


def _applied(a: Array, v: Array) -> Array:
    """Return the product of matrices (3, 3, trials) and vectors (3, trials)."""
    return np.asarray(a[:, 0] * v[0] + a[:, 1] * v[1] + a[:, 2] * v[2])
