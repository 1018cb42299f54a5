"""What a result costs by devices, windows, sources, outputs and trials: table, figure.

Run `python benchmarks/performance.py [--against TREE] [--rounds N] [--docs]`. All is
time of one processor, its own and that of the children, the median of several rounds:
others may use the machine. Beside it stands how many normals the same core draws in
the same round. With another tree both are measured in turn, and their ratio is that of
the same rounds. `--docs` writes the table and the figure of docs/performance.md.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as a user starts it

import argparse
import json
import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from statistics import median
from time import process_time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"
GIVEN = ROOT / "tests" / "guard" / "inputs"
ROUNDS = 5
NORMALS = 4096 * 48 * 100
WANTED = """\
name: cost
environment: none
limits:
  gyro: {scale_factor: 700 ppm, mounting_angle: 60 arcsec, bias: 10 deg/h}
  accelerometer: {scale_factor: 900 ppm, mounting_angle: 150 arcsec, bias: 2 mg}
"""
LED = """\
name: cost on a mission
environment: none
reference: next_turn_on
limits:
  gyro: {scale_factor: 20 ppm, mounting_angle: 5 arcsec, bias: 0.02 deg/h}
  accelerometer: {scale_factor: 60 ppm, mounting_angle: 5 arcsec, bias: 80 ug}
  mission: {position: {horizontal: 1 nmi, at: 1 h, probability: 50 %}}
