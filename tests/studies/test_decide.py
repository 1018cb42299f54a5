"""What to buy: the choice of compare, with the station and the age of their studies."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from command_line import call
from places import put
from reading import assert_says, on_terminal

from budget.errors import CallError
from budget.inputs import load_device, load_procedure
from budget.report.decision import decision_answer, decision_document
from budget.report.page import render_page
from budget.studies.allocation.allocate import allocate
from budget.studies.comparison.compare import compare
from budget.studies.decide import decide
from budget.studies.stations import qualify

NEED = {
    "name": "need",
    "environment": "none",
    "age": "0 s",
    "coverage": "95 %",
    "reference": "next_turn_on",
    "limits": {"mission": {"position": [{"horizontal": "3 km", "at": "60 s"}]}},
}
EDGE = "catalogue-edge"
DEVICES = ("hg4930#A", "hg4930#C", "stim300#5g", "primus-200")


@pytest.fixture(scope="module")
def at_the_edge():
    """Return the decision among four units, of which one meets."""
    return decide(DEVICES, EDGE)


@pytest.mark.slow
def test_the_choice_is_what_compare_ranks_first(at_the_edge):
    """A device has the gravest verdict and the largest utilisation of its parts."""
    found = compare(DEVICES, EDGE, method="gum")
    (purchase,) = at_the_edge.purchases

    assert purchase.chosen.name == found.imus[0].name == "HG4930 (C)"
    assert {one.name: one.verdict for one in purchase.best} == {
        pair.name: pair.verdict for pair in found.imus
    }
    assert purchase.chosen.utilisation == found.imus[0].utilisation
    assert at_the_edge.is_met


def test_what_cannot_be_judged_is_asked_for_and_never_bought(at_the_edge):
    """A unit that hides its repeatability stands behind one that fails for nobody."""
    (purchase,) = at_the_edge.purchases
    asked = {one.name: ask for one, ask in purchase.open}

    assert asked["Primus 200"].decides
    assert asked["Primus 200"].line.quantity == "bias_repeatability"
    assert {one.name for one in purchase.meeting} == {"HG4930 (C)"}
    assert {one.name for one in purchase.failing} == {"HG4930 (A)"}


def test_the_station_is_that_of_the_study_of_stations(at_the_edge):
    """Verdicts and ratios are those of `qualify` for the unit that is bought."""
    own = qualify(load_device("hg4930#C"), requirement=EDGE).stations
    (purchase,) = at_the_edge.purchases

    assert [(one.name, one.verdict, one.test_ratio) for one in purchase.stations] == [
        (one.name, one.verdict, one.test_ratio) for one in own
    ]


def test_a_unit_needs_no_test_where_its_maker_s_calibration_meets():
    """Both are told; the maker's goes first though a test may leave less."""
    found = decide(["hg4930#C"], NEED, mission="outage-60-s")
    (purchase,) = found.purchases

    assert [one.is_as_made for one in purchase.of_chosen] == [True, False]
    assert [one.verdict for one in purchase.of_chosen] == ["meets", "meets"]
    assert purchase.stations == ()


def test_a_test_is_chosen_where_the_maker_s_calibration_does_not_meet():
    """The verdict goes before the effort."""
    both = decide(["stim300#5g"], NEED, mission="outage-60-s").purchases[0].of_chosen
    least = min(one.utilisation for one in both)
    limit = 3000.0 * sum(one.utilisation for one in both) / 2.0
    need = NEED | {
        "limits": {
            "mission": {"position": [{"horizontal": f"{limit} m", "at": "60 s"}]}
        }
    }
    chosen = decide(["stim300#5g"], need, mission="outage-60-s").purchases[0].offers[0]

    assert chosen.utilisation == pytest.approx(least * 3000.0 / limit, rel=1e-9, abs=0)


