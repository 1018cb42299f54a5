"""The budget table: quantities, c, what they add up to, axes that agree once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import sqrt

import pytest
from numpy.testing import assert_allclose
from reading import lines
from report_examples import WIDE_LIMITS

from budget.inputs import load_device, load_procedure, load_requirement
from budget.known import AT_LEAST, AT_MOST
from budget.report.analysis.groups import budget_section
from budget.report.pages import blocks, line
from budget.report.tables import group_tables, print_divisor
from budget.resources import shipped
from budget.studies.analysis import analyze

COLUMNS = [
    *("quantity", "specification", "distribution", "divisor", "u(x)", "", "c"),
    *("", "c u(x) [deg/h]", "share [%]", "\N{GREEK SMALL LETTER NU}"),
]
PAGE = "analysis/group"
U_X, C, PART = 4, 6, 8  # places of u(x), c and c u(x)


@cache
def device(name):
    """Load a shipped device."""
    return load_device(shipped("specs") / "devices" / f"{name}.yaml")


@cache
def budget(name="zhao-2019", **settings):
    """Return its budget."""
    return analyze(device(name), validate=False, **settings)


def budget_table(group):
    """Return the budget table of a group."""
    (found,) = blocks(PAGE, "table", group=group)
    return found


def table(of, title):
    """Return the budget table of one group."""
    return next(budget_table(one) for one in group_tables(of) if one.title == title)


def texts(group):
    """Return the rows of a group by their heads."""
    return {row[0].text: [cell.text for cell in row] for row in group.rows}


def test_columns_are_those_of_a_budget():
    """JCGM 100:2008, 8.1 and EA-4/02: from the quantity to degrees of freedom."""
    found = table(budget(), "gyro bias")

    assert [column.head for column in found.columns] == COLUMNS


def test_axes_that_agree_stand_once():
    """The three biases of the paper's gyro are one group of rows, titled by axes."""
    (group,) = table(budget(), "gyro bias").groups

    assert not group.title
    title = next(g for g in group_tables(budget()) if g.title == "gyro bias")
    assert line(PAGE, "title", group=title) == "Gyro bias x, y, z [deg/h]"
    assert texts(group)["bias repeatability"][1:9] == [
        *("0.05 deg/h, 1 sigma", "normal", "1", "0.05", "deg/h", "1", "", "0.050")
    ]
    walk = texts(group)["angle random walk"]
    assert walk[C + 1] == "(deg/h)/(deg/sqrt(h))"


def test_axes_that_differ_stand_apart():
    """One axis with another value has rows of its own, with its u(x)."""
    changed = device("zhao-2019").replace({"gyro.bias_repeatability.y": "0.2 deg/h"})
    groups = table(analyze(changed, validate=False), "gyro bias").groups

    assert [group.title for group in groups] == ["x, z", "y"]
    assert [texts(group)["bias repeatability"][U_X] for group in groups] == [
        *("0.05", "0.2")
    ]


@pytest.mark.parametrize("settings", [{}, {"method": "monte-carlo", "trials": 20000}])
def test_printed_rows_multiply_and_add_up(settings):
    """As printed: u(x) times c is c u(x), and their squares sum to the combined u."""
    of = budget(**settings)
    for group in group_tables(of):
        found = budget_table(group)
        heads = [column.head for column in found.columns]
        place = heads.index(
            f"c u(x) [{group.unit}]"
        )  # after units of c, if any has one
        for own in found.groups:
            squares, seen = 0.0, 0
            for row in own.rows:
                part = float(row[place].text)
                if row[0].text.startswith("combined"):
                    assert_allclose(sqrt(squares), part, rtol=0.03)
                    seen = 1
                elif row[U_X].text:
                    product = float(row[U_X].text) * float(row[C].text)
                    assert_allclose(product, part, rtol=0.05)
                    squares += part**2
            assert seen == 1


def test_k_is_as_computed():
    """At 99.73 % k is 3 and infinite degrees of freedom are said."""
    (group,) = table(budget(coverage=0.9973), "gyro bias").groups
    rows = texts(group)

    assert rows["U99.73 = k u"][1] == "k = 3"
    assert rows["combined u"][-1] == "\N{INFINITY}"


def test_what_is_of_trials_says_so():
    """Under Monte Carlo rows are the law's, totals by axis where their u differ."""
    (group,) = table(
        budget(method="monte-carlo", trials=20000), "gyro scale factor"
    ).groups

    heads = [row[0].text for row in group.rows]
    assert heads.count("scale factor repeatability") == 1
    assert any("combined u, by monte-carlo" in head for head in heads)


def test_lower_bounds_are_marked():
    """Where an expected line is not given, u and U are this or more."""
    of = budget(only=("gyro.bias_stability",))
    (group,) = table(of, "gyro bias").groups
    assert next(iter(texts(group))) == "bias stability"

    lacking = analyze(
        load_device(shipped("specs") / "devices" / "bmi088.yaml"), validate=False
    )
    marked = [
        row
        for one in group_tables(lacking)
        for own in budget_table(one).groups
        for row in own.rows
        if row[0].text.startswith(("combined", "U95")) and AT_LEAST in row[-3].text
    ]
    assert marked


