"""How old a calibration may be before a limit is reached."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reading import lines

from budget import analyze, load_device, load_procedure, load_requirement
from budget.report.allocation import allocation_section
from budget.studies.allocation.allocate import allocate
from budget.units import DAY, MICRO_G, YEAR

DEVICE = """
format: budget-device/1
name: aged
accelerometer:
  errors:
    bias_repeatability: 10 ug
    bias_stability: 1e-3 ug
    velocity_random_walk: 1e-3 ug/sqrt(Hz)
    scale_factor_repeatability: 1e-3 ppm
    mounting_repeatability: 1e-3 arcsec
    scale_factor_ageing: {{value: 1e-6 ppm, horizon: 1 year, law: drift}}
    ageing: {{value: {} ug, horizon: 1 year, law: {}}}
"""
REQUIREMENT = """
format: budget-requirement/1
name: bias
reference: {}
limits: {{accelerometer: {{bias: {} ug}}}}
"""
K = 1.959963984540054  # 95 % of a normal distribution


@pytest.fixture
def found(tmp_path):
    """Return a function that allocates for accelerometers that age, under a limit."""

    def of(ageing, limit, *, law="drift", reference="next_turn_on"):
        device, limits = tmp_path / "device.yaml", tmp_path / "requirement.yaml"
        device.write_text(DEVICE.format(ageing, law), encoding="utf-8")
        limits.write_text(REQUIREMENT.format(reference, limit), encoding="utf-8")
        return device, limits

    return of


def allocated(device, limits):
    """Return an allocation."""
    return allocate(
        load_device(device),
        requirement=load_requirement(limits),
        catalogue=(),
        validate=False,
    )


def recalibrations(device, limits):
    """Return when to calibrate again."""
    return allocated(device, limits).recalibrations


def said_of(allocation):
    """Return what its section says of the first of them."""
    texts = lines(allocation_section(allocation))
    return texts[texts.index("When to calibrate again") + 1]


@pytest.mark.parametrize(("law", "power"), [("drift", 1.0), ("random_walk", 0.5)])
def test_the_limit_is_reached_where_the_closed_form_says(found, law, power):
    """U(A)^2 = 2 u_r^2 + (v (A/H)^p)^2: two turn-ons and the ageing are all."""
    one, *_ = recalibrations(*found(100, 150, law=law))
    u = 150.0 / K
    age = YEAR * (np.sqrt(u**2 - 2.0 * 10.0**2) / 100.0) ** (1.0 / power)
    # The law counts products of lines too, 1e-5 of the variance.
    assert_allclose(one.age, age, rtol=1e-4)


def test_the_budget_at_that_age_is_at_its_limit(found):
    """Analysis at the age that is found gives the limit as U: one answer."""
    device, limits = found(100, 150)
    one, *_ = recalibrations(device, limits)
    budget = analyze(
        load_device(device),
        procedure=load_procedure(age=f"{one.age!r} s"),
        reference="next_turn_on",
        validate=False,
    )
    ends = [
        row.interval[1] for row in budget.outputs if row.output.name.quantity == "bias"
    ]
    assert_allclose(max(ends) / MICRO_G, 150.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("ageing", "limit", "words"),
    [
        (1000, 28, "a limit is exceeded within one day"),
        (1e-3, 150, "no limit is reached within 30 years"),
        (100, 150, "a limit is reached after 9 months, at a coverage of 95 %"),
    ],
)
def test_it_is_said_in_words(found, ageing, limit, words):
    """What is beyond what was tried is said to be so; a time is rounded down."""
    allocation = allocated(*found(ageing, limit))
    one, *_ = allocation.recalibrations
    assert words in said_of(allocation)
    assert (one.age is None) is ("after 9" not in words)
    assert one.age is None or DAY < one.age < 30.0 * YEAR


def test_what_is_not_given_makes_it_sooner(found):
    """An age is an upper bound then, and none that is not reached is promised."""
    for ageing, words in (
        (100, "after 9 months at the latest"),
        (1e-3, "not assessed, as specifications are not given"),
    ):
        device, limits = found(ageing, 150)
        text = device.read_text(encoding="utf-8")
        kept = [line for line in text.splitlines() if "scale_factor" not in line]
        device.write_text("\n".join(kept), encoding="utf-8")
        said = said_of(allocated(device, limits))
        assert words in said
        assert "scale factor ageing" in said


def test_nothing_is_said_where_age_counts_nothing(found):
    """Counted from the test's own turn-on nothing ages."""
    assert recalibrations(*found(100, 150, reference="as_tested")) == ()
