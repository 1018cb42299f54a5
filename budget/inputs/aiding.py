"""What a mission file says of aids: how it is aligned, what is measured, the filter."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import log, sqrt
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import Field, model_validator
from pydantic_core import core_schema

from budget.errors import UnitError
from budget.inputs.fields import (
    KEY,
    Checked,
    Measured,
    OrText,
    ShortText,
    Sign,
    Strict,
    by_axis,
    fault,
    faults,
    mapping_of,
    per_axis,
)
from budget.inputs.records import Aiding, Believed, OwnFilter
from budget.inputs.tree import describe
from budget.model.source import SENSORS
from budget.model.sources import lines_of
from budget.names import AIDING, PARAMETERS, PLACES, Name
from budget.units import Quantity, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

ZERO_VELOCITY = "zero_velocity"
OPTIMAL, SELF = "optimal", "self"
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
CORRELATION_TIME = "correlation_time"
# Beyond these nothing is known: the earth's quarter, no speed that can be, half a turn.
MOST_UNKNOWN = {
    "position": parse_quantity("1e7 m", "m"),
    "velocity": parse_quantity("1e4 m/s", "m/s"),
    "level": parse_quantity("180 deg", "deg"),
    "heading": parse_quantity("180 deg", "deg"),
}
_ROUNDING = 1e-9  # of a time, relative

Time = Annotated[Quantity, Measured("s", bare=True)]
Rate = Annotated[Quantity, Measured("Hz", Sign.POSITIVE)]


@dataclass(frozen=True)
class OrWord:
    """Beside the mapping it annotates, a word that stands for a whole one."""

    words: tuple[str, ...]
    example: str  # of a mapping

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either."""

        def read(
            value: object, mapping: core_schema.ValidatorFunctionWrapHandler
        ) -> object:
            if isinstance(value, dict):
                return mapping(value)
            if value in self.words:
                return value
            raise fault(
                f"found {describe(value)}, expected {' or '.join(self.words)}, or a "
                f"mapping such as {self.example}"
            )

        return core_schema.no_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Describe either."""
        return {"anyOf": [{"enum": [*self.words]}, handler(schema["schema"])]}


class OrOne:
    """Beside the sequence it annotates, one of its words alone."""

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either."""

        def read(value: object) -> object:
            return (value,) if isinstance(value, str) else value

        return core_schema.no_info_before_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Describe either."""
        several = handler(schema["schema"])
        return {"anyOf": [several["items"], several]}


class AlignmentPart(Strict):
    """How well a mission knows where it begins, 1 sigma; what it does not say, all."""

    position: Annotated[Quantity, Measured("m")] | None = Field(
        default=None, description="north, east and down each; unset: known exactly"
    )
    velocity: Annotated[Quantity, Measured("m/s")] | None = Field(
        default=None, description="north, east and down each; unset: known exactly"
    )
    level: Annotated[Quantity, Measured("deg")] | None = Field(
        default=None, description="each of two tilts; unset: known exactly"
    )
    heading: Annotated[Quantity, Measured("deg")] | None = Field(
        default=None, description="unset: known exactly"
    )

    @model_validator(mode="before")
    @classmethod
    def _check_word(cls, value: object) -> object:
        if isinstance(value, dict) and SELF in value:
            raise fault(
                f"found {describe(value)}, expected self, which has its duration "
                "beside it, as 'alignment_time: 300 s'"
            )
        return value

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        messages: dict[tuple[str | int, ...], str] = {
            (
                key,
            ): f"found {one.printed!r}, expected {most.printed} at the most, which "
            "is to know nothing of it"
            for key, most in MOST_UNKNOWN.items()
            if (one := getattr(self, key)) is not None
            and one.value > most.value * (1.0 + _ROUNDING)
        }
        if messages:
            raise faults(messages)
        return self

    @property
    def start(self) -> tuple[float, ...]:
        """Errors of position, velocity, attitude, each north, east, down [SI]."""
        position, velocity, level, heading = (
            0.0 if one is None else one.value
            for one in (self.position, self.velocity, self.level, self.heading)
        )
        three = len(AXES)
        return (*(position,) * three, *(velocity,) * three, level, level, heading)


def _size(like: str, **more: Any) -> Any:  # noqa: ANN401
    """Return the type of the size of what is measured, with what it says besides."""
    measured = Measured(like, Sign.POSITIVE)
    fields = {"axes": per_axis(like, AXES, Sign.POSITIVE), **more}
    meanings = {"axes": "those that differ, 1 sigma"}
    base = mapping_of(f"size in {like}", {"value": Annotated[Quantity, measured]})
    words = ", ".join(more)
    return mapping_of(f"size in {like} {words}", fields, meanings, base)


_Position: Any = Annotated[
    _size("m", meaning=Literal["1 sigma", "CEP"]),
    OrText(Measured("m", Sign.POSITIVE)),
]
_Velocity: Any = Annotated[_size("m/s"), OrText(Measured("m/s", Sign.POSITIVE))]
_ByAxis: Any = per_axis("m/s", AXES, Sign.POSITIVE)
_Drift: Any = Annotated[
    _size("m", correlation_time=Annotated[Quantity, Measured("s", Sign.POSITIVE)]),
    OrText(Measured("m", Sign.POSITIVE), besides="correlation_time: 60 s"),
]


class Spanned(Checked):
    """Something that is there for a while."""

    during: tuple[tuple[Time, Time], ...] | None = Field(
        default=None,
        description="beside a trajectory: begins and ends of when it is there",
    )

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return what is wrong with it."""
        if self.during is None:
            return {}
        found: dict[tuple[str | int, ...], str] = {}
        if not self.during:
            found["during",] = "names no time, expected such as [[0 s, 600 s]]"
        for place, (begin, end) in enumerate(self.during):
            if end.value <= begin.value:
                found["during", place] = (
                    f"ends at {end.printed}, and begins at {begin.printed}; expected "
                    "an end after its begin"
                )
        for place, (one, after) in enumerate(pairwise(self.during), start=1):
            if after[0].value < one[1].value:
                found["during", place] = (
                    f"begins at {after[0].printed}, before the one before ends at "
                    f"{one[1].printed}; expected spans one after the other"
                )
        return found


