"""Files of references: reference budgets by name, their inputs as stored and now."""

from __future__ import annotations

import os
from dataclasses import replace
from hashlib import sha256
from os.path import isdir, isfile
from pathlib import Path, PureWindowsPath
from typing import TYPE_CHECKING

from budget.errors import CallError, ReferenceFileError
from budget.inputs.changes import check_used, read_change
from budget.inputs.checking import nearest
from budget.inputs.device import read_device, root_of, variant_names
from budget.inputs.fields import node_of
from budget.inputs.files import FOLDERS, NamedFile, find, lies_in, open_file
from budget.inputs.load import PAPER
from budget.inputs.reader import parse
from budget.inputs.station import named_station, station_file
from budget.inputs.tree import YamlFile, all_of
from budget.model.sources import STATION
from budget.recordings.results import open_result, read_result
from budget.references.exchange import effective
from budget.references.records import RESULT, StoredInput
from budget.resources import shipped
from budget.results import InputFile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.inputs.changes import Override
    from budget.references.records import Role

FOLDER = "references"
SUFFIX = ".json"  # of a reference budget
SUFFIXES = (".yaml", ".yml")


def shipped_references() -> tuple[NamedFile, ...]:
    """Return the references that ship, by name."""
    return tuple(
        NamedFile(path=path, shown=path.stem, variant="")
        for path in sorted((shipped("specs") / FOLDER).glob(f"*{SUFFIX}"))
    )


def named_reference(one: NamedFile) -> InputFile:
    """Return a reference by its base name and the hash of its bytes."""
    digest = sha256(one.path.read_bytes()).hexdigest()
    return InputFile(role="reference", name=one.path.name, sha256=digest)


def find_references(name: str | None) -> tuple[NamedFile, ...]:
    """Find references by file, by folder or by bare name; all that ship without one.

    Raises
    ------
    ReferenceFileError
        The name is of none, or the folder has none.
    """
    there = shipped_references()
    if name is None:
        return there
    bare = name.removesuffix(SUFFIX)
    if is_folder := isdir(name):  # noqa: PTH112 - a name that can be none is not there
        paths = {str(one): one for one in sorted(Path(name).glob(f"*{SUFFIX}"))}
    elif isfile(name):  # noqa: PTH113 - as above
        paths = {name: Path(name)}
    else:
        paths = {one.shown: one.path for one in there if one.shown == bare}
    if not paths:
        known = tuple(one.shown for one in there)
        raise ReferenceFileError(
            f"{name}: has no {SUFFIX} file, expected a folder with references; "
            "store one with `budget check --save`"
            if is_folder
            else f"{name}: no such file, expected a reference budget, a folder of "
            f"them, or a shipped one: {', '.join(known) or 'none'}"
            f"{nearest(bare, known)}"
        )
    return tuple(
        NamedFile(path=path, shown=shown, variant="") for shown, path in paths.items()
    )


def take(
    role: Role, typed: str | Path | None, folder: Path | None = None
) -> StoredInput:
    """Return a file that a user named, as a reference stores it.

    It is FILE, FILE#VARIANT of a device, or the bare name of a file that ships; None is
    the paper's that ships, whatever the folder one works in has of that name. Without
    the folder where the reference will be it is stored as it was named.

    Raises
    ------
    SpecError
        Everything that is wrong with the file, each at its place.
    ReferenceFileError
        No path leads from the reference to the file that holds on another machine.
    """
    return _taken(role, typed, folder)[0]


def _taken(
    role: Role, typed: str | Path | None, folder: Path | None
) -> tuple[StoredInput, YamlFile]:
    """Return a file as a reference stores it, and as it was read from its path."""
    if typed is not None:
        file = find(typed, role if role in FOLDERS else None)
    else:
        path = shipped("specs") / FOLDERS[role] / f"{PAPER}.yaml"
        file = NamedFile(path=path, shown=PAPER, variant="")
    document = _open(file, role)
    return _stored(document, role, file, folder), replace(document, file=str(file.path))


def _stored(
    document: YamlFile, role: Role, file: NamedFile, folder: Path | None
) -> StoredInput:
    """Return a file that was read as a reference stores it."""
    ships = shipped("specs") / FOLDERS.get(role, role)
    is_bare = file.path.parent == ships and file.shown == file.path.stem
    shown = file.shown
    if folder is not None and file.content is not None:
        raise CallError(
            f"{shown}: a reference is computed again from its files, expected a file "
            "that stays; save what is there to a file and name it"
        )
    if folder is not None and not is_bare:
        shown = _path_from(folder, file.path, role)
    return StoredInput(
        role=role,
        file=shown,
        variant=file.variant,
        sha256=document.sha256,
        text=document.text,  # of the bytes that were hashed: none is read twice
    )


