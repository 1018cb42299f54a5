"""Other readings of the paper's inputs: each computed, none adopted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from budget.model.sources import GYRO
from budget.names import Name
from budget.problem import Group
from budget.studies.paper.conditions import (
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
    with_lines,
    without_nominal_angles,
)
from budget.studies.paper.findings import (
    READING_FAILS,
    READING_FITS,
    U_MEAN,
    U_SINGLE,
    Finding,
    ratio_of,
    say,
)
from budget.studies.paper.printed import RUNS, TABLE_1
from budget.studies.paper.statistics import LEVEL, Fit, fit
from budget.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.problem import Problem
    from budget.spec.records import Procedure, Sensor
    from budget.studies.paper.conditions import Conditions

FAR_APART = 30_000.0  # pause between windows, 100 correlation times [s]
PER_SAMPLE = 0.005 * DEG_PER_HOUR  # [rad/s]
ROOT_HOUR = 60.0  # [sqrt(s)]
SIX_DIGITS = 5e-6  # doubles leave about 1e-6 of eq. (4)'s residual [1]
LEFT_ON = "the angle random walk 0.005 deg/sqrt(h) left on beside it"
ONCE_A_WINDOW = "noise added once to the sum of a window, not to each of its samples"


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """One way to understand the inputs of one row of Table 1."""

    source: Name
    name: str
    runs: int
    expectation: Expectation

    @property
    def full_name(self) -> str:
        """With what the entries are taken for."""
        kind = "single run" if self.runs == 1 else f"mean over {self.runs} runs"
        return f"{self.name}, {kind}"

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Which of the twelve entries are random, shape (12,), boolean."""
        return np.array(self.expectation.u > 0.0)

    def fit(self, printed: Array, parameter: str | None = None) -> Fit:
        """Hold the entries of one parameter, or all random ones, against it."""
        if parameter is not None:
            return fit(printed, self.expectation, PLACES[parameter], runs=self.runs)
        places = self.varies
        if self.source == Name("mounting_repeatability", owner=GYRO):
            places[PLACES["bias"]] = False  # they follow from the angles, mounting.py
        return fit(printed, self.expectation, places, runs=self.runs, scatter=False)


def printed_entries(source: Name) -> Array:
    """Return the row of Table 1 of that source as numbers, shape (12,) [1]."""
    row = next(row for row in TABLE_1 if row.source == source)
    return np.array([float(text) for text in row.entries])


def readings(conditions: Conditions) -> tuple[Reading, ...]:
    """Set up every reading, each for a single run and for a mean over 25 runs."""
    gyro, procedure = conditions.gyro, conditions.printed
    size = nominal_size(gyro)
    apart = replace(procedure, gyro=replace(procedure.gyro, pause=FAR_APART))
    walk = gyro.line("angle_random_walk")
    if walk is None:
        raise ValueError("the paper's gyro has no angle random walk")
    sixtieth = _with_random_walk(gyro, walk.u / ROOT_HOUR)
    stability, noise = (
        Name("bias_stability", owner=GYRO),
        Name("angle_random_walk", owner=GYRO),
    )
    found = {
        (stability, "+ and - turns far apart, their noise independent"): expect(
            only_sources(gyro, apart, stability), size
        ),
        (stability, LEFT_ON): expect(
            only_sources(gyro, procedure, stability, noise), size
        ),
        (stability, "the angle random walk 0.005 deg/sqrt(h) in its place"): expect(
            only_sources(gyro, procedure, noise), size
        ),
        (noise, "0.005 deg/h, white in each sample at 100 Hz"): expect(
            only_sources(
                with_lines(gyro, sample_noise=PER_SAMPLE),
                procedure,
                Name("sample_noise", owner=GYRO),
            ),
            size,
        ),
        (noise, "0.005 deg/sqrt(h) converted as if it were deg/h, 60 times less"): (
            expect(only_sources(sixtieth, procedure, noise), size)
        ),
        (noise, ONCE_A_WINDOW): expect(
            _noise_once_a_window(only_sources(gyro, procedure, noise), procedure), size
        ),
        (
            Name("mounting_repeatability", owner=GYRO),
            "the nominal 2 arcsec dropped from the draws, errors counted from it",
        ): _dropped_nominal(conditions),
    }
    return tuple(
        Reading(source=source, name=name, runs=runs, expectation=expectation)
        for (source, name), expectation in found.items()
        for runs in (1, RUNS)
    )


def best_reading(all_readings: tuple[Reading, ...], source: Name) -> Reading | None:
    """Return the reading that fits a row as a whole and group by group, or None."""
    fitting = [
        reading
        for reading in all_readings
        if reading.source == source and fits_row(reading, printed_entries(source))
    ]
    return max(fitting, key=lambda r: r.fit(printed_entries(source)).p, default=None)


