"""Aided navigation in one level channel: its table, and conditioning without a filter.

p' = v, v' = -g phi + a, phi' = v/R + e: position and velocity are measured every second
for a time, then nothing for a minute.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm

from budget.navigation.aided import Aid, Aided, Belief, Drift, KalmanFilter
from budget.navigation.growth import (
    AxisNoise,
    Growth,
    Markov,
    Rounding,
    UnitRandomWalk,
    UnitWhiteNoise,
)
from budget.navigation.route import Steps
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

G, R = 9.80665, 6371000.0
POSITION, VELOCITY, LEVEL = 0, 3, 6  # rows of what is seen
ROOT_HOUR = 60.0  # [sqrt(s)]
LATER = (10, 30, 60)  # after the last measurement [s]
# What the table says, of tac.yaml and mems.yaml without scale factor and mounting.
SIGMA = {
    "tac": {
        "gyro.bias": 1.0 * DEG_PER_HOUR,
        "gyro.stability": 0.5 * DEG_PER_HOUR,
        "gyro.walk": radians(0.1) / ROOT_HOUR,
        "accelerometer.bias": 1000.0 * MICRO_G,
        "accelerometer.stability": 50.0 * MICRO_G,
        "accelerometer.walk": 0.05 / ROOT_HOUR,
    },
    "mems": {
        "gyro.bias": 200.0 * DEG_PER_HOUR,
        "gyro.stability": 10.0 * DEG_PER_HOUR,
        "gyro.walk": radians(0.3) / ROOT_HOUR,
        "accelerometer.bias": 5000.0 * MICRO_G,
        "accelerometer.stability": 100.0 * MICRO_G,
        "accelerometer.walk": 0.1 / ROOT_HOUR,
    },
}
INPUT = {"gyro": 0, "accelerometer": 3}
TAU = 300.0
MEASURED = {"position": (POSITION, 2.5), "velocity": (VELOCITY, 0.05)}
START = {POSITION: 10.0, VELOCITY: 1.0, LEVEL: radians(1.0)}
F = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -G], [0.0, 1.0 / R, 0.0]])


@dataclass(frozen=True)
class Channel:
    """One level channel, as navigation asks a Moment."""

    shape: tuple[int, ...]

    @property
    def at_rest(self):
        """Return it: nothing in it depends on motion."""
        return self

    def some(self, rows):
        """Return fewer moments."""
        number = len(range(self.shape[0])[rows])
        return Channel((number, *self.shape[1:]))

    def all_over(self, rows, columns, places):
        """Return a matrix of ones and numbers at some places, at all times."""
        M = np.zeros((rows, columns))
        for row, column in places:
            M[row, column] = 1.0
        return np.broadcast_to(M, (*self.shape, rows, columns))

    def dynamics(self, **_):
        """Return the equations of the channel."""
        return np.broadcast_to(F, (*self.shape, 3, 3))

    def entry(self, **_):
        """Return where a gyro and an accelerometer enter."""
        return self.all_over(3, 6, [(2, 0), (1, 3)])

    def seen(self, **_):
        """Return position, velocity and tilt as what is seen."""
        return self.all_over(9, 3, [(POSITION, 0), (VELOCITY, 1), (LEVEL, 2)])

    measured = seen

    def given(self, **_):
        """Return the states of the errors at the start."""
        return self.all_over(3, 9, [(0, POSITION), (1, VELOCITY), (2, LEVEL)])

    def aligned(self, **_):
        """Return what self-alignment finds: nothing."""
        return self.all_over(3, 6, [])


def columns(moment):
    """Return what the biases of a gyro and an accelerometer are."""
    return moment.all_over(6, 2, [(0, 0), (3, 1)])


def noises_of(unit):
    """Return the noises of a unit, by line."""
    return {
        name: (AxisNoise(row=INPUT[owner], noise=noise, u=SIGMA[unit][name]),)
        for owner in INPUT
        for name, noise in (
            (f"{owner}.stability", Markov(times=(TAU,))),
            (f"{owner}.walk", UnitWhiteNoise()),
        )
    }


def channel(times):
    """Return growth in the channel, asked for at these times [s]."""
    shape = (len(times),)
    return Growth(
        first=Channel(()),
        alignment=0.0,
        steps=Steps(
            durations=np.diff([0.0, *times]),
            nodes=Channel((*shape, 4)),
            asked=tuple(range(len(times))),
            ends=Channel(shape),
        ),
        aided=True,
    )


def aided(unit, duration, *, noises=None, drift=None, believed=None, ends=None):
    """Return a unit in the channel, measured every second for a duration [s].

    Noises besides its own; a filter that believes another unit, or other epochs.
    """
    growth = channel([*range(1, duration + 1), *(duration + time for time in LATER)])
    aids = tuple(
        Aid(
            name=name,
            rows=(row,),
            u=(u,),
            ends=ends or tuple(range(duration)),
            drift=drift if name == "position" else None,
        )
        for name, (row, u) in MEASURED.items()
    )
    start = np.zeros(9)
    start[[*START]] = [*START.values()]
    own = believed or unit
    belief = Belief(
        covariance=np.diag([SIGMA[own][f"{owner}.bias"] ** 2 for owner in INPUT]),
        columns=columns,
        biases=columns(Channel(())),
        noises=sum(({**noises_of(own), **(noises or {})}).values(), ()),
        aids=aids,
        start=start,
    )
    asked = tuple(range(duration - 1, duration + len(LATER)))
    return Aided(
        filter=KalmanFilter(growth=growth, belief=belief, kept=frozenset(asked)),
        asked=asked,
        aids=aids,
        start=start,
    )


def by_source(journey, unit, noises=None):
    """Return the covariance of what is asked for that each source leaves, by name."""
    found = {
        name: journey.of_noise(parts)
        for name, parts in {**noises_of(unit), **(noises or {})}.items()
    }
    found |= journey.of_aids()
    found |= {f"start.{name}": C for name, C in journey.of_start()}
    S = journey.of_constants(columns)
    for owner, place in zip(INPUT, (0, 1), strict=True):
        made = S[..., place] * SIGMA[unit][f"{owner}.bias"]
        found[f"{owner}.bias"] = np.multiply.outer(made, made)
    return found


def position(C):
    """Return the standard uncertainties of the position at all times [m]."""
    return np.sqrt([C[t, POSITION, t, POSITION] for t in range(len(C))])


@dataclass(frozen=True)
class Dense:
    """All states of the channel, and nothing of the package: Phi and Q by Van Loan."""

    unit: str
    tau: float = TAU

    @property
    def equations(self):
        """Return p, v, phi, biases, stabilities: their equations and noise density."""
        A, W = np.zeros((7, 7)), np.zeros((7, 7))
        A[:3, :3] = F
        A[2, [3, 5]] = A[1, [4, 6]] = 1.0
        A[5, 5] = A[6, 6] = -1.0 / self.tau
        sigma = SIGMA[self.unit]
        W[2, 2], W[1, 1] = (
            sigma["gyro.walk"] ** 2,
            sigma["accelerometer.walk"] ** 2,
        )
        W[5, 5] = 2.0 / self.tau * sigma["gyro.stability"] ** 2
        W[6, 6] = 2.0 / self.tau * sigma["accelerometer.stability"] ** 2
        return A, W

    def step(self, h):
        """Return transition and noise of a time."""
        A, W = self.equations
        E = expm(np.block([[-A, W], [np.zeros((7, 7)), A.T]]) * h)
        move = E[7:, 7:].T
        return move, move @ E[:7, 7:]

    @property
    def begin(self):
        """Return the covariance when it begins."""
        names = [f"{o}.{n}" for n in ("bias", "stability") for o in INPUT]
        own = [SIGMA[self.unit][name] for name in names]
        return np.diag(np.square([*START.values(), *own]))

    def conditioned(self, duration):
        """Return the covariance at the end, of all measurements at once."""
        (move, noise), (last, more) = self.step(1.0), self.step(float(LATER[-1]))
        P, covariances = self.begin, []
        for _ in range(duration):
            P = move @ P @ move.T + noise
            covariances.append(P)
        H = np.eye(7)[:2]
        blocks = [[np.zeros((2, 2))] * duration for _ in range(duration)]
        crossed = []
        for j, C in enumerate(covariances):
            blocks[j][j] = H @ C @ H.T
            for k in range(j + 1, duration):
                C = move @ C  # noqa: PLW2901 - of z_k with z_j
                blocks[k][j] = H @ C @ H.T
                blocks[j][k] = blocks[k][j].T
            crossed.append(last @ C @ H.T)
        Y = np.block(blocks) + np.diag(np.tile(np.square([2.5, 0.05]), duration))
        X = np.concatenate(crossed, axis=1)
        P = last @ covariances[-1] @ last.T + more
        scale = 1.0 / np.sqrt(np.diag(Y))
        return P - X * scale @ np.linalg.solve(
            Y * np.outer(scale, scale), (X * scale).T
        )


TABLE = {
    ("tac", 60): "0.384079 0.503291 1.37927 4.88920 0.0173331 208.502 0.876690 999.607",
    ("tac", 600): "0.350124 0.465823 1.19340 3.89405 0.0162465 207.937 0.451566 "
    "999.612",
    ("mems", 60): "0.384119 0.592581 2.98357 14.8406 0.0226273 994.331 4.65020 4807.65",
    ("mems", 600): "0.350240 0.566405 2.90634 14.3370 0.0224298 994.235 4.46626 "
    "4807.75",
}
BY_SOURCE = {
    "gyro.walk": 2.59030,
    "accelerometer.walk": 0.459659,
    "accelerometer.stability": 0.354394,
    "gyro.stability": 1.17886,
    "position": 0.488193,
    "velocity": 3.11023,
    "start.position": 0.0125018,
    "start.velocity": 0.0244911,
    "start.level": 0.0172212,
    "accelerometer.bias": 0.000986702,
    "gyro.bias": 2.35693,
}


@pytest.mark.parametrize(("unit", "duration"), TABLE)
def test_the_table_of_one_level_channel(unit, duration):
    """Position after 0, 10, 30, 60 s, velocity, tilt, biases left are the table's."""
    journey = aided(unit, duration)
    P = journey.filter.run.covariances[duration - 1]
    left = [np.sqrt(P[np.ix_(own, own)].sum()) for own in ((3, 5), (4, 6))]

    found = [
        *np.sqrt(journey.believed[:, POSITION, POSITION]),
        *np.sqrt(np.diag(P)[1:3]) / [1.0, ARCSEC],
        left[0] / DEG_PER_HOUR,
        left[1] / MICRO_G,
    ]

    assert_allclose(found, [*map(float, TABLE[unit, duration].split())], rtol=1e-4)


