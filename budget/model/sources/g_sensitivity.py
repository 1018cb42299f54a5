"""Gyro g-sensitivity: what a specific force adds to a rate (IEEE 952)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Disturbance

if TYPE_CHECKING:
    from budget.arrays import Array

# G_ij: what axis i shows of a force along body axis j.
ELEMENTS = tuple(f"{i}{j}" for i in "xyz" for j in "xyz")


@dataclass(frozen=True)
class GSensitivity(Disturbance):
    """e_i = sum_j G_ij f_j, f the specific force in body axes.

    Whole turns feel the same mean force in both senses, so that a rate test shows
    nothing; static windows with z up take G_iz g for a bias.
    """

    def in_use(self, x: Array, force: Array) -> Array:  # noqa: ARG002
        """Return the force in the rows of its elements."""
        rows = np.eye(3)[:, :, None] * force[..., None, None, :]
        return np.asarray(rows.reshape(*force.shape, len(ELEMENTS)))
