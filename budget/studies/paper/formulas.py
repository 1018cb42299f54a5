"""Formulas of sections 1 and 2 fed with error-free pulses: what they return, and truth.

The printed formulas are computed as printed, misprints and all, and apart from those
that the package uses (budget.model.response), so that agreement means something.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, prod, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import scheme_of
from budget.earth import ROTATION_RATE
from budget.model.response import estimate
from budget.names import ANGLES, AXES
from budget.studies.paper.findings import WORD, Finding, Verdict
from budget.units import ARCSEC, DEG_PER_HOUR, STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.arrays import Array
    from budget.model.response import CalibratedTriad
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import PrintedFormula

# All different, so that no misprint can hide behind equal values.
ANGLE = np.arange(1.0, 7.0) * ARCSEC  # xy xz yx yz zx zy [rad]
GYRO_K = np.array([2.0, 3.0, 5.0])  # [pulses/rad]
ACCELEROMETER_K = np.array([2400.0, 2500.0, 2600.0]) / STANDARD_GRAVITY
GYRO_BIAS = np.array([1.5, 2.5, 3.5]) * DEG_PER_HOUR
ACCELEROMETER_BIAS = np.array([5e-3, 6e-3, 7e-3]) * STANDARD_GRAVITY
TURNED = (2, 0, 1)  # axis of turns j = 1, 2, 3 of eq. (3)
FACES = ((2, 1), (2, -1), (0, 1), (0, -1), (1, 1), (1, -1))  # axis, up or down: eq. (5)
CLOSE = 1e-8  # both formulas divide differences of pulses, relative [1]
IN_UNIT: dict[str, Callable[[float], float]] = {  # from SI
    "1": lambda value: value,
    "pulses/rad": lambda value: value,
    "pulses/s/g": lambda value: value * STANDARD_GRAVITY,
    "arcsec": lambda value: value / ARCSEC,
    "deg/h": lambda value: value / DEG_PER_HOUR,
    "mg": lambda value: value / STANDARD_GRAVITY * 1e3,
}
# A quotient as printed: '-[N_x(3) - N_x(4)]/2g K_y'; what is beside each other is
# multiplied, n by itself is one turn.
QUOTIENT = re.compile(
    r"(?:d_xy = )?(?P<sign>-?)\[?(?P<first>[nN]_[xyz]\(?\d\)?)"
    r"(?: (?P<joined>[-+]) (?P<second>N_[xyz]\(\d\))\])?/(?P<below>.*)"
)
FACTOR = re.compile(r"\d|pi|K_[xyz]|n_[xyz]\d|[gn]")


@dataclass(frozen=True, kw_only=True)
class Returned:
    """What a formula makes of error-free pulses: as printed, ours, and truth [SI]."""

    printed: float
    ours: float
    truth: float


@dataclass(frozen=True, kw_only=True)
class Formula:
    """One formula for one parameter.

    Attributes
    ----------
    name : str
        'd_yx'.
    given : PrintedFormula
        The formula in words of the paper, and ours.
    returns_printed, returns_ours, truth : float
        In the unit of the formula.
    """

    name: str
    given: PrintedFormula
    returns_printed: float
    returns_ours: float
    truth: float

    @property
    def is_misprint(self) -> bool:
        """Whether the printed formula misses the true value."""
        return abs(self.returns_printed / self.truth - 1.0) > CLOSE

    @property
    def is_right(self) -> bool:
        """Whether the formula used here returns the true value."""
        return abs(self.returns_ours / self.truth - 1.0) <= CLOSE


def compute_formulas(conditions: Conditions) -> tuple[Formula, ...]:
    """Return every calibration formula of section 1, in the order of the paper."""
    compute = {
        "eq. (3)": _gyro_turns(conditions),
        "eq. (4)": _gyro_bias(conditions),
        "2.1.1": _integral(conditions),
        "eq. (5)": _accelerometer(conditions),
        "eq. (17)": _asymmetry(conditions),
    }
    formulas = []
    for given in conditions.paper.formulas:
        in_unit = IN_UNIT[given.unit]
        for name in given.names:
            found = compute[given.equation](name, given.printed)
            formulas.append(
                Formula(
                    name=name,
                    given=given,
                    returns_printed=in_unit(found.printed),
                    returns_ours=in_unit(found.ours),
                    truth=in_unit(found.truth),
                )
            )
    return tuple(formulas)


def formula_findings(conditions: Conditions) -> tuple[Finding, ...]:
    """Return one row for each formula, judged by what it returns."""
    return tuple(_finding(formula) for formula in compute_formulas(conditions))


def evaluate(text: str, values: Mapping[str, float]) -> float:
    """Return a quotient as printed, of counts by their names and K_x, g, n."""
    found = QUOTIENT.fullmatch(text)
    if found is None:
        raise ValueError(f"{text!r} is no quotient of counts, such as -n_x1/n_x2")
    above = values[found["first"]]
    if found["second"]:
        sign = -1.0 if found["joined"] == "-" else 1.0
        above += sign * values[found["second"]]
    below = prod(
        float(factor) if factor.isdigit() else values[factor]
        for factor in FACTOR.findall(found["below"])
    )
    return (-above if found["sign"] else above) / below


def _finding(formula: Formula) -> Finding:
    """Judge one formula by what it returns."""
    given = formula.given
    unit = "" if given.unit == "1" else f" {given.unit}"
    printed, ours, truth = (
        f"{value:.8g}{unit}"
        for value in (formula.returns_printed, formula.returns_ours, formula.truth)
    )
    why = f"error-free pulses at {truth}: printed gives {printed}, ours {ours}"
    verdict = Verdict.AGREES if formula.is_right else Verdict.UNEXPLAINED
    if formula.is_right and formula.is_misprint:
        verdict = Verdict.MISPRINT if given.is_slip else Verdict.EXPLAINED
        why += f"; {given.note}"
    return Finding(
        section="formulas",
        where=f"{given.equation}, {formula.name}",
        printed=given.printed,
        ours=given.ours or given.printed,
        quantity=WORD,
        ratio=formula.returns_ours / formula.returns_printed,  # a sign counts here
        verdict=verdict,
        why=why,
    )


Compute = Callable[[str, str], Returned]  # of a name and the printed text


def _mounting() -> Array:
    """Return I + dT of eq. (1) at ANGLE."""
    xy, xz, yx, yz, zx, zy = ANGLE
    return np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])


def _calibrate(conditions: Conditions, sensor: str) -> CalibratedTriad:
    """Calibrate from error-free readings, as the package does."""
    K, bias = {
        "gyro": (GYRO_K, GYRO_BIAS),
        "accelerometer": (ACCELEROMETER_K, ACCELEROMETER_BIAS),
    }[sensor]
    scheme = scheme_of(sensor, conditions.corrected)
    inputs = (scheme.turn + scheme.standing).T
    return estimate(scheme, K[:, None] * (_mounting() @ inputs + bias[:, None]))


def _quotients(
    values: Mapping[str, float], found: CalibratedTriad, K: Array, bias: Array
) -> Compute:
    """Compute K_x, d_xy, the bias of x, each by a quotient of counts."""
    ours, truth = (
        {
            **{f"K_{axis}": factors[i] for i, axis in enumerate(AXES)},
            **{f"d_{angle}": angles[i] for i, angle in enumerate(ANGLES)},
            **{axis: biases[i] for i, axis in enumerate(AXES)},
        }
        for factors, angles, biases in (
            (found.scale_factor, found.mounting_angle, found.bias),
            (K, ANGLE, bias),
        )
    )

    def compute(name: str, printed: str) -> Returned:
        parameter = name.rpartition(" ")[2]  # of 'second d_xy', 'accelerometer bias x'
        # The second d_xy is held against d_xy, whose name it bears.
        mine = truth if name.startswith("second") else ours
        return Returned(
            printed=evaluate(printed, values),
            ours=float(mine[parameter]),
            truth=float(truth[parameter]),
        )

    return compute


def _gyro_turns(conditions: Conditions) -> Compute:
    """Eq. (3): scale factors and angles from turns by one revolution."""
    n = GYRO_K[:, None] * _mounting() * 4.0 * pi
    values = {
        f"n_{axis}{j}": float(n[i, turned])
        for i, axis in enumerate(AXES)
        for j, turned in enumerate(TURNED, start=1)
    }
    found = _calibrate(conditions, "gyro")
    return _quotients(values | {"pi": pi, "n": 1.0}, found, GYRO_K, GYRO_BIAS)


def _accelerometer(conditions: Conditions) -> Compute:
    """Eq. (5): twelve positions."""
    g, K, M = conditions.printed.gravity, ACCELEROMETER_K, _mounting()
    values = {
        f"N_{axis}({j})": float((K * (M[:, up] * sign * g + ACCELEROMETER_BIAS))[i])
        for i, axis in enumerate(AXES)
        for j, (up, sign) in enumerate(FACES, start=1)
    }
    values |= {"g": g} | {f"K_{axis}": float(K[i]) for i, axis in enumerate(AXES)}
    found = _calibrate(conditions, "accelerometer")
    return _quotients(values, found, K, ACCELEROMETER_BIAS)


def _gyro_bias(conditions: Conditions) -> Compute:
    """Eq. (4): the bias, by the transpose as printed and by the inverse of eq. (1)."""
    w = np.array([0.0, 0.0, ROTATION_RATE * sin(conditions.printed.latitude)])
    M = _mounting()
    static = GYRO_K * (M @ w + GYRO_BIAS)
    printed = (np.eye(3) + (M - np.eye(3)).T) @ (static / GYRO_K) - w
    return _by_axis(printed, _calibrate(conditions, "gyro").bias, GYRO_BIAS)


def _by_axis(printed: Array, ours: Array, truth: Array) -> Compute:
    """Return the values of the axis that a name ends with or has after 'dK_'."""

    def compute(name: str, _: str) -> Returned:
        i = AXES.index(name.removeprefix("dK_")[0] if "dK_" in name else name[-1])
        return Returned(
            printed=float(printed[i]), ours=float(ours[i]), truth=float(truth[i])
        )

    return compute


def _integral(conditions: Conditions) -> Compute:
    """2.1.1: what z counts of the horizontal earth rate while the table turns about z.

    Over whole turns both integrals vanish, so that the misprint does no harm there; a
    third of a turn shows it.
    """
    rate, latitude = conditions.printed.gyro.rate, conditions.printed.latitude
    azimuth = 2.0 * pi / 3.0
    horizontal = ROTATION_RATE * cos(latitude) / rate
    # Integrals of w cos L (sin a, cos a) over the time, a = rate t.
    x, y = horizontal * (1.0 - cos(azimuth)), horizontal * sin(azimuth)
    zx, zy = ANGLE[4:]
    truth = (_mounting() - np.eye(3))[2] @ np.array([x, y, 0.0])
    found = Returned(
        printed=float(zy * y - zx * y),
        ours=float(zy * x - zx * y),
        truth=float(truth),
    )
    return lambda *_: found


def _asymmetry(conditions: Conditions) -> Compute:
    """Eq. (17): scale-factor error from asymmetry, at the paper's bias, 1250 ppm."""
    rate, latitude = conditions.printed.gyro.rate, conditions.printed.latitude
    Ka, T = conditions.paper.farthest["scale_factor_asymmetry"], 2.0 * pi / rate
    b = float(conditions.gyro.nominal_bias[0])
    along = b + ROTATION_RATE * np.array([0.0, cos(latitude), sin(latitude)])
    plus = (1.0 + Ka / 2.0) * (2.0 * pi + along * T)
    minus = (1.0 - Ka / 2.0) * (-2.0 * pi + along * T)
    counted = (plus - minus) / (4.0 * pi) - 1.0  # eq. (3) on these pulses
    printed = np.full(3, Ka * T * b / (4.0 * pi))
    return _by_axis(printed, Ka * T * along / (4.0 * pi), counted)
