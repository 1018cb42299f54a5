"""Text with a unit, against values converted by hand."""

from __future__ import annotations

import re
from math import pi

import pytest
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError, UnitError
from budget.inputs import load_device
from budget.units import KINDS, STANDARD_GRAVITY, parse_quantity, per_root_hertz

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


# ---- every unit that data sheets print: read right, or refused with what to write ----

RATE, ANGLE_WALK, RATE_WALK, ACCELERATION, VELOCITY_WALK = (
    *("deg/h", "deg/sqrt(h)", "deg/h/sqrt(h)", "ug", "ug/sqrt(Hz)"),
)
ACCELERATION_WALK, RATIO, ANGLE, TIME, FREQUENCY = (
    *("ug/sqrt(h)", "ppm", "arcsec", "s", "Hz"),
)

# Spelling as printed, kind, size in SI. By hand, to 16 digits, from 1 deg =
# 3.141592653589793/180 rad = 0.01745329251994330 rad; 1 h = 3600 s, whose root is 60;
# 1/sqrt(Hz) = sqrt(s); 1 g = 9.80665 m/s^2; 1 ft = 0.3048 m; 1 Gal = 0.01 m/s^2.
READ = [
    ("°/h/g", "deg/h/g", 4.943723709009050e-7),  # 4.84813681109536e-6 / 9.80665
    ("(°/s)/(m/s²)", "deg/h/g", 0.01745329251994330),
    ("µg/g²", "ug/g^2", 1.019716212977928e-7),  # 1e-6 / 9.80665
    ("ppm/g", "ug/g^2", 1.019716212977928e-7),
    ("°/h/°C", "deg/h/degC", 4.848136811095360e-6),
    ("µg/°C", "ug/degC", 9.80665e-6),
    ("mg/K", "ug/degC", 9.80665e-3),
    ("°C/min", "degC/h", 1.0 / 60.0),
    ("°/h", RATE, 4.848136811095360e-6),  # 0.0174532925199433 / 3600
    ("°/hr", RATE, 4.848136811095360e-6),
    ("°/hour", RATE, 4.848136811095360e-6),
    ("deg/h", RATE, 4.848136811095360e-6),
    ("deg/hr", RATE, 4.848136811095360e-6),
    ("°/s", RATE, 0.01745329251994330),
    ("°/sec", RATE, 0.01745329251994330),
    ("deg/s", RATE, 0.01745329251994330),
    ("dps", RATE, 0.01745329251994330),
    ("rad/s", RATE, 1.0),
    ("mrad/s", RATE, 0.001),
    ("arcsec/s", RATE, 4.848136811095360e-6),  # 1 arcsec = 1 deg / 3600
    ("º/h", RATE, 4.848136811095360e-6),  # the masculine ordinal indicator
    ("˚/h", RATE, 4.848136811095360e-6),  # the ring above
    ("∘/h", RATE, 4.848136811095360e-6),  # the ring operator
    ("dph", RATE, 4.848136811095360e-6),
    ("mdeg/s", RATE, 1.745329251994330e-5),
    ("m°/s", RATE, 1.745329251994330e-5),
    ("mdps", RATE, 1.745329251994330e-5),
    ("µdps", RATE, 1.745329251994330e-8),
    ("ndps", RATE, 1.745329251994330e-11),
    ("µrad/s", RATE, 1e-6),
    ("nrad/s", RATE, 1e-9),
    ("mdeg/h", RATE, 4.848136811095360e-9),
    ("°/√h", ANGLE_WALK, 2.908882086657216e-4),  # 0.0174532925199433 / 60
    ("°/√hr", ANGLE_WALK, 2.908882086657216e-4),
    ("deg/sqrt(hr)", ANGLE_WALK, 2.908882086657216e-4),
    ("deg/rt-hr", ANGLE_WALK, 2.908882086657216e-4),
    ("°/√s", ANGLE_WALK, 0.01745329251994330),
    ("°/√sec", ANGLE_WALK, 0.01745329251994330),
    ("rad/√s", ANGLE_WALK, 1.0),
    ("°/s/√Hz", ANGLE_WALK, 0.01745329251994330),  # deg/s sqrt(s) = deg/sqrt(s)
    ("(°/s)/√Hz", ANGLE_WALK, 0.01745329251994330),
    ("dps/√Hz", ANGLE_WALK, 0.01745329251994330),
    ("°/h/√Hz", ANGLE_WALK, 4.848136811095360e-6),  # a 60th of deg/sqrt(h)
    ("rad/s/√Hz", ANGLE_WALK, 1.0),
    ("mdps/√Hz", ANGLE_WALK, 1.745329251994330e-5),
    ("mdps/rtHz", ANGLE_WALK, 1.745329251994330e-5),
    ("dps/rt(Hz)", ANGLE_WALK, 0.01745329251994330),
    ("nrad/s/√Hz", ANGLE_WALK, 1e-9),
    ("deg/hr^(1/2)", ANGLE_WALK, 2.908882086657216e-4),
    ("deg/h^0.5", ANGLE_WALK, 2.908882086657216e-4),
    ("°/h**(0.5)", ANGLE_WALK, 2.908882086657216e-4),
    ("deg/h^½", ANGLE_WALK, 2.908882086657216e-4),
    ("mdeg/√h", ANGLE_WALK, 2.908882086657216e-7),
    ("°/h/√h", RATE_WALK, 8.080228018492267e-8),  # 4.84813681109536e-6 / 60
    ("°/s/√s", RATE_WALK, 0.01745329251994330),
    ("rad/s/√s", RATE_WALK, 1.0),
    ("g", ACCELERATION, 9.80665),
    ("mg", ACCELERATION, 9.80665e-3),
    ("\N{MICRO SIGN}g", ACCELERATION, 9.80665e-6),
    ("\N{GREEK SMALL LETTER MU}g", ACCELERATION, 9.80665e-6),
    ("ug", ACCELERATION, 9.80665e-6),
    ("ng", ACCELERATION, 9.80665e-9),
    ("m/s²", ACCELERATION, 1.0),
    ("m/s2", ACCELERATION, 1.0),
    ("mGal", ACCELERATION, 1e-5),
    ("Gal", ACCELERATION, 1e-2),
    ("ft/s²", ACCELERATION, 0.3048),
    ("mm/s²", ACCELERATION, 1e-3),
    ("cm/s²", ACCELERATION, 1e-2),
    ("um/s^2", ACCELERATION, 1e-6),
    ("nm/s²", ACCELERATION, 1e-9),
    ("µGal", ACCELERATION, 1e-8),
    ("m/s/√h", VELOCITY_WALK, 0.01666666666666667),  # 1 / 60
    ("m/s/√hr", VELOCITY_WALK, 0.01666666666666667),
    ("ft/s/√h", VELOCITY_WALK, 0.00508),  # 0.3048 / 60
    ("fps/√hr", VELOCITY_WALK, 0.00508),
    ("m/s/√s", VELOCITY_WALK, 1.0),
    ("\N{MICRO SIGN}g/√Hz", VELOCITY_WALK, 9.80665e-6),
    ("\N{GREEK SMALL LETTER MU}g/√Hz", VELOCITY_WALK, 9.80665e-6),
    ("mg/√Hz", VELOCITY_WALK, 9.80665e-3),
    ("µg/rtHz", VELOCITY_WALK, 9.80665e-6),
    ("ng/√Hz", VELOCITY_WALK, 9.80665e-9),
    ("µm/s²/√Hz", VELOCITY_WALK, 1e-6),
    ("mm/s/√h", VELOCITY_WALK, 1.666666666666667e-5),
    ("g/√Hz", VELOCITY_WALK, 9.80665),
    ("m/s²/√Hz", VELOCITY_WALK, 1.0),
    ("m/s²/√s", ACCELERATION_WALK, 1.0),
    ("\N{MICRO SIGN}g/√h", ACCELERATION_WALK, 1.634441666666667e-7),  # 9.80665e-6 / 60
    ("ppm", RATIO, 1e-6),
    ("%", RATIO, 1e-2),
    ("mrad", ANGLE, 1e-3),
    ("\N{MICRO SIGN}rad", ANGLE, 1e-6),
    ("\N{GREEK SMALL LETTER MU}rad", ANGLE, 1e-6),
    ("urad", ANGLE, 1e-6),
    ("arcmin", ANGLE, 2.908882086657216e-4),  # 0.0174532925199433 / 60
    ("arcsec", ANGLE, 4.848136811095360e-6),  # 0.0174532925199433 / 3600
    ("°", ANGLE, 0.01745329251994330),
    ("º", ANGLE, 0.01745329251994330),
    ("mdeg", ANGLE, 1.745329251994330e-5),
    ("udeg", ANGLE, 1.745329251994330e-8),
    ("nrad", ANGLE, 1e-9),
    ("ms", TIME, 1e-3),
    ("s", TIME, 1.0),
    ("min", TIME, 60.0),
    ("h", TIME, 3600.0),
    ("hr", TIME, 3600.0),
    ("hour", TIME, 3600.0),
    ("Hz", FREQUENCY, 1.0),
    ("kHz", FREQUENCY, 1e3),
    ("km", "m", 1e3),
    ("ft", "m", 0.3048),
    ("nmi", "m", 1852.0),
    ("km/h", "m/s", 0.2777777777777778),
    ("kn", "m/s", 0.5144444444444445),
    ("kt", "m/s", 0.5144444444444445),
]

