"""Long runs: stopped at once, and in little memory."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from time import monotonic, sleep

import pytest

LONG_RUN = (
    *(sys.executable, "-m", "budget", "analyze", "--method", "monte-carlo"),
    *("--trials", "100000000"),
)
PATIENCE = 600.0  # [s] before a test gives up on a process that hangs


def wait_for_group(group):
    """Return whether all processes of a group are gone before patience ends."""
    begun = monotonic()
    while monotonic() - begun < PATIENCE:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        sleep(0.05)
    return False


@pytest.mark.parametrize("workers", ["1", "2"])
def test_ctrl_c_leaves_no_process_and_no_file(tmp_path, workers):
    """Interrupted in the middle, the run ends with 130, whole, and writes nothing."""
    result = tmp_path / "result.json"
    process = subprocess.Popen(
        [*LONG_RUN, "--workers", workers, "--json", str(result)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    sleep(4.0)  # well into the trials: 400 million take minutes
    assert process.poll() is None
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does, to all of them
    _, talk = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert "interrupted" in talk
    assert "Traceback" not in talk
    assert wait_for_group(process.pid)
    assert list(tmp_path.iterdir()) == []


PEAK_OF_CHILD = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def test_more_trials_than_are_kept_take_no_more_memory():
    """Three million trials, counted in bins, stay under 300 MB."""
    # Through a small process: a child starts with the memory of its parent.
    run = subprocess.run(
        [sys.executable, "-c", PEAK_OF_CHILD, *LONG_RUN[:-1], "3000000"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert int(run.stdout) / 1024.0 < 300.0  # kB on Linux; 3e6 x 24 doubles: 550 MB
