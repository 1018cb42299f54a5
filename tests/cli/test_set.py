"""`--set` on every command that reads a device: the same change, and told in each."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from html import unescape

import pytest
from command_line import call
from places import TESTS, put
from reading import assert_says

from budget import load_catalogue, load_device
from budget.cli import app
from budget.missing import fill
from budget.names import Name
from budget.resources import shipped
from budget.settings import Inputs, every_row

pytestmark = pytest.mark.usefixtures("drawn_once", "analyzed_once")

CHANGE = "gyro.bias_stability=0.02 deg/h"
SET = ("--set", CHANGE)
GRADE = ("--requirement", "navigation-grade")
# Quick calls of every command that reads devices, with --json - after them.
CALLS = {
    "analyze": ("analyze", "zhao-2019", "--no-validate"),
    "allocate": ("allocate", "zhao-2019", *GRADE, "--no-validate"),
    "station": ("station", "zhao-2019", *GRADE),
    "compare": ("compare", "zhao-2019", *GRADE, "--method", "gum"),
    "decide": ("decide", GRADE[1], "zhao-2019"),
    "export": ("export", "zhao-2019", "--to", "gtsam", "--rate", "100"),
    "devices": ("devices", "zhao-2019"),
    "report": ("report", "zhao-2019", "--no-validate", "-o", "a.html"),
    "mission": ("mission", "zhao-2019", "--mission", "bench", "--no-validate"),
}
# What has documents of its own: stored budgets, two sides, words on files.
OTHERS = {"check", "diff", "validate", "simulate", "calibrate", "history"}
WITHOUT = {"new", "schema", "paper", "characterise"}  # what reads no device


def test_every_command_has_it_or_a_reason():
    """None is forgotten."""
    names = {one.name or one.callback.__name__ for one in app.registered_commands}
    assert names == CALLS.keys() | OTHERS | WITHOUT
    assert every_row(Inputs)["changes"].jobs == names - WITHOUT


@pytest.fixture
def edited(tmp_path, monkeypatch):
    """Provide a device file with the change in it, of the shipped one's name."""
    monkeypatch.chdir(tmp_path)
    file = shipped("specs") / "devices" / "zhao-2019.yaml"
    text = file.read_text(encoding="utf-8")
    assert text.count("0.04 deg/h") == 1
    return put(tmp_path / "zhao-2019.yaml", text.replace("0.04 deg/h", "0.02 deg/h"))


@cache
def document(name, *more):
    """Return the JSON of a quick call, with more words; that of each is asked once."""
    return json.loads(call(*CALLS[name], *more, "--json", "-").out)


