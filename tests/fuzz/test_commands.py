"""Hostile files given to every command that reads one: an error, never a traceback."""

from __future__ import annotations

import re

import pytest
from command_line import call

HOSTILE = {
    "empty": b"",
    "no text": b"\x00\xff\xfe\x80",
    "UTF-16": "name: x\ngyro: {}\n".encode("utf-16"),
    "an open bracket": b"gyro: [",
    "an alias": b"a: &a [1]\nb: *a\n",
    "a tag": b"gyro: !!python/object/apply:os.system [true]\n",
    "deep": b"{a: " * 5_000,
    "too large": b"#" * 100_000,
    "an escape of no character": b'name: "\\UFFFFFFFF"\n',
    "a list": b"- 1\n",
    "a number": b"1e400\n",
    "words in brackets": b"'[bold]{x}[/bold] %s \\N': 1\n",
    "wrong everywhere": b"gyro: 1\nlimits: 3\ncosts: 4\nlatitude: 5\n",
}
PLACE = re.compile(r"^bad\.yaml(#A)?:[1-9]\d*:[1-9]\d*: ", re.MULTILINE)

FILE = re.compile(r"^bad\.yaml\b", re.MULTILINE)

# Every command with a place for a file; FILE is where the hostile one goes.
COMMANDS = (
    "validate FILE",
    "devices FILE",
    "analyze FILE",
    "analyze FILE#A",
    "analyze --procedure FILE",
    "compare FILE --requirement navigation-grade",
    "compare zhao-2019 FILE --requirement navigation-grade --strict",
    "compare zhao-2019 --requirement FILE",
    "compare zhao-2019 --requirement navigation-grade --procedure FILE",
    "allocate FILE --requirement navigation-grade",
    "allocate --requirement FILE",
    "allocate --requirement navigation-grade --costs FILE",
    "allocate --requirement navigation-grade --procedure FILE",
    "station FILE --requirement navigation-grade",
    "station --requirement FILE",
    "station --requirement navigation-grade --procedure FILE",
    "station --requirement navigation-grade --station FILE",
    "mission FILE --mission bench",
    "mission --mission FILE",
    "mission --mission bench --requirement FILE",
    "mission --mission bench --calibration FILE",
    "report --mission FILE -o out.html",
    "report FILE -o out.html",
    "report --requirement FILE -o out.html",
    "report --procedure FILE -o out.html",
)


# A reference budget is JSON that the tool wrote: there is no place in it for a person.
# `check` counts what cannot be checked on stdout.
REFERENCES = ("check FILE", "diff FILE FILE")


@pytest.mark.parametrize("command", COMMANDS + REFERENCES)
def test_every_command_refuses_a_hostile_file_in_words(command, tmp_path, monkeypatch):
    """Exit code 2, the place in the file on stderr, nothing on stdout or on disk."""
    monkeypatch.chdir(tmp_path)
    told = FILE if command in REFERENCES else PLACE
    for name, data in HOSTILE.items():
        (tmp_path / "bad.yaml").write_bytes(data)
        run = call(*command.replace("FILE", "bad.yaml").split(), code=2)
        assert told.search(run.err), (name, run.err)
        assert "Traceback" not in run.err, name
        assert run.out == "" or command == "check FILE", (name, run.out)
        assert [path.name for path in tmp_path.iterdir()] == ["bad.yaml"], name
