"""The range of a sensor: what a file may say of it, and what the record then has."""

from __future__ import annotations

import pytest
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose
from reading import assert_says

from budget.errors import SpecError
from budget.inputs import load_device
from budget.inputs.device import read_device
from budget.inputs.files import find, open_file
from budget.inputs.schema import json_schema
from budget.units import DEGREE, STANDARD_GRAVITY

GYRO = {"errors": {"bias_stability": "1 deg/h"}}
BOTH = {"name": "x", "gyro": GYRO, "accelerometer": {"errors": {}}}
ONE = {"name": "x", "gyro": GYRO}


def gyro_range(tree):
    """Return the range of the gyro of a file [deg/s]."""
    return load_device(tree).gyro.range / DEGREE


@pytest.mark.parametrize(
    "tree",
    [
        {**ONE, "range": "300 deg/s"},
        {**ONE, "range": "±300 deg/s"},
        {**BOTH, "range": {"gyro": "300 deg/s"}},
        {**ONE, "range": {"gyro": {"value": "300 deg/s", "condition": "selectable"}}},
        {"name": "x", "gyro": {**GYRO, "range": "300 deg/s"}},
        {"name": "x", "gyro": {**GYRO, "range": {"value": "5.235987755982989 rad/s"}}},
        {**ONE, "range": {"gyro": dict.fromkeys("xyz", "300 deg/s")}},
    ],
)
def test_every_form_says_the_same(tree):
    """One number for three axes, wherever and however a file says it."""
    assert_allclose(gyro_range(tree), [300.0] * 3, rtol=1e-14)


def test_axes_replace_the_value_that_stands_for_the_others():
    """The value counts for x and y, z has its own."""
    tree = {**ONE, "range": {"gyro": {"value": "300 deg/s", "z": "100 deg/s"}}}
    assert_allclose(gyro_range(tree), [300.0, 300.0, 100.0], rtol=1e-14)


def test_what_is_not_given_is_no_number():
    """None, and no text: neither zero nor infinity."""
    device = load_device(BOTH)
    assert [one.range for one in device.sensors] == [None, None]
    assert device.range == ""


def test_g_is_that_of_the_file():
    """A range in g is of the g that the maker means."""
    tree = {**BOTH, "gravity_unit": "9.8 m/s^2", "range": {"accelerometer": "10 g"}}
    assert_allclose(load_device(tree).accelerometer.range, [98.0] * 3, rtol=1e-14)
    usual = {**BOTH, "range": {"accelerometer": "10 g"}}
    found = load_device(usual).accelerometer.range
    assert_allclose(found, [10.0 * STANDARD_GRAVITY] * 3, rtol=1e-14)


def test_people_read_what_the_maker_prints():
    """Numbers with both signs, options and condition beside them."""
    of_gyro = {
        "value": "2000 deg/s",
        "options": "250, 2000 deg/s",
        "condition": "full scale",
    }
    tree = {**BOTH, "range": {"gyro": of_gyro, "accelerometer": "10 g"}}
    assert_says(
        load_device(tree).range,
        "gyro ±2000 deg/s (of 250, 2000 deg/s; full scale)",
        "accelerometer ±10 g",
    )
    by_axis = {**ONE, "range": {"gyro": {"value": "3 deg/s", "z": "1 deg/s"}}}
    assert "x ±3 deg/s, y ±3 deg/s, z ±1 deg/s" in load_device(by_axis).range


@pytest.mark.parametrize(
    ("tree", "facts"),
    [
        # As files said it when it was a text.
        (
            {**BOTH, "range": "gyro 400 °/s (±); accelerometer 5 g (±)"},
            ["range", "{gyro: 300 deg/s, accelerometer: 10 g}", "condition"],
        ),
        ({**ONE, "range": 300}, ["range", "300", "{gyro: 300 deg/s"]),
        ({**ONE, "range": "300 deg"}, ["range", "300 deg"]),
        ({**ONE, "range": "0 deg/s"}, ["range", "0 deg/s"]),
        ({**ONE, "range": {"gyro": "-3 deg/s"}}, ["range.gyro", "positive"]),
        ({**ONE, "range": {"gyro": "3 g"}}, ["range.gyro", "an angular rate"]),
        ({**ONE, "range": {"gyros": "3 deg/s"}}, ["gyros", "did you mean 'gyro'"]),
        ({**ONE, "range": "10 g"}, ["accelerometer", "figures"]),
        ({**ONE, "range": {"gyro": {"x": "3 deg/s"}}}, ["y, z", "expected value"]),
        ({**ONE, "range": {"gyro": {"condition": "wide"}}}, ["x, y, z"]),
        (
            {
                "name": "x",
                "range": "3 deg/s",
                "gyro": {**GYRO, "range": "4 deg/s"},
            },
            ["range", "stands under gyro", "remove"],
        ),
    ],
)
def test_what_is_no_range_is_refused(tree, facts):
    """At its place, with what was found and the form that is expected."""
    with pytest.raises(SpecError) as caught:
        load_device(tree)
    assert_says(str(caught.value), *facts)


def test_variants_override_sensor_by_sensor():
    """A variant that says one range leaves that of the other sensor."""
    variants = {
        "wide": {"range": {"accelerometer": "80 g"}},
        "slow": {"range": {"gyro": {"z": "100 deg/s"}}},
        "own": {"range": {"gyro": "20 deg/s"}},
    }
    of_gyro = {"value": "400 deg/s", "condition": "c"}
    tree = {
        **BOTH,
        "range": {"gyro": of_gyro, "accelerometer": "5 g"},
        "variants": variants,
    }
    document = open_file(find(tree), "device")
    assert [read_device(document, name).range for name in ("", *variants)] == [
        "gyro ±400 deg/s (c); accelerometer ±5 g",
        "gyro ±400 deg/s (c); accelerometer ±80 g",
        "gyro x ±400 deg/s, y ±400 deg/s, z ±100 deg/s (c); accelerometer ±5 g",
        "gyro ±20 deg/s; accelerometer ±5 g",
    ]


@pytest.mark.parametrize(
    ("given", "is_valid"),
    [
        ("300 deg/s", True),
        ("±300 deg/s", True),
        ({"gyro": "300 deg/s", "accelerometer": {"value": "10 g", "z": "5 g"}}, True),
        ("gyro 400 °/s (±)", False),
        ("-300 deg/s", False),
        ({"gyros": "300 deg/s"}, False),
    ],
)
def test_an_editor_is_told_the_same(given, is_valid):
    """The schema allows what is read, and refuses the text of old."""
    schema = Draft202012Validator(json_schema("device"))
    assert schema.is_valid({**ONE, "range": given}) == is_valid
