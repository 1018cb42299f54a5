"""Temperature of both triads, and how their parameters change with it.

b = b0 + bT (T - T0) + bR dT/dt and K = K0 (1 + kT (T - T0)), IEEE 1293 and 952. The
coefficients are the device's, fixed and of one sign on all axes; the history T(t) is
what nobody knows. It is the same for all axes and both triads, whose tests it takes as
begun together where each has a clock of its own. Within a window kT acts by the means
of T and of the input. That both change in a turn is left out: of n turns in a time L on
a ramp r at the most kT r L/(2 pi n) times what turns of the input, 16 % of kT g times
the change of T in one turn about a level axis. At 100 ppm/degC, 1 degC/h and 18 s that
is 0.08 ug of an accelerometer's reading and, of the earth rate, 1e-6 deg/h of a gyro's.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from budget.model.noise import stationary, weighed
from budget.model.response import BIAS
from budget.model.source import (
    Coefficient,
    Disturbance,
    Effect,
    Given,
    SimulatedWindow,
    Triad,
    TurnOnChange,
)
from budget.model.waves import Waves

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from budget.arrays import Array
    from budget.model.course import Course
    from budget.model.response import Truth
    from budget.model.scheme import Scheme
    from budget.model.source import Act, Gains
    from budget.model.windows import Schedule

BIAS_COEFFICIENT = "bias_temperature_coefficient"
RATE_COEFFICIENT = "bias_temperature_rate_coefficient"
SCALE_COEFFICIENT = "scale_factor_temperature_coefficient"
COEFFICIENTS = (BIAS_COEFFICIENT, RATE_COEFFICIENT, SCALE_COEFFICIENT)
ON_THE_WAY = "on the way"  # form of a coefficient of what is known at every time
WAVES = 300  # of a random temperature in the simulation


@dataclass(frozen=True)
class TemperatureCoefficient(Coefficient):
    """bT, bR or kT: change of a parameter with the temperature."""

    needs = "sources.temperature"


@dataclass(frozen=True)
class OnTheWay(Effect):
    """One of them where T(t) is known: a constant of each axis, whose size is given.

    Attributes
    ----------
    target : str
        'bias' or 'scale_factor'.
    is_of_rate : bool
        Whether it acts by dT/dt.
    """

    target: str
    is_of_rate: bool = False

    def felt(self, course: Course, t: Array) -> Array:
        """Return T - T0 [K], or dT/dt [K/s]."""
        return course.slope(t) if self.is_of_rate else course.at(t)


@dataclass(frozen=True)
class History(Disturbance):
    """e_i = bT_i T + bR_i dT/dt + kT_i T x_i, x_i the input of the axis."""

    needs = "sources.coefficient"

    @abstractmethod
    def course(self, value: Array, given: Given, times: Array) -> Array:
        """Return T - T0 at those times [K]."""

    def reading(self, value: Array, moment: SimulatedWindow) -> Array:
        """Return what the temperature of every sample adds."""
        coefficients = _coefficients(moment.known)
        if coefficients is None:
            return np.zeros((3, 1))
        bT, bR, kT = coefficients[..., None]
        at, given = moment.samples, moment.given
        edges = np.append(at.times - at.dt / 2.0, at.last + at.dt / 2.0)
        T = self.course(value, given, at.times)
        rate = np.diff(self.course(value, given, edges)) / at.dt
        return np.asarray(bT * T + bR * rate + kT * T * moment.true_input)


@dataclass(frozen=True)
class TemperatureCourse(History):
    """A history of known shape; its size is what nobody knows."""

    @abstractmethod
    def shape(self, given: Given, times: Array) -> Array:
        """Return T - T0 at those times for each input of 1, shape (k, n) [1]."""

    @abstractmethod
    def means(self, given: Given, schedule: Schedule) -> Array:
        """Return the means of that over windows, shape (k, n) [1]."""

    def course(self, value: Array, given: Given, times: Array) -> Array:
        """Return T - T0 at those times [K]."""
        return np.asarray(value @ self.shape(given, times))

    def bind(self, given: Given, triad: Triad) -> Act | None:
        """Return the size times what 1 of it leaves; None without coefficients."""
        coefficients = _coefficients(triad.given)
        if coefficients is None:
            return None
        bT, bR, kT = coefficients[..., None, None]
        scheme, schedule = triad.scheme, triad.scheme.schedule
        T = self.means(given, schedule)
        ends = schedule.starts + schedule.lengths
        rate = self.shape(given, ends) - self.shape(given, schedule.starts)
        weighed = scheme.weigh(T.T)  # (3, m, k)
        inputs = scheme.turn + scheme.standing

        return partial(
            _warmed,
            shift=bT * weighed + bR * scheme.weigh((rate / schedule.lengths).T),
            seen=[kT * scheme.weigh(inputs * one[:, None]) for one in T],
            constant=kT * weighed,
        )


@dataclass(frozen=True)
class TemperatureRamp(TemperatureCourse):
    """T - T0 = r t from the start of a triad's test."""

    def shape(self, given: Given, times: Array) -> Array:  # noqa: ARG002
        """Return t."""
        return times[None]

    def means(self, given: Given, schedule: Schedule) -> Array:  # noqa: ARG002
        """Return the times in the middle of the windows."""
        return schedule.middles[None]


