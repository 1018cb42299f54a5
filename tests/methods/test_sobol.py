"""Sobol' indices: exact ones found, at the stated rate; SALib as the referee."""

from __future__ import annotations

import numpy as np
import pytest
from builders import paper_accelerometer, paper_gyro, procedure
from numpy.testing import assert_allclose, assert_array_equal
from SALib.analyze import sobol as salib_analyze
from SALib.sample import sobol as salib_sample
from scipy.stats import binom, qmc

from budget.calibration.problem import calibration_problem
from budget.distributions import ARCSINE, NORMAL, TRIANGULAR, UNIFORM
from budget.errors import CallError, ProblemError
from budget.methods.gum import propagate
from budget.methods.sobol import (
    _Draws,
    _factors,
    _inputs,
    _one_scramble,
    evaluations,
    sobol,
)
from budget.problem import Group, Output, Problem

ISHIGAMI_FIRST = (0.313905191148, 0.442411144790, 0.0)
ISHIGAMI_TOTAL = (0.557588855210, 0.442411144790, 0.243683664062)


def wave(x):
    """Return the Ishigami function of x (3, trials)."""
    return (np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0]))[
        None
    ]


def ishigami():
    """Return the Ishigami function of three uniform inputs on (-pi, pi)."""
    return Problem(
        groups=tuple(
            Group.independent(f"x{i}", u=np.pi / np.sqrt(3.0), distribution=UNIFORM)
            for i in (1, 2, 3)
        ),
        outputs=(Output(name="y"),),
        function=wave,
    )


def paper_problem(**more):
    """Return the built-in calibration with further gyro lines."""
    return calibration_problem((paper_gyro(**more), paper_accelerometer()), procedure())


def rate_inside(seeds, shift=0.0):
    """Return how often the six exact indices lie in their intervals."""
    exact = np.concatenate([ISHIGAMI_FIRST, ISHIGAMI_TOTAL]) + shift
    inside = 0
    for seed in range(seeds):
        r = sobol(ishigami(), samples=256, seed=seed)
        low = np.concatenate([r.first.low[:, 0], r.total.low[:, 0]])
        high = np.concatenate([r.first.high[:, 0], r.total.high[:, 0]])
        inside += int(((low <= exact) & (exact <= high)).sum())
    return inside


@pytest.mark.slow
def test_intervals_cover_the_exact_indices_at_their_stated_rate():
    """Over 200 seeds the 95 % intervals hold the exact Ishigami indices.

    Six indices of one seed share their points, so at worst they count as one: the
    bounds are those of 200 tries at p = 1e-4, and so wide.
    """
    rate = rate_inside(200) / (6 * 200)
    assert rate > binom.ppf(1e-4, 200, 0.95) / 200


def test_the_coverage_check_can_fail():
    """Control: exact indices moved by 0.01 are not covered at that rate."""
    assert rate_inside(40, shift=0.01) / (6 * 40) < binom.ppf(1e-4, 40, 0.95) / 40


def test_points_and_indices_are_salibs_own():
    """One scramble gives SALib's sample bit for bit and its analyze's indices."""
    n, problem = 512, ishigami()
    names = [group.name for group in problem.groups]
    spec = {"num_vars": 3, "names": names, "bounds": [[-np.pi, np.pi]] * 3}
    seed = np.random.default_rng(np.random.SeedSequence(7, spawn_key=(0,)))
    x = salib_sample.sample(spec, n, calc_second_order=False, seed=seed)
    referee = salib_analyze.analyze(spec, wave(x.T)[0], calc_second_order=False, seed=1)

    rng = np.random.default_rng(np.random.SeedSequence(7, spawn_key=(0,)))
    points = qmc.Sobol(6, scramble=True, seed=rng).random(n).T
    # SALib's rows are A, AB1, AB2, AB3, B for every point.
    assert_allclose(_inputs(problem, points[:3]), x[::5].T, rtol=0, atol=1e-12)
    assert_allclose(_inputs(problem, points[3:]), x[4::5].T, rtol=0, atol=1e-12)

    draws = _Draws(samples=n, seed=7)
    factors = _factors(problem, by_input=False)
    first, total = _one_scramble(problem, factors, None, draws, 0)
    # SALib centres outputs on the mean of all rows, here it is that of A and B: a
    # difference of some 1e-3 of a standard deviation, squared.
    assert_allclose(first[:, 0], referee["S1"], rtol=0, atol=2e-6)
    assert_allclose(total[:, 0], referee["ST"], rtol=1e-9)


