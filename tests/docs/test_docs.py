"""Examples in docs/ run as printed and say what they say."""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from command_line import call
from numpy.testing import assert_allclose
from places import DOCS, ROOT
from reference_examples import computing_once

from budget.model.sources import SOURCES
from budget.studies.export.template import targets

PROBLEMS = re.findall(
    r"```python\n(.*?)```",
    (DOCS / "problems.md").read_text(encoding="utf-8"),
    re.DOTALL,
)


def run(code):
    """Run a block of docs/problems.md; return its names."""
    names: dict[str, object] = {}
    exec(compile(code, "problems.md", "exec"), names)  # noqa: S102 - our own text
    return names


def test_the_problem_of_ones_own_runs_as_printed(capsys):
    """The example of docs/problems.md gives Table H.4 of JCGM 100:2008."""
    names = run(PROBLEMS[0])

    first = capsys.readouterr().out.splitlines()[0]
    u = [float(number) for number in first.strip("[]").split()]
    assert_allclose(u, [0.071, 0.2956, 0.236], rtol=0, atol=1e-3)
    assert_allclose(names["law"].standard_uncertainty, u, rtol=1e-6)


def test_the_example_of_shapes_runs_as_printed(capsys):
    """Law and Monte Carlo of docs/problems.md's four shapes agree on the mean."""
    names = run(PROBLEMS[1])
    law, trials = names["law"], names["trials"]

    assert len(capsys.readouterr().out.splitlines()) == 2
    error = law.mean - trials.mean
    # x1 x2^2 has E = 10.025 (4 + 1) = 50.1, exactly what the law says.
    assert_allclose(law.mean, [10.025 * 5.0], rtol=1e-12)
    assert abs(error[0]) < 5.0 * trials.standard_uncertainty[0] / 1e3


def test_the_example_of_a_copula_runs_as_printed(capsys):
    """The correlation that is drawn is the one given."""
    run(PROBLEMS[2])

    # Of the product of both, in units of u, the variance is below 3.
    assert abs(float(capsys.readouterr().out) + 0.5) < 5.0 * np.sqrt(3.0 / 200_000)


def test_the_example_of_regions_runs_as_printed():
    """The ellipse of trials is the law's, but for the bend of an arc of 0.02 rad."""
    names = run(PROBLEMS[3])
    law, ellipse = names["law"], names["ellipse"]

    assert_allclose(ellipse.factor, np.sqrt(5.991), rtol=0.01)
    assert_allclose(ellipse.covariance, law.covariance, rtol=0.02)
    assert ellipse.contains(law.mean[:, None]).all()


def test_the_example_of_decision_rules_runs_as_printed():
    """Of JCGM 106's bearings 4.2 % do not conform, 0.8 % of all are accepted so."""
    names = run(PROBLEMS[4])

    assert_allclose(1.0 - names["simple"].conforming, 0.042, rtol=0, atol=0.001)
    assert_allclose(names["simple"].consumer, 0.008, rtol=0, atol=0.001)
    assert_allclose(names["acceptance"][1], 1.67, rtol=0, atol=0.01)
    assert names["one"].is_accepted


@pytest.mark.slow
@pytest.mark.usefixtures("drawn_once")
def test_the_library_example_runs_as_printed(capsys, tmp_path, monkeypatch):
    """The Python of docs/results.md runs on and gives a verdict for each sensor."""
    text = (DOCS / "results.md").read_text(encoding="utf-8")
    code = "\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL))
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "results.md", "exec"), {})  # noqa: S102 - our own text

    out = capsys.readouterr().out
    assert "gyro.bias_repeatability" in out
    assert "('gyro', 'fails'" in out
    assert "('accelerometer', 'fails'" in out
    assert "Zhao 2019 optical IMU, changed" in out
    assert {path.name for path in tmp_path.iterdir()} == {"bias.png", "report.html"}


# ---- docs/references.md --------------------------------------------------------------

