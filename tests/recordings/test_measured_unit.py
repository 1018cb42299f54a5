"""A unit that was calibrated, in the place of the prediction of its data sheet."""

from __future__ import annotations

import json
import random
from hashlib import sha256

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import t as student

import budget

SIX = "six-positions-and-turns"
UNIT = """
name: unit
gyro:
  errors:
    angle_random_walk: 0.02 deg/sqrt(h)
    bias_stability: {value: 0.2 deg/h, correlation_time: 300 s}
    bias_repeatability: 0.05 deg/h
    scale_factor_repeatability: 20 ppm
    mounting_repeatability: 2 arcsec
    g_sensitivity: 0.5 deg/h/g
accelerometer:
  errors:
    velocity_random_walk: 30 ug/sqrt(Hz)
    bias_stability: {value: 5 ug, correlation_time: 300 s}
    bias_repeatability: 10 ug
    scale_factor_repeatability: 20 ppm
    mounting_repeatability: 2 arcsec
    scale_factor_quadratic: 10 ug/g^2
"""
STATION = """
name: poor
station:
  positioning: 200 arcsec
  levelling: {east: 200 arcsec, north: 200 arcsec}
  azimuth: 1 deg
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Provide a unit's results, of a good and of a poor station."""
    found = tmp_path_factory.mktemp("units")
    (found / "unit.yaml").write_text(UNIT, encoding="utf-8")
    (found / "poor.yaml").write_text(STATION, encoding="utf-8")
    for name, station in (
        ("good", "three-axis-table"),
        ("poor", str(found / "poor.yaml")),
    ):
        at = ("--procedure", SIX, "--station", station)
        run, sheet = str(found / f"{name}.csv"), str(found / "unit.yaml")
        simulate = ("simulate", sheet, *at, "--means", "--seed", "3", "-o", run)
        assert call(*simulate).code == 0
        made = ("calibrate", run, *at, "--device", sheet, "--serial", name)
        assert call(*made, "--json", str(found / f"{name}.json")).code == 0
    return found


def used(folder, mission, *more):
    """Return the document of a mission."""
    out = folder / "out.json"
    words = ("mission", str(folder / "unit.yaml"), "--procedure", SIX)
    rest = ("--mission", mission, "--no-validate", "--json", str(out))
    assert call(*words, *rest, *more).code == 0
    return json.loads(out.read_text(encoding="utf-8"))


def sizes(document):
    """Return the standard uncertainties."""
    return [one["standard_uncertainty"] for one in document["outputs"]]


@pytest.mark.slow
@pytest.mark.parametrize("mission", ["bench", "car-drive"])
@pytest.mark.parametrize("name", ["good", "poor"])
def test_the_same_estimator_gives_the_prediction(folder, mission, name):
    """With the device and the station of the run the covariance is the budget's."""
    station = "three-axis-table" if name == "good" else str(folder / "poor.yaml")
    predicted = used(folder, mission, "--station", station)
    found = used(folder, mission, "--measured", str(folder / f"{name}.json"))
    assert_allclose(sizes(found), sizes(predicted), rtol=1e-9)
    assert found["inputs"]["measured"]["name"] == f"{name}.json"


def drop(document, k):
    """Take a parameter out of the covariance too."""
    rows = document["covariance"]
    document["covariance"] = [
        [x for j, x in enumerate(row) if j != k] for i, row in enumerate(rows) if i != k
    ]
    return True


def mutated(folder, change):
    """Write a result that is changed."""
    document = json.loads((folder / "good.json").read_text(encoding="utf-8"))
    change(document)
    path = folder / "changed.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(is_sound=False), "not sound"),
        (lambda d: d.update(title="other"), "calibration of 'other'"),
        (lambda d: d.update(procedure="other"), "calibrated by 'other'"),
        (lambda d: d.update(lower_bound=True), "lower bounds"),
        (lambda d: d["outputs"][0].update(unit="counts/(deg/s)"), "in counts"),
        (lambda d: d.update(outputs=[]), "is no result"),
        (lambda d: d["outputs"].pop(0) and drop(d, 0), "says nothing of gyro.scale"),
        (lambda d: d["inputs"]["device"].update(sha256="0" * 64), "another device"),
        (lambda d: d["inputs"].pop("procedure"), "another procedure"),
        (
            lambda d: d["inputs"]["device"].update(changes=[{"line": "gyro.x"}]),
            "laid over",
        ),
    ],
)
def test_what_is_no_result_of_this_unit_is_refused(folder, change, said):
    """Exit 2, with the file and what to do."""
    path = mutated(folder, change)
    words = ("mission", str(folder / "unit.yaml"), "--procedure", SIX)
    found = call(*words, "--mission", "bench", "--measured", str(path))
    assert found.code == 2
    assert said in " ".join(found.err.split())


