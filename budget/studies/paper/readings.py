"""Readings of Table 1: what the inputs of a row may mean, held against its entries."""

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
    value_of,
    with_lines,
    without_nominal_angles,
)
from budget.studies.paper.findings import (
    RUNS,
    U_MEAN,
    U_SINGLE,
    Finding,
    Verdict,
    ratio_of,
    say,
    words,
)
from budget.studies.paper.statistics import LEVEL, Fit, fit
from budget.units import DEG_PER_HOUR

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.problem import Problem
    from budget.spec.records import Procedure
    from budget.studies.paper.conditions import Conditions
    from budget.studies.paper.printed import GivenReading

SIX_DIGITS = 5e-6  # doubles leave about 1e-6 of eq. (4)'s residual [1]
STABILITY = Name("bias_stability", owner=GYRO)
WALK = Name("angle_random_walk", owner=GYRO)
MOUNTING = Name("mounting_repeatability", owner=GYRO)


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """One way to understand the inputs of one row of Table 1, and its entries.

    Attributes
    ----------
    source : Name
        Of the row.
    name : str
        What is read so; '' for the inputs as stated.
    sources : tuple of Name
        What varies under it.
    printed : ndarray, shape (12,)
        Entries of the row [1].
    expectation : Expectation
        Of one run.
    runs : int
        How many runs each entry is a mean over; 1 for a single run.
    """

    source: Name
    name: str = ""
    sources: tuple[Name, ...]
    printed: Array
    expectation: Expectation
    runs: int = 1

    @property
    def of_mean(self) -> Reading:
        """The same of a mean over 25 runs."""
        return replace(self, runs=RUNS)

    @property
    def full_name(self) -> str:
        """With what the entries are taken for."""
        kind = "single run" if self.runs == 1 else f"mean over {self.runs} runs"
        return f"{self.name}, {kind}"

    @property
    def quantity(self) -> str:
        """What the standard uncertainty of an entry is: of a run or of a mean."""
        return U_SINGLE if self.runs == 1 else U_MEAN

    @property
    def u(self) -> Array:
        """Standard uncertainties of the entries, shape (12,) [1]."""
        return np.asarray(self.expectation.u / np.sqrt(self.runs))

    @property
    def varies(self) -> NDArray[np.bool_]:
        """Which of the twelve entries are random, shape (12,), boolean."""
        return np.array(self.expectation.u > 0.0)

    def is_random(self, parameter: str) -> bool:
        """Whether the entries of that parameter vary from run to run."""
        return bool(self.varies[PLACES[parameter]].all())

    def fit(self, parameter: str | None = None) -> Fit:
        """Hold the entries of one parameter, or all random ones jointly, against it."""
        if parameter is not None:
            place = PLACES[parameter]
            return fit(self.printed, self.expectation, place, runs=self.runs)
        places = self.varies
        if self.source == MOUNTING:
            places[PLACES["bias"]] = False  # they follow from the angles, mounting.py
        return fit(
            self.printed, self.expectation, places, runs=self.runs, scatter=False
        )

    @property
    def fits_row(self) -> bool:
        """Whether random entries fit, together and by parameter, and others agree."""
        expected, fixed = self.expectation, ~self.varies
        equal = np.maximum(expected.resolution, SIX_DIGITS * np.abs(expected.mean))
        if np.any(np.abs(self.printed - expected.mean)[fixed] > equal[fixed]):
            return False
        return self.fit().fits and all(
            self.fit(parameter).fits
            for parameter in PLACES
            if self.is_random(parameter)
        )


def as_stated(
    conditions: Conditions, row: str, sources: tuple[Name, ...] = ()
) -> Reading:
    """Read a row as the paper states its inputs, or with other sources on."""
    source = Name(row, owner=GYRO)
    sources = sources or (source,)
    gyro = conditions.gyro
    problem = only_sources(gyro, conditions.printed, *sources)
    return Reading(
        source=source,
        sources=sources,
        printed=np.array([float(text) for text in conditions.paper.entries(row)]),
        expectation=expect(problem, nominal_size(gyro)),
    )


