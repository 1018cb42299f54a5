"""What a study is asked: a limit on what the test does not estimate is no limit met."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import put

from budget import analyze, load_device, load_procedure, load_requirement
from budget.names import Name
from budget.question import Question
from budget.report.analysis.verdict import summary
from budget.studies.conformity import assess
from budget.studies.what_if import what_if
from budget.units import ARCSEC

pytestmark = pytest.mark.usefixtures("drawn_once")

TABLE = "one-axis-rate-table"
AS_TESTED = "as_tested"
LOOSE = f"name: loose\nreference: {AS_TESTED}\nlimits:\n  gyro: {{scale_factor: 1 %"


@pytest.fixture
def limits(tmp_path):
    """Return a function that writes wide limits, with more of the gyro's."""

    def write(more=""):
        return put(tmp_path / "loose.yaml", f"{LOOSE}{more}}}\n")

    return write


def judged(asked):
    """Return the verdicts of all commands, and the warnings."""
    device, plan = load_device("zhao-2019"), load_procedure(TABLE)
    requirement = load_requirement(asked)
    question = Question.of(device, procedure=plan, requirement=requirement)
    budget = analyze(device, procedure=plan, reference=AS_TESTED, validate=False)
    (assessed,) = assess(budget, requirement).sensors
    (slid,) = what_if(question).evaluate({}).sensors
    args = ("--requirement", asked, "--procedure", TABLE, "--json", "-")
    compared = call("compare", "zhao-2019", *args, "--method", "gum").document
    allotted = call("allocate", "zhao-2019", *args, "--no-validate").document
    return {
        "verdicts": {
            assessed.verdict,
            slid.verdict,
            *(one["verdict"] for one in compared["devices"]),
        },
        "not estimated": assessed.not_estimated,
        "warnings": [
            [text for text in said if "does not estimate" in text]
            for said in (compared["warnings"], allotted["warnings"])
        ],
    }


def test_a_limit_on_a_held_parameter_is_never_met(limits):
    """The scale factors alone meet; of the angle nothing is known, and all say so."""
    found = judged(limits(", mounting_angle: {xy: 60 arcsec}"))

    assert found["verdicts"] == {"undecidable"}
    assert found["not estimated"] == ("gyro.mounting_angle.xy",)
    for said in found["warnings"]:
        assert [text for text in said if "gyro mounting angle xy" in text] == said != []
    alone = judged(limits())
    assert alone["verdicts"] == {"meets"}
    assert alone["not estimated"] == ()
    assert alone["warnings"] == [[], []]


def test_limits_on_held_parameters_alone_are_none(tmp_path):
    """There is nothing to judge: what the requirement would have to limit is said."""
    path = put(tmp_path / "bias.yaml", "name: bias\nlimits: {gyro: {bias: 5 deg/h}}\n")
    for command in ("compare", "allocate", "report"):
        more = ("-o", tmp_path / "page.html") if command == "report" else ()
        run = call(
            *(command, "zhao-2019", "--requirement", path, "--procedure", TABLE, *more),
            code=2,
        )

        assert "limit" in run.err
        assert "Traceback" not in run.err


ALIGNED = f"name: aligned\nreference: {AS_TESTED}\nlimits:\n  misalignment: "


@pytest.fixture
def aligned(tmp_path):
    """Return a function that writes limits on the misalignment, and on more."""

    def write(limit, more=""):
        return put(tmp_path / "aligned.yaml", f"{ALIGNED}{limit}\n{more}")

    return write


def test_a_misalignment_is_judged_with_both_triads(aligned):
    """Utilisation by hand: 1.96 times the root of both rotations' variances.

    As tested, so noise alone: nothing of it is shared, the variances add up. The
    verdict turns at the limit, and sliders say what the page says.
    """
    device = load_device("zhao-2019")
    asked = ("rotation.x",)
    rotations = analyze(device, reference=AS_TESTED, outputs=asked, validate=False)
    u = np.hypot(*(row.standard_uncertainty for row in rotations.outputs)) / ARCSEC
    end = 1.959963985 * u
    verdicts = []
    for limit in (0.99 * end, 1.01 * end):
        requirement = load_requirement(aligned(f"{{x: {limit:.9f} arcsec}}"))
        question = Question.of(device, requirement=requirement)
        budget = analyze(
            device, requirement=requirement, reference=AS_TESTED, validate=False
        )
        (one,) = budget.assessment.sensors
        assert (one.sensor, one.worst_output) == ("imu", "imu.misalignment.x")
        assert_allclose(one.utilisation, end / limit, rtol=1e-6)
        (slid,) = what_if(question, budget=budget).evaluate({}).sensors
        assert (slid.sensor, slid.verdict) == ("imu", one.verdict)
        verdicts.append(one.verdict)
    assert verdicts == ["fails", "meets"]


def test_a_limit_on_both_triads_needs_both(aligned):
    """Of a gyro alone, or of one whose angles are held: said, and never met."""
    limits = aligned("1 deg", "  gyro: {scale_factor: 1 %}\n")
    requirement = load_requirement(limits)
    alone = analyze(load_device("adxrs453"), reference=AS_TESTED, validate=False)
    found = assess(alone, requirement)
    assert [one.sensor for one in found.sensors] == ["gyro"]
    assert found.not_there == ("imu",)
    assert "misalignment" in str(summary(alone, found))

    plan = load_procedure("six-positions-and-turns")
    held = replace(plan, held=(Name("mounting_angle", owner="gyro", axis="yx"),))
    budget = analyze(
        load_device("zhao-2019"),
        procedure=held,
        requirement=requirement,
        reference=AS_TESTED,
        validate=False,
    )
    verdicts = {one.sensor: one.verdict for one in budget.assessment.sensors}
    assert verdicts == {"gyro": "meets", "imu": "undecidable"}
    assert [text for text in budget.warnings if "misalignment x" in text] != []


def test_an_allocation_says_that_it_judges_no_misalignment(aligned):
    """A warning names the limit; without it there is none."""
    limits = aligned("1 deg", "  gyro: {rotation: 1 arcsec}\n")
    args = ("zhao-2019", "--requirement", limits, "--json", "-", "--no-validate")
    said = call("allocate", *args).document["warnings"]
    assert len([text for text in said if "misalignment" in text]) == 1
    limits.write_text(limits.read_text().replace("  misalignment: 1 deg\n", ""))
    said = call("allocate", *args).document["warnings"]
    assert not [text for text in said if "misalignment" in text]


def test_an_allocation_holds_limits_on_what_is_derived(tmp_path):
    """A rotation within 10 arcsec: two turn-ons make sqrt 2 u, two angles u again.

    So mounting repeatability may be 10 arcsec over k, less what noise takes of it.
    """
    path = put(
        tmp_path / "turned.yaml",
        "name: turned\nlimits: {gyro: {rotation: 10 arcsec}}\n",
    )
    how = ("--no-validate", "--json", "-")
    found = call("allocate", "zhao-2019", "--requirement", path, *how).document
    names = [one["output"] for one in found["outputs"]]
    assert names == [f"gyro.rotation.{axis}" for axis in "xyz"]
    (mounting,) = (
        one
        for one in found["sources"]
        if one["source"] == "gyro.mounting_repeatability"
    )
    assert_allclose(mounting["allowed"], 10.0 / 1.959963985, rtol=0.01)
    assert mounting["allowed"] < 10.0 / 1.959963985
