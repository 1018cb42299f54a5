"""No file costs more than 80 calls a byte or 200 MB, whatever its contents."""

from __future__ import annotations

import json
import subprocess
import sys
from functools import cache
from itertools import product
from pathlib import Path

import pytest
from places import put

COST = Path(__file__).parent / "cost.py"
CAP = 64 * 1024  # bytes of a file
# Calls of functions; the dearest file (deep flow lists) needs 2.7 million, which take
# 0.8 s of one core. What is quadratic in 64 KiB takes a thousand times the bound.
MOST_STEPS = 80 * CAP
MOST_BYTES = 200e6  # of the whole process

NODES = 5_000
LEVELS = 20
MOST_ISSUES = 100

DEVICE = "name: x\ngyro: {errors: {sample_noise: 1 deg/h}}\n"
ERRORS = "name: x\ngyro:\n  errors:\n"


def padded(text, size):
    """Return a text with a comment after it that fills it up to a size."""
    return text + "#" * (size - len(text))


def laughs(width, depth):
    """Return lists of aliases of lists of aliases: width to the depth leaves."""
    lines = [f"a0: &a0 [{','.join(['x'] * width)}]"]
    lines += [
        f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * width)}]" for i in range(1, depth)
    ]
    return "\n".join(lines)


def figures(count):
    """Return a device with that many figures that no model uses."""
    entries = ", ".join("{name: n, value: v}" for _ in range(count))
    return f"{DEVICE}figures: [{entries}]\n"


# A thousand units of an angle, no two alike.
ANGLES = [
    f"1 deg*{a}/{a}*{b}/{b}*{c}/{c}"
    for a, b, c in product(
        ("s", "h", "m", "g", "ft", "ms", "ng", "ug", "mg", "Hz"), repeat=3
    )
]


def variant(number):
    """Return overrides of nine figures in nine units that no other variant has."""
    units = iter(ANGLES[9 * number :])
    lines = ("bias_repeatability", "bias_stability", "sample_noise")
    axes = "{{axes: {{x: {}/s, y: {}/s, z: {}/s}}}}"
    figures = [
        f"{line}: {axes.format(next(units), next(units), next(units))}"
        for line in lines
    ]
    return f"gyro: {{errors: {{{', '.join(figures)}}}}}"


