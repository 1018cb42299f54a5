"""Write files whole or not at all."""

from __future__ import annotations

import errno
import os
import shutil
import signal
from contextlib import ExitStack, contextmanager, suppress
from secrets import token_hex
from signal import SIG_DFL
from stat import S_ISFIFO, S_ISREG, S_ISSOCK
from threading import current_thread, main_thread
from typing import TYPE_CHECKING, Any

from budget.errors import OutputError
from budget.journal import is_input, note_written

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping
    from pathlib import Path

WRITABLE = 0o222  # permission bits
# What is written in the place of a file is nobody else's to read until it has its mode.
PRIVATE, UNMASKED = 0o600, 0o666
NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)


def write_all(files: Mapping[Path, str | bytes | Iterable[str]]) -> None:
    """Write all files, or leave every one of them as it was.

    Each is written under a temporary name in its own folder and renamed only when all
    are complete; should a rename fail, the earlier ones are taken back. A signal that
    comes between the first rename and the last waits.

    Parameters
    ----------
    files : mapping of Path to str, bytes or pieces of str
        Text is written as UTF-8 with its line ends as they are; pieces one after
        another, so that a large text never stands in memory as a whole.

    Raises
    ------
    OutputError
        A folder is missing or cannot be written, a target is no regular file, is
        read-only or an input of this run, two paths are one file, or the disk refuses.
    """
    targets = check_targets(files)
    with ExitStack() as staging:
        staged = []
        for (path, content), target in zip(files.items(), targets, strict=True):
            try:
                staged.append(_stage(target, _encoded(content), staging))
            except OSError as error:
                raise _refused(path, error) from error
        # Steps back run only on an error; temporary files go in any case, after them.
        with _without_signals(), staging.pop_all() as scraps, ExitStack() as undo:
            for path, target, temporary in zip(files, targets, staged, strict=True):
                try:
                    _take_place(target, temporary, scraps, undo)
                except OSError as error:
                    raise _refused(path, error) from error
            for folder in dict.fromkeys(target.parent for target in targets):
                _sync_folder(folder)
            undo.pop_all()
            note_written(files)


def check_targets(paths: Iterable[Path]) -> list[Path]:
    """Return where outputs go, links followed, or refuse what cannot be written.

    Raises
    ------
    OutputError
        As write_all; also where an output is an input of this run.
    """
    found = [(path, _follow(path)) for path in paths]
    targets = [target for _, target in found]
    for path, target in found:
        _check(path, target, twice=targets.count(target) > 1)
    return targets


@contextmanager
def _without_signals() -> Iterator[None]:
    """Let signals that would end this process wait until the files stand.

    A mask would not do: with other threads about, as those of linear algebra, a signal
    goes to one of them, and Python answers it here.
    """
    waiting: list[int] = []
    before: dict[int, Any] = {}
    names = ("SIGINT", "SIGTERM", "SIGHUP") if _in_main_thread() else ()
    try:
        for number in (
            getattr(signal, name) for name in names if hasattr(signal, name)
        ):
            if callable(handler := signal.getsignal(number)) or handler == SIG_DFL:
                before[number] = handler
                signal.signal(number, lambda number, _: waiting.append(number))
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in waiting[:1]:
            signal.raise_signal(number)


def _in_main_thread() -> bool:
    """Whether signals are answered here."""
    return current_thread() is main_thread()


def _follow(path: Path) -> Path:
    """Return the file behind a path; say of a link that leads nowhere that it does."""
    try:
        path.stat()
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise OutputError(
                f"{path}: is a link that leads back to itself, expected a file or a "
                "free name; remove the link or give another path"
            ) from None
        if isinstance(error, FileNotFoundError) and path.is_symlink():
            raise OutputError(
                f"{path}: is a link to {path.readlink()}, which does not exist, "
                "expected a file or a free name; remove the link or make its file first"
            ) from None
        if not isinstance(error, (FileNotFoundError, NotADirectoryError)):
            raise _refused(path, error) from None
    return path.resolve()


def _encoded(content: str | bytes | Iterable[str]) -> Iterator[bytes]:
    """Encode as UTF-8, also file names whose bytes this locale does not know."""
    if isinstance(content, bytes):
        yield content
        return
    for text in (content,) if isinstance(content, str) else content:
        data = text.encode("utf-8", errors="surrogateescape")
        yield data.decode("utf-8", errors="replace").encode()


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
    if is_input(target):
        raise OutputError(
            f"{path}: is an input of this run and would be overwritten, expected "
            "another file; write to that"
        )
    if target.exists():
        _check_present(path, target.stat().st_mode)
        if not (os.access(target, os.W_OK) and target.stat().st_mode & WRITABLE):
            raise OutputError(
                f"{path}: is read-only, expected a file that can be written or a free "
                "name; change its permissions or give another path"
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


def _check_present(path: Path, mode: int) -> None:
    """Refuse what is there and is no regular file."""
    kinds = {"a pipe (FIFO)": S_ISFIFO, "a socket": S_ISSOCK}
    if not S_ISREG(mode):
        kind = next((name for name, has in kinds.items() if has(mode)), "a device")
        raise OutputError(
            f"{path}: is {kind}, expected a regular file or a free name; to write to "
            "standard output give '-'"
        )


def _stage(target: Path, content: Iterable[bytes], scraps: ExitStack) -> Path:
    """Write the content beside the target under a temporary name."""
    temporary = _beside(target)
    scraps.callback(temporary.unlink, missing_ok=True)
    is_there = target.exists()
    _write(temporary, content, mode=PRIVATE if is_there else UNMASKED)
    if is_there:
        shutil.copymode(target, temporary)
    return temporary


def _write(path: Path, content: Iterable[bytes], *, mode: int) -> None:
    """Write a new file down to the disk, where a full one shows: before any rename."""
    descriptor = os.open(path, NEW, mode)
    with os.fdopen(descriptor, "wb") as file:
        file.writelines(content)
        file.flush()
        os.fsync(file.fileno())


def _sync_folder(folder: Path) -> None:
    """See that renames outlast a loss of power, where a folder can be asked to."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


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
    _write(former, [target.read_bytes()], mode=PRIVATE)
    shutil.copystat(target, former)
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
