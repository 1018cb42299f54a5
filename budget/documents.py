"""Documents of records: rows say what stands under which key, one writer writes them.

A form is one kind of object in documents, and has a row for each key. From its rows its
JSON and CSV are written, and its JSON Schema and docs/documents.md are made. They stand
above the record that they are of. A row begins with its key, and has of what follows
what it needs, in this order; lines that are indented deeper belong to it:

    key? = path / size by path or null if path as form not in CSV (type) [unit]: meaning

- `?`: left out where there is none, or nothing in it;
- `= path`: where the record has it, if not under the key: attributes, with dots between
  them, all None of None, and of a tuple those of its items; a number is a place in a
  tuple, None beyond its end; `self` is the record, a text in quotation marks itself.
  What a form is given to read goes before attributes;
- `/ unit`: SI in the record, and in documents in the unit that stands beside it: over
  the `si_per_unit` of the record, of its output, or of what it is part of. Other sizes
  are paths, to divide by, or with `*` to multiply by;
- `by path`: of a list in the record an object, by what each item has there;
- `or null`: null where it is an empty text, or infinite;
- `if path`, `unless path`: left out where there is nothing, or something;
- `as form`: the form of it or of its items, where that is not the one of their type;
- `not in CSV`: no column in a table of these;
- `(type)`: where the record does not say it or has another, of which it is then made:
  `bool`, `str`, `list[str]`, `dict[str, str]`;
- `[unit]`: that of the number in documents.

A row that begins with `*` has the keys of what is there, null where that is None.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isinf
from textwrap import dedent
from typing import Any, TypeVar

T = TypeVar("T")
Row = re.Match[str]
Read = Callable[[Any], Any]
SCHEMA = "budget/1"
UNIT = "unit"
ROW = re.compile(
    r"(?P<spliced>\*)?(?P<key>[\w.]+)(?P<maybe>\?)?"
    r"( = (?P<path>'[^']*'|[\w.]+))?"
    r"(?P<sizes>( [/*] [\w.]+)*)"
    r"( by (?P<by>\w+))?"
    r"(?P<null> or null)?"
    r"( (?P<when>if|unless) (?P<given>[\w.]+))?"
    r"( as (?P<form>\w+))?"
    r"(?P<aside> not in CSV)?"
    r"( \((?P<type>[^)]+)\))?"
    r"( \[(?P<unit>[^]]+)\])?"
    r"(: (?P<meaning>.+))?"
)
READS: Mapping[str, Read] = {"self": lambda record: record, "None": lambda _: None}
MADE: Mapping[str, Read] = {
    "bool": bool,
    "str": str,
    "list[str]": lambda found: [str(one) for one in found],
    "dict[str, str]": dict,
}


@dataclass(frozen=True, kw_only=True)
class Form:
    """One kind of object in documents.

    Attributes
    ----------
    name : str
        As the JSON Schema calls it.
    text : str
        Its rows.
    record : type
        What it is written from.
    said : str
        What it is, in one line.
    commands : str
        Those that write it, of a whole document; '' of a part.
    reads : mapping of str to callable
        What is read of a record that it does not have itself, by its name in paths.
    """

    name: str
    text: str
    record: type
    said: str
    commands: str
    reads: Mapping[str, Read]

    @cached_property
    def rows(self) -> tuple[Row, ...]:
        """Its rows.

        Raises
        ------
        ValueError
            One is none.
        """
        lines = re.sub(r"\n +", " ", dedent(self.text).strip()).splitlines()
        if self.commands:
            words = self.commands.split()
            only = "" if len(words) > 1 else f" = '{words[0]}'"
            head = (f"schema = '{SCHEMA}'", f"command{only} (Literal{words})")
            lines = [*head, *lines]
        found = [ROW.fullmatch(line) for line in lines]
        if None in found:
            line = lines[found.index(None)]
            raise ValueError(f"form {self.name}: found {line!r}, expected a row")
        return tuple(filter(None, found))

    @cached_property
    def columns(self) -> dict[str, list[str]]:
        """Heads of a table of these, each with the keys down to what stands below it.

        What is called `value` stands under what it is the value of.
        """
        found: dict[str, list[str]] = {}
        for row in self.rows:
            key = row["key"]
            inside = FORMS[row["form"]].columns if row["form"] else {"value": []}
            above = [] if row["spliced"] else [key]
            if not row["aside"]:
                found |= {
                    key if head == "value" else head: [*above, *below]
                    for head, below in inside.items()
                }
        return found

    def read(self, record: Any, path: str) -> Any:  # noqa: ANN401 - any record
        """Return what is at a path of a record."""
        if path.startswith("'"):
            return path[1:-1]
        first, *rest = path.split(".")
        read = self.reads.get(first) or READS.get(first)
        value = read(record) if read else step_into(record, first)
        for step in rest:
            value = step_into(value, step)
        return value

    def entries(self, record: Any, size: float = 1.0) -> Iterator[tuple[str, Any]]:  # noqa: ANN401 - as above
        """Yield the keys of a record with what stands there; of an iterator another.

        `size` is that of the unit of what the record is part of.
        """
        size = getattr(getattr(record, "output", record), "si_per_unit", size)
        for row in self.rows:
            if row["when"]:
                given = bool(self.read(record, row["given"]))
                if given != (row["when"] == "if"):
                    continue
            value = self.read(record, row["path"] or row["key"])
            if row["maybe"] and _is_nothing(value):
                continue
            if row["spliced"]:
                yield from form_of(value, row["form"]).entries(value, size)
            else:
                yield row["key"], self._written(record, row, value, size)

    def _written(self, record: Any, row: Row, value: Any, size: float) -> Any:  # noqa: ANN401 - as above
        """Return what documents have in the place of a value."""
        if value is None:
            return None
        steps = row["sizes"].split()
        for sign, path in zip(steps[::2], steps[1::2], strict=True):
            by = size if path == UNIT else self.read(record, path)
            value = _times(value, sign, by)
        if row["by"]:
            value = {getattr(one, row["by"]): one for one in value}
        if row["null"] and (value == "" or (isinstance(value, float) and isinf(value))):
            return None
        make = MADE.get(row["type"] or "")
        return _plain(make(value) if make else value, row["form"], size)


FORMS: dict[str, Form] = {}  # by their names
BY_TYPE: dict[type, Form] = {}  # of records that are written so where nothing is said


def written(
    name: str, text: str, /, *, said: str = "", commands: str = "", **reads: Read
) -> Callable[[type[T]], type[T]]:
    """Give a record a form; of several the one that stands first is that of its type.

    Without words it is what the record is in one line.
    """

    def give(record: type[T]) -> type[T]:
        own = (record.__doc__ or "").partition("\n")[0].replace(" [SI]", "")
        BY_TYPE[record] = FORMS[name] = Form(
            name=name,
            text=text,
            record=record,
            said=said or own,
            commands=commands,
            reads=reads,
        )
        return record

    return give


def form_of(record: object, name: str | None = None) -> Form:
    """Return the form of that name, else the one of the type of a record."""
    return FORMS[name] if name else BY_TYPE[type(record)]


def document(record: object, name: str = "", *, size: float = 1.0) -> dict[str, Any]:
    """Return what documents say of a record, in printed units."""
    return {
        key: list(value) if isinstance(value, Iterator) else value
        for key, value in form_of(record, name).entries(record, size)
    }


class Documented:
    """A record that has a form."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        return document(self)


