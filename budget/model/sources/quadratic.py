"""Second-order scale factor of an accelerometer, K2 (IEEE 1293)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, Moment, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act


@dataclass(frozen=True)
class Quadratic(Disturbance):
    """e = K2 x^2 with x = (M u)_i + b_i, the input of the axis itself.

    Up and down alike, so that it looks like a bias: db = K2 (g^2 - b^2), dk = 2 K2 b.
    Noise in x^2 is left out: its square is 1e-6 of an accelerometer's noise at most.
    """

    def bind(self, given: Given, triad: Triad) -> Act:  # noqa: ARG002
        """Return K2 times the weighed squares.

        sum W (m u + b)^2 = m^T (sum W u u^T) m + 2 b m (sum W u) + b^2 sum W.
        """
        scheme = triad.scheme
        u = scheme.turn + scheme.standing
        squares = scheme.weigh((u[:, :, None] * u[:, None]).reshape(-1, 9))
        squares = squares.reshape(3, -1, 3, 3)
        means, total = scheme.weigh(u), scheme.weights.sum(axis=2)[..., None]

        return partial(_squared, squares=squares, means=means, total=total)

    def reading(self, value: Array, moment: Moment) -> Array:
        """Return K2 x^2 of every sample's input."""
        return value[:, None] * moment.true_input**2


def _squared(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    squares: Array,
    means: Array,
    total: Array,
) -> Array:
    """Return K2 times the weighed squares of M u + b."""
    m = truth.see(np.tile(np.eye(3), (3, 1, 1)))  # rows of M, (3, 3, trials)
    b = truth.bias[:, None]
    linear = (means[..., None] * m[:, None]).sum(axis=2)
    inner = (squares[..., None] * m[:, None, None]).sum(axis=3)
    bent = (inner * m[:, None]).sum(axis=2)
    return np.asarray(x[:, None] * (bent + 2.0 * b * linear + b**2 * total))
