"""Examples in docs/ run as printed and say what they say."""

from __future__ import annotations

import re
import runpy
import shlex
import subprocess
from pathlib import Path

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import DOCS, ROOT
from ruamel.yaml import YAML

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


def test_console_examples_run(folder):
    """Every line of the page is exit code 0, in the order of the page."""
    first, *lines = [line for block in blocks("console") for line in block.splitlines()]
    refused = say(lines[0])
    assert (refused.code, "folder" in refused.err) == (2, True), refused.err
    make_folder(first)
    assert len(lines) >= 5
    for line in lines:
        outcome = say(line)
        assert outcome.code == 0, (line, outcome.err)
    assert (folder / "references" / "imu.json").is_file()


def test_the_job_does_what_the_page_says(folder):
    """Its last step passes; after the edit of the page it fails and says why."""
    (job,) = blocks("yaml")
    steps = YAML(typ="safe").load(job)["jobs"]["budgets"]["steps"]
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


def test_the_table_of_targets_is_the_one_of_the_data():
    """docs/export.md lists the keys, units and sources that exports are made from."""
    page = (DOCS / "export.md").read_text(encoding="utf-8")
    names = runpy.run_path(str(DOCS / "make_tables.py"))

    assert names["page"]("export.md") == page
    assert "`gyroscope_noise_density` [rad/s/sqrt(Hz)]" in page
