"""Allan deviations of data sheets: by hand, against a simulation, and what they say."""

from __future__ import annotations

from math import log, pi, sqrt

import numpy as np
import pytest
from figure_text import crossed_texts, cut_texts, texts
from numpy.testing import assert_allclose
from reading import assert_says

from budget.inputs import load_device, load_procedure, uncalibrated
from budget.model.noise import Flicker, GaussMarkov, Quantized, RandomWalk, White
from budget.names import Name
from budget.report.figures.allan import (
    SIGMA,
    Allan,
    allan_plot,
    allan_variance,
)
from budget.units import DEG_PER_HOUR, DEGREE

TIMES = (0.1, 1.0, 18.0, 300.0, 1e4)


def of(name, sensor=0, procedure=None):
    """Return the Allan deviations of a triad that ships."""
    return Allan.of(load_device(name).sensors[sensor], load_procedure(procedure))


@pytest.mark.parametrize(
    ("process", "variance"),
    [
        (White(0.3), lambda tau: 0.3**2 / tau),
        (RandomWalk(0.2), lambda tau: 0.2**2 * tau / 3.0),
        (Quantized(0.6), lambda tau: 3.0 * (0.6**2 / 12.0) / tau**2),
        (Flicker(0.5, 1e-9), lambda tau: 0.5**2 * 2.0 / pi * log(2.0) + 0.0 * tau),
    ],
)
def test_each_law_is_that_of_ieee_952(process, variance):
    """N^2/tau, K^2 tau/3, 3 Q^2/tau^2, and (2 ln 2/pi) B^2 far above the low cut."""
    expected = [variance(tau) for tau in TIMES]
    assert_allclose(allan_variance(process, TIMES), expected, rtol=2e-3)


def test_a_window_of_the_papers_unit_by_hand():
    """0.005 deg/sqrt(h) over 300 s is 0.005 sqrt(3600/300) = 0.0173 deg/h."""
    found = of("zhao-2019")
    N = next(
        one
        for one in load_device("zhao-2019").sensors[0].lines
        if one.name == "angle_random_walk"
    ).u[0]
    at = np.interp(
        log(300.0),
        np.log(found.times),
        np.log(found.deviations[Name("angle_random_walk", owner="gyro")]),
    )
    assert pytest.approx(0.005 * DEGREE / 60.0) == N
    assert np.exp(at) / DEG_PER_HOUR == pytest.approx(0.005 * sqrt(12.0), rel=1e-3)


def test_a_simulated_record_has_that_deviation():
    """White noise and a Gauss-Markov process, sampled and averaged, not by the model.

    Over 20 000 s at 10 Hz; by the overlapping estimate of IEEE 952.
    """
    rng, dt, n = np.random.default_rng(7), 0.1, 200_000
    N, sigma, tau_c = 0.02, 0.01, 5.0
    a = np.exp(-dt / tau_c)
    steps = sigma * sqrt(1.0 - a * a) * rng.standard_normal(n)
    x = np.empty(n)
    state = sigma * rng.standard_normal()
    for k, step in enumerate(steps):
        x[k] = state = a * state + step
    theta = np.cumsum(x + N / sqrt(dt) * rng.standard_normal(n)) * dt
    for m in (10, 50, 200):
        tau = m * dt
        second = theta[2 * m :] - 2.0 * theta[m:-m] + theta[: -2 * m]
        estimate = np.mean(second**2) / (2.0 * tau**2)
        model = sum(
            allan_variance(one, [tau])[0]
            for one in (White(N), GaussMarkov(sigma, tau_c))
        )
        assert_allclose(estimate, model, rtol=0.1)


def test_the_marks_are_the_windows_of_the_calibration():
    """The paper turns for 18 s and stands for 5 min; its maker has no windows."""
    found = of("zhao-2019")
    assert [(one.length, one.windows) for one in found.marks] == [(300.0, 4), (18.0, 6)]
    for one in found.marks:
        at = np.interp(log(one.length), np.log(found.times), found.whole)
        assert_allclose(one.sigma, at, rtol=0.02)
    sensor = load_device("zhao-2019").sensors[0]
    assert Allan.of(sensor, uncalibrated("factory")).marks == ()


def test_of_white_noise_alone_it_is_the_noise_of_an_average():
    """What is slower than a window shifts both averages alike, and stays in one."""
    (long, short), gyro = of("zhao-2019").marks, Name("angle_random_walk", owner="gyro")
    for one in (long, short):
        white = 0.005 * DEGREE / 60.0 / sqrt(one.length)
        assert one.parts[gyro] == pytest.approx(white**2, rel=1e-6)
        (slow,) = (v for name, v in one.parts.items() if name != gyro)
        assert one.average == pytest.approx(sqrt(white**2 + slow))
        assert white < one.sigma < one.average


def test_it_says_what_is_left_in_an_average():
    """Title, words, table and the drawn marks have the same numbers."""
    picture = allan_plot(of("zhao-2019")).picture
    assert_says(picture.title, "over 5 min has u = 0.038 deg/h", "bias stability")
    assert_says(picture.title, "Allan deviation 0.029 deg/h", "variance")
    said = "4 windows of 5 min: Allan deviation 0.029, u of an average 0.038"
    assert_says(picture.alt, said, "angle random walk")
    assert len(picture.data.groups[0].rows) == 7
    found = texts(allan_plot(of("zhao-2019")).figure)
    assert {"5 min", f"{SIGMA} 0.029", "u 0.038", "18 s", "all together"} <= set(found)
    assert any("log scale" in text for text in found)


@pytest.mark.parametrize(
    ("name", "procedure"),
    [
        ("zhao-2019", None),
        ("hg4930#C", "twenty-four-positions"),
        ("stim300#5g", "hand-turns"),
        ("ltys11cj1x", None),
        ("adis16448", "norm-icosahedron"),
    ],
)
def test_its_texts_stand_apart(name, procedure):
    """None is cut, and none lies on another one."""
    for sensor in load_device(name).sensors:
        found = Allan.of(sensor, load_procedure(procedure))
        if found is not None:
            figure = allan_plot(found).figure
            assert cut_texts(figure) == []
            assert [pair for pair in crossed_texts(figure) if pair[1] != "line"] == []


def test_a_sheet_without_noise_has_no_such_figure():
    """Of a triad of which no line is noise there is none."""
    from dataclasses import replace

    sensor = load_device("zhao-2019").sensors[0]
    assert Allan.of(replace(sensor, lines=()), load_procedure(None)) is None
