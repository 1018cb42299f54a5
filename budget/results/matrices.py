"""Compensation matrices: what turns readings into inputs, with uncertainties."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from budget.documents import Documented, written
from budget.language import note

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.names import Name
    from budget.problem import Output

CONVENTION = note(
    "Reading n of the axes, in counts a second, of an input u in body axes: "
    "n = K (M u + b), M = I + dT. Row i of M is what axis i shows of the body axes x, "
    "y, z. Back: u = T (n/K - b) with the bias b in sensor axes, or u = T n/K - T b "
    "with T b in body axes; T = inv(M), body from sensor axes."
)


def in_units(covariance: Array, outputs: Sequence[Output]) -> Array:
    """Return a covariance of outputs in products of their units."""
    scale = np.array([output.si_per_unit for output in outputs])
    return np.asarray(covariance / np.outer(scale, scale))


@written(
    "bias_of_matrix",
    """
    unit = output.unit
    value / unit (list[float])
    standard_uncertainty / unit (list[float])
    """,
    said="What turns readings into inputs, of one triad, at its nominal values.",
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Bias:
    """Biases of the three axes of a triad [SI]."""

    output: Output  # of the first axis
    value: Array
    standard_uncertainty: Array


@written(
    "matrices",
    """
    body_to_sensor = self as matrix: M, whose row i is what axis i shows of the body
      axes
    sensor_to_body = self as uncertain_matrix: T, the inverse of M
    bias_sensor = sensor_axes as bias_of_matrix: taken off before T
    bias_body = body_axes as bias_of_matrix: taken off after T
    bias_lower_bound = lacks.9 (bool): whether lines that are not given would widen
      the biases
    covariance = printed (list[list[float]]) [products of units]: of T row by row, bias
      in sensor axes, bias in body axes
    """,
    sensor_axes=lambda found: found.bias(9),
    body_axes=lambda found: found.bias(12),
    printed=lambda found: in_units(found.covariance, found.outputs),
)
@written(
    "uncertain_matrix",
    """
    value = T (list[list[float]]) [1]: row by row
    standard_uncertainty = u (list[list[float]]) [1]: of its elements
    lower_bound = lacks.0 (bool): whether lines that are not given would widen it
    """,
    u=lambda found: found.standard_uncertainty[:9].reshape(3, 3),
)
@written(
    "matrix",
    """
    value = M (list[list[float]]) [1]: row by row
    """,
)
@dataclass(frozen=True, kw_only=True, eq=False)
class Compensation(Documented):
    """What turns readings into inputs, of one triad, at its nominal values.

    Attributes
    ----------
    sensor : str
    outputs : tuple of Output, length 15
        T row by row, b in sensor axes, T b in body axes.
    value : ndarray, shape (15,)
        At the nominal values of the device [SI].
    covariance : ndarray, shape (15, 15)
        Joint, of what a calibration finds [products of SI units].
    lacks : tuple of tuple of Name, length 15
        Expected lines that are not given and would widen each output.
    """

    sensor: str
    outputs: tuple[Output, ...]
    value: Array
    covariance: Array = field(repr=False)
    lacks: tuple[tuple[Name, ...], ...] = ((),) * 15

    @property
    def standard_uncertainty(self) -> Array:
        """Standard uncertainties in the order of the outputs, shape (15,) [SI]."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def T(self) -> Array:
        """Body from sensor axes, shape (3, 3) [1]."""
        return self.value[:9].reshape(3, 3)

    @property
    def M(self) -> Array:
        """Sensor from body axes, I + dT, shape (3, 3) [1]."""
        return np.asarray(np.linalg.inv(self.T))

    @property
    def bias_sensor(self) -> Array:
        """Bias b, taken off before T, shape (3,) [SI]."""
        return self.value[9:12]

    @property
    def bias_body(self) -> Array:
        """Bias T b, taken off after T, shape (3,) [SI]."""
        return self.value[12:]

    def bias(self, first: int) -> Bias:
        """Return three biases, the first of which stands there among the outputs."""
        own = slice(first, first + 3)
        return Bias(
            output=self.outputs[first],
            value=self.value[own],
            standard_uncertainty=self.standard_uncertainty[own],
        )
