"""Errors of a mission with predicted lines are over what these lines may be."""

from __future__ import annotations

import json
from dataclasses import replace
from math import erf, sqrt

import numpy as np
import pytest
from keeping import catalogue
from numpy.testing import assert_allclose
from places import put
from reading import on_terminal
from scipy.integrate import quad
from scipy.stats import t

from budget import analyze, load_device, load_requirement, uncalibrated
from budget.methods.radius import probability_within
from budget.missing import line_of
from budget.missing.prediction import Prediction, stand_in
from budget.names import MISSION, Name
from budget.question import question_of
from budget.report.analysis.mission import mission_answer
from budget.report.document import to_json
from budget.studies.doubt import ONE_SIGMA, Mixture, _within, squared_lines
from budget.studies.mission import bought, curve

VN100 = load_device("vn-100")
TIMES = (60.0, 600.0)
BIAS = Name("bias_repeatability", owner="gyro")
DF = 9.0
TRIALS = 400_000
# Points of low discrepancy are better than the root of their number, 32,768.
POINTS_OFF = 0.3 / sqrt(32768)


def on_the_bench(device=VN100, *, missing="predict", **more):
    """Return the budget of a unit as its maker calibrated it, on a bench."""
    return analyze(
        device,
        mission="bench",
        at=TIMES,
        procedure=uncalibrated("factory"),
        missing=missing,
        catalogue=catalogue(),
        validate=False,
        **more,
    )


def horizontal(budget, time, quantity="position"):
    """Return an output of the plane."""
    name = Name(quantity, owner=MISSION, axis="horizontal", time=time)
    return budget.output(name)


@pytest.fixture(scope="module")
def predicted():
    """Return the budget over what the lines may be."""
    return on_the_bench()


@pytest.fixture(scope="module")
def at_medians(predicted):
    """Return what the law says of the device with the lines at their medians."""
    return question_of(predicted).law


def alone(scale):
    """Return the mixture of one line, of all there is."""
    prediction = Prediction(
        names=(BIAS,),
        location=np.zeros(1),
        scale=np.array([[scale**2]]),
        df=DF,
        devices=((),),
        designs=(3,),
    )
    return Mixture(sources=(BIAS,), squared=squared_lines(prediction, [0]))


@pytest.mark.parametrize("coverage", [ONE_SIGMA, 0.95])
@pytest.mark.parametrize("scale", [0.1, 1.0, 2.0])
def test_one_line_alone_by_quadrature(scale, coverage):
    """The integral of erf, and of 1 - exp, over the density of the logarithm."""
    axis, circle = np.array([[4.0], [0.0], [0.0]]), np.array([[4.0], [4.0], [0.0]])
    inside = {
        "axis": lambda z: erf(z / sqrt(2.0)),
        "circle": lambda z: 1.0 - np.exp(-0.5 * z * z),
    }
    for shape, each in (("axis", axis), ("circle", circle)):
        (found,) = alone(scale).radius(coverage, (BIAS,), each[None])
        p, _ = quad(
            lambda x, f=inside[shape], r=found: (
                f(r / (2.0 * np.exp(scale * x))) * t.pdf(x, DF)
            ),
            -60.0,
            60.0,
            points=(0.0,),
            limit=400,
        )
        assert abs(p - coverage) < POINTS_OFF


def test_probabilities_in_a_plane_are_those_of_the_radius():
    """The integral over angles against the one of budget.methods.radius."""
    rng = np.random.default_rng(4)
    larger = np.exp(rng.normal(0.0, 2.0, 200))
    variances = np.stack([larger, larger * rng.uniform(0.001, 1.0, 200)])
    for radius in (0.1, 1.0, 5.0):
        expected = probability_within(np.full(200, radius), variances).mean()
        inside, slope = _within(radius, variances)
        steps = [_within(radius * (1.0 + h), variances)[0] for h in (1e-4, -1e-4)]

        assert_allclose(inside, expected, rtol=1e-5)
        assert_allclose(slope, (steps[0] - steps[1]) / 2e-4, rtol=1e-4)


