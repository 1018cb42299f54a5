"""The paper's own conditions: its device and procedure, a few sources at a time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.problem import calibration_problem
from budget.distributions import NORMAL
from budget.inputs import load_device, load_procedure
from budget.inputs.records import ErrorLine
from budget.methods.gum import propagate
from budget.names import Name
from budget.results import input_files
from budget.units import PPM
from zhao_2019.printed import load_paper

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Procedure, Sensor
    from budget.problem import Problem
    from budget.results import InputFile
    from zhao_2019.printed import Paper

DEVICE = "zhao-2019"  # the shipped files hold the paper's values as printed
HALF_ULP = 2.0**-53  # spacing of doubles just below 1 [1]
PLACES = {  # of the parameters among the twelve outputs of a triad
    "scale_factor": slice(0, 3),
    "mounting_angle": slice(3, 9),
    "bias": slice(9, 12),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Conditions:
    """What the paper prints, its device, and its procedure.

    The procedure has eq. (4) as printed or as corrected. To the sensors are added the
    lines that the paper varies in its figures, at their largest step: nonlinearity
    750 ppm, asymmetry 1250 ppm.
    """

    paper: Paper
    gyro: Sensor
    accelerometer: Sensor
    printed: Procedure
    corrected: Procedure
    inputs: tuple[InputFile, ...]

    @property
    def sensors(self) -> tuple[Sensor, Sensor]:
        """Both triads, gyro first."""
        return self.gyro, self.accelerometer

    def sensor(self, kind: str) -> Sensor:
        """Return the triad of that kind."""
        return self.gyro if kind == "gyro" else self.accelerometer


@dataclass(frozen=True, kw_only=True, eq=False)
class Expectation:
    """What the twelve relative errors of one run should be."""

    mean: Array  # [1], shape (12,)
    # Of one run; of the mean over n runs it is the n-th part, shape (12, 12) [1].
    covariance: Array
    resolution: Array  # rounding of the computation, shape (12,) [1]

    @property
    def u(self) -> Array:
        """Standard uncertainties of one run, shape (12,); 0 where only rounding."""
        u = np.sqrt(np.diag(self.covariance))
        return np.where(u > self.resolution, u, 0.0)


def load_conditions() -> Conditions:
    """Load what the paper prints, and the shipped device and procedure of it."""
    paper, device, procedure = load_paper(), load_device(DEVICE), load_procedure()
    if device.gyro is None or device.accelerometer is None:
        raise ValueError(f"the shipped device {DEVICE} lacks a sensor")
    nonlinearity = paper.farthest["scale_factor_nonlinearity"]
    return Conditions(
        paper=paper,
        gyro=with_lines(device.gyro, **paper.farthest),
        accelerometer=with_lines(
            device.accelerometer, scale_factor_nonlinearity=nonlinearity
        ),
        printed=replace(procedure, formulas="paper"),
        corrected=replace(procedure, formulas="corrected"),
        inputs=input_files((device,), procedure=procedure),
    )


def with_lines(sensor: Sensor, **values: float) -> Sensor:
    """Return the sensor with lines set, the same on all axes, normal [SI]."""
    kept = tuple(line for line in sensor.lines if line.name not in values)
    added = tuple(
        ErrorLine(
            name=name,
            u=np.full(3, value),
            distributions=(NORMAL,) * 3,
            printed=f"{value / PPM:g} ppm",
            unit="ppm",
            si_per_unit=PPM,
        )
        for name, value in values.items()
    )
    return replace(sensor, lines=(*kept, *added))


def without_nominal_angles(sensor: Sensor) -> Sensor:
    """Return the sensor with true mounting angles drawn about zero."""
    return replace(sensor, nominal_mounting_angle=np.zeros(6))


def value_of(sensor: Sensor, line: str) -> float:
    """Return a line of the data sheet, which all axes of the paper share [SI]."""
    found = sensor.line(line)
    if found is None:
        raise ValueError(f"the paper's {sensor.kind} lacks {line}")
    return float(found.u[0])


def nominal_size(sensor: Sensor) -> Array:
    """Return what errors are relative to, shape (12,): 1, nominal values [SI]."""
    return np.concatenate(
        [np.ones(3), sensor.nominal_mounting_angle, sensor.nominal_bias]
    )


def only_sources(sensor: Sensor, procedure: Procedure, *sources: Name) -> Problem:
    """Set up the calibration with these sources alone; '' is none at all."""
    # Lines that vary in no run would only slow the draws down.
    lines = tuple(
        line for line in sensor.lines if Name(line.name, owner=sensor.kind) in sources
    ) or tuple(line for line in sensor.lines if line.name == "bias_repeatability")
    only = frozenset(source for source in sources if source)
    return calibration_problem((replace(sensor, lines=lines),), procedure, only=only)


def expect(problem: Problem, size: Array) -> Expectation:
    """Propagate a Problem of one triad, its errors relative to `size` [SI]."""
    law = propagate(problem)
    resolution = np.array([output.resolution for output in problem.outputs])
    return Expectation(
        mean=law.mean / size,
        covariance=law.covariance / np.outer(size, size),
        resolution=resolution / np.abs(size),
    )
