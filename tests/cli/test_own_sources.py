"""Error lines of other packages: the one of the documentation, and broken ones."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from math import pi

import pytest
from command_line import Outcome, start, surroundings
from numpy.testing import assert_allclose
from places import DOCS, ROOT, TESTS

from budget.earth import normal_gravity
from budget.units import STANDARD_GRAVITY

K = 0.4  # of the device, anisoelasticity [deg/h/g^2]
NAME = "gyro.anisoelasticity"
LINES = """
  errors:
    bias_repeatability: {bias}
    bias_stability: {{value: {stability}, correlation_time: 300 s}}
    {walk}
    scale_factor_repeatability: 50 ppm
    mounting_repeatability: 5 arcsec
"""
GYRO = LINES.format(
    bias="1 deg/h", stability="0.3 deg/h", walk="angle_random_walk: 0.01 deg/sqrt(h)"
)
ACCELEROMETER = LINES.format(
    bias="100 ug", stability="20 ug", walk="velocity_random_walk: 0.01 m/s/sqrt(h)"
)
TILTED = """
name: tilted
latitude: 45 deg
estimator: least_squares
windows:
  - {face: all, dwell: 300 s}
  - {middle: 45 deg, dwell: 300 s}
  - {face: z up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}
  - {face: x up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}
  - {face: y up, turn: vertical, turns: 1, back: true, rate: 20 deg/s, use: gyro}
"""
BEND = """
name: bend
environment: none
mission:
  latitude: 45 deg
  segments: [{straight: 20 s, speed: 20 m/s}, {turn: 90 deg, rate: 36 deg/s}]
