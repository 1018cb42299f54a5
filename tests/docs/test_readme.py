"""The README: every command in it runs, and every number in it is the tool's."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from runpy import run_path
from shutil import copy

import pytest
from builders import last_digit
from command_line import analyze, call, output
from numpy.testing import assert_allclose
from places import ROOT

import budget
from budget.report.tables import group_tables

pytestmark = pytest.mark.usefixtures("drawn_once")

EXAMPLE = ROOT / "docs" / "example"
README, CHINESE, COMMANDS = (
    (ROOT / name).read_text(encoding="utf-8")
    for name in ("README.md", "README.zh.md", "docs/commands.md")
)


def blocks(language, *, page=README):
    """Return the fenced blocks of one language, in their order."""
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```$", page)


def commands():
    """Return the names of the commands that there are."""
    listing = call("--help").out.partition("Commands:")[2]
    return {line.split()[0] for line in listing.splitlines() if line[:3].strip()}


CONSOLE = [
    line.removeprefix("$ budget ")
    for page in (README, COMMANDS)
    for block in blocks("console", page=page)
    for line in block.splitlines()
]
# Of this the pages are compared with the committed ones, below.
EXAMPLE_REPORT = (
    "report --requirement docs/example/requirement.yaml --sobol --allocate"
    " -o report.html -o report.pdf"
)
ELSEWHERE = {EXAMPLE_REPORT}
FIGURES = ("share-gyro-bias", "which-imu")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with the README's device file in it, and work there."""
    (device,) = blocks("yaml")
    (tmp_path / "imu.yaml").write_text(device, encoding="utf-8")
    example = tmp_path / "docs" / "example"
    example.mkdir(parents=True)
    copy(EXAMPLE / "requirement.yaml", example)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_two_commands_come_first():
    """The first two sh blocks are one line each: the report, then the tests."""
    report, tests = blocks("sh")[:2]

    for command in (report, tests):
        assert command.count("\n") == 1
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install ")
    assert report.endswith("&& .venv/bin/budget report -o report.html\n")
    assert "'.[test]'" in tests
    assert "&& .venv/bin/pytest" in tests


def test_what_the_tests_leave_out_is_run_elsewhere():
    """The README's command runs all but the slow tests, .ci/run those too."""
    _, tests = blocks("sh")[:2]
    assert tests.endswith(" -m 'not slow'\n")
    runs = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    (slow,) = (line for line in runs if line.startswith(".venv/bin/pytest "))
    assert " -m slow | tee " in slow


@pytest.mark.kernels
def test_the_first_table_is_the_tools():
    """Names, units, digits and contributions are the tool's, to the letter."""
    result = budget.analyze(budget.load_device("zhao-2019"), validate=False)
    table = re.findall(r"(?m)^\| ((?:gyro|accelerometer) .*) \|$", README)

    assert [
        f"{group.title} | {group.widest.u.text} {group.unit}"
        f" | {group.widest.expanded.text} {group.unit} | {group.contributions}"
        for group in group_tables(result)
    ] == table
    printed = call("analyze", "--no-validate", "--full", COLUMNS="200").out
    for row in table:
        for part in row.replace(" deg/h", "").replace(" arcsec", "").split(" | "):
            assert re.sub(" (ppm|ug)$", "", part) in printed


@pytest.mark.kernels
def test_the_printed_block_is_the_terminals():
    """The text block stands in what `budget analyze` prints, to the letter."""
    (block,) = blocks("text")

    assert block in call("analyze", "--no-validate", "--full").out


@pytest.mark.slow
def test_the_figures_and_the_page_of_schemes_are_the_tools(tmp_path, monkeypatch):
    """Titles and labels of the committed figures are those that would be drawn now."""
    script = ROOT / "docs" / "make_figures.py"
    monkeypatch.setattr(sys, "argv", [str(script), str(tmp_path)])
    run_path(str(script), run_name="__main__")

    def texts(path):
        return re.findall(r">([^<>\n]+)</t", path.read_text(encoding="utf-8"))

    share, which = (tmp_path / f"{name}.svg" for name in FIGURES)
    assert "79 %" in texts(share)
    assert texts(which).count("meets") == 2
    (said,) = re.findall(r"!\[([^\]]+)\]\(docs/which-imu\.svg\)", README)
    for name in ("Zhao 2019 optical IMU", "HG4930 (C)", "29.9", "82.6"):
        assert name in said
        assert name in texts(which)
    for path in (share, which):
        assert f"](docs/{path.name})" in README
    drawn = sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*.svg"))
    shipped = {path.stem for path in (ROOT / "specs" / "procedures").glob("*.yaml")}
    assert {path.stem for path in drawn} == shipped | {
        *FIGURES,
        "measured-mpu-9150",
        "straight",
        "turning",
    }
    for path in drawn:
        assert texts(ROOT / "docs" / path) == texts(tmp_path / path) != []
    kept, made = (folder / "schemes.md" for folder in (ROOT / "docs", tmp_path))
    assert kept.read_text(encoding="utf-8") == made.read_text(encoding="utf-8")


