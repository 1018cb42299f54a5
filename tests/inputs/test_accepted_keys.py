"""Every key that a file may have changes a result, or the docs say that it does not."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass, replace
from functools import reduce
from operator import getitem
from pathlib import Path
from string import ascii_lowercase
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from builders import line, paper_accelerometer, paper_gyro
from command_line import call
from fuzz.grammar import replaced
from fuzz.keys import KEYS, TABLE, Key, is_of_use, silent
from jsonschema import Draft202012Validator
from places import ROOT, put

import budget
from budget.aiding import journey_of
from budget.calibration.mission import mission_outputs, mission_problem, of_aiding
from budget.calibration.problem import calibration_problem
from budget.calibration.saturation import Peak, beyond
from budget.errors import SpecError
from budget.inputs import load_costs, load_device, uncalibrated, validate
from budget.inputs.device import read_device
from budget.inputs.files import find, open_file
from budget.inputs.records import ANGLES, AXES
from budget.inputs.use import in_use
from budget.methods.gum import propagate
from budget.model.sources import SENSORS, lines_of, walk_of
from budget.model.sources.later import AGEING
from budget.names import ORDERS
from budget.navigation.growth import AxisNoise, Markov
from budget.studies.allocation.allocate import allocate
from budget.studies.verdicts import VERDICTS

DEG, G = np.pi / 180.0, 9.80665
CHANGED = 1e-9  # relative; far above rounding, far below what any perturbation does
PAPER = budget.load_procedure()
# With a temperature that changes, so that its coefficients are felt.
WARM = replace(
    PAPER,
    environment=(
        line("temperature.ramp", [1.0 / 3600.0]),
        line("vibration.test", [9.80665]),
        line("age", [3e7]),
    ),
)
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("nothing_is_missing")]
MARK = "Quagga"  # a word that stands in no file and no message


def base_of(path):
    """Return the path of a key as the base of a device has it, without its variant."""
    return path[2:] if path[0] == "variants" else path


def example(key):
    """Return a value of a key that is not its default."""
    schema, default = key.schema, key.schema.get("default")
    if "examples" in schema:
        unit = schema["examples"][0].removeprefix("1 ")
        fixed = {"m/s^2": "9.81 m/s^2", "%": "80 %"}
        return fixed.get(unit, f"7 {unit}")
    if schema.get("type") == "array":
        lists = {
            "order": ["x", "y", "z"],
            "azimuths": ["10 deg", "100 deg"],
            "soak_points": ["70 s"],
            "reading": ["2 sigma", "3 sigma"],
            "at": ["7 s"],
        }
        return lists.get(key.path[-1], ["scale_factor"])  # of what is estimated
    if key.path[-1] == "distribution" and "arcsine" in schema.get("enum", ()):
        return "arcsine"  # the last words of the list are other words for uniform
    said = {  # two-sided, the larger, is what is taken without it; the name of a file
        "density": "one-sided",
        "station": "three-axis-table" if key.path == ("station",) else None,
    }
    if word := said.get(key.path[-1]):
        return word
    if "enum" in schema:
        return next(word for word in reversed(schema["enum"]) if word != default)
    others = {"boolean": True, "integer": 7, "number": 7}
    return others.get(schema.get("type"), MARK)


def steps_of(key):
    """Return the way to a key in a file that has it: of a list the first item."""
    return tuple(0 if step == "[]" else step for step in key.path)


# Keys whose value has to stand beside another one to be allowed, or to mean something.
BIASES = {"gyro": "deg/h", "accelerometer": "ug"}
RANGES = {"gyro": "deg/s", "accelerometer": "g"}
AXES_OF = {"bias": AXES, "mounting_angle": ANGLES}
FIGURE_KEYS = (
    *("value", "meaning", "distribution", "includes", "horizon"),
    *("condition", "source", "degrees_of_freedom"),
)
BESIDE = {
    "distribution": {"meaning": "max"},
    "averaging_time": {"definition": "allan_minimum"},
    **{
        key: {"bandwidth": {"corner": "9 Hz", "order": 1}}
        for key in ("corner", "order")
    },
}
OF_AXES = BESIDE | {"definition": {"correlation_time": "300 s"}}  # as all axes have
# A unit per root of hertz, beside which `density` may stand.
DENSITIES = {
    "deg/sqrt(h)": "deg/h/sqrt(Hz)",
    "ug/sqrt(Hz)": "ug/sqrt(Hz)",
    "deg/h/sqrt(h)": "deg/s^2/sqrt(Hz)",
    "ug/sqrt(h)": "ug/s/sqrt(Hz)",
}


def ranged(key):
    """Return a device with a range that no test is beyond, and with that key of it."""
    kinds = [step for step in key.path if step in SENSORS]
    if not kinds:  # a text, of the kind of the last form that it has
        kinds = [one for one in SENSORS if example(key).endswith(f" {RANGES[one]}")]
    (sensor,) = kinds
    errors = {"bias_stability": f"100 {BIASES[sensor]}"}
    tree = {"name": "x", sensor: {"errors": errors}}
    given = {"value": f"90 {RANGES[sensor]}"}
    if key.path[0] == sensor:
        tree[sensor]["range"] = given
    else:
        tree["range"] = {sensor: given}
    return tree, replaced(tree, steps_of(key), example(key))


def device(key):
    """Return a device as small as the key allows, without the key and with it."""
    return ranged(key) if "range" in key.path[:2] else lined(key)


def lined(key):
    """Return the same for a key that is not of a range."""
    sensor = key.path[0] if key.path[0] in SENSORS else "gyro"
    tree = {
        "name": "x",
        "gravity_unit": "9.80665 m/s^2",
        sensor: {
            "nominal": {"bias": f"100 {BIASES[sensor]}", "mounting_angle": "1 deg"},
            "errors": {},
        },
    }
    if key.path[1:2] == ("nominal",) and len(key.path) == 4:
        nominal, axes = tree[sensor]["nominal"], AXES_OF[key.path[2]]
        nominal[key.path[2]] = dict.fromkeys(axes, nominal[key.path[2]])
    if key.path[:1] == ("gravity_unit",):
        tree["accelerometer"] = {"errors": {"bias_repeatability": "1 mg"}}
    if key.path[1:2] == ("errors",):
        name, *rest = key.path[2:]
        (line,) = (one for one in lines_of(sensor) if one.name == name)
        figure = {"value": f"1 {line.like(sensor)}"}
        beside = (OF_AXES if rest[:1] == ["axes"] else BESIDE).get(key.path[-1], {})
        if key.path[-1] in {"line", "shape"}:
            beside = {"full_scale": "400 deg/s" if sensor == "gyro" else "9 g"}
        if key.path[-1] == "density":
            beside = {"value": f"1 {DENSITIES[line.like(sensor)]}"}
        if line.name in AGEING.values():
            beside = beside | {"horizon": "1 h" if rest == ["law"] else "2 years"}
        if rest[:1] == ["earlier"]:
            earlier = {"value": f"0.1 {line.like(sensor)}", "horizon": "1 day"}
            beside = beside | {"earlier": [earlier], "value": f"9 {line.like(sensor)}"}
        tree[sensor]["errors"][name] = figure | beside
        if len(rest) > 2 and rest[0] == "axes":  # a key of an axis that is a mapping
            tree[sensor]["errors"][name]["axes"] = {
                rest[1]: {
                    k: v for k, v in {**figure, **beside}.items() if k != "horizon"
                }
            }
    else:
        tree[sensor]["errors"] = {
            "bias_stability": f"100 {BIASES[sensor]}",
            **({"scale_factor_asymmetry": "1000 ppm"} if sensor == "gyro" else {}),
        }
    if "figures" in key.path:
        tree["figures"] = [{"name": "n", "value": "v"}]
    return tree, replaced(tree, steps_of(key), example(key))


def numbers(value):
    """Return all numbers and verdicts in a document, in their order."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return [number for item in value for number in numbers(item)]
    is_result = isinstance(value, int | float) or value in VERDICTS
    return [value] if is_result else []