@pytest.mark.slow
def test_the_age_is_that_of_the_allocation():
    """When it is due is what `allocate` says of the lines as they are."""
    device = load_device("hg4930#C").replace(
        {
            "gyro.ageing": {"value": "4 deg/h", "horizon": "1 year"},
            "accelerometer.ageing": {"value": "1 mg", "horizon": "1 year"},
        }
    )
    (purchase,) = decide([device], EDGE).purchases
    own = allocate(device, requirement=EDGE, validate=False).recalibrations

    assert purchase.recalibrations == tuple(
        one for one in own if one.goal == "devices as they are"
    )


def test_triads_are_bought_apart_where_no_unit_has_both():
    """One choice a sensor; the headline of each is its own."""
    found = decide(["adxrs453", "adxl357"], EDGE)

    assert [one.kind for one in found.purchases] == ["gyro", "accelerometer"]


@pytest.mark.slow
def test_the_same_calibration_is_named_as_it_is():
    """A procedure that is at hand takes the place of the paper's."""
    found = decide(["hg4930#C"], EDGE, ["twenty-four-positions", "zhao-2019"])

    assert found.calibrations == (
        load_procedure("twenty-four-positions").name,
        load_procedure("zhao-2019").name,
    )


@pytest.mark.slow
def test_the_command_answers_and_writes_its_page(tmp_path):
    """Terminal, page and document say the same; the exit code is the verdict's."""
    page = tmp_path / "d.html"
    need = "specs/requirements/catalogue-edge.yaml"
    found = call(
        "decide", need, *DEVICES, "-o", str(page), "--json", str(tmp_path / "d"), code=0
    )
    document = json.loads((tmp_path / "d").read_text("utf-8"))

    assert_says(found.out, "BUY HG4930 (C)", "95.3", "good three-axis table")
    assert "HG4930 (C)" in page.read_text("utf-8")
    assert document["purchases"][0]["chosen"] == "HG4930 (C)"
    assert call("decide", need, "stim300#5g").code == 1


@pytest.mark.parametrize("width", [80, 100])
def test_no_table_of_a_decision_is_split(at_the_edge, width):
    """Devices with price, mass and power stand in one table, on lines that fit."""
    text = on_terminal(decision_answer(at_the_edge), width)

    assert len([x for x in text.splitlines() if x.startswith("device ")]) == 1
    assert "140 grams" in text
    assert max(map(len, text.splitlines())) <= width


def test_makers_are_asked_once_for_what_decides(at_the_edge):
    """Devices of one maker that wait for the same stand in one point, with a bound."""
    text = " ".join(on_terminal(decision_answer(at_the_edge), 80).split())

    assert "Primus 200 (Sagem): gyro bias repeatability, which fails from" in text
    assert text.count("gyro bias repeatability, which") == 1


HOSTILE = "**a** | `b` $c$ <i> {{ 7*7 }} {% if %} # - 1."


def test_a_hostile_name_is_text():
    """Whatever a device, a maker or a need is called stands there as it is."""
    need = judged({"gyro": {"bias": "30 deg/h"}}) | {"name": f"need {HOSTILE}"}
    unit = replace(
        load_device("hg4930#C"),
        name=HOSTILE,
        vendor=f"maker {HOSTILE}",
        price=f"1 EUR {HOSTILE}",
    )
    silent = replace(unit, name=f"2 {HOSTILE}", gyro=empty(unit.gyro))
    found = decide((unit, silent), need)
    text = " ".join(on_terminal(decision_answer(found), 300).split())

    assert f"BUY {HOSTILE}: MEETS need {HOSTILE}" in text
    assert f"1 EUR {HOSTILE}" in text
    assert f"2 {HOSTILE} (maker {HOSTILE})" in text
    page = render_page(decision_document(found, date="2026-01-01"))
    assert "<i>" not in page.partition("<main")[2]