@dataclass(frozen=True)
class WarmUp(TemperatureCourse):
    """T - T0 = -D e^(-t/tau) from the start of a triad's test."""

    def shape(self, given: Given, times: Array) -> Array:
        """Return -e^(-t/tau)."""
        return np.asarray(-np.exp(-times / _time(given)))[None]

    def means(self, given: Given, schedule: Schedule) -> Array:
        """Return -(tau/L) e^(-s/tau) (1 - e^(-L/tau))."""
        x = schedule.lengths / _time(given)
        return np.asarray(self.shape(given, schedule.starts) * -np.expm1(-x) / x)


@dataclass(frozen=True)
class Soaks(TemperatureCourse):
    """T - T0 follows the soaks, each of a temperature x_k of its own, by a lag of tau.

    T = x_0 + sum_k (x_k - x_(k-1)) s(t - t_k), s(t) = 1 - e^(-t/tau) from t = 0 on: the
    response of a first-order lag to steps at the times t_k at which soaks begin, the
    first one settled at the start of the test.
    """

    def size(self, given: Given, scheme: Scheme | None) -> int:  # noqa: ARG002
        """Return the number of soaks."""
        return 1 + _points(given).size

    def shape(self, given: Given, times: Array) -> Array:
        """Return s(t - t_k) - s(t - t_(k+1)), that of the first one 1 before."""
        since = np.maximum(times - _points(given)[:, None], 0.0)
        return _steps(-np.expm1(-since / _time(given)))

    def means(self, given: Given, schedule: Schedule) -> Array:
        """Return the same of its integral, t - tau (1 - e^(-t/tau)), over windows."""
        tau, points = _time(given), _points(given)[:, None]
        start, end = (
            np.maximum(times - points, 0.0)
            for times in (schedule.starts, schedule.starts + schedule.lengths)
        )
        grown = end - start + tau * (np.expm1(-end / tau) - np.expm1(-start / tau))
        return _steps(grown / schedule.lengths)


def _steps(risen: Array) -> Array:
    """Return the part of each soak where soaks after the first have risen, (k, n)."""
    ends = np.zeros((1, risen.shape[1]))
    return np.asarray(
        np.concatenate([ends + 1.0, risen]) - np.concatenate([risen, ends])
    )


@dataclass(frozen=True)
class RandomTemperature(History):
    """T - T0 is a stationary first-order Gauss-Markov process.

    Its inputs are what the statistics of the triads take of its window means and of its
    mean rates of change: of each triad those that differ, one triad after the other.
    """

    is_process = True

    def covariance(self, given: Given, triads: Sequence[Triad]) -> Array | None:
        """Return the covariance of the inputs of those triads [K^2, K^2/s, ...]."""
        parts = [(_rows(triad), triad.scheme.schedule) for triad in triads]
        felt = [(rows, schedule) for rows, schedule in parts if len(rows)]
        if not felt:
            return None
        starts = np.concatenate([schedule.starts for _, schedule in felt])
        lengths = np.concatenate([schedule.lengths for _, schedule in felt])
        n = [len(schedule.windows) for _, schedule in felt]
        weights = np.zeros((sum(len(rows) for rows, _ in felt), 2, starts.size))
        row = place = 0
        for (rows, _), count in zip(felt, n, strict=True):
            weights[row : row + len(rows), :, place : place + count] = rows
            row, place = row + len(rows), place + count
        sigma, tau = float(given.u[0]), _time(given)
        integrals = (
            lambda t: tau**2 * (np.abs(t) / tau + np.expm1(-np.abs(t) / tau)),
            lambda t: -tau * np.sign(t) * np.expm1(-np.abs(t) / tau),
            lambda t: np.exp(-np.abs(t) / tau),
        )
        mean, change = weights[:, 0], weights[:, 1]
        both = np.concatenate([mean, change])

        def blocks(own: slice) -> Array:
            return np.hstack(stationary(starts, lengths, integrals, own))

        C = weighed(both, blocks).reshape(2, len(mean), 3, -1)
        mixed = C[1, :, 1] @ mean.T
        whole = C[0, :, 0] @ mean.T + mixed + mixed.T + C[1, :, 2] @ change.T
        return np.asarray(sigma**2 * 0.5 * (whole + whole.T))

    def part(self, triads: Sequence[Triad], place: int) -> slice:
        """Return where the inputs of one triad stand among those of all."""
        counts = [len(_rows(triad)) for triad in triads[: place + 1]]
        return slice(sum(counts[:-1]), sum(counts))

    def bind(self, given: Given, triad: Triad) -> Act | None:  # noqa: ARG002
        """Return what a triad makes of its inputs; None without coefficients."""
        coefficients = _coefficients(triad.given)
        if coefficients is None:
            return None
        all_rows = _all_rows(triad)
        flat = all_rows.reshape(-1, all_rows[0, 0, 0].size)
        place = np.unique(flat, axis=0, return_inverse=True)[1]
        at = np.asarray(place, dtype=np.intp).reshape(all_rows.shape[:3])
        return partial(_mixed, coefficients=coefficients, place=at)

    def draw(self, given: Given, rng: np.random.Generator) -> Array | None:
        """Draw waves whose frequencies have the spectrum, a Lorentz curve."""
        p = (np.arange(WAVES) + rng.uniform(size=WAVES)) / WAVES
        frequencies = np.tan(0.5 * np.pi * p) / (2.0 * np.pi * _time(given))
        sizes = np.full(WAVES, float(given.u[0]) / np.sqrt(WAVES))
        return Waves.draw(frequencies, sizes, rng).values

    def course(self, value: Array, given: Given, times: Array) -> Array:  # noqa: ARG002
        """Return the sum of the waves."""
        return Waves(value).at(times)