# What is measured has a line, the spelling is another: spelling, kind, what to write.
RESPELLED = [
    ("milli-rad/s", RATE, "did you mean '5 mrad/s'?"),
    ("arc-sec/s", RATE, "did you mean '5 arcsec/s'?"),
    ("deg/Hr", RATE, "did you mean '5 deg/h'?"),
    ("°/h rms", RATE, "{value: 5 °/h, meaning: rms}"),
    ("mg rms", ACCELERATION, "{value: 5 mg, meaning: rms}"),
    ("µgrms", ACCELERATION, "{value: 5 µg, meaning: rms}"),
    ("deg/sqrt(h) max", ANGLE_WALK, "{value: 5 deg/sqrt(h), meaning: max}"),
    ("mg p-p", ACCELERATION, "{value: 5 mg, meaning: peak to peak}"),
    ("°/h (3\N{GREEK SMALL LETTER SIGMA})", RATE, "{value: 5 °/h, meaning: 3 sigma}"),
    ("Deg/Hr typ.", RATE, "{value: 5 deg/h, meaning: typical}"),
    ("micro-g", ACCELERATION, "did you mean '5 ug'?"),
    ("milli-g", ACCELERATION, "did you mean '5 mg'?"),
    ("deg/root-hr", ANGLE_WALK, "did you mean '5 deg/sqrt(h)'?"),
    ("°/√Hr", ANGLE_WALK, "did you mean '5 deg/sqrt(h)'?"),
    # Printed for two units that are a factor of 60 apart: both are named, none chosen.
    ("deg/hour 1/√Hz", ANGLE_WALK, "for deg/h/sqrt(Hz) and for deg/sqrt(h), which"),
    ("m/s/√Hz", VELOCITY_WALK, "for m/s/sqrt(h) and for m/s^2/sqrt(Hz), which"),
    ("sec", ANGLE, "which is a time, expected an angle (arcsec, arcmin"),
    ("arc-sec", ANGLE, "did you mean '5 arcsec'?"),
    ('"', ANGLE, "did you mean '5 arcsec'?"),
    ("samples/s", FREQUENCY, "did you mean '5 Hz'?"),
    ("KHz", FREQUENCY, "did you mean '5 kHz'?"),
    ("gal", ACCELERATION, "did you mean '5 Gal'?"),
    ("MGal", ACCELERATION, "expected an acceleration (ug, mg, g, m/s^2, mGal)"),
    ("mRad", ANGLE, "did you mean '5 mrad'?"),
    ("deg per root hour", ANGLE_WALK, "did you mean '5 deg/sqrt(h)'?"),
    # A density stays one: 5 deg/sqrt(s) would be another random walk.
    ("DPS/rtHz", ANGLE_WALK, "did you mean '5 deg/s/sqrt(Hz)'?"),
    ("Hr", TIME, "did you mean '5 h'?"),
    ("PPM", RATIO, "did you mean '5 ppm'?"),
    ("week", TIME, "expected a time (s, min, h, day, month, year)"),
]

