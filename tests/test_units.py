"""Text with a unit, against values converted by hand."""

from __future__ import annotations

import subprocess
import sys
from math import pi

import pytest
from numpy.testing import assert_allclose

from budget.errors import UnitError
from budget.units import STANDARD_GRAVITY, parse_quantity

DEG = pi / 180.0

# From the definitions: 1 deg = pi/180 rad, 1 h = 3600 s, 1 ft = 0.3048 m,
# 1 Gal = 1 cm/s^2, 1 g = 9.80665 m/s^2; sqrt(3600) = 60; 1/sqrt(Hz) = sqrt(s).
RATES = {
    "deg/h": DEG / 3600.0,
    "deg/hr": DEG / 3600.0,
    "deg/hour": DEG / 3600.0,
    "\N{DEGREE SIGN}/h": DEG / 3600.0,
    "\N{DEGREE SIGN}/hr": DEG / 3600.0,
    "deg/s": DEG,
    "deg/sec": DEG,
    "dps": DEG,
    "\N{DEGREE SIGN}/s": DEG,
    "rad/s": 1.0,
    "mrad/s": 1e-3,
    "arcsec/s": DEG / 3600.0,
}
ANGLE_RANDOM_WALKS = {
    "deg/sqrt(h)": DEG / 60.0,
    "deg/sqrt(hr)": DEG / 60.0,
    "deg/rt-hr": DEG / 60.0,
    "\N{DEGREE SIGN}/\N{SQUARE ROOT}h": DEG / 60.0,
    "\N{DEGREE SIGN}/\N{SQUARE ROOT}(h)": DEG / 60.0,
    "\N{DEGREE SIGN}/ \N{SQUARE ROOT}hr": DEG / 60.0,
    "deg/sqrt(s)": DEG,
    "deg/h/sqrt(Hz)": DEG / 3600.0,
    "deg/(h*sqrt(Hz))": DEG / 3600.0,
    "deg/s/sqrt(Hz)": DEG,
    "(\N{DEGREE SIGN}/s)/\N{SQUARE ROOT}Hz": DEG,
    "dps/\N{SQUARE ROOT}Hz": DEG,
    "rad/s/sqrt(Hz)": 1.0,
}
RATE_RANDOM_WALKS = {
    "deg/h/sqrt(h)": DEG / 216000.0,
    "deg/s/sqrt(s)": DEG,
    "rad/s/sqrt(s)": 1.0,
}
ACCELERATIONS = {
    "g": 9.80665,
    "mg": 9.80665e-3,
    "ug": 9.80665e-6,
    "\N{MICRO SIGN}g": 9.80665e-6,
    "\N{GREEK SMALL LETTER MU}g": 9.80665e-6,
    "ng": 9.80665e-9,
    "m/s^2": 1.0,
    "m/s**2": 1.0,
    "m/s2": 1.0,
    "m/s\N{SUPERSCRIPT TWO}": 1.0,
    "mGal": 1e-5,
    "Gal": 1e-2,
}
VELOCITY_RANDOM_WALKS = {
    "ug/sqrt(Hz)": 9.80665e-6,
    "\N{MICRO SIGN}g/\N{SQUARE ROOT}Hz": 9.80665e-6,
    "mg/sqrt(Hz)": 9.80665e-3,
    "g/sqrt(Hz)": 9.80665,
    "m/s/sqrt(h)": 1.0 / 60.0,
    "m/s^2/sqrt(Hz)": 1.0,
    "ft/s/sqrt(h)": 0.3048 / 60.0,
    "fps/\N{SQUARE ROOT}hr": 0.3048 / 60.0,
}
ACCELERATION_RANDOM_WALKS = {"ug/sqrt(h)": 9.80665e-6 / 60.0, "m/s^2/sqrt(s)": 1.0}
RATIOS = {"ppm": 1e-6, "%": 1e-2}
ANGLES = {
    "arcsec": DEG / 3600.0,
    "\N{DOUBLE PRIME}": DEG / 3600.0,
    "arcmin": DEG / 60.0,
    "deg": DEG,
    "\N{DEGREE SIGN}": DEG,
    "mrad": 1e-3,
    "urad": 1e-6,
    "\N{MICRO SIGN}rad": 1e-6,
    "rad": 1.0,
}
TIMES = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}
FREQUENCIES = {"Hz": 1.0, "kHz": 1e3}

BY_LIKE = {
    "deg/h": RATES,
    "deg/sqrt(h)": ANGLE_RANDOM_WALKS,
    "deg/h/sqrt(h)": RATE_RANDOM_WALKS,
    "ug": ACCELERATIONS,
    "ug/sqrt(Hz)": VELOCITY_RANDOM_WALKS,
    "ug/sqrt(h)": ACCELERATION_RANDOM_WALKS,
    "ppm": RATIOS,
    "arcsec": ANGLES,
    "s": TIMES,
    "Hz": FREQUENCIES,
}


@pytest.mark.parametrize(
    ("like", "unit", "size"),
    [
        (like, unit, size)
        for like, units in BY_LIKE.items()
        for unit, size in units.items()
    ],
)
def test_every_spelling_has_its_size(like, unit, size):
    """A unit that data sheets print has the size its definition gives."""
    quantity = parse_quantity(f"2.5 {unit}", like)
    assert_allclose(quantity.value, 2.5 * size, rtol=1e-15)
    assert_allclose(quantity.si_per_unit, size, rtol=1e-15)
    assert quantity.unit == unit
    assert quantity.printed == f"2.5 {unit}"


