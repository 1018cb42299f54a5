"""Noise models by the restricted likelihood of block means, held to dense algebra."""

from __future__ import annotations

from dataclasses import replace
from math import log, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from budget.methods.noise_fit import (
    AT_68,
    BlockMeans,
    Runs,
    allan_variance,
    fit_models,
    fit_noise,
    profile_interval,
    spectral_density,
    upper_bound,
)
from budget.methods.restricted import BlockProcess, restricted

BLOCK = 2.0  # [s]


def markov(s, t, n):
    """Return the covariance of block means of a Gauss-Markov process, by quadrature."""
    x = BLOCK / t
    lag = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    C = (s * 2.0 * np.sinh(x / 2.0) / x) ** 2 * np.exp(-x * lag)
    np.fill_diagonal(C, 2.0 * s**2 * (x - 1.0 + np.exp(-x)) / x**2)
    return C


def walk(K, n):
    """Return that of a random walk from 0: K^2 times the means of min(t, t')."""
    i = np.arange(n)
    C = K**2 * BLOCK * (np.minimum.outer(i, i) + 0.5)
    C[i, i] = K**2 * BLOCK * (i + 1.0 / 3.0)
    return C


def dense(y, X, V):
    """Return log determinants and squares of the restricted likelihood, as defined."""
    there = ~np.isnan(y)
    V, y, X = V[np.ix_(there, there)], y[there], X[there]
    inverse = np.linalg.inv(V)
    information = X.T @ inverse @ X
    b = np.linalg.solve(information, X.T @ inverse @ y)
    r = y - X @ b
    logs = np.linalg.slogdet(V)[1] + np.linalg.slogdet(information)[1]
    return logs, r @ inverse @ r, b


