"""Recordings for tests: made of seeds, written as a user has them."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter

HEADS = ("time [s]", "gyro_x [deg/h]", "gyro_y [deg/h]", "gyro_z [deg/h]")


def white(rng, n, dt, N):
    """Return white noise of density N."""
    return N / np.sqrt(dt) * rng.standard_normal(n)


def markov(rng, n, dt, s, t):
    """Return a first-order Gauss-Markov process, stationary from its start."""
    p = np.exp(-dt / t)
    e = rng.standard_normal(n)
    e[0] /= np.sqrt(1.0 - p * p)
    return lfilter([s * np.sqrt(1.0 - p * p)], [1.0, -p], e)


def walk(rng, n, dt, K):
    """Return a random walk."""
    return K * np.sqrt(dt) * np.cumsum(rng.standard_normal(n))


def check_log():
    """Return time and rates of the log of which the figures are known [s, deg/h]."""
    rng, n, dt = np.random.default_rng(8), 720_000, 0.01
    x = white(rng, n, dt, 9.0) + markov(rng, n, dt, 6.0, 60.0) + 40.0
    y = white(rng, n, dt, 9.0) - 25.0
    z = white(rng, n, dt, 9.0) + walk(rng, n, dt, 0.3) + 10.0
    return np.stack([np.arange(n) * dt, x, y, z], axis=1)


def short_log(rows=3000, seed=1, dt=0.01):
    """Return a short one, white."""
    rng = np.random.default_rng(seed)
    rates = rng.standard_normal((rows, 3)) * 90.0 + [40.0, -25.0, 10.0]
    return np.concatenate([np.arange(rows)[:, None] * dt, rates], axis=1)


def write(path, values, heads=HEADS, sep=",", end="\n"):
    """Write rows below their heads."""
    lines = [sep.join(heads)] if heads else []
    lines += [sep.join(f"{v:.10g}" for v in row) for row in values]
    path.write_bytes((end.join(lines) + end).encode())
    return path
