"""A single level channel against closed forms: constants, white noise, walks, Markov.

p' = v, v' = -g phi + a, phi' = v/R + e, with ws = sqrt(g/R): the equations that every
textbook solves, through the same engine as a navigator's nine.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from budget.model.course import Fading, Profile
from budget.navigation.growth import (
    AxisNoise,
    Growth,
    Markov,
    Rounding,
    UnitRandomWalk,
    UnitWhiteNoise,
)
from budget.navigation.route import Motion, Steps
from budget.units import DEG_PER_HOUR, MICRO_G

R, G = 6371000.0, 9.80665
WS = (G / R) ** 0.5
GYRO, FORCE, TILT = 0, 3, 4  # inputs; the third is the tilt that alignment leaves
TIMES = (60.0, 600.0, 3600.0)
ARW = 0.005 * np.radians(1.0) / 60.0


@dataclass(frozen=True)
class Channel:
    """One level channel, in place of moments of flight."""

    shape: tuple[int, ...] = ()
    sign: float = 1.0
    time: np.ndarray | float = 0.0  # since the start [s]

    @property
    def at_rest(self):
        """It always does."""
        return self

    def some(self, rows):
        """Return fewer moments."""
        number = len(range(self.shape[0])[rows])
        return Channel((number, *self.shape[1:]), self.sign, self.time[rows])

    def all(self, one):
        """Return one matrix for every moment."""
        return np.broadcast_to(one, (*self.shape, *np.shape(one)))

    def dynamics(self, *, aided):  # noqa: ARG002
        """Return F of p, v, phi."""
        F = np.array([[0, 1, 0], [0, 0, -G], [0, self.sign / R, 0]], dtype=float)
        return self.all(F)

    def entry(self, *, aided):  # noqa: ARG002
        """Take one gyro and one accelerometer."""
        B = np.zeros((3, 6))
        B[2, GYRO] = B[1, FORCE] = 1.0
        return self.all(B)

    def seen(self, *, aided):  # noqa: ARG002
        """Ask for the states."""
        return self.all(np.eye(3))

    def aligned(self, *, aided):  # noqa: ARG002
        """Begin with a tilt, and the one that hides a force."""
        M = np.zeros((3, 6))
        M[2, TILT] = 1.0
        M[2, FORCE] = 1.0 / G
        return self.all(M)


def channel(times=TIMES, *, step=30.0, alignment=0.0, sign=1.0):
    """Return its growth in steps."""
    durations, asked, begun = [], [], 0.0
    for time in times:
        number = int(np.ceil((time - begun) / step))
        durations += [(time - begun) / number] * number
        asked.append(len(durations) - 1)
        begun = time
    at = Motion.of(np.array(durations), Channel())
    steps = Steps(
        durations=np.array(durations),
        nodes=Channel((len(durations), 4), sign, at.time),
        asked=tuple(asked),
        ends=Channel((len(times),), sign),
    )
    first = Channel(sign=sign)
    return Growth(first=first, alignment=alignment, steps=steps, aided=True)


def position_of(noise, row, u, **options):
    """Return standard deviations of position at the times [m]."""
    C = channel(**options).of_noise([AxisNoise(row=row, noise=noise, u=u)])
    return np.sqrt([C[i, 0, i, 0] for i in range(len(C))])


def constants(**options):
    """Return what a unit of each input becomes, shape (times, 3, 6)."""
    return channel(**options).of_constants(lambda _: np.eye(6))


def to_position(row, t):
    """Return the position at t after an impulse of an input."""
    return -R * (1.0 - np.cos(WS * t)) if row == GYRO else np.sin(WS * t) / WS


def variance_of_markov(tau, row, t, *, nodes=80):
    """Return the variance of position at t by Gauss' quadrature over both times."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    late, early = t * x[:, None], t * np.outer(x, x)
    area = t * w[:, None] * t * np.outer(x, w)
    both = to_position(row, t - late) * to_position(row, t - early)
    return 2.0 * (area * both * np.exp((early - late) / tau)).sum()


def test_constants():
    """Gyro, accelerometer and tilt: R (t - sin/ws), (1 - cos)/ws^2, R (1 - cos)."""
    t = np.array(TIMES)
    S = constants()[:, 0]
    cos = 1.0 - np.cos(WS * t)
    assert_allclose(-S[:, GYRO], R * (t - np.sin(WS * t) / WS), rtol=1e-9)
    assert_allclose(S[:, FORCE], cos / WS**2, rtol=1e-9)
    # The tilt alone is known to begin with: nothing else enters by that input.
    tilted = constants(alignment=1.0)[:, 0]
    assert_allclose(-tilted[:, TILT], R * cos, rtol=1e-9)
    assert_allclose(tilted[:, FORCE], 0.0, atol=1e-6)  # hidden by the tilt [m per SI]
    gyro = [0.0171111, 16.6478, 1353.4137]
    assert_allclose(-S[:, GYRO] * 0.01 * DEG_PER_HOUR, gyro, rtol=4e-6)
    force = [1.76438, 168.517, 792.235]
    assert_allclose(S[:, FORCE] * 100 * MICRO_G, force, rtol=4e-6)