CASES = {
    "white": ([], []),
    "gm": ([(2.0, 30.0)], []),
    "slow gm": ([(2.0, 2e3)], []),
    "rw": ([], [0.5]),
    "both": ([(2.0, 30.0)], [0.5]),
    "many": ([(1.0, 2.0), (1.0, 8.0), (1.0, 32.0)], [0.3]),
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_the_dense_likelihood(name):
    """With missing blocks and a regressor, to the rounding of both."""
    n, rng = 60, np.random.default_rng(1)
    y = 3.0 * rng.standard_normal(n) + np.cumsum(rng.standard_normal(n))
    y[[0, 7, 8, 21]] = np.nan
    X = np.stack([np.ones(n), np.linspace(-1.0, 1.0, n)], axis=1)
    stationary, walks = CASES[name]
    V = 9.0 * np.eye(n)
    V = V + sum((markov(s, t, n) for s, t in stationary), np.zeros((n, n)))
    V = V + sum((walk(K, n) for K in walks), np.zeros((n, n)))
    processes = [BlockProcess.markov(s, t, BLOCK) for s, t in stationary]
    processes += [BlockProcess.walk(K, BLOCK) for K in walks]

    found = restricted(y, X, processes, 9.0)
    logs, squares, b = dense(y, X, V)
    assert_allclose(found.log_determinant, logs, rtol=1e-10)
    assert_allclose(found.squares, squares, rtol=1e-8)
    assert_allclose(found.fit, b, rtol=1e-7)
    assert found.freedom == n - 4 - 2


@pytest.mark.parametrize("form", ["ends", "means"])
@pytest.mark.parametrize("name", CASES)
def test_both_forms_are_the_dense_likelihood(name, form):
    """By the ends of blocks with hardly any white noise, by their means with enough."""
    n, rng = 40, np.random.default_rng(2)
    y = 3.0 * rng.standard_normal(n) + np.cumsum(rng.standard_normal(n))
    y[[3, 4, 39]] = np.nan
    X = np.ones((n, 1))
    stationary, walks = CASES[name]
    white = 0.05 if form == "ends" else 12.0
    V = white * np.eye(n)
    V = V + sum((markov(s, t, n) for s, t in stationary), np.zeros((n, n)))
    V = V + sum((walk(K, n) for K in walks), np.zeros((n, n)))
    of, to = (BlockProcess.markov, BlockProcess.walk)
    if form == "means":
        of, to = BlockProcess.of_means, BlockProcess.walk_of_means
    processes = [*(of(s, t, BLOCK) for s, t in stationary)]
    processes += [to(K, BLOCK) for K in walks]
    found = restricted(y, X, processes, white)
    logs, squares, b = dense(y, X, V)
    # To the rounding of the dense one, whose condition is some 1e5 here.
    assert_allclose(found.log_determinant, logs, rtol=1e-7)
    assert_allclose(found.squares, squares, rtol=1e-6)
    assert_allclose(found.fit, b, rtol=1e-6)


def test_short_blocks_of_a_process_join_long_ones():
    """The series for a block far below the correlation time, and the closed form."""
    for ratio in (0.99e-4, 1.01e-4):
        one = BlockProcess.of_means(3.0, BLOCK / ratio, BLOCK)
        assert_allclose(one.variance / 9.0, 1.0 + ratio**2 / 12.0, rtol=1e-12)
        assert_allclose(one.white / 9.0, -ratio / 3.0, rtol=2e-3)
    for ratio in (0.99e-3, 1.01e-3):  # s^2 x/6: of its ends what a walk leaves
        one = BlockProcess.markov(3.0, BLOCK / ratio, BLOCK)
        assert_allclose(
            one.white / 9.0, ratio / 6.0 * (1.0 - ratio**2 / 10.0), rtol=1e-9
        )
        assert_allclose(one.ends, 0.5 - ratio**2 / 24.0, rtol=1e-12)


def test_means_of_a_walk_take_white_noise_beside_them():
    """Their white part is negative; by its ends a walk takes none."""
    y, X = np.arange(5.0), np.ones((5, 1))
    step = BlockProcess.walk_of_means(1.0, BLOCK)
    assert restricted(y, X, [step], 0.99 * BLOCK / 6.0) is None
    assert restricted(y, X, [step], 1.01 * BLOCK / 6.0) is not None
    assert restricted(y, X, [BlockProcess.walk(1.0, BLOCK)], 1e-9) is not None


@pytest.mark.parametrize(("s", "t"), [(60.0, 3.0), (60.0, 20.0)])
def test_a_process_far_above_the_white_noise_is_found(s, t):
    """N of 0.5, which blocks of 2 s do not show beside it: the process is as it is.

    Where means stood for it white noise had to be as large as its negative white part.
    """
    rng, n, dt = np.random.default_rng(4), 400_000, 0.02
    p = np.exp(-dt / t)
    e = rng.standard_normal(n)
    e[0] /= sqrt(1.0 - p * p)
    slow = lfilter([s * sqrt(1.0 - p * p)], [1.0, -p], e)
    every = slow + 0.5 / sqrt(dt) * rng.standard_normal(n)
    data = BlockMeans(
        y=every.reshape(-1, 100).mean(axis=1),
        X=np.ones((4000, 1)),
        block=2.0,
        sample=dt,
    )
    fit = fit_noise(data, "gm")
    for name, truth in (("sigma", s), ("tau", t)):
        low, high = profile_interval(fit, name)
        assert low < truth < high
        assert high / low < 1.7
    assert fit.values["N"] < 3.0


def check_log():
    """Return three axes [deg/h]: N 9 with gm(6, 60 s), alone, with rw(0.3); means."""
    rng, n, dt = np.random.default_rng(8), 720_000, 0.01

    def white(N):
        return N / sqrt(dt) * rng.standard_normal(n)

    def gauss_markov(s, t):
        p = np.exp(-dt / t)
        e = rng.standard_normal(n)
        e[0] /= sqrt(1.0 - p * p)
        return lfilter([s * sqrt(1.0 - p * p)], [1.0, -p], e)

    x = white(9.0) + gauss_markov(6.0, 60.0) + 40.0
    y = white(9.0) - 25.0
    z = white(9.0) + 0.3 * sqrt(dt) * np.cumsum(rng.standard_normal(n)) + 10.0
    return [
        BlockMeans(
            y=one.reshape(-1, 200).mean(axis=1),
            X=np.ones((n // 200, 1)),
            block=2.0,
            sample=dt,
        )
        for one in (x, y, z)
    ]


@pytest.fixture(scope="module")
def axes():
    return check_log()


def test_a_process_is_found_and_how_well(axes):
    """A log of two hours of known numbers, fitted in another program, too."""
    best, second, *_ = fit_models(axes[0])

    assert best.model == "gm"
    assert second.model == "gm+rw"
    assert_allclose(second.bic - best.bic, log(3600.0), atol=0.05)
    values = [best.values[name] for name in ("N", "sigma", "tau")]
    assert_allclose(values, [9.045, 5.587, 44.53], rtol=1e-3)
    for name, ends in (
        ("N", (8.806, 9.292)),
        ("sigma", (5.003, 6.364)),
        ("tau", (33.06, 63.11)),
    ):
        assert_allclose(profile_interval(best, name), ends, rtol=2e-3)
    assert_allclose(best.mean, 40.0, atol=4.0 * best.mean_uncertainty[0])


def test_white_noise_is_no_more_than_that(axes):
    """Every other line has a bound, and its bound is above what was not put in."""
    best, second, *_ = fit_models(axes[1], ("white", "rw", "flicker"))

    assert best.model == "white"
    assert second.bic - best.bic > 6.0
    assert_allclose(best.values["N"], 8.968, rtol=1e-3)
    assert 0.0 < upper_bound(best, "K") < 0.05
    assert profile_interval(best, "N")[0] < 9.0 < profile_interval(best, "N")[1]


def test_a_walk_is_one_that_a_process_may_be_too(axes):
    """Neither is told from the other in two hours: BIC says 3.1."""
    best, second, *_ = fit_models(axes[2], ("white", "rw", "gm"))

    assert (best.model, second.model) == ("rw", "gm")
    assert_allclose(second.bic - best.bic, 3.14, atol=0.05)
    assert_allclose(best.values["K"], 0.3133, rtol=1e-3)
    assert_allclose(profile_interval(best, "K"), (0.2634, 0.3728), rtol=2e-3)


def test_an_interval_of_white_noise_is_that_of_its_sum_of_squares():
    """Of n - 1 differences: chi-square by its likelihood, in closed form."""
    n = 400
    y = np.random.default_rng(3).standard_normal(n)
    fit = fit_noise(BlockMeans(y=y, X=np.ones((n, 1)), block=1.0, sample=0.1), "white")
    s = float(np.std(y, ddof=1))
    assert_allclose(fit.values["N"], s, rtol=1e-12)

    for end in profile_interval(fit, "N"):
        r = (s / end) ** 2  # 2 l falls short by (n - 1)(r - 1 - ln r)
        assert_allclose((n - 1) * (r - 1.0 - log(r)), 3.8415, atol=2e-3)


def test_processes_beyond_any_block_have_a_likelihood_or_none():
    """One much faster than a block is as white as its means; none divides by 0."""
    y = np.random.default_rng(3).standard_normal(50)
    X = np.ones((50, 1))
    for time in (BLOCK / 1e4, 1e-7, 1e-300):
        one = BlockProcess.markov(3.0, time, BLOCK)
        x = BLOCK / time
        found = restricted(y, X, [one], 2.0)
        alike = restricted(y, X, [], 2.0 + 18.0 * (1.0 - 1.0 / x) / x)
        assert_allclose(found.log_likelihood, alike.log_likelihood, rtol=1e-7)
    assert restricted(y, X, [BlockProcess.markov(1e12, 1e6, BLOCK)], 1.0) is not None
    assert restricted(np.full(50, np.nan), X, [], 1.0) is None


def test_densities_integrate_to_variances():
    """One-sided: of a Gauss-Markov process sigma^2, of blocks as their Allan variance.

    The Allan variance is the integral of S(f) 2 sin^4(pi f t)/(pi f t)^2.
    """
    f = np.geomspace(1e-7, 1e5, 2_000_001)
    S = spectral_density({"N": 0.0, "sigma": 3.0, "tau": 20.0}, f)
    assert_allclose(np.trapezoid(S, f), 9.0, rtol=1e-4)
    for values in ({"N": 2.0}, {"K": 0.1}, {"sigma": 3.0, "tau": 20.0}, {"B": 4.0}):
        S = spectral_density(values, f)
        x = np.pi * f * 5.0
        found = np.trapezoid(S * 2.0 * np.sin(x) ** 4 / x**2, f)
        wanted = allan_variance(values, np.array([0.01, 5.0]), 1e6)[1]
        if "B" in values:  # a sum of processes, one for each factor of 4
            assert_allclose(found, 2.0 * np.log(2.0) / np.pi * 16.0, rtol=2e-3)
            assert_allclose(wanted, found, rtol=0.03)
            continue
        assert_allclose(found, wanted, rtol=2e-3)


def test_a_large_mean_leaves_the_likelihood_its_digits():
    """1 g beside noise of 1 ug: the same as without, to 1e-9."""
    y = np.random.default_rng(6).standard_normal(500)
    X = np.ones((500, 1))
    processes = [BlockProcess.markov(0.5, 30.0, BLOCK)]
    own, above = (restricted(y + level, X, processes, 1.0) for level in (0.0, 1e6))
    assert_allclose(above.log_likelihood, own.log_likelihood, rtol=1e-9)
    assert_allclose(above.fit - 1e6, own.fit, rtol=1e-6, atol=1e-9)


def _walks(seed, coefficient=0.02, number=1000, block=2.0, runs=2):
    """Return records of white noise of 1 with a random walk."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(runs):
        steps = rng.normal(0.0, coefficient * np.sqrt(block), number)
        y = rng.normal(0.0, 1.0 / np.sqrt(block), number) + np.cumsum(steps)
        ones = np.ones((number, 1))
        found.append(BlockMeans(y=y, X=ones, block=block, sample=0.01))
    return Runs(tuple(found))


@pytest.mark.parametrize("times", [1e3, 1e5, 1e9, 1e12, 1e20])
def test_a_process_too_slow_for_a_record_is_a_walk(times):
    """Its likelihood is that of a random walk of sigma sqrt(2/tau), to O(T/tau)."""
    (data,) = _walks(1, runs=1).records
    tau, K = times * data.duration, 0.02
    slow = {"N": 1.0, "sigma": K * np.sqrt(tau / 2.0), "tau": tau}
    found, walk = data.likelihood(slow), data.likelihood({"N": 1.0, "K": K})
    assert_allclose(
        found.log_likelihood, walk.log_likelihood, rtol=0, atol=1.0 / times + 1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_a_correlation_time_that_runs_away_gains_nothing(seed):
    """A walk costs one parameter less; N is known no better than by white noise alone.

    Of n means the logarithm of N has 1/sqrt(2 (n - 1)) at the least, Fisher's bound.
    """
    data = _walks(seed)
    walk, markov = (fit_noise(data, one) for one in ("rw", "gm"))
    assert markov.bic > walk.bic
    slow = replace(markov, values={**markov.values, "tau": 1e9 * data.duration})
    slow.values["sigma"] = walk.values["K"] * np.sqrt(slow.values["tau"] / 2.0)
    slow.values["N"] = walk.values["N"]
    slow = replace(slow, log_likelihood=walk.log_likelihood)
    for one in (walk, markov, slow):
        low, high = profile_interval(one, "N", AT_68)
        relative = 0.5 * np.log(high / low)
        assert relative > 0.98 / np.sqrt(2.0 * (data.number - 1))
