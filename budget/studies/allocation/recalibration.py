"""Age of a calibration at which a limit is reached: when to calibrate again."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from budget.inputs.station import with_age
from budget.model.sources.later import AGEING
from budget.studies.allocation.longer_tests import (
    AS_THEY_ARE,
    largest_utilisation,
)
from budget.studies.allocation.records import Recalibration
from budget.units import DAY, YEAR, parse_quantity

if TYPE_CHECKING:
    from collections.abc import Callable

    from budget.arrays import Array
    from budget.inputs.records import Procedure
    from budget.methods.scaling import ScaledLaw
    from budget.studies.allocation.cases import SensorCase

SOONEST, LATEST = DAY, 30.0 * YEAR  # [s]
ALLOCATED = "as allocated"


def find_recalibrations(case: SensorCase) -> tuple[Recalibration, ...]:
    """Find how old a calibration may be, with the lines as they are and as allocated.

    The age A at which the largest end of an interval, |m(A)| + k u(A), is at its limit,
    by the law of propagation. () where errors are not counted from a later turn-on, or
    nothing that is given ages.
    """
    ages = [
        name
        for name in AGEING.values()
        for sensor in case.question.sensors
        if sensor.line(name)
    ]
    if case.question.reference != "next_turn_on" or not ages:
        return ()
    states = [(AS_THEY_ARE, case.task.now)]
    if case.s is not None:
        states.append((ALLOCATED, case.s))
    # Both ask for the ends.
    laws = cache(lambda age, known: case.law_of(known, _aged(case, age)))
    return tuple(_find(case, laws, s, goal) for goal, s in states)


def _aged(case: SensorCase, age: float) -> Procedure:
    """Return the procedure of a calibration that is as old [s]."""
    return with_age(case.question.procedure, parse_quantity(f"{age!r} s", "s"))


def _find(
    case: SensorCase,
    laws: Callable[[float, tuple[float, ...]], ScaledLaw],
    s: Array,
    goal: str,
) -> Recalibration:
    """Look between a day and 30 years for the age at which the limits are reached."""

    def used(age: float) -> float:
        return largest_utilisation(case.task, laws(age, case.known(s)), s)

    age, utilisation = None, used(SOONEST)
    if utilisation <= 1.0:
        utilisation = used(LATEST)
        if utilisation > 1.0:
            from scipy.optimize import brentq

            age = float(brentq(lambda age: used(age) - 1.0, SOONEST, LATEST))
            utilisation = 1.0
    oldest = case.question.under(_aged(case, LATEST)).sensors
    return Recalibration(
        sensor=case.owner,
        goal=goal,
        age=age,
        utilisation=utilisation,
        not_given=tuple(name for one in oldest for name in one.expected_missing),
    )
