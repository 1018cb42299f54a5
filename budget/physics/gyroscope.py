"""Errors of the calibrated gyro parameters: Zhao 2019, eqs. (1), (3), (4), (15)-(17).

With R T = 2 pi n the turn angle, s = +-1 its sense, M = I + dT and e_a the mean earth
rate during a turn about axis a, axis i counts in such a turn (eq. 6)

    N = K_i (1 + s Ka_i/2) [ s R M_ia + (M e_a)_i + b_i + n_s ] T .

The difference of the + and the - turn, over 4 pi n K_i, is M_ia + epsilon_ia with

    epsilon_ia = T/(4 pi n) [ n+ - n- + Ka_i ((M e_a)_i + b_i + (n+ + n-)/2) ] ,

from which eq. (3) reads scale factors and angles. Everything here is that identity and
eq. (4), written as errors; nothing is linearised.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import ROTATION_RATE
from budget.physics.schedule import Schedule, schedule_gyro
from budget.physics.sources import SourceRows, TriadSources, error_sources
from budget.physics.triad import (
    ResponseError,
    read_response,
    refer,
    tilt,
    tilt_transposed,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure, Sensor

# Azimuths that balance leave sums of sines of this size [1], by rounding.
BALANCED = 1e-14


@dataclass(frozen=True, kw_only=True, eq=False)
class GyroCalibration:
    """The 12 gyro outputs as a function of the gyro's error sources.

    Attributes
    ----------
    bias : ndarray, shape (3,)
        Nominal bias [rad/s].
    angle : ndarray, shape (6,)
        Nominal mounting angles [rad].
    gain : float
        T / (4 pi n) [s/rad].
    turn_earth : ndarray, shape (3, 3)
        Mean earth rate during the turns: row a is e_a in body axes [rad/s].
    static_earth : ndarray, shape (3,)
        Mean earth rate over the static dwells, in body axes [rad/s].
    formulas, reference : str
        Bias formula; what the errors are counted from.
    asymmetric : bool
        Whether scale-factor asymmetry is among the sources.
    """

    bias: Array
    angle: Array
    gain: float
    turn_earth: Array
    static_earth: Array
    formulas: str
    reference: str
    asymmetric: bool
    rows: SourceRows

    def __call__(self, x: Array) -> Array:
        """Return the errors of all outputs.

        Parameters
        ----------
        x : ndarray, shape (n_inputs, trials)
            The gyro's inputs [SI].

        Returns
        -------
        ndarray, shape (12, trials)
            Scale factors [1], mounting angles [rad], biases [rad/s], in the order of
            triad.OUTPUT_NAMES.
        """
        rows = self.rows
        bias = self.bias[:, None] + rows.constant(x, "bias_repeatability")
        angle = self.angle[:, None] + rows.constant(x, "mounting_repeatability")
        noise = rows.noise(x)
        epsilon = self._response_error(x, bias, angle, noise)
        response = read_response(epsilon, angle)
        bias_error = self._bias_error(bias, angle, noise[:, 3], response)
        return refer(x, rows, self.reference, response, bias_error)

    def _response_error(
        self, x: Array, bias: Array, angle: Array, noise: Array
    ) -> Array:
        """Return epsilon_ia, shape (3, 3, trials) [1]: differences of turns, eq. (6).

        The asymmetry term holds the mean earth rate, which eq. (17) omits.
        """
        difference = noise[:, :3]  # n+ - n- by turn axis
        if not self.asymmetric:
            return np.asarray(self.gain * difference)
        mean = noise[:, 4:7]  # (n+ + n-)/2 by turn axis
        Ka = self.rows.constant(x, "scale_factor_asymmetry")  # eqs. (15), (16)
        standing = np.stack(  # (M e_a)_i
            [e[:, None] + tilt(angle, e) for e in self.turn_earth], axis=1
        )
        odd = Ka[:, None] * (standing + bias[:, None] + mean)
        return np.asarray(self.gain * (difference + odd))

    def _bias_error(
        self, bias: Array, angle: Array, noise: Array, response: ResponseError
    ) -> Array:
        """Return calibrated minus true bias, shape (3, trials) [rad/s]: eq. (4).

        With w the mean earth rate over the dwells and v = mean(N)/K calibrated:

        corrected: v - (I + dT) w, which inverts eq. (1);
        paper: (I + dT^T) v - w. Eq. (4) as printed undoes the mounting angles by the
        transpose, which is right only where dT is antisymmetric and the bias is given
        in body axes; here it leaves (dT + dT^T) w + dT^T b + dT^T dT w.
        """
        w = self.static_earth
        standing = w[:, None] + tilt(angle, w) + bias  # mean(N)/K without error
        e = response.scale_factor
        v_error = (noise - standing * e) / (1.0 + e)
        if self.formulas == "paper":
            calibrated = angle + response.mounting_angle
            v = standing + v_error
            return v_error + tilt(angle, w) + tilt_transposed(calibrated, v)
        return np.asarray(v_error - tilt(response.mounting_angle, w))


def gyro_calibration(
    sensor: Sensor,
    procedure: Procedure,
    *,
    reference: str,
    only: frozenset[str] | None = None,
) -> tuple[TriadSources, GyroCalibration]:
    """Set up the gyro's error sources and the function from them to its outputs."""
    schedule = schedule_gyro(procedure.gyro)
    asymmetry = sensor.line("scale_factor_asymmetry")
    asymmetric = asymmetry is not None and bool(asymmetry.u.any())
    sources = error_sources(
        sensor,
        schedule,
        np.tile(_statistics(schedule, asymmetric=asymmetric), (3, 1, 1)),
        sample_rate=procedure.sample_rate,
        reference=reference,
        only=only,
    )
    horizontal = ROTATION_RATE * cos(procedure.latitude)
    vertical = ROTATION_RATE * sin(procedure.latitude)
    calibration = GyroCalibration(
        bias=sensor.nominal_bias,
        angle=sensor.nominal_mounting_angle,
        gain=1.0 / (2.0 * procedure.gyro.rate),  # T / (4 pi n), T = 2 pi n / rate
        # Whole turns average the part across the axis to zero: east, north, up.
        turn_earth=np.diag([0.0, horizontal, vertical]),
        static_earth=_mean_earth(procedure.gyro.azimuths, horizontal, vertical),
        formulas=procedure.formulas,
        reference=reference,
        asymmetric=asymmetric,
        rows=sources.rows,
    )
    return sources, calibration


