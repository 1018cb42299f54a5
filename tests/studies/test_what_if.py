"""What-if: the law for changed sources against the analysis of a changed device."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import builders
import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import put
from report_examples import make_device

from budget import analyze, load_device, load_mission, load_requirement
from budget.distributions import ARCSINE, TRIANGULAR, UNIFORM
from budget.errors import CallError
from budget.inputs.records import Limit, Origin, Requirement
from budget.names import MISSION, Name
from budget.question import Question
from budget.settings import Settings
from budget.studies.analysis import analyze_as
from budget.studies.conformity import assess
from budget.studies.what_if import one_at_a_time, what_if
from budget.units import ARCSEC, DEG_PER_HOUR, PPM

# The second-order law is even in every source and exact in the factors; what is left
# is the rounding of two sums of some thousand products.
RTOL = 1e-9


def line(name, u, **more):
    """Return a line with the printed unit of its kind."""
    unit, scale = {
        "bias": ("deg/h", DEG_PER_HOUR),
        "scal": ("ppm", PPM),
        "moun": ("arcsec", ARCSEC),
    }.get(name[:4], ("deg/h", DEG_PER_HOUR))
    return replace(
        builders.line(name, u, **more), unit=unit, si_per_unit=scale, printed=f"{name}"
    )


def hard_device():
    """Return a device with asymmetry, unequal axes and shapes that are not normal."""
    gyro = builders.sensor(
        "gyro",
        [
            line(
                "bias_repeatability",
                np.array([0.05, 0.2, 0.1]) * DEG_PER_HOUR,
                distribution=UNIFORM,
            ),
            line("bias_stability", np.array([0.04, 0.09, 0.01]) * DEG_PER_HOUR),
            line("angle_random_walk", 2e-6),
            line("rate_random_walk", 1e-10),
            line("scale_factor_repeatability", 5e-3, distribution=TRIANGULAR),
            line("scale_factor_nonlinearity", 2e-3, distribution=ARCSINE),
            line("scale_factor_asymmetry", [1e-3, 2e-3, 3e-3], distribution=UNIFORM),
            line(
                "mounting_repeatability",
                np.array([2.0, 3.0, 900.0, 5.0, 6.0, 7.0]) * ARCSEC,
                distribution=ARCSINE,
            ),
        ],
        bias=np.array([2.5, -1.0, 0.0]) * DEG_PER_HOUR,
        angle=2.0 * ARCSEC,
    )
    accelerometer = builders.paper_accelerometer(scale_factor_nonlinearity=1e-4)
    return replace(make_device(), gyro=gyro, accelerometer=accelerometer)


def scaled(device, factors):
    """Return the device with figures multiplied, by full names."""

    def resized(sensor):
        lines = tuple(
            replace(one, u=one.u * factors.get(f"{sensor.kind}.{one.name}", 1.0))
            for one in sensor.lines
        )
        return replace(sensor, lines=lines)

    return replace(
        device,
        gyro=resized(device.gyro),
        accelerometer=resized(device.accelerometer),
    )


def analyzed(device, **options):
    """Return the budget by gum, unchecked by Monte Carlo."""
    return analyze(device, validate=False, **options)


def agrees(outlook, budget):
    """Compare mean, u and the law's intervals of all outputs."""
    resolution = np.array([row.output.resolution for row in budget.outputs])
    u = np.array([row.standard_uncertainty for row in budget.outputs])
    mean = np.array([row.mean for row in budget.outputs])
    interval = budget.question.law.interval(budget.settings.coverage)
    # Where a mean or a spread is below what doubles resolve, the rounding differs.
    assert_allclose(outlook.u, np.where(u > resolution, u, outlook.u), rtol=RTOL)
    assert (outlook.u[u <= resolution] <= resolution[u <= resolution]).all()
    assert (np.abs(outlook.mean - mean) <= RTOL * np.abs(mean) + resolution).all()
    gap = np.abs(outlook.interval - interval)
    assert (gap <= RTOL * np.abs(interval) + resolution[:, None]).all()


