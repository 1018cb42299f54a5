"""Examples in docs/ run as printed and say what they say."""

from __future__ import annotations

import re

import numpy as np
from numpy.testing import assert_allclose
from places import DOCS

PROBLEMS = re.findall(
    r"```python\n(.*?)```",
    (DOCS / "problems.md").read_text(encoding="utf-8"),
    re.DOTALL,
)


def run(code):
    """Run a block of docs/problems.md; return its names."""
    names: dict[str, object] = {}
    exec(compile(code, "problems.md", "exec"), names)  # noqa: S102 - our own text
    return names


def test_the_problem_of_ones_own_runs_as_printed(capsys):
    """The example of docs/problems.md gives Table H.4 of JCGM 100:2008."""
    names = run(PROBLEMS[0])

    first = capsys.readouterr().out.splitlines()[0]
    u = [float(number) for number in first.strip("[]").split()]
    assert_allclose(u, [0.071, 0.2956, 0.236], rtol=0, atol=1e-3)
    assert_allclose(names["law"].standard_uncertainty, u, rtol=1e-6)


def test_the_example_of_shapes_runs_as_printed(capsys):
    """Law and Monte Carlo of docs/problems.md's four shapes agree on the mean."""
    names = run(PROBLEMS[1])
    law, trials = names["law"], names["trials"]

    assert len(capsys.readouterr().out.splitlines()) == 2
    error = law.mean - trials.mean
    # x1 x2^2 has E = 10.025 (4 + 1) = 50.1, exactly what the law says.
    assert_allclose(law.mean, [10.025 * 5.0], rtol=1e-12)
    assert abs(error[0]) < 5.0 * trials.standard_uncertainty[0] / 1e3


def test_the_example_of_a_copula_runs_as_printed(capsys):
    """The correlation that is drawn is the one given."""
    run(PROBLEMS[2])

    # Of the product of both, in units of u, the variance is below 3.
    assert abs(float(capsys.readouterr().out) + 0.5) < 5.0 * np.sqrt(3.0 / 200_000)


def test_the_example_of_regions_runs_as_printed():
    """The ellipse of trials is the law's, but for the bend of an arc of 0.02 rad."""
    names = run(PROBLEMS[3])
    law, ellipse = names["law"], names["ellipse"]

    assert_allclose(ellipse.factor, np.sqrt(5.991), rtol=0.01)
    assert_allclose(ellipse.covariance, law.covariance, rtol=0.02)
    assert ellipse.contains(law.mean[:, None]).all()


def test_the_example_of_decision_rules_runs_as_printed():
    """Of JCGM 106's bearings 4.2 % do not conform, 0.8 % of all are accepted so."""
    names = run(PROBLEMS[4])

    assert_allclose(1.0 - names["simple"].conforming, 0.042, rtol=0, atol=0.001)
    assert_allclose(names["simple"].consumer, 0.008, rtol=0, atol=0.001)
    assert_allclose(names["acceptance"][1], 1.67, rtol=0, atol=0.01)
    assert names["one"].is_accepted


def test_the_library_example_runs_as_printed(capsys):
    """The Python block of docs/results.md runs and gives a verdict for each sensor."""
    text = (DOCS / "results.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(code, "results.md", "exec"), {})  # noqa: S102 - our own text

    out = capsys.readouterr().out
    assert "gyro.bias_repeatability" in out
    assert "('gyro', 'fails'" in out
    assert "('accelerometer', 'fails'" in out
