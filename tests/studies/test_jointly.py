"""Limits that are to be kept together: one utilisation, by trials and by the law."""

from __future__ import annotations

from math import erf, log, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.stats import norm

import budget
from budget.methods.largest import sampling_interval
from budget.studies.allocation.allocate import allocate
from budget.studies.comparison.compare import compare
from budget.studies.jointly import (
    NORMAL_TRIALS,
    POINTS,
    Components,
    Jointly,
    components_of,
    ends_together,
)

P = 0.95
Z = norm.ppf((1.0 + P) / 2.0)  # of one output alone
# Standard error of the quantile from as many plain draws, of one output [1].
PLAIN = sqrt(P * (1.0 - P) / POINTS) / (2.0 * norm.pdf(Z)) / Z
TRIALS = 100_000  # that a verdict is judged by at first


def jointly_of(covariance: np.ndarray, pairs: tuple = (), mean=0.0) -> Jointly:
    """Return limits of 1 on normal outputs; a group adds to the first of them."""
    n = len(covariance)
    more = np.zeros((1, n, n))
    more[0, 0, 0] = 1.0
    of = Components(
        rows=np.arange(n),
        limits=np.ones(n),
        pairs=np.array(pairs, dtype=int).reshape(-1, 2),
        mean=np.full(n, mean),
        covariance=covariance,
    )
    known = ((np.zeros(1), 1.0),)
    return Jointly(of=of, rest=covariance, parts=more, coverage=P, known=known)


class TestByLaw:
    """The quantile of the largest ratio against closed forms."""

    @pytest.mark.parametrize("n", [1, 3, 6, 24])
    def test_of_independent_outputs_probabilities_multiply(self, n):
        """Solve prod erf(t/(u_i sqrt 2)) = p for t, of several sizes."""
        u = np.linspace(1.0, 0.5, n)
        found = jointly_of(np.diag(u**2)).by_law(np.zeros(1))

        def excess(t: float) -> float:
            return np.prod([erf(t / (one * sqrt(2.0))) for one in u]) - P

        assert_allclose(found, brentq(excess, 0.1, 10.0), rtol=PLAIN)

    def test_what_hangs_together_counts_once(self):
        """24 outputs that are one have its quantile; Bonferroni's is 1.57 times it."""
        found = jointly_of(np.ones((24, 24))).by_law(np.zeros(1))
        assert_allclose(found, Z, rtol=PLAIN)
        bonferroni = norm.ppf(1.0 - (1.0 - P) / 48.0)
        assert bonferroni > 1.5 * found

    def test_a_length_is_of_its_two_components(self):
        """Equal variances: sigma sqrt(-2 ln(1 - p)) (Rayleigh)."""
        found = jointly_of(4.0 * np.eye(2), pairs=((0, 1),)).by_law(np.zeros(1))
        assert_allclose(found, 2.0 * sqrt(-2.0 * log(1.0 - P)), rtol=PLAIN)

    def test_a_mean_counts(self):
        """Of one output erf((t - m)/sqrt 2)/2 + erf((t + m)/sqrt 2)/2 = p."""
        found = jointly_of(np.eye(1), mean=0.7).by_law(np.zeros(1))

        def excess(t: float) -> float:
            return (erf((t - 0.7) / sqrt(2)) + erf((t + 0.7) / sqrt(2))) / 2.0 - P

        assert_allclose(found, brentq(excess, 0.1, 10.0), rtol=PLAIN)

    def test_it_grows_with_what_is_added(self):
        """No step of it down, but by what the points err; the last is far above."""
        rng = np.random.default_rng(3)
        A = rng.standard_normal((12, 5))
        one = jointly_of(A @ A.T / 5.0)
        found = [one.by_law(np.array([w])) for w in np.linspace(0.0, 3.0, 31) ** 2]
        assert (np.diff(found) > -PLAIN * found[0]).all()
        assert found[-1] > 1.5 * found[0]


