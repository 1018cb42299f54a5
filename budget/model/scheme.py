"""A calibration scheme: windows, their nominal inputs, and the weights of an estimator.

A window's average reading of axis i, over its true scale factor, is (M u)_i + b_i +
e_i, with M = I + dT and u the mean input. With A the matrix of rows (u_w, 1), any
weights W with W A = I give the statistics (M_i, b_i) + W (e_i + M_i du): the response
of the axis to the three body axes, and its bias, each with its error and nothing else.

A parameter can be held: it is taken for what the design says. Its row of W is 0, its
column of A joins that of the own axis, which it is counted in, and what the truth
differs from it is seen by the other rows of W as they see that column.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.names import AXES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.windows import Schedule

# dT of Zhao 2019, eq. (1): element (ROW, COLUMN) is SIGN times the angle, for the
# angles in the order of ANGLES: xy, xz, yx, yz, zx, zy.
ROW = np.array([0, 0, 1, 1, 2, 2])
COLUMN = np.array([2, 1, 2, 0, 1, 0])
SIGN = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])

BIAS = 3  # row of the weights, after the responses to x, y, z
STATISTICS = 4
UNBIASED = 1e-9  # what W A may miss I by [1]
ROUNDING = 1e-14  # a weight below this part of the largest in its row is rounding [1]
RANK = 1e-9  # a singular value below this part of the largest is none [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Scheme:
    """How one triad is calibrated.

    Attributes
    ----------
    owner : str
        'gyro' or 'accelerometer'.
    schedule : Schedule
        The n windows.
    earth, gravity : ndarray, shape (3,)
        Earth rate [rad/s] and specific force of gravity [m/s^2], east-north-up.
    weights : ndarray, shape (3, 4, n)
        W of each axis: rows of its responses to body x, y, z, then of its bias
        [1/unit of the input, and 1].
    rotated : ndarray, shape (3,), or None
        Mean input at which eq. (4) of Zhao 2019 rotates the bias as printed, in body
        axes; None: the bias is what the weights give.
    held : Held or None
        What is not estimated; None: everything is.

    Raises
    ------
    CallError
        The weights are not unbiased.
    """

    owner: str
    schedule: Schedule
    earth: Array
    gravity: Array
    weights: Array = field(repr=False)
    rotated: Array | None = None
    held: Held | None = None

    def __post_init__(self) -> None:
        """Check W A = I: an estimator that misses it has errors without any source."""
        check_unbiased(self)

    @property
    def ambient(self) -> Array:
        """What the place puts in, east-north-up, shape (3,) [unit of the input]."""
        return self.earth if self.owner == "gyro" else self.gravity

    @cached_property
    def turn(self) -> Array:
        """What the table's turns put in, shape (n, 3); an accelerometer's is 0."""
        rates = self.schedule.rates
        return rates if self.owner == "gyro" else np.zeros_like(rates)

    @cached_property
    def standing(self) -> Array:
        """What the place puts in, mean over each window, shape (n, 3) [unit of input].

        It is kept apart from the turns: it cancels in differences of them, exactly.
        """
        return self.schedule.to_body @ self.ambient

    @cached_property
    def force(self) -> Array:
        """Mean specific force in body axes, shape (n, 3) [m/s^2]."""
        return self.schedule.to_body @ self.gravity

    @cached_property
    def seen(self) -> Array:
        """W A, shape (3, 4, 4): what each statistic takes of each parameter.

        Turns and place apart, so that what cancels within either is exactly 0.
        """
        response = self.weights @ self.turn + self.weights @ self.standing
        constant = self.weights.sum(axis=2)
        return np.concatenate([response, constant[:, :, None]], axis=2)

    @property
    def senses(self) -> Array:
        """Signs of the turns as seen by the input, 0 of dwells, shape (n,) [1]."""
        return self.schedule.senses * self.turn.any(axis=1)

    def weigh(self, values: Array, weights: Array | None = None) -> Array:
        """Return W applied to values of the windows, shape (3, 4, m).

        Products are rounded one by one, so that equal windows of opposite sign cancel
        exactly; a fused multiply-add would leave their rounding.

        Parameters
        ----------
        values : ndarray, shape (n, m)
            Of each window.
        weights : ndarray, shape (3, k, n), optional
            In place of the scheme's own.
        """
        W = self.weights if weights is None else weights
        return np.asarray((W[..., None] * values).sum(axis=2))


def check_unbiased(scheme: Scheme) -> None:
    """Refuse weights that do not give back what the windows hold.

    Raises
    ------
    CallError
        W A differs from I beyond rounding, in what is estimated: which axis and which
        parameter.
    """
    weights, found = scheme.weights, scheme.seen
    size = np.abs(scheme.turn + scheme.standing).max(initial=0.0) or 1.0
    estimated = np.ones((3, STATISTICS), dtype=bool)
    if scheme.held is not None:
        found = scheme.held.join(found)
        estimated = ~scheme.held.which
    scale = np.ones((STATISTICS, STATISTICS))
    scale[:BIAS, BIAS], scale[BIAS, :BIAS] = size, 1.0 / size
    missed = np.abs(found - np.eye(STATISTICS)) * scale
    missed[:, :BIAS, BIAS] /= np.abs(weights[:, :BIAS]).sum(axis=2) * size + 1.0
    missed[~(estimated[:, :, None] & estimated[:, None, :])] = 0.0
    if not (missed < UNBIASED).all():
        axis, row, column = np.unravel_index(int(np.nanargmax(missed)), missed.shape)
        rows = [*(f"response to {name}" for name in AXES), "bias"]
        columns = [*(f"an input along {name}" for name in AXES), "a constant bias"]
        raise CallError(
            f"the weights of the {scheme.owner} are biased: of axis {AXES[axis]} the "
            f"{rows[row]} takes {found[axis, row, column]:.6g} of {columns[column]}, "
            f"expected {float(row == column):g}; weights W need W A = I, with A the "
            "rows (mean input, 1) of the windows"
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Held:
    """Parameters that are not estimated, and what they are taken for.

    Attributes
    ----------
    which : ndarray of bool, shape (3, 4)
        Of each axis: its responses to body x, y, z, its bias; its response to itself is
        its scale factor.
    value : ndarray, shape (3, 4)
        Design values of all, over the scale factor; 1 of the own response.
    """

    which: NDArray[np.bool_]
    value: Array

    @property
    def estimated(self) -> NDArray[np.intp]:
        """Places of what is estimated, among scale factors, angles and biases."""
        own = self.which[[0, 1, 2], [0, 1, 2]]
        return np.flatnonzero(
            ~np.concatenate([own, self.which[ROW, COLUMN], self.which[:, BIAS]])
        )

    def join(self, columns: Array) -> Array:
        """Add columns of held parameters to that of the own axis, which is (3, m, 4).

        A held parameter is a known part of the own input: K (u_i + d u_a + b).
        """
        columns = columns.copy()
        for i in range(3):
            others = self.which[i] & (np.arange(STATISTICS) != i)
            columns[i, :, i] += columns[i][:, others] @ self.value[i, others]
        return columns


def least_squares(
    inputs: Array,
    covariance: Array | None = None,
    held: NDArray[np.bool_] | None = None,
) -> Array:
    """Return the weights of least squares, shape (4, n): W = (A^T C^-1 A)^-1 A^T C^-1.

    Without a covariance C of the window averages every window counts alike; with it
    they are the best linear unbiased weights (Gauss, Markov, Aitken).

    Parameters
    ----------
    inputs : ndarray, shape (n, 3)
        Nominal mean inputs of the windows [SI].
    covariance : ndarray, shape (n, n), optional
        Of the window averages, positive definite [SI squared].
    held : ndarray of bool, shape (4,), optional
        Parameters whose columns are left out; their rows of W are 0.

    Raises
    ------
    CallError
        The windows cannot tell some parameters apart: which.
    """
    free = np.ones(STATISTICS, dtype=bool) if held is None else ~held
    size = float(np.abs(inputs).max(initial=0.0)) or 1.0
    A = np.column_stack([inputs / size, np.ones(len(inputs))])[:, free]
    W = np.zeros((STATISTICS, len(inputs)))
    if not free.any():
        return W
    _, singular, rows = np.linalg.svd(A, full_matrices=True)
    singular = np.concatenate([singular, np.zeros(free.sum() - singular.size)])
    unseen = rows[singular <= RANK * singular.max()]
    if unseen.size:
        names = [*(f"the response to {axis}" for axis in AXES), "the bias"]
        kept = [name for name, is_free in zip(names, free, strict=True) if is_free]
        raise CallError(
            "these windows cannot tell apart: "
            + "; ".join(_describe_null(row, kept) for row in unseen)
            + ". Add windows in which these inputs differ (a face turned down, a turn "
            "in the other sense), or hold a parameter (estimate: names the others)"
        )
    if covariance is not None:
        whiten = np.linalg.inv(np.linalg.cholesky(covariance))
        W[free] = np.linalg.pinv(whiten @ A) @ whiten
    else:
        W[free] = np.linalg.pinv(A)
    W[np.abs(W) < ROUNDING * np.abs(W).max(axis=1, keepdims=True)] = 0.0
    W[:BIAS] /= size
    return W


def _describe_null(row: Array, names: list[str]) -> str:
    """Say which parameters a null vector of A mixes."""
    largest = np.abs(row).max()
    parts = [
        name
        for name, part in zip(names, row, strict=True)
        if abs(part) > 1e-6 * largest
    ]
    if len(parts) == 1:
        return f"{parts[0]} from nothing at all (no window shows it)"
    return " and ".join(parts)
