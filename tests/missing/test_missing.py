"""What stands in the place of lines that are not given, by each mode."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import call
from keeping import catalogue
from numpy.testing import assert_allclose
from reading import on_terminal, section
from reading import rows as rows_of

from budget import load_device, load_requirement
from budget.errors import CallError
from budget.inputs.load import load_variants
from budget.missing import MODES, comparable, fill
from budget.names import Name
from budget.report.comparison.page import comparison_answer, comparison_document
from budget.report.comparison.tables import rankings, to_csv
from budget.report.document import json_text
from budget.studies.ceilings import ceilings
from budget.studies.comparison.compare import compare
from budget.studies.comparison.ranking import rank_devices
from budget.studies.verdicts import MEETS, MEETS_IF, VERDICTS

EDGE = load_requirement("catalogue-edge")
MOUNTING = Name("mounting_repeatability", owner="gyro")
LACKS_ONE = load_device("ltm210#S1B")  # the mounting repeatability


def compared(*devices, missing, **more):
    """Compare by the law alone."""
    return compare(
        devices, EDGE, catalogue=catalogue(), missing=missing, method="gum", **more
    )


def gyro_of(found, name):
    """Return the verdict on the gyro of a device."""
    (one,) = [d for d in found.devices if d.sensor == "gyro" and d.name == name]
    return one


@pytest.fixture(scope="module")
def by_mode():
    """Return comparisons of a few devices by every mode."""
    devices = [
        *load_variants("hg4930"),
        LACKS_ONE,
        *(
            load_device(name)
            for name in ("stim210", "stim300#5g", "stim300#80g", "cgm300s10")
        ),
    ]
    return {mode: compared(*devices, missing=mode) for mode in MODES}


def test_refuse_changes_nothing():
    """No line is put in, no assumption added: the device is the same object."""
    device, filling = fill(LACKS_ONE, "refuse", catalogue())

    assert device is LACKS_ONE
    assert filling.lines == filling.left == ()


def test_an_unknown_mode_is_refused():
    """With the words that are allowed."""
    with pytest.raises(CallError, match="refuse, worst, typical, predict"):
        fill(LACKS_ONE, "best", catalogue())


def median_of_designs(sizes):
    """Return the median of the designs' medians, counted by hand."""
    return np.median([np.median(own) for own in sizes.values()])


@pytest.mark.parametrize(
    ("mode", "take"),
    [
        ("worst", lambda sizes: max(one for own in sizes.values() for one in own)),
        ("typical", median_of_designs),
    ],
)
def test_worst_and_median_of_comparable_devices(mode, take):
    """Of the same sensor, technology and grade; of the largest axis of each.

    Variants of one file are one witness of what is typical.
    """
    offers = comparable(MOUNTING, LACKS_ONE, LACKS_ONE.gyro, catalogue())
    device, filling = fill(LACKS_ONE, mode, catalogue())
    (told,) = filling.lines
    line = device.gyro.line("mounting_repeatability")
    sizes = {}
    for offer, owner in offers:
        sizes.setdefault(owner.origin.sha256, []).append(np.log(offer.u.max()))
    expected = np.exp(take(sizes))

    assert told.devices == len(offers) >= 3
    assert_allclose(line.u.max(), expected, rtol=1e-9)
    assert told.expected == MOUNTING
    assert not device.gyro.expected_missing
    assert MOUNTING not in device.gyro.not_given
    assert any("not given" in text for text in device.assumptions[-1:])


def test_what_nobody_gives_is_left():
    """A gyro whose grade nobody can tell gets nothing by its grade."""
    bare = load_device("stim210")
    for mode in ("worst", "typical"):
        device, filling = fill(bare, mode, catalogue())
        assert device is bare
        assert filling.left == bare.gyro.expected_missing
    assert fill(bare, "predict", catalogue())[1].left == ()
    assert fill(bare, "predict", ())[1].left == bare.gyro.expected_missing


def test_a_sensor_without_any_line_stays_unknown():
    """Nothing is predicted of what gives nothing."""
    empty = replace(
        LACKS_ONE,
        gyro=replace(LACKS_ONE.gyro, lines=(), expected_missing=(MOUNTING,)),
    )
    for mode in MODES:
        assert fill(empty, mode, catalogue())[0] is empty
    found = compared(empty, missing="predict")
    assert [one.name for one in found.nothing_known] == [empty.name]


@pytest.mark.slow
def test_at_worst_is_no_better_than_worst(by_mode):
    """A ceiling is the worst comparable device's line, or more: hiding never helps."""
    found = 0
    for one in by_mode["refuse"].devices:
        if one.missing is None or one.at_worst is None:
            continue
        (worst,) = [
            each
            for each in by_mode["worst"].devices
            if (each.name, each.sensor) == (one.name, one.sensor)
        ]
        assert worst.utilisation <= one.at_worst * (1.0 + 1e-9)
        assert (one.missing.verdict == "fails") == (one.at_worst > 1.0)
        found += 1

    assert found > 4


