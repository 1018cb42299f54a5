"""Recorded trajectories: columns with units in, SI out, each fault at its row."""

from __future__ import annotations

import re
from math import cos, degrees, radians, sin

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import ROOT

from budget.earth import normal_radius
from budget.errors import SpecError
from budget.inputs.trajectory import MOST_ROWS, read_trajectory
from budget.navigation.route import Leg, Legs, Start, moved

HEADER = "time [s],latitude [deg],longitude [deg],height [m]"
ROWS = [f"{n},45.0{n},9.0{n},100" for n in range(5)]
FLIGHT = Legs(
    start=Start(latitude=radians(45.0), height=500.0, speed=70.0, heading=radians(80)),
    legs=(
        Leg(duration=20.0),
        Leg(duration=60.0, turn_rate=radians(3.0)),
        Leg(duration=40.0, climb_rate=4.0),
    ),
)
FILE = ROOT / "tests" / "data" / "flight.csv"  # FLIGHT, as `recorded` writes it
PARTS = 10  # of a second, in which the longitude is summed


def recorded(route, *, longitude=11.0, angles=True):
    """Return a route as a recording, a row for each second, and its rows in SI."""
    here, east, time = route.start, radians(longitude), 0
    rows = [(0.0, here.latitude, east, here.height, 0.0, 0.0, here.heading)]
    for leg in route.legs:
        for _ in range(round(leg.duration)):
            for _ in range(PARTS):
                middle = moved(here, leg, 0.5 / PARTS)
                radius = normal_radius(middle.latitude) + middle.height
                aside = middle.speed * sin(middle.heading) / PARTS
                east += aside / (radius * cos(middle.latitude))
                here = moved(here, leg, 1.0 / PARTS)
            time += 1
            angle = (0.0, 0.0, here.heading)
            rows.append((float(time), here.latitude, east, here.height, *angle))
    width = 7 if angles else 4
    heads = [*HEADER.split(","), "roll [deg]", "pitch [deg]", "heading [deg]"]
    lines = [",".join(heads[:width])]
    for t, lat, lon, height, *angle in rows:
        place = f"{t:.0f},{degrees(lat):.10f},{degrees(lon):.10f},{height:.4f}"
        turned = [f"{degrees(one) % 360.0:.6f}" for one in angle] if angles else []
        lines.append(",".join([place, *turned]))
    return "\n".join(lines) + "\n", np.array(rows)


@pytest.fixture
def read(tmp_path):
    """Return a function that writes a text, or rows below a header, and reads it."""

    def of(text, header=HEADER):
        if not isinstance(text, str | bytes):
            text = "\n".join([header, *text]) + "\n"
        path = tmp_path / "t.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_trajectory(path, "t.csv")

    return of


@pytest.fixture
def refused(read):
    """Return a function that says what is wrong: 'line:column: field: words'."""

    def of(text, header=HEADER):
        with pytest.raises(SpecError) as caught:
            read(text, header)
        return [str(issue).removeprefix("t.csv:") for issue in caught.value.issues]

    return of


@pytest.mark.parametrize("is_stored", [True, False])
def test_the_recording_of_a_flight_is_the_flight(read, is_stored):
    """A route of segments, written as a file, is read as what it was."""
    text, rows = recorded(FLIGHT)
    found = read(FILE.read_bytes() if is_stored else text)
    assert_allclose(found.track.time, rows[:, 0], rtol=1e-15)
    assert_allclose(found.track.latitude, rows[:, 1], rtol=0, atol=1e-12)
    assert_allclose(found.track.longitude, rows[:, 2], rtol=0, atol=1e-12)
    assert_allclose(found.track.height, rows[:, 3], rtol=0, atol=1e-4)
    assert_allclose(found.track.attitude, rows[:, 4:], rtol=0, atol=1e-8)
    assert_allclose(found.first_speed, 70.0, rtol=1e-4)
    assert found.assumptions == ()


def test_without_a_heading_it_is_that_of_the_track(read):
    """Second differences: within a turn to their order; roll and pitch are 0."""
    _, rows = recorded(FLIGHT)
    text, _ = recorded(FLIGHT, angles=False)
    found = read(text)
    # Of a chord in a turn of 0.05 rad a row, and of half a row where it begins.
    assert_allclose(found.track.attitude[:, 2], rows[:, 6], rtol=0, atol=0.03)
    assert_allclose(found.track.attitude[25:75, 2], rows[25:75, 6], rtol=0, atol=1e-5)
    assert not found.track.attitude[:, :2].any()
    said = " ".join(found.assumptions)
    for key in ("roll", "pitch", "heading"):
        assert f"trajectory.{key}: not given" in said


