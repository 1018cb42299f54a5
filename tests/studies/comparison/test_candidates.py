"""What limits a device and what it lacks; fronts, caps, pairs, warnings, grades."""

from __future__ import annotations

import itertools
from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from builders import (
    K95,
    NOWHERE,
    by_name,
    compared,
    device,
    line,
    only_bias,
    paper_device,
    procedure,
    requirement,
)
from numpy.testing import assert_allclose

from budget.calibration.problem import calibration_problem
from budget.distributions import UNIFORM
from budget.errors import CallError
from budget.inputs.records import Requirement
from budget.methods.gum import propagate
from budget.missing.grades import completeness, grade, kind_of_device
from budget.question import Question
from budget.studies.figures_of_merit import (
    Amount,
    front,
    over_cap,
    read_amount,
)
from budget.studies.judgement import find_remedy, screen
from budget.units import DEG_PER_HOUR, MICRO_G

# What limits it, and what is missing


def test_remedy_brings_the_worst_output_to_its_limit():
    """With the factor on the limiting source alone, the law's utilisation is 1."""
    bad = paper_device(times=3.0)
    asked = Question.of(bad, procedure=procedure(), requirement=requirement())
    one, law = asked.held, asked.law
    ends = np.abs(law.interval(0.95)).max(axis=1) / one.limits
    judged = screen(one, seed=0)
    worst = judged.worst
    remedy = find_remedy(one, judged)
    mended = replace(
        bad.gyro,
        lines=tuple(
            replace(line, u=remedy.factor * line.u)
            if f"gyro.{line.name}" == remedy.source
            else line
            for line in bad.gyro.lines
        ),
    )
    after = propagate(calibration_problem((mended,), procedure()))

    assert ends[worst] > 1.0
    assert_allclose(
        np.abs(after.interval(0.95)[worst]).max() / one.limits[worst], 1.0, rtol=1e-6
    )


def test_source_that_alone_cannot_mend_has_no_factor():
    """Where the others are beyond the limit by themselves, no factor is named."""
    lines = {
        "bias_repeatability": 2.0 * DEG_PER_HOUR,
        "bias_stability": 2.0 * DEG_PER_HOUR,
    }
    found = compared([device("x", gyro=lines)], method="gum").devices[0]

    assert found.verdict == "fails"
    assert found.remedy.factor is None


def test_missing_line_is_bounded_by_the_catalogue():
    """At worst it is what the worst device of the same technology and grade has."""
    bare = {"bias_stability": 0.04 * DEG_PER_HOUR}

    def offer(name, u, stability, technology):
        lines = {"bias_repeatability": u, "bias_stability": stability}
        sizes = {line: size * DEG_PER_HOUR for line, size in lines.items()}
        return device(name, gyro=sizes, technology=technology)

    catalogue = [
        offer("mems", 9.0, 0.04, "bulk MEMS"),
        offer("coarse fog", 9.0, 11.0, "FOG"),
        offer("best fog", 0.1, 0.04, "FOG"),
        offer("worst fog", 0.2, 0.05, "FOG, closed loop"),
        only_bias("fog of no grade", 9.0, technology="FOG"),
    ]
    found = compared(
        [device("x", gyro=bare, missing=("bias_repeatability",), technology="FOG")],
        catalogue=catalogue,
        method="gum",
    )
    bound = found.devices[0].missing

    (condition,) = found.devices[0].conditions
    assert condition.line == "gyro.bias_repeatability"
    assert_allclose(condition.ceiling, 0.2 * DEG_PER_HOUR, rtol=1e-12)
    assert bound.utilisation > found.devices[0].utilisation
    assert_allclose(bound.utilisation, K95 * sqrt(0.2**2 + 0.03**2), rtol=0.01)
    assert bound.verdict == "meets"