CHANGES = (
    {"gyro.bias_repeatability": 7.0},
    {"gyro.scale_factor_asymmetry": 7.0, "gyro.bias_repeatability": 0.5},
    {"gyro.mounting_repeatability": 2.0, "accelerometer.bias_stability": 7.0},
    {"gyro.scale_factor_repeatability": 7.0, "gyro.scale_factor_nonlinearity": 2.0},
    {"accelerometer.sample_noise": 0.0, "gyro.angle_random_walk": 0.5},
)


@pytest.mark.parametrize("formulas", ["corrected", "paper"])
@pytest.mark.parametrize("reference", ["nominal", "as_tested", "next_turn_on"])
def test_factors_give_the_budget_of_the_changed_device(reference, formulas):
    """All 24 outputs agree with an analysis of the device with those figures."""
    procedure = builders.procedure(formulas=formulas)
    options = {"procedure": procedure, "reference": reference, "coverage": 0.9}
    model = what_if(Question.of(hard_device(), **options))

    assert len(model.outputs) == 24
    for changes in CHANGES:
        budget = analyzed(scaled(hard_device(), changes), **options)
        agrees(model.evaluate(changes), budget)


def test_the_comparison_can_fail():
    """Control: a device with one figure 1 % off does not agree."""
    changes = {"gyro.bias_repeatability": 7.0}
    other = analyzed(scaled(hard_device(), {"gyro.bias_repeatability": 7.07}))

    with pytest.raises(AssertionError):
        agrees(what_if(Question.of(hard_device())).evaluate(changes), other)


def test_only_some_sources_can_be_changed_where_only_some_count():
    """With `only` the model has those sources alone, and their budget."""
    only = ("bias_stability", "gyro.scale_factor_asymmetry")
    model = what_if(Question.of(hard_device(), only=only))
    changes = {"gyro.bias_stability": 2.0}

    assert [source.name for source in model.sources] == [
        "gyro.bias_stability",
        "gyro.scale_factor_asymmetry",
        "accelerometer.bias_stability",
    ]
    agrees(model.evaluate(changes), analyzed(scaled(hard_device(), changes), only=only))


def test_shares_are_those_of_the_budget():
    """Each source's share of every output is the one that analyze gives."""
    changes = {"gyro.scale_factor_asymmetry": 7.0}
    model = what_if(Question.of(hard_device()))
    budget = analyzed(scaled(hard_device(), changes))
    share = model.evaluate(changes).share
    for k, row in enumerate(budget.outputs):
        if not row.is_resolved:
            continue
        expected = {part.source: part.share for part in row.contributions}
        for g, source in enumerate(model.sources):
            # Shares below 1e-15 are rounding of the variance they are parts of.
            assert_allclose(
                share[k, g], expected.get(source.name, 0.0), rtol=RTOL, atol=1e-15
            )


def requirement(**limits):
    """Return a requirement of the outputs named, '__' for the dots [SI]."""
    return Requirement(
        name="some",
        coverage=0.9,
        reference="as_tested",
        limits=tuple(
            Limit(
                output=Name(quantity, owner=owner, axis=axis), limit=limit, printed=""
            )
            for name, limit in limits.items()
            for owner, quantity, axis in [name.split("__")]
        ),
        caps=(),
        assumptions=(),
        origin=Origin(file="some.yaml", sha256=""),
    )


@pytest.mark.parametrize("factor", [1.0, 40.0])
@pytest.mark.parametrize("missing", [(), (Name("noise", owner="gyro"),)])
def test_verdicts_are_those_of_the_assessment(factor, missing):
    """Utilisation, worst output and verdict agree with assess, meeting or not."""
    wanted = requirement(gyro__bias__x=1.0 * DEG_PER_HOUR, gyro__bias__y=1e-6)
    device = hard_device()
    device = replace(
        device,
        gyro=replace(device.gyro, expected_missing=missing),
        technology="optical",
    )
    changes = {"gyro.bias_stability": factor}
    outlook = what_if(Question.of(device, requirement=wanted)).evaluate(changes)
    changed = scaled(device, changes)
    budget = analyzed(changed, requirement=wanted, coverage=0.9, reference="as_tested")
    assessed = assess(budget, wanted, [changed])

    (ours,), (theirs,) = outlook.sensors, assessed.sensors
    assert (ours.sensor, ours.verdict) == (theirs.sensor, theirs.verdict)
    assert ours.worst_outputs[0] == theirs.worst_output
    assert_allclose(ours.utilisation, theirs.utilisation, rtol=RTOL)
    assert ours.verdict == (
        "fails" if factor > 1.0 else "undecidable" if missing else "meets"
    )
    required = [used for used in outlook.utilisation if used is not None]
    assert_allclose(required, [row.utilisation for row in assessed.outputs], rtol=RTOL)