@pytest.mark.parametrize("time", TIMES)
def test_circles_hold_as_many_as_they_say(predicted, at_medians, time):
    """Lines drawn at random, then errors of their covariance: 50 and 95 % within."""
    rng = np.random.default_rng(int(time))
    question = question_of(predicted)
    prediction = question.filled.prediction
    n = len(prediction.names)
    normal = rng.standard_normal((TRIALS, n)) @ np.linalg.cholesky(prediction.scale).T
    chi = np.sqrt(rng.chisquare(prediction.df, TRIALS) / prediction.df)
    squared = np.exp(2.0 * normal / chi[:, None])

    found = curve(question, [time])
    plane = found.covariance[:, 0, :2, :2]  # position north and east
    lines = [Name(stand_in(x).name, owner=x.owner) for x in prediction.names]
    parts = plane[[found.sources.index(line) for line in lines]]
    V = plane.sum(axis=0) - parts.sum(axis=0) + np.tensordot(squared, parts, axes=1)
    z = rng.standard_normal((TRIALS, 2))
    root = np.sqrt(V[:, 0, 0])
    slant = V[:, 0, 1] / root
    north = root * z[:, 0]
    east = slant * z[:, 0] + np.sqrt(V[:, 1, 1] - slant**2) * z[:, 1]

    row = horizontal(predicted, time)
    for p, radius in ((0.5, row.radii.cep), (0.95, row.radii.r95)):
        inside = np.mean(np.hypot(north, east) < radius)
        sigma = sqrt(p * (1.0 - p) / TRIALS)
        assert abs(inside - p) < 3.0 * sigma + POINTS_OFF
    # Control: R95 at the medians of the lines holds too few; the circle of half of them
    # may lie near, as half of the lines are beyond their medians.
    k = [o.name for o in at_medians.outputs].index(row.output.name)
    usual = at_medians.interval(0.95)[k, 1]
    assert np.mean(np.hypot(north, east) < usual) < 0.95 - 0.2
    (axis,) = [
        each
        for each in predicted.outputs
        if each.output.name == Name("position", owner=MISSION, axis="north", time=time)
    ]
    within = np.mean(np.abs(north) < axis.standard_uncertainty)
    assert abs(within - ONE_SIGMA) < 3.0 * sqrt(0.22 / TRIALS) + POINTS_OFF


def test_covariances_of_drawn_lines_are_those_of_a_device_that_has_them(predicted):
    """V_0 + sum C_m (s_m/median)^2 against the law of the device with lines s."""
    question = question_of(predicted)
    prediction = question.filled.prediction
    factors = np.linspace(0.3, 3.0, len(prediction.names))
    device = VN100
    for name, median, factor in zip(
        prediction.names, prediction.median, factors, strict=True
    ):
        sensor = getattr(device, name.owner)
        line = line_of(stand_in(name), name.owner, float(factor * median))
        device = replace(
            device, **{name.owner: sensor.with_lines((*sensor.lines, line))}
        )
    given = on_the_bench(device, missing="refuse")
    found = curve(question, TIMES)
    lines = [Name(stand_in(x).name, owner=x.owner) for x in prediction.names]
    places = [found.sources.index(line) for line in lines]
    parts = found.horizontal_variance()
    drms_2 = parts.sum(axis=0) + (factors**2 - 1.0) @ parts[places]

    for k, time in enumerate(TIMES):
        u = horizontal(given, time).standard_uncertainty
        # Products of two lines are as they are at the medians.
        assert_allclose(np.sqrt(drms_2[k]), u, rtol=1e-4)


def test_what_no_predicted_line_reaches_is_the_law():
    """A mixture of other sources leaves the radii of a source as they are."""
    other = Name("angle_random_walk", owner="gyro")
    each = np.array([[[4.0, 1.0], [1.0, 0.0], [0.5, 0.0]]])
    mixed = alone(1.0).radius(0.95, (other,), each)

    assert_allclose(mixed[1], 1.959963984540054, rtol=1e-12)
    assert mixed[0] > mixed[1]


