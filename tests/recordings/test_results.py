"""Two calibrations side by side: what moved, and the mistake it is the size of."""

from __future__ import annotations

import json
from math import degrees, radians, sin
from pathlib import Path, PurePath

import numpy as np
import pytest
from calibration.test_mistakes import MEMS
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import chi2, norm

from budget.errors import CallError, SpecError
from budget.inputs import load_device, load_procedure
from budget.names import BETWEEN, DERIVED
from budget.recordings.columns import LIKE
from budget.recordings.history import history
from budget.recordings.lot import lot_of
from budget.recordings.results import (
    change_between,
    is_result,
    read_result,
    read_results,
)

SIX = "six-positions-and-turns"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Provide results: of a unit, of it once more, with a mistake, of another unit."""
    found = tmp_path_factory.mktemp("results")
    (found / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    device = str(found / "mems.yaml")
    for name, seed, more in (
        ("a", "4", ()),
        ("turned", "4", ("--blunder", "turn_sense")),
        ("earth", "4", ("--blunder", "earth_rate_sign")),
        ("other", "5", ()),
    ):
        run, result = (str(found / f"{name}.{kind}") for kind in ("csv", "json"))
        words = ("simulate", device, "--procedure", SIX, "--means", "--rate", "20")
        assert call(*words, "--seed", seed, *more, "-o", run).code == 0
        words = ("calibrate", run, "--procedure", SIX, "--device", device)
        assert call(*words, "--json", result).code in {0, 1}
    return found


def change(folder, first, second, procedure=SIX):
    """Hold two of them beside each other."""
    how = None if procedure is None else load_procedure(procedure)
    sides = (read_result(folder / f"{one}.json") for one in (first, second))
    return change_between(*sides, how)


def test_a_result_is_read_as_it_was_written(folder):
    """Values, units and covariance of the document."""
    found = read_result(folder / "a.json")
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert is_result(folder / "a.json")
    assert found.values.tolist() == [one["value"] for one in document["outputs"]]
    u = [one["standard_uncertainty"] for one in document["outputs"]]
    assert_allclose(np.sqrt(np.diag(found.covariance)), u, rtol=1e-12)


def test_another_unit_has_moved_and_the_same_has_not(folder):
    """By z of the difference, with p below 5 % over all."""
    assert not change(folder, "a", "a").moved
    found = change(folder, "a", "other")
    assert len(found.moved) > 10
    one = found.moved[0]
    assert_allclose(one.z, one.difference / one.standard_uncertainty)
    assert_allclose(one.p, 2.0 * norm.sf(abs(one.z)), rtol=1e-9)
    assert found.level == 0.05 / len(found.parameters)
    assert not found.looks_like


def test_what_is_derived_is_not_counted(folder):
    """Of 24 estimated parameters, as rotations and the like are sums of them."""
    found = change(folder, "a", "other")
    derived = [one for one in found.parameters if one.is_derived]
    assert len(found.parameters) - len(derived) == 24
    assert {x.parameter for x in derived} == {*DERIVED, *BETWEEN}
    assert not any(one.is_derived for one in found.moved)
    said = call("diff", *(str(folder / f"{x}.json") for x in ("a", "other"))).out
    assert f"{len(found.moved)} of 24 estimated parameters moved beyond" in said
    more = sum(one.standing == "moved" for one in derived)
    assert f"Derived of them, {more} of 15 moved" in said


def test_what_some_results_lack_is_named_with_them(folder, tmp_path):
    """Of two, in time and of a lot: left out, and said with the file."""
    paths = [*units(folder, 1.0, n=3)]
    for k, lost in ((1, ("gyro", "bias")), (2, ("gyro", "scale_factor"))):
        made = json.loads(paths[k].read_text(encoding="utf-8"))
        kept = [
            i
            for i, one in enumerate(made["outputs"])
            if (one["sensor"], one["parameter"]) != lost
            or (k == 2 and one["axis"] != "y")
        ]
        made["outputs"] = [made["outputs"][i] for i in kept]
        rows = made["covariance"]
        made["covariance"] = [[rows[i][j] for j in kept] for i in kept]
        paths[k].write_text(json.dumps(made, indent=1), encoding="utf-8")
    whole, biased, scaled = map(read_result, paths)
    found = lot_of(load_device(MEMS), [whole, biased, scaled])
    said = (
        f"not in {paths[1].name}, and so left out: gyro bias",
        f"not in {paths[2].name}, and so left out: gyro scale factor y",
    )
    assert len(found.parameters) == 20
    assert {*map(str, found.warnings)} == {*said}
    of_two = change_between(whole, biased, None)
    assert said[0] in map(str, of_two.warnings)
    for k, path in enumerate(paths):
        made = json.loads(path.read_text(encoding="utf-8"))
        made |= {"serial": "7", "date": f"2026-0{k + 1}-01"}
        made["inputs"]["recording"]["sha256"] = str(k) * 64
        (tmp_path / path.name).write_text(json.dumps(made), encoding="utf-8")
    in_time = history(tmp_path)
    assert len(in_time.parameters) == 20
    assert {*said} <= {*map(str, in_time.warnings)}
    # A data sheet that knows nothing of a sensor is a file that lacks it.
    half = {key: MEMS[key] for key in MEMS if key != "accelerometer"}
    found = lot_of(load_device(half), [whole, biased])
    assert any("accelerometer bias" in str(one) for one in found.warnings)


def test_a_change_of_the_size_of_a_mistake_is_named(folder):
    """In which of the two it was made; without a procedure nobody knows."""
    for first, second, run in (("a", "earth", "second"), ("earth", "a", "first")):
        (found,) = change(folder, first, second).looks_like
        assert (found.mistake.name, found.mistake.sensor) == ("earth_rate_sign", "gyro")
        assert found.run == run
        # Six faces up: 2 w sin L of the vertical axis go into the turns' bias alone.
    (found,) = change(folder, "a", "turned").looks_like
    assert found.mistake.name == "turn_sense"
    assert not change(folder, "a", "turned", procedure=None).looks_like


# One turntable run of a fibre-optic unit in Wuhan (turns there and back about each axis
# pointing up), published twice: the biases of one axis are 15.29 deg/h apart.
WUHAN = "30.531651244 deg"


def test_two_published_results_of_one_run_are_told(tmp_path):
    """2 w sin(latitude) in one axis: its earth rate had the wrong sign."""
    apart = 2.0 * degrees(7.292115e-5) * 3600.0 * sin(radians(30.531651244))
    assert_allclose(apart, 15.28, atol=0.005)
    faces = [
        {"face": f"{axis} {way}", "dwell": "3 min", "use": "accelerometer"}
        for axis in "xyz"
        for way in ("up", "down")
    ]
    turns = [
        {"face": f"{axis} up", "turn": "vertical", "turns": sign, "rate": "10 deg/s"}
        for axis in "xyz"
        for sign in (1, -1)
    ]
    how = {"name": "turntable", "latitude": WUHAN, "gravity": "9.7936174 m/s^2"}
    how |= {"sample_rate": "100 Hz", "windows": [*faces, *turns]}
    procedure, run, first = (
        str(tmp_path / name) for name in ("how.yaml", "run.csv", "first.json")
    )
    Path(procedure).write_text(json.dumps(how), encoding="utf-8")
    words = ("--procedure", procedure)
    call("simulate", "zhao-2019", *words, "--means", "--seed", "1", "-o", run)
    call("calibrate", run, *words, "--device", "zhao-2019", "--json", first)
    document = json.loads(Path(first).read_text(encoding="utf-8"))
    (bias,) = (
        one
        for one in document["outputs"]
        if (one["sensor"], one["parameter"], one["axis"]) == ("gyro", "bias", "y")
    )
    bias["value"] -= 15.29
    document["inputs"]["recording"]["sha256"] = "1" * 64
    second = tmp_path / "second.json"
    second.write_text(json.dumps(document), encoding="utf-8")
    found = change_between(
        read_result(first), read_result(second), load_procedure(procedure)
    )
    (looks,) = found.looks_like
    assert (looks.mistake.name, looks.mistake.axis) == ("earth_rate_sign", "y")
    assert looks.run == "either"
    said = " ".join(call("diff", first, str(second), *words).out.split())
    assert "the earth rate with the wrong sign, in axis y alone" in said
    assert_allclose(chi2.isf(0.001, 12), 32.9, rtol=1e-3)
    bias["value"] += 1.0  # 25 u from it
    second.write_text(json.dumps(document), encoding="utf-8")
    assert "wrong sign" not in call("diff", first, str(second), *words).out


def test_diff_says_it(folder):
    """On a terminal, as JSON, as CSV; three of them are refused."""
    a, earth = (str(folder / f"{one}.json") for one in ("a", "earth"))
    found = call("diff", a, earth, "--procedure", SIX, "--json", "-")
    assert found.code == 0
    document = json.loads(found.out)
    assert document["looks_like"][0]["name"] == "earth_rate_sign"
    said = " ".join(call("diff", a, earth, "--procedure", SIX).out.split())
    assert "the change is the size of a mistake in earth.json" in said
    assert call("diff", a, earth, a).code == 2


WIDER = ("--set", "gyro.bias_stability=1 deg/h")


@pytest.mark.parametrize(
    ("words", "idle"),
    [
        (("diff", "a.json", "earth.json"), ("-o", "page.html")),
        (("diff", "mems.yaml", "a.json", "earth.json"), ("-o", "page.html")),
        (("diff", "a.json", "earth.json"), ("--mission", "bench")),
        (("diff", "a.json", "earth.json"), WIDER),
        (("diff", "mems.yaml", "a.json", "earth.json"), ("--procedure", SIX)),
        (("history", "a.json"), WIDER),
        (("calibrate", "a.csv", "--procedure", SIX), WIDER),
        (
            ("simulate", "mems.yaml", "--static", "9 s", "-o", "s.csv"),
            ("--station", "ideal"),
        ),
        (("characterise", "a.csv"), ("--procedure", SIX)),
    ],
)
def test_what_changes_nothing_is_refused(folder, monkeypatch, words, idle):
    """A page or an option is never left out in silence: it is named."""
    monkeypatch.chdir(folder)
    before = {*folder.iterdir()}
    assert idle[0] in call(*words, *idle, code=2).err
    assert {*folder.iterdir()} == before


def test_a_result_is_known_however_it_is_laid_out(folder, tmp_path):
    """Sorted, on one line, without spaces: a result, and never a device file."""
    made = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    path = tmp_path / "a.json"
    for spaces in ((",", ":"), (" ,", " : ")):
        path.write_text(
            json.dumps(made, sort_keys=True, separators=spaces), encoding="utf-8"
        )
        assert is_result(path)
    path.write_text('{"command": "compare"}', encoding="utf-8")
    assert not is_result(path)


def units(folder, spread, n=6):
    """Write results of a lot whose biases x spread by so much of what is printed."""
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    rng = np.random.default_rng(7)
    for k in range(n):
        made = json.loads(json.dumps(whole)) | {"serial": str(k)}
        for one in made["outputs"]:
            size = spread if (one["parameter"], one["axis"]) == ("bias", "x") else 1.0
            one["value"] = rng.normal() * size * (one["prior"] or 1.0)
        path = folder / f"unit-{k}-{spread:g}.json"
        path.write_text(json.dumps(made, indent=1), encoding="utf-8")
        yield path


def test_the_spread_of_a_lot_is_held_beside_what_is_printed(folder):
    """One that is four times as wide is worse; the others are not."""
    device = load_device(MEMS)
    sound = lot_of(device, [read_result(one) for one in units(folder, 1.0)])
    assert len(sound.parameters) == 24
    assert not sound.worse
    paths = [*units(folder, 4.0)]
    found = lot_of(device, [read_result(one) for one in paths])
    assert {(one.parameter, one.axis) for one in found.worse} == {("bias", "x")}
    one = next(x for x in found.parameters if (x.parameter, x.axis) == ("bias", "x"))
    assert_allclose(one.printed, 200.0, rtol=1e-9)
    values = [
        read_result(x).values[read_result(x).keys.index(("gyro", "bias", "x"))]
        for x in paths
    ]
    s = np.std(values, ddof=1)
    assert_allclose(one.p, chi2.sf(5 * s**2 / 200.0**2, 5), rtol=0.01)
    # Of six s x 0.6242 to s x 2.4526, as of a repeatability.
    ends = (one.spread_low, one.spread_high)
    assert_allclose(ends, s * np.array([0.6242, 2.4526]), rtol=2e-3)
    said = call("diff", str(folder / "mems.yaml"), *map(str, paths))
    assert said.code == 0
    assert "spread more than is printed" in said.out
    with pytest.raises(CallError, match="are one run, which is counted once"):
        lot_of(device, [read_result(paths[0])] * 2)
    again = json.loads(paths[1].read_text(encoding="utf-8")) | {"serial": "0"}
    again["inputs"]["recording"]["sha256"] = "0" * 64
    paths[1].write_text(json.dumps(again), encoding="utf-8")
    with pytest.raises(CallError, match="are of one unit"):
        lot_of(device, [read_result(one) for one in paths[:2]])


def other(folder, name, change):
    """Write the first result with something else in it."""
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    change(whole)
    (folder / f"{name}.json").write_text(json.dumps(whole), encoding="utf-8")
    return folder / f"{name}.json"


def put(*places, value):
    """Return what puts a value into a document."""

    def change(whole):
        for place in places[:-1]:
            whole = whole[place]
        whole[places[-1]] = value

    return change


def of_u(u):
    """Return what gives the first parameter another u."""

    def change(whole):
        whole["outputs"][0]["standard_uncertainty"] = u
        whole["outputs"][0]["value"] += 1.0
        for k in range(len(whole["outputs"])):
            whole["covariance"][0][k] = whole["covariance"][k][0] = (
                u if u is None else 0.0
            )

    return change


def test_exact_values_moved_where_they_differ(folder):
    """Of u 0; where it is not known that is not told, and nowhere does it look good."""
    for name, more in (("exact", 0.0), ("same", 0.0), ("more", 1.0)):
        path = other(folder, name, of_u(0.0))
        whole = json.loads(path.read_text(encoding="utf-8"))
        whole["outputs"][0]["value"] += more
        path.write_text(json.dumps(whole), encoding="utf-8")
    assert change(folder, "exact", "same").parameters[0].standing == "within"
    one = change(folder, "exact", "more").parameters[0]
    assert (one.standing, one.z, one.p) == ("moved", None, 0.0)
    unknown = other(folder, "unknown", of_u(None))
    one = change(folder, "a", "unknown").parameters[0]
    assert (one.standing, one.z, one.p, one.standard_uncertainty) == (
        "not told",
        None,
        None,
        None,
    )
    said = call("diff", str(folder / "a.json"), str(unknown))
    assert said.code == 0
    assert "Whether 1 parameter moved is not told" in " ".join(said.out.split())


def test_one_run_given_twice_is_said(folder):
    """Of two calibrations, and of a lot, where it is no second unit."""
    assert any("are one run" in str(x) for x in change(folder, "a", "a").warnings)
    copy = folder / "copy-of-a.json"
    copy.write_bytes((folder / "a.json").read_bytes())
    with pytest.raises(CallError, match=r"a.json and copy-of-a.json are one run"):
        lot_of(load_device(MEMS), [read_result(folder / "a.json"), read_result(copy)])


def test_of_a_lot_only_what_is_printed_is_judged(folder):
    """A sheet with the bias of the gyro alone: 3 of 24 are judged, of 21 it is said."""
    sheet = {
        "format": "budget-device/1",
        "name": "prints little",
        "gyro": {"errors": {"bias_repeatability": "200 deg/h"}},
        "accelerometer": {"errors": {"velocity_random_walk": "100 ug/sqrt(Hz)"}},
    }
    (folder / "little.yaml").write_text(json.dumps(sheet), encoding="utf-8")
    paths = [*map(str, units(folder, 1.0, n=3))]
    found = lot_of(load_device(sheet), [read_result(one) for one in paths])
    assert len(found.judged) == 3
    assert len(found.parameters) == 24
    said = " ".join(call("diff", str(folder / "little.yaml"), *paths).out.split())
    assert "None of 3 parameters that are judged spreads more" in said
    assert "Of 21 parameters the spread is not judged" in said


@pytest.mark.parametrize(
    ("places", "value", "said"),
    [
        (
            ("covariance", 3, 3),
            -1.0,
            r"covariance.3.3: found -1.0, expected a variance",
        ),
        (("covariance", 0, 1), 0.5, "covariance.0.1: found 0.5, expected that of"),
        (
            ("covariance", 0, 1),
            1e300,
            "covariance.0.1: found 1e.300, expected a number",
        ),
        (("covariance", 2), [1.0], "covariance.2: found .1.0., expected 39 numbers"),
        (("outputs", 1, "value"), "5", 'outputs.1.value: found "5", expected a number'),
        (("outputs", 1, "value"), float("nan"), "outputs.1.value: found NaN"),
        (("outputs", 1, "value"), None, "outputs.1.value: found nothing"),
        (("outputs", 1, "standard_uncertainty"), -2, "standard_uncertainty: found -2"),
        (("outputs", 1, "standard_uncertainty"), 2, "the root of its variance"),
        (("outputs", 1, "coverage_factor"), 0, "coverage_factor: found 0"),
        (("outputs", 1, "axis"), "x", "outputs.1: .* expected every parameter once"),
        (("outputs", 1, "axis"), "w", 'outputs.1.axis: found "w", expected x, y, z'),
        (("outputs", 1, "unit"), "deg/h", "outputs.1.unit: .* a unit such as ppm"),
        (("is_sound",), "yes", 'is_sound: found "yes", expected true, false or null'),
        (("serial",), "7\x1b[2J", "serial: .* a text of one line"),
    ],
)
def test_what_no_calibration_says_is_refused(folder, places, value, said):
    """With file, key, what was found and what is allowed; exit code 2."""
    path = other(folder, "bad", put(*places, value=value))
    with pytest.raises(SpecError, match=said):
        read_result(path)
    assert call("diff", str(folder / "a.json"), str(path)).code == 2


def test_correlations_that_no_errors_have_are_refused(folder):
    """Three pairs at -0.9 each: every one is allowed, all together are not."""

    def three(whole):
        C = whole["covariance"]
        for i in range(3):
            for k in range(3):
                if i != k:
                    C[i][k] = -0.9 * np.sqrt(C[i][i] * C[k][k])

    path = other(folder, "bad", three)
    with pytest.raises(SpecError, match="no eigenvalue of the correlations below 0"):
        read_result(path)


ODD = (-1, -1e-30, 0, 1e300, -1e300, 1e90, 5e-324, float("nan"), float("inf"), "x")
ODDER = ("", "\n# x", "a|b", None, True, [], {}, [1], 2**70, "9" * 300, "2026-05-31")


def places_in(document, own=()):
    """Yield where every key of a document stands."""
    every = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in [*every]:
        yield (*own, key)
        if isinstance(value, dict | list):
            yield from places_in(value, (*own, key))


def spoilt(document, rng):
    """Return a document with one to three things changed in what is read."""
    found = json.loads(json.dumps(document))
    for _ in range(rng.integers(1, 4)):
        every = [*places_in(found)]
        depth = rng.integers(1, 4)
        own = [one for one in every if len(one) == depth] or every
        *above, key = own[rng.integers(len(own))]
        at = found
        for one in above:
            at = at[one]
        what = rng.integers(8)
        if what == 0:
            del at[key]
        elif what == 1 and isinstance(at, list):
            at.append(at[key])
        elif what > 4 and len(own[0]) == 3 and "outputs" in found:
            rows = found["outputs"]
            row = rows[rng.integers(len(rows))] if rows else {}
            if isinstance(row, dict):
                row["value"] = rng.normal() * 10.0 ** rng.integers(-300, 100)
        else:
            odd = (*ODD, *ODDER)
            at[key] = odd[rng.integers(len(odd))]
    return found


@pytest.mark.parametrize("runs", [3, pytest.param(300, marks=pytest.mark.slow)])
def test_no_result_file_ends_in_a_traceback(folder, tmp_path, runs):
    """History, two side by side, a lot: what was asked, or exit code 2 and words."""
    rng = np.random.default_rng(300)
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    whole = {k: whole[k] for k in list(whole)[: list(whole).index("matrix")]} | {
        "date": "2026-05-01"
    }
    for k, date in enumerate(("2024-05-01", "2025-05-01")):
        (tmp_path / f"{k}.json").write_text(
            json.dumps(whole | {"date": date, "inputs": {}, "serial": ""}),
            encoding="utf-8",
        )
    good, more = str(tmp_path / "0.json"), str(tmp_path / "1.json")
    (tmp_path / "r.yaml").write_text(
        "name: r\nlimits:\n  gyro:\n    bias: 900 deg/h\n", encoding="utf-8"
    )
    device = str(folder / "mems.yaml")
    codes = []
    for k in range(runs):
        bad = tmp_path / "bad.json"
        text = json.dumps(spoilt(whole, rng), indent=1)
        if k % 7 == 0:
            text = text.replace('"serial"', '"serial": "7", "serial"')
        bad.write_text(text, encoding="utf-8")
        wanted = ("--device", device, "--requirement", str(tmp_path / "r.yaml"))
        page = ("-o", str(tmp_path / "o.html"))  # slow
        out = ("--json", str(tmp_path / "o.json"), "--csv", str(tmp_path / "o.csv"))
        for words in (
            ("history", good, more, str(bad), *wanted, *out),
            ("history", good, more, str(bad), *(page if k % 5 == 0 else ())),
            ("diff", good, str(bad), "--procedure", SIX, *out),
            ("diff", device, good, str(bad), *out),
        ):
            found = call(*words)
            assert found.code in {0, 2}, (k, words, found.err)
            assert "Traceback" not in found.err
            assert "nan" not in found.out.split()
            assert found.code == 0 or "bad.json" in found.err or "0.json" in found.err
            codes.append(found.code)
    assert {*codes} == ({0, 2} if runs > 100 else {2})


@pytest.mark.parametrize(
    "text",
    ['{"command": "calibrate"}', '{"command": "calibrate", "outputs": 3}', "[", "NaN"],
)
def test_what_is_no_result_is_refused(tmp_path, folder, text):
    """With its name; whatever stands in it."""
    path = tmp_path / "b.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"b.json.* is no result of a calibration"):
        read_result(path)
    whole = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    whole["outputs"][0]["unit"] = "counts/(deg/s)"
    path.write_text(json.dumps(whole), encoding="utf-8")
    with pytest.raises(CallError, match="calibrate both with, or"):
        change_between(read_result(folder / "a.json"), read_result(path), None)


def test_files_of_one_name_are_told_apart(folder, tmp_path):
    """By the shortest end of their paths that is no other one's; others stay short."""
    for year, name in (("2025", "a"), ("2026", "other")):
        (tmp_path / year).mkdir()
        data = (folder / f"{name}.json").read_bytes()
        (tmp_path / year / "cal.json").write_bytes(data)
    paths = [tmp_path / year / "cal.json" for year in ("2025", "2026")]
    found = read_results([*paths, folder / "a.json"])
    names = [PurePath(one.name).as_posix() for one in found]
    assert names == ["2025/cal.json", "2026/cal.json", "a.json"]
    assert [x.name for x in read_results([paths[0], paths[0]])] == ["cal.json"] * 2


