"""Check files in a process of its own; print what each cost, a line of JSON each.

    python tests/fuzz/cost.py FILE...

Steps are the calls of functions, those written in C included, that a check makes: the
same on every machine, however busy, where seconds are not. Bytes are the most that the
process has held so far, Python, imports and the files before included: more than the
one file needs. `python benchmarks/reader.py` tells the seconds.
"""

from __future__ import annotations

import json
import re
import sys
from cProfile import Profile
from pathlib import Path

from budget.errors import SpecError
from budget.inputs import validate


def check(name):
    """Return how many issues a file has."""
    try:
        validate(name)
    except SpecError as error:
        return len(error.issues)
    return 0


def steps(work):
    """Return how many calls of functions some work makes, and what it returns."""
    profile = Profile()
    result = profile.runcall(work)
    return sum(entry.callcount for entry in profile.getstats()), result


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
        count, issues = steps(lambda name=name: check(name))
        cost = {"file": name, "steps": count, "bytes": peak(), "issues": issues}
        sys.stdout.write(f"{json.dumps(cost)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