@pytest.mark.parametrize("sense", [1, -1])
def test_longitudes_and_headings_do_not_jump(read, sense):
    """Over the date line, and through north, in either direction."""
    rows = [
        f"{n},0,{(180.0 + sense * 0.001 * (n - 2) + 180.0) % 360.0 - 180.0},0,"
        f"{(sense * 2 * (n - 2)) % 360}"
        for n in range(5)
    ]
    found = read(rows, HEADER + ",heading [deg]")
    assert_allclose(np.diff(found.track.longitude), radians(sense * 0.001), rtol=1e-9)
    heading = found.track.attitude[:, 2]
    assert_allclose(np.diff(heading), radians(sense * 2.0), rtol=1e-9)


def test_columns_stand_in_any_order_and_unit(read):
    """Values are what their heads say; time begins at the first row."""
    rows = [f"{0.1 * n},{n + 7},45.{n},{30 * n}" for n in range(5)]
    header = "height [km], time [min] ,latitude [deg],longitude [arcmin]"
    found = read(rows, header)
    assert_allclose(found.track.time, 60.0 * np.arange(5.0), rtol=1e-15)
    assert_allclose(found.track.height, 100.0 * np.arange(5.0), rtol=1e-15)
    assert_allclose(found.track.longitude, radians(0.5) * np.arange(5.0), rtol=1e-15)
    marked = "\ufeff" + "\r\n".join([header, *rows, "", ""])
    assert_allclose(read(marked).track.height, found.track.height, rtol=0)


@pytest.mark.parametrize(
    ("header", "what"),
    [
        ("time [s],latitude [deg],height [m]", "1:1: the header has no longitude"),
        (HEADER + ",speed [m/s]", "1:52: 'speed' is no column"),
        (HEADER.replace("lat", "Lat"), "1:10: 'Latitude' .*'latitude \\[deg\\]'"),
        (HEADER.replace(" [s]", ""), r"1:1: time: has no unit, expected 'time \[s\]'"),
        (HEADER.replace("[s]", "[m]"), "1:1: time: .*a length, expected a time"),
        (HEADER.replace("[s]", "[]"), "1:1: time: "),
        (HEADER + ",height [m]", "1:52: 'height' stands twice"),
        ("x" * 2000, "1:1: "),
    ],
)
def test_a_header_that_is_none_is_refused(refused, header, what):
    """Columns that lack, are not known, have no unit or another one."""
    assert any(re.match(what, text) for text in refused(ROWS, header))


@pytest.mark.parametrize("mark", [";", "\t", "|"])
def test_columns_are_parted_by_commas(refused, mark):
    """Another mark is the one thing that is said of such a file."""
    text = "\n".join([HEADER, *ROWS]).replace(",", mark)
    (found,) = refused(text)
    assert found.startswith(f"1:1: parts its columns by {mark!r}, expected commas")


@pytest.mark.parametrize(
    ("row", "what"),
    [
        ("2,45.02,9.02", "4:1: has 3 values, expected 4"),
        ("2,45.02,9.02,100,", "4:1: has 5 values"),
        ("2,45.02,x,100", "4:9: longitude: found 'x', expected a number"),
        ("2,45.02,nan,100", "4:9: longitude: found 'nan'"),
        ("2,45.02,1_0,100", "4:9: longitude: found '1_0'"),
        ("2,45.02,\u0661,100", "4:9: longitude: "),
        ("2,45.02,,100", "4:9: longitude: found ''"),
        ("2,45.02,361,100", "4:9: longitude: found '361', expected -360"),
        ("2,45.02,9.02,1e999", "4:14: height: found '1e999', expected -100 km"),
        ("2,89.9,9.02,100", "4:3: latitude: found '89.9', expected between"),
        ("2,-89.9,9.02,100", "4:3: latitude: found '-89.9', expected between"),
        ("1,45.02,9.02,100", "4:1: time: found '1', expected a time after"),
        ("0.5,45.02,9.02,100", "4:1: time: found '0.5'"),
        ("1e999,45.02,9.02,100", "5:1: time: found '3'"),
        ("2,46.02,9.02,100", "4:1: is .* km/s from the row before"),
        ("2,45.02,9.02,100e3", "4:1: is .* km/s from the row before"),
    ],
)
def test_a_row_that_is_wrong_is_refused(refused, row, what):
    """With line and column; what is right before it has no issue."""
    found = refused([*ROWS[:2], row, *ROWS[3:]])
    assert any(re.match(what, text) for text in found), found
    assert all(text[0] in "45" for text in found), found


def test_all_rows_that_are_wrong_are_said_at_once(refused):
    """What is alike in many of them once, at the first."""
    assert len(refused([*ROWS, "5,x,y,z", "6,1"])) == 4
    assert len(refused([*ROWS, *(f"{n},x,0,0" for n in (5, 6, 7))])) == 3
    (found,) = refused([f"{n},x,0,0" for n in range(500)])
    assert found.startswith("2:3: latitude: found 'x', expected a number; 499 more")


