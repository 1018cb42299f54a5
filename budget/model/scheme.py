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
    statistics_of,
    tilt,
    tilt_transposed,
)
from budget.model.windows import EXACT, Timing
from budget.names import AXES, parameters_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.place import Place
    from budget.model.response import Truth
    from budget.model.windows import Schedule

UNBIASED = 1e-9  # what W A may miss I by [1]
ROUNDING = 1e-14  # a weight below this part of the largest in its row is rounding [1]
ROWS = 16  # of weights that are applied at a time, at the least
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
    place : Place
        What the test takes it for.
    weights : ndarray, shape (3, 4 + m, n)
        W of each axis: rows of its responses to body x, y, z, then of its bias
        [1/unit of the input, and 1], then of its higher orders.
    rotated : ndarray, shape (3,), or None
        Mean input at which eq. (4) of Zhao 2019 rotates the bias as printed, in body
        axes; None: the bias is what the weights give.
    held : Held or None
        What is not estimated; None: everything is.
    timing : Timing
        What it goes by where the table turns.
    orders : tuple of int
        Powers p of an axis' own input whose coefficients K_p are estimated, m of them.

    Raises
    ------
    CallError
        The weights are not unbiased.
    """

    # Whether a tilt of the base is an error; to who knows no attitude it is none.
    knows_attitudes: ClassVar[bool] = True
    # Whether turns are known; else what is turned is found, and a wrong one no error.
    knows_turns: ClassVar[bool] = True
    # What W weighs: each axis its windows, or as a page of weights calls it.
    weighed: ClassVar[str] = "windows"

    owner: str
    schedule: Schedule
    place: Place
    weights: Array = field(repr=False)
    rotated: Array | None = None
    held: Held | None = None
    timing: Timing = field(default_factory=Timing)
    orders: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Check W A = I: an estimator that misses it has errors without any source."""
        check_unbiased(self)

    def held_of(self, quantity: str) -> Array:
        """Return 1 of what is held of a quantity, 0 of what is estimated, by axis."""
        here = np.array([one.quantity == quantity for one in parameters_of(self.owner)])
        if self.held is None:
            return np.zeros(here.sum())
        return np.where(self.held.by_parameter[here], 1.0, 0.0)

    @property
    def earth(self) -> Array:
        """Earth rate, east-north-up, shape (3,) [rad/s]."""
        return self.place.earth

    @property
    def gravity(self) -> Array:
        """Specific force of gravity, east-north-up, shape (3,) [m/s^2]."""
        return self.place.force

    @property
    def ambient(self) -> Array:
        """What the place puts in, east-north-up, shape (3,) [unit of the input]."""
        return self.earth if self.owner == "gyro" else self.gravity

    @property
    def leaning(self) -> Array:
        """The same, as tilts act by it, shape (3,) [unit of the input]."""
        return self.place.leaning if self.owner == "gyro" else self.gravity

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
    def within(self) -> Array:
        """Inputs within each window, shape (n, p, 3) [unit of the input]."""
        return np.asarray(self.turn[:, None] + self.schedule.spread(self.ambient))

    @cached_property
    def harmonics(self) -> Array:
        """Inputs within each window as A + C cos + S sin, shape (3, n, 3) [SI].

        A, C and S of the angle that the table has turned by; C and S of dwells are 0.
        """
        u = self.within
        if u.shape[1] == 1:
            return np.stack([u[:, 0], 0.0 * u[:, 0], 0.0 * u[:, 0]])
        mean = self.turn + self.standing
        swing = (u[:, :2] - u[:, 2:]) / 2.0  # at 0 and 180, 90 and 270 deg
        swing[self.schedule.senses == 0.0] = 0.0
        return np.stack([mean, swing[:, 0], swing[:, 1]])

    @cached_property
    def force(self) -> Array:
        """Mean specific force in body axes, shape (n, 3) [m/s^2]."""
        return self.schedule.to_body @ self.gravity

    @cached_property
    def forces(self) -> Array:
        """Specific force in body axes within each window, shape (n, p, 3) [m/s^2].

        Of a part of a turn its mean.
        """
        found = self.schedule.spread(self.gravity)
        turns = np.linalg.norm(self.schedule.turned, axis=1) / (2.0 * np.pi)
        is_part = np.abs(turns - np.round(turns)) > EXACT
        found[is_part] = self.force[is_part, None]
        return found

    @cached_property
    def powers(self) -> Array:
        """Powers of the own input of each axis, shape (3, n, m), means [SI]."""
        if not self.orders:  # what is within a window is asked for by few
            return np.zeros((3, len(self.schedule.windows), 0))
        return mean_powers(self.within, self.orders)

    @cached_property
    def seen(self) -> Array:
        """W A, shape (3, 4 + m, 4): what each statistic takes of each parameter.

        Turns and place apart, so that what cancels within either is exactly 0.
        """
        response = self.weights @ self.turn + self.weights @ self.standing
        return np.concatenate([response, self.weights.sum(axis=2)[:, :, None]], axis=2)

    @property
    def senses(self) -> Array:
        """Signs of the turns as seen by the input, 0 of dwells, shape (n,) [1]."""
        return self.schedule.senses * self.turn.any(axis=1)

    def shown_weights(self) -> tuple[list[tuple[str, Array]], dict[str, Array]]:
        """Return what is weighed, with its mean input, and W by axis, '' of all."""
        inputs = self.turn + self.standing
        names = (window.name for window in self.schedule.windows)
        parts = list(zip(names, inputs, strict=True))
        if all(np.array_equal(self.weights[0], W) for W in self.weights):
            return parts, {"": self.weights[0]}
        return parts, dict(zip(AXES, self.weights, strict=True))

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
        parts = np.array_split(W, max(1, W.shape[1] // ROWS), axis=1)
        return np.concatenate(
            [(part[..., None] * values).sum(axis=2) for part in parts], axis=1
        )

    def read_errors(self, truth: Truth, epsilon: Array) -> Errors:
        """Read scale factors, angles and biases off statistics (M, b) + epsilon.

        K_i = K_true (1 + e_ii); d = s (s d + e_ia) / (1 + e_ii), s the sign of the
        angle in dT; b = (b + e_ib) / (1 + e_ii): Zhao 2019, eqs. (3) to (5). Written as
        errors: the difference of two nearly equal values would lose digits.

        With `rotated` w the bias goes through eq. (4) as printed: it rotates v, the
        mean reading over K, by the transpose, (I + dT^T) v - w, which is right only
        where dT is antisymmetric and the bias given in body axes.

        Parameters
        ----------
        truth : Truth
        epsilon : ndarray, shape (3, 4, trials)
            Errors of the statistics of each axis, W (e + M du).

        Returns
        -------
        Errors
        """
        if self.held is not None:
            epsilon = epsilon + self._from_held(self.held, truth)
        own = epsilon[[0, 1, 2], [0, 1, 2]]
        back = 1.0 / (1.0 + own)
        angle = epsilon[ROW, COLUMN]
        angle *= SIGN[:, None]
        pairs = angle.reshape(3, 2, -1)  # ROW is 0, 0, 1, 1, 2, 2
        pairs -= truth.angle.reshape(pairs.shape) * own[:, None]
        pairs *= back[:, None]
        bias = (epsilon[:, BIAS] - truth.bias * own) * back
        higher = np.moveaxis(epsilon[:, STATISTICS:] * back[:, None], 0, 1)
        if self.rotated is not None:
            found = truth.angle + angle
            through = tilt(found, self.rotated)
            v = truth.bias + bias + self.rotated[:, None] + through
            bias = bias + through + tilt_transposed(found, v)
        return Errors(
            scale_factor=own,
            mounting_angle=angle,
            bias=bias,
            higher=higher.reshape(-1, higher.shape[-1]),
        )

    def estimate(self, readings: Array) -> CalibratedTriad:
        """Calibrate one triad from its readings: the same weights, on real windows.

        Parameters
        ----------
        readings : ndarray, shape (3, n)
            Mean pulses per second of each axis in each window.

        Returns
        -------
        CalibratedTriad
        """
        statistics = np.einsum("ikw,iw->ik", self.weights, readings)
        if self.held is not None:
            statistics -= self._known(self.held)
        K = statistics[[0, 1, 2], [0, 1, 2]]
        angle = SIGN * statistics[ROW, COLUMN] / K[ROW]
        bias = statistics[:, BIAS] / K
        higher = (statistics[:, STATISTICS:] / K[:, None]).T.ravel()
        w = self.rotated
        if w is not None:
            v = bias + w + tilt(angle[:, None], w)[:, 0]
            bias = v + tilt_transposed(angle[:, None], v[:, None])[:, 0] - w
        return CalibratedTriad(
            scale_factor=K, mounting_angle=angle, bias=bias, higher=higher
        )

    def _from_held(self, held: Held, truth: Truth) -> Array:
        """Return what held parameters add to epsilon, shape (3, 4, trials).

        A column that is held at h0 and truly is h leaves h - (1 + e) h0 in the
        averages, e = K0/K - 1 where the scale factor is held, else 0 (it is estimated
        with the held column in it). Of the own column both are 1. W sees it as it sees
        that column, and the statistic of a held scale factor is off by e itself.
        """
        e = held.which[[0, 1, 2], [0, 1, 2]][:, None] * truth.from_design
        true = statistics_of(np.ones_like(e), SIGN[:, None] * truth.angle, truth.bias)
        taken = held.value[..., None]
        left = 1.0 * held.which[..., None] * (true - taken - e[:, None] * taken)
        found = (self.seen[:, :, :, None] * left[:, None]).sum(axis=2)
        found[[0, 1, 2], [0, 1, 2]] += e
        return np.asarray(found)

    def _known(self, held: Held) -> Array:
        """Return what held scale factors of 1 add to the statistics, (3, 4 + m)."""
        is_own = held.which[[0, 1, 2], [0, 1, 2]]
        own = held.join(self.seen)[[0, 1, 2], :, [0, 1, 2]]  # (3, 4 + m)
        known = np.where(is_own[:, None], own, 0.0)
        known[[0, 1, 2], [0, 1, 2]] -= is_own
        return np.asarray(known)


def mean_powers(inputs: Array, orders: Sequence[int]) -> Array:
    """Return means of powers over windows, (3, n, m), of inputs (n, p, 3) in them."""
    own = np.moveaxis(inputs, 2, 0)[..., None]
    return np.asarray((own ** np.array(orders, dtype=float)).mean(axis=2))


def check_unbiased(scheme: Scheme) -> None:
    """Refuse weights that do not give back what the windows hold.

    Raises
    ------
    CallError
        W A differs from I beyond rounding, in what is estimated: which axis and which
        parameter.
    """
    weights, found = scheme.weights, scheme.seen
    inputs = scheme.turn + scheme.standing
    estimated = np.ones(weights.shape[:2], dtype=bool)
    if scheme.held is not None:
        found = scheme.held.join(found)
        estimated[:, :STATISTICS] = ~scheme.held.which
    found = np.concatenate([found, weights @ scheme.powers], axis=2)
    size = np.abs(inputs).max(initial=0.0) or 1.0
    scale = size ** np.array([1.0, 1.0, 1.0, 0.0, *scheme.orders])
    missed = np.abs(found - np.eye(len(scale))) * scale[:, None] / scale
    missed[:, :BIAS, BIAS] /= np.abs(weights[:, :BIAS]).sum(axis=2) * size + 1.0
    missed[~(estimated[:, :, None] & estimated[:, None, :])] = 0.0
    if not (missed < UNBIASED).all():
        axis, row, column = np.unravel_index(int(np.nanargmax(missed)), missed.shape)
        powers = [f"the input to the power {order}" for order in scheme.orders]
        rows = [*(f"response to {name}" for name in AXES), "bias", *powers]
        columns = [
            *(f"an input along {name}" for name in AXES),
            *("a constant bias", *powers),
        ]
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
        return np.flatnonzero(~self.by_parameter)

    @property
    def held(self) -> NDArray[np.intp]:
        """Places of what is not, among them."""
        return np.flatnonzero(self.by_parameter)

    @property
    def by_parameter(self) -> NDArray[np.bool_]:
        """Which of scale factors, angles and biases are held, shape (12,)."""
        own = self.which[[0, 1, 2], [0, 1, 2]]
        return np.concatenate([own, self.which[ROW, COLUMN], self.which[:, BIAS]])

    @property
    def nominal(self) -> Array:
        """Nominal parameters, (12,): K 1, angles, biases."""
        value = self.value
        return np.concatenate([np.ones(3), SIGN * value[ROW, COLUMN], value[:, BIAS]])

    def errors_of(self, truth: Truth) -> Array:
        """Return the errors of what is taken as nominal, (12, trials)."""
        _, angle, bias = np.split(self.nominal[:, None], (3, 9))
        parts = [truth.from_design, angle - truth.angle, bias - truth.bias]
        return np.concatenate(parts)

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
    powers: Mapping[int, Array] | None = None,
) -> Array:
    """Return the weights of least squares, (4 + m, n): W = (A^T C^-1 A)^-1 A^T C^-1.

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
    powers : mapping of int to ndarray, shape (n,), optional
        More columns, m of them: powers of an input, by the order.

    Raises
    ------
    CallError
        The windows cannot tell some parameters apart: which; or their covariance has
        no inverse.
    """
    powers = {} if powers is None else powers
    size = float(np.abs(inputs).max(initial=0.0)) or 1.0
    scale = size ** np.array([1.0, 1.0, 1.0, 0.0, *powers])
    free = np.ones(len(scale), dtype=bool)
    if held is not None:
        free[:STATISTICS] = ~held
    columns = np.column_stack([inputs, np.ones(len(inputs)), *powers.values()])
    A = (columns / scale)[:, free]
    W = np.zeros((len(scale), len(inputs)))
    if not free.any():
        return W
    names = [*(f"the response to {axis}" for axis in AXES), "the bias"]
    names += [f"order {order} of the input" for order in powers]
    kept = [name for name, is_free in zip(names, free, strict=True) if is_free]
    if mixed := not_told_apart(A, kept):
        raise CallError(
            f"these windows cannot tell apart: {mixed}. Add windows in which these "
            "inputs differ (a face turned down, a turn in the other sense), or hold a "
            "parameter (estimate: names the others)"
        )
    if covariance is not None:
        try:
            root = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:
            raise CallError(
                "the noise of these windows is one and the same to rounding, so that "
                "none can be weighed against another; take least_squares, or see to "
                "the lengths, starts and noise that are given"
            ) from None
        found = np.linalg.solve(root.T, np.linalg.pinv(np.linalg.solve(root, A)).T).T
        # Variances of windows that differ by many powers of ten cost W A = I digits.
        W[free] = found + (np.eye(len(found)) - found @ A) @ np.linalg.pinv(A)
    else:
        W[free] = np.linalg.pinv(A)
    W[np.abs(W) < ROUNDING * np.abs(W).max(axis=1, keepdims=True)] = 0.0
    return np.asarray(W / scale[:, None])


def not_told_apart(A: Array, names: Sequence[str]) -> str:
    """Say which columns of A, (n, m), its null vectors mix, by their names; '' if none.

    Any set of them spans the same: each is freed of a parameter that no other has then.
    """
    few = max(0, A.shape[1] - len(A))  # rows of 0 that show what so few leave open
    padded = np.pad(A, ((0, few), (0, 0)))
    _, singular, vectors = np.linalg.svd(padded, full_matrices=False)
    rows = vectors[singular <= RANK * singular.max()]
    for k in range(len(rows)):
        free = np.abs(rows[k:]).argmax()
        place, column = k + free // rows.shape[1], free % rows.shape[1]
        rows[[k, place]] = rows[[place, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= rows[others, column, None] * rows[k]
    words = []
    for row in rows:
        is_mixed = np.abs(row) > 1e-6 * np.abs(row).max()
        parts = [name for name, is_in in zip(names, is_mixed, strict=True) if is_in]
        alone = f"{parts[0]} from nothing at all (no window shows it)"
        words.append(alone if len(parts) == 1 else " and ".join(parts))
    return "; ".join(sorted(words))
