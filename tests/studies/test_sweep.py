"""Sweep of a line: each row is a budget of its own."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

import budget

LINE = "gyro.bias_repeatability"
VALUES = ("0.01 deg/h", "0.02 deg/h", "0.05 deg/h")


def test_variance_grows_with_the_square_of_a_line():
    """A repeatability counts once from nominal: u^2 = u_0^2 + v^2, JCGM 100, (10)."""
    table = budget.sweep("zhao-2019", LINE, VALUES, outputs=["gyro.bias.z"])
    variance = table["standard_uncertainty"].to_numpy() ** 2
    v = table["value"].to_numpy()

    assert [f"{one} deg/h" for one in v] == list(VALUES)
    assert set(table["value_unit"]) == {"deg/h"}
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


@pytest.mark.parametrize(
    "values",
    [
        np.linspace(1.0, 3.0, 3),
        range(1, 4),
        [1, 2.0, np.float32(3.0)],
        ["1 deg/h", 2, "3 deg/h"],
        np.arange(1, 4)[:, None].repeat(3, axis=1),
    ],
)
def test_numbers_have_one_unit(values):
    """Arrays, ranges and lists with `unit=` are what texts with it are."""
    asked = {"outputs": ["gyro.bias.z"]}
    texts = budget.sweep("zhao-2019", LINE, ["1 deg/h", "2 deg/h", "3 deg/h"], **asked)
    table = budget.sweep("zhao-2019", LINE, values, unit="deg/h", **asked)

    found = table["standard_uncertainty"]
    assert_allclose(found, texts["standard_uncertainty"], rtol=1e-12)


def test_a_number_without_a_unit_is_refused():
    """What it is in is said, never guessed."""
    with pytest.raises(budget.CallError, match="without a unit; give unit="):
        budget.sweep("zhao-2019", LINE, [0.1])


def test_a_mission_is_swept():
    """Outputs by the names of its budget; north and east have half of the variance."""
    name = "mission.position"
    table = budget.sweep(
        "hg4930#C",
        "accelerometer.bias_repeatability",
        [1.0],
        unit="mg",
        mission="outage-60-s",
        at=["60 s"],
        outputs=[name],
    ).set_index("axis")
    u = table["standard_uncertainty"]

    assert set(table.index) == {"north", "east", "horizontal"}
    assert set(table["time [s]"]) == {60.0}
    assert_allclose(np.hypot(u["north"], u["east"]), u["horizontal"], rtol=1e-12)
    with pytest.raises(KeyError, match=r"mission\.position\.60 s"):
        budget.sweep(
            "hg4930#C",
            "accelerometer.bias_repeatability",
            ["1 mg"],
            mission="outage-60-s",
            outputs=["mission.position.61 s"],
        )


def test_a_long_table_prints_ten_rows():
    """How many there are is said; a part of it is a frame like any other."""
    table = budget.sweep("zhao-2019", LINE, VALUES)

    assert len(table) == 72
    assert "[72 rows x " in repr(table)
    assert len(repr(table).splitlines()) < 20
    assert table._repr_html_().count("<tr") < 20
    assert type(table[table["axis"] == "x"]) is pd.DataFrame


@pytest.mark.parametrize("values", ["0.1 deg/h", [], ["3 m"], [None], 5])
def test_values_that_are_none_are_refused(values):
    """One text, nothing and a wrong unit are told before anything is computed."""
    with pytest.raises(budget.BudgetError, match="bias_repeatability"):
        budget.sweep("zhao-2019", LINE, values)