"""
COMMANDS = {
    "`report`, HTML": ("report", "-o", "r.html"),
    "`report --sobol`, HTML and PDF": (
        *("report", "--sobol", "-o", "r.html", "-o", "r.pdf"),
    ),
    "`report --mission bench --allocate`": (
        *("report", "zhao-2019", "--requirement", "led.yaml", "--mission", "bench"),
        *("--allocate", "--no-validate", "-o", "r.html"),
    ),
    "`allocate` by norm and turns": (
        *("allocate", f"{GIVEN}/imu.yaml", "--requirement", f"{GIVEN}/bench.yaml"),
        *("--no-validate", "--procedure", "norm-and-turns-by-hand"),
    ),
}
FLOORS = {
    "Monte Carlo, over the floor of its normals": (None, ("gyro", "accelerometer")),
    "the same, estimator `norm`": ("norm-eighteen-positions", ("accelerometer",)),
}


def yardstick() -> float:
    """Return how many million normals this core draws in a second."""
    import numpy as np

    rng = np.random.Generator(np.random.SFC64(1))
    block = np.empty((48, 4096))
    begun = process_time()
    for _ in range(100):
        rng.standard_normal(out=block)
    return NORMALS / (process_time() - begun) / 1e6


def sizes() -> Iterator[tuple[str, int, Callable[[], object]]]:
    """Yield what the cost is measured against: its name, its size, what is done."""
    import budget
    from budget.calibration.problem import calibration_problem
    from budget.inputs import load_catalogue, load_procedure

    sensors = budget.load_device("zhao-2019").sensors
    every = load_catalogue()
    both = [one for one in every if len(one.sensors) > 1][:16]
    wanted = Path("wanted.yaml")
    for n in (2, 4, 8, 16):
        yield (
            "devices",
            n,
            lambda n=n: budget.compare(both[:n], wanted, method="gum"),
        )
    test = load_procedure("twenty-four-positions")
    span = max(one.start + one.length for one in test.windows) + 60.0
    for times in (1, 4, 16):
        windows = tuple(
            replace(one, start=one.start + k * span, name=f"{one.name}, {k}")
            for k in range(times)
            for one in test.windows
        )
        longer = replace(test, windows=windows)
        yield (
            "windows",
            len(windows),
            lambda longer=longer: budget.propagate(
                calibration_problem(sensors, longer)
            ),
        )
    paper = load_procedure(None)
    for n in (1, 2, 4):
        fewer = tuple(replace(one, lines=one.lines[:n]) for one in sensors)
        yield (
            "sources",
            sum(len(one.lines) for one in fewer),
            lambda fewer=fewer: budget.propagate(calibration_problem(fewer, paper)),
        )
    names = [output.name for output in calibration_problem(sensors, paper).outputs]
    for n in (3, 6, 12, 24):
        yield (
            "outputs",
            n,
            lambda n=n: budget.propagate(
                calibration_problem(sensors, paper, outputs=names[:n])
            ),
        )
    problem = calibration_problem(sensors, paper)
    for n in (10_000, 100_000, 1_000_000):
        yield "trials", n, lambda n=n: budget.sample(problem, trials=n)


def fresh() -> None:
    """Forget functions and derivatives of calibrations, where a tree keeps any."""
    from budget.calibration import problem
    from budget.methods import gum

    if hasattr(problem, "_frame"):
        problem._frame.cache_clear()  # noqa: SLF001
    getattr(gum, "_KEPT", {}).clear()


def spent(done: Callable[[], object]) -> float:
    """Return the processor time of something done once before, kept short [s]."""
    taken, times = 0.0, 0
    while taken < 0.2 and times < 20:  # noqa: PLR2004
        fresh()
        begun = process_time()
        done()
        taken, times = taken + process_time() - begun, times + 1
    return taken / times


def of_command(words: tuple[str, ...]) -> float:
    """Return the processor time of a command, its start included [s]."""
    process = subprocess.Popen(
        [sys.executable, "-m", "budget", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"budget {' '.join(words)} failed")
    return usage.ru_utime


def over_the_floor(name: str | None, kinds: tuple[str, ...]) -> float:
    """Return what a fixed run of Monte Carlo takes over drawing its normals [1]."""
    import numpy as np

    import budget
    from budget.calibration.problem import calibration_problem
    from budget.inputs import load_procedure
    from budget.methods.execution import BLOCK

    every = budget.load_device("zhao-2019").sensors
    sensors = tuple(one for one in every if one.kind in kinds)
    problem = calibration_problem(sensors, load_procedure(name))
    rng, taken = np.random.Generator(np.random.SFC64(1)), []
    block = np.empty((problem.normals_per_trial, BLOCK))
    for _ in range(3):
        begun = process_time()
        for _ in range(60):
            rng.standard_normal(out=block)
        drawn = process_time()
        budget.sample(problem, trials=60 * BLOCK)
        taken.append((process_time() - drawn) / (drawn - begun))
    return min(taken)


def measure() -> dict[str, float]:
    """Return one round of this tree, by row."""
    found = {"yardstick": yardstick()}
    found |= {name: of_command(words) for name, words in COMMANDS.items()}
    found |= {name: over_the_floor(*what) for name, what in FLOORS.items()}
    for kind, size, done in sizes():
        done()  # imports, and what is kept
        found[f"{kind} {size}"] = spent(done)
    return found


def round_of(tree: Path) -> dict[str, float]:
    """Return one round of a tree, in a process of its own."""
    folders = os.pathsep.join(map(str, (tree, tree / "examples")))
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("wanted.yaml", WANTED), ("led.yaml", LED)):
            (Path(folder) / name).write_text(text, encoding="utf-8")
        made = subprocess.run(
            [sys.executable, __file__, "--measure"],
            env={**os.environ, "PYTHONPATH": folders},
            cwd=folder,
            check=True,
            capture_output=True,
            text=True,
        )
    return json.loads(made.stdout)


def table(rounds: dict[str, list[dict[str, float]]]) -> str:
    """Return the rows as Markdown: of each tree, and of the first over the last."""
    trees = [*rounds]
    heads = [*trees, *(["ratio [1]"] if trees[1:] else [])]
    lines = [f"| what | {' | '.join(heads)} |", "|---|" + "---:|" * len(heads)]
    for row in rounds[trees[0]][0]:
        each = [median(one[row] for one in rounds[tree]) for tree in trees]
        cells = [f"{one:.3g}" for one in each]
        if trees[1:]:
            pairs = zip(rounds[trees[0]], rounds[trees[-1]], strict=True)
            cells.append(f"{median(a[row] / b[row] for a, b in pairs):.2f}")
        unit = "1e6/s" if row == "yardstick" else "1" if row in FLOORS else "s"
        name = "normals drawn by this core" if row == "yardstick" else row
        name += f" [{unit}]"
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def draw(rounds: dict[str, list[dict[str, float]]]) -> str:
    """Return the costs against the sizes as SVG: a panel each, a line for each tree."""
    from matplotlib.figure import Figure

    from budget.report.figures.style import BLUE, MUTED, to_svg

    kinds: dict[str, list[int]] = {}
    for row in rounds[next(iter(rounds))][0]:
        if found := re.fullmatch(r"(\w+) (\d+)", row):
            kinds.setdefault(found[1], []).append(int(found[2]))
    figure = Figure(figsize=(7.2, 2.2), layout="constrained")
    every = figure.subplots(1, len(kinds), sharey=True)
    for axes, (kind, each) in zip(every, kinds.items(), strict=True):
        for tree, colour in zip(rounds, (MUTED, BLUE)[-len(rounds) :], strict=True):
            cost = [median(one[f"{kind} {n}"] for one in rounds[tree]) for n in each]
            axes.loglog(each, cost, "o-", ms=3, color=colour, label=tree)
        axes.set_xlabel(kind)
    every[0].set_ylabel("processor time [s]")
    every[0].legend(frameon=False)
    return to_svg(figure, name="performance")


def main() -> None:
    """Measure in turn, print the table; write it and the figure where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, help="another tree, measured in turn")
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure:
        sys.stdout.write(json.dumps(measure()))
        return
    trees = {"before": asked.against} if asked.against else {}
    trees["now"] = ROOT
    rounds: dict[str, list[dict[str, float]]] = {name: [] for name in trees}
    for _ in range(asked.rounds):
        for name, tree in trees.items():
            rounds[name].append(round_of(tree))
    text = table(rounds)
    print(text)
    if asked.docs:
        page = DOCS / "performance.md"
        page.write_text(
            re.sub(
                r"(?ms)^\| what .*?\n(?=\n|\Z)",
                lambda _: text + "\n",
                page.read_text(encoding="utf-8"),
            ),
            encoding="utf-8",
        )
        (DOCS / "performance.svg").write_text(draw(rounds), encoding="utf-8")


if __name__ == "__main__":
    main()