class TestByTrials:
    """The utilisation that trials give."""

    def test_it_is_within_the_limit_where_enough_trials_are(self):
        """A part of p or more within is a t of 1 or less, to the last trial."""
        rng = np.random.default_rng(11)
        kept = []
        for _ in range(300):
            ratios = rng.exponential(1.0 / 3.0, rng.integers(50, 2000))
            t = ends_together(ratios, P).largest
            assert (t <= 1.0) == ((ratios <= 1.0).mean() >= P)
            kept.append(t <= 1.0)
        assert 0.1 < np.mean(kept) < 0.9

    def test_its_interval_covers(self):
        """Of 600 seeds 95 % contain the quantile of exponentials, -ln(1 - p)."""
        hits = np.zeros(2)
        for seed in range(600):
            ends = ends_together(np.random.default_rng(seed).exponential(size=4000), P)
            low, high = sampling_interval(ends)
            middle, half = ends.largest, (high - low) / 2.0
            off = abs(middle - (-log(1.0 - P)))
            hits += (off <= half, off <= 0.6 * half)  # the second is the control
        wide, narrow = hits / 600.0
        # 4 standard errors of the proportion; the density costs a little of it.
        assert abs(wide - 0.95) < 4.0 * sqrt(0.95 * 0.05 / 600.0)
        assert narrow < 0.95 - 4.0 * sqrt(0.95 * 0.05 / 600.0)


SHEET: dict[str, Any] = {
    "name": "whole sheet",
    "technology": "MEMS",
    "gyro": {
        "errors": {
            "bias_repeatability": "3 deg/h",
            "bias_stability": {"value": "1 deg/h", "correlation_time": "100 s"},
            "angle_random_walk": "0.1 deg/sqrt(h)",
            "scale_factor_repeatability": "100 ppm",
            "mounting_repeatability": "10 arcsec",
            "bias_temperature_coefficient": "0.3 deg/h/degC",
            "g_sensitivity": "1e-6 deg/h/g",
            "scale_factor_temperature_coefficient": "1e-6 ppm/degC",
        }
    },
    "accelerometer": {
        "errors": {
            "bias_repeatability": "0.5 mg",
            "bias_stability": {"value": "50 ug", "correlation_time": "100 s"},
            "velocity_random_walk": "0.05 m/s/sqrt(h)",
            "scale_factor_repeatability": "300 ppm",
            "mounting_repeatability": "10 arcsec",
            "bias_temperature_coefficient": "1e-3 ug/degC",
            "scale_factor_temperature_coefficient": "1e-6 ppm/degC",
        }
    },
}
OUTAGE = {
    "name": "outage of a minute",
    "mission": {"latitude": "45 deg", "segments": [{"stand": "60 s"}]},
}
TIMES = (20, 30, 40, 60)


def judged(
    length: float,
    *,
    decision: str = "joint",
    environment: str | None = "none",
    without: str = "",
    **more: Any,
):
    """Return the verdict of limits at four times, as squares of these [m at 60 s]."""
    sheet = {**SHEET, "gyro": {"errors": {**SHEET["gyro"]["errors"], **more}}}
    sheet["gyro"]["errors"].pop(without, None)
    position = [
        {"horizontal": f"{length * (t / 60.0) ** 2!r} m", "at": f"{t} s"} for t in TIMES
    ]
    coverage = P if decision == "joint" else 1.0 - (1.0 - P) / len(TIMES)
    found = budget.analyze(
        sheet,
        mission=OUTAGE,
        requirement={
            "name": "need",
            "decision": decision,
            "coverage": f"{100.0 * coverage!r} %",
            "limits": {"mission": {"position": position}},
        },
        procedure=budget.uncalibrated("factory", environment=environment),
        validate=False,
    )
    (sensor,) = found.assessment.sensors
    return sensor


# By sampling, of the trials and of the points that carry them on.
SAMPLED = 4.0 * sqrt(P * (1.0 - P) * (1.0 / TRIALS + 1.0 / POINTS))


@pytest.fixture(scope="module")
def length():
    """Return the limit at 60 s that is used in full [m]."""
    return 50.0 * judged(50.0).utilisation


