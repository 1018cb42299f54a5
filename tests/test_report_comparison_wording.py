"""What a comparison says in words: the answer, and what it leaves open."""

from __future__ import annotations

import io

import pytest
from comparison_examples import compared, paper_device, requirement
from document_text import find, lines, section
from rich.console import Console

from budget.report.blocks import Listing
from budget.report.comparison.document import to_dict
from budget.report.comparison.page import comparison_document, comparison_sections
from budget.report.comparison.terminal import render_comparison
from budget.report.comparison.wording import unknown_cap_lines

BOTH = ("gyro", "accelerometer")
DATE = "2026-01-01"
CAPS = (("price", "100 EUR"), ("mass", "2 kg"), ("power", "9 W"))


def rendered(found, width=100):
    """Return what a terminal of a width shows."""
    console = Console(width=width, record=True, file=io.StringIO())
    render_comparison(found, console)
    return console.export_text()


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
    assert unknown_cap_lines(capped) == (
        "price, at most 100 EUR: given for no device",
        (
            "mass, at most 2 kg: not known for silent, "
            "poet ('light', which cannot be held against it)"
        ),
    )


def test_unknown_amounts_stand_in_terminal_page_and_document(capped):
    """Each of the three names the devices whose mass is not known."""
    page = comparison_document(capped, date=DATE)
    remarks = " ".join(lines(section(page, "remarks")))
    of = {one["name"]: one for one in to_dict(capped)["devices"]}

    assert "Not known whether over a cap" in rendered(capped)
    assert "not known for silent, poet" in rendered(capped)
    assert "Over a cap: heavy: mass 3 kg, at most 2 kg" in remarks
    assert "Cap on mass, at most 2 kg: not known for silent, poet" in remarks
    assert [one["merit"] for one in of["heavy"]["unknown_caps"]] == ["price"]
    assert of["poet"]["unknown_caps"][1] == {
        "merit": "mass",
        "cap": "2 kg",
        "text": "light",
    }


@pytest.mark.parametrize(
    ("caps", "said"),
    [((), "the requirement sets no cap"), (CAPS[2:], "no cap is exceeded")],
)
def test_no_cap_is_exceeded_only_where_there_is_one(caps, said):
    """Without remarks the page says whether there was a cap to keep."""
    found = compared(
        [paper_device(times=0.5, power="1 W")], requirement(caps=caps), method="gum"
    )
    remarks = section(comparison_document(found, date=DATE), "remarks")
    (listing,) = find(remarks, Listing)

    assert not listing.items
    assert said in listing.empty


def test_limits_of_a_sensor_that_no_device_has_are_not_met():
    """Gyros against limits for both sensors: every answer says what is not judged."""
    found = compared([paper_device(times=0.5)], requirement(sensors=BOTH), method="gum")
    document = comparison_document(found, date=DATE)
    first, *_ = comparison_sections(found)

    assert "accelerometer: limits not judged, no device here" in rendered(found)
    assert document.headline == "MET for the gyro: test requirement"
    for text in (document.summary[0], " ".join(lines(first))):
        assert "has a device that meets; the limits for the accelerometer" in text
        assert "are not judged" in text
    assert "limits the accelerometer" in " ".join(lines(section(document, "remarks")))
    assert to_dict(found)["not_compared"] == ["accelerometer"]
