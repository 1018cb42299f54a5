"""The file of a reference budget: its format, its reader, its text.

Format 1 is JSON, one number a line, with a checksum over its content. A later format
gets a model of its own and a step that turns the older one into it; the first file ever
written stays in the tests.
"""

from __future__ import annotations

import json
import platform
import re
from collections import Counter
from dataclasses import fields
from pathlib import PurePosixPath, PureWindowsPath
from typing import TYPE_CHECKING, Any

from budget.errors import ReferenceFileError
from budget.inputs.fields import KEY, Faults, node_of, one_of, table
from budget.inputs.reader import MOST_BYTES as LONGEST_INPUT
from budget.inputs.schema import schema_of
from budget.journal import note_read
from budget.references.files import digest
from budget.references.records import (
    REFERENCE,
    RESULT,
    SHA256,
    STORED,
    ReferenceBudget,
    files_fault,
    needed,
)
from budget.settings import fills
from budget.units import STANDARD_GRAVITY
from budget.version import __version__

if TYPE_CHECKING:
    from pathlib import Path

    from budget.references.records import Stored

FORMAT = "budget-reference/1"
NEWEST = 1
MOST_BYTES = 8 * 1024 * 1024  # forty times the largest that ships
WRITER = "`budget check --save`"
RESTORE = "restore it from version control, or save it again"
SHOWN = 3  # faults that one message says


