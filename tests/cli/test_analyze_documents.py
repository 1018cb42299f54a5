"""The JSON and CSV documents of `budget analyze`: what other people's scripts read."""

from __future__ import annotations

import csv
import io
from hashlib import sha256
from math import fsum
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest
from command_line import analyze, call
from jsonschema import Draft202012Validator
from numpy.testing import assert_allclose
from places import put

AXES = ("x", "y", "z")
ANGLES = ("xy", "xz", "yx", "yz", "zx", "zy")
ORDER = [
    (sensor, parameter, axis, unit)
    for sensor, bias_unit in (("gyro", "deg/h"), ("accelerometer", "ug"))
    for parameter, axes, unit in (
        ("scale_factor", AXES, "ppm"),
        ("mounting_angle", ANGLES, "arcsec"),
        ("bias", AXES, bias_unit),
    )
    for axis in axes
]
GIVEN = {
    "gyro": (
        *("bias_repeatability", "bias_stability", "angle_random_walk"),
        *("scale_factor_repeatability", "mounting_repeatability"),
    ),
    "accelerometer": (
        *("bias_repeatability", "bias_stability", "sample_noise"),
        *("scale_factor_repeatability", "mounting_repeatability"),
    ),
}
NOT_GIVEN = [
    "gyro.rate_random_walk",
    "gyro.quantization",
    "gyro.scale_factor_nonlinearity",
    "gyro.scale_factor_asymmetry",
    "gyro.g_sensitivity",
    "gyro.scale_factor_quadratic",
    "gyro.scale_factor_cubic",
    "gyro.bias_over_temperature",
    "gyro.scale_factor_over_temperature",
    "gyro.ageing",
    "gyro.scale_factor_ageing",
    "gyro.vibration_rectification",
    "accelerometer.acceleration_random_walk",
    "accelerometer.quantization",
    "accelerometer.scale_factor_nonlinearity",
    "accelerometer.scale_factor_asymmetry",
    "accelerometer.scale_factor_quadratic",
    "accelerometer.scale_factor_cubic",
    "accelerometer.bias_over_temperature",
    "accelerometer.scale_factor_over_temperature",
    "accelerometer.ageing",
    "accelerometer.scale_factor_ageing",
    "accelerometer.vibration_rectification",
]
COLUMNS = (
    "sensor,parameter,axis,unit,source,standard_uncertainty,share,"
    "mean,interval_low,interval_high,interval_by,lower_bound"
)


