"""Journal of one run of the command line: files read and written.

So that no output takes the place of an input, and that a run which is ended says what
stands. It is kept in the context of the run, as reader and writer, floors apart, know
nothing of each other; a program that uses the library keeps none.
"""

from __future__ import annotations

import os
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path


@dataclass(frozen=True)
class Journal:
    """Files read, by device and inode and by their path without links; and written."""

    read: set[tuple[int, int] | str] = field(default_factory=set)
    written: list[str] = field(default_factory=list)


_present: ContextVar[Journal | None] = ContextVar("journal", default=None)


@contextmanager
def keep_journal() -> Iterator[Journal]:
    """Keep a journal until the block ends."""
    journal = Journal()
    token = _present.set(journal)
    try:
        yield journal
    finally:
        _present.reset(token)


def is_kept() -> bool:
    """Whether this is a run of the command line."""
    return _present.get() is not None


def note_read(path: Path) -> None:
    """Note a file that is an input; one that is not there is none."""
    journal = _present.get()
    if journal is not None:
        journal.read.update(_identities(path))


def note_written(paths: Iterable[Path]) -> None:
    """Note files that stand complete."""
    journal = _present.get()
    if journal is not None:
        journal.written.extend(map(str, paths))


def is_input(path: Path) -> bool:
    """Whether a file was read in this run, by whatever name or hard link."""
    journal = _present.get()
    return journal is not None and not journal.read.isdisjoint(_identities(path))


def _identities(path: Path) -> set[tuple[int, int] | str]:
    """Return what tells the file of a path: itself, and where it lies."""
    try:
        found = path.stat()
        return {(found.st_dev, found.st_ino), os.path.realpath(path)}
    except (OSError, ValueError):  # ValueError: a null byte in the name
        return set()