def test_each_source_of_one_level_channel():
    """A minute after a minute each source leaves of the position what is known."""
    found = by_source(aided("tac", 60), "tac")

    assert found.keys() == BY_SOURCE.keys()
    for name, u in BY_SOURCE.items():
        assert_allclose(position(found[name])[-1], u, rtol=2e-4, err_msg=name)


@pytest.mark.parametrize("unit", SIGMA)
def test_a_filter_leaves_what_conditioning_on_all_measurements_leaves(unit):
    """The filter's covariance is that given all measurements at once, to 1e-9."""
    found = aided(unit, 60).believed[-1]
    expected = Dense(unit).conditioned(60)

    rows = [POSITION, VELOCITY, LEVEL]
    assert_allclose(np.diag(found)[rows], np.diag(expected)[:3], rtol=1e-9)


def off_conditioning(journey):
    """Return by how much the variance of the position is off that of conditioning."""
    expected = Dense("tac").conditioned(60)[0, 0]
    total = sum(by_source(journey, "tac").values())[-1, POSITION, -1, POSITION]
    return abs(total / expected - 1.0)


def test_other_epochs_and_gains_leave_more():
    """Measured a second early, or with the gains of another unit: the controls."""
    assert off_conditioning(aided("tac", 60)) < 1e-9
    assert off_conditioning(aided("tac", 60, ends=tuple(range(59)))) > 1e-3
    assert off_conditioning(aided("tac", 60, believed="mems")) > 1e-3


