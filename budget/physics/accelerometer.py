"""Errors of the calibrated accelerometer parameters: Zhao 2019, eqs. (2), (5).

With body axis a up or down, s = +-1, axis i counts on average

    N = K_i [ s g M_ia + b_i + n_s ] ,   M = I + dT .

The difference of up and down, over 2 g K_i, is M_ia + (n+ - n-)/(2 g), from which
eq. (5) reads scale factors and angles; the sum gives the bias. In eq. (5) d_yz is
printed with N_x for N_y, and the second d_xy is d_xz: both are mended here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.physics.schedule import Schedule, schedule_accelerometer
from budget.physics.sources import SourceRows, TriadSources, error_sources
from budget.physics.triad import read_response, refer

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure, Sensor


@dataclass(frozen=True, kw_only=True, eq=False)
class AccelerometerCalibration:
    """The 12 accelerometer outputs as a function of the accelerometer's error sources.

    Attributes
    ----------
    bias : ndarray, shape (3,)
        Nominal bias [m/s^2].
    angle : ndarray, shape (6,)
        Nominal mounting angles [rad].
    gravity : float
        At the place [m/s^2].
    reference : str
        What the errors are counted from.
    """

    bias: Array
    angle: Array
    gravity: float
    reference: str
    rows: SourceRows

    def __call__(self, x: Array) -> Array:
        """Return the errors of all outputs.

        Parameters
        ----------
        x : ndarray, shape (n_inputs, trials)
            The accelerometer's inputs [SI].

        Returns
        -------
        ndarray, shape (12, trials)
            Scale factors [1], mounting angles [rad], biases [m/s^2], in the order of
            triad.OUTPUT_NAMES.
        """
        rows = self.rows
        bias = self.bias[:, None] + rows.constant(x, "bias_repeatability")
        angle = self.angle[:, None] + rows.constant(x, "mounting_repeatability")
        noise = rows.noise(x)
        response = read_response(noise[:, :3] / (2.0 * self.gravity), angle)
        # [N(up) + N(down)] / 2 K calibrated, eq. (5), minus the true bias.
        e = response.scale_factor
        bias_error = (noise[:, 3] - bias * e) / (1.0 + e)
        return refer(x, rows, self.reference, response, bias_error)


def accelerometer_calibration(
    sensor: Sensor,
    procedure: Procedure,
    *,
    reference: str,
    only: frozenset[str] | None = None,
) -> tuple[TriadSources, AccelerometerCalibration]:
    """Set up the accelerometer's sources and the function from them to its outputs."""
    schedule = schedule_accelerometer(procedure.accelerometer)
    sources = error_sources(
        sensor,
        schedule,
        np.stack([_statistics(schedule, axis) for axis in range(3)]),
        sample_rate=procedure.sample_rate,
        reference=reference,
        only=only,
    )
    calibration = AccelerometerCalibration(
        bias=sensor.nominal_bias,
        angle=sensor.nominal_mounting_angle,
        gravity=procedure.gravity,
        reference=reference,
        rows=sources.rows,
    )
    return sources, calibration


def _statistics(schedule: Schedule, axis: int) -> Array:
    """Return what eq. (5) uses of the window averages, shape (4, n_windows).

    Differences of up and down for body axes x, y, z, each face the mean of its two
    dwells; last the mean of up and down of the sensor's own axis.
    """
    n = len(schedule.windows)
    difference, own = np.zeros((3, n)), np.zeros((1, n))
    for up in range(3):
        difference[up, schedule.pick(up, 1)] = 0.5
        difference[up, schedule.pick(up, -1)] = -0.5
    own[0, schedule.pick(axis, 1)] = own[0, schedule.pick(axis, -1)] = 0.25
    return np.concatenate([difference, own])
