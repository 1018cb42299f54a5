"""Noise of the axes: white, of every sample, random walk, first-order Gauss-Markov."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, expm1, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.model.noise import (
    SAME_EDGE,
    Flicker,
    GaussMarkov,
    Process,
    Quantized,
    RandomWalk,
    White,
)
from budget.model.source import Given, Noise, Samples
from budget.model.waves import Waves

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array

# Samples from which a filter that takes half a second to import is the quicker one.
LONG = 10_000
LOW_CUT = 1.0 / 86400.0  # of a flicker that names none: once a day [Hz]
WAVES_PER_OCTAVE = 6  # of a flicker in the simulation


@dataclass(frozen=True)
class WhiteNoise(Noise):
    """Angle or velocity random walk: white noise of density N."""

    formula = "u_L^2 = N^2/L"
    letters = "sources.white_noise"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:  # noqa: ARG002
        """Return white noise of that density."""
        return White(float(given.u[axis]))

    def sampler(
        self,
        given: Given,
        rng: np.random.Generator,
        sample_rate: float,  # noqa: ARG002
    ) -> Callable[[Samples], Array]:
        """Return samples of standard deviation N/sqrt(dt)."""
        u = given.u[:, None]
        return lambda at: np.asarray(u / sqrt(at.dt) * rng.standard_normal((3, at.n)))


@dataclass(frozen=True)
class SampleNoise(Noise):
    """White noise of every sample, sigma at the sample rate: Zhao 2019, 2.2.2."""

    formula = "u_L^2 = sigma^2/(f L)"
    letters = "sources.sample_noise"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:
        """Return white noise: the variance of an average is sigma^2 / (f L)."""
        return White(float(given.u[axis]) / sqrt(sample_rate))

    def sampler(
        self, given: Given, rng: np.random.Generator, sample_rate: float
    ) -> Callable[[Samples], Array]:
        """Return samples of standard deviation sigma."""
        u = given.u[:, None]

        def samples(at: Samples) -> Array:
            # Where a window is no whole number of sample periods, dt differs a little.
            scale = 1.0 / sqrt(at.dt * sample_rate)
            return np.asarray(u * scale * rng.standard_normal((3, at.n)))

        return samples


@dataclass(frozen=True)
class Walk(Noise):
    """Rate or acceleration random walk, 0 at the start of the test."""

    formula = "u_L^2 = K^2 (s + L/3)"
    letters = "sources.walk"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:  # noqa: ARG002
        """Return the integral of white noise of density K."""
        return RandomWalk(float(given.u[axis]))

    def sampler(
        self,
        given: Given,
        rng: np.random.Generator,
        sample_rate: float,  # noqa: ARG002
    ) -> Callable[[Samples], Array]:
        """Return the running sum of steps K sqrt(dt)."""
        u = given.u[:, None]
        state, clock = np.zeros(3), 0.0  # last value and its time

        def samples(at: Samples) -> Array:
            nonlocal clock, state
            steps = rng.standard_normal((3, at.n)) * sqrt(at.dt)
            steps[:, 0] *= sqrt((at.first - clock) / at.dt)
            walk = state[:, None] + np.cumsum(u * steps, axis=1)
            clock, state = at.last, walk[:, -1]
            return walk

        return samples


@dataclass(frozen=True)
class Stability(Noise):
    """First-order Gauss-Markov process, stationary: Zhao 2019, 2.1.1."""

    formula = r"u_L^2 = 2 sigma^2 (tau/L)^2 (L/tau - 1 + e^(-L\/tau))"
    letters = "sources.gauss_markov"

    own: str = "bias"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:  # noqa: ARG002
        """Return the process of that sigma and correlation time."""
        return GaussMarkov(float(given.u[axis]), float(_tau(given)[axis]))

    def sampler(
        self,
        given: Given,
        rng: np.random.Generator,
        sample_rate: float,  # noqa: ARG002
    ) -> Callable[[Samples], Array]:
        """Return x(t + dt) = a x(t) + sigma sqrt(1 - a^2) z, a = exp(-dt/tau)."""
        state, clock = np.zeros(3), 0.0  # last value and its time

        def samples(at: Samples) -> Array:
            nonlocal clock, state
            z = rng.standard_normal((3, at.n))
            first = z[:, 0].copy()
            taus = _tau(given).tolist()
            for i, (sigma, tau) in enumerate(zip(given.u.tolist(), taus, strict=True)):
                gap = (at.first - clock) / tau if clock else np.inf
                before = exp(-gap) * state[i]
                z[i] *= sigma * sqrt(-expm1(-2.0 * at.dt / tau))
                z[i, 0] = before + sigma * sqrt(-expm1(-2.0 * gap)) * first[i]
            values = np.empty_like(z)
            for tau in dict.fromkeys(taus):  # mostly one for all axes
                rows = [i for i, each in enumerate(taus) if each == tau]
                values[rows] = recursion(exp(-at.dt / tau), z[rows])
            clock, state = at.last, values[:, -1]
            return values

        return samples


@dataclass(frozen=True)
class Quantization(Noise):
    """Rounding of increments of angle or velocity, step q."""

    formula = "u_L^2 = q^2/(6 L^2)"
    letters = "sources.rounding"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:  # noqa: ARG002
        """Return the rounding of that step."""
        return Quantized(float(given.u[axis]))

    def sampler(
        self,
        given: Given,
        rng: np.random.Generator,
        sample_rate: float,  # noqa: ARG002
    ) -> Callable[[Samples], Array]:
        """Return differences of what is left over at the edges of samples, over dt."""
        step = given.u[:, None]
        left, clock = np.zeros(3), -np.inf  # at the last edge, and its time

        def samples(at: Samples) -> Array:
            nonlocal clock, left
            edges = step * rng.uniform(-0.5, 0.5, (3, at.n + 1))
            half = at.dt / 2.0
            if abs(at.first - half - clock) < SAME_EDGE * at.n * at.dt:
                edges[:, 0] = left
            clock, left = at.last + half, edges[:, -1]
            return np.asarray(np.diff(edges, axis=1) / at.dt)

        return samples


@dataclass(frozen=True)
class FlickerNoise(Noise):
    """Bias instability as flicker, of coefficient B above a low cut."""

    formula = r'u_L^2 = B^2/pi ((x sin x + 1 - cos x)\/x^2 - "Ci"(x))'
    letters = "sources.flicker"

    own: str = "bias"

    def process(self, given: Given, axis: int, sample_rate: float) -> Process:  # noqa: ARG002
        """Return flicker of that coefficient."""
        return Flicker(float(given.u[axis]), float(_low_cut(given)[axis]))

    def sampler(
        self, given: Given, rng: np.random.Generator, sample_rate: float
    ) -> Callable[[Samples], Array]:
        """Return waves up to half the sample rate, one for each part of an octave."""
        axes = []
        for B, low in zip(given.u, _low_cut(given), strict=True):
            octaves = max(1.0, np.log2(0.5 * sample_rate / low))
            bands = int(np.ceil(WAVES_PER_OCTAVE * octaves))
            ratio = 2.0 ** (octaves / bands)
            frequencies = low * ratio ** (np.arange(bands) + rng.uniform(size=bands))
            size = B * sqrt(np.log(ratio) / np.pi)  # of B^2/(pi f), one-sided
            axes.append(Waves.draw(frequencies, np.full(bands, size), rng))
        return lambda at: np.stack([waves.at(at.times) for waves in axes])


def _low_cut(given: Given) -> Array:
    """Return the low cut by axis [Hz]; of a probe that of a day."""
    return np.full(given.u.size, LOW_CUT) if given.low_cut is None else given.low_cut


def _tau(given: Given) -> Array:
    """Return tau by axis [s]; the reader gives one to every stability."""
    if given.correlation_time is None:
        raise ValueError(f"{given.name} without a correlation time")
    return given.correlation_time


def recursion(a: float, z: Array) -> Array:
    """Return x_k = a x_(k-1) + z_k of rows, shape (rows, samples); x_0 = z_0.

    Of short ones as the equations with two diagonals that they are: to the last bit
    the same, each being one product and one sum.
    """
    if z.shape[1] >= LONG:
        from scipy.signal import lfilter

        return np.asarray(lfilter([1.0], [1.0, -a], z))
    from scipy.linalg import solve_banded

    bands = np.zeros((3, z.shape[1]))  # above the diagonal, on it, below it
    bands[1], bands[2] = 1.0, -a
    return np.asarray(solve_banded((1, 1), bands, z.T, check_finite=False).T)
