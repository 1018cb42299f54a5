"""Missions with aids, sound and damaged, through the commands that compute them."""

from __future__ import annotations

import json
import re
import shutil

import pytest
from command_line import call
from fuzz.effort import examples
from fuzz.grammar import BELIEVED, Raw, leaves, mappings, random_of, replaced, write
from hypothesis import given
from hypothesis import strategies as st
from places import TESTS

pytestmark = pytest.mark.slow  # a mission takes a while

DATA = TESTS / "data"
# Far above and below what anyone means, in the unit that stands there.
EXTREMES = ("1e-12", "1e-6", "1e-3", "1e2", "1e3", "1e4", "1e6", "1e9", "0", "1e300")
SLOW = ("1e-6", "1e-3", "0.017", "0.1", "7", "0", "1e300")  # epochs cost time
WRONG = ("", "~", "x", "[]", "{}", "5", "5 furlong", "nan m", "true", "1e400 m", "-0 s")
AIDS = ("gnss", "heading", "zero_velocity", "odometer")
PLACE = re.compile(r"(^|/)[mr]\.yaml(:[1-9]\d*:[1-9]\d*)?: |^mission\.", re.MULTILINE)
MISSION = "mems.yaml --mission m.yaml --no-validate"
COMMANDS = (
    "validate m.yaml",
    f"mission {MISSION} --json -",
    f"mission {MISSION} --requirement r.yaml",
    f"report {MISSION} --requirement r.yaml -o out.html",
    "compare mems.yaml tac.yaml --mission m.yaml --requirement r.yaml --json -",
    f"mission {MISSION} --calibration zhao-2019 --json -",
    f"mission {MISSION} --method monte-carlo --trials 500",
    f"mission {MISSION} --calibration none --only gyro.bias_repeatability",
    "mission tac.yaml --mission m.yaml",
)
ALL_DONE = {0, 1, 2}  # of a program that has no fault
REQUIREMENT = """
name: way
environment: none
limits:
  mission:
    position: {horizontal: 100 m, at: 20 s}
    heading: {limit: 2 deg, at: 20 s}
"""


def sizes_of(random, like):
    """Return a size as aids write it: a text, or a mapping with axes or a meaning."""
    size = f"{random.choice(('0.05', '2.5', '1', '3e-2'))} {like}"
    how = random.choice(("text", "text", "value", "axes", "CEP"))
    if how == "text" or (how == "CEP" and like != "m"):
        return size
    more = {"axes": {"axes": {"down": f"5 {like}"}}, "CEP": {"meaning": "CEP"}}
    return {"value": size, **more.get(how, {})}


def aiding_of(random, names):
    """Return aids of these names."""
    found = {}
    for name in names:
        one = {"rate": f"{random.choice(('1', '0.5', '2', '0.3'))} Hz"}
        if name == "gnss":
            one["position"] = sizes_of(random, "m")
            if random.random() < 0.6:
                one["velocity"] = sizes_of(random, "m/s")
            if random.random() < 0.3:
                one["position_drift"] = {"value": "2 m", "correlation_time": "60 s"}
        else:
            one["value"] = "1 deg" if name == "heading" else "0.1 m/s"
        found[name] = one
    return found


def moving(random, names):
    """Return segments: aided, without aids, and perhaps a stand at the end."""
    away = [name for name in names if name != "zero_velocity"]
    turn = {"turn": random.choice(("180 deg", "-90 deg")), "rate": "15 deg/s"}
    if random.random() < 0.3:
        turn |= {"bank": "coordinated", "roll_rate": "30 deg/s"}
    found = [{"straight": "8 s"}, turn]
    if away and random.random() < 0.5:
        found = [{"aiding": away, "repeat": Raw("2"), "segments": found}]
    elif away:
        found = [{"aiding": away, **one} for one in found]
    found.append(
        random.choice(({"straight": "12 s"}, {"climb": "9 s", "rate": "1 m/s"}))
    )
    if "zero_velocity" in names:
        found += [
            {"accelerate": "5 s", "to": "0 m/s"},
            {"stand": "9 s", "aiding": ["zero_velocity"]},
        ]
    return found