def fits_row(reading: Reading, printed: Array) -> bool:
    """Whether random entries fit, together and by parameter, and the rest is equal."""
    expected, fixed = reading.expectation, ~reading.varies
    equal = np.maximum(expected.resolution, SIX_DIGITS * np.abs(expected.mean))
    if np.any(np.abs(printed - expected.mean)[fixed] > equal[fixed]):
        return False
    random = [p for p, place in PLACES.items() if reading.varies[place].all()]
    together = reading.fit(printed)
    return together.fits and all(reading.fit(printed, p).fits for p in random)


def switched_on(conditions: Conditions) -> dict[tuple[Name, ...], Expectation]:
    """Expect one run with every choice of the five stated sources: 31 of them."""
    size = nominal_size(conditions.gyro)
    sources = [row.source for row in TABLE_1]
    return {
        chosen: expect(only_sources(conditions.gyro, conditions.printed, *chosen), size)
        for n in range(1, len(sources) + 1)
        for chosen in combinations(sources, n)
    }


def fitting_choices(
    choices: dict[tuple[Name, ...], Expectation], source: Name
) -> tuple[tuple[tuple[str, ...], Reading], ...]:
    """Return the choices of sources that fit a row, as one run or a mean over 25."""
    tried = (
        (chosen, Reading(source=source, name="", runs=runs, expectation=expectation))
        for chosen, expectation in choices.items()
        for runs in (1, RUNS)
    )
    printed = printed_entries(source)
    return tuple(
        (chosen, reading) for chosen, reading in tried if fits_row(reading, printed)
    )


def reading_findings(all_readings: tuple[Reading, ...]) -> tuple[Finding, ...]:
    """Return a row for each reading and parameter that varies under it."""
    findings = []
    for reading in all_readings:
        printed = printed_entries(reading.source)
        together = reading.fit(printed)
        verdict = READING_FITS if fits_row(reading, printed) else READING_FAILS
        for parameter, place in PLACES.items():
            if not reading.varies[place].all():
                continue
            found = reading.fit(printed, parameter)
            # Where the reading has a mean, deviations from it are what is random.
            rms = _rms((printed - reading.expectation.mean)[place])
            about = _rms(reading.expectation.mean[place])
            shifted = about > found.u_rms
            findings.append(
                Finding(
                    section="readings",
                    where=f"{_title(reading.source)}, {parameter.replace('_', ' ')}: "
                    f"{reading.full_name}",
                    printed=f"rms {say(rms, 3)}" + (" about -1" if shifted else ""),
                    ours=found.u_rms,
                    quantity=U_SINGLE if reading.runs == 1 else U_MEAN,
                    ratio=ratio_of(found.u_rms, rms),
                    verdict=verdict,
                    why=f"p {say(found.p)}; the whole row p {say(together.p)}, least "
                    f"allowed {LEVEL:g}",
                    p_single=found.p if reading.runs == 1 else None,
                    p_mean=None if reading.runs == 1 else found.p,
                    is_summary=True,
                )
            )
    return tuple(findings)


def _with_random_walk(gyro: Sensor, density: Array) -> Sensor:
    """Return the gyro with another density of its angle random walk [rad/sqrt(s)]."""
    lines = tuple(
        replace(line, u=density) if line.name == "angle_random_walk" else line
        for line in gyro.lines
    )
    return replace(gyro, lines=lines)


def _noise_once_a_window(problem: Problem, procedure: Procedure) -> Problem:
    """Return the problem with white noise of variance sigma^2/n^2, not sigma^2/n.

    n = f L samples in a window of length L; the inputs of each axis are three
    differences of turns and one mean of dwells, all of them uncorrelated.
    """
    (group,) = problem.groups
    turn = 2.0 * np.pi * procedure.gyro.turns / procedure.gyro.rate  # [s]
    lengths = np.tile([turn, turn, turn, procedure.gyro.dwell], 3)
    variance = np.diag(group.covariance) / (procedure.sample_rate * lengths)
    once = Group.independent(group.name, u=np.sqrt(variance))
    return replace(problem, groups=(once,))


def _dropped_nominal(conditions: Conditions) -> Expectation:
    """Expect errors of angles that are drawn about 0 and counted from 2 arcsec."""
    gyro = conditions.gyro
    found = expect(
        only_sources(
            without_nominal_angles(gyro),
            conditions.printed,
            Name("mounting_repeatability", owner=GYRO),
        ),
        nominal_size(gyro),
    )
    shift = np.zeros(12)
    shift[PLACES["mounting_angle"]] = -1.0  # (0 + draw - 2 arcsec) / 2 arcsec
    return replace(found, mean=found.mean + shift)


def _title(source: Name) -> str:
    """Name the row of Table 1 for people."""
    return f"Table 1, {source.quantity.replace('_', ' ')}"


def _rms(values: Array) -> float:
    """Return the root mean square [1]."""
    return float(np.sqrt(np.mean(values**2)))
