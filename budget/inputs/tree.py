"""YAML as a tree: nodes with their places, overlaid, and written again."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from budget.errors import Issue, SpecError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

Steps = tuple[str | int, ...]  # keys, and places in lists
# Of a mapping as it is written, in its order: a comment, or a key with its value.
Entries = Any  # Iterable[str | tuple[str, str | Entries]]
LONGEST_SHOWN = 80  # characters of a text in a message
MOST_ISSUES = 100  # that one error says: more help nobody, and cost time
# What stands without quotes, and is no number, truth or nothing to a reader of YAML.
_PLAIN = re.compile(
    r"(?!(?:[\d.eE+-]+|true|false|null)$)"
    r"(?:[\w.][^:#,\[\]{}\n]*[^:#,\[\]{}\s]|\w)"
)


@dataclass(frozen=True, order=True)
class Location:
    """A line and a column of a file."""

    line: int  # from 1
    column: int  # from 1


START = Location(1, 1)


@dataclass(frozen=True, kw_only=True)
class Node:
    """A value in a file."""

    # None where the file has something that is no value (nothing, or an alias); that is
    # an issue of the document already.
    value: str | float | bool | tuple[Node, ...] | dict[str, Node] | None
    written: str = ""  # a scalar as the file spells it; '' for the others
    path: str  # dotted path in the file
    # Where the value starts, and its key; the same where it has none.
    at: Location
    key: Location
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

    def find(self, steps: Sequence[str | int]) -> Node | None:
        """Return the node at the end of those steps, or None where there is none."""
        node: Node | None = self
        for step in steps:
            node = node and node.child(step)
        return node


@dataclass(frozen=True, kw_only=True)
class YamlFile:
    """One file, read: what it says and what is wrong with it as YAML."""

    file: str  # as the user gave it
    base_name: str
    sha256: str
    root: Node
    issues: tuple[Issue, ...]
    kind: str = ""  # 'device', ..., once its keys have said so
    text: str = ""  # of the bytes that `sha256` is of
    variant: str = ""  # of a device whose root it is laid over

    @property
    def stem(self) -> str:
        """The name of what it holds, where it says none."""
        return self.base_name.partition(".")[0]

    def issue(self, node: Node, message: str, *, on_key: bool = False) -> Issue:
        """Return an issue with that node."""
        return issue_at(node, message, self.file, on_key=on_key)

    def refuse(
        self, *found: tuple[Node | Steps, str], on_key: bool = False
    ) -> SpecError:
        """Return the error that says what is wrong at nodes, or at the end of steps."""
        new = (
            self.issue(
                at if isinstance(at, Node) else self.root.nearest(at),
                message,
                on_key=on_key,
            )
            for at, message in found
        )
        return all_of([*self.issues, *new])


def issue_at(
    node: Node, message: str, file: str = "", *, on_key: bool = False
) -> Issue:
    """Return an issue with a node, of that file where the node names none."""
    at = node.key if on_key else node.at
    return Issue(
        file=node.file or file,
        line=at.line,
        column=at.column,
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
    """Lay one node over another, key by key; every part keeps its own place.

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


def put(node: Node | None, steps: Sequence[str | int], new: Node | None) -> Node:
    """Lay a node over what is at the end of the steps; None takes that away.

    Mappings that are not there yet on the way are where the new node is.
    """
    if not steps:
        return cast("Node", new)
    (step, *rest) = steps
    if node and isinstance(node.value, tuple) and isinstance(step, int):
        items = list(node.value)
        items[step] = put(items[step], rest, new)
        return replace(node, value=tuple(items))
    keys = {**node.value} if node and isinstance(node.value, dict) else {}
    if new is None and not rest:
        keys.pop(str(step), None)
    else:
        keys[str(step)] = put(keys.get(str(step)), rest, new)
    if node and isinstance(node.value, dict):
        return replace(node, value=keys)
    return replace(cast("Node", new or node), value=keys, written="", path="")


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


def block(entries: Entries, indent: str = "") -> Iterator[str]:
    """Write keys below one another, each value after its key or, of several, below."""
    for entry in entries:
        if isinstance(entry, str):
            yield f"{indent}# {entry}".rstrip()
            continue
        key, value = entry
        if isinstance(value, str):
            yield f"{indent}{key}: {value}".rstrip()
        else:
            yield f"{indent}{key}:"
            yield from block(value, f"{indent}  ")


def flow(value: object, text: Callable[[Any], str] = str) -> str:
    """Write a value on one line, a node as its file spells it.

    `text` writes keys and scalars: as they stand, or `quoted`, which is JSON.
    """
    if isinstance(value, Node):
        is_scalar = not isinstance(value.value, dict | tuple)
        value = " ".join(value.written.split()) if is_scalar else value.value
    if isinstance(value, Mapping):
        pairs = (f"{text(key)}: {flow(one, text)}" for key, one in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(flow(one, text) for one in value)}]"
    return text(value)


def visible(text: str) -> str:
    """Write what cannot be seen as escapes."""
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in text)


def quoted(value: object) -> str:
    """Quote a text as YAML 1.2 and JSON both do; raises as `json.dumps`."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def scalar(text: str) -> str:
    """Write a text without quotes where YAML reads it as the same text."""
    return text if _PLAIN.fullmatch(text) else quoted(text)