@pytest.mark.slow
def test_a_station_has_its_rows():
    """Station lines are quantities too; those that are many and small stand together.

    What is gathered has the root of the sum of squares of its parts.
    """
    procedure = load_procedure(
        shipped("specs") / "procedures" / "zhao-2019.yaml",
        station=shipped("specs") / "stations" / "three-axis-table.yaml",
    )
    of = analyze(device("zhao-2019"), procedure=procedure, validate=False)
    stationed = [
        row
        for one in group_tables(of)
        for own in budget_table(one).groups
        for row in own.rows
        if row[0].text.startswith("station ")
    ]

    assert stationed
    assert all(row[1].text and row[U_X].text for row in stationed)
    group = next(one for one in group_tables(of) if one.title == "gyro bias")
    rows = budget_table(group).groups[0]
    row = next(row for row in rows.rows if row[0].text.endswith("others together"))
    assert len(group.minor) > 8
    largest = max(
        sqrt(sum(source.cells[place].u.exact ** 2 for source in group.minor))
        for place in range(3)
    )
    assert_allclose(row[PART].exact, largest, rtol=1e-12)
    assert row[PART].text.startswith(AT_MOST)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        *((1.0, "1"), (3.0, "3"), (sqrt(3.0), "sqrt(3)"), (0.664, "0.664")),
        *((2.0 * sqrt(3.0), "2 sqrt(3)"), (sqrt(6.0), "sqrt(6)")),
        (2.0 * sqrt(2.0), "2 sqrt(2)"),
    ],
)
def test_divisors_are_printed_as_roots(value, text):
    """Those of a uniform, triangular or arcsine shape are roots, others numbers."""
    assert print_divisor(value) == text


def test_the_section_says_how_to_read_it():
    """What c is, and what correlation it carries, is said once."""
    section = budget_section(group_tables(budget()), load_procedure("zhao-2019"))
    said = " ".join(lines(section))

    assert "sensitivity coefficient" in said
    assert "correlation" in said


def test_a_predicted_line_says_whose_it_is():
    """A line of other devices has no divisor, and says that it is predicted."""
    sheet = load_device("ltm210#S10")
    of = analyze(sheet, validate=False, missing="predict")
    (group,) = table(of, "gyro mounting angle").groups
    row = texts(group)["mounting repeatability"]

    assert "predicted" in row[1]
    assert row[3] == ""
    assert row[U_X]


@cache
def judged_by_trials():
    """Return few simulated runs against wide limits: the law's intervals are kept."""
    return analyze(
        load_device("hg4930#A"),
        method="simulation",
        trials=20,
        requirement=load_requirement(WIDE_LIMITS),
        # A tenth of the samples: it is asked how u is said, not how large it is.
        procedure=replace(load_procedure(None), sample_rate=10.0),
    )


def test_u_of_trials_has_no_k_to_the_interval_of_the_law():
    """JCGM 100:2008, 6.2.1: k is U over u of one method; each total says its own."""
    of = judged_by_trials()
    row = of.output("gyro.bias.x")
    assert (row.interval_by, row.u_by, row.coverage_factor) == (
        *("law", "simulation"),
        None,
    )
    other = of.output("accelerometer.bias.x")
    half = (other.interval[1] - other.interval[0]) / 2.0
    assert_allclose(
        other.coverage_factor * other.standard_uncertainty, half, rtol=1e-12
    )

    (group,) = table(of, "gyro bias").groups
    heads = [one[0].text for one in group.rows]
    assert any(head.startswith("combined u, by simulation") for head in heads)
    assert any("interval from, by GUM propagation" in head for head in heads)
    assert not any(cell.text.startswith("k =") for one in group.rows for cell in one)


def test_u_of_trials_has_no_degrees_of_freedom():
    """They are of the law's u; a remark says whose rows and totals are."""
    of = judged_by_trials()
    (group,) = table(of, "gyro bias").groups
    combined = [one for one in group.rows if one[0].text.startswith("combined")]
    assert combined
    assert all(one[-1].text == "" for one in combined)
    assert {row.degrees_of_freedom for row in of.outputs} == {None}

    def remarks(one):
        groups = group_tables(one)
        said = (blocks(PAGE, "remarks", group=g, checked=True) for g in groups)
        return [str(x.words) for one in said for x in one]

    assert any("combined u by simulation" in text for text in remarks(of))
    assert not any("combined u by" in text for text in remarks(budget()))


def test_degrees_of_freedom_nobody_knows_are_blank():
    """A predicted line has none, nor has what it is in; nor has a lower bound."""
    of = analyze(load_device("ltm210#S10"), validate=False, missing="predict")
    (group,) = table(of, "gyro mounting angle").groups
    rows = texts(group)
    assert rows["mounting repeatability"][-1] == ""
    assert rows["combined u"][-1] == ""
    predicted = next(
        one for one in of.quantities if one.source == "gyro.mounting_repeatability"
    )
    assert predicted.to_dict()["degrees_of_freedom"] is None

    lacking = analyze(load_device("bmi088"), validate=False)
    found = {row.lower_bound: row.degrees_of_freedom for row in lacking.outputs}
    assert found[True] is None
