"""How accurate a number must be to be worth its digits: JCGM 101:2008, 7.9.2."""

from __future__ import annotations

from math import floor, log10
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.problem import Output


def numerical_tolerance(u: Array, outputs: tuple[Output, ...], digits: int) -> Array:
    """Return delta of every output, shape (n_out,) [SI].

    u = c 10^l with c an integer of so many digits, delta = 10^l / 2. The digits are
    those of the number as it is printed, in the output's unit. A spread that is only
    rounding has the tolerance of its resolution.

    Parameters
    ----------
    u : ndarray, shape (n_out,)
        Standard uncertainties [SI].
    outputs : tuple of Output
        Their units and resolutions.
    digits : int
        Significant digits wanted of u.
    """
    return np.array(
        [
            _half_last_digit(value / output.si_per_unit, digits) * output.si_per_unit
            if value > output.resolution
            else output.resolution
            for value, output in zip(u, outputs, strict=True)
        ]
    )


def _half_last_digit(u: float, digits: int) -> float:
    """Return half a unit in the last of the significant digits of u."""
    last = floor(log10(u)) - digits + 1
    if round(u / 10.0**last) == 10**digits:  # 9.96 has two digits as 10, not 9.9
        last += 1
    return 0.5 * 10.0**last