def numbers(value):
    """Yield every number in a document, in its order."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in {"sha256", "inputs"}:
                yield from numbers(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from numbers(inner)
    elif isinstance(value, float):
        yield value


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.slow
def test_numbers_are_those_of_an_edited_file(name, edited):
    """A change on the call and one in the file are one change, to the bit."""
    words = CALLS[name]
    own = [edited if word == "zhao-2019" else word for word in words]
    by_hand = json.loads(call(*own, "--json", "-").out)
    documents = (document(name, *SET), by_hand, document(name))
    found = [list(numbers(one)) for one in documents]
    assert found[0] == found[1]
    assert found[0]
    assert found[0] != found[2]


@pytest.mark.parametrize("name", CALLS)
def test_every_document_names_the_change(name, tmp_path, monkeypatch):
    """The name of the device, the assumptions and the input say what is other."""
    monkeypatch.chdir(tmp_path)
    found = document(name, *SET)
    text = json.dumps(found)
    assert "Zhao 2019 optical IMU, changed" in text
    told = " ".join(re.findall(r'"([^"]*by --set[^"]*)"', text))
    assert_says(told, "gyro.bias_stability", "0.02 deg/h", "0.04 deg/h")
    if name == "devices":
        return
    inputs = found["inputs"]
    device = inputs["device"] if isinstance(inputs, dict) else inputs[0]
    (change,) = device["changes"]
    assert change["line"] == "gyro.bias_stability"
    assert_says(change["from"], "0.04 deg/h")
    assert_says(change["to"], "0.02 deg/h")


@pytest.mark.parametrize("name", sorted(CALLS.keys() - {"report"}))
def test_a_person_sees_the_change(name):
    """On the terminal: the name of the device, and old and new value."""
    words = CALLS[name]
    run = call(*words, *SET)
    out = " ".join((run.out + run.err).replace("# ", "").split())
    assert "changed" in out
    assert_says(out, "gyro.bias_stability", "0.02 deg/h", "0.04 deg/h", "--set")


def test_a_page_shows_the_change_and_the_call(tmp_path, monkeypatch):
    """Title, inputs, provenance, and a command that can be typed again."""
    monkeypatch.chdir(tmp_path)
    assert call(*CALLS["report"], *SET).code == 0
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    plain = " ".join(re.sub("<[^>]+>", " ", text).split())
    assert "Zhao 2019 optical IMU, changed" in plain
    assert "zhao-2019 --set 'gyro.bias_stability=0.02 deg/h'" in unescape(plain)
    assert "changed: gyro.bias_stability 0.02 deg/h" in plain


def test_a_difference_is_that_to_an_edited_file(edited):
    """Of a device beside itself B is changed; of two, the one that is named, or all."""
    by_hand = call("diff", "zhao-2019", edited, "--json", "-").document

    def moved(document):
        return [{**one, "causes": len(one["causes"])} for one in document["moved"]]

    assert len(by_hand["moved"]) > 50
    for words in (
        ("zhao-2019", "zhao-2019", "--set", CHANGE),
        ("zhao-2019", "zhao-2019", "--set", f"zhao-2019:{CHANGE}"),
    ):
        run = call("diff", *words, "--json", "-", code=0)
        assert moved(run.document) == moved(by_hand)
        assert run.document["first"] == "zhao-2019"
        assert run.document["second"] == "zhao-2019, changed"
        first, *texts = run.document["changes"]
        assert first["key"] == "gyro.errors.bias_stability"
        assert_says(first["before"], "0.04 deg/h")
        assert_says(first["after"], "0.02 deg/h")
        assert [one["after"] for one in texts] == ["--set"]
    # Of two devices both are changed, so this line tells them apart no more.
    both = call("diff", "zhao-2019", edited, "--set", CHANGE, "--json", "-").document
    assert both["moved"] == []
    change = f"{edited}:gyro.bias_stability=0.04 deg/h"
    one = call("diff", "zhao-2019", edited, "--set", change, "--json", "-").document
    assert one["moved"] == []
    assert (one["first"], one["second"]) == ("zhao-2019", f"{edited}, changed")


def test_a_reference_keeps_the_change(tmp_path, monkeypatch, edited):
    """It is checked with the change, also where the file says something else by now."""
    monkeypatch.chdir(tmp_path)
    call("check", "--save", "changed.json", edited.name, "--set", CHANGE, code=0)
    stored = json.loads((tmp_path / "changed.json").read_text(encoding="utf-8"))
    assert stored["inputs"][0]["changes"] == [CHANGE]
    assert call("check", "changed.json").code == 0
    text = edited.read_text(encoding="utf-8")
    edited.write_text(text.replace("0.02 deg/h", "0.07 deg/h"), encoding="utf-8")
    assert call("check", "changed.json").code == 0
    edited.write_text(text.replace("50 ppm", "51 ppm"), encoding="utf-8")
    assert call("check", "changed.json").code == 1
    edited.write_text(text, encoding="utf-8")
    plain = call("diff", "changed.json", "zhao-2019", "--json", "-").document
    keys = [one["key"] for one in plain["changes"] if not one["is_text"]]
    assert keys == ["gyro.errors.bias_stability"]


def test_a_comparison_keeps_the_change_of_one_variant(tmp_path, monkeypatch):
    """Variants of a file are stored together; a change finds its own."""
    monkeypatch.chdir(tmp_path)
    call(
        *("check", "--save", "a.json", "hg4930", "--kind", "compare"),
        *("--requirement", "catalogue-edge", "--set", f"#A:{CHANGE}"),
        code=0,
    )
    text = (tmp_path / "a.json").read_text(encoding="utf-8")
    subjects = {one["subject"] for one in json.loads(text)["numbers"]}
    devices = {name.rpartition(" ")[0] for name in subjects if " " in name}
    assert {name for name in devices if "hg4930" in name} == {
        *("hg4930.yaml#A, changed", "hg4930.yaml#B", "hg4930.yaml#C"),
    }
    assert call("check", "a.json").code == 0


@pytest.mark.parametrize("name", ["analyze", "mission", "compare", "export"])
def test_a_change_beside_a_result_is_one_of_the_use(name):
    """What a run left of the parameters stays; what the unit does later is changed."""
    words = [*CALLS[name], "--procedure", "zhao-2019"]
    words += ["--measured", str(TESTS / "data" / "measured.json")]
    words += ["--residual"] * (name == "export")
    plain = call(*words, "--json", "-").document
    changed = call(*words, *SET, "--json", "-").document
    assert "Zhao 2019 optical IMU, changed" in json.dumps(changed)
    assert "measured.json" in json.dumps(changed["inputs"])
    assert [*numbers(plain)] != [*numbers(changed)]


def test_validity_is_that_of_the_changed_device():
    """What is wrong in a change is said as of the file; what is right is assumed."""
    run = call("validate", "zhao-2019", "hg4930#A", "--set", f"#A:{CHANGE}", code=0)
    assert_says(run.out, "zhao-2019: device, valid", "hg4930#A: device, valid")
    assert run.out.count("by --set") == 1
    run = call("validate", "zhao-2019", "--set", "gyro.bias_stability=0.02 deg", code=2)
    assert_says(run.err, "--set gyro.bias_stability", "an angle", "deg/h")


@pytest.mark.parametrize(
    "words",
    [
        ("validate", "navigation-grade"),
        ("diff", "zhao-2019", "hg4930#A", "--set", f"iim:{CHANGE}"),
        ("check", "zhao-2019"),
    ],
    ids=lambda words: words[0],
)
def test_a_change_that_reaches_nothing_is_refused(words):
    """Never in silence; and a stored budget is what it is."""
    run = call(*words, "--set", CHANGE)
    assert (run.code, run.out) == (2, "")
    assert "--set" in run.err or "settings are those" in run.err


def test_a_variant_that_is_not_stored_has_no_change(tmp_path, monkeypatch):
    """Of an analysis the base alone is stored; of a comparison every variant."""
    monkeypatch.chdir(tmp_path)
    text = "name: two\ngyro: {errors: {bias_stability: 1 deg/h}}\n"
    (tmp_path / "two.yaml").write_text(f"{text}variants: {{A: {{name: A}}}}\n")
    how = ("check", "--save", "x.json", "two.yaml", "--set", f"#A:{CHANGE}")
    run = call(*how)
    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "--set", "no device here called '#A'")
    assert not (tmp_path / "x.json").exists()
    grade = ("--kind", "compare", "--requirement", "tactical-grade")
    assert call(*how, *grade).code == 0
    stored = json.loads((tmp_path / "x.json").read_text(encoding="utf-8"))
    assert stored["inputs"][0]["changes"] == [f"#A:{CHANGE}"]


def test_a_csv_with_devices_names_the_change():
    """The comparison's rows are of the changed device."""
    run = call(*CALLS["compare"], *SET, "--csv", "-")
    assert "Zhao 2019 optical IMU, changed" in run.out


