"""Write files whole or not at all."""

from __future__ import annotations

import os
import shutil
from contextlib import ExitStack
from secrets import token_hex
from typing import TYPE_CHECKING

from budget.errors import OutputError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


def write_all(files: Mapping[Path, str | bytes]) -> None:
    """Write all files, or leave every one of them as it was.

    Each is written under a temporary name in its own folder and renamed only when all
    are complete; should a rename fail, the earlier ones are taken back.

    Parameters
    ----------
    files : mapping of Path to str or bytes
        Text is written as UTF-8 with its line ends as they are.

    Raises
    ------
    OutputError
        A folder is missing or cannot be written, a target is no regular file, two
        paths are one file, or the disk refuses.
    """
    targets = [path.resolve() for path in files]  # a link stays, its file is replaced
    for path, target in zip(files, targets, strict=True):
        _check(path, target, twice=targets.count(target) > 1)
    contents = [
        _encode(content) if isinstance(content, str) else content
        for content in files.values()
    ]
    # Steps back run only on an error; temporary files go in any case, after them.
    with ExitStack() as scraps, ExitStack() as undo:
        staged = []
        for path, target, content in zip(files, targets, contents, strict=True):
            try:
                staged.append(_stage(target, content, scraps))
            except OSError as error:
                raise _refused(path, error) from error
        for path, target, temporary in zip(files, targets, staged, strict=True):
            try:
                _take_place(target, temporary, scraps, undo)
            except OSError as error:
                raise _refused(path, error) from error
        undo.pop_all()


def _encode(text: str) -> bytes:
    """Encode as UTF-8, also file names whose bytes this locale does not know."""
    data = text.encode("utf-8", errors="surrogateescape")
    return data.decode("utf-8", errors="replace").encode()


def _check(path: Path, target: Path, *, twice: bool) -> None:
    """Refuse what cannot be written, before anything is."""
    if twice:
        raise OutputError(
            f"{path}: two outputs would be written to this one file, expected a file "
            "for each; give them different names"
        )
    if target.is_dir():
        raise OutputError(
            f"{path}: there is a folder of that name, expected a file or a free name; "
            "give the name of a file in it"
        )
    if target.exists() and not target.is_file():
        raise OutputError(
            f"{path}: is a device or a pipe, expected a regular file or a free name; "
            "to write to standard output give '-'"
        )
    if not target.parent.is_dir():
        raise OutputError(
            f"{path}: the folder {path.parent} does not exist, expected one that can "
            "be written; make it first or give another path"
        )
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise OutputError(
            f"{path}: the folder {path.parent} cannot be written, expected one that "
            "can; change its permissions or give another path"
        )


def _stage(target: Path, content: bytes, scraps: ExitStack) -> Path:
    """Write the content beside the target under a temporary name."""
    temporary = _beside(target)
    scraps.callback(temporary.unlink, missing_ok=True)
    with temporary.open("xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())  # a full disk shows here, not after the rename
    if target.exists():
        shutil.copymode(target, temporary)
    return temporary


def _take_place(
    target: Path, temporary: Path, scraps: ExitStack, undo: ExitStack
) -> None:
    """Rename to the target; a copy of what stood there is kept for the step back."""
    if not target.exists():
        temporary.replace(target)
        undo.callback(target.unlink, missing_ok=True)
        return
    former = _beside(target)
    scraps.callback(former.unlink, missing_ok=True)
    shutil.copy2(target, former)
    temporary.replace(target)
    undo.callback(former.replace, target)


def _beside(target: Path) -> Path:
    """Return a free name in the folder of the target."""
    return target.with_name(f".{target.name}.{token_hex(8)}.budget-tmp")


def _refused(path: Path, error: OSError) -> OutputError:
    """Say what the system said."""
    return OutputError(
        f"{path}: the system refused: {error.strerror or error}; expected a file that "
        "can be written; nothing was written, free the disk or give another path"
    )
