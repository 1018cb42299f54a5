"""Quantisation and flicker: printed check values, and pulses against the law."""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from builders import GYRO_SF, UNITS, assert_printed, line, procedure, sensor
from numpy.testing import assert_allclose
from places import put
from scipy.integrate import quad

from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.errors import SpecError
from budget.inputs import load_device
from budget.methods.gum import propagate
from budget.model.noise import Flicker, Quantized
from budget.model.sources import processes
from budget.model.windows import Schedule, Window
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

DAY = 86400.0  # [s]
RUNS = 200


def schedule(*windows):
    """Return windows of (start, length)."""
    return Schedule(
        windows=tuple(Window(name="", start=s, length=n) for s, n in windows)
    )


def test_quantisation_of_a_pair_of_turns_is_as_printed():
    """Q 1 arcsec, adjacent turns: u(dk) = 0.272804 ppm, three edges in two windows."""
    gyro = sensor("gyro", {"quantization": 1.0 * ARCSEC})
    u = propagate(calibration_problem((gyro,), procedure())).standard_uncertainty
    for value in u[GYRO_SF] / UNITS[GYRO_SF]:
        assert_printed(value, "0.272804")
    apart = propagate(calibration_problem((gyro,), procedure(pause=1.0)))
    # Four edges: q^2/3 in place of q^2/2.
    assert_allclose(
        apart.standard_uncertainty[GYRO_SF] / u[GYRO_SF], np.sqrt(2.0 / 3.0)
    )


def test_windows_share_the_edge_that_they_meet_at():
    """Q^2/(6 L^2), -q^2/(12 L_a L_b) where they meet, else nothing."""
    C = Quantized(2.0).covariance(schedule((0.0, 4.0), (4.0, 5.0), (10.0, 2.0)))
    exact = [[4 / 96, -4 / 240, 0], [-4 / 240, 4 / 150, 0], [0, 0, 4 / 24]]
    assert_allclose(C, exact, rtol=1e-12, atol=1e-15)


def test_flicker_has_the_printed_covariance():
    """B 1, once a day, two windows of 18 s that meet."""
    C = Flicker(1.0, 1.0 / DAY).covariance(schedule((0.0, 18.0), (18.0, 18.0)))
    # 2.406829710515 and 1.965558646549 are printed; 40 digits give these.
    assert_allclose(C[0, 0], 2.40682971050998246, rtol=1e-14)
    assert_allclose(C[0, 1], 1.96555864655850762, rtol=1e-14)
    # The difference of a pair is 4 ln 2/pi whatever the length: more turns do not help.
    for length in (1.0, 18.0, 100.0):
        C = Flicker(1.0, 1e-9).covariance(schedule((0.0, length), (length, length)))
        assert_allclose(C[0, 0] + C[1, 1] - 2.0 * C[0, 1], 4.0 * np.log(2.0) / np.pi)


@pytest.mark.parametrize("x", [1e-4, 0.0131, 0.9, 30.0])
def test_flicker_has_the_formula_of_the_report(x):
    """B^2/pi ((x sin x + 1 - cos x)/x^2 - Ci(x)) of one window, x = 2 pi f_L L."""
    length = x * DAY / (2.0 * np.pi)
    C = Flicker(2.0, 1.0 / DAY).covariance(schedule((5.0, length)))
    with mpmath.workdps(30):
        y = mpmath.mpf(x)
        shape = (y * mpmath.sin(y) + 1 - mpmath.cos(y)) / y**2 - mpmath.ci(y)
        expected = float(4 / mpmath.pi * shape)

    assert_allclose(C, [[expected]], rtol=1e-9)


def test_flicker_is_the_integral_of_its_density():
    """The covariance of two windows is that of the spectrum, by quadrature."""
    low = 1e-3
    C = Flicker(1.5, low).covariance(schedule((0.0, 20.0), (70.0, 40.0)))

    def density(log_f):
        f = np.exp(log_f)
        both = np.sinc(f * 20.0) * np.sinc(f * 40.0)
        return 1.5**2 / np.pi * both * np.cos(2.0 * np.pi * f * 80.0)

    found, _ = quad(density, np.log(low), np.log(20.0), limit=2000)
    assert_allclose(C[0, 1], found, rtol=1e-5)


