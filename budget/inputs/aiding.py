"""What a mission file says of aids: how it is aligned, what is measured, the filter."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import log, sqrt
from typing import TYPE_CHECKING, Any, ClassVar

from budget.errors import UnitError
from budget.inputs.fields import (
    KEY,
    TEXT,
    TIME,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    by_axis,
    by_name,
    fault,
    given_of,
    items,
    meaning,
    measured,
    one_of,
    or_else,
    or_text,
    per_axis,
    table,
)
from budget.inputs.records import Aiding, Believed, OwnFilter, joined
from budget.inputs.tree import Node, describe
from budget.model.source import SENSORS
from budget.model.sources import lines_of
from budget.names import AIDING, PARAMETERS, PLACES, Name
from budget.units import Quantity, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.inputs.fields import Read

ZERO_VELOCITY = "zero_velocity"
OPTIMAL, SELF, PERFECT = "optimal", "self", "perfect"
AXES = PLACES["position"]
MOST_EPOCHS = 100_000  # of all aids
CEP_OF_SIGMA = sqrt(2.0 * log(2.0))  # radius of half of a circular normal law [1]
# What is measured, by its name among the sources; and the unit of its size.
SIZES = {
    "gnss_position": "m",
    "gnss_velocity": "m/s",
    "gnss_position_drift": "m",
    "heading": "deg",
    "zero_velocity": "m/s",
    "odometer": "m/s",
}
VECTORS = ("gnss_position", "gnss_velocity", ZERO_VELOCITY)  # sizes by axis
CORRELATION_TIME = "correlation_time"
# Beyond these nothing is known: the earth's quarter, no speed that can be, half a turn.
MOST_UNKNOWN = {
    "position": parse_quantity("1e7 m", "m"),
    "velocity": parse_quantity("1e4 m/s", "m/s"),
    "level": parse_quantity("180 deg", "deg"),
    "heading": parse_quantity("180 deg", "deg"),
}
EXACTLY = "unset: known exactly"
_ROUNDING = 1e-9  # of a time, relative


def or_word(kind: ValueKind, words: tuple[str, ...], example: str) -> ValueKind:
    """Allow, beside a mapping, a word that stands for a whole one."""

    def read(node: Node, gravity: float, mapping: Read) -> object:
        value = node.value
        if value in words:
            return value
        if isinstance(value, dict) and SELF in words and SELF in value:
            raise fault(
                f"found {describe(value)}, expected self, which has its duration "
                "beside it, as 'alignment_time: 300 s'"
            )
        if isinstance(value, dict):
            return mapping(node, gravity)
        raise fault(
            f"found {describe(value)}, expected {' or '.join(words)}, or a mapping "
            f"such as {example}"
        )

    return or_else(kind, read, {"enum": [*words]})


class AlignmentPart(Keyed):
    """How well a mission knows where it begins, 1 sigma; what it does not say, all."""

    rows: ClassVar[Rows] = {
        **{
            key: KeyRow(measured(like), f"north, east and down each; {EXACTLY}")
            for key, like in (("position", "m"), ("velocity", "m/s"))
        },
        "level": KeyRow(measured("deg"), f"each of two tilts; {EXACTLY}"),
        "heading": KeyRow(measured("deg"), EXACTLY),
    }

    def _faults(self) -> dict[tuple[str, ...], str]:
        """Return what is larger than to know nothing of it."""
        return {
            (key,): f"found {one.printed!r}, expected {most.printed} at the most, "
            "which is to know nothing of it"
            for key, most in MOST_UNKNOWN.items()
            if (one := getattr(self, key)) and one.value > most.value * (1 + _ROUNDING)
        }

    @property
    def start(self) -> tuple[float, ...]:
        """Errors of position, velocity, attitude, each north, east, down [SI]."""
        position, velocity, level, heading = (
            0.0 if one is None else one.value
            for one in (self.position, self.velocity, self.level, self.heading)
        )
        three = len(AXES)
        return (*(position,) * three, *(velocity,) * three, level, level, heading)


ALIGNMENT = or_word(
    table(AlignmentPart), (PERFECT, SELF), "{position: 10 m, heading: 5 deg}"
)


def size_of(like: str, besides: str = "", **more: KeyRow) -> ValueKind:
    """Return the kind of the size of what is measured, with what it says besides."""
    size = measured(like, Sign.POSITIVE)
    axes = KeyRow(per_axis(like, AXES, Sign.POSITIVE), "those that differ, 1 sigma")
    rows = {"value": KeyRow(size), "axes": axes, **more}
    return or_text(table(rows=rows, title=f"size in {like}"), size, besides)


class Spanned(Keyed):
    """Something that is there for a while."""

    rows: ClassVar[Rows] = {
        "during": KeyRow(
            items(items(TIME, TIME)),
            "beside a trajectory: begins and ends of when it is there",
        )
    }
    rules: ClassVar[Rules] = (
        Rule(
            "during",
            lambda it: it.during == (),
            "names no time, expected such as [[0 s, 600 s]]",
        ),
    )

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return which spans are none, or not apart."""
        spans = self.during or ()
        ends: dict[tuple[str | int, ...], str] = {
            ("during", place): f"ends at {end.printed}, and begins at {begin.printed}; "
            "expected an end after its begin"
            for place, (begin, end) in enumerate(spans)
            if end.value <= begin.value
        }
        return ends | {
            ("during", place): f"begins at {after.printed}, before the one before ends "
            f"at {end.printed}; expected spans one after the other"
            for place, ((_, end), (after, _)) in enumerate(pairwise(spans), start=1)
            if after.value < end.value
        }