"""
# Calls one after the other in a process that has the package, as JSON of outcomes.
CALLING = """
import json, sys
from command_line import call
print(json.dumps([vars(call(*words)) for words in json.load(sys.stdin)]))
"""


def device(line=f"anisoelasticity: {K} deg/h/g^2"):
    """Return a device file with one more line of the gyro."""
    return f"name: mine\ngyro:{GYRO}    {line}\naccelerometer:{ACCELEROMETER}"


def install(folder, name, points, **modules):
    """Put a distribution into a folder, as pip would leave it."""
    info = folder / f"{name.replace('-', '_')}-1.0.dist-info"
    info.mkdir()
    rows = "".join(f"{key} = {value}\n" for key, value in points.items())
    (info / "entry_points.txt").write_text(f"[budget.sources]\n{rows}")
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n"
    )
    for module, text in modules.items():
        (folder / f"{module}.py").write_text(text)


def run(folder, *calls):
    """Call the command line in a folder whose packages are installed."""
    path = [str(folder), str(TESTS), str(ROOT), str(ROOT / "examples")]
    done = subprocess.run(
        [sys.executable, "-c", CALLING],
        cwd=folder,
        input=json.dumps([words.split() for words in calls]),
        capture_output=True,
        text=True,
        check=True,
        env=surroundings() | {"PYTHONPATH": ":".join(path)},
    )
    return [Outcome(**one) for one in json.loads(done.stdout)]


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    """Install the example of the documentation beside the files that use it."""
    folder = tmp_path_factory.mktemp("own")
    text = (DOCS / "own-sources.md").read_text(encoding="utf-8")
    code, project = (
        re.search(rf"```{kind}\n(.*?)```", text, re.DOTALL)[1]
        for kind in ("python", "toml")
    )
    known = tomllib.loads(project)["project"]
    install(folder, known["name"], known["entry-points"]["budget.sources"], my_imu=code)
    for name, content in (
        ("mine", device()),
        ("tilted", TILTED),
        ("bend", BEND),
        ("slip", device(f"anisoelastic drift: {K} deg/h/g^2")),
        ("wrong", device("anisoelasticity: 0.4 deg/h")),
    ):
        (folder / f"{name}.yaml").write_text(content)
    return folder


def spread(outcome, *wanted):
    """Return the standard uncertainty of the last output of a quantity and axis."""
    rows = json.loads(outcome.out)["outputs"]
    found = [x for x in rows if (x["sensor"], x["parameter"], x["axis"]) == wanted]
    return found[-1]["standard_uncertainty"]


@pytest.mark.slow
def test_the_example_gives_what_the_page_says(home):
    """In windows k g^2/26, on a bend 2/pi k a g T, in samples as in windows."""
    asked = f"mine.yaml --only {NAME} --json -"
    calm = f"analyze {asked} --procedure tilted.yaml"
    windows, samples, bend = run(
        home,
        f"{calm} --no-validate",
        f"{calm} --method simulation --trials 100",
        f"mission {asked} --mission bend.yaml --no-validate",
    )
    g = normal_gravity(pi / 4.0)
    size = (g / STANDARD_GRAVITY) ** 2 * K / 26.0
    rate = 36.0 * pi / 180.0
    felt = K * 20.0 * rate * g / STANDARD_GRAVITY**2  # [arcsec/s]

    # Earth rate, in the turns too, is left out here; of samples there are 100.
    assert_allclose(spread(windows, "gyro", "bias", "y"), size, rtol=1e-3)
    assert_allclose(spread(samples, "gyro", "bias", "y"), size, rtol=0.25)
    for axis in ("roll", "pitch"):
        u = spread(bend, "mission", "attitude", axis)
        assert_allclose(u, felt / rate, rtol=5e-3)


@pytest.mark.slow
def test_every_command_knows_it(home):
    """Read, checked, ranked, changed, allocated, reported, described, exported."""
    valid, slip, wrong, schema, changed, ranked, split, told, pages = run(
        home,
        "validate mine.yaml",
        "validate slip.yaml",
        "validate wrong.yaml",
        "schema device",
        f"analyze mine.yaml --procedure tilted.yaml --set {NAME}=40deg/h/g^2 "
        "--no-validate",
        "compare mine.yaml zhao-2019 --procedure tilted.yaml --method gum "
        "--requirement tactical-grade --json -",
        "allocate mine.yaml --procedure tilted.yaml --requirement tactical-grade "
        "--no-validate --json -",
        "export mine.yaml --to kalibr --rate 100",
        "report mine.yaml --procedure tilted.yaml --full --no-validate -o r.html",
    )

    assert (valid.code, valid.err) == (0, "")
    assert slip.code == 2
    assert "did you mean 'anisoelasticity'?; how makers print it: my-imu" in slip.err
    assert wrong.code == 2
    assert "expected a rate per square of an acceleration" in wrong.err
    own = json.loads(schema.out)["$defs"]["gyro_errors"]["properties"]
    assert "anisoelastic drift" in own["anisoelasticity"]["description"]
    assert "anisoelasticity" in changed.out
    assert ranked.code in {0, 1}
    assert '"gyro.anisoelasticity"' in split.out
    assert "gyro.anisoelasticity: 0.4 deg/h/g^2" in told.err + told.out
    assert pages.code == 0
    page = (home / "r.html").read_text(encoding="utf-8")
    assert "What other error lines add to a reading" in page
    assert "anisoelasticity k of axis i" in page
    assert not any(one.err.count("Traceback") for one in (ranked, split, told, pages))


def test_the_shell_completes_it(home):
    """As a name of a source, and of a specification that is set."""
    code = (
        "from budget.cli.options import complete_line, complete_source\n"
        "print(complete_source('gyro.an'), complete_line('gyro.ani'))"
    )
    path = ":".join(map(str, (home, ROOT)))
    found = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env=surroundings() | {"PYTHONPATH": path},
    ).stdout

    assert NAME in found
    assert f"{NAME}=" in found


@pytest.mark.slow
def test_help_looks_for_none():
    """What needs no device looks for no package; what needs one does once."""
    code = (
        "import sys\nfrom importlib import metadata\nfrom budget.cli import main\n"
        "found = metadata.entry_points\nasked = []\n"
        "metadata.entry_points = lambda **of: asked.append(of) or found(**of)\n"
        "sys.argv = ['budget', *sys.argv[1:]]\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print(asked.count({'group': 'budget.sources'}))"
    )

    def times(*words):
        run = subprocess.run(
            [sys.executable, "-c", code, *words],
            capture_output=True,
            text=True,
            check=True,
            env=surroundings() | {"PYTHONPATH": str(ROOT)},
        )
        return int(run.stdout.split()[-1])

    assert times("--help") == 0
    assert times("validate", "zhao-2019", "hg4930") == 1


# A process with a key of its own, in one file: two Gauss-Markov processes of a spread.
PAIR = """
from dataclasses import dataclass
from math import sqrt
import numpy as np
from budget.model.noise import GaussMarkov, InRun
from budget.model.source import IN_RUN, Key, Noise, Source