PAGE = (DOCS / "references.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    """Return the fenced blocks of one language."""
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```$", PAGE)


def say(line):
    """Run one `budget` line in this process."""
    words = shlex.split(line.removeprefix("$ "))
    assert words[0] == "budget"
    return call(*words[1:])


computed_once = pytest.fixture(scope="module")(computing_once)
SHIPPED_HOLD = "$ budget check"


def make_folder(line):
    """Run the line that makes the folder of the references."""
    assert line == "$ mkdir references"
    Path("references").mkdir()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide the README's device, in a folder as a user keeps it, and work there."""
    (device,) = re.findall(r"(?ms)^```yaml\n(.*?)^```$", README)
    (tmp_path / "imu.yaml").write_text(device, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.usefixtures("computed_once")
def test_console_examples_run(folder):
    """Every line of the page is exit code 0, in the order of the page."""
    first, *lines = [line for block in blocks("console") for line in block.splitlines()]
    refused = say(lines[0])
    assert (refused.code, "folder" in refused.err) == (2, True), refused.err
    make_folder(first)
    assert len(lines) >= 5
    # That the shipped references hold is a test of `check`.
    assert SHIPPED_HOLD in lines
    for line in lines:
        if line != SHIPPED_HOLD:
            outcome = say(line)
            assert outcome.code == 0, (line, outcome.err)
    assert (folder / "references" / "imu.json").is_file()


@pytest.mark.slow
@pytest.mark.usefixtures("computed_once")
def test_the_job_does_what_the_page_says(folder):
    """Its last step passes; after the edit of the page it fails and says why."""
    (job,) = blocks("yaml")
    steps = yaml.safe_load(job)["jobs"]["budgets"]["steps"]
    check = steps[-1]["run"]
    assert steps[0]["with"] == {"submodules": True}
    assert steps[-2]["run"] == "pip install ./tools/sins-budget"
    assert "`tools/sins-budget`, a submodule" in PAGE
    folder_line, first, *_ = blocks("console")[0].splitlines()
    make_folder(folder_line)
    assert say(first).code == 0
    assert say(check).code == 0

    edit, again = blocks("sh")[0].splitlines()
    before = (folder / "imu.yaml").read_text(encoding="utf-8").splitlines()
    subprocess.run(shlex.split(edit), cwd=folder, check=True)
    after = (folder / "imu.yaml").read_text(encoding="utf-8").splitlines()
    (changed,) = (b for a, b in zip(before, after, strict=True) if a != b)
    assert changed.strip().startswith("bias_stability: {value: 0.0101 deg/h")
    assert again == check
    outcome = say(again)
    assert outcome.code == 1
    (said,) = blocks("text")
    assert said in outcome.out


def test_the_page_names_what_ships():
    """Every shipped reference is named, alone or as one of the paper's."""
    for path in (ROOT / "specs" / "references").glob("*.json"):
        kind = re.match("compare|allocate|zhao-2019", path.stem)
        assert kind or f"`{path.stem}`" in PAGE
    assert (DOCS / "make_references.py").is_file()


# ---- pages that are made, and the site -----------------------------------------------

TABLES = runpy.run_path(str(DOCS / "make_tables.py"))
CAPABILITIES = (DOCS / "capabilities.md").read_text(encoding="utf-8")
TUTORIAL = (DOCS / "tutorial.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "row"),
    [
        ("datasheets.md", "| [`bias_stability`](#bias-stability) |"),
        ("export.md", "`gyroscope_noise_density` [rad/s/sqrt(Hz)]"),
        ("library.md", "| `budget.analyze` | Compute the error budget"),
        ("documents.md", "| `contributions` | list of [contribution](#contribution) |"),
        ("commands.md", "| `--exit-code` | `analyze`, `mission` |"),
        ("keys.md", "| `sample_rate` | in Hz | `100 Hz` | of the sensor outputs |"),
    ],
)
def test_a_table_is_made_of_what_the_package_has(name, row):
    """Words, targets, public names and keys of documents are those of today."""
    page = (DOCS / name).read_text(encoding="utf-8")
    assert TABLES["page"](name) == page
    assert row in page
    assert set(TABLES["TABLES"]) == {"datasheets.md", *MADE}


MADE = ("export.md", "library.md", "documents.md", "commands.md", "keys.md")


def test_every_capability_names_its_oracle_and_the_test():
    """Each row has both, each test is there; no line, figure or target is left out."""
    rows = [
        [cell.strip() for cell in line.strip("|").split(" | ")]
        for line in CAPABILITIES.splitlines()
        if line.startswith("| ") and not line.startswith(("| capability", "| line"))
    ]
    named = set()
    for what, oracle, *tests in (row for row in rows if "validated by" not in row):
        found = re.findall(r"`(tests/[\w/]+\.py)`", *tests)
        assert oracle, what
        assert found, what
        assert [path for path in found if not (ROOT / path).is_file()] == []
        named |= set(re.findall("`([^`]+)`", what))
    assert {source.name for source in SOURCES} <= named
    assert set(targets()) <= named


def test_the_index_leads_to_every_page():
    """No page is outside the site's tree, and none is in it that is not there."""
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    linked = re.findall(r"^- \[.+\]\((.+\.md)\)$", index, re.MULTILINE)
    pages = {path.name for path in DOCS.glob("*.md")}
    assert sorted(linked) == sorted(pages - {"index.md"})


def test_links_between_pages_lead_somewhere():
    """Of every page: files, folders up too, are there."""
    for page in DOCS.glob("*.md"):
        links = re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text("utf-8"))
        assert [link for link in links if not (DOCS / link).exists()] == [], page.name


@pytest.mark.slow
@pytest.mark.usefixtures("computed_once")
def test_the_tutorial_runs_to_the_letter(tmp_path, monkeypatch):
    """Each command does what is shown of it; the report's own tests write the pages."""
    monkeypatch.chdir(tmp_path)
    (limits,) = re.findall(r"(?ms)^```yaml\n(.*?)^```$", TUTORIAL)
    Path("requirement.yaml").write_text(limits, encoding="utf-8")
    assert runs_to_the_letter(TUTORIAL) >= 6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["verdicts.md", "aided.md"])
