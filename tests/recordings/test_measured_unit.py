"""A unit that was calibrated, in the place of the prediction of its data sheet."""

from __future__ import annotations

import json

import pytest
from command_line import call
from numpy.testing import assert_allclose

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
    ],
)
def test_what_is_no_result_of_this_unit_is_refused(folder, change, said):
    """Exit 2, with the file and what to do."""
    path = mutated(folder, change)
    words = ("mission", str(folder / "unit.yaml"), "--procedure", SIX)
    found = call(*words, "--mission", "bench", "--measured", str(path))
    assert found.code == 2
    assert said in " ".join(found.err.split())
