"""A mission in a report: its finding, its figures, its limits on page one."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from functools import cache
from html import unescape
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import numpy as np
import pytest
from command_line import call, checked
from figure_text import crossed_texts, cut_texts
from numpy.testing import assert_allclose
from places import TESTS
from reading import assert_says, find, on_terminal, say

from budget.inputs import (
    load_device,
    load_mission,
    load_procedure,
    load_requirement,
    uncalibrated,
)
from budget.inputs.use import in_use
from budget.known import Known
from budget.language import speaking
from budget.names import Name, time_text
from budget.question import Question
from budget.report.analysis.mission import (
    mission_answer,
    mission_document,
    mission_figures,
    mission_section,
)
from budget.report.blocks import Picture, Table
from budget.report.device_file import MARK
from budget.report.figures.growth import (
    PLANE,
    ErrorGrowth,
    growth_pictures,
    growth_plot,
    times_apart,
)
from budget.report.mission import by_time, contributions
from budget.report.tables import unit_for
from budget.studies.analysis import analyze
from budget.studies.mission import curve, drawn_times
from budget.studies.what_if import what_if
from budget.units import ARCSEC, DEGREE, parse_quantity

pytestmark = pytest.mark.usefixtures("drawn_once", "analyzed_once")

LIMITS = {
    "name": "a mile",
    "limits": {
        "gyro": {"bias": "1 deg/h"},
        "mission": {
            "position": [{"horizontal": "1 m", "at": "60 s", "probability": "50 %"}]
        },
    },
}


@cache
def carried(*, limited=False):
    """Return the budget of an outage, with a limit or without."""
    return analyze(
        "zhao-2019",
        validate=False,
        procedure=load_procedure(None),
        requirement=load_requirement(LIMITS) if limited else None,
        mission="outage-60-s",
        at=(10.0, 60.0),
        command="mission",
    )


@cache
def grown():
    """Return how its error grows."""
    times = drawn_times(load_mission("outage-60-s"), (10.0, 60.0))
    return curve(carried().question, times)


def table_of(budget, name):
    """Return a table of the section of a mission."""
    (table,) = (one for one in find(mission_section(budget), Table) if one.name == name)
    return table


def test_the_figure_ends_where_the_table_does():
    """The curve has at its end the CEP, R95 and shares of the law."""
    growth = ErrorGrowth.of(grown())
    row = by_time(carried())[-1].horizontal
    assert growth.curve.times[-1] == 60.0
    assert_allclose(growth.sizes["CEP"][-1], row.radii.cep, rtol=1e-9)
    assert_allclose(growth.sizes["R95"][-1], row.radii.r95, rtol=1e-9)
    shares = {part.source: part.share for part in row.contributions}
    for k, source in enumerate(growth.sources):
        assert_allclose(growth.shares[k, -1], shares[source], rtol=1e-6)


ERRORS = (PLANE, ("attitude", "heading"), ("velocity", "north"))


def test_areas_of_sources_add_up_to_the_whole():
    """Of each error the shares of all sources are 1 at every time."""
    for error in ERRORS:
        growth = ErrorGrowth.of(grown(), error)
        assert_allclose(growth.shares.sum(axis=0), 1.0, rtol=1e-9)


def test_one_error_is_below_what_the_normal_law_says():
    """U95 of heading is 1.96 times its standard uncertainty."""
    growth = ErrorGrowth.of(grown(), ("attitude", "heading"))
    u = grown().standard_uncertainty("attitude", "heading")
    assert_allclose(growth.sizes["U95"], 1.959964 * u, rtol=1e-6)


def test_the_figure_says_its_finding_and_its_numbers():
    """Its title is a finding; every line and area is in the alternative text."""
    (first,) = growth_pictures(grown())
    assert_says(first.title, "1.2 m CEP after 1 min", "of the variance")
    assert_says(first.alt, "R95", "accelerometer bias repeatability", "all others")
    assert_says(first.alt, "shares of its variance", "all others [%]")
    assert {f"curve-{k}" for k in range(1, 4)} <= set(first.tips)
    for name in ("mission-growth-curve-2", "mission-growth-curve-3"):
        assert f'id="{name}"' in first.svg
    assert len(first.data.groups[0].rows) == len(grown().times)


def test_each_limited_error_has_a_figure_with_its_limits():
    """The horizontal one first; of a limit there is a mark and a word."""
    limits = carried(limited=True).assessment.outputs
    (first,) = growth_pictures(grown(), limits)
    assert_says(first.alt, "limit 1 m after 1 min")
    assert "Diamonds" in first.caption
    heading = replace(
        limits[0],
        output=replace(
            limits[0].output,
            name=Name("attitude", owner="mission", axis="heading", time=60.0),
        ),
    )
    found = growth_pictures(grown(), (heading,))
    assert [one.name for one in found][1:] == ["mission-growth-attitude-heading"]
    assert "limit" not in found[0].alt


@pytest.mark.parametrize("error", ERRORS)
def test_texts_of_the_figure_of_a_mission_stand_apart(error):
    """None is cut, and no name lies on another one."""
    figure = growth_plot(ErrorGrowth.of(grown(), error)).figure
    assert cut_texts(figure) == []
    assert [pair for pair in crossed_texts(figure) if pair[1] != "line"] == []


@pytest.mark.parametrize("language", ["en", "zh"])
def test_the_section_has_tables_and_both_figures(language):
    """Position, motion, contributions; and what a page alone shows."""
    with speaking(language):
        section = mission_section(carried(), mission_figures(carried()))
        names = [table.name for table in find(section, Table)]
        pictures = find(section, Picture)
    assert names[:3] == [
        "mission-position",
        "mission-motion",
        "mission-contributions",
    ]
    assert [one.name for one in pictures] == ["mission-growth", "mission-track"]


def test_shares_of_the_table_are_those_of_the_law():
    """Of each time all rows, small ones gathered, make up the whole."""
    table = table_of(carried(), "mission-contributions")
    cells = np.array([[c.exact for c in row[1:]] for row in table.groups[0].rows])
    assert_allclose(cells.sum(axis=0), 1.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("quantity", "size", "unit"),
    [
        ("position", 999.0, "m"),
        ("position", 1000.0, "km"),
        ("position", 0.0, "m"),
        ("velocity", 5000.0, "m/s"),
        ("attitude", 59.0 * ARCSEC, "arcsec"),
        ("attitude", 60.0 * ARCSEC, "arcmin"),
        ("attitude", 3600.0 * ARCSEC, "deg"),
    ],
)
def test_units_are_those_that_one_reads(quantity, size, unit):
    """The next one begins where it is 1."""
    assert unit_for(quantity, size)[0] == unit


@pytest.mark.parametrize(
    ("duration", "asked", "first"),
    [(3600.0, (10.0, 60.0), 10.0), (3600.0, (3600.0,), 36.0), (86400.0, (1.0,), 86.4)],
)
def test_the_axis_has_two_decades_or_three(duration, asked, first):
    """It begins with what is asked for; it ends with the mission."""
    lasting = SimpleNamespace(duration=duration)
    times = drawn_times(replace(load_mission("bench"), route=lasting), asked)
    assert times[0] == first
    assert times[-1] == duration
    assert list(times) == sorted(set(times))
    assert {one for one in asked if one >= first} <= set(times)


@pytest.mark.slow
def test_a_report_judges_mission_and_calibration_together(tmp_path):
    """One conformance of both; the page and the document have the same numbers."""
    wanted = tmp_path / "mile.json.yaml"
    wanted.write_text(json.dumps(LIMITS), encoding="utf-8")
    page, numbers = tmp_path / "a.html", tmp_path / "a.json"
    run = call(
        *("report", "zhao-2019", "--mission", "outage-60-s", "--no-validate"),
        *("--requirement", wanted, "-o", page, "--json", numbers),
    )
    assert run.code == 0, run.err
    found = checked(json.loads(numbers.read_text(encoding="utf-8")))
    sensors = [one["sensor"] for one in found["assessment"]["sensors"]]
    assert sensors == ["gyro", "mission"]
    own = found["mission"]
    assert own["command"] == "mission"
    (far,) = (
        one
        for one in own["outputs"]
        if (one["parameter"], one["axis"], one["time"])
        == ("position", "horizontal", 60.0)
    )
    (judged,) = (
        one for one in found["assessment"]["outputs"] if one["sensor"] == "mission"
    )
    assert judged["largest_error"] == far["cep"]
    assert judged["coverage"] == 0.5
    text = page.read_text(encoding="utf-8")
    assert_says(text, f"{far['cep']:.2g} m CEP")
    assert_says(text, "Mission: outage of 60 s")
    assert 'id="mission-growth' in text


@pytest.mark.slow
def test_the_command_of_the_sliders_judges_the_mission(tmp_path, monkeypatch):
    """What the page hands out is a report, and says of a changed line what it says."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mile.yaml").write_text(json.dumps(LIMITS), encoding="utf-8")
    run = call(
        *("report", "zhao-2019", "--mission", "outage-60-s", "--no-validate"),
        *("--at", "10 s", "--requirement", "mile.yaml", "-o", "a.html"),
    )
    assert run.code == 0, run.err
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    (found,) = re.findall(r'class="what-if-model">(.*?)</script>', text)
    model = json.loads(unescape(found))
    (tmp_path / "changed.yaml").write_text(
        model["device"].replace(MARK, ""), encoding="utf-8"
    )
    change = ("--set", "accelerometer.bias_repeatability=74 ug", "--json", "a.json")
    run = call(*shlex.split(model["command_of_file"])[1:], *change)
    assert run.code == 0, run.err
    assert model["command"] == (
        "budget report zhao-2019 --requirement mile.yaml --mission outage-60-s "
        "--at '10 s' --no-validate -o changed.html"
    )
    told = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    wanted, mission = load_requirement(LIMITS), load_mission("outage-60-s")
    how = in_use(load_procedure(), wanted, mission)
    question = replace(
        Question.of(load_device("zhao-2019"), procedure=how, requirement=wanted),
        mission=mission,
    )
    outlook = what_if(question).evaluate({"accelerometer.bias_repeatability": 2.0})
    for ours, theirs in zip(
        outlook.sensors, told["assessment"]["sensors"], strict=True
    ):
        assert (ours.sensor, ours.verdict) == (theirs["sensor"], theirs["verdict"])
        assert_allclose(ours.utilisation, theirs["utilisation"], rtol=1e-6)