def test_a_singular_covariance_is_said(folder):
    """Two parameters that are known only together: that triad is not looked at."""

    def make_one(whole):
        rows = np.array(whole["covariance"]).reshape((len(whole["outputs"]), -1))
        u = np.sqrt(np.diag(rows))
        rows[1] = rows[0] * u[1] / u[0]
        rows[:, 1] = rows[:, 0] * u[1] / u[0]
        rows[1, 1] = u[1] ** 2
        whole["covariance"] = rows.tolist()

    other(folder, "singular", make_one)
    found = change(folder, "singular", "singular")
    (said,) = [str(x) for x in found.warnings if "no known mistake" in str(x)]
    assert "gyro" in said
    assert "accelerometer" not in said
    whole = change(folder, "a", "other")
    assert not any("no known mistake" in str(x) for x in whole.warnings)


def test_a_lot_in_counts_shares_the_level_over_what_is_judged(folder):
    """Without gain scale factors are not judged: 5 % is over the 18 that are."""
    sound = lot_of(load_device(MEMS), [read_result(x) for x in units(folder, 1.0)])
    assert_allclose(sound.level, 0.05 / 24, rtol=1e-12)
    paths = []
    for path in units(folder, 1.0):
        whole = json.loads(path.read_text(encoding="utf-8"))
        for one in whole["outputs"]:
            if one["parameter"] == "scale_factor" and one["sensor"] in LIKE:
                one["unit"] = f"counts/({LIKE[one['sensor']]})"
        paths.append(path.with_name(f"counts-{path.name}"))
        paths[-1].write_text(json.dumps(whole, indent=1), encoding="utf-8")
    found = lot_of(load_device(MEMS), [read_result(one) for one in paths])
    assert len(found.judged) == 18
    assert_allclose(found.level, 0.05 / 18, rtol=1e-12)


def test_z_stands_beside_its_parameter_at_80_columns(folder):
    """Values to two digits of u, so that one table has room for all columns."""
    out = call("diff", str(folder / "a.json"), str(folder / "other.json")).out
    head = next(one for one in out.splitlines() if one.startswith("parameter"))
    assert head.split()[-2:] == ["unit", "z"]
    assert max(map(len, out.splitlines())) <= 80
