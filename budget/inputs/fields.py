"""Types of the values in a file: quantities, texts, one value or one per axis."""

from __future__ import annotations

import re
from abc import abstractmethod
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, Self, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    TypeAdapter,
    create_model,
    model_validator,
)
from pydantic_core import (
    CoreSchema,
    InitErrorDetails,
    PydanticCustomError,
    ValidationError,
    core_schema,
)

from budget.errors import UnitError
from budget.inputs.tree import describe
from budget.units import NUMBER, STANDARD_GRAVITY, Quantity, kind_of, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue


Path = TypeVar("Path", bound=tuple[str | int, ...])  # keys and places in a list
_BREAK = re.compile(r"[\t\n\r]")


class Strict(BaseModel):
    """A mapping with known keys; nothing is converted in silence."""

    # Most are parts of others, or of files that a command does not read: each is built
    # where it is first asked.
    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, defer_build=True
    )


def fault(message: str) -> PydanticCustomError:
    """Return the error of one value, in our own words."""
    # The message is a parameter: braces in it are text, not places to fill.
    return PydanticCustomError("budget", "{message}", {"message": message})


KEY = "[key]"  # last of a path: the key there, as pydantic says it too


def faults(messages: Mapping[Path, str]) -> ValidationError:
    """Return the errors of several values, named by their path in the mapping."""
    return ValidationError.from_exception_data(
        "budget",
        [
            InitErrorDetails(type=fault(message), loc=path, input=None)
            for path, message in messages.items()
        ],
    )


class Checked(Strict):
    """A mapping whose parts have to go together."""

    @model_validator(mode="after")
    def _check_parts(self) -> Self:
        if messages := self._faults():
            raise faults(messages)
        return self

    @abstractmethod
    def _faults(self) -> Mapping[Any, str]:
        """Return what is wrong with it, by its path in the mapping."""


class Sign(Enum):
    """Which values a quantity may take."""

    ANY = "any"
    NOT_NEGATIVE = "not negative"
    POSITIVE = "positive"


@dataclass(frozen=True)
class Measured:
    """A text with a number and a unit of one kind, read into a Quantity."""

    like: str
    sign: Sign = Sign.NOT_NEGATIVE
    bare: bool = False  # a number without a unit means `like` to most people here

    def read(self, value: object, info: core_schema.ValidationInfo) -> object:
        """Return the quantity that a text says."""
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            kind = kind_of(self.like).name
            raise fault(
                f"found {describe(value)}, expected {kind} with its unit, "
                f"such as '1 {self.like}'"
            )
        gravity = (info.context or {}).get("gravity", STANDARD_GRAVITY)
        try:
            quantity = parse_quantity(
                str(value),
                self.like,
                gravity=gravity,
                bare=self.like if self.bare else "",
            )
        except UnitError as error:
            raise fault(str(error)) from None
        low = quantity.value < 0.0 or (
            quantity.value == 0.0 and self.sign is Sign.POSITIVE
        )
        if low and self.sign is not Sign.ANY:
            raise fault(
                f"found {value!r}, expected {kind_of(self.like).name} that is "
                f"{self.sign.value}"
            )
        return quantity

    @property
    def json_schema(self) -> JsonSchemaValue:
        """What an editor checks, and shows as help."""
        kind = kind_of(self.like)
        number = NUMBER if self.sign is Sign.ANY else NUMBER.replace("[+-]", r"\+", 1)
        return {
            "type": "string",
            "pattern": rf"^{number}\s*[^\s0-9.,:_+-].*$",
            "description": f"{kind.name}: a number and its unit",
            "examples": [
                f"1 {unit}" for unit in dict.fromkeys((self.like, *kind.units))
            ],
        }

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read the value."""
        return core_schema.with_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Tell pydantic how to describe the value."""
        return self.json_schema


@dataclass(frozen=True)
class Synonyms:
    """Beside the words that a text may be, other spellings of them."""

    meant: Mapping[str, str]  # by the other spelling

    def __hash__(self) -> int:
        """Return one number for all: types are kept by what they are made of."""
        return hash(tuple(self.meant))

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either spelling."""

        def read(value: object) -> object:
            return self.meant.get(value, value) if isinstance(value, str) else value

        return core_schema.no_info_before_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Tell pydantic how to describe all spellings; of one word that is enough."""
        words = handler(schema)
        own = words.get("enum")
        return {**words, "enum": [*own, *self.meant]} if own else words