@pytest.mark.slow
@pytest.mark.kernels
def test_the_example_report_is_the_tools(tmp_path, monkeypatch):
    """Verdict, headings and every number of the committed page are those of today."""
    script = ROOT / "docs" / "make_example.py"
    start, said = subprocess.run, []

    def run_here(words, *, check, env=None):
        """Call the command in this process, where the script starts one."""
        if words[1:3] != ["-m", "budget"]:
            return start(words, check=check)
        run = call(*words[3:], SOURCE_DATE_EPOCH=env["SOURCE_DATE_EPOCH"], code=0)
        said.append(run.err)
        assert check
        return run

    monkeypatch.setattr(subprocess, "run", run_here)
    monkeypatch.setattr(sys, "argv", [str(script), str(tmp_path)])
    run_path(str(script), run_name="__main__")
    assert EXAMPLE_REPORT in CONSOLE
    assert '"--sobol", "--allocate"' in script.read_text(encoding="utf-8")
    (err,) = said
    assert "report.pdf: written" in err
    made, kept = (
        (folder / "report.html").read_text(encoding="utf-8")
        for folder in (tmp_path, EXAMPLE)
    )

    def headings(page):
        return re.findall(r"<h[123][^>]*>(.*?)</h[123]>", page, flags=re.DOTALL)

    def numbers(page):
        pattern = r'id="report-json">(.*?)</script>'
        (document,) = re.findall(pattern, page, flags=re.DOTALL)
        budget_of_page = json.loads(document)
        return [
            [row["mean"], row["standard_uncertainty"], *row["interval"]]
            for row in budget_of_page["outputs"]
        ]

    assert headings(made) == headings(kept)
    assert_allclose(numbers(made), numbers(kept), rtol=1e-9, atol=1e-12)
    assert (EXAMPLE / "report.pdf").read_bytes().startswith(b"%PDF-")
    for name in ("report.html", "report.pdf", "page-one.png"):
        assert f"docs/example/{name}" in README


@pytest.mark.slow
@pytest.mark.parametrize("line", [line for line in CONSOLE if line not in ELSEWHERE])
def test_examples_run(folder, line):
    """Each example of the README and of commands.md is exit 0 beside its device."""
    run = call(*shlex.split(line), code=0)

    assert run.out or list(folder.glob("*.html"))


def test_the_example_device_gives_every_expected_line(folder):
    """A user who fills in the README's file can get a verdict: nothing is missing."""
    device = budget.load_device(folder / "imu.yaml")

    assert [sensor.expected_missing for sensor in device.sensors] == [(), ()]


@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_numbers_of_the_references(reference):
    """The number beside each reference is the tool's, to its last digit."""
    (printed,) = re.findall(rf"(?m)^- `{reference}`.*?\*\*([0-9.]+)\*\*", README)

    u = output(analyze("--reference", reference), "gyro.bias.x")
    assert_allclose(
        u["standard_uncertainty"], float(printed), rtol=0, atol=last_digit(printed) / 2
    )


def test_commands_are_those_that_there_are():
    """The tables of commands name all there are, and no others."""
    for page in (README, CHINESE):
        assert set(re.findall(r"(?m)^\| `budget (\w+)", page)) == commands()
    table, _, _ = COMMANDS.partition("\n## ")
    assert set(re.findall(r"(?m)^\| `(\w+)`", table)) == commands()


def test_links_lead_somewhere():
    """Every file that the README links to is in the checkout."""
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).is_file(), target


def test_changelog_names_this_version():
    """The changelog has a heading for the version of the package."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

    assert re.search(rf"(?m)^## {re.escape(budget.__version__)}\b", text)
