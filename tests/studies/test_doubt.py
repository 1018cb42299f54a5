"""Probability to meet over what missing lines may be, and which one to ask for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from scipy.special import stdtr

from budget import load_device, load_requirement
from budget.missing import fill
from budget.missing.prediction import Prediction
from budget.names import Name
from budget.question import Question
from budget.studies.doubt import doubt_of, rooms, standard, weigh
from budget.studies.judgement import judge_with

A, B, C = (Name(f"line_{letter}", owner="gyro") for letter in "abc")
REQUIREMENT = load_requirement("catalogue-edge")


def predicted(names, scale, df=8.0):
    """Return a prediction with medians of 1."""
    n = len(names)
    return Prediction(
        names=names,
        location=np.zeros(n),
        scale=np.asarray(scale, dtype=float),
        df=df,
        devices=(("x",),) * n,
        designs=(3,) * n,
    )


@pytest.mark.parametrize("room", [0.2, 1.0, 7.0, 50.0])
def test_one_line_has_a_closed_form(room):
    """P = F_t(ln sqrt(room) / scale), and to know the line ends all doubt."""
    p, (worth,) = weigh(predicted((A,), [[0.49]]), np.array([[1.0]]), np.array([room]))
    expected = float(stdtr(8.0, 0.5 * np.log(room) / 0.7))

    # 32,768 points of low discrepancy: the third decimal at the worst.
    assert_allclose(p, expected, rtol=0, atol=5e-4)
    assert worth == min(p, 1.0 - p)


def test_worth_of_two_lines_is_that_of_brute_force():
    """Nested Monte Carlo of correlated lines: p, and what each one is worth."""
    scale = np.array([[0.5, 0.2], [0.2, 1.1]])
    unit = np.array([[0.4, 1.0], [0.9, 0.1]])
    room = np.array([2.5, 3.0])
    p, worth = weigh(predicted((A, B), scale), unit, room)
    rng = np.random.default_rng(7)
    df, outer, inner = 8.0, 1500, 1500

    def meets(x):
        return (np.exp(2.0 * x) @ unit <= room).all(axis=-1)

    # Conditional of a multivariate t (Ding, The American Statistician 70 (2016) 293).
    for m, other in ((0, 1), (1, 0)):
        x = np.sqrt(scale[m, m]) * rng.standard_t(df, outer)
        d = x**2 / scale[m, m]
        slope = scale[m, other] / scale[m, m]
        rest = scale[other, other] - slope * scale[m, other]
        spread = np.sqrt((df + d) / (df + 1.0) * rest)
        both = np.empty((outer, inner, 2))
        both[..., m] = x[:, None]
        both[..., other] = slope * x[:, None] + spread[:, None] * rng.standard_t(
            df + 1.0, (outer, inner)
        )
        q = meets(both).mean(axis=1)
        mean = float(q.mean())
        value = min(mean, 1.0 - mean) - float(np.minimum(q, 1.0 - q).mean())
        noise = 4.0 * 0.5 / np.sqrt(outer)  # standard error of a mean in [0, 1/2]

        assert abs(mean - p) < noise
        assert abs(value - worth[m]) < noise
        assert worth[m] > 0.02


def test_a_line_that_reaches_nothing_is_worth_nothing():
    """And one that decides all is worth all the doubt."""
    p, worth = weigh(
        predicted((A, B), np.diag([0.5, 0.5])),
        np.array([[1.0], [0.0]]),
        np.array([1.5]),
    )
    assert worth[1] == 0.0
    assert_allclose(worth[0], min(p, 1.0 - p), rtol=0.05)


def test_points_are_of_the_distribution():
    """Quantiles of each Student t, no correlation, the first in order."""
    t = standard(3, 8.0)
    levels = np.array([0.01, 0.05, 0.3, 0.5, 0.7, 0.95, 0.99])
    for one in t:
        below = stdtr(8.0, np.quantile(one, levels))
        assert_allclose(below, levels, rtol=0, atol=2e-3)
    assert np.abs(np.corrcoef(np.clip(t, -4.0, 4.0)) - np.eye(3)).max() < 0.01
    assert (np.diff(t[0]) >= 0.0).all()


def held_of(device):
    """Return the gyro of a device against the requirement, with its law."""
    return Question.of(device, requirement=REQUIREMENT).alone("gyro").held


def test_contributions_stand_for_the_law_of_every_draw():
    """Of lines drawn anew, the law itself meets where the rooms say so."""
    device, filling = fill(load_device("stim300#5g"), "predict", catalogue())
    held = held_of(device)
    prediction = filling.prediction.of(
        [name for name in filling.prediction.names if name.owner == "gyro"]
    )
    judged = judge_with(held, seed=0, trials=2_000)
    unit, room = rooms(prediction, held, judged)
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(20):
        times = np.exp(rng.normal(0.0, 1.5, len(prediction.names)))
        factor = {
            line.source.quantity: times[prediction.names.index(line.expected)]
            for line in filling.lines
            if line.expected in prediction.names
        }
        gyro = replace(
            device.gyro,
            lines=tuple(
                replace(line, u=line.u * factor.get(line.name, 1.0))
                for line in device.gyro.lines
            ),
        )
        now = held_of(replace(device, gyro=gyro))
        u = np.sqrt(np.diag(now.law.covariance))[now.rows]
        ends = np.abs(now.mean) + judged.factor * u
        by_law = bool((ends <= now.limits).all())
        assert bool((times**2 @ unit <= room).all()) == by_law
        seen.add(by_law)
    assert seen == {True, False}


def test_what_fails_by_given_lines_is_in_no_doubt():
    """A device beyond a limit by what it gives has no probability to meet."""
    sheet = load_device("sch16t-k01")
    kept = [line for line in sheet.gyro.lines if line.name != "g_sensitivity"]
    sheet = replace(sheet, gyro=sheet.gyro.with_lines(kept))
    device, filling = fill(sheet, "predict", catalogue())
    big = replace(
        device,
        gyro=replace(
            device.gyro,
            lines=tuple(
                replace(line, u=1e3 * line.u) if line.name == "bias_stability" else line
                for line in device.gyro.lines
            ),
        ),
    )
    for one, is_open in ((device, True), (big, False)):
        held = held_of(one)
        judged = judge_with(held, seed=0, trials=2_000)
        assert (doubt_of(filling.prediction, held, judged) is not None) == is_open
