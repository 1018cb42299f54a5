"""Fields of files: rows of keys, kinds of values, and the reader of both with places.

What a mapping in a file may hold is a table of rows: a key, the kind of its value, what
it means, what stands for it where the file has none. Kinds are quantities with their
unit and sign, words, numbers, texts, lists, mappings, and what may stand in their
place. One reader reads them all, each fault at its place and in our words; the JSON
Schema and `budget new` are made of the same rows. What parts of a mapping do not go
together are rules.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cache, cached_property
from itertools import pairwise
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from budget.errors import UnitError
from budget.inputs.checking import bracketed, mended, see, slip
from budget.inputs.makers import MEANINGS
from budget.inputs.tree import START, Node, all_of, describe
from budget.units import NUMBER, STANDARD_GRAVITY, Quantity, kind_of, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.errors import Issue
    from budget.inputs.tree import Steps, YamlFile

Schema = dict[str, Any]  # a JSON Schema, or a part of one
Schemas = dict["KeyTable", Schema]  # of mappings
Read = Callable[[Node, float], Any]
KEY = "[key]"  # last of a way: the key there, not its value


class Fault(NamedTuple):
    """What is wrong with a value, and the way to it."""

    way: Steps
    says: str
    is_usual: bool = False  # of every kind of value: makers' words are no help there


USUAL = True


class Faults(ValueError):  # noqa: N818 - several
    """What is wrong with values, each by the way to it."""

    def __init__(self, *found: Fault) -> None:
        self.found = found

    def under(self, *steps: str | int) -> Iterator[Fault]:
        """Yield the faults as they are of the value at these steps."""
        return (one._replace(way=(*steps, *one.way)) for one in self.found)


def fault(says: str) -> Faults:
    """Return the error of one value."""
    return Faults(Fault((), says))


def faults(messages: Mapping[Any, str]) -> Faults:
    """Return the errors of several values, named by their way in the mapping."""
    return Faults(*(Fault(way, says) for way, says in messages.items()))


def found_else(node: Node, expected: str) -> Faults:
    """Return the error of a value in the place of which another is expected."""
    is_number = isinstance(node.value, int | float)
    found = node.written if is_number else describe(node.value)
    return Faults(Fault((), f"found {found}, {expected}", USUAL))


def node_of(value: Any, path: str = "") -> Node:  # noqa: ANN401 - plain values
    """Return a value as a file would have it."""
    if isinstance(value, Mapping):
        known: Any = {key: node_of(one, f"{path}.{key}") for key, one in value.items()}
    elif isinstance(value, list | tuple):
        known = tuple(node_of(one, f"{path}[{k}]") for k, one in enumerate(value))
    else:
        known = value
    written = str(value) if known is value else ""
    return Node(value=known, written=written, path=path, at=START, key=START)


def check(
    document: YamlFile,
    kind: ValueKind,
    *,
    root: Node | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> Any:  # noqa: ANN401 - by the kind
    """Read a file's nodes into a mapping; `g` means `gravity` [m/s^2] in it.

    `root` stands for the file's own: a variant laid over the base.

    Raises
    ------
    SpecError
        Something is wrong with the file; every issue of it.
    """
    root = root or document.root
    found: tuple[Fault, ...] = ()
    try:
        read = kind.read(root, gravity)
    except Faults as error:
        found = error.found
    if not found and not document.issues:
        return read
    # What is no sound YAML has its issue already, and no value for a row.
    known = {(issue.line, issue.column) for issue in document.issues}
    new = [_issue(document, root, one) for one in found]
    raise all_of(
        [*document.issues, *(x for x in new if (x.line, x.column) not in known)]
    )


def _issue(document: YamlFile, root: Node, one: Fault) -> Issue:
    """Return a fault as an issue at its place in the file."""
    on_key = one.way[-1:] == (KEY,)
    steps = one.way[:-1] if on_key else one.way
    hint = "" if one.is_usual or "expected" not in one.says else see(steps)
    return document.issue(root.nearest(steps), one.says + hint, on_key=on_key)


@dataclass(frozen=True, eq=False)
class ValueKind:
    """One kind of value.

    Attributes
    ----------
    read : callable
        Returns what a node says, `g` of so much [m/s^2]; raises Faults.
    schema : callable or Schema
        JSON Schema, of those of the mappings in it, to which it may add.
    tables : tuple of KeyTable
        The mappings that stand right in it.
    allowed : tuple of str
        Words that it may be, where it is one of some.
    beside : callable, optional
        The kind that it is in a mapping, of the node of that.
    """

    read: Read = field(default=lambda *_: None)
    schema: Callable[[Schemas], Schema] | Schema = field(default_factory=dict)
    tables: tuple[KeyTable, ...] = ()
    allowed: tuple[str, ...] = ()
    beside: Callable[[Node], ValueKind] | None = None

    def described(self, tables: Schemas) -> Schema:
        """Return the JSON Schema; those of mappings go to `tables`, by their names."""
        return self.schema(tables) if callable(self.schema) else self.schema


OWN = ValueKind()  # that each of several types has


class Sign(Enum):
    """Which values a quantity may take."""

    ANY = "any"
    NOT_NEGATIVE = "not negative"
    POSITIVE = "positive"


@cache
def measured(
    like: str,
    sign: Sign = Sign.NOT_NEGATIVE,
    *,
    bare: bool = False,
    both: bool = False,
) -> ValueKind:
    """Return the kind of a text with a number and a unit, read into a Quantity.

    Parameters
    ----------
    like : str
        A unit of the quantity, the most usual one.
    sign : Sign
    bare : bool
        Whether a number without a unit means that unit to most people here.
    both : bool
        Whether it is both ends of a range: '±300 deg/s' is 300 deg/s.
    """
    kind = kind_of(like)
    number = NUMBER if sign is Sign.ANY else NUMBER.replace("[+-]", r"\+", 1)

    def read(node: Node, gravity: float) -> Quantity:
        value = node.value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            expected = f"expected {kind.name} with its unit, such as '1 {like}'"
            raise fault(f"found {describe(value)}, {expected}")
        text = str(value).removeprefix("±" if both else "")
        try:
            quantity = parse_quantity(
                text, like, gravity=gravity, bare=like if bare else ""
            )
        except UnitError as error:
            raise fault(str(error)) from None
        low = quantity.value < 0.0 or (quantity.value == 0.0 and sign is Sign.POSITIVE)
        if low and sign is not Sign.ANY:
            raise fault(f"found {value!r}, expected {kind.name} that is {sign.value}")
        return quantity

    return ValueKind(
        read,
        {
            "type": "string",
            "pattern": rf"^{'±?' * both}{number}\s*[^\s0-9.,:_+-].*$",
            "description": f"{kind.name}: a number and its unit",
            "examples": [f"1 {unit}" for unit in dict.fromkeys((like, *kind.units))],
        },
    )


TIME = measured("s", bare=True)
SPAN = measured("s", Sign.POSITIVE, bare=True)
ANGLE = measured("deg", Sign.ANY)


def one_of(
    *allowed: str, meant: Mapping[str, str] | None = None, hint: str = ""
) -> ValueKind:
    """Return the kind of some words, in any capitals, or other spellings of them.

    The hint stands after what is expected.
    """
    other = meant or {}
    by_lower = {word.lower(): word for word in allowed}

    def read(node: Node, _: float) -> str:
        word = other.get(node.written) or by_lower.get(node.written.lower())
        if word is None or isinstance(node.value, dict | tuple):
            *first, last = map(repr, allowed)
            either = f"{', '.join(first)} or {last}" if first else last
            raise found_else(
                node, f"expected {either}{slip(node.written, allowed)}{hint}"
            )
        return word

    every = [*dict.fromkeys((*allowed, *other))]
    choice = {"enum": every} if allowed[1:] else {"const": every[0]}
    return ValueKind(read, {"type": "string", **choice}, allowed=allowed)


def meaning(*allowed: str, meant: Mapping[str, str] | None = None) -> ValueKind:
    """Return the kind of what a value may mean, of which a page tells."""
    return one_of(*allowed, meant=meant, hint=f"; what makers mean: {MEANINGS}")


def number(
    least: float = -inf, most: float = inf, *, is_whole: bool = True
) -> ValueKind:
    """Return the kind of a number without a unit, within bounds; or a whole one."""
    like = "a whole number, such as 1" if is_whole else "a number, such as 1.5"

    def read(node: Node, _: float) -> float:
        value: Any = node.value
        if isinstance(value, bool) or not isinstance(
            value, int if is_whole else int | float
        ):
            raise found_else(node, f"expected {like}{mended(node)}")
        for is_wrong, expected in (
            (not isfinite(value), "a finite number"),
            (value < least, f"{least} or more"),
            (value > most, f"{most} or less"),
        ):
            if is_wrong:
                raise found_else(node, f"expected {expected}")
        return int(value) if is_whole else float(value)

    bounds = {"minimum": least, "maximum": most}
    return ValueKind(
        read,
        {
            "type": "integer" if is_whole else "number",
            **{key: one for key, one in bounds.items() if isfinite(one)},
        },
    )


def _read_truth(node: Node, _: float) -> bool:
    """Read true or false."""
    if not isinstance(node.value, bool):
        raise found_else(node, f"expected true or false{mended(node, is_truth=True)}")
    return node.value


TRUTH = ValueKind(_read_truth, {"type": "boolean"})


def text(most: int, *wrong: tuple[Callable[[str], object], str]) -> ValueKind:
    """Return the kind of a text of so many characters; what is wrong, and its words."""

    def read(node: Node, _: float) -> str:
        value = node.value
        if not isinstance(value, str):
            raise found_else(node, "expected text; put it in quotes")
        if len(value) > most:
            raise found_else(node, f"expected at most {most} characters")
        for is_wrong, says in wrong:
            if is_wrong(value):
                raise fault(says)
        return value

    return ValueKind(read, {"type": "string", "maxLength": most})


_BROKEN = re.compile(r"[\t\n\r]").search, "has a tab or a line break, expected one line"
_BLANK = re.compile(r"\s*").fullmatch, "is blank, expected text; or remove the key"
TEXT, LONG_TEXT = text(200, _BROKEN, _BLANK), text(4000, _BLANK)


def items(
    *kinds: ValueKind,
    least: int = 0,
    most: int | None = None,
    alone: bool = False,
    lacks: tuple[str, ...] = (),
    many: str = "",
) -> ValueKind:
    """Return the kind of a list of values of one kind; of several, one of each.

    Parameters
    ----------
    *kinds : ValueKind
    least, most : int
        How many; None: any number.
    alone : bool
        Whether one item may stand in the place of a list of one.
    lacks : tuple of str
        Of items that are mappings, of which a value is no item: the key that it would
        have, and what an item has to say more.
    many : str
        What is said of too many, with their {number}.
    """
    (kind, *others), fixed = kinds, len(kinds) if kinds[1:] else 0
    tables = () if others else kind.tables
    largest = fixed or most

    def read(node: Node, gravity: float) -> tuple[Any, ...]:
        value = node.value
        if lacks and isinstance(value, str | int | float) and value is not True:
            raise fault(
                f"found {describe(value)} alone, expected more beside the value: "
                f"{{{lacks[0]}: {value}, {lacks[1]}}}"
            )
        if alone and isinstance(value, dict if tables else str):
            value = (node,)
        if not isinstance(value, tuple):
            hint = bracketed(node, of_mappings=bool(tables))
            raise found_else(node, f"expected a list in brackets{hint}")
        size = f"has {len(value)} items, expected"
        if largest is not None and len(value) > largest:
            if many:
                raise fault(many.format(number=len(value)))
            raise found_else(node, f"{size} {largest} at the most")
        absent = (
            Fault((place,), f"item {place + 1} is missing, expected it here", USUAL)
            for place in range(len(value), fixed)
        )
        each = kinds if fixed else (kind,) * len(value)
        found = _read_all(
            zip(range(len(value)), each, value, strict=False), gravity, *absent
        )
        if len(value) < least:
            raise found_else(node, f"{size} {least} or more")
        return tuple(found.values())

    def schema(tables: Schemas) -> Schema:
        every = [one.described(tables) for one in kinds]
        of_list = {
            "type": "array",
            **({"prefixItems": every} if fixed else {"items": every[0]}),
            **given_of({"minItems": fixed or least or None, "maxItems": largest}),
        }
        return {"anyOf": [every[0], of_list]} if alone else of_list

    return ValueKind(read, schema, tables)


def by_name(kind: ValueKind, name: ValueKind = TEXT) -> ValueKind:
    """Return the kind of a mapping of the user's names, each to a value of one kind."""

    def read(node: Node, gravity: float) -> dict[str, Any]:
        if not isinstance(node.value, dict):
            raise found_else(node, "expected a mapping of keys")
        wrong: list[Fault] = []
        for key in node.value:
            try:
                name.read(node_of(key), gravity)
            except Faults as error:
                wrong += error.under(key, KEY)
        each = ((key, kind, one) for key, one in node.value.items())
        return _read_all(each, gravity, *wrong)

    return ValueKind(
        read,
        lambda tables: {
            "type": "object",
            "propertyNames": name.described(tables),
            "additionalProperties": kind.described(tables),
        },
        kind.tables,
    )