# Place of the angle in the rows of S: S[i, j] is e_ijk theta_ik, and its sign.
ANGLES = {
    "xy": (0, 2, -1.0),
    "xz": (0, 1, 1.0),
    "yx": (1, 2, 1.0),
    "yz": (1, 0, -1.0),
    "zx": (2, 1, -1.0),
    "zy": (2, 0, 1.0),
}
UNITS = {
    "ppm": 1e-6,
    "arcsec": np.pi / 180.0 / 3600.0,
    "deg/h": np.pi / 180.0 / 3600.0,
    "ug": 9.80665e-6,
}


def of_input(document, sensor, given):
    """Return what each parameter puts into a reading at an input, (3, n) [SI]."""
    rows = np.zeros((3, len(document["outputs"])))
    for k, one in enumerate(document["outputs"]):
        if one["sensor"] != sensor or one["parameter"] not in {
            "scale_factor",
            "mounting_angle",
            "bias",
        }:
            continue
        i, j, sign = ANGLES.get(
            one["axis"], (*[max("xyz".find(one["axis"]), 0)] * 2, 1)
        )
        size = 1.0 if one["parameter"] == "bias" else given[j]
        rows[i, k] = sign * size * UNITS[one["unit"]]
    return rows


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_errors_at_rest_are_those_of_the_covariance(tmp_path, seed):
    """Level, at rest, heading north at 45 deg, after 10 s: a t^2/2 and w t.

    By the covariance of the file alone. What a turn of w t puts into the position is
    below 1e-2 of it and independent, so below 1e-4; the earth turns by 7e-4.
    """
    sheet = "\n".join(
        line
        for line in UNIT.splitlines()
        if "g_sens" not in line and "quadratic" not in line
    )
    files = {"unit.yaml": sheet, "poor.yaml": STATION.replace("200", str(100 * seed))}
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    unit, run = str(tmp_path / "unit.yaml"), str(tmp_path / "run.csv")
    at = ("--procedure", SIX, "--station", str(tmp_path / "poor.yaml"))
    assert call("simulate", unit, *at, "--means", "--seed", seed, "-o", run).code == 0
    made = ("calibrate", run, *at, "--device", unit)
    assert call(*made, "--json", str(tmp_path / "own.json")).code == 0
    document = json.loads((tmp_path / "own.json").read_text(encoding="utf-8"))
    C = np.array(document["covariance"])
    rest = ("--measured", str(tmp_path / "own.json"), "--only", "calibration.result")
    found = {
        (one["parameter"], one["axis"]): one["standard_uncertainty"]
        for one in used(tmp_path, "bench", *rest)["outputs"]
        if one["time"] == 10.0
    }
    g, rate, root = 9.80665, 7.292115e-5, np.sqrt(0.5)
    t = 10.0
    # Right, forward, up.
    force = of_input(document, "accelerometer", (0.0, 0.0, g))
    turn = of_input(document, "gyro", (0.0, rate * root, rate * root))
    north, east = force[1] * t**2 / 2.0, force[0] * t**2 / 2.0
    arcsec = UNITS["arcsec"]
    for key, row in {
        ("position", "north"): north,
        ("position", "east"): east,
        ("attitude", "roll"): turn[1] * t / arcsec,
        ("attitude", "heading"): turn[2] * t / arcsec,
    }.items():
        assert_allclose(found[key], np.sqrt(row @ C @ row), rtol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_trials_agree_with_the_law(folder, seed):
    """Standard deviations of 10000 trials are within 4.5 of theirs, 1/sqrt(2 n)."""
    file = ("--measured", str(folder / "poor.json"))
    law = used(folder, "bench", *file)
    drawn = used(
        folder,
        "bench",
        *(*file, "--method", "monte-carlo", "--trials", "10000", "--seed", seed),
    )
    assert_allclose(sizes(drawn), sizes(law), rtol=4.5 / np.sqrt(2e4))


def test_a_simulation_of_what_is_predicted_is_refused(folder):
    """It would leave out what was measured."""
    words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX)
    file = ("--measured", str(folder / "good.json"))
    found = call(*words, *file, "--method", "simulation")
    assert found.code == 2
    assert "--measured is of one that was done" in " ".join(found.err.split())


