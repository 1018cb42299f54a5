"""Higher orders of a scale factor, K2 and K3 (IEEE 1293, 952)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from budget.model.response import diagonal
from budget.model.source import Disturbance, Given, SimulatedWindow, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act


@dataclass(frozen=True)
class Power(Disturbance):
    """e = K_p x^p with x = (M u)_i + b_i, the input of the axis itself.

    Of accelerometers an even order is alike up and down and looks like a bias: db =
    K2 (g^2 - b^2), dk = 2 K2 b; an odd one like a scale factor: dk = K3 (g^2 + 3 b^2),
    db = 2 K3 g^2 b. Of gyros a turn shows dk = K3 Omega^2, dk = 2 K2 (b + earth rate);
    what they add at other rates a later run meets. Noise is no part of x.

    Attributes
    ----------
    order : int
        p, 2 or more.
    """

    needs = "sources.order"

    order: int

    def bind(self, given: Given, triad: Triad) -> Act:  # noqa: ARG002
        """Return K_p times the weighed powers.

        sum W (m u + b)^p = sum_k C(p, k) b^(p - k) sum W (m u)^k, the last of them the
        weighed tensor u...u (k times, mean over a turn) contracted with m as often.
        """
        scheme = triad.scheme
        u = scheme.within
        tensors, tensor = [], np.ones((*u.shape[:2], 1))
        for _ in range(self.order + 1):
            tensors.append(scheme.weigh(tensor.mean(axis=1)))
            tensor = (tensor[..., None] * u[:, :, None]).reshape(*u.shape[:2], -1)
        return partial(_powered, tensors=tuple(tensors))

    def in_use(self, x: Array, force: Array) -> Array:  # noqa: ARG002
        """Return x^p of each axis."""
        return diagonal(x**self.order)

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return K_p x^p of every sample's input."""
        return value[:, None] * moment.true_input**self.order


def _powered(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    tensors: tuple[Array, ...],
) -> Array:
    """Return K_p times the weighed powers of M u + b."""
    m = truth.see(np.tile(np.eye(3), (3, 1, 1)))  # rows of M, (3, 3, trials)
    b = truth.bias[:, None]
    order = len(tensors) - 1
    total: Array | float = 0.0
    for k, tensor in enumerate(tensors):
        part = tensor[..., None]
        for left in reversed(range(k)):
            part = part.reshape(*tensor.shape[:2], 3**left, 3, -1)
            part = (part * m[:, None, None]).sum(axis=3)
        total = total + comb(order, k) * b ** (order - k) * part[:, :, 0]
    return np.asarray(x[:, None] * total)