class TestOfOneNumber:
    """The verdict, its utilisation and its conditions."""

    @pytest.mark.slow
    @pytest.mark.parametrize("used", [0.97, 0.995, 1.005, 1.02])
    def test_the_verdict_goes_by_the_utilisation(self, length, used):
        """With nothing missing `at_ceilings` is what the verdict was taken by."""
        found = judged(length / used)
        low, high = found.utilisation_interval
        verdict = "meets" if found.utilisation <= 1.0 else "fails"
        assert found.verdict == ("undecided" if low <= 1.0 < high else verdict)
        assert (found.utilisation <= 1.0) == (found.conformance.value >= P)
        if found.verdict != "fails":
            assert_allclose(found.at_ceilings, found.utilisation, rtol=1e-12)

    @pytest.mark.slow
    def test_a_unit_that_meets_has_room(self, length):
        """At 99 % of the limit some degrees; by Bonferroni there are none."""
        for decision, has_room in (("joint", True), ("each", False)):
            found = judged(length / 0.99, decision=decision, environment=None)
            bounds = [
                one.below
                for one in found.conditions
                if one.kind == "temperature" and one.below is not None
            ]
            assert (found.verdict == "meets_if" and bounds[0] > 0.0) == has_room

    @pytest.mark.slow
    def test_at_the_bound_of_a_line_the_limits_are_kept_with_p(self, length):
        """Put back into the sheet it gives p; the bound by Bonferroni gives more."""
        off = {}
        for decision in ("joint", "each"):
            left = judged(2.0 * length, decision=decision, without="bias_repeatability")
            assert left.verdict == "undecidable"
            (ask,) = left.asks
            size = f"{ask.below / ask.si_per_unit!r} {ask.unit}"
            back = judged(2.0 * length, bias_repeatability=size)
            off[decision] = abs(back.conformance.value - P)
        assert off["joint"] < SAMPLED < off["each"]

    @pytest.mark.slow
    def test_at_the_bound_of_a_temperature_the_limits_are_kept_with_p(self, length):
        """The same of a use that nobody has stated; all its coefficients are given.

        What is not given is at its ceiling in the bound, and 0 in what is put back.
        """
        found = judged(2.0 * length, environment=None)
        (bound, *_) = (
            one.below / one.si_per_unit
            for one in found.conditions
            if one.kind == "temperature" and one.below is not None
        )
        back = judged(2.0 * length, environment=f"temperature {bound!r} degC")
        assert abs(back.conformance.value - P) < SAMPLED


def test_lengths_are_the_last_rows_of_a_law():
    """Two components stand in the place of a length, each with its limit."""
    law = SimpleNamespace(
        value=np.zeros(4),
        legs=np.array([[0], [2]]),
        mean=np.array([0.5, 1.0, 1.5, 0.0]),
        covariance=np.diag([1.0, 4.0, 9.0, 10.0]),
    )
    held = SimpleNamespace(
        law=law,
        rows=np.array([1, 3]),
        lengths=np.array([-2, 0]),
        limits=np.array([2.0, 5.0]),
    )
    found = components_of(held)
    assert found.rows.tolist() == [1, 0, 2]
    assert found.pairs.tolist() == [[1, 2]]
    assert_allclose(found.mean, [0.5, 0.1, 0.3], rtol=1e-12)
    assert_allclose(np.diag(found.covariance), [1.0, 0.04, 0.36], rtol=1e-12)


TOGETHER = {
    "name": "together",
    "decision": "joint",
    "reference": "next_turn_on",
    "environment": "none",
    "limits": {"gyro": {"bias": "0.35 deg/h", "scale_factor": "300 ppm"}},
}


def test_the_fast_screen_is_of_the_same_number():
    """Draws of the normal law and trials of the model, both about one quantile."""
    used = {}
    for method in ("gum", "monte-carlo"):
        (row,) = compare(["zhao-2019"], TOGETHER, method=method).devices
        used[method] = row.utilisation
        low, high = row.utilisation_interval
        assert low < row.utilisation < high
        assert row.verdict == "meets"
    # Four standard errors of one output alone, from so many draws and trials.
    error = PLAIN * sqrt(POINTS / NORMAL_TRIALS + POINTS / TRIALS)
    assert_allclose(used["gum"], used["monte-carlo"], rtol=4.0 * error)


@pytest.mark.slow
def test_an_allocation_keeps_limits_together():
    """At its limits it is not said to fail; by a factor of each alone it was."""
    found = allocate("zhao-2019", requirement=TOGETHER)
    (standing,) = found.standings
    assert standing.sensor == "gyro"
    assert standing.verdict in {"meets", "undecided"}
