"""Derived outputs: rotations, non-orthogonalities and misalignment of the triads.

Row i of M = I + dT (Zhao 2019, eq. (1)) is what axis i shows of an input in body axes,
to first order in the mounting angles the unit vector m_i of its sensitive axis. The two
parts of dT are two properties of a triad:

- antisymmetric, the rotation theta of the triad from the body axes, by the right-hand
  rule: m_i = e_i + theta x e_i, so theta_x = (M_yz - M_zy)/2 = (yx + zx)/2, and
  likewise theta_y = (xy + zy)/2, theta_z = (xz + yz)/2;
- symmetric, the non-orthogonality of two axes, the cosine of the angle between them:
  m_i . m_j = M_ij + M_ji, so xy: xz - yz, xz: zy - xy, yz: yx - zx. Above 0 the axes
  are less than 90 deg apart.

The misalignment is the rotation of the gyros less that of the accelerometers: how a
unit is mounted turns both alike and is no part of it.

So defined they are linear in the angles, and their errors are exact. As geometry they
are of first order: with angles up to d the rotation nearest to M (its polar
decomposition) differs from theta by d^2/2, and the angles between the rows of M from
the above by d^2: 32 and 66 arcsec at 1 deg. What an error of the angles makes of them
differs there by 2 % and 4 % of that error.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.schemes import answered, estimated
from budget.model.response import COLUMN, ROW, SIGN
from budget.model.source import ACCELEROMETER, GYRO
from budget.names import ANGLES, AXES, IMU, Name, every_output

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    from budget.arrays import Array
    from budget.inputs.records import Procedure


@cache
def parts_of(name: Name) -> Mapping[Name, float]:
    """Return the parameters that an output is a sum of, with their factors [1].

    A parameter is its own and only part.
    """
    if name.quantity == "rotation":
        i = AXES.index(name.axis)
        j, k = (i + 1) % 3, (i + 2) % 3
        return _angle(name.owner, j, k, 0.5) | _angle(name.owner, k, j, -0.5)
    if name.quantity == "non_orthogonality":
        i, j = map(AXES.index, name.axis)
        return _angle(name.owner, i, j, 1.0) | _angle(name.owner, j, i, 1.0)
    if name.owner == IMU:
        gyro, accelerometer = (parts_of(one).items() for one in rotations_of(name))
        # Angle by angle: what both triads have alike cancels exactly.
        return {
            part: sign * factor
            for both in zip(gyro, accelerometer, strict=True)
            for sign, (part, factor) in zip((1.0, -1.0), both, strict=True)
        }
    return {name: 1.0}


def rotations_of(misalignment: Name) -> tuple[Name, Name]:
    """Return the rotations of gyros and accelerometers that a misalignment is of."""
    axis = misalignment.axis
    return (
        Name("rotation", owner=GYRO, axis=axis),
        Name("rotation", owner=ACCELEROMETER, axis=axis),
    )


def _angle(owner: str, row: int, column: int, factor: float) -> dict[Name, float]:
    """Return an element of dT times a factor."""
    (k,) = np.flatnonzero((row == ROW) & (column == COLUMN))
    name = Name("mounting_angle", owner=owner, axis=ANGLES[k])
    return {name: factor * float(SIGN[k])}


def known_outputs(
    kinds: Sequence[str], procedure: Procedure, *, every: bool = False
) -> tuple[Name, ...]:
    """Return all that can be asked of triads, in order: all its parts are estimated.

    With `every` parameters that are held have errors, too.
    """
    known = answered if every else estimated
    found = {name for kind in kinds for name in known(kind, procedure)}
    return tuple(
        name
        for owner in (*kinds, IMU)
        for name in every_output(owner)
        if parts_of(name).keys() <= found
    )


def outputs_for(
    kinds: Sequence[str],
    procedure: Procedure,
    limits: Iterable[Name],
    asked: Collection[Name] | None = None,
) -> tuple[Name, ...] | None:
    """Return what is asked for or limited, of what is known, in order.

    None where that is the parameters and nothing else; without `asked` they all are.
    """
    known = known_outputs(kinds, procedure)
    limited = set(limits)
    if asked is None:
        found = [name for name in known if parts_of(name).keys() == {name}]
        if not {*known} & limited - {*found}:
            return None
        asked = found
    return tuple(name for name in known if name in limited or name in asked)


@dataclass(frozen=True, kw_only=True)
class Combination:
    """A linear map; each output is the sum of (place, factor) over its terms."""

    terms: tuple[tuple[tuple[int, float], ...], ...]

    def __call__(self, y: Array) -> Array:
        """Return the sums, shape (n_new, trials), for y (n, trials)."""
        # One by one, in their order: the same to the last bit on every machine.
        return np.stack([sum(f * y[k] for k, f in row) for row in self.terms])


def combination(names: Sequence[Name], outputs: Iterable[Name]) -> Combination:
    """Return the map from parameters of these names to outputs that they make up."""
    places = {name: place for place, name in enumerate(names)}
    return Combination(
        terms=tuple(
            tuple((places[part], factor) for part, factor in parts_of(name).items())
            for name in outputs
        )
    )
