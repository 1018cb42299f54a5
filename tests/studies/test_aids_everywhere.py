"""Missions with aids in every study: each has the filter that it says it has."""

from __future__ import annotations

import csv
import io
import json
from functools import cache

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS

from budget.inputs import load_device, load_mission, load_requirement, uncalibrated
from budget.names import MISSION
from budget.question import Question
from budget.settings import Inputs, Settings
from budget.studies.analysis import analyze_as
from budget.studies.comparison.compare import compare
from budget.studies.what_if import what_if

DATA = TESTS / "data" / "aided"
G1 = DATA / "g1.yaml"
FACTORY = uncalibrated("factory")
WALK = "gyro.angle_random_walk"
# Of tac on g1 at 660 s, by the other program: gains kept, and retuned [m].
FACTORS = (0.9, 1.1, 2.0, 5.0)
KEPT = (5.32200, 5.98592, 9.39129, 21.9623)
RETUNED = (5.31311, 5.97795, 8.85397, 17.7969)
TRIALS = 4000


def limited(horizontal="10 m"):
    """Return a limit at the end of an outage."""
    at = {"horizontal": horizontal, "at": "660 s", "probability": "50 %"}
    return load_requirement({"name": "way", "limits": {"mission": {"position": [at]}}})


def on_mission(unit="tac", factor=1.0, **more):
    """Return the budget of a unit on the mission, as its maker calibrated it."""
    changes = [f"{WALK}={0.1 * factor!r} deg/sqrt(h)"] * (factor != 1.0)
    question = Question.load(
        load_device(DATA / f"{unit}.yaml", changes),
        inputs=Inputs(
            procedure=FACTORY,
            mission=more.pop("mission", G1),
            at=more.pop("carried_to", (660.0,)),
            requirement=more.pop("requirement", None),
        ),
    )
    settings = more.pop("settings", Settings(validate=False))
    return analyze_as(settings, question, command="mission", **more)


@cache
def model():
    """Return the model of sliders of the mission."""
    budget = on_mission(requirement=limited())
    return what_if(budget.question, budget=budget)


def horizontal(outlook):
    """Return the root of the summed variances north and east of an outlook [m]."""
    axes = [
        (one.name.owner, one.name.quantity, one.name.axis) for one in model().outputs
    ]
    return outlook.u[axes.index((MISSION, "position", "horizontal"))]


@pytest.mark.parametrize(("factor", "u"), [*zip(FACTORS, KEPT, strict=True)])
def test_sliders_keep_the_gains(factor, u):
    """What a change does to the filter that there is, is exact."""
    assert_allclose(horizontal(model().evaluate({WALK: factor})), u, rtol=1e-4)


@pytest.mark.parametrize(("factor", "u"), [*zip(FACTORS, RETUNED, strict=True)])
def test_a_changed_line_retunes(factor, u):
    """`--set` changes the truth and what the filter believes; never for the worse."""
    row = on_mission(factor=factor).output("mission.position.horizontal.660")
    assert_allclose(row.standard_uncertainty, u, rtol=1e-4)
    assert row.standard_uncertainty < horizontal(model().evaluate({WALK: factor}))


@pytest.mark.slow
def test_each_unit_of_a_comparison_has_its_own_filter():
    """The largest error of each is what it has alone; the better one is first."""
    found = compare(
        [DATA / "mems.yaml", DATA / "tac.yaml"],
        limited(),
        mission=G1,
        calibration="factory",
        method="gum",
    )
    rows = {one.name: one for one in found.devices if one.sensor == MISSION}
    assert [*rows] == ["tac", "mems"]
    for unit, row in rows.items():
        alone = on_mission(unit, requirement=limited()).assessment
        (own,) = (one for one in alone.sensors if one.sensor == MISSION)
        assert row.verdict == own.verdict
        assert_allclose(row.utilisation, own.utilisation, rtol=1e-9)
    assert rows["tac"].verdict == "undecidable"  # its g-sensitivity is not given
    assert rows["mems"].verdict == "fails"