def differ(first, second):
    """Say whether two lists of numbers differ by more than rounding."""
    if len(first) != len(second):
        return True
    return any(
        a != b and (isinstance(a, str) or abs(a - b) > CHANGED * max(abs(a), abs(b)))
        for a, b in zip(first, second, strict=True)
    )


def analyzed(one, procedure=WARM):
    """Return the numbers of `budget analyze`, by the law and not validated.

    Of a later turn-on where something waits for one.
    """
    names = " ".join(line.name for line in procedure.environment)
    names += " ".join(line.name for sensor in one.sensors for line in sensor.lines)
    waits = any(word in names for word in ("mission", "over_temperature", "ageing"))
    document = budget.analyze(
        one,
        procedure=procedure,
        reference="next_turn_on" if waits else "nominal",
        validate=False,
    ).to_dict()
    return numbers([document["outputs"], document["covariance"]])


def choices(kind, *, moving, of_use=False):
    """Return the keys of a kind that have to move a number, or those that need not.

    What a unit is used in several kinds say alike: a test of its own, `of_use`.
    """
    return [
        key
        for key in KEYS[kind]
        if silent(kind, base_of(key.path)) != moving
        and "const" not in key.schema
        and is_of_use(kind, key.path) == of_use
    ]


def is_of_another_axis(key):
    """Say whether a key beside a value is of an axis that reads as the first one."""
    _, found, own = "/".join(map(str, key.path)).partition("/axes/")
    return bool(found) and own.partition("/")[0] not in {"x", "xy", "xx"} and "/" in own


DEVICE = [
    key
    for key in choices("device", moving=True)
    # What a range decides is a test of its own.
    if key.path[0] != "variants" and "range" not in key.path[:2]
    if not is_of_another_axis(key)
]
RANGED = [
    key
    for key in choices("device", moving=True)
    if key.path[0] != "variants" and "range" in key.path[:2]
]
# What `abstract` hides is a test of its own.
QUIET = [
    key
    for key in choices("device", moving=False)
    # What a force along x or y does not do is tested with the source, and what a time
    # of the Allan curve does not do with the reader.
    if key.path[0] not in {"variants", "abstract"}
    and {"g_sensitivity", "averaging_time"}.isdisjoint(key.path)
    and not is_of_another_axis(key)
]
VARIED: dict = {}  # by line, or what else stands so deep
for key in KEYS["device"]:
    if (
        key.path[0] == "variants"
        and "const" not in key.schema
        and not is_of_another_axis(key)
    ):
        VARIED.setdefault(".".join(map(str, key.path[2:5])), []).append(key)


def alike(keys, name):
    """Return lists of keys, each of those with the same name."""
    found: dict = {}
    for key in keys:
        found.setdefault(name(key), []).append(key)
    return list(found.values())