@dataclass(frozen=True)
class OrText:
    """Beside the mapping it annotates, a text that says one quantity for all of it.

    Where it has to say more besides, the text is read to say what is wrong with it.
    """

    measured: Measured
    besides: str = ""

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
            found = self.measured.read(value, info)
            if self.besides:
                raise fault(
                    f"found {describe(value)} alone, expected more beside the value: "
                    f"{{value: {value}, {self.besides}}}"
                )
            return found

        return core_schema.with_info_wrap_validator_function(read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Tell pydantic how to describe either."""
        mapping = handler(schema["schema"])
        if self.besides:
            return mapping
        return {"anyOf": [self.measured.json_schema, mapping]}


@dataclass(frozen=True)
class Later:
    """A type that is made where a file first has a value of it.

    There is one for every line that a data sheet may have, and a file has a few: to
    make all of them takes longer than to read the file.
    """

    make: Callable[[], Any]  # the same type every time

    def read(self, value: object, info: core_schema.ValidationInfo) -> object:
        """Read a value of that type; what is wrong with it has its place in it."""
        return _adapter(self.make()).validator.validate_python(
            value, context=info.context
        )

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read the value."""
        return core_schema.with_info_plain_validator_function(self.read)


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:  # noqa: ANN401
    """Return what reads a value of a type, built once for all lines of that type."""
    return TypeAdapter(kind)


def mapping_of(
    title: str,
    fields: Mapping[str, Any],
    meanings: Mapping[str, str] | None = None,
    base: type[Strict] = Strict,
) -> type[Strict]:
    """Return the type of a mapping whose keys may all be left out."""
    optional: dict[str, Any] = {
        key: (kind | None, Field(default=None, description=(meanings or {}).get(key)))
        for key, kind in fields.items()
    }
    name = re.sub("[^A-Za-z]+", "_", title)
    return create_model(name, __base__=base, **optional)


@cache
def per_axis(like: str, axes: tuple[str, ...], sign: Sign) -> Any:  # noqa: ANN401
    """Return the type of one quantity for all axes, or of a mapping of axes."""
    measured = Measured(like, sign)
    fields = dict.fromkeys(axes, Annotated[Quantity, measured])
    return Annotated[mapping_of(f"by axis in {like}", fields), OrText(measured)]


@dataclass(frozen=True)
class OneOrMore:
    """Beside the sequence it annotates, one of its items alone.

    A text in its place is shown as the value of the key of an item, with what an item
    has to say more.
    """

    key: str
    besides: str

    def read(self, value: object) -> object:
        """Return the sequence that a value means."""
        if isinstance(value, str | int | float) and not isinstance(value, bool):
            raise fault(
                f"found {describe(value)} alone, expected more beside the value: "
                f"{{{self.key}: {value}, {self.besides}}}"
            )
        return (value,) if isinstance(value, dict) else value

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either."""
        return core_schema.no_info_before_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Describe either."""
        several = handler(schema)
        return {"anyOf": [several["items"], several]}


def by_axis(value: Quantity | Strict, axes: tuple[str, ...]) -> dict[str, Quantity]:
    """Return the quantity of each axis that a value names; a text names them all."""
    if isinstance(value, Quantity):
        return dict.fromkeys(axes, value)
    named = {axis: getattr(value, axis) for axis in axes}
    return {axis: quantity for axis, quantity in named.items() if quantity is not None}


def _check_text(text: str) -> str:
    """Refuse a text that says nothing."""
    if not text.strip():
        raise fault("is blank, expected text; or remove the key")
    return text


def _check_line(text: str) -> str:
    """Refuse a text that is more than one line."""
    if _BREAK.search(text):
        raise fault("has a tab or a line break, expected one line")
    return _check_text(text)


ShortText = Annotated[str, Field(max_length=200), AfterValidator(_check_line)]
LongText = Annotated[str, Field(max_length=4000), AfterValidator(_check_text)]
