"""Formulas of sections 1 and 2 fed with error-free pulses: what they return, and truth.

The printed formulas are written down here as printed, misprints and all, and apart from
those the package uses (budget.model.response), so that agreement means something.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import scheme_of
from budget.earth import ROTATION_RATE
from budget.model.response import estimate
from budget.spec.records import AXES
from budget.studies.paper.conditions import FARTHEST
from budget.studies.paper.findings import (
    AGREES,
    EXPLAINED,
    MISPRINT,
    UNEXPLAINED,
    WORD,
    Finding,
)
from budget.units import ARCSEC, DEG_PER_HOUR, STANDARD_GRAVITY

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.model.response import CalibratedTriad
    from budget.model.scheme import Scheme
    from budget.studies.paper.conditions import Conditions

# All different, so that no misprint can hide behind equal values.
ANGLE = np.arange(1.0, 7.0) * ARCSEC  # xy xz yx yz zx zy [rad]
GYRO_K = np.array([2.0, 3.0, 5.0])  # [pulses/rad]
ACCELEROMETER_K = np.array([2400.0, 2500.0, 2600.0]) / STANDARD_GRAVITY
GYRO_BIAS = np.array([1.5, 2.5, 3.5]) * DEG_PER_HOUR
ACCELEROMETER_BIAS = np.array([5e-3, 6e-3, 7e-3]) * STANDARD_GRAVITY
FACES = ((2, 1), (2, -1), (0, 1), (0, -1), (1, 1), (1, -1))  # axis, up or down
X, Y, Z = range(3)
CLOSE = 1e-8  # both formulas divide differences of pulses, relative [1]


@dataclass(frozen=True, kw_only=True)
class Formula:
    """One formula as printed and as used, and what each makes of error-free pulses.

    Attributes
    ----------
    equation, name : str
        'eq. (3)', 'd_yx'.
    printed, ours : str
        The formulas in words of the paper.
    returns_printed, returns_ours, truth : float
        In `unit`.
    note : str
        Why they differ.
    """

    equation: str
    name: str
    printed: str
    ours: str
    returns_printed: float
    returns_ours: float
    truth: float
    unit: str
    note: str = ""

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
    return (
        *_gyro_turns(conditions),
        *_gyro_bias(conditions),
        _integral(conditions),
        *_accelerometer(conditions),
        *_asymmetry(conditions),
    )


def formula_findings(formulas: tuple[Formula, ...]) -> tuple[Finding, ...]:
    """Return one row for each formula."""
    return tuple(_finding(formula) for formula in formulas)


def _finding(formula: Formula) -> Finding:
    """Judge one formula by what it returns."""
    unit = "" if formula.unit == "1" else f" {formula.unit}"
    printed, ours, truth = (
        f"{value:.8g}{unit}"
        for value in (formula.returns_printed, formula.returns_ours, formula.truth)
    )
    why = f"error-free pulses at {truth}: printed gives {printed}, ours {ours}"
    if not formula.is_right:
        verdict = UNEXPLAINED
    elif not formula.is_misprint:
        verdict = AGREES
    else:
        verdict = EXPLAINED if formula.equation == "eq. (4)" else MISPRINT
        verdict = EXPLAINED if formula.equation == "eq. (17)" else verdict
        why += f"; {formula.note}"
    return Finding(
        section="formulas",
        where=f"{formula.equation}, {formula.name}",
        printed=formula.printed,
        ours=formula.ours,
        quantity=WORD,
        ratio=formula.returns_ours / formula.returns_printed,  # a sign counts here
        verdict=verdict,
        why=why,
    )


def _mounting() -> Array:
    """Return I + dT of eq. (1) at ANGLE."""
    xy, xz, yx, yz, zx, zy = ANGLE
    return np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])


def _calibrate(scheme: Scheme, K: Array, bias: Array) -> CalibratedTriad:
    """Calibrate from error-free readings, as the package does."""
    inputs = (scheme.turn + scheme.standing).T
    return estimate(scheme, K[:, None] * (_mounting() @ inputs + bias[:, None]))


def _corrected(conditions: Conditions) -> Scheme:
    """Return the paper's gyro test with the bias by the inverse of eq. (1)."""
    return scheme_of("gyro", replace(conditions.printed, formulas="corrected"))


