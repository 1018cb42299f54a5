"""Method section: the weights of each estimator, with all their digits and words."""

from __future__ import annotations

import numpy as np
import pytest
from reading import find, lines
from report_examples import make_budget

from budget import analyze, load_device, load_procedure
from budget.language import LANGUAGES, speaking
from budget.report.analysis.groups import budget_section
from budget.report.analysis.method import Trials, method_section
from budget.report.blocks import Equation, Table
from budget.report.tables import group_tables


def section_of(name, language="en"):
    """Return the section of a procedure of the catalogue."""
    devices, procedure = (load_device("zhao-2019"),), load_procedure(name)
    settings = make_budget().settings
    with speaking(language):
        return method_section(
            settings,
            procedure,
            devices,
            Trials(check=0, densities=0),
            of_verdict=settings,
        )


@pytest.mark.parametrize(
    "name", ["six-positions-and-turns", "one-axis-rate-table", "dividing-head"]
)
def test_weights_of_least_squares_are_unbiased(name):
    """Of every axis and of all alike: each takes its own input as it is, W A = I."""
    tables = find(section_of(name), Table)
    assert tables
    for table in tables:
        for group in table.groups:
            assert group.title[:5] == ("axis " if len(table.groups) == 3 else "")
            rows = np.array([[cell.exact for cell in row[1:]] for row in group.rows])
            u, W = rows[:, :3], rows[:, 3:]
            seen = W.T @ np.column_stack([u, np.ones(len(u))])
            own = np.flatnonzero(np.abs(W[:, :4]).sum(axis=0) > 0.0)
            assert own.size
            np.testing.assert_allclose(
                seen[np.ix_(own, own)], np.eye(len(own)), atol=1e-9
            )


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("norm-nine-positions", {"accelerometer": (9, 1)}),
        ("norm-and-turns-by-hand", {"gyro": (12, 3), "accelerometer": (9, 1)}),
        ("dividing-head", {"accelerometer": (6, 3)}),
        ("hand-turns", {"gyro": (4, 1), "accelerometer": (4, 1)}),
    ],
)
def test_each_estimator_has_columns_for_what_it_weighs(name, sizes, language):
    """One for each parameter or power, in groups by axis; heads have units."""
    tables = find(section_of(name, language), Table)
    found = {
        table.name: (len(table.columns) - 4, len(table.groups)) for table in tables
    }
    assert found == {f"weights-{kind}": size for kind, size in sizes.items()}
    for table in tables:
        heads = [column.head for column in table.columns]
        assert len(set(heads)) == len(heads)
        assert all(head.endswith("]") for head in heads[1:4])
        assert {column.kind for column in table.columns[1:]} == {"number"}


def budget_of(name):
    """Return the section of the budgets by a procedure, figures left out."""
    procedure = load_procedure(name)
    groups = group_tables(analyze("zhao-2019", procedure=name, validate=False))
    return budget_section(groups, procedure, full=False)


def test_formulas_of_an_estimator_are_those_of_the_procedure():
    """Norm, rotation and least squares have theirs, the paper's are not there."""
    norm, turned, plain = (
        [one.math.source for one in find(budget_of(name), Equation)]
        for name in ("norm-nine-positions", "norm-and-turns-by-hand", "hand-turns")
    )
    assert "F_w = g_w^2 - g^2" in norm
    assert "sum W F = 0" not in norm
    assert {"F_w = g_w^2 - g^2", "sum W F = 0"} < set(turned)
    assert plain[1] == "W = (A^upright(T) A)^(-1) A^upright(T)"
    assert not any("n_(x 2)" in source for source in (*norm, *turned, *plain))


def test_what_is_held_and_what_is_estimated_besides_is_said():
    """Both are sentences behind the estimator, where the procedure has them."""
    said = {
        name: " ".join(lines(budget_of(name)))
        for name in ("one-axis-rate-table", "dividing-head", "hand-turns")
    }
    held, orders = "that is held", "estimated besides"
    assert [held in one for one in said.values()] == [True, False, False]
    assert [orders in one for one in said.values()] == [False, True, False]