def test_a_time_takes_a_mission(tmp_path):
    """--at alone is refused in words."""
    run = call("report", "--at", "10 s", "-o", tmp_path / "a.html")
    assert run.code == 2
    assert_says(run.err, "--mission")


@cache
def page_of_a_mile(verdict):
    """Return the words of a report with one limit, on the mission."""
    limit = {"meets": "9 nmi", "fails": "0.0001 nmi"}[verdict]
    wanted = {
        "name": verdict,
        "limits": {"mission": {"position": {"horizontal": limit, "at": "60 s"}}},
    }
    with TemporaryDirectory() as folder:
        path, page = Path(folder) / "wanted.yaml", Path(folder) / "a.html"
        path.write_text(json.dumps(wanted), encoding="utf-8")
        run = call(
            *("report", "zhao-2019", "--mission", "outage-60-s", "--no-validate"),
            *("--requirement", path, "-o", page),
        )
        assert run.code == 0, run.err
        text = page.read_text(encoding="utf-8")
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]*>", "", text)))


@pytest.mark.slow
@pytest.mark.parametrize("verdict", ["meets", "fails"])
def test_page_one_is_of_the_mission_that_is_limited(verdict):
    """Its contributors are those of the limited error; its place stands on top."""
    text = page_of_a_mile(verdict)
    (said,) = re.findall(r"Horizontal position after 1 min: (.*?)\. ", text)
    assert_says(said, "nmi allowed", "of the variance")
    assert_says(
        text, "mission outage of 60 s, raw turn-on biases, from latitude 45 deg"
    )


