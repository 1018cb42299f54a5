"""Devices, requirements and comparisons that the tests of `compare` build on."""

from __future__ import annotations

import pickle
from concurrent.futures import Executor, Future
from dataclasses import replace
from math import sqrt

from builders import (
    NOWHERE,
    PAPER_ACCELEROMETER,
    PAPER_GYRO,
    line,
    procedure,
    sensor,
)
from scipy.special import ndtri

from budget.distributions import UNIFORM
from budget.inputs.records import Device, Limit, Origin, Requirement
from budget.names import ANGLES, AXES, Name
from budget.studies.comparison.compare import compare
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G

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
