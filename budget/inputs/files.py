"""Find the file a user names, and of what kind it is."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from budget.errors import CallError, SpecError
from budget.inputs.checking import nearest
from budget.inputs.reader import INPUT, read, read_stdin, refuse
from budget.inputs.tree import all_of, describe
from budget.resources import shipped
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator

    from budget.inputs.tree import Node, YamlFile

# The folder of the shipped files of each kind; of costs and recordings there are none.
FOLDERS = {
    "device": "devices",
    "procedure": "procedures",
    "station": "stations",
    "mission": "missions",
    "requirement": "requirements",
    "costs": "costs",
    "recording": "recordings",
}
STDIN = "-"
NEWEST_FORMAT = 1  # that this version reads, of every kind
_BARE_NAME = re.compile(r"\w[\w.+-]*")


@dataclass(frozen=True, kw_only=True)
class NamedFile:
    """What a user typed: a file and perhaps a variant in it."""

    path: Path
    shown: str  # as typed
    variant: str  # '' for the base
    content: bytes | None = None  # where it is known, and not to be read


# What stands for a file: its name, that of a shipped one, or what is in it.
File = str | Path | Mapping[str, object] | NamedFile
_MOST_NAMES = 20  # that one message lists
MAPPING = "dict"  # the name of a file that is none


def find(typed: File, kind: str | None = None) -> NamedFile:
    """Find the file behind FILE, FILE#VARIANT or the bare name of a shipped one.

    A mapping stands for a file with its keys, and is kept as JSON indented by one;
    '-' and '-#VARIANT' for what is on standard input.

    Raises
    ------
    CallError
        It is none of these.
    SpecError
        Standard input cannot be read.
    """
    if isinstance(typed, NamedFile):
        return typed
    if isinstance(typed, Mapping):
        content = _written(typed)
        return NamedFile(path=Path(MAPPING), shown=MAPPING, variant="", content=content)
    if not isinstance(typed, str | Path):
        what = kind or "file"
        raise CallError(
            f"found a {type(typed).__name__}, expected a {what}: what "
            f"budget.load_{what} returns, the name of a file or of a shipped {what}, "
            "or a dict with the keys of such a file"
        )
    text = str(typed)
    shown, mark, variant = text.rpartition("#")
    if not mark or exists(Path(text)):
        shown, mark = text, ""
    variant = variant if mark else ""
    if shown == STDIN:
        return NamedFile(
            path=Path(INPUT), shown=INPUT, variant=variant, content=read_stdin()
        )
    path = Path(shown)
    if _BARE_NAME.fullmatch(shown) and not (exists(path) and path.is_file()):
        same_name = (one for one in _shipped(kind) if one.stem == shown)
        path = next(same_name, path)
    return NamedFile(path=path, shown=shown, variant=variant)


def _written(mapping: Mapping[str, object]) -> bytes:
    """Write a mapping as the file that it stands for.

    Raises
    ------
    CallError
        It holds what no file can hold.
    """
    try:
        text = json.dumps(mapping, indent=1, ensure_ascii=False, allow_nan=False)
        return text.encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise CallError(
            f"{MAPPING}: {error}; a file has texts, numbers, true or false, lists "
            "and dicts of them"
        ) from None


def open_file(file: NamedFile, kind: str | None = None) -> YamlFile:
    """Read a file and find its kind from its keys.

    Raises
    ------
    SpecError
        It cannot be read, has a newer format, or is of another kind or of none.
    """
    refuse_absent(file, kind)
    document = read(file.path, file.shown, file.content)
    root = document.root
    if root.value is None:  # an issue already
        raise all_of(document.issues)
    if not isinstance(root.value, dict):
        hint = "; a mission file names a recording, as 'trajectory: FILE.csv'"
        hint = hint if file.path.suffix.lower() == ".csv" else ""
        message = f"found {describe(root.value)}, expected a mapping of keys{hint}"
        raise document.refuse((root, message))
    _check_format(document)
    sign = next(_signs(root), None)
    # A procedure may hold no more than its station, all else being the paper's; where
    # nothing says of what kind a file is, its model says what is missing.
    also = "procedure" if sign and sign.kind == "station" else None
    own = kind or (sign.kind if sign else "")
    if own and (sign is None or own in {sign.kind, also}):
        return replace(document, kind=own)
    if sign is not None:
        message = f"this key is of a {sign.kind} file, expected a {kind} file"
        raise document.refuse((sign.node, message), on_key=True)
    message = (
        "is of no known kind, expected limits (in a requirement), costs (costs), "
        "recording (recording), mission (mission), latitude or windows (procedure), "
        "station (station), gyro or accelerometer (device)"
    )
    raise document.refuse((root, message))


def refuse_absent(
    file: NamedFile, kind: str | None, words: tuple[str, ...] = ()
) -> None:
    """Refuse a file that is not there, where these words may stand in its place.

    Raises
    ------
    SpecError
        It is not there.
    """
    if file.content is not None or exists(file.path):
        return
    names = shipped_names(kind)
    ships = ", ".join(names)
    if len(names) > _MOST_NAMES:
        ships = f"`budget devices` lists {len(names)} of them"
    expected = ", ".join((*map(repr, words), "a YAML file"))
    bare = f", or a shipped one: {ships}" if names else ""
    message = f"no such file, expected {expected}{bare}"
    raise refuse(file.shown, f"{message}{_hint(file, names, words)}")


def _shipped(kind: str | None) -> list[Path]:
    """Return the shipped files of a kind, or of all."""
    folders = FOLDERS.values() if kind is None else [FOLDERS[kind]]
    return [
        path
        for folder in folders
        for path in sorted((shipped("specs") / folder).glob("*.yaml"))
    ]


def shipped_names(kind: str | None) -> tuple[str, ...]:
    """Return the bare names of the shipped files of a kind, or of all."""
    return tuple(path.stem for path in _shipped(kind))


def bare_name(file: str) -> str:
    """Return 'hg4930#A', by which a shipped file is named, of 'hg4930.yaml#A'."""
    path, mark, variant = file.partition("#")
    return f"{Path(path).stem}{mark}{variant}"


def _hint(file: NamedFile, names: tuple[str, ...], words: tuple[str, ...]) -> str:
    """Return a hint at the word or shipped file, with its variant, that may be meant.

    Or '' where none is near.
    """
    variant = f"#{file.variant}" if file.variant else ""
    name = bare_name(f"{file.shown}{variant}")
    if name.partition("#")[0] in names:
        return f"; did you mean {name!r}, which ships?"
    return nearest(file.shown, (*words, *names))


def exists(path: Path) -> bool:
    """Say whether there is such a file; a name that cannot be one is none."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def lies_in(path: Path, tree: Path) -> bool:
    """Say whether a file is in a folder or below it, links followed."""
    try:
        return path.resolve().is_relative_to(tree.resolve())
    except (OSError, ValueError, RuntimeError):  # no name of a file, or links in a ring
        return False


