"""Sweep of a line: each row is a budget of its own."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import budget

LINE = "gyro.bias_repeatability"
VALUES = ("0.01 deg/h", "0.02 deg/h", "0.05 deg/h")


def test_variance_grows_with_the_square_of_a_line():
    """A repeatability counts once from nominal: u^2 = u_0^2 + v^2, JCGM 100, (10)."""
    table = budget.sweep("zhao-2019", LINE, VALUES, outputs=["gyro.bias.z"])
    variance = table["standard_uncertainty"].to_numpy() ** 2
    v = np.array([float(text.split()[0]) for text in table["value"]])

    assert list(table["value"]) == list(VALUES)
    assert_allclose(np.diff(variance), np.diff(v**2), rtol=1e-6)
    assert_allclose(table["share"], v**2 / variance, rtol=1e-6)


def test_a_row_is_the_budget_of_the_replaced_device():
    """Numbers, limits and verdicts are those of `analyze` and of its requirement."""
    start = budget.load_device("zhao-2019").replace(
        {LINE: "0.1 deg/h", "gyro.bias_stability": "0.001 deg/h"}
    )
    wanted = "navigation-grade"
    table = budget.sweep(start, LINE, VALUES[:1], requirement=wanted)
    one = budget.analyze(
        start.replace({LINE: VALUES[0]}),
        requirement=wanted,
        reference="next_turn_on",
        validate=False,
    )
    row = one.output("gyro.bias.z").in_unit()
    (found,) = table.query(
        "sensor == 'gyro' and parameter == 'bias' and axis == 'z'"
    ).to_dict("records")
    (judged,) = (r for r in one.assessment.outputs if r.output.name == "gyro.bias.z")

    assert found["standard_uncertainty"] == row.standard_uncertainty
    assert (found["interval_low"], found["interval_high"]) == row.interval
    assert (found["limit"], found["utilisation"]) == (0.01, judged.utilisation)
    assert found["verdict"] == "fails"
    # The line that is swept, though another was changed after it first was.
    assert found["share"] > 0.1


def test_only_what_is_asked_for_is_in_it():
    """A requirement adds its columns, no rows."""
    table = budget.sweep(
        "zhao-2019",
        LINE,
        VALUES[:1],
        requirement="navigation-grade",
        outputs=["gyro.bias"],
    )
    assert list(table["axis"]) == ["x", "y", "z"]
    assert not table["verdict"].isna().any()


@pytest.mark.parametrize("values", ["0.1 deg/h", [], ["3 m"], [None], 5])
def test_values_that_are_none_are_refused(values):
    """One text, nothing and a wrong unit are told before anything is computed."""
    with pytest.raises(budget.BudgetError, match="bias_repeatability"):
        budget.sweep("zhao-2019", LINE, values)
