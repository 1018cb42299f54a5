"""References of missions: stored with their file, and what moved them is named."""

from __future__ import annotations

import json
from hashlib import sha256

import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import put
from reading import assert_says

from budget.references.store import _checksum

DEVICE = """\
name: One
gyro:
  errors:
    bias_repeatability: 1 deg/h
    bias_stability: {value: 0.5 deg/h, correlation_time: 300 s}
    angle_random_walk: 0.1 deg/sqrt(h)
accelerometer:
  errors: {bias_repeatability: 1 mg, velocity_random_walk: 0.05 m/s/sqrt(h)}
"""
HEAD = "name: way\nmission:\n  latitude: 47 deg\n  speed: 15 m/s\n"
AIDED = (
    HEAD
    + """\
  alignment: {position: 10 m, velocity: 1 m/s, level: 1 deg, heading: 5 deg}
  aiding: {gnss: {position: 2.5 m, velocity: 0.05 m/s, rate: 1 Hz}}
  segments:
    - {straight: 20 s, aiding: [gnss]}
    - {straight: 20 s}
  at: [30 s, 40 s]
"""
)
PLAIN = HEAD + "  segments: [{straight: 40 s}]\n  at: [30 s, 40 s]\n"
MISSIONS = {"plain": PLAIN, "aided": AIDED}
LIMITS = """\
name: far
limits: {mission: {position: [{horizontal: 7 m, at: 40 s, probability: 50 %}]}}
"""
HUT = "station: {gravity: 20 mGal, mount: 3 arcsec}\n"
WALK = "gyro.errors.angle_random_walk: 0.1 deg/sqrt(h) -> 0.11 deg/sqrt(h)"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder to work in, with a device, a mission with aids, and limits."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("imu", DEVICE), ("way", AIDED), ("far", LIMITS), ("hut", HUT)):
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    return tmp_path


def save(*more):
    """Store the mission of the device."""
    return call(
        "check", "--save", "ref.json", "imu.yaml", "--mission", "way.yaml", *more
    )


def change(folder, name, before, after):
    """Change a file."""
    path = folder / f"{name}.yaml"
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def stored(folder):
    """Return the content of the reference."""
    return json.loads((folder / "ref.json").read_text(encoding="utf-8"))