def record(**properties):
    """Return the schema of a mapping in which all of these keys stand."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
    }


def pair(of):
    """Return the schema of two values of one kind."""
    return {"type": "array", "items": of, "minItems": 2, "maxItems": 2}


NUMBER = {"type": "number"}
SPREAD = {"type": "number", "minimum": 0}
COUNT = {"type": "integer", "minimum": 0}
TEXTS = {"type": "array", "items": {"type": "string", "minLength": 1}}
INPUT = record(
    name={"type": "string", "pattern": r"^[^/\\]+$"},
    sha256={"type": "string", "pattern": "^[0-9a-f]{64}$"},
)
CONTRACT = record(
    schema={"const": "budget/1"},
    command={"const": "analyze"},
    title={"type": "string"},
    inputs={"type": "object", "additionalProperties": INPUT},
    settings=record(
        method={"enum": ["gum", "monte-carlo", "simulation"]},
        trials={"anyOf": [{"type": "null"}, COUNT]},
        seed=COUNT,
        coverage={"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
        interval={"enum": ["symmetric", "shortest"]},
        reference={"enum": ["nominal", "as_tested", "next_turn_on"]},
        formulas={"enum": ["corrected", "paper"]},
        normals_per_trial={"anyOf": [COUNT, {"type": "null"}]},
        only=TEXTS,
    ),
    outputs={
        "type": "array",
        "items": record(
            sensor={"enum": ["gyro", "accelerometer"]},
            parameter={"enum": ["scale_factor", "mounting_angle", "bias"]},
            axis={"enum": [*AXES, *ANGLES]},
            unit={"enum": ["ppm", "arcsec", "deg/h", "ug"]},
            mean=NUMBER,
            standard_uncertainty=SPREAD,
            interval=pair(NUMBER),
            coverage_factor=SPREAD,
            degrees_of_freedom={"type": ["number", "null"]},
            contributions={
                "type": "array",
                "items": record(
                    source={"type": "string"},
                    standard_uncertainty=SPREAD,
                    share=NUMBER,
                    sobol_first={"type": ["number", "null"]},
                    sobol_total={"type": ["number", "null"]},
                ),
            },
            validation={
                "anyOf": [
                    {"type": "null"},
                    record(
                        trials=COUNT,
                        holds={"type": "boolean"},
                        difference_low=SPREAD,
                        difference_high=SPREAD,
                        tolerance=SPREAD,
                    ),
                ]
            },
        ),
    },
    quantities={
        "type": "object",
        "additionalProperties": record(
            printed={"type": "string", "minLength": 1},
            meaning={"type": "string"},
            unit={"type": "string", "minLength": 1},
            standard_uncertainty={"type": "array", "items": SPREAD, "minItems": 1},
            distribution={"type": "string", "minLength": 1},
            divisor={"type": ["number", "null"]},
            degrees_of_freedom={"type": ["number", "null"]},
        ),
    },
    covariance={"type": "array", "items": {"type": "array", "items": NUMBER}},
    not_given=TEXTS,
    assumptions=TEXTS,
    warnings=TEXTS,
)

CALLS = {
    "gum": (),
    "monte-carlo": ("--method", "monte-carlo", "--trials", "20000"),
    "simulation": ("--method", "simulation", "--trials", "30"),
    "next turn-on": ("--reference", "next_turn_on"),
    "as tested": ("--reference", "as_tested"),
    "two sources": ("--only", "gyro.bias_stability", "--only", "sample_noise"),
    "sobol": ("--sobol", "--samples", "64"),
}


@pytest.fixture(scope="module", params=CALLS.values(), ids=CALLS.keys())
def document(request):
    """One document for each of several ways to ask for it."""
    return analyze(*request.param)


def test_document_keeps_the_contract(document):
    """Every key of the contract is there, of its type and within its range."""
    Draft202012Validator.check_schema(CONTRACT)
    faults = [
        f"{fault.json_path}: {fault.message}"
        for fault in Draft202012Validator(CONTRACT).iter_errors(document)
    ]

    assert faults == []


def test_the_contract_can_be_broken(document):
    """Control: a missing key and a number as text are both found."""
    broken = {**document, "covariance": [["0.0"]]}
    del broken["not_given"]

    faults = list(Draft202012Validator(CONTRACT).iter_errors(broken))
    assert len(faults) == 2


def test_outputs_stand_in_their_order_and_unit(document):
    """24 outputs, gyro first: ppm, arcsec, deg/h; accelerometer: ppm, arcsec, ug."""
    assert [
        tuple(row[key] for key in ("sensor", "parameter", "axis", "unit"))
        for row in document["outputs"]
    ] == ORDER


def test_contributions_are_complete(document):
    """Each output lists every given source of its sensor once, then the interaction."""
    for row in document["outputs"]:
        sensor = row["sensor"]
        assert [part["source"] for part in row["contributions"]] == [
            *(f"{sensor}.{line}" for line in GIVEN[sensor]),
            "interaction",
        ]


def test_shares_are_of_the_whole(document):
    """Shares are variances over the law's total: they sum to 1, or are all 0."""
    for row in document["outputs"]:
        parts = row["contributions"]
        variances = [part["standard_uncertainty"] ** 2 for part in parts]
        total = fsum(variances)
        shares = [part["share"] for part in parts]
        assert_allclose(fsum(shares), 1.0 if total > 0.0 else 0.0, rtol=1e-12)
        for share, variance in zip(shares, variances, strict=True):
            assert_allclose(share * total, variance, rtol=1e-9)


def test_covariance_belongs_to_the_outputs(document):
    """Symmetric, 24 by 24, and its diagonal is the square of every u."""
    covariance = np.array(document["covariance"])
    u = np.array([row["standard_uncertainty"] for row in document["outputs"]])

    assert covariance.shape == (24, 24)
    # A rounding of the covariance is small against the two u that it belongs to.
    assert np.all(np.abs(covariance - covariance.T) <= 1e-12 * np.outer(u, u))
    assert_allclose(np.diag(covariance), u**2, rtol=1e-12)


