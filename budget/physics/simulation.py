"""The calibration done pulse by pulse, the paper's own way: referee for the methods.

Every sample of every window is made: the turning earth, the constants of the run, each
noise process in time; the pulses are counted (Zhao 2019, eqs. (1), (2)) and go through
the calibration formulas. Of the closed forms for window averages nothing is used here,
so agreement with them is evidence for both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from math import cos, exp, expm1, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from budget.arrays import Array
from budget.distributions import LEAST
from budget.earth import ROTATION_RATE
from budget.errors import CallError
from budget.physics.formulas import (
    CalibratedTriad,
    calibrate_accelerometer,
    calibrate_gyro,
)
from budget.physics.schedule import Window, schedule_accelerometer, schedule_gyro

if TYPE_CHECKING:
    from budget.spec.records import ErrorLine, Procedure, Sensor

# Of one window, three axes and a few arrays of that length: some 0.2 GB.
MOST_SAMPLES = 2_000_000
NEW_AT_TURN_ON = (
    "bias_repeatability",
    "scale_factor_repeatability",
    "mounting_repeatability",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class TurnOn:
    """The values that the constants of one triad have during one turn-on."""

    k: Array  # K = K0 (1 + k), shape (3,) [1]
    asymmetry: Array  # Ka, shape (3,) [1]
    angle: Array  # shape (6,) [rad]
    bias: Array  # shape (3,) [SI]


@dataclass(frozen=True, kw_only=True)
class Samples:
    """The sampling of one window: n samples at the middle of steps of dt."""

    n: int
    dt: float  # [s]
    first: float  # time of the first sample [s]

    @property
    def last(self) -> float:
        """Time of the last sample [s]."""
        return self.first + (self.n - 1) * self.dt


Noise = Callable[[Samples], Array]  # the next samples of a process, shape (3, n)
Count = Callable[[Window, TurnOn, Noise], Array]  # pulses of a window, shape (3,)


def simulate(
    sensors: tuple[Sensor, ...],
    procedure: Procedure,
    *,
    run: int,
    seed: int = 0,
    reference: str = "nominal",
    only: frozenset[str] | None = None,
) -> Array:
    """Simulate one run of the whole calibration.

    Parameters
    ----------
    sensors : tuple of Sensor
        At most one gyro and one accelerometer.
    procedure : Procedure
        Turns and dwells, the place, the formulas.
    run, seed : int
        Which random numbers; each source has a stream of its own.
    reference : str
        What errors are counted from: 'nominal', 'as_tested', 'next_turn_on'.
    only : frozenset of str, optional
        Full names of the sources that count; all others are left out.

    Returns
    -------
    ndarray, shape (12 times the number of sensors,)
        Errors of scale factors (relative), mounting angles and biases, triad by triad
        [1, rad, rad/s or m/s^2].

    Raises
    ------
    CallError
        A window holds too many samples to be made one by one.
    """
    _check_samples(sensors, procedure)
    return np.concatenate(
        [
            _simulate_triad(
                sensor, procedure, run=run, seed=seed, reference=reference, only=only
            )
            for sensor in sensors
        ]
    )


def _check_samples(sensors: tuple[Sensor, ...], procedure: Procedure) -> None:
    """Refuse windows that would fill the memory."""
    schedules = {
        "gyro": schedule_gyro(procedure.gyro),
        "accelerometer": schedule_accelerometer(procedure.accelerometer),
    }
    for sensor in sensors:
        samples = schedules[sensor.kind].lengths.max() * procedure.sample_rate
        if samples > MOST_SAMPLES:
            raise CallError(
                f"a window of the {sensor.kind} procedure holds {samples:.3g} samples "
                f"at {procedure.sample_rate:g} Hz; the simulation makes them one by "
                f"one, {MOST_SAMPLES:.0e} at the most. Lower the sample rate or "
                "shorten the window, or use another method, for which length is free"
            )


def _simulate_triad(
    sensor: Sensor,
    procedure: Procedure,
    *,
    run: int,
    seed: int,
    reference: str,
    only: frozenset[str] | None,
) -> Array:
    """Simulate one triad; shape (12,)."""
    lines = [
        line
        for line in sensor.lines
        if only is None or f"{sensor.kind}.{line.name}" in only
    ]
    name = {line.name: f"{sensor.kind}.{line.name}" for line in lines}
    rng = {line.name: _generator(seed, run, name[line.name]) for line in lines}
    during = {
        line.name: _draw(line, rng[line.name]) for line in lines if _is_constant(line)
    }
    later = {
        line.name: _draw(line, _generator(seed, run, f"{name[line.name]}, later"))
        for line in lines
        if line.name in NEW_AT_TURN_ON
    }
    tested = _turn_on(sensor, during)
    held = {
        "nominal": _turn_on(sensor, {}),
        "as_tested": tested,
        "next_turn_on": _turn_on(sensor, {**during, **later}),
    }[reference]
    noises = [
        _noise(line, rng[line.name], procedure.sample_rate)
        for line in lines
        if not _is_constant(line)
    ]

    def count(window: Window, turn_on: TurnOn, u: Callable[[Samples], Array]) -> Array:
        return _count(window, turn_on, u, noises, procedure.sample_rate)

    calibrate = _run_gyro if sensor.kind == "gyro" else _run_accelerometer
    found = calibrate(tested, procedure, count)
    return np.concatenate(
        [
            (found.scale_factor - (1.0 + held.k)) / (1.0 + held.k),
            found.mounting_angle - held.angle,
            found.bias - held.bias,
        ]
    )


def _run_gyro(tested: TurnOn, procedure: Procedure, count: Count) -> CalibratedTriad:
    """Turn, dwell, and calibrate: Zhao 2019, 1.2.1, 1.2.2."""
    latitude, plan = procedure.latitude, procedure.gyro
    earth = ROTATION_RATE * np.array([0.0, cos(latitude), sin(latitude)])  # ENU
    turn_pulses, static = np.zeros((3, 3)), np.zeros(3)
    mean_earth = np.zeros(3)
    for window in schedule_gyro(plan).windows:
        if window.axis is not None:
            axis = np.eye(3)[window.axis]
            rate = window.sign * plan.rate

            pulses = count(window, tested, _turning(earth, axis, rate))
            turn_pulses[:, window.axis] += window.sign * pulses
        else:
            azimuth = np.array([window.azimuth], dtype=float)
            standing = _seen_from(earth, np.eye(3)[2], azimuth)
            pulses = count(window, tested, _steady(standing))
            static += pulses / window.length / len(plan.azimuths)
            mean_earth += standing[:, 0] / len(plan.azimuths)
    return calibrate_gyro(
        turn_pulses,
        static,
        turns=plan.turns,
        mean_earth=mean_earth,
        formulas=procedure.formulas,
    )


def _run_accelerometer(
    tested: TurnOn, procedure: Procedure, count: Count
) -> CalibratedTriad:
    """Dwell on the six faces, each twice, and calibrate: Zhao 2019, 1.2.3."""
    face_rate = np.zeros((3, 6))
    for place, window in enumerate(
        schedule_accelerometer(procedure.accelerometer).windows
    ):
        up = window.sign * procedure.gravity * np.eye(3)[:, [window.axis or 0]]
        pulses = count(window, tested, _steady(up))
        face_rate[:, place // 2] += pulses / window.length / 2.0
    return calibrate_accelerometer(face_rate, gravity=procedure.gravity)


def _count(
    window: Window,
    turn_on: TurnOn,
    u: Callable[[Samples], Array],
    noises: list[Noise],
    sample_rate: float,
) -> Array:
    """Count the pulses of one window, shape (3,): eqs. (1), (2), K0 = 1, summed."""
    n = max(1, round(window.length * sample_rate))
    dt = window.length / n
    at = Samples(n=n, dt=dt, first=window.start + dt / 2.0)
    xy, xz, yx, yz, zx, zy = turn_on.angle
    M = np.array([[1.0, xz, -xy], [-yz, 1.0, yx], [zy, -zx, 1.0]])  # I + dT, eq. (1)
    K = 1.0 + turn_on.k
    if window.azimuth is None:  # the dwells use the mean K
        K = K * (1.0 + window.sign * turn_on.asymmetry / 2.0)  # eq. (16)
    rate = M @ u(at) + turn_on.bias[:, None]
    for noise in noises:
        rate = rate + noise(at)
    if rate.shape[1] == 1:  # nothing varies within the window
        return np.asarray(K * rate[:, 0] * window.length)
    return np.asarray(K * rate.sum(axis=1) * dt)


def _turning(earth: Array, axis: Array, rate: float) -> Callable[[Samples], Array]:
    """Return the input of a rate turn: the turn itself and the earth seen from it."""

    def u(at: Samples) -> Array:
        angle: Array = rate * at.dt * (np.arange(at.n, dtype=float) + 0.5)
        return np.asarray(_seen_from(earth, axis, angle) + rate * axis[:, None])

    return u


def _steady(u: Array) -> Callable[[Samples], Array]:
    """Return an input that stays what it is during a window."""
    return lambda _: u


def _seen_from(vector: Array, axis: Array, angle: Array) -> Array:
    """Return a fixed vector in a frame turned about an axis, shape (3, n_angles)."""
    across = np.cross(vector, axis)
    along = axis * (axis @ vector)
    return np.asarray(
        along[:, None]
        + np.outer(vector - along, np.cos(angle))
        + np.outer(across, np.sin(angle))
    )


def _noise(line: ErrorLine, rng: np.random.Generator, sample_rate: float) -> Noise:
    """Return a process that yields its samples window after window, shape (3, n)."""
    from scipy.signal import lfilter

    u = line.u[:, None]
    state = np.zeros(3)  # last value of the process
    clock = 0.0  # its time; windows come in the order of time

    def white(at: Samples) -> Array:
        return np.asarray(u / sqrt(at.dt) * rng.standard_normal((3, at.n)))

    def per_sample(at: Samples) -> Array:
        # Where a window is no whole number of sample periods, dt differs a little.
        scale = 1.0 / sqrt(at.dt * sample_rate)
        return np.asarray(u * scale * rng.standard_normal((3, at.n)))

    def random_walk(at: Samples) -> Array:
        nonlocal clock, state
        steps = rng.standard_normal((3, at.n)) * sqrt(at.dt)
        steps[:, 0] *= sqrt((at.first - clock) / at.dt)
        walk = state[:, None] + np.cumsum(u * steps, axis=1)
        clock, state = at.last, walk[:, -1]
        return walk

    def gauss_markov(at: Samples) -> Array:
        nonlocal clock, state
        z = rng.standard_normal((3, at.n))
        values = np.empty_like(z)
        for i, (sigma, tau) in enumerate(
            zip(line.u, _correlation_time(line), strict=True)
        ):
            # x(t + dt) = a x(t) + sigma sqrt(1 - a^2) z, a = exp(-dt/tau); at t = 0
            # the process is stationary.
            a = exp(-at.dt / tau)
            innovation = sigma * sqrt(-expm1(-2.0 * at.dt / tau)) * z[i]
            gap = (at.first - clock) / tau if clock else np.inf
            before = exp(-gap) * state[i]
            innovation[0] = before + sigma * sqrt(-expm1(-2.0 * gap)) * z[i, 0]
            values[i] = lfilter([1.0], [1.0, -a], innovation)
        clock, state = at.last, values[:, -1]
        return values

    return {
        "bias_stability": gauss_markov,
        "sample_noise": per_sample,
        "rate_random_walk": random_walk,
        "acceleration_random_walk": random_walk,
    }.get(line.name, white)


def _correlation_time(line: ErrorLine) -> Array:
    """Return tau by axis [s]; the reader gives one to every bias stability."""
    if line.correlation_time is None:
        raise ValueError(f"{line.name} without a correlation time")
    return line.correlation_time


def _turn_on(sensor: Sensor, drawn: dict[str, Array]) -> TurnOn:
    """Add what was drawn to the nominal values."""
    zero = np.zeros(3)
    return TurnOn(
        k=drawn.get("scale_factor_repeatability", zero)
        + drawn.get("scale_factor_nonlinearity", zero),  # eq. (14)
        asymmetry=drawn.get("scale_factor_asymmetry", zero),
        angle=sensor.nominal_mounting_angle
        + drawn.get("mounting_repeatability", np.zeros(6)),
        bias=sensor.nominal_bias + drawn.get("bias_repeatability", zero),
    )


def _is_constant(line: ErrorLine) -> bool:
    """Whether the line is a constant of the run: the rest vary in time."""
    return line.name.startswith("scale_factor_") or line.name in NEW_AT_TURN_ON


def _draw(line: ErrorLine, rng: np.random.Generator) -> Array:
    """Draw a random constant, shape (3,) or (6,) [SI]."""
    p = rng.uniform(LEAST, 1.0, line.u.size)
    z = [shape.quantile(p[i : i + 1])[0] for i, shape in enumerate(line.distributions)]
    return np.asarray(line.u * z)


def _generator(seed: int, run: int, name: str) -> np.random.Generator:
    """Return the random stream of one source in one run."""
    key = int.from_bytes(sha256(name.encode()).digest()[8:16], "big")
    return np.random.Generator(
        np.random.SFC64(np.random.SeedSequence(seed, spawn_key=(key, run)))
    )
