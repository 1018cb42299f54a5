"""Units: the only place where a number that is not SI has a meaning.

Inside the package every number is SI and every angle in radians. Printed units are
factors here; text with a unit is read by `parse_quantity`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from difflib import SequenceMatcher
from functools import cache, lru_cache
from math import pi
from typing import TYPE_CHECKING

from budget.errors import UnitError

if TYPE_CHECKING:
    import pint

HOUR = 3600.0  # [s]
DEGREE = pi / 180.0  # [rad]
ARCSEC = DEGREE / 3600.0  # [rad]
PPM = 1e-6  # [1]
DEG_PER_HOUR = DEGREE / HOUR  # [rad/s]
STANDARD_GRAVITY = 9.80665  # [m/s^2], exact by definition (CGPM 1901)
MICRO_G = 1e-6 * STANDARD_GRAVITY  # [m/s^2]

# Decimal and finite: no sign of thousands, no leading zero (YAML 1.1 reads 010 as 8).
NUMBER = r"[+-]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"

# unit = term {("/" | "*") term}; a term is a name with or without a square, the root
# of a name, or a product of such factors in parentheses.
_NAME = "[A-Za-z]+"
_FACTOR = rf"(?:sqrt\({_NAME}\)|{_NAME}(?:(?:\^|\*\*)?2)?)"
_PRODUCT = rf"{_FACTOR}(?:[/*]{_FACTOR})*"
_TERM = rf"(?:{_FACTOR}|\({_PRODUCT}\))"
_UNIT = re.compile(rf"{_TERM}(?:[/*]{_TERM})*")
_QUANTITY = re.compile(rf"((?>{NUMBER}))\s*([^\s\d.,:_+-]\S*(?: \S+)*)")
# Sizes a quantity may have, beside 0 [SI]. The law of propagation takes fourth powers
# of figures and products of them, which must neither overflow nor vanish.
_SMALLEST, _LARGEST = 1e-30, 1e30
_LONGEST = 100  # characters; the longest figure on a data sheet has about 20
_NEAR = 0.5  # likeness from which one unit may be a slip for another


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A number with its unit, as read from a text."""

    value: float  # [SI]
    unit: str  # as printed
    si_per_unit: float  # size of the unit [SI]
    printed: str  # the whole text


@dataclass(frozen=True)
class Kind:
    """One kind of quantity: what people call it and how its units are spelled."""

    name: str  # with its article
    units: tuple[str, ...]  # the preferred spellings, the most usual first


KINDS = (
    Kind("an angular rate", ("deg/h", "deg/s", "rad/s", "mrad/s", "arcsec/s")),
    Kind(
        "an angle random walk",
        (
            "deg/sqrt(h)",
            "deg/sqrt(s)",
            "deg/h/sqrt(Hz)",
            "deg/s/sqrt(Hz)",
            "rad/s/sqrt(Hz)",
        ),
    ),
    Kind("a rate random walk", ("deg/h/sqrt(h)", "deg/s/sqrt(s)", "rad/s/sqrt(s)")),
    Kind("an acceleration", ("ug", "mg", "g", "m/s^2", "mGal")),
    Kind(
        "a velocity random walk",
        ("ug/sqrt(Hz)", "mg/sqrt(Hz)", "g/sqrt(Hz)", "m/s/sqrt(h)", "ft/s/sqrt(h)"),
    ),
    Kind("an acceleration random walk", ("ug/sqrt(h)", "m/s^2/sqrt(s)")),
    Kind("a ratio", ("ppm", "%")),
    Kind("an angle", ("arcsec", "arcmin", "deg", "mrad", "urad", "rad")),
    Kind("a time", ("s", "min", "h")),
    Kind("a frequency", ("Hz", "kHz")),
)

# Our own registry: pint's default one reads ug and mg as masses and turns deg/s into
# Hz. An angle is a dimension here, so that a rate is never taken for a frequency.
DEFINITIONS = {
    "rad": "[angle]",
    "mrad": "1e-3 * rad",
    "urad": "1e-6 * rad",
    "deg": f"{DEGREE!r} * rad",
    "arcmin": f"{DEGREE / 60.0!r} * rad",
    "arcsec": f"{ARCSEC!r} * rad",
    "s": "[time]",
    "ms": "1e-3 * s",
    "min": "60 * s",
    "h": "3600 * s",
    "Hz": "1 / s",
    "kHz": "1e3 * Hz",
    "m": "[length]",
    "ft": "0.3048 * m",
    "dps": "deg / s",
    "fps": "ft / s",
    "Gal": "1e-2 * m / s ** 2",
    "mGal": "1e-3 * Gal",
    "g": "GRAVITY * m / s ** 2",
    "mg": "1e-3 * g",
    "ug": "1e-6 * g",
    "ng": "1e-9 * g",
    "percent": "1e-2",
    "ppm": "1e-6",
}
ALIASES = {
    "degree": "deg",
    "degrees": "deg",
    "sec": "s",
    "hr": "h",
    "hour": "h",
}