def _gyro_turns(conditions: Conditions) -> list[Formula]:
    """Eq. (3): scale factors and angles from turns by one revolution."""
    n = GYRO_K[:, None] * _mounting() * 4.0 * pi
    found = _calibrate(_corrected(conditions), GYRO_K, GYRO_BIAS)
    turned = {"x": 2, "y": 3, "z": 1}
    formulas = [
        Formula(
            equation="eq. (3)",
            name=f"K_{axis}",
            printed=f"n_{axis}{turned[axis]}/4 pi n",
            ours=f"n_{axis}{turned[axis]}/4 pi n",
            returns_printed=float(n[i, i] / (4.0 * pi)),
            returns_ours=float(found.scale_factor[i]),
            truth=float(GYRO_K[i]),
            unit="pulses/rad",
        )
        for i, axis in enumerate(AXES)
    ]
    printed = (
        ("d_xy", "-n_x1/n_x2", -n[X, Z] / n[X, X]),
        ("d_xz", "n_x3/n_x2", n[X, Y] / n[X, X]),
        ("d_yx", "-n_y1/n_y3", -n[Y, Z] / n[Y, Y]),
        ("d_yz", "-n_y2/n_y3", -n[Y, X] / n[Y, Y]),
        ("d_zx", "-n_z3/n_z1", -n[Z, Y] / n[Z, Z]),
        ("d_zy", "n_z2/n_z1", n[Z, X] / n[Z, Z]),
    )
    formulas += _angles("eq. (3)", printed, found.mounting_angle, {"d_yx": "n_y1/n_y3"})
    return formulas


def _angles(
    equation: str,
    printed: tuple[tuple[str, str, float], ...],
    found: Array,
    mended: dict[str, str],
) -> list[Formula]:
    """Return the six angles of one equation; `mended` has ours where it differs."""
    notes = {
        ("eq. (3)", "d_yx"): "by eq. (1) y sees +d_yx of a turn about z: no minus",
        ("eq. (5)", "d_yz"): "it takes the counts of x, so that -K_x/K_y comes out",
        ("eq. (5)", "d_xz"): "it stands there as a second d_xy, which as such is wrong "
        "by d_xz - d_xy, and d_xz is nowhere",
    }
    return [
        Formula(
            equation=equation,
            name=name,
            printed=text,
            ours=mended.get(name, text),
            returns_printed=float(value) / ARCSEC,
            returns_ours=float(ours) / ARCSEC,
            truth=float(truth) / ARCSEC,
            unit="arcsec",
            note=notes.get((equation, name), ""),
        )
        for (name, text, value), ours, truth in zip(printed, found, ANGLE, strict=True)
    ]


def _gyro_bias(conditions: Conditions) -> list[Formula]:
    """Eq. (4): the bias, by the transpose as printed and by the inverse of eq. (1)."""
    w = np.array([0.0, 0.0, ROTATION_RATE * sin(conditions.printed.latitude)])
    M = _mounting()
    static = GYRO_K * (M @ w + GYRO_BIAS)
    printed = (np.eye(3) + (M - np.eye(3)).T) @ (static / GYRO_K) - w
    ours = _calibrate(_corrected(conditions), GYRO_K, GYRO_BIAS).bias
    return [
        Formula(
            equation="eq. (4)",
            name=f"gyro bias {axis}",
            printed="(I + dT^T) mean(N)/K - w",
            ours="mean(N)/K - (I + dT) w",
            returns_printed=float(printed[i] / DEG_PER_HOUR),
            returns_ours=float(ours[i] / DEG_PER_HOUR),
            truth=float(GYRO_BIAS[i] / DEG_PER_HOUR),
            unit="deg/h",
            note="the transpose undoes dT only where dT is a rotation and the bias "
            "stands in body axes; `formulas: paper` keeps it",
        )
        for i, axis in enumerate(AXES)
    ]


def _integral(conditions: Conditions) -> Formula:
    """2.1.1: what z counts of the horizontal earth rate while the table turns about z.

    Over whole turns both integrals vanish, so that the misprint does no harm there; a
    third of a turn shows it.
    """
    rate, latitude = conditions.printed.gyro.rate, conditions.printed.latitude
    azimuth = 2.0 * pi / 3.0
    horizontal = ROTATION_RATE * cos(latitude) / rate
    # Integrals of w cos L (sin a, cos a) over the time, a = rate t.
    x, y = horizontal * (1.0 - cos(azimuth)), horizontal * sin(azimuth)
    dT = _mounting() - np.eye(3)
    zx, zy = ANGLE[4:]
    return Formula(
        equation="2.1.1",
        name="earth rate in the count of z",
        printed="int d_zy w_iey dt - int d_zx w_iey dt",
        ours="int d_zy w_iex dt - int d_zx w_iey dt",
        returns_printed=float(zy * y - zx * y) / ARCSEC,
        returns_ours=float(zy * x - zx * y) / ARCSEC,
        truth=float(dT[Z] @ np.array([x, y, 0.0])) / ARCSEC,
        unit="arcsec",
        note="by eq. (1) d_zy belongs to x. Over a third of a turn; over whole turns "
        "both integrals vanish, and nothing that follows is wrong",
    )