def from_json(model, factors):
    """Compute the budget from the JSON alone, as the page does, in printed units."""
    f = [factors.get(source["name"], 1.0) for source in model["sources"]]
    names = [source["name"] for source in model["sources"]]
    rows = []
    for k, output in enumerate(model["outputs"]):
        mean = output["value"] + sum(
            q**2 * row[k] for q, row in zip(f, model["mean"], strict=True)
        )
        variance = sum(
            q**2 * a[k] + q**4 * b[k]
            for q, a, b in zip(f, model["first"], model["second"], strict=True)
        )
        for pair in model["pairs"]:
            g, h = (f[names.index(name)] for name in pair["sources"])
            variance += g**2 * h**2 * pair["variance"][k]
        rows.append((mean, output["factor"] * variance**0.5))
    return np.array(rows)


def test_the_json_alone_gives_the_same_numbers():
    """A page that knows nothing but the JSON finds means and U of every output."""
    model = what_if(Question.of(hard_device(), reference="next_turn_on"))
    changes = {"gyro.scale_factor_asymmetry": 3.0, "gyro.bias_repeatability": 0.2}
    document = json.loads(json.dumps(model.to_dict(), allow_nan=False))
    found = from_json(document, changes)
    outlook = model.evaluate(changes)
    unit = np.array([output.si_per_unit for output in model.outputs])

    assert document["pairs"]
    assert_allclose(found[:, 0], outlook.mean / unit, rtol=1e-12, atol=1e-20)
    assert_allclose(found[:, 1], model.coverage_factor * outlook.u / unit, rtol=1e-12)


def test_the_json_names_sources_and_outputs_in_printed_units(tmp_path):
    """Sources have the unit of the file, outputs their own, limits too."""
    file = put(
        tmp_path / "one.yaml",
        "name: one\ngyro:\n  errors:\n    bias_repeatability: 0.05 deg/h\n"
        "    mounting_repeatability: {value: 2 arcsec, meaning: max}\n",
    )
    wanted = requirement(gyro__bias__x=3.0 * DEG_PER_HOUR)
    document = what_if(Question.of(load_device(file), requirement=wanted)).to_dict()

    assert document["coverage"] == 0.9
    (sensor,) = document["sensors"]
    assert sensor["missing"] == [
        "bias stability",
        "noise",
        "scale factor repeatability",
    ]
    bias, mounting = document["sources"]
    assert (bias["title"], bias["printed"]) == ("gyro bias repeatability", "0.05 deg/h")
    assert (bias["unit"], mounting["unit"]) == ("deg/h", "arcsec")
    assert_allclose([bias["u"], mounting["u"]], [0.05, 2.0 / 3.0**0.5], rtol=1e-12)
    x = next(o for o in document["outputs"] if o["name"] == "gyro.bias.x")
    assert (x["title"], x["group"], x["axis"]) == ("gyro bias x", "gyro bias", "x")
    assert_allclose([x["limit"], x["factor"]], [3.0, 1.6448536], rtol=1e-7)
    assert document["outputs"][0]["limit"] is None


