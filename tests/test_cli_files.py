"""`budget validate`, `budget schema` and `budget report`: files in, files out."""

from __future__ import annotations

import json
import re

import pytest
from command_line import call, start
from jsonschema import Draft202012Validator
from ruamel.yaml import YAML

from budget.resources import shipped

REQUIREMENT = shipped("specs") / "requirements" / "navigation-grade.yaml"
SHIPPED = sorted(shipped("specs").glob("*/*.yaml"))
FOLDERS = {
    "devices": "device",
    "procedures": "procedure",
    "requirements": "requirement",
}
KINDS = ("device", "procedure", "requirement", "costs")
GYRO = "name: g\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_shipped_files_are_valid(path):
    """Every file that ships is valid, and of the kind of its folder."""
    run = call("validate", path)

    kind = FOLDERS[path.parent.name]
    assert (run.code, run.err) == (0, "")
    assert run.out.startswith(f"{path}: {kind}, valid\n")


def test_assumptions_are_printed(tmp_path):
    """A default that was taken for a figure is said: a correlation time of 300 s."""
    file = tmp_path / "g.yaml"
    file.write_text("name: g\ngyro: {errors: {bias_stability: 1 deg/h}}\n")
    run = call("validate", file)

    assert run.code == 0
    assert re.search(r"assumed: .*bias_stability.*300 s", run.out)


def test_faults_are_printed_with_their_places(tmp_path):
    """All faults of a file are said at once, each as file:line:column: field: ..."""
    file = tmp_path / "bad.yaml"
    file.write_text(
        "name: bad\n"
        "gyro:\n"
        "  errors:\n"
        "    bias_stabilty: 0.04 deg/h\n"
        "    bias_repeatability: 0.05\n"
        "    angle_random_walk: 0.005 deg/h\n",
        encoding="utf-8",
    )
    run = call("validate", file)

    assert (run.code, run.out) == (2, "")
    lines = [re.match(rf"{file}:(\d+):\d+: ", text) for text in run.err.splitlines()]
    assert [int(line[1]) for line in lines] == [4, 5, 6]
    assert "bias_stability" in run.err.splitlines()[0]


def test_good_files_are_named_beside_bad_ones(tmp_path):
    """One bad file among good ones is exit 2; the good ones are still said valid."""
    bad = tmp_path / "bad.yaml"
    bad.write_text("name: bad\nwheels: 4\n", encoding="utf-8")
    run = call("validate", REQUIREMENT, bad)

    assert run.code == 2
    assert run.out == f"{REQUIREMENT}: requirement, valid\n"
    assert run.err.startswith(f"{bad}:")


def test_validate_needs_a_file():
    """`budget validate` without a file is a bad call."""
    assert call("validate").code == 2


@pytest.mark.parametrize("kind", KINDS)
def test_schema_is_a_json_schema(kind):
    """`budget schema KIND` prints a valid JSON Schema and nothing else."""
    run = call("schema", kind)

    assert (run.code, run.err) == (0, "")
    Draft202012Validator.check_schema(run.document)


def test_schema_of_an_unknown_kind():
    """A kind that there is not is exit 2 and says which there are."""
    run = call("schema", "sensor")

    assert (run.code, run.out) == (2, "")
    assert "requirement" in run.err


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.name)
def test_schema_agrees_with_the_reader(path):
    """A file that the reader takes is valid by the schema that editors use."""
    schema = call("schema", FOLDERS[path.parent.name]).document
    content = YAML(typ="safe", pure=True).load(path)

    assert list(Draft202012Validator(schema).iter_errors(content)) == []


def test_schema_refuses_a_misspelt_line():
    """By the schema of a device, a line that there is not is a fault."""
    schema = call("schema", "device").document
    content = {"name": "g", "gyro": {"errors": {"bias_stabilty": "1 deg/h"}}}

    assert list(Draft202012Validator(schema).iter_errors(content)) != []


