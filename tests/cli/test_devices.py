"""`budget devices`: what ships, and what one data sheet says."""

from __future__ import annotations

import command_line
import pytest
from command_line import call
from places import put
from reading import assert_says

import budget
from budget.errors import SpecError
from budget.inputs import load_all, load_device, load_variants, variants
from budget.missing.grades import grade


@pytest.fixture
def wide(monkeypatch):
    """Give the terminal room for all columns."""
    monkeypatch.setitem(command_line.TERMINAL, "COLUMNS", "160")


@pytest.mark.usefixtures("wide")
def test_list_names_every_shipped_device():
    """One line for each device and variant, by its name."""
    out = call("devices").out
    lines = [line for line in out.partition("\n\n")[0].splitlines()[1:] if line]
    catalogue = budget.load_catalogue()

    assert len(lines) == len(catalogue)
    for line, device in zip(lines, catalogue, strict=True):
        assert line.startswith(device.name)


@pytest.mark.usefixtures("wide")
def test_list_says_kind_grade_and_completeness():
    """The paper's IMU: tactical gyros by bias stability, five lines of five each."""
    (line,) = (x for x in call("devices").out.splitlines() if " zhao-2019 " in x)

    assert "IMU" in line
    assert "tactical/navigation" in line
    assert "5/5 5/5" in line


@pytest.mark.usefixtures("wide")
def test_every_name_of_the_list_is_taken(tmp_path, monkeypatch):
    """What stands under name is a DEVICE of every command, in any folder."""
    monkeypatch.chdir(tmp_path)
    lines = call("devices").out.partition("\n\n")[0].splitlines()
    place = lines[0].index(" name ") + 1
    names = [line[place:].split()[0] for line in lines[1:]]

    found = [load_device(name).origin for name in names]
    assert found == [one.origin for one in budget.load_catalogue()]
    assert "hg4930#A" in names
    assert call("analyze", "hg4930#A", "--no-validate").code == 0


def test_a_file_that_ships_and_is_not_here_is_named_as_it_is_given():
    """The error for hg4930.yaml#A says hg4930#A."""
    found = call("analyze", "specs/hg4930.yaml#A", code=2)
    assert_says(found.err, "specs/hg4930.yaml", "'hg4930#A'")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--kind", "gyro"), lambda one: one.gyro),
        (("--kind", "imu"), lambda one: one.gyro and one.accelerometer),
        (
            ("--kind", "gyro", "--grade", "tactical"),
            lambda one: one.gyro and grade(one.gyro) == "tactical",
        ),
        (
            ("--grade", "navigation", "--grade", "consumer"),
            lambda one: {"navigation", "consumer"} & {*map(grade, one.sensors)},
        ),
    ],
)
def test_the_list_is_cut_to_kinds_and_grades(words, expected):
    """A kind alone or in an IMU, and the grade is that of the kind asked for."""
    found = call("devices", *words, "--json", "-").document["devices"]
    wanted = [one.name for one in budget.load_catalogue() if expected(one)]

    assert [one["name"] for one in found] == wanted
    assert 0 < len(wanted) < len(budget.load_catalogue())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("devices", "hg4930", "--kind", "gyro"), ("--kind", "hg4930")),
        (("devices", "--kind", "gyro", "--grade", "navigation"), ("found none",)),
        (("devices", "--grade", "best"), ("--grade", "best", "navigation")),
    ],
)
def test_what_chooses_nothing_is_refused(words, said):
    """A named device is not chosen, and no device is no list."""
    found = call(*words)
    assert (found.code, found.out) == (2, "")
    assert_says(found.err, *said)


def test_json_of_the_list():
    """The document has the names of the catalogue and what each one is."""
    document = call("devices", "--json", "-").document

    assert (document["schema"], document["command"]) == ("budget/1", "devices")
    names = [device["name"] for device in document["devices"]]
    assert names == [device.name for device in budget.load_catalogue()]


@pytest.mark.usefixtures("wide")
def test_one_device_shows_printed_figure_and_what_it_means():
    """A maker's Allan minimum stands beside the standard uncertainty taken from it."""
    out = call("devices", "hg4930#C").out

    (line,) = (
        x for x in out.splitlines() if x.startswith("bias stability") and "°/hr" in x
    )
    # As flicker noise: in the terms of the maker, the lowest point.
    assert line.count("0.25 °/hr") == 2
    assert "allan minimum" in out
    assert "Printed, not budgeted" in out
    assert "not given" in out


def test_one_device_as_json():
    """Figures stand as printed and as standard uncertainty in the unit as printed."""
    document = call("devices", "zhao-2019", "--json", "-").document
    gyro = document["device"]["sensors"][0]
    line = next(x for x in gyro["lines"] if x["line"] == "bias_stability")

    assert line["printed"] == "0.04 deg/h"
    assert line["unit"] == "deg/h"
    assert [round(u, 12) for u in line["standard_uncertainty"]] == [0.04] * 3
    assert line["correlation_time"] == [300.0] * 3


def test_file_with_variants_shows_each():
    """Without '#' all variants of a file are shown, with it one."""
    every = call("devices", "hg4930").out
    one = call("devices", "hg4930#A").out

    assert [name in every for name in ("(A)", "(B)", "(C)")] == [True] * 3
    assert [name in one for name in ("HG4930 (A)", "HG4930 (B)")] == [True, False]


def test_unknown_device_is_2():
    """A name that there is not: exit 2 and the nearest one."""
    run = call("devices", "hg493", code=2)

    assert "did you mean 'hg4930'" in run.err


@pytest.mark.parametrize("name", ["hg4930", "zhao-2019"])
def test_variants_are_read_as_one_by_one(name):
    """Reading a file once gives the devices that reading each variant gives."""
    together = load_variants(name)
    alone = [load_device(f"{name}#{v}" if v else name) for v in variants(name)]

    assert [d.name for d in together] == [d.name for d in alone]
    for a, b in zip(together, alone, strict=True):
        assert a.origin == b.origin
        for s, t in zip(a.sensors, b.sensors, strict=True):
            assert [line.u.tolist() for line in s.lines] == [
                line.u.tolist() for line in t.lines
            ]


def test_errors_of_several_files_come_together(tmp_path):
    """Two bad files are told at once."""
    paths = []
    for name in ("one", "two"):
        path = put(
            tmp_path / f"{name}.yaml", f"name: {name}\ngyro: {{errors: {{bias: 1}}}}\n"
        )
        paths.append(path)
    with pytest.raises(SpecError) as caught:
        load_all(paths)

    assert {issue.file for issue in caught.value.issues} == set(map(str, paths))