def test_means_lie_within_their_intervals(document):
    """Every interval holds its mean."""
    for row in document["outputs"]:
        low, high = row["interval"]
        assert low <= row["mean"] <= high


def test_interval_of_the_law():
    """By the law the interval is mean +- k u, with k of the normal distribution."""
    k = NormalDist().inv_cdf(0.975)
    for row in analyze()["outputs"]:
        half_width = k * row["standard_uncertainty"]
        assert_allclose(
            row["interval"],
            [row["mean"] - half_width, row["mean"] + half_width],
            rtol=1e-9,
        )


def test_contributions_of_the_law_add_up():
    """By the law, the variances of an output's rows sum to its variance."""
    for row in analyze()["outputs"]:
        parts = [p["standard_uncertainty"] ** 2 for p in row["contributions"]]
        assert_allclose(fsum(parts), row["standard_uncertainty"] ** 2, rtol=1e-9)


def test_settings_of_a_plain_call():
    """What was not asked for has the default of the contract."""
    settings = analyze()["settings"]

    assert {
        "method": "gum",
        "trials": None,
        "seed": 0,
        "coverage": 0.95,
        "interval": "symmetric",
        "reference": "nominal",
        "formulas": "corrected",
        "normals_per_trial": 48,
        "only": [],
    }.items() <= settings.items()


def test_not_given_lines_of_the_paper_device():
    """Some model lines are not in the paper's data sheet, and each is named."""
    assert analyze()["not_given"] == NOT_GIVEN


def test_sobol_indices_only_when_asked_for(document):
    """Without `--sobol` both indices are null; with it they are numbers."""
    asked = document["settings"]["sobol_samples"] is not None
    for row in document["outputs"]:
        for part in row["contributions"][:-1]:
            for key in ("sobol_first", "sobol_total"):
                assert (part[key] is not None) == asked
        interaction = row["contributions"][-1]
        assert interaction["sobol_first"] is interaction["sobol_total"] is None


def test_inputs_are_named_by_content(tmp_path):
    """Input files stand with base name and SHA-256, without their folders."""
    text = "name: g\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n"
    device = put(tmp_path / "device.yaml", text)

    assert analyze(device)["inputs"]["device"] == {
        "name": "device.yaml",
        "sha256": sha256(text.encode()).hexdigest(),
    }


def test_document_names_no_place(tmp_path):
    """No folder, output name, host or number of workers gets into a document."""
    device = put(
        tmp_path / "device.yaml",
        "name: g\ngyro: {errors: {bias_repeatability: 1 deg/h}}\n",
    )
    file = tmp_path / "out.json"
    call("analyze", device, "--no-validate", "--workers", "2", "--json", file, code=0)

    text = file.read_text(encoding="utf-8")
    for word in (str(tmp_path), "out.json", str(Path.home()), "workers"):
        assert word not in text


def test_csv_rows_are_those_of_the_contract():
    """One row for each output and source, then `total`, which alone has an interval."""
    text = call("analyze", "--no-validate", "--csv", "-").out
    assert text.partition("\n")[0] == COLUMNS
    assert "\r" not in text

    rows = list(csv.DictReader(io.StringIO(text)))
    expected = [
        (*key, source)
        for key in ORDER
        for source in (
            *(f"{key[0]}.{line}" for line in GIVEN[key[0]]),
            *("interaction", "total"),
        )
    ]
    assert [tuple(row.values())[:5] for row in rows] == expected
    for row in rows:
        ends = [row["mean"], row["interval_low"], row["interval_high"]]
        assert all(ends) if row["source"] == "total" else not any(ends)


def test_csv_and_json_hold_the_same_numbers():
    """Both documents carry full precision: the same doubles, to the last bit."""
    rows = csv.DictReader(
        io.StringIO(call("analyze", "--no-validate", "--csv", "-").out)
    )
    of_csv = [
        tuple(float(row[key]) for key in ("mean", "interval_low", "interval_high"))
        for row in rows
        if row["source"] == "total"
    ]

    assert of_csv == [(row["mean"], *row["interval"]) for row in analyze()["outputs"]]
