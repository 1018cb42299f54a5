"""What a study is asked: a limit on what the test does not estimate is no limit met."""

from __future__ import annotations

import pytest
from command_line import call

from budget import analyze, load_device, load_procedure, load_requirement
from budget.studies.conformity import assess
from budget.studies.request import Analysis
from budget.studies.what_if import what_if

TABLE = "one-axis-rate-table"
AS_TESTED = "as_tested"
LOOSE = f"name: loose\nreference: {AS_TESTED}\nlimits:\n  gyro: {{scale_factor: 1 %"


@pytest.fixture
def limits(tmp_path):
    """Return a function that writes wide limits, with more of the gyro's."""

    def write(more=""):
        path = tmp_path / "loose.yaml"
        path.write_text(f"{LOOSE}{more}}}\n")
        return path

    return write


def judged(asked):
    """Return the verdicts of all commands, and the warnings."""
    device, plan = load_device("zhao-2019"), load_procedure(TABLE)
    requirement = load_requirement(asked)
    analysis = Analysis.of(device, procedure=plan, requirement=requirement)
    budget = analyze(device, procedure=plan, reference=AS_TESTED)
    (assessed,) = assess(budget, requirement).sensors
    (slid,) = what_if(analysis).evaluate({}).sensors
    args = ("--requirement", asked, "--procedure", TABLE, "--json", "-")
    compared = call("compare", "zhao-2019", *args, "--method", "gum").document
    allotted = call("allocate", "zhao-2019", *args).document
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
        assert [text for text in said if "gyro.mounting_angle xy" in text] == said != []
    alone = judged(limits())
    assert alone["verdicts"] == {"meets"}
    assert alone["not estimated"] == ()
    assert alone["warnings"] == [[], []]


def test_limits_on_held_parameters_alone_are_none(tmp_path):
    """There is nothing to judge: what the requirement would have to limit is said."""
    path = tmp_path / "bias.yaml"
    path.write_text("name: bias\nlimits: {gyro: {bias: 5 deg/h}}\n")
    for command in ("compare", "allocate", "report"):
        more = ("-o", tmp_path / "page.html") if command == "report" else ()
        run = call(
            *(command, "zhao-2019", "--requirement", path, "--procedure", TABLE, *more)
        )

        assert run.code == 2
        assert "limit" in run.err
        assert "Traceback" not in run.err
