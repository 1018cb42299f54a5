"""Fuzz the reader of files and the unit grammar, led by the code they reach.

    pip install atheris
    python tests/fuzz/reader.py -max_total_time=600 FOLDER

FOLDER keeps the inputs that reach new code; other options are those of libFuzzer. The
shipped files and everything in `found/` are the seeds. An input that breaks the
reader ends the run and is written to the current folder as `crash-...`: put it into
`found/`, where `tests/fuzz/test_files.py` replays it for ever, and mend the reader.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

HERE = Path(__file__).parent
CHECKOUT = HERE.parent.parent
sys.path[:0] = [str(CHECKOUT), str(HERE.parent)]

with atheris.instrument_imports(include=["budget"]):
    from fuzz.oracle import LIKES, LOADERS, UNITS, judge_input

    from budget.inputs import json_schema

FOUND = HERE / "found"
LONGEST = 1500  # bytes; longer files are the business of test_cost.py
# The one kind of which none ships.
COSTS = b"costs: {gyro.bias_stability: {a: 1, p: 2, u_ref: 0.04 deg/h}}\n"


def words_of(schema):
    """Yield the keys and the words that a JSON Schema knows."""
    if isinstance(schema, dict):
        for key in ("properties", "enum", "examples"):
            yield from schema.get(key, ())
        for part in schema.values():
            yield from words_of(part)
    elif isinstance(schema, list):
        for part in schema:
            yield from words_of(part)


def write_seeds(folder):
    """Write the seeds and a dictionary of words; return the path of that."""
    shipped = sorted((CHECKOUT / "specs").rglob("*.yaml"))
    found = sorted(FOUND.iterdir())
    for number, path in enumerate([*shipped, *found]):
        (folder / f"seed-{number}").write_bytes(path.read_bytes())
    (folder / "costs").write_bytes(COSTS)
    for number, like in enumerate(LIKES):
        (folder / f"unit-{number}").write_bytes(UNITS + f"1.5e-3 {like}".encode())
    words = {str(word) for kind in LOADERS for word in words_of(json_schema(kind))}
    marks = {": ", "\n  ", "- ", "{", "}", "[", "]", "&a", "*a", "!!", "|", ">", "<<"}
    dictionary = folder.parent / "words.dict"
    escaped = (
        "".join(f"\\x{byte:02x}" for byte in word.encode()) for word in words | marks
    )
    dictionary.write_text("".join(f'"{word}"\n' for word in sorted(escaped)))
    return dictionary


def main():
    """Run until the time is over or an input breaks the reader."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "seeds").mkdir()
        dictionary = write_seeds(folder / "seeds")
        path = folder / "input.yaml"
        kinds = [(kind,) for kind in LOADERS]  # each parse costs, so one at a time

        def judge(data):
            judge_input(path, data, kinds[sum(data) % len(kinds)])

        options = [f"-dict={dictionary}", f"-max_len={LONGEST}", "-timeout=5"]
        arguments = [sys.argv[0], *options, *sys.argv[1:], str(folder / "seeds")]
        atheris.Setup(arguments, judge)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
