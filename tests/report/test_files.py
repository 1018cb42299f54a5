"""Files are written whole or not at all."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from stat import S_IMODE, S_ISDIR

import pytest
from places import put

from budget.errors import OutputError
from budget.journal import keep_journal, note_read
from budget.report.files import write_all


def listing(folder):
    """Names and contents of the files in a folder."""
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir()) if p.is_file()}


def test_text_and_bytes_are_written(tmp_path):
    """Text is written as UTF-8 with its line ends as they are, bytes as bytes."""
    write_all({tmp_path / "a.csv": "µ\n", tmp_path / "b.pdf": b"\x00\xff"})

    assert listing(tmp_path) == {"a.csv": b"\xc2\xb5\n", "b.pdf": b"\x00\xff"}


def test_files_are_replaced(tmp_path):
    """What stood there before is gone, and nothing else is left behind."""
    (tmp_path / "a.csv").write_text("old and longer")

    write_all({tmp_path / "a.csv": "new"})

    assert listing(tmp_path) == {"a.csv": b"new"}


def test_permissions_stay(tmp_path):
    """A replaced file keeps its mode; a new one gets the usual one, not 0600."""
    old = put(tmp_path / "old", "old")
    old.chmod(0o640)
    plain = put(tmp_path / "plain", "made the usual way")

    write_all({old: "x", tmp_path / "new": "x"})

    assert old.stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "new").stat().st_mode == plain.stat().st_mode


def test_link_is_followed(tmp_path):
    """A symbolic link stays a link and its file is replaced."""
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")

    write_all({tmp_path / "link": "new"})

    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"


def fifo(folder):
    """Make a pipe."""
    os.mkfifo(folder / "x" / "fifo")
    return folder / "x" / "fifo"


def loop(folder):
    """Make a link to itself."""
    (folder / "x" / "loop").symlink_to("loop")
    return folder / "x" / "loop"


def dangling(folder):
    """Make a link to nothing."""
    (folder / "x" / "link").symlink_to("nowhere")
    return folder / "x" / "link"


def read_only(folder):
    """Make a file that nobody may write, root included."""
    (folder / "x" / "kept").write_text("old")
    (folder / "x" / "kept").chmod(0o444)
    return folder / "x" / "kept"


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda folder: folder / "missing" / "b", "does not exist"),
        (lambda folder: folder, "there is a folder of that name"),
        (lambda _: Path(os.devnull), "is a device"),
        (fifo, r"is a pipe \(FIFO\)"),
        (loop, "leads back to itself"),
        (dangling, "is a link to nowhere, which does not exist"),
        (read_only, "is read-only"),
        (lambda folder: folder / "." / "x" / ".." / "a", "written to this one file"),
    ],
)
def test_nothing_is_written_when_one_cannot_be(tmp_path, make, said):
    """One bad path stops all files; the message names it and what to do."""
    (tmp_path / "x").mkdir()
    bad = make(tmp_path)

    with pytest.raises(OutputError, match=said) as caught:
        write_all({tmp_path / "a": "text", bad: "text"})

    assert "expected" in str(caught.value)
    assert listing(tmp_path) == {}


def test_unwritable_folder_is_named(tmp_path, monkeypatch):
    """A folder without permission is refused before anything is written."""
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere

    with pytest.raises(OutputError, match="cannot be written, expected one that"):
        write_all({tmp_path / "a": "text"})

    assert listing(tmp_path) == {}


def test_failed_rename_takes_the_others_back(tmp_path, monkeypatch):
    """If the last rename fails, earlier files are as they were and no scraps stay."""
    (tmp_path / "a").write_text("old a")
    whole = Path.replace

    def replace(self, target):
        if Path(target).name == "c":
            raise OSError(28, "No space left on device")
        return whole(self, target)

    monkeypatch.setattr(Path, "replace", replace)

    with pytest.raises(OutputError, match="c: the system refused: No space left"):
        write_all({tmp_path / "a": "new", tmp_path / "b": "new", tmp_path / "c": "new"})

    assert listing(tmp_path) == {"a": b"old a"}


def test_interrupt_leaves_no_scraps(tmp_path, monkeypatch):
    """Stopped while writing, the folder is as it was."""

    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)

    with pytest.raises(KeyboardInterrupt):
        write_all({tmp_path / "a": "text"})

    assert listing(tmp_path) == {}


@pytest.mark.parametrize("name", ["in", "hard", "soft", "x/../in"])
def test_what_was_read_is_not_overwritten(tmp_path, name):
    """An input is told by any name: its own, a hard link, a link, another spelling."""
    (tmp_path / "x").mkdir()
    (tmp_path / "in").write_text("input")
    (tmp_path / "hard").hardlink_to(tmp_path / "in")
    (tmp_path / "soft").symlink_to("in")

    with keep_journal():
        note_read(tmp_path / "in")
        with pytest.raises(OutputError, match="is an input of this run"):
            write_all({tmp_path / "other": "text", tmp_path / name: "text"})
        write_all({tmp_path / "other": "text"})

    assert (tmp_path / "in").read_text() == "input"
    write_all({tmp_path / name: "text"})  # the next run has not read it


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_between_renames_waits(tmp_path, monkeypatch, number):
    """All files are new when it is answered, by whoever answers it otherwise."""
    (tmp_path / "a").write_text("old")
    whole = Path.replace
    seen = []

    def answer(*_):
        seen.append(listing(tmp_path))

    def replace(self, target):
        whole(self, target)
        os.kill(os.getpid(), number)
        time.sleep(0.01)  # time for Python to answer, if it would

    monkeypatch.setattr(Path, "replace", replace)
    before = signal.signal(number, answer)
    try:
        write_all({tmp_path / "a": "new", tmp_path / "b": "new"})
        assert signal.getsignal(number) is answer
    finally:
        signal.signal(number, before)

    assert seen == [{"a": b"new", "b": b"new"}]


def test_a_signal_that_is_ignored_stays_ignored(tmp_path, monkeypatch):
    """As under nohup: nothing is answered after the files stand."""
    whole = Path.replace

    def replace(self, target):
        whole(self, target)
        os.kill(os.getpid(), signal.SIGHUP)

    monkeypatch.setattr(Path, "replace", replace)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        write_all({tmp_path / "a": "new"})
    finally:
        signal.signal(signal.SIGHUP, before)

    assert listing(tmp_path) == {"a": b"new"}


def test_a_private_file_stays_private_while_it_is_replaced(tmp_path, monkeypatch):
    """Nothing that stands beside it, new or former, can be read by others."""
    target = put(tmp_path / "private.json", "old")
    target.chmod(0o640)
    seen = {}

    def look(descriptor, sync=os.fsync):
        for file in tmp_path.glob(".*.budget-tmp"):
            seen.setdefault(file.name, S_IMODE(file.stat().st_mode))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", look)
    before = os.umask(0o022)
    try:
        write_all({target: "new", tmp_path / "public.json": "new"})
    finally:
        os.umask(before)
    private = [mode for name, mode in seen.items() if "private" in name]
    assert len(private) == 2
    assert set(private) == {0o600}
    assert S_IMODE(target.stat().st_mode) == 0o640
    assert S_IMODE((tmp_path / "public.json").stat().st_mode) == 0o644
    assert target.read_text() == "new"


def test_the_folder_is_synced_after_the_renames(tmp_path, monkeypatch):
    """The last thing synced is the folder, with the new name in it."""
    synced = []

    def look(descriptor, sync=os.fsync):
        is_folder = S_ISDIR(os.fstat(descriptor).st_mode)
        synced.append((is_folder, (tmp_path / "new.json").exists()))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", look)
    write_all({tmp_path / "new.json": "{}"})
    assert synced == [(False, False), (True, True)]