def take_procedures(
    typed: Sequence[str | Path | None], folder: Path | None = None
) -> tuple[StoredInput, ...]:
    """Return procedures as `take` does, and the station that they name after them.

    Raises
    ------
    SpecError, ReferenceFileError
        As `take`; or they name several stations, of which a reference stores one.
    """
    taken: list[StoredInput] = []
    stations: dict[str, StoredInput] = {}
    for name in typed:
        one, document = _taken("procedure", name, folder)
        taken.append(one)
        if named_station(document):
            file = station_file(document)
            station = _stored(open_file(file, STATION), "station", file, folder)
            stations[station.file] = station
    if len(stations) > 1:
        raise ReferenceFileError(
            f"the procedures name the stations {', '.join(stations)}, and a reference "
            "stores one; save a reference of each, or write the keys of the station "
            "into the procedures"
        )
    return (*taken, *stations.values())


def with_changes(
    inputs: Sequence[StoredInput], changes: Sequence[str], *, job: str
) -> tuple[StoredInput, ...]:
    """Return inputs of a job with the changes that are their own, as of `--set`.

    Raises
    ------
    CallError
        A change is none, or reaches no device.
    SpecError
        Everything that is wrong with a device that has one, each at its place.
    """
    wanted = [read_change(text) for text in changes]
    if not wanted:
        return tuple(inputs)
    taken = [replace(one, changes=_own(one, wanted, job)) for one in inputs]
    check_used(wanted, (text for one in taken for text in one.changes))
    return tuple(taken)


def _own(one: StoredInput, changes: Sequence[Override], job: str) -> tuple[str, ...]:
    """Return those changes that a device, or any variant that it stands for, has."""
    if one.role != "device":
        return ()
    document = parse(one.text.encode(), one.file, base_name=_locate(one, Path()).name)
    found = {
        change.text
        for name in _variants(document, one, job)
        for change in _reaching(document, one, name, changes)
    }
    return tuple(change.text for change in changes if change.text in found)


def _variants(document: YamlFile, one: StoredInput, job: str) -> tuple[str, ...]:
    """Return the devices that an input stands for: in a comparison every variant."""
    if job == "compare" and not one.variant:
        return variant_names(document)
    return (one.variant,)


def _reaching(
    document: YamlFile, one: StoredInput, variant: str, changes: Sequence[Override]
) -> list[Override]:
    """Return those changes that are of one device in a file."""
    root = root_of(document, variant)
    file = NamedFile(path=_locate(one, Path()), shown=one.file, variant=variant)
    return [change for change in changes if change.is_of(file, variant, root)]


def present_documents(
    inputs: Sequence[StoredInput],
    folder: Path,
    *,
    reference: str,
    job: str,
    root: Path | None = None,
) -> tuple[YamlFile, ...]:
    """Return the inputs as their files are now, a device with its variant laid over.

    Paths count from `folder`, that of the reference; the files must be in `root`, or
    else in the tree of that folder. Of a comparison a device file is its base and every
    variant.

    Raises
    ------
    ReferenceFileError
        A file is gone, or would be outside the tree of the reference.
    SpecError
        A file cannot be read on.
    """
    found: list[YamlFile] = []
    tree = tree_of(folder) if root is None else root
    named = any(one.role == "procedure" and _names_station(one) for one in inputs)
    for one in inputs:
        if named and one.role == STATION:
            continue  # found below: by the name that the procedure has for it now
        path = _locate(one, folder)
        is_bare = _is_bare(one.role, one.file)
        if not is_bare:
            _confine(one.role, one.file, path, tree, reference)
        if not isfile(path):  # noqa: PTH113 - a name that can be none is not there
            where = "among the files that ship" if is_bare else "there"
            raise ReferenceFileError(
                f"{reference}: its {one.role} {one.file} is not {where}; a reference "
                "is computed again from its files: put the file back, or save the "
                "reference again from where it is now"
            )
        shown = one.file if is_bare else os.path.relpath(path)
        document = _open(
            NamedFile(path=path, shown=shown, variant=one.variant), one.role
        )
        found.extend(_documents(document, one, job))
    stations = {}
    for procedure in [one for one in found if named_station(one)]:
        file = station_file(procedure)
        if file.path.parent != shipped("specs") / FOLDERS[STATION]:
            _confine(STATION, file.shown, file.path, tree, reference)
        stations[file.path.resolve()] = open_file(file, STATION)
    return (*found, *stations.values())


