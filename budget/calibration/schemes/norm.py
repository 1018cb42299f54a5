"""Calibration scheme of accelerometers at unknown attitudes, by the norm of gravity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.norm import NormScheme, sensitivity, statistics_weights
from budget.model.scheme import not_told_apart
from budget.names import parameters_of

if TYPE_CHECKING:
    from budget.inputs.records import Procedure
    from budget.model.scheme import Held
    from budget.model.windows import Schedule


def scheme_by_norm(
    owner: str, schedule: Schedule, procedure: Procedure, held: Held
) -> NormScheme:
    """Return windows and weights of a triad of accelerometers.

    Parameters
    ----------
    owner : str
        'accelerometer'.
    schedule : Schedule
        Dwells; their attitudes are nominal and need be known only roughly.
    procedure : Procedure
        The place.
    held : Held
        What is not estimated; with less than three angles it is refused.

    Raises
    ------
    CallError
        The dwells cannot tell some parameters apart: which.
    """
    force = schedule.to_body @ procedure.place.force
    g = procedure.gravity
    names = [parameters_of(owner)[k] for k in held.estimated]
    size = np.array([g if name.quantity == "bias" else 1.0 for name in names])
    J = sensitivity(force, held) * size / (2.0 * g**2)
    if mixed := not_told_apart(J, [name.without_owner for name in names]):
        raise CallError(
            f"{procedure.name}, {owner}: the norm of gravity in these dwells cannot "
            f"tell apart: {mixed}. Parameters are {len(names)}, dwells {len(force)}; "
            "how the triad is turned no norm shows (three angles are held), nor faces "
            "alone an angle: add attitudes between the faces, or hold a parameter "
            "(estimate: names the others)"
        )
    W = np.linalg.pinv(J) * size[:, None] / (2.0 * g**2)
    return NormScheme(
        owner=owner,
        schedule=schedule,
        place=procedure.place,
        timing=procedure.timing,
        weights=statistics_weights(W, force),
        held=held,
    )