def test_at_worst_is_that_of_a_device_with_the_ceilings():
    """What `refuse` prints as at worst is what a sheet at its ceilings comes to."""
    top = ceilings(LACKS_ONE, [MOUNTING], catalogue())[MOUNTING]
    gyro = LACKS_ONE.gyro.with_lines((*LACKS_ONE.gyro.lines, top.line))
    whole = replace(LACKS_ONE, gyro=replace(gyro, expected_missing=()))

    refused = gyro_of(compared(LACKS_ONE, missing="refuse"), LACKS_ONE.name)
    full = gyro_of(compared(whole, missing="refuse"), LACKS_ONE.name)
    assert_allclose(full.utilisation, refused.at_worst, rtol=1e-3)
    assert not full.utilisation.is_bound


def test_predictions_decide_what_is_undecidable(by_mode):
    """By `predict` every one of these has a probability, and none is undecidable."""
    refused = [d for d in by_mode["refuse"].devices if d.verdict == "undecidable"]
    found = by_mode["predict"]
    open_now = {(d.name, d.sensor) for d in refused}

    assert len(open_now) >= 6
    assert not [d for d in found.devices if d.verdict == "undecidable"]
    predicted = {(d.name, d.sensor): d for d in found.devices if d.doubt is not None}
    assert predicted.keys() == open_now
    for one in predicted.values():
        assert one.verdict == "predicted"
        low, high = one.doubt.utilisation_90
        assert low * (1.0 - 1e-9) <= one.utilisation <= high * (1.0 + 1e-9)
        assert sum(ask.reduction for ask in one.doubt.asks) > 0.0
        assert one.doubt.asks[0].reduction <= one.doubt.doubt
        assert {ask.source for ask in one.doubt.asks} == {*one.missing.lines}
    # What fails by what it gives, fails.
    for one in by_mode["refuse"].devices:
        if one.verdict == "fails" and one.sensor == "gyro":
            assert gyro_of(found, one.name).verdict == "fails"


def test_exit_code_goes_by_given_lines_alone():
    """A device that meets with lines of others does not make the requirement met."""
    for mode, verdict in (
        ("refuse", "undecidable"),
        ("worst", "meets_if"),
        ("typical", "meets_if"),
        ("predict", "predicted"),
    ):
        found = compared(LACKS_ONE, missing=mode)
        assert gyro_of(found, LACKS_ONE.name).verdict == verdict
        assert not found.is_met


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_what_rests_on_others_is_never_ahead_of_equals(by_mode, mode):
    """Devices that give all and meet come first; no lead and no front of the others."""
    for rows in by_mode[mode].lists.values():
        numbered = [one for one in rows if one.verdict in {MEETS, MEETS_IF}]
        given = [one.missing is None for one in numbered]
        assert given == sorted(given, reverse=True)
        p = [one.doubt.probability for one in rows if one.doubt is not None]
        assert p == sorted(p, reverse=True)
        order = [one.verdict for one in rows]
        assert order == sorted(order, key=VERDICTS.index)
        for one in rows:
            if one.missing is not None:
                assert one.ahead is None
                assert one.on_front == ()


def test_every_result_names_the_mode_and_the_lines(by_mode):
    """Terminal, page, JSON and CSV; by `refuse` none of them speaks of a mode."""
    for mode, found in by_mode.items():
        text = " ".join(on_terminal(comparison_answer(found, full=True)).split())
        document = json.loads(json_text(found.to_dict()))
        page = comparison_document(found, date="2026-01-01")
        said = "".join(page.summary)
        if mode == "refuse":
            assert "--missing" not in text + said + page.headline
            assert "missing" not in document["settings"]
            continue
        assert f"--missing {mode}" in text
        assert f"of other devices in the place of those not given ({mode})" in text
        assert f"--missing {mode}" in said
        stands = {"worst": "at the worst", "typical": "at the median"}
        how = stands.get(mode, "as predicted")
        assert f"with specifications not given {how} " in page.headline
        assert document["settings"]["missing"] == mode
        (one,) = [
            d
            for d in document["devices"]
            if d["name"] == LACKS_ONE.name and d["sensor"] == "gyro"
        ]
        assert one["missing"]["mode"] == mode
        (line,) = one["missing"]["filled"]
        assert line["source"] == MOUNTING
        assert line["devices"] >= 3
        assert line["printed"] in text
        # What nobody predicts, the g-sensitivity, may leave it open; nothing else.
        left = {own["line"] for own in one["conditions"]} - {MOUNTING}
        assert left <= {"gyro.g_sensitivity"}
        assert one["lower_bound"] is bool(left)
        assert (line["interval_90"] is not None) == (mode == "predict")


