"""Files of every kind out of the schemas, written in many styles, with their places."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from random import Random

from hypothesis import strategies as st

from budget.inputs import json_schema

NUMBERS = ("0.5", "1", "20", "1e-3", ".5", "5.", "+3E1", "1.25e+1")
# Where a number of any size would break a rule that the schema does not know.
FIXED = {
    "gravity_unit": "9.80708 m/s^2",
    "sample_rate": "100 Hz",
    "coverage": "90 %",
    "dwell": "60 s",
    "rate": "30 deg/s",
    "horizon": "2 years",
    "settling_time": "9 min",
}
TEXTS = ("x", "a: b", "5", "no", "\N{DEGREE SIGN}/\N{SQUARE ROOT}h", "'", "# c", "{")
HALF_WIDTHS = ("max", "maximum", "max.", "peak to peak", "p-p", "pk-pk", "peak-to-peak")
NORMAL = ("normal", "gaussian", "Gaussian")


@dataclass(frozen=True)
class Raw:
    """A scalar that is written as it stands: a number, true, or damage."""

    text: str


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a key and its value stand; the same for an item of a list."""

    key: tuple[int, int]  # line and column, from 1
    value: tuple[int, int]


@dataclass
class Page:
    """A text that grows, and the places of what is in it, by path."""

    text: str = ""
    places: dict[tuple[str | int, ...], Place] = field(default_factory=dict)

    @property
    def at(self):
        """Line and column of what is written next, from 1."""
        line, _, tail = self.text.rpartition("\n")
        return (line.count("\n") + 2 if "\n" in self.text else 1, len(tail) + 1)


@cache
def schema_of(kind):
    """Return the schema of a kind of file, made once; nobody may change it."""
    return json_schema(kind)


def trees(kind):
    """Return a strategy of trees that the schema of a kind of file allows."""
    return st.integers(0, 2**32 - 1).map(lambda seed: tree_of(kind, random_of(seed)))


def tree_of(kind, random):
    """Return a tree that the schema of a kind of file allows."""
    schema = schema_of(kind)
    share = random.choice([0.1, 0.3, 0.7])  # of the optional keys
    tree = _value(schema, schema, random, "", share)
    return MENDED.get(kind, dict)(_keep_rules(tree))


def random_of(seed):
    """Return a generator: one draw of hypothesis, where thousands would be slow."""
    return _Random(seed)


class _Random(Random):
    """Draws of a few, without the care for the last bit that takes most of the time."""

    def choice(self, seq):
        """Return one of a sequence."""
        return seq[int(self.random() * len(seq))]

    def randint(self, a, b):
        """Return one of a to b."""
        return a + int(self.random() * (b - a + 1))


def _value(schema, root, random, key, share):
    """Return one value of a schema."""
    while "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rpartition("/")[2]]
    if "anyOf" in schema:
        return _value(random.choice(schema["anyOf"]), root, random, key, share)
    if schema.get("type") == "object":
        return _mapping(schema, root, random, share)
    if schema.get("type") == "array":
        items = schema.get("prefixItems") or [schema["items"]] * random.randint(1, 3)
        return [_value(item, root, random, key, share) for item in items]
    return _leaf(schema, random, key)


def _leaf(schema, random, key):
    """Return one scalar of a schema."""
    if schema.get("type") in {"integer", "number", "boolean"}:
        return Raw("true" if schema["type"] == "boolean" else str(random.randint(1, 9)))
    if "examples" in schema:
        unit = random.choice(schema["examples"]).removeprefix("1 ")
        return FIXED.get(key, f"{random.choice(NUMBERS)} {unit}")
    return random.choice(
        schema.get("enum") or [schema.get("const", random.choice(TEXTS))]
    )


def _mapping(schema, root, random, share):
    """Return a mapping with some of the keys of a schema, in any order."""
    known = schema.get("properties", {})
    if not known:
        names = random.sample(["A", "B 2", "-c"], k=random.randint(1, 2))
        inner = schema["additionalProperties"]
        return {name: _value(inner, root, random, name, share) for name in names}
    needed = {*schema.get("required", ()), *_SIGNS.intersection(known)}
    keys = [key for key in known if key in needed or random.random() < share]
    random.shuffle(keys)
    return {key: _value(known[key], root, random, key, share) for key in keys}


