"""Devices against a requirement: verdicts, conformance and ranks, with confidence."""

from __future__ import annotations

import gc
from math import prod, sqrt

import numpy as np
import pytest
from builders import (
    CONSTANTS,
    K95,
    SIZES,
    bounded_bias,
    by_name,
    compared,
    device,
    line,
    only_bias,
    paper_device,
    procedure,
    requirement,
)
from numpy.testing import assert_allclose
from scipy.special import ndtr
from scipy.stats import binomtest

from budget.distributions import UNIFORM
from budget.problem import Problem
from budget.question import Question
from budget.studies.judgement import _binomial
from budget.units import DEG_PER_HOUR

# Verdicts


def test_small_errors_meet_and_large_ones_fail():
    """A device far inside its limits meets, the same twenty times worse fails."""
    found = compared([paper_device("good"), paper_device("bad", times=20.0)])

    assert by_name(found, "good").verdict == "meets"
    assert by_name(found, "bad").verdict == "fails"


def test_missing_line_stops_a_meets():
    """With an expected line missing nothing meets, however small the errors are."""
    found = compared([paper_device("good", missing=("bias_stability",))])

    assert found.devices[0].utilisation < 0.99
    assert found.devices[0].verdict == "undecidable"
    assert not found.is_met


def test_missing_line_does_not_excuse_a_fails():
    """A device that fails already fails whatever is missing."""
    found = compared([paper_device(times=20.0, missing=("bias_stability",))])

    assert found.devices[0].verdict == "fails"


def test_limit_inside_the_sampling_interval_is_undecided():
    """At a utilisation of 1 few trials do not tell: the interval holds 1."""
    row = compared([bounded_bias("edge", 1.0)], trials=2_000, max_trials=2_000)
    low, high = row.devices[0].utilisation_interval

    assert low <= 1.0 < high
    assert row.devices[0].verdict == "undecided"


def test_more_trials_settle_a_close_verdict():
    """Half a per cent beside the limit, 2,000 trials are not enough and more are."""
    # A quantile of the uniform distribution: sqrt(0.025 0.975/n) 2/0.95, so 0.7 % of
    # 2,000 trials and 0.03 % of 1.6e6.
    close = bounded_bias("close", 0.995)
    few = compared([close], trials=2_000, max_trials=2_000).devices[0]
    more = compared([close], trials=2_000, max_trials=1_600_000).devices[0]

    assert few.verdict == "undecided"
    assert more.verdict == "meets"
    assert 2_000 < more.trials <= 1_600_000


def test_clear_verdicts_get_no_more_trials():
    """What the first trials settle is not tried again."""
    found = compared(
        [paper_device("good"), paper_device("bad", times=20.0)],
        trials=20_000,
        max_trials=320_000,
    )

    assert {row.trials for row in found.devices} == {20_000}


def test_law_near_the_limit_advises_monte_carlo():
    """By gum, 0.97 of the limit carries the advice and 0.5 does not."""
    near, far = (
        compared([only_bias("x", part / K95)], method="gum").devices[0]
        for part in (0.97, 0.5)
    )

    assert "monte-carlo" in near.advice
    assert far.advice == ""


def test_utilisation_by_law_is_the_closed_form():
    """One bias of u against a limit L: utilisation k u / L."""
    row = compared([only_bias("x", 0.2)], method="gum").devices[0]

    assert_allclose(row.utilisation, K95 * 0.2, rtol=1e-9)
    assert row.margin == 1.0 - row.utilisation
    assert row.worst_output.startswith("gyro.bias")


def test_utilisation_by_trials_agrees_with_the_law():
    """A normal output has the law's utilisation to the rounding, a uniform its own.

    The interval of the sampling holds the closed form of the uniform one, 0.95 a; seed
    and trials are fixed, at 95 % one seed in twenty would miss.
    """
    normal = compared([only_bias("x", 0.2)]).devices[0]
    low, high = (
        compared([bounded_bias("x", 0.5)], trials=100_000, max_trials=100_000)
        .devices[0]
        .utilisation_interval
    )

    assert_allclose(normal.utilisation, K95 * 0.2, rtol=1e-9)
    assert {row.interval_by for row in normal.outputs} == {"law"}
    assert low < 0.5 < high
    assert not low < 0.51 < high  # control