MORE = {
    "rounding": (AxisNoise(row=0, noise=Rounding(period=0.01), u=1e-4),),
    "rounding of velocity": (AxisNoise(row=3, noise=Rounding(period=0.01), u=0.1),),
    "walk": (AxisNoise(row=0, noise=UnitRandomWalk(), u=1e-7),),
    "flicker": (AxisNoise(row=3, noise=Markov(times=(3.0, 30.0)), u=1e-3),),
}


def test_the_parts_add_up_to_the_covariance_of_the_filter():
    """With every kind of noise, and a drift of the position, at all times."""
    drift = Drift(u=(2.0,), correlation_time=40.0)
    journey = aided("tac", 60, noises=MORE, drift=drift)

    found = by_source(journey, "tac", MORE)

    assert found["position_drift"][-1, POSITION, -1, POSITION] > 0.0
    rows = [POSITION, VELOCITY, LEVEL]
    for t, believed in enumerate(journey.believed):
        total = sum(C[t, rows, t, rows] for C in found.values())
        assert_allclose(total, believed[rows, rows], rtol=1e-9)


def believing(other, duration):
    """Return the variances of p, v, phi of the tac unit by a filter of another one.

    As the covariance of truth and estimate together: Phi and Q of both, and the gains
    of what the filter believes.
    """
    true = Dense("tac")
    (move, noise), (last, more) = true.step(1.0), true.step(float(LATER[-1]))
    (as_moved, as_noise), (as_last, _) = other.step(1.0), other.step(float(LATER[-1]))
    H, R = np.eye(7)[:2], np.diag([2.5**2, 0.05**2])
    P, one = other.begin, np.eye(7)
    J = np.zeros((14, 14))
    J[:7, :7] = true.begin
    for _ in range(duration):
        P = as_moved @ P @ as_moved.T + as_noise
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        P = (one - K @ H) @ P @ (one - K @ H).T + K @ R @ K.T
        step = np.block([[move, 0.0 * one], [0.0 * one, as_moved]])
        J = step @ J @ step.T
        J[:7, :7] += noise
        update = np.block([[one, 0.0 * one], [K @ H, one - K @ H]])
        J = update @ J @ update.T
        J[7:, 7:] += K @ R @ K.T
    step = np.concatenate([last, -as_last], axis=1)
    return np.diag(step @ J @ step.T + more)[:3]


