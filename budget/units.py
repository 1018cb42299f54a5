"""Units: the only place where a number that is not SI has a meaning.

Inside the package every number is SI and every angle in radians. Printed units are
factors here; text with a unit is read by `parse_quantity`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, lru_cache
from math import pi, prod, sqrt
from typing import TYPE_CHECKING

from budget.errors import UnitError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

HOUR = 3600.0  # [s]
DAY = 24.0 * HOUR  # [s]
YEAR = 365.25 * DAY  # [s], Julian: what a month is a twelfth of
DEGREE = pi / 180.0  # [rad]
ARCSEC = DEGREE / 3600.0  # [rad]
PPM = 1e-6  # [1]
DEG_PER_HOUR = DEGREE / HOUR  # [rad/s]
STANDARD_GRAVITY = 9.80665  # [m/s^2], exact by definition (CGPM 1901)
MICRO_G = 1e-6 * STANDARD_GRAVITY  # [m/s^2]

# Decimal and finite: no sign of thousands, no leading zero (YAML 1.1 reads 010 as 8).
NUMBER = r"[+-]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

# unit = term {("/" | "*") term}; a term is a name with or without a square, the root
# of a name, or a product of such factors in parentheses, which may have a power.
_NAME = "[A-Za-z]+"
_FACTOR = rf"(?:sqrt\({_NAME}\)|{_NAME}(?:(?:\^|\*\*)?[23])?)"
_PRODUCT = rf"{_FACTOR}(?:[/*]{_FACTOR})*"
_TERM = rf"(?:{_FACTOR}|\({_PRODUCT}\)(?:(?:\^|\*\*)[23])?)"
_UNIT = re.compile(rf"{_TERM}(?:[/*]{_TERM})*")
_TERMS = re.compile(
    rf"([/*]?)(?:\(({_PRODUCT})\)|sqrt\(({_NAME})\)|({_NAME}))(?:\^|\*\*)?([23])?"
)
_QUANTITY = re.compile(rf"((?>{NUMBER}))\s*([^\s\d.,:_+-]\S*(?: \S+)*)")
# Sizes a quantity may have, beside 0 [SI]. The law of propagation takes fourth powers
# of values and products of them, which must neither overflow nor vanish.
_SMALLEST, _LARGEST = 1e-30, 1e30
_LONGEST = 100  # characters; the longest value on a data sheet has about 20
_SAME = 1e-12  # relative difference of two sizes of one unit that is rounding

# Random walk over noise density, by what the maker's spectrum counts. A one-sided
# density D holds all power at positive frequencies: rms in a band B is D sqrt(B), and
# the random walk coefficient is N = D / sqrt(2); the two-sided density is N itself,
# and '' is a value that is the random walk, no density.
ONE_SIDED, TWO_SIDED = "one-sided", "two-sided"
WALK_PER_DENSITY = {ONE_SIDED: 1.0 / sqrt(2.0), TWO_SIDED: 1.0, "": 1.0}  # [1]


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number with its unit, as read from a text."""

    value: float  # [SI]
    unit: str  # as printed
    si_per_unit: float  # size of the unit [SI]
    printed: str  # the whole text


@dataclass(frozen=True)
class QuantityKind:
    """One kind of quantity: what people call it and how its units are spelled."""

    name: str  # with its article
    units: tuple[str, ...]  # the preferred spellings, the most usual first
    of_ratio: str = ""  # what to do with a ratio in its place


_OF_FULL_SCALE = (
    "; a ratio is of a full scale: give it as scale_factor_nonlinearity, with "
    "full_scale and shape: {}"
)
_QUADRATIC, _CUBIC = (_OF_FULL_SCALE.format(word) for word in ("quadratic", "cubic"))