@pytest.mark.parametrize("verdict", ["meets", "fails"])
def test_a_small_error_is_in_a_unit_of_its_own(verdict):
    """Metres of a limit in miles: nobody reads 0.0005 nmi."""
    text = page_of_a_mile(verdict)
    assert len(re.findall(r"after 1 min: [\d.]+ m of [\d.]+ nmi allowed", text)) >= 1
    assert not re.findall(r"after 1 min: 0\.000\d+ nmi of ", text)


@pytest.mark.parametrize("sizes", [(0.25, 4200.0), (1500.0, 42_000.0), (0.0, 2000.0)])
def test_a_column_has_one_unit(sizes):
    """Metres and kilometres do not stand below one another; the smallest decides."""
    last = max(row.output.name.time for row in carried().outputs)
    rows = [
        replace(
            row,
            standard_uncertainty=Known(sizes[row.output.name.time == last]),
            radii=None,
        )
        if row.parameter == "position"
        else row
        for row in carried().outputs
    ]
    table = table_of(replace(carried(), outputs=tuple(rows)), "mission-position")
    units = {row[-1].text for row in table.groups[0].rows} - {""}

    assert units == {"m" if 0.0 < sizes[0] < 1000.0 else "km"}


def test_heading_has_a_unit_of_its_own():
    """Roll and pitch stand in arcsec beside a heading that is off by degrees."""
    angles = {"roll": 14.0 * ARCSEC, "pitch": 13.0 * ARCSEC, "heading": 1.4 * DEGREE}
    rows = [
        replace(row, standard_uncertainty=Known(angles[row.axis]))
        if row.parameter == "attitude"
        else row
        for row in carried().outputs
    ]
    table = table_of(replace(carried(), outputs=tuple(rows)), "mission-motion")
    (row, _) = table.groups[0].rows
    told = [cell.text for cell in row]
    assert told[-5:] == ["14", "13", "arcsec", "1.4", "deg"]


