"""Structured names: whose quantity it is, which one, of which axis."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import TYPE_CHECKING, Self, TypeVar, cast

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

AXES = ("x", "y", "z")
ONE_VALUE = ("",)  # of what has no axes
ANGLES = ("xy", "xz", "yx", "yz", "zx", "zy")  # order of the six mounting angles
PAIRS = ("xy", "xz", "yz")  # of axes, in no order
PARAMETERS = {"scale_factor": AXES, "mounting_angle": ANGLES, "bias": AXES}
# What follows from mounting angles (budget.calibration.derived): of a triad, of both.
DERIVED = {"rotation": AXES, "non_orthogonality": PAIRS}
BETWEEN = {"misalignment": AXES}
# What a test of accelerometers may find besides: K_p of the input to the power p.
ORDERS = {"second_order": 2, "third_order": 3}
HIGHER = dict.fromkeys(ORDERS, AXES)
OUTPUTS = {**PARAMETERS, **HIGHER, **DERIVED, **BETWEEN}
IMU = "imu"  # owner of what belongs to both triads together
# What both make of a mission: errors of navigation at a time, of which the horizontal
# ones are lengths of vectors.
MISSION = "mission"
AIDING, ALIGNMENT = "aiding", "alignment"  # owners of what a mission adds to sources
HORIZONTAL = ("north", "east")
PLACES = {
    "position": (*HORIZONTAL, "down"),
    "velocity": (*HORIZONTAL, "down"),
    "attitude": ("roll", "pitch", "heading"),
}
LENGTHS = {"position": "horizontal", "velocity": "horizontal"}


N = TypeVar("N", bound="Name")


class Name(str):
    """A dotted text that keeps its parts: `gyro.bias.x`.

    It is the text itself wherever one is wanted (keys, documents, messages); whoever
    needs a part reads the attribute, and nobody splits strings.
    """

    __slots__ = ("axis", "owner", "quantity", "time")

    # 'gyro', 'accelerometer', 'station', ...; '' of a Problem that knows no owners.
    owner: str
    # 'bias', 'bias_stability', 'levelling.east'; the text itself without an owner.
    quantity: str
    axis: str  # 'x', 'xy', ...; '' where there is none
    time: float | None  # since a mission began [s]; None of what is at no time

    def __new__(
        cls,
        quantity: str,
        *,
        owner: str = "",
        axis: str = "",
        time: float | None = None,
    ) -> Self:
        """Join the parts that are there with dots."""
        # A Name has its own: of thousands of devices one stands for all.
        return cast("Self", _joined(cls, str(quantity), str(owner), str(axis), time))

    def __reduce__(self) -> tuple[object, ...]:
        """Keep the parts when the name is sent to another process."""
        return _name, (self.quantity, self.owner, self.axis, self.time)

    @property
    def group(self) -> Name:
        """The name without its axis: what several axes have in common."""
        return Name(self.quantity, owner=self.owner)

    @property
    def without_owner(self) -> Name:
        """The name within its owner: 'bias.x'."""
        return Name(self.quantity, axis=self.axis, time=self.time)

    def within(self, owner: str) -> Name:
        """Leave the owner out where it is that one: what stands among its own."""
        return self.without_owner if self.owner == owner else self


@lru_cache(maxsize=4096)
def _joined(
    kind: type[N], quantity: str, owner: str, axis: str, time: float | None
) -> N:
    """Return the name of these parts, once."""
    at = "" if time is None else f"{time:.10g}"
    self = str.__new__(kind, ".".join(x for x in (owner, quantity, axis, at) if x))
    self.owner, self.quantity, self.axis, self.time = owner, quantity, axis, time
    return self


SPANS = (("h", 3600.0, 2.0), ("min", 60.0, 1.0), ("s", 1.0, 0.0))  # unit [s], parts


def time_text(time: float) -> str:
    """Write a time as people do: '90 s', '10 min', '84.4 min', '1.5 h'; to ten digits.

    In the largest unit that it is whole in, hours by halves, else in the one that takes
    the fewest digits.
    """
    for unit, size, parts in SPANS:
        whole = parts * time / size
        if parts and time >= size and whole == round(whole):
            return f"{time / size:.10g} {unit}"
    fitting = [(time / size, unit) for unit, size, _ in SPANS if time >= size]
    value, unit = min(reversed(fitting), key=_digits, default=(time, "s"))
    return f"{value:.10g} {unit}"


def spellings(name: Name) -> tuple[str, ...]:
    """Return all that an output may be called: `mission.position.60 s` among it.

    A time with or without its unit; of a length of a vector without its axis, too.
    """
    if name.time is None:
        return (name,)
    heads = [Name(name.quantity, owner=name.owner, axis=name.axis)]
    if LENGTHS.get(name.quantity) == name.axis:
        heads.append(name.group)
    times = [f"{name.time / size:.10g} {unit}" for unit, size, _ in SPANS]
    return tuple(
        f"{head}.{at}" for head in heads for at in (f"{name.time:.10g}", *times)
    )


def with_parts(text: str, names: Iterable[Name]) -> list[Name]:
    """Return those that begin or end with some parts: 'gyro.bias', 'bias.x', 'x'."""
    begin, end = f"{text}.", f".{text}"
    return [name for name in names if name.startswith(begin) or name.endswith(end)]


def braced(names: Iterable[Name]) -> str:
    """List outputs, those of one quantity in one.

    'gyro.bias.{x, y, z}', 'mission.position.{north, east}.{10, 60}'.
    """
    found: dict[Name, tuple[dict[str, None], dict[str, None]]] = {}
    for name in names:
        axes, times = found.setdefault(name.group, ({}, {}))
        axes[name.axis] = None
        if name.time is not None:
            times[f"{name.time:.10g}"] = None
    return "; ".join(
        ".".join([group, *(f"{{{', '.join(part)}}}" for part in parts if any(part))])
        for group, parts in found.items()
    )


def _digits(quantity: tuple[float, str]) -> int:
    """Count the digits that the value of a quantity takes, zeros at its ends aside."""
    return len(f"{quantity[0]:.9e}".partition("e")[0].replace(".", "").rstrip("0"))


def keys_of(quantity: str) -> tuple[str, ...]:
    """Return the keys of a file that a quantity stands under: levelling, east."""
    return tuple(quantity.split("."))


def as_name(text: str) -> Name:
    """Return a name as it is; another text becomes a name without owner or axis."""
    return text if isinstance(text, Name) else Name(text)


def meant(text: str, known: Iterable[Name]) -> tuple[Name, ...]:
    """Return the known names that a person or a stored document means by a text.

    In full, or without the owner: 'bias_stability' is that of both triads.
    """
    return tuple(name for name in known if text in {name, name.without_owner})


def words(name: str) -> str:
    """Turn a key into words: 'scale_factor' to 'scale factor'."""
    plain = name.replace("non_", "non-").replace("turn_on", "turn-on").replace("_", " ")
    return " ".join("IMU" if word == IMU else word for word in plain.split(" "))


def key_title(key: str) -> str:
    """Write a key of a file as words, 'gyro bias stability'."""
    return words(key.replace(".", " "))


def by_group(names: Iterable[Name]) -> tuple[str, ...]:
    """Return parameters with those of one quantity in one: 'gyro.bias', '... x, y'."""
    axes: dict[Name, list[str]] = {}
    for name in names:
        axes.setdefault(name.group, []).append(name.axis)
    return tuple(
        group
        if len(found) == len(OUTPUTS.get(group.quantity, ()))
        else f"{group} {', '.join(found)}"
        for group, found in axes.items()
    )


@cache
def parameters_of(owner: str) -> tuple[Name, ...]:
    """Return the names of the 12 outputs of a triad, in their order."""
    return tuple(
        Name(quantity, owner=owner, axis=axis)
        for quantity, axes in PARAMETERS.items()
        for axis in axes
    )


def quantities_of(owner: str) -> Mapping[str, tuple[str, ...]]:
    """Return what can be asked of a triad, or of both: IMU; with the axes of each."""
    if owner == IMU:
        return BETWEEN
    higher = HIGHER if owner == "accelerometer" else {}
    return {**PARAMETERS, **higher, **DERIVED}


@cache
def every_output(owner: str) -> tuple[Name, ...]:
    """Return the names of all that can be asked of a triad, or of both: IMU."""
    return tuple(
        Name(quantity, owner=owner, axis=axis)
        for quantity, axes in quantities_of(owner).items()
        for axis in axes
    )


@cache
def components_of(name: Name) -> tuple[Name, ...]:
    """Return the two components that an output is the length of; () of others."""
    if name.owner != MISSION or LENGTHS.get(name.quantity) != name.axis:
        return ()
    return tuple(
        Name(name.quantity, owner=MISSION, axis=axis, time=name.time)
        for axis in HORIZONTAL
    )


def _name(quantity: str, owner: str, axis: str, time: float | None) -> Name:
    return Name(quantity, owner=owner, axis=axis, time=time)
