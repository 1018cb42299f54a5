"""Limits of memory that a shell sets: words within seconds, or the right answer."""

from __future__ import annotations

import subprocess

import pytest
from command_line import surroundings
from failing import BUDGET, PATIENCE

pytest.importorskip("resource")

MISSION = ("mission", "--mission", "bench", "--no-validate")
ENOUGH = 2_000_000  # [kB]


def limited(option, kilobytes, *args):
    """Run a command in a shell that limits its memory."""
    shell = ("sh", "-c", f'ulimit {option} {kilobytes} && exec "$@"', "sh")
    return subprocess.run(
        (*shell, *BUDGET, *args),
        env=surroundings(),
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=PATIENCE,
        check=False,
    )


@pytest.mark.parametrize("option", ["-v", "-d"])
@pytest.mark.parametrize("kilobytes", [100_000, 220_000, 300_000, 480_000])
def test_too_little_memory_is_refused_in_words(option, kilobytes):
    """Before libraries are loaded that would wait for ever: what to raise, to what."""
    found = limited(option, kilobytes, *MISSION)

    assert found.returncode == 2, found.stderr
    assert found.stdout == ""
    for word in (f"ulimit {option}", f"{kilobytes} kB", "491520 kB", "raise it"):
        assert word in found.stderr


@pytest.mark.slow
def test_enough_memory_changes_nothing():
    """Under a limit that is no less than needed the answer is that without one."""
    plain = limited("-v", "unlimited", *MISSION)

    for option in ("-v", "-d"):
        found = limited(option, ENOUGH, *MISSION)
        assert found.returncode == 0, found.stderr
        assert found.stdout == plain.stdout


@pytest.mark.parametrize("command", [("report",), ("paper",), MISSION])
def test_pages_are_refused_less_than_what_draws_them_takes(command):
    """What makes a PDF would end the process where it gets no memory."""
    found = limited("-v", 800_000, *command, "-o", "a.pdf")

    assert found.returncode == 2, found.stderr
    assert "819200 kB" in found.stderr


def test_the_version_is_printed_under_any_limit():
    """What takes no matrix is not refused."""
    assert limited("-v", 100_000, "--version").returncode == 0
