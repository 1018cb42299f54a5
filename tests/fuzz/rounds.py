"""Mutated files, command lines and exports at random: words or a result, no fault.

    python tests/fuzz/rounds.py files|lines|exports SEED RUNS [FIRST]

Hostile rounds by hand or at night, in one process. Run k depends on the seed and k
alone: with RUNS 1 and FIRST k it is repeated. It prints each run that is not as it
should be, each that takes long, and at the end how many were run, with the seed, and
their codes. It ends with 1 where there is a fault.
"""

from __future__ import annotations

import os
import re
import sys
from collections import Counter
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import process_time

sys.path.insert(0, str(Path(__file__).parents[1]))

from command_line import call
from surroundings import TARGETS

from budget.resources import shipped

SPECS = shipped("specs")
FILES = sorted(
    path
    for path in (*SPECS.rglob("*"), *(Path(__file__).parents[1] / "data").glob("*.csv"))
    if path.suffix in {".yaml", ".json", ".csv"}
)
PIECES = (
    *("\n", ": ", "- ", "{", "}", "[", "]", "'", '"', "#", "|", "&a ", "*a", "!!str "),
    *("nan", ".inf", "1e400", "-1", "0", "1e-30", "1e30", "1,5", "1.57", "  ", "\t"),
    *("deg", "rad", "ft", "ug", "%", "null", "~", "\u202e", "\ufeff", "\x00", "\ufffd"),
)
FIGURE = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
LONGEST = 4_000  # characters of a line that is said
SLOW = 30.0  # of a processor [s]
# Of Python's warnings: what the program warns of stands under "Warning:" too.
FAULT = re.compile(r"Traceback|[a-z]Warning:|internal error")


def mutated(text, random):
    """Return a text with one to three pieces of it changed, doubled or gone."""
    for _ in range(random.randint(1, 3)):
        lines = text.split("\n")
        k = random.randrange(len(lines))
        way = random.randrange(6)
        numbers = list(FIGURE.finditer(text))
        if way == 0 and numbers:
            at = random.choice(numbers)
            new = random.choice((*PIECES, f"{random.gauss(0, 1):.3g}", at[0] * 3))
            text = text[: at.start()] + new + text[at.end() :]
            continue
        if way == 1:
            del lines[k]
        elif way == 2:
            lines.insert(random.randrange(len(lines) + 1), lines[k])
        elif way == 3:
            lines[k] = random.choice(("  ", " ", "", "- ")) + lines[k].lstrip()
        elif way == 4:
            other = random.choice(FILES).read_text(encoding="utf-8").split("\n")
            lines.insert(k, random.choice(other)[:2_000])
        else:
            start = random.randrange(len(lines[k]) + 1)
            gone = start + random.randint(0, 6)
            piece = random.choice(PIECES)
            lines[k] = lines[k][:start] + piece + lines[k][gone:]
        text = "\n".join(lines)
    return text


def a_file(random):
    """Return the command that reads a mutated file of any kind, written here."""
    source = random.choice(FILES)
    made = Path(f"bad{source.suffix}")
    text = mutated(source.read_text(encoding="utf-8"), random)
    coding = random.choice(("utf-8",) * 8 + ("utf-16", "latin-1", "utf-8-sig"))
    made.write_bytes(text.encode(coding, errors="replace"))
    if source.suffix == ".csv":
        Path("m.yaml").write_text("mission: {trajectory: bad.csv}\n", encoding="utf-8")
        return ("validate", "m.yaml")
    return ("check" if source.suffix == ".json" else "validate", made)


NAMES = {
    kind: tuple(path.stem for path in sorted((SPECS / kind).glob("*.yaml")))
    for kind in ("devices", "missions", "procedures", "requirements", "stations")
}
# Whole units, among them variants of what is abstract.
UNITS = tuple(
    one["file"].replace(".yaml", "")
    for one in call("devices", "--kind", "IMU", "--json", "-").document["devices"]
)
ODD = ("", "-", "nan", "0", "-1", "1e400", "no-such", "../x", "a#b", "1 deg", "é", "--")
VALUES = {
    "--procedure": NAMES["procedures"],
    "--requirement": NAMES["requirements"],
    "--station": NAMES["stations"],
    "--mission": ("bench", "outage-10-s", "outage-60-s"),
    "--calibration": ("none", "factory", *NAMES["procedures"]),
    "--missing": ("refuse", "worst", "typical", "predict"),
    "--age": ("1 year", "30 d", "0 s"),
    "--environment": ("none", "temperature 20 degC", "vibration 1 g"),
    "--at": ("10 s", "1 min"),
    "--reference": ("nominal", "as_tested", "next_turn_on"),
    "--set": ("gyro.bias_stability=1 deg/h", "accelerometer.bias_stability.x=5 ug"),
    "--coverage": ("0.95", "99 %", "0.5"),
    "--digits": ("1", "2"),
    "--interval": ("symmetric", "shortest"),
    "--language": ("en", "zh"),
    "--accept": ("meets", "meets_if"),
    "--kind": ("gyro", "accelerometer", "IMU"),
    "--grade": ("tactical", "navigation", "MEMS"),
    "--only": ("gyro.bias_stability", "station.latitude"),
    "--seed": ("0", "7"),
    "--json": ("-", "out.json"),
    "--csv": ("-", "out.csv"),
    "--output": ("out.html", "out.txt"),
    "--rate": ("100", "200 Hz"),
    "--inflate": ("1", "2.5"),
}
FLAGS = ("--full", "--exit-code", "--strict", "--market", "--pairs", "--residual")
COMMANDS = (
    *("analyze --no-validate", "mission --no-validate --mission outage-10-s"),
    "allocate --no-validate --requirement navigation-grade",
    "station --requirement tactical-grade",
    "compare --method gum --requirement navigation-grade",
    *("validate", "new -", "devices", "schema", "diff", "check", "paper"),
    *("export --to gtsam --rate 200", "report --no-validate -o out.html"),
)