# Conformance


def closed_conformance(u):
    """Return the probability that independent normal errors are all within."""
    parts = {
        "scale_factor": (3, u["scale_factor_repeatability"]),
        "mounting_angle": (6, u["mounting_repeatability"]),
        "bias": (3, u["bias_repeatability"]),
    }
    return prod(
        (2.0 * ndtr(SIZES["gyro"][name] / size) - 1.0) ** n
        for name, (n, size) in parts.items()
    )


@pytest.mark.parametrize(
    ("method", "trials"), [("gum", 16_384), ("monte-carlo", 20_000)]
)
def test_conformance_of_independent_errors(method, trials):
    """Independent normal errors: the product, to 4 standard errors of the count."""
    found = compared([device("x", gyro=CONSTANTS)], method=method)
    expected = closed_conformance(CONSTANTS)
    error = sqrt(expected * (1.0 - expected) / trials)

    assert 0.05 < expected < 0.95
    conformance = found.devices[0].conformance
    assert_allclose(conformance.value, expected, rtol=0, atol=4.0 * error)
    if method == "gum":  # of the law: not sampled, and not sure
        assert conformance.low is None
    else:
        assert conformance.low < conformance.value < conformance.high
    assert abs(conformance.value - expected * 0.9) > 4.0 * error  # control


def test_joint_conformance_of_correlated_errors():
    """Noise that all share makes joint conformance larger than the product.

    Against a count in draws of the joint normal law, with the law's own covariance.
    """
    lines = {"bias_stability": 1.0 * DEG_PER_HOUR}
    found = compared([device("x", gyro=lines)], method="gum").devices[0]
    one = Question.of(
        device("x", gyro=lines), procedure=procedure(), requirement=requirement()
    )
    law, one = one.law, one.held
    rng = np.random.default_rng(5)
    n = 200_000
    y = rng.multivariate_normal(
        law.mean / one.limits,
        law.covariance / np.outer(one.limits, one.limits),
        n,
        method="eigh",
    )
    counted = (np.abs(y) <= 1.0).all(axis=1).mean()
    error = sqrt(counted * (1.0 - counted) * (1.0 / n + 1.0 / 16_384))

    product = prod(row.conformance for row in found.outputs)
    assert 0.05 < counted < 0.95
    assert_allclose(found.conformance.value, counted, rtol=0, atol=4.0 * error)
    assert found.conformance.value >= product - 4.0 * error


def test_errors_far_inside_conform_in_every_draw():
    """The short way for small errors gives what counting would: every draw inside."""
    found = compared([paper_device(times=1e-3)], method="gum").devices[0]

    assert found.conformance.value == 1.0
    assert found.conformance.low is None


@pytest.mark.parametrize(
    ("successes", "trials"), [(0, 50), (50, 50), (3, 200), (88, 100)]
)
def test_interval_of_a_proportion_is_clopper_pearsons(successes, trials):
    """The ends are those of scipy's exact binomial interval."""
    ours = _binomial(successes, trials)
    theirs = binomtest(successes, trials).proportion_ci(0.95, method="exact")

    assert_allclose([ours.low, ours.high], [theirs.low, theirs.high], rtol=1e-9)


# Ranks


def test_identical_devices_tie_and_draw_no_more():
    """The same lines under two names: probability one half, no further trials."""
    found = compared(
        [paper_device("a"), paper_device("b")], trials=20_000, max_trials=320_000
    )
    first, last = found.devices

    assert first.ahead.probability == 0.5
    assert first.ahead.is_tied
    assert {first.trials, last.trials} == {20_000}


