"""The range of a triad: the largest input of either sign that it reads."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field, create_model
from pydantic_core import PydanticCustomError

from budget.inputs.fields import (
    Measured,
    Or,
    Rule,
    Ruled,
    ShortText,
    Sign,
    either,
    fault,
    mapping_of,
    or_text,
)
from budget.inputs.tree import describe
from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import AXES
from budget.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import ValidationInfo
    from pydantic.json_schema import JsonSchemaValue

    from budget.arrays import Array


@dataclass(frozen=True)
class Bound(Measured):
    """A quantity that is both ends of a range, '300 deg/s' or '±300 deg/s'."""

    sign: Sign = Sign.POSITIVE

    def read(self, value: object, info: ValidationInfo) -> object:
        """Return the quantity that a text says."""
        text = value.removeprefix("±") if isinstance(value, str) else value
        return super().read(text, info)

    @property
    def json_schema(self) -> JsonSchemaValue:
        """What an editor checks, and shows as help."""
        found = super().json_schema
        return {**found, "pattern": found["pattern"].replace("^", "^±?", 1)}


MEASURED = {GYRO: Bound("deg/s"), ACCELEROMETER: Bound("g")}
FORM = "{gyro: 300 deg/s, accelerometer: 10 g}"
IS = "the largest input of either sign that it reads"


class RangeValue(Ruled):
    """What a file may say of the range of one triad, besides a text."""

    value: Quantity | None = None
    x: Quantity | None = None
    y: Quantity | None = None
    z: Quantity | None = None
    options: ShortText = Field(
        default="", description="ranges that it can be ordered or set to, as printed"
    )
    condition: ShortText = Field(default="", description="the maker's other words")

    rules: ClassVar[tuple[Rule, ...]] = (
        Rule(
            (),
            lambda given: given.absent,
            "says nothing of {absent}, expected value, or x, y and z",
        ),
    )

    @property
    def absent(self) -> str:
        """The axes that it says nothing of."""
        return ", ".join(axis for axis in AXES if self.of_axis(axis) is None)

    def of_axis(self, axis: str) -> Quantity | None:
        """Return what it says of an axis."""
        own: Quantity | None = getattr(self, axis)
        return self.value if own is None else own


def _read_alone(
    value: Any,  # noqa: ANN401
    mapping: Callable[[object], object],
    info: ValidationInfo,
) -> object:
    """Read a mapping of sensors, or a text: its unit says which."""
    if isinstance(value, dict):
        return mapping(value)
    for sensor, measured in MEASURED.items():
        with suppress(PydanticCustomError):
            measured.read(value, info)
            return mapping({sensor: value})
    raise fault(
        f"found {describe(value)}, expected {FORM}, each {IS}; in a file with one "
        "sensor '300 deg/s' will do; the maker's other words stand beside a value: "
        "{value: 300 deg/s, condition: ...}"
    )


def range_type(sensor: str) -> Any:  # noqa: ANN401
    """Return the type of the range of one triad: a text, or a mapping."""
    measured = MEASURED[sensor]
    fields: dict[str, Any] = dict.fromkeys(
        ("value", *AXES), (Annotated[Quantity, measured] | None, None)
    )
    mapping = create_model(f"range_{sensor}", __base__=RangeValue, **fields)
    return Annotated[mapping, or_text(measured)]


TYPES = {sensor: range_type(sensor) for sensor in MEASURED}
RANGES: Any = Annotated[
    mapping_of("ranges", TYPES),
    Or(
        _read_alone,
        lambda schema: either(*(one.json_schema for one in MEASURED.values()), schema),
    ),
]


@dataclass(frozen=True, kw_only=True)
class ReadRange:
    """The range of one triad, as its record has it."""

    range: Array  # shape (3,) [rad/s or m/s^2]
    range_printed: str  # for people: '±400 °/s (saturates at ±480 °/s)'


def read_range(given: Quantity | RangeValue) -> ReadRange:
    """Turn what a file says of the range of one triad into numbers and a text."""
    if isinstance(given, Quantity):
        given = RangeValue.model_construct(value=given)
    found = [(axis, one) for axis in AXES if (one := given.of_axis(axis)) is not None]
    texts = [f"{axis} ±{one.printed}" for axis, one in found]
    if len({one.printed for _, one in found}) == 1:
        texts = [f"±{found[0][1].printed}"]
    words = f"of {given.options}" if given.options else ""
    beside = "; ".join(filter(None, (words, given.condition)))
    return ReadRange(
        range=np.array([one.value for _, one in found]),
        range_printed=", ".join(texts) + (f" ({beside})" if beside else ""),
    )