# What is measured has no line, whatever the spelling; where somebody might put it.
READ += [
    ("ppm/°C", "ppm/degC", 1e-6),
    ("%/°C", "ppm/degC", 1e-2),
    ("K", "degC", 1.0),
    ("mm", "m", 1e-3),
    ("°C", "degC", 1.0),
    ("µrad/°C", "deg/h/(degC/min)", 1e-6),
    ("ppm/(°/s)²", "ppm/(deg/s)^2", 1e-6 / DEG**2),
    ("(°/h)/g²", "deg/h/g^2", DEG / 3600.0 / 9.80665**2),
]
NOT_BUDGETED = {
    RATIO: (
        *("% FS", "ppm of FS", "% span", "ppm of span/°C"),
        *("mA/g", "mV/g", "LSB/g", "LSB/(°/s)", "mV/°/s"),
    ),
    ANGLE: ("% cross-axis", "arcsec/pulse", "arc-sec/pulse", "µrad/LSB"),
    RATE: (
        *("°/h/g²rms", "°/h/Gauss"),
        *("arcsec/pulse", "V", "bit"),
    ),
    ACCELERATION: (
        *("µg/g²rms", "mg/g²rms", "µg/Gauss"),
        *("µg/min", "ft/s/count", "m/s/LSB", "W", "mW", "mA", "gram", "grams", "kg"),
        *("lb", "cc", "cm³", "in³", "MTBF h", "FIT", "EUR"),
    ),
}