def test_missing_line_that_nobody_has_is_not_bounded():
    """Without such a line in the catalogue it decides, and has to be asked for."""
    bare = paper_device(missing=("bias_repeatability",))
    found = compared([bare], catalogue=[], method="gum")

    (condition,) = found.devices[0].conditions
    assert (found.devices[0].verdict, condition.decides) == ("undecidable", True)
    assert found.devices[0].missing.utilisation is None
    assert found.devices[0].missing.verdict == ""


# Fronts, caps, pairs


def test_front_is_what_brute_force_finds():
    """On 200 random points with ties, the front is that of the definition."""
    rng = np.random.default_rng(3)
    points = [
        (float(u), Amount(value=float(c), unit="KG") if c < 18 else None)
        for u, c in rng.integers(1, 21, (200, 2))
    ]
    known = [(u, a.value) for u, a in points if a is not None]
    expected = tuple(
        a is not None
        and not any(
            v <= u and c <= a.value and (v, c) != (u, a.value) for v, c in known
        )
        for u, a in points
    )

    assert front(points) == expected
    assert 0 < sum(expected) < 50


@pytest.mark.parametrize(
    ("merit", "text", "value", "unit"),
    [
        ("mass", "140 grams (typical)", 0.14, "kg"),
        ("mass", "12 g (±2)", 0.012, "kg"),
        ("power", "600 mW (<, ±15 V quiescent)", 0.6, "W"),
        ("price", "56.54 EUR (dealer price, reel of 500)", 56.54, "EUR"),
    ],
)
def test_amounts_are_read_as_makers_write_them(merit, text, value, unit):
    """A remark in brackets does not hide the number before it."""
    amount = read_amount(merit, text)

    assert_allclose(amount.value, value, rtol=1e-12)
    assert amount.unit == unit


def test_what_is_no_amount_is_not_guessed():
    """A range, a unit that is none, or words are no number."""
    for text in ("", "1 to 2 kg", "3 furlongs", "light", "5"):
        assert read_amount("mass", text) is None


def test_caps_are_shown_and_set_no_verdict():
    """A device above a cap says so and meets all the same."""
    heavy = paper_device("heavy", mass="3 kg")
    found = compared([heavy], requirement(caps=[("mass", "2000 g")]))

    assert found.devices[0].verdict == "meets"
    assert found.devices[0].over_caps == ("mass 3 kg, at most 2000 g",)
    assert not any(cap.merit == "mass" for cap in found.devices[0].unknown_caps)
    assert over_cap("mass", "2 kg", "2000 g") == ""
    assert over_cap("price", "3 USD", "2 EUR") == ""


def test_front_of_a_comparison_names_its_merit():
    """Light and bad, heavy and good are both on the front; heavy and bad is not."""
    found = compared(
        [
            paper_device("light", times=3.0, mass="1 kg"),
            paper_device("good", mass="2 kg"),
            paper_device("beaten", times=2.0, mass="3 kg"),
        ],
        method="gum",
    )

    fronts = {row.name: row.on_front for row in found.devices}
    assert fronts == {"light": ("mass",), "good": ("mass",), "beaten": ()}


def test_pairs_are_counted_together():
    """Every gyro with every accelerometer: no surer than either, the worse verdict."""
    both = ("gyro", "accelerometer")
    devices = [
        paper_device("a", sensors=both, times=2.0),
        paper_device("b", sensors=both, times=20.0),
    ]
    found = compared(devices, requirement(sensors=both), pairs=True, method="gum")

    assert len(found.pairs) == 4
    alone = compared(devices, requirement(sensors=both), method="gum")
    assert alone.pairs == ()
    own = {one for one in found.pairs if one.name == one.accelerometer}
    assert {replace(one, ahead=None) for one in alone.imus} == own
    for pair in found.pairs:
        g = by_name(found, pair.name)
        a = by_name(found, pair.accelerometer, "accelerometer")
        p, q = g.conformance.value, a.conformance.value
        error = sqrt(p * q * (1.0 - p * q) / 16_384)  # own sources: the product
        assert_allclose(pair.conformance.value, p * q, rtol=0, atol=4.0 * error)
        assert pair.conformance.value <= min(p, q)
        assert pair.utilisation == max(g.utilisation, a.utilisation)
        if "fails" in (g.verdict, a.verdict):
            assert pair.verdict == "fails"
    parts = [pair.utilisation for pair in found.pairs if pair.verdict == "fails"]
    assert parts == sorted(parts)


