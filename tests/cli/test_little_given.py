"""Devices of which nothing, zeros, one line or axis is given, to every command."""

from __future__ import annotations

import csv
import io
import json
import re

import pytest
from command_line import call
from keeping import once
from reading import assert_says

from budget.studies.comparison import judging

pytestmark = pytest.mark.usefixtures("drawn_once")

TRIADS = "name: u\ngyro: {{errors: {}}}\naccelerometer: {{errors: {}}}\n"
VARIANT = """gyro: {}
variants: {A: {gyro: {errors: {bias_repeatability: 0.1 deg/h}}}}
"""
ZEROS = (
    "{{bias_repeatability: 0 {0}, bias_stability: 0 {0}, "
    "mounting_repeatability: 0 arcsec}}"
)
UNITS = {
    "nothing": TRIADS.format("{}", "{}"),
    "zeros": TRIADS.format(ZEROS.format("deg/h"), ZEROS.format("ug")),
    "line": TRIADS.format("{sample_noise: 1 deg/h}", "{}"),
    "axis": TRIADS.format(
        "{bias_repeatability: {axes: {x: 1 deg/h, y: 0 deg/h, z: 0 deg/h}}}", "{}"
    ),
}
SHAPES = {
    "empty": "name: Empty\ngyro: {}\n",
    "both": "name: Both\ngyro: {}\naccelerometer: {}\n",
    "base": f"name: Base\n{VARIANT}",
    "abstract": f"name: Abstract\nabstract: true\n{VARIANT}",
}
LIMIT = (
    "name: soon\nenvironment: none\n"
    "limits: {mission: {position: {horizontal: 1 m, at: 1e-4 s}}}\n"
)
GRADE = "--requirement tactical-grade"
FEW = "--trials 1000"
SOON = "--mission bench --at 1e-4_s --no-validate"
COMMANDS = (
    "validate UNIT",
    "devices UNIT",
    f"analyze UNIT {GRADE}",
    "analyze UNIT --no-validate --only gyro.flicker",
    "analyze UNIT --no-validate --only bias_repeatability",
    f"analyze UNIT --method monte-carlo {FEW}",
    "analyze UNIT --method simulation --trials 2",
    "analyze UNIT --no-validate --sobol --samples 16",
    "analyze UNIT --no-validate --sobol --samples 64 --reference as_tested",
    f"analyze UNIT {SOON}",
    "mission UNIT --mission bench --no-validate",
    f"mission UNIT {SOON} --only gyro.flicker",
    f"mission UNIT {SOON} --only gyro.bias_stability",
    f"mission UNIT {SOON} --calibration none",
    f"mission UNIT {SOON} --calibration zhao-2019 --language zh",
    f"mission UNIT {SOON} --requirement soon.yaml",
    f"mission UNIT --mission bench --at 1e-4_s --method monte-carlo {FEW}",
    "mission UNIT --mission bench-self-aligned --at 1e-4_s --no-validate",
    f"report UNIT -o out.html {GRADE} --no-validate --allocate",
    f"report UNIT -o out.html {SOON}",
    f"report base.yaml -o out.html {GRADE} --no-validate --compare UNIT",
    f"compare UNIT {GRADE} {FEW} --max-trials 1000",
    f"compare UNIT zhao-2019 {GRADE} --method gum --validate --pairs",
    f"compare UNIT {GRADE} --mission bench --method gum",
    (
        f"compare UNIT {GRADE} --method gum --procedure zhao-2019 --procedure "
        "zhao-2019-eq4 -o out.html -o out.pdf --json out.json --csv out.csv"
    ),
    f"allocate UNIT {GRADE} --no-validate --strategy proportional",
    f"allocate UNIT {GRADE} --strategy cost --write out.yaml",
    f"station UNIT {GRADE}",
    "export UNIT --to kalibr",
    "export UNIT --to psins --residual",
    "check --save out.json UNIT",
    f"check UNIT --save out.json --kind compare {GRADE} --method gum",
    f"check UNIT --save out.json --kind allocate {GRADE}",
    "diff zhao-2019 UNIT",
    "diff UNIT UNIT",
)
# To these, in turn, what has a line or what has an axis; files of another shape, which
# reading tells apart, to the others.
DEAR = ("report", "allocate", "mission", "station", "diff zhao", "analyze UNIT --m")
ANSWERED = (0, 1, 2)  # met, not met, refused in words
UNSAID = re.compile(
    r"\bnan\b|\bNaN\b|Traceback|(?<![\d.])0 % of the variance|spread of the variance"
)


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
    for name, text in {**UNITS, **SHAPES, "soon": LIMIT}.items():
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_answers_where_little_is_given(command, folder):
    """No failure of the program, no nan, no source of 0 % of the variance."""
    units = ["nothing", "zeros", ("line", "axis")[COMMANDS.index(command) % 2]]
    for name in units if command.startswith(DEAR) else (*UNITS, *SHAPES):
        words = command.replace("UNIT", f"{name}.yaml").split()

        outcome = call(*(word.replace("_s", " s") for word in words))

        page = folder / "out.html"
        shown = page.read_text(encoding="utf-8") if page.exists() else ""
        shown = re.sub(r"<(script|style)[^>]*>.*?</\1>", "", shown, flags=re.DOTALL)
        assert outcome.code in ANSWERED, (name, outcome.err)
        assert outcome.code < 2 or outcome.err.strip(), name
        assert not UNSAID.search(outcome.out + outcome.err + shown), name


def test_a_mission_without_an_error_blames_no_line():
    """Where no line moves the position that is said, and no source or rate is named."""
    soon = ("--mission", "bench", "--at", "1e-4 s", "--only", "gyro.bias_stability")

    outcome = call("mission", *soon, code=0)

    said = " ".join(outcome.out.split())
    assert "no specification moves the horizontal position by more than" in said
    assert "share of the variance" not in outcome.out


@pytest.mark.parametrize("method", ["gum", "monte-carlo"])
@pytest.mark.usefixtures("folder")
def test_a_sensor_without_lines_is_undecidable_without_a_figure(method):
    """It is in no ranking; its entry has a verdict, what is missing and no number."""
    how = ("--requirement", "tactical-grade", "--method", method)
    run = call("compare", "base.yaml", "both.yaml", *how, "--json", "-", code=1)
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
    run = call("compare", "empty.yaml", *how, code=1)
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
    one = SHAPES["base"].replace(
        "gyro: {}", "gyro: {errors: {bias_repeatability: 9 deg/h}}"
    )
    (folder / "base.yaml").write_text(one, encoding="utf-8")
    assert call("check", "ref.json").code == 1