def readings(conditions: Conditions) -> tuple[Reading, ...]:
    """Set up every other reading, each for a single run and for a mean over 25 runs."""
    single = [
        replace(
            as_stated(conditions, given.row),
            name=given.name,
            sources=_names(given),
            expectation=_expect(given, conditions),
        )
        for given in conditions.paper.readings
    ]
    return tuple(one for reading in single for one in (reading, reading.of_mean))


def best_reading(all_readings: tuple[Reading, ...], source: Name) -> Reading | None:
    """Return the reading that fits a row as a whole and group by group, or None."""
    fitting = [r for r in all_readings if r.source == source and r.fits_row]
    return max(fitting, key=lambda reading: reading.fit().p, default=None)


def switched_on(conditions: Conditions) -> dict[tuple[Name, ...], Expectation]:
    """Expect one run with every choice of the five stated sources: 31 of them."""
    rows = list(conditions.paper.table_1)
    sources = [Name(row, owner=GYRO) for row in rows]
    return {
        chosen: as_stated(conditions, rows[0], chosen).expectation
        for n in range(1, len(sources) + 1)
        for chosen in combinations(sources, n)
    }


def fitting_choices(
    choices: dict[tuple[Name, ...], Expectation], stated: Reading
) -> tuple[Reading, ...]:
    """Return the choices of sources that fit a row, as one run or a mean over 25."""
    return tuple(
        reading
        for chosen, expectation in choices.items()
        for runs in (1, RUNS)
        if (
            reading := replace(
                stated, sources=chosen, expectation=expectation, runs=runs
            )
        ).fits_row
    )


def reading_findings(all_readings: tuple[Reading, ...]) -> tuple[Finding, ...]:
    """Return a row for each reading and parameter that varies under it."""
    findings = []
    for reading in all_readings:
        together, is_single = reading.fit(), reading.runs == 1
        verdict = Verdict.READING_FITS if reading.fits_row else Verdict.READING_FAILS
        for parameter in filter(reading.is_random, PLACES):
            place, found = PLACES[parameter], reading.fit(parameter)
            # Where the reading has a mean, deviations from it are what is random.
            rms = root_mean_square((reading.printed - reading.expectation.mean)[place])
            shifted = root_mean_square(reading.expectation.mean[place]) > found.u_rms
            findings.append(
                Finding(
                    section="readings",
                    where=f"Table 1, {words(reading.source.quantity)}, "
                    f"{words(parameter)}: {reading.full_name}",
                    printed=f"rms {say(rms, 3)}" + (" about -1" if shifted else ""),
                    ours=found.u_rms,
                    quantity=reading.quantity,
                    ratio=ratio_of(found.u_rms, rms),
                    verdict=verdict,
                    why=f"p {say(found.p)}; the whole row p {say(together.p)}, least "
                    f"allowed {LEVEL:g}",
                    p_single=found.p if is_single else None,
                    p_mean=None if is_single else found.p,
                    is_summary=True,
                )
            )
    return tuple(findings)


def root_mean_square(values: Array) -> float:
    """Return the root mean square [1]."""
    return float(np.sqrt(np.mean(values**2)))


def _names(given: GivenReading) -> tuple[Name, ...]:
    """Return what varies under a reading."""
    return tuple(Name(source, owner=GYRO) for source in given.sources)


def _expect(given: GivenReading, conditions: Conditions) -> Expectation:
    """Expect one run with what a reading changes."""
    gyro, procedure = conditions.gyro, conditions.printed
    if given.pause is not None:
        procedure = replace(procedure, gyro=replace(procedure.gyro, pause=given.pause))
    if given.sample_noise is not None:
        gyro = with_lines(gyro, sample_noise=given.sample_noise * DEG_PER_HOUR)
    walk = value_of(gyro, WALK.quantity) / given.divisor
    gyro = with_lines(gyro, angle_random_walk=walk)
    if given.about_zero:
        gyro = without_nominal_angles(gyro)
    problem = only_sources(gyro, procedure, *_names(given))
    if given.once_a_window:
        problem = _noise_once_a_window(problem, procedure)
    found = expect(problem, nominal_size(conditions.gyro))
    if not given.about_zero:
        return found
    shift = np.zeros(12)
    shift[PLACES["mounting_angle"]] = -1.0  # (0 + draw - 2 arcsec) / 2 arcsec
    return replace(found, mean=found.mean + shift)


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
