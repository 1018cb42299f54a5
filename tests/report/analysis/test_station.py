"""The station's section of a report: its finding, its shares, what cancels."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from numpy.testing import assert_allclose
from reading import assert_says, find, lines, rows, say

from budget import load_device, load_procedure, load_requirement
from budget.inputs import load_station
from budget.inputs.station import at_station
from budget.question import question_of
from budget.report.analysis.station import station_section
from budget.report.blocks import Paragraph, Table
from budget.report.figures.sources import coupling_chart
from budget.report.inputs import inputs_section, procedure_section
from budget.report.tables import group_tables, print_share
from budget.studies.analysis import analyze
from budget.studies.cautions import unfelt
from budget.studies.evidence import coupling

PLAIN = """name: plain
accelerometer:
  nominal: {bias: 6 mg}
  errors: {bias_repeatability: 37 ug, scale_factor_repeatability: 37 ppm}
gyro:
  nominal: {bias: 2.5 deg/h}
  errors: {bias_repeatability: 0.05 deg/h, scale_factor_repeatability: 50 ppm,
    mounting_repeatability: 2 arcsec, bias_temperature_coefficient: 0.1 deg/h/degC}
"""
WEATHER = "environment: {vibration: {test: 1 g}, temperature: {ramp: 2 degC/h}}\n"


@cache
def table_top():
    """Return a budget at the good three-axis table, judged, once."""
    return analyze(
        load_device("zhao-2019"),
        procedure=load_procedure(station="three-axis-table"),
        requirement=load_requirement("navigation-grade"),
        reference="next_turn_on",
        validate=False,
    )


def section_of(budget):
    """Return the section on a budget's station."""
    question = question_of(budget)
    return station_section(
        budget,
        group_tables(budget),
        question.procedure,
        budget.assessment,
        unfelt(question),
    )


def finding(section):
    """Return what a section opens with."""
    first = section.blocks[0]
    assert isinstance(first, Paragraph)
    return say(first.words)


def table_of(section, name):
    """Return the table of that name, cells as they are."""
    return next(table for table in find(section, Table) if table.name == name)


@pytest.fixture
def shaky(tmp_path):
    """Return a plain device and a procedure at a station with weather."""
    (tmp_path / "plain.yaml").write_text(PLAIN)
    (tmp_path / "here.yaml").write_text(
        "station: {turn_angle: 1 arcsec, azimuth: 9 arcsec}\n" + WEATHER
    )
    there = at_station(load_procedure(), load_station(tmp_path / "here.yaml"))
    return load_device(tmp_path / "plain.yaml"), there


@pytest.mark.slow
def test_the_finding_is_what_the_station_adds_to_the_variance():
    """Of its largest share: one less the variance without it over that with it."""
    budget = table_top()
    bare = analyze(load_device("zhao-2019"), reference="next_turn_on", validate=False)
    added = {
        row.output.name: 1.0
        - (bare.output(row.output.name).standard_uncertainty / row.standard_uncertainty)
        ** 2
        for row in budget.outputs
    }
    worst = max(added, key=added.get)
    text = finding(section_of(budget))

    assert_says(
        text,
        *("station", print_share(added[worst]), print_share(1.0 - added[worst])),
        *("gyro mounting angle yx", "mount", "own specifications"),
    )
    assert worst == "gyro.mounting_angle.yx"
    assert text.startswith("The station contributes")


def test_shares_of_all_parts_make_each_group_whole():
    """Lines of the station add up to it; with the sensors and products to 1."""
    table = table_of(section_of(table_top()), "station-shares")
    station, together = table.groups
    columns = [k for k, one in enumerate(table.columns) if one.kind == "number"]
    assert len(columns) == 6
    for k in columns:
        lines_of_it = sum(row[k].exact or 0.0 for row in station.rows)
        parts = [row[k].exact or 0.0 for row in together.rows]
        assert_allclose(lines_of_it, parts[0], rtol=1e-9)
        assert_allclose(sum(parts), 1.0, rtol=1e-9)


def test_every_figure_of_the_station_has_its_row():
    """Name, figure and meaning as the file has them, and where it acts most."""
    procedure = load_procedure(station="three-axis-table")
    table = table_of(section_of(table_top()), "station-shares")
    found = {row[0].text: row for row in table.groups[0].rows}
    assert len(found) == len(procedure.station)
    mount = found["mount"]
    assert (mount[1].text, mount[1].note) == ("5 arcsec", "max")
    assert mount[2].text == "gyro mounting angle yz"
    assert found["levelling east"][2].text == "gyro bias z"
    assert found["azimuth"][2].text == "nothing"


def test_what_cancels_is_said_in_words():
    """Levelling about north by the 180 deg repeat; a rate error that nobody uses."""
    said = lines(section_of(table_top()))
    removed = next(line for line in said if "180 deg repeat" in line)
    assert_says(removed, "Levelling north, azimuth", "removed")
    assert any(line.startswith("Rate error: needs turns") for line in said)


def test_parts_of_a_limit_add_up_in_squares():
    """Station and sensors alone, as parts of the limit; all is what is judged."""
    budget = table_top()
    table = table_of(section_of(budget), "station-limits")
    rows = table.groups[0].rows
    assert len(rows) == 6
    limits = {
        row.output.name.replace(".", " ").replace("_", " "): row
        for row in budget.assessment.outputs
    }
    for name, _, station, own, every in rows:
        used = limits[name.text]
        assert_allclose(every.exact, used.utilisation, rtol=1e-12)
        # The larger end is not half the width: by trials they differ by some 1e-3.
        assert_allclose(station.exact**2 + own.exact**2, every.exact**2, rtol=1e-2)