def by_file(keys, file=lambda key: device(key)[0]):
    """Return lists of keys, each of those whose file without them is the same."""
    return alike(keys, lambda key: json.dumps(file(key)))


def with_words(tree, keys):
    """Return a file with all those keys, each with a word of its own, and the words."""
    words = [MARK + letter for letter in ascii_lowercase[: len(keys)]]
    for key, word in zip(keys, words, strict=True):
        assert example(key) == MARK, str(key)
        tree = replaced(tree, steps_of(key), word)
    return tree, words


def by_line(kind):
    """Mark a test of `keys` of a kind that move a number: of a line at a time."""
    keys = DEVICE if kind == "device" else choices(kind, moving=True)
    lines = alike(keys, lambda key: ".".join(key.path[:3]))
    if kind == "costs":  # each line is read as the others: of each one key, in turn
        own = alike(keys, lambda key: key.path[1])
        lines = [[each[place % len(each)]] for place, each in enumerate(own)]
    return pytest.mark.parametrize("keys", lines, ids=lambda keys: str(keys[0]))


def unmoved(keys, asked):
    """Return the keys with which no number is another one: `asked` gives both lists."""
    found = []
    for key in keys:
        try:
            moved = differ(*asked(key))
        except Exception as error:
            error.add_note(f"with the key {key}")
            raise
        if not moved:
            found.append(str(key))
    return found


FOUND: dict = {}  # many keys share a file without them: what it gives is asked once


def once(question, tree):
    """Return the answer to a question of a file, asked once for each content."""
    key = question, json.dumps(tree)
    if key not in FOUND:
        FOUND[key] = question(tree)
    return FOUND[key]


def analyzed_file(tree):
    """Return the numbers of `budget analyze` of a device file."""
    return analyzed(load_device(tree))


def untested_file(tree):
    """Return how well a device is known that nobody calibrates."""
    problem = calibration_problem(
        load_device(tree).sensors,
        uncalibrated("none"),
        reference="next_turn_on",
        every=True,
    )
    return propagate(problem).standard_uncertainty.tolist()


def printed(tree):
    """Return what `budget devices` shows of a file."""
    with TemporaryDirectory() as folder:
        path = put(Path(folder) / "file.yaml", json.dumps(tree))
        return call("devices", path).out


def budgeted(key):
    """Return the numbers of a device without a key, and with it.

    What every calibration finds moves what nobody calibrates.
    """
    is_initial = len(key.path) > 2 and key.path[2].startswith("initial_")
    asked = untested_file if is_initial else analyzed_file
    return tuple(once(asked, tree) for tree in device(key))


@by_line("device")
def test_a_key_of_a_device_moves_a_number(keys):
    """Some output of the budget is another one with each key."""
    assert unmoved(keys, budgeted) == []


def asked_beyond(tree):
    """Return the axes of a device whose ranges 8 deg/s and 8 g are beyond."""
    size = {"gyro": 8.0 * DEG, "accelerometer": 8.0 * G}
    return [
        axis
        for sensor in load_device(tree).sensors
        for axis in AXES
        if beyond(
            sensor,
            [Peak(sensor=sensor.kind, axis=axis, size=size[sensor.kind], where="")],
        )
    ]


@pytest.mark.parametrize("key", RANGED, ids=str)
def test_a_key_of_a_range_decides_what_may_be_asked(key):
    """8 deg/s and 8 g are within a range of 90, and beyond one of 7 by any key."""
    assert [len(asked_beyond(tree)) for tree in device(key)] == [
        0,
        1 if key.path[-1] in AXES else 3,
    ]


@pytest.mark.parametrize("keys", by_file(QUIET), ids=lambda keys: str(keys[0]))
def test_keys_of_the_table_move_no_number_and_are_printed(keys):
    """No output changes with such keys, and `budget devices` shows what they say.

    All that one file may have at once, each with a word of its own.
    """
    before, _ = device(keys[0])
    after, words = with_words(before, keys)
    assert not differ(*(once(analyzed_file, tree) for tree in (before, after)))
    assert MARK not in once(printed, before)
    shown = once(printed, after)
    assert [
        str(k) for k, word in zip(keys, words, strict=True) if word not in shown
    ] == []


def test_an_abstract_base_is_hidden():
    """`abstract` takes the base from the list of what a file holds."""
    before, _ = device(Key(("name",), {}))
    before["variants"] = {"A": {}}
    assert validate(before).variants == ("", "A")
    assert "\nx (A) (gyro)" in printed(before)
    hidden = {**before, "abstract": True}
    assert validate(hidden).variants == ("A",)
    assert "\nx (gyro)" not in "\n" + printed(hidden)


def facts(value):
    """Return what a record says as plain values, but for names and where it is from."""
    if is_dataclass(value):
        left = [
            f.name
            for f in fields(value)
            if f.name not in {"origin", "device", "read_again", "read_plain"}
        ]
        return {name: facts(getattr(value, name)) for name in left}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [facts(item) for item in value] if isinstance(value, tuple) else value


@pytest.mark.parametrize("place", VARIED)
def test_a_key_of_a_variant_does_what_it_does_in_the_base(place):
    """A variant that overrides one key is the device whose base says so itself."""
    inner = [Key(base_of(key.path), key.schema) for key in VARIED[place]]
    for keys in by_file(inner):
        assert_varied(keys)