@pytest.mark.parametrize(("unit", "like", "size"), READ)
def test_a_printed_unit_has_the_size_worked_out_by_hand(unit, like, size):
    """A unit in the spelling of a data sheet is read with its SI size."""
    assert_allclose(parse_quantity(f"5 {unit}", like).value, 5.0 * size, rtol=1e-15)


@pytest.mark.parametrize(("unit", "own"), [(unit, like) for unit, like, _ in READ])
def test_a_printed_unit_is_of_one_kind_only(unit, own):
    """Whatever else is asked for, the unit is refused and named as what it is."""
    (name,) = (kind.name for kind in KINDS if kind.units[0] == own)
    for kind in KINDS:
        if kind.name != name:
            with pytest.raises(UnitError) as caught:
                parse_quantity(f"5 {unit}", kind.units[0])
            assert f"which is {name}, expected {kind.name} (" in str(caught.value)


@pytest.mark.parametrize(("unit", "like", "words"), RESPELLED)
def test_a_spelling_that_is_not_read_is_refused_with_the_right_one(unit, like, words):
    """The message names the spelling to write, or both where makers mean two things."""
    with pytest.raises(UnitError) as caught:
        parse_quantity(f"5 {unit}", like)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("unit", "like"),
    [(unit, like) for like, units in NOT_BUDGETED.items() for unit in units],
)
def test_a_unit_of_no_model_is_refused_with_the_place_it_has(unit, like):
    """Nothing is dropped to make it fit; the message says where the figure may go."""
    with pytest.raises(UnitError) as caught:
        parse_quantity(f"5 {unit}", like)
    assert "under 'figures' of its device" in str(caught.value)
    assert "did you mean" not in str(caught.value)


def proposals(text, like):
    """Return the texts that the refusal of a text proposes in its place."""
    try:
        parse_quantity(text, like)
    except UnitError as error:
        _, _, hint = str(error).partition("did you mean ")
        return re.findall("'([^']*)'", hint) + re.findall("value: ([^,]*)", str(error))
    return []


@pytest.mark.parametrize(
    ("text", "like", "value"),
    [
        ("2.8 mdps/sqrt(Hz)", ANGLE_WALK, 4.886921905584124e-5),  # 2.8e-3 pi/180
        ("10 mdeg/s", RATE, 1.745329251994330e-4),
        ("250 nrad/s/sqrt(Hz)", ANGLE_WALK, 2.5e-7),
        ("20 um/s^2", ACCELERATION, 2e-5),
        ("0.07 deg/hr^(1/2)", ANGLE_WALK, 2.036217460660051e-5),  # 0.07 pi/180/60
    ],
)
def test_a_metric_prefix_is_read(text, like, value):
    """A figure with a prefix, or a power for a root, has the size it says."""
    assert_allclose(parse_quantity(text, like).value, value, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "like", "hint"),
    [
        ("5e-5", RATIO, "as a plain ratio that is '50 ppm'"),
        ("0.003", RATIO, "as a plain ratio that is '0.3 %'"),
        ("95", RATIO, ""),
        ("0", RATIO, ""),
        ("5e-5", ANGLE, ""),
        ("9.81", ACCELERATION, ""),
        ("1,500 deg/h", RATE, ""),  # decimal to one reader, thousands to another
        ("1,5 Deg/Hr", RATE, "did you mean '1.5 deg/h'?"),
        ("0.5 deg", RATE, ""),
        ("5 mG", ACCELERATION, ""),  # milligauss to a magnetometer
        ("5 Mrad", ANGLE, ""),  # mega, or milli with a slip
        ("5 mas", ANGLE, ""),
        ("> 5 mg", ACCELERATION, ""),  # no bound from above
    ],
)
def test_a_number_without_a_sound_unit_is_never_given_one(text, like, hint):
    """What nobody can know is not proposed; the units that are allowed are listed."""
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, like)
    (kind,) = (kind for kind in KINDS if kind.units[0] == like)
    tail = str(caught.value).partition(f"({', '.join(kind.units)})")[2]
    assert tail.removeprefix("; ") == hint