def forge(folder, edit):
    """Change the reference and put the right checksum on it."""
    content = stored(folder)
    edit(content)
    del content["checksum"]
    content["checksum"] = _checksum(content)
    (folder / "ref.json").write_text(json.dumps(content), encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("way", MISSIONS)
def test_what_is_stored_is_what_the_mission_says(folder, way):
    """Its errors at its times, source by source; and its file by content."""
    (folder / "way.yaml").write_text(MISSIONS[way], encoding="utf-8")
    assert save("--requirement", "far.yaml").code == 0
    content = stored(folder)
    roles = [(one["role"], one["file"]) for one in content["inputs"]]
    assert ("mission", "way.yaml") in roles
    assert not any(role == "procedure" for role, _ in roles)
    options = ("--requirement", "far.yaml", "--no-validate", "--json", "found.json")
    call("mission", "imu.yaml", "--mission", "way.yaml", *options, code=0)
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    numbers = {
        (one["subject"], one["quantity"], one.get("partner", "")): one["value"]
        for one in content["numbers"]
    }
    for row in found["outputs"]:
        name = f"mission.{row['parameter']}.{row['axis']}.{row['time']:.10g}"
        u = numbers[name, "standard_uncertainty", ""]
        assert_allclose(u, row["standard_uncertainty"], rtol=1e-12)
        for part in row["contributions"]:
            own = numbers.get((name, "contribution", part["source"]))
            assert own == part["standard_uncertainty"]
    assert ("aiding.gnss_velocity" in str(numbers)) == (way == "aided")
    words = {(one["subject"], one["quantity"]): one["text"] for one in content["words"]}
    assert words["mission", "verdict"] == found["assessment"]["verdict"]
    assert "g_sensitivity" in words["gyro", "not_given"]
    assert call("check", "ref.json").code == 0


@pytest.mark.parametrize("way", MISSIONS)
def test_a_line_that_moved_a_mission_is_named(folder, way):
    """With how much of each move it made: of a lone change all of it."""
    (folder / "way.yaml").write_text(MISSIONS[way], encoding="utf-8")
    assert save().code == 0
    change(folder, "imu", "0.1 deg/sqrt(h)", "0.11 deg/sqrt(h)")
    run = call("check", "ref.json", "--json", "moved.json", code=1)
    assert_says(run.out, f"device imu.yaml: {WALK}", "0 unchanged, 1 moved")


@pytest.mark.slow
def test_an_outage_that_begins_later_is_named(folder):
    """By the key of the mission; beside a change of the device each has its part."""
    assert save().code == 0
    change(folder, "way", "straight: 20 s, aiding", "straight: 21 s, aiding")
    key = "mission way.yaml: mission.segments[0].straight: 20 s -> 21 s"
    run = call("check", "ref.json", code=1)
    assert_says(run.out, key)
    change(folder, "imu", "0.1 deg/sqrt(h)", "0.11 deg/sqrt(h)")
    run = call("check", "ref.json", code=1)
    assert_says(run.out, key, WALK)


@pytest.mark.slow
def test_an_aid_that_comes_and_a_time_that_comes_have_moved_it(folder):
    """What they add is new, beside what they change."""
    assert save().code == 0
    change(
        folder,
        "way",
        "rate: 1 Hz}}",
        "rate: 1 Hz}, heading: {value: 1 deg, rate: 1 Hz}}",
    )
    change(folder, "way", "aiding: [gnss]", "aiding: [gnss, heading]")
    call("check", "ref.json", "--csv", "moved.csv", code=1)
    assert "aiding.heading" in (folder / "moved.csv").read_text(encoding="utf-8")
    (folder / "way.yaml").write_text(AIDED, encoding="utf-8")
    change(folder, "way", "at: [30 s", "at: [25 s, 30 s")
    call("check", "ref.json", "--csv", "moved.csv", code=1)
    rows = (folder / "moved.csv").read_text(encoding="utf-8")
    assert "horizontal.25" in rows
    assert "horizontal.30" not in rows


@pytest.mark.slow
def test_what_calibrated_the_unit_is_an_input_like_the_others(folder):
    """A procedure and its station: stored, and named where they move a number."""
    plan = "name: plan\ngyro: {turns: 10}\n"
    (folder / "plan.yaml").write_text(plan, encoding="utf-8")
    assert save("--procedure", "plan.yaml", "--station", "hut.yaml").code == 0
    assert call("check", "ref.json").code == 0
    change(folder, "plan", "turns: 10", "turns: 2")
    run = call("check", "ref.json", code=1)
    assert_says(run.out, "procedure plan.yaml: gyro.turns: 10 -> 2")
    change(folder, "plan", "turns: 2", "turns: 10")
    change(folder, "hut", "20 mGal", "30 mGal")
    run = call("check", "ref.json", code=1)
    assert_says(run.out, "station hut.yaml: station.gravity: 20 mGal -> 30 mGal")


def test_code_that_moved_a_mission_is_named(folder):
    """Where the files are as they were it was the tool."""
    assert save().code == 0

    def worse(content):
        for one in content["numbers"]:
            one["value"] *= 1.001

    forge(folder, worse)
    run = call("check", "ref.json", code=1)
    assert_says(run.out, "tool: code: as stored -> as it is")


@pytest.mark.slow
def test_trials_of_a_mission_have_their_standard_errors(folder):
    """So that another seed is no move, and a tenth more of a line is one."""
    assert save("--method", "monte-carlo", "--trials", "4000").code == 0
    errors = [one.get("standard_error") for one in stored(folder)["numbers"]]
    assert any(errors)
    assert call("check", "ref.json").code == 0

    def other(content):
        content["settings"]["seed"] = 5

    forge(folder, other)
    assert call("check", "ref.json").code == 0
    change(folder, "imu", "0.1 deg/sqrt(h)", "0.3 deg/sqrt(h)")
    assert call("check", "ref.json").code == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--kind", "mission"), "0 of role mission, a reference of kind mission has 1"),
        (("--mission", "way.yaml", "--kind", "analyze"), "1 of role mission"),
        (("--requirement", "far.yaml"), "or give --mission FILE"),
        (
            ("--mission", "way.yaml", "--requirement", "gyro.yaml"),
            "found calibration by the maker",
        ),
        (("--mission", "way.yaml", "--station", "hut.yaml"), "--procedure FILE"),
        (("--mission", "way.yaml", "--reference", "nominal"), "means nothing to"),
        (("--mission", "track.yaml"), "recorded trajectory, which a reference does"),
    ],
)
def test_what_is_no_reference_of_a_mission_is_refused(folder, words, said):
    """In words that say what to give; nothing is written."""
    (folder / "gyro.yaml").write_text("name: g\nlimits: {gyro: {bias: 1 deg/h}}\n")
    (folder / "track.yaml").write_text("mission: {trajectory: secret.csv}\n")
    run = call("check", "--save", "ref.json", "imu.yaml", *words, code=2)
    assert_says(run.err, said)
    assert not (folder / "ref.json").exists()