def _read_all(
    nodes: Iterable[tuple[Any, ValueKind, Node]], gravity: float, *wrong: Fault
) -> dict[Any, Any]:
    """Read the values in a list or a mapping; raises what is wrong with all of them."""
    found, every = {}, [*wrong]
    for step, kind, node in nodes:
        try:
            found[step] = kind.read(node, gravity)
        except Faults as error:
            every += error.under(step)
    if every:
        raise Faults(*every)
    return found


def or_else(
    kind: ValueKind,
    read: Callable[[Node, float, Read], Any],
    *others: ValueKind | Schema,
) -> ValueKind:
    """Return a kind of value with what a file may write in its place.

    It is read of a node, of gravity and of what reads the kind; `others`, for the JSON
    Schema, are what may stand there.
    """

    def schema(tables: Schemas) -> Schema:
        every = [
            one.described(tables) if isinstance(one, ValueKind) else one
            for one in (*others, kind)
        ]
        return {"anyOf": every} if others else every[0]

    return replace(
        kind, read=lambda node, gravity: read(node, gravity, kind.read), schema=schema
    )


def or_text(mapping: ValueKind, size: ValueKind, besides: str = "") -> ValueKind:
    """Allow, beside a mapping, a text that says one quantity for all of it.

    Where it has to say more besides, the text is read to say what is wrong with it.
    """

    def read(node: Node, gravity: float, own: Read) -> Any:  # noqa: ANN401 - either
        if isinstance(node.value, dict):
            return own(node, gravity)
        found = size.read(node, gravity)
        if besides:
            raise fault(
                f"found {describe(node.value)} alone, expected more beside the value: "
                f"{{value: {node.value}, {besides}}}"
            )
        return found

    return or_else(mapping, read, *(() if besides else (size,)))