def test_numbers_beside_each_other_are_of_one_law(predicted):
    """Intervals, radii, DRMS, covariance and curve; in JSON too, and it says so."""
    question = question_of(predicted)
    found = curve(question, TIMES)
    document = json.loads(to_json(predicted))
    for k, time in enumerate(TIMES):
        for quantity in ("position", "velocity"):
            row = horizontal(predicted, time, quantity)
            legs = [
                predicted.output(Name(quantity, owner=MISSION, axis=axis, time=time))
                for axis in ("north", "east")
            ]
            drms = np.hypot(*(leg.standard_uncertainty for leg in legs))
            assert_allclose(row.standard_uncertainty, drms, rtol=1e-12)
            assert_allclose(row.largest_error, row.radii.r95, rtol=1e-9)
            assert_allclose(found.radius(0.5, quantity)[k], row.radii.cep, rtol=1e-9)
            assert_allclose(found.radius(0.95, quantity)[k], row.radii.r95, rtol=1e-9)
            assert_allclose(found.drms(quantity)[k], drms, rtol=1e-9)
            assert {leg.interval_by for leg in (row, *legs)} == {"prediction"}
            (written,) = [
                one
                for one in document["outputs"]
                if (one["parameter"], one["axis"], one["time"])
                == (quantity, "horizontal", time)
            ]
            for key, value in (
                ("cep", row.radii.cep),
                ("r95", row.radii.r95),
                ("drms", drms),
            ):
                assert_allclose(written[key], value, rtol=1e-12)
    u = [row.standard_uncertainty for row in predicted.outputs]
    assert_allclose(np.sqrt(np.diag(predicted.covariance)), u, rtol=1e-12)
    assert any("predictive mixture" in text for text in document["assumptions"])
    assert "predictive mixture" in " ".join(
        on_terminal(mission_answer(predicted)).split()
    )
    (_, maker) = bought(question)
    assert_allclose(
        maker.cep, [horizontal(predicted, time).radii.cep for time in TIMES], rtol=1e-9
    )


@pytest.mark.parametrize(
    ("missing", "by"),
    [("refuse", "law"), ("worst", "monte-carlo"), ("typical", "law")],
)
def test_other_modes_are_of_one_unit(missing, by):
    """Radii are those of one normal law, and nobody speaks of a mixture.

    The worst line is another maker's bound, of uniform shape: its circle by trials is
    smaller than the law's.
    """
    found = on_the_bench(missing=missing)
    row = horizontal(found, 60.0)
    law = question_of(found).law
    k = [output.name for output in law.outputs].index(row.output.name)

    assert row.interval_by == by
    ratio = row.radii.r95 / law.interval(0.95)[k, 1]
    expected, rtol = {"law": (1.0, 1e-12), "monte-carlo": (0.85, 0.02)}[by]
    assert_allclose(ratio, expected, rtol=rtol)
    assert not any("mixture" in text for text in found.assumptions)


@pytest.mark.slow
def test_a_requirement_changes_no_radius(predicted, tmp_path):
    """What is judged at the medians does not stand in the table of errors."""
    path = put(
        tmp_path / "wide.yaml",
        "name: wide\nreference: next_turn_on\nlimits:\n  mission:\n    position:\n"
        "      - {horizontal: 1 km, at: 60 s, probability: 50 %}\n"
        "      - {horizontal: 9000 km, at: 600 s}\n",
    )
    limited = on_the_bench(requirement=load_requirement(path))
    assert limited.assessment is not None
    for time in TIMES:
        row, same = (horizontal(one, time) for one in (limited, predicted))
        assert row.interval_by == "prediction"
        assert_allclose(row.radii.r95, same.radii.r95, rtol=1e-12)


def test_the_vn100_on_a_bench(predicted, at_medians):
    """After a minute R95 is 0.75 km; the medians of its lines would say 101 m."""
    row = horizontal(predicted, 60.0)
    k = [output.name for output in at_medians.outputs].index(row.output.name)

    assert_allclose(row.radii.r95, 748.0, rtol=0.05)
    assert_allclose(row.radii.cep, 69.5, rtol=0.05)
    assert_allclose(at_medians.interval(0.95)[k, 1], 101.0, rtol=0.05)