def test_calibrations_of_one_name_are_refused():
    """Nobody could tell which of them is meant; a calibration named twice is one."""
    with pytest.raises(CallError, match="of the same name: Zhao 2019"):
        decide("hg4930#C", EDGE, ["zhao-2019", "zhao-2019"])


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("absent",), "no such file"),
        ((EDGE, "absent.yaml"), "no such file"),
        ((EDGE, "hg4930", "--kind", "gyro"), "name no device"),
        ((EDGE, "hg4930", "--mission", "bench"), "no limit on a mission"),
        ((EDGE, "hg4930", "--json", "-", "--csv", "-"), "both write to stdout"),
        ((EDGE, "hg4930", "-o", "x.txt"), "allowed: .html, .pdf"),
        ((EDGE, "hg4930", "--age", "-1 year"), "not negative"),
        (("specs/devices/hg4930.yaml",), "expected a requirement"),
    ],
)
def test_a_bad_call_is_refused_and_says_why(args, said):
    """Exit code 2, nothing on stdout."""
    found = call("decide", *args, code=2)

    assert found.out == ""
    assert said in found.err


def test_where_nothing_is_given_everything_is_asked_for():
    """A unit of an empty sheet is not bought, and the headline says why."""
    unit = load_device("hg4930#C")
    need = judged({"gyro": {"bias": "30 deg/h"}})
    found = decide(replace(unit, gyro=empty(unit.gyro)), need)

    assert not found.is_met
    text = " ".join(on_terminal(decision_answer(found), 80).split())
    assert_says(text, "NO gyro here can be shown to meet need", "of 1 device")
    assert "HG4930 (C) (Honeywell): gyro" in text.partition("ask the makers")[2]


def empty(sensor):
    """Return a sensor of which no error specification is given."""
    return replace(sensor, lines=())


def judged(limits, **more):
    """Return a requirement on both triads."""
    return (
        {"name": "need", "environment": "none", "age": "0 s"}
        | more
        | {
            "reference": "next_turn_on",
            "limits": limits,
        }
    )


def test_limits_kept_together_are_those_of_the_whole_unit():
    """Each triad alone keeps its own with p, both together do not."""
    unit = load_device("hg4930#C")
    joint = {"decision": "joint", "coverage": "95 %"}
    loose = {"gyro": {"bias": "30 deg/h"}, "accelerometer": {"bias": "10 mg"}}
    rows = compare([unit], judged(loose, **joint), method="gum").devices
    used = {one.sensor: one.utilisation / 0.97 for one in rows}
    tight = {
        "gyro": {"bias": f"{30.0 * used['gyro']} deg/h"},
        "accelerometer": {"bias": f"{10.0 * used['accelerometer']} mg"},
    }
    need = judged(tight, **joint)
    found = compare([unit], need, method="gum")
    (purchase,) = decide([unit], need).purchases

    assert {one.verdict for one in found.devices} == {"meets"}
    assert found.imus[0].verdict == "fails"
    assert purchase.chosen is None
    assert purchase.offers[0].verdict == "fails"


def test_what_nobody_can_judge_is_not_bought():
    """A gyro alone meets its limits; those on the accelerometer stay unjudged."""
    found = decide(["cgys30cj3#A", "adxrs453"], EDGE)
    gyros = decide(["stim202"], judged({"gyro": {"bias": "1000 deg/h"}}))

    assert found.verdict in {"fails", "undecidable"}
    assert gyros.not_compared == ()
    both = judged({"gyro": {"bias": "1000 deg/h"}, "accelerometer": {"bias": "100 mg"}})
    left = decide(["stim202"], both)
    assert left.not_compared == ("accelerometer",)
    assert [one.chosen for one in left.purchases] == [None]
    assert not left.is_met


def test_a_headline_never_buys_what_is_not_judged(tmp_path):
    """The terminal names the limits that nobody judged, and the exit code is 1."""
    need = put(
        tmp_path / "need.yaml",
        "name: need\nenvironment: none\nage: 0 s\nlimits:\n"
        "  gyro: {bias: 1000 deg/h}\n  accelerometer: {bias: 100 mg}\n",
    )
    found = call("decide", str(need), "stim202", code=1)

    assert "BUY" not in found.out
    assert_says(found.out, "accelerometer", "not judged")