@pytest.mark.parametrize(
    ("station", "outputs", "words"),
    [
        ("mount: 5 arcsec", "gyro.bias", ("less than 0.1 %",)),
        ("gravity: 3 mGal", "accelerometer.scale_factor", ("0.6 %", "by gravity;")),
        ("azimuth: 9 arcsec", "gyro.bias", ("to U of no output",)),
    ],
)
def test_a_small_part_is_said_in_words(tmp_path, station, outputs, words):
    """Below what is printed, below what is worth a share, and none at all."""
    (tmp_path / "s.yaml").write_text(f"station: {{{station}}}\n")
    budget = analyze(
        load_device("zhao-2019"),
        procedure=load_procedure(station=tmp_path / "s.yaml"),
        outputs=[outputs],
        validate=False,
    )
    assert_says(finding(section_of(budget)), *words)


def test_what_is_left_out_is_said_to_be():
    """With chosen sources the others are not said to do nothing."""
    budget = analyze(
        load_device("zhao-2019"),
        procedure=load_procedure(station="three-axis-table"),
        only=["station.gravity"],
        validate=False,
    )
    table = table_of(section_of(budget), "station-shares")
    where = {row[0].text: row[2].text for row in table.groups[0].rows}
    assert where.pop("gravity").startswith("accelerometer scale factor")
    assert set(where.values()) == {"left out"}


def test_rounding_uses_nothing_of_a_limit():
    """By the norm of gravity a plate's angles are none: 0, not 1e-14 of a limit."""
    budget = analyze(
        load_device("zhao-2019"),
        procedure=load_procedure("norm-nine-positions", station="granite-plate-cube"),
        requirement=load_requirement("tactical-grade"),
        reference=load_requirement("tactical-grade").reference,
        validate=False,
    )
    table = table_of(section_of(budget), "station-limits")
    used = {row[0].text: row[2] for row in table.groups[0].rows}
    (angle,) = [used[name] for name in used if "mounting angle" in name]
    assert (angle.text, angle.exact) == ("0", 0.0)


def test_temperature_has_its_rows_and_a_vibration_is_known(shaky):
    """A ramp has shares; a known size says by which line it acts, and is no spread."""
    device, procedure = shaky
    section = section_of(analyze(device, procedure=procedure, validate=False))
    table = table_of(section, "station-shares")
    assert section.title == "Test station and environment"
    assert [group.title for group in table.groups] == [
        "station",
        "environment",
        "together",
    ]
    ramp, vibration = table.groups[1].rows
    assert ramp[2].text.startswith("gyro bias")
    assert (vibration[1].text, vibration[1].note) == ("1 g", "known value")
    assert "The station and the environment contribute" in finding(section)
    # No triad has the line that it acts by.
    assert any(line.startswith("Vibration test: needs") for line in lines(section))

    felt = replace(procedure, station=(), environment=procedure.environment[1:])
    only = section_of(analyze(device, procedure=felt, validate=False))
    assert_says(finding(only), "is known", "vibration rectification")


def test_a_known_value_is_never_called_one_sigma(shaky):
    """Among the inputs and the assumptions a vibration is what it is."""
    device, procedure = shaky
    (said,) = [text for text in procedure.assumptions if "vibration" in text]
    assert_says(said, "1 g", "known value")
    assert "sigma" not in said
    row = next(
        row for row in rows(inputs_section((device,), procedure)) if "1 g" in row
    )
    assert row[0] == "vibration.test"
    given = next(line for line in device.gyro.lines if "temperature" in line.name)
    assert given.meaning == "known value"


@pytest.mark.parametrize(
    ("station", "words"),
    [
        (None, ("none is given", "ideal", "assumed")),
        ("ideal", ("given as ideal", "ideal.yaml")),
        ("granite-plate-cube", ("granite-plate-cube.yaml", "figures")),
    ],
)
def test_a_procedure_says_its_station_in_a_line(station, words):
    """Ideal and assumed, given as ideal, or with figures; without figures no more."""
    procedure = load_procedure(station=station)
    pairs = dict(procedure_section(procedure, ("gyro",)).blocks[0].rows)
    assert_says(say(pairs["station"]), *words)
    budget = analyze(load_device("zhao-2019"), procedure=procedure, validate=False)
    assert (section_of(budget) is None) == (station in {None, "ideal"})


def test_the_coupling_figure_has_a_head_for_every_owner(shaky):
    """Rows of station and environment under their own heads, named within them."""
    device, procedure = shaky
    question = question_of(analyze(device, procedure=procedure, validate=False))
    table = coupling(question)
    chart = coupling_chart(table, "gyro")
    assert [group.title for group in chart.groups][:3] == [
        "gyro",
        "station",
        "environment",
    ]
    assert [row.label for row in chart.groups[1].rows] == ["turn angle", "azimuth"]
    assert_says(chart.alt, "station: turn angle", "environment: temperature ramp")
    bare = question_of(analyze(device, validate=False))
    alone = coupling(bare)
    assert coupling_chart(alone, "gyro").groups[0].title == ""