def test_a_filter_that_believes_another_correlation_time():
    """Its errors are those of truth and estimate together, carried forward."""
    other = Dense("tac", tau=20.0)
    noises = {
        f"{owner}.stability": (
            AxisNoise(
                row=row,
                noise=Markov(times=(20.0,)),
                u=SIGMA["tac"][f"{owner}.stability"],
            ),
        )
        for owner, row in INPUT.items()
    }
    journey = aided("tac", 60, noises=noises)

    total = sum(by_source(journey, "tac").values())

    rows = [POSITION, VELOCITY, LEVEL]
    # Digits cancel in the covariance of both.
    assert_allclose(total[-1, rows, -1, rows], believing(other, 60), rtol=1e-6)
    assert total[-1, POSITION, -1, POSITION] > Dense("tac").conditioned(60)[0, 0]


@pytest.mark.parametrize("time", [0.01, 1.0, 30.0, 3e4])
def test_transitions_are_exponentials(time):
    """In short steps and in long ones: Schuler's oscillation in closed form."""
    (found,) = channel([time]).moves

    w = (G / R) ** 0.5
    c, s = np.cos(w * time), np.sin(w * time)
    expected = [
        [1.0, s / w, -2.0 * R * np.sin(0.5 * w * time) ** 2],
        [0.0, c, -G * s / w],
        [0.0, s / (w * R), c],
    ]
    assert_allclose(found, expected, rtol=1e-12)
