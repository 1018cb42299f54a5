"""Two files key by key: what differs, and one of them with a single key exchanged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.spec.tree import Document, Node, merge, plain

if TYPE_CHECKING:
    from collections.abc import Iterator

LONGEST = 60  # characters of a value in a message
Steps = tuple[str | int, ...]


@dataclass(frozen=True, kw_only=True)
class KeyChange:
    """A key whose value differs.

    Attributes
    ----------
    steps : tuple of str or int
        The way to it.
    before, after : Node or None
        None where the key is not there.
    """

    steps: Steps
    before: Node | None
    after: Node | None

    @property
    def path(self) -> str:
        """The way to it as people read it; the `value` of a figure is the figure."""
        steps = self.steps[:-1] if self.steps[-1:] == ("value",) else self.steps
        text = ""
        for step in steps:
            text += f"[{step}]" if isinstance(step, int) else f".{step}"
        return text.removeprefix(".") or "the whole file"


def effective(document: Document, variant: str) -> Document:
    """Return a device file as one device: the variant over the base.

    Figures get one shape, {value: ...}, so that a short one and a long one differ in
    their values only. The file is one that can be read (see spec.device).
    """
    keys = document.root.value
    if not isinstance(keys, dict):
        return document
    base = {k: v for k, v in keys.items() if k not in {"variants", "abstract"}}
    root = replace(document.root, value=base)
    variants = document.root.child("variants")
    over = variants.child(variant) if variants and variant else None
    if over is not None:
        root = merge(root, over)
    return replace(
        document,
        root=_long_figures(root),
        base_name=f"{document.base_name}#{variant}" if variant else document.base_name,
    )


def differences(before: Document, after: Document) -> tuple[KeyChange, ...]:
    """Return every key that differs, in the order of the files."""
    return tuple(_differences(before.root, after.root, ()))


def exchange(document: Document, change: KeyChange) -> Document:
    """Return the file before, with this one key as it is after."""
    return replace(document, root=_put(document.root, change.steps, change.after))


def show(node: Node | None) -> str:
    """Write a value as a file would spell it, on one line; '' for none."""
    text = "" if node is None else _flow(node)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _long_figures(root: Node) -> Node:
    """Write every figure under `errors` as a mapping."""
    for sensor in ("gyro", "accelerometer"):
        errors = (root.child(sensor) or root).child("errors")
        if errors is None or not isinstance(errors.value, dict):
            continue
        for line, figure in errors.value.items():
            if isinstance(figure.value, str):
                long = replace(figure, value={"value": figure}, written="")
                root = _put(root, (sensor, "errors", line), long)
    return root


def _differences(
    before: Node | None, after: Node | None, steps: Steps
) -> Iterator[KeyChange]:
    """Yield the differences of two nodes at the same place."""
    if before is not None and after is not None:
        a, b = before.value, after.value
        if isinstance(a, dict) and isinstance(b, dict):
            for key in dict.fromkeys((*a, *b)):
                yield from _differences(a.get(key), b.get(key), (*steps, key))
            return
        if isinstance(a, tuple) and isinstance(b, tuple) and _are_records(a, b):
            for place, (one, other) in enumerate(zip(a, b, strict=True)):
                yield from _differences(one, other, (*steps, place))
            return
        if plain(before) == plain(after):
            return
    yield KeyChange(steps=steps, before=before, after=after)


def _are_records(a: tuple[Node, ...], b: tuple[Node, ...]) -> bool:
    """Whether two lists hold as many mappings; a list of words is one value."""
    return len(a) == len(b) and all(isinstance(item.value, dict) for item in (*a, *b))


def _put(node: Node, steps: Steps, new: Node | None) -> Node:
    """Return a node with another one at the end of the steps; None takes it away."""
    if not steps:
        return node if new is None else new
    step, rest = steps[0], steps[1:]
    if isinstance(node.value, tuple) and isinstance(step, int):
        items = list(node.value)
        items[step] = _put(items[step], rest, new)
        return replace(node, value=tuple(items))
    keys = dict(node.value) if isinstance(node.value, dict) else {}
    name = str(step)
    if rest:
        keys[name] = _put(keys[name], rest, new)
    elif new is None:
        keys.pop(name, None)
    else:
        keys[name] = new
    return replace(node, value=keys)


def _flow(node: Node) -> str:
    """Write a node in YAML's flow style."""
    if isinstance(node.value, dict):
        inside = ", ".join(f"{k}: {_flow(child)}" for k, child in node.value.items())
        return f"{{{inside}}}"
    if isinstance(node.value, tuple):
        return f"[{', '.join(_flow(item) for item in node.value)}]"
    return " ".join(node.written.split())