@pytest.mark.parametrize(
    ("number", "like", "hint"),
    [("95", "%", "95 %"), ("0.95", "%", "95 %"), ("9.81", "m/s^2", "9.81 m/s^2")],
)
def test_a_key_with_one_usual_unit_proposes_that(number, like, hint):
    """Where nearly all people mean one unit, the refusal of a bare number asks so."""
    with pytest.raises(UnitError, match=re.escape(f"'{hint}'")):
        parse_quantity(number, like, bare=like)


REPLACED = (
    *(("/", " per "), ("/", " / "), ("√", "root "), ("√", "rt-"), ("√", "")),
    *(("m", "milli-"), ("sec", "-sec"), ("deg", "degs"), ("°", "deg."), ("h", "hours")),
)
ADDED = (" max", " rms", " (3\N{GREEK SMALL LETTER SIGMA})", "/g", "s", " FS", "2")


def mutated(unit):
    """Yield a unit as people may misspell it: case, letters lost, words, additions."""
    yield from (unit.upper(), unit.lower(), unit.title(), unit.swapcase())
    for i in range(len(unit)):
        yield unit[:i] + unit[i + 1 :]
        yield unit[:i] + unit[i].swapcase() + unit[i + 1 :]
    yield from (unit.replace(old, new) for old, new in REPLACED)
    yield from (unit + end for end in ADDED)


@pytest.mark.slow
def test_no_hint_changes_a_quantity():
    """Every hint at a misspelled unit is read, as the quantity that was misspelled.

    Every spelling that is read, with every prefix it may have, is misspelled in many
    ways. A density stays a density, which is no random walk.
    """
    proposed = 0
    bare = [(unit, like) for unit, like, _ in READ]
    for unit, like in bare + [(p + unit, like) for unit, like in bare for p in "munk"]:
        try:
            meant = parse_quantity(f"5 {unit}", like)
        except UnitError:
            continue
        for wrong in mutated(unit):
            for text in proposals(f"5 {wrong}", like):
                proposed += 1
                read = parse_quantity(text, like)
                assert_allclose(read.value, meant.value, rtol=1e-12, err_msg=wrong)
                assert per_root_hertz(read.unit) == per_root_hertz(meant.unit), wrong
    assert proposed > 1000


@pytest.mark.parametrize("like", [kind.units[0] for kind in KINDS])
def test_nothing_of_another_kind_is_proposed(like):
    """A unit of one quantity is no slip for a unit of another."""
    for unit, own, _ in READ:
        if own != like:
            assert proposals(f"5 {unit}", like) == []


def gyro(tmp_path, line, figure):
    """Return a line of a gyro whose file says that figure."""
    path = put(
        tmp_path / "gyro.yaml", f"name: x\ngyro: {{errors: {{{line}: {figure}}}}}\n"
    )
    return load_device(path).gyro.line(line)


def test_random_walk_and_density_differ_by_their_factor_of_sixty(tmp_path):
    """1 deg/sqrt(h) is a 60th of 1 (deg/s)/sqrt(Hz), 60 times 1 (deg/h)/sqrt(Hz).

    These are two-sided: one-sided ones are sqrt(2) smaller.
    """
    walk = gyro(tmp_path, "angle_random_walk", "1 deg/sqrt(h)")
    both = "{{value: 1 ({})/sqrt(Hz), density: two-sided}}"
    fast = gyro(tmp_path, "angle_random_walk", both.format("deg/s"))
    slow = gyro(tmp_path, "angle_random_walk", both.format("deg/h"))
    side = "{value: 1 (deg/s)/sqrt(Hz), density: one-sided}"
    one_sided = gyro(tmp_path, "angle_random_walk", side)
    assert_allclose(fast.u, 2.0**0.5 * one_sided.u, rtol=1e-15)
    assert_allclose(walk.u, 2.908882086657216e-4, rtol=1e-15)
    assert_allclose(fast.u, 60.0 * walk.u, rtol=1e-15)
    assert_allclose(walk.u, 60.0 * slow.u, rtol=1e-15)
    assert (walk.unit, fast.unit) == ("deg/sqrt(h)", "(deg/s)/sqrt(Hz)")


