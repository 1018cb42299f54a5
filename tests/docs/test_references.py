"""docs/references.md: its examples run as printed."""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest
from command_line import call
from places import DOCS, ROOT
from ruamel.yaml import YAML

PAGE = (DOCS / "references.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    """Return the fenced blocks of one language."""
    return re.findall(rf"(?ms)^```{language}\n(.*?)^```$", PAGE)


def run(line):
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
    refused = run(lines[0])
    assert (refused.code, "folder" in refused.err) == (2, True), refused.err
    make_folder(first)
    assert len(lines) >= 5
    for line in lines:
        outcome = run(line)
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
    assert run(first).code == 0
    assert run(check).code == 0

    edit, again = blocks("sh")[0].splitlines()
    before = (folder / "imu.yaml").read_text(encoding="utf-8").splitlines()
    subprocess.run(shlex.split(edit), cwd=folder, check=True)
    after = (folder / "imu.yaml").read_text(encoding="utf-8").splitlines()
    (changed,) = (b for a, b in zip(before, after, strict=True) if a != b)
    assert changed.strip().startswith("bias_stability: {value: 0.0101 deg/h")
    assert again == check
    outcome = run(again)
    assert outcome.code == 1
    (said,) = blocks("text")
    assert said in outcome.out


def test_the_page_names_what_ships():
    """Every shipped reference is named, alone or as one of the paper's."""
    for path in (ROOT / "specs" / "references").glob("*.json"):
        kind = re.match("compare|allocate|zhao-2019", path.stem)
        assert kind or f"`{path.stem}`" in PAGE
    assert (DOCS / "make_references.py").is_file()
