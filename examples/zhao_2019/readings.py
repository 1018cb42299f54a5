"""Readings of Table 1: what the inputs of a row may mean, and how well that fits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtr, chdtrc, erfc, ndtr

from budget.model.sources import GYRO
from budget.names import Name
from budget.problem import Group
from budget.sentences import sentence
from budget.units import DEG_PER_HOUR
from zhao_2019.conditions import (
    PLACES,
    Expectation,
    expect,
    nominal_size,
    only_sources,
    value_of,
    with_lines,
    without_nominal_angles,
)
from zhao_2019.printed import RUNS, U_MEAN, U_SINGLE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.inputs.fields import Keyed
    from budget.inputs.records import Procedure
    from budget.problem import Problem
    from zhao_2019.conditions import Conditions

LEVEL = 0.01  # a reading is said to fit from this p on [1]
SIX_DIGITS = 5e-6  # doubles leave about 1e-6 of eq. (4)'s residual [1]
STABILITY = Name("bias_stability", owner=GYRO)
WALK = Name("angle_random_walk", owner=GYRO)
MOUNTING = Name("mounting_repeatability", owner=GYRO)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """Printed entries against an expectation."""

    chi_square: float  # deviations squared in the metric of their joint covariance [1]
    entries: int  # its degrees of freedom
    # Two-sided: twice the smaller tail; too good a fit counts as well. Where the
    # scatter about a common shift was tested too, twice the smaller of both p [1].
    p: float
    p_entries: Array  # two-sided normal p of each entry by itself [1]
    u_rms: float  # root mean square of the standard uncertainties [1]

    @property
    def fits(self) -> bool:
        """Whether the entries may well be such."""
        return self.p >= LEVEL


def fit(
    printed: Array,
    expectation: Expectation,
    places: slice | NDArray[np.bool_],
    *,
    runs: int,
    scatter: bool = True,
) -> Fit:
    """Hold printed relative errors [1] against the mean over `runs` runs, or one.

    All entries at `places` of the twelve must vary. Where `scatter`, that about a
    common shift is tested too: six entries near -1 have the sum of squares of six
    draws with u = 1, but not their scatter.
    """
    deviation = (printed - expectation.mean)[places]
    C = expectation.covariance[places][:, places] / runs
    u = np.sqrt(np.diag(C))
    # Scaled first: scale factors and angles differ by a factor of 1e5.
    z = deviation / u
    one = np.ones_like(z)
    weighted = np.linalg.solve(C / np.outer(u, u), np.stack([z, one], axis=1))
    chi_square = float(z @ weighted[:, 0])
    p = two_sided(chi_square, z.size)
    if scatter:
        about = chi_square - float(one @ weighted[:, 0]) ** 2 / float(
            one @ weighted[:, 1]
        )
        p = min(1.0, 2.0 * min(p, two_sided(about, z.size - 1)))
    return Fit(
        chi_square=chi_square,
        entries=z.size,
        p=p,
        p_entries=erfc(np.abs(z) / np.sqrt(2.0)),
        u_rms=float(np.sqrt(np.mean(u**2))),
    )


def two_sided(chi_square: float, entries: int) -> float:
    """Return twice the smaller tail of chi-square: too good counts as well [1]."""
    tails = chdtr(entries, chi_square), chdtrc(entries, chi_square)
    return float(min(1.0, 2.0 * min(tails)))


def order_probability(
    order: str, expectation: Expectation, places: slice, *, runs: int
) -> float:
    """Return the probability that the largest entry has that power of ten [1].

    10^k <= max |entry| < 10^(k+1): so the paper's text reads its own Table 1. Entries
    are taken as independent; their correlations are 0.2 at the most.
    """
    mean, u = expectation.mean[places], expectation.u[places] / np.sqrt(runs)

    def below(bound: float) -> float:
        inside = ndtr((bound - mean) / u) - ndtr((-bound - mean) / u)
        return float(np.prod(inside))

    return below(10.0 * float(order)) - below(float(order))


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """One way to understand the inputs of one row of Table 1, and its entries."""

    source: Name  # of the row
    name: str = ""  # what is read so; '' for the inputs as stated
    sources: tuple[Name, ...]  # what varies under it
    texts: tuple[str, ...]  # the twelve entries of the row as printed
    printed: Array  # their values, shape (12,) [1]
    expectation: Expectation  # of one run
    runs: int = 1  # how many runs each entry is a mean over; 1 for a single run

    @property
    def of_mean(self) -> Reading:
        """The same of a mean over 25 runs."""
        return replace(self, runs=RUNS)

    @property
    def full_name(self) -> str:
        """With what the entries are taken for."""
        if self.runs == 1:
            return sentence("paper_words.single_run", name=self.name)
        return sentence("paper_words.mean", name=self.name, runs=self.runs)

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
            places[PLACES["bias"]] = False  # they follow from the angles, table1.py
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
    gyro, texts = conditions.gyro, conditions.paper.entries(row)
    problem = only_sources(gyro, conditions.printed, *sources)
    return Reading(
        source=source,
        sources=sources,
        texts=texts,
        printed=np.array([float(text) for text in texts]),
        expectation=expect(problem, nominal_size(gyro)),
    )


def readings(conditions: Conditions) -> tuple[Reading, ...]:
    """Set up every other reading, each for a single run and for a mean over 25 runs."""
    single = [
        replace(
            as_stated(conditions, given.row),
            name=given.name,
            sources=tuple(Name(source, owner=GYRO) for source in given.sources),
            expectation=_expect(given, conditions),
        )
        for given in conditions.paper.readings
    ]
    return tuple(one for reading in single for one in (reading, reading.of_mean))


def best_reading(all_readings: tuple[Reading, ...], source: Name) -> Reading | None:
    """Return the reading that fits a row as a whole and group by group, or None."""
    fitting = [r for r in all_readings if r.source == source and r.fits_row]
    return max(fitting, key=lambda reading: reading.fit().p, default=None)


def _expect(given: Keyed, conditions: Conditions) -> Expectation:
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
    sources = (Name(source, owner=GYRO) for source in given.sources)
    problem = only_sources(gyro, procedure, *sources)
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