def test_a_figure_doubled_in_the_file_is_the_factor_two(tmp_path):
    """The text '0.1 deg/h' in place of '0.05 deg/h' gives what the factor 2 gives."""
    text = (
        "name: one\ngyro:\n  nominal: {bias: 2.5 deg/h}\n  errors:\n"
        "    bias_repeatability: {value: FIGURE, meaning: max}\n"
        "    scale_factor_asymmetry: 1250 ppm\n"
    )
    devices = []
    for figure in ("0.05 deg/h", "0.1 deg/h"):
        file = put(tmp_path / "one.yaml", text.replace("FIGURE", figure))
        devices.append(load_device(file))

    agrees(
        what_if(Question.of(devices[0])).evaluate({"gyro.bias_repeatability": 2.0}),
        analyzed(devices[1]),
    )


@pytest.mark.parametrize(
    ("factors", "message"),
    [
        ({"gyro.nothing": 2.0}, "gyro.nothing: no source"),
        ({"gyro.bias_stability": -1.0}, "the factor on gyro.bias_stability is -1"),
        ({"gyro.bias_stability": float("inf")}, "is inf, expected 0 or more"),
    ],
)
def test_factors_that_mean_nothing_are_refused(factors, message):
    """An unknown source, a negative and an infinite factor are named."""
    with pytest.raises(CallError, match=message):
        what_if(Question.of(hard_device())).evaluate(factors)


def test_the_largest_size_that_meets_is_at_the_limit():
    """A device changed to it uses all of a limit, and one more of it fails."""
    wanted = load_requirement("tactical-grade")
    device = load_device("zhao-2019")
    options = {"requirement": wanted, "reference": wanted.reference, "validate": False}
    model = what_if(analyze(device, **options).question)
    rows = {row.source.name: row for row in one_at_a_time(model)}
    found = {name: row.most for name, row in rows.items()}
    assert found["gyro.angle_random_walk"] > 10.0
    for name in ("gyro.bias_repeatability", "accelerometer.scale_factor_repeatability"):
        changed = scaled(device, {name: found[name]})
        budget = analyze(changed, **options)
        used = [one.utilisation for one in budget.assessment.sensors]
        assert_allclose(max(used), 1.0, rtol=1e-9)
        assert rows[name].to_dict()["meets_up_to"] == found[name]
    assert [step.factor for step in rows[name].steps if step.verdict == "meets"] == [
        0.0,
        0.5,
        1.0,
        2.0,
    ]


def test_no_size_meets_where_others_are_beyond():
    """The paper's gyro has seven times too much by its other lines."""
    wanted = load_requirement("navigation-grade")
    question = analyze(
        load_device("zhao-2019"),
        requirement=wanted,
        reference=wanted.reference,
        validate=False,
    ).question
    rows = one_at_a_time(what_if(question))
    assert {row.most for row in rows} == {None}
    assert {row.to_dict()["meets_up_to"] for row in rows} == {None}


# ---- limits on a mission -------------------------------------------------------------

MILE = {
    "name": "a mile",
    "coverage": "90 %",
    "limits": {
        "gyro": {"bias": "1 deg/h"},
        "mission": {
            "position": {"horizontal": "0.8 m", "at": "60 s", "probability": "50 %"},
            "heading": {"limit": "20 arcsec", "at": "10 s"},
        },
    },
}


def oblong():
    """Return the paper's device with one accelerometer better than the others.

    So that the errors of position lie in an ellipse, which no source leaves as it is.
    """
    device = load_device("zhao-2019")
    lines = tuple(
        replace(one, u=one.u * np.array([1.0, 0.1, 1.0]))
        if one.name == "bias_repeatability"
        else one
        for one in device.accelerometer.lines
    )
    return replace(device, accelerometer=replace(device.accelerometer, lines=lines))


