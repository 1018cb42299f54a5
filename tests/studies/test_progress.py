"""The progress bar: on a terminal only, and with the name of what is being done."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from command_line import surroundings

import budget

pty = pytest.importorskip("pty", reason="takes a pseudo-terminal")

REPORT = ("report", "--sobol", "-o", "x.html", "-o", "x.pdf")


def on_terminal(*args, cwd):
    """Return what a command shows on a terminal that is its stderr."""
    mine, its = pty.openpty()
    run = subprocess.Popen(
        [sys.executable, "-m", "budget", *args],
        cwd=cwd,
        stdout=subprocess.DEVNULL,
        stderr=its,
        env=surroundings() | {"TERM": "xterm"},
    )
    os.close(its)
    shown = b""
    while True:
        try:
            part = os.read(mine, 4096)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(mine)
    assert run.wait(timeout=600) == 0
    return shown.decode()


@pytest.mark.slow
def test_long_work_says_what_it_is_doing(tmp_path):
    """A report shows a bar with the names of its tasks, and takes it away after."""
    shown = on_terminal(*REPORT, cwd=tmp_path)

    assert "figures and pages" in shown
    assert "100%" in shown
    assert shown.rstrip().endswith("x.pdf: written")


def test_studies_name_their_tasks():
    """Checks, indices and their steps are told by name, in their order."""
    told = []
    budget.analyze(
        budget.load_device("zhao-2019"),
        samples=64,
        progress=lambda what, done, total: told.append((what, done <= total)),
    )

    assert list(dict.fromkeys(told)) == [
        ("Monte Carlo check of the law", True),
        ("Sobol' indices", True),
    ]