# Warnings and refusals


def test_devices_of_one_name_are_told():
    """Two devices of one name are compared, with a warning that names it."""
    found = compared([paper_device("twin"), paper_device("twin", times=2.0)])

    assert len(found.devices) == 2
    assert any("same name: twin" in text for text in found.warnings)


def test_impossible_limit_is_told():
    """A limit below what the paper's formula leaves without any error is named."""
    wanted = requirement()
    tight = replace(
        wanted,
        limits=tuple(
            replace(limit, limit=1e-17) if limit.output == "gyro.bias.z" else limit
            for limit in wanted.limits
        ),
    )
    tilted = paper_device()
    gyro = replace(tilted.gyro, nominal_mounting_angle=np.full(6, 1e-4))
    found = compared(
        [replace(tilted, gyro=gyro)],
        tight,
        method="gum",
        procedures=[procedure(formulas="paper")],
    )

    assert any("gyro bias z" in t and "no device" in t for t in found.warnings)


def test_sensor_without_limits_has_no_row():
    """A requirement for gyros leaves accelerometers out, and says so."""
    found = compared([paper_device(sensors=("gyro", "accelerometer"))])

    assert found.required == ("gyro",)
    assert any("no limit for the accelerometer" in t for t in found.warnings)


def test_sensor_that_no_device_has_is_told():
    """Limits on a sensor that nobody has are not passed over in silence."""
    wanted = requirement(sensors=("gyro", "accelerometer"))
    found = compared([paper_device()], wanted)

    assert any("which no device here has" in t for t in found.warnings)


def test_nothing_to_compare_is_an_error():
    """A requirement that limits no sensor of these devices cannot be judged."""
    wanted = Requirement(
        name="other",
        coverage=0.95,
        reference="nominal",
        limits=requirement(sensors=("accelerometer",)).limits,
        caps=(),
        assumptions=(),
        origin=NOWHERE,
    )
    with pytest.raises(CallError, match="limits no sensor") as caught:
        compared([paper_device()], wanted)
    assert f"nothing that {procedure().name} estimates" in str(caught.value)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"method": "linear"}, "allowed: gum, monte-carlo"),
        ({"method": "monte-carlo", "validate": True}, "take --method gum"),
        ({"trials": 1}, "2 to "),
        ({"trials": 200, "max_trials": 100}, "no more than --max-trials"),
        ({"procedures": [procedure(), procedure()]}, "of the same name"),
    ],
)
def test_bad_calls_are_refused(options, said):
    """What means nothing, or nothing together, is refused and says what is allowed."""
    with pytest.raises(CallError, match=said):
        compared([paper_device()], **options)


def test_validation_names_what_the_law_gets_wrong(monkeypatch):
    """An interval of the law that trials do not confirm is named; theirs is none."""
    flat = device(
        "flat",
        gyro=[line("bias_repeatability", 0.5 * DEG_PER_HOUR, distribution=UNIFORM)],
    )
    found = compared([flat], method="gum", validate=True)
    assert not [text for text in found.warnings if "not confirmed" in text]

    def sure(problem, law, coverage):
        """Take the law for exact whatever the shapes."""
        del problem, coverage
        return np.zeros(law.value.size)

    monkeypatch.setattr("budget.studies.judgement.end_accuracy", sure)
    found = compared([flat], method="gum", validate=True)
    (text,) = (t for t in found.warnings if "not confirmed" in t)
    assert "flat" in text
    assert "gyro bias x" in text
    assert "scale_factor" not in text