@pytest.mark.smoke
def test_report_is_written(tmp_path):
    """`budget report -o x.html` writes one whole page; nothing goes to stdout."""
    run = start("report", "--no-validate", "-o", "x.html", cwd=tmp_path)

    assert (run.code, run.out) == (0, "")
    assert "x.html: written" in run.err
    assert [path.name for path in tmp_path.iterdir()] == ["x.html"]
    page = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert page.lower().startswith("<!doctype html>")
    assert page.rstrip().endswith("</html>")
    assert "Zhao 2019 optical IMU" in page


def test_report_of_the_same_day_is_the_same(tmp_path):
    """With SOURCE_DATE_EPOCH the bytes are the same and the date is that one."""
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        run = start(
            *("report", "--no-validate", "-o", f"{name}.html"),
            cwd=folder,
            SOURCE_DATE_EPOCH="86400",
        )
        assert run.code == 0, run.err

    one, two = ((tmp_path / n / f"{n}.html").read_bytes() for n in ("a", "b"))
    assert one == two
    assert b"1970-01-02" in one


def test_report_needs_an_output():
    """Without -o there is nothing to write: exit 2."""
    run = call("report", "--no-validate")

    assert run.code == 2
    assert "-o" in run.err


def test_report_of_an_unknown_kind(tmp_path):
    """`-o x.txt` is exit 2, even beside a good one, and nothing is written."""
    run = call(
        *("report", "--no-validate"),
        *("-o", tmp_path / "x.html", "-o", tmp_path / "x.txt"),
    )

    assert (run.code, run.out) == (2, "")
    assert "x.txt" in run.err
    assert ".html" in run.err
    assert list(tmp_path.iterdir()) == []


def test_report_against_a_requirement(tmp_path):
    """A failed requirement is said in the page; the exit code stays 0."""
    page = tmp_path / "x.html"
    run = call("report", "--no-validate", "--requirement", REQUIREMENT, "-o", page)

    assert run.code == 0, run.err
    text = page.read_text(encoding="utf-8")
    assert "navigation grade" in text
    assert re.search("fails", text, flags=re.IGNORECASE)
    assert "next_turn_on" in text


def test_requirement_agrees_with_the_same_options(tmp_path):
    """Saying what the requirement says is no conflict."""
    page = tmp_path / "x.html"
    run = call(
        *("report", "--no-validate", "--requirement", REQUIREMENT, "-o", page),
        *("--coverage", "95 %", "--reference", "next_turn_on"),
    )

    assert run.code == 0, run.err


@pytest.mark.parametrize(
    ("option", "value"), [("--coverage", "0.9"), ("--reference", "nominal")]
)
def test_requirement_beside_another_option(tmp_path, option, value):
    """Another coverage or reference than the requirement's is exit 2, nothing done."""
    page = tmp_path / "x.html"
    run = call(
        *("report", "--no-validate", "--requirement", REQUIREMENT, "-o", page),
        *(option, value),
    )

    assert (run.code, run.out) == (2, "")
    assert option in run.err
    assert value in run.err
    assert not page.exists()


def test_requirement_without_a_limit_for_what_is_there(tmp_path):
    """Limits for an accelerometer alone cannot judge a gyro: exit 2."""
    device, requirement = tmp_path / "g.yaml", tmp_path / "r.yaml"
    device.write_text(GYRO, encoding="utf-8")
    requirement.write_text(
        "name: r\nlimits: {accelerometer: {bias: 80 ug}}\n", encoding="utf-8"
    )
    page = tmp_path / "x.html"
    run = call(
        *("report", device, "--no-validate", "--requirement", requirement, "-o", page)
    )

    assert (run.code, run.out) == (2, "")
    assert not page.exists()


def test_report_carries_the_exact_numbers(tmp_path):
    """The document that `analyze --json` prints stands whole in the page."""
    page = tmp_path / "x.html"
    assert call("report", "--no-validate", "-o", page).code == 0
    text = page.read_text(encoding="utf-8")
    (embedded,) = re.findall(
        r'<script type="application/json"[^>]*>(.*?)</script>', text, flags=re.DOTALL
    )

    of_page = json.loads(embedded)
    of_command = call("analyze", "--no-validate", "--json", "-").document
    assert of_page["outputs"] == of_command["outputs"]
    assert of_page["covariance"] == of_command["covariance"]
