"""The calibration formulas as they are used: Zhao 2019, eqs. (3) to (5), mended."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.blocks import Equation, Equations, Panel, Paragraph
from budget.report.formulas import (
    Letter,
    Mean,
    Sup,
    brackets,
    equals,
    fraction,
    line,
    minus,
    sign,
    sub,
    upright,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Words
    from budget.report.formulas import Math

PAPER = (
    "X. Zhao, L. Zhang, S. Li, Metrology & Measurement Technology 39 (3), 2019, 34-40, "
    "doi 10.11823/j.issn.1674-5795.2019.03.06"
)
# Axis and the turn that scales it; angle, sign, and pulse differences: eq. (3).
TURN_SCALES = (("x", "2"), ("y", "3"), ("z", "1"))
TURN_ANGLES = (
    ("xy", -1, "x1", "x2"),
    ("xz", 1, "x3", "x2"),
    ("yx", 1, "y1", "y3"),
    ("yz", -1, "y2", "y3"),
    ("zx", -1, "z3", "z1"),
    ("zy", 1, "z2", "z1"),
)
# Axis and its face up; angle, sign, and the face up that shows it: eq. (5).
FACE_SCALES = (("x", 3), ("y", 5), ("z", 1))
FACE_ANGLES = (
    ("xy", -1, 1),
    ("xz", 1, 5),
    ("yx", 1, 1),
    ("yz", -1, 3),
    ("zx", -1, 5),
    ("zy", 1, 3),
)
DELTA, EPSILON, NABLA, OMEGA, PHI = "\u03b4", "\u03b5", "\u2207", "\u03c9", "\u03c6"
MINUS, PLUS = "\N{MINUS SIGN}", "+"
TILT = line(upright("\u0394"), "T")
MEAN_OUTPUT = fraction(Mean(base=Letter(text="N")), Letter(text="K"))
MEAN_RATE = Mean(base=Letter(text=OMEGA))
TRANSPOSED_TILT = line(
    upright("\u0394"), Sup(base=Letter(text="T"), exponent=upright("T"))
)


def notation() -> Words:
    """Say where the formulas come from, and what their letters are."""
    return (
        f"After {PAPER}, its misprints mended. ",
        Letter(text="K"),
        " is a scale factor, ",
        Letter(text=DELTA),
        " a mounting angle, ",
        TILT,
        " the matrix of them in its eq. (1), ",
        Letter(text=EPSILON),
        " and ",
        Letter(text=NABLA),
        " the bias of gyro and accelerometer, ",
        Letter(text="I"),
        " the unit matrix, ",
        Letter(text="g"),
        " gravity.",
    )


def turns_panel() -> Panel:
    """Return the gyro's scale factors and mounting angles, eq. (3)."""
    around = line(upright("4"), "\u03c0", "m")
    equations = [
        equals(sub("K", axis), fraction(sub("n", f"{axis}{turn}"), around))
        for axis, turn in TURN_SCALES
    ] + [
        equals(
            sub(DELTA, angle),
            _signed(factor, fraction(sub("n", top), sub("n", bottom))),
        )
        for angle, factor, top, bottom in TURN_ANGLES
    ]
    words: Words = (
        sub("n", "ij"),
        (
            ": pulses of axis i over m turns forward minus those back, about "
            "z (j = 1), x (2), y (3). The paper prints "
        ),
        sub(DELTA, "yx"),
        " with a minus, against its eq. (1).",
    )
    return _panel("Gyro scale factors and mounting angles, eq. (3)", words, equations)


def gyro_bias_panel(formulas: str) -> Panel:
    """Return the gyro's bias: eq. (4) as printed, or corrected."""
    identity = Letter(text="I")
    corrected = equals(
        Letter(text=EPSILON),
        line(MEAN_OUTPUT, sign(MINUS), brackets(identity, sign(PLUS), TILT), MEAN_RATE),
    )
    printed = line(
        brackets(identity, sign(PLUS), TRANSPOSED_TILT),
        MEAN_OUTPUT,
        sign(MINUS),
        MEAN_RATE,
    )
    letters: Words = (
        Mean(base=Letter(text="N")),
        " is the mean number of pulses a second over the azimuths, ",
        MEAN_RATE,
        " the mean earth rate there in body axes, (0, 0, ",
        line(OMEGA, upright("sin"), PHI),
        ") at latitude ",
        Letter(text=PHI),
        " where they balance. ",
    )
    if formulas == "paper":
        words: Words = (
            *letters,
            "This is exact only without mounting angles; the corrected formula is ",
            corrected,
            ".",
        )
        used = equals(Letter(text=EPSILON), printed)
        return _panel("Gyro bias, eq. (4) as printed", words, [used])
    words = (
        *letters,
        "The paper prints ",
        printed,
        ", which does not invert its eq. (1) where there are mounting angles.",
    )
    return _panel("Gyro bias, corrected from eq. (4)", words, [corrected])


def accelerometer_panel() -> Panel:
    """Return the accelerometer's parameters, eq. (5)."""
    gravity = line(upright("2"), "g")
    equations = [
        equals(sub("K", axis), fraction(_faces(axis, face, MINUS), gravity))
        for axis, face in FACE_SCALES
    ]
    equations += [
        equals(
            sub(DELTA, angle),
            _signed(
                factor,
                fraction(
                    _faces(angle[0], face, MINUS), line(gravity, sub("K", angle[0]))
                ),
            ),
        )
        for angle, factor, face in FACE_ANGLES
    ]
    equations += [
        equals(
            sub(NABLA, axis),
            fraction(_faces(axis, face, PLUS), line(upright("2"), sub("K", axis))),
        )
        for axis, face in FACE_SCALES
    ]
    words: Words = (
        sub("N", "i"),
        brackets("j"),
        (
            ": mean number of pulses a second of axis i over the two dwells with z up "
            "(j = 1), z down (2), x up (3), x down (4), y up (5), y down (6). The "
            "paper prints "
        ),
        sub(DELTA, "yz"),
        " with the counts of x, and ",
        sub(DELTA, "xy"),
        " twice; the second is ",
        sub(DELTA, "xz"),
        ".",
    )
    return _panel("Accelerometer, eq. (5)", words, equations)


def _panel(title: str, words: Words, equations: Sequence[Math]) -> Panel:
    """Return formulas under what their letters mean."""
    return Panel(
        title=title,
        blocks=(
            Paragraph(words=words, small=True),
            Equations(equations=tuple(Equation(math=math) for math in equations)),
        ),
    )


def _faces(axis: str, face: int, operator: str) -> Math:
    """Return the mean outputs of one face and of its opposite, joined by a sign."""
    up, down = (
        line(sub("N", axis), brackets(upright(str(place))))
        for place in (face, face + 1)
    )
    return line(up, sign(operator), down)


def _signed(factor: int, term: Math) -> Math:
    """Return a term, with a minus before it where the factor is negative."""
    return minus(term) if factor < 0 else term
