"""Spectrum of a recording: its periodic lines, and what it is over a model's."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array

AVERAGES = 100  # segments at the least, of half overlap
LONGEST, SHORTEST = 2**14, 256  # samples of a segment
ABOVE = 3.0  # times the median of the neighbours [1]
NEIGHBOURS = 50  # bins on each side
FIRST = 20  # bin: below it a spectrum rises by itself
LOBE = 2  # bins on each side that a line of a Hann window fills
PARTS = 16  # of a decade, of a spectrum that is shown
MOST = 10  # lines that are told, the largest first
MOST_MISSING = 0.02  # of the samples [1]


def welch_spectrum(values: Array, rate: float) -> tuple[Array, Array] | None:
    """Return frequencies [Hz] and one-sided power density [unit^2/Hz] of a recording.

    By Welch's method of Hann windows, 100 at the least. Missing values are taken at the
    mean; None where they are more than 2 %, or too few are there.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The first samples, nan where one is missing [unit].
    rate : float
        [Hz].
    """
    from scipy.signal import welch

    there = np.isfinite(values)
    n = len(values)
    size = 2 ** int(np.log2(max(2 * n // (AVERAGES + 1), 1)))
    size = min(size, LONGEST)
    if size < SHORTEST or there.sum() < (1.0 - MOST_MISSING) * n:
        return None
    filled = np.where(there, values, values[there].mean())
    frequency, power = welch(filled, rate, "hann", size)
    return frequency, power


def residual_spectrum(
    spectrum: tuple[Array, Array], density: Callable[[Array], Array]
) -> list[tuple[float, float]]:
    """Return a spectrum over that of a model, means of parts of a decade.

    Frequency [Hz] and ratio [1]: about 1 where the model holds.

    Parameters
    ----------
    spectrum : (ndarray, ndarray)
        Of `welch_spectrum`.
    density : callable
        One-sided power density of the model at frequencies [unit^2/Hz].
    """
    frequency, power = (one[LOBE:-1] for one in spectrum)  # mean and Nyquist apart
    ratio = power / density(frequency)
    number = max(int(PARTS * np.log10(frequency[-1] / frequency[0])), 1)
    edges = np.geomspace(frequency[0], frequency[-1] * (1.0 + 1e-9), number + 1)
    place = np.searchsorted(edges, frequency, side="right") - 1
    return [
        (float(np.exp(np.log(frequency[own]).mean())), float(ratio[own].mean()))
        for k in range(number)
        if (own := place == k).any()
    ]


def periodic_lines(spectrum: tuple[Array, Array]) -> list[tuple[float, float]]:
    """Return frequency [Hz] and amplitude [unit] of lines, the largest first.

    A line of amplitude A has the power A^2/2 over the bins of its lobe.

    Parameters
    ----------
    spectrum : (ndarray, ndarray)
        Of `welch_spectrum`.
    """
    from scipy.ndimage import median_filter

    frequency, power = spectrum
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