def mission_of(random):
    """Return a sound mission with aids, of 30 to 80 s."""
    names = [name for name in AIDS if random.random() < 0.5] or ["gnss"]
    part = {
        "alignment": random.choice(
            (
                "perfect",
                {"position": "10 m", "velocity": "1 m/s", "level": "1 deg"},
                {"heading": random.choice(("5 deg", "40 deg")), "level": "30 arcmin"},
            )
        ),
        "altitude": random.choice(("aided", "free")),
        "aiding": aiding_of(random, names),
    }
    if random.random() < 0.25:  # a recording, of 65 s or 120 s
        stands = random.random() < 0.5
        part["trajectory"] = "standing.csv" if stands else "flight.csv"
        if stands and random.random() < 0.5:
            part |= {"alignment": "self", "alignment_time": "60 s"}
        if not stands and "zero_velocity" in names:
            del part["aiding"]["zero_velocity"]
            part["aiding"] |= aiding_of(random, ["gnss"])
        for one in part["aiding"].values():
            spans = ([["0 s", "30 s"]], [["5 s", "9.5 s"], ["20 s", "65 s"]])
            one["during"] = random.choice(spans)
        part["at"] = ["30 s", "65 s"]
    else:
        part |= {"latitude": "47 deg", "speed": "15 m/s"}
        part["segments"] = moving(random, names)
    own = random.choice(("optimal", "no", "estimates", "believes", "both"))
    if own == "optimal":
        part["filter"] = "optimal"
    elif own != "no":
        part["filter"] = {}
        if own != "believes":
            part["filter"]["estimates"] = random.choice(
                ([], ["gyro.bias"], ["gyro.bias", "accelerometer.bias"])
            )
        if own != "estimates":
            known = [key for key in BELIEVED if "gnss" in names or "gnss" not in key]
            name = random.choice(known)
            part["filter"]["believes"] = {name: BELIEVED[name]}
    return {"name": "m", "environment": "none", "mission": part}


def damaged(tree, random):
    """Return a tree with one thing changed: a number, a value, or a key."""
    inside = [one for one in leaves(tree) if one[0][0] == "mission"]
    path, value = random.choice(inside)
    text = value.text if isinstance(value, Raw) else str(value)
    number, _, unit = text.partition(" ")
    how = random.choice((*("size",) * 5, "wrong", "gone", "more", "swap"))
    if how == "size" and number[:1].isdigit():
        sizes = SLOW if unit == "Hz" and random.random() < 0.9 else EXTREMES
        return replaced(tree, path, f"{random.choice(sizes)} {unit}".strip())
    if how == "gone":
        within, key = path[:-1], path[-1]
        whole = tree
        for step in within:
            whole = whole[step]
        if isinstance(whole, dict) and len(whole) > 1:
            kept = {one: whole[one] for one in whole if one != key}
            return replaced(tree, within, kept)
    if how == "more":
        known = [one for one in mappings(tree) if one[:1] == ("mission",)]
        names = ("aiding", "during", "rate", "value", "axes", "bias", "filter", "at")
        key = random.choice(names)
        return replaced(tree, (*random.choice(known), key), random.choice(inside)[1])
    if how == "swap":
        return replaced(tree, path, random.choice(inside)[1])
    return replaced(tree, path, Raw(random.choice(WRONG)))


def judge_run(command, run, there, folder):
    """Check what a command has done, given the files that were there before."""
    told = (command, run.code, run.err[-3000:])
    assert run.code in ALL_DONE, told
    assert "Traceback" not in run.err + run.out, told
    assert "nan" not in re.findall(r"[a-z]+", run.out.lower()), told
    new = {path.name for path in folder.iterdir()} - there
    if run.code == 2:
        assert run.err.strip(), told
        assert not new, (told, new)
        assert len(run.err) < 12_000, told
        if not command.startswith("compare"):
            assert run.out == "", told
        return
    if "--json" in command:
        json.loads(run.out, parse_constant=lambda word: pytest.fail(f"{word}: {told}"))
    assert ("out.html" in new) == ("-o out.html" in command), told
    for name in new:
        page = (folder / name).read_text(encoding="utf-8")
        assert page.rstrip().endswith("</html>"), told
        assert not re.search(r">\s*(nan|inf)\b", page), told
        (folder / name).unlink()


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return a folder with devices, recordings and a requirement, and be there."""
    for name in ("aided/mems.yaml", "aided/tac.yaml", "flight.csv", "standing.csv"):
        shutil.copy(DATA / name, tmp_path)
    (tmp_path / "r.yaml").write_text(REQUIREMENT, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_missions_with_aids_are_computed_or_refused(folder):
    """A mission with aids, sound or damaged, gives numbers or words, never a fault.

    One in four at least is computed, else this would say nothing.
    """
    computed = []

    @examples(20)
    @given(seed=st.integers(0, 2**32 - 1))
    def judge(seed):
        random = random_of(seed)
        tree = mission_of(random)
        for _ in range(random.choice((0, 1, 1, 2))):
            tree = damaged(tree, random)
        (folder / "m.yaml").write_text(write(tree, seed).text, encoding="utf-8")
        there = {path.name for path in folder.iterdir()}
        commands = [COMMANDS[0], COMMANDS[1], random.choice(COMMANDS[2:])]
        for command in commands:
            run = call(*command.split())
            judge_run(command, run, there, folder)
            if run.code == 2:
                assert PLACE.search(run.err), run.err
                if command == COMMANDS[0]:
                    break  # the others say the same
        computed.append(run.code != 2)

    judge()
    assert sum(computed) > len(computed) // 4, (sum(computed), len(computed))
