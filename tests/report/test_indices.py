"""Sobol' indices for people: with intervals, ranked, small ones gathered."""

from __future__ import annotations

import re

import pytest
from builders import NOWHERE, procedure, sensor
from document_text import on_terminal

from budget.report.analysis.groups import budget_answer
from budget.report.tables import index_tables, print_index
from budget.spec.records import Device
from budget.studies.analysis import analyze
from budget.units import DEG_PER_HOUR


@pytest.mark.parametrize(
    ("value", "interval", "expected"),
    [
        (0.78649, (0.786, 0.787), ("0.786", "[0.786, 0.787]")),
        (0.0, (-0.0123, 0.0004), ("0.000", "[-0.012, 0.000]")),
        (0.0, (-1e-9, 1e-9), ("0.000", "[0.000, 0.000]")),
        (0.4, (0.2, 0.6), ("0.40", "[0.20, 0.60]")),
        (1.0, (1.0, 1.0), ("1.000", "[1.000, 1.000]")),
    ],
)
def test_an_index_has_the_digits_of_its_interval(value, interval, expected):
    """Digits beyond the interval, and a minus before zero, are not printed."""
    assert print_index(value, interval) == expected


@pytest.fixture(scope="module")
def device():
    """Return a gyro whose scale factors know only a product of two sources."""
    gyro = sensor(
        "gyro",
        {
            "bias_repeatability": 2.5 * DEG_PER_HOUR,
            "bias_stability": 1e-12,
            "scale_factor_asymmetry": 0.05,
        },
    )
    return Device(
        name="asymmetric",
        gyro=gyro,
        accelerometer=None,
        figures=(),
        assumptions=(),
        origin=NOWHERE,
    )


@pytest.fixture(scope="module")
def budget(device):
    """Return its budget with indices."""
    return analyze(device, procedure=procedure(), samples=512, validate=False)


def test_tables_hold_every_source_that_varies(budget):
    """Each output has a table; each source stands in it, as a row or as small."""
    tables = index_tables(budget)
    assert len(tables) == 12
    for table in tables:
        text = " ".join([table.small, *(row.title for row in table.rows)])
        for name in ("bias repeatability", "bias stability", "scale factor asymmetry"):
            assert name in text


def test_sources_that_cannot_be_told_apart_share_a_rank(budget):
    """Both factors of the product in an angle are first, and interact."""
    (table,) = [t for t in index_tables(budget) if t.title == "gyro mounting angle xy"]
    assert [(row.rank, row.note) for row in table.rows] == [("1=", "interacts")] * 2


@pytest.mark.parametrize("width", [40, 80])
def test_terminal_prints_no_index_without_its_interval(budget, width):
    """Every printed index is followed by its interval, and nothing is cut."""
    text = on_terminal(budget_answer(budget), width)
    shown = text.partition("Sobol indices of")[2].partition("Not given")[0]
    pairs = re.findall(r"\d\.\d+ +\[-?\d\.\d+, -?\d\.\d+\]", shown)
    rest = re.sub(r"\d\.\d+ +\[-?\d\.\d+, -?\d\.\d+\]", "", shown)
    assert len(pairs) >= 2 * 3  # first and total, at least one source a group
    assert re.findall(r"(?<!below )\d\.\d+", rest) == []
    assert max(len(row) for row in text.splitlines()) <= width
