"""A budget for other programs: JSON of schema budget/1, and CSV, at full precision."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from itertools import chain
from json.encoder import encode_basestring as quoted
from math import isfinite
from typing import TYPE_CHECKING, Any

from budget.documents import FORMS, document

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from budget.results import Budget


def to_json(budget: Budget, extras: Mapping[str, Any] | None = None) -> str:
    """Write the JSON document of a budget, with those of other studies by their keys.

    Raises
    ------
    ValueError
        A number is not finite: JSON has none, and a budget must have none.
    """
    return json_text({**budget.to_dict(), **(extras or {})})


def json_text(found: Mapping[str, Any]) -> str:
    """Write a document at full precision. Raises ValueError as to_json."""
    return "".join(json_pieces(found))


def json_pieces(found: Mapping[str, Any]) -> Iterator[str]:
    """Yield the text of a document, of what an iterator gives one after another.

    Thousands of devices as one nest of dicts, and as what that is encoded to, take ten
    times the room of their text. Raises ValueError as to_json.
    """
    start = "{\n "
    for key, value in found.items():
        yield f"{start}{quoted(key)}: "
        start = ",\n "
        if not isinstance(value, Iterator):
            yield _encoded(value, "\n ")
            continue
        empty = "[]"
        for one in value:
            yield ("[\n  " if empty else ",\n  ") + _encoded(one, "\n  ")
            empty = ""
        yield empty or "\n ]"
    yield "\n}\n"


def _encoded(value: Any, line: str) -> str:  # noqa: ANN401 - any part of a document
    """Write a part of a document, its lines after `line`: as `json` does with indents.

    That knows them in Python alone, at three times the time.
    """
    if isinstance(value, str):
        return quoted(value)
    if value is None or isinstance(value, bool | int):
        return json.dumps(value)
    if isinstance(value, float):
        if not isfinite(value):
            raise ValueError(f"{value!r} is no number that JSON has")
        return float.__repr__(value)
    deeper = f"{line} "
    if isinstance(value, Mapping):
        own = [f"{quoted(key)}: {_encoded(one, deeper)}" for key, one in value.items()]
        first, last = "{}"
    else:
        own = [_encoded(one, deeper) for one in value]
        first, last = "[]"
    between = f",{deeper}"
    return f"{first}{deeper}{between.join(own)}{line}{last}" if own else first + last


def json_of(record: object, form: str) -> str:
    """Write what a form says of a record. Raises ValueError as to_json."""
    return json_text(document(record, form))


def to_csv(budget: Budget) -> str:
    """Write one row for each output and source and one `total`, in printed units."""
    return csv_text(budget.columns, budget.rows())


def table_csv(name: str, records: Iterable[object]) -> str:
    """Write one row for each record, as the form of that name has columns."""
    columns = FORMS[name].columns
    rows = (
        {head: _below(one, keys) for head, keys in columns.items()}
        for one in (document(each, name) for each in records)
    )
    return csv_text([*columns], rows)


def _below(found: Any, keys: Sequence[str]) -> Any:  # noqa: ANN401 - of a document
    """Return what stands under some keys, of a list its items one after another."""
    for key in keys:
        found = found and found[key]
    return ", ".join(found) if isinstance(found, list) else found


FORMULA = ("=", "+", "-", "@", "\t")  # what a spreadsheet takes for a formula


def csv_text(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """Write what `csv_pieces` yields."""
    return "".join(csv_pieces(columns, rows))


def csv_pieces(
    columns: Sequence[str], rows: Iterable[Mapping[str, Any]]
) -> Iterator[str]:
    r"""Yield these columns of rows under a line of heads, LF at the end of each.

    Numbers have all their digits; None, and what a row lacks, is nothing. A text that
    a spreadsheet would take for a formula has an apostrophe before it; a number has
    not, negative ones neither. A carriage return is written as \r.
    """
    cells = ([_cell(row.get(name)) for name in columns] for row in rows)
    for line in chain([columns], cells):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerow(line)
        yield text.getvalue()


def _cell(value: str | float | None) -> str:
    """Write one cell."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        text = value.replace("\r", "\\r")  # which the writer would not quote
        return f"'{text}" if text.startswith(FORMULA) and not _is_number(text) else text
    return str(value) if isinstance(value, int) else repr(float(value))


def _is_number(text: str) -> bool:
    """Whether a text is a number, as the printed ones of the paper are."""
    try:
        float(text)
    except ValueError:
        return False
    return True