# Of the temperature: 0.1 degC/s from that of the test; 20 degC to it in 300 s.
RAMP = Profile((0.0, 3600.0), (0.0, 360.0))
WARM_UP = Fading(20.0, 300.0)


@pytest.mark.parametrize(
    ("row", "u", "course", "slope", "printed"),
    [
        (FORCE, 10 * MICRO_G, RAMP, lambda _: 0.1, (0.352942, 343.386)),
        (GYRO, 0.01 * DEG_PER_HOUR, RAMP, lambda _: 0.1, (0.0256690, 252.042)),
        (FORCE, 10 * MICRO_G, WARM_UP, None, (3.30478, 189.178)),
        (GYRO, 0.01 * DEG_PER_HOUR, WARM_UP, None, (0.325772, 215.049)),
    ],
    ids=["ramp, force", "ramp, gyro", "warm-up, force", "warm-up, gyro"],
)
def test_a_temperature_that_is_known(row, u, course, slope, printed):
    """Ramp in closed form, warm-up integrated by itself: 10 ug and 0.01 deg/h per K.

    (b r/ws^2) (t - sin(ws t)/ws) and b r R (t^2/2 - (1 - cos ws t)/ws^2).
    """
    times = TIMES[:2]
    b = np.zeros((6, 1))
    b[row] = u
    S = channel(times).of_constants(
        lambda moment: course.at(moment.time)[..., None, None] * b
    )
    found = np.abs(S[:, 0, 0])
    assert_allclose(found, printed, rtol=3e-6)

    def moved(t, x):
        T = 0.1 * t if slope else -20.0 * exp(-t / 300.0)
        a, e = (u * T if row == one else 0.0 for one in (FORCE, GYRO))
        return [x[1], -G * x[2] + a, x[1] / R + e]

    own = solve_ivp(
        moved, (0.0, 600.0), [0.0] * 3, t_eval=times, rtol=1e-11, atol=1e-15
    )
    assert_allclose(S[:, 0, 0], own.y[0], rtol=1e-7)
    if slope:
        t = np.array(times)
        x = WS * t
        closed = {
            FORCE: (t - np.sin(x) / WS) / WS**2,
            GYRO: R * (t**2 / 2 - (1 - np.cos(x)) / WS**2),
        }
        assert_allclose(found, u * slope(0.0) * closed[row], rtol=1e-8)
    # Control: at the temperature of its start all the way it is another.
    still = channel(times).of_constants(lambda _: course.at(np.array(60.0)) * b)
    assert (np.abs(still[:, 0, 0] / found) < 0.9).any()


def test_white_noise_and_walk():
    """Variances of position of ARW, VRW and RRW, each in closed form."""
    t = np.array(TIMES)
    x = WS * t
    s, s2 = np.sin(x), np.sin(2 * x)
    arw = R**2 * (1.5 * t - 2 * s / WS + s2 / (4 * WS))
    vrw = (0.5 * t - s2 / (4 * WS)) / WS**2
    rrw = x**3 / 3 + x / 2 + 2 * x * np.cos(x) - 2 * s - s2 / 4
    # These differences lose digits while ws t is small.
    lost = 1e-14 / x**5
    for row, noise, variance in (
        (GYRO, UnitWhiteNoise(), arw),
        (FORCE, UnitWhiteNoise(), vrw),
        (GYRO, UnitRandomWalk(), rrw * R**2 / WS**3),
    ):
        found = position_of(noise, row, 1.0) ** 2
        assert np.all(np.abs(found / variance - 1.0) < 1e-9 + lost), (row, noise)
    printed = [27.21109, 778.5128]
    assert_allclose(position_of(UnitWhiteNoise(), GYRO, ARW)[1:], printed, rtol=1e-7)


