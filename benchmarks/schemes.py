"""What test schemes cost: a whole analysis, and trials against their floor.

Run `python benchmarks/schemes.py`. A process each for the analyses, with validation, as
the ratio to that of the paper's test in the same run; trials of every shipped scheme in
one process on one core, as the ratio to drawing the same normals and no more.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one

from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from main_job import BUDGET, run
from throughput import TRIALS, floor, trials

from budget.calibration.problem import calibration_problem
from budget.inputs import load_device, load_procedure
from budget.question import sensors_of
from budget.resources import shipped

ROUNDS = 5
# 6 dwells and 6 turns, repeated: 198 windows are 144 and 54.
MANY = """name: many windows
latitude: 34 deg
estimator: {estimator}
windows:
  - {{face: all, dwell: 60 s, repeat: {dwells}}}
  - windows:
      - {{face: z up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}}
      - {{face: x up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}}
      - {{face: y up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}}
    repeat: {turns}
"""


def analyses(folder: Path) -> None:
    """Print how long whole commands take."""
    jobs = {"the paper's test": [*BUDGET, "analyze"]}
    for estimator, dwells, turns in (
        ("least_squares", 24, 9),
        ("weighted", 24, 9),
        ("least_squares", 1125, 375),
    ):
        name = f"{6 * (dwells + turns)} windows, {estimator}"
        path = folder / f"{name}.yaml"
        path.write_text(MANY.format(estimator=estimator, dwells=dwells, turns=turns))
        jobs[name] = [*BUDGET, "analyze", "--procedure", str(path)]
    times: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(ROUNDS):  # in turn, so that ratios hold where the speed drifts
        for name, job in jobs.items():
            times[name].append(run(job)[0])
    base = median(times["the paper's test"])
    for name, found in times.items():
        print(f"{name:46} {median(found):8.3f} s {median(found) / base:7.2f}")


def throughput() -> None:
    """Print trials against the floor of their normals, scheme by scheme."""
    device = load_device("zhao-2019")
    for path in sorted((shipped("specs") / "procedures").glob("*.yaml")):
        procedure = load_procedure(path.stem)
        sensors = sensors_of([device], procedure)
        problem = calibration_problem(sensors, procedure)
        ratios = []
        for _ in range(3):
            bare = floor(problem)
            ratios.append(trials(problem, TRIALS)[0] / bare)
        normals = problem.normals_per_trial
        print(f"{path.stem:40} {normals:4} normals {median(ratios):7.2f} of the floor")


if __name__ == "__main__":
    with TemporaryDirectory() as name:
        analyses(Path(name))
    throughput()