@pytest.mark.parametrize(
    ("time", "told"),
    [
        (0.5, "0.5 s"),
        (75.0, "75 s"),
        (90.0, "90 s"),
        (600.0, "10 min"),
        (2532.0, "42.2 min"),
        (4320.0, "72 min"),
        (5064.0, "84.4 min"),
        (5400.0, "1.5 h"),
        (86399.0, "86399 s"),
    ],
)
def test_a_time_takes_few_digits(time, told):
    """In the unit that a file would give it in, and it is that time."""
    assert time_text(time) == told
    assert parse_quantity(told, "s").value == time


AIDED = TESTS / "data" / "aided"


@cache
def aided(unit, name):
    """Return the budget of one of the missions with aids, and how its errors grow."""
    mission = load_mission(AIDED / f"{name}.yaml")
    found = analyze(
        AIDED / f"{unit}.yaml",
        validate=False,
        procedure=uncalibrated("factory"),
        mission=mission,
        command="mission",
    )
    return found, curve(found.question, drawn_times(mission, mission.at))


@pytest.mark.slow
def test_a_mission_with_aids_is_drawn_to_where_they_end():
    """From as long before as the mission goes on after it, on an even axis."""
    _, drawn = aided("mems", "g4")
    growth = ErrorGrowth.of(drawn)
    assert 540.0 < drawn.times[0] < 545.0
    assert {600.0, 610.0, 630.0, 660.0} <= set(drawn.times)
    assert_allclose(growth.curve.drms()[-1], 30.9758, rtol=1e-4)
    assert "Shaded: with aids." in growth_pictures(drawn)[0].caption
    assert "Shaded" not in growth_pictures(grown())[0].caption


@pytest.mark.slow
def test_a_mission_whose_aids_never_end_is_drawn_whole():
    """On both of its figures: one point, at its end, warned of an axis of no length."""
    part = {
        "latitude": "47 deg",
        "aiding": {"gnss": {"position": "2.5 m", "rate": "1 Hz"}},
        "segments": [{"stand": "40 s", "aiding": "gnss"}],
    }
    mission = load_mission({"name": "always", "mission": part})
    times = drawn_times(mission, mission.at)
    assert times[0] < 2.0
    assert times[-1] == 40.0
    request = replace(aided("tac", "g1")[0].question, mission=mission)
    request = replace(request, carried_to=mission.at)
    assert len(growth_pictures(curve(request, times))) == 1


@pytest.mark.slow
def test_what_an_own_filter_believes_stands_beside_what_is_true():
    """At every time, of position and heading; the optimal one has no such table."""
    own, optimal = (
        {one.name: one for one in find(mission_section(aided("mems", name)[0]), Table)}
        for name in ("g4", "g3")
    )
    rows = [
        [str(one.text) for one in row] for row in own["filter-believed"].groups[0].rows
    ]
    assert rows[3] == ["11 min", "attitude heading", "981", "1980", "arcsec"]
    assert rows[7] == ["11 min", "position horizontal", "22.9", "31", "m"]
    assert "filter-learnt" in optimal
    assert "filter-believed" not in optimal


