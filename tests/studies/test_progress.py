"""The progress bar: on a terminal only, and with the name of what is being done."""

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest
from command_line import surroundings

import budget
from budget.cli import computing

pty = pytest.importorskip("pty", reason="takes a pseudo-terminal")

REPORT = ("report", "--no-validate", "--sobol", "--samples", "64", "-o", "x.html")
# The bar does not wait until work takes long: how long that is is asked below.
AT_ONCE = """
import runpy
from budget.cli import computing

computing.PATIENCE = 0.0
runpy.run_module("budget", run_name="__main__", alter_sys=True)
"""


def on_terminal(*args, cwd):
    """Return what a command shows on a terminal that is its stderr."""
    mine, its = pty.openpty()
    run = subprocess.Popen(
        [sys.executable, "-c", AT_ONCE, *args],
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
    assert shown.rstrip().endswith("x.html: written")


class Stream(io.StringIO):
    """A stream that is a terminal, or none."""

    def __init__(self, *, is_terminal):
        super().__init__()
        self.isatty = lambda: is_terminal


@pytest.mark.parametrize(
    ("seconds", "is_terminal", "shows"),
    [(0.1, True, False), (3.0, True, True), (3.0, False, False)],
)
def test_a_bar_is_for_long_work(seconds, is_terminal, shows, monkeypatch):
    """Three seconds of work get a bar on a terminal; nothing else does."""
    clock = iter((0.0, seconds))
    monkeypatch.setattr(computing, "monotonic", lambda: next(clock, seconds))
    monkeypatch.setattr(sys, "stderr", Stream(is_terminal=is_terminal))
    with computing.progress() as show:
        show("work", 1, 2)
    assert ("work" in sys.stderr.getvalue()) is shows


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
