"""`budget new`: a commented device file that `budget validate` accepts."""

from __future__ import annotations

import io
import re

import pytest
from command_line import call
from places import put

from budget.cli.new import new
from budget.errors import CallError
from budget.inputs import load_device
from budget.model.sources import SENSORS, lines_of


def written(folder, *args):
    """Write a device file; return its path."""
    path = folder / "imu.yaml"
    call("new", path, *args, code=0)
    return path


def lines(device):
    """Return the lines that a device gives, as printed."""
    return {
        f"{sensor.kind}.{line.name}": (line.printed, line.meaning)
        for sensor in device.sensors
        for line in sensor.lines
    }


def test_given_lines_are_in_the_file(tmp_path):
    """What is given is read back; the other sensor is absent, the name the file's."""
    path = written(
        tmp_path,
        *("--line", "gyro.bias_stability=0.5 deg/h"),
        *("--line", "gyro.scale_factor_repeatability={value: 300 ppm, meaning: max}"),
        *("--source", "TS1524: rev. 31"),
    )
    device = load_device(str(path))
    assert lines(device) == {
        "gyro.bias_stability": ("0.5 deg/h", "1 sigma"),
        "gyro.scale_factor_repeatability": ("300 ppm", "max"),
    }
    assert (device.name, device.source) == ("imu", "TS1524: rev. 31")
    assert call("validate", path).code == 0


@pytest.mark.parametrize(
    ("sensor", "line"),
    [(sensor, line) for sensor in SENSORS for line in lines_of(sensor)],
    ids=lambda one: getattr(one, "name", one),
)
def test_every_line_is_there_to_be_filled_in(sensor, line, tmp_path):
    """Uncommented with a value each is read; with the blank it is refused."""
    text = written(tmp_path).read_text("utf-8")
    head, _, tail = text.partition(f"\n{sensor}:\n")
    blank = re.compile(rf"^    # ({line.name}: .*)$", re.MULTILINE)
    assert len(blank.findall(tail)) >= 1
    tail = re.sub(r"^  errors: \{\}.*$", "  errors:", tail, count=1, flags=re.MULTILINE)
    next(one for one in SENSORS if one != sensor)
    for number, code in (("1", 0), ("___", 2)):
        filled = blank.sub(
            lambda found, number=number: "    " + found[1].replace("___", number),
            tail,
            count=1,
        )
        path = put(tmp_path / f"{code}.yaml", f"{head}\n{sensor}:\n{filled}")
        call("validate", path, code=code)


def test_without_a_terminal_and_lines_it_is_a_template(tmp_path):
    """A file of comments is written, and is valid: no line is invented."""
    path = written(tmp_path)
    assert lines(load_device(str(path))) == {}
    assert call("validate", path).code == 0
    assert call("new", "-").out == path.read_text("utf-8").replace(
        "name: imu", "name: new device"
    )


def test_a_file_is_not_lost(tmp_path):
    """One that is there stays, unless --force is given."""
    path = put(tmp_path / "imu.yaml", "mine")
    outcome = call("new", path, code=2)
    assert "--force" in outcome.err
    assert path.read_text("utf-8") == "mine"
    assert call("new", path, "--force").code == 0
    assert path.read_text("utf-8") != "mine"


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("gyro.bias_stability=0.5 deg", "which is an angle, expected an angular rate"),
        ("gyro.bias_stability=-1 deg/h", "not negative"),
        ("gyro.ARW=1 deg/sqrt(h)", "did you mean 'angle_random_walk'"),
        ("gyro.bias_stability={value: 1 deg/h, meaning: 4 sigma}", "found '4 sigma'"),
        ("gyro.bias_stability={value: 1 deg/h", "imu.yaml:"),
        ("gyro.bias_stability", "expected SENSOR.SPEC=VALUE"),
        ("gyros.bias_stability=1 deg/h", "did you mean 'gyro'"),
        ("gyro.=1 deg/h", "expected SENSOR.SPEC=VALUE"),
        ("gyro.bias_stability=1 deg/h\nname: y", "on one line"),
    ],
)
def test_nonsense_is_refused_as_in_a_file(given, said, tmp_path):
    """Exit 2 with the error that the file would have, and no file."""
    outcome = call("new", tmp_path / "imu.yaml", "--line", given, code=2)
    assert said in outcome.err
    assert list(tmp_path.iterdir()) == []


def test_a_line_given_twice_is_refused(tmp_path):
    """Neither of the two is taken in silence."""
    one = ("--line", "gyro.bias_stability=1 deg/h")
    outcome = call("new", tmp_path / "imu.yaml", *one, *one, code=2)
    assert "given twice" in outcome.err


def test_a_name_that_is_no_yaml_is_refused(tmp_path):
    """A device file has the suffix that others look for."""
    outcome = call("new", tmp_path / "imu.txt", code=2)
    assert ".yaml" in outcome.err


class Terminal(io.StringIO):
    """A stream that a person sits at."""

    def isatty(self):
        """Say so."""
        return True


def asked(folder, monkeypatch, answers):
    """Answer the questions; return the file and what was said."""
    said = Terminal()
    monkeypatch.setattr("sys.stdin", Terminal("".join(f"{one}\n" for one in answers)))
    monkeypatch.setattr("sys.stderr", said)
    path = folder / "imu.yaml"
    new(path)
    return path, said.getvalue()


def test_on_a_terminal_it_asks(tmp_path, monkeypatch):
    """A wrong answer is explained and asked again; Enter leaves a line out."""
    wrong, right = ["1 deg", "max"], ["1 deg/h", "max"]
    stable = ["0.3 deg/h", "typical", "allan_minimum"]
    rest = [""] * 10
    path, said = asked(
        tmp_path, monkeypatch, ["Mine, 2", "", *wrong, *right, *stable, *rest]
    )
    device = load_device(str(path))
    assert lines(device) == {
        "gyro.bias_repeatability": ("1 deg/h", "max"),
        "gyro.bias_stability": ("0.3 deg/h", "typical"),
    }
    assert (device.name, device.source) == ("Mine, 2", "")
    assert "found '1 deg', which is an angle" in said
    # Each expected line but flicker, and the second noise, since none was given.
    assert said.count("such as 1 ") == 1 + 6 + 6
    assert "docs/datasheets.md#bias-stability" in said


def test_answers_that_end_write_nothing(tmp_path, monkeypatch):
    """The end of stdin is no Enter."""
    with pytest.raises(CallError, match="nothing was written"):
        asked(tmp_path, monkeypatch, ["Mine"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("option", ["--name", "--source"])
def test_a_name_on_two_lines_is_refused(option, tmp_path):
    """A file is not broken by what is put into it."""
    outcome = call("new", tmp_path / "imu.yaml", option, "a\nb: c", code=2)
    assert "on one line" in outcome.err
    assert list(tmp_path.iterdir()) == []