@cache
def cases():
    """Return the texts of files by what they are.

    A file at a cap, or just below it, is read, or refused for what is in it; one above
    it is refused for the cap.
    """
    return {
        "at the cap of bytes": padded(DEVICE, CAP),
        "above the cap of bytes": padded(DEVICE, CAP + 1),
        "1e6 items in a flow list": "a: [" + "1," * 1_000_000 + "]",
        "1e6 items in a block list": "a:\n" + "- 1\n" * 1_000_000,
        "1e6 keys": "".join(f"k{i}: 1\n" for i in range(1_000_000)),
        "near the cap of nodes": figures(995),
        "above the cap of nodes": figures(1_005),
        "at the cap of levels": "{a: " * (LEVELS - 1) + "1" + "}" * (LEVELS - 1),
        "above the cap of levels": "{a: " * LEVELS + "1" + "}" * LEVELS,
        "deep flow lists": "[" * (CAP - 1),
        "deep flow mappings": "{a: " * (CAP // 4 - 1),
        "deep block lists": "- " * (CAP // 2 - 1),
        "deep keys": "? " * (CAP // 2 - 1),
        "deep indentation": "".join(f"{' ' * i}k:\n" for i in range(350)),
        "a long flow line of words": "a: [" + "x y z, " * 9_000 + "]",
        "a long flow line of numbers": "gyro: {azimuths: [" + "0 deg, " * 9_000 + "]}",
        "360 azimuths": "gyro: {azimuths: [" + "0deg," * 360 + "]}",
        "5000 azimuths": "gyro: {azimuths: [" + "0deg," * 4_980 + "]}",
        "as many wrong azimuths": "gyro: {azimuths: [" + "0 dge," * 4_980 + "]}",
        "different wrong units": "gyro: {azimuths: ["
        + ",".join(f"{i} d{i:x}" for i in range(4_000))
        + "]}",
        "different right units": f"gyro: {{azimuths: [{', '.join(ANGLES)}]}}",
        "variants in different units": f"name: x\n{variant(0)}\nvariants: {{"
        + ", ".join(f"v{i}: {{{variant(i)}}}" for i in range(50))
        + "}\n",
        "aliases of aliases": laughs(9, 30),
        "a wide alias": "a: &a " + "x" * 30_000 + "\nb: [" + "*a," * 9_000 + "]",
        "anchors": "a: [" + ",".join(f"&a{i} 1" for i in range(4_900)) + "]",
        "tags": "a: [" + "!!python/object:x 1," * 3_000 + "]",
        "merge keys": "<<: {" + ", ".join(f"k{i}: 1" for i in range(4_900)) + "}",
        "one key twice, often": "k: 1\n" * 2_400,
        "a key of 60 kB": "k" * 60_000 + ": 1",
        "a key of 60 kB below errors": ERRORS + "    " + "k" * 60_000 + ": 1 deg/h\n",
        "a quoted key of 60 kB": '"' + "k " * 30_000 + '": 1',
        "keys that are nearly right": ERRORS
        + "".join(f"    bias_stabilit{i}: 1 deg/h\n" for i in range(2_000)),
        "a number of 60 kB": ERRORS + f"    sample_noise: {'9' * 60_000}\n",
        "a number of 60 kB with a unit": ERRORS
        + f"    sample_noise: {'9' * 60_000} ug\n",
        "a unit of 60 kB": ERRORS + "    sample_noise: 1 " + "deg/" * 15_000 + "h\n",
        "blanks before a unit": ERRORS
        + "    sample_noise: '1"
        + " " * 60_000
        + "deg/h'\n",
        "roots of roots": ERRORS + "    sample_noise: 1 " + "sqrt(" * 12_000 + "h\n",
        "a text of 60 kB": f"name: {'x ' * 30_000}\ngyro: {{}}\n",
        "a folded text": "name: >\n" + "  x\n\n" * 12_000 + "gyro: {}\n",
        "a text in single quotes": "name: '" + "''" * 32_000 + "'\n",
        "escapes": 'name: "' + "\\x41" * 16_000 + '"\n',
        "escaped breaks": 'name: "' + "\\\n" * 32_000 + '"\n',
        "blank lines": "\n" * (CAP - 20) + DEVICE[:20],
        "comments": "#\n" * 30_000 + DEVICE,
        "comments behind keys": "k: # c\n" * 9_000,
        "tabs": "name:" + "\t" * 60_000 + "x\ngyro: {}\n",
        "documents": "---\n" * (CAP // 4),
        "ends of documents": "...\n" * (CAP // 4),
        "colons": ": " * (CAP // 2),
        "question marks": "? a\n" * (CAP // 4),
        "commas": "[" + "," * (CAP - 2) + "]",
        "quotes": "'\n" * (CAP // 2),
        "quotes on one line": '"" ' * (CAP // 3),
        "percent signs": "a\n%" * (CAP // 3),
        "characters beyond the first plane": "name: "
        + "\U0001f680" * 16_000
        + "\ngyro: {}",
        "a variant with everything": "name: x\ngyro: {}\nvariants:\n"
        + "".join(f"  v{i}: {{gyro: {{errors: {{}}}}}}\n" for i in range(50)),
        "variants with many figures": DEVICE
        + "figures: ["
        + "{name: n, value: v}, " * 900
        + "]\nvariants: {"
        + ", ".join(f"v{i}: {{}}" for i in range(50))
        + "}\n",
        "variants with many mistakes": DEVICE
        + "figures: ["
        + "{name: n, valeu: v}, " * 900
        + "]\nvariants: {"
        + ", ".join(f"v{i}: {{}}" for i in range(50))
        + "}\n",
        "many axes in variants": DEVICE
        + "variants:\n"
        + "".join(
            f"  v{i}: {{gyro: {{errors: {{sample_noise: {{axes: "
            "{x: 1 deg/h, y: {value: 2 deg/h, meaning: max}, z: 3 rad/s}}}}}\n"
            for i in range(50)
        ),
        "empty items": "-\n" * (CAP // 2),
        "a word of 64 kB": padded("name: ", CAP - 10).replace("#", "x"),
        "2000 variants": DEVICE
        + "variants: {"
        + ", ".join(f"v{i}: {{}}" for i in range(2_000))
        + "}\n",
        "mistakes in a device and its variants": "name: x\n"
        + "".join(f"k{i}: 1\n" for i in range(99))
        + "variants:\n"
        + "".join(
            f"  v{i}: {{gyro: {{errors: {{sample_noise: {i} k}}}}}}\n"
            for i in range(50)
        ),
        "costs": "costs: {" + ", ".join(f"k{i}: {{a: 1}}" for i in range(1_600)) + "}",
        "a mission of 10,000 segments": "mission: {latitude: 45 deg, segments: "
        "[{repeat: 100, segments: [{turn: 5 deg, rate: 1 deg/s, repeat: 100}]}]}",
        "limits": "name: x\nlimits: {"
        + ", ".join(f"k{i}: {{bias: 1 deg/h}}" for i in range(1_600))
        + "}",
    }


def costs(script, files):
    """Return what the check of each file costs, by file name, in one more process."""
    run = subprocess.run(
        [sys.executable, str(script), *map(str, files)],
        capture_output=True,
        text=True,
        check=True,
        timeout=3000,  # against hanging; they take a minute
    )
    found = [json.loads(line) for line in run.stdout.splitlines()]
    return {one["file"]: one for one in found}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return what every case costs."""
    folder = tmp_path_factory.mktemp("hostile")
    names = {case: folder / f"{number}.yaml" for number, case in enumerate(cases())}
    for case, path in names.items():
        path.write_text(cases()[case], encoding="utf-8", newline="")
    huge = folder / "huge.yaml"
    with huge.open("wb") as stream:
        stream.write(DEVICE.encode())
        stream.truncate(100_000_000)
    names |= {"100 MB": huge, "no end": Path("/dev/zero")}
    by_file = costs(COST, names.values())
    return {case: by_file[str(path)] for case, path in names.items()}


CAPS = {  # files at a cap, and how many issues they have
    "at the cap of bytes": 0,
    "above the cap of bytes": 1,
    "near the cap of nodes": 0,
    "above the cap of nodes": 1,
    "100 MB": 1,
    "no end": 1,
}


@pytest.mark.slow
def test_hostile_files_are_cheap(found):
    """Each takes few steps and less than 200 MB; those at a cap are read."""
    dear = {
        case: cost
        for case, cost in found.items()
        if cost["steps"] >= MOST_STEPS
        or cost["bytes"] >= MOST_BYTES
        or cost["issues"] > MOST_ISSUES + 1
    }
    assert dear == {}
    assert len(found) == len(cases()) + 2
    assert {case: found[case]["issues"] for case in CAPS} == CAPS


@pytest.mark.slow
def test_steps_and_memory_are_measured(tmp_path):
    """Control: a check that holds more and looks at all pairs of bytes is seen."""
    begins = "    held = b'x' * 250_000_000\n    for _ in range(6_000_000): len(held)\n"
    text = COST.read_text(encoding="utf-8")
    first = '    """Return how many issues a file has."""\n'
    assert first in text
    script = put(tmp_path / "greedy.py", text.replace(first, first + begins))
    (found,) = costs(script, ["zhao-2019"]).values()
    assert found["steps"] > MOST_STEPS
    assert found["bytes"] > MOST_BYTES


LONG = {
    "digits": "'9' * N",
    "digits and a unit": "'9' * N + ' ug'",
    "digits after a point": "'0.' + '9' * N + '!'",
    "exponents": "'1' + 'e1' * N",
    "blanks before a unit": "'1' + ' ' * N + 'deg/h'",
    "blanks between words": "'1 ' + 'a ' * N",
    "a unit": "'1 ' + 'deg/' * N + 'h'",
    "roots of roots": "'1 ' + 'sqrt(' * N + 'h'",
    "parentheses": "'1 ' + '(' * N + ')' * N",
}


@pytest.mark.slow
def test_a_text_is_read_in_linear_time():
    """A million characters as a quantity are refused: no pattern tries all pairs.

    What is written in C makes no calls to be counted. In linear time these texts take a
    second, in quadratic time hours, so the patience decides on no machine.
    """
    code = (
        "from budget.errors import UnitError\n"
        "from budget.units import parse_quantity\n"
        "N = 1_000_000\n"
        f"for text in ({', '.join(LONG.values())}):\n"
        "    try:\n        parse_quantity(text, 'deg/h')\n"
        "    except UnitError:\n"
        "        print('refused')\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    assert run.stdout.split() == ["refused"] * len(LONG)
