"""Figures 1 to 4: errors against steps of nonlinearity and of asymmetry."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, floor, log10, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import ROTATION_RATE
from budget.model.sources import GYRO
from budget.names import Name
from budget.spec.records import ANGLES, AXES
from budget.studies.paper.conditions import (
    PLACES,
    nominal_size,
    only_sources,
)
from budget.studies.paper.findings import (
    AGREES,
    AGREES_IN_ORDER,
    READING_FAILS,
    UNEXPLAINED,
    Finding,
    ratio_of,
    say,
)
from budget.studies.paper.printed import (
    ASYMMETRY_STEP,
    FIGURE_ORDERS,
    NONLINEARITY_STEP,
    RUNS,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.spec.records import Procedure, Sensor
    from budget.studies.paper.conditions import Conditions

PROPORTIONAL = 1e-4  # departure from a straight line over the largest value [1]
HALF_ULP = 2.0**-53  # of a ratio near 1 [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """One of the four figures, computed: relative errors against the step.

    Attributes
    ----------
    figure, source, parameter : str
        'figure 3', 'gyro.scale_factor_asymmetry', 'mounting_angle'.
    size : ndarray, shape (25,)
        Nonlinearity or asymmetry at i = 1 to 25 [1].
    errors : ndarray, shape (n, 25)
        Relative errors of the axes or angles [1].
    names : tuple of str, length n
    slopes : ndarray, shape (n,)
        Closed form of d error / d size [1].
    order : str
        What the paper reads off its figure.
    """

    figure: str
    source: Name
    parameter: str
    size: Array
    errors: Array
    names: tuple[str, ...]
    slopes: Array
    order: str

    @property
    def largest(self) -> float:
        """Largest absolute error [1]."""
        return float(np.abs(self.errors).max())

    @property
    def fitted_slopes(self) -> Array:
        """Rise from i = 1 to i = 25 over the step, shape (n,) [1]."""
        rise = self.errors[:, -1] - self.errors[:, 0]
        return np.asarray(rise / (self.size[-1] - self.size[0]))

    @property
    def departure(self) -> float:
        """Largest departure from the straight line through both ends, relative [1]."""
        line = self.errors[:, [0]] + self.fitted_slopes[:, None] * (
            self.size - self.size[0]
        )
        return float(np.abs(self.errors - line).max() / self.largest)


def compute_sweeps(conditions: Conditions) -> tuple[Sweep, ...]:
    """Calibrate error-free but for the step, 25 times: formulas of the paper."""
    gyro, procedure = conditions.gyro, conditions.printed
    angle, bias = _asymmetry_slopes(gyro, procedure)
    steps = np.arange(1, RUNS + 1)
    plans = (
        ("figure 1", "scale_factor_nonlinearity", "bias", NONLINEARITY_STEP, 0 * bias),
        (
            "figure 2",
            "scale_factor_nonlinearity",
            "mounting_angle",
            NONLINEARITY_STEP,
            0 * angle,
        ),
        ("figure 3", "scale_factor_asymmetry", "mounting_angle", ASYMMETRY_STEP, angle),
        ("figure 4", "scale_factor_asymmetry", "bias", ASYMMETRY_STEP, bias),
    )
    sweeps = []
    for figure, line, parameter, step, slopes in plans:
        source = Name(line, owner=GYRO)
        problem = only_sources(gyro, procedure, source)
        size = np.asarray(step * steps, dtype=float)
        errors = problem.evaluate(np.tile(size, (3, 1))) / nominal_size(gyro)[:, None]
        sweeps.append(
            Sweep(
                figure=figure,
                source=source,
                parameter=parameter,
                size=size,
                errors=errors[PLACES[parameter]],
                names=ANGLES if parameter == "mounting_angle" else AXES,
                slopes=slopes,
                order=FIGURE_ORDERS[figure],
            )
        )
    return tuple(sweeps)


def sweep_findings(
    sweeps: tuple[Sweep, ...], conditions: Conditions
) -> tuple[Finding, ...]:
    """Return the order of each figure, and the slopes of those that rise."""
    findings: list[Finding] = []
    for sweep in sweeps:
        findings.append(_order(sweep))
        if sweep.slopes.any():
            findings += _slopes(sweep)
    return (*findings, *_figure_3_readings(sweeps[2], conditions.gyro))


def power_of_ten(value: float) -> int:
    """Return k with 10^k <= |value| < 10^(k+1)."""
    return floor(log10(abs(value)))


def _asymmetry_slopes(gyro: Sensor, procedure: Procedure) -> tuple[Array, Array]:
    """Return d(relative error)/dKa of the angles, shape (6,), and biases, (3,).

    With G = T/(4 pi n) each row of the response takes up G Ka b off its diagonal and
    G Ka (b + e) on it, e = (0, w cos L, w sin L). Hence for an angle s G b / d0, s its
    sign in dT, and by eq. (4) for the biases -(b + w_i) G (b + e_i) + sum over k != i
    of G b (b + w_k), over b; w = (0, 0, w sin L). Terms in dT are left out, 1e-5.
    """
    b = float(gyro.nominal_bias[0])
    d0 = float(gyro.nominal_mounting_angle[0])
    gain = 1.0 / (2.0 * procedure.gyro.rate)  # T / (4 pi n)
    vertical = ROTATION_RATE * sin(procedure.latitude)
    e = np.array([0.0, ROTATION_RATE * cos(procedure.latitude), vertical])
    v = b + np.array([0.0, 0.0, vertical])
    sign = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
    bias = gain * (b * (v.sum() - v) - v * (b + e)) / b
    return sign * gain * b / d0, bias


def _order(sweep: Sweep) -> Finding:
    """Hold the largest error against the order that the text reads off the figure."""
    where = f"{sweep.figure}, {sweep.parameter.replace('_', ' ')}, order"
    printed, ours = float(sweep.order), sweep.largest
    step = "30 ppm x i" if sweep.figure in {"figure 1", "figure 2"} else "50 ppm x i"
    if ours == 0.0:
        return Finding(
            section="figures",
            where=where,
            printed=sweep.order,
            ours=0.0,
            verdict=AGREES,
            why=f"{step}: no effect; the printed order is {printed / HALF_ULP:.0f} "
            "times 2^-53, rounding of calibrated over nominal - 1",
            is_summary=True,
        )
    agrees = power_of_ten(ours) == power_of_ten(printed)
    why = f"{step}, largest at i = {RUNS}"
    if not sweep.slopes.any():
        why = (
            f"{step}: the same at every i, eq. (4)'s own error and no rounding, as the "
            "text has it"
        )
    elif not agrees:
        why += f": {say(ours, 3)}, {printed / ours:.0f} times below the order printed"
    return Finding(
        section="figures",
        where=where,
        printed=sweep.order,
        ours=ours,
        ratio=ratio_of(ours, printed),
        verdict=AGREES_IN_ORDER if agrees else UNEXPLAINED,
        why=why,
        is_summary=True,
    )


def _slopes(sweep: Sweep) -> list[Finding]:
    """Say of every axis or angle that its error is proportional to the asymmetry."""
    straight = sweep.departure <= PROPORTIONAL
    return [
        Finding(
            section="figures",
            where=f"{sweep.figure}, {sweep.parameter.replace('_', ' ')} {name}, slope",
            printed="proportional",
            ours=float(found),
            verdict=AGREES if straight else UNEXPLAINED,
            why=f"relative error per unit of asymmetry; closed form {say(closed, 5)}; "
            f"straight to {say(sweep.departure, 1)} of the largest error",
        )
        for name, found, closed in zip(
            sweep.names, sweep.fitted_slopes, sweep.slopes, strict=True
        )
    ]


def _figure_3_readings(sweep: Sweep, gyro: Sensor) -> list[Finding]:
    """Try readings of figure 3; what changes it must leave figure 4 as it is."""
    ours = sweep.largest
    bias = float(np.abs(gyro.nominal_bias[0]))
    readings = (
        (
            "axis in per cent",
            100.0,
            "has the order; but figure 4, drawn alike, then misses its own by 100",
        ),
        (
            "the 1200 s of the dwells as t in eq. (12)",
            1200.0 / 18.0,
            "has the order; but the biases of figure 4 grow alike, to 67 times theirs",
        ),
        (
            "the whole earth rate added to the bias",
            1.0 + ROTATION_RATE / bias,
            "not enough",
        ),
    )
    return [
        Finding(
            section="readings",
            where=f"figure 3, mounting angle: {name}",
            printed=sweep.order,
            ours=factor * ours,
            ratio=ratio_of(factor * ours, float(sweep.order)),
            verdict=READING_FAILS,
            why=why,
            is_summary=True,
        )
        for name, factor, why in readings
    ]
