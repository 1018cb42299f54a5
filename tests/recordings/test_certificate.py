"""Certificates: errors as found and as left, environment, what a station rests on."""

from __future__ import annotations

import json
from html import unescape

import numpy as np
import pytest
import yaml
from calibration.test_mistakes import MEMS
from command_line import call
from numpy.testing import assert_allclose
from scipy.stats import chi2, ncx2

from budget.calibration.schemes import schemes_of, windows_of
from budget.errors import CallError, SpecError
from budget.inputs import load_device, load_procedure, load_recording
from budget.model.response import COLUMN, ROW
from budget.names import ANGLES, AXES
from budget.recordings.calibrate import calibrate
from budget.recordings.columns import LIKE
from budget.recordings.run_soundness import unseen_mistakes
from budget.recordings.simulated_run import simulated_run
from budget.report.correction import correction_code

SIX = "six-positions-and-turns"
NORM = "norm-eighteen-positions"
# In the units of documents: what an earlier correction is off the truth by.
OFF = {"scale_factor": 800.0, "mounting_angle": 90.0, "bias": -400.0}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Provide a folder with a device and a run of it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mems.yaml").write_text(json.dumps(MEMS), encoding="utf-8")
    made = simulated_run("mems.yaml", procedure=SIX, seed=4, means=True)
    (tmp_path / "run.csv").write_text("".join(made.csv()), encoding="utf-8")
    return tmp_path


def words(*more, run="run.csv"):
    """Calibrate a run beside the data sheet."""
    return "calibrate", run, "--procedure", SIX, "--device", "mems.yaml", *more


def truths(made, sensor):
    """Return what was drawn, by parameter, in the units of documents."""
    own, arcsec = made.turn_ons[sensor], np.pi / 180.0 / 3600.0
    size = arcsec if sensor == "gyro" else 9.80665e-6
    return {
        "scale_factor": dict(zip("xyz", own.k / 1e-6, strict=True)),
        "mounting_angle": dict(
            zip(("xy", "xz", "yx", "yz", "zx", "zy"), own.angle / arcsec, strict=True)
        ),
        "bias": dict(zip("xyz", own.bias / size, strict=True)),
    }


def test_errors_as_found_are_those_of_the_correction_in_force(folder):
    """An earlier result that is off the truth by known amounts: these, to their U."""
    made = simulated_run("mems.yaml", procedure=SIX, seed=4, means=True)
    assert call(*words("--json", "before.json", "--date", "2026-01-05")).code == 0
    before = json.loads((folder / "before.json").read_text(encoding="utf-8"))
    for one in before["outputs"]:
        if one["parameter"] in OFF:
            truth = truths(made, one["sensor"])[one["parameter"]][one["axis"]]
            one["value"] = truth - OFF[one["parameter"]]
    (folder / "before.json").write_text(json.dumps(before, indent=1), encoding="utf-8")
    more = ("--as-found", "before.json", "--date", "2026-05-31", "--json", "a.json")
    found = call(*words(*more))
    assert found.code == 0
    assert "As found: with the correction of before.json" in found.out
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert document["as_found"]["date"] == "2026-01-05"
    assert document["inputs"]["as found"]["name"] == "before.json"
    rows = [one for one in document["outputs"] if one["parameter"] in OFF]
    pulls = [
        (one["as_found"] - OFF[one["parameter"]]) / one["standard_uncertainty"]
        for one in rows
    ]
    assert len(rows) == 24
    # 24 of a normal: the largest is above 4 in one of 650 such sets.
    assert np.abs(pulls).max() < 4.0
    assert chi2.sf(np.sum(np.square(pulls)), len(pulls)) > 1e-3
    for one in document["outputs"]:
        u = one["coverage_factor"] * one["standard_uncertainty"]
        assert_allclose(one["as_left"], u, rtol=1e-12)


