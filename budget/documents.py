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
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from math import isinf
from textwrap import dedent
from typing import Any, TypeVar

from budget import views

T = TypeVar("T")
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
ATOMS = (str, float, int)


class FormRow:
    """What a form says of one key, ready to write it."""

    def __init__(self, said: re.Match[str], reads: Mapping[str, Read]) -> None:
        self.said = said
        self.key, self.form = said["key"], said["form"]
        self.is_maybe, self.is_spliced = bool(said["maybe"]), bool(said["spliced"])
        self.path = said["path"] or self.key
        self.get = _reader(self.path, reads)
        self.given = _reader(said["given"], reads) if said["given"] else None
        steps = said["sizes"].split()
        self.sizes = [
            (sign, None if path == UNIT else _reader(path, reads))
            for sign, path in zip(steps[::2], steps[1::2], strict=True)
        ]
        made = [
            said["by"] and partial(_by, key=said["by"]),
            said["null"] and _unless_null,
            MADE.get(said["type"] or ""),
        ]
        self.made = [one for one in made if one]

    def put(self, found: dict[str, Any], record: Any, size: float) -> None:  # noqa: ANN401 - any record
        """Put what stands under the key into a document, of an iterator another."""
        if self.given and bool(self.given(record)) != (self.said["when"] == "if"):
            return
        value = self.get(record)
        if self.is_maybe and _is_nothing(value):
            return
        if self.is_spliced:
            form_of(value, self.form).put(found, value, size)
            return
        for sign, read in self.sizes if value is not None else ():
            value = _times(value, sign, size if read is None else read(record))
        for make in self.made if value is not None else ():
            value = make(value)
        is_atom = value is None or isinstance(value, ATOMS)
        found[self.key] = value if is_atom else _plain(value, self.form, size)

    @property
    def meaning(self) -> str:
        """What it says of the key in words, with its unit."""
        unit = self.said["unit"] or (UNIT if f"/ {UNIT}" in self.said["sizes"] else "")
        return " ".join(filter(None, (self.said["meaning"], unit and f"[{unit}]")))


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
    def rows(self) -> tuple[FormRow, ...]:
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
        return tuple(FormRow(one, self.reads) for one in found if one is not None)

    @cached_property
    def columns(self) -> dict[str, list[str]]:
        """Heads of a table of these, each with the keys down to what stands below it.

        What is called `value` stands under what it is the value of.
        """
        found: dict[str, list[str]] = {}
        for row in self.rows:
            inside = FORMS[row.form].columns if row.form else {"value": []}
            above = [] if row.is_spliced else [row.key]
            if not row.said["aside"]:
                found |= {
                    row.key if head == "value" else head: [*above, *below]
                    for head, below in inside.items()
                }
        return found

    def put(self, found: dict[str, Any], record: Any, size: float = 1.0) -> None:  # noqa: ANN401 - as above
        """Put the keys of a record into a document.

        `size` is that of the unit of what it is part of.
        """
        size = getattr(getattr(record, "output", record), "si_per_unit", size)
        for row in self.rows:
            row.put(found, record, size)


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


def document(
    record: object, name: str | None = None, *, size: float = 1.0
) -> dict[str, Any]:
    """Return what documents say of a record, in printed units."""
    found: dict[str, Any] = {}
    form_of(record, name).put(found, record, size)
    return found


class Shown:
    """A record that prints as a short table, in a notebook too.

    Numbers are rounded as in a report, in printed units.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        """Return that table as text, and how much there is beyond it."""
        text: str = views.view().shown_text(self)
        return text

    def _repr_html_(self) -> str:
        """Return the same in HTML."""
        html: str = views.view().shown_html(self)
        return html


class Documented:
    """A record that has a form."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Return what documents say of it, in printed units."""
        return {
            key: list(value) if isinstance(value, Iterator) else value
            for key, value in document(self).items()
        }


def _reader(path: str, reads: Mapping[str, Read]) -> Read:
    """Return what reads a path of a record."""
    if path.startswith("'"):
        return lambda _: path[1:-1]
    first, *rest = path.split(".")
    begin = reads.get(first) or READS.get(first) or partial(_step, step=first)
    if not rest:
        return begin
    return lambda record: reduce(_step, rest, begin(record))


def _step(value: Any, step: str) -> Any:  # noqa: ANN401 - any record
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


def _is_nothing(value: Any) -> bool:  # noqa: ANN401 - as above
    """Say whether there is no value, or nothing in it."""
    return value is None or (hasattr(value, "__len__") and len(value) == 0)


def _times(value: Any, sign: str, size: Any) -> Any:  # noqa: ANN401 - as above
    """Return a number, or several, over or times a size."""
    if isinstance(value, tuple | list):
        return [_times(one, sign, size) for one in value]
    return value * size if sign == "*" else value / size


def _by(found: Iterable[Any], key: str) -> dict[str, Any]:
    """Return records by what they have there."""
    return {getattr(one, key): one for one in found}


def _unless_null(value: Any) -> Any:  # noqa: ANN401 - as above
    """Return None of an empty text and of what is infinite."""
    is_none = value == "" or (isinstance(value, float) and isinf(value))
    return None if is_none else value


def _plain(value: Any, name: str | None, size: float) -> Any:  # noqa: ANN401 - as above
    """Return a value as JSON has it: lists of tuples and arrays, objects of records."""
    if isinstance(value, ATOMS):
        return value
    if isinstance(value, Mapping):
        return {key: _plain(one, name, size) for key, one in value.items()}
    if isinstance(value, Sequence | Iterator):
        found = (
            document(one, name, size=size) if name else _plain(one, None, size)
            for one in value
        )
        return list(found) if isinstance(value, tuple | list) else found
    if name or type(value) in BY_TYPE:
        return document(value, name, size=size)
    return value.tolist() if hasattr(value, "tolist") else value