def test_density_and_random_walk_are_one_quantity():
    """0.1 deg/sqrt(h) is 6 deg/h/sqrt(Hz)."""
    walk = parse_quantity("0.1 deg/sqrt(h)", "deg/sqrt(h)")
    density = parse_quantity("6 deg/h/sqrt(Hz)", "deg/sqrt(h)")
    assert_allclose(walk.value, density.value, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "like", "value"),
    [
        ("95 %", "%", 0.95),
        ("20 ppm", "ppm", 2e-5),
        ("-1.5e-3 rad", "rad", -1.5e-3),
        (".5 s", "s", 0.5),
        ("5. s", "s", 5.0),
        ("+3E2 s", "s", 300.0),
        ("300s", "s", 300.0),
        ("  0 deg/h ", "deg/h", 0.0),
    ],
)
def test_decimal_numbers_are_read_to_the_last_bit(text, like, value):
    """A decimal number in a decimal unit is the nearest double."""
    assert parse_quantity(text, like).value == value


@pytest.mark.parametrize(
    ("text", "like", "power"),
    [("1 g", "g", 1.0), ("1 ug/sqrt(Hz)", "ug/sqrt(Hz)", 1e-6)],
)
def test_g_is_what_the_file_says(text, like, power):
    """Gravity scales g and what is derived from it, and nothing else."""
    own = parse_quantity(text, like, gravity=9.80708)
    assert_allclose(own.value, 9.80708 * power, rtol=1e-15)
    assert parse_quantity(text, like).value < own.value
    assert parse_quantity("1 m/s^2", "g", gravity=9.80708).value == 1.0


def test_standard_gravity_is_the_default():
    """Without a word g is 9.80665 m/s^2."""
    assert parse_quantity("1 g", "g").value == STANDARD_GRAVITY


@pytest.mark.parametrize(
    ("text", "like", "words"),
    [
        ("0.5 deg", "deg/h", ("which is an angle", "an angular rate (deg/h, deg/s")),
        ("0.5 deg/h", "deg", ("which is an angular rate", "an angle (arcsec, arcmin")),
        ("5 deg/h", "deg/sqrt(h)", ("an angular rate", "(deg/sqrt(h), deg/sqrt(s)")),
        ("5 Hz", "deg/h", ("which is a frequency", "an angular rate")),
        ("5 ug", "deg/h", ("which is an acceleration",)),
        ("5 rad", "ppm", ("which is an angle", "a ratio (ppm, %)")),
        ("5 m/s/sqrt(Hz)", "m/s/sqrt(h)", ("m/s/sqrt(h) and for m/s^2/sqrt(Hz)",)),
        ("5 Deg/Hr", "deg/h", ("'Deg/Hr' is no known unit", "did you mean '5 deg/h'")),
        ("5 PPM", "ppm", ("no known unit", "did you mean '5 ppm'")),
        ("5 degs/h", "deg/h", ("no known unit", "did you mean '5 deg/h'")),
        ("5 % FS", "ppm", ("'% FS' is no known unit",)),
        ("5 deg/hour 1/sqrt(Hz)", "deg/sqrt(h)", ("no known unit",)),
        ("5 sqrt(sqrt(h))", "s", ("no known unit",)),
        ("5 deg^9/h", "deg/h", ("no known unit",)),
        ("5 g; import os", "g", ("no known unit",)),
        ("7 mg rms", "g", ("{value: 7 mg, meaning: rms}",)),
        ("5", "deg/h", ("without a unit", "an angular rate (deg/h, deg/s")),
        ("1e-6", "deg/h", ("without a unit", "an angular rate (deg/h, deg/s")),
        ("deg/h", "deg/h", ("no number with a unit",)),
        ("", "deg/h", ("no number with a unit",)),
        ("1,5 deg/h", "deg/h", ("did you mean '1.5 deg/h'",)),
        ("1_000 deg/h", "deg/h", ("did you mean '1000 deg/h'",)),
        ("010 deg/h", "deg/h", ("did you mean '10 deg/h'",)),
        ("\N{MINUS SIGN}5 deg/h", "deg/h", ("did you mean '-5 deg/h'",)),
        ("1:30 deg/h", "deg/h", ("no number with a unit",)),
        ("0x10 deg/h", "deg/h", ("expected an angular rate",)),
        ("nan deg/h", "deg/h", ("no number with a unit",)),
        ("inf deg/h", "deg/h", ("no number with a unit",)),
        ("1e999 deg/h", "deg/h", ("an angular rate of a size that can be",)),
        ("1e-999 deg/h", "deg/h", ("1e-30 to 1e+30 in SI units",)),
        ("1.1e30 rad/s", "deg/h", ("1e-30 to 1e+30 in SI units",)),
        ("-9e-31 rad/s", "deg/h", ("1e-30 to 1e+30 in SI units",)),
        ("< 5 deg/h", "deg/h", ("{value: 5 deg/h, meaning: max}",)),
        ("\N{PLUS-MINUS SIGN}5 mg", "g", ("{value: 5 mg, meaning: max}",)),
        ("5 deg/h" + " " * 200 + "x", "deg/h", ("...", "no number with a unit")),
    ],
)
def test_refusals_say_what_was_found_what_is_allowed_and_what_to_do(text, like, words):
    """A text that is no quantity of the kind is refused in words that help."""
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, like)
    for word in ("found", "expected", *words):
        assert word in str(caught.value)


def test_importing_units_wakes_no_pint():
    """The constants cost no registry: pint is loaded by the first text only."""
    code = "import sys, budget.units; print('pint' in sys.modules)"
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "False"
