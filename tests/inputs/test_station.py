"""Station files: alone, named by a procedure, and beside one on the command line."""

from __future__ import annotations

import json

import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import put

from budget.errors import CallError, SpecError
from budget.inputs import (
    load_calibration,
    load_mission,
    load_procedure,
    load_station,
    validate,
)
from budget.inputs.use import AGE, in_use
from budget.model.windows import Timing
from budget.units import ARCSEC

pytestmark = pytest.mark.usefixtures("drawn_once")

OWN = """name: ours
station:
  turn_angle: 3 arcsec
  rate_error: {value: 7 ppm, source: its certificate}
  gravity: 1 mGal
environment: {temperature: {ramp: 1 degC/h}}
"""
REQUIREMENT = "name: r\nenvironment: none\nlimits: {gyro: {scale_factor: 500 ppm}}\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with a station and procedures, in which commands run."""
    (tmp_path / "ours.yaml").write_text(OWN)
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "beside.yaml").write_text("station: {mount: 5 arcsec}\n")
    (tmp_path / "sub" / "plan.yaml").write_text("name: p\nstation: beside.yaml\n")
    (tmp_path / "r.yaml").write_text(REQUIREMENT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_shipped_stations_are_those_of_the_docs():
    """Three; the ideal one has no figure, the cube no turn."""
    names = {
        name: {line.name for line in load_station(name).station}
        for name in ("ideal", "three-axis-table", "granite-plate-cube")
    }
    assert names["ideal"] == set()
    assert {"turn_angle", "wobble", "mount", "azimuth"} <= names["three-axis-table"]
    assert not {"turn_angle", "wobble", "edge_jitter"} & names["granite-plate-cube"]
    for name in names:
        for line in load_station(name).station:
            assert line.condition
            assert line.source


def test_a_station_file_is_read_as_a_procedures_own(folder):
    """Figures, words and environment; what is left open is said."""
    (folder / "inline.yaml").write_text(OWN + "latitude: 34.2394 deg\n")
    inline = load_procedure("inline.yaml")
    beside = load_procedure(station="ours.yaml")
    for one in (inline, beside):
        assert [line.name for line in one.station] == [
            *("turn_angle", "rate_error", "gravity"),
        ]
        assert_allclose(one.station[0].u, 3.0 * ARCSEC, rtol=1e-12)
        assert_allclose(one.station[2].u, 1e-5, rtol=1e-12)
        assert [line.name for line in one.environment] == ["temperature.ramp"]
        assert "station.scale_from: not given, angle assumed" in one.assumptions
        assert "station: not given, an ideal one assumed" not in one.assumptions
        assert any("its certificate" in text for text in one.assumptions)
    assert beside.station_origin.file == "ours.yaml"
    assert beside.timing == Timing()


def test_a_procedure_names_a_station_beside_it(folder):
    """The file in its own folder, a shipped one, else what is wrong, at its key."""
    plan = load_procedure("sub/plan.yaml")
    assert [line.name for line in plan.station] == ["mount"]
    (folder / "shipped.yaml").write_text("name: s\nstation: three-axis-table\n")
    assert len(load_procedure("shipped.yaml").station) > 10
    assert validate("shipped.yaml").kind == "procedure"

    (folder / "none.yaml").write_text("name: s\nstation: three-axis-tabel\n")
    with pytest.raises(
        SpecError, match=r"none.yaml:2:10: station: .*'three-axis-table'"
    ):
        load_procedure("none.yaml")
    (folder / "bad.yaml").write_text("station: {turn_angel: 1 arcsec}\n")
    (folder / "named.yaml").write_text("name: s\nstation: bad.yaml\n")
    with pytest.raises(SpecError, match=r"bad.yaml:1:.*turn_angel.*turn_angle"):
        load_procedure("named.yaml")


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("station: {mount: 1 arcsec}\n", "station of its own"),
        ("environment: {temperature: {ramp: 1 degC/h}}\n", "environment of its own"),
    ],
)
def test_two_stations_are_refused(folder, text, what):
    """No one is taken for the other in silence."""
    (folder / "plan.yaml").write_text(f"latitude: 45 deg\n{text}")
    with pytest.raises(SpecError, match=what):
        load_procedure("plan.yaml", station="ours.yaml")
    (folder / "both.yaml").write_text(
        "station: ours.yaml\nenvironment: {temperature: {ramp: 1 degC/h}}\n"
    )
    with pytest.raises(SpecError, match=r"both.yaml:2:1: environment"):
        load_procedure("both.yaml")


@pytest.mark.slow
@pytest.mark.usefixtures("folder")
def test_every_command_takes_a_station_and_says_its_file():
    """Analyze, compare, allocate and report; the numbers move, the file is named."""
    asked = {
        "analyze": ("--no-validate",),
        "compare": ("--requirement", "r.yaml", "--method", "gum"),
        "allocate": ("--requirement", "r.yaml", "--no-validate"),
    }
    for command, more in asked.items():
        found = []
        for station in ((), ("--station", "ours.yaml")):
            run = call(command, "zhao-2019", *more, *station, "--json", "-")
            # Of the temperature of that test the device says nothing: undecidable.
            assert run.code == (1 if station and command != "analyze" else 0), run.err
            found.append(json.loads(run.out))
        assert found[0] != found[1]
        assert "ours.yaml" in json.dumps(found[1]["inputs"]), command
    run = call("analyze", "--station", "nowhere.yaml", code=2)
    assert "three-axis-table" in run.err
    assert "--station" in call("report", "--help").out


def test_an_age_is_given_once(tmp_path):
    """It is a known time of the environment; a second one, and no time, are refused."""
    how = load_procedure(age="1 year")
    (line,) = (one for one in how.environment if one.name == "age")
    assert_allclose(line.u, 365.25 * 86400.0, rtol=1e-15)
    assert "environment.age: 1 year, known value, --age" in how.assumptions
    station = put(
        tmp_path / "station.yaml", "station: {}\nenvironment: {age: 2 years}\n"
    )
    with pytest.raises(SpecError, match=r"has an age of its own.*remove one"):
        load_procedure(station=station, age="1 year")
    for text, why in (("1 ug", "expected a time"), ("-1 s", "not negative")):
        with pytest.raises(CallError, match=f"age: .*{why}"):
            load_procedure(age=text)


def test_an_age_of_zero_that_a_call_states_stays(tmp_path):
    """Beside `environment none`, too: the age that a mission's file has gives way."""
    path = put(
        tmp_path / "m.yaml",
        "name: m\nage: 1 year\nmission:\n  latitude: 45 deg\n  speed: 0 m/s\n"
        "  heading: 0 deg\n  segments: [{stand: 60 s}]\n  at: [60 s]\n",
    )
    for environment in (None, "none"):
        how = load_calibration("factory", age="0 s", environment=environment)
        used = in_use(how, None, load_mission(path))
        (age,) = (line for line in used.environment if line.name == AGE)
        assert not age.u.any()
