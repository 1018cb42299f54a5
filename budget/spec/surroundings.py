"""What a file says of the table and the room: the sources that no sensor owns."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

from budget.model.sources import lines_of
from budget.names import Name, keys_of
from budget.spec.fields import mapping_of
from budget.spec.figures import figure_type, take

if TYPE_CHECKING:
    from budget.model.source import Source
    from budget.spec.fields import Strict
    from budget.spec.figures import Taken


@cache
def surroundings_type(owner: str) -> Any:  # noqa: ANN401
    """Return the type of the mapping of that owner, nested as its names are dotted."""
    tree: dict[str, Any] = {}
    for source in lines_of(owner):
        *folders, last = keys_of(source.name)
        branch = tree
        for folder in folders:
            branch = branch.setdefault(folder, {})
        branch[last] = source
    return _mapping(owner, owner, tree)


def take_surroundings(owner: str, mapping: Strict | None) -> tuple[Taken, ...]:
    """Return the sources that a mapping of that owner names, in the table's order."""
    taken = []
    for source in lines_of(owner):
        figure: Any = mapping
        for key in keys_of(source.name):
            figure = getattr(figure, key, None)
        if figure is not None:
            taken.append(take(source, owner, figure))
    return tuple(taken)


def describe_surroundings(owner: str, taken: tuple[Taken, ...]) -> tuple[str, ...]:
    """Say which figures of that owner count, with the words that stand beside them."""
    return tuple(
        f"{Name(line.name, owner=owner)}: {line.printed}, "
        + ", ".join(word for word in words if word)
        for line in (one.line for one in taken)
        for words in [
            (line.meaning, line.includes, line.horizon, line.condition, line.source)
        ]
    )


def _mapping(title: str, owner: str, tree: dict[str, Any]) -> Any:  # noqa: ANN401
    """Return the type of one level of the mapping."""
    fields: dict[str, Any] = {}
    meanings: dict[str, str] = {}
    for key, branch in tree.items():
        if isinstance(branch, dict):
            fields[key] = _mapping(f"{title} {key}", owner, branch)
        else:
            source: Source = branch
            fields[key], meanings[key] = figure_type(source, owner), source.model
    return mapping_of(title, fields, meanings)
