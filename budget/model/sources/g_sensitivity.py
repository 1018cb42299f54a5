"""Gyro g-sensitivity: what a specific force adds to a rate (IEEE 952)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance, Given, SimulatedWindow, Triad

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act

# G_ij: what axis i shows of a force along body axis j.
ELEMENTS = tuple(f"{i}{j}" for i in "xyz" for j in "xyz")


@dataclass(frozen=True)
class GSensitivity(Disturbance):
    """e_i = sum_j G_ij f_j, f the specific force in body axes.

    Whole turns feel the same mean force in both senses, so that a rate test shows
    nothing; static windows with z up take G_iz g for a bias.
    """

    def bind(self, given: Given, triad: Triad) -> Act:  # noqa: ARG002
        """Return G times the weighed force, statistic by statistic."""
        force = triad.scheme.weigh(triad.scheme.force)  # (3, 4, 3)

        return partial(_sensed, force=force)

    def in_use(self, x: Array, force: Array) -> Array:  # noqa: ARG002
        """Return the force in the rows of its elements."""
        rows = np.eye(3)[:, :, None] * force[..., None, None, :]
        return np.asarray(rows.reshape(*force.shape, len(ELEMENTS)))

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return G f of every sample."""
        return np.asarray(value.reshape(3, 3) @ moment.force)


def _sensed(
    x: Array,
    truth: Truth,  # noqa: ARG001
    noise: Array,  # noqa: ARG001
    *,
    force: Array,
) -> Array:
    """Return G f for weighed forces f."""
    G = x.reshape(3, 3, -1)
    return np.asarray((force[..., None] * G[:, None]).sum(axis=2))
