"""Figures 1 to 4: errors against steps of nonlinearity and of asymmetry."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, floor, log10, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.earth import ROTATION_RATE
from budget.model.sources import GYRO
from budget.names import PARAMETERS, Name
from budget.studies.paper.conditions import HALF_ULP, PLACES, nominal_size, only_sources
from budget.studies.paper.findings import (
    RUNS,
    Finding,
    Verdict,
    agrees_if,
    ratio_of,
    say,
    words,
)

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import PrintedFigure

PROPORTIONAL = 1e-4  # departure from a straight line over the largest value [1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sweep:
    """One of the four figures, computed: relative errors against the step.

    Attributes
    ----------
    figure, source : str
        'figure 3', 'gyro.scale_factor_asymmetry'.
    given : PrintedFigure
        What is stepped, and what the paper reads off its figure.
    size : ndarray, shape (25,)
        Nonlinearity or asymmetry at i = 1 to 25 [1].
    errors : ndarray, shape (n, 25)
        Relative errors of the axes or angles [1].
    slopes : ndarray, shape (n,)
        Closed form of d error / d size [1].
    """

    figure: str
    source: Name
    given: PrintedFigure
    size: Array
    errors: Array
    slopes: Array

    @property
    def names(self) -> tuple[str, ...]:
        """Axes or angles, length n."""
        return PARAMETERS[self.given.parameter]

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
    nominal = nominal_size(conditions.gyro)
    rising = _asymmetry_slopes(conditions)
    sweeps = []
    for figure, given in conditions.paper.figures.items():
        place, source = PLACES[given.parameter], Name(given.source, owner=GYRO)
        problem = only_sources(conditions.gyro, conditions.printed, source)
        size = given.step * np.arange(1.0, RUNS + 1.0)
        errors = problem.evaluate(np.tile(size, (3, 1))) / nominal[:, None]
        rises = source.quantity == "scale_factor_asymmetry"
        sweeps.append(
            Sweep(
                figure=figure,
                source=source,
                given=given,
                size=size,
                errors=errors[place],
                slopes=rising[place] * rises,
            )
        )
    return tuple(sweeps)


def power_of_ten(value: float) -> int:
    """Return k with 10^k <= |value| < 10^(k+1)."""
    return floor(log10(abs(value)))


def _asymmetry_slopes(conditions: Conditions) -> Array:
    """Return d(relative error)/dKa of the twelve parameters, shape (12,) [1].

    With G = T/(4 pi n) each row of the response takes up G Ka b off its diagonal and
    G Ka (b + e) on it, e = (0, w cos L, w sin L). Hence for an angle s G b / d0, s its
    sign in dT, and by eq. (4) for the biases -(b + w_i) G (b + e_i) + sum over k != i
    of G b (b + w_k), over b; w = (0, 0, w sin L). Terms in dT are left out, 1e-5.
    """
    gyro, procedure = conditions.gyro, conditions.printed
    b = float(gyro.nominal_bias[0])
    d0 = float(gyro.nominal_mounting_angle[0])
    gain = 1.0 / (2.0 * procedure.gyro.rate)  # T / (4 pi n)
    vertical = ROTATION_RATE * sin(procedure.latitude)
    e = np.array([0.0, ROTATION_RATE * cos(procedure.latitude), vertical])
    v = b + np.array([0.0, 0.0, vertical])
    sign = np.array([-1.0, 1.0, 1.0, -1.0, -1.0, 1.0])
    bias = gain * (b * (v.sum() - v) - v * (b + e)) / b
    return np.concatenate([gain * (b + e), sign * gain * b / d0, bias])


def sweep_findings(
    sweeps: tuple[Sweep, ...], conditions: Conditions
) -> tuple[Finding, ...]:
    """Return the order of each figure, and the slopes of those that rise."""
    findings: list[Finding] = []
    for sweep in sweeps:
        findings.append(_order(sweep))
        if sweep.slopes.any():
            findings += _slopes(sweep)
    return (*findings, *_figure_3_readings(sweeps[2], conditions))


def _order(sweep: Sweep) -> Finding:
    """Hold the largest error against the order that the text reads off the figure."""
    order, ours = float(sweep.given.order), sweep.largest
    verdict, why = Verdict.AGREES_IN_ORDER, f", largest at i = {RUNS}"
    if not ours:
        verdict = Verdict.AGREES
        why = (
            f": no effect; the printed order is {order / HALF_ULP:.0f} times 2^-53, "
            "rounding of calibrated over nominal - 1"
        )
    elif power_of_ten(ours) != power_of_ten(order):
        verdict = Verdict.UNEXPLAINED
        why += f": {say(ours, 3)}, {order / ours:.0f} times below the order printed"
    elif not sweep.slopes.any():
        why = (
            ": the same at every i, eq. (4)'s own error and no rounding, as the text "
            "has it"
        )
    return Finding(
        section="figures",
        where=f"{sweep.figure}, {words(sweep.given.parameter)}, order",
        printed=sweep.given.order,
        ours=ours,
        ratio=ratio_of(ours, order),
        verdict=verdict,
        why=f"{sweep.given.stepped}{why}",
        is_summary=True,
    )


def _slopes(sweep: Sweep) -> list[Finding]:
    """Say of every axis or angle that its error is proportional to the asymmetry."""
    straight = sweep.departure <= PROPORTIONAL
    return [
        Finding(
            section="figures",
            where=f"{sweep.figure}, {words(sweep.given.parameter)} {name}, slope",
            printed="proportional",
            ours=float(found),
            verdict=agrees_if(straight),
            why=f"relative error per unit of asymmetry; closed form {say(closed, 5)}; "
            f"straight to {say(sweep.departure, 1)} of the largest error",
        )
        for name, found, closed in zip(
            sweep.names, sweep.fitted_slopes, sweep.slopes, strict=True
        )
    ]


def _figure_3_readings(sweep: Sweep, conditions: Conditions) -> list[Finding]:
    """Try readings of figure 3: by what each would multiply our errors."""
    bias = float(np.abs(conditions.gyro.nominal_bias[0]))
    factors = (
        100.0,  # per cent
        1200.0 / 18.0,  # time of the dwells over that of a turn
        1.0 + ROTATION_RATE / bias,
    )
    return [
        Finding(
            section="readings",
            where=f"{sweep.figure}, {words(sweep.given.parameter)}: {name}",
            printed=sweep.given.order,
            ours=factor * sweep.largest,
            ratio=ratio_of(factor * sweep.largest, float(sweep.given.order)),
            verdict=Verdict.READING_FAILS,
            why=why,
            is_summary=True,
        )
        for factor, (name, why) in zip(
            factors, conditions.paper.figure_3.items(), strict=True
        )
    ]