def test_a_bad_change_is_refused_in_words():
    """Exit code 2, nothing on stdout, the option named."""
    run = call("analyze", "zhao-2019", "--set", "gyro.bias_stability=0.02 deg")
    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "--set gyro.bias_stability", "an angle", "deg/h")
    run = call("devices", "--set", CHANGE)
    assert (run.code, run.out) == (2, "")
    assert_says(run.err, "--set", "name one")


@pytest.mark.parametrize(
    ("address", "count"),
    [("gyro", 12), ("gyro.bias", 3), ("gyro.bias.z", 1), ("bias.z", 2)],
)
def test_an_address_selects_what_is_printed(address, count):
    """A triad, a group, one of its axes: `--outputs` shows these alone."""
    run = call(*CALLS["analyze"], "--outputs", address, "--json", "-")
    names = [
        f"{row['sensor']}.{row['parameter']}.{row['axis']}"
        for row in run.document["outputs"]
    ]
    assert len(names) == count
    assert all(address in name for name in names)


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_a_changed_device_is_no_comparable_one_to_itself(mode):
    """What stands for a line it lacks does not come from its own printed sheet."""
    catalogue = load_catalogue()
    plain = load_device("hg4930#A")
    assert plain.name in {one.name for one in catalogue}
    sensor = replace(
        plain.accelerometer,
        lines=tuple(
            one
            for one in plain.accelerometer.lines
            if one.name != "velocity_random_walk"
        ),
        expected_missing=(Name("noise", owner="accelerometer"),),
    )
    lacking = replace(plain, accelerometer=sensor)
    changed = load_device("hg4930#A", ["gyro.bias_stability=0.45 deg/h"])
    named = replace(
        lacking,
        name=changed.name,
        accelerometer=replace(sensor, device=changed.name),
        gyro=changed.gyro,
        origin=changed.origin,
    )
    told = [fill(one, mode, catalogue)[1].lines for one in (lacking, named)]
    assert told[0]
    assert told[0] == told[1]
