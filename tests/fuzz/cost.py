"""Check files in a process of its own; print what each cost, a line of JSON each.

    python tests/fuzz/cost.py FILE...

Seconds are those of the check alone, the best of three where the first is slow,
because a busy machine only ever adds. Bytes are the most that the process has held so
far, Python, imports and the files before included: more than the one file needs.
"""

from __future__ import annotations

import json
import re
import sys
import time
from pathlib import Path

from budget.errors import SpecError
from budget.spec import validate

QUICK = 0.2  # [s] that no bound is near to


def check(name):
    """Return how long the check of a file takes and how many issues it has."""
    begun = time.perf_counter()
    try:
        validate(name)
        issues = 0
    except SpecError as error:
        issues = len(error.issues)
    return time.perf_counter() - begun, issues


def peak():
    """Return the most memory that this program has held [byte].

    The kernel's ru_maxrss would count what its parent held when it was started.
    """
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return int(re.search(r"VmHWM:\s+(\d+) kB", status)[1]) * 1024


def main():
    """Check the files named on the command line."""
    validate("zhao-2019")  # the imports and the units are no part of the check
    for name in sys.argv[1:]:
        seconds, issues = check(name)
        if seconds > QUICK:
            seconds = min(seconds, check(name)[0], check(name)[0])
        cost = {"file": name, "seconds": seconds, "bytes": peak(), "issues": issues}
        sys.stdout.write(f"{json.dumps(cost)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