KINDS = (
    QuantityKind("an angular rate", ("deg/h", "deg/s", "rad/s", "mrad/s", "arcsec/s")),
    QuantityKind(
        "an angle random walk",
        (
            "deg/sqrt(h)",
            "deg/sqrt(s)",
            "deg/h/sqrt(Hz)",
            "deg/s/sqrt(Hz)",
            "rad/s/sqrt(Hz)",
        ),
    ),
    QuantityKind(
        "a rate random walk", ("deg/h/sqrt(h)", "deg/s/sqrt(s)", "rad/s/sqrt(s)")
    ),
    QuantityKind("an acceleration", ("ug", "mg", "g", "m/s^2", "mGal")),
    QuantityKind(
        "a velocity random walk",
        ("ug/sqrt(Hz)", "mg/sqrt(Hz)", "g/sqrt(Hz)", "m/s/sqrt(h)", "ft/s/sqrt(h)"),
    ),
    QuantityKind("an acceleration random walk", ("ug/sqrt(h)", "m/s^2/sqrt(s)")),
    QuantityKind("a g-sensitivity", ("deg/h/g", "deg/s/g")),
    QuantityKind(
        "a second-order coefficient", ("ug/g^2", "mg/g^2", "ppm/g"), _QUADRATIC
    ),
    QuantityKind("a third-order coefficient", ("ug/g^3", "mg/g^3", "ppm/g^2"), _CUBIC),
    QuantityKind(
        "a second-order coefficient of a rate",
        ("ppm/(deg/s)", "deg/h/(deg/s)^2"),
        _QUADRATIC,
    ),
    QuantityKind(
        "a third-order coefficient of a rate",
        ("ppm/(deg/s)^2", "deg/h/(deg/s)^3"),
        _CUBIC,
    ),
    QuantityKind("a rate per square of an acceleration", ("deg/h/g^2", "deg/s/g^2")),
    QuantityKind("a temperature", ("degC", "K")),
    QuantityKind("a temperature rate", ("degC/h", "degC/min")),
    QuantityKind(
        "a coefficient of a temperature rate", ("deg/h/(degC/min)", "deg/h/(degC/h)")
    ),
    QuantityKind(
        "an acceleration per temperature rate", ("ug/(degC/min)", "ug/(degC/h)")
    ),
    QuantityKind("a temperature coefficient of a ratio", ("ppm/degC", "%/degC")),
    QuantityKind("a temperature coefficient of a rate", ("deg/h/degC", "deg/s/degC")),
    QuantityKind(
        "a temperature coefficient of an acceleration", ("ug/degC", "mg/degC")
    ),
    QuantityKind("a ratio", ("ppm", "%")),
    QuantityKind("an angle", ("arcsec", "arcmin", "deg", "mrad", "urad", "rad")),
    QuantityKind("a velocity", ("m/s", "mm/s", "um/s", "ft/s", "km/h", "kn")),
    QuantityKind("a time", ("s", "min", "h", "day", "month", "year")),
    QuantityKind("a length", ("m", "km", "nmi", "ft")),
    QuantityKind("a frequency", ("Hz", "kHz")),
    QuantityKind("a pressure", ("hPa", "kPa", "Pa", "mbar")),
    # Of lines of other packages: we have no model of a magnetic field.
    QuantityKind("a magnetic flux density", ("gauss", "uT", "mT", "T")),
    QuantityKind("a rate per magnetic flux density", ("deg/h/gauss", "deg/h/mT")),
    QuantityKind("an acceleration per magnetic flux density", ("ug/gauss", "ug/mT")),
)

# What a name means: a number times powers of other names. Those without a meaning are
# the base units, each with a dimension of its own; an angle has one, so that a rate is
# never taken for a frequency.
_BASES: dict[str, tuple[float, dict[str, float]] | None] = {
    "rad": None,
    "deg": (DEGREE, {"rad": 1.0}),
    "arcmin": (DEGREE / 60.0, {"rad": 1.0}),
    "arcsec": (ARCSEC, {"rad": 1.0}),
    "s": None,
    "min": (60.0, {"s": 1.0}),
    "h": (HOUR, {"s": 1.0}),
    "day": (DAY, {"s": 1.0}),
    "month": (YEAR / 12.0, {"s": 1.0}),
    "year": (YEAR, {"s": 1.0}),
    "Hz": (1.0, {"s": -1.0}),
    "m": None,
    "degC": None,
    "K": (1.0, {"degC": 1.0}),
    "ft": (0.3048, {"m": 1.0}),
    "nmi": (1852.0, {"m": 1.0}),  # exact by definition
    "kn": (1.0, {"nmi": 1.0, "h": -1.0}),
    "dps": (1.0, {"deg": 1.0, "s": -1.0}),
    "dph": (1.0, {"deg": 1.0, "h": -1.0}),
    "fps": (1.0, {"ft": 1.0, "s": -1.0}),
    "Gal": (1e-2, {"m": 1.0, "s": -2.0}),
    "g": (STANDARD_GRAVITY, {"m": 1.0, "s": -2.0}),  # or that of the place
    "Pa": None,  # of the air about a unit: a base, as no mass has a name
    "hPa": (100.0, {"Pa": 1.0}),
    "mbar": (100.0, {"Pa": 1.0}),
    "T": None,
    "gauss": (1e-4, {"T": 1.0}),
    "percent": (1e-2, {}),
    "ppm": (PPM, {}),
}
# Metric prefixes, and the units that take them. Never k before g, which is a mass.
_PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "k": 1e3}
_PREFIXED = {
    **dict.fromkeys(("rad", "deg", "dps", "s", "Gal", "g"), "mun"),
    "m": "kcmun",
    "dph": "m",
    "Hz": "k",
    "Pa": "k",
    "T": "mun",
}
DEFINITIONS = _BASES | {
    prefix + base: (_PREFIXES[prefix], {base: 1.0})
    for base, prefixes in _PREFIXED.items()
    for prefix in prefixes
}
ALIASES = {
    "degree": "deg",
    "degrees": "deg",
    "sec": "s",
    "hr": "h",
    "hour": "h",
    "hours": "h",
    "days": "day",
    "months": "month",
    "years": "year",
    "yr": "year",
    "kt": "kn",
    "knots": "kn",
    "Gauss": "gauss",
}