def test_without_an_earlier_result_errors_as_found_are_of_the_uncorrected_unit(folder):
    """Value less the nominal one, in JSON, and said."""
    found = call(*words("--json", "a.json"))
    assert "As found: without correction" in found.out
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    assert document["as_found"] is None
    for one in document["outputs"]:
        assert_allclose(one["as_found"], one["value"], rtol=1e-12)  # nominal 0
        assert one["found_standing"] is None


def test_an_error_as_found_meets_fails_or_is_open_by_its_u(folder):
    """|e| + U within the limit meets, |e| - U above it fails, between it is open."""
    plain = calibrate("run.csv", procedure=SIX, device="mems.yaml")
    one = next(x for x in plain.outputs if (x.parameter, x.axis) == ("bias", "x"))
    e, U = abs(one.as_found), one.expanded
    assert e > 2.0 * U
    for limit, is_found, is_left in (
        (e + 1.01 * U, "meets", "meets"),
        (e + 0.99 * U, "undecided", "meets"),
        (e - 0.99 * U, "undecided", "meets"),
        (e - 1.01 * U, "fails", "meets"),
        (0.99 * U, "fails", "fails"),
    ):
        (folder / "r.yaml").write_text(
            "name: r\nreference: as_tested\nlimits: {gyro: {bias: {x: "
            f"{limit / one.si_per_unit:.9g} {one.unit}}}}}}}\n",
            encoding="utf-8",
        )
        found = calibrate(
            "run.csv", procedure=SIX, device="mems.yaml", requirement="r.yaml"
        )
        own = next(x for x in found.outputs if x.limit is not None)
        assert (own.found_standing, own.left_standing) == (is_found, is_left)
        assert len(found.failed_as_found) == (is_found == "fails")
        bare = call(
            *("calibrate", "run.csv", "--procedure", SIX, "--requirement", "r.yaml")
        )
        said = "1 parameter is not known as well as required; whether the run was sound"
        assert (said in " ".join(bare.out.split())) == (bare.code == 1)


def test_a_run_that_is_not_sound_has_no_verdict(folder):
    """Its values are not to be used, as found either."""
    made = simulated_run(
        "mems.yaml", procedure=SIX, seed=4, means=True, blunders=["turn_sense"]
    )
    (folder / "bad.csv").write_text("".join(made.csv()), encoding="utf-8")
    (folder / "r.yaml").write_text(
        "name: r\nreference: as_tested\nlimits: {gyro: {bias: 1000 deg/h}}\n",
        encoding="utf-8",
    )
    found = calibrate(
        "bad.csv", procedure=SIX, device="mems.yaml", requirement="r.yaml"
    )
    assert found.is_sound is False
    assert {one.found_standing for one in found.outputs} == {None}


def test_an_earlier_result_that_does_not_fit_is_refused(folder):
    """Of a later day, in other units, or no result at all."""
    assert call(*words("--json", "a.json", "--date", "2026-05-31")).code == 0
    found = call(*words("--as-found", "a.json", "--date", "2026-05-30"))
    assert (found.code, "after this run" in found.err) == (2, True)
    document = json.loads((folder / "a.json").read_text(encoding="utf-8"))
    for one in document["outputs"]:
        if one["parameter"] == "scale_factor":
            one["unit"] = f"counts/({LIKE[one['sensor']]})"
    (folder / "b.json").write_text(json.dumps(document), encoding="utf-8")
    assert "with, or without, a gain" in call(*words("--as-found", "b.json")).err
    (folder / "c.json").write_text("{}", encoding="utf-8")
    assert "is no result" in call(*words("--as-found", "c.json")).err


