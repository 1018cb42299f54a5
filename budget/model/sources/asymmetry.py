"""Scale-factor asymmetry, by the sense of a turn or by the sign of the input."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.response import diagonal
from budget.model.source import Disturbance, Given, SimulatedWindow, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act

LEAST = 1e-40  # square of an amplitude below which it is rounding [SI squared]


@dataclass(frozen=True)
class TurnAsymmetry(Disturbance):
    """By the sense of the turn: Zhao 2019, eqs. (15), (16).

    K(+) = K (1 + Ka/2) in a + turn and K(-) = K (1 - Ka/2) in a - turn, all axes.

    With s the sense of the turn a reading of it holds e = s (Ka/2)(M u + b + noise);
    the dwells use the mean K. The input u holds the earth rate, which eq. (17) omits.
    """

    def weights(self, scheme: Scheme) -> Array:
        """Return W with the sign of each turn: sums where W has differences."""
        return scheme.weights * scheme.senses

    def bind(self, given: Given, triad: Triad) -> Act:  # noqa: ARG002
        """Return Ka/2 times the signed statistics of M u + b + noise."""
        scheme = triad.scheme
        signed = self.weights(scheme)
        # The turn itself cancels here as exactly as the earth rate does in W.
        seen = scheme.weigh(scheme.turn, signed) + scheme.weigh(scheme.standing, signed)
        constant = signed.sum(axis=2)
        R = triad.statistics.coefficients(signed)

        return partial(_signed, seen=seen, constant=constant, R=R)

    def in_use(self, x: Array, force: Array) -> Array:  # noqa: ARG002
        """Return |x|/2 of each axis: in use no table says what the sense of a turn is.

        In a turn of the table about the axis s (Ka/2) x is the same.
        """
        return diagonal(0.5 * np.abs(x))

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return s (Ka/2) times the reading."""
        return moment.window.sense * 0.5 * value[:, None] * moment.reading


def _signed(
    x: Array,
    truth: Truth,
    noise: Array,
    *,
    seen: Array,
    constant: Array,
    R: Array,
) -> Array:
    """Return Ka/2 (M v + b c + R noise) for the signed sums v, c and R of W."""
    inner = truth.see(seen) + constant[:, :, None] * truth.bias[:, None]
    if R.any():
        inner = inner + R @ noise
    return np.asarray(0.5 * x[:, None] * inner)


@dataclass(frozen=True)
class InputAsymmetry(Disturbance):
    """By the sign of the axis' own input x = (M u)_i + b_i: e = (Ka/2) |x| (IEEE 528).

    Of accelerometers it looks like a bias, db = Ka g/2; of gyros it is one of the
    static windows, and dk = Ka (b + earth rate)/(2 Omega). Noise is no part of x.
    """

    needs = "sources.estimate"

    def bind(self, given: Given, triad: Triad) -> Act:  # noqa: ARG002
        """Return Ka/2 times the weighed means of |x| over the windows."""
        scheme = triad.scheme
        return partial(_folded, weights=scheme.weights, harmonics=scheme.harmonics)

    def in_use(self, x: Array, force: Array) -> Array:  # noqa: ARG002
        """Return |x|/2 of each axis."""
        return diagonal(0.5 * np.abs(x))

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return (Ka/2) |x| of every sample's input."""
        return 0.5 * value[:, None] * np.abs(moment.true_input)


def _folded(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    weights: Array,
    harmonics: Array,
) -> Array:
    """Return Ka/2 times weighed means of |x|, x = A + C cos + S sin in a window."""
    a, c, s = (truth.see(np.tile(one, (3, 1, 1))) for one in harmonics)
    a = a + truth.bias[:, None]
    square = c * c + s * s  # of the amplitude
    # At a = 0 either side will do for a Taylor number: Ka a has the same variance.
    mean, swing = _numbers(a), _numbers(square)
    folded = np.where(mean < 0.0, -1.0, 1.0) * a
    both = (swing > LEAST) & (swing > mean * mean)  # x changes sign within the window
    folded[both] = _mean_absolute(a[both], square[both])
    return np.asarray(0.5 * x[:, None] * (weights @ folded))


def _numbers(values: Array) -> Array:
    """Return numbers without derivatives, of Taylor numbers too."""
    if values.dtype != object:
        return values
    return np.asarray(
        np.frompyfunc(lambda v: getattr(v, "value", v), 1, 1)(values), dtype=float
    )


def _mean_absolute(a: Array, square: Array) -> Array:
    """Return the mean of |a + r cos| over a whole turn, |a| <= r, `square` r^2.

    (2/pi) (a arcsin(a/r) + sqrt(r^2 - a^2)).
    """
    r = np.sqrt(square)
    return np.asarray((a * np.arcsin(a / r) + np.sqrt(square - a * a)) * (2.0 / np.pi))
