"""`budget station`: documents, files, exit codes, and what people read."""

from __future__ import annotations

import csv
import io

import pytest
from command_line import call
from keeping import once
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.studies import stations

TACTICAL = ("station", "zhao-2019", "--requirement", "tactical-grade")
HARD = ("station", "zhao-2019", "--requirement", "navigation-grade")


@pytest.fixture(scope="module", autouse=True)
def _computed_once():
    """Judge stations once, in however many forms it is told."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stations, "qualify", once(stations.qualify, {}))
        yield


@pytest.fixture
def at_a_table(tmp_path):
    """Write a procedure with a station of its own."""
    return put(
        tmp_path / "lab.yaml",
        "name: lab\nlatitude: 34.2394 deg\nstation: three-axis-table\n",
    )


def test_some_station_does_and_the_code_is_0():
    """The table does at 4:1; the plate with its cube does not in full."""
    run = call(*TACTICAL, "--json", "-", code=0)
    verdicts = {one["file"]: one["verdict"] for one in run.document["stations"]}
    assert verdicts["three-axis-table.yaml"] == "does"
    assert verdicts["ideal.yaml"] == "no figures"
    assert run.document["does"] is True
    assert_says(call(*TACTICAL).out, "good three-axis table will do", "4:1")


def test_a_station_that_is_given_again_is_one():
    """Beside those at hand, whether by its name or by its file."""
    again = ("--station", "three-axis-table") * 2
    assert call(*TACTICAL, *again).out == call(*TACTICAL).out


def test_no_station_does_and_the_code_is_1():
    """At 4:1 of the navigation grade; the headline names the nearest and why."""
    run = call(*HARD, "--full", code=1)
    assert_says(
        run.out,
        *("no station here will do", "4:1", "good three-axis table", "724 %"),
        *("any value will do", "names no station", "accepted up to", "8.3.2"),
    )


@pytest.mark.slow
def test_the_page_fits_a_usual_terminal(at_a_table):
    """No line is longer than 80 characters, with a station of its own too."""
    for more in ((), ("--procedure", at_a_table)):
        out = call(*TACTICAL, *more).out
        assert max(map(len, out.splitlines())) <= 80


@pytest.mark.slow
def test_the_own_station_stands_first(at_a_table):
    """Its figures have what they are now, in the page and in the document."""
    run = call(*TACTICAL, "--procedure", at_a_table, "--json", "-")
    first = run.document["stations"][0]
    assert first["own"]
    assert first["file"] == "three-axis-table.yaml"
    assert [one["own"] for one in run.document["stations"]].count(True) == 1
    turn = run.document["sources"][0]
    assert (turn["source"], turn["now"]) == ("station.turn_angle", 1.0)
    shown = call(*TACTICAL, "--procedure", at_a_table, "--full").out
    assert_says(shown, "within", "now")


@pytest.mark.parametrize("ratio", ["3:1", "3", "3.0", " 3 : 1"])
def test_a_ratio_is_read_in_every_form(ratio):
    """`3:1` and `3` are the same."""
    run = call(*TACTICAL, "--ratio", ratio, "--json", "-")
    assert run.document["settings"]["ratio"] == 3.0


@pytest.mark.parametrize(
    ("option", "value"),
    [
        *(("--ratio", text) for text in ("0", "abc", "4:2", "0.5", "1e9", "-4", "")),
        *(("--guard", text) for text in ("-1", "x", "11", "nan")),
        ("--strategy", "cost"),
        ("--strategy", "proportional"),
        ("--station", "nowhere.yaml"),
        ("--write", "needed.txt"),
    ],
)
def test_a_bad_option_is_refused_in_words(option, value):
    """Exit code 2, the option and what is allowed; nothing on stdout."""
    run = call(*HARD, f"{option}={value}")
    assert (run.code, run.out) == (2, "")
    assert option.removeprefix("--") in run.err or value in run.err
    assert "Traceback" not in run.err


def test_what_is_written_is_a_station_that_does(tmp_path):
    """Given back as a candidate it uses all of limit / 4, and the code is 0."""
    path = tmp_path / "needed.yaml"
    assert call(*HARD, "--write", path).code == 1  # none of those there does
    assert call("validate", path).code == 0
    run = call(*HARD, "--station", path, "--json", "-", code=0)
    found = {one["file"]: one for one in run.document["stations"]}["needed.yaml"]
    assert_allclose(found["utilisation"], 1.0, rtol=1e-6)
    assert found["verdict"] == "does"
    assert_allclose(found["ratio"], 4.0, rtol=1e-6)


def test_the_table_for_programs_has_every_source():
    """CSV and JSON say the same of each."""
    rows = [*csv.DictReader(io.StringIO(call(*HARD, "--csv", "-").out))]
    sources = call(*HARD, "--json", "-").document["sources"]
    assert [row["source"] for row in rows] == [one["source"] for one in sources]
    for row, one in zip(rows, sources, strict=True):
        assert row["alone"] == ("" if one["alone"] is None else repr(one["alone"]))
        assert row["any"] == str(one["any"]).lower()
        assert row["now"] == ""


def test_an_acceptance_limit_is_printed_rounded_down():
    """100 arcsec less 9.0571 is 90.943: 90.94 is accepted, 90.95 is not."""
    out = call(*TACTICAL, "--full").out
    line = next(row for row in out.splitlines() if "90.9" in row)
    assert_says(line, "gyro mounting angle yx", "9.06", "90.94 arcsec")


def test_a_requirement_that_limits_nothing_here_is_refused(tmp_path):
    """The requirement is named, and what would help."""
    path = put(tmp_path / "r.yaml", "name: r\nlimits: {gyro: {bias: 1 deg/h}}\n")
    run = call(*HARD[:2], "--requirement", path, "--procedure", "six-positions", code=2)
    assert_says(run.err, "accelerometer", "add limits")


def test_the_whole_measurement_decides_what_is_accepted(tmp_path):
    """At 0.1 deg/h a bias is accepted up to 0.0489, 2:1; the station stands beside.

    The verdict of the station is of its part alone, and the headline says the rest.
    """
    path = put(tmp_path / "r.yaml", "name: r\nlimits: {gyro: {bias: 0.1 deg/h}}\n")
    run = call("station", "zhao-2019", "--requirement", path, "--full")
    assert_says(run.out, "will do", "test uncertainty ratio", "1.96:1", "Z540.3")
    line = [row for row in run.out.splitlines() if row.startswith("Gyro bias x")][-1]
    assert_says(line, "0.0511", "0.0489", "1.96", "0.038", "0.0998")

    document = call("station", "zhao-2019", "--requirement", path, "--json", "-")
    found = {one["file"]: one for one in document.document["stations"]}
    row = found["three-axis-table.yaml"]["outputs"][2]
    assert_allclose(row["acceptance_limit"], 0.04894, rtol=1e-3)
    assert_allclose(row["station_acceptance_limit"], 0.09971, rtol=1e-3)
    assert_allclose(row["test_uncertainty_ratio"], 1.958, rtol=1e-3)
    assert_allclose(row["ratio"], 345.0, rtol=1e-2)


def test_more_false_accepts_than_two_percent_are_said():
    """Without a guard band an eighth of all items is accepted wrongly at 0.02 deg/h."""
    said = "above the 2 % of ANSI/NCSL Z540.3"
    assert_says(call(*HARD, "--guard", "0", "--full").out, said)
    assert said not in " ".join(call(*HARD, "--full").out.split())
