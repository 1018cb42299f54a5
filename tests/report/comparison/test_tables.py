"""What a comparison says in words: the answer, and what it leaves open."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from builders import compared, paper_device, requirement
from reading import assert_says, find, lines, on_terminal, rows, section

from budget import documents
from budget.language import speaking
from budget.report.blocks import Picture, Table
from budget.report.comparison.figures import map_chart
from budget.report.comparison.page import (
    comparison_answer,
    comparison_document,
    comparison_sections,
)
from budget.report.comparison.tables import rankings, tallies
from budget.report.document import json_pieces

pytestmark = pytest.mark.usefixtures("drawn_once")

BOTH = ("gyro", "accelerometer")
DATE = "2026-01-01"
CAPS = (("price", "100 EUR"), ("mass", "2 kg"), ("power", "9 W"))


def computed_apart(found):
    """Return what a report says of how a comparison in it was computed."""
    first, *_ = comparison_sections(found)
    return next(text for text in lines(first) if text.startswith("Computed"))


def rendered(found, width=100):
    """Return what a terminal of a width shows."""
    return on_terminal(comparison_answer(found, full=True), width)


@pytest.fixture(scope="module")
def capped():
    """Devices whose price nobody gives, whose mass two give, one in words."""
    devices = [
        paper_device("heavy", sensors=BOTH, times=0.5, mass="3 kg", power="1 W"),
        paper_device("silent", sensors=BOTH, times=0.6, power="2 W"),
        paper_device("poet", sensors=BOTH, times=0.7, mass="light", power="3 W"),
    ]
    wanted = requirement(sensors=BOTH, caps=CAPS)
    return compared(devices, wanted, method="gum")


def test_unknown_amounts_are_no_kept_caps(capped):
    """A cap says for which devices nobody knows; one that all keep says nothing."""
    found = lines(section(comparison_document(capped, date=DATE), "remarks"))
    price, mass = (line for line in found if line.startswith("Cap on "))
    assert_says(price, "price, at most 100 EUR", "given for none of 3 devices")
    assert_says(mass, "mass, at most 2 kg", "for 2 of 3 devices", "poet ('light'")
    assert "silent" not in price + mass


def test_unknown_amounts_stand_in_terminal_page_and_document(capped):
    """Each of the three says of how many the mass is not known."""
    page = comparison_document(capped, date=DATE)
    remarks = " ".join(lines(section(page, "remarks")))
    of = {one["name"]: one for one in capped.to_dict()["devices"]}

    for text in (rendered(capped), remarks):
        assert_says(text, "mass, at most 2 kg", "no amount is given for 2 of 3")
    assert_says(remarks, "over a cap: heavy", "mass 3 kg")
    assert [one["merit"] for one in of["heavy"]["unknown_caps"]] == ["price"]
    assert of["poet"]["unknown_caps"][1] == {
        "merit": "mass",
        "cap": "2 kg",
        "text": "light",
    }


@pytest.mark.parametrize(
    ("caps", "said"),
    [((), "None."), (CAPS[2:], "None; no cap on price, mass or power is exceeded")],
)
def test_no_cap_is_exceeded_only_where_there_is_one(caps, said):
    """Without remarks the page says whether there was a cap to keep."""
    one = paper_device(times=0.5, power="1 W")
    reads = replace(one, gyro=replace(one.gyro, range=np.full(3, 10.0)))
    found = compared([reads], requirement(caps=caps), method="gum")
    remarks = section(comparison_document(found, date=DATE), "remarks")
    (_, text) = lines(remarks)

    assert said in text


def test_limits_of_a_sensor_that_no_device_has_are_not_met():
    """Gyros against limits for both sensors: every answer says what is not judged."""
    found = compared([paper_device(times=0.5)], requirement(sensors=BOTH), method="gum")
    document = comparison_document(found, date=DATE)
    first, *_ = comparison_sections(found)

    assert_says(rendered(found), "accelerometer: limits not judged", "no device")
    for text in (document.headline, " ".join(lines(first))):
        assert_says(text, "MET", "limits for the accelerometer not judged")
        assert_says(text, "1 of 1 gyro meets")
    assert "limits the accelerometer" in " ".join(lines(section(document, "remarks")))
    assert found.to_dict()["not_compared"] == ["accelerometer"]


@pytest.mark.parametrize("sensors", [BOTH, ("accelerometer",)])
def test_json_is_written_piece_by_piece_as_if_at_once(sensors):
    """The same text as of the whole document, with devices and without one judged."""
    devices = [paper_device(times=0.5), paper_device(times=0.7)]
    found = compared(devices, requirement(sensors=BOTH), method="gum", pairs=True)
    if sensors != BOTH:
        found = replace(found, devices=(), pairs=())
    whole = json.dumps(found.to_dict(), ensure_ascii=False, indent=1) + "\n"
    assert "".join(json_pieces(documents.document(found))) == whole


def test_sections_in_a_report_say_how_they_were_computed():
    """Method, trials and seed stand there, and that page one can differ a little."""
    found = compared([paper_device(times=0.5)], seed=7)
    first, *_ = comparison_sections(found)
    text = " ".join(lines(first))

    assert "95 % coverage" in text
    assert_says(text, "Monte Carlo (JCGM 101)", "20 000 trials of each device")
    assert_says(text, "seed 7", "can differ", "page one", "last digits")


def test_more_trials_of_open_verdicts_are_said():
    """Where a device got more trials than all had, the most are named."""
    found = compared([paper_device(times=0.5)])
    (one,) = found.devices
    more = replace(found, devices=(replace(one, trials=80_000),))

    assert "up to 80 000 where" in computed_apart(more)
    assert "up to" not in computed_apart(found)


def test_a_comparison_by_the_law_claims_no_trials():
    """By gum the sentence names the law, and no trials."""
    text = computed_apart(compared([paper_device(times=0.5)], method="gum"))

    assert_says(text, "GUM propagation (JCGM 100)", "seed 0")
    assert "trials" not in text


def test_assumptions_of_compared_devices_stand_in_the_report():
    """Alike assumptions are one row; figures and devices are gathered in it."""
    found = compared([paper_device(f"d{n}", times=0.5) for n in range(3)], method="gum")
    assumed = replace(
        found,
        assumptions=tuple(
            f"d{n}: gyro.{line}: 'typical' taken as 1 sigma"
            for n in range(3)
            for line in ("bias_stability", "angle_random_walk")
        ),
    )
    part = section_of(comparison_sections(assumed), "comparison-assumptions")

    assert rows(part) == [
        (
            "gyro bias stability, gyro angle random walk",
            "'typical' taken as 1 sigma",
            "all 3 devices",
        )
    ]


@pytest.mark.parametrize(
    ("masses", "said"),
    [
        (
            ("140 g", "0.14 kg", ""),
            "the 2 devices that give one have the same, 0.14 kg",
        ),
        (("140 g", "", ""), "only d0 gives one that can be compared"),
    ],
)
def test_a_front_that_would_show_nothing_is_said_in_words(masses, said):
    """Points of one mass, as variants have, or a single point make no figure."""
    devices = [
        paper_device(f"d{n}", times=0.1 + 0.2 * n, mass=mass, power=f"{n + 1} W")
        for n, mass in enumerate(masses)
    ]
    document = comparison_document(compared(devices, method="gum"), date=DATE)
    fronts = [p.name for p in find(document, Picture) if p.name.startswith("front")]

    assert fronts == ["front-power-gyro-0"]
    text = " ".join(lines(section(document, "figures")))
    assert_says(text, "price: no device gives one", f"mass: {said}")


def test_with_every_front_drawn_nothing_is_said_of_fronts():
    """Two prices, masses and powers make three figures and no sentence about them."""
    devices = [
        paper_device(
            f"d{n}",
            times=0.1 + 0.2 * n,
            price=f"{n + 1} EUR",
            mass=f"{n + 1} kg",
            power=f"{n + 1} W",
        )
        for n in range(2)
    ]
    document = comparison_document(compared(devices, method="gum"), date=DATE)

    assert sum(p.name.startswith("front") for p in find(document, Picture)) == 3
    assert "No figure" not in " ".join(lines(document.sections))


def test_the_map_names_no_device_that_lacks_a_specification():
    """Nearly no error, but specifications missing: it is asked for, not drawn."""
    bare = paper_device("bare", times=0.01, missing=("bias_stability",))
    bad = paper_device("bad", times=20.0, missing=("bias_stability",))
    good = paper_device("good", times=0.5)

    def titled(*devices):
        found = compared(list(devices), method="gum")
        return map_chart(rankings(found)[0], "map", None).title

    assert_says(titled(bare, good), "tightest for the only device judged")
    assert_says(titled(good, bad), "tightest", "1 more does not give all")
    assert_says(titled(bad), "no device that is decided gives all")


def test_devices_that_lack_specifications_are_marked():
    """The map marks what is this or more, and leaves out what cannot be judged."""
    devices = [
        paper_device("bare", times=0.01, missing=("bias_stability",)),
        paper_device("beyond", times=20.0, missing=("bias_stability",)),
        paper_device("whole", times=0.5),
    ]
    document = comparison_document(compared(devices, method="gum"), date=DATE)
    (drawn,) = (p for p in find(document, Picture) if p.name.startswith("map"))
    ranking = next(t for t in find(document, Table) if t.name == "ranking")

    assert ">beyond *<" in drawn.svg
    assert ">whole<" in drawn.svg
    assert "bare" not in drawn.svg
    assert "*: specifications are not given" in drawn.caption
    told = {row[0].text: row[2].text for row in ranking.groups[0].rows}
    assert told.keys() == {"beyond", "whole"}
    assert told["beyond"].startswith("≥")
    assert not told["whole"].startswith("≥")


def judged(found, verdict, **more):
    """Return a comparison with one verdict on every device."""
    devices = tuple(replace(one, verdict=verdict, **more) for one in found.devices)
    return replace(found, devices=devices)


@pytest.mark.parametrize(
    ("verdict", "headline", "counts"),
    [
        ("meets", "MET", "3 of 3 gyros"),
        ("meets_if", "MET ON CONDITIONS", "3 of 3 gyros (on conditions)"),
        ("undecided", "NOT MET", "0 of 3 gyros"),
    ],
)
def test_the_answer_is_by_the_best_verdict(capped, verdict, headline, counts):
    """Of required sensors, of those that are judged alone, and in every language."""
    found = judged(capped, verdict)
    partly = replace(
        found,
        devices=tuple(one for one in found.devices if one.sensor == "gyro"),
        not_compared=("imu", "mission"),
    )

    for one, of in ((found, ": "), (partly, ", limits for the gyro and acc")):
        page = comparison_document(one, date=DATE)
        assert page.headline.startswith(f"{headline}{of}")
        assert counts in page.headline
        assert page.headline.endswith(" meet test requirement")
        with speaking("zh"):
            page = comparison_document(one, date=DATE)
        assert "test requirement" in page.headline
        assert not re.search("MET|device|judged", page.headline + page.summary[0])
    assert_says(" ".join(lines(comparison_sections(partly))), "both triads")


@pytest.mark.parametrize(
    ("verdict", "said"),
    [
        ("meets", "MET: 3 of 3 units on the mission meet"),
        ("meets_if", "MET ON CONDITIONS: 3 of 3 units on the mission (on conditions)"),
        ("fails", "NOT MET: 0 of 3 units on the mission meet"),
    ],
)
def test_the_answer_on_a_mission_alone_names_no_sensor(capped, verdict, said):
    """Units meet, do so on conditions, or none does."""
    gyros = tuple(one for one in capped.devices if one.sensor == "gyro")
    alone = replace(capped, devices=gyros, mission="flight")
    found = judged(alone, verdict, sensor="mission")
    page = comparison_document(found, date=DATE)

    assert page.headline.startswith(said)
    assert_says(" ".join(page.summary), "on the mission flight")
    assert "gyro" not in page.headline


def test_who_meets_after_any_procedure_is_counted_once(capped):
    """On conditions after one and without after another: a device that meets."""
    gyros = [one for one in capped.devices if one.sensor == "gyro"]
    first = judged(replace(capped, devices=tuple(gyros)), "meets_if").devices
    second = [replace(one, procedure="other") for one in gyros[:1]]
    procedures = (*capped.procedures, "other")
    found = replace(capped, devices=(*first, *second), procedures=procedures)

    (one,) = tallies(found)
    assert (one.devices, one.meeting, one.conditional) == (3, 3, 2)


def test_devices_of_which_nothing_is_known_are_named(capped):
    """Among what cannot be judged, with all that there is to ask for."""
    (one, *_) = [device for device in capped.devices if device.sensor == "gyro"]
    bare = replace(one, name="bare", place=9, verdict="undecidable", outputs=())
    page = comparison_document(replace(capped, nothing_known=(bare,)), date=DATE)

    ((names, ask, *_),) = rows(section(page, "not-judged"))
    assert names == "bare"
    assert_says(ask, "every error specification", "none is given")
    assert "1 undecidable" in " ".join(lines(page.cards[0]))
    assert "of 4 gyros" in page.headline


def test_advice_is_given_once_for_all_that_it_is_for(capped):
    """With the devices and their sensors."""
    advice = "near the limit: use --method monte-carlo"
    page = comparison_document(judged(capped, "meets", advice=advice), date=DATE)
    (text,) = [one for one in lines(section(page, "remarks")) if "near the" in one]

    assert_says(text, "heavy (gyro)", "poet (accelerometer)", "monte-carlo")


def section_of(parts, name):
    """Return the section of that name."""
    (found,) = (part for part in parts if part.name == name)
    return found
