"""Any text as a quantity, and any unit of the grammar against a second reading."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import pi, sqrt

import pytest
from fuzz.effort import examples
from fuzz.oracle import LIKES, judge_quantity
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

HALF = Fraction(1, 2)
DEG = pi / 180.0

# Size in SI and powers of angle, time, length, temperature and magnetic field: written
# down here once more, by hand; powers that are not written are zero.
NAMES = {
    "deg": (DEG, (1, 0, 0)),
    "\N{DEGREE SIGN}": (DEG, (1, 0, 0)),
    "arcmin": (DEG / 60.0, (1, 0, 0)),
    "arcsec": (DEG / 3600.0, (1, 0, 0)),
    "rad": (1.0, (1, 0, 0)),
    "mrad": (1e-3, (1, 0, 0)),
    "\N{MICRO SIGN}rad": (1e-6, (1, 0, 0)),
    "s": (1.0, (0, 1, 0)),
    "sec": (1.0, (0, 1, 0)),
    "ms": (1e-3, (0, 1, 0)),
    "min": (60.0, (0, 1, 0)),
    "h": (3600.0, (0, 1, 0)),
    "hr": (3600.0, (0, 1, 0)),
    "hour": (3600.0, (0, 1, 0)),
    "Hz": (1.0, (0, -1, 0)),
    "kHz": (1e3, (0, -1, 0)),
    "dps": (DEG, (1, -1, 0)),
    "mdps": (1e-3 * DEG, (1, -1, 0)),
    "dph": (DEG / 3600.0, (1, -1, 0)),
    "mdeg": (1e-3 * DEG, (1, 0, 0)),
    "nrad": (1e-9, (1, 0, 0)),
    "um": (1e-6, (0, 0, 1)),
    "m": (1.0, (0, 0, 1)),
    "ft": (0.3048, (0, 0, 1)),
    "km": (1e3, (0, 0, 1)),
    "nmi": (1852.0, (0, 0, 1)),
    "kn": (1852.0 / 3600.0, (0, -1, 1)),
    "fps": (0.3048, (0, -1, 1)),
    "Gal": (1e-2, (0, -2, 1)),
    "mGal": (1e-5, (0, -2, 1)),
    "g": (9.80665, (0, -2, 1)),
    "mg": (9.80665e-3, (0, -2, 1)),
    "ug": (9.80665e-6, (0, -2, 1)),
    "\N{GREEK SMALL LETTER MU}g": (9.80665e-6, (0, -2, 1)),
    "ng": (9.80665e-9, (0, -2, 1)),
    "%": (1e-2, (0, 0, 0)),
    "ppm": (1e-6, (0, 0, 0)),
    "degC": (1.0, (0, 0, 0, 1)),
    "K": (1.0, (0, 0, 0, 1)),
    "gauss": (1e-4, (0, 0, 0, 0, 1)),
    "Gauss": (1e-4, (0, 0, 0, 0, 1)),
    "T": (1.0, (0, 0, 0, 0, 1)),
    "mT": (1e-3, (0, 0, 0, 0, 1)),
    "uT": (1e-6, (0, 0, 0, 0, 1)),
    "nT": (1e-9, (0, 0, 0, 0, 1)),
    "Pa": (1.0, (0, 0, 0, 0, 0, 1)),
    "hPa": (1e2, (0, 0, 0, 0, 0, 1)),
    "kPa": (1e3, (0, 0, 0, 0, 0, 1)),
    "mbar": (1e2, (0, 0, 0, 0, 0, 1)),
}
# The dimension of each kind of quantity, in the order of LIKES.
KINDS = (
    *((1, -1), (1, -HALF), (1, -3 * HALF), (0, -2, 1), (0, -3 * HALF, 1)),
    *((0, -5 * HALF, 1), (1, 1, -1), (0, 2, -1), (0, 4, -2)),
    *((-1, 1), (-2, 2), (1, 3, -2), (0, 0, 0, 1), (0, -1, 0, 1)),
    *((1, 0, 0, -1), (0, -1, 1, -1), (0, 0, 0, -1)),
    (1, -1, 0, -1),
    *((0, -2, 1, -1), (), (1,), (0, -1, 1), (0, 1), (0, 0, 1), (0, -1)),
    (0, 0, 0, 0, 0, 1),
    *((0, 0, 0, 0, 1), (1, -1, 0, 0, -1), (0, -2, 1, 0, -1)),
)
STANDARD = 9.80665  # [m/s^2]

PIECES = (
    *NAMES,
    *("/", "*", "^2", "**2", "2", "^3", "\N{SUPERSCRIPT TWO}", "(", ")", "sqrt(", " "),
    *("\N{SQUARE ROOT}", "rt-", "\N{MIDDLE DOT}", "1", "0", ".", "e", "-", "+"),
    *("9" * 60, "1e", "400", "nan", "inf", "_", ",", ":", "0x", "<", "rms"),
    *("\N{PLUS-MINUS SIGN}", "\N{PRIME}", "\N{DOUBLE PRIME}", "\N{OHM SIGN}"),
    *("\0", "\t", "\n", "\r", "\u200b", "\N{FULLWIDTH DIGIT ONE}", "\ud800"),
    *("G", "UG", "Deg", "lambda", "__import__", "pi", "K", "kg"),
)


@dataclass(frozen=True)
class Unit:
    """A unit as text, with its size and dimension as worked out here."""

    text: str
    size: float  # [SI]
    powers: tuple[Fraction, ...]  # of angle, time, length, temperature, field, pressure


def powers_of(*written):
    """Return the six powers of a dimension of which the last ones may be left out."""
    return tuple(map(Fraction, (*written, *(0,) * (6 - len(written)))))


def factor(name, shape):
    """Return one factor: a name, its power or its root, in one of the spellings."""
    size, powers = NAMES[name][0], powers_of(*NAMES[name][1])
    if shape in ROOTS:
        return Unit(shape.format(name), sqrt(size), tuple(p / 2 for p in powers))
    if shape == "{}":
        return Unit(name, size, powers)
    n = 3 if shape in CUBES else 2
    return Unit(shape.format(name), size**n, tuple(n * p for p in powers))


def joined(first, sign, second):
    """Return the product or the quotient of two units."""
    power = -1 if "/" in sign else 1
    pairs = zip(first.powers, second.powers, strict=True)
    return Unit(
        f"{first.text}{sign}{second.text}",
        first.size * second.size**power,
        tuple(a + power * b for a, b in pairs),
    )


def folded(parts, signs):
    """Return parts joined from left to right."""
    unit = parts[0]
    for sign, part in zip(signs, parts[1:], strict=False):
        unit = joined(unit, sign, part)
    return unit


def in_parentheses(unit):
    """Return a unit in parentheses, which changes what stands before them."""
    return Unit(f"({unit.text})", unit.size, unit.powers)


ROOTS = ("sqrt({})", "\N{SQUARE ROOT}{}", "\N{SQUARE ROOT}({})", "rt-{}", "rt{}")
CUBES = ("{}^3", "{}**3", "{}3", "{}\N{SUPERSCRIPT THREE}")
SQUARES = ("{}^2", "{}**2", "{}2", "{}\N{SUPERSCRIPT TWO}")
# In this grammar a root or a square is of a name: of a sign such as % it needs a word.
WORDS = [name for name in NAMES if name.isalpha()]
SIGNS = st.lists(
    st.sampled_from(["/", "*", " / ", "/ ", "\N{MIDDLE DOT}"]), min_size=3, max_size=3
)
FACTORS = st.builds(factor, st.sampled_from(list(NAMES)), st.just("{}")) | st.builds(
    factor, st.sampled_from(WORDS), st.sampled_from((*ROOTS, *SQUARES, *CUBES))
)
PRODUCTS = st.builds(folded, st.lists(FACTORS, min_size=1, max_size=3), SIGNS)
UNITS = st.builds(
    folded,
    st.lists(FACTORS | PRODUCTS.map(in_parentheses), min_size=1, max_size=3),
    SIGNS,
)


def can_be(value):
    """Say whether a quantity may have that size [SI]."""
    return value == 0.0 or 1e-30 <= abs(value) <= 1e30


@pytest.mark.slow
@examples(1500)
@given(
    text=st.text(max_size=40)
    | st.lists(st.sampled_from(PIECES), max_size=12).map("".join)
    | st.lists(st.sampled_from(PIECES), max_size=8).map(lambda p: "1.5 " + "".join(p)),
    like=st.sampled_from(LIKES),
    gravity=st.floats(9.5, 10.5),
)
def test_any_text_is_a_quantity_or_refused(text, like, gravity):
    """A text is a finite number of the kind, or an error on one printable line."""
    judge_quantity(text, like, gravity)


@pytest.mark.slow
@examples(600)
@given(number=st.sampled_from(["1", "2.5", "-3", "0", "1e-3", "+.5", "7."]), unit=UNITS)
def test_units_of_the_grammar_have_their_size_and_no_other_kind(number, unit):
    """A unit put together here is read with the size worked out here, by its kind only.

    No unit is taken for one of another dimension, in whatever spelling.
    """
    text = f"{number} {unit.text}"
    for like, powers in zip(LIKES, KINDS, strict=True):
        value = judge_quantity(text, like, STANDARD)
        if powers_of(*powers) != unit.powers:
            assert value is None, (text, like)
        elif len(text) <= 100 and can_be(float(number) * unit.size):
            assert value is not None, (text, like)
            assert_allclose(value, float(number) * unit.size, rtol=1e-12)


@examples(300)
@given(
    digits=st.text("0123456789", min_size=1, max_size=20),
    fraction=st.none() | st.text("0123456789", max_size=20),
    exponent=st.none() | st.integers(-330, 330),
    sign=st.sampled_from(["", "+", "-"]),
)
def test_numbers_are_read_to_the_last_bit_or_refused(digits, fraction, exponent, sign):
    """A decimal number of seconds is the nearest double, as Python's own reader says.

    Leading zeros are refused, and so is what no quantity can be.
    """
    text = sign + digits
    text += "" if fraction is None else f".{fraction}"
    text += "" if exponent is None else f"e{exponent}"
    value = judge_quantity(f"{text} s", "s", STANDARD)
    expected = float(text)
    gone = expected == 0.0 and any(c in "123456789" for c in text.partition("e")[0])
    padded = len(digits) > 1 and digits.startswith("0")
    if gone or padded or not can_be(expected):
        assert value is None, text
    else:
        assert value == expected, text
