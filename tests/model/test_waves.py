"""Sums of waves at equally spaced times."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.model.waves import Waves


@pytest.mark.parametrize("n", [1, 2, 3, 7, 16, 1201])
def test_waves_are_the_sum_of_their_sines(n):
    """Every time has a cos(2 pi f t) + b sin(2 pi f t), at ends and between."""
    rng = np.random.default_rng(n)
    waves = Waves.draw(rng.uniform(1e-5, 2.0, 40), np.linspace(0.5, 2.0, 40), rng)
    times = 1234.5 + 0.25 * np.arange(n)
    f, a, b = waves.values
    phase = 2.0 * np.pi * f * times[:, None]
    exact = (a * np.cos(phase) + b * np.sin(phase)).sum(axis=1)
    assert_allclose(waves.at(times), exact, rtol=0, atol=1e-9)
