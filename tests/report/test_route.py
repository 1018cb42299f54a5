"""Where a mission leads, as `budget validate` tells it."""

from __future__ import annotations

import json

import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import put

from budget.inputs import load_mission
from budget.report.route import route_section
from budget.studies.cautions import of_no_vehicle


def cells(**keys):
    """Return the rows of the table of a mission with those keys."""
    one = load_mission({"mission": {"latitude": "45 deg", **keys}})
    _, table = route_section(one).blocks
    return [[cell.text for cell in row] for group in table.groups for row in group.rows]


def line_of(mission):
    """Return the line that says the route of a mission."""
    (line,) = route_section(mission).blocks[0].words
    return line


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


def mission(folder, rows, heads="time [s],latitude [deg],longitude [deg],height [m]"):
    """Return the mission of a recording of these rows."""
    text = "\n".join([heads, *(",".join(map(str, row)) for row in rows)])
    (folder / "t.csv").write_text(text + "\n")
    return put(
        folder / "m.yaml", "format: budget-mission/1\nmission: {trajectory: t.csv}\n"
    )


def straight(count=60, *, dt=1.0, speed=20.0, latitude=45.0, longitude=10.0, unit=1.0):
    """Return rows of a vehicle that goes north, angles times a unit [deg]."""
    north = speed / 111_132.0  # [deg/s], near latitude 45 deg
    return [
        (n * dt, (latitude + north * n * dt) * unit, longitude * unit, 100.0)
        for n in range(count)
    ]


def test_one_line_says_the_route_of_segments():
    """1.2 km north in a minute; a circle of radius v/w asks for v w."""
    start = {"latitude": "45 deg", "longitude": "-10 deg"}
    way = {"straight": "60 s", "speed": "20 m/s", "heading": "0 deg"}
    one = load_mission({"mission": {**start, "segments": [way]}})
    assert line_of(one) == (
        "Route: 45.0000 N 10.0000 W to 45.0108 N 10.0000 W, 1.2 km in 1 min, 0 m to "
        "0 m high, at most 20 m/s, 0 m/s up or down, 0 g, 0 deg/s."
    )
    turn = {"turn": "90 deg", "rate": "10 deg/s"}
    way = load_mission({"mission": {**start, "speed": "20 m/s", "segments": [turn]}})
    # v w = 20 x 0.174533 = 3.4907 m/s^2; the way is 20 m/s x 9 s.
    assert_allclose(way.route.outline.acceleration, 3.490658504, rtol=1e-9)
    assert_allclose(way.route.outline.length, 180.0, rtol=1e-12)
    assert not of_no_vehicle(way)


def test_the_line_says_how_high_it_goes():
    """Feet under [m] are seen there: 300 m in a minute, up to where the climb ends."""
    start = {"latitude": "45 deg", "height": "-0.2 m", "speed": "20 m/s"}
    way = [{"climb": "60 s", "rate": "5 m/s"}, {"climb": "10 s", "rate": "-8 m/s"}]
    one = load_mission({"mission": {**start, "segments": way}})
    line = line_of(one)
    assert "0 m to 300 m high" in line
    assert "8 m/s up or down" in line
    assert_allclose(one.route.outline.heights, (-0.2, 299.8), rtol=1e-12)
    assert_allclose(one.route.outline.climb_rate, 8.0, rtol=1e-12)


def test_a_route_east_ends_at_its_longitude():
    """On the equator by v t / a: 1000 m/s for 100 s are 0.89832 deg."""
    way = {"straight": "100 s", "speed": "1000 m/s", "heading": "90 deg"}
    start = {"latitude": "0 deg", "longitude": "179.5 deg"}
    one = load_mission({"mission": {**start, "segments": [way]}})
    assert "0.0000 N 179.5000 E to 0.0000 N 179.6017 W" in line_of(one)


@pytest.mark.slow
def test_the_line_is_shown_everywhere(tmp_path):
    """In validate, mission and report the same, and its numbers in JSON."""
    path = mission(tmp_path, straight())
    line = line_of(load_mission(path))
    assert "45.0000 N 10.0000 E to 45.0106 N 10.0000 E, 1.18 km in 59 s" in line
    found = tmp_path / "m.json"
    texts = [
        call("validate", str(path)).out,
        call("mission", "--mission", str(path), "--full", "--json", str(found)).out,
    ]
    assert all(line in " ".join(text.split()) for text in texts)
    way = json.loads(found.read_text())["mission"]["route"]
    assert_allclose(way["speed"], 20.0, rtol=1e-3)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (straight(), []),
        (
            straight(unit=0.017453292519943295),
            ["Gulf of Guinea: are its angles in rad?"],
        ),
        ([(1000 * t, *rest) for t, *rest in straight()], ["times in ms"]),
        (straight(speed=2000.0), ["aircraft stay below 1000 m/s"]),
        ([(t, round(a, 4), *b) for t, a, *b in straight(99, dt=0.1)], ["11.1 m", "g"]),
        ([*straight(30), *straight(60, longitude=10.01)[30:]], ["aircraft stay below"]),
        (straight(latitude=0.5, longitude=-1.0), ["Gulf of Guinea"]),
        (straight(latitude=-1.5, longitude=3.1), ["Gulf of Guinea"]),
        (straight(latitude=0.0, longitude=0.0), []),
        (straight(latitude=1.35, longitude=103.8), []),
    ],
)
def test_what_is_of_no_vehicle_is_said(tmp_path, rows, said):
    """A wrong unit, too few decimals or a jump; a car, and Singapore, are silent."""
    heads = "time [s],latitude [deg],longitude [deg],height [m],heading [deg]"
    path = mission(tmp_path, [(*row, 0) for row in rows], heads)
    found = " ".join(of_no_vehicle(load_mission(path)))
    assert all(one in found for one in said)
    assert bool(found) == bool(said)
    shown = call("validate", str(path)).out
    assert ("warning: " in shown) == bool(said)