def override_by(key):
    """Return a variant that says one key otherwise than its base."""
    steps = steps_of(key)
    if steps[0] not in SENSORS and (steps[0] != "range" or len(steps) == 1):
        return {steps[0]: device(key)[1][steps[0]]}
    value = example(key)
    if 0 in steps:  # a list is overridden as a whole
        steps = steps[: steps.index(0)]
        value = reduce(getitem, steps, device(key)[1])
    for step in reversed(steps):
        value = {step: value}
    return value


def assert_varied(keys):
    """Assert that keys of variants of one file do what they do in its base."""
    before, _ = device(keys[0])
    variants = {f"V{n}": override_by(key) for n, key in enumerate(keys)}
    document = opened({**before, "variants": variants})
    unchanged = facts(read_device(document))
    unchanged.pop("name")
    for variant, key in zip(variants, keys, strict=True):
        chosen = facts(read_device(document, variant))
        direct = facts(load_device(device(key)[1]))
        assert chosen.pop("name") == f"{direct.pop('name')} ({variant})", str(key)
        assert chosen == direct, str(key)
        assert chosen != unchanged or key.path == ("name",), str(key)


def opened(path):
    """Return a file that is read and not yet taken for a device."""
    return open_file(find(path), "device")


@pytest.mark.parametrize("kind", KEYS)
def test_a_key_that_can_say_one_thing_only_says_the_default(kind):
    """The docs list it as moving no number; any other word is refused by the schema."""
    for key in (key for key in KEYS[kind] if "const" in key.schema):
        assert silent(kind, base_of(key.path)), str(key)
        allowed = Draft202012Validator(key.schema)
        assert allowed.is_valid(key.schema["const"]), str(key)
        assert not allowed.is_valid(MARK), str(key)


DWELLS = [
    {"face": f"{axis} {word}", "dwell": "60 s"}
    for axis in AXES
    for word in ("up", "down")
]
STANDING = [
    {"middle": f"{middle} deg", "inner": f"{inner} deg", "dwell": "60 s"}
    for middle in (0, 45, -60)
    for inner in (0, 90, 180, -45, 225)
]
TURN = {"face": "z up", "turn": "vertical", "turns": 1, "rate": "20 deg/s"}
# The first window that a key is tried in; else a dwell at a face.
WINDOW = {
    **{key: {**TURN, "use": "gyro"} for key in ("turn", "turns", "rate", "back")},
    **{
        key: {"outer": "1 deg", "dwell": "60 s"} for key in ("outer", "middle", "inner")
    },
}
# What a key of the station does nothing without.
NEEDED = {
    "scale_from": {"rate_error": "100 ppm"},
    "rate_error": {"scale_from": "rate"},
    "window": {"edge_jitter": "1 s"},
    "edge_jitter": {"window": "time"},
}
ESTIMATED = {"estimator": "weighted", "pause": "7 s"}
# What has to stand there so that a key of it may, and means something.
ENVIRONMENTS = {
    "temperature": {
        "sigma": "1 degC",
        "correlation_time": "300 s",
        "mission": "1 degC",
        "warm_up": "1 degC",
        "warm_up_time": "300 s",
        "soak": "1 degC",
        "settling_time": "300 s",
        "soak_points": ["600 s"],
    },
    "age": "1 year",
    "vibration": {"test": "1 g", "mission": "2 g"},
}


def place_of(key):
    """Return a procedure in which a key of a figure stands beside its value."""
    tree = {"latitude": "34.2394 deg"}
    if key.path[0] == "station" and key.path[1:]:  # where nothing of it cancels
        tree["gyro"] = {"azimuths": ["10 deg"]}
        tree["station"] = NEEDED.get(key.path[1], {})
    if key.path == ("moves",):
        tree |= {"estimator": "norm", "windows": STANDING}
    if key.path == ("flip_axis",):
        tree["station"] = {"orthogonality": {"outer_middle": "100 arcsec"}}
    if key.path[0] in {"windows", "pause"}:
        first = WINDOW.get(key.path[-1], {"face": "x up", "dwell": "60 s"})
        if key.path[2:3] == ("windows",):
            first = {"windows": [first]}
        tree["windows"] = [first, *DWELLS]
    if key.path[0] == "estimate":
        tree["estimator"] = "least_squares"
    if key.path[0] == "environment":
        tree["environment"] = {key.path[1]: ENVIRONMENTS[key.path[1]]}
    if key.path[0] in {"station", "environment"} and {"axes", *FIGURE_KEYS} & {
        *key.path
    }:
        owner, *steps = key.path[:-1]
        line = next(
            one
            for n in range(len(steps), 0, -1)
            for one in lines_of(owner)
            if one.name == ".".join(steps[:n])
        )
        value = {"value": f"100 {line.like(owner)}"}
        figure = {**value, **BESIDE.get(key.path[-1], {})}
        own = (owner, *line.name.split("."))
        tree = replaced(tree, own, value)
        if key.path[-1] in FIGURE_KEYS:
            tree = replaced(tree, key.path[:-1], figure)
    return tree