class AidPart(Spanned):
    """Something that is measured at a rate."""

    rate: Rate = Field(description="of its epochs, k/rate from the mission's start")

    def measured(self) -> dict[str, tuple[float, ...]]:
        """Return sizes by the name of the source [SI]."""
        raise NotImplementedError


class GnssPart(AidPart):
    """Position and velocity from satellites, loosely coupled."""

    position: _Position | None = Field(default=None, description="white by epoch")
    velocity: _Velocity | None = Field(default=None, description="white by epoch")
    position_drift: _Drift | None = Field(
        default=None, description="an error of the position that fades (Gauss-Markov)"
    )

    def _faults(self) -> dict[tuple[str | int, ...], str]:
        """Return what is wrong with it."""
        found = super()._faults()
        if self.position is None and self.velocity is None:
            found["position",] = (
                "has neither position nor velocity; expected one at least, such as "
                "'position: 2.5 m'"
            )
        elif self.position is None and self.position_drift is not None:
            found["position_drift",] = "is of a position, which is not there; add it"
        for key in ("position", "velocity", "position_drift"):
            one = getattr(self, key)
            if isinstance(one, Strict) and getattr(one, "value", None) is None:
                found[key,] = "says no value, expected such as {value: 2.5 m}"
        drift = self.position_drift
        if drift is not None and drift.correlation_time is None:
            found["position_drift",] = (
                "says no correlation_time, expected such as {value: 2.5 m, "
                "correlation_time: 60 s}"
            )
        return found

    def measured(self) -> dict[str, tuple[float, ...]]:
        """Return sizes by the name of the source [SI]."""
        given = {"gnss_position": self.position, "gnss_velocity": self.velocity}
        return {key: _by_axis(one) for key, one in given.items() if one is not None}


