"""Variants of a device file: what they take from the base and what they replace."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import put

from budget.errors import SpecError
from budget.inputs import load_device, validate, variants

DEG_H = pi / 180.0 / 3600.0

VARIANTS = """\
name: Family
vendor: V
gyro:
  nominal: {bias: 1 deg/h}
  errors:
    bias_repeatability: 1 deg/h
    bias_stability: {value: 3 deg/h, meaning: 3 sigma, correlation_time: 100 s}
    sample_noise: {value: 2 deg/h, axes: {z: 4 deg/h}}
variants:
  A:
    gyro:
      errors:
        bias_repeatability: {meaning: 2 sigma}
        bias_stability: {correlation_time: 50 s}
        sample_noise: {axes: {x: 8 deg/h}}
  B:
    price: 9 EUR
    gyro:
      nominal: {bias: {x: 5 deg/h}}
      errors:
        bias_stability: 5 deg/h
        angle_random_walk: 1 deg/sqrt(h)
        sample_noise: {adds_to: angle_random_walk}
    accelerometer: {errors: {bias_repeatability: 1 ug}}
"""


@pytest.fixture
def family(tmp_path):
    """Return a device file with variants."""
    return put(tmp_path / "family.yaml", VARIANTS)


def test_variants_are_the_base_and_the_named_ones(family):
    """The base is '' in the list; each has its name, and its origin says which."""
    assert variants(family) == ("", "A", "B")
    assert load_device(family).name == "Family"
    device = load_device(f"{family}#B")
    assert device.name == device.gyro.device == "Family (B)"
    assert device.origin.file == "family.yaml#B"
    assert (device.vendor, device.price) == ("V", "9 EUR")


def test_a_variant_is_laid_over_the_base_key_by_key(family):
    """A mapping over a string keeps its value, over a mapping its other keys."""
    sensor = load_device(f"{family}#A").gyro
    assert_allclose(sensor.line("bias_repeatability").u, [0.5 * DEG_H] * 3, rtol=1e-15)
    stability = sensor.line("bias_stability")
    assert_allclose(stability.u, [DEG_H] * 3, rtol=1e-14)
    assert_allclose(stability.correlation_time, [50.0] * 3, rtol=0)
    noise = np.array([8.0, 2.0, 4.0]) * DEG_H
    assert_allclose(sensor.line("sample_noise").u, noise, rtol=1e-14)


def test_a_string_in_a_variant_replaces_a_mapping(family):
    """A figure given anew as a string is 1 sigma: no meaning of the base is left."""
    sensor = load_device(f"{family}#B").gyro
    assert_allclose(sensor.line("bias_stability").u, [5.0 * DEG_H] * 3, rtol=1e-14)
    assert_allclose(sensor.line("bias_stability").correlation_time, 300.0, rtol=0)
    assert_allclose(sensor.nominal_bias, [5.0 * DEG_H, 0.0, 0.0], rtol=1e-14, atol=0)
    assert sensor.line("angle_random_walk") is not None


def test_the_base_knows_nothing_of_its_variants(family):
    """What a variant adds is not in the base."""
    base = load_device(family)
    assert base.accelerometer is None
    assert base.gyro.line("angle_random_walk") is None
    assert_allclose(base.gyro.line("bias_repeatability").u, [DEG_H] * 3, rtol=1e-15)


def test_an_abstract_base_is_hidden(family):
    """It is in no list, cannot be loaded, and need not be a device by itself."""
    family.write_text(VARIANTS.replace("vendor: V", "abstract: true"))
    assert variants(family) == ("A", "B")
    with pytest.raises(SpecError, match="abstract, choose a variant: A, B"):
        load_device(family)
    assert load_device(f"{family}#A").name == "Family (A)"
    assert validate(family).variants == ("A", "B")


def test_an_unknown_variant_is_refused_with_the_known_ones(family):
    """The message lists the variants and stands where they do."""
    with pytest.raises(SpecError, match=r":9:1: .*no variant 'AA', there are: A, B"):
        load_device(f"{family}#AA")


def test_validate_checks_base_and_variants_and_says_what_is_assumed(family):
    """Assumptions of all are listed once, with the kind that the keys say."""
    checked = validate(family)
    assert (checked.kind, checked.variants) == ("device", ("", "A", "B"))
    assert len(set(checked.assumptions)) == len(checked.assumptions)
    text = "gyro.bias_stability: correlation time not given, 300 s assumed"
    assert text in checked.assumptions  # of B alone


def test_a_mistake_of_the_base_is_reported_once(family):
    """It is in every variant, and one issue of the file."""
    family.write_text(VARIANTS.replace("axes: {z: 4 deg/h}", "axes: {z: 4 deg}"))
    with pytest.raises(SpecError) as caught:
        validate(family)
    assert len(caught.value.issues) == 1


def test_a_file_with_the_mark_in_its_name_is_no_variant(tmp_path):
    """'a#b.yaml' is that file where there is one."""
    path = put(tmp_path / "a#b.yaml", "name: x\ngyro: {}\n")
    assert load_device(path).name == "x"