def _names_station(one: StoredInput) -> bool:
    """Whether a stored procedure names the file of a station."""
    return bool(named_station(parse(one.text.encode(), one.file, base_name=one.file)))


def stored_documents(
    inputs: Sequence[StoredInput], *, reference: str, job: str
) -> tuple[YamlFile, ...]:
    """Return the inputs as a reference has them; '' for files that were just read.

    Raises
    ------
    SpecError
        An input is unsound.
    """
    found: list[YamlFile] = []
    for one in inputs:
        shown = f"{reference}, stored {one.file}" if reference else one.file
        path, data = _locate(one, Path()), one.text.encode()
        if one.role == RESULT:
            file = NamedFile(path=path, shown=shown, variant="", content=data)
            found.append(_open(file, one.role))
            continue
        document = parse(data, shown, base_name=path.name)
        if document.issues:
            raise all_of(document.issues)
        document = replace(document, kind=one.role)
        found.extend(_documents(document, one, job))
    return tuple(found)


def tree_of(folder: Path) -> Path:
    """Return the tree that a reference in that folder may read its inputs from.

    The folder one works in, where the reference is in it; the files that ship, where it
    ships; else its own folder.
    """
    here = folder.resolve()
    for tree in (shipped("specs"), Path.cwd()):
        if here.is_relative_to(tree.resolve()):
            return tree
    return folder


def _confine(role: str, file: str, path: Path, tree: Path, reference: str) -> None:
    """Refuse a file outside the tree, links followed, before it is opened.

    Whoever forges a reference would else have any file of the reader's read, and lines
    of it in a message.
    """
    if not lies_in(path, tree):
        raise ReferenceFileError(
            f"{reference}: its {role} {file} is outside {tree}, expected a "
            "file in the tree of the reference; it was not opened. If you trust the "
            "reference, give a folder that both are in: --root FOLDER"
        )


def digest(text: str) -> str:
    """Return the SHA-256 of a text."""
    return sha256(text.encode()).hexdigest()


def _documents(document: YamlFile, one: StoredInput, job: str) -> list[YamlFile]:
    """Return one input, or one for every variant in a comparison."""
    if one.role != "device":
        return [document]
    changes = [read_change(text) for text in one.changes]
    found = []
    for name in _variants(document, one, job):
        own = _reaching(document, one, name, changes)
        read_device(document, name, own)  # says what is wrong, at its place in the file
        found.append(effective(document, name, own))
    return found


def _open(file: NamedFile, role: str) -> YamlFile:
    """Read a file of a role; of a result only as a whole can anything be other.

    Raises
    ------
    SpecError
        What is wrong with it.
    """
    if role != RESULT:
        return open_file(file, role)
    opened = open_result(file)
    sha256 = read_result(opened).sha256
    return YamlFile(
        file=file.shown,
        base_name=file.path.name,
        sha256=sha256,
        root=replace(node_of(sha256), written=f"SHA-256 {sha256[:12]}"),
        issues=(),
        kind=RESULT,
        text=(opened.content or b"").decode(),
    )


def _is_bare(role: str, file: str) -> bool:
    """Whether a stored file is the bare name of one that ships."""
    return role in FOLDERS and "/" not in file and not file.endswith(SUFFIXES)


def _locate(one: StoredInput, folder: Path) -> Path:
    """Return where a stored input is now."""
    if _is_bare(one.role, one.file):
        return shipped("specs") / FOLDERS[one.role] / f"{one.file}.yaml"
    return folder / one.file


def _path_from(folder: Path, path: Path, role: str) -> str:
    """Return the path of a file from a folder, with '/'."""
    here, there = (Path(os.path.abspath(p)) for p in (folder, path))  # noqa: PTH100 - resolve() would follow links
    if here.parts[:2] != there.parts[:2] and here != there.parent:
        raise ReferenceFileError(
            f"{path}: has no folder in common with the reference in {folder}, so no "
            "path from one to the other would hold on another machine; keep both in "
            "one tree"
        )
    relative = Path(os.path.relpath(there, here)).as_posix()
    # 'C:x.yaml' is a name here and a place on a disk elsewhere; './C:x.yaml' is not.
    is_odd = _is_bare(role, relative) or PureWindowsPath(relative).anchor
    return f"./{relative}" if is_odd else relative
