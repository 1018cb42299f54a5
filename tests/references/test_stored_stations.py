"""References at a test station: its file is stored, checked, and never lost."""

from __future__ import annotations

import json

import pytest
from command_line import call
from places import put
from reading import assert_says
from reference_examples import DEVICE

from budget.errors import CallError
from budget.references.check import make_reference
from budget.references.files import stored_documents, take
from budget.references.jobs import compute
from budget.references.records import Stored

HUT = "station: {gravity: 20 mGal, mount: 3 arcsec}\n"
PLAN = "name: p\nlatitude: 40 deg\nstation: hut.yaml\n"
GRAVITY = "station.gravity: 20 mGal -> 30 mGal"
WAYS = {
    "given": ("--station", "hut.yaml"),
    "named": ("--procedure", "plan.yaml"),
    "below": ("--procedure", "sub/plan.yaml"),
    "compared": (
        *("--procedure", "plan.yaml", "--kind", "compare"),
        *("--requirement", "tactical-grade"),
    ),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a device, a station, procedures that name it, and work there."""
    (tmp_path / "sub").mkdir()
    for name, text in {
        "imu.yaml": DEVICE,
        "hut.yaml": HUT,
        "plan.yaml": PLAN,
        "sub/plan.yaml": PLAN,
        "sub/hut.yaml": HUT,
    }.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def save(*options):
    """Store a reference; return what the command did."""
    return call("check", "--save", "ref.json", "imu.yaml", *options)


def inputs(folder):
    """Return role and file of each stored input."""
    stored = json.loads((folder / "ref.json").read_text())["inputs"]
    return [(one["role"], one["file"]) for one in stored]


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_the_station_is_stored_and_its_change_is_named(folder, way):
    """Given beside a procedure or named by it: held, then moved by that key alone."""
    assert save(*WAYS[way]).code == 0
    file = "sub/hut.yaml" if way == "below" else "hut.yaml"
    assert ("station", file) in inputs(folder)
    assert call("check", "ref.json").code == 0

    (folder / file).write_text(HUT.replace("20 mGal", "30 mGal"))
    run = call("check", "ref.json", code=1)
    assert_says(
        run.out, "station hut.yaml", GRAVITY, "1 reference: 0 unchanged, 1 moved"
    )


def test_a_reference_without_station_does_not_have_its_numbers(folder):
    """What a station adds is in the stored numbers, not only its file."""
    assert save().code == 0
    plain = (folder / "ref.json").read_text()
    assert save("--station", "hut.yaml").code == 0
    with_station = json.loads((folder / "ref.json").read_text())["numbers"]
    assert "station.gravity" not in plain
    assert any("station.gravity" in json.dumps(one) for one in with_station)


def test_what_is_stored_needs_no_file(folder):
    """The stored text of the station is computed with, wherever its file went."""
    taken = [
        *(take("device", "imu.yaml"), take("procedure", "plan.yaml")),
        take("station", "hut.yaml"),
    ]
    there = make_reference("analyze", taken, Stored())
    (folder / "hut.yaml").unlink()
    read = stored_documents(taken, reference="old", job="analyze")
    again = compute("analyze", read, Stored())
    assert again.numbers == there.numbers
    with pytest.raises(CallError, match="not among the inputs"):
        compute("analyze", read[:2], Stored())


@pytest.mark.parametrize("way", WAYS)
def test_a_station_that_is_gone_is_said(folder, way):
    """Nothing is computed without it."""
    assert save(*WAYS[way]).code == 0
    (folder / ("sub" if way == "below" else ".") / "hut.yaml").unlink()
    if way == "below":
        (folder / "hut.yaml").unlink()
    run = call("check", "ref.json", code=2)
    assert "hut.yaml" in run.err


@pytest.mark.slow
def test_a_procedure_that_names_another_station_is_at_that(folder):
    """The check goes by the procedure as it is now, and says what became another."""
    assert save(*WAYS["named"]).code == 0
    (folder / "other.yaml").write_text(HUT.replace("20 mGal", "30 mGal"))
    (folder / "plan.yaml").write_text(PLAN.replace("hut.yaml", "other.yaml"))
    run = call("check", "ref.json", code=1)
    assert GRAVITY in run.out
    (folder / "plan.yaml").write_text(PLAN.replace("station: hut.yaml\n", ""))
    run = call("check", "ref.json", code=1)
    assert_says(run.out, "station", "hut.yaml", "there")


def test_a_station_outside_the_tree_is_not_opened(folder, tmp_path_factory):
    """As of every input: a procedure is no way round it."""
    assert save(*WAYS["named"]).code == 0
    elsewhere = put(
        tmp_path_factory.mktemp("elsewhere") / "secret.yaml", "secret: yes\n"
    )
    (folder / "plan.yaml").write_text(PLAN.replace("hut.yaml", str(elsewhere)))
    run = call("check", "ref.json", code=2)
    assert_says(run.err, "outside", "not opened")
    assert "secret: yes" not in run.err


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ((*WAYS["named"], "--station", "hut.yaml"), "leave --station out"),
        (
            (*WAYS["compared"], "--procedure", "sub/plan.yaml"),
            "a reference stores one",
        ),
    ],
)
def test_two_stations_are_refused(folder, options, what):
    """In words, and nothing is written."""
    run = save(*options)
    assert run.code == 2
    assert what in run.err
    assert not (folder / "ref.json").exists()


@pytest.mark.usefixtures("folder")
def test_a_check_takes_no_station():
    """It is that of the reference."""
    assert save().code == 0
    run = call("check", "ref.json", "--station", "hut.yaml", code=2)
    assert "--save" in run.err