def test_a_forged_mission_is_refused_in_words(folder, tmp_path_factory):
    """Edited, doubled, or led to a file that is not its own: none is opened."""
    secret = put(tmp_path_factory.mktemp("elsewhere") / "secret.csv", "hunter2\n")
    assert save().code == 0
    text = (folder / "ref.json").read_text(encoding="utf-8")

    def refused(edit=None):
        (folder / "ref.json").write_text(text, encoding="utf-8")
        if edit is not None:
            forge(folder, edit)
        run = call("check", "ref.json", code=2)
        assert "hunter2" not in run.err + run.out
        return run.err

    def place(content):
        return next(one for one in content["inputs"] if one["role"] == "mission")

    edited = text.replace("straight: 20 s}", "straight: 22 s}")
    assert edited != text
    (folder / "ref.json").write_text(edited, encoding="utf-8")
    assert_says(call("check", "ref.json").err, "the checksum differs")
    assert_says(refused(lambda c: c["inputs"].append(place(c))), "2 of role mission")
    assert_says(refused(lambda c: c["inputs"].remove(place(c))), "0 of role mission")
    gone = refused(lambda c: place(c).update(file=str(secret)))
    assert_says(gone, "has an absolute path")
    assert_says(
        refused(lambda c: c.update(job="compare")), "a reference of kind compare"
    )

    def led_astray(content):
        lines = ["mission:", f"  trajectory: {secret}"]
        digest = sha256("\n".join(lines).encode()).hexdigest()
        place(content).update(text=lines, sha256=digest)

    # What is stored only explains: it is not read, and stops no check.
    (folder / "ref.json").write_text(text, encoding="utf-8")
    forge(folder, led_astray)
    run = call("check", "ref.json", code=0)
    assert "hunter2" not in run.err + run.out
    # The file itself, in its place, has a trajectory: refused before it is opened.
    (folder / "way.yaml").write_text(f"mission: {{trajectory: {secret}}}\n")
    assert_says(refused(), "a recorded trajectory, which a reference does not store")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "way"), [("compare", "plain"), ("compare", "aided"), ("allocate", "aided")]
)
def test_limits_on_a_mission_are_shared_out_and_compared(folder, kind, way):
    """With the file of the mission, whose change is named too."""
    (folder / "way.yaml").write_text(MISSIONS[way], encoding="utf-8")
    options = ["--kind", kind, "--requirement", "far.yaml"]
    if kind == "compare":
        options += ["--method", "monte-carlo", "--trials", "2000"]
    assert save(*options).code == 0
    assert any("horizontal" in one["subject"] for one in stored(folder)["numbers"])
    assert call("check", "ref.json").code == 0
    change(folder, "way", "speed: 15 m/s", "speed: 150 m/s")
    change(folder, "imu", "0.1 deg/sqrt(h)", "0.2 deg/sqrt(h)")
    run = call("check", "ref.json", code=1)
    assert_says(run.out, "mission.speed: 15 m/s -> 150 m/s")
    assert_says(run.out, WALK.replace("0.11 ", "0.2 "))


@pytest.mark.slow
def test_two_units_on_a_mission_side_by_side(folder):
    """Two devices, a device beside a reference, and two references."""
    other = DEVICE.replace("0.1 deg/sqrt(h)", "0.11 deg/sqrt(h)")
    (folder / "other.yaml").write_text(other, encoding="utf-8")
    run = call("diff", "imu.yaml", "other.yaml", "--mission", "way.yaml", code=0)
    assert_says(run.out, WALK)
    assert save().code == 0
    run = call("diff", "ref.json", "other.yaml", code=0)
    assert_says(run.out, WALK)
    run = call("diff", "ref.json", "other.yaml", "--mission", "way.yaml", code=2)
    assert_says(run.err, "leave --mission out")
    run = call("diff", "ref.json", "ref.json", code=0)