def step_into(value: Any, step: str) -> Any:  # noqa: ANN401 - any record
    """Return what is one step of a path further."""
    if value is None:
        return None
    if isinstance(value, Mapping):
        return value.get(step)
    if not isinstance(value, tuple):
        return getattr(value, step)
    if not step.isdecimal():
        return [getattr(one, step) for one in value]
    return value[int(step)] if int(step) < len(value) else None


def said_of(row: Row) -> str:
    """Return what a row says of its key in words, with its unit."""
    unit = row["unit"] or (UNIT if f"/ {UNIT}" in row["sizes"] else "")
    return " ".join(filter(None, (row["meaning"], unit and f"[{unit}]")))


def _is_nothing(value: Any) -> bool:  # noqa: ANN401 - as above
    """Say whether there is no value, or nothing in it."""
    return value is None or (hasattr(value, "__len__") and len(value) == 0)


def _times(value: Any, sign: str, size: Any) -> Any:  # noqa: ANN401 - as above
    """Return a number, or several, over or times a size."""
    if isinstance(value, tuple):
        return [_times(one, sign, size) for one in value]
    return value * size if sign == "*" else value / size


def _plain(value: Any, name: str | None, size: float) -> Any:  # noqa: ANN401 - as above
    """Return a value as JSON has it: lists of tuples and arrays, objects of records."""
    if isinstance(value, Mapping):
        return {key: _plain(one, name, size) for key, one in value.items()}
    if isinstance(value, tuple | list | Iterator):
        found = (
            document(one, name, size=size) if name else _plain(one, None, size)
            for one in value
        )
        return found if isinstance(value, Iterator) else list(found)
    if name or type(value) in BY_TYPE:
        return document(value, name or "", size=size)
    return value.tolist() if hasattr(value, "tolist") else value
