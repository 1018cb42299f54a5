"""Types of the values in a file: quantities, texts, one value or one per axis."""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeVar, cast

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
    from collections.abc import Callable, Mapping, Sequence

    from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
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


@dataclass(frozen=True)
class Rule:
    """What parts of a mapping do not go together, and what is said then.

    Attributes
    ----------
    at : str or tuple
        The key, or the way to it, that it is said of.
    wrong : callable
        Whether a mapping breaks it.
    says : str
        With '{key}' for what the mapping has under a key, as its file prints it.
    """

    at: str | tuple[str | int, ...]
    wrong: Callable[..., object]  # of a mapping alone
    says: str

    @property
    def way(self) -> tuple[str | int, ...]:
        """The way to what it is said of."""
        return (self.at,) if isinstance(self.at, str) else self.at

    def found(self, mapping: BaseModel) -> str:
        """Return what is said of a mapping that breaks it."""
        return self.says.format_map(_Printed(mapping))


class _Printed(dict[str, object]):
    """What a mapping has under its keys, as its file prints it."""

    def __init__(self, mapping: BaseModel) -> None:
        self.mapping = mapping

    def __missing__(self, key: str) -> object:
        value = getattr(self.mapping, key)
        return getattr(value, "printed", value)


class Ruled(Strict):
    """A mapping whose parts have to go together."""

    rules: ClassVar[tuple[Rule, ...]] = ()  # of one key the first that is broken counts

    @model_validator(mode="after")
    def _check_rules(self) -> Self:
        broken = [rule for rule in self._rules() if rule.wrong(self)]
        found = {rule.way: rule.found(self) for rule in broken} | self._faults()
        if found:
            raise faults(found)
        return self

    def _rules(self) -> tuple[Rule, ...]:
        """Return the rules of its type, those that count most at the end."""
        return _rules_of(type(self))

    def _faults(self) -> dict[Any, str]:
        """Return what is wrong with it besides, by its path in the mapping."""
        return {}


@cache
def _rules_of(kind: type[Ruled]) -> tuple[Rule, ...]:
    """Return the rules of a type before them those of the types it is made of."""
    every = [vars(one).get("rules", ()) for one in kind.__mro__]
    return tuple(rule for rules in every for rule in rules)[::-1]


class FieldGroup(Ruled):
    """Beside a line that may be repeated, a group of lines that is, as a whole."""

    key: ClassVar[str]  # of the lines of a group
    of_all: ClassVar[tuple[str, ...]] = ()  # keys that a group says of all its lines
    if TYPE_CHECKING:
        repeat: int

    @property
    def is_group(self) -> bool:
        """Whether it is no line by itself."""
        return getattr(self, self.key) is not None

    @property
    def lines(self) -> tuple[Any, ...]:
        """The lines of a group; itself where it is none."""
        own: tuple[Any, ...] | None = getattr(self, self.key)
        return (self,) if own is None else own

    def _rules(self) -> tuple[Rule, ...]:
        """Return the rules of a line, where it is one."""
        return () if self.is_group else super()._rules()

    def _faults(self) -> dict[Any, str]:
        """Return what is wrong with a group."""
        if not self.is_group:
            return super()._faults()
        others = self.model_fields_set - {self.key, "repeat", *self.of_all}
        found: dict[Any, str] = {
            (key,): f"stands beside a group of {self.key}; say it in its lines"
            for key in sorted(others)
        }
        none = f"names no {self.key.removesuffix('s')}, expected one at least"
        return found if self.lines else {**found, (self.key,): none}

    @property
    def number(self) -> int:
        """How many it stands for."""
        if not self.is_group:
            return cast("int", super().number)  # type: ignore[misc]
        number: int = sum(line.number for line in self.lines)
        return self.repeat * number


def not_rising(
    values: Sequence[Quantity], at: str, says: str, *, least: float = 1.0
) -> dict[Any, str]:
    """Return where values do not rise, by their places from the second on.

    `says` has the words for the later one {after} and the one before it {one}; each has
    to be more than `least` times that.
    """
    return {
        (at, place): says.format(one=one.printed, after=after.printed)
        for place, (one, after) in enumerate(pairwise(values), start=1)
        if after.value <= one.value * least
    }


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


Time = Annotated[Quantity, Measured("s", bare=True)]
Span = Annotated[Quantity, Measured("s", Sign.POSITIVE, bare=True)]
Angle = Annotated[Quantity, Measured("deg", Sign.ANY)]


@dataclass(frozen=True, eq=False)
class Or:
    """Beside the type that it annotates, what a file may write in its place.

    Attributes
    ----------
    read : callable
        Of a value, of what reads the type, and of what is known of the file.
    describe : callable
        JSON Schema of either, of that of the type.
    """

    read: Callable[[Any, Callable[[object], object], ValidationInfo], object]
    describe: Callable[[JsonSchemaValue], JsonSchemaValue]

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either."""
        return core_schema.with_info_wrap_validator_function(self.read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Tell pydantic how to describe either."""
        inner: Any = schema
        return self.describe(handler(inner["schema"]))


def either(*schemas: JsonSchemaValue) -> JsonSchemaValue:
    """Return the JSON Schema of any of several."""
    return {"anyOf": [*schemas]}


def synonyms(meant: Mapping[str, str]) -> Or:
    """Allow, beside the words that a text may be, other spellings of them."""
    return Or(
        lambda value, word, _: word(
            meant.get(value, value) if isinstance(value, str) else value
        ),
        # Of one word the schema is enough.
        lambda words: (
            {**words, "enum": [*words["enum"], *meant]} if "enum" in words else words
        ),
    )


def or_text(measured: Measured, besides: str = "") -> Or:
    """Allow, beside a mapping, a text that says one quantity for all of it.

    Where it has to say more besides, the text is read to say what is wrong with it.
    """

    def read(value: Any, mapping: Callable[[object], object], info: Any) -> object:  # noqa: ANN401
        if isinstance(value, dict):
            return mapping(value)
        found = measured.read(value, info)
        if besides:
            raise fault(
                f"found {describe(value)} alone, expected more beside the value: "
                f"{{value: {value}, {besides}}}"
            )
        return found

    return Or(
        read,
        lambda schema: schema if besides else either(measured.json_schema, schema),
    )


def or_word(words: tuple[str, ...], example: str) -> Or:
    """Allow, beside a mapping, a word that stands for a whole one."""

    def read(value: Any, mapping: Callable[[object], object], _: object) -> object:  # noqa: ANN401
        if isinstance(value, dict):
            return mapping(value)
        if value in words:
            return value
        raise fault(
            f"found {describe(value)}, expected {' or '.join(words)}, or a mapping "
            f"such as {example}"
        )

    return Or(read, lambda schema: either({"enum": [*words]}, schema))


def or_one(key: str = "", besides: str = "") -> Or:
    """Allow, beside a sequence, one of its items alone.

    Where items are mappings, a text in its place is shown as the value of that key,
    with what an item has to say more.
    """

    def read(value: Any, items: Callable[[object], object], _: object) -> object:  # noqa: ANN401
        if key and isinstance(value, str | int | float) and not isinstance(value, bool):
            raise fault(
                f"found {describe(value)} alone, expected more beside the value: "
                f"{{{key}: {value}, {besides}}}"
            )
        return items((value,) if isinstance(value, dict if key else str) else value)

    return Or(read, lambda schema: either(schema["items"], schema))


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
    return Annotated[mapping_of(f"by axis in {like}", fields), or_text(measured)]


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
