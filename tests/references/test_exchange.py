"""Files key by key: what differs, and one key exchanged."""

from __future__ import annotations

import re

import pytest
from numpy.testing import assert_allclose
from places import DOCS
from reference_examples import DEVICE, parts_of

from budget.inputs.composer import compose
from budget.inputs.device import read_device
from budget.inputs.tree import YamlFile, plain
from budget.references.exchange import (
    FIGURE_TEXTS,
    RANGE_TEXTS,
    TEXTS,
    differences,
    effective,
    exchange,
    is_text,
)
from budget.units import DEG_PER_HOUR

FILES = DOCS / "files.md"
VARIANTS = """\
name: Family
abstract: true
gyro:
  errors:
    bias_repeatability: 1 deg/h
    angle_random_walk: {value: 0.1 deg/sqrt(h), meaning: typical}
variants:
  A: {gyro: {errors: {bias_repeatability: 2 deg/h}}}
  B: {gyro: {errors: {angle_random_walk: {meaning: 1 sigma}}}}
"""


def document(text, variant=""):
    """Return a device text as one device."""
    root, issues = compose(text, "imu.yaml")
    assert not issues
    whole = YamlFile(
        file="imu.yaml", base_name="imu.yaml", sha256="", root=root, issues=()
    )
    return effective(whole, variant)


def changed(before, after, **variants):
    """Return (key, before, after) of every difference."""
    one = document(before, variants.get("one", ""))
    other = document(after, variants.get("other", ""))
    return [(c.path, *c.shown) for c in differences(one, other)]


@pytest.mark.parametrize("variant", ["A", "B"])
def test_an_effective_variant_is_the_device(variant):
    """The variant laid over the base reads as the same figures as FILE#VARIANT."""
    root, _ = compose(VARIANTS, "f")
    whole = YamlFile(file="f", base_name="f", sha256="", root=root, issues=())
    there = read_device(whole, variant).gyro
    here = read_device(effective(whole, variant)).gyro

    assert effective(whole, variant).base_name == f"f#{variant}"
    assert [line.name for line in here.lines] == [line.name for line in there.lines]
    for one, other in zip(here.lines, there.lines, strict=True):
        assert_allclose(one.u, other.u, rtol=0)


def test_a_figure_is_named_by_its_line():
    """Short or long, a figure that differs is the line, not its `value`."""
    long = DEVICE.replace("0.05 deg/h", "{value: 0.06 deg/h}")
    assert changed(DEVICE, long) == [
        ("gyro.errors.bias_repeatability", "0.05 deg/h", "0.06 deg/h")
    ]


def test_spelling_is_no_difference():
    """Quotes, comments, order of keys and the short form of a figure say the same."""
    same = DEVICE.replace("0.05 deg/h", "{value: '0.05 deg/h'}  # as printed")
    assert changed(DEVICE, same) == []
    swapped = "notes: not a number\n" + DEVICE.replace("notes: not a number\n", "")
    assert changed(DEVICE, swapped) == []


def test_keys_that_come_and_go():
    """A key that is on one side only has no value on the other."""
    less = DEVICE.replace("    scale_factor_asymmetry: 40 ppm\n", "")
    assert changed(DEVICE, less) == [
        ("gyro.errors.scale_factor_asymmetry", "{value: 40 ppm}", "")
    ]
    assert changed(less, DEVICE) == [
        ("gyro.errors.scale_factor_asymmetry", "", "{value: 40 ppm}")
    ]


def test_lists():
    """A list of words is one value; records of a list are compared one by one."""
    text = "gyro: {order: [z, x, y]}\nfigures: [{name: a, value: 1 V}, {name: b}]\n"
    other = text.replace("[z, x, y]", "[x, z, y]").replace("1 V", "2 V")
    assert changed(text, other) == [
        ("gyro.order", "[z, x, y]", "[x, z, y]"),
        ("figures[0]", "1 V", "2 V"),
    ]
    longer = text.replace("{name: b}", "{name: b}, {name: c}")
    ((path, _, _),) = changed(text, longer)
    assert path == "figures"


