"""A temperature and a vibration that are known on the way, in every study."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from reading import assert_says

from budget.inputs import load_device, load_mission, load_requirement, uncalibrated
from budget.names import MISSION
from budget.question import Question
from budget.settings import Inputs, Settings
from budget.studies.allocation.allocate import allocate
from budget.studies.analysis import analyze_as
from budget.studies.comparison.compare import compare
from budget.studies.mission import curve
from budget.studies.what_if import what_if

COEFFICIENT = "gyro.bias_temperature_coefficient"
GYRO = {
    "angle_random_walk": "0.1 deg/sqrt(h)",
    "bias_repeatability": "5 deg/h",
    "bias_stability": "1 deg/h",
    "scale_factor_repeatability": "300 ppm",
    "mounting_repeatability": "60 arcsec",
    "scale_factor_temperature_coefficient": "10 ppm/degC",
    "vibration_rectification": "0.2 deg/h/g^2",
    "g_sensitivity": "1 deg/h/g",
}
ACCELEROMETER = {
    "velocity_random_walk": "0.05 m/s/sqrt(h)",
    "bias_repeatability": "1 mg",
    "bias_stability": "50 ug",
    "scale_factor_repeatability": "300 ppm",
    "mounting_repeatability": "60 arcsec",
    "bias_temperature_coefficient": "20 ug/degC",
    "scale_factor_temperature_coefficient": "10 ppm/degC",
    "vibration_rectification": "30 ug/g^2",
}
WARM_UP = {"warm_up": {"by": "20 degC", "time": "300 s"}}
AIDS = {"gnss": {"position": "2.5 m", "velocity": "0.05 m/s", "rate": "1 Hz"}}
TIMES = (60.0, 600.0)
TRIALS = 4000


def unit(coefficient="0.5 deg/h/degC"):
    """Return a unit that says all that a warm-up and a vibration act by, or not."""
    more = {"bias_temperature_coefficient": coefficient} if coefficient else {}
    return {
        "name": f"unit of {coefficient}",
        "technology": "MEMS",
        "range": {"gyro": "400 deg/s", "accelerometer": "10 g"},
        "gyro": {"errors": {**GYRO, **more}},
        "accelerometer": {"errors": ACCELEROMETER},
    }


def way(*, aided=False):
    """Return ten minutes from switching it on, shaken in the first half."""
    first = {"straight": "300 s", "speed": "15 m/s", "vibration": "2 g"}
    start = {"position": "10 m", "velocity": "1 m/s", "level": "1 deg"}
    aids = {"aiding": AIDS, "alignment": start} if aided else {}
    named = {"aiding": ["gnss"]} if aided else {}
    part = {"latitude": "47 deg", **aids}
    legs = [{**first, **named}, {"straight": "300 s"}]
    use = {"environment": {"temperature": WARM_UP, "vibration": "1 g"}, "age": "0 s"}
    return load_mission({"name": "way", **use, "mission": {**part, "segments": legs}})


def limited(horizontal="35 km"):
    """Return a limit at its end."""
    at = {"horizontal": horizontal, "at": "600 s", "probability": "95 %"}
    return load_requirement({"name": "way", "limits": {"mission": {"position": [at]}}})


def budget_of(coefficient="0.5 deg/h/degC", *, aided=False, **more):
    """Return the budget of that unit on the way, as its maker calibrated it."""
    settings = more.pop("settings", Settings(validate=False, reference="next_turn_on"))
    question = Question.load(
        load_device(unit(coefficient)),
        inputs=Inputs(
            procedure=more.pop("procedure", uncalibrated("factory")),
            mission=way(aided=aided),
            at=TIMES,
            **more,
        ),
    )
    return analyze_as(settings, question, command="mission")


@cache
def standing(coefficient, limit="35 km"):
    """Return how a unit stands."""
    (own,) = budget_of(coefficient, requirement=limited(limit)).assessment.sensors
    return own


def test_a_course_is_a_temperature_that_is_stated():
    """With all that it acts by the verdict has no condition, and says the course."""
    found = standing("0.5 deg/h/degC")
    assert (found.verdict, found.conditions) == ("meets", ())
    warming = "warming up by 20 degC to the temperature of the calibration"
    assert_says(found.use, f"{warming} (time constant 5 min)")
    assert_says(found.use, "1 g to 2 g rms of vibration")
    assert not any("temperature" in str(one.line) for one in found.cautions)
    assert standing("0.6 deg/h/degC").verdict == "fails"


def test_a_coefficient_that_is_not_given_is_asked_for_where_it_fails():
    """And what is said of it is what a unit that gives as much has."""
    found = standing(None)
    assert found.verdict == "undecidable"
    one = next(one for one in found.conditions if one.line == COEFFICIENT)
    bound = one.below / one.si_per_unit
    verdicts = [standing(f"{x * bound:.9g} deg/h/degC").verdict for x in (0.97, 1.03)]
    assert verdicts == ["meets", "fails"]


@pytest.mark.parametrize("aided", [False, True])
def test_the_curve_goes_through_the_budget(aided):
    """Each source of it, the coefficients among them, at a time that is asked for."""
    found = budget_of(aided=aided)
    drawn = curve(found.question, TIMES)
    names = [str(name) for name in drawn.sources]
    variance = drawn.covariance[names.index(COEFFICIENT)]
    for place, time in enumerate(TIMES):
        row = found.output(f"mission.position.north.{time:g}")
        part = {str(x.source): x for x in row.contributions}[COEFFICIENT]
        u = np.sqrt(drawn.covariance[:, place, 0, 0].sum())
        assert_allclose(u, row.standard_uncertainty, rtol=1e-6)
        share = variance[place, 0, 0] / u**2
        assert_allclose(part.share, share, rtol=1e-6, atol=1e-9)
        assert share > 0.0


def test_a_slider_is_what_another_unit_has():
    """Of a coefficient of a course, exactly: without aids no filter is retuned."""
    one = budget_of(requirement=limited())
    model = what_if(one.question, budget=one)
    names = [str(one.name) for one in model.outputs]
    place = names.index("mission.position.horizontal.600")
    u = model.evaluate({COEFFICIENT: 2.0}).u[place]
    row = budget_of("1 deg/h/degC").output("mission.position.horizontal.600")
    assert_allclose(u, row.standard_uncertainty, rtol=1e-6)


def test_an_allocation_of_a_coefficient_meets():
    """It is a line as any: allotted, and the limit is reached with it."""
    found = allocate(
        load_device(unit()),
        requirement=limited("30 km"),
        mission=way(),
        calibration="factory",
        validate=False,
    )
    assert found.feasible
    rows = {str(one.source): one for one in found.sources}
    own = rows[COEFFICIENT]
    assert (own.status, own.allowed < own.now) == ("free", True)
    value = own.allowed / own.si_per_unit
    better = budget_of(f"{value:.9g} deg/h/degC", requirement=limited("30 km"))
    assert better.assessment.sensors[0].utilisation < 1.2  # others are as they were
    (row,) = found.outputs
    assert_allclose(row.allowed, 1.0, rtol=1e-6)


@pytest.mark.parametrize("aided", [False, True])
@pytest.mark.slow
def test_trials_agree_with_the_law(aided):
    """Within 4 standard errors; control: not with the law of 1.5 times as much."""
    settings = Settings(
        method="monte-carlo",
        trials=TRIALS,
        seed=3,
        validate=False,
        reference="next_turn_on",
        only=(COEFFICIENT, "gyro.vibration_rectification"),
    )
    trials = budget_of(aided=aided, settings=settings)
    law, other = (
        budget_of(
            f"{size} deg/h/degC", aided=aided, settings=replace(settings, method="gum")
        )
        for size in (0.5, 0.75)
    )
    # A sigma of n normal trials has the standard error 1/sqrt(2 (n - 1)).
    bound = 4.0 / np.sqrt(2.0 * (TRIALS - 1))
    ratios, far = (
        np.array(
            [
                x.standard_uncertainty / y.standard_uncertainty
                for x, y in zip(trials.outputs, of.outputs, strict=True)
            ]
        )
        for of in (law, other)
    )
    assert np.abs(ratios - 1.0).max() < bound
    assert np.abs(far - 1.0).max() > 2.0 * bound


def test_a_comparison_and_its_command_say_it(tmp_path):
    """The better coefficient is first; a size by the call takes the course's place."""
    devices = [load_device(unit(f"{size} deg/h/degC")) for size in (0.6, 0.4)]
    found = compare(
        devices, limited(), mission=way(), calibration="factory", method="gum"
    )
    rows = [one for one in found.devices if one.sensor == MISSION]
    assert [one.verdict for one in rows] == ["meets", "fails"]
    names = ("unit", "way")
    files = {key: tmp_path / f"{key}.yaml" for key in names}
    files["unit"].write_text(json.dumps(unit()), encoding="utf-8")
    segments = [{"straight": "600 s", "speed": "15 m/s"}]
    said = {
        "environment": {"temperature": WARM_UP},
        "mission": {"latitude": "47 deg", "segments": segments},
    }
    files["way"].write_text(json.dumps(said), encoding="utf-8")
    words = ("mission", str(files["unit"]), "--mission", str(files["way"]))
    run = call(*words, "--no-validate", "--only", COEFFICIENT, code=0)
    assert_says(run.out, "100 % of the variance is gyro bias temperature coefficient")
    size = call(*words, "--no-validate", "--environment", "temperature 20 degC")
    assert_says(size.out, "78 % of the variance is environment temperature mission")
    none = call(*words, "--only", COEFFICIENT, "--environment", "none", code=2)
    assert_says(none.err, "is no source of these devices")
