"""Bad files: each is refused at its place, in words, and never in another way."""

from __future__ import annotations

import re
from unittest.mock import patch

import pytest
import yaml
from places import put

from budget.errors import SpecError
from budget.inputs import composer, load_device, load_procedure, validate
from budget.inputs.checking import nearest
from budget.inputs.composer import compose
from budget.inputs.load import load_costs
from budget.inputs.reader import read
from budget.resources import shipped

GYRO = "name: x\ngyro:\n  errors:\n"
LIMITS = "name: x\nlimits:\n"

# Text of the file, place of the issue, words of its message.
BAD = {
    "empty": ("", "1:1", "the file is empty"),
    "blank": (" \n\n", "1:1", "the file is empty"),
    "comments only": ("# nothing\n", "1:1", "the file is empty"),
    "no mapping": ("just text\n", "1:1", "'just text', expected a mapping"),
    "a list": ("- gyro\n", "1:1", "a list, expected a mapping"),
    "unknown kind": ("name: x\n", "1:1", "no known kind"),
    "syntax": ("name: x\ngyro: {errors: }}\n", "2:17", "no YAML"),
    "colon in text": ("name: a: b\ngyro: {}\n", "1:8", "no YAML|quotes"),
    "tab": ("name: x\ngyro:\n\terrors: {}\n", "3:1", "no YAML"),
    "bad indentation": ("name: x\ngyro:\n   a: 1\n  b: 2\n", "4:3", "no YAML"),
    "bad escape": ('name: "\\q"\n', "1:8", "no YAML"),
    "escape beyond Unicode": ('name: "\\U00110000"\n', "1:10", "no YAML"),
    "two documents": ("name: x\ngyro: {}\n---\nname: y\n", "3:1", "second document"),
    "directive": ("%YAML 1.1\n---\nname: x\ngyro: {}\n", "1:1", "directive"),
    "NUL": ("name: x\ngyro: {}\nnotes: a\0b\n", "3:9", r"U\+0000"),
    "mark inside": ("name: x\ngyro: {}\nnotes: a\ufeffb\n", "3:9", r"U\+FEFF"),
    "line separator": ("name: a\u2028b\ngyro: {}\n", "1:8", r"U\+2028"),
    "reordering mark": ("name: a\u202eb\ngyro: {}\n", "1:8", r"U\+202E"),
    "escaped control": ('name: "a\\x1b"\ngyro: {}\n', "1:7", r"U\+001B"),
    "escaped surrogate": ('name: "\\ud800"\ngyro: {}\n', "1:10", "no YAML"),
    "line break in a name": ('name: "a\\nb"\ngyro: {}\n', "1:7", "one line"),
    "duplicate key": ("name: x\nname: y\ngyro: {}\n", "2:1", "duplicate key.*1:1"),
    "duplicate line": (
        GYRO + "    sample_noise: 1 deg/h\n    sample_noise: 2 deg/h\n",
        "5:5",
        "duplicate key",
    ),
    "alias": ("name: &n x\ngyro: {}\nnotes: *n\n", "3:8", "alias 'n'"),
    "anchor": ("name: &n x\ngyro: {}\n", "1:7", "anchor 'n'; remove it"),
    "tag": ("name: !!str x\ngyro: {}\n", "1:7", "tag .*; remove it"),
    "python tag": ("name: !!python/name:os.system x\ngyro: {}\n", "1:7", "tag"),
    "merge key": ("name: x\ngyro: {}\n<<: {}\n", "3:1", "unknown key '<<'"),
    "list as a key": ("name: x\ngyro: {}\n? [a]\n: b\n", "3:3", "key is no word"),
    "empty value": ("name: x\ngyro:\n", "2:1", "is empty"),
    "null": ("name: x\ngyro: {errors: null}\n", "2:16", "is empty"),
    "unknown key": ("name: x\ngyr: {}\ngyro: {}\n", "2:1", "did you mean 'gyro'"),
    "unknown line": (
        GYRO + "    bias_stabilty: 1 deg/h\n",
        "4:5",
        "bias_repeatability, bias_stability, .*did you mean 'bias_stability'",
    ),
    "line of the other sensor": (
        GYRO + "    velocity_random_walk: 1 ug/sqrt(Hz)\n",
        "4:5",
        "unknown key.*did you mean 'angle_random_walk'",
    ),
    "line of the other sensor, accelerometer": (
        "name: x\naccelerometer: {errors: {angle_random_walk: 1 deg/sqrt(h)}}\n",
        "2:26",
        "did you mean 'velocity_random_walk'",
    ),
    "line of one sensor only": (
        "name: x\naccelerometer: {errors: {g_sensitivity: 1 deg/h/g}}\n",
        "2:26",
        "initial_mounting$",
    ),
    "another number of sigmas": (
        GYRO + "    sample_noise: {value: 1 deg/h, meaning: 4 sigma}\n",
        "4:45",
        "or 'exact'; what makers mean: docs/datasheets.md#what-a-value-means$",
    ),
    "another shape": (
        GYRO + "    bias_repeatability: {value: 1 deg/h, distribution: lognormal}\n",
        "4:56",
        "or 'arcsine'$",
    ),
    "a bound in the text": (
        GYRO + "    angle_random_walk: 0.012 deg/sqrt(h) max\n",
        "4:24",
        r"\{value: 0.012 deg/sqrt\(h\), meaning: max\}",
    ),
    "correlation time of a constant": (
        GYRO + "    bias_repeatability: {value: 1 deg/h, correlation_time: 1 s}\n",
        "4:42",
        "unknown key 'correlation_time'",
    ),
    "missing name": ("gyro: {}\n", "1:1", "'name' is missing"),
    "no sensor": ("name: x\nvariants: {}\ngyro: 5\n", "3:7", "found 5, expected a map"),
    "number for a name": ("name: 1521\ngyro: {}\n", "1:7", "found 1521, .*quotes"),
    "blank name": ("name: ' '\ngyro: {}\n", "1:7", "blank"),
    "long name": (f"name: {'x' * 201}\ngyro: {{}}\n", "1:7", "at most 200"),
    "no unit": (
        GYRO + "    sample_noise: 0.5\n",
        "4:19",
        r"without a unit, expected an angular rate \(deg/h",
    ),
    "small no unit": (GYRO + "    sample_noise: 1e-6\n", "4:19", "without a unit"),
    "text no unit": (GYRO + "    sample_noise: '5'\n", "4:19", "without a unit"),
    "wrong unit": (GYRO + "    sample_noise: 5 ug\n", "4:19", "which is an accel"),
    "rate as an angle": (
        GYRO + "    bias_stability: 0.5 deg\n",
        "4:21",
        r"an angle, expected an angular rate \(deg/h, deg/s",
    ),
    "unknown unit": (GYRO + "    sample_noise: 5 dgr/h\n", "4:19", "no known unit"),
    "decimal comma": (GYRO + "    sample_noise: 1,5 deg/h\n", "4:19", "'1.5 deg/h'"),
    "underscore": (GYRO + "    sample_noise: 1_000 deg/h\n", "4:19", "'1000 deg/h'"),
    "leading zero": (GYRO + "    sample_noise: 010 deg/h\n", "4:19", "'10 deg/h'"),
    "negative": (GYRO + "    sample_noise: -5 deg/h\n", "4:19", "not negative"),
    "not finite": (GYRO + "    sample_noise: .inf deg/h\n", "4:19", "no number"),
    "not a number": (GYRO + "    sample_noise: nan deg/h\n", "4:19", "no number"),
    "too large": (GYRO + "    sample_noise: 1e999 deg/h\n", "4:19", "that can be"),
    "too small": (GYRO + "    sample_noise: 1e-99 deg/h\n", "4:19", "that can be"),
    "list for a figure": (
        GYRO + "    sample_noise: [1 deg/h]\n",
        "4:19",
        "found a list",
    ),
    "word for a figure": (GYRO + "    sample_noise: true\n", "4:19", "found true, exp"),
    "figure without value": (GYRO + "    sample_noise: {}\n", "4:19", "neither value"),
    "axes not all named": (
        GYRO + "    sample_noise: {axes: {x: 1 deg/h}}\n",
        "4:26",
        "missing: y, z",
    ),
    "wrong axis": (
        GYRO + "    sample_noise: {value: 1 deg/h, axes: {xy: 1 deg/h}}\n",
        "4:43",
        "unknown key 'xy', allowed: x, y, z",
    ),
    "wrong meaning": (
        GYRO + "    sample_noise: {value: 1 deg/h, meaning: 3 sigmas}\n",
        "4:45",
        "did you mean '3 sigma'",
    ),
    "normal half-width": (
        GYRO + "    bias_repeatability: {value: 1 deg/h, meaning: max, "
        "distribution: normal}\n",
        "4:70",
        "a half-width; expected uniform",
    ),
    "uniform process": (
        GYRO + "    sample_noise: {value: 1 deg/h, distribution: uniform}\n",
        "4:50",
        "found 'uniform', expected 'normal'",
    ),
    "Allan minimum of 3 sigma": (
        GYRO + "    bias_stability: {value: 1 deg/h, meaning: 3 sigma, "
        "definition: allan_minimum}\n",
        "4:68",
        "1 sigma",
    ),
    "no correlation": (
        GYRO + "    bias_stability: {value: 1 deg/h, correlation_time: 0 s}\n",
        "4:56",
        "positive",
    ),
    "abstract no": ("name: x\nabstract: no\ngyro: {}\n", "2:11", "did you mean false"),
    "abstract alone": ("name: x\nabstract: true\ngyro: {}\n", "1:1", "no variants"),
    "variants list": ("name: x\ngyro: {}\nvariants: [a]\n", "3:11", "found a list"),
    "variant text": ("name: x\ngyro: {}\nvariants: {A: b}\n", "3:15", "found 'b'"),
    "variant name": (
        "name: x\ngyro: {}\nvariants: {'A#': {}}\n",
        "3:12",
        "without '#'",
    ),
    "variant of a variant": (
        "name: x\ngyro: {}\nvariants: {A: {variants: {}}}\n",
        "3:16",
        "base only",
    ),
    "mistake in a variant": (
        "name: x\ngyro: {}\nvariants:\n  A: {gyro: {errors: {sample_noise: 1 deg}}}\n",
        "4:37",
        "variants.A.gyro.errors.sample_noise: .*an angle",
    ),
    "figure entry": (
        "name: x\ngyro: {}\nfigures: [{name: bandwidth, value: 200}]\n",
        "3:36",
        "found 200, expected text; put it in quotes",
    ),
    "format of another kind": (
        "format: budget-procedure/1\nname: x\ngyro: {}\n",
        "1:9",
        "expected 'budget-device/1'",
    ),
    "newer format": (
        "format: budget-device/2\nname: x\ngyro: {}\n",
        "1:9",
        "needs budget >= 2",
    ),
    "gravity unit": ("name: x\ngyro: {}\ngravity_unit: 9.81 m/s\n", "3:15", "m/s"),
    "gravity typo": ("name: x\ngyro: {}\ngravity_unit: 980 m/s^2\n", "3:15", "9.5 to"),
    "half a turn": ("latitude: 0 deg\ngyro: {turns: 0.5}\n", "2:15", "whole number"),
    "no turn": ("latitude: 0 deg\ngyro: {turns: 0}\n", "2:15", "expected 1 or more"),
    "octal turns": ("latitude: 0 deg\ngyro: {turns: 010}\n", "2:15", "did you mean 10"),
    "turns with _": ("latitude: 0 deg\ngyro: {turns: 1_000}\n", "2:15", "mean 1000"),
    "turns with unit": (
        "latitude: 0 deg\ngyro: {turns: 1 s}\n",
        "2:15",
        "whole number",
    ),
    "beyond the pole": ("latitude: 91 deg\n", "1:11", "-90 deg to 90 deg"),
    "bare latitude": ("latitude: 34.2394\n", "1:11", "without a unit"),
    "gravity word": ("gravity: earth\n", "1:10", "'normal' or an acceleration"),
    "no rate": ("gyro: {rate: 0 deg/s}\n", "1:14", "positive"),
    "negative pause": ("accelerometer: {pause: -1 s}\n", "1:24", "not negative"),
    "order twice": ("gyro: {order: [z, z, y]}\n", "1:15", "each of x, y, z once"),
    "order of what": ("gyro: {order: [z, w, y]}\n", "1:19", "found 'w'"),
    "no azimuth": ("gyro: {azimuths: []}\n", "1:18", "one at least"),
    "azimuths alone": ("gyro: {azimuths: 0 deg}\n", "1:18", "expected a list"),
    "dwell without sample": (
        "sample_rate: 1 Hz\ngyro: {dwell: 0.5 s}\n",
        "2:15",
        "has no sample",
    ),
    "turn without sample": (
        "sample_rate: 1 Hz\ngyro: {rate: 720 deg/s}\n",
        "2:14",
        "a turn of 0.5 s has no sample",
    ),
    "formulas": ("formulas: Papr\n", "1:11", "did you mean 'paper'"),
    "no limits": (LIMITS + "  gyro: {}\n", "3:3", "names no limit"),
    "zero limit": (LIMITS + "  gyro: {bias: 0 deg/h}\n", "3:16", "positive"),
    "limit of nothing": (LIMITS + "  gyro: {noise: 1 ppm}\n", "3:10", "unknown key"),
    "coverage": (
        "name: x\ncoverage: 100 %\nlimits: {gyro: {bias: 1 deg/h}}\n",
        "2:11",
        "from 1e-6 to 1 - 1e-12",
    ),
    "bare coverage": (
        "name: x\ncoverage: 0.95\nlimits: {gyro: {bias: 1 deg/h}}\n",
        "2:11",
        "without a unit",
    ),
    "reference": (
        "name: x\nreference: next\nlimits: {gyro: {bias: 1 deg/h}}\n",
        "2:12",
        "'next_turn_on'",
    ),
    "cost of nothing": ("costs: {gyro.bias: {a: 1}}\n", "1:9", "unknown key"),
    "free": (
        "costs: {gyro.bias_stability: {a: 0}}\n",
        "1:34",
        "expected 1e-12 or more",
    ),
    "infinite": (
        "costs: {gyro.bias_stability: {a: .inf}}\n",
        "1:34",
        "expected a numb",
    ),
    "u_ref": (
        "costs: {gyro.bias_stability: {u_ref: 1 ug}}\n",
        "1:38",
        "an angular rate",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_is_refused_at_its_place(case, tmp_path):
    """A mistake is reported at its line and column, in words that name it."""
    text, place, words = BAD[case]
    path = tmp_path / "bad.yaml"
    path.write_bytes(text.encode())
    with pytest.raises(SpecError) as caught:
        validate(path)
    lines = str(caught.value).splitlines()
    at = [line for line in lines if line.startswith(f"{path}:{place}: ")]
    assert at, lines
    assert re.search(words, "\n".join(at)), at


BYTES = {
    "not UTF-8": (
        b"name: x\ngyro: {}\nvendor: M\xfcller\n",
        "3:10",
        "0xfc is not UTF-8",
    ),
    "UTF-16": ("name: x\n".encode("utf-16"), "1:1", "is not UTF-8"),
    "too large": (b"#" * 65_537, "1:1", "larger than 65536 bytes"),
}


@pytest.mark.parametrize("case", BYTES)
def test_bytes_that_are_no_text_are_refused(case, tmp_path):
    """A file that is no UTF-8, or too large, is refused before it is parsed."""
    data, place, words = BYTES[case]
    path = tmp_path / "bad.yaml"
    path.write_bytes(data)
    with pytest.raises(SpecError, match=words) as caught:
        validate(path)
    assert str(caught.value).startswith(f"{path}:{place}: ")


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    """A mark that an editor puts before UTF-8 is skipped and shifts no column."""
    path = tmp_path / "marked.yaml"
    path.write_bytes(b"\xef\xbb\xbfname: 5\ngyro: {}\n")
    with pytest.raises(SpecError) as caught:
        validate(path)
    assert str(caught.value).startswith(f"{path}:1:7: name: ")
    path.write_bytes(b"\xef\xbb\xbfname: x\ngyro: {}\n")
    assert load_device(path).name == "x"


def test_line_breaks_of_other_systems_count_as_one(tmp_path):
    """A file with CR LF has the lines that an editor shows."""
    path = tmp_path / "dos.yaml"
    path.write_bytes(b"name: x\r\ngyro:\r\n  errors: 5\r\n")
    with pytest.raises(SpecError, match=r":3:11: gyro.errors: "):
        validate(path)


def test_all_issues_come_at_once_in_the_order_of_the_file(tmp_path):
    """YAML slips, unknown keys, units and contradictions are reported together."""
    path = put(
        tmp_path / "bad.yaml",
        "name: !!str x\n"
        "nam: y\n"
        "gyro:\n"
        "  errors:\n"
        "    bias_stability: {value: 1 deg, correlation_time: 5}\n"
        "    sample_noise: {value: 1 deg/h, distribution: uniform}\n"
        "    sample_noise: 2 deg/h\n"
        "accelerometer:\n"
        "  errors: {bias_repeatability: {value: 1 ug, meaning: max, "
        "distribution: normal}}\n",
    )
    with pytest.raises(SpecError) as caught:
        validate(path)
    places = [(issue.line, issue.field) for issue in caught.value.issues]
    assert places == [
        (1, "name"),
        (2, "nam"),
        (5, "gyro.errors.bias_stability.value"),
        (5, "gyro.errors.bias_stability.correlation_time"),
        (6, "gyro.errors.sample_noise.distribution"),
        (7, "gyro.errors.sample_noise"),
        (9, "accelerometer.errors.bias_repeatability.distribution"),
    ]
    assert {issue.file for issue in caught.value.issues} == {str(path)}


def test_without_the_library_in_c_files_read_the_same(monkeypatch):
    """Its parser in Python finds the same nodes and places, and refuses alike."""
    paths = sorted(shipped("specs").rglob("*.yaml"), key=lambda path: path.name)[::12]
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert len(texts) > 5
    by_c = [compose(text, "file.yaml") for text in texts]
    monkeypatch.setattr(composer, "LOADER", yaml.SafeLoader)
    assert [compose(text, "file.yaml") for text in texts] == by_c
    for escape in ("\\q", "\\UFFFFFFFF"):
        with pytest.raises(SpecError, match=r"^file.yaml:1:.*is no YAML"):
            compose(f'name: "{escape}"', "file.yaml")


def test_a_tab_after_a_colon_is_a_space():
    """YAML 1.2 lets tabs part a key from its value; no editor shows the difference."""
    assert compose("name:\tx\t# y", "file.yaml") == compose("name: x # y", "file.yaml")


def test_what_is_no_sound_yaml_is_reported_once(tmp_path):
    """An alias leaves no value behind, and no second message about that."""
    path = put(tmp_path / "bad.yaml", "name: *a\ngyro: {}\n")
    with pytest.raises(SpecError) as caught:
        validate(path)
    assert len(caught.value.issues) == 1


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("absent.yaml", "no such file"),
        ("zhao2019", "did you mean 'zhao-2019'"),
        ("nul\0.yaml", "no such file"),
        ("x" * 5000, "no such file"),
        (".", "is a folder"),
    ],
)
def test_a_file_that_is_none_is_refused(name, words):
    """A name without a file behind it is an issue of that name, as it was typed."""
    with pytest.raises(SpecError, match=words) as caught:
        load_device(name)
    assert str(caught.value).startswith(f"{name}:1:1: ")