def test_another_table_than_that_of_the_run_is_refused(folder):
    """A result that counts its table takes no other one."""
    words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX)
    file = ("--measured", str(folder / "good.json"))
    found = call(*words, *file, "--station", str(folder / "poor.yaml"))
    assert found.code == 2
    assert "another station than poor.yaml" in " ".join(found.err.split())


LIMITS = """
name: limits
limits:
  accelerometer:
    mounting_angle: 20 arcsec
"""


@pytest.mark.slow
def test_the_poor_unit_of_a_sheet_fails_and_the_good_one_meets(folder):
    """Each unit is one more candidate, after its own run."""
    (folder / "limits.yaml").write_text(LIMITS, encoding="utf-8")
    words = ("compare", str(folder / "unit.yaml"), "--procedure", SIX)
    files = [str(folder / f"{name}.json") for name in ("good", "poor")]
    out = folder / "compared.json"
    found = call(
        *(*words, "--measured", files[0], "--measured", files[1]),
        *("--requirement", str(folder / "limits.yaml"), "--json", str(out)),
    )
    assert found.code == 1
    document = json.loads(out.read_text(encoding="utf-8"))
    verdicts = {one["name"]: one["verdict"] for one in document["devices"]}
    assert verdicts["unit (unit poor)"] == "fails"
    assert verdicts["unit (unit good)"] == "meets_if"
    named = {one["name"] for one in document["inputs"]}
    assert {"good.json", "poor.json", "unit.yaml"} <= named
    for name, code in (("good", 0), ("poor", 1)):
        words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX)
        one = call(
            *(*words, "--measured", str(folder / f"{name}.json")),
            *("--requirement", str(folder / "limits.yaml"), "--exit-code"),
            *("--no-validate", "--accept", "meets_if"),
        )
        assert one.code == code


@pytest.mark.slow
def test_every_unit_stands_in_a_brief_answer(folder, tmp_path):
    """Beyond the three that are best, too: whoever gives a result asks for it."""
    (tmp_path / "limits.yaml").write_text(LIMITS, encoding="utf-8")
    words = ["compare", str(folder / "unit.yaml"), "--procedure", SIX]
    names = ("first", "second", "third", "fourth")
    for name in names:
        one = json.loads((folder / "poor.json").read_text(encoding="utf-8"))
        own = tmp_path / f"{name}.json"
        own.write_text(json.dumps({**one, "serial": name}), encoding="utf-8")
        words += ["--measured", str(own)]
    found = call(*words, "--requirement", str(tmp_path / "limits.yaml"))
    assert all(f"(unit {name})" in found.out for name in names)


@pytest.mark.slow
def test_pages_have_what_was_measured(folder, tmp_path):
    """A report of a unit names it, its file and its share; also on a mission."""
    page = tmp_path / "page.html"
    file = folder / "poor.json"
    words = ("report", str(folder / "unit.yaml"), "--procedure", SIX, "--full")
    rest = ("--measured", str(file), "--mission", "bench", "--no-validate")
    assert call(*words, *rest, "-o", str(page)).code == 0
    text = page.read_text(encoding="utf-8")
    assert "unit (unit poor)" in text
    assert "calibration result" in text
    assert sha256(file.read_bytes()).hexdigest() in text


@pytest.mark.slow
def test_no_calibration_has_nothing_of_what_was_measured(folder):
    """What the unit would be without a test is that of its sheet."""
    own = used(folder, "bench", "--measured", str(folder / "poor.json"))
    sheet = used(folder, "bench")
    cep = [
        [one["cep"] for one in found["mission"]["calibrations"][:2]]
        for found in (own, sheet)
    ]
    assert cep[0] == cep[1]


def test_an_export_names_the_unit(folder):
    """File, its SHA-256, serial number."""
    out = folder / "unit.m"
    words = ("export", str(folder / "unit.yaml"), "--procedure", SIX, "--to", "matlab")
    file = folder / "good.json"
    more = ("--residual", "--rate", "200", "-o", str(out))
    assert call(*words, "--measured", str(file), *more).code == 0
    text = "".join(out.read_text(encoding="utf-8").replace("%", " ").split())
    digest = sha256(file.read_bytes()).hexdigest()
    assert digest in text
    assert "measuredgood.json" in text
    assert "serialnumbergood" in text
    refused = call(*words, "--measured", str(file), "--rate", "200", "-o", str(out))
    assert refused.code == 2


