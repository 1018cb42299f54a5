"""Noise processes: closed forms against printed values, quadrature and mpmath."""

from __future__ import annotations

import tracemalloc

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import dblquad

from budget.model.noise import (
    ROWS,
    Flicker,
    GaussMarkov,
    Quantized,
    RandomWalk,
    White,
)
from budget.model.windows import Schedule, Window


def schedule(*windows):
    """Return a schedule of (start, length) windows."""
    return Schedule(
        windows=tuple(
            Window(name=str(i), start=start, length=length)
            for i, (start, length) in enumerate(windows)
        )
    )


@pytest.mark.parametrize(
    ("length", "variance", "adjacent"),
    [(18.0, "1.6567009763", "1.5920595937"), (300.0, "1.2434325112", "0.6752841175")],
)
def test_gauss_markov_check_values(length, variance, adjacent):
    """Sigma 1.3, tau 300 s: variance and adjacent covariance are as stated."""
    C = GaussMarkov(1.3, 300.0).covariance(schedule((0.0, length), (length, length)))
    assert_allclose(C[0, 0], float(variance), rtol=0, atol=1e-10)
    assert_allclose(C[0, 1], float(adjacent), rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("process", "kernel"),
    [
        (GaussMarkov(0.7, 40.0), lambda t, s: 0.49 * np.exp(-abs(t - s) / 40.0)),
        (RandomWalk(0.3), lambda t, s: 0.09 * min(t, s)),
    ],
)
def test_covariance_is_the_double_integral_of_the_kernel(process, kernel):
    """Each element is the mean of the autocovariance over both windows."""
    windows = [(0.0, 18.0), (18.0, 18.0), (60.0, 30.0)]
    C = process.covariance(schedule(*windows))
    for a, (s_a, L_a) in enumerate(windows):
        for b, (s_b, L_b) in enumerate(windows[a:], start=a):
            # Split at the kink of the kernel on the diagonal.
            below, above = (s_a, s_a + L_a) if a == b else (s_b, s_b + L_b)
            pieces = (
                [(below, lambda t: t), (lambda t: t, above)]
                if a == b
                else [(below, above)]
            )
            total = sum(
                dblquad(kernel, s_a, s_a + L_a, low, high, epsabs=0, epsrel=1e-9)[0]
                for low, high in pieces
            )
            assert_allclose(C[a, b], total / (L_a * L_b), rtol=1e-8)
            assert_allclose(C[b, a], C[a, b], rtol=1e-14)


def test_white_average_has_density_squared_over_length():
    """Windows of white noise are independent with variance N^2/L."""
    C = White(0.2).covariance(schedule((0.0, 10.0), (10.0, 40.0)))
    assert_allclose(C, np.diag([0.004, 0.001]), rtol=1e-14)


@pytest.mark.parametrize(
    ("process", "expected"),
    [
        (White(0.5), 2.0 * 0.25 / 20.0),
        (RandomWalk(0.5), 0.25 * (50.0 - 20.0 / 3.0)),
    ],
)
def test_difference_of_two_windows(process, expected):
    """Length T = 20, starts L = 50 apart: 2 N^2/T and K^2 (L - T/3)."""
    two = schedule((7.0, 20.0), (57.0, 20.0))
    assert_allclose(
        process.reduce(two, np.array([[1.0, -1.0]]))[0, 0], expected, rtol=1e-12
    )