def calibrated(key):
    """Return the numbers of a device after a test without a key, and with it.

    It has noise of every kind; what a station does it does to one with a bias alone.
    Of the two sensors the first whose numbers differ, else the last.
    """
    felt_by = {"moves": ("accelerometer",), **{name: (name,) for name in SENSORS}}
    for sensor in felt_by.get(key.path[0], SENSORS):
        tree = {"name": "x", sensor: noisy(sensor, key)}
        place = place_of(key)
        value = place["windows"][1:] if key.path == ("windows",) else example(key)
        own = replaced(place, steps_of(key), ESTIMATED.get(key.path[0], value))
        found = [once(analyzed_test, [tree, said]) for said in (place, own)]
        if differ(*found):
            break
    return found


def noisy(sensor, key):
    """Return a sensor that feels a key of a procedure."""
    errors = {
        line.name: f"10 {line.like(sensor)}"
        for line in lines_of(sensor)
        if line.process or line.name == "vibration_rectification"
    }
    noise = {"value": errors["sample_noise"], "adds_to": walk_of(sensor)}
    errors["sample_noise"] = noise
    errors["flicker"] = {"value": errors["flicker"], "adds_to": "bias_stability"}
    if key.path[0] == "station":
        errors = {"bias_repeatability": f"10 {BIASES[sensor]}"}
    if key.path[:2] == ("environment", "age"):
        ages = {"value": errors["bias_stability"], "horizon": "1 year"}
        errors |= {"ageing": ages}
    return {"nominal": {"mounting_angle": "1 deg"}, "errors": errors}


def analyzed_test(both):
    """Return the numbers of `budget analyze` of a device file with a procedure file."""
    tree, said = both
    return analyzed(load_device(tree), budget.load_procedure(said))


@by_line("procedure")
def test_a_key_of_a_procedure_moves_a_number(keys):
    """Some output of a device that feels it is another one with each key."""
    assert unmoved(keys, calibrated) == []


# What limits on a mission are judged on: an altitude that is not known has errors.
FLIGHT = {
    "mission": {
        "latitude": "45 deg",
        "altitude": "free",
        "segments": [{"stand": "120 s"}],
    }
}


# What feels each use: its test is ideal, and all that is missing is let be.
USED = {
    "temperature": {"value": "9 degC"},
    "vibration": {"value": "0.9 g"},
    "age": {"value": "0.9 year"},
}
FEELING = {
    "name": "x",
    "gyro": {
        "errors": {
            "bias_repeatability": "1 deg/h",
            "bias_temperature_coefficient": "1 deg/h/degC",
            "vibration_rectification": "1 deg/h/g^2",
            "ageing": {"value": "1 deg/h", "horizon": "1 year"},
        },
        "range": "100 deg/s",
    },
}
WHOLE = {  # files that state no use
    "requirement": {"name": "x", "limits": {"gyro": {"bias": "90 deg/h"}}},
    "mission": FLIGHT,
    "procedure": {"latitude": "34.2394 deg"},
}


def used(kind, tree):
    """Return the numbers of a verdict on what feels each use that a file states."""
    files = WHOLE | {kind: tree}
    wanted = budget.load_requirement(files["requirement"])
    mission = budget.load_mission(files["mission"])
    plan = in_use(budget.load_procedure(files["procedure"]), wanted, mission)
    judged = budget.analyze(
        load_device(FEELING),
        procedure=plan,
        requirement=wanted,
        coverage=wanted.coverage,
        reference=wanted.reference,
        validate=False,
    )
    return numbers(judged.assessment.to_dict())


def stated(kind, key):
    """Return such a file without a key, and with it."""
    tree, steps = WHOLE[kind], steps_of(key)
    name = steps[-2] if steps[-1] in FIGURE_KEYS else steps[-1]
    if steps[-1] in FIGURE_KEYS:
        tree = replaced(tree, steps[:-1], USED[name] | BESIDE.get(steps[-1], {}))
    like = {"temperature": "7 degC", "vibration": "0.7 g", "age": "0.7 year"}
    value = like[name] if steps[-1] in {*like, "value"} else example(key)
    return tree, replaced(tree, steps, value)


# What is known at every time, by the key that it is said in.
PROFILE = {"reference": "5 degC", "profile": [["0 s", "9 degC"], ["60 s", "20 degC"]]}
SHAKEN = {"value": "2 g", "during": [["0 s", "9 s"]]}
COURSES = {
    "reference": ("temperature", PROFILE),
    "profile": ("temperature", PROFILE),
    "warm_up": ("temperature", {"warm_up": {"by": "9 degC", "time": "50 s"}}),
    "[]": ("vibration", [SHAKEN, {"value": "1 g"}]),
}
OTHER = {
    "reference": "6 degC",
    "profile": [["0 s", "9 degC"], ["50 s", "30 degC"]],
    "by": "8 degC",
    "time": "40 s",
    "value": "3 g",
    "during": [["0 s", "20 s"]],
}


def known(key):
    """Return a mission with a course without a key, or with another value, and it."""
    name, said = COURSES[key.path[2]]
    track = {"trajectory": str(ROOT / "tests" / "data" / "standing.csv")}
    tree = {"environment": {name: said}, "mission": {**track, "at": ["60 s"]}}
    return tree, replaced(tree, steps_of(key), OTHER[key.path[-1]])


def warmed(tree):
    """Return errors of what feels a temperature and a vibration on a mission."""
    one = budget.load_mission(tree)
    gyro = paper_gyro(bias_temperature_coefficient=1e-6, vibration_rectification=1e-9)
    how = in_use(uncalibrated("factory"), None, one)
    outputs = mission_outputs(one, one.at)
    problem = mission_problem((gyro, paper_accelerometer()), how, one, outputs)
    return propagate(problem).standard_uncertainty.tolist()


