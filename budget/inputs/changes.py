"""Changes of a device on a call: SENSOR.LINE=VALUE, laid over the file as a variant is.

What a change says goes through the same model as the file, so it is read by the same
rules and refused in the same words.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.errors import CallError, Issue, UnitError
from budget.inputs.checking import nearest
from budget.inputs.composer import UNSAFE, compose, forbid
from budget.inputs.tree import Node, all_of, describe, merge
from budget.model.sources import ACCELEROMETER, GYRO, SENSORS, lines_of
from budget.names import ANGLES, AXES, Name, keys_of, words
from budget.sentences import sentence
from budget.units import parse_quantity, per_root_hertz

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.inputs.files import NamedFile

# Keys beside a value that tell of the old one alone. The others say how it is meant: a
# new value is meant likewise.
_OF_THE_OLD = {"source", "condition", "includes"}
_SIZES = {"value", "axes"}
_NOMINAL = {"bias": AXES, "mounting_angle": ANGLES}
_ABSENT = "not given"
RANGE = "range"  # of a triad: it stands beside the sensors in a file
_LONGEST = 1000  # characters of a change
_EXAMPLE = "gyro.bias_stability='0.02 deg/h'"


@dataclass(frozen=True, kw_only=True)
class Change:
    """One value that is another one than in the file.

    Attributes
    ----------
    text : str
        As it was given.
    device : str
        The device that it is of, as FILE, FILE#VARIANT or #VARIANT; '' of all.
    sensor, place, line : str
        'gyro', 'errors', 'nominal' or 'range', and the key under it, '' of a range.
    inside : tuple of str
        Keys below that, an axis among them; () of the line as a whole.
    node : Node
        The new value.
    """

    text: str
    device: str
    sensor: str
    place: str
    line: str
    inside: tuple[str, ...]
    node: Node

    @property
    def address(self) -> Name:
        """What is changed, as results name it."""
        if self.place == "errors":
            return Name(self.line, owner=self.sensor)
        if self.place == RANGE:
            return Name(RANGE, owner=self.sensor)
        return Name(self.place, owner=self.sensor, axis=self.line)

    @property
    def path(self) -> tuple[str, ...]:
        """Where it stands in a device file."""
        if self.place == RANGE:
            return (RANGE, self.sensor)
        return (self.sensor, self.place, self.line)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes of the line; () of one that is not known."""
        if self.place == RANGE:
            return AXES
        if self.place == "nominal":
            return _NOMINAL.get(self.line, ())
        known = {line.name: line.axes for line in lines_of(self.sensor)}
        return known.get(self.line, ())

    def is_of(self, file: NamedFile, variant: str, root: Node) -> bool:
        """Whether a device has that sensor, and is the one that is named, if any is."""
        if root.child(self.sensor) is None:
            return False
        names = {file.shown, file.path.name, file.path.stem}
        marked = {f"{name}#{variant}" for name in (*names, "")} if variant else set()
        return not self.device or self.device in names | marked


Changes = Mapping[str, object] | Sequence[str]


def texts_of(changes: Changes) -> tuple[str, ...]:
    """Write changes as SENSOR.LINE=VALUE, of a mapping {SENSOR.LINE: VALUE}.

    Raises
    ------
    CallError
        They are neither a mapping nor texts.
    """
    if isinstance(changes, str):  # one change, not a sequence of letters
        return (changes,)
    if isinstance(changes, Mapping):
        return tuple(f"{line}={_value(value)}" for line, value in changes.items())
    if not isinstance(changes, Sequence) or any(
        not isinstance(one, str) for one in changes
    ):
        raise CallError(
            f"changes are {changes!r:.60}, expected a dict of values by specification, "
            "as {'gyro.bias_stability': '0.02 deg/h'}"
        )
    return tuple(changes)


def _value(value: object) -> str:
    """Write the value of a change as a file would have it on one line."""
    if isinstance(value, str):
        return value
    try:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise CallError(
            f"changes: {error}; a value is a text, a number, or a list or dict of them"
        ) from None


