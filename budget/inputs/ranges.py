"""The range of a triad: the largest input of either sign that it reads."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field, create_model, model_validator
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from budget.inputs.fields import (
    Measured,
    OrText,
    ShortText,
    Sign,
    Strict,
    fault,
    faults,
    mapping_of,
)
from budget.inputs.tree import describe
from budget.model.sources import ACCELEROMETER, GYRO
from budget.names import AXES
from budget.units import Quantity

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue

    from budget.arrays import Array


@dataclass(frozen=True)
class Bound(Measured):
    """A quantity that is both ends of a range, '300 deg/s' or '±300 deg/s'."""

    sign: Sign = Sign.POSITIVE

    def read(self, value: object, info: core_schema.ValidationInfo) -> object:
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


class RangeValue(Strict):
    """What a file may say of the range of one triad, besides a text."""

    value: Quantity | None = None
    x: Quantity | None = None
    y: Quantity | None = None
    z: Quantity | None = None
    options: ShortText = Field(
        default="", description="ranges that it can be ordered or set to, as printed"
    )
    condition: ShortText = Field(default="", description="the maker's other words")

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        if absent := [axis for axis in AXES if self.of_axis(axis) is None]:
            message = (
                f"says nothing of {', '.join(absent)}, expected value, or x, y and z"
            )
            raise faults({(): message})
        return self

    def of_axis(self, axis: str) -> Quantity | None:
        """Return what it says of an axis."""
        own: Quantity | None = getattr(self, axis)
        return self.value if own is None else own


@dataclass(frozen=True)
class OfOneSensor:
    """Beside the mapping of sensors that it annotates, a text: its unit says which."""

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either."""

        def read(
            value: object,
            mapping: core_schema.ValidatorFunctionWrapHandler,
            info: core_schema.ValidationInfo,
        ) -> object:
            if isinstance(value, dict):
                return mapping(value)
            for sensor, measured in MEASURED.items():
                with suppress(PydanticCustomError):
                    measured.read(value, info)
                    return mapping({sensor: value})
            raise fault(
                f"found {describe(value)}, expected {FORM}, each {IS}; in a file with "
                "one sensor '300 deg/s' will do; the maker's other words stand beside "
                "a value: {value: 300 deg/s, condition: ...}"
            )

        return core_schema.with_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Tell pydantic how to describe either."""
        texts = [measured.json_schema for measured in MEASURED.values()]
        return {"anyOf": [*texts, handler(schema["schema"])]}


def range_type(sensor: str) -> Any:  # noqa: ANN401
    """Return the type of the range of one triad: a text, or a mapping."""
    measured = MEASURED[sensor]
    fields: dict[str, Any] = dict.fromkeys(
        ("value", *AXES), (Annotated[Quantity, measured] | None, None)
    )
    mapping = create_model(f"range_{sensor}", __base__=RangeValue, **fields)
    return Annotated[mapping, OrText(measured)]


TYPES = {sensor: range_type(sensor) for sensor in MEASURED}
RANGES: Any = Annotated[mapping_of("ranges", TYPES), OfOneSensor()]


@dataclass(frozen=True, kw_only=True)
class ReadRange:
    """The range of one triad, as its record has it."""

    values: Array  # shape (3,) [rad/s or m/s^2]
    printed: str  # for people: '±400 °/s (saturates at ±480 °/s)'


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
        values=np.array([one.value for _, one in found]),
        printed=", ".join(texts) + (f" ({beside})" if beside else ""),
    )
