"""Positions of a calibration: what they hold up, how they turn, and what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from figure_text import crossed_texts, cut_texts, texts
from numpy.testing import assert_allclose
from reading import assert_says

from budget.inputs import load_procedure, uncalibrated
from budget.report.figures.attitudes import (
    RIGHT,
    SIGHT,
    UP,
    Positions,
    positions_plot,
)

TIMES = "\N{MULTIPLICATION SIGN}"
BOTH = ("gyro", "accelerometer")
SHIPPED = (
    "zhao-2019",
    "six-positions",
    "six-positions-and-turns",
    "twelve-positions",
    "twenty-four-positions",
    "norm-icosahedron",
    "norm-nine-positions",
    "norm-and-turns-by-hand",
    "hand-turns",
    "one-axis-rate-table",
    "dividing-head",
)


def positions(name):
    """Return the positions of a procedure that ships."""
    return Positions.of(load_procedure(name), BOTH)


def test_who_looks_stands_south_and_above():
    """The picture is of three directions at right angles, up is up, north recedes."""
    frame = np.array([RIGHT, UP, SIGHT])
    assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
    assert UP[2] > 0.0
    assert RIGHT[0] > 0.0
    assert SIGHT[1] < 0.0 < SIGHT[2]


@pytest.mark.parametrize(
    ("name", "stands", "turns", "even"),
    [
        ("six-positions", 6, 0, 1),
        ("twelve-positions", 12, 0, 2),
        ("twenty-four-positions", 24, 6, 4),
        ("hand-turns", 6, 3, 1),
        ("norm-icosahedron", 12, 0, 0),
        ("one-axis-rate-table", 0, 6, 0),
    ],
)
def test_positions_are_counted(name, stands, turns, even):
    """As many as the procedure has windows; alike ones are one cube."""
    found = positions(name)
    assert (found.positions, found.turned, found.even) == (stands, turns, even)
    if even:
        assert len(found.dwells) == 6
        assert {one.azimuths for one in found.dwells} == {even}


def test_the_paper_holds_z_up_for_its_azimuths_too():
    """Four dwells of the gyro beside the two of the accelerometer; three turns."""
    found = positions("zhao-2019")
    assert found.ups["z", 1] == 6
    assert set(found.ups.values()) == {6, 2}
    assert found.axes == ["x", "y", "z"]


def test_the_vertical_of_an_icosahedron_is_no_axis():
    """Its twelve directions are unit vectors, opposite in pairs."""
    found = positions("norm-icosahedron")
    ups = np.array([one.up for one in found.dwells])
    assert all(one.vertical is None for one in found.dwells)
    assert_allclose(np.linalg.norm(ups, axis=1), 1.0, rtol=1e-9)
    assert_allclose(ups.sum(axis=0), 0.0, atol=1e-4)


def test_it_says_what_is_up_and_what_turns():
    """In the title, at the cubes, in the words and in the table."""
    picture = positions_plot(positions("twenty-four-positions")).picture
    assert_says(picture.title, "24 positions", "up and down 4 times", "6 turns")
    assert_says(picture.alt, f"z up {TIMES} 4", "vertical in body axes")
    assert "arc" in picture.caption
    assert len(picture.data.groups[0].rows) == 9
    found = texts(positions_plot(positions("twenty-four-positions")).figure)
    assert {"z up", "z down", "x up", "turn z", f"{TIMES} 4", f"{TIMES} 2"} <= set(
        found
    )
    assert "arc" not in positions_plot(positions("six-positions")).picture.caption


@pytest.mark.parametrize("name", SHIPPED)
@pytest.mark.slow
def test_its_texts_stand_apart(name):
    """None is cut, and none lies on another one."""
    figure = positions_plot(positions(name)).figure
    assert cut_texts(figure) == []
    assert [pair for pair in crossed_texts(figure) if pair[1] != "line"] == []


@pytest.mark.parametrize("name", SHIPPED)
def test_axes_point_where_the_body_does(name):
    """An axis that is up is drawn upwards, one that is down is not."""
    for one in positions(name).every:
        seen = one.to_body @ np.column_stack([RIGHT, UP])
        if one.vertical is not None:
            axis, sign = one.vertical
            row = seen["xyz".index(axis)]
            assert_allclose(row, [0.0, sign * UP[2]], atol=1e-3)


def test_without_a_calibration_there_are_no_positions():
    """The maker's is not known, and a sensor that is not there has none."""
    assert Positions.of(uncalibrated("factory"), BOTH) is None
    assert Positions.of(load_procedure("six-positions"), ("gyro",)) is None
