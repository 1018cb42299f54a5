"""Errors of both triads with a source at a value: by the problem, by pulses."""

from __future__ import annotations

import numpy as np
from builders import at_sources, paper_accelerometer, paper_gyro
from numpy.testing import assert_allclose

from budget.calibration import simulation
from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G, PPM

UNITS = np.array(
    [PPM] * 3
    + [ARCSEC] * 6
    + [DEG_PER_HOUR] * 3
    + [PPM] * 3
    + [ARCSEC] * 6
    + [MICRO_G] * 3
)
GYRO_SF, GYRO_ANGLE, GYRO_BIAS = slice(0, 3), slice(3, 9), slice(9, 12)
ACC_SF, ACC_ANGLE, ACC_BIAS = slice(12, 15), slice(15, 21), slice(21, 24)


def last_digit(printed):
    """One unit in the last printed digit."""
    mantissa, _, exponent = printed.lower().partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def assert_printed(actual, printed):
    """Compare with a number as it is printed."""
    assert_allclose(actual, float(printed), rtol=0, atol=last_digit(printed))


def triads(gyro=None, accelerometer=None):
    """Return both triads of the paper with more lines."""
    return paper_gyro(**(gyro or {})), paper_accelerometer(**(accelerometer or {}))


def errors(sensors, how, **values):
    """Return the 24 errors, in printed units, with sources at values, others at 0."""
    problem = calibration_problem(sensors, how)
    return problem.evaluate(at_sources(problem, **values)[:, None])[:, 0] / UNITS


def simulated(monkeypatch, sensors, how, name, values):
    """Return the 24 errors of a simulated run with one source at values."""
    monkeypatch.setattr(simulation, "_values", lambda *_: np.array(values, dtype=float))
    only = frozenset({name})
    return simulate(sensors, how, run=0, only=only) / UNITS