class AidPart(Spanned):
    """Something that is measured at a rate."""

    rows: ClassVar[Rows] = {
        "rate": KeyRow(
            measured("Hz", Sign.POSITIVE),
            "of its epochs, k/rate from the mission's start",
            is_needed=True,
        )
    }


class GnssPart(AidPart):
    """Position and velocity from satellites, loosely coupled."""

    rows: ClassVar[Rows] = {
        "position": KeyRow(
            size_of("m", meaning=KeyRow(meaning("1 sigma", "CEP"))), "white by epoch"
        ),
        "velocity": KeyRow(size_of("m/s"), "white by epoch"),
        "position_drift": KeyRow(
            size_of(
                "m",
                besides="correlation_time: 60 s",
                correlation_time=KeyRow(measured("s", Sign.POSITIVE)),
            ),
            "an error of the position that fades (Gauss-Markov)",
        ),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "position_drift",
            lambda it: it.position_drift and it.position_drift.correlation_time is None,
            "says no correlation_time, expected such as {{value: 2.5 m, "
            "correlation_time: 60 s}}",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: getattr(getattr(it, key), "value", 0) is None,
                "says no value, expected such as {{value: 2.5 m}}",
            )
            for key in ("position", "velocity", "position_drift")
        ),
        Rule(
            "position",
            lambda it: it.position is None and it.velocity is None,
            "has neither position nor velocity; expected one at least, such as "
            "'position: 2.5 m'",
        ),
        Rule(
            "position_drift",
            lambda it: it.position_drift and it.velocity and it.position is None,
            "is of a position, which is not there; add it",
        ),
    )


# What is measured besides positions, with the unit of its size and what that says.
_SIMPLE = {
    "heading": ("deg", "1 sigma, white by epoch", "a heading, as of two antennas", {}),
    ZERO_VELOCITY: (
        "m/s",
        "1 sigma of each axis, white by epoch",
        "where the vehicle stands, that it does",
        {"axes": KeyRow(per_axis("m/s", AXES, Sign.POSITIVE), "those that differ")},
    ),
    "odometer": (
        "m/s",
        "1 sigma, white by epoch",
        "a forward speed, as of wheels, in body axes",
        {},
    ),
}


class AidingPart(Keyed):
    """What is measured besides; segments or `during` say when."""

    rows: ClassVar[Rows] = {
        "gnss": KeyRow(table(GnssPart), "position and velocity from satellites"),
        **{
            key: KeyRow(
                table(
                    AidPart,
                    {
                        "value": KeyRow(
                            measured(like, Sign.POSITIVE), of, is_needed=True
                        ),
                        **more,
                    },
                    key,
                ),
                says,
            )
            for key, (like, of, says, more) in _SIMPLE.items()
        },
    }

    @property
    def parts(self) -> dict[str, AidPart]:
        """The aids that are there, by their keys."""
        return given_of(vars(self))

    def lines(
        self, spans: Mapping[str, Sequence[tuple[float, float]]]
    ) -> tuple[Aiding, ...]:
        """Return all that is measured, by when each aid is there [s]."""
        drift = None if self.gnss is None else self.gnss.position_drift
        fades: dict[str, Any] = {}
        if drift:
            time = drift.correlation_time.value
            fades = {"drift": _by_axis(drift), "correlation_time": time}
        return tuple(
            Aiding(
                name=name,
                u=_by_axis(given) if name in VECTORS else (given.value.value,),
                rate=part.rate.value,
                spans=joined(spans[key]),
                **(fades if name == "gnss_position" else {}),
            )
            for key, part in self.parts.items()
            for name, given in _sizes_of(key, part)
            if given is not None
        )