# Keys without which a file has no kind, or a limit no number.
_SIGNS = {"gyro", "limits", "costs", "a", "value", "scale_factor", "latitude"}


def _keep_rules(tree):
    """Mend what no schema says: which keys fit together, which numbers fit a key."""
    if not isinstance(tree, dict):
        return tree
    tree = _keep_pairs({key: _keep_rules(value) for key, value in tree.items()})
    if tree.get("meaning") in HALF_WIDTHS and tree.get("distribution") in NORMAL:
        del tree["distribution"]
    _keep_uncertain(tree)
    tree.pop("density", None)  # only beside some units
    if "bias_stability" in tree and "adds_to" not in tree.get("flicker", {}):
        tree.pop("flicker", None)
    _keep_one_process(tree.get("bias_stability"))
    if "sample_noise" in tree:
        tree.pop("angle_random_walk", None)
        tree.pop("velocity_random_walk", None)
    tree.pop("averaging_time", None)  # only beside some definitions
    if tree.get("definition") == "allan_minimum":
        tree.pop("meaning", None)
    if isinstance(tree.get("order"), list):
        tree["order"] = ["y", "z", "x"]
    _keep_lists(tree)
    if "variants" in tree and "abstract" in tree:
        del tree["abstract"]
    if "abstract" in tree:
        tree["abstract"] = Raw("false")
    if tree.get("costs") == {}:
        tree["costs"] = {"gyro.bias_stability": {"a": Raw("2")}}
    return tree


def _keep_uncertain(tree):
    """Mend a figure with degrees of freedom: they are of a standard uncertainty."""
    if "degrees_of_freedom" in tree:
        for key in ("meaning", "distribution", "reading"):
            tree.pop(key, None)


def _keep_one_process(stable):
    """Mend a stability whose axes would be of two kinds of process."""
    axes = stable["axes"] if "axes" in _keys(stable) else {}
    for part in (stable, *axes.values()):
        if "definition" in _keys(part):
            part.setdefault("correlation_time", "5 s")


def _keys(value):
    """Return the keys of a mapping; none of what is no mapping."""
    return value.keys() if isinstance(value, dict) else ()


def _keep_lists(tree):
    """Mend lists whose items fit together."""
    opened = [key for key, line in tree.items() if "reading" in _keys(line)]
    for key in opened[1:]:  # each one more is a law for each of its words
        del tree[key]["reading"]
    if "soak_points" in tree:
        tree["soak_points"] = ["1 min", "2 h"]
    if "reading" in tree:
        tree["reading"] = ["max", "1 sigma"]
        for key in ("meaning", "distribution", "axes"):
            tree.pop(key, None)
    if isinstance(tree.get("value"), str) and "earlier" in tree:
        tree["earlier"] = [{"value": tree["value"], "horizon": "1 s"}]
        tree["horizon"] = "2 years"
    else:
        tree.pop("earlier", None)


# Keys that go without those named, and keys that need theirs beside them.
_WITHOUT = {
    "bias": {"azimuths"},  # of a gyro's test
    **{
        f"{quantity}_over_temperature": {
            f"{quantity}_temperature_coefficient",
            f"{quantity}_temperature_rate_coefficient",
        }
        for quantity in ("bias", "scale_factor")
    },
}
_NEEDS = {
    **dict.fromkeys(("line", "shape"), "full_scale"),
    "warm_up": "warm_up_time",
    "warm_up_time": "warm_up",
    "sigma": "correlation_time",
}


def _keep_pairs(tree):
    """Drop keys that stand beside one they must not, or without one they need."""
    barred = {other for key in tree for other in _WITHOUT.get(key, ())}
    barred |= {key for key in tree if _NEEDS.get(key, key) not in tree}
    if "sigma" not in tree and "value" not in tree and "definition" not in tree:
        barred.add("correlation_time")  # a stability has its time alone
    soaks = {"soak", "soak_points", "settling_time"}
    barred |= set() if soaks <= tree.keys() else soaks
    own = tree.get("bias_repeatability"), tree.get("scale_factor_repeatability")
    for parameter, one in zip(("bias", "scale_factor"), own, strict=True):
        name = "ageing" if parameter == "bias" else "scale_factor_ageing"
        ages = tree.get(name)
        if isinstance(one, dict) and "horizon" in one and isinstance(ages, dict):
            ages["adds_to"] = f"{parameter}_repeatability"
    return {key: value for key, value in tree.items() if key not in barred}


