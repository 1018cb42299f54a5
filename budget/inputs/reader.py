"""Read a YAML 1.2 file strictly: bytes in, nodes with positions and issues out."""

from __future__ import annotations

import os
import re
import sys
from functools import lru_cache
from hashlib import sha256
from math import isfinite
from typing import TYPE_CHECKING, TextIO

from budget.errors import Issue, SpecError
from budget.inputs.composer import BREAK, UNSAFE, compose, forbid
from budget.inputs.tree import START, Location, YamlFile
from budget.journal import note_read

if TYPE_CHECKING:
    from pathlib import Path

# A device file has 2 KiB.
MOST_BYTES = 64 * 1024
ODD = re.compile("[^0-9eE.+ \t,\r-]")  # what a row of numbers has not
INPUT = "standard input"  # its name in messages and results


def read(path: Path, shown: str, content: bytes | None = None) -> YamlFile:
    """Read one file, which messages name `shown`: its nodes, and its lesser issues.

    What it holds may be known already: then nothing is read from the disk.

    Duplicate keys, empty values, aliases, anchors and tags do not stop the reading.

    Raises
    ------
    SpecError
        The file cannot be read on: missing, too large, no UTF-8, no YAML.
    """
    data = read_bytes(path, shown) if content is None else content
    # In any locale the characters of the name, not what stands for its bytes.
    base_name = os.fsencode(path.name).decode("utf-8", errors="replace")
    return parse(data, shown, base_name=base_name)


def read_stdin() -> bytes:
    """Return what is on standard input, the same whenever a run asks for it.

    Raises
    ------
    SpecError
        It cannot be read.
    """
    if sys.stdin is None:
        raise refuse(INPUT, "is closed, expected a YAML file on it")
    return _read_stream(sys.stdin)


@lru_cache(maxsize=1)
def _read_stream(stream: TextIO) -> bytes:
    """Return what is on a stream, never much more than a file may hold."""
    try:
        return stream.buffer.read(MOST_BYTES + 1)
    except OSError as error:
        reason = error.strerror or str(error)
        raise refuse(
            INPUT, f"cannot be read ({reason}), expected a YAML file"
        ) from None


# A run names a file more than once: as a device, in the catalogue, in a reference. All
# that ships fits in, and more: a catalogue read in order would drive itself out.
@lru_cache(maxsize=512)
def parse(data: bytes, shown: str, *, base_name: str) -> YamlFile:
    """Read the bytes of a file; as `read`, also before there is a file."""
    if len(data) > MOST_BYTES:
        raise refuse(shown, f"is larger than {MOST_BYTES} bytes, the most allowed")
    root, issues = compose(_decode(data, shown), shown)
    return YamlFile(
        file=shown,
        base_name=base_name,
        sha256=sha256(data).hexdigest(),
        root=root,
        issues=tuple(issues),
        text=data.decode(),  # with its byte order mark, if it has one
    )


def is_number(cell: str) -> bool:
    """Whether a cell of a table is a finite number, in digits."""
    try:
        return not ODD.search(cell) and bool(isfinite(float(cell)))
    except ValueError:
        return False


def refuse(shown: str, message: str, mark: Location = START) -> SpecError:
    """Return the error that a file as a whole is refused with."""
    issue = Issue(
        file=shown, line=mark.line, column=mark.column, field="", message=message
    )
    return SpecError((issue,))


def read_bytes(
    path: Path, shown: str, *, most: int = MOST_BYTES, what: str = "a YAML file"
) -> bytes:
    """Return what is in a file, never much more than it may hold.

    Raises
    ------
    SpecError
        It cannot be read.
    """
    try:
        with path.open("rb") as stream:
            note_read(path)
            return stream.read(most + 1)
    except IsADirectoryError:
        raise refuse(shown, f"is a folder, expected {what}") from None
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise refuse(shown, f"cannot be read ({reason}), expected {what}") from None


def _decode(data: bytes, shown: str) -> str:
    """Return the text of the file, without a byte order mark at its start."""
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8-sig", errors="ignore")
        message = f"byte 0x{data[error.start]:02x} is not UTF-8; save the file as UTF-8"
        raise refuse(shown, message, _mark_after(before)) from None
    if not text.strip():
        raise refuse(shown, "the file is empty, expected a mapping of keys")
    unsafe = UNSAFE.search(text)
    if unsafe:
        raise refuse(shown, forbid(unsafe[0]), _mark_after(text[: unsafe.start()]))
    directive = re.search("^%", text, re.MULTILINE)
    if directive:
        message = "a line starts with '%', a YAML directive; remove it or indent it"
        raise refuse(shown, message, _mark_after(text[: directive.start()]))
    return text


def _mark_after(text: str) -> Location:
    """Return the place that follows a text."""
    lines = BREAK.split(text)
    return Location(len(lines), len(lines[-1]) + 1)
