"""YAML nodes with their positions, before they mean anything."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.errors import Issue, SpecError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence


@dataclass(frozen=True, order=True)
class Mark:
    """A place in a file."""

    line: int  # from 1
    column: int  # from 1


START = Mark(1, 1)
LONGEST_SHOWN = 80  # characters of a text in a message
MOST_ISSUES = 100  # that one error says: more help nobody, and cost time


@dataclass(frozen=True, kw_only=True)
class Node:
    """A value in a file."""

    # None where the file has something that is no value (nothing, or an alias); that is
    # an issue of the document already.
    value: str | float | bool | tuple[Node, ...] | dict[str, Node] | None
    written: str = ""  # a scalar as the file spells it; '' for the others
    path: str  # dotted path in the file
    # Where the value starts, and its key; the same where it has none.
    at: Mark
    key: Mark
    file: str = ""  # that it is from, where it is not that of the document

    def child(self, step: str | int) -> Node | None:
        """Return the node under that key or index, or None where there is none."""
        if isinstance(self.value, dict):
            return self.value.get(str(step))
        if isinstance(self.value, tuple) and isinstance(step, int):
            return self.value[step] if step < len(self.value) else None
        return None

    def nearest(self, steps: Sequence[str | int]) -> Node:
        """Return the deepest node there is on the way of those steps.

        A mapping that stands for a sequence of one is its own first item.
        """
        node = self
        for step in steps:
            if step == 0 and isinstance(node.value, dict):
                continue
            child = node.child(step)
            if child is None:
                break
            node = child
        return node


@dataclass(frozen=True, kw_only=True)
class Document:
    """One file, read: what it says and what is wrong with it as YAML."""

    file: str  # as the user gave it
    base_name: str
    sha256: str
    root: Node
    issues: tuple[Issue, ...]
    kind: str = ""  # 'device', ..., once its keys have said so
    text: str = ""  # of the bytes that `sha256` is of

    def issue(self, node: Node, message: str, *, on_key: bool = False) -> Issue:
        """Return an issue with that node."""
        mark = node.key if on_key else node.at
        return Issue(
            file=node.file or self.file,
            line=mark.line,
            column=mark.column,
            field=node.path,
            message=message,
        )


def all_of(issues: Iterable[Issue]) -> SpecError:
    """Return the error that says all issues, each once, in the order of the file."""
    found = sorted(dict.fromkeys(issues), key=lambda i: (i.line, i.column))
    if len(found) > MOST_ISSUES:
        message = "more issues follow; mend the ones above first"
        found[MOST_ISSUES:] = [replace(found[MOST_ISSUES], field="", message=message)]
    return SpecError(tuple(found))


def plain(node: Node, words: Mapping[int, str] | None = None) -> object:
    """Return the values alone: dicts, tuples and scalars.

    `words` stand for the values of some nodes, by their id().
    """
    if isinstance(node.value, dict):
        return {key: plain(child, words) for key, child in node.value.items()}
    if isinstance(node.value, tuple):
        return tuple(plain(item, words) for item in node.value)
    return words.get(id(node), node.value) if words else node.value


def merge(base: Node, over: Node, *, short: bool = False) -> Node:
    """Lay one node over another, key by key; every part keeps its own position.

    Only two mappings merge; else `over` replaces `base`. Under `errors`, where `short`,
    a string is short for {value: string}.
    """
    below = base.value
    if short and isinstance(below, str):
        below = {"value": base}
    if not isinstance(below, dict) or not isinstance(over.value, dict):
        return over
    merged = dict(below)
    for key, child in over.value.items():
        known = merged.get(key)
        inside = short or key == "errors"
        merged[key] = child if known is None else merge(known, child, short=inside)
    return replace(base, value=merged)


def describe(value: object) -> str:
    """Say what a value is, on one line, as a person sees it in the file."""
    if isinstance(value, dict):
        return "a mapping of keys"
    if isinstance(value, tuple):
        return "a list"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return repr(
            value if len(value) <= LONGEST_SHOWN else f"{value[:LONGEST_SHOWN]}..."
        )
    return str(value)