def test_exchanged_one_by_one_the_file_becomes_the_other():
    """All keys exchanged in turn give the file after; one alone changes just that."""
    after = (
        DEVICE.replace("0.05 deg/h", "0.06 deg/h")
        .replace("    scale_factor_asymmetry: 40 ppm\n", "")
        .replace("sample_noise: 50 ug", "velocity_random_walk: 5 ug/sqrt(Hz)")
        .replace("{xy: 4 arcsec}", "{xy: 5 arcsec, zx: 1 arcsec}")
    )
    here, there = document(DEVICE), document(after)
    changes = differences(here, there)

    assert len(changes) == 5  # the two angles are of one figure
    for change in changes:
        alone = exchange(here, change)
        (only,) = differences(here, alone)
        assert only.steps == change.steps
    for change in changes:
        here = exchange(here, change)
    assert plain(here.root) == plain(there.root)


@pytest.mark.parametrize(
    ("before", "after", "shown"),
    [
        (
            "1 deg/h",
            "{value: 1 deg/h, meaning: max, distribution: triangular}",
            ("1 deg/h", "{value: 1 deg/h, meaning: max, distribution: triangular}"),
        ),
        (
            "{value: 5 deg/h, meaning: max, axes: {z: 8 deg/h}}",
            "{value: 6 deg/h, meaning: max}",
            ("{value: 5 deg/h, axes: {z: 8 deg/h}}", "6 deg/h"),
        ),
        (
            "{value: 5 deg/h, axes: {x: 7 deg/h, z: 8 deg/h}}",
            "{value: 5 deg/h, axes: {x: 6 deg/h, z: 9 deg/h}}",
            (
                "{value: 5 deg/h, axes: {x: 7 deg/h, z: 8 deg/h}}",
                "{value: 5 deg/h, axes: {x: 6 deg/h, z: 9 deg/h}}",
            ),
        ),
    ],
)
def test_keys_of_one_figure_are_one_change(before, after, shown):
    """Keys of a figure that change together are exchanged and shown together."""
    one, other = (
        document(f"gyro: {{errors: {{bias_repeatability: {figure}}}}}\n")
        for figure in (before, after)
    )
    (change,) = differences(one, other)

    assert (change.path, *change.shown) == (
        "gyro.errors.bias_repeatability",
        *shown,
    )
    assert plain(exchange(one, change).root) == plain(other.root)


def test_a_text_of_a_figure_stands_alone():
    """A condition moves no number: it is no part of what changes a figure."""
    one = document("gyro: {errors: {bias_repeatability: 1 deg/h}}\n")
    long = "{value: 1 deg/h, condition: warm, meaning: max, distribution: arcsine}"
    other = document(f"gyro: {{errors: {{bias_repeatability: {long}}}}}\n")
    text, figure = sorted(differences(one, other), key=lambda c: -len(c.steps))

    assert text.steps[3:] == ("condition",)
    assert is_text("device", text.steps)
    assert not is_text("device", figure.steps)
    assert figure.keys == ("meaning", "distribution")
    assert (
        "condition"
        not in plain(exchange(one, figure).root)["gyro"]["errors"]["bias_repeatability"]
    )


def test_texts_are_those_of_the_docs():
    """The keys that by design move no number are those that docs/files.md lists."""
    _, _, table = FILES.read_text(encoding="utf-8").partition(
        "### Keys that move no number"
    )
    table, _, _ = table.partition("\n## ")
    rows: dict[str, set[str]] = {}
    for where, keys in re.findall(r"(?m)^\| ([a-z ]+) \| (`.*) \|$", table):
        rows.setdefault(where, set()).update(re.findall("`([a-z_]+)`", keys))
    every = rows["every file"]
    named = every | rows["every file but costs"]

    assert {
        "device": named | rows["device"],
        "procedure": named,
        "station": named,
        "mission": named,
        "requirement": named | rows["requirement"],
        "costs": every,
    } == TEXTS
    assert rows["a specification value"] == FIGURE_TEXTS
    assert rows["a range"] == RANGE_TEXTS


def test_an_exchange_leaves_the_file_it_was_made_of():
    """Nodes are shared, never changed."""
    (device, _) = parts_of()
    before = plain(device.root)
    after = document(DEVICE.replace("0.05 deg/h", "0.07 deg/h"))
    (change,) = differences(device, after)
    mixed = exchange(device, change)

    assert plain(device.root) == before
    u = read_device(mixed).gyro.line("bias_repeatability").u
    assert_allclose(u, 0.07 * DEG_PER_HOUR, rtol=1e-12)


def test_long_values_are_cut():
    """A value is shown on one line of at most 60 characters."""
    ((_, _, shown),) = changed("notes: a\n", f"notes: |\n  {'long ' * 40}\n  x\n")
    assert len(shown) == 60
    assert shown.endswith("...")
