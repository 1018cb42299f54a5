"""Lines of a data sheet as error sources: random constants and noise processes."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.distributions import NORMAL
from budget.physics.noise import GaussMarkov, Process, RandomWalk, White
from budget.problem import Group

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.physics.schedule import Schedule
    from budget.spec.records import ErrorLine, Sensor

# Random constants that take a new value at each turn-on; the others are properties of
# the device and stay.
NEW_AT_TURN_ON = (
    "bias_repeatability",
    "scale_factor_repeatability",
    "mounting_repeatability",
)
CONSTANTS = (
    *NEW_AT_TURN_ON,
    "scale_factor_nonlinearity",
    "scale_factor_asymmetry",
)
# Statistics of window averages that every triad uses: three differences and one mean.
BASIC = 4
REFERENCES = ("nominal", "as_tested", "next_turn_on")


@dataclass(frozen=True, kw_only=True)
class SourceRows:
    """Where each source of one triad stands among the rows of its inputs.

    A constant has one row an axis (or angle); under the reference `next_turn_on` the
    rows of the later turn-on follow. A process has one row for each statistic of its
    window averages: axis after axis the BASIC ones, then axis after axis the others,
    so that asymmetry, which needs more of them, moves no draws of the first.
    """

    constants: tuple[tuple[str, slice], ...]
    later: tuple[tuple[str, slice], ...]
    processes: tuple[slice, ...]
    statistics: int

    def constant(self, x: Array, name: str) -> Array:
        """Return the values of a constant, shape (3 or 6, trials); 0 if not given."""
        return _rows(x, self.constants, name)

    def departure(self, x: Array, name: str, reference: str) -> Array:
        """Return true value minus reference value of a constant, same shape.

        The reference holds 0 (nominal), the value itself (as_tested), or, for what is
        new at each turn-on, an independent draw (next_turn_on).
        """
        own = _rows(x, self.constants, name)
        stays = name not in NEW_AT_TURN_ON
        if reference == "as_tested" or (reference == "next_turn_on" and stays):
            return np.zeros_like(own)
        if reference == "next_turn_on":
            return np.asarray(own - _rows(x, self.later, name))
        return own

    def scale_factor_departure(self, x: Array, reference: str) -> Array:
        """Return (K true - K reference) / K reference, shape (3, trials) [1].

        K = K0 (1 + repeatability + nonlinearity), Zhao 2019, eq. (14); with asymmetry
        that is the mean of K(+) and K(-), eq. (15).
        """
        k = self.departure(x, "scale_factor_repeatability", reference)
        k = k + self.departure(x, "scale_factor_nonlinearity", reference)
        if reference != "next_turn_on":
            return k  # K reference is K0, or K itself and k is 0
        k_next = _rows(x, self.later, "scale_factor_repeatability")
        k_next = k_next + _rows(x, self.constants, "scale_factor_nonlinearity")
        return np.asarray(k / (1.0 + k_next))

    def noise(self, x: Array) -> Array:
        """Return the sum of all processes, shape (3, statistics, trials)."""
        more = self.statistics - BASIC
        total = np.zeros((3 * self.statistics, x.shape[1]), dtype=x.dtype)
        for rows in self.processes:
            total += x[rows]
        first = total[: 3 * BASIC].reshape(3, BASIC, -1)
        if not more:
            return first
        return np.concatenate([first, total[3 * BASIC :].reshape(3, more, -1)], axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class TriadSources:
    """The input groups of one triad, and where their rows are."""

    groups: tuple[Group, ...]
    rows: SourceRows


def error_sources(
    sensor: Sensor,
    schedule: Schedule,
    weights: Array,
    *,
    sample_rate: float,
    reference: str,
    only: frozenset[str] | None = None,
) -> TriadSources:
    """Turn the lines of one sensor into groups of inputs.

    Parameters
    ----------
    sensor : Sensor
        The lines of the data sheet.
    schedule : Schedule
        Windows of this triad.
    weights : ndarray, shape (3, statistics, n_windows)
        For each axis the sums and differences of window averages that its formulas
        use [1].
    sample_rate : float
        Of the pulses; sets the density of noise that is given per sample [Hz].
    reference : str
        One of REFERENCES.
    only : frozenset of str, optional
        Full names of the sources that count; all others are set to 0.

    Returns
    -------
    TriadSources
    """
    groups: list[Group] = []
    constants: list[tuple[str, slice]] = []
    later: list[tuple[str, slice]] = []
    processes: list[slice] = []
    row = 0
    for line in sensor.lines:
        name = f"{sensor.kind}.{line.name}"
        counts = only is None or name in only
        if line.name in CONSTANTS:
            twice = reference == "next_turn_on" and line.name in NEW_AT_TURN_ON
            group = _constant_group(name, line, counts=counts, turn_ons=1 + twice)
            n = line.u.size
            constants.append((line.name, slice(row, row + n)))
            if twice:
                later.append((line.name, slice(row + n, row + 2 * n)))
        else:
            group = _process_group(
                name, line, schedule, weights, sample_rate, counts=counts
            )
            processes.append(slice(row, row + group.size))
        groups.append(group)
        row += group.size
    return TriadSources(
        groups=tuple(groups),
        rows=SourceRows(
            constants=tuple(constants),
            later=tuple(later),
            processes=tuple(processes),
            statistics=weights.shape[1],
        ),
    )


def process_of(line: ErrorLine, axis: int, sample_rate: float) -> Process:
    """Return the noise process that a line means for one axis."""
    size = float(line.u[axis])
    if line.name == "bias_stability":
        if line.correlation_time is None:
            raise ValueError(f"{line.name} without a correlation time")
        return GaussMarkov(size, float(line.correlation_time[axis]))
    if line.name == "sample_noise":
        return White(size / sqrt(sample_rate))  # variance sigma^2 / (f L)
    if line.name in {"rate_random_walk", "acceleration_random_walk"}:
        return RandomWalk(size)
    return White(size)  # angle_random_walk, velocity_random_walk


def _constant_group(
    name: str, line: ErrorLine, *, counts: bool, turn_ons: int
) -> Group:
    """Make the group of a random constant, one set of inputs for each turn-on."""
    return Group.independent(
        name,
        u=np.tile(line.u * counts, turn_ons),
        distribution=line.distributions * turn_ons,
    )


def _process_group(
    name: str,
    line: ErrorLine,
    schedule: Schedule,
    weights: Array,
    sample_rate: float,
    *,
    counts: bool,
) -> Group:
    """Make the group of a noise process: its statistics, correlated within an axis."""
    n_axes, statistics, _ = weights.shape
    n = n_axes * statistics
    covariance = np.zeros((n, n))
    for axis in range(n_axes if counts else 0):
        process = process_of(line, axis, sample_rate)
        more = statistics - BASIC
        rows = np.r_[
            axis * BASIC : (axis + 1) * BASIC,
            n_axes * BASIC + axis * more : n_axes * BASIC + (axis + 1) * more,
        ]
        covariance[np.ix_(rows, rows)] = process.reduce(schedule, weights[axis])
    return Group(
        name=name,
        mean=np.zeros(n),
        covariance=covariance,
        distributions=(NORMAL,) * n,
    )


def _rows(x: Array, places: tuple[tuple[str, slice], ...], name: str) -> Array:
    """Return the rows of a source, or zeros of its shape where it is not given."""
    for known, rows in places:
        if known == name:
            return x[rows]
    n = 6 if name == "mounting_repeatability" else 3
    return np.zeros((n, x.shape[1]), dtype=x.dtype)
