"""Sobol' indices for people: with intervals, ranked, small ones gathered."""

from __future__ import annotations

import re

import pytest
from builders import NOWHERE, procedure, sensor
from reading import on_terminal

from budget.inputs.records import Device
from budget.report.analysis.groups import budget_answer
from budget.report.figures.sources import sobol_chart
from budget.report.tables import print_index
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
    """Of each group one output has rows; each source stands there, or in words."""
    chart = sobol_chart(budget, "gyro")
    assert len(chart.data.groups) == 3
    for group in chart.data.groups:
        parameter = group.title.removeprefix("Gyro ").rpartition(" ")[0]
        zeros = re.search(rf"{parameter}: ([^;.]*)", chart.caption)
        text = " ".join([zeros[1] if zeros else "", *(r[0].text for r in group.rows)])
        for name in ("bias repeatability", "bias stability", "scale factor asymmetry"):
            assert name in text


def test_sources_that_cannot_be_told_apart_share_a_rank(budget):
    """Both factors of the product in an angle are first, and interact."""
    groups = sobol_chart(budget, "gyro").data.groups
    (group,) = [g for g in groups if g.title == "Gyro mounting angle xy"]
    found = [(row[1].text, row[0].note) for row in group.rows]
    assert found == [("1=", "interacts")] * 2


@pytest.mark.parametrize("width", [40, 80])
def test_terminal_prints_no_index_without_its_interval(budget, width):
    """Every printed index is followed by its interval, and nothing is cut."""
    text = on_terminal(budget_answer(budget), width)
    shown = text.partition("Sobol' indices")[2].partition("Not given")[0]
    pair = r"\d\.\d+\s+(?:interval:\s+)?\[-?\d\.\d+,\s+-?\d\.\d+\]"
    pairs = re.findall(pair, shown)
    rest = re.sub(pair, "", shown)
    assert len(pairs) >= 2 * 3  # first and total, at least one source a group
    assert re.findall(r"\d\.\d+", rest) == []
    assert max(len(row) for row in text.splitlines()) <= width
