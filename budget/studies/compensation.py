"""Compensation matrices: what turns the readings of a triad into its input.

The reading n of the axes (counts a second), over their scale factors K, is M u + b with
M = I + dT (Zhao 2019, eq. (1)): row i is what axis i shows of an input u in body axes,
the bias b is in sensor axes. So

    u = T (n/K - b) = T n/K - T b ,    T = M^-1 ,

with the bias taken off before T, or T b, which is in body axes, after it. Both forms
are a map of the parameters that a calibration finds, one more behind its Problem: their
uncertainties are joint, to second order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import estimated
from budget.methods.gum import propagate
from budget.model.response import inverse, tilt_matrix
from budget.names import AXES, Name, by_group, parameters_of
from budget.results import Compensation
from budget.sentences import sentence

if TYPE_CHECKING:
    from budget.arrays import Array
    from budget.inputs.records import Sensor
    from budget.problem import Output, Problem
    from budget.question import Question


@dataclass(frozen=True, kw_only=True, eq=False)
class Inversion:
    """T, b and T b of one triad, of the errors of its parameters.

    Attributes
    ----------
    angle, bias : ndarray, shape (6,), (3,)
        Nominal values, that the errors are added to [rad, unit of the input].
    angles, biases : tuple of int
        Rows of their errors.
    """

    angle: Array
    bias: Array
    angles: tuple[int, ...]
    biases: tuple[int, ...]

    def __call__(self, y: Array) -> Array:
        """Return T row by row, b, T b, shape (15, trials), of errors (n, trials)."""
        dT = tilt_matrix(y[list(self.angles)] + self.angle[:, None])
        b = y[list(self.biases)] + self.bias[:, None]
        T = inverse(np.eye(3)[..., None] + dT)
        return np.concatenate([*T, b, (T * b).sum(axis=1)])


def inversion_of(sensor: Sensor, parameters: Problem) -> Inversion:
    """Return the map of one triad, whose angles and biases a Problem has."""
    names = [output.name for output in parameters.outputs]

    def rows(quantity: str) -> tuple[int, ...]:
        wanted = [n for n in parameters_of(sensor.kind) if n.quantity == quantity]
        return tuple(names.index(name) for name in wanted)

    return Inversion(
        angle=sensor.nominal_mounting_angle,
        bias=sensor.nominal_bias,
        angles=rows("mounting_angle"),
        biases=rows("bias"),
    )


def outputs_of(sensor: Sensor, parameters: Problem) -> tuple[Output, ...]:
    """Return what that map returns; T is as sure as an angle, T b as b."""
    like = {output.name.quantity: output for output in parameters.outputs}
    element = replace(like["mounting_angle"], unit="1", si_per_unit=1.0)
    return tuple(
        replace(like_it, name=Name(quantity, owner=sensor.kind, axis=axis))
        for quantity, like_it, axes in (
            ("T", element, [row + column for row in AXES for column in AXES]),
            ("bias_sensor", like["bias"], AXES),
            ("bias_body", like["bias"], AXES),
        )
        for axis in axes
    )


def compensations(
    question: Question,
) -> tuple[dict[str, Compensation], tuple[str, ...]]:
    """Return the matrices of every triad, and of which there are none, in words."""
    found: dict[str, Compensation] = {}
    absent = []
    for sensor in question.sensors:
        kind = sensor.kind
        known = estimated(kind, question.procedure)
        needed = [n for n in parameters_of(kind) if n.quantity != "scale_factor"]
        if held := [name for name in needed if name not in known]:
            absent.append(
                sentence(
                    "cautions.no_matrices",
                    sensor=kind,
                    procedure=question.procedure.name,
                    parameters=by_group(held),
                )
            )
            continue
        parameters = replace(question.alone(kind), requirement=None).problem
        invert = inversion_of(sensor, parameters)
        problem = parameters.then(invert, outputs_of(sensor, parameters))
        of_bias, of_angles = (
            tuple(dict.fromkeys(line for name in own for line in question.lacks[name]))
            for own in (needed, [n for n in needed if n.quantity == "mounting_angle"])
        )
        found[kind] = Compensation(
            sensor=kind,
            outputs=problem.outputs,
            value=invert(np.zeros((len(known), 1)))[:, 0],
            covariance=propagate(problem).covariance,
            lacks=tuple(
                of_angles if one.name.quantity == "T" else of_bias
                for one in problem.outputs
            ),
        )
    return found, tuple(absent)