def _keep_windows(tree):
    """Mend a procedure: windows or the paper's tests, each window one that can be."""
    tree["latitude"] = "-12.5 deg"
    if "height" in tree:
        tree["height"], tree["gravity"] = "120 m", "normal"
    if "station" in tree and not isinstance(tree["station"], dict):
        tree["station"] = "three-axis-table"
    if tree.get("estimator") != "norm" or "windows" not in tree:
        tree.pop("moves", None)
    if "windows" not in tree:
        return _keep_test(tree)
    for key in ("gyro", "accelerometer", "formulas"):
        tree.pop(key, None)
    if tree.get("estimator") == "paper":
        del tree["estimator"]
    tree["windows"] = [_window(one) for one in tree["windows"]]
    if tree.get("estimator") == "norm":  # of dwells, and not of the gyro
        dwells = [
            one for one in tree["windows"] if not one.keys() & {"turn", "windows"}
        ]
        tree["windows"] = [one | {"use": "accelerometer"} for one in dwells]
        if not dwells:
            return tree | {"windows": [{"face": "z up", "dwell": "60 s"}]}
    return tree


def _keep_device(tree):
    """Mend a device: a range of the unit is of both sensors, neither with its own."""
    sensors = [tree.get(key, {}) for key in ("gyro", "accelerometer")]
    if not all(sensors) or any("range" in sensor for sensor in sensors):
        tree.pop("range", None)
    return tree


def _keep_station(tree):
    """Mend a station file: without a figure of one or of a room it has no kind."""
    figures = [tree.get(key, {}) for key in ("station", "environment")]
    if not any(leaves(figures)):
        tree["station"] = {"turn_angle": "1 arcsec"}
    return tree


# A segment of a vehicle that stands before and after, by its first key.
_SEGMENTS = {
    "stand": {"stand": "60 s"},
    "straight": {"straight": "60 s", "speed": "0 m/s"},
    "turn": {"turn": "-30 deg", "rate": "3 deg/s"},
    "climb": {"climb": "1 min", "rate": "-2 m/s"},
    "accelerate": {"accelerate": "9 s", "to": "0 km/h"},
}


ZERO_VELOCITY = "zero_velocity"
RATES = ("1 Hz", "0.25 Hz", "7 Hz", "0.1 Hz")
BELIEVED = {
    "aiding.gnss_position": "5 m",
    "gyro.angle_random_walk": "0.03 deg/sqrt(h)",
    "gyro.bias_stability.correlation_time": "60 s",
    "accelerometer.bias_repeatability.x": "1 mg",
}


def _segment(one, aids):
    """Return a segment that is one thing, or a group of such, with aids that fit it."""
    own = next((key for key in one if key in _SEGMENTS), "stand")
    lines = [_segment(line, aids) for line in one.get("segments", ())]
    kept = {"segments": lines} if lines else _SEGMENTS[own]
    moves = any("stand" not in line for line in lines or [kept])
    named = one.get("aiding", [])
    named = [named] if isinstance(named, str) else named
    named = [
        key for key in aids if key in named and not (moves and key == ZERO_VELOCITY)
    ]
    if named:
        kept = {"aiding": named, **kept}
        if lines:
            kept["segments"] = [
                {key: line[key] for key in line if key != "aiding"} for line in lines
            ]
    return {key: one[key] for key in ("repeat",) if not lines and key in one} | kept


