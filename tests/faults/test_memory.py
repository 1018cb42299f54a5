"""Long runs in little memory."""

from __future__ import annotations

import subprocess
import sys

LONG_RUN = (
    *(sys.executable, "-m", "budget", "analyze", "--method", "monte-carlo"),
    *("--trials", "100000000"),
)


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