@pytest.mark.parametrize("kind", WHOLE)
def test_a_key_of_the_use_moves_a_number(kind):
    """A verdict, or the margin of one, is another one with each key."""
    keys = choices(kind, moving=True, of_use=True)

    def judged(key):
        if kind == "mission" and {*key.path} & {*COURSES}:
            return [warmed(tree) for tree in known(key)]
        return [used(kind, tree) for tree in stated(kind, key)]

    assert len(keys) > 4
    assert unmoved(keys, judged) == []


@pytest.mark.parametrize("kind", WHOLE)
def test_a_key_of_the_use_in_the_table_moves_none(kind):
    """Words beside a temperature, a vibration or an age change no verdict."""
    keys = choices(kind, moving=False, of_use=True)
    for key in keys:
        before, after = (used(kind, tree) for tree in stated(kind, key))
        assert not differ(before, after), str(key)
    assert len(keys) > 3


def limited_flight(key):
    """Return a requirement on a mission without a key, and with it."""
    kinds = {"position": "50 m", "velocity": "5 m/s"}
    quantity, word = key.path[2], key.path[-1]
    size = kinds.get(quantity, "50 arcsec")
    own = {"horizontal" if quantity in kinds else "limit": size, "at": "60 s"}
    other = own | {word: {"at": "70 s", "probability": "80 %"}.get(word, f"1{size}")}
    if word not in {"at", "probability"}:
        own, other = (
            {word: one[word], "at": "60 s"} for one in (own | {word: size}, other)
        )
    return tuple(
        {"limits": {"mission": {quantity: [one] if "[]" in key.path else one}}}
        for one in (own, other)
    )


# Two constants: what limits on a mission are compared with has to be small, not real.
FLYING = {
    "name": "x",
    **{
        sensor: {"errors": {"bias_repeatability": f"10 {unit}"}}
        for sensor, unit in BIASES.items()
    },
}


def compared(requirement):
    """Return the document of `budget compare` by the law; of `report` for both."""
    if "mission" in requirement["limits"]:
        wanted = budget.load_requirement({"name": "x", **requirement})
        said = repr(facts(wanted))  # a list of one limit says what the limit says
        if said not in FOUND:
            judged = budget.analyze(
                load_device(FLYING), requirement=wanted, mission=FLIGHT, validate=False
            )
            FOUND[said] = {"devices": judged.assessment.to_dict()}
        return FOUND[said]
    if "misalignment" in requirement["limits"]:
        wanted = budget.load_requirement({"name": "x", **requirement})
        judged = budget.analyze(
            budget.load_device("zhao-2019"),
            requirement=wanted,
            coverage=wanted.coverage,
            reference=wanted.reference,
            validate=False,
        )
        return {"devices": judged.assessment.to_dict()}
    tree = {"name": "x", "price": "90 EUR", "mass": "9 kg", "power": "9 W"}
    for sensor in requirement["limits"]:
        errors = {
            line.name: f"10 {line.like(sensor)}"
            for line in lines_of(sensor)
            if line.name in {"bias_stability", "bias_repeatability"}
        }
        tree[sensor] = {"errors": errors}
    one = load_device(tree)
    wanted = budget.load_requirement({"name": "x", **requirement})
    tumbled = any(limit.output.quantity in ORDERS for limit in wanted.limits)
    plan = budget.load_procedure("dividing-head") if tumbled else PAPER
    return budget.compare([one], wanted, [plan], method="gum").to_dict()


def judged_by(key):
    """Return the numbers of a comparison without a key of its limits, and with it."""
    # Each axis is within this by 6 %, all three together are not.
    tree = {"limits": {"gyro": {"bias": "32 deg/h"}}}
    if key.path[0] == "limits" and key.path[1] != "mission":
        tree = replaced({}, key.path, example(key).replace("7", "9", 1))
    if key.path[:2] == ("limits", "mission"):
        return tuple(numbers(compared(one)["devices"]) for one in limited_flight(key))
    before = numbers(once(compared, tree)["devices"])
    # One of the words is what an unset key stands for.
    for value in key.schema.get("enum", [example(key)]):
        after = numbers(compared(replaced(tree, key.path, value))["devices"])
        if differ(before, after):
            break
    return before, after


@by_line("requirement")
def test_a_key_of_a_requirement_moves_a_number(keys):
    """Utilisation, verdict or probability is another one with each key."""
    assert unmoved(keys, judged_by) == []


@pytest.mark.parametrize("key", choices("requirement", moving=False), ids=str)
def test_a_key_of_a_requirement_in_the_table_is_printed(key):
    """No number moves, and the document of a comparison says what the key does."""
    tree = {"limits": {"gyro": {"bias": "30 deg/h"}}}
    caps = {"price": "2 EUR", "mass": "2 kg", "power": "2 W"}
    value = caps.get(key.path[-1], MARK)
    before = compared(tree)
    after = compared(replaced(tree, key.path, value))
    assert not differ(numbers(before["devices"]), numbers(after["devices"]))
    for document, shown in ((before, False), (after, True)):
        said = json.dumps([document["requirement"], document["devices"]])
        assert (value in said) == shown