def _statistics(schedule: Schedule, *, asymmetric: bool) -> Array:
    """Return what eqs. (3), (4) use of the window averages, shape (k, n_windows).

    Differences of the + and the - turn about x, y, z; the mean over the static dwells;
    with asymmetry the means of the + and the - turn too.
    """
    n = len(schedule.windows)
    difference, mean, static = np.zeros((3, n)), np.zeros((3, n)), np.zeros((1, n))
    for axis in range(3):
        plus, minus = schedule.pick(axis, 1), schedule.pick(axis, -1)
        difference[axis, plus], difference[axis, minus] = 1.0, -1.0
        mean[axis, plus] = mean[axis, minus] = 0.5
    static[0, schedule.azimuths] = 1.0 / len(schedule.azimuths)
    return np.concatenate([difference, static, *([mean] if asymmetric else [])])


def _mean_earth(
    azimuths: tuple[float, ...], horizontal: float, vertical: float
) -> Array:
    """Return the earth rate in body axes, mean over the azimuths: Zhao 2019, 1.2.2."""
    east, north = np.mean(np.sin(azimuths)), np.mean(np.cos(azimuths))
    return np.array(
        [
            0.0 if abs(east) < BALANCED else horizontal * east,
            0.0 if abs(north) < BALANCED else horizontal * north,
            vertical,
        ]
    )
