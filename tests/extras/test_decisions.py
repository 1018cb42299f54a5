"""Decisions on items: closed forms, JCGM 106's example, guard bands that keep."""

from __future__ import annotations

from math import inf, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from budget.distributions import NORMAL, TRIANGULAR, UNIFORM
from budget.errors import CallError
from budget.methods.decisions import acceptance_interval, global_risks
from jcgm import (
    conformance_probability,
    decide,
    gamma,
    global_guard_band,
    lognormal,
    specific_guard_band,
)

BEARINGS = {"mean": 1.0, "u": 0.5, "u_measurement": 0.25, "distribution": gamma(4.0)}


def test_guard_band_of_the_ball_bearings_of_jcgm_106():
    """For a consumer's risk of 0.1 % it is 0.3281712284559932 um, by Suncal: 9.5.4."""
    w = global_guard_band((-inf, 2.0), 0.001, **BEARINGS)
    assert_allclose(w, 0.3281712284559932, rtol=1e-6)


def test_conformity_of_one_item():
    """Phi of both distances; one limit at y = T_U - 1.645 u gives 95 %: clause 7."""
    p = conformance_probability(0.3, 0.5, (-1.0, 1.0))
    assert_allclose(p, stats.norm.cdf(1.4) - stats.norm.cdf(-2.6), rtol=1e-12)
    p = conformance_probability(1.0 - 1.6448536 * 0.1, 0.1, (-inf, 1.0))
    assert_allclose(p, 0.95, rtol=1e-8)
    p = conformance_probability(0.9, 0.2, (-inf, 1.0), distribution=UNIFORM)
    assert_allclose(p, 0.5 + 0.1 / (2.0 * sqrt(3.0) * 0.2), rtol=1e-12)


def test_a_decision_carries_its_own_risk():
    """Accepted, the risk is of not conforming; rejected, of conforming."""
    rule = {"tolerance": (-inf, 1.0), "acceptance": (-inf, 0.9)}
    taken, sent_back = decide(0.9, 0.1, **rule), decide(0.95, 0.1, **rule)
    assert (taken.is_accepted, sent_back.is_accepted) == (True, False)
    assert_allclose(taken.risk, stats.norm.sf(1.0), rtol=1e-12)
    assert_allclose(sent_back.risk, stats.norm.cdf(0.5), rtol=1e-12)


@pytest.mark.parametrize("tolerance", [(-inf, 1.0), (-1.0, inf), (-1.0, 1.0)])
@pytest.mark.parametrize("risk", [0.001, 0.05, 0.4, 0.9])
@pytest.mark.parametrize("shape", [NORMAL, TRIANGULAR, lognormal(0.4)])
def test_specific_guard_band_keeps_its_risk(tolerance, risk, shape):
    """At the worse acceptance limit the item conforms with 1 - risk, no more."""
    w = specific_guard_band(0.1, tolerance, risk, distribution=shape)
    ends = [e for e in acceptance_interval(tolerance, w) if np.isfinite(e)]
    worst = min(
        conformance_probability(y, 0.1, tolerance, distribution=shape) for y in ends
    )
    assert_allclose(worst, 1.0 - risk, rtol=1e-9)


@pytest.mark.parametrize("risk", [1e-5, 0.01, 0.03])
@pytest.mark.parametrize(("low", "high"), [(-inf, 1.0), (-1.0, inf), (-1.0, 1.0)])
def test_global_guard_band_keeps_its_risk(low, high, risk):
    """The rule that it makes has the consumer's risk that was asked for."""
    case = {"mean": 0.1, "u": 0.6, "u_measurement": 0.2}
    w = global_guard_band((low, high), risk, **case)
    found = global_risks((low, high), (low + w, high - w), **case)
    assert_allclose(found.consumer, risk, rtol=1e-7)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: conformance_probability(0.0, 0.0, (0.0, 1.0)), "u is 0.0"),
        (lambda: specific_guard_band(0.1, (0.0, 1.0), 1.0), "risk is 1.0"),
        (lambda: specific_guard_band(1.0, (0.0, 1.0), 0.05), "in the middle"),
        (
            lambda: global_guard_band((-inf, 2.0), 0.05, **BEARINGS),
            r"0\.04238 do not conform",
        ),
    ],
)
def test_what_is_no_rule_is_refused(call, words):
    """Each message says what is allowed."""
    with pytest.raises(CallError, match=words):
        call()