def bounded_scale(name, used, bias, *, by="repeatability"):
    """Return a gyro whose worst error is a uniform scale factor; bias [deg/h]."""
    u = used * SIZES["gyro"]["scale_factor"] / (0.95 * sqrt(3.0))
    lines = [
        line(f"scale_factor_{by}", u, distribution=UNIFORM),
        line("bias_repeatability", bias * DEG_PER_HOUR),
    ]
    return device(name, gyro=lines)


@pytest.mark.parametrize("used", [0.5, 4.3])
def test_what_has_the_same_worst_output_draws_no_more(used):
    """Another bias changes no rank where the scale factor decides.

    With four times the trials the two are as tied as before, to the last digit.
    """
    pair = [bounded_scale("a", used, 0.05), bounded_scale("b", used, 0.02)]
    found = compared(pair, trials=5_000, max_trials=80_000)
    assert [row.closer.trials for row in found.devices] == [5_000, 5_000]
    for number in (5_000, 20_000):
        found = compared(pair, trials=number, max_trials=number)
        assert found.devices[0].ahead.probability == 0.5
    other = [pair[0], bounded_scale("b", used, 0.05, by="nonlinearity")]
    found = compared(other, trials=5_000, max_trials=80_000)
    first, last = (row.closer.trials for row in found.devices)
    assert found.devices[0].ahead.is_tied or max(first, last) > 5_000
    # Of two that fail nobody chooses one: that tie stays as it is.
    assert (max(first, last) > 5_000) == (used < 1.0)


def test_what_nothing_parts_is_drawn_for_together():
    """Twins, one of them tied with a third device: both get the trials that it takes.

    With the trials of one alone their ends would differ, and so could their ranks.
    """
    three = [
        bounded_scale("a", 0.5, 0.05),
        bounded_scale("b", 0.5, 0.02),
        bounded_scale("c", 0.5, 0.03, by="nonlinearity"),
    ]
    found = compared(three, trials=5_000, max_trials=80_000)
    first, second = (by_name(found, name) for name in "ab")
    assert first.closer.trials == second.closer.trials > 5_000
    assert first.closer.used.tolist()[:3] == second.closer.used.tolist()[:3]


def test_common_random_numbers_part_close_devices():
    """A third of a per cent is told apart although each interval is wider than that."""
    found = compared(
        [bounded_bias("worse", 0.5 * 1.003), bounded_bias("better", 0.5)],
        trials=20_000,
        max_trials=20_000,
    )
    first, last = found.devices
    low, high = first.utilisation_interval

    assert (first.name, last.name) == ("better", "worse")
    assert first.ahead.probability > 0.975
    assert high > last.utilisation > low


def test_verdict_goes_before_utilisation():
    """A device that meets is ahead of a smaller utilisation that is undecidable."""
    found = compared(
        [
            paper_device("full", times=0.5),
            paper_device("bare", times=0.1, missing=("noise",)),
        ]
    )

    assert [row.name for row in found.devices] == ["full", "bare"]
    assert found.devices[0].ahead is None  # no probability across verdicts


def test_more_devices_move_no_number():
    """A device's numbers do not depend on who else is compared."""
    alone = compared([paper_device("a")]).devices[0]
    among = by_name(compared([paper_device("b", times=3.0), paper_device("a")]), "a")

    assert alone.utilisation == among.utilisation
    assert alone.conformance == among.conformance


def test_a_comparison_keeps_no_problem(monkeypatch):
    """Of chunks that are judged no Problem is left: of thousands all would stand."""
    monkeypatch.setattr("budget.studies.comparison.judging.CHUNK", 1)
    found = []

    def count(*_):
        gc.collect()
        found.append(sum(isinstance(one, Problem) for one in gc.get_objects()))

    devices = [paper_device(str(place)) for place in range(8)]
    gc.collect()
    gc.freeze()  # what the tests have made so far is not looked through each time
    try:
        count()
        compared(devices, method="gum", progress=count)
    finally:
        gc.unfreeze()

    assert len(found) > 8
    assert max(found) <= found[0] + 1