def test_is_met_takes_one_device_for_each_sensor():
    """A comparison is met only if some gyro and some accelerometer meet."""
    both = ("gyro", "accelerometer")
    wanted = requirement(sensors=both)
    good_gyro = paper_device("g")
    good_accelerometer = paper_device("a", sensors=("accelerometer",), times=0.5)
    bad = paper_device("bad", sensors=("accelerometer",), times=50.0)

    for devices, expected in (
        ([good_gyro, bad], False),
        ([good_gyro, bad, good_accelerometer], True),
    ):
        assert compared(devices, wanted, method="gum").is_met is expected


# Grades


@pytest.mark.parametrize(
    ("kind", "line_name", "sizes"),
    [
        (
            "gyro",
            "bias_stability",
            ((0.0099, "navigation"), (0.0101, "tactical"), (10.1, "consumer")),
        ),
        (
            "accelerometer",
            "bias_repeatability",
            ((99.0, "navigation"), (101.0, "tactical"), (5001.0, "consumer")),
        ),
    ],
)
def test_grades_change_at_their_sizes(kind, line_name, sizes):
    """Just below a size a sensor has the grade, just above it the next one."""
    unit = DEG_PER_HOUR if kind == "gyro" else MICRO_G
    for size, expected in sizes:
        found = device("x", **{kind: {line_name: size * unit}})
        assert grade(found.sensors[0]) == expected


def test_grade_of_what_is_not_given():
    """Without the line it goes by, a sensor has no grade."""
    assert grade(device("x", gyro={"angle_random_walk": 1e-6}).gyro) == "-"


def test_completeness_counts_expected_lines():
    """Five lines are expected; each missing one is one less."""
    for missing in itertools.chain([()], [("noise",), ("noise", "bias_stability")]):
        found = completeness(paper_device(missing=missing).gyro)
        assert str(found) == f"{5 - len(missing)}/5"


def test_kind_of_device():
    """Both sensors make an IMU; one alone is what it is."""
    assert kind_of_device(paper_device(sensors=("gyro", "accelerometer"))) == "IMU"
    assert kind_of_device(paper_device(sensors=("accelerometer",))) == "accelerometer"


def test_imus_are_ranked_as_one_device():
    """The worse triad rules; equal units tie, and one that cannot be judged is last.

    Each is better in one triad: the rank by the gyro alone is another one.
    """
    both = {"sensors": ("gyro", "accelerometer")}
    even = paper_device("even", times=0.3, **both)
    twin = replace(even, name="twin", gyro=replace(even.gyro, device="twin"))
    uneven = replace(
        paper_device("uneven", times=0.1, **both),
        accelerometer=paper_device("u", times=0.6, **both).accelerometer,
    )
    gap = paper_device("gap", times=0.1, missing=("bias_repeatability",), **both)
    found = compared([uneven, gap, even, twin], requirement(times=2.0, **both))

    names = [(pair.name, pair.printed_rank) for pair in found.imus]
    assert names == [("even", "1="), ("twin", "1="), ("uneven", "3"), ("gap", "")]
    assert next(one.name for one in found.devices if one.sensor == "gyro") == "uneven"
    pair = found.imus[2]
    assert pair.utilisation == by_name(found, "uneven", "accelerometer").utilisation
    assert {name.owner for name in pair.worst_outputs} == {"accelerometer"}
    assert found.imus[3].verdict == "undecidable"
    document = found.to_dict()
    assert [(one["name"], one["rank"]) for one in document["imus"]] == [
        *(("even", 1), ("twin", 1), ("uneven", 3), ("gap", None))
    ]
    (gap,) = (one for one in document["imus"] if one["name"] == "gap")
    parts = [one for one in document["devices"] if one["name"] == "gap"]
    assert len(parts) == len(gap["conditions"]) == 2
    assert gap["conditions"] == [one for part in parts for one in part["conditions"]]
    assert document["pairs"] == []
