"""Find the references that a user names, or all that ship."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from budget.errors import ReferenceFileError
from budget.resources import shipped
from budget.spec.checking import nearest
from budget.studies.reference.parts import is_there

if TYPE_CHECKING:
    from collections.abc import Sequence

FOLDER = "references"
SUFFIX = ".json"


@dataclass(frozen=True, kw_only=True)
class FoundReference:
    """A reference file and how it is called."""

    path: Path
    shown: str


def shipped_references() -> tuple[FoundReference, ...]:
    """Return the references that ship, by name."""
    return tuple(
        FoundReference(path=path, shown=path.stem)
        for path in sorted((shipped("specs") / FOLDER).glob(f"*{SUFFIX}"))
    )


def find_references(names: Sequence[str]) -> tuple[FoundReference, ...]:
    """Find references by file, by folder or by bare name; all that ship without one.

    Raises
    ------
    ReferenceFileError
        A name is of none, or a folder has none.
    """
    if not names:
        return shipped_references()
    found: dict[Path, FoundReference] = {}
    for name in names:
        for one in _find(name):
            found.setdefault(one.path, one)
    return tuple(found.values())


def _find(name: str) -> tuple[FoundReference, ...]:
    """Find what one name stands for."""
    path = Path(name)
    if is_there(path, folder=True):
        inside = tuple(
            FoundReference(path=one, shown=str(one))
            for one in sorted(path.glob(f"*{SUFFIX}"))
        )
        if not inside:
            raise ReferenceFileError(
                f"{name}: has no {SUFFIX} file, expected a folder with references; "
                "store one with `budget check --save`"
            )
        return inside
    if is_there(path, folder=False):
        return (FoundReference(path=path, shown=name),)
    there = shipped_references()
    bare = name.removesuffix(SUFFIX)
    by_name = tuple(one for one in there if one.shown == bare)
    if by_name:
        return by_name
    known = tuple(one.shown for one in there)
    raise ReferenceFileError(
        f"{name}: no such file, expected a reference budget, a folder of them, or a "
        f"shipped one: {', '.join(known) or 'none'}{nearest(bare, known)}"
    )