def _accelerometer(conditions: Conditions) -> list[Formula]:
    """Eq. (5): twelve positions."""
    g, K, M = conditions.printed.gravity, ACCELEROMETER_K, _mounting()
    face = np.stack(
        [K * (M[:, axis] * sign * g + ACCELEROMETER_BIAS) for axis, sign in FACES],
        axis=1,
    )
    scheme = scheme_of("accelerometer", conditions.printed)
    found = _calibrate(scheme, K, ACCELEROMETER_BIAS)

    def difference(axis: int, j: int) -> float:
        return float(face[axis, j - 1] - face[axis, j])

    first = {"x": 3, "y": 5, "z": 1}  # face with that axis up
    formulas = [
        Formula(
            equation="eq. (5)",
            name=f"K_{axis}",
            printed=f"[N_{axis}({j}) - N_{axis}({j + 1})]/2g",
            ours=f"[N_{axis}({j}) - N_{axis}({j + 1})]/2g",
            returns_printed=difference(i, j) / (2.0 * g) * STANDARD_GRAVITY,
            returns_ours=float(found.scale_factor[i]) * STANDARD_GRAVITY,
            truth=float(K[i]) * STANDARD_GRAVITY,
            unit="pulses/s/g",
        )
        for i, (axis, j) in enumerate(first.items())
    ]
    plan = (  # angle, sign, counts of axis, faces, K of axis
        ("d_xy", -1.0, X, 1, X),
        ("d_xz", 1.0, X, 5, X),
        ("d_yx", 1.0, Y, 1, Y),
        ("d_yz", -1.0, X, 3, Y),  # printed with the counts of x
        ("d_zx", -1.0, Z, 5, Z),
        ("d_zy", 1.0, Z, 3, Z),
    )
    printed = tuple(
        (
            name,
            _quotient(sign, AXES[i], j, AXES[k]),
            sign * difference(i, j) / (2.0 * g * K[k]),
        )
        for name, sign, i, j, k in plan
    )
    mended = {"d_yz": "-[N_y(3) - N_y(4)]/2g K_y"}
    angles = _angles("eq. (5)", printed, found.mounting_angle, mended)
    formulas += [_second_xy(a) if a.name == "d_xz" else a for a in angles]
    formulas += [
        Formula(
            equation="eq. (5)",
            name=f"accelerometer bias {axis}",
            printed=f"[N_{axis}({j}) + N_{axis}({j + 1})]/2K_{axis}",
            ours=f"[N_{axis}({j}) + N_{axis}({j + 1})]/2K_{axis}",
            returns_printed=float((face[i, j - 1] + face[i, j]) / (2.0 * K[i]))
            / STANDARD_GRAVITY
            * 1e3,
            returns_ours=float(found.bias[i]) / STANDARD_GRAVITY * 1e3,
            truth=float(ACCELEROMETER_BIAS[i]) / STANDARD_GRAVITY * 1e3,
            unit="mg",
        )
        for i, (axis, j) in enumerate(first.items())
    ]
    return formulas


def _quotient(sign: float, axis: str, j: int, over: str) -> str:
    """Write an angle of eq. (5): counts of one axis at faces j and j + 1."""
    minus = "-" if sign < 0.0 else ""
    return f"{minus}[N_{axis}({j}) - N_{axis}({j + 1})]/2g K_{over}"


def _second_xy(angle: Formula) -> Formula:
    """Return the second d_xy of eq. (5): held against d_xy, whose name it bears."""
    return Formula(
        equation=angle.equation,
        name="second d_xy",
        printed=f"d_xy = {angle.printed}",
        ours=f"d_xz = {angle.ours}; d_xy by the first",
        returns_printed=angle.returns_printed,
        returns_ours=float(ANGLE[0]) / ARCSEC,
        truth=float(ANGLE[0]) / ARCSEC,
        unit="arcsec",
        note=angle.note,
    )


def _asymmetry(conditions: Conditions) -> list[Formula]:
    """Eq. (17): scale-factor error from asymmetry, at the paper's bias, 1250 ppm."""
    rate, latitude = conditions.printed.gyro.rate, conditions.printed.latitude
    Ka, T = FARTHEST["scale_factor_asymmetry"], 2.0 * pi / rate
    b = float(conditions.gyro.nominal_bias[0])
    earth = ROTATION_RATE * np.array([0.0, cos(latitude), sin(latitude)])
    formulas = []
    for i, axis in enumerate(AXES):
        plus = (1.0 + Ka / 2.0) * (2.0 * pi + (b + earth[i]) * T)
        minus = (1.0 - Ka / 2.0) * (-2.0 * pi + (b + earth[i]) * T)
        counted = (plus - minus) / (4.0 * pi) - 1.0  # eq. (3) on these pulses
        formulas.append(
            Formula(
                equation="eq. (17)",
                name=f"dK_{axis}/K from asymmetry",
                printed="e T Ka/4 pi n",
                ours="(e + earth rate along the axis) T Ka/4 pi n",
                returns_printed=Ka * T * b / (4.0 * pi),
                returns_ours=float(Ka * T * (b + earth[i]) / (4.0 * pi)),
                truth=float(counted),
                unit="1",
                note="the earth turns along the axis in both turns and does not cancel "
                "where K(+) and K(-) differ",
            )
        )
    return formulas