@pytest.mark.slow
def test_warnings_caps_and_the_rule_of_decision_stand_beside_the_choice(tmp_path):
    """What a comparison warns of is not lost on the way."""
    need = put(
        tmp_path / "need.yaml",
        "name: need\nenvironment: none\nage: 0 s\ndecision: each\n"
        "caps: {mass: 100 g}\nlimits:\n  gyro: {bias: 100 deg/h}\n",
    )
    found = call("decide", str(need), "hg4930#C")
    study = decide(["hg4930#C"], str(need))

    for text in study.warnings:
        assert_says(found.out, *str(text).split()[:4])
    assert_says(
        found.out, "each limit by itself, at 95 % coverage", "140 grams", "100 g"
    )


def test_a_test_that_age_does_not_reach_says_so():
    """Errors at the test itself do not age, and the sheet is not blamed for it."""
    device = load_device("hg4930#C").replace(
        {"gyro.ageing": {"value": "4 deg/h", "horizon": "1 year"}}
    )
    need = judged({"gyro": {"bias": "100 deg/h"}}) | {"reference": "as_tested"}
    (purchase,) = decide([device], need).purchases

    assert purchase.is_aged
    assert purchase.recalibrations == ()


@pytest.mark.parametrize(
    "line",
    [
        "gyro.scale_factor_repeatability=0 ppm",
        "gyro.bias_stability=0 deg/h",
        "gyro.angle_random_walk=0 deg/sqrt(h)",
    ],
)
def test_a_unit_that_hides_a_specification_is_not_preferred(line):
    """Less on what is given is no reason: the order is that of `compare`."""
    whole = replace(load_device("hg4930#C"), name="whole")
    hiding = replace(whole.replace(dict([line.split("=")])), name="hiding")
    limits = {"gyro": {"bias": "300 deg/h", "scale_factor": "20000 ppm"}}
    need = {"name": "need", "reference": "next_turn_on", "limits": limits}
    offers = decide([hiding, whole], need).offers
    ranked = compare([hiding, whole], need, method="gum").devices

    assert {one.verdict for one in ranked} == {"meets_if"}
    assert [one.name for one in ranked] == ["whole", "hiding"]
    assert [one.name for one in offers] == ["whole", "hiding"]
    assert offers[1].utilisation < offers[0].utilisation


def test_what_both_sheets_leave_open_is_said_once():
    """Neither triad says what vibration does: it is one use, of lines of both."""
    limits = {"gyro": {"bias": "300 deg/h"}, "accelerometer": {"bias": "100 mg"}}
    need = {"name": "need", "reference": "next_turn_on", "limits": limits}
    text = " ".join(
        on_terminal(decision_answer(decide(["hg4930#C"], need)), 80).split()
    )

    assert_says(
        text,
        "the effect of vibration and age",
        "accelerometer vibration rectification not given",
    )


def test_what_is_predicted_says_how_and_how_likely(tmp_path):
    """The mode stands beside the counts, the probability beside the word."""
    device = put(
        tmp_path / "part.yaml",
        "name: part given\ntechnology: FOG\ngyro:\n  range: 300 deg/s\n  errors:\n"
        "    bias_repeatability: 0.05 deg/h\n    angle_random_walk: 0.01 deg/sqrt(h)\n"
        "    scale_factor_repeatability: 10 ppm\n",
    )
    asked = ("decide", "tactical-grade", device)
    assert_says(
        call(*asked, "--missing", "predict", code=1).out,
        *("predicted 0.92", "verdicts that rest on them are probabilities"),
    )
    assert "PREDICTED" not in call(*asked, code=1).out.upper()


def test_a_file_that_cannot_be_read_is_said_and_left_out(tmp_path):
    """As by compare; the exit code is that of bad input."""
    bad = put(
        tmp_path / "comma.yaml",
        "name: comma\ngyro: {errors: {bias_repeatability: {value: 0,007 deg/h}}}\n",
    )
    run = call("decide", "tactical-grade", bad, "zhao-2019", code=2)
    assert "write a point (0.5, not 0,5)" in run.err
    assert "BUY Zhao 2019" in run.out
    other = call("compare", bad, "zhao-2019", "--requirement", "tactical-grade", code=2)
    assert other.err == run.err
