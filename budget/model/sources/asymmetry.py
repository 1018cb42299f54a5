"""Scale-factor asymmetry by the sense of the turn: Zhao 2019, eqs. (15), (16)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, Moment, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act


@dataclass(frozen=True)
class TurnAsymmetry(Disturbance):
    """K(+) = K (1 + Ka/2) in a + turn and K(-) = K (1 - Ka/2) in a - turn, all axes.

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

    def reading(self, value: Array, moment: Moment) -> Array:
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