_SPELLINGS = str.maketrans(
    {
        "\N{MICRO SIGN}": "u",
        "\N{GREEK SMALL LETTER MU}": "u",
        "\N{DEGREE SIGN}": "deg",
        "\N{PRIME}": "arcmin",
        "\N{DOUBLE PRIME}": "arcsec",
        "\N{SUPERSCRIPT TWO}": "^2",
        "\N{MIDDLE DOT}": "*",
        "\N{DOT OPERATOR}": "*",
        "%": "percent",
    }
)

# Spellings that are not read, and what makers mean by them; two where they differ.
MEANT = {
    "s": ("arcsec",),  # 'sec' beside an angle
    "min": ("arcmin",),
    '"': ("arcsec",),
    "'": ("arcmin",),
    "microg": ("ug",),
    "micro-g": ("ug",),
    "milli-g": ("mg",),
    "samples/s": ("Hz",),
    "m/s/sqrt(Hz)": ("m/s/sqrt(h)", "m/s^2/sqrt(Hz)"),  # a factor of 60
    "deg/h 1/sqrt(Hz)": ("deg/h/sqrt(Hz)", "deg/sqrt(h)"),  # a factor of 60
}
# What stands in units of which a data sheet has many and no model of ours has one.
_FOREIGN = re.compile(
    r"(?<![A-Za-z])(?:degC|C|K|FS|span|cross-axis|mA|A|mV|V|mW|W|LSB|pulse|count|bit|"
    r"Gauss|kg|grams?|lb|cc|[cm]m|in|MTBF|FIT|EUR|USD|CNY)(?![A-Za-z])"
)
_FIGURES = "a figure that no model uses goes under 'figures' of its device, as text"