@pytest.mark.slow
def test_the_method_says_the_filter_where_there_is_one():
    """Its equations, and whose they are."""
    said = [
        " ".join(map(str, block.words))
        for own in (aided("mems", "g4")[0], carried())
        for block in mission_section(own, mission_figures(own)).blocks[-1:]
    ]
    assert_says(said[0], "K = P H' (H P H' + R)^-1", "Brown and Hwang")
    assert "Brown" not in said[1]


SHEET = TESTS / "guard" / "inputs" / "bare.yaml"
OUTAGE = {
    "name": "ten minutes without satellites",
    "mission": {
        "latitude": "45 deg",
        "segments": [{"straight": "600 s", "speed": "20 m/s"}],
    },
}


@cache
def bare(*, limited=False):
    """Return the budget of a sheet that lacks much on a mission that states little."""
    mission = load_mission(OUTAGE)
    return analyze(
        load_device(SHEET),
        validate=False,
        procedure=uncalibrated("factory"),
        requirement=load_requirement(LIMITS) if limited else None,
        mission=mission,
        command="mission",
    )


@pytest.mark.parametrize("limited", [False, True])
def test_page_one_says_what_it_rests_on_and_the_finding_stands_once(limited):
    """Judged or not: cautions, what a mission begins with, how far off it is."""
    found = mission_document(bare(limited=limited), date="2026-01-01")
    first = on_terminal([one for one in found.sections if one.on_first_page])
    assert_says(first, "alignment: not given, perfect assumed")
    assert_says(first, "altitude: not given, aided assumed")
    assert ("Cautions" in first) == bool(bare(limited=limited).assessment)
    said = on_terminal(found.sections) + " ".join(
        say(words) for card in found.cards for words in card.lines
    )
    assert " ".join(said.split()).count("the horizontal position is off by") == 1


def test_a_brief_answer_says_what_is_assumed():
    """The environment that nobody stated, and how the mission begins."""
    text = on_terminal(mission_answer(bare(), full=False))
    assert_says(text, "Assumed", "its environment not stated", "perfect assumed")
    assert_says(text, "aided assumed")


def test_main_contributors_are_those_of_the_last_time():
    """Not those with the largest share at any time."""
    (first, *_) = contributions(by_time(bare()))["latest"]
    assert first.shares[-1] == max(
        one.share for one in by_time(bare())[-1].horizontal.contributions
    )
    assert "contributors gyro bias stability" in " ".join(
        on_terminal(mission_answer(bare(), full=False)).split()
    )


def test_figures_say_that_errors_are_lower_bounds():
    """Title, words, caption and every number of both tables; nothing where all is."""
    for one in mission_figures(bare()):
        for text in (one.title, one.alt, one.caption):
            assert "\N{GREATER-THAN OR EQUAL TO}" in text
        for row in one.data.groups[0].rows:
            assert {cell.text[0] for cell in row[1:3]} == {
                "\N{GREATER-THAN OR EQUAL TO}"
            }
    for one in mission_figures(carried()):
        assert "\N{GREATER-THAN OR EQUAL TO}" not in one.title + one.alt + one.caption


def test_times_of_a_table_are_told_apart():
    """By as many digits as that takes; two elsewhere."""
    assert times_apart([1.234, 60.0, 62.5]) == ["1.2 s", "1 min", "1.04 min"]
    near = [600.0 + 0.5 * k for k in range(9)]
    assert len(set(times_apart(near))) == len(near)


@pytest.mark.slow
def test_limits_at_the_medians_are_marked_beside_the_mixture(tmp_path):
    """And a brief answer says how much it may use, and whom to ask for what."""
    wanted = tmp_path / "wanted.yaml"
    wanted.write_text(json.dumps(LIMITS).replace("1 m", "20 m"), encoding="utf-8")
    run = call(
        *("mission", SHEET, "--mission", "bench", "--requirement", wanted),
        *("--missing", "predict"),
        COLUMNS="160",
    )
    text = " ".join(run.out.split())
    assert "after 1 min, at the medians" in text
    assert_says(text, "does not conform at the medians")
    assert_says(text, "not at their medians", "of the limit, 90 % over predicted")
    assert_says(text, "ask the maker for it first")