@dataclass(frozen=True)
class Pair:
    sigma: float
    times: tuple

    def _both(self):
        return [GaussMarkov(self.sigma / sqrt(2.0), time) for time in self.times]

    def covariance(self, schedule):
        return sum(one.covariance(schedule) for one in self._both())

    def reduce(self, schedule, weights):
        return sum(one.reduce(schedule, weights) for one in self._both())

    def in_run(self, sample_rate):
        return InRun("markov", self.sigma / sqrt(2.0), self.times)

@dataclass(frozen=True)
class PairNoise(Noise):
    formula = "u^2 = sigma^2"
    letters = "pair of processes, sigma in all"

    def process(self, given, axis, sample_rate):
        time = given.own["slow_time"]
        return Pair(float(given.u[axis]), (time / 10.0, time))

    def sampler(self, given, rng, sample_rate):
        return lambda at: given.u[:, None] * rng.standard_normal((3, at.n))

PAIR = Source(
    name="pair", units={"gyro": "deg/h"}, model="two processes", effect=PairNoise(),
    stays=IN_RUN, keys=(Key(name="slow_time", unit="s", usual=3000.0, says="slower"),),
)
"""


@pytest.mark.slow
def test_a_process_with_keys_of_its_own_is_one_file(tmp_path):
    """Its variance is the mean of those of its parts, in a test and on a mission."""
    install(tmp_path, "pair", {"pair": "pair:PAIR"}, pair=PAIR)
    (tmp_path / "bend.yaml").write_text(BEND)
    own = device("pair: {value: 0.2 deg/h, slow_time: 1000 s}")
    (tmp_path / "own.yaml").write_text(own)
    (tmp_path / "usual.yaml").write_text(device("pair: 0.2 deg/h"))
    one = "0.3 deg/h, correlation_time: 300 s"
    calls = []
    for asked in (
        "analyze {} --only gyro.{} --no-validate --json -",
        "mission {} --mission bend.yaml --only gyro.{} --no-validate --json -",
    ):
        calls.append(asked.format("own.yaml", "pair"))
        for time in (100, 1000):
            part = own.replace(one, f"0.2 deg/h, correlation_time: {time} s")
            (tmp_path / f"part-{time}.yaml").write_text(part)
            calls.append(asked.format(f"part-{time}.yaml", "bias_stability"))
    *found, usual = run(tmp_path, *calls, "validate usual.yaml")

    for three, wanted in (
        (found[:3], ("gyro", "scale_factor", "x")),
        (found[3:], ("mission", "position", "north")),
    ):
        whole, *parts = (spread(outcome, *wanted) ** 2 for outcome in three)
        assert_allclose(whole, sum(parts) / 2.0, rtol=1e-6)
    assert "gyro.pair: slow_time is not said: 3000 s taken" in usual.out


# A change with a key, and a process whose size is not the first thing it is given.
ODD = """
from collections.abc import Mapping
from dataclasses import dataclass
import numpy as np
from budget.model.noise import GaussMarkov
from budget.model.source import DEVICE, IN_RUN, Key, Noise, Source, TurnOnChange

class Cycled(TurnOnChange):
    formula = "n b"
    letters = "cycles n, bias b"

    def gains(self, known):
        later = known["cycled"].own["cycles"] * np.eye(3)
        return {"bias": (np.zeros((3, 3)), later)}

@dataclass(frozen=True)
class Late:
    time: float
    sigma: float

    @property
    def same(self):
        return GaussMarkov(self.sigma, self.time)

    def covariance(self, schedule):
        return self.same.covariance(schedule)

    def reduce(self, schedule, weights):
        return self.same.reduce(schedule, weights)

    def in_run(self, sample_rate):
        return self.same.in_run(sample_rate)

class LateNoise(Noise):
    formula = "u^2 = sigma^2"
    letters = "process of size sigma"

    def process(self, given, axis, sample_rate):
        return Late(100.0, float(given.u[axis]))

    def sampler(self, given, rng, sample_rate):
        return lambda at: given.u[:, None] * rng.standard_normal((3, at.n))

