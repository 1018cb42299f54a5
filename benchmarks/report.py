"""How long a report takes: step by step, and the whole command with both files.

Run `python benchmarks/report.py`. The report of the paper's device with Monte Carlo at
one digit and Sobol' indices at 8 x 2048 points. Machines are noisy: each figure is the
median of several runs, in seconds of the wall and of the processor, and the ratio to
the analysis of the same run.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import budget
from budget.inputs import load_procedure
from budget.question import question_of
from budget.report.analysis.build import report_document
from budget.report.page import render_page
from budget.report.typeset import typeset
from budget.studies.evidence import gather_evidence

RUNS = 5
SAMPLES = 2048


@dataclass
class Clock:
    """Takes the time from one step to the next."""

    wall: float = field(default_factory=perf_counter)
    processor: float = field(default_factory=process_time)

    def lap(self) -> tuple[float, float]:
        """Return the seconds since the last lap, of wall and processor."""
        before = (self.wall, self.processor)
        self.wall, self.processor = perf_counter(), process_time()
        return self.wall - before[0], self.processor - before[1]


def steps() -> dict[str, tuple[float, float]]:
    """Make one report in this process and time its steps."""
    device, procedure = budget.load_device("zhao-2019"), load_procedure(None)
    clock, taken = Clock(), {}
    result = budget.analyze(device, procedure=procedure, samples=SAMPLES)
    taken["analysis, check, indices"] = clock.lap()
    evidence = gather_evidence(question_of(result), result)
    taken["coupling, densities, what-if"] = clock.lap()
    document = report_document(
        result,
        devices=(device,),
        procedure=procedure,
        evidence=evidence,
        command_line="budget report",
        date="2026-01-01",
    )
    taken["figures and tables"] = clock.lap()
    render_page(document)
    taken["HTML"] = clock.lap()
    typeset(document)
    taken["PDF"] = clock.lap()
    return taken


def whole() -> float:
    """Return the seconds that the whole command takes as a process of its own."""
    with TemporaryDirectory() as folder:
        pages = (Path(folder) / "report.html", Path(folder) / "report.pdf")
        outputs = [word for page in pages for word in ("-o", str(page))]
        begun = perf_counter()
        subprocess.run(
            [sys.executable, "-m", "budget", "report", "--sobol", *outputs],
            check=True,
            stderr=subprocess.DEVNULL,
        )
        return perf_counter() - begun


def main() -> None:
    """Print a row for every step, and one for the command."""
    steps()  # imports
    runs = [steps() for _ in range(RUNS)]
    print(f"{'step':32} {'wall s':>8} {'cpu s':>8} {'ratio':>7}")
    base = 0.0
    for name in runs[0]:
        wall = median(run[name][0] for run in runs)
        processor = median(run[name][1] for run in runs)
        base = base or wall
        print(f"{name:32} {wall:8.2f} {processor:8.2f} {wall / base:7.2f}")
    command = median(whole() for _ in range(RUNS))
    print(
        f"{'whole command, both files':32} {command:8.2f} {'':8} {command / base:7.2f}"
    )


if __name__ == "__main__":
    main()