class HeadingPart(AidPart):
    """A heading, as of two antennas."""

    value: Annotated[Quantity, Measured("deg", Sign.POSITIVE)] = Field(
        description="1 sigma, white by epoch"
    )

    def measured(self) -> dict[str, tuple[float, ...]]:
        """Return sizes by the name of the source [SI]."""
        return {"heading": (self.value.value,)}


class ZeroVelocityPart(AidPart):
    """A vehicle that stands, and knows it."""

    value: Annotated[Quantity, Measured("m/s", Sign.POSITIVE)] = Field(
        description="1 sigma of each axis, white by epoch"
    )
    axes: _ByAxis | None = Field(default=None, description="those that differ")

    def measured(self) -> dict[str, tuple[float, ...]]:
        """Return sizes by the name of the source [SI]."""
        return {"zero_velocity": _by_axis(self)}


class OdometerPart(AidPart):
    """A forward speed, as of wheels, in body axes."""

    value: Annotated[Quantity, Measured("m/s", Sign.POSITIVE)] = Field(
        description="1 sigma, white by epoch"
    )

    def measured(self) -> dict[str, tuple[float, ...]]:
        """Return sizes by the name of the source [SI]."""
        return {"odometer": (self.value.value,)}


class AidingPart(Strict):
    """What is measured besides; segments or `during` say when."""

    gnss: GnssPart | None = Field(
        default=None, description="position and velocity from satellites"
    )
    heading: HeadingPart | None = Field(default=None, description="a heading")
    zero_velocity: ZeroVelocityPart | None = Field(
        default=None, description="where the vehicle stands, that it does"
    )
    odometer: OdometerPart | None = Field(default=None, description="a forward speed")

    @property
    def given(self) -> dict[str, AidPart]:
        """The aids that are there, by their keys."""
        parts = {key: getattr(self, key) for key in type(self).model_fields}
        return {key: part for key, part in parts.items() if part is not None}

    def lines(
        self, spans: Mapping[str, Sequence[tuple[float, float]]]
    ) -> tuple[Aiding, ...]:
        """Return all that is measured, by when each aid is there [s]."""
        drift = None if self.gnss is None else self.gnss.position_drift
        return tuple(
            Aiding(
                name=name,
                u=u,
                rate=part.rate.value,
                spans=joined(spans[key]),
                drift=_by_axis(drift) if drift and name == "gnss_position" else (),
                correlation_time=drift.correlation_time.value
                if drift and name == "gnss_position"
                else 0.0,
            )
            for key, part in self.given.items()
            for name, u in part.measured().items()
        )


Aids = Annotated[
    tuple[Literal["gnss", "heading", "zero_velocity", "odometer"], ...], OrOne()
]


class FilterPart(Strict):
    """A filter of its own: what it estimates, and what it believes otherwise."""

    estimates: tuple[ShortText, ...] | None = Field(
        default=None,
        description="parameters that are its states, such as gyro.bias; unset: all",
    )
    believes: dict[ShortText, ShortText] | None = Field(
        default=None,
        description="specifications that it takes for others than they are, as --set "
        "writes them, 1 sigma: 'gyro.angle_random_walk: 0.03 deg/sqrt(h)'",
    )

    @model_validator(mode="after")
    def _check_parts(self) -> Self:
        parameters = estimable()
        messages: dict[tuple[str | int, ...], str] = {
            ("estimates", place): f"found {name!r}, expected one of "
            f"{', '.join(parameters)}"
            for place, name in enumerate(self.estimates or ())
            if name not in parameters
        }
        for name, text in (self.believes or {}).items():
            try:
                _believed(name, text)
            except UnitError as error:
                on_key = () if name in _lines() else (KEY,)
                messages["believes", name, *on_key] = str(error)
        if messages:
            raise faults(messages)
        return self

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


def joined(spans: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Return spans of which none begins where the one before ends."""
    found: list[tuple[float, float]] = []
    for begin, end in spans:
        if found and begin <= found[-1][1] * (1.0 + _ROUNDING):
            found[-1] = (found[-1][0], end)
        else:
            found.append((begin, end))
    return tuple(found)


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