CYCLED = Source(
    name="cycled", units={"gyro": "deg/h"}, model="by cycles", effect=Cycled(),
    stays=DEVICE, keys=(Key(name="cycles", unit="s", usual=1.0, says="cycles"),),
)
LATE = Source(
    name="late", units={"gyro": "deg/h"}, model="one", effect=LateNoise(), stays=IN_RUN
)
"""


@pytest.mark.slow
def test_a_line_of_ones_own_is_that_of_its_device(tmp_path):
    """Not that of the one before it, and a process has the size that it says."""
    install(tmp_path, "odd", {"cycled": "odd:CYCLED", "late": "odd:LATE"}, odd=ODD)
    for n in (1, 50):
        own = f"cycled: {{value: 0.1 deg/h, cycles: {n} s}}"
        (tmp_path / f"cycles-{n}.yaml").write_text(device(own))
    (tmp_path / "late.yaml").write_text(device("late: 0.2 deg/h"))
    same = device().replace("0.3 deg/h, correlation_time: 300 s", "0.2 deg/h, {}")
    same = same.replace("{}", "correlation_time: 100 s")
    same = same.replace(f"    anisoelasticity: {K} deg/h/g^2", "")
    (tmp_path / "same.yaml").write_text(same)
    wanted = {"name": "w", "reference": "next_turn_on"}
    wanted |= {"environment": "none", "limits": {"gyro": {"bias": "30 deg/h"}}}
    (tmp_path / "wanted.yaml").write_text(json.dumps(wanted))
    how = "--requirement wanted.yaml --method gum --json -"
    only = "--no-validate --json - --only gyro"
    *compared, late, markov = run(
        tmp_path,
        *(
            f"compare {files} {how}"
            for files in (
                "cycles-1.yaml",
                "cycles-50.yaml",
                "cycles-1.yaml cycles-50.yaml",
                "cycles-50.yaml cycles-1.yaml",
            )
        ),
        f"analyze late.yaml {only}.late",
        f"analyze same.yaml {only}.bias_stability",
    )

    one, five, *both = (
        {x["file"]: x["utilisation"] for x in json.loads(outcome.out)["devices"]}
        for outcome in compared
    )
    assert one["cycles-1.yaml"] < 0.9 * five["cycles-50.yaml"]
    for found in both:
        assert found == pytest.approx(one | five, rel=1e-12, abs=0)
    bias = ("gyro", "bias", "x")
    assert_allclose(spread(late, *bias), spread(markov, *bias), rtol=1e-9)


@pytest.mark.slow
def test_a_line_that_is_expected_and_absent_bounds_the_verdict(home, tmp_path):
    """As a line of ours: the verdict names what to ask for, and up to which value."""
    code = (home / "my_imu.py").read_text()
    line = NAME.removeprefix("gyro.")
    named = f'    stays=DEVICE,\n    expected="{line}",\n'
    code = code.replace("    stays=DEVICE,\n", named)
    install(tmp_path, "my-imu", {line: "my_imu:ANISOELASTICITY"}, my_imu=code)
    g = "g_sensitivity: 0.1 deg/h/g"
    given, absent = device(f"{g}\n    {line}: {K} deg/h/g^2"), device(g)
    wanted = {"name": "w", "environment": "none"}
    wanted |= {"limits": {"gyro": {"bias": "30 deg/h"}}}
    files = {"given": given, "absent": absent, "tilted": TILTED}
    for name, text in (files | {"wanted": json.dumps(wanted)}).items():
        (tmp_path / f"{name}.yaml").write_text(text)
    how = "--procedure tilted.yaml --requirement wanted.yaml --no-validate"
    known, asked, read = run(
        tmp_path,
        f"analyze given.yaml {how} --json -",
        f"analyze absent.yaml {how} --json -",
        f"analyze absent.yaml {how}",
    )

    (sensor,) = json.loads(known.out)["assessment"]["sensors"]
    assert sensor["verdict"] == "meets"
    (sensor,) = json.loads(asked.out)["assessment"]["sensors"]
    assert sensor["verdict"] in {"meets_if", "undecidable"}
    assert "gyro anisoelasticity" in read.out
    assert "deg/h/g^2" in read.out


HEAD = """
from dataclasses import dataclass, replace
import numpy as np
from budget.model.noise import InRun, White
from budget.model.source import *
from budget.model.source import Disturbance, Noise, Offset, Source

def row(name, effect, **more):
    said = {"units": {"gyro": "deg/h/g"}, "model": "one", "stays": "device"}
    return Source(name=name, effect=effect, **(said | more))

