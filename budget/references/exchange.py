"""Input files key by key: what differs, and one side with a single key exchanged.

The keys of one figure of a data sheet (its value, meaning, distribution, axes, ...) say
one thing together, so they are exchanged together.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.inputs.changes import apply
from budget.inputs.device import root_of
from budget.inputs.records import CHANGED
from budget.inputs.tree import Node, YamlFile, flow, plain, put
from budget.references.difference import Alteration

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.inputs.changes import Override
    from budget.inputs.tree import Steps

LONGEST = 60  # characters of a value in a message
LONGEST_FIGURE = 160  # of a figure with several of its keys
SENSORS = ("gyro", "accelerometer")
FIGURE = 3  # steps to a figure: sensor, `errors`, line
VALUE = "value"

# Keys that by design move no number, by the kind of the file; docs/files.md lists them.
TEXTS = {
    "device": {
        *("format", "name", "source", "vendor", "technology", "price", "mass"),
        *("power", "notes", "figures", "abstract"),
    },
    "procedure": {"format", "name"},
    "station": {"format", "name"},
    "mission": {"format", "name"},
    "requirement": {"format", "name", "caps"},
    "costs": {"format"},
}
FIGURE_TEXTS = {"includes", "horizon", "condition", "source"}
RANGE = "range"  # of the device, or under a sensor
RANGE_TEXTS = {"options", "condition"}


@dataclass(frozen=True)
class Exchanged:
    """A change of the inputs, and the inputs before with it alone."""

    change: Alteration
    inputs: tuple[YamlFile, ...] | None = None  # None where it cannot be tried


@dataclass(frozen=True, kw_only=True)
class KeyChange:
    """A key whose value differs, or a figure of which several keys do."""

    steps: Steps
    before: Node | None  # None where the key is not there
    after: Node | None  # of a figure its texts stay as they are before
    keys: tuple[str, ...] = ()  # of a figure of which several differ: those

    @property
    def path(self) -> str:
        """The way to it as people read it; the `value` of a figure is the figure."""
        steps = self.steps[:-1] if self.steps[-1:] == (VALUE,) else self.steps
        text = "".join(
            f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps
        )
        return text.removeprefix(".") or "the whole file"

    @property
    def shown(self) -> tuple[str, str]:
        """Value before and after on a line each; of a figure its value and the keys."""
        if not self.keys:
            return show(self.before), show(self.after)
        keys = {VALUE, *self.keys}
        before, after = (_only(node, keys) for node in (self.before, self.after))
        return show(before, LONGEST_FIGURE), show(after, LONGEST_FIGURE)


def effective(
    document: YamlFile, variant: str, changes: Sequence[Override] = ()
) -> YamlFile:
    """Return a device file as one device: the variant over the base, changes over both.

    Figures get one shape, {value: ...}, so that a short one and a long one differ in
    their values only. The file is one that can be read (see inputs.device).
    """
    root = put(root_of(document, variant), ("abstract",), None)
    for change in changes:
        root = apply(root, change)
    for sensor in SENSORS:
        errors = root.find((sensor, "errors"))
        lines = errors.value if errors and isinstance(errors.value, dict) else {}
        for line, figure in lines.items():
            if isinstance(figure.value, str):
                long = replace(figure, value={VALUE: figure}, written="")
                root = put(root, (sensor, "errors", line), long)
    name = f"{document.base_name}#{variant}" if variant else document.base_name
    base_name = f"{name}{CHANGED}" if changes else name
    return replace(document, root=root, base_name=base_name, variant=variant)


def input_changes(
    before: Sequence[YamlFile], after: Sequence[YamlFile]
) -> tuple[Exchanged, ...]:
    """Return what differs between files, with the inputs before that have it alone.

    Files that the other side has not come first, and cannot be tried.
    """
    pairs = _pairs(before, after)
    found = [
        Exchanged(Alteration(where=own.kind, key=own.base_name, before=was, after=now))
        for side, paired, was, now in (
            (before, pairs.keys(), "there", ""),
            (after, pairs.values(), "", "there"),
        )
        for place, own in enumerate(side)
        if place not in paired
    ]
    for place, other in pairs.items():
        own, new = before[place], after[other]
        same = own.base_name == new.base_name
        where = f"{own.kind} {own.base_name}" if same else own.kind
        for key in differences(own, new):
            was, now = key.shown
            change = Alteration(
                where=where,
                key=key.path,
                before=was,
                after=now,
                is_text=is_text(own.kind, key.steps),
            )
            one = exchange(own, key) if key.steps else new
            alone = (*before[:place], one, *before[place + 1 :])
            found.append(Exchanged(change, alone))
    return tuple(found)


def differences(before: YamlFile, after: YamlFile) -> tuple[KeyChange, ...]:
    """Return every key that differs, in the order of the files.

    Several keys of one figure are one change of that figure: a meaning without the
    distribution that belongs to it is another figure than either file has.
    """
    groups: dict[Steps, list[KeyChange]] = {}
    for change in _differences(before.root, after.root, ()):
        steps = change.steps
        inside = _is_in_figure(steps) and not is_text("device", steps)
        groups.setdefault(steps[:FIGURE] if inside else steps, []).append(change)
    found: list[KeyChange] = []
    for steps, own in groups.items():
        if len(own) == 1:
            found += own
            continue
        root = before.root
        for change in own:
            root = put(root, change.steps, change.after)
        keys = tuple(dict.fromkeys(str(change.steps[FIGURE]) for change in own))
        was, now = before.root.nearest(steps), root.nearest(steps)
        found.append(KeyChange(steps=steps, before=was, after=now, keys=keys))
    return tuple(found)


def is_text(role: str, steps: Steps) -> bool:
    """Whether a key of a file of that role is one that by design moves no number."""
    return steps[:1] != () and (
        steps[0] in TEXTS[role]
        or (_is_in_figure(steps) and not FIGURE_TEXTS.isdisjoint(steps[FIGURE:]))
        or (RANGE in steps[:2] and steps[-1] in RANGE_TEXTS)
    )


def exchange(document: YamlFile, change: KeyChange) -> YamlFile:
    """Return the file before, with this one key as it is after."""
    return replace(document, root=put(document.root, change.steps, change.after))


def show(node: Node | None, longest: int = LONGEST) -> str:
    """Write a value as a file would spell it, on one line; '' for none."""
    text = "" if node is None else flow(node)
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def _pairs(before: Sequence[YamlFile], after: Sequence[YamlFile]) -> dict[int, int]:
    """Return which file is which: by role and name, a lone one of a role by role.

    Of several devices without a name in common none is the other's successor.
    """
    pairs: dict[int, int] = {}
    for place, own in enumerate(before):
        lone = all(
            sum(one.kind == own.kind for one in side) == 1 for side in (before, after)
        )
        fits = (
            k
            for k, one in enumerate(after)
            if one.kind == own.kind
            and (lone or one.base_name == own.base_name)
            and k not in pairs.values()
        )
        if (other := next(fits, None)) is not None:
            pairs[place] = other
    return pairs


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
        if (
            isinstance(a, tuple)
            and isinstance(b, tuple)
            and len(a) == len(b)
            and all(isinstance(one.value, dict) for one in (*a, *b))
        ):  # as many mappings; a list of words is one value
            for place, (one, other) in enumerate(zip(a, b, strict=True)):
                yield from _differences(one, other, (*steps, place))
            return
        if plain(before) == plain(after):
            return
    yield KeyChange(steps=steps, before=before, after=after)


def _is_in_figure(steps: Steps) -> bool:
    """Whether a key is one of a figure of a data sheet."""
    return len(steps) > FIGURE and steps[0] in SENSORS and steps[1] == "errors"


def _only(node: Node | None, keys: set[str]) -> Node | None:
    """Return a figure with these keys alone, in its short form where it has one."""
    if node is None or not isinstance(node.value, dict):
        return node
    own = {key: child for key, child in node.value.items() if key in keys}
    return own[VALUE] if set(own) == {VALUE} else replace(node, value=own)
