"""Numbers at the edge of what can be computed: bounded in words where they are read."""

from __future__ import annotations

import numpy as np
import pytest
from command_line import call

from budget.errors import CallError
from budget.methods.gum import propagate
from budget.methods.monte_carlo import sample
from budget.problem import Group, Output, Problem

BEYOND = (
    "99.99999999999999 %",
    "0.9999999999999",
    "1e-20 %",
    "0.00000099",
    "1e1000000",
    "1e-1000000",
    "1e999999999999999999 %",
    "nan",
)
WITHIN = ("0.0001 %", "1e-6", "99.9999999999 %", "0.999999999999")
REQUIREMENT = "name: r\ncoverage: {}\nlimits: {{gyro: {{bias: 1 deg/h}}}}\n"
COSTS = "costs: {{gyro.bias_repeatability: {{{}}}}}\n"


@pytest.mark.parametrize("text", BEYOND)
def test_a_coverage_at_the_edge_is_refused_on_the_command_line(text):
    """Exit code 2, and what is allowed."""
    run = call("analyze", "--no-validate", "--coverage", text, code=2)
    assert "from 1e-6 to 1 - 1e-12" in run.err
    assert "Traceback" not in run.err


@pytest.mark.parametrize("text", WITHIN)
@pytest.mark.parametrize("method", ["gum", "monte-carlo"])
def test_a_coverage_within_the_bounds_gives_finite_intervals(text, method):
    """The bounds themselves are allowed."""
    how = ("--method", method, "--json", "-")
    how += ("--no-validate",) if method == "gum" else ("--trials", "2000")
    run = call("analyze", "--coverage", text, *how, code=0)
    for row in run.document["outputs"]:
        low, high = row["interval"]
        assert np.isfinite([low, high]).all()
        assert low <= row["mean"] <= high or method == "monte-carlo"


@pytest.mark.parametrize("text", ["99.99999999999999 %", "1e-20 %", "1e20 %"])
def test_a_coverage_at_the_edge_is_refused_in_a_file(text, tmp_path, monkeypatch):
    """At its place in the requirement."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "r.yaml").write_text(REQUIREMENT.format(text), encoding="utf-8")
    run = call("validate", "r.yaml", code=2)
    assert run.err.startswith("r.yaml:2:11: coverage: ")
    assert "from 1e-6 to 1 - 1e-12" in run.err


@pytest.mark.parametrize("coverage", [0.0, 1e-7, 1.0 - 1e-13, 1.0, float("nan")])
def test_a_coverage_at_the_edge_is_refused_by_the_library(coverage):
    """By the law and by Monte Carlo alike."""
    x = Group.independent("x", u=1.0)
    y = Output(name="y", unit="1")
    problem = Problem(groups=(x,), outputs=(y,), function=lambda x: x)
    with pytest.raises(CallError, match="from 1e-6 to"):
        propagate(problem).interval(coverage)
    with pytest.raises(CallError, match="from 1e-6 to"):
        sample(problem, trials=1000, coverage=coverage)


@pytest.mark.parametrize(
    ("part", "place"),
    [("p: 400", "p: "), ("a: 1e308", "a: "), ("a: 1e-300", "a: "), ("p: 1e-9", "p: ")],
)
def test_a_cost_at_the_edge_is_refused(part, place, tmp_path, monkeypatch):
    """At its place in the costs file."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "c.yaml").write_text(COSTS.format(part), encoding="utf-8")
    run = call("validate", "c.yaml", code=2)
    assert run.err.startswith("c.yaml:1:")
    assert f"costs.gyro.bias_repeatability.{place}" in run.err


def test_a_cost_that_is_no_number_is_refused_in_words(tmp_path, monkeypatch):
    """A reference value far from the present one, to a high power."""
    monkeypatch.chdir(tmp_path)
    text = COSTS.format("a: 1e12, p: 10, u_ref: 1e30 deg/h")
    (tmp_path / "c.yaml").write_text(text, encoding="utf-8")
    how = ("--requirement", "navigation-grade", "--costs", "c.yaml", "--no-validate")
    run = call("allocate", *how, code=2)
    assert "gyro.bias_repeatability" in run.err
    assert "Traceback" not in run.err