@contextmanager
def unshown(path: Path, what: str, document: YamlFile, node: Node) -> Iterator[None]:
    """Read a file that another one names at `node`; show nothing of a stranger's.

    Whoever writes a file for others could else name any file of theirs, and have lines
    of it in a message. In the folder of the file that names it, or below, it is ours.

    Raises
    ------
    SpecError
        What is wrong; of a file elsewhere, where that begins.
    """
    try:
        yield
    except SpecError as error:
        folder = Path(document.file).parent
        if lies_in(path, folder):
            raise
        first = error.issues[0]
        message = (
            f"found {describe(node.value)}, which cannot be read as {what}, from line "
            f"{first.line}, column {first.column} on; nothing of a file outside "
            f"{str(folder)!r} is shown: copy it there to see what is wrong"
        )
        raise document.refuse((node, message)) from None


def _check_format(document: YamlFile) -> None:
    """Refuse a file that was written for a later version of this program."""
    node = document.root.child("format")
    version = re.fullmatch(
        "budget-[a-z]+/([1-9][0-9]{0,8})", node.written if node else ""
    )
    if node and version and int(version[1]) > NEWEST_FORMAT:
        # Format n comes with version n of this program.
        message = (
            f"found {node.written!r}, which needs budget >= {version[1]}; this is "
            f"budget {__version__}"
        )
        raise document.refuse((node, message))


@dataclass(frozen=True)
class _Sign:
    """A key that says of what kind a file is."""

    kind: str
    node: Node


def _signs(root: Node) -> Iterator[_Sign]:
    """Yield what the keys say about the kind of a file, the decisive one first."""
    sensors = [node for key in ("gyro", "accelerometer") if (node := root.child(key))]
    inside = ("rate", "turns", "order", "azimuths", "pause", "dwell", "bias")
    places = [
        ("requirement", root, ("limits",)),
        ("costs", root, ("costs",)),
        ("recording", root, ("recording",)),
        ("mission", root, ("mission",)),
        (
            "procedure",
            root,
            (
                *("gravity", "formulas", "sample_rate"),
                *("windows", "estimator", "estimate"),
            ),
        ),
        *(("procedure", sensor, inside) for sensor in sensors),
        # What stands under `mission`: its model says so.
        ("mission", root, ("segments", "trajectory", "altitude", "alignment")),
        ("procedure", root, ("latitude",)),
        ("procedure", root, ("height", "flip_axis", "pause")),
        ("device", root, ("gyro", "accelerometer")),
        ("station", root, ("station", "environment")),
    ]
    for kind, place, keys in places:
        for key in keys:
            if node := place.child(key):
                # The name of a station stands in procedures alone.
                names = key == "station" and isinstance(node.value, str)
                yield _Sign("procedure" if names else kind, node)
