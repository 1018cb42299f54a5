"""How long the check of a file takes: the dearest files that the tests count calls of.

Run `python benchmarks/reader.py`; target 1 s. Each figure is the best of three in one
process, after the imports.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from fuzz.test_cost import cases

from budget.errors import SpecError
from budget.inputs import validate

TARGET = 1.0  # [s]
REPEATS = 3
SHOWN = 10


def seconds(path: Path) -> float:
    """Return how long one check of a file works [s]."""
    begun = process_time()
    with suppress(SpecError):
        validate(str(path))
    return process_time() - begun


def main() -> None:
    """Print the dearest files."""
    validate("zhao-2019")  # the imports and the units are no part of the check
    times = {}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "case.yaml"
        for case, text in cases().items():
            path.write_text(text, encoding="utf-8", newline="")
            times[case] = min(seconds(path) for _ in range(REPEATS))
    for case in sorted(times, key=times.__getitem__, reverse=True)[:SHOWN]:
        print(f"{case:40} {times[case]:6.3f} s (target {TARGET:g} s)")


if __name__ == "__main__":
    main()