def test_a_file_of_another_kind_names_the_key_that_says_so(tmp_path):
    """A procedure given as a device is refused at the key that makes it one."""
    path = put(tmp_path / "procedure.yaml", "name: x\ngyro: {dwell: 5 s}\n")
    with pytest.raises(SpecError, match=r":2:8: gyro.dwell: .*a procedure file, exp"):
        load_device(path)
    with pytest.raises(SpecError, match="a device file, expected a procedure file"):
        load_procedure(shipped("specs") / "devices" / "zhao-2019.yaml")


def test_the_same_bytes_are_parsed_once_and_others_again(tmp_path):
    """A file that is named again costs no parser; one that was written anew does."""
    path = put(tmp_path / "d.yaml", "name: first\ngyro: {}\n")
    with patch("budget.inputs.reader.compose", wraps=compose) as composed:
        assert load_device(path).name == load_device(path).name == "first"
        path.write_text("name: second\ngyro: {}\n", encoding="utf-8")
        assert load_device(path).name == "second"
    assert composed.call_count == 2


def test_who_loads_a_device_again_has_a_record_of_his_own():
    """What is written into the arrays of one is in no other."""
    first, again = load_device("zhao-2019"), load_device("zhao-2019")
    bias = first.gyro.nominal_bias.copy()
    first.gyro.nominal_bias[:] = 7.0
    first.gyro.lines[0].u[:] = 7.0
    for other in (again, load_device("zhao-2019")):
        assert other.gyro is not first.gyro
        assert (other.gyro.nominal_bias == bias).all()
        assert not (other.gyro.lines[0].u == 7.0).any()