@pytest.mark.parametrize(
    ("rows", "header", "said"),
    [
        ([f"{n},5,45,{n},9,{n},100,0" for n in range(60)], HEADER, "write points"),
        ([f"{n};45,{n};9,{n};100" for n in range(60)], HEADER.replace(",", ";"), "not"),
        ([f"{n},103.{n},1.3,0" for n in range(60)], HEADER, "longitude swapped?"),
        ([f"45.{n},{n},9,0" for n in range(60)][::-1], HEADER, "a time after that"),
        (ROWS[1:], ROWS[0], "1:1: is of numbers, expected a header"),
        (
            [f"{n},45.{n},0.1,0" for n in range(60)],
            HEADER.replace("latitude [deg]", "latitude [rad]"),
            "is it 'latitude [deg]'?",
        ),
    ],
)
def test_a_mistake_in_every_row_is_said_once(refused, rows, header, said):
    """With what to do, at the first place; not sixty times."""
    (found,) = refused(rows, header)
    assert said in found


@pytest.mark.parametrize(
    ("head", "hint"),
    [
        ("lat", "write 'latitude [deg]'"),
        ("Lat [rad]", "write 'latitude [rad]'"),
        ("lat_deg", "write 'latitude [deg]'"),
        ("latitude (deg)", "write 'latitude [deg]'"),
        ("LONGITUDE", "write 'longitude [deg]'"),
        ("lng", "write 'longitude [deg]'"),
        ("alt_m", "write 'height [m]'"),
        ("Altitude", "write 'height [m]'"),
        ("yaw", "write 'heading [deg]'"),
        ("t", "write 'time [s]'"),
        ("Roll", "write 'roll [deg]'"),
        ("vn [m/s]", "leave it out"),
        ("ve", "leave it out"),
        ("vd_m", "leave it out"),
    ],
)
def test_usual_heads_get_a_hint(refused, head, hint):
    """What others call a column, in any capitals, with a unit in another place."""
    found = [text for text in refused(ROWS, f"{HEADER},{head}") if "no column" in text]
    assert len(found) == 1
    assert hint in found[0]


@pytest.mark.parametrize(
    ("name", "data", "kind"),
    [
        ("s.yaml", b"station: {}\n", "a station file"),
        ("s.yml", b"- [\n", "a YAML file"),
        ("t.csv", b"PK\x03\x04\xff", "an archive or a workbook"),
        ("t.csv", b"\x93NUMPY\x01", "an array of NumPy"),
        ("t.csv", b"$GPGGA,1,2\n", "NMEA"),
        ("t.csv", b"\xef\xbb\xbf<?xml?>", "XML"),
        ("t.csv", b'{"a": 1}', "JSON"),
    ],
)
def test_a_file_of_another_kind_is_named(tmp_path, name, data, kind):
    """For what it is, in one sentence."""
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(SpecError, match=kind) as caught:
        read_trajectory(path, name)
    assert len(caught.value.issues) == 1


@pytest.mark.parametrize(
    ("north", "east", "heading", "hint"),
    [
        (-20.0, 0.0, 3.1416, "read as radians it would fit"),
        (1.0, 20.0, -87.0, "counted to the left"),
        (20.0, 0.1, 90.0, "latitude and longitude are swapped"),
        (20.0, 0.0, 130.0, ""),
    ],
)
def test_a_heading_aside_has_a_hint(read, north, east, heading, hint):
    """Where another reading of it lies along the track; it changes nothing."""
    found = read(_headed(north, east, heading), HEADER + ",heading [deg]")
    (said,) = (text for text in found.assumptions if "differs from" in text)
    assert said.endswith(hint or "units of the columns")
    assert_allclose(found.track.attitude[:, 2], radians(heading), rtol=1e-12)


def test_a_track_that_stands_has_no_heading(read, refused):
    """It is asked for then, and taken where it is given."""
    rows = [*ROWS, *(f"{n},45.04,9.04,100" for n in (5, 6, 7))]
    (text,) = refused(rows)
    assert text.startswith("7:1: ")
    assert "in rows 7 to 9 of the file" in text
    assert "a column 'heading [deg]'" in text
    found = read([f"{row},30" for row in rows], HEADER + ",heading [deg]")
    assert_allclose(found.track.attitude[:, 2], radians(30.0), rtol=1e-15)


def _rows(times):
    """Return rows of a vehicle that goes evenly to the north, at those times."""
    return [f"{time:.12g},{45.0 + 1e-4 * time:.9f},9,100" for time in times]


