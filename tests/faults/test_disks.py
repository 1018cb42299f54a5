"""Disks, folders and memory that fail: whole files or none, and words."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
from contextlib import contextmanager
from unittest.mock import patch

import pytest
from failing import (
    BUDGET,
    FOREIGN,
    WRITING,
    contents,
    environment,
    run,
    run_here,
    said,
)
from forked import ASKED, keep_computed
from places import put

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="faults of POSIX systems"),
    pytest.mark.usefixtures("drawn_once", "computed_once"),
]

NOBODY = 65_534  # user and group without rights
ADDRESS_SPACE = 500 << 20  # [bytes] libraries take 350 MB, 2e6 trials 384


@pytest.fixture(scope="module")
def computed_once():
    """Compute once for the same words: it is the files that fail here."""
    with pytest.MonkeyPatch.context() as changes:
        keep_computed(changes.setattr)
        yield


@pytest.fixture(autouse=True)
def another_call():
    """Let a test make a call of its own, which asks from the first on."""
    ASKED.clear()


@contextmanager
def small_files(most):
    """Let this process write no file beyond a size [byte].

    Nor bytecode, which Python would cut there in silence, and read in the next run.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        with patch.object(sys, "dont_write_bytecode", new=True):
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.slow
@pytest.mark.parametrize("name", WRITING)
def test_a_limit_on_the_size_of_files(name, tmp_path):
    """A disk that takes 2 kB of a file: exit 2, the old files whole, no scraps."""
    for path in ("a.json", "a.csv", "a.html", "a.pdf"):
        (tmp_path / path).write_text(f"old {path}", encoding="utf-8")
    before = contents(tmp_path)

    with small_files(2048):
        outcome = run_here(*WRITING[name], folder=tmp_path)
    refused = {  # a PDF is prepared first, in the folder for temporary files
        "paper": "the folder for temporary files (File too large)",
    }.get(name, "the system refused: File too large")
    assert refused in said(outcome)
    assert outcome.returncode == 2
    assert contents(tmp_path) == before


@contextmanager
def small_disk(folder, options):
    """Mount a file system of its own on a folder; skip where that is not allowed."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    if (
        not shutil.which("mount")
        or subprocess.run(mount, capture_output=True, check=False).returncode
    ):
        pytest.skip("mounting is not allowed here")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["analyze", "export", "new", "paper"])  # all formats
def test_a_full_disk(name, tmp_path):
    """A disk of 8 kB: exit 2, the message names the file, old files are whole."""
    with small_disk(tmp_path / "disk", "size=8k") as disk:
        (disk / "a.json").write_text("old", encoding="utf-8")
        before = contents(disk)
        outcome = run_here(*WRITING[name], folder=disk)
        text = said(outcome)
        assert contents(disk) == before
    assert "No space left on device" in text
    assert "nothing was written" in text
    assert outcome.returncode == 2


@pytest.mark.parametrize("name", ["analyze", "report"])
def test_a_read_only_disk(name, tmp_path):
    """Exit 2, and the folder is named."""
    with small_disk(tmp_path / "disk", "size=8k,ro") as disk:
        outcome = run_here(*WRITING[name], folder=disk)
        text = said(outcome)
        assert contents(disk) == {}
    assert "cannot be written" in text or "the system refused: Read-only" in text
    assert outcome.returncode == 2


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("capsh"), reason="needs capsh")
def test_a_user_without_rights(tmp_path):
    """A folder of another user: exit 2 and what to do; so for a file not readable."""
    # Root may write anywhere, so it is root without that power.
    drop = "--drop=cap_dac_override,cap_dac_read_search"
    powerless = ["capsh", drop, "--", "-c", 'exec "$@"', "bash"]
    folder = tmp_path / "another's"
    folder.mkdir()
    secret = put(folder / "secret.yaml", FOREIGN)
    secret.chmod(0o600)
    try:
        for path in (secret, folder):
            os.chown(path, NOBODY, NOBODY)
        subprocess.run([*powerless, "true"], check=True, capture_output=True)
    except (PermissionError, subprocess.CalledProcessError):
        pytest.skip("needs root, whose power is then taken")

    def attempt(*words):
        return subprocess.run(
            [*powerless, *BUDGET, *words],
            cwd=folder,
            env=environment(),
            capture_output=True,
            check=False,
        )

    written = attempt("analyze", "--no-validate", "--json", "a.json")
    assert "cannot be written" in said(written)
    read = attempt("validate", "secret.yaml")
    assert "secret.yaml:1:1: " in said(read)
    assert (written.returncode, read.returncode) == (2, 2)
    assert [path.name for path in folder.iterdir()] == ["secret.yaml"]


def test_a_file_where_a_folder_should_be(tmp_path):
    """Exit 2, and nothing is touched."""
    (tmp_path / "file").write_text("old", encoding="utf-8")
    outcome = run(
        *("analyze", "--no-validate", "--json", "file/a.json"), folder=tmp_path
    )
    assert "expected one that can be written" in said(outcome)
    assert outcome.returncode == 2
    assert contents(tmp_path) == {"file": b"old"}


@pytest.mark.slow
def test_a_folder_that_is_gone(tmp_path):
    """Started in a folder that has been removed, a command still works or says so."""
    gone = tmp_path / "gone"
    gone.mkdir()
    outcome = subprocess.run(
        ["bash", "-c", 'rmdir "$PWD"; exec "$@"', "bash", *BUDGET, "devices"],
        cwd=gone,
        env=environment(),
        capture_output=True,
        check=False,
    )
    said(outcome)
    assert outcome.returncode in {0, 2}


@pytest.mark.slow
def test_too_little_memory(tmp_path):
    """Memory that runs out is exit 2 and words, at whatever point it does."""

    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))

    words = (
        "analyze",
        "--method",
        "monte-carlo",
        "--trials",
        "2000000",
        "--json",
        "a.json",
    )
    small = run(
        *("analyze", "--no-validate"),
        folder=tmp_path,
        before=limit,
        OPENBLAS_NUM_THREADS="1",
    )
    if small.returncode:
        pytest.skip("the libraries alone take more here")
    outcome = run(*words, folder=tmp_path, before=limit, OPENBLAS_NUM_THREADS="1")
    text = said(outcome)
    assert outcome.returncode == 2
    assert "not enough memory" in text
    assert contents(tmp_path) == {}


# ---- long runs in little memory ------------------------------------------------------

LONG_RUN = (
    *(sys.executable, "-m", "budget", "analyze", "--method", "monte-carlo"),
    *("--trials", "100000000"),
)


PEAK_OF_CHILD = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


@pytest.mark.slow
def test_more_trials_than_are_kept_take_no_more_memory():
    """Trials that are counted in bins stay under 240 MB."""
    # Through a small process: a child starts with the memory of its parent.
    run = subprocess.run(
        [sys.executable, "-c", PEAK_OF_CHILD, *LONG_RUN[:-1], "2100000"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert int(run.stdout) / 1024.0 < 240.0  # kB on Linux; 2.1e6 x 24 doubles: 400 MB