@pytest.mark.parametrize(
    "keys",
    by_file(choices("procedure", moving=False), place_of),
    ids=lambda keys: str(keys[0]),
)
def test_keys_of_a_procedure_in_the_table_are_printed(keys):
    """A comparison says the procedure's name, an assumption a word beside a figure."""
    one = load_device(device(Key(("name",), {}))[0])
    tree, words = with_words(place_of(keys[0]), keys)
    procedure = budget.load_procedure(tree)
    if keys[0].path == ("name",):
        wanted = budget.load_requirement(
            {"name": "x", "limits": {"gyro": {"bias": "1 deg/h"}}}
        )
        document = budget.compare([one], wanted, [procedure], method="gum").to_dict()
        assert document["procedures"] == words
    else:
        document = budget.analyze(one, procedure=procedure, validate=False).to_dict()
        said = "".join(document["assumptions"])
        assert [word for word in words if word not in said] == []


# The segment that a key of a mission is tried in, where it needs others beside it.
BANK = {"bank": "coordinated", "roll_rate": "3 deg/s"}
SEGMENTS = {
    "stand": {"stand": "60 s"},
    "straight": {"straight": "60 s", "speed": "20 m/s", "heading": "0 deg"},
    "turn": {"turn": "90 deg", "rate": "3 deg/s"},
    "climb": {"climb": "60 s", "rate": "5 m/s"},
    "accelerate": {"accelerate": "60 s", "to": "20 m/s"},
    "bank": {"turn": "90 deg", "rate": "3 deg/s", **BANK},
}
OF_SEGMENTS = {
    **dict.fromkeys(("speed", "heading"), "straight"),
    "rate": "climb",
    "to": "accelerate",
    "repeat": "stand",
    "vibration": "stand",
    "bank": "turn",
    "roll_rate": "bank",
}


def going(key):
    """Return a mission without a key, and with it."""
    if is_of_aids(key):
        return with_aids(key)
    part = {"latitude": "45 deg", "segments": [SEGMENTS["turn"]]}
    if key.path[-1] in BANK:
        part["speed"] = "20 m/s"
    if key.path[1:2] == ("segments",):
        own = SEGMENTS[OF_SEGMENTS.get(key.path[-1], key.path[-1])]
        part["segments"] = [{"segments": [own]} if len(key.path) > 4 else own]
    if key.path[-1] == "vibration":
        tree = {"mission": part, "environment": {"vibration": "1 g"}}
        return tree, replaced(tree, steps_of(key), "2 g")
    if key.path[-1] == "alignment_time":
        part |= {"alignment": "self", "alignment_time": "300 s"}
    tree = {"mission": part}
    after = replaced(tree, steps_of(key), example(key))
    if key.path[-1] == "trajectory":
        after = {"mission": {"trajectory": str(ROOT / "tests" / "data" / "flight.csv")}}
    if key.path[-1] == "alignment":
        after["mission"]["alignment_time"] = "300 s"
    if key.path[-1] == "bank":
        after = replaced(tree, steps_of(key), "coordinated")
        after = replaced(after, (*steps_of(key)[:-1], "roll_rate"), "3 deg/s")
    return tree, after


# A mission that says all of its aids once; the vehicle stands, then moves.
AIDS = {
    "gnss": {
        "position": {"value": "2.5 m"},
        "velocity": {"value": "0.05 m/s"},
        "position_drift": {"value": "3 m", "correlation_time": "60 s"},
        "rate": "0.5 Hz",
    },
    "heading": {"value": "0.5 deg", "rate": "0.5 Hz"},
    "zero_velocity": {"value": "0.01 m/s", "rate": "0.5 Hz"},
    "odometer": {"value": "0.1 m/s", "rate": "0.5 Hz"},
}
OWN = {"estimates": ["gyro.bias"], "believes": {"gyro.bias_repeatability": "1 deg/s"}}


def is_of_aids(key):
    """Say whether a key is of aids, of a filter, or of how it is aligned."""
    of_alignment = key.path[1:2] == ("alignment",) and len(key.path) > 2
    return of_alignment or bool({"aiding", "filter"} & {*key.path})


def with_aids(key):
    """Return a mission with aids without a key, or with another value, and with it."""
    part = {
        "latitude": "45 deg",
        "altitude": "free",
        "alignment": {"position": "30 m", "level": "0.5 deg"},
        "aiding": AIDS,
        "segments": [
            {"segments": [{"stand": "20 s"}], "aiding": [*AIDS]},
            {"accelerate": "10 s", "to": "20 m/s"},
        ],
    }
    value = example(key)
    match key.path[1:]:
        case ("filter", *_):
            names = key.path[2:3] or ("estimates",)
            after = {**part, "filter": {name: OWN[name] for name in names}}
        case ("segments", *rest):
            one = {"stand": "20 s"}
            said = {**one, "aiding": ["gnss"]}
            named = {"straight": "10 s", "aiding": ["gnss", "heading", "odometer"]}
            zero = {"stand": "3 s", "aiding": "zero_velocity"}
            more = [{"accelerate": "10 s", "to": "20 m/s"}, named]
            is_inside = len(rest) > 2
            first, then = (
                {"segments": [line]} if is_inside else line for line in (one, said)
            )
            part["segments"] = [zero, first, *more]
            after = {**part, "segments": [zero, then, *more]}
        case (*_, "during"):
            track = str(ROOT / "tests" / "data" / "standing.csv")
            own = AIDS[key.path[2]]
            part = {"trajectory": track, "at": ["60 s"]}
            part["aiding"] = {
                key.path[2]: {**own, "during": [["0 s", "9 s"], ["20 s", "30 s"]]}
            }
            after = replaced({"mission": part}, key.path[:4], [["0 s", "9 s"]])
            return {"mission": part}, after
        case _:
            if "meaning" in key.path:
                value = "CEP"
            tree = {"mission": part}
            return tree, replaced(tree, steps_of(key), value)
    return {"mission": part}, {"mission": after}


