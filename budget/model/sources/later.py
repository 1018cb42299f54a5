"""Sources that differ at a later turn-on: residuals, vibration, age.

A maker prints how far a parameter has gone after a time, its horizon H: u(H). At
another age A of the calibration it has gone u(H) A/H if it drifts, u(H) sqrt(A/H) if it
walks at random. Where nobody says which, the larger of both is taken; between two
horizons that are printed, the power law through both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.model.source import Coefficient, Given, TurnOnChange

if TYPE_CHECKING:
    from collections.abc import Mapping

    from budget.arrays import Array
    from budget.model.course import Course
    from budget.model.source import Gains

MISSION_TEMPERATURE = "temperature.mission"
TEST_VIBRATION, MISSION_VIBRATION = "vibration.test", "vibration.mission"
AGE = "age"
RECTIFICATION = "vibration_rectification"
DRIFT, RANDOM_WALK = "drift", "random_walk"
AGEING = {"bias": "ageing", "scale_factor": "scale_factor_ageing"}  # by the parameter


@dataclass(frozen=True)
class OverTemperature(TurnOnChange):
    """What is left of a parameter's temperature dependence: 0 at the test's.

    Attributes
    ----------
    target : str
        'bias' or 'scale_factor'.
    """

    needs = "sources.other_temperature"

    target: str

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return nothing in the test, all of it later; of a stated 0 nothing either."""
        later = known.get(MISSION_TEMPERATURE)
        is_felt = later is None or later.u.any() or later.course is not None
        felt = 1.0 if is_felt else 0.0
        return {self.target: (np.zeros((3, 3)), felt * np.eye(3))}


@dataclass(frozen=True)
class VibrationRectification(TurnOnChange):
    """db = VRE a^2, a the rms of the vibration: during the test, and later."""

    target = "bias"
    needs = "sources.vibration"

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return the squares of both vibrations."""
        test, mission = (
            known[name].u[0] ** 2 if name in known else 0.0
            for name in (TEST_VIBRATION, MISSION_VIBRATION)
        )
        return {"bias": (test * np.eye(3), mission * np.eye(3))}

    def felt(self, course: Course, t: Array) -> Array:
        """Return the square of a vibration that is known on the way."""
        return course.at(t) ** 2


@dataclass(frozen=True)
class Vibration(Coefficient):
    """Rms of a vibration, which is known."""

    needs = "sources.rectification"
    partners = (RECTIFICATION,)


@dataclass(frozen=True)
class Ageing(TurnOnChange):
    """What a parameter has gone since its calibration, by the age of that.

    Attributes
    ----------
    target : str
        'bias' or 'scale_factor'.
    """

    needs = "sources.age"

    target: str

    def gains(self, known: Mapping[str, Given]) -> Mapping[str, Gains]:
        """Return nothing in the test, what the age makes of it later."""
        own, age = known.get(AGEING[self.target]), age_in(known)
        if own is None:
            return {}
        return {self.target: (np.zeros((3, 3)), growth(own, age) * np.eye(3))}


@dataclass(frozen=True)
class Age(Coefficient):
    """Time from the calibration to the later turn-on, which is known."""

    needs = "sources.ageing"
    partners = tuple(AGEING.values())


def age_in(known: Mapping[str, Given]) -> float:
    """Return the age of the calibration at the later turn-on, 0 if not given [s]."""
    return float(known[AGE].u[0]) if AGE in known else 0.0


def growth(given: Given, age: float) -> float:
    """Return what a parameter has gone at an age [s] over that at its horizon [1].

    Raises
    ------
    CallError
        The line has no horizon.
    """
    if not given.horizons:
        raise CallError(f"{given.name}: without a horizon nobody knows its ageing")
    if age == 0.0:
        return 0.0
    times, sizes = np.array(given.horizons).T
    if times[0] < age < times[-1]:
        return float(np.exp(np.interp(np.log(age), np.log(times), np.log(sizes))))
    end = 0 if age <= times[0] else -1
    ratio = float(age / times[end])
    laws = {DRIFT: ratio, RANDOM_WALK: float(np.sqrt(ratio))}
    return float(sizes[end]) * laws.get(given.form, max(laws.values()))