@dataclass(frozen=True)
class Fine(Disturbance):
    def in_use(self, x, force):
        return np.eye(3) * force[..., None]

@dataclass(frozen=True)
class Flat(Disturbance):
    def in_use(self, x, force):
        return force

@dataclass(frozen=True)
class Endless(Disturbance):
    def in_use(self, x, force):
        with np.errstate(divide="ignore"):
            return np.eye(3) / force[..., None]

@dataclass(frozen=True)
class Falls(Disturbance):
    def in_use(self, x, force):
        raise LookupError("no table")

@dataclass(frozen=True)
class Idle(Disturbance):
    pass

@dataclass(frozen=True)
class Late(Disturbance):
    def in_use(self, x, force):
        if np.size(force) > 18:
            raise LookupError("no table of so many")
        return np.eye(3) * force[..., None]

def act(x, truth, noise):
    return np.full((3, 4, x.shape[1]), np.nan)

@dataclass(frozen=True)
class Unbound(Fine):
    def bind(self, given, triad):
        return act

class Odd(White):
    def covariance(self, schedule):
        return -super().covariance(schedule)
    def reduce(self, schedule, weights):
        return -super().reduce(schedule, weights)

@dataclass(frozen=True)
class Negative(Noise):
    def process(self, given, axis, sample_rate):
        return Odd(1.0)
    def sampler(self, given, rng, sample_rate):
        return lambda at: rng.standard_normal((3, at.n))