@pytest.mark.parametrize(
    ("row", "sigma", "printed"),
    [
        (GYRO, 0.04 * DEG_PER_HOUR, (55.1111, 2444.57)),
        (FORCE, 20 * MICRO_G, (26.7157, 145.173)),
    ],
)
def test_gauss_markov(row, sigma, printed):
    """Against its correlation function, integrated twice by quadrature."""
    found = position_of(Markov(times=(300.0,)), row, sigma)
    assert_allclose(found[1:], printed, rtol=3e-6)
    variances = [variance_of_markov(300.0, row, t) for t in TIMES]
    more = [variance_of_markov(300.0, row, t, nodes=90) for t in TIMES]
    assert_allclose(variances, more, rtol=1e-11)
    assert_allclose(found, sigma * np.sqrt(variances), rtol=1e-9)


@pytest.mark.parametrize("tau", [1e-9, 1e-3, 0.3, 1.4, 1.6, 7.0, 40.0, 1e4, 1e9])
def test_any_correlation_time(tau):
    """Far below a step as far above the mission: against the step of an hundredth."""
    one = channel((90.0,), step=30.0)
    many = channel((90.0,), step=0.3)
    part = [AxisNoise(row=GYRO, noise=Markov(times=(tau,)), u=1.0)]
    C, D = one.of_noise(part)[0, :, 0], many.of_noise(part)[0, :, 0]
    size = np.sqrt(np.outer(np.diag(D), np.diag(D)))
    assert_allclose(C / size, D / size, rtol=0, atol=1e-8)
    if tau < 1e-6:
        white = [AxisNoise(row=GYRO, noise=UnitWhiteNoise(), u=(2 * tau) ** 0.5)]
        expected = one.of_noise(white)[0, :, 0]
        assert_allclose(C / size, expected / size, rtol=0, atol=1e-8)


def test_rounding_of_angles():
    """Errors q/sqrt(12) of the angle at every sample, added up one by one."""
    period, until = 0.5, 60.0
    found = channel((until,)).of_noise(
        [AxisNoise(row=GYRO, noise=Rounding(period=period), u=1.0)]
    )[0, :, 0]
    # Rate is the difference of errors e at the ends of a sample, over its length.
    edges = np.arange(0.0, until + period / 2, period)
    x = WS * (until - edges)
    whole = np.array([-R * (until - edges - np.sin(x) / WS), R * WS * (np.cos(x) - 1)])
    whole = np.stack([whole[0], -R * (1 - np.cos(x)), np.sin(x) / WS])
    of_sample = (whole[:, :-1] - whole[:, 1:]) / period
    of_edge = np.pad(of_sample, ((0, 0), (1, 0))) - np.pad(of_sample, ((0, 0), (0, 1)))
    expected = of_edge @ of_edge.T / 12.0
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    # The last angle alone is off in tilt; continuous e against samples is 0.5/60.
    assert_allclose(found / size, expected / size, rtol=0, atol=0.02)


def test_rounding_that_an_alignment_meets():
    """The mean of a force over 4 s is off by (e - e before)/4 s, and e goes on."""
    period, until, T = 0.5, 60.0, 4.0
    part = [AxisNoise(row=FORCE, noise=Rounding(period=period), u=1.0)]
    found = channel((until,), alignment=T).of_noise(part)[0, :, 0]
    edges = np.arange(0.0, until + period / 2, period)
    x = WS * (until - edges)
    # What a unit of force since each edge is at the end, and a tilt from the begin.
    whole = np.stack([(1 - np.cos(x)) / WS**2, np.sin(x) / WS, (1 - np.cos(x)) / G])
    x = WS * until
    tilt = np.array([-R * (1 - np.cos(x)), -G * np.sin(x) / WS, np.cos(x)]) / G / T
    of_sample = (whole[:, :-1] - whole[:, 1:]) / period
    of_edge = np.pad(of_sample, ((0, 0), (1, 0))) - np.pad(of_sample, ((0, 0), (0, 1)))
    of_edge[:, 0] += tilt
    expected = (of_edge @ of_edge.T + np.outer(tilt, tilt)) / 12.0
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert_allclose(found / size, expected / size, rtol=0, atol=0.02)
    # Control: without the alignment the position is another.
    other = channel((until,)).of_noise(part)[0, 0, 0, 0]
    assert abs(other / expected[0, 0] - 1.0) > 0.1


def test_a_wrong_channel_is_seen():
    """Control: errors that do not swing are 36 %, not 1e-9, off after an hour."""
    off = constants(sign=0.0)[2, 0, GYRO] / constants()[2, 0, GYRO]
    assert off > 1.3
    fast = position_of(Markov(times=(301.0,)), GYRO, 1.0, times=(600.0,))
    slow = position_of(Markov(times=(300.0,)), GYRO, 1.0, times=(600.0,))
    assert abs(fast / slow - 1.0) > 1e-4
