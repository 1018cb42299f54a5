"""Random processes as sums of sinusoids, which can be evaluated at any times."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt
from typing import TYPE_CHECKING, Self

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array


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
        """Return the sum at equally spaced times, shape (n_times,).

        With n = i m + j a wave at time t0 + n dt is the product of one at t0 + i m dt
        and one at j dt: some 2 sqrt(n_times) sines of each frequency, not n_times.
        """
        f, a, b = self.values
        step = (times[-1] - times[0]) / max(times.size - 1, 1)
        m = ceil(sqrt(times.size))
        rows = (a - 1j * b) * _waves(times[::m], f)  # its real part is a cos + b sin
        found = rows @ _waves(step * np.arange(m), f).T
        return np.asarray(found.real.reshape(-1)[: times.size])


def _waves(times: Array, frequencies: Array) -> NDArray[np.complex128]:
    """Return exp(2 pi i f t), shape (n_times, n_frequencies)."""
    return np.asarray(np.exp(2j * np.pi * np.outer(times, frequencies)))