@pytest.mark.parametrize("tau", [1e-9, 1e-3, 1.0, 17.9, 18.1, 300.0, 1e4, 1e9, 1e14])
def test_gauss_markov_differences_keep_their_digits(tau):
    """From far below a sample to far beyond the test, to 1e-9 of mpmath's 60 digits."""
    windows = schedule((0.0, 18.0), (18.0, 18.0), (40.0, 18.0))
    weights = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [0.5, 0.0, 0.5]])
    actual = GaussMarkov(1.0, tau).reduce(windows, weights)

    with mpmath.workdps(60):
        t, x = mpmath.mpf(tau), mpmath.mpf(18) / mpmath.mpf(tau)
        same = 2 * (x - 1 + mpmath.exp(-x)) / x**2

        def other(gap):
            return mpmath.exp(-gap / t) * ((1 - mpmath.exp(-x)) / x) ** 2

        C = mpmath.matrix(
            [
                [same, other(0), other(22)],
                [other(0), same, other(4)],
                [other(22), other(4), same],
            ]
        )
        W = mpmath.matrix(weights.tolist())
        exact = W * C * W.T
        exact = np.array([[float(exact[i, j]) for j in range(3)] for i in range(3)])
    # Elements far below the geometric mean of their diagonal carry its rounding.
    scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
    assert_allclose(actual / scale, exact / scale, rtol=0, atol=1e-9)


PROCESSES = (
    White(0.2),
    RandomWalk(0.3),
    GaussMarkov(1.3, 300.0),
    GaussMarkov(1.3, 1e6),
    Quantized(2.0),
    Flicker(1.5, 1e-5),
)


@pytest.mark.parametrize("process", PROCESSES, ids=repr)
def test_a_covariance_that_is_made_in_parts_is_that_of_the_whole(process):
    """Rows of ROWS windows and some more make what all of them at once make."""
    rng = np.random.default_rng(5)
    n = 2 * ROWS + 7
    windows = schedule(*((10.0 * k + 2.0 * (k % 2), 8.0) for k in range(n)))
    weights = rng.normal(size=(4, n))

    C = process.reduce(windows, weights)

    whole = weights @ process.covariance(windows) @ weights.T
    assert_allclose(C, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())


@pytest.mark.slow
@pytest.mark.parametrize("process", PROCESSES, ids=repr)
def test_memory_grows_with_the_windows_and_not_with_their_square(process):
    """No array of all windows by all windows is made; the covariance itself is one."""
    n = 3000
    windows = schedule(*((10.0 * k, 10.0) for k in range(n)))
    windows.starts, windows.lengths  # kept by the schedule  # noqa: B018

    def peak(work):
        tracemalloc.start()
        try:
            work()
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    square = 8 * n * n
    assert peak(lambda: process.reduce(windows, np.ones((4, n)))) < square
    assert peak(lambda: process.covariance(windows)) >= square


def repeated(times):
    """Return a test that repeats: three dwells, a pause, a turn; and its weights."""
    pattern = [(0.0, 13.7), (13.7, 13.7), (27.4, 13.7), (60.1, 20.3)]
    windows = schedule(*((91.3 * k + s, L) for k in range(times) for s, L in pattern))
    rng = np.random.default_rng(8)
    once = rng.normal(size=(3, len(pattern)))
    once[1] = 1.0, 0.0, -1.0, 0.0  # a difference, which no constant shows in
    return windows, np.tile(once, times) / times


@pytest.mark.parametrize("process", PROCESSES, ids=repr)
def test_repeated_windows_are_what_each_of_them_is(process):
    """Kinds of windows together make what all of them one by one make."""
    windows, weights = repeated(ROWS)
    whole = weights @ process.covariance(windows) @ weights.T
    scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole)))
    C = process.reduce(windows, weights)
    assert_allclose(C / scale, whole / scale, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_a_repetition_costs_its_lags_and_not_its_pairs(monkeypatch):
    """9,000 windows by 9,000 are 81 million pairs, of a few lags: 1 in 100 at most."""
    asked = []
    integral = Flicker._integral  # noqa: SLF001 - what is costly
    counted = lambda self, t: asked.append(t.size) or integral(self, t)  # noqa: E731
    monkeypatch.setattr(Flicker, "_integral", counted)
    windows, weights = repeated(2250)
    Flicker(1.5, 1e-5).reduce(windows, weights)
    assert sum(asked) < len(windows.windows) ** 2 / 100
    asked.clear()
    Flicker(1.5, 1e-5).reduce(*repeated(ROWS // 4))
    assert sum(asked) == 4 * ROWS**2  # few windows are multiplied out