def test_environment_and_day_of_a_run_are_those_of_its_recording_file(folder):
    """Numbers and text, in JSON and on the certificate; they move no number."""
    (folder / "lab.yaml").write_text(
        "recording: run.csv\ndate: 2026-05-31\nenvironment: {temperature: 296.55 K, "
        "humidity: 45 %, pressure: 1.002 kPa, text: laboratory 3}\n",
        encoding="utf-8",
    )
    plain = calibrate("run.csv", procedure=SIX, device="mems.yaml")
    found = calibrate("lab.yaml", procedure=SIX, device="mems.yaml")
    assert found.date == "2026-05-31"
    document = found.to_dict()
    (row,) = document["environment"]
    numbers = [row[key] for key in ("temperature", "humidity", "pressure")]
    assert_allclose(numbers, [23.4, 45.0, 10.02], rtol=1e-12)
    assert row["text"] == "laboratory 3"
    assert [x.value for x in found.outputs] == [x.value for x in plain.outputs]
    assert found.covariance == plain.covariance
    assert call(*words("-o", "a.html", run="lab.yaml")).code == 0
    page = unescape((folder / "a.html").read_text(encoding="utf-8"))
    said = "23.4 \N{DEGREE SIGN}C, 45 % RH, 10.02 hPa, laboratory 3"
    assert said in page.replace("\u202f", " ").replace("\xa0", " ")
    assert call(*words("--date", "2026-06-01", run="lab.yaml")).code == 2
    (folder / "lab.yaml").write_text(
        "recording: run.csv\nenvironment: a cold morning\n", encoding="utf-8"
    )
    assert load_recording("lab.yaml").environment.text == "a cold morning"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("environment: {humidity: 120 %}", "above 100 %"),
        ("environment: {temperature: -300 degC}", "absolute zero"),
        ("environment: {pressure: 1 bar}", "hPa"),
        ("date: yesterday", "is no day"),
    ],
)
def test_an_environment_that_cannot_be_is_refused(folder, line, said):
    """At its place, with what is allowed."""
    (folder / "lab.yaml").write_text(f"recording: run.csv\n{line}\n", encoding="utf-8")
    with pytest.raises(SpecError, match=said):
        load_recording("lab.yaml")


def test_a_serial_number_is_a_text_of_one_line(folder):
    """One that no result could be read back with is refused."""
    failed = call(*words("--serial", "7\n", "--json", "a.json"))
    assert failed.code == 2
    assert "expected a text of one line" in failed.err
    assert not (folder / "a.json").exists()


def test_what_nobody_stated_is_said_so(folder):
    """Environment, dates, serial number and station stand on every certificate."""
    assert call(*words("-o", "a.html")).code == 0
    page = (folder / "a.html").read_text(encoding="utf-8")
    assert "serial number: not stated" in page
    assert "date of the run: not stated" in page
    assert page.count("not stated") >= 4
    assert "No figures of a station are given" in page


def test_figures_of_the_station_are_listed_with_what_they_rest_on(folder):
    """Value, shape, degrees of freedom and source of each; or that it has none."""
    (folder / "table.yaml").write_text(
        "name: table\nstation:\n  turn_angle: {value: 2 arcsec, meaning: max, "
        'source: "certificate 4711 of 2026-02-03"}\n  latitude: 1 arcsec\n',
        encoding="utf-8",
    )
    found = calibrate(
        "run.csv", procedure=SIX, device="mems.yaml", station="table.yaml"
    )
    rows = {one["line"]: one for one in found.to_dict()["station"]}
    assert rows.keys() == {"turn_angle", "latitude"}
    assert rows["turn_angle"]["source"] == "certificate 4711 of 2026-02-03"
    assert rows["turn_angle"]["distributions"] == ["uniform"]
    assert rows["latitude"]["source"] == ""
    assert call(*words("--station", "table.yaml", "-o", "a.html")).code == 0
    page = (folder / "a.html").read_text(encoding="utf-8")
    assert "certificate 4711 of 2026-02-03" in page