def reference_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a reference budget."""
    # The checksum: SHA-256 of all the rest, as JSON with sorted keys and no spaces.
    own = {"format": needed(one_of(FORMAT)), "checksum": needed(SHA256)}
    return schema_of(table(ReferenceBudget, REFERENCE | own), "budget reference file")


def present_versions() -> dict[str, str]:
    """Return what computes here: the tool, Python, numpy, scipy."""
    import numpy as np
    import scipy

    return {
        "budget": __version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "scipy": scipy.__version__,
    }


def reference_text(reference: ReferenceBudget) -> str:
    """Write a reference: the same reference gives the same text.

    Raises
    ------
    ValueError
        A number is not finite.
    """
    content: dict[str, Any] = {
        **_fields(reference),
        "format": FORMAT,
        "inputs": [
            _set(_fields(one)) | {"text": one.text.split("\n")}
            for one in reference.inputs
        ],
        "settings": _settings(reference.settings),
        "numbers": [_set(_fields(one)) for one in reference.numbers],
        "words": [{"text": one.text, **_set(_fields(one))} for one in reference.words],
        "known": sorted(reference.known),
    }
    content = json.loads(json.dumps(content, allow_nan=False))  # lists for tuples
    content["checksum"] = _checksum(content)
    lines = []
    for key in sorted(content):
        value = content[key]
        if isinstance(value, list):
            rows = ",\n".join(f"  {_line(row)}" for row in value)
            shown = f"[\n{rows}\n ]" if value else "[]"
        else:
            shown = _line(value)
        lines.append(f" {_line(key)}: {shown}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def read_reference(path: Path, shown: str) -> ReferenceBudget:
    """Read a reference of this format or an older one, `shown` in messages.

    Raises
    ------
    ReferenceFileError
        It cannot be read, is none, is cut short, was edited, or is of a newer format.
    """
    try:
        with path.open("rb") as stream:
            note_read(path)
            data = stream.read(MOST_BYTES + 1)
    except IsADirectoryError:
        raise ReferenceFileError(f"{shown}: is a folder, expected a file") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        reason = getattr(error, "strerror", None) or error
        raise _no_reference(shown, f"cannot be read ({reason})") from None
    return parse_reference(data, shown)


def parse_reference(data: bytes, shown: str) -> ReferenceBudget:
    """Read a reference from its bytes; raises as read_reference.

    Also before a new one is written: what could not be read back is not worth a file.
    """
    if len(data) > MOST_BYTES:
        raise ReferenceFileError(
            f"{shown}: is larger than {MOST_BYTES} bytes, the most a reference budget "
            "may have; save one for fewer devices"
        )
    content = _parse(data, shown)
    _check_format(content, shown)
    if content.get("checksum") != _checksum(content):
        raise ReferenceFileError(
            f"{shown}: its content is not what was written (the checksum differs); a "
            f"reference is written by {WRITER}, not by hand: {RESTORE}"
        )
    del content["format"], content["checksum"]
    try:
        own = table(ReferenceBudget, REFERENCE)
        found: ReferenceBudget = own.read(node_of(content), STANDARD_GRAVITY)
    except Faults as error:
        raise ReferenceFileError(_said(error, shown)) from None
    if fault := _content_fault(found):
        raise ReferenceFileError(f"{shown}: {fault}; save the reference again")
    return found


def _content_fault(reference: ReferenceBudget) -> str:
    """Say what no single value shows; '' where all is well."""
    for one in reference.inputs:
        if PurePosixPath(one.file).is_absolute() or PureWindowsPath(one.file).anchor:
            return (
                f"the input {one.file} has an absolute path, expected one from the "
                "folder of the reference"
            )
        if one.role != RESULT and len(one.text) > LONGEST_INPUT:
            return (
                f"the stored {one.file} is larger than {LONGEST_INPUT} bytes, the most "
                "that an input may have"
            )
        if digest(one.text) != one.sha256:
            return f"the stored {one.file} has not the SHA-256 that stands beside it"
    if fault := files_fault(reference.job, [one.role for one in reference.inputs]):
        return f"inputs: {fault}"
    for kind, stated in (("numbers", reference.numbers), ("words", reference.words)):
        for item, times in Counter(one.item for one in stated).items():
            if times > 1:
                return f"{kind}: {item} stands there {times} times, expected once"
    return ""


def _parse(data: bytes, shown: str) -> dict[str, Any]:
    """Parse JSON without nan and infinity."""
    text = ""
    try:
        text = data.decode()
        content = json.loads(text, parse_constant=_refuse_constant)
        # What is nested too deeply, or has half a character, fails here.
        json.dumps(content, ensure_ascii=False).encode()
    except UnicodeDecodeError as error:
        raise _no_reference(shown, f"byte {error.start} is not UTF-8") from None
    except json.JSONDecodeError as error:
        what = f"is no JSON here: {error.msg.lower()}"
        if error.pos >= len(text.rstrip()):
            what = "ends too early, it was cut short"
        raise _no_reference(f"{shown}:{error.lineno}:{error.colno}", what) from None
    except (ValueError, RecursionError) as error:
        reason = "nested too deeply" if isinstance(error, RecursionError) else error
        what = f"is no JSON of a reference budget ({reason})"
        raise _no_reference(shown, what) from None
    if not isinstance(content, dict) or "format" not in content:
        raise _no_reference(shown, "has no `format` key")
    return content


def _no_reference(where: str, what: str) -> ReferenceFileError:
    """Return the error for what is no reference, with what to do."""
    return ReferenceFileError(
        f"{where}: {what}; expected a reference budget ({FORMAT}), as {WRITER} writes "
        f"it: {RESTORE}"
    )


def _check_format(content: dict[str, Any], shown: str) -> None:
    """Refuse another format, and a newer one."""
    found = content["format"]
    name = found if isinstance(found, str) else "no text"
    version = re.fullmatch("budget-reference/([1-9][0-9]{0,8})", name)
    if version is None:
        raise ReferenceFileError(
            f"{shown}: format is {name[:80]!a}, expected {FORMAT!r}; give a file "
            f"that {WRITER} wrote"
        )
    if int(version[1]) > NEWEST:
        # Format n comes with version n of this program.
        raise ReferenceFileError(
            f"{shown}: format is {found!r}, which needs budget >= {version[1]}; this "
            f"is budget {__version__}: update it, or save the reference again with it"
        )


def _checksum(content: dict[str, Any]) -> str:
    """Return the SHA-256 of all but the checksum, in one spelling."""
    rest = {key: value for key, value in content.items() if key != "checksum"}
    return digest(json.dumps(rest, sort_keys=True, separators=(",", ":")))


def _said(error: Faults, shown: str) -> str:
    """Say what is wrong with the first values, and what to do."""
    lines = [
        f"{shown}: {'.'.join(str(step)[:40] for step in one.way if step != KEY)}: "
        f"{one.says}"
        for one in error.found[:SHOWN]
    ]
    if len(error.found) > SHOWN:
        lines.append(f"{shown}: and {len(error.found) - SHOWN} more")
    lines[-1] += "; save the reference again"
    return "\n".join(lines)


def _fields(record: Any) -> dict[str, Any]:  # noqa: ANN401 - any dataclass
    """Return a flat record by field; `asdict` copies every text."""
    return {one.name: getattr(record, one.name) for one in fields(record)}


def _settings(stored: Stored) -> dict[str, Any]:
    """Return the settings that there are; what fills in only where something does."""
    found = _set({name: getattr(stored, name) for name in STORED})
    return (
        found if fills(stored) else {k: v for k, v in found.items() if k != "missing"}
    )


def _set(values: dict[str, Any]) -> dict[str, Any]:
    """Leave out what is None, False or empty; 0 is a seed."""
    return {k: v for k, v in values.items() if v or (v == 0 and v is not False)}


def _line(value: object) -> str:
    """Write JSON on one line."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False, allow_nan=False)


def _refuse_constant(name: str) -> float:
    """Refuse NaN and Infinity, which are no JSON."""
    raise ValueError(f"found {name}")