def test_indices_of_a_linear_model_are_its_variance_shares():
    """First and total equal c^2 u^2 / sum, for all four shapes, to 1e-9."""
    u = np.array([1.0, 2.0, 3.0, 4.0])
    problem = Problem(
        groups=tuple(
            Group.independent(f"x{i}", u=size, distribution=shape)
            for i, (size, shape) in enumerate(
                zip(u, (NORMAL, UNIFORM, TRIANGULAR, ARCSINE), strict=True)
            )
        ),
        outputs=(Output(name="y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )
    share = u**2 / np.sum(u**2)
    r = sobol(problem, samples=64)
    assert_allclose(r.first.value[:, 0], share, rtol=1e-9)
    assert_allclose(r.total.value[:, 0], share, rtol=1e-9)
    plain = sobol(problem, samples=1024, control_variate=False)
    assert (plain.first.low[:, 0] < share).all()
    assert (share < plain.first.high[:, 0]).all()


def test_indices_of_the_calibration_are_the_shares_of_the_law():
    """All 24 outputs: shares of the law are found, its interactions negligible."""
    problem = paper_problem()
    law = propagate(problem)
    share = law.source_variance / np.diag(law.covariance)
    r = sobol(problem, samples=256)
    # The model departs from its tangent by some 1e-5 of a standard uncertainty.
    assert_allclose(r.first.value, share, rtol=0, atol=1e-5)
    assert_allclose(r.total.value, share, rtol=0, atol=1e-5)


def test_the_control_variate_sharpens_the_same_points():
    """With the tangent as control variate intervals are 1000 times narrower."""
    problem = paper_problem()
    sharp = sobol(problem, samples=256)
    plain = sobol(problem, samples=256, control_variate=False)
    gain = (plain.first.high - plain.first.low).max() / (
        sharp.first.high - sharp.first.low
    ).max()
    assert gain > 1000.0


def test_products_show_as_interaction():
    """Y = x1 x2 + x3: x1 and x2 have first 0, total 1/2; x3 1/2 and 1/2."""
    problem = Problem(
        groups=tuple(Group.independent(n, u=1.0) for n in ("x1", "x2", "x3")),
        outputs=(Output(name="y"),),
        function=lambda x: (x[0] * x[1] + x[2])[None],
    )
    r = sobol(problem, samples=4096)
    assert (r.interaction.low[:2, 0] > 0.4).all()
    assert r.interaction.low[2, 0] < 0.0 < r.interaction.high[2, 0]
    assert_allclose(r.total.value[:, 0], [0.5, 0.5, 0.5], rtol=0, atol=0.05)
    assert r.ranks(0) == (1, 1, 1)


def test_ranks_part_what_can_be_told_apart():
    """Ishigami's totals 0.56, 0.44, 0.24 rank 1, 2, 3."""
    assert sobol(ishigami(), samples=4096).ranks(0) == (1, 2, 3)


def test_constant_sources_and_outputs_are_left_out():
    """A source of zero has no index; an output without variance has nan, no crash."""
    problem = Problem(
        groups=(Group.independent("x", u=1.0), Group.independent("c", u=0.0, mean=2.0)),
        outputs=(Output(name="y"), Output(name="still")),
        function=np.copy,
    )
    r = sobol(problem, samples=64)
    assert r.factors == ("x",)
    assert_allclose(r.first.value[0, 0], 1.0, rtol=1e-12)
    assert np.isnan(r.first.value[0, 1])


def test_nothing_that_varies_is_refused():
    """A Problem of constants raises ProblemError."""
    problem = Problem(
        groups=(Group.independent("c", u=0.0),),
        outputs=(Output(name="y"),),
        function=np.copy,
    )
    with pytest.raises(ProblemError, match="no source varies"):
        sobol(problem)


def test_a_correlated_group_is_whole_or_refused():
    """A correlated source has an index as a whole; its inputs have none."""
    group = Group(
        name="pair",
        mean=np.zeros(2),
        covariance=np.array([[1.0, 0.5], [0.5, 1.0]]),
        distributions=(NORMAL, NORMAL),
    )
    problem = Problem(
        groups=(group, Group.independent("z", u=1.0)),
        outputs=(Output(name="y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )
    assert_allclose(
        sobol(problem, samples=64).first.value[:, 0], [0.75, 0.25], rtol=1e-9
    )
    with pytest.raises(ProblemError, match="'pair' are correlated"):
        sobol(problem, by_input=True)


def test_inputs_of_a_source_can_be_told_apart():
    """by_input gives an index to every single varying input."""
    problem = Problem(
        groups=(Group.independent("x", u=[1.0, 0.0, 2.0]),),
        outputs=(Output(name="y"),),
        function=lambda x: x.sum(axis=0, keepdims=True),
    )
    r = sobol(problem, samples=64, by_input=True)
    assert r.factors == ("x[0]", "x[2]")
    assert_allclose(r.first.value[:, 0], [0.2, 0.8], rtol=1e-9)


@pytest.mark.slow
def test_workers_change_no_index():
    """One and two processes give the same indices bit for bit."""
    alone = sobol(paper_problem(), samples=64, seed=2)
    shared = sobol(paper_problem(), samples=64, seed=2, workers=2)
    assert_array_equal(alone.first.value, shared.first.value)
    assert_array_equal(alone.total.low, shared.total.low)


def test_cost_is_known_beforehand():
    """The evaluations announced are those made: (sources + 2) N scrambles."""
    problem = ishigami()
    announced = evaluations(problem, 1000, 8)
    assert announced == sobol(problem, samples=1000).evaluations == 5 * 1024 * 8


def test_more_points_than_a_machine_keeps_are_refused():
    """Samples beyond a million a scramble are refused in words, before memory is."""
    problem = calibration_problem(
        (paper_gyro(),), procedure(), reference="nominal", only=None
    )

    with pytest.raises(CallError, match="at the most"):
        sobol(problem, samples=2**62)


G_A = np.array([0.0, 1.0, 4.5, 9.0])


def g_function():
    """Return Sobol's G function of four uniform inputs on (0, 1)."""
    a = G_A[:, None]
    return Problem(
        groups=tuple(
            Group.independent(
                f"x{i}", mean=0.5, u=1.0 / np.sqrt(12.0), distribution=UNIFORM
            )
            for i in range(len(G_A))
        ),
        outputs=(Output(name="y"),),
        function=lambda x: np.prod((np.abs(4.0 * x - 2.0) + a) / (1.0 + a), axis=0)[
            None
        ],
    )


def test_the_g_function_falls_back_to_no_control_variate():
    """Indices are the closed form, and the result says why there was no tangent.

    V_i = 1/(3 (1 + a_i)^2), V = prod(1 + V_i) - 1; first V_i/V, total V_i prod of the
    others' (1 + V_j) over V (Saltelli et al. 2010).
    """
    V_i = 1.0 / (3.0 * (1.0 + G_A) ** 2)
    V = np.prod(1.0 + V_i) - 1.0
    r = sobol(g_function(), samples=4096)
    assert_allclose(r.first.value[:, 0], V_i / V, rtol=0, atol=0.005)
    total = V_i * np.prod(1.0 + V_i) / (1.0 + V_i) / V
    assert_allclose(r.total.value[:, 0], total, rtol=0, atol=0.005)
    assert "abs has no two derivatives at 0" in r.note
    plain = sobol(g_function(), samples=64, control_variate=False)
    assert plain.note == ""
    assert_array_equal(plain.total.value, sobol(g_function(), samples=64).total.value)


def test_a_control_variate_leaves_no_note():
    """Where the tangent serves nothing is said."""
    assert sobol(ishigami(), samples=64).note == ""


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_values_that_are_not_finite_are_refused():
    """An infinite output raises ProblemError, where indices were nan."""
    problem = Problem(
        groups=(Group.independent("x", u=1.0),),
        outputs=(Output(name="y"),),
        function=lambda x: np.where(x > 1.0, np.inf, x),
    )
    with pytest.raises(ProblemError, match="not finite"):
        sobol(problem, samples=64)