def test_a_scatter_is_of_noise_alone(folder):
    """Table and place are those of the station; that it is sound is not told."""
    run, result = str(folder / "good.csv"), str(folder / "scatter.json")
    assert call("calibrate", run, "--procedure", SIX, "--json", result).code == 0
    document = json.loads((folder / "scatter.json").read_text(encoding="utf-8"))
    alone = used(folder, "bench", "--measured", result)
    said = " ".join(alone["warnings"])
    assert "sound is not told" in said
    assert "table and place are taken as exact" in said
    station = ("--station", str(folder / "poor.yaml"))
    at_table = used(folder, "bench", "--measured", result, *station)
    assert sizes(at_table)[0] > 20.0 * sizes(alone)[0]
    found = folder / "as_tested.json"
    words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX, "--no-validate")
    only = ("--only", "calibration.result", "--reference", "as_tested")
    asked = (*words, *only, "--measured", result, "--json", str(found))
    assert call(*asked).code == 0
    rows = json.loads(found.read_text(encoding="utf-8"))["outputs"]
    of_file = [one for one in document["outputs"] if one["sensor"] != "imu"]
    known = {(x["sensor"], x["parameter"], x["axis"]): x for x in of_file}
    for own in rows:
        told = known[own["sensor"], own["parameter"], own["axis"]]
        u = told["standard_uncertainty"]
        width = (own["interval"][1] - own["interval"][0]) / 2.0
        # Of a scale factor relative to it.
        assert_allclose(own["standard_uncertainty"], u, rtol=1e-4)
        k = student.ppf(0.975, told["degrees_of_freedom"])  # by trials
        assert_allclose(width, k * u, rtol=0.03)


WARM = """
name: warm
gyro:
  errors:
    angle_random_walk: 0.02 deg/sqrt(h)
    bias_repeatability: 0.05 deg/h
    bias_temperature_coefficient: 0.03 deg/h/degC
    scale_factor_temperature_coefficient: -0.4 ppm/degC
accelerometer:
  errors:
    velocity_random_walk: 30 ug/sqrt(Hz)
    bias_repeatability: 10 ug
    bias_temperature_coefficient:
      axes: {x: 20 ug/degC, y: -10 ug/degC, z: 5 ug/degC}
    scale_factor_temperature_coefficient: 0.3 ppm/degC
"""
HOT = """
name: hot
station:
  positioning: 20 arcsec
  levelling: {east: 10 arcsec, north: 10 arcsec}
environment:
  temperature: {ramp: 2 degC/h}
"""
PER_DEGREE = {
    ("gyro", "bias"): (0.03, 0.03, 0.03),
    ("gyro", "scale_factor"): (-0.4, -0.4, -0.4),
    ("accelerometer", "bias"): (20.0, -10.0, 5.0),
    ("accelerometer", "scale_factor"): (0.3, 0.3, 0.3),
}
REPEATED = {"gyro": 0.05, "accelerometer": 10.0}