@dataclass(frozen=True)
class TemperatureChange(TurnOnChange):
    """Another temperature at the later turn-on than in the test: db = bT dT."""

    needs = "sources.later_coefficient"

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return bT and kT at the later turn-on."""
        coefficients = _coefficients(known)
        if coefficients is None:
            return {}
        bT, _, kT = coefficients[..., None]
        return {"bias": (0.0 * bT, bT), "scale_factor": (0.0 * kT, kT)}


def _coefficients(known: Mapping[str, Given]) -> Array | None:
    """Return bT, bR and kT by axis, shape (3, 3) [SI]; None where none is given."""
    found = [known.get(name) for name in COEFFICIENTS]
    if not any(line is not None and line.u.any() for line in found):
        return None
    return np.array([np.zeros(3) if line is None else line.u for line in found])


def _time(given: Given) -> float:
    """Return the time of a source that has one [s]; the reader sees to it."""
    if given.correlation_time is None:
        raise ValueError(f"{given.name} without its time")
    return float(given.correlation_time[0])


def _points(given: Given) -> Array:
    """Return the times at which soaks begin after the first one [s]."""
    if given.points is None:
        raise ValueError(f"{given.name} without its points")
    return given.points


def _all_rows(triad: Triad) -> Array:
    """Return what each statistic takes of T and of its rate, (5, 3, m, 2, n).

    Of the biases' own change, of its rate, and of the scale factor times the input
    along x, y and z, for each axis and each statistic.
    """
    scheme: Scheme = triad.scheme
    W = scheme.weights
    nothing = np.zeros_like(W)
    inputs = scheme.turn + scheme.standing  # (n, 3)
    parts = [
        (W, nothing),
        (nothing, W),
        *((W * inputs[:, axis], nothing) for axis in range(BIAS)),
    ]
    coefficients = _coefficients(triad.given)
    _, bR, kT = np.zeros((3, 3)) if coefficients is None else coefficients
    used = (True, bR.any(), *(kT.any(),) * BIAS)
    return np.array(
        [
            np.stack(pair, axis=2) * float(is_used)
            for pair, is_used in zip(parts, used, strict=True)
        ]
    )


def _rows(triad: Triad) -> Array:
    """Return those that differ, shape (k, 2, n); none without coefficients."""
    n = len(triad.scheme.schedule.windows)
    if _coefficients(triad.given) is None or n == 0:
        return np.zeros((0, 2, n))
    rows = _all_rows(triad)
    flat = rows.reshape(-1, rows.shape[3] * rows.shape[4])
    return np.unique(flat, axis=0).reshape(-1, *rows.shape[3:])


def _warmed(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    shift: Array,
    seen: Sequence[Array],
    constant: Array,
) -> Array:
    """Return the sizes times what histories of size 1 leave."""
    left: Array | float = 0.0
    for k, rows in enumerate(seen):
        own = shift[..., k, None] + constant[..., k, None] * truth.bias[:, None]
        left = left + (own + truth.see(rows)) * x[k]
    return np.asarray(left)


def _mixed(
    x: Array,
    truth: Truth,
    noise: Array,  # noqa: ARG001
    *,
    coefficients: Array,
    place: NDArray[np.intp],
) -> Array:
    """Return bT T + bR dT/dt + kT T (M u + b) for the statistics of T."""
    bT, bR, kT = coefficients[..., None, None]
    mean, rate, *along = x[place]  # (3, m, trials) each
    total = bT * mean + bR * rate
    if not kT.any():
        return np.asarray(total)
    M = truth.see(np.tile(np.eye(3), (3, 1, 1)))  # rows, (3, 3, trials)
    seen = mean * truth.bias[:, None]
    for axis, part in enumerate(along):
        seen = seen + M[:, axis, None] * part
    return np.asarray(total + kT * seen)