def test_worked_sheets_run_to_the_letter(name, tmp_path, monkeypatch):
    """Each file under its name, each command with what is shown of it."""
    monkeypatch.chdir(tmp_path)
    page = (DOCS / name).read_text("utf-8")
    for file, text in re.findall(r"(?ms)^```yaml\n# (\S+)\n(.*?)^```$", page):
        Path(file).write_text(text, encoding="utf-8")
    assert runs_to_the_letter(page) >= 5


def runs_to_the_letter(page):
    """Run the commands of a page, with what is shown of each; how many are shown."""
    shown = re.findall(r"(?ms)^```(console|text)\n(.*?)^```$", page)
    said = ""
    for kind, text in shown:
        if kind == "text":
            assert [one for one in text.splitlines() if squeeze(one) not in said] == []
            continue
        for line in text.replace("\\\n", "").splitlines():
            if line.startswith("$ budget report"):
                continue
            outcome = say(line)
            assert outcome.code == 0, (line, outcome.err)
            said = squeeze(outcome.out + outcome.err)
    return [kind for kind, _ in shown].count("text")


def squeeze(text):
    """Return a text with one space in the place of each run of them."""
    return " ".join(text.split())


@pytest.mark.slow
def test_the_gallery_is_what_would_be_drawn_now(tmp_path):
    """The page, and the titles and labels of every figure."""
    script = runpy.run_path(str(DOCS / "make_gallery.py"))
    script["draw"](tmp_path)
    page = (tmp_path / "gallery.md").read_text(encoding="utf-8")
    assert page == (DOCS / "gallery.md").read_text(encoding="utf-8")

    def texts(path):
        return re.findall(r">([^<>\n]+)</t", path.read_text(encoding="utf-8"))

    drawn = sorted((tmp_path / "gallery").iterdir())
    assert [path.stem for path in drawn] == sorted(
        script["FIGURES"] | script["OF_MISSION"]
    )
    for path in drawn:
        assert texts(path) == texts(DOCS / "gallery" / path.name), path.stem
