"""A temperature that both triads share, and what their parameters make of it.

T(t) - T0 = r t from the start of a triad's test; b = b0 + bT (T - T0) and K = K0 (1 +
kT (T - T0)), IEEE 1293 and 952. The coefficients are the device's, fixed
and of one sign on all axes; the ramp is what nobody knows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.source import Coefficient, Disturbance, Given, Moment, Triad

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.arrays import Array
    from budget.model.response import Truth
    from budget.model.source import Act

BIAS_COEFFICIENT = "bias_temperature_coefficient"


@dataclass(frozen=True)
class TemperatureCoefficient(Coefficient):
    """bT: change of a bias with the temperature."""

    needs = "a temperature that changes (temperature.ramp of the environment)"


@dataclass(frozen=True)
class TemperatureRamp(Disturbance):
    """e_i = bT_i r t, t the time in the middle of a window."""

    needs = f"a sensor with a coefficient ({BIAS_COEFFICIENT})"

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return r times the weighed times, axis by axis; None without coefficients."""
        coefficient = _coefficient(triad.given)
        if coefficient is None:
            return None
        times = triad.scheme.weigh(triad.scheme.schedule.middles[:, None])  # (3, 4, 1)
        drift = coefficient[:, None, None] * times

        return partial(_drifted, drift=drift)

    def reading(self, value: Array, moment: Moment) -> Array:
        """Return bT r t of every sample."""
        coefficient = _coefficient(moment.given)
        if coefficient is None:
            return np.zeros((3, 1))
        drift = value[0] * moment.samples.times
        return np.asarray(coefficient[:, None] * drift)


def _coefficient(given: Mapping[str, Given]) -> Array | None:
    """Return bT by axis [SI], None where the data sheet gives none."""
    line = given.get(BIAS_COEFFICIENT)
    return None if line is None else line.u


def _drifted(
    x: Array,
    truth: Truth,  # noqa: ARG001
    noise: Array,  # noqa: ARG001
    *,
    drift: Array,
) -> Array:
    """Return r times what a ramp of 1 leaves."""
    return np.asarray(drift * x[None])