@pytest.mark.parametrize(
    ("gaps", "words"),
    [
        ([], ""),
        ([(20.0, 20.9)], ""),
        ([(20.0, 60.0)], "no row from 1020 s to 1060 s, the others come every 0.1 s"),
        (
            [(5.0, 7.0), (20.0, 60.0), (70.0, 75.0)],
            "3 gaps, the longest with no row from 1020 s to 1060 s, the others come",
        ),
    ],
)
def test_rows_that_are_left_out_are_said(read, gaps, words):
    """From more than ten steps on, at the times of the file; of several the longest."""
    times = [
        1000.0 + 0.1 * n
        for n in range(1000)
        if not any(start + 0.05 < 0.1 * n < end - 0.05 for start, end in gaps)
    ]
    said = [text for text in read(_rows(times)).assumptions if "smooth" in text]
    assert len(said) == bool(words)
    assert words in "".join(said)


def _headed(north, east, heading):
    """Return rows of an even track [m/s], with that heading in its column [deg]."""
    return [
        f"{n},{45.0 + n * degrees(north / 6.37e6):.10f},"
        f"{9.0 + n * degrees(east / 6.38e6 / cos(radians(45.0))):.10f},100,{heading}"
        for n in range(20)
    ]


@pytest.mark.parametrize(
    ("north", "east", "heading", "angle"),
    [
        (20.0, 0.0, 0.0, ""),
        (-20.0, -0.1, -179.9, ""),  # over south, where angles jump
        (20.0, 0.0, 43.0, ""),
        (20.0, 0.0, 720.0, ""),
        (0.9, 0.0, 90.0, ""),  # too slow to say
        (20.0, 0.0, 47.0, "47"),
        (20.0, 0.0, -47.0, "47"),
        (0.0, 20.0, 1.5708, "88"),  # radians
        (20.0, 0.0, 180.0, "180"),
        (1.1, 0.0, 450.0, "90"),
    ],
)
def test_a_heading_aside_of_the_track_is_said(read, north, east, heading, angle):
    """From 45 degrees in the median on, either way round, where the vehicle moves."""
    found = read(_headed(north, east, heading), HEADER + ",heading [deg]")
    said = [text for text in found.assumptions if "differs from the track" in text]
    assert len(said) == bool(angle)
    assert all(f"track by {angle} deg in the median" in text for text in said)


def test_half_of_the_headings_may_be_aside(read):
    """A car that backs up now and then is none with swapped columns; stops are none."""
    ahead, back = _headed(20.0, 0.0, 0.0), _headed(20.0, 0.0, 180.0)
    header = HEADER + ",heading [deg]"
    assert "differs" not in str(read([*ahead[:12], *back[12:]], header).assumptions)
    assert "differs" in str(read([*ahead[:8], *back[8:]], header).assumptions)
    place = back[-1].split(",", 1)[1]
    stops = [f"{n},{place[:-3]}0" for n in range(20, 60)]
    assert "differs" in str(read([*back, *stops], header).assumptions)


@pytest.mark.parametrize(
    ("stops", "words"),
    [
        ([1], "in row 3 of"),
        ([0, 7], "in rows 2 and 9 of"),
        ([0, *range(7, 13)], "in rows 2 and 9 to 14 of"),
        (range(0, 14, 2), "in rows 2, 4, 6, 8, 10 and 2 more of"),
    ],
)
def test_rows_that_stand_are_said_in_one(refused, stops, words):
    """By their numbers in the file, the first as the place, of many runs five."""
    # Central differences: a row stands where those beside it are at one place, and the
    # second-order ones at the ends by the three rows there.
    place = [0.0, 1.0]
    for row in range(1, 16):
        place.append(place[-2] + (0.0 if row in stops else 2.0))
    if 0 in stops:
        place[0] = 4.0 / 3.0 * place[1] - place[2] / 3.0
    rows = [f"{n},{45.0 + 1e-3 * one:.12f},9,0" for n, one in enumerate(place)]
    (text,) = refused(rows)
    assert text.startswith(f"{min(stops) + 2}:1: ")
    assert words in text


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("", "1:1: the file is empty"),
        (b"\xff", "1:1: byte 0xff is not UTF-8"),
        (ROWS[:3], "1:1: has 3 rows, expected 4"),
        (
            "\n" * MOST_ROWS + "\n\n,",
            "has 50002 rows, expected 4 to 50000; leave rows out",
        ),
        ([f"{n},45.0{n},9.0{n},100" for n in (0, 1, 2)] + ["90000,1,1,1"], "24 h"),
    ],
)
def test_a_file_that_is_no_recording_is_refused(refused, text, what):
    """Empty, no text, too short, too long."""
    (found,) = refused(text)
    assert what in found


def test_a_file_that_cannot_be_read_is_refused(tmp_path):
    """A folder, and none at all."""
    for path, what in ((tmp_path, "is a folder"), (tmp_path / "none", "CSV file")):
        with pytest.raises(SpecError, match=what):
            read_trajectory(path, "t.csv")