def test_no_shipped_file_drives_another_out(tmp_path):
    """All that ships is parsed once, read in order again and again, and more beside."""
    own = [tmp_path / f"{number}.yaml" for number in range(100)]
    for path in own:
        path.write_text(f"name: own {path.stem}\ngyro: {{}}\n", encoding="utf-8")
    files = [*sorted(shipped("specs").rglob("*.yaml")), *own]
    for path in files:
        read(path, str(path))
    with patch("budget.inputs.reader.compose") as composed:
        for path in files:
            read(path, str(path))
    assert not composed.called


def test_a_word_of_a_fixed_list_may_stand_in_capitals(tmp_path):
    """It is understood, at any depth; what else is wrong is said as ever."""
    text = (
        "name: x\ngyro: {errors: {bias_stability: {value: 1 deg/h, meaning: MAX, "
        "distribution: Normal}, angle_random_walk: {value: 1 deg/sqrt(h), "
        "meaning: %s}}}\n"
    )
    (tmp_path / "a.yaml").write_text(text % "Max", encoding="utf-8")
    (tmp_path / "b.yaml").write_text(text.lower() % "max", encoding="utf-8")
    (tmp_path / "c.yaml").write_text(text % "MAXI", encoding="utf-8")
    a, b = (load_device(tmp_path / name) for name in ("a.yaml", "b.yaml"))
    assert [one.u.tolist() for one in a.sensors[0].lines] == [
        one.u.tolist() for one in b.sensors[0].lines
    ]
    with pytest.raises(SpecError) as error:
        load_device(tmp_path / "c.yaml")
    (issue,) = error.value.issues
    assert "found 'MAXI'" in issue.message


@pytest.mark.parametrize("allowed", [("alpha",), ("alpha", "ALPHA")])
def test_no_hint_proposes_what_stands_there(allowed):
    """What was written is no word that could have been meant."""
    assert "'alpha'" not in nearest("alpha", allowed)
    assert "did you mean 'alpha'?" in nearest("alphb", ("alpha",))


def test_bounds_are_in_words_of_our_own(tmp_path):
    """A list that is too short or a number too large: no word of the library's."""
    costs = "costs: {gyro.bias_stability: {a: 1e99, p: -1}}\n"
    (tmp_path / "c.yaml").write_text(costs, encoding="utf-8")
    with pytest.raises(SpecError) as error:
        load_costs(tmp_path / "c.yaml")
    said = str(error.value).lower()
    assert "or less" in said
    assert "or more" in said
    assert not re.search("input should|should have|value error", said)
