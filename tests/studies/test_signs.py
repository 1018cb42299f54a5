"""Coefficients of temperature of either sign have one size, wherever it is taken."""

from __future__ import annotations

import shlex

import pytest
from command_line import call
from keeping import catalogue
from numpy.testing import assert_allclose

from budget import analyze, load_device, load_procedure
from budget.missing.prediction import predict
from budget.names import Name
from budget.question import Question
from budget.studies.allocation.market import best_offered
from budget.studies.ceilings import ceilings
from budget.studies.input_quantities import sensitivities
from budget.studies.what_if import what_if
from budget.units import DEG_PER_HOUR

WARM = """
name: warm
technology: MEMS
gyro:
  errors:
    bias_repeatability: 5 deg/h
    bias_stability: 4 deg/h
    angle_random_walk: 0.05 deg/sqrt(h)
    scale_factor_repeatability: 500 ppm
    bias_temperature_coefficient: {sign}3 deg/h/degC
    scale_factor_temperature_coefficient: {{value: {sign}40 ppm/degC, meaning: max}}
"""
PLACE = """
station: {turn_angle: 1 arcsec}
environment: {temperature: {ramp: 5 degC/h}}
"""
REQUIREMENT = """
name: to be met
environment: {temperature: 10 degC}
limits:
  gyro: {scale_factor: 3000 ppm, bias: 90 deg/h}
"""
BENCH = """
name: bench
environment: {temperature: 10 degC}
mission: {latitude: 45 deg, longitude: 0 deg, height: 0 m, alignment: perfect,
  altitude: aided, segments: [{stand: 60 s}]}
"""
COEFFICIENT = Name("bias_temperature_coefficient", owner="gyro")
MISSING = Name("mounting_repeatability", owner="gyro")


@pytest.fixture
def files(tmp_path, monkeypatch):
    """Write both devices and what they are judged by into the folder at hand."""
    monkeypatch.chdir(tmp_path)
    texts = {
        "up.yaml": WARM.format(sign=""),
        "down.yaml": WARM.format(sign="-"),
        "place.yaml": PLACE,
        "requirement.yaml": REQUIREMENT,
        "bench.yaml": BENCH,
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return [load_device(name) for name in ("up.yaml", "down.yaml")]


def test_each_alone_leaves_the_same_u(files):
    """The law and the model behind the page give both one u, of every output."""
    plan = load_procedure("zhao-2019", environment="temperature 10 degC")
    first, second = (
        analyze(one, procedure=plan, reference="next_turn_on", validate=False)
        for one in files
    )
    for own, other in zip(first.outputs, second.outputs, strict=True):
        assert_allclose(other.standard_uncertainty, own.standard_uncertainty, rtol=1e-9)


def test_sizes_are_those_of_the_coefficients(files):
    """What-if, quantities of the budget, the market, ceilings and predictions."""
    cases = [Question.of(one, reference="next_turn_on") for one in files]
    found = [
        {
            "what-if": [source.u for source in what_if(case).sources],
            "u(x)": [one.u_input.max() for one in sensitivities(case).values()],
            "market": list(best_offered([device]).values()),
            "ceiling": [
                one.u for one in ceilings(device, [MISSING], catalogue()).values()
            ],
            "prediction": predict(device, [MISSING], catalogue()).median,
        }
        for case, device in zip(cases, files, strict=True)
    ]
    for name, own in found[0].items():
        assert min(own) >= 0.0, name
        assert_allclose(found[1][name], own, rtol=1e-12, err_msg=name)


def test_the_market_offers_the_size(files):
    """A sheet that prints -3 deg/h/degC offers 3."""
    offers = [
        best_offered([device], device.sensors)[COEFFICIENT] / DEG_PER_HOUR
        for device in files
    ]

    assert_allclose(offers, [3.0, 3.0], rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        "analyze DEVICE --no-validate --environment 'temperature 10 degC'",
        "analyze DEVICE --method simulation --trials 100 --station place.yaml",
        "analyze DEVICE --requirement requirement.yaml --missing worst",
        "compare DEVICE --requirement requirement.yaml --method gum --missing predict",
        "allocate DEVICE --requirement requirement.yaml --no-validate",
        "mission DEVICE ms1000#MS1005 --mission bench.yaml --no-validate",
        "station DEVICE --requirement requirement.yaml --station place.yaml",
        "export DEVICE ms1000#MS1005 --to kalibr --rate 200 --missing predict",
        "validate DEVICE",
    ],
)
def test_every_command_takes_either(files, words):
    """The exit code is that of the coefficient of the other sign."""
    assert files
    first, second = (
        call(*(name if word == "DEVICE" else word for word in shlex.split(words)))
        for name in ("up.yaml", "down.yaml")
    )
    assert first.code == second.code, second.err
    assert first.code in {0, 1}, first.err
