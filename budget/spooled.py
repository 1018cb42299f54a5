"""Sequences of more records than memory has room for: read from a file, one at a time.

A record that is read back is another object than the one that was given, and what is
asked for twice is made twice: `held` makes a tuple of what is short.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from tempfile import TemporaryFile
from typing import Generic, TypeVar, overload
from weakref import finalize

from budget.errors import BudgetError

S = TypeVar("S")
T = TypeVar("T")

IN_MEMORY = 2048  # records of a list that stay there, some 15 kB each


class Lazy(Sequence[T]):
    """A sequence whose items are made when they are asked for."""

    def _make(self, place: int) -> T:
        """Return the item at that place, from 0 on."""
        raise NotImplementedError

    @overload
    def __getitem__(self, place: int) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[T]: ...
    def __getitem__(self, place: int | slice) -> T | Sequence[T]:
        """Return an item, or those of a slice, made when they are asked for."""
        found = range(len(self))[place]
        return self._make(found) if isinstance(found, int) else Made(self._make, found)

    def held(self) -> Sequence[T]:
        """Return a tuple of them, or this where there are many."""
        return tuple(self) if len(self) <= IN_MEMORY else self


@dataclass(frozen=True, eq=False)
class Made(Lazy[T], Generic[S, T]):
    """What a function makes of each item of another sequence."""

    make: Callable[[S], T]
    items: Sequence[S]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.items)

    def _make(self, place: int) -> T:
        return self.make(self.items[place])


def chained(parts: Iterable[Sequence[T]]) -> Sequence[T]:
    """Return the items of several sequences as one."""
    every = [*parts]
    places = [(part, k) for part in every for k in range(len(part))]
    return Made(lambda place: place[0][place[1]], places).held()


class SpooledList(Lazy[T]):
    """A list whose first items are in memory, the others in a file without a name.

    Raises
    ------
    BudgetError
        The folder for temporary files has no room.
    """

    def __init__(self, items: Iterable[T] = ()) -> None:
        """Begin with some items."""
        self._first: list[T] = []
        self._ends = [0]  # of the others in the file
        self.extend(items)

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._first) + len(self._ends) - 1

    def append(self, item: T) -> None:
        """Add an item; beyond the first ones it must be one that can be pickled."""
        if len(self._ends) == 1 and len(self._first) < IN_MEMORY:
            self._first.append(item)
            return
        try:
            if len(self._ends) == 1:
                self._file = TemporaryFile()  # noqa: SIM115 - closed with this
                finalize(self, self._file.close)
            self._file.seek(self._ends[-1])
            self._file.write(pickle.dumps(item, pickle.HIGHEST_PROTOCOL))
            self._file.flush()
        except OSError as error:
            raise BudgetError(
                f"no room for temporary files ({error.strerror}), which hold what "
                "memory does not; give TMPDIR a folder with some 20 kB for each device"
            ) from error
        self._ends.append(self._file.tell())

    def extend(self, items: Iterable[T]) -> None:
        """Add items."""
        for one in items:
            self.append(one)

    def _make(self, place: int) -> T:
        if place < len(self._first):
            return self._first[place]
        later = place - len(self._first)
        start, end = self._ends[later : later + 2]
        self._file.seek(start)
        found: T = pickle.loads(self._file.read(end - start))  # noqa: S301 - our own
        return found
