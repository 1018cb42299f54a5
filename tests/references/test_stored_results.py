"""References of units that were measured: the result is stored, and checked."""

from __future__ import annotations

import json

import pytest
from command_line import call
from places import put
from reading import assert_says

SIX = "six-positions-and-turns"
UNIT = """
name: unit
gyro:
  errors:
    angle_random_walk: 0.02 deg/sqrt(h)
    bias_repeatability: 0.05 deg/h
variants:
  B: {accelerometer: {errors: {velocity_random_walk: 30 ug/sqrt(Hz)}}}
"""
LIMITS = "name: limits\nlimits: {gyro: {bias: 1 deg/h}}\n"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Provide the results of two units, by their scatter and by their sheet."""
    found = tmp_path_factory.mktemp("results")
    put(found / "unit.yaml", UNIT)
    sheet, texts = str(found / "unit.yaml"), {}
    for variant in ("", "#B"):
        run, out = str(found / "run.csv"), found / "result.json"
        at = ("--procedure", SIX)
        made = ("simulate", f"{sheet}{variant}", *at, "--means", "--seed", "2")
        assert call(*made, "-o", run).code == 0
        device = ("--device", f"{sheet}{variant}")
        assert call("calibrate", run, *at, *device, "--json", str(out)).code == 0
        texts[variant] = out.read_text(encoding="utf-8")
    return texts


@pytest.fixture
def folder(tmp_path, monkeypatch, results):
    """Provide a sheet with a result of each of its variants, and work there."""
    put(tmp_path / "unit.yaml", UNIT)
    put(tmp_path / "limits.yaml", LIMITS)
    (tmp_path / "b").mkdir()
    put(tmp_path / "cal.json", results[""])
    put(tmp_path / "b" / "cal.json", results["#B"])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def save(device, *more, code=0):
    """Store a reference; return what the command did."""
    words = ("check", "--save", "ref.json", device, "--procedure", SIX)
    return call(*words, *more, code=code)


def rewrite(path, change):
    """Change a result on the disk."""
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    path.write_text(json.dumps(document), encoding="utf-8")


def doubled(document):
    """Make what a run left twice as large."""
    document["covariance"] = [[4.0 * x for x in row] for row in document["covariance"]]
    for row in document["outputs"]:
        row["standard_uncertainty"] *= 2.0


WAYS = {
    "analyze": ("unit.yaml", "cal.json", ()),
    "a variant": ("unit.yaml#B", "b/cal.json", ()),
    "mission": ("unit.yaml#B", "b/cal.json", ("--mission", "bench")),
    "compare": (
        "unit.yaml",
        "cal.json",
        (
            *("--measured", "b/cal.json", "--kind", "compare"),
            *("--requirement", "limits.yaml"),
        ),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_a_result_is_stored_and_what_it_moves_is_named(folder, way):
    """Unchanged, then each number that moved by the file alone."""
    device, file, more = WAYS[way]
    save(device, "--measured", file, *more)
    stored = json.loads((folder / "ref.json").read_text(encoding="utf-8"))["inputs"]
    assert ("result", file) in {(one["role"], one["file"]) for one in stored}
    assert call("check", "ref.json", code=0)
    rewrite(folder / file, doubled)
    run = call("check", "ref.json", "--json", "-", code=1)
    (found,) = run.document["references"]
    change = found["changes"][0]
    assert_says(change["where"], "result", "cal.json")
    assert_says(change["before"], "SHA-256")
    # The two variants of a comparison have results of one name.
    assert run.document["moved"]
    for one in run.document["moved"]:
        is_number = one["difference"] is not None
        assert len(one["causes"]) == is_number, one


@pytest.mark.slow
def test_what_cannot_be_checked_is_said(folder):
    """A file that is gone, not sound, no result, of another sheet: a sentence each."""
    save("unit.yaml", "--measured", "cal.json")
    path = folder / "cal.json"
    whole = path.read_text(encoding="utf-8")

    def said(*words):
        run = call("check", "ref.json", code=2)
        assert_says(run.err, *words)
        assert len(run.err.strip().splitlines()) == 1

    rewrite(path, lambda document: document.update(is_sound=False))
    said("cal.json", "not sound")
    path.write_text("{", encoding="utf-8")
    said("cal.json", "is no result")
    path.write_bytes(whole.encode("utf-16"))
    said("cal.json", "is no result")
    path.unlink()
    said("ref.json: its result cal.json is not there")
    path.write_text(whole, encoding="utf-8")
    put(folder / "unit.yaml", UNIT.replace("0.05", "0.06"))
    said("another device than unit.yaml")


def test_what_is_no_reference_of_a_unit_is_refused(folder):
    """Exit 2, with what to do, and no file."""
    one = ("--measured", "cal.json")
    limits = ("--requirement", "limits.yaml")
    for more, word in (
        ((*one, "--kind", "allocate", *limits), "role result"),
        ((*one, "--set", "gyro.bias_repeatability=1 deg/h"), "leave --set out"),
        ((*one, "--measured", "b/cal.json"), "role result"),
        (("--measured", "unit.yaml"), "is no result"),
        (("--measured", "gone.json"), "cannot be read"),
        (("--measured", "ref.json"), "cannot be read"),
    ):
        run = save("unit.yaml", *more, code=2)
        assert_says(run.err, word)
        assert not (folder / "ref.json").exists()


def test_a_reference_is_not_written_over_its_result(folder):
    """What is read is not where it goes."""
    words = ("check", "--save", "cal.json", "unit.yaml", "--procedure", SIX)
    before = (folder / "cal.json").read_bytes()
    assert call(*words, "--measured", "cal.json").code == 2
    assert (folder / "cal.json").read_bytes() == before


def test_a_forged_result_reads_no_other_file(folder):
    """A bare name ships of no result, and one outside of the tree is not opened."""
    from budget.references.store import _checksum

    save("unit.yaml", "--measured", "cal.json")
    whole = json.loads((folder / "ref.json").read_text(encoding="utf-8"))
    for file in ("zhao-2019", "../../secret.json", "cal.json#B", "b", "."):
        content = json.loads(json.dumps(whole))
        (one,) = (x for x in content["inputs"] if x["role"] == "result")
        one["file"] = file
        content.pop("checksum")
        content["checksum"] = _checksum(content)
        put(folder / "forged.json", json.dumps(content))
        run = call("check", "forged.json", code=2)
        assert "Traceback" not in run.err
        assert len(run.err.strip().splitlines()) == 1