GONE = row("renamed", Fine())
CLASS = row("classy", Fine)
FLAT = row("flat", Flat())
ENDLESS = row("endless", Endless())
FALLS = row("falls", Falls())
IDLE = row("idle", Idle())
UNITLESS = row("unitless", Fine(), units={})
FURLONGS = row("furlongs", Fine(), units={"gyro": "furlong/fortnight"})
STATION = row("outdoors", Fine(), units={"station": "arcsec"})
GAUDY = row("gaudy", Fine(), colour="pink", stays="forever", words="text")
UPPER = row("Upper", Fine())
OURS = row("bias_stability", Fine())
OUTPUT = row("scale_factor", Fine())
AXES = row("axes", Fine(), axes=("x", "x", []))
OFFSET = row("shift", Offset("tilt"))
NEGATIVE = row("negative", Negative())
MONEY = row("money", type("Money", (Fine,), {"formula": "$x$"})())
NEEDED = row("needed", Fine(), expected="noise")
UNTOLD = row("untold", Fine(), keys=(Key(name="cycles", unit="s", usual=1.0, says=""),))
KEYED = row("keyed", Fine(), keys=(Key(name="value", unit="s", usual=1.0, says=""),))
LATE = row("late", Late())
UNBOUND = row("unbound", Unbound())
CROOKED = row("crooked", type("Crooked", (Fine,), {"formula": "nofunction(x)"})())
TWICE = row("twice", Fine())
"""
# By the key: what an entry point names, and what is said of it.
BROKEN = {
    "missing": ("not_there:ROW", "ModuleNotFoundError: No module named 'not_there'"),
    "leaves": ("leaving:ROW", "its import ended with SystemExit: 3"),
    "nothing": ("broken:NOTHING", "has no attribute 'NOTHING'"),
    "text": ("broken:HEAD", "has no attribute 'HEAD'"),
    "function": ("broken:act", "found function, expected a budget.model.source.Source"),
    "gone": ("broken:GONE", "its Source is called 'renamed', expected the name"),
    "classy": ("broken:CLASS", "its effect is the class Fine, expected an instance"),
    "flat": ("broken:FLAT", "its in_use has the shape (3,), expected (3, 3)"),
    "endless": ("broken:ENDLESS", "values that are no finite numbers"),
    "falls": ("broken:FALLS", "ended with LookupError: no table"),
    "idle": ("broken:IDLE", "its effect adds nothing; expected in_use, or bind"),
    "unitless": ("broken:UNITLESS", "its units are {}, expected a unit by sensor"),
    "furlongs": ("broken:FURLONGS", "found the unit 'furlong/fortnight'"),
    "outdoors": ("broken:STATION", "of gyro, accelerometer or both"),
    "gaudy": ("broken:GAUDY", "its colour is 'pink', expected 'orange'"),
    "Upper": ("broken:UPPER", "expected small letters, digits and underscores"),
    "bias_stability": ("broken:OURS", "budget itself calls something"),
    "scale_factor": ("broken:OUTPUT", "budget itself calls something"),
    "axes": ("broken:AXES", "ended with TypeError"),
    "shift": ("broken:OFFSET", "its target is 'tilt', expected scale_factor"),
    "negative": ("broken:NEGATIVE", "not symmetric, or of a negative variance"),
    "money": ("broken:MONEY", "a formula without '$'"),
    "untold": ("broken:UNTOLD", "its in_use is not told its keys"),
    "keyed": ("broken:KEYED", "its keys are not a tuple of Key"),
    "needed": (
        "broken:NEEDED",
        "it is expected as 'noise', which ties lines",
    ),
}
TRIED_LATER = {"late": "LATE", "unbound": "UNBOUND", "crooked": "CROOKED"}


@pytest.fixture(scope="module")
def ruin(tmp_path_factory):
    """Install every broken line, each in a distribution of its own."""
    folder = tmp_path_factory.mktemp("ruin")
    for number, (key, (value, _)) in enumerate(BROKEN.items()):
        install(folder, f"broken-{number}", {key: value})
    for number in (1, 2):
        install(folder, f"twin-{number}", {"twice": "broken:TWICE"})
    points = {key: f"broken:{value}" for key, value in TRIED_LATER.items()}
    install(
        folder,
        "later",
        points,
        broken=HEAD,
        leaving="import sys\nprint('on stdout')\nsys.exit(3)\n",
    )
    for key in ("falls", *TRIED_LATER):
        (folder / f"{key}.yaml").write_text(device(f"{key}: 1 deg/h/g"))
    return folder


@pytest.mark.slow
def test_a_broken_line_is_told_and_harms_no_other(ruin, tmp_path):
    """Each with its distribution; a device without it has the numbers it had."""
    words = "analyze zhao-2019 --no-validate --json -"
    (harmed,) = run(ruin, words)
    well = start(*words.split(), cwd=tmp_path)
    told = {
        re.search("the error line '([^']+)'", line)[1]: line
        for line in harmed.err.splitlines()
        if line.startswith("warning: ")
    }

    assert harmed.code == 0
    assert told.keys() == BROKEN.keys() | {"twice"}
    for number, (key, (value, said)) in enumerate(BROKEN.items()):
        assert f"of broken-{number} 1.0 ({key} = {value}) is left out: " in told[key]
        assert said in told[key]
        assert told[key].endswith("mend or remove that package (docs/own-sources.md)")
    assert "twin-1 1.0 (twice = broken:TWICE) and twin-2 1.0" in told["twice"]
    assert "Traceback" not in harmed.err
    before, after = json.loads(well.out), json.loads(harmed.out)
    for document in (before, after):  # the two that loaded are lines nobody gives
        for key in ("provenance", "not_given", "inputs", "settings"):
            document.pop(key, None)
    assert after["outputs"] == before["outputs"]


@pytest.mark.slow
def test_what_needs_a_broken_line_is_refused(ruin):
    """In the file that gives it, at its place; or where its effect fails later."""
    file, late, unbound, crooked, mission = run(
        ruin,
        "validate falls.yaml",
        "analyze late.yaml --no-validate",
        "analyze unbound.yaml --no-validate",
        "report crooked.yaml --full --no-validate -o r.html",
        "mission late.yaml --mission bench --no-validate",
    )

    assert file.code == 2
    said = [line for line in file.err.splitlines() if line.startswith("falls.yaml:")]
    assert re.match(r"falls\.yaml:\d+:5: gyro\.errors\.falls: unknown key", said[0])
    assert "the error line 'falls' of broken-9 1.0" in said[0]
    for one, key, what in (
        (late, "late", "LookupError: no table of so many"),
        (mission, "late", "LookupError: no table of so many"),
        (unbound, "unbound", "values that are no finite numbers"),
        (crooked, "crooked", "cannot be set"),
    ):
        assert one.code == 2
        first = next(x for x in one.err.splitlines() if f"of later 1.0 ({key}" in x)
        assert f"'{key}' of later 1.0 ({key} = broken:{TRIED_LATER[key]})" in first
        assert what in first
        assert "Traceback" not in one.err
    assert not (ruin / "r.html").exists()
