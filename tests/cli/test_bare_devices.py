"""Devices of which next to nothing is known, given to every command."""

from __future__ import annotations

import csv
import io
import json

import pytest
from command_line import call
from keeping import once
from reading import assert_says

from budget.studies.comparison import judging

pytestmark = pytest.mark.usefixtures("drawn_once")

DEVICES = {
    "empty.yaml": "name: Empty\ngyro: {}\n",
    "both.yaml": "name: Both\ngyro: {}\naccelerometer: {}\n",
    "base.yaml": "name: Base\ngyro: {}\n"
    "variants:\n  A: {gyro: {errors: {bias_repeatability: 0.1 deg/h}}}\n",
    "abstract.yaml": "name: Abstract\nabstract: true\ngyro: {}\n"
    "variants:\n  A: {gyro: {errors: {bias_repeatability: 0.1 deg/h}}}\n",
    "one.yaml": "name: One\ngyro: {errors: {bias_repeatability: 0.1 deg/h}}\n",
    "zero.yaml": "name: Zero\ngyro: {errors: {bias_repeatability: 0 deg/h}}\n",
}
GRADE = "--requirement tactical-grade"
FEW = "--trials 5000"
COMMANDS = (
    "validate DEVICE",
    "devices DEVICE",
    "analyze DEVICE",
    f"analyze DEVICE --method monte-carlo {FEW}",
    "analyze DEVICE --method simulation --trials 2",
    "analyze DEVICE --no-validate --sobol --samples 64",
    "analyze DEVICE --no-validate --sobol --samples 64 --reference as_tested",
    "analyze DEVICE --no-validate --only bias_repeatability",
    f"report DEVICE -o out.html {GRADE} --no-validate",
    f"report DEVICE -o out.html {GRADE} --no-validate --allocate",
    f"report -o out.html {GRADE} --no-validate --compare DEVICE",
    f"compare DEVICE {GRADE} {FEW} --max-trials 5000",
    f"compare DEVICE zhao-2019 {GRADE} --method gum --validate --pairs",
    (
        f"compare DEVICE {GRADE} --method gum --procedure zhao-2019 "
        "--procedure zhao-2019-eq4 -o out.html -o out.pdf --json out.json --csv out.csv"
    ),
    f"allocate DEVICE {GRADE}",
    f"allocate DEVICE {GRADE} --strategy cost --write out.yaml",
    "check DEVICE --save out.json",
    f"check DEVICE --save out.json --kind compare {GRADE} --method gum",
    f"check DEVICE --save out.json --kind allocate {GRADE}",
)
SLOW = ("report", "allocate")  # these get two devices, some seconds each
ANSWERED = (0, 1, 2)  # met, not met, refused in words


@pytest.fixture(scope="module", autouse=True)
def judged_once():
    """Judge the device beside the one of which little is known once for all of them."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("judge", "validate"):
            patch.setattr(judging, name, once(getattr(judging, name), {}))
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide the devices, and work there."""
    for name, text in DEVICES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.usefixtures("folder")
def test_every_command_answers_for_a_device_of_which_little_is_known(command):
    """It computes what is there or says what is missing; never a traceback."""
    names = ("empty.yaml", "one.yaml") if command.startswith(SLOW) else DEVICES
    for name in names:
        run = call(*command.replace("DEVICE", name).split())
        assert run.code in ANSWERED, (name, run)
        assert "Traceback" not in run.err, name
        if run.code == 2:
            assert run.err.strip(), name


@pytest.mark.parametrize("method", ["gum", "monte-carlo"])
@pytest.mark.usefixtures("folder")
def test_a_sensor_without_lines_is_undecidable_without_a_figure(method):
    """It is in no ranking; its entry has a verdict, what is missing and no number."""
    how = ("--requirement", "tactical-grade", "--method", method)
    run = call("compare", "base.yaml", "both.yaml", *how, "--json", "-")
    assert run.code == 1
    assert [row["name"] for row in run.document["devices"]] == ["Base (A)"]
    found = run.document["nothing_known"]
    assert [(row["name"], row["sensor"]) for row in found] == [
        ("Base", "gyro"),
        ("Both", "gyro"),
        ("Both", "accelerometer"),
    ]
    for row in found:
        assert row["verdict"] == "undecidable"
        assert len(row["missing"]["lines"]) == 5
        assert not {"rank", "utilisation", "conformance"} & row.keys()


@pytest.mark.usefixtures("folder")
def test_a_sensor_without_lines_alone_meets_nothing():
    """Exit code 1, NOT MET, and one row of the CSV, without a number."""
    how = ("--requirement", "tactical-grade", "--method", "gum")
    run = call("compare", "empty.yaml", *how)
    assert run.code == 1
    assert "Empty, no error specification given" in run.out
    assert "0 of 1 gyro meets" in " ".join(run.out.split())
    assert "0.00" not in run.out
    (row,) = csv.DictReader(
        io.StringIO(call("compare", "empty.yaml", *how, "--csv", "-").out)
    )
    assert row["verdict"] == "undecidable"
    assert row["device_utilisation"] == row["device_conformance"] == row["rank"] == ""


def test_a_report_on_a_sensor_without_lines_says_that_nothing_is_known(folder):
    """No output is said to stay within its limit, and none to have some to spare."""
    how = ("--requirement", "tactical-grade", "--no-validate", "-o", "out.html")
    assert call("report", "both.yaml", *how).code == 0
    page = (folder / "out.html").read_text(encoding="utf-8")
    assert_says(page, "nothing is known", "gyro and accelerometer")
    assert "to spare" not in page
    assert "within their limits" not in page
    assert "UNDECIDABLE" in page


def test_a_reference_holds_a_sensor_without_lines(folder):
    """It is stored with its verdict, and checked again."""
    how = ("--kind", "compare", "--requirement", "tactical-grade", "--method", "gum")
    assert call("check", "--save", "ref.json", "base.yaml", *how).code == 0
    stored = json.loads((folder / "ref.json").read_text(encoding="utf-8"))
    assert "undecidable" in json.dumps(stored)
    assert call("check", "ref.json").code == 0
    one = DEVICES["base.yaml"].replace(
        "gyro: {}", "gyro: {errors: {bias_repeatability: 9 deg/h}}"
    )
    (folder / "base.yaml").write_text(one, encoding="utf-8")
    assert call("check", "ref.json").code == 1