def test_what_is_held_has_no_uncertainty(folder):
    """By the norm three angles: null, named in a caution and in the correction."""
    made = simulated_run("mems.yaml", procedure=NORM, seed=4, means=True)
    (folder / "norm.csv").write_text("".join(made.csv()), encoding="utf-8")
    found = calibrate("norm.csv", procedure=NORM, device="mems.yaml")
    (one,) = found.to_dict()["matrix"].values()
    u = np.array(one["standard_uncertainty"], dtype=float)
    held = {
        name.axis
        for name in load_procedure(NORM).held
        if (name.owner, name.quantity) == ("accelerometer", "mounting_angle")
    }
    assert len(held) == 3
    names = set()
    for angle, i, j in zip(ANGLES, ROW, COLUMN, strict=True):
        names |= {f"S {AXES[i]}{AXES[j]}"} if angle in held else set()
        assert np.isnan(u[i, j]) == (angle in held)
        assert np.isnan(u[i, j]) or u[i, j] > 0.0
    assert (np.diag(u) > 0.0).all()
    assert None not in one["bias_standard_uncertainty"]
    made_of = yaml.safe_load(correction_code(found, to="yaml"))["accelerometer"]
    assert {*made_of["not_estimated"]} == names
    for to in ("python", "c"):
        assert "Not estimated, taken as nominal: S " in correction_code(found, to=to)
    assert any("not estimated" in str(x) for x in found.warnings)


@pytest.mark.parametrize("axes", ["y", "xyz", "xy"])
def test_a_reversed_axis_in_counts_has_its_sign_in_its_gain(folder, axes):
    """R stays the rotation it is without the reversal; an odd number is said."""
    made = simulated_run("mems.yaml", procedure=SIX, seed=4, means=True)
    rows = [x.split(",") for x in "".join(made.csv()).splitlines()]
    gain = 2048.0 / 9.80665
    found = {}
    for name, reversed_ in (("plain", ""), ("turned", axes)):
        heads, own = [*rows[0]], [[*row] for row in rows[1:]]
        for k, head in enumerate(heads):
            if head.startswith("acc"):
                heads[k] = head.replace("[m/s^2]", "[counts]")
                sign = -1.0 if head.split("_")[1][0] in reversed_ else 1.0
                for row in own:
                    row[k] = row[k] and f"{sign * gain * float(row[k]):.12g}"
        (folder / f"{name}.csv").write_text(
            "".join(",".join(row) + "\n" for row in [heads, *own]), encoding="utf-8"
        )
        found[name] = calibrate(f"{name}.csv", procedure=SIX, device="mems.yaml")
    plain, turned = (
        next(x for x in found[key].matrix if x.sensor == "accelerometer")
        for key in ("plain", "turned")
    )
    signs = np.array([-1.0 if axis in axes else 1.0 for axis in "xyz"])
    assert_allclose(np.linalg.det(turned.rotation), 1.0, rtol=1e-12)
    assert_allclose(turned.rotation, plain.rotation, rtol=0, atol=1e-9)
    assert_allclose(np.sign(np.diag(turned.triangle)), signs, rtol=0)
    assert_allclose(
        turned.triangle @ turned.rotation, turned.sensor_from_body, rtol=1e-9, atol=1e-9
    )
    said = any("left-handed" in str(one) for one in found["turned"].warnings)
    assert said == (len(axes) % 2 == 1)
    assert not any("left-handed" in str(one) for one in found["plain"].warnings)


