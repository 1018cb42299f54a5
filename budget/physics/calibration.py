"""The whole calibration as one Problem: sources of both triads to 24 parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import ROTATION_RATE
from budget.physics.accelerometer import accelerometer_calibration
from budget.physics.gyroscope import gyro_calibration
from budget.physics.triad import OUTPUT_NAMES
from budget.problem import Function, Group, Output, Problem
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, PPM

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure, Sensor

BIAS_UNITS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}

# Spread below this part of a parameter's natural size is rounding of doubles: of a
# scale factor 1, of an angle 1 rad, of a bias the input it is measured beside.
ROUNDING = 1e-14  # [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """The function of the Problem: each triad works on its own rows."""

    triads: tuple[tuple[slice, Function], ...]

    def __call__(self, x: Array) -> Array:
        """Return all outputs, shape (n_outputs, trials), for x (n_inputs, trials)."""
        return np.concatenate([function(x[rows]) for rows, function in self.triads])


def calibration_problem(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    reference: str = "nominal",
    only: frozenset[str] | None = None,
) -> Problem:
    """Set up the calibration of one or two triads.

    Parameters
    ----------
    sensors : tuple of Sensor
        At most one gyro and one accelerometer.
    procedure : Procedure
        Turns and dwells, the place, the formulas.
    reference : str
        What errors are counted from: 'nominal', 'as_tested', 'next_turn_on'.
    only : frozenset of str, optional
        Full names of the sources that count; all others are set to 0.

    Returns
    -------
    Problem
        Sources as groups, 12 outputs for each triad; errors, calibrated value minus
        reference [1, rad, rad/s, m/s^2].
    """
    groups: list[Group] = []
    outputs: list[Output] = []
    triads: list[tuple[slice, Function]] = []
    row = 0
    for sensor in sensors:
        set_up = (
            gyro_calibration if sensor.kind == "gyro" else accelerometer_calibration
        )
        sources, function = set_up(sensor, procedure, reference=reference, only=only)
        n = sum(group.size for group in sources.groups)
        groups.extend(sources.groups)
        outputs.extend(_outputs(sensor, procedure))
        triads.append((slice(row, row + n), function))
        row += n
    return Problem(
        groups=tuple(groups),
        outputs=tuple(outputs),
        function=Calibration(triads=tuple(triads)),
    )


def _outputs(sensor: Sensor, procedure: Procedure) -> tuple[Output, ...]:
    """Name the outputs of one triad, with units and the size of their rounding."""
    beside = ROTATION_RATE if sensor.kind == "gyro" else procedure.gravity  # [SI]
    natural_bias = beside + float(np.abs(sensor.nominal_bias).max())
    kinds = {
        "scale_factor": ("ppm", PPM, 1.0),
        "mounting_angle": ("arcsec", ARCSEC, 1.0),
        "bias": (*BIAS_UNITS[sensor.kind], natural_bias),
    }
    outputs = []
    for name in OUTPUT_NAMES:
        unit, si_per_unit, size = kinds[name.split(".")[0]]
        outputs.append(
            Output(
                name=f"{sensor.kind}.{name}",
                unit=unit,
                si_per_unit=si_per_unit,
                resolution=ROUNDING * size,
            )
        )
    return tuple(outputs)
