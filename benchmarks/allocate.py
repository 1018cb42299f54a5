"""How long an allocation takes: 24 outputs, 14 sources, every strategy.

Run `python benchmarks/allocate.py`. After start-up: set up the law, solve both
sensors; target 0.2 s. Monte Carlo and the catalogue come on top in the command and are
timed apart.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core means one

from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from budget.inputs import load_device, load_procedure, load_requirement
from budget.question import Question
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.cases import (
    NO_BOUNDS,
    STRATEGIES,
    resize,
    set_up,
    solve,
)
from budget.studies.allocation.market import load_catalogue

if TYPE_CHECKING:
    from budget.inputs.records import Sensor

TARGET = 0.2  # [s]
REPEATS = 5


def with_more(sensor: Sensor, names: tuple[str, ...]) -> Sensor:
    """Return a sensor with more scale-factor lines, like its repeatability."""
    first = sensor.line("scale_factor_repeatability")
    if first is None:
        raise SystemExit("the built-in device has no scale-factor repeatability")
    lines = tuple(replace(first, name=name) for name in names)
    return replace(sensor, lines=(*sensor.lines, *lines))


def main() -> None:
    """Print seconds a solve by strategy, then those of the whole study."""
    device = load_device("zhao-2019")
    wanted, procedure = load_requirement("navigation-grade"), load_procedure()
    names = ("scale_factor_nonlinearity", "scale_factor_asymmetry")
    whole = Question.of(device, procedure=procedure, requirement=wanted)
    whole = whole.with_sensors(with_more(one, names) for one in device.sensors)
    sensors = whole.sensors
    print(f"{sum(len(sensor.lines) for sensor in sensors)} sources, 24 outputs")
    for strategy in STRATEGIES:
        times = []
        for _ in range(REPEATS):
            begun = perf_counter()
            for sensor in sensors:
                case = set_up(whole.alone(sensor.kind), NO_BOUNDS, {})
                if case is None:
                    raise SystemExit("the requirement has no limits")
                solved = solve(case, strategy, None)
                resize(sensor, case.task.law.sources, solved.factors)
            times.append(perf_counter() - begun)
        # The first one still imports scipy.optimize: start-up.
        seconds = float(np.median(times[1:]))
        print(f"{strategy:14} {seconds:.4f} s a solve (target {TARGET})")
    begun = perf_counter()
    catalogue, _ = load_catalogue()
    print(f"catalogue      {perf_counter() - begun:.2f} s")
    begun = perf_counter()
    allocate(device, requirement=wanted, strategy="cost", catalogue=catalogue)
    print(f"whole study    {perf_counter() - begun:.2f} s, all of it")


if __name__ == "__main__":
    main()
