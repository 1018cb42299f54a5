"""Changes of a device on a call: SENSOR.LINE=VALUE, laid over the file as a variant is.

What a change says goes through the same model as the file, so it is read by the same
rules and refused in the same words.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.errors import CallError, UnitError
from budget.inputs.checking import nearest
from budget.inputs.composer import UNSAFE, compose, forbid
from budget.inputs.tree import (
    Node,
    all_of,
    describe,
    flow,
    issue_at,
    merge,
    put,
    quoted,
)
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
NOMINAL = {"bias": AXES, "mounting_angle": ANGLES}
_ABSENT = "not given"
EXACT = "exact"  # meaning of a 0 that is meant, and no line that nobody gives
RANGE = "range"  # of a triad: it stands beside the sensors in a file
_LONGEST = 1000  # characters of a change
_EXAMPLE = "gyro.bias_stability='0.02 deg/h'"


@dataclass(frozen=True, kw_only=True)
class Override:
    """One value that is another one than in the file.

    Attributes
    ----------
    text : str
        As it was given.
    device : str
        The device that it is of, as FILE, FILE#VARIANT or #VARIANT; '' of all.
    address : Name
        What is changed, as results name it.
    path : tuple of str
        Where it stands in a device file: sensor, 'errors' or 'nominal', and the key
        under it; or 'range' and the sensor.
    axes : tuple of str
        Of the line; () of one that is not known.
    inside : tuple of str
        Keys below that, an axis among them; () of the line as a whole.
    node : Node
        The new value.
    """

    text: str
    device: str
    address: Name
    path: tuple[str, ...]
    axes: tuple[str, ...]
    inside: tuple[str, ...]
    node: Node

    def is_of(self, file: NamedFile, variant: str, root: Node) -> bool:
        """Whether a device has that sensor, and is the one that is named, if any is."""
        if root.child(self.address.owner) is None:
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
    try:
        return value if isinstance(value, str) else flow(value, quoted)
    except (TypeError, ValueError, RecursionError) as error:
        raise CallError(
            f"changes: {error}; a value is a text, a number, or a list or dict of them"
        ) from None


def read_change(text: str) -> Override:
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
        names = [
            Name(x.name, owner=owner) for owner in SENSORS for x in lines_of(owner)
        ]
        every = (*names, *(name.without_owner for name in names))
        raise CallError(
            f"--set: {path.strip()!r} is no specification of a sensor, expected "
            f"SENSOR.SPEC with {' or '.join(SENSORS)}, as "
            f"{_EXAMPLE}{_whose(path.strip(), every)}"
        )
    place = keys.pop(0) if keys[0] in {"errors", "nominal"} and keys[1:] else "errors"
    line, *inside = keys
    where: tuple[str, ...] = (sensor, place, line)
    known = {one.name: one.axes for one in lines_of(sensor)}
    if line == RANGE:
        place, where, known = RANGE, (RANGE, sensor), {RANGE: AXES}
    address = Name(line, owner=sensor)
    if place == "nominal":
        address, known = Name(place, owner=sensor, axis=line), NOMINAL
    label = f"--set {path.strip()}"
    node, issues = compose(value.strip(), label, path=".".join((*where, *inside)))
    if issues:
        raise all_of(issues)
    return Override(
        text=text,
        device=device,
        address=address,
        path=where,
        axes=known.get(line, ()),
        inside=tuple(inside),
        node=node,
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


def apply(root: Node, change: Override) -> Node:
    """Lay a change over the nodes of a device."""
    over, base = change.node, _there(root, change)
    if isinstance(over.value, tuple) and change.axes and not change.inside:
        over = _by_axis(over, change)
    if "errors" in change.path:
        over = _line(base, over, change)
    elif change.inside:
        over = _by_key(base, over, change)
    return put(_with_ranges(root, change), change.path, over)


def _there(root: Node, change: Override) -> Node | None:
    """Return what stands now where a change is."""
    return _with_ranges(root, change).find(change.path)


def _with_ranges(root: Node, change: Override) -> Node:
    """Return a device whose range, where it is a text, stands by its sensor."""
    node = root.child(RANGE)
    if node is None or not isinstance(node.value, str) or RANGE not in change.path:
        return root
    try:
        parse_quantity(node.value.removeprefix("±"), "deg/s")
        sensor = GYRO
    except UnitError:
        sensor = ACCELEROMETER
    return put(root, (RANGE,), replace(node, value={sensor: node}))


def _by_axis(over: Node, change: Override) -> Node:
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
        raise all_of([issue_at(over, message)])
    axes = replace(over, value=dict(zip(change.axes, items, strict=True)))
    return replace(over, value={"axes": axes}) if "errors" in change.path else axes


def _line(base: Node | None, over: Node, change: Override) -> Node:
    """Return a line with the change in it, and with no word of the old source."""
    known = {} if base is None else {"value": base}
    if base is not None and isinstance(base.value, dict):
        known = base.value
    kept = {
        key: one
        for key, one in known.items()
        if key not in _OF_THE_OLD
        and not (key == "meaning" and one.value == EXACT)  # of the old 0
    }
    if change.inside:
        is_axis = change.inside[0] in change.axes
        steps = ("axes", *change.inside) if is_axis else change.inside
        new = merge(replace(over, value=kept), put(None, steps, over), short=True)
    else:
        own = over.value if isinstance(over.value, dict) else {"value": over}
        if own.keys() & _SIZES:
            kept = {key: one for key, one in kept.items() if key not in _SIZES}
        new = replace(over, value={**kept, **own})
    fields = dict(new.value) if isinstance(new.value, dict) else {}
    if "density" in fields and not per_root_hertz(_shown(new)):
        del fields["density"]
    told = replace(change.node, value="--set", written="--set")
    return replace(new, value={"source": told, **fields})


def _by_key(base: Node | None, over: Node, change: Override) -> Node:
    """Return nominal values, or a range, with that of one axis changed."""
    known = {} if base is None else dict.fromkeys(change.axes, base)
    if base is not None and isinstance(base.value, dict):
        known = {key: one for key, one in base.value.items() if key != "condition"}
    return replace(over, value={**known, change.inside[0]: over})


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
    before: Node, after: Node, changes: Iterable[Override]
) -> tuple[Changed, ...]:
    """Say what each change changed."""
    told: dict[Name, Changed] = {}
    for change in changes:
        old, new = _there(before, change), _there(after, change)
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


def check_used(changes: Sequence[Override], used: Iterable[str]) -> None:
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
        sensor = change.address.owner
        whose = f" called {change.device!r}" if change.device else ""
        raise CallError(
            f"--set {change.text}: no device here{whose} has "
            f"{'an' if sensor[0] in 'aeiou' else 'a'} {sensor}; give one "
            "that has, or leave this change out"
        )