def test_a_prediction_looks_no_better_than_it_is(by_mode):
    """No conformance at medians: not in the table, not in JSON, not in CSV."""
    found = by_mode["predict"]
    (table,) = [each for each in rankings(found) if each.sensor == "gyro"]
    (row,) = [each for each in table.rows if each.device == LACKS_ONE.name]
    document = json.loads(json_text(found.to_dict()))
    (one,) = [
        d
        for d in document["devices"]
        if d["name"] == LACKS_ONE.name and d["sensor"] == "gyro"
    ]

    assert row.verdict.startswith("meets 0.")
    assert row.conformance == ""
    (fails,) = [d for d in found.devices if d.verdict == "fails" and d.at_medians][:1]
    assert fails.to_dict()["conformance"] is None
    assert row.ask.startswith("mounting repeatability 0.")
    assert one["conformance"] is None
    assert one["predicted"]["worth_asking"][0]["source"] == MOUNTING
    (first, *_) = [
        each
        for each in csv.DictReader(to_csv(found))
        if each["device"] == LACKS_ONE.name and each["sensor"] == "gyro"
    ]
    assert first["device_conformance"] == ""
    assert float(first["device_probability"]) == one["predicted"]["probability"]
    assert first["ask_first"] == MOUNTING
    assert "device_probability" not in next(to_csv(by_mode["refuse"]))


def test_pairs_of_predicted_parts():
    """The probability of a pair is the product; a part that fails, fails it."""
    device = load_device("cgm300s10")
    found = compared(device, missing="predict")
    (pair,) = found.imus
    parts = [one.doubt.probability for one in found.devices]

    assert pair.verdict == "predicted"
    assert_allclose(pair.probability, parts[0] * parts[1], rtol=1e-12)
    assert pair.to_dict()["conformance"] is None
    (failing,) = compared(load_device("stim300#80g"), missing="predict").imus
    assert (failing.verdict, failing.probability) == ("fails", None)
    assert failing.to_dict()["conformance"] is None


def test_what_fails_ranks_below_any_chance(by_mode):
    """A device that exceeds by what it gives is behind one that is open, at 0 too."""
    rows = [one for one in by_mode["predict"].devices if one.sensor == "gyro"]
    fails = next(one for one in rows if one.verdict == "fails" and not one.missing)
    likely = next(one for one in rows if one.doubt is not None)
    none = replace(likely, doubt=replace(likely.doubt, probability=0.0))
    some = replace(likely, doubt=replace(likely.doubt, probability=0.01))

    assert rank_devices([fails, none])[0].verdict == "predicted"
    assert rank_devices([fails, none, some])[0].doubt.probability == 0.01


def test_one_device_is_judged_as_among_others(by_mode):
    """What is predicted of a device does not depend on the ones compared with it."""
    alone = gyro_of(compared(LACKS_ONE, missing="predict"), LACKS_ONE.name)
    among = gyro_of(by_mode["predict"], LACKS_ONE.name)

    assert alone.doubt == among.doubt


def test_a_density_is_printed_as_makers_do():
    """A random walk per root of hertz is the one-sided density: N times sqrt(2)."""
    device, filling = fill(load_device("adis16495-1"), "predict", catalogue())
    line = device.accelerometer.line("velocity_random_walk")
    (told,) = [each for each in filling.lines if each.source.endswith(line.name)]
    ug = 9.80665e-6

    printed = float(told.printed.removesuffix(" ug/sqrt(Hz)"))
    assert_allclose(printed, np.sqrt(2.0) * line.u.max() / ug, rtol=6e-3)


def test_what_names_no_technology_is_told_so():
    """Nobody is comparable with it, which is no fault of the catalogue."""
    for device, reason in (
        (replace(LACKS_ONE, technology=""), "names no `technology`"),
        (load_device("stim210"), "no device of the catalogue"),
    ):
        found = compared(device, missing="worst")
        page = comparison_document(found, date="2026-01-01")
        ((*_, effect),) = rows_of(section(page, "missing"))
        assert reason in effect
        assert "nothing is known" in effect


@pytest.mark.parametrize("mode", ["worst", "typical", "predict"])
def test_a_headline_names_no_mode_where_nothing_was_put_in(mode):
    """All that is expected is given: the verdict rests on nothing else."""
    asked = ("analyze", "--requirement", "tactical-grade", "--no-validate")
    whole = call(*asked, "zhao-2019", "--missing", mode).out
    part = call(*asked, "adis16495-1", "--missing", mode).out

    assert "with specifications not given" not in whole.partition("Each of")[0]
    assert "with specifications not given" in " ".join(part.split())
