"""Random processes as sums of waves: the same at whatever times they are asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array

AT_ONCE = 10_000  # times, of a few hundred waves: some 50 MB


@dataclass(frozen=True)
class Waves:
    """Sum of a cos(2 pi f t) + b sin(2 pi f t), a and b normal.

    With frequencies drawn at random, each from its own part of the spectrum, the
    covariance over draws is exactly that of the spectrum (Rice 1944).

    Attributes
    ----------
    values : ndarray, shape (3, n)
        f [Hz], a and b.
    """

    values: Array

    @classmethod
    def draw(cls, frequencies: Array, sizes: Array, rng: np.random.Generator) -> Self:
        """Draw a and b; `sizes` are their standard deviations, shape (n,)."""
        parts = sizes * rng.standard_normal((2, sizes.size))
        return cls(np.concatenate([frequencies[None], parts]))

    def at(self, times: Array) -> Array:
        """Return the sum at times, shape (n_times,)."""
        found = np.empty(times.size)
        for first in range(0, times.size, AT_ONCE):
            some = slice(first, first + AT_ONCE)
            phase = 2.0 * np.pi * np.outer(times[some], self.values[0])
            found[some] = (
                np.cos(phase) @ self.values[1] + np.sin(phase) @ self.values[2]
            )
        return found
