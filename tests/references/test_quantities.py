"""What is read from a document: every path of the table, each with its tolerance."""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose
from reference_examples import DEVICE, snapshot

from budget.references import jobs
from budget.references.quantities import (
    LEAST_COST,
    LEAST_COST_LINE,
    MEANINGS,
    PART,
    _leaves,
    _Where,
)
from budget.report.schema import results_schema

LIMITS = [("requirement", "navigation-grade")]
# A second triad of which no error line is given: nothing is known of it.
BARE = "name: Bare\naccelerometer: {nominal: {bias: 1 mg}}\n"


@pytest.fixture
def documents(monkeypatch):
    """Provide a list of all documents from which something is read."""
    seen = []
    read = jobs.snapshot_of

    def note(document, errors):
        seen.append(document)
        return read(document, errors)

    monkeypatch.setattr(jobs, "snapshot_of", note)
    return seen


@pytest.mark.parametrize(
    ("job", "texts", "asked"),
    [
        ("analyze", [DEVICE], {"samples": 32}),
        ("compare", [DEVICE, BARE], {}),
        ("allocate", [DEVICE], {"strategy": "cost"}),
    ],
)
def test_every_path_of_the_table_is_in_a_document(documents, job, texts, asked):
    """A key that a document no longer has would be passed over in silence."""
    for text in texts:
        snapshot(text, job=job, more=LIMITS, **asked)
    found = {
        path
        for document in documents
        for path, _, value in _leaves(document, "", _Where())
        if value is not None
    }
    assert set(MEANINGS[job]) <= found


def floors(found, document):
    """Return the rounding of each kind of number, and what it is to be."""
    for one in document["outputs"]:
        name = f"{one['sensor']}.{one['parameter']}.{one['axis']}"
        for number in found.numbers:
            if number.subject == name and number.unit == one["unit"]:
                yield number.floor, one["resolution"]
    for one in document["assessment"]["outputs"]:
        name = f"{one['sensor']}.{one['parameter']}.{one['axis']}"
        for number in found.numbers:
            if (number.subject, number.quantity) == (name, "utilisation"):
                yield number.floor, one["resolution"] / one["limit"]


def test_an_output_is_sure_to_its_resolution(documents):
    """Its numbers in its unit, the part of its limit to that part of it."""
    found = snapshot(more=LIMITS)
    (document,) = documents
    pairs = list(floors(found, document))
    assert len(pairs) > 24 * 8
    assert_allclose(*zip(*pairs, strict=True), rtol=1e-12)
    assert {n.floor for n in found.numbers if n.quantity == "correlation"} == {PART}


def test_a_sensor_is_as_sure_as_its_least_sure_output():
    """Its largest part of a limit has the rounding and the spread of the worst one."""
    found = snapshot(more=LIMITS, method="monte-carlo", trials=2000)
    used = [one for one in found.numbers if one.quantity == "utilisation"]
    for sensor in ("gyro", "accelerometer"):
        own = [one for one in used if one.subject.startswith(f"{sensor}.")]
        (all_,) = (one for one in used if one.subject == sensor)
        assert all_.value == max(one.value for one in own)
        assert all_.floor == max(one.floor for one in own)
        assert all_.standard_error == max(one.standard_error for one in own)


def test_the_law_has_no_standard_errors_and_trials_have():
    """Contributions are the law's under both; counts have trials.

    By the law the ends alone of those intervals that trials gave are sampled.
    """
    law = snapshot(more=LIMITS)
    sampled = [one for one in law.numbers if one.is_sampled]
    ends_alone = {"interval_low", "interval_high", "utilisation"}
    assert {one.quantity for one in sampled} == ends_alone
    ends = [one for one in law.numbers if one.quantity.startswith("interval")]
    assert len(sampled) < len(ends)
    drawn = snapshot(more=LIMITS, method="monte-carlo", trials=2000)
    assert {one.quantity for one in drawn.numbers if not one.is_sampled} == {
        "contribution"
    }
    compared = snapshot(job="compare", more=LIMITS, method="monte-carlo", trials=2000)
    counted = {one.quantity for one in compared.numbers if one.trials}
    assert counted == {"conformance"}
    # The standard uncertainty of a comparison is the law's.
    exact = {one.quantity for one in compared.numbers if not one.is_sampled}
    assert exact == {"standard_uncertainty"}


@pytest.mark.slow
def test_the_solver_of_the_least_cost_is_sure_of_the_cost_to_a_part():
    """Of a line to the root of that; by another strategy there is no solver."""
    by_cost = snapshot(job="allocate", more=LIMITS, strategy="cost")
    equal = snapshot(job="allocate", more=LIMITS, strategy="equal")
    for found, line in ((by_cost, LEAST_COST_LINE), (equal, 0.0)):
        for one in found.numbers:
            if one.quantity == "allowed":
                assert_allclose(one.floor, line * one.value, rtol=1e-12)
            if one.quantity in {"cost", "cost_now"}:
                assert_allclose(one.floor, LEAST_COST * one.value, rtol=1e-12)
    assert any(one.quantity == "cost" for one in by_cost.numbers)


def test_what_is_derived_is_sampled_as_well(tmp_path):
    """A limit on a rotation has standard errors in a comparison and in an analysis."""
    wanted = tmp_path / "want.yaml"
    limits = "{gyro: {bias: 1 deg/h, rotation: 10 arcsec}, misalignment: 1 arcmin}"
    wanted.write_text(f"name: want\nlimits: {limits}\n", encoding="utf-8")
    asked = {"method": "monte-carlo", "trials": 2000}
    for job, quantity in (("compare", "largest_error"), ("analyze", "utilisation")):
        found = snapshot(job=job, more=[("requirement", str(wanted))], **asked)
        (one,) = (
            number
            for number in found.numbers
            if (number.quantity, number.subject.rpartition(" ")[2])
            == (quantity, "gyro.rotation.x")
        )
        assert one.standard_error > 0.0


SCHEMA = results_schema()


def objects(node):
    """Yield the objects that a part of the schema may be, of a list its items."""
    if "$ref" in node:
        yield from objects(SCHEMA["$defs"][node["$ref"].rpartition("/")[2]])
    elif "properties" in node:
        yield node["properties"]
    for one in (*node.get("anyOf", ()), *filter(None, [node.get("items")])):
        yield from objects(one) if isinstance(one, dict) else ()


def has(node, steps):
    """Say whether there is a path below a part of the schema; numbers are places."""
    if not steps or steps[0].isdecimal():
        return True
    first, *rest = steps
    return any(has(one[first], rest) for one in objects(node) if first in one)


@pytest.mark.parametrize("command", MEANINGS)
def test_what_is_compared_is_what_a_row_is_of(command):
    """A key that a form renames or drops is missed here, not in a stored reference."""
    (root,) = (
        one
        for one in SCHEMA["oneOf"]
        for properties in objects(one)
        if command in properties.get("command", {}).get("enum", ())
    )

    assert [one for one in MEANINGS[command] if not has(root, one.split("."))] == []
    assert not has(root, ["outputs", "none"])
