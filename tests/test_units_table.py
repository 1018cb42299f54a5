"""Every unit that data sheets print: read right, or refused with what to write."""

from __future__ import annotations

import re

import pytest
from numpy.testing import assert_allclose

from budget.errors import SpecError, UnitError
from budget.spec import load_device
from budget.units import KINDS, parse_quantity, per_root_hertz

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
    ("month", TIME, "expected a time (s, min, h)"),
    ("year", TIME, "expected a time (s, min, h)"),
]

# What is measured has no line, whatever the spelling; where somebody might put it.
NOT_BUDGETED = {
    RATIO: (
        *("% FS", "ppm of FS", "% span", "ppm of span/°C", "ppm/°C", "%/°C"),
        *("mA/g", "mV/g", "LSB/g", "LSB/(°/s)", "mV/°/s"),
    ),
    ANGLE: ("% cross-axis", "µrad/°C", "arcsec/pulse", "arc-sec/pulse", "µrad/LSB"),
    RATE: (
        *("°/h/g²rms", "°/h/Gauss"),
        *("arcsec/pulse", "°C", "K", "V", "bit"),
    ),
    ACCELERATION: (
        *("µg/g³", "µg/g²rms", "mg/g²rms", "µg/Gauss"),
        *("µg/min", "ft/s/count", "m/s/LSB", "W", "mW", "mA", "gram", "grams", "kg"),
        *("lb", "cc", "cm³", "in³", "mm", "MTBF h", "FIT", "EUR"),
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
    path = tmp_path / "gyro.yaml"
    path.write_text(
        f"name: x\ngyro: {{errors: {{{line}: {figure}}}}}\n", encoding="utf-8"
    )
    return load_device(path).gyro.line(line)


def test_random_walk_and_density_differ_by_their_factor_of_sixty(tmp_path):
    """1 deg/sqrt(h) is a 60th of 1 (deg/s)/sqrt(Hz), 60 times 1 (deg/h)/sqrt(Hz).

    These are two-sided: one-sided ones, which is the default, are sqrt(2) smaller.
    """
    walk = gyro(tmp_path, "angle_random_walk", "1 deg/sqrt(h)")
    both = "{{value: 1 ({})/sqrt(Hz), density: two-sided}}"
    fast = gyro(tmp_path, "angle_random_walk", both.format("deg/s"))
    slow = gyro(tmp_path, "angle_random_walk", both.format("deg/h"))
    one_sided = gyro(tmp_path, "angle_random_walk", "1 (deg/s)/sqrt(Hz)")
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
    path = tmp_path / "accelerometer.yaml"
    path.write_text(
        f"name: x\nmass: 50 {unit}\n"
        f"accelerometer: {{errors: {{bias_repeatability: 50 {unit}}}}}\n",
        encoding="utf-8",
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