def on_outage(device):
    """Return the budget of a device against limits on a mission of a minute."""
    wanted = load_requirement(MILE)
    return analyze_as(
        Settings(validate=False),
        Question.of(device, requirement=wanted, mission=load_mission("outage-60-s")),
    )


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, "fails"),
        ({"gyro.bias_repeatability": 7.0}, "fails"),
        ({"accelerometer.bias_repeatability": 0.5}, "meets"),
        (
            {"gyro.bias_repeatability": 0.0, "accelerometer.bias_repeatability": 2.0},
            "fails",
        ),
    ],
)
def test_limits_on_a_mission_follow_the_sources(changes, verdict):
    """Verdict, largest error and shares are those of the changed device.

    The circle too, whose coverage factor changes with the shape of the ellipse.
    """
    device = oblong()
    budget = on_outage(device)
    model = what_if(budget.question, budget=budget)
    outlook = model.evaluate(changes)
    truth = on_outage(scaled(device, changes)).assessment
    ours = {one.sensor: one for one in outlook.sensors}

    assert [*ours] == [one.sensor for one in truth.sensors] == ["gyro", MISSION]
    for one in truth.sensors:
        assert ours[one.sensor].verdict == one.verdict
    assert ours[MISSION].verdict == verdict
    assert ours[MISSION].worst_outputs[0] == truth.sensors[1].worst_output
    judged = {row.output.name: row for row in truth.outputs}
    own = [k for k, one in enumerate(model.outputs) if one.name.owner == MISSION]
    assert {model.outputs[k].name for k in own} == {
        name for name in judged if name.owner == MISSION
    }
    for k in own:
        row = judged[model.outputs[k].name]
        assert_allclose(outlook.interval[k], row.interval, rtol=1e-9)
        assert_allclose(outlook.utilisation[k], row.utilisation, rtol=1e-9)
        assert_allclose(outlook.u[k], row.standard_uncertainty, rtol=1e-9)


def test_the_circle_changes_its_shape():
    """Control: its factor k is not that of the sources as they are."""
    model = what_if(on_outage(oblong()).question)
    k = [one.name.axis for one in model.outputs].index("horizontal")
    now, then = (
        model.evaluate(changes)
        for changes in ({}, {"accelerometer.bias_repeatability": 0.0})
    )
    factors = [one.interval[k, 1] / one.u[k] for one in (now, then)]
    assert abs(factors[1] / factors[0] - 1.0) > 1e-3
    assert_allclose(now.share[k].sum(), 1.0, rtol=0, atol=1e-6)


def test_trials_of_a_mission_keep_their_ratio_to_the_law():
    """At factors of 1 the interval that was judged, elsewhere in its shape."""
    device = oblong()
    lines = tuple(
        replace(one, distributions=(UNIFORM,) * 3)
        if one.name == "bias_repeatability"
        else one
        for one in device.accelerometer.lines
    )
    device = replace(device, accelerometer=replace(device.accelerometer, lines=lines))
    budget = on_outage(device)
    (row,) = (one for one in budget.assessment.outputs if one.by_trials)
    model, law = what_if(budget.question, budget=budget), what_if(budget.question)
    k = [one.name for one in model.outputs].index(row.output.name)
    changes = {"gyro.bias_repeatability": 7.0}

    assert row.output.name.axis == "horizontal"
    assert_allclose(model.evaluate({}).interval[k], row.interval, rtol=1e-9)
    half = [
        np.ptp(one.evaluate(factors).interval[k])
        for factors in ({}, changes)
        for one in (model, law)
    ]
    assert abs(half[0] / half[1] - 1.0) > 1e-3
    assert_allclose(half[2] / half[3], half[0] / half[1], rtol=1e-12)


def test_one_at_a_time_is_of_the_calibration():
    """Its U is of one coverage: limits of a mission have their own."""
    budget = on_outage(oblong())
    rows = one_at_a_time(what_if(budget.question, budget=budget))
    before = one_at_a_time(
        what_if(replace(budget.question, mission=None), budget=budget)
    )
    assert rows
    for row, own in zip(rows, before, strict=True):
        assert (row.source, row.output, row.share) == (
            own.source,
            own.output,
            own.share,
        )
        for step, same in zip(row.steps, own.steps, strict=True):
            assert step.expanded == same.expanded