@pytest.mark.parametrize(
    ("line", "figure", "words"),
    [
        ("angle_random_walk", "1 deg/s", "which is an angular rate"),
        ("angle_random_walk", "1 deg/h", "which is an angular rate"),
        ("angle_random_walk", "1 deg/sqrt(Hz)", "does not fit"),
        ("angle_random_walk", "1 deg*sqrt(h)", "does not fit"),
        ("angle_random_walk", "1 deg/h/sqrt(h)", "which is a rate random walk"),
        ("bias_stability", "1 deg/sqrt(h)", "which is an angle random walk"),
        ("bias_stability", "1 (deg/s)/sqrt(Hz)", "which is an angle random walk"),
        ("rate_random_walk", "1 deg/sqrt(h)", "which is an angle random walk"),
    ],
)
def test_no_rate_passes_for_a_random_walk(line, figure, words, tmp_path):
    """A rate, a random walk and its slope are three quantities, never exchanged."""
    with pytest.raises(SpecError, match=words):
        gyro(tmp_path, line, figure)


@pytest.mark.parametrize("micro", ["u", "\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}"])
def test_a_micro_g_is_an_acceleration_and_no_mass(micro, tmp_path):
    """50 ug of bias is 50e-6 times gravity; the same text as a mass stays a text."""
    unit = f"{micro}g"
    path = put(
        tmp_path / "accelerometer.yaml",
        f"name: x\nmass: 50 {unit}\n"
        f"accelerometer: {{errors: {{bias_repeatability: 50 {unit}}}}}\n",
    )
    device = load_device(path)
    line = device.accelerometer.line("bias_repeatability")
    assert_allclose(line.u, 4.903325e-4, rtol=1e-15)  # 50 x 9.80665e-6
    assert device.mass == f"50 {unit}"


@pytest.mark.parametrize("unit", ["microgram", "micrograms", "mcg", "mg*g/kg", "ugram"])
def test_no_mass_passes_for_an_acceleration(unit):
    """A spelling of micrograms is refused where an acceleration is needed."""
    with pytest.raises(UnitError, match=r"no known unit.*acceleration"):
        parse_quantity(f"50 {unit}", ACCELERATION)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("1.57", "'1.57 rad' or '1.57 deg'"),
        ("-3.14", "'-3.14 rad' or '-3.14 deg'"),
        ("0.785398", "'0.785398 rad' or '0.785398 deg'"),
        ("6.2832", "'6.2832 rad' or '6.2832 deg'"),
        ("45", "'45 deg'"),
        ("1.5", "'1.5 deg'"),
        ("0.70", "'0.70 deg'"),
        ("45.26", "'45.26 deg'"),
        ("1e-999999999999", "'1e-999999999999 deg'"),
    ],
)
def test_a_part_of_pi_without_a_unit_is_likelier_in_radians(text, hint):
    """A bare angle is meant in deg, but where its decimals are those of pi/12."""
    with pytest.raises(UnitError) as caught:
        parse_quantity(text, "deg", bare="deg")
    assert str(caught.value).endswith(f"did you mean {hint}?")


def test_a_field_has_units_for_lines_of_other_packages():
    """1 gauss is 1e-4 T; a rate per field is no rate, and has its place as a figure."""
    size = pi / 180.0 / 3600.0 / 1e-4
    for text in ("0.5 deg/h/gauss", "0.5 °/h/Gauss", "5 deg/h/mT"):
        assert_allclose(
            parse_quantity(text, "deg/h/gauss").value, 0.5 * size, rtol=1e-14
        )
    with pytest.raises(UnitError, match="which is a rate per magnetic flux density"):
        parse_quantity("0.5 deg/h/gauss", "deg/h")