def _keep_aids(part):
    """Mend aids and a filter; return the names of the aids."""
    aids = part.get("aiding") or {}
    for number, (key, one) in enumerate(aids.items()):
        one["rate"] = RATES[(len(one) + number) % len(RATES)]
        one.pop("during", None)  # beside a trajectory
        if key == "gnss":
            one.setdefault("position", "2.5 m")
            for name in ("position", "velocity", "position_drift"):
                if isinstance(one.get(name), dict):
                    one[name].setdefault(
                        "value", "3 m/s" if name == "velocity" else "3 m"
                    )
            if "position_drift" in one:
                drift = one["position_drift"]
                drift = drift if isinstance(drift, dict) else {"value": drift}
                one["position_drift"] = {"correlation_time": "60 s", **drift}
    if not aids:
        part.pop("aiding", None)
        part.pop("filter", None)
    if isinstance(part.get("filter"), dict):
        own = part["filter"]
        if "estimates" in own:
            own["estimates"] = ["gyro.bias", "accelerometer.scale_factor"]
            del own["estimates"][len(aids) % 2 :]
        if "believes" in own:
            name = [*BELIEVED][len(str(own)) % len(BELIEVED)]
            own["believes"] = {name: BELIEVED[name]}
    return [*aids]


def _keep_mission(tree):
    """Mend a mission: segments that follow, of a vehicle that stands."""
    part = tree["mission"]
    fixed = {"longitude": "-100 deg", "height": "120 m", "speed": "0 m/s"}
    fixed |= {"at": ["1 s", "2 s"], "alignment_time": "5 min"}
    part |= {key: value for key, value in fixed.items() if key in part}
    part.pop("trajectory", None)
    part |= {"latitude": "-12.5 deg"}
    aids = _keep_aids(part)
    segments = [_segment(one, aids) for one in part.get("segments", [{}])]
    lines = [line for one in segments for line in (one, *one.get("segments", ()))]
    unused = {*aids}.difference(*(line.get("aiding", ()) for line in lines))
    if unused:
        segments.append({"stand": "20 s", "aiding": sorted(unused)})
    part["segments"] = segments
    if part.get("alignment") == "self":
        part["alignment_time"] = "5 min"
    else:
        part.pop("alignment_time", None)
    return tree


# A limit on each quantity of a mission, in what is wanted of it.
_LIMITS = {
    "position": {"horizontal": "1 nmi"},
    "velocity": {"north": "2 m/s"},
    **{axis: {"limit": "6 arcmin"} for axis in ("roll", "pitch", "heading")},
}


def _keep_requirement(tree):
    """Mend a requirement: limits on a mission at one time, after a later turn-on."""
    limits = tree.get("limits")
    on = limits.get("mission") if isinstance(limits, dict) else None
    if not isinstance(on, dict):
        return tree
    for quantity, said in on.items():
        one = said[0] if isinstance(said, list) and said else said
        kept = one if isinstance(one, dict) else {}
        own = _LIMITS[quantity] | kept | {"at": "60 s"}
        on[quantity] = [own] if isinstance(said, list) else own
    if on:
        tree.pop("reference", None)
    return tree


MENDED = {
    "device": _keep_device,
    "requirement": _keep_requirement,
    "procedure": _keep_windows,
    "station": _keep_station,
    "mission": _keep_mission,
}


def _keep_test(tree):
    """Mend a procedure of the paper's tests."""
    tree.pop("pause", None)
    if tree.get("gyro", {}).get("bias"):
        tree["gyro"].pop("dwell", None)
        tree.pop("formulas", None)
    if tree.get("estimator") in {"least_squares", "weighted", "norm"}:
        tree.pop("formulas", None)
    else:
        tree.pop("estimate", None)
    return tree


def _window(one):
    """Return a window with one attitude and one length, or a group of such."""
    if "windows" in one:
        return {"windows": [_window(line) for line in one["windows"]]}
    one = {key: value for key, value in one.items() if key not in {"start", "repeat"}}
    if "face" in one or not one.keys() & {"outer", "middle", "inner"}:
        one = {"face": "z up"} | one
        drop = {"outer", "middle", "inner"}
        if "azimuths" in one:
            drop.add("azimuth")
    else:
        drop = {"azimuth", "azimuths"}
    if "turn" in one:
        one |= {"turns": Raw("-2"), "rate": "20 deg/s"}
        drop |= {"dwell"}
    else:
        one = {"dwell": "60 s"} | one
        drop |= {"turns", "rate", "back"}
    return {key: value for key, value in one.items() if key not in drop}


