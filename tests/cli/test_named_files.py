"""Files that a file names: of one elsewhere nothing is shown."""

from __future__ import annotations

import re
import shutil

import pytest
from command_line import call
from places import ROOT, put

SECRETS = {
    "passwords": "root:s3cret:0:0:root:/root:/bin/bash\nuser:s3cret:1:1::/:/bin/sh\n",
    "a key": "-----BEGIN s3cret KEY-----\ns3cret\ns3cret\n",
    "settings": "[s3cret]\ns3cret = s3cret, 's3cret'\ns3cret,\n",
    "a table": "time [s],s3cret [s3cret]\n" + "1,s3cret\n" * 9,
    "numbers": "time [s],latitude [deg],longitude [deg],height [m]\n"
    + "s3cret,1,1,1\n" * 9,
    "YAML": "station: {s3cret: s3cret, rate_error: s3cret}\ns3cret: [1]\n",
    "JSON": '{"s3cret": "s3cret"}',
    "a tag": "!!python/name:s3cret s3cret\n",
}
FILES = {
    "mission": "mission: {{trajectory: '{path}', alignment: perfect}}\n",
    "procedure": "station: '{path}'\ngyro: {{turns: 2}}\n",
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the folder of the file that names another one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own" / "below").mkdir(parents=True)
    return tmp_path / "own"


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("way", ["up", "whole", "link"])
@pytest.mark.parametrize("secret", SECRETS)
def test_nothing_of_a_file_elsewhere_is_shown(folder, kind, way, secret):
    """One line at the name, with the place in the other file; a control beside it."""
    elsewhere = put(folder.parent / "elsewhere.txt", SECRETS[secret])
    (folder / "link.txt").symlink_to(elsewhere)
    path = {"up": "../elsewhere.txt", "whole": elsewhere, "link": "link.txt"}[way]
    named = put(folder / f"{kind}.yaml", FILES[kind].format(path=path))
    run = call("validate", named, code=2)
    assert "s3cret" not in run.out + run.err
    (line,) = run.err.splitlines()
    assert line.startswith(f"{named}:1:")
    assert re.search(r"line \d+, column \d+", line)


@pytest.mark.parametrize(
    ("kind", "secret"),
    [("mission", "a table"), ("mission", "numbers"), ("procedure", "YAML")],
)
def test_a_file_of_ones_own_is_told_of_in_full(folder, kind, secret):
    """The control: in the folder or below it what was found helps to mend it."""
    (folder / "below" / "x.txt").write_text(SECRETS[secret], encoding="utf-8")
    named = put(folder / f"{kind}.yaml", FILES[kind].format(path="below/x.txt"))
    run = call("validate", named, code=2)
    assert "x.txt:" in run.err
    assert "s3cret" in run.err


def test_a_recording_elsewhere_is_read(folder):
    """A file that is sound may lie anywhere."""
    shutil.copy(ROOT / "tests" / "data" / "flight.csv", folder.parent)
    named = folder / "mission.yaml"
    text = "{trajectory: ../flight.csv, alignment: perfect, altitude: aided}"
    named.write_text(f"mission: {text}\n", encoding="utf-8")
    call("validate", named, code=0)
