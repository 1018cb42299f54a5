"""Formulas of sections 1 and 2 fed with error-free pulses: what they return, and truth.

The printed formulas are computed as printed, misprints and all, and apart from those
that the package uses (budget.model.response), so that agreement means something.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from math import cos, pi, prod, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import scheme_of
from budget.earth import ROTATION_RATE
from budget.names import ANGLES, AXES
from budget.sentences import sentence
from budget.units import ARCSEC, DEG_PER_HOUR, STANDARD_GRAVITY
from zhao_2019.printed import Agreement, Finding

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.fields import Keyed
    from zhao_2019.conditions import Conditions

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
FACTOR = r"\d|pi|K_[xyz]|n_[xyz]\d|[gn]"
QUOTIENT = re.compile(
    r"(?:d_xy = )?(?P<sign>-?)\[?(?P<first>[nN]_[xyz]\(?\d\)?)"
    r"(?: (?P<joined>[-+]) (?P<second>N_[xyz]\(\d\))\])?"
    rf"/(?P<below>(?:(?:{FACTOR}) ?)+)"
)


@dataclass(frozen=True, kw_only=True)
class Pulses:
    """Error-free pulses of one test, and what they must return."""

    # Counts and factors by the names that they have in the formulas [SI].
    counts: dict[str, float] = field(default_factory=dict)
    # Each parameter by its name, as the package finds it and as it is [SI].
    ours: dict[str, float]
    truth: dict[str, float]
    # What those printed formulas return that are no quotients of counts [SI].
    printed: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Formula:
    """One formula for one parameter."""

    name: str  # 'd_yx'
    given: Keyed  # the formula in words of the paper, and ours
    # In the unit of the formula.
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
    gyro, accelerometer = _gyro(conditions), _accelerometer(conditions)
    tests = {
        "eq. (3)": gyro,
        "eq. (4)": gyro,
        "2.1.1": _integral(conditions),
        "eq. (5)": accelerometer,
        "eq. (17)": _asymmetry(conditions),
    }
    formulas = []
    for given in conditions.paper.formulas:
        pulses, in_unit = tests[given.equation], IN_UNIT[given.unit]
        for name in given.names:
            printed = pulses.printed.get(name)
            if printed is None:
                printed = evaluate(given.printed, pulses.counts)
            formulas.append(
                Formula(
                    name=name,
                    given=given,
                    returns_printed=in_unit(printed),
                    returns_ours=in_unit(pulses.ours[name]),
                    truth=in_unit(pulses.truth[name]),
                )
            )
    return tuple(formulas)


def formula_findings(conditions: Conditions) -> tuple[Finding, ...]:
    """Return one row for each formula, judged by what it returns."""
    findings = []
    for formula in compute_formulas(conditions):
        given, remark = formula.given, ""
        verdict = Agreement.AGREES if formula.is_right else Agreement.UNEXPLAINED
        if formula.is_right and formula.is_misprint:
            verdict = Agreement.MISPRINT if given.is_slip else Agreement.EXPLAINED
            remark = sentence("paper_words.cause", text=given.note)
        findings.append(
            conditions.paper.tell(
                "formula",
                printed=given.printed,
                ours=given.ours or given.printed,
                # A sign counts here.
                ratio=formula.returns_ours / formula.returns_printed,
                verdict=verdict,
                formula=formula,
                unit="" if given.unit == "1" else f" {given.unit}",
                note=remark,
            )
        )
    return tuple(findings)


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
        for factor in re.findall(FACTOR, found["below"])
    )
    return (-above if found["sign"] else above) / below


def _mounting() -> Array:
    """Return I + dT of eq. (1) at ANGLE."""
    xy, xz, yx, yz, zx, zy = ANGLE
    return np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])


def _pulses(
    conditions: Conditions, sensor: str, counts: dict[str, float], K: Array, bias: Array
) -> Pulses:
    """Calibrate a triad from error-free readings, as the package does."""
    scheme = scheme_of(sensor, conditions.corrected)
    inputs = (scheme.turn + scheme.standing).T
    found = scheme.estimate(K[:, None] * (_mounting() @ inputs + bias[:, None]))
    ours, truth = (
        _named("K_{}", AXES, factors)
        | _named("d_{}", ANGLES, angles)
        | _named(f"{sensor} bias {{}}", AXES, biases)
        # The second d_xy of eq. (5) is held against d_xy, whose name it bears.
        | {"second d_xy": float(angles[0])}
        for factors, angles, biases in (
            (found.scale_factor, found.mounting_angle, found.bias),
            (K, ANGLE, bias),
        )
    )
    return Pulses(counts=counts, ours=ours, truth=truth)


def _named(text: str, names: Sequence[str], values: Array) -> dict[str, float]:
    """Return values by a text with each name in its place."""
    return {
        text.format(name): float(value)
        for name, value in zip(names, values, strict=True)
    }


def _gyro(conditions: Conditions) -> Pulses:
    """Eqs. (3) and (4): turns by one revolution; the bias by the transpose of dT."""
    M = _mounting()
    n = GYRO_K[:, None] * M * 4.0 * pi
    w = np.array([0.0, 0.0, ROTATION_RATE * sin(conditions.printed.latitude)])
    static = GYRO_K * (M @ w + GYRO_BIAS)
    bias = (np.eye(3) + (M - np.eye(3)).T) @ (static / GYRO_K) - w  # eq. (4)
    counts = {"pi": pi, "n": 1.0}
    for j, turned in enumerate(TURNED, start=1):
        counts |= _named(f"n_{{}}{j}", AXES, n[:, turned])
    pulses = _pulses(conditions, "gyro", counts, GYRO_K, GYRO_BIAS)
    return replace(pulses, printed=_named("gyro bias {}", AXES, bias))


def _accelerometer(conditions: Conditions) -> Pulses:
    """Eq. (5): twelve positions."""
    g, K, bias = conditions.printed.gravity, ACCELEROMETER_K, ACCELEROMETER_BIAS
    counts = _named("K_{}", AXES, K) | {"g": g}
    for j, (axis, sign) in enumerate(FACES, start=1):
        means = K * (_mounting()[:, axis] * sign * g + bias)
        counts |= _named(f"N_{{}}({j})", AXES, means)
    return _pulses(conditions, "accelerometer", counts, K, bias)


def _integral(conditions: Conditions) -> Pulses:
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
    name = "earth rate in the count of z"
    return Pulses(
        printed={name: float(zy * y - zx * y)},
        ours={name: float(zy * x - zx * y)},
        truth={name: float(truth)},
    )


def _asymmetry(conditions: Conditions) -> Pulses:
    """Eq. (17): scale-factor error from asymmetry, at the paper's bias, 1250 ppm."""
    rate, latitude = conditions.printed.gyro.rate, conditions.printed.latitude
    Ka, T = conditions.paper.farthest["scale_factor_asymmetry"], 2.0 * pi / rate
    b = float(conditions.gyro.nominal_bias[0])
    along = b + ROTATION_RATE * np.array([0.0, cos(latitude), sin(latitude)])
    plus = (1.0 + Ka / 2.0) * (2.0 * pi + along * T)
    minus = (1.0 - Ka / 2.0) * (-2.0 * pi + along * T)
    counted = (plus - minus) / (4.0 * pi) - 1.0  # eq. (3) on these pulses
    name = "dK_{}/K from asymmetry"
    return Pulses(
        printed=_named(name, AXES, np.full(3, Ka * T * b / (4.0 * pi))),
        ours=_named(name, AXES, Ka * T * along / (4.0 * pi)),
        truth=_named(name, AXES, counted),
    )