_SPELLINGS = str.maketrans(
    {
        "\N{MICRO SIGN}": "u",
        "\N{GREEK SMALL LETTER MU}": "u",
        # The last three are what copies out of a PDF have for the degree sign.
        "\N{DEGREE SIGN}": "deg",
        "\N{MASCULINE ORDINAL INDICATOR}": "deg",
        "\N{RING ABOVE}": "deg",
        "\N{RING OPERATOR}": "deg",
        "\N{PRIME}": "arcmin",
        "\N{DOUBLE PRIME}": "arcsec",
        "\N{SUPERSCRIPT TWO}": "^2",
        "\N{SUPERSCRIPT THREE}": "^3",
        "\N{VULGAR FRACTION ONE HALF}": "(1/2)",
        "\N{MIDDLE DOT}": "*",
        "\N{DOT OPERATOR}": "*",
        "%": "percent",
    }
)

# Printed for two units that are a factor of 60 apart (more by the sides of a density):
# nobody but the maker can tell.
AMBIGUOUS = {
    "m/s/sqrt(Hz)": ("m/s/sqrt(h)", "m/s^2/sqrt(Hz)"),
    "deg/h 1/sqrt(Hz)": ("deg/h/sqrt(Hz)", "deg/sqrt(h)"),
}
# Words that are not read, and the name that means the same.
_WORDS = {
    **{name.lower(): name for name in _BASES if name != "g"},  # G is gauss to many
    **dict.fromkeys(("degs", "degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("arcsecs", "arcsecond", "arcseconds"), "arcsec"),
    **dict.fromkeys(("arcmins", "arcminute", "arcminutes"), "arcmin"),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
    **dict.fromkeys(("days", "d"), "day"),
    **dict.fromkeys(("months", "mo"), "month"),
    **dict.fromkeys(("years", "yr", "yrs"), "year"),
    **dict.fromkeys(("metre", "metres", "meter", "meters"), "m"),
    **dict.fromkeys(("foot", "feet"), "ft"),
    "hertz": "Hz",
}
_ROOT = r"(?:\u221a|\b(?:square[ -]root|sqrt|root|rt)(?:[ -]of)?[ -]?)"
_RESPELL = (
    (r"''|\"", "arcsec"),
    (r"'", "arcmin"),
    (r"\bsamples?/(?:sec|s)\b|\bsps\b", "Hz"),
    (r"\s+per\s+", "/"),
    (rf"{_ROOT}\s*(?:\(({_NAME})\)|({_NAME}))", r"sqrt(\1\2)"),
    (r"\barc[ -](?=sec|min)", "arc"),
    (r"\bmilli[ -]?(?=[a-z])", "m"),
    (r"\bmicro[ -]?(?=[a-z])", "u"),
    (r"\bnano[ -]?(?=[a-z])", "n"),
)
# What a maker means, where it stands behind or before the value and not as 'meaning'.
_BEHIND = re.compile(
    r"[\s,(]*(?:(?P<max>max(?:imum|\.)?)|(?P<typical>typ(?:ical|\.)?)|(?P<rms>rms)"
    r"|(?P<peak_to_peak>p-p|pk-pk|peak[ -]to[ -]peak)"
    r"|(?P<sigma>[123])[ -]?(?:sigma|\u03c3))\)?",
    re.IGNORECASE,
)
_BEFORE = re.compile(
    r"(?:(?P<max><=?|\u2264|\u00b1|\+/-|max(?:imum|\.)?|up to)"
    r"|(?P<typical>~|\u2248|typ(?:ical|\.)?))\s*",
    re.IGNORECASE,
)
# What stands in units of which a data sheet has many and no model of ours has one.
_FOREIGN = re.compile(
    r"(?<![A-Za-z])(?:degC|C|K|FS|span|cross-axis|mA|A|mV|V|mW|W|LSB|pulse|count|bit|"
    r"Gauss|kg|grams?|lb|cc|[cm]m|in|MTBF|FIT|EUR|USD|CNY)(?![A-Za-z])"
)
_UNUSED = "a value that no model uses goes under 'figures' of its device, as text"


def parse_quantity(
    text: str, like: str, *, gravity: float = STANDARD_GRAVITY, bare: str = ""
) -> Quantity:
    """Read a number with its unit.

    Parameters
    ----------
    text : str
        What a person wrote: '0.005 deg/sqrt(h)'.
    like : str
        A unit of the kind that is needed here: 'deg/sqrt(h)'.
    gravity : float
        What `g` means [m/s^2].
    bare : str
        The unit that a number without one has here in the mouth of most people, as
        in 'latitude: 34.2': the refusal names it. '' where nobody can know.

    Returns
    -------
    Quantity
        Its value in SI, its unit as printed and the size of that unit.

    Raises
    ------
    UnitError
        The text is no finite number with a unit of that kind.
    """
    kind = kind_of(like)
    match = _QUANTITY.fullmatch(text.strip()) if len(text) <= _LONGEST else None
    if match is None:
        raise UnitError(_explain_text(text, kind, bare))
    number, unit = match.groups()
    size = _size(unit, gravity)
    if size is None or size.dimension != _dimension(like):
        raise UnitError(_explain_unit(text, number, unit, kind, size))
    # In decimal, so that 95 % is 0.95 to the last bit and 20 ppm is 2e-5.
    value = float(Decimal(repr(float(number))) * Decimal(repr(size.si_per_unit)))
    vanished = value == 0.0 and re.match(r"[^eE]*[1-9]", number)
    if vanished or (value != 0.0 and not _SMALLEST <= abs(value) <= _LARGEST):
        raise UnitError(
            f"found {text!r}, expected {kind.name} of a size that can be, 0 or "
            f"{_SMALLEST:g} to {_LARGEST:g} in SI units; see to its exponent"
        )
    return Quantity(
        value=value, unit=unit, si_per_unit=size.si_per_unit, printed=text.strip()
    )


def size_of(unit: str) -> float:
    """Return the size of a unit [SI].

    Raises
    ------
    UnitError
        It is none that we know.
    """
    size = _size(unit, STANDARD_GRAVITY)
    if size is None:
        raise UnitError(f"{unit!r} is no unit of this package")
    return size.si_per_unit


@lru_cache(maxsize=1024)
def si_unit(like: str) -> str:
    """Return the SI unit of what a unit is of, '1' of a ratio; 'SI' where none is."""
    units = kind_of(like).units
    if "%" in units:
        return "1"
    return next((unit for unit in units if size_of(unit) == 1.0), "SI")


def kind_of(like: str) -> QuantityKind:
    """Return the kind of quantity that `like` is a unit of; of none one of its own."""
    found = (k for k in KINDS if _dimension(k.units[0]) == _dimension(like))
    return next(found, QuantityKind(f"a quantity in {like}", (like,)))


@dataclass(frozen=True)
class _Size:
    """What a unit stands for."""

    si_per_unit: float  # [SI]
    dimension: frozenset[tuple[str, float]]  # base units and their powers


@lru_cache(maxsize=1024)
def _size(unit: str, gravity: float) -> _Size | None:
    """Return the size of a unit, or None where the text is no unit we know."""
    plain = _plain(unit)
    names = re.findall(_NAME, plain.replace("sqrt(", "("))
    if not _UNIT.fullmatch(plain) or not DEFINITIONS.keys() >= set(names):
        return None
    parts = list(_parts(_gathered(_powers(plain)), gravity))
    bases = _gathered((base, power) for _, base, power in parts if base)
    return _Size(prod(factor for factor, *_ in parts), frozenset(bases.items()))


def _powers(unit: str, of_all: float = 1.0) -> Iterator[tuple[str, float]]:
    """Yield the names of a unit of our grammar with their powers, in its order."""
    for operator, product, root, name, digit in _TERMS.findall(unit):
        power = of_all * float(digit or 1) * (-1.0 if operator == "/" else 1.0)
        if product:
            yield from _powers(product, power)
        else:
            yield root or name, 0.5 * power if root else power


def _parts(
    powers: Mapping[str, float], gravity: float
) -> Iterator[tuple[float, str, float]]:
    """Yield what powers of names are made of: a number, a base unit and its power.

    One of both at a time: the number stands with '' and 0, the base unit with 1.
    """
    for name, power in powers.items():
        meaning = DEFINITIONS[name]
        if meaning is None:
            yield 1.0, name, power
            continue
        factor, of = meaning
        yield (gravity if name == "g" else factor) ** power, "", 0.0
        yield from _parts({base: p * power for base, p in of.items()}, gravity)


def _gathered(powers: Iterable[tuple[str, float]]) -> dict[str, float]:
    """Add up the powers of each name, and leave out those that cancel."""
    total: dict[str, float] = {}
    for name, power in powers:
        total[name] = total.get(name, 0.0) + power
    return {name: power for name, power in total.items() if power}


@cache
def _dimension(like: str) -> frozenset[tuple[str, float]]:
    """Return the dimension of one of our own example units."""
    size = _size(like, STANDARD_GRAVITY)
    if size is None:
        raise UnitError(f"{like!r} is no unit of this package")
    return size.dimension


def per_root_hertz(unit: str) -> bool:
    """Say whether a unit is that of a noise density, per root of hertz."""
    return re.search(r"sqrt\(k?Hz\)", _plain(unit)) is not None


def _plain(unit: str) -> str:
    """Spell a unit in ASCII, with every root as sqrt(...) and no blank in it."""
    text = re.sub(r"\s*([/*()])\s*", r"\1", unit.translate(_SPELLINGS))
    text = re.sub(
        rf"(?:\u221a\s*|\brt-?)(?:\(({_NAME})\)|({_NAME}))", r"sqrt(\1\2)", text
    )
    half = r"(?:\(1/2\)|\(0?\.5\)|0?\.5)"
    text = re.sub(rf"({_NAME})(?:\^|\*\*){half}", r"sqrt(\1)", text)
    return re.sub(_NAME, lambda name: ALIASES.get(name[0], name[0]), text)


# Cached like the sizes: every variant of a device repeats the mistakes of its base.
@lru_cache(maxsize=1024)
def _explain_text(text: str, kind: QuantityKind, bare: str) -> str:
    """Say what is wrong with a text that is no number followed by a unit."""
    shown = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    found = f"found {shown!r}"
    allowed = f"expected {kind.name} ({', '.join(kind.units)})"
    text = text.strip()
    if re.fullmatch(NUMBER, text):
        return f"{found} without a unit, {allowed}{_with_unit(text, kind, bare)}"
    bound = _BEFORE.match(text)
    if bound:
        return f"{found}, {allowed}{_as_mapping(text[bound.end() :], bound, kind)}"
    number = re.split(r"[^0-9.,:_+\u2212-]", text)[0]
    mended = number.replace("_", "").replace("\u2212", "-")
    # A comma before three digits is decimal to one reader, of thousands to another.
    if not re.search(r",[0-9]{3}(?![0-9])", mended):
        mended = mended.replace(",", ".")
    mended = re.sub(r"^([+-]?)0+(?=[0-9])", r"\1", mended)
    mended = _readable(mended + text[len(number) :], kind)
    hint = f"; did you mean {mended!r}?" if mended else ""
    return f"{found}, which is no number with a unit, {allowed}{hint}"


@lru_cache(maxsize=1024)
def _explain_unit(
    text: str, number: str, unit: str, kind: QuantityKind, size: _Size | None
) -> str:
    """Say what is wrong with a unit, and how the same unit is spelled here.

    No hint is another quantity or another size than what was written: where nobody
    can say which unit was meant, the units that are allowed have to do.
    """
    allowed = f"expected {kind.name} ({', '.join(kind.units)})"
    behind = next((m for m in _BEHIND.finditer(unit) if m.end() == len(unit)), None)
    if behind:
        advice = _as_mapping(f"{number} {unit[: behind.start()]}", behind, kind)
        if advice:
            return f"found {text!r}, {allowed}{advice}"
    plain = _plain(unit)
    meant = [u for u in AMBIGUOUS.get(plain, ()) if _fits(u, kind)]
    names: list[str] = []
    if size is None:
        why = f"{unit!r} is no known unit"
    else:
        names = [k.name for k in KINDS if _dimension(k.units[0]) == size.dimension]
        why = f"which is {names[0]}" if names else f"{unit!r} does not fit"
    if meant:
        advice = (
            f"; makers print it for {' and for '.join(meant)}, which differ by a "
            "factor of 60 or more; ask which is meant"
        )
    elif size is None and (mended := _readable(f"{number} {unit}", kind)):
        advice = f"; did you mean {mended!r}?"
    else:
        part = plain.startswith(tuple(f"{u}/" for u in kind.units))
        # A magnetic field has no model of ours.
        odd = size is not None and (not names or "T" in dict(size.dimension))
        foreign = size is None and (part or _FOREIGN.search(plain))
        if kind.of_ratio and size is not None and not size.dimension:
            return f"found {text!r}, {why}, {allowed}{kind.of_ratio}"
        advice = f"; {_UNUSED}" if odd or foreign else ""
    return f"found {text!r}, {why}, {allowed}{advice}"


def _with_unit(number: str, kind: QuantityKind, bare: str) -> str:
    """Say which quantity a number without a unit is, where that can be said."""
    size = abs(float(number))
    if "ppm" in kind.units and PPM / 1e3 <= size < 1.0:
        unit, power = ("ppm", 6) if size < 1e3 * PPM else ("%", 2)
        scaled = Decimal(number).scaleb(power).normalize()
        return f"; as a plain ratio that is '{scaled:f} {unit}'"
    if bare == "deg" and _is_part_of_pi(number):
        return f"; did you mean '{number} rad' or '{number} {bare}'?"
    return f"; did you mean '{number} {bare}'?" if bare else ""


def _is_part_of_pi(number: str) -> bool:
    """Whether a number is a multiple of pi/12 to its decimals, two of them at least."""
    decimals = re.fullmatch(r"[+-]?[0-9]*\.([0-9]{2,15})", number)
    if not decimals:
        return False
    off = (abs(abs(float(number)) - k * pi / 12.0) for k in range(1, 25))
    return min(off) < 10.0 ** -len(decimals[1])


def _as_mapping(rest: str, words: re.Match[str], kind: QuantityKind) -> str:
    """Say how a value is written whose meaning stands in its text."""
    readable = _readable(rest.strip(), kind)
    if not readable:
        return ""
    meaning, said = next((k, v) for k, v in words.groupdict().items() if v)
    if meaning == "sigma":
        meaning = f"{said} sigma"
    as_key = meaning.replace("_", " ")
    return f"; a specification value says so: {{value: {readable}, meaning: {as_key}}}"


def _readable(text: str, kind: QuantityKind) -> str:
    """Return a text that is read as what this one says; '' where nobody knows one.

    The text itself where it is read, else one with the same number in which words of
    the unit are spelled otherwise: 'Deg/Hr', 'milli-g', 'arc-sec', 'deg per root hour'.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        return ""
    number, unit = match.groups()
    if _fits(unit, kind):
        return text
    spelled = unit.translate(_SPELLINGS)
    for pattern, strict in _RESPELL:
        spelled = re.sub(pattern, strict, spelled, flags=re.IGNORECASE)
    spelled = _plain(re.sub(_NAME, lambda name: _strict_name(name[0]), spelled))
    if not _fits(spelled, kind):
        return ""
    same = [usual for usual in kind.units if _same(spelled, usual)]
    return f"{number} {spelled if spelled in same or not same else same[0]}"


def _strict_name(name: str) -> str:
    """Return the name that a word stands for; the word where it stands for none."""
    if name == "sqrt" or name in DEFINITIONS:
        return name
    if name.lower() in _WORDS:
        return _WORDS[name.lower()]
    # A capital M is mega, so case is free in what follows a prefix only.
    prefix, base = name[0].replace("K", "k"), _WORDS.get(name[1:].lower())
    return f"{prefix}{base}" if base and prefix + base in DEFINITIONS else name


def _same(unit: str, other: str) -> bool:
    """Say whether units of one kind have one size, both or neither of a density."""
    one, two = _size(unit, STANDARD_GRAVITY), _size(other, STANDARD_GRAVITY)
    if one is None or two is None or per_root_hertz(unit) != per_root_hertz(other):
        return False
    return abs(one.si_per_unit / two.si_per_unit - 1.0) <= _SAME


def _fits(unit: str, kind: QuantityKind) -> bool:
    """Say whether a text is a unit of that kind."""
    size = _size(unit, STANDARD_GRAVITY)
    return size is not None and size.dimension == _dimension(kind.units[0])
