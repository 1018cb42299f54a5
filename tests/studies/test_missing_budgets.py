"""A budget and its verdict with lines in the place of those that are not given."""

from __future__ import annotations

import json

import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from reading import on_terminal

from budget import CallError, analyze, load_device, load_procedure, load_requirement
from budget.missing import fill
from budget.names import Name
from budget.question import question_of
from budget.report.analysis.build import report_document
from budget.report.analysis.groups import budget_answer
from budget.report.document import to_json
from budget.studies.comparison.compare import compare
from budget.studies.evidence import gather_evidence

EDGE = load_requirement("catalogue-edge")
DEVICE = load_device("stim300#5g")  # lacks two gyro lines and one accelerometer line
LACKS = Name("mounting_repeatability", owner="gyro")


def budget_of(*devices, missing, requirement=EDGE, **more):
    """Return the budget by the law, not validated."""
    return analyze(
        *devices,
        requirement=requirement,
        coverage=EDGE.coverage,
        reference=EDGE.reference,
        missing=missing,
        catalogue=catalogue(),
        validate=False,
        **more,
    )


@pytest.fixture(scope="module")
def predicted():
    """Return the budget with predicted lines."""
    return budget_of(DEVICE, missing="predict")


def test_refuse_is_the_budget_without_a_word_of_it():
    """By default nothing stands for a line, and the documents are what they were."""
    document = json.loads(to_json(budget_of(DEVICE, missing="refuse")))
    usual = json.loads(
        to_json(
            analyze(
                DEVICE,
                requirement=EDGE,
                coverage=EDGE.coverage,
                reference=EDGE.reference,
                validate=False,
            )
        )
    )
    assert document == usual
    assert "missing" not in document
    assert "missing" not in document["settings"]


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_the_budget_is_that_of_a_device_with_those_lines(mode):
    """Numbers are those of the completed device; nothing of it is a lower bound."""
    found = budget_of(DEVICE, missing=mode, requirement=None)
    completed, filling = fill(DEVICE, mode, catalogue())
    plain = budget_of(completed, missing="refuse", requirement=None)

    assert_allclose(found.covariance, plain.covariance, rtol=1e-12, atol=0)
    assert not any(row.lower_bound for row in found.outputs)
    assert {line.expected for line in found.filled} == {
        *DEVICE.gyro.expected_missing,
        *DEVICE.accelerometer.expected_missing,
    }
    document = json.loads(to_json(found))
    assert document["missing"]["mode"] == document["settings"]["missing"] == mode
    assert [line["source"] for line in document["missing"]["filled"]] == [
        line.source for line in filling.lines
    ]
    text = " ".join(on_terminal(budget_answer(found)).split())
    assert f"--missing {mode}" in text
    for line in found.filled:
        assert f"{line.printed} ({line.origin})" in text
        number = line.designs if mode == "typical" else line.devices
        assert f" {number} " in f"{line.origin} "


def test_one_verdict_whatever_the_command(predicted):
    """The budget says of each sensor what compare says of it."""
    compared = compare([DEVICE], EDGE, catalogue=catalogue(), missing="predict")
    for own in predicted.assessment.sensors:
        (other,) = [one for one in compared.devices if one.sensor == own.sensor]
        assert own.verdict == other.verdict == "predicted"
        assert_allclose(own.doubt.probability, other.doubt.probability, atol=5e-4)
        assert [ask.source for ask in own.doubt.asks] == [
            ask.source for ask in other.doubt.asks
        ]
        assert own.known_conformance is None
    (pair,) = compared.imus
    assert_allclose(predicted.assessment.chance, pair.probability, atol=1e-3)


@pytest.mark.slow
def test_the_page_says_the_probability_and_what_to_ask_for(predicted):
    """Headline, cards and limits; nothing at medians is called certain."""
    evidence = gather_evidence(question_of(predicted), predicted, predicted.assessment)
    document = report_document(
        predicted,
        devices=question_of(predicted).devices,
        procedure=load_procedure(),
        evidence=evidence,
        assessment=predicted.assessment,
        command_line="budget report",
        date="2026-01-01",
    )
    words = repr((document.cards, document.sections))

    assert document.headline.startswith("PREDICTED ")
    assert "meets with a probability of 0." in document.headline
    assert "with specifications not given as predicted" in document.headline
    assert "ask the maker for it first" in repr(document.cards)
    assert "conforms at the medians" in words
    assert "Conformance probability" not in words
    assert "ppm, predicted" in words
    # The sliders leave the verdict open too: a size of a line is no knowledge of it.
    sensors = evidence.what_if.sensors
    assert all(sensor.missing for sensor in sensors if sensor.name != "imu")


def test_two_devices_make_one_unit():
    """Lines of a gyro and of an accelerometer file are filled each by its own."""
    gyro, other = load_device("ltm210#S1B"), load_device("adxl357")
    found = budget_of(gyro, other, missing="predict")
    question = question_of(found)

    assert {line.expected.owner for line in found.filled} == {"gyro", "accelerometer"}
    assert {one.verdict for one in found.assessment.sensors} == {"predicted"}
    assert question.filling.prediction.names == (
        *gyro.gyro.expected_missing,
        *other.accelerometer.expected_missing,
    )
    alone = budget_of(gyro, missing="predict").assessment.sensors[0]
    together = found.assessment.sensors[0]
    assert_allclose(alone.doubt.probability, together.doubt.probability, atol=1e-3)


def test_nothing_comparable_leaves_the_verdict_undecidable():
    """Of an empty catalogue nothing is put in, and that is said."""
    found = analyze(
        DEVICE,
        catalogue=(),
        requirement=EDGE,
        coverage=EDGE.coverage,
        reference=EDGE.reference,
        missing="predict",
        validate=False,
    )
    text = on_terminal(budget_answer(found))

    assert {one.verdict for one in found.assessment.sensors} == {"undecidable"}
    assert found.filled == ()
    assert LACKS in found.left
    assert "gyro mounting repeatability: nothing is known" in text


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_the_library_takes_the_devices_that_ship(mode):
    """As the command does: a catalogue of one's own is asked for, not needed."""
    device = load_device("stim300#5g")
    one = analyze(device, missing=mode, validate=False)
    other = analyze(device, missing=mode, validate=False, catalogue=catalogue())
    assert one.filled
    assert one.filled == other.filled


def test_a_requirement_rules_coverage_and_reference():
    """Another one that is asked for beside it is refused."""
    found = analyze("zhao-2019", requirement="tactical-grade", validate=False).settings
    assert (found.coverage, found.reference) == (0.95, "next_turn_on")
    with pytest.raises(CallError, match="reference nominal differs"):
        analyze("zhao-2019", requirement="tactical-grade", reference="nominal")