def carried(one):
    """Return what constants and noise of the gyros and accelerometers become."""
    sensors = (paper_gyro(), paper_accelerometer())
    journey = journey_of(one, one.at, sensors, uncalibrated("factory"))
    noise = AxisNoise(row=0, noise=Markov(times=(300.0,)), u=1.0)
    found = [journey.of_constants(lambda _: np.eye(6)), journey.of_noise([noise])]
    found += [C for _, C in of_aiding(journey)]
    return [number for part in found for number in part.ravel().tolist()]


@by_line("mission")
def test_a_key_of_a_mission_moves_a_number(keys):
    """Errors of position, velocity or attitude are other ones with each key."""

    def flown(key):
        if key.path[-1] == "vibration":
            return [warmed(tree) for tree in going(key)]
        return [carried(budget.load_mission(one)) for one in going(key)]

    assert unmoved(keys, flown) == []


@pytest.mark.parametrize("key", choices("mission", moving=False), ids=str)
def test_a_key_of_a_mission_in_the_table_moves_none(key):
    """The name is another one, the longitude is said; the rest is what it was."""
    before, after = map(budget.load_mission, going(key))
    assert (after.name == MARK) == (key.path == ("name",))
    is_placed = after.route.start.longitude is not None
    assert is_placed == (key.path[-1] == "longitude")
    start = replace(after.route.start, longitude=None)
    after = replace(after, route=replace(after.route, start=start))
    assert facts(replace(before, name="")) == facts(replace(after, name=""))


def paid_for(key):
    """Return the numbers of an allocation without a key of the costs, and with it."""
    trees = {"a": 1}, {"a": 1, key.path[-1]: example(key)}
    return tuple(once(allocated, {key.path[1]: part}) for part in trees)


def allocated(costs):
    """Return what a line may be and what it costs: the costs of that line."""
    ((place, _),) = costs.items()
    sensor, name = place.split(".")
    lines = {line.name: line.like(sensor) for line in lines_of(sensor)}
    other = "bias_repeatability" if name != "bias_repeatability" else "sample_noise"
    errors: dict = {one: f"10 {lines[one]}" for one in (name, other)}
    if name in AGEING.values():
        errors[name] = {"value": errors[name], "horizon": "1 year"}
    one = load_device({"name": "x", sensor: {"errors": errors}})
    bias = lines["bias_repeatability"]
    limits = {
        "scale_factor": "5 ppm",
        "mounting_angle": "5 arcsec",
        "bias": f"5 {bias}",
    }
    wanted = budget.load_requirement({"name": "x", "limits": {sensor: limits}})
    document = allocate(
        one,
        requirement=wanted,
        procedure=PAPER,
        costs=load_costs({"costs": costs}),
        catalogue=(),
        validate=False,
    ).to_dict()
    return numbers([document["sources"], document["costs"]])


@by_line("costs")
def test_a_key_of_costs_moves_a_number(keys, monkeypatch):
    """What the lines may be, or what they cost, is another one with each key."""
    # A longer procedure is searched for with a hundred trials, and not asked for here.
    module = "budget.studies.allocation.allocate"
    monkeypatch.setattr(f"{module}.find_longer_tests", lambda *_, **__: ())
    assert unmoved(keys, paid_for) == []


def test_the_walk_finds_the_keys_it_is_there_for():
    """Keys of every depth and form are among those tried, so none is left out."""
    found = {kind: {str(key) for key in keys} for kind, keys in KEYS.items()}
    assert {
        *("name", "gravity_unit", "figures.[].meaning", "variants.*.mass"),
        *("gyro.nominal.mounting_angle.zy", "gyro.errors.angle_random_walk"),
        *("accelerometer.errors.bias_stability.axes.x.correlation_time",),
        *("variants.*.gyro.errors.mounting_repeatability.axes.xy.source",),
    } <= found["device"]
    assert {"gravity", "gyro.azimuths", "accelerometer.pause"} <= found["procedure"]
    assert {"limits.gyro.bias", "limits.gyro.bias.z", "caps.mass"} <= found[
        "requirement"
    ]
    assert "costs.gyro.bias_stability.u_ref" in found["costs"]


def test_a_key_that_did_nothing_would_be_found():
    """Control: the measure sees no change where there is none."""
    tree, _ = device(Key(("gyro", "errors", "sample_noise", "value"), {"type": ""}))
    one, same = load_device(tree), load_device({**tree, "notes": "n"})
    assert not differ(analyzed(one), analyzed(same))
    with pytest.raises(SpecError, match="unknown key"):
        load_device({**tree, "bias": "1 deg/h"})


def test_the_table_of_the_docs_has_no_key_that_is_not_there():
    """Each word of the table is a key of some file, so that no row is stale."""
    known = {step for keys in KEYS.values() for key in keys for step in key.path}
    listed = {word for _, words in TABLE for word in words}
    assert listed - known == {"normal", "input"}  # what the one word is