def read_change(text: str) -> Change:
    """Read SENSOR.LINE=VALUE, with an axis or a key after the line.

    Raises
    ------
    CallError
        The text is no such thing, or names no sensor.
    SpecError
        The value is no YAML.
    """
    if len(text) > _LONGEST:
        raise CallError(
            f"--set: found {len(text)} characters, {_LONGEST} are allowed; write a "
            "device file with what is other"
        )
    if unsafe := UNSAFE.search(text):
        raise CallError(f"--set: {forbid(unsafe[0])}")
    address, sign, value = text.partition("=")
    device, _, path = address.strip().rpartition(":")
    if not sign or not value.strip():
        raise CallError(
            f"--set: found {text!r}, expected SENSOR.SPEC=VALUE, as {_EXAMPLE}"
        )
    sensor, *keys = keys_of(path.strip())
    if sensor not in SENSORS or not keys or not all(keys):
        known = tuple(
            Name(line.name, owner=owner)
            for owner in SENSORS
            for line in lines_of(owner)
        )
        every = (*known, *(name.without_owner for name in known))
        raise CallError(
            f"--set: {path.strip()!r} is no specification of a sensor, expected "
            f"SENSOR.SPEC with {' or '.join(SENSORS)}, as "
            f"{_EXAMPLE}{_whose(path.strip(), every)}"
        )
    place = keys.pop(0) if keys[0] in {"errors", "nominal"} and keys[1:] else "errors"
    line, *inside = keys
    if line == RANGE:
        place, line = RANGE, ""
    label = f"--set {path.strip()}"
    node, issues = compose(value.strip(), label)
    if issues:
        raise all_of(issues)
    at = (RANGE, sensor) if place == RANGE else (sensor, place, line)
    return Change(
        text=text,
        device=device,
        sensor=sensor,
        place=place,
        line=line,
        inside=tuple(inside),
        node=_labelled(node, label, ".".join(filter(None, (*at, *inside)))),
    )


def _whose(path: str, known: tuple[str, ...]) -> str:
    """Return a hint at the line that a text is a slip of."""
    hint = nearest(path, known)
    owners = [
        owner
        for owner in SENSORS
        if path == RANGE or path in {one.name for one in lines_of(owner)}
    ]
    if owners:
        names = " or ".join(repr(str(Name(path, owner=owner))) for owner in owners)
        return f"; did you mean {names}?"
    return hint


def _labelled(node: Node, label: str, path: str) -> Node:
    """Return a node that says where it is from, and stands at that path."""
    value = node.value
    if isinstance(value, dict):
        value = {
            key: _labelled(child, label, f"{path}.{key}")
            for key, child in value.items()
        }
    elif isinstance(value, tuple):
        value = tuple(
            _labelled(child, label, f"{path}[{place}]")
            for place, child in enumerate(value)
        )
    return replace(node, value=value, path=path, file=label)


def apply(root: Node, change: Change) -> Node:
    """Lay a change over the nodes of a device."""
    over = change.node
    base = _at(root, change)
    if isinstance(over.value, tuple) and change.axes and not change.inside:
        over = _by_axis(over, change)
    if change.place == "errors":
        over = _line(base, over, change)
    elif change.inside:
        over = _by_key(base, over, change)
    if change.place == RANGE:
        root = _with_ranges(root)
    for key in reversed(change.path):
        over = replace(change.node, value={key: over}, path="")
    return _replaced(root, over, depth=len(change.path))


def _with_ranges(root: Node) -> Node:
    """Return a device whose range, where it is a text, stands by its sensor."""
    node = root.child(RANGE)
    if (
        node is None
        or not isinstance(node.value, str)
        or not isinstance(root.value, dict)
    ):
        return root
    try:
        parse_quantity(node.value.removeprefix("±"), "deg/s")
        sensor = GYRO
    except UnitError:
        sensor = ACCELEROMETER
    ranges = replace(node, value={sensor: node})
    return replace(root, value={**root.value, RANGE: ranges})


def _at(root: Node, change: Change) -> Node | None:
    """Return what stands there now."""
    node: Node | None = _with_ranges(root) if change.place == RANGE else root
    for key in change.path:
        node = None if node is None else node.child(key)
    return node


def _by_axis(over: Node, change: Change) -> Node:
    """Turn a list of values into a mapping of axes.

    Raises
    ------
    SpecError
        There are more or fewer than axes.
    """
    items = over.value if isinstance(over.value, tuple) else ()
    if len(items) != len(change.axes):
        message = (
            f"found a list of {len(items)}, expected {len(change.axes)} values: "
            f"{', '.join(change.axes)}"
        )
        raise all_of(
            [
                Issue(
                    file=over.file,
                    line=over.at.line,
                    column=over.at.column,
                    field=over.path,
                    message=message,
                )
            ]
        )
    axes = replace(over, value=dict(zip(change.axes, items, strict=True)))
    return replace(over, value={"axes": axes}) if change.place == "errors" else axes