@pytest.mark.slow
def test_use_at_another_temperature_by_hand(tmp_path):
    """Run at 35 degC, with a ramp of its own; used at 20 degC, 1 sigma.

    By numpy alone: one temperature T moves all by coefficients k, a repeatability R
    counts at both turn-ons, and the ramp of the run is in C, once: the covariance is
    C + T^2 k k' + 2 R^2. The square of a change of scale, 6 ppm, is below 1e-10 of it.
    """
    for name, text in (("warm.yaml", WARM), ("hot.yaml", HOT)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    sheet, run = str(tmp_path / "warm.yaml"), str(tmp_path / "run.csv")
    at = ("--procedure", SIX, "--station", str(tmp_path / "hot.yaml"))
    assert call("simulate", sheet, *at, "--means", "--seed", "5", "-o", run).code == 0
    file, out = str(tmp_path / "own.json"), str(tmp_path / "out.json")
    assert call("calibrate", run, *at, "--device", sheet, "--json", file).code == 0
    words = ("analyze", sheet, "--procedure", SIX, "--measured", file, "--no-validate")
    use = ("--environment", "temperature 15 degC", "--reference", "next_turn_on")
    assert call(*words, *use, "--json", out).code == 0
    result, found = (
        json.loads((tmp_path / name).read_text(encoding="utf-8"))
        for name in ("own.json", "out.json")
    )
    keys = [
        [(one["sensor"], one["parameter"], one["axis"]) for one in document["outputs"]]
        for document in (result, found)
    ]
    at = [keys[0].index(key) for key in keys[1]]
    C = np.array(result["covariance"], dtype=float)[np.ix_(at, at)]
    of_scale = np.array([key[1] == "scale_factor" for key in keys[1]])
    values = np.array([result["outputs"][k]["value"] for k in at])
    size = np.where(of_scale, 1.0 / (1.0 + 1e-6 * values), 1.0)  # relative to it
    k = np.array(
        [
            PER_DEGREE[key[:2]]["xyz".index(key[2])] if key[:2] in PER_DEGREE else 0.0
            for key in keys[1]
        ]
    )
    repeated = [REPEATED[key[0]] * (key[1] == "bias") for key in keys[1]]
    expected = C * np.outer(size, size) + 15.0**2 * np.outer(k, k)
    expected += np.diag(2.0 * np.square(repeated))
    u = np.sqrt(np.diag(expected))
    covariance = np.array(found["covariance"], dtype=float)
    assert_allclose(
        covariance / np.outer(u, u), expected / np.outer(u, u), rtol=0.0, atol=1e-9
    )
    assert_allclose(sizes(found), u, rtol=1e-9)


LINES = """
name: both
limits:
  accelerometer: {mounting_angle: 20 arcsec, bias: 100 ug}
  gyro: {bias: 1 deg/h}
"""


@pytest.mark.slow
def test_a_sheet_on_an_ideal_table_is_no_better_than_its_unit(folder):
    """Said once where both stand together; at the station of the run both are alike."""
    (folder / "both.yaml").write_text(LINES, encoding="utf-8")
    out, page = str(folder / "compared.json"), folder / "compared.html"
    words = ("compare", str(folder / "unit.yaml"), "--procedure", SIX)
    rest = ("--requirement", str(folder / "both.yaml"), "--json", out)
    unit = ("--measured", str(folder / "good.json"))
    said = "a sheet looks better than its own unit"
    found = call(*words, *rest, *unit, "-o", str(page))
    document = json.loads((folder / "compared.json").read_text(encoding="utf-8"))
    assert sum(said in one for one in document["warnings"]) == 1
    assert said in " ".join(found.out.split())
    assert said in page.read_text(encoding="utf-8")
    files = {one["name"]: one.get("measured") for one in document["devices"]}
    assert files == {"unit": None, "unit (unit good)": "good.json"}
    call(*words, *rest, *unit, "--station", "three-axis-table")
    document = json.loads((folder / "compared.json").read_text(encoding="utf-8"))
    assert not any(said in one for one in document["warnings"])
    used_of = {
        (one["name"], one["sensor"]): one["utilisation"] for one in document["devices"]
    }
    for sensor in ("gyro", "accelerometer"):
        # By trials: the largest of several outputs, and Student's t of the result.
        own, sheet = used_of["unit (unit good)", sensor], used_of["unit", sensor]
        assert_allclose(own, sheet, rtol=0.02)
    call(*words, *rest)
    document = json.loads((folder / "compared.json").read_text(encoding="utf-8"))
    assert not any(said in one for one in document["warnings"])


def test_a_result_may_be_a_document(folder):
    """In the library: of a mapping it is as of its file, and nothing is read."""
    device = budget.load_device(str(folder / "unit.yaml"))
    whole = json.loads((folder / "good.json").read_text(encoding="utf-8"))
    both = [
        budget.analyze(device, procedure=SIX, measured=[one], validate=False)
        for one in (str(folder / "good.json"), whole)
    ]
    u = [[row.standard_uncertainty for row in one.outputs] for one in both]
    assert u[0] == u[1]


def test_a_part_larger_than_the_whole_leaves_nothing():
    """Of C less its part what is negative is 0, and no variance is above C."""
    from budget.recordings.measured_unit import _without

    C = np.array([[4.0, 1.0], [1.0, 1.0]])
    assert_allclose(_without(C, 9.0 * np.eye(2)), np.zeros((2, 2)), atol=1e-15)
    assert_allclose(_without(C, np.zeros((2, 2))), C, rtol=1e-12)
    left = _without(C, np.diag([0.0, 9.0]))
    assert np.linalg.eigvalsh(left)[0] >= -1e-12


def test_two_devices_or_two_results_are_refused(folder):
    """A result is of one device, and a device has one."""
    sheet, file = str(folder / "unit.yaml"), str(folder / "good.json")
    words = ("analyze", sheet, "--procedure", SIX)
    two = call(*words, "--measured", file, "--measured", str(folder / "poor.json"))
    assert two.code == 2
    assert "several results" in two.err
    same = call(*words, "--measured", file, "--measured", file)
    assert same.code == 2


ODD = (None, True, -1, 0, 1e308, -1e308, float("nan"), "", "x" * 500, [], {}, [[1]])


def test_no_mutation_of_a_result_is_a_fault(folder, tmp_path):
    """240 results with a key gone or odd: read, or refused in a sentence."""
    whole = (folder / "good.json").read_text(encoding="utf-8")
    path = tmp_path / "odd.json"
    words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX)
    for seed in range(240):
        draw = random.Random(seed)  # noqa: S311 - no secret
        document = json.loads(whole)
        for key in ("windows", "matrix", "assumptions", "unseen"):
            document.pop(key)
        place, key = document, draw.choice([*document])
        while (
            isinstance(place[key], dict | list) and place[key] and draw.random() < 0.8
        ):
            place = place[key]
            key = draw.choice(
                [*place] if isinstance(place, dict) else range(len(place))
            )
        if draw.random() < 0.3:
            del place[key]
        else:
            place[key] = draw.choice(ODD)
        path.write_text(json.dumps(document), encoding="utf-8")
        found = call(*words, "--no-validate", "--measured", str(path))
        assert found.code in {0, 2}, (seed, found.err)
        assert "Traceback" not in found.err
        assert found.code == 0 or len(found.err.splitlines()) < 8, found.err