def leaves(tree, path=()):
    """Yield the paths of all scalars in a tree, with their values."""
    if isinstance(tree, dict | list):
        pairs = tree.items() if isinstance(tree, dict) else enumerate(tree)
        for step, value in pairs:
            yield from leaves(value, (*path, step))
    else:
        yield path, tree


def mappings(tree, path=()):
    """Yield the paths of all mappings in a tree."""
    if isinstance(tree, dict):
        yield path
    if isinstance(tree, dict | list):
        pairs = tree.items() if isinstance(tree, dict) else enumerate(tree)
        for step, value in pairs:
            yield from mappings(value, (*path, step))


def replaced(tree, path, value):
    """Return a tree with another value at that path; a new key where there is none."""
    if not path:
        return value
    step, *rest = path
    if isinstance(tree, list):
        return [
            replaced(one, rest, value) if i == step else one
            for i, one in enumerate(tree)
        ]
    known = tree or {}
    return {**known, step: replaced(known.get(step), rest, value)}


def write(tree, seed, twice=None):
    """Write a tree as YAML, in styles drawn from the seed; `twice`: a key to repeat.

    The places of the repeated key are those of its second time.
    """
    writer = _Writer(Page(), random_of(seed), twice)
    writer.block(tree, (), 0)
    return writer.page


@dataclass(frozen=True)
class _Writer:
    """Writes onto a page, in styles drawn as it goes."""

    page: Page
    random: Random
    twice: tuple[str | int, ...] | None

    def block(self, tree, path, indent):
        """Write a mapping with one key on a line, deeper ones in either style."""
        page, random = self.page, self.random
        for number, key in enumerate(self.keys(tree, path)):
            if number and random.random() < 0.1:
                page.text += f"{' ' * random.randint(0, 9)}# {key}: comment\n"
            page.text += " " * indent
            start = page.at
            page.text += f"{self.word(key)}:"
            value, inner = tree[key], (*path, key)
            if isinstance(value, dict) and value and random.random() < 0.6:
                page.text += random.choice(["\n", "  # why\n", "\n\n"])
                deeper = indent + random.randint(1, 4)
                page.places[inner] = Place(key=start, value=(page.at[0], deeper + 1))
                self.block(value, inner, deeper)
            else:
                page.text += " " * random.randint(1, 3)
                page.places[inner] = Place(key=start, value=page.at)
                self.flow(value, inner)
                page.text += random.choice(["\n", " # x\n", "\n\n"])

    def flow(self, value, path):
        """Write any value on one line."""
        page = self.page
        if isinstance(value, dict):
            page.text += "{"
            for number, key in enumerate(self.keys(value, path)):
                page.text += ", " if number else ""
                start = page.at
                page.text += f"{self.word(key)}: "
                page.places[*path, key] = Place(key=start, value=page.at)
                self.flow(value[key], (*path, key))
            page.text += "}"
        elif isinstance(value, list):
            page.text += "["
            for number, item in enumerate(value):
                page.text += ", " if number else ""
                page.places[*path, number] = Place(key=page.at, value=page.at)
                self.flow(item, (*path, number))
            page.text += "]"
        else:
            page.text += self.scalar(value)

    def keys(self, tree, path):
        """Return the keys of a mapping, one of them perhaps twice."""
        return [key for key in tree for _ in range(1 + (self.twice == (*path, key)))]

    def word(self, key):
        """Write a key, in quotes now and then and where it must be."""
        bare = key[0].isalpha()
        return key if bare and self.random.random() < 0.9 else f'"{key}"'

    def scalar(self, value):
        """Write a scalar; without quotes only where YAML reads it as that text."""
        if isinstance(value, Raw):
            return value.text
        plain = value[0].isdigit() and " " in value and ":" not in value
        style = self.random.choice(
            ["plain", "single", "double"] if plain else ["single"]
        )
        if style == "single":
            return "'" + value.replace("'", "''") + "'"
        return f'"{value}"' if style == "double" else value
