"""A reference from somebody else reads no file of mine and keeps no machine busy."""

from __future__ import annotations

import json
import os
from hashlib import sha256

import pytest
from command_line import call

from budget.inputs import reader
from budget.references.files import digest, take
from budget.references.store import _checksum
from budget.settings import MOST_TRIALS

DEVICE = "name: One\ngyro: {errors: {bias_repeatability: 0.1 deg/h}}\n"
PRIVATE = "mine: hunter2\n"


@pytest.fixture
def project(tmp_path, monkeypatch):
    """Provide a folder to work in, with a reference, and a secret outside of it."""
    project = tmp_path / "project"
    (project / "references").mkdir(parents=True)
    (project / "one.yaml").write_text(DEVICE, encoding="utf-8")
    (tmp_path / "secret.yaml").write_text(PRIVATE, encoding="utf-8")
    monkeypatch.chdir(project)
    assert call("check", "one.yaml", "--save", "references/one.json").code == 0
    return project


def forge(project, change):
    """Change the stored reference and put the right checksum on it."""
    path = project / "references" / "one.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    content.pop("checksum")
    content["checksum"] = _checksum(content)
    path.write_text(json.dumps(content), encoding="utf-8")


def naming(file):
    """Return a change that makes the device another file."""

    def change(content):
        content["inputs"][0]["file"] = file

    return change


@pytest.mark.usefixtures("project")
def test_an_input_in_the_folder_one_works_in_is_read():
    """The control: a path that leads up and stays in the tree."""
    assert call("check", "references/one.json").code == 0


def test_an_input_outside_the_tree_is_not_opened(project):
    """It is refused by name, and nothing of it stands in the message."""
    forge(project, naming("../../secret.yaml"))
    run = call("check", "references/one.json", code=2)
    assert "is outside" in run.err
    assert "--root FOLDER" in run.err
    assert "hunter2" not in run.err + run.out
    assert "mine:" not in run.err + run.out


def test_a_link_does_not_lead_out_of_the_tree(project):
    """What counts is the file behind it."""
    (project / "link.yaml").symlink_to("../secret.yaml")
    forge(project, naming("../link.yaml"))
    run = call("check", "references/one.json", code=2)
    assert "is outside" in run.err
    assert "mine:" not in run.err + run.out


def test_elsewhere_the_tree_is_the_folder_of_the_reference(project, monkeypatch):
    """From another folder a path that leads up needs --root."""
    other = project / "other"
    other.mkdir()
    monkeypatch.chdir(other)
    run = call("check", "../references/one.json", code=2)
    assert "is outside" in run.err
    assert call("check", "../references/one.json", "--root", "..").code == 0


def test_a_pipe_is_no_input(project):
    """Nothing waits for who would write into it."""
    os.mkfifo(project / "pipe.yaml")
    forge(project, naming("../pipe.yaml"))
    run = call("check", "references/one.json", code=2)
    assert "is not there" in run.err


@pytest.mark.parametrize("name", ["trials", "max_trials"])
def test_trials_beyond_the_command_line_are_refused(project, name):
    """In the reference as on the command line."""
    most = MOST_TRIALS

    def change(content):
        content["settings"] = {"method": "monte-carlo", name: most + 1}

    forge(project, change)
    run = call("check", "references/one.json", code=2)
    assert name in run.err
    option = f"--{name.replace('_', '-')}"
    asked = call("analyze", "--method", "monte-carlo", option, str(most + 1), code=2)
    assert str(most) in asked.err


@pytest.mark.usefixtures("project")
def test_a_file_is_read_once(monkeypatch):
    """The text that is stored is that whose hash is, though the file changes."""
    read = reader.read_bytes  # between reading and hashing

    def then_change(path, shown):
        data = read(path, shown)
        path.write_text(DEVICE.replace("0.1", "0.9"), encoding="utf-8")
        return data

    monkeypatch.setattr(reader, "read_bytes", then_change)
    one = take("device", "one.yaml")
    assert digest(one.text) == one.sha256 == sha256(DEVICE.encode()).hexdigest()
