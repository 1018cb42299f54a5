"""Periodic lines in a recording: bins of its Welch spectrum above their neighbours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from budget.arrays import Array

AVERAGES = 100  # segments at the least, of half overlap
LONGEST, SHORTEST = 2**14, 256  # samples of a segment
ABOVE = 3.0  # times the median of the neighbours [1]
NEIGHBOURS = 50  # bins on each side
FIRST = 20  # bin: below it a spectrum rises by itself
LOBE = 2  # bins on each side that a line of a Hann window fills
MOST = 10  # lines that are told, the largest first
MOST_MISSING = 0.02  # of the samples [1]


def periodic_lines(values: Array, rate: float) -> list[tuple[float, float]]:
    """Return frequency [Hz] and amplitude [unit] of lines, the largest first.

    A line of amplitude A has the power A^2/2 over the bins of its lobe. Missing values
    are taken at the mean, up to 2 % of them.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The first samples, nan where one is missing [unit].
    rate : float
        [Hz].
    """
    from scipy.ndimage import median_filter
    from scipy.signal import welch

    there = np.isfinite(values)
    n = len(values)
    size = 2 ** int(np.log2(max(2 * n // (AVERAGES + 1), 1)))
    size = min(size, LONGEST)
    if size < SHORTEST or there.sum() < (1.0 - MOST_MISSING) * n:
        return []
    filled = np.where(there, values, values[there].mean())
    frequency, power = welch(filled, rate, "hann", size)
    floor = median_filter(power, 2 * NEIGHBOURS + 1, mode="nearest")
    over = np.where(power > ABOVE * floor, power, 0.0)
    over[:FIRST] = 0.0
    found: list[tuple[float, float]] = []
    while over.any() and len(found) < MOST:
        top = int(over.argmax())
        lobe = slice(max(top - LOBE, 0), top + LOBE + 1)
        own = np.maximum(power[lobe] - floor[lobe], 0.0)
        width = frequency[1] - frequency[0]
        middle = float(own @ frequency[lobe] / own.sum())
        found.append((middle, float(np.sqrt(2.0 * own.sum() * width))))
        over[max(top - 2 * LOBE, 0) : top + 2 * LOBE + 1] = 0.0
    return sorted(found, key=lambda one: -one[1])