def given_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is given, of a mapping of what may be."""
    return {key: value for key, value in values.items() if value is not None}


@dataclass(frozen=True, eq=False)
class KeyRow:
    """One key that a mapping may have.

    Attributes
    ----------
    kind : ValueKind
        Of its value.
    says : str
        What it means; of what stands for it where the file has none, too.
    usual : object
        What stands for it, as a file would write it; None: nothing.
    is_needed : bool
        Whether it must be there.
    """

    kind: ValueKind
    says: str = ""
    usual: object = None
    is_needed: bool = False

    @cached_property
    def default(self) -> object:
        """What stands for it, read."""
        if self.usual in (None, "", (), False):
            return self.usual
        return self.kind.read(node_of(self.usual), STANDARD_GRAVITY)

    def schema(self, tables: Schemas) -> Schema:
        """Return the JSON Schema of its value."""
        found = self.kind.described(tables)
        usual = self.usual if self.usual not in (None, "", (), {}) else None
        shown = list(usual) if isinstance(usual, tuple) else usual
        return found | given_of({"description": self.says or None, "default": shown})


Rows = Mapping[str, KeyRow]


def rows_of(
    kinds: Mapping[str, ValueKind], says: Mapping[str, str] | None = None
) -> Rows:
    """Return rows of keys that may all be left out."""
    return {key: KeyRow(kind, (says or {}).get(key, "")) for key, kind in kinds.items()}


def format_row(kind: str) -> KeyRow:
    """Return the row of the key that says which version of a file it is."""
    return KeyRow(one_of(f"budget-{kind}/1"), usual=f"budget-{kind}/1")


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

    def found(self, mapping: Keyed) -> str:
        """Return what is said of a mapping that breaks it."""
        return self.says.format_map(_Printed(mapping))


Rules = tuple[Rule, ...]


class _Printed(dict[str, object]):
    """What a mapping has under its keys, as its file prints it."""

    def __init__(self, mapping: Keyed) -> None:
        self.mapping = mapping

    def __missing__(self, key: str) -> object:
        value = getattr(self.mapping, key)
        return getattr(value, "printed", value)


class Keyed:
    """A mapping with known keys, read: an attribute of each, and which were given.

    `rows` are those of a type and of the types that it is made of, `rules` likewise: of
    one key the first that is broken counts.
    """

    rows: ClassVar[Rows] = {}
    rules: ClassVar[Rules] = ()
    every_rule: ClassVar[Rules] = ()  # before those of its bases, from the last on
    strangers: ClassVar[Mapping[str, str]] = {}  # keys of others, and what to do
    given: frozenset[str]
    if TYPE_CHECKING:

        def __getattr__(self, key: str) -> Any: ...  # noqa: ANN401, D105 - of its rows

    __slots__ = ("__dict__", "given")

    def __init_subclass__(cls) -> None:
        """Put together the rows of the types that it is made of."""
        cls.rows = {
            key: row for base in cls.__bases__[::-1] for key, row in _rows(base).items()
        } | vars(cls).get("rows", {})
        every = [vars(one).get("rules", ()) for one in cls.__mro__]
        cls.every_rule = tuple(rule for rules in every for rule in rules)[::-1]

    def __init__(self, values: Mapping[str, object], given: Iterable[str]) -> None:
        """Take the values of all rows, and the keys of those that were given."""
        vars(self).update(values)
        self.given = frozenset(given)

    @classmethod
    def of(cls, **given: object) -> Self:
        """Return one of which this is given."""
        usual = {key: row.default for key, row in cls.rows.items()}
        return cls(usual | given, given)

    def but(self, **other: object) -> Self:
        """Return another with other values."""
        return type(self)(vars(self) | other, self.given | other.keys())

    def broken(self) -> dict[Any, str]:
        """Return what is wrong with it as a whole, by the way to it."""
        broken = [rule for rule in self._rules() if rule.wrong(self)]
        found = {rule.way: rule.found(self) for rule in broken} | self._faults()
        return found or self._faults_of_whole()

    def _rules(self) -> tuple[Rule, ...]:
        """Return the rules of its type, those that count most at the end."""
        return self.every_rule

    def _faults(self) -> dict[Any, str]:
        """Return what is wrong with it besides, by its way in the mapping."""
        return {}

    def _faults_of_whole(self) -> dict[Any, str]:
        """Return what is wrong with it where nothing else is; may raise it as well."""
        return {}


def _rows(base: type) -> Rows:
    """Return the rows of a type, where it has any."""
    return base.rows if issubclass(base, Keyed) else {}


class KeyTable:
    """A mapping of one type; of other rows than its type has where they are given."""

    def __init__(
        self, record: type = Keyed, rows: Rows | None = None, title: str = ""
    ) -> None:
        self.record = record
        self.rows = {**_rows(record), **(rows or {})}
        self.title = re.sub("[^A-Za-z]+", "_", title or record.__name__)
        self.needed = [key for key, row in self.rows.items() if row.is_needed]

    def read(self, node: Node, gravity: float) -> Any:  # noqa: ANN401 - the record
        """Return the mapping; raises what is wrong with its values, else as a whole."""
        if not isinstance(node.value, dict):
            raise found_else(node, "expected a mapping of keys")
        strange = [
            Fault((key, KEY), self._unknown(key), USUAL)
            for key in node.value
            if key not in self.rows
        ]
        absent = [
            Fault((key,), f"{key!r} is missing, expected it here", USUAL)
            for key in self.needed
            if key not in node.value
        ]
        # What has no value is an issue of the document already.
        there = (
            (key, row.kind.beside(node) if row.kind.beside else row.kind, one)
            for key, one in node.value.items()
            if (row := self.rows.get(key))
            and (one.value is not None or row.usual or row.is_needed)
        )
        read = _read_all(there, gravity, *strange, *absent)
        given = dict.fromkeys(node.value) | read
        values = {key: read.get(key, row.default) for key, row in self.rows.items()}
        if not issubclass(self.record, Keyed):
            return self.record(**values)
        found = self.record(values, given)
        if wrong := found.broken():
            raise faults(wrong)
        return found

    def _unknown(self, key: str) -> str:
        """Say that there is no such key, which one may be meant, or where it is."""
        allowed = tuple(self.rows)
        owners = [
            own
            for own, row in self.rows.items()
            if any(key in one.rows for one in row.kind.tables)
        ]
        inside = f"; it stands under {owners[0]!r}" if len(owners) == 1 else ""
        strange = getattr(self.record, "strangers", {}).get(key, "")
        hint = strange or slip(key, allowed) or inside
        return f"unknown key {describe(key)}, allowed: {', '.join(allowed)}{hint}"

    def schema(self, tables: Schemas) -> Schema:
        """Return a reference to its own, which goes to the tables."""
        if self not in tables:
            same = sum(one.title == self.title for one in tables)
            own = tables[self] = {
                "title": f"{self.title}_{same + 1}" if same else self.title
            }
            own |= {
                "type": "object",
                "description": (self.record.__doc__ or "").partition("\n")[0],
                "properties": {
                    key: row.schema(tables) for key, row in self.rows.items()
                },
                "additionalProperties": False,
                "required": self.needed,
            }
        return {"$ref": f"#/$defs/{tables[self]['title']}"}


def table(record: type = Keyed, rows: Rows | None = None, title: str = "") -> ValueKind:
    """Return the kind of a mapping; as of KeyTable."""
    own = KeyTable(record, rows, title)
    return ValueKind(own.read, own.schema, (own,))


class FieldGroup(Keyed):
    """Beside a line that may be repeated, a group of lines that is, as a whole."""

    key: ClassVar[str]  # of the lines of a group
    of_all: ClassVar[tuple[str, ...]] = ()  # keys that a group says of all its lines

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
        others = self.given - {self.key, "repeat", *self.of_all}
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
            return int(super().number)  # type: ignore[misc]
        return int(self.repeat * sum(line.number for line in self.lines))


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


@cache
def per_axis(like: str, axes: tuple[str, ...], sign: Sign) -> ValueKind:
    """Return the kind of one quantity for all axes, or of a mapping of axes."""
    size = measured(like, sign)
    rows = rows_of(dict.fromkeys(axes, size))
    return or_text(table(rows=rows, title=f"by axis in {like}"), size)


def by_axis(value: Quantity | Keyed, axes: tuple[str, ...]) -> dict[str, Quantity]:
    """Return the quantity of each axis that a value names; a text names them all."""
    if isinstance(value, Quantity):
        return dict.fromkeys(axes, value)
    return given_of({axis: getattr(value, axis) for axis in axes})
