"""Where a mission leads, as `budget validate` tells it."""

from __future__ import annotations

from command_line import call

from budget.report.route import route_section
from budget.spec import load_mission


def cells(**keys):
    """Return the rows of the table of a mission with those keys."""
    one = load_mission({"mission": {"latitude": "45 deg", **keys}})
    (table,) = route_section(one).blocks
    return [[cell.text for cell in row] for group in table.groups for row in group.rows]


def test_place_and_motion_are_those_of_the_segments():
    """At the start and at each asked time, in degrees and metres."""
    rows = cells(
        height="100 m",
        heading="350 deg",
        segments=[
            {"stand": "60 s"},
            {"accelerate": "10 s", "to": "20 m/s"},
            {"turn": "100 deg", "rate": "10 deg/s"},
            {"climb": "40 s", "rate": "-2.5 m/s"},
        ],
        at=["1 min", "65 s", "80 s", "2 min"],
    )
    assert [row[0] for row in rows] == ["0 s", "60 s", "65 s", "80 s", "2 min"]
    assert [row[2] for row in rows] == ["100", "100", "100", "100", "0"]
    assert [row[3] for row in rows] == ["0", "0", "10", "20", "20"]
    assert [row[4] for row in rows] == ["350", "350", "350", "90", "90"]
    assert float(rows[-1][1]) > float(rows[1][1]) == 45.0


def test_a_whole_turn_heads_north_again():
    """No 360 deg beside 0 deg, whatever rounding does."""
    rows = cells(segments=[{"turn": "-360 deg", "rate": "7 deg/s", "repeat": 3}])
    assert (rows[0][4], rows[-1][4]) == ("0", "0")


def test_validate_tells_it():
    """Beside what is assumed, for each mission."""
    out = call("validate", "transport-flight").out
    assert "mission, valid" in out
    assert "Where the mission leads" in out
    assert "9500" in out
