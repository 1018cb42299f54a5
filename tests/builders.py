"""Sensors, procedures and comparisons that several test modules build on."""

from __future__ import annotations

from math import radians

import numpy as np

from budget.distributions import NORMAL
from budget.inputs.records import (
    AccelerometerProcedure,
    Device,
    ErrorLine,
    GyroProcedure,
    Origin,
    Procedure,
    Sensor,
)
from budget.model.sources import SOURCES
from budget.question import Question
from budget.units import (
    ARCSEC,
    DEG_PER_HOUR,
    DEGREE,
    MICRO_G,
    STANDARD_GRAVITY,
)

ROOT_HOUR = 60.0  # [sqrt(s)]
NOWHERE = Origin(file="", sha256="")

# The paper's figures by line: value [SI] and, of a stability, correlation time [s].
PAPER_GYRO = {
    "bias_repeatability": 0.05 * DEG_PER_HOUR,
    "bias_stability": 0.04 * DEG_PER_HOUR,
    "angle_random_walk": 0.005 * DEGREE / ROOT_HOUR,
    "scale_factor_repeatability": 50e-6,
    "mounting_repeatability": 2.0 * ARCSEC,
}
PAPER_ACCELEROMETER = {
    "bias_repeatability": 37.0 * MICRO_G,
    "bias_stability": 20.0 * MICRO_G,
    "sample_noise": 50.0 * MICRO_G,
    "scale_factor_repeatability": 37e-6,
    "mounting_repeatability": 2.0 * ARCSEC,
}


def line(name, u, *, tau=300.0, distribution=NORMAL):
    """Return one line of a data sheet; `u` is a number or one for each axis."""
    n = max(6 if name == "mounting_repeatability" else 3, np.size(u))
    n = next((len(s.axes) for s in SOURCES if s.name == name and s.shared), n)
    return ErrorLine(
        name=name,
        u=np.broadcast_to(np.asarray(u, dtype=float), (n,)).copy(),
        distributions=(distribution,) * n,
        correlation_time=np.full(3, tau) if name == "bias_stability" else None,
        printed="",
        unit="",
        si_per_unit=1.0,
    )


def sensor(kind, lines, *, bias=0.0, angle=0.0, tau=300.0):
    """Return a triad from `{name: u}` or ready lines; nominal values [SI]."""
    if isinstance(lines, dict):
        lines = [line(name, u, tau=tau) for name, u in lines.items()]
    return Sensor(
        kind=kind,
        device="test device",
        nominal_bias=np.broadcast_to(np.asarray(bias, dtype=float), (3,)).copy(),
        nominal_mounting_angle=np.broadcast_to(
            np.asarray(angle, dtype=float), (6,)
        ).copy(),
        lines=tuple(lines),
        not_given=(),
        expected_missing=(),
    )


def paper_gyro(**more):
    """Return the paper's gyro, with further or other lines [SI]."""
    return sensor(
        "gyro", {**PAPER_GYRO, **more}, bias=2.5 * DEG_PER_HOUR, angle=2.0 * ARCSEC
    )


def paper_accelerometer(**more):
    """Return the paper's accelerometer, with further or other lines [SI]."""
    return sensor(
        "accelerometer",
        {**PAPER_ACCELEROMETER, **more},
        bias=6e-3 * STANDARD_GRAVITY,
        angle=2.0 * ARCSEC,
    )


def procedure(
    *,
    latitude=34.2394,
    gravity=9.7966933092,
    sample_rate=100.0,
    formulas="corrected",
    rate=20.0,
    turns=1,
    dwell=300.0,
    pause=0.0,
    order=("z", "x", "y"),
    azimuths=(0.0, 180.0, 270.0, 450.0),
    station=(),
    environment=(),
    flip_axis="inner",
    **more,
):
    """Return a procedure, the paper's by default; latitude, azimuths, rate in deg."""
    return Procedure(
        name="test procedure",
        latitude=radians(latitude),
        gravity=gravity,
        sample_rate=sample_rate,
        formulas=formulas,
        gyro=GyroProcedure(
            rate=radians(rate),
            turns=turns,
            order=order,
            pause=pause,
            azimuths=tuple(radians(a) for a in azimuths),
            dwell=dwell,
        ),
        accelerometer=AccelerometerProcedure(
            dwell=dwell, pause=pause, flip_axis=flip_axis
        ),
        assumptions=(),
        origin=NOWHERE,
        station=station,
        environment=environment,
        **more,
    )


def asked(*sensors, **more):
    """Return the Question of a device of these triads; `more` as of Question.of."""
    found = {one.kind: one for one in sensors}
    made = Device(
        name="made",
        gyro=found.get("gyro"),
        accelerometer=found.get("accelerometer"),
        figures=(),
        assumptions=(),
        origin=NOWHERE,
    )
    return Question.of(made, **more)


def at_sources(problem, **values):
    """Return the input vector with whole sources set to values, the rest at 0.

    Keys are full names with '__' for the dot.
    """
    x = problem.mean.copy()
    for name, value in values.items():
        place = [g.name for g in problem.groups].index(name.replace("__", "."))
        x[problem.slices[place]] = value
    return x