def _line(base: Node | None, over: Node, change: Change) -> Node:
    """Return a line with the change in it, and with no word of the old source."""
    known: dict[str, Node] = {}
    if base is not None:
        known = base.value if isinstance(base.value, dict) else {"value": base}
    lasting = {key: one for key, one in known.items() if key not in _OF_THE_OLD}
    if "meaning" in lasting and lasting["meaning"].value == "exact":
        del lasting["meaning"]  # of the old 0
    sizes = {key: one for key, one in lasting.items() if key in _SIZES}
    kept = {key: one for key, one in lasting.items() if key not in _SIZES}
    if change.inside:
        first, *rest = change.inside
        if first in change.axes:
            first, rest = "axes", list(change.inside)
        for key in reversed(rest):
            over = replace(over, value={key: over})
        line = replace(over, value={**sizes, **kept})
        new = merge(line, replace(over, value={first: over}), short=True)
    elif isinstance(over.value, dict):
        if over.value.keys() & _SIZES:
            sizes = {}
        new = replace(over, value={**sizes, **kept, **over.value})
    else:
        new = replace(over, value={**kept, "value": over})
    fields = dict(new.value) if isinstance(new.value, dict) else {}
    if "density" in fields and not per_root_hertz(_shown(new)):
        del fields["density"]
    told = replace(change.node, value="--set", written="--set")
    return replace(new, value={"source": told, **fields})


def _by_key(base: Node | None, over: Node, change: Change) -> Node:
    """Return nominal values, or a range, with that of one axis changed."""
    known: dict[str, Node] = {}
    if base is not None and isinstance(base.value, dict):
        known = {key: one for key, one in base.value.items() if key != "condition"}
    elif base is not None:
        known = dict.fromkeys(change.axes, base)
    (axis, *_) = change.inside
    return replace(over, value={**known, axis: over})


def _replaced(base: Node, over: Node, *, depth: int) -> Node:
    """Lay one path over another; what stands at its end is replaced."""
    if depth == 0 or not isinstance(base.value, dict):
        return over
    merged = dict(base.value)
    for key, child in over.value.items() if isinstance(over.value, dict) else ():
        known = merged.get(key)
        merged[key] = (
            child if known is None else _replaced(known, child, depth=depth - 1)
        )
    return replace(base, value=merged)


@written(
    "changed_line",
    """
    line = address
    from = old: what the file says, '(not there)' where it does not
    to = new
    """,
)
@dataclass(frozen=True, kw_only=True)
class Changed(Documented):
    """What became of a change: a provenance, not what a file says."""

    texts: tuple[str, ...]  # as it was given; the last one counts
    address: Name
    old: str  # _ABSENT where the file has none
    new: str

    @property
    def said(self) -> str:
        """The change in words, as one of the assumptions."""
        return sentence(
            "assumed.changed",
            address=self.address,
            new=self.new,
            old=None if self.old == _ABSENT else self.old,
        )


def tell_changes(
    before: Node, after: Node, changes: Iterable[Change]
) -> tuple[Changed, ...]:
    """Say what each change changed."""
    told: dict[Name, Changed] = {}
    for change in changes:
        old, new = _at(before, change), _at(after, change)
        earlier = told.get(change.address)
        told[change.address] = Changed(
            texts=(*(earlier.texts if earlier else ()), change.text),
            address=change.address,
            old=_ABSENT if old is None else _shown(old),
            new=_ABSENT if new is None else _shown(new),
        )
    return tuple(told.values())


def _shown(node: Node) -> str:
    """Write a value with what moves its number, on one line."""
    if isinstance(node.value, dict):
        own = {
            key: _shown(child)
            for key, child in node.value.items()
            if key not in _OF_THE_OLD
        }
        sizes = [own.pop(key) for key in ("value", "axes") if key in own]
        inner = ", ".join(f"{words(key)} {text}" for key, text in own.items())
        if not sizes:
            return inner
        return ", ".join(sizes) + (f" ({inner})" if inner else "")
    if isinstance(node.value, tuple):
        return ", ".join(map(_shown, node.value))
    return node.written or describe(node.value)


def check_used(changes: Sequence[Change], used: Iterable[str]) -> None:
    """Refuse a change that reaches none of the devices.

    Raises
    ------
    CallError
        No device that was given is called so, or has that sensor.
    """
    left = {change.text: change for change in changes}
    for text in used:
        left.pop(text, None)
    for change in left.values():
        whose = f" called {change.device!r}" if change.device else ""
        raise CallError(
            f"--set {change.text}: no device here{whose} has "
            f"{'an' if change.sensor[0] in 'aeiou' else 'a'} {change.sensor}; give one "
            "that has, or leave this change out"
        )