def test_what_meets_is_up_to_the_limits_of_a_mission_too():
    """A line alone brings the mission to its limit; one that cannot has no factor.

    Control: by the limits of the calibration the gyro's line could grow.
    """
    device = oblong()
    budget = on_outage(device)
    rows = {
        row.source.name: row
        for row in one_at_a_time(what_if(budget.question, budget=budget))
    }
    name = "accelerometer.bias_repeatability"
    truth = on_outage(scaled(device, {name: rows[name].most})).assessment
    used = {one.sensor: one.utilisation for one in truth.sensors}
    calibration = replace(budget.question, mission=None)
    alone = {
        row.source.name: row.most
        for row in one_at_a_time(what_if(calibration, budget=budget))
    }

    assert_allclose(used[MISSION], 1.0, rtol=1e-9)
    assert {step.verdict for step in rows[name].steps} == {"meets", "fails"}
    assert rows["gyro.bias_repeatability"].most is None
    assert alone["gyro.bias_repeatability"] > 2.0


# ---- verdicts that hold if ----------------------------------------------------------


# A gyro that gives no mounting repeatability, against a limit of what that reaches.
ANGLE = {
    "name": "angles",
    "reference": "next_turn_on",
    "environment": "none",
    "limits": {"gyro": {"mounting_angle": "600 arcsec"}},
}
LACKING = "ltm210#S1B"
NOISE = "gyro.angle_random_walk"


@cache
def lacking():
    """Return the budget of it."""
    return analyzed_against(load_device(LACKING))


def analyzed_against(device):
    """Return the budget of a device against that limit."""
    return analyze(device, requirement=ANGLE, validate=False)


@pytest.mark.parametrize(
    ("factor", "verdict"),
    [(1.0, "meets_if"), (1.1, "meets_if"), (250.0, "undecidable"), (500.0, "fails")],
)
def test_a_missing_line_leaves_conditions(factor, verdict):
    """At its ceiling beside what is changed it is within, or not; or all is beyond.

    Of these the own budget of the changed device says the same.
    """
    budget, device = lacking(), load_device(LACKING)
    model = what_if(budget.question, budget=budget)
    (outlook,) = model.evaluate({NOISE: factor}).sensors
    lines = tuple(
        replace(one, u=one.u * factor) if one.name == NOISE.partition(".")[2] else one
        for one in device.gyro.lines
    )
    changed = replace(device, gyro=replace(device.gyro, lines=lines))
    (truth,) = analyzed_against(changed).assessment.sensors

    assert (truth.verdict, outlook.verdict) == (verdict, verdict)
    assert_allclose(outlook.utilisation, truth.utilisation, rtol=1e-9)
    (sensor,) = model.sensors
    assert [text.template for text in sensor.conditions] == ["conditions.stays_below"]


def test_at_the_ceilings_it_uses_what_the_verdict_says():
    """What missing lines add is what the standing of the budget is of."""
    budget = lacking()
    model = what_if(budget.question, budget=budget)
    (sensor,) = budget.assessment.sensors
    used = np.array(
        [
            np.sqrt(row.standard_uncertainty**2 + added) * factor / row.limit
            for row, added, factor in (
                (
                    row,
                    model.added[0, k],
                    model.coverage_factor[k],
                )
                for k, output in enumerate(model.outputs)
                for row in budget.assessment.outputs
                if row.output.name == output.name
            )
        ]
    )
    assert model.added[0].any()
    # The rest is the mean, of second order.
    assert_allclose(used.max(), sensor.at_ceilings, rtol=1e-3)


def test_limits_together_are_not_said_to_be_kept():
    """The law does not say here with what probability all are; one beyond fails."""
    limits = {"gyro": {"bias": "0.4 deg/h", "scale_factor": "300 ppm"}}
    wanted = load_requirement(
        {
            "name": "together",
            "limits": limits,
            "environment": "none",
            "decision": "joint",
        }
    )
    budget = analyze(load_device("zhao-2019"), requirement=wanted, validate=False)
    model = what_if(budget.question, budget=budget)
    own = [one.verdict for one in budget.assessment.sensors]

    assert [one.verdict for one in model.evaluate({}).sensors] == own == ["meets"]
    for factor, verdict in ((0.9, "undecided"), (9.0, "fails")):
        (found,) = model.evaluate({"gyro.bias_repeatability": factor}).sensors
        assert found.verdict == verdict