@pytest.mark.parametrize("mission", ["g1", "g5"])
@pytest.mark.slow
def test_trials_agree_with_the_law(mission):
    """Of the optimal filter and of one of its own, within 4 standard errors.

    Control: not with the law of 1.2 times the walk.
    """
    unit = {"g1": "tac", "g5": "mems"}[mission]
    mission = DATA / f"{mission}.yaml"
    trials = on_mission(
        unit,
        mission=mission,
        settings=Settings(method="monte-carlo", trials=TRIALS, seed=6, validate=False),
    )
    law = on_mission(unit, mission=mission)
    ratios = np.array(
        [
            one.standard_uncertainty / other.standard_uncertainty
            for one, other in zip(trials.outputs, law.outputs, strict=True)
        ]
    )
    # A sigma of n normal trials has the standard error 1/sqrt(2 (n - 1)); of a
    # horizontal error, whose two parts are at most one and the same, no more.
    bound = 4.0 / np.sqrt(2.0 * (TRIALS - 1))
    assert np.abs(ratios - 1.0).max() < bound
    if unit == "tac":
        other = on_mission(factor=1.3)
        far = [
            one.standard_uncertainty / row.standard_uncertainty
            for one, row in zip(trials.outputs, other.outputs, strict=True)
            if (row.parameter, row.axis) == ("position", "north")
        ]
        assert abs(far[0] - 1.0) > bound


@pytest.mark.slow
def test_forms_of_a_result_have_the_same_numbers(tmp_path):
    """JSON and CSV; and what is computed again is the same."""
    words = ("mission", str(DATA / "mems.yaml"), "--mission", str(DATA / "g4.yaml"))
    files = [tmp_path / f"{k}.json" for k in (0, 1)]
    runs = [call(*words, "--no-validate", "--json", str(file)) for file in files]
    table = call(*words, "--no-validate", "--csv", "-")
    assert [run.code for run in (*runs, table)] == [0, 0, 0]
    one, other = (json.loads(file.read_text(encoding="utf-8")) for file in files)
    assert one["outputs"] == other["outputs"]
    assert one["mission"]["filter"]["turned"]["turned"] > 0.0
    rows = list(csv.DictReader(io.StringIO(table.out)))
    totals = {
        (row["parameter"], row["axis"], float(row["time"])): float(
            row["standard_uncertainty"]
        )
        for row in rows
    }
    for out in one["outputs"]:
        key = (out["parameter"], out["axis"], out["time"])
        assert_allclose(totals[key], out["standard_uncertainty"], rtol=1e-9)


def test_a_mission_that_is_aided_to_its_end_says_so_beside_its_verdict():
    """What is meant for an outage and has aids there is no outage."""
    gnss = {"velocity": "0.05 m/s", "rate": "1 Hz"}
    part = {"latitude": "47 deg", "speed": "15 m/s", "aiding": {"gnss": gnss}}
    segments = [{"straight": "60 s", "aiding": ["gnss"]}]
    route = {
        "name": "m",
        "environment": "none",
        "mission": part | {"segments": segments},
    }
    at = {"horizontal": "80 m", "at": "60 s"}
    need = load_requirement({"name": "n", "limits": {"mission": {"position": [at]}}})
    budget = on_mission(mission=route, requirement=need, carried_to=(60.0,))
    (sensor,) = budget.assessment.sensors
    assert [one.kind for one in sensor.cautions].count("aided") == 1


@pytest.mark.parametrize(("mission", "at"), [("g4", "660 s"), ("g1", "600 s")])
@pytest.mark.slow
def test_what_a_verdict_owes_to_aids_stands_beside_it_in_every_command(mission, at):
    """A filter that is too sure, and a limit while aids are there; once each."""
    kind, words = {
        "g4": ("filter", "what it says of its own accuracy is too good"),
        "g1": ("aided", "aids and unit are judged together"),
    }[mission]
    tree = {"horizontal": "80 m", "at": at, "probability": "50 %"}
    need = load_requirement({"name": "n", "limits": {"mission": {"position": [tree]}}})
    path = DATA / f"{mission}.yaml"
    budget = on_mission(
        "mems", mission=path, requirement=need, carried_to=(float(at[:-2]),)
    )
    (sensor,) = budget.assessment.sensors
    found = compare(
        [load_device(DATA / "mems.yaml")],
        need,
        mission=load_mission(path),
        method="gum",
    )
    (row,) = found.on_mission if hasattr(found, "on_mission") else found.devices
    for standing in (sensor, row):
        (text,) = (str(one.text) for one in standing.cautions if one.kind == kind)
        assert words in text
    assert not any(words in text for text in budget.warnings)