def test_what_is_no_file_is_refused(folder, tmp_path):
    """Empty, a folder, a loop of links, bytes, a name with control characters."""
    loop = tmp_path / "loop.json"
    loop.symlink_to(loop)
    (tmp_path / "empty.json").write_bytes(b"")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00{")
    (tmp_path / "deep.json").write_text("[" * 100_000, encoding="utf-8")
    words = ("analyze", str(folder / "unit.yaml"), "--procedure", SIX, "--measured")
    names = ["loop.json", "empty.json", "bytes.json", "deep.json", "gone\n.json", "."]
    for name in names:
        found = call(*words, str(tmp_path / name))
        assert found.code == 2, (name, found.err)
        assert "Traceback" not in found.err


@pytest.mark.slow
def test_what_a_sheet_lacks_stays_a_lower_bound(tmp_path):
    """Noise that the sheet does not give is not in the result; a stand-in counts."""
    sheet, file = tmp_path / "lack.yaml", tmp_path / "lack.json"
    lines = [x for x in UNIT.splitlines() if "angle_random_walk" not in x]
    sheet.write_text("\n".join(lines), encoding="utf-8")
    run, at = str(tmp_path / "run.csv"), ("--procedure", SIX)
    one = ("simulate", str(sheet), *at, "--means", "--seed", "5", "-o", run)
    assert call(*one).code == 0
    made = ("calibrate", run, *at, "--device", str(sheet), "--json", str(file))
    assert call(*made).code == 0
    assert json.loads(file.read_text(encoding="utf-8"))["lower_bound"]
    found = {}
    for key, rest in {
        "own": ("--measured", str(file)),
        "sheet": (),
        "worst": ("--measured", str(file), "--missing", "worst"),
        "sheet, worst": ("--missing", "worst"),
    }.items():
        out = tmp_path / "out.json"
        words = ("analyze", str(sheet), *at, "--no-validate", "--json", str(out))
        assert call(*words, *rest).code == 0
        found[key] = json.loads(out.read_text(encoding="utf-8"))["outputs"]
    for own, predicted in (("own", "sheet"), ("worst", "sheet, worst")):
        for x, y in zip(found[own], found[predicted], strict=True):
            assert x["lower_bound"] == y["lower_bound"]
            u = [one["standard_uncertainty"] for one in (x, y)]
            assert_allclose(*u, rtol=1e-9)