def test_exchanged_windows_that_may_be_missed_are_listed():
    """By noncentral chi-square of both tests, here by hand for the worst two."""
    device, procedure = load_device("icm-20948"), load_procedure(SIX)
    found = unseen_mistakes(device, procedure)
    row = next(x for x in found.unseen if x.name == "windows_order")
    from budget.calibration.mistakes import TriadRun

    sensor = next(x for x in device.sensors if x.kind == row.sensor)
    scheme = schemes_of([sensor], procedure)[row.sensor]
    every = enumerate(windows_of(procedure))
    own = [k + 1 for k, one in every if one.use in {row.sensor, "both"}]
    inputs = (scheme.turn + scheme.standing).T
    readings = inputs + sensor.nominal_bias[:, None]
    run = TriadRun.of(sensor, procedure, scheme.schedule, readings, own)
    probabilities = []
    A, C = run.columns, run.covariance
    V = C + A @ np.linalg.inv(run.information) @ A.T
    W = np.linalg.inv(C)
    for one in (x for x in run.known if x.name == "windows_order"):
        shift = (readings[:, list(one.order)] - readings).ravel()
        if np.abs(shift).max() <= 1e-9 * np.abs(inputs).max():
            continue  # equal inputs: no harm
        left = shift - A @ np.linalg.solve(A.T @ W @ A, A.T @ W @ shift)
        tests = (
            (shift @ np.linalg.solve(V, shift), shift.size - run.wide),
            (left @ W @ left, shift.size - 12),
        )
        probabilities.append(
            max(ncx2.sf(chi2.isf(1e-3, nu), nu, size) for size, nu in tests)
        )
    assert_allclose(row.probability, min(probabilities), rtol=1e-4)
    assert 0.0 < row.probability < 0.95
    said = " ".join(call("validate", "icm-20948", SIX).out.split())
    assert "two windows exchanged" in said


def test_limits_that_are_not_judged_have_a_row(folder):
    """Of what the run does not find, by their names."""
    (folder / "r.yaml").write_text(
        "name: r\nreference: as_tested\nlimits: {accelerometer: {bias: 90 mg}}\n",
        encoding="utf-8",
    )
    rows = [x.split(",") for x in (folder / "run.csv").read_text().splitlines()]
    own = [k for k, one in enumerate(rows[0]) if not one.startswith("acc")]
    (folder / "gyro.csv").write_text(
        "".join(",".join(row[k] for k in own) + "\n" for row in rows), encoding="utf-8"
    )
    found = calibrate(
        "gyro.csv", procedure=SIX, device="mems.yaml", requirement="r.yaml"
    )
    names = found.to_dict()["not_judged"]
    assert names == [f"accelerometer.bias.{axis}" for axis in "xyz"]
    with pytest.raises(CallError, match="expected one as"):
        calibrate("run.csv", procedure=SIX, date="May")


def test_degrees_of_freedom_of_the_station_are_carried(folder):
    """By Welch and Satterthwaite; its figures and the day of issue are said once."""
    (folder / "table.yaml").write_text(
        "name: table\nstation:\n  mount: {axes: {x: {value: 30 arcsec, "
        "degrees_of_freedom: 6}, y: 5 arcsec, z: 5 arcsec}}\n",
        encoding="utf-8",
    )
    found = calibrate(
        "run.csv", procedure=SIX, device="mems.yaml", station="table.yaml"
    )
    keys = [(one.sensor, one.parameter, one.axis) for one in found.outputs]
    one = found.outputs[keys.index(("gyro", "mounting_angle", "yx"))]
    arcsec = np.pi / 180.0 / 3600.0
    u = one.standard_uncertainty / arcsec
    assert_allclose(one.degrees_of_freedom, u**4 / (30.0**4 / 6.0), rtol=1e-3)
    text = call(*words("--station", "table.yaml", "-o", "a.html")).out
    said = " ".join(text.split())
    assert "Station table.yaml: mount x 30 arcsec, y 5 arcsec, z 5 arcsec" in said
    assert text.count("30 arcsec") == 1
    page = unescape((folder / "a.html").read_text(encoding="utf-8"))
    assert "issued 20" in page
    assert "station.mount: x 30 arcsec" not in page.split('type="application/json"')[0]


def test_degrees_of_freedom_of_an_environment_are_refused_in_a_sentence(folder):
    """By the level of it others are multiplied: there they have no place in the law."""
    (folder / "table.yaml").write_text(
        "name: table\nenvironment:\n  temperature: {sigma: {value: 1 degC, "
        "degrees_of_freedom: 6}, correlation_time: 100 s}\n",
        encoding="utf-8",
    )
    with pytest.raises(SpecError, match="by this others are multiplied"):
        calibrate("run.csv", procedure=SIX, device="mems.yaml", station="table.yaml")