@cache
def options_of(command):
    """Return the options of a command that values are known of."""
    told = set(re.findall(r"--[a-z-]+", call(command, "--help").out))
    return sorted(told & {*VALUES, *FLAGS})


def some(random, command, most):
    """Return options, most of them the command's, with values of which few are odd."""
    words = []
    own = options_of(command) if random.random() < 7 / 8 else [*VALUES, *FLAGS]
    for name in random.sample(own, random.randint(0, min(most, len(own)))):
        odd = random.random() < 1 / 20
        value = random.choice(ODD if odd else VALUES.get(name, ODD))
        words += [name] if name in FLAGS else [name, value]
    return words


def a_line(random):
    """Return a command with devices and options that may fit it, or not."""
    command = random.choice(COMMANDS).split()
    devices = random.choices(NAMES["devices"], k=random.choice((0, 1, 1, 1, 2, 3)))
    if random.random() < 1 / 20:
        devices = [*devices, random.choice(ODD)]
    return (*command, *devices, *some(random, command[0], 4))


def an_export(random):
    """Return an export of a device to a target."""
    sure = 5 / 6  # of what most exports need
    names = UNITS if random.random() < sure else NAMES["devices"]
    words = ["export", random.choice(names), "--to", random.choice(TARGETS)]
    if random.random() < sure:
        words += ["--missing", random.choice(("worst", "typical", "predict"))]
    if random.random() < sure:
        words += ["--rate", random.choice(("200", "0.5"))]
    residual = random.random() < 1 / 3
    asked = ("--procedure", "--station", "--age", "--environment") if residual else ()
    for name in random.sample((*asked, "--inflate"), random.randint(0, 1)):
        words += [name, random.choice(VALUES[name])]
    words += ["--residual"] if residual else []
    if random.random() > sure:
        words += ["--set", random.choice(VALUES["--set"])]
    return (*words, *random.choice(((), ("--json", "-"), ("-o", "out.yaml"))))


WAYS = {"files": a_file, "lines": a_line, "exports": an_export}


def fault_of(run):
    """Return what is wrong with a run, '' where nothing."""
    said = run.err.splitlines()
    odd = [line for line in said if FAULT.search(line) or len(line) > LONGEST]
    if run.code not in {0, 1, 2} or odd or (run.code == 2 and not run.err.strip()):
        return f"code {run.code}: {(odd or [run.err[-300:]])[0][:500]}"
    return ""


def main():
    """Run all, and print what was found."""
    what, seed, runs = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    first = int(sys.argv[4]) if len(sys.argv) > 4 else 0
    codes, faults = Counter(), 0
    begun = process_time()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        for k in range(first, first + runs):
            words = WAYS[what](Random(f"{what} {seed} {k}"))  # noqa: S311 - no secret
            start = process_time()
            try:
                run = call(*words)
                codes[run.code] += 1
                wrong = fault_of(run)
            except Exception as error:  # noqa: BLE001 - that is what is looked for
                wrong = f"{type(error).__name__}: {error}"
            faults += bool(wrong)
            took = process_time() - start
            if wrong or took > SLOW:
                line = " ".join(map(str, words))
                sys.stdout.write(f"run {k}: budget {line}: {took:.0f} s {wrong}\n")
            if (k + 1) % 100 == 0 or k + 1 == first + runs:
                sys.stdout.write(
                    f"{what}, seed {seed}: {k + 1 - first} runs, {faults} faults, "
                    f"codes {dict(codes)}, {process_time() - begun:.0f} s\n"
                )
            sys.stdout.flush()
        os.chdir("/")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