def parse_quantity(
    text: str, like: str, *, gravity: float = STANDARD_GRAVITY
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
        raise UnitError(_explain_text(text, kind))
    number, unit = match.groups()
    size = _size(unit, gravity)
    if size is None or size.dimension != _dimension(like):
        raise UnitError(_explain_unit(text, number, unit, kind, size))
    # In decimal, so that 95 % is 0.95 to the last bit and 20 ppm is 2e-5.
    printed = Decimal(repr(float(number)))
    value = float(printed * Decimal(repr(size.si_per_unit)))
    vanished = value == 0.0 and re.match(r"[^eE]*[1-9]", number)
    if vanished or (value != 0.0 and not _SMALLEST <= abs(value) <= _LARGEST):
        raise UnitError(
            f"found {text!r}, expected {kind.name} of a size that can be, 0 or "
            f"{_SMALLEST:g} to {_LARGEST:g} in SI units; see to its exponent"
        )
    return Quantity(
        value=value, unit=unit, si_per_unit=size.si_per_unit, printed=text.strip()
    )


def kind_of(like: str) -> Kind:
    """Return the kind of quantity that `like` is a unit of."""
    return next(k for k in KINDS if _dimension(k.units[0]) == _dimension(like))


@dataclass(frozen=True)
class _Size:
    """What a unit stands for."""

    si_per_unit: float  # [SI]
    dimension: frozenset[tuple[str, object]]  # base dimension and its power


@lru_cache(maxsize=8)
def _registry(gravity: float) -> pint.UnitRegistry[float]:
    """Return the registry in which `g` is that gravity [m/s^2]."""
    import pint  # a quarter of a second, so not before a unit is read

    registry: pint.UnitRegistry[float] = pint.UnitRegistry(None)
    for name, definition in DEFINITIONS.items():
        registry.define(f"{name} = {definition.replace('GRAVITY', repr(gravity))}")
    return registry


@lru_cache(maxsize=1024)
def _size(unit: str, gravity: float) -> _Size | None:
    """Return the size of a unit, or None where the text is no unit we know."""
    plain = _plain(unit)
    names = re.findall(_NAME, plain.replace("sqrt(", "("))
    if not _UNIT.fullmatch(plain) or not DEFINITIONS.keys() >= set(names):
        return None
    powers = re.sub(r"sqrt(\([^)]*\))", r"\1**0.5", plain)
    powers = re.sub(r"([A-Za-z])(?:\^|\*\*)?2", r"\1**2", powers)
    parsed = _registry(gravity).Quantity(1.0, powers).to_root_units()
    return _Size(parsed.magnitude, frozenset(parsed.dimensionality.items()))


@cache
def _dimension(like: str) -> frozenset[tuple[str, object]]:
    """Return the dimension of one of our own example units."""
    size = _size(like, STANDARD_GRAVITY)
    if size is None:
        raise UnitError(f"{like!r} is no unit of this package")
    return size.dimension


def _plain(unit: str) -> str:
    """Spell a unit in ASCII, with every root as sqrt(...) and no blank in it."""
    text = re.sub(r"\s*([/*()])\s*", r"\1", unit.translate(_SPELLINGS))
    text = re.sub(rf"(?:\u221a|\brt-)(?:\(({_NAME})\)|({_NAME}))", r"sqrt(\1\2)", text)
    return re.sub(_NAME, lambda name: ALIASES.get(name[0], name[0]), text)


# Cached like the sizes: every variant of a device repeats the mistakes of its base.
@lru_cache(maxsize=1024)
def _explain_text(text: str, kind: Kind) -> str:
    """Say what is wrong with a text that is no number followed by a unit."""
    shown = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
    found = f"found {shown!r}"
    allowed = f"expected {kind.name} ({', '.join(kind.units)})"
    if re.fullmatch(NUMBER, text.strip()):
        example = f"{text.strip()} {kind.units[0]}"
        return f"{found} without a unit, {allowed}, for example {example!r}"
    if re.match(r"\s*[<>\u2264\u2265\u00b1~]", text):
        return f"{found}, {allowed}; write a bound as 'value' with 'meaning: max'"
    number = re.split(r"[A-Za-z%\u00b0]", text.strip())[0]
    mended = number.replace(",", ".").replace("_", "").replace("\u2212", "-")
    mended = re.sub(r"^([+-]?)0+(?=[0-9])", r"\1", mended)
    mended += text.strip()[len(number) :]
    hint = f"; did you mean {mended!r}?" if _QUANTITY.fullmatch(mended) else ""
    return f"{found}, which is no number with a unit, {allowed}{hint}"


@lru_cache(maxsize=1024)
def _explain_unit(
    text: str, number: str, unit: str, kind: Kind, size: _Size | None
) -> str:
    """Say what is wrong with a unit, and which right one is nearest to it."""
    allowed = f"expected {kind.name} ({', '.join(kind.units)})"
    bare = unit.removesuffix("rms").rstrip()
    if bare != unit and _fits(bare, kind):
        rms = f"write 'rms' as 'meaning: rms' beside 'value: {number} {bare}'"
        return f"found {text!r}, {allowed}; {rms}"
    why = f"{unit!r} is no known unit"
    size = size or _size(bare, STANDARD_GRAVITY)
    others: list[str] = []
    if size is not None:
        others = [k.name for k in KINDS if _dimension(k.units[0]) == size.dimension]
        why = f"which is {others[0]}" if others else f"{unit!r} does not fit"
    return f"found {text!r}, {why}, {allowed}{_advise(number, bare, kind, others)}"


def _advise(number: str, unit: str, kind: Kind, others: list[str]) -> str:
    """Say what to write in place of a unit that does not fit; '' where nobody knows.

    A hint never drops part of what is measured: '1 deg/h/g' is no slip for '1 deg/h'.
    """
    plain = _plain(unit)
    part = not others and plain.startswith(tuple(f"{u}/" for u in kind.units))
    meant = [u for u in MEANT.get(plain, ()) if _fits(u, kind)]
    if not meant and not _FOREIGN.search(plain):
        near = {u: SequenceMatcher(None, plain.lower(), u).ratio() for u in kind.units}
        best = max(kind.units, key=near.__getitem__)  # of equals the most usual one
        meant = [best] if near[best] > _NEAR and not part else []
    if meant:
        words = " or ".join(f"'{number} {spelling}'" for spelling in meant)
        return f"; did you mean {words}?"
    odd = not others and _size(unit, STANDARD_GRAVITY) is not None
    return f"; {_FIGURES}" if part or odd or _FOREIGN.search(plain) else ""


def _fits(unit: str, kind: Kind) -> bool:
    """Say whether a text is a unit of that kind."""
    size = _size(unit, STANDARD_GRAVITY)
    return size is not None and size.dimension == _dimension(kind.units[0])
