"""What recorded calibrations cost: a long recording, mistakes, ten thousand results.

    python benchmarks/calibrations.py [--rate HZ] [--results N]

Processor times in one run, and the largest memory.
"""

from __future__ import annotations

import argparse
import json
import resource
import tempfile
import time
from datetime import date, timedelta
from pathlib import Path

from budget.recordings.calibrate import calibrate
from budget.recordings.history import history
from budget.recordings.simulated_run import simulated_run

NAME = "zhao-2019"


def main() -> None:
    """Make a run, calibrate it sound and with a mistake, and read its history."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--rate", type=float, default=400.0, help="of sampling [Hz]")
    parser.add_argument("--results", type=int, default=10_000)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.csv"
        begun = time.process_time()
        made = simulated_run(NAME, procedure=NAME, rate=given.rate)
        with path.open("w", encoding="utf-8") as stream:
            stream.writelines(made.csv())
        say(f"simulate {made.samples:,} rows", begun)
        begun = time.process_time()
        found = calibrate(path, procedure=NAME, device=NAME)
        say("calibrate them", begun)
        wrong = simulated_run(
            NAME, procedure=NAME, rate=5.0, means=True, blunders=["earth_rate_sign"]
        )
        path.write_text("".join(wrong.csv()), encoding="utf-8")
        begun = time.process_time()
        calibrate(path, procedure=NAME, device=NAME)
        say("calibrate a table, a mistake in it", begun)
        document = found.to_dict() | {"serial": "1"}
        for k in range(given.results):
            document["date"] = (date(1990, 1, 1) + timedelta(days=k)).isoformat()
            text = json.dumps(document, indent=1)
            (Path(folder) / f"{k}.json").write_text(text, encoding="utf-8")
        begun = time.process_time()
        history(folder)
        say(f"history of {given.results:,} results", begun)
    largest = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"largest memory {largest:.0f} MB")


def say(what: str, begun: float) -> None:
    """Print what took how long."""
    print(f"{what}: {time.process_time() - begun:.2f} s")


if __name__ == "__main__":
    main()