def _sizes_of(key: str, part: Any) -> tuple[tuple[str, Any], ...]:  # noqa: ANN401
    """Return what an aid measures, by the name of the source, and how well."""
    if key != "gnss":
        return ((key, part),)
    return (("gnss_position", part.position), ("gnss_velocity", part.velocity))


AIDS = items(one_of(*AidingPart.rows), alone=True)


class FilterPart(Keyed):
    """A filter of its own: what it estimates, and what it believes otherwise."""

    rows: ClassVar[Rows] = {
        "estimates": KeyRow(
            items(TEXT),
            "parameters that are its states, such as gyro.bias; unset: all",
        ),
        "believes": KeyRow(
            by_name(TEXT),
            "specifications that it takes for others than they are, as --set "
            "writes them, 1 sigma: 'gyro.angle_random_walk: 0.03 deg/sqrt(h)'",
        ),
    }

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return what is none of its states, and no line that it could believe."""
        states: dict[tuple[str | int, ...], str] = {
            ("estimates", place): f"found {name!r}, expected one of "
            f"{', '.join(estimable())}"
            for place, name in enumerate(self.estimates or ())
            if name not in estimable()
        }
        found = {**states}
        for name, text in (self.believes or {}).items():
            try:
                _believed(name, text)
            except UnitError as error:
                on_key = () if name in _lines() else (KEY,)
                found["believes", name, *on_key] = str(error)
        return found

    @property
    def own(self) -> OwnFilter:
        """The filter as a record."""
        known = estimable()
        return OwnFilter(
            estimates=None
            if self.estimates is None
            else tuple(known[name] for name in self.estimates),
            believes=tuple(
                _believed(name, text) for name, text in (self.believes or {}).items()
            ),
        )


FILTER = or_word(table(FilterPart), (OPTIMAL,), "{estimates: [gyro.bias]}")


@cache
def estimable() -> dict[str, Name]:
    """Return the parameters that a filter may have as states, by their texts."""
    every = (Name(key, owner=kind) for kind in SENSORS for key in PARAMETERS)
    return {str(name): name for name in every}


@cache
def _lines() -> dict[str, tuple[Name, str, str]]:
    """Return each line that may be believed: its name, axis or time, and unit."""
    found = {}
    for kind in SENSORS:
        for line in lines_of(kind):
            name, like = Name(line.name, owner=kind), line.like(kind)
            if line.is_initial or not like:
                continue
            for axis in ("", *line.axes):
                found[str(Name(line.name, owner=kind, axis=axis))] = (name, axis, like)
            time = Name(line.name, owner=kind, axis=CORRELATION_TIME)
            found[str(time)] = (name, CORRELATION_TIME, "s")
    for key, like in SIZES.items():
        name = Name(key, owner=AIDING)
        found[str(name)] = (name, "", like)
    return found


def _believed(key: str, text: str) -> Believed:
    """Read what a filter believes of a line.

    Raises
    ------
    UnitError
        There is no such line, or that is no value of it.
    """
    known = _lines()
    if key not in known:
        raise UnitError(
            f"found {key!r}, which is no specification; expected one as "
            "--set names it, such as gyro.angle_random_walk, or of the aids, such "
            "as aiding.gnss_position"
        )
    name, inside, like = known[key]
    quantity = parse_quantity(text, like)
    if quantity.value < 0.0 or (
        quantity.value == 0.0 and (name.owner == AIDING or inside == CORRELATION_TIME)
    ):
        raise UnitError(f"found {text!r}, expected one above 0")
    is_time = inside == CORRELATION_TIME
    return Believed(
        line=name,
        value=quantity.value,
        printed=quantity.printed,
        axis="" if is_time else inside,
        is_time=is_time,
    )


def _by_axis(given: Any) -> tuple[float, ...]:  # noqa: ANN401 - a type made on the way
    """Return the sizes north, east and down, 1 sigma [SI].

    A CEP is the radius that half of all errors are in: sigma times sqrt(2 ln 2).
    """
    if isinstance(given, Quantity):
        return (given.value,) * len(AXES)
    part = CEP_OF_SIGMA if getattr(given, "meaning", None) == "CEP" else 1.0
    own = dict.fromkeys(AXES, given.value.value / part)
    if given.axes is not None:
        own |= {axis: one.value for axis, one in by_axis(given.axes, AXES).items()}
    return tuple(own.values())
