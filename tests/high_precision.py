"""The calibration again, in 100 digits and in its simplest form: pulses and formulas.

Written from the model and the formulas of Zhao 2019, eqs. (1) to (5), (15), (16), and
the definition of a window average; nothing of budget.model is used. Differences of
nearly equal numbers, which the package avoids, cost nothing here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import mpmath
from mpmath import mpf

# A process of 1e20 s leaves 60 of them in the difference of two windows of 1 ms.
DIGITS = 100
STEP = mpf(10) ** -25  # of a difference quotient, over the size of the input
EARTH = mpf("7.292115e-5")  # [rad/s]
X, Y, Z = range(3)


# ---- windows and processes ----------------------------------------------------------


def gyro_windows(*, rate, turns, dwell, pause=0):
    """Return (start, length) of z+, z-, x+, x-, y+, y- and four dwells [s]."""
    turn = 2 * mpmath.pi * turns / (mpf(rate) * mpmath.pi / 180)
    return _back_to_back([turn] * 6 + [mpf(dwell)] * 4, mpf(pause))


def accelerometer_windows(*, dwell, pause=0):
    """Return (start, length) of the twelve dwells [s]."""
    return _back_to_back([mpf(dwell)] * 12, mpf(pause))


def _back_to_back(lengths, pause):
    windows, start = [], mpf(0)
    for length in lengths:
        windows.append((start, length))
        start += length + pause
    return windows


def white(windows, density):
    """Return the covariance of the averages of white noise: N^2/L."""
    n = len(windows)
    C = mpmath.zeros(n)
    for a, (_, length) in enumerate(windows):
        C[a, a] = mpf(density) ** 2 / length
    return C


def random_walk(windows, density):
    """Return the covariance of the averages of K times a Wiener process."""

    def element(a, b):
        s_a, L_a = min(windows[a], windows[b])
        return s_a + L_a / 3 if a == b else s_a + L_a / 2

    return mpf(density) ** 2 * _matrix(len(windows), element)


def gauss_markov(windows, sigma, tau):
    """Return the covariance of the averages of a first-order Gauss-Markov process."""
    tau = mpf(tau)

    def element(a, b):
        (s_a, L_a), (s_b, L_b) = sorted((windows[a], windows[b]))
        if a == b:
            x = L_a / tau
            return 2 * (x - 1 + mpmath.exp(-x)) / x**2
        gap = s_b - s_a - L_a
        if abs(gap) < L_a * mpf(10) ** (DIGITS // -2):
            gap = mpf(0)  # the sum of starts and lengths leaves the last digits
        return (
            mpmath.exp(-gap / tau)
            * (1 - mpmath.exp(-L_a / tau))
            * (1 - mpmath.exp(-L_b / tau))
            * tau**2
            / (L_a * L_b)
        )

    return mpf(sigma) ** 2 * _matrix(len(windows), element)


def _matrix(n, element):
    C = mpmath.zeros(n)
    for a in range(n):
        for b in range(a, n):
            C[a, b] = C[b, a] = element(a, b)
    return C


# ---- the calibration ----------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class State:
    """True values of one triad [SI]; `noise[axis][window]` are window averages."""

    bias: list
    angle: list  # xy, xz, yx, yz, zx, zy
    k: list
    asymmetry: list
    noise: list


def response(angle):
    """Return I + dT, eq. (1)."""
    xy, xz, yx, yz, zx, zy = angle
    return [[mpf(1), xz, -xy], [-yz, mpf(1), yx], [zy, -zx, mpf(1)]]


def calibrate_gyro(state, windows, *, rate, turns, latitude, azimuths, formulas):
    """Count the pulses of every window and use eqs. (3), (4); angles in degrees."""
    M = response(state.angle)
    static = [_earth(latitude, azimuth) for azimuth in azimuths]
    turned, seen_static = _seen_by_gyro(
        tuple(state.angle), tuple(state.bias), rate, latitude, azimuths
    )
    n, place = {}, 0
    for axis in (Z, X, Y):
        for sense in (1, -1):
            length = windows[place][1]
            for i in range(3):
                seen = turned[axis, sense][i] + state.noise[i][place]
                gain = (1 + state.k[i]) * (1 + sense * state.asymmetry[i] / 2)
                n[i, axis] = n.get((i, axis), 0) + sense * gain * seen * length
            place += 1
    mean_N, w = [mpf(0)] * 3, [mpf(0)] * 3
    for earth, shown in zip(static, seen_static, strict=True):
        for i in range(3):
            seen = shown[i] + state.noise[i][place]
            mean_N[i] += (1 + state.k[i]) * seen / len(azimuths)
            w[i] += earth[i] / len(azimuths)
        place += 1
    K = [n[i, i] / (4 * mpmath.pi * turns) for i in range(3)]
    angle = [
        -n[X, Z] / n[X, X],
        n[X, Y] / n[X, X],
        n[Y, Z] / n[Y, Y],
        -n[Y, X] / n[Y, Y],
        -n[Z, Y] / n[Z, Z],
        n[Z, X] / n[Z, Z],
    ]
    M = response(angle)
    v = [mean_N[i] / K[i] for i in range(3)]
    if formulas == "paper":
        bias = [sum(M[j][i] * v[j] for j in range(3)) - w[i] for i in range(3)]
    else:
        bias = [v[i] - sum(M[i][j] * w[j] for j in range(3)) for i in range(3)]
    return K, angle, bias


@cache
def _earth(latitude, azimuth):
    """Return the earth rate along the axes at an azimuth; 180 deg has the sine 0."""
    lat = mpf(latitude) * mpmath.pi / 180
    return (
        EARTH * mpmath.cos(lat) * mpmath.sinpi(mpf(azimuth) / 180),
        EARTH * mpmath.cos(lat) * mpmath.cospi(mpf(azimuth) / 180),
        EARTH * mpmath.sin(lat),
    )


@cache
def _seen_by_gyro(angle, bias, rate, latitude, azimuths):
    """Return M u + b of each turn, by axis and sense, and of each dwell: no noise."""
    M, omega = response(angle), mpf(rate) * mpmath.pi / 180
    _, north, up = _earth(latitude, 0)
    # Whole turns average the earth rate across the axis of the turn to zero.
    along = {X: [0, 0, 0], Y: [0, north, 0], Z: [0, 0, up]}

    def seen(rates):
        return [sum(M[i][j] * rates[j] for j in range(3)) + bias[i] for i in range(3)]

    turned = {}
    for axis, earth in along.items():
        for sense in (1, -1):
            rates = [sense * omega * (j == axis) + earth[j] for j in range(3)]
            turned[axis, sense] = seen(rates)
    return turned, [seen(_earth(latitude, azimuth)) for azimuth in azimuths]


def calibrate_accelerometer(state, *, gravity):
    """Count the pulses of the twelve dwells and use eq. (5), misprints mended."""
    M, g = response(state.angle), mpf(gravity)
    N, place = {}, 0
    for axis in (Z, X, Y):
        for sense in (1, -1):
            for _ in range(2):
                for i in range(3):
                    seen = sense * g * M[i][axis] + state.bias[i]
                    seen += state.noise[i][place]
                    key = i, axis, sense
                    N[key] = N.get(key, 0) + (1 + state.k[i]) * seen / 2
                place += 1

    def difference(i, axis):
        return (N[i, axis, 1] - N[i, axis, -1]) / (2 * g)

    K = [difference(i, i) for i in range(3)]
    angle = [
        -difference(X, Z) / K[X],
        difference(X, Y) / K[X],
        difference(Y, Z) / K[Y],
        -difference(Y, X) / K[Y],
        -difference(Z, Y) / K[Z],
        difference(Z, X) / K[Z],
    ]
    bias = [(N[i, i, 1] + N[i, i, -1]) / (2 * K[i]) for i in range(3)]
    return K, angle, bias


# ---- the law of propagation ---------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Expansion:
    """Derivatives of some outputs: C[k] a row, H[k] the elements that are not 0."""

    C: list
    H: list


def expand(function, sizes):
    """Differentiate a function by difference quotients about no deviation.

    `function` takes a list of n deviations and returns a list of outputs; `sizes` are
    the natural sizes of the inputs, which the steps are fractions of.
    """
    n = len(sizes)
    h = [STEP * size for size in sizes]
    middle = function([mpf(0)] * n)
    outputs = range(len(middle))

    def at(sign, *places):
        point = [mpf(0)] * n
        for place in places:
            point[place] = sign * h[place]
        return function(point)

    plus = [at(1, i) for i in range(n)]
    minus = [at(-1, i) for i in range(n)]
    # Mixed derivatives are of one side: right to a STEP, which is far below 1e-12.
    C = [[(plus[i][k] - minus[i][k]) / (2 * h[i]) for i in range(n)] for k in outputs]
    H = [{} for _ in outputs]
    for i in range(n):
        for k in outputs:
            own = plus[i][k] - 2 * middle[k] + minus[i][k]
            if own:
                H[k][i, i] = own / h[i] ** 2
        for j in range(i):
            both = at(1, i, j)
            for k in outputs:
                mixed = both[k] - plus[i][k] - plus[j][k] + middle[k]
                if mixed:
                    H[k][i, j] = H[k][j, i] = mixed / (h[i] * h[j])
    return Expansion(C=C, H=H)


def propagate(expansion, U):
    """Return u of every output by the second-order law for normal inputs.

    JCGM 100:2008, eq. (13) and the note to 5.1.2.
    """
    n, u = U.rows, []
    # Most of U and H is 0: the axes have little in common.
    columns = [[(i, U[i, j]) for i in range(n) if U[i, j]] for j in range(n)]
    for row, H in zip(expansion.C, expansion.H, strict=True):
        bent, HU = {}, {}
        for (i, k), part in H.items():
            bent.setdefault(i, {})[k] = part
        for i, parts in bent.items():
            for j, column in enumerate(columns):
                HU[i, j] = sum(parts[k] * part for k, part in column if k in parts)
        first = sum(
            row[j] * sum(row[i] * part for i, part in column)
            for j, column in enumerate(columns)
            if row[j]
        )
        second = sum(part * HU[j, i] for (i, j), part in HU.items() if (j, i) in HU) / 2
        u.append(mpmath.sqrt(first + second))
    return u