@pytest.mark.parametrize(
    ("kind", "name", "u"),
    [
        ("gyro", "quantization", 100.0 * ARCSEC),
        ("accelerometer", "quantization", 1e-3),
        ("gyro", "flicker", 0.1 * DEG_PER_HOUR),
        ("accelerometer", "flicker", 20.0 * MICRO_G),
    ],
)
def test_pulses_have_the_spread_of_the_law(kind, name, u):
    """12 standard uncertainties agree within the error of the runs; 1.5 u does not."""
    how = procedure(dwell=30.0, sample_rate=4.0, pause=0.0)
    one = sensor(kind, {name: u})
    law = propagate(calibration_problem((one,), how)).standard_uncertainty
    runs = np.array([simulate((one,), how, run=k) for k in range(RUNS)])
    off = np.std(runs, axis=0, ddof=1) / law - 1.0
    bound = 4.5 / np.sqrt(2.0 * (RUNS - 1))
    assert np.abs(off).max() < bound
    assert np.abs((off + 1.0) / 1.5 - 1.0).max() > bound


def read(tmp_path, *lines):
    """Return the gyro of a file with these lines."""
    path = put(
        tmp_path / "d.yaml",
        "name: x\ngyro:\n  errors:\n" + "".join(f"    {a}\n" for a in lines),
    )
    return load_device(path)


def test_a_flicker_says_its_low_cut_or_has_it_assumed(tmp_path):
    """Unset it is once a day and printed; the Allan minimum is 0.664 B."""
    one = read(tmp_path, "flicker: 0.1 deg/h")
    assert_allclose(one.gyro.lines[0].low_cut, 1.0 / DAY, rtol=1e-15)
    assert any("low cut not given" in text for text in one.assumptions)
    words = "definition: allan_minimum, low_cut: 0.001 Hz"
    one = read(tmp_path, f"flicker: {{value: 0.1 deg/h, {words}}}")
    (line,) = one.gyro.lines
    assert_allclose(line.low_cut, 1e-3, rtol=1e-15)
    assert_allclose(line.u, 0.1 * DEG_PER_HOUR / 0.664, rtol=1e-12)
    assert not any("low cut" in text for text in one.assumptions)


def test_the_bias_instability_is_read_once(tmp_path):
    """Flicker beside a stability is refused, unless it is said to be another noise."""
    stability = "bias_stability: 0.1 deg/h"
    with pytest.raises(SpecError, match=r"flicker.*would be counted twice"):
        read(tmp_path, stability, "flicker: 0.1 deg/h")
    more = "flicker: {value: 0.1 deg/h, adds_to: bias_stability}"
    assert len(read(tmp_path, stability, more).gyro.lines) == 2


def test_a_low_cut_of_a_line_reaches_the_law():
    """A lower cut is a larger bias, and hardly another scale factor."""
    found = []
    for low in (1e-6, 1e-3):
        flicker = line("flicker", 0.1 * DEG_PER_HOUR)
        one = sensor("gyro", [replace(flicker, low_cut=np.full(3, low))])
        law = propagate(calibration_problem((one,), procedure()))
        found.append(law.standard_uncertainty)
    ratio = found[0] / found[1]
    assert ratio[9:].min() > 1.5
    assert_allclose(ratio[:3], 1.0, rtol=1e-2)


@pytest.mark.parametrize("x", [0.9e4, 1.1e4, 1e6, 1e12])
def test_flicker_far_out_is_that_of_forty_digits(x):
    """G where its terms cancel: of windows years apart, or a low cut far too high."""
    low = 1.0 / 86400.0
    a = 2.0 * np.pi * low
    with mpmath.workdps(40):
        X = mpmath.mpf(a * (x / a))
        inner = X**2 / 2 * mpmath.ci(X) - X / 2 * mpmath.sin(X)
        exact = -(inner - (1 - mpmath.cos(X)) / 2) / (mpmath.pi * mpmath.mpf(a) ** 2)
    found = Flicker(1.0, low)._integral(np.array([x / a]))  # noqa: SLF001

    assert_allclose(found, float(exact), rtol=2e-12)


@pytest.mark.parametrize("a", [0.0, 0.3, 1.0 - 1e-9])
def test_a_short_recursion_has_every_bit_of_a_long_one(monkeypatch, a):
    """From one sample on: where the quicker of two ways begins moves no number."""
    z = np.random.default_rng(1).standard_normal((3, 5000))
    for number in (1, 2, 3, 100, 5000):
        row = z[:, :number]
        monkeypatch.setattr(processes, "LONG", number + 1)
        short = processes.recursion(a, row)
        monkeypatch.setattr(processes, "LONG", number)
        assert short.tobytes() == processes.recursion(a, row).tobytes()
        assert_allclose(short[:, -1], row @ a ** np.arange(number)[::-1], rtol=1e-9)
