"""Sensors, devices, requirements and comparisons that several test modules build on."""

from __future__ import annotations

import pickle
from concurrent.futures import Executor, Future
from dataclasses import replace
from math import radians, sqrt

import numpy as np
from numpy.testing import assert_allclose
from scipy.special import ndtri

from budget.calibration import simulation
from budget.calibration.problem import calibration_problem
from budget.calibration.simulation import simulate
from budget.distributions import NORMAL, UNIFORM
from budget.inputs.records import (
    AccelerometerProcedure,
    Device,
    ErrorLine,
    GyroProcedure,
    Limit,
    Origin,
    Procedure,
    Requirement,
    Sensor,
)
from budget.model.sources import SOURCES
from budget.names import ANGLES, AXES, Name
from budget.question import Question
from budget.studies.comparison.compare import compare
from budget.units import (
    ARCSEC,
    DEG_PER_HOUR,
    DEGREE,
    MICRO_G,
    PPM,
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


K95 = float(ndtri(0.975))
SMALL = {"trials": 20_000, "max_trials": 20_000}  # for what no tail depends on
SIZES = {  # limits of one unit [SI]
    "gyro": {"scale_factor": 1e-4, "mounting_angle": 5 * ARCSEC, "bias": DEG_PER_HOUR},
    "accelerometer": {
        "scale_factor": 1e-4,
        "mounting_angle": 5 * ARCSEC,
        "bias": 100 * MICRO_G,
    },
}
PARAMETERS = (("scale_factor", AXES), ("mounting_angle", ANGLES), ("bias", AXES))
CONSTANTS = {  # independent errors: no process, one constant for each output
    "bias_repeatability": 0.3 * DEG_PER_HOUR,
    "scale_factor_repeatability": 4e-5,
    "mounting_repeatability": 2.0 * ARCSEC,
}


def device(name, *, gyro=None, accelerometer=None, missing=(), **texts):
    """Return a device from lines of either sensor; `missing` are expected lines."""
    built = {"gyro": None, "accelerometer": None}
    for kind, lines in (("gyro", gyro), ("accelerometer", accelerometer)):
        if lines is not None:
            built[kind] = replace(
                sensor(kind, lines),
                device=name,
                not_given=tuple(Name(line, owner=kind) for line in missing),
                expected_missing=tuple(Name(line, owner=kind) for line in missing),
            )
    return Device(
        name=name,
        figures=(),
        assumptions=(),
        origin=Origin(file=f"{name}.yaml", sha256="0" * 64),
        **built,
        **{"technology": "optical", **texts},
    )


def paper_device(name="paper", *, times=1.0, sensors=("gyro",), missing=(), **more):
    """Return the paper's device with every figure times a factor, some left out."""
    lines = {"gyro": PAPER_GYRO, "accelerometer": PAPER_ACCELEROMETER}
    noise = ("angle_random_walk", "sample_noise") if "noise" in missing else ()
    chosen = {
        kind: {
            line: times * u
            for line, u in lines[kind].items()
            if line not in (*missing, *noise)
        }
        for kind in sensors
    }
    return device(name, **chosen, missing=missing, **more)


def requirement(*, times=1.0, sensors=("gyro",), reference="nominal", caps=()):
    """Return a requirement with limits on all outputs of some sensors."""
    return Requirement(
        name="test requirement",
        coverage=0.95,
        reference=reference,
        limits=tuple(
            Limit(
                output=Name(quantity, owner=kind, axis=axis),
                limit=times * SIZES[kind][quantity],
                printed=f"{times:g} units",
            )
            for kind in sensors
            for quantity, axes in PARAMETERS
            for axis in axes
        ),
        caps=tuple(caps),
        assumptions=(),
        origin=NOWHERE,
    )


def compared(devices, wanted=None, **options):
    """Compare under the test procedure, by few trials where nothing else is asked."""
    if options.get("method") != "gum":
        options = {**SMALL, **options}
    procedures = options.pop("procedures", [procedure()])
    return compare(devices, wanted or requirement(), procedures, **options)


def by_name(comparison, name, sensor_kind="gyro"):
    """Return the verdict on one sensor of one device."""
    (found,) = (
        row
        for row in comparison.devices
        if (row.name, row.sensor) == (name, sensor_kind)
    )
    return found


def only_bias(name, u, **more):
    """Return a gyro whose only error is its bias repeatability [deg/h]."""
    return device(name, gyro={"bias_repeatability": u * DEG_PER_HOUR}, **more)


def bounded_bias(name, used, **more):
    """Return a gyro whose only error is a uniform bias, at a utilisation in truth.

    95 % of a uniform quantity of half-width a lie within 0.95 a, whereas the law says
    1.96 a/sqrt(3) = 1.13 a.
    """
    u = used * SIZES["gyro"]["bias"] / (0.95 * sqrt(3.0))
    lines = [line("bias_repeatability", u, distribution=UNIFORM)]
    return device(name, gyro=lines, **more)


def sent(something):
    """Return what arrives of something at another process."""
    return pickle.loads(pickle.dumps(something))  # noqa: S301 - written here


class Elsewhere(Executor):
    """Another process, as far as what is sent and what comes back goes: copies."""

    def submit(self, work, /, *tasks):
        """Do what has arrived, and send back what it returns."""
        future = Future()
        work, tasks = sent((work, tasks))
        future.set_result(sent(work(*tasks)))
        return future
